//! The answer of a database of kind `landmarks`: votes with the placements of their exemplars, and the points that gave
//! them.

use serde::Serialize;
use utoipa::ToSchema;

use super::localisation::{LandmarkPoseBody, PlacePoseBody, Surveyed};
use super::{Answer, DecisionBody, Drawn, EvidenceBody, ReasonBody, StagesBody, Wanted};
use crate::http::problem::{Code, Problem};
use crate::http::stages::StageClock;
use landmarkd_core::imaging::Frame;
use landmarkd_core::localisation::PlanarPoses;
use landmarkd_core::recognition::landmarks::{
    AContrario, AskedFrame, Instance, KeptExemplar, Landmarks, PointVote, Recognition, Stage,
    VerifiedPlacement, annotate,
};

/// What speaks for the answer of a landmark database.
#[derive(Debug, Serialize, ToSchema)]
pub struct LandmarkEvidence {
    /// The evidence, best first.
    pub votes: Vec<VoteBody>,
    /// Everything known that is in the frame for sure enough, surest first: several things, or one several times. Empty
    /// where answers have no confidence, or no placement.
    pub instances: Vec<InstanceBody>,
    /// The evidence for the best vote; null where its exemplar isn't laid on the frame, and with signatures of intensity.
    pub evidence: Option<AContrarioBody>,
    /// Other labels that chance doesn't explain: they look alike or overlap, or are in the frame too. Best first.
    #[schema(required = false)]
    pub also: Vec<AlsoBody>,
    /// The best guess where the decision is null.
    pub guess: Option<GuessBody>,
    /// Where the camera is, where exemplars of the version have poses; null where those that agree don't tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub pose: Option<Option<PlacePoseBody>>,
    /// Why the decision is null, the likeliest first.
    #[schema(required = false)]
    pub reasons: Vec<ReasonBody>,
    /// Interest points that were asked: no more than it takes.
    pub points_used: u64,
    /// Interest points in the frame.
    pub points_found: u64,
    /// With `explain`: every point's vote, most salient first. For each label the weights sum to its W.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<PointBody>>,
}

/// How unlikely chance explains an agreement.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct AContrarioBody {
    /// log₁₀ of how many such agreements chance makes in a frame of something else: -2 is one in a hundred frames.
    pub log10_false_alarms: f64,
    /// Windows of the frame that agree, those of one spot once.
    pub agreeing: u64,
    /// Windows of the frame that were matched with the exemplar.
    pub asked: u64,
}

/// Another label that chance doesn't explain.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlsoBody {
    pub label: String,
    pub evidence: AContrarioBody,
}

/// What the frame most likely shows, though not for sure enough.
#[derive(Debug, Serialize, ToSchema)]
pub struct GuessBody {
    pub label: String,
    /// Id of the exemplar that agrees most; null where none is laid on the frame.
    pub exemplar: Option<String>,
    pub evidence: Option<AContrarioBody>,
}

impl From<&AContrario> for AContrarioBody {
    fn from(evidence: &AContrario) -> Self {
        let AContrario { log10_false_alarms, agreeing, asked } = *evidence;
        Self { log10_false_alarms, agreeing: agreeing as u64, asked: asked as u64 }
    }
}

/// The votes for a label.
#[derive(Debug, Serialize, ToSchema)]
pub struct VoteBody {
    pub label: String,
    /// W of the label.
    pub weight: f64,
    /// Its part of all W.
    pub share: f64,
    /// Votes that counted for it: of interest points, or with `placement` of their sub-windows.
    pub points: u64,
    /// Where its exemplar lies; null where matches don't say so, as with the paper's method, and with intensities and upright viewpoints.
    pub placement: Option<PlacementBody>,
    /// The evidence for it; null as the placement is, and with signatures of intensity.
    pub evidence: Option<AContrarioBody>,
}

/// An exemplar laid on the frame.
#[derive(Debug, Serialize, ToSchema)]
pub struct PlacementBody {
    /// Where the centre of the exemplar's picture is seen.
    pub x_px: f32,
    pub y_px: f32,
    /// How it is turned, in (-180, 180]; positive from x towards y: clockwise as seen on screen.
    pub rotation_deg: f32,
    /// Pixels of the frame for each of the exemplar.
    pub scale: f32,
    /// Sub-windows of the frame that agree on it.
    pub inliers: u64,
    /// How well the exemplar's gradients are found again in the frame, -1 to 1.
    pub agreement: f32,
    /// The corners of the exemplar's picture on the frame, from its top left on clockwise.
    pub outline_px: [[f32; 2]; 4],
    /// Id of the exemplar.
    pub exemplar: String,
    /// From pixels of the exemplar's picture to pixels of the frame, row by row, in homogeneous coordinates; null with
    /// signatures of intensity. `x_px`, `y_px`, `rotation_deg` and `scale` are those of the picture's middle.
    pub homography: Option<[[f64; 3]; 3]>,
    /// Where the exemplar's picture is before the camera, if its `size_mm` and the frame's camera are known.
    #[serde(rename = "T_camera_landmark", skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub camera_landmark: Option<LandmarkPoseBody>,
    /// The other pose that explains what is seen nearly as well, if there is one: tilted the other way.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub alternative: Option<LandmarkPoseBody>,
    /// With `T_camera_landmark`: whether the alternative is about as likely.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub ambiguous: Option<bool>,
}

/// Something known that is in the frame.
#[derive(Debug, Serialize, ToSchema)]
pub struct InstanceBody {
    pub label: String,
    /// Probability of being right.
    pub confidence: f64,
    pub placement: PlacementBody,
}

impl PlacementBody {
    fn of(verified: &VerifiedPlacement, model: &Landmarks) -> Self {
        let exemplar = &model.exemplars()[verified.exemplar];
        let placement = &verified.placement;
        // -π itself, and what rounds to -180, is the same turn as 180
        let degrees = placement.rotation_rad.to_degrees();
        Self {
            x_px: placement.x_px,
            y_px: placement.y_px,
            rotation_deg: if degrees <= -180.0 { 180.0 } else { degrees },
            scale: placement.scale,
            inliers: verified.inliers as u64,
            agreement: verified.agreement,
            outline_px: verified.outline_px(exemplar.width_px, exemplar.height_px),
            exemplar: exemplar.id.clone(),
            homography: verified.homography.map(|homography| homography.0),
            camera_landmark: None,
            alternative: None,
            ambiguous: None,
        }
    }

    /// The same with its pose on the plane.
    fn on_plane(self, found: Option<PlanarPoses>) -> Self {
        let Some(found) = found else { return self };
        Self {
            camera_landmark: Some(LandmarkPoseBody::from(&found.pose)),
            alternative: found.alternative.as_ref().map(LandmarkPoseBody::from),
            ambiguous: Some(found.ambiguous),
            ..self
        }
    }
}

/// The vote of an interest point.
#[derive(Debug, Serialize, ToSchema)]
pub struct PointBody {
    pub x_px: f32,
    pub y_px: f32,
    pub salience: f32,
    /// Id of the exemplar that it votes for, or whose eigenpoint is nearest.
    pub exemplar: String,
    /// Its label; null where the exemplar is negative.
    pub label: Option<String>,
    /// Distance D in the eigenspace.
    pub distance: f64,
    /// Its part of W: 0 where it counts for nothing; with the paper's method 1/(D+ε).
    pub weight: f64,
}

/// The parts of a recognition by landmarks, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct LandmarkStages {
    /// Interest points.
    pub attention: f64,
    /// Sub-windows and their spectra.
    pub signature: f64,
    /// Choosing exemplars and reading them, where the version's windows are not in memory; else 0.
    #[schema(required = false)]
    pub fetch: f64,
    /// Projection and nearest eigenpoints.
    pub search: f64,
    pub vote: f64,
    /// Laying exemplars on the frame.
    pub verification: f64,
    /// Where the frame was taken, where exemplars have poses; else 0.
    #[schema(required = false)]
    pub locate: f64,
}

const STAGES: [&str; 5] = ["attention", "signature", "search", "vote", "verification"];
/// Where the version's windows are not in memory.
pub(super) const FETCH: &str = "fetch";
/// Where exemplars have poses.
const LOCATE: &str = "locate";

fn word(stage: Stage) -> &'static str {
    match stage {
        Stage::Attention => "attention",
        Stage::Signature => "signature",
        Stage::Search => "search",
        Stage::Vote => "vote",
        Stage::Verification => "verification",
    }
}

/// Exemplars that a frame is recognised among where the version's windows are not in memory.
const CHOSEN: usize = 200;

/// A frame of which exemplars are chosen.
pub(super) struct Chosen {
    asked: AskedFrame<'static>,
    /// Their indices, ascending.
    pub exemplars: Vec<usize>,
}

/// The exemplars that are likest the frame.
///
/// # Errors
/// The model has signatures of intensities, whose windows are always in memory.
pub(super) fn choose(frame: &Frame, model: &Landmarks, clock: &mut StageClock) -> Result<Chosen, Problem> {
    clock.expect(&STAGES);
    let asked = model.ask(frame, |stage| clock.end(word(stage))).ok_or_else(not_kept)?;
    let exemplars = model.likest(&asked, CHOSEN);
    Ok(Chosen { asked, exemplars })
}

/// What can't be: a version whose windows are read, and that has none to read.
pub(super) fn not_kept() -> Problem {
    Problem::new(Code::Internal, "the version has no windows that can be read by themselves")
}

/// The answer to the frame by those exemplars that were chosen, read by now.
pub(super) fn answer_among(
    frame: &Frame,
    model: &Landmarks,
    chosen: &Chosen,
    kept: Vec<KeptExemplar<'_>>,
    surveyed: &Surveyed<'_>,
    wanted: Wanted,
    clock: &mut StageClock,
) -> Result<Answer, Problem> {
    let among = model.of_kept(kept).map_err(|_| not_kept())?;
    clock.end(FETCH);
    let recognition =
        among.recognise_asked(&chosen.asked, |stage| clock.end(word(stage))).map_err(|_| not_kept())?;
    let mut answer = located(frame, &among, recognition, Some(&chosen.asked), surveyed, wanted, clock);
    let mut weights = vec![0.0; model.exemplars().len()];
    for (&exemplar, weight) in chosen.exemplars.iter().zip(&answer.exemplar_weights) {
        weights[exemplar] = *weight;
    }
    answer.exemplar_weights = weights;
    Ok(answer)
}

/// The model's answer to the frame.
pub(super) fn answer(
    frame: &Frame,
    model: &Landmarks,
    surveyed: &Surveyed<'_>,
    wanted: Wanted,
    clock: &mut StageClock,
) -> Answer {
    clock.expect(&STAGES);
    // Points are asked in batches: a stage may come several times.
    let mut finished = |stage| clock.end(word(stage));
    let asked = if surveyed.has_places() { model.ask(frame, &mut finished) } else { None };
    let answered = asked.and_then(|asked| {
        let recognition = model.recognise_asked(&asked, &mut finished).ok()?;
        Some((recognition, asked))
    });
    let Some((recognition, asked)) = answered else {
        let recognition = model.recognise(frame, finished);
        return located(frame, model, recognition, None, surveyed, wanted, clock);
    };
    located(frame, model, recognition, Some(&asked), surveyed, wanted, clock)
}

/// The answer with what is in metres, as far as surveys tell.
fn located(
    frame: &Frame,
    model: &Landmarks,
    recognition: Recognition,
    asked: Option<&AskedFrame<'_>>,
    surveyed: &Surveyed<'_>,
    wanted: Wanted,
    clock: &mut StageClock,
) -> Answer {
    let pose = surveyed.has_poses().then(|| surveyed.pose(model, &recognition, asked, frame));
    let placement = |verified: &VerifiedPlacement| {
        PlacementBody::of(verified, model).on_plane(surveyed.plane(model, verified, frame))
    };
    let mut answer = rendered(frame, model, recognition, pose, &placement, wanted, clock);
    clock.end(LOCATE);
    if let StagesBody::Landmarks(stages) = &mut answer.stages {
        stages.locate = clock.ms(LOCATE);
    }
    answer
}

fn rendered(
    frame: &Frame,
    model: &Landmarks,
    recognition: Recognition,
    pose: Option<Option<PlacePoseBody>>,
    placement: &dyn Fn(&VerifiedPlacement) -> PlacementBody,
    wanted: Wanted,
    clock: &StageClock,
) -> Answer {
    let [attention, signature, search, vote, verification] = STAGES.map(|stage| clock.ms(stage));
    let fetch = clock.ms(FETCH);
    let point = |vote: &PointVote| {
        let exemplar = &model.exemplars()[vote.exemplar];
        PointBody {
            x_px: vote.x_px,
            y_px: vote.y_px,
            salience: vote.salience,
            exemplar: exemplar.id.clone(),
            label: (!exemplar.is_negative()).then(|| exemplar.label.clone()),
            distance: vote.distance,
            weight: vote.weight,
        }
    };
    let votes = recognition.votes.iter().take(wanted.top).map(|vote| VoteBody {
        label: vote.label.clone(),
        weight: vote.weight,
        share: vote.share,
        points: vote.points as u64,
        placement: vote.placement.as_ref().map(placement),
        evidence: vote.a_contrario.as_ref().map(AContrarioBody::from),
    });
    let instance = |instance: &Instance| InstanceBody {
        label: instance.label.clone(),
        confidence: instance.confidence,
        placement: placement(&instance.verified),
    };
    let decision = recognition.decision.as_ref();
    let best = recognition.votes.first().filter(|_| decision.is_none());
    let guess = best.map(|vote| GuessBody {
        label: vote.label.clone(),
        exemplar: vote.placement.as_ref().map(|placed| model.exemplars()[placed.exemplar].id.clone()),
        evidence: vote.a_contrario.as_ref().map(AContrarioBody::from),
    });
    let also = recognition.also.iter().map(|also| AlsoBody {
        label: also.label.clone(),
        evidence: AContrarioBody::from(&also.a_contrario),
    });
    let reasons = recognition.reasons.iter().map(|reason| ReasonBody {
        code: reason.code(),
        detail: reason.detail(),
        remedy: reason.remedy(),
    });
    Answer {
        decision: decision
            .map(|decision| DecisionBody { label: decision.label.clone(), confidence: decision.confidence }),
        warnings: recognition.warnings.iter().map(|warning| warning.code()).collect(),
        evidence: EvidenceBody::Landmarks(Box::new(LandmarkEvidence {
            votes: votes.collect(),
            instances: recognition.instances.iter().map(instance).collect(),
            evidence: recognition.a_contrario.as_ref().map(AContrarioBody::from),
            also: also.collect(),
            guess,
            pose,
            reasons: reasons.collect(),
            points_used: recognition.points_used as u64,
            points_found: recognition.points_found as u64,
            points: wanted.explain.then(|| recognition.points.iter().map(point).collect()),
        })),
        stages: StagesBody::Landmarks(LandmarkStages {
            attention,
            signature,
            fetch,
            search,
            vote,
            verification,
            locate: 0.0,
        }),
        drawn: wanted.drawing.map(|_| {
            let png = annotate(frame, &recognition, model).into_png();
            Drawn { png, distance_from_space: None }
        }),
        exemplar_weights: recognition.exemplar_weights,
    }
}
