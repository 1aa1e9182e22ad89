//! The service under load: a process with a trained database, and what is asked of it.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use bytes::Bytes;
use landmarkd_core::imaging::{Frame, Image};
use reqwest::{Client, Method};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::client;
use crate::pictures::{SIDE_PX, jpeg, png, scene};
use crate::process::Process;

/// Longer than any training here.
const PATIENCE: Duration = Duration::from_secs(120);

pub struct Service {
    pub process: Process,
    client: Client,
    _folder: TempDir,
}

impl Service {
    /// Start it over an empty folder, with more said on the command line.
    pub fn start(arguments: &[&str]) -> Self {
        rustls::crypto::ring::default_provider().install_default().ok();
        let folder = tempfile::tempdir().unwrap();
        let say = |command: &mut Command| {
            command.args(arguments);
        };
        let process = Process::start_with(Path::new(folder.path()), say);
        let client = Client::builder().no_proxy().timeout(PATIENCE).build().unwrap();
        Self { process, client, _folder: folder }
    }

    pub async fn send(&self, method: Method, path: &str, body: Option<&Value>) -> Value {
        let mut request = self.client.request(method, format!("{}{path}", self.process.url));
        if let Some(body) = body {
            request = request.json(body);
        }
        let answer = request.send().await.unwrap();
        let status = answer.status();
        let text = answer.text().await.unwrap();
        assert!(status.is_success(), "{path}: {status} {text}");
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// A database of these options with a picture a label, not yet trained.
    pub async fn taught(&self, database: &str, options: Value, pictures: &[Bytes]) {
        let path = format!("/v1/databases/{database}");
        self.send(Method::PUT, &path, Some(&json!({"kind": "landmarks", "options": options}))).await;
        for (number, picture) in pictures.iter().enumerate() {
            self.add(database, &format!("place-{number}"), picture).await;
        }
    }

    /// Add a training image.
    pub async fn add(&self, database: &str, label: &str, picture: &Bytes) {
        let url = format!("{}/v1/databases/{database}/exemplars?label={label}", self.process.url);
        self.client.post(url).body(picture.clone()).send().await.unwrap().error_for_status().unwrap();
    }

    /// Queue a training; the job's path.
    pub async fn begin_training(&self, database: &str, options: Value) -> String {
        let path = format!("/v1/databases/{database}/trainings");
        let job = self.send(Method::POST, &path, Some(&options)).await;
        format!("/v1/jobs/{}", job["id"].as_str().unwrap())
    }

    /// Train and wait for the version.
    pub async fn train(&self, database: &str, options: Value) {
        let job = self.begin_training(database, options).await;
        let begun = Instant::now();
        loop {
            let now = self.send(Method::GET, &job, None).await;
            match now["state"].as_str() {
                Some("succeeded") => return,
                Some("queued" | "running") if begun.elapsed() < PATIENCE => {}
                _ => panic!("{now:#}"),
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

/// A recognition as it goes over the wire.
pub fn recognition(database: &str, picture: &[u8]) -> Vec<u8> {
    client::request("POST", &format!("/v1/databases/{database}/recognitions"), "image/jpeg", picture)
}

/// What is asked when nothing is to be computed.
pub fn livez() -> Vec<u8> {
    client::request("GET", "/livez", "text/plain", b"")
}

/// Options of tiny pictures that are recognised in a moment.
pub fn tiny() -> Value {
    json!({"method": "paper", "interest_points": 16, "query_points": 24, "rings": 4, "sectors": 16, "dimension": 8})
}

/// Tiny pictures.
pub fn tiny_pictures(count: u64) -> Vec<Bytes> {
    (1..=count).map(|number| png(&scene(number))).collect()
}

/// A picture with more to it, 168 pixels a side: three by three scenes side by side.
pub fn room(number: u64) -> Bytes {
    side_by_side(3, number * 100)
}

/// A picture with much to it, 448 pixels a side.
pub fn hall(number: u64) -> Bytes {
    side_by_side(8, number * 100)
}

/// So many times as many scenes, from a number on.
fn side_by_side(scenes_a_side: usize, first: u64) -> Bytes {
    let scenes: Vec<Frame> = (0..scenes_a_side * scenes_a_side).map(|at| scene(first + at as u64)).collect();
    let side = scenes_a_side * SIDE_PX;
    let gray = Image::from_fn(side, side, |x, y| {
        let scene = &scenes[y / SIDE_PX * scenes_a_side + x / SIDE_PX];
        scene.luminance.pixels()[y % SIDE_PX * SIDE_PX + x % SIDE_PX]
    });
    jpeg(&Frame::gray(gray))
}
