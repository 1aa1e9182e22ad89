//! Statements on the table `databases`.

use sqlx::Row;
use sqlx::postgres::{PgConnection, PgRow};

use crate::store::row::{time, unsigned};
use crate::store::{CatalogueError, DatabaseCounts, DatabaseRow};

fn read(row: &PgRow) -> Result<DatabaseRow, CatalogueError> {
    Ok(DatabaseRow {
        name: row.try_get("name")?,
        kind: row.try_get("kind")?,
        options: row.try_get("options")?,
        created_at: time(row, "created_at")?,
    })
}

pub async fn create(
    connection: &mut PgConnection,
    name: &str,
    kind: &str,
    options: &str,
) -> Result<(DatabaseRow, bool), CatalogueError> {
    if let Some(existing) = find(connection, name).await? {
        return Ok((existing, false));
    }
    // Whoever is a moment later than somebody else gets that one's row, unchanged: xmax is set on it.
    let row = sqlx::query(
        "INSERT INTO databases (name, kind, options, created_at) VALUES ($1, $2, $3, now_us())
         ON CONFLICT (name) DO UPDATE SET name = excluded.name RETURNING *, xmax = 0 AS is_new",
    )
    .bind(name)
    .bind(kind)
    .bind(options)
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, row.try_get("is_new")?))
}

pub async fn set_options(
    connection: &mut PgConnection,
    name: &str,
    options: &str,
) -> Result<DatabaseRow, CatalogueError> {
    let row = sqlx::query("UPDATE databases SET options = $2 WHERE name = $1 RETURNING *")
        .bind(name)
        .bind(options)
        .fetch_optional(connection)
        .await?;
    read(&row.ok_or_else(|| CatalogueError::no_database(name))?)
}

/// Lets nobody else change the database's versions and aliases, or delete it, until the transaction ends.
///
/// False when there is none; another transaction may make it any moment then, so the caller is done.
pub async fn lock(connection: &mut PgConnection, name: &str) -> Result<bool, CatalogueError> {
    let row = sqlx::query("SELECT FROM databases WHERE name = $1 FOR NO KEY UPDATE")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    Ok(row.is_some())
}

/// Lets nobody delete the database until the transaction ends. Errors: `NotFound`.
pub async fn keep(connection: &mut PgConnection, name: &str) -> Result<(), CatalogueError> {
    let row = sqlx::query("SELECT FROM databases WHERE name = $1 FOR KEY SHARE")
        .bind(name)
        .fetch_optional(connection)
        .await?;
    row.map(drop).ok_or_else(|| CatalogueError::no_database(name))
}

pub async fn find(connection: &mut PgConnection, name: &str) -> Result<Option<DatabaseRow>, CatalogueError> {
    let row =
        sqlx::query("SELECT * FROM databases WHERE name = $1").bind(name).fetch_optional(connection).await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut PgConnection,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<DatabaseRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM databases WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2")
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all(connection)
        .await?;
    rows.iter().map(read).collect()
}

/// Deletes the row; exemplars, versions and aliases go with it by cascade.
pub async fn delete(connection: &mut PgConnection, name: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM databases WHERE name = $1").bind(name).execute(connection).await?;
    Ok(done.rows_affected() > 0)
}

pub async fn counts(connection: &mut PgConnection, name: &str) -> Result<DatabaseCounts, CatalogueError> {
    let row = sqlx::query(
        "SELECT (SELECT count(*) FROM exemplars WHERE database = name) AS exemplars,
                (SELECT count(DISTINCT label) FROM exemplars WHERE database = name) AS labels,
                (SELECT count(*) FROM versions WHERE database = name) AS versions
         FROM databases WHERE name = $1",
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
