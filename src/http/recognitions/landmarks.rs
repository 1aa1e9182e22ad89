//! What a database of kind `landmarks` answers: votes, and the points that gave them.

use std::time::Duration;

use serde::Serialize;
use utoipa::ToSchema;

use super::{Answer, DecisionBody, EvidenceBody, StagesBody, Wanted, ms};
use crate::imaging::Frame;
use crate::recognition::landmarks::{Landmarks, PointVote, Stage, annotate};

/// What speaks for the answer of a landmark database.
#[derive(Debug, Serialize, ToSchema)]
pub struct LandmarkEvidence {
    /// The evidence, best first.
    pub votes: Vec<VoteBody>,
    /// Interest points that voted.
    pub points_used: u64,
    /// Interest points in the frame.
    pub points_found: u64,
    /// With `explain`: every point's vote, most salient first. For each label the weights sum to its W.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<PointBody>>,
}

/// The votes for a label.
#[derive(Debug, Serialize, ToSchema)]
pub struct VoteBody {
    pub label: String,
    /// W of the label.
    pub weight: f64,
    /// Its part of all W.
    pub share: f64,
    /// Interest points whose vote counted for it.
    pub points: u64,
}

/// The vote of an interest point.
#[derive(Debug, Serialize, ToSchema)]
pub struct PointBody {
    pub x_px: f32,
    pub y_px: f32,
    pub salience: f32,
    /// Id of the exemplar with the nearest eigenpoint.
    pub exemplar: String,
    /// Its label.
    pub label: String,
    /// Distance D in the eigenspace.
    pub distance: f64,
    /// 1/(D+ε), or 0 when another exemplar of the label is the one that counts.
    pub weight: f64,
}

/// The parts of a recognition by landmarks, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct LandmarkStages {
    /// Interest points.
    pub attention: f64,
    /// Sub-windows and their spectra.
    pub signature: f64,
    /// Projection and nearest eigenpoints.
    pub search: f64,
    pub vote: f64,
}

fn place(stage: Stage) -> usize {
    match stage {
        Stage::Attention => 0,
        Stage::Signature => 1,
        Stage::Search => 2,
        Stage::Vote => 3,
    }
}

/// What the model says of the frame; `lap` gives the time since it was last asked.
pub(super) fn answer(
    frame: &Frame,
    model: &Landmarks,
    wanted: Wanted,
    mut lap: impl FnMut() -> Duration,
) -> Answer {
    let mut clocked = ["attention", "signature", "search", "vote"].map(|stage| (stage, Duration::ZERO));
    let recognition = model.recognise(frame, |stage| clocked[place(stage)].1 = lap());
    let [attention, signature, search, vote] = clocked.map(|(_, took)| ms(took));
    let point = |vote: &PointVote| {
        let exemplar = &model.exemplars()[vote.exemplar];
        PointBody {
            x_px: vote.x_px,
            y_px: vote.y_px,
            salience: vote.salience,
            exemplar: exemplar.id.clone(),
            label: exemplar.label.clone(),
            distance: vote.distance,
            weight: vote.weight,
        }
    };
    let votes = recognition.votes.iter().take(wanted.top).map(|vote| VoteBody {
        label: vote.label.clone(),
        weight: vote.weight,
        share: vote.share,
        points: vote.points as u64,
    });
    let best = recognition.votes.first();
    Answer {
        decision: best.map(|best| DecisionBody { label: best.label.clone(), confidence: None }),
        warnings: recognition.warnings.iter().map(|warning| warning.code()).collect(),
        evidence: EvidenceBody::Landmarks(LandmarkEvidence {
            votes: votes.collect(),
            points_used: recognition.points_used as u64,
            points_found: recognition.points_found as u64,
            points: wanted.explain.then(|| recognition.points.iter().map(point).collect()),
        }),
        stages: StagesBody::Landmarks(LandmarkStages { attention, signature, search, vote }),
        clocked: clocked.into(),
        annotated: wanted.annotated.then(|| annotate(frame, &recognition, model).into_png()),
    }
}
