//! The vote (A§4.5): a point whose nearest eigenpoint lies at distance D gives 1/(D + ε) to that
//! eigenpoint's exemplar; W of an exemplar is the sum, and a label has the W of its best or of all.
//!
//! Equal W: of exemplars the earlier (label, then id) is the better, of labels the one that sorts first.

use super::model::Exemplar;
use super::options::{LandmarkOptions, PerLabel};
use super::recognition::{LabelVote, PointVote};
use crate::eigen::Neighbour;
use crate::vision::InterestPoint;

/// The votes of the points of a frame.
pub(super) struct Tally {
    /// In the order of the windows.
    pub points: Vec<PointVote>,
    /// W of every exemplar.
    pub exemplar_weights: Vec<f64>,
}

/// Counts the votes of points with their nearest eigenpoint. Votes for an exemplar that doesn't count for its label
/// have weight 0 in `points`, but count in `exemplar_weights`.
pub(super) fn tally<'a>(
    nearest: impl Iterator<Item = (InterestPoint, &'a Neighbour)>,
    exemplar_of: impl Fn(usize) -> usize,
    exemplars: &[Exemplar],
    options: &LandmarkOptions,
) -> Tally {
    let vote = |(point, neighbour): (InterestPoint, &Neighbour)| {
        let weight = 1.0 / (f64::from(neighbour.distance) + options.epsilon); // A§4.5
        PointVote::new(point, exemplar_of(neighbour.index), neighbour.distance, weight)
    };
    let mut points: Vec<PointVote> = nearest.map(vote).collect();
    let mut exemplar_weights = vec![0.0; exemplars.len()];
    points.iter().for_each(|p| exemplar_weights[p.exemplar] += p.weight);
    if options.per_label == PerLabel::Best {
        let best = best_of_labels(&exemplar_weights, exemplars);
        points.iter_mut().filter(|p| !best[p.exemplar]).for_each(|p| p.weight = 0.0);
    }
    Tally { points, exemplar_weights }
}

/// Of each exemplar whether it is the best of its label.
fn best_of_labels(weights: &[f64], exemplars: &[Exemplar]) -> Vec<bool> {
    let mut is_best = vec![false; exemplars.len()];
    let mut first = 0;
    for label in exemplars.chunk_by(|a, b| a.label == b.label) {
        let mut best = first;
        for (exemplar, weight) in weights.iter().enumerate().skip(first).take(label.len()) {
            if *weight > weights[best] {
                best = exemplar;
            }
        }
        is_best[best] = true;
        first += label.len();
    }
    is_best
}

/// The labels with W > 0, which is the sum of their points' weights, best first.
pub(super) fn label_votes(points: &[PointVote], exemplars: &[Exemplar]) -> Vec<LabelVote> {
    let label_of = label_numbers(exemplars);
    let mut totals = vec![(0.0, 0); label_of.last().map_or(0, |last| last + 1)];
    for point in points {
        let (weight, count) = &mut totals[label_of[point.exemplar]];
        *weight += point.weight;
        *count += usize::from(point.weight > 0.0);
    }
    let all: f64 = totals.iter().map(|(weight, _)| weight).sum();
    let labels = exemplars.chunk_by(|a, b| a.label == b.label).map(|run| &run[0].label);
    let mut votes: Vec<LabelVote> = labels
        .zip(totals)
        .filter(|(_, (weight, _))| *weight > 0.0)
        .map(|(label, (weight, points))| LabelVote {
            label: label.clone(),
            weight,
            share: weight / all,
            points,
            placement: None,
            a_contrario: None,
        })
        .collect();
    votes.sort_by(|a, b| b.weight.total_cmp(&a.weight)); // stable: equal ones stay in the order of labels
    votes
}

/// The number of each exemplar's label: equal labels stand together, as the exemplars are sorted by them.
pub(super) fn label_numbers(exemplars: &[Exemplar]) -> Vec<usize> {
    let runs = exemplars.chunk_by(|a, b| a.label == b.label);
    runs.enumerate().flat_map(|(run, members)| members.iter().map(move |_| run)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::pictures::paper;
    use super::*;

    fn exemplars(labels: &[&str]) -> Vec<Exemplar> {
        let exemplar = |(i, label): (usize, &&str)| Exemplar {
            id: format!("{i:03}"),
            label: (*label).to_owned(),
            width_px: 1,
            height_px: 1,
            windows: 1,
            edges: Vec::new(),
        };
        labels.iter().enumerate().map(exemplar).collect()
    }

    /// The vote of points that have these exemplars and distances.
    fn counted(
        labels: &[&str],
        matches: &[(usize, f32)],
        per_label: PerLabel,
    ) -> (Vec<LabelVote>, Vec<PointVote>, Vec<f64>) {
        let options = LandmarkOptions { per_label, epsilon: 0.5, ..paper() };
        let exemplars = exemplars(labels);
        let point = InterestPoint { x_px: 0.0, y_px: 0.0, salience: 1.0 };
        let nearest: Vec<Neighbour> =
            matches.iter().map(|&(index, distance)| Neighbour { index, distance }).collect();
        let nearest = nearest.iter().map(|neighbour| (point, neighbour));
        let Tally { points, exemplar_weights } = tally(nearest, |index| index, &exemplars, &options);
        (label_votes(&points, &exemplars), points, exemplar_weights)
    }

    fn counts(votes: &[LabelVote]) -> Vec<(&str, f64, usize)> {
        votes.iter().map(|v| (v.label.as_str(), v.weight, v.points)).collect()
    }

    #[test]
    fn a_point_gives_one_over_distance_plus_epsilon() {
        // 1/(0.5 + 0.5) = 1, 1/(1.5 + 0.5) = 0.5, 1/(3.5 + 0.5) = 0.25
        let matches = [(0, 0.5), (1, 1.5), (1, 3.5), (2, 3.5)];
        let (votes, points, weights) = counted(&["a", "b", "b"], &matches, PerLabel::Sum);
        assert_eq!(weights, [1.0, 0.75, 0.25]);
        assert_eq!(counts(&votes), [("a", 1.0, 1), ("b", 1.0, 3)]);
        assert_eq!(votes[0].share, 0.5);
        assert_eq!(points.iter().map(|p| p.weight).collect::<Vec<_>>(), [1.0, 0.5, 0.25, 0.25]);
        let (votes, points, weights) = counted(&["a", "b", "b"], &matches, PerLabel::Best);
        assert_eq!(weights, [1.0, 0.75, 0.25]);
        assert_eq!(counts(&votes), [("a", 1.0, 1), ("b", 0.75, 2)]);
        assert_eq!(points[3].weight, 0.0);
    }

    #[test]
    fn of_equal_exemplars_the_earlier_counts() {
        let (votes, points, _) = counted(&["a", "a"], &[(1, 0.5), (0, 0.5)], PerLabel::Best);
        assert_eq!(counts(&votes), [("a", 1.0, 1)]);
        assert_eq!((points[0].weight, points[1].weight), (0.0, 1.0));
    }

    #[test]
    fn nobody_votes_for_nothing() {
        assert_eq!(counted(&["a"], &[], PerLabel::Best), (vec![], vec![], vec![0.0]));
        let (votes, ..) = counted(&["a", "b"], &[(1, f32::INFINITY), (0, 1.0)], PerLabel::Sum);
        assert_eq!(votes.len(), 1);
    }

    proptest! {
        #[test]
        fn the_weights_of_points_sum_to_w_exactly(
            matches in prop::collection::vec((0usize..12, 0.0f32..3.0), 0..100),
            sum in any::<bool>(),
        ) {
            let labels = ["a", "a", "a", "b", "c", "c", "d", "d", "d", "d", "e", "f"];
            let per_label = if sum { PerLabel::Sum } else { PerLabel::Best };
            let (votes, points, weights) = counted(&labels, &matches, per_label);
            for vote in &votes {
                let of_label = points.iter().filter(|p| labels[p.exemplar] == vote.label);
                prop_assert_eq!(of_label.clone().map(|p| p.weight).sum::<f64>(), vote.weight);
                prop_assert_eq!(of_label.filter(|p| p.weight > 0.0).count(), vote.points);
            }
            for vote in votes.iter().filter(|_| !sum) {
                let of_label = labels.iter().zip(&weights).filter(|(label, _)| **label == vote.label);
                prop_assert_eq!(of_label.map(|(_, w)| *w).fold(0.0, f64::max), vote.weight);
            }
            prop_assert!(votes.is_sorted_by(|a, b| a.weight >= b.weight));
            let shares: f64 = votes.iter().map(|v| v.share).sum();
            prop_assert!(votes.is_empty() || (shares - 1.0).abs() < 1e-12);
            let voted = |label| points.iter().any(|p| labels[p.exemplar] == label && p.weight > 0.0);
            prop_assert_eq!(votes.len(), ["a", "b", "c", "d", "e", "f"].into_iter().filter(|l| voted(*l)).count());
        }
    }
}
