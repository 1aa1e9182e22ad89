//! Cameras and rigid motions in space: what turns pixels into bearings, and bearings into metres.
//!
//! Conventions, those of REP 103 and REP 105: lengths in metres; a *body* frame has x forward, y left, z up; an *optical*
//! frame has z forward, x right, y down. `T_a_b` takes a point of frame b to frame a. Angles turn counter-clockwise about the
//! axis that they are named after: a heading (`yaw`) is 0 along the map's x axis and 90° along its y axis.

mod camera;
mod map_pose;
mod point_pair;
mod rigid;

pub use camera::{Camera, CameraFault};
pub use map_pose::{MapPose, optical_in_body};
pub use point_pair::PointPair;
pub use rigid::RigidTransform;

pub use glam::{DMat3, DQuat, DVec2, DVec3};
