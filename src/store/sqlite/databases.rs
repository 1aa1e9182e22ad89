//! Statements on the table `databases`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::row::{time, unsigned};
use crate::store::{CatalogueError, DatabaseCounts, DatabaseRow};

fn read(row: &SqliteRow) -> Result<DatabaseRow, CatalogueError> {
    Ok(DatabaseRow {
        name: row.try_get("name")?,
        kind: row.try_get("kind")?,
        options: row.try_get("options")?,
        created_at: time(row, "created_at")?,
    })
}

pub async fn create(
    connection: &mut SqliteConnection,
    name: &str,
    kind: &str,
    options: &str,
) -> Result<(DatabaseRow, bool), CatalogueError> {
    if let Some(existing) = find(connection, name).await? {
        return Ok((existing, false));
    }
    let row = sqlx::query(
        "INSERT INTO databases (name, kind, options, created_at) VALUES (?1, ?2, ?3, ?4) RETURNING *",
    )
    .bind(name)
    .bind(kind)
    .bind(options)
    .bind(now_us())
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, true))
}

pub async fn set_options(
    connection: &mut SqliteConnection,
    name: &str,
    options: &str,
) -> Result<DatabaseRow, CatalogueError> {
    let row = sqlx::query("UPDATE databases SET options = ?2 WHERE name = ?1 RETURNING *")
        .bind(name)
        .bind(options)
        .fetch_optional(connection)
        .await?;
    read(&row.ok_or_else(|| CatalogueError::no_database(name))?)
}

pub async fn find(
    connection: &mut SqliteConnection,
    name: &str,
) -> Result<Option<DatabaseRow>, CatalogueError> {
    let row =
        sqlx::query("SELECT * FROM databases WHERE name = ?1").bind(name).fetch_optional(connection).await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut SqliteConnection,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<DatabaseRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM databases WHERE (?1 IS NULL OR name > ?1) ORDER BY name LIMIT ?2")
        .bind(after)
        .bind(limit)
        .fetch_all(connection)
        .await?;
    rows.iter().map(read).collect()
}

/// Deletes the row; exemplars, versions and aliases go with it by cascade.
pub async fn delete(connection: &mut SqliteConnection, name: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM databases WHERE name = ?1").bind(name).execute(connection).await?;
    Ok(done.rows_affected() > 0)
}

pub async fn counts(connection: &mut SqliteConnection, name: &str) -> Result<DatabaseCounts, CatalogueError> {
    let row = sqlx::query(
        "SELECT (SELECT count(*) FROM exemplars WHERE database = name) AS exemplars,
                (SELECT count(DISTINCT label) FROM exemplars WHERE database = name) AS labels,
                (SELECT count(*) FROM versions WHERE database = name) AS versions
         FROM databases WHERE name = ?1",
    )
    .bind(name)
    .fetch_optional(connection)
    .await?
    .ok_or_else(|| CatalogueError::no_database(name))?;
    Ok(DatabaseCounts {
        exemplars: unsigned(&row, "exemplars")?,
        labels: unsigned(&row, "labels")?,
        versions: unsigned(&row, "versions")?,
    })
}
