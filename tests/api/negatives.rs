//! Negative exemplars: pictures without anything known, taught without a label. What looks like them is unknown.

use bytes::Bytes;
use landmarkd_core::imaging::{Frame, Image};
use serde_json::{Value, json};

use crate::app::{App, form, form_type, pointers, tar};
use crate::pictures::{Numbers, png, scene_png};

const HEIGHT_PX: usize = 240;

/// A window of 320 × 240 px of a long wall full of discs and bars, its own for every seed.
fn wall_png(seed: u64, left: usize) -> Bytes {
    let width = 640;
    let mut numbers = Numbers::seeded(seed);
    let mut wall = Image::from_fn(width, HEIGHT_PX, |_, _| 90.0);
    for _ in 0..width * HEIGHT_PX / 400 {
        let (x, y) = (numbers.below(width as u64) as f32, numbers.below(HEIGHT_PX as u64) as f32);
        let (a, b) = (3.0 + numbers.below(22) as f32, 3.0 + numbers.below(12) as f32);
        let (gray, round) = (20.0 + numbers.below(220) as f32, numbers.below(5) < 2);
        for (at, pixel) in wall.pixels_mut().iter_mut().enumerate() {
            let (u, v) = (((at % width) as f32 - x) / a, ((at / width) as f32 - y) / b);
            if if round { u * u + v * v < 1.0 } else { u.abs().max(v.abs()) < 1.0 } {
                *pixel = gray;
            }
        }
    }
    png(&Frame::gray(Image::from_fn(320, HEIGHT_PX, |x, y| wall.at(left + x, y))))
}

async fn create(app: &App, database: &str) {
    let options = json!({"working_size_px": 320, "interest_points": 300, "query_points": 400});
    let body = json!({"kind": "landmarks", "options": options});
    app.put(&format!("/v1/databases/{database}"), body).await.expect(201);
}

async fn teach(app: &App, database: &str, query: &str, picture: Bytes) -> Value {
    app.post_png(&format!("/v1/databases/{database}/exemplars?{query}"), picture).await.expect(201)
}

/// Every value of a member called `label`, wherever it stands.
fn labels(value: &Value) -> Vec<&Value> {
    match value {
        Value::Object(members) => members
            .iter()
            .flat_map(|(name, value)| if name == "label" { vec![value] } else { labels(value) })
            .collect(),
        Value::Array(items) => items.iter().flat_map(labels).collect(),
        _ => Vec::new(),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_a_negative_exemplar_shows_is_unknown_and_says_so() {
    let app = App::start().await;
    create(&app, "lab").await;
    teach(&app, "lab", "label=desk", wall_png(1, 0)).await;
    teach(&app, "lab", "label=door", wall_png(2, 0)).await;
    app.train("lab", json!({"calibration": "none"})).await;
    let frame = wall_png(1, 90);
    let before = app.recognise("lab", "", frame.clone()).await;
    assert_eq!(before["decision"]["label"], "desk", "the picture overlaps that of the desk");

    let negative = teach(&app, "lab", "negative=true", wall_png(1, 80)).await;
    assert_eq!((&negative["label"], &negative["negative"]), (&Value::Null, &json!(true)));
    let job = app.train("lab", json!({"promote": "if_not_worse"})).await;
    assert_eq!(job["comparison"]["promoted"], true, "{job:#}");
    let after = app.recognise("lab", "?explain=true", frame).await;
    assert_eq!(after["decision"], Value::Null, "{after:#}");
    assert_eq!(after["reasons"][0]["code"], "known_background", "{after:#}");
    let remedy = after["reasons"][0]["remedy"].as_str().unwrap();
    assert!(remedy.contains(negative["id"].as_str().unwrap()), "{remedy}");
    assert!(labels(&after).iter().all(|label| **label != json!("")), "{after:#}");
    let desk = app.recognise("lab", "", wall_png(1, 0)).await;
    assert_eq!(desk["decision"]["label"], "desk");

    let version = app.get("/v1/databases/lab/versions/2").await.expect(200);
    assert_eq!((&version["counts"]["exemplars"], &version["counts"]["labels"]), (&json!(3), &json!(2)));
    let verdict = &version["report"]["verdict"];
    assert_eq!(verdict["single_picture_labels"], json!(["desk", "door"]), "{verdict:#}");
    let detail = app.get("/v1/databases/lab").await.expect(200);
    assert_eq!((&detail["exemplars"], &detail["labels"]), (&json!(3), &json!(2)));

    // The artifact brings it to another site.
    let artifact = app.get("/v1/databases/lab/versions/2/artifact").await;
    create(&app, "site").await;
    let imported =
        app.post_bytes("/v1/databases/site/versions", "application/octet-stream", artifact.body).await;
    let number = imported.expect(201)["version"].clone();
    let there = app.recognise("site", &format!("?version={number}"), wall_png(1, 90)).await;
    assert_eq!(there["reasons"][0]["code"], "known_background");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_that_stands_before_a_negative_exemplar_is_elsewhere() {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "landmarks", "options": {"viewpoint": "upright"}}))
        .await
        .expect(201);
    teach(&app, "lab", "label=desk", wall_png(1, 0)).await;
    teach(&app, "lab", "negative=true", wall_png(2, 0)).await;
    app.train("lab", json!({"calibration": "none"})).await;
    let track = app.post("/v1/databases/lab/tracks", json!({})).await.expect(201);
    let path = format!("/v1/databases/lab/tracks/{}/frames", track["id"].as_str().unwrap());
    let mut last = Value::Null;
    for _ in 0..3 {
        last = app.post_png(&path, wall_png(2, 0)).await.expect(200);
    }
    assert!(last["elsewhere"].as_f64().unwrap() > 0.9, "{last:#}");
    assert!(labels(&last["belief"]).iter().all(|label| **label == json!("desk")), "{last:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_negative_exemplar_is_listed_chosen_and_deleted() {
    let app = App::start().await;
    create(&app, "lab").await;
    teach(&app, "lab", "label=desk", scene_png(1)).await;
    let negative = teach(&app, "lab", "negative=true", scene_png(2)).await;
    let again = app.post_png("/v1/databases/lab/exemplars?negative=true", scene_png(2)).await.expect(200);
    assert_eq!(again["id"], negative["id"]);
    let other = teach(&app, "lab", "label=door&negative=false", scene_png(2)).await;
    assert_ne!(other["id"], negative["id"], "the same picture with a label is another exemplar");
    let count = async |query: &str| {
        let listed = app.get(&format!("/v1/databases/lab/exemplars{query}")).await.expect(200);
        listed["items"].as_array().unwrap().len()
    };
    assert_eq!((count("").await, count("?negative=true").await, count("?negative=false").await), (3, 1, 2));
    // an empty label is no label: it chooses none
    assert_eq!(count("?label=").await, 0);
    app.delete("/v1/databases/lab/exemplars?label=").await;
    assert_eq!(count("?negative=true").await, 1);
    app.delete("/v1/databases/lab/exemplars?negative=true").await.expect(204);
    assert_eq!((count("").await, count("?negative=true").await), (2, 0));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_teaches_negative_exemplars_too() {
    let app = App::start().await;
    create(&app, "lab").await;
    let files = [("desk/1.png", scene_png(1)), ("_negative/monday/room__5.png", scene_png(2))];
    let archive = tar(&files).await;
    let path = "/v1/databases/lab/exemplars:batch";
    let answer = app.post_bytes(path, "application/x-tar", archive).await.expect(200);
    assert_eq!((&answer["created"], &answer["rejected"]), (&json!(2), &json!(0)), "{answer:#}");
    let manifest = json!([
        {"file": "a", "negative": true},
        {"file": "b", "negative": true, "label": "desk"},
        {"file": "c"},
    ]);
    let pictures = [3, 4, 5].map(|number| scene_png(number).to_vec());
    let [a, b, c] = pictures;
    let body = form(&[("manifest", manifest.to_string().into_bytes()), ("a", a), ("b", b), ("c", c)]);
    let answer = app.post_bytes(path, &form_type(), body).await.expect(200);
    assert_eq!((&answer["created"], &answer["rejected"]), (&json!(1), &json!(2)), "{answer:#}");
    assert_eq!(pointers(&answer["items"][1]["problem"]), ["/negative"]);
    assert_eq!(pointers(&answer["items"][2]["problem"]), ["/label"]);
    let listed = app.get("/v1/databases/lab/exemplars?negative=true").await.expect(200);
    assert_eq!(listed["items"].as_array().unwrap().len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_has_no_use_for_negative_exemplars_says_what_to_do() {
    let app = App::start().await;
    create(&app, "lab").await;
    app.put("/v1/databases/things", json!({"kind": "objects"})).await.expect(201);
    app.create("paper").await;
    for (database, query, pointer) in [
        ("lab", "negative=true&label=desk", "#negative"),
        ("lab", "", "#label"),
        ("lab", "negative=false", "#label"),
        ("lab", "negative=true&pose_deg=5", "#pose_deg"),
        ("things", "negative=true", "#negative"),
        ("paper", "negative=true", "#negative"),
    ] {
        let path = format!("/v1/databases/{database}/exemplars?{query}");
        let problem = app.post_png(&path, scene_png(1)).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), [pointer], "{query}");
    }
    teach(&app, "lab", "negative=true", scene_png(1)).await;
    app.post("/v1/databases/lab/trainings", json!({})).await.expect_problem(422, "no_exemplars");
    teach(&app, "lab", "label=desk", scene_png(2)).await;
    let intensity = json!({"options": {"signature": "intensity"}});
    let problem =
        app.post("/v1/databases/lab/trainings", intensity).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/options/signature"]);
    assert!(problem["detail"].as_str().unwrap().contains("?negative=true"), "{problem:#}");
}
