//! Leave-one-out trials: each view is left out of its object and shown to the database, which tells what an unknown
//! picture of a known object will be like.

use super::acceptance::{Acceptance, Logistic};
use super::manifold::{DistinctPoses, ONE_POSE_DEG};
use super::model::{CANDIDATES, NearObject, Objects};
use super::object::{KnownObject, Query, ViewSet, euclidean_distance};
use super::options::AppearanceOf;
use super::ranked_object::unexplained_ratio;
use super::training::ProjectedViews;
use crate::angle::angular_distance_deg;
use crate::statistics::quantile;

/// Held-out views on which rates are counted: more take longer and tell no more.
pub(super) const MAX_TRIALS: usize = 2000;
/// One view in so many is kept to see how distances grow with the gap: then it is twice as wide again.
const COARSE: usize = 4;
/// Noise alone makes a distance of this between equal pictures.
const MIN_SCALE: f64 = 0.002;
/// Of the magnitudes of normal deviates 80 % are below.
const NORMAL_AT_80: f64 = 1.2816;
/// Nothing is accepted that isn't so many times as likely right as wrong: to name a strange thing costs more than to refuse
/// a known one.
const LEAST_ODDS: f64 = 1.5;
/// Nothing is accepted of which less is explained, whatever few and sparse views show: of strange things that are held
/// against six objects, 97 % explain less than 0.13 of the likest one.
const MIN_EXPLAINED: f64 = 0.15;
/// From the median of a normal deviate's magnitude to its standard deviation.
const SIGMA_OF_MEDIAN: f64 = 1.4826;

/// A view that was left out of its object, with all that have the same pose.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldOutView {
    /// Distance from the others: from the curve between its neighbours if it has a pose; `None` if there are no others.
    pub distance: Option<f64>,
    /// … from every fourth of the others.
    coarse_distance: Option<f64>,
    pose: Option<HeldOutPose>,
}

#[derive(Clone, Copy, Debug)]
struct HeldOutPose {
    /// Index among its object's distinct poses.
    index: usize,
    error_deg: f64,
    /// Between its neighbours.
    gap_deg: f64,
    /// Of the curve where it was found.
    speed_per_deg: f64,
}

impl HeldOutView {
    /// Error of the pose that the other views give it.
    pub fn pose_error_deg(&self) -> Option<f64> {
        self.pose.map(|pose| pose.error_deg)
    }
}

/// Leave each view of an object out in turn.
pub(super) fn leave_each_out(views: &ProjectedViews, poses_deg: &[Option<f64>]) -> Vec<HeldOutView> {
    let object = LeaveOneOut { views, poses_deg, distinct: DistinctPoses::of(poses_deg) };
    (0..poses_deg.len()).map(|view| object.without(view)).collect()
}

/// The views of one object, of which one at a time is left out.
struct LeaveOneOut<'a> {
    views: &'a ProjectedViews,
    poses_deg: &'a [Option<f64>],
    distinct: DistinctPoses,
}

impl LeaveOneOut<'_> {
    fn without(&self, view: usize) -> HeldOutView {
        let own = self.distinct.of_view[view];
        let others = self.set_of(|other| {
            let pose = self.distinct.of_view[other];
            other != view && (pose.is_none() || pose != own)
        });
        let Some(others) = others else { return HeldOutView::default() };
        let (point, from_space) = (self.point(view), self.views.distances_from_space[view]);
        let distance = others.distance(point, from_space);
        let in_gap = |set: &ViewSet| set.distance_in_gap(point, from_space, self.poses_deg[view]?);
        let gap = in_gap(&others);
        let pose = distance.on_curve.zip(gap).and_then(|(on_curve, gap)| {
            Some(HeldOutPose {
                index: own?,
                error_deg: angular_distance_deg(on_curve.nearest.turn_deg, self.poses_deg[view]?),
                gap_deg: gap.gap_deg,
                speed_per_deg: on_curve.nearest.speed_per_deg,
            })
        });
        let coarse_distance = own.and_then(|own| {
            let is_coarse = |pose: usize| (pose + COARSE - own % COARSE) % COARSE == COARSE / 2;
            let every_fourth = self.set_of(|other| self.distinct.of_view[other].is_some_and(is_coarse))?;
            in_gap(&every_fourth).map(|gap| gap.distance)
        });
        let distance = gap.map_or(distance.total(), |gap| gap.distance);
        HeldOutView { distance: Some(distance), coarse_distance, pose }
    }

    fn point(&self, view: usize) -> &[f32] {
        &self.views.points[view * self.views.dimension..][..self.views.dimension]
    }

    /// The views that are kept; `None` if none is.
    fn set_of(&self, is_kept: impl Fn(usize) -> bool) -> Option<ViewSet> {
        let kept: Vec<usize> = (0..self.poses_deg.len()).filter(|&view| is_kept(view)).collect();
        let points: Vec<f32> = kept.iter().flat_map(|&view| self.point(view)).copied().collect();
        let poses_deg: Vec<Option<f64>> = kept.iter().map(|&view| self.poses_deg[view]).collect();
        (!kept.is_empty()).then(|| ViewSet::new(&points, &poses_deg, self.views.dimension))
    }
}

/// The eigenpoints of the universal eigenspace, with the object and the pose of each.
pub(super) struct LabelledPoints<'a> {
    /// views × dimension, row-major.
    pub points: &'a [f32],
    pub dimension: usize,
    pub object_of_view: &'a [usize],
    pub poses_deg: &'a [Option<f64>],
}

impl LabelledPoints<'_> {
    /// Whether leaving `view` out leaves `other` out.
    pub fn is_left_out_with(&self, other: usize, view: usize) -> bool {
        let is_same = |(a, b)| angular_distance_deg(a, b) <= ONE_POSE_DEG;
        other == view
            || self.object_of_view[other] == self.object_of_view[view]
                && self.poses_deg[view].zip(self.poses_deg[other]).is_some_and(is_same)
    }

    pub fn point(&self, view: usize) -> &[f32] {
        &self.points[view * self.dimension..][..self.dimension]
    }

    /// By object: the largest distance from one of its views to the next in pose.
    fn widest_steps(&self, objects: usize) -> Vec<f64> {
        let mut widest = vec![0.0_f64; objects];
        let apart = |a: usize, b: usize| euclidean_distance(self.point(a), self.point(b));
        let posed: Vec<usize> =
            (0..self.object_of_view.len()).filter(|&view| self.poses_deg[view].is_some()).collect();
        for views in posed.chunk_by(|&a, &b| self.object_of_view[a] == self.object_of_view[b]) {
            let round = views.iter().zip(views.iter().cycle().skip(1));
            widest[self.object_of_view[views[0]]] = round.map(|(&a, &b)| apart(a, b)).fold(0.0, f64::max);
        }
        widest
    }

    /// The distance of the nearest view of each object when `view` is left out: nearest objects first.
    fn nearest_objects(&self, view: usize, objects: usize) -> Vec<NearObject> {
        let query = self.point(view);
        let mut nearest = vec![f32::INFINITY; objects];
        for (other, point) in self.points.chunks_exact(self.dimension).enumerate() {
            let square: f32 = point.iter().zip(query).map(|(a, b)| (a - b) * (a - b)).sum();
            let best = &mut nearest[self.object_of_view[other]];
            if square < *best && !self.is_left_out_with(other, view) {
                *best = square;
            }
        }
        let mut found: Vec<NearObject> = (nearest.into_iter().enumerate())
            .filter(|(_, square)| square.is_finite())
            .map(|(object, square)| NearObject { object, distance: f64::from(square).sqrt() })
            .collect();
        found.sort_by(NearObject::by_distance);
        found
    }
}

/// A view shown to all objects as if it had not been learnt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    /// The object that it shows.
    pub object: usize,
    /// Expected distance from its own object, as a query; `None` if that has no other view.
    pub own_distance: Option<f64>,
    /// Whether its own object was among the likeliest: those alone are compared in their own eigenspaces.
    pub is_likely: bool,
    /// The other object that would be answered.
    pub other: Option<NearObject>,
    /// Where the order of the universal eigenspace decides: whether its own object comes first.
    pub own_is_first: Option<bool>,
    /// Of an aligned view: the error of its pose over the standard deviation that the fit gives.
    pub pose_ratio: Option<f64>,
}

impl Trial {
    /// Its own object, at the distance that is expected of a query.
    fn own(&self) -> Option<NearObject> {
        self.own_distance.map(|distance| NearObject { object: self.object, distance })
    }

    /// The object that would be answered if it is accepted.
    pub fn nearest(&self) -> Option<NearObject> {
        let own = self.own().filter(|_| self.is_likely);
        match self.own_is_first {
            Some(true) => own,
            Some(false) => self.other,
            None => own.into_iter().chain(self.other).min_by(NearObject::by_distance),
        }
    }
}

/// Statistics over the held-out views of all objects.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldOutStatistics {
    /// See [`Acceptance::distance_ratio`].
    pub distance_ratio: f64,
    /// See [`Acceptance::tangential_part`].
    tangential_part: f64,
}

impl HeldOutStatistics {
    /// `None` if no object has two views.
    pub fn of(held_out: &[Vec<HeldOutView>]) -> Option<HeldOutStatistics> {
        let all = || held_out.iter().flatten();
        all().find(|view| view.distance.is_some())?;
        let ratios: Vec<f64> = all()
            .filter_map(|view| Some((view.distance?, view.coarse_distance?)))
            .filter(|&(_, coarse)| coarse > 0.0)
            .map(|(distance, coarse)| distance / coarse)
            .collect();
        let distance_ratio = quantile(&ratios, 0.5).unwrap_or(1.0).min(1.0);
        // where the pose was found in the right gap: elsewhere the error says nothing about the residual
        let parts: Vec<f64> = all()
            .filter_map(|view| Some((view.distance?, view.pose?)))
            .filter(|(distance, pose)| *distance > 0.0 && pose.error_deg < pose.gap_deg / 2.0)
            .map(|(distance, pose)| pose.error_deg * pose.speed_per_deg / distance)
            .collect();
        let tangential_part = quantile(&parts, 0.5).map_or(1.0, |median| (SIGMA_OF_MEDIAN * median).min(1.0));
        Some(HeldOutStatistics { distance_ratio, tangential_part })
    }

    /// Set the scale, the typical distance and the pose errors of each object by its own held-out views; an object
    /// with one view gets the median scale of the others.
    pub fn describe(&self, objects: &mut [KnownObject], held_out: &[Vec<HeldOutView>]) {
        for (object, views) in objects.iter_mut().zip(held_out) {
            let distances: Vec<f64> = views.iter().filter_map(|view| view.distance).collect();
            let mean_square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64;
            object.part.scale = (!distances.is_empty()).then(|| mean_square.sqrt().max(MIN_SCALE));
            object.part.typical_distance = self.distance_ratio * quantile(&distances, 0.5).unwrap_or(0.0);
            // all or none: the views at a pose are left out together
            let errors = (0..object.views.poses_deg.len()).map(|index| {
                let there = views.iter().filter_map(|view| view.pose).filter(|held| held.index == index);
                there.map(|held| held.error_deg).reduce(f64::max)
            });
            object.part.held_out_deg = errors.collect::<Option<Vec<f64>>>().unwrap_or_default();
        }
        let scales: Vec<f64> = objects.iter().filter_map(|object| object.part.scale).collect();
        let median = quantile(&scales, 0.5);
        for object in objects.iter_mut() {
            object.part.scale = object.part.scale.or(median);
        }
    }

    /// Show views to all objects: every one, or as many as [`MAX_TRIALS`]. `rows` are their appearances, views × length.
    pub fn trials(
        &self,
        model: &Objects,
        rows: &[f32],
        held_out: &[HeldOutView],
        points: &LabelledPoints,
    ) -> Vec<Trial> {
        let length = model.universal.length();
        let count = held_out.len();
        let views = (0..count).step_by(count.div_ceil(MAX_TRIALS));
        views
            .map(|view| {
                let query = Query::new(&model.universal, &rows[view * length..][..length]);
                self.trial(model, view, &query, held_out[view], points)
            })
            .collect()
    }

    fn trial(
        &self,
        model: &Objects,
        view: usize,
        query: &Query,
        held_out: HeldOutView,
        points: &LabelledPoints,
    ) -> Trial {
        let object = points.object_of_view[view];
        let mut near = points.nearest_objects(view, model.objects.len());
        // a view that is left out is still part of its object's covariance
        model.order_by_covariance(&mut near, &query.point);
        let is_likely = near.iter().take(CANDIDATES).any(|found| found.object == object);
        let mut others = near.iter().filter(|found| found.object != object).take(CANDIDATES).map(|found| {
            let distance = model.objects[found.object].distance(query).total();
            NearObject { object: found.object, distance }
        });
        let (other, own_is_first) = match model.covariance_decides() {
            true => (others.next(), near.first().map(|first| first.object == object)),
            false => (others.min_by(NearObject::by_distance), None),
        };
        let own_distance = held_out.distance.map(|distance| distance * self.distance_ratio.sqrt());
        Trial { object, own_distance, is_likely, other, own_is_first, pose_ratio: None }
    }

    /// B(16): the threshold that accepts a part `accept` of the known, of gradients nothing that isn't [`LEAST_ODDS`] times as likely right as wrong; the radius
    /// that loses none of them, and the confidence.
    pub fn acceptance(
        &self,
        model: &Objects,
        trials: &[Trial],
        points: &LabelledPoints,
    ) -> Option<Acceptance> {
        let objects = &model.objects;
        let relative = |found: NearObject| match model.options.appearance {
            AppearanceOf::Intensity => found.distance / objects[found.object].root_scale(),
            AppearanceOf::Gradient => found.distance,
        };
        let own: Vec<f64> = trials.iter().filter_map(|trial| trial.own().map(relative)).collect();
        let accepting = quantile(&own, model.options.accept)?;
        let evidence = |found| f64::max(relative(found), f64::MIN_POSITIVE).ln();
        let (mut right, mut wrong) = (Vec::new(), Vec::new());
        for trial in trials {
            if let Some(found) = trial.nearest().filter(|_| trial.own_distance.is_some()) {
                if found.object == trial.object { &mut right } else { &mut wrong }.push(evidence(found));
            }
            wrong.extend(trial.other.map(evidence));
        }
        let confidence = (!right.is_empty() && !wrong.is_empty()).then(|| Logistic::fit(&right, &wrong));
        let threshold = match model.options.appearance {
            AppearanceOf::Intensity => accepting,
            AppearanceOf::Gradient => {
                let likely =
                    confidence.and_then(|fit| fit.evidence_at(LEAST_ODDS)).map_or(f64::INFINITY, f64::exp);
                accepting.min(likely).min(unexplained_ratio(MIN_EXPLAINED))
            }
        };
        // what is accepted lies so far from the curve, and the curve no farther from a view than the next one is
        let steps = points.widest_steps(objects.len());
        let radius = objects.iter().zip(steps).map(|(object, step)| threshold * object.root_scale() + step);
        let ratios: Vec<f64> = trials.iter().filter_map(|trial| trial.pose_ratio).collect();
        // Errors have longer tails than a normal deviate: by their 80 %.
        let aligned_part = quantile(&ratios, 0.8).map(|ratio| ratio / NORMAL_AT_80);
        // Measured on the 20 objects of COIL-20: the median error of aligned poses is 2.3°, 1.0° and 0.23° with 12, 18 and 36
        // views; distances fall by less than half of that.
        let distance_ratio = match model.options.appearance {
            AppearanceOf::Intensity => self.distance_ratio,
            AppearanceOf::Gradient => self.distance_ratio.powi(2),
        };
        Some(Acceptance {
            distance_ratio,
            tangential_part: aligned_part.unwrap_or(self.tangential_part),
            radius: radius.fold(0.0, f64::max),
            threshold,
            confidence,
        })
    }
}
