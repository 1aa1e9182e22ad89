//! The runner: claims jobs one after another, keeps their lease alive, and ends each exactly once.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::watch;

use super::lease::{Lease, WORKER_LEASE};
use super::queue::Jobs;
use super::stop::Stop;
use super::worker::Worker;
use super::{sweep, training};
use crate::compute::Compute;
use crate::database::{Databases, JobRow};
use crate::telemetry::{Metrics, chain};
use landmarkd_core::imaging::DecodeLimits;

/// How long an idle runner sleeps before it looks for jobs that other processes queued.
const IDLE_POLL: Duration = Duration::from_secs(1);
/// How long a job waits in its worker when a store is away.
const OUTAGE_PAUSE: Duration = Duration::from_secs(2);
/// Most claims of one job: one that kills its worker five times would kill it again.
const MAX_ATTEMPTS: u32 = 5;

/// Runs the jobs of this process.
pub struct Runner {
    /// The queue that it claims from.
    pub jobs: Jobs,
    /// Where exemplars and pictures are read, and versions and calibrations written.
    pub databases: Databases,
    /// The threads that its jobs compute on.
    pub compute: Compute,
    /// Limits of the pictures that its jobs decode.
    pub decode: DecodeLimits,
    /// Where finished trainings are counted.
    pub metrics: Arc<Metrics>,
    /// The name that it claims under; no other process uses it.
    pub owner: String,
}

impl Runner {
    /// Claims and runs jobs until `shutdown` turns true; then hands back the one that runs.
    pub async fn run(self, mut shutdown: watch::Receiver<bool>) {
        while !*shutdown.borrow() {
            let kinds = [training::KIND, sweep::KIND];
            let claim = self.jobs.catalogue.claim_job(&self.owner, &kinds, WORKER_LEASE, MAX_ATTEMPTS);
            match claim.await {
                Ok(Some(job)) => {
                    self.jobs.signals.changed.notify_waiters();
                    tokio::select! {
                        () = self.work(&job) => {}
                        _ = shutdown.wait_for(|stop| *stop) => {}
                    }
                    self.jobs.signals.changed.notify_waiters();
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
            () = self.jobs.signals.work.notified() => {}
            () = tokio::time::sleep(IDLE_POLL) => {}
            _ = shutdown.wait_for(|stop| *stop) => {}
        }
    }

    /// Runs a job while its lease is kept alive, and ends it.
    async fn work(&self, job: &JobRow) {
        let (kind, database, calibration) = (&job.kind, &job.database, &job.calibration);
        tracing::info!(job = %job.id, kind, database, calibration, attempt = job.attempts, "job starts");
        let started = Instant::now();
        let (catalogue, signals) = (Arc::clone(&self.jobs.catalogue), self.jobs.signals.clone());
        let lease = Lease::new(job.id, job.token, catalogue, signals);
        let outcome = tokio::select! {
            outcome = self.outcome(job, &lease) => outcome,
            never = lease.keep_alive() => match never {},
        };
        let took_ms = started.elapsed().as_millis() as u64;
        match outcome {
            Ok(version) => {
                tracing::info!(job = %job.id, version, took_ms, "job succeeded");
                if version.is_some() {
                    self.metrics.training(started.elapsed());
                }
            }
            Err(stop) => self.end(&lease, stop, took_ms).await,
        }
    }

    /// Runs a job of either kind; returns the version that a training made.
    async fn outcome(&self, job: &JobRow, lease: &Lease) -> Result<Option<i64>, Stop> {
        let Self { databases, compute, decode, .. } = self;
        let worker = Worker { lease, databases, compute, decode };
        if job.kind == sweep::KIND {
            return sweep::run(&worker, job).await.map(|()| None);
        }
        training::run(&worker, job).await.map(Some)
    }

    /// Ends a job that stopped, or puts it back into the queue.
    async fn end(&self, lease: &Lease, stop: Stop, took_ms: u64) {
        let (Lease { id, token, .. }, catalogue) = (lease, &self.jobs.catalogue);
        let ended = match stop {
            Stop::Cancelled => {
                tracing::info!(job = %id, took_ms, "job cancelled");
                catalogue.cancelled_job(*id, *token).await.map(drop)
            }
            Stop::Failed(failure) => {
                let (code, detail) = (failure.code.word(), &failure.detail);
                tracing::warn!(job = %id, code, detail, took_ms, "job failed");
                catalogue.fail_job(*id, *token, &failure.to_document()).await.map(drop)
            }
            Stop::Lost => {
                tracing::warn!(job = %id, took_ms, "another worker has the job: left to it");
                Ok(())
            }
            Stop::Unavailable(error) => {
                let error = chain(&error);
                tracing::warn!(job = %id, error, took_ms, "job interrupted: a store is away");
                tokio::time::sleep(OUTAGE_PAUSE).await;
                // Back into the queue, the attempt not counted; with the catalogue away too the lease expires.
                catalogue.hand_back_jobs(&self.owner).await.map(drop)
            }
        };
        if let Err(error) = ended {
            tracing::warn!(job = %id, %error, "can't end the job: it will be claimed again");
        }
    }
}
