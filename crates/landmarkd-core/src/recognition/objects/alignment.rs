//! The alignment of a picture with an object: where in the picture the object stands, how large and how turned, before its
//! distance is judged; and the part of the object that the picture explains.
//!
//! Gauss–Newton on the difference between the appearance read from the picture at a [`Similarity`] and the one rebuilt from the
//! object's manifold at a turn: four unknowns of the place, one of the turn. A cell that differs much counts little
//! (Geman and McClure 1987), so that what is hidden doesn't decide: the robust projection of Leonardis and Bischof
//! (2000), with cells for pixels and neighbours that are hidden together.

use super::hypothesis::Reach;
use super::object::ViewSet;
use super::reason::Visibility;
use crate::eigen::{Eigenspace, Symmetric};
use crate::imaging::Image;
use crate::vision::gradient_field::{DIRECTIONS, GradientField, OPPONENTS, Similarity};
use crate::vision::smoothed;

/// Standard deviations of what is expected of a place: shift in px of a picture whose longer side is 128 px, logarithm of
/// the scale, turn in radians.
const EXPECTED: [f64; 4] = [5.0, 5.0, 0.1, 0.105];
/// What a place that is one standard deviation away costs, where two unrelated appearances cost 2.
const PRIOR: f64 = 0.006;
/// … and this part of the energy that interpolation leaves.
const PRIOR_OF_INTERPOLATION: f64 = 0.4;
/// No place farther away is looked at, near where the object was learnt …
const FARTHEST: [f64; 4] = [14.0, 14.0, 0.3, 0.3];
/// … and in the whole picture, where a place costs nothing.
const FARTHEST_OF_ALL: [f64; 4] = [40.0, 40.0, 0.7, 0.6];
/// Longest step, in standard deviations of the place and in degrees of the turn.
const MAX_STEP: f64 = 1.5;
const MAX_TURN_STEP_DEG: f64 = 5.0;
/// A step shorter than this part of a standard deviation, and of a degree, is the last.
const MIN_STEP: f64 = 0.02;
const ITERATIONS: usize = 6;
/// An alignment is given up that costs so many times what the best one does.
const HOPELESS: f64 = 4.0;
/// Iterations before cells that differ count less: until then the place is too far off to tell which do.
const UNWEIGHTED: usize = 2;
/// A cell counts a quarter where its difference has this part of a cell's mean energy, and what interpolation between the
/// object's views leaves.
const TOLERANCE: f64 = 0.25;
/// Standard deviation in cells over which differences are averaged: what hides one cell hides its neighbours.
const TOGETHER_CELLS: f32 = 1.0;
/// Differences of the place and the turn by which derivatives are taken.
const DIFFERENCES: [f64; 4] = [0.5, 0.5, 0.01, 0.02];
const TURN_DIFFERENCE_DEG: f64 = 0.25;
/// The brightness of an appearance of length one, of which a part may be hidden, relative to its object's.
const GAIN: [f64; 2] = [0.8, 1.6];
const UNKNOWNS: usize = 5;

/// Where an alignment begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    pub place: Similarity,
    /// On the manifold; `None`: the nearest view that is not on it.
    pub turn_deg: Option<f64>,
}

/// An object aligned with a picture.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub place: Similarity,
    /// `None` for a view without a pose.
    pub turn_deg: Option<f64>,
    /// The manifold ends here: the object may be turned further.
    pub at_end: bool,
    /// Difference of the appearances, each cell held below the tolerance, and what the place costs.
    pub cost: f64,
    /// The part of the object's appearance that the picture shows, 0..=1.
    pub explained: f64,
    /// The turn's standard deviation if differences are noise, degrees; infinite without a turn.
    pub turn_sigma_deg: f64,
    /// The picture's at the place.
    pub appearance: Vec<f32>,
    pub visibility: Visibility,
}

/// An object to be aligned with a picture.
pub(super) struct Aligner<'a> {
    pub field: &'a GradientField,
    pub reach: Reach,
    /// Cells along both sides.
    pub cells: [usize; 2],
    pub space: &'a Eigenspace,
    pub views: &'a ViewSet,
    /// Of the object: see [`ObjectPart`](super::parts::ObjectPart).
    pub typical_distance: f64,
}

/// How a difference of appearances changes with the unknowns.
struct Jacobian {
    /// By unknown: the change for one unit of [`EXPECTED`], or for one degree.
    columns: Vec<Vec<f32>>,
}

/// The state of an alignment.
struct Estimate {
    /// In units of [`EXPECTED`].
    unknowns: [f64; 4],
    turn_deg: Option<f64>,
    /// The picture's appearance at the place.
    shown: Vec<f32>,
    /// The object's at the turn.
    object: Vec<f32>,
    gain: f32,
    /// By cell.
    weights: Vec<f32>,
}

impl Aligner<'_> {
    /// Align the object from a start on. An alignment that is far worse than `best_cost` after its first steps is given up.
    pub fn fit(&self, start: &Start, best_cost: f64) -> Fit {
        let shown = self.shown(&start.place);
        let turn_deg = start.turn_deg.filter(|_| self.views.manifold().is_some());
        // Without a pose the object is one of its views.
        let object = turn_deg.map_or_else(|| self.nearest_view(&shown), |turn| self.object(turn));
        let weights = vec![1.0; self.cells[0] * self.cells[1]];
        let unknowns = in_units(&start.place);
        let mut at = Estimate { unknowns, turn_deg, shown, object, gain: 1.0, weights };
        let mut jacobian = self.jacobian(&at);
        let farthest = if self.reach == Reach::Near { FARTHEST } else { FARTHEST_OF_ALL };
        for iteration in 0..ITERATIONS {
            if iteration == UNWEIGHTED {
                jacobian = self.jacobian(&at);
            }
            if iteration >= UNWEIGHTED {
                self.reweigh(&mut at);
                if self.cost(&at) > HOPELESS * best_cost {
                    break;
                }
            }
            let Some(step) = self.step(&at, &jacobian) else { break };
            for k in 0..4 {
                let most = farthest[k] / EXPECTED[k];
                at.unknowns[k] = (at.unknowns[k] + step[k].clamp(-MAX_STEP, MAX_STEP)).clamp(-most, most);
            }
            at.shown = self.shown(&from_units(&at.unknowns));
            if let Some(turn) = &mut at.turn_deg {
                *turn += step[4].clamp(-MAX_TURN_STEP_DEG, MAX_TURN_STEP_DEG);
                at.object = self.object(*turn);
            }
            if iteration > UNWEIGHTED && step.iter().all(|v| v.abs() < MIN_STEP) {
                break;
            }
        }
        self.reweigh(&mut at);
        self.judged(at, &jacobian)
    }

    fn judged(&self, at: Estimate, jacobian: &Jacobian) -> Fit {
        let energies = self.energies(&at.object, &at.object, 0.0);
        let all: f32 = energies.iter().sum();
        let seen: f32 = at.weights.iter().zip(&energies).map(|(w, e)| w * e).sum();
        let of_manifold = at.turn_deg.zip(self.views.manifold());
        Fit {
            place: from_units(&at.unknowns),
            turn_deg: of_manifold.map(|(turn, manifold)| manifold.held(turn).rem_euclid(360.0) % 360.0),
            at_end: of_manifold.is_some_and(|(turn, manifold)| manifold.is_end(turn)),
            cost: self.cost(&at),
            explained: f64::from(seen / all.max(f32::MIN_POSITIVE)),
            turn_sigma_deg: self.turn_sigma_deg(&at, jacobian),
            visibility: Visibility { cells: self.cells, weights: at.weights, energies },
            appearance: at.shown,
        }
    }

    /// The picture's appearance at a place.
    fn shown(&self, place: &Similarity) -> Vec<f32> {
        self.field.appearance(place, &self.space.mean[self.histograms()..])
    }

    /// The object's appearance at a turn.
    fn object(&self, turn_deg: f64) -> Vec<f32> {
        let point = self.views.manifold().map(|manifold| manifold.point(turn_deg));
        self.space.rebuild(&point.unwrap_or_default())
    }

    /// The appearance of the view that is nearest to one.
    fn nearest_view(&self, appearance: &[f32]) -> Vec<f32> {
        let (point, _) = self.space.locate(appearance);
        self.space.rebuild(&self.views.nearest_view(&point))
    }

    /// Numbers of an appearance that are histograms.
    fn histograms(&self) -> usize {
        self.cells[0] * self.cells[1] * DIRECTIONS
    }

    /// Opponent planes count where the picture has colours.
    fn counts_colours(&self) -> bool {
        self.field.is_colour() && self.space.length() > self.histograms()
    }

    /// By cell: the energy of `a` less `part` of `b`.
    fn energies(&self, a: &[f32], b: &[f32], part: f32) -> Vec<f32> {
        let mut energies = Vec::with_capacity(self.cells[0] * self.cells[1]);
        let (a, a_colours) = a.split_at(self.histograms());
        let (b, b_colours) = b.split_at(self.histograms());
        let energy =
            |(a, b): (&[f32], &[f32])| a.iter().zip(b).map(|(a, b)| (a - part * b).powi(2)).sum::<f32>();
        energies.extend(a.chunks_exact(DIRECTIONS).zip(b.chunks_exact(DIRECTIONS)).map(energy));
        if self.counts_colours() {
            let colours = a_colours.chunks_exact(OPPONENTS).zip(b_colours.chunks_exact(OPPONENTS));
            energies.iter_mut().zip(colours).for_each(|(sum, cell)| *sum += energy(cell));
        }
        energies
    }

    /// By cell: the energy of the difference between object and picture, averaged over its neighbours.
    fn differences(&self, at: &Estimate) -> Vec<f32> {
        let [columns, rows] = self.cells;
        let energies = self.energies(&at.object, &at.shown, at.gain);
        smoothed(&Image::new(columns, rows, energies), TOGETHER_CELLS).pixels().to_vec()
    }

    fn tolerance(&self) -> f32 {
        ((TOLERANCE + self.typical_distance.powi(2)) / (self.cells[0] * self.cells[1]) as f64) as f32
    }

    /// What a place costs that is one standard deviation away: the more, the worse the views between which is interpolated
    /// agree, as a shift may feign a turn.
    fn prior(&self) -> f64 {
        match self.reach {
            Reach::Near => PRIOR + PRIOR_OF_INTERPOLATION * self.typical_distance.powi(2),
            Reach::Far => 0.0,
        }
    }

    /// Lets cells count by how little they differ, and finds the gain by those that count.
    fn reweigh(&self, at: &mut Estimate) {
        let tolerance = self.tolerance();
        at.weights = self.differences(at).iter().map(|d| (1.0 + d / tolerance).powi(-2)).collect();
        let both = weighted_product(&at.weights, &at.shown, &at.object, false);
        let own = weighted_product(&at.weights, &at.shown, &at.shown, false);
        at.gain = (both / own.max(f64::MIN_POSITIVE)).clamp(GAIN[0], GAIN[1]) as f32;
    }

    /// Differences, each held below the tolerance, and what the place costs.
    fn cost(&self, at: &Estimate) -> f64 {
        let tolerance = self.tolerance();
        let held: f32 = self.differences(at).iter().map(|d| tolerance * d / (tolerance + d)).sum();
        f64::from(held) + self.prior() * at.unknowns.iter().map(|v| v * v).sum::<f64>()
    }

    fn jacobian(&self, at: &Estimate) -> Jacobian {
        let change = |to: &[f32], from: &[f32], factor: f32| -> Vec<f32> {
            to.iter().zip(from).map(|(to, from)| factor * (to - from)).collect()
        };
        let mut columns = Vec::with_capacity(UNKNOWNS);
        for k in 0..4 {
            let mut moved = at.unknowns;
            let difference = DIFFERENCES[k] / EXPECTED[k];
            moved[k] += difference;
            columns.push(change(&self.shown(&from_units(&moved)), &at.shown, at.gain / difference as f32));
        }
        if let Some(turn) = at.turn_deg {
            let turned = self.object(turn + TURN_DIFFERENCE_DEG);
            columns.push(change(&turned, &at.object, -1.0 / TURN_DIFFERENCE_DEG as f32));
        }
        Jacobian { columns }
    }

    /// By unknown of the place: what one standard deviation away costs. A turn in the plane that looks like the object's own, as
    /// that of a part seen from above does, is left to the pose.
    fn priors(&self, at: &Estimate, jacobian: &Jacobian) -> [f64; 4] {
        let mut priors = [self.prior(); 4];
        if let [.., turn, pose] = &jacobian.columns[..]
            && jacobian.columns.len() == UNKNOWNS
        {
            let product = |a, b| weighted_product(&at.weights, a, b, self.counts_colours());
            let (energy, both) = (product(turn, turn), product(turn, pose));
            let likeness = both * both / (energy * product(pose, pose)).max(f64::MIN_POSITIVE);
            priors[3] += energy * likeness.powi(4) / (1.0 - likeness).max(1e-3);
        }
        priors
    }

    /// JᵀWJ with the priors on the place.
    fn normal(&self, at: &Estimate, jacobian: &Jacobian, priors: &[f64; 4]) -> Option<Symmetric> {
        let (columns, colours) = (&jacobian.columns, self.counts_colours());
        let count = columns.len();
        let mut normal = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..=a {
                normal[a * count + b] = weighted_product(&at.weights, &columns[a], &columns[b], colours);
            }
            normal[a * count + a] += priors.get(a).copied().unwrap_or(0.0);
        }
        Symmetric::of(&normal, count)
    }

    /// The change of the unknowns: 0 for a turn that there is not.
    fn step(&self, at: &Estimate, jacobian: &Jacobian) -> Option<[f64; UNKNOWNS]> {
        let residual = self.residual(at);
        let priors = self.priors(at, jacobian);
        let right: Vec<f64> = (jacobian.columns.iter().enumerate())
            .map(|(k, column)| {
                let slope = weighted_product(&at.weights, column, &residual, self.counts_colours());
                -slope - at.unknowns.get(k).map_or(0.0, |v| priors[k] * v)
            })
            .collect();
        let solved = self.normal(at, jacobian, &priors)?.solve(&right);
        let mut step = [0.0; UNKNOWNS];
        step[..solved.len()].copy_from_slice(&solved);
        Some(step)
    }

    /// The picture less the object.
    fn residual(&self, at: &Estimate) -> Vec<f32> {
        at.shown.iter().zip(&at.object).map(|(shown, object)| at.gain * shown - object).collect()
    }

    /// Of the turn, if the differences that are left are noise; infinite without a turn.
    fn turn_sigma_deg(&self, at: &Estimate, jacobian: &Jacobian) -> f64 {
        let priors = self.priors(at, jacobian);
        let Some(normal) = self.normal(at, jacobian, &priors).filter(|_| at.turn_deg.is_some()) else {
            return f64::INFINITY;
        };
        let variance = normal.solve(&[0.0, 0.0, 0.0, 0.0, 1.0])[4];
        let residual = self.residual(at);
        (variance * weighted_product(&at.weights, &residual, &residual, self.counts_colours())).sqrt()
    }
}

/// Σ w·a·b, with a weight for each cell; of the histograms, and of the opponent planes if these count.
fn weighted_product(weights: &[f32], a: &[f32], b: &[f32], colours: bool) -> f64 {
    let histograms = weights.len() * DIRECTIONS;
    let mut sums = [0.0_f32; DIRECTIONS];
    let (a_cells, _) = a[..histograms].as_chunks::<DIRECTIONS>();
    let (b_cells, _) = b[..histograms].as_chunks::<DIRECTIONS>();
    for ((a, b), weight) in a_cells.iter().zip(b_cells).zip(weights) {
        for k in 0..DIRECTIONS {
            sums[k] += weight * a[k] * b[k];
        }
    }
    let mut sum = f64::from(sums.iter().sum::<f32>());
    if colours {
        let cells = a[histograms..].chunks_exact(OPPONENTS).zip(b[histograms..].chunks_exact(OPPONENTS));
        let of_cell = |((a, b), weight): ((&[f32], &[f32]), &f32)| {
            weight * a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>()
        };
        sum += f64::from(cells.zip(weights).map(of_cell).sum::<f32>());
    }
    sum
}

fn in_units(place: &Similarity) -> [f64; 4] {
    let values = [place.x_px, place.y_px, place.scale.ln(), place.turn_rad];
    std::array::from_fn(|k| values[k] / EXPECTED[k])
}

fn from_units(unknowns: &[f64; 4]) -> Similarity {
    let [x_px, y_px, log_scale, turn_rad] = std::array::from_fn(|k| unknowns[k] * EXPECTED[k]);
    Similarity { x_px, y_px, scale: log_scale.exp(), turn_rad }
}

#[cfg(test)]
mod tests {
    use super::super::disturbance::Disturbance;
    use super::super::model::Objects;
    use super::super::recognition::{Recognition, Warning};
    use super::super::test_pictures::{SIDE_PX, normaliser, thing, turntable};
    use super::super::{ObjectOptions, train};
    use crate::angle::angular_distance_deg;
    use crate::imaging::{Frame, Image};

    fn trained() -> Objects {
        let options = ObjectOptions::default();
        train(turntable(4, 10, &options), &normaliser(&options), &options).unwrap().0
    }

    fn asked(model: &Objects, frame: &Frame) -> Recognition {
        model.recognise(frame, |_| ()).unwrap()
    }

    fn code(recognition: &Recognition) -> &'static str {
        assert_eq!(recognition.decision, None);
        recognition.reasons[0].code()
    }

    #[test]
    fn where_an_object_stands_is_found_with_its_pose() {
        let model = trained();
        for (shift_px, scale, turn_deg) in
            [([1.5, -1.0], 1.0, 0.0), ([0.0, 1.8], 0.93, 0.0), ([-1.0, 0.0], 1.08, 4.0)]
        {
            let disturbance = Disturbance {
                shift: shift_px.map(|px| px / SIDE_PX as f64),
                scale,
                turn_rad: f64::to_radians(turn_deg),
                ..Disturbance::NONE
            };
            for (seed, pose_deg) in [(0, 25.0), (1, 125.0), (2, 255.0), (3, 344.0)] {
                let decision =
                    asked(&model, &disturbance.of(&thing(seed, pose_deg), 0)).decision.expect("recognised");
                assert_eq!(decision.label, format!("thing{seed}"));
                let found = decision.alignment.unwrap();
                let off_px = (found.shift_x_px - shift_px[0]).hypot(found.shift_y_px - shift_px[1]);
                assert!(off_px < 0.6 && (found.scale / scale - 1.0).abs() < 0.04, "{found:?}");
                assert!((found.turn_deg - turn_deg).abs() < 2.5, "{found:?}");
                let error_deg = angular_distance_deg(decision.pose.unwrap().turn_deg, pose_deg);
                assert!(error_deg < 3.0, "thing{seed} at {pose_deg}°: {error_deg}");
            }
        }
    }

    #[test]
    fn what_is_hidden_does_not_decide() {
        let model = trained();
        let mut right = 0;
        for seed in 0..4 {
            for side in 0..6 {
                let hidden_rad = f64::from(side);
                let disturbance =
                    Disturbance { hidden: 0.2, hidden_rad, occluder: 90.0, ..Disturbance::NONE };
                let recognition = asked(&model, &disturbance.of(&thing(seed, 35.0), 0));
                right += usize::from(recognition.decision.is_some_and(|d| d.label == format!("thing{seed}")));
            }
        }
        assert!(right >= 23, "{right} of 24");
    }

    #[test]
    fn a_refusal_says_what_would_help() {
        let model = trained();
        let of = |disturbance: Disturbance| asked(&model, &disturbance.of(&thing(2, 35.0), 0));
        assert_eq!(code(&of(Disturbance { shift: [0.2, 0.0], ..Disturbance::NONE })), "off_centre");
        assert_eq!(code(&of(Disturbance { scale: 0.6, ..Disturbance::NONE })), "scale");
        assert_eq!(code(&of(Disturbance { gain: 0.01, ..Disturbance::NONE })), "light");
        assert_eq!(code(&asked(&model, &thing(31, 0.0))), "unlike_anything");
        let half = Disturbance { hidden: 0.6, occluder: 0.0, ..Disturbance::NONE };
        let reasons: Vec<&str> = (0..4)
            .map(|seed| asked(&model, &half.of(&thing(seed, 35.0), 0)))
            .filter(|r| r.decision.is_none())
            .map(|r| code(&r))
            .collect();
        assert!(reasons.contains(&"hidden"), "{reasons:?}");
    }

    #[test]
    fn things_of_one_luminance_differ_by_their_colours() {
        let options = ObjectOptions::default();
        let normaliser = normaliser(&options);
        // The same luminance of 0.299 r + 0.587 g + 0.114 b.
        let red = [1.5, 0.7966, 0.7966];
        let blue = [0.9, 0.9, 1.7772];
        let painted = |turn: f64, factors: [f32; 3]| {
            let gray = thing(5, turn).luminance;
            Frame::colour(
                factors.map(|factor| Image::from_fn(SIDE_PX, SIDE_PX, |x, y| 0.6 * factor * gray.at(x, y))),
            )
        };
        let views = [("red", red), ("blue", blue)].into_iter().flat_map(|(label, factors)| {
            let view = super::super::test_pictures::view;
            (0..24)
                .map(move |n| (label, 15.0 * f64::from(n), factors))
                .map(|(label, turn, factors)| view(&normaliser, label, Some(turn), &painted(turn, factors)))
                .collect::<Vec<_>>()
        });
        let model = train(views.collect(), &normaliser, &options).unwrap().0;
        for (label, factors) in [("red", red), ("blue", blue)] {
            let decision = asked(&model, &painted(52.0, factors)).decision.expect("recognised");
            assert_eq!(decision.label, label);
            assert!(angular_distance_deg(decision.pose.unwrap().turn_deg, 52.0) < 3.0);
        }
        // The colours are all that tells them apart.
        let gray = asked(&model, &Frame::gray(painted(52.0, red).luminance));
        assert!(gray.warnings.contains(&Warning::GrayFrame) && gray.warnings.contains(&Warning::CloseSecond));
    }
}
