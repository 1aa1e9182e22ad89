//! What the demo asks a service, and what it reads of the answers.

use reqwest::multipart::{Form, Part};
use reqwest::{Method, RequestBuilder};
use serde::Deserialize;

use super::DemoError;
use super::data_sets::Exemplar;
use crate::client::Server;

/// What a frame, or a part on a table, was recognised as.
#[derive(Default, Deserialize)]
pub struct Recognition {
    /// `None`: unknown, or not sure enough.
    pub decision: Option<Decision>,
    /// `None`: landmarks, unknown, or without a pose.
    pub pose: Option<AnsweredPose>,
    #[serde(default)]
    pub timings_ms: Timings,
}

/// The label that was decided for.
#[derive(Deserialize)]
pub struct Decision {
    pub label: String,
    /// The chance that it is right, if the version is calibrated.
    pub confidence: Option<f64>,
}

/// How an object is turned, by the answer.
#[derive(Clone, Copy, Deserialize)]
pub struct AnsweredPose {
    pub turn_deg: f64,
    pub sigma_deg: f64,
    pub reliable: bool,
}

/// Milliseconds that the service measured.
#[derive(Default, Deserialize)]
pub struct Timings {
    /// Of a recognition, without decoding.
    #[serde(default)]
    pub recognise: f64,
    /// Of a depth map or an inspection.
    #[serde(default)]
    pub total: f64,
}

impl Recognition {
    /// The label decided for; `None`: unknown.
    pub fn label(&self) -> Option<&str> {
        self.decision.as_ref().map(|decision| decision.label.as_str())
    }
}

/// What an inspection found on a table.
#[derive(Deserialize)]
pub struct Inspection {
    pub objects: Vec<InspectedPart>,
    pub timings_ms: Timings,
}

/// A part on the table.
#[derive(Deserialize)]
pub struct InspectedPart {
    pub region: Region,
    /// Where the robot finds it, X and Y.
    pub robot_mm: Option<[f64; 2]>,
    #[serde(flatten)]
    pub recognition: Recognition,
}

/// The region of a part.
#[derive(Deserialize)]
pub struct Region {
    /// x and y.
    pub centroid_px: [f64; 2],
}

/// How far the gripper is off a part.
#[derive(Deserialize)]
pub struct Centring {
    /// How it must move, X and Y.
    pub move_mm: [f64; 2],
    /// Whether it need not.
    pub centred: bool,
}

/// The summary of a depth map.
#[derive(Deserialize)]
pub struct DepthSummary {
    /// Part of the pixels that have a depth.
    pub coverage: f64,
    pub timings_ms: Timings,
}

impl Server {
    /// Adds a training picture to a database.
    pub(super) async fn add_exemplar(&self, database: &str, exemplar: &Exemplar) -> Result<(), DemoError> {
        let pose_deg = exemplar.pose_deg.map(|pose_deg| pose_deg.to_string());
        let mut query = vec![("label", exemplar.label.as_str())];
        query.extend(pose_deg.as_deref().map(|pose_deg| ("pose_deg", pose_deg)));
        let call = self.call(Method::POST, &["databases", database, "exemplars"], &query);
        Ok(self.send(with_png(call, &exemplar.png)).await.map(drop)?)
    }

    /// What a version recognises in a frame.
    pub(super) async fn recognise(
        &self,
        database: &str,
        version: u64,
        png: &[u8],
    ) -> Result<Recognition, DemoError> {
        let version = version.to_string();
        let path = ["databases", database, "recognitions"];
        let call = self.call(Method::POST, &path, &[("version", &version), ("top", "1")]);
        Ok(self.json(with_png(call, png)).await?)
    }

    /// The frame with the evidence drawn on it, a PNG.
    pub(super) async fn annotated(&self, database: &str, png: &[u8]) -> Result<Vec<u8>, DemoError> {
        let call = self.call(Method::POST, &["databases", database, "recognitions"], &[]);
        Ok(self.bytes(with_png(call, png).header("Accept", "image/png")).await?)
    }

    /// What lies on a table, by a version of the workcell's database.
    pub(super) async fn inspect(
        &self,
        workcell: &str,
        version: u64,
        png: &[u8],
    ) -> Result<Inspection, DemoError> {
        Ok(self.json(self.inspection(workcell, &[("version", &version.to_string())], png)).await?)
    }

    /// The table with the answer about every part drawn on it, a PNG.
    pub(super) async fn inspection_annotated(
        &self,
        workcell: &str,
        png: &[u8],
    ) -> Result<Vec<u8>, DemoError> {
        Ok(self.bytes(self.inspection(workcell, &[], png).header("Accept", "image/png")).await?)
    }

    fn inspection(&self, workcell: &str, query: &[(&str, &str)], png: &[u8]) -> RequestBuilder {
        let form = Form::new().part("overview", Part::bytes(png.to_vec()).file_name("overview.png"));
        self.call(Method::POST, &["workcells", workcell, "inspections"], query).multipart(form)
    }

    /// The regions of a picture as a picture of a media type.
    pub(super) async fn regions(&self, png: &[u8], media_type: &str) -> Result<Vec<u8>, DemoError> {
        let call = self.call(Method::POST, &["segmentations"], &[]);
        Ok(self.bytes(with_png(call, png).header("Accept", media_type)).await?)
    }

    /// How far off a part the camera at the gripper is.
    pub(super) async fn centre(&self, workcell: &str, png: &[u8]) -> Result<Centring, DemoError> {
        let call = self.call(Method::POST, &["workcells", workcell, "centrings"], &[]);
        Ok(self.json(with_png(call, png)).await?)
    }

    /// The summary of the depth map of a near- and a far-focused picture.
    pub(super) async fn depth_summary(
        &self,
        pair: &[Vec<u8>; 2],
        optics: &str,
    ) -> Result<DepthSummary, DemoError> {
        Ok(self.json(self.depth_call(pair, optics)).await?)
    }

    /// The depth map as a file of a media type.
    pub(super) async fn depth_map(
        &self,
        pair: &[Vec<u8>; 2],
        optics: &str,
        media_type: &str,
    ) -> Result<Vec<u8>, DemoError> {
        Ok(self.bytes(self.depth_call(pair, optics).header("Accept", media_type)).await?)
    }

    fn depth_call(&self, [near, far]: &[Vec<u8>; 2], optics: &str) -> RequestBuilder {
        let file = |name: &str, png: &[u8]| Part::bytes(png.to_vec()).file_name(format!("{name}.png"));
        let form = Form::new().part("near", file("near", near)).part("far", file("far", far));
        self.call(Method::POST, &["depth-maps"], &[]).multipart(form.text("optics", optics.to_owned()))
    }
}

fn with_png(call: RequestBuilder, png: &[u8]) -> RequestBuilder {
    call.header("Content-Type", "image/png").body(png.to_vec())
}
