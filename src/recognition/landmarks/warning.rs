//! What a reader of an answer should know before trusting it.

use std::fmt;

/// Fewer points than this and a vote is luck: one background point outweighs the object.
pub const FEW_POINTS: usize = 8;

/// A doubt about one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// Nothing in the frame drew attention, or nothing was to be seen where it did.
    NoInterestPoints,
    /// Fewer than eight interest points voted, though more were asked for.
    FewInterestPoints { found: usize },
    /// The database was trained with colour and the frame has none.
    GrayFrame,
}

impl Warning {
    /// A short name for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::NoInterestPoints => "no_interest_points",
            Warning::FewInterestPoints { .. } => "few_interest_points",
            Warning::GrayFrame => "gray_frame",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NoInterestPoints => {
                write!(f, "no interest points were found: the frame is flat, dark or out of focus")
            }
            Warning::FewInterestPoints { found } => {
                write!(
                    f,
                    "only {found} interest points were found; fewer than {FEW_POINTS} make an unsure vote"
                )
            }
            Warning::GrayFrame => {
                write!(f, "the frame is gray, but the database was trained with colour: signatures differ")
            }
        }
    }
}
