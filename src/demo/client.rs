//! A client of the HTTP contract, as small as the demo needs.

use std::time::Duration;

use reqwest::multipart::{Form, Part};
use reqwest::{Method, RequestBuilder, Response, Url};
use serde_json::Value;
use tokio::time::{Instant, sleep};

use super::DemoError;
use super::lessons::Exemplar;

/// The longest that one call may take: a request's own limit at the service.
const PATIENCE: Duration = Duration::from_secs(60);
/// The longest that a training may take: pictures by the thousand train within minutes.
const TRAINING_PATIENCE: Duration = Duration::from_secs(900);
const POLL_EVERY: Duration = Duration::from_millis(100);

/// A running service.
pub struct Server {
    base_url: Url,
    http: reqwest::Client,
}

/// What a frame was taken for.
pub struct Answer {
    /// `None`: for nothing that is known, or not for sure enough.
    pub label: Option<String>,
    /// The chance that it is right, if the service says so.
    pub confidence: Option<f64>,
    /// What the service says the recognition took.
    pub recognise_ms: f64,
}

/// What a picture was taken for, as a whole.
pub struct ObjectAnswer {
    /// `None`: for nothing that is known.
    pub label: Option<String>,
    /// `None`: without an answer.
    pub pose: Option<AnsweredPose>,
}

/// How the service says that an object is turned.
#[derive(Clone, Copy)]
pub struct AnsweredPose {
    pub turn_deg: f64,
    pub sigma_deg: f64,
    pub reliable: bool,
}

/// What stands on a table.
pub struct Inspected {
    pub parts: Vec<InspectedPart>,
    /// What the service says that looking took.
    pub inspect_ms: f64,
}

/// A part on the table.
pub struct InspectedPart {
    /// The middle of its region, x and y.
    pub centroid_px: [f64; 2],
    /// Where the robot finds it, X and Y.
    pub robot_mm: Option<[f64; 2]>,
    pub answer: ObjectAnswer,
}

/// How far the gripper is off a part.
pub struct Centring {
    /// How it must move, X and Y.
    pub move_mm: [f64; 2],
    /// Whether it need not.
    pub centred: bool,
}

/// What a depth map is like in short.
pub struct DepthSummary {
    /// Part of the pixels that have a depth.
    pub coverage: f64,
    /// What the service says that measuring took.
    pub measure_ms: f64,
}

impl ObjectAnswer {
    fn of(answer: &Value) -> ObjectAnswer {
        let pose = answer["pose"]["turn_deg"].as_f64().map(|turn_deg| AnsweredPose {
            turn_deg,
            sigma_deg: answer["pose"]["sigma_deg"].as_f64().unwrap_or_default(),
            reliable: answer["pose"]["reliable"].as_bool().unwrap_or_default(),
        });
        ObjectAnswer { label: answer["decision"]["label"].as_str().map(str::to_owned), pose }
    }
}

/// A pair of numbers; `None` for anything else.
fn pair(value: &Value) -> Option<[f64; 2]> {
    Some([value[0].as_f64()?, value[1].as_f64()?])
}

impl Server {
    /// The service at an address such as `http://127.0.0.1:8080`; proxies of the environment are not asked.
    pub fn at(base_url: &str) -> Result<Server, DemoError> {
        let address = || DemoError::Address { base_url: base_url.to_owned() };
        let url: Url = base_url.parse().map_err(|_| address())?;
        if url.cannot_be_a_base() {
            return Err(address());
        }
        // One provider for the whole process; somebody else may have installed it.
        rustls::crypto::ring::default_provider().install_default().ok();
        let http = reqwest::Client::builder()
            .timeout(PATIENCE)
            .no_proxy()
            .tls_certs_only([])
            .build()
            .map_err(|source| DemoError::NoAnswer { call: base_url.to_owned(), source })?;
        Ok(Server { base_url: url, http })
    }

    /// Delete what has that path, if it is there.
    pub async fn forget(&self, path: &[&str]) -> Result<(), DemoError> {
        match self.send(self.call(Method::DELETE, path, &[])).await {
            Err(DemoError::Refused { status: 404, .. }) => Ok(()),
            answer => answer.map(drop),
        }
    }

    /// Create what is to have that path.
    pub async fn create(&self, path: &[&str], document: &Value) -> Result<(), DemoError> {
        self.send(self.call(Method::PUT, path, &[]).json(document)).await.map(drop)
    }

    /// Send one training image.
    pub async fn learn(&self, database: &str, exemplar: &Exemplar) -> Result<(), DemoError> {
        let pose_deg = exemplar.pose_deg.map(|pose_deg| pose_deg.to_string());
        let mut query = vec![("label", exemplar.label.as_str())];
        query.extend(pose_deg.as_deref().map(|pose_deg| ("pose_deg", pose_deg)));
        let call = self.call(Method::POST, &["databases", database, "exemplars"], &query);
        self.send(with_png(call, &exemplar.png)).await.map(drop)
    }

    /// Train as `wanted` says and wait for the end; returns the version.
    pub async fn train(&self, database: &str, wanted: &Value) -> Result<u64, DemoError> {
        let call = self.call(Method::POST, &["databases", database, "trainings"], &[]);
        let mut job = self.json(call.json(wanted)).await?;
        let id = job["id"].as_str().unwrap_or_default().to_owned();
        let started = Instant::now();
        loop {
            match job["state"].as_str() {
                Some("succeeded") => return Ok(job["version"].as_u64().unwrap_or_default()),
                Some("failed" | "cancelled") => {
                    let problem = job["problem"]["detail"].as_str().unwrap_or("it was cancelled");
                    return Err(DemoError::Training { detail: problem.to_owned() });
                }
                _ if started.elapsed() > TRAINING_PATIENCE => {
                    return Err(DemoError::Endless { job: id, waited_s: TRAINING_PATIENCE.as_secs() });
                }
                _ => sleep(POLL_EVERY).await,
            }
            job = self.json(self.call(Method::GET, &["jobs", &id], &[])).await?;
        }
    }

    /// What a version of landmarks takes a frame for.
    pub async fn ask(&self, database: &str, version: u64, png: &[u8]) -> Result<Answer, DemoError> {
        let answer = self.recognise(database, version, png).await?;
        let decision = &answer["decision"];
        Ok(Answer {
            label: decision["label"].as_str().map(str::to_owned),
            confidence: decision["confidence"].as_f64(),
            recognise_ms: answer["timings_ms"]["recognise"].as_f64().unwrap_or_default(),
        })
    }

    /// What a version of objects takes a picture for.
    pub async fn ask_object(
        &self,
        database: &str,
        version: u64,
        png: &[u8],
    ) -> Result<ObjectAnswer, DemoError> {
        Ok(ObjectAnswer::of(&self.recognise(database, version, png).await?))
    }

    async fn recognise(&self, database: &str, version: u64, png: &[u8]) -> Result<Value, DemoError> {
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

    /// What stands on a table, by a version of the workcell's database.
    pub async fn inspect(&self, workcell: &str, version: u64, png: &[u8]) -> Result<Inspected, DemoError> {
        let version = version.to_string();
        let answer = self.json(self.inspection(workcell, &[("version", &version)], png)).await?;
        let part = |object: &Value| InspectedPart {
            centroid_px: pair(&object["region"]["centroid_px"]).unwrap_or_default(),
            robot_mm: pair(&object["robot_mm"]),
            answer: ObjectAnswer::of(object),
        };
        Ok(Inspected {
            parts: answer["objects"].as_array().into_iter().flatten().map(part).collect(),
            inspect_ms: answer["timings_ms"]["total"].as_f64().unwrap_or_default(),
        })
    }

    /// The table with what is said of every part drawn on it, a PNG.
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
        let answer = self.json(with_png(call, png)).await?;
        Ok(Centring {
            move_mm: pair(&answer["move_mm"]).unwrap_or_default(),
            centred: answer["centred"].as_bool().unwrap_or_default(),
        })
    }

    /// What the depth map of a near- and a far-focused picture is like.
    pub async fn depth_summary(&self, pair: &[Vec<u8>; 2], optics: &str) -> Result<DepthSummary, DemoError> {
        let summary = self.json(self.depth_call(pair, optics)).await?;
        Ok(DepthSummary {
            coverage: summary["coverage"].as_f64().unwrap_or_default(),
            measure_ms: summary["timings_ms"]["total"].as_f64().unwrap_or_default(),
        })
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

    async fn json(&self, call: RequestBuilder) -> Result<Value, DemoError> {
        let answer = self.send(call).await?;
        let call = answer.url().to_string();
        answer.json().await.map_err(|source| DemoError::NoAnswer { call, source })
    }

    /// Send; an answer that isn't a success becomes an error with the problem's own words.
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
