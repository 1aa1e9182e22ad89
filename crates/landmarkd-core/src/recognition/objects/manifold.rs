//! The appearance manifold of an object: the curve that its eigenpoints follow as it turns.
//!
//! A cubic spline through the eigenpoints in the order of their poses, with pose in degrees as its parameter
//! (Murase and Nayar 1995). It is closed and periodic when the views go round, and an open arc with natural ends when
//! they leave a wide part of the circle out. Views need not be equally spaced.

use super::report::Gap;
use crate::angle::angular_distance_deg;
use crate::statistics::median;

/// A gap wider than this and than [`OPEN_GAP_FACTOR`] times the median gap leaves the curve open there.
const OPEN_GAP_DEG: f64 = 60.0;
const OPEN_GAP_FACTOR: f64 = 3.0;
/// A gap that is reported, and in which no pose is reliable, is wider than this in any case: B§6 asks for ten
/// views …
const WIDE_GAP_DEG: f64 = 36.0;
/// … or wider than this many times the median gap, and than a few degrees.
const WIDE_GAP_FACTOR: f64 = 2.5;
const MIN_WIDE_GAP_DEG: f64 = 15.0;
/// The curve is sampled about so often, for the start of the search.
const SAMPLES: usize = 288;
const NEWTON_STEPS: usize = 4;
/// Two poses nearer than this are one pose.
const SEPARATION_DEG: f64 = 15.0;
/// Poses that differ by no more are one: a spline through two pictures of nearly one pose would swing between them.
pub(super) const ONE_POSE_DEG: f64 = 0.5;

/// The curve of one object.
#[derive(Clone, Debug)]
pub(super) struct Manifold {
    /// Ascending; the first in [0, 360), the last less than 360 beyond it.
    knots_deg: Vec<f64>,
    /// knots × dimension, row-major.
    points: Vec<f64>,
    /// At the knots, per degree²; knots × dimension.
    second_derivatives: Vec<f64>,
    dimension: usize,
    closed: bool,
    /// Points of the curve, [`Manifold::per_segment`] from each knot on.
    samples: Vec<f32>,
    per_segment: usize,
}

/// A point of the curve that is near a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CurvePoint {
    /// In [0, 360).
    pub turn_deg: f64,
    pub distance: f64,
    /// Length of the curve's derivative there.
    pub speed_per_deg: f64,
    /// It is the end of an open arc: the object may be turned further.
    pub at_end: bool,
}

/// The point of the curve nearest to a query, and the nearest that is another pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveProjection {
    pub nearest: CurvePoint,
    pub second: Option<CurvePoint>,
}

/// One coordinate of the curve and its derivatives by the turn in degrees.
#[derive(Clone, Copy, Debug)]
struct Coordinate {
    value: f64,
    first: f64,
    second: f64,
}

/// The different ones among the poses of views.
pub(super) struct DistinctPoses {
    /// Ascending.
    pub poses_deg: Vec<f64>,
    /// Index into `poses_deg` for each view; `None` for one without a pose.
    pub of_view: Vec<Option<usize>>,
}

impl DistinctPoses {
    pub fn of(poses_deg: &[Option<f64>]) -> DistinctPoses {
        let mut posed: Vec<(f64, usize)> =
            poses_deg.iter().enumerate().filter_map(|(view, pose)| Some(((*pose)?, view))).collect();
        posed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut groups: Vec<Vec<(f64, usize)>> = Vec::new();
        for view in posed {
            match groups.last_mut() {
                Some(group) if view.0 - group[0].0 <= ONE_POSE_DEG => group.push(view),
                _ => groups.push(vec![view]),
            }
        }
        let mean =
            |group: &Vec<(f64, usize)>| group.iter().map(|(pose, _)| pose).sum::<f64>() / group.len() as f64;
        let mut distinct: Vec<f64> = groups.iter().map(mean).collect();
        // across 0 the last are the first
        if groups.len() > 1 && angular_distance_deg(distinct[0], distinct[groups.len() - 1]) <= ONE_POSE_DEG {
            distinct.pop();
            let last = groups.pop().unwrap_or_default();
            groups[0].extend(last);
        }
        let mut of_view = vec![None; poses_deg.len()];
        for (index, group) in groups.iter().enumerate() {
            group.iter().for_each(|&(_, view)| of_view[view] = Some(index));
        }
        DistinctPoses { poses_deg: distinct, of_view }
    }
}

/// The gaps from each of ascending poses to the next, round the circle.
pub(super) fn gaps(poses_deg: &[f64]) -> Vec<f64> {
    let next = poses_deg.iter().skip(1).copied().chain([poses_deg[0] + 360.0]);
    next.zip(poses_deg).map(|(next, pose)| next - pose).collect()
}

fn median_gap(gaps_deg: &[f64]) -> f64 {
    median(&mut gaps_deg.to_vec(), f64::total_cmp).unwrap_or(0.0)
}

/// The wide gaps between ascending poses.
pub(super) fn wide_gaps(poses_deg: &[f64]) -> Vec<Gap> {
    if poses_deg.len() < 2 {
        return Vec::new();
    }
    let gaps = gaps(poses_deg);
    let most = (WIDE_GAP_FACTOR * median_gap(&gaps)).clamp(MIN_WIDE_GAP_DEG, WIDE_GAP_DEG);
    let wide = (0..gaps.len()).filter(|&i| gaps[i] > most + 1e-9);
    wide.map(|i| Gap { from_deg: poses_deg[i], to_deg: poses_deg[(i + 1) % gaps.len()] }).collect()
}

impl Manifold {
    /// The curve through knots × `dimension` row-major points at ascending poses in [0, 360); `None` for fewer than
    /// three.
    pub fn through(poses_deg: &[f64], points: &[f32], dimension: usize) -> Option<Manifold> {
        let count = poses_deg.len();
        if count < 3 || dimension == 0 {
            return None;
        }
        let gaps = gaps(poses_deg);
        let widest = (0..count).max_by(|&a, &b| gaps[a].total_cmp(&gaps[b])).unwrap_or(0);
        let closed = gaps[widest] <= OPEN_GAP_DEG.max(OPEN_GAP_FACTOR * median_gap(&gaps));
        // an open arc begins behind the gap
        let first = if closed { 0 } else { (widest + 1) % count };
        let order = (0..count).map(|i| (first + i) % count);
        let knots_deg: Vec<f64> =
            order.clone().map(|i| poses_deg[i] + if i < first { 360.0 } else { 0.0 }).collect();
        let points: Vec<f64> =
            order.flat_map(|i| &points[i * dimension..][..dimension]).map(|&v| f64::from(v)).collect();
        let second_derivatives = second_derivatives(&knots_deg, &points, dimension, closed);
        let segments = if closed { count } else { count - 1 };
        let per_segment = SAMPLES.div_ceil(segments).clamp(2, 16);
        let samples = Vec::new();
        let mut curve =
            Manifold { knots_deg, points, second_derivatives, dimension, closed, samples, per_segment };
        let count = segments * per_segment + if closed { 0 } else { 1 };
        let samples = (0..count).flat_map(|sample| curve.at(curve.sample_deg(sample)));
        curve.samples = samples.map(|coordinate| coordinate.value as f32).collect();
        Some(curve)
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        8 * (self.knots_deg.len() + self.points.len() + self.second_derivatives.len())
            + 4 * self.samples.len()
    }

    fn end_deg(&self) -> f64 {
        match self.closed {
            true => self.knots_deg[0] + 360.0,
            false => self.knots_deg[self.knots_deg.len() - 1],
        }
    }

    fn sample_deg(&self, sample: usize) -> f64 {
        let (segment, part) = (sample / self.per_segment, sample % self.per_segment);
        let Some(&from) = self.knots_deg.get(segment) else { return self.end_deg() };
        let to = self.knots_deg.get(segment + 1).copied().unwrap_or(self.end_deg());
        from + (to - from) * part as f64 / self.per_segment as f64
    }

    /// The coordinates of the curve at `turn_deg`, which lies between the first knot and the end.
    fn at(&self, turn_deg: f64) -> impl Iterator<Item = Coordinate> {
        let count = self.knots_deg.len();
        let last = if self.closed { count - 1 } else { count - 2 };
        let segment = self.knots_deg.partition_point(|&knot| knot <= turn_deg).saturating_sub(1).min(last);
        let next = (segment + 1) % count;
        let to = self.knots_deg.get(segment + 1).copied().unwrap_or(self.end_deg());
        let h = to - self.knots_deg[segment];
        let (a, b) = ((to - turn_deg) / h, (turn_deg - self.knots_deg[segment]) / h);
        let row = |values: &'_ [f64], row: usize, k: usize| values[row * self.dimension + k];
        (0..self.dimension).map(move |k| {
            let (p, q) = (row(&self.points, segment, k), row(&self.points, next, k));
            let (m, n) = (row(&self.second_derivatives, segment, k), row(&self.second_derivatives, next, k));
            Coordinate {
                value: a * p + b * q + ((a.powi(3) - a) * m + (b.powi(3) - b) * n) * h * h / 6.0,
                first: (q - p) / h + ((1.0 - 3.0 * a * a) * m + (3.0 * b * b - 1.0) * n) * h / 6.0,
                second: a * m + b * n,
            }
        })
    }

    /// The point of the curve at a turn, of an open arc at its end if it is beyond.
    pub fn point(&self, turn_deg: f64) -> Vec<f32> {
        self.at(self.held(turn_deg)).map(|coordinate| coordinate.value as f32).collect()
    }

    /// The turn itself if the curve is closed, else the nearest one on the arc.
    pub fn held(&self, turn_deg: f64) -> f64 {
        let (first, end) = (self.knots_deg[0], self.end_deg());
        let turn_deg = first + (turn_deg - first).rem_euclid(360.0);
        match self.closed || turn_deg <= end {
            true => turn_deg,
            false if turn_deg - end > first + 360.0 - turn_deg => first,
            false => end,
        }
    }

    /// Whether a turn is at an end of an open arc, or beyond.
    pub fn is_end(&self, turn_deg: f64) -> bool {
        let held = self.held(turn_deg);
        !self.closed && (held <= self.knots_deg[0] || held >= self.end_deg())
    }

    /// The points of the curve nearest to a query: from the nearest samples by Newton's method on half the squared
    /// distance.
    pub fn project(&self, query: &[f32]) -> CurveProjection {
        let squares: Vec<f32> =
            self.samples.chunks_exact(self.dimension).map(|sample| squared_distance(sample, query)).collect();
        let count = squares.len();
        let best = (0..count).fold(0, |best, i| if squares[i] < squares[best] { i } else { best });
        let nearest = self.refined(best, query);
        let is_minimum = |i: usize| {
            let (before, after) = match self.closed {
                true => (squares[(i + count - 1) % count], squares[(i + 1) % count]),
                false => (
                    if i == 0 { f32::INFINITY } else { squares[i - 1] },
                    squares.get(i + 1).copied().unwrap_or(f32::INFINITY),
                ),
            };
            squares[i] <= before && squares[i] <= after
        };
        let is_other = |i: usize| angular_distance_deg(self.sample_deg(i), nearest.turn_deg) > SEPARATION_DEG;
        let second = (0..count)
            .filter(|&i| is_minimum(i) && is_other(i))
            .min_by(|&a, &b| squares[a].total_cmp(&squares[b]))
            .map(|sample| self.refined(sample, query));
        CurveProjection { nearest, second }
    }

    /// The point nearest to a query among those from one pose on to another.
    pub fn nearest_between(&self, query: &[f32], from_deg: f64, to_deg: f64) -> Option<CurvePoint> {
        let reach = (to_deg - from_deg).rem_euclid(360.0);
        (0..self.samples.len() / self.dimension)
            .filter(|&sample| (self.sample_deg(sample) - from_deg).rem_euclid(360.0) <= reach)
            .map(|sample| {
                (squared_distance(&self.samples[sample * self.dimension..][..self.dimension], query), sample)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, sample)| self.refined(sample, query))
    }

    /// The nearest point between the samples before and after a sample, or the sample itself if that is nearer.
    fn refined(&self, sample: usize, query: &[f32]) -> CurvePoint {
        let start = self.sample_deg(sample);
        let mut turn_deg = self.newton(sample, query);
        let (mut found, begun) = (self.offset(turn_deg, query), self.offset(start, query));
        if begun.square < found.square {
            (turn_deg, found) = (start, begun);
        }
        let at_end = !self.closed && (turn_deg <= self.knots_deg[0] || turn_deg >= self.end_deg());
        CurvePoint {
            // rounding may give 360 itself
            turn_deg: turn_deg.rem_euclid(360.0) % 360.0,
            distance: found.square.sqrt(),
            speed_per_deg: found.squared_speed.sqrt(),
            at_end,
        }
    }

    /// Where Newton's method ends that starts at a sample and stays between its neighbours, or the end of an open arc.
    fn newton(&self, sample: usize, query: &[f32]) -> f64 {
        let start = self.sample_deg(sample);
        let last = self.samples.len() / self.dimension - 1;
        let before = match sample {
            0 if self.closed => self.end_deg() - self.sample_deg(last),
            0 => 0.0,
            _ => start - self.sample_deg(sample - 1),
        };
        let least = start - before;
        let most = if sample == last { self.end_deg() } else { self.sample_deg(sample + 1) };
        let mut turn_deg = start;
        for _ in 0..NEWTON_STEPS {
            let (mut slope, mut curvature) = (0.0, 0.0);
            for (coordinate, &q) in self.at(self.wrapped(turn_deg)).zip(query) {
                let offset = coordinate.value - f64::from(q);
                slope += offset * coordinate.first;
                curvature += coordinate.first * coordinate.first + offset * coordinate.second;
            }
            // without a positive curvature there is no minimum to step to
            if curvature <= 0.0 {
                break;
            }
            turn_deg = (turn_deg - slope / curvature).clamp(least, most);
        }
        turn_deg
    }

    /// The turn between the first knot and the end.
    fn wrapped(&self, turn_deg: f64) -> f64 {
        match self.closed {
            true => self.knots_deg[0] + (turn_deg - self.knots_deg[0]).rem_euclid(360.0),
            false => turn_deg,
        }
    }

    fn offset(&self, turn_deg: f64, query: &[f32]) -> Offset {
        let none = Offset { square: 0.0, squared_speed: 0.0 };
        self.at(self.wrapped(turn_deg)).zip(query).fold(none, |sum, (coordinate, &q)| Offset {
            square: sum.square + (coordinate.value - f64::from(q)).powi(2),
            squared_speed: sum.squared_speed + coordinate.first * coordinate.first,
        })
    }
}

/// Of a point of the curve from a query.
struct Offset {
    /// Squared distance.
    square: f64,
    squared_speed: f64,
}

fn squared_distance(a: &[f32], b: &[f32]) -> f32 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += (a[lane] - b[lane]) * (a[lane] - b[lane]);
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| (a - b) * (a - b)).sum();
    sums.iter().sum::<f32>() + rest
}

/// Second derivatives at the knots: those that make the first ones continuous.
///
/// hᵢ₋₁ mᵢ₋₁ + 2 (hᵢ₋₁ + hᵢ) mᵢ + hᵢ mᵢ₊₁ = 6 ((yᵢ₊₁ − yᵢ)/hᵢ − (yᵢ − yᵢ₋₁)/hᵢ₋₁), cyclic when closed, and m = 0 at
/// the ends of an open arc.
fn second_derivatives(knots_deg: &[f64], points: &[f64], dimension: usize, closed: bool) -> Vec<f64> {
    let count = knots_deg.len();
    let gap = |i: usize| match knots_deg.get(i + 1) {
        Some(next) => next - knots_deg[i],
        None => knots_deg[0] + 360.0 - knots_deg[i],
    };
    // the unknowns: all knots, or the inner ones
    let first = if closed { 0 } else { 1 };
    let unknowns = if closed { count } else { count - 2 };
    let mut diagonal = Vec::with_capacity(unknowns);
    let mut right = Vec::with_capacity(unknowns * dimension);
    for i in first..first + unknowns {
        let (before, after) = ((i + count - 1) % count, (i + 1) % count);
        let (h, g) = (gap(before), gap(i));
        diagonal.push(2.0 * (h + g));
        for k in 0..dimension {
            let y = |row: usize| points[row * dimension + k];
            right.push(6.0 * ((y(after) - y(i)) / g - (y(i) - y(before)) / h));
        }
    }
    // between unknowns i and i + 1
    let off_diagonal: Vec<f64> = (first..first + unknowns).map(gap).collect();
    match closed {
        true => cyclic(diagonal, &off_diagonal, right, dimension),
        false => {
            let inner = tridiagonal(diagonal, &off_diagonal, right, dimension);
            [vec![0.0; dimension], inner, vec![0.0; dimension]].concat()
        }
    }
}

/// Thomas' algorithm for a symmetric tridiagonal matrix and `width` right sides at once; `off_diagonal[i]` is between
/// i and i + 1.
fn tridiagonal(mut diagonal: Vec<f64>, off_diagonal: &[f64], mut right: Vec<f64>, width: usize) -> Vec<f64> {
    let count = diagonal.len();
    for i in 1..count {
        let factor = off_diagonal[i - 1] / diagonal[i - 1];
        diagonal[i] -= factor * off_diagonal[i - 1];
        let (done, rest) = right.split_at_mut(i * width);
        let before = &done[(i - 1) * width..];
        rest[..width].iter_mut().zip(before).for_each(|(r, b)| *r -= factor * b);
    }
    for i in (0..count).rev() {
        let (rest, done) = right.split_at_mut((i + 1) * width);
        for (k, r) in rest[i * width..].iter_mut().enumerate() {
            let after = if i + 1 < count { off_diagonal[i] * done[k] } else { 0.0 };
            *r = (*r - after) / diagonal[i];
        }
    }
    right
}

/// The same with `off_diagonal[count − 1]` in the corners (Sherman-Morrison); three unknowns at least.
fn cyclic(mut diagonal: Vec<f64>, off_diagonal: &[f64], right: Vec<f64>, width: usize) -> Vec<f64> {
    let count = diagonal.len();
    let corner = off_diagonal[count - 1];
    let gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[count - 1] -= corner * corner / gamma;
    let mut update = vec![0.0; count];
    (update[0], update[count - 1]) = (gamma, corner);
    let update = tridiagonal(diagonal.clone(), off_diagonal, update, 1);
    let mut solved = tridiagonal(diagonal, off_diagonal, right, width);
    let share = 1.0 + update[0] + corner / gamma * update[count - 1];
    let factors: Vec<f64> =
        (0..width).map(|k| (solved[k] + corner / gamma * solved[(count - 1) * width + k]) / share).collect();
    for (row, &u) in solved.chunks_exact_mut(width).zip(&update) {
        row.iter_mut().zip(&factors).for_each(|(s, f)| *s -= f * u);
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve that never meets itself.
    fn wave(turn_deg: f64) -> [f32; 3] {
        let t = turn_deg.to_radians();
        [t.cos() as f32, t.sin() as f32, 0.3 * (3.0 * t).sin() as f32]
    }

    fn through(poses: &[f64]) -> Manifold {
        let points: Vec<f32> = poses.iter().flat_map(|&pose| wave(pose)).collect();
        Manifold::through(poses, &points, 3).unwrap()
    }

    #[test]
    fn poses_between_the_views_are_found() {
        let poses: Vec<f64> =
            (0..24).map(|i| 15.0 * f64::from(i) + if i % 3 == 0 { 4.0 } else { 0.0 }).collect();
        let curve = through(&poses);
        for turn in (0..360).step_by(7).map(f64::from) {
            let foot = curve.project(&wave(turn)).nearest;
            assert!(angular_distance_deg(foot.turn_deg, turn) < 0.1, "{turn}: {foot:?}");
            assert!(foot.distance < 0.003 && !foot.at_end);
            // |d/dt| per degree of a circle of radius 1 with a ripple
            assert!((0.016..0.025).contains(&foot.speed_per_deg));
        }
    }

    #[test]
    fn the_spline_goes_through_its_points_and_is_smooth_everywhere() {
        for poses in [
            vec![3.0, 50.0, 110.0, 190.0, 200.0, 290.0],
            (0..12).map(|i| 100.0 + 9.0 * f64::from(i)).collect(),
        ] {
            let curve = through(&poses);
            assert_eq!(curve.closed, poses.len() == 6);
            for &pose in &poses {
                let foot = curve.project(&wave(pose)).nearest;
                assert!(
                    foot.distance < 1e-6 && angular_distance_deg(foot.turn_deg, pose) < 1e-3,
                    "{pose}: {foot:?}"
                );
            }
            for &knot in &curve.knots_deg[1..curve.knots_deg.len() - 1] {
                let (left, right) = (curve.at(knot - 1e-7), curve.at(knot));
                for (l, r) in left.zip(right) {
                    for (left, right) in [(l.value, r.value), (l.first, r.first), (l.second, r.second)] {
                        assert!((left - right).abs() < 1e-6, "{l:?} and {r:?} at {knot}");
                    }
                }
            }
        }
    }

    #[test]
    fn an_open_arc_ends_where_its_views_end() {
        // across 0
        let poses: Vec<f64> = vec![0.0, 10.0, 20.0, 30.0, 40.0, 320.0, 330.0, 340.0, 350.0];
        let curve = through(&poses);
        assert!(!curve.closed);
        let inside = curve.project(&wave(355.0)).nearest;
        assert!(angular_distance_deg(inside.turn_deg, 355.0) < 0.2 && !inside.at_end);
        for (asked, end) in [(60.0, 40.0), (290.0, 320.0)] {
            let foot = curve.project(&wave(asked)).nearest;
            assert!(foot.at_end && angular_distance_deg(foot.turn_deg, end) < 1e-9, "{foot:?}");
        }
        assert_eq!(wide_gaps(&poses), [Gap { from_deg: 40.0, to_deg: 320.0 }]);
    }

    #[test]
    fn a_symmetric_object_has_a_second_pose() {
        let poses: Vec<f64> = (0..36).map(|i| 10.0 * f64::from(i)).collect();
        let points: Vec<f32> = poses.iter().flat_map(|&pose| wave(2.0 * pose)).collect();
        let curve = Manifold::through(&poses, &points, 3).unwrap();
        let CurveProjection { nearest, second } = curve.project(&wave(2.0 * 33.0));
        let mut turns = [nearest.turn_deg, second.unwrap().turn_deg];
        turns.sort_by(f64::total_cmp);
        assert!((turns[0] - 33.0).abs() < 0.1 && (turns[1] - 213.0).abs() < 0.1, "{turns:?}");
        let asymmetric = through(&poses).project(&wave(33.0));
        assert!(asymmetric.second.is_none_or(|second| second.distance > 0.5));
    }

    #[test]
    fn gaps_are_wide_by_themselves_or_beside_the_others() {
        let every = |step: usize| (0..360).step_by(step).map(|pose| pose as f64).collect::<Vec<f64>>();
        assert_eq!(wide_gaps(&every(10)), []);
        assert_eq!(wide_gaps(&every(36)), []);
        assert_eq!(wide_gaps(&every(40)).len(), 9);
        let missing: Vec<f64> =
            every(10).into_iter().filter(|&pose| !(120.0..160.0).contains(&pose)).collect();
        assert_eq!(wide_gaps(&missing), [Gap { from_deg: 110.0, to_deg: 160.0 }]);
    }

    #[test]
    fn poses_that_hardly_differ_are_one() {
        let poses = [Some(10.2), None, Some(0.1), Some(359.9), Some(10.0), Some(90.0)];
        let distinct = DistinctPoses::of(&poses);
        assert_eq!(distinct.poses_deg.len(), 3);
        assert!((distinct.poses_deg[1] - 10.1).abs() < 1e-9);
        assert_eq!(distinct.of_view, [Some(1), None, Some(0), Some(0), Some(1), Some(2)]);
    }

    #[test]
    fn fewer_than_three_views_make_no_curve() {
        assert!(Manifold::through(&[0.0, 90.0], &[0.0, 1.0], 1).is_none());
    }
}
