//! Everything the service keeps: the catalogue (rows, in SQLite) and the blobs (bytes, in a folder).
//!
//! Write order is the whole protocol: the blob first, then its row, then the alias, the last two in one
//! transaction. A crash leaves at most an orphan blob, which `Blobs::collect_orphans` removes by age.
//! This is the only room that knows `sqlx` and `object_store`, and the only one that touches the disk.

mod blobs;
mod catalogue;
mod folder;
mod sqlite;
#[cfg(test)]
mod suite;

pub use blobs::{BlobError, BlobName, Blobs};
pub use catalogue::{
    AliasExpectation, AliasRow, AliasTarget, CalibrationRow, Catalogue, CatalogueError, DatabaseCounts,
    DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow, JobFilter, JobRow, JobState, NewVersion, Progress,
    Renewal, UnknownJobState, VersionRow, WorkcellRow,
};
pub use folder::{Folder, OpenFolderError, open_folder};
pub use sqlite::OpenCatalogueError;
