//! Statements on the table `processes`.

use std::time::Duration;

use sqlx::Row;
use sqlx::postgres::{PgConnection, PgRow};

use crate::store::row::time;
use crate::store::{CatalogueError, ProcessRow};

/// Silent for a day: forgotten.
const FORGOTTEN_AFTER_US: i64 = 24 * 3600 * 1_000_000;

fn read(row: &PgRow) -> Result<ProcessRow, CatalogueError> {
    Ok(ProcessRow {
        worker: row.try_get("worker")?,
        role: row.try_get("role")?,
        serving: row.try_get("serving")?,
        started_at: time(row, "started_at")?,
        seen_at: time(row, "seen_at")?,
    })
}

pub async fn note(connection: &mut PgConnection, process: &ProcessRow) -> Result<(), CatalogueError> {
    sqlx::query(
        "INSERT INTO processes (worker, role, serving, started_at, seen_at) VALUES ($1, $2, $3, $4, now_us())
         ON CONFLICT (worker) DO UPDATE SET role = $2, serving = $3, seen_at = now_us()",
    )
    .bind(&process.worker)
    .bind(&process.role)
    .bind(&process.serving)
    .bind(process.started_at.as_microsecond())
    .execute(&mut *connection)
    .await?;
    sqlx::query("DELETE FROM processes WHERE seen_at < now_us() - $1")
        .bind(FORGOTTEN_AFTER_US)
        .execute(connection)
        .await?;
    Ok(())
}

pub async fn list(connection: &mut PgConnection, fresh: Duration) -> Result<Vec<ProcessRow>, CatalogueError> {
    let rows =
        sqlx::query("SELECT * FROM processes WHERE seen_at >= now_us() - $1 ORDER BY started_at, worker")
            .bind(i64::try_from(fresh.as_micros()).unwrap_or(i64::MAX))
            .fetch_all(connection)
            .await?;
    rows.iter().map(read).collect()
}
