//! Hostile values in well-formed requests: numbers that are none or too large, in every document that holds numbers, and
//! pictures with nothing in them, at every call that takes one. What is taken must then be of use.

use axum::http::Method;
use bytes::Bytes;
use landmarkd_core::imaging::encode::png_gray8;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::{Value, json};

use crate::app::{App, form, form_type, request, with_bytes};
use crate::depth_pictures::optics;
use crate::pictures::{THING_PX, Thing, flat_png, png, scene_png, thing};

fn bench() -> Value {
    let places = [[10.0, 10.0], [310.0, 12.0], [8.0, 230.0], [305.0, 225.0]];
    let pairs =
        places.map(|[x, y]| json!({"image_px": [x, y], "robot_mm": [x / 2.0 + 100.0, 300.0 - y / 2.0]}));
    json!({"database": "parts", "correspondences": pairs, "tolerance_px": 2.5,
           "local": {"mm_per_px": 0.1, "rotation_deg": 12.5}, "segmentation": {"offset": 3.5, "min_area_px": 20}})
}

/// Databases of both kinds with a version, a rig and a workcell.
async fn site() -> App {
    let app = App::start().await;
    app.trained("lab", 2).await;
    app.put("/v1/databases/parts", json!({"kind": "objects", "options": {"dimension": 4}})).await.expect(201);
    for turn_deg in (0..360).step_by(45) {
        for (label, which) in [("bar", Thing::Bar), ("wedge", Thing::Wedge)] {
            let path = format!("/v1/databases/parts/exemplars?label={label}&pose_deg={turn_deg}");
            app.post_png(&path, png(&thing(which, f64::from(turn_deg), THING_PX))).await.expect(201);
        }
    }
    app.train("parts", json!({})).await;
    app.put("/v1/calibrations/rig", optics()).await.expect(201);
    app.put("/v1/workcells/bench", bench()).await.expect(201);
    app
}

/// Texts that may stand where a number stands in JSON, most of them wrongly.
const NUMBERS: [&str; 18] = [
    "NaN",
    "Infinity",
    "-Infinity",
    "1e999",
    "-1e999",
    "1e308",
    "-1e308",
    "1e-320",
    "-0.0",
    "0",
    "-1",
    "1e16",
    "18446744073709551616",
    "-9223372036854775809",
    "0.1e",
    "1",
    "null",
    "\"NaN\"",
];

/// The pointers of the numbers in a document.
fn numbers(value: &Value, at: &str, all: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            members.iter().for_each(|(name, member)| numbers(member, &format!("{at}/{name}"), all))
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(number, item)| numbers(item, &format!("{at}/{number}"), all));
        }
        Value::Number(_) => all.push(at.to_owned()),
        _ => {}
    }
}

/// Each number of the document in turn as each of [`NUMBERS`].
fn with_numbers(document: &Value) -> impl Iterator<Item = (String, String)> {
    let mut all = Vec::new();
    numbers(document, "", &mut all);
    all.into_iter().flat_map(move |pointer| {
        NUMBERS.map(|number| {
            let mut changed = document.clone();
            *changed.pointer_mut(&pointer).unwrap() = "@".into();
            (format!("{pointer} = {number}"), changed.to_string().replace("\"@\"", number))
        })
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_number_stands_in_optics_is_refused_or_measured_with() {
    let app = site().await;
    let [near, far] = [scene_png(1), scene_png(2)];
    let mut taken = 0;
    for (what, text) in with_numbers(&optics()) {
        let put = request(Method::PUT, "/v1/calibrations/wild");
        let answer = app.send(with_bytes(put, "application/json", text.clone())).await;
        assert!(matches!(answer.status, 200 | 201 | 400 | 422), "{what}: {answer:?}");
        taken += u32::from(answer.status < 300);
        let parts = [("near", near.clone()), ("far", far.clone()), ("optics", text.into())];
        let measured = app.post_bytes("/v1/depth-maps", &form_type(), form(&parts)).await;
        assert!(matches!(measured.status, 200 | 400 | 422), "{what}: {measured:?}");
        assert!(answer.status < 300 || measured.status >= 400, "{what}: {answer:?} {measured:?}");
    }
    assert!(taken > 0, "some numbers are possible");
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_number_stands_in_a_workcell_is_refused_or_inspected_with() {
    let app = site().await;
    let overview = png(&thing(Thing::Bar, 30.0, 96));
    let mut taken = 0;
    for (what, text) in with_numbers(&bench()) {
        let put = request(Method::PUT, "/v1/workcells/wild");
        let answer = app.send(with_bytes(put, "application/json", text)).await;
        assert!(matches!(answer.status, 200 | 201 | 400 | 422), "{what}: {answer:?}");
        if answer.status < 300 {
            taken += 1;
            let path = "/v1/workcells/wild/inspections";
            let found =
                app.post_bytes(path, &form_type(), form(&[("overview", overview.clone())])).await.expect(200);
            let told = found["objects"]
                .as_array()
                .unwrap()
                .iter()
                .flat_map(|part| part["robot_mm"].as_array().unwrap());
            assert!({ told }.all(Value::is_number), "{what}: {found}");
            app.get("/v1/workcells/wild").await.expect(200);
        }
    }
    assert!(taken > 0, "some numbers are possible");
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_number_stands_in_options_or_a_manifest_is_answered() {
    let app = site().await;
    let segmentation =
        json!({"threshold": 128, "window_px": 15, "offset": 2.5, "min_area_px": 10, "max_objects": 5});
    for (what, text) in with_numbers(&segmentation) {
        let parts = [("image", scene_png(1)), ("options", text.into())];
        let answer = app.post_bytes("/v1/segmentations", &form_type(), form(&parts)).await;
        assert!(matches!(answer.status, 200 | 400 | 422), "{what}: {answer:?}");
    }
    let manifest = json!([{"file": "a", "label": "cup", "pose_deg": 12.5}]);
    for (what, text) in with_numbers(&manifest) {
        let parts = [("manifest", text.into()), ("a", scene_png(9))];
        let answer = app.post_bytes("/v1/databases/lab/exemplars:batch", &form_type(), form(&parts)).await;
        assert!(matches!(answer.status, 200 | 400 | 422), "{what}: {answer:?}");
    }
    for options in [
        json!({"method": "placement", "interest_points": 20, "query_points": 20, "subwindow_radius_px": [8, 12], "rings": 4,
               "sectors": 16, "dimension": 8, "neighbours": 3, "epsilon": 0.5, "position_prior_px": 9.5}),
        json!({"width_px": 32, "height_px": 32, "smoothing": 0.01, "dimension": 4, "accept": 0.9}),
    ] {
        let kind = if options.get("accept").is_some() { "objects" } else { "landmarks" };
        for (what, text) in with_numbers(&json!({"kind": kind, "options": options})) {
            let put = request(Method::PUT, &format!("/v1/databases/wild-{kind}"));
            let answer = app.send(with_bytes(put, "application/json", text)).await;
            assert!(matches!(answer.status, 200 | 201 | 400 | 422), "{what}: {answer:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_with_nothing_in_it_is_answered_by_every_call() {
    let app = site().await;
    let track =
        app.post("/v1/databases/lab/tracks", json!({})).await.expect(201)["id"].as_str().unwrap().to_owned();
    let pictures = [
        Bytes::from(png_gray8(1, 1, &[200])),
        png_gray8(1, 40, &[90; 40]).into(),
        png_gray8(300, 1, &[90; 300]).into(),
        flat_png(0),
        flat_png(255),
    ];
    for (at, picture) in pictures.iter().enumerate() {
        for path in [
            "/v1/databases/parts/recognitions",
            "/v1/segmentations",
            "/v1/workcells/bench/centrings",
            "/v1/databases/lab/exemplars?label=nothing",
            "/v1/databases/parts/exemplars?label=nothing",
            &format!("/v1/databases/lab/tracks/{track}/frames"),
        ] {
            let answer = app.post_png(path, picture.clone()).await;
            assert!(matches!(answer.status, 200 | 201 | 422), "picture {at}: {answer:?}");
        }
        let parts =
            [("near", picture.clone()), ("far", flat_png(9)), ("optics", optics().to_string().into())];
        let measured = app.post_bytes("/v1/depth-maps", &form_type(), form(&parts)).await;
        // Of one size with the other, it has a map without a distance.
        assert!(
            measured.status == 422 || measured.expect(200)["depth_mm"].is_null(),
            "picture {at}: {measured:?}"
        );
        let answer = app
            .post_bytes(
                "/v1/workcells/bench/inspections",
                &form_type(),
                form(&[("overview", picture.clone())]),
            )
            .await;
        assert_eq!(answer.expect(200)["objects"], json!([]), "picture {at}");
    }
    // And they spoil no training: those that can't be used are left out, or the job says what is wrong.
    for database in ["lab", "parts"] {
        let queued =
            app.post(&format!("/v1/databases/{database}/trainings"), json!({"promote": "never"})).await;
        let job = app.finished(&queued.expect(202)).await;
        let reason = job["problem"]["code"].as_str();
        assert!(job["state"] == "succeeded" || reason.is_some_and(|code| code != "internal"), "{job:#}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_is_done_to_a_document_is_answered() {
    let app = site().await;
    let documents = [
        ("/v1/calibrations/wild", optics().to_string()),
        ("/v1/workcells/wild", bench().to_string()),
        (
            "/v1/databases/wild",
            json!({"kind": "objects", "options": {"dimension": 9, "search": "slabs"}}).to_string(),
        ),
    ];
    let edits = prop::collection::vec(
        (
            any::<prop::sample::Index>(),
            prop_oneof![any::<u8>(), prop::sample::select(b"{}[]\",:.0129eE-n".to_vec())],
        ),
        1..4,
    );
    let runner = Config { cases: 300, failure_persistence: None, ..Config::default() };
    let run = TestRunner::new(runner).run(&(0..documents.len(), edits), |(which, edits)| {
        let (path, text) = &documents[which];
        let mut bytes = text.clone().into_bytes();
        for (at, byte) in edits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let answer = app.now(app.send(with_bytes(request(Method::PUT, path), "application/json", bytes)));
        if answer.status < 300 {
            app.now(app.get(path)).expect(200);
            app.now(app.delete(path)).expect(204);
        }
        Ok(())
    });
    run.unwrap();
}
