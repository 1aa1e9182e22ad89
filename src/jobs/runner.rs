//! The runner: claims jobs one after another, keeps their lease alive, and ends each exactly once.

use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::{Mutex, RwLockWriteGuard, watch};
use uuid::Uuid;

use super::{Jobs, sweep, training};
use crate::compute::{Compute, ComputeError};
use crate::database::{DatabaseError, Databases, JobRow, Progress};
use crate::store::CatalogueError;
use crate::telemetry::{Metrics, chain};
use landmarkd_core::imaging::DecodeLimits;

/// How long a silent worker keeps its job: three missed renewals.
pub const WORKER_LEASE: Duration = Duration::from_secs(15);
/// How often a lease is renewed, and a wish to cancel is heard at the latest.
const RENEW_EVERY: Duration = Duration::from_secs(2);
/// The shortest time between two notes of progress: four a second are enough for a person's eye.
const NOTE_EVERY: Duration = Duration::from_millis(250);
/// How long an idle runner sleeps before it looks for jobs that other processes queued.
const IDLE_POLL: Duration = Duration::from_secs(1);
/// How long a job waits in its worker when a store is away.
const OUTAGE_PAUSE: Duration = Duration::from_secs(2);
/// Claims of one job before it counts as deadly: a job that kills its worker five times would kill it again.
const MAX_ATTEMPTS: u32 = 5;

/// Why a job stopped before its end.
#[derive(Debug)]
pub(super) enum Stop {
    /// Somebody asked for it.
    Cancelled,
    /// Another worker has it now, or the service is shutting down: leave it alone.
    Lost,
    /// It can't be done; the problem is kept with the job.
    Failed { code: &'static str, detail: String },
    /// A store is away: the job goes back into the queue.
    Unavailable { error: DatabaseError },
}

impl From<DatabaseError> for Stop {
    fn from(error: DatabaseError) -> Self {
        match error {
            DatabaseError::Catalogue { source: CatalogueError::LeaseLost } => Self::Lost,
            DatabaseError::Catalogue { source: CatalogueError::CancelRequested } => Self::Cancelled,
            DatabaseError::Catalogue { source: CatalogueError::NotFound { what } } => {
                Self::Failed { code: "unknown_database", detail: format!("{what}; it was deleted meanwhile") }
            }
            error @ DatabaseError::LostExemplar { .. } => Self::Failed {
                code: "unreadable_exemplar",
                detail: format!(
                    "{}; post the same picture again, or delete it, and train again",
                    chain(&error)
                ),
            },
            DatabaseError::Blobs { source } if source.is_damage() => {
                Self::Failed { code: "unreadable_picture", detail: chain(&source) }
            }
            DatabaseError::Unloadable { reason, .. } => Self::Failed {
                code: "internal",
                detail: format!("the new version can't be read back: {reason}"),
            },
            DatabaseError::Compute { source: ComputeError::Panicked { message } } => {
                Self::Failed { code: "internal", detail: format!("the computation failed: {message}") }
            }
            error @ DatabaseError::CalibrationChanged { .. } => {
                Self::Failed { code: "calibration_changed", detail: format!("{error}: sweep it again") }
            }
            error @ DatabaseError::UnknownCalibration { .. } => Self::Failed {
                code: "unknown_calibration",
                detail: format!("{error}; it was deleted meanwhile"),
            },
            error @ DatabaseError::UnreadableCalibration { .. } => {
                Self::Failed { code: "internal", detail: chain(&error) }
            }
            error => Self::Unavailable { error },
        }
    }
}

impl From<CatalogueError> for Stop {
    fn from(error: CatalogueError) -> Self {
        DatabaseError::from(error).into()
    }
}

/// A running job's tie to the catalogue: its lease, its progress, the wish to cancel it.
#[derive(Clone)]
pub(super) struct Lease {
    pub(super) id: Uuid,
    pub(super) token: i64,
    jobs: Jobs,
    stop: Arc<StopWish>,
    noted: Arc<Mutex<Option<Noted>>>,
}

#[derive(Default)]
struct StopWish {
    cancelled: AtomicBool,
    lost: AtomicBool,
}

struct Noted {
    at: Instant,
    stage: String,
}

impl Lease {
    /// Say how far the job is; the reply says whether to go on. Notes come at most every [`NOTE_EVERY`], but for
    /// the first of a stage.
    pub(super) async fn progress(&self, stage: &str, done: u64, total: u64) -> Result<(), Stop> {
        self.go_on()?;
        let mut noted = self.noted.lock().await;
        let due = noted.as_ref().is_none_or(|last| last.stage != stage || last.at.elapsed() >= NOTE_EVERY);
        if due {
            *noted = Some(Noted { at: Instant::now(), stage: stage.into() });
            drop(noted);
            self.renew(Some(&Progress { stage: stage.into(), done, total })).await;
        }
        self.go_on()
    }

    /// Held from before the job's success until this process serves what it made.
    pub(super) async fn publishing(&self) -> RwLockWriteGuard<'_, ()> {
        self.jobs.publishing.write().await
    }

    /// Whether the job should go on.
    pub(super) fn go_on(&self) -> Result<(), Stop> {
        if self.stop.lost.load(Ordering::Relaxed) {
            return Err(Stop::Lost);
        }
        if self.stop.cancelled.load(Ordering::Relaxed) {
            return Err(Stop::Cancelled);
        }
        Ok(())
    }

    async fn renew(&self, progress: Option<&Progress>) {
        match self.jobs.catalogue.renew_job(self.id, self.token, WORKER_LEASE, progress).await {
            Ok(renewal) => {
                if renewal.cancel_requested {
                    self.stop.cancelled.store(true, Ordering::Relaxed);
                }
                if progress.is_some() {
                    self.jobs.changed.notify_waiters();
                }
            }
            Err(CatalogueError::LeaseLost) => self.stop.lost.store(true, Ordering::Relaxed),
            // The lease runs on; if the catalogue stays away it runs out and the job is taken up again.
            Err(error) => tracing::warn!(job = %self.id, %error, "can't renew the lease"),
        }
    }
}

/// Renew the lease for as long as the job runs.
async fn keep_alive(lease: &Lease) -> Infallible {
    loop {
        tokio::time::sleep(RENEW_EVERY).await;
        lease.renew(None).await;
    }
}

/// Runs the jobs of this process.
pub struct Runner {
    jobs: Jobs,
    databases: Databases,
    compute: Compute,
    decode: DecodeLimits,
    metrics: Arc<Metrics>,
    owner: String,
}

impl Runner {
    /// A runner that claims in the name of `owner`, which no other process uses.
    pub fn new(
        jobs: Jobs,
        databases: Databases,
        compute: Compute,
        decode: DecodeLimits,
        metrics: Arc<Metrics>,
        owner: String,
    ) -> Self {
        Self { jobs, databases, compute, decode, metrics, owner }
    }

    /// Claim and run jobs until `shutdown` turns true; then hand back what runs.
    pub async fn run(self, mut shutdown: watch::Receiver<bool>) {
        while !*shutdown.borrow() {
            let claimed = self
                .jobs
                .catalogue
                .claim_job(&self.owner, &[training::KIND, sweep::KIND], WORKER_LEASE, MAX_ATTEMPTS)
                .await;
            match claimed {
                Ok(Some(job)) => {
                    self.jobs.changed.notify_waiters();
                    let lease = Lease {
                        id: job.id,
                        token: job.token,
                        jobs: self.jobs.clone(),
                        stop: Arc::default(),
                        noted: Arc::default(),
                    };
                    tokio::select! {
                        () = self.work(&job, &lease) => {}
                        _ = shutdown.wait_for(|stop| *stop) => {}
                    }
                    self.jobs.changed.notify_waiters();
                }
                Ok(None) => self.idle(&mut shutdown).await,
                Err(error) => {
                    tracing::warn!(%error, "can't look for jobs");
                    self.idle(&mut shutdown).await;
                }
            }
        }
        match self.jobs.catalogue.hand_back_jobs(&self.owner).await {
            Ok(0) => {}
            Ok(count) => tracing::info!(count, "handed back running jobs"),
            Err(error) => tracing::warn!(%error, "can't hand back running jobs: their leases will run out"),
        }
    }

    async fn idle(&self, shutdown: &mut watch::Receiver<bool>) {
        tokio::select! {
            () = self.jobs.work.notified() => {}
            () = tokio::time::sleep(IDLE_POLL) => {}
            _ = shutdown.wait_for(|stop| *stop) => {}
        }
    }

    /// Do the job, whatever its kind; the version that it made, if it makes one.
    async fn outcome(&self, job: &JobRow, lease: &Lease) -> Result<Option<i64>, Stop> {
        let Self { databases, compute, decode, .. } = self;
        if job.kind == sweep::KIND {
            return sweep::run(job, lease, databases, compute, decode).await.map(|()| None);
        }
        training::run(job, lease, databases, compute, decode).await.map(Some)
    }

    async fn work(&self, job: &JobRow, lease: &Lease) {
        let (kind, database, calibration) = (&job.kind, &job.database, &job.calibration);
        tracing::info!(job = %job.id, kind, database, calibration, attempt = job.attempts, "job starts");
        let started = Instant::now();
        let outcome = tokio::select! {
            outcome = self.outcome(job, lease) => outcome,
            never = keep_alive(lease) => match never {},
        };
        let took_ms = started.elapsed().as_millis() as u64;
        let ended = match outcome {
            Ok(version) => {
                tracing::info!(job = %job.id, version, took_ms, "job succeeded");
                if version.is_some() {
                    self.metrics.training(started.elapsed());
                }
                return;
            }
            Err(Stop::Cancelled) => {
                tracing::info!(job = %job.id, took_ms, "job cancelled");
                self.jobs.catalogue.cancelled_job(lease.id, lease.token).await.map(drop)
            }
            Err(Stop::Failed { code, detail }) => {
                tracing::warn!(job = %job.id, code, detail, took_ms, "job failed");
                let problem = serde_json::json!({"code": code, "detail": detail}).to_string();
                self.jobs.catalogue.fail_job(lease.id, lease.token, &problem).await.map(drop)
            }
            Err(Stop::Lost) => {
                tracing::warn!(job = %job.id, took_ms, "another worker has the job: left to it");
                return;
            }
            Err(Stop::Unavailable { error }) => {
                let error = chain(&error);
                tracing::warn!(job = %job.id, error, took_ms, "job interrupted: a store is away");
                tokio::time::sleep(OUTAGE_PAUSE).await;
                // Back into the queue, the attempt not counted; with the catalogue away too the lease runs out.
                self.jobs.catalogue.hand_back_jobs(&self.owner).await.map(drop)
            }
        };
        if let Err(error) = ended {
            tracing::warn!(job = %job.id, %error, "can't end the job: it will be taken up again");
        }
    }
}
