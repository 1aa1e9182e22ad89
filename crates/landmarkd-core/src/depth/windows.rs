//! Means over Gaussian windows on coarser grids: the mean over a window of σ pixels changes little within σ, so only
//! every second, fourth or eighth pixel has one. Wider windows are made of narrower ones: variances add.

use pulp::{Arch, Simd, WithSimd};

use crate::vision::smoothing::{WeightedPairs, mirrored};

/// Planes of window means: plane p at (x, y) is the mean about the pixel (x·step, y·step).
#[derive(Clone, Debug)]
pub(super) struct Means<const N: usize> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Pixels between neighbours of the grid.
    pub(super) step: usize,
    /// Standard deviation of the window in pixels.
    pub(super) sigma_px: f64,
    /// Its variance as it is, ending at [`REACH`], in px².
    pub(super) variance_px2: f64,
    pub(super) planes: [Vec<f32>; N],
}

/// Least standard deviation of a window, in steps of its grid.
const LEAST_SIGMA_STEPS: f64 = 1.25;
/// The window ends at this many standard deviations.
const REACH: f64 = 3.0;
/// The first window of a cascade, at most: wider ones are made of it.
const FIRST_SIGMA_PX: f64 = 2.5;
/// Pixels of one block of vector instructions.
pub(super) const LANES: usize = 16;

/// Half of a Gaussian kernel, centre first; the whole sums to 1.
fn half_kernel(sigma: f64) -> Vec<f32> {
    let reach = (REACH * sigma).ceil().max(1.0) as i32;
    let bell = |k: i32| (-0.5 * (f64::from(k) / sigma).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(bell).sum();
    (0..=reach).map(|k| (bell(k) / sum) as f32).collect()
}

/// The variance of a kernel of this half, in steps².
fn variance(half_kernel: &[f32]) -> f64 {
    half_kernel.iter().enumerate().map(|(k, &weight)| 2.0 * f64::from(weight) * (k * k) as f64).sum()
}

/// The step of a window's grid, if that of the narrower window before it is `step`.
fn step_for(sigma_px: f64, step: usize) -> usize {
    if sigma_px / (2 * step) as f64 >= LEAST_SIGMA_STEPS { 2 * step } else { step }
}

impl<const N: usize> Means<N> {
    /// Means of N planes over the first window of the cascade to `sigma_px`.
    fn first<R: Rows<N>>(rows: &R, width: usize, height: usize, sigma_px: f64) -> Means<N> {
        let sigma_px = sigma_px.min(FIRST_SIGMA_PX);
        let step = step_for(sigma_px, 1);
        let (grid_width, grid_height) = (width.div_ceil(step), height.div_ceil(step));
        let kernel = half_kernel(sigma_px);
        let mut means = Means {
            width: grid_width,
            height: grid_height,
            step,
            sigma_px,
            variance_px2: variance(&kernel),
            planes: std::array::from_fn(|_| Vec::with_capacity(grid_width * grid_height)),
        };
        let padded_width = width.next_multiple_of(LANES);
        let mut across: [Vec<f32>; N] = std::array::from_fn(|_| vec![0.0; padded_width]);
        let mut smoothing = RowSmoothing::new(width, &kernel, step);
        for y in (0..height).step_by(step) {
            for from in (0..width).step_by(LANES) {
                let mut sums = [[0.0; LANES]; N];
                Arch::new().dispatch(SumRows { rows, y, height, from, kernel: &kernel, sums: &mut sums });
                for (row, sums) in across.iter_mut().zip(&sums) {
                    row[from..][..LANES].copy_from_slice(sums);
                }
            }
            for (row, plane) in across.iter().zip(&mut means.planes) {
                smoothing.smooth(&row[..width], plane);
            }
        }
        means
    }

    /// The same means over a window of `sigma_px`, wider than this one.
    pub(super) fn widened(&self, sigma_px: f64) -> Means<N> {
        let step = step_for(sigma_px, self.step);
        let by = step / self.step;
        let more = (sigma_px * sigma_px - self.sigma_px * self.sigma_px).sqrt() / self.step as f64;
        let kernel = half_kernel(more);
        let (width, height) = (self.width.div_ceil(by), self.height.div_ceil(by));
        let mut smoothing = RowSmoothing::new(self.width, &kernel, by);
        let mut across = vec![0.0; self.width];
        let planes = std::array::from_fn(|p| {
            let mut plane = Vec::with_capacity(width * height);
            for y in (0..self.height).step_by(by) {
                let row = |dy: isize| {
                    let y = mirrored(y as isize + dy, self.height);
                    &self.planes[p][y * self.width..][..self.width]
                };
                let taps = (0..kernel.len() as isize).map(|k| (row(-k), row(k)));
                Arch::new().dispatch(WeightedPairs { out: &mut across, kernel: &kernel, taps });
                smoothing.smooth(&across, &mut plane);
            }
            plane
        });
        let variance_px2 = self.variance_px2 + variance(&kernel) * (self.step * self.step) as f64;
        Means { width, height, step, sigma_px, variance_px2, planes }
    }

    /// Means over the window of `sigma_px`, by a cascade of windows.
    pub(super) fn over<R: Rows<N>>(rows: &R, width: usize, height: usize, sigma_px: f64) -> Means<N> {
        let mut means = Means::first(rows, width, height, sigma_px);
        while means.sigma_px < sigma_px {
            means = means.widened((2.0 * means.sigma_px).min(sigma_px));
        }
        means
    }
}

/// N values of each pixel, computed on demand.
pub(super) trait Rows<const N: usize> {
    /// Add `weight` times the values of pixels `from..` of row `y` to `sums`; of pixels beyond the row, anything.
    fn add(&self, y: usize, from: usize, weight: f32, sums: &mut [[f32; LANES]; N]);
}

/// N planes as they are.
pub(super) struct Planes<'a, const N: usize> {
    pub(super) width: usize,
    pub(super) planes: [&'a [f32]; N],
}

impl<const N: usize> Rows<N> for Planes<'_, N> {
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators over the lanes are not inlined into vector code here"
    )]
    fn add(&self, y: usize, from: usize, weight: f32, sums: &mut [[f32; LANES]; N]) {
        for p in 0..N {
            let row = &self.planes[p][y * self.width + from..(y + 1) * self.width];
            let count = row.len().min(LANES);
            for lane in 0..count {
                sums[p][lane] += weight * row[lane];
            }
        }
    }
}

/// The weighted sum of a block of pixels over the rows about `y`.
struct SumRows<'a, R, const N: usize> {
    rows: &'a R,
    y: usize,
    height: usize,
    from: usize,
    kernel: &'a [f32],
    sums: &'a mut [[f32; LANES]; N],
}

impl<R: Rows<N>, const N: usize> WithSimd for SumRows<'_, R, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let reach = self.kernel.len() as isize - 1;
        for dy in -reach..=reach {
            let y = mirrored(self.y as isize + dy, self.height);
            self.rows.add(y, self.from, self.kernel[dy.unsigned_abs()], self.sums);
        }
    }
}

/// Smoothing along rows of one length, with its working memory.
struct RowSmoothing<'a> {
    kernel: &'a [f32],
    step: usize,
    /// The column of each padded pixel.
    columns: Vec<usize>,
    /// The padded row's pixels, every `step`-th together: neighbours of the grid then stand side by side.
    phases: Vec<Vec<f32>>,
    count: usize,
}

impl<'a> RowSmoothing<'a> {
    fn new(width: usize, kernel: &'a [f32], step: usize) -> Self {
        let reach = (kernel.len() - 1).next_multiple_of(step);
        let padded = (width + 2 * reach).next_multiple_of(step);
        let columns = (0..padded).map(|x| mirrored(x as isize - reach as isize, width)).collect();
        RowSmoothing {
            kernel,
            step,
            columns,
            phases: vec![vec![0.0; padded / step]; step],
            count: width.div_ceil(step),
        }
    }

    /// Appends the smoothed row to `out`.
    fn smooth(&mut self, row: &[f32], out: &mut Vec<f32>) {
        for (phase, pixels) in self.phases.iter_mut().enumerate() {
            let columns = self.columns[phase..].iter().step_by(self.step);
            for (pixel, &column) in pixels.iter_mut().zip(columns) {
                *pixel = row[column];
            }
        }
        let from = out.len();
        out.resize(from + self.count, 0.0);
        let reach = (self.kernel.len() - 1).next_multiple_of(self.step) as isize;
        let row = |tap: isize| {
            let at = (reach + tap) as usize;
            &self.phases[at % self.step][at / self.step..][..self.count]
        };
        let taps = (0..self.kernel.len() as isize).map(|k| (row(-k), row(k)));
        Arch::new().dispatch(WeightedPairs { out: &mut out[from..], kernel: self.kernel, taps });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Straight from the definition, over the whole plane and its mirror images.
    fn direct(plane: &[f32], width: usize, height: usize, sigma_px: f64, x: usize, y: usize) -> f64 {
        let reach = (4.0 * sigma_px) as isize;
        let (mut sum, mut weights) = (0.0, 0.0);
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let weight = (-0.5 * (dx * dx + dy * dy) as f64 / (sigma_px * sigma_px)).exp();
                let (column, row) = (mirrored(x as isize + dx, width), mirrored(y as isize + dy, height));
                sum += weight * f64::from(plane[row * width + column]);
                weights += weight;
            }
        }
        sum / weights
    }

    #[test]
    fn wide_windows_made_of_narrow_ones_are_gaussian_means() {
        let (width, height) = (61, 47);
        let plane: Vec<f32> = (0..width * height).map(|at| (at * 7919 % 251) as f32).collect();
        let rows = Planes { width, planes: [&plane] };
        for (sigma_px, step) in [(1.0, 1), (2.5, 2), (4.0, 2), (7.0, 4)] {
            let means = Means::over(&rows, width, height, sigma_px);
            assert_eq!((means.step, means.width), (step, width.div_ceil(step)));
            for y in 0..means.height {
                for x in 0..means.width {
                    let fast = f64::from(means.planes[0][y * means.width + x]);
                    let slow = direct(&plane, width, height, sigma_px, x * step, y * step);
                    assert!((fast - slow).abs() < 2.0, "σ {sigma_px} at ({x}, {y}): {fast} is not {slow}");
                }
            }
        }
    }

    #[test]
    fn a_flat_plane_has_its_own_mean_everywhere() {
        let plane = vec![42.0; 19 * 3];
        let means = Means::over(&Planes { width: 19, planes: [&plane] }, 19, 3, 20.0);
        assert!(means.planes[0].iter().all(|mean| (mean - 42.0).abs() < 1e-3));
    }
}
