//! Which window answers at each point of the grid, and how far it is trusted.
//!
//! A window measures the depth of the texture that it holds, wherever in it that lies. So it counts only where its texture
//! lies about the point, and its expected error is of five parts: noise, what noise doesn't explain of its residual (two
//! depths in one window leave some), what textures differ by, the scatter of narrower windows' estimates about a plane
//! ([`super::spread`]: within the window, or beside the point, so that a point near a step is held against its own side),
//! and how much of what is around the point is plain, unless all of the picture shows one surface. The window of the least
//! expected error answers. Within the blur of a step none does: estimates belong to neither side there.

use super::dense_map::{MOST_BETA, MOST_MISFIT, MOST_SIGMA};
use super::estimate::{Sample, Samples};
use super::spread::Spread;
use super::windows::{Means, Planes};
use crate::eigen::Symmetric;

/// What one window measured.
pub(super) struct WindowSamples {
    /// Standard deviation of the window in pixels.
    pub(super) sigma_px: f64,
    /// β with its evidence; its deviation is that which noise makes.
    pub(super) samples: Samples,
    /// How much texture says so at each point: d²E/dβ².
    pub(super) texture: Vec<f32>,
    /// Variance that noise gives β where that is 1.
    pub(super) noise_variance: f32,
}

/// What textures differ by in β, whatever the window: their spectra aren't 1/f.
pub(super) const TEXTURE_SIGMA: f32 = 0.006;
/// The middle of a window's texture may lie this many of its standard deviations off the point.
const MOST_OFF_MIDDLE: f32 = 0.7;
/// The narrowest window has this part of a wider one's texture at least: else that is elsewhere.
const LEAST_OWN_TEXTURE: f32 = 0.3;
/// The narrowest window has this many times the widest one's texture at most: else it is that of a lone contour, and to
/// which of its two sides its depth belongs is not known.
const MOST_OWN_TEXTURE: f32 = 4.2;
/// Estimates scatter within this many standard deviations of a window.
const SPREAD_WINDOW: f64 = 1.6;
/// Surroundings whose plain part counts (standard deviation, pixels).
const SURROUNDINGS_PX: f64 = 16.0;
/// How much plain surroundings enlarge the expected error.
const PLAIN_WEIGHT: f32 = 3.8;
/// Where noise alone gives the narrowest window's β a larger deviation, a surface is plain.
const PLAIN_SIGMA: f32 = 0.015;
/// A picture shows one surface if this part of what is known, which is at least that part of the picture, lies on it: within
/// three expected errors, or so much of β. On photographed scenes with steps a third to six tenths do.
const ON_SURFACE_PART: f64 = 0.9;
const LEAST_KNOWN: f64 = 0.01;
const ON_SURFACE: f64 = 0.06;
/// Rounds of fitting it, its terms, and what keeps those small that nothing determines.
const SURFACE_ROUNDS: usize = 4;
const TERMS: usize = 6;
const RIDGE: f64 = 1e-6;
/// No depth has a larger expected error; β spans 2 over the working range.
const MOST_BETA_SIGMA: f32 = 2.0 * MOST_SIGMA;

/// The answer at each point of the finest grid. `windows` ascend.
pub(super) fn chosen(windows: &[WindowSamples]) -> Samples {
    let finest = &windows[0].samples;
    let &Samples { width, height, step, .. } = finest;
    let widths: Vec<f64> =
        windows.iter().map(|window| SPREAD_WINDOW * window.sigma_px / step as f64).collect();
    let spreads = Spread::over(finest, &widths);
    let points = (0..width * height).map(|at| least_expected_error(windows, &spreads, at)).collect();
    let mut samples = Samples { width, height, step, points };
    doubt_surroundings(&mut samples, &windows[0]);
    samples
}

/// The choice at point `at` of the finest grid.
fn least_expected_error(windows: &[WindowSamples], spreads: &[Spread], at: usize) -> Sample {
    let finest = &windows[0].samples;
    let (x, y) = (at % finest.width, at / finest.width);
    let place_px = [x, y].map(|v| v * finest.step);
    let own_texture = windows[0].texture[at];
    let mut chosen = Sample { ambiguous: finest.points[at].ambiguous, ..Sample::UNKNOWN };
    let mut noise_sigma = f32::INFINITY;
    let mut lone_contour = false;
    for (window, spread) in windows.iter().zip(spreads) {
        let Some(point) = window.at(place_px) else { continue };
        lone_contour = own_texture > MOST_OWN_TEXTURE * point.texture;
        if point.off_middle > MOST_OFF_MIDDLE || own_texture < LEAST_OWN_TEXTURE * point.texture {
            continue;
        }
        noise_sigma = noise_sigma.min(point.sigma);
        let variance = point.sigma * point.sigma + TEXTURE_SIGMA * TEXTURE_SIGMA;
        if variance >= chosen.sigma * chosen.sigma {
            continue;
        }
        let sigma = (variance + spread.beside([x, y], point.beta, point.sigma * point.sigma)).sqrt();
        if sigma < chosen.sigma {
            chosen = Sample { beta: point.beta, sigma, misfit: point.misfit, ..chosen };
        }
    }
    if lone_contour {
        return Sample { ambiguous: false, ..Sample::UNKNOWN };
    }
    chosen.scattered = chosen.sigma > MOST_BETA_SIGMA && noise_sigma <= MOST_BETA_SIGMA;
    chosen.ambiguous &= chosen.sigma.is_infinite();
    chosen
}

/// Whether nearly all that is known lies on one smooth surface, quadratic in the picture: then nothing speaks for steps.
fn is_one_surface(samples: &Samples) -> bool {
    let [columns, rows] = [samples.width, samples.height].map(|count| 2.0 / count as f64);
    let known = || samples.points.iter().enumerate().filter(|(_, sample)| is_known(sample));
    let terms = |at: usize| {
        let (x, y) = ((at % samples.width) as f64 * columns - 1.0, (at / samples.width) as f64 * rows - 1.0);
        [1.0, x, y, x * x, x * y, y * y]
    };
    let mut surface = [0.0; TERMS];
    let off = |surface: &[f64; TERMS], at: usize, sample: &Sample| {
        let level: f64 = terms(at).iter().zip(surface).map(|(term, factor)| term * factor).sum();
        (f64::from(sample.beta) - level).abs()
    };
    let is_on = |surface: &[f64; TERMS], at: usize, sample: &Sample| {
        off(surface, at, sample) <= ON_SURFACE.max(3.0 * f64::from(sample.sigma))
    };
    for round in 0..SURFACE_ROUNDS {
        let (mut normal, mut right) = (vec![0.0; TERMS * TERMS], vec![0.0; TERMS]);
        for (at, sample) in known().filter(|(at, sample)| round == 0 || is_on(&surface, *at, sample)) {
            let terms = terms(at);
            for (i, a) in terms.iter().enumerate() {
                right[i] += a * f64::from(sample.beta);
                for (j, b) in terms.iter().enumerate() {
                    normal[i * TERMS + j] += a * b;
                }
            }
        }
        (0..TERMS).for_each(|i| normal[i * TERMS + i] += RIDGE * samples.points.len() as f64);
        let Some(normal) = Symmetric::of(&normal, TERMS) else { return false };
        surface.copy_from_slice(&normal.solve(&right));
    }
    let (mut count, mut on) = (0, 0);
    for (at, sample) in known() {
        count += 1;
        on += usize::from(is_on(&surface, at, sample));
    }
    count as f64 >= LEAST_KNOWN * samples.points.len() as f64 && on as f64 >= ON_SURFACE_PART * count as f64
}

/// Enlarges the expected error where much of what is around is plain: a step there would not show. Where all that shows is
/// one surface nothing speaks for steps.
fn doubt_surroundings(samples: &mut Samples, narrowest: &WindowSamples) {
    if is_one_surface(samples) {
        return;
    }
    let (width, height, step) = (samples.width, samples.height, samples.step as f64);
    let least_texture = narrowest.noise_variance / (PLAIN_SIGMA * PLAIN_SIGMA);
    let points = samples.points.iter().zip(&narrowest.texture);
    let shows: Vec<f32> =
        points.map(|(sample, &texture)| f32::from(is_known(sample) || texture > least_texture)).collect();
    let rows = Planes { width, planes: [&shows] };
    let around = Means::over(&rows, width, height, SURROUNDINGS_PX / step);
    for (at, sample) in samples.points.iter_mut().enumerate() {
        let [x, y] = [at % width, at / width].map(|v| v / around.step);
        let plain = (1.0 - around.planes[0][y * around.width + x]).max(0.0);
        sample.sigma *= 1.0 + PLAIN_WEIGHT * plain;
    }
}

/// Whether a sample is a depth, but for what is around it.
fn is_known(sample: &Sample) -> bool {
    sample.sigma <= MOST_BETA_SIGMA && sample.beta.abs() <= MOST_BETA && sample.misfit <= MOST_MISFIT
}

/// One window's answer at one pixel.
struct Point {
    beta: f32,
    sigma: f32,
    misfit: f32,
    texture: f32,
    /// How far the middle of the texture lies off the window's, in its standard deviations.
    off_middle: f32,
}

impl WindowSamples {
    /// The window's answer at a pixel, bilinear between the grid's points; `None` where one of them has none.
    fn at(&self, [x_px, y_px]: [usize; 2]) -> Option<Point> {
        let &Samples { width, height, step, .. } = &self.samples;
        let along = |px: usize, count: usize| {
            let before = (px / step).min(count - 1);
            (before, (before + 1).min(count - 1), (px % step) as f32 / step as f32)
        };
        let ((x0, x1, u), (y0, y1, v)) = (along(x_px, width), along(y_px, height));
        let corners = [
            (y0 * width + x0, (1.0 - u) * (1.0 - v)),
            (y0 * width + x1, u * (1.0 - v)),
            (y1 * width + x0, (1.0 - u) * v),
            (y1 * width + x1, u * v),
        ];
        let mut point = Point { beta: 0.0, sigma: 0.0, misfit: 0.0, texture: 0.0, off_middle: 0.0 };
        for (at, weight) in corners.into_iter().filter(|(_, weight)| *weight > 0.0) {
            let corner = &self.samples.points[at];
            if corner.sigma.is_infinite() {
                return None;
            }
            point.beta += weight * corner.beta;
            point.sigma += weight * corner.sigma;
            point.misfit += weight * corner.misfit;
            point.texture += weight * self.texture[at];
        }
        // σ²∇h/h off the middle, as in the texture's own correction; over σ.
        let texture = |x: usize, y: usize| self.texture[y * width + x];
        let across = texture((x0 + 1).min(width - 1), y0) - texture(x0.saturating_sub(1), y0);
        let down = texture(x0, (y0 + 1).min(height - 1)) - texture(x0, y0.saturating_sub(1));
        point.off_middle = across.hypot(down) * self.sigma_px as f32 / (2 * step) as f32 / texture(x0, y0);
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of β with a small wave that no expected error explains, and a depth every third column alone.
    fn samples(beta: impl Fn(f32, f32) -> f32) -> Samples {
        let (width, height) = (60, 40);
        let point = |at: usize| {
            let (x, y) = ((at % width) as f32 / width as f32, (at / width) as f32 / height as f32);
            let known = Sample { sigma: 0.01, misfit: 1.0, ..Sample::UNKNOWN };
            let wave = 0.02 * (at as f32 * 1.7).sin();
            if at.is_multiple_of(3) { Sample { beta: beta(x, y) + wave, ..known } } else { Sample::UNKNOWN }
        };
        Samples { width, height, step: 4, points: (0..width * height).map(point).collect() }
    }

    #[test]
    fn slants_and_bowls_are_one_surface_and_steps_are_not() {
        assert!(is_one_surface(&samples(|x, y| 0.8 * x - 0.5 * y)));
        assert!(is_one_surface(&samples(|x, y| 0.9 * (x - 0.4).powi(2) + 0.6 * x * y - 0.2)));
        assert!(!is_one_surface(&samples(|x, _| if x < 0.7 { -0.3 } else { 0.3 })));
        assert!(!is_one_surface(&samples(|x, y| if (x - 0.5).hypot(y - 0.5) < 0.25 { 0.4 } else { 0.0 })));
        let nothing = Samples { points: vec![Sample::UNKNOWN; 2400], ..samples(|_, _| 0.0) };
        assert!(!is_one_surface(&nothing));
    }
}
