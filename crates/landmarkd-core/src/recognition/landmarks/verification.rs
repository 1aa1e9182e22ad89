//! Verification of hypotheses: the edge template of each exemplar is compared with the frame at its placement.

use super::confidence::{Confidence, Evidence, log_margin};
use super::consensus::Hypothesis;
use super::edge_template::{EdgeTemplate, GradientDirections};
use super::model::Exemplar;
use super::placement::Placement;
use super::recognition::{Instance, VerifiedPlacement};

/// Hypotheses that are verified at most, and of these the ones that are kept and refined.
const MOST_VERIFIED: usize = 96;
const MOST_KEPT: usize = 12;
/// Hypotheses with less than this part of the best one's W are dropped.
const LEAST_PART: f64 = 0.05;
/// Step sizes of the refinement: pixels; of them so many radians, and such a part of the scale.
const STEPS: [f32; 2] = [1.0, 0.5];
const STEP_RAD: f32 = 0.02;
const STEP_SCALE: f32 = 0.02;
/// Steps of each size at most: the placement stays near the matches that support it.
const MOST_STEPS: usize = 12;
/// Two exemplars lie in one place if their centres are nearer than this part of the smaller one's mean side.
const SAME_PLACE: f32 = 0.25;

/// A hypothesis with its agreement on the frame.
#[derive(Clone, Debug)]
pub(super) struct ScoredHypothesis {
    pub hypothesis: Hypothesis,
    /// Agreement of the edge template with the frame, −1..=1.
    pub agreement: f32,
    /// W: the agreement, if positive, times the root of the density of matches.
    pub weight: f64,
}

impl ScoredHypothesis {
    fn new(hypothesis: Hypothesis, agreement: f32) -> ScoredHypothesis {
        let weight = f64::from(agreement.max(0.0) * hypothesis.density.sqrt());
        ScoredHypothesis { hypothesis, agreement, weight }
    }

    /// The result without its matches.
    pub fn verified(&self) -> VerifiedPlacement {
        let Hypothesis { exemplar, placement, ref inliers, .. } = self.hypothesis;
        VerifiedPlacement {
            exemplar,
            placement,
            homography: None,
            inliers: inliers.len(),
            agreement: self.agreement,
        }
    }

    /// Index of each inlier's match, and its part of W.
    pub fn shares(&self) -> impl Iterator<Item = (usize, f64)> {
        let part = self.weight / f64::from(self.hypothesis.density);
        self.hypothesis
            .inliers
            .iter()
            .map(move |inlier| (inlier.index as usize, part * f64::from(inlier.density)))
    }
}

/// Verified hypotheses, best first, all with W > 0; of one label one in one place, so that many views of a thing don't
/// crowd out another.
pub(super) struct Ranking<'a> {
    exemplars: &'a [Exemplar],
    pub hypotheses: Vec<ScoredHypothesis>,
}

impl<'a> Ranking<'a> {
    /// Verifies hypotheses where their matches place them.
    pub fn verify(
        hypotheses: Vec<Hypothesis>,
        exemplars: &'a [Exemplar],
        frame: &GradientDirections,
    ) -> Ranking<'a> {
        let scored = hypotheses.into_iter().take(MOST_VERIFIED).map(|hypothesis| {
            let template = EdgeTemplate::of(&exemplars[hypothesis.exemplar].edges);
            let agreement = template.agreement(&hypothesis.placement, frame);
            ScoredHypothesis::new(hypothesis, agreement)
        });
        let scored = sorted(scored);
        let least = scored.first().map_or(0.0, |best| LEAST_PART * best.weight);
        let mut kept = Ranking { exemplars, hypotheses: Vec::new() };
        for candidate in scored.into_iter().filter(|candidate| candidate.weight >= least) {
            let taken = kept.hypotheses.iter().any(|other| {
                kept.label(other) == kept.label(&candidate) && kept.in_one_place(other, &candidate)
            });
            if kept.hypotheses.len() < MOST_KEPT && !taken {
                kept.hypotheses.push(candidate);
            }
        }
        kept
    }

    /// Moves each placement to where its edge template agrees best with the frame, near where it was.
    pub fn refined(self, frame: &GradientDirections) -> Ranking<'a> {
        let scored = self.hypotheses.into_iter().map(|ScoredHypothesis { hypothesis, .. }| {
            let template = EdgeTemplate::of(&self.exemplars[hypothesis.exemplar].edges);
            let (placement, agreement) =
                refined(hypothesis.placement, |placement| template.agreement(placement, frame));
            ScoredHypothesis::new(Hypothesis { placement, ..hypothesis }, agreement)
        });
        Ranking { hypotheses: sorted(scored), ..self }
    }

    /// The label of a hypothesis' exemplar.
    pub fn label(&self, scored: &ScoredHypothesis) -> &'a str {
        &self.exemplars[scored.hypothesis.exemplar].label
    }

    /// The best hypothesis of each label, best first.
    pub fn best_of_labels(&self) -> Vec<&ScoredHypothesis> {
        let mut best: Vec<&ScoredHypothesis> = Vec::new();
        for scored in &self.hypotheses {
            if best.iter().all(|other| self.label(other) != self.label(scored)) {
                best.push(scored);
            }
        }
        best
    }

    /// The strongest hypothesis of another label in the same place: its W as a part of this one's.
    pub fn rival(&self, scored: &ScoredHypothesis) -> Option<f64> {
        let others = self
            .hypotheses
            .iter()
            .filter(|other| self.label(other) != self.label(scored) && self.in_one_place(scored, other));
        others.map(|other| other.weight / scored.weight).reduce(f64::max)
    }

    /// The evidence for a hypothesis.
    pub fn evidence(&self, scored: &ScoredHypothesis) -> Evidence {
        Evidence::Placement {
            log_weight: (1.0 + 10.0 * scored.weight).ln(),
            agreement: f64::from(scored.agreement.max(0.0)),
            log_margin: log_margin(self.rival(scored)),
            log_inliers: (scored.hypothesis.inliers.len() as f64).ln(),
        }
    }

    /// The hypotheses that reach the threshold and are each the best in their place, most confident first.
    pub fn instances(&self, confidence: Option<&Confidence>) -> Vec<Instance> {
        let Some(confidence) = confidence else { return Vec::new() };
        let mut best: Vec<&ScoredHypothesis> = Vec::new();
        for scored in &self.hypotheses {
            if !best.iter().any(|other| self.in_one_place(other, scored)) {
                best.push(scored);
            }
        }
        let instance = |scored: &ScoredHypothesis| Instance {
            label: self.label(scored).to_owned(),
            confidence: confidence.of(&self.evidence(scored)),
            verified: scored.verified(),
        };
        let mut instances: Vec<Instance> = best.into_iter().map(instance).collect();
        instances.retain(|instance| instance.confidence >= confidence.threshold);
        instances.sort_by(|a, b| b.confidence.total_cmp(&a.confidence)); // stable
        instances
    }

    /// Whether two exemplars would lie in one place.
    fn in_one_place(&self, a: &ScoredHypothesis, b: &ScoredHypothesis) -> bool {
        let side_px = |of: &Hypothesis| {
            let Exemplar { width_px, height_px, .. } = self.exemplars[of.exemplar];
            of.placement.scale * (width_px as f32 + height_px as f32) / 2.0
        };
        let (a, b) = (&a.hypothesis, &b.hypothesis);
        let off_px = (a.placement.x_px - b.placement.x_px).hypot(a.placement.y_px - b.placement.y_px);
        off_px < SAME_PLACE * side_px(a).min(side_px(b))
    }
}

/// Those with W > 0, best first; of equal ones the earlier exemplar first.
fn sorted(scored: impl Iterator<Item = ScoredHypothesis>) -> Vec<ScoredHypothesis> {
    let mut scored: Vec<ScoredHypothesis> = scored.filter(|scored| scored.weight > 0.0).collect();
    scored.sort_by(|a, b| {
        b.weight.total_cmp(&a.weight).then(a.hypothesis.exemplar.cmp(&b.hypothesis.exemplar))
    });
    scored
}

/// The placement near `start` with the highest value, by hill climbing along each of its four numbers.
fn refined(start: Placement, value: impl Fn(&Placement) -> f32) -> (Placement, f32) {
    let mut best = (start, value(&start));
    for step in STEPS {
        for _ in 0..MOST_STEPS {
            let Placement { x_px, y_px, rotation_rad, scale } = best.0;
            let before = best.1;
            for sign in [-step, step] {
                let neighbours = [
                    Placement { x_px: x_px + sign, ..best.0 },
                    Placement { y_px: y_px + sign, ..best.0 },
                    Placement { rotation_rad: rotation_rad + sign * STEP_RAD, ..best.0 },
                    Placement { scale: scale * (1.0 + sign * STEP_SCALE), ..best.0 },
                ];
                for neighbour in neighbours {
                    let found = value(&neighbour);
                    if found > best.1 {
                        best = (neighbour, found);
                    }
                }
            }
            if best.1 <= before {
                break;
            }
        }
    }
    let turn = best.0.rotation_rad.rem_euclid(std::f32::consts::TAU);
    let rotation_rad = if turn > std::f32::consts::PI { turn - std::f32::consts::TAU } else { turn };
    (Placement { rotation_rad, ..best.0 }, best.1)
}
