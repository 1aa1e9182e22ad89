//! Where a frame was taken, in metres: what the surveys of a version's exemplars make of a recognition.

use serde::Serialize;
use utoipa::ToSchema;

use crate::database::survey::CameraDocument;
use crate::database::survey::{Survey, Surveys};
use crate::http::problem::Problem;
use crate::http::surveys::camera_for;
use landmarkd_core::geometry::{Camera, MapPose};
use landmarkd_core::imaging::{Frame, Header};
use landmarkd_core::localisation::{PlaceMethod, PlaceView, locate};
use landmarkd_core::recognition::landmarks::{AgreeingExemplar, AskedFrame, Landmarks, Recognition};

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
        let is_turned = (frame.width() > frame.height()) != (stored.0 > stored.1);
        let size_px = if is_turned { (stored.1, stored.0) } else { stored };
        let camera = camera.map(|camera| camera_for(camera, size_px, "#camera")).transpose()?;
        Ok(Self { surveys, camera })
    }

    /// Whether frames are located.
    pub fn has_poses(&self) -> bool {
        self.surveys.values().any(|survey| survey.pose.is_some())
    }

    /// Where the frame was taken; none where the exemplars that agree don't tell.
    pub fn pose(
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
