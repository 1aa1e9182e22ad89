//! Signatures of gradient directions (A§4.4 carried over from intensities to directions).
//!
//! In a polar sub-window the direction of the gradient *relative to the radius* does not change when the picture turns
//! (RIFF, Takacs et al. 2010). In [`DIRECTIONS`] soft bins, per ring (GLOH, Mikolajczyk and Schmid 2005), it is a function of
//! θ that only shifts: the amplitudes of its Fourier transform along θ are the signature, its phases tell the turn. The root
//! of each amplitude is taken before the eigenspace (Hellinger; RootSIFT, Arandjelović and Zisserman 2012).
//!
//! A spectrum is laid out ring by ring, direction by direction: the real parts of the [`FREQUENCIES`] lowest frequencies, then
//! the imaginary parts.
//!
//! [`LANES`] sub-windows are described side by side: each number of the arithmetic is a vector of theirs. Interest points
//! are at whole pixels, so that the samples of all sub-windows have the same weights, the taper among them.

use std::array::from_fn;
use std::f64::consts::TAU;

use pulp::{Arch, Simd, WithSimd};

use super::gradient::PaddedGradient;

/// Soft bins of the gradient's direction relative to the radius.
pub const DIRECTIONS: usize = 6;
/// Frequencies along θ that are kept, 0 among them.
pub const FREQUENCIES: usize = 9;
/// Rings of the signature; each sums [`ROWS_PER_RING`] rows of samples.
pub const RINGS: usize = 6;
const ROWS_PER_RING: usize = 2;
const ROWS: usize = RINGS * ROWS_PER_RING;
/// Samples along θ.
pub const SECTORS: usize = 32;
/// Channels that are transformed along θ.
pub const CHANNELS: usize = RINGS * DIRECTIONS;
/// Numbers of a spectrum of one channel.
const CHANNEL: usize = 2 * FREQUENCIES;
/// Components of a signature.
pub const SIGNATURE_LENGTH: usize = CHANNELS * FREQUENCIES;
/// Numbers of a spectrum.
pub const SPECTRUM_LENGTH: usize = CHANNELS * CHANNEL;
/// Sub-windows that are described side by side.
const LANES: usize = 8;
/// One number of each of them.
type Lanes = [f32; LANES];
/// Below this Euclidean length of all amplitudes there is nothing to see.
const LEAST_LENGTH: f32 = 1e-3;

/// All that is computed once for sub-windows of one radius.
#[derive(Clone, Debug)]
pub struct GradientSignature {
    /// Pixels that a sub-window reaches to each side of its centre.
    reach_px: usize,
    /// Of each sample, rows outer, sectors inner.
    taps: Vec<Tap>,
    /// Unit radius of each sector.
    cos: [f32; SECTORS],
    sin: [f32; SECTORS],
    /// Weight of each frequency.
    soft: [f32; FREQUENCIES],
}

/// The signature of the same sub-window in a picture that is flipped from left to right: gradients at the angle φ from the
/// radius are at −φ. The components after those of the gradient, amplitudes along θ as well, stay.
///
/// # Panics
/// If the signature is shorter than [`SIGNATURE_LENGTH`].
pub fn mirrored_signature(signature: &mut [f32]) {
    swap_directions(&mut signature[..SIGNATURE_LENGTH], FREQUENCIES);
}

/// The spectrum of the same sub-window in a picture that is flipped from left to right: what was at θ is at π − θ.
pub fn mirrored_spectrum(spectrum: &mut [f32]) {
    swap_directions(spectrum, CHANNEL);
    for channel in spectrum.chunks_exact_mut(CHANNEL) {
        let (re, im) = channel.split_at_mut(FREQUENCIES);
        // conjugate of each frequency, turned by half a circle
        re.iter_mut().skip(1).step_by(2).for_each(|odd| *odd = -*odd);
        im.iter_mut().step_by(2).for_each(|even| *even = -*even);
    }
}

fn swap_directions(numbers: &mut [f32], channel: usize) {
    for ring in numbers.chunks_exact_mut(DIRECTIONS * channel) {
        for direction in 1..DIRECTIONS / 2 {
            let (low, high) = ring.split_at_mut((DIRECTIONS - direction) * channel);
            low[direction * channel..][..channel].swap_with_slice(&mut high[..channel]);
        }
    }
}

/// Where a sample is taken, and how the four pixels about it count.
#[derive(Clone, Copy, Debug)]
struct Tap {
    /// Pixel above and left of the sample, from the pixel that is `reach_px` above and left of the centre.
    column: usize,
    row: usize,
    /// Bilinear weights times the row's taper: left, left, right, right, for x and y of the gradient each.
    upper: [f32; 4],
    lower: [f32; 4],
}

/// What was described, sub-window by sub-window.
#[derive(Clone, Debug, Default)]
pub struct SignatureBatch {
    /// Which of the points have a signature, ascending.
    pub described: Vec<usize>,
    /// [`SIGNATURE_LENGTH`] numbers for each of them, the roots of amplitudes: of unit length.
    pub signatures: Vec<f32>,
    /// [`SPECTRUM_LENGTH`] numbers for each of them.
    pub spectra: Vec<f32>,
}

impl GradientSignature {
    /// Sub-windows of `radius_px` pixels of their level.
    pub fn new(radius_px: f64) -> GradientSignature {
        let radius = |row: usize| (row as f64 + 0.5) * radius_px / ROWS as f64;
        let angle = |sector: usize| TAU * sector as f64 / SECTORS as f64;
        let reach_px = radius_px.ceil() as usize + 1;
        let tap = |at: usize| {
            let (row, sector) = (at / SECTORS, at % SECTORS);
            let (sin, cos) = angle(sector).sin_cos();
            let (x, y) = (radius(row) * cos + reach_px as f64, radius(row) * sin + reach_px as f64);
            let (right, below) = (x - x.floor(), y - y.floor());
            // Gaussian, and the root of the row's area
            let taper = (-0.5 * (radius(row) / (radius_px / 1.3)).powi(2)).exp() * radius(row).sqrt();
            let weights = |vertical: f64| {
                let (left, right) =
                    ((taper * vertical * (1.0 - right)) as f32, (taper * vertical * right) as f32);
                [left, left, right, right]
            };
            Tap { column: x as usize, row: y as usize, upper: weights(1.0 - below), lower: weights(below) }
        };
        GradientSignature {
            reach_px,
            taps: (0..ROWS * SECTORS).map(tap).collect(),
            cos: from_fn(|s| angle(s).cos() as f32),
            sin: from_fn(|s| angle(s).sin() as f32),
            // sectors overlap: high frequencies count less
            soft: from_fn(|k| (-0.5 * (k as f64 / (0.6 * FREQUENCIES as f64)).powi(2)).exp() as f32),
        }
    }

    /// Pixels that a sub-window reaches to each side of its centre: the border that its gradient must have.
    pub fn reach_px(&self) -> usize {
        self.reach_px
    }

    /// The signatures and spectra of the sub-windows about points (x, y) of a level, px; of those where there is
    /// something to see.
    ///
    /// # Panics
    /// If a point is outside the level, or the gradient's border narrower than [`GradientSignature::reach_px`].
    pub fn describe(&self, gradient: &PaddedGradient, points: &[[usize; 2]]) -> SignatureBatch {
        assert!(gradient.border_px() >= self.reach_px, "a border as wide as sub-windows reach");
        let inside = |&[x, y]: &[usize; 2]| x < gradient.width() && y < gradient.height();
        assert!(points.iter().all(inside), "points of the level");
        let mut batch = SignatureBatch {
            described: Vec::with_capacity(points.len()),
            signatures: Vec::with_capacity(points.len() * SIGNATURE_LENGTH),
            spectra: Vec::with_capacity(points.len() * SPECTRUM_LENGTH),
        };
        let offset = |tap: &Tap| tap.row * gradient.stride() + tap.column;
        let offsets: Vec<usize> = self.taps.iter().map(offset).collect();
        let mut samples = vec![[[0.0; LANES]; 2]; ROWS * SECTORS];
        let mut spectra = vec![[0.0; LANES]; SPECTRUM_LENGTH];
        let mut amplitudes = vec![[0.0; LANES]; SIGNATURE_LENGTH];
        for (number, points) in points.chunks(LANES).enumerate() {
            for (lane, point) in points.iter().enumerate() {
                let samples = &mut samples;
                Arch::new().dispatch(Sample {
                    plan: self,
                    gradient,
                    offsets: &offsets,
                    point,
                    lane,
                    samples,
                });
            }
            let (spectra, amplitudes) = (&mut spectra[..], &mut amplitudes[..]);
            let length =
                Arch::new().dispatch(Describe { plan: self, samples: &samples, spectra, amplitudes });
            for lane in 0..points.len() {
                if length[lane] >= LEAST_LENGTH {
                    batch.described.push(number * LANES + lane);
                    batch.signatures.extend(amplitudes.iter().map(|amplitude| amplitude[lane]));
                    batch.spectra.extend(spectra.iter().map(|number| number[lane]));
                }
            }
        }
        batch
    }
}

/// The gradient at all samples of one sub-window, tapered.
struct Sample<'a> {
    plan: &'a GradientSignature,
    gradient: &'a PaddedGradient,
    /// Of each sample, from the pixel that is `reach_px` above and left of the centre.
    offsets: &'a [usize],
    point: &'a [usize; 2],
    lane: usize,
    samples: &'a mut [[Lanes; 2]],
}

impl WithSimd for Sample<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (stride, beyond) = (self.gradient.stride(), self.gradient.border_px() - self.plan.reach_px);
        let first = (self.point[1] + beyond) * stride + self.point[0] + beyond;
        let numbers = self.gradient.pairs().as_flattened();
        let lane = self.lane % LANES;
        let (taps, offsets) = (&self.plan.taps[..self.samples.len()], &self.offsets[..self.samples.len()]);
        for at in 0..self.samples.len() {
            let (tap, place) = (&taps[at], 2 * (first + offsets[at]));
            let upper: &[f32; 4] = numbers[place..].first_chunk().expect("within the border");
            let lower: &[f32; 4] = numbers[place + 2 * stride..].first_chunk().expect("within the border");
            let mut sum = [0.0_f32; 4];
            for i in 0..4 {
                sum[i] = tap.upper[i] * upper[i] + tap.lower[i] * lower[i];
            }
            self.samples[at][0][lane] = sum[0] + sum[2];
            self.samples[at][1][lane] = sum[1] + sum[3];
        }
    }
}

/// From samples to spectra and the roots of amplitudes, of unit length; returns the length that they had.
struct Describe<'a> {
    plan: &'a GradientSignature,
    samples: &'a [[Lanes; 2]],
    spectra: &'a mut [Lanes],
    amplitudes: &'a mut [Lanes],
}

impl WithSimd for Describe<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Lanes {
        let mut apart = [[0.0_f32; LANES]; SPECTRUM_LENGTH];
        let mut channels = [[[0.0_f32; LANES]; SECTORS]; DIRECTIONS];
        for ring in 0..RINGS {
            let rows = self.samples[ring * ROWS_PER_RING * SECTORS..].as_chunks::<SECTORS>().0;
            soft_bins(simd, self.plan, [&rows[0], &rows[1]], &mut channels);
            let out = apart[ring * DIRECTIONS * CHANNEL..].as_chunks_mut::<CHANNEL>().0;
            for b in 0..DIRECTIONS {
                transform(simd, &self.plan.soft, &channels[b], &mut out[b]);
            }
        }
        // rings overlap, and a transform of a sum is the sum of transforms
        const RING: usize = DIRECTIONS * CHANNEL;
        let (apart, spectra) = (&apart, &mut self.spectra[..SPECTRUM_LENGTH]);
        for ring in 0..RINGS {
            let (inner, outer) = (ring.saturating_sub(1), if ring + 1 < RINGS { ring + 1 } else { ring });
            let inward = if inner == ring { 0.0 } else { 0.5 };
            let outward = if outer == ring { 0.0 } else { 0.5 };
            for at in 0..RING {
                let (here, inner, outer) =
                    (&apart[ring * RING + at], &apart[inner * RING + at], &apart[outer * RING + at]);
                for v in 0..LANES / S::F32_LANES {
                    let beside = vector(simd, inner, v) * inward + vector(simd, outer, v) * outward;
                    (vector(simd, here, v) + beside).store(&mut spectra[ring * RING + at], v);
                }
            }
        }
        let amplitudes = &mut self.amplitudes[..SIGNATURE_LENGTH];
        let mut square = [0.0_f32; LANES];
        for channel in 0..CHANNELS {
            for k in 0..FREQUENCIES {
                let (re, im) =
                    (&spectra[channel * CHANNEL + k], &spectra[channel * CHANNEL + FREQUENCIES + k]);
                let out = &mut amplitudes[channel * FREQUENCIES + k];
                for v in 0..LANES / S::F32_LANES {
                    let (re, im) = (vector(simd, re, v), vector(simd, im, v));
                    let power = re * re + im * im;
                    (vector(simd, &square, v) + power).store(&mut square, v);
                    power.sqrt().store(out, v);
                }
            }
        }
        let (mut length, mut scale) = ([0.0_f32; LANES], [0.0_f32; LANES]);
        for w in 0..LANES {
            length[w] = square[w].sqrt();
            scale[w] = 1.0 / if length[w] > LEAST_LENGTH { length[w] } else { LEAST_LENGTH };
        }
        for v in 0..LANES / S::F32_LANES {
            let scale = vector(simd, &scale, v);
            for amplitude in amplitudes.iter_mut() {
                (vector(simd, amplitude, v) * scale).sqrt().store(amplitude, v);
            }
            for number in spectra.iter_mut() {
                (vector(simd, number, v) * scale).store(number, v);
            }
        }
        length
    }
}

/// Numbers of some sub-windows, side by side in a register.
#[derive(Clone, Copy)]
struct Vector<S: Simd>(S, S::f32s);

#[inline(always)]
fn vector<S: Simd>(simd: S, lanes: &Lanes, number: usize) -> Vector<S> {
    Vector(simd, S::as_simd_f32s(lanes).0[number])
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn store(self, lanes: &mut Lanes, number: usize) {
        S::as_mut_simd_f32s(lanes).0[number] = self.1;
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Vector(self.0, self.0.sqrt_f32s(self.1))
    }

    /// This if it is above 0, else 0.
    #[inline(always)]
    fn positive(self) -> Self {
        Vector(self.0, self.0.max_f32s(self.1, self.0.splat_f32s(0.0)))
    }
}

impl<S: Simd> std::ops::Add for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Vector(self.0, self.0.add_f32s(self.1, other.1))
    }
}

impl<S: Simd> std::ops::Sub for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Vector(self.0, self.0.sub_f32s(self.1, other.1))
    }
}

impl<S: Simd> std::ops::Mul for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Vector(self.0, self.0.mul_f32s(self.1, other.1))
    }
}

impl<S: Simd> std::ops::Mul<f32> for Vector<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Vector(self.0, self.0.mul_f32s(self.1, self.0.splat_f32s(factor)))
    }
}

/// The parts of the gradient in each direction relative to the radius, summed over the rows of a ring. Of opposite
/// directions b and b + 3 the projections are opposite.
#[inline(always)]
fn soft_bins<S: Simd>(
    simd: S,
    plan: &GradientSignature,
    rows: [&[[Lanes; 2]; SECTORS]; ROWS_PER_RING],
    channels: &mut [[Lanes; SECTORS]; DIRECTIONS],
) {
    const SIN_60: f32 = 0.866_025_4;
    for s in 0..SECTORS {
        let (cos, sin) = (plan.cos[s], plan.sin[s]);
        for v in 0..LANES / S::F32_LANES {
            let nothing = Vector(simd, simd.splat_f32s(0.0));
            let mut sums = [nothing; DIRECTIONS];
            for row in rows {
                let [gx, gy] = &row[s];
                let (gx, gy) = (vector(simd, gx, v), vector(simd, gy, v));
                let (radial, tangential) = (gx * cos + gy * sin, gy * cos - gx * sin);
                let half = (radial * radial + tangential * tangential).sqrt() * 0.5;
                let (along, across) = (radial * 0.5, tangential * SIN_60);
                let projections = [radial, across + along, across - along];
                for b in 0..DIRECTIONS / 2 {
                    sums[b] = sums[b] + (projections[b] - half).positive();
                    let back = nothing - (projections[b] + half);
                    sums[b + DIRECTIONS / 2] = sums[b + DIRECTIONS / 2] + back.positive();
                }
            }
            for b in 0..DIRECTIONS {
                sums[b].store(&mut channels[b][s], v);
            }
        }
    }
}

/// cos and sin of π/16, π/8, 3π/16.
const C1: f32 = 0.980_785_25;
const S1: f32 = 0.195_090_32;
const C2: f32 = 0.923_879_5;
const S2: f32 = 0.382_683_43;
const C3: f32 = 0.831_469_6;
const S3: f32 = 0.555_570_24;
const ROOT_HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// The lowest frequencies of the Fourier transform along θ, weighted. What a frequency gives equally to several sectors
/// is added up before: by halves of the circle (k odd, even), and so on.
#[inline(always)]
fn transform<S: Simd>(
    simd: S,
    soft: &[f32; FREQUENCIES],
    channel: &[Lanes; SECTORS],
    out: &mut [Lanes; CHANNEL],
) {
    for v in 0..LANES / S::F32_LANES {
        let nothing = Vector(simd, simd.splat_f32s(0.0));
        let (mut odd, mut even) = ([nothing; 16], [nothing; 16]);
        for s in 0..16 {
            let (here, across) = (vector(simd, &channel[s], v), vector(simd, &channel[s + 16], v));
            (odd[s], even[s]) = (here - across, here + across);
        }
        // k = 1, 3, 5, 7: cos k(π − φ) = −cos kφ, sin k(π − φ) = sin kφ
        let (mut d, mut e) = ([odd[0]; 8], [odd[8]; 9]);
        for s in 1..8 {
            (d[s], e[s]) = (odd[s] - odd[16 - s], odd[s] + odd[16 - s]);
        }
        // multiples of π/16 of each sector times k, folded into the first quadrant
        let middle = d[4] * ROOT_HALF;
        let re1 = d[0] + d[1] * C1 + d[2] * C2 + d[3] * C3 + middle + d[5] * S3 + d[6] * S2 + d[7] * S1;
        let re3 = d[0] + d[1] * C3 + d[2] * S2 - d[3] * S1 - middle - d[5] * C1 - d[6] * C2 - d[7] * S3;
        let re5 = d[0] + d[1] * S3 - d[2] * S2 - d[3] * C1 - middle + d[5] * S1 + d[6] * C2 + d[7] * C3;
        let re7 = d[0] + d[1] * S1 - d[2] * C2 - d[3] * S3 + middle + d[5] * C3 - d[6] * S2 - d[7] * C1;
        let middle = e[4] * ROOT_HALF;
        let im1 = e[1] * S1 + e[2] * S2 + e[3] * S3 + middle + e[5] * C3 + e[6] * C2 + e[7] * C1 + e[8];
        let im3 = e[1] * S3 + e[2] * C2 + e[3] * C1 + middle + e[5] * S1 - e[6] * S2 - e[7] * C3 - e[8];
        let im5 = e[1] * C3 + e[2] * C2 + e[3] * S1 - middle - e[5] * C1 - e[6] * S2 + e[7] * S3 + e[8];
        let im7 = e[1] * C1 + e[2] * S2 - e[3] * C3 - middle + e[5] * S3 + e[6] * C2 - e[7] * S1 - e[8];
        // k = 2, 6
        let (mut twice, mut fourfold) = ([nothing; 8], [nothing; 8]);
        for s in 0..8 {
            (twice[s], fourfold[s]) = (even[s] - even[s + 8], even[s] + even[s + 8]);
        }
        let (a1, a2, a3) = (twice[1] - twice[7], (twice[2] - twice[6]) * ROOT_HALF, twice[3] - twice[5]);
        let (b1, b2, b3) = (twice[1] + twice[7], (twice[2] + twice[6]) * ROOT_HALF, twice[3] + twice[5]);
        let re2 = twice[0] + a1 * C2 + a2 + a3 * S2;
        let re6 = twice[0] + a1 * S2 - a2 - a3 * C2;
        let im2 = b1 * S2 + b2 + b3 * C2 + twice[4];
        let im6 = b1 * C2 + b2 - b3 * S2 - twice[4];
        // k = 4, and 0 and 8
        let (mut four, mut eight) = ([nothing; 4], [nothing; 4]);
        for s in 0..4 {
            (four[s], eight[s]) = (fourfold[s] - fourfold[s + 4], fourfold[s] + fourfold[s + 4]);
        }
        let re4 = four[0] + (four[1] - four[3]) * ROOT_HALF;
        let im4 = four[2] + (four[1] + four[3]) * ROOT_HALF;
        let re0 = (eight[0] + eight[2]) + (eight[1] + eight[3]);
        let (re8, im8) = (eight[0] - eight[2], eight[1] - eight[3]);
        let re = [re0, re1, re2, re3, re4, re5, re6, re7, re8];
        let im = [nothing, im1, im2, im3, im4, im5, im6, im7, im8];
        for k in 0..FREQUENCIES {
            (re[k] * soft[k]).store(&mut out[k], v);
            (im[k] * -soft[k]).store(&mut out[FREQUENCIES + k], v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::gradient::gradient;
    use super::super::smoothed;
    use super::*;
    use crate::imaging::Image;

    fn picture() -> Image {
        let wave = |x: usize, y: usize| {
            let (x, y) = (x as f32, y as f32);
            128.0 + 50.0 * (0.31 * x + 0.2 * y).sin() + 40.0 * (0.011 * x * y).cos() + 20.0 * (0.9 * y).sin()
        };
        Image::from_fn(70, 53, wave)
    }

    /// Sample by sample and term by term, in f64: signature and spectrum.
    fn direct(image: &Image, radius_px: f64, [x, y]: [usize; 2]) -> (Vec<f64>, Vec<f64>) {
        let gradient = gradient(image);
        let bilinear = crate::imaging::sampling::bilinear_replicated;
        let mut rings = vec![[[0.0_f64; SECTORS]; DIRECTIONS]; RINGS];
        for (row, s) in (0..ROWS).flat_map(|row| (0..SECTORS).map(move |s| (row, s))) {
            let radius = (row as f64 + 0.5) * radius_px / ROWS as f64;
            let theta = TAU * s as f64 / SECTORS as f64;
            let (px, py) = (x as f64 + radius * theta.cos(), y as f64 + radius * theta.sin());
            let taper = (-0.5 * (radius / (radius_px / 1.3)).powi(2)).exp() * radius.sqrt();
            let (gx, gy) = (taper * bilinear(&gradient.x, px, py), taper * bilinear(&gradient.y, px, py));
            let direction = gy.atan2(gx) - theta;
            for (b, channel) in rings[row / ROWS_PER_RING].iter_mut().enumerate() {
                let off = direction - TAU * b as f64 / DIRECTIONS as f64;
                channel[s] += gx.hypot(gy) * (off.cos() - 0.5).max(0.0);
            }
        }
        let mut spectrum = Vec::new();
        for (ring, b) in (0..RINGS).flat_map(|ring| (0..DIRECTIONS).map(move |b| (ring, b))) {
            let beside = |s: usize| {
                let at = |ring: usize| rings.get(ring).map_or(0.0, |r| r[b][s]);
                at(ring) + 0.5 * (at(ring.wrapping_sub(1)) + at(ring + 1))
            };
            let term = |k: usize, f: fn(f64) -> f64| -> f64 {
                let soft = (-0.5 * (k as f64 / (0.6 * FREQUENCIES as f64)).powi(2)).exp();
                (0..SECTORS).map(|s| soft * beside(s) * f(TAU * (k * s) as f64 / SECTORS as f64)).sum()
            };
            spectrum.extend((0..FREQUENCIES).map(|k| term(k, f64::cos)));
            spectrum.extend((0..FREQUENCIES).map(|k| -term(k, f64::sin)));
        }
        let length = spectrum.iter().map(|v| v * v).sum::<f64>().sqrt();
        spectrum.iter_mut().for_each(|v| *v /= length);
        let amplitude = |c: &[f64], k: usize| c[k].hypot(c[FREQUENCIES + k]).sqrt();
        let channels = spectrum.chunks_exact(CHANNEL);
        (channels.flat_map(|c| (0..FREQUENCIES).map(move |k| amplitude(c, k))).collect(), spectrum)
    }

    #[test]
    fn signatures_are_those_of_the_definition() {
        let (image, plan) = (picture(), GradientSignature::new(14.0));
        let gradient = PaddedGradient::new(&image, plan.reach_px());
        // inside, at the corners, and more than are described side by side
        let mut points = vec![[30, 25], [0, 0], [69, 52], [69, 0], [6, 40]];
        points.extend((0..6).map(|i| [20 + 5 * i, 20 + i]));
        let batch = plan.describe(&gradient, &points);
        assert_eq!(batch.described, (0..points.len()).collect::<Vec<_>>());
        let rows = batch.signatures.chunks_exact(SIGNATURE_LENGTH);
        for ((point, signature), spectrum) in
            points.iter().zip(rows).zip(batch.spectra.chunks_exact(SPECTRUM_LENGTH))
        {
            let (expected, spectrum_expected) = direct(&image, 14.0, *point);
            for (at, (a, b)) in signature.iter().zip(expected).enumerate() {
                assert!((f64::from(*a) - b).abs() < 1e-3, "{point:?}, amplitude {at}: {a} is not {b}");
            }
            for (at, (a, b)) in spectrum.iter().zip(spectrum_expected).enumerate() {
                assert!((f64::from(*a) - b).abs() < 1e-5, "{point:?}, number {at}: {a} is not {b}");
            }
        }
    }

    #[test]
    fn nothing_to_see_has_no_signature() {
        let image = Image::from_fn(60, 30, |x, _| if x < 30 { 90.0 } else { 3.0 * x as f32 });
        let plan = GradientSignature::new(10.0);
        let gradient = PaddedGradient::new(&image, plan.reach_px() + 3);
        let batch = plan.describe(&gradient, &[[10, 10], [40, 10], [12, 20], [30, 10]]);
        assert_eq!(batch.described, [1, 3]);
        assert_eq!(batch.signatures.len(), 2 * SIGNATURE_LENGTH);
        assert!(plan.describe(&gradient, &[]).described.is_empty());
    }

    #[test]
    fn a_quarter_turn_leaves_the_amplitudes_and_shows_in_the_phases() {
        let image = Image::from_fn(61, 61, |x, y| picture().at(x, y.min(52)));
        let turned = Image::from_fn(61, 61, |x, y| image.at(y, 60 - x));
        let plan = GradientSignature::new(14.0);
        let [a, b] = [&image, &turned]
            .map(|image| plan.describe(&PaddedGradient::new(image, plan.reach_px()), &[[30, 30]]));
        let change = a.signatures.iter().zip(&b.signatures).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(change < 2e-3, "{change}");
        // a quarter turn multiplies frequency k by iᵏ
        let channels = a.spectra.chunks_exact(CHANNEL).zip(b.spectra.chunks_exact(CHANNEL));
        for (at, (a, b)) in channels.enumerate() {
            for k in 0..FREQUENCIES {
                let (re, im) = (a[k], a[FREQUENCIES + k]);
                let expected = [[re, im], [im, -re], [-re, -im], [-im, re]][k % 4];
                let off = (b[k] - expected[0]).hypot(b[FREQUENCIES + k] - expected[1]);
                assert!(off < 2e-3, "channel {at}, frequency {k}: {off}");
            }
        }
    }

    #[test]
    fn vector_instructions_change_no_bit() {
        let (image, plan) = (picture(), GradientSignature::new(14.0));
        let gradient = PaddedGradient::new(&image, plan.reach_px());
        let offsets: Vec<usize> = plan.taps.iter().map(|t| t.row * gradient.stride() + t.column).collect();
        let run = |arch: Arch| {
            let mut samples = vec![[[0.0; LANES]; 2]; ROWS * SECTORS];
            for lane in 0..LANES {
                let point = &[10 + 6 * lane, 20 + lane];
                let samples = &mut samples;
                arch.dispatch(Sample {
                    plan: &plan,
                    gradient: &gradient,
                    offsets: &offsets,
                    point,
                    lane,
                    samples,
                });
            }
            let mut spectra = vec![[0.0; LANES]; SPECTRUM_LENGTH];
            let mut amplitudes = vec![[0.0; LANES]; SIGNATURE_LENGTH];
            let (s, a) = (&mut spectra[..], &mut amplitudes[..]);
            arch.dispatch(Describe { plan: &plan, samples: &samples, spectra: s, amplitudes: a });
            (spectra, amplitudes)
        };
        assert_eq!(run(Arch::Scalar), run(Arch::new()));
    }

    #[test]
    fn a_flipped_picture_has_the_mirrored_signature_and_spectrum() {
        let picture = |flipped: bool| {
            Image::from_fn(81, 61, |x, y| {
                let x = if flipped { 80 - x } else { x };
                ((x * x / 7 + 3 * y + x * y / 5) % 97) as f32
            })
        };
        let plan = GradientSignature::new(14.0);
        let described = |image: &Image, x: usize| {
            plan.describe(&PaddedGradient::new(&smoothed(image, 1.0), plan.reach_px()), &[[x, 33]])
        };
        let (mut here, there) = (described(&picture(false), 30), described(&picture(true), 50));
        let unlike = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(unlike(&here.signatures, &there.signatures) > 0.05);
        mirrored_signature(&mut here.signatures);
        mirrored_spectrum(&mut here.spectra);
        assert!(unlike(&here.signatures, &there.signatures) < 1e-3);
        assert!(unlike(&here.spectra, &there.spectra) < 1e-3);
    }
}
