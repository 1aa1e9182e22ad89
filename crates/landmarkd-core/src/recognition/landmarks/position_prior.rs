//! The prior that a window is seen near its trained position (places, upright): the position in the frame as two more
//! coordinates of the eigenpoint. A window that moved by the prior's width is as much farther as if its signature
//! had changed by [`WEIGHT`], squared.

use super::description::Window;

/// Squared distance in the eigenspace that a move by one width adds.
const WEIGHT: f64 = 0.02;
/// Coordinates of a position.
const COORDINATES: usize = 2;

/// Appends to each eigenpoint of `dimension` coordinates the position of its window, if there is a prior.
pub(super) fn with_positions(
    eigenpoints: Vec<f32>,
    dimension: usize,
    windows: impl Iterator<Item = Window>,
    position_prior_px: Option<f64>,
) -> Vec<f32> {
    let Some(width_px) = position_prior_px else { return eigenpoints };
    let scale = (WEIGHT.sqrt() / width_px) as f32;
    let rows = eigenpoints.chunks_exact(dimension).zip(windows);
    rows.flat_map(|(row, Window { point, .. })| {
        row.iter().copied().chain([scale * point.x_px, scale * point.y_px])
    })
    .collect()
}

/// The eigenpoints of `dimension` coordinates without the positions.
pub(super) fn without_positions(rows: &[f32], dimension: usize, position_prior_px: Option<f64>) -> Vec<f32> {
    let rows = rows.chunks_exact(row_length(dimension, position_prior_px));
    rows.flat_map(|row| &row[..dimension]).copied().collect()
}

/// Coordinates of a row: those of the eigenpoint, and of the position if there is a prior.
pub(super) fn row_length(dimension: usize, position_prior_px: Option<f64>) -> usize {
    dimension + if position_prior_px.is_some() { COORDINATES } else { 0 }
}
