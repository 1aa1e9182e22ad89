//! What SQLite has no type for: ids as text, and the clock of this process.

use jiff::Timestamp;
use sqlx::Row;
use sqlx::sqlite::SqliteRow;
use uuid::Uuid;

use crate::store::CatalogueError;

/// The present moment in microseconds: what the time columns hold.
pub fn now_us() -> i64 {
    Timestamp::now().as_microsecond()
}

/// Reads an id column.
pub fn id(row: &SqliteRow, column: &str) -> Result<Uuid, CatalogueError> {
    let text: &str = row.try_get(column)?;
    Uuid::try_parse(text).map_err(|source| CatalogueError::Corrupt {
        what: format!("{column} is {text:?}"),
        source: Some(source.into()),
    })
}
