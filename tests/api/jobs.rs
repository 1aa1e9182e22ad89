//! Jobs: watched from their first state to their last, cancelled, and failed with a reason.

use axum::body::Body;
use axum::http::Method;
use landmarkd::compute::Lane;
use serde_json::{Value, json};

use crate::app::{App, Occupied, request};
use crate::pictures::flat_png;
use crate::waits::until;

/// One server-sent event: its number and the job as it was then.
fn events(stream: &[u8]) -> Vec<(u64, Value)> {
    let text = std::str::from_utf8(stream).unwrap();
    let blocks = text.split("\n\n").filter(|block| block.lines().any(|line| line.starts_with("data:")));
    blocks
        .map(|block| {
            let field = |name: &str| {
                let line = block.lines().find_map(|line| line.strip_prefix(name));
                line.unwrap_or_else(|| panic!("no {name} in {block:?}")).trim()
            };
            (field("id:").parse().unwrap(), serde_json::from_str(field("data:")).unwrap())
        })
        .collect()
}

/// The events of a job after number `after`, to its end.
async fn followed(app: &App, job: &Value, after: Option<u64>) -> Vec<(u64, Value)> {
    let mut asked = request(Method::GET, &format!("/v1/jobs/{}/events", job["id"].as_str().unwrap()));
    if let Some(after) = after {
        asked = asked.header("last-event-id", after);
    }
    let answer = app.send(asked.body(Body::empty()).unwrap()).await;
    match answer.status {
        // Nothing will come any more: a client that resumes by itself must not try for ever.
        204 => assert!(answer.body.is_empty(), "{answer:?}"),
        status => assert_eq!((status, answer.header("content-type")), (200, "text/event-stream")),
    }
    events(&answer.body)
}

async fn queue(app: &App) -> Value {
    let answer = app.post("/v1/databases/lab/trainings", json!({})).await;
    let job = answer.expect(202);
    assert_eq!(answer.header("location"), format!("/v1/jobs/{}", job["id"].as_str().unwrap()));
    job
}

async fn two_places(app: &App) {
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    app.add("lab", "can", 2).await;
}

async fn reaches(app: &App, job: &Value, state: &str) {
    let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
    until(state, async || app.get(&path).await.expect(200)["state"] == state).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn events_tell_a_jobs_life_from_its_first_state_to_its_last() {
    let app = App::start().await;
    two_places(&app).await;
    let job = queue(&app).await;
    assert_eq!(
        (&job["state"], &job["kind"], &job["database"]),
        (&json!("queued"), &json!("training"), &json!("lab"))
    );
    let events = followed(&app, &job, None).await;
    let numbers: Vec<u64> = events.iter().map(|(number, _)| *number).collect();
    assert_eq!(numbers, (1..=events.len() as u64).collect::<Vec<_>>());
    let mut states: Vec<&str> = events.iter().map(|(_, job)| job["state"].as_str().unwrap()).collect();
    states.dedup();
    assert_eq!(states, ["queued", "running", "succeeded"]);
    let mut stages: Vec<&str> =
        events.iter().filter_map(|(_, job)| job["progress"]["stage"].as_str()).collect();
    stages.dedup();
    assert_eq!(stages, ["describing", "eigenspace", "rehearsing", "calibrating", "publishing"]);
    assert!(events.iter().all(|(_, event)| event["id"] == job["id"]));
    let (_, last) = events.last().unwrap();
    assert_eq!(*last, app.get(&format!("/v1/jobs/{}", job["id"].as_str().unwrap())).await.expect(200));
    assert_eq!((&last["version"], &last["attempts"]), (&json!(1), &json!(1)));
    assert!(last["created_at"].as_str() <= last["started_at"].as_str());
    assert!(last["started_at"].as_str() <= last["finished_at"].as_str());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stream_of_events_resumes_after_the_last_one_seen() {
    let app = App::start().await;
    two_places(&app).await;
    let job = queue(&app).await;
    let whole = followed(&app, &job, None).await;
    for (at, (number, _)) in whole.iter().enumerate() {
        assert_eq!(followed(&app, &job, Some(*number)).await, whole[at + 1..], "after {number}");
    }
    let asked = request(Method::GET, &format!("/v1/jobs/{}/events", job["id"].as_str().unwrap()));
    let asked = asked.header("last-event-id", "the last").body(Body::empty()).unwrap();
    app.send(asked).await.expect_problem(422, "invalid_field");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stream_that_began_while_the_job_waited_sees_it_through() {
    let mut app = App::start_idle().await;
    two_places(&app).await;
    let job = queue(&app).await;
    let path = format!("/v1/jobs/{}/events", job["id"].as_str().unwrap());
    app.begin();
    let (events, ()) = tokio::join!(app.get(&path), async {
        reaches(&app, &job, "succeeded").await;
    });
    assert_eq!(self::events(&events.body).last().unwrap().1["state"], "succeeded");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_waiting_job_is_cancelled_at_once() {
    let mut app = App::start_idle().await;
    two_places(&app).await;
    let job = queue(&app).await;
    let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
    assert_eq!(app.delete(&path).await.expect(202)["state"], "cancelled");
    app.begin();
    let states: Vec<_> =
        followed(&app, &job, None).await.into_iter().map(|(_, job)| job["state"].clone()).collect();
    assert_eq!(states, ["queued", "cancelled"]);
    app.delete(&path).await.expect_problem(409, "job_ended");
    assert_eq!(app.get("/v1/databases/lab").await.expect(200)["versions"], 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_running_job_is_cancelled_at_its_next_step() {
    let app = App::start().await;
    two_places(&app).await;
    let occupied = Occupied::lane(&app, Lane::Training).await;
    let job = queue(&app).await;
    reaches(&app, &job, "running").await;
    let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
    assert_eq!(app.delete(&path).await.expect(202)["state"], "running", "it is asked to end");
    drop(occupied);
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], job.get("version")), (&json!("cancelled"), None));
    assert_eq!(app.get("/v1/databases/lab").await.expect(200)["versions"], 0);
    app.train("lab", json!({})).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_without_exemplars_is_not_trained() {
    let app = App::start().await;
    app.create("lab").await;
    app.post("/v1/databases/lab/trainings", json!({})).await.expect_problem(422, "no_exemplars");
    assert_eq!(app.get("/v1/jobs").await.expect(200)["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_whose_exemplars_went_meanwhile_fails_with_the_reason() {
    let mut app = App::start_idle().await;
    two_places(&app).await;
    let job = queue(&app).await;
    app.delete("/v1/databases/lab/exemplars?label=cup").await.expect(204);
    app.delete("/v1/databases/lab/exemplars?label=can").await.expect(204);
    app.begin();
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["problem"]["code"]), (&json!("failed"), &json!("no_exemplars")));
}

#[tokio::test(flavor = "multi_thread")]
async fn flat_pictures_alone_fail_the_job_with_its_problem() {
    let app = App::start().await;
    app.create("lab").await;
    for level in [0, 128, 255] {
        app.post_png("/v1/databases/lab/exemplars?label=wall", flat_png(level)).await.expect(201);
    }
    let job = app.finished(&queue(&app).await).await;
    assert_eq!(job["state"], "failed");
    let problem = &job["problem"];
    assert_eq!((&problem["code"], &problem["status"]), (&json!("too_few_points"), &json!(422)));
    for member in ["type", "title", "detail"] {
        assert!(problem[member].as_str().is_some_and(|text| !text.is_empty()), "{problem:#}");
    }
    let database = app.get("/v1/databases/lab").await.expect(200);
    assert_eq!((&database["versions"], &database["current_version"]), (&json!(0), &Value::Null));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flat_picture_among_others_is_named_in_the_report() {
    let app = App::start().await;
    two_places(&app).await;
    let flat = app.post_png("/v1/databases/lab/exemplars?label=wall", flat_png(90)).await.expect(201);
    app.train("lab", json!({})).await;
    let version = app.get("/v1/databases/lab/versions/1").await.expect(200);
    assert_eq!(version["report"]["exemplars_without_points"], json!([flat["id"]]));
}

#[tokio::test(flavor = "multi_thread")]
async fn one_picture_under_forty_labels_does_not_break_a_training() {
    let app = App::start().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    // Many labels for one picture: every eigenpoint stands many times.
    for label in 0..40 {
        app.add("lab", &format!("same-{label}"), 2).await;
    }
    app.train("lab", json!({})).await;
    let answer = app.recognise("lab", "?top=100", crate::pictures::scene_png(1)).await;
    assert_eq!(answer["votes"][0]["label"], "cup");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_waiting_job_of_a_deleted_database_ends_and_says_why() {
    let mut app = App::start_idle().await;
    two_places(&app).await;
    let job = queue(&app).await;
    app.delete("/v1/databases/lab").await.expect(204);
    app.begin();
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["database"]), (&json!("cancelled"), &json!("lab")));
    assert_eq!(job["problem"]["code"], "database_deleted", "{job:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_running_job_of_a_deleted_database_ends_and_publishes_nothing() {
    let app = App::start().await;
    two_places(&app).await;
    let occupied = Occupied::lane(&app, Lane::Training).await;
    let job = queue(&app).await;
    reaches(&app, &job, "running").await;
    app.delete("/v1/databases/lab").await.expect(204);
    two_places(&app).await;
    drop(occupied);
    assert_eq!(app.finished(&job).await["state"], "cancelled");
    let database = app.get("/v1/databases/lab").await.expect(200);
    assert_eq!(database["versions"], 0, "the new database of that name got a version of the old one's");
    app.train("lab", json!({})).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn jobs_are_listed_newest_first_by_database_and_state() {
    let app = App::start().await;
    two_places(&app).await;
    app.create("other").await;
    app.add("other", "cup", 1).await;
    app.add("other", "can", 2).await;
    let first = app.train("lab", json!({})).await;
    let second = app.train("other", json!({})).await;
    let third = app.train("lab", json!({})).await;
    let ids = async |query: &str| {
        let page = app.get(&format!("/v1/jobs?{query}")).await.expect(200);
        page["items"].as_array().unwrap().iter().map(|job| job["id"].clone()).collect::<Vec<_>>()
    };
    let [first, second, third] = [first, second, third].map(|job| job["id"].clone());
    assert_eq!(ids("").await, [third.clone(), second.clone(), first.clone()]);
    assert_eq!(ids("database=lab").await, [third.clone(), first.clone()]);
    assert_eq!(ids("state=succeeded&limit=1").await, std::slice::from_ref(&third));
    assert_eq!(ids("state=failed").await, Vec::<Value>::new());
    let cursor = third.as_str().unwrap();
    assert_eq!(ids(&format!("cursor={cursor}")).await, [second, first]);
    app.get("/v1/jobs?state=done").await.expect_problem(422, "invalid_field");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shutdown_hands_the_running_job_back_to_the_next_start() {
    let mut app = App::start().await;
    two_places(&app).await;
    let occupied = Occupied::lane(&app, Lane::Training).await;
    let job = queue(&app).await;
    reaches(&app, &job, "running").await;
    app.leave_jobs();
    let folder = app.stop();
    drop(occupied);
    let app = App::open(folder, |_| ()).await;
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(1)), "{job:#}");
    assert_eq!(job["attempts"], 1, "a job handed back was no attempt: {job:#}");
}
