//! `GET /v1/events`: what happens in this process, as server-sent events, for those who run a fleet.

use std::collections::HashSet;
use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::sse::{Event as SentEvent, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::{Stream, StreamExt, stream};
use jiff::{SignedDuration, Timestamp};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::Service;
use super::access::reach;
use super::extract::Query;
use super::jobs::JobBody;
use super::keys::unconfined;
use super::problem::{Code, Problem};
use super::recognitions::{DecisionBody, PlacePoseBody, RecognitionBody};
use crate::access::Caller;
use crate::database::registry::ServedState;
use crate::database::{FrameHeader, JobEventRow};
use crate::events::{Cursor, Event, EventKind};

/// Most streams at once: each holds a connection.
const MOST_FOLLOWERS: usize = 64;
/// Time between two looks at what is served and at the jobs.
const LOOK_EVERY: Duration = Duration::from_millis(500);
/// So long jobs are watched for those who come back.
const LINGER: SignedDuration = SignedDuration::from_mins(5);
/// Most changes of jobs that are read at once.
const JOB_EVENTS_PAGE: usize = 1000;
/// So long a change of a job may take to be seen.
const OVERLAP: SignedDuration = SignedDuration::from_secs(2);

/// Which events are wanted.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct EventQuery {
    /// Those of this database.
    pub database: Option<String>,
    /// Decisions about frames of this robot, and all that is about no robot.
    pub robot_id: Option<String>,
    /// Kinds, with commas between them: `decision`, `version`, `job`; all by default.
    pub kind: Option<String>,
}

/// What a client has seen of the events.
#[derive(IntoParams)]
#[into_params(parameter_in = Header)]
#[expect(dead_code, reason = "describes the header for the OpenAPI document")]
pub struct LastEvent {
    /// The `id` of the last event seen.
    #[param(rename = "Last-Event-ID", required = false)]
    last_event_id: String,
}

/// What a frame decided.
#[derive(Debug, Serialize, ToSchema)]
pub struct DecisionEvent<'a> {
    pub at: Timestamp,
    pub database: &'a str,
    pub version: i64,
    pub header: &'a FrameHeader,
    /// The track that the frame belongs to.
    pub track: Option<Uuid>,
    /// Of the track, if there is one, else of the frame.
    pub decision: Option<&'a DecisionBody>,
    /// Where the camera is, if that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<&'a PlacePoseBody>,
}

/// A database that answers with another version, or with none.
#[derive(Debug, Serialize, ToSchema)]
pub struct VersionEvent<'a> {
    pub at: Timestamp,
    pub database: &'a str,
    /// What `current` answers with in this process.
    pub version: Option<i64>,
    /// Why an alias doesn't serve what it should.
    pub reason: Option<&'a str>,
}

fn json(body: &impl Serialize) -> String {
    serde_json::to_string(body).expect("text and numbers always serialise")
}

/// Tells those who follow what a frame decided.
pub fn decided(service: &Service, recognition: &RecognitionBody, track: Option<Uuid>) {
    let body = DecisionEvent {
        at: Timestamp::now(),
        database: &recognition.database,
        version: recognition.version,
        header: &recognition.header,
        track,
        decision: recognition.decision.as_ref(),
        pose: recognition.evidence.pose(),
    };
    service.events.publish(Event {
        kind: EventKind::Decision,
        database: Some(recognition.database.clone()),
        robot_id: recognition.header.robot_id.clone(),
        data: json(&body),
    });
}

/// Looks again and again at what is served and, while anybody follows, at the jobs, and tells what changed.
pub async fn watch(service: Service) {
    let mut served = service.databases.registry().states();
    let (mut looked_at, mut told) = (Timestamp::now(), HashSet::new());
    let mut followed_at = None;
    loop {
        tokio::time::sleep(LOOK_EVERY).await;
        let now = service.databases.registry().states();
        if service.ready.load(std::sync::atomic::Ordering::Relaxed) {
            tell_versions(&service, &served, &now);
        }
        served = now;
        if service.events.are_followed() {
            followed_at = Some(Timestamp::now());
        }
        match followed_at {
            Some(at) if at + LINGER >= Timestamp::now() => {}
            _ => {
                // Who comes back after longer is told that some were missed.
                if followed_at.take().is_some() {
                    service.events.forget();
                }
                (looked_at, told) = (Timestamp::now(), HashSet::new());
                continue;
            }
        }
        // With the catalogue away they are told later.
        let Ok(rows) = service.jobs.events_since(looked_at).await else { continue };
        // A change of a longer transaction may come behind a newer one; a page that is full says nothing of what is behind it.
        let newest = rows.last().map_or(looked_at, |row| row.created_at);
        let is_full = rows.len() >= JOB_EVENTS_PAGE;
        looked_at = if is_full { newest.max(looked_at) } else { looked_at.max(newest - OVERLAP) };
        let before = std::mem::replace(&mut told, rows.iter().map(|row| (row.job, row.sequence)).collect());
        for row in rows.into_iter().filter(|row| !before.contains(&(row.job, row.sequence))) {
            tell_job(&service, row);
        }
    }
}

fn tell_versions(service: &Service, before: &[ServedState], now: &[ServedState]) {
    let gone = before.iter().filter(|state| now.iter().all(|other| other.database != state.database));
    let gone: Vec<ServedState> =
        gone.map(|state| ServedState { version: None, reason: None, ..state.clone() }).collect();
    for state in now.iter().filter(|state| !before.contains(state)).chain(&gone) {
        let body = VersionEvent {
            at: Timestamp::now(),
            database: &state.database,
            version: state.version,
            reason: state.reason.as_deref(),
        };
        service.events.publish(Event {
            kind: EventKind::Version,
            database: Some(state.database.clone()),
            robot_id: None,
            data: json(&body),
        });
    }
}

fn tell_job(service: &Service, row: JobEventRow) {
    let database = row.body.database.clone();
    let data = json(&JobBody::from(row.body));
    service.events.publish(Event { kind: EventKind::Job, database, robot_id: None, data });
}

/// One event.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the event for the OpenAPI document")]
pub struct ServiceEvent {
    /// To be sent as `Last-Event-ID`.
    id: String,
    /// `decision`, `version`, `job`; `lost` where events were missed that are no longer kept.
    event: String,
    /// JSON: of a decision `at`, `database`, `version`, `header`, `track`, `decision` and, where the version's exemplars have
    /// poses, `pose`; of a version `at`, `database`, `version`, `reason`; of a job the job.
    #[schema(content_media_type = "application/json")]
    data: String,
}

/// What happens from now on, as server-sent events: decisions about frames that this process answers, versions that it swaps
/// in, jobs of the whole fleet. With `Last-Event-ID` from there on, as far as it is kept: some thousand events. A key sees what
/// it reaches.
#[utoipa::path(
    get, operation_id = "follow_events",
    path = "/v1/events", tag = "service", security(("key" = ["recognise"])), params(EventQuery, LastEvent),
    responses((status = 200, description = "Events", body = ServiceEvent, content_type = "text/event-stream"))
)]
pub async fn get(
    State(service): State<Service>,
    caller: Caller,
    Query(query): Query<EventQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kinds = kinds(query.kind.as_deref())?;
    if let Some(database) = &query.database {
        reach(&caller, database)?;
    }
    let after =
        match headers.get("last-event-id") {
            None => service.events.now(),
            Some(value) => value.to_str().ok().and_then(|text| text.parse().ok()).ok_or_else(|| {
                Problem::field("#Last-Event-ID", "must be the id of an event of this stream")
            })?,
        };
    let follower = service.events.follow(MOST_FOLLOWERS).ok_or_else(|| {
        let text = format!("{MOST_FOLLOWERS} streams of events are open: follow with one for all");
        Problem::new(Code::Overloaded, text)
    })?;
    let (keyring, revocable) = (service.keyring.clone(), caller.clone());
    let revoked = async move { keyring.revoked(&revocable).await };
    let is_wanted = move |event: &Event| {
        kinds.contains(&event.kind)
            && query.database.as_ref().is_none_or(|wanted| event.database.as_ref() == Some(wanted))
            && (query.robot_id.is_none() || event.robot_id.is_none() || event.robot_id == query.robot_id)
            && match &event.database {
                Some(database) => reach(&caller, database).is_ok(),
                None => unconfined(&caller).is_ok(),
            }
    };
    let sent = follow(service, after).map(move |sent| {
        let _open = &follower;
        sent
    });
    let wanted = sent.filter_map(move |sent| {
        let sent = match sent {
            Sent::Event(cursor, event) => is_wanted(&event).then(|| {
                SentEvent::default().id(cursor.to_string()).event(event.kind.as_str()).data(&event.data)
            }),
            Sent::Lost => Some(SentEvent::default().event("lost").data("{}")),
        };
        std::future::ready(sent.map(Ok::<_, Infallible>))
    });
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15));
    Ok(Sse::new(wanted.take_until(Box::pin(revoked))).keep_alive(keep_alive).into_response())
}

fn kinds(given: Option<&str>) -> Result<Vec<EventKind>, Problem> {
    let Some(given) = given else { return Ok(EventKind::ALL.to_vec()) };
    let kind = |word: &str| {
        let found = EventKind::ALL.into_iter().find(|kind| kind.as_str() == word.trim());
        found.ok_or_else(|| Problem::field("#kind", format!("{word:?} is none of decision, version and job")))
    };
    given.split(',').map(kind).collect()
}

enum Sent {
    Event(Cursor, std::sync::Arc<Event>),
    /// Some that came before what follows are no longer kept.
    Lost,
}

/// The events after the cursor, up to shutdown.
fn follow(service: Service, after: Cursor) -> impl Stream<Item = Sent> {
    let batches = stream::unfold(after, move |after| {
        let (events, mut shutdown) = (service.events.clone(), service.shutdown.clone());
        async move {
            let now = events.now();
            let (mut found, mut lost) = events.after(after);
            if found.is_empty() && !lost {
                tokio::select! {
                    () = events.changed(after) => (found, lost) = events.after(after),
                    _ = shutdown.wait_for(|stop| *stop) => return None,
                }
            }
            let next = found.last().map_or(now, |(cursor, _)| *cursor);
            let lost = lost.then_some(Sent::Lost);
            let found = found.into_iter().map(|(cursor, event)| Sent::Event(cursor, event));
            Some((stream::iter(lost.into_iter().chain(found)), next))
        }
    });
    batches.flatten()
}
