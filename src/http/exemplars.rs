//! `/v1/databases/{database}/exemplars[/{id}[/image]]`: training images.

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::databases::read_options;
use super::extract::{Path, Query};
use super::pages::{Page, Paging};
use super::paths::DatabasePath;
use super::problem::Problem;
use super::uploads::{OnePicture, Picture, RobotHeader};
use super::{Service, put_status};
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::{DatabaseRow, ExemplarFilter, ExemplarRow, FrameHeader, Name, NewExemplar};
use landmarkd_core::imaging::{self, DecodeError};

/// The exemplar that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct ExemplarPath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Id of the exemplar.
    pub id: Uuid,
}

/// What a training image shows.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct LabelQuery {
    /// The place or object; left out where `negative` is true.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub label: Option<Name>,
    /// Turntable pose, in degrees.
    #[param(minimum = 0, exclusive_maximum = 360)]
    pub pose_deg: Option<f64>,
    /// Of landmarks with signatures of gradients: the picture shows nothing known, such as the building without anything that
    /// is to be recognised. What looks like it is background.
    #[param(default = false)]
    pub negative: Option<bool>,
}

/// Which exemplars are meant.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct ExemplarQuery {
    /// Those of this label.
    pub label: Option<String>,
    /// True: those that show nothing known; false: those with a label.
    pub negative: Option<bool>,
    /// Those that this robot sent.
    pub robot_id: Option<String>,
    /// Those received at this moment or later, by the service's clock.
    pub since: Option<Timestamp>,
    /// Those received before this moment.
    pub before: Option<Timestamp>,
    /// Most items to give.
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub limit: Option<u32>,
    /// `next_cursor` of the page before.
    pub cursor: Option<String>,
}

/// Which exemplars are to go.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct DeleteQuery {
    /// Those of this label.
    pub label: Option<String>,
    /// True: those that show nothing known; false: those with a label.
    pub negative: Option<bool>,
    /// Those that this robot sent.
    pub robot_id: Option<String>,
    /// Those received at this moment or later, by the service's clock.
    pub since: Option<Timestamp>,
    /// Those received before this moment.
    pub before: Option<Timestamp>,
}

/// A training image.
#[derive(Debug, Serialize, ToSchema)]
pub struct ExemplarBody {
    pub id: Uuid,
    /// Null where it is negative.
    pub label: Option<String>,
    /// Whether it shows nothing known.
    pub negative: bool,
    pub pose_deg: Option<f64>,
    pub width_px: u32,
    pub height_px: u32,
    /// Size of the picture as sent.
    pub bytes: u64,
    /// SHA-256 of the picture as sent.
    pub sha256: String,
    pub media_type: String,
    pub created_at: Timestamp,
    pub header: FrameHeader,
}

impl From<ExemplarRow> for ExemplarBody {
    fn from(row: ExemplarRow) -> Self {
        Self {
            id: row.id,
            label: (!row.negative).then_some(row.label),
            negative: row.negative,
            pose_deg: row.pose_deg,
            width_px: row.width_px,
            height_px: row.height_px,
            bytes: row.bytes,
            sha256: row.sha256,
            media_type: row.media_type,
            created_at: row.created_at,
            header: FrameHeader { robot_id: row.robot_id, frame_id: row.frame_id, stamp: row.stamp },
        }
    }
}

/// A pose, if it is one: in [0, 360). `at` points to it.
pub fn pose(given: Option<f64>, at: &str) -> Result<Option<f64>, Problem> {
    match given {
        Some(pose) if !(0.0..360.0).contains(&pose) => {
            let text = format!("{pose} is not in [0, 360): a full turn is 0, and 5° backwards is 355");
            Err(Problem::field(at, text))
        }
        // -0 is 0.
        given => Ok(given.map(|pose| pose + 0.0)),
    }
}

/// The label of an exemplar, or none for a negative one. `at` is what pointers to the fields begin with.
pub fn label_or_negative(
    database: &DatabaseRow,
    label: Option<Name>,
    negative: bool,
    pose_deg: Option<f64>,
    at: &str,
) -> Result<Option<Name>, Problem> {
    let field = |name: &str, text: &str| Err(Problem::field(format!("{at}{name}"), text));
    match label {
        Some(_) if negative => {
            field("negative", "a negative exemplar shows nothing known: leave out label, or negative")
        }
        None if !negative => field(
            "label",
            "name the place or object with label, or say with negative=true that nothing known is to be seen",
        ),
        None if pose_deg.is_some() => {
            field("pose_deg", "a negative exemplar shows nothing that could be turned: leave out pose_deg")
        }
        None if !read_options(database)?.have_gradients() => field(
            "negative",
            "negative exemplars are for databases of kind landmarks with signature gradient: leave it out, or put that \
             option first",
        ),
        label => Ok(label),
    }
}

/// Decodes a picture once, so that only pictures are kept, and keeps it; the pose is in [0, 360). Returns the exemplar, and
/// whether it is new.
pub async fn keep(
    service: &Service,
    database: &Name,
    label: Option<Name>,
    pose_deg: Option<f64>,
    picture: &Picture,
    header: FrameHeader,
) -> Result<(ExemplarRow, bool), Problem> {
    let (bytes, limits, media_type) = (picture.bytes.clone(), service.decode, picture.format.media_type());
    let decode = move || {
        let frame = imaging::decode(&bytes, &limits)?;
        let size = (frame.width() as u32, frame.height() as u32);
        Ok::<_, DecodeError>(NewExemplar::of(label, pose_deg, bytes, media_type, size, header))
    };
    let (decoded, _) = service.compute.run(Lane::Maintenance, picture.working_bytes, decode).await?;
    Ok(service.databases.add_exemplar(database, decoded?).await?)
}

/// Add a training image: the raw picture, or a form with a part `image`. The same again is the same exemplar.
#[utoipa::path(
    post, operation_id = "add_exemplar",
    path = "/v1/databases/{database}/exemplars", tag = "databases", security(("key" = ["contribute"])), params(DatabasePath, LabelQuery),
    request_body(
        description = "The picture, raw or as the part `image` of a form",
        content(
            (String = "image/jpeg"), (String = "image/png"),
            (String = "image/x-portable-graymap"), (String = "image/x-portable-pixmap"),
            (ImageForm = "multipart/form-data")
        )
    ),
    responses(
        (status = 201, body = ExemplarBody, description = "Kept"),
        (status = 200, body = ExemplarBody, description = "It was there"),
    )
)]
pub async fn post(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(query): Query<LabelQuery>,
    RobotHeader(header): RobotHeader,
    picture: OnePicture,
) -> Result<(StatusCode, Json<ExemplarBody>), Problem> {
    let database = service.databases.get(&path.database).await?;
    let pose_deg = pose(query.pose_deg, "#pose_deg")?;
    let negative = query.negative.unwrap_or(false);
    let label = label_or_negative(&database, query.label, negative, pose_deg, "#")?;
    let picture = picture.checked(&service.decode)?;
    let kept = keep(&service, &path.database, label, pose_deg, &picture, header);
    let (row, created) = kept.await?;
    Ok((put_status(created), Json(row.into())))
}

/// A form with one picture.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct ImageForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
}

/// Training images by id.
#[utoipa::path(
    get, operation_id = "list_exemplars",
    path = "/v1/databases/{database}/exemplars", tag = "databases", security(("key" = ["contribute"])), params(DatabasePath, ExemplarQuery),
    responses((status = 200, body = Page<ExemplarBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(query): Query<ExemplarQuery>,
) -> Result<Json<Page<ExemplarBody>>, Problem> {
    let Paging { limit, after } = Paging::read(query.limit, query.cursor.as_deref())?;
    service.databases.get(&path.database).await?;
    let ExemplarQuery { label, negative, robot_id, since, before, .. } = query;
    let filter = ExemplarFilter { label, negative, robot_id, since, before };
    let rows = service.databases.exemplars(&path.database, &filter, after, limit).await?;
    Ok(Json(Page::of(rows, limit, |row| row.id.to_string(), ExemplarBody::from)))
}

/// One training image.
#[utoipa::path(
    get, operation_id = "get_exemplar",
    path = "/v1/databases/{database}/exemplars/{id}", tag = "databases", security(("key" = ["contribute"])), params(ExemplarPath),
    responses((status = 200, body = ExemplarBody))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<ExemplarPath>,
) -> Result<Json<ExemplarBody>, Problem> {
    service.databases.get(&path.database).await?;
    Ok(Json(service.databases.exemplar(&path.database, path.id).await?.into()))
}

/// The picture of a training image, byte for byte as it was sent.
#[utoipa::path(
    get, operation_id = "get_exemplar_image",
    path = "/v1/databases/{database}/exemplars/{id}/image", tag = "databases", security(("key" = ["contribute"])), params(ExemplarPath),
    responses((status = 200, description = "The picture", content(
        (Vec<u8> = "image/jpeg"), (Vec<u8> = "image/png"), (Vec<u8> = "image/x-portable-anymap")
    )))
)]
pub async fn image(
    State(service): State<Service>,
    Path(path): Path<ExemplarPath>,
) -> Result<Response, Problem> {
    service.databases.get(&path.database).await?;
    let row = service.databases.exemplar(&path.database, path.id).await?;
    let bytes = service.databases.exemplar_bytes(&row).await?;
    Ok(([(header::CONTENT_TYPE, row.media_type)], bytes).into_response())
}

/// Delete one training image. Versions trained with it stay as they are.
#[utoipa::path(
    delete, operation_id = "delete_exemplar",
    path = "/v1/databases/{database}/exemplars/{id}", tag = "databases", security(("key" = ["train"])), params(ExemplarPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<ExemplarPath>,
) -> Result<StatusCode, Problem> {
    service.databases.get(&path.database).await?;
    service.databases.delete_exemplar(&path.database, path.id, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Delete the training images that match all that is given: a label, whether negative, a robot, a span of time; with nothing given, none
/// and 400. Versions trained with them stay as they are: train anew, then delete the older versions.
#[utoipa::path(
    delete, operation_id = "delete_exemplars",
    path = "/v1/databases/{database}/exemplars", tag = "databases", security(("key" = ["train"])), params(DatabasePath, DeleteQuery),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete_matching(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<DatabasePath>,
    Query(query): Query<DeleteQuery>,
) -> Result<StatusCode, Problem> {
    service.databases.get(&path.database).await?;
    let DeleteQuery { label, negative, robot_id, since, before } = query;
    let filter = ExemplarFilter { label, negative, robot_id, since, before };
    service.databases.delete_exemplars(&path.database, &filter, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
