//! Where a camera stands, in metres: from exemplars whose poses are known, from flat landmarks, and over a way.

mod essential;
mod least_squares;
pub mod place;
pub mod scene;
pub mod two_view;

pub use place::{PlaceMethod, PlacePose, PlaceView, locate};
pub use two_view::{TwoView, relative_pose};
