//! Could this agreement be chance? The number of false alarms of a group of matches that one map explains (Desolneux, Moisan
//! and Morel 2008; Moisan and Stival 2004).
//!
//! Under the background model a match is an accident: it lies anywhere in the frame, and its turn and scale are those of any
//! match of this frame. Of n matches k agree with a map that s of them determined. Every one of the k then has the right turn
//! and scale, and k − s of them the right place:
//!
//! NFA = tests · (n − s) · C(n, k) · C(k, s) · p_similar^k · p_place^(k − s)
//!
//! Matches whose windows overlap see the same thing and are one witness. Near matches are rarer accidents than far ones: the
//! nearest half, quarter … are judged by themselves, and the best of these counts, as one test more each.

use std::f64::consts::PI;

use super::consensus::turn_between;
use super::matching::Match;
use crate::recognition::landmarks::homography::Homography;

/// Tolerances that are tried: part of the widest for the place; radians for the turn, which is that for the scale's logarithm.
pub(super) const TOLERANCES: [(f64, f32); 5] =
    [(1.0, 0.5), (0.5, 0.5), (0.25, 0.5), (0.125, 0.4), (0.0625, 0.3)];
/// Nearest parts of the matches that are judged by themselves: all, a half, a quarter, …
const STRATA: usize = 5;
/// Windows nearer than this part of their radius are one witness.
pub(super) const SEPARATION: f32 = 0.5;

/// What accidents are like in one frame.
#[derive(Clone, Debug)]
pub(super) struct Background {
    /// Turn and logarithm of the scale of the frame's matches, a sample; by scale.
    similar: Vec<(f32, f32)>,
    area_px: f64,
    exemplars: usize,
}

/// A group of matches that a map explains.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// −log₁₀ of the number of false alarms.
    pub evidence: f64,
    /// Indices of the witnesses.
    pub witnesses: Vec<usize>,
    /// Matches that were asked.
    pub asked: usize,
}

impl Background {
    /// Of all the matches of a frame, against so many exemplars.
    pub fn of(matches: &[Match], [width_px, height_px]: [usize; 2], exemplars: usize) -> Background {
        let stride = (matches.len() / 4000).max(1);
        let mut similar: Vec<_> =
            matches.iter().step_by(stride).map(|m| (m.turn_rad, m.scale.ln())).collect();
        similar.sort_by(|a, b| a.1.total_cmp(&b.1));
        Background { similar, area_px: (width_px * height_px) as f64, exemplars }
    }

    /// The part of the frame's matches that have about this turn and scale.
    fn chance_similar(&self, turn_rad: f32, log_scale: f32, within: f32) -> f64 {
        let from = self.similar.partition_point(|&(_, scale)| scale <= log_scale - within);
        let end = self.similar.partition_point(|&(_, scale)| scale < log_scale + within).max(from);
        let near = |&&(turn, _): &&(f32, f32)| turn_between(turn, turn_rad) < within;
        let count = self.similar[from..end].iter().filter(near).count();
        ((count + 1) as f64 / (self.similar.len() + 1) as f64).min(0.5)
    }

    /// The group of an exemplar's matches that a map explains best, by any of the tolerances. `determined_by`: matches that
    /// determine such a map. `within_px`: the widest tolerance. `tests`: other maps that are tried.
    pub fn group(
        &self,
        matches: &[Match],
        order: &[usize],
        map: &Homography,
        determined_by: usize,
        within_px: f64,
        tests: usize,
    ) -> Option<Group> {
        let middle = map.local_similarity([0.0, 0.0]);
        let residuals: Vec<Residual> = matches.iter().map(|m| Residual::of(m, map, within_px)).collect();
        let tests = (self.exemplars * tests * TOLERANCES.len() * STRATA) as f64;
        let mut best: Option<Group> = None;
        let mut chances: Option<(f32, f64)> = None;
        // by weight: the witnesses of a nearer part are the first of those of a farther one
        let mut ends: Vec<usize> = (0..STRATA).rev().map(|s| matches.len().div_ceil(1 << s)).collect();
        ends.dedup();
        for (part, similar) in TOLERANCES {
            let px = within_px * part;
            let place = (PI * px * px / self.area_px).min(0.5).log10();
            let chance = match chances {
                Some((of, chance)) if of == similar => chance,
                _ => self.chance_similar(middle.turn_rad as f32, middle.scale.ln() as f32, similar).log10(),
            };
            chances = Some((similar, chance));
            let mut witnesses: Vec<usize> = Vec::new();
            let mut from = 0;
            for &end in &ends {
                let before = witnesses.len();
                for &i in &order[from..end] {
                    if residuals[i].within(px as f32, similar) && separate(&matches[i], &witnesses, matches) {
                        witnesses.push(i);
                    }
                }
                from = end;
                let (n, k, s) = (end, witnesses.len(), determined_by);
                // as many of more are likelier by chance
                if k > s && n > s && k > before {
                    let alarms = |ways: f64, of_them: f64| {
                        tests.log10()
                            + ((n - s) as f64).log10()
                            + ways
                            + of_them
                            + k as f64 * chance
                            + (k - s) as f64 * place
                    };
                    let better = |alarms: f64| best.as_ref().is_none_or(|b| -alarms > b.evidence);
                    // what is not better without the binomials, which are ≥ 1, is not with them
                    if better(alarms(0.0, 0.0)) {
                        let alarms = alarms(log10_choose(n, k), log10_choose(k, s));
                        if better(alarms) {
                            best = Some(Group { evidence: -alarms, witnesses: witnesses.clone(), asked: n });
                        }
                    }
                }
            }
        }
        best
    }
}

/// How far a match is from what a map says.
pub(super) struct Residual {
    px: f32,
    turn_rad: f32,
    log_scale: f32,
}

impl Residual {
    /// Of a match; infinite where it is farther than `within_px`.
    pub fn of(found: &Match, map: &Homography, within_px: f64) -> Residual {
        let (from, to) = found.pair();
        let at = map.apply(from);
        let px = (at[0] - to[0]).hypot(at[1] - to[1]);
        if px >= within_px || px.is_nan() {
            return Residual { px: f32::MAX, turn_rad: 0.0, log_scale: 0.0 };
        }
        let local = map.local_similarity(from);
        Residual {
            px: px as f32,
            turn_rad: turn_between(found.turn_rad, local.turn_rad as f32),
            log_scale: (found.scale / local.scale as f32).ln().abs(),
        }
    }

    /// Whether all three are within their tolerances.
    pub fn within(&self, px: f32, similar: f32) -> bool {
        self.px < px && self.turn_rad < similar && self.log_scale < similar
    }
}

/// Whether a match sees another thing than the witnesses so far, in the frame and in the exemplar.
fn separate(found: &Match, witnesses: &[usize], matches: &[Match]) -> bool {
    witnesses.iter().all(|&i| {
        let other = &matches[i];
        let off = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        let radius_px = SEPARATION * found.radius_px.max(other.radius_px);
        let there_px = radius_px / found.scale;
        found.query != other.query
            && off(found.to, other.to) >= radius_px.powi(2)
            && off(found.from, other.from) >= there_px.powi(2)
    })
}

/// log₁₀ of n over k.
pub(super) fn log10_choose(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    let k = k.min(n - k);
    (0..k).map(|i| ((n - i) as f64 / (i + 1) as f64).log10()).sum()
}

#[cfg(test)]
mod tests {
    use super::super::planted::{accidents, planted};
    use super::*;

    #[test]
    fn binomial_coefficients_are_exact() {
        for (n, k, exact) in [
            (5, 2, 10.0),
            (10, 0, 1.0),
            (10, 10, 1.0),
            (52, 5, 2_598_960.0),
            (50, 25, 126_410_606_437_752.0_f64),
        ] {
            assert!((log10_choose(n, k) - f64::log10(exact)).abs() < 1e-9, "{n} over {k}");
        }
    }

    #[test]
    fn a_planted_group_is_evident_and_accidents_are_not() {
        let map = Homography::similarity([320.0, 240.0], 0.3, 1.2);
        let judged = |matches: &[Match]| {
            let order: Vec<usize> = (0..matches.len()).collect();
            Background::of(matches, [640, 480], 10).group(matches, &order, &map, 2, 40.0, 4)
        };
        let mut matches = accidents(1, 300, 7);
        assert!(judged(&matches).is_none_or(|group| group.evidence < 1.0));
        matches.extend(planted(0, &map, 20, 10_000, 8));
        assert!(judged(&matches).is_some_and(|group| group.evidence > 5.0 && group.witnesses.len() >= 10));
    }
}
