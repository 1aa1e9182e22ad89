//! The training job: exemplars → each made ready by itself → eigenspace → artifact → version → alias. What is
//! particular to a kind stands in a file of its own.
//!
//! The order of the writes is the protocol: the artifact's blob, read back and checked; then, in one transaction,
//! the version's row, the alias and the end of the job. A crash at any point leaves the old truth or the new. A version that is
//! checked in the background is published before: its job ends, in a second transaction, with the verdict in its report.

mod describing;
mod gate;
mod growing;
mod landmarks;
mod objects;

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::stop::Stop;
use super::worker::Worker;
use crate::database::artifact::{self, Artifact};
use crate::database::survey::{Surveys, surveys_of};
use crate::database::{
    ALGORITHM_REVISION, CURRENT, Counts, DatabaseError, Databases, ExemplarRow, GrownReport, JobRow, Kind,
    LoadedVersion, Model, Options, Report, TrainingTimings, VersionRow, inputs_digest,
};
use crate::problem::Code;
use crate::store::{CatalogueError, NewVersion};
use crate::telemetry::chain;
pub use gate::VersionComparison;
pub use growing::EigenspaceChoice;
use landmarks::Fitted;
pub use objects::UnfitExemplars;

/// The word for this job in the catalogue.
pub(super) const KIND: &str = "training";

/// Whether `current` moves to the new version.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = PromoteWord)]
pub enum Promote {
    /// It does.
    #[default]
    Always,
    /// Unless it is worse than the version that `current` points to: both are shown the exemplars seen otherwise, and
    /// the sign test says whether it is worse beyond chance (p < 0.05). See the job's `comparison`.
    IfNotWorse,
    /// It doesn't.
    Never,
}

/// Whether a version is asked about its own pictures before it is published.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CalibrationWord)]
pub enum SelfCheck {
    /// It is: the report has a verdict, or with signatures of intensity the reliability of confidences.
    #[default]
    Wait,
    /// It is asked afterwards: the version is published as soon as its eigenspace stands, the job goes on, and the verdict is
    /// added to the report of the version, not to its artifact. Signatures of gradients only.
    Background,
    /// It isn't: the version is published as soon as its eigenspace stands. With signatures of intensity its answers have
    /// no confidence.
    None,
}

/// The parameters of a training, fixed when it is queued and kept with the job.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingParams {
    /// How the exemplars are trained.
    pub options: Options,
    /// Whether `current` moves to the version.
    pub promote: Promote,
    /// Whether the version is asked about its own pictures first.
    pub calibration: SelfCheck,
    /// Which eigenspace the exemplars are projected on.
    pub eigenspace: EigenspaceChoice,
}

#[derive(Serialize, Deserialize)]
struct ParamsDocument {
    options: String,
    promote: Promote,
    #[serde(default)]
    calibration: SelfCheck,
    #[serde(default)]
    eigenspace: EigenspaceChoice,
}

impl TrainingParams {
    pub(super) fn to_document(&self) -> String {
        let Self { options, promote, calibration, eigenspace } = self;
        let (promote, calibration, eigenspace) = (*promote, *calibration, *eigenspace);
        let document = ParamsDocument { options: options.to_document(), promote, calibration, eigenspace };
        serde_json::to_string(&document).expect("text and words always serialise")
    }

    /// The kind is that of the database: the document doesn't name it.
    fn from_document(kind: Kind, text: &str) -> Result<Self, Stop> {
        let document: ParamsDocument =
            serde_json::from_str(text).map_err(|error| Stop::failed(Code::Internal, error.to_string()))?;
        let options = Options::from_document(kind, &document.options)
            .map_err(|error| Stop::failed(Code::Internal, chain(&error)))?;
        let ParamsDocument { promote, calibration, eigenspace, .. } = document;
        Ok(Self { options, promote, calibration, eigenspace })
    }
}

/// What a training is made from.
struct Inputs {
    /// Name of the database.
    database: String,
    exemplars: Vec<ExemplarRow>,
    surveys: Surveys,
    params: TrainingParams,
    /// Digest of exemplars, options and algorithm: of the version too.
    digest: String,
}

impl Inputs {
    /// Whether the version is asked about its own pictures after it is published.
    fn is_checked_afterwards(&self) -> bool {
        self.params.calibration == SelfCheck::Background && self.params.options.have_gradients()
    }

    /// Whether the version's report is to say how well it knows its own pictures.
    fn wants_verdict(&self) -> bool {
        self.params.calibration != SelfCheck::None && self.params.options.have_gradients()
    }

    async fn read(job: &JobRow, databases: &Databases) -> Result<Self, Stop> {
        let not_found = |what: String| CatalogueError::NotFound { what };
        let name = job.database.clone().ok_or_else(|| not_found("the database of a training".into()))?;
        let row = databases.catalogue.database(&name).await?;
        let row = row.ok_or_else(|| not_found(format!("database {name}")))?;
        let kind = Kind::parse(&row.kind).ok_or_else(|| {
            let text = format!("the database is of kind {}: this release can't train it", row.kind);
            Stop::failed(Code::NotYet, text)
        })?;
        let params = TrainingParams::from_document(kind, &job.params)?;
        let exemplars = databases.catalogue.training_set(&name).await?;
        if exemplars.is_empty() && job.version.is_none() {
            let text = "the database has no exemplars: post some, then train";
            return Err(Stop::failed(Code::NoExemplars, text));
        }
        let digest = inputs_digest(kind, &params.options.to_document(), &exemplars);
        let surveys = surveys_of(&exemplars)?;
        Ok(Self { database: name, exemplars, surveys, params, digest })
    }
}

/// Trains, publishes, and ends the job with the version's number.
pub(super) async fn run(worker: &Worker<'_>, job: &JobRow) -> Result<i64, Stop> {
    let mut inputs = Inputs::read(job, worker.databases).await?;
    // published before its process died: where the alias is by now is none of this job's business
    if let Some(version) = job.version {
        return check_published(worker, &inputs, version).await;
    }
    if let Some(version) = reuse(worker, &inputs, None).await? {
        return Ok(version);
    }
    let mut grown = None;
    if let Options::Landmarks(options) = &inputs.params.options
        && inputs.params.options.have_gradients()
        && let Some(base) = growing::base(worker, &inputs, options).await?
    {
        let (fitted, same) = (inputs.digest.clone(), base.is_same(&inputs).then(|| base.version()));
        inputs.digest = base.digest.clone();
        if let Some(version) = reuse(worker, &inputs, same).await? {
            return Ok(version);
        }
        // what has nothing new and doesn't load is trained anew
        if same.is_none() {
            grown = base.grown(worker, &inputs, options).await?;
        }
        if grown.is_none() {
            inputs.digest = fitted;
        }
    }
    let (artifact, bytes) = train(worker, &inputs, grown).await?;
    publish(worker, &inputs, &artifact, bytes).await
}

/// Ends the job with the version that was trained from the same inputs, or that of the number which has the same exemplars, if
/// it loads.
async fn reuse(worker: &Worker<'_>, inputs: &Inputs, same: Option<i64>) -> Result<Option<i64>, Stop> {
    let Worker { lease, databases, .. } = worker;
    let Inputs { database, digest, .. } = inputs;
    let found = match same {
        Some(version) => databases.catalogue.version(database, version).await?,
        None => databases.catalogue.version_by_digest(database, digest).await?,
    };
    let Some(found) = found else { return Ok(None) };
    let loaded = databases.registry().load(database, found.version, &found.digest, &found.blob).await;
    let version = match loaded {
        Ok(version) => version,
        // Trained again it gives the same bytes, and storing those mends the artifact.
        Err(DatabaseError::Unloadable { reason, .. }) => {
            tracing::warn!(database, found.version, reason, "damaged: training it again");
            return Ok(None);
        }
        Err(error) => return Err(error.into()),
    };
    let Promotion { alias, comparison } = promotion(worker, inputs, version).await?;
    if inputs.wants_verdict() && !report_of(&found)?.has_verdict() {
        return publish_early(worker, inputs, &NewVersion::again(found), alias, comparison, None)
            .await
            .map(Some);
    }
    let _publishing = lease.publishing().await;
    let (number, comparison) = (Some(found.version), comparison.as_deref());
    databases.catalogue.succeed_job(lease.id, lease.token, number, alias, comparison).await?;
    serve_now(databases.registry().refresh()).await;
    Ok(number)
}

/// The artifact of the exemplars, with its file.
async fn train(
    worker: &Worker<'_>,
    inputs: &Inputs,
    grown: Option<(Fitted, GrownReport)>,
) -> Result<(Artifact, Bytes), Stop> {
    let rows = inputs.exemplars.clone();
    let (trained, timings, descriptions) = match inputs.params.options.clone() {
        Options::Landmarks(options) => {
            let (trained, timings, descriptions) =
                landmarks::train(worker, rows, options, inputs.params.calibration, grown).await?;
            (trained, timings, Some(descriptions))
        }
        Options::Objects(options) => {
            let (trained, timings) = objects::train(worker, rows, options).await?;
            (trained, timings, None)
        }
    };
    let (started, digest, surveys) = (Instant::now(), inputs.digest.clone(), inputs.surveys.clone());
    let (mut artifact, bytes) = worker.run(0, move || trained.into_artifact(digest, surveys)).await?;
    let eigenspace = timings.eigenspace + started.elapsed().as_secs_f64() * 1e3;
    // The file is without these: the same inputs give the same bytes.
    let timings = TrainingTimings { eigenspace, ..timings };
    artifact.report = artifact.report.timed(timings).with_descriptions(descriptions);
    if inputs.is_checked_afterwards() {
        artifact.report = artifact.report.not_checked();
    }
    Ok((artifact, bytes))
}

/// Keeps the artifact and ends the job with a version of it.
async fn publish(
    worker: &Worker<'_>,
    inputs: &Inputs,
    artifact: &Artifact,
    bytes: Bytes,
) -> Result<i64, Stop> {
    let Worker { lease, databases, .. } = worker;
    lease.progress("publishing", 0, 1).await?;
    let new = databases.keep_artifact(&inputs.database, artifact, bytes).await?;
    let candidate = databases.registry().load(&inputs.database, 0, &new.digest, &new.blob).await?;
    let Promotion { alias, comparison } = promotion(worker, inputs, Arc::clone(&candidate)).await?;
    lease.check()?;
    if inputs.is_checked_afterwards() {
        return publish_early(worker, inputs, &new, alias, comparison, Some(candidate)).await;
    }
    let _publishing = lease.publishing().await;
    let comparison = comparison.as_deref();
    let version = databases.catalogue.publish(lease.id, lease.token, &new, alias, comparison).await?;
    serve_now(databases.registry().serve_checked(candidate, &version)).await;
    Ok(version.version)
}

/// Publishes the version and then asks it about its own pictures.
async fn publish_early(
    worker: &Worker<'_>,
    inputs: &Inputs,
    new: &NewVersion,
    alias: Option<&str>,
    comparison: Option<String>,
    checked: Option<Arc<LoadedVersion>>,
) -> Result<i64, Stop> {
    let Worker { lease, databases, .. } = worker;
    let published = {
        let _publishing = lease.publishing().await;
        let (catalogue, comparison) = (&databases.catalogue, comparison.as_deref());
        let published = catalogue.publish_early(lease.id, lease.token, new, alias, comparison).await?;
        match checked {
            Some(checked) => serve_now(databases.registry().serve_checked(checked, &published)).await,
            None => serve_now(databases.registry().refresh()).await,
        }
        published
    };
    check_published(worker, inputs, published.version).await
}

/// Asks a version that is published about its own pictures, and ends the job with the verdict in its report.
async fn check_published(worker: &Worker<'_>, inputs: &Inputs, version: i64) -> Result<i64, Stop> {
    let (Worker { lease, databases, .. }, database) = (worker, &inputs.database);
    let Some(row) = databases.catalogue.version(database, version).await? else {
        // deleted meanwhile
        databases.catalogue.succeed_job(lease.id, lease.token, None, None, None).await?;
        return Ok(version);
    };
    let loaded = databases.whole_version(&row).await?;
    let mut report = report_of(&row)?;
    let checked =
        landmarks::verdict(worker, "checking", &inputs.exemplars, &loaded, landmarks::model_of).await?;
    if let Some((verdict, took_ms)) = checked {
        report = report.checked(verdict, took_ms);
    }
    let (catalogue, report) = (&databases.catalogue, report.to_document());
    catalogue.succeed_with_report(lease.id, lease.token, database, version, &report).await?;
    Ok(version)
}

/// The report that is kept with a version.
fn report_of(row: &VersionRow) -> Result<Report, Stop> {
    let kind = Kind::parse(&row.kind)
        .ok_or_else(|| Stop::failed(Code::Internal, format!("a version of the unknown kind {}", row.kind)))?;
    Report::from_document(kind, &row.report)
        .map_err(|error| Stop::failed(Code::Internal, format!("the report of the version: {error}")))
}

/// What becomes of `current` when a version is published.
struct Promotion {
    /// The alias that moves to the version.
    alias: Option<&'static str>,
    /// The [`VersionComparison`] to keep with the job, as a document.
    comparison: Option<String>,
}

async fn promotion(
    worker: &Worker<'_>,
    inputs: &Inputs,
    candidate: Arc<LoadedVersion>,
) -> Result<Promotion, Stop> {
    Ok(match inputs.params.promote {
        Promote::Always => Promotion { alias: Some(CURRENT), comparison: None },
        Promote::Never => Promotion { alias: None, comparison: None },
        Promote::IfNotWorse => {
            let compared = gate::compare(worker, &inputs.database, candidate, &inputs.exemplars).await?;
            let alias = compared.promoted.then_some(CURRENT);
            Promotion { alias, comparison: Some(compared.to_document()) }
        }
    })
}

/// Longest time that readers of jobs wait for a version to be served.
const SERVE_TIMEOUT: Duration = Duration::from_secs(5);

/// Loads what was published. The job has ended: if this fails, the next refresh does it.
async fn serve_now(refresh: impl Future<Output = Result<(), DatabaseError>>) {
    match tokio::time::timeout(SERVE_TIMEOUT, refresh).await {
        Ok(Ok(())) => {}
        Ok(Err(error)) => {
            tracing::warn!(error = chain(&error), "can't refresh after a training");
        }
        Err(_) => tracing::warn!("the refresh after a training takes long: it is served a little later"),
    }
}

/// The model of the exemplars, with its report.
struct Trained {
    model: Model,
    report: Report,
    counts: Counts,
}

impl Trained {
    /// The artifact and its file.
    fn into_artifact(self, digest: String, surveys: Surveys) -> (Artifact, Bytes) {
        let Self { model, report, counts } = self;
        let algorithm_revision = ALGORITHM_REVISION;
        let artifact = Artifact { digest, algorithm_revision, counts, report, model, surveys };
        let bytes = Bytes::from(artifact::write(&artifact));
        (artifact, bytes)
    }
}

/// The exemplars of these ids, all of them once in every round, and how many they are in each.
fn rounds_of(ids: &[&str], rounds: u64, exemplars: &[ExemplarRow]) -> (Vec<ExemplarRow>, usize) {
    let by_id: HashMap<String, &ExemplarRow> =
        exemplars.iter().map(|row| (row.id.to_string(), row)).collect();
    let chosen: Vec<&ExemplarRow> = ids.iter().filter_map(|&id| by_id.get(id).copied()).collect();
    let rows = (0..rounds).flat_map(|_| chosen.iter().map(|&row| row.clone())).collect();
    (rows, chosen.len())
}
