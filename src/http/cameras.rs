//! `/v1/cameras[/{name}]`: intrinsics of cameras, which pictures then name.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::extract::{Json as JsonIn, Path, Query};
use super::pages::{self, Page, PageQuery};
use super::problem::{FieldError, Problem};
use super::{Service, put_status};
use crate::access::Caller;
use crate::database::survey::CameraDocument;
use crate::database::{KeptCamera, Name};
use landmarkd_core::geometry::Camera;

/// The camera that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CameraPath {
    /// Name of the camera.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub name: Name,
}

/// A camera that is kept.
#[derive(Debug, Serialize, ToSchema)]
pub struct KeptCameraBody {
    pub name: String,
    #[serde(flatten)]
    pub camera: CameraDocument,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

impl From<KeptCamera> for KeptCameraBody {
    fn from(kept: KeptCamera) -> Self {
        let KeptCamera { name, camera, created_at, updated_at } = kept;
        Self { name, camera, created_at, updated_at }
    }
}

/// A camera as it is sent with a picture.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(untagged)]
#[schema(as = CameraReference)]
pub enum CameraReference {
    /// The name of one that is kept.
    Name(String),
    /// Its intrinsics.
    Intrinsics(CameraDocument),
}

impl CameraReference {
    /// As a part of a form has it: intrinsics as JSON, or a name, in quotes or not.
    ///
    /// # Errors
    /// It is neither.
    pub fn of_text(text: &[u8]) -> Result<Self, Problem> {
        match text.trim_ascii() {
            json if json.starts_with(b"{") => super::extract::from_json(json).map(Self::Intrinsics),
            name => Ok(Self::Name(String::from_utf8_lossy(name).trim_matches('"').to_owned())),
        }
    }

    /// The intrinsics. `at` points to the reference.
    ///
    /// # Errors
    /// There is no camera of that name, or the intrinsics can't be.
    pub async fn resolved(self, service: &Service, at: &str) -> Result<CameraDocument, Problem> {
        match self {
            Self::Name(name) => {
                let name =
                    Name::parse(&name).map_err(|error| Problem::field(at, format!("{name:?} {error}")))?;
                Ok(service.databases.camera(&name).await?.camera)
            }
            Self::Intrinsics(camera) => checked(camera, at),
        }
    }
}

/// Intrinsics that can be. `at` points to them.
///
/// # Errors
/// Every member at fault.
fn checked(camera: CameraDocument, at: &str) -> Result<CameraDocument, Problem> {
    let faults = Camera::from(&camera).faults();
    let faults = faults
        .into_iter()
        .map(|fault| FieldError { pointer: format!("{at}/{}", fault.field), detail: fault.fault });
    let faults: Vec<FieldError> = faults.collect();
    if faults.is_empty() { Ok(camera) } else { Err(Problem::fields(faults)) }
}

/// Keep a camera's intrinsics; those of that name are replaced. Exemplars that named it before keep what it was.
#[utoipa::path(
    put, operation_id = "put_camera",
    path = "/v1/cameras/{name}", tag = "cameras", security(("key" = ["train"])), params(CameraPath), request_body = CameraDocument,
    responses(
        (status = 201, body = KeptCameraBody, description = "Kept"),
        (status = 200, body = KeptCameraBody, description = "It was there, and is replaced"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CameraPath>,
    JsonIn(camera): JsonIn<CameraDocument>,
) -> Result<(StatusCode, Json<KeptCameraBody>), Problem> {
    let camera = checked(camera, "")?;
    let (kept, created) = service.databases.put_camera(&path.name, &camera, &caller.actor()).await?;
    Ok((put_status(created), Json(kept.into())))
}

/// Cameras by name.
#[utoipa::path(
    get, operation_id = "list_cameras", path = "/v1/cameras", tag = "cameras", security(("key" = ["recognise"])), params(PageQuery),
    responses((status = 200, body = Page<KeptCameraBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<KeptCameraBody>>, Problem> {
    let limit = pages::limit(page.limit)?;
    let kept = service.databases.cameras(page.cursor.as_deref(), limit).await?;
    Ok(Json(Page::of(kept, limit, |kept| kept.name.clone(), KeptCameraBody::from)))
}

/// One camera.
#[utoipa::path(
    get, operation_id = "get_camera",
    path = "/v1/cameras/{name}", tag = "cameras", security(("key" = ["recognise"])), params(CameraPath),
    responses((status = 200, body = KeptCameraBody))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<CameraPath>,
) -> Result<Json<KeptCameraBody>, Problem> {
    Ok(Json(service.databases.camera(&path.name).await?.into()))
}

/// Delete a camera. Exemplars that named it keep its intrinsics.
#[utoipa::path(
    delete, operation_id = "delete_camera",
    path = "/v1/cameras/{name}", tag = "cameras", security(("key" = ["train"])), params(CameraPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CameraPath>,
) -> Result<StatusCode, Problem> {
    service.databases.delete_camera(&path.name, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
