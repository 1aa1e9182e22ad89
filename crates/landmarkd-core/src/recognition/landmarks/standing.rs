//! What remains of the hypotheses where exemplars may lie when they are laid on the frame and looked at.

use super::consensus::Hypothesis;
use super::contour::{Directions, Template};
use super::model::Exemplar;
use super::placement::Placement;

/// Hypotheses that are laid on the frame as they are, and of these the ones whose place is looked for more exactly.
const LAID: usize = 96;
const REFINED: usize = 12;
/// Hypotheses weaker than this part of the best one are not looked at any longer.
const LEAST_PART: f64 = 0.05;
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
    /// Index of each agreeing match, and what it adds to the density.
    members: Vec<(u32, f32)>,
    density: f32,
}

impl Standing {
    fn new(hypothesis: Hypothesis, agreement: f32) -> Standing {
        let Hypothesis { exemplar, placement, density, members } = hypothesis;
        let weight = f64::from(agreement.max(0.0) * density.sqrt());
        Standing { exemplar, placement, agreement, weight, members, density }
    }

    /// Matches that agree.
    pub fn inliers(&self) -> usize {
        self.members.len()
    }

    /// Index of each agreeing match, and its part of W.
    pub fn given(&self) -> impl Iterator<Item = (u32, f64)> {
        let part = self.weight / f64::from(self.density);
        self.members.iter().map(move |&(index, density)| (index, part * f64::from(density)))
    }
}

/// The hypotheses laid on the frame where their matches say, the best first, none with W = 0: of one label one
/// exemplar in one place, so that many views of a thing don't crowd out another.
pub(super) fn laid(hypotheses: Vec<Hypothesis>, exemplars: &[Exemplar], frame: &Directions) -> Vec<Standing> {
    let look = |hypothesis: Hypothesis| {
        let template = Template::of(&exemplars[hypothesis.exemplar].contour);
        let agreement = template.agreement(&hypothesis.placement, frame);
        Standing::new(hypothesis, agreement)
    };
    let mut standings: Vec<Standing> = hypotheses.into_iter().take(LAID).map(look).collect();
    best_first(&mut standings);
    let least = standings.first().map_or(0.0, |best| LEAST_PART * best.weight);
    let label = |standing: &Standing| &exemplars[standing.exemplar].label;
    let mut apart: Vec<Standing> = Vec::new();
    for standing in standings.into_iter().filter(|standing| standing.weight >= least) {
        let taken = apart
            .iter()
            .any(|other| label(other) == label(&standing) && in_one_place(other, &standing, exemplars));
        if apart.len() < REFINED && !taken {
            apart.push(standing);
        }
    }
    apart
}

/// The same where they agree best with the frame, near where they were.
pub(super) fn exact(standings: Vec<Standing>, exemplars: &[Exemplar], frame: &Directions) -> Vec<Standing> {
    let look = |standing: Standing| {
        let template = Template::of(&exemplars[standing.exemplar].contour);
        let (placement, agreement) =
            refined(standing.placement, |placement| template.agreement(placement, frame));
        let Standing { exemplar, density, members, .. } = standing;
        Standing::new(Hypothesis { exemplar, placement, density, members }, agreement)
    };
    let mut standings: Vec<Standing> = standings.into_iter().map(look).collect();
    best_first(&mut standings);
    standings
}

fn best_first(standings: &mut Vec<Standing>) {
    standings.retain(|standing| standing.weight > 0.0);
    standings.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.exemplar.cmp(&b.exemplar)));
}

/// Whether two exemplars would lie in one place.
pub(super) fn in_one_place(a: &Standing, b: &Standing, exemplars: &[Exemplar]) -> bool {
    let side_px = |Standing { exemplar, placement, .. }: &Standing| {
        let Exemplar { width_px, height_px, .. } = &exemplars[*exemplar];
        placement.scale * (*width_px as f32 + *height_px as f32) / 2.0
    };
    let off_px = (a.placement.x_px - b.placement.x_px).hypot(a.placement.y_px - b.placement.y_px);
    off_px < SAME_PLACE * side_px(a).min(side_px(b))
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
