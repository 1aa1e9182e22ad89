//! Exemplars: kept once, given back as they were sent, removed only when it is said which.

use std::collections::HashSet;

use axum::http::{Method, header};
use serde_json::{Value, json};

use crate::app::{App, request, with_bytes};
use crate::pictures::{jpeg, scene, scene_png};

const EXEMPLARS: &str = "/v1/databases/lab/exemplars";

async fn count(app: &App) -> u64 {
    app.get("/v1/databases/lab").await.expect(200)["exemplars"].as_u64().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_picture_label_and_pose_again_is_the_same_exemplar() {
    let app = App::start().await;
    app.create("lab").await;
    let post = async |query: &str| app.post_png(&format!("{EXEMPLARS}?{query}"), scene_png(1)).await;
    let first = post("label=cup&pose_deg=10").await.expect(201);
    let second = post("label=cup&pose_deg=10").await.expect(200);
    assert_eq!(first, second);
    assert_eq!(post("label=cup&pose_deg=10.0").await.expect(200)["id"], first["id"], "the same pose");
    for other in ["label=cup", "label=can&pose_deg=10", "label=cup&pose_deg=11"] {
        assert_ne!(post(other).await.expect(201)["id"], first["id"], "{other}");
    }
    assert_eq!(count(&app).await, 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pose_is_taken_only_within_one_turn() {
    let app = App::start().await;
    app.create("lab").await;
    for (number, (sent, kept)) in (1..).zip([("0", 0.0), ("-0", 0.0), ("355", 355.0), ("359.99", 359.99)]) {
        let path = format!("{EXEMPLARS}?label=cup&pose_deg={sent}");
        let exemplar = app.post_png(&path, scene_png(number)).await.expect(201);
        assert_eq!(exemplar["pose_deg"], kept, "{sent}");
    }
    for wrong in ["NaN", "inf", "-inf", "1e300", "north", "360", "-5", "-1e-20"] {
        let path = format!("{EXEMPLARS}?label=cup&pose_deg={wrong}");
        let problem = app.post_png(&path, scene_png(1)).await.expect_problem(422, "invalid_field");
        let text = problem["detail"].as_str().unwrap();
        assert!(text.contains("[0, 360)") || wrong == "north", "{wrong}: {text}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_comes_back_byte_for_byte_with_its_type_and_sum() {
    let app = App::start().await;
    app.create("lab").await;
    for (bytes, media_type) in [(scene_png(1), "image/png"), (jpeg(&scene(1)), "image/jpeg")] {
        // What the client says it is doesn't count.
        let path = format!("{EXEMPLARS}?label=cup");
        let exemplar = app.post_bytes(&path, "application/octet-stream", bytes.clone()).await.expect(201);
        assert_eq!(exemplar["media_type"], media_type);
        assert_eq!((&exemplar["width_px"], &exemplar["height_px"]), (&json!(56), &json!(56)));
        assert_eq!(exemplar["bytes"], bytes.len());
        assert_eq!(exemplar["sha256"].as_str().unwrap().len(), 64);
        let image = app.get(&format!("{EXEMPLARS}/{}/image", exemplar["id"].as_str().unwrap())).await;
        assert_eq!((image.status, image.header("content-type")), (200, media_type));
        assert_eq!(image.body, bytes);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robots_exemplars_are_found_and_removed_by_its_id() {
    let app = App::start().await;
    app.create("lab").await;
    for (number, robot) in [(1, "r1"), (2, "r2"), (3, "r1")] {
        let sent = request(Method::POST, &format!("{EXEMPLARS}?label=cup"))
            .header("x-robot-id", robot)
            .header("x-stamp", "2026-01-31T12:00:00.5Z");
        let exemplar = app.send(with_bytes(sent, "image/png", scene_png(number))).await.expect(201);
        let echo = json!({"robot_id": robot, "frame_id": null, "stamp": "2026-01-31T12:00:00.5Z"});
        assert_eq!(exemplar["header"], echo);
    }
    let found = app.get(&format!("{EXEMPLARS}?robot_id=r1")).await.expect(200);
    assert_eq!(found["items"].as_array().unwrap().len(), 2);
    app.delete(&format!("{EXEMPLARS}?robot_id=r1&label=can")).await.expect(204);
    assert_eq!(count(&app).await, 3, "both filters must match");
    app.delete(&format!("{EXEMPLARS}?robot_id=r1")).await.expect(204);
    assert_eq!(count(&app).await, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn exemplars_are_removed_by_label_or_id_and_never_all_of_them_by_omission() {
    let app = App::start().await;
    app.create("lab").await;
    let (cup, can) = (app.add("lab", "cup", 1).await, app.add("lab", "can", 2).await);
    app.add("lab", "cup", 3).await;
    app.delete(EXEMPLARS).await.expect_problem(400, "missing_filter");
    app.delete(&format!("{EXEMPLARS}?labels=cup")).await.expect_problem(422, "invalid_field");
    assert_eq!(count(&app).await, 3);

    app.delete(&format!("{EXEMPLARS}?label=cup")).await.expect(204);
    let gone = format!("{EXEMPLARS}/{}", cup["id"].as_str().unwrap());
    app.get(&gone).await.expect_problem(404, "unknown_exemplar");
    let kept = format!("{EXEMPLARS}/{}", can["id"].as_str().unwrap());
    assert_eq!(app.get(&kept).await.expect(200), can);
    app.delete(&kept).await.expect(204);
    app.delete(&kept).await.expect_problem(404, "unknown_exemplar");
    app.get(&format!("{kept}/image")).await.expect_problem(404, "unknown_exemplar");
    assert_eq!(count(&app).await, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn versions_stay_as_they_are_when_their_exemplars_go() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let before = app.recognise("lab", "", scene_png(1)).await;
    app.delete(&format!("{EXEMPLARS}?label=place-1")).await.expect(204);
    let after = app.recognise("lab", "", scene_png(1)).await;
    assert_eq!((&before["digest"], &before["votes"]), (&after["digest"], &after["votes"]));
}

/// All pages of a list.
async fn pages(app: &App, path: &str, limit: usize) -> Vec<Value> {
    let (mut all, mut cursor) = (Vec::new(), String::new());
    loop {
        let page = app.get(&format!("{path}limit={limit}{cursor}")).await.expect(200);
        let items = page["items"].as_array().unwrap();
        assert!(items.len() <= limit);
        all.extend(items.iter().cloned());
        match page["next_cursor"].as_str() {
            Some(next) => cursor = format!("&cursor={next}"),
            None => return all,
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn pages_of_every_size_hold_the_same_exemplars_in_the_same_order() {
    let app = App::start().await;
    app.create("lab").await;
    for number in 1..=7 {
        app.add("lab", if number % 2 == 0 { "even" } else { "odd" }, number).await;
    }
    let whole = pages(&app, &format!("{EXEMPLARS}?"), 1000).await;
    assert_eq!(whole.iter().map(|item| item["id"].as_str().unwrap()).collect::<HashSet<_>>().len(), 7);
    for limit in [1, 2, 7] {
        assert_eq!(pages(&app, &format!("{EXEMPLARS}?"), limit).await, whole, "{limit} a page");
    }
    let odd: Vec<Value> = whole.into_iter().filter(|item| item["label"] == "odd").collect();
    assert_eq!(pages(&app, &format!("{EXEMPLARS}?label=odd&"), 3).await, odd);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_exemplar_added_between_two_pages_moves_none_of_the_others() {
    let app = App::start().await;
    app.create("lab").await;
    for number in 1..=6 {
        app.add("lab", "cup", number).await;
    }
    let before = pages(&app, &format!("{EXEMPLARS}?"), 1000).await;
    let first = app.get(&format!("{EXEMPLARS}?limit=3")).await.expect(200);
    app.add("lab", "cup", 7).await;
    let cursor = first["next_cursor"].as_str().unwrap();
    let rest = app.get(&format!("{EXEMPLARS}?cursor={cursor}")).await.expect(200);
    let seen = [first["items"].as_array().unwrap().as_slice(), rest["items"].as_array().unwrap()].concat();
    assert!(before.iter().all(|item| seen.contains(item)), "one of the six was lost");
    let ids: HashSet<_> = seen.iter().map(|item| item["id"].as_str().unwrap()).collect();
    assert_eq!(ids.len(), seen.len(), "one came twice");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_declared_length_and_a_streamed_body_are_the_same_upload() {
    let app = App::start().await;
    app.create("lab").await;
    let path = format!("{EXEMPLARS}?label=cup");
    let streamed = app.post_png(&path, scene_png(1)).await.expect(201);
    let bytes = scene_png(1);
    let declared = request(Method::POST, &path).header(header::CONTENT_LENGTH, bytes.len());
    assert_eq!(app.send(with_bytes(declared, "image/png", bytes)).await.expect(200), streamed);
}
