//! `POST /v1/segmentations`: what stands out from the background of a picture, region by region.

use std::time::Duration;

use axum::Json;
use axum::extract::{FromRequest, Request, State};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use super::extract::essence;
use super::options::SegmentationOptionsBody;
use super::problem::{FieldError, Problem};
use super::recognitions::ms;
use super::regions::{self, RegionBody};
use super::stages::Stages;
use super::uploads::{HeaderEcho, KnownParts, OnePicture, Picture, RobotHeader};
use super::{Service, accept};
use crate::compute::Lane;
use crate::telemetry::Work;
use landmarkd_core::imaging::{self, Frame, encode};
use landmarkd_core::vision::segmentation::{Segmentation, SegmentationOptions, segmented};
use landmarkd_core::workcell::annotate_regions;

/// A picture, and how it is taken apart.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct SegmentationForm {
    /// The picture.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    image: String,
    options: Option<SegmentationOptionsBody>,
}

/// What stands out from the background.
#[derive(Debug, Serialize, ToSchema)]
pub struct SegmentationBody {
    pub header: HeaderEcho,
    pub width_px: usize,
    pub height_px: usize,
    /// Regions of at least the least area, also those beyond `max_objects`.
    pub regions_found: usize,
    /// The largest first.
    pub regions: Vec<RegionBody>,
    /// `no_region`: nothing stands out. `more_regions`: there are more than `max_objects`.
    pub warnings: Vec<&'static str>,
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
    /// Those of finished work.
    pub fn of(queue: Duration, stages: &Stages) -> Self {
        Self { queue: ms(queue), decode: stages.ms("decode"), segment: stages.ms("segment") }
    }
}

/// What the call gives, ours by preference first.
const OFFERED: [&str; 3] = ["application/json", "image/png", PREVIEW];
const PREVIEW: &str = "image/png; preview=regions";

/// The file that was asked for; none for JSON.
fn file(wanted: &str, frame: &Frame, segmentation: &Segmentation) -> Option<Vec<u8>> {
    match wanted {
        "image/png" => {
            let (width, height) = (segmentation.width(), segmentation.height());
            Some(encode::png_gray16(width, height, segmentation.labels()))
        }
        PREVIEW => Some(annotate_regions(frame, segmentation).into_png()),
        _ => None,
    }
}

/// The picture of a request, and the options in its query or form.
async fn asked(request: Request, service: &Service) -> Result<(Picture, SegmentationOptions), Problem> {
    let query = request.uri().query().unwrap_or_default().to_owned();
    let (options, mut faults) = SegmentationOptionsBody::read_query(&query);
    if essence(request.headers()).as_deref() != Some("multipart/form-data") {
        if !faults.is_empty() {
            return Err(Problem::fields(faults));
        }
        return Ok((OnePicture::from_request(request, service).await?.judged(&service.decode)?, options));
    }
    let mut parts = KnownParts::of(request, service, &["image"], &["options"]).await?;
    if parts.holds("options") && !query.is_empty() {
        let detail = "and options in the query exclude each other: give one".into();
        faults.push(FieldError { pointer: "/options".into(), detail });
    }
    let image = parts.require("image");
    let options = match parts.object("options")? {
        Some(body) => {
            let (options, wrong) = SegmentationOptionsBody::read("/options", &body);
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
    params(SegmentationOptionsBody),
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
    let wanted = accept::choose(&headers, &OFFERED)?;
    let (picture, options) = asked(request, &service).await?;
    let (limits, memory) = (service.decode, picture.working_bytes);
    let work = move || {
        let mut stages = Stages::begin();
        let frame = imaging::decode(&picture.bytes, &limits)?;
        stages.end("decode");
        let segmentation = segmented(&frame.luminance, &options);
        stages.end("segment");
        let file = file(wanted, &frame, &segmentation);
        if file.is_some() {
            stages.end("encode");
        }
        Ok::<_, Problem>((segmentation, file, stages))
    };
    let (worked, queue) = service.compute.run(Lane::Recognition, memory, work).await?;
    let (segmentation, file, stages) = worked?;
    stages.count(&service.metrics, Work::Workcell, queue);
    let warnings = regions::warnings(&segmentation);
    let mut response = match file {
        Some(png) => {
            let headers = [("content-type", "image/png"), ("x-warnings", &warnings.join(","))];
            (headers, png).into_response()
        }
        None => Json(SegmentationBody {
            header: header.into(),
            width_px: segmentation.width(),
            height_px: segmentation.height(),
            regions_found: segmentation.found,
            regions: segmentation.regions.iter().map(RegionBody::from).collect(),
            warnings,
            timings_ms: SegmentationTimings::of(queue, &stages),
        })
        .into_response(),
    };
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    Ok(response)
}
