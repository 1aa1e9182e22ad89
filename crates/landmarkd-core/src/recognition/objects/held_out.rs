//! Views that are left out and shown again: what an unknown picture of a known object will be like.

use super::calibration::{Calibration, Logistic, quantile};
use super::manifold::{ONE_POSE_DEG, apart_deg, different};
use super::model::{CANDIDATES, Objects};
use super::object::{KnownObject, ViewSet};

/// Held-out views on which rates are counted: more take longer and tell no more.
pub(super) const TRIALS: usize = 2000;
/// One view in so many is kept to see how distances grow with the gap: then it is twice as wide again.
const COARSE: usize = 4;
/// What noise alone makes of equal pictures.
const LEAST_SCALE: f64 = 0.002;
/// From the median of a normal deviate's magnitude to its standard deviation.
const SIGMA_OF_MEDIAN: f64 = 1.4826;

/// A view that was left out of its object, with all that have the same pose.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldOutView {
    /// How far it was from the others, from the curve between its neighbours if it has a pose; `None` if there are
    /// none.
    pub distance: Option<f64>,
    /// … from every fourth of the others.
    coarse: Option<f64>,
    pose: Option<HeldOutPose>,
}

#[derive(Clone, Copy, Debug)]
struct HeldOutPose {
    /// Which of its object's different poses it has.
    number: usize,
    error_deg: f64,
    /// Between its neighbours.
    gap_deg: f64,
    /// Of the curve where it was found.
    speed_per_deg: f64,
}

impl HeldOutView {
    /// By how much its pose was missed.
    pub fn pose_error_deg(&self) -> Option<f64> {
        self.pose.map(|pose| pose.error_deg)
    }
}

/// Leave each view of an object out: of n × `dimension` eigenpoints, each `outside` so far from the space.
pub(super) fn hold_out(
    points: &[f32],
    outside: &[f64],
    poses_deg: &[Option<f64>],
    dimension: usize,
) -> Vec<HeldOutView> {
    let count = poses_deg.len();
    let point = |view: usize| &points[view * dimension..][..dimension];
    let set = |members: &[usize]| {
        let points: Vec<f32> = members.iter().flat_map(|&view| point(view)).copied().collect();
        let poses: Vec<Option<f64>> = members.iter().map(|&view| poses_deg[view]).collect();
        ViewSet::new(&points, &poses, dimension)
    };
    let (_, which) = different(poses_deg);
    (0..count)
        .map(|left_out| {
            let is_other =
                |&view: &usize| view != left_out && (which[view].is_none() || which[view] != which[left_out]);
            let others: Vec<usize> = (0..count).filter(is_other).collect();
            if others.is_empty() {
                return HeldOutView::default();
            }
            let others = set(&others);
            let closeness = others.closeness(point(left_out), outside[left_out]);
            let in_gap =
                |set: &ViewSet| set.distance_in_gap(point(left_out), outside[left_out], poses_deg[left_out]?);
            let gap = in_gap(&others);
            let pose = closeness.feet.zip(gap).and_then(|((foot, _), (_, gap_deg))| {
                Some(HeldOutPose {
                    number: which[left_out]?,
                    error_deg: apart_deg(foot.turn_deg, poses_deg[left_out]?),
                    gap_deg,
                    speed_per_deg: foot.speed_per_deg,
                })
            });
            let coarse = which[left_out].and_then(|own| {
                let is_coarse = |number: usize| (number + COARSE - own % COARSE) % COARSE == COARSE / 2;
                let members: Vec<usize> =
                    (0..count).filter(|&view| which[view].is_some_and(is_coarse)).collect();
                in_gap(&set(&members)).map(|(distance, _)| distance)
            });
            let distance = gap.map_or(closeness.total(), |(distance, _)| distance);
            HeldOutView { distance: Some(distance), coarse, pose }
        })
        .collect()
}

/// The universal eigenspace's points and whose they are.
pub(super) struct Neighbourhood<'a> {
    /// n × dimension.
    pub points: &'a [f32],
    pub dimension: usize,
    pub owner: &'a [usize],
    pub poses_deg: &'a [Option<f64>],
}

impl Neighbourhood<'_> {
    /// Whether leaving `view` out leaves `other` out.
    pub fn goes_with(&self, other: usize, view: usize) -> bool {
        let is_same = |(a, b)| apart_deg(a, b) <= ONE_POSE_DEG;
        other == view
            || self.owner[other] == self.owner[view]
                && self.poses_deg[view].zip(self.poses_deg[other]).is_some_and(is_same)
    }

    /// By object: the largest distance from one of its views to the next in pose.
    fn widest_steps(&self, objects: usize) -> Vec<f64> {
        let mut widest = vec![0.0_f64; objects];
        let point = |view: usize| &self.points[view * self.dimension..][..self.dimension];
        let apart = |a: usize, b: usize| {
            let pairs = point(a).iter().zip(point(b));
            pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
        };
        let posed: Vec<usize> =
            (0..self.owner.len()).filter(|&view| self.poses_deg[view].is_some()).collect();
        for views in posed.chunk_by(|&a, &b| self.owner[a] == self.owner[b]) {
            let round = views.iter().zip(views.iter().cycle().skip(1));
            widest[self.owner[views[0]]] = round.map(|(&a, &b)| apart(a, b)).fold(0.0, f64::max);
        }
        widest
    }

    /// How far the nearest view of each object is when `view` is left out: nearest objects first.
    fn nearest_objects(&self, view: usize, objects: usize) -> Vec<(usize, f64)> {
        let query = &self.points[view * self.dimension..][..self.dimension];
        let mut nearest = vec![f32::INFINITY; objects];
        for (other, point) in self.points.chunks_exact(self.dimension).enumerate() {
            let square: f32 = point.iter().zip(query).map(|(a, b)| (a - b) * (a - b)).sum();
            let best = &mut nearest[self.owner[other]];
            if square < *best && !self.goes_with(other, view) {
                *best = square;
            }
        }
        let mut found: Vec<(usize, f64)> = (nearest.into_iter().enumerate())
            .filter(|(_, square)| square.is_finite())
            .map(|(object, square)| (object, f64::from(square).sqrt()))
            .collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        found
    }
}

/// A view shown to all objects as if it had not been learnt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// Which object it is of.
    pub object: usize,
    /// How far it would be from its own object, as a query; `None` if that has no other view.
    pub own: Option<f64>,
    /// Whether its own object was among the likeliest: those alone are looked at closely.
    is_likely: bool,
    /// The other object that would be answered, and how far it is.
    pub other: Option<(usize, f64)>,
    /// Where the order of the universal eigenspace decides: whether its own object comes first.
    own_is_first: Option<bool>,
}

impl Trial {
    /// The object that would be answered if it is accepted.
    pub fn nearest(&self) -> Option<(usize, f64)> {
        let own = self.own.filter(|_| self.is_likely).map(|own| (self.object, own));
        match self.own_is_first {
            Some(true) => own,
            Some(false) => self.other,
            None => own.into_iter().chain(self.other).min_by(|a, b| a.1.total_cmp(&b.1)),
        }
    }
}

/// What all held-out views together teach.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lesson {
    pub shrink: f64,
    pub angle_part: f64,
}

impl Lesson {
    /// Fill in what each object's own views teach of it. `None` if no object has two views.
    pub fn learn(objects: &mut [KnownObject], held_out: &[Vec<HeldOutView>]) -> Option<Lesson> {
        let all = || held_out.iter().flatten();
        let ratios: Vec<f64> = all()
            .filter_map(|view| Some((view.distance?, view.coarse?)))
            .filter(|&(_, coarse)| coarse > 0.0)
            .map(|(distance, coarse)| distance / coarse)
            .collect();
        let shrink = quantile(&ratios, 0.5).unwrap_or(1.0).min(1.0);
        // where the pose was found in the right gap: elsewhere the error says nothing about the residual
        let parts: Vec<f64> = all()
            .filter_map(|view| Some((view.distance?, view.pose?)))
            .filter(|(distance, pose)| *distance > 0.0 && pose.error_deg < pose.gap_deg / 2.0)
            .map(|(distance, pose)| pose.error_deg * pose.speed_per_deg / distance)
            .collect();
        let angle_part = quantile(&parts, 0.5).map_or(1.0, |median| (SIGMA_OF_MEDIAN * median).min(1.0));

        for (object, views) in objects.iter_mut().zip(held_out) {
            let distances: Vec<f64> = views.iter().filter_map(|view| view.distance).collect();
            let mean_square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64;
            object.scale = (!distances.is_empty()).then(|| mean_square.sqrt().max(LEAST_SCALE));
            object.usual = shrink * quantile(&distances, 0.5).unwrap_or(0.0);
            // all or none: the views at a pose have been left out together
            let errors = (0..object.views.poses_deg.len()).map(|number| {
                let there = views.iter().filter_map(|view| view.pose).filter(|held| held.number == number);
                there.map(|held| held.error_deg).reduce(f64::max)
            });
            object.held_out_deg = errors.collect::<Option<Vec<f64>>>().unwrap_or_default();
        }
        let scales: Vec<f64> = objects.iter().filter_map(|object| object.scale).collect();
        let usual = quantile(&scales, 0.5)?;
        for object in objects.iter_mut() {
            object.scale = object.scale.or(Some(usual));
        }
        Some(Lesson { shrink, angle_part })
    }

    /// Show views to all objects: every one, or as many as [`TRIALS`]. `rows` are their appearances.
    pub fn trials(
        &self,
        model: &Objects,
        rows: &[f32],
        held_out: &[HeldOutView],
        neighbourhood: &Neighbourhood,
    ) -> Vec<Trial> {
        let length = model.universal.length();
        let count = neighbourhood.owner.len();
        (0..count)
            .step_by(count.div_ceil(TRIALS))
            .map(|view| {
                let object = neighbourhood.owner[view];
                let vector = &rows[view * length..][..length];
                let (point, outside) = model.universal.locate(vector);
                let mut near = neighbourhood.nearest_objects(view, model.objects.len());
                // a view that is left out is still part of its object's covariance
                model.order_by_covariance(&mut near, &point);
                let is_likely = near.iter().take(CANDIDATES).any(|(found, _)| *found == object);
                let own = held_out[view].distance.map(|d| d * self.shrink.sqrt());
                let mut others =
                    near.iter().filter(|(found, _)| *found != object).take(CANDIDATES).map(|&(found, _)| {
                        (found, model.objects[found].closeness(vector, (&point, outside)).total())
                    });
                let (other, own_is_first) = match model.order_stands() {
                    true => (others.next(), near.first().map(|(first, _)| *first == object)),
                    false => (others.min_by(|a, b| a.1.total_cmp(&b.1)), None),
                };
                Trial { object, own, is_likely, other, own_is_first }
            })
            .collect()
    }

    /// B(16): the threshold that accepts a part of the known, the radius that loses none of them, and the confidence.
    pub fn calibrated(
        &self,
        objects: &[KnownObject],
        trials: &[Trial],
        neighbourhood: &Neighbourhood,
        accept: f64,
    ) -> Option<Calibration> {
        let relative =
            |(object, distance): (usize, f64)| distance / objects[object].scale.map_or(1.0, f64::sqrt);
        let own: Vec<f64> = trials.iter().filter_map(|t| Some(relative((t.object, t.own?)))).collect();
        let (mut right, mut wrong) = (Vec::new(), Vec::new());
        let evidence = |found| f64::max(relative(found), f64::MIN_POSITIVE).ln();
        for trial in trials {
            if let Some(found) = trial.nearest().filter(|_| trial.own.is_some()) {
                if found.0 == trial.object { &mut right } else { &mut wrong }.push(evidence(found));
            }
            wrong.extend(trial.other.map(evidence));
        }
        let threshold = quantile(&own, accept)?;
        // what is accepted lies so far from the curve, and the curve no farther from a view than the next one is
        let reach = neighbourhood.widest_steps(objects.len());
        let radius = objects
            .iter()
            .zip(reach)
            .map(|(object, step)| threshold * object.scale.map_or(1.0, f64::sqrt) + step);
        Some(Calibration {
            shrink: self.shrink,
            angle_part: self.angle_part,
            radius: radius.fold(0.0, f64::max),
            threshold,
            confidence: (!right.is_empty() && !wrong.is_empty()).then(|| Logistic::fit(&right, &wrong)),
        })
    }
}
