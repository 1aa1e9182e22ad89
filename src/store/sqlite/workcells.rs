//! Statements on the table `workcells`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::row::time;
use crate::store::{CatalogueError, WorkcellRow};

fn read(row: &SqliteRow) -> Result<WorkcellRow, CatalogueError> {
    Ok(WorkcellRow {
        name: row.try_get("name")?,
        document: row.try_get("document")?,
        created_at: time(row, "created_at")?,
        updated_at: time(row, "updated_at")?,
    })
}

pub async fn put(
    connection: &mut SqliteConnection,
    name: &str,
    document: &str,
) -> Result<(WorkcellRow, bool), CatalogueError> {
    let is_new = find(connection, name).await?.is_none();
    let row = sqlx::query(
        "INSERT INTO workcells (name, document, created_at, updated_at) VALUES (?1, ?2, ?3, ?3)
         ON CONFLICT (name) DO UPDATE SET document = ?2, updated_at = ?3 RETURNING *",
    )
    .bind(name)
    .bind(document)
    .bind(now_us())
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, is_new))
}

pub async fn find(
    connection: &mut SqliteConnection,
    name: &str,
) -> Result<Option<WorkcellRow>, CatalogueError> {
    let row =
        sqlx::query("SELECT * FROM workcells WHERE name = ?1").bind(name).fetch_optional(connection).await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut SqliteConnection,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<WorkcellRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM workcells WHERE (?1 IS NULL OR name > ?1) ORDER BY name LIMIT ?2")
        .bind(after)
        .bind(limit)
        .fetch_all(connection)
        .await?;
    rows.iter().map(read).collect()
}

pub async fn delete(connection: &mut SqliteConnection, name: &str) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM workcells WHERE name = ?1").bind(name).execute(connection).await?;
    Ok(done.rows_affected() > 0)
}
