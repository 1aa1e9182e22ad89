//! `/v1/workcells[/{name}]`: a table, the cameras above it, and the robot that reaches onto it.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};

use super::access::reach;
use super::extract::{Json as JsonIn, Path, Query};
use super::keys::unconfined;
use super::options::{read_members, read_segmentation};
use super::pages::{self, Page, PageQuery};
use super::problem::{FieldError, Problem};
use super::{Service, put_status};
use crate::access::Caller;
use crate::database::options::SegmentationOptionsDocument;
use crate::database::workcells::{
    CorrespondenceDocument, LocalCameraDocument, MappingKindWord, WorkcellDocument,
};
use crate::database::{DatabaseError, KeptWorkcell, Name, WorkcellSetup};
use landmarkd_core::workcell::{
    MappingError, MappingKind, Suspect, Workcell, leave_one_out_mm, residuals_mm, suspect,
};

/// The workcell that a call is about.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct WorkcellPath {
    /// Name of the workcell.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub name: Name,
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
    /// The distance of each correspondence, in their order; null beyond the mapping's horizon.
    #[schema(required = false)]
    pub residuals_mm: Vec<Option<f64>>,
    /// How well each kind of mapping foretells a correspondence from the others.
    #[schema(required = false)]
    pub leave_one_out_mm: LeaveOneOutBody,
    /// The correspondences, by their indices from 0, that `exchanged` (two) or `outlying` (one) is about.
    #[schema(required = false)]
    pub suspects: Vec<usize>,
}

/// Root mean square distance of left-out correspondences from where a mapping fitted to the others puts them, in mm;
/// null if too few are left. What `mapping` is chosen by if it isn't given.
#[derive(Debug, Serialize, ToSchema)]
pub struct LeaveOneOutBody {
    pub similarity: Option<f64>,
    pub affine: Option<f64>,
    pub homography: Option<f64>,
}

/// A workcell as it is kept.
#[derive(Debug, Serialize, ToSchema)]
pub struct WorkcellBody {
    pub name: String,
    pub database: String,
    pub calibration: Option<String>,
    pub correspondences: Vec<CorrespondenceDocument>,
    pub flip_y: bool,
    pub mapping: MappingBody,
    pub local: Option<LocalCameraDocument>,
    pub tolerance_px: f64,
    /// All members; null: chosen from each picture.
    pub segmentation: SegmentationOptionsDocument,
    /// `mirrored`: with the other `flip_y` the correspondences would fit far better, or two of them were exchanged.
    /// `exchanged`: with the robot's points of the two `suspects` exchanged they would. `outlying`: without the one in
    /// `suspects` they would.
    pub warnings: Vec<&'static str>,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

impl From<KeptWorkcell> for WorkcellBody {
    fn from(kept: KeptWorkcell) -> Self {
        let KeptWorkcell { name, setup, created_at, updated_at } = kept;
        let Workcell { mapping, flip_y, local, tolerance_px, segmentation } = setup.workcell;
        let suspect = suspect(&mapping, &setup.correspondences, flip_y);
        let warnings = [
            ("mirrored", mapping.mirrored),
            ("exchanged", matches!(suspect, Some(Suspect::Exchanged(_)))),
            ("outlying", matches!(suspect, Some(Suspect::Outlying(_)))),
        ];
        let left_out = |kind| leave_one_out_mm(&setup.correspondences, kind, flip_y);
        let leave_one_out_mm = LeaveOneOutBody {
            similarity: left_out(MappingKind::Similarity),
            affine: left_out(MappingKind::Affine),
            homography: left_out(MappingKind::Homography),
        };
        let mapping = MappingBody {
            kind: mapping.kind.into(),
            matrix: mapping.matrix,
            residual_mm: mapping.residual_mm,
            residuals_mm: residuals_mm(&mapping, &setup.correspondences),
            leave_one_out_mm,
            suspects: match suspect {
                Some(Suspect::Exchanged(pair)) => pair.to_vec(),
                Some(Suspect::Outlying(at)) => vec![at],
                None => vec![],
            },
        };
        Self {
            name,
            database: setup.database.to_string(),
            calibration: setup.calibration.map(|name| name.to_string()),
            correspondences: setup.correspondences.into_iter().map(CorrespondenceDocument::from).collect(),
            flip_y,
            warnings: warnings.into_iter().filter(|(_, is_so)| *is_so).map(|(word, _)| word).collect(),
            mapping,
            local: local.map(LocalCameraDocument::from),
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

/// The workcell that the members of a request describe.
///
/// # Errors
/// Every member that is missing, unknown, misshapen or impossible.
fn setup(mut body: Map<String, Value>) -> Result<WorkcellSetup, Problem> {
    // Its members are read one by one, as those of the body.
    let segmentation = match body.get_mut("segmentation") {
        Some(Value::Object(members)) => std::mem::take(members),
        _ => Map::new(),
    };
    let (document, mut faults) = read_members::<WorkcellDocument>("", &body);
    faults.extend(missing(&document, &faults));
    faults.extend(
        document
            .faults()
            .into_iter()
            .map(|fault| FieldError { pointer: format!("/{}", fault.option), detail: fault.message }),
    );
    let (segmentation, wrong) = read_segmentation("/segmentation", &segmentation);
    faults.extend(wrong);
    let mapping = document.correspondences.as_ref().and_then(|correspondences| {
        let fitted = match correspondences.len() {
            ..=MAX_CORRESPONDENCES => document.fit().map_err(|error| unfit(&error)),
            count => Err(FieldError {
                pointer: "/correspondences".into(),
                detail: format!("{count} are more than {MAX_CORRESPONDENCES}: give fewer"),
            }),
        };
        fitted.map_err(|fault| faults.push(fault)).ok()
    });
    match (document.database.clone(), mapping, faults.as_slice()) {
        (Some(database), Some(mapping), []) => Ok(document.setup(database, mapping, segmentation)),
        _ => Err(Problem::fields(faults)),
    }
}

/// The members that are missing, but for those that were sent and can't be read.
fn missing(document: &WorkcellDocument, faults: &[FieldError]) -> Vec<FieldError> {
    let is_missing = [
        ("/database", document.database.is_none()),
        ("/correspondences", document.correspondences.is_none()),
    ];
    let is_unreadable = |member: &str| faults.iter().any(|fault| fault.pointer.starts_with(member));
    (is_missing.into_iter())
        .filter(|&(member, is_missing)| is_missing && !is_unreadable(member))
        .map(|(member, _)| FieldError { pointer: member.into(), detail: "is missing".into() })
        .collect()
}

/// Describe a workcell; one of that name is replaced. The database must be there, trained or not, and of kind
/// `objects`; so must the calibration, if one is named.
#[utoipa::path(
    put, operation_id = "put_workcell",
    path = "/v1/workcells/{name}", tag = "workcell", security(("key" = ["train"])), params(WorkcellPath), request_body = WorkcellDocument,
    responses(
        (status = 201, body = WorkcellBody, description = "Created"),
        (status = 200, body = WorkcellBody, description = "It was there, and is replaced"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<WorkcellPath>,
    JsonIn(body): JsonIn<Map<String, Value>>,
) -> Result<(StatusCode, Json<WorkcellBody>), Problem> {
    let setup = setup(body)?;
    reach(&caller, setup.database.as_str())?;
    // Nor may it be taken from a database that isn't the caller's.
    match service.databases.workcell(&path.name).await {
        Ok(before) => reach(&caller, before.setup.database.as_str())?,
        Err(DatabaseError::UnknownWorkcell { .. }) => {}
        // Of one that can't be read nobody knows whose it is.
        Err(DatabaseError::UnreadableWorkcell { .. }) => unconfined(&caller)?,
        Err(error) => return Err(error.into()),
    }
    let (kept, created) = service.databases.put_workcell(&path.name, &setup, &caller.actor()).await?;
    let status = put_status(created);
    Ok((status, Json(kept.into())))
}

/// Workcells by name.
#[utoipa::path(
    get, operation_id = "list_workcells", path = "/v1/workcells", tag = "workcell", security(("key" = ["recognise"])), params(PageQuery),
    responses((status = 200, body = Page<WorkcellBody>))
)]
pub async fn list(
    State(service): State<Service>,
    caller: Caller,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<WorkcellBody>>, Problem> {
    let limit = pages::limit(page.limit)?;
    let kept = service.databases.workcells(page.cursor.as_deref(), limit).await?;
    let mut page = Page::of(kept, limit, |workcell| workcell.name.clone(), WorkcellBody::from);
    page.items.retain(|workcell| caller.reaches(workcell.database.as_str()));
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
    caller: Caller,
    Path(path): Path<WorkcellPath>,
) -> Result<Json<WorkcellBody>, Problem> {
    let kept = service.databases.workcell(&path.name).await?;
    reach(&caller, kept.setup.database.as_str())?;
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
    caller: Caller,
    Path(path): Path<WorkcellPath>,
) -> Result<StatusCode, Problem> {
    match service.databases.workcell(&path.name).await {
        Ok(kept) => reach(&caller, kept.setup.database.as_str())?,
        // One that can't be read can still be deleted, by who reaches all.
        Err(DatabaseError::UnreadableWorkcell { .. }) => unconfined(&caller)?,
        Err(error) => return Err(error.into()),
    }
    service.databases.delete_workcell(&path.name, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
