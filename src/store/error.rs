//! What a call of the catalogue fails with, and what an error of a driver means.

use sqlx::error::{DatabaseError, ErrorKind};
use sqlx::postgres::PgDatabaseError;
use sqlx::sqlite::SqliteError;

/// SQLite's primary result code for a file that can't be written.
pub const SQLITE_READ_ONLY: i64 = 8;
/// SQLite's primary result codes for a file that is damaged or isn't a database.
const DAMAGED_FILE: [i64; 2] = [11, 26];
/// PostgreSQL's codes for damaged tables and indexes.
const DAMAGED_TABLE: [&str; 2] = ["XX001", "XX002"];
/// PostgreSQL's codes for a statement that doesn't fit the tables, and, among them, for one that isn't allowed.
const MISFIT_CLASS: &str = "42";
const NO_RIGHTS: &str = "42501";
/// PostgreSQL's codes for a character that it, or the encoding its database was made with, can't keep.
const NO_SUCH_CHARACTER: [&str; 2] = ["22021", "22P05"];

/// What a catalogue call can fail with.
///
/// The source of an error, where there is one, is the driver's own error.
#[derive(Debug, thiserror::Error)]
pub enum CatalogueError {
    /// The catalogue can't be reached or can't write now (away, busy, disk full); it may heal by itself.
    #[error("the catalogue is unavailable")]
    Unavailable {
        /// The driver's error.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The row that the call needs isn't there.
    #[error("{what} does not exist")]
    NotFound {
        /// The row, for people: what it is, and its name.
        what: String,
    },
    /// The catalogue's state forbids the call.
    #[error("{what}")]
    Conflict {
        /// Why, for people.
        what: String,
    },
    /// The alias or calibration isn't as the caller expected it.
    #[error("it is not at the expected revision")]
    PreconditionFailed,
    /// The job isn't running under this token any more: nothing was written.
    #[error("the lease on the job was lost")]
    LeaseLost,
    /// Somebody asked for the job to end before it did: nothing was written, and `Catalogue::cancelled_job` has to be
    /// called.
    #[error("the job was asked to end")]
    CancelRequested,
    /// A filter that must name something names nothing: absent never means all.
    #[error("the filter names no label, no robot and no time, nor whether negative")]
    EmptyFilter,
    /// What was read can't have been written by this program.
    #[error("the catalogue is corrupt: {what}")]
    Corrupt {
        /// What was read, for people.
        what: String,
        /// The driver's error, where it was the driver that noticed.
        #[source]
        source: Option<Box<dyn std::error::Error + Send + Sync>>,
    },
}

impl CatalogueError {
    /// The error for a value that was read and that this program never writes.
    pub(super) fn corrupt(what: String) -> Self {
        Self::Corrupt { what, source: None }
    }

    /// The error for a database that isn't there.
    pub(super) fn no_database(name: &str) -> Self {
        Self::NotFound { what: format!("database {name:?}") }
    }

    /// The error for a version that isn't there.
    pub(super) fn no_version(database: &str, version: i64) -> Self {
        Self::NotFound { what: format!("version {version} of database {database:?}") }
    }

    /// The error for a calibration that isn't there.
    pub(super) fn no_calibration(name: &str) -> Self {
        Self::NotFound { what: format!("calibration {name:?}") }
    }

    /// The error for the deletion of a version that is in use.
    pub(super) fn aliased(database: &str, version: i64, alias: &str) -> Self {
        Self::Conflict {
            what: format!("alias {alias:?} points to version {version} of database {database:?}"),
        }
    }
}

impl From<sqlx::Error> for CatalogueError {
    /// Tells what may heal by itself (away, busy, disk full) from what never will.
    fn from(error: sqlx::Error) -> Self {
        let what = match &error {
            error if is_damage(error) => "what is on the disk is damaged",
            sqlx::Error::Database(reported) if is_misfit(reported.as_ref()) => {
                "its tables are not what this release expects"
            }
            sqlx::Error::Database(reported) if reported.kind() != ErrorKind::Other => {
                "a row breaks a constraint"
            }
            sqlx::Error::Database(reported) if is_postgres(reported.as_ref(), &NO_SUCH_CHARACTER) => {
                return Self::Conflict {
                    what: "a text holds a character that PostgreSQL can't keep".to_owned(),
                };
            }
            sqlx::Error::ColumnDecode { .. }
            | sqlx::Error::Decode(_)
            | sqlx::Error::ColumnNotFound(_)
            | sqlx::Error::ColumnIndexOutOfBounds { .. }
            | sqlx::Error::TypeNotFound { .. } => "a column is not what it should be",
            _ => return Self::Unavailable { source: error.into() },
        };
        Self::Corrupt { what: what.to_owned(), source: Some(error.into()) }
    }
}

/// Whether PostgreSQL reported one of these codes.
pub fn is_postgres(reported: &dyn DatabaseError, codes: &[&str]) -> bool {
    reported.try_downcast_ref::<PgDatabaseError>().is_some_and(|reported| codes.contains(&reported.code()))
}

/// Whether the database found its own files damaged.
pub fn is_damage(error: &sqlx::Error) -> bool {
    let sqlx::Error::Database(reported) = error else { return false };
    let reported = reported.as_ref();
    if reported.try_downcast_ref::<PgDatabaseError>().is_some() {
        return is_postgres(reported, &DAMAGED_TABLE);
    }
    sqlite_code(reported).is_some_and(|code| DAMAGED_FILE.contains(&code))
}

/// What the database reported, if it was unavailable and did report something.
pub fn reported_unavailable(error: &CatalogueError) -> Option<&dyn DatabaseError> {
    let CatalogueError::Unavailable { source } = error else { return None };
    let Some(sqlx::Error::Database(reported)) = source.downcast_ref() else { return None };
    Some(reported.as_ref())
}

/// Whether SQLite has the file open for reading only.
pub fn is_read_only(error: &CatalogueError) -> bool {
    let Some(reported) = reported_unavailable(error) else { return false };
    sqlite_code(reported) == Some(SQLITE_READ_ONLY)
}

/// SQLite's primary result code: the low byte of the extended one.
pub fn sqlite_code(reported: &dyn DatabaseError) -> Option<i64> {
    reported.try_downcast_ref::<SqliteError>()?;
    reported.code()?.parse::<i64>().ok().map(|code| code & 0xff)
}

/// Whether PostgreSQL finds a statement wrong, for good: rights that are missing may be granted again.
fn is_misfit(reported: &dyn DatabaseError) -> bool {
    reported
        .try_downcast_ref::<PgDatabaseError>()
        .is_some_and(|reported| reported.code().starts_with(MISFIT_CLASS) && reported.code() != NO_RIGHTS)
}
