//! `/v2…`: health and metadata as the Open Inference Protocol has them, for those who route by it. A database is a model, its
//! versions are the model's. Frames are asked about with `POST /v1/databases/{database}/recognitions`.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use std::sync::atomic::Ordering;
use utoipa::{IntoParams, ToSchema};

use super::Service;
use super::extract::Path;
use super::paths::DatabasePath;
use super::problem::Problem;
use crate::database::{CURRENT, DatabaseRow, Name};

/// Most versions of a model that are named, the newest first.
const MOST_VERSIONS: u32 = 1000;

/// Whether the process runs.
#[derive(Debug, Serialize, ToSchema)]
pub struct ServerLive {
    live: bool,
}

/// 200 while the process runs.
#[utoipa::path(get, operation_id = "server_live", path = "/v2/health/live", tag = "inference protocol", security(()), responses((status = 200, body = ServerLive)))]
pub async fn live() -> Json<ServerLive> {
    Json(ServerLive { live: true })
}

/// Whether recognitions are answered.
#[derive(Debug, Serialize, ToSchema)]
pub struct ServerReady {
    ready: bool,
}

/// Whether recognitions are answered; 503 while starting or shutting down.
#[utoipa::path(
    get, operation_id = "server_ready", path = "/v2/health/ready", tag = "inference protocol", security(()),
    responses((status = 200, body = ServerReady), (status = 503, body = ServerReady, description = "Starting or shutting down"))
)]
pub async fn ready(State(service): State<Service>) -> (StatusCode, Json<ServerReady>) {
    let ready = service.ready.load(Ordering::Relaxed) && !*service.shutdown.borrow();
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    (status, Json(ServerReady { ready }))
}

/// The service.
#[derive(Debug, Serialize, ToSchema)]
pub struct ServerMetadata {
    #[schema(example = "landmarkd")]
    name: &'static str,
    version: &'static str,
    /// None: inference isn't spoken here.
    extensions: [&'static str; 0],
}

/// Name and version of the service.
#[utoipa::path(get, operation_id = "server_metadata", path = "/v2", tag = "inference protocol", security(("key" = ["recognise"])), responses((status = 200, body = ServerMetadata)))]
pub async fn metadata() -> Json<ServerMetadata> {
    Json(ServerMetadata { name: env!("CARGO_PKG_NAME"), version: env!("CARGO_PKG_VERSION"), extensions: [] })
}

/// A version of a database, as the model that it is.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct ModelVersionPath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Number of the version.
    pub version: i64,
}

/// A database, as the model that it is.
#[derive(Debug, Serialize, ToSchema)]
pub struct ModelMetadata {
    name: String,
    versions: Vec<String>,
    /// `landmarkd_landmarks` or `landmarkd_objects`.
    platform: String,
    inputs: Vec<TensorMetadata>,
    outputs: Vec<TensorMetadata>,
}

/// What goes in or comes out.
#[derive(Debug, Serialize, ToSchema)]
pub struct TensorMetadata {
    name: &'static str,
    datatype: &'static str,
    shape: Vec<i64>,
}

/// Whether a model answers.
#[derive(Debug, Serialize, ToSchema)]
pub struct ModelReady {
    name: String,
    ready: bool,
}

fn model(row: DatabaseRow, versions: Vec<String>) -> ModelMetadata {
    // one encoded picture in, one label out
    let tensor = |name| TensorMetadata { name, datatype: "BYTES", shape: vec![1] };
    ModelMetadata {
        platform: format!("landmarkd_{}", row.kind),
        name: row.name,
        versions,
        inputs: vec![tensor("image")],
        outputs: vec![tensor("decision")],
    }
}

/// A database with its versions.
#[utoipa::path(
    get, operation_id = "model_metadata", path = "/v2/models/{database}", tag = "inference protocol", security(("key" = ["recognise"])),
    params(DatabasePath), responses((status = 200, body = ModelMetadata))
)]
pub async fn model_metadata(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
) -> Result<Json<ModelMetadata>, Problem> {
    let row = service.databases.get(&path.database).await?;
    let versions = service.databases.versions(&path.database, None, MOST_VERSIONS).await?;
    Ok(Json(model(row, versions.iter().map(|row| row.version.to_string()).collect())))
}

/// One version of a database.
#[utoipa::path(
    get, operation_id = "model_version_metadata", path = "/v2/models/{database}/versions/{version}", tag = "inference protocol",
    security(("key" = ["recognise"])), params(ModelVersionPath), responses((status = 200, body = ModelMetadata))
)]
pub async fn version_metadata(
    State(service): State<Service>,
    Path(path): Path<ModelVersionPath>,
) -> Result<Json<ModelMetadata>, Problem> {
    let row = service.databases.get(&path.database).await?;
    let version = service.databases.version(&path.database, path.version).await?;
    Ok(Json(model(row, vec![version.version.to_string()])))
}

/// Whether a database answers; 503 while it doesn't.
#[utoipa::path(
    get, operation_id = "model_ready", path = "/v2/models/{database}/ready", tag = "inference protocol", security(("key" = ["recognise"])),
    params(DatabasePath),
    responses((status = 200, body = ModelReady), (status = 503, body = ModelReady, description = "It has no version in memory"))
)]
pub async fn model_ready(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
) -> Result<(StatusCode, Json<ModelReady>), Problem> {
    service.databases.get(&path.database).await?;
    let ready = service.databases.registry().by_alias(path.database.as_str(), CURRENT).is_some();
    let status = if ready { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
    Ok((status, Json(ModelReady { name: path.database.to_string(), ready })))
}
