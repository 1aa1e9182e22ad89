//! Objects: which one it is and its pose, by the appearance of the whole picture (paper B §5).
//!
//! Training: a [`Normaliser`] makes each exemplar an [`Appearance`], then [`train`]. Recognition:
//! [`Objects::recognise`]. The steps: [`appearance`] (B(7)), [`training`] (B(8)–(13)), `manifold` (the curve of an
//! object's eigenpoints), `held_out` and [`acceptance`] (B(16)).

pub mod acceptance;
mod aligned_trials;
mod alignment;
pub mod annotated;
pub mod appearance;
pub mod disturbance;
mod held_out;
mod hypothesis;
mod manifold;
pub mod model;
mod normalised_crop;
mod object;
pub mod options;
pub mod parts;
mod ranked_object;
pub mod reason;
pub mod recognition;
pub mod reconstruction;
pub mod report;
pub mod synthetic_view;
#[cfg(test)]
mod test_pictures;
pub mod training;

pub use acceptance::{Acceptance, Logistic};
pub use annotated::annotate;
pub use appearance::{Appearance, Normaliser, SizeMismatch, common_size, common_step_deg};
pub use model::{Objects, Stage, ViewName};
pub use options::{AppearanceOf, Dimension, Distance, MAX_SIDE_PX, ObjectOptions, Resize, Search, Stages};
pub use parts::{ObjectPart, ObjectParts, PartsError};
pub use reason::Reason;
pub use recognition::{Alignment, Candidate, Decision, Pose, Recognition, Warning};
pub use reconstruction::Reconstruction;
pub use report::{Confusion, DimensionRate, Gap, HeldOut, ObjectReport, PoseErrors, TrainingReport};
pub use synthetic_view::{ViewSample, recognises_view, synthetic_view};
pub use training::{TrainingError, View, is_trial, train};

/// Parts of a database are made of these.
pub use crate::eigen::Eigenspace;
