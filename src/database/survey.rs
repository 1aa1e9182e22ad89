//! The survey of an exemplar: where it was taken, with which camera, how large it is. One document, which is sent, kept with the
//! exemplar and written into artifacts.
//!
//! Without `size_mm` the pose is that of the camera's body (x forward, y left, z up: it looks along x). With it the picture
//! shows something flat, and the pose is that of the picture itself: origin in its middle, x along its normal towards whoever
//! looks at it, z up.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{DatabaseError, Databases, ExemplarRow, Name};
use landmarkd_core::geometry::{Camera, MapPose};

/// A pose in a map, as REP 103 counts: metres, degrees counter-clockwise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MapPose)]
#[serde(deny_unknown_fields)]
pub struct MapPoseDocument {
    /// The map that the numbers are of: poses of different maps are never compared.
    #[schema(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub map: Name,
    pub x_m: f64,
    pub y_m: f64,
    /// Height.
    #[serde(default)]
    #[schema(default = 0.0)]
    pub z_m: f64,
    /// Heading: 0 along the map's x axis, 90 along its y axis.
    pub yaw_deg: f64,
    /// Positive when it looks down.
    #[serde(default)]
    #[schema(default = 0.0)]
    pub pitch_deg: f64,
    /// Positive when its left side rises.
    #[serde(default)]
    #[schema(default = 0.0)]
    pub roll_deg: f64,
    /// Standard deviation of the position along each axis.
    #[serde(default = "default_sigma_m")]
    #[schema(default = 0.05)]
    pub sigma_m: f64,
}

fn default_sigma_m() -> f64 {
    MapPoseDocument::DEFAULT_SIGMA_M
}

/// The farthest that a pose may lie from its map's origin: doubles are exact to a nanometre there.
const MOST_M: f64 = 1e6;

impl MapPoseDocument {
    /// As a robot that drives by laser says of itself.
    pub const DEFAULT_SIGMA_M: f64 = 0.05;

    /// What is wrong with it: members and why.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let lengths = [("x_m", self.x_m), ("y_m", self.y_m), ("z_m", self.z_m)];
        let turns = [("yaw_deg", self.yaw_deg), ("pitch_deg", self.pitch_deg), ("roll_deg", self.roll_deg)];
        let far = lengths.into_iter().filter(|(_, length)| length.abs() > MOST_M || length.is_nan());
        let far =
            far.map(|(name, length)| (name, format!("{length} is not within {MOST_M} m of the origin")));
        let wild = turns.into_iter().filter(|(_, turn)| turn.abs() > 360.0 || turn.is_nan());
        let wild = wild.map(|(name, turn)| (name, format!("{turn} is not between -360 and 360")));
        let vague = !(self.sigma_m > 0.0 && self.sigma_m <= 100.0);
        let vague = vague.then(|| ("sigma_m", format!("{} is not above 0 and at most 100", self.sigma_m)));
        far.chain(wild).chain(vague).collect()
    }
}

impl From<&MapPoseDocument> for MapPose {
    fn from(document: &MapPoseDocument) -> Self {
        let MapPoseDocument { x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg, .. } = *document;
        Self { x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg }
    }
}

/// Intrinsics of a camera, as OpenCV and ROS (`plumb_bob`) write them: pixels count from the centre of the top-left one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Camera)]
#[serde(deny_unknown_fields)]
pub struct CameraDocument {
    /// Focal lengths, in pixels.
    pub fx: f64,
    pub fy: f64,
    /// The principal point, in pixels.
    pub cx: f64,
    pub cy: f64,
    /// Radial distortion; all are 0 for rectified pictures.
    #[serde(default)]
    #[schema(default = 0.0)]
    pub k1: f64,
    #[serde(default)]
    #[schema(default = 0.0)]
    pub k2: f64,
    /// Tangential distortion.
    #[serde(default)]
    #[schema(default = 0.0)]
    pub p1: f64,
    #[serde(default)]
    #[schema(default = 0.0)]
    pub p2: f64,
    #[serde(default)]
    #[schema(default = 0.0)]
    pub k3: f64,
    /// Size of the pictures that it was calibrated with; others of the same shape are taken too.
    pub width_px: u32,
    pub height_px: u32,
}

impl From<&CameraDocument> for Camera {
    fn from(document: &CameraDocument) -> Self {
        let CameraDocument { fx, fy, cx, cy, k1, k2, p1, p2, k3, width_px, height_px } = *document;
        Self { fx, fy, cx, cy, distortion: [k1, k2, p1, p2, k3], width_px, height_px }
    }
}

impl From<&Camera> for CameraDocument {
    fn from(camera: &Camera) -> Self {
        let Camera { fx, fy, cx, cy, distortion: [k1, k2, p1, p2, k3], width_px, height_px } = *camera;
        Self { fx, fy, cx, cy, k1, k2, p1, p2, k3, width_px, height_px }
    }
}

/// The surveys of exemplars by their ids, of those that have any.
pub type Surveys = BTreeMap<String, Survey>;

/// Memory that they take, about.
pub fn bytes_of(surveys: &Surveys) -> u64 {
    let id_and_map = 2 * 36;
    (surveys.len() * (size_of::<(String, Survey)>() + id_and_map)) as u64
}

/// Those of these exemplars.
///
/// # Errors
/// [`DatabaseError::UnreadableSurvey`].
pub fn surveys_of(rows: &[ExemplarRow]) -> Result<Surveys, DatabaseError> {
    let surveyed = rows.iter().filter(|row| row.survey.is_some());
    surveyed.map(|row| Ok((row.id.to_string(), Survey::of(row)?))).collect()
}

/// Where an exemplar was taken, with which camera, and how large it is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Survey {
    /// Of the camera's body; with `size_mm` of the flat thing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<MapPoseDocument>,
    /// The camera that took the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraDocument>,
    /// Width of the picture on the plane that it shows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_mm: Option<f64>,
}

impl Survey {
    /// Whether its numbers can be.
    pub fn is_sound(&self) -> bool {
        self.pose.as_ref().is_none_or(|pose| pose.faults().is_empty())
            && self.camera.as_ref().is_none_or(|camera| Camera::from(camera).faults().is_empty())
            && self.size_mm.is_none_or(is_size)
    }

    /// The survey of an exemplar; empty where it has none.
    ///
    /// # Errors
    /// [`DatabaseError::UnreadableSurvey`]: a newer release wrote it, or it was changed by hand.
    pub fn of(row: &ExemplarRow) -> Result<Self, DatabaseError> {
        let Some(text) = &row.survey else { return Ok(Self::default()) };
        serde_json::from_str(text)
            .map_err(|source| DatabaseError::UnreadableSurvey { exemplar: row.id.to_string(), source })
    }

    /// This survey; what it doesn't say is taken from `other`.
    pub fn over(self, other: Self) -> Self {
        Self {
            pose: self.pose.or(other.pose),
            camera: self.camera.or(other.camera),
            size_mm: self.size_mm.or(other.size_mm),
        }
    }

    /// The text that is kept; none of an empty one.
    pub fn to_document(&self) -> Option<String> {
        let is_empty = *self == Self::default();
        (!is_empty).then(|| serde_json::to_string(self).expect("numbers and text always serialise"))
    }
}

/// Whether it is the width of a picture on the plane that it shows, in mm.
pub fn is_size(size_mm: f64) -> bool {
    size_mm > 0.0 && size_mm <= 1e6
}

impl Databases {
    /// Changes the survey of an exemplar; `change` is called again if somebody else changed it meanwhile. It is in force from
    /// the next training on.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownExemplar`], [`DatabaseError::UnreadableSurvey`].
    pub async fn change_survey(
        &self,
        database: &Name,
        id: Uuid,
        change: impl Fn(Survey) -> Survey,
    ) -> Result<ExemplarRow, DatabaseError> {
        loop {
            let row = self.exemplar(database, id).await?;
            let text = change(Survey::of(&row)?).to_document();
            if text == row.survey {
                return Ok(row);
            }
            let (before, after) = (row.survey.as_deref(), text.as_deref());
            let changed = self.catalogue.change_exemplar_survey(database.as_str(), id, before, after).await?;
            if let Some(changed) = changed {
                return Ok(changed);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_reads_back_and_an_empty_one_is_none() {
        let survey = Survey {
            pose: Some(MapPoseDocument {
                map: Name::parse("hall").unwrap(),
                x_m: 1.5,
                y_m: -2.0,
                z_m: 0.0,
                yaw_deg: 90.0,
                pitch_deg: 0.0,
                roll_deg: 0.0,
                sigma_m: 0.05,
            }),
            camera: None,
            size_mm: Some(210.0),
        };
        let text = survey.to_document().unwrap();
        assert_eq!(serde_json::from_str::<Survey>(&text).unwrap(), survey);
        assert_eq!(Survey::default().to_document(), None);
    }

    #[test]
    fn members_of_a_pose_that_cannot_be_are_named() {
        let text = r#"{"map": "m", "x_m": 1e9, "y_m": 0, "yaw_deg": 720, "sigma_m": 0}"#;
        let pose: MapPoseDocument = serde_json::from_str(text).unwrap();
        let names: Vec<_> = pose.faults().into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["x_m", "yaw_deg", "sigma_m"]);
    }
}
