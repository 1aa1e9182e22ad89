//! `POST /v1/workcells/{name}/inspections`: every part on the table, what it is, how it is turned, where to reach.

use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::access::reach;
use super::extract::{Path, Query};
use super::pairs::{PairParts, PairPictures};
use super::problem::{Code, FieldError, Problem};
use super::recognitions::{CandidateBody, DecisionBody, PoseBody, drawn, version_for};
use super::regions::{GroundBody, LeftOutBody, RegionBody};
use super::stages::{StageClock, ms};
use super::uploads::{KnownParts, Picture, RobotHeader};
use super::workcells::WorkcellPath;
use super::{Service, accept};
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::{DatabaseError, FrameHeader, KeptWorkcell, Kind, LoadedVersion, Model, Name};
use crate::telemetry::Work;
use landmarkd_core::depth::{Calibration, FocalPair};
use landmarkd_core::imaging::{self, DecodeLimits, Frame};
use landmarkd_core::recognition::objects::Objects;
use landmarkd_core::workcell::{
    Inspection, InspectionError, PairScene, PairView, Part, Stage, Workcell, annotate, inspect,
    inspect_with_depth,
};

/// What the pair shows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum PairViewWord {
    /// One part, from near: the local camera's view.
    #[default]
    Local,
    /// The whole table, pixel by pixel as the overview shows it.
    Overview,
}

/// What answers, and what the pair shows.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct InspectionQuery {
    /// The alias whose version answers; `current` when neither alias nor version is given.
    #[param(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub alias: Option<Name>,
    /// Number of the version that answers.
    #[param(minimum = 1)]
    pub version: Option<i64>,
    /// With a pair of one part: the id of its region; by default the only one, or the one nearest the overview's
    /// middle.
    #[param(minimum = 1)]
    pub region: Option<usize>,
    /// With a pair: `local` (one part, seen by the local camera) or `overview` (the overview's geometry: every part
    /// gets its distance).
    #[param(inline, required = false)]
    pub pair_view: Option<PairViewWord>,
}

/// The table, and with `near` and `far`, or `wide` and `narrow`, a pair of a part or of the table.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct InspectionForm {
    /// The overview camera's picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    overview: String,
    /// The near-focused picture; with `far`, and a calibration in the workcell.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    near: Option<String>,
    /// The far-focused picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    far: Option<String>,
    /// By a calibration of two apertures: the picture of the wider one; with `narrow`.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    wide: Option<String>,
    /// The picture of the narrower aperture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    narrow: Option<String>,
}

/// What stands on the table.
#[derive(Debug, Serialize, ToSchema)]
pub struct InspectionBody {
    pub workcell: String,
    pub database: String,
    /// The version that answered.
    pub version: i64,
    pub digest: String,
    /// The calibration that distances were measured with; null without a pair.
    pub calibration: Option<String>,
    pub header: FrameHeader,
    pub width_px: usize,
    pub height_px: usize,
    /// Regions of at least the least area, also those beyond `max_objects`.
    pub regions_found: usize,
    /// One for each region, the largest first; also those that are nothing known.
    pub objects: Vec<PartBody>,
    /// `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. `touching`: a region may be several
    /// parts. `large_region`: the largest may be the table itself. `little_ground`: too little of the picture is ground to
    /// be sure of its level. `textured_ground`: parts of little contrast are lost in its texture. `line_left_out`,
    /// `shadows_left_out`, `small_left_out` (nearly as large as the least area): see `left_out`. `perhaps_shadow`: a part's
    /// dark side may be its shadow. `not_segmented`: the version
    /// was trained without `segment`, so that its pictures were made by another recipe than the parts are cut out by.
    /// `no_region_in_pair`: nothing stands out in the near-focused picture. Those of a depth map with `depth_` before.
    pub warnings: Vec<String>,
    /// What differs from the ground and is no region.
    #[schema(required = false)]
    pub left_out: LeftOutBody,
    /// What the overview was compared with; null with a threshold for the whole picture.
    pub ground: Option<GroundBody>,
    pub timings_ms: InspectionTimings,
}

/// A part on the table.
#[derive(Debug, Serialize, ToSchema)]
pub struct PartBody {
    pub region: RegionBody,
    /// Where its centroid is, X and Y; null beyond the horizon of the mapping.
    pub robot_mm: Option<[f64; 2]>,
    /// Direction of its principal axis, in [-90, 90), from X towards Y; null if it has none.
    pub robot_deg: Option<f64>,
    /// What it is; null when it is like nothing that is known.
    pub decision: Option<DecisionBody>,
    /// The objects that were looked at closely, the likeliest first.
    pub candidates: Vec<CandidateBody>,
    /// How it is turned; null without a decision, when fewer than three exemplars differ in pose, or while the
    /// version isn't calibrated.
    pub pose: Option<PoseBody>,
    /// Median of the distances within its region; null if none was measured.
    pub distance_mm: Option<f64>,
    /// Standard deviation to be expected of it; null if the method tells none.
    pub distance_sigma_mm: Option<f64>,
    /// Part of its pixels that have a distance.
    pub distance_coverage: Option<f64>,
    /// Those of a recognition: `touches_border` (what is missing may change the answer), `over_exposed`,
    /// `blank_picture`, `beyond_threshold`, `close_second`, `not_calibrated`. `beyond_horizon`: the mapping has no
    /// place for it. `no_depth`: it was looked for, and no pixel of the part has one.
    pub warnings: Vec<&'static str>,
}

/// How long the parts of an inspection took, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct InspectionTimings {
    /// Waiting for a computing thread.
    pub queue: f64,
    pub decode: f64,
    pub segment: f64,
    /// Cutting out, centring and scaling of all parts.
    pub cut: f64,
    /// Which objects, and how turned.
    pub recognise: f64,
    /// Making filters ready; next to nothing when the same calibration was used lately.
    pub design: f64,
    /// The depth map, and the distances of the parts.
    pub depth: f64,
    /// All that follows decoding: the sum of the five before.
    pub total: f64,
}

/// The pictures of a request.
struct Pictures {
    overview: Picture,
    pair: Option<Pair>,
}

/// The focal pair of a request, and what it shows.
struct Pair {
    pictures: PairPictures,
    scene: PairScene,
    calibration: Calibration,
}

impl Pictures {
    /// Reads the form. `calibration` is the name of the workcell's.
    ///
    /// # Errors
    /// Parts that are missing or don't go together, pictures that are not taken, an unknown calibration.
    async fn read(
        request: Request,
        query: &InspectionQuery,
        calibration: Option<&Name>,
        service: &Service,
    ) -> Result<Self, Problem> {
        let mut parts =
            KnownParts::of(request, service, &["overview", "near", "far", "wide", "narrow"], &[], None)
                .await?;
        let wrong = pair_faults(&parts, query, calibration.is_some());
        let overview = parts.require("overview");
        parts.faults.extend(wrong);
        let (Some(overview), []) = (overview, parts.faults.as_slice()) else {
            return Err(Problem::fields(parts.faults));
        };
        let in_part = |name: &'static str| move |problem: Problem| problem.in_part(name);
        let overview = Picture::of(overview, &service.decode).map_err(in_part("overview"))?;
        let pair = match calibration.filter(|_| parts.holds("near") || parts.holds("wide")) {
            Some(calibration) => {
                let calibration = service.databases.rig(calibration).await?.calibration;
                let (Some(taken), []) = (PairParts::take(&mut parts), parts.faults.as_slice()) else {
                    return Err(Problem::fields(parts.faults));
                };
                let pictures = taken.pictures(&calibration.optics, &service.decode)?;
                Some(Pair { pictures, scene: query.scene(), calibration })
            }
            None => None,
        };
        Ok(Self { overview: overview.with_share(parts.share), pair })
    }

    /// The overview, and the focal pair if there is one.
    fn decode(&self, limits: &DecodeLimits) -> Result<(Frame, Option<FocalPair>), Problem> {
        let overview = imaging::decode(&self.overview.bytes, limits)
            .map_err(|error| Problem::from(error).in_part("overview"))?;
        let decoded = |pair: &Pair| pair.pictures.decoded(limits);
        Ok((overview, self.pair.as_ref().map(decoded).transpose()?))
    }

    /// Memory that they take while they are worked on.
    fn working_bytes(&self) -> u64 {
        let pair = self.pair.as_ref().map_or(0, |pair| pair.pictures.depth_bytes());
        self.overview.header.segmentation_bytes() + pair
    }
}

impl InspectionQuery {
    fn scene(&self) -> PairScene {
        match self.pair_view.unwrap_or_default() {
            PairViewWord::Local => PairScene::Local { region: self.region },
            PairViewWord::Overview => PairScene::Overview,
        }
    }
}

/// What a computing thread makes of a request.
struct Inspected {
    inspection: Inspection,
    png: Option<Vec<u8>>,
    stages: StageClock,
}

/// Decode, inspect, draw: runs on a computing thread.
fn inspected(
    pictures: &Pictures,
    workcell: &Workcell,
    version: &LoadedVersion,
    is_drawn: bool,
    service: &Service,
) -> Result<Inspected, Problem> {
    let model = objects(version)?;
    let mut stages = StageClock::begin();
    let (overview, pair) = pictures.decode(&service.decode)?;
    stages.end("decode");
    let finished = |stage| {
        stages.end(match stage {
            Stage::Segment => "segment",
            Stage::Crop => "cut",
            Stage::Recognise => "recognise",
            Stage::Design => "design",
            Stage::Depth => "depth",
        });
    };
    let inspection = match (&pair, &pictures.pair) {
        (Some(pair), Some(Pair { pictures, scene, calibration })) => {
            let view = PairView { pair, scene: *scene, calibration };
            let estimator = |calibration: &_, options: &_| service.estimators.ready(calibration, options);
            inspect_with_depth(&overview, &view, workcell, model, estimator, finished)
                .map_err(|error| refused(error, pictures.first_name()))?
        }
        _ => inspect(&overview, workcell, model, finished),
    };
    let png = is_drawn.then(|| annotate(&overview, &inspection).into_png());
    if is_drawn {
        stages.end("encode");
    }
    Ok(Inspected { inspection, png, stages })
}

/// The model of a version, if it is one of objects.
fn objects(version: &LoadedVersion) -> Result<&Objects, Problem> {
    match &version.model {
        Model::Objects(model) => Ok(model),
        Model::Landmarks(_) => Err(DatabaseError::WrongKind {
            database: version.database.clone(),
            kind: version.model.kind().as_str().into(),
            wanted: Kind::Objects.as_str(),
        }
        .into()),
    }
}

/// The problem of a pair whose first picture is the part of this name.
fn refused(error: InspectionError, first: &str) -> Problem {
    match error {
        InspectionError::OtherSize { overview_px, pair_px } => {
            other_size(overview_px, pair_px).in_part(first)
        }
        InspectionError::UnknownRegion { id, regions } => unknown_region(id, regions),
        InspectionError::Estimator(error) => error.into(),
        InspectionError::Estimate(error) => error.into(),
    }
}

fn other_size(overview_px: (usize, usize), pair_px: (usize, usize)) -> Problem {
    let text = format!(
        "the pair has {}×{} px and the overview {}×{}: with pair_view=overview both have one size; without it the pair \
         is the local camera's view of one part",
        pair_px.0, pair_px.1, overview_px.0, overview_px.1
    );
    Problem::new(Code::ImageSizeMismatch, text)
}

fn unknown_region(id: usize, regions: usize) -> Problem {
    let there = match regions {
        0 => "nothing stands out in the overview".to_owned(),
        1 => "the overview has the region 1 alone".to_owned(),
        regions => format!("the overview has the regions 1 to {regions}"),
    };
    let text = format!("there is no region {id}: {there}; leave it out for the one nearest the middle");
    let at_fault = FieldError { pointer: "#region".into(), detail: text.clone() };
    Problem::new(Code::NoRegion, text).with_errors(vec![at_fault])
}

/// What is wrong with the parts of the form, taken with the query and the workcell.
fn pair_faults(parts: &KnownParts, query: &InspectionQuery, has_calibration: bool) -> Vec<FieldError> {
    let mut faults = Vec::new();
    let mut fault = |pointer: &str, detail: &str| {
        faults.push(FieldError { pointer: pointer.into(), detail: detail.into() });
    };
    let mut first = None;
    for [a, b] in [["near", "far"], ["wide", "narrow"]] {
        for [missing, sent] in [[b, a], [a, b]] {
            first = first.or(parts.holds(sent).then_some(sent));
            if parts.holds(sent) && !parts.holds(missing) {
                fault(&format!("/{missing}"), &format!("is missing: {a} and {b} come together"));
            }
        }
    }
    if let Some(first) = first.filter(|_| !has_calibration) {
        fault(
            &format!("/{first}"),
            "needs a calibration: PUT the workcell with the name of one, or leave the pair out",
        );
    }
    let any = first.is_some();
    let is_overview = query.pair_view == Some(PairViewWord::Overview);
    if query.pair_view.is_some() && !any {
        fault("#pair_view", "is about a pair: send near and far, or wide and narrow, or leave it out");
    }
    if query.region.is_some() && !any {
        fault("#region", "says what a pair shows: send near and far, or wide and narrow, or leave it out");
    } else if query.region.is_some() && is_overview {
        fault("#region", "and pair_view=overview exclude each other: there the pair shows every part");
    }
    faults
}

/// Find every part on the table, say what it is, how it is turned and where to reach; with a focal pair, how far away
/// it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png` the answer is
/// the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.
#[utoipa::path(
    post, operation_id = "inspect",
    path = "/v1/workcells/{name}/inspections", tag = "workcell", security(("key" = ["recognise"])), params(WorkcellPath, InspectionQuery),
    request_body(content = InspectionForm, content_type = "multipart/form-data"),
    responses((status = 200, description = "What stands on the table", content(
        (InspectionBody = "application/json"), (Vec<u8> = "image/png")
    )))
)]
pub async fn post(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<WorkcellPath>,
    Query(query): Query<InspectionQuery>,
    headers: HeaderMap,
    RobotHeader(header): RobotHeader,
    request: Request,
) -> Result<Response, Problem> {
    let is_drawn = accept::choose(&headers, &["application/json", "image/png"])? == "image/png";
    let KeptWorkcell { name, setup, .. } = service.databases.workcell(&path.name).await?;
    reach(&caller, setup.database.as_str())?;
    let version =
        version_for(&service.databases, &setup.database, query.version, query.alias.as_ref()).await?;
    let pictures = Pictures::read(request, &query, setup.calibration.as_ref(), &service).await?;
    let calibration = setup.calibration.filter(|_| pictures.pair.is_some());
    let memory = pictures.working_bytes();
    let work = {
        let (service, version, workcell) = (service.clone(), Arc::clone(&version), setup.workcell);
        move || inspected(&pictures, &workcell, &version, is_drawn, &service)
    };
    let (worked, queue) = service.compute.run(Lane::Recognition, memory, work).await?;
    let inspected = worked?;
    inspected.stages.record(&service.metrics, Work::Workcell, queue);
    Ok(accept::vary(inspected.render(name, calibration, &version, header, queue)))
}

impl Inspected {
    /// The answer; `queue` is the time that the work waited for a thread.
    fn render(
        self,
        workcell: String,
        calibration: Option<Name>,
        version: &LoadedVersion,
        header: FrameHeader,
        queue: Duration,
    ) -> Response {
        let Self { inspection, png, stages } = self;
        if let Some(png) = png {
            return drawn(version, png);
        }
        let body = InspectionBody {
            workcell,
            database: version.database.clone(),
            version: version.version,
            digest: version.digest.clone(),
            calibration: calibration.map(|name| name.to_string()),
            header,
            width_px: inspection.segmentation.width(),
            height_px: inspection.segmentation.height(),
            regions_found: inspection.segmentation.found,
            objects: inspection.parts.iter().map(PartBody::from).collect(),
            warnings: inspection.warnings.iter().map(|warning| warning.code()).collect(),
            left_out: (&inspection.segmentation.left_out).into(),
            ground: inspection.segmentation.noise.map(GroundBody::from),
            timings_ms: InspectionTimings::of(queue, &stages),
        };
        Json(body).into_response()
    }
}

impl InspectionTimings {
    fn of(queue: Duration, stages: &StageClock) -> Self {
        let [decode, segment, cut, recognise, design, depth] =
            ["decode", "segment", "cut", "recognise", "design", "depth"].map(|stage| stages.ms(stage));
        let total = segment + cut + recognise + design + depth;
        Self { queue: ms(queue), decode, segment, cut, recognise, design, depth, total }
    }
}

impl From<&Part> for PartBody {
    fn from(part: &Part) -> Self {
        let recognition = &part.recognition;
        let mut warnings: Vec<&'static str> =
            recognition.warnings.iter().map(|warning| warning.code()).collect();
        if part.robot_mm.is_none() {
            warnings.push("beyond_horizon");
        }
        if part.is_in_pair && part.distance.is_none() {
            warnings.push("no_depth");
        }
        let decision = recognition.decision.as_ref();
        Self {
            region: (&part.region).into(),
            robot_mm: part.robot_mm,
            robot_deg: part.robot_deg,
            decision: decision.map(DecisionBody::from),
            candidates: recognition.candidates.iter().map(CandidateBody::from).collect(),
            pose: decision.and_then(|decision| decision.pose).map(PoseBody::from),
            distance_mm: part.distance.map(|distance| distance.distance_mm),
            distance_sigma_mm: part.distance.and_then(|distance| distance.sigma_mm),
            distance_coverage: part.distance.map(|distance| distance.coverage),
            warnings,
        }
    }
}
