//! What a frame's windows say together: the votes, the evidence for the best of them, and what stands against it.

use super::confidence::{EVIDENCE, Evidence};
use super::consensus::Match;
use super::description::Window;
use super::model::Landmarks;
use super::naive_bayes::tally;
use super::options::Viewpoint;
use super::recognition::{LabelVote, Placed, PointVote};
use super::standing::{Standing, in_one_place};
use super::vote::{label_votes, vote};
use crate::eigen::Neighbour;

/// Rivals below this part of the best one's W count alike, as none.
const FAR: f64 = 0.05;

/// What all windows so far say.
pub(super) struct Opinion {
    pub votes: Vec<LabelVote>,
    pub points: Vec<PointVote>,
    pub exemplar_weights: Vec<f64>,
    /// Where exemplars lie, the best first; none if windows only count.
    pub standings: Vec<Standing>,
    /// For the best vote.
    pub evidence: Evidence,
    /// The strongest other label in the best one's place, and its part of the best one's W.
    pub rival: Option<f64>,
}

impl Landmarks {
    /// The opinion of matches that say where exemplars lie.
    pub(super) fn placed(
        &self,
        windows: &[Window],
        neighbours: &[Neighbour],
        matches: &[Match],
        standings: Vec<Standing>,
    ) -> Opinion {
        let mut exemplar_weights = vec![0.0; self.exemplars.len()];
        for standing in &standings {
            let weight: &mut f64 = &mut exemplar_weights[standing.exemplar];
            *weight = weight.max(standing.weight);
        }
        let best = self.best_of_labels(&standings);
        // what every point gave, the strongest point first; those that gave nothing with their nearest eigenpoint
        let mut given: Vec<(u32, usize, f32, f64)> = best
            .iter()
            .flat_map(|standing| standing.given().map(|(index, weight)| (standing.exemplar, index, weight)))
            .map(|(exemplar, index, weight)| {
                let found = &matches[index as usize];
                (found.query, exemplar, found.distance, weight)
            })
            .collect();
        let mut gave = vec![false; windows.len()];
        given.iter().for_each(|(query, ..)| gave[*query as usize] = true);
        let count = neighbours.len() / windows.len().max(1);
        let nothing = gave.iter().enumerate().filter(|(_, gave)| !**gave && count > 0).map(|(query, _)| {
            let nearest = &neighbours[query * count];
            (query as u32, self.owned[nearest.index].exemplar as usize, nearest.distance, 0.0)
        });
        given.extend(nothing);
        given.sort_by_key(|(query, ..)| *query);
        let salience = |query: u32| windows[query as usize].point.salience;
        given.sort_by(|(a, ..), (b, ..)| salience(*b).total_cmp(&salience(*a))); // stable
        let point = |(query, exemplar, distance, weight): (u32, usize, f32, f64)| {
            let point = windows[query as usize].point;
            PointVote {
                x_px: point.x_px,
                y_px: point.y_px,
                salience: point.salience,
                exemplar,
                distance: f64::from(distance),
                weight,
            }
        };
        let points: Vec<PointVote> = given.into_iter().map(point).collect();
        // W is what the points gave, in their order
        let weight_of = |standing: &Standing| -> f64 {
            points.iter().filter(|point| point.exemplar == standing.exemplar).map(|point| point.weight).sum()
        };
        let all: f64 = best.iter().map(|standing| weight_of(standing)).sum();
        let votes = best.iter().map(|standing| LabelVote {
            label: self.label(standing).to_owned(),
            weight: weight_of(standing),
            share: weight_of(standing) / all,
            points: standing.inliers(),
            placement: Some(placed(standing)),
        });
        Opinion {
            votes: votes.collect(),
            points,
            exemplar_weights,
            evidence: standings.first().map_or([0.0; EVIDENCE], |first| self.evidence(first, &standings)),
            rival: standings.first().and_then(|first| self.rival(first, &standings)),
            standings,
        }
    }

    /// The opinion of matches that only count.
    pub(super) fn counted(&self, windows: &[Window], neighbours: &[Neighbour]) -> Opinion {
        let exemplar_of = |index: usize| self.owned[index].exemplar as usize;
        let (votes, points, exemplar_weights) = match self.options.viewpoint {
            Viewpoint::Free => {
                let count = if neighbours.is_empty() { 1 } else { neighbours.len() / windows.len() };
                let nearest = neighbours.iter().step_by(count);
                let matches = windows
                    .iter()
                    .zip(nearest)
                    .map(|(window, n)| (window.point, exemplar_of(n.index), f64::from(n.distance)));
                vote(matches, &self.exemplars, &self.options) // A§4.5
            }
            Viewpoint::Upright => {
                let count = if neighbours.is_empty() { 1 } else { neighbours.len() / windows.len() };
                let rows = windows.iter().map(|window| window.point).zip(neighbours.chunks_exact(count));
                let mut tally = tally(rows, exemplar_of, &self.exemplars);
                tally.points.sort_by(|a, b| b.salience.total_cmp(&a.salience)); // stable
                let votes = label_votes(&tally.points, &self.exemplars);
                (votes, tally.points, tally.exemplar_weights)
            }
        };
        let rival = match &votes[..] {
            [first, second, ..] => Some(second.weight / first.weight),
            _ => None,
        };
        let evidence = votes.first().map_or([0.0; EVIDENCE], |first| {
            let asked = windows.len() as f64;
            let next = votes.get(1).map_or(0, |second| second.points);
            [
                -rival.unwrap_or(FAR).max(FAR).ln(),
                first.points.saturating_sub(next) as f64 / asked,
                first.points as f64 / asked,
                (first.points as f64).ln(),
            ]
        });
        Opinion { votes, points, exemplar_weights, standings: Vec::new(), evidence, rival }
    }

    /// Of each label the best standing.
    pub(super) fn best_of_labels<'a>(&self, standings: &'a [Standing]) -> Vec<&'a Standing> {
        let mut best: Vec<&Standing> = Vec::new();
        for standing in standings {
            if best.iter().all(|other| self.label(other) != self.label(standing)) {
                best.push(standing);
            }
        }
        best
    }

    pub(super) fn label(&self, standing: &Standing) -> &str {
        &self.exemplars[standing.exemplar].label
    }

    /// The strongest standing of another label in the same place: its part of this one's W.
    fn rival(&self, standing: &Standing, all: &[Standing]) -> Option<f64> {
        let others = all.iter().filter(|other| {
            self.label(other) != self.label(standing) && in_one_place(standing, other, &self.exemplars)
        });
        others.map(|other| other.weight / standing.weight).reduce(f64::max)
    }

    /// What speaks for a standing.
    pub(super) fn evidence(&self, standing: &Standing, all: &[Standing]) -> Evidence {
        let rival = self.rival(standing, all).unwrap_or(FAR).clamp(FAR, 1.0);
        [
            (1.0 + 10.0 * standing.weight).ln(),
            f64::from(standing.agreement.max(0.0)),
            -rival.ln(),
            (standing.inliers() as f64).ln(),
        ]
    }
}

pub(super) fn placed(standing: &Standing) -> Placed {
    Placed {
        exemplar: standing.exemplar,
        placement: standing.placement,
        inliers: standing.inliers(),
        agreement: standing.agreement,
    }
}
