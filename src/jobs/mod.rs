//! Jobs: long work that survives a restart. The queue, the runner, and one file per kind of job.
//!
//! A job is a row of the catalogue. Whoever claims it holds a lease and a token; a worker that lost its lease can
//! finish nothing, so a job ends exactly once. Every change of a job is an event with a number, kept with it.

mod lease;
mod queue;
mod runner;
mod stop;
mod sweep;
mod training;
mod worker;

pub use lease::WORKER_LEASE;
pub use queue::{JobError, Jobs};
pub use runner::Runner;
pub use stop::Failure;
pub use sweep::{SweepParams, SweepPlane};
pub use training::{EigenspaceChoice, Promote, SelfCheck, TrainingParams, UnfitExemplars, VersionComparison};
