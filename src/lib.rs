//! landmarkd: robots ask where they are and what they see; the answer comes with its evidence.
//!
//! The mathematics is the crate `landmarkd_core`. This crate is the service around it: stores, databases and their
//! versions, jobs, keys, HTTP, and the verbs of the binary. `ARCHITECTURE.md` is the map.

pub mod access;
pub mod bag;
pub mod client;
pub mod compute;
pub mod config;
pub mod connections;
pub mod database;
pub mod demo;
pub mod evaluate;
pub mod events;
pub mod http;
pub mod jobs;
pub mod keys;
pub mod problem;
pub mod serve;
pub mod store;
pub mod telemetry;
pub mod tls;
