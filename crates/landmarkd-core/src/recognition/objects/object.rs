//! One known object: its eigenspace, its views there, and the curve through those that have a pose.

use super::acceptance::Acceptance;
use super::alignment::Fit;
use super::manifold::{CurveProjection, DistinctPoses, Manifold, wide_gaps};
use super::parts::ObjectPart;
use super::recognition::Pose;
use crate::eigen::Eigenspace;

/// B§6: fewer views give no reliable pose.
const MIN_VIEWS: usize = 10;
/// A pose with a larger standard deviation is not reliable: 2.5 of it lie within 5°.
const MAX_SIGMA_DEG: f64 = 2.0;
/// Another pose is an alternative if its distance is at most so many times that of the nearest.
const AMBIGUOUS: f64 = 1.2;
/// Between two views the standard deviation is at least this part of the gap: a view that is left out lies in the
/// middle of its neighbours, where an interpolation's errors cancel.
const MIN_SIGMA_OF_GAP: f64 = 0.01;
/// The standard deviation of a pose about which nothing is known.
const UNKNOWN_DEG: f64 = 180.0;

/// An appearance, located in the universal eigenspace (B(13)).
pub(super) struct Query<'a> {
    pub vector: &'a [f32],
    /// Its eigenpoint.
    pub point: Vec<f32>,
    pub distance_from_space: f64,
}

impl<'a> Query<'a> {
    pub fn new(universal: &Eigenspace, vector: &'a [f32]) -> Query<'a> {
        let (point, distance_from_space) = universal.locate(vector);
        Query { vector, point, distance_from_space }
    }
}

/// Views of an object as eigenpoints, in whatever space.
#[derive(Clone, Debug)]
pub(super) struct ViewSet {
    dimension: usize,
    /// Poses that a view has, ascending, each once.
    pub poses_deg: Vec<f64>,
    /// Through the eigenpoints at these poses; of several at one pose their mean.
    manifold: Option<Manifold>,
    /// Eigenpoints of views that are not on a manifold, n × dimension.
    isolated: Vec<f32>,
}

/// The distance of a picture from an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct ObjectDistance {
    /// From the nearest view or point of the manifold, in the eigenspace.
    pub in_space: f64,
    pub from_space: f64,
    /// The nearest points of the manifold, if there is one.
    pub on_curve: Option<CurveProjection>,
}

impl ObjectDistance {
    /// The distance between the pictures: √(in² + from²).
    pub fn total(&self) -> f64 {
        self.in_space.hypot(self.from_space)
    }
}

/// ‖a − b‖
pub(super) fn euclidean_distance(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
}

/// The distance of a point from the curve between two neighbouring views.
#[derive(Clone, Copy, Debug)]
pub(super) struct GapDistance {
    pub distance: f64,
    /// Between the two views.
    pub gap_deg: f64,
}

impl ViewSet {
    /// Of n × `dimension` eigenpoints and their poses.
    pub fn new(points: &[f32], poses_deg: &[Option<f64>], dimension: usize) -> ViewSet {
        let point = |view: usize| &points[view * dimension..][..dimension];
        let DistinctPoses { poses_deg: poses, of_view } = DistinctPoses::of(poses_deg);
        let mut knots = Vec::with_capacity(poses.len() * dimension);
        for index in 0..poses.len() {
            let same: Vec<usize> = (0..of_view.len()).filter(|&view| of_view[view] == Some(index)).collect();
            knots.extend((0..dimension).map(|k| {
                let sum: f64 = same.iter().map(|&view| f64::from(point(view)[k])).sum();
                (sum / same.len() as f64) as f32
            }));
        }
        let manifold = Manifold::through(&poses, &knots, dimension);
        let is_isolated = |view: &usize| manifold.is_none() || poses_deg[*view].is_none();
        let isolated = (0..poses_deg.len()).filter(is_isolated).flat_map(point).copied().collect();
        ViewSet { dimension, poses_deg: poses, manifold, isolated }
    }

    /// The distance of a point of the space, which is the projection of a picture `from_space` away from it.
    pub fn distance(&self, point: &[f32], from_space: f64) -> ObjectDistance {
        let on_curve = self.manifold.as_ref().map(|manifold| manifold.project(point));
        // without a coordinate all views are the mean
        let at_mean = if self.dimension == 0 { 0.0 } else { f64::INFINITY };
        let isolated = self.isolated.chunks_exact(self.dimension.max(1));
        let nearest = isolated.map(|view| euclidean_distance(view, point)).fold(at_mean, f64::min);
        let in_space = on_curve.map_or(nearest, |curve| curve.nearest.distance.min(nearest));
        ObjectDistance { in_space, from_space, on_curve }
    }

    /// The curve through the views that have a pose, if there are three.
    pub fn manifold(&self) -> Option<&Manifold> {
        self.manifold.as_ref()
    }

    /// The eigenpoint of the nearest view that is not on the manifold; the mean's where all are.
    pub fn nearest_view(&self, point: &[f32]) -> Vec<f32> {
        let isolated = self.isolated.chunks_exact(self.dimension.max(1));
        let apart = |view: &&[f32]| euclidean_distance(view, point);
        let nearest = isolated.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.map_or_else(|| vec![0.0; self.dimension], <[f32]>::to_vec)
    }

    /// Indices of the poses before and after a pose; `None` without any.
    fn neighbours(&self, pose_deg: f64) -> Option<(usize, usize)> {
        let count = self.poses_deg.len();
        let after = self.poses_deg.partition_point(|&pose| pose < pose_deg);
        (count > 0).then(|| ((after + count - 1) % count, after % count))
    }

    /// From the pose of a view before a pose to that of the one after it; `None` without any.
    pub fn gap_deg(&self, pose_deg: f64) -> Option<f64> {
        let (before, after) = self.neighbours(pose_deg)?;
        Some((self.poses_deg[after] - self.poses_deg[before]).rem_euclid(360.0))
    }

    /// The distance of a point from the curve between the views before and after a pose: the error of interpolation
    /// there, though the object may look much the same elsewhere.
    pub fn distance_in_gap(&self, point: &[f32], from_space: f64, pose_deg: f64) -> Option<GapDistance> {
        let (before, after) = self.neighbours(pose_deg)?;
        let (from_deg, to_deg) = (self.poses_deg[before], self.poses_deg[after]);
        let nearest = self.manifold.as_ref()?.nearest_between(point, from_deg, to_deg)?;
        let gap_deg = (to_deg - from_deg).rem_euclid(360.0);
        Some(GapDistance { distance: nearest.distance.hypot(from_space), gap_deg })
    }

    pub fn bytes(&self) -> usize {
        8 * self.poses_deg.len() + self.manifold.as_ref().map_or(0, Manifold::bytes) + 4 * self.isolated.len()
    }
}

/// One known object.
#[derive(Clone, Debug)]
pub(super) struct KnownObject {
    pub label: String,
    pub part: ObjectPart,
    /// In its own eigenspace or the universal one.
    pub views: ViewSet,
}

impl KnownObject {
    /// The distance of a query.
    pub fn distance(&self, query: &Query) -> ObjectDistance {
        match &self.part.space {
            None => self.views.distance(&query.point, query.distance_from_space),
            Some(space) => {
                let (point, from_space) = space.locate(query.vector);
                self.views.distance(&point, from_space)
            }
        }
    }

    /// Distances from the object are judged relative to this.
    pub fn root_scale(&self) -> f64 {
        self.part.scale.map_or(1.0, f64::sqrt)
    }

    /// The pose at a distance. `tangential_part` and `distance_ratio` are those of the database's
    /// [`Acceptance`](super::acceptance::Acceptance).
    pub fn pose(&self, distance: &ObjectDistance, tangential_part: f64, distance_ratio: f64) -> Option<Pose> {
        let CurveProjection { nearest, second } = distance.on_curve?;
        let turn_deg = nearest.turn_deg;
        // a small residual may be chance
        let residual = nearest.distance.hypot(distance.from_space).max(self.part.typical_distance);
        let by_residual = tangential_part * residual / nearest.speed_per_deg;
        let sigma_deg = match self.held_out_sigma_deg(turn_deg, distance_ratio) {
            Some(held_out_deg) if by_residual.is_finite() => by_residual.max(held_out_deg),
            _ => UNKNOWN_DEG,
        };
        let alternative_deg = second
            .filter(|second| second.distance.hypot(distance.from_space) <= AMBIGUOUS * residual)
            .map(|second| second.turn_deg);
        // a view without a pose may be nearer than the curve
        let is_on_curve = distance.in_space >= nearest.distance;
        let reliable = self.views.poses_deg.len() >= MIN_VIEWS
            && sigma_deg <= MAX_SIGMA_DEG
            && alternative_deg.is_none()
            && !self.is_in_wide_gap(turn_deg)
            && is_on_curve
            && !nearest.at_end;
        Some(Pose { turn_deg, sigma_deg: sigma_deg.min(UNKNOWN_DEG), reliable, alternative_deg })
    }

    /// The pose of an aligned fit; `second` is the best one at another turn.
    pub fn aligned_pose(&self, nearest: &Fit, second: Option<&Fit>, acceptance: &Acceptance) -> Option<Pose> {
        let turn_deg = nearest.turn_deg?;
        let sigma_deg = match self.held_out_sigma_deg(turn_deg, acceptance.distance_ratio) {
            Some(held_out_deg) if nearest.turn_sigma_deg.is_finite() => {
                (acceptance.tangential_part * nearest.turn_sigma_deg).max(held_out_deg)
            }
            _ => UNKNOWN_DEG,
        };
        let typical = self.part.typical_distance.powi(2);
        let alternative_deg = second
            .filter(|second| second.cost <= AMBIGUOUS.powi(2) * nearest.cost.max(typical))
            .and_then(|second| second.turn_deg);
        let reliable = self.views.poses_deg.len() >= MIN_VIEWS
            && sigma_deg <= MAX_SIGMA_DEG
            && alternative_deg.is_none()
            && !self.is_in_wide_gap(turn_deg)
            && !nearest.at_end;
        Some(Pose { turn_deg, sigma_deg: sigma_deg.min(UNKNOWN_DEG), reliable, alternative_deg })
    }

    fn is_in_wide_gap(&self, turn_deg: f64) -> bool {
        wide_gaps(&self.views.poses_deg).into_iter().any(|gap| {
            let width_deg = (gap.to_deg - gap.from_deg).rem_euclid(360.0);
            (turn_deg - gap.from_deg).rem_euclid(360.0) < width_deg && turn_deg != gap.from_deg
        })
    }

    /// The larger of the held-out errors of the views on both sides of a pose, as a query has it, and no less than a
    /// part of the gap between them.
    fn held_out_sigma_deg(&self, turn_deg: f64, distance_ratio: f64) -> Option<f64> {
        let errors_deg = &self.part.held_out_deg;
        if errors_deg.is_empty() {
            return None;
        }
        let (before, after) = self.views.neighbours(turn_deg)?;
        let gap_deg = (self.views.poses_deg[after] - self.views.poses_deg[before]).rem_euclid(360.0);
        let error_deg = errors_deg[after].max(errors_deg[before]);
        Some((distance_ratio * error_deg).max(MIN_SIGMA_OF_GAP * gap_deg))
    }

    pub fn bytes(&self) -> usize {
        let ObjectPart { space, eigenpoints, held_out_deg, .. } = &self.part;
        let space = space.as_ref().map_or(0, |space| 4 * (space.mean.len() + space.basis.len()));
        let numbers = space + 4 * eigenpoints.len() + 8 * held_out_deg.len();
        size_of::<Self>() + self.label.len() + self.views.bytes() + numbers
    }
}
