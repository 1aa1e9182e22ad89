//! `POST /v1/databases/{database}/recognitions[:batch]`: ask a frame what it shows. What is particular to a kind
//! stands in a file of its own.

mod landmarks;
mod localisation;
mod objects;

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use futures_util::stream::FuturesOrdered;
use serde::{Deserialize, Serialize};
use tokio_util::task::AbortOnDropHandle;
use utoipa::{IntoParams, ToSchema};

use super::cameras::CameraReference;
use super::extract::{Path, Query};
use super::paths::DatabasePath;
use super::problem::{Code, Problem, ProblemBody};
use super::stages::{StageClock, ms};
use super::uploads::{Form, OnePicture, Picture, RobotHeader, Texts};
use super::{Service, accept, events};
use crate::compute::Lane;
use crate::database::survey::CameraDocument;
use crate::database::{Databases, FrameHeader, Kind, LoadedVersion, Model, Name};
use crate::telemetry::Work;
use landmarkd_core::imaging::{self, Frame};

use landmarks::{Chosen, LandmarkEvidence, LandmarkStages};
use localisation::Surveyed;
pub(super) use localisation::{PlacePoseBody, flat};
use objects::{ObjectEvidence, ObjectStages};

pub(super) use objects::{CandidateBody, PoseBody};

/// What answers, and how much of the evidence is wanted.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct RecognitionQuery {
    /// The alias whose version answers; `current` when neither alias nor version is given.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub alias: Option<Name>,
    /// Number of the version that answers.
    #[param(minimum = 1)]
    pub version: Option<i64>,
    /// Most labels in `votes` or `candidates`; of candidates there are five at most.
    #[param(minimum = 1, maximum = 1000, default = 5)]
    pub top: Option<usize>,
    /// Give every point's vote. Objects have no more to give.
    #[param(default = false)]
    pub explain: Option<bool>,
    /// The name of a kept camera that took the frame: then where exemplars have poses the frame's is computed from the points in
    /// common. A form has its intrinsics, or a name, as the part `camera`.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub camera: Option<Name>,
}

/// Labels in `votes` or `candidates` when the call names no number.
const DEFAULT_TOP: usize = 5;
/// Most labels in `votes` or `candidates`.
const MAX_TOP: usize = 1000;

impl StagesBody {
    /// Their sum, in milliseconds.
    fn total(&self) -> f64 {
        match self {
            Self::Landmarks(stages) => {
                let LandmarkStages { attention, signature, fetch, search, vote, verification, locate } =
                    stages;
                attention + signature + fetch + search + vote + verification + locate
            }
            Self::Objects(stages) => stages.appearance + stages.universal + stages.object,
        }
    }
}

/// What a frame shows.
#[derive(Debug, Serialize, ToSchema)]
pub struct RecognitionBody {
    pub database: String,
    pub kind: Kind,
    /// The version that answered.
    pub version: i64,
    /// Its digest: the same frame and digest give the same answer.
    pub digest: String,
    pub header: FrameHeader,
    /// What to act on; null when nothing is recognised, or not for sure enough.
    pub decision: Option<DecisionBody>,
    /// Reasons to doubt the answer. Landmarks: `no_interest_points`, `too_few_points`, `votes_on_background`,
    /// `close_second`, `gray_frame`. Objects: `resized`, `blank_picture`, `over_exposed`, `gray_frame`, `beyond_threshold`,
    /// `close_second`, `not_calibrated`; with `segment` also `no_region`, `touches_border`, `several_regions`.
    pub warnings: Vec<&'static str>,
    pub timings_ms: TimingsBody,
    #[serde(flatten)]
    pub evidence: EvidenceBody,
}

impl EvidenceBody {
    /// Replaces where the camera is; gives what it was.
    pub fn replace_pose(&mut self, pose: Option<PlacePoseBody>) -> Option<PlacePoseBody> {
        match self {
            Self::Landmarks(evidence) => {
                evidence.pose.as_mut().and_then(|of_frame| std::mem::replace(of_frame, pose))
            }
            Self::Objects(_) => None,
        }
    }

    /// Where the camera is, if the version's exemplars have poses.
    pub fn pose(&self) -> Option<&PlacePoseBody> {
        match self {
            Self::Landmarks(evidence) => evidence.pose.as_ref()?.as_ref(),
            Self::Objects(_) => None,
        }
    }
}

/// What speaks for the answer, by the kind of the database.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub enum EvidenceBody {
    Landmarks(Box<LandmarkEvidence>),
    Objects(ObjectEvidence),
}

/// What the frame shows.
#[derive(Debug, Serialize, ToSchema)]
pub struct DecisionBody {
    pub label: String,
    /// Probability of being right; null while the version isn't calibrated.
    pub confidence: Option<f64>,
}

/// Why a decision is null.
#[derive(Debug, Serialize, ToSchema)]
pub struct ReasonBody {
    /// Landmarks: `too_dark`, `over_exposed`, `little_to_see`, `ambiguous`, `weak_evidence`, `known_background`, `mirrored`,
    /// `unlike_anything`. Objects: `light`, `off_centre`, `scale`, `hidden`, `between_views`, `unlike_anything`.
    pub code: &'static str,
    /// What was seen.
    pub detail: String,
    /// What to do about it.
    pub remedy: String,
}

/// How long the parts of a recognition took, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct TimingsBody {
    /// Waiting for a computing thread.
    pub queue: f64,
    pub decode: f64,
    /// All that follows decoding.
    pub recognise: f64,
    #[serde(flatten)]
    pub stages: StagesBody,
}

/// The parts of what follows decoding, in milliseconds, by the kind of the database.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
#[serde(untagged)]
pub enum StagesBody {
    Landmarks(LandmarkStages),
    Objects(ObjectStages),
}

/// One item of a batch: a recognition, or the problem with that picture.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub enum RecognitionItem {
    Recognition(Box<RecognitionBody>),
    Failed { problem: ProblemBody },
}

/// The answers to a batch, in the order of its pictures.
#[derive(Debug, Serialize, ToSchema)]
pub struct RecognitionBatch {
    pub items: Vec<RecognitionItem>,
}

/// A form with a frame, and the camera that took it.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct FrameForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
    /// The camera that took it.
    camera: Option<CameraReference>,
}

/// A form with several pictures.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct ImagesForm {
    /// The pictures: parts that are all called `image`.
    #[schema(content_media_type = "application/octet-stream")]
    image: Vec<String>,
}

/// How much of an answer is wanted.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    pub top: usize,
    explain: bool,
    drawing: Option<Drawing>,
    /// The camera that took the frame.
    camera: Option<CameraDocument>,
}

/// A picture instead of numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Drawing {
    /// The frame with the evidence on it.
    Evidence,
    /// What the eigenspace makes of it; of kind `objects` only.
    Reconstruction,
}

const DISTANCE_FROM_SPACE: HeaderName = HeaderName::from_static("x-distance-from-space");

impl Drawing {
    const RECONSTRUCTION: &str = "image/png; view=reconstruction";

    /// By the type that was accepted.
    fn of(given: &str) -> Option<Self> {
        match given {
            "image/png" => Some(Self::Evidence),
            Self::RECONSTRUCTION => Some(Self::Reconstruction),
            _ => None,
        }
    }
}

/// The picture that was wanted.
struct Drawn {
    png: Vec<u8>,
    /// Of a reconstruction.
    distance_from_space: Option<f64>,
}

impl Wanted {
    /// As a query has it, without a drawing.
    pub fn of(top: Option<usize>, explain: Option<bool>) -> Result<Self, Problem> {
        let explain = explain.unwrap_or(false);
        match top.unwrap_or(DEFAULT_TOP) {
            top @ 1..=MAX_TOP => Ok(Self { top, explain, drawing: None, camera: None }),
            other => Err(Problem::field("#top", format!("{other} is not between 1 and {MAX_TOP}"))),
        }
    }
}

impl Wanted {
    /// The same, of a frame that this camera took: the one that a form has, or that the query names.
    ///
    /// # Errors
    /// There is no camera of that name, or the intrinsics can't be.
    pub async fn by_camera(
        self,
        service: &Service,
        named: Option<Name>,
        texts: &Texts,
    ) -> Result<Self, Problem> {
        let named = named.map(|name| (CameraReference::Name(name.to_string()), "#camera"));
        let sent = texts.get("camera").map(|text| CameraReference::of_text(text)).transpose();
        let sent = sent.map_err(|problem| problem.in_part("camera"))?.map(|camera| (camera, "/camera"));
        let camera = match sent.or(named) {
            Some((camera, at)) => Some(camera.resolved(service, at).await?),
            None => None,
        };
        Ok(Self { camera, ..self })
    }
}

/// The answer of a model of some kind to a frame.
struct Answer {
    decision: Option<DecisionBody>,
    warnings: Vec<&'static str>,
    evidence: EvidenceBody,
    stages: StagesBody,
    drawn: Option<Drawn>,
    /// W of every exemplar of landmarks, in the model's order.
    exemplar_weights: Vec<f64>,
}

/// An answer with the times of its stages.
pub(super) struct Recognised {
    answer: Answer,
    queue: Duration,
    clock: StageClock,
}

/// The version of that number, or the one that answers for that alias, by default `current`.
///
/// # Errors
/// Both are given, or there is no such version.
pub(super) async fn version_for(
    databases: &Databases,
    database: &Name,
    version: Option<i64>,
    alias: Option<&Name>,
) -> Result<Arc<LoadedVersion>, Problem> {
    match (version, alias) {
        (Some(_), Some(_)) => Err(Problem::field("#version", "and alias exclude each other: give one")),
        (Some(version), None) => Ok(databases.version_model(database, version).await?),
        (None, alias) => Ok(databases.alias_model(database, alias).await?),
    }
}

/// How far the first visit to a computing thread came.
enum Visited<T, Add> {
    Answered(Answer, T),
    /// The version's windows are not in memory: those of the chosen exemplars are to be read.
    Chosen(Frame, Chosen, Add),
}

/// Decodes and recognises on computing threads. Calls `add` there with the picture's bytes, W of every exemplar and where the
/// frame was taken.
///
/// # Errors
/// The picture can't be decoded or isn't of the database's size, too much waits already, or the version's windows can't be
/// read.
pub(super) async fn recognise<T: Send + 'static>(
    service: &Service,
    version: &Arc<LoadedVersion>,
    picture: Picture,
    wanted: Wanted,
    add: impl FnOnce(&[u8], &[f64], Option<&PlacePoseBody>) -> T + Send + 'static,
) -> Result<(Recognised, T), Problem> {
    let limits = service.decode;
    // a drawing shows the picture as it was posted
    let side_px = match &version.model {
        Model::Landmarks(model) if wanted.drawing.is_none() => model.options().working_size_px,
        Model::Landmarks(_) | Model::Objects(_) => None,
    };
    let memory = side_px.map_or(picture.working_bytes, |side_px| picture.header.reduced_bytes(side_px));
    let _turn = version.turn().await;
    let (asked, bytes, header) = (Arc::clone(version), picture.bytes.clone(), picture.header);
    let visit = move || {
        let mut clock = StageClock::begin();
        let frame = match side_px {
            Some(side_px) => imaging::decode_reduced(&bytes, &limits, side_px)?,
            None => imaging::decode(&bytes, &limits)?,
        };
        clock.end("decode");
        let answer = match &asked.model {
            Model::Landmarks(model) if asked.kept.is_some() => {
                let chosen = landmarks::choose(&frame, model, &mut clock)?;
                return Ok((Visited::Chosen(frame, chosen, add), clock));
            }
            Model::Landmarks(model) => {
                let surveyed = Surveyed::of(&asked.surveys, wanted.camera.as_ref(), &header, &frame)?;
                landmarks::answer(&frame, model, &surveyed, wanted, &mut clock)
            }
            Model::Objects(model) => objects::answer(&frame, model, wanted, &mut clock)?,
        };
        let added = add(&bytes, &answer.exemplar_weights, answer.evidence.pose());
        Ok::<_, Problem>((Visited::Answered(answer, added), clock))
    };
    let (visited, mut queue) = service.compute.run(Lane::Recognition, memory, visit).await?;
    let (visited, clock) = visited?;
    let (answer, added, clock) = match visited {
        Visited::Answered(answer, added) => (answer, added, clock),
        Visited::Chosen(frame, chosen, add) => {
            let (asked, indices) = (Arc::clone(version), chosen.exemplars.clone());
            // a task of its own: a batch whose next picture is waited for must not hold up the store's answer
            let read = tokio::spawn(async move { asked.read_exemplars(&indices).await });
            let read = AbortOnDropHandle::new(read).await.map_err(|_| landmarks::not_kept())??;
            let (asked, mut clock) = (Arc::clone(version), clock);
            clock.end(landmarks::FETCH);
            // the lists of few windows are hardly filled
            let memory = memory + 4 * read.bytes();
            let again = move || {
                clock.resume();
                let Model::Landmarks(model) = &asked.model else { return Err(landmarks::not_kept()) };
                let surveyed = Surveyed::of(&asked.surveys, wanted.camera.as_ref(), &header, &frame)?;
                let kept = read.kept();
                let answer =
                    landmarks::answer_among(&frame, model, &chosen, kept, &surveyed, wanted, &mut clock)?;
                let added = add(&picture.bytes, &answer.exemplar_weights, answer.evidence.pose());
                Ok::<_, Problem>((answer, added, clock))
            };
            let (done, second) = service.compute.run(Lane::Recognition, memory, again).await?;
            queue += second;
            done?
        }
    };
    clock.record(&service.metrics, Work::Recognition, queue);
    Ok((Recognised { answer, queue, clock }, added))
}

/// A picture with the evidence; its headers name the version that answered.
pub(super) fn drawn(version: &LoadedVersion, png: Vec<u8>) -> Response {
    let text = |text: &str| HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static(""));
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("image/png")),
        (HeaderName::from_static("x-version"), HeaderValue::from(version.version)),
        (HeaderName::from_static("x-digest"), text(&version.digest)),
    ];
    (headers, png).into_response()
}

pub(super) fn render(
    version: &LoadedVersion,
    header: FrameHeader,
    recognised: Recognised,
) -> RecognitionBody {
    let Recognised { answer, queue, clock } = recognised;
    RecognitionBody {
        database: version.database.clone(),
        kind: version.model.kind(),
        version: version.version,
        digest: version.digest.clone(),
        header,
        decision: answer.decision,
        warnings: answer.warnings,
        timings_ms: TimingsBody {
            queue: ms(queue),
            decode: clock.ms("decode"),
            recognise: answer.stages.total(),
            stages: answer.stages,
        },
        evidence: answer.evidence,
    }
}

/// Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it (points and votes,
/// or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
/// `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes of the frame, three
/// pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and the residual about
/// mid-gray, whose length is `X-Distance-From-Space`.
#[utoipa::path(
    post, operation_id = "recognise",
    path = "/v1/databases/{database}/recognitions", tag = "recognition", security(("key" = ["recognise"])), params(DatabasePath, RecognitionQuery),
    request_body(
        description = "The picture, raw or as the part `image` of a form",
        content(
            (String = "image/jpeg"), (String = "image/png"), (String = "image/x-portable-graymap"),
            (String = "image/x-portable-pixmap"), (FrameForm = "multipart/form-data")
        )
    ),
    responses((status = 200, description = "What the frame shows", content(
        (RecognitionBody = "application/json"), (Vec<u8> = "image/png")
    )))
)]
pub async fn post(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(query): Query<RecognitionQuery>,
    headers: HeaderMap,
    RobotHeader(header): RobotHeader,
    frame: OnePicture,
) -> Result<Response, Problem> {
    let given = accept::choose(&headers, &["application/json", "image/png", Drawing::RECONSTRUCTION])?;
    let wanted = Wanted { drawing: Drawing::of(given), ..Wanted::of(query.top, query.explain)? };
    let wanted = wanted.by_camera(&service, query.camera, &frame.texts).await?;
    let version =
        version_for(&service.databases, &path.database, query.version, query.alias.as_ref()).await?;
    if wanted.drawing == Some(Drawing::Reconstruction) && matches!(version.model, Model::Landmarks(_)) {
        let text = format!("database {} is of kind landmarks: accept image/png", version.database);
        return Err(Problem::new(Code::NotAcceptable, text));
    }
    let picture = frame.admitted(&service)?;
    let (mut recognised, ()) = recognise(&service, &version, picture, wanted, |_, _, _| ()).await?;
    let response = match recognised.answer.drawn.take() {
        Some(Drawn { png, distance_from_space }) => {
            let mut response = drawn(&version, png);
            if let Some(Ok(distance)) = distance_from_space.map(|d| format!("{d:.6}").parse()) {
                response.headers_mut().insert(DISTANCE_FROM_SPACE, distance);
            }
            response
        }
        None => {
            let body = render(&version, header, recognised);
            events::decided(&service, &body, None);
            Json(body).into_response()
        }
    };
    Ok(accept::vary(response))
}

/// Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.
#[utoipa::path(
    post, operation_id = "recognise_batch",
    path = "/v1/databases/{database}/recognitions:batch", tag = "recognition", security(("key" = ["recognise"])),
    params(DatabasePath, RecognitionQuery),
    request_body(content = ImagesForm, content_type = "multipart/form-data"),
    responses((status = 200, body = RecognitionBatch))
)]
pub async fn post_batch(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(query): Query<RecognitionQuery>,
    RobotHeader(header): RobotHeader,
    request: Request,
) -> Result<Json<RecognitionBatch>, Problem> {
    let wanted = Wanted::of(query.top, query.explain)?;
    let wanted = wanted.by_camera(&service, query.camera, &Texts::new()).await?;
    let version =
        version_for(&service.databases, &path.database, query.version, query.alias.as_ref()).await?;
    let limits = &service.limits;
    let mut form = Form::of(request, &service, limits.max_batch_bytes, limits.max_body_bytes).await?;
    let mut items = Vec::new();
    let mut running = FuturesOrdered::new();
    // As many pictures are held as there are threads for them, and one that arrives.
    let most_running = service.compute.threads(Lane::Recognition);
    while let Some((name, part)) = form.next().await? {
        let read = part.read(limits.max_body_bytes).await?;
        let named = if name == "image" {
            read
        } else {
            Err(Problem::field("/image", format!("every part is called image, not {name:?}")))
        };
        let (service, version, header) = (&service, &version, header.clone());
        running.push_back(async move {
            let picture = Picture::of(named?, &service.decode)?;
            let (recognised, ()) = recognise(service, version, picture, wanted, |_, _, _| ()).await?;
            let body = render(version, header, recognised);
            events::decided(service, &body, None);
            Ok(body)
        });
        if running.len() >= most_running
            && let Some(done) = running.next().await
        {
            items.push(item(done));
        }
    }
    while let Some(done) = running.next().await {
        items.push(item(done));
    }
    if items.is_empty() {
        return Err(Problem::field("/image", "the form has no part called image"));
    }
    Ok(Json(RecognitionBatch { items }))
}

fn item(done: Result<RecognitionBody, Problem>) -> RecognitionItem {
    match done {
        Ok(body) => RecognitionItem::Recognition(Box::new(body)),
        Err(problem) => RecognitionItem::Failed { problem: problem.into() },
    }
}
