//! A depth map: distance, expected error and flags of every pixel of the near-focused picture, and figures of the
//! whole.

use std::f64::consts::PI;

use super::prediction::{HALVED_WINDOW_PX, WINDOW_PX};
use super::selection::TEXTURE_SIGMA;
use super::{BlurScale, Optics};

/// Why a pixel has no depth: one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Flag {
    /// Too little texture: an expected error above 2 % of the range, no more detail than noise, or a lone contour, of
    /// which nothing says to which of its sides its depth belongs.
    LowTexture = 1,
    /// Full scale within 8 px in either picture.
    Saturated = 2,
    /// |β| above 1.05.
    OutOfRange = 4,
    /// No one depth explains the window, or neighbouring windows' depths differ: a step, occlusion, motion,
    /// misregistration, glint.
    Inconsistent = 8,
    /// The filters don't fit into the picture here.
    Border = 16,
    /// A second depth explains the window nearly as well.
    Ambiguous = 32,
}

impl Flag {
    /// Every flag, by its bit.
    pub const ALL: [Flag; 6] = {
        use Flag::*;
        [LowTexture, Saturated, OutOfRange, Inconsistent, Border, Ambiguous]
    };

    /// Its bit in a pixel's flags.
    pub const fn bit(self) -> u8 {
        self as u8
    }

    /// Its name in the contract.
    pub const fn word(self) -> &'static str {
        match self {
            Flag::LowTexture => "low_texture",
            Flag::Saturated => "saturated",
            Flag::OutOfRange => "out_of_range",
            Flag::Inconsistent => "inconsistent",
            Flag::Border => "border",
            Flag::Ambiguous => "ambiguous",
        }
    }
}

/// A doubt about the whole map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// The pictures were more than 0.25 px apart, and were brought together.
    Shifted,
    /// No shift could be measured: the texture doesn't fix one.
    ShiftUnknown,
    /// The pictures' scales differ by more than 0.25 px in the corners (the lens breathes, or zooms), and were matched.
    Scaled,
    /// The camera turned by more than 0.25 px in the corners between the pictures; it was turned back.
    Rotated,
    /// A part of the picture moved by more than 0.3 px between the pictures, against the rest.
    Moved,
    /// No shift, scale and turn brings the pictures' parts together.
    Misregistered,
    /// The pictures' brightness differs by more than 3 %.
    GainOff,
    /// The pictures' contrasts differ by another factor than their brightness: a dark level or a tone curve that only one
    /// of them has; they were matched.
    ContrastOff,
    /// More than a fifth of the pixels with texture are inconsistent.
    ManyInconsistent,
    /// Fewer than 5 % of the pixels have a depth.
    LowCoverage,
    /// By the scales of the pictures near and far are exchanged, or by their detail the two apertures.
    NearFarSwapped,
}

impl Warning {
    /// Its word in the contract.
    pub const fn word(self) -> &'static str {
        match self {
            Warning::Shifted => "shifted",
            Warning::ShiftUnknown => "shift_unknown",
            Warning::Scaled => "scaled",
            Warning::Rotated => "rotated",
            Warning::Moved => "moved",
            Warning::Misregistered => "misregistered",
            Warning::GainOff => "gain_off",
            Warning::ContrastOff => "contrast_off",
            Warning::ManyInconsistent => "many_inconsistent",
            Warning::LowCoverage => "low_coverage",
            Warning::NearFarSwapped => "near_far_swapped",
        }
    }
}

/// The least, the median and the largest depth, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthSpan {
    /// The least depth.
    pub min: f64,
    /// The upper median of the depths.
    pub median: f64,
    /// The largest depth.
    pub max: f64,
}

/// Figures of a whole depth map.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The distance that the near-focused picture is focused at, in mm.
    pub near_focus_mm: f64,
    /// The distance that the far-focused picture is focused at, in mm.
    pub far_focus_mm: f64,
    /// Part of the pixels that have a depth.
    pub coverage: f64,
    /// `None` if no pixel has a depth.
    pub depth: Option<DepthSpan>,
    /// Noise of a picture in gray levels of 255, estimated from the residual (`gram` only).
    pub noise_sigma: Option<f64>,
    /// By how much the far-focused picture was displaced and has been moved back, x and y.
    pub shift_px: [f64; 2],
    /// What the far-focused picture was multiplied by: the median over the picture.
    pub gain: f64,
    /// Pixels with each flag, in the order of [`Flag::ALL`].
    pub flag_counts: [u64; 6],
    /// Doubts about the whole map, in the order in which they arise.
    pub warnings: Vec<Warning>,
}

/// Distances of the pixels of the near-focused picture, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) depth_mm: Vec<f32>,
    pub(super) sigma_mm: Vec<f32>,
    pub(super) flags: Vec<u8>,
    pub(super) optics: Optics,
    pub(super) halvings: u32,
    /// Figures of the whole map.
    pub summary: Summary,
}

impl DepthMap {
    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Distance along the optical axis in mm, row-major; NaN where a flag is set.
    pub fn depth_mm(&self) -> &[f32] {
        &self.depth_mm
    }

    /// Expected standard deviation of each depth in mm; NaN where there is none (the method has no model of its error,
    /// or the texture is too weak).
    pub fn sigma_mm(&self) -> &[f32] {
        &self.sigma_mm
    }

    /// The standard deviation to be expected of the median of so many depths that lie side by side, each of `sigma_mm`: what
    /// noise makes of them averages out window by window, and what one texture makes of them doesn't.
    pub fn sigma_of_median_mm(&self, sigma_mm: f64, depths: usize) -> f64 {
        // β spans two over the working range.
        let shared_mm = (f64::from(TEXTURE_SIGMA) / 2.0 * self.optics.range_mm()).min(sigma_mm);
        let window_px = match self.halvings {
            0 => WINDOW_PX,
            halvings => HALVED_WINDOW_PX * f64::from(1 << halvings),
        };
        let windows = (depths as f64 / (4.0 * PI * window_px * window_px)).max(1.0);
        ((sigma_mm * sigma_mm - shared_mm * shared_mm) / windows).sqrt().hypot(shared_mm)
    }

    /// The map with the error that an aperture of this `blur_scale` brings to all depths: the difference of the squares of both
    /// blurs is K²β, so that K wrong by a part ε makes β wrong by 2εβ.
    #[must_use]
    pub fn with_error_of(mut self, blur_scale: &BlurScale) -> DepthMap {
        let part = 2.0 * blur_scale.sigma_px / blur_scale.optics.largest_blur_px();
        let known = self.sigma_mm.iter_mut().zip(&self.depth_mm).filter(|(_, depth)| depth.is_finite());
        for (sigma_mm, &depth_mm) in known {
            let depth_mm = f64::from(depth_mm);
            let beta = self.optics.beta(depth_mm);
            // Towards the lens, where no distance is infinite.
            let shared_mm = self.optics.depth_mm(beta + part * beta.abs()) - depth_mm;
            *sigma_mm = sigma_mm.hypot(shared_mm as f32);
        }
        self
    }

    /// Flags of each pixel, the bits of [`Flag`]; 0 where there is a depth.
    pub fn flags(&self) -> &[u8] {
        &self.flags
    }

    /// The pixels with a depth, in reading order: index of the pixel, and the point of the scene in mm, x right, y down,
    /// z away from the lens along the optical axis.
    pub fn points_mm(&self) -> impl Iterator<Item = (usize, [f64; 3])> {
        let centre = self.optics.principal_point(self.width, self.height);
        let known = self.depth_mm.iter().enumerate().filter(|(_, depth)| depth.is_finite());
        known.map(move |(at, &depth)| {
            let pixel = [(at % self.width) as f64, (at / self.width) as f64];
            (at, self.optics.point_mm(pixel, centre, f64::from(depth)))
        })
    }
}
