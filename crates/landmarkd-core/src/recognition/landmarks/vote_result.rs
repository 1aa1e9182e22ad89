//! The result of all windows of a frame: votes, the evidence for the best of them, and its strongest rival.

use super::confidence::{Evidence, log_margin};
use super::naive_bayes;
use super::options::Viewpoint;
use super::query::Query;
use super::recognition::{Instance, LabelVote, PointVote};
use super::verification::{Ranking, ScoredHypothesis};
use super::vote::{self, label_votes};
use crate::eigen::Neighbour;

/// The votes of a frame's windows.
pub(super) struct VoteResult {
    /// Best first.
    pub votes: Vec<LabelVote>,
    /// Most salient point first.
    pub points: Vec<PointVote>,
    pub exemplar_weights: Vec<f64>,
    /// Most confident first; empty if the method verifies no placements.
    pub instances: Vec<Instance>,
    /// For the best vote.
    pub evidence: Evidence,
    /// W of the strongest rival of the best vote, as a part of its W: another label, in the same place if there are
    /// placements.
    pub rival: Option<f64>,
}

impl VoteResult {
    /// The votes of verified placements: the best of each label has the W of its inliers.
    pub fn of_placements(query: &Query<'_>, ranking: &Ranking<'_>) -> VoteResult {
        let mut exemplar_weights = vec![0.0; query.model.exemplars.len()];
        for scored in &ranking.hypotheses {
            let weight: &mut f64 = &mut exemplar_weights[scored.hypothesis.exemplar];
            *weight = weight.max(scored.weight);
        }
        let best_of_labels = ranking.best_of_labels();
        let points = inlier_votes(query, &best_of_labels);
        let best = ranking.hypotheses.first();
        VoteResult {
            votes: placement_votes(ranking, &best_of_labels, &points, exemplar_weights.len()),
            points,
            exemplar_weights,
            instances: ranking.instances(query.model.confidence()),
            evidence: best.map_or(Evidence::None, |best| ranking.evidence(best)),
            rival: best.and_then(|best| ranking.rival(best)),
        }
    }

    /// The votes of windows for the owners of their nearest eigenpoints.
    pub fn of_windows(query: &Query<'_>) -> VoteResult {
        let model = query.model;
        let exemplar_of = |index: usize| model.windows.exemplar(index);
        let rows = query.rows().map(|(window, near)| (window.point, near));
        let mut tally = match model.options.viewpoint {
            Viewpoint::Free => {
                let nearest = rows.map(|(point, near)| (point, &near[0]));
                vote::tally(nearest, exemplar_of, &model.exemplars, &model.options) // A§4.5
            }
            Viewpoint::Upright => naive_bayes::tally(rows, exemplar_of, &model.exemplars),
        };
        tally.points.sort_by(|a, b| b.salience.total_cmp(&a.salience)); // stable
        let votes = label_votes(&tally.points, &model.exemplars);
        let rival = match &votes[..] {
            [first, second, ..] => Some(second.weight / first.weight),
            _ => None,
        };
        let evidence = votes.first().map_or(Evidence::None, |first| {
            let (points, windows) = (first.points as f64, query.windows.len() as f64);
            let second = votes.get(1).map_or(0, |second| second.points);
            Evidence::Vote {
                log_margin: log_margin(rival),
                lead: first.points.saturating_sub(second) as f64 / windows,
                share: points / windows,
                log_points: points.ln(),
            }
        });
        VoteResult {
            votes,
            points: tally.points,
            exemplar_weights: tally.exemplar_weights,
            instances: Vec::new(),
            evidence,
            rival,
        }
    }
}

/// The votes of the inliers; a window that is no inlier votes with weight 0 for the owner of its nearest eigenpoint.
fn inlier_votes(query: &Query<'_>, best_of_labels: &[&ScoredHypothesis]) -> Vec<PointVote> {
    let mut votes: Vec<(u32, PointVote)> = Vec::new();
    let mut is_inlier = vec![false; query.windows.len()];
    for scored in best_of_labels {
        for (index, weight) in scored.shares() {
            let found = &query.matches[index];
            let point = query.windows[found.query as usize].point;
            votes.push((
                found.query,
                PointVote::new(point, scored.hypothesis.exemplar, found.distance, weight),
            ));
            is_inlier[found.query as usize] = true;
        }
    }
    for (number, (window, near)) in query.rows().enumerate().filter(|(number, _)| !is_inlier[*number]) {
        let Neighbour { index, distance } = near[0];
        let exemplar = query.model.windows.exemplar(index);
        votes.push((number as u32, PointVote::new(window.point, exemplar, distance, 0.0)));
    }
    // stable: a window's votes stay in the order of the labels
    votes.sort_by(|(a, vote_a), (b, vote_b)| vote_b.salience.total_cmp(&vote_a.salience).then(a.cmp(b)));
    votes.into_iter().map(|(_, vote)| vote).collect()
}

/// The votes for the best placements. W is the sum of the points' weights in their order.
fn placement_votes(
    ranking: &Ranking<'_>,
    best_of_labels: &[&ScoredHypothesis],
    points: &[PointVote],
    exemplars: usize,
) -> Vec<LabelVote> {
    let mut weights = vec![0.0; exemplars];
    points.iter().for_each(|point| weights[point.exemplar] += point.weight);
    let weight = |scored: &ScoredHypothesis| weights[scored.hypothesis.exemplar];
    let all: f64 = best_of_labels.iter().map(|scored| weight(scored)).sum();
    let vote = |scored: &&ScoredHypothesis| LabelVote {
        label: ranking.label(scored).to_owned(),
        weight: weight(scored),
        share: weight(scored) / all,
        points: scored.hypothesis.inliers.len(),
        placement: Some(scored.verified()),
        a_contrario: None,
    };
    best_of_labels.iter().map(vote).collect()
}
