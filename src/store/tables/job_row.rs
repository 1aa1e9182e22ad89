//! A job's row, and what its columns mean.

use jiff::Timestamp;
use uuid::Uuid;

use super::job_state::JobState;
use crate::store::CatalogueError;
use crate::store::query::{FromRow, Row};

/// How far a job is: `done` of `total` steps of a stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// What the job does at present.
    pub stage: String,
    /// Steps that are done.
    pub done: u64,
    /// Steps in all.
    pub total: u64,
}

/// A piece of long work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobRow {
    /// UUID v7: ids sort by the time of their making.
    pub id: Uuid,
    /// Which work it is, for instance `training`.
    pub kind: String,
    /// The name only: the row outlives the database. None for a job about a calibration.
    pub database: Option<String>,
    /// Likewise, the calibration that the job is about.
    pub calibration: Option<String>,
    /// What the work was ordered with, as JSON.
    pub params: String,
    /// Where it is in its life.
    pub state: JobState,
    /// None until its first report, and again after each claim.
    pub progress: Option<Progress>,
    /// Counts the claims; a worker's writes must name the one it was given.
    pub token: i64,
    /// The worker that holds the job, or held it when it ended; none while it waits.
    pub owner: Option<String>,
    /// When a running job may be claimed by another worker.
    pub lease_until: Option<Timestamp>,
    /// Whether a running job has been asked to end.
    pub cancel_requested: bool,
    /// Claims that count: one that was handed back doesn't.
    pub attempts: u32,
    /// The version it made or found.
    pub version: Option<i64>,
    /// JSON with at least `code` and `detail`, where the job failed or was cut off by a deletion.
    pub problem: Option<String>,
    /// JSON: how the version did beside the one in use, where that was asked for.
    pub comparison: Option<String>,
    /// When it was queued.
    pub created_at: Timestamp,
    /// The first claim.
    pub started_at: Option<Timestamp>,
    /// When it reached a terminal state.
    pub finished_at: Option<Timestamp>,
}

impl FromRow for JobRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        // SQLite's column can't be NULL: it is empty there in a job about a calibration.
        let database: Option<String> = row.get("database")?;
        Ok(Self {
            id: row.id("id")?,
            kind: row.get("kind")?,
            database: database.filter(|name| !name.is_empty()),
            calibration: row.get("calibration")?,
            params: row.get("params")?,
            state: read_state(row)?,
            progress: read_progress(row)?,
            token: row.get("token")?,
            owner: row.get("owner")?,
            lease_until: row.optional_time("lease_until")?,
            cancel_requested: row.get("cancel_requested")?,
            attempts: row.unsigned("attempts")?,
            version: row.get("version")?,
            problem: row.get("problem")?,
            comparison: row.get("comparison")?,
            created_at: row.time("created_at")?,
            started_at: row.optional_time("started_at")?,
            finished_at: row.optional_time("finished_at")?,
        })
    }
}

/// Reads the column `state`.
pub fn read_state(row: &Row) -> Result<JobState, CatalogueError> {
    let word: String = row.get("state")?;
    word.parse().map_err(|_| CatalogueError::corrupt(format!("a job's state is {word:?}")))
}

/// Reads the columns of the progress.
fn read_progress(row: &Row) -> Result<Option<Progress>, CatalogueError> {
    let stage: Option<String> = row.get("progress_stage")?;
    let Some(stage) = stage else { return Ok(None) };
    Ok(Some(Progress { stage, done: row.unsigned("progress_done")?, total: row.unsigned("progress_total")? }))
}
