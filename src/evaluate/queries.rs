//! The queries of an evaluation: each is decoded, recognised, timed and compared with its truth, whatever the model.

use std::collections::BTreeSet;

use super::figures::{Times, timed};
use super::files::{LabelledFile, Skipped, UNKNOWN, read_frame};
use landmarkd_core::imaging::Frame;

/// Counts pictures that are done, and reports the count.
pub(super) struct Progress<'a> {
    done: usize,
    total: usize,
    report: &'a mut dyn FnMut(usize, usize),
}

impl<'a> Progress<'a> {
    /// Of `total` pictures; `report` is called with (pictures done, all pictures).
    pub fn new(total: usize, report: &'a mut dyn FnMut(usize, usize)) -> Progress<'a> {
        Progress { done: 0, total, report }
    }

    /// One more picture is done.
    pub fn step(&mut self) {
        self.done += 1;
        (self.report)(self.done, self.total);
    }
}

/// The answers to all queries.
pub(super) struct Answers<J> {
    /// Each compared with its truth, in the order of the files.
    pub judged: Vec<J>,
    /// Labels of queries that the model was not trained on, but for [`UNKNOWN`].
    pub untrained_labels: Vec<String>,
    /// From the bytes of a query to its pixels.
    pub decode: Times,
    /// From its pixels to the answer.
    pub recognise: Times,
}

/// Recognises every query of the files; `judge` compares an answer with its file, whose label is one of `labels` or not.
/// Pictures that can't be read or recognised are skipped.
pub(super) fn ask<R, E: ToString, J>(
    files: &[LabelledFile],
    labels: &[&str],
    recognise: impl Fn(&Frame) -> Result<R, E>,
    judge: impl Fn(&LabelledFile, bool, R) -> J,
    skipped: &mut Vec<Skipped>,
    progress: &mut Progress,
) -> Answers<J> {
    let (mut judged, mut untrained) = (Vec::new(), BTreeSet::new());
    let (mut decode_ms, mut recognise_ms) = (Vec::new(), Vec::new());
    for file in files {
        if let Some((frame, took_ms)) = read_frame(&file.path, skipped) {
            let is_known = file.label.as_deref().is_some_and(|label| labels.contains(&label));
            let mut recognised_ms = 0.0;
            match timed(&mut recognised_ms, || recognise(&frame)) {
                Err(reason) => skipped.push(Skipped::new(&file.path, reason)),
                Ok(recognition) => {
                    if !is_known {
                        untrained.extend(file.label.clone());
                    }
                    decode_ms.push(took_ms);
                    recognise_ms.push(recognised_ms);
                    judged.push(judge(file, is_known, recognition));
                }
            }
        }
        progress.step();
    }
    untrained.remove(UNKNOWN);
    Answers {
        judged,
        untrained_labels: untrained.into_iter().collect(),
        decode: Times::of(decode_ms),
        recognise: Times::of(recognise_ms),
    }
}
