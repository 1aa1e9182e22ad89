//! How far the estimates of narrow windows scatter about a plane: over a wide window that means that it sees more than
//! one surface, or a curved one, whatever its own estimate says.
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

/// Scatter over windows about the points of a grid.
pub(super) struct Spread {
    width: usize,
    height: usize,
    /// Samples between neighbours of the grid.
    step: usize,
    points: Vec<Scatter>,
}

/// The scatter of estimates about a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scatter {
    /// Weighted variance of β about the plane.
    pub(super) variance: f32,
    /// What noise makes of it.
    pub(super) expected: f32,
}

impl Scatter {
    /// The variance that `margin` times the noise doesn't explain.
    pub(super) fn excess(self, margin: f32) -> f32 {
        (self.variance - margin * self.expected).max(0.0)
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
        Spread { width, height, step: means.step, points }
    }

    /// The scatter about a sample, of the nearest point of the grid.
    pub(super) fn at(&self, x: usize, y: usize) -> Scatter {
        let nearest = |at: usize, count: usize| ((at + self.step / 2) / self.step).min(count - 1);
        self.points[nearest(y, self.height) * self.width + nearest(x, self.width)]
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
        return Scatter { variance: 0.0, expected: f32::INFINITY };
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
    Scatter { variance: rest as f32, expected: (at(known, x, y) / sum) as f32 }
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

    #[test]
    fn planes_do_not_scatter_and_steps_do() {
        let plane = samples(|x, y| 0.01 * x as f32 - 0.02 * y as f32);
        let step = samples(|x, _| if x < 24 { 0.2 } else { -0.2 });
        for (narrow, wide) in [(2.0, 3.2), (2.0, 5.6)] {
            let spread = |samples: &Samples| Spread::over(samples, &[narrow, wide]);
            for (plane, step) in spread(&plane).iter().zip(spread(&step)) {
                let deviation = |spread: &Spread, x: usize| spread.at(x, 20).variance.sqrt();
                assert!(deviation(plane, 24) < 0.01, "a plane scatters by {}", deviation(plane, 24));
                assert!(deviation(&step, 24) > 0.08, "a step scatters by {}", deviation(&step, 24));
            }
            assert!(spread(&step)[0].at(4, 20).variance.sqrt() < 0.01, "far from the step");
        }
        let expected = Spread::over(&plane, &[2.0])[0].at(24, 20).expected;
        assert!((expected - 0.02 * 0.02 - LEAST_VARIANCE).abs() < 1e-5, "{expected}");
    }
}
