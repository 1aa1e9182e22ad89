//! Depth maps: distances in every form, and a problem that says what to do for everything that is no focal pair.

use axum::http::{Method, header};
use bytes::Bytes;
use landmarkd_core::depth::scene::Relief;
use landmarkd_core::imaging::encode::png_gray8;
use landmarkd_core::imaging::{DecodeLimits, decode};
use landmarkd_core::statistics::median;
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers, request, with_bytes};
use crate::depth_pictures::{SIZE_PX, optics, pair, parts, photograph};
use crate::pictures::{flat_png, png, scene};

const PATH: &str = "/v1/depth-maps";

/// Ask for a depth map of these parts in that form.
async fn ask(app: &App, query: &str, accept: &str, parts: &[(&str, Bytes)]) -> Answer {
    let asked = request(Method::POST, &format!("{PATH}{query}")).header(header::ACCEPT, accept);
    let answer = app.send(with_bytes(asked, &form_type(), form(parts))).await;
    assert_eq!(answer.header("vary"), "Accept", "{answer:?}");
    answer
}

/// Ask for the summary.
async fn summary(app: &App, parts: &[(&str, Bytes)]) -> Answer {
    ask(app, "", "application/json", parts).await
}

/// The shape in an array's header, and its values.
fn array(bytes: &[u8]) -> (String, Vec<f32>) {
    let header_bytes = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..header_bytes]).unwrap();
    let shape = header.split("'shape': ").nth(1).unwrap().split(')').next().unwrap().to_owned() + ")";
    (shape, bytes[header_bytes..].as_chunks().0.iter().map(|value| f32::from_le_bytes(*value)).collect())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_slant_is_measured_and_told_in_every_form() {
    let app = App::start().await;
    let seen = photograph(Relief::Slant, 1);
    let parts = parts(&seen.pngs().map(Bytes::from), &[("optics", optics())]);
    let (width, height) = SIZE_PX;

    let told = summary(&app, &parts).await.expect(200);
    assert_eq!((&told["width_px"], &told["height_px"]), (&json!(width), &json!(height)));
    assert_eq!((&told["method"], &told["window"]), (&json!("gram"), &json!("auto")));
    assert_eq!(told["calibration"], Value::Null);
    let number = |member: &str| told[member].as_f64().unwrap();
    assert!((number("near_focus_mm") - 529.0).abs() < 1e-6 && number("far_focus_mm") > 700.0, "{told:#}");
    let range_mm = number("range_mm");
    assert!((range_mm - number("far_focus_mm") + number("near_focus_mm")).abs() < 1e-6);
    assert!((number("largest_blur_px") - 4.56).abs() < 0.05 && number("coverage") > 0.5, "{told:#}");

    let npy = ask(&app, "", "application/x-npy", &parts).await;
    assert_eq!((npy.status, npy.header("content-type")), (200, "application/x-npy"));
    let (shape, depths_mm) = array(&npy.body);
    assert_eq!(shape, format!("({height}, {width},)"));
    let known: Vec<(f32, f64)> =
        depths_mm.iter().copied().zip(seen.depth_mm).filter(|(depth, _)| depth.is_finite()).collect();
    let mut errors: Vec<f64> = known.iter().map(|(depth, truth)| (f64::from(*depth) - truth).abs()).collect();
    let half_mm = median(&mut errors, f64::total_cmp).unwrap();
    assert!(half_mm < 0.01 * range_mm, "half are off by {half_mm} mm");
    let least = known.iter().map(|(depth, _)| f64::from(*depth)).fold(f64::MAX, f64::min);
    assert!((told["depth_mm"]["min"].as_f64().unwrap() - least).abs() < 1e-3, "{told:#}");
    assert!((number("coverage") - known.len() as f64 / (width * height) as f64).abs() < 1e-6);
    // What isn't hidden in the summary isn't hidden beside a file.
    assert_eq!(npy.header("x-near-focus-mm").parse::<f64>().unwrap(), number("near_focus_mm"));
    assert_eq!(npy.header("x-far-focus-mm").parse::<f64>().unwrap(), number("far_focus_mm"));
    assert_eq!(npy.header("x-coverage").parse::<f64>().unwrap(), number("coverage"));
    let warnings: Vec<&str> =
        told["warnings"].as_array().unwrap().iter().map(|warning| warning.as_str().unwrap()).collect();
    assert_eq!(npy.header("x-warnings"), warnings.join(","));

    let planes = ask(&app, "?planes=depth,sigma,flags", "application/x-npy", &parts).await;
    let (shape, planes) = array(&planes.body);
    assert_eq!(shape, format!("(3, {height}, {width},)"));
    let [depth, sigma, flags] = [0, 1, 2].map(|plane| &planes[plane * width * height..][..width * height]);
    for at in 0..width * height {
        assert_eq!(depth[at].to_bits(), depths_mm[at].to_bits());
        assert_eq!(depth[at].is_finite(), flags[at] == 0.0, "a flagged pixel has no depth: {at}");
        assert!(!depth[at].is_finite() || sigma[at] > 0.0, "a depth comes with its error: {at}");
    }
    let flagged = told["flags"].as_object().unwrap();
    let border = flags.iter().filter(|flag| **flag as u8 & 16 != 0).count();
    assert_eq!((flagged.len(), &flagged["border"]), (6, &json!(border)));
    let (shape, alone) = array(&ask(&app, "?planes=flags", "application/x-npy", &parts).await.body);
    assert_eq!((shape, alone.as_slice()), (format!("({height}, {width},)"), flags));

    let picture = ask(&app, "", "image/png", &parts).await;
    assert_eq!((picture.header("content-type"), picture.header("x-depth-scale-mm")), ("image/png", "0.1"));
    let read = decode(&picture.body, &DecodeLimits::default()).unwrap();
    for (level, depth) in read.luminance.pixels().iter().zip(&depths_mm) {
        let mm = f64::from(*level) * 257.0 * 0.1;
        let right = if depth.is_finite() { (mm - f64::from(*depth)).abs() < 0.06 } else { mm == 0.0 };
        assert!(right, "{mm} mm in the picture, {depth} mm in the array");
    }

    let cloud = ask(&app, "", "model/ply", &parts).await;
    assert_eq!(cloud.header("content-type"), "model/ply");
    let head = format!("element vertex {}\n", known.len());
    assert!(cloud.body.windows(head.len()).any(|part| part == head.as_bytes()));
    let last = &cloud.body[cloud.body.len() - 15..];
    let metres = f32::from_le_bytes(last[8..12].try_into().unwrap());
    assert!((metres * 1000.0 - known.last().unwrap().0).abs() < 0.01);

    let preview = ask(&app, "", "image/png; preview=turbo", &parts).await;
    assert_eq!((preview.header("content-type"), preview.header("x-depth-scale-mm")), ("image/png", ""));
    let drawn = decode(&preview.body, &DecodeLimits::default()).unwrap();
    assert!(drawn.is_colour() && drawn.height() > height);

    let metrics = app.get("/metrics").await;
    let text = String::from_utf8_lossy(&metrics.body);
    for (stage, times) in [("queue", 7), ("estimate", 7), ("encode", 6)] {
        let line = format!(r#"landmarkd_depth_stage_seconds_count{{stage="{stage}"}} {times}"#);
        assert!(text.contains(&line), "{line}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_given_is_refused_before_the_form_is_read() {
    let app = App::start().await;
    for accept in ["text/html", "image/png;preview=grey", "image/jpeg"] {
        let problem = ask(&app, "", accept, &[("near", Bytes::new())]).await;
        let problem = problem.expect_problem(406, "not_acceptable");
        assert!(problem["detail"].as_str().unwrap().contains("image/png; preview=turbo"), "{problem:#}");
    }
    for planes in ["", "depth,", "depth,colour", "flags,flags", "Depth"] {
        let query = format!("?planes={planes}");
        let problem = ask(&app, &query, "application/x-npy", &[]).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), ["#planes"], "{planes}");
    }
    let asked = with_bytes(request(Method::POST, PATH), "image/png", Bytes::new());
    let problem = app.send(asked).await.expect_problem(415, "unsupported_media_type");
    assert!(problem["detail"].as_str().unwrap().contains("-F near=@near.png -F far=@far.png"), "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn parts_come_in_any_order_and_the_robot_is_echoed() {
    let app = App::start().await;
    let options = json!({"method": "stm", "window": 4, "align": "none", "photometric": "none", "median": 3});
    let mut parts = parts(&pair(Relief::Cone, 2), &[("optics", optics()), ("options", options)]);
    let first = summary(&app, &parts).await.expect(200);
    assert_eq!((&first["method"], &first["window"]), (&json!("stm"), &json!(4.0)));
    assert_eq!((&first["shift_px"], &first["gain"]), (&json!([0.0, 0.0]), &json!(1.0)));
    parts.reverse();
    let asked = request(Method::POST, PATH).header("x-robot-id", "r2").header("x-stamp", "12.5");
    let again = app.send(with_bytes(asked, &form_type(), form(&parts))).await.expect(200);
    assert_eq!(again["header"], json!({"robot_id": "r2", "frame_id": null, "stamp": "12.5"}));
    for member in ["coverage", "depth_mm", "flags", "warnings"] {
        assert_eq!(again[member], first[member], "{member}");
    }
    let timings = first["timings_ms"].as_object().unwrap();
    let took = |stage: &str| timings[stage].as_f64().unwrap();
    let sum = took("register") + took("match") + took("estimate") + took("judge");
    assert!((took("total") - sum).abs() < 1e-9 && sum > 0.0 && took("decode") > 0.0, "{timings:?}");
    assert!(again["timings_ms"]["design"].as_f64().unwrap() <= took("design") + 1.0);
}

#[tokio::test(flavor = "multi_thread")]
async fn every_part_that_is_missing_unknown_or_wrong_is_named_at_once() {
    let app = App::start().await;
    let [near, far] = pair(Relief::Slant, 3);
    let problem = summary(&app, &[]).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/far", "/near", "/optics"]);
    let wrong = [
        ("near", near.clone()),
        ("right", far.clone()),
        ("optics", Bytes::from_static(br#"{"focal_length_mm": -25, "colour": 1}"#)),
        ("options", Bytes::from_static(br#"{"method": "stereo", "median": 4}"#)),
    ];
    let problem = summary(&app, &wrong).await.expect_problem(422, "invalid_field");
    let named = pointers(&problem);
    for pointer in [
        "/far",
        "/right",
        "/optics/focal_length_mm",
        "/optics/colour",
        "/optics/aperture_mm",
        "/options/method",
        "/options/median",
    ] {
        assert!(named.contains(&pointer), "{pointer}: {problem:#}");
    }
    let mut twice = parts(&[near.clone(), far.clone()], &[("optics", optics())]);
    twice.push(("far", far.clone()));
    let problem = summary(&app, &twice).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/far"]);

    let both = parts(&[near.clone(), far.clone()], &[("optics", optics()), ("calibration", json!("rig"))]);
    let problem = summary(&app, &both).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/calibration", "/optics"]);
    let named = |name: &str| parts(&[near.clone(), far.clone()], &[("calibration", json!(name))]);
    summary(&app, &named("rig")).await.expect_problem(404, "unknown_calibration");
    let problem = summary(&app, &named("../rig")).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/calibration"]);

    for (text, status, code) in [
        (r#"{"focal_length_mm": NaN}"#, 400, "malformed_request"),
        (r#"{"focal_length_mm": 1e999}"#, 400, "malformed_request"),
        ("[25]", 422, "invalid_field"),
    ] {
        let mut parts = parts(&[near.clone(), far.clone()], &[]);
        parts.push(("optics", text.into()));
        let problem = summary(&app, &parts).await.expect_problem(status, code);
        assert_eq!(pointers(&problem), ["/optics"], "{text}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_optics_that_cannot_be_is_refused_with_its_fields() {
    let app = App::start().await;
    let pictures = pair(Relief::Slant, 4);
    let table = [
        (json!({"near_plane_mm": 26.2}), vec!["near_focus_mm", "near_plane_mm"]),
        (json!({"aperture_mm": 9}), vec!["aperture_mm", "f_number"]),
        (json!({"near_focus_mm": null}), vec!["near_plane_mm"]),
        (json!({"f_number": null}), vec!["aperture_mm"]),
        (json!({"f_number": -2.8, "pixel_pitch_um": -29}), vec!["f_number", "pixel_pitch_um"]),
        (json!({"plane_separation_mm": "0.37"}), vec!["plane_separation_mm"]),
        (json!({"telecentric": "yes"}), vec!["telecentric"]),
        (json!({"principal_point_px": [1]}), vec!["principal_point_px"]),
        // Sensors within the focal length: the far-focused one, and both.
        (json!({"plane_separation_mm": 1.5}), vec!["near_focus_mm", "plane_separation_mm"]),
        (json!({"near_focus_mm": null, "near_plane_mm": 24}), vec!["near_plane_mm", "plane_separation_mm"]),
    ];
    for (change, fields) in table {
        let mut wrong = optics();
        wrong.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        let problem = summary(&app, &parts(&pictures, &[("optics", wrong)])).await;
        let problem = problem.expect_problem(422, "invalid_field");
        let expected: Vec<String> = fields.iter().map(|field| format!("/optics/{field}")).collect();
        assert_eq!(pointers(&problem), expected, "{change}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn two_pictures_that_are_no_pair_are_refused() {
    let app = App::start().await;
    let [near, far] = pair(Relief::Slant, 5);
    let small = |side: usize, seed: u8| Bytes::from(png_gray8(side, side, &vec![seed; side * side]));
    let table = [
        ([near.clone(), near.clone()], 422, "identical_images"),
        ([near.clone(), small(96, 1)], 422, "image_size_mismatch"),
        ([small(1, 1), small(1, 2)], 422, "image_too_small"),
        ([small(8, 1), small(8, 2)], 422, "image_too_small"),
        ([near.clone(), far.slice(..far.len() / 2)], 400, "corrupt_image"),
        ([Bytes::from_static(b"GIF89a"), far.clone()], 415, "unsupported_image_format"),
        ([near.clone(), Bytes::new()], 400, "empty_image"),
    ];
    for (pictures, status, code) in table {
        let answer = summary(&app, &parts(&pictures, &[("optics", optics())])).await;
        let problem = answer.expect_problem(status, code);
        if status != 422 {
            let at = if code == "unsupported_image_format" { "/near" } else { "/far" };
            assert_eq!(pointers(&problem), [at], "{problem:#}");
        }
    }
    // The same pixels in another file are the same picture too.
    let frame = decode(&near, &DecodeLimits::default()).unwrap();
    let mut pgm = format!("P5 {} {} 255\n", frame.width(), frame.height()).into_bytes();
    pgm.extend(frame.luminance.to_gray8());
    let answer = summary(&app, &parts(&[near, pgm.into()], &[("optics", optics())])).await;
    answer.expect_problem(422, "identical_images");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_black_pair_has_no_depth_and_says_so() {
    let app = App::start().await;
    let (width, height) = SIZE_PX;
    let mut levels = vec![0; width * height];
    let near = Bytes::from(png_gray8(width, height, &levels));
    levels[width * height / 2 + width / 2] = 1;
    let pictures = [near, Bytes::from(png_gray8(width, height, &levels))];
    for method in ["gram", "stm"] {
        let parts = parts(&pictures, &[("optics", optics()), ("options", json!({"method": method}))]);
        let told = summary(&app, &parts).await.expect(200);
        assert_eq!((&told["coverage"], &told["depth_mm"]), (&json!(0.0), &Value::Null), "{told:#}");
        assert!(told["warnings"].as_array().unwrap().contains(&json!("low_coverage")), "{told:#}");
        assert!(told["gain"].as_f64().is_some_and(f64::is_finite), "{told:#}");
        for accept in ["image/png", "application/x-npy", "model/ply", "image/png; preview=turbo"] {
            let file = ask(&app, "", accept, &parts).await;
            assert_eq!((file.status, file.header("x-coverage")), (200, "0"));
            assert!(file.header("x-warnings").contains("low_coverage"), "{file:?}");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_papers_method_needs_a_calibration() {
    let app = App::start().await;
    let options = json!({"method": "laplacian"});
    let parts = parts(&pair(Relief::Slant, 6), &[("optics", optics()), ("options", options)]);
    let problem = summary(&app, &parts).await.expect_problem(422, "needs_calibration");
    assert!(problem["detail"].as_str().unwrap().contains("/sweep"), "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn colour_is_taken_for_its_luminance() {
    let app = App::start().await;
    let (one, other) = (scene(1), scene(2));
    let told = summary(&app, &parts(&[png(&one), png(&other)], &[("optics", optics())])).await.expect(200);
    assert_eq!(told["width_px"], one.width());
    let mixed = [png(&one), flat_png(90)];
    summary(&app, &parts(&mixed, &[("optics", optics())])).await.expect(200);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_optics_is_judged_before_it_is_built() {
    let app = App::start().await;
    let predict = |body: Value| {
        let app = &app;
        async move { app.post("/v1/optics:predict", body).await }
    };
    let answer = predict(json!({"optics": optics()})).await.expect(200);
    let sigmas = |answer: &Value| -> Vec<Option<f64>> {
        answer["distances"].as_array().unwrap().iter().map(|each| each["sigma_mm"].as_f64()).collect()
    };
    assert_eq!((sigmas(&answer).len(), sigmas(&answer).contains(&None)), (41, false), "{answer:#}");
    assert_eq!(answer["distances"][0]["distance_mm"], json!(529.0));
    assert!(answer["working_range_mm"][0].as_f64().unwrap() < 529.0);
    assert!(answer["advice"].as_array().is_some_and(|lines| !lines.is_empty()));

    let faint = predict(json!({"optics": optics(), "contrast": 8, "noise_sigma": 2})).await.expect(200);
    assert!(sigmas(&faint)[20].is_none_or(|faint| faint > sigmas(&answer)[20].unwrap()), "{faint:#}");

    // A range that these optics don't reach: the answer says which would.
    let wide = predict(json!({"optics": optics(), "range_mm": [400, 1200]})).await.expect(200);
    assert!(sigmas(&wide)[0].is_none() && sigmas(&wide)[40].is_none());
    assert!(wide["advice"][0].as_str().unwrap().contains("focus the near picture at 400 mm"), "{wide:#}");

    for (body, fields) in [
        (json!({}), vec!["/optics"]),
        (json!({"optics": {"focal_length_mm": -1}, "contrast": 500}), vec!["/contrast"]),
        (
            json!({"optics": optics(), "range_mm": [900, 600], "noise_sigma": 0}),
            vec!["/noise_sigma", "/range_mm"],
        ),
        (json!({"optics": optics(), "texture": 1}), vec!["/texture"]),
    ] {
        let problem = predict(body.clone()).await.expect_problem(422, "invalid_field");
        let found = pointers(&problem);
        assert!(fields.iter().all(|field| found.iter().any(|pointer| pointer == field)), "{body}: {found:?}");
    }
}
