//! The queue of jobs: put in, listed, followed by their events, and cancelled.

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use uuid::Uuid;

use super::lease::Signals;
use super::sweep::{self, SweepParams};
use super::training::{self, TrainingParams, UnfitExemplars};
use crate::database::{
    DatabaseError, ExemplarFilter, JobEventRow, JobFilter, JobRow, JobState, Name, Options, Rig,
};
use crate::store::{Actor, Catalogue, CatalogueError};

/// Why a call on a job failed.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// No job has that id.
    #[error("there is no job {id}")]
    Unknown {
        /// The id that was asked for.
        id: Uuid,
    },
    /// It can't be cancelled any more.
    #[error("job {id} has ended: it is {state}")]
    Ended {
        /// The job's id.
        id: Uuid,
        /// The word of its last state.
        state: &'static str,
    },
    /// There is nothing to train from.
    #[error("database {database} has no exemplars with a label")]
    NoExemplars {
        /// The database's name.
        database: String,
    },
    /// Negative exemplars, and signatures that have no use for them.
    #[error("database {database} has negative exemplars, which go with signatures of gradients")]
    Negative {
        /// The database's name.
        database: String,
    },
    /// A training would fail, by the rows of the exemplars.
    #[error("the exemplars of database {database} can't be trained with these options")]
    Unfit {
        /// The database's name.
        database: String,
        /// What is wrong with them.
        #[source]
        source: UnfitExemplars,
    },
    /// Something about the database, the calibration or a store.
    #[error(transparent)]
    Database(#[from] DatabaseError),
}

impl From<CatalogueError> for JobError {
    fn from(error: CatalogueError) -> Self {
        DatabaseError::from(error).into()
    }
}

/// The queue of jobs; cheap to clone.
#[derive(Clone)]
pub struct Jobs {
    pub(super) catalogue: Arc<Catalogue>,
    pub(super) signals: Signals,
}

/// Time between two reads of the events when nothing wakes the reader.
const EVENTS_POLL: Duration = Duration::from_millis(500);

impl Jobs {
    /// The queue kept in `catalogue`.
    pub fn new(catalogue: Arc<Catalogue>) -> Self {
        Self { catalogue, signals: Signals::default() }
    }

    /// Wakes the runner, and the readers of events.
    pub fn wake(&self) {
        self.signals.work.notify_one();
        self.signals.changed.notify_waiters();
    }

    /// Queues a training of the database.
    ///
    /// # Errors
    /// [`JobError::NoExemplars`], [`JobError::Negative`], [`JobError::Unfit`], or an unknown database.
    pub async fn train(
        &self,
        database: &Name,
        params: &TrainingParams,
        by: &Actor,
    ) -> Result<JobRow, JobError> {
        let name = database.as_str();
        let unknown = || DatabaseError::UnknownDatabase { database: database.to_string() };
        self.catalogue.database(name).await?.ok_or_else(unknown)?;
        if self.catalogue.database_counts(name).await?.labels == 0 {
            return Err(JobError::NoExemplars { database: database.to_string() });
        }
        match &params.options {
            Options::Objects(options) => {
                let exemplars = self.catalogue.training_set(name).await?;
                if let Some(source) = UnfitExemplars::among(&exemplars, options) {
                    return Err(JobError::Unfit { database: database.to_string(), source });
                }
            }
            Options::Landmarks(_) if params.options.have_gradients() => {}
            Options::Landmarks(_) => {
                let negative = ExemplarFilter { negative: Some(true), ..ExemplarFilter::default() };
                if !self.catalogue.exemplars(name, &negative, None, 1).await?.is_empty() {
                    return Err(JobError::Negative { database: database.to_string() });
                }
            }
        }
        let job = self.catalogue.enqueue_job(training::KIND, name, &params.to_document(), by).await?;
        self.signals.work.notify_one();
        Ok(job)
    }

    /// Queues a sweep of the rig.
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
        self.signals.work.notify_one();
        Ok(job)
    }

    /// One job.
    ///
    /// # Errors
    /// [`JobError::Unknown`], or the catalogue is away.
    pub async fn get(&self, id: Uuid) -> Result<JobRow, JobError> {
        let job = self.catalogue.job(id).await?;
        let _served = self.signals.publishing.read().await;
        job.ok_or(JobError::Unknown { id })
    }

    /// At most `limit` jobs, the newest first; `after` is the oldest one of the page before.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn list(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, JobError> {
        let jobs = self.catalogue.jobs(filter, after, limit).await?;
        let _served = self.signals.publishing.read().await;
        Ok(jobs)
    }

    /// Cancels a job: a waiting one at once, a running one at its next step.
    ///
    /// # Errors
    /// [`JobError::Unknown`], or [`JobError::Ended`] when it had ended before.
    pub async fn cancel(&self, id: Uuid, by: &Actor) -> Result<JobRow, JobError> {
        let before = self.get(id).await?;
        if before.state.is_terminal() {
            return Err(JobError::Ended { id, state: before.state.as_str() });
        }
        let cancelled = self.catalogue.request_cancel(id, by).await?;
        self.signals.changed.notify_waiters();
        cancelled.ok_or(JobError::Unknown { id })
    }

    /// The number of jobs in each state that has any.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn by_state(&self) -> Result<Vec<(JobState, u64)>, JobError> {
        Ok(self.catalogue.jobs_by_state().await?)
    }

    /// The events of a job after number `after`; waits for the next when there is none yet. Empty when the job has
    /// ended and there will be none.
    ///
    /// # Errors
    /// [`JobError::Unknown`], or the catalogue is away.
    pub async fn events_after(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, JobError> {
        loop {
            let changed = self.signals.changed.notified();
            let events = self.catalogue.job_events(id, after).await?;
            drop(self.signals.publishing.read().await);
            if !events.is_empty() {
                return Ok(events);
            }
            if self.get(id).await?.state.is_terminal() {
                // Its last event may have come between the two reads.
                return Ok(self.catalogue.job_events(id, after).await?);
            }
            let _ = tokio::time::timeout(EVENTS_POLL, changed).await;
        }
    }

    /// The events of all jobs after a moment, in order; at most a thousand.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn events_since(&self, moment: Timestamp) -> Result<Vec<JobEventRow>, JobError> {
        Ok(self.catalogue.job_events_since(moment).await?)
    }
}
