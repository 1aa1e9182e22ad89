//! Bringing the far-focused picture into register with the near-focused one.
//!
//! A displacement is read from the phase of the cross-spectrum at low frequencies, where the transfer functions of both
//! blurs are real and positive and leave the phase alone.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

use super::calibration::Registration;
use super::resampling::{Affine, applied, resampled};
use super::windows::{Means, Planes};
use super::{FocalPair, Optics};
use crate::eigen::Symmetric;
use crate::imaging::Image;
use crate::statistics::median;
use crate::vision::smoothed;

/// Lowest frequency used, cycles a pixel: below it the window over the picture prevails.
const LOWEST: f64 = 0.02;
/// Highest frequency used, cycles a pixel.
const HIGHEST: f64 = 0.12;
/// Longest side of what is transformed, in pixels: more pixels add nothing to the accuracy that is needed.
const MOST_SIDE_PX: usize = 1024;
/// A rigid rig shifts by no more.
const MOST_SHIFT_PX: f64 = 6.0;
/// How far the phases must agree: 1 is wholly.
const LEAST_COHERENCE: f64 = 0.9;
/// The lesser principal second moment of the spectrum over the greater, at least: stripes fix one direction only.
const LEAST_ISOTROPY: f64 = 0.2;
/// Frequencies of half the plane that carry the spectrum, at least: a periodic pattern has few, and fits itself shifted by its period.
const LEAST_FREQUENCIES: f64 = 30.0;

/// The map that takes the near picture's pixels to the far one's, by the scale of an ordinary lens.
pub(super) fn scaling(optics: &Optics, width: usize, height: usize) -> Affine {
    let (scale, [x, y]) = (optics.far_scale(), optics.principal_point(width, height));
    [scale, 0.0, x - scale * x, 0.0, scale, y - scale * y]
}

/// By how many pixels, x and y, the far picture's content lies off the near one's; `None` if the texture doesn't fix it.
pub(super) fn shift(near: &Image, far: &Image, largest_blur_px: f64) -> Option<[f64; 2]> {
    CrossSpectrum::of(near, far, largest_blur_px)?.shift()
}

/// The cross-spectrum far · near* at the frequencies that are used.
#[derive(Default)]
struct CrossSpectrum {
    /// Cycles a pixel, x and y.
    frequencies: Vec<[f64; 2]>,
    values: Vec<Complex64>,
}

impl CrossSpectrum {
    fn of(near: &Image, far: &Image, largest_blur_px: f64) -> Option<CrossSpectrum> {
        let [near, far] = [near, far].map(|image| halved(&image.middle(MOST_SIDE_PX)));
        let (width, height) = (near.width(), near.height());
        if width.min(height) < 8 {
            return None;
        }
        let transform = joint_transform(&near, &far);
        let highest = HIGHEST.min(1.0 / largest_blur_px);
        let cycles = |k: usize, length: usize| {
            (k as f64 - if 2 * k > length { length as f64 } else { 0.0 }) / length as f64 / 2.0
        };
        let mut spectrum = CrossSpectrum::default();
        // Half of the plane: the other half repeats it.
        for i in 0..=width / 2 {
            for j in 0..height {
                let frequency = [cycles(i, width), cycles(j, height)];
                let radius = frequency[0].hypot(frequency[1]);
                if radius > LOWEST && radius < highest {
                    let z = transform[i * height + j];
                    let mirrored = transform[(width - i) % width * height + (height - j) % height].conj();
                    let (n, f) = (z + mirrored, (z - mirrored) * Complex64::new(0.0, -1.0));
                    spectrum.frequencies.push(frequency);
                    spectrum.values.push(f * n.conj() * 0.25);
                }
            }
        }
        Some(spectrum)
    }

    /// The shift whose phases fit best, by weighted least squares; `None` if it can't be trusted.
    fn shift(&self) -> Option<[f64; 2]> {
        let magnitudes: Vec<f64> = self.values.iter().map(|v| v.norm()).collect();
        let total: f64 = magnitudes.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for ([x, y], magnitude) in self.frequencies.iter().zip(&magnitudes) {
            xx += magnitude * x * x / total;
            xy += magnitude * x * y / total;
            yy += magnitude * y * y / total;
        }
        let (middle, radius) = ((xx + yy) / 2.0, (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt());
        let squares: f64 = magnitudes.iter().map(|magnitude| (magnitude / total).powi(2)).sum();
        if middle - radius <= LEAST_ISOTROPY * (middle + radius) || 1.0 / squares <= LEAST_FREQUENCIES {
            return None;
        }
        let determinant = xx * yy - xy * xy;
        let mut shift = [0.0; 2];
        for _ in 0..4 {
            let [mut right_x, mut right_y] = [0.0; 2];
            for ((&[x, y], magnitude), &value) in self.frequencies.iter().zip(&magnitudes).zip(&self.values) {
                let phase = residual_phase(shift, [x, y], value);
                right_x += magnitude * x * phase / total;
                right_y += magnitude * y * phase / total;
            }
            shift[0] -= (yy * right_x - xy * right_y) / determinant / TAU;
            shift[1] -= (xx * right_y - xy * right_x) / determinant / TAU;
        }
        let terms = self.frequencies.iter().zip(&magnitudes).zip(&self.values);
        let coherence: Complex64 = terms
            .map(|((&frequency, magnitude), &value)| {
                Complex64::from_polar(magnitude / total, residual_phase(shift, frequency, value))
            })
            .sum();
        let trusted = shift[0].hypot(shift[1]) <= MOST_SHIFT_PX && coherence.norm() > LEAST_COHERENCE;
        trusted.then_some(shift)
    }
}

/// The phase of a cross-spectrum's value that a shift leaves.
fn residual_phase([dx, dy]: [f64; 2], [x, y]: [f64; 2], value: Complex64) -> f64 {
    (value * Complex64::from_polar(1.0, TAU * (x * dx + y * dy))).arg()
}

/// The Fourier transform of near + i·far, column by column; both without their means, under a Hann window.
fn joint_transform(near: &Image, far: &Image) -> Vec<Complex64> {
    let (width, height) = (near.width(), near.height());
    let (near_mean, far_mean) = (near.mean(), far.mean());
    let hann = |at: usize, length: usize| 0.5 - 0.5 * (TAU * at as f64 / (length - 1) as f64).cos();
    let mut values = Vec::with_capacity(width * height);
    let columns: Vec<f64> = (0..width).map(|x| hann(x, width)).collect();
    for y in 0..height {
        let row = hann(y, height);
        let pixels = near.row(y).iter().zip(far.row(y)).zip(&columns);
        values.extend(pixels.map(|((&n, &f), column)| {
            Complex64::new(f64::from(n) - near_mean, f64::from(f) - far_mean) * (row * column)
        }));
    }
    let mut planner = FftPlanner::new();
    planner.plan_fft_forward(width).process(&mut values);
    let mut transposed = vec![Complex64::ZERO; width * height];
    for (y, row) in values.chunks_exact(width).enumerate() {
        row.iter().enumerate().for_each(|(x, &value)| transposed[x * height + y] = value);
    }
    planner.plan_fft_forward(height).process(&mut transposed);
    transposed
}

/// Standard deviation of the smoothing before a picture is halved: what is left of the detail that the halved one can't
/// hold would be taken for depth.
pub(super) const HALVING_SIGMA_PX: f32 = 1.4;

/// Every second pixel of every second row, after smoothing.
pub(super) fn halved(image: &Image) -> Image {
    let smooth = smoothed(image, HALVING_SIGMA_PX);
    Image::from_fn(image.width().div_ceil(2), image.height().div_ceil(2), |x, y| smooth.at(2 * x, 2 * y))
}

/// Sides of the parts that a target is registered by, in pixels.
const TILES_PX: std::ops::RangeInclusive<usize> = 112..=256;
/// A part whose displacement lies this many times the usual off the common map is left out.
const OUTLIER: f64 = 3.0;
/// A part within this many pixels of the common map isn't left out.
const INLIER_PX: f64 = 0.1;
/// Rounds of leaving parts out.
const FIT_ROUNDS: usize = 4;

/// A registration fitted to the displacements of a picture's parts.
pub(super) struct TiledFit {
    /// `None` if too few parts are usable.
    pub(super) fit: Option<Registration>,
    /// Parts that were used.
    pub(super) usable: usize,
    /// All parts.
    pub(super) tiles: usize,
    /// How far the part that fits worst lies off the fit, in pixels.
    pub(super) worst_px: f64,
}

/// The registration that a textured target shows, if `to_far` is near it: displacements of overlapping parts, fitted. Parts
/// begin a part of their side, one in `overlaps`, after each other.
pub(super) fn fitted_registration(
    near: &Image,
    far: &Image,
    to_far: &Affine,
    largest_blur_px: f64,
    overlaps: usize,
) -> TiledFit {
    let (width, height) = (near.width(), near.height());
    let brought = resampled(far, to_far);
    let tile = (width.min(height) / 2).clamp(*TILES_PX.start(), *TILES_PX.end()).min(width.min(height));
    let corners = |side: usize| (0..=side - tile).step_by(tile / overlaps);
    let mut tiles = 0;
    let mut pairs = Vec::new();
    for (top, left) in corners(height).flat_map(|top| corners(width).map(move |left| (top, left))) {
        tiles += 1;
        let part = |image: &Image| image.cropped(left, top, tile, tile);
        let from = [left, top].map(|corner| corner as f64 + (tile - 1) as f64 / 2.0);
        if let Some([dx, dy]) = shift(&part(near), &part(&brought), largest_blur_px) {
            pairs.push(PointPair { from, to: applied(to_far, [from[0] + dx, from[1] + dy]) });
        }
    }
    let all = pairs.len();
    let mut fit = (all >= LEAST_PARTS).then(|| fitted_affine(&pairs)).flatten();
    let mut worst_px = 0.0_f64;
    for _ in 0..FIT_ROUNDS {
        let Some(found) = fit else { break };
        let mut off_px: Vec<f64> =
            pairs.iter().map(|pair| pair.distance(&found.affine_far_to_near)).collect();
        let usual_px = median(&mut off_px.clone(), f64::total_cmp).unwrap_or(0.0);
        let most_px = (OUTLIER * usual_px).max(INLIER_PX);
        let Some((worst, off)) = off_px.drain(..).enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        if off <= most_px {
            break;
        }
        worst_px = worst_px.max(off);
        pairs.swap_remove(worst);
        fit = (pairs.len() >= LEAST_PARTS).then(|| fitted_affine(&pairs)).flatten();
    }
    TiledFit { fit, usable: pairs.len(), tiles, worst_px }
}

/// Fewer parts leave no residual to test an affine map by.
const LEAST_PARTS: usize = 6;

/// Least window over which the means of both pictures agree whatever their focus, in pixels.
const SWAP_WINDOW_PX: f64 = 4.0;
/// The other scale must fit better by this factor.
const SWAP_MARGIN: f64 = 0.7;

/// Whether the far picture fits the near one better under the inverse map: then the pictures are exchanged. Without a
/// difference of scale nothing tells them apart.
pub(super) fn exchanged(pair: &FocalPair, to_far: &Affine, largest_blur_px: f64) -> bool {
    let [scale, ..] = *to_far;
    let (width, height) = (pair.width(), pair.height());
    let farthest = (1.0 - scale).abs() * width.max(height) as f64 / 2.0;
    if farthest < 0.5 {
        return false;
    }
    let rows = Planes { width, planes: [pair.near.pixels(), pair.far.pixels()] };
    let means = Means::over(&rows, width, height, largest_blur_px.max(SWAP_WINDOW_PX));
    let centre = [to_far[2] / (1.0 - scale), to_far[5] / (1.0 - scale)];
    scaled_difference(&means, centre, 1.0 / scale) < SWAP_MARGIN * scaled_difference(&means, centre, scale)
}

/// The mean square difference of the near plane and the far one, which is scaled about `centre` and as bright as the near
/// one on the whole.
fn scaled_difference(means: &Means<2>, centre: [f64; 2], scale: f64) -> f64 {
    let [near, far] = &means.planes;
    let total = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let gain = (total(near) / total(far).max(1e-9)) as f32;
    let step = means.step as f64;
    let to = |at: usize, centre: f64| (centre + scale * (at as f64 * step - centre)) / step;
    let (mut sum, mut count) = (0.0, 0_u32);
    for y in 0..means.height {
        for x in 0..means.width {
            let (u, v) = (to(x, centre[0]), to(y, centre[1]));
            if u < 0.0 || v < 0.0 || u >= (means.width - 1) as f64 || v >= (means.height - 1) as f64 {
                continue;
            }
            let (i, j) = (u as usize, v as usize);
            let (p, q) = ((u - i as f64) as f32, (v - j as f64) as f32);
            let at = j * means.width + i;
            let above = far[at] * (1.0 - p) + far[at + 1] * p;
            let below = far[at + means.width] * (1.0 - p) + far[at + means.width + 1] * p;
            let seen = gain * (above * (1.0 - q) + below * q);
            sum += f64::from(near[y * means.width + x] - seen).powi(2);
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
}

/// A point of the near picture and the same point in the far one, in pixels.
struct PointPair {
    from: [f64; 2],
    to: [f64; 2],
}

impl PointPair {
    /// How far a map misses the pair.
    fn distance(&self, affine: &Affine) -> f64 {
        let [dx, dy] = self.residual(affine);
        dx.hypot(dy)
    }

    /// How far a map misses the pair, x and y.
    fn residual(&self, affine: &Affine) -> [f64; 2] {
        let at = applied(affine, self.from);
        [at[0] - self.to[0], at[1] - self.to[1]]
    }
}

/// The least-squares affine map of point pairs: at least three that aren't in one line.
fn fitted_affine(pairs: &[PointPair]) -> Option<Registration> {
    let mut normal = [0.0; 9];
    let mut right = [[0.0; 3]; 2];
    for PointPair { from: [x, y], to } in pairs {
        // In parts of a thousand pixels, so that all unknowns are of one size.
        let row = [x / 1000.0, y / 1000.0, 1.0];
        for i in 0..3 {
            for j in 0..3 {
                normal[3 * i + j] += row[i] * row[j];
            }
            for (right, to) in right.iter_mut().zip(to) {
                right[i] += row[i] * to;
            }
        }
    }
    let normal = Symmetric::of(&normal, 3)?;
    let [[a, b, c], [d, e, f]] = right.map(|right| {
        let solution = normal.solve(&right);
        [solution[0] / 1000.0, solution[1] / 1000.0, solution[2]]
    });
    let affine_far_to_near = [a, b, c, d, e, f];
    let squares = pairs.iter().map(|pair| pair.distance(&affine_far_to_near).powi(2));
    let rms_px = (squares.sum::<f64>() / pairs.len() as f64).sqrt();
    Some(Registration { affine_far_to_near, rms_px })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::scene::{Camera, Relief, Scene, Texture, bench_optics};

    fn camera(telecentric: bool) -> Camera {
        Camera::new(bench_optics(8.0, telecentric))
    }

    fn seen(camera: &Camera, texture: Texture) -> FocalPair {
        camera.photograph(&Scene::new(Relief::Slant, texture, 4)).pair().unwrap()
    }

    #[test]
    fn a_shift_is_found_through_the_blur() {
        for shift_px in [[0.4, -0.7], [3.0, 1.5], [0.0, 0.0]] {
            let pair = seen(&Camera { far_shift_px: shift_px, ..camera(true) }, Texture::Gravel);
            let found = shift(&pair.near, &pair.far, 5.0).expect("gravel fixes a shift");
            let off = (found[0] - shift_px[0]).hypot(found[1] - shift_px[1]);
            assert!(off < 0.05, "{found:?} is not {shift_px:?}");
        }
    }

    #[test]
    fn a_pattern_that_fixes_no_shift_is_refused() {
        for texture in
            [Texture::Bars { period_px: 8.0 }, Texture::Stripes { period_px: 10.0 }, Texture::Plain]
        {
            let pair = seen(&camera(true), texture);
            assert_eq!(shift(&pair.near, &pair.far, 5.0), None, "{texture:?}");
        }
    }

    #[test]
    fn a_target_shows_the_scale_of_an_ordinary_lens() {
        let camera = camera(false);
        let pair = seen(&camera, Texture::Gravel);
        let start = scaling(&camera.optics, pair.width(), pair.height());
        let TiledFit { fit, usable, tiles, .. } = fitted_registration(&pair.near, &pair.far, &start, 5.0, 4);
        let Registration { affine_far_to_near: affine, rms_px } = fit.expect("gravel can be registered by");
        assert!(usable * 2 > tiles && rms_px < 0.1, "{usable} of {tiles}, {rms_px} px left");
        for corner in [[0.0, 0.0], [255.0, 239.0]] {
            let (found, expected) = (applied(&affine, corner), applied(&start, corner));
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 0.3, "{corner:?} is taken to {found:?}, not {expected:?}");
        }
    }
}
