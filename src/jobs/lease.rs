//! The lease of a running job. Renewing it writes the job's progress and reads whether the job was cancelled or lost.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::{Mutex, Notify, RwLock, RwLockWriteGuard};
use uuid::Uuid;

use super::stop::Stop;
use crate::database::Progress;
use crate::store::{Catalogue, CatalogueError};

/// How long a silent worker keeps its job: three missed renewals.
pub const WORKER_LEASE: Duration = Duration::from_secs(15);
/// Time between two renewals; a request to cancel is seen at the latest then.
const RENEW_EVERY: Duration = Duration::from_secs(2);
/// Least time between two writes of progress: four a second are enough for a person's eye.
const WRITE_PROGRESS_EVERY: Duration = Duration::from_millis(250);

/// How the queue, the runner and its jobs wake each other within a process.
#[derive(Clone, Default)]
pub(super) struct Signals {
    /// Notified when there is something to claim or to cancel.
    pub(super) work: Arc<Notify>,
    /// Notified when a job of this process changed; changes by other processes are found by polling.
    pub(super) changed: Arc<Notify>,
    /// Locked for writing from before a job's success until this process serves what it made: a caller that has read
    /// of the success gets the new version.
    pub(super) publishing: Arc<RwLock<()>>,
}

/// The lease of one job.
#[derive(Clone)]
pub(super) struct Lease {
    pub(super) id: Uuid,
    pub(super) token: i64,
    catalogue: Arc<Catalogue>,
    signals: Signals,
    state: Arc<LeaseState>,
}

#[derive(Default)]
struct LeaseState {
    is_cancelled: AtomicBool,
    is_lost: AtomicBool,
    written: Mutex<Option<WrittenProgress>>,
}

struct WrittenProgress {
    at: Instant,
    stage: String,
}

impl Lease {
    pub(super) fn new(id: Uuid, token: i64, catalogue: Arc<Catalogue>, signals: Signals) -> Self {
        Self { id, token, catalogue, signals, state: Arc::default() }
    }

    /// Writes the job's progress, at most once every [`WRITE_PROGRESS_EVERY`] but for the first of a stage.
    ///
    /// # Errors
    /// The job is cancelled or lost.
    pub(super) async fn progress(&self, stage: &str, done: u64, total: u64) -> Result<(), Stop> {
        self.check()?;
        let mut written = self.state.written.lock().await;
        let is_due = written
            .as_ref()
            .is_none_or(|last| last.stage != stage || last.at.elapsed() >= WRITE_PROGRESS_EVERY);
        if is_due {
            *written = Some(WrittenProgress { at: Instant::now(), stage: stage.into() });
            drop(written);
            self.renew(Some(&Progress { stage: stage.into(), done, total })).await;
        }
        self.check()
    }

    /// The lock to hold from before the job's success until this process serves what it made.
    pub(super) async fn publishing(&self) -> RwLockWriteGuard<'_, ()> {
        self.signals.publishing.write().await
    }

    /// Whether the job may go on.
    ///
    /// # Errors
    /// The job is cancelled or lost.
    pub(super) fn check(&self) -> Result<(), Stop> {
        if self.state.is_lost.load(Ordering::Relaxed) {
            return Err(Stop::Lost);
        }
        if self.state.is_cancelled.load(Ordering::Relaxed) {
            return Err(Stop::Cancelled);
        }
        Ok(())
    }

    /// Renews the lease for as long as it is polled.
    pub(super) async fn keep_alive(&self) -> Infallible {
        loop {
            tokio::time::sleep(RENEW_EVERY).await;
            self.renew(None).await;
        }
    }

    async fn renew(&self, progress: Option<&Progress>) {
        match self.catalogue.renew_job(self.id, self.token, WORKER_LEASE, progress).await {
            Ok(renewal) => {
                if renewal.cancel_requested {
                    self.state.is_cancelled.store(true, Ordering::Relaxed);
                }
                if progress.is_some() {
                    self.signals.changed.notify_waiters();
                }
            }
            Err(CatalogueError::LeaseLost) => self.state.is_lost.store(true, Ordering::Relaxed),
            // The lease runs on; if the catalogue stays away it expires and the job is claimed again.
            Err(error) => tracing::warn!(job = %self.id, %error, "can't renew the lease"),
        }
    }
}
