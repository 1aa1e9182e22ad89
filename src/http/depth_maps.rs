//! `POST /v1/depth-maps`: how far away everything is, from two pictures that differ in focus or in aperture.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::body::BodyShare;
use super::extract::Query;
use super::optics::{Lens, OpticsBody, rounded_mm};
use super::options::{DepthOptionsBody, WindowBody};
use super::pairs::{PAIR_PARTS, PairParts, PairPictures, depth_picture};
use super::problem::{Code, FieldError, Problem};
use super::stages::{StageClock, ms};
use super::uploads::{KnownParts, MAX_DEPTH_BYTES, PartList, Picture, RobotHeader};
use super::{Service, accept};
use crate::compute::Lane;
use crate::database::{DepthMethodWord, FrameHeader, Name};
use crate::telemetry::Work;
use landmarkd_core::depth::{
    BlurScale, Calibration, DepthMap, DepthOptions, Estimator, Flag, FocalPair, FocusStack, Optics,
    STACK_PICTURES, StackEstimator, StackOptics, Stage, Summary, blur_scale,
};
use landmarkd_core::imaging::{self, DecodeLimits, encode, false_colour, npy, ply};

/// Which planes an array has.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct PlanesQuery {
    /// For `application/x-npy`: `depth` (mm, NaN = unknown), `sigma` (its expected standard deviation in mm), `flags`
    /// (bits), with commas between them. One plane is an array H×W, several are n×H×W in the order given.
    #[param(default = "depth", example = "depth,sigma,flags")]
    pub planes: Option<String>,
}

/// A near- and a far-focused picture, or a wide-open and a stopped-down one, and what the lens is. Either `optics` or
/// `calibration`.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct DepthForm {
    /// The near-focused picture; with `far`.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    near: Option<String>,
    /// The far-focused picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    far: Option<String>,
    /// The picture of the wider aperture, in place of a focal pair; with `narrow`.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    wide: Option<String>,
    /// The picture of the narrower aperture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    narrow: Option<String>,
    /// The pictures of a focus stack, in place of a pair: the part comes as often as the optics have focus settings, in their
    /// order.
    #[schema(value_type = Option<Vec<String>>, format = Binary, content_media_type = "application/octet-stream")]
    stack: Option<Vec<String>>,
    optics: Option<OpticsBody>,
    /// Name of a calibration.
    #[schema(pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    calibration: Option<String>,
    options: Option<DepthOptionsBody>,
}

/// How far away everything is, in short.
#[derive(Debug, Serialize, ToSchema)]
pub struct DepthMapBody {
    pub header: FrameHeader,
    pub method: DepthMethodWord,
    pub window: WindowBody,
    /// The calibration that was used; null when the form had the optics.
    pub calibration: Option<String>,
    pub width_px: usize,
    pub height_px: usize,
    /// The distance that the near-focused picture is focused at, of a stack its first; of an aperture pair, the near end of
    /// the working range.
    pub near_focus_mm: f64,
    /// The distance that the far-focused picture is focused at, of a stack its last; of an aperture pair, the far end of the
    /// working range.
    pub far_focus_mm: f64,
    /// From the one to the other: the working range.
    pub range_mm: f64,
    /// The largest blur within the working range.
    pub largest_blur_px: f64,
    /// The blur that was measured from the pictures; absent when the optics said it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub blur_scale: Option<BlurScaleBody>,
    /// Part of the pixels that have a depth.
    pub coverage: f64,
    /// Null when no pixel has a depth.
    pub depth_mm: Option<DepthSpanBody>,
    /// Noise of a picture in grey levels of 255, as the method sees it; null if it can't.
    pub noise_sigma: Option<f64>,
    /// By how much the far-focused picture was displaced; it was moved back. Of an aperture pair: one of the two. Of a stack:
    /// the picture that was farthest off.
    pub shift_px: [f64; 2],
    /// What the far-focused picture was multiplied by. Of an aperture pair: one of the two. Of a stack: the picture that was
    /// farthest off the one before it.
    pub gain: f64,
    /// Pixels without a depth, by the reason: `low_texture`, `saturated`, `out_of_range`, `inconsistent`, `border`,
    /// `ambiguous`.
    #[schema(value_type = BTreeMap<String, u64>)]
    pub flags: BTreeMap<&'static str, u64>,
    /// Reasons to doubt the whole. Mended: `shifted`, `scaled`, `rotated`, `gain_off`, `contrast_off`. Not mended:
    /// `shift_unknown`, `moved`, `misregistered`, `many_inconsistent`, `low_coverage`, `near_far_swapped`, `sweep_failed`
    /// (the calibration's newest sweep failed: what was measured before it answers), `scale_estimated` (the aperture was
    /// measured from these pictures: see `blur_scale`; all distances share its error).
    pub warnings: Vec<&'static str>,
    pub timings_ms: DepthTimings,
}

/// An aperture that was measured from the pictures.
#[derive(Debug, Serialize, ToSchema)]
pub struct BlurScaleBody {
    /// For the pixel pitch of the optics.
    pub aperture_mm: f64,
    /// The largest blur within the working range.
    pub largest_blur_px: f64,
    /// Its standard deviation.
    pub sigma_px: f64,
}

/// Depths of the pixels that have one.
#[derive(Debug, Serialize, ToSchema)]
pub struct DepthSpanBody {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

/// How long the parts of a depth map took, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct DepthTimings {
    /// Waiting for a computing thread.
    pub queue: f64,
    /// Making filters ready; next to nothing when the same optics and options were used lately. Those of a focus stack are
    /// made for each call.
    pub design: f64,
    pub decode: f64,
    /// All that follows decoding: the sum of the four below.
    pub total: f64,
    /// Scale and shift.
    pub register: f64,
    /// Brightness, and halving.
    pub r#match: f64,
    /// Filters and windows.
    pub estimate: f64,
    /// Choice of windows, lens law, flags.
    pub judge: f64,
}

/// A plane of an array.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Plane {
    Depth,
    Sigma,
    Flags,
}

impl Plane {
    fn values(self, map: &DepthMap) -> Box<dyn Iterator<Item = f32> + '_> {
        match self {
            Self::Depth => Box::new(map.depth_mm().iter().copied()),
            Self::Sigma => Box::new(map.sigma_mm().iter().copied()),
            Self::Flags => Box::new(map.flags().iter().map(|&bits| f32::from(bits))),
        }
    }
}

impl PlanesQuery {
    fn planes(&self) -> Result<Vec<Plane>, Problem> {
        let wrong = |what: String| {
            Problem::field(
                "#planes",
                format!("{what}: give depth, sigma, flags, or several with commas between"),
            )
        };
        let mut planes = Vec::new();
        for word in self.planes.as_deref().unwrap_or("depth").split(',') {
            let plane = match word {
                "depth" => Plane::Depth,
                "sigma" => Plane::Sigma,
                "flags" => Plane::Flags,
                other => return Err(wrong(format!("{other:?} is no plane"))),
            };
            if planes.contains(&plane) {
                return Err(wrong(format!("{word:?} is named twice")));
            }
            planes.push(plane);
        }
        Ok(planes)
    }
}

/// The media types that the call gives, the default first.
const OFFERED: [&str; 5] =
    ["application/json", "image/png", "application/x-npy", "model/ply", "image/png; preview=turbo"];

/// How a depth map is written.
enum Form {
    Summary,
    Png,
    Npy(Vec<Plane>),
    Ply,
    Preview,
}

/// A depth map as bytes.
struct File {
    media_type: &'static str,
    bytes: Vec<u8>,
    /// Of a 16-bit picture: mm a grey level.
    step_mm: Option<f64>,
}

impl Form {
    fn wanted(headers: &HeaderMap, query: &PlanesQuery) -> Result<Self, Problem> {
        let planes = query.planes()?;
        Ok(match accept::choose(headers, &OFFERED)? {
            "image/png" => Self::Png,
            "application/x-npy" => Self::Npy(planes),
            "model/ply" => Self::Ply,
            "image/png; preview=turbo" => Self::Preview,
            _ => Self::Summary,
        })
    }

    /// The file; none for the summary.
    fn write(&self, map: &DepthMap, pair: &FocalPair) -> Option<File> {
        let (width, height) = (map.width(), map.height());
        let file = |media_type, bytes| Some(File { media_type, bytes, step_mm: None });
        match self {
            Self::Summary => None,
            Self::Png => {
                let (bytes, step_mm) = encode::png_distances(width, height, map.depth_mm());
                Some(File { media_type: "image/png", bytes, step_mm: Some(step_mm) })
            }
            Self::Npy(planes) => {
                let shape = [planes.len(), height, width];
                let shape = if planes.len() == 1 { &shape[1..] } else { &shape[..] };
                let values = planes.iter().flat_map(|plane| plane.values(map));
                file("application/x-npy", npy::npy_f32(shape, values))
            }
            Self::Ply => {
                let levels = pair.near().pixels();
                let points = map.points_mm().map(|(at, point_mm)| (point_mm, levels[at]));
                file("model/ply", ply::ply_points(points))
            }
            Self::Preview => file("image/png", false_colour::png_turbo(width, height, map.depth_mm())),
        }
    }
}

/// The pictures to measure, and how.
struct Question {
    pictures: Pictures,
    options: DepthOptions,
    form: Form,
}

/// Pictures, and what they were taken with.
enum Pictures {
    Pair {
        pictures: PairPictures,
        calibration: Box<Calibration>,
        /// Else the blur is measured from the pictures first.
        aperture_known: bool,
    },
    Stack {
        pictures: Vec<Picture>,
        optics: StackOptics,
    },
}

impl Pictures {
    /// Memory that they take while they are measured.
    fn depth_bytes(&self) -> u64 {
        match self {
            Self::Pair { pictures, .. } => pictures.depth_bytes(),
            Self::Stack { pictures, .. } => pictures.iter().map(|picture| picture.depth_bytes).sum(),
        }
    }
}

/// The answer of a computing thread to a question.
struct Measured {
    largest_blur_px: f64,
    blur_scale: Option<BlurScale>,
    summary: Summary,
    size_px: (usize, usize),
    file: Option<File>,
    clock: StageClock,
}

/// Decode, measure, write: runs on a computing thread.
fn measure(question: &Question, service: &Service) -> Result<Measured, Problem> {
    let Question { pictures, options, form } = question;
    match pictures {
        Pictures::Pair { pictures, calibration, aperture_known } => {
            measure_pair(pictures, calibration, *aperture_known, options, form, service)
        }
        Pictures::Stack { pictures, optics } => measure_stack(pictures, optics, options, form, service),
    }
}

fn measure_pair(
    pictures: &PairPictures,
    calibration: &Calibration,
    aperture_known: bool,
    options: &DepthOptions,
    form: &Form,
    service: &Service,
) -> Result<Measured, Problem> {
    let mut clock = StageClock::begin();
    let pair = pictures.decoded(&service.decode)?;
    clock.end("decode");
    let blur_scale = match aperture_known {
        true => None,
        false => Some(blur_scale(&calibration.optics, &pair)?),
    };
    let estimator = match blur_scale {
        None => service.estimators.ready(calibration, options)?,
        // Of this pair alone: not worth keeping.
        Some(BlurScale { optics, .. }) => Arc::new(Estimator::new(&Calibration::of(optics), options)?),
    };
    clock.end("design");
    let map = estimator.estimate(&pair, &mut |stage| clock.end(stage_word(stage)))?;
    let (map, optics) = match &blur_scale {
        None => (map, calibration.optics),
        Some(scale) => (map.with_error_of(scale), scale.optics),
    };
    Ok(Measured::of(map, &pair, optics.largest_blur_px(), blur_scale, form, clock))
}

fn measure_stack(
    pictures: &[Picture],
    optics: &StackOptics,
    options: &DepthOptions,
    form: &Form,
    service: &Service,
) -> Result<Measured, Problem> {
    let mut clock = StageClock::begin();
    let frames = pictures.iter().enumerate().map(|(at, picture)| {
        imaging::decode(&picture.bytes, &service.decode)
            .map_err(|error| Problem::from(error).in_part(&stack_part(at)))
    });
    let bits = pictures.iter().map(|picture| picture.bits).min().unwrap_or(8);
    let stack = FocusStack::new(frames.collect::<Result<_, _>>()?, bits)
        .map_err(|(at, error)| Problem::from(error).in_part(&stack_part(at)))?;
    clock.end("decode");
    let estimator = StackEstimator::new(optics, options)?;
    clock.end("design");
    let map = estimator.estimate(&stack, &mut |stage| clock.end(stage_word(stage)));
    let largest_blur_px = optics.pairs().iter().map(Optics::largest_blur_px).fold(0.0, f64::max);
    Ok(Measured::of(map, stack.first_pair(), largest_blur_px, None, form, clock))
}

fn stack_part(at: usize) -> String {
    format!("stack/{at}")
}

fn stage_word(stage: Stage) -> &'static str {
    match stage {
        Stage::Register => "register",
        Stage::Match => "match",
        Stage::Estimate => "estimate",
        Stage::Map => "judge",
    }
}

impl Measured {
    /// Writes the file that was asked for.
    fn of(
        map: DepthMap,
        pair: &FocalPair,
        largest_blur_px: f64,
        blur_scale: Option<BlurScale>,
        form: &Form,
        mut clock: StageClock,
    ) -> Self {
        let file = form.write(&map, pair);
        if file.is_some() {
            clock.end("encode");
        }
        let size_px = (map.width(), map.height());
        Self { largest_blur_px, blur_scale, size_px, summary: map.summary, file, clock }
    }
}

/// The distance of everything from two pictures that differ in focus or in aperture. `Accept` chooses the form: a summary; a 16-bit
/// PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in metres; or, for
/// people, a picture in false colours (near is red). Pictures must be linear in light.
#[utoipa::path(
    post, operation_id = "measure_depth", path = "/v1/depth-maps", tag = "depth", security(("key" = ["recognise"])), params(PlanesQuery),
    request_body(content = DepthForm, content_type = "multipart/form-data"),
    responses((
        status = 200, description = "The depth map",
        content(
            (DepthMapBody = "application/json"), (Vec<u8> = "image/png"), (Vec<u8> = "application/x-npy"),
            (Vec<u8> = "model/ply"), (Vec<u8> = "image/png; preview=turbo")
        ),
        headers(
            ("X-Depth-Scale-Mm" = f64, description = "16-bit PNG: mm a grey level"),
            ("X-Near-Focus-Mm" = f64, description = "Files: as `near_focus_mm`"),
            ("X-Far-Focus-Mm" = f64, description = "Files: as `far_focus_mm`"),
            ("X-Coverage" = f64, description = "Files: as `coverage`"),
            ("X-Warnings" = String, description = "Files: as `warnings`, with commas between"),
        )
    ))
)]
pub async fn post(
    State(service): State<Service>,
    query: Result<Query<PlanesQuery>, Problem>,
    headers: HeaderMap,
    robot: Result<RobotHeader, Problem>,
    request: Request,
) -> Response {
    let asked = async {
        let form = Form::wanted(&headers, &query?.0)?;
        depth_map(&service, form, robot?.0, request).await
    };
    // Problems depend on `Accept` too: what is acceptable does.
    accept::vary(asked.await.unwrap_or_else(Problem::into_response))
}

/// A request as a question, with the name of the calibration that it names and the room of its body.
struct Asked {
    question: Question,
    calibration: Option<String>,
    /// Whether a sweep of that calibration has failed since.
    sweep_failed: bool,
    share: BodyShare,
}

impl Asked {
    async fn read(service: &Service, form: Form, request: Request) -> Result<Self, Problem> {
        let texts = ["optics", "calibration", "options"];
        let list = PartList { name: "stack", most: *STACK_PICTURES.end() };
        let mut parts = KnownParts::of(request, service, &PAIR_PARTS, &texts, Some(list)).await?;
        let options = parts.object("options")?.unwrap_or_default();
        let (options, faults) = DepthOptionsBody::read(&options);
        parts.faults.extend(faults);
        let rig = match rig(&mut parts)? {
            Some(RigPart::Stack(optics)) => {
                let pictures = stack_pictures(&mut parts, &optics, &service.decode)?;
                let question =
                    Question { pictures: Pictures::Stack { pictures, optics: *optics }, options, form };
                return Ok(Self { question, calibration: None, sweep_failed: false, share: parts.share });
            }
            Some(RigPart::Pair(rig)) => Some(rig),
            // The optics of a stack that can't be: its pictures are no wrong pair.
            None if !parts.list.is_empty() => return Err(Problem::fields(parts.faults)),
            None => None,
        };
        if !parts.list.is_empty() {
            let detail = "is of a focus stack: it needs optics with focuses_mm or planes_mm".into();
            parts.faults.push(FieldError { pointer: "/stack".into(), detail });
        }
        let pair = PairParts::take(&mut parts);
        let (Some(pair), Some(rig), []) = (pair, rig, parts.faults.as_slice()) else {
            return Err(Problem::fields(parts.faults));
        };
        let mut aperture_known = true;
        let (name, calibration, sweep_failed) = match rig {
            PairRig::Known(optics) => (None, Calibration::of(optics), false),
            PairRig::Open(optics) => {
                aperture_known = false;
                (None, Calibration::of(optics), false)
            }
            PairRig::Named(name) => {
                let kept = service.databases.rig(&name).await?;
                let sweep_failed = service.databases.failed_sweep(&kept).await?.is_some();
                (Some(kept.name), kept.calibration, sweep_failed)
            }
        };
        let pictures = pair.pictures(&calibration.optics, &service.decode)?;
        let pictures = Pictures::Pair { pictures, calibration: Box::new(calibration), aperture_known };
        let question = Question { pictures, options, form };
        Ok(Self { question, calibration: name, sweep_failed, share: parts.share })
    }
}

/// Most memory that the pictures of a stack may take together: that of the largest pair.
const MAX_STACK_BYTES: u64 = 2 * MAX_DEPTH_BYTES;

/// The pictures of a focus stack.
///
/// # Errors
/// Everything that is wrong with the form; the first that is no picture for depth; or that all together are too large.
fn stack_pictures(
    parts: &mut KnownParts,
    optics: &StackOptics,
    limits: &DecodeLimits,
) -> Result<Vec<Picture>, Problem> {
    let (sent, wanted) = (std::mem::take(&mut parts.list), optics.pairs().len() + 1);
    if sent.len() != wanted {
        let detail = format!(
            "comes {} times, and the optics have {wanted} focus settings: send a picture of each",
            sent.len()
        );
        parts.faults.push(FieldError { pointer: "/stack".into(), detail });
    }
    for name in PAIR_PARTS {
        if parts.take(name).is_some() {
            let detail = "is no part of a focus stack: its pictures are parts called stack".into();
            parts.faults.push(FieldError { pointer: format!("/{name}"), detail });
        }
    }
    if !parts.faults.is_empty() {
        return Err(Problem::fields(std::mem::take(&mut parts.faults)));
    }
    let pictures = sent.into_iter().enumerate();
    let pictures = pictures.map(|(at, bytes)| depth_picture(&stack_part(at), bytes, limits));
    let pictures = pictures.collect::<Result<Vec<Picture>, Problem>>()?;
    let depth_bytes: u64 = pictures.iter().map(|picture| picture.depth_bytes).sum();
    if depth_bytes > MAX_STACK_BYTES {
        let text = format!(
            "measuring depth in these pictures takes {} MiB, more than the {} that are allowed: send fewer, or smaller ones",
            depth_bytes >> 20,
            MAX_STACK_BYTES >> 20
        );
        return Err(Problem::new(Code::ImageTooLarge, text).in_part("stack"));
    }
    Ok(pictures)
}

async fn depth_map(
    service: &Service,
    form: Form,
    robot: FrameHeader,
    request: Request,
) -> Result<Response, Problem> {
    let Asked { question, calibration, sweep_failed, share } = Asked::read(service, form, request).await?;
    let memory = question.pictures.depth_bytes();
    let options = question.options;
    let held = service.clone();
    let work = move || {
        let _share = share;
        measure(&question, &held)
    };
    let (measured, queue) = service.compute.run(Lane::Recognition, memory, work).await?;
    let Measured { largest_blur_px, blur_scale, summary, size_px: (width_px, height_px), file, clock } =
        measured?;
    clock.record(&service.metrics, Work::Depth, queue);
    let mut warnings: Vec<&'static str> = summary.warnings.iter().map(|warning| warning.word()).collect();
    if sweep_failed {
        warnings.push("sweep_failed");
    }
    if blur_scale.is_some() {
        warnings.push("scale_estimated");
    }
    if let Some(file) = file {
        return Ok(file.into_response(&summary, &warnings));
    }
    Ok(Json(DepthMapBody {
        header: robot,
        method: options.method.into(),
        window: options.window.into(),
        calibration,
        width_px,
        height_px,
        near_focus_mm: rounded_mm(summary.near_focus_mm),
        far_focus_mm: rounded_mm(summary.far_focus_mm),
        range_mm: rounded_mm(summary.far_focus_mm - summary.near_focus_mm),
        largest_blur_px,
        blur_scale: blur_scale.map(BlurScaleBody::from),
        coverage: summary.coverage,
        depth_mm: summary.depth.map(|depth| DepthSpanBody {
            min: depth.min,
            median: depth.median,
            max: depth.max,
        }),
        noise_sigma: summary.noise_sigma,
        shift_px: summary.shift_px,
        gain: summary.gain,
        flags: Flag::ALL.iter().map(|flag| flag.word()).zip(summary.flag_counts).collect(),
        warnings,
        timings_ms: DepthTimings::of(queue, &clock),
    })
    .into_response())
}

impl From<BlurScale> for BlurScaleBody {
    fn from(scale: BlurScale) -> Self {
        let [aperture_mm, _] = scale.optics.apertures_mm();
        Self { aperture_mm, largest_blur_px: scale.optics.largest_blur_px(), sigma_px: scale.sigma_px }
    }
}

impl DepthTimings {
    fn of(queue: Duration, clock: &StageClock) -> Self {
        let [register, r#match, estimate, judge] =
            ["register", "match", "estimate", "judge"].map(|stage| clock.ms(stage));
        Self {
            queue: ms(queue),
            design: clock.ms("design"),
            decode: clock.ms("decode"),
            total: register + r#match + estimate + judge,
            register,
            r#match,
            estimate,
            judge,
        }
    }
}

/// The lens, as a form describes it or names its calibration.
enum RigPart {
    Pair(PairRig),
    Stack(Box<StackOptics>),
}

/// The lens of two pictures.
enum PairRig {
    Known(Optics),
    /// By an aperture that isn't known.
    Open(Optics),
    Named(Name),
}

/// The optics or the calibration's name; a fault if there are both, none, or wrong ones.
fn rig(parts: &mut KnownParts) -> Result<Option<RigPart>, Problem> {
    let sent = ["optics", "calibration"].map(|name| parts.holds(name));
    let (optics, name) = (parts.object("optics")?, parts.take("calibration"));
    let mut fault = |pointer: &str, detail: String| {
        parts.faults.push(FieldError { pointer: pointer.into(), detail });
        None
    };
    Ok(match (sent, optics, name) {
        ([false, false], ..) => fault(
            "/optics",
            "is missing: send a part called optics (JSON), or one called calibration (a name)".into(),
        ),
        ([true, true], ..) => {
            fault("/optics", "and calibration exclude each other: send one".into());
            fault("/calibration", "and optics exclude each other: send one".into())
        }
        (_, Some(optics), _) => match OpticsBody::read_lens("/optics", &optics) {
            Ok(Lens::Pair(optics)) => Some(RigPart::Pair(PairRig::Known(optics))),
            Ok(Lens::OpenPair(optics)) => Some(RigPart::Pair(PairRig::Open(optics))),
            Ok(Lens::Stack(optics)) => Some(RigPart::Stack(Box::new(optics))),
            Err(faults) => {
                parts.faults.extend(faults);
                None
            }
        },
        (_, None, Some(name)) => {
            let text = String::from_utf8_lossy(&name);
            match Name::parse(text.trim()) {
                Ok(name) => Some(RigPart::Pair(PairRig::Named(name))),
                Err(error) => fault("/calibration", format!("{text:?} {error}")),
            }
        }
        // A part that holds something else than an object: it is named already.
        (_, None, None) => None,
    })
}

impl File {
    /// The file, with the parts of the summary that qualify it, and the warnings, in headers.
    fn into_response(self, summary: &Summary, warnings: &[&str]) -> Response {
        let fields = [
            ("x-near-focus-mm", rounded_mm(summary.near_focus_mm).to_string()),
            ("x-far-focus-mm", rounded_mm(summary.far_focus_mm).to_string()),
            ("x-coverage", summary.coverage.to_string()),
            ("x-warnings", warnings.join(",")),
        ];
        let step = self.step_mm.map(|mm| ("x-depth-scale-mm", mm.to_string()));
        let mut response = ([(header::CONTENT_TYPE, self.media_type)], self.bytes).into_response();
        for (name, value) in fields.into_iter().chain(step) {
            let value = HeaderValue::try_from(value).expect("numbers and words are ASCII");
            response.headers_mut().insert(HeaderName::from_static(name), value);
        }
        response
    }
}
