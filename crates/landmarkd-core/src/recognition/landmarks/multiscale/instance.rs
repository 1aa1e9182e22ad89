//! Instances: all things in a frame, also several of one exemplar, each once.

use super::decision::likeliest_first;
use super::hypothesis::{Exemplar, Frame, Hypothesis, HypothesisOptions, hypotheses, largest_votes};
use super::matching::Match;
use crate::recognition::landmarks::homography::Homography;

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
        let mut found = hypotheses(exemplars, &Frame { matches: &matches, ..*frame }, votes, o);
        found.retain(|h| h.is_evident(o.least_evidence));
        // votes that the exemplar has elsewhere, where another instance may be, tell nothing of this place
        for h in &mut found {
            h.votes = votes_within(&Outline::of(&exemplars[h.exemplar], &h.map), h.exemplar, &matches);
        }
        likeliest_first(&mut found, o.viewpoint);
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

#[cfg(test)]
mod tests {
    use super::super::planted::{accidents, planted, votes_of};
    use super::*;

    const THINGS: usize = 10;

    /// The instances in a frame of 640 by 480 px, of ten exemplars of 200 by 150 px.
    fn found(mut matches: Vec<Match>) -> Vec<Hypothesis> {
        matches.sort_by_key(|m| m.exemplar);
        let frame = Frame { size_px: [640, 480], matches: &matches };
        let exemplars = [Exemplar { width_px: 200, height_px: 150 }; THINGS];
        instances(&exemplars, &frame, &votes_of(THINGS, &matches), &HypothesisOptions::default(), 8)
    }

    #[test]
    fn two_of_one_exemplar_are_both_found() {
        let centres = [[160.0, 240.0], [480.0, 240.0]];
        let maps = centres.map(|centre| Homography::similarity(centre, 0.0, 1.0));
        let mut matches = accidents(THINGS, 400, 3);
        matches.extend(planted(5, &maps[0], 30, 10_000, 4));
        matches.extend(planted(5, &maps[1], 30, 20_000, 5));
        let found = found(matches);
        assert_eq!(found.iter().map(|h| h.exemplar).collect::<Vec<_>>(), [5, 5]);
        for [x, y] in centres {
            let there = |h: &Hypothesis| {
                let [u, v] = h.map.apply([0.0, 0.0]);
                (u - x).hypot(v - y) < 6.0
            };
            assert!(found.iter().any(there), "{x}");
        }
    }

    #[test]
    fn nothing_is_found_in_noise() {
        for seed in 0..20 {
            assert!(found(accidents(THINGS, 800, 100 + seed)).is_empty(), "{seed}");
        }
    }
}
