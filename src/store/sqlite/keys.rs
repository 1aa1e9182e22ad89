//! Statements on the table `keys`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::row::{optional_time, time};
use crate::store::{CatalogueError, KeyRow, NewKey};

fn read(row: &SqliteRow) -> Result<KeyRow, CatalogueError> {
    Ok(KeyRow {
        id: row.try_get("id")?,
        name: row.try_get("name")?,
        hash: row.try_get("hash")?,
        scope: row.try_get("scope")?,
        databases: row.try_get("databases")?,
        requests_per_s: row.try_get("requests_per_s")?,
        created_at: time(row, "created_at")?,
        last_used_at: optional_time(row, "last_used_at")?,
        revoked_at: optional_time(row, "revoked_at")?,
    })
}

pub async fn insert(connection: &mut SqliteConnection, new: &NewKey) -> Result<KeyRow, CatalogueError> {
    let row = sqlx::query(
        "INSERT INTO keys (id, name, hash, scope, databases, requests_per_s, created_at)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) RETURNING *",
    )
    .bind(&new.id)
    .bind(&new.name)
    .bind(&new.hash)
    .bind(&new.scope)
    .bind(&new.databases)
    .bind(new.requests_per_s)
    .bind(now_us())
    .fetch_one(connection)
    .await?;
    read(&row)
}

pub async fn find(connection: &mut SqliteConnection, id: &str) -> Result<Option<KeyRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM keys WHERE id = ?1").bind(id).fetch_optional(connection).await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(connection: &mut SqliteConnection) -> Result<Vec<KeyRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM keys ORDER BY created_at, id").fetch_all(connection).await?;
    rows.iter().map(read).collect()
}

/// True when it was in force until now.
pub async fn revoke(connection: &mut SqliteConnection, id: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("UPDATE keys SET revoked_at = ?2 WHERE id = ?1 AND revoked_at IS NULL")
        .bind(id)
        .bind(now_us())
        .execute(connection)
        .await?;
    Ok(done.rows_affected() > 0)
}

/// A time that is older than the one kept changes nothing.
pub async fn note_use(connection: &mut SqliteConnection, id: &str, at_us: i64) -> Result<(), CatalogueError> {
    sqlx::query(
        "UPDATE keys SET last_used_at = ?2 WHERE id = ?1 AND (last_used_at IS NULL OR last_used_at < ?2)",
    )
    .bind(id)
    .bind(at_us)
    .execute(connection)
    .await?;
    Ok(())
}
