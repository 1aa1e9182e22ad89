//! Scale space: a picture at several resolutions, each smoothed before it is sampled (Lindeberg 1994).
//!
//! Level 0 is the picture itself; level i has 2^(i / `levels_per_octave`) px of the picture per px of its own. Pixel
//! centres are at whole numbers: the level's pixel u stands at (u + 0.5)·k − 0.5 of the picture.

use crate::imaging::{Image, resampled};

use super::smoothing::smoothed;

/// A level is not made if its shorter side would have fewer pixels.
const LEAST_SIDE_PX: usize = 40;
/// Blur of a sampled picture, px: what is sampled k times coarser is smoothed to k times as much.
const SAMPLING_BLUR_PX: f64 = 0.5;

/// A picture at one resolution.
#[derive(Clone, Debug)]
pub struct Level {
    /// The picture, sampled.
    pub image: Image,
    /// Pixels of the picture per pixel of the level, ≥ 1.
    pub scale: f32,
}

/// The picture at up to `levels` resolutions, the finest first; level 0 whatever its size.
pub fn scale_space(picture: &Image, levels_per_octave: usize, levels: usize) -> Vec<Level> {
    let step = (1.0 / levels_per_octave as f64).exp2();
    let blur_px = SAMPLING_BLUR_PX * (step * step - 1.0).sqrt();
    let mut out = vec![Level { image: picture.clone(), scale: 1.0 }];
    while out.len() < levels {
        let finer = &out[out.len() - 1];
        let side = |whole: usize| (whole as f64 / step.powi(out.len() as i32)).round() as usize;
        let (width, height) = (side(picture.width()), side(picture.height()));
        if width.min(height) < LEAST_SIDE_PX {
            break;
        }
        let image = resampled(&smoothed(&finer.image, blur_px as f32), width, height);
        out.push(Level { image, scale: picture.width() as f32 / width as f32 });
    }
    out
}
