//! Statements on the table `exemplars`.

use jiff::Timestamp;
use sqlx::Row;
use sqlx::postgres::{PgConnection, PgRow};
use uuid::Uuid;

use super::databases;

use crate::store::row::{time, to_column, unsigned};
use crate::store::{CatalogueError, ExemplarFilter, ExemplarRow};

fn read(row: &PgRow) -> Result<ExemplarRow, CatalogueError> {
    Ok(ExemplarRow {
        database: row.try_get("database")?,
        id: row.try_get("id")?,
        label: row.try_get("label")?,
        pose_deg: row.try_get("pose_deg")?,
        width_px: unsigned(row, "width_px")?,
        height_px: unsigned(row, "height_px")?,
        bytes: unsigned(row, "bytes")?,
        sha256: row.try_get("sha256")?,
        blob: row.try_get("blob")?,
        media_type: row.try_get("media_type")?,
        robot_id: row.try_get("robot_id")?,
        frame_id: row.try_get("frame_id")?,
        stamp: row.try_get("stamp")?,
        created_at: time(row, "created_at")?,
    })
}

pub async fn insert(
    connection: &mut PgConnection,
    new: &ExemplarRow,
) -> Result<(ExemplarRow, bool), CatalogueError> {
    if let Some(existing) = find(connection, &new.database, new.id).await? {
        return Ok((existing, false));
    }
    databases::keep(connection, &new.database).await?;
    // Whoever is a moment later than somebody else gets that one's row, unchanged: xmax is set on it.
    let row = sqlx::query(
        "INSERT INTO exemplars (database, id, label, pose_deg, width_px, height_px, bytes, sha256, blob,
                                media_type, robot_id, frame_id, stamp, created_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, now_us())
         ON CONFLICT (database, id) DO UPDATE SET id = excluded.id RETURNING *, xmax = 0 AS is_new",
    )
    .bind(&new.database)
    .bind(new.id)
    .bind(&new.label)
    .bind(new.pose_deg)
    .bind(i64::from(new.width_px))
    .bind(i64::from(new.height_px))
    .bind(to_column(new.bytes))
    .bind(&new.sha256)
    .bind(&new.blob)
    .bind(&new.media_type)
    .bind(&new.robot_id)
    .bind(&new.frame_id)
    .bind(&new.stamp)
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, row.try_get("is_new")?))
}

pub async fn find(
    connection: &mut PgConnection,
    database: &str,
    id: Uuid,
) -> Result<Option<ExemplarRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM exemplars WHERE database = $1 AND id = $2")
        .bind(database)
        .bind(id)
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut PgConnection,
    database: &str,
    filter: &ExemplarFilter,
    after: Option<Uuid>,
    limit: u32,
) -> Result<Vec<ExemplarRow>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT * FROM exemplars
         WHERE database = $1 AND ($2 IS NULL OR label = $2) AND ($3 IS NULL OR robot_id = $3)
           AND ($4 IS NULL OR created_at >= $4) AND ($5 IS NULL OR created_at < $5)
           AND ($6 IS NULL OR id > $6)
         ORDER BY id LIMIT $7",
    )
    .bind(database)
    .bind(&filter.label)
    .bind(&filter.robot_id)
    .bind(filter.since.map(Timestamp::as_microsecond))
    .bind(filter.before.map(Timestamp::as_microsecond))
    .bind(after)
    .bind(i64::from(limit))
    .fetch_all(connection)
    .await?;
    rows.iter().map(read).collect()
}

pub async fn delete(connection: &mut PgConnection, database: &str, id: Uuid) -> Result<bool, CatalogueError> {
    let done = sqlx::query("DELETE FROM exemplars WHERE database = $1 AND id = $2")
        .bind(database)
        .bind(id)
        .execute(connection)
        .await?;
    Ok(done.rows_affected() > 0)
}

pub async fn delete_matching(
    connection: &mut PgConnection,
    database: &str,
    filter: &ExemplarFilter,
) -> Result<u64, CatalogueError> {
    if filter.is_empty() {
        return Err(CatalogueError::EmptyFilter);
    }
    let done = sqlx::query(
        "DELETE FROM exemplars
         WHERE database = $1 AND ($2 IS NULL OR label = $2) AND ($3 IS NULL OR robot_id = $3)
           AND ($4 IS NULL OR created_at >= $4) AND ($5 IS NULL OR created_at < $5)",
    )
    .bind(database)
    .bind(&filter.label)
    .bind(&filter.robot_id)
    .bind(filter.since.map(Timestamp::as_microsecond))
    .bind(filter.before.map(Timestamp::as_microsecond))
    .execute(connection)
    .await?;
    Ok(done.rows_affected())
}

pub async fn training_set(
    connection: &mut PgConnection,
    database: &str,
) -> Result<Vec<ExemplarRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM exemplars WHERE database = $1 ORDER BY label, id")
        .bind(database)
        .fetch_all(connection)
        .await?;
    rows.iter().map(read).collect()
}
