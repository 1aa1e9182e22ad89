//! The middleware around every route: request id, span, deadline, panics, problem documents, metrics, one log line.

use std::panic::AssertUnwindSafe;
use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, Method};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::FutureExt;
use tracing::Instrument;
use uuid::Uuid;

use super::Service;
use super::problem::{Code, Problem};
use crate::compute::panic_message;
use crate::telemetry::otlp;

const REQUEST_ID: &str = "x-request-id";
/// Longest request id taken from a caller.
const MAX_REQUEST_ID_BYTES: usize = 128;
/// Factor of the deadline for batches, sweeps and artifacts: they carry many pictures' worth of work.
pub const LONG_CALL: u32 = 10;

/// The id of a call in the log and in the audit record.
#[derive(Clone)]
pub struct RequestId(pub String);

/// Gives the request its id, span and deadline, and turns whatever comes back into one response.
pub async fn request(State(service): State<Service>, mut request: Request, next: Next) -> Response {
    let started = Instant::now();
    let request_id = request_id(&request);
    request.extensions_mut().insert(RequestId(request_id.clone()));
    let method = request.method().clone();
    let path = request.uri().path().to_owned();
    let route =
        request.extensions().get::<MatchedPath>().map_or("unmatched".into(), |m| m.as_str().to_owned());
    let span = tracing::info_span!("request", %method, path, request_id, trace_id = trace_id(&request));
    otlp::continue_trace(&span, request.headers());
    let deadline = deadline(&service, &route);

    let answer = within(deadline, next.run(request)).instrument(span.clone()).await;
    let mut response = with_problem(answer.unwrap_or_else(Problem::into_response), &request_id);
    if let Ok(value) = HeaderValue::from_str(&request_id) {
        response.headers_mut().insert(REQUEST_ID, value);
    }
    let status = response.status().as_u16();
    service.metrics.request(known(&method), &route, status, started.elapsed());
    otlp::note_answer(&span, known(&method), &route, status);
    span.in_scope(|| tracing::info!(status, took_ms = started.elapsed().as_secs_f64() * 1e3, "answered"));
    response
}

/// The response, unless the handler panics or is not done by the deadline.
async fn within(deadline: Duration, handler: impl Future<Output = Response>) -> Result<Response, Problem> {
    match tokio::time::timeout(deadline, AssertUnwindSafe(handler).catch_unwind()).await {
        Ok(Ok(response)) => Ok(response),
        Ok(Err(panic)) => {
            tracing::error!(message = panic_message(&*panic), "a handler panicked");
            Err(Problem::new(Code::Internal, "something went wrong in the service; the log has it"))
        }
        Err(_) => {
            let seconds = deadline.as_secs();
            let text =
                format!("the answer was not ready within {seconds} s: try again, or send less at once");
            Err(Problem::new(Code::DeadlineExceeded, text))
        }
    }
}

/// The response with its problem, if it has one, as a document. Headers that the handler or the router set (Allow) stay,
/// but for those of the document.
fn with_problem(mut response: Response, request_id: &str) -> Response {
    let Some(problem) = response.extensions_mut().remove::<Problem>() else { return response };
    let held = std::mem::take(response.headers_mut());
    let mut response = problem.render(Some(request_id.to_owned()));
    for (name, value) in held {
        if let Some(name) = name.filter(|name| !response.headers().contains_key(name)) {
            response.headers_mut().insert(name, value);
        }
    }
    response
}

fn deadline(service: &Service, route: &str) -> Duration {
    let long = [":batch", "/versions", "/sweep"].iter().any(|end| route.ends_with(end));
    service.limits.request_timeout * if long { LONG_CALL } else { 1 }
}

/// The method as a label of metrics, which must stay few.
fn known(method: &Method) -> &str {
    const KNOWN: [Method; 7] = [
        Method::GET,
        Method::HEAD,
        Method::PUT,
        Method::POST,
        Method::DELETE,
        Method::PATCH,
        Method::OPTIONS,
    ];
    if KNOWN.contains(method) { method.as_str() } else { "OTHER" }
}

/// The caller's id, if it sent a usable one, or a new one.
fn request_id(request: &Request) -> String {
    let sent = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let usable =
        |id: &&str| !id.is_empty() && id.len() <= MAX_REQUEST_ID_BYTES && !id.contains(char::is_control);
    sent.filter(usable).map_or_else(|| Uuid::now_v7().to_string(), str::to_owned)
}

/// The trace id of a W3C `traceparent` (`version-trace-parent-flags`), if the caller sent one.
fn trace_id(request: &Request) -> Option<String> {
    let sent = request.headers().get("traceparent")?.to_str().ok()?;
    let id = sent.split('-').nth(1)?;
    (id.len() == 32 && id.bytes().all(|c| c.is_ascii_hexdigit())).then(|| id.to_owned())
}

/// The response to addresses that no route has.
pub async fn unknown_route(request: Request) -> Problem {
    Problem::new(
        Code::UnknownRoute,
        format!("there is nothing at {}: GET /openapi.json lists every call", request.uri().path()),
    )
}

/// The response to methods that a route doesn't take.
pub async fn method_not_allowed(request: Request) -> Problem {
    Problem::new(
        Code::MethodNotAllowed,
        format!("{} doesn't take {}: see /docs", request.uri().path(), request.method()),
    )
}
