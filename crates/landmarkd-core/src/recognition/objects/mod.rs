//! Objects: which one it is and how it is turned, by the appearance of the whole picture (paper B §5).
//!
//! Training: a [`Canvas`] makes each exemplar an [`Appearance`], then [`Objects::train`]. Recognition:
//! [`Objects::recognise`]. The steps stand in [`appearance`] (B(7)), [`training`] (B(8)–(13)), `manifold`
//! (the curve of an object's eigenpoints) and [`calibration`] (B(16)).

pub mod annotated;
pub mod appearance;
pub mod calibration;
mod cutout;
mod held_out;
mod manifold;
pub mod model;
mod object;
pub mod options;
pub mod parts;
#[cfg(test)]
mod pictures;
pub mod recognition;
pub mod reconstruction;
pub mod rehearsal;
pub mod report;
pub mod training;

pub use annotated::annotate;
pub use appearance::{Appearance, Canvas, SizeMismatch, common_size};
pub use calibration::{Calibration, Logistic};
pub use model::{Objects, Stage, ViewName};
pub use options::{Dimension, Distance, MAX_SIDE_PX, ObjectOptions, Resize, Search, Stages};
pub use parts::{ObjectPart, ObjectParts, PartsError};
pub use recognition::{Candidate, Decision, Pose, Recognition, Warning};
pub use reconstruction::Reconstruction;
pub use rehearsal::rehearsal;
pub use report::{Confusion, DimensionRate, Gap, HeldOut, ObjectReport, PoseErrors, TrainingReport};
pub use training::{TrainingError, View};

/// Parts of a database are made of these.
pub use crate::eigen::Eigenspace;
