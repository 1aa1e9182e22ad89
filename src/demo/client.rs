//! A client of the HTTP contract, as small as the demo needs.

use std::time::Duration;

use reqwest::multipart::{Form, Part};
use reqwest::{Method, RequestBuilder, Response, Url};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tokio::time::{Instant, sleep};

use super::DemoError;
use super::data_sets::Exemplar;

/// The longest that one call may take: a request's own limit at the service.
const CALL_TIMEOUT: Duration = Duration::from_secs(60);
/// The longest that a training may take: thousands of pictures train within minutes.
const TRAINING_TIMEOUT: Duration = Duration::from_secs(900);
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A running service.
pub struct Server {
    base_url: Url,
    http: reqwest::Client,
}

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

/// A job as far as the demo follows it.
#[derive(Deserialize)]
struct Job {
    id: String,
    state: String,
    version: Option<u64>,
    problem: Option<Value>,
}

impl Server {
    /// The service at an address such as `http://127.0.0.1:8080`; proxies of the environment are not asked.
    pub fn at(base_url: &str) -> Result<Server, DemoError> {
        let address = || DemoError::Address { base_url: base_url.to_owned() };
        let url: Url = base_url.parse().map_err(|_| address())?;
        if url.cannot_be_a_base() {
            return Err(address());
        }
        // One provider for the whole process; another part of it may have installed it.
        rustls::crypto::ring::default_provider().install_default().ok();
        let http = reqwest::Client::builder()
            .timeout(CALL_TIMEOUT)
            .no_proxy()
            .tls_certs_only([])
            .build()
            .map_err(|source| DemoError::NoAnswer { call: base_url.to_owned(), source })?;
        Ok(Server { base_url: url, http })
    }

    /// Deletes what has that path, if it is there.
    pub async fn delete(&self, path: &[&str]) -> Result<(), DemoError> {
        match self.send(self.call(Method::DELETE, path, &[])).await {
            Err(DemoError::Refused { status: 404, .. }) => Ok(()),
            answer => answer.map(drop),
        }
    }

    /// Creates what is to have that path.
    pub async fn create(&self, path: &[&str], document: &Value) -> Result<(), DemoError> {
        self.send(self.call(Method::PUT, path, &[]).json(document)).await.map(drop)
    }

    /// Adds a training picture to a database.
    pub async fn add_exemplar(&self, database: &str, exemplar: &Exemplar) -> Result<(), DemoError> {
        let pose_deg = exemplar.pose_deg.map(|pose_deg| pose_deg.to_string());
        let mut query = vec![("label", exemplar.label.as_str())];
        query.extend(pose_deg.as_deref().map(|pose_deg| ("pose_deg", pose_deg)));
        let call = self.call(Method::POST, &["databases", database, "exemplars"], &query);
        self.send(with_png(call, &exemplar.png)).await.map(drop)
    }

    /// Trains with a request's document and waits for the end; returns the version.
    pub async fn train(&self, database: &str, document: &Value) -> Result<u64, DemoError> {
        let call = self.call(Method::POST, &["databases", database, "trainings"], &[]);
        let mut job: Job = self.json(call.json(document)).await?;
        let started = Instant::now();
        loop {
            match job.state.as_str() {
                "succeeded" => return Ok(job.version.unwrap_or_default()),
                "failed" | "cancelled" => {
                    let problem = job.problem.unwrap_or_default();
                    let detail = problem["detail"].as_str().unwrap_or("it was cancelled").to_owned();
                    return Err(DemoError::Training { detail });
                }
                _ if started.elapsed() > TRAINING_TIMEOUT => {
                    return Err(DemoError::Endless { job: job.id, waited_s: TRAINING_TIMEOUT.as_secs() });
                }
                _ => sleep(POLL_INTERVAL).await,
            }
            job = self.json(self.call(Method::GET, &["jobs", &job.id], &[])).await?;
        }
    }

    /// What a version recognises in a frame.
    pub async fn recognise(
        &self,
        database: &str,
        version: u64,
        png: &[u8],
    ) -> Result<Recognition, DemoError> {
        let version = version.to_string();
        let path = ["databases", database, "recognitions"];
        let call = self.call(Method::POST, &path, &[("version", &version), ("top", "1")]);
        self.json(with_png(call, png)).await
    }

    /// The frame with the evidence drawn on it, a PNG.
    pub async fn annotated(&self, database: &str, png: &[u8]) -> Result<Vec<u8>, DemoError> {
        let call = self.call(Method::POST, &["databases", database, "recognitions"], &[]);
        self.bytes(with_png(call, png).header("Accept", "image/png")).await
    }

    /// What lies on a table, by a version of the workcell's database.
    pub async fn inspect(&self, workcell: &str, version: u64, png: &[u8]) -> Result<Inspection, DemoError> {
        self.json(self.inspection(workcell, &[("version", &version.to_string())], png)).await
    }

    /// The table with the answer about every part drawn on it, a PNG.
    pub async fn inspection_annotated(&self, workcell: &str, png: &[u8]) -> Result<Vec<u8>, DemoError> {
        self.bytes(self.inspection(workcell, &[], png).header("Accept", "image/png")).await
    }

    fn inspection(&self, workcell: &str, query: &[(&str, &str)], png: &[u8]) -> RequestBuilder {
        let form = Form::new().part("overview", Part::bytes(png.to_vec()).file_name("overview.png"));
        self.call(Method::POST, &["workcells", workcell, "inspections"], query).multipart(form)
    }

    /// The regions of a picture as a picture of a media type.
    pub async fn regions(&self, png: &[u8], media_type: &str) -> Result<Vec<u8>, DemoError> {
        let call = self.call(Method::POST, &["segmentations"], &[]);
        self.bytes(with_png(call, png).header("Accept", media_type)).await
    }

    /// How far off a part the camera at the gripper is.
    pub async fn centre(&self, workcell: &str, png: &[u8]) -> Result<Centring, DemoError> {
        let call = self.call(Method::POST, &["workcells", workcell, "centrings"], &[]);
        self.json(with_png(call, png)).await
    }

    /// The summary of the depth map of a near- and a far-focused picture.
    pub async fn depth_summary(&self, pair: &[Vec<u8>; 2], optics: &str) -> Result<DepthSummary, DemoError> {
        self.json(self.depth_call(pair, optics)).await
    }

    /// The depth map as a file of a media type.
    pub async fn depth_map(
        &self,
        pair: &[Vec<u8>; 2],
        optics: &str,
        media_type: &str,
    ) -> Result<Vec<u8>, DemoError> {
        self.bytes(self.depth_call(pair, optics).header("Accept", media_type)).await
    }

    fn depth_call(&self, [near, far]: &[Vec<u8>; 2], optics: &str) -> RequestBuilder {
        let file = |name: &str, png: &[u8]| Part::bytes(png.to_vec()).file_name(format!("{name}.png"));
        let form = Form::new().part("near", file("near", near)).part("far", file("far", far));
        self.call(Method::POST, &["depth-maps"], &[]).multipart(form.text("optics", optics.to_owned()))
    }

    /// A call to `/v1/…`; names are escaped.
    fn call(&self, method: Method, path: &[&str], query: &[(&str, &str)]) -> RequestBuilder {
        let mut url = self.base_url.clone();
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.pop_if_empty().push("v1").extend(path);
        }
        if !query.is_empty() {
            url.query_pairs_mut().extend_pairs(query);
        }
        self.http.request(method, url)
    }

    async fn bytes(&self, call: RequestBuilder) -> Result<Vec<u8>, DemoError> {
        let answer = self.send(call).await?;
        let call = answer.url().to_string();
        let bytes = answer.bytes().await.map_err(|source| DemoError::NoAnswer { call, source })?;
        Ok(bytes.to_vec())
    }

    async fn json<T: DeserializeOwned>(&self, call: RequestBuilder) -> Result<T, DemoError> {
        let answer = self.send(call).await?;
        let call = answer.url().to_string();
        answer.json().await.map_err(|source| DemoError::NoAnswer { call, source })
    }

    /// Sends; an answer that isn't a success becomes an error with the problem's detail.
    async fn send(&self, call: RequestBuilder) -> Result<Response, DemoError> {
        let answer = call.send().await.map_err(|source| DemoError::NoAnswer {
            call: source.url().map_or_else(String::new, Url::to_string),
            source: source.without_url(),
        })?;
        let (status, call) = (answer.status(), answer.url().to_string());
        if status.is_success() {
            return Ok(answer);
        }
        let problem: Value = answer.json().await.unwrap_or_default();
        let detail = problem["detail"].as_str().unwrap_or("without a reason").to_owned();
        Err(DemoError::Refused { call, status: status.as_u16(), detail })
    }
}

fn with_png(call: RequestBuilder, png: &[u8]) -> RequestBuilder {
    call.header("Content-Type", "image/png").body(png.to_vec())
}
