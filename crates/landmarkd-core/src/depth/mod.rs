//! Metric depth from two pictures that differ in focus or in aperture (B§4): optics, registration, three estimators,
//! calibration. *Near* is the first picture of [`Optics`], *far* the second, also where they differ in aperture.
//!
//! Lengths in mm from the lens' principal plane, pixels as everywhere: x right, y down, the origin at the centre of
//! the top-left one. A depth is the distance along the optical axis. Gray levels are 0..=255 and linear in light. β in
//! [−1, 1] says where between the two sensors a point is sharp: +1 on the near-focused one, −1 on the far-focused one.

mod blur_scale;
mod brightness;
mod calibration;
mod dense_map;
mod depth_map;
mod estimate;
mod estimator;
mod fault;
mod filtering;
mod focal_pair;
mod focus_stack;
mod gram;
mod kernels;
mod laplacian;
mod monotone;
mod optics;
mod options;
mod otf;
mod prediction;
mod registration;
mod resampling;
pub mod scene;
mod selection;
mod spread;
mod stm;
mod sweep;
mod windows;

pub use blur_scale::{BlurScale, BlurScaleError, blur_scale};
pub use calibration::{
    Calibration, Filters, ImageSize, Noise, Photometric, Registration, RegistrationError, RegistrationTarget,
    Residual, Table,
};
pub use depth_map::{DepthMap, DepthSpan, Flag, Summary, Warning};
pub use estimator::{EstimateError, Estimator, EstimatorError, Stage};
pub use fault::Fault;
pub use focal_pair::{FocalPair, PairError};
pub use focus_stack::{FocusStack, STACK_PICTURES, StackEstimator, StackOptics, StackSpec};
pub use optics::{Aperture, Optics, OpticsSpec, Pair, Sensor};
pub use options::{DepthOptions, Median, Method, Window};
pub use prediction::{Expected, Prediction, Scenery, predicted};
pub use sweep::{MAX_PLANES, MIN_PLANES, Sweep, SweepError};
