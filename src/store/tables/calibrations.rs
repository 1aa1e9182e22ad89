//! The table `calibrations`, and the counter of their revisions.

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// What is known of a camera rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CalibrationRow {
    /// Unique among the calibrations.
    pub name: String,
    /// The calibration, as JSON.
    pub document: String,
    /// Grows with every change; no two states of any calibration share one, not even after a deletion.
    pub revision: i64,
    /// When it was created.
    pub created_at: Timestamp,
    /// When its document was replaced last.
    pub updated_at: Timestamp,
}

impl FromRow for CalibrationRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            name: row.get("name")?,
            document: row.get("document")?,
            revision: row.get("revision")?,
            created_at: row.time("created_at")?,
            updated_at: row.time("updated_at")?,
        })
    }
}

/// Creates or replaces the calibration, if it is at the revision `expected`; none means that it isn't there. Errors:
/// `PreconditionFailed`.
pub async fn put(
    connection: &mut Connection<'_>,
    name: &str,
    document: &str,
    expected: Option<i64>,
) -> Result<CalibrationRow, CatalogueError> {
    if lock(connection, name).await? != expected {
        return Err(CatalogueError::PreconditionFailed);
    }
    let revision: i64 = connection
        .query("UPDATE last_calibration_revision SET revision = revision + 1 RETURNING revision")
        .fetch_one()
        .await?;
    connection
        .query(
            "INSERT INTO calibrations (name, document, revision, created_at, updated_at)
             VALUES ($1, $2, $3, now_us(), now_us())
             ON CONFLICT (name) DO UPDATE SET document = $2, revision = $3, updated_at = now_us() RETURNING *",
        )
        .bind(name)
        .bind(document)
        .bind(revision)
        .fetch_one()
        .await
}

/// Lets nobody else change the calibration, or create it, until the transaction ends; gives its revision.
///
/// A row that isn't there yet can't be locked: the counter of all calibrations stands for it, and is always locked
/// first.
pub async fn lock(connection: &mut Connection<'_>, name: &str) -> Result<Option<i64>, CatalogueError> {
    let _counter: i64 =
        connection.query("SELECT revision FROM last_calibration_revision FOR UPDATE").fetch_one().await?;
    connection
        .query("SELECT revision FROM calibrations WHERE name = $1 FOR NO KEY UPDATE")
        .bind(name)
        .fetch_optional()
        .await
}

/// Lets nobody delete the calibration until the transaction ends. Errors: `NotFound`.
pub async fn lock_against_deletion(
    connection: &mut Connection<'_>,
    name: &str,
) -> Result<(), CatalogueError> {
    let locked: Option<String> = connection
        .query("SELECT name FROM calibrations WHERE name = $1 FOR KEY SHARE")
        .bind(name)
        .fetch_optional()
        .await?;
    locked.map(drop).ok_or_else(|| CatalogueError::no_calibration(name))
}

/// The calibration of that name.
pub async fn find(
    connection: &mut Connection<'_>,
    name: &str,
) -> Result<Option<CalibrationRow>, CatalogueError> {
    connection.query("SELECT * FROM calibrations WHERE name = $1").bind(name).fetch_optional().await
}

/// Calibrations by name.
pub async fn list(
    connection: &mut Connection<'_>,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<CalibrationRow>, CatalogueError> {
    connection
        .query("SELECT * FROM calibrations WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2")
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// Deletes a calibration; false when there was none.
pub async fn delete(connection: &mut Connection<'_>, name: &str) -> Result<bool, CatalogueError> {
    Ok(connection.query("DELETE FROM calibrations WHERE name = $1").bind(name).execute().await? > 0)
}
