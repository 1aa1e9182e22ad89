//! The answer that the hypotheses of a frame make.

use std::collections::HashSet;

use super::hypothesis::Hypothesis;
use super::matching::Match;
use super::placed_template::PlacedTemplate;
use crate::eigen::Neighbour;
use crate::imaging::{Frame, Image};
use crate::recognition::landmarks::confidence::{Evidence, log_margin};
use crate::recognition::landmarks::description::WindowBatch;
use crate::recognition::landmarks::homography::Homography;
use crate::recognition::landmarks::model::Landmarks;
use crate::recognition::landmarks::options::{Colour, Viewpoint};
use crate::recognition::landmarks::placement::Placement;
use crate::recognition::landmarks::reason::{Reason, reasons};
use crate::recognition::landmarks::recognition::{
    AContrario, AgreeingExemplar, Also, Decision, Instance, LabelVote, PointVote, Recognition,
    VerifiedPlacement,
};
use crate::recognition::landmarks::warning::{FEW_POINTS, Warning};
use crate::vision::InterestPoint;

/// A rival with more than this part of the best one's W is close.
const CLOSE: f64 = 0.8;

/// The windows of a frame with their nearest eigenpoints, rows of equal length.
pub(super) struct AskedWindows<'a> {
    pub batch: &'a WindowBatch,
    pub neighbours: &'a [Neighbour],
    pub matches: &'a [Match],
    /// Interest points in the frame.
    pub points_found: usize,
}

/// The hypotheses of a frame.
pub(super) struct Ranking<'a> {
    pub model: &'a Landmarks,
    /// The frame at its working size.
    pub working: &'a Frame,
    /// Its luminance with σ = 1 px.
    pub smoothed: &'a Image,
    /// What the decision for the likeliest rests on, where there is one: it, or a place that overlaps it.
    pub decided: Option<Hypothesis>,
    /// What the frame shows when it is flipped, if it is mirrored.
    pub mirrored: Option<Hypothesis>,
    /// Of each exemplar the best, likeliest first.
    pub hypotheses: Vec<Hypothesis>,
    /// What is there, each thing once, most evident first.
    pub instances: Vec<Hypothesis>,
}

impl Ranking<'_> {
    /// The answer.
    pub fn recognition(&self, windows: &AskedWindows<'_>, votes_of_exemplars: Vec<f64>) -> Recognition {
        let best = self.best_of_labels();
        let least = self.model.options.least_evidence();
        let points = self.points(&best, windows);
        let votes = self.votes(&best, &points);
        let evidence = self.evidence(&best);
        let a_contrario =
            self.decided.as_ref().or(best.first().copied()).map(|found| self.a_contrario(found));
        let decided = best.first().filter(|_| self.decided.is_some());
        let decision = decided.map(|first| Decision {
            label: self.label(first).to_owned(),
            confidence: self.model.confidence.as_ref().map(|curve| curve.of(&evidence)),
        });
        let also = best.iter().skip(1).filter(|other| self.mirrored.is_none() && other.is_evident(least));
        let also = also
            .map(|other| Also { label: self.label(other).to_owned(), a_contrario: self.a_contrario(other) });
        let asked = windows.batch.windows.len();
        Recognition {
            reasons: match decision {
                Some(_) => Vec::new(),
                None => reasons(self.model, self.working, asked, &votes, self.known_reason(&best)),
            },
            decision,
            points_found: windows.points_found,
            points_used: asked,
            instances: self.instances(),
            warnings: self.warnings(asked, &votes),
            votes,
            points,
            exemplar_weights: self.exemplar_weights(&best, votes_of_exemplars),
            evidence,
            a_contrario,
            also: also.collect(),
            agreeing: self.agreeing(),
        }
    }

    fn label(&self, found: &Hypothesis) -> &str {
        &self.model.exemplars[found.exemplar].label
    }

    fn is_negative(&self, found: &Hypothesis) -> bool {
        self.model.exemplars[found.exemplar].is_negative()
    }

    /// Why nothing is decided, where that is known: the frame is mirrored, or shows a negative exemplar at least as likely as
    /// any label, or all but one.
    fn known_reason(&self, best: &[&Hypothesis]) -> Option<Reason> {
        if let Some(flipped) = &self.mirrored {
            return Some(Reason::Mirrored { label: self.label(flipped).to_owned() });
        }
        let evident = |found: &&Hypothesis| found.is_evident(self.model.options.least_evidence());
        let background = self.hypotheses.iter().filter(evident).position(|found| self.is_negative(found))?;
        let found = self.hypotheses.iter().filter(evident).nth(background)?;
        let labels = best.iter().copied().filter(evident).count();
        let exemplar = || self.model.exemplars[found.exemplar].id.clone();
        (background == 0 || labels <= 1).then(|| Reason::KnownBackground { exemplar: exemplar() })
    }

    /// The exemplars that are evident; none where a negative exemplar is likeliest, or the frame is mirrored.
    fn agreeing(&self) -> Vec<AgreeingExemplar> {
        let is_unknown =
            self.mirrored.is_some() || self.hypotheses.first().is_some_and(|found| self.is_negative(found));
        let evident = self.hypotheses.iter().filter(|found| {
            !is_unknown && !self.is_negative(found) && found.is_evident(self.model.options.least_evidence())
        });
        let mut agreeing: Vec<AgreeingExemplar> = evident
            .map(|found| AgreeingExemplar { exemplar: found.exemplar, a_contrario: self.a_contrario(found) })
            .collect();
        agreeing
            .sort_by(|a, b| a.a_contrario.log10_false_alarms.total_cmp(&b.a_contrario.log10_false_alarms));
        agreeing
    }

    /// The likeliest hypothesis of each label, likeliest first.
    fn best_of_labels(&self) -> Vec<&Hypothesis> {
        let mut best: Vec<&Hypothesis> = Vec::new();
        for found in self.hypotheses.iter().filter(|found| !self.is_negative(found)) {
            if best.iter().all(|other| self.label(other) != self.label(found)) {
                best.push(found);
            }
        }
        best
    }

    /// For the best label.
    fn evidence(&self, best: &[&Hypothesis]) -> Evidence {
        match best {
            [] => Evidence::None,
            [first, others @ ..] => {
                let decisive = self.decided.as_ref().unwrap_or(first);
                let others = others.iter().filter(|other| other.exemplar != decisive.exemplar);
                evidence(decisive, others.copied())
            }
        }
    }

    fn a_contrario(&self, found: &Hypothesis) -> AContrario {
        AContrario {
            log10_false_alarms: -found.evidence,
            agreeing: found.witnesses.len(),
            asked: found.asked,
        }
    }

    /// The votes of the windows: each witness of a label's best hypothesis has an equal part of its W; the other windows
    /// vote with weight 0 for the owner of their nearest eigenpoint.
    fn points(&self, best: &[&Hypothesis], windows: &AskedWindows<'_>) -> Vec<PointVote> {
        let AskedWindows { batch, neighbours, matches, .. } = windows;
        let reduction = self.working.reduction;
        let posted = |query: usize| {
            let point = batch.windows[query].point;
            let [x_px, y_px] = [point.x_px, point.y_px].map(|at| (at + 0.5) * reduction - 0.5);
            InterestPoint { x_px, y_px, ..point }
        };
        let per_window = neighbours.len().checked_div(batch.windows.len()).unwrap_or(0).max(1);
        let nearest = |query: usize| neighbours[query * per_window];
        let mut votes: Vec<(usize, PointVote)> = Vec::new();
        let mut witnesses = HashSet::new();
        for (rank, found) in best.iter().enumerate() {
            let weight = self.weight(best, rank) / found.witnesses.len() as f64;
            for &index in &found.witnesses {
                let query = matches[index].query as usize;
                witnesses.insert(query);
                let distance = nearest(query).distance;
                votes.push((query, PointVote::new(posted(query), found.exemplar, distance, weight)));
            }
        }
        for query in (0..batch.windows.len()).filter(|query| !witnesses.contains(query)) {
            let Neighbour { index, distance } = nearest(query);
            let exemplar = self.model.windows.exemplar(index);
            votes.push((query, PointVote::new(posted(query), exemplar, distance, 0.0)));
        }
        // stable: a window's votes stay in the order of the labels
        votes.sort_by(|(a, vote_a), (b, vote_b)| vote_b.salience.total_cmp(&vote_a.salience).then(a.cmp(b)));
        votes.into_iter().map(|(_, vote)| vote).collect()
    }

    /// W of the label of a rank: −log₁₀ of the number of false alarms where that is under 1, else less than 1; no more than that
    /// of a likelier label. That of the decision is by the evidence it rests on.
    fn weight(&self, best: &[&Hypothesis], rank: usize) -> f64 {
        let first = self.decided.as_ref().unwrap_or(best[0]);
        best[1..=rank].iter().fold(own_weight(first), |least, found| least.min(own_weight(found)))
    }

    /// W of a label is the sum of its points' weights in their order.
    fn votes(&self, best: &[&Hypothesis], points: &[PointVote]) -> Vec<LabelVote> {
        let mut sums = vec![(0.0, 0); self.model.exemplars.len()];
        for point in points.iter().filter(|point| point.weight > 0.0) {
            let (weight, count) = &mut sums[point.exemplar];
            *weight += point.weight;
            *count += 1;
        }
        let all: f64 = best.iter().map(|found| sums[found.exemplar].0).sum();
        let vote = |found: &&Hypothesis| {
            let (weight, points) = sums[found.exemplar];
            LabelVote {
                label: self.label(found).to_owned(),
                weight,
                share: if all > 0.0 { weight / all } else { 0.0 },
                points,
                placement: Some(self.verified(found)),
                a_contrario: Some(self.a_contrario(found)),
            }
        };
        best.iter().map(vote).collect()
    }

    /// W of every exemplar: of a place its votes, as places overlap; else that of its hypothesis, of each label the
    /// likeliest alone, so that many views of a thing are no rivals.
    fn exemplar_weights(&self, best: &[&Hypothesis], votes: Vec<f64>) -> Vec<f64> {
        match self.model.options.viewpoint {
            Viewpoint::Upright => votes,
            Viewpoint::Free => {
                let mut weights = vec![0.0; votes.len()];
                best.iter().for_each(|found| weights[found.exemplar] = own_weight(found));
                weights
            }
        }
    }

    fn instances(&self) -> Vec<Instance> {
        let instance = |found: &Hypothesis| {
            let others = self.hypotheses.iter().filter(|other| {
                self.label(other) != self.label(found)
                    && other.witnesses.iter().any(|index| found.witnesses.contains(index))
            });
            Instance {
                label: self.label(found).to_owned(),
                confidence: self.model.confidence.map_or(1.0, |curve| curve.of(&evidence(found, others))),
                verified: self.verified(found),
            }
        };
        self.instances.iter().map(instance).collect()
    }

    /// The placement in pixels of the posted pictures.
    fn verified(&self, found: &Hypothesis) -> VerifiedPlacement {
        let exemplar = &self.model.exemplars[found.exemplar];
        let taught = self.model.options.reduction_of(exemplar.width_px, exemplar.height_px);
        let middle = self.model.working_size_px(found.exemplar).map(|side| (f64::from(side) - 1.0) / 2.0);
        let from_corner = found.map.from_corner(middle);
        let homography = from_corner.between_posted(f64::from(taught), f64::from(self.working.reduction));
        VerifiedPlacement {
            exemplar: found.exemplar,
            placement: placement(&homography, [exemplar.width_px, exemplar.height_px]),
            homography: Some(homography),
            inliers: found.witnesses.len(),
            agreement: PlacedTemplate::new(&exemplar.edges, &found.map).agreement(self.smoothed),
        }
    }

    fn warnings(&self, asked: usize, votes: &[LabelVote]) -> Vec<Warning> {
        let mut warnings = Vec::new();
        match asked {
            0 => warnings.push(Warning::NoInterestPoints),
            found if found < FEW_POINTS => warnings.push(Warning::TooFewPoints { found }),
            _ => {}
        }
        if let [first, second, ..] = votes
            && second.weight > CLOSE * first.weight
        {
            warnings.push(Warning::CloseSecond);
        }
        if self.model.options.colour == Colour::Opponent && !self.working.is_colour() {
            warnings.push(Warning::GrayFrame);
        }
        warnings
    }
}

fn own_weight(found: &Hypothesis) -> f64 {
    match found.evidence {
        evidence if evidence > 0.0 => 1.0 + evidence,
        _ => f64::from(found.density / (1.0 + found.density)),
    }
}

/// The evidence for a hypothesis beside others.
fn evidence<'h>(found: &Hypothesis, others: impl Iterator<Item = &'h Hypothesis>) -> Evidence {
    let rival = others.map(|other| other.evidence).fold(0.0, f64::max);
    Evidence::AContrario {
        log_evidence: found.evidence.max(0.0).ln_1p(),
        log_margin: log_margin(Some(rival / found.evidence.max(f64::MIN_POSITIVE))),
        log_agreeing: (found.witnesses.len().max(1) as f64).ln(),
    }
}

/// The similarity that is nearest to a homography in the middle of the exemplar's picture.
fn placement(homography: &Homography, size_px: [u32; 2]) -> Placement {
    let middle = size_px.map(|side| (f64::from(side) - 1.0) / 2.0);
    let [x, y] = homography.apply(middle);
    let local = homography.local_similarity(middle);
    Placement {
        x_px: x as f32,
        y_px: y as f32,
        rotation_rad: local.turn_rad as f32,
        scale: local.scale as f32,
    }
}
