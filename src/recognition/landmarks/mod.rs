//! Landmarks: places and objects recognised by local appearance (paper A).
//!
//! Training: [`describe`] each exemplar, then [`Landmarks::train`]. Recognition: [`Landmarks::recognise`].
//! The steps stand in [`description`] (A§4.2–4.4), [`training`] (A§4.1) and [`vote`] (A§4.5).

pub mod annotated;
pub mod description;
pub mod model;
pub mod options;
pub mod parts;
#[cfg(test)]
mod pictures;
pub mod training;
pub mod vote;
pub mod warning;

pub use annotated::annotate;
pub use description::{DescribedExemplar, ExemplarName, describe};
pub use model::{Exemplar, Landmarks, Stage};
pub use options::{Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Taper, Viewpoint};
pub use parts::{LandmarkParts, PartsError};
pub use training::{TrainingError, TrainingReport};
pub use vote::{LabelVote, PointVote, Recognition};
pub use warning::Warning;
