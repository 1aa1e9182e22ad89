//! Everything the service keeps: the catalogue (rows, in SQLite or PostgreSQL) and the blobs (bytes, in a folder or a
//! bucket).
//!
//! Write order is the whole protocol: the blob first, then its row, then the alias, the last two in one
//! transaction. A crash leaves at most an orphan blob, which `collect_orphans` removes by age.
//! This is the only room that knows `sqlx` and `object_store`, and the only one that touches the disk.

mod advice;
mod backup;
mod blob_error;
mod blob_name;
mod blobs;
mod bucket;
mod cache;
mod catalogue;
mod descriptions;
mod error;
mod file_lock;
mod folder;
mod open;
mod orphans;
mod postgres;
mod query;
mod session;
mod sqlite;
#[cfg(test)]
mod suite;
mod tables;
/// A private bucket, shared with the tests of whole processes.
#[cfg(test)]
#[path = "../../tests/fleet/bucket.rs"]
mod test_bucket;
mod upload;

pub use advice::operator_advice;
pub use backup::{Backup, BackupError, back_up, catalogue_faults};
pub use blob_error::BlobError;
pub use blob_name::{BlobName, InvalidBlobName};
pub use blobs::Blobs;
pub use bucket::{OpenBucketError, open_bucket};
pub use catalogue::{Catalogue, CollectionGuard, open_postgres};
pub use descriptions::{DescriptionKey, Descriptions};
pub use error::CatalogueError;
pub use folder::{Folder, OpenFolderError, open_folder, open_unlocked_folder};
pub use open::OpenCatalogueError;
pub use orphans::{OrphanCollection, collect_orphans};
pub use tables::aliases::{AliasExpectation, AliasRow, AliasTarget};
pub use tables::audit::{Actor, AuditFilter, AuditRow};
pub use tables::calibrations::CalibrationRow;
pub use tables::databases::{DatabaseCounts, DatabaseRow};
pub use tables::exemplars::{ExemplarFilter, ExemplarRow};
pub use tables::job_events::JobEventRow;
pub use tables::job_row::{JobRow, Progress};
pub use tables::job_state::{JobState, UnknownJobState};
pub use tables::jobs::{JobFilter, Renewal};
pub use tables::keys::{KeyRow, NewKey};
pub use tables::named_documents::NamedDocument;
pub use tables::processes::ProcessRow;
pub use tables::versions::{NewVersion, VersionRow};
