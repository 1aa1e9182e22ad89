//! Where a camera stands, in metres: from exemplars whose poses are known, from flat landmarks, and over a way.

mod edge_alignment;
mod essential;
mod least_squares;
pub mod place;
mod planar_pose;
mod pose_filter;
pub mod scene;
pub mod two_view;

pub use edge_alignment::located;
pub use place::{PlaceMethod, PlacePose, PlaceView, locate};
pub use planar_pose::{PlanarPose, PlanarPoses, Sighting, on_plane, solve};
pub use pose_filter::{Estimate, Odometry, PlanePose, PoseFilter};
pub use two_view::{TwoView, relative_pose};
