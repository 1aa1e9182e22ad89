//! Each picture of a database asked with itself left out: how well the others of its label know it, and which labels look
//! alike. With gradient signatures.

use super::model::{Exemplar, Landmarks};
use super::multiscale;
use crate::imaging::Frame;

/// Exemplars that are asked at most, evenly chosen from all.
const MOST_ASKED: usize = 100;
/// Two pictures with so much agreement of all that was matched, at least, are the same.
const SAME: f64 = 0.5;
/// And with so many windows that agree.
const LEAST_SAME: usize = 100;

/// What a database without one of its exemplars says of that exemplar's picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// The exemplar's label.
    pub label: String,
    /// Whether the label has other pictures.
    pub has_others: bool,
    /// Whether the decision is its label, or it is named together with the decision.
    pub named: bool,
    /// Other labels that chance doesn't explain, best first: they show the same.
    pub alike: Vec<String>,
    /// Id of another label's exemplar that is the same picture.
    pub same_picture: Option<String>,
}

/// The exemplars to ask: their indices, ascending.
pub fn exemplars_to_leave_out(model: &Landmarks) -> Vec<usize> {
    let labelled = model.labelled();
    let all = labelled.len();
    let chosen = all.min(MOST_ASKED);
    (0..chosen).map(|i| labelled[i * all / chosen]).collect()
}

/// Asks for the picture of the exemplar of this id with that exemplar left out; `None` if there is no such exemplar, or
/// its database has other signatures.
pub fn left_out(model: &Landmarks, id: &str, frame: &Frame) -> Option<LeftOut> {
    let describer = model.scale_space.as_ref()?;
    let exemplar = model.exemplars.iter().position(|exemplar| exemplar.id == id)?;
    let label = model.exemplars[exemplar].label.clone();
    let recognition = multiscale::recognise(model, describer, Some(exemplar), frame, |_| ());
    let decided = recognition.decision.iter().map(|decision| &decision.label);
    let labels: Vec<&String> = decided.chain(recognition.also.iter().map(|also| &also.label)).collect();
    let other = |e: &Exemplar| e.label == label && e.id != id;
    let best = recognition.votes.first().filter(|vote| vote.label != label);
    let same = best.filter(|vote| {
        vote.a_contrario.is_some_and(|evidence| {
            evidence.agreeing >= LEAST_SAME && evidence.agreeing as f64 > SAME * evidence.asked as f64
        })
    });
    let placed = same.and_then(|vote| vote.placement.as_ref());
    Some(LeftOut {
        has_others: model.exemplars.iter().any(other),
        named: labels.contains(&&label),
        alike: labels.into_iter().filter(|other| **other != label).cloned().collect(),
        same_picture: placed.map(|placed| model.exemplars[placed.exemplar].id.clone()),
        label,
    })
}
