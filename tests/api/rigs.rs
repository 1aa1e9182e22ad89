//! Rigs of other kinds than two focus settings whose optics are known: two apertures of one focus, an aperture that isn't known,
//! and focus stacks.

use axum::http::{Method, header};
use bytes::Bytes;
use futures_util::future::join_all;
use landmarkd_core::depth::scene::{
    Camera, Relief, Rendered, Scene, Texture, bench_aperture_pair, bench_optics,
};
use landmarkd_core::depth::{Aperture, Optics, OpticsSpec, Pair, Sensor};
use landmarkd_core::imaging::encode::png_gray8;
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers, request, with_bytes};

const RIG: &str = "/v1/calibrations/iris";

/// A lens of 35 mm focused at 500 mm, at f/2.8 and f/8, for what stands from there to 540 mm.
fn optics() -> Value {
    json!({
        "focal_length_mm": 35, "f_numbers": [2.8, 8], "focus_mm": 500, "range_end_mm": 540, "pixel_pitch_um": 10,
        "telecentric": false,
    })
}

fn iris() -> Camera {
    Camera { width: 128, height: 96, ..Camera::new(bench_aperture_pair([2.8, 8.0], 540.0, false)) }
}

/// The wide-open and the stopped-down picture.
fn pictures(seen: &Rendered) -> [Bytes; 2] {
    seen.pngs().map(Bytes::from)
}

fn text(value: &Value) -> Bytes {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned).into()
}

async fn depth(app: &App, parts: &[(&str, Bytes)]) -> Answer {
    app.post_bytes("/v1/depth-maps", &form_type(), form(parts)).await
}

/// Send a form to the rig.
async fn send<N: AsRef<str>>(app: &App, path: &str, parts: &[(N, Bytes)]) -> Answer {
    app.post_bytes(&format!("{RIG}/{path}"), &form_type(), form(parts)).await
}

fn median_mm(told: &Value) -> f64 {
    told["depth_mm"]["median"].as_f64().unwrap_or_else(|| panic!("{told:#}"))
}

#[tokio::test(flavor = "multi_thread")]
async fn two_apertures_measure_under_their_own_names() {
    let app = App::start().await;
    let seen = iris().photograph(&Scene::new(Relief::Plane { share: 0.6 }, Texture::Gravel, 1));
    let [wide, narrow] = pictures(&seen);
    let parts = [("narrow", narrow.clone()), ("optics", text(&optics())), ("wide", wide.clone())];
    let told = depth(&app, &parts).await.expect(200);
    assert!((median_mm(&told) - seen.depth_mm[0]).abs() < 0.4, "{told:#}");
    assert!(
        told["far_focus_mm"].as_f64().unwrap() > 539.9 && told["near_focus_mm"].as_f64().unwrap() > 500.0
    );
    assert!(told["coverage"].as_f64().unwrap() > 0.5 && told.get("blur_scale").is_none(), "{told:#}");

    // Pictures of the other kind, or of both.
    let wrong = [("near", wide.clone()), ("far", narrow.clone()), ("optics", text(&optics()))];
    let problem = depth(&app, &wrong).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/near"]);
    assert!(problem["errors"][0]["detail"].as_str().unwrap().contains("wide and narrow"), "{problem:#}");
    let both = [
        ("near", wide.clone()),
        ("far", narrow.clone()),
        ("wide", wide.clone()),
        ("optics", text(&optics())),
    ];
    let problem = depth(&app, &both).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/wide"]);
    let half = [("wide", wide.clone()), ("optics", text(&optics()))];
    let problem = depth(&app, &half).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/narrow"]);
    let twice = [("wide", wide.clone()), ("narrow", wide), ("optics", text(&optics()))];
    depth(&app, &twice).await.expect_problem(422, "identical_images");
}

#[tokio::test(flavor = "multi_thread")]
async fn depth_maps_of_one_key_hold_the_room_that_they_declare() {
    let mut app = App::start().await;
    app.close().await;
    let seen = iris().photograph(&Scene::new(Relief::Plane { share: 0.6 }, Texture::Gravel, 1));
    let [wide, narrow] = pictures(&seen);
    let body = form(&[("wide", wide), ("narrow", narrow), ("optics", text(&optics()))]);
    let ask = || {
        let declared = request(Method::POST, "/v1/depth-maps").header(header::CONTENT_LENGTH, body.len());
        app.send(with_bytes(declared, &form_type(), body.clone()))
    };
    for answer in join_all([ask(), ask()]).await {
        answer.expect(200);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_sweep_stays_on_one_side_of_the_focus() {
    let app = App::start().await;
    app.put(RIG, optics()).await.expect(201);
    let seen = iris().photograph(&Scene::new(Relief::Plane { share: 0.6 }, Texture::Gravel, 1));
    let [wide, narrow] = pictures(&seen);
    let line = |depth_mm: f64| json!({"depth_mm": depth_mm, "wide": "w", "narrow": "n"});
    let manifest = text(&Value::from([490.0, 510.0, 520.0, 530.0, 545.0].map(line).to_vec()));
    let answer = send(&app, "sweep", &[("w", wide), ("n", narrow), ("manifest", manifest)]).await;
    assert_eq!(pointers(&answer.expect_problem(422, "invalid_field")), ["/manifest/0/depth_mm"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn what_makes_no_pair_of_apertures_is_named() {
    let app = App::start().await;
    for (changed, at) in [
        (json!({"range_end_mm": 500}), vec!["/range_end_mm"]),
        (json!({"range_end_mm": null}), vec!["/range_end_mm"]),
        (json!({"f_numbers": [4, 4.2]}), vec!["/f_numbers"]),
        (json!({"f_numbers": [4]}), vec!["/f_numbers"]),
        (json!({"apertures_mm": [9, 4]}), vec!["/apertures_mm", "/f_numbers"]),
        (json!({"f_number": 8}), vec!["/f_number"]),
        (json!({"plane_separation_mm": 0.4}), vec!["/plane_separation_mm"]),
        (json!({"aperture": "unknown"}), vec!["/aperture"]),
        (json!({"focus_mm": 20}), vec!["/focus_mm"]),
    ] {
        let mut body = optics();
        body.as_object_mut().unwrap().extend(changed.as_object().unwrap().clone());
        let problem = app.put(RIG, body).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), at, "{changed}: {problem:#}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn two_apertures_are_kept_swept_and_predicted() {
    let app = App::start().await;
    let made = app.put(RIG, optics()).await.expect(201);
    assert_eq!(made["optics"]["range_end_mm"], 540.0);
    assert!(made["optics"].get("plane_separation_mm").is_none(), "{made:#}");
    assert_eq!(app.put(RIG, optics()).await.expect(200), made, "the same optics changes nothing");
    assert_eq!(app.put(RIG, made["optics"].clone()).await.expect(200), made, "nor does what it answers");

    let camera = iris();
    let at_mm = |at: usize| 506.0 + 35.0 * at as f64 / 8.0;
    let mut parts: Vec<(String, Bytes)> = Vec::new();
    let mut lines = Vec::new();
    for at in 0..9 {
        let share = (at_mm(at) - camera.optics.near_focus_mm()) / camera.optics.range_mm();
        let seen = camera.photograph(&Scene::new(Relief::Plane { share }, Texture::Gravel, 20 + at as u64));
        let [wide, narrow] = pictures(&seen);
        parts.extend([(format!("w{at}"), wide), (format!("n{at}"), narrow)]);
        lines.push(json!({"depth_mm": at_mm(at), "wide": format!("w{at}"), "narrow": format!("n{at}")}));
    }
    let with = |lines: &[Value]| {
        let manifest = Bytes::from(Value::from(lines.to_vec()).to_string());
        [parts.as_slice(), &[("manifest".into(), manifest)]].concat()
    };
    let mut other = lines.clone();
    other[0] = json!({"depth_mm": at_mm(0), "near": "w0", "far": "n0"});
    let problem = send(&app, "sweep", &with(&other)).await.expect_problem(422, "invalid_field");
    let at = ["/manifest/0/far", "/manifest/0/narrow", "/manifest/0/near", "/manifest/0/wide"];
    assert_eq!(pointers(&problem), at, "{problem:#}");
    let job = app.finished(&send(&app, "sweep", &with(&lines)).await.expect(202)).await;
    assert_eq!(job["state"], "succeeded", "{job:#}");

    let seen = camera.photograph(&Scene::new(Relief::Plane { share: 0.3 }, Texture::Gravel, 40));
    let [wide, narrow] = pictures(&seen);
    let parts =
        [("wide", wide.clone()), ("narrow", narrow.clone()), ("calibration", Bytes::from_static(b"iris"))];
    let told = depth(&app, &parts).await.expect(200);
    assert!((median_mm(&told) - seen.depth_mm[0]).abs() < 0.4, "{told:#}");

    let problem = send(&app, "registration", &[("near", wide.clone()), ("far", narrow.clone())]).await;
    let problem = problem.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/far", "/narrow", "/near", "/wide"]);
    let target = Camera { width: 256, height: 240, ..camera };
    let [wide, narrow] = pictures(&target.photograph(&Scene::new(Relief::Slant, Texture::Gravel, 41)));
    let dark = Bytes::from(png_gray8(256, 240, &[3; 256 * 240]));
    let sent = [("wide", wide), ("narrow", narrow), ("dark_wide", dark.clone()), ("dark_narrow", dark)];
    let registered = send(&app, "registration", &sent).await.expect(200);
    assert!(registered["registration"]["rms_px"].as_f64().unwrap() < 0.1, "{registered:#}");
    assert_eq!(registered["photometric"]["dark_near"], 3.0);

    let answer = app.post("/v1/optics:predict", json!({"optics": optics(), "range_mm": [505, 700]})).await;
    let answer = answer.expect(200);
    let [from, to] = [0, 1].map(|k| answer["working_range_mm"][k].as_f64().unwrap());
    assert!(from > 500.0 && from < 510.0 && to > 535.0 && to < 545.0, "{answer:#}");
    let at = &answer["distances"][5];
    assert!(at["near_blur_px"].as_f64() > at["far_blur_px"].as_f64(), "the wide-open one first: {at:#}");
    let advice = answer["advice"][0].as_str().unwrap();
    assert!(advice.contains("end the range at 700 mm"), "{advice}");
}

#[tokio::test(flavor = "multi_thread")]
async fn an_aperture_that_is_not_known_is_measured_and_marked() {
    let app = App::start().await;
    let truth = bench_optics(7.0, true);
    let camera = Camera::new(truth);
    let seen = camera.photograph(&Scene::new(Relief::Slant, Texture::Gravel, 5));
    let [near, far] = pictures(&seen);
    let optics = json!({
        "focal_length_mm": 35, "aperture": "unknown", "near_focus_mm": 500, "plane_separation_mm": 0.4,
        "pixel_pitch_um": 10, "telecentric": true,
    });
    let told = depth(&app, &[("near", near), ("far", far), ("optics", text(&optics))]).await.expect(200);
    let found = |member: &str| told["blur_scale"][member].as_f64().unwrap_or_else(|| panic!("{told:#}"));
    assert!((found("largest_blur_px") - truth.largest_blur_px()).abs() < 3.0 * found("sigma_px"), "{told:#}");
    assert!(
        (found("aperture_mm") - 5.0).abs() < 0.4
            && told["largest_blur_px"] == told["blur_scale"]["largest_blur_px"]
    );
    assert!(told["warnings"].as_array().unwrap().contains(&json!("scale_estimated")), "{told:#}");
    assert!(told["coverage"].as_f64().unwrap() > 0.5);

    // A blank wall says nothing of the aperture.
    let [near, far] = pictures(&camera.photograph(&Scene::new(Relief::Slant, Texture::Plain, 5)));
    let blank = depth(&app, &[("near", near), ("far", far), ("optics", text(&optics))]).await;
    blank.expect_problem(422, "scale_unclear");
    // What is kept or predicted has an aperture.
    let problem = app.put(RIG, optics.clone()).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/aperture"]);
    let problem = app.post("/v1/optics:predict", json!({"optics": optics})).await;
    assert_eq!(pointers(&problem.expect_problem(422, "invalid_field")), ["/optics/aperture"]);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_focus_stack_measures_beyond_its_first_two_settings() {
    let app = App::start().await;
    let first_mm = 35.0 * 500.0 / 465.0;
    let planes_mm: [f64; 3] = [first_mm, first_mm - 0.4, first_mm - 0.8];
    let camera = |last: usize| {
        let optics = Optics::new(&OpticsSpec {
            focal_length_mm: 35.0,
            pair: Pair::Focal {
                aperture: Aperture::FNumber(8.0),
                near_sensor: Sensor::PlaneMm(planes_mm[0]),
                plane_separation_mm: planes_mm[0] - planes_mm[last],
            },
            pixel_pitch_um: 10.0,
            telecentric: true,
            principal_point_px: None,
        });
        Camera { width: 128, height: 96, ..Camera::new(optics.unwrap()) }
    };
    // Beyond the second focus, so by the second pair alone.
    let whole = camera(2).optics;
    let depth_mm = whole.depth_mm(-0.35);
    let shown = |last: usize| {
        let optics = camera(last).optics;
        let share = (depth_mm - optics.near_focus_mm()) / optics.range_mm();
        pictures(&camera(last).photograph(&Scene::new(Relief::Plane { share }, Texture::Gravel, 6)))
    };
    let [[first, second], [_, third]] = [shown(1), shown(2)];
    let optics = json!({
        "focal_length_mm": 35, "f_number": 8, "planes_mm": planes_mm, "pixel_pitch_um": 10, "telecentric": true,
    });
    let parts = |list: &[&Bytes], name: &'static str| -> Vec<(&str, Bytes)> {
        let pictures = list.iter().map(|picture| (name, (*picture).clone()));
        pictures.chain([("optics", text(&optics))]).collect()
    };
    let told = depth(&app, &parts(&[&first, &second, &third], "stack")).await.expect(200);
    assert!((median_mm(&told) - depth_mm).abs() < 0.005 * whole.range_mm(), "not {depth_mm:.1}: {told:#}");
    assert!((told["far_focus_mm"].as_f64().unwrap() - whole.far_focus_mm()).abs() < 1e-3);
    let same = depth(&app, &parts(&[&first, &second, &third], "stack[]")).await.expect(200);
    assert_eq!(same["depth_mm"], told["depth_mm"], "both ways of naming a list");

    let problem = depth(&app, &parts(&[&first, &second], "stack")).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/stack"]);
    let problem = depth(&app, &parts(&[&first, &third, &third], "stack")).await;
    problem.expect_problem(422, "identical_images");
    let mut mixed = parts(&[&first, &second, &third], "stack");
    mixed.push(("near", first.clone()));
    assert_eq!(pointers(&depth(&app, &mixed).await.expect_problem(422, "invalid_field")), ["/near"]);
    let problem = app.put(RIG, optics.clone()).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/planes_mm"]);
    for (wrong, at) in [
        (json!({"planes_mm": [37.2, 37.6, 36.8]}), "/optics/planes_mm"),
        (json!({"planes_mm": [37.6, 37.2]}), "/optics/planes_mm"),
        (json!({"planes_mm": []}), "/optics/planes_mm"),
        (json!({"near_focus_mm": 500}), "/optics/near_focus_mm"),
    ] {
        let mut body = optics.clone();
        body.as_object_mut().unwrap().extend(wrong.as_object().unwrap().clone());
        let parts = [
            ("stack", first.clone()),
            ("stack", second.clone()),
            ("stack", third.clone()),
            ("optics", text(&body)),
        ];
        let problem = depth(&app, &parts).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), [at], "{wrong}");
    }
}
