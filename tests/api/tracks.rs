//! Tracks: frames of a robot's way add up to a belief; a repeat counts once, a swap loses nothing, and all has bounds.

use std::time::{Duration, Instant};

use axum::body::Body;
use axum::http::{Method, Request};
use bytes::Bytes;
use futures_util::future::join_all;
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers, request, with_bytes};
use crate::pictures::{flat_png, scene_png};

const TRACKS: &str = "/v1/databases/lab/tracks";

/// Begin a track; its address.
async fn begin(app: &App, body: Value) -> String {
    let answer = app.post(TRACKS, body).await;
    let track = answer.expect(201);
    let address = format!("{TRACKS}/{}", track["id"].as_str().unwrap());
    assert_eq!(answer.header("location"), address);
    address
}

fn frame(track: &str, picture: Bytes, id: Option<&str>) -> Request<Body> {
    let builder = request(Method::POST, &format!("{track}/frames")).header("x-robot-id", "rover");
    let builder = id.into_iter().fold(builder, |builder, id| builder.header("x-frame-id", id));
    with_bytes(builder, "image/png", picture)
}

/// The answer to a scene.
async fn see(app: &App, track: &str, scene: u64) -> Value {
    app.send(frame(track, scene_png(scene), None)).await.expect(200)
}

fn probability(answer: &Value) -> f64 {
    answer["belief"][0]["probability"].as_f64().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn belief_grows_from_frame_to_frame() {
    let app = App::start().await;
    app.trained("lab", 6).await;
    let track = begin(&app, json!({})).await;
    let before = app.get(&track).await.expect(200);
    assert_eq!((&before["frames"], &before["decision"]), (&json!(0), &Value::Null));
    assert_eq!(before["elsewhere"], 0.5);

    let mut last = 0.0;
    for number in 1..=3 {
        let answer = see(&app, &track, 3).await;
        assert_eq!(answer["belief"][0]["label"], "place-3");
        assert!(probability(&answer) > last, "{} after {last}", probability(&answer));
        last = probability(&answer);
        assert_eq!(answer["decision"], json!({"label": "place-3", "confidence": last}));
        // What a recognition of the frame alone tells stands under the same names.
        let alone = app.recognise("lab", "", scene_png(3)).await;
        let own = json!({"number": number, "counted": true, "decision": alone["decision"]});
        assert_eq!(answer["frame"], own);
        for member in ["database", "kind", "version", "digest", "votes", "points_used", "points_found"] {
            assert_eq!(answer[member], alone[member], "{member}");
        }
        assert_eq!(answer["header"]["robot_id"], "rover");
        assert!(answer["timings_ms"]["vote"].as_f64().is_some());
        let all: f64 =
            answer["belief"].as_array().unwrap().iter().map(|l| l["probability"].as_f64().unwrap()).sum();
        assert!(all + answer["elsewhere"].as_f64().unwrap() < 1.0, "five labels of six are told");
    }
    assert!(last > 0.8, "{last}");

    let now = app.get(&format!("{track}?top=1")).await.expect(200);
    assert_eq!((&now["frames"], &now["motion"]), (&json!(3), &json!("still")));
    assert_eq!(now["decision"], json!({"label": "place-3", "confidence": last}));
    assert_eq!(now["belief"].as_array().unwrap().len(), 1);
    assert!(now["expires_at"].as_str() > now["created_at"].as_str());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_path_tells_where_a_robot_is_that_sees_nothing() {
    let app = App::start().await;
    app.create("lab").await;
    let way = [4, 1, 7, 3, 6, 2, 5];
    for scene in way {
        app.add("lab", &format!("place-{scene}"), scene).await;
    }
    app.train("lab", json!({})).await;
    for way in [way.to_vec(), way.into_iter().rev().collect()] {
        let track = begin(&app, json!({"motion": "path"})).await;
        for scene in &way[..4] {
            assert_eq!(see(&app, &track, *scene).await["belief"][0]["label"], format!("place-{scene}"));
        }
        let blind = app.send(frame(&track, flat_png(90), None)).await.expect(200);
        assert_eq!((&blind["frame"]["decision"], &blind["motion"]), (&Value::Null, &json!("path")));
        assert_eq!(blind["belief"][0]["label"], format!("place-{}", way[4]), "{blind:#}");
        assert_eq!(blind["warnings"], json!(["no_interest_points"]));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_last_frame_sent_again_counts_once() {
    let app = App::start().await;
    app.trained("lab", 4).await;
    let track = begin(&app, json!({})).await;
    let first = app.send(frame(&track, scene_png(2), Some("7"))).await.expect(200);
    let again = app.send(frame(&track, scene_png(2), Some("7"))).await.expect(200);
    assert_eq!(again["frame"]["counted"], false);
    for member in ["belief", "elsewhere", "decision", "votes"] {
        assert_eq!(again[member], first[member], "{member}");
    }
    assert_eq!(again["frame"]["number"], 1);
    // Another picture is another frame, though its camera gives every frame one id; so is one without an id.
    let other = app.send(frame(&track, scene_png(3), Some("7"))).await.expect(200);
    assert_eq!((&other["frame"]["number"], &other["frame"]["counted"]), (&json!(2), &json!(true)));
    for number in 3..5 {
        assert_eq!(see(&app, &track, 3).await["frame"]["number"], number);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_goes_on_with_the_version_that_is_swapped_in() {
    let app = App::start().await;
    app.trained("lab", 4).await;
    let track = begin(&app, json!({"motion": "path"})).await;
    for scene in 1..=3 {
        see(&app, &track, scene).await;
    }
    app.add("lab", "place-9", 9).await;
    app.train("lab", json!({})).await;
    // Nothing to see: what is believed comes from before, and the robot goes on.
    let answer = app.send(frame(&track, flat_png(90), None)).await.expect(200);
    assert_eq!((&answer["version"], &answer["frame"]["number"]), (&json!(2), &json!(4)));
    assert_eq!(answer["belief"][0]["label"], "place-4");
    assert_eq!(answer["belief"].as_array().unwrap().len(), 5);
    assert_eq!(see(&app, &track, 9).await["decision"]["label"], "place-9");

    // Back to version 1, by an alias of its own: the new place is unknown there.
    app.put("/v1/databases/lab/aliases/old", json!({"version": 1})).await.expect(201);
    let other = begin(&app, json!({"alias": "old"})).await;
    let answer = see(&app, &other, 9).await;
    assert_eq!((&answer["version"], answer["belief"].as_array().unwrap().len()), (&json!(1), 4));
    assert_eq!(app.get(&other).await.expect(200)["alias"], "old");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_path_whose_order_is_unknown_says_so_and_has_none() {
    let app = App::start().await;
    app.trained("lab", 3).await;
    app.delete("/v1/databases/lab/exemplars?label=place-2").await.expect(204);
    let track = begin(&app, json!({"motion": "path"})).await;
    let told = app.get(&track).await.expect(200);
    assert_eq!((&told["motion"], &told["warnings"]), (&json!("still"), &json!(["order_unknown"])));
    assert_eq!(see(&app, &track, 2).await["warnings"], json!(["order_unknown"]));
    // Trained again, the version has what the database has.
    app.train("lab", json!({})).await;
    let answer = see(&app, &track, 1).await;
    assert_eq!((&answer["motion"], &answer["warnings"]), (&json!("path"), &json!([])));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_without_frames_is_gone_after_a_while() {
    let app = App::start_with(|settings| settings.limits.track_idle = Duration::from_millis(1500)).await;
    app.trained("lab", 2).await;
    let (kept, left) = (begin(&app, json!({})).await, begin(&app, json!({})).await);
    let began = Instant::now();
    while began.elapsed() < Duration::from_millis(2000) {
        see(&app, &kept, 1).await;
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let problem = app.send(frame(&left, scene_png(1), None)).await.expect_problem(404, "unknown_track");
    assert!(problem["detail"].as_str().unwrap().contains("without a frame for 1.5 s is gone"), "{problem}");
    app.get(&left).await.expect_problem(404, "unknown_track");
    let listed = app.get(TRACKS).await.expect(200);
    assert_eq!(listed["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn tracks_are_bounded_in_number_and_memory() {
    let app = App::start_with(|settings| settings.limits.max_tracks = 2).await;
    app.trained("lab", 2).await;
    let (first, second) = (begin(&app, json!({})).await, begin(&app, json!({})).await);
    let full = app.post(TRACKS, json!({})).await;
    full.expect_problem(429, "too_many_tracks");
    let seconds: u64 = full.header("retry-after").parse().unwrap();
    assert!((500..=600).contains(&seconds), "{seconds}");
    // Those that are there go on.
    see(&app, &first, 1).await;
    app.delete(&second).await.expect(204);
    app.delete(&second).await.expect_problem(404, "unknown_track");
    let third = begin(&app, json!({})).await;

    let page = app.get(&format!("{TRACKS}?limit=1")).await.expect(200);
    assert_eq!(page["items"][0]["id"], first.rsplit('/').next().unwrap());
    let cursor = page["next_cursor"].as_str().unwrap();
    let page = app.get(&format!("{TRACKS}?limit=2&cursor={cursor}")).await.expect(200);
    assert_eq!(page["items"][0]["id"], third.rsplit('/').next().unwrap());
    assert_eq!((page["items"].as_array().unwrap().len(), &page["next_cursor"]), (1, &Value::Null));
    let metrics = String::from_utf8(app.get("/metrics").await.body.to_vec()).unwrap();
    assert!(metrics.contains("landmarkd_tracks 2\n"), "{metrics}");

    let app = App::start_with(|settings| settings.limits.max_tracks_bytes = 3000).await;
    app.trained("lab", 2).await;
    let track = begin(&app, json!({"motion": "path"})).await;
    for _ in 0..8 {
        app.post(TRACKS, json!({})).await;
    }
    app.post(TRACKS, json!({})).await.expect_problem(429, "too_many_tracks");
    see(&app, &track, 1).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn frames_of_a_track_are_taken_one_by_one_and_a_pile_of_them_is_refused() {
    let app = App::start().await;
    app.trained("lab", 3).await;
    let track = begin(&app, json!({})).await;
    let at_once = (0..30).map(|_| app.send_expecting_5xx(frame(&track, scene_png(1), None)));
    let answers: Vec<Answer> = join_all(at_once).await;
    let (taken, refused): (Vec<_>, Vec<_>) = answers.into_iter().partition(|answer| answer.status == 200);
    refused.iter().for_each(|answer| drop(answer.expect_problem(503, "overloaded")));
    assert!(taken.len() >= 9, "{} were taken", taken.len());
    let mut numbers: Vec<u64> =
        taken.iter().map(|answer| answer.json()["frame"]["number"].as_u64().unwrap()).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=taken.len() as u64).collect::<Vec<_>>());
    assert_eq!(app.get(&track).await.expect(200)["frames"], taken.len());
}

#[tokio::test(flavor = "multi_thread")]
async fn what_can_not_be_tracked_is_refused_and_leaves_the_track_as_it_was() {
    let app = App::start().await;
    app.post("/v1/databases/none/tracks", json!({})).await.expect_problem(404, "unknown_database");
    app.get("/v1/databases/none/tracks").await.expect_problem(404, "unknown_database");
    app.create("hall").await;
    app.post("/v1/databases/hall/tracks", json!({})).await.expect_problem(409, "not_trained");
    app.trained("lab", 3).await;
    app.post(TRACKS, json!({"alias": "new"})).await.expect_problem(404, "unknown_alias");
    let wrong = app.post(TRACKS, json!({"motion": "sideways"})).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&wrong), ["/motion"]);
    app.post(TRACKS, json!({"speed": 3})).await.expect_problem(422, "invalid_field");

    let track = begin(&app, json!({})).await;
    see(&app, &track, 1).await;
    let before = app.get(&track).await.expect(200);
    let frames = format!("{track}/frames");
    app.post_png(&frames, Bytes::new()).await.expect_problem(400, "empty_image");
    app.post_png(&frames, scene_png(1).slice(..200)).await.expect_problem(400, "corrupt_image");
    app.post_bytes(&frames, "text/plain", "hello").await.expect_problem(415, "unsupported_media_type");
    app.post_png(&format!("{frames}?top=0"), scene_png(1)).await.expect_problem(422, "invalid_field");
    app.post_png(&format!("{frames}?version=1"), scene_png(1)).await.expect_problem(422, "invalid_field");
    app.get(&format!("{track}?top=0")).await.expect_problem(422, "invalid_field");
    app.get(&format!("{TRACKS}/x")).await.expect_problem(422, "invalid_field");
    app.get(&frames).await.expect_problem(405, "method_not_allowed");
    let after = app.get(&track).await.expect(200);
    assert_eq!((&after["frames"], &after["belief"]), (&before["frames"], &before["belief"]));

    // A track belongs to its database.
    let astray = track.replace("lab", "hall");
    app.get(&astray).await.expect_problem(404, "unknown_track");
    app.send(frame(&astray, scene_png(1), None)).await.expect_problem(404, "unknown_track");
    app.delete(&astray).await.expect_problem(404, "unknown_track");

    let sent = form(&[("image", scene_png(1))]);
    let answer =
        app.post_bytes(&format!("{frames}?explain=true&top=2"), &form_type(), sent).await.expect(200);
    assert_eq!((&answer["frame"]["number"], answer["belief"].as_array().unwrap().len()), (&json!(2), 2));
    assert!(!answer["points"].as_array().unwrap().is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn objects_have_no_tracks() {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "objects"})).await.expect(201);
    for scene in 1..=4 {
        app.add("lab", &format!("thing-{}", scene % 2), scene).await;
    }
    app.train("lab", json!({})).await;
    let problem = app.post(TRACKS, json!({})).await.expect_problem(409, "kind_conflict");
    assert!(problem["detail"].as_str().unwrap().contains("tracks are of databases of kind landmarks"));
}
