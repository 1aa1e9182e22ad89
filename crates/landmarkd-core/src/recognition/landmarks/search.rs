//! Search for the eigenpoints nearest to the windows of a frame (A§4.1, A§4.5), among all of a database or without some
//! of its exemplars.

use super::description::WindowBatch;
use super::model::{Exemplar, Landmarks};
use super::options::{Signature, Viewpoint};
use super::position_prior::{row_length, with_positions};
use crate::eigen::{EigenpointIndex, InvertedIndex, Neighbour};

/// Below so many eigenpoints all are looked at: an index would save little.
const EXACT_BELOW: usize = 4096;

/// The eigenpoints of a database as they are searched: signatures of gradients are many.
pub(super) enum WindowIndex {
    /// All are looked at.
    Exact(EigenpointIndex),
    /// Lists of the nearest centroids.
    Inverted(InvertedIndex),
}

impl WindowIndex {
    /// The index of n × `dimension` row-major eigenpoints.
    pub fn new(points: Vec<f32>, dimension: usize, signature: Signature) -> WindowIndex {
        match signature {
            Signature::Gradient if points.len() >= EXACT_BELOW * dimension => {
                WindowIndex::Inverted(InvertedIndex::new(points, dimension))
            }
            Signature::Gradient | Signature::Intensity => {
                WindowIndex::Exact(EigenpointIndex::new(points, dimension))
            }
        }
    }

    /// The eigenpoints, row-major.
    pub fn points(&self) -> &[f32] {
        match self {
            WindowIndex::Exact(index) => index.points(),
            WindowIndex::Inverted(index) => index.points(),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            WindowIndex::Exact(index) => index.count(),
            WindowIndex::Inverted(index) => index.count(),
        }
    }

    /// Memory held.
    pub fn bytes(&self) -> usize {
        match self {
            WindowIndex::Exact(index) => index.bytes(),
            WindowIndex::Inverted(index) => index.bytes(),
        }
    }

    /// The nearest of each query, nearest first.
    fn nearest_several(&self, queries: &[f32], count: usize) -> Vec<Neighbour> {
        match self {
            WindowIndex::Exact(index) if count == 1 => index.nearest(queries),
            WindowIndex::Exact(index) => index.nearest_several(queries, count),
            WindowIndex::Inverted(index) => index.nearest_several(queries, count),
        }
    }
}

/// Neighbours that are looked at for each that is kept, where an exemplar is left out.
const MORE_NEIGHBOURS: usize = 2;

/// The eigenpoints of a database without those of some exemplars.
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
        let kept = model.windows.iter().enumerate().filter(|(_, window)| !left_out[window.exemplar as usize]);
        let rows: Vec<u32> = kept.map(|(row, _)| row as u32).collect();
        let length = row_length(model.dimension(), model.options.position_prior_px);
        let all = model.index.points();
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
        None => model.index.nearest_several(&projected, count),
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
    let wanted = (MORE_NEIGHBOURS * count).min(model.index.count());
    let found = model.index.nearest_several(&model.eigenspace.project(&batch.signatures), wanted);
    let mut rows = Vec::with_capacity(batch.windows.len() * count);
    for row in found.chunks_exact(wanted) {
        let others = row.iter().filter(|near| model.windows[near.index].exemplar as usize != exemplar);
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
    (model.options.neighbours + background).min(model.index.count())
}
