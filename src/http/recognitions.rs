//! `POST /v1/databases/{database}/recognitions[:batch]`: ask a frame what it shows.

use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use futures_util::StreamExt;
use futures_util::stream::FuturesOrdered;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::databases::{DatabasePath, KindWord};
use super::exemplars::ImageForm;
use super::extract::{Path, Query};
use super::problem::{Problem, ProblemBody};
use super::uploads::{Form, HeaderEcho, OnePicture, Picture, RobotHeader};
use super::{Service, accept};
use crate::compute::Lane;
use crate::database::{FrameHeader, LoadedVersion, Model, Name};
use crate::imaging::{self, DecodeError, Frame};
use crate::recognition::landmarks::{Landmarks, Recognition, Stage, annotate};

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
    /// Most labels in `votes`.
    #[param(minimum = 1, maximum = 1000, default = 5)]
    pub top: Option<usize>,
    /// Give every point's vote.
    #[param(default = false)]
    pub explain: Option<bool>,
}

/// Labels in `votes` when the call names no number.
const DEFAULT_TOP: usize = 5;
/// Most labels in `votes`.
const MAX_TOP: usize = 1000;

/// What a frame shows.
#[derive(Debug, Serialize, ToSchema)]
pub struct RecognitionBody {
    pub database: String,
    pub kind: KindWord,
    /// The version that answered.
    pub version: i64,
    /// Its digest: the same frame and digest give the same answer.
    pub digest: String,
    pub header: HeaderEcho,
    /// What to act on; null when nothing is recognised.
    pub decision: Option<DecisionBody>,
    /// Reasons to doubt the answer: `no_interest_points`, `few_interest_points`, `gray_frame`.
    pub warnings: Vec<&'static str>,
    pub timings_ms: TimingsBody,
    /// The evidence, best first.
    pub votes: Vec<VoteBody>,
    /// Interest points that voted.
    pub points_used: u64,
    /// Interest points in the frame.
    pub points_found: u64,
    /// With `explain`: every point's vote, most salient first. For each label the weights sum to its W.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<PointBody>>,
}

/// What the frame shows.
#[derive(Debug, Serialize, ToSchema)]
pub struct DecisionBody {
    pub label: String,
    /// Probability of being right; null while the version isn't calibrated.
    pub confidence: Option<f64>,
}

/// The votes for a label.
#[derive(Debug, Serialize, ToSchema)]
pub struct VoteBody {
    pub label: String,
    /// W of the label.
    pub weight: f64,
    /// Its part of all W.
    pub share: f64,
    /// Interest points whose vote counted for it.
    pub points: u64,
}

/// The vote of an interest point.
#[derive(Debug, Serialize, ToSchema)]
pub struct PointBody {
    pub x_px: f32,
    pub y_px: f32,
    pub salience: f32,
    /// Id of the exemplar with the nearest eigenpoint.
    pub exemplar: String,
    /// Its label.
    pub label: String,
    /// Distance D in the eigenspace.
    pub distance: f64,
    /// 1/(D+ε), or 0 when another exemplar of the label is the one that counts.
    pub weight: f64,
}

/// How long the parts of a recognition took, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct TimingsBody {
    /// Waiting for a computing thread.
    pub queue: f64,
    pub decode: f64,
    /// All that follows decoding.
    pub recognise: f64,
    /// Interest points.
    pub attention: f64,
    /// Sub-windows and their spectra.
    pub signature: f64,
    /// Projection and nearest eigenpoints.
    pub search: f64,
    pub vote: f64,
}

/// One item of a batch: a recognition, or the problem with that picture.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub enum BatchItem {
    Recognition(Box<RecognitionBody>),
    Failed { problem: ProblemBody },
}

/// The answers to a batch, in the order of its pictures.
#[derive(Debug, Serialize, ToSchema)]
pub struct RecognitionBatch {
    pub items: Vec<BatchItem>,
}

/// A form with several pictures.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct ImagesForm {
    /// The pictures: parts that are all called `image`.
    #[schema(content_media_type = "application/octet-stream")]
    image: Vec<String>,
}

/// How long each part of the work took.
#[derive(Debug, Clone, Copy, Default)]
struct Clocked {
    queue: Duration,
    decode: Duration,
    stages: [Duration; 4],
}

/// A recognition with what the answer needs beside it.
struct Recognised {
    recognition: Recognition,
    annotated: Option<Vec<u8>>,
    clocked: Clocked,
}

fn place(stage: Stage) -> usize {
    match stage {
        Stage::Attention => 0,
        Stage::Signature => 1,
        Stage::Search => 2,
        Stage::Vote => 3,
    }
}

/// Decode and recognise: runs on a computing thread.
fn recognise(
    picture: &Picture,
    limits: &imaging::DecodeLimits,
    landmarks: &Landmarks,
    with_picture: bool,
) -> Result<Recognised, DecodeError> {
    let mut clocked = Clocked::default();
    let mut last = Instant::now();
    let mut lap = || {
        let now = Instant::now();
        now.duration_since(std::mem::replace(&mut last, now))
    };
    let frame: Frame = imaging::decode(&picture.bytes, limits)?;
    clocked.decode = lap();
    let recognition = landmarks.recognise(&frame, |stage| clocked.stages[place(stage)] = lap());
    let annotated = with_picture.then(|| annotate(&frame, &recognition, landmarks).into_png());
    Ok(Recognised { recognition, annotated, clocked })
}

impl Service {
    async fn version_for(
        &self,
        database: &Name,
        query: &RecognitionQuery,
    ) -> Result<Arc<LoadedVersion>, Problem> {
        match (query.version, &query.alias) {
            (Some(_), Some(_)) => Err(Problem::field("#version", "and alias exclude each other: give one")),
            (Some(version), None) => Ok(self.databases.version_model(database, version).await?),
            (None, alias) => Ok(self.databases.alias_model(database, alias.as_ref()).await?),
        }
    }

    async fn recognise(
        &self,
        version: &Arc<LoadedVersion>,
        picture: Picture,
        with_picture: bool,
    ) -> Result<Recognised, Problem> {
        let (version, limits) = (Arc::clone(version), self.decode);
        let memory = picture.working_bytes;
        let work = move || {
            let Model::Landmarks(landmarks) = &version.model;
            recognise(&picture, &limits, landmarks, with_picture)
        };
        let (recognised, queue) = self.compute.run(Lane::Recognition, memory, work).await?;
        let mut recognised = recognised?;
        recognised.clocked.queue = queue;
        let clocked = recognised.clocked;
        let [attention, signature, search, vote] = clocked.stages;
        for (stage, took) in [
            ("queue", queue),
            ("decode", clocked.decode),
            ("attention", attention),
            ("signature", signature),
            ("search", search),
            ("vote", vote),
        ] {
            self.metrics.stage(stage, took);
        }
        Ok(recognised)
    }
}

fn render(
    version: &LoadedVersion,
    header: FrameHeader,
    recognised: &Recognised,
    query: &RecognitionQuery,
) -> Result<RecognitionBody, Problem> {
    let Model::Landmarks(landmarks) = &version.model;
    let recognition = &recognised.recognition;
    let top = top(query)?;
    let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
    let [attention, signature, search, vote] = recognised.clocked.stages.map(ms);
    let points = query.explain.unwrap_or(false).then(|| {
        let point = |vote: &crate::recognition::landmarks::PointVote| {
            let exemplar = &landmarks.exemplars()[vote.exemplar];
            PointBody {
                x_px: vote.x_px,
                y_px: vote.y_px,
                salience: vote.salience,
                exemplar: exemplar.id.clone(),
                label: exemplar.label.clone(),
                distance: vote.distance,
                weight: vote.weight,
            }
        };
        recognition.points.iter().map(point).collect()
    });
    Ok(RecognitionBody {
        database: version.database.clone(),
        kind: version.kind().into(),
        version: version.version,
        digest: version.digest.clone(),
        header: header.into(),
        decision: recognition
            .votes
            .first()
            .map(|best| DecisionBody { label: best.label.clone(), confidence: None }),
        warnings: recognition.warnings.iter().map(|warning| warning.code()).collect(),
        timings_ms: TimingsBody {
            queue: ms(recognised.clocked.queue),
            decode: ms(recognised.clocked.decode),
            recognise: attention + signature + search + vote,
            attention,
            signature,
            search,
            vote,
        },
        votes: recognition
            .votes
            .iter()
            .take(top)
            .map(|vote| VoteBody {
                label: vote.label.clone(),
                weight: vote.weight,
                share: vote.share,
                points: vote.points as u64,
            })
            .collect(),
        points_used: recognition.points_used as u64,
        points_found: recognition.points_found as u64,
        points,
    })
}

fn top(query: &RecognitionQuery) -> Result<usize, Problem> {
    match query.top.unwrap_or(DEFAULT_TOP) {
        top @ 1..=MAX_TOP => Ok(top),
        other => Err(Problem::field("#top", format!("{other} is not between 1 and {MAX_TOP}"))),
    }
}

/// Recognise one frame. With `Accept: image/png` the answer is the frame with points and votes drawn on it; the headers
/// `X-Version` and `X-Digest` say what answered.
#[utoipa::path(
    post, operation_id = "recognise",
    path = "/v1/databases/{database}/recognitions", tag = "recognition", params(DatabasePath, RecognitionQuery),
    request_body(
        description = "The picture, raw or as the part `image` of a form",
        content(
            (String = "image/jpeg"), (String = "image/png"), (String = "image/x-portable-graymap"),
            (String = "image/x-portable-pixmap"), (ImageForm = "multipart/form-data")
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
    OnePicture(picture): OnePicture,
) -> Result<Response, Problem> {
    let given = accept::choose(&headers, &["application/json", "image/png"])?;
    let with_picture = given == "image/png";
    top(&query)?;
    let version = service.version_for(&path.database, &query).await?;
    let recognised = service.recognise(&version, picture, with_picture).await?;
    let mut response = match recognised.annotated {
        Some(png) => {
            let text = |text: &str| HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static(""));
            let headers = [
                (header::CONTENT_TYPE, HeaderValue::from_static("image/png")),
                (HeaderName::from_static("x-version"), HeaderValue::from(version.version)),
                (HeaderName::from_static("x-digest"), text(&version.digest)),
            ];
            (headers, png).into_response()
        }
        None => Json(render(&version, header, &recognised, &query)?).into_response(),
    };
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

/// Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.
#[utoipa::path(
    post, operation_id = "recognise_batch",
    path = "/v1/databases/{database}/recognitions:batch", tag = "recognition",
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
    top(&query)?;
    let version = service.version_for(&path.database, &query).await?;
    let limits = &service.limits;
    let mut form = Form::of(request, &service, limits.max_batch_bytes).await?;
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
        let (service, version, query, header) = (&service, &version, &query, header.clone());
        running.push_back(async move {
            let picture = Picture::of(named?, &service.decode)?;
            let recognised = service.recognise(version, picture, false).await?;
            render(version, header, &recognised, query)
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

fn item(done: Result<RecognitionBody, Problem>) -> BatchItem {
    match done {
        Ok(body) => BatchItem::Recognition(Box::new(body)),
        Err(problem) => BatchItem::Failed { problem: problem.into() },
    }
}
