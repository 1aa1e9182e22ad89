//! The survey of an exemplar as requests have it: members of a query, parts of a form, lines of a manifest, a change.

use serde::Deserialize;
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::Service;
use super::cameras::CameraReference;
use super::extract::{from_json, from_value};
use super::problem::{FieldError, Problem};
use super::uploads::Texts;
use crate::database::survey::{CameraDocument, MapPoseDocument, Survey, is_size};
use landmarkd_core::geometry::Camera;

/// A survey whose camera may be a name. Of a query the members of the pose stand by themselves.
#[derive(Debug, Clone, Default)]
pub struct SurveyIn {
    pub pose: Option<MapPoseDocument>,
    pub camera: Option<CameraReference>,
    pub size_mm: Option<f64>,
}

impl SurveyIn {
    /// The same with the members of a form's parts before its own.
    ///
    /// # Errors
    /// A part that can't be read.
    pub fn with_texts(self, texts: &Texts) -> Result<Self, Problem> {
        let pose = texts.get("pose").map(|text| from_json(text).map_err(|problem| problem.in_part("pose")));
        let camera = texts
            .get("camera")
            .map(|text| CameraReference::of_text(text).map_err(|problem| problem.in_part("camera")));
        let size_mm =
            texts.get("size_mm").map(|text| from_json(text).map_err(|problem| problem.in_part("size_mm")));
        Ok(Self {
            pose: pose.transpose()?.or(self.pose),
            camera: camera.transpose()?.or(self.camera),
            size_mm: size_mm.transpose()?.or(self.size_mm),
        })
    }

    /// The survey, its camera looked up. `at` is what pointers to its members begin with.
    ///
    /// # Errors
    /// Every member at fault, or a camera that isn't there.
    pub async fn resolved(self, service: &Service, at: &str) -> Result<Survey, Problem> {
        let camera = match self.camera {
            Some(camera) => Some(camera.resolved(service, &format!("{at}camera")).await?),
            None => None,
        };
        let survey = Survey { pose: self.pose, camera, size_mm: self.size_mm };
        checked(&survey, at)?;
        Ok(survey)
    }
}

fn checked(survey: &Survey, at: &str) -> Result<(), Problem> {
    let mut faults: Vec<FieldError> = Vec::new();
    let mut fault = |member: &str, detail: String| {
        faults.push(FieldError { pointer: format!("{at}{member}"), detail });
    };
    for (member, detail) in survey.pose.iter().flat_map(MapPoseDocument::faults) {
        // in a query the members stand by themselves
        let within = if at == "#" { member.to_owned() } else { format!("pose/{member}") };
        fault(&within, detail);
    }
    if let Some(size_mm) = survey.size_mm.filter(|size| !is_size(*size)) {
        fault(
            "size_mm",
            format!("{size_mm} is not the width of a picture in mm, above 0 and at most 1000000"),
        );
    }
    if faults.is_empty() { Ok(()) } else { Err(Problem::fields(faults)) }
}

/// The camera of a picture of that size. `at` points to it.
///
/// # Errors
/// The camera is one of pictures of another shape.
pub fn camera_for(camera: &CameraDocument, size_px: (u32, u32), at: &str) -> Result<Camera, Problem> {
    let (width, height) = size_px;
    Camera::from(camera).resized(width, height).ok_or_else(|| {
        let text = format!(
            "is of pictures of {}×{} px, and this one has {width}×{height}: send the whole picture at any size, or the \
             intrinsics of what was cut out",
            camera.width_px, camera.height_px
        );
        Problem::field(at, text)
    })
}

/// A change of an exemplar's survey: what is left out stays, null takes it away.
#[derive(Debug, ToSchema)]
#[schema(as = ExemplarPatch)]
#[expect(dead_code, reason = "describes the body for the OpenAPI document")]
pub struct SurveyPatch {
    pose: Option<MapPoseDocument>,
    camera: Option<CameraReference>,
    /// Width of the picture on the plane that it shows, in mm.
    size_mm: Option<f64>,
}

/// A change, read: of each member none where it stays, else what it becomes.
#[derive(Default)]
pub struct SurveyChange {
    pose: Option<Option<MapPoseDocument>>,
    pub camera: Option<Option<CameraDocument>>,
    size_mm: Option<Option<f64>>,
}

impl SurveyChange {
    /// As a request has it.
    ///
    /// # Errors
    /// Every member that is unknown, misshapen or impossible, or a camera that isn't there.
    pub async fn read(service: &Service, members: Map<String, Value>) -> Result<Self, Problem> {
        let (mut change, mut faults) = (Self::default(), Vec::new());
        for (name, value) in members {
            match name.as_str() {
                "pose" => change.pose = Some(member("pose", value, &mut faults)),
                "size_mm" => change.size_mm = Some(member("size_mm", value, &mut faults)),
                "camera" => {
                    let camera: Option<CameraReference> = member("camera", value, &mut faults);
                    change.camera = Some(match camera {
                        Some(camera) => Some(camera.resolved(service, "/camera").await?),
                        None => None,
                    });
                }
                _ => faults.push(FieldError {
                    pointer: format!("/{name}"),
                    detail: "is no member that can be changed: pose, camera and size_mm are".into(),
                }),
            }
        }
        if !faults.is_empty() {
            return Err(Problem::fields(faults));
        }
        checked(&change.on(Survey::default()), "/")?;
        Ok(change)
    }

    /// The survey with this change.
    pub fn on(&self, before: Survey) -> Survey {
        Survey {
            pose: self.pose.clone().unwrap_or(before.pose),
            camera: self.camera.unwrap_or(before.camera),
            size_mm: self.size_mm.unwrap_or(before.size_mm),
        }
    }
}

fn member<T: for<'de> Deserialize<'de>>(name: &str, value: Value, faults: &mut Vec<FieldError>) -> Option<T> {
    match from_value::<Option<T>>(value) {
        Ok(read) => read,
        Err(fault) => {
            faults.push(FieldError { pointer: format!("/{name}{}", fault.pointer), ..fault });
            None
        }
    }
}
