//! The method `gram`: at the right β, H_f·n = H_n·f. The energy of what is left, E(β) = c(β)ᵀ Q c(β) with
//! Q_ij = ⟨q_i q_j⟩, is a curve over β whose minimum is the depth, whose height there says whether any depth explains
//! the window, and whose bend says how well the depth is known.

use pulp::{Arch, Simd, WithSimd};

use super::Window;
use super::estimate::{Estimate, Samples};
use super::filtering::filtered;
use super::kernels::{KernelBank, LABELS, PRODUCTS, RANK, STEP, beta_of, product_pairs};
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
/// Labels about the minimum that belong to it.
const SAME_VALLEY: f32 = 3.0;
/// What the kernels leave of the texture at the right β, as a part of the curve's bend.
const LEAK: f64 = 0.02;
/// Half-width of the interval that a wider window's answer must share with all narrower ones', in standard deviations.
const AGREEMENT: f64 = 1.2;
/// A window whose β has a smaller standard deviation is good enough to stop at.
const ENOUGH: f32 = 0.03;
/// What textures differ by in β, whatever the window: their spectra aren't 1/f.
const TEXTURE_SIGMA: f32 = 0.006;

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

/// The curve's minimum at every point of a grid.
struct Minima {
    width: usize,
    height: usize,
    step: usize,
    sigma_px: f64,
    beta: Vec<f32>,
    /// d²E/dβ² at the minimum.
    bend: Vec<f32>,
    /// E there.
    least: Vec<f32>,
    /// Whether a second minimum is nearly as low.
    ambiguous: Vec<bool>,
    /// Energy of all q_j: of noise alone, the noise's variance times their number.
    energy: Vec<f32>,
}

impl Minima {
    fn of(means: &Means<PRODUCTS>, bank: &KernelBank) -> Minima {
        let count = means.width * means.height;
        let mut minima = Minima {
            width: means.width,
            height: means.height,
            step: means.step,
            sigma_px: means.sigma_px,
            beta: vec![0.0; count],
            bend: vec![0.0; count],
            least: vec![0.0; count],
            ambiguous: vec![false; count],
            energy: vec![0.0; count],
        };
        let squares: Vec<usize> =
            product_pairs().enumerate().filter(|(_, (i, j))| i == j).map(|(p, _)| p).collect();
        for from in (0..count).step_by(LANES) {
            let taken = LANES.min(count - from);
            let mut products = [[0.0; LANES]; PRODUCTS];
            for (lanes, plane) in products.iter_mut().zip(&means.planes) {
                lanes[..taken].copy_from_slice(&plane[from..][..taken]);
            }
            let curves = Arch::new().dispatch(Curves { products: &products, bank });
            let mut energy = [0.0; LANES];
            for &p in &squares {
                energy.iter_mut().zip(&products[p]).for_each(|(sum, v)| *sum += v);
            }
            for (lane, energy) in energy.into_iter().enumerate().take(taken) {
                let at = from + lane;
                // The parabola through the lowest label and its neighbours.
                let label = (curves.lowest[lane] as usize).clamp(1, LABELS - 2);
                let [before, here, after] =
                    [label - 1, label, label + 1].map(|label| curves.energy[label][lane]);
                let second_difference = (before - 2.0 * here + after).max(1e-9);
                let offset = (0.5 * (before - after) / second_difference).clamp(-1.0, 1.0);
                minima.beta[at] = bank.read(beta_of(label) as f32 + STEP * offset);
                minima.bend[at] = second_difference / (STEP * STEP);
                minima.least[at] = here;
                minima.ambiguous[at] = curves.second[lane] - here < AMBIGUOUS * (curves.highest[lane] - here);
                minima.energy[at] = energy;
            }
        }
        minima
    }

    /// Independent samples in a window.
    fn samples(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.sigma_px * self.sigma_px / NOISE_AREA_PX
    }

    /// β with its standard deviation and how badly one depth explains the window; the deviation is infinite where
    /// there is nothing to go by.
    fn judged(&self, noise_sigma: f64) -> Judged {
        let (noise, samples) = (noise_sigma * noise_sigma, self.samples());
        let silent = noise * (RANK as f64 + SIGNIFICANCE * (2.0 * RANK as f64 / samples).sqrt());
        let count = self.beta.len();
        let mut judged = Judged {
            grid: (self.width, self.height, self.step),
            beta: self.centred(),
            sigma: Vec::with_capacity(count),
            misfit: Vec::with_capacity(count),
            ambiguous: Vec::with_capacity(count),
        };
        for at in 0..count {
            let bend = f64::from(self.bend[at]);
            let loud = f64::from(self.energy[at]) >= silent;
            judged.ambiguous.push(loud && self.ambiguous[at]);
            let known = loud && !self.ambiguous[at];
            judged.sigma.push(if known {
                (2.0 * noise / (samples * bend)).sqrt() as f32
            } else {
                f32::INFINITY
            });
            judged.misfit.push((f64::from(self.least[at]) / (LEAK * bend + noise)) as f32);
        }
        judged
    }

    /// β as if the texture lay evenly about each point. A window measures β at the middle of its texture, weighed by the
    /// bend h: σ²∇h/h away from its own middle. With the slope of β that is undone.
    fn centred(&self) -> Vec<f32> {
        let (width, height) = (self.width, self.height);
        let variance_steps = ((self.sigma_px / self.step as f64).powi(2)) as f32;
        let mut beta = self.beta.clone();
        for y in 1..height.saturating_sub(1) {
            for x in 1..width.saturating_sub(1) {
                let at = y * width + x;
                let mut correction = 0.0;
                for (before, after) in [(at - 1, at + 1), (at - width, at + width)] {
                    let slope = 0.5 * (self.beta[after] - self.beta[before]);
                    let off_middle =
                        variance_steps * 0.5 * (self.bend[after] - self.bend[before]) / self.bend[at];
                    correction += slope * off_middle.clamp(-MOST_OFF_MIDDLE, MOST_OFF_MIDDLE);
                }
                beta[at] -= correction.clamp(-MOST_CORRECTION, MOST_CORRECTION);
            }
        }
        beta
    }
}

/// Grid steps that the texture's middle may be taken to lie away from a window's.
const MOST_OFF_MIDDLE: f32 = 2.0;
/// The most that β is corrected by: beyond it the relief is no slope.
const MOST_CORRECTION: f32 = 0.05;

/// The estimate of one window.
struct Judged {
    grid: (usize, usize, usize),
    beta: Vec<f32>,
    sigma: Vec<f32>,
    misfit: Vec<f32>,
    ambiguous: Vec<bool>,
}

/// The curves of a block of points: E by label, and their extremes.
struct CurveBlock {
    energy: [[f32; LANES]; LABELS],
    /// Label of the lowest point.
    lowest: [f32; LANES],
    highest: [f32; LANES],
    /// The lowest other minimum.
    second: [f32; LANES],
}

struct Curves<'a> {
    products: &'a [[f32; LANES]; PRODUCTS],
    bank: &'a KernelBank,
}

impl WithSimd for Curves<'_> {
    type Output = CurveBlock;

    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators over the lanes are not inlined into vector code here"
    )]
    fn with_simd<S: Simd>(self, _simd: S) -> CurveBlock {
        let mut energy = [[0.0_f32; LANES]; LABELS];
        for label in 0..LABELS {
            let form = &self.bank.forms[label];
            let mut sum = [0.0_f32; LANES];
            for p in 0..PRODUCTS {
                for lane in 0..LANES {
                    sum[lane] += form[p] * self.products[p][lane];
                }
            }
            energy[label] = sum;
        }
        let (mut least, mut lowest, mut highest) = (energy[0], [0.0_f32; LANES], energy[0]);
        for label in 1..LABELS {
            for lane in 0..LANES {
                let here = energy[label][lane];
                let lower = here < least[lane];
                lowest[lane] = if lower { label as f32 } else { lowest[lane] };
                least[lane] = if lower { here } else { least[lane] };
                highest[lane] = if here > highest[lane] { here } else { highest[lane] };
            }
        }
        let mut second = [f32::INFINITY; LANES];
        for label in 0..LABELS {
            let here = energy[label];
            let before = if label > 0 { energy[label - 1] } else { [f32::INFINITY; LANES] };
            let after = if label + 1 < LABELS { energy[label + 1] } else { [f32::INFINITY; LANES] };
            for lane in 0..LANES {
                let valley = (here[lane] < before[lane]) & (here[lane] <= after[lane]);
                let other = (label as f32 - lowest[lane]).abs() > SAME_VALLEY;
                let candidate = if valley & other { here[lane] } else { f32::INFINITY };
                second[lane] = if candidate < second[lane] { candidate } else { second[lane] };
            }
        }
        CurveBlock { energy, lowest, highest, second }
    }
}

/// β of a registered and matched pair. `halvings` is how often it was halved before; `least_noise` what the noise
/// is never less than, in grey levels.
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
    let mut means = Means::up_to(&products, width, height, windows[0]);
    let mut minima = vec![Minima::of(&means, bank)];
    for &sigma_px in &windows[1..] {
        means = means.widened(sigma_px);
        minima.push(Minima::of(&means, bank));
    }
    let noise_sigma = noise_of(&minima[minima.len().min(2) - 1]).max(least_noise);
    let judged: Vec<Judged> = minima.iter().map(|minima| minima.judged(noise_sigma)).collect();
    Estimate { samples: chosen(&judged), noise_sigma: Some(noise_sigma) }
}

/// The tenth percentile of what the best depth leaves, as noise: most windows hold one depth, some hold two.
fn noise_of(minima: &Minima) -> f64 {
    let mut least = minima.least.clone();
    let tenth = least.len() / 10;
    let (_, &mut value, _) = least.select_nth_unstable_by(tenth, f32::total_cmp);
    1.1 * f64::from(value.max(0.0)).sqrt()
}

/// At each point of the finest grid the widest window whose answer agrees with all narrower ones' (intersection of
/// confidence intervals): wide on planes, narrow at steps.
fn chosen(judged: &[Judged]) -> Samples {
    let (width, height, step) = judged[0].grid;
    let mut samples = Samples::new(width, height, step);
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            let mut ambiguous = false;
            for (number, window) in judged.iter().enumerate() {
                let Some(point) = window.at(x * step, y * step) else {
                    ambiguous |= number == 0 && window.ambiguous[at];
                    continue;
                };
                let reach = AGREEMENT * point.sigma;
                let (new_low, new_high) = (low.max(point.beta - reach), high.min(point.beta + reach));
                (low, high) = match (new_low <= new_high, samples.sigma[at] < ENOUGH) {
                    (true, _) => (new_low, new_high),
                    (false, true) => break,
                    // What the narrower ones say is too unsure to be held against a wider one.
                    (false, false) => (point.beta - reach, point.beta + reach),
                };
                samples.beta[at] = point.beta as f32;
                samples.sigma[at] = point.sigma as f32;
                samples.misfit[at] = point.misfit as f32;
            }
            samples.ambiguous[at] = ambiguous && samples.sigma[at].is_infinite();
            samples.sigma[at] = (samples.sigma[at].powi(2) + TEXTURE_SIGMA * TEXTURE_SIGMA).sqrt();
        }
    }
    samples
}

/// One window's answer at one pixel.
struct Point {
    beta: f64,
    sigma: f64,
    misfit: f64,
}

impl Judged {
    /// The answer at a pixel, between the grid's points; `None` where one of them has none.
    fn at(&self, x_px: usize, y_px: usize) -> Option<Point> {
        let (width, height, step) = self.grid;
        let along = |px: usize, count: usize| {
            let before = (px / step).min(count - 1);
            (before, (before + 1).min(count - 1), (px % step) as f64 / step as f64)
        };
        let ((x0, x1, u), (y0, y1, v)) = (along(x_px, width), along(y_px, height));
        let corners = [
            (y0 * width + x0, (1.0 - u) * (1.0 - v)),
            (y0 * width + x1, u * (1.0 - v)),
            (y1 * width + x0, (1.0 - u) * v),
            (y1 * width + x1, u * v),
        ];
        let mut point = Point { beta: 0.0, sigma: 0.0, misfit: 0.0 };
        for (at, weight) in corners.into_iter().filter(|(_, weight)| *weight > 0.0) {
            if self.sigma[at].is_infinite() {
                return None;
            }
            point.beta += weight * f64::from(self.beta[at]);
            point.sigma += weight * f64::from(self.sigma[at]);
            point.misfit += weight * f64::from(self.misfit[at]);
        }
        Some(point)
    }
}
