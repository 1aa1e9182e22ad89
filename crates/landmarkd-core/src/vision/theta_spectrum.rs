//! The Fourier transform of a polar sub-window along θ, ring by ring. Its amplitudes are a signature that is invariant to
//! rotation and keeps the rings apart; its phases give the rotation of one sub-window against another.
//!
//! A spectrum holds, for each ring, the real parts of the [`FREQUENCIES`] lowest frequencies and then their
//! imaginary parts, each times √2 except frequency 0: so the sum of squares is that of the real signal's whole
//! spectrum, and a product of two spectra counts the repeated half.

use std::array::from_fn;
use std::f64::consts::TAU;

use pulp::{Arch, Simd, WithSimd};

use super::signature::{Normalise, brightness};

/// Frequencies along θ that are kept, 0 among them; sub-windows with fewer than 23 sectors have zeros in the
/// rest.
pub const FREQUENCIES: usize = 12;
/// Numbers of a ring's spectrum.
const RING: usize = 2 * FREQUENCIES;
/// Turns at which the correlation of two spectra is evaluated; the peak is found between them by a parabola.
const TURNS: usize = 32;
const HALF: usize = TURNS / 2;
/// The taper is a Gaussian over the radius with this part of the sub-window's radius as σ, and each ring
/// counts by the root of its area.
const SIGMA: f64 = 1.0 / 1.5;

/// Tables for spectra of one shape; shared between threads.
#[derive(Clone, Debug)]
pub struct ThetaPlan {
    rings: usize,
    sectors: usize,
    normalise: Normalise,
    ring_weight: Vec<f32>,
    /// A row a sector: what its sample adds to a ring's spectrum.
    waves: Vec<[f32; RING]>,
    /// A row a frequency: what it adds to the correlation at each turn below half of one.
    cosines: [[f32; HALF]; FREQUENCIES],
    sines: [[f32; HALF]; FREQUENCIES],
}

/// A spectrum quantised to −127..=127, as trained databases hold it, and its length.
#[derive(Clone, Copy, Debug)]
pub struct KeptSpectrum<'a> {
    /// rings × 2 × [`FREQUENCIES`].
    pub numbers: &'a [i8],
    /// The root of the sum of their squares.
    pub length: f32,
}

/// The rotation of one sub-window against another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeTurn {
    /// From x towards y, in (−π, π].
    pub turn_rad: f32,
    /// Normalised correlation at that turn, −1..=1.
    pub correlation: f32,
}

impl ThetaPlan {
    /// A plan for sub-windows of `rings` × `sectors` samples, at least 1 × 4.
    pub fn new(rings: usize, sectors: usize, normalise: Normalise) -> ThetaPlan {
        let frequencies = FREQUENCIES.min(sectors.div_ceil(2));
        let counted = |k: usize| if k == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
        let phase = |k: usize, part: usize, of: usize| (TAU * ((k * part) % of) as f64 / of as f64).sin_cos();
        let wave = |sector: usize| {
            let mut row = [0.0; RING];
            for k in 0..frequencies {
                let (sin, cos) = phase(k, sector, sectors);
                row[k] = (counted(k) * cos) as f32;
                row[FREQUENCIES + k] = (-counted(k) * sin) as f32;
            }
            row
        };
        let ring_weight = |ring: usize| {
            let radius = (ring as f64 + 0.5) / rings as f64;
            ((-0.5 * (radius / SIGMA).powi(2)).exp() * radius.sqrt()) as f32
        };
        ThetaPlan {
            rings,
            sectors,
            normalise,
            ring_weight: (0..rings).map(ring_weight).collect(),
            waves: (0..sectors).map(wave).collect(),
            cosines: from_fn(|k| from_fn(|j| phase(k, j, TURNS).1 as f32)),
            sines: from_fn(|k| from_fn(|j| -phase(k, j, TURNS).0 as f32)),
        }
    }

    /// Numbers of a spectrum.
    pub fn length(&self) -> usize {
        self.rings * RING
    }

    /// Amplitudes of a spectrum.
    pub fn amplitudes(&self) -> usize {
        self.rings * FREQUENCIES
    }

    /// Writes the spectrum of a sub-window and its amplitudes, of unit length together; returns whether
    /// the sub-window has any contrast. Allocates nothing.
    ///
    /// # Panics
    /// If `samples` does not hold rings × sectors values, `spectrum` not [`ThetaPlan::length`], or
    /// `amplitudes` not [`ThetaPlan::amplitudes`].
    pub fn transform(&self, samples: &[f32], spectrum: &mut [f32], amplitudes: &mut [f32]) -> bool {
        assert_eq!(samples.len(), self.rings * self.sectors, "rings × sectors samples");
        assert_eq!((spectrum.len(), amplitudes.len()), (self.length(), self.amplitudes()), "all rings");
        let Some((offset, scale)) = brightness(samples, self.normalise) else { return false };
        Arch::new().dispatch(Transform { plan: self, samples, offset, scale, spectrum, amplitudes });
        let length = amplitudes.iter().map(|v| v * v).sum::<f32>().sqrt();
        if length > 0.0 {
            amplitudes.iter_mut().for_each(|v| *v /= length);
        }
        length > 0.0
    }

    /// Samples of a sub-window.
    pub fn samples(&self) -> usize {
        self.rings * self.sectors
    }

    /// Writes the sub-window itself, normalised in brightness as the plan says, tapered and of unit length;
    /// returns whether it has any contrast.
    ///
    /// # Panics
    /// If `samples` or `window` do not hold rings × sectors values.
    pub fn upright(&self, samples: &[f32], window: &mut [f32]) -> bool {
        assert_eq!(samples.len(), self.samples(), "rings × sectors samples");
        assert_eq!(window.len(), self.samples(), "rings × sectors values");
        let Some((offset, _)) = brightness(samples, self.normalise) else { return false };
        let rings = samples.chunks_exact(self.sectors).zip(window.chunks_exact_mut(self.sectors));
        for ((ring, out), weight) in rings.zip(&self.ring_weight) {
            for (out, sample) in out.iter_mut().zip(ring) {
                *out = (sample - offset) * weight;
            }
        }
        let length = spectrum_length(window);
        if length > 0.0 {
            window.iter_mut().for_each(|v| *v /= length);
        }
        length > 0.0
    }

    /// The rotation of the sub-window of `query` against that of `kept`, where their circular correlation peaks.
    pub fn relative_turn(&self, query: &[f32], query_length: f32, kept: KeptSpectrum<'_>) -> RelativeTurn {
        let correlation = Arch::new().dispatch(Correlate { plan: self, query, kept: kept.numbers });
        let mut best = 0;
        for (j, value) in correlation.iter().enumerate() {
            if *value > correlation[best] {
                best = j;
            }
        }
        let (left, peak, right) =
            (correlation[(best + TURNS - 1) % TURNS], correlation[best], correlation[(best + 1) % TURNS]);
        let curvature = left - 2.0 * peak + right;
        let between = if curvature < 0.0 { 0.5 * (left - right) / curvature } else { 0.0 };
        let turn = (best as f32 + between) * std::f32::consts::TAU / TURNS as f32;
        let length = query_length * kept.length;
        RelativeTurn {
            turn_rad: if turn > std::f32::consts::PI { turn - std::f32::consts::TAU } else { turn },
            correlation: if length > 0.0 { peak / length } else { 0.0 },
        }
    }
}

/// The Euclidean length of a spectrum.
pub fn spectrum_length(spectrum: &[f32]) -> f32 {
    spectrum.iter().map(|v| v * v).sum::<f32>().sqrt()
}

/// Quantises a spectrum: the largest number becomes ±127.
pub fn kept_spectrum(spectrum: &[f32], numbers: &mut Vec<i8>) {
    let largest = spectrum.iter().fold(0.0_f32, |most, v| most.max(v.abs()));
    let scale = if largest > 0.0 { 127.0 / largest } else { 0.0 };
    numbers.extend(spectrum.iter().map(|v| (v * scale).round() as i8));
}

struct Transform<'a> {
    plan: &'a ThetaPlan,
    samples: &'a [f32],
    offset: f32,
    scale: f32,
    spectrum: &'a mut [f32],
    amplitudes: &'a mut [f32],
}

impl WithSimd for Transform<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let plan = self.plan;
        let (waves, weights) = (&plan.waves[..plan.sectors], &plan.ring_weight[..plan.rings]);
        let spectra = &mut self.spectrum.as_chunks_mut::<RING>().0[..plan.rings];
        let amplitudes = &mut self.amplitudes.as_chunks_mut::<FREQUENCIES>().0[..plan.rings];
        for ring in 0..plan.rings {
            let (spectrum, amplitudes, ring_weight) =
                (&mut spectra[ring], &mut amplitudes[ring], weights[ring]);
            let ring = &self.samples[ring * plan.sectors..][..plan.sectors];
            let mut sum = [0.0_f32; RING];
            for sector in 0..ring.len() {
                let (value, wave) = ((ring[sector] - self.offset) * self.scale, &waves[sector]);
                for at in 0..RING {
                    sum[at] += value * wave[at];
                }
            }
            for k in 0..FREQUENCIES {
                let (re, im) = (sum[k] * ring_weight, sum[FREQUENCIES + k] * ring_weight);
                spectrum[k] = re;
                spectrum[FREQUENCIES + k] = im;
                amplitudes[k] = (re * re + im * im).sqrt();
            }
        }
    }
}

struct Correlate<'a> {
    plan: &'a ThetaPlan,
    query: &'a [f32],
    kept: &'a [i8],
}

impl WithSimd for Correlate<'_> {
    type Output = [f32; TURNS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f32; TURNS] {
        // real by real beside imaginary by imaginary, and real by imaginary beside imaginary by real
        let (mut alike, mut crosswise) = ([0.0_f32; RING], [0.0_f32; RING]);
        let (query, kept) = (self.query.as_chunks::<RING>().0, self.kept.as_chunks::<RING>().0);
        let rings = if query.len() < kept.len() { query.len() } else { kept.len() };
        let (query, kept) = (&query[..rings], &kept[..rings]);
        for ring in 0..rings {
            let (q, t) = (&query[ring], &kept[ring]);
            // and the first half once more, behind
            let mut turned = [0.0_f32; RING + FREQUENCIES];
            for n in 0..RING {
                turned[n] = t[n] as f32;
            }
            for n in 0..FREQUENCIES {
                turned[RING + n] = turned[n];
            }
            for n in 0..RING {
                alike[n] += q[n] * turned[n];
                crosswise[n] += q[n] * turned[FREQUENCIES + n];
            }
        }
        // the cosines are alike for a turn and its opposite, the sines of opposite sign
        let (mut even, mut odd) = ([0.0_f32; HALF], [0.0_f32; HALF]);
        let mut opposite = 0.0;
        for k in 0..FREQUENCIES {
            let (re, im) = (alike[k] + alike[FREQUENCIES + k], crosswise[FREQUENCIES + k] - crosswise[k]);
            let (cos, sin) = (&self.plan.cosines[k], &self.plan.sines[k]);
            for j in 0..HALF {
                even[j] += re * cos[j];
                odd[j] += im * sin[j];
            }
            opposite += if k % 2 == 0 { re } else { -re };
        }
        let mut correlation = [0.0_f32; TURNS];
        for j in 0..HALF {
            correlation[j] = even[j] + odd[j];
        }
        correlation[HALF] = opposite;
        for j in 1..HALF {
            correlation[TURNS - j] = even[j] - odd[j];
        }
        correlation
    }
}

#[cfg(test)]
mod tests {
    use super::super::PolarGrid;
    use super::*;
    use crate::angle::angular_distance_deg;
    use crate::imaging::{Frame, Image};

    fn blobs() -> Image {
        Image::from_fn(81, 81, |x, y| {
            let at = |cx: f32, cy: f32, r: f32| {
                let (dx, dy) = (x as f32 - cx, y as f32 - cy);
                (-(dx * dx + dy * dy) / (r * r)).exp()
            };
            20.0 + 150.0 * at(45.0, 38.0, 4.0) + 90.0 * at(33.0, 44.0, 3.0) + 60.0 * at(41.0, 50.0, 5.0)
        })
    }

    fn described(plan: &ThetaPlan, image: &Image) -> (Vec<f32>, Vec<f32>) {
        let mut samples = vec![0.0; 8 * 32];
        PolarGrid::new(14.0, 8, 32).sample(image, 40.0, 40.0, &mut samples);
        let (mut spectrum, mut amplitudes) = (vec![0.0; plan.length()], vec![0.0; plan.amplitudes()]);
        assert!(plan.transform(&samples, &mut spectrum, &mut amplitudes));
        (spectrum, amplitudes)
    }

    #[test]
    fn the_phases_tell_the_turn_and_the_amplitudes_do_not_know_it() {
        let plan = ThetaPlan::new(8, 32, Normalise::Contrast);
        let picture = Frame::gray(blobs());
        let (spectrum, amplitudes) = described(&plan, &picture.luminance);
        let mut numbers = Vec::new();
        kept_spectrum(&spectrum, &mut numbers);
        let length = numbers.iter().map(|&v| f32::from(v).powi(2)).sum::<f32>().sqrt();
        for degrees in [0.0, 10.0, 37.0, 90.0, 178.0, -120.0] {
            let (turned, turned_amplitudes) = described(&plan, &picture.turned(degrees).luminance);
            let kept = KeptSpectrum { numbers: &numbers, length };
            let found = plan.relative_turn(&turned, spectrum_length(&turned), kept);
            let error_deg = angular_distance_deg(f64::from(found.turn_rad.to_degrees()), degrees);
            assert!(error_deg < 2.0, "{degrees}: {found:?}");
            assert!(found.correlation > 0.97, "{degrees}: {found:?}");
            let change: f32 = amplitudes.iter().zip(&turned_amplitudes).map(|(a, b)| (a - b).powi(2)).sum();
            assert!(change.sqrt() < 0.06, "{degrees}: {}", change.sqrt());
        }
    }

    #[test]
    fn a_spectrum_is_the_plain_fourier_sum() {
        let plan = ThetaPlan::new(2, 32, Normalise::None);
        let samples: Vec<f32> = (0..64).map(|i| ((i * 37) % 19) as f32).collect();
        let (mut spectrum, mut amplitudes) = (vec![0.0; plan.length()], vec![0.0; plan.amplitudes()]);
        assert!(plan.transform(&samples, &mut spectrum, &mut amplitudes));
        for ring in 0..2 {
            let radius = (ring as f64 + 0.5) / 2.0;
            let weight = (-0.5 * (radius * 1.5).powi(2)).exp() * radius.sqrt();
            for k in 0..FREQUENCIES {
                let (mut re, mut im) = (0.0, 0.0);
                for (s, &v) in samples[ring * 32..][..32].iter().enumerate() {
                    let (sin, cos) = (TAU * (k * s) as f64 / 32.0).sin_cos();
                    re += f64::from(v) * cos;
                    im -= f64::from(v) * sin;
                }
                let counted = if k == 0 { weight } else { weight * std::f64::consts::SQRT_2 };
                let row = &spectrum[ring * RING..][..RING];
                assert!((f64::from(row[k]) - counted * re).abs() < 1e-3, "ring {ring}, frequency {k}");
                assert!((f64::from(row[FREQUENCIES + k]) - counted * im).abs() < 1e-3, "ring {ring}, {k}");
            }
        }
    }

    #[test]
    fn nothing_to_see_has_no_spectrum() {
        let plan = ThetaPlan::new(8, 32, Normalise::Contrast);
        let (mut spectrum, mut amplitudes) = (vec![0.0; plan.length()], vec![0.0; plan.amplitudes()]);
        assert!(!plan.transform(&[90.0; 256], &mut spectrum, &mut amplitudes));
        assert!(!plan.upright(&[90.0; 256], &mut [0.0; 256]));
    }
}
