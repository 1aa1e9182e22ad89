//! `/v1/calibrations[/{name}[/registration]]`: what is known of the rigs that depth is measured with.

use axum::Json;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::{IntoParams, ToSchema};

use super::Service;
use super::access::Who;
use super::depth_maps::decoded_pair;
use super::extract::{Json as JsonIn, Path, Query};
use super::optics::{OpticsBody, told_mm};
use super::options::DepthMethodWord;
use super::pages::{self, Page, PageQuery};
use super::problem::{Code, FieldError, Problem};
use super::uploads::{KnownParts, Picture};
use crate::compute::Lane;
use crate::database::{Name, Rig};
use landmarkd_core::depth::{Calibration, RegistrationTarget};
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
    pub image: Option<ImageBody>,
    /// What it is measured by: as described, or fitted to a sweep.
    pub optics: OpticsBody,
    /// The optics as described, if it was fitted to a sweep since; else null.
    pub stated_optics: Option<OpticsBody>,
    pub registration: Option<RegistrationBody>,
    pub photometric: Option<PhotometricBody>,
    pub noise: Option<NoiseBody>,
    /// What the table was measured with.
    pub filters: Option<FiltersBody>,
    pub table: Option<TableBody>,
    pub residual: Option<ResidualBody>,
    /// The distance that the near-focused picture is focused at.
    pub near_focus_mm: f64,
    /// The distance that the far-focused picture is focused at.
    pub far_focus_mm: f64,
    /// From the near to the far focus distance: the working range.
    pub range_mm: f64,
    /// The largest blur within the working range.
    pub largest_blur_px: f64,
    /// What would make it better, for people.
    pub advice: Vec<String>,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

/// Size of the pictures in pixels, and bits a sample.
#[derive(Debug, Serialize, ToSchema)]
pub struct ImageBody {
    pub width: usize,
    pub height: usize,
    pub bits: u8,
}

/// How the far-focused picture is brought into register.
#[derive(Debug, Serialize, ToSchema)]
pub struct RegistrationBody {
    /// a, b, c, d, e, f: the far pixel (a·x + b·y + c, d·x + e·y + f) shows what the near pixel (x, y) shows.
    pub affine_far_to_near: [f64; 6],
    /// What is left between both.
    pub rms_px: f64,
}

/// Offsets and gain of the two sensors, in grey levels of 255.
#[derive(Debug, Serialize, ToSchema)]
pub struct PhotometricBody {
    pub dark_near: f64,
    pub dark_far: f64,
    /// What the far-focused picture, without its dark level, is multiplied by.
    pub gain_far: f64,
}

/// Noise of a pixel: variance = read_sigma² + shot_gain · level, in grey levels of 255.
#[derive(Debug, Serialize, ToSchema)]
pub struct NoiseBody {
    pub read_sigma: f64,
    pub shot_gain: f64,
}

/// The filters that the table was measured with.
#[derive(Debug, Serialize, ToSchema)]
pub struct FiltersBody {
    pub method: DepthMethodWord,
    /// Side of the kernels.
    #[serde(rename = "K")]
    pub side: usize,
    /// Pairs of kernels.
    #[serde(rename = "J")]
    pub rank: usize,
    /// Highest frequency that they let pass, cycles a pixel.
    pub band: f64,
    /// By how much the pictures are shrunk first.
    pub scale: u32,
    pub hash: String,
}

/// From what the method says to what is true, by planes at known depths.
#[derive(Debug, Serialize, ToSchema)]
pub struct TableBody {
    /// Where the planes are between the focus distances: 1 near, −1 far.
    pub beta: Vec<f64>,
    /// What the method said.
    pub raw: Vec<f64>,
    /// Standard deviation of that over the plane.
    pub sigma: Vec<f64>,
    pub depth_mm: Vec<f64>,
}

/// What is left of the planes' depths after the table.
#[derive(Debug, Serialize, ToSchema)]
pub struct ResidualBody {
    pub rms_mm: f64,
    pub max_mm: f64,
}

/// Version of the document's shape.
const SHAPE: u32 = 1;

impl From<Rig> for CalibrationBody {
    fn from(rig: Rig) -> Self {
        let advice = rig.advice();
        let Calibration { optics, stated, image, registration, photometric, noise, filters, table, residual } =
            rig.calibration;
        Self {
            name: rig.name,
            version: SHAPE,
            image: image.map(|image| ImageBody {
                width: image.width_px,
                height: image.height_px,
                bits: image.bits,
            }),
            registration: registration.map(|registration| RegistrationBody {
                affine_far_to_near: registration.affine_far_to_near,
                rms_px: registration.rms_px,
            }),
            photometric: photometric.map(|photometric| PhotometricBody {
                dark_near: photometric.dark_near,
                dark_far: photometric.dark_far,
                gain_far: photometric.gain_far,
            }),
            noise: noise.map(|noise| NoiseBody { read_sigma: noise.read_sigma, shot_gain: noise.shot_gain }),
            filters: filters.map(|filters| FiltersBody {
                method: filters.method.into(),
                side: filters.side,
                rank: filters.rank,
                band: filters.band,
                scale: 1 << filters.halvings,
                hash: filters.hash,
            }),
            table: table.map(|table| TableBody {
                beta: table.beta,
                raw: table.raw,
                sigma: table.sigma,
                depth_mm: table.depth_mm,
            }),
            residual: residual
                .map(|residual| ResidualBody { rms_mm: residual.rms_mm, max_mm: residual.max_mm }),
            near_focus_mm: told_mm(optics.near_focus_mm()),
            far_focus_mm: told_mm(optics.far_focus_mm()),
            range_mm: told_mm(optics.range_mm()),
            largest_blur_px: optics.largest_blur_px(),
            optics: (&optics).into(),
            stated_optics: stated.as_ref().map(OpticsBody::from),
            advice,
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
    who: Who,
    Path(path): Path<CalibrationPath>,
    JsonIn(body): JsonIn<Map<String, Value>>,
) -> Result<(StatusCode, Json<CalibrationBody>), Problem> {
    let optics = OpticsBody::read("", &body).map_err(Problem::fields)?;
    let (rig, created) = service.databases.put_rig(&path.name, &optics, &who.actor()).await?;
    let status = if created { StatusCode::CREATED } else { StatusCode::OK };
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
    Ok(Json(service.databases.rig(&path.name).await?.into()))
}

/// Delete a calibration; its unfinished sweeps are cancelled.
#[utoipa::path(
    delete, operation_id = "delete_calibration",
    path = "/v1/calibrations/{name}", tag = "depth", security(("key" = ["train"])), params(CalibrationPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    who: Who,
    Path(path): Path<CalibrationPath>,
) -> Result<StatusCode, Problem> {
    service.databases.delete_rig(&path.name, &who.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Pictures to register by.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct RegistrationForm {
    /// The near-focused picture of a flat target with fine irregular texture, within the working range.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    near: String,
    /// The far-focused picture of it.
    #[schema(format = Binary, content_media_type = "application/octet-stream")]
    far: String,
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
}

const REGISTRATION_PARTS: [&str; 6] = ["near", "far", "dark_near", "dark_far", "flat_near", "flat_far"];

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
    who: Who,
    Path(path): Path<CalibrationPath>,
    request: Request,
) -> Result<Json<CalibrationBody>, Problem> {
    let rig = service.databases.rig(&path.name).await?;
    let mut parts = KnownParts::of(request, &service, &REGISTRATION_PARTS, &[]).await?;
    for pair in [["dark_near", "dark_far"], ["flat_near", "flat_far"]] {
        for [name, other] in [pair, [pair[1], pair[0]]] {
            if parts.holds(name) && !parts.holds(other) {
                let detail = format!("is missing: {name} and {other} come together");
                parts.faults.push(FieldError { pointer: format!("/{other}"), detail });
            }
        }
    }
    let (near, far) = (parts.require("near"), parts.require("far"));
    let (Some(near), Some(far), []) = (near, far, parts.faults.as_slice()) else {
        return Err(Problem::fields(parts.faults));
    };
    let mut pictures = vec![("near", near), ("far", far)];
    let others = REGISTRATION_PARTS[2..].iter();
    pictures.extend(others.filter_map(|name| Some((*name, parts.take(name)?))));
    let judged = pictures.into_iter().map(|(name, bytes)| {
        let picture = Picture::of(bytes, &service.decode)
            .and_then(Picture::for_depth)
            .map_err(|problem| problem.in_part(name))?;
        Ok::<_, Problem>((name, picture))
    });
    let pictures = judged.collect::<Result<Vec<_>, _>>()?;
    let memory = pictures.iter().map(|(_, picture)| picture.depth_bytes).sum();
    let (calibration, limits, share) = (rig.calibration.clone(), service.decode, parts.share);
    let work = move || {
        let _share = share;
        Ok::<_, Problem>(calibration.registered(&target(&pictures, &limits)?)?)
    };
    let (registered, _) = service.compute.run(Lane::Upkeep, memory, work).await?;
    Ok(Json(service.databases.update_rig(&rig, &registered?, &who.actor()).await?.into()))
}

/// The target from its pictures, the first two its own: runs on a computing thread.
fn target(pictures: &[(&str, Picture)], limits: &DecodeLimits) -> Result<RegistrationTarget, Problem> {
    let pair = decoded_pair([&pictures[0].1, &pictures[1].1], ["near", "far"], limits)?;
    let level = |name: &str| -> Result<Option<f64>, Problem> {
        let Some((_, picture)) = pictures.iter().find(|(part, _)| *part == name) else { return Ok(None) };
        let frame =
            imaging::decode(&picture.bytes, limits).map_err(|error| Problem::from(error).in_part(name))?;
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
    let both = |near: Option<f64>, far: Option<f64>| near.zip(far).map(|(near, far)| [near, far]);
    let dark = both(level("dark_near")?, level("dark_far")?);
    let flat = both(level("flat_near")?, level("flat_far")?);
    Ok(RegistrationTarget { target: pair, dark, flat })
}
