//! Statements on the table `audit`.

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};

use super::row::now_us;
use crate::store::audit::Entry;
use crate::store::row::time;
use crate::store::{Actor, AuditFilter, AuditRow, CatalogueError};

fn read(row: &SqliteRow) -> Result<AuditRow, CatalogueError> {
    Ok(AuditRow {
        id: row.try_get("id")?,
        at: time(row, "at")?,
        actor: Actor {
            key: row.try_get("key")?,
            name: row.try_get("actor")?,
            request_id: row.try_get("request_id")?,
        },
        action: row.try_get("action")?,
        database: row.try_get("database")?,
        subject: row.try_get("subject")?,
        detail: row.try_get("detail")?,
    })
}

pub async fn append(
    connection: &mut SqliteConnection,
    by: &Actor,
    entry: Entry<'_>,
) -> Result<(), CatalogueError> {
    sqlx::query(
        "INSERT INTO audit (key, actor, request_id, action, database, subject, detail, at)
         VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
    )
    .bind(&by.key)
    .bind(&by.name)
    .bind(&by.request_id)
    .bind(entry.action)
    .bind(entry.database)
    .bind(entry.subject)
    .bind(entry.detail.to_string())
    .bind(now_us())
    .execute(connection)
    .await?;
    Ok(())
}

pub async fn list(
    connection: &mut SqliteConnection,
    filter: &AuditFilter,
    before: Option<i64>,
    limit: u32,
) -> Result<Vec<AuditRow>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT * FROM audit
         WHERE (?1 IS NULL OR database = ?1) AND (?2 IS NULL OR key = ?2) AND (?3 IS NULL OR action = ?3)
           AND (?4 IS NULL OR id < ?4)
         ORDER BY id DESC LIMIT ?5",
    )
    .bind(&filter.database)
    .bind(&filter.key)
    .bind(&filter.action)
    .bind(before)
    .bind(limit)
    .fetch_all(connection)
    .await?;
    rows.iter().map(read).collect()
}
