//! The vote (A§4.5): a point whose nearest eigenpoint lies at distance D gives 1/(D + ε) to that
//! eigenpoint's exemplar; W of an exemplar is the sum, and a label has the W of its best or of all.
//!
//! Equal W: of exemplars the earlier (label, then id) is the better, of labels the one that sorts first.

use super::model::Exemplar;
use super::options::{LandmarkOptions, PerLabel};
use super::warning::Warning;
use crate::vision::InterestPoint;

/// What a frame was taken for, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognition {
    /// Interest points in the frame.
    pub points_found: usize,
    /// The strongest of them, that voted; those with nothing to see about them are passed over.
    pub points_used: usize,
    /// Labels with W > 0, best first.
    pub votes: Vec<LabelVote>,
    /// What each point said, strongest point first.
    pub points: Vec<PointVote>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// The vote for one label.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelVote {
    /// What was voted for.
    pub label: String,
    /// W: the weights of its points, added up in their order, exactly.
    pub weight: f64,
    /// Its part of the W of all labels, 0..=1.
    pub share: f64,
    /// How many points voted for it with a weight above 0.
    pub points: usize,
}

/// The vote of one interest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointVote {
    /// Where it is.
    pub x_px: f32,
    /// Where it is.
    pub y_px: f32,
    /// How strongly it drew attention.
    pub salience: f32,
    /// Whose eigenpoint is nearest: index into the model's exemplars.
    pub exemplar: usize,
    /// D.
    pub distance: f64,
    /// 1/(D + ε); 0 where only the best exemplar of a label counts and this is another.
    pub weight: f64,
}

/// Count the votes of (point, exemplar, distance) in their order.
pub(super) fn vote(
    matches: impl Iterator<Item = (InterestPoint, usize, f64)>,
    exemplars: &[Exemplar],
    options: &LandmarkOptions,
) -> (Vec<LabelVote>, Vec<PointVote>) {
    let mut points: Vec<PointVote> = matches
        .map(|(InterestPoint { x_px, y_px, salience }, exemplar, distance)| PointVote {
            x_px,
            y_px,
            salience,
            exemplar,
            distance,
            weight: 1.0 / (distance + options.epsilon), // A§4.5
        })
        .collect();

    // the labels stand in runs, as the exemplars are sorted by them
    let runs: Vec<&[Exemplar]> = exemplars.chunk_by(|a, b| a.label == b.label).collect();
    let run_of: Vec<usize> =
        runs.iter().enumerate().flat_map(|(run, members)| members.iter().map(move |_| run)).collect();

    if options.per_label == PerLabel::Best {
        let mut weights = vec![0.0; exemplars.len()];
        points.iter().for_each(|p| weights[p.exemplar] += p.weight);
        let mut best: Vec<Option<usize>> = vec![None; runs.len()];
        for (exemplar, &weight) in weights.iter().enumerate() {
            let best = &mut best[run_of[exemplar]];
            if best.is_none_or(|b| weight > weights[b]) {
                *best = Some(exemplar);
            }
        }
        for point in &mut points {
            if best[run_of[point.exemplar]] != Some(point.exemplar) {
                point.weight = 0.0;
            }
        }
    }

    let mut totals = vec![(0.0, 0); runs.len()];
    for point in &points {
        let (weight, count) = &mut totals[run_of[point.exemplar]];
        *weight += point.weight;
        *count += usize::from(point.weight > 0.0);
    }
    let all: f64 = totals.iter().map(|(weight, _)| weight).sum();
    let mut votes: Vec<LabelVote> = runs
        .iter()
        .zip(totals)
        .filter(|(_, (weight, _))| *weight > 0.0)
        .map(|(members, (weight, points))| LabelVote {
            label: members[0].label.clone(),
            weight,
            share: weight / all,
            points,
        })
        .collect();
    votes.sort_by(|a, b| b.weight.total_cmp(&a.weight)); // stable: equal ones stay in the order of labels
    (votes, points)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn exemplars(labels: &[&str]) -> Vec<Exemplar> {
        let exemplar = |(i, label): (usize, &&str)| Exemplar {
            id: format!("{i:03}"),
            label: (*label).to_owned(),
            width_px: 1,
            height_px: 1,
            points: 1,
        };
        labels.iter().enumerate().map(exemplar).collect()
    }

    fn counted(
        labels: &[&str],
        matches: &[(usize, f64)],
        per_label: PerLabel,
    ) -> (Vec<LabelVote>, Vec<PointVote>) {
        let options = LandmarkOptions { per_label, epsilon: 0.5, ..LandmarkOptions::default() };
        let point = InterestPoint { x_px: 0.0, y_px: 0.0, salience: 1.0 };
        vote(
            matches.iter().map(|&(exemplar, distance)| (point, exemplar, distance)),
            &exemplars(labels),
            &options,
        )
    }

    fn told(votes: &[LabelVote]) -> Vec<(&str, f64, usize)> {
        votes.iter().map(|v| (v.label.as_str(), v.weight, v.points)).collect()
    }

    #[test]
    fn a_point_gives_one_over_distance_plus_epsilon() {
        // 1/(0.5 + 0.5) = 1, 1/(1.5 + 0.5) = 0.5, 1/(3.5 + 0.5) = 0.25
        let matches = [(0, 0.5), (1, 1.5), (1, 3.5), (2, 3.5)];
        let (votes, points) = counted(&["a", "b", "b"], &matches, PerLabel::Sum);
        assert_eq!(told(&votes), [("a", 1.0, 1), ("b", 1.0, 3)]);
        assert_eq!(votes[0].share, 0.5);
        assert_eq!(points.iter().map(|p| p.weight).collect::<Vec<_>>(), [1.0, 0.5, 0.25, 0.25]);
        let (votes, points) = counted(&["a", "b", "b"], &matches, PerLabel::Best);
        assert_eq!(told(&votes), [("a", 1.0, 1), ("b", 0.75, 2)]);
        assert_eq!(points[3].weight, 0.0);
    }

    #[test]
    fn of_equal_exemplars_the_earlier_counts() {
        let (votes, points) = counted(&["a", "a"], &[(1, 0.5), (0, 0.5)], PerLabel::Best);
        assert_eq!(told(&votes), [("a", 1.0, 1)]);
        assert_eq!((points[0].weight, points[1].weight), (0.0, 1.0));
    }

    #[test]
    fn nobody_votes_for_nothing() {
        assert_eq!(counted(&["a"], &[], PerLabel::Best), (vec![], vec![]));
        let (votes, _) = counted(&["a", "b"], &[(1, f64::INFINITY), (0, 1.0)], PerLabel::Sum);
        assert_eq!(votes.len(), 1);
    }

    proptest! {
        #[test]
        fn the_weights_of_points_sum_to_w_exactly(
            matches in prop::collection::vec((0usize..12, 0.0f64..3.0), 0..100),
            sum in any::<bool>(),
        ) {
            let labels = ["a", "a", "a", "b", "c", "c", "d", "d", "d", "d", "e", "f"];
            let per_label = if sum { PerLabel::Sum } else { PerLabel::Best };
            let (votes, points) = counted(&labels, &matches, per_label);
            for vote in &votes {
                let of_label = points.iter().filter(|p| labels[p.exemplar] == vote.label);
                prop_assert_eq!(of_label.clone().map(|p| p.weight).sum::<f64>(), vote.weight);
                prop_assert_eq!(of_label.filter(|p| p.weight > 0.0).count(), vote.points);
            }
            prop_assert!(votes.is_sorted_by(|a, b| a.weight >= b.weight));
            let shares: f64 = votes.iter().map(|v| v.share).sum();
            prop_assert!(votes.is_empty() || (shares - 1.0).abs() < 1e-12);
            let voted = |label| points.iter().any(|p| labels[p.exemplar] == label && p.weight > 0.0);
            prop_assert_eq!(votes.len(), ["a", "b", "c", "d", "e", "f"].into_iter().filter(|l| voted(*l)).count());
        }
    }
}
