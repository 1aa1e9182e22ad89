//! The method `stm` (Subbarao and Surya): n − f = (σ_n² − σ_f²)/4 · ∇²((n + f)/2), by least squares in a window.
//!
//! Exact for small blurs only. For larger ones the result depends on the texture: the curve of a 1/f spectrum under the
//! optics' own transfer functions replaces the closed form, and equals it where blur is small.

use super::Optics;
use super::estimate::{Estimate, Sample, Samples};
use super::otf::pillbox;
use super::windows::{Means, Planes};
use crate::imaging::Image;
use crate::vision::smoothed;

/// Standard deviation of the smoothing before the Laplacian, in pixels.
const PREFILTER_PX: f32 = 1.5;
/// Area over which residuals are correlated, in pixels, as measured on rendered pictures: a window has its area over this
/// independent samples.
const NOISE_AREA_PX: f64 = 10.0;
/// The window of `auto`.
const WINDOW_PX: f64 = 4.0;
/// Frequencies of the curve along each axis of a whole period.
const GRID: usize = 48;
/// Points of the curve, evenly spaced in β.
const POINTS: usize = 121;
/// β of the outermost points.
const OUTERMOST: f64 = 1.5;
/// ⟨L²⟩ below this many times that of noise alone is no texture.
const SIGNIFICANCE: f64 = 6.0;

/// g(β) = σ_n² − σ_f² as the method measures it, falling with β.
#[derive(Clone, Debug)]
pub(super) struct StmCurve {
    beta: Vec<f64>,
    g: Vec<f64>,
}

impl StmCurve {
    pub(super) fn new(optics: &Optics) -> StmCurve {
        let beta: Vec<f64> =
            (0..POINTS).map(|k| -OUTERMOST + 2.0 * OUTERMOST * k as f64 / (POINTS - 1) as f64).collect();
        let mut g: Vec<f64> = beta.iter().map(|&beta| expected(optics.registered_blur_px(beta))).collect();
        // Far out of the range the curve may turn back: there it is made monotone.
        let middle = POINTS / 2;
        for k in middle + 1..POINTS {
            g[k] = g[k].min(g[k - 1] - 1e-6);
        }
        for k in (0..middle).rev() {
            g[k] = g[k].max(g[k + 1] + 1e-6);
        }
        StmCurve { beta, g }
    }

    /// All numbers of the curve, in a fixed order.
    pub(super) fn numbers(&self) -> Vec<f32> {
        self.beta.iter().chain(&self.g).map(|&v| v as f32).collect()
    }

    /// β of a measured g, and dβ/dg there.
    fn at(&self, g: f64) -> (f64, f64) {
        let after = self.g.partition_point(|&point| point > g).clamp(1, POINTS - 1);
        let slope = (self.beta[after] - self.beta[after - 1]) / (self.g[after] - self.g[after - 1]);
        let beta = self.beta[after] + (g - self.g[after]) * slope;
        (beta.clamp(-OUTERMOST, OUTERMOST), slope)
    }
}

/// 4⟨(n − f)L⟩/⟨L²⟩ of a texture with a 1/f spectrum, blurred by these diameters.
fn expected([near_px, far_px]: [f64; 2]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for i in 0..GRID {
        for j in 0..GRID {
            let signed = |k: usize| (k as f64 - if k > GRID / 2 { GRID as f64 } else { 0.0 }) / GRID as f64;
            let frequency = signed(i).hypot(signed(j));
            if frequency == 0.0 || frequency > 0.5 {
                continue;
            }
            let angle = |k: usize| (std::f64::consts::TAU * signed(k)).cos();
            let laplacian = 2.0 * angle(i) + 2.0 * angle(j) - 4.0;
            let smoothing = std::f64::consts::TAU * frequency * f64::from(PREFILTER_PX);
            let spectrum = (-smoothing * smoothing).exp() / (frequency * frequency);
            let (n, f) = (pillbox(frequency, near_px), pillbox(frequency, far_px));
            product += spectrum * (n - f) * laplacian * 0.5 * (n + f);
            square += spectrum * (laplacian * 0.5 * (n + f)).powi(2);
        }
    }
    4.0 * product / square
}

/// ∇² by the five-point mask; 0 on the border.
pub(super) fn laplacian(image: &Image) -> Vec<f32> {
    let (width, height) = (image.width(), image.height());
    let mut out = vec![0.0; width * height];
    if width < 3 {
        return out;
    }
    for y in 1..height.saturating_sub(1) {
        let (above, row, below) = (image.row(y - 1), image.row(y), image.row(y + 1));
        let inner = &mut out[y * width + 1..(y + 1) * width - 1];
        for (x, out) in inner.iter_mut().enumerate() {
            *out = above[x + 1] + below[x + 1] + row[x] + row[x + 2] - 4.0 * row[x + 1];
        }
    }
    out
}

/// β of a registered and matched pair. `quantum` is the least noise in gray levels.
pub(super) fn estimate(
    near: &Image,
    far: &Image,
    curve: &StmCurve,
    window_px: Option<f64>,
    quantum: f64,
) -> Estimate {
    let (width, height) = (near.width(), near.height());
    let (near, far) = (smoothed(near, PREFILTER_PX), smoothed(far, PREFILTER_PX));
    let both = Image::new(
        width,
        height,
        near.pixels().iter().zip(far.pixels()).map(|(n, f)| 0.5 * (n + f)).collect(),
    );
    let laplacian = laplacian(&both);
    let difference: Vec<f32> = near.pixels().iter().zip(far.pixels()).map(|(n, f)| n - f).collect();
    let times = |a: &[f32], b: &[f32]| -> Vec<f32> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
    let [dl, ll, dd] =
        [times(&difference, &laplacian), times(&laplacian, &laplacian), times(&difference, &difference)];
    let rows = Planes { width, planes: [&dl, &ll, &dd] };
    let means = Means::over(&rows, width, height, window_px.unwrap_or(WINDOW_PX));

    let independent = 4.0 * std::f64::consts::PI * means.sigma_px * means.sigma_px / NOISE_AREA_PX;
    // Unit noise leaves 2/(4πσ²) of variance in n − f after the prefilter.
    let noise_of_left = 2.0 * std::f64::consts::PI * f64::from(PREFILTER_PX).powi(2);
    let sample = |at: usize| {
        let [dl, ll, dd] = std::array::from_fn(|plane| f64::from(means.planes[plane][at]));
        // What the straight line leaves: noise, and its own standard error.
        let left = (dd - dl * dl / ll.max(f64::MIN_POSITIVE)).max(0.0);
        let noise = (left * noise_of_left).max(quantum * quantum);
        if ll <= SIGNIFICANCE * noise_of_laplacian() * noise {
            return Sample::UNKNOWN;
        }
        let (beta, slope) = curve.at(4.0 * dl / ll);
        let variance = left.max(quantum * quantum / noise_of_left) / (independent * ll);
        let sigma = (4.0 * slope.abs() * variance.sqrt()) as f32;
        Sample { beta: beta as f32, sigma, ..Sample::UNKNOWN }
    };
    let points = (0..means.width * means.height).map(sample).collect();
    let samples = Samples { width: means.width, height: means.height, step: means.step, points };
    Estimate { samples, noise_sigma: None }
}

/// Variance of L from unit noise in both pictures: ∫ (2πρ)⁴ e^(−4π²σ²ρ²) dρ² = 1/(2πσ⁶), and half of it for a mean of two.
fn noise_of_laplacian() -> f64 {
    0.5 / (2.0 * std::f64::consts::PI * f64::from(PREFILTER_PX).powi(6))
}
