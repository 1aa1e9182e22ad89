//! The colour part of a signature: amplitudes of a polar sub-window of an opponent plane, per ring.
//!
//! In absolute units (gray levels over 64), the mean with its sign, so that red differs from green and pale from
//! saturated. Invariant to rotation as the gray signature is; not to the colour of the light.

use std::f64::consts::TAU;

/// Frequencies along θ that are kept of each ring: the mean and three more.
const FREQUENCIES: usize = 4;
/// The unit of an opponent plane, in gray levels.
const UNIT: f64 = 64.0;
/// The Gaussian over the radius has this part of the window's radius as σ.
const SIGMA: f64 = 1.0 / 1.5;

/// The weights that make the colour part of a signature from a sub-window of rings × sectors samples.
#[derive(Clone, Debug)]
pub struct OpponentPlan {
    rings: usize,
    sectors: usize,
    /// Per ring: its taper, and all units.
    ring_weight: Vec<f32>,
    /// Per frequency from 1 on, per sector: cos and sin.
    waves: Vec<Vec<(f32, f32)>>,
}

impl OpponentPlan {
    /// A plan for sub-windows of `rings` × `sectors` samples, at least 1 × 4.
    pub fn new(rings: usize, sectors: usize) -> OpponentPlan {
        let ring_weight = (0..rings)
            .map(|ring| {
                let radius = (ring as f64 + 0.5) / rings as f64;
                // each ring counts by its area's root beside the Gaussian
                let taper = (-0.5 * (radius / SIGMA).powi(2)).exp() * radius.sqrt();
                (taper / sectors as f64 / UNIT / (rings as f64).sqrt()) as f32
            })
            .collect();
        let waves = (1..FREQUENCIES.min(sectors / 2 + 1))
            .map(|k| {
                let wave = |sector: usize| {
                    let (sin, cos) = (TAU * ((k * sector) % sectors) as f64 / sectors as f64).sin_cos();
                    (cos as f32, sin as f32)
                };
                (0..sectors).map(wave).collect()
            })
            .collect();
        OpponentPlan { rings, sectors, ring_weight, waves }
    }

    /// Samples of a sub-window.
    pub fn samples(&self) -> usize {
        self.rings * self.sectors
    }

    /// How many numbers one opponent plane gives.
    pub fn length(&self) -> usize {
        self.rings * (1 + self.waves.len())
    }

    /// Writes the amplitudes of one sub-window of an opponent plane, times `weight`, ring by ring.
    ///
    /// # Panics
    /// If `samples` does not hold rings × sectors values or `amplitudes` not [`OpponentPlan::length`].
    pub fn sign(&self, samples: &[f32], weight: f32, amplitudes: &mut [f32]) {
        assert_eq!(samples.len(), self.rings * self.sectors, "rings × sectors samples");
        assert_eq!(amplitudes.len(), self.length(), "one amplitude a ring and frequency");
        let rings = samples.chunks_exact(self.sectors).zip(&self.ring_weight);
        for ((ring, ring_weight), out) in rings.zip(amplitudes.chunks_exact_mut(1 + self.waves.len())) {
            let scale = weight * ring_weight;
            out[0] = scale * ring.iter().sum::<f32>();
            for (out, wave) in out[1..].iter_mut().zip(&self.waves) {
                let (re, im) = ring
                    .iter()
                    .zip(wave)
                    .fold((0.0, 0.0), |(re, im), (v, (cos, sin))| (re + v * cos, im + v * sin));
                *out = scale * (re * re + im * im).sqrt();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signed(plan: &OpponentPlan, samples: &[f32]) -> Vec<f32> {
        let mut amplitudes = vec![0.0; plan.length()];
        plan.sign(samples, 1.0, &mut amplitudes);
        amplitudes
    }

    #[test]
    fn red_is_not_green() {
        let plan = OpponentPlan::new(3, 8);
        let (red, green) = (signed(&plan, &[64.0; 24]), signed(&plan, &[-64.0; 24]));
        assert!(red[0] > 0.01);
        assert!(red.iter().zip(&green).all(|(r, g)| (r + g).abs() < 1e-6));
    }

    #[test]
    fn a_turn_changes_nothing() {
        let plan = OpponentPlan::new(4, 12);
        let samples: Vec<f32> =
            (0..48u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as f32 - 128.0).collect();
        let mut turned = samples.clone();
        turned.chunks_exact_mut(12).for_each(|ring| ring.rotate_left(5));
        let (still, turned) = (signed(&plan, &samples), signed(&plan, &turned));
        assert!(still.iter().zip(&turned).all(|(a, b)| (a - b).abs() < 1e-6), "{still:?}\n{turned:?}");
    }

    #[test]
    fn frequencies_are_told_apart() {
        let plan = OpponentPlan::new(1, 16);
        let wave =
            |k: usize| (0..16).map(|s| (TAU * (k * s) as f64 / 16.0 + 0.3).cos() as f32).collect::<Vec<_>>();
        for k in 1..4 {
            let amplitudes = signed(&plan, &wave(k));
            let strongest = (0..4).max_by(|&a, &b| amplitudes[a].total_cmp(&amplitudes[b])).unwrap();
            assert_eq!(strongest, k, "{amplitudes:?}");
        }
    }

    #[test]
    fn few_sectors_have_few_frequencies() {
        assert_eq!(OpponentPlan::new(5, 4).length(), 5 * 3);
        assert_eq!(OpponentPlan::new(5, 32).length(), 5 * 4);
    }
}
