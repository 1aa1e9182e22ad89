//! Un-learning: what a robot taught, or what came in a span of time, is deleted, and the next version is the one that
//! would be there if it had never come.

use axum::http::Method;
use serde_json::{Value, json};

use crate::app::{App, request, with_bytes};
use crate::pictures::scene_png;

const KINDS: [&str; 2] = ["landmarks", "objects"];

async fn create(app: &App, database: &str, kind: &str) {
    let options = match kind {
        "landmarks" => json!({"interest_points": 12, "rings": 4, "sectors": 16, "dimension": 8}),
        _ => json!({"width_px": 32, "height_px": 32}),
    };
    app.put(&format!("/v1/databases/{database}"), json!({"kind": kind, "options": options}))
        .await
        .expect(201);
}

/// Two scenes of two places each, as one robot teaches them; the ids.
async fn taught(app: &App, database: &str, robot: &str, first: u64) -> Vec<String> {
    let mut ids = Vec::new();
    for number in first..first + 4 {
        let path = format!("/v1/databases/{database}/exemplars?label=place-{}", number % 2);
        let asked = with_bytes(
            request(Method::POST, &path).header("x-robot-id", robot),
            "image/png",
            scene_png(number),
        );
        let added = app.send(asked).await.expect(201);
        ids.push(added["id"].as_str().unwrap().to_owned());
    }
    ids
}

/// The artifact of the version that answers, and its ETag: the hash of its bytes.
async fn artifact(app: &App, database: &str) -> (Vec<u8>, String) {
    let current = app.get(&format!("/v1/databases/{database}")).await.expect(200)["current_version"].clone();
    let answer = app.get(&format!("/v1/databases/{database}/versions/{current}/artifact")).await;
    assert_eq!(answer.status, 200);
    (answer.body.to_vec(), answer.header("etag").to_owned())
}

/// Whether a text stands in a file.
fn holds(file: &[u8], text: &str) -> bool {
    file.windows(text.len()).any(|bytes| bytes == text.as_bytes())
}

#[tokio::test(flavor = "multi_thread")]
async fn the_next_version_is_as_if_the_robot_had_never_been_there() {
    let app = App::start().await;
    for kind in KINDS {
        let (all, rest) = (format!("{kind}-of-all"), format!("{kind}-of-the-rest"));
        create(&app, &all, kind).await;
        create(&app, &rest, kind).await;
        let gone = taught(&app, &all, "r1", 1).await;
        let kept = taught(&app, &all, "r2", 11).await;
        assert_eq!(taught(&app, &rest, "r2", 11).await, kept);
        app.train(&all, json!({})).await;
        let (before, _) = artifact(&app, &all).await;
        app.delete(&format!("/v1/databases/{all}/exemplars?robot_id=r1")).await.expect(204);
        app.train(&all, json!({})).await;
        app.train(&rest, json!({})).await;

        let (after, etag) = artifact(&app, &all).await;
        assert_eq!(etag, artifact(&app, &rest).await.1, "byte for byte the version of who never knew {kind}");
        if kind == "landmarks" {
            assert!(gone.iter().chain(&kept).all(|id| holds(&before, id)), "a version names its exemplars");
            assert!(gone.iter().all(|id| !holds(&after, id)) && kept.iter().all(|id| holds(&after, id)));
        }
        // The version before is deleted with its last knowledge, and what was deleted is on the record.
        app.delete(&format!("/v1/databases/{all}/versions/1")).await.expect(204);
        let record = app.get(&format!("/v1/audit?database={all}&action=exemplar.delete")).await.expect(200);
        let detail: &Value = &record["items"][0]["detail"];
        assert_eq!((&detail["robot_id"], &detail["deleted"]), (&json!("r1"), &json!(4)));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_span_of_time_is_unlearnt_and_nothing_beside_it() {
    let app = App::start().await;
    create(&app, "lab", "landmarks").await;
    taught(&app, "lab", "r1", 1).await;
    taught(&app, "lab", "r2", 11).await;
    taught(&app, "lab", "r1", 21).await;
    let listed = app.get("/v1/databases/lab/exemplars").await.expect(200);
    let mut times: Vec<String> = (listed["items"].as_array().unwrap().iter())
        .map(|item| item["created_at"].as_str().unwrap().to_owned())
        .collect();
    // RFC 3339 in UTC; the fractions differ in length, so by value.
    times.sort_by_key(|time| time.parse::<jiff::Timestamp>().unwrap());
    let (since, before) = (&times[4], &times[8]);
    let span = format!("since={since}&before={before}");
    let count = async |query: &str| {
        let found = app.get(&format!("/v1/databases/lab/exemplars?{query}")).await.expect(200);
        found["items"].as_array().unwrap().len()
    };
    assert_eq!((count(&span).await, count(&format!("before={since}")).await), (4, 4));
    app.delete(&format!("/v1/databases/lab/exemplars?{span}&robot_id=r1")).await.expect(204);
    assert_eq!(count("").await, 12, "both must match, and r1 taught nothing in that time");
    app.delete(&format!("/v1/databases/lab/exemplars?{span}")).await.expect(204);
    assert_eq!((count("").await, count("robot_id=r2").await), (8, 0));
    app.delete(&format!("/v1/databases/lab/exemplars?since={before}")).await.expect(204);
    assert_eq!(count("robot_id=r1").await, 4);
    app.delete("/v1/databases/lab/exemplars").await.expect_problem(400, "missing_filter");
    app.delete("/v1/databases/lab/exemplars?since=yesterday").await.expect_problem(422, "invalid_field");
}
