//! `/v1/databases/{database}/tracks[/{id}[/frames]]`: frames of a robot on its way, whose evidence adds up.

mod live;

use std::collections::HashMap;
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

pub use self::live::Tracks;
use self::live::{Localisation, MotionWord, Track};
use super::cameras::CameraReference;
use super::extract::{Json as JsonIn, Path, Query, from_json};
use super::pages::{Page, PageQuery, Paging};
use super::paths::DatabasePath;
use super::problem::{Code, Problem};
use super::recognitions::{
    DecisionBody, PlacePoseBody, RecognitionBody, Wanted, recognise, render, version_for,
};
use super::uploads::{OnePicture, RobotHeader, Texts};
use super::{Service, events};
use crate::database::{CURRENT, Databases, LoadedVersion, Model, Name};
use landmarkd_core::localisation::Odometry;
use landmarkd_core::recognition::landmarks::{Belief, Landmarks, Motion, Viewpoint};

/// The track that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct TrackPath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Id of the track.
    pub id: Uuid,
}

/// A track to begin.
#[derive(Debug, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewTrack {
    /// How robots move among the exemplars.
    #[serde(default)]
    #[schema(default = "auto")]
    pub motion: MotionWord,
    /// The alias whose version answers; `current` when it isn't given.
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub alias: Option<Name>,
}

/// A track.
#[derive(Debug, Serialize, ToSchema)]
pub struct TrackBody {
    pub id: Uuid,
    pub database: String,
    /// The alias whose version answers.
    pub alias: String,
    /// How robots are taken to move: `path` or `still`.
    pub motion: MotionWord,
    /// The version that answered last.
    pub version: i64,
    /// Frames that were counted.
    pub frames: u64,
    /// `order_unknown`: `path` was asked for, but the version has exemplars that came with an artifact file or were
    /// deleted from the database, so that their order isn't known.
    pub warnings: Vec<&'static str>,
    pub created_at: Timestamp,
    /// When it is gone unless another frame comes.
    pub expires_at: Timestamp,
}

/// A track with what is believed.
#[derive(Debug, Serialize, ToSchema)]
pub struct TrackDetail {
    #[serde(flatten)]
    pub track: TrackBody,
    #[serde(flatten)]
    pub belief: BeliefBody,
}

/// Where a robot is, by all its frames so far.
#[derive(Debug, Serialize, ToSchema)]
pub struct BeliefBody {
    /// The label that is believed more than all else together, with that probability as `confidence`; null if none is. With
    /// `motion: "path"` together with the places directly before and after its own.
    pub decision: Option<DecisionBody>,
    /// The likeliest labels, best first.
    pub belief: Vec<LabelBeliefBody>,
    /// Probability of being where no exemplar was taken.
    pub elsewhere: f64,
    /// Where the robot is in a map, if exemplars have poses and some frame told.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub pose: Option<PlacePoseBody>,
}

/// The belief in a label.
#[derive(Debug, Serialize, ToSchema)]
pub struct LabelBeliefBody {
    pub label: String,
    /// Probability of being at one of its exemplars.
    pub probability: f64,
    /// Id of the likeliest of them.
    pub exemplar: String,
}

/// How much of a track is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TrackQuery {
    /// Most labels in `belief`.
    #[param(minimum = 1, maximum = 1000, default = 5)]
    pub top: Option<usize>,
}

/// How much of an answer is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct FrameQuery {
    /// Most labels in `belief` and in `votes`.
    #[param(minimum = 1, maximum = 1000, default = 5)]
    pub top: Option<usize>,
    /// Give every point's vote.
    #[param(default = false)]
    pub explain: Option<bool>,
    /// The name of a kept camera that took the frame. A form has its intrinsics, or a name, as the part `camera`.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub camera: Option<Name>,
    /// How far the camera moved forward since the frame before, with `dy_m` and `dyaw_deg`. A form has the three as the part
    /// `odometry`.
    pub dx_m: Option<f64>,
    /// How far to its left.
    pub dy_m: Option<f64>,
    /// How far it turned, counter-clockwise.
    pub dyaw_deg: Option<f64>,
}

/// How the camera moved since the frame before, in its own frame there: x forward, y left.
#[derive(Debug, Clone, Copy, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OdometryBody {
    pub dx_m: f64,
    #[serde(default)]
    #[schema(default = 0.0)]
    pub dy_m: f64,
    /// Counter-clockwise.
    pub dyaw_deg: f64,
}

/// A form with a frame of a track.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct TrackFrameForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
    /// The camera that took it.
    camera: Option<CameraReference>,
    /// How it moved since the frame before.
    odometry: Option<OdometryBody>,
}

/// The motion that a form or the query names.
///
/// # Errors
/// A part that can't be read, or a motion that can't be.
fn odometry(query: &FrameQuery, texts: &Texts) -> Result<Option<Odometry>, Problem> {
    let sent = texts.get("odometry").map(|text| from_json::<OdometryBody>(text)).transpose();
    let sent = sent.map_err(|problem| problem.in_part("odometry"))?;
    let named = match (query.dx_m, query.dy_m, query.dyaw_deg) {
        (None, None, None) => None,
        (Some(dx_m), dy_m, Some(dyaw_deg)) => {
            Some(OdometryBody { dx_m, dy_m: dy_m.unwrap_or(0.0), dyaw_deg })
        }
        _ => return Err(Problem::field("#dx_m", "and dyaw_deg come together, with dy_m or without")),
    };
    let at = if sent.is_some() { "/odometry/" } else { "#" };
    let Some(OdometryBody { dx_m, dy_m, dyaw_deg }) = sent.or(named) else { return Ok(None) };
    for (name, value, most) in [("dx_m", dx_m, 1e3), ("dy_m", dy_m, 1e3), ("dyaw_deg", dyaw_deg, 3.6e3)] {
        if value.abs() > most || value.is_nan() {
            let text = format!("{value} is no motion between two frames: at most {most} either way");
            return Err(Problem::field(format!("{at}{name}"), text));
        }
    }
    Ok(Some(Odometry { dx_m, dy_m, dyaw_deg }))
}

/// What a frame shows, and where the robot is by all its frames so far. The fields are those of a recognition of this
/// frame alone, but for `decision` and `pose`, which are the track's.
#[derive(Debug, Serialize, ToSchema)]
pub struct TrackedFrameBody {
    /// Id of the track.
    pub track: Uuid,
    /// The likeliest labels, best first.
    pub belief: Vec<LabelBeliefBody>,
    /// Probability of being where no exemplar was taken.
    pub elsewhere: f64,
    /// What is this frame's alone.
    pub frame: FrameBody,
    /// How robots are taken to move: `path` or `still`.
    pub motion: MotionWord,
    /// When the track is gone unless another frame comes.
    pub expires_at: Timestamp,
    #[serde(flatten)]
    pub recognition: RecognitionBody,
}

/// A frame of a track.
#[derive(Debug, Serialize, ToSchema)]
pub struct FrameBody {
    /// Its number in the track, from 1.
    pub number: u64,
    /// False when it was the last frame sent again (the same `X-Frame-Id`, header and picture): the belief is as it was.
    pub counted: bool,
    /// What a recognition of this frame alone decides.
    pub decision: Option<DecisionBody>,
    /// Where it was taken by this frame alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub pose: Option<PlacePoseBody>,
}

/// The model of a version, if it is one of landmarks.
fn landmarks(version: &LoadedVersion) -> Result<&Landmarks, Problem> {
    match &version.model {
        Model::Landmarks(model) => Ok(model),
        Model::Objects(_) => Err(Problem::new(
            Code::KindConflict,
            format!(
                "database {} is of kind objects: tracks are of databases of kind landmarks",
                version.database
            ),
        )),
    }
}

/// The word of a motion.
fn word(belief: &Belief) -> MotionWord {
    match belief.motion() {
        Motion::Still => MotionWord::Still,
        Motion::Path(_) => MotionWord::Path,
    }
}

impl BeliefBody {
    fn of(track: &Track, top: usize) -> Self {
        let labels = track.belief.labels(&track.exemplars);
        let decision = track.belief.decision(&track.exemplars);
        let decision =
            decision.map(|(label, probability)| DecisionBody { label, confidence: Some(probability) });
        let belief = labels.into_iter().take(top).map(|believed| LabelBeliefBody {
            label: believed.label,
            probability: believed.probability,
            exemplar: track.exemplars[believed.exemplar].id.clone(),
        });
        let pose = track.localisation.as_ref().and_then(Localisation::pose);
        Self { decision, belief: belief.collect(), elsewhere: track.belief.unknown(&track.exemplars), pose }
    }
}

impl TrackBody {
    fn of(track: &Track, tracks: &Tracks) -> Self {
        Self {
            id: track.id,
            database: track.database.to_string(),
            alias: track.alias.as_ref().map_or(CURRENT, Name::as_str).into(),
            motion: word(&track.belief),
            version: track.version,
            frames: track.frames,
            warnings: order_warning(track).into_iter().collect(),
            created_at: track.created_at,
            expires_at: tracks.expires_at(track),
        }
    }
}

/// How robots move among the exemplars of a model; none along a path when their order isn't known.
async fn motion(
    databases: &Databases,
    wanted: MotionWord,
    database: &Name,
    model: &Landmarks,
) -> Result<Option<Motion>, Problem> {
    match (wanted, model.options().viewpoint) {
        (MotionWord::Still, _) | (MotionWord::Auto, Viewpoint::Free) => return Ok(Some(Motion::Still)),
        (MotionWord::Path, _) | (MotionWord::Auto, Viewpoint::Upright) => {}
    }
    let arrived = databases.exemplars_by_arrival(database).await?;
    let ids = model.exemplars().iter().map(|exemplar| exemplar.id.as_str());
    let index_of: HashMap<&str, usize> = ids.zip(0..).collect();
    let order: Vec<usize> =
        arrived.iter().filter_map(|id| index_of.get(id.to_string().as_str()).copied()).collect();
    Ok((order.len() == model.exemplars().len()).then_some(Motion::Path(order)))
}

/// The track with another version: the belief in an exemplar that both versions have stays.
async fn carried_over(
    databases: &Databases,
    track: &Track,
    version: &LoadedVersion,
) -> Result<Track, Problem> {
    let model = landmarks(version)?;
    if track.digest == version.digest {
        return Ok(Track { version: version.version, ..track.clone() });
    }
    let motion = motion(databases, track.motion, &track.database, model).await?;
    let ids = track.exemplars.iter().map(|exemplar| exemplar.id.as_str());
    let index_before: HashMap<&str, usize> = ids.zip(0..).collect();
    let exemplars = model.exemplars().iter();
    let before: Vec<Option<usize>> =
        exemplars.map(|exemplar| index_before.get(exemplar.id.as_str()).copied()).collect();
    Ok(Track {
        is_out_of_order: motion.is_none(),
        belief: track.belief.carried_over(motion.unwrap_or(Motion::Still), &before),
        version: version.version,
        digest: version.digest.clone(),
        exemplars: model.names().into(),
        ..track.clone()
    })
}

fn order_warning(track: &Track) -> Option<&'static str> {
    track.is_out_of_order.then_some("order_unknown")
}

/// Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the process that began
/// them, until they are deleted or no frame comes for ten minutes.
#[utoipa::path(
    post, operation_id = "begin_track",
    path = "/v1/databases/{database}/tracks", tag = "recognition", security(("key" = ["recognise"])), params(DatabasePath),
    request_body = Option<NewTrack>,
    responses((status = 201, body = TrackBody, description = "Begun", headers(("Location" = String))))
)]
pub async fn post(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    JsonIn(new): JsonIn<NewTrack>,
) -> Result<Response, Problem> {
    let version = version_for(&service.databases, &path.database, None, new.alias.as_ref()).await?;
    let model = landmarks(&version)?;
    let motion = motion(&service.databases, new.motion, &path.database, model).await?;
    let now = Timestamp::now();
    let track = service.tracks.begin(Track {
        id: Uuid::now_v7(),
        database: path.database,
        alias: new.alias,
        motion: new.motion,
        is_out_of_order: motion.is_none(),
        version: version.version,
        digest: version.digest.clone(),
        exemplars: model.names().into(),
        localisation: None,
        belief: Belief::new(motion.unwrap_or(Motion::Still), model.exemplars().len()),
        frames: 0,
        last: None,
        created_at: now,
        used_at: now,
    })?;
    let location = format!("/v1/databases/{}/tracks/{}", track.database, track.id);
    let location = HeaderValue::from_str(&location).unwrap_or(HeaderValue::from_static(""));
    Ok((StatusCode::CREATED, [(header::LOCATION, location)], Json(TrackBody::of(&track, &service.tracks)))
        .into_response())
}

/// Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track are taken one by
/// one, in the order in which they come. The last frame sent again, by a robot that got no answer, isn't counted twice.
/// When the alias moves to another version, the track goes on with that one.
#[utoipa::path(
    post, operation_id = "add_frame",
    path = "/v1/databases/{database}/tracks/{id}/frames", tag = "recognition", security(("key" = ["recognise"])), params(TrackPath, FrameQuery),
    request_body(
        description = "The picture, raw or as the part `image` of a form",
        content(
            (String = "image/jpeg"), (String = "image/png"), (String = "image/x-portable-graymap"),
            (String = "image/x-portable-pixmap"), (TrackFrameForm = "multipart/form-data")
        )
    ),
    responses((status = 200, body = TrackedFrameBody))
)]
pub async fn post_frame(
    State(service): State<Service>,
    Path(path): Path<TrackPath>,
    Query(query): Query<FrameQuery>,
    RobotHeader(header): RobotHeader,
    frame: OnePicture,
) -> Result<Json<TrackedFrameBody>, Problem> {
    let odometry = odometry(&query, &frame.texts)?;
    let wanted = Wanted::of(query.top, query.explain)?;
    let wanted = wanted.by_camera(&service, query.camera, &frame.texts).await?;
    let queue = service.tracks.queue(&path.database, path.id)?;
    let _guard = queue.lock().await?;
    let track = service.tracks.get(&path.database, path.id)?;
    let version = version_for(&service.databases, &path.database, None, track.alias.as_ref()).await?;
    let track = carried_over(&service.databases, &track, &version).await?;
    let sent = header.clone();
    let add = move |bytes: &[u8], weights: &[f64], fix: Option<&PlacePoseBody>| {
        track.after(sent, bytes, odometry.as_ref(), weights, fix)
    };
    let picture = frame.admitted(&service)?;
    let (recognised, (track, counted)) = recognise(&service, &version, picture, wanted, add).await?;
    let track = service.tracks.put(track)?;

    let mut recognition = render(&version, header, recognised);
    recognition.warnings.extend(order_warning(&track));
    let BeliefBody { decision, belief, elsewhere, pose } = BeliefBody::of(&track, wanted.top);
    let of_frame = std::mem::replace(&mut recognition.decision, decision);
    let pose_of_frame = recognition.evidence.replace_pose(pose);
    events::decided(&service, &recognition, Some(track.id));
    Ok(Json(TrackedFrameBody {
        track: track.id,
        belief,
        elsewhere,
        frame: FrameBody { number: track.frames, counted, decision: of_frame, pose: pose_of_frame },
        motion: word(&track.belief),
        expires_at: service.tracks.expires_at(&track),
        recognition,
    }))
}

/// The live tracks of a database, in the order in which they began.
#[utoipa::path(
    get, operation_id = "list_tracks",
    path = "/v1/databases/{database}/tracks", tag = "recognition", security(("key" = ["recognise"])), params(DatabasePath, PageQuery),
    responses((status = 200, body = Page<TrackBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<TrackBody>>, Problem> {
    service.databases.get(&path.database).await?;
    let Paging { limit, after } = Paging::read(page.limit, page.cursor.as_deref())?;
    let tracks = service.tracks.list(&path.database, after, limit);
    Ok(Json(Page::of(
        tracks,
        limit,
        |track| track.id.to_string(),
        |track| TrackBody::of(&track, &service.tracks),
    )))
}

/// One track with what is believed. Looking at it doesn't keep it alive.
#[utoipa::path(
    get, operation_id = "get_track",
    path = "/v1/databases/{database}/tracks/{id}", tag = "recognition", security(("key" = ["recognise"])), params(TrackPath, TrackQuery),
    responses((status = 200, body = TrackDetail))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<TrackPath>,
    Query(query): Query<TrackQuery>,
) -> Result<Json<TrackDetail>, Problem> {
    let top = Wanted::of(query.top, None)?.top;
    let track: Arc<Track> = service.tracks.get(&path.database, path.id)?;
    Ok(Json(TrackDetail {
        track: TrackBody::of(&track, &service.tracks),
        belief: BeliefBody::of(&track, top),
    }))
}

/// End a track.
#[utoipa::path(
    delete, operation_id = "end_track",
    path = "/v1/databases/{database}/tracks/{id}", tag = "recognition", security(("key" = ["recognise"])), params(TrackPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    Path(path): Path<TrackPath>,
) -> Result<StatusCode, Problem> {
    service.tracks.end(&path.database, path.id)?;
    Ok(StatusCode::NO_CONTENT)
}
