//! Makes both pictures equally bright and of equal contrast, place by place: apertures, sensors, vignettes, dark levels and
//! tone curves differ.
//!
//! A ratio of brightness alone doesn't show a dark level or a tone curve that only one picture has: both change the
//! contrast by another factor than the brightness. So relative changes of brightness across the picture are compared
//! too. What both pictures have alike can't be seen here.

use super::windows::{Means, Planes};
use crate::imaging::Image;
use crate::statistics::median;

/// Window of the local brightness in pixels: wide enough that blur doesn't change its mean.
const WINDOW_PX: f64 = 16.0;
/// The same over the largest blur, at least.
const WINDOW_BLURS: f64 = 3.0;
/// Changes of brightness are taken across this many windows.
const ACROSS: f64 = 2.0;
/// Added to both means, so that the ratio stays finite in the dark.
const PEDESTAL: f32 = 1.0;
/// Gray levels from here on are cut off.
const FULL_SCALE: f32 = 254.5;
/// This part of the pixels is no loss.
const CLIPPED_PART: f64 = 0.001;
/// A contrast nearer to 1 is left: scenes that are all near or all far show as much.
const LEAST_CONTRAST: f64 = 0.02;
/// Root of the mean square of the far picture's relative changes of brightness, at least: what blur does to less of them
/// would be taken for contrast.
const LEAST_CHANGE: f64 = 0.012;
/// Changes of brightness in both pictures must correlate so far.
const LEAST_CORRELATION: f64 = 0.995;
/// A contrast farther from 1 is no tone curve.
const MOST_CONTRAST: f64 = 2.0;

/// A far picture made as bright as the near one.
pub(super) struct Matched {
    pub(super) far: Image,
    /// What it was multiplied by: the median over the picture.
    pub(super) gain: f64,
    /// The power that its brightness, relative to what is around, was raised to.
    pub(super) contrast: f64,
}

/// The far picture with the near one's local brightness n̄ and contrast k: n̄·(f/f̄)^k.
pub(super) fn matched(near: &Image, far: &Image, largest_blur_px: f64) -> Matched {
    let (width, height) = (near.width(), near.height());
    let rows = Planes { width, planes: [near.pixels(), far.pixels()] };
    let means = Means::over(&rows, width, height, WINDOW_PX.max(WINDOW_BLURS * largest_blur_px));
    // Light that full scale cuts off changes brightness as no tone curve does.
    let contrast = if [near, far].into_iter().any(is_clipped) { 1.0 } else { contrast(&means) };
    let [near, there] = &means.planes;
    let raised = |level: f32| level.max(0.0) + PEDESTAL;
    // What a level of 1 becomes: n̄/f̄^k.
    let factors: Vec<f32> =
        near.iter().zip(there).map(|(&n, &f)| raised(n) / raised(f).powf(contrast as f32)).collect();
    let mut ratios: Vec<f32> = near.iter().zip(there).map(|(&n, &f)| raised(n) / raised(f)).collect();
    let gain = f64::from(median(&mut ratios, f32::total_cmp).unwrap_or(1.0));

    let mut out = far.clone();
    let mut along = vec![0.0; means.width];
    for (y, row) in out.pixels_mut().chunks_exact_mut(width).enumerate() {
        let (before, v) = (y / means.step, (y % means.step) as f32 / means.step as f32);
        let after = (before + 1).min(means.height - 1);
        for (x, ratio) in along.iter_mut().enumerate() {
            let at = |y: usize| factors[y * means.width + x];
            *ratio = at(before) * (1.0 - v) + at(after) * v;
        }
        for (cell, pixels) in row.chunks_mut(means.step).enumerate() {
            let (left, right) = (along[cell], along[(cell + 1).min(means.width - 1)]);
            for (x, pixel) in pixels.iter_mut().enumerate() {
                let factor = left + (right - left) * (x as f32 / means.step as f32);
                *pixel = match contrast {
                    1.0 => *pixel * factor,
                    _ => raised(*pixel).powf(contrast as f32) * factor,
                };
            }
        }
    }
    Matched { far: out, gain, contrast }
}

/// Whether full scale cuts off more than single pixels of a picture.
fn is_clipped(image: &Image) -> bool {
    let clipped = image.pixels().iter().filter(|&&level| level >= FULL_SCALE).count();
    clipped as f64 > CLIPPED_PART * image.pixels().len() as f64
}

/// By how much more the near picture's brightness changes across itself than the far one's, both relative to what they
/// are; 1 if that can't be told from what blur does.
fn contrast(means: &Means<2>) -> f64 {
    let apart = (ACROSS * means.sigma_px / means.step as f64).round() as usize;
    let logarithm = |plane: usize, at: usize| f64::from((means.planes[plane][at].max(0.0) + PEDESTAL).ln());
    let [mut near_near, mut near_far, mut far_far, mut count] = [0.0; 4];
    for y in 0..means.height {
        for x in 0..means.width {
            let at = y * means.width + x;
            let right = (x + apart < means.width).then_some(at + apart);
            let below = (y + apart < means.height).then_some(at + apart * means.width);
            for other in [right, below].into_iter().flatten() {
                let [near, far] = [0, 1].map(|plane| logarithm(plane, other) - logarithm(plane, at));
                near_near += near * near;
                near_far += near * far;
                far_far += far * far;
                count += 1.0;
            }
        }
    }
    let correlation = near_far / (near_near * far_far).sqrt();
    let contrast = (near_near / far_far).sqrt();
    let told = (far_far / count).sqrt() >= LEAST_CHANGE && correlation > LEAST_CORRELATION;
    let differs = (LEAST_CONTRAST..MOST_CONTRAST.ln()).contains(&contrast.ln().abs());
    if told && differs { contrast } else { 1.0 }
}
