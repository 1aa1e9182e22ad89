//! Recognition of synthetic views with their exemplar's label in the database, and with the label held out, when the
//! right answer is none.

use super::confidence::CalibrationSample;
use super::description::ExemplarName;
use super::model::{Exemplar, Landmarks};
use super::recognise::recognise;
use super::recognition::Recognition;
use super::search::EigenpointSubset;
use super::synthetic_view::SyntheticView;
use crate::imaging::Frame;

/// Exemplars with synthetic views at most.
const MOST_EXEMPLARS: usize = 40;
/// Fewer exemplars have several rounds of views each.
const FEW_EXEMPLARS: usize = 10;

/// A label with more than this part of another's evidence is as evident.
const EQUAL: f64 = 0.95;

/// Which exemplars of a database are shown in synthetic views, evenly chosen from all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CalibrationPlan {
    /// Indices of the exemplars, ascending.
    pub exemplars: Vec<usize>,
    /// Rounds of views of each exemplar.
    pub rounds: u64,
}

impl CalibrationPlan {
    /// The plan for a database.
    pub fn of(model: &Landmarks) -> CalibrationPlan {
        let labelled = model.labelled();
        let all = labelled.len();
        let chosen = all.min(MOST_EXEMPLARS);
        CalibrationPlan {
            exemplars: (0..chosen).map(|i| labelled[i * all / chosen]).collect(),
            rounds: FEW_EXEMPLARS.div_ceil(chosen.max(1)) as u64,
        }
    }
}

/// Two samples of each synthetic view of an exemplar: with its label, and with the label held out.
///
/// Exemplars don't depend on each other: their samples may be taken in parallel.
pub fn calibration_samples(
    model: &Landmarks,
    name: &ExemplarName,
    views: &[SyntheticView],
) -> Vec<CalibrationSample> {
    let samples = |[known, unknown]: [Recognition; 2]| {
        let right = known.votes.first().is_some_and(|vote| vote.label == name.label);
        [
            CalibrationSample { evidence: known.evidence, right, known: true },
            CalibrationSample { evidence: unknown.evidence, right: false, known: false },
        ]
    };
    answers(model, name, views).into_iter().flat_map(samples).collect()
}

/// Whether the database decides correctly on each synthetic view of an exemplar: for its label, and for none with the
/// label held out. Two answers a view, in the same order for every database.
pub fn correct_decisions(model: &Landmarks, name: &ExemplarName, views: &[SyntheticView]) -> Vec<bool> {
    let correct = |[known, unknown]: [Recognition; 2]| {
        let right = known.decision.is_some_and(|decision| decision.label == name.label);
        [right, unknown.decision.is_none()]
    };
    answers(model, name, views).into_iter().flat_map(correct).collect()
}

/// Whether the database names the label of an exemplar on each synthetic view of it, and no other label is as evident.
pub fn names_rightly(model: &Landmarks, name: &ExemplarName, views: &[SyntheticView]) -> Vec<bool> {
    let rightly = |view: &SyntheticView| {
        let recognition = model.recognise(&view.frame, |_| ());
        let own = recognition.a_contrario.map_or(0.0, |own| -own.log10_false_alarms);
        let as_evident =
            recognition.also.iter().any(|also| -also.a_contrario.log10_false_alarms > EQUAL * own);
        !as_evident && recognition.decision.is_some_and(|decision| decision.label == name.label)
    };
    views.iter().map(rightly).collect()
}

/// The answers to each synthetic view: with the label in the database, and with the label held out.
fn answers(model: &Landmarks, name: &ExemplarName, views: &[SyntheticView]) -> Vec<[Recognition; 2]> {
    let any = |wanted: &dyn Fn(&Exemplar) -> bool| model.exemplars.iter().any(wanted);
    let other_views = any(&|e| e.label == name.label && e.id != name.id);
    let other_labels = any(&|e| e.label != name.label);
    let without_itself = other_views.then(|| EigenpointSubset::without(model, |e| e.id == name.id));
    let without_label = EigenpointSubset::without(model, |e| e.label == name.label);
    let ask = |frame: &Frame, subset| recognise(model, subset, frame, |_| ());
    let answers = |view: &SyntheticView| {
        let known = ask(&view.frame, without_itself.as_ref().filter(|_| view.new_view));
        let unknown = match other_labels {
            true => ask(&view.frame, Some(&without_label)),
            // nothing else is known: the background alone
            false => ask(&view.background, None),
        };
        [known, unknown]
    };
    views.iter().map(answers).collect()
}
