//! Statements on the tables `jobs`, `job_events` and `job_blobs`.
//!
//! Whatever changes a job's state or progress appends an event on the same connection, hence in the same
//! transaction. A worker's statements all say `id = … AND token = … AND state = 'running'`.

use std::time::Duration;

use sqlx::Row;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use uuid::Uuid;

use super::row::{id as read_id, now_us};
use super::{calibrations, databases};
use crate::store::job_end::{Outcome, Subject, attempts_exhausted};
use crate::store::row::{corrupt, optional_time, time, to_column, unsigned};
use crate::store::{CatalogueError, JobEventRow, JobFilter, JobRow, JobState, Progress, Renewal};

fn read(row: &SqliteRow) -> Result<JobRow, CatalogueError> {
    let database: String = row.try_get("database")?;
    Ok(JobRow {
        id: read_id(row, "id")?,
        kind: row.try_get("kind")?,
        database: Some(database).filter(|name| !name.is_empty()),
        calibration: row.try_get("calibration")?,
        params: row.try_get("params")?,
        state: read_state(row)?,
        progress: read_progress(row)?,
        token: row.try_get("token")?,
        owner: row.try_get("owner")?,
        lease_until: optional_time(row, "lease_until")?,
        cancel_requested: row.try_get("cancel_requested")?,
        attempts: unsigned(row, "attempts")?,
        version: row.try_get("version")?,
        problem: row.try_get("problem")?,
        comparison: row.try_get("comparison")?,
        created_at: time(row, "created_at")?,
        started_at: optional_time(row, "started_at")?,
        finished_at: optional_time(row, "finished_at")?,
    })
}

fn read_state(row: &SqliteRow) -> Result<JobState, CatalogueError> {
    let word: &str = row.try_get("state")?;
    word.parse().map_err(|_| corrupt(format!("a job's state is {word:?}")))
}

fn read_progress(row: &SqliteRow) -> Result<Option<Progress>, CatalogueError> {
    let stage: Option<String> = row.try_get("progress_stage")?;
    let Some(stage) = stage else { return Ok(None) };
    Ok(Some(Progress {
        stage,
        done: unsigned(row, "progress_done")?,
        total: unsigned(row, "progress_total")?,
    }))
}

fn read_event(row: &SqliteRow) -> Result<JobEventRow, CatalogueError> {
    Ok(JobEventRow {
        job: read_id(row, "id")?,
        sequence: row.try_get("sequence")?,
        body: read(row)?,
        created_at: time(row, "at")?,
    })
}

/// The moment a lease taken now runs out.
fn lease_end_us(lease: Duration) -> i64 {
    now_us().saturating_add(i64::try_from(lease.as_micros()).unwrap_or(i64::MAX))
}

/// Writes down the job as it is now.
async fn append_event(connection: &mut SqliteConnection, id: &str) -> Result<(), CatalogueError> {
    sqlx::query(
        "INSERT INTO job_events (job, sequence, at, state, progress_stage, progress_done, progress_total, token,
                                 owner, lease_until, cancel_requested, attempts, version, problem, comparison,
                                 started_at, finished_at)
         SELECT id, (SELECT coalesce(max(sequence), 0) + 1 FROM job_events WHERE job = ?1), ?2, state,
                progress_stage, progress_done, progress_total, token, owner, lease_until, cancel_requested,
                attempts, version, problem, comparison, started_at, finished_at
         FROM jobs WHERE id = ?1",
    )
    .bind(id)
    .bind(now_us())
    .execute(connection)
    .await?;
    Ok(())
}

pub async fn enqueue(
    connection: &mut SqliteConnection,
    kind: &str,
    database: &str,
    params: &str,
) -> Result<JobRow, CatalogueError> {
    if databases::find(connection, database).await?.is_none() {
        return Err(CatalogueError::no_database(database));
    }
    insert(connection, kind, database, None, params).await
}

pub async fn enqueue_for_calibration(
    connection: &mut SqliteConnection,
    kind: &str,
    calibration: &str,
    params: &str,
    blobs: &[String],
) -> Result<JobRow, CatalogueError> {
    if calibrations::find(connection, calibration).await?.is_none() {
        return Err(CatalogueError::no_calibration(calibration));
    }
    let job = insert(connection, kind, "", Some(calibration), params).await?;
    let id = job.id.to_string();
    for blob in blobs {
        sqlx::query("INSERT OR IGNORE INTO job_blobs (job, blob) VALUES (?1, ?2)")
            .bind(&id)
            .bind(blob)
            .execute(&mut *connection)
            .await?;
    }
    Ok(job)
}

async fn insert(
    connection: &mut SqliteConnection,
    kind: &str,
    database: &str,
    calibration: Option<&str>,
    params: &str,
) -> Result<JobRow, CatalogueError> {
    let id = Uuid::now_v7().to_string();
    let row = sqlx::query(
        "INSERT INTO jobs (id, kind, database, calibration, params, state, created_at)
         VALUES (?1, ?2, ?3, ?4, ?5, 'queued', ?6) RETURNING *",
    )
    .bind(&id)
    .bind(kind)
    .bind(database)
    .bind(calibration)
    .bind(params)
    .bind(now_us())
    .fetch_one(&mut *connection)
    .await?;
    append_event(connection, &id).await?;
    read(&row)
}

pub async fn find(connection: &mut SqliteConnection, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
    let row = sqlx::query("SELECT * FROM jobs WHERE id = ?1")
        .bind(id.to_string())
        .fetch_optional(connection)
        .await?;
    row.as_ref().map(read).transpose()
}

pub async fn list(
    connection: &mut SqliteConnection,
    filter: &JobFilter,
    after: Option<Uuid>,
    limit: u32,
) -> Result<Vec<JobRow>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT * FROM jobs
         WHERE (?1 IS NULL OR database = ?1) AND (?5 IS NULL OR calibration = ?5)
           AND (?2 IS NULL OR state = ?2) AND (?3 IS NULL OR id < ?3)
         ORDER BY id DESC LIMIT ?4",
    )
    .bind(&filter.database)
    .bind(filter.state.map(JobState::as_str))
    .bind(after.map(|id| id.to_string()))
    .bind(limit)
    .bind(&filter.calibration)
    .fetch_all(connection)
    .await?;
    rows.iter().map(read).collect()
}

/// Claims the oldest job that can be, ending the ones before it that can't go on.
///
/// Every turn but the last ends one job for good, so the loop ends.
pub async fn claim(
    connection: &mut SqliteConnection,
    owner: &str,
    kinds: &[&str],
    lease: Duration,
    max_attempts: u32,
) -> Result<Option<JobRow>, CatalogueError> {
    let kinds = serde_json::json!(kinds).to_string();
    loop {
        let row = sqlx::query(
            "SELECT * FROM jobs
             WHERE state IN ('queued', 'running') AND (state = 'queued' OR lease_until <= ?1)
               AND kind IN (SELECT value FROM json_each(?2))
             ORDER BY id LIMIT 1",
        )
        .bind(now_us())
        .bind(&kinds)
        .fetch_optional(&mut *connection)
        .await?;
        let Some(row) = row else { return Ok(None) };
        let job = read(&row)?;
        if job.cancel_requested {
            end(connection, job.id, JobState::Cancelled, Outcome::default()).await?;
        } else if job.attempts >= max_attempts {
            let problem = attempts_exhausted(job.attempts);
            let outcome = Outcome { problem: Some(&problem), ..Outcome::default() };
            end(connection, job.id, JobState::Failed, outcome).await?;
        } else {
            return take(connection, job.id, owner, lease).await.map(Some);
        }
    }
}

async fn take(
    connection: &mut SqliteConnection,
    id: Uuid,
    owner: &str,
    lease: Duration,
) -> Result<JobRow, CatalogueError> {
    let id = id.to_string();
    let row = sqlx::query(
        "UPDATE jobs
         SET state = 'running', token = token + 1, attempts = attempts + 1, owner = ?2, lease_until = ?3,
             progress_stage = NULL, progress_done = NULL, progress_total = NULL,
             started_at = coalesce(started_at, ?4)
         WHERE id = ?1 RETURNING *",
    )
    .bind(&id)
    .bind(owner)
    .bind(lease_end_us(lease))
    .bind(now_us())
    .fetch_one(&mut *connection)
    .await?;
    append_event(connection, &id).await?;
    read(&row)
}

/// Ends a job whoever holds it.
async fn end(
    connection: &mut SqliteConnection,
    id: Uuid,
    state: JobState,
    outcome: Outcome<'_>,
) -> Result<JobRow, CatalogueError> {
    let id = id.to_string();
    let row = sqlx::query(
        "UPDATE jobs SET state = ?2, version = ?3, problem = ?4, comparison = ?6, lease_until = NULL,
                         finished_at = ?5
         WHERE id = ?1 RETURNING *",
    )
    .bind(&id)
    .bind(state.as_str())
    .bind(outcome.version)
    .bind(outcome.problem)
    .bind(now_us())
    .bind(outcome.comparison)
    .fetch_one(&mut *connection)
    .await?;
    append_event(connection, &id).await?;
    read(&row)
}

/// Gives the job that this token still holds.
pub async fn held(connection: &mut SqliteConnection, id: Uuid, token: i64) -> Result<JobRow, CatalogueError> {
    let row = sqlx::query("SELECT * FROM jobs WHERE id = ?1 AND token = ?2 AND state = 'running'")
        .bind(id.to_string())
        .bind(token)
        .fetch_optional(connection)
        .await?;
    read(&row.ok_or(CatalogueError::LeaseLost)?)
}

/// Gives the job that this token still holds, unless it was asked to end: then nothing may come of it any more.
pub async fn held_and_wanted(
    connection: &mut SqliteConnection,
    id: Uuid,
    token: i64,
) -> Result<JobRow, CatalogueError> {
    let row = held(connection, id, token).await?;
    if row.cancel_requested { Err(CatalogueError::CancelRequested) } else { Ok(row) }
}

/// Ends a job that this token holds.
pub async fn finish(
    connection: &mut SqliteConnection,
    id: Uuid,
    token: i64,
    state: JobState,
    outcome: Outcome<'_>,
) -> Result<JobRow, CatalogueError> {
    held(connection, id, token).await?;
    end(connection, id, state, outcome).await
}

pub async fn renew(
    connection: &mut SqliteConnection,
    id: Uuid,
    token: i64,
    lease: Duration,
    progress: Option<&Progress>,
) -> Result<Renewal, CatalogueError> {
    let before = held(connection, id, token).await?;
    let after = progress.or(before.progress.as_ref());
    sqlx::query(
        "UPDATE jobs SET lease_until = ?2, progress_stage = ?3, progress_done = ?4, progress_total = ?5
         WHERE id = ?1",
    )
    .bind(id.to_string())
    .bind(lease_end_us(lease))
    .bind(after.map(|progress| progress.stage.as_str()))
    .bind(after.map(|progress| to_column(progress.done)))
    .bind(after.map(|progress| to_column(progress.total)))
    .execute(&mut *connection)
    .await?;
    if after != before.progress.as_ref() {
        append_event(connection, &id.to_string()).await?;
    }
    Ok(Renewal { cancel_requested: before.cancel_requested })
}

pub async fn request_cancel(
    connection: &mut SqliteConnection,
    id: Uuid,
) -> Result<Option<JobRow>, CatalogueError> {
    let Some(job) = find(connection, id).await? else { return Ok(None) };
    match job.state {
        JobState::Queued => end(connection, id, JobState::Cancelled, Outcome::default()).await.map(Some),
        JobState::Running => {
            let row = sqlx::query("UPDATE jobs SET cancel_requested = 1 WHERE id = ?1 RETURNING *")
                .bind(id.to_string())
                .fetch_one(connection)
                .await?;
            read(&row).map(Some)
        }
        JobState::Succeeded | JobState::Failed | JobState::Cancelled => Ok(Some(job)),
    }
}

/// Cancels the unfinished jobs about what is being deleted.
pub async fn cancel_all(
    connection: &mut SqliteConnection,
    subject: Subject<'_>,
) -> Result<(), CatalogueError> {
    let rows = sqlx::query(
        "SELECT * FROM jobs WHERE (database = ?1 OR calibration = ?2) AND state IN ('queued', 'running')",
    )
    .bind(subject.database())
    .bind(subject.calibration())
    .fetch_all(&mut *connection)
    .await?;
    let problem = subject.deleted();
    for row in &rows {
        let outcome = Outcome { problem: Some(&problem), ..Outcome::default() };
        end(connection, read_id(row, "id")?, JobState::Cancelled, outcome).await?;
    }
    Ok(())
}

pub async fn hand_back(connection: &mut SqliteConnection, owner: &str) -> Result<u64, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM jobs WHERE owner = ?1 AND state = 'running'")
        .bind(owner)
        .fetch_all(&mut *connection)
        .await?;
    for row in &rows {
        let job = read(row)?;
        if job.cancel_requested {
            end(connection, job.id, JobState::Cancelled, Outcome::default()).await?;
        } else {
            requeue(connection, job.id).await?;
        }
    }
    Ok(rows.len() as u64)
}

async fn requeue(connection: &mut SqliteConnection, id: Uuid) -> Result<(), CatalogueError> {
    let id = id.to_string();
    sqlx::query(
        "UPDATE jobs
         SET state = 'queued', attempts = attempts - 1, owner = NULL, lease_until = NULL,
             progress_stage = NULL, progress_done = NULL, progress_total = NULL
         WHERE id = ?1",
    )
    .bind(&id)
    .execute(&mut *connection)
    .await?;
    append_event(connection, &id).await
}

pub async fn release_dead_leases(
    connection: &mut SqliteConnection,
    except_owner: &str,
) -> Result<u64, CatalogueError> {
    let now_us = now_us();
    let done = sqlx::query(
        "UPDATE jobs SET lease_until = ?2 WHERE state = 'running' AND owner <> ?1 AND lease_until > ?2",
    )
    .bind(except_owner)
    .bind(now_us)
    .execute(connection)
    .await?;
    Ok(done.rows_affected())
}

pub async fn events(
    connection: &mut SqliteConnection,
    id: Uuid,
    after: i64,
) -> Result<Vec<JobEventRow>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT j.id, j.kind, j.database, j.calibration, j.params, j.created_at, e.*
         FROM job_events e JOIN jobs j ON j.id = e.job
         WHERE e.job = ?1 AND e.sequence > ?2 ORDER BY e.sequence",
    )
    .bind(id.to_string())
    .bind(after)
    .fetch_all(connection)
    .await?;
    rows.iter().map(read_event).collect()
}

pub async fn count_by_state(
    connection: &mut SqliteConnection,
) -> Result<Vec<(JobState, u64)>, CatalogueError> {
    let rows = sqlx::query("SELECT state, count(*) AS jobs FROM jobs GROUP BY state ORDER BY state")
        .fetch_all(connection)
        .await?;
    rows.iter().map(|row| Ok((read_state(row)?, unsigned(row, "jobs")?))).collect()
}
