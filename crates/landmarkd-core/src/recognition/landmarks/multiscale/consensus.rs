//! Consensus of an exemplar's matches on where it lies. Each match predicts a centre, a turn and a scale; those of background
//! scatter, those of a thing that is really there meet. The widths are in proportion to the exemplar: what is seen obliquely
//! or is not flat spreads the more the larger it is.

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
    let predictions: Vec<Prediction> =
        considered.iter().map(|&i| Prediction::of(&matches[i], diagonal_px)).collect();
    let mut weight: Vec<f32> = considered.iter().map(|&i| matches[i].weight).collect();
    let mut modes = Vec::new();
    while modes.len() < most {
        let mut top = (0.0, 0);
        for (i, about) in predictions.iter().enumerate().take(MOST_CENTRES) {
            if weight[i] > 0.0 {
                let density =
                    predictions.iter().zip(&weight).map(|(other, weight)| weight * about.kernel(other)).sum();
                if density > top.0 {
                    top = (density, i);
                }
            }
        }
        let (density, about) = (top.0, predictions.get(top.1));
        let Some(about) = about.filter(|_| density > 0.0) else { break };
        let near: Vec<usize> = (0..predictions.len())
            .filter(|&i| weight[i] > 0.0 && about.kernel(&predictions[i]) > LEAST_KERNEL)
            .collect();
        if near.len() < 2 {
            break;
        }
        near.iter().for_each(|&i| weight[i] = 0.0);
        modes.push(Mode { density, agreeing: near.into_iter().map(|i| considered[i]).collect() });
    }
    modes
}

/// The similarity that one match predicts.
struct Prediction {
    centre: [f32; 2],
    turn_rad: f32,
    log_scale: f32,
    /// 1 over the square of the width of the centre.
    sharpness: f32,
}

impl Prediction {
    fn of(found: &Match, diagonal_px: f32) -> Prediction {
        let width_px = (CENTRE_WIDTH * diagonal_px * found.scale).max(LEAST_CENTRE_WIDTH_PX);
        Prediction {
            centre: found.centre(),
            turn_rad: found.turn_rad,
            log_scale: found.scale.ln(),
            sharpness: 1.0 / (width_px * width_px),
        }
    }

    /// 1 where both predict the same, 0 where they have nothing to do with each other.
    fn kernel(&self, other: &Prediction) -> f32 {
        let (dx, dy) = (self.centre[0] - other.centre[0], self.centre[1] - other.centre[1]);
        let off = (dx * dx + dy * dy) * self.sharpness;
        let scaled = (self.log_scale - other.log_scale) * (1.0 / SCALE_WIDTH);
        if off + scaled * scaled > REACH {
            return 0.0;
        }
        let turned = turn_between(self.turn_rad, other.turn_rad) * (1.0 / TURN_WIDTH_RAD);
        let exponent = off + scaled * scaled + turned * turned;
        if exponent > REACH { 0.0 } else { (-0.5 * exponent).exp() }
    }
}

/// The angle between two turns, in 0..=π.
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
