//! A client of the HTTP contract, as small as the verbs need that call a running service: `demo`, `teach`, `ask`.
//!
//! What only one of them asks for stands with it, as further methods of [`Server`].

use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fs, io};

use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use reqwest::{Certificate, Method, RequestBuilder, Response, Url};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use thiserror::Error;
use tokio::time::{Instant, sleep};

/// The longest that one call may take: a request's own limit at the service.
const CALL_TIMEOUT: Duration = Duration::from_secs(60);
/// The longest that a training may take: thousands of pictures train within minutes.
const TRAINING_TIMEOUT: Duration = Duration::from_secs(3600);
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A running service.
pub struct Server {
    base_url: Url,
    http: reqwest::Client,
}

/// Why a call went wrong.
#[derive(Debug, Error)]
pub enum ClientError {
    /// The address of the service can't be parsed.
    #[error("{base_url} is no address of a service: give one such as http://127.0.0.1:8080")]
    Address {
        /// The address given.
        base_url: String,
    },
    /// The key holds what no header can.
    #[error("the key can't be sent: it holds something else than letters, digits and signs")]
    Key,
    /// The file of certificates can't be used.
    #[error("{} holds no certificates (PEM)", .path.display())]
    Certificates {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A call got no answer, or one that can't be read.
    #[error("no answer to {call}")]
    NoAnswer {
        /// The URL called.
        call: String,
        /// The cause.
        source: reqwest::Error,
    },
    /// The service answered a call with a problem.
    #[error("the service refused {call}: {detail} (status {status})")]
    Refused {
        /// The URL called.
        call: String,
        /// The HTTP status.
        status: u16,
        /// The problem's detail.
        detail: String,
    },
    /// The training failed or was cancelled.
    #[error("the training failed: {detail}")]
    Training {
        /// The problem's detail.
        detail: String,
    },
    /// The training took too long.
    #[error("the training did not end within {waited_s} s; the job is {job}")]
    Endless {
        /// The job's id.
        job: String,
        /// How long it was waited for, in seconds.
        waited_s: u64,
    },
}

/// A job as far as it is followed.
#[derive(Deserialize)]
struct Job {
    id: String,
    state: String,
    version: Option<u64>,
    problem: Option<Value>,
}

impl Server {
    /// The service at an address such as `http://127.0.0.1:8080`; proxies of the environment are not asked. `key` comes with
    /// every call; `certificates`, a PEM file, are those that a service with TLS is trusted by.
    ///
    /// # Errors
    /// [`ClientError`] naming the argument that can't be used.
    pub fn at(base_url: &str, key: Option<&str>, certificates: Option<&Path>) -> Result<Server, ClientError> {
        let address = || ClientError::Address { base_url: base_url.to_owned() };
        let url: Url = base_url.parse().map_err(|_| address())?;
        if url.cannot_be_a_base() {
            return Err(address());
        }
        let mut headers = HeaderMap::new();
        if let Some(key) = key {
            let value = HeaderValue::from_str(&format!("Bearer {key}")).map_err(|_| ClientError::Key)?;
            headers.insert(AUTHORIZATION, value);
        }
        // One provider for the whole process; another part of it may have installed it.
        rustls::crypto::ring::default_provider().install_default().ok();
        let http = reqwest::Client::builder()
            .timeout(CALL_TIMEOUT)
            .no_proxy()
            .default_headers(headers)
            .tls_certs_only(certificates.map(certificates_of).transpose()?.unwrap_or_default())
            .build()
            .map_err(|source| ClientError::NoAnswer { call: base_url.to_owned(), source })?;
        Ok(Server { base_url: url, http })
    }

    /// Deletes what has that path, if it is there.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn delete(&self, path: &[&str]) -> Result<(), ClientError> {
        match self.send(self.call(Method::DELETE, path, &[])).await {
            Err(ClientError::Refused { status: 404, .. }) => Ok(()),
            answer => answer.map(drop),
        }
    }

    /// Creates what is to have that path.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn create(&self, path: &[&str], document: &Value) -> Result<(), ClientError> {
        self.send(self.call(Method::PUT, path, &[]).json(document)).await.map(drop)
    }

    /// What has that path; `None`: nothing.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn find<T: DeserializeOwned>(&self, path: &[&str]) -> Result<Option<T>, ClientError> {
        match self.json(self.call(Method::GET, path, &[])).await {
            Err(ClientError::Refused { status: 404, .. }) => Ok(None),
            answer => answer.map(Some),
        }
    }

    /// Trains with a request's document and waits for the end; returns the version.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn train(&self, database: &str, document: &Value) -> Result<u64, ClientError> {
        let call = self.call(Method::POST, &["databases", database, "trainings"], &[]);
        let mut job: Job = self.json(call.json(document)).await?;
        let started = Instant::now();
        loop {
            match job.state.as_str() {
                "succeeded" => return Ok(job.version.unwrap_or_default()),
                "failed" | "cancelled" => {
                    let problem = job.problem.unwrap_or_default();
                    let detail = problem["detail"].as_str().unwrap_or("it was cancelled").to_owned();
                    return Err(ClientError::Training { detail });
                }
                _ if started.elapsed() > TRAINING_TIMEOUT => {
                    return Err(ClientError::Endless { job: job.id, waited_s: TRAINING_TIMEOUT.as_secs() });
                }
                _ => sleep(POLL_INTERVAL).await,
            }
            job = self.json(self.call(Method::GET, &["jobs", &job.id], &[])).await?;
        }
    }

    /// A call to `/v1/…`; names are escaped.
    pub fn call(&self, method: Method, path: &[&str], query: &[(&str, &str)]) -> RequestBuilder {
        let mut url = self.base_url.clone();
        if let Ok(mut segments) = url.path_segments_mut() {
            segments.pop_if_empty().push("v1").extend(path);
        }
        if !query.is_empty() {
            url.query_pairs_mut().extend_pairs(query);
        }
        self.http.request(method, url)
    }

    /// The bytes of the answer to a call.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn bytes(&self, call: RequestBuilder) -> Result<Vec<u8>, ClientError> {
        let answer = self.send(call).await?;
        let call = answer.url().to_string();
        let bytes = answer.bytes().await.map_err(|source| ClientError::NoAnswer { call, source })?;
        Ok(bytes.to_vec())
    }

    /// The document that answers a call.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn json<T: DeserializeOwned>(&self, call: RequestBuilder) -> Result<T, ClientError> {
        let answer = self.send(call).await?;
        let call = answer.url().to_string();
        answer.json().await.map_err(|source| ClientError::NoAnswer { call, source })
    }

    /// Sends; an answer that isn't a success becomes an error with the problem's detail.
    ///
    /// # Errors
    /// [`ClientError`].
    pub async fn send(&self, call: RequestBuilder) -> Result<Response, ClientError> {
        let answer = call.send().await.map_err(|source| ClientError::NoAnswer {
            call: source.url().map_or_else(String::new, Url::to_string),
            source: source.without_url(),
        })?;
        let (status, call) = (answer.status(), answer.url().to_string());
        if status.is_success() {
            return Ok(answer);
        }
        let problem: Value = answer.json().await.unwrap_or_default();
        let detail = problem["detail"].as_str().unwrap_or("without a reason").to_owned();
        Err(ClientError::Refused { call, status: status.as_u16(), detail })
    }
}

fn certificates_of(path: &Path) -> Result<Vec<Certificate>, ClientError> {
    let none = |source| ClientError::Certificates { path: path.to_path_buf(), source };
    let pem = fs::read(path).map_err(|error: io::Error| none(error.into()))?;
    let certificates = Certificate::from_pem_bundle(&pem).map_err(|error| none(error.into()))?;
    match certificates.is_empty() {
        true => Err(none("there is no certificate in it".into())),
        false => Ok(certificates),
    }
}
