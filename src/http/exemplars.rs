//! `/v1/databases/{database}/exemplars[/{id}[/image]]`: training images.

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::cameras::CameraReference;
use super::databases::read_options;
use super::extract::{Json as JsonIn, Path, Query, from_value};
use super::pages::{Page, Paging};
use super::paths::DatabasePath;
use super::problem::{FieldError, Problem};
use super::surveys::{SurveyChange, SurveyIn, SurveyPatch, camera_for};
use super::uploads::{OnePicture, Picture, RobotHeader};
use super::{Service, put_status};
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::survey::{CameraDocument, MapPoseDocument};
use crate::database::{
    DatabaseError, DatabaseRow, ExemplarFilter, ExemplarRow, FrameHeader, Kind, Name, NewExemplar, Survey,
};
use landmarkd_core::imaging;

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
    /// The map that `x_m`, `y_m` and `yaw_deg` are of, which then all are given: where the camera was, or with `size_mm`
    /// where the flat thing is. Of landmarks.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub map: Option<Name>,
    pub x_m: Option<f64>,
    pub y_m: Option<f64>,
    /// Height.
    pub z_m: Option<f64>,
    /// Heading, counter-clockwise from the map's x axis.
    pub yaw_deg: Option<f64>,
    /// Positive when it looks down.
    pub pitch_deg: Option<f64>,
    /// Positive when its left side rises.
    pub roll_deg: Option<f64>,
    /// Standard deviation of the position.
    #[param(default = 0.05)]
    pub sigma_m: Option<f64>,
    /// Width of the picture on the plane that it shows: of something flat, such as a poster.
    pub size_mm: Option<f64>,
    /// The name of a kept camera that took the picture. A form has its intrinsics, or a name, as the part `camera`.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub camera: Option<Name>,
}

impl LabelQuery {
    /// What the query says about where the picture was taken.
    ///
    /// # Errors
    /// A pose without one of the members that it must have.
    fn survey(&self) -> Result<SurveyIn, Problem> {
        let given = |name: &str, value: Option<f64>| value.map(|value| (name.to_owned(), value.into()));
        let mut pose: Map<String, Value> = [
            ("x_m", self.x_m),
            ("y_m", self.y_m),
            ("z_m", self.z_m),
            ("yaw_deg", self.yaw_deg),
            ("pitch_deg", self.pitch_deg),
            ("roll_deg", self.roll_deg),
            ("sigma_m", self.sigma_m),
        ]
        .into_iter()
        .filter_map(|(name, value)| given(name, value))
        .collect();
        pose.extend(self.map.iter().map(|map| ("map".to_owned(), map.as_str().into())));
        let pose = match pose.is_empty() {
            true => None,
            false => Some(from_value(Value::Object(pose)).map_err(|fault| {
                Problem::field(format!("#{}", fault.pointer.trim_start_matches('/')), fault.detail)
            })?),
        };
        let camera = self.camera.as_ref().map(|name| CameraReference::Name(name.to_string()));
        Ok(SurveyIn { pose, camera, size_mm: self.size_mm })
    }
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
    /// Where the camera was; with `size_mm` where the flat thing is.
    #[schema(required = false)]
    pub pose: Option<MapPoseDocument>,
    /// The camera that took it.
    #[schema(required = false)]
    pub camera: Option<CameraDocument>,
    /// Width of the picture on the plane that it shows.
    #[schema(required = false)]
    pub size_mm: Option<f64>,
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

impl TryFrom<ExemplarRow> for ExemplarBody {
    type Error = DatabaseError;

    fn try_from(row: ExemplarRow) -> Result<Self, DatabaseError> {
        let Survey { pose, camera, size_mm } = Survey::of(&row)?;
        Ok(Self {
            id: row.id,
            label: (!row.negative).then_some(row.label),
            negative: row.negative,
            pose_deg: row.pose_deg,
            pose,
            camera,
            size_mm,
            width_px: row.width_px,
            height_px: row.height_px,
            bytes: row.bytes,
            sha256: row.sha256,
            media_type: row.media_type,
            created_at: row.created_at,
            header: FrameHeader { robot_id: row.robot_id, frame_id: row.frame_id, stamp: row.stamp },
        })
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

/// A survey, if the exemplar may have one. `at` is what pointers to its members begin with.
///
/// # Errors
/// It is of an object, or nothing known is to be seen.
pub fn surveyable(
    database: &DatabaseRow,
    survey: Survey,
    negative: bool,
    at: &str,
) -> Result<Survey, Problem> {
    if survey == Survey::default() || (database.kind == Kind::Landmarks.as_str() && !negative) {
        return Ok(survey);
    }
    let named = [
        (if at == "#" { "map" } else { "pose" }, survey.pose.is_some()),
        ("camera", survey.camera.is_some()),
        ("size_mm", survey.size_mm.is_some()),
    ];
    let text = match negative {
        true => "a negative exemplar shows nothing that could be anywhere: leave it out",
        false => "is of databases of kind landmarks: for the turn of an object there is pose_deg",
    };
    let fault = |(name, _)| FieldError { pointer: format!("{at}{name}"), detail: text.into() };
    Err(Problem::fields(named.into_iter().filter(|(_, is_given)| *is_given).map(fault).collect()))
}

/// What is said about a picture that becomes an exemplar.
pub struct Description {
    /// None for a negative one.
    pub label: Option<Name>,
    /// In [0, 360).
    pub pose_deg: Option<f64>,
    pub survey: Survey,
    pub header: FrameHeader,
}

/// Decodes a picture once, so that only pictures are kept, and keeps it. Returns the exemplar, and whether it is new. `at` is
/// what pointers begin with.
pub async fn keep(
    service: &Service,
    database: &Name,
    description: Description,
    picture: &Picture,
    at: &'static str,
) -> Result<(ExemplarRow, bool), Problem> {
    let (bytes, limits, media_type) = (picture.bytes.clone(), service.decode, picture.format.media_type());
    let Description { label, pose_deg, survey, header } = description;
    let decode = move || {
        let frame = imaging::decode(&bytes, &limits)?;
        let size = (frame.width() as u32, frame.height() as u32);
        if let Some(camera) = &survey.camera {
            camera_for(camera, size, &format!("{at}camera"))?;
        }
        Ok::<_, Problem>(NewExemplar::of(label, pose_deg, survey, bytes, media_type, size, header))
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
            (ExemplarForm = "multipart/form-data")
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
    let survey = query.survey()?.with_texts(&picture.texts)?.resolved(&service, "#").await?;
    let survey = surveyable(&database, survey, negative, "#")?;
    let label = label_or_negative(&database, query.label, negative, pose_deg, "#")?;
    let picture = picture.checked(&service.decode)?;
    let description = Description { label, pose_deg, survey, header };
    let (row, created) = keep(&service, &path.database, description, &picture, "#").await?;
    Ok((put_status(created), Json(row.try_into()?)))
}

/// A form with one picture.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct ImageForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
}

/// A form with a training image, and where it was taken.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct ExemplarForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
    /// Where the camera was; with `size_mm` where the flat thing is.
    pose: Option<MapPoseDocument>,
    /// The camera that took it.
    camera: Option<CameraReference>,
    /// Width of the picture on the plane that it shows.
    size_mm: Option<f64>,
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
    Ok(Json(Page::try_of(rows, limit, |row| row.id.to_string(), ExemplarBody::try_from)?))
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
    Ok(Json(service.databases.exemplar(&path.database, path.id).await?.try_into()?))
}

/// Change where a training image was taken, with which camera, or how large it is: what is left out stays, null takes it away.
/// In force from the next training on.
#[utoipa::path(
    patch, operation_id = "change_exemplar",
    path = "/v1/databases/{database}/exemplars/{id}", tag = "databases", security(("key" = ["contribute"])), params(ExemplarPath),
    request_body = SurveyPatch,
    responses((status = 200, body = ExemplarBody))
)]
pub async fn patch(
    State(service): State<Service>,
    Path(path): Path<ExemplarPath>,
    JsonIn(members): JsonIn<Map<String, Value>>,
) -> Result<Json<ExemplarBody>, Problem> {
    let database = service.databases.get(&path.database).await?;
    let row = service.databases.exemplar(&path.database, path.id).await?;
    let change = SurveyChange::read(&service, members).await?;
    surveyable(&database, change.on(Survey::default()), row.negative, "/")?;
    if let Some(Some(camera)) = &change.camera {
        camera_for(camera, (row.width_px, row.height_px), "/camera")?;
    }
    let changed =
        service.databases.change_survey(&path.database, path.id, |before| change.on(before)).await?;
    Ok(Json(changed.try_into()?))
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
