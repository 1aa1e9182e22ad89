//! How far the estimates of narrow windows scatter about a plane: over a wide window that means that it sees more than
//! one surface, or a curved one, whatever its own estimate says. Beside a step a support about the point sees both sides,
//! and one that lies off it sees one: the plane there, continued to the point, says whether an estimate belongs to that
//! side (Kuwahara et al. 1976; in stereo the shiftable windows of Bobick and Intille 1999).
//!
//! A plane is fitted to β by weighted least squares about each point. The moments that it takes are derivatives of
//! smoothed planes: with a Gaussian window G of variance v, Σ G·w·(x′ − x) = v ∂(G∗w)/∂x, and
//! Σ G·w·(x′ − x)² = v² ∂²(G∗w)/∂x² + v (G∗w).

use super::estimate::{Sample, Samples};
use super::windows::{Means, Planes};

/// What estimates scatter by, whatever the noise: variance of β.
const LEAST_VARIANCE: f32 = 0.006 * 0.006;
/// Samples of a larger standard deviation don't count: what noise makes of them has no Gaussian spread.
const MOST_SIGMA: f32 = 0.1;
/// Keeps the plane's slope in bounds where all weight lies on a line, as a part of the window's variance.
const RIDGE: f64 = 0.025;

/// The planes that are smoothed: samples that count, their weights w, wβ and wβ².
const PLANES: usize = 4;

/// How much of what noise makes of the scatter is taken off it.
const NOISE_MARGIN: f32 = 1.3;
/// Supports beside a point lie this many of their standard deviations off it.
const BESIDE: f64 = 0.8;
/// Places of the supports: about the point, and around it.
const SUPPORTS: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [DIAGONAL, DIAGONAL],
    [-DIAGONAL, DIAGONAL],
    [DIAGONAL, -DIAGONAL],
    [-DIAGONAL, -DIAGONAL],
];
const DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// An estimate within this of a plane belongs to it, in β, beside its own error.
const ON_PLANE: f32 = 0.005;

/// Scatter over windows about the points of a grid.
pub(super) struct Spread {
    width: usize,
    height: usize,
    /// Samples between neighbours of the grid.
    step: usize,
    /// Standard deviation of the windows in samples.
    sigma: f64,
    points: Vec<Scatter>,
}

/// The scatter of estimates about a plane.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    /// Weighted variance of β about the plane.
    variance: f32,
    /// What noise makes of it.
    expected: f32,
    /// The plane's β at the support's middle, and its slopes by sample, along x and y.
    beta: f32,
    slopes: [f32; 2],
}

impl Scatter {
    /// Of a support without estimates.
    const NONE: Scatter = Scatter { variance: 0.0, expected: f32::INFINITY, beta: 0.0, slopes: [0.0; 2] };

    /// The variance that noise doesn't explain.
    fn excess(&self) -> f32 {
        (self.variance - NOISE_MARGIN * self.expected).max(0.0)
    }
}

impl Spread {
    /// Over Gaussian windows of ascending widths, in samples.
    pub(super) fn over(samples: &Samples, widths: &[f64]) -> Vec<Spread> {
        let counts = |sample: &Sample| sample.sigma < MOST_SIGMA;
        let weight = |sample: &Sample| match counts(sample) {
            true => 1.0 / (sample.sigma * sample.sigma + LEAST_VARIANCE),
            false => 0.0,
        };
        let plane =
            |value: &dyn Fn(&Sample) -> f32| -> Vec<f32> { samples.points.iter().map(value).collect() };
        let planes: [Vec<f32>; PLANES] = [
            plane(&|sample| f32::from(counts(sample))),
            plane(&weight),
            plane(&|sample| weight(sample) * sample.beta),
            plane(&|sample| weight(sample) * sample.beta * sample.beta),
        ];
        let rows = Planes { width: samples.width, planes: planes.each_ref().map(Vec::as_slice) };
        let mut means = Means::over(&rows, samples.width, samples.height, widths[0]);
        let mut spreads = vec![Spread::of(&means)];
        for &width in &widths[1..] {
            means = means.widened(width);
            spreads.push(Spread::of(&means));
        }
        spreads
    }

    fn of(means: &Means<PLANES>) -> Spread {
        let (width, height) = (means.width, means.height);
        let points = (0..height).flat_map(|y| (0..width).map(move |x| scatter(means, x, y))).collect();
        Spread { width, height, step: means.step, sigma: means.sigma_px, points }
    }

    /// The variance that an estimate at a sample has beside its own, `variance`: the least of all supports. Of the support
    /// about it what noise doesn't explain of the scatter; of one beside it also how far the estimate lies off the plane.
    pub(super) fn beside(&self, [x, y]: [usize; 2], beta: f32, variance: f32) -> f32 {
        let mut least = f32::INFINITY;
        for (number, [right, down]) in SUPPORTS.into_iter().enumerate() {
            let [u, v] = [(x, right, self.width), (y, down, self.height)].map(|(at, off, count)| {
                let place = (at as f64 + BESIDE * self.sigma * off) / self.step as f64;
                (place.round().max(0.0) as usize).min(count - 1)
            });
            let support = &self.points[v * self.width + u];
            if number > 0 && support.expected.is_infinite() {
                continue;
            }
            let mut excess = support.excess();
            if number > 0 && excess < least {
                let [dx, dy] = [(x, u), (y, v)].map(|(at, middle)| at as f32 - (middle * self.step) as f32);
                let plane = support.beta + support.slopes[0] * dx + support.slopes[1] * dy;
                excess += ((beta - plane).powi(2) - variance - ON_PLANE * ON_PLANE).max(0.0);
            }
            least = least.min(excess);
            if least == 0.0 {
                break;
            }
        }
        least
    }
}

/// The scatter over the window about one point of its grid.
fn scatter(means: &Means<PLANES>, x: usize, y: usize) -> Scatter {
    let [known, weight, first, second] = &means.planes;
    let (width, height) = (means.width, means.height);
    let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
    let (up, down) = (y.saturating_sub(1), (y + 1).min(height - 1));
    let at = |plane: &[f32], x: usize, y: usize| f64::from(plane[y * width + x]);
    let sum = at(weight, x, y);
    if sum <= f64::from(f32::MIN_POSITIVE) {
        return Scatter::NONE;
    }
    let (step, v) = (means.step as f64, means.variance_px2);
    // Over the sum: means. Along x, along y.
    let slope = |plane: &[f32]| {
        [at(plane, right, y) - at(plane, left, y), at(plane, x, down) - at(plane, x, up)]
            .map(|difference| v * difference / (2.0 * step) / sum)
    };
    let [mean_x, mean_y] = slope(weight);
    let mean = at(first, x, y) / sum;
    let curvature = |before: f64, after: f64| v * v * (before - 2.0 * sum + after) / (step * step) / sum + v;
    let twist =
        at(weight, right, down) - at(weight, left, down) - at(weight, right, up) + at(weight, left, up);
    let xx = (curvature(at(weight, left, y), at(weight, right, y)) - mean_x * mean_x).max(0.0);
    let yy = (curvature(at(weight, x, up), at(weight, x, down)) - mean_y * mean_y).max(0.0);
    let xy = v * v * twist / (4.0 * step * step) / sum - mean_x * mean_y;
    let [x_beta, y_beta] = slope(first);
    let (x_beta, y_beta) = (x_beta - mean_x * mean, y_beta - mean_y * mean);
    let ridge = RIDGE * v;
    let determinant = ((xx + ridge) * (yy + ridge) - xy * xy).max(ridge * ridge);
    let along_x = ((yy + ridge) * x_beta - xy * y_beta) / determinant;
    let along_y = ((xx + ridge) * y_beta - xy * x_beta) / determinant;
    let variance = (at(second, x, y) / sum - mean * mean).max(0.0);
    let of_plane = along_x * along_x * xx + 2.0 * along_x * along_y * xy + along_y * along_y * yy;
    let rest = variance - 2.0 * (along_x * x_beta + along_y * y_beta) + of_plane;
    let rest = rest.clamp(0.0, variance);
    Scatter {
        variance: rest as f32,
        expected: (at(known, x, y) / sum) as f32,
        beta: (mean - along_x * mean_x - along_y * mean_y) as f32,
        slopes: [along_x as f32, along_y as f32],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of σ 0.02, every third one unknown.
    fn samples(beta: impl Fn(usize, usize) -> f32) -> Samples {
        let (width, height) = (48, 40);
        let sample = |at: usize| Sample {
            beta: beta(at % width, at / width),
            sigma: if at % 3 == 2 { f32::INFINITY } else { 0.02 },
            ..Sample::UNKNOWN
        };
        Samples { width, height, step: 1, points: (0..width * height).map(sample).collect() }
    }

    /// What is beside the error of an estimate of no error, as a deviation.
    fn beside(spread: &Spread, x: usize, beta: f32) -> f32 {
        spread.beside([x, 20], beta, 0.0).sqrt()
    }

    #[test]
    fn planes_do_not_scatter_and_steps_do() {
        let sloping = |x: usize, y: usize| 0.01 * x as f32 - 0.02 * y as f32;
        let (plane, step) = (samples(sloping), samples(|x, _| if x < 24 { 0.2 } else { -0.2 }));
        let spread = |samples: &Samples| Spread::over(samples, &[2.0, 3.2]);
        for (plane, step) in spread(&plane).iter().zip(spread(&step)) {
            let at = |spread: &Spread| spread.points[20 / spread.step * spread.width + 24 / spread.step];
            assert!(at(plane).variance.sqrt() < 0.01, "a plane scatters by {}", at(plane).variance.sqrt());
            assert!(at(&step).variance.sqrt() > 0.08, "a step scatters by {}", at(&step).variance.sqrt());
            assert!(beside(plane, 24, sloping(24, 20)) < 0.01 && beside(&step, 4, 0.2) < 0.01);
        }
        let expected = spread(&plane)[0].points[20 * 48 + 24].expected;
        assert!((expected - 0.02 * 0.02 - LEAST_VARIANCE).abs() < 1e-5, "{expected}");
    }

    #[test]
    fn an_estimate_near_a_step_belongs_to_its_side_or_to_none() {
        let step = samples(|x, _| 0.004 * x as f32 + if x < 24 { 0.2 } else { -0.2 });
        let spread = &Spread::over(&step, &[2.0])[0];
        // No depth has a deviation above 0.04.
        for (x, own) in [(20, 0.28), (26, -0.096)] {
            let (own, between) = (beside(spread, x, own), beside(spread, x, own - own.signum() * 0.15));
            assert!(own < 0.04 && between > 0.055, "at {x}: {own} on its side, {between} between the two");
        }
        // A whole support away the step doesn't show at all.
        assert!(beside(spread, 14, 0.256) < 0.02 && beside(spread, 34, -0.064) < 0.02);
    }
}
