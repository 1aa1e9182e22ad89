//! The training job: exemplars → each made ready by itself → eigenspace → artifact → version → alias. What is
//! particular to a kind stands in a file of its own.
//!
//! The order of the writes is the protocol: the artifact's blob, read back and checked; then, in one transaction,
//! the version's row, the alias and the end of the job. A crash at any point leaves the old truth or the new.

mod landmarks;
mod objects;

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures_util::{StreamExt, TryStreamExt, stream};
use serde::{Deserialize, Serialize};

use super::runner::{Lease, Stop};
use crate::compute::{Compute, Lane};
use crate::database::artifact::{self, Artifact};
use crate::database::{
    ALGORITHM_REVISION, CURRENT, Counts, DatabaseError, Databases, ExemplarRow, JobRow, Kind, Model, Options,
    Report, ReportTimings, inputs_digest,
};
use crate::imaging::{self, DecodeLimits, Frame};
use crate::store::CatalogueError;
pub use objects::UnfitExemplars;

/// The word for this job in the catalogue.
pub(super) const KIND: &str = "training";

/// Whether `current` moves to the new version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Promote {
    Always,
    Never,
}

/// What a training is asked to do, settled when it is queued.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingParams {
    pub options: Options,
    pub promote: Promote,
}

#[derive(Serialize, Deserialize)]
struct ParamsDocument {
    options: String,
    promote: Promote,
}

impl TrainingParams {
    pub(super) fn to_document(&self) -> String {
        let document = ParamsDocument { options: self.options.to_document(), promote: self.promote };
        serde_json::to_string(&document).expect("text and words always serialise")
    }

    /// The kind is that of the database: the document doesn't name it.
    fn from_document(kind: Kind, text: &str) -> Result<Self, Stop> {
        let unreadable = |detail: String| Stop::Failed { code: "internal", detail };
        let document: ParamsDocument =
            serde_json::from_str(text).map_err(|error| unreadable(error.to_string()))?;
        let options = Options::from_document(kind, &document.options)
            .map_err(|error| unreadable(crate::telemetry::chain(&error)))?;
        Ok(Self { options, promote: document.promote })
    }
}

/// Train, publish, and end the job with the version's number.
pub(super) async fn run(
    job: &JobRow,
    lease: &Lease,
    databases: &Databases,
    compute: &Compute,
    decode: &DecodeLimits,
) -> Result<i64, Stop> {
    let nowhere = || CatalogueError::NotFound { what: "the database of a training".into() };
    let name = job.database.as_deref().ok_or_else(nowhere)?;
    let database = databases.catalogue.database(name).await?;
    let database = database.ok_or_else(|| CatalogueError::NotFound { what: format!("database {name}") })?;
    let kind = Kind::parse(&database.kind).ok_or_else(|| Stop::Failed {
        code: "not_yet",
        detail: format!("the database is of kind {}: this release can't train it", database.kind),
    })?;
    let params = TrainingParams::from_document(kind, &job.params)?;
    let promote = (params.promote == Promote::Always).then_some(CURRENT);
    let exemplars = databases.catalogue.training_set(name).await?;
    if exemplars.is_empty() {
        let detail = "the database has no exemplars: post some, then train".into();
        return Err(Stop::Failed { code: "no_exemplars", detail });
    }
    let digest = inputs_digest(kind, &params.options.to_document(), &exemplars);
    if let Some(found) = databases.catalogue.version_by_digest(name, &digest).await? {
        match databases.registry().check(name, &digest, &found.blob).await {
            Ok(()) => {
                let _publishing = lease.publishing().await;
                databases.catalogue.succeed_job(lease.id, lease.token, Some(found.version), promote).await?;
                announce(databases).await;
                return Ok(found.version);
            }
            // Trained again it gives the same bytes, and storing those mends the artifact.
            Err(DatabaseError::Unloadable { reason, .. }) => {
                tracing::warn!(database = name, found.version, reason, "damaged: training it again");
            }
            Err(error) => return Err(error.into()),
        }
    }

    let worker = Worker { lease, databases, compute, decode };
    let (trained, timings) = match params.options {
        Options::Landmarks(options) => landmarks::train(worker, exemplars, options).await?,
        Options::Objects(options) => objects::train(worker, exemplars, options).await?,
    };
    let started = Instant::now();
    let write = move || trained.into_artifact(digest);
    let ((artifact, bytes), _) = compute.run(Lane::Training, 0, write).await.map_err(DatabaseError::from)?;
    let eigenspace = timings.eigenspace + started.elapsed().as_secs_f64() * 1e3;

    lease.progress("publishing", 0, 1).await?;
    let mut new = databases.keep_artifact(name, &artifact, bytes).await?;
    new.report = artifact.report.timed(ReportTimings { eigenspace, ..timings }).to_document();
    databases.registry().check(name, &new.digest, &new.blob).await?;
    lease.go_on()?;
    let _publishing = lease.publishing().await;
    let version = databases.catalogue.publish(lease.id, lease.token, &new, promote).await?;
    announce(databases).await;
    Ok(version.version)
}

/// Longest that readers of jobs are kept waiting for a version to be served.
const ANNOUNCE_PATIENCE: Duration = Duration::from_secs(5);

/// Serve what was published. The job has ended: if this fails, the next refresh does it.
async fn announce(databases: &Databases) {
    match tokio::time::timeout(ANNOUNCE_PATIENCE, databases.registry().refresh()).await {
        Ok(Ok(())) => {}
        Ok(Err(error)) => {
            tracing::warn!(error = crate::telemetry::chain(&error), "can't refresh after a training");
        }
        Err(_) => tracing::warn!("the refresh after a training takes long: it is served a little later"),
    }
}

/// What the method of a kind made of the exemplars.
struct Trained {
    model: Model,
    report: Report,
    counts: Counts,
}

impl Trained {
    /// The artifact and its file.
    fn into_artifact(self, digest: String) -> (Artifact, Bytes) {
        let Self { model, report, counts } = self;
        let artifact = Artifact { digest, algorithm_revision: ALGORITHM_REVISION, counts, report, model };
        let bytes = Bytes::from(artifact::write(&artifact));
        (artifact, bytes)
    }
}

/// What it takes to read exemplars and to compute.
struct Worker<'a> {
    lease: &'a Lease,
    databases: &'a Databases,
    compute: &'a Compute,
    decode: &'a DecodeLimits,
}

impl Worker<'_> {
    /// What `describe` makes of each exemplar by itself, in the exemplars' order, and the milliseconds that it took;
    /// several at once on the training lane.
    async fn described<T, F>(&self, exemplars: Vec<ExemplarRow>, describe: F) -> Result<(Vec<T>, f64), Stop>
    where
        T: Send + 'static,
        F: Fn(&ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let started = Instant::now();
        let (total, describe) = (exemplars.len() as u64, Arc::new(describe));
        let described = stream::iter(exemplars)
            .map(|row| self.described_one(row, Arc::clone(&describe)))
            .buffered(self.compute.threads(Lane::Training))
            .enumerate()
            .then(|(done, described)| async move {
                self.lease.progress("describing", done as u64, total).await?;
                described
            })
            .try_collect()
            .await?;
        Ok((described, started.elapsed().as_secs_f64() * 1e3))
    }

    async fn described_one<T, F>(&self, row: ExemplarRow, describe: Arc<F>) -> Result<T, Stop>
    where
        T: Send + 'static,
        F: Fn(&ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let bytes = self.databases.exemplar_bytes(&row).await?;
        let limits = *self.decode;
        let memory = imaging::read_header(&bytes, &limits).map_or(0, |header| header.working_bytes());
        let work = move || {
            let frame = imaging::decode(&bytes, &limits).map_err(|error| Stop::Failed {
                code: "unreadable_exemplar",
                detail: format!(
                    "exemplar {} can't be decoded: {}; delete it and train again",
                    row.id,
                    crate::telemetry::chain(&error)
                ),
            })?;
            describe(&row, &frame)
        };
        self.compute.run(Lane::Training, memory, work).await.map_err(DatabaseError::from)?.0
    }

    /// What `fit` makes of all that was described, on one thread, and the milliseconds that it took.
    async fn fitted(
        &self,
        fit: impl FnOnce() -> Result<Trained, Stop> + Send + 'static,
    ) -> Result<(Trained, f64), Stop> {
        self.lease.progress("eigenspace", 0, 1).await?;
        let started = Instant::now();
        let (fitted, _) = self.compute.run(Lane::Training, 0, fit).await.map_err(DatabaseError::from)?;
        Ok((fitted?, started.elapsed().as_secs_f64() * 1e3))
    }
}
