//! The tables `jobs` and `job_blobs`.
//!
//! Each change of a job's state or progress appends an event in the same transaction. A worker's statements name the
//! token of its claim. Leases are taken and judged by the catalogue's clock alone: the clocks of processes differ.

use std::time::Duration;

use serde_json::json;
use uuid::Uuid;

use super::job_row::{JobRow, Progress, read_state};
use super::job_state::JobState;
use super::{calibrations, databases, job_events};
use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row, to_column};

/// How many jobs are in a state.
impl FromRow for (JobState, u64) {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok((read_state(row)?, row.unsigned("jobs")?))
    }
}

/// Which jobs are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Jobs about this database.
    pub database: Option<String>,
    /// Jobs about this calibration.
    pub calibration: Option<String>,
    /// Jobs in this state.
    pub state: Option<JobState>,
}

/// What a worker learns when it renews its lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Renewal {
    /// Somebody asked for the job to end: stop at the next step and call `Catalogue::cancelled_job`.
    pub cancel_requested: bool,
}

/// What a job leaves when it ends.
#[derive(Debug, Default)]
pub struct Outcome<'a> {
    /// The version that it made or found.
    pub version: Option<i64>,
    /// Why it failed, as JSON.
    pub problem: Option<&'a str>,
    /// How the version did beside the one in use, as JSON.
    pub comparison: Option<&'a str>,
}

/// What a job is about.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    /// The database of this name.
    Database(&'a str),
    /// The calibration of this name.
    Calibration(&'a str),
}

impl<'a> Subject<'a> {
    /// The database, if the job is about one.
    fn database(self) -> Option<&'a str> {
        match self {
            Self::Database(name) => Some(name),
            Self::Calibration(_) => None,
        }
    }

    /// The calibration, if the job is about one.
    fn calibration(self) -> Option<&'a str> {
        match self {
            Self::Database(_) => None,
            Self::Calibration(name) => Some(name),
        }
    }

    /// The problem (JSON) of a job whose subject was deleted.
    fn deletion_problem(self) -> String {
        let (code, detail) = match self {
            Self::Database(name) => ("database_deleted", format!("database {name:?} was deleted")),
            Self::Calibration(name) => ("calibration_deleted", format!("calibration {name:?} was deleted")),
        };
        json!({"code": code, "detail": detail}).to_string()
    }
}

/// A lease as it is added to a time column: at most 146 000 years, so that the sum fits.
fn lease_us(lease: Duration) -> i64 {
    i64::try_from(lease.as_micros()).unwrap_or(i64::MAX).min(i64::MAX / 2)
}

/// Queues a job about a database or a calibration. Errors: `NotFound` for that one.
pub async fn enqueue(
    connection: &mut Connection<'_>,
    kind: &str,
    subject: Subject<'_>,
    params: &str,
) -> Result<JobRow, CatalogueError> {
    match subject {
        Subject::Database(name) => databases::lock_against_deletion(connection, name).await?,
        Subject::Calibration(name) => calibrations::lock_against_deletion(connection, name).await?,
    }
    let job: JobRow = connection
        .query_per_dialect(
            "INSERT INTO jobs (id, kind, database, calibration, params, state, created_at)
             VALUES ($1, $2, coalesce($3, ''), $4, $5, 'queued', now_us()) RETURNING *",
            "INSERT INTO jobs (id, kind, database, calibration, params, state, created_at)
             VALUES ($1, $2, $3, $4, $5, 'queued', now_us()) RETURNING *",
        )
        .bind_id(Uuid::now_v7())
        .bind(kind)
        .bind(subject.database())
        .bind(subject.calibration())
        .bind(params)
        .fetch_one()
        .await?;
    job_events::append(connection, job.id).await?;
    Ok(job)
}

/// Keeps blobs until the job has ended.
pub async fn keep_blobs(
    connection: &mut Connection<'_>,
    id: Uuid,
    blobs: &[String],
) -> Result<(), CatalogueError> {
    connection
        .query_per_dialect(
            "INSERT INTO job_blobs (job, blob) SELECT DISTINCT $1, value FROM json_each($2)",
            "INSERT INTO job_blobs (job, blob) SELECT DISTINCT $1, blob FROM unnest($2) AS blob",
        )
        .bind_id(id)
        .bind_list(blobs)
        .execute()
        .await?;
    Ok(())
}

/// The job of that id.
pub async fn find(connection: &mut Connection<'_>, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
    connection.query("SELECT * FROM jobs WHERE id = $1").bind_id(id).fetch_optional().await
}

/// Jobs, the newest first; `after` is the oldest one seen.
pub async fn list(
    connection: &mut Connection<'_>,
    filter: &JobFilter,
    after: Option<Uuid>,
    limit: u32,
) -> Result<Vec<JobRow>, CatalogueError> {
    connection
        .query(
            "SELECT * FROM jobs
             WHERE ($1 IS NULL OR database = $1) AND ($2 IS NULL OR calibration = $2)
               AND ($3 IS NULL OR state = $3) AND ($4 IS NULL OR id < $4)
             ORDER BY id DESC LIMIT $5",
        )
        .bind(&filter.database)
        .bind(&filter.calibration)
        .bind(filter.state.map(JobState::as_str))
        .bind_id(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// How many jobs there are in each state that has any.
pub async fn count_by_state(connection: &mut Connection<'_>) -> Result<Vec<(JobState, u64)>, CatalogueError> {
    connection
        .query("SELECT state, count(*) AS jobs FROM jobs GROUP BY state ORDER BY state")
        .fetch_all()
        .await
}

/// Claims the oldest job that can be, ending the ones before it that can't go on.
///
/// PostgreSQL skips jobs that another transaction has locked, so claims never wait for each other. Every turn but the
/// last ends one job for good, so the loop ends.
pub async fn claim(
    connection: &mut Connection<'_>,
    owner: &str,
    kinds: &[&str],
    lease: Duration,
    max_attempts: u32,
) -> Result<Option<JobRow>, CatalogueError> {
    loop {
        let job: Option<JobRow> = connection
            .query_per_dialect(
                "SELECT * FROM jobs
                 WHERE state IN ('queued', 'running') AND (state = 'queued' OR lease_until <= now_us())
                   AND kind IN (SELECT value FROM json_each($1))
                 ORDER BY id LIMIT 1",
                "SELECT * FROM jobs
                 WHERE state IN ('queued', 'running') AND (state = 'queued' OR lease_until <= now_us())
                   AND kind = ANY ($1)
                 ORDER BY id LIMIT 1 FOR UPDATE SKIP LOCKED",
            )
            .bind_list(kinds)
            .fetch_optional()
            .await?;
        let Some(job) = job else { return Ok(None) };
        if job.cancel_requested {
            end(connection, job.id, JobState::Cancelled, Outcome::default()).await?;
        } else if job.attempts >= max_attempts {
            let detail = format!("the job was taken up {} times and never finished", job.attempts);
            let problem = json!({"code": "attempts_exhausted", "detail": detail}).to_string();
            let outcome = Outcome { problem: Some(&problem), ..Outcome::default() };
            end(connection, job.id, JobState::Failed, outcome).await?;
        } else {
            return assign(connection, job.id, owner, lease).await.map(Some);
        }
    }
}

/// Gives a job to a worker.
async fn assign(
    connection: &mut Connection<'_>,
    id: Uuid,
    owner: &str,
    lease: Duration,
) -> Result<JobRow, CatalogueError> {
    let job = connection
        .query(
            "UPDATE jobs
             SET state = 'running', token = token + 1, attempts = attempts + 1, owner = $2,
                 lease_until = now_us() + $3, progress_stage = NULL, progress_done = NULL, progress_total = NULL,
                 started_at = coalesce(started_at, now_us())
             WHERE id = $1 RETURNING *",
        )
        .bind_id(id)
        .bind(owner)
        .bind(lease_us(lease))
        .fetch_one()
        .await?;
    job_events::append(connection, id).await?;
    Ok(job)
}

/// Ends a job whoever holds it.
async fn end(
    connection: &mut Connection<'_>,
    id: Uuid,
    state: JobState,
    outcome: Outcome<'_>,
) -> Result<JobRow, CatalogueError> {
    let job = connection
        .query(
            "UPDATE jobs SET state = $2, version = coalesce($3, version), problem = $4,
                             comparison = coalesce($5, comparison), lease_until = NULL, finished_at = now_us()
             WHERE id = $1 RETURNING *",
        )
        .bind_id(id)
        .bind(state.as_str())
        .bind(outcome.version)
        .bind(outcome.problem)
        .bind(outcome.comparison)
        .fetch_one()
        .await?;
    job_events::append(connection, id).await?;
    Ok(job)
}

/// Locks and gives the running job that this token holds. Errors: `LeaseLost`.
async fn lock_held(connection: &mut Connection<'_>, id: Uuid, token: i64) -> Result<JobRow, CatalogueError> {
    connection
        .query("SELECT * FROM jobs WHERE id = $1 AND token = $2 AND state = 'running' FOR UPDATE")
        .bind_id(id)
        .bind(token)
        .fetch_optional()
        .await?
        .ok_or(CatalogueError::LeaseLost)
}

/// Ends a job that this token holds and that was not asked to end. Errors: `LeaseLost`, `CancelRequested`.
pub async fn succeed(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
    outcome: Outcome<'_>,
) -> Result<JobRow, CatalogueError> {
    lock_uncancelled(connection, id, token).await?;
    end(connection, id, JobState::Succeeded, outcome).await
}

/// Notes the version of a job that goes on. Errors: `LeaseLost`, `CancelRequested`.
pub async fn note_version(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
    version: i64,
    comparison: Option<&str>,
) -> Result<(), CatalogueError> {
    lock_uncancelled(connection, id, token).await?;
    connection
        .query("UPDATE jobs SET version = $2, comparison = $3 WHERE id = $1")
        .bind_id(id)
        .bind(version)
        .bind(comparison)
        .execute()
        .await?;
    job_events::append(connection, id).await
}

/// Locks a job that this token holds and that was not asked to end. Errors: `LeaseLost`, `CancelRequested`.
pub async fn lock_uncancelled(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
) -> Result<(), CatalogueError> {
    let job = lock_held(connection, id, token).await?;
    if job.cancel_requested { Err(CatalogueError::CancelRequested) } else { Ok(()) }
}

/// Ends a job that this token holds, asked to end or not. Errors: `LeaseLost`.
pub async fn finish(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
    state: JobState,
    outcome: Outcome<'_>,
) -> Result<JobRow, CatalogueError> {
    lock_held(connection, id, token).await?;
    end(connection, id, state, outcome).await
}

/// Extends the lease to `lease` from now, and records the progress when it is given. Errors: `LeaseLost`.
pub async fn renew(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
    lease: Duration,
    progress: Option<&Progress>,
) -> Result<Renewal, CatalogueError> {
    let before = lock_held(connection, id, token).await?;
    let after = progress.or(before.progress.as_ref());
    connection
        .query(
            "UPDATE jobs SET lease_until = now_us() + $2, progress_stage = $3, progress_done = $4,
                             progress_total = $5
             WHERE id = $1",
        )
        .bind_id(id)
        .bind(lease_us(lease))
        .bind(after.map(|progress| progress.stage.as_str()))
        .bind(after.map(|progress| to_column(progress.done)))
        .bind(after.map(|progress| to_column(progress.total)))
        .execute()
        .await?;
    if after != before.progress.as_ref() {
        job_events::append(connection, id).await?;
    }
    Ok(Renewal { cancel_requested: before.cancel_requested })
}

/// Asks a job to end: a queued one is cancelled at once, a running one is flagged, a finished one stays as it is.
pub async fn request_cancel(
    connection: &mut Connection<'_>,
    id: Uuid,
) -> Result<Option<JobRow>, CatalogueError> {
    let job: Option<JobRow> =
        connection.query("SELECT * FROM jobs WHERE id = $1 FOR UPDATE").bind_id(id).fetch_optional().await?;
    let Some(job) = job else { return Ok(None) };
    match job.state {
        JobState::Queued => end(connection, id, JobState::Cancelled, Outcome::default()).await.map(Some),
        JobState::Running => {
            let flagged = connection
                .query("UPDATE jobs SET cancel_requested = TRUE WHERE id = $1 RETURNING *")
                .bind_id(id)
                .fetch_one()
                .await?;
            Ok(Some(flagged))
        }
        JobState::Succeeded | JobState::Failed | JobState::Cancelled => Ok(Some(job)),
    }
}

/// Cancels the unfinished jobs about what is being deleted.
pub async fn cancel_all(connection: &mut Connection<'_>, subject: Subject<'_>) -> Result<(), CatalogueError> {
    let jobs: Vec<JobRow> = connection
        .query(
            "SELECT * FROM jobs WHERE (database = $1 OR calibration = $2) AND state IN ('queued', 'running')
             ORDER BY id FOR UPDATE",
        )
        .bind(subject.database())
        .bind(subject.calibration())
        .fetch_all()
        .await?;
    let problem = subject.deletion_problem();
    for job in &jobs {
        let outcome = Outcome { problem: Some(&problem), ..Outcome::default() };
        end(connection, job.id, JobState::Cancelled, outcome).await?;
    }
    Ok(())
}

/// Puts a worker's running jobs back into the queue, the attempt not counted; gives their number.
///
/// One that was asked to end is cancelled.
pub async fn hand_back(connection: &mut Connection<'_>, owner: &str) -> Result<u64, CatalogueError> {
    let jobs: Vec<JobRow> = connection
        .query("SELECT * FROM jobs WHERE owner = $1 AND state = 'running' ORDER BY id FOR UPDATE")
        .bind(owner)
        .fetch_all()
        .await?;
    for job in &jobs {
        if job.cancel_requested {
            end(connection, job.id, JobState::Cancelled, Outcome::default()).await?;
        } else {
            requeue(connection, job.id).await?;
        }
    }
    Ok(jobs.len() as u64)
}

async fn requeue(connection: &mut Connection<'_>, id: Uuid) -> Result<(), CatalogueError> {
    connection
        .query(
            "UPDATE jobs
             SET state = 'queued', attempts = attempts - 1, owner = NULL, lease_until = NULL,
                 progress_stage = NULL, progress_done = NULL, progress_total = NULL
             WHERE id = $1",
        )
        .bind_id(id)
        .execute()
        .await?;
    job_events::append(connection, id).await
}

/// Ends the leases of every other owner now; gives the number that had time left.
pub async fn release_dead_leases(
    connection: &mut Connection<'_>,
    except_owner: &str,
) -> Result<u64, CatalogueError> {
    connection
        .query(
            "UPDATE jobs SET lease_until = now_us()
             WHERE state = 'running' AND owner <> $1 AND lease_until > now_us()",
        )
        .bind(except_owner)
        .execute()
        .await
}
