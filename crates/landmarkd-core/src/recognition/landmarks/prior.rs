//! The belief that a window is seen near where it was (places, upright): its place in the frame as two more
//! coordinates of its eigenpoint. A window that moved by the prior's width is as much farther as if its signature
//! had changed by [`WEIGHT`], squared.

use super::description::Window;

/// Squared distance that one width makes.
const WEIGHT: f64 = 0.02;
/// Coordinates of a place.
const COORDINATES: usize = 2;

/// Eigenpoints of `dimension` coordinates with the place of each one's window, if the prior is wanted.
pub(super) fn with_places(
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

/// The same without the places.
pub(super) fn without_places(rows: &[f32], dimension: usize, position_prior_px: Option<f64>) -> Vec<f32> {
    match position_prior_px {
        None => rows.to_vec(),
        Some(_) => {
            rows.chunks_exact(dimension + COORDINATES).flat_map(|row| &row[..dimension]).copied().collect()
        }
    }
}

/// Coordinates of a row.
pub(super) fn coordinates(dimension: usize, position_prior_px: Option<f64>) -> usize {
    dimension + if position_prior_px.is_some() { COORDINATES } else { 0 }
}
