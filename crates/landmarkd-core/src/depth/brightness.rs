//! Makes both pictures equally bright, place by place: apertures, sensors and vignettes differ.
//!
//! Expects pictures without offsets (dark levels): a ratio of brightness doesn't show them.

use super::windows::{Means, Planes};
use crate::imaging::Image;
use crate::statistics::median;

/// Window of the local brightness in pixels: wide enough that blur doesn't change its mean.
const WINDOW_PX: f64 = 16.0;
/// Added to both means, so that the ratio stays finite in the dark.
const PEDESTAL: f32 = 1.0;

/// The far picture times the ratio of the local means, and the median of that ratio.
pub(super) fn matched(near: &Image, far: &Image) -> (Image, f64) {
    let (width, height) = (near.width(), near.height());
    let rows = Planes { width, planes: [near.pixels(), far.pixels()] };
    let means = Means::over(&rows, width, height, WINDOW_PX);
    let ratios: Vec<f32> = means.planes[0]
        .iter()
        .zip(&means.planes[1])
        .map(|(n, f)| (n.max(0.0) + PEDESTAL) / (f.max(0.0) + PEDESTAL))
        .collect();
    let median = median(&mut ratios.clone(), f32::total_cmp).unwrap_or(1.0);

    let mut out = far.clone();
    let mut along = vec![0.0; means.width];
    for (y, row) in out.pixels_mut().chunks_exact_mut(width).enumerate() {
        let (before, v) = (y / means.step, (y % means.step) as f32 / means.step as f32);
        let after = (before + 1).min(means.height - 1);
        for (x, ratio) in along.iter_mut().enumerate() {
            let at = |y: usize| ratios[y * means.width + x];
            *ratio = at(before) * (1.0 - v) + at(after) * v;
        }
        for (cell, pixels) in row.chunks_mut(means.step).enumerate() {
            let (left, right) = (along[cell], along[(cell + 1).min(means.width - 1)]);
            for (x, pixel) in pixels.iter_mut().enumerate() {
                *pixel *= left + (right - left) * (x as f32 / means.step as f32);
            }
        }
    }
    (out, f64::from(median))
}
