//! Which hypothesis is likeliest, and whether it may be decided.
//!
//! Evidence tells *that* something known is there. Which of several that are there (varieties of one brand, places that
//! overlap) the frame resembles most is told by votes, the more so by those that agree with the placement.

use super::hypothesis::{Hypothesis, HypothesisOptions};
use super::overlap::Overlap;
use crate::recognition::landmarks::options::Viewpoint;

/// Things are compared by their votes whose evidence is positive and at least this part of the best one's.
const COMPARED_EVIDENCE: f64 = 0.05;
/// Of a place all votes count, those that agree with its placement a little more: what is not flat agrees with no one plane.
const PLACE_SUPPORT: f64 = 0.25;
/// Places overlap from here on: evidence for one is evidence that it is one of them.
const OVERLAPPING: f64 = 0.4;
/// The likeliest label is not decided where another has evidence so many times as large, or its votes are less than this
/// part of the votes of another that is about as evident: then evidence and votes contradict each other.
const CONTRADICTING_EVIDENCE: f64 = 4.0;
const LEAST_VOTES: f64 = 0.85;

/// Sorts hypotheses, the likeliest first. Things that are not evident come after those that are; where nothing is above
/// accident, evidence tells nothing, and all are compared.
pub(super) fn likeliest_first(found: &mut [Hypothesis], viewpoint: Viewpoint) {
    let top = found.iter().fold(f64::MIN, |most, h| most.max(h.evidence));
    let (least, power) = match viewpoint {
        Viewpoint::Upright => (f64::MIN, PLACE_SUPPORT),
        Viewpoint::Free if top >= 0.0 => (COMPARED_EVIDENCE * top, 1.0),
        Viewpoint::Free => (f64::MIN, 1.0),
    };
    let key = |h: &Hypothesis| {
        let compared = h.evidence >= least;
        (compared, if compared { h.support.powf(power) * h.votes } else { h.evidence })
    };
    found.sort_by(|a, b| key(b).0.cmp(&key(a).0).then(key(b).1.total_cmp(&key(a).1)));
}

/// The hypothesis whose evidence allows to decide for the likeliest of hypotheses (sorted so): its own or, of places, that
/// of one that overlaps it. `None` where all is accident, or something contradicts. `labels`: of the exemplars.
pub(super) fn decided<'a>(
    found: &'a [Hypothesis],
    labels: &[usize],
    overlap: &Overlap,
    o: &HypothesisOptions,
) -> Option<&'a Hypothesis> {
    let first = found.first()?;
    let mine = |h: &&Hypothesis| labels[h.exemplar] == labels[first.exemplar];
    let speaks = |h: &&Hypothesis| mine(h) || overlap.between(first.exemplar, h.exemplar) >= OVERLAPPING;
    let evident = found.iter().filter(speaks).filter(|h| h.is_evident(o.least_evidence));
    let witness = evident.max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    let votes = found.iter().filter(mine).fold(0.0_f64, |most, h| most.max(h.votes));
    let contradicts = |h: &Hypothesis| {
        let there = h.evidence >= o.least_evidence.max(witness.evidence / CONTRADICTING_EVIDENCE);
        h.evidence > CONTRADICTING_EVIDENCE * witness.evidence || there && votes < LEAST_VOTES * h.votes
    };
    let contradicted = found.iter().any(|h| !mine(&h) && contradicts(h));
    (!contradicted).then_some(witness)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recognition::landmarks::homography::Homography;

    fn hypothesis(exemplar: usize, evidence: f64, support: f64, votes: f64) -> Hypothesis {
        Hypothesis {
            exemplar,
            map: Homography::similarity([0.0, 0.0], 0.0, 1.0),
            evidence,
            density: 1.0,
            witnesses: (0..8).collect(),
            asked: 50,
            support,
            votes,
        }
    }

    fn decide(mut found: Vec<Hypothesis>, overlap: &Overlap, viewpoint: Viewpoint) -> Option<(usize, usize)> {
        likeliest_first(&mut found, viewpoint);
        let o = HypothesisOptions { viewpoint, ..HypothesisOptions::default() };
        decided(&found, &[0, 1, 2], overlap, &o).map(|witness| (found[0].exemplar, witness.exemplar))
    }

    #[test]
    fn of_things_evidence_comes_first_and_votes_tell_varieties() {
        let apart = Overlap::none();
        let far = vec![hypothesis(0, 30.0, 4.0, 10.0), hypothesis(1, 0.5, 9.0, 12.0)];
        assert_eq!(decide(far, &apart, Viewpoint::Free), Some((0, 0)));
        let varieties = vec![hypothesis(0, 30.0, 4.0, 10.0), hypothesis(1, 20.0, 9.0, 12.0)];
        assert_eq!(decide(varieties, &apart, Viewpoint::Free), Some((1, 1)));
        let contradicting = vec![hypothesis(0, 90.0, 4.0, 10.0), hypothesis(1, 20.0, 9.0, 12.0)];
        assert_eq!(decide(contradicting, &apart, Viewpoint::Free), None);
        assert_eq!(decide(Vec::new(), &apart, Viewpoint::Free), None);
    }

    #[test]
    fn evidence_for_a_place_that_overlaps_is_evidence_for_the_likeliest() {
        let places = || vec![hypothesis(0, -3.0, 5.0, 20.0), hypothesis(1, 15.0, 5.0, 18.0)];
        let windows = |votes: [f32; 2]| (0..40).map(move |query| (query, votes));
        let same = Overlap::of(&[0, 1], windows([1.0, 0.8]).flat_map(|(q, [a, b])| [(q, 0, a), (q, 1, b)]));
        assert_eq!(decide(places(), &same, Viewpoint::Upright), Some((0, 1)));
        assert_eq!(decide(places(), &Overlap::none(), Viewpoint::Upright), None);
    }

    #[test]
    fn few_witnesses_are_asked_for_more() {
        let few = |evidence| Hypothesis { witnesses: vec![0, 1, 2, 3], ..hypothesis(0, evidence, 1.0, 1.0) };
        let decide = |evidence| decide(vec![few(evidence)], &Overlap::none(), Viewpoint::Free);
        assert_eq!((decide(3.0), decide(5.0)), (None, Some((0, 0))));
    }
}
