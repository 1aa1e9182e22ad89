//! Statements on the table `calibrations`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::row::time;
use crate::store::{CalibrationRow, CatalogueError};

fn read(row: &SqliteRow) -> Result<CalibrationRow, CatalogueError> {
    Ok(CalibrationRow {
        name: row.try_get("name")?,
        document: row.try_get("document")?,
        revision: row.try_get("revision")?,
        created_at: time(row, "created_at")?,
        updated_at: time(row, "updated_at")?,
    })
}

pub async fn put(
    connection: &mut SqliteConnection,
    name: &str,
    document: &str,
    expected: Option<i64>,
) -> Result<CalibrationRow, CatalogueError> {
    let before = find(connection, name).await?;
    if before.as_ref().map(|row| row.revision) != expected {
        return Err(CatalogueError::PreconditionFailed);
    }
    let revision: i64 =
        sqlx::query_scalar("UPDATE last_calibration_revision SET revision = revision + 1 RETURNING revision")
            .fetch_one(&mut *connection)
            .await?;
    let row = sqlx::query(
        "INSERT INTO calibrations (name, document, revision, created_at, updated_at) VALUES (?1, ?2, ?3, ?4, ?4)
         ON CONFLICT (name) DO UPDATE SET document = ?2, revision = ?3, updated_at = ?4 RETURNING *",
    )
    .bind(name)
    .bind(document)
    .bind(revision)
    .bind(now_us())
    .fetch_one(connection)
    .await?;
    read(&row)
}

pub async fn find(
    connection: &mut SqliteConnection,
    name: &str,
) -> Result<Option<CalibrationRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM calibrations WHERE name = ?1")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut SqliteConnection,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<CalibrationRow>, CatalogueError> {
    let rows =
        sqlx::query("SELECT * FROM calibrations WHERE (?1 IS NULL OR name > ?1) ORDER BY name LIMIT ?2")
            .bind(after)
            .bind(limit)
            .fetch_all(connection)
            .await?;
    rows.iter().map(read).collect()
}

pub async fn delete(connection: &mut SqliteConnection, name: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM calibrations WHERE name = ?1").bind(name).execute(connection).await?;
    Ok(done.rows_affected() > 0)
}
