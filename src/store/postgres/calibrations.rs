//! Statements on the table `calibrations`.

use sqlx::Row;
use sqlx::postgres::{PgConnection, PgRow};

use crate::store::row::time;
use crate::store::{CalibrationRow, CatalogueError};

fn read(row: &PgRow) -> Result<CalibrationRow, CatalogueError> {
    Ok(CalibrationRow {
        name: row.try_get("name")?,
        document: row.try_get("document")?,
        revision: row.try_get("revision")?,
        created_at: time(row, "created_at")?,
        updated_at: time(row, "updated_at")?,
    })
}

pub async fn put(
    connection: &mut PgConnection,
    name: &str,
    document: &str,
    expected: Option<i64>,
) -> Result<CalibrationRow, CatalogueError> {
    if lock(connection, name).await? != expected {
        return Err(CatalogueError::PreconditionFailed);
    }
    let revision: i64 =
        sqlx::query_scalar("UPDATE last_calibration_revision SET revision = revision + 1 RETURNING revision")
            .fetch_one(&mut *connection)
            .await?;
    let row = sqlx::query(
        "INSERT INTO calibrations (name, document, revision, created_at, updated_at) 
         VALUES ($1, $2, $3, now_us(), now_us())
         ON CONFLICT (name) DO UPDATE SET document = $2, revision = $3, updated_at = now_us() RETURNING *",
    )
    .bind(name)
    .bind(document)
    .bind(revision)
    .fetch_one(connection)
    .await?;
    read(&row)
}

/// Lets nobody else change the calibration, or make it, until the transaction ends; gives its revision.
///
/// What isn't there yet can't be locked: the counter of all calibrations stands for it, and is always locked first.
pub async fn lock(connection: &mut PgConnection, name: &str) -> Result<Option<i64>, CatalogueError> {
    sqlx::query("SELECT FROM last_calibration_revision FOR UPDATE").execute(&mut *connection).await?;
    let revision = sqlx::query_scalar("SELECT revision FROM calibrations WHERE name = $1 FOR NO KEY UPDATE")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    Ok(revision)
}

/// Lets nobody delete the calibration until the transaction ends. Errors: `NotFound`.
pub async fn keep(connection: &mut PgConnection, name: &str) -> Result<(), CatalogueError> {
    let row = sqlx::query("SELECT FROM calibrations WHERE name = $1 FOR KEY SHARE")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    row.map(drop).ok_or_else(|| CatalogueError::no_calibration(name))
}

pub async fn find(
    connection: &mut PgConnection,
    name: &str,
) -> Result<Option<CalibrationRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM calibrations WHERE name = $1")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut PgConnection,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<CalibrationRow>, CatalogueError> {
    let rows =
        sqlx::query("SELECT * FROM calibrations WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2")
            .bind(after)
            .bind(i64::from(limit))
            .fetch_all(connection)
            .await?;
    rows.iter().map(read).collect()
}

pub async fn delete(connection: &mut PgConnection, name: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM calibrations WHERE name = $1").bind(name).execute(connection).await?;
    Ok(done.rows_affected() > 0)
}
