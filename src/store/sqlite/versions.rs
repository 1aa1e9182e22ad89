//! Statements on the table `versions`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::row::{time, to_column, unsigned};
use crate::store::{CatalogueError, NewVersion, VersionRow};

fn read(row: &SqliteRow) -> Result<VersionRow, CatalogueError> {
    Ok(VersionRow {
        database: row.try_get("database")?,
        version: row.try_get("version")?,
        digest: row.try_get("digest")?,
        blob: row.try_get("blob")?,
        bytes: unsigned(row, "bytes")?,
        kind: row.try_get("kind")?,
        algorithm_revision: row.try_get("algorithm_revision")?,
        options: row.try_get("options")?,
        counts: row.try_get("counts")?,
        report: row.try_get("report")?,
        created_at: time(row, "created_at")?,
    })
}

pub async fn insert(
    connection: &mut SqliteConnection,
    new: &NewVersion,
) -> Result<(VersionRow, bool), CatalogueError> {
    if let Some(existing) = find_by_digest(connection, &new.database, &new.digest).await? {
        return Ok((existing, false));
    }
    // The counter stands beside the rows, so that deleting the last version doesn't give its number back.
    let number: Option<i64> = sqlx::query_scalar(
        "UPDATE databases SET last_version = last_version + 1 WHERE name = ?1 RETURNING last_version",
    )
    .bind(&new.database)
    .fetch_optional(&mut *connection)
    .await?;
    let number = number.ok_or_else(|| CatalogueError::no_database(&new.database))?;
    let row = sqlx::query(
        "INSERT INTO versions (database, version, digest, blob, bytes, kind, algorithm_revision, options,
                               counts, report, created_at)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11) RETURNING *",
    )
    .bind(&new.database)
    .bind(number)
    .bind(&new.digest)
    .bind(&new.blob)
    .bind(to_column(new.bytes))
    .bind(&new.kind)
    .bind(new.algorithm_revision)
    .bind(&new.options)
    .bind(&new.counts)
    .bind(&new.report)
    .bind(now_us())
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, true))
}

pub async fn find(
    connection: &mut SqliteConnection,
    database: &str,
    version: i64,
) -> Result<Option<VersionRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM versions WHERE database = ?1 AND version = ?2")
        .bind(database)
        .bind(version)
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn find_by_digest(
    connection: &mut SqliteConnection,
    database: &str,
    digest: &str,
) -> Result<Option<VersionRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM versions WHERE database = ?1 AND digest = ?2")
        .bind(database)
        .bind(digest)
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut SqliteConnection,
    database: &str,
    after: Option<i64>,
    limit: u32,
) -> Result<Vec<VersionRow>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT * FROM versions WHERE database = ?1 AND (?2 IS NULL OR version > ?2) ORDER BY version LIMIT ?3",
    )
    .bind(database)
    .bind(after)
    .bind(limit)
    .fetch_all(connection)
    .await?;
    rows.iter().map(read).collect()
}

pub async fn delete(
    connection: &mut SqliteConnection,
    database: &str,
    version: i64,
) -> Result<bool, CatalogueError> {
    let alias: Option<String> =
        sqlx::query_scalar("SELECT alias FROM aliases WHERE database = ?1 AND version = ?2 ORDER BY alias")
            .bind(database)
            .bind(version)
            .fetch_optional(&mut *connection)
            .await?;
    if let Some(alias) = alias {
        return Err(CatalogueError::aliased(database, version, &alias));
    }
    let done = sqlx::query("DELETE FROM versions WHERE database = ?1 AND version = ?2")
        .bind(database)
        .bind(version)
        .execute(connection)
        .await?;
    Ok(done.rows_affected() > 0)
}

/// Those of these databases' versions that are there; `versions` is a JSON list of pairs.
pub async fn digests(
    connection: &mut SqliteConnection,
    versions: &str,
) -> Result<Vec<(String, i64, String)>, CatalogueError> {
    Ok(sqlx::query_as(
        "SELECT v.database, v.version, v.digest
         FROM json_each(?1) w JOIN versions v ON v.database = w.value ->> 0 AND v.version = w.value ->> 1",
    )
    .bind(versions)
    .fetch_all(connection)
    .await?)
}
