//! Where a camera stands, in metres: from exemplars whose poses are known, from flat landmarks, and over a way.

mod essential;
mod least_squares;
pub mod place;
mod pose_filter;
pub mod scene;
pub mod two_view;

pub use place::{PlaceMethod, PlacePose, PlaceView, locate};
pub use pose_filter::{Estimate, Odometry, PlanePose, PoseFilter};
pub use two_view::{TwoView, relative_pose};
