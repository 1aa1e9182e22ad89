//! What a frame was taken for, how sure that is, and why.

use super::placement::Placement;
use super::warning::Warning;

/// What a frame was taken for, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// What the frame shows; `None` if nothing is known in it for sure enough.
    pub decision: Option<Decision>,
    /// Interest points in the frame.
    pub points_found: usize,
    /// Those that were asked: no more than it takes, and none with nothing to see about it.
    pub points_used: usize,
    /// Labels with W > 0, best first.
    pub votes: Vec<LabelVote>,
    /// Every exemplar that is placed in the frame for sure enough, surest first.
    pub instances: Vec<Instance>,
    /// What each point said, strongest point first.
    pub points: Vec<PointVote>,
    /// W of every exemplar of the model, in the model's order.
    pub exemplar_weights: Vec<f64>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// What a frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Its name.
    pub label: String,
    /// The chance that it is right, 0..=1; `None` if the model isn't calibrated.
    pub confidence: Option<f64>,
}

/// The vote for one label.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelVote {
    /// What was voted for.
    pub label: String,
    /// W: the weights of its points, added up in their order, exactly.
    pub weight: f64,
    /// Its part of the W of all labels, 0..=1.
    pub share: f64,
    /// How many points voted for it with a weight above 0.
    pub points: usize,
    /// Where the votes say it lies.
    pub placement: Option<Placed>,
}

/// An exemplar laid on the frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Index into the model's exemplars.
    pub exemplar: usize,
    /// Where.
    pub placement: Placement,
    /// Windows of the frame that agree.
    pub inliers: usize,
    /// How well the exemplar's gradients are found again in the frame, −1..=1.
    pub agreement: f32,
}

/// An exemplar that is in the frame for sure enough.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// What it shows.
    pub label: String,
    /// The chance that it is right, 0..=1.
    pub confidence: f64,
    /// Where it lies.
    pub placed: Placed,
}

/// The vote of one interest point for one exemplar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointVote {
    /// Where it is.
    pub x_px: f32,
    /// Where it is.
    pub y_px: f32,
    /// How strongly it drew attention.
    pub salience: f32,
    /// Whose eigenpoint is near: index into the model's exemplars.
    pub exemplar: usize,
    /// D.
    pub distance: f64,
    /// Its part of W; 0 where it doesn't count.
    pub weight: f64,
}
