//! Objects: which one it is and how it is turned, from the first upload to the answer, and every wrong turn before it.

use axum::http::{Method, header};
use bytes::Bytes;
use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::imaging::encode::{png_gray8, png_rgb8};
use landmarkd_core::imaging::{DecodeLimits, Frame, Image, decode};
use serde_json::{Value, json};

use crate::app::{App, form, form_type, request, tar, with_bytes};
use crate::pictures::{THING_PX, Thing, png, scene_png, thing};

const SHELF: &str = "/v1/databases/shelf";
const THINGS: [(&str, Thing); 3] = [("bar", Thing::Bar), ("wedge", Thing::Wedge), ("pair", Thing::Pair)];
const FILE: &str = "application/octet-stream";

fn picture(which: Thing, turn_deg: f64) -> Bytes {
    png(&thing(which, turn_deg, THING_PX))
}

async fn create(app: &App, options: Value) {
    app.put(SHELF, json!({"kind": "objects", "options": options})).await.expect(201);
}

async fn add(app: &App, query: &str, picture: Bytes) -> Value {
    let answer = app.post_png(&format!("{SHELF}/exemplars?{query}"), picture).await;
    assert!(matches!(answer.status, 200 | 201), "{answer:?}");
    answer.json()
}

/// Three things, seen at every 15°, as an archive whose names give the poses.
async fn fill(app: &App) {
    let views = THINGS.into_iter().flat_map(|(label, which)| {
        (0..24).map(move |n| {
            let turn_deg = 15.0 * f64::from(n);
            (format!("{label}/view__{turn_deg}.png"), picture(which, turn_deg))
        })
    });
    let archive = tar(&views.collect::<Vec<_>>()).await;
    let batch = app.post_bytes(&format!("{SHELF}/exemplars:batch"), "application/x-tar", archive).await;
    assert_eq!(batch.expect(200)["created"], 72);
}

async fn shelf() -> App {
    let app = App::start().await;
    create(&app, json!({"dimension": 12})).await;
    fill(&app).await;
    app.train("shelf", json!({})).await;
    app
}

/// Train what is asked to fail; the problem of the call or of the job.
async fn refusal(app: &App, options: Value) -> Value {
    let answer = app.post(&format!("{SHELF}/trainings"), json!({"options": options})).await;
    if answer.status != 202 {
        assert_eq!(answer.status, 422, "{answer:?}");
        return answer.json();
    }
    let job = app.finished(&answer.json()).await;
    assert_eq!(job["state"], "failed", "{job:#}");
    job["problem"].clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn things_are_named_and_their_poses_told_between_the_views() {
    let app = shelf().await;
    for (label, which) in THINGS {
        for turn_deg in [7.5, 100.0, 218.0, 352.5] {
            let answer = app.recognise("shelf", "", picture(which, turn_deg)).await;
            assert_eq!(answer["decision"]["label"], label, "{turn_deg}: {answer:#}");
            let pose = &answer["pose"];
            let told_deg = pose["turn_deg"].as_f64().unwrap();
            assert!(angular_distance_deg(told_deg, turn_deg) < 3.0, "{label} at {turn_deg}: {answer:#}");
            assert!((0.0..360.0).contains(&told_deg) && pose["sigma_deg"].as_f64().unwrap() > 0.0);
            // The two ends of the bar are of one shape: held-out views were taken for the other side, or that is named.
            let other_deg = pose["alternative_deg"].as_f64();
            let is_doubted = other_deg.is_some_and(|other| angular_distance_deg(other, told_deg) > 170.0)
                || pose["sigma_deg"].as_f64().unwrap() > 10.0;
            assert!(
                pose["reliable"] == true || label == "bar" && is_doubted,
                "{label} at {turn_deg}: {answer:#}"
            );
        }
    }
    let larger = app.recognise("shelf", "", png(&thing(Thing::Bar, 100.0, 2 * THING_PX))).await;
    assert_eq!((&larger["decision"]["label"], &larger["warnings"]), (&json!("bar"), &json!(["resized"])));
    assert!(angular_distance_deg(larger["pose"]["turn_deg"].as_f64().unwrap(), 100.0) < 3.0, "{larger:#}");
    let unknown = app.recognise("shelf", "", picture(Thing::Ring, 0.0)).await;
    assert_eq!((&unknown["decision"], &unknown["pose"]), (&Value::Null, &Value::Null), "{unknown:#}");
    assert_eq!(unknown["warnings"][0], "beyond_threshold");
    assert_eq!(unknown["candidates"].as_array().unwrap().len(), 3, "the evidence is given in any case");
    assert_eq!(
        (&unknown["alignment"], &unknown["reasons"][0]["code"]),
        (&Value::Null, &json!("unlike_anything"))
    );
}

/// A thing that is moved by whole pixels; beyond its picture, ground.
fn moved(which: Thing, turn_deg: f64, right_px: isize, down_px: isize) -> Bytes {
    let luminance = thing(which, turn_deg, THING_PX).luminance;
    let at = |x: usize, y: usize| {
        let from = |v: usize, by: isize| (v as isize - by).clamp(0, THING_PX as isize - 1) as usize;
        luminance.at(from(x, right_px), from(y, down_px))
    };
    png(&Frame::gray(Image::from_fn(THING_PX, THING_PX, at)))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_thing_that_moved_is_named_with_its_place_and_far_away_the_reason_is_told() {
    let app = shelf().await;
    let answer = app.recognise("shelf", "", moved(Thing::Wedge, 100.0, 2, -1)).await;
    assert_eq!(answer["decision"]["label"], "wedge", "{answer:#}");
    let px = |name: &str| answer["alignment"][name].as_f64().unwrap();
    assert!((px("shift_x_px") - 2.0).abs() < 0.7 && (px("shift_y_px") + 1.0).abs() < 0.7, "{answer:#}");
    assert!(angular_distance_deg(answer["pose"]["turn_deg"].as_f64().unwrap(), 100.0) < 5.0, "{answer:#}");
    assert_eq!(answer["reasons"], json!([]));

    let far = app.recognise("shelf", "", moved(Thing::Wedge, 100.0, THING_PX as isize / 4, 0)).await;
    assert_eq!(far["decision"], Value::Null, "{far:#}");
    let reason = &far["reasons"][0];
    assert_eq!(reason["code"], "off_centre", "{far:#}");
    assert!(reason["detail"].as_str().unwrap().contains("wedge") && reason["remedy"].is_string(), "{far:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_has_the_evidence_of_its_kind_and_no_other() {
    let app = shelf().await;
    let answer = app.recognise("shelf", "?top=2&explain=true", picture(Thing::Bar, 40.0)).await;
    let members = |value: &Value| -> Vec<String> { value.as_object().unwrap().keys().cloned().collect() };
    let sorted = |mut names: Vec<String>| {
        names.sort_unstable();
        names
    };
    let all = [
        "alignment",
        "candidates",
        "database",
        "decision",
        "digest",
        "header",
        "kind",
        "pose",
        "reasons",
        "timings_ms",
        "version",
        "warnings",
    ];
    assert_eq!(sorted(members(&answer)), all);
    assert_eq!((&answer["kind"], &answer["version"]), (&json!("objects"), &json!(1)));
    let confidence = answer["decision"]["confidence"].as_f64().unwrap();
    assert!((0.5..=1.0).contains(&confidence), "{answer:#}");
    let candidates = answer["candidates"].as_array().unwrap();
    assert_eq!((candidates.len(), &candidates[0]["label"]), (2, &json!("bar")));
    let one =
        ["distance_from_space", "distance_in_space", "explained", "label", "least_explained", "threshold"];
    assert_eq!(sorted(members(&candidates[0])), one);
    let explained = |candidate: &Value| candidate["explained"].as_f64().unwrap();
    assert!(explained(&candidates[0]) > explained(&candidates[1]));
    assert!(explained(&candidates[0]) >= candidates[0]["least_explained"].as_f64().unwrap());
    let timings = ["appearance", "decode", "object", "queue", "recognise", "universal"];
    assert_eq!(sorted(members(&answer["timings_ms"])), timings);
    let metrics = app.get("/metrics").await;
    let metrics = std::str::from_utf8(&metrics.body).unwrap();
    for (stage, count) in [("decode", 1), ("appearance", 1), ("universal", 1), ("object", 1), ("vote", 0)] {
        let line = format!("landmarkd_recognition_stage_seconds_count{{stage=\"{stage}\"}} {count}\n");
        assert!(metrics.contains(&line), "{line} {metrics}");
    }

    app.train("shelf", json!({"options": {"appearance": "intensity"}})).await;
    let answer = app.recognise("shelf", "", picture(Thing::Bar, 40.0)).await;
    let candidates = answer["candidates"].as_array().unwrap();
    let distance = |candidate: &Value| {
        let of = |name: &str| candidate[name].as_f64().unwrap();
        of("distance_in_space").hypot(of("distance_from_space"))
    };
    assert!(distance(&candidates[0]) < distance(&candidates[1]));
    assert!(distance(&candidates[0]) <= candidates[0]["threshold"].as_f64().unwrap());
    assert_eq!((&candidates[0]["explained"], &answer["alignment"]), (&Value::Null, &Value::Null));

    let mahalanobis = json!({"options": {"distance": "mahalanobis", "stages": "universal_only"}});
    app.train("shelf", mahalanobis).await;
    let answer = app.recognise("shelf", "", picture(Thing::Bar, 40.0)).await;
    assert!(answer["candidates"][0]["mahalanobis"].is_f64(), "{answer:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_three_searches_answer_alike() {
    let app = shelf().await;
    let mut answers = Vec::new();
    for search in ["exhaustive", "kd_tree", "slabs"] {
        app.train("shelf", json!({"options": {"search": search}})).await;
        let answer = app.recognise("shelf", "", picture(Thing::Pair, 111.0)).await;
        answers.push(["decision", "candidates", "pose"].map(|member| answer[member].clone()));
    }
    assert!(answers.iter().all(|answer| *answer == answers[0]), "{answers:#?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_training_reports_rates_poses_gaps_and_repeats() {
    let app = App::start().await;
    create(&app, json!({})).await;
    fill(&app).await;
    // One view twice: the same pose, and nearly the same picture.
    let twice = png(&thing(Thing::Bar, 0.01, THING_PX));
    add(&app, "label=bar&pose_deg=0", twice).await;
    let gone = app.get(&format!("{SHELF}/exemplars?label=wedge&limit=1000")).await.expect(200);
    for exemplar in gone["items"].as_array().unwrap() {
        if (105.0..=180.0).contains(&exemplar["pose_deg"].as_f64().unwrap()) {
            app.delete(&format!("{SHELF}/exemplars/{}", exemplar["id"].as_str().unwrap())).await.expect(204);
        }
    }
    app.train("shelf", json!({})).await;
    let version = app.get(&format!("{SHELF}/versions/1")).await.expect(200);
    assert_eq!(version["counts"], json!({"exemplars": 67, "labels": 3, "interest_points": 0}));
    let report = &version["report"];
    assert_eq!((&report["width_px"], &report["height_px"]), (&json!(THING_PX), &json!(THING_PX)));
    let dimension = report["dimension"].as_u64().unwrap() as usize;
    let spectrum = report["spectrum"].as_array().unwrap();
    assert!((1..=64).contains(&dimension) && spectrum.len() >= dimension, "{report:#}");
    let rates = report["rate_by_dimension"].as_array().unwrap();
    let rate = |at: usize| rates.iter().find(|rate| rate["dimension"] == at).unwrap()["right"].as_u64();
    assert!(rates.iter().all(|other| other["right"].as_u64() <= rate(dimension)), "{rates:#?}");
    let held_out = &report["held_out"];
    let of = |name: &str| held_out[name].as_u64().unwrap();
    assert!(of("known") >= 66 && of("known_right") * 10 >= of("known") * 8, "{held_out:#}");
    assert!(of("unknown_refused") * 2 > of("unknown"), "{held_out:#}");
    let labels: Vec<_> =
        report["objects"].as_array().unwrap().iter().map(|object| &object["label"]).collect();
    assert_eq!(labels, ["bar", "pair", "wedge"]);
    let gaps = &report["objects"][2]["gaps"];
    assert_eq!(gaps, &json!([{"from_deg": 90.0, "to_deg": 195.0}]), "{report:#}");
    assert_eq!(report["objects"][1]["gaps"], json!([]));
    assert!(report["objects"][1]["pose"]["median_deg"].as_f64().unwrap() < 5.0, "{report:#}");
    assert_eq!(report["repeated_poses"].as_array().unwrap().len(), 1, "{report:#}");
    assert!(report["timings_ms"]["eigenspace"].as_f64().unwrap() > 0.0);

    // Where a thing was never seen, its pose is told and not to be acted on.
    let answer = app.recognise("shelf", "", picture(Thing::Wedge, 140.0)).await;
    assert_ne!(answer["pose"]["reliable"], true, "{answer:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_is_answered_in_order_with_the_bad_one_in_its_place() {
    let app = shelf().await;
    let parts = [
        ("image", picture(Thing::Wedge, 33.0)),
        ("image", Bytes::from_static(b"no picture")),
        ("image", picture(Thing::Bar, 200.0)),
    ];
    let path = format!("{SHELF}/recognitions:batch");
    let batch = app.post_bytes(&path, &form_type(), form(&parts)).await.expect(200);
    assert_eq!(batch["items"][0]["decision"]["label"], "wedge");
    assert_eq!(batch["items"][1]["problem"]["code"], "unsupported_image_format");
    assert!(
        angular_distance_deg(batch["items"][2]["pose"]["turn_deg"].as_f64().unwrap(), 200.0) < 3.0,
        "{batch:#}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn an_answer_can_be_had_as_a_picture() {
    let app = shelf().await;
    let accept = request(Method::POST, &format!("{SHELF}/recognitions")).header(header::ACCEPT, "image/png");
    let drawn = app.send(with_bytes(accept, "image/png", picture(Thing::Bar, 75.0))).await;
    assert_eq!((drawn.status, drawn.header("content-type")), (200, "image/png"), "{drawn:?}");
    assert_eq!(drawn.header("x-version"), "1");
    let frame = decode(&drawn.body, &DecodeLimits::default()).unwrap();
    let green = frame.to_rgb8().chunks_exact(3).filter(|rgb| *rgb == [64, 224, 96]).count();
    assert!(green > 50, "{green} px say what it is and how it is turned");
}

#[tokio::test(flavor = "multi_thread")]
async fn eigenimages_are_pictures_and_known_ones_are_not_sent_again() {
    let app = shelf().await;
    let version = app.get(&format!("{SHELF}/versions/1")).await.expect(200);
    let dimension = version["report"]["dimension"].as_u64().unwrap();
    let path = |which: &str| format!("{SHELF}/versions/1/eigenimages/{which}");
    let mut seen = Vec::new();
    for which in ["mean".to_owned(), "0".to_owned(), (dimension - 1).to_string()] {
        let answer = app.get(&path(&which)).await;
        assert_eq!((answer.status, answer.header("content-type")), (200, "image/png"), "{answer:?}");
        let frame = decode(&answer.body, &DecodeLimits::default()).unwrap();
        let levels = frame.luminance.pixels();
        assert!(levels.iter().any(|v| *v != levels[0]) && levels.iter().any(|v| *v > 200.0), "{which}");
        let etag = answer.header("etag").to_owned();
        let again = request(Method::GET, &path(&which)).header(header::IF_NONE_MATCH, &etag);
        let known = app.send(again.body(axum::body::Body::empty()).unwrap()).await;
        assert_eq!((known.status, known.header("etag")), (304, etag.as_str()));
        assert!(!seen.contains(&etag), "each has an ETag of its own");
        seen.push(etag);
    }
    let problem = app.get(&path(&dimension.to_string())).await.expect_problem(404, "unknown_eigenimage");
    assert!(problem["detail"].as_str().unwrap().contains(&format!("has {dimension} eigenimages")));
    app.get(&path("99999999999999999999999")).await.expect_problem(404, "unknown_eigenimage");
    for wrong in ["-1", "+1", "1.5", "means"] {
        let problem = app.get(&path(wrong)).await.expect_problem(422, "invalid_field");
        assert_eq!(problem["errors"][0]["pointer"], "#image", "{problem:#}");
    }
    app.get(&format!("{SHELF}/versions/2/eigenimages/mean")).await.expect_problem(404, "unknown_version");

    app.trained("lab", 2).await;
    let problem = app.get("/v1/databases/lab/versions/1/eigenimages/0").await;
    let problem = problem.expect_problem(404, "unknown_eigenimage");
    assert!(problem["detail"].as_str().unwrap().contains("landmarks"), "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_of_objects_tells_its_options_and_takes_others() {
    let app = App::start().await;
    let created = app.put(SHELF, json!({"kind": "objects"})).await.expect(201);
    let defaults = json!({
        "appearance": "gradient", "colour": "auto",
        "width_px": null, "height_px": null, "resize": "fit", "smoothing": 1.5 / 128.0, "segment": false,
        "dimension": "auto", "stages": "universal_then_object", "search": "kd_tree",
        "distance": "euclidean", "accept": 0.98,
    });
    assert_eq!((&created["kind"], &created["options"]), (&json!("objects"), &defaults));
    let options = json!({"dimension": 12, "segment": false, "width_px": 64, "height_px": 64});
    let changed = app.put(SHELF, json!({"kind": "objects", "options": options})).await.expect(200);
    assert_eq!((&changed["options"]["dimension"], &changed["options"]["width_px"]), (&json!(12), &json!(64)));
    assert_eq!(app.get("/v1/databases").await.expect(200)["items"], json!([changed]));

    // Another appearance brings its own defaults.
    let options = json!({"appearance": "intensity", "dimension": 9});
    let changed = app.put(SHELF, json!({"kind": "objects", "options": options})).await.expect(200);
    let of = |name: &str| changed["options"][name].clone();
    assert_eq!(
        (of("smoothing"), of("colour"), of("accept")),
        (json!(3.0 / 128.0), json!("gray"), json!(0.97))
    );
    let coloured = json!({"kind": "objects", "options": {"appearance": "intensity", "colour": "opponent"}});
    let problem = app.put(SHELF, coloured).await.expect_problem(422, "invalid_field");
    assert_eq!(problem["errors"][0]["pointer"], "/options/colour");
}

#[tokio::test(flavor = "multi_thread")]
async fn options_that_objects_do_not_have_are_named_all_at_once() {
    let app = App::start().await;
    let options = json!({
        "interest_points": 64, "dimension": 0, "accept": 1, "resize": "crop", "width_px": 64, "search": 5,
    });
    let problem = app.put(SHELF, json!({"kind": "objects", "options": options})).await;
    let problem = problem.expect_problem(422, "invalid_field");
    let mut named: Vec<_> =
        problem["errors"].as_array().unwrap().iter().map(|e| e["pointer"].as_str().unwrap()).collect();
    named.sort_unstable();
    let wrong = ["accept", "dimension", "height_px", "interest_points", "resize", "search"];
    assert_eq!(named, wrong.map(|option| format!("/options/{option}")), "{problem:#}");
    app.get(SHELF).await.expect_problem(404, "unknown_database");

    // In a training likewise.
    create(&app, json!({})).await;
    let asked = json!({"options": {"rings": 8, "accept": 0.1}});
    let problem = app.post(&format!("{SHELF}/trainings"), asked).await.expect_problem(422, "invalid_field");
    assert_eq!(problem["errors"].as_array().unwrap().len(), 2, "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn removing_the_background_is_an_option_that_is_told() {
    let app = App::start().await;
    create(&app, json!({"segment": true})).await;
    assert_eq!(app.get(SHELF).await.expect(200)["options"]["segment"], true);
    fill(&app).await;
    app.train("shelf", json!({"options": {"dimension": 12}})).await;
    assert_eq!(app.get(&format!("{SHELF}/versions/1")).await.expect(200)["options"]["segment"], true);
    // The same thing, smaller and off the middle.
    let (small, side) = (thing(Thing::Wedge, 40.0, THING_PX), 2 * THING_PX);
    let at = |v: usize| v.checked_sub(THING_PX / 3).filter(|v| *v < THING_PX);
    let shifted =
        Image::from_fn(side, side, |x, y| at(x).zip(at(y)).map_or(0.0, |(x, y)| small.luminance.at(x, y)));
    let answer = app.recognise("shelf", "", png(&Frame::gray(shifted))).await;
    assert_eq!(answer["decision"]["label"], "wedge", "{answer:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_database_stays_of_its_kind() {
    let app = App::start().await;
    create(&app, json!({})).await;
    let problem = app.put(SHELF, json!({"kind": "landmarks"})).await.expect_problem(409, "kind_conflict");
    assert!(problem["detail"].as_str().unwrap().contains("objects"), "{problem:#}");
    app.create("lab").await;
    app.put("/v1/databases/lab", json!({"kind": "objects"})).await.expect_problem(409, "kind_conflict");
    // Options of the kind asked for, which the database isn't.
    let asked = json!({"kind": "objects", "options": {"dimension": "auto"}});
    app.put("/v1/databases/lab", asked).await.expect_problem(409, "kind_conflict");
}

#[tokio::test(flavor = "multi_thread")]
async fn too_few_exemplars_are_refused_before_a_job_is_made() {
    let app = App::start().await;
    create(&app, json!({})).await;
    let path = format!("{SHELF}/trainings");
    app.post(&path, json!({})).await.expect_problem(422, "no_exemplars");
    add(&app, "label=bar&pose_deg=0", picture(Thing::Bar, 0.0)).await;
    let problem = app.post(&path, json!({})).await.expect_problem(422, "too_few_exemplars");
    assert!(problem["detail"].as_str().unwrap().contains("post more"), "{problem:#}");
    assert_eq!(app.get("/v1/jobs").await.expect(200)["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn equal_pictures_are_refused_whether_the_files_or_only_their_pixels_are_equal() {
    let app = App::start().await;
    create(&app, json!({})).await;
    for query in ["label=bar&pose_deg=0", "label=bar&pose_deg=90", "label=wedge"] {
        add(&app, query, picture(Thing::Bar, 0.0)).await;
    }
    let path = format!("{SHELF}/trainings");
    app.post(&path, json!({})).await.expect_problem(422, "all_equal");

    // The same pixels in another file: only decoding tells.
    let frame = thing(Thing::Bar, 0.0, THING_PX);
    let levels: Vec<u8> = frame.luminance.pixels().iter().map(|v| v.round() as u8).collect();
    let colours: Vec<u8> = levels.iter().flat_map(|level| [*level; 3]).collect();
    assert_eq!(picture(Thing::Bar, 0.0), Bytes::from(png_gray8(THING_PX, THING_PX, &levels)));
    add(&app, "label=bar&pose_deg=180", png_rgb8(THING_PX, THING_PX, &colours).into()).await;
    let problem = refusal(&app, json!({})).await;
    assert_eq!(problem["code"], "all_equal", "{problem:#}");
    assert!(problem["detail"].as_str().unwrap().contains("post others"), "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn black_pictures_show_nothing() {
    let app = App::start().await;
    create(&app, json!({})).await;
    add(&app, "label=bar", picture(Thing::Bar, 0.0)).await;
    add(&app, "label=bar", png_gray8(THING_PX, THING_PX, &[0; THING_PX * THING_PX]).into()).await;
    assert_eq!(refusal(&app, json!({})).await["code"], "too_few_exemplars");
    add(&app, "label=bar", picture(Thing::Bar, 90.0)).await;
    app.train("shelf", json!({})).await;
    let report = &app.get(&format!("{SHELF}/versions/1")).await.expect(200)["report"];
    assert_eq!(report["blank"].as_array().unwrap().len(), 1);
    let black = png_gray8(THING_PX, THING_PX, &[0; THING_PX * THING_PX]);
    let answer = app.recognise("shelf", "", black.into()).await;
    assert_eq!(answer["decision"], Value::Null);
    assert_eq!(answer["warnings"], json!(["blank_picture"]));
}

#[tokio::test(flavor = "multi_thread")]
async fn sizes_that_differ_are_scaled_or_refused_as_the_database_will_have_it() {
    let app = App::start().await;
    create(&app, json!({"resize": "never"})).await;
    for turn_deg in [0.0, 60.0, 120.0] {
        add(&app, &format!("label=bar&pose_deg={turn_deg}"), picture(Thing::Bar, turn_deg)).await;
    }
    let small = png(&thing(Thing::Bar, 180.0, 32));
    let small = add(&app, "label=bar&pose_deg=180", small).await;
    let path = format!("{SHELF}/trainings");
    let problem = app.post(&path, json!({})).await.expect_problem(422, "image_size_mismatch");
    let text = problem["detail"].as_str().unwrap();
    for part in ["3 of 48×48 px", "1 of 32×32 px", "resize fit"] {
        assert!(text.contains(part), "{part}: {problem:#}");
    }
    // All of one size, and that isn't the one asked for.
    let asked = json!({"options": {"width_px": 32, "height_px": 32}});
    app.post(&path, asked).await.expect_problem(422, "image_size_mismatch");

    // Scaled, and the report says which.
    app.train("shelf", json!({"options": {"resize": "fit"}})).await;
    let report = &app.get(&format!("{SHELF}/versions/1")).await.expect(200)["report"];
    assert_eq!((&report["resized"], &report["width_px"]), (&json!([small["id"]]), &json!(48)));
    let large = png(&thing(Thing::Bar, 60.0, 96));
    let answer = app.recognise("shelf", "", large.clone()).await;
    assert_eq!(answer["warnings"][0], "resized", "{answer:#}");
    assert_eq!(answer["candidates"][0]["label"], "bar");

    // Or the odd one deleted: then queries of another size are refused too, alone and in a batch.
    app.delete(&format!("{SHELF}/exemplars/{}", small["id"].as_str().unwrap())).await.expect(204);
    assert_eq!(app.train("shelf", json!({})).await["version"], 2);
    let asked = format!("{SHELF}/recognitions");
    let problem = app.post_png(&asked, large.clone()).await.expect_problem(422, "image_size_mismatch");
    assert!(problem["detail"].as_str().unwrap().contains("48×48"), "{problem:#}");
    let accept = request(Method::POST, &asked).header(header::ACCEPT, "image/png");
    let drawn = app.send(with_bytes(accept, "image/png", large.clone())).await;
    drawn.expect_problem(422, "image_size_mismatch");
    let parts = [("image", large), ("image", picture(Thing::Bar, 60.0))];
    let batch = app.post_bytes(&format!("{asked}:batch"), &form_type(), form(&parts)).await.expect(200);
    assert_eq!(batch["items"][0]["problem"]["code"], "image_size_mismatch");
    assert_eq!(batch["items"][1]["candidates"][0]["label"], "bar");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pose_that_is_none_is_refused_alone_in_a_manifest_and_in_an_archive() {
    let app = App::start().await;
    create(&app, json!({})).await;
    for pose in ["360", "-5"] {
        let path = format!("{SHELF}/exemplars?label=bar&pose_deg={pose}");
        let problem = app.post_png(&path, picture(Thing::Bar, 0.0)).await;
        let problem = problem.expect_problem(422, "invalid_field");
        assert_eq!(problem["errors"][0]["pointer"], "#pose_deg");
        let text = problem["errors"][0]["detail"].as_str().unwrap();
        assert!(text.starts_with(&format!("{pose} is not in [0, 360)")), "{text}");
    }
    let path = format!("{SHELF}/exemplars:batch");
    let rejected = |batch: &Value| {
        for (at, status) in ["rejected", "created", "rejected"].into_iter().enumerate() {
            assert_eq!(batch["items"][at]["status"], status, "{batch:#}");
        }
        let problem = &batch["items"][0]["problem"];
        assert_eq!((&problem["code"], &problem["status"]), (&json!("invalid_field"), &json!(422)));
        assert!(problem["detail"].as_str().unwrap().contains("[0, 360)"), "{problem:#}");
    };
    let poses = [360.0, 359.5, -5.0];
    let line = |n: usize| json!({"file": n.to_string(), "label": "bar", "pose_deg": poses[n]});
    let manifest = json!([line(0), line(1), line(2)]).to_string();
    let views: Vec<Bytes> = poses.iter().map(|pose| picture(Thing::Bar, *pose)).collect();
    let parts = [
        ("manifest", Bytes::from(manifest)),
        ("0", views[0].clone()),
        ("1", views[1].clone()),
        ("2", views[2].clone()),
    ];
    rejected(&app.post_bytes(&path, &form_type(), form(&parts)).await.expect(200));
    let files =
        [("pair/a__360.png", &views[0]), ("pair/a__359.5.png", &views[1]), ("pair/a__-5.png", &views[2])];
    rejected(&app.post_bytes(&path, "application/x-tar", tar(&files).await).await.expect(200));
    assert_eq!(app.get(SHELF).await.expect(200)["exemplars"], 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_view_each_is_enough_to_tell_two_things_apart_and_not_to_know_others() {
    let app = App::start().await;
    create(&app, json!({})).await;
    add(&app, "label=bar&pose_deg=0", picture(Thing::Bar, 0.0)).await;
    add(&app, "label=ring", picture(Thing::Ring, 0.0)).await;
    app.train("shelf", json!({})).await;
    let report = &app.get(&format!("{SHELF}/versions/1")).await.expect(200)["report"];
    assert_eq!(report["held_out"], Value::Null);
    let answer = app.recognise("shelf", "", picture(Thing::Bar, 2.0)).await;
    assert_eq!(answer["decision"], json!({"label": "bar", "confidence": null}), "{answer:#}");
    assert_eq!(answer["pose"], Value::Null);
    assert!(answer["warnings"].as_array().unwrap().contains(&json!("not_calibrated")), "{answer:#}");
    assert_eq!(answer["candidates"][0]["threshold"], Value::Null);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_artifact_taken_in_elsewhere_answers_as_the_original() {
    let home = shelf().await;
    let file = home.get(&format!("{SHELF}/versions/1/artifact")).await.body;
    let away = App::start().await;
    create(&away, json!({"dimension": 3})).await;
    let versions = format!("{SHELF}/versions");
    let taken = away.post_bytes(&versions, FILE, file.clone()).await.expect(201);
    away.post_bytes(&versions, FILE, file.clone()).await.expect(200);
    let original = home.get(&format!("{SHELF}/versions/1")).await.expect(200);
    for member in ["digest", "options", "counts", "artifact_bytes"] {
        assert_eq!(taken[member], original[member], "{member}");
    }
    let mut report = original["report"].clone();
    report["timings_ms"] = Value::Null;
    assert_eq!(taken["report"], report);
    assert_eq!(away.get(&format!("{versions}/1/artifact")).await.body, file);
    away.put(&format!("{SHELF}/aliases/current"), json!({"version": 1})).await.expect(201);
    for (which, turn_deg) in [(Thing::Bar, 50.0), (Thing::Pair, 301.0), (Thing::Ring, 0.0)] {
        let at_home = home.recognise("shelf", "", picture(which, turn_deg)).await;
        let abroad = away.recognise("shelf", "", picture(which, turn_deg)).await;
        for member in ["digest", "decision", "candidates", "pose", "warnings"] {
            assert_eq!(at_home[member], abroad[member], "{member}");
        }
    }
    let mut damaged = file.to_vec();
    damaged[file.len() / 2] ^= 1;
    away.post_bytes(&versions, FILE, damaged).await.expect_problem(422, "invalid_artifact");
    away.post_bytes(&versions, FILE, file.slice(..file.len() - 9))
        .await
        .expect_problem(422, "invalid_artifact");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_artifact_of_the_other_kind_is_refused() {
    let app = shelf().await;
    app.trained("lab", 2).await;
    for (from, to) in [("shelf", "lab"), ("lab", "shelf")] {
        let file = app.get(&format!("/v1/databases/{from}/versions/1/artifact")).await.body;
        let answer = app.post_bytes(&format!("/v1/databases/{to}/versions"), FILE, file).await;
        answer.expect_problem(409, "kind_conflict");
        let versions = app.get(&format!("/v1/databases/{to}/versions")).await.expect(200);
        assert_eq!(versions["items"].as_array().unwrap().len(), 1);
    }
    app.post_png(&format!("{SHELF}/recognitions"), scene_png(1)).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_things_in_another_order_are_the_same_version() {
    let mut digests = Vec::new();
    for backwards in [false, true] {
        let app = App::start().await;
        create(&app, json!({})).await;
        let mut turns_deg = [0.0, 45.0, 90.0, 200.0];
        if backwards {
            turns_deg.reverse();
        }
        for turn_deg in turns_deg {
            add(&app, &format!("label=bar&pose_deg={turn_deg}"), picture(Thing::Bar, turn_deg)).await;
        }
        app.train("shelf", json!({})).await;
        app.train("shelf", json!({})).await;
        let versions = app.get(&format!("{SHELF}/versions")).await.expect(200);
        assert_eq!(versions["items"].as_array().unwrap().len(), 1, "the same inputs are one version");
        let file = app.get(&format!("{SHELF}/versions/1/artifact")).await;
        digests.push((versions["items"][0]["digest"].clone(), file.header("etag").to_owned()));
    }
    assert_eq!(digests[0], digests[1]);
}
