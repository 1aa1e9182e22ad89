//! The training job: exemplars → each made ready by itself → eigenspace → artifact → version → alias. What is
//! particular to a kind stands in a file of its own.
//!
//! The order of the writes is the protocol: the artifact's blob, read back and checked; then, in one transaction,
//! the version's row, the alias and the end of the job. A crash at any point leaves the old truth or the new.

mod gate;
mod landmarks;
mod objects;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures_util::{StreamExt, TryStreamExt, stream};
use serde::{Deserialize, Serialize};

use super::runner::{Lease, Stop};
use crate::compute::{Compute, Lane};
use crate::database::artifact::{self, Artifact};
use crate::database::{
    ALGORITHM_REVISION, CURRENT, Counts, DatabaseError, Databases, ExemplarRow, JobRow, Kind, LoadedVersion,
    Model, Options, Report, ReportTimings, inputs_digest,
};
use crate::store::CatalogueError;
pub use gate::VersionComparison;
use landmarkd_core::imaging::{self, DecodeLimits, Frame};
pub use objects::UnfitExemplars;

/// The word for this job in the catalogue.
pub(super) const KIND: &str = "training";

/// Whether `current` moves to the new version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Promote {
    Always,
    /// Unless it is worse than the version that `current` points to, beyond chance.
    IfNotWorse,
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
    let exemplars = databases.catalogue.training_set(name).await?;
    if exemplars.is_empty() {
        let detail = "the database has no exemplars: post some, then train".into();
        return Err(Stop::Failed { code: "no_exemplars", detail });
    }
    let digest = inputs_digest(kind, &params.options.to_document(), &exemplars);
    let worker = Worker { lease, databases, compute, decode };
    if let Some(found) = databases.catalogue.version_by_digest(name, &digest).await? {
        match databases.registry().load(name, found.version, &digest, &found.blob).await {
            Ok(version) => {
                let (alias, comparison) = worker.promotion(params.promote, name, version, &exemplars).await?;
                let (version, comparison) = (Some(found.version), comparison.as_deref());
                let _publishing = lease.publishing().await;
                databases.catalogue.succeed_job(lease.id, lease.token, version, alias, comparison).await?;
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

    let rows = exemplars.clone();
    let (trained, timings) = match params.options {
        Options::Landmarks(options) => landmarks::train(&worker, rows, options).await?,
        Options::Objects(options) => objects::train(&worker, rows, options).await?,
    };
    let started = Instant::now();
    let write = move || trained.into_artifact(digest);
    let ((artifact, bytes), _) = compute.run(Lane::Training, 0, write).await.map_err(DatabaseError::from)?;
    let eigenspace = timings.eigenspace + started.elapsed().as_secs_f64() * 1e3;

    lease.progress("publishing", 0, 1).await?;
    let mut new = databases.keep_artifact(name, &artifact, bytes).await?;
    new.report = artifact.report.timed(ReportTimings { eigenspace, ..timings }).to_document();
    let candidate = databases.registry().load(name, 0, &new.digest, &new.blob).await?;
    let (alias, comparison) = worker.promotion(params.promote, name, candidate, &exemplars).await?;
    lease.go_on()?;
    let _publishing = lease.publishing().await;
    let published =
        databases.catalogue.publish(lease.id, lease.token, &new, alias, comparison.as_deref()).await;
    let version = published?;
    announce(databases).await;
    Ok(version.version)
}

/// Pictures of the exemplar's size, with what recognition needs, that a piece of a training's work holds at most.
const PICTURES_AT_ONCE: u64 = 4;

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

/// The exemplars of these ids, all of them once in every round, and how many they are in each.
fn rounds_of(ids: &[&str], rounds: u64, exemplars: &[ExemplarRow]) -> (Vec<ExemplarRow>, usize) {
    let by_id: HashMap<String, &ExemplarRow> =
        exemplars.iter().map(|row| (row.id.to_string(), row)).collect();
    let chosen: Vec<&ExemplarRow> = ids.iter().filter_map(|&id| by_id.get(id).copied()).collect();
    let rows = (0..rounds).flat_map(|_| chosen.iter().map(|&row| row.clone())).collect();
    (rows, chosen.len())
}

impl Worker<'_> {
    /// The alias that moves to a version, and how that version did beside the one in use where that is asked for.
    async fn promotion(
        &self,
        promote: Promote,
        database: &str,
        candidate: Arc<LoadedVersion>,
        exemplars: &[ExemplarRow],
    ) -> Result<(Option<&'static str>, Option<String>), Stop> {
        match promote {
            Promote::Always => Ok((Some(CURRENT), None)),
            Promote::Never => Ok((None, None)),
            Promote::IfNotWorse => {
                let compared = gate::compare(self, database, candidate, exemplars).await?;
                Ok((compared.promoted.then_some(CURRENT), Some(compared.to_document())))
            }
        }
    }

    /// What `work` makes of each exemplar by itself, in the exemplars' order, and the milliseconds that it took;
    /// several at once on the training lane. It is told the exemplar's place among them.
    async fn each<T, F>(
        &self,
        stage: &str,
        exemplars: Vec<ExemplarRow>,
        work: F,
    ) -> Result<(Vec<T>, f64), Stop>
    where
        T: Send + 'static,
        F: Fn(usize, &ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let started = Instant::now();
        let (total, work) = (exemplars.len() as u64, Arc::new(work));
        let made = stream::iter(exemplars.into_iter().enumerate())
            .map(|(place, row)| self.one(place, row, Arc::clone(&work)))
            .buffered(self.compute.threads(Lane::Training))
            .enumerate()
            .then(|(done, made)| async move {
                self.lease.progress(stage, done as u64, total).await?;
                made
            })
            .try_collect()
            .await?;
        Ok((made, started.elapsed().as_secs_f64() * 1e3))
    }

    async fn one<T, F>(&self, place: usize, row: ExemplarRow, work: Arc<F>) -> Result<T, Stop>
    where
        T: Send + 'static,
        F: Fn(usize, &ExemplarRow, &Frame) -> Result<T, Stop> + Send + Sync + 'static,
    {
        let bytes = self.databases.exemplar_bytes(&row).await?;
        let limits = *self.decode;
        // rehearsals are drawn beside the picture, some at a time
        let memory = imaging::read_header(&bytes, &limits)
            .map_or(0, |header| PICTURES_AT_ONCE * header.working_bytes());
        let work = move || {
            let frame = imaging::decode(&bytes, &limits).map_err(|error| Stop::Failed {
                code: "unreadable_exemplar",
                detail: format!(
                    "exemplar {} can't be decoded: {}; delete it and train again",
                    row.id,
                    crate::telemetry::chain(&error)
                ),
            })?;
            work(place, &row, &frame)
        };
        self.compute.run(Lane::Training, memory, work).await.map_err(DatabaseError::from)?.0
    }

    /// The value of `work`, done on one thread, and the milliseconds that it took.
    async fn alone<T: Send + 'static>(
        &self,
        stage: &str,
        work: impl FnOnce() -> Result<T, Stop> + Send + 'static,
    ) -> Result<(T, f64), Stop> {
        self.lease.progress(stage, 0, 1).await?;
        let started = Instant::now();
        let (made, _) = self.compute.run(Lane::Training, 0, work).await.map_err(DatabaseError::from)?;
        Ok((made?, started.elapsed().as_secs_f64() * 1e3))
    }
}
