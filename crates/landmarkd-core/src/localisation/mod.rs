//! Where a camera stands, in metres: from exemplars whose poses are known, from flat landmarks, and over a way.

pub mod edge_alignment;
pub mod planar_pose;
pub mod pose_filter;
pub mod scene;
