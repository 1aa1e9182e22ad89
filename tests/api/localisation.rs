//! Where a frame was taken, in metres: exemplars of a rendered room whose poses are known, frames between them.

use std::sync::LazyLock;

use bytes::Bytes;
use landmarkd_core::geometry::{Camera, MapPose};
use landmarkd_core::localisation::scene::{Exposure, Room, Scene, poster};
use serde_json::{Value, json};

use crate::app::{App, form, form_type, pointers};
use crate::pictures::{jpeg, png};

static ROOM: LazyLock<Scene> =
    LazyLock::new(|| Scene::rooms(&[Room { least_m: [0.0, 0.0], greatest_m: [5.0, 4.0], seed: 3 }]));

const CAMERA: Camera = Camera {
    fx: 230.0,
    fy: 231.0,
    cx: 158.0,
    cy: 121.0,
    distortion: [-0.1, 0.02, 2e-4, -3e-4, 0.0],
    width_px: 320,
    height_px: 240,
};

fn camera() -> Value {
    let [k1, k2, p1, p2, k3] = CAMERA.distortion;
    json!({"fx": CAMERA.fx, "fy": CAMERA.fy, "cx": CAMERA.cx, "cy": CAMERA.cy, "k1": k1, "k2": k2, "p1": p1, "p2": p2,
           "k3": k3, "width_px": 320, "height_px": 240})
}

fn at(x_m: f64, y_m: f64, yaw_deg: f64) -> MapPose {
    MapPose { x_m, y_m, z_m: 0.6, yaw_deg, ..MapPose::default() }
}

fn photograph(pose: &MapPose, seed: u64) -> Bytes {
    jpeg(&ROOM.photograph(&CAMERA, pose, &Exposure { noise: 2.0, seed, ..Exposure::default() }))
}

/// A database of pictures a metre apart along the room, all of them looking at the far wall.
async fn taught(app: &App) {
    app.put("/v1/cameras/front", camera()).await.expect(201);
    let options = json!({"viewpoint": "upright", "working_size_px": 320});
    app.put("/v1/databases/lab", json!({"kind": "landmarks", "options": options})).await.expect(201);
    for (number, (x_m, y_m)) in
        (0..).zip([(1.0, 1.0), (2.0, 1.0), (1.0, 2.0), (2.0, 2.0), (1.0, 3.0), (2.0, 3.0)])
    {
        let query = format!("label=p{number}&map=flat&x_m={x_m}&y_m={y_m}&z_m=0.6&yaw_deg=0&camera=front");
        let path = format!("/v1/databases/lab/exemplars?{query}");
        app.post_bytes(&path, "image/jpeg", photograph(&at(x_m, y_m, 0.0), number)).await.expect(201);
    }
    app.train("lab", json!({"calibration": "none"})).await;
}

/// How far off a pose is, in metres and degrees.
fn off(pose: &Value, truth: &MapPose) -> (f64, f64) {
    let number = |name: &str| pose[name].as_f64().unwrap_or_else(|| panic!("no {name} in {pose:#}"));
    let turn = (number("yaw_deg") - truth.yaw_deg + 180.0).rem_euclid(360.0) - 180.0;
    ((number("x_m") - truth.x_m).hypot(number("y_m") - truth.y_m), turn.abs())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_frame_between_exemplars_is_located_with_its_camera_and_roughly_without() {
    let app = App::start().await;
    taught(&app).await;
    let truth = at(1.5, 1.6, 4.0);
    let frame = photograph(&truth, 40);
    let ask = async |query: &str| {
        let path = format!("/v1/databases/lab/recognitions{query}");
        app.post_bytes(&path, "image/jpeg", frame.clone()).await.expect(200)
    };
    let answer = ask("?camera=front").await;
    let pose = &answer["pose"];
    let (metres, degrees) = off(pose, &truth);
    assert!(metres < 0.3 && degrees < 3.0, "{metres} m, {degrees}° off: {pose:#}");
    assert_eq!((&pose["map"], &pose["method"]), (&json!("flat"), &json!("triangulation")));
    assert!(pose["support"].as_array().unwrap().len() > 1, "{pose:#}");
    let covariance: Vec<f64> =
        pose["covariance"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
    assert!(covariance.len() == 9 && covariance[0] > 0.0 && covariance[1] == covariance[3], "{covariance:?}");
    assert!(answer["timings_ms"]["locate"].as_f64().unwrap() > 0.0);

    let without = ask("").await;
    assert_eq!(without["pose"]["method"], "exemplars");
    let (metres, degrees) = off(&without["pose"], &truth);
    assert!(metres < 2.0 && degrees < 30.0, "{metres} m, {degrees}° off");

    let parts = [("image", frame.to_vec()), ("camera", camera().to_string().into_bytes())];
    let sent = app.post_bytes("/v1/databases/lab/recognitions", &form_type(), form(&parts)).await.expect(200);
    assert_eq!(sent["pose"], answer["pose"]);
    let strange = json!({"fx": 200, "fy": 200, "cx": 160, "cy": 60, "width_px": 320, "height_px": 120});
    let parts = [("image", frame.to_vec()), ("camera", strange.to_string().into_bytes())];
    let refused = app.post_bytes("/v1/databases/lab/recognitions", &form_type(), form(&parts)).await;
    assert_eq!(pointers(&refused.expect_problem(422, "invalid_field")), ["#camera"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_track_follows_a_robot_by_frames_and_odometry() {
    let app = App::start().await;
    taught(&app).await;
    let track = app.post("/v1/databases/lab/tracks", json!({})).await.expect(201);
    let track = format!("/v1/databases/lab/tracks/{}", track["id"].as_str().unwrap());
    let step_m = 0.2;
    for step in 0..4 {
        let truth = at(1.1 + step_m * f64::from(step), 1.5, 0.0);
        let moved = if step == 0 { String::new() } else { format!("&dx_m={step_m}&dyaw_deg=0") };
        let path = format!("{track}/frames?camera=front{moved}");
        let answer =
            app.post_bytes(&path, "image/jpeg", photograph(&truth, 60 + step as u64)).await.expect(200);
        let pose = &answer["pose"];
        let (metres, degrees) = off(pose, &truth);
        assert!(metres < 0.4 && degrees < 6.0, "step {step}: {metres} m, {degrees}° off: {pose:#}");
        assert_eq!((&pose["method"], &pose["map"]), (&json!("track"), &json!("flat")));
        assert!(pose["lost"].is_boolean() && answer["frame"]["pose"]["method"] != "track");
    }
    let kept = app.get(&track).await.expect(200);
    assert_eq!(kept["pose"]["method"], "track");
    // What shows nothing moves on by odometry alone.
    let dark = crate::pictures::flat_png(9);
    let before = kept["pose"]["x_m"].as_f64().unwrap();
    let answer = app.post_png(&format!("{track}/frames?dx_m=0.5&dyaw_deg=0"), dark).await.expect(200);
    let moved = answer["pose"]["x_m"].as_f64().unwrap() - before;
    assert!((moved - 0.5).abs() < 0.1, "{moved}");
    for (wrong, pointer) in [("dx_m=1", "#dx_m"), ("dx_m=1e9&dyaw_deg=0", "#dx_m")] {
        let refused = app.post_png(&format!("{track}/frames?{wrong}"), crate::pictures::flat_png(9)).await;
        assert_eq!(pointers(&refused.expect_problem(422, "invalid_field")), [pointer]);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn without_poses_there_is_no_pose() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    let answer = app.recognise("lab", "", crate::pictures::scene_png(1)).await;
    assert_eq!(answer.get("pose"), None);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_poster_of_known_size_is_measured_and_says_where_the_camera_is() {
    let app = App::start().await;
    let poster = poster(5, 300, 240);
    let hangs = MapPose { x_m: 3.0, y_m: 2.0, z_m: 1.0, yaw_deg: 180.0, ..MapPose::default() };
    let mut room = ROOM.clone();
    room.hang(&poster, 0.6, &hangs);
    app.put("/v1/cameras/front", camera()).await.expect(201);
    let options = json!({"working_size_px": 320});
    app.put("/v1/databases/lab", json!({"kind": "landmarks", "options": options})).await.expect(201);
    let parts = [
        ("image", png(&poster).to_vec()),
        (
            "pose",
            json!({"map": "flat", "x_m": 3, "y_m": 2, "z_m": 1, "yaw_deg": 180}).to_string().into_bytes(),
        ),
        ("size_mm", b"600".to_vec()),
    ];
    let path = "/v1/databases/lab/exemplars?label=poster";
    app.post_bytes(path, &form_type(), form(&parts)).await.expect(201);
    app.train("lab", json!({"calibration": "none"})).await;

    let truth = at(1.6, 1.7, 8.0);
    let frame = jpeg(&room.photograph(&CAMERA, &truth, &Exposure { noise: 2.0, ..Exposure::default() }));
    let path = "/v1/databases/lab/recognitions?camera=front";
    let answer = app.post_bytes(path, "image/jpeg", frame.clone()).await.expect(200);
    assert_eq!(answer["decision"]["label"], "poster", "{answer:#}");
    let placement = &answer["instances"][0]["placement"];
    let seen = truth.optical().inverse().then(&hangs.transform());
    let found = &placement["T_camera_landmark"];
    for (axis, truth_m) in seen.translation_m.to_array().into_iter().enumerate() {
        let off = found["translation_m"][axis].as_f64().unwrap() - truth_m;
        assert!(off.abs() < 0.02 * seen.translation_m.length(), "{off} m off along {axis}: {placement:#}");
    }
    assert_eq!(found["covariance"].as_array().unwrap().len(), 36);
    assert!(placement["ambiguous"].is_boolean());
    let pose = &answer["pose"];
    assert_eq!((&pose["method"], &pose["map"]), (&json!("flat_landmark"), &json!("flat")));
    let (metres, degrees) = off(pose, &truth);
    assert!(metres < 0.1 && degrees < 2.0, "{metres} m, {degrees}° off");

    let without = app.post_bytes("/v1/databases/lab/recognitions", "image/jpeg", frame).await.expect(200);
    assert_eq!(without["instances"][0]["placement"].get("T_camera_landmark"), None);
    assert_eq!(without["pose"], Value::Null);
}
