//! One known object: its eigenspace, its views there, and the curve through those that have a pose.

use super::manifold::{Foot, Manifold, different, wide_gaps};
use super::recognition::Pose;
use crate::eigen::Eigenspace;

/// B§6: fewer views give no pose to rely on.
const LEAST_VIEWS: usize = 10;
/// A pose is relied on up to this: then 2.5 of them lie within 5°.
const MOST_SIGMA_DEG: f64 = 2.0;
/// Another pose is an alternative if its distance is at most so many times that of the nearest.
const AMBIGUOUS: f64 = 1.2;
/// Between two views a pose is never known better than to this part of the gap: a view that is left out stands in
/// the middle of its neighbours, where an interpolation's errors cancel.
const FINEST_PART: f64 = 0.01;
/// No more is known about a pose than that it is one.
const UNKNOWN_DEG: f64 = 180.0;

/// Views of an object as eigenpoints, in whatever space.
#[derive(Clone, Debug)]
pub(super) struct ViewSet {
    dimension: usize,
    /// Poses that a view has, ascending, each once.
    pub poses_deg: Vec<f64>,
    /// Through the eigenpoints at these poses; of several at one pose their mean.
    manifold: Option<Manifold>,
    /// Eigenpoints of views that are not on a manifold, n × dimension.
    loose: Vec<f32>,
}

/// How near a picture is to an object.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closeness {
    pub in_space: f64,
    pub from_space: f64,
    /// The nearest point of the manifold, and the nearest that is another pose.
    pub feet: Option<(Foot, Option<Foot>)>,
}

impl Closeness {
    /// The distance between the pictures: √(in² + from²).
    pub fn total(&self) -> f64 {
        self.in_space.hypot(self.from_space)
    }
}

impl ViewSet {
    /// Of n × `dimension` eigenpoints and their poses.
    pub fn new(points: &[f32], poses_deg: &[Option<f64>], dimension: usize) -> ViewSet {
        let point = |view: usize| &points[view * dimension..][..dimension];
        let (poses, which) = different(poses_deg);
        let mut knots = Vec::with_capacity(poses.len() * dimension);
        for number in 0..poses.len() {
            let same: Vec<usize> = (0..which.len()).filter(|&view| which[view] == Some(number)).collect();
            knots.extend((0..dimension).map(|k| {
                let sum: f64 = same.iter().map(|&view| f64::from(point(view)[k])).sum();
                (sum / same.len() as f64) as f32
            }));
        }
        let manifold = Manifold::through(&poses, &knots, dimension);
        let is_loose = |view: &usize| manifold.is_none() || poses_deg[*view].is_none();
        let loose = (0..poses_deg.len()).filter(is_loose).flat_map(point).copied().collect();
        ViewSet { dimension, poses_deg: poses, manifold, loose }
    }

    /// How near a point of the space is that lies `from_space` outside of it.
    pub fn closeness(&self, point: &[f32], from_space: f64) -> Closeness {
        let feet = self.manifold.as_ref().map(|manifold| manifold.nearest(point));
        // without a coordinate all views stand at the mean
        let alone = if self.dimension == 0 { 0.0 } else { f64::INFINITY };
        let loose = self.loose.chunks_exact(self.dimension.max(1)).map(|view| {
            let pairs = view.iter().zip(point);
            pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>().sqrt()
        });
        let nearest = loose.fold(alone, f64::min);
        let in_space = feet.map_or(nearest, |(foot, _)| foot.distance.min(nearest));
        Closeness { in_space, from_space, feet }
    }

    /// Which of the poses stand before and after a pose; `None` without any.
    fn about(&self, pose_deg: f64) -> Option<(usize, usize)> {
        let count = self.poses_deg.len();
        let after = self.poses_deg.partition_point(|&pose| pose < pose_deg);
        (count > 0).then(|| ((after + count - 1) % count, after % count))
    }

    /// How far a point is from the curve between the views before and after a pose, and how wide that gap is: what
    /// interpolation misses there, though the object may look much the same elsewhere.
    pub fn distance_in_gap(&self, point: &[f32], from_space: f64, pose_deg: f64) -> Option<(f64, f64)> {
        let (before, after) = self.about(pose_deg)?;
        let (from_deg, to_deg) = (self.poses_deg[before], self.poses_deg[after]);
        let foot = self.manifold.as_ref()?.nearest_between(point, from_deg, to_deg)?;
        Some((foot.distance.hypot(from_space), (to_deg - from_deg).rem_euclid(360.0)))
    }

    pub fn bytes(&self) -> usize {
        8 * self.poses_deg.len() + self.manifold.as_ref().map_or(0, Manifold::bytes) + 4 * self.loose.len()
    }
}

/// One known object.
#[derive(Clone, Debug)]
pub(super) struct KnownObject {
    pub label: String,
    /// Its own eigenspace; `None`: the universal one.
    pub space: Option<Eigenspace>,
    pub views: ViewSet,
    /// How far a held-out view was from the others: root mean square. `None` if there is one view.
    pub scale: Option<f64>,
    /// How far the usual query is, as held-out views lead one to expect.
    pub usual: f64,
    /// By how much the pose of a view was missed when the views at that pose were left out; as `views.poses_deg`, or
    /// empty.
    pub held_out_deg: Vec<f64>,
    /// The eigenpoints of all its views in its own space or the universal one, in their order.
    pub points: Vec<f32>,
}

impl KnownObject {
    /// How near an appearance is. `universal` is its eigenpoint and distance from the universal eigenspace.
    pub fn closeness(&self, vector: &[f32], universal: (&[f32], f64)) -> Closeness {
        match &self.space {
            None => self.views.closeness(universal.0, universal.1),
            Some(space) => {
                let (point, outside) = space.locate(vector);
                self.views.closeness(&point, outside)
            }
        }
    }

    /// The pose that a closeness tells. `angle_part` is the part of the residual that turns the pose, `shrink` how
    /// much nearer a query is than a held-out view.
    pub fn pose(&self, closeness: &Closeness, angle_part: f64, shrink: f64) -> Option<Pose> {
        let (foot, second) = closeness.feet?;
        let turn_deg = foot.turn_deg;
        // a lucky residual is no knowledge
        let residual = foot.distance.hypot(closeness.from_space).max(self.usual);
        let by_residual = angle_part * residual / foot.speed_per_deg;
        // nearer to a view without a pose than to the curve
        let is_elsewhere = closeness.in_space < foot.distance;
        let sigma_deg = match self.held_out_about(turn_deg) {
            Some((held_out_deg, gap_deg)) if by_residual.is_finite() => {
                by_residual.max(shrink * held_out_deg).max(FINEST_PART * gap_deg)
            }
            _ => UNKNOWN_DEG,
        };
        let alternative_deg = second
            .filter(|second| second.distance.hypot(closeness.from_space) <= AMBIGUOUS * residual)
            .map(|second| second.turn_deg);
        let in_gap = wide_gaps(&self.views.poses_deg).into_iter().any(|(from, to)| {
            (turn_deg - from).rem_euclid(360.0) < (to - from).rem_euclid(360.0) && turn_deg != from
        });
        let reliable = self.views.poses_deg.len() >= LEAST_VIEWS
            && sigma_deg <= MOST_SIGMA_DEG
            && alternative_deg.is_none()
            && !in_gap
            && !is_elsewhere
            && !foot.at_end;
        Some(Pose { turn_deg, sigma_deg: sigma_deg.min(UNKNOWN_DEG), reliable, alternative_deg })
    }

    /// The larger of the held-out errors of the views on both sides of a pose, and how far apart these are.
    fn held_out_about(&self, turn_deg: f64) -> Option<(f64, f64)> {
        if self.held_out_deg.is_empty() {
            return None;
        }
        let (before, after) = self.views.about(turn_deg)?;
        let gap_deg = (self.views.poses_deg[after] - self.views.poses_deg[before]).rem_euclid(360.0);
        Some((self.held_out_deg[after].max(self.held_out_deg[before]), gap_deg))
    }

    pub fn bytes(&self) -> usize {
        let space = self.space.as_ref().map_or(0, |space| 4 * (space.mean.len() + space.basis.len()));
        self.label.len()
            + space
            + self.views.bytes()
            + 8 * self.held_out_deg.len()
            + 4 * self.points.len()
            + size_of::<Self>()
    }
}
