//! `POST /v1/calibrations/{name}/sweep`: measure the rig's table by textured planes at known depths, as a job.

use std::collections::BTreeMap;

use axum::extract::{Request, State};
use axum::response::Response;
use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::Service;
use super::calibrations::CalibrationPath;
use super::extract::{MAX_JSON_BYTES, Path, from_json};
use super::jobs::{JobBody, queued};
use super::options::read_members;
use super::problem::{Code, FieldError, Problem};
use super::uploads::{Form, Picture};
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::{DepthMethodWord, PictureBlob, Rig};
use crate::jobs::{SweepParams, SweepPlane};
use landmarkd_core::depth::{MAX_PLANES, Method, Optics, Pair, Sweep};
use landmarkd_core::imaging;

/// One plane of a sweep.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneLine {
    /// Distance of the plane from the lens.
    #[schema(exclusive_minimum = 0)]
    pub depth_mm: f64,
    /// Name of the part with the near-focused picture.
    #[schema(required = false)]
    pub near: Option<String>,
    /// Name of the part with the far-focused picture.
    #[schema(required = false)]
    pub far: Option<String>,
    /// Of a rig of two apertures, in place of `near`: name of the part with the picture of the wider one.
    #[schema(required = false)]
    pub wide: Option<String>,
    /// Of a rig of two apertures, in place of `far`: name of the part with the picture of the narrower one.
    #[schema(required = false)]
    pub narrow: Option<String>,
}

impl PlaneLine {
    /// The members that name pictures, and what they hold.
    fn pictures(&self) -> [(&'static str, Option<&String>); 4] {
        let Self { near, far, wide, narrow, .. } = self;
        [("near", near), ("far", far), ("wide", wide), ("narrow", narrow)]
            .map(|(name, part)| (name, part.as_ref()))
    }
}

/// How a sweep is to be measured.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepOptionsBody {
    /// The method that the table is for: `gram` by default.
    #[schema(required = false)]
    pub method: Option<DepthMethodWord>,
    /// Whether aperture, separation (of two apertures: their ratio) and sensor plane are fitted to the planes first.
    #[schema(default = false)]
    pub fit_optics: Option<bool>,
}

/// A form with a manifest, and one part for each picture that it names.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct SweepForm {
    /// JSON: planes at 5 known depths or more, better 9 to 21, that reach past both focus distances.
    manifest: Vec<PlaneLine>,
    options: Option<SweepOptionsBody>,
}

/// Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with a job. Planes
/// that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't monotone fails
/// the job.
#[utoipa::path(
    post, operation_id = "sweep_calibration",
    path = "/v1/calibrations/{name}/sweep", tag = "depth", security(("key" = ["train"])), params(CalibrationPath),
    request_body(content = SweepForm, content_type = "multipart/form-data"),
    responses((status = 202, body = JobBody, description = "Queued", headers(("Location" = String))))
)]
pub async fn post(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<CalibrationPath>,
    request: Request,
) -> Result<Response, Problem> {
    let rig = service.databases.rig(&path.name).await?;
    let sent = SweepParts::read(request, &service).await?;
    let params = sent.params(&rig)?;
    let depths_mm: Vec<f64> = params.planes.iter().map(|plane| plane.depth_mm).collect();
    let (calibration, method) = (rig.calibration.clone(), params.method);
    let check = move || Sweep::new(&calibration, method, &depths_mm).map(drop);
    service.compute.run(Lane::Maintenance, 0, check).await?.0?;
    Ok(queued(service.jobs.sweep(&rig, &params, &caller.actor()).await?))
}

/// The distance that both pictures of an aperture pair are focused at.
fn common_focus_mm(optics: &Optics) -> Option<f64> {
    let spec = optics.spec();
    let Pair::Aperture { sensor, .. } = spec.pair else { return None };
    let (f, v) = (spec.focal_length_mm, sensor.plane_mm(spec.focal_length_mm)?);
    Some(f * v / (v - f)) // B(1)
}

/// A picture in the blob store.
struct StoredPicture {
    blob: PictureBlob,
    /// Width and height as decoded.
    size_px: (usize, usize),
}

/// The parts of a form.
#[derive(Default)]
struct SweepParts {
    manifest: Option<Bytes>,
    options: Option<Bytes>,
    pictures: BTreeMap<String, StoredPicture>,
}

impl SweepParts {
    /// Reads the form; each picture is decoded and stored as it comes, one at a time.
    async fn read(request: Request, service: &Service) -> Result<Self, Problem> {
        let limits = &service.limits;
        let held_bytes = limits.max_body_bytes + 2 * MAX_JSON_BYTES;
        let mut form = Form::of(request, service, limits.max_batch_bytes, held_bytes).await?;
        let mut sent = Self::default();
        while let Some((name, part)) = form.next().await? {
            let text = match name.as_str() {
                "manifest" => Some(&mut sent.manifest),
                "options" => Some(&mut sent.options),
                _ => None,
            };
            let twice = || Problem::field(format!("/{name}"), "comes twice: send it once");
            if let Some(text) = text {
                let bytes = part.read(MAX_JSON_BYTES).await?.map_err(|problem| problem.in_part(&name))?;
                if text.replace(bytes).is_some() {
                    return Err(twice());
                }
                continue;
            }
            if sent.pictures.contains_key(&name) {
                return Err(twice());
            }
            if sent.pictures.len() == 2 * MAX_PLANES {
                let text = format!("a sweep has at most {MAX_PLANES} planes of two pictures");
                return Err(Problem::new(Code::SweepRefused, text));
            }
            let bytes = part.read(limits.max_body_bytes).await?.map_err(|problem| problem.in_part(&name))?;
            let stored =
                StoredPicture::store(bytes, service).await.map_err(|problem| problem.in_part(&name))?;
            sent.pictures.insert(name, stored);
        }
        Ok(sent)
    }
}

impl StoredPicture {
    /// Decodes a picture once, so that only pictures are stored, and stores it.
    async fn store(bytes: Bytes, service: &Service) -> Result<Self, Problem> {
        let (picture, limits) = (Picture::of(bytes.clone(), &service.decode)?.for_depth()?, service.decode);
        let memory = picture.working_bytes;
        let decode = move || imaging::decode(&picture.bytes, &limits);
        let frame = service.compute.run(Lane::Maintenance, memory, decode).await?.0?;
        let blob = service.databases.keep_picture(bytes).await?;
        Ok(Self { blob, size_px: (frame.width(), frame.height()) })
    }
}

impl SweepParts {
    /// The sweep that the form asks for.
    fn params(&self, rig: &Rig) -> Result<SweepParams, Problem> {
        let Some(manifest) = &self.manifest else {
            let text = "is missing: send a part called manifest, JSON [{depth_mm, near, far}]";
            return Err(Problem::field("/manifest", text));
        };
        let manifest: Vec<PlaneLine> = from_json(manifest).map_err(|problem| problem.in_part("manifest"))?;
        let mut faults = Vec::new();
        let mut fault = |pointer, detail| faults.push(FieldError { pointer, detail });
        let mut planes = Vec::new();
        let optics = &rig.calibration.optics;
        let (names, focus_mm) = (optics.picture_names(), common_focus_mm(optics));
        for (at, line) in manifest.iter().enumerate() {
            let pictures = line.pictures();
            let mut picture = |member: &str| {
                let pointer = format!("/manifest/{at}/{member}");
                let named = pictures.iter().find(|(name, _)| *name == member).and_then(|(_, part)| *part);
                let Some(name) = named else {
                    fault(pointer, "is missing: the name of a part of the form".into());
                    return None;
                };
                let stored = self.pictures.get(name);
                if stored.is_none() {
                    fault(pointer, format!("the form has no part named {name:?}"));
                }
                stored
            };
            let [first, second] = names.map(&mut picture);
            if let Some((first, second)) = first.zip(second) {
                planes.push((line.depth_mm, first, second));
            }
            if let Some(focus_mm) = focus_mm
                && (line.depth_mm > focus_mm) != (optics.near_focus_mm() > focus_mm)
            {
                let detail = format!(
                    "is not on the side of the focus at {focus_mm:.1} mm that is measured: blur is alike on both, so all \
                     planes stand on that one"
                );
                fault(format!("/manifest/{at}/depth_mm"), detail);
            }
            for (member, _) in pictures.iter().filter(|(name, part)| part.is_some() && !names.contains(name))
            {
                let detail = format!("is of another kind of rig: name {} and {}", names[0], names[1]);
                fault(format!("/manifest/{at}/{member}"), detail);
            }
        }
        for name in self.pictures.keys() {
            if !manifest.iter().flat_map(PlaneLine::pictures).any(|(_, part)| part == Some(name)) {
                fault(format!("/{name}"), "no line of the manifest names this part".into());
            }
        }
        let (options, wrong) = self.options()?;
        faults.extend(wrong);
        if !faults.is_empty() {
            return Err(Problem::fields(faults));
        }
        self.check_sizes(rig)?;
        if let Some((depth_mm, ..)) = planes.iter().find(|(_, near, far)| near.blob == far.blob) {
            let [first, second] = names;
            let text =
                format!("{first} and {second} of the plane at {depth_mm} mm are one picture: send both");
            return Err(Problem::new(Code::IdenticalImages, text));
        }
        Ok(SweepParams {
            revision: rig.revision,
            method: options.method.map_or(Method::Gram, Method::from),
            fit_optics: options.fit_optics.unwrap_or_default(),
            planes: planes
                .into_iter()
                .map(|(depth_mm, near, far)| SweepPlane {
                    depth_mm,
                    near: near.blob.clone(),
                    far: far.blob.clone(),
                })
                .collect(),
        })
    }

    fn options(&self) -> Result<(SweepOptionsBody, Vec<FieldError>), Problem> {
        let Some(bytes) = &self.options else { return Ok(Default::default()) };
        let members: Map<String, Value> = from_json(bytes).map_err(|problem| problem.in_part("options"))?;
        Ok(read_members("/options", &members))
    }

    /// Refuses pictures of several sizes, or of another than the rig's if it has one.
    fn check_sizes(&self, rig: &Rig) -> Result<(), Problem> {
        let of_rig = rig.calibration.image.map(|image| (image.width_px, image.height_px));
        let Some(wanted) = of_rig.or(self.pictures.values().next().map(|stored| stored.size_px)) else {
            return Ok(());
        };
        match self.pictures.iter().find(|(_, stored)| stored.size_px != wanted) {
            None => Ok(()),
            Some((name, StoredPicture { size_px: (width, height), .. })) => {
                let text = format!(
                    "it is {width}×{height} px, not {}×{} px: send pictures of one size, the one that the rig was \
                     registered with if it was",
                    wanted.0, wanted.1
                );
                Err(Problem::new(Code::ImageSizeMismatch, text).in_part(name))
            }
        }
    }
}
