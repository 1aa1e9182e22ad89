//! The table `processes`, which only PostgreSQL has: the processes that share the catalogue.

use std::time::Duration;

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// A process that hasn't reported for so long is forgotten.
const FORGOTTEN_AFTER_US: i64 = 24 * 3600 * 1_000_000;

/// A process of a fleet, as it last reported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessRow {
    /// Unique to the process.
    pub worker: String,
    /// Whether it serves, trains or does both: `serve`, `train` or `all`.
    pub role: String,
    /// The versions that it holds in memory, as JSON.
    pub serving: String,
    /// When the process started.
    pub started_at: Timestamp,
    /// When it last reported; what the caller puts here is ignored.
    pub seen_at: Timestamp,
}

impl FromRow for ProcessRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            worker: row.get("worker")?,
            role: row.get("role")?,
            serving: row.get("serving")?,
            started_at: row.time("started_at")?,
            seen_at: row.time("seen_at")?,
        })
    }
}

/// Records what a process reports, and forgets the processes that have been silent for a day.
pub async fn record(connection: &mut Connection<'_>, process: &ProcessRow) -> Result<(), CatalogueError> {
    connection
        .query(
            "INSERT INTO processes (worker, role, serving, started_at, seen_at)
             VALUES ($1, $2, $3, $4, now_us())
             ON CONFLICT (worker) DO UPDATE SET role = $2, serving = $3, seen_at = now_us()",
        )
        .bind(&process.worker)
        .bind(&process.role)
        .bind(&process.serving)
        .bind(process.started_at.as_microsecond())
        .execute()
        .await?;
    connection
        .query("DELETE FROM processes WHERE seen_at < now_us() - $1")
        .bind(FORGOTTEN_AFTER_US)
        .execute()
        .await?;
    Ok(())
}

/// The processes that reported within the time `fresh`, by the time of their start.
pub async fn list(
    connection: &mut Connection<'_>,
    fresh: Duration,
) -> Result<Vec<ProcessRow>, CatalogueError> {
    connection
        .query("SELECT * FROM processes WHERE seen_at >= now_us() - $1 ORDER BY started_at, worker")
        .bind(i64::try_from(fresh.as_micros()).unwrap_or(i64::MAX))
        .fetch_all()
        .await
}
