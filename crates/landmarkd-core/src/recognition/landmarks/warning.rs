//! Reasons to doubt an answer.

/// With fewer points a vote is chance: one background point outweighs the object.
pub const FEW_POINTS: usize = 8;

/// A reason to doubt an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// The frame has no interest points, or all of their sub-windows are flat.
    NoInterestPoints,
    /// Fewer than eight interest points voted, though the options allow more.
    TooFewPoints {
        /// Points that voted.
        found: usize,
    },
    /// Nothing was decided, and fewer than half of the points voted for the best label.
    VotesOnBackground {
        /// Points that voted for the best label.
        voted: usize,
        /// Points that were searched.
        used: usize,
    },
    /// Another label has nearly the same W.
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
