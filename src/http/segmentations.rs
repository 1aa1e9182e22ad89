//! `POST /v1/segmentations`: what stands out from the background of a picture, region by region.

use std::time::Duration;

use axum::Json;
use axum::extract::{FromRequest, Request, State};
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::extract::essence;
use super::options::{read_segmentation, read_segmentation_query};
use super::problem::{FieldError, Problem};
use super::regions::{GroundBody, LeftOutBody, RegionBody};
use super::stages::{StageClock, ms};
use super::uploads::{KnownParts, OnePicture, Picture, RobotHeader};
use super::{Service, accept};
use crate::compute::Lane;
use crate::database::FrameHeader;
use crate::database::options::SegmentationOptionsDocument;
use crate::telemetry::Work;
use landmarkd_core::imaging::{self, DecodeLimits, encode};
use landmarkd_core::vision::segmentation::{Segmentation, SegmentationOptions, segmented};
use landmarkd_core::workcell::{Warning, annotate_regions};

/// A picture, and how it is taken apart.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct SegmentationForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
    options: Option<SegmentationOptionsDocument>,
}

/// What stands out from the background.
#[derive(Debug, Serialize, ToSchema)]
pub struct SegmentationBody {
    pub header: FrameHeader,
    pub width_px: usize,
    pub height_px: usize,
    /// Regions of at least the least area, also those beyond `max_objects`.
    pub regions_found: usize,
    /// The largest first.
    pub regions: Vec<RegionBody>,
    /// `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`. `touching`: a region may be several
    /// parts. `large_region`: the largest may be the table itself. `little_ground`: too little of the picture is ground to
    /// be sure of its level. `textured_ground`: parts of little contrast are lost in its texture. `line_left_out`,
    /// `shadows_left_out`, `small_left_out` (nearly as large as the least area): see `left_out`. `perhaps_shadow`: a part's
    /// dark side may be its shadow.
    pub warnings: Vec<String>,
    /// What differs from the ground and is no region.
    #[schema(required = false)]
    pub left_out: LeftOutBody,
    /// What the picture was compared with; null with a threshold for the whole picture.
    pub ground: Option<GroundBody>,
    pub timings_ms: SegmentationTimings,
}

/// How long the parts of a segmentation took, in milliseconds.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub struct SegmentationTimings {
    /// Waiting for a computing thread.
    pub queue: f64,
    pub decode: f64,
    pub segment: f64,
}

impl SegmentationTimings {
    /// The times of finished work.
    pub fn of(queue: Duration, stages: &StageClock) -> Self {
        Self { queue: ms(queue), decode: stages.ms("decode"), segment: stages.ms("segment") }
    }
}

/// The media types of the answer, the preferred one first.
const OFFERED: [&str; 3] = ["application/json", "image/png", PREVIEW];
const PREVIEW: &str = "image/png; preview=regions";

/// What a computing thread makes of a request.
struct Segmented {
    segmentation: Segmentation,
    /// None if JSON is wanted.
    png: Option<Vec<u8>>,
    stages: StageClock,
}

impl Segmented {
    /// Decodes, segments, draws: runs on a computing thread.
    fn of(
        picture: &Picture,
        options: &SegmentationOptions,
        media_type: &str,
        limits: &DecodeLimits,
    ) -> Result<Self, Problem> {
        let mut stages = StageClock::begin();
        let frame = imaging::decode(&picture.bytes, limits)?;
        stages.end("decode");
        let segmentation = segmented(&frame, options);
        stages.end("segment");
        let (width, height) = (segmentation.width(), segmentation.height());
        let png = match media_type {
            "image/png" => Some(encode::png_gray16(width, height, segmentation.labels())),
            PREVIEW => Some(annotate_regions(&frame, &segmentation).into_png()),
            _ => None,
        };
        if png.is_some() {
            stages.end("encode");
        }
        Ok(Self { segmentation, png, stages })
    }

    /// The answer; `queue` is the time that the work waited for a thread.
    fn render(self, header: FrameHeader, queue: Duration) -> Response {
        let Self { segmentation, png, stages } = self;
        let warnings: Vec<String> = Warning::about(&segmentation).into_iter().map(Warning::code).collect();
        if let Some(png) = png {
            let headers = [("content-type", "image/png"), ("x-warnings", &warnings.join(","))];
            return (headers, png).into_response();
        }
        let body = SegmentationBody {
            header,
            width_px: segmentation.width(),
            height_px: segmentation.height(),
            regions_found: segmentation.found,
            regions: segmentation.regions.iter().map(RegionBody::from).collect(),
            warnings,
            left_out: (&segmentation.left_out).into(),
            ground: segmentation.noise.map(GroundBody::from),
            timings_ms: SegmentationTimings::of(queue, &stages),
        };
        Json(body).into_response()
    }
}

/// The picture of a request, and the options in its query or form.
async fn read(request: Request, service: &Service) -> Result<(Picture, SegmentationOptions), Problem> {
    let query = request.uri().query().unwrap_or_default().to_owned();
    let (options, mut faults) = read_segmentation_query(&query);
    if essence(request.headers()).as_deref() != Some("multipart/form-data") {
        if !faults.is_empty() {
            return Err(Problem::fields(faults));
        }
        return Ok((OnePicture::from_request(request, service).await?.checked(&service.decode)?, options));
    }
    let mut parts = KnownParts::of(request, service, &["image"], &["options"], None).await?;
    if parts.holds("options") && !query.is_empty() {
        let detail = "and options in the query exclude each other: give one".into();
        faults.push(FieldError { pointer: "/options".into(), detail });
    }
    let image = parts.require("image");
    let options = match parts.object("options")? {
        Some(body) => {
            let (options, wrong) = read_segmentation("/options", &body);
            faults.extend(wrong);
            options
        }
        None => options,
    };
    faults.extend(parts.faults);
    let (Some(image), []) = (image, faults.as_slice()) else { return Err(Problem::fields(faults)) };
    let picture = Picture::of(image, &service.decode).map_err(|problem| problem.in_part("image"))?;
    Ok((picture.with_share(parts.share), options))
}

/// Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit label image
/// (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes, axes and ids.
/// A picture in which nothing stands out is an answer without regions.
#[utoipa::path(
    post, operation_id = "segment", path = "/v1/segmentations", tag = "workcell", security(("key" = ["recognise"])),
    params(SegmentationOptionsDocument),
    request_body(
        description = "The picture, raw with the options in the query, or as a form",
        content(
            (String = "image/jpeg"), (String = "image/png"), (String = "image/x-portable-graymap"),
            (String = "image/x-portable-pixmap"), (SegmentationForm = "multipart/form-data")
        )
    ),
    responses((
        status = 200, description = "What stands out",
        content(
            (SegmentationBody = "application/json"), (Vec<u8> = "image/png"),
            (Vec<u8> = "image/png; preview=regions")
        ),
        headers(("X-Warnings" = String, description = "Pictures: as `warnings`, with commas between"))
    ))
)]
pub async fn post(
    State(service): State<Service>,
    headers: HeaderMap,
    RobotHeader(header): RobotHeader,
    request: Request,
) -> Result<Response, Problem> {
    let media_type = accept::choose(&headers, &OFFERED)?;
    let (picture, options) = read(request, &service).await?;
    let (limits, memory) = (service.decode, picture.header.segmentation_bytes());
    let work = move || Segmented::of(&picture, &options, media_type, &limits);
    let (segmented, queue) = service.compute.run(Lane::Recognition, memory, work).await?;
    let segmented = segmented?;
    segmented.stages.record(&service.metrics, Work::Workcell, queue);
    Ok(accept::vary(segmented.render(header, queue)))
}
