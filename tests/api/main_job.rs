//! The main job: pictures in, a trained version, and answers with their evidence.

use std::collections::HashMap;

use axum::body::Body;
use axum::http::{Method, header};
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
use serde_json::{Value, json};

use crate::app::{App, form, form_type, request, tar, with_bytes};
use crate::pictures::{SIDE_PX, jpeg, png, scene, scene_png};

const PLACES: [&str; 4] = ["kitchen", "hall", "lab", "stairs"];

/// A database of four places, uploaded as one tar archive and trained.
async fn four_places(app: &App) {
    app.create("home").await;
    fill(app).await;
}

/// Upload the four places and train.
async fn fill(app: &App) {
    let files = (1..).zip(PLACES).map(|(number, label)| (format!("{label}/view.png"), scene_png(number)));
    let archive = tar(&files.collect::<Vec<_>>()).await;
    let path = "/v1/databases/home/exemplars:batch";
    let batch = app.post_bytes(path, "application/x-tar", archive).await.expect(200);
    assert_eq!((&batch["created"], &batch["rejected"]), (&json!(4), &json!(0)), "{batch:#}");
    let job = app.train("home", json!({})).await;
    assert_eq!(job["version"], 1);
    assert_eq!(job["progress"]["done"], job["progress"]["total"], "{job:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn places_uploaded_as_a_tar_and_trained_are_recognised_straight_and_turned() {
    let app = App::start().await;
    let options =
        json!({"interest_points": 48, "query_points": 200, "subwindow_radius_px": 9, "dimension": 16});
    app.put("/v1/databases/home", json!({"kind": "landmarks", "options": options})).await.expect(201);
    fill(&app).await;
    for (number, label) in (1..).zip(PLACES) {
        for turn_deg in [0.0, 90.0, 180.0, 270.0] {
            let answer = app.recognise("home", "", png(&scene(number).turned(turn_deg))).await;
            assert_eq!(answer["decision"]["label"], label, "{answer:#}");
            let confidence = answer["decision"]["confidence"].as_f64().unwrap();
            assert!((0.5..=1.0).contains(&confidence), "{answer:#}");
            assert_eq!(answer["votes"][0]["label"], label);
            assert_eq!((&answer["kind"], &answer["version"]), (&json!("landmarks"), &json!(1)));
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn explained_points_sum_to_the_weight_of_each_label() {
    let app = App::start().await;
    four_places(&app).await;
    // Two scenes mixed, so that several labels get votes.
    let (one, other) = (scene(1).to_rgb8(), scene(2).to_rgb8());
    let half = one.len() / 2;
    let mixed = [&one[..half], &other[half..]].concat();
    let picture = landmarkd_core::imaging::encode::png_rgb8(SIDE_PX, SIDE_PX, &mixed);
    let answer = app.recognise("home", "?explain=true&top=1000", picture.into()).await;
    let points = answer["points"].as_array().unwrap();
    assert_eq!(points.len() as u64, answer["points_used"].as_u64().unwrap());
    let mut sums: HashMap<&str, f64> = HashMap::new();
    for point in points {
        *sums.entry(point["label"].as_str().unwrap()).or_default() += point["weight"].as_f64().unwrap();
        let (x_px, y_px) = (point["x_px"].as_f64().unwrap(), point["y_px"].as_f64().unwrap());
        assert!((0.0..SIDE_PX as f64).contains(&x_px) && (0.0..SIDE_PX as f64).contains(&y_px), "{point}");
    }
    let votes = answer["votes"].as_array().unwrap();
    assert!(votes.len() >= 2, "{answer:#}");
    let mut all = 0.0;
    for vote in votes {
        let (weight, sum) = (vote["weight"].as_f64().unwrap(), sums[vote["label"].as_str().unwrap()]);
        // Numbers may lose their last digit on the way through JSON.
        assert!(
            (weight - sum).abs() <= 1e-12 * sum,
            "{} has {weight}, its points sum to {sum}",
            vote["label"]
        );
        all += vote["share"].as_f64().unwrap();
    }
    assert!((all - 1.0).abs() < 1e-9, "the shares sum to {all}");
    assert!(votes.is_sorted_by(|a, b| a["weight"].as_f64() >= b["weight"].as_f64()), "{answer:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn points_are_given_only_when_they_are_asked_for_and_votes_at_most_as_many() {
    let app = App::start().await;
    four_places(&app).await;
    let answer = app.recognise("home", "?top=1", scene_png(3)).await;
    assert!(answer.get("points").is_none(), "{answer:#}");
    assert_eq!(answer["votes"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_client_that_accepts_a_picture_gets_the_frame_drawn_on() {
    let app = App::start().await;
    four_places(&app).await;
    let asked = request(Method::POST, "/v1/databases/home/recognitions").header(header::ACCEPT, "image/png");
    let answer = app.send(with_bytes(asked, "image/png", scene_png(2))).await;
    assert_eq!((answer.status, answer.header("content-type")), (200, "image/png"));
    let drawn = decode(&answer.body, &DecodeLimits::default()).unwrap();
    assert!(drawn.width() >= SIDE_PX && drawn.height() >= SIDE_PX);
    assert!(drawn.is_colour());
    assert_ne!(drawn.to_rgb8(), scene(2).to_rgb8(), "nothing is drawn on it");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_frame_and_version_give_the_same_answer() {
    let app = App::start().await;
    four_places(&app).await;
    let mut first = app.recognise("home", "?explain=true", scene_png(4)).await;
    let mut second = app.recognise("home", "?explain=true", scene_png(4)).await;
    for answer in [&mut first, &mut second] {
        answer.as_object_mut().unwrap().remove("timings_ms");
    }
    assert_eq!(first, second);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_form_is_as_good_as_the_raw_picture() {
    let app = App::start().await;
    four_places(&app).await;
    let raw =
        app.post_png("/v1/databases/home/exemplars?label=attic&pose_deg=45", scene_png(9)).await.expect(201);
    let body = form(&[("comment", Vec::from("of no interest")), ("image", scene_png(9).into())]);
    let path = "/v1/databases/home/exemplars?label=attic&pose_deg=45";
    let as_form = app.post_bytes(path, &form_type(), body).await.expect(200);
    assert_eq!(raw, as_form, "one exemplar, sent twice");

    let frame = jpeg(&scene(1));
    let answer =
        app.post_bytes("/v1/databases/home/recognitions", "image/jpeg", frame.clone()).await.expect(200);
    let body = form(&[("image", frame)]);
    let as_form = app.post_bytes("/v1/databases/home/recognitions", &form_type(), body).await.expect(200);
    assert_eq!(answer["votes"][0]["label"], "kitchen");
    assert_eq!(answer["votes"], as_form["votes"]);
}

fn statuses(batch: &Value) -> Vec<(&str, &str)> {
    let items = batch["items"].as_array().unwrap();
    items.iter().map(|item| (item["file"].as_str().unwrap(), item["status"].as_str().unwrap())).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn one_bad_picture_in_an_archive_never_loses_the_rest() {
    let app = App::start().await;
    app.create("home").await;
    let files = [
        ("train/cup/front__12.5.png", scene_png(1)),
        ("cup/broken.png", scene_png(2).slice(..200)),
        ("cup/notes.txt", "no picture".into()),
        ("lonely.png", scene_png(3)),
        ("a label/x.png", scene_png(3)),
        ("can/front.jpg", jpeg(&scene(4))),
        ("can/front-again.jpg", jpeg(&scene(4))),
    ];
    let path = "/v1/databases/home/exemplars:batch";
    let batch = app.post_bytes(path, "application/x-tar", tar(&files).await).await.expect(200);
    let expected = ["created", "rejected", "rejected", "rejected", "rejected", "created", "duplicate"];
    let expected: Vec<_> = files.iter().map(|(file, _)| *file).zip(expected).collect();
    assert_eq!(statuses(&batch), expected, "{batch:#}");
    assert_eq!(
        (&batch["created"], &batch["duplicates"], &batch["rejected"]),
        (&json!(2), &json!(1), &json!(4))
    );
    let codes = [1, 2, 3, 4].map(|at| batch["items"][at]["problem"]["code"].as_str().unwrap());
    assert_eq!(codes, ["corrupt_image", "unsupported_image_format", "invalid_field", "invalid_field"]);
    assert_eq!(batch["items"][5]["id"], batch["items"][6]["id"]);
    let id = batch["items"][0]["id"].as_str().unwrap();
    let kept = app.get(&format!("/v1/databases/home/exemplars/{id}")).await.expect(200);
    assert_eq!((&kept["label"], &kept["pose_deg"]), (&json!("cup"), &json!(12.5)));
}

#[tokio::test(flavor = "multi_thread")]
async fn long_names_in_an_archive_are_read_whole() {
    let app = App::start().await;
    app.create("home").await;
    // Longer than the 100 bytes of a tar header, so that it comes as an entry of its own.
    let file = format!("{}/cup/{}__33.png", "shelf".repeat(12), "view".repeat(30));
    let archive = tar(&[(&file, scene_png(1)), (&"can/short.png".to_owned(), scene_png(2))]).await;
    let path = "/v1/databases/home/exemplars:batch";
    let batch = app.post_bytes(path, "application/x-tar", archive).await.expect(200);
    assert_eq!(statuses(&batch), [(file.as_str(), "created"), ("can/short.png", "created")], "{batch:#}");
    let cups = app.get("/v1/databases/home/exemplars?label=cup").await.expect(200);
    assert_eq!(cups["items"][0]["pose_deg"], 33.0, "{cups:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn one_bad_picture_in_a_form_with_a_manifest_never_loses_the_rest() {
    let app = App::start().await;
    app.create("home").await;
    let manifest = json!([
        {"file": "a", "label": "cup", "pose_deg": 270},
        {"file": "a", "label": "cup", "pose_deg": -90},
        {"file": "b", "label": "cup"},
        {"file": "c", "label": "no/label"},
        {"file": "never sent", "label": "can"},
        {"file": "a", "label": "mug"},
    ]);
    let parts = [
        ("manifest", manifest.to_string().into()),
        ("a", scene_png(1)),
        ("b", "no picture".into()),
        ("c", scene_png(2)),
        ("d", scene_png(3)),
    ];
    let path = "/v1/databases/home/exemplars:batch";
    for manifest_last in [false, true] {
        let mut parts = parts.to_vec();
        if manifest_last {
            parts.rotate_left(1);
        }
        let batch = app.post_bytes(path, &form_type(), form(&parts)).await.expect(200);
        let kept = if manifest_last { "duplicate" } else { "created" };
        let expected = [
            ("a", kept),
            ("a", "rejected"),
            ("a", kept),
            ("b", "rejected"),
            ("c", "rejected"),
            ("d", "rejected"),
            ("never sent", "rejected"),
        ];
        assert_eq!(statuses(&batch), expected, "{batch:#}");
    }
    let cups = app.get("/v1/databases/home/exemplars?label=cup").await.expect(200);
    assert_eq!(cups["items"][0]["pose_deg"], 270.0, "{cups:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_batch_of_frames_is_answered_in_order_with_the_bad_one_in_its_place() {
    let app = App::start().await;
    four_places(&app).await;
    let numbers = [3, 1, 4, 2, 3, 2];
    let mut parts: Vec<_> = numbers.iter().map(|&number| ("image", scene_png(number))).collect();
    parts.insert(2, ("image", scene_png(1).slice(..300)));
    parts.insert(5, ("picture", scene_png(1)));
    let path = "/v1/databases/home/recognitions:batch";
    let batch = app.post_bytes(path, &form_type(), form(&parts)).await.expect(200);
    let items = batch["items"].as_array().unwrap();
    let said: Vec<&str> = items
        .iter()
        .map(|item| item["votes"][0]["label"].as_str().or(item["problem"]["code"].as_str()).unwrap())
        .collect();
    let place = |number: usize| PLACES[number - 1];
    let expected =
        [place(3), place(1), "corrupt_image", place(4), place(2), "invalid_field", place(3), place(2)];
    assert_eq!(said, expected, "{batch:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_gray_frame_for_a_database_in_colour_is_answered_with_a_doubt() {
    let app = App::start().await;
    app.create("home").await;
    app.add("home", "kitchen", 1).await;
    app.add("home", "hall", 2).await;
    let gray = Frame::gray(scene(1).luminance);
    for (colour, warnings) in [("gray", json!([])), ("opponent", json!(["gray_frame"]))] {
        app.train("home", json!({"options": {"colour": colour}})).await;
        assert_eq!(app.recognise("home", "", png(&gray)).await["warnings"], warnings, "{colour}");
        assert_eq!(app.recognise("home", "", scene_png(1)).await["warnings"], json!([]), "{colour}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robots_header_is_echoed_as_it_was_sent() {
    let app = App::start().await;
    four_places(&app).await;
    let sent = request(Method::POST, "/v1/databases/home/recognitions")
        .header("x-robot-id", "rübe-7")
        .header("x-frame-id", "camera/left 12")
        .header("x-stamp", "1700000000.000000001")
        .header(header::CONTENT_TYPE, "image/png")
        .body(Body::from(scene_png(1)))
        .unwrap();
    let answer = app.send(sent).await.expect(200);
    let header = json!({"robot_id": "rübe-7", "frame_id": "camera/left 12", "stamp": "1700000000.000000001"});
    assert_eq!(answer["header"], header);
}
