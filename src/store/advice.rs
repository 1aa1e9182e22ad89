//! What an operator can do about a store that can't be used now.

use std::error::Error;
use std::io;

use super::error::{SQLITE_READ_ONLY, is_postgres, sqlite_code};

/// SQLite's primary result code for a full disk.
const SQLITE_FULL: i64 = 13;
/// PostgreSQL's code for a full disk, and the one for a server that takes no writes.
const POSTGRES_FULL: &[&str] = &["53100"];
const POSTGRES_READ_ONLY: &[&str] = &["25006"];

/// Why a store can't be used now, and what to do, for people; from an error and its causes.
pub fn operator_advice(error: &(dyn Error + 'static)) -> &'static str {
    std::iter::successors(Some(error), |&error| error.source())
        .find_map(known)
        .unwrap_or("it can't be reached: look after its disk or its connection")
}

fn known(error: &(dyn Error + 'static)) -> Option<&'static str> {
    const FULL: &str = "its disk is full: make room";
    const READ_ONLY: &str = "its disk takes no writes: look after its mount and rights";
    if let Some(error) = error.downcast_ref::<io::Error>() {
        return match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Some(FULL),
            io::ErrorKind::ReadOnlyFilesystem | io::ErrorKind::PermissionDenied => Some(READ_ONLY),
            _ => None,
        };
    }
    let Some(sqlx::Error::Database(reported)) = error.downcast_ref::<sqlx::Error>() else { return None };
    let reported = reported.as_ref();
    if sqlite_code(reported) == Some(SQLITE_FULL) || is_postgres(reported, POSTGRES_FULL) {
        Some(FULL)
    } else if sqlite_code(reported) == Some(SQLITE_READ_ONLY) || is_postgres(reported, POSTGRES_READ_ONLY) {
        Some(READ_ONLY)
    } else {
        None
    }
}
