//! The real binary under load: too much of it, rude clients, days of work in minutes, a training beside recognition, and in memory.
//!
//! Client and service share the machine, and time is what is measured, so every test is ignored unless asked for, one
//! at a time and optimised: `cargo test --release --test load -- --ignored --nocapture --test-threads 1`. Each prints
//! its figures, and asserts counts, ratios within the run, and bounds with room to spare. `LANDMARKD_LOAD_SECONDS` (60),
//! `LANDMARKD_LOAD_RECOGNITIONS` (50000) and `LANDMARKD_LOAD_PUBLISHES` (200) make them shorter.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

mod client;
mod figures;
mod memory;
mod overload;
#[path = "../api/pictures.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod pictures;
#[path = "../api/process.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod process;
mod rude;
mod service;
mod soak;
mod training;
