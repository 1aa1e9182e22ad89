//! `/v1/jobs[/{id}[/events]]`: long work, watched and cancelled.

use std::convert::Infallible;
use std::time::Duration;

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::{Stream, StreamExt, stream};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::Service;
use super::access::reach;
use super::extract::{Path, Query};
use super::pages::{Page, Paging};
use super::problem::{Problem, ProblemBody};
use crate::access::Caller;
use crate::database::{JobEventRow, JobFilter, JobRow, JobState};
use crate::jobs::{Failure, VersionComparison};

/// A piece of long work.
#[derive(Debug, Serialize, ToSchema)]
pub struct JobBody {
    pub id: Uuid,
    #[schema(example = "training")]
    pub kind: String,
    /// The database that it is about; null for a sweep.
    pub database: Option<String>,
    /// The calibration that it is about; null for a training.
    pub calibration: Option<String>,
    pub state: JobState,
    pub progress: Option<ProgressBody>,
    /// The version it made or found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<i64>,
    /// How the version did beside the one that `current` pointed to, if the training was to promote it `if_not_worse`.
    pub comparison: Option<VersionComparison>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<ProblemBody>,
    /// Who does it, or did it last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worker: Option<String>,
    /// How often it was begun.
    pub attempts: u32,
    pub created_at: Timestamp,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_at: Option<Timestamp>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finished_at: Option<Timestamp>,
}

/// How far a job is.
#[derive(Debug, Serialize, ToSchema)]
pub struct ProgressBody {
    #[schema(example = "describing")]
    pub stage: String,
    pub done: u64,
    pub total: u64,
}

impl From<JobRow> for JobBody {
    fn from(row: JobRow) -> Self {
        Self {
            id: row.id,
            comparison: VersionComparison::of_job(&row),
            kind: row.kind,
            database: row.database,
            calibration: row.calibration,
            state: row.state,
            progress: row.progress.map(|progress| ProgressBody {
                stage: progress.stage,
                // The end of the last step is written with the job's.
                done: if row.state == JobState::Succeeded { progress.total } else { progress.done },
                total: progress.total,
            }),
            version: row.version,
            problem: row.problem.as_deref().map(|kept| Problem::from(Failure::from_document(kept)).into()),
            worker: row.owner,
            attempts: row.attempts,
            created_at: row.created_at,
            started_at: row.started_at,
            finished_at: row.finished_at,
        }
    }
}

/// The answer to a call that queued a job: 202 with its address.
pub fn queued(row: JobRow) -> Response {
    let location = HeaderValue::try_from(format!("/v1/jobs/{}", row.id)).expect("an id is ASCII");
    (StatusCode::ACCEPTED, [(header::LOCATION, location)], Json(JobBody::from(row))).into_response()
}

/// The job that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct JobPath {
    /// Id of the job.
    pub id: Uuid,
}

/// Which jobs are meant.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct JobQuery {
    /// Those of this database.
    pub database: Option<String>,
    /// Those of this calibration.
    pub calibration: Option<String>,
    /// Those in this state.
    #[param(inline)]
    pub state: Option<JobState>,
    /// Most items to give.
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub limit: Option<u32>,
    /// `next_cursor` of the page before.
    pub cursor: Option<String>,
}

/// Jobs, the newest first.
#[utoipa::path(
    get, operation_id = "list_jobs",
    path = "/v1/jobs", tag = "jobs", security(("key" = ["recognise"])), params(JobQuery), responses((status = 200, body = Page<JobBody>))
)]
pub async fn list(
    State(service): State<Service>,
    caller: Caller,
    Query(query): Query<JobQuery>,
) -> Result<Json<Page<JobBody>>, Problem> {
    let Paging { limit, after } = Paging::read(query.limit, query.cursor.as_deref())?;
    let JobQuery { database, calibration, state, .. } = query;
    let filter = JobFilter { database, calibration, state };
    let rows = service.jobs.list(&filter, after, limit).await?;
    let mut page = Page::of(rows, limit, |row| row.id.to_string(), JobBody::from);
    page.items.retain(|job| job.database.as_deref().is_none_or(|database| caller.reaches(database)));
    Ok(Json(page))
}

/// One job.
#[utoipa::path(
    get, operation_id = "get_job",
    path = "/v1/jobs/{id}", tag = "jobs", security(("key" = ["recognise"])), params(JobPath), responses((status = 200, body = JobBody))
)]
pub async fn get(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<JobPath>,
) -> Result<Json<JobBody>, Problem> {
    Ok(Json(reached(&service, &caller, path.id).await?.into()))
}

/// Cancel a job: a waiting one at once, a running one at its next step.
#[utoipa::path(
    delete, operation_id = "cancel_job",
    path = "/v1/jobs/{id}", tag = "jobs", security(("key" = ["train"])), params(JobPath),
    responses((status = 202, body = JobBody, description = "It will end"))
)]
pub async fn cancel(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<JobPath>,
) -> Result<(StatusCode, Json<JobBody>), Problem> {
    reached(&service, &caller, path.id).await?;
    Ok((StatusCode::ACCEPTED, Json(service.jobs.cancel(path.id, &caller.actor()).await?.into())))
}

/// What a client has seen of a job's events.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[expect(dead_code, reason = "describes the header for the OpenAPI document")]
pub struct LastEvent {
    /// Number of the last event seen.
    #[param(rename = "Last-Event-ID", required = false, minimum = 0)]
    last_event_id: i64,
}

/// One event of a job's life.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the event for the OpenAPI document")]
pub struct JobEvent {
    /// Its number.
    id: String,
    /// The job as JSON.
    #[schema(content_media_type = "application/json")]
    data: String,
}

/// A job's life as server-sent events: each the job's body, from its first state on. `id` counts up, `Last-Event-ID`
/// resumes after it, and the stream ends after the last state.
#[utoipa::path(
    get, operation_id = "follow_job",
    path = "/v1/jobs/{id}/events", tag = "jobs", security(("key" = ["recognise"])),
    params(JobPath, LastEvent),
    responses(
        (status = 200, description = "Events whose data is a job", body = JobEvent, content_type = "text/event-stream"),
        (status = 204, description = "The job has ended and you have seen its last event")
    )
)]
pub async fn events(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<JobPath>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let after = match headers.get("last-event-id") {
        None => 0,
        Some(value) => {
            let number = value.to_str().ok().and_then(|text| text.trim().parse().ok());
            number.filter(|number| *number >= 0).ok_or_else(|| {
                Problem::field("#Last-Event-ID", "must be the number of an event of this job")
            })?
        }
    };
    if reached(&service, &caller, path.id).await?.state.is_terminal()
        && service.jobs.events_after(path.id, after).await?.is_empty()
    {
        // 204 makes a browser's EventSource stop reconnecting.
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    let keyring = service.keyring.clone();
    // A key that is revoked ends its streams too.
    let revoked = async move { keyring.revoked(&caller).await };
    let events = follow(service, path.id, after).take_until(Box::pin(revoked));
    Ok(Sse::new(events).keep_alive(keep_alive).into_response())
}

/// The job, if the caller's key reaches its database.
async fn reached(service: &Service, caller: &Caller, id: Uuid) -> Result<JobRow, Problem> {
    let job = service.jobs.get(id).await?;
    if let Some(database) = &job.database {
        reach(caller, database)?;
    }
    Ok(job)
}

/// The events of a job after number `after`, up to its last, or to shutdown.
fn follow(service: Service, id: Uuid, after: i64) -> impl Stream<Item = Result<Event, Infallible>> {
    let rows = stream::unfold(Some(after), move |after| {
        let (jobs, mut shutdown) = (service.jobs.clone(), service.shutdown.clone());
        async move {
            // With the catalogue away the stream ends too; the client resumes with Last-Event-ID.
            let rows = tokio::select! {
                rows = jobs.events_after(id, after?) => rows.ok()?,
                _ = shutdown.wait_for(|stop| *stop) => return None,
            };
            let next = match rows.last() {
                Some(last) if !last.body.state.is_terminal() => Some(last.sequence),
                _ => None,
            };
            Some((stream::iter(rows), next))
        }
    });
    rows.flatten().map(|row| Ok(event(row)))
}

fn event(row: JobEventRow) -> Event {
    let sequence = row.sequence.to_string();
    let body = serde_json::to_string(&JobBody::from(row.body)).expect("text and numbers always serialise");
    Event::default().id(sequence).data(body)
}
