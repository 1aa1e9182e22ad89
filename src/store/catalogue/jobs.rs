//! The queue of jobs.

use std::time::Duration;

use jiff::Timestamp;
use serde_json::json;
use uuid::Uuid;

use super::Catalogue;
use super::databases::set_alias;
use crate::store::error::CatalogueError;
use crate::store::query::Connection;
use crate::store::session::{statement, transaction};
use crate::store::tables::aliases::AliasExpectation;
use crate::store::tables::audit::{self, Actor, NewEntry, parse_document};
use crate::store::tables::calibrations::{self, CalibrationRow};
use crate::store::tables::databases;
use crate::store::tables::job_events::{self, JobEventRow};
use crate::store::tables::job_row::{JobRow, Progress};
use crate::store::tables::job_state::JobState;
use crate::store::tables::jobs::{self, JobFilter, Outcome, Renewal, Subject};
use crate::store::tables::versions::{self, NewVersion, VersionRow};

impl Catalogue {
    /// Adds a job about a database to the queue.
    ///
    /// # Errors
    /// `NotFound` for the database; `Unavailable`, `Corrupt`.
    pub async fn enqueue_job(
        &self,
        kind: &str,
        database: &str,
        params: &str,
        actor: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::enqueue(c, kind, Subject::Database(database), params).await?;
            let detail = json!({"kind": kind, "params": parse_document(params)});
            audit::append(c, actor, NewEntry::new("job.queue").in_database(database).about(job.id).with(detail)).await?;
            c.notifies = true;
            Ok(job)
        })
    }

    /// Adds a job about a calibration to the queue, with the blobs that it will read: they count as named until it has
    /// ended, and must be stored before.
    ///
    /// # Errors
    /// `NotFound` for the calibration; `Unavailable`, `Corrupt`.
    pub async fn enqueue_calibration_job(
        &self,
        kind: &str,
        calibration: &str,
        params: &str,
        blobs: &[String],
        actor: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::enqueue(c, kind, Subject::Calibration(calibration), params).await?;
            jobs::keep_blobs(c, job.id, blobs).await?;
            let detail = json!({"job": job.id, "kind": kind});
            audit::append(c, actor, NewEntry::new("job.queue").about(calibration).with(detail)).await?;
            c.notifies = true;
            Ok(job)
        })
    }

    /// The job of that id.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn job(&self, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
        statement!(self, c => jobs::find(c, id).await)
    }

    /// Jobs, the newest first; `after` is the oldest one seen.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn jobs(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, CatalogueError> {
        statement!(self, c => jobs::list(c, filter, after, limit).await)
    }

    /// What happened to a job after the event `after` (0: from its first state on), in order.
    ///
    /// Every change of state or progress appends one event in the transaction that makes it.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn job_events(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, CatalogueError> {
        statement!(self, c => job_events::list(c, id, after).await)
    }

    /// What happened to all jobs after a moment, in order; at most a thousand events.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn job_events_since(&self, moment: Timestamp) -> Result<Vec<JobEventRow>, CatalogueError> {
        statement!(self, c => job_events::since(c, moment).await)
    }

    /// How many jobs there are in each state that has any.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn jobs_by_state(&self) -> Result<Vec<(JobState, u64)>, CatalogueError> {
        statement!(self, c => jobs::count_by_state(c).await)
    }

    /// Gives the oldest job of these kinds that waits, or whose lease ran out, to this worker.
    ///
    /// Its token and its attempts grow by one and its progress starts again. On the way, a job that was asked to end
    /// becomes `cancelled`, and one that was claimed `max_attempts` times becomes `failed`.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn claim_job(
        &self,
        owner: &str,
        kinds: &[&str],
        lease: Duration,
        max_attempts: u32,
    ) -> Result<Option<JobRow>, CatalogueError> {
        transaction!(self, c => jobs::claim(c, owner, kinds, lease, max_attempts).await)
    }

    /// Extends the lease to `lease` from now, and notes the progress when it is given.
    ///
    /// # Errors
    /// `LeaseLost`; `Unavailable`, `Corrupt`.
    pub async fn renew_job(
        &self,
        id: Uuid,
        token: i64,
        lease: Duration,
        progress: Option<&Progress>,
    ) -> Result<Renewal, CatalogueError> {
        transaction!(self, c => jobs::renew(c, id, token, lease, progress).await)
    }

    /// Ends a job with a version: its row, the alias if one is named, and the job's success, in one transaction.
    ///
    /// The version of that digest is taken where there is one already. What came of comparing it (JSON) is kept with
    /// the job.
    ///
    /// # Errors
    /// `LeaseLost`, `CancelRequested`, `NotFound` for the database; then nothing has changed. `Unavailable`, `Corrupt`.
    pub async fn publish(
        &self,
        id: Uuid,
        token: i64,
        new: &NewVersion,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<VersionRow, CatalogueError> {
        transaction!(self, c => {
            let version = insert_version(c, id, token, new, promote_alias).await?;
            let outcome = Outcome { version: Some(version.version), comparison, ..Outcome::default() };
            jobs::succeed(c, id, token, outcome).await?;
            Ok(version)
        })
    }

    /// The same for a job that goes on: its version is noted, and stays whatever becomes of the job.
    ///
    /// # Errors
    /// As those of [`Catalogue::publish`].
    pub async fn publish_early(
        &self,
        id: Uuid,
        token: i64,
        new: &NewVersion,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<VersionRow, CatalogueError> {
        transaction!(self, c => {
            let version = insert_version(c, id, token, new, promote_alias).await?;
            jobs::note_version(c, id, token, version.version, comparison).await?;
            c.notifies = true;
            Ok(version)
        })
    }

    /// Ends a job with another report for the version that it published early, if that is still there.
    ///
    /// # Errors
    /// `LeaseLost`, `CancelRequested`; then nothing has changed. `Unavailable`, `Corrupt`.
    pub async fn succeed_with_report(
        &self,
        id: Uuid,
        token: i64,
        database: &str,
        version: i64,
        report: &str,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            lock_subject(c, id).await?;
            let outcome = Outcome { version: Some(version), ..Outcome::default() };
            let job = jobs::succeed(c, id, token, outcome).await?;
            versions::set_report(c, database, version, report).await?;
            let entry = NewEntry::new("version.check").in_database(database).about(version);
            audit::append(c, &Actor::job(id), entry).await?;
            Ok(job)
        })
    }

    /// Ends a job with what it found out about its calibration: the document, if that is still at the revision
    /// `expected`, and the job's success, in one transaction.
    ///
    /// # Errors
    /// `LeaseLost`, `CancelRequested`, `PreconditionFailed`; then nothing has changed. `Unavailable`, `Corrupt`.
    pub async fn publish_calibration(
        &self,
        id: Uuid,
        token: i64,
        document: &str,
        expected: i64,
    ) -> Result<CalibrationRow, CatalogueError> {
        transaction!(self, c => {
            lock_subject(c, id).await?;
            let job = jobs::succeed(c, id, token, Outcome::default()).await?;
            let name = job.calibration.unwrap_or_default();
            let row = calibrations::put(c, &name, document, Some(expected)).await?;
            audit::append(c, &Actor::job(id), NewEntry::new("calibration.put").about(&name)).await?;
            Ok(row)
        })
    }

    /// Ends a job that needed no new version: the one it found, the alias if one is named, and its success.
    ///
    /// An alias is moved only when there is a version.
    ///
    /// # Errors
    /// `LeaseLost`, `CancelRequested`, `NotFound` for the version; then nothing has changed. `Unavailable`, `Corrupt`.
    pub async fn succeed_job(
        &self,
        id: Uuid,
        token: i64,
        version: Option<i64>,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            lock_subject(c, id).await?;
            let outcome = Outcome { version, comparison, ..Outcome::default() };
            let job = jobs::succeed(c, id, token, outcome).await?;
            if let Some(version) = version {
                let database = job.database.as_deref().unwrap_or_default();
                if versions::find(c, database, version).await?.is_none() {
                    return Err(CatalogueError::no_version(database, version));
                }
                if let Some(alias) = promote_alias {
                    let any = AliasExpectation::Any;
                    set_alias(c, database, alias, version, any, &Actor::job(id)).await?;
                }
            }
            Ok(job)
        })
    }

    /// Ends a job with a problem (JSON with at least `code` and `detail`).
    ///
    /// # Errors
    /// `LeaseLost`; `Unavailable`, `Corrupt`.
    pub async fn fail_job(&self, id: Uuid, token: i64, problem: &str) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let outcome = Outcome { problem: Some(problem), ..Outcome::default() };
            jobs::finish(c, id, token, JobState::Failed, outcome).await
        })
    }

    /// Ends a job that was asked to end.
    ///
    /// # Errors
    /// `LeaseLost`; `Unavailable`, `Corrupt`.
    pub async fn cancelled_job(&self, id: Uuid, token: i64) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => jobs::finish(c, id, token, JobState::Cancelled, Outcome::default()).await)
    }

    /// Asks a job to end: a queued one is cancelled at once, a running one is flagged, a finished one stays.
    ///
    /// None when there is no such job.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn request_cancel(&self, id: Uuid, actor: &Actor) -> Result<Option<JobRow>, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::request_cancel(c, id).await?;
            if let Some(job) = &job {
                let entry = NewEntry::new("job.cancel").in_database(job.database.as_deref());
                audit::append(c, actor, entry.about(id)).await?;
            }
            c.notifies = true;
            Ok(job)
        })
    }

    /// Puts a worker's running jobs back into the queue, the attempt not counted; gives their number.
    ///
    /// One that was asked to end is cancelled. For graceful shutdown.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn hand_back_jobs(&self, owner: &str) -> Result<u64, CatalogueError> {
        transaction!(self, c => {
            let handed_back = jobs::hand_back(c, owner).await?;
            c.notifies = true;
            Ok(handed_back)
        })
    }

    /// Ends the leases of every other owner now; gives the number that had time left.
    ///
    /// Only for an embedded catalogue, where holding the folder's lock proves that every other owner is dead. A shared
    /// one leaves them to run out, and gives 0.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn release_dead_leases(&self, except_owner: &str) -> Result<u64, CatalogueError> {
        if self.is_shared() {
            return Ok(0);
        }
        transaction!(self, c => jobs::release_dead_leases(c, except_owner).await)
    }
}

/// Adds the version of a job that may publish, or finds the one of that digest, and moves the alias if one is named.
async fn insert_version(
    connection: &mut Connection<'_>,
    id: Uuid,
    token: i64,
    new: &NewVersion,
    promote_alias: Option<&str>,
) -> Result<VersionRow, CatalogueError> {
    let is_there = databases::lock(connection, &new.database).await?;
    jobs::lock_uncancelled(connection, id, token).await?;
    if !is_there {
        return Err(CatalogueError::no_database(&new.database));
    }
    let (version, is_new) = versions::insert(connection, new).await?;
    if is_new {
        let entry =
            NewEntry::new("version.publish").in_database(new.database.as_str()).about(version.version);
        audit::append(connection, &Actor::job(id), entry.with(json!({"digest": new.digest}))).await?;
    }
    if let Some(alias) = promote_alias {
        let any = AliasExpectation::Any;
        set_alias(connection, &new.database, alias, version.version, any, &Actor::job(id)).await?;
    }
    Ok(version)
}

/// Locks what a job is about: that comes before the job's own row.
async fn lock_subject(connection: &mut Connection<'_>, job: Uuid) -> Result<(), CatalogueError> {
    let Some(job) = jobs::find(connection, job).await? else { return Ok(()) };
    if let Some(database) = &job.database {
        databases::lock(connection, database).await?;
    }
    if let Some(calibration) = &job.calibration {
        calibrations::lock(connection, calibration).await?;
    }
    Ok(())
}
