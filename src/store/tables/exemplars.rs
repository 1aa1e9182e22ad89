//! The table `exemplars`.

use jiff::Timestamp;
use serde_json::{Value, json};
use uuid::Uuid;

use super::databases;
use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row, to_column};

/// One training image; its bytes are the blob.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarRow {
    /// The database's name.
    pub database: String,
    /// Unique in its database.
    pub id: Uuid,
    /// What is seen in the image; empty where it is negative.
    pub label: String,
    /// Whether nothing known is seen in it.
    pub negative: bool,
    /// The object's turn about the vertical; none for a landmark, and where it isn't known.
    pub pose_deg: Option<f64>,
    /// Where it was taken, with which camera, and how large it is, as JSON.
    pub survey: Option<String>,
    /// Width of the image.
    pub width_px: u32,
    /// Height of the image.
    pub height_px: u32,
    /// Size of the image as sent.
    pub bytes: u64,
    /// SHA-256 of the bytes as sent, hex.
    pub sha256: String,
    /// Name of the blob, as `BlobName` writes it.
    pub blob: String,
    /// Media type of the bytes.
    pub media_type: String,
    /// The robot that sent it, where it said so.
    pub robot_id: Option<String>,
    /// The camera's coordinate frame, as the robot named it.
    pub frame_id: Option<String>,
    /// The capture time as the robot sent it.
    pub stamp: Option<String>,
    /// Set by the catalogue on insertion; what the caller puts here is ignored.
    pub created_at: Timestamp,
}

impl FromRow for ExemplarRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            database: row.get("database")?,
            id: row.id("id")?,
            label: row.get("label")?,
            negative: row.get("negative")?,
            pose_deg: row.get("pose_deg")?,
            survey: row.get("survey")?,
            width_px: row.unsigned("width_px")?,
            height_px: row.unsigned("height_px")?,
            bytes: row.unsigned("bytes")?,
            sha256: row.get("sha256")?,
            blob: row.get("blob")?,
            media_type: row.get("media_type")?,
            robot_id: row.get("robot_id")?,
            frame_id: row.get("frame_id")?,
            stamp: row.get("stamp")?,
            created_at: row.time("created_at")?,
        })
    }
}

/// Which exemplars are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExemplarFilter {
    /// Exactly this label.
    pub label: Option<String>,
    /// Negative ones, or those with a label.
    pub negative: Option<bool>,
    /// Sent by this robot.
    pub robot_id: Option<String>,
    /// Received at this moment or later.
    pub since: Option<Timestamp>,
    /// Received before this moment.
    pub before: Option<Timestamp>,
}

impl ExemplarFilter {
    /// The audit entry's detail on a deletion by this filter.
    pub(in crate::store) fn audit_detail(&self, deleted: u64) -> Value {
        let time = |time: Option<Timestamp>| time.map(|time| time.to_string());
        let mut detail = json!({
            "label": self.label, "robot_id": self.robot_id,
            "since": time(self.since), "before": time(self.before), "deleted": deleted,
        });
        if let Some(negative) = self.negative {
            detail["negative"] = negative.into();
        }
        detail
    }
}

/// Adds an exemplar, or gives the existing one of that database and id unchanged, with `false`. Errors: `NotFound` for
/// the database.
pub async fn insert(
    connection: &mut Connection<'_>,
    new: &ExemplarRow,
) -> Result<(ExemplarRow, bool), CatalogueError> {
    loop {
        if let Some(existing) = find(connection, &new.database, new.id).await? {
            return Ok((existing, false));
        }
        databases::lock_against_deletion(connection, &new.database).await?;
        // No row when another transaction inserted the exemplar meanwhile: the next turn finds that one.
        let inserted = connection
            .query(
                "INSERT INTO exemplars (database, id, label, negative, pose_deg, survey, width_px, height_px, bytes,
                                        sha256, blob, media_type, robot_id, frame_id, stamp, created_at)
                 VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, now_us())
                 ON CONFLICT (database, id) DO NOTHING RETURNING *",
            )
            .bind(&new.database)
            .bind_id(new.id)
            .bind(&new.label)
            .bind(new.negative)
            .bind(new.pose_deg)
            .bind(&new.survey)
            .bind(i64::from(new.width_px))
            .bind(i64::from(new.height_px))
            .bind(to_column(new.bytes))
            .bind(&new.sha256)
            .bind(&new.blob)
            .bind(&new.media_type)
            .bind(&new.robot_id)
            .bind(&new.frame_id)
            .bind(&new.stamp)
            .fetch_optional()
            .await?;
        if let Some(inserted) = inserted {
            return Ok((inserted, true));
        }
    }
}

/// Replaces the survey of an exemplar if it is still `before`, and gives it; none when it isn't, or there is none of that id.
pub async fn change_survey(
    connection: &mut Connection<'_>,
    database: &str,
    id: Uuid,
    before: Option<&str>,
    after: Option<&str>,
) -> Result<Option<ExemplarRow>, CatalogueError> {
    connection
        .query(
            "UPDATE exemplars SET survey = $4 WHERE database = $1 AND id = $2 AND coalesce(survey, '') = coalesce($3, '')
             RETURNING *",
        )
        .bind(database)
        .bind_id(id)
        .bind(before)
        .bind(after)
        .fetch_optional()
        .await
}

/// The exemplar of that id.
pub async fn find(
    connection: &mut Connection<'_>,
    database: &str,
    id: Uuid,
) -> Result<Option<ExemplarRow>, CatalogueError> {
    connection
        .query("SELECT * FROM exemplars WHERE database = $1 AND id = $2")
        .bind(database)
        .bind_id(id)
        .fetch_optional()
        .await
}

/// Exemplars by id; an empty filter means all.
pub async fn list(
    connection: &mut Connection<'_>,
    database: &str,
    filter: &ExemplarFilter,
    after: Option<Uuid>,
    limit: u32,
) -> Result<Vec<ExemplarRow>, CatalogueError> {
    connection
        .query(
            "SELECT * FROM exemplars
             WHERE database = $1 AND ($2 IS NULL OR label = $2 AND NOT negative) AND ($3 IS NULL OR robot_id = $3)
               AND ($4 IS NULL OR created_at >= $4) AND ($5 IS NULL OR created_at < $5)
               AND ($6 IS NULL OR negative = $6) AND ($7 IS NULL OR id > $7)
             ORDER BY id LIMIT $8",
        )
        .bind(database)
        .bind(&filter.label)
        .bind(&filter.robot_id)
        .bind(filter.since.map(Timestamp::as_microsecond))
        .bind(filter.before.map(Timestamp::as_microsecond))
        .bind(filter.negative)
        .bind_id(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// Every exemplar of a database, by label, then id.
pub async fn training_set(
    connection: &mut Connection<'_>,
    database: &str,
) -> Result<Vec<ExemplarRow>, CatalogueError> {
    connection
        .query("SELECT * FROM exemplars WHERE database = $1 ORDER BY label, id")
        .bind(database)
        .fetch_all()
        .await
}

/// Deletes one exemplar; false when there was none.
pub async fn delete(
    connection: &mut Connection<'_>,
    database: &str,
    id: Uuid,
) -> Result<bool, CatalogueError> {
    let deleted = connection
        .query("DELETE FROM exemplars WHERE database = $1 AND id = $2")
        .bind(database)
        .bind_id(id)
        .execute()
        .await?;
    Ok(deleted > 0)
}

/// Deletes the exemplars that match, and counts them. Errors: `EmptyFilter`.
pub async fn delete_matching(
    connection: &mut Connection<'_>,
    database: &str,
    filter: &ExemplarFilter,
) -> Result<u64, CatalogueError> {
    if *filter == ExemplarFilter::default() {
        return Err(CatalogueError::EmptyFilter);
    }
    connection
        .query(
            "DELETE FROM exemplars
             WHERE database = $1 AND ($2 IS NULL OR label = $2 AND NOT negative) AND ($3 IS NULL OR robot_id = $3)
               AND ($4 IS NULL OR created_at >= $4) AND ($5 IS NULL OR created_at < $5)
               AND ($6 IS NULL OR negative = $6)",
        )
        .bind(database)
        .bind(&filter.label)
        .bind(&filter.robot_id)
        .bind(filter.since.map(Timestamp::as_microsecond))
        .bind(filter.before.map(Timestamp::as_microsecond))
        .bind(filter.negative)
        .execute()
        .await
}
