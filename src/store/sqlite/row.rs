//! What stands between a row of SQLite and a row struct: times in microseconds, ids as text, checked integers.

use jiff::Timestamp;
use sqlx::Row;
use sqlx::sqlite::SqliteRow;
use uuid::Uuid;

use crate::store::CatalogueError;

/// SQLite's primary result codes for a file that is damaged or isn't a database.
const DAMAGED_CODES: [i64; 2] = [11, 26];

impl From<sqlx::Error> for CatalogueError {
    /// Tells what may heal by itself (away, busy, disk full) from what never will.
    fn from(error: sqlx::Error) -> Self {
        let what = match &error {
            sqlx::Error::Database(reported) => {
                // The low byte of SQLite's extended result code is the primary one.
                let code = reported.code().and_then(|code| code.parse::<i64>().ok()).map(|code| code & 0xff);
                if code.is_some_and(|code| DAMAGED_CODES.contains(&code)) {
                    "the file is damaged"
                } else if reported.kind() != sqlx::error::ErrorKind::Other {
                    "a row breaks a constraint"
                } else {
                    return Self::Unavailable { source: error.into() };
                }
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

/// The present moment in microseconds: what the time columns hold.
pub fn now_us() -> i64 {
    Timestamp::now().as_microsecond()
}

/// An unsigned size as a column holds it; nothing that fits a disk saturates.
pub fn to_column(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

/// Reads an integer column that can't be negative, or can't be above its type's limit.
pub fn unsigned<T: TryFrom<i64>>(row: &SqliteRow, column: &str) -> Result<T, CatalogueError> {
    let value: i64 = row.try_get(column)?;
    T::try_from(value).map_err(|_| corrupt(format!("{column} is {value}")))
}

/// Reads a time column.
pub fn time(row: &SqliteRow, column: &str) -> Result<Timestamp, CatalogueError> {
    to_timestamp(row.try_get(column)?, column)
}

/// Reads a time column that may be empty.
pub fn optional_time(row: &SqliteRow, column: &str) -> Result<Option<Timestamp>, CatalogueError> {
    let value: Option<i64> = row.try_get(column)?;
    value.map(|value_us| to_timestamp(value_us, column)).transpose()
}

/// Reads an id column.
pub fn id(row: &SqliteRow, column: &str) -> Result<Uuid, CatalogueError> {
    let text: &str = row.try_get(column)?;
    Uuid::try_parse(text).map_err(|source| CatalogueError::Corrupt {
        what: format!("{column} is {text:?}"),
        source: Some(source.into()),
    })
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
