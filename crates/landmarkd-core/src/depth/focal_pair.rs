//! Two pictures of one scene, focused near and far.

use thiserror::Error;

use crate::imaging::{Frame, Image};

/// Why two pictures are no focal pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PairError {
    /// The pictures differ in size.
    #[error(
        "the near-focused picture is {near_width_px}×{near_height_px} px, the far-focused one {far_width_px}×{far_height_px}"
    )]
    SizeMismatch {
        /// Width of the near-focused picture.
        near_width_px: usize,
        /// Height of the near-focused picture.
        near_height_px: usize,
        /// Width of the far-focused picture.
        far_width_px: usize,
        /// Height of the far-focused picture.
        far_height_px: usize,
    },
    /// One picture was given twice.
    #[error("both pictures are the same, pixel for pixel")]
    Identical,
    /// A side is too short.
    #[error("the pictures are {width_px}×{height_px} px; depth needs {least_px} px a side or more")]
    TooSmall {
        /// Width of both pictures.
        width_px: usize,
        /// Height of both pictures.
        height_px: usize,
        /// The shortest side that holds a window.
        least_px: usize,
    },
}

/// Two luminances of one size, and their pixels at full scale.
#[derive(Clone, Debug, PartialEq)]
pub struct FocalPair {
    pub(super) near: Image,
    pub(super) far: Image,
    /// Where the near and the far picture reach full scale, row-major.
    pub(super) saturated: [Vec<bool>; 2],
    /// Bits a sample of the coarser picture.
    pub(super) bits: u8,
}

/// Shorter sides hold no window.
const LEAST_SIDE_PX: usize = 16;
/// Full scale of every plane, whatever its bits.
const FULL_SCALE: f32 = 255.0;

/// Which pixels of a frame reach full scale in any of its planes.
fn saturated(frame: &Frame) -> Vec<bool> {
    let planes = frame.rgb.as_ref().map_or(std::slice::from_ref(&frame.luminance), |rgb| rgb);
    let mut saturated = vec![false; frame.width() * frame.height()];
    for plane in planes {
        saturated.iter_mut().zip(plane.pixels()).for_each(|(mark, &level)| *mark |= level >= FULL_SCALE);
    }
    saturated
}

impl FocalPair {
    /// The pair of a near- and a far-focused picture of `bits` bits a sample.
    ///
    /// # Errors
    /// [`PairError`]: sizes that differ or are too small, or one picture twice.
    pub fn new(near: Frame, far: Frame, bits: u8) -> Result<FocalPair, PairError> {
        let (width_px, height_px) = (near.width(), near.height());
        if (width_px, height_px) != (far.width(), far.height()) {
            return Err(PairError::SizeMismatch {
                near_width_px: width_px,
                near_height_px: height_px,
                far_width_px: far.width(),
                far_height_px: far.height(),
            });
        }
        if width_px.min(height_px) < LEAST_SIDE_PX {
            return Err(PairError::TooSmall { width_px, height_px, least_px: LEAST_SIDE_PX });
        }
        if near.luminance == far.luminance {
            return Err(PairError::Identical);
        }
        let saturated = [&near, &far].map(saturated);
        Ok(FocalPair { near: near.luminance, far: far.luminance, saturated, bits })
    }

    /// Width of both in pixels.
    pub fn width(&self) -> usize {
        self.near.width()
    }

    /// Height of both in pixels.
    pub fn height(&self) -> usize {
        self.near.height()
    }

    /// The middle of both, of at most this many pixels a side.
    pub(super) fn middle(&self, side_px: usize) -> FocalPair {
        let (width, height) = (self.width().min(side_px), self.height().min(side_px));
        let (left, top) = ((self.width() - width) / 2, (self.height() - height) / 2);
        let marks = |marks: &Vec<bool>| {
            let rows = (top..top + height).map(|y| &marks[y * self.width() + left..][..width]);
            rows.flatten().copied().collect()
        };
        FocalPair {
            near: self.near.middle(side_px),
            far: self.far.middle(side_px),
            saturated: self.saturated.each_ref().map(marks),
            bits: self.bits,
        }
    }

    /// Luminance of the near-focused picture, whose geometry the depth map has.
    pub fn near(&self) -> &Image {
        &self.near
    }
}
