//! Consensus of matches on where an exemplar lies. Each match predicts a placement of its exemplar; those of background
//! scatter, those of an object that is really there meet in one place. Modes of the density of the predictions are
//! found with a biweight kernel.

use pulp::{Arch, Simd, WithSimd};

use super::matching::Match;
use super::placement::{Placement, PointPair};
use crate::angle::angular_distance_rad;

/// Widths of the kernel: of the centre, of the rotation, of the logarithm of the scale.
const CENTRE_WIDTH_PX: f32 = 6.0;
const TURN_WIDTH_RAD: f32 = 12.0 * std::f32::consts::PI / 180.0;
const SCALE_WIDTH: f32 = 0.12;
/// The kernel is 0 beyond this many widths, squared.
const REACH: f32 = 6.25;
/// Of one exemplar's matches the heaviest so many are considered.
const MOST_MATCHES: usize = 512;
/// Hypotheses for one exemplar at most.
const MOST_MODES: usize = 6;
/// Inliers of a hypothesis at least.
const LEAST_INLIERS: usize = 2;

/// A match that agrees with a hypothesis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inlier {
    /// Index of the match.
    pub index: u32,
    /// What the match adds to the density.
    pub density: f32,
}

/// A placement of an exemplar that several matches agree on.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    /// Index of the exemplar.
    pub exemplar: usize,
    pub placement: Placement,
    /// Density of the matches at the placement: the sum over the inliers.
    pub density: f32,
    /// In the order of the matches.
    pub inliers: Vec<Inlier>,
}

/// The hypotheses of matches that are sorted by exemplar; densest first.
pub(super) fn hypotheses(matches: &[Match]) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    let mut first = 0;
    let mut density = KernelDensity::default();
    for group in matches.chunk_by(|a, b| a.exemplar == b.exemplar) {
        if group.len() >= LEAST_INLIERS {
            density.fill(group);
            let modes = density.modes(group).into_iter().map(|mut hypothesis| {
                hypothesis.inliers.iter_mut().for_each(|inlier| inlier.index += first as u32);
                hypothesis
            });
            found.extend(modes);
        }
        first += group.len();
    }
    found.sort_by(|a: &Hypothesis, b: &Hypothesis| {
        b.density.total_cmp(&a.density).then(a.exemplar.cmp(&b.exemplar))
    });
    found
}

/// Matches whose kernels are computed together.
const LANES: usize = 16;

/// The density of the placements that one exemplar's matches predict. Buffers are kept from exemplar to exemplar.
#[derive(Default)]
struct KernelDensity {
    /// Index of each match that is considered.
    matches: Vec<u32>,
    /// The prediction of each match in units of the widths: x, y, cos, sin, logarithm of the scale. Padded with zeros
    /// to a multiple of [`LANES`], as `weight` and `kernel`.
    coordinates: [Vec<f32>; 5],
    /// 0 for matches that a hypothesis has taken.
    weight: Vec<f32>,
    /// The kernel about one match, of every match.
    kernel: Vec<f32>,
    /// The density at each match.
    density: Vec<f32>,
}

impl KernelDensity {
    fn fill(&mut self, group: &[Match]) {
        self.matches.clear();
        self.matches.extend(0..group.len() as u32);
        if group.len() > MOST_MATCHES {
            let weight = |index: u32| group[index as usize].weight;
            self.matches.sort_by(|a, b| weight(*b).total_cmp(&weight(*a)));
            self.matches.truncate(MOST_MATCHES);
        }
        self.coordinates.iter_mut().for_each(Vec::clear);
        self.weight.clear();
        for &index in &self.matches {
            let Match { placement, weight, .. } = group[index as usize];
            let (sin, cos) = placement.rotation_rad.sin_cos();
            let at = [
                placement.x_px / CENTRE_WIDTH_PX,
                placement.y_px / CENTRE_WIDTH_PX,
                cos / TURN_WIDTH_RAD,
                sin / TURN_WIDTH_RAD,
                placement.scale.ln() / SCALE_WIDTH,
            ];
            self.coordinates.iter_mut().zip(at).for_each(|(all, value)| all.push(value));
            self.weight.push(weight);
        }
        let padded = self.matches.len().next_multiple_of(LANES);
        self.coordinates.iter_mut().for_each(|all| all.resize(padded, 0.0));
        self.weight.resize(padded, 0.0);
        self.kernel.resize(padded, 0.0);
        self.density.clear();
        for i in 0..self.matches.len() {
            let density = self.kernel_about(i);
            self.density.push(density);
        }
    }

    /// Computes the kernel of every match about match `i`. Returns the density there.
    fn kernel_about(&mut self, i: usize) -> f32 {
        let about = [0, 1, 2, 3, 4].map(|axis| self.coordinates[axis][i]);
        let coordinates = self.coordinates.each_ref().map(|all| all.as_chunks().0);
        let (weight, out) = (self.weight.as_chunks().0, self.kernel.as_chunks_mut().0);
        Arch::new().dispatch(BiweightKernel { about, coordinates, weight, out })
    }

    /// The modes, densest first. Takes the matches of each away before it looks for the next.
    fn modes(&mut self, group: &[Match]) -> Vec<Hypothesis> {
        let mut modes = Vec::new();
        while modes.len() < MOST_MODES {
            let Some(top) =
                (0..self.density.len()).max_by(|&a, &b| self.density[a].total_cmp(&self.density[b]))
            else {
                break;
            };
            self.kernel_about(top);
            let added = |i: usize| self.kernel[i] * self.weight[i];
            let agree: Vec<usize> = (0..self.matches.len()).filter(|&i| added(i) > 0.0).collect();
            let inliers = agree.iter().map(|&i| Inlier { index: self.matches[i], density: added(i) });
            let inliers = one_per_window(inliers.collect(), group);
            if inliers.len() < LEAST_INLIERS {
                break;
            }
            modes.push(Hypothesis {
                exemplar: group[0].exemplar as usize,
                placement: consensus(&inliers, group, &group[self.matches[top] as usize].placement),
                density: inliers.iter().map(|inlier| inlier.density).sum(),
                inliers,
            });
            self.take_away(&agree);
        }
        modes
    }

    /// Subtracts matches from the density.
    fn take_away(&mut self, taken: &[usize]) {
        for &i in taken {
            self.kernel_about(i);
            for (density, kernel) in self.density.iter_mut().zip(&self.kernel) {
                *density -= kernel * self.weight[i];
            }
            self.density[i] = f32::NEG_INFINITY;
        }
        taken.iter().for_each(|&i| self.weight[i] = 0.0);
    }
}

/// The inliers in the order of the matches: of those of one window of the frame the one that adds most.
fn one_per_window(mut inliers: Vec<Inlier>, group: &[Match]) -> Vec<Inlier> {
    let query = |inlier: &Inlier| group[inlier.index as usize].query;
    inliers.sort_by(|a, b| query(a).cmp(&query(b)).then(b.density.total_cmp(&a.density)));
    inliers.dedup_by_key(|inlier| query(inlier));
    inliers.sort_by_key(|inlier| inlier.index);
    inliers
}

/// The similarity that fits the inliers' positions, if it is near the mean of their predictions and the mode; else that
/// mean.
fn consensus(inliers: &[Inlier], group: &[Match], mode: &Placement) -> Placement {
    let matched = |inlier: &Inlier| &group[inlier.index as usize];
    let sum = |value: fn(&Placement) -> f32| {
        inliers.iter().fold(0.0, |sum, inlier| sum + inlier.density * value(&matched(inlier).placement))
    };
    let total = sum(|_| 1.0);
    let mean = Placement {
        x_px: sum(|at| at.x_px) / total,
        y_px: sum(|at| at.y_px) / total,
        rotation_rad: sum(|at| at.rotation_rad.sin()).atan2(sum(|at| at.rotation_rad.cos())),
        scale: (sum(|at| at.scale.ln()) / total).exp(),
    };
    let near = |fit: &Placement| {
        angular_distance_rad(fit.rotation_rad, mean.rotation_rad) < 2.0 * TURN_WIDTH_RAD
            && (fit.x_px - mode.x_px).hypot(fit.y_px - mode.y_px) < 2.0 * CENTRE_WIDTH_PX
    };
    let pair = |inlier: &Inlier| {
        let Match { from, to, .. } = *matched(inlier);
        PointPair { exemplar: from, frame: to, weight: inlier.density }
    };
    let pairs: Vec<PointPair> = inliers.iter().map(pair).collect();
    Placement::fit(&pairs, Some(mean.scale)).filter(|fit| pairs.len() >= 3 && near(fit)).unwrap_or(mean)
}

/// (1 − u²)² of the distance u in units of the reach.
struct BiweightKernel<'a> {
    about: [f32; 5],
    coordinates: [&'a [[f32; LANES]]; 5],
    weight: &'a [[f32; LANES]],
    out: &'a mut [[f32; LANES]],
}

impl WithSimd for BiweightKernel<'_> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f32 {
        let [x0, y0, cos0, sin0, scale0] = self.about;
        let mut density = [0.0; LANES];
        for chunk in 0..self.out.len() {
            let [x, y, cos, sin, scale] = self.coordinates;
            let (x, y, cos, sin, scale) = (&x[chunk], &y[chunk], &cos[chunk], &sin[chunk], &scale[chunk]);
            let (weight, out) = (&self.weight[chunk], &mut self.out[chunk]);
            for i in 0..LANES {
                let (dx, dy, dc, ds, dl) =
                    (x[i] - x0, y[i] - y0, cos[i] - cos0, sin[i] - sin0, scale[i] - scale0);
                let left = 1.0 - (dx * dx + dy * dy + dc * dc + ds * ds + dl * dl) * (1.0 / REACH);
                let left = if left > 0.0 { left } else { 0.0 };
                out[i] = left * left;
                density[i] += out[i] * weight[i];
            }
        }
        let mut sum = 0.0;
        for lane in density {
            sum += lane;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn predicting(exemplar: u32, x_px: f32, degrees: f32, from: [f32; 2], weight: f32) -> Match {
        let placement = Placement { x_px, y_px: 80.0, rotation_rad: degrees.to_radians(), scale: 1.0 };
        let query = (from[0] * 100.0 + from[1] + x_px * 7.0) as i32 as u32;
        Match { query, distance: 0.0, exemplar, placement, from, to: placement.apply(from), weight }
    }

    #[test]
    fn matches_that_agree_outweigh_more_that_do_not() {
        let mut matches: Vec<Match> = (0..30)
            .map(|i| predicting(0, 10.0 + 37.0 * i as f32, 53.0 * i as f32, [5.0, 0.0], 0.2))
            .collect();
        let corners = [[-20.0, -10.0], [15.0, -12.0], [3.0, 25.0], [-9.0, 14.0]];
        matches.extend(corners.map(|from| predicting(1, 100.0, 40.0, from, 0.1)));
        let found = hypotheses(&matches);
        assert_eq!(found[0].exemplar, 1);
        assert_eq!(found[0].inliers.len(), 4);
        let placement = found[0].placement;
        assert!(
            (placement.x_px - 100.0).abs() < 1e-3 && (placement.y_px - 80.0).abs() < 1e-3,
            "{placement:?}"
        );
        assert!((placement.rotation_rad.to_degrees() - 40.0).abs() < 1e-2);
        assert!((found[0].density - 0.4).abs() < 1e-6);
    }

    #[test]
    fn one_exemplar_may_lie_in_several_places_and_no_match_counts_twice() {
        let corners = [[-20.0, -10.0], [15.0, -12.0], [3.0, 25.0]];
        let places = [(40.0, 0.0), (140.0, 90.0), (240.0, -170.0)];
        let matches: Vec<Match> = places
            .iter()
            .flat_map(|&(x, degrees)| corners.map(|from| predicting(0, x, degrees, from, 0.1)))
            .collect();
        let found = hypotheses(&matches);
        let mut at: Vec<f32> = found.iter().map(|hypothesis| hypothesis.placement.x_px.round()).collect();
        at.sort_by(f32::total_cmp);
        assert_eq!(at, [40.0, 140.0, 240.0]);
        let mut inliers: Vec<u32> =
            found.iter().flat_map(|h| h.inliers.iter().map(|inlier| inlier.index)).collect();
        inliers.sort_unstable();
        assert_eq!(inliers, (0..9).collect::<Vec<u32>>());
    }

    #[test]
    fn turns_agree_across_half_a_turn() {
        let matches =
            [predicting(0, 50.0, 178.0, [20.0, 0.0], 0.1), predicting(0, 50.0, -178.0, [-20.0, 3.0], 0.1)];
        let found = hypotheses(&matches);
        assert_eq!(found[0].inliers.len(), 2);
        assert!(found[0].placement.rotation_rad.to_degrees().abs() > 176.0);
    }

    #[test]
    fn a_single_match_is_no_hypothesis() {
        assert!(hypotheses(&[predicting(0, 50.0, 0.0, [1.0, 1.0], 1.0)]).is_empty());
        assert!(hypotheses(&[]).is_empty());
    }

    #[test]
    fn a_window_that_resembles_two_trained_ones_counts_once() {
        let mut twice =
            [predicting(0, 50.0, 0.0, [10.0, 4.0], 0.1), predicting(0, 51.0, 2.0, [12.0, 4.0], 0.1)];
        twice[1].query = twice[0].query;
        assert!(hypotheses(&twice).is_empty());
        let third = predicting(0, 50.0, 1.0, [-20.0, 9.0], 0.1);
        assert_eq!(hypotheses(&[twice[0], twice[1], third])[0].inliers.len(), 2);
    }
}
