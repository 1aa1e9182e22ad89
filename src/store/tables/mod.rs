//! The catalogue's tables, one file each: its rows, and the statements on it, which take a connection.
//!
//! Rows are the shape on the disk: documents stand in them as JSON text, and nothing here checks a name or an option;
//! the callers above do. Which statements make a transaction, and in which order they lock, [`super::Catalogue`]
//! decides. Lists are pages: `after` is the key of the last row seen, `limit` the most rows to give.

pub mod aliases;
pub mod audit;
pub mod calibrations;
pub mod cameras;
pub mod databases;
pub mod exemplars;
pub mod job_events;
pub mod job_row;
pub mod job_state;
pub mod jobs;
pub mod keys;
pub mod named_documents;
pub mod processes;
pub mod versions;
pub mod workcells;
