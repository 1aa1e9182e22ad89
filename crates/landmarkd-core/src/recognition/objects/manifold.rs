//! The appearance manifold of an object: the curve that its eigenpoints follow as it turns.
//!
//! A cubic spline through the eigenpoints in the order of their poses, with pose in degrees as its parameter
//! (Murase and Nayar 1995). It is closed and periodic when the views go round, and an open arc with natural ends when
//! they leave a wide part of the circle out. Views need not be equally spaced.

/// Views further apart than this and more than [`GAP_PARTS`] times the usual leave the curve open there.
const OPEN_GAP_DEG: f64 = 60.0;
const GAP_PARTS: f64 = 3.0;
/// A gap that is reported, and in which no pose is reliable, is wider than this in any case: B§6 asks for ten
/// views …
const WIDE_GAP_DEG: f64 = 36.0;
/// … or wider than this many times the usual gap, and than a few degrees.
const UNUSUAL_PARTS: f64 = 2.5;
const NARROW_GAP_DEG: f64 = 15.0;
/// The curve is sampled about so often, for the start of the search.
const SAMPLES: usize = 288;
const NEWTON_STEPS: usize = 4;
/// Two poses nearer than this are one pose.
const SEPARATION_DEG: f64 = 15.0;

/// The curve of one object.
#[derive(Clone, Debug)]
pub(super) struct Manifold {
    /// Ascending; the first in [0, 360), the last less than 360 beyond it.
    knots_deg: Vec<f64>,
    /// knots × dimension, row-major.
    points: Vec<f64>,
    /// Second derivatives there, per degree².
    bends: Vec<f64>,
    dimension: usize,
    closed: bool,
    /// Points of the curve, [`Manifold::per_segment`] from each knot on.
    samples: Vec<f32>,
    per_segment: usize,
}

/// A point of the curve that is near a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Foot {
    /// In [0, 360).
    pub turn_deg: f64,
    pub distance: f64,
    /// How fast the curve goes there.
    pub speed_per_deg: f64,
    /// It is the end of an open arc: the object may be turned further.
    pub at_end: bool,
}

/// Poses that differ by no more are one: a spline through two pictures of nearly one pose would swing between them.
pub(super) const ONE_POSE_DEG: f64 = 0.5;

/// The different ones among poses, ascending, and which of them each is of.
pub(super) fn different(poses_deg: &[Option<f64>]) -> (Vec<f64>, Vec<Option<usize>>) {
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
    let mut different: Vec<f64> = groups.iter().map(mean).collect();
    // across 0 the last are the first
    if groups.len() > 1 && apart_deg(different[0], different[groups.len() - 1]) <= ONE_POSE_DEG {
        different.pop();
        let last = groups.pop().unwrap_or_default();
        groups[0].extend(last);
    }
    let mut which = vec![None; poses_deg.len()];
    for (number, group) in groups.iter().enumerate() {
        group.iter().for_each(|&(_, view)| which[view] = Some(number));
    }
    (different, which)
}

/// The angle between two poses, 0..=180.
pub(super) fn apart_deg(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

/// The gaps from each of ascending poses to the next, round the circle.
fn gaps(poses_deg: &[f64]) -> Vec<f64> {
    let next = poses_deg.iter().skip(1).copied().chain([poses_deg[0] + 360.0]);
    next.zip(poses_deg).map(|(next, pose)| next - pose).collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// The wide gaps between ascending poses: (from, to).
pub(super) fn wide_gaps(poses_deg: &[f64]) -> Vec<(f64, f64)> {
    if poses_deg.len() < 2 {
        return Vec::new();
    }
    let gaps = gaps(poses_deg);
    let most = (UNUSUAL_PARTS * median(&gaps)).clamp(NARROW_GAP_DEG, WIDE_GAP_DEG);
    let wide = (0..gaps.len()).filter(|&i| gaps[i] > most + 1e-9);
    wide.map(|i| (poses_deg[i], poses_deg[(i + 1) % gaps.len()])).collect()
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
        let closed = gaps[widest] <= OPEN_GAP_DEG.max(GAP_PARTS * median(&gaps));
        // an open arc begins behind the gap
        let first = if closed { 0 } else { (widest + 1) % count };
        let order = (0..count).map(|i| (first + i) % count);
        let knots_deg: Vec<f64> =
            order.clone().map(|i| poses_deg[i] + if i < first { 360.0 } else { 0.0 }).collect();
        let points: Vec<f64> =
            order.flat_map(|i| &points[i * dimension..][..dimension]).map(|&v| f64::from(v)).collect();
        let bends = bends(&knots_deg, &points, dimension, closed);
        let segments = if closed { count } else { count - 1 };
        let per_segment = SAMPLES.div_ceil(segments).clamp(2, 16);
        let mut curve =
            Manifold { knots_deg, points, bends, dimension, closed, samples: Vec::new(), per_segment };
        let count = segments * per_segment + if closed { 0 } else { 1 };
        let mut samples = Vec::with_capacity(count * dimension);
        for sample in 0..count {
            let at = curve.sample_deg(sample);
            samples.extend(curve.at(at).map(|[p, _, _]| p as f32));
        }
        curve.samples = samples;
        Some(curve)
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        8 * (self.knots_deg.len() + self.points.len() + self.bends.len()) + 4 * self.samples.len()
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

    /// Position, first and second derivative of each coordinate at `turn_deg`, which lies between the first knot
    /// and the end.
    fn at(&self, turn_deg: f64) -> impl Iterator<Item = [f64; 3]> {
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
            let (m, n) = (row(&self.bends, segment, k), row(&self.bends, next, k));
            [
                a * p + b * q + ((a.powi(3) - a) * m + (b.powi(3) - b) * n) * h * h / 6.0,
                (q - p) / h + ((1.0 - 3.0 * a * a) * m + (3.0 * b * b - 1.0) * n) * h / 6.0,
                a * m + b * n,
            ]
        })
    }

    /// The point of the curve nearest to a query, and the nearest of those that are another pose: from the nearest
    /// samples by Newton's method on half the squared distance.
    pub fn nearest(&self, query: &[f32]) -> (Foot, Option<Foot>) {
        let squares: Vec<f32> =
            self.samples.chunks_exact(self.dimension).map(|sample| square_apart(sample, query)).collect();
        let count = squares.len();
        let best = (0..count).fold(0, |best, i| if squares[i] < squares[best] { i } else { best });
        let first = self.foot(best, query);
        let is_low = |i: usize| {
            let (before, after) = match self.closed {
                true => (squares[(i + count - 1) % count], squares[(i + 1) % count]),
                false => (
                    if i == 0 { f32::INFINITY } else { squares[i - 1] },
                    squares.get(i + 1).copied().unwrap_or(f32::INFINITY),
                ),
            };
            squares[i] <= before && squares[i] <= after
        };
        let second = (0..count)
            .filter(|&i| is_low(i) && apart_deg(self.sample_deg(i), first.turn_deg) > SEPARATION_DEG)
            .min_by(|&a, &b| squares[a].total_cmp(&squares[b]))
            .map(|sample| self.foot(sample, query));
        (first, second)
    }

    /// The point nearest to a query among those from one pose on to another.
    pub fn nearest_between(&self, query: &[f32], from_deg: f64, to_deg: f64) -> Option<Foot> {
        let reach = (to_deg - from_deg).rem_euclid(360.0);
        (0..self.samples.len() / self.dimension)
            .filter(|&sample| (self.sample_deg(sample) - from_deg).rem_euclid(360.0) <= reach)
            .map(|sample| {
                (square_apart(&self.samples[sample * self.dimension..][..self.dimension], query), sample)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, sample)| self.foot(sample, query))
    }

    fn foot(&self, sample: usize, query: &[f32]) -> Foot {
        let start = self.sample_deg(sample);
        // between the samples before and after, or the end of an open arc
        let last = self.samples.len() / self.dimension - 1;
        let before = match sample {
            0 if self.closed => self.end_deg() - self.sample_deg(last),
            0 => 0.0,
            _ => start - self.sample_deg(sample - 1),
        };
        let (least, most) =
            (start - before, if sample == last { self.end_deg() } else { self.sample_deg(sample + 1) });
        let within = |turn: f64| match self.closed {
            true => self.knots_deg[0] + (turn - self.knots_deg[0]).rem_euclid(360.0),
            false => turn,
        };
        let mut turn = start;
        for _ in 0..NEWTON_STEPS {
            let (mut slope, mut bend) = (0.0, 0.0);
            for ([p, v, w], &q) in self.at(within(turn)).zip(query) {
                let off = p - f64::from(q);
                slope += off * v;
                bend += v * v + off * w;
            }
            // where the curve bends away from the query there is no minimum to step to
            if bend <= 0.0 {
                break;
            }
            turn = (turn - slope / bend).clamp(least, most);
        }
        let measure = |turn: f64| {
            let parts =
                self.at(within(turn)).zip(query).map(|([p, v, _], &q)| [(p - f64::from(q)).powi(2), v * v]);
            parts.fold([0.0, 0.0], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
        };
        let (mut found, begun) = (measure(turn), measure(start));
        if begun[0] < found[0] {
            (turn, found) = (start, begun);
        }
        let at_end = !self.closed && (turn <= self.knots_deg[0] || turn >= self.end_deg());
        // rounding may give 360 itself
        let turn_deg = turn.rem_euclid(360.0) % 360.0;
        Foot { turn_deg, distance: found[0].sqrt(), speed_per_deg: found[1].sqrt(), at_end }
    }
}

fn square_apart(a: &[f32], b: &[f32]) -> f32 {
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
fn bends(knots_deg: &[f64], points: &[f64], dimension: usize, closed: bool) -> Vec<f64> {
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
    // off the diagonal, between unknowns i and i + 1
    let beside: Vec<f64> = (first..first + unknowns).map(gap).collect();
    let solved = if closed {
        cyclic(diagonal, &beside, right, dimension)
    } else {
        tridiagonal(diagonal, &beside, right, dimension)
    };
    match closed {
        true => solved,
        false => [vec![0.0; dimension], solved, vec![0.0; dimension]].concat(),
    }
}

/// Thomas' algorithm for a symmetric tridiagonal matrix and `width` right sides at once; `beside[i]` stands
/// between i and i + 1.
fn tridiagonal(mut diagonal: Vec<f64>, beside: &[f64], mut right: Vec<f64>, width: usize) -> Vec<f64> {
    let count = diagonal.len();
    for i in 1..count {
        let factor = beside[i - 1] / diagonal[i - 1];
        diagonal[i] -= factor * beside[i - 1];
        let (done, rest) = right.split_at_mut(i * width);
        let before = &done[(i - 1) * width..];
        rest[..width].iter_mut().zip(before).for_each(|(r, b)| *r -= factor * b);
    }
    for i in (0..count).rev() {
        let (rest, done) = right.split_at_mut((i + 1) * width);
        for (k, r) in rest[i * width..].iter_mut().enumerate() {
            let after = if i + 1 < count { beside[i] * done[k] } else { 0.0 };
            *r = (*r - after) / diagonal[i];
        }
    }
    right
}

/// The same with `beside[count − 1]` in the corners (Sherman-Morrison); three unknowns at least.
fn cyclic(mut diagonal: Vec<f64>, beside: &[f64], right: Vec<f64>, width: usize) -> Vec<f64> {
    let count = diagonal.len();
    let corner = beside[count - 1];
    let gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[count - 1] -= corner * corner / gamma;
    let mut update = vec![0.0; count];
    (update[0], update[count - 1]) = (gamma, corner);
    let update = tridiagonal(diagonal.clone(), beside, update, 1);
    let mut solved = tridiagonal(diagonal, beside, right, width);
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
            let (foot, _) = curve.nearest(&wave(turn));
            assert!(apart_deg(foot.turn_deg, turn) < 0.1, "{turn}: {foot:?}");
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
                let (foot, _) = curve.nearest(&wave(pose));
                assert!(foot.distance < 1e-6 && apart_deg(foot.turn_deg, pose) < 1e-3, "{pose}: {foot:?}");
            }
            for &knot in &curve.knots_deg[1..curve.knots_deg.len() - 1] {
                let (left, right) = (curve.at(knot - 1e-7), curve.at(knot));
                for (l, r) in left.zip(right) {
                    (0..3).for_each(|i| assert!((l[i] - r[i]).abs() < 1e-6, "derivative {i} at {knot}"));
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
        let (inside, _) = curve.nearest(&wave(355.0));
        assert!(apart_deg(inside.turn_deg, 355.0) < 0.2 && !inside.at_end);
        for (asked, end) in [(60.0, 40.0), (290.0, 320.0)] {
            let (foot, _) = curve.nearest(&wave(asked));
            assert!(foot.at_end && apart_deg(foot.turn_deg, end) < 1e-9, "{foot:?}");
        }
        assert_eq!(wide_gaps(&poses), [(40.0, 320.0)]);
    }

    #[test]
    fn a_symmetric_object_has_a_second_pose() {
        let poses: Vec<f64> = (0..36).map(|i| 10.0 * f64::from(i)).collect();
        let points: Vec<f32> = poses.iter().flat_map(|&pose| wave(2.0 * pose)).collect();
        let curve = Manifold::through(&poses, &points, 3).unwrap();
        let (first, second) = curve.nearest(&wave(2.0 * 33.0));
        let second = second.unwrap();
        let mut turns = [first.turn_deg, second.turn_deg];
        turns.sort_by(f64::total_cmp);
        assert!((turns[0] - 33.0).abs() < 0.1 && (turns[1] - 213.0).abs() < 0.1, "{turns:?}");
        let lonely = through(&poses).nearest(&wave(33.0));
        assert!(lonely.1.is_none_or(|second| second.distance > 0.5));
    }

    #[test]
    fn gaps_are_wide_by_themselves_or_beside_the_others() {
        let every = |step: usize| (0..360).step_by(step).map(|pose| pose as f64).collect::<Vec<f64>>();
        assert_eq!(wide_gaps(&every(10)), []);
        assert_eq!(wide_gaps(&every(36)), []);
        assert_eq!(wide_gaps(&every(40)).len(), 9);
        let missing: Vec<f64> =
            every(10).into_iter().filter(|&pose| !(120.0..160.0).contains(&pose)).collect();
        assert_eq!(wide_gaps(&missing), [(110.0, 160.0)]);
    }

    #[test]
    fn poses_that_hardly_differ_are_one() {
        let poses = [Some(10.2), None, Some(0.1), Some(359.9), Some(10.0), Some(90.0)];
        let (different, which) = different(&poses);
        assert_eq!(different.len(), 3);
        assert!((different[1] - 10.1).abs() < 1e-9);
        assert_eq!(which, [Some(1), None, Some(0), Some(0), Some(1), Some(2)]);
    }

    #[test]
    fn fewer_than_three_views_make_no_curve() {
        assert!(Manifold::through(&[0.0, 90.0], &[0.0, 1.0], 1).is_none());
    }
}
