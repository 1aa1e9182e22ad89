//! What is known of a rig: its optics, and what was measured with it.
//!
//! Level 0 is the optics alone. Level 1 adds registration and photometry from one textured target. Level 2 adds a
//! table from planes at known depths.

use thiserror::Error;

use super::monotone::MonotoneCurve;
use super::registration::{TiledFit, fitted_registration, scaling};
use super::{EstimateError, FocalPair, Method, Optics};

/// The pictures that a calibration holds for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    /// Width of both pictures.
    pub width_px: usize,
    /// Height of both pictures.
    pub height_px: usize,
    /// Bits a sample.
    pub bits: u8,
}

/// How the far-focused picture is brought into register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// `[a, b, c, d, e, f]`: the far pixel (a·x + b·y + c, d·x + e·y + f) shows what the near pixel (x, y) shows.
    pub affine_far_to_near: [f64; 6],
    /// What is left between both, in pixels.
    pub rms_px: f64,
}

/// Offsets and gain of the two sensors, in gray levels of 255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photometric {
    /// Level of the near-focused sensor in the dark.
    pub dark_near: f64,
    /// Level of the far-focused sensor in the dark.
    pub dark_far: f64,
    /// What the far-focused picture, without its dark level, is multiplied by.
    pub gain_far: f64,
}

/// Noise of a pixel: variance = read_sigma² + shot_gain · level, in gray levels of 255.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation in the dark.
    pub read_sigma: f64,
    /// Variance that each gray level adds: shot noise.
    pub shot_gain: f64,
}

/// The filters that the table was measured with.
#[derive(Clone, Debug, PartialEq)]
pub struct Filters {
    /// The method that has them.
    pub method: Method,
    /// K: side of the kernels in pixels; 0 if the method has none.
    pub side: usize,
    /// J: pairs of kernels; 0 if the method has none.
    pub rank: usize,
    /// Highest frequency that they let pass, cycles a pixel.
    pub band: f64,
    /// How often the pictures are halved first.
    pub halvings: u32,
    /// Sum over the kernels: a table is good for these alone.
    pub hash: String,
}

/// What the method measures of planes at known depths, and what is true, in the order of rising β.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// True β of the planes.
    pub beta: Vec<f64>,
    /// What the method measured, made monotone.
    pub raw: Vec<f64>,
    /// Standard deviation of `raw` over the plane.
    pub sigma: Vec<f64>,
    /// Known depths in mm.
    pub depth_mm: Vec<f64>,
}

/// How well the table of all other planes gives the depth of each plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Root of the mean square error of the left-out planes, in mm.
    pub rms_mm: f64,
    /// The largest error of a left-out plane, in mm.
    pub max_mm: f64,
}

/// All that is known of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// The optics that depths are measured with: stated, or fitted to a sweep.
    pub optics: Optics,
    /// The optics as stated, if it was fitted since.
    pub stated: Option<Optics>,
    /// The pictures that it holds for; any size at level 0.
    pub image: Option<ImageSize>,
    /// Measured registration (level 1).
    pub registration: Option<Registration>,
    /// Dark levels and gain, if dark or flat pictures were given (level 1).
    pub photometric: Option<Photometric>,
    /// Noise as the sweep measured it (level 2, `gram` only).
    pub noise: Option<Noise>,
    /// The filters that the table is for (level 2).
    pub filters: Option<Filters>,
    /// The table of the sweep (level 2).
    pub table: Option<Table>,
    /// The error of the table on planes left out of it (level 2).
    pub residual: Option<Residual>,
}

/// Pictures for level 1. Dark and flat ones come in pairs of near and far, each of the target's size.
#[derive(Clone, Debug)]
pub struct RegistrationTarget {
    /// A textured target within the working range.
    pub target: FocalPair,
    /// Mean levels of the two sensors in the dark, gray levels of 255.
    pub dark: Option<[f64; 2]>,
    /// Mean levels of the two sensors before an evenly lit white surface.
    pub flat: Option<[f64; 2]>,
}

/// Why a registration is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RegistrationError {
    /// The texture fixes too few displacements for an affine map.
    #[error(
        "the target has too little texture to register by: {usable} of {tiles} parts of the picture could be used"
    )]
    TooLittleTexture {
        /// Parts of the picture whose texture fixes a displacement.
        usable: usize,
        /// All parts.
        tiles: usize,
    },
    /// No affine map brings the pictures together.
    #[error("the pictures can't be brought closer than {rms_px:.3} px; at most {most_px} px are taken")]
    TooFarOff {
        /// What the fit leaves, root of the mean square.
        rms_px: f64,
        /// The most that is accepted.
        most_px: f64,
    },
    /// Dark and flat pictures contradict each other.
    #[error("the flat pictures are no brighter than the dark ones")]
    FlatNotBright,
}

impl ImageSize {
    /// Whether a pair has this size.
    pub(super) fn check(self, pair: &FocalPair) -> Result<(), EstimateError> {
        let (width_px, height_px) = (pair.width(), pair.height());
        if (self.width_px, self.height_px) == (width_px, height_px) {
            return Ok(());
        }
        let (calibrated_width_px, calibrated_height_px) = (self.width_px, self.height_px);
        Err(EstimateError::OtherSize { calibrated_width_px, calibrated_height_px, width_px, height_px })
    }
}

impl Table {
    /// From what the method measures to β; planes of equal measurements are one point.
    pub(super) fn curve(&self) -> MonotoneCurve {
        MonotoneCurve::inverse_through(&self.raw, &self.beta)
    }
}

impl Calibration {
    /// Level 0: nothing but the optics.
    pub fn of(optics: Optics) -> Calibration {
        Calibration {
            optics,
            stated: None,
            image: None,
            registration: None,
            photometric: None,
            noise: None,
            filters: None,
            table: None,
            residual: None,
        }
    }

    /// Level 1: registration and photometry from a target. A table measured before is dropped: it was measured with
    /// another registration.
    ///
    /// # Errors
    /// [`RegistrationError`].
    pub fn registered(&self, target: &RegistrationTarget) -> Result<Calibration, RegistrationError> {
        let [dark_near, dark_far] = target.dark.unwrap_or_default();
        let photometric = match (target.dark, target.flat) {
            (None, None) => None,
            (_, None) => Some(Photometric { dark_near, dark_far, gain_far: 1.0 }),
            (_, Some([near, far])) if near > dark_near && far > dark_far => {
                Some(Photometric { dark_near, dark_far, gain_far: (near - dark_near) / (far - dark_far) })
            }
            (_, Some(_)) => return Err(RegistrationError::FlatNotBright),
        };
        let FocalPair { near, far, bits, .. } = &target.target;
        let (width_px, height_px) = (near.width(), near.height());
        let start = scaling(&self.optics, width_px, height_px);
        let TiledFit { fit, usable, tiles, .. } =
            fitted_registration(near, far, &start, self.optics.largest_blur_px(), TARGET_OVERLAPS);
        let fit = fit.ok_or(RegistrationError::TooLittleTexture { usable, tiles })?;
        let rms_px = fit.rms_px;
        if rms_px > MOST_RMS_PX {
            return Err(RegistrationError::TooFarOff { rms_px, most_px: MOST_RMS_PX });
        }
        Ok(Calibration {
            image: Some(ImageSize { width_px, height_px, bits: *bits }),
            registration: Some(fit),
            photometric,
            stated: self.stated,
            ..Calibration::of(self.optics)
        })
    }
}

/// Parts of a target begin a quarter of their side after each other.
const TARGET_OVERLAPS: usize = 4;
/// A rigid rig leaves less than this, and more costs more than the noise.
const MOST_RMS_PX: f64 = 0.1;
