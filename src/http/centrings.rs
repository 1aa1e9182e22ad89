//! `POST /v1/workcells/{name}/centrings`: by how much the camera at the gripper is off the part.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::Service;
use super::access::reach;
use super::exemplars::ImageForm;
use super::extract::Path;
use super::problem::{Code, Problem};
use super::regions::RegionBody;
use super::segmentations::SegmentationTimings;
use super::stages::StageClock;
use super::uploads::{OnePicture, RobotHeader};
use super::workcells::WorkcellPath;
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::FrameHeader;
use crate::telemetry::Work;
use landmarkd_core::imaging;
use landmarkd_core::workcell::centring;

/// By how much the part nearest the picture's middle is off it.
#[derive(Debug, Serialize, ToSchema)]
pub struct CentringBody {
    pub workcell: String,
    pub header: FrameHeader,
    /// The region nearest the middle.
    pub region: RegionBody,
    /// Its centroid less the picture's middle, x and y.
    pub move_px: [f64; 2],
    /// By how much the gripper must move to have it in the middle, X and Y; null while the workcell says nothing of the
    /// local camera.
    pub move_mm: Option<[f64; 2]>,
    /// Whether it is within the workcell's tolerance.
    pub centred: bool,
    /// How far it is off the middle.
    pub distance_px: f64,
    pub timings_ms: SegmentationTimings,
}

/// Look with the camera at the gripper: by how much it is off the part nearest the picture's middle. Move by it, and
/// ask again until `centred`.
#[utoipa::path(
    post, operation_id = "centre",
    path = "/v1/workcells/{name}/centrings", tag = "workcell", security(("key" = ["recognise"])), params(WorkcellPath),
    request_body(
        description = "The picture, raw or as the part `image` of a form",
        content(
            (String = "image/jpeg"), (String = "image/png"), (String = "image/x-portable-graymap"),
            (String = "image/x-portable-pixmap"), (ImageForm = "multipart/form-data")
        )
    ),
    responses((status = 200, body = CentringBody))
)]
pub async fn post(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<WorkcellPath>,
    RobotHeader(header): RobotHeader,
    picture: OnePicture,
) -> Result<Json<CentringBody>, Problem> {
    let kept = service.databases.workcell(&path.name).await?;
    reach(&caller, kept.setup.database.as_str())?;
    let picture = picture.admitted(&service)?;
    let (limits, memory, workcell) =
        (service.decode, picture.header.segmentation_bytes(), kept.setup.workcell);
    let work = move || {
        let mut stages = StageClock::begin();
        let frame = imaging::decode(&picture.bytes, &limits)?;
        stages.end("decode");
        let centring = centring(&frame, &workcell);
        stages.end("segment");
        Ok::<_, Problem>((centring, stages))
    };
    let (worked, queue) = service.compute.run(Lane::Recognition, memory, work).await?;
    let (centring, stages) = worked?;
    stages.record(&service.metrics, Work::Workcell, queue);
    let centring = centring.ok_or_else(|| {
        let text = "nothing stands out from the background: bring a part into view, or change the workcell's \
                    segmentation (POST /v1/segmentations shows what it sees)";
        Problem::new(Code::NoRegion, text)
    })?;
    Ok(Json(CentringBody {
        workcell: kept.name,
        header,
        region: (&centring.region).into(),
        move_px: centring.move_px,
        move_mm: centring.move_mm,
        centred: centring.centred,
        distance_px: centring.distance_px,
        timings_ms: SegmentationTimings::of(queue, &stages),
    }))
}
