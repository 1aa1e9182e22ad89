//! Where a camera stands, in metres: from exemplars whose poses are known, from flat landmarks, and over a way.

pub mod scene;
