//! The training job: exemplars → described one by one → eigenspace → artifact → version → alias.
//!
//! The order of the writes is the protocol: the artifact's blob, read back and checked; then, in one transaction,
//! the version's row, the alias and the end of the job. A crash at any point leaves the old truth or the new.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures_util::{StreamExt, TryStreamExt, stream};
use serde::{Deserialize, Serialize};

use super::runner::{Lease, Stop};
use crate::compute::{Compute, ComputeError, Lane};
use crate::database::artifact::{self, Artifact};
use crate::database::{
    ALGORITHM_REVISION, CURRENT, Counts, DatabaseError, Databases, ExemplarRow, JobRow, Kind, Model, Report,
    ReportTimings, inputs_digest, options,
};
use crate::imaging::{self, DecodeLimits};
use crate::recognition::landmarks::{self, DescribedExemplar, ExemplarName, LandmarkOptions, Landmarks};
use crate::store::{BlobError, CatalogueError};

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
    pub options: LandmarkOptions,
    pub promote: Promote,
}

#[derive(Serialize, Deserialize)]
struct ParamsDocument {
    options: String,
    promote: Promote,
}

impl TrainingParams {
    pub(super) fn to_document(&self) -> String {
        let document = ParamsDocument { options: options::to_document(&self.options), promote: self.promote };
        serde_json::to_string(&document).expect("text and words always serialise")
    }

    fn from_document(text: &str) -> Result<Self, Stop> {
        let unreadable = |detail: String| Stop::Failed { code: "internal", detail };
        let document: ParamsDocument =
            serde_json::from_str(text).map_err(|error| unreadable(error.to_string()))?;
        let options = options::from_document(&document.options)
            .map_err(|error| unreadable(crate::telemetry::chain(&error)))?;
        Ok(Self { options, promote: document.promote })
    }
}

impl From<DatabaseError> for Stop {
    fn from(error: DatabaseError) -> Self {
        match error {
            DatabaseError::Catalogue { source: CatalogueError::LeaseLost } => Self::Lost,
            DatabaseError::Catalogue { source: CatalogueError::CancelRequested } => Self::Cancelled,
            DatabaseError::Catalogue { source: CatalogueError::NotFound { what } } => {
                Self::Failed { code: "unknown_database", detail: format!("{what}; it was deleted meanwhile") }
            }
            DatabaseError::Blobs {
                source: error @ (BlobError::NotFound { .. } | BlobError::Corrupt { .. }),
            } => Self::Failed { code: "unreadable_exemplar", detail: crate::telemetry::chain(&error) },
            DatabaseError::Unloadable { reason, .. } => Self::Failed {
                code: "internal",
                detail: format!("the new version can't be read back: {reason}"),
            },
            DatabaseError::Compute { source: ComputeError::Panicked { message } } => {
                Self::Failed { code: "internal", detail: format!("the computation failed: {message}") }
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

/// Train, publish, and end the job with the version's number.
pub(super) async fn run(
    job: &JobRow,
    lease: &Lease,
    databases: &Databases,
    compute: &Compute,
    decode: &DecodeLimits,
) -> Result<i64, Stop> {
    let params = TrainingParams::from_document(&job.params)?;
    let promote = (params.promote == Promote::Always).then_some(CURRENT);
    let exemplars = databases.catalogue.training_set(&job.database).await?;
    if exemplars.is_empty() {
        let detail = "the database has no exemplars: post some, then train".into();
        return Err(Stop::Failed { code: "no_exemplars", detail });
    }
    let document = options::to_document(&params.options);
    let digest = inputs_digest(Kind::Landmarks, &document, &exemplars);
    if let Some(found) = databases.catalogue.version_by_digest(&job.database, &digest).await? {
        match databases.registry().check(&job.database, &digest, &found.blob).await {
            Ok(()) => {
                let _publishing = lease.publishing().await;
                databases.catalogue.succeed_job(lease.id, lease.token, Some(found.version), promote).await?;
                announce(databases).await;
                return Ok(found.version);
            }
            // Trained again it gives the same bytes, and storing those mends the artifact.
            Err(DatabaseError::Unloadable { reason, .. }) => {
                tracing::warn!(job.database, found.version, reason, "damaged: training it again");
            }
            Err(error) => return Err(error.into()),
        }
    }

    let started = Instant::now();
    let options = Arc::new(params.options);
    let described = describe_all(exemplars, &options, lease, databases, compute, decode).await?;
    let describe_ms = started.elapsed().as_secs_f64() * 1e3;

    lease.progress("eigenspace", 0, 1).await?;
    let started = Instant::now();
    let fit = move || fit(described, &options, digest);
    let (fitted, _) = compute.run(Lane::Training, 0, fit).await.map_err(DatabaseError::from)?;
    let (artifact, bytes) = fitted?;
    let eigenspace_ms = started.elapsed().as_secs_f64() * 1e3;

    lease.progress("publishing", 0, 1).await?;
    let mut new = databases.keep_artifact(&job.database, &artifact, bytes).await?;
    let timings = ReportTimings { describe: describe_ms, eigenspace: eigenspace_ms };
    new.report = Report { timings_ms: Some(timings), ..artifact.report }.to_document();
    databases.registry().check(&job.database, &new.digest, &new.blob).await?;
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

/// Interest points and signatures of every exemplar, in the exemplars' order; several at once on the training lane.
async fn describe_all(
    exemplars: Vec<ExemplarRow>,
    options: &Arc<LandmarkOptions>,
    lease: &Lease,
    databases: &Databases,
    compute: &Compute,
    decode: &DecodeLimits,
) -> Result<Vec<DescribedExemplar>, Stop> {
    let total = exemplars.len() as u64;
    let described = stream::iter(exemplars)
        .map(|row| describe(row, Arc::clone(options), databases, compute, *decode))
        .buffered(compute.threads(Lane::Training));
    described
        .enumerate()
        .then(|(done, described)| async move {
            lease.progress("describing", done as u64, total).await?;
            described
        })
        .try_collect()
        .await
}

async fn describe(
    row: ExemplarRow,
    options: Arc<LandmarkOptions>,
    databases: &Databases,
    compute: &Compute,
    limits: DecodeLimits,
) -> Result<DescribedExemplar, Stop> {
    let bytes = databases.exemplar_bytes(&row).await?;
    let memory = imaging::read_header(&bytes, &limits).map_or(0, |header| header.working_bytes());
    let name = ExemplarName { id: row.id.to_string(), label: row.label };
    let work = move || {
        let frame = imaging::decode(&bytes, &limits)?;
        Ok::<_, imaging::DecodeError>(landmarks::describe(name, &frame, &options))
    };
    let (described, _) = compute.run(Lane::Training, memory, work).await.map_err(DatabaseError::from)?;
    described.map_err(|error| Stop::Failed {
        code: "unreadable_exemplar",
        detail: format!(
            "exemplar {} can't be decoded: {}; delete it and train again",
            row.id,
            crate::telemetry::chain(&error)
        ),
    })
}

/// The eigenspace of the described exemplars, as an artifact and its file.
fn fit(
    described: Vec<DescribedExemplar>,
    options: &LandmarkOptions,
    digest: String,
) -> Result<(Artifact, Bytes), Stop> {
    let (model, report) = Landmarks::train(described, options)
        .map_err(|error| Stop::Failed { code: "too_few_points", detail: crate::telemetry::chain(&error) })?;
    let counts = Counts {
        exemplars: report.exemplars as u64,
        labels: report.labels as u64,
        interest_points: report.interest_points as u64,
    };
    let artifact = Artifact {
        digest,
        algorithm_revision: ALGORITHM_REVISION,
        counts,
        report: Report::from(&report),
        model: Model::Landmarks(model),
    };
    let bytes = Bytes::from(artifact::write(&artifact));
    Ok((artifact, bytes))
}
