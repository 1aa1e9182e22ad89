//! The answer of a database of kind `objects`: candidates, and the pose of the object.

use serde::Serialize;
use utoipa::ToSchema;

use super::{Answer, DecisionBody, Drawing, Drawn, EvidenceBody, ReasonBody, StagesBody, Wanted};
use crate::http::problem::Problem;
use crate::http::stages::StageClock;
use landmarkd_core::imaging::Frame;
use landmarkd_core::imaging::encode::png_gray8;
use landmarkd_core::recognition::objects::{
    Alignment, Candidate, Decision, Objects, Pose, Reason, Reconstruction, Stage, annotate,
};

/// What speaks for the answer of an object database.
#[derive(Debug, Serialize, ToSchema)]
pub struct ObjectEvidence {
    /// The objects that were looked at closely, the likeliest first.
    pub candidates: Vec<CandidateBody>,
    /// How the object is turned; null without a decision, when fewer than three exemplars differ in pose, or while the
    /// version isn't calibrated.
    pub pose: Option<PoseBody>,
    /// Where the object stands in the frame; null without a decision, and with `appearance: "intensity"`.
    #[schema(required = false)]
    pub alignment: Option<AlignmentBody>,
    /// Why the decision is null, the likeliest first; empty where there is one.
    #[schema(required = false)]
    pub reasons: Vec<ReasonBody>,
}

/// Where an object stands in a frame, relative to where its exemplars stand in theirs. Its appearance is read there.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlignmentBody {
    /// To the right, in pixels of the database's pictures; with `segment` of the crop.
    pub shift_x_px: f64,
    /// Down.
    pub shift_y_px: f64,
    /// Size in the frame over that in the exemplars.
    pub scale: f64,
    /// Turn in the frame's plane, clockwise as seen.
    pub turn_deg: f64,
}

/// An object that was looked at closely. Distances are between appearances of length one: 0 is equal, √2 nothing in
/// common.
#[derive(Debug, Serialize, ToSchema)]
pub struct CandidateBody {
    pub label: String,
    /// From the nearest point of the object's curve of views, in the eigenspace.
    pub distance_in_space: f64,
    /// What of the picture the eigenspace can't express.
    pub distance_from_space: f64,
    /// The largest total distance √(in² + from²) that is accepted as this object; null while it isn't calibrated, and where
    /// `explained` decides.
    pub threshold: Option<f64>,
    /// The part of the object that the frame shows, 0 to 1, once aligned; null with `appearance: "intensity"`.
    #[schema(required = false)]
    pub explained: Option<f64>,
    /// The least such part that is accepted; null while it isn't calibrated.
    #[schema(required = false)]
    pub least_explained: Option<f64>,
    /// By the covariance of the object's views; with `distance: "mahalanobis"` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mahalanobis: Option<f64>,
}

/// How an object is turned.
#[derive(Debug, Serialize, ToSchema)]
pub struct PoseBody {
    /// Turn about the vertical, in [0, 360).
    pub turn_deg: f64,
    /// Standard deviation to be expected.
    pub sigma_deg: f64,
    /// Whether the pose may be acted on.
    pub reliable: bool,
    /// Another pose that would look the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alternative_deg: Option<f64>,
}

/// The parts of a recognition by whole appearance, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct ObjectStages {
    /// The picture as a vector.
    pub appearance: f64,
    /// Projection into the universal eigenspace, and the eigenpoints near.
    pub universal: f64,
    /// The likeliest objects' own eigenspaces: which, and how turned.
    pub object: f64,
}

impl From<&Decision> for DecisionBody {
    fn from(decision: &Decision) -> Self {
        Self { label: decision.label.clone(), confidence: decision.confidence }
    }
}

impl From<&Reason> for ReasonBody {
    fn from(reason: &Reason) -> Self {
        Self { code: reason.code(), detail: reason.detail(), remedy: reason.remedy() }
    }
}

impl From<&Candidate> for CandidateBody {
    fn from(candidate: &Candidate) -> Self {
        Self {
            label: candidate.label.clone(),
            distance_in_space: candidate.distance_in_space,
            distance_from_space: candidate.distance_from_space,
            threshold: candidate.threshold,
            explained: candidate.explained,
            least_explained: candidate.least_explained,
            mahalanobis: candidate.mahalanobis,
        }
    }
}

impl From<Alignment> for AlignmentBody {
    fn from(alignment: Alignment) -> Self {
        let Alignment { shift_x_px, shift_y_px, scale, turn_deg } = alignment;
        Self { shift_x_px, shift_y_px, scale, turn_deg }
    }
}

impl From<Pose> for PoseBody {
    fn from(pose: Pose) -> Self {
        Self {
            turn_deg: pose.turn_deg,
            sigma_deg: pose.sigma_deg,
            reliable: pose.reliable,
            alternative_deg: pose.alternative_deg,
        }
    }
}

const STAGES: [&str; 3] = ["appearance", "universal", "object"];

fn word(stage: Stage) -> &'static str {
    match stage {
        Stage::Appearance => "appearance",
        Stage::Universal => "universal",
        Stage::Object => "object",
    }
}

/// The model's answer to the frame.
///
/// # Errors
/// The frame is not of the database's size, and `resize` is `never`.
pub(super) fn answer(
    frame: &Frame,
    model: &Objects,
    wanted: Wanted,
    clock: &mut StageClock,
) -> Result<Answer, Problem> {
    clock.expect(&STAGES);
    let recognition = model.recognise(frame, |stage| clock.end(word(stage)))?;
    let [appearance, universal, object] = STAGES.map(|stage| clock.ms(stage));
    let decision = recognition.decision.as_ref();
    Ok(Answer {
        decision: decision.map(DecisionBody::from),
        warnings: recognition.warnings.iter().map(|warning| warning.code()).collect(),
        evidence: EvidenceBody::Objects(ObjectEvidence {
            candidates: recognition.candidates.iter().take(wanted.top).map(CandidateBody::from).collect(),
            pose: decision.and_then(|decision| decision.pose).map(PoseBody::from),
            alignment: decision.and_then(|decision| decision.alignment).map(AlignmentBody::from),
            reasons: recognition.reasons.iter().map(ReasonBody::from).collect(),
        }),
        stages: StagesBody::Objects(ObjectStages { appearance, universal, object }),
        drawn: match wanted.drawing {
            None => None,
            Some(Drawing::Evidence) => {
                let png = annotate(frame, &recognition).into_png();
                Some(Drawn { png, distance_from_space: None })
            }
            Some(Drawing::Reconstruction) => {
                let reconstruction = Reconstruction::of(frame, model)?;
                let picture = reconstruction.side_by_side();
                let png = png_gray8(picture.width(), picture.height(), &picture.to_gray8());
                Some(Drawn { png, distance_from_space: Some(reconstruction.distance_from_space) })
            }
        },
        exemplar_weights: Vec::new(),
    })
}
