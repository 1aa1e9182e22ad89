//! Jobs: long work that survives a restart. The queue's door, the runner, and one file per kind of job.
//!
//! A job is a row of the catalogue. Whoever claims it holds a lease and a token; a worker that lost its lease can
//! finish nothing, so a job ends exactly once. Every change of a job is an event with a number, kept with it.

mod runner;
mod sweep;
mod training;

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{Notify, RwLock};
use uuid::Uuid;

use crate::database::{DatabaseError, JobEventRow, JobFilter, JobRow, JobState, Name, Options, Rig};
use crate::store::{Actor, Catalogue, CatalogueError};
pub use runner::{Runner, WORKER_LEASE};
pub use sweep::{SweepParams, SweepPlane, sweep_problem};
pub use training::{Promote, TrainingParams, UnfitExemplars, VersionComparison};

/// Why a call on a job failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    #[error("there is no job {id}")]
    Unknown { id: Uuid },
    #[error("job {id} has ended: it is {state}")]
    Ended { id: Uuid, state: &'static str },
    #[error("database {database} has no exemplars")]
    NoExemplars { database: String },
    #[error("the exemplars of database {database} can't be trained with these options")]
    Unfit {
        database: String,
        #[source]
        source: UnfitExemplars,
    },
    #[error(transparent)]
    Database(#[from] DatabaseError),
}

/// The queue of jobs; cheap to clone.
#[derive(Clone)]
pub struct Jobs {
    catalogue: Arc<dyn Catalogue>,
    /// Woken when there is something to claim or to cancel.
    work: Arc<Notify>,
    /// Woken when a job of this process changed; other processes' changes are found by polling.
    changed: Arc<Notify>,
    /// Written from a job's success until this process serves what it made: whoever reads of the success and asks
    /// next gets the new version.
    publishing: Arc<RwLock<()>>,
}

/// How long a reader of events waits before it looks again by itself.
const EVENTS_POLL: Duration = Duration::from_millis(500);

impl Jobs {
    /// The queue kept in `catalogue`.
    pub fn new(catalogue: Arc<dyn Catalogue>) -> Self {
        Self { catalogue, work: Arc::default(), changed: Arc::default(), publishing: Arc::default() }
    }

    /// Have those who wait for jobs, or for changes of one, look again.
    pub fn wake(&self) {
        self.work.notify_one();
        self.changed.notify_waiters();
    }

    /// Queue a training of the database.
    ///
    /// # Errors
    /// [`JobError::NoExemplars`], [`JobError::Unfit`], or an unknown database.
    pub async fn train(
        &self,
        database: &Name,
        params: &TrainingParams,
        by: &Actor,
    ) -> Result<JobRow, JobError> {
        let unknown = || DatabaseError::UnknownDatabase { database: database.to_string() };
        let known = self.catalogue.database(database.as_str()).await.map_err(DatabaseError::from)?;
        known.ok_or_else(unknown)?;
        let counts = self.catalogue.database_counts(database.as_str()).await.map_err(DatabaseError::from)?;
        if counts.exemplars == 0 {
            return Err(JobError::NoExemplars { database: database.to_string() });
        }
        if let Options::Objects(options) = &params.options {
            let exemplars =
                self.catalogue.training_set(database.as_str()).await.map_err(DatabaseError::from)?;
            UnfitExemplars::among(&exemplars, options)
                .map_or(Ok(()), |source| Err(JobError::Unfit { database: database.to_string(), source }))?;
        }
        let queued =
            self.catalogue.enqueue_job(training::KIND, database.as_str(), &params.to_document(), by).await;
        let job = queued.map_err(DatabaseError::from)?;
        self.work.notify_one();
        Ok(job)
    }

    /// Queue a sweep of the rig.
    ///
    /// # Errors
    /// An unknown calibration.
    pub async fn sweep(&self, rig: &Rig, params: &SweepParams, by: &Actor) -> Result<JobRow, JobError> {
        let (document, blobs) = (params.to_document(), params.blobs());
        let queued =
            self.catalogue.enqueue_calibration_job(sweep::KIND, &rig.name, &document, &blobs, by).await;
        let job = queued.map_err(|error| match error {
            CatalogueError::NotFound { .. } => {
                DatabaseError::UnknownCalibration { calibration: rig.name.clone() }
            }
            error => error.into(),
        })?;
        self.work.notify_one();
        Ok(job)
    }

    /// One job.
    ///
    /// # Errors
    /// [`JobError::Unknown`].
    pub async fn get(&self, id: Uuid) -> Result<JobRow, JobError> {
        let job = self.catalogue.job(id).await.map_err(DatabaseError::from)?;
        let _served = self.publishing.read().await;
        job.ok_or(JobError::Unknown { id })
    }

    /// Jobs, the newest first; `after` is the oldest one seen.
    pub async fn list(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, JobError> {
        let jobs = self.catalogue.jobs(filter, after, limit).await.map_err(DatabaseError::from)?;
        let _served = self.publishing.read().await;
        Ok(jobs)
    }

    /// Ask a job to end. A running one ends at its next step.
    ///
    /// # Errors
    /// [`JobError::Unknown`], or [`JobError::Ended`] when it had ended before.
    pub async fn cancel(&self, id: Uuid, by: &Actor) -> Result<JobRow, JobError> {
        let before = self.get(id).await?;
        if before.state.is_terminal() {
            return Err(JobError::Ended { id, state: before.state.as_str() });
        }
        let asked = self.catalogue.request_cancel(id, by).await.map_err(DatabaseError::from)?;
        self.changed.notify_waiters();
        asked.ok_or(JobError::Unknown { id })
    }

    /// How many jobs there are in each state that has any.
    pub async fn by_state(&self) -> Result<Vec<(JobState, u64)>, JobError> {
        Ok(self.catalogue.jobs_by_state().await.map_err(DatabaseError::from)?)
    }

    /// The events of a job after number `after`, waiting for the next when there is none yet; empty when the job
    /// has ended and there will be none.
    pub async fn events_after(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, JobError> {
        loop {
            let changed = self.changed.notified();
            let events = self.catalogue.job_events(id, after).await.map_err(DatabaseError::from)?;
            drop(self.publishing.read().await);
            if !events.is_empty() {
                return Ok(events);
            }
            if self.get(id).await?.state.is_terminal() {
                // Its last event may have come between the two looks.
                return Ok(self.catalogue.job_events(id, after).await.map_err(DatabaseError::from)?);
            }
            let _ = tokio::time::timeout(EVENTS_POLL, changed).await;
        }
    }
}
