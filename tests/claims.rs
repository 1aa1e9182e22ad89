//! The papers' claims as executable sentences, on real pictures.
//!
//! The pictures are read from the folder that the environment variable `LANDMARKD_DATA` names; claims that need it are
//! ignored unless asked for. Trials are drawn with fixed seeds, so that every run sees the same frames. All claims with
//! their figures: `LANDMARKD_DATA=… cargo test --release --test claims -- --include-ignored --nocapture`.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

#[path = "claims/composites.rs"]
mod composites;
#[path = "claims/data.rs"]
mod data;
#[path = "claims/depth.rs"]
mod depth;
#[path = "claims/drawn_tables.rs"]
mod drawn_tables;
#[path = "claims/objects.rs"]
mod objects;
#[path = "claims/parts.rs"]
mod parts;
#[path = "claims/placement.rs"]
mod placement;
#[path = "claims/places.rs"]
mod places;
#[path = "claims/plates.rs"]
mod plates;
#[path = "claims/random.rs"]
mod random;
#[path = "claims/real.rs"]
mod real;
#[path = "claims/rigs.rs"]
mod rigs;
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
