//! Search for the eigenpoints nearest to the windows of a frame (A§4.1, A§4.5), among all of a database or without some
//! of its exemplars.

use super::description::WindowBatch;
use super::model::{Exemplar, Landmarks};
use super::options::Viewpoint;
use super::position_prior::{row_length, with_positions};
use crate::eigen::{EigenpointIndex, Neighbour};

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
        None if count == 1 => model.index.nearest(&projected),
        None => model.index.nearest_several(&projected, count),
    }
}

/// Local naive Bayes needs one neighbour more: the farthest stands for the background.
fn neighbours_per_window(model: &Landmarks) -> usize {
    let background = usize::from(model.options.viewpoint == Viewpoint::Upright);
    (model.options.neighbours + background).min(model.index.count())
}
