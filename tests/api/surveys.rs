//! Surveys: where exemplars were taken, with which camera, how large they are.

use serde_json::{Value, json};

use crate::app::{App, form, form_type, pointers, tar};
use crate::pictures::scene_png;

const EXEMPLARS: &str = "/v1/databases/lab/exemplars";

fn camera() -> Value {
    // of pictures of another size than those of the tests, and of the same shape
    json!({"fx": 112.0, "fy": 112.0, "cx": 55.5, "cy": 55.5, "k1": -0.05, "k2": 0.0, "p1": 0.0, "p2": 0.0, "k3": 0.0,
           "width_px": 112, "height_px": 112})
}

fn pose(x_m: f64) -> Value {
    json!({"map": "hall", "x_m": x_m, "y_m": -2.0, "z_m": 0.0, "yaw_deg": 90.0, "pitch_deg": 0.0, "roll_deg": 0.0,
           "sigma_m": 0.05})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_camera_is_kept_listed_replaced_and_deleted() {
    let app = App::start().await;
    let kept = app.put("/v1/cameras/front", camera()).await.expect(201);
    assert_eq!((&kept["name"], &kept["fx"], &kept["k1"]), (&json!("front"), &json!(112.0), &json!(-0.05)));
    app.put(
        "/v1/cameras/front",
        json!({"fx": 90, "fy": 90, "cx": 56, "cy": 56, "width_px": 112, "height_px": 112}),
    )
    .await
    .expect(200);
    assert_eq!(app.get("/v1/cameras/front").await.expect(200)["k1"], 0.0);
    assert_eq!(app.get("/v1/cameras").await.expect(200)["items"][0]["name"], "front");
    app.delete("/v1/cameras/front").await.expect(204);
    app.get("/v1/cameras/front").await.expect_problem(404, "unknown_camera");
    app.delete("/v1/cameras/front").await.expect_problem(404, "unknown_camera");
    let wrong = json!({"fx": 0, "fy": 90, "cx": 56, "cy": 1e9, "width_px": 112, "height_px": 112});
    let problem = app.put("/v1/cameras/front", wrong).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/cy", "/fx"]);
    let folded = json!({"fx": 56, "fy": 56, "cx": 56, "cy": 56, "k1": -3, "width_px": 112, "height_px": 112});
    let problem = app.put("/v1/cameras/front", folded).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/k1"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_comes_with_its_pose_in_the_query_or_in_a_form() {
    let app = App::start().await;
    app.create("lab").await;
    app.put("/v1/cameras/front", camera()).await.expect(201);
    let query = format!("{EXEMPLARS}?label=hall&map=hall&x_m=1.5&y_m=-2&yaw_deg=90&camera=front");
    let by_query = app.post_png(&query, scene_png(1)).await.expect(201);
    assert_eq!((&by_query["pose"], &by_query["camera"]), (&pose(1.5), &camera()));
    let parts = [
        ("pose", pose(1.5).to_string().into_bytes()),
        ("image", scene_png(2).to_vec()),
        ("camera", camera().to_string().into_bytes()),
        ("size_mm", b"210".to_vec()),
    ];
    let sent = app.post_bytes(&format!("{EXEMPLARS}?label=hall"), &form_type(), form(&parts)).await;
    let by_form = sent.expect(201);
    assert_eq!((&by_form["pose"], &by_form["size_mm"]), (&pose(1.5), &json!(210.0)));
    let named = [("camera", b"front".to_vec()), ("image", scene_png(3).to_vec())];
    let sent = app.post_bytes(&format!("{EXEMPLARS}?label=hall"), &form_type(), form(&named)).await;
    assert_eq!(sent.expect(201)["camera"], camera());
    let listed = app.get(EXEMPLARS).await.expect(200);
    let poses = listed["items"].as_array().unwrap().iter().filter(|item| item["pose"] == pose(1.5));
    assert_eq!(poses.count(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_picture_with_another_pose_moves_and_without_one_stays() {
    let app = App::start().await;
    app.create("lab").await;
    let at = |x_m: f64| format!("{EXEMPLARS}?label=hall&map=hall&x_m={x_m}&y_m=-2&yaw_deg=90");
    let first = app.post_png(&at(1.0), scene_png(1)).await.expect(201);
    let moved = app.post_png(&at(2.0), scene_png(1)).await.expect(200);
    assert_eq!((&moved["id"], &moved["pose"]), (&first["id"], &pose(2.0)));
    let same = app.post_png(&format!("{EXEMPLARS}?label=hall"), scene_png(1)).await.expect(200);
    assert_eq!(same["pose"], pose(2.0));
    let sized = app.post_png(&format!("{EXEMPLARS}?label=hall&size_mm=100"), scene_png(1)).await.expect(200);
    assert_eq!((&sized["pose"], &sized["size_mm"]), (&pose(2.0), &json!(100.0)));

    let path = format!("{EXEMPLARS}/{}", first["id"].as_str().unwrap());
    let patch = async |body: Value| app.patch(&path, body).await;
    let changed = patch(json!({"size_mm": 297, "camera": camera()})).await.expect(200);
    assert_eq!((&changed["size_mm"], &changed["pose"]), (&json!(297.0), &pose(2.0)));
    let changed = patch(json!({"pose": null})).await.expect(200);
    assert_eq!((&changed["pose"], &changed["size_mm"]), (&Value::Null, &json!(297.0)));
    let problem = patch(json!({"pose": {"map": "hall"}, "label": "x"})).await;
    assert_eq!(pointers(&problem.expect_problem(422, "invalid_field")), ["/label", "/pose"]);
    assert_eq!(app.get(&path).await.expect(200), changed);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_is_refused_with_the_member_at_fault() {
    let app = App::start().await;
    app.create("lab").await;
    app.put("/v1/databases/things", json!({"kind": "objects"})).await.expect(201);
    let refused = async |path: &str, at: &[&str]| {
        let problem = app.post_png(path, scene_png(1)).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), at, "{path}");
    };
    refused(&format!("{EXEMPLARS}?label=a&map=hall&x_m=1"), &["#"]).await;
    refused(&format!("{EXEMPLARS}?label=a&map=hall&x_m=1&y_m=2e9&yaw_deg=0"), &["#y_m"]).await;
    refused(&format!("{EXEMPLARS}?label=a&size_mm=0"), &["#size_mm"]).await;
    refused("/v1/databases/things/exemplars?label=a&size_mm=10", &["#size_mm"]).await;
    let path = format!("{EXEMPLARS}?label=a&camera=front");
    app.post_png(&path, scene_png(1)).await.expect_problem(404, "unknown_camera");
    let wide = json!({"fx": 90, "fy": 90, "cx": 56, "cy": 30, "width_px": 112, "height_px": 60});
    app.put("/v1/cameras/wide", wide).await.expect(201);
    refused(&format!("{EXEMPLARS}?label=a&camera=wide"), &["#camera"]).await;
    assert_eq!(app.get(EXEMPLARS).await.expect(200)["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn an_archive_has_a_table_of_poses_before_or_behind_its_pictures() {
    let app = App::start().await;
    app.create("lab").await;
    app.put("/v1/cameras/front", camera()).await.expect(201);
    let table = "file,map,x_m,y_m,yaw_deg,camera\nhall/1.png,hall,1.5,-2,90,front\nhall/2.png,hall,2.5,-2,90,\n\
                 hall/9.png,hall,0,0,0,\n";
    let (first, second) = (scene_png(1), scene_png(2));
    for files in [
        [("set/poses.csv", table.as_bytes()), ("set/hall/1.png", &first), ("set/hall/2.png", &second)],
        [("set/hall/1.png", &first), ("set/hall/2.png", &second), ("set/poses.csv", table.as_bytes())],
    ] {
        let answer =
            app.post_bytes(&format!("{EXEMPLARS}:batch"), "application/x-tar", tar(&files).await).await;
        let answer = answer.expect(200);
        assert_eq!(answer["rejected"], 1, "{answer:#}");
        assert_eq!(answer["items"][2]["file"], "set/hall/9.png");
        let listed = app.get(EXEMPLARS).await.expect(200);
        let mut x: Vec<_> =
            listed["items"].as_array().unwrap().iter().map(|item| item["pose"]["x_m"].as_f64()).collect();
        x.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(x, [Some(1.5), Some(2.5)]);
        for item in listed["items"].as_array().unwrap() {
            app.delete(&format!("{EXEMPLARS}/{}", item["id"].as_str().unwrap())).await.expect(204);
        }
    }
    let broken = [("poses.csv", "file,lat\na/1.png,3\n".as_bytes()), ("hall/1.png", &first)];
    let answer = app.post_bytes(&format!("{EXEMPLARS}:batch"), "application/x-tar", tar(&broken).await).await;
    let answer = answer.expect(200);
    assert_eq!((&answer["created"], &answer["items"][0]["file"]), (&json!(1), &json!("poses.csv")));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_manifest_has_poses_and_poses_are_part_of_a_version() {
    let app = App::start().await;
    app.create("lab").await;
    let manifest = json!([
        {"file": "a", "label": "hall", "pose": pose(1.0), "camera": camera()},
        {"file": "b", "label": "hall", "pose": pose(2.0)},
        {"file": "c", "label": "hall", "pose": {"map": "hall", "x_m": 1, "y_m": 1, "yaw_deg": 1e3}},
    ]);
    let parts = [
        ("manifest", manifest.to_string().into_bytes()),
        ("a", scene_png(1).to_vec()),
        ("b", scene_png(2).to_vec()),
        ("c", scene_png(3).to_vec()),
    ];
    let answer = app.post_bytes(&format!("{EXEMPLARS}:batch"), &form_type(), form(&parts)).await.expect(200);
    assert_eq!((&answer["created"], &answer["rejected"]), (&json!(2), &json!(1)), "{answer:#}");
    assert_eq!(answer["items"][2]["problem"]["errors"][0]["pointer"], "/pose/yaw_deg");

    let train = async || app.train("lab", json!({})).await["version"].as_i64().unwrap();
    assert_eq!((train().await, train().await), (1, 1));
    let id = answer["items"][1]["id"].as_str().unwrap().to_owned();
    app.patch(&format!("{EXEMPLARS}/{id}"), json!({"pose": pose(3.0)})).await.expect(200);
    assert_eq!((train().await, train().await), (2, 2));

    let artifact = app.get("/v1/databases/lab/versions/2/artifact").await;
    assert_eq!(artifact.status, 200);
    app.put("/v1/databases/copy", json!({"kind": "landmarks"})).await.expect(201);
    app.post_bytes("/v1/databases/copy/versions", "application/octet-stream", artifact.body)
        .await
        .expect(201);
}
