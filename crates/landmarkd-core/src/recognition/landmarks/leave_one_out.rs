//! Each picture of a database asked with itself left out: how well the others of its label know it, and which labels look
//! alike. With gradient signatures.

use super::model::{Exemplar, Landmarks, Windows};
use super::multiscale::asked_frame::AskedFrame;
use super::multiscale::recognise_among;
use super::recognition::PointVote;
use crate::imaging::Frame;
use crate::statistics::median;

/// Exemplars that are asked at most, evenly chosen from all.
const MOST_ASKED: usize = 100;
/// Two pictures are the same if half of the windows that agree are so near to each other: of windows of photographs three
/// of four are 0.26 and more from the nearest of any other photograph.
const SAME: f64 = 0.15;
/// And if so many agree.
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
    let Windows::Encoded(windows) = &model.windows else { return None };
    let exemplar = model.exemplars.iter().position(|exemplar| exemplar.id == id)?;
    let label = model.exemplars[exemplar].label.clone();
    let asked = AskedFrame::of(model, &windows.exemplars, frame, |_| ());
    let recognition = recognise_among(model, windows, Some(exemplar), &asked, |_| ());
    let decided = recognition.decision.iter().map(|decision| &decision.label);
    let labels: Vec<&String> = decided.chain(recognition.also.iter().map(|also| &also.label)).collect();
    let other = |e: &Exemplar| e.label == label && e.id != id;
    let best = recognition.votes.first().filter(|vote| vote.label != label);
    let placed = best.and_then(|vote| vote.placement.as_ref());
    let same = placed.filter(|placed| {
        let agrees = |point: &&PointVote| point.exemplar == placed.exemplar && point.weight > 0.0;
        let mut distances: Vec<f64> =
            recognition.points.iter().filter(agrees).map(|point| point.distance).collect();
        distances.len() >= LEAST_SAME && median(&mut distances, f64::total_cmp).is_some_and(|d| d < SAME)
    });
    Some(LeftOut {
        has_others: model.exemplars.iter().any(other),
        named: labels.contains(&&label),
        alike: labels.into_iter().filter(|other| **other != label).cloned().collect(),
        same_picture: same.map(|same| model.exemplars[same.exemplar].id.clone()),
        label,
    })
}
