//! Search for the eigenpoints nearest to the windows of a frame (A§4.1, A§4.5), among all of a database or without some
//! of its exemplars.

use super::description::WindowBatch;
use super::model::{Exemplar, Landmarks, PlainWindows, Windows};
use super::options::{Signature, Viewpoint};
use super::position_prior::{row_length, with_positions};
use crate::eigen::{EigenpointIndex, Neighbour};

/// Neighbours that are looked at for each that is kept, where an exemplar is left out.
const MORE_NEIGHBOURS: usize = 2;

impl Windows {
    /// The nearest of each query, nearest first.
    fn nearest_several(&self, queries: &[f32], count: usize) -> Vec<Neighbour> {
        match self {
            Windows::Plain(PlainWindows { index, .. }) if count == 1 => index.nearest(queries),
            Windows::Plain(PlainWindows { index, .. }) => index.nearest_several(queries, count),
            Windows::Encoded(windows) => windows.index().nearest_several(queries, count),
            Windows::Elsewhere(_) => Vec::new(),
        }
    }
}

/// The eigenpoints of a database with signatures of intensities without those of some exemplars.
pub(super) struct EigenpointSubset {
    /// `None` if no eigenpoint is left.
    index: Option<EigenpointIndex>,
    /// Of each eigenpoint of the subset its row in the whole database.
    rows: Vec<u32>,
}

impl EigenpointSubset {
    /// The eigenpoints of the exemplars that `left_out` is false for.
    pub fn without(model: &Landmarks, left_out: impl Fn(&Exemplar) -> bool) -> EigenpointSubset {
        let left_out: Vec<bool> = model.exemplars.iter().map(left_out).collect();
        let Windows::Plain(plain) = &model.windows else {
            return EigenpointSubset { index: None, rows: Vec::new() };
        };
        let kept = plain.windows.iter().enumerate().filter(|(_, window)| !left_out[window.exemplar as usize]);
        let rows: Vec<u32> = kept.map(|(row, _)| row as u32).collect();
        let length = row_length(model.dimension(), model.options.position_prior_px);
        let all = plain.index.points();
        let points: Vec<f32> =
            rows.iter().flat_map(|&row| &all[row as usize * length..][..length]).copied().collect();
        EigenpointSubset { index: (!points.is_empty()).then(|| EigenpointIndex::new(points, length)), rows }
    }
}

/// The nearest eigenpoints of every window, rows of equal length, nearest first. Searches the subset if there is one.
pub(super) fn nearest(
    model: &Landmarks,
    batch: &WindowBatch,
    subset: Option<&EigenpointSubset>,
) -> Vec<Neighbour> {
    let projected = with_positions(
        model.eigenspace.project(&batch.signatures),
        model.dimension(),
        batch.windows.iter().copied(),
        model.options.position_prior_px,
    );
    let count = neighbours_per_window(model);
    match subset {
        Some(EigenpointSubset { index: None, .. }) => Vec::new(),
        Some(EigenpointSubset { index: Some(index), rows }) => {
            let found = index.nearest_several(&projected, count.min(index.count()));
            found.into_iter().map(|n| Neighbour { index: rows[n.index] as usize, ..n }).collect()
        }
        None => model.windows.nearest_several(&projected, count),
    }
}

/// The nearest eigenpoints of every window, without those of one exemplar if so asked: rows of equal length, nearest first.
pub(super) fn nearest_but(model: &Landmarks, batch: &WindowBatch, held_out: Option<usize>) -> Vec<Neighbour> {
    match held_out {
        None => nearest(model, batch, None),
        Some(exemplar) => nearest_without(model, batch, exemplar),
    }
}

/// The nearest eigenpoints of every window without those of one exemplar, rows of equal length, nearest first. Where
/// the exemplar takes most of what is near, the farthest of the others stands for those that are missing.
fn nearest_without(model: &Landmarks, batch: &WindowBatch, exemplar: usize) -> Vec<Neighbour> {
    let count = neighbours_per_window(model);
    let wanted = (MORE_NEIGHBOURS * count).min(model.windows.count());
    let found = model.windows.nearest_several(&model.eigenspace.project(&batch.signatures), wanted);
    let mut rows = Vec::with_capacity(batch.windows.len() * count);
    for row in found.chunks_exact(wanted) {
        let others = row.iter().filter(|near| model.windows.exemplar(near.index) != exemplar);
        let before = rows.len();
        rows.extend(others.take(count));
        match rows[before..].last().copied() {
            Some(farthest) => rows.resize(before + count, farthest),
            // nothing else is near: the window says nothing
            None => rows.resize(before + count, row[wanted - 1]),
        }
    }
    rows
}

/// Local naive Bayes needs one neighbour more: the farthest stands for the background.
fn neighbours_per_window(model: &Landmarks) -> usize {
    let by_background =
        model.options.viewpoint == Viewpoint::Upright || model.options.signature == Signature::Gradient;
    let background = usize::from(by_background);
    (model.options.neighbours + background).min(model.windows.count())
}
