//! What stands between a database's row and a row struct, whichever database: times in microseconds, checked
//! integers, and what an error of the driver means.

use jiff::Timestamp;
use sqlx::error::{DatabaseError, ErrorKind};
use sqlx::postgres::PgDatabaseError;
use sqlx::sqlite::SqliteError;
use sqlx::{ColumnIndex, Decode, Row, Type};

use super::CatalogueError;

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

/// Whether SQLite has the file open for reading only.
pub fn is_read_only(error: &sqlx::Error) -> bool {
    let sqlx::Error::Database(reported) = error else { return false };
    sqlite_code(reported.as_ref()) == Some(SQLITE_READ_ONLY)
}

/// SQLite's primary result code: the low byte of the extended one.
pub fn sqlite_code(reported: &dyn DatabaseError) -> Option<i64> {
    reported.try_downcast_ref::<SqliteError>()?;
    reported.code()?.parse::<i64>().ok().map(|code| code & 0xff)
}

/// Whether PostgreSQL finds a statement wrong: no waiting mends that. Rights may be given back.
fn is_misfit(reported: &dyn DatabaseError) -> bool {
    reported
        .try_downcast_ref::<PgDatabaseError>()
        .is_some_and(|reported| reported.code().starts_with(MISFIT_CLASS) && reported.code() != NO_RIGHTS)
}

/// An unsigned size as a column holds it; nothing that fits a disk saturates.
pub fn to_column(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// Reads an integer column that can't be negative, or can't be above its type's limit.
pub fn unsigned<T: TryFrom<i64>, R: Row>(row: &R, column: &str) -> Result<T, CatalogueError>
where
    for<'r> i64: Decode<'r, R::Database> + Type<R::Database>,
    for<'c> &'c str: ColumnIndex<R>,
{
    let value: i64 = row.try_get(column)?;
    T::try_from(value).map_err(|_| corrupt(format!("{column} is {value}")))
}

/// Reads a time column.
pub fn time<R: Row>(row: &R, column: &str) -> Result<Timestamp, CatalogueError>
where
    for<'r> i64: Decode<'r, R::Database> + Type<R::Database>,
    for<'c> &'c str: ColumnIndex<R>,
{
    to_timestamp(row.try_get(column)?, column)
}

/// Reads a time column that may be empty.
pub fn optional_time<R: Row>(row: &R, column: &str) -> Result<Option<Timestamp>, CatalogueError>
where
    for<'r> i64: Decode<'r, R::Database> + Type<R::Database>,
    for<'c> &'c str: ColumnIndex<R>,
{
    let value: Option<i64> = row.try_get(column)?;
    value.map(|value_us| to_timestamp(value_us, column)).transpose()
}

/// The error for a value that was read and can't be.
pub fn corrupt(what: String) -> CatalogueError {
    CatalogueError::Corrupt { what, source: None }
}

fn to_timestamp(value_us: i64, column: &str) -> Result<Timestamp, CatalogueError> {
    Timestamp::from_microsecond(value_us).map_err(|source| CatalogueError::Corrupt {
        what: format!("{column} is {value_us}"),
        source: Some(source.into()),
    })
}
