//! `/v1/calibrations[/{name}[/registration]]`: what is known of the rigs that depth is measured with.

use std::collections::BTreeMap;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::extract::{Json as JsonIn, Path, Query};
use super::optics::{OpticsBody, rounded_mm};
use super::pages::{self, Page, PageQuery};
use super::pairs::{PairPictures, depth_picture};
use super::problem::{Code, FieldError, Problem};
use super::uploads::{KnownParts, Picture};
use super::{Service, put_status};
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::Name;
use crate::database::calibrations::{
    CALIBRATION_DOCUMENT_VERSION, FiltersDocument, ImageDocument, NoiseDocument, PhotometricDocument,
    RegistrationDocument, ResidualDocument, Rig, TableDocument,
};
use landmarkd_core::depth::{Calibration, Optics, RegistrationTarget};
use landmarkd_core::imaging::{self, DecodeLimits};

/// The calibration that a call is about.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct CalibrationPath {
    /// Name of the calibration.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub name: Name,
}

/// What is known of a rig: its optics, and what was measured with it.
#[derive(Debug, Serialize, ToSchema)]
pub struct CalibrationBody {
    pub name: String,
    /// Version of the document's shape.
    pub version: u32,
    /// The pictures that it holds for; null before anything was measured.
    pub image: Option<ImageDocument>,
    /// What it is measured by: as described, or fitted to a sweep.
    pub optics: OpticsBody,
    /// The optics as described, if it was fitted to a sweep since; else null.
    pub stated_optics: Option<OpticsBody>,
    /// Of an aperture pair, here and in `photometric`, near is the first picture: the wide-open one when the range ends beyond
    /// the focus, the stopped-down one when it ends before it.
    pub registration: Option<RegistrationDocument>,
    /// For near and far of an aperture pair see `registration`.
    pub photometric: Option<PhotometricDocument>,
    pub noise: Option<NoiseDocument>,
    /// What the table was measured with.
    pub filters: Option<FiltersDocument>,
    pub table: Option<TableDocument>,
    pub residual: Option<ResidualDocument>,
    /// The distance that the near-focused picture is focused at; of an aperture pair, the near end of the working range.
    pub near_focus_mm: f64,
    /// The distance that the far-focused picture is focused at; of an aperture pair, the far end of the working range.
    pub far_focus_mm: f64,
    /// From the one to the other: the working range.
    pub range_mm: f64,
    /// The largest blur within the working range.
    pub largest_blur_px: f64,
    /// What would make it better, for people.
    pub advice: Vec<String>,
    /// The newest sweep's job, if it failed and nothing was measured since: what is above is from before it. Told of one
    /// calibration, not in a list.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub failed_sweep: Option<Uuid>,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

impl From<Rig> for CalibrationBody {
    fn from(rig: Rig) -> Self {
        let advice = rig.advice();
        let Calibration { optics, stated, image, registration, photometric, noise, filters, table, residual } =
            rig.calibration;
        Self {
            name: rig.name,
            version: CALIBRATION_DOCUMENT_VERSION,
            image: image.map(ImageDocument::from),
            registration: registration.map(RegistrationDocument::from),
            photometric: photometric.map(PhotometricDocument::from),
            noise: noise.map(NoiseDocument::from),
            filters: filters.map(FiltersDocument::from),
            table: table.map(TableDocument::from),
            residual: residual.map(ResidualDocument::from),
            near_focus_mm: rounded_mm(optics.near_focus_mm()),
            far_focus_mm: rounded_mm(optics.far_focus_mm()),
            range_mm: rounded_mm(optics.range_mm()),
            largest_blur_px: optics.largest_blur_px(),
            optics: (&optics).into(),
            stated_optics: stated.as_ref().map(OpticsBody::from),
            advice,
            failed_sweep: None,
            created_at: rig.created_at,
            updated_at: rig.updated_at,
        }
    }
}

/// Describe a rig by its optics. The same optics again changes nothing; another drops what was measured with the one
/// before: registration, brightness and table.
#[utoipa::path(
    put, operation_id = "put_calibration",
    path = "/v1/calibrations/{name}", tag = "depth", security(("key" = ["train"])), params(CalibrationPath), request_body = OpticsBody,
    responses(
        (status = 201, body = CalibrationBody, description = "Created"),
        (status = 200, body = CalibrationBody, description = "It was there; with another optics, replaced"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CalibrationPath>,
    JsonIn(body): JsonIn<Map<String, Value>>,
) -> Result<(StatusCode, Json<CalibrationBody>), Problem> {
    let optics = OpticsBody::read("", &body).map_err(Problem::fields)?;
    let (rig, created) = service.databases.put_rig(&path.name, &optics, &caller.actor()).await?;
    let status = put_status(created);
    Ok((status, Json(rig.into())))
}

/// Calibrations by name.
#[utoipa::path(
    get, operation_id = "list_calibrations", path = "/v1/calibrations", tag = "depth", security(("key" = ["recognise"])), params(PageQuery),
    responses((status = 200, body = Page<CalibrationBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<CalibrationBody>>, Problem> {
    let limit = pages::limit(page.limit)?;
    let rigs = service.databases.rigs(page.cursor.as_deref(), limit).await?;
    Ok(Json(Page::of(rigs, limit, |rig| rig.name.clone(), CalibrationBody::from)))
}

/// One calibration.
#[utoipa::path(
    get, operation_id = "get_calibration",
    path = "/v1/calibrations/{name}", tag = "depth", security(("key" = ["recognise"])), params(CalibrationPath),
    responses((status = 200, body = CalibrationBody))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<CalibrationPath>,
) -> Result<Json<CalibrationBody>, Problem> {
    let rig = service.databases.rig(&path.name).await?;
    let failed_sweep = service.databases.failed_sweep(&rig).await?;
    Ok(Json(CalibrationBody { failed_sweep, ..rig.into() }))
}

/// Delete a calibration; its unfinished sweeps are cancelled.
#[utoipa::path(
    delete, operation_id = "delete_calibration",
    path = "/v1/calibrations/{name}", tag = "depth", security(("key" = ["train"])), params(CalibrationPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CalibrationPath>,
) -> Result<StatusCode, Problem> {
    service.databases.delete_rig(&path.name, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Pictures to register by. A rig of two apertures has `wide` and `narrow` in place of `near` and `far`, also in `dark_wide`
/// and the others; which of them its calibration calls near, see there.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct RegistrationForm {
    /// The near-focused picture of a flat target with fine irregular texture, within the working range.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    near: Option<String>,
    /// The far-focused picture of it.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    far: Option<String>,
    /// The near-focused sensor's picture in the dark; with `dark_far`.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    dark_near: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    dark_far: Option<String>,
    /// The near-focused sensor's picture of an evenly lit white surface; with `flat_far`.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    flat_near: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    flat_far: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    wide: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    narrow: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    dark_wide: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    dark_narrow: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    flat_wide: Option<String>,
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    flat_narrow: Option<String>,
}

/// The parts of a registration in the order of the optics' pictures: of the target, in the dark, of white.
fn registration_parts(optics: &Optics) -> [[&'static str; 2]; 3] {
    match optics.picture_names() {
        ["wide", _] => [["wide", "narrow"], ["dark_wide", "dark_narrow"], ["flat_wide", "flat_narrow"]],
        ["narrow", _] => [["narrow", "wide"], ["dark_narrow", "dark_wide"], ["flat_narrow", "flat_wide"]],
        _ => [["near", "far"], ["dark_near", "dark_far"], ["flat_near", "flat_far"]],
    }
}

/// Register the rig's two pictures by one textured target, and match their brightness. A table measured before is
/// dropped: it was measured with another registration.
#[utoipa::path(
    post, operation_id = "register_calibration",
    path = "/v1/calibrations/{name}/registration", tag = "depth", security(("key" = ["train"])), params(CalibrationPath),
    request_body(content = RegistrationForm, content_type = "multipart/form-data"),
    responses((status = 200, body = CalibrationBody))
)]
pub async fn register(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CalibrationPath>,
    request: Request,
) -> Result<Json<CalibrationBody>, Problem> {
    let rig = service.databases.rig(&path.name).await?;
    let names = registration_parts(&rig.calibration.optics);
    let mut parts = KnownParts::of(request, &service, names.as_flattened(), &[], None).await?;
    let pictures = RegistrationPictures::take(&mut parts, names, &service.decode)?;
    let memory = pictures.depth_bytes();
    let (calibration, limits, share) = (rig.calibration.clone(), service.decode, parts.share);
    let work = move || {
        let _share = share;
        Ok::<_, Problem>(calibration.registered(&pictures.decoded(names, &limits)?)?)
    };
    let (registered, _) = service.compute.run(Lane::Maintenance, memory, work).await?;
    Ok(Json(service.databases.update_rig(&rig, &registered?, &caller.actor()).await?.into()))
}

/// The pictures of a registration.
struct RegistrationPictures {
    target: PairPictures,
    /// In the dark and of white, those that were sent, by the names of their parts.
    levels: BTreeMap<&'static str, Picture>,
}

impl RegistrationPictures {
    /// Takes them out of the form. `names` are those of [`registration_parts`].
    ///
    /// # Errors
    /// Every part that is missing, unknown or comes twice; or the first that is no picture for depth.
    fn take(
        parts: &mut KnownParts,
        names: [[&'static str; 2]; 3],
        limits: &DecodeLimits,
    ) -> Result<Self, Problem> {
        let [target, dark, flat] = names;
        for pair in [dark, flat] {
            for [name, other] in [pair, [pair[1], pair[0]]] {
                if parts.holds(name) && !parts.holds(other) {
                    let detail = format!("is missing: {name} and {other} come together");
                    parts.faults.push(FieldError { pointer: format!("/{other}"), detail });
                }
            }
        }
        let required = target.map(|name| parts.require(name).map(|bytes| (name, bytes)));
        let ([Some(first), Some(second)], []) = (required, parts.faults.as_slice()) else {
            return Err(Problem::fields(std::mem::take(&mut parts.faults)));
        };
        let sent = [dark, flat].into_iter().flatten().filter_map(|name| Some((name, parts.take(name)?)));
        let levels = sent.map(|(name, bytes)| Ok::<_, Problem>((name, depth_picture(name, bytes, limits)?)));
        Ok(Self {
            target: PairPictures::of([first, second], limits)?,
            levels: levels.collect::<Result<_, _>>()?,
        })
    }

    /// Memory that they take while they are worked on.
    fn depth_bytes(&self) -> u64 {
        self.target.depth_bytes() + self.levels.values().map(|picture| picture.depth_bytes).sum::<u64>()
    }

    /// The target, decoded: for a computing thread.
    fn decoded(
        &self,
        [_, dark, flat]: [[&'static str; 2]; 3],
        limits: &DecodeLimits,
    ) -> Result<RegistrationTarget, Problem> {
        let pair = self.target.decoded(limits)?;
        let level = |name: &'static str| -> Result<Option<f64>, Problem> {
            let Some(picture) = self.levels.get(name) else { return Ok(None) };
            let frame = imaging::decode(&picture.bytes, limits)
                .map_err(|error| Problem::from(error).in_part(name))?;
            if (frame.width(), frame.height()) != (pair.width(), pair.height()) {
                let text = format!(
                    "it is {}×{} px, the target {}×{} px: send pictures of one size",
                    frame.width(),
                    frame.height(),
                    pair.width(),
                    pair.height()
                );
                return Err(Problem::new(Code::ImageSizeMismatch, text).in_part(name));
            }
            Ok(Some(frame.luminance.mean()))
        };
        let both = |[first, second]: [&'static str; 2]| -> Result<Option<[f64; 2]>, Problem> {
            Ok(level(first)?.zip(level(second)?).map(|(first, second)| [first, second]))
        };
        let (dark, flat) = (both(dark)?, both(flat)?);
        Ok(RegistrationTarget { target: pair, dark, flat })
    }
}
