//! A fleet under test: what its processes share, the processes, and a client.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use bytes::Bytes;
use landmarkd_core::statistics::median;
use reqwest::header::{AUTHORIZATION, HeaderMap};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::bucket::Bucket;
use crate::pictures::{png, scene};
use crate::postgres::Cluster;
use crate::process::{Process, landmarkd};

/// Longer than any wait of a test should be.
const PATIENCE: Duration = Duration::from_secs(120);

/// What processes share; each gets a data folder of its own.
pub struct Fleet {
    pub cluster: Cluster,
    catalogue: String,
    pub bucket: Bucket,
    folders: TempDir,
    started: AtomicUsize,
}

impl Fleet {
    pub fn new() -> Self {
        let cluster = Cluster::start_new();
        Self {
            catalogue: cluster.create_database(),
            cluster,
            bucket: Bucket::new(),
            folders: tempfile::tempdir().unwrap(),
            started: AtomicUsize::new(0),
        }
    }

    /// Change rows behind the processes' backs.
    pub fn change_catalogue(&self, statements: &str) {
        self.cluster.sql(&self.catalogue, statements);
    }

    /// Transactions that the catalogue has committed.
    pub fn transactions(&self) -> f64 {
        let asked = "SELECT xact_commit FROM pg_stat_database WHERE datname = current_database()";
        self.cluster.sql(&self.catalogue, asked).parse().expect("a number")
    }

    /// Make a key at the command line; its text.
    pub fn key(&self, name: &str, scope: &str) -> String {
        let done = landmarkd()
            .args(["keys", "create", "--name", name, "--scope", scope, "--catalogue", &self.catalogue])
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        String::from_utf8(done.stdout).unwrap().trim().to_owned()
    }

    /// One more process, listening.
    pub fn process(&self, arguments: &[&str]) -> Member {
        let number = self.started.fetch_add(1, Ordering::Relaxed);
        let folder = self.folders.path().join(format!("process-{number}"));
        let process = Process::start_with(&folder, |command| {
            command
                .args(["--catalogue", &self.catalogue, "--blobs", &self.bucket.location()])
                .args(arguments)
                .env("AWS_ENDPOINT_URL", self.bucket.endpoint())
                .env("AWS_REGION", "us-east-1")
                .env("AWS_ACCESS_KEY_ID", "fleet")
                .env("AWS_SECRET_ACCESS_KEY", "fleet");
        });
        Member { client: Client::new(&process.url), process }
    }
}

/// A process of the fleet and a client of it.
pub struct Member {
    pub process: Process,
    pub client: Client,
}

/// Asks one process over HTTP; cheap to clone.
#[derive(Clone)]
pub struct Client {
    url: String,
    http: reqwest::Client,
}

impl Client {
    fn new(url: &str) -> Self {
        Self { url: url.to_owned(), http: http(HeaderMap::new()) }
    }

    /// A client of the same process that sends this key.
    pub fn with_key(&self, key: &str) -> Self {
        let value = format!("Bearer {key}").parse().unwrap();
        Self { http: http(HeaderMap::from_iter([(AUTHORIZATION, value)])), ..self.clone() }
    }

    /// Status and body.
    pub async fn get(&self, path: &str) -> (u16, Value) {
        read(self.http.get(format!("{}{path}", self.url))).await
    }

    pub async fn put(&self, path: &str, body: &Value) -> (u16, Value) {
        read(self.http.put(format!("{}{path}", self.url)).json(body)).await
    }

    pub async fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        read(self.http.post(format!("{}{path}", self.url)).json(body)).await
    }

    pub async fn post_picture(&self, path: &str, picture: Bytes) -> (u16, Value) {
        let request = self.http.post(format!("{}{path}", self.url)).header("Content-Type", "image/png");
        read(request.body(picture)).await
    }

    pub async fn delete(&self, path: &str) -> u16 {
        self.http.delete(format!("{}{path}", self.url)).send().await.expect("an answer").status().as_u16()
    }

    /// The answer to a picture, with its headers.
    pub async fn send_picture(&self, path: &str, picture: Bytes) -> reqwest::Response {
        let request = self.http.post(format!("{}{path}", self.url)).header("Content-Type", "image/png");
        request.body(picture).send().await.expect("an answer")
    }

    /// A body that isn't JSON.
    pub async fn text(&self, path: &str) -> String {
        self.http
            .get(format!("{}{path}", self.url))
            .send()
            .await
            .expect("an answer")
            .text()
            .await
            .expect("text")
    }

    /// A database of the paper's method, which trains in a moment, with a scene a label.
    pub async fn teach(&self, database: &str, scenes: std::ops::Range<u64>) {
        let options = json!({"kind": "landmarks", "options": {"method": "paper"}});
        let (status, body) = self.put(&format!("/v1/databases/{database}"), &options).await;
        assert!(status == 200 || status == 201, "{status} {body}");
        for number in scenes {
            self.teach_scene(database, number).await;
        }
    }

    pub async fn teach_scene(&self, database: &str, number: u64) {
        let path = format!("/v1/databases/{database}/exemplars?label=place{number}");
        let (status, body) = self.post_picture(&path, png(&scene(number))).await;
        assert!(status == 200 || status == 201, "{status} {body}");
    }

    /// Queue a training; the job's path.
    pub async fn train(&self, database: &str) -> String {
        let (status, body) = self.post(&format!("/v1/databases/{database}/trainings"), &json!({})).await;
        assert_eq!(status, 202, "{body}");
        format!("/v1/jobs/{}", body["id"].as_str().unwrap())
    }

    /// The job once it has ended.
    pub async fn ended(&self, job: &str) -> Value {
        let begun = Instant::now();
        loop {
            let (status, body) = self.get(job).await;
            if status == 200
                && ["succeeded", "failed", "cancelled"].contains(&body["state"].as_str().unwrap())
            {
                return body;
            }
            assert!(begun.elapsed() < PATIENCE, "{job} doesn't end: {status} {body}");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    }

    /// Train, and wait until this process serves the version.
    pub async fn trained(&self, database: &str) -> i64 {
        let job = self.train(database).await;
        let ended = self.ended(&job).await;
        assert_eq!(ended["state"], "succeeded", "{ended}");
        let version = ended["version"].as_i64().unwrap();
        self.serves(database, version).await;
        version
    }

    /// Wait until this process serves the version under `current`; how long that took.
    pub async fn serves(&self, database: &str, version: i64) -> Duration {
        let begun = Instant::now();
        loop {
            let (_, ready) = self.get("/readyz").await;
            let databases = ready["databases"].as_array().cloned().unwrap_or_default();
            let served = databases.iter().find(|one| one["database"] == database);
            if served.is_some_and(|one| one["version"] == version) {
                return begun.elapsed();
            }
            assert!(begun.elapsed() < PATIENCE, "{database} {version} isn't served: {ready}");
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    }

    /// Ask about a scene.
    pub async fn recognise(&self, database: &str, number: u64) -> (u16, Value) {
        self.post_picture(&format!("/v1/databases/{database}/recognitions"), png(&scene(number))).await
    }
}

/// What asks over plain HTTP.
fn http(headers: HeaderMap) -> reqwest::Client {
    rustls::crypto::ring::default_provider().install_default().ok();
    reqwest::Client::builder().timeout(PATIENCE).default_headers(headers).build().unwrap()
}

async fn read(request: reqwest::RequestBuilder) -> (u16, Value) {
    let answer = request.send().await.expect("an answer");
    let status = answer.status().as_u16();
    let body = answer.bytes().await.expect("a body");
    (status, serde_json::from_slice(&body).unwrap_or(Value::Null))
}

/// The middle and the largest of some times, in seconds.
pub fn middle_and_most(mut times: Vec<Duration>) -> (f64, f64) {
    times.sort();
    let most = times[times.len() - 1];
    (median(&mut times, Ord::cmp).expect("there are times").as_secs_f64(), most.as_secs_f64())
}
