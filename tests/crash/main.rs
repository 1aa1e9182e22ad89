//! Nothing acknowledged is lost, whatever happens to the process, its disk or its files: the real binary over a folder
//! of its own, killed, starved and damaged.
//!
//! A part of the rounds runs by default; all of them, with figures, by
//! `cargo test --release --test crash -- --ignored --nocapture --test-threads 1`.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

mod backups;
mod client;
mod corruption;
mod disk;
mod faults;
mod kills;
#[path = "../api/pictures.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod pictures;
#[path = "../api/process.rs"]
#[expect(dead_code, reason = "shared with the tests of the API and of a fleet")]
mod process;
mod scenario;
mod sweep;
