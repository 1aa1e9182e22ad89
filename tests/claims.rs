//! The papers' claims as executable sentences, on real pictures.
//!
//! The pictures are read from the folder that the environment variable `LANDMARKD_DATA` names; without it each
//! claim says that it was skipped. Trials are drawn with fixed seeds, so that every run sees the same frames.
//! Run with `cargo test --release --test claims -- --nocapture` to see the figures.

#[path = "claims/composites.rs"]
mod composites;
#[path = "claims/data.rs"]
mod data;
#[path = "claims/depth.rs"]
mod depth;
#[path = "claims/objects.rs"]
mod objects;
#[path = "claims/placement.rs"]
mod placement;
#[path = "claims/places.rs"]
mod places;
#[path = "claims/random.rs"]
mod random;
#[path = "claims/table.rs"]
mod table;
#[path = "claims/table_scene.rs"]
mod table_scene;
#[path = "claims/trials.rs"]
mod trials;
#[path = "claims/turntable.rs"]
mod turntable;
#[path = "claims/upright.rs"]
mod upright;
#[path = "claims/workcell.rs"]
mod workcell;
