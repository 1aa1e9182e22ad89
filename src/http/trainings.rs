//! `POST /v1/databases/{database}/trainings`: make a version of the exemplars, as a job.

use axum::extract::State;
use axum::response::Response;
use serde::Deserialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::Service;
use super::databases::read_options;
use super::extract::{Json as JsonIn, Path};
use super::jobs::{JobBody, queued};
use super::options;
use super::paths::DatabasePath;
use super::problem::Problem;
use crate::access::Caller;
use crate::database::OptionsDocument;
use crate::jobs::{EigenspaceChoice, Promote, SelfCheck, TrainingParams};

/// A training to do.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewTraining {
    /// Put over the database's options for this training alone.
    #[schema(value_type = Option<OptionsDocument>)]
    pub options: Option<Map<String, Value>>,
    /// Whether `current` moves to the new version.
    #[serde(default)]
    #[schema(default = "always")]
    pub promote: Promote,
    /// Of landmarks: whether the version is asked about its own pictures, and whether before it is published (`wait`) or
    /// afterwards (`background`); `wait` unless given. The comparison of `promote: "if_not_worse"` comes before in any case.
    pub calibration: Option<SelfCheck>,
    /// Of landmarks with signatures of gradients: which eigenspace the exemplars are projected on; `auto` unless given.
    pub eigenspace: Option<EigenspaceChoice>,
}

/// Train the database's exemplars into a version: answers at once with a job.
#[utoipa::path(
    post, operation_id = "begin_training", path = "/v1/databases/{database}/trainings", tag = "databases", security(("key" = ["train"])), params(DatabasePath),
    request_body = Option<NewTraining>,
    responses((status = 202, body = JobBody, description = "Queued", headers(("Location" = String))))
)]
pub async fn post(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<DatabasePath>,
    JsonIn(new): JsonIn<NewTraining>,
) -> Result<Response, Problem> {
    let base = read_options(&service.databases.get(&path.database).await?)?;
    let options = options::patched(base, &new.options.unwrap_or_default())?;
    if new.calibration == Some(SelfCheck::Background) && !options.have_gradients() {
        let text = "background is for landmarks with signature gradient, which decide without a calibration: give wait or none";
        return Err(Problem::field("/calibration", text));
    }
    if new.eigenspace == Some(EigenspaceChoice::Keep) && !options.have_gradients() {
        let text = "keep is for landmarks with signature gradient: give fit, or leave it out";
        return Err(Problem::field("/eigenspace", text));
    }
    let (calibration, eigenspace) = (new.calibration.unwrap_or_default(), new.eigenspace.unwrap_or_default());
    let params = TrainingParams { options, promote: new.promote, calibration, eigenspace };
    let job = service.jobs.train(&path.database, &params, &caller.actor()).await?;
    Ok(queued(job))
}
