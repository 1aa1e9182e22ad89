//! Asks one process that may die at any moment.

use std::path::Path;
use std::time::{Duration, Instant};

use bytes::Bytes;
use reqwest::{Method, RequestBuilder};
use serde_json::Value;

use crate::process::{Process, landmarkd};

/// The process died before its answer was whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Died;

/// An answer, whole.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub retry_after: Option<String>,
    pub body: Bytes,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_default()
    }

    pub fn is_well(&self) -> bool {
        (200..300).contains(&self.status)
    }

    #[track_caller]
    pub fn expect(self, status: u16) -> Value {
        let body = self.json();
        assert_eq!(self.status, status, "{body:#}");
        body
    }
}

#[derive(Clone)]
pub struct Client {
    url: String,
    http: reqwest::Client,
}

impl Client {
    pub fn new(process: &Process) -> Self {
        rustls::crypto::ring::default_provider().install_default().ok();
        let http = reqwest::Client::builder()
            .no_proxy()
            .tls_certs_only([])
            // No connection is used twice, so that a death shows at once.
            .pool_max_idle_per_host(0)
            .timeout(Duration::from_secs(60))
            .build()
            .unwrap();
        Self { url: process.url.clone(), http }
    }

    pub async fn get(&self, path: &str) -> Result<Answer, Died> {
        self.send(Method::GET, path, |request| request).await
    }

    pub async fn send(
        &self,
        method: Method,
        path: &str,
        with: impl FnOnce(RequestBuilder) -> RequestBuilder,
    ) -> Result<Answer, Died> {
        let request = with(self.http.request(method, format!("{}{path}", self.url)));
        let response = request.send().await.map_err(|_| Died)?;
        let status = response.status().as_u16();
        let retry_after =
            response.headers().get("retry-after").map(|value| value.to_str().unwrap().to_owned());
        let body = response.bytes().await.map_err(|_| Died)?;
        Ok(Answer { status, retry_after, body })
    }

    pub async fn put(&self, path: &str, body: Value) -> Result<Answer, Died> {
        self.send(Method::PUT, path, |request| request.json(&body)).await
    }

    pub async fn post(&self, path: &str, body: Value) -> Result<Answer, Died> {
        self.send(Method::POST, path, |request| request.json(&body)).await
    }

    pub async fn post_picture(&self, path: &str, picture: Bytes) -> Result<Answer, Died> {
        self.send(Method::POST, path, |request| request.header("content-type", "image/png").body(picture))
            .await
    }

    /// Wait until recognitions are answered; how long that took.
    pub async fn ready(&self, context: &str) -> Duration {
        let started = Instant::now();
        loop {
            let answer =
                self.get("/readyz").await.unwrap_or_else(|_| panic!("died while starting: {context}"));
            if answer.status == 200 {
                return started.elapsed();
            }
            assert!(started.elapsed() < Duration::from_secs(5), "not ready: {context}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    /// Wait until the job has ended.
    pub async fn ended(&self, job: &str) -> Result<Value, Died> {
        let started = Instant::now();
        loop {
            let answer = self.get(&format!("/v1/jobs/{job}")).await?;
            let body = answer.json();
            if answer.status == 200 && !matches!(body["state"].as_str(), Some("queued" | "running")) {
                return Ok(body);
            }
            assert!([200, 503].contains(&answer.status), "{body:#}");
            assert!(started.elapsed() < Duration::from_secs(90), "the job doesn't end: {body:#}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }
}

/// What `landmarkd verify` says about a folder, which a process may be serving; none when all is well.
pub fn verify(folder: &Path) -> Result<String, String> {
    let ended = landmarkd().arg("verify").arg("--data-dir").arg(folder).output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    match ended.status.success() {
        true => Ok(said),
        false => Err(said + &String::from_utf8_lossy(&ended.stderr)),
    }
}
