//! Several processes of the real binary on one PostgreSQL and one S3-compatible bucket, both started here and private.
//!
//! Needs PostgreSQL's programs and `moto_server`, so every test is ignored unless asked for:
//! `cargo test --test fleet -- --ignored`. `.ci/run` installs both and does.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

#[expect(dead_code, reason = "shared with the store's own tests")]
mod bucket;
mod fleet;
mod jobs;
mod keys;
mod outages;
#[path = "../api/pictures.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod pictures;
#[expect(dead_code, reason = "shared with the store's own tests")]
mod postgres;
mod posting;
#[path = "../api/process.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod process;
mod sizing;
mod versions;
