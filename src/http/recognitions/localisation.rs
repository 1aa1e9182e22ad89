//! Where a frame was taken, in metres: what the surveys of a version's exemplars make of a recognition.

use serde::Serialize;
use utoipa::ToSchema;

use crate::database::survey::CameraDocument;
use crate::database::survey::{Survey, Surveys};
use crate::http::problem::Problem;
use crate::http::surveys::camera_for;
use landmarkd_core::geometry::{Camera, MapPose};
use landmarkd_core::imaging::{Frame, Header};
use landmarkd_core::localisation::{PlaceMethod, PlaceView, PlanarPose, PlanarPoses, locate, located};
use landmarkd_core::recognition::landmarks::{
    AgreeingExemplar, AskedFrame, Landmarks, Recognition, VerifiedPlacement,
};

/// Where the camera is, on the plane of a map.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct PlacePoseBody {
    /// The map of the exemplars that it rests on.
    pub map: String,
    pub x_m: f64,
    pub y_m: f64,
    /// Heading, counter-clockwise from the map's x axis, in (-180, 180].
    pub yaw_deg: f64,
    /// Of x, y and heading, row by row; in m and rad, as ROS has it.
    pub covariance: [f64; 9],
    /// How it was found. `exemplars`: the mean of those that agree. `bearing`: heading by the points in common with one exemplar,
    /// whose place it is to within metres. `triangulation`: by the points in common with several. `flat_landmark`: by something
    /// flat of known size. `track`: by all frames of a track.
    pub method: &'static str,
    /// Ids of the exemplars that it rests on.
    pub support: Vec<String>,
    /// Of a track: whether it is better not relied on. Frames contradict each other, or tell of several places.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(required = false)]
    pub lost: Option<bool>,
}

/// Where something flat is before the camera.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct LandmarkPoseBody {
    /// From the camera to the middle of the exemplar's picture, in the camera's optical frame: x right, y down, z forward.
    pub translation_m: [f64; 3],
    /// x, y, z, w: from the landmark's frame (x along its normal towards who looks at it, z up) to the optical frame.
    pub quaternion: [f64; 4],
    /// Of the translation (m) and of a rotation after that of the quaternion (rad), in the optical frame; row by row.
    #[schema(min_items = 36, max_items = 36)]
    pub covariance: Vec<f64>,
    /// Root mean square of how far its edges are from where they are seen.
    pub error_px: f64,
}

impl From<&PlanarPose> for LandmarkPoseBody {
    fn from(pose: &PlanarPose) -> Self {
        Self {
            translation_m: pose.camera_landmark.translation_m.to_array(),
            quaternion: pose.camera_landmark.rotation.to_array(),
            covariance: pose.covariance.as_flattened().to_vec(),
            error_px: pose.error_px,
        }
    }
}

/// What is known beside the pictures.
pub struct Surveyed<'a> {
    surveys: &'a Surveys,
    /// The frame's, at its size as posted.
    camera: Option<Camera>,
}

impl<'a> Surveyed<'a> {
    /// For a frame with that header, decoded.
    ///
    /// # Errors
    /// The camera is one of frames of another shape.
    pub fn of(
        surveys: &'a Surveys,
        camera: Option<&CameraDocument>,
        header: &Header,
        frame: &Frame,
    ) -> Result<Self, Problem> {
        let stored = (header.width_px, header.height_px);
        // a file that lies on its side was turned when it was decoded
        let part = |(width, height): (u32, u32)| (f64::from(width) / f64::from(height)).ln();
        let shown = (frame.width() as f64 / frame.height() as f64).ln();
        let is_turned = (shown - part(stored)).abs() > (shown + part(stored)).abs() + 1e-9;
        let size_px = if is_turned { (stored.1, stored.0) } else { stored };
        let camera = camera.map(|camera| camera_for(camera, size_px, "#camera")).transpose()?;
        Ok(Self { surveys, camera })
    }

    /// Whether frames are located.
    pub fn has_poses(&self) -> bool {
        self.surveys.values().any(|survey| survey.pose.is_some())
    }

    /// Whether frames are located by where exemplars were taken.
    pub fn has_places(&self) -> bool {
        self.surveys.values().any(|survey| survey.pose.is_some() && survey.size_mm.is_none())
    }

    /// Where something flat that was placed on the frame is before the camera; none where its size or the camera isn't known.
    pub fn plane(&self, model: &Landmarks, placed: &VerifiedPlacement, frame: &Frame) -> Option<PlanarPoses> {
        let size_mm = self.surveys.get(&model.exemplars()[placed.exemplar].id)?.size_mm?;
        located(model, placed, size_mm, frame, self.camera.as_ref()?)
    }

    /// Where the frame was taken: by something flat, or by where the exemplars that agree were taken, whichever tells better.
    pub fn pose(
        &self,
        model: &Landmarks,
        recognition: &Recognition,
        asked: Option<&AskedFrame<'_>>,
        frame: &Frame,
    ) -> Option<PlacePoseBody> {
        let placed = recognition.instances.iter().map(|instance| instance.verified);
        let flat = placed.filter_map(|placed| self.pose_by_plane(model, &placed, frame));
        let place = asked.and_then(|asked| self.pose_by_places(model, recognition, asked));
        let spread = |pose: &PlacePoseBody| pose.covariance[0] + pose.covariance[4];
        flat.chain(place).min_by(|a, b| spread(a).total_cmp(&spread(b)))
    }

    fn pose_by_plane(
        &self,
        model: &Landmarks,
        placed: &VerifiedPlacement,
        frame: &Frame,
    ) -> Option<PlacePoseBody> {
        let id = &model.exemplars()[placed.exemplar].id;
        let landmark = self.surveys.get(id)?.pose.as_ref()?;
        let found = self.plane(model, placed, frame).filter(|found| !found.ambiguous)?;
        let place = found.pose.camera_on_plane(&MapPose::from(landmark), landmark.sigma_m);
        Some(PlacePoseBody {
            map: landmark.map.to_string(),
            x_m: place.x_m,
            y_m: place.y_m,
            yaw_deg: place.yaw_deg,
            covariance: flat(&place.covariance),
            method: "flat_landmark",
            support: vec![id.clone()],
            lost: None,
        })
    }

    fn pose_by_places(
        &self,
        model: &Landmarks,
        recognition: &Recognition,
        asked: &AskedFrame<'_>,
    ) -> Option<PlacePoseBody> {
        let survey = |agreeing: &AgreeingExemplar| self.surveys.get(&model.exemplars()[agreeing.exemplar].id);
        let posed = recognition.agreeing.iter().filter_map(|agreeing| {
            let Survey { pose: Some(pose), camera, size_mm: None } = survey(agreeing)? else { return None };
            Some((agreeing, pose, camera))
        });
        let posed: Vec<_> = posed.collect();
        // Poses of different maps say nothing of each other: that of the likeliest exemplar counts.
        let map = posed.first().map(|(_, pose, _)| &pose.map)?;
        let posed: Vec<_> = posed.iter().filter(|(_, pose, _)| pose.map == *map).collect();
        let exemplars: Vec<usize> = posed.iter().map(|(agreeing, ..)| agreeing.exemplar).collect();
        let pairs = match self.camera {
            Some(_) => model.correspondences(asked, &exemplars),
            None => vec![Vec::new(); exemplars.len()],
        };
        let views = posed.iter().zip(&pairs).map(|((agreeing, pose, camera), pairs)| {
            let taught = &model.exemplars()[agreeing.exemplar];
            let camera = camera.as_ref().map(Camera::from);
            PlaceView {
                pose: MapPose::from(*pose),
                sigma_m: pose.sigma_m,
                camera: camera.and_then(|camera| camera.resized(taught.width_px, taught.height_px)),
                evidence: -agreeing.a_contrario.log10_false_alarms,
                correspondences: pairs,
            }
        });
        let found = locate(&views.collect::<Vec<_>>(), self.camera.as_ref())?;
        let method = match found.method {
            PlaceMethod::Exemplars => "exemplars",
            PlaceMethod::Bearing => "bearing",
            PlaceMethod::Triangulation => "triangulation",
        };
        let id = |view: &usize| model.exemplars()[exemplars[*view]].id.clone();
        Some(PlacePoseBody {
            map: map.to_string(),
            x_m: found.x_m,
            y_m: found.y_m,
            yaw_deg: found.yaw_deg,
            covariance: flat(&found.covariance),
            method,
            support: found.support.iter().map(id).collect(),
            lost: None,
        })
    }
}

/// Row by row.
pub fn flat(covariance: &[[f64; 3]; 3]) -> [f64; 9] {
    std::array::from_fn(|i| covariance[i / 3][i % 3])
}
