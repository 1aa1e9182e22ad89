//! Landmarks: places and objects recognised by local appearance (paper A).
//!
//! Training: [`describe`] each exemplar, then [`Landmarks::train`]. Recognition: [`Landmarks::recognise`].
//! Recognitions along a robot's way add up to a [`Belief`].
//! The steps stand in [`description`] (A§4.2–4.4), [`training`] (A§4.1) and [`vote`] (A§4.5).

pub mod annotated;
pub mod belief;
pub mod confidence;
mod consensus;
mod dead_leaves;
pub mod description;
pub mod edge_template;
pub mod held_out;
pub mod homography;
pub mod leave_one_out;
mod matching;
pub mod model;
mod multiscale;
mod naive_bayes;
pub mod options;
pub mod parts;
#[cfg(test)]
mod pictures;
pub mod placement;
mod position_prior;
mod query;
pub mod reason;
mod recognise;
pub mod recognition;
mod search;
pub mod synthetic_view;
pub mod training;
mod verification;
mod vote;
mod vote_result;
pub mod warning;

pub use annotated::annotate;
pub use belief::{Belief, LabelBelief, Motion};
pub use confidence::{CalibrationSample, Confidence, Evidence, Reliability, ReliabilityBin};
pub use description::{DescribedExemplar, ExemplarName, Window, describe};
pub use edge_template::EdgePoint;
pub use held_out::{CalibrationPlan, calibration_samples, correct_decisions, names_rightly};
pub use homography::Homography;
pub use leave_one_out::{LeftOut, exemplars_to_leave_out, left_out};
pub use model::{Exemplar, Landmarks};
pub use multiscale::asked_frame::{AskedFrame, KeptExemplar};
pub use multiscale::window_space::{EncodedExemplar, WindowSample, WindowSpace, residual_of, sample_plan};
pub use options::{
    Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Preset, Signature, Taper, Viewpoint,
};
pub use parts::{EncodedParts, LandmarkParts, PartsError, PlainParts, WindowParts};
pub use placement::Placement;
pub use reason::Reason;
pub use recognition::{
    AContrario, AgreeingExemplar, Also, Decision, Instance, LabelVote, PointVote, Recognition, Stage,
    VerifiedPlacement,
};
pub use synthetic_view::{SyntheticView, synthetic_views};
pub use training::{TrainingError, TrainingReport};
pub use warning::Warning;
