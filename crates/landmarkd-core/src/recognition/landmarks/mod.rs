//! Landmarks: places and objects recognised by local appearance (paper A).
//!
//! Training: [`describe`] each exemplar, then [`Landmarks::train`]. Recognition: [`Landmarks::recognise`].
//! Recognitions along a robot's way add up to a [`Belief`].
//! The steps stand in [`description`] (A§4.2–4.4), [`training`] (A§4.1) and [`vote`] (A§4.5).

pub mod annotated;
pub mod belief;
pub mod confidence;
mod consensus;
pub mod contour;
pub mod description;
mod matching;
pub mod model;
mod naive_bayes;
mod opinion;
pub mod options;
pub mod parts;
#[cfg(test)]
mod pictures;
pub mod placement;
mod prior;
mod recognise;
pub mod recognition;
pub mod rehearsal;
mod standing;
pub mod training;
mod vote;
pub mod warning;

pub use annotated::annotate;
pub use belief::{Belief, LabelBelief, Motion};
pub use confidence::{Confidence, Evidence, Rehearsed, Reliability, ReliabilityBin};
pub use contour::ContourPoint;
pub use description::{DescribedExemplar, ExemplarName, Window, describe};
pub use model::{Exemplar, Landmarks};
pub use options::{Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Taper, Viewpoint};
pub use parts::{LandmarkParts, PartsError};
pub use placement::Placement;
pub use recognise::Stage;
pub use recognition::{Decision, Instance, LabelVote, Placed, PointVote, Recognition};
pub use rehearsal::{Rehearsal, rehearsals};
pub use training::{TrainingError, TrainingReport};
pub use warning::Warning;
