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

use crate::vision::segmentation::SegmentationOptions;

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
