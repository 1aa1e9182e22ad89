//! Everything the service keeps: the catalogue (rows, in SQLite or PostgreSQL) and the blobs (bytes, in a folder or a
//! bucket).
//!
//! Write order is the whole protocol: the blob first, then its row, then the alias, the last two in one
//! transaction. A crash leaves at most an orphan blob, which `Blobs::collect_orphans` removes by age.
//! This is the only room that knows `sqlx` and `object_store`, and the only one that touches the disk.

mod audit;
mod backup;
mod blobs;
mod bucket;
mod cache;
mod catalogue;
mod folder;
mod job_end;
mod open;
mod outage;
mod postgres;
mod row;
mod sqlite;
#[cfg(test)]
mod suite;
/// A private bucket, shared with the tests of whole processes.
#[cfg(test)]
#[path = "../../tests/fleet/bucket.rs"]
mod test_bucket;

pub use audit::{Actor, AuditFilter, AuditRow};
pub use backup::{Backup, BackupError, back_up, catalogue_faults};
pub use blobs::{BlobError, BlobName, Blobs, Collected};
pub use bucket::{OpenBucketError, open_bucket};
pub use catalogue::{
    AliasExpectation, AliasRow, AliasTarget, CalibrationRow, Catalogue, CatalogueError, DatabaseCounts,
    DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow, JobFilter, JobRow, JobState, KeyRow, NewKey,
    NewVersion, ProcessRow, Progress, Renewal, Turn, UnknownJobState, VersionRow, WorkcellRow,
};
pub use folder::{Folder, OpenFolderError, open_beside, open_folder};
pub use open::OpenCatalogueError;
pub use outage::outage;
pub use postgres::open_postgres;
