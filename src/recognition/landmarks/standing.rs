//! What remains of the hypotheses where exemplars may lie when they are laid on the frame and looked at.

use super::consensus::Hypothesis;
use super::contour::{Directions, Template};
use super::model::Exemplar;
use super::placement::Placement;

/// Hypotheses that are laid on the frame as they are, and of these the ones whose place is looked for more exactly.
const LAID: usize = 96;
const REFINED: usize = 12;
/// Hypotheses weaker than this part of the best one are not looked at any longer.
const LEAST_PART: f32 = 0.05;
/// Steps of the search for the exact place: so many pixels, radians, and parts of the scale.
const STEPS: [f32; 2] = [1.0, 0.5];
const STEP_RAD: f32 = 0.02;
/// So many steps of each size at most: the place stays near the matches that speak for it.
const MOST_STEPS: usize = 12;
const STEP_SCALE: f32 = 0.02;
/// Two exemplars lie in one place if their centres are nearer than this part of the smaller one's mean side.
const SAME_PLACE: f32 = 0.25;

/// A hypothesis that was looked at.
#[derive(Clone, Debug)]
pub(super) struct Standing {
    pub exemplar: usize,
    pub placement: Placement,
    pub agreement: f32,
    /// W: the agreement on the picture times the root of the density of matches.
    pub weight: f64,
    /// Index of each agreeing match, and its part of W.
    pub members: Vec<(u32, f64)>,
}

/// The hypotheses with W > 0, the best first.
pub(super) fn standings(
    hypotheses: Vec<Hypothesis>,
    exemplars: &[Exemplar],
    frame: &Directions,
) -> Vec<Standing> {
    let weight = |density: f32, agreement: f32| agreement.max(0.0) * density.sqrt();
    let mut laid: Vec<(Hypothesis, f32)> = hypotheses
        .into_iter()
        .take(LAID)
        .map(|hypothesis| {
            let template = Template::of(&exemplars[hypothesis.exemplar].contour);
            let agreement = template.agreement(&hypothesis.placement, frame);
            (hypothesis, agreement)
        })
        .collect();
    laid.sort_by(|(a, at_a), (b, at_b)| weight(b.density, *at_b).total_cmp(&weight(a.density, *at_a)));
    // of one label one exemplar in one place: many views of a thing don't crowd out another
    let mut apart: Vec<(Hypothesis, f32)> = Vec::new();
    for (hypothesis, agreement) in laid {
        let taken = |(other, _): &(Hypothesis, f32)| {
            exemplars[other.exemplar].label == exemplars[hypothesis.exemplar].label
                && near(
                    other.exemplar,
                    &other.placement,
                    hypothesis.exemplar,
                    &hypothesis.placement,
                    exemplars,
                )
        };
        let weak = apart.first().is_some_and(|(best, at_best)| {
            weight(hypothesis.density, agreement) < LEAST_PART * weight(best.density, *at_best)
        });
        if apart.len() < REFINED && !weak && !apart.iter().any(taken) {
            apart.push((hypothesis, agreement));
        }
    }
    let mut standings: Vec<Standing> = apart
        .into_iter()
        .map(|(hypothesis, _)| {
            let template = Template::of(&exemplars[hypothesis.exemplar].contour);
            let value = |placement: &Placement| template.agreement(placement, frame);
            let (placement, agreement) = refined(hypothesis.placement, value);
            // W is what its points give: their sum, not the other way round
            let part = f64::from(weight(hypothesis.density, agreement) / hypothesis.density);
            let members: Vec<(u32, f64)> = hypothesis
                .members
                .iter()
                .map(|&(index, density)| (index, part * f64::from(density)))
                .collect();
            let weight = members.iter().map(|(_, weight)| weight).sum();
            Standing { exemplar: hypothesis.exemplar, placement, agreement, weight, members }
        })
        .filter(|standing| standing.weight > 0.0)
        .collect();
    standings.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.exemplar.cmp(&b.exemplar)));
    standings
}

/// Whether two exemplars would lie in one place.
pub(super) fn in_one_place(a: &Standing, b: &Standing, exemplars: &[Exemplar]) -> bool {
    near(a.exemplar, &a.placement, b.exemplar, &b.placement, exemplars)
}

fn near(a: usize, at_a: &Placement, b: usize, at_b: &Placement, exemplars: &[Exemplar]) -> bool {
    let side_px = |exemplar: usize, at: &Placement| {
        let Exemplar { width_px, height_px, .. } = &exemplars[exemplar];
        at.scale * (*width_px as f32 + *height_px as f32) / 2.0
    };
    let off_px = (at_a.x_px - at_b.x_px).hypot(at_a.y_px - at_b.y_px);
    off_px < SAME_PLACE * side_px(a, at_a).min(side_px(b, at_b))
}

/// The placement near `start` with the highest value, by steps along each of its four numbers.
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
