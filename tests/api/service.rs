//! The service about itself: alive, ready, counted, described.

use std::collections::HashMap;

use landmarkd::http::openapi;
use landmarkd::telemetry::Work;
use serde_json::{Value, json};

use crate::app::App;
use crate::pictures::scene_png;

/// The samples of `/metrics`: name with labels → value.
async fn metrics(app: &App) -> HashMap<String, f64> {
    let answer = app.get("/metrics").await;
    assert!(answer.header("content-type").starts_with("text/plain"), "{answer:?}");
    let text = String::from_utf8(answer.body.to_vec()).unwrap();
    let samples = text.lines().filter(|line| !line.starts_with('#'));
    samples
        .map(|line| {
            let (name, value) = line.rsplit_once(' ').unwrap();
            (name.to_owned(), value.parse().unwrap())
        })
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_new_service_is_alive_and_ready() {
    let app = App::start().await;
    assert_eq!(app.get("/livez").await.expect(200), json!({"status": "alive"}));
    let ready = json!({"status": "ready", "databases": [], "catalogue": "ok", "blobs": "ok"});
    assert_eq!(app.get("/readyz").await.expect(200), ready);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_service_that_has_not_loaded_its_versions_is_alive_and_not_ready() {
    let app = App::start_idle().await;
    app.get("/livez").await.expect(200);
    let (status, ready) = app.readiness().await;
    assert_eq!((status, &ready["status"]), (503, &json!("starting")));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_trained_database_is_ready_with_its_version() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let ready = app.get("/readyz").await.expect(200);
    assert_eq!(ready["databases"], json!([{"database": "lab", "version": 1, "state": "ready"}]));
}

#[tokio::test(flavor = "multi_thread")]
async fn metrics_count_requests_by_route_and_status_and_every_stage_of_a_recognition() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let before = metrics(&app).await;
    for stage in Work::Recognition.stages() {
        let count = format!("landmarkd_recognition_stage_seconds_count{{stage=\"{stage}\"}}");
        assert_eq!(before[&count], 0.0, "{stage} is counted before anything was recognised");
    }
    app.recognise("lab", "", scene_png(1)).await;
    app.recognise("lab", "?version=1", scene_png(1)).await;
    app.post_png("/v1/databases/none/recognitions", scene_png(1))
        .await
        .expect_problem(404, "unknown_database");
    app.get("/no/such/address").await.expect_problem(404, "unknown_route");
    let after = metrics(&app).await;
    for stage in Work::Recognition.stages() {
        let count = format!("landmarkd_recognition_stage_seconds_count{{stage=\"{stage}\"}}");
        let of_others = ["fetch", "appearance", "universal", "object"].contains(stage);
        assert_eq!(after[&count], if of_others { 0.0 } else { 2.0 }, "{stage}");
    }
    let route = "/v1/databases/{database}/recognitions";
    for (status, count) in [(200, 2.0), (404, 1.0)] {
        let name =
            format!("landmarkd_requests_total{{method=\"POST\",route=\"{route}\",status=\"{status}\"}}");
        assert_eq!(after.get(&name), Some(&count), "{name}");
    }
    let unmatched = "landmarkd_requests_total{method=\"GET\",route=\"unmatched\",status=\"404\"}";
    assert_eq!(after.get(unmatched), Some(&1.0), "addresses that nobody knows don't become labels");
    assert_eq!(after["landmarkd_jobs{state=\"succeeded\"}"], 1.0);
    assert_eq!(after["landmarkd_jobs{state=\"queued\"}"], 0.0);
    assert_eq!(after["landmarkd_training_seconds_count"], 1.0);
    assert_eq!(after["landmarkd_versions_loaded"], 1.0);
    assert!(after["landmarkd_versions_loaded_bytes"] > 100.0);
    for lane in ["recognition", "training"] {
        assert_eq!(after[&format!("landmarkd_pool_waiting{{lane=\"{lane}\"}}")], 0.0);
        assert!(after.contains_key(&format!("landmarkd_pool_running{{lane=\"{lane}\"}}")));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn info_tells_the_limits_in_force() {
    let app = App::start_with(|settings| {
        settings.limits.max_body_bytes = 2 << 20;
        settings.limits.waiting_per_thread = 5;
    })
    .await;
    let info = app.get("/v1/info").await.expect(200);
    assert_eq!((&info["name"], &info["version"]), (&json!("landmarkd"), &json!(env!("CARGO_PKG_VERSION"))));
    let limits = &info["limits"];
    let expected = [
        ("max_body_bytes", 2 << 20),
        ("max_side_px", 8192),
        ("max_pixels", 50_000_000),
        ("max_decode_bytes", 288 << 20),
        ("max_decode_bytes_total", 1 << 30),
        ("max_batch_parts", 1000),
        ("max_batch_bytes", 512 << 20),
        ("threads", 2),
        ("max_waiting", 10),
        ("request_timeout_ms", 60_000),
        ("header_timeout_ms", 10_000),
        ("body_timeout_ms", 30_000),
    ];
    for (limit, value) in expected {
        assert_eq!(limits[limit], value, "{limit}");
    }
    let formats = ["image/jpeg", "image/png", "image/x-portable-graymap", "image/x-portable-pixmap"];
    assert_eq!(info["formats"], json!(formats));
    assert!(info["worker"].as_str().unwrap().starts_with("worker-"));
    assert!(info["started_at"].as_str().unwrap().ends_with('Z'));
    // One process works alone in a folder.
    assert_eq!(info["role"], "all");
    let (worker, started_at) = (&info["worker"], &info["started_at"]);
    let alone = json!([{"worker": worker, "role": "all", "started_at": started_at, "databases": []}]);
    assert_eq!(info["processes"], alone);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_documentation_comes_from_the_binary_alone() {
    let app = App::start().await;
    let page = app.get("/docs/").await;
    assert_eq!((page.status, page.header("content-type")), (200, "text/html"));
    let html = String::from_utf8(page.body.to_vec()).unwrap();
    assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("\"//"), "{html}");
    let mut parts = 0;
    for part in html.split(['"', '\'']).filter(|part| part.ends_with(".js") || part.ends_with(".css")) {
        let answer = app.get(&format!("/docs/{}", part.trim_start_matches("./"))).await;
        assert!(answer.status == 200 && !answer.body.is_empty(), "{answer:?}");
        parts += 1;
    }
    assert!(parts >= 3, "{html}");
    let start = app.get("/docs/swagger-initializer.js").await;
    let start = String::from_utf8(start.body.to_vec()).unwrap();
    assert!(start.contains("/openapi.json") && !start.contains("http"), "{start}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_contract_that_is_served_is_the_one_that_is_committed() {
    let app = App::start().await;
    let served = app.get("/openapi.json").await.expect(200);
    let committed: Value = serde_json::from_str(include_str!("../../openapi/landmarkd.json")).unwrap();
    assert_eq!(served, committed);
}

#[test]
fn the_committed_contract_is_generated_from_the_code() {
    let committed = include_str!("../../openapi/landmarkd.json");
    assert!(
        openapi::text() == committed,
        "openapi/landmarkd.json is not what the code says: run `cargo run -- openapi > openapi/landmarkd.json`"
    );
}

/// Every operation of the contract with its address.
fn operations(document: &Value) -> Vec<(String, &Value)> {
    let mut all = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            all.push((format!("{method} {path}"), operation));
        }
    }
    all
}

/// Every `$ref` below a value.
fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
    match value {
        Value::Object(members) => {
            found.extend(members.get("$ref").and_then(Value::as_str));
            members.values().for_each(|member| references(member, found));
        }
        Value::Array(items) => items.iter().for_each(|item| references(item, found)),
        _ => {}
    }
}

#[test]
fn every_operation_of_the_contract_has_a_summary_a_schema_and_a_problem() {
    let document: Value = serde_json::from_str(&openapi::text()).unwrap();
    assert_eq!(document["openapi"].as_str().unwrap().split('.').take(2).collect::<Vec<_>>(), ["3", "1"]);
    let operations = operations(&document);
    assert!(operations.len() >= 25, "{} operations", operations.len());
    let mut ids = Vec::new();
    for (address, operation) in &operations {
        assert!(operation["summary"].as_str().is_some_and(|text| text.len() > 5), "{address} has no summary");
        assert_eq!(operation["tags"].as_array().map(Vec::len), Some(1), "{address} has no one tag");
        ids.push(operation["operationId"].as_str().unwrap());
        let responses = operation["responses"].as_object().unwrap();
        let problem = &responses["default"]["content"]["application/problem+json"]["schema"]["$ref"];
        assert_eq!(problem, "#/components/schemas/Problem", "{address} documents no problem");
        let good: Vec<_> = responses.iter().filter(|(status, _)| status.starts_with('2')).collect();
        assert!(!good.is_empty(), "{address} documents no success");
        for (status, response) in good {
            let content = response["content"].as_object();
            assert_eq!(content.is_none(), status == "204", "{address} {status} has no body, or one too many");
            for (media_type, body) in content.into_iter().flatten() {
                assert!(body["schema"].is_object(), "{address} {status} {media_type} has no schema");
            }
        }
    }
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "two operations have one operationId");
}

#[test]
fn every_reference_of_the_contract_leads_somewhere() {
    let document: Value = serde_json::from_str(&openapi::text()).unwrap();
    let mut found = Vec::new();
    references(&document, &mut found);
    assert!(found.len() > 30);
    for reference in found {
        let target = document.pointer(reference.strip_prefix('#').unwrap());
        assert!(
            target.is_some_and(|schema| !schema.as_object().unwrap().is_empty()),
            "{reference} leads nowhere"
        );
    }
}
