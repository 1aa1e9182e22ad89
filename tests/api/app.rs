//! The service under test: wired as it is in production over a temporary folder, asked through its router.
//!
//! Every answer is held against what all answers promise: a request id, and for errors a whole problem document; a
//! 5xx fails the test unless it is asked for with [`App::send_expecting_5xx`]. A test that leaves a job queued or
//! running fails when its app is dropped, unless it says so with [`App::leave_jobs`].

use std::error::Error;
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, Method, Request, header, request};
use bytes::Bytes;
use futures_util::stream;
use http_body_util::BodyExt;
use landmarkd::access::{Actor, Grant, Scope};
use landmarkd::compute::Lane;
use landmarkd::config::{GivenSettings, Settings};
use landmarkd::database::JobState;
use landmarkd::http::{self, Service};
use landmarkd::serve::{self, Parts};
use landmarkd::telemetry::chain;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::{JoinError, JoinHandle, block_in_place};
use tower::ServiceExt;

use crate::pictures;
use crate::waits::{BOUND, until};

pub struct App {
    pub service: Service,
    router: Router,
    /// The background work, until it is started.
    held: Option<Parts>,
    background: Option<JoinHandle<Result<(), JoinError>>>,
    shutdown: watch::Sender<bool>,
    folder: Arc<TempDir>,
    may_leave_jobs: bool,
    /// Sent with every request that has none of its own.
    key: Option<String>,
}

impl App {
    /// The service over an empty folder.
    pub async fn start() -> Self {
        Self::start_with(|_| ()).await
    }

    /// The service over an empty folder, with other settings.
    pub async fn start_with(change: impl FnOnce(&mut Settings)) -> Self {
        Self::open(Arc::new(tempfile::tempdir().unwrap()), change).await
    }

    /// The service over a folder that may hold something.
    pub async fn open(folder: Arc<TempDir>, change: impl FnOnce(&mut Settings)) -> Self {
        let mut app = Self::open_idle(folder, change).await;
        app.begin();
        until("ready", async || app.readiness().await.0 == 200).await;
        app
    }

    /// The service over an empty folder, with its background work held back: jobs stay queued until [`App::begin`].
    pub async fn start_idle() -> Self {
        Self::open_idle(Arc::new(tempfile::tempdir().unwrap()), |_| ()).await
    }

    async fn open_idle(folder: Arc<TempDir>, change: impl FnOnce(&mut Settings)) -> Self {
        let given = GivenSettings {
            data_dir: Some(folder.path().to_owned()),
            threads: Some(2),
            ..GivenSettings::default()
        };
        let mut settings = Settings::settle(given, None).unwrap();
        change(&mut settings);
        let (shutdown, watched) = watch::channel(false);
        let parts = once_free(async || serve::wire(&settings, watched.clone()).await).await;
        Self {
            service: parts.service.clone(),
            router: http::router(parts.service.clone()),
            held: Some(parts),
            background: None,
            shutdown,
            folder,
            may_leave_jobs: false,
            key: None,
        }
    }

    /// Start the background work that was held back.
    pub fn begin(&mut self) {
        let parts = self.held.take().expect("the background work begins once");
        self.background = Some(parts.start().1);
    }

    /// Send this key with every request from now on, or none.
    pub fn use_key(&mut self, key: Option<&str>) {
        self.key = key.map(str::to_owned);
    }

    /// Make the first key, of scope admin, as the command line does, and send it from now on; its text and its id.
    pub async fn close(&mut self) -> (String, String) {
        let grant =
            Grant { name: "operator".into(), scope: Scope::Admin, databases: None, requests_per_s: None };
        let made = self.service.keyring.create(&grant, &Actor::named("command line")).await.unwrap();
        self.use_key(Some(made.key.reveal()));
        (made.key.reveal().to_owned(), made.row.id)
    }

    /// Make a key, `{name, scope, …}`; its text and its id.
    pub async fn make_key(&self, body: Value) -> (String, String) {
        let made = self.post("/v1/keys", body).await.expect(201);
        (made["key"].as_str().unwrap().to_owned(), made["id"].as_str().unwrap().to_owned())
    }

    /// The folder that it works in.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Jobs may be left unfinished when the app is dropped.
    pub fn leave_jobs(&mut self) {
        self.may_leave_jobs = true;
    }

    /// Shut down; the folder stays for another app.
    pub fn stop(self) -> Arc<TempDir> {
        Arc::clone(&self.folder)
    }

    /// Wait for a future from code that isn't async, such as a property.
    pub fn now<T>(&self, future: impl Future<Output = T>) -> T {
        block_in_place(|| Handle::current().block_on(future))
    }

    async fn ask(&self, request: Request<Body>) -> Answer {
        let answer = self.answer(request).await;
        answer.check();
        answer
    }

    async fn answer(&self, mut request: Request<Body>) -> Answer {
        if let Some(key) = &self.key
            && !request.headers().contains_key(header::AUTHORIZATION)
        {
            let value = format!("Bearer {key}").parse().unwrap();
            request.headers_mut().insert(header::AUTHORIZATION, value);
        }
        let asked = format!("{} {}", request.method(), request.uri());
        let answering = async {
            let response = self.router.clone().oneshot(request).await.unwrap();
            let (parts, body) = response.into_parts();
            let body = body.collect().await.unwrap().to_bytes();
            Answer { asked: asked.clone(), status: parts.status.as_u16(), headers: parts.headers, body }
        };
        let answer = tokio::time::timeout(BOUND, answering).await;
        answer.unwrap_or_else(|_| panic!("no answer to {asked}"))
    }

    /// Ask, and get the whole answer.
    pub async fn send(&self, request: Request<Body>) -> Answer {
        let answer = self.ask(request).await;
        assert!(answer.status < 500, "{answer:?}");
        answer
    }

    /// The text of an endless answer, up to where it is enough.
    pub async fn read_stream(&self, mut request: Request<Body>, is_enough: impl Fn(&str) -> bool) -> String {
        if let Some(key) = &self.key {
            let value = format!("Bearer {key}").parse().unwrap();
            request.headers_mut().insert(header::AUTHORIZATION, value);
        }
        let response = self.router.clone().oneshot(request).await.unwrap();
        assert_eq!(response.status(), 200);
        let (mut body, mut text) = (response.into_body(), String::new());
        while !is_enough(&text) {
            let frame = tokio::time::timeout(crate::waits::BOUND, body.frame()).await;
            let frame = frame.unwrap_or_else(|_| panic!("no more came after {text}"));
            let data = frame.expect("the stream goes on").unwrap().into_data().unwrap_or_default();
            text.push_str(std::str::from_utf8(&data).unwrap());
        }
        text
    }

    /// Whether somebody follows what happens.
    pub fn is_followed(&self) -> bool {
        self.service.events.are_followed()
    }

    /// Ask for what isn't held against what all answers promise.
    pub async fn send_as_it_is(&self, request: Request<Body>) -> Answer {
        self.answer(request).await
    }

    /// Ask when the service may be unable to answer.
    pub async fn send_expecting_5xx(&self, request: Request<Body>) -> Answer {
        self.ask(request).await
    }

    /// Whether the service calls itself ready, and the status of that answer.
    pub async fn readiness(&self) -> (u16, Value) {
        let answer = self.answer(request(Method::GET, "/readyz").body(Body::empty()).unwrap()).await;
        (answer.status, answer.json())
    }

    pub async fn get(&self, path: &str) -> Answer {
        self.send(request(Method::GET, path).body(Body::empty()).unwrap()).await
    }

    pub async fn delete(&self, path: &str) -> Answer {
        self.send(request(Method::DELETE, path).body(Body::empty()).unwrap()).await
    }

    pub async fn put(&self, path: &str, body: Value) -> Answer {
        self.send(with_json(request(Method::PUT, path), &body)).await
    }

    pub async fn post(&self, path: &str, body: Value) -> Answer {
        self.send(with_json(request(Method::POST, path), &body)).await
    }

    pub async fn patch(&self, path: &str, body: Value) -> Answer {
        self.send(with_json(request(Method::PATCH, path), &body)).await
    }

    /// Send bytes as they are.
    pub async fn post_bytes(&self, path: &str, media_type: &str, bytes: impl Into<Bytes>) -> Answer {
        self.send(with_bytes(request(Method::POST, path), media_type, bytes)).await
    }

    /// Send a PNG picture.
    pub async fn post_png(&self, path: &str, bytes: impl Into<Bytes>) -> Answer {
        self.post_bytes(path, "image/png", bytes).await
    }

    /// Create a database that trains fast: few points, short signatures.
    pub async fn create(&self, database: &str) {
        let options = json!({"method": "paper", "interest_points": 16, "query_points": 24, "rings": 4, "sectors": 16, "dimension": 8});
        let body = json!({"kind": "landmarks", "options": options});
        self.put(&format!("/v1/databases/{database}"), body).await.expect(201);
    }

    /// Add the scene of that number as a training image.
    pub async fn add(&self, database: &str, label: &str, number: u64) -> Value {
        let path = format!("/v1/databases/{database}/exemplars?label={label}");
        let answer = self.post_png(&path, pictures::scene_png(number)).await;
        assert!(matches!(answer.status, 200 | 201), "{answer:?}");
        answer.json()
    }

    /// Train and wait; the finished job, which has succeeded.
    pub async fn train(&self, database: &str, body: Value) -> Value {
        let queued = self.post(&format!("/v1/databases/{database}/trainings"), body).await.expect(202);
        let job = self.finished(&queued).await;
        assert_eq!(job["state"], "succeeded", "{job:#}");
        job
    }

    /// A job after it has ended.
    pub async fn finished(&self, job: &Value) -> Value {
        let id = job["id"].as_str().unwrap();
        // The stream of events ends with the job.
        self.get(&format!("/v1/jobs/{id}/events")).await;
        let job = self.get(&format!("/v1/jobs/{id}")).await.expect(200);
        assert!(matches!(job["state"].as_str(), Some("succeeded" | "failed" | "cancelled")), "{job:#}");
        job
    }

    /// A database with the scenes 1, 2, … under labels `place-1`, `place-2`, …, trained.
    pub async fn trained(&self, database: &str, scenes: u64) {
        self.create(database).await;
        for number in 1..=scenes {
            self.add(database, &format!("place-{number}"), number).await;
        }
        self.train(database, json!({})).await;
    }

    /// Recognise a scene by `current`; the answer's body.
    pub async fn recognise(&self, database: &str, query: &str, picture: Bytes) -> Value {
        self.post_png(&format!("/v1/databases/{database}/recognitions{query}"), picture).await.expect(200)
    }
}

impl Drop for App {
    fn drop(&mut self) {
        let background = self.background.take();
        let left = self.now(async {
            let counted = self.service.jobs.by_state().await.unwrap_or_default();
            self.shutdown.send_replace(true);
            if let Some(background) = background {
                let ended = tokio::time::timeout(Duration::from_secs(20), background).await;
                let well = matches!(ended, Ok(Ok(Ok(()))));
                assert!(well || std::thread::panicking(), "the background work doesn't end well: {ended:?}");
            }
            counted.into_iter().filter(|(state, _)| !JobState::is_terminal(*state)).collect::<Vec<_>>()
        });
        let complains = !self.may_leave_jobs && !std::thread::panicking();
        assert!(!complains || left.is_empty(), "the test leaves jobs: {left:?}");
    }
}

/// Occupies every thread of a lane until it is dropped.
pub struct Occupied(Vec<mpsc::Sender<()>>);

impl Occupied {
    pub async fn lane(app: &App, lane: Lane) -> Self {
        let held = (0..app.service.compute.threads(lane)).map(|_| {
            let (release, held) = mpsc::channel::<()>();
            let compute = app.service.compute.clone();
            // Ends when the sender is dropped.
            tokio::spawn(async move { compute.run(lane, 0, move || held.recv()).await.is_ok() });
            release
        });
        let held = Self(held.collect());
        until("all run", async || app.service.compute.running(lane) == held.0.len()).await;
        held
    }
}

/// Open a folder once whoever held it before has let go of it: the last task of a store may outlive its last call.
pub async fn once_free<T, E: Error + 'static>(open: impl AsyncFn() -> Result<T, E>) -> T {
    let started = Instant::now();
    loop {
        match open().await {
            Ok(opened) => return opened,
            Err(error) if chain(&error).contains("in use") && started.elapsed() < Duration::from_secs(5) => {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
            Err(error) => panic!("{}", chain(&error)),
        }
    }
}

/// A request that is still without headers of its own and body.
pub fn request(method: Method, path: &str) -> request::Builder {
    Request::builder().method(method).uri(path)
}

pub fn with_json(builder: request::Builder, body: &Value) -> Request<Body> {
    with_bytes(builder, "application/json", body.to_string())
}

pub fn with_bytes(builder: request::Builder, media_type: &str, bytes: impl Into<Bytes>) -> Request<Body> {
    builder.header(header::CONTENT_TYPE, media_type).body(in_pieces(bytes.into(), 64 << 10)).unwrap()
}

/// A body of undeclared length that comes as over a wire: piece by piece, and not all of it is there at once.
pub fn in_pieces(bytes: Bytes, piece_bytes: usize) -> Body {
    let pieces = stream::unfold(bytes, move |mut rest| async move {
        tokio::task::yield_now().await;
        let piece = rest.split_to(piece_bytes.min(rest.len()));
        (!piece.is_empty()).then_some((Ok::<_, std::io::Error>(piece), rest))
    });
    Body::from_stream(pieces)
}

/// What the service answered.
pub struct Answer {
    asked: String,
    pub status: u16,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl std::fmt::Debug for Answer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let body = String::from_utf8_lossy(&self.body[..self.body.len().min(2000)]);
        write!(f, "{} answered {} {:?} {body}", self.asked, self.status, self.headers)
    }
}

impl Answer {
    /// The body as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// A header's text, empty when it isn't there.
    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    /// The body, if the status is this one: JSON, or null for none.
    #[track_caller]
    pub fn expect(&self, status: u16) -> Value {
        assert_eq!(self.status, status, "{self:?}");
        if self.body.is_empty() { Value::Null } else { self.json() }
    }

    /// The problem document, if it is this one.
    #[track_caller]
    pub fn expect_problem(&self, status: u16, code: &str) -> Value {
        let problem = self.json();
        assert_eq!((self.status, problem["code"].as_str()), (status, Some(code)), "{self:?}");
        problem
    }

    /// What every answer promises.
    fn check(&self) {
        let id = self.header("x-request-id");
        assert!(!id.is_empty(), "no request id: {self:?}");
        assert_eq!(self.header("x-content-type-options"), "nosniff", "{self:?}");
        if self.status < 400 {
            return;
        }
        assert_eq!(self.header("content-type"), "application/problem+json", "{self:?}");
        let problem = self.json();
        for member in ["type", "title", "detail", "code", "request_id"] {
            let text = problem[member].as_str().unwrap_or_default();
            assert!(!text.is_empty(), "the problem has no {member}: {self:?}");
        }
        assert_eq!(problem["status"], self.status, "{self:?}");
        assert_eq!(problem["request_id"], id, "{self:?}");
        assert_eq!(problem["type"], format!("/problems/{}", problem["code"].as_str().unwrap()));
        let puts_off = matches!(self.status, 429 | 503);
        assert_eq!(puts_off, self.headers.contains_key(header::RETRY_AFTER), "{self:?}");
    }
}

/// The pointers of a problem's fields, sorted.
pub fn pointers(problem: &Value) -> Vec<&str> {
    let errors = problem["errors"].as_array().unwrap();
    let mut at: Vec<&str> = errors.iter().map(|error| error["pointer"].as_str().unwrap()).collect();
    at.sort_unstable();
    at
}

const BOUNDARY: &str = "a-line-that-no-picture-holds";

/// The media type of [`form`].
pub fn form_type() -> String {
    format!("multipart/form-data; boundary={BOUNDARY}")
}

/// A multipart body of parts (name, bytes).
pub fn form<N: AsRef<str>, B: AsRef<[u8]>>(parts: &[(N, B)]) -> Bytes {
    let mut body = Vec::new();
    for (name, bytes) in parts {
        let name = name.as_ref();
        let head = format!(
            "--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{name}\"; filename=\"../{name}.png\"\r\n\r\n"
        );
        body.extend_from_slice(head.as_bytes());
        body.extend_from_slice(bytes.as_ref());
        body.extend_from_slice(b"\r\n");
    }
    body.extend_from_slice(format!("--{BOUNDARY}--\r\n").as_bytes());
    body.into()
}

/// A tar archive of files (path, bytes).
pub async fn tar<P: AsRef<str>, B: AsRef<[u8]>>(files: &[(P, B)]) -> Bytes {
    let mut archive = tokio_tar::Builder::new(Vec::new());
    for (path, bytes) in files {
        let mut header = tokio_tar::Header::new_gnu();
        header.set_size(bytes.as_ref().len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        archive.append_data(&mut header, path.as_ref(), bytes.as_ref()).await.unwrap();
    }
    archive.into_inner().await.unwrap().into()
}
