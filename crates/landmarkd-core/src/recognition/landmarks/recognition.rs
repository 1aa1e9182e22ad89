//! The answer of a recognition: decision, votes, verified placements and their evidence.

use super::confidence::Evidence;
use super::homography::Homography;
use super::placement::Placement;
use super::reason::Reason;
use super::warning::Warning;
use crate::vision::InterestPoint;

/// The stages of a recognition, in their order; all but the first may come several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A§4.2: interest points.
    Attention,
    /// A§4.3–4.4: sub-windows and signatures.
    Signature,
    /// A§4.1, A§4.5: projection, and the nearest eigenpoints.
    Search,
    /// A§4.5: votes.
    Vote,
    /// Edge templates compared with the frame.
    Verification,
}

/// The answer to a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// `None` if nothing reaches the database's threshold.
    pub decision: Option<Decision>,
    /// Interest points in the frame.
    pub points_found: usize,
    /// Interest points that were searched: no more than it takes, and none with a flat sub-window.
    pub points_used: usize,
    /// Labels with W > 0, best first.
    pub votes: Vec<LabelVote>,
    /// The verified placements that reach the threshold, most confident first.
    pub instances: Vec<Instance>,
    /// The vote of each point, most salient point first.
    pub points: Vec<PointVote>,
    /// W of every exemplar of the model, in the model's order.
    pub exemplar_weights: Vec<f64>,
    /// For the best vote.
    pub evidence: Evidence,
    /// For the best vote, with gradient signatures.
    pub a_contrario: Option<AContrario>,
    /// Other labels than the decision's that chance doesn't explain, best first: they look alike, overlap, or are in
    /// the frame too. Gradient signatures only.
    pub also: Vec<Also>,
    /// The exemplars whose agreement with the frame chance doesn't explain, of any label, most evident first. Gradient
    /// signatures only.
    pub agreeing: Vec<AgreeingExemplar>,
    /// Why nothing was decided, the likeliest first. Gradient signatures only.
    pub reasons: Vec<Reason>,
    /// Reasons to doubt the answer.
    pub warnings: Vec<Warning>,
}

/// How unlikely chance explains an agreement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AContrario {
    /// log₁₀ of how often chance would agree as well, in all exemplars of a frame of something else.
    pub log10_false_alarms: f64,
    /// Windows of the frame, a spot once, that agree.
    pub agreeing: usize,
    /// Windows of the frame that were matched with the exemplar.
    pub asked: usize,
}

/// An exemplar that agrees with a frame beyond chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgreeingExemplar {
    /// Index into the model's exemplars.
    pub exemplar: usize,
    /// How unlikely that is by chance.
    pub a_contrario: AContrario,
}

/// Another label that chance doesn't explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Also {
    /// The class or place.
    pub label: String,
    /// The evidence for it.
    pub a_contrario: AContrario,
}

/// The label that a frame is recognised as.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The class or place.
    pub label: String,
    /// Probability that it is right, 0..=1; `None` if the model isn't calibrated.
    pub confidence: Option<f64>,
}

/// The vote for one label.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelVote {
    /// The label that was voted for.
    pub label: String,
    /// W: exactly the sum of the weights of its points, in their order.
    pub weight: f64,
    /// Its part of the W of all labels, 0..=1.
    pub share: f64,
    /// Points that voted for it with a weight above 0.
    pub points: usize,
    /// Its best placement; `None` if the method verifies none.
    pub placement: Option<VerifiedPlacement>,
    /// The evidence for it, with gradient signatures and where there is a placement.
    pub a_contrario: Option<AContrario>,
}

/// A placement of an exemplar that was compared with the frame's gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedPlacement {
    /// Index into the model's exemplars.
    pub exemplar: usize,
    /// Position, rotation and scale in the frame; of a homography, those of the picture's middle.
    pub placement: Placement,
    /// From pixels of the exemplar's picture to pixels of the frame, with gradient signatures.
    pub homography: Option<Homography>,
    /// Windows of the frame that agree with the placement.
    pub inliers: usize,
    /// Agreement of the edge template with the frame's gradients, −1..=1.
    pub agreement: f32,
}

impl VerifiedPlacement {
    /// Where a point of an exemplar's picture of that size lies in the frame.
    pub fn apply(&self, [x, y]: [f32; 2], width_px: u32, height_px: u32) -> [f32; 2] {
        match &self.homography {
            Some(homography) => homography.apply([f64::from(x), f64::from(y)]).map(|at| at as f32),
            None => {
                self.placement.apply([x - (width_px as f32 - 1.0) / 2.0, y - (height_px as f32 - 1.0) / 2.0])
            }
        }
    }

    /// The corners of an exemplar's picture of that size in the frame, from its top left clockwise on the screen when it
    /// isn't turned.
    pub fn outline_px(&self, width_px: u32, height_px: u32) -> [[f32; 2]; 4] {
        let (right, bottom) = (width_px as f32 - 0.5, height_px as f32 - 0.5);
        [[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]]
            .map(|corner| self.apply(corner, width_px, height_px))
    }
}

/// A verified placement that reaches the threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Label of its exemplar.
    pub label: String,
    /// Probability that it is right, 0..=1.
    pub confidence: f64,
    /// Its exemplar and where that lies.
    pub verified: VerifiedPlacement,
}

/// The vote of one interest point for one exemplar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointVote {
    /// Column of the point.
    pub x_px: f32,
    /// Row of the point.
    pub y_px: f32,
    /// Salience of the point.
    pub salience: f32,
    /// Owner of the near eigenpoint: index into the model's exemplars.
    pub exemplar: usize,
    /// D.
    pub distance: f64,
    /// Its part of W; 0 where it doesn't count.
    pub weight: f64,
}

impl PointVote {
    pub(super) fn new(point: InterestPoint, exemplar: usize, distance: f32, weight: f64) -> PointVote {
        let InterestPoint { x_px, y_px, salience } = point;
        PointVote { x_px, y_px, salience, exemplar, distance: f64::from(distance), weight }
    }
}
