//! The method `gram`: at the right β, H_f·n = H_n·f. The energy of the residual, E(β) = c(β)ᵀ Q c(β) with
//! Q_ij = ⟨q_i q_j⟩, is a curve over β. Its minimum is the depth, its height there says whether any depth explains the
//! window, and its second derivative says how well the depth is known. Windows of several widths are measured;
//! [`super::selection`] chooses between them.

use pulp::{Arch, Simd, WithSimd};

use super::Window;
use super::estimate::{Estimate, Sample, Samples};
use super::filtering::filtered;
use super::kernels::{BETA_STEP, CANDIDATES, KernelBank, PRODUCTS, RANK, beta_of, product_pairs};
use super::selection::{WindowSamples, chosen};
use super::windows::{LANES, Means, Rows};
use crate::imaging::Image;

/// Windows of `auto`, standard deviation in pixels.
const WINDOWS_PX: [f64; 4] = [2.5, 4.0, 7.0, 12.0];
/// The same after halving: a window then sees more detail of the original.
const HALVED_WINDOWS_PX: [f64; 3] = [2.0, 3.0, 5.0];
/// Area over which the filters make noise alike, in pixels: a window has its area over this independent samples.
const NOISE_AREA_PX: f64 = 4.5;
/// A window must hold more energy than noise makes, by this many standard deviations.
const SIGNIFICANCE: f64 = 10.0;
/// A second minimum within this part of the curve's height is another answer.
const AMBIGUOUS: f32 = 0.15;
/// Candidates about the minimum that belong to it.
const SAME_VALLEY: f32 = 3.0;
/// How much the energy that noise doesn't explain counts as uncertainty of β. Of textures at two depths that a window holds
/// it is half of the variance of their β times d²E/dβ²: 2 would take all of it for that, and a texture that is crossed by
/// one contour leaves as much.
const LEFT_WEIGHT: f64 = 0.5;
/// Energy that noise explains: its mean, and this many standard deviations of a window's.
const NOISE_DEVIATIONS: f64 = 2.0;
/// What the kernels leave of the texture at the right β, as a part of the curve's second derivative, at the most.
const LEAK: f64 = 0.02;
/// The same, at the least.
const LEAST_LEAK: f64 = 0.0003;

/// The products q_i·q_j of one picture pair.
struct Products<'a> {
    width: usize,
    q: &'a [Vec<f32>; RANK],
}

impl Rows<PRODUCTS> for Products<'_> {
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators over the lanes are not inlined into vector code here"
    )]
    fn add(&self, y: usize, from: usize, weight: f32, sums: &mut [[f32; LANES]; PRODUCTS]) {
        let count = LANES.min(self.width - from);
        let mut q = [[0.0_f32; LANES]; RANK];
        for i in 0..RANK {
            let row = &self.q[i][y * self.width + from..];
            if count == LANES {
                q[i].copy_from_slice(&row[..LANES]);
            } else {
                q[i][..count].copy_from_slice(&row[..count]);
            }
        }
        let mut p = 0;
        for i in 0..RANK {
            let mut weighted = [0.0_f32; LANES];
            for lane in 0..LANES {
                weighted[lane] = weight * q[i][lane];
            }
            for j in i..RANK {
                let sum = &mut sums[p];
                for lane in 0..LANES {
                    sum[lane] += weighted[lane] * q[j][lane];
                }
                p += 1;
            }
        }
    }
}

/// The lowest point of one curve.
struct Minimum {
    beta: f32,
    /// d²E/dβ² there.
    second_derivative: f32,
    /// E there.
    residual: f32,
    /// Whether another minimum is nearly as low.
    ambiguous: bool,
    /// Energy of all q_j: of noise alone, the noise's variance times their number.
    energy: f32,
}

impl Minimum {
    /// By the parabola through the lowest candidate and its neighbours.
    fn of(curves: &Curves, lane: usize, energy: f32, bank: &KernelBank) -> Minimum {
        let lowest = (curves.lowest[lane] as usize).clamp(1, CANDIDATES - 2);
        let [before, here, after] =
            [lowest - 1, lowest, lowest + 1].map(|candidate| curves.energy[candidate][lane]);
        let second_difference = (before - 2.0 * here + after).max(1e-9);
        let offset = (0.5 * (before - after) / second_difference).clamp(-1.0, 1.0);
        Minimum {
            beta: bank.corrected(beta_of(lowest) as f32 + BETA_STEP * offset),
            second_derivative: second_difference / (BETA_STEP * BETA_STEP),
            residual: here,
            ambiguous: curves.second[lane] - here < AMBIGUOUS * (curves.highest[lane] - here),
            energy,
        }
    }
}

/// The minima over one window, at every point of its grid.
struct Minima {
    width: usize,
    height: usize,
    step: usize,
    sigma_px: f64,
    points: Vec<Minimum>,
}

impl Minima {
    fn of(means: &Means<PRODUCTS>, bank: &KernelBank) -> Minima {
        let count = means.width * means.height;
        let squares: Vec<usize> =
            product_pairs().enumerate().filter(|(_, (i, j))| i == j).map(|(p, _)| p).collect();
        let mut points = Vec::with_capacity(count);
        for from in (0..count).step_by(LANES) {
            let taken = LANES.min(count - from);
            let mut products = [[0.0; LANES]; PRODUCTS];
            for (lanes, plane) in products.iter_mut().zip(&means.planes) {
                lanes[..taken].copy_from_slice(&plane[from..][..taken]);
            }
            let curves = Arch::new().dispatch(EvaluateCurves { products: &products, bank });
            points.extend((0..taken).map(|lane| {
                let energy = squares.iter().fold(0.0, |sum, &p| sum + products[p][lane]);
                Minimum::of(&curves, lane, energy, bank)
            }));
        }
        Minima {
            width: means.width,
            height: means.height,
            step: means.step,
            sigma_px: means.sigma_px,
            points,
        }
    }

    /// β with the standard deviation that noise gives it, how badly one depth explains the window, and how much texture
    /// there is to say so.
    fn samples(&self, noise_sigma: f64) -> WindowSamples {
        let noise = noise_sigma * noise_sigma;
        let spread = (2.0 * RANK as f64 / independent(self.sigma_px)).sqrt();
        let least_energy = noise * (RANK as f64 + SIGNIFICANCE * spread);
        let sample = |(minimum, beta): (&Minimum, f32)| {
            let second_derivative = f64::from(minimum.second_derivative);
            let textured = f64::from(minimum.energy) >= least_energy;
            let variance = variance(minimum.residual.into(), second_derivative, noise, self.sigma_px);
            Sample {
                beta,
                sigma: if textured && !minimum.ambiguous { variance.sqrt() as f32 } else { f32::INFINITY },
                misfit: (f64::from(minimum.residual) / (LEAK * second_derivative + noise)) as f32,
                ambiguous: textured && minimum.ambiguous,
                scattered: false,
            }
        };
        let points = self.points.iter().zip(self.texture_centred()).map(sample).collect();
        WindowSamples {
            sigma_px: self.sigma_px,
            samples: Samples { width: self.width, height: self.height, step: self.step, points },
            texture: self.points.iter().map(|minimum| minimum.second_derivative).collect(),
            noise_variance: (2.0 * noise / independent(self.sigma_px)) as f32,
        }
    }

    /// β as if the texture lay evenly about each point. A window measures β at the middle of its texture, weighed by
    /// the second derivative h: σ²∇h/h away from its own middle. The slope of β undoes that.
    fn texture_centred(&self) -> Vec<f32> {
        let (width, height) = (self.width, self.height);
        let variance_steps = ((self.sigma_px / self.step as f64).powi(2)) as f32;
        let mut beta: Vec<f32> = self.points.iter().map(|minimum| minimum.beta).collect();
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let at = y * width + x;
                let mut correction = 0.0;
                for (before, after) in [(at - 1, at + 1), (at - width, at + width)] {
                    let [before, after] = [before, after].map(|at| &self.points[at]);
                    let slope = 0.5 * (after.beta - before.beta);
                    let off_middle =
                        variance_steps * 0.5 * (after.second_derivative - before.second_derivative)
                            / self.points[at].second_derivative;
                    correction += slope * off_middle.clamp(-MOST_OFF_MIDDLE, MOST_OFF_MIDDLE);
                }
                beta[at] -= correction.clamp(-MOST_CORRECTION, MOST_CORRECTION);
            }
        }
        beta
    }

    /// The pictures' noise from the tenth percentile of the residuals: most windows hold one depth, some hold two.
    fn noise_sigma(&self) -> f64 {
        let left = |minimum: &Minimum| minimum.residual - LEAST_LEAK as f32 * minimum.second_derivative;
        let mut residuals: Vec<f32> = self.points.iter().map(left).collect();
        let tenth = residuals.len() / 10;
        let (_, &mut residual, _) = residuals.select_nth_unstable_by(tenth, f32::total_cmp);
        // A window's own noise scatters: the tenth percentile lies about a standard deviation below the mean.
        let below = 1.0 - (2.0 / independent(self.sigma_px)).sqrt();
        (f64::from(residual.max(0.0)) / below.max(0.5)).sqrt()
    }
}

/// Samples of independent noise in a Gaussian window.
fn independent(sigma_px: f64) -> f64 {
    4.0 * std::f64::consts::PI * sigma_px * sigma_px / NOISE_AREA_PX
}

/// The variance of β at a minimum of E: what noise of this variance makes, and what it doesn't explain.
pub(super) fn variance(residual: f64, second_derivative: f64, noise: f64, sigma_px: f64) -> f64 {
    let relative = 2.0 / independent(sigma_px);
    let left = (residual - noise * (1.0 + NOISE_DEVIATIONS * relative.sqrt())).max(0.0);
    (relative * noise + LEFT_WEIGHT * left) / second_derivative
}

/// Grid steps that the texture's middle may be taken to lie away from a window's.
const MOST_OFF_MIDDLE: f32 = 2.0;
/// The most that β is corrected by: beyond it the relief is no slope.
const MOST_CORRECTION: f32 = 0.05;

/// The curves of a block of points: E at each candidate β, and their extremes.
struct Curves {
    energy: [[f32; LANES]; CANDIDATES],
    /// The candidate of the lowest point.
    lowest: [f32; LANES],
    highest: [f32; LANES],
    /// The lowest other minimum.
    second: [f32; LANES],
}

/// Evaluates E at all candidates.
struct EvaluateCurves<'a> {
    products: &'a [[f32; LANES]; PRODUCTS],
    bank: &'a KernelBank,
}

impl WithSimd for EvaluateCurves<'_> {
    type Output = Curves;

    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators over the lanes are not inlined into vector code here"
    )]
    fn with_simd<S: Simd>(self, _simd: S) -> Curves {
        let mut energy = [[0.0_f32; LANES]; CANDIDATES];
        for candidate in 0..CANDIDATES {
            let form = &self.bank.forms[candidate];
            let mut sum = [0.0_f32; LANES];
            for p in 0..PRODUCTS {
                for lane in 0..LANES {
                    sum[lane] += form[p] * self.products[p][lane];
                }
            }
            energy[candidate] = sum;
        }
        let (mut least, mut lowest, mut highest) = (energy[0], [0.0_f32; LANES], energy[0]);
        for candidate in 1..CANDIDATES {
            for lane in 0..LANES {
                let here = energy[candidate][lane];
                let lower = here < least[lane];
                lowest[lane] = if lower { candidate as f32 } else { lowest[lane] };
                least[lane] = if lower { here } else { least[lane] };
                highest[lane] = if here > highest[lane] { here } else { highest[lane] };
            }
        }
        let mut second = [f32::INFINITY; LANES];
        for candidate in 0..CANDIDATES {
            let here = energy[candidate];
            let before = if candidate > 0 { energy[candidate - 1] } else { [f32::INFINITY; LANES] };
            let after =
                if candidate + 1 < CANDIDATES { energy[candidate + 1] } else { [f32::INFINITY; LANES] };
            for lane in 0..LANES {
                let valley = (here[lane] < before[lane]) & (here[lane] <= after[lane]);
                let other = (candidate as f32 - lowest[lane]).abs() > SAME_VALLEY;
                let value = if valley & other { here[lane] } else { f32::INFINITY };
                second[lane] = if value < second[lane] { value } else { second[lane] };
            }
        }
        Curves { energy, lowest, highest, second }
    }
}

/// β of a registered and matched pair that was halved `halvings` times. `least_noise` is a lower bound of the noise, in
/// gray levels.
pub(super) fn estimate(
    near: &Image,
    far: &Image,
    bank: &KernelBank,
    window: Window,
    halvings: u32,
    least_noise: f64,
) -> Estimate {
    let (width, height) = (near.width(), near.height());
    let q = filtered(near, far, bank);
    let products = Products { width, q: &q };
    let scale = f64::from(1_u32 << halvings);
    let windows: Vec<f64> = match window {
        Window::Px(px) => vec![(px / scale).max(1.0)],
        Window::Auto if halvings == 0 => WINDOWS_PX.to_vec(),
        Window::Auto => HALVED_WINDOWS_PX.to_vec(),
    };
    let mut means = Means::over(&products, width, height, windows[0]);
    let mut minima = vec![Minima::of(&means, bank)];
    for &sigma_px in &windows[1..] {
        means = means.widened(sigma_px);
        minima.push(Minima::of(&means, bank));
    }
    let noise_sigma = minima[0].noise_sigma().max(least_noise);
    let windows: Vec<WindowSamples> = minima.iter().map(|minima| minima.samples(noise_sigma)).collect();
    Estimate { samples: chosen(&windows), noise_sigma: Some(noise_sigma) }
}
