//! `POST /v1/workcells/{name}/inspections`: every part on the table, what it is, how it is turned, where to reach.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::access::{Who, reach};
use super::depth_maps::decoded_pair;
use super::extract::{Path, Query};
use super::problem::{Code, FieldError, Problem};
use super::recognitions::{CandidateBody, DecisionBody, PoseBody, drawn, ms};
use super::regions::{self, RegionBody};
use super::stages::Stages;
use super::uploads::{HeaderEcho, KnownParts, Picture, RobotHeader};
use super::workcells::WorkcellPath;
use super::{Service, accept};
use crate::compute::Lane;
use crate::database::{DatabaseError, FrameHeader, Kind, LoadedVersion, Model, Name};
use crate::telemetry::Work;
use landmarkd_core::depth::{Calibration, DepthMap, DepthOptions, FocalPair};
use landmarkd_core::imaging;
use landmarkd_core::recognition::objects::Objects;
use landmarkd_core::vision::segmentation::segmented_from_near;
use landmarkd_core::workcell::{Distance, Inspection, Part, Stage, Workcell, annotate, inspect};

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

/// The table, and with `near` and `far` a focal pair of a part or of the table.
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
    pub header: HeaderEcho,
    pub width_px: usize,
    pub height_px: usize,
    /// Regions of at least the least area, also those beyond `max_objects`.
    pub regions_found: usize,
    /// One for each region, the largest first; also those that are nothing known.
    pub objects: Vec<PartBody>,
    /// `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. `not_segmented`: the version
    /// was trained without `segment`, so that its pictures were made by another recipe than the parts are cut out by.
    /// `no_region_in_pair`: nothing stands out in the near-focused picture. Those of a depth map with `depth_` before.
    pub warnings: Vec<String>,
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

/// The pair of a request.
struct Pair {
    pictures: [Picture; 2],
    calibration: Calibration,
    view: PairViewWord,
    region: Option<usize>,
}

/// What a call asks for.
struct Question {
    overview: Picture,
    workcell: Workcell,
    version: Arc<LoadedVersion>,
    pair: Option<Pair>,
    is_drawn: bool,
}

/// What a computing thread makes of it.
struct Inspected {
    inspection: Inspection,
    /// One for each part.
    distances: Vec<Option<Distance>>,
    /// Whether the distance of each part was looked for.
    is_sought: Vec<bool>,
    warnings: Vec<String>,
    png: Option<Vec<u8>>,
    stages: Stages,
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

/// Decode, inspect, measure, draw: runs on a computing thread.
fn work_on(question: &Question, service: &Service) -> Result<Inspected, Problem> {
    let Question { overview, workcell, version, pair, is_drawn } = question;
    let model = objects(version)?;
    let mut stages = Stages::begin();
    let frame = imaging::decode(&overview.bytes, &service.decode)
        .map_err(|error| Problem::from(error).in_part("overview"))?;
    let decoded = match pair {
        Some(Pair { pictures: [near, far], view, .. }) => {
            let decoded = decoded_pair([near, far], ["near", "far"], &service.decode)?;
            let sizes_px = [(frame.width(), frame.height()), (decoded.width(), decoded.height())];
            if *view == PairViewWord::Overview && sizes_px[0] != sizes_px[1] {
                return Err(other_size(sizes_px));
            }
            Some(decoded)
        }
        None => None,
    };
    stages.end("decode");
    let inspection = inspect(&frame, workcell, model, |stage| {
        stages.end(match stage {
            Stage::Segment => "segment",
            Stage::Cut => "cut",
            Stage::Recognise => "recognise",
        });
    });
    let mut warnings: Vec<String> =
        regions::warnings(&inspection.segmentation).into_iter().map(str::to_owned).collect();
    if !model.options().segment {
        warnings.push("not_segmented".into());
    }
    let mut inspected = Inspected {
        distances: vec![None; inspection.parts.len()],
        is_sought: vec![false; inspection.parts.len()],
        inspection,
        warnings,
        png: None,
        stages,
    };
    if let (Some(pair), Some(decoded)) = (pair, &decoded) {
        inspected.measure(pair, decoded, workcell, service)?;
    }
    if *is_drawn {
        let drawing = annotate(&frame, &inspected.inspection, &inspected.distances);
        inspected.png = Some(drawing.into_png());
        inspected.stages.end("encode");
    }
    Ok(inspected)
}

impl Inspected {
    /// Measure the distances of the parts that the pair shows.
    fn measure(
        &mut self,
        pair: &Pair,
        decoded: &FocalPair,
        workcell: &Workcell,
        service: &Service,
    ) -> Result<(), Problem> {
        let segmentation = &self.inspection.segmentation;
        let one = match (pair.region, pair.view) {
            (Some(id), _) => {
                Some(segmentation.region(id).ok_or_else(|| no_such_region(id, segmentation.regions.len()))?)
            }
            (None, PairViewWord::Local) => segmentation.central(),
            (None, PairViewWord::Overview) => None,
        };
        if segmentation.regions.is_empty() {
            return Ok(());
        }
        // What a sweep was made with measures best.
        let mut options = DepthOptions::default();
        if let Some(filters) = &pair.calibration.filters {
            options.method = filters.method;
        }
        let estimator = service.estimators.ready(&pair.calibration, &options)?;
        self.stages.end("design");
        let map = estimator.estimate(decoded, &mut |_| ())?;
        match one {
            None => {
                let of_all =
                    segmentation.regions.iter().map(|region| Distance::of(region, segmentation, &map));
                self.distances = of_all.collect();
                self.is_sought.fill(true);
            }
            Some(region) => match local_distance(decoded, workcell, &map) {
                Some(distance) => {
                    self.distances[region.id - 1] = distance;
                    self.is_sought[region.id - 1] = true;
                }
                None => self.warnings.push("no_region_in_pair".into()),
            },
        }
        self.warnings.extend(map.summary.warnings.iter().map(|warning| format!("depth_{}", warning.word())));
        self.stages.end("depth");
        Ok(())
    }
}

/// The distance of the part in the middle of the near-focused picture; none without a part.
fn local_distance(pair: &FocalPair, workcell: &Workcell, map: &DepthMap) -> Option<Option<Distance>> {
    let seen = segmented_from_near(pair.near(), &workcell.segmentation);
    Some(Distance::of(seen.central()?, &seen, map))
}

fn other_size([overview, pair]: [(usize, usize); 2]) -> Problem {
    let text = format!(
        "the pair has {}×{} px and the overview {}×{}: with pair_view=overview both have one size; without it the pair \
         is the local camera's view of one part",
        pair.0, pair.1, overview.0, overview.1
    );
    Problem::new(Code::ImageSizeMismatch, text).in_part("near")
}

fn no_such_region(id: usize, regions: usize) -> Problem {
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
    let (near, far) = (parts.holds("near"), parts.holds("far"));
    for (missing, is_missing) in [("/near", far && !near), ("/far", near && !far)] {
        if is_missing {
            fault(missing, "is missing: near and far come together");
        }
    }
    if (near || far) && !has_calibration {
        fault(
            "/near",
            "needs a calibration: PUT the workcell with the name of one, or leave near and far out",
        );
    }
    let is_overview = query.pair_view == Some(PairViewWord::Overview);
    if query.pair_view.is_some() && !near && !far {
        fault("#pair_view", "is about a pair: send near and far, or leave it out");
    }
    if query.region.is_some() && !near && !far {
        fault("#region", "says what a pair shows: send near and far, or leave it out");
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
    who: Who,
    Path(path): Path<WorkcellPath>,
    Query(query): Query<InspectionQuery>,
    headers: HeaderMap,
    RobotHeader(header): RobotHeader,
    request: Request,
) -> Result<Response, Problem> {
    let is_drawn = accept::choose(&headers, &["application/json", "image/png"])? == "image/png";
    let mut response = service.inspection(&who, &path.name, &query, is_drawn, header, request).await?;
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}

impl Service {
    async fn inspection(
        &self,
        who: &Who,
        name: &Name,
        query: &InspectionQuery,
        is_drawn: bool,
        header: FrameHeader,
        request: Request,
    ) -> Result<Response, Problem> {
        let kept = self.databases.workcell(name).await?;
        let setup = kept.setup;
        reach(&who.caller, setup.database.as_str())?;
        let version = self.version_for(&setup.database, query.version, query.alias.as_ref()).await?;
        let mut parts = KnownParts::of(request, self, &["overview", "near", "far"], &[]).await?;
        let wrong = pair_faults(&parts, query, setup.calibration.is_some());
        let overview = parts.require("overview");
        parts.faults.extend(wrong);
        let (Some(overview), []) = (overview, parts.faults.as_slice()) else {
            return Err(Problem::fields(parts.faults));
        };
        let in_part = |name: &'static str| move |problem: Problem| problem.in_part(name);
        let overview = Picture::of(overview, &self.decode).map_err(in_part("overview"))?;
        let mut memory = overview.working_bytes;
        let sent = (parts.take("near"), parts.take("far"), &setup.calibration);
        let pair = match sent {
            (Some(near), Some(far), Some(calibration)) => {
                let calibration = self.databases.rig(calibration).await?.calibration;
                let judged = |bytes, name| {
                    Picture::of(bytes, &self.decode).and_then(Picture::for_depth).map_err(in_part(name))
                };
                let pictures = [judged(near, "near")?, judged(far, "far")?];
                memory += pictures.iter().map(|picture| picture.depth_bytes).sum::<u64>();
                let view = query.pair_view.unwrap_or_default();
                Some(Pair { pictures, calibration, view, region: query.region })
            }
            _ => None,
        };
        let calibration = setup.calibration.filter(|_| pair.is_some());
        let question =
            Question { overview, workcell: setup.workcell, version: Arc::clone(&version), pair, is_drawn };
        let (service, share) = (self.clone(), parts.share);
        let work = move || {
            let _share = share;
            work_on(&question, &service)
        };
        let (inspected, queue) = self.compute.run(Lane::Recognition, memory, work).await?;
        let mut inspected = inspected?;
        inspected.stages.count(&self.metrics, Work::Workcell, queue);
        if let Some(png) = inspected.png.take() {
            return Ok(drawn(&version, png));
        }
        let Inspected { inspection, distances, is_sought, warnings, stages, .. } = inspected;
        let [segment, cut, recognise, design, depth] =
            ["segment", "cut", "recognise", "design", "depth"].map(|stage| stages.ms(stage));
        let parts = inspection.parts.iter().zip(distances).zip(is_sought);
        let body = InspectionBody {
            workcell: kept.name,
            database: version.database.clone(),
            version: version.version,
            digest: version.digest.clone(),
            calibration: calibration.map(|name| name.to_string()),
            header: header.into(),
            width_px: inspection.segmentation.width(),
            height_px: inspection.segmentation.height(),
            regions_found: inspection.segmentation.found,
            objects: parts.map(|((part, distance), sought)| PartBody::new(part, distance, sought)).collect(),
            warnings,
            timings_ms: InspectionTimings {
                queue: ms(queue),
                decode: stages.ms("decode"),
                segment,
                cut,
                recognise,
                design,
                depth,
                total: segment + cut + recognise + design + depth,
            },
        };
        Ok(Json(body).into_response())
    }
}

impl PartBody {
    /// A part with its distance, if that was looked for and found.
    fn new(part: &Part, distance: Option<Distance>, is_sought: bool) -> Self {
        let recognition = &part.recognition;
        let mut warnings: Vec<&'static str> =
            recognition.warnings.iter().map(|warning| warning.code()).collect();
        if part.robot_mm.is_none() {
            warnings.push("beyond_horizon");
        }
        if is_sought && distance.is_none() {
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
            distance_mm: distance.map(|distance| distance.distance_mm),
            distance_sigma_mm: distance.and_then(|distance| distance.sigma_mm),
            distance_coverage: distance.map(|distance| distance.coverage),
            warnings,
        }
    }
}
