//! Hypotheses: where exemplars lie in a frame, each with its evidence that this is no accident.

use super::a_contrario::{Background, Group, Residual};
use super::consensus::{self, Mode, turn_between};
use super::matching::Match;
use crate::recognition::landmarks::homography::{Homography, LEAST_POINTS};
use crate::recognition::landmarks::options::Viewpoint;

/// What is known of an exemplar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exemplar {
    pub width_px: usize,
    pub height_px: usize,
}

/// What is known of a frame.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub size_px: [usize; 2],
    /// Sorted by exemplar.
    pub matches: &'a [Match],
}

/// How hypotheses are looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct HypothesisOptions {
    /// Exemplars whose matches are looked at, by their votes.
    pub promising: usize,
    /// Of the nearest so many trained windows a window of the frame votes for the place.
    pub voting: u32,
    /// Places an exemplar.
    pub modes: usize,
    /// Hypotheses that are explained, densest first.
    pub explained: usize,
    /// Widest tolerance for the place, part of the frame's diagonal.
    pub tolerance: f64,
    /// Rounds of the search for a plane.
    pub rounds: usize,
    /// Evidence from which on it is no accident.
    pub least_evidence: f64,
    /// What is likelier is told otherwise of places than of things.
    pub viewpoint: Viewpoint,
    /// The exemplars are chosen from so many, if those are more.
    pub chosen_from: usize,
}

impl Default for HypothesisOptions {
    fn default() -> Self {
        HypothesisOptions {
            promising: 40,
            voting: 6,
            modes: 1,
            explained: 16,
            tolerance: 0.0125,
            rounds: 300,
            least_evidence: 2.0,
            viewpoint: Viewpoint::Free,
            chosen_from: 0,
        }
    }
}

/// Evidence of a placement that too few witnesses agree with to be judged.
const LEAST_EVIDENCE: f64 = -20.0;
/// Maps that are tried for one mode: a similarity and a plane, each with its fits.
const MAPS: usize = 4;
/// The widest tolerance is so many times that of the fit: what is not flat agrees about a place only roughly.
const WIDER: f64 = 4.0;
/// A match supports a placement if it agrees to within this part of the placed exemplar's diagonal, and in turn and scale.
const SUPPORT_PLACE: f64 = 0.1;
const SUPPORT_SIMILAR: f32 = 0.5;
/// Fewer witnesses than this are asked for more evidence: what few windows say, dependence can fake.
const FEW_WITNESSES: usize = 5;
const MORE_EVIDENCE: f64 = 2.0;

/// A placement of an exemplar, and what speaks for it.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub exemplar: usize,
    /// Of offsets from the exemplar's centre to frame pixels.
    pub map: Homography,
    /// −log₁₀ of the number of false alarms.
    pub evidence: f64,
    /// Density of the consensus.
    pub density: f32,
    /// Indices of the witnesses among the frame's matches.
    pub witnesses: Vec<usize>,
    /// Matches of the exemplar that were asked.
    pub asked: usize,
    /// The exemplar's votes by windows that roughly agree with the placement.
    pub support: f64,
    /// The exemplar's votes, wherever it lies.
    pub votes: f64,
}

impl Hypothesis {
    /// Whether the agreement is no accident.
    pub fn is_evident(&self, least_evidence: f64) -> bool {
        let few = self.witnesses.len() < FEW_WITNESSES;
        self.evidence >= least_evidence * if few { MORE_EVIDENCE } else { 1.0 }
    }
}

/// The hypotheses of a frame, most evident first; of each exemplar the best. `votes`: of the exemplars.
pub(super) fn hypotheses(
    exemplars: &[Exemplar],
    frame: &Frame,
    votes: &[f64],
    o: &HypothesisOptions,
) -> Vec<Hypothesis> {
    let background = Background::of(frame.matches, frame.size_px, exemplars.len().max(o.chosen_from));
    let mut order: Vec<usize> = (0..exemplars.len()).collect();
    order.sort_by(|&a, &b| votes[b].total_cmp(&votes[a]));
    order.truncate(o.promising);
    let mut seen = Vec::new();
    for e in order {
        let first = frame.matches.partition_point(|m| (m.exemplar as usize) < e);
        let count = frame.matches[first..].partition_point(|m| m.exemplar as usize == e);
        let all = &frame.matches[first..first + count];
        let voting: Vec<usize> = (0..all.len()).filter(|&i| all[i].rank < o.voting).collect();
        let voters: Vec<Match> = voting.iter().map(|&i| all[i]).collect();
        let diagonal = (exemplars[e].width_px as f32).hypot(exemplars[e].height_px as f32);
        for mut mode in consensus::modes(&voters, diagonal, o.modes) {
            mode.agreeing.iter_mut().for_each(|i| *i = voting[*i]);
            seen.push((mode, e, first, all));
        }
    }
    seen.sort_by(|a, b| b.0.density.total_cmp(&a.0.density));
    seen.truncate(o.explained);
    let mut out: Vec<Hypothesis> = Vec::new();
    for (mode, e, first, all) in seen {
        let Some(mut found) = explained(&exemplars[e], frame, all, &mode, &background, o) else { continue };
        found.exemplar = e;
        found.votes = votes[e];
        found.witnesses.iter_mut().for_each(|i| *i += first);
        match out.iter_mut().find(|other| other.exemplar == e) {
            Some(other) if other.evidence < found.evidence => *other = found,
            Some(_) => {}
            None => out.push(found),
        }
    }
    out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    out
}

/// The map that explains most of an exemplar's matches near a mode: a similarity or a plane.
fn explained(
    exemplar: &Exemplar,
    frame: &Frame,
    all: &[Match],
    mode: &Mode,
    background: &Background,
    o: &HypothesisOptions,
) -> Option<Hypothesis> {
    let within_px = (o.tolerance * (frame.size_px[0] as f64).hypot(frame.size_px[1] as f64)).max(3.0);
    let mut by_weight: Vec<usize> = (0..all.len()).collect();
    by_weight.sort_by(|&a, &b| all[b].weight.total_cmp(&all[a].weight));
    let mut maps = vec![(similarity(all, &mode.agreeing, within_px), false)];
    let mut different: Vec<u32> = mode.agreeing.iter().map(|&i| all[i].query).collect();
    different.sort_unstable();
    different.dedup();
    if different.len() >= LEAST_POINTS {
        let pairs: Vec<_> = mode.agreeing.iter().map(|&i| all[i].pair()).collect();
        let plane = Homography::agreed(&pairs, within_px, o.rounds).map(|(plane, _)| plane);
        let sane = plane.filter(|plane| plane.is_sane(exemplar.width_px as f64, exemplar.height_px as f64));
        maps.extend(sane.map(|plane| (plane, true)));
    }
    let judged = maps.into_iter().map(|(map, is_plane)| {
        let (determined_by, within_px) =
            if is_plane { (LEAST_POINTS, within_px) } else { (2, 2.0 * within_px) };
        (map, background.group(all, &by_weight, &map, determined_by, WIDER * within_px, MAPS))
    });
    let evidence = |group: &Option<Group>| group.as_ref().map_or(f64::MIN, |group| group.evidence);
    let (map, group) = judged.max_by(|a, b| evidence(&a.1).total_cmp(&evidence(&b.1)))?;
    let group = group.unwrap_or(Group {
        evidence: LEAST_EVIDENCE,
        witnesses: mode.agreeing.clone(),
        asked: all.len(),
    });
    let support = support(exemplar, all, &map);
    Some(Hypothesis {
        exemplar: 0,
        map,
        evidence: group.evidence,
        density: mode.density,
        witnesses: group.witnesses,
        asked: group.asked,
        support,
        votes: 0.0,
    })
}

/// The votes of the windows that roughly agree with a map, of each window the largest.
fn support(exemplar: &Exemplar, all: &[Match], map: &Homography) -> f64 {
    let diagonal = (exemplar.width_px as f64).hypot(exemplar.height_px as f64);
    let within_px = SUPPORT_PLACE * diagonal * map.local_similarity([0.0, 0.0]).scale;
    let agrees =
        |found: &&Match| Residual::of(found, map, within_px).within(within_px as f32, SUPPORT_SIMILAR);
    largest_votes(all.iter().filter(agrees)).iter().map(|(_, vote)| f64::from(*vote)).sum()
}

/// The similarity that agreeing matches determine: least squares of their points, if that is near what they predict alone;
/// else the mean of what they predict.
fn similarity(all: &[Match], agreeing: &[usize], within_px: f64) -> Homography {
    let total: f64 = agreeing.iter().map(|&i| f64::from(all[i].weight)).sum();
    let mean = |value: fn(&Match) -> f32| {
        agreeing.iter().map(|&i| f64::from(all[i].weight * value(&all[i]))).sum::<f64>() / total
    };
    let turn_rad = mean(|m| m.turn_rad.sin()).atan2(mean(|m| m.turn_rad.cos()));
    let scale = mean(|m| m.scale.ln()).exp();
    let centre = [mean(|m| m.centre()[0]), mean(|m| m.centre()[1])];
    let mut map = Homography::similarity(centre, turn_rad, scale);
    for widths in [4.0, 2.0, 2.0] {
        let near = |found: &&Match| {
            let (from, to) = found.pair();
            let at = map.apply(from);
            (at[0] - to[0]).hypot(at[1] - to[1]) < widths * within_px
        };
        let near: Vec<&Match> = agreeing.iter().map(|&i| &all[i]).filter(near).collect();
        let pairs: Vec<_> = near.iter().map(|found| found.pair()).collect();
        let weights: Vec<f64> = near.iter().map(|found| f64::from(found.weight)).collect();
        let Some(fit) = Homography::fitted_similarity(&pairs, &weights).filter(|_| near.len() >= 3) else {
            break;
        };
        let local = fit.local_similarity([0.0, 0.0]);
        if turn_between(local.turn_rad as f32, turn_rad as f32) > 0.5
            || (local.scale / scale).ln().abs() > 0.4
        {
            break;
        }
        map = fit;
    }
    map
}

/// Of each window the largest vote, by window.
pub(super) fn largest_votes<'a>(matches: impl Iterator<Item = &'a Match>) -> Vec<(u32, f32)> {
    let mut votes: Vec<(u32, f32)> = matches.map(|found| (found.query, found.vote)).collect();
    votes.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    votes.dedup_by_key(|(query, _)| *query);
    votes
}

#[cfg(test)]
mod tests {
    use super::super::planted::{accidents, planted, votes_of};
    use super::*;

    const THINGS: usize = 10;

    /// The hypotheses of a frame of 640 by 480 px, against ten exemplars of 200 by 150 px.
    fn judged(mut matches: Vec<Match>) -> Vec<Hypothesis> {
        matches.sort_by_key(|m| m.exemplar);
        let frame = Frame { size_px: [640, 480], matches: &matches };
        let exemplars = [Exemplar { width_px: 200, height_px: 150 }; THINGS];
        hypotheses(&exemplars, &frame, &votes_of(THINGS, &matches), &HypothesisOptions::default())
    }

    fn off(a: &Homography, b: &Homography) -> f64 {
        let corners = [[-90.0, -60.0], [90.0, -60.0], [90.0, 60.0], [-90.0, 60.0]];
        let off = corners.map(|corner| {
            let (p, q) = (a.apply(corner), b.apply(corner));
            (p[0] - q[0]).hypot(p[1] - q[1])
        });
        off.into_iter().fold(0.0, f64::max)
    }

    #[test]
    fn a_planted_similarity_and_a_planted_plane_are_recovered() {
        let similarity = Homography::similarity([300.0, 220.0], 0.6, 1.3);
        let plane = Homography([[1.0, 0.1, 320.0], [-0.1, 0.9, 240.0], [0.0008, 0.0, 1.0]]);
        for map in [similarity, plane] {
            let mut matches = accidents(THINGS, 600, 1);
            matches.extend(planted(3, &map, 40, 10_000, 2));
            let found = judged(matches);
            assert_eq!(found[0].exemplar, 3);
            assert!(found[0].evidence > 10.0, "{}", found[0].evidence);
            assert!(off(&found[0].map, &map) < 6.0, "{}", off(&found[0].map, &map));
            assert!(found[0].is_evident(2.0));
        }
    }

    #[test]
    fn nothing_is_evident_in_noise() {
        for seed in 0..20 {
            let found = judged(accidents(THINGS, 800, 100 + seed));
            assert!(!found.iter().any(|h| h.is_evident(2.0)), "{seed}");
        }
        assert!(judged(Vec::new()).is_empty());
    }
}
