//! A homography of the plane (Hartley and Zisserman 2004): by least squares, and by RANSAC (Fischler and Bolles 1981).

use pulp::{Arch, Simd, WithSimd};

use crate::imaging::Random;

/// Points must agree for a homography to be looked at; four determine it.
pub const LEAST_POINTS: usize = 4;

/// Corners may lie so many times as deep as the nearest.
const MOST_DEPTH: f64 = 4.0;
/// Among so many of the best pairs the first round chooses.
const PROSAC_FIRST: usize = 8;

/// Triangles smaller than this part of the square of the distances are lines.
const DEGENERATE: f64 = 1e-6;

/// A point, and the one that it corresponds to.
pub type Correspondence = ([f64; 2], [f64; 2]);

/// A projective map of the plane, row-major; the last element is about 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography(pub [[f64; 3]; 3]);

/// Turn and scale of a map near a point.
#[derive(Clone, Copy, Debug)]
pub struct LocalSimilarity {
    /// From x towards y.
    pub turn_rad: f64,
    /// Length there per length here.
    pub scale: f64,
}

impl Homography {
    /// Where a point goes; far away where it goes to infinity.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let row = |r: &[f64; 3]| r[0] * x + r[1] * y + r[2];
        let w = row(&self.0[2]);
        [row(&self.0[0]) / w, row(&self.0[1]) / w]
    }

    /// A map of offsets from a picture's middle, as one of positions in the picture.
    pub fn from_corner(&self, [x, y]: [f64; 2]) -> Homography {
        let moved = self.0.map(|[a, b, c]| [a, b, c - a * x - b * y]);
        Homography(moved.map(|row| row.map(|v| v / moved[2][2])))
    }

    /// The same between pictures that are `from` and `to` times as large.
    pub fn between_posted(&self, from: f64, to: f64) -> Homography {
        // a pixel u of the small picture stands at (u + ½)·k − ½ of the large one
        let up = [[to, 0.0, 0.5 * (to - 1.0)], [0.0, to, 0.5 * (to - 1.0)], [0.0, 0.0, 1.0]];
        let shift = 0.5 / from - 0.5;
        let down = [[from.recip(), 0.0, shift], [0.0, from.recip(), shift], [0.0, 0.0, 1.0]];
        let product = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
            std::array::from_fn(|row| {
                std::array::from_fn(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum())
            })
        };
        let whole = product(&product(&up, &self.0), &down);
        Homography(whole.map(|row| row.map(|v| v / whole[2][2])))
    }

    /// The derivative at a point.
    pub fn derivative(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let h = &self.0;
        let w = h[2][0] * x + h[2][1] * y + h[2][2];
        let [u, v] = self.apply([x, y]);
        [
            [(h[0][0] - u * h[2][0]) / w, (h[0][1] - u * h[2][1]) / w],
            [(h[1][0] - v * h[2][0]) / w, (h[1][1] - v * h[2][1]) / w],
        ]
    }

    /// The derivative at a point, as turn and scale.
    pub fn local_similarity(&self, at: [f64; 2]) -> LocalSimilarity {
        let j = self.derivative(at);
        let determinant = j[0][0] * j[1][1] - j[0][1] * j[1][0];
        LocalSimilarity {
            turn_rad: (j[1][0] - j[0][1]).atan2(j[0][0] + j[1][1]),
            scale: determinant.max(1e-6).sqrt(),
        }
    }

    /// Whether a picture of this size about the origin stays convex, of the same handedness, neither tiny nor huge, and is not seen from too
    /// far aside.
    pub fn is_sane(&self, width: f64, height: f64) -> bool {
        let (x, y) = (width / 2.0, height / 2.0);
        let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
        let depth = |[x, y]: [f64; 2]| self.0[2][0] * x + self.0[2][1] * y + self.0[2][2];
        let middle = depth([0.0, 0.0]);
        let depths = corners.map(depth);
        let (least, most) =
            depths.iter().fold((f64::MAX, 0.0_f64), |(l, m), d| (l.min(d.abs()), m.max(d.abs())));
        if depths.iter().any(|d| d * middle <= 0.0) || most > MOST_DEPTH * least || most.is_nan() {
            return false;
        }
        let p = corners.map(|corner| self.apply(corner));
        let turn = |i: usize| {
            let (a, b, c) = (p[i], p[(i + 1) % 4], p[(i + 2) % 4]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let area = 0.5 * (turn(0) + turn(2));
        (0..4).all(|i| turn(i) > 0.0) && area > 0.01 * width * height && area < 60.0 * width * height
    }

    /// The similarity x ↦ centre + scale · R(turn) · x.
    pub fn similarity(centre: [f64; 2], turn_rad: f64, scale: f64) -> Homography {
        let (sin, cos) = turn_rad.sin_cos();
        Homography([
            [scale * cos, -scale * sin, centre[0]],
            [scale * sin, scale * cos, centre[1]],
            [0.0, 0.0, 1.0],
        ])
    }

    /// The least-squares similarity of weighted point pairs; `None` if the points coincide.
    pub fn fitted_similarity(pairs: &[Correspondence], weights: &[f64]) -> Option<Homography> {
        let total: f64 = weights.iter().sum();
        let mean = |point: fn(&Correspondence) -> [f64; 2]| {
            let weighted = pairs.iter().zip(weights).map(|(pair, w)| point(pair).map(|v| w * v / total));
            weighted.fold([0.0, 0.0], |sum, v| [sum[0] + v[0], sum[1] + v[1]])
        };
        let (from, to) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let (mut along, mut across, mut variance) = (0.0, 0.0, 0.0);
        for ((a, b), w) in pairs.iter().zip(weights) {
            let ([x, y], [u, v]) = ([a[0] - from[0], a[1] - from[1]], [b[0] - to[0], b[1] - to[1]]);
            along += w * (x * u + y * v);
            across += w * (x * v - y * u);
            variance += w * (x * x + y * y);
        }
        let length = along.hypot(across);
        if !(variance > 1e-9 && length > 1e-9) {
            return None;
        }
        let about = Homography::similarity([0.0, 0.0], across.atan2(along), length / variance);
        let [x, y] = about.apply(from);
        Some(Homography::similarity([to[0] - x, to[1] - y], across.atan2(along), length / variance))
    }

    /// The least-squares homography of point pairs (from, to), by the normalised direct linear transform with the last element
    /// held at 1; `None` if the points don't determine one.
    pub fn fitted(pairs: &[Correspondence]) -> Option<Homography> {
        if pairs.len() < LEAST_POINTS {
            return None;
        }
        let from = Normalisation::of(pairs.iter().map(|pair| pair.0))?;
        let to = Normalisation::of(pairs.iter().map(|pair| pair.1))?;
        let mut normal = [[0.0_f64; 9]; 8];
        for (a, b) in pairs {
            let ([x, y], [u, v]) = (from.apply(*a), to.apply(*b));
            for row in
                [[x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y, u], [0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y, v]]
            {
                for (out, a) in normal.iter_mut().zip(row) {
                    out.iter_mut().zip(row).for_each(|(out, b)| *out += a * b);
                }
            }
        }
        let h = solved(normal)?;
        let h = [[h[0], h[1], h[2]], [h[3], h[4], h[5]], [h[6], h[7], 1.0]];
        // undo both normalisations: T_to⁻¹ · h · T_from
        let (s, [mx, my]) = (from.scale, from.mean);
        let right = h.map(|r| [r[0] * s, r[1] * s, r[2] - s * (r[0] * mx + r[1] * my)]);
        let mut out = [[0.0; 3]; 3];
        for c in 0..3 {
            out[0][c] = right[0][c] / to.scale + to.mean[0] * right[2][c];
            out[1][c] = right[1][c] / to.scale + to.mean[1] * right[2][c];
            out[2][c] = right[2][c];
        }
        let last = out[2][2];
        (last.abs() > 1e-9).then(|| Homography(out.map(|row| row.map(|v| v / last))))
    }

    /// The homography through four point pairs (from, to); `None` if the first points don't determine one.
    ///
    /// In homogeneous coordinates p₄ = Σ λᵢ pᵢ of the other three, by Cramer's rule; the map takes λᵢ pᵢ to μᵢ qᵢ.
    fn through(pairs: &[Correspondence; 4]) -> Option<Homography> {
        let origin = pairs[0].0;
        let area = |[a, b, c]: [[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let p = pairs.map(|pair| [pair.0[0] - origin[0], pair.0[1] - origin[1]]);
        let q = pairs.map(|pair| pair.1);
        let weights = |p: &[[f64; 2]; 4]| {
            [area([p[3], p[1], p[2]]), area([p[0], p[3], p[2]]), area([p[0], p[1], p[3]])]
        };
        let (lambda, mu) = (weights(&p), weights(&q));
        let extent = p.iter().fold(0.0_f64, |most, [x, y]| most.max(x * x + y * y));
        let least = DEGENERATE * extent;
        if lambda.iter().any(|v| v.abs() <= least) || area([p[0], p[1], p[2]]).abs() <= least {
            return None;
        }
        let mut h = [[0.0; 3]; 3];
        for i in 0..3 {
            let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
            // the line through the other two: zero there
            let line = [a[1] - b[1], b[0] - a[0], a[0] * b[1] - a[1] * b[0]];
            let scale = mu[i] * lambda[(i + 1) % 3] * lambda[(i + 2) % 3];
            for (row, q) in h.iter_mut().zip([q[i][0], q[i][1], 1.0]) {
                row.iter_mut().zip(line).for_each(|(out, line)| *out += scale * q * line);
            }
        }
        let h = h.map(|[a, b, c]| [a, b, c - a * origin[0] - b * origin[1]]);
        let last = h[2][2];
        let middle = |axis: usize| pairs.iter().map(|pair| pair.0[axis]).sum::<f64>() / 4.0;
        let depth = h[2][0] * middle(0) + h[2][1] * middle(1) + last;
        (last.abs() > 1e-9 * depth.abs()).then(|| Homography(h.map(|row| row.map(|v| v / last))))
    }

    /// The homography that most pairs agree with to within `within_px`, refined on them; and which they are. The pairs come
    /// best first: early rounds choose among the first ones (PROSAC, Chum and Matas 2005).
    pub fn agreed(
        pairs: &[Correspondence],
        within_px: f64,
        rounds: usize,
    ) -> Option<(Homography, Vec<usize>)> {
        if pairs.len() < LEAST_POINTS {
            return None;
        }
        let mut random = Random::new(pairs.len() as u64, 7);
        let mut best: Option<(usize, Homography)> = None;
        let square = within_px * within_px;
        let off = |h: &Homography, (a, b): &([f64; 2], [f64; 2])| {
            let p = h.apply(*a);
            (p[0] - b[0]).powi(2) + (p[1] - b[1]).powi(2)
        };
        let lanes = PairLanes::of(pairs);
        let mut left = rounds;
        let mut round = 0;
        while round < left {
            round += 1;
            let among = (PROSAC_FIRST + pairs.len() * 2 * round / rounds.max(1)).min(pairs.len());
            let mut chosen = [usize::MAX; 4];
            for i in 0..4 {
                loop {
                    let candidate = (random.uniform() * among as f64) as usize % among;
                    if !chosen[..i].contains(&candidate) {
                        chosen[i] = candidate;
                        break;
                    }
                }
            }
            let Some(h) = Homography::through(&chosen.map(|i| pairs[i])) else { continue };
            let count = Arch::new().dispatch(Agreeing { lanes: &lanes, map: &h, square });
            if best.as_ref().is_none_or(|(most, _)| count > *most) {
                best = Some((count, h));
                let share = count as f64 / pairs.len() as f64;
                let needed = (0.005_f64.ln() / (1.0 - share.powi(4)).max(1e-9).ln()).ceil();
                left = left.min(round.max(needed.max(1.0) as usize));
            }
        }
        let (_, mut h) = best?;
        let mut inliers = Vec::new();
        for _ in 0..3 {
            inliers = (0..pairs.len()).filter(|&i| off(&h, &pairs[i]) < square).collect();
            let agreeing: Vec<_> = inliers.iter().map(|&i| pairs[i]).collect();
            h = Homography::fitted(&agreeing)?;
        }
        Some((h, inliers))
    }
}

/// Pairs that are compared with a map together.
const LANES: usize = 8;

/// Pairs with each of their four numbers side by side; padded by pairs that agree with nothing.
struct PairLanes(Vec<[[f64; LANES]; 4]>);

impl PairLanes {
    fn of(pairs: &[Correspondence]) -> PairLanes {
        let lanes = pairs.chunks(LANES).map(|chunk| {
            let mut lanes = [[f64::NAN; LANES]; 4];
            for (lane, ([x, y], [u, v])) in chunk.iter().enumerate() {
                lanes.iter_mut().zip([x, y, u, v]).for_each(|(lanes, value)| lanes[lane] = *value);
            }
            lanes
        });
        PairLanes(lanes.collect())
    }
}

/// How many pairs a map takes to within a distance, given its square.
struct Agreeing<'a> {
    lanes: &'a PairLanes,
    map: &'a Homography,
    square: f64,
}

impl WithSimd for Agreeing<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> usize {
        let h = self.map.0;
        let mut agreeing = [0_i64; LANES];
        for [x, y, u, v] in &self.lanes.0 {
            for i in 0..LANES {
                let at = |r: [f64; 3]| r[0] * x[i] + r[1] * y[i] + r[2];
                let w = at(h[2]);
                let (du, dv) = (at(h[0]) - u[i] * w, at(h[1]) - v[i] * w); // w times as far
                agreeing[i] += i64::from(du * du + dv * dv < self.square * (w * w));
            }
        }
        agreeing.iter().sum::<i64>() as usize
    }
}

/// To zero mean and a mean distance of about 1.
struct Normalisation {
    mean: [f64; 2],
    scale: f64,
}

impl Normalisation {
    fn of(points: impl Iterator<Item = [f64; 2]> + Clone) -> Option<Normalisation> {
        let count = points.clone().count() as f64;
        let sum = points.clone().fold([0.0, 0.0], |s, p| [s[0] + p[0], s[1] + p[1]]);
        let mean = sum.map(|v| v / count);
        let distance = points.map(|p| (p[0] - mean[0]).hypot(p[1] - mean[1])).sum::<f64>() / count;
        (distance > 1e-9).then(|| Normalisation { mean, scale: 1.0 / distance })
    }

    fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        [(p[0] - self.mean[0]) * self.scale, (p[1] - self.mean[1]) * self.scale]
    }
}

/// The solution of eight linear equations, right side last, by elimination with pivoting.
fn solved(mut m: [[f64; 9]; 8]) -> Option<[f64; 8]> {
    for i in 0..8 {
        let pivot = (i..8).max_by(|&a, &b| m[a][i].abs().total_cmp(&m[b][i].abs()))?;
        if m[pivot][i].abs() < 1e-12 {
            return None;
        }
        m.swap(i, pivot);
        let (above, below) = m.split_at_mut(i + 1);
        for row in below {
            let factor = row[i] / above[i][i];
            row.iter_mut().zip(above[i]).skip(i).for_each(|(v, pivot)| *v -= factor * pivot);
        }
    }
    let mut x = [0.0; 8];
    for i in (0..8).rev() {
        let known: f64 = (i + 1..8).map(|j| m[i][j] * x[j]).sum();
        x[i] = (m[i][8] - known) / m[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: Homography = Homography([[0.9, -0.2, 30.0], [0.25, 1.1, -12.0], [4e-4, -3e-4, 1.0]]);

    fn pairs(count: usize) -> Vec<Correspondence> {
        let mut random = Random::new(3, 1);
        let point = |random: &mut Random| [640.0 * random.uniform(), 480.0 * random.uniform()];
        (0..count).map(|_| point(&mut random)).map(|from| (from, TRUTH.apply(from))).collect()
    }

    fn assert_same(found: &Homography, within_px: f64) {
        for from in [[0.0, 0.0], [639.0, 0.0], [639.0, 479.0], [0.0, 479.0], [320.0, 240.0]] {
            let (a, b) = (found.apply(from), TRUTH.apply(from));
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < within_px, "{from:?}: {a:?} for {b:?}");
        }
    }

    #[test]
    fn four_points_determine_it_and_more_average() {
        assert_same(&Homography::fitted(&pairs(4)).unwrap(), 1e-6);
        assert_same(&Homography::fitted(&pairs(40)).unwrap(), 1e-6);
        assert_eq!(Homography::fitted(&pairs(3)), None);
        let line: Vec<_> =
            (0..6).map(|i| ([f64::from(i), 2.0 * f64::from(i)], [f64::from(i), 0.0])).collect();
        assert_eq!(Homography::fitted(&line), None, "points of a line determine none");
    }

    #[test]
    fn through_four_points_it_is_the_fitted_one() {
        let mut random = Random::new(9, 1);
        let mut point = || [640.0 * random.uniform() - 320.0, 480.0 * random.uniform() - 240.0];
        for _ in 0..200 {
            let pairs: [Correspondence; 4] = std::array::from_fn(|_| (point(), point()));
            let through = Homography::through(&pairs).unwrap();
            for (from, to) in pairs {
                let at = through.apply(from);
                assert!((at[0] - to[0]).hypot(at[1] - to[1]) < 1e-5, "{at:?} for {to:?}");
            }
        }
        let line = [[0.0, 0.0], [10.0, 20.0], [30.0, 60.0], [5.0, 90.0]].map(|p| (p, [p[1], p[0]]));
        assert_eq!(Homography::through(&line), None);
        assert_eq!(Homography::through(&[([3.0, 3.0], [1.0, 1.0]); 4]), None);
    }

    #[test]
    fn it_is_found_among_more_wrong_pairs_than_right_ones() {
        let mut random = Random::new(5, 1);
        let mut pairs = pairs(30);
        for _ in 0..45 {
            let mut point = || [640.0 * random.uniform(), 480.0 * random.uniform()];
            pairs.push((point(), point()));
        }
        let (found, inliers) = Homography::agreed(&pairs, 3.0, 500).unwrap();
        assert_same(&found, 0.5);
        assert!((0..30).all(|index| inliers.contains(&index)) && inliers.len() < 33, "{inliers:?}");
    }

    #[test]
    fn turn_and_scale_are_those_of_the_derivative() {
        let (sin, cos) = 0.6_f64.sin_cos();
        let similarity =
            Homography([[2.0 * cos, -2.0 * sin, 7.0], [2.0 * sin, 2.0 * cos, 9.0], [0.0, 0.0, 1.0]]);
        let local = similarity.local_similarity([50.0, 80.0]);
        assert!((local.turn_rad - 0.6).abs() < 1e-12 && (local.scale - 2.0).abs() < 1e-12);
    }

    #[test]
    fn mirrors_folds_and_specks_are_not_sane() {
        assert!(TRUTH.is_sane(640.0, 480.0));
        let mirror = Homography([[-1.0, 0.0, 640.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let fold = Homography([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0 / 300.0, 0.0, 1.0]]);
        let speck = Homography([[0.05, 0.0, 0.0], [0.0, 0.05, 0.0], [0.0, 0.0, 1.0]]);
        assert!([mirror, fold, speck].iter().all(|h| !h.is_sane(640.0, 480.0)));
    }

    #[test]
    fn between_larger_pictures_it_maps_the_same_points() {
        let large = TRUTH.between_posted(2.0, 3.0);
        let into = |k: f64, [x, y]: [f64; 2]| [(x + 0.5) * k - 0.5, (y + 0.5) * k - 0.5];
        let from = [100.0, 60.0];
        let (a, b) = (large.apply(into(2.0, from)), into(3.0, TRUTH.apply(from)));
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9, "{a:?} {b:?}");
    }
}
