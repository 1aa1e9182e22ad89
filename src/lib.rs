//! landmarkd: robots ask where they are and what they see; the answer comes with its evidence.
//!
//! The crate docs are the map of the house; `ARCHITECTURE.md` walks through it.
//! Pure mathematics in the middle (`imaging`, `vision`, `eigen`, `depth`, `recognition`, `workcell`),
//! waiting and talking at the rim (`store`, `access`, `database`, `jobs`, `http`).

pub mod access;
pub mod compute;
pub mod config;
pub mod connections;
pub mod database;
pub mod demo;
pub mod evaluate;
pub mod http;
pub mod jobs;
pub mod keys;
pub mod serve;
pub mod store;
pub mod telemetry;
pub mod tls;
