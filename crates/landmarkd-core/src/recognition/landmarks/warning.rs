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
    TooFewPoints { found: usize },
    /// Nothing was decided, and fewer than half of the points that were asked voted for the best label.
    VotesOnBackground { voted: usize, used: usize },
    /// Another label has nearly the same evidence.
    CloseSecond,
    /// The database was trained with colour and the frame has none.
    GrayFrame,
}

impl Warning {
    /// A short name for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::NoInterestPoints => "no_interest_points",
            Warning::TooFewPoints { .. } => "too_few_points",
            Warning::VotesOnBackground { .. } => "votes_on_background",
            Warning::CloseSecond => "close_second",
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
            Warning::TooFewPoints { found } => {
                write!(
                    f,
                    "only {found} interest points were found; fewer than {FEW_POINTS} make an unsure vote"
                )
            }
            Warning::VotesOnBackground { voted, used } => {
                write!(
                    f,
                    "only {voted} of {used} points speak for the best label: most lie on the background, or on \
                     something that the database doesn't know"
                )
            }
            Warning::CloseSecond => {
                write!(f, "another label has nearly the same evidence: see the votes")
            }
            Warning::GrayFrame => {
                write!(f, "the frame is gray, but the database was trained with colour: signatures differ")
            }
        }
    }
}
