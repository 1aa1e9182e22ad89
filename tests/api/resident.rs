//! Versions whose windows are not in memory: what a frame needs is read from the artifact, and the answers are those of a
//! version in memory.

use axum::http::Method;
use serde_json::{Value, json};

use crate::app::{App, request};
use crate::pictures::scene_png;

const PLACES: u64 = 8;

/// An answer without what differs from one call to the next.
fn told(mut answer: Value) -> Value {
    answer.as_object_mut().unwrap().remove("timings_ms");
    answer
}

/// A gauge of `/metrics`.
async fn gauge(app: &App, name: &str) -> f64 {
    let answer = app.get("/metrics").await;
    let text = String::from_utf8(answer.body.to_vec()).unwrap();
    let value = text.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    value.trim().parse().unwrap()
}

async fn taught() -> App {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "landmarks"})).await.expect(201);
    for number in 0..PLACES {
        app.add("lab", &format!("place-{number}"), number).await;
    }
    app.train("lab", json!({"calibration": "none"})).await;
    app
}

#[tokio::test(flavor = "multi_thread")]
async fn answers_are_those_of_a_version_in_memory_and_what_was_read_stays_for_a_while() {
    let app = taught().await;
    let asked = |app: App| async move {
        let mut answers = Vec::new();
        for number in [0, 3, 7, 40] {
            answers.push(told(app.recognise("lab", "?explain=true&top=5", scene_png(number)).await));
        }
        (answers, app)
    };
    let (in_memory, app) = asked(app).await;
    assert_eq!(in_memory[1]["decision"]["label"], "place-3");
    assert_eq!(gauge(&app, "landmarkd_exemplar_cache_bytes").await, 0.0);
    let whole = gauge(&app, "landmarkd_versions_loaded_bytes").await;

    let folder = app.stop();
    let app = App::open(folder, |settings| settings.resident_limit_bytes = 0).await;
    let held = gauge(&app, "landmarkd_versions_loaded_bytes").await;
    assert!(held < whole, "{held} of {whole} bytes");
    let (read, app) = asked(app).await;
    assert_eq!(read, in_memory);
    assert_eq!(gauge(&app, "landmarkd_exemplars_read{from=\"store\"}").await, PLACES as f64);
    assert_eq!(gauge(&app, "landmarkd_exemplars_read{from=\"cache\"}").await, 3.0 * PLACES as f64);
    let timings = app.recognise("lab", "", scene_png(3)).await["timings_ms"].clone();
    assert!(timings["fetch"].as_f64().unwrap() > 0.0, "{timings}");

    // the evidence drawn, a track, and a version that goes on from this one
    let drawn = app
        .send(
            request(Method::POST, "/v1/databases/lab/recognitions")
                .header("content-type", "image/png")
                .header("accept", "image/png")
                .body(scene_png(3).into())
                .unwrap(),
        )
        .await;
    assert_eq!((drawn.status, drawn.headers["content-type"].to_str().unwrap()), (200, "image/png"));
    let track = app.post("/v1/databases/lab/tracks", json!({"motion": "still"})).await.expect(201);
    let frames = format!("/v1/databases/lab/tracks/{}/frames", track["id"].as_str().unwrap());
    let tracked = app.post_png(&frames, scene_png(5)).await.expect(200);
    assert_eq!(tracked["belief"][0]["label"], "place-5");
    app.add("lab", "place-9", 9).await;
    app.train("lab", json!({"calibration": "none", "eigenspace": "keep", "promote": "if_not_worse"})).await;
    assert_eq!(app.recognise("lab", "", scene_png(9)).await["decision"]["label"], "place-9");
    assert_eq!(
        gauge(&app, "landmarkd_exemplars_read{from=\"store\"}").await,
        PLACES as f64 + 1.0,
        "only the new one"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_artifact_is_told_where_its_bytes_are_needed() {
    let folder = taught().await.stop();
    let blobs = folder.path().join("blobs");
    let artifact = walk(&blobs).into_iter().max_by_key(|path| path.metadata().unwrap().len()).unwrap();
    let whole = std::fs::read(&artifact).unwrap();
    let mut damaged = whole.clone();
    // before the last tensor, among the windows
    let at = damaged.len() - 20_000;
    damaged[at] ^= 1;
    std::fs::write(&artifact, &damaged).unwrap();
    let app = App::open(folder, |settings| {
        settings.resident_limit_bytes = 0;
        // nothing stays
        settings.exemplar_cache_bytes = 0;
    })
    .await;
    let ask = || {
        let asked =
            request(Method::POST, "/v1/databases/lab/recognitions").header("content-type", "image/png");
        asked.body(scene_png(3).into()).unwrap()
    };
    let refused = app.send(ask()).await;
    assert_eq!(refused.status, 409);
    let problem: Value = serde_json::from_slice(&refused.body).unwrap();
    assert_eq!(problem["code"], "version_unloadable");
    assert!(problem["detail"].as_str().unwrap().contains("train again"), "{problem}");
    std::fs::write(&artifact, &whole).unwrap();
    assert_eq!(app.send(ask()).await.status, 200);
}

fn walk(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}
