//! Bringing the far-focused picture into register with the near-focused one.
//!
//! A displacement is read from the phase of the cross-spectrum at low frequencies, where the transfer functions of both
//! blurs are real and positive and leave the phase alone.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

use super::resampling::{Affine, applied, resampled};
use super::windows::{Means, Planes};
use super::{FocalPair, Optics};
use crate::eigen::Symmetric;
use crate::imaging::Image;
use crate::vision::smoothed;

/// Lowest frequency used, cycles a pixel: below it the window over the picture prevails.
const LOWEST: f64 = 0.02;
/// Highest frequency used, cycles a pixel.
const HIGHEST: f64 = 0.12;
/// Longest side of what is transformed, in pixels: more pixels add nothing to the accuracy that is needed.
const MOST_SIDE_PX: usize = 1024;
/// A larger shift is none of a rig that is screwed together.
const MOST_SHIFT_PX: f64 = 6.0;
/// How far the phases must agree: 1 is wholly.
const LEAST_COHERENCE: f64 = 0.9;
/// The lesser of the spectrum's two spreads over the greater, at least: stripes fix one direction only.
const LEAST_SPREAD: f64 = 0.2;
/// Frequencies of half the plane that carry the spectrum, at least: a periodic pattern has few, and fits itself shifted by its period.
const LEAST_FREQUENCIES: f64 = 30.0;

/// The map that takes the near picture's pixels to the far one's, by the scale of an ordinary lens.
pub(super) fn scaling(optics: &Optics, width: usize, height: usize) -> Affine {
    let (scale, [x, y]) = (optics.far_scale(), optics.principal_point(width, height));
    [scale, 0.0, x - scale * x, 0.0, scale, y - scale * y]
}

/// By how many pixels, x and y, the far picture's content lies off the near one's; `None` if the texture doesn't fix it.
pub(super) fn shift(near: &Image, far: &Image, largest_blur_px: f64) -> Option<[f64; 2]> {
    let spectrum = CrossSpectrum::of(near, far, largest_blur_px)?;
    spectrum.shift()
}

/// The cross-spectrum far · near* at the frequencies that are used.
struct CrossSpectrum {
    /// Cycles a pixel, x and y.
    frequencies: Vec<[f64; 2]>,
    values: Vec<Complex64>,
}

impl CrossSpectrum {
    fn of(near: &Image, far: &Image, largest_blur_px: f64) -> Option<CrossSpectrum> {
        let near = halved_middle(near);
        let far = halved_middle(far);
        let (width, height) = (near.width(), near.height());
        if width.min(height) < 8 {
            return None;
        }
        let mean = |image: &Image| {
            image.pixels().iter().map(|&v| f64::from(v)).sum::<f64>() / (width * height) as f64
        };
        let (near_mean, far_mean) = (mean(&near), mean(&far));
        let fade = |at: usize, length: usize| {
            0.5 - 0.5 * (std::f64::consts::TAU * at as f64 / (length - 1) as f64).cos()
        };
        // Both pictures in one transform: near real, far imaginary.
        let mut values = Vec::with_capacity(width * height);
        let columns: Vec<f64> = (0..width).map(|x| fade(x, width)).collect();
        for y in 0..height {
            let row = fade(y, height);
            let pixels = near.row(y).iter().zip(far.row(y)).zip(&columns);
            values.extend(pixels.map(|((&n, &f), column)| {
                Complex64::new(f64::from(n) - near_mean, f64::from(f) - far_mean) * (row * column)
            }));
        }
        let mut planner = FftPlanner::new();
        planner.plan_fft_forward(width).process(&mut values);
        let mut turned = vec![Complex64::ZERO; width * height];
        for (y, row) in values.chunks_exact(width).enumerate() {
            for (x, &value) in row.iter().enumerate() {
                turned[x * height + y] = value;
            }
        }
        planner.plan_fft_forward(height).process(&mut turned);

        let highest = HIGHEST.min(1.0 / largest_blur_px);
        let cycles = |k: usize, length: usize| {
            (k as f64 - if 2 * k > length { length as f64 } else { 0.0 }) / length as f64 / 2.0
        };
        let mut spectrum = CrossSpectrum { frequencies: Vec::new(), values: Vec::new() };
        // Half of the plane: the other half repeats it.
        for i in 0..=width / 2 {
            for j in 0..height {
                let frequency = [cycles(i, width), cycles(j, height)];
                let radius = frequency[0].hypot(frequency[1]);
                if radius > LOWEST && radius < highest {
                    let z = turned[i * height + j];
                    let mirrored = turned[(width - i) % width * height + (height - j) % height].conj();
                    let (n, f) = (z + mirrored, (z - mirrored) * Complex64::new(0.0, -1.0));
                    spectrum.frequencies.push(frequency);
                    spectrum.values.push(f * n.conj() * 0.25);
                }
            }
        }
        Some(spectrum)
    }

    /// The shift whose phases fit best, by weighted least squares, and the look at whether it can be trusted.
    fn shift(&self) -> Option<[f64; 2]> {
        let weights: Vec<f64> = self.values.iter().map(|v| v.norm()).collect();
        let total: f64 = weights.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for ([x, y], weight) in self.frequencies.iter().zip(&weights) {
            xx += weight * x * x / total;
            xy += weight * x * y / total;
            yy += weight * y * y / total;
        }
        let (middle, radius) = ((xx + yy) / 2.0, (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt());
        let squares: f64 = weights.iter().map(|weight| (weight / total).powi(2)).sum();
        if middle - radius <= LEAST_SPREAD * (middle + radius) || 1.0 / squares <= LEAST_FREQUENCIES {
            return None;
        }
        let determinant = xx * yy - xy * xy;
        let turned_back = |[dx, dy]: [f64; 2], [x, y]: [f64; 2], value: Complex64| {
            value * Complex64::from_polar(1.0, std::f64::consts::TAU * (x * dx + y * dy))
        };
        let mut shift = [0.0; 2];
        for _ in 0..4 {
            let [mut right_x, mut right_y] = [0.0; 2];
            for ((&[x, y], weight), &value) in self.frequencies.iter().zip(&weights).zip(&self.values) {
                let phase = turned_back(shift, [x, y], value).arg();
                right_x += weight * x * phase / total;
                right_y += weight * y * phase / total;
            }
            shift[0] -= (yy * right_x - xy * right_y) / determinant / std::f64::consts::TAU;
            shift[1] -= (xx * right_y - xy * right_x) / determinant / std::f64::consts::TAU;
        }
        let agreement: Complex64 = self
            .frequencies
            .iter()
            .zip(&weights)
            .zip(&self.values)
            .map(|((&frequency, weight), &value)| {
                Complex64::from_polar(weight / total, turned_back(shift, frequency, value).arg())
            })
            .sum();
        let trusted = shift[0].hypot(shift[1]) <= MOST_SHIFT_PX && agreement.norm() > LEAST_COHERENCE;
        trusted.then_some(shift)
    }
}

/// The middle of a picture at half its size.
fn halved_middle(image: &Image) -> Image {
    let (width, height) = (image.width().min(MOST_SIDE_PX), image.height().min(MOST_SIDE_PX));
    let (left, top) = ((image.width() - width) / 2, (image.height() - height) / 2);
    let middle = Image::from_fn(width, height, |x, y| image.at(left + x, top + y));
    halved(&middle)
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

/// The map from near to far that a textured target shows, if `to_far` is near it: displacements of overlapping parts,
/// fitted. Tells how many parts of how many could be used, and what is left (root of the mean square, in pixels).
pub(super) fn mapped(
    near: &Image,
    far: &Image,
    to_far: &Affine,
    largest_blur_px: f64,
) -> (Option<(Affine, f64)>, usize, usize) {
    let (width, height) = (near.width(), near.height());
    let brought = resampled(far, to_far);
    let tile = (width.min(height) / 2).clamp(*TILES_PX.start(), *TILES_PX.end()).min(width.min(height));
    let corners = |side: usize| (0..=side - tile).step_by(tile / 4);
    let mut tiles = 0;
    let mut places = Vec::new();
    for top in corners(height) {
        for left in corners(width) {
            tiles += 1;
            let part = |image: &Image| Image::from_fn(tile, tile, |x, y| image.at(left + x, top + y));
            let middle = [left, top].map(|corner| corner as f64 + (tile - 1) as f64 / 2.0);
            if let Some([dx, dy]) = shift(&part(near), &part(&brought), largest_blur_px) {
                places.push((middle, applied(to_far, [middle[0] + dx, middle[1] + dy])));
            }
        }
    }
    if places.len() < LEAST_PARTS {
        return (None, places.len(), tiles);
    }
    let first = fitted_affine(&places);
    let fitted = first.and_then(|(affine, rms_px)| {
        places.retain(|(from, to)| {
            let at = applied(&affine, *from);
            (at[0] - to[0]).hypot(at[1] - to[1]) <= OUTLIER * rms_px
        });
        (places.len() >= LEAST_PARTS).then(|| fitted_affine(&places)).flatten()
    });
    (fitted, places.len(), tiles)
}

/// Fewer parts fix no affine map with anything left to judge it by.
const LEAST_PARTS: usize = 6;

/// Window in which both pictures look alike however they are focused, at least, in pixels.
const SWAP_WINDOW_PX: f64 = 4.0;
/// The other scale must fit better by this factor.
const SWAP_MARGIN: f64 = 0.7;

/// Whether the far picture fits the near one better when the map is turned round: then they are exchanged. Without a
/// difference of scale there is nothing to tell by.
pub(super) fn looks_swapped(pair: &FocalPair, to_far: &Affine, largest_blur_px: f64) -> bool {
    let [scale, ..] = *to_far;
    let (width, height) = (pair.width(), pair.height());
    let farthest = (1.0 - scale).abs() * width.max(height) as f64 / 2.0;
    if farthest < 0.5 {
        return false;
    }
    let rows = Planes { width, planes: [pair.near.pixels(), pair.far.pixels()] };
    let means = Means::up_to(&rows, width, height, largest_blur_px.max(SWAP_WINDOW_PX));
    let [near, far] = &means.planes;
    let total = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let gain = (total(near) / total(far).max(1e-9)) as f32;
    let step = means.step as f64;
    let (centre_x, centre_y) = (to_far[2] / (1.0 - scale), to_far[5] / (1.0 - scale));
    let difference = |scale: f64| {
        let (mut sum, mut count) = (0.0, 0_u32);
        for y in 0..means.height {
            for x in 0..means.width {
                let to = |at: usize, centre: f64| (centre + scale * (at as f64 * step - centre)) / step;
                let (u, v) = (to(x, centre_x), to(y, centre_y));
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
    };
    difference(1.0 / scale) < SWAP_MARGIN * difference(scale)
}

/// The affine map that takes points to others, as nearly as it can, and what it leaves (root of the mean square, in
/// pixels). At least three points that aren't in one line.
fn fitted_affine(places: &[([f64; 2], [f64; 2])]) -> Option<(Affine, f64)> {
    let mut normal = [0.0; 9];
    let mut right = [[0.0; 3]; 2];
    for ([x, y], to) in places {
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
    let affine = [a, b, c, d, e, f];
    let left = places.iter().map(|(from, to)| {
        let at = applied(&affine, *from);
        (at[0] - to[0]).powi(2) + (at[1] - to[1]).powi(2)
    });
    Some((affine, (left.sum::<f64>() / places.len() as f64).sqrt()))
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
        let (fitted, usable, tiles) = mapped(&pair.near, &pair.far, &start, 5.0);
        let (affine, rms_px) = fitted.expect("gravel can be registered by");
        assert!(usable * 2 > tiles && rms_px < 0.1, "{usable} of {tiles}, {rms_px} px left");
        for corner in [[0.0, 0.0], [255.0, 239.0]] {
            let (found, expected) = (applied(&affine, corner), applied(&start, corner));
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 0.3, "{corner:?} is taken to {found:?}, not {expected:?}");
        }
    }
}
