//! `/v1/workcells[/{name}]`: a table, the cameras above it, and the robot that reaches onto it.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};

use super::Service;
use super::access::{Who, reach};
use super::extract::{Json as JsonIn, Path, Query};
use super::keys::for_all;
use super::options::{SegmentationOptionsBody, readable, words};
use super::pages::{self, Page, PageQuery};
use super::problem::{FieldError, Problem};
use crate::database::{DatabaseError, KeptWorkcell, Name, WorkcellSetup};
use landmarkd_core::workcell::{self, Correspondence, LocalCamera, Mapping, MappingError, Workcell};

words!(
    /// What a mapping keeps: shapes (turned, scaled and moved); parallels; straight lines (a camera that looks aslant).
    MappingKindWord, workcell::MappingKind, { Similarity, Affine, Homography }
);

/// The workcell that a call is about.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WorkcellPath {
    /// Name of the workcell.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub name: Name,
}

/// A pixel of the overview camera and the place on the table that it shows.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrespondenceBody {
    /// x and y.
    pub image_px: [f64; 2],
    /// X and Y.
    pub robot_mm: [f64; 2],
}

/// The camera at the gripper.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LocalCameraBody {
    /// Scale on the table.
    #[schema(exclusive_minimum = 0, maximum = 1e6)]
    pub mm_per_px: f64,
    /// Direction of the image's x axis in the robot's plane, from X towards Y.
    #[serde(default)]
    #[schema(minimum = -360, maximum = 360)]
    pub rotation_deg: f64,
}

/// What is known of a workcell.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PutWorkcell {
    /// The database that names the parts, of kind `objects`.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Option<Name>,
    /// The rig that measures distances, for inspections with a focal pair.
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub calibration: Option<Name>,
    /// What the mapping is fitted to: two at the least for a similarity, three for an affine map, four for a
    /// homography; more even out their errors.
    #[schema(value_type = Vec<CorrespondenceBody>, min_items = 2, max_items = 100)]
    pub correspondences: Option<Vec<CorrespondenceBody>>,
    /// By default affine from three correspondences on, else a similarity.
    #[schema(required = false)]
    pub mapping: Option<MappingKindWord>,
    /// Whether the robot's Y grows where the image's y falls, as seen by both cameras.
    #[schema(default = true)]
    pub flip_y: Option<bool>,
    /// The camera at the gripper: without it centrings are told in pixels alone.
    #[schema(required = false)]
    pub local: Option<LocalCameraBody>,
    /// A part counts as centred within so many pixels.
    #[schema(minimum = 0, maximum = 1000, default = 1)]
    pub tolerance_px: Option<f64>,
    /// Of both cameras' pictures.
    #[schema(value_type = Option<SegmentationOptionsBody>)]
    pub segmentation: Option<Map<String, Value>>,
}

/// Most correspondences of a workcell: a calibration target has a few hundred corners.
const MAX_CORRESPONDENCES: usize = 100;

/// From the overview camera's pixels to the robot.
#[derive(Debug, Serialize, ToSchema)]
pub struct MappingBody {
    pub kind: MappingKindWord,
    /// Row by row: (X·w, Y·w, w) = matrix · (x, y, 1), in mm and pixels.
    pub matrix: [[f64; 3]; 3],
    /// Root mean square distance of the correspondences from where the mapping puts them.
    pub residual_mm: f64,
}

/// A workcell as it is kept.
#[derive(Debug, Serialize, ToSchema)]
pub struct WorkcellBody {
    pub name: String,
    pub database: String,
    pub calibration: Option<String>,
    pub correspondences: Vec<CorrespondenceBody>,
    pub flip_y: bool,
    pub mapping: MappingBody,
    pub local: Option<LocalCameraBody>,
    pub tolerance_px: f64,
    /// All members; null: chosen from each picture.
    pub segmentation: SegmentationOptionsBody,
    /// `mirrored`: with the other `flip_y` the correspondences would fit far better, or two of them were exchanged.
    pub warnings: Vec<&'static str>,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

impl From<KeptWorkcell> for WorkcellBody {
    fn from(kept: KeptWorkcell) -> Self {
        let KeptWorkcell { name, setup, created_at, updated_at } = kept;
        let Workcell { mapping, flip_y, local, tolerance_px, segmentation } = setup.workcell;
        Self {
            name,
            database: setup.database.to_string(),
            calibration: setup.calibration.map(|name| name.to_string()),
            correspondences: (setup.correspondences.into_iter())
                .map(|pair| CorrespondenceBody { image_px: pair.image_px, robot_mm: pair.robot_mm })
                .collect(),
            flip_y,
            warnings: if mapping.mirrored { vec!["mirrored"] } else { vec![] },
            mapping: MappingBody {
                kind: mapping.kind.into(),
                matrix: mapping.matrix,
                residual_mm: mapping.residual_mm,
            },
            local: local.map(|local| LocalCameraBody {
                mm_per_px: local.mm_per_px,
                rotation_deg: local.rotation_deg,
            }),
            tolerance_px,
            segmentation: (&segmentation).into(),
            created_at,
            updated_at,
        }
    }
}

/// What is wrong with the correspondences, and what to do.
fn unfit(error: &MappingError) -> FieldError {
    let (below, advice) = match *error {
        MappingError::TooFew { .. } => (String::new(), "give more, or a simpler mapping"),
        MappingError::Equal { second, what, .. } => {
            (format!("/{second}/{what}"), "give places that are apart, each once")
        }
        MappingError::Collinear { .. } => {
            (String::new(), "give some beside that line, spread over the table, or mapping similarity")
        }
        MappingError::NotFinite { at } => (format!("/{at}"), "give pixels and mm"),
        MappingError::Folded => (
            String::new(),
            "look for one that is mistyped or for two that are exchanged, or give mapping affine",
        ),
        MappingError::Unlike => (
            String::new(),
            "give flip_y the other way round, look for what is mistyped, or give mapping affine",
        ),
    };
    FieldError { pointer: format!("/correspondences{below}"), detail: format!("{error}: {advice}") }
}

impl PutWorkcell {
    /// The workcell that the members describe.
    ///
    /// # Errors
    /// Every member that is missing, unknown, misshapen or impossible.
    fn read(body: &Map<String, Value>) -> Result<WorkcellSetup, Problem> {
        let (sent, mut faults) = readable::<Self>("", body);
        let is_told = |faults: &[FieldError], member: &str| {
            faults.iter().any(|fault| fault.pointer.starts_with(member))
        };
        for (member, is_missing) in
            [("/database", sent.database.is_none()), ("/correspondences", sent.correspondences.is_none())]
        {
            // One that was sent and can't be read is told so, and not that it is missing.
            if is_missing && !is_told(&faults, member) {
                faults.push(FieldError { pointer: member.into(), detail: "is missing".into() });
            }
        }
        let tolerance_px = sent.tolerance_px.unwrap_or(1.0);
        let local = sent
            .local
            .map(|local| LocalCamera { mm_per_px: local.mm_per_px, rotation_deg: local.rotation_deg });
        faults.extend(
            workcell::faults(local, tolerance_px)
                .into_iter()
                .map(|fault| FieldError { pointer: format!("/{}", fault.option), detail: fault.message }),
        );
        let (segmentation, wrong) =
            SegmentationOptionsBody::read("/segmentation", &sent.segmentation.unwrap_or_default());
        faults.extend(wrong);
        let correspondences: Vec<Correspondence> = (sent.correspondences.iter().flatten())
            .map(|pair| Correspondence { image_px: pair.image_px, robot_mm: pair.robot_mm })
            .collect();
        let flip_y = sent.flip_y.unwrap_or(true);
        let kind = sent.mapping.map(workcell::MappingKind::from);
        let mapping = if sent.correspondences.is_none() {
            None
        } else if correspondences.len() > MAX_CORRESPONDENCES {
            let detail = format!("{} are more than {MAX_CORRESPONDENCES}: give fewer", correspondences.len());
            faults.push(FieldError { pointer: "/correspondences".into(), detail });
            None
        } else {
            Mapping::fit(&correspondences, kind, flip_y).map_err(|error| faults.push(unfit(&error))).ok()
        };
        match (sent.database, mapping, faults.as_slice()) {
            (Some(database), Some(mapping), []) => Ok(WorkcellSetup {
                database,
                calibration: sent.calibration,
                correspondences,
                workcell: Workcell { mapping, flip_y, local, tolerance_px, segmentation },
            }),
            _ => Err(Problem::fields(faults)),
        }
    }
}

/// Describe a workcell; one of that name is replaced. The database must be there, trained or not, and of kind
/// `objects`; so must the calibration, if one is named.
#[utoipa::path(
    put, operation_id = "put_workcell",
    path = "/v1/workcells/{name}", tag = "workcell", security(("key" = ["train"])), params(WorkcellPath), request_body = PutWorkcell,
    responses(
        (status = 201, body = WorkcellBody, description = "Created"),
        (status = 200, body = WorkcellBody, description = "It was there, and is replaced"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    who: Who,
    Path(path): Path<WorkcellPath>,
    JsonIn(body): JsonIn<Map<String, Value>>,
) -> Result<(StatusCode, Json<WorkcellBody>), Problem> {
    let setup = PutWorkcell::read(&body)?;
    reach(&who.caller, setup.database.as_str())?;
    // Nor may it be taken from a database that isn't the caller's.
    match service.databases.workcell(&path.name).await {
        Ok(before) => reach(&who.caller, before.setup.database.as_str())?,
        Err(DatabaseError::UnknownWorkcell { .. }) => {}
        // Of one that can't be read nobody knows whose it is.
        Err(DatabaseError::UnreadableWorkcell { .. }) => for_all(&who)?,
        Err(error) => return Err(error.into()),
    }
    let (kept, created) = service.databases.put_workcell(&path.name, &setup, &who.actor()).await?;
    let status = if created { StatusCode::CREATED } else { StatusCode::OK };
    Ok((status, Json(kept.into())))
}

/// Workcells by name.
#[utoipa::path(
    get, operation_id = "list_workcells", path = "/v1/workcells", tag = "workcell", security(("key" = ["recognise"])), params(PageQuery),
    responses((status = 200, body = Page<WorkcellBody>))
)]
pub async fn list(
    State(service): State<Service>,
    who: Who,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<WorkcellBody>>, Problem> {
    let limit = pages::limit(page.limit)?;
    let kept = service.databases.workcells(page.cursor.as_deref(), limit).await?;
    let mut page = Page::of(kept, limit, |workcell| workcell.name.clone(), WorkcellBody::from);
    page.items.retain(|workcell| who.caller.reaches(workcell.database.as_str()));
    Ok(Json(page))
}

/// One workcell.
#[utoipa::path(
    get, operation_id = "get_workcell",
    path = "/v1/workcells/{name}", tag = "workcell", security(("key" = ["recognise"])), params(WorkcellPath),
    responses((status = 200, body = WorkcellBody))
)]
pub async fn get(
    State(service): State<Service>,
    who: Who,
    Path(path): Path<WorkcellPath>,
) -> Result<Json<WorkcellBody>, Problem> {
    let kept = service.databases.workcell(&path.name).await?;
    reach(&who.caller, kept.setup.database.as_str())?;
    Ok(Json(kept.into()))
}

/// Delete a workcell. Its database and calibration stay.
#[utoipa::path(
    delete, operation_id = "delete_workcell",
    path = "/v1/workcells/{name}", tag = "workcell", security(("key" = ["train"])), params(WorkcellPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    who: Who,
    Path(path): Path<WorkcellPath>,
) -> Result<StatusCode, Problem> {
    match service.databases.workcell(&path.name).await {
        Ok(kept) => reach(&who.caller, kept.setup.database.as_str())?,
        // One that can't be read can still be deleted, by who reaches all.
        Err(DatabaseError::UnreadableWorkcell { .. }) => for_all(&who)?,
        Err(error) => return Err(error.into()),
    }
    service.databases.delete_workcell(&path.name, &who.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
