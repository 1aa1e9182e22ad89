//! The whole service over a temporary folder, called through its router; every answer is checked for what all answers
//! promise. It is opened again from time to time, so that what inputs left doesn't grow without end.

use std::cell::RefCell;
use std::fs;
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, Request, Uri};
use bytes::Bytes;
use futures_util::stream;
use http_body_util::BodyExt;
use landmarkd::config::{GivenSettings, Settings};
use landmarkd::http;
use landmarkd::problem::Code;
use landmarkd::serve;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;
use tokio::task::{JoinError, JoinHandle};
use tower::ServiceExt;

use crate::drawn;

/// Longer than any answer takes, on a busy machine too.
const TIMEOUT: Duration = Duration::from_secs(90);
/// Calls after which the service is opened again.
const CALLS_PER_SERVICE: u32 = 2000;

/// A request, as an input describes it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Call<'a> {
    pub method: &'a str,
    /// Path and query; `@exemplar`, `@job` and `@track` stand for ids that are there.
    pub target: &'a str,
    pub headers: &'a [(&'a [u8], &'a [u8])],
    pub body: &'a [u8],
    /// The body comes in pieces of so many bytes; 0: at once.
    pub piece_bytes: usize,
}

/// An answer that kept what all answers promise.
pub struct Answer {
    pub status: u16,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Answer {
    /// The body as JSON.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|error| panic!("{error}: {:?}", self.body))
    }
}

thread_local! {
    // Not dropped at the process's exit: what the runtime needs to end is gone by then.
    static SERVICE: RefCell<ManuallyDrop<Option<Service>>> = const { RefCell::new(ManuallyDrop::new(None)) };
}

/// Sends a call to the service; none when the input makes no request that a server would pass on.
pub fn send(call: Call) -> Option<Answer> {
    SERVICE.with_borrow_mut(|held| {
        let service = held.get_or_insert_with(Service::open);
        let answer = service.send(call);
        // What the next inputs need is restored when a call deleted it.
        let gone = call.method == "DELETE"
            && NEEDED.iter().any(|word| call.target.contains(word))
            && answer.as_ref().is_some_and(|answer| answer.status < 300);
        if service.calls >= CALLS_PER_SERVICE || (gone && !service.is_whole()) {
            **held = None;
        }
        answer
    })
}

struct Service {
    runtime: Runtime,
    router: Router,
    shutdown: watch::Sender<bool>,
    background: Option<JoinHandle<Result<(), JoinError>>>,
    /// Placeholders in targets, and the ids that replace them.
    ids: Vec<(&'static str, String)>,
    calls: u32,
    _folder: Option<TempDir>,
}

/// A data folder with everything trained, and the ids in it.
struct Template {
    folder: TempDir,
    ids: Vec<(&'static str, String)>,
}

fn template() -> &'static Template {
    static TEMPLATE: OnceLock<Template> = OnceLock::new();
    TEMPLATE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut service = Service::over(folder.path());
        service.fill();
        Template { folder, ids: std::mem::take(&mut service.ids) }
    })
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder is made");
    for entry in fs::read_dir(from).expect("the folder is listed") {
        let entry = entry.expect("the folder is listed");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a file is copied");
        }
    }
}

/// What must be there.
const THERE: [&str; 6] = [
    "/v1/databases/lab/versions/1",
    "/v1/databases/lab/exemplars/@exemplar",
    "/v1/databases/lab/tracks/@track",
    "/v1/databases/placed/aliases/current",
    "/v1/databases/parts/aliases/current",
    "/v1/workcells/bench",
];

/// Words in the targets of what must be there.
const NEEDED: [&str; 6] = ["lab", "placed", "parts", "rig", "bench", "@"];

impl Service {
    /// A copy of the template, with a track.
    fn open() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        copy(template().folder.path(), folder.path());
        let mut service = Self::over(folder.path());
        service._folder = Some(folder);
        service.ids = template().ids.clone();
        while !service.is_ready() {}
        let track = service.send_json("POST", "/v1/databases/lab/tracks", &json!({}));
        service.ids.push(("@track", track["id"].as_str().expect("an id").to_owned()));
        service.calls = 0;
        service
    }

    fn is_ready(&mut self) -> bool {
        let answer = self.send(Call { method: "GET", target: "/readyz", ..Call::default() });
        answer.is_some_and(|answer| answer.status == 200)
    }

    fn over(folder: &Path) -> Self {
        let given =
            GivenSettings { data_dir: Some(folder.to_owned()), threads: Some(1), ..GivenSettings::default() };
        let settings = Settings::settle(given, None).expect("the defaults are settings");
        let runtime = Builder::new_current_thread().enable_all().build().expect("a runtime");
        let (shutdown, watched) = watch::channel(false);
        let (service, background) = runtime.block_on(async {
            serve::wire(&settings, watched).await.expect("an empty folder opens").start()
        });
        let router = http::router(service);
        let background = Some(background);
        Self { runtime, router, shutdown, background, ids: Vec::new(), calls: 0, _folder: None }
    }

    fn send_body(&mut self, method: &str, target: &str, media_type: &str, body: &[u8]) -> Value {
        let headers: [(&[u8], &[u8]); 1] = [(b"content-type", media_type.as_bytes())];
        let call = Call { method, target, headers: &headers, body, piece_bytes: 0 };
        let answer = self.send(call).expect("this is a request");
        assert!(answer.status < 300, "{method} {target} {} {:?}", answer.status, answer.body);
        answer.json()
    }

    fn send_json(&mut self, method: &str, target: &str, body: &Value) -> Value {
        self.send_body(method, target, "application/json", body.to_string().as_bytes())
    }

    fn train(&mut self, database: &str) -> String {
        let job = self.send_json("POST", &format!("/v1/databases/{database}/trainings"), &json!({}));
        let id = job["id"].as_str().expect("a job has an id").to_owned();
        // The stream of events ends with the job.
        self.send(Call { method: "GET", target: &format!("/v1/jobs/{id}/events"), ..Call::default() });
        id
    }

    /// A database of each kind and method, a rig, a workcell.
    fn fill(&mut self) {
        let small =
            json!({"interest_points": 6, "query_points": 8, "rings": 4, "sectors": 16, "dimension": 3});
        for (database, method) in [("lab", "paper"), ("placed", "placement")] {
            let mut options = small.clone();
            options["method"] = method.into();
            let body = json!({"kind": "landmarks", "options": options});
            self.send_json("PUT", &format!("/v1/databases/{database}"), &body);
            for number in 0..2 {
                let target = format!("/v1/databases/{database}/exemplars?label=place-{number}");
                let kept = self.send_body("POST", &target, "image/png", &drawn::scene_png(number));
                if database == "lab" {
                    self.ids.push(("@exemplar", kept["id"].as_str().expect("an id").to_owned()));
                }
            }
            let job = self.train(database);
            self.ids.push(("@job", job));
        }
        let options = json!({"dimension": 4, "width_px": 16, "height_px": 16});
        self.send_json("PUT", "/v1/databases/parts", &json!({"kind": "objects", "options": options}));
        for number in 0..8 {
            let target =
                format!("/v1/databases/parts/exemplars?label=part-{}&pose_deg={}", number % 2, 45 * number);
            self.send_body("POST", &target, "image/png", &drawn::scene_png(number));
        }
        self.train("parts");
        self.send_json("PUT", "/v1/calibrations/rig", &drawn::optics());
        self.send_json("PUT", "/v1/workcells/bench", &drawn::workcell());
    }

    fn is_whole(&mut self) -> bool {
        THERE.iter().all(|target| {
            let answer = self.send(Call { method: "GET", target, ..Call::default() });
            answer.is_some_and(|answer| answer.status == 200)
        })
    }

    fn send(&mut self, call: Call) -> Option<Answer> {
        self.calls += 1;
        let mut target = call.target.to_owned();
        for (word, id) in &self.ids {
            target = target.replace(word, id);
        }
        let method = Method::from_bytes(call.method.as_bytes()).ok()?;
        let mut request = Request::new(body(call.body, call.piece_bytes));
        *request.method_mut() = method.clone();
        *request.uri_mut() = target.parse::<Uri>().ok()?;
        for (name, value) in call.headers {
            if let (Ok(name), Ok(value)) = (HeaderName::from_bytes(name), HeaderValue::from_bytes(value)) {
                request.headers_mut().append(name, value);
            }
        }
        let router = self.router.clone();
        let answering = async {
            let response = router.oneshot(request).await.expect("the router always answers");
            let (parts, body) = response.into_parts();
            let body = body.collect().await.expect("the body comes whole").to_bytes();
            Answer { status: parts.status.as_u16(), headers: parts.headers, body }
        };
        let answer = self.runtime.block_on(async { tokio::time::timeout(TIMEOUT, answering).await });
        let answer = answer.unwrap_or_else(|_| panic!("no answer to {method} {target}"));
        check(&answer, &method, &target);
        Some(answer)
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        self.shutdown.send_replace(true);
        let background = self.background.take();
        self.runtime.block_on(async {
            if let Some(background) = background {
                background.await.expect("it ends").expect("the background work ends well");
            }
        });
    }
}

/// A body of undeclared length, in pieces.
fn body(bytes: &[u8], piece_bytes: usize) -> Body {
    let bytes = Bytes::copy_from_slice(bytes);
    if piece_bytes == 0 {
        return bytes.into();
    }
    let pieces = stream::unfold(bytes, move |mut rest| async move {
        tokio::task::yield_now().await;
        let piece = rest.split_to(piece_bytes.min(rest.len()));
        (!piece.is_empty()).then_some((Ok::<_, std::io::Error>(piece), rest))
    });
    Body::from_stream(pieces)
}

/// What every answer promises: a request's id, no 5xx but a 503 that says when to come back, a whole problem document
/// for every error.
fn check(answer: &Answer, method: &Method, target: &str) {
    let header = |name: &str| answer.headers.get(name).map(HeaderValue::as_bytes).unwrap_or_default();
    let text = String::from_utf8_lossy(&answer.body[..answer.body.len().min(2000)]);
    let whole = format!("{method} {target} answered {} {:?} {text}", answer.status, answer.headers);
    assert!(!header("x-request-id").is_empty(), "no request id: {whole}");
    assert_eq!(header("x-content-type-options"), b"nosniff", "{whole}");
    assert!(answer.status < 500 || answer.status == 503, "{whole}");
    if method == Method::HEAD {
        return;
    }
    if header("content-type") == b"application/json" {
        answer.json();
    }
    // Readiness answers 503 with its own document.
    if answer.status < 400 || target.starts_with("/readyz") {
        return;
    }
    assert_eq!(header("content-type"), b"application/problem+json", "{whole}");
    let problem = answer.json();
    for member in ["type", "title", "detail", "code", "request_id"] {
        assert!(problem[member].as_str().is_some_and(|text| !text.is_empty()), "no {member}: {whole}");
    }
    let code = Code::from_word(problem["code"].as_str().unwrap_or_default());
    assert_eq!(code.map(|code| code.status()), Some(answer.status), "{whole}");
    assert_eq!(problem["status"], answer.status, "{whole}");
    assert_eq!(problem["request_id"].as_str().map(str::as_bytes), Some(header("x-request-id")), "{whole}");
    assert_eq!(
        answer.status == 503 || answer.status == 429,
        answer.headers.contains_key("retry-after"),
        "{whole}"
    );
}
