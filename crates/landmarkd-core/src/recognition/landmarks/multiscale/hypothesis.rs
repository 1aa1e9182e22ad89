//! Hypotheses: where exemplars lie in a frame, each with its evidence that this is no accident.

use super::a_contrario::{Background, Group, Residual};
use super::consensus::{self, Mode, turn_between};
use super::matching::Match;
use crate::recognition::landmarks::homography::{Homography, LEAST_POINTS};

/// What is known of an exemplar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exemplar {
    pub width_px: usize,
    pub height_px: usize,
}

/// What is known of a frame.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub width_px: usize,
    pub height_px: usize,
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
    /// Those are compared by their support and votes whose evidence is positive and at least this part of the best one's.
    pub least_part: f64,
    /// Evidence from which on it is no accident.
    pub least_evidence: f64,
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
            least_part: 0.05,
            least_evidence: 2.0,
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
/// The likeliest label is not decided where another has evidence so many times as large, or its votes are less than this
/// part of the votes of another that is about as evident: then evidence and votes contradict each other.
const CONTRADICTING_EVIDENCE: f64 = 4.0;
const LEAST_VOTES: f64 = 0.85;

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
    /// How much the frame resembles the exemplar, there and on the whole.
    fn likeliness(&self) -> f64 {
        self.support * self.votes
    }
}

/// The hypotheses of a frame, of each exemplar the best; the likeliest first. `votes`: of the exemplars.
///
/// Evidence tells whether a thing is there; support and votes tell which of several that are there (places that overlap,
/// varieties) the frame resembles most.
pub(super) fn hypotheses(
    exemplars: &[Exemplar],
    frame: &Frame,
    votes: &[f64],
    o: &HypothesisOptions,
) -> Vec<Hypothesis> {
    let mut found = by_windows(exemplars, frame, votes, o);
    likeliest_first(&mut found, o);
    found
}

/// Those that are there by their support and votes, then the others by their evidence. Where nothing is above accident,
/// evidence tells nothing, and all are compared.
fn likeliest_first(found: &mut [Hypothesis], o: &HypothesisOptions) {
    let top = found.iter().fold(f64::MIN, |most, h| most.max(h.evidence));
    let least = if top >= 0.0 { o.least_part * top } else { f64::MIN };
    let key =
        |h: &Hypothesis| (h.evidence >= least, if h.evidence >= least { h.likeliness() } else { h.evidence });
    found.sort_by(|a, b| key(b).0.cmp(&key(a).0).then(key(b).1.total_cmp(&key(a).1)));
}

/// The decision that hypotheses (likeliest first) allow, if any: the first, where it is no accident and nothing contradicts.
/// `labels`: of the exemplars.
pub(super) fn decided<'a>(
    found: &'a [Hypothesis],
    labels: &[usize],
    o: &HypothesisOptions,
) -> Option<&'a Hypothesis> {
    let first = found.first().filter(|h| h.evidence >= o.least_evidence)?;
    let label = |h: &Hypothesis| labels.get(h.exemplar);
    let mine = |h: &&Hypothesis| label(h) == label(first);
    // another exemplar of the label speaks for it too
    let evidence = found.iter().filter(mine).fold(0.0_f64, |most, h| most.max(h.evidence));
    let votes = found.iter().filter(mine).fold(0.0_f64, |most, h| most.max(h.votes));
    let contradicts = |h: &Hypothesis| {
        let there = h.evidence >= o.least_evidence.max(evidence / CONTRADICTING_EVIDENCE);
        h.evidence > CONTRADICTING_EVIDENCE * evidence || there && votes < LEAST_VOTES * h.votes
    };
    let contradicted = found.iter().any(|h| !mine(&h) && contradicts(h));
    (!contradicted).then_some(first)
}

/// What is there, likeliest first; what the windows about the witnesses of one placement show no other placement shows again.
/// An exemplar may be there several times, at places apart.
pub(super) fn instances(
    exemplars: &[Exemplar],
    frame: &Frame,
    votes: &[f64],
    o: &HypothesisOptions,
    most: usize,
) -> Vec<Hypothesis> {
    let mut out: Vec<Hypothesis> = Vec::new();
    let mut outlines: Vec<Outline> = Vec::new();
    // where the matches that are left stand among the frame's
    let mut left: Vec<usize> = (0..frame.matches.len()).collect();
    while out.len() < most {
        let matches: Vec<Match> = left.iter().map(|&i| frame.matches[i]).collect();
        let mut found = by_windows(exemplars, &Frame { matches: &matches, ..*frame }, votes, o);
        found.retain(|h| h.evidence >= o.least_evidence);
        // votes that the exemplar has elsewhere, where another instance may be, tell nothing of this place
        for h in &mut found {
            h.votes = votes_within(&Outline::of(&exemplars[h.exemplar], &h.map), h.exemplar, &matches);
        }
        likeliest_first(&mut found, o);
        let outline = |h: &Hypothesis| Outline::of(&exemplars[h.exemplar], &h.map);
        let Some(at) = found.iter().position(|h| !outlines.iter().any(|other| other.hides(&outline(h))))
        else {
            break;
        };
        let mut best = found.swap_remove(at);
        let taken: Vec<Match> = best.witnesses.iter().map(|&i| matches[i]).collect();
        let there = outline(&best);
        best.witnesses.iter_mut().for_each(|i| *i = left[*i]);
        left.retain(|&i| {
            let found = &frame.matches[i];
            let [x, y] = found.to;
            let shown = taken.iter().any(|other| {
                let ([u, v], r) = (other.to, found.radius_px.max(other.radius_px));
                (x - u).powi(2) + (y - v).powi(2) <= (TAKEN * r).powi(2)
            });
            !shown && !there.hides(&Outline::predicted(&exemplars[found.exemplar as usize], found))
        });
        outlines.push(there);
        out.push(best);
    }
    out
}

/// The votes of an exemplar by windows within an outline, of each window the largest. The matches are sorted by exemplar.
fn votes_within(outline: &Outline, exemplar: usize, matches: &[Match]) -> f64 {
    let first = matches.partition_point(|m| (m.exemplar as usize) < exemplar);
    let count = matches[first..].partition_point(|m| m.exemplar as usize == exemplar);
    let inside = |m: &&Match| {
        (0..2).all(|axis| (outline.least[axis]..outline.most[axis]).contains(&f64::from(m.to[axis])))
    };
    largest_votes(matches[first..first + count].iter().filter(inside))
        .iter()
        .map(|(_, vote)| f64::from(*vote))
        .sum()
}

/// Of each window the largest vote, by window.
fn largest_votes<'a>(matches: impl Iterator<Item = &'a Match>) -> Vec<(u32, f32)> {
    let mut votes: Vec<(u32, f32)> = matches.map(|found| (found.query, found.vote)).collect();
    votes.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    votes.dedup_by_key(|(query, _)| *query);
    votes
}

/// Windows nearer than this part of their radius to a witness show what it shows.
const TAKEN: f32 = 1.0;

/// Things are opaque: one hides another of about its size where they overlap by this part of the smaller one.
const HIDDEN: f64 = 0.4;
/// A thing may stand before another that is so many times as large.
const MUCH_LARGER: f64 = 4.0;

/// The box about a placed exemplar.
struct Outline {
    least: [f64; 2],
    most: [f64; 2],
}

impl Outline {
    fn of(exemplar: &Exemplar, map: &Homography) -> Outline {
        let (x, y) = (exemplar.width_px as f64 / 2.0, exemplar.height_px as f64 / 2.0);
        let corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(|corner| map.apply(corner));
        let along = |axis: usize, pick: fn(f64, f64) -> f64| {
            corners[1..].iter().fold(corners[0][axis], |a, c| pick(a, c[axis]))
        };
        Outline {
            least: [along(0, f64::min), along(1, f64::min)],
            most: [along(0, f64::max), along(1, f64::max)],
        }
    }

    /// Where one match alone places its exemplar.
    fn predicted(exemplar: &Exemplar, found: &Match) -> Outline {
        let centre = found.centre().map(f64::from);
        Outline::of(
            exemplar,
            &Homography::similarity(centre, f64::from(found.turn_rad), f64::from(found.scale)),
        )
    }

    fn hides(&self, other: &Outline) -> bool {
        let area = |o: &Outline| (o.most[0] - o.least[0]) * (o.most[1] - o.least[1]);
        let side = |axis: usize| {
            (self.most[axis].min(other.most[axis]) - self.least[axis].max(other.least[axis])).max(0.0)
        };
        let (small, large) = (area(self).min(area(other)), area(self).max(area(other)));
        side(0) * side(1) > HIDDEN * small && large < MUCH_LARGER * small
    }
}

/// The hypotheses by the evidence of their windows, most evident first; of each exemplar the best.
fn by_windows(
    exemplars: &[Exemplar],
    frame: &Frame,
    votes: &[f64],
    o: &HypothesisOptions,
) -> Vec<Hypothesis> {
    let background = Background::of(frame.matches, frame.width_px, frame.height_px, exemplars.len());
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
    let within_px = (o.tolerance * (frame.width_px as f64).hypot(frame.height_px as f64)).max(3.0);
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
    let group = group.unwrap_or(Group { evidence: LEAST_EVIDENCE, witnesses: Vec::new(), asked: all.len() });
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

#[cfg(test)]
mod tests {
    use super::super::planted::{accidents, planted};
    use super::*;

    const THINGS: usize = 10;

    /// The hypotheses or instances of a frame of 640 by 480 px, against ten exemplars of 200 by 150 px.
    fn judged(mut matches: Vec<Match>, several: bool) -> Vec<Hypothesis> {
        matches.sort_by_key(|m| m.exemplar);
        let frame = Frame { width_px: 640, height_px: 480, matches: &matches };
        let exemplars = [Exemplar { width_px: 200, height_px: 150 }; THINGS];
        let mut votes = vec![0.0; THINGS];
        matches.iter().for_each(|m| votes[m.exemplar as usize] += f64::from(m.vote));
        let o = HypothesisOptions::default();
        if several {
            instances(&exemplars, &frame, &votes, &o, 8)
        } else {
            hypotheses(&exemplars, &frame, &votes, &o)
        }
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
            let found = judged(matches, false);
            assert_eq!(found[0].exemplar, 3);
            assert!(found[0].evidence > 10.0, "{}", found[0].evidence);
            assert!(off(&found[0].map, &map) < 6.0, "{}", off(&found[0].map, &map));
            let labels: Vec<usize> = (0..THINGS).collect();
            assert!(decided(&found, &labels, &HypothesisOptions::default()).is_some_and(|h| h.exemplar == 3));
        }
    }

    #[test]
    fn two_instances_of_one_exemplar_are_both_found() {
        let maps = [[160.0, 240.0], [480.0, 240.0]].map(|centre| Homography::similarity(centre, 0.0, 1.0));
        let mut matches = accidents(THINGS, 400, 3);
        matches.extend(planted(5, &maps[0], 30, 10_000, 4));
        matches.extend(planted(5, &maps[1], 30, 20_000, 5));
        let found = judged(matches, true);
        assert_eq!(found.iter().map(|h| h.exemplar).collect::<Vec<_>>(), [5, 5]);
        assert!(maps.iter().all(|map| found.iter().any(|h| off(&h.map, map) < 6.0)));
    }

    #[test]
    fn nothing_is_found_in_noise() {
        for seed in 0..20 {
            let o = HypothesisOptions::default();
            let labels: Vec<usize> = (0..THINGS).collect();
            assert!(
                decided(&judged(accidents(THINGS, 800, 100 + seed), false), &labels, &o).is_none(),
                "{seed}"
            );
            assert!(judged(accidents(THINGS, 800, 100 + seed), true).is_empty(), "{seed}");
        }
        assert!(judged(Vec::new(), false).is_empty());
    }
}
