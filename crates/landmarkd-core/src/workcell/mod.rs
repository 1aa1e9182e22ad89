//! The workcell (B§2–3, Figure 1): every part on the table found, named, and located where the robot reaches.
//!
//! The overview camera sees the table; a [`Mapping`] takes its pixels to the robot's millimetres. The local camera, at
//! the gripper, centres: [`centring`].

mod annotated;
mod centring;
mod distance;
mod inspection;
mod mapping;

pub use annotated::{annotate, annotate_regions};
pub use centring::{Centring, LocalCamera, centring};
pub use distance::Distance;
pub use inspection::{Inspection, Part, Stage, inspect};
pub use mapping::{Correspondence, Mapping, MappingError, MappingKind};

use crate::vision::OptionFault;
use crate::vision::segmentation::SegmentationOptions;

/// The largest tolerance.
const MAX_TOLERANCE_PX: f64 = 1000.0;
/// The largest scale and turn of a local camera.
const MAX_LOCAL: LocalCamera = LocalCamera { mm_per_px: 1e6, rotation_deg: 360.0 };

/// What is known of a workcell, beside the database that names its parts.
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
    /// Of both cameras' pictures.
    pub segmentation: SegmentationOptions,
}

/// What can't be, of what stands beside the mapping and the segmentation, which are judged by their own rooms.
pub fn faults(local: Option<LocalCamera>, tolerance_px: f64) -> Vec<OptionFault> {
    let mut faults = Vec::new();
    let mut fault = |option, message| faults.push(OptionFault { option, message });
    if !(0.0..=MAX_TOLERANCE_PX).contains(&tolerance_px) {
        fault("tolerance_px", format!("{tolerance_px} is not in 0..={MAX_TOLERANCE_PX}"));
    }
    if let Some(LocalCamera { mm_per_px, rotation_deg }) = local {
        let most = MAX_LOCAL;
        if !(mm_per_px > 0.0 && mm_per_px <= most.mm_per_px) {
            let message = format!("{mm_per_px} is not above 0, and at most {}", most.mm_per_px);
            fault("local/mm_per_px", message);
        }
        if !(-most.rotation_deg..=most.rotation_deg).contains(&rotation_deg) {
            fault("local/rotation_deg", format!("{rotation_deg} is not within ±{}", most.rotation_deg));
        }
    }
    faults
}
