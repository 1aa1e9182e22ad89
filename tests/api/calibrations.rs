//! Calibrations: kept under names, registered, swept as jobs that outlive a restart, and never mixed with what was
//! measured of another rig.

use bytes::Bytes;
use landmarkd_core::depth::scene::Relief;
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers};
use crate::depth_pictures::{SIZE_PX, optics, pair, parts, photograph_of};
use crate::pictures::{flat_png, scene_png};

const RIG: &str = "/v1/calibrations/rig";

/// Near and far focus distance of the rig, with a little to spare.
const REACH_MM: [f64; 2] = [515.0, 765.0];

/// Depths in equal steps over what a sweep must reach.
fn depths_mm(planes: usize) -> Vec<f64> {
    let [near, far] = REACH_MM;
    (0..planes).map(|at| near + (far - near) * at as f64 / (planes - 1) as f64).collect()
}

/// A sweep of planes that stand at `shown` and are said to stand at `told`.
fn sweep_parts(shown: &[f64], told: &[f64]) -> Vec<(String, Bytes)> {
    let near_mm = 529.0;
    let far_mm = far_focus_mm();
    let mut lines = Vec::new();
    let mut parts = Vec::new();
    for (at, (shown_mm, told_mm)) in shown.iter().zip(told).enumerate() {
        let share = (shown_mm - near_mm) / (far_mm - near_mm);
        let [near, far] = pair(Relief::Plane { share }, 100 + at as u64);
        parts.extend([(format!("n{at}"), near), (format!("f{at}"), far)]);
        lines.push(json!({"depth_mm": told_mm, "near": format!("n{at}"), "far": format!("f{at}")}));
    }
    parts.push(("manifest".into(), Value::Array(lines).to_string().into()));
    parts
}

/// Of the rig of the tests.
fn far_focus_mm() -> f64 {
    let (focal_mm, near_mm) = (25.0, 529.0);
    let far_plane_mm = focal_mm * near_mm / (near_mm - focal_mm) - 0.37;
    focal_mm * far_plane_mm / (far_plane_mm - focal_mm)
}

async fn send(app: &App, path: &str, parts: &[(String, Bytes)]) -> Answer {
    app.post_bytes(&format!("{RIG}/{path}"), &form_type(), form(parts)).await
}

async fn sweep(app: &App, parts: &[(String, Bytes)]) -> Answer {
    send(app, "sweep", parts).await
}

async fn depth_map(app: &App, relief: Relief, others: &[(&str, Value)]) -> Answer {
    let parts = parts(&pair(relief, 7), others);
    app.post_bytes("/v1/depth-maps", &form_type(), form(&parts)).await
}

#[tokio::test(flavor = "multi_thread")]
async fn a_rig_is_described_once_and_again_and_otherwise() {
    let app = App::start().await;
    let made = app.put(RIG, optics()).await.expect(201);
    assert_eq!((&made["name"], &made["version"]), (&json!("rig"), &json!(1)));
    assert!((made["near_focus_mm"].as_f64().unwrap() - 529.0).abs() < 1e-6);
    assert!((made["far_focus_mm"].as_f64().unwrap() - far_focus_mm()).abs() < 1e-6, "{made:#}");
    for member in ["image", "registration", "photometric", "noise", "filters", "table", "residual"] {
        assert_eq!(made[member], Value::Null, "{member}");
    }
    assert!(
        made["advice"].as_array().unwrap().iter().any(|line| line.as_str().unwrap().contains("Sweep it"))
    );
    let again = app.put(RIG, optics()).await.expect(200);
    assert_eq!(again, made, "the same optics changes nothing");
    let mut wider = optics();
    wider["f_number"] = json!(2.0);
    let changed = app.put(RIG, wider).await.expect(200);
    assert_eq!(
        (&changed["optics"]["aperture_mm"], &changed["created_at"]),
        (&json!(12.5), &made["created_at"])
    );
    assert_eq!(app.get(RIG).await.expect(200), changed);

    app.put("/v1/calibrations/arm", optics()).await.expect(201);
    let page = app.get("/v1/calibrations?limit=1").await.expect(200);
    assert_eq!((&page["items"][0]["name"], &page["next_cursor"]), (&json!("arm"), &json!("arm")));
    let page = app.get("/v1/calibrations?limit=1&cursor=arm").await.expect(200);
    assert_eq!(page["items"], json!([changed]));

    app.delete(RIG).await.expect(204);
    for answer in [
        app.delete(RIG).await,
        app.get(RIG).await,
        sweep(&app, &[]).await,
        send(&app, "registration", &[]).await,
    ] {
        answer.expect_problem(404, "unknown_calibration");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_optics_that_cannot_be_makes_no_rig() {
    let app = App::start().await;
    let mut wrong = optics();
    wrong["focal_length_mm"] = json!(-25);
    wrong["aperture_mm"] = json!(9);
    let problem = app.put(RIG, wrong).await.expect_problem(422, "invalid_field");
    let at = pointers(&problem);
    assert_eq!(at, ["/aperture_mm", "/f_number", "/focal_length_mm"]);
    app.get(RIG).await.expect_problem(404, "unknown_calibration");
    app.put("/v1/calibrations/-rig", optics()).await.expect_problem(422, "invalid_field");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_swept_rig_has_a_table_and_measures_by_it() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let depths_mm = depths_mm(9);
    let mut parts = sweep_parts(&depths_mm, &depths_mm);
    // The manifest may come first, too.
    parts.rotate_right(1);
    let answer = sweep(&app, &parts).await;
    let queued = answer.expect(202);
    assert_eq!(answer.header("location"), format!("/v1/jobs/{}", queued["id"].as_str().unwrap()));
    assert_eq!((&queued["kind"], &queued["database"]), (&json!("sweep"), &Value::Null));
    assert_eq!(queued["calibration"], "rig");
    let job = app.finished(&queued).await;
    assert_eq!(job["state"], "succeeded", "{job:#}");
    assert_eq!(job["version"], Value::Null);
    let listed = app.get("/v1/jobs?calibration=rig").await.expect(200);
    assert_eq!(listed["items"][0]["id"], queued["id"]);
    assert_eq!(app.get("/v1/jobs?calibration=arm").await.expect(200)["items"], json!([]));

    let rig = app.get(RIG).await.expect(200);
    let kept: Vec<f64> =
        rig["table"]["depth_mm"].as_array().unwrap().iter().map(|mm| mm.as_f64().unwrap()).collect();
    assert_eq!(kept.len(), depths_mm.len(), "{rig:#}");
    assert_eq!(rig["image"], json!({"width": SIZE_PX.0, "height": SIZE_PX.1, "bits": 8}));
    assert_eq!(rig["filters"]["method"], "gram");
    assert!(rig["residual"]["max_mm"].as_f64().unwrap() < 10.0, "{rig:#}");

    let told =
        depth_map(&app, Relief::Plane { share: 0.5 }, &[("calibration", json!("rig"))]).await.expect(200);
    assert_eq!(told["calibration"], "rig");
    let middle_mm = (529.0 + far_focus_mm()) / 2.0;
    assert!((told["depth_mm"]["median"].as_f64().unwrap() - middle_mm).abs() < 4.0, "{told:#}");

    // Pictures of another size are not this rig's.
    let others = [("near", scene_png(1)), ("far", scene_png(2)), ("calibration", Bytes::from_static(b"rig"))];
    let answer = app.post_bytes("/v1/depth-maps", &form_type(), form(&others)).await;
    answer.expect_problem(422, "image_size_mismatch");

    // The same optics keeps the table, another drops it.
    assert_eq!(app.put(RIG, optics()).await.expect(200)["table"], rig["table"]);
    let mut wider = optics();
    wider["f_number"] = json!(2.0);
    assert_eq!(app.put(RIG, wider).await.expect(200)["table"], Value::Null);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sweep_that_cannot_be_is_refused_at_once() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let four = depths_mm(4);
    sweep(&app, &sweep_parts(&four, &four)).await.expect_problem(422, "too_few_planes");
    // Depths that don't reach past the far focus distance, one depth twice, one within the focal length.
    let five = depths_mm(5);
    let mut parts = sweep_parts(&five, &[515.0, 550.0, 600.0, 650.0, 700.0]);
    sweep(&app, &parts).await.expect_problem(422, "sweep_refused");
    for told in [
        [515.0, 550.0, 550.0, 700.0, 765.0],
        [10.0, 550.0, 600.0, 700.0, 765.0],
        [-515.0, 550.0, 600.0, 700.0, 765.0],
    ] {
        let lines: Vec<Value> = (0..5)
            .map(|at| json!({"depth_mm": told[at], "near": format!("n{at}"), "far": format!("f{at}")}))
            .collect();
        parts.pop();
        parts.push(("manifest".into(), Value::Array(lines).to_string().into()));
        sweep(&app, &parts).await.expect_problem(422, "sweep_refused");
    }
    assert_eq!(app.get("/v1/jobs").await.expect(200)["items"], json!([]));
}

#[tokio::test(flavor = "multi_thread")]
async fn every_fault_of_a_sweeps_form_is_named() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let five = depths_mm(5);
    let whole = sweep_parts(&five, &five);
    let without = |name: &str| -> Vec<(String, Bytes)> {
        whole.iter().filter(|(part, _)| part != name).cloned().collect()
    };
    let problem = sweep(&app, &without("manifest")).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/manifest"]);
    let mut parts = without("f2");
    parts.extend([
        ("extra".into(), scene_png(1)),
        ("options".into(), Bytes::from_static(br#"{"method": "stereo"}"#)),
    ]);
    let problem = sweep(&app, &parts).await.expect_problem(422, "invalid_field");
    let at = pointers(&problem);
    assert_eq!(at, ["/extra", "/manifest/2/far", "/options/method"]);

    let with = |name: &str, bytes: Bytes| {
        let mut parts = without(name);
        parts.push((name.into(), bytes));
        parts
    };
    let table = [
        (with("f2", whole[4].1.clone()), 422, "identical_images", None),
        (with("f2", scene_png(1)), 422, "image_size_mismatch", Some("/f2")),
        (with("f2", whole[5].1.slice(..99)), 400, "corrupt_image", Some("/f2")),
        (with("f2", Bytes::from_static(b"GIF89a")), 415, "unsupported_image_format", Some("/f2")),
        (with("manifest", Bytes::from_static(b"[{")), 400, "malformed_request", Some("/manifest")),
        (with("manifest", Bytes::from_static(br#"[{"depth": 1}]"#)), 422, "invalid_field", None),
    ];
    for (parts, status, code, at) in table {
        let problem = sweep(&app, &parts).await.expect_problem(status, code);
        if let Some(at) = at {
            assert_eq!(pointers(&problem), [at], "{problem:#}");
        }
    }
    let mut twice = whole.clone();
    twice.push(whole[0].clone());
    let problem = sweep(&app, &twice).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/n0"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sweep_that_is_not_monotone_fails_its_job_and_leaves_the_rig_as_it_was() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let shown = depths_mm(7);
    let mut told = shown.clone();
    told.swap(2, 4);
    let queued = sweep(&app, &sweep_parts(&shown, &told)).await.expect(202);
    let job = app.finished(&queued).await;
    assert_eq!(
        (&job["state"], &job["problem"]["code"]),
        (&json!("failed"), &json!("not_monotone")),
        "{job:#}"
    );
    let rig = app.get(RIG).await.expect(200);
    assert_eq!((&rig["table"], &rig["failed_sweep"]), (&Value::Null, &job["id"]));

    // What was known before it answers, and says so; a rig that was described anew has no failed sweep.
    let warned = |answer: &Value| answer["warnings"].as_array().unwrap().contains(&json!("sweep_failed"));
    let by_rig = [("calibration", json!("rig"))];
    let answer = depth_map(&app, Relief::Slant, &by_rig).await.expect(200);
    assert!(warned(&answer), "{answer:#}");
    let mut other = optics();
    other["f_number"] = json!(2.7);
    app.put(RIG, other).await.expect(200);
    assert!(app.get(RIG).await.expect(200).get("failed_sweep").is_none());
    assert!(!warned(&depth_map(&app, Relief::Slant, &by_rig).await.expect(200)));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_plane_without_texture_fails_its_job() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let depths_mm = depths_mm(5);
    let mut parts = sweep_parts(&depths_mm, &depths_mm);
    let flat = |level: u8| {
        let (width, height) = SIZE_PX;
        Bytes::from(landmarkd_core::imaging::encode::png_gray8(width, height, &vec![level; width * height]))
    };
    (parts[4].1, parts[5].1) = (flat(99), flat(100));
    let job = app.finished(&sweep(&app, &parts).await.expect(202)).await;
    assert_eq!(
        (&job["state"], &job["problem"]["code"]),
        (&json!("failed"), &json!("too_little_texture")),
        "{job:#}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_queued_sweep_outlives_a_restart() {
    let mut app = App::start_idle().await;
    app.put(RIG, optics()).await.expect(201);
    let depths_mm = depths_mm(5);
    let queued = sweep(&app, &sweep_parts(&depths_mm, &depths_mm)).await.expect(202);
    app.leave_jobs();
    let folder = app.stop();
    let app = App::open(folder, |_| ()).await;
    let job = app.finished(&queued).await;
    assert_eq!(job["state"], "succeeded", "{job:#}");
    assert_ne!(app.get(RIG).await.expect(200)["table"], Value::Null);
}

#[tokio::test(flavor = "multi_thread")]
async fn deleting_a_rig_cancels_its_sweeps() {
    let mut app = App::start_idle().await;
    app.put(RIG, optics()).await.expect(201);
    let depths_mm = depths_mm(5);
    let queued = sweep(&app, &sweep_parts(&depths_mm, &depths_mm)).await.expect(202);
    app.delete(RIG).await.expect(204);
    app.begin();
    let job = app.finished(&queued).await;
    let ended = (&job["state"], &job["problem"]["code"]);
    assert_eq!(ended, (&json!("cancelled"), &json!("calibration_deleted")), "{job:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sweep_of_a_rig_that_was_changed_meanwhile_changes_nothing() {
    let mut app = App::start_idle().await;
    app.put(RIG, optics()).await.expect(201);
    let depths_mm = depths_mm(5);
    let queued = sweep(&app, &sweep_parts(&depths_mm, &depths_mm)).await.expect(202);
    let mut wider = optics();
    wider["f_number"] = json!(2.0);
    let changed = app.put(RIG, wider).await.expect(200);
    app.begin();
    let job = app.finished(&queued).await;
    let ended = (&job["state"], &job["problem"]["code"]);
    assert_eq!(ended, (&json!("failed"), &json!("calibration_changed")), "{job:#}");
    assert_eq!(app.get(RIG).await.expect(200), changed);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_rig_is_registered_by_one_target() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    // Larger than the others': it is registered by its parts.
    let (width, height) = (256, 240);
    let target = photograph_of((width, height), Relief::Plane { share: 0.5 }, 11).pngs().map(Bytes::from);
    let level = |level: u8| {
        Bytes::from(landmarkd_core::imaging::encode::png_gray8(width, height, &vec![level; width * height]))
    };
    let whole: Vec<(String, Bytes)> = [
        ("near", target[0].clone()),
        ("far", target[1].clone()),
        ("dark_near", level(2)),
        ("dark_far", level(4)),
    ]
    .map(|(name, bytes)| (name.to_owned(), bytes))
    .into();
    let rig = send(&app, "registration", &whole).await.expect(200);
    assert!(rig["registration"]["rms_px"].as_f64().unwrap() < 0.1, "{rig:#}");
    assert_eq!(
        (&rig["photometric"]["dark_near"], &rig["photometric"]["dark_far"]),
        (&json!(2.0), &json!(4.0))
    );
    assert_eq!(rig["image"], json!({"width": width, "height": height, "bits": 8}));
    assert_eq!(app.get(RIG).await.expect(200), rig);

    let problem = send(&app, "registration", &whole[1..3]).await.expect_problem(422, "invalid_field");
    let at = pointers(&problem);
    assert_eq!(at, ["/dark_far", "/near"]);
    let mut other_size = whole.clone();
    other_size[2].1 = flat_png(40);
    let problem = send(&app, "registration", &other_size).await.expect_problem(422, "image_size_mismatch");
    assert_eq!(pointers(&problem), ["/dark_near"]);
    let blank = [("near".to_owned(), level(99)), ("far".to_owned(), level(100))];
    let problem = send(&app, "registration", &blank).await.expect_problem(422, "registration_refused");
    assert!(problem["detail"].as_str().unwrap().contains("texture"), "{problem:#}");
    assert_eq!(app.get(RIG).await.expect(200), rig, "a refusal changes nothing");
}
