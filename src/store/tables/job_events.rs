//! The table `job_events`: a job as it was after each change of its state or progress.

use jiff::Timestamp;
use uuid::Uuid;

use super::job_row::JobRow;
use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// A job as it was after one change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobEventRow {
    /// The job's id.
    pub job: Uuid,
    /// Counts 1, 2, 3 … for each job.
    pub sequence: i64,
    /// The whole row as it was then.
    pub body: JobRow,
    /// When the change was made.
    pub created_at: Timestamp,
}

impl FromRow for JobEventRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            job: row.id("id")?,
            sequence: row.get("sequence")?,
            body: JobRow::from_row(row)?,
            created_at: row.time("at")?,
        })
    }
}

/// Appends the job as it is now. The transaction has locked the job's row, so the sequence has no gap.
pub async fn append(connection: &mut Connection<'_>, job: Uuid) -> Result<(), CatalogueError> {
    connection
        .query(
            "INSERT INTO job_events (job, sequence, at, state, progress_stage, progress_done, progress_total, token,
                                     owner, lease_until, cancel_requested, attempts, version, problem, comparison,
                                     started_at, finished_at)
             SELECT id, (SELECT coalesce(max(sequence), 0) + 1 FROM job_events WHERE job = $1), now_us(), state,
                    progress_stage, progress_done, progress_total, token, owner, lease_until, cancel_requested,
                    attempts, version, problem, comparison, started_at, finished_at
             FROM jobs WHERE id = $1",
        )
        .bind_id(job)
        .execute()
        .await?;
    Ok(())
}

/// The events of all jobs after a moment, in order; at most a thousand.
pub async fn since(
    connection: &mut Connection<'_>,
    moment: Timestamp,
) -> Result<Vec<JobEventRow>, CatalogueError> {
    connection
        .query(
            "SELECT j.id, j.kind, j.database, j.calibration, j.params, j.created_at, e.*
             FROM job_events e JOIN jobs j ON j.id = e.job
             WHERE e.at > $1 ORDER BY e.at, e.job, e.sequence LIMIT 1000",
        )
        .bind(moment.as_microsecond())
        .fetch_all()
        .await
}

/// The events of a job after the one numbered `after`, in order.
pub async fn list(
    connection: &mut Connection<'_>,
    job: Uuid,
    after: i64,
) -> Result<Vec<JobEventRow>, CatalogueError> {
    connection
        .query(
            "SELECT j.id, j.kind, j.database, j.calibration, j.params, j.created_at, e.*
             FROM job_events e JOIN jobs j ON j.id = e.job
             WHERE e.job = $1 AND e.sequence > $2 ORDER BY e.sequence",
        )
        .bind_id(job)
        .bind(after)
        .fetch_all()
        .await
}
