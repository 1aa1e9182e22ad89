//! `POST /v1/databases/{database}/trainings`: make a version of the exemplars, as a job.

use axum::extract::State;
use axum::response::Response;
use serde::Deserialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::Service;
use super::access::Who;
use super::databases::{DatabasePath, read_options};
use super::extract::{Json as JsonIn, Path};
use super::jobs::{JobBody, queued};
use super::options::{self, OptionsBody};
use super::problem::Problem;
use crate::jobs::{Promote, TrainingParams};

/// Whether `current` moves to the new version.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PromoteWord {
    #[default]
    Always,
    /// Unless it is worse than the version that `current` points to: both are shown the exemplars seen otherwise, and
    /// the sign test says whether it is worse beyond chance (p < 0.05). See the job's `comparison`.
    IfNotWorse,
    Never,
}

/// A training to do.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewTraining {
    /// Put over the database's options for this training alone.
    #[schema(value_type = Option<OptionsBody>)]
    pub options: Option<Map<String, Value>>,
    /// Whether `current` moves to the new version.
    #[serde(default)]
    #[schema(default = "always")]
    pub promote: PromoteWord,
}

/// Train the database's exemplars into a version: answers at once with a job.
#[utoipa::path(
    post, operation_id = "begin_training", path = "/v1/databases/{database}/trainings", tag = "databases", security(("key" = ["train"])), params(DatabasePath),
    request_body = Option<NewTraining>,
    responses((status = 202, body = JobBody, description = "Queued", headers(("Location" = String))))
)]
pub async fn post(
    State(service): State<Service>,
    who: Who,
    Path(path): Path<DatabasePath>,
    JsonIn(new): JsonIn<NewTraining>,
) -> Result<Response, Problem> {
    let promote = match new.promote {
        PromoteWord::Always => Promote::Always,
        PromoteWord::Never => Promote::Never,
        PromoteWord::IfNotWorse => Promote::IfNotWorse,
    };
    let base = read_options(&service.databases.get(&path.database).await?)?;
    let options = options::over(base, &new.options.unwrap_or_default())?;
    let job = service.jobs.train(&path.database, &TrainingParams { options, promote }, &who.actor()).await?;
    Ok(queued(job))
}
