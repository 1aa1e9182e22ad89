//! The signature of a sub-window (A§4.4): the amplitude of the two-dimensional DFT of its tapered polar
//! form. A turn shifts the columns cyclically, a shift changes only phases, so the amplitude stays.
//!
//! Order: frequency along θ first (0..=sectors/2: the input is real, the other half repeats), along r
//! within (0..rings). The transform is not normalised; the signature is, as [`Normalise`] says.

use std::sync::Arc;

use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};

/// The weighting of a sub-window's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taper {
    /// A Gaussian of the radius alone, σ a quarter of the window's length: θ is periodic and needs no
    /// fading, and without it a turn changes nothing.
    Radial,
    /// The paper's words (A§4.4): a two-dimensional Gaussian on the (r, θ) image. It fades out directions,
    /// so the signature changes under turns.
    Literal,
}

/// The normalisation of sub-windows and signatures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normalise {
    /// Mean removed, deviation made one, signature of unit length: brightness and contrast don't matter.
    Contrast,
    /// Signature of unit length, the mean kept: only contrast about black doesn't matter.
    Energy,
    /// Gray levels as they are; a white window's signature has length 1.
    None,
}

/// Sub-windows whose deviation is below this, in gray levels, have no contrast: their signature is zero.
const LEAST_DEVIATION: f32 = 1e-2;

/// Tables and transforms for signatures of one shape; shared between threads.
#[derive(Clone)]
pub struct SignaturePlan {
    rings: usize,
    sectors: usize,
    normalise: Normalise,
    /// Weight of every sample, ring by ring.
    taper: Vec<f32>,
    /// Along θ, two real rings at a time as one complex row.
    along_theta: Arc<dyn Fft<f32>>,
    along_r: Arc<dyn Fft<f32>>,
    /// The length of a white window's spectrum.
    white: f32,
}

/// The working memory of one thread.
#[derive(Clone, Debug)]
pub struct SignatureScratch {
    rows: Vec<Complex32>,
    columns: Vec<Complex32>,
    inner: Vec<Complex32>,
}

impl SignaturePlan {
    /// A plan for sub-windows of `rings` × `sectors` samples, both at least 1.
    pub fn new(rings: usize, sectors: usize, taper: Taper, normalise: Normalise) -> SignaturePlan {
        let mut planner = FftPlanner::new();
        let taper = weights(rings, sectors, taper);
        // Parseval: ‖spectrum‖² over both halves is rings · sectors · Σ (255 w)²; the repeated half of the
        // frequencies counts as well, which a length in round figures may.
        let energy: f64 = taper.iter().map(|&w| (255.0 * f64::from(w)).powi(2)).sum();
        SignaturePlan {
            rings,
            sectors,
            normalise,
            taper,
            along_theta: planner.plan_fft_forward(sectors),
            along_r: planner.plan_fft_forward(rings),
            white: (energy * (rings * sectors) as f64).sqrt() as f32,
        }
    }

    /// How many numbers a signature has: rings × (sectors/2 + 1).
    pub fn length(&self) -> usize {
        self.rings * (self.sectors / 2 + 1)
    }

    /// Working memory for [`SignaturePlan::sign`].
    pub fn scratch(&self) -> SignatureScratch {
        let inner = self.along_theta.get_inplace_scratch_len().max(self.along_r.get_inplace_scratch_len());
        SignatureScratch {
            rows: vec![Complex32::ZERO; self.rings.div_ceil(2) * self.sectors],
            columns: vec![Complex32::ZERO; self.length()],
            inner: vec![Complex32::ZERO; inner],
        }
    }

    /// Writes the signature of one sub-window; returns whether it has any contrast. Allocates
    /// nothing. The signature of a sub-window without contrast is zero.
    ///
    /// # Panics
    /// If `samples` does not hold rings × sectors values or `signature` not [`SignaturePlan::length`].
    pub fn sign(&self, samples: &[f32], scratch: &mut SignatureScratch, signature: &mut [f32]) -> bool {
        assert_eq!(samples.len(), self.taper.len(), "rings × sectors samples");
        assert_eq!(signature.len(), self.length(), "rings × (sectors/2 + 1) amplitudes");
        let Some((offset, scale)) = brightness(samples, self.normalise) else {
            signature.fill(0.0);
            return false;
        };

        self.fill_rows(samples, offset, scale, &mut scratch.rows);
        self.along_theta.process_with_scratch(&mut scratch.rows, &mut scratch.inner); // A§4.4
        self.separate(&scratch.rows, &mut scratch.columns);
        self.along_r.process_with_scratch(&mut scratch.columns, &mut scratch.inner); // A§4.4
        for (amplitude, z) in signature.iter_mut().zip(&scratch.columns) {
            *amplitude = (z.re * z.re + z.im * z.im).sqrt();
        }
        let length = match self.normalise {
            Normalise::None => self.white,
            Normalise::Contrast | Normalise::Energy => {
                signature.iter().map(|&v| f64::from(v) * f64::from(v)).sum::<f64>().sqrt() as f32
            }
        };
        let visible = signature.iter().any(|&v| v > 0.0);
        if visible {
            signature.iter_mut().for_each(|v| *v /= length);
        }
        visible
    }

    /// Two tapered real rings to each complex row.
    fn fill_rows(&self, samples: &[f32], offset: f32, scale: f32, rows: &mut [Complex32]) {
        let sectors = self.sectors;
        let value = |ring: usize, sector: usize| {
            let at = ring * sectors + sector;
            (samples[at] - offset) * scale * self.taper[at]
        };
        for (pair, row) in rows.chunks_exact_mut(sectors).enumerate() {
            let (first, second) = (2 * pair, 2 * pair + 1);
            for (sector, z) in row.iter_mut().enumerate() {
                let im = if second < self.rings { value(second, sector) } else { 0.0 };
                *z = Complex32::new(value(first, sector), im);
            }
        }
    }

    /// The spectra of the rings, frequency by frequency: of Z = A + iB, A = (Z(k) + Z*(−k))/2 and B = (Z(k) − Z*(−k))/2i.
    fn separate(&self, rows: &[Complex32], columns: &mut [Complex32]) {
        let sectors = self.sectors;
        for (pair, row) in rows.chunks_exact(sectors).enumerate() {
            for k in 0..=sectors / 2 {
                let (z, w) = (row[k], row[(sectors - k) % sectors].conj());
                let column = &mut columns[k * self.rings..][..self.rings];
                column[2 * pair] = (z + w) * 0.5;
                if let Some(second) = column.get_mut(2 * pair + 1) {
                    let d = (z - w) * 0.5;
                    *second = Complex32::new(d.im, -d.re);
                }
            }
        }
    }
}

/// Offset and scale that normalise the samples' brightness, (v − offset) · scale; `None` without contrast.
pub(super) fn brightness(samples: &[f32], normalise: Normalise) -> Option<(f32, f32)> {
    match normalise {
        Normalise::Energy | Normalise::None => Some((0.0, 1.0)),
        Normalise::Contrast => {
            let count = samples.len() as f64;
            let mean = sum(samples, |v| v) / count;
            let square = sum(samples, |v| (v - mean) * (v - mean));
            let deviation = (square / count).sqrt() as f32;
            (deviation >= LEAST_DEVIATION).then(|| (mean as f32, 1.0 / deviation))
        }
    }
}

/// Σ f(v), in several sums side by side: a single one would wait for each addition.
fn sum(samples: &[f32], f: impl Fn(f64) -> f64) -> f64 {
    let mut sums = [0.0; 8];
    let (chunks, rest) = samples.as_chunks::<8>();
    for chunk in chunks {
        for (sum, &v) in sums.iter_mut().zip(chunk) {
            *sum += f(f64::from(v));
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|&v| f(f64::from(v))).sum::<f64>()
}

/// The taper on a window of unit radius, σ a quarter of each axis's whole length (A§4.4).
fn weights(rings: usize, sectors: usize, taper: Taper) -> Vec<f32> {
    let bell = |v: f64| (-0.5 * v * v).exp();
    let over_r = |ring: usize| bell((ring as f64 + 0.5) / rings as f64 / 0.5);
    let over_theta = |sector: usize| match taper {
        Taper::Radial => 1.0,
        Taper::Literal => bell((sector as f64 - (sectors as f64 - 1.0) / 2.0) / (sectors as f64 / 4.0)),
    };
    (0..rings)
        .flat_map(|ring| (0..sectors).map(move |sector| (over_r(ring) * over_theta(sector)) as f32))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    fn signed(plan: &SignaturePlan, samples: &[f32]) -> Vec<f32> {
        let mut signature = vec![0.0; plan.length()];
        let visible = plan.sign(samples, &mut plan.scratch(), &mut signature);
        assert_eq!(visible, signature.iter().any(|&v| v != 0.0));
        signature
    }

    /// The definition: mean, deviation, taper, a DFT term by term, amplitudes, unit length.
    fn naive(plan: &SignaturePlan, samples: &[f32]) -> Vec<f32> {
        let (rings, sectors) = (plan.rings, plan.sectors);
        let count = samples.len() as f64;
        let mean = samples.iter().map(|&v| f64::from(v)).sum::<f64>() / count;
        let mean = if plan.normalise == Normalise::Contrast { mean } else { 0.0 };
        let mut amplitudes = Vec::new();
        for k in 0..=sectors / 2 {
            for m in 0..rings {
                let (mut re, mut im) = (0.0, 0.0);
                for ring in 0..rings {
                    for sector in 0..sectors {
                        let at = ring * sectors + sector;
                        let value = (f64::from(samples[at]) - mean) * f64::from(plan.taper[at]);
                        let turn = (k * sector) as f64 / sectors as f64 + (m * ring) as f64 / rings as f64;
                        re += value * (TAU * turn).cos();
                        im -= value * (TAU * turn).sin();
                    }
                }
                amplitudes.push(re.hypot(im));
            }
        }
        let length = match plan.normalise {
            Normalise::None => f64::from(plan.white),
            _ => amplitudes.iter().map(|v| v * v).sum::<f64>().sqrt(),
        };
        amplitudes.iter().map(|v| (v / length) as f32).collect()
    }

    /// Rings, sectors and samples with some contrast.
    fn windows() -> impl Strategy<Value = (usize, usize, Vec<f32>)> {
        (2usize..12, 4usize..34).prop_flat_map(|(rings, sectors)| {
            prop::collection::vec(0u8..=255, rings * sectors).prop_map(move |levels| {
                let mut samples: Vec<f32> = levels.into_iter().map(f32::from).collect();
                (samples[0], samples[1]) = (0.0, 255.0);
                (rings, sectors, samples)
            })
        })
    }

    fn distance(a: &[f32], b: &[f32]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    }

    fn shifted(samples: &[f32], sectors: usize, by: usize) -> Vec<f32> {
        let mut samples = samples.to_vec();
        samples.chunks_exact_mut(sectors).for_each(|ring| ring.rotate_right(by % sectors));
        samples
    }

    proptest! {
        #[test]
        fn fast_equals_naive(
            (rings, sectors, samples) in windows(),
            literal in any::<bool>(),
            normalise in prop::sample::select(vec![Normalise::Contrast, Normalise::Energy, Normalise::None]),
        ) {
            let taper = if literal { Taper::Literal } else { Taper::Radial };
            let plan = SignaturePlan::new(rings, sectors, taper, normalise);
            prop_assert!(distance(&signed(&plan, &samples), &naive(&plan, &samples)) < 1e-5);
        }

        #[test]
        fn turns_change_nothing_with_a_radial_taper((rings, sectors, samples) in windows(), by in 0usize..34) {
            let plan = SignaturePlan::new(rings, sectors, Taper::Radial, Normalise::Contrast);
            let turned = shifted(&samples, sectors, by);
            prop_assert!(distance(&signed(&plan, &samples), &signed(&plan, &turned)) < 1e-5);
        }

        #[test]
        fn brightness_and_contrast_change_nothing(
            (rings, sectors, samples) in windows(),
            gain in 0.1f32..4.0,
            offset in -100.0f32..100.0,
        ) {
            let plan = SignaturePlan::new(rings, sectors, Taper::Radial, Normalise::Contrast);
            let lit: Vec<f32> = samples.iter().map(|v| gain * v + offset).collect();
            prop_assert!(distance(&signed(&plan, &samples), &signed(&plan, &lit)) < 1e-4);
            let plan = SignaturePlan::new(rings, sectors, Taper::Radial, Normalise::Energy);
            let lit: Vec<f32> = samples.iter().map(|v| gain * v).collect();
            prop_assert!(distance(&signed(&plan, &samples), &signed(&plan, &lit)) < 1e-4);
        }

        #[test]
        fn signatures_have_unit_length((rings, sectors, samples) in windows()) {
            let plan = SignaturePlan::new(rings, sectors, Taper::Radial, Normalise::Contrast);
            let length = signed(&plan, &samples).iter().map(|v| v * v).sum::<f32>().sqrt();
            prop_assert!((length - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn the_literal_taper_feels_a_turn() {
        // a fixed random 16 × 8 picture, as 8 rings of 16 sectors, turned by every sector
        let samples: Vec<f32> = (0..128u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as f32).collect();
        let largest = |taper| {
            let plan = SignaturePlan::new(8, 16, taper, Normalise::Contrast);
            let still = signed(&plan, &samples);
            (1..16).map(|by| distance(&still, &signed(&plan, &shifted(&samples, 16, by)))).fold(0.0, f32::max)
        };
        let (radial, literal) = (largest(Taper::Radial), largest(Taper::Literal));
        println!("largest change of the signature under turns: radial {radial:.1e}, literal {literal:.2}");
        assert!(radial < 1e-5, "radial {radial}");
        assert!(literal > 0.05, "literal {literal}");
    }

    #[test]
    fn a_flat_window_shows_nothing() {
        let plan = SignaturePlan::new(10, 32, Taper::Radial, Normalise::Contrast);
        let flat: Vec<f32> = (0..320).map(|i| 127.3 + 1e-5 * (i % 3) as f32).collect();
        assert!(signed(&plan, &flat).iter().all(|&v| v == 0.0));
        for normalise in [Normalise::Energy, Normalise::None] {
            let plan = SignaturePlan::new(10, 32, Taper::Radial, normalise);
            assert!(signed(&plan, &[0.0; 320]).iter().all(|&v| v == 0.0));
        }
    }

    #[test]
    fn without_normalising_a_white_window_has_length_one() {
        for (rings, sectors) in [(10, 32), (5, 7), (2, 4)] {
            let plan = SignaturePlan::new(rings, sectors, Taper::Radial, Normalise::None);
            let white = signed(&plan, &vec![255.0; rings * sectors]);
            let length = white.iter().map(|v| v * v).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 1e-5, "{rings}×{sectors}: {length}");
        }
    }
}
