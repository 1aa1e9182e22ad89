//! The filters of the method `gram`: few pairs of small kernels whose combinations give, for every β, the residual
//! H_f·n − H_n·f (defocused by each other's blur, both pictures are equal at the right β).
//!
//! Designed from the optics alone. For each of [`CANDIDATES`] values of β the ideal pair of filters,
//! B·(H_f, −H_n)/√(H_n² + H_f²), is approximated by a pair of kernels; the singular value decomposition of all of them
//! gives [`RANK`] pairs, of which every other is a combination: r_β = Σ_j c_j(β) q_j, q_j = a_j∗n + b_j∗f.
//! The division makes noise pass alike at every β; B keeps what a texture of a 1/f spectrum has above the noise, below
//! [`BAND`].
//!
//! Kernels are symmetric under the eight turns and mirrorings of the square and blind to a constant. Values are kept
//! by orbit: (a, b), 0 ≤ a ≤ b, stands for the taps (±a, ±b) and (±b, ±a).

use super::Optics;
use super::monotone::{MonotoneCurve, pooled};
use super::otf::pillbox;
use crate::eigen::Symmetric;

/// J: pairs of kernels. With three the slopes of some textures are off by 2 %.
pub(super) const RANK: usize = 5;
/// Products q_i·q_j, i ≤ j.
pub(super) const PRODUCTS: usize = RANK * (RANK + 1) / 2;
/// Candidate values of β, evenly spaced.
pub(super) const CANDIDATES: usize = 53;
/// The outermost candidate: beyond ±1, so that depths out of the range are found.
const OUTERMOST: f64 = 1.3;
/// The step between candidates.
pub(super) const BETA_STEP: f32 = (2.0 * OUTERMOST / (CANDIDATES - 1) as f64) as f32;
/// Frequencies above are not used, cycles a pixel: a sensor's pixels alias there.
pub(super) const BAND: f64 = 0.35;
/// Frequencies of the design, along each axis of a whole period.
const GRID: usize = 48;
/// Standard deviation of the texture that the filters are best for, gray levels.
const TEXTURE_SIGMA: f64 = 42.0;
/// How much vanishing at the right β counts against the filters' shape.
const VANISHING: f64 = 30.0;
/// How much larger than the noise B takes it to be, as a variance: caution.
const NOISE_MARGIN: f64 = 25.0;
/// Largest blur that kernels of 9 × 9 reach around, in pixels; wider ones are 13 × 13.
const SMALL_KERNEL_BLUR_PX: f64 = 5.5;

/// The kernels and coefficients of one optics.
#[derive(Clone, Debug)]
pub(super) struct KernelBank {
    /// K: side of the kernels in pixels.
    pub(super) side: usize,
    /// The orbits (a, b), 0 ≤ a ≤ b ≤ K/2.
    pub(super) orbits: Vec<(usize, usize)>,
    /// For each orbit, its value in the kernels a_j of the near-focused picture, then in the b_j of the far one.
    pub(super) values: Vec<[[f32; RANK]; 2]>,
    /// For each β: the factors of the products in E(β) = c(β)ᵀ Q c(β).
    pub(super) forms: Vec<[f32; PRODUCTS]>,
    /// β by E's minimum, for minima [`CORRECTION_STEP`] apart from −[`OUTERMOST`] on: with kernels this small the
    /// residual doesn't vanish wholly at the right β, which biases the minimum for a texture of a 1/f spectrum.
    pub(super) correction: Vec<f32>,
}

/// What a window full of texture says of its depth.
pub(super) struct Evidence {
    /// d²E/dβ².
    pub(super) second_derivative: f64,
    /// What the kernels leave of the texture at the right β.
    pub(super) left: f64,
}

/// The lowest candidate that has neighbours, and E about it.
fn lowest(energy: &[f64]) -> (usize, [f64; 3]) {
    let lowest = (0..CANDIDATES).min_by(|&a, &b| energy[a].total_cmp(&energy[b])).unwrap_or(0);
    let lowest = lowest.clamp(1, CANDIDATES - 2);
    (lowest, [lowest - 1, lowest, lowest + 1].map(|candidate| energy[candidate]))
}

/// The step between entries of the correction.
const CORRECTION_STEP: f64 = 0.01;

/// β of a candidate.
pub(super) fn beta_of(candidate: usize) -> f64 {
    -OUTERMOST + 2.0 * OUTERMOST * candidate as f64 / (CANDIDATES - 1) as f64
}

/// The pairs (i, j), i ≤ j, in the order of the products.
pub(super) fn product_pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..RANK).flat_map(|i| (i..RANK).map(move |j| (i, j)))
}

/// One frequency of the design, standing for all that symmetry makes equal.
struct Frequency {
    cycles: f64,
    multiplicity: f64,
    /// Of each orbit, its response less what a constant gives: the orbit (0, 0) balances every kernel.
    responses: Vec<f64>,
}

impl KernelBank {
    /// The bank of an optics whose largest blur is at most 7.5 px, for pictures that were halved so often; its pixels
    /// are those of the halved pictures.
    pub(super) fn new(optics: &Optics, halvings: u32) -> KernelBank {
        // Of one gray level before halving.
        let noise_sigma = 0.5_f64.powi(halvings as i32);
        let side = if optics.largest_blur_px() < SMALL_KERNEL_BLUR_PX { 9 } else { 13 };
        let reach = side / 2;
        let orbits: Vec<_> = (0..=reach).flat_map(|b| (0..=b).map(move |a| (a, b))).collect();
        let frequencies = frequencies(&orbits);
        let pairs: Vec<Vec<f64>> = (0..CANDIDATES)
            .map(|candidate| {
                let blur_px = optics.registered_blur_px(beta_of(candidate));
                weighted_pair(
                    &residual_filters(blur_px, noise_sigma, &frequencies, orbits.len() - 1),
                    &orbits,
                )
            })
            .collect();
        let directions = principal_directions(&pairs);
        let kernels = |orbit: usize| {
            let root = orbit_size(orbits[orbit]).sqrt();
            [0, orbits.len()].map(|from| std::array::from_fn(|j| (directions[j][from + orbit] / root) as f32))
        };
        let values = (0..orbits.len()).map(kernels).collect();
        let forms = pairs.iter().map(|pair| quadratic_form(pair, &directions)).collect();
        let bank = KernelBank { side, orbits, values, forms, correction: Vec::new() };
        KernelBank { correction: bank.correction(optics, &frequencies), ..bank }
    }

    /// True β by the minimum of E that a texture of a 1/f spectrum has there.
    fn correction(&self, optics: &Optics, frequencies: &[Frequency]) -> Vec<f32> {
        let responses = self.responses(frequencies);
        let truths: Vec<f64> = (0..CANDIDATES).map(beta_of).collect();
        let minimum = |&beta: &f64| self.minimum(optics.registered_blur_px(beta), frequencies, &responses);
        let minima = pooled(&truths.iter().map(minimum).collect::<Vec<f64>>());
        let curve = MonotoneCurve::inverse_through(&minima, &truths);
        let entries = (2.0 * OUTERMOST / CORRECTION_STEP).round() as usize + 1;
        (0..entries)
            .map(|k| curve.at(-OUTERMOST + CORRECTION_STEP * k as f64).0.clamp(-OUTERMOST, OUTERMOST) as f32)
            .collect()
    }

    /// The response of each kernel a_j, and of each b_j, to each frequency.
    fn responses(&self, frequencies: &[Frequency]) -> Vec<[[f64; RANK]; 2]> {
        let response = |frequency: &Frequency, picture: usize, j: usize| {
            let taps = self.values[1..].iter().zip(&frequency.responses);
            taps.map(|(values, response)| f64::from(values[picture][j]) * response).sum()
        };
        let responses = frequencies
            .iter()
            .map(|frequency| [0, 1].map(|picture| std::array::from_fn(|j| response(frequency, picture, j))));
        responses.collect()
    }

    /// Where E is least for a texture of a 1/f spectrum under this blur of the near and the far picture.
    fn minimum(&self, blur_px: [f64; 2], frequencies: &[Frequency], responses: &[[[f64; RANK]; 2]]) -> f64 {
        let energy = self.curve(blur_px, frequencies, responses);
        let (lowest, [before, here, after]) = lowest(&energy);
        let second_difference = (before - 2.0 * here + after).max(f64::MIN_POSITIVE);
        let offset = (0.5 * (before - after) / second_difference).clamp(-1.0, 1.0);
        beta_of(lowest) + f64::from(BETA_STEP) * offset
    }

    /// E at each candidate for a texture of a 1/f spectrum under this blur, summed over the frequencies of the design.
    fn curve(
        &self,
        blur_px: [f64; 2],
        frequencies: &[Frequency],
        responses: &[[[f64; RANK]; 2]],
    ) -> Vec<f64> {
        let mut products = [0.0; PRODUCTS];
        for (frequency, [a, b]) in frequencies.iter().zip(responses) {
            let [near, far] = blur_px.map(|diameter| pillbox(frequency.cycles, diameter));
            let q: [f64; RANK] = std::array::from_fn(|j| a[j] * near + b[j] * far);
            let weight = frequency.multiplicity * spectrum(frequency.cycles);
            for (sum, (i, j)) in products.iter_mut().zip(product_pairs()) {
                *sum += weight * q[i] * q[j];
            }
        }
        let energy = |form: &[f32; PRODUCTS]| -> f64 {
            form.iter().zip(&products).map(|(factor, product)| f64::from(*factor) * product).sum()
        };
        self.forms.iter().map(energy).collect()
    }

    /// d²E/dβ² and E at the minimum for a texture of a 1/f spectrum and a standard deviation of one gray level, under
    /// each of these blurs of the near and the far picture.
    pub(super) fn evidence(&self, blurs_px: &[[f64; 2]]) -> Vec<Evidence> {
        let frequencies = frequencies(&self.orbits);
        let responses = self.responses(&frequencies);
        let variance: f64 = frequencies.iter().map(|f| f.multiplicity * spectrum(f.cycles)).sum();
        let step = f64::from(BETA_STEP);
        let of = |&blur_px: &[f64; 2]| {
            let (_, [before, here, after]) = lowest(&self.curve(blur_px, &frequencies, &responses));
            let second_derivative = (before - 2.0 * here + after) / (step * step) / variance;
            Evidence { second_derivative, left: here / variance }
        };
        blurs_px.iter().map(of).collect()
    }

    /// β for a minimum of E.
    pub(super) fn corrected(&self, minimum: f32) -> f32 {
        let place = ((minimum + OUTERMOST as f32) / CORRECTION_STEP as f32).max(0.0);
        let before = (place as usize).min(self.correction.len() - 2);
        let (low, high) = (self.correction[before], self.correction[before + 1]);
        low + (high - low) * (place - before as f32).min(1.0)
    }

    /// All numbers of the bank, in a fixed order.
    pub(super) fn numbers(&self) -> Vec<f32> {
        let values = self.values.iter().flatten().flatten();
        values.chain(self.forms.iter().flatten()).chain(&self.correction).copied().collect()
    }

    /// How far the kernels reach, in pixels.
    pub(super) fn reach(&self) -> usize {
        self.side / 2
    }
}

/// A pair of kernels as one vector of unit length: values of the orbits, near then far, each times the root of its
/// orbit's size, so that lengths and angles are those of the kernels. `solution` lacks the orbit (0, 0), which balances
/// a kernel to a sum of 0.
fn weighted_pair(solution: &[f64], orbits: &[(usize, usize)]) -> Vec<f64> {
    let mut weighted = Vec::with_capacity(2 * orbits.len());
    for values in solution.chunks_exact(orbits.len() - 1) {
        let others = values.iter().zip(&orbits[1..]);
        let balance: f64 = others.clone().map(|(v, &orbit)| v * orbit_size(orbit)).sum();
        weighted.push(-balance);
        weighted.extend(others.map(|(v, &orbit)| v * orbit_size(orbit).sqrt()));
    }
    let noise_gain = weighted.iter().map(|v| v * v).sum::<f64>().sqrt();
    weighted.iter_mut().for_each(|v| *v /= noise_gain);
    weighted
}

/// The right singular vectors of the pairs, row by row: the eigenvectors of their small Gram matrix, to 1e-8 in f64.
fn principal_directions(pairs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let columns = pairs[0].len();
    let mut gram = vec![0.0; columns * columns];
    for pair in pairs {
        for (row, a) in gram.chunks_exact_mut(columns).zip(pair) {
            row.iter_mut().zip(pair).for_each(|(sum, b)| *sum += a * b);
        }
    }
    Symmetric::of(&gram, columns).expect("kernels of valid optics are finite").vectors
}

/// The factors of the products in E(β) = c(β)ᵀ Q c(β), c the pair's coordinates along the leading directions.
fn quadratic_form(pair: &[f64], directions: &[Vec<f64>]) -> [f32; PRODUCTS] {
    let mut c: [f64; RANK] =
        std::array::from_fn(|j| pair.iter().zip(&directions[j]).map(|(a, b)| a * b).sum());
    let length = c.iter().map(|v| v * v).sum::<f64>().sqrt();
    c.iter_mut().for_each(|v| *v /= length);
    let mut factors = product_pairs().map(|(i, j)| if i == j { c[i] * c[i] } else { 2.0 * c[i] * c[j] });
    std::array::from_fn(|_| factors.next().expect("as many as products") as f32)
}

/// Taps of an orbit.
fn orbit_size((a, b): (usize, usize)) -> f64 {
    match (a, b) {
        (0, 0) => 1.0,
        (0, _) => 4.0,
        (a, b) if a == b => 4.0,
        _ => 8.0,
    }
}

/// The frequencies (i, j)/GRID, 0 ≤ j ≤ i ≤ GRID/2, without (0, 0).
fn frequencies(orbits: &[(usize, usize)]) -> Vec<Frequency> {
    let half = GRID / 2;
    let wave = |k: usize, tap: usize| (std::f64::consts::TAU * (k * tap) as f64 / GRID as f64).cos();
    let axis = |k: usize| if k == 0 || k == half { 1.0 } else { 2.0 };
    let response = |i: usize, j: usize, (a, b): (usize, usize)| {
        orbit_size((a, b)) / 2.0 * (wave(i, a) * wave(j, b) + wave(i, b) * wave(j, a)) - orbit_size((a, b))
    };
    (1..=half)
        .flat_map(|i| (0..=i).map(move |j| (i, j)))
        .map(|(i, j)| Frequency {
            cycles: (i as f64).hypot(j as f64) / GRID as f64,
            multiplicity: axis(i) * axis(j) * if i == j { 1.0 } else { 2.0 },
            responses: orbits[1..].iter().map(|&orbit| response(i, j, orbit)).collect(),
        })
        .collect()
}

/// Power of the texture that the filters are best for: 1/f in amplitude.
fn spectrum(cycles: f64) -> f64 {
    TEXTURE_SIGMA * TEXTURE_SIGMA * 0.02 / (cycles * cycles + 1e-4)
}

/// The kernels nearest to the ideal filters of one β, by weighted least squares: values of the orbits but (0, 0), near
/// then far.
fn residual_filters(blur_px: [f64; 2], noise_sigma: f64, frequencies: &[Frequency], free: usize) -> Vec<f64> {
    let spectra: Vec<f64> = frequencies.iter().map(|frequency| spectrum(frequency.cycles)).collect();
    let transfers: Vec<[f64; 2]> = frequencies
        .iter()
        .map(|frequency| blur_px.map(|diameter| pillbox(frequency.cycles, diameter)))
        .collect();
    let both = |[n, f]: [f64; 2]| n * n + f * f + 1e-6;
    let count: f64 = frequencies.iter().map(|frequency| frequency.multiplicity).sum();
    let mean = |value: &dyn Fn(usize) -> f64| {
        (0..frequencies.len()).map(|k| frequencies[k].multiplicity * value(k)).sum::<f64>() / count
    };
    let mean_spectrum = mean(&|k| spectra[k]);
    let mean_signal = mean(&|k| spectra[k] * both(transfers[k]));

    let unknowns = 2 * free;
    let mut normal = vec![0.0; unknowns * unknowns];
    let mut right = vec![0.0; unknowns];
    for (k, frequency) in frequencies.iter().enumerate() {
        let ([near, far], q) = (transfers[k], both(transfers[k]));
        let signal = spectra[k] * q;
        let band =
            (1.0 - (-(frequency.cycles / 0.05).powi(2)).exp()) / (1.0 + (frequency.cycles / BAND).powi(8));
        let wanted = band * (signal / (signal + NOISE_MARGIN * noise_sigma * noise_sigma) / q).sqrt();
        let vanishing = frequency.multiplicity * VANISHING * VANISHING * spectra[k] / mean_spectrum;
        let shape = frequency.multiplicity * (0.3 + (signal / mean_signal).sqrt()).powi(2);
        let targets = [wanted * far, -wanted * near];
        for row in 0..unknowns {
            let (own, r) = ([near, far][row / free], frequency.responses[row % free]);
            right[row] += shape * r * targets[row / free];
            for column in 0..=row {
                let (other, c) = ([near, far][column / free], frequency.responses[column % free]);
                let same = if row / free == column / free { shape } else { 0.0 };
                normal[row * unknowns + column] += r * c * (vanishing * own * other + same);
            }
        }
    }
    let normal = Symmetric::of(&normal, unknowns).expect("weights of valid optics are finite");
    normal.solve(&right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::scene::bench_optics;

    fn optics(f_number: f64) -> Optics {
        bench_optics(f_number, true)
    }

    #[test]
    fn kernels_are_blind_to_a_constant_and_of_unit_noise_together() {
        for f_number in [8.0, 6.0] {
            let bank = KernelBank::new(&optics(f_number), 0);
            assert_eq!(bank.side, if f_number == 8.0 { 9 } else { 13 });
            for j in 0..RANK {
                let mut energy = 0.0;
                for picture in 0..2 {
                    let taps = bank.orbits.iter().zip(&bank.values);
                    let sum: f64 =
                        taps.clone().map(|(&o, values)| orbit_size(o) * f64::from(values[picture][j])).sum();
                    assert!(sum.abs() < 1e-5, "kernel {j} answers {sum} to a constant");
                    energy += taps
                        .map(|(&o, values)| orbit_size(o) * f64::from(values[picture][j]).powi(2))
                        .sum::<f64>();
                }
                assert!((energy - 1.0).abs() < 1e-4, "kernel {j} has an energy of {energy}");
            }
        }
    }

    #[test]
    fn a_minimum_is_read_as_the_depth_of_a_natural_texture() {
        let bank = KernelBank::new(&optics(8.0), 0);
        assert!(bank.corrected(0.0).abs() < 0.01, "the middle is the middle: {}", bank.corrected(0.0));
        let mut before = -2.0;
        for k in -130..=130 {
            let (minimum, read) = (k as f32 / 100.0, bank.corrected(k as f32 / 100.0));
            assert!(read >= before && (read - minimum).abs() < 0.1, "{minimum} is read as {read}");
            before = read;
        }
    }

    #[test]
    fn one_optics_gives_one_bank() {
        assert_eq!(KernelBank::new(&optics(8.0), 0).numbers(), KernelBank::new(&optics(8.0), 0).numbers());
        assert_ne!(KernelBank::new(&optics(8.0), 0).numbers(), KernelBank::new(&optics(8.1), 0).numbers());
    }
}
