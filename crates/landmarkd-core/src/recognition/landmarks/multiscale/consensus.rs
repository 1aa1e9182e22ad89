//! Consensus of an exemplar's matches on where it lies. Each match predicts a centre, a turn and a scale; those of background
//! scatter, those of a thing that is really there meet. The widths are in proportion to the exemplar: what is seen obliquely
//! or is not flat spreads the more the larger it is.

use pulp::{Arch, Simd, WithSimd};

use super::matching::Match;

/// Widths of the kernel: of the centre as a part of the placed exemplar's diagonal, of the turn, of the scale's logarithm.
const CENTRE_WIDTH: f32 = 0.08;
const LEAST_CENTRE_WIDTH_PX: f32 = 8.0;
const TURN_WIDTH_RAD: f32 = 0.35;
const SCALE_WIDTH: f32 = 0.35;
/// A match agrees with a mode where the kernel exceeds this.
const LEAST_KERNEL: f32 = 0.25;
/// Of an exemplar's matches the heaviest so many are considered.
const MOST_MATCHES: usize = 320;

/// At the heaviest so many of these a mode is looked for.
const MOST_CENTRES: usize = 64;
/// The kernel is 0 where its exponent exceeds this.
const REACH: f32 = 9.0;

/// A placement that several matches agree on.
#[derive(Clone, Debug)]
pub(super) struct Mode {
    /// Sum of the kernel times the weight of all matches.
    pub density: f32,
    /// Indices of the matches that agree.
    pub agreeing: Vec<usize>,
}

/// The densest modes of one exemplar's matches, at most `most`; each takes its matches away before the next is looked for.
pub(super) fn modes(matches: &[Match], diagonal_px: f32, most: usize) -> Vec<Mode> {
    let mut considered: Vec<usize> = (0..matches.len()).collect();
    considered.sort_by(|&a, &b| matches[b].weight.total_cmp(&matches[a].weight)); // stable
    considered.truncate(MOST_MATCHES);
    let predictions = Predictions::of(considered.iter().map(|&i| &matches[i]), diagonal_px);
    let mut weight: Vec<f32> = considered.iter().map(|&i| matches[i].weight).collect();
    let mut exponents = vec![0.0; predictions.sharpness.len()];
    let mut modes = Vec::new();
    while modes.len() < most {
        let mut top = (0.0, 0);
        for i in 0..considered.len().min(MOST_CENTRES) {
            if weight[i] > 0.0 {
                let mut density = 0.0;
                predictions.near(i, &mut exponents, |other, kernel| density += weight[other] * kernel);
                if density > top.0 {
                    top = (density, i);
                }
            }
        }
        let (density, about) = top;
        if density <= 0.0 {
            break;
        }
        let mut near: Vec<usize> = Vec::new();
        predictions.near(about, &mut exponents, |i, kernel| {
            if weight[i] > 0.0 && kernel > LEAST_KERNEL {
                near.push(i);
            }
        });
        if near.len() < 2 {
            break;
        }
        near.iter().for_each(|&i| weight[i] = 0.0);
        modes.push(Mode { density, agreeing: near.into_iter().map(|i| considered[i]).collect() });
    }
    modes
}

/// Matches that are compared together.
const LANES: usize = 16;

/// The similarities that matches predict, each number side by side; padded to a multiple of [`LANES`] by what is far from
/// everything.
struct Predictions {
    centre_x: Vec<f32>,
    centre_y: Vec<f32>,
    turn_rad: Vec<f32>,
    log_scale: Vec<f32>,
    /// 1 over the square of the width of the centre.
    sharpness: Vec<f32>,
}

impl Predictions {
    fn of<'a>(matches: impl ExactSizeIterator<Item = &'a Match>, diagonal_px: f32) -> Predictions {
        let padded = matches.len().next_multiple_of(LANES);
        let [mut centre_x, mut centre_y, mut turn_rad, mut log_scale, mut sharpness] =
            [(); 5].map(|()| Vec::with_capacity(padded));
        for found in matches {
            let width_px = (CENTRE_WIDTH * diagonal_px * found.scale).max(LEAST_CENTRE_WIDTH_PX);
            let [x, y] = found.centre();
            centre_x.push(x);
            centre_y.push(y);
            turn_rad.push(found.turn_rad);
            log_scale.push(found.scale.ln());
            sharpness.push(1.0 / (width_px * width_px));
        }
        centre_x.resize(padded, f32::INFINITY);
        [&mut centre_y, &mut turn_rad, &mut log_scale, &mut sharpness]
            .into_iter()
            .for_each(|all| all.resize(padded, 0.0));
        Predictions { centre_x, centre_y, turn_rad, log_scale, sharpness }
    }

    /// Calls `met` with every prediction that has to do with one of them, in their order, and the kernel: 1 where both predict
    /// the same.
    fn near(&self, about: usize, exponents: &mut [f32], mut met: impl FnMut(usize, f32)) {
        Arch::new().dispatch(Exponents { all: self, about, exponents });
        for (number, chunk) in exponents.as_chunks::<LANES>().0.iter().enumerate() {
            let mut within = 0;
            for exponent in chunk {
                within += i32::from(*exponent <= REACH);
            }
            if within > 0 {
                for (lane, exponent) in chunk.iter().enumerate().filter(|(_, exponent)| **exponent <= REACH) {
                    met(number * LANES + lane, (-0.5 * exponent).exp());
                }
            }
        }
    }
}

/// The square of the distance of all predictions from one, in widths of its kernel.
struct Exponents<'a> {
    all: &'a Predictions,
    about: usize,
    exponents: &'a mut [f32],
}

impl WithSimd for Exponents<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (p, i, padded) = (self.all, self.about, self.exponents.len());
        let (x0, y0, turn0, scale0, sharpness) =
            (p.centre_x[i], p.centre_y[i], p.turn_rad[i], p.log_scale[i], p.sharpness[i]);
        let (x, y) = (&p.centre_x[..padded], &p.centre_y[..padded]);
        let (turn, scale) = (&p.turn_rad[..padded], &p.log_scale[..padded]);
        for i in 0..padded {
            let (dx, dy) = (x0 - x[i], y0 - y[i]);
            let off = (dx * dx + dy * dy) * sharpness;
            let scaled = (scale0 - scale[i]) * (1.0 / SCALE_WIDTH);
            let turned = turn_between(turn0, turn[i]) * (1.0 / TURN_WIDTH_RAD);
            self.exponents[i] = off + scaled * scaled + turned * turned;
        }
    }
}

/// The angle between two turns, in 0..=π.
#[inline(always)]
pub(super) fn turn_between(a: f32, b: f32) -> f32 {
    let turned = (a - b).abs();
    if turned > std::f32::consts::PI { std::f32::consts::TAU - turned } else { turned }
}

#[cfg(test)]
mod tests {
    use super::super::planted::{accidents, planted};
    use super::*;
    use crate::recognition::landmarks::homography::Homography;

    #[test]
    fn the_densest_mode_is_the_planted_one() {
        let mut matches = accidents(1, 200, 9);
        matches.extend(planted(0, &Homography::similarity([200.0, 300.0], -0.8, 0.9), 30, 10_000, 10));
        let modes = modes(&matches, 250.0, 2);
        let right = modes[0].agreeing.iter().filter(|&&i| i >= 200).count();
        assert!(right >= 28, "{right}");
        assert!(modes[0].agreeing.len() - right <= 3);
        assert!(modes.len() < 2 || modes[1].density < 0.5 * modes[0].density);
        assert!(super::modes(&[], 250.0, 2).is_empty());
    }
}
