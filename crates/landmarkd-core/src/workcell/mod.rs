//! The workcell (B§2–3, Figure 1): every part on the table found, recognised, and located in the robot's plane.
//!
//! The overview camera sees the table; a [`Mapping`] takes its pixels to the robot's millimetres. The local camera, at
//! the gripper, centres: [`centring`].

mod annotated;
mod centring;
mod diagnosis;
mod distance;
mod inspection;
mod mapping;

pub use annotated::{annotate, annotate_regions};
pub use centring::{Centring, LocalCamera, centring};
pub use diagnosis::{Suspect, leave_one_out_mm, residuals_mm, suspect};
pub use distance::PartDistance;
pub use inspection::{
    Inspection, InspectionError, PairScene, PairView, Part, Stage, Warning, inspect, inspect_with_depth,
};
pub use mapping::{Correspondence, Mapping, MappingError, MappingKind};

use crate::vision::OptionFault;
use crate::vision::segmentation::SegmentationOptions;

const MAX_TOLERANCE_PX: f64 = 1000.0;
const MAX_MM_PER_PX: f64 = 1e6;
const MAX_ROTATION_DEG: f64 = 360.0;

/// A workcell, beside the database that recognises its parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Workcell {
    /// From the overview camera's pixels to the robot.
    pub mapping: Mapping,
    /// Whether the robot's Y grows where the image's y falls, as seen by both cameras.
    pub flip_y: bool,
    /// The camera at the gripper, if it is known.
    pub local: Option<LocalCamera>,
    /// A part counts as centred within so many pixels, along the straight line.
    pub tolerance_px: f64,
    /// For the pictures of both cameras.
    pub segmentation: SegmentationOptions,
}

/// Everything that is wrong with the local camera and the tolerance. Mapping and segmentation have checks of their own.
pub fn faults(local: Option<LocalCamera>, tolerance_px: f64) -> Vec<OptionFault> {
    let mut faults = Vec::new();
    let mut fault = |option, message| faults.push(OptionFault { option, message });
    if !(0.0..=MAX_TOLERANCE_PX).contains(&tolerance_px) {
        fault("tolerance_px", format!("{tolerance_px} is not in 0..={MAX_TOLERANCE_PX}"));
    }
    if let Some(LocalCamera { mm_per_px, rotation_deg }) = local {
        if !(mm_per_px > 0.0 && mm_per_px <= MAX_MM_PER_PX) {
            fault("local/mm_per_px", format!("{mm_per_px} is not above 0, and at most {MAX_MM_PER_PX}"));
        }
        if !(-MAX_ROTATION_DEG..=MAX_ROTATION_DEG).contains(&rotation_deg) {
            fault("local/rotation_deg", format!("{rotation_deg} is not within ±{MAX_ROTATION_DEG}"));
        }
    }
    faults
}
