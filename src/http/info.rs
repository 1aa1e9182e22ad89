//! The service about itself: alive, ready, metrics, info.

use std::sync::atomic::Ordering;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::Serialize;
use utoipa::ToSchema;

use super::Service;
use crate::access::Caller;
use crate::compute::Lane;
use crate::database::registry::ServedState;
use crate::database::{JobState, Process};

/// Alive.
#[derive(Debug, Serialize, ToSchema)]
pub struct Alive {
    #[schema(example = "alive")]
    status: &'static str,
}

/// 200 while the process runs.
#[utoipa::path(get, path = "/livez", tag = "service", security(()), responses((status = 200, body = Alive)))]
pub async fn livez() -> Json<Alive> {
    Json(Alive { status: "alive" })
}

/// Whether the service answers, and with what.
#[derive(Debug, Serialize, ToSchema)]
pub struct Ready {
    status: ReadyStatus,
    databases: Vec<DatabaseReady>,
    catalogue: StoreStatus,
    blobs: StoreStatus,
}

/// `degraded` still answers: something is broken, the rest serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReadyStatus {
    Ready,
    Degraded,
    Starting,
}

/// A store as this process sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StoreStatus {
    Ok,
    Unavailable,
}

/// A database as this process serves it.
#[derive(Debug, Serialize, ToSchema)]
pub struct DatabaseReady {
    database: String,
    /// The version that `current` answers with.
    version: Option<i64>,
    state: ReadyStatus,
    /// Why it is degraded.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl From<ServedState> for DatabaseReady {
    fn from(served: ServedState) -> Self {
        let ServedState { database, version, reason } = served;
        let state = if reason.is_none() { ReadyStatus::Ready } else { ReadyStatus::Degraded };
        Self { database, version, state, reason }
    }
}

/// Longest time that a store may take to answer before it counts as away.
const STORE_TIMEOUT: Duration = Duration::from_secs(1);

/// Whether the service answers recognitions; 503 only while starting or shutting down.
#[utoipa::path(
    get, path = "/readyz", tag = "service", security(()),
    responses((status = 200, body = Ready), (status = 503, body = Ready, description = "Starting or shutting down"))
)]
pub async fn readyz(State(service): State<Service>) -> (StatusCode, Json<Ready>) {
    let (catalogue, blobs) = tokio::join!(
        tokio::time::timeout(STORE_TIMEOUT, service.databases.ping_catalogue()),
        tokio::time::timeout(STORE_TIMEOUT, service.databases.ping_blobs()),
    );
    let store = |is_ok: bool| if is_ok { StoreStatus::Ok } else { StoreStatus::Unavailable };
    let (catalogue, blobs) = (store(matches!(catalogue, Ok(Ok(())))), store(matches!(blobs, Ok(Ok(())))));
    let states = service.databases.registry().states();
    let databases: Vec<DatabaseReady> = states.into_iter().map(DatabaseReady::from).collect();
    let is_well = catalogue == StoreStatus::Ok
        && blobs == StoreStatus::Ok
        && databases.iter().all(|database| database.state == ReadyStatus::Ready);
    let is_ready = service.ready.load(Ordering::Relaxed) && !*service.shutdown.borrow();
    let (code, status) = match (is_ready, is_well) {
        (false, _) => (StatusCode::SERVICE_UNAVAILABLE, ReadyStatus::Starting),
        (true, true) => (StatusCode::OK, ReadyStatus::Ready),
        (true, false) => (StatusCode::OK, ReadyStatus::Degraded),
    };
    (code, Json(Ready { status, databases, catalogue, blobs }))
}

/// Metrics in Prometheus' text format.
#[utoipa::path(
    get, path = "/metrics", tag = "service", security(("key" = ["recognise"])),
    responses((status = 200, body = String, content_type = "text/plain; version=0.0.4"))
)]
pub async fn metrics(State(service): State<Service>) -> Response {
    let metrics = &service.metrics;
    for (name, lane) in
        [("recognition", Lane::Recognition), ("training", Lane::Training), ("upkeep", Lane::Maintenance)]
    {
        metrics.pool_running.with_label_values(&[name]).set(service.compute.running(lane) as i64);
        metrics.pool_waiting.with_label_values(&[name]).set(service.compute.waiting(lane) as i64);
    }
    let (versions, bytes) = service.databases.registry().held();
    metrics.versions_loaded.set(versions as i64);
    metrics.versions_loaded_bytes.set(bytes as i64);
    let exemplars = service.databases.registry().exemplar_cache();
    metrics.exemplar_cache_bytes.set(exemplars.bytes() as i64);
    for (from, count) in ["cache", "store"].into_iter().zip(exemplars.found_and_read()) {
        metrics.exemplars_read.with_label_values(&[from]).set(count as i64);
    }
    let (tracks, bytes) = service.tracks.held();
    metrics.tracks.set(tracks as i64);
    metrics.tracks_bytes.set(bytes as i64);
    // With the catalogue away the last numbers stay.
    if let Ok(counted) = service.jobs.by_state().await {
        for state in JobState::ALL {
            let count = counted.iter().find(|(counted, _)| *counted == state).map_or(0, |(_, count)| *count);
            metrics.jobs.with_label_values(&[state.as_str()]).set(count as i64);
        }
    }
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], metrics.text()).into_response()
}

/// What this service is and what it takes.
#[derive(Debug, Serialize, ToSchema)]
pub struct Info {
    #[schema(example = "landmarkd")]
    name: &'static str,
    /// Release.
    version: &'static str,
    /// Algorithm revision: versions of another revision come from another method.
    revision: i64,
    limits: LimitsBody,
    /// Media types of the pictures that are read.
    formats: Vec<&'static str>,
    started_at: Timestamp,
    /// The name under which this process does jobs.
    worker: String,
    /// Its part of a fleet's work.
    #[schema(value_type = String, example = "all")]
    role: &'static str,
    /// The processes that share the catalogue and what each serves, this one first: as they told within the last
    /// ten seconds. With the catalogue away, this one alone.
    processes: Vec<ProcessBody>,
}

/// A process, and what it serves.
#[derive(Debug, Serialize, ToSchema)]
pub struct ProcessBody {
    worker: String,
    #[schema(example = "serve")]
    role: String,
    started_at: Timestamp,
    databases: Vec<DatabaseReady>,
}

impl From<Process> for ProcessBody {
    fn from(process: Process) -> Self {
        let Process { worker, role, databases, started_at } = process;
        Self { worker, role, started_at, databases: databases.into_iter().map(DatabaseReady::from).collect() }
    }
}

/// What is refused.
#[derive(Debug, Serialize, ToSchema)]
pub struct LimitsBody {
    max_body_bytes: u64,
    max_side_px: u32,
    max_pixels: u64,
    max_decode_bytes: u64,
    max_decode_bytes_total: u64,
    max_body_bytes_total: u64,
    max_batch_parts: u64,
    max_batch_bytes: u64,
    max_artifact_bytes: u64,
    max_tracks: u64,
    max_tracks_bytes: u64,
    track_idle_ms: u64,
    max_waiting: u64,
    threads: u64,
    request_timeout_ms: u64,
    max_connections: u64,
    header_timeout_ms: u64,
    body_timeout_ms: u64,
    idle_timeout_ms: u64,
    write_timeout_ms: u64,
}

/// What this service is and what it takes.
#[utoipa::path(get, path = "/v1/info", tag = "service", security(("key" = ["recognise"])), responses((status = 200, body = Info)))]
pub async fn info(State(service): State<Service>, caller: Caller) -> Json<Info> {
    let limits = &service.limits;
    let threads = service.compute.threads(Lane::Recognition);
    let ms = |duration: Duration| duration.as_millis() as u64;
    let processes = tokio::time::timeout(STORE_TIMEOUT, service.databases.processes()).await;
    let others = processes.ok().and_then(Result::ok).unwrap_or_default();
    let others = others.into_iter().filter(|process| process.worker != *service.worker);
    Json(Info {
        name: "landmarkd",
        version: env!("CARGO_PKG_VERSION"),
        revision: crate::database::ALGORITHM_REVISION,
        limits: LimitsBody {
            max_body_bytes: limits.max_body_bytes,
            max_side_px: limits.max_side_px,
            max_pixels: limits.max_pixels,
            max_decode_bytes: limits.max_decode_bytes,
            max_decode_bytes_total: limits.max_decode_bytes_total,
            max_body_bytes_total: limits.max_body_bytes_total,
            max_batch_parts: limits.max_batch_parts as u64,
            max_batch_bytes: limits.max_batch_bytes,
            max_artifact_bytes: limits.max_artifact_bytes,
            max_tracks: limits.max_tracks as u64,
            max_tracks_bytes: limits.max_tracks_bytes,
            track_idle_ms: ms(limits.track_idle),
            max_waiting: (limits.waiting_per_thread * threads) as u64,
            threads: threads as u64,
            request_timeout_ms: ms(limits.request_timeout),
            max_connections: limits.max_connections as u64,
            header_timeout_ms: ms(limits.header_timeout),
            body_timeout_ms: ms(limits.body_timeout),
            idle_timeout_ms: ms(limits.idle_timeout),
            write_timeout_ms: ms(limits.write_timeout),
        },
        formats: vec!["image/jpeg", "image/png", "image/x-portable-graymap", "image/x-portable-pixmap"],
        started_at: service.started_at,
        worker: service.worker.to_string(),
        role: service.role.as_str(),
        processes: std::iter::once(service.process())
            .chain(others)
            .map(ProcessBody::from)
            .map(|mut process| {
                process.databases.retain(|database| caller.reaches(&database.database));
                process
            })
            .collect(),
    })
}
