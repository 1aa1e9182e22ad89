//! Segmentations: what stands out from a background is counted and placed, in every form, and every wrong turn is told.

use axum::http::{Method, header};
use bytes::Bytes;
use landmarkd_core::imaging::encode::png_gray8;
use landmarkd_core::imaging::{DecodeLimits, decode, read_header};
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers, request, with_bytes};
use crate::pictures::flat_png;

const PATH: &str = "/v1/segmentations";
const WIDTH_PX: usize = 200;
const HEIGHT_PX: usize = 150;

/// A file of that size with these levels.
fn drawn(width: usize, height: usize, level: impl Fn(f64, f64) -> u8) -> Bytes {
    let levels: Vec<u8> =
        (0..width * height).map(|at| level((at % width) as f64, (at / width) as f64)).collect();
    png_gray8(width, height, &levels).into()
}

/// Whether a disc about (50, 60), or a bar about (140.5, 75) that is turned by 30°, covers a place.
fn is_thing(x: f64, y: f64) -> bool {
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    let (dx, dy) = (x - 140.5, y - 75.0);
    let in_bar = (cos * dx + sin * dy).abs() < 30.0 && (cos * dy - sin * dx).abs() < 6.0;
    (x - 50.0).hypot(y - 60.0) < 20.0 || in_bar
}

/// Both, light on a dark ground.
fn things() -> Bytes {
    drawn(WIDTH_PX, HEIGHT_PX, |x, y| if is_thing(x, y) { 160 } else { 20 })
}

async fn ask(app: &App, query: &str, accept: &str, picture: Bytes) -> Answer {
    let asked = request(Method::POST, &format!("{PATH}{query}")).header(header::ACCEPT, accept);
    app.send(with_bytes(asked, "image/png", picture)).await
}

async fn regions(app: &App, query: &str, picture: Bytes) -> Value {
    ask(app, query, "application/json", picture).await.expect(200)
}

fn without_times(mut body: Value) -> Value {
    body["timings_ms"].take();
    body
}

#[tokio::test(flavor = "multi_thread")]
async fn what_stands_out_is_counted_placed_and_measured() {
    let app = App::start().await;
    let asked = request(Method::POST, PATH).header("x-robot-id", "arm-1");
    let answer = app.send(with_bytes(asked, "image/png", things())).await;
    assert_eq!(answer.header("vary"), "Accept");
    let seen = answer.expect(200);
    assert_eq!((&seen["width_px"], &seen["height_px"]), (&json!(WIDTH_PX), &json!(HEIGHT_PX)));
    assert_eq!((&seen["regions_found"], &seen["warnings"]), (&json!(2), &json!([])), "{seen:#}");
    assert_eq!(seen["header"]["robot_id"], "arm-1");
    let near = |value: &Value, expected: f64, tolerance: f64| {
        assert!((value.as_f64().unwrap() - expected).abs() < tolerance, "{expected}: {seen:#}");
    };
    let [disc, bar] = [0, 1].map(|at| &seen["regions"][at]);
    assert_eq!((&disc["id"], &bar["id"]), (&json!(1), &json!(2)));
    near(&disc["centroid_px"][0], 50.0, 0.3);
    near(&disc["centroid_px"][1], 60.0, 0.3);
    near(&disc["area_px"], 1256.0, 40.0);
    near(&disc["elongation"], 1.0, 0.05);
    assert_eq!(disc["orientation_deg"], Value::Null);
    near(&bar["centroid_px"][0], 140.5, 0.3);
    near(&bar["centroid_px"][1], 75.0, 0.3);
    near(&bar["orientation_deg"], 30.0, 1.0);
    near(&bar["elongation"], 5.0, 0.3);
    for (at, expected) in [30.0, 40.0, 41.0, 41.0].into_iter().enumerate() {
        near(&disc["bbox_px"][at], expected, 2.5);
    }
    assert!([disc, bar].iter().all(|region| region["touches_border"] == false));
    for stage in ["queue", "decode", "segment"] {
        assert!(seen["timings_ms"][stage].as_f64().unwrap() >= 0.0, "{seen:#}");
    }
    let cut = drawn(WIDTH_PX, HEIGHT_PX, |x, y| if x.hypot(y - 75.0) < 25.0 { 160 } else { 20 });
    assert_eq!(regions(&app, "", cut).await["regions"][0]["touches_border"], true);

    let metrics = app.get("/metrics").await;
    let metrics = std::str::from_utf8(&metrics.body).unwrap();
    for (stage, count) in [("queue", 2), ("decode", 2), ("segment", 2), ("encode", 0)] {
        let line = format!("landmarkd_workcell_stage_seconds_count{{stage=\"{stage}\"}} {count}\n");
        assert!(metrics.contains(&line), "{line} {metrics}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_label_image_has_the_id_of_each_pixel_in_sixteen_bits() {
    let app = App::start().await;
    let labels = ask(&app, "", "image/png", things()).await;
    assert_eq!((labels.status, labels.header("content-type")), (200, "image/png"));
    assert_eq!((labels.header("vary"), labels.header("x-warnings")), ("Accept", ""));
    let limits = DecodeLimits::default();
    assert_eq!(read_header(&labels.body, &limits).unwrap().bits, 16);
    let read = decode(&labels.body, &limits).unwrap();
    assert_eq!((read.width(), read.height()), (WIDTH_PX, HEIGHT_PX));
    let id = |x, y| (read.luminance.at(x, y) * 257.0).round() as u64;
    assert_eq!((id(50, 60), id(140, 75), id(0, 0), id(199, 149)), (1, 2, 0, 0));
    let told = regions(&app, "", things()).await;
    let ids = read.luminance.pixels().iter().map(|level| (level * 257.0).round() as u64);
    assert_eq!(told["regions"][1]["area_px"], ids.filter(|id| *id == 2).count());

    let preview = ask(&app, "", "image/png; preview=regions", things()).await;
    assert_eq!((preview.status, preview.header("content-type")), (200, "image/png"));
    assert!(decode(&preview.body, &limits).unwrap().is_colour());
    ask(&app, "", "text/html", things()).await.expect_problem(406, "not_acceptable");
}

#[tokio::test(flavor = "multi_thread")]
async fn options_say_the_same_in_the_query_and_in_a_form() {
    let app = App::start().await;
    let dark = drawn(WIDTH_PX, HEIGHT_PX, |x, y| if is_thing(x, y) { 60 } else { 200 });
    for (query, options) in [
        ("?polarity=dark_on_light", json!({"polarity": "dark_on_light"})),
        ("?polarity=dark_on_light&threshold=otsu", json!({"polarity": "dark_on_light", "threshold": "otsu"})),
        ("?polarity=dark_on_light&threshold=130", json!({"polarity": "dark_on_light", "threshold": 130})),
        (
            "?polarity=dark_on_light&window_px=101&offset=20&min_area_px=50&max_objects=9",
            json!({"polarity": "dark_on_light", "window_px": 101, "offset": 20, "min_area_px": 50, "max_objects": 9}),
        ),
    ] {
        let asked = regions(&app, query, dark.clone()).await;
        assert_eq!(asked["regions_found"], 2, "{query}: {asked:#}");
        let parts = [("options", options.to_string().into()), ("image", dark.clone())];
        let by_form = app.post_bytes(PATH, &form_type(), form::<_, Bytes>(&parts)).await.expect(200);
        assert_eq!(without_times(by_form), without_times(asked), "{query}");
    }
    let parts = form(&[("image", dark)]);
    let by_form = app.post_bytes(&format!("{PATH}?polarity=dark_on_light"), &form_type(), parts).await;
    assert_eq!(by_form.expect(200)["regions_found"], 2, "a form may have its options in the query");
}

#[tokio::test(flavor = "multi_thread")]
async fn darker_and_lighter_things_are_told_apart_and_what_is_left_out_is_counted() {
    let app = App::start().await;
    let disc = |x: f64, y: f64, at: [f64; 2], radius: f64| (x - at[0]).hypot(y - at[1]) < radius;
    let picture = drawn(320, 240, |x, y| {
        let noise = ((x * 37.0 + y * 101.0) % 5.0) as u8;
        let light = disc(x, y, [60.0, 60.0], 25.0);
        // Two discs that touch, a speck, and a line across the picture.
        let pair = disc(x, y, [200.0, 60.0], 20.0) || disc(x, y, [238.5, 60.0], 20.0);
        let is_speck = disc(x, y, [60.0, 200.0], 1.5);
        let is_line = (y - 130.0).abs() < 2.0;
        match (light || is_speck, pair || is_line) {
            (true, _) => 200 + noise,
            (_, true) => 30 + noise,
            _ => 110 + noise,
        }
    });
    let seen = regions(&app, "", picture.clone()).await;
    assert_eq!(seen["regions_found"], 3, "{seen:#}");
    let darker: Vec<&Value> = (0..3).map(|at| &seen["regions"][at]["darker"]).collect();
    assert_eq!(darker, [&json!(false), &json!(true), &json!(true)], "{seen:#}");
    assert!(seen["regions"].as_array().unwrap().iter().all(|region| region["touching"] == false));
    assert_eq!((&seen["left_out"]["lines"], &seen["left_out"]["small"]), (&json!(1), &json!(1)), "{seen:#}");
    let speck = seen["left_out"]["small_areas_px"][0].as_u64().unwrap();
    assert!(
        (5..12).contains(&speck) && seen["left_out"]["least_area_px"].as_u64().unwrap() > speck,
        "{seen:#}"
    );
    assert!(seen["ground"]["part"].as_f64().unwrap() > 0.7 && seen["ground"]["averaged_px"] == 1, "{seen:#}");
    assert!(seen["warnings"].as_array().unwrap().contains(&json!("line_left_out")), "{seen:#}");
    let light = regions(&app, "?polarity=light_on_dark", picture.clone()).await;
    assert_eq!(light["regions_found"], 1, "{light:#}");
    assert_eq!(regions(&app, "?threshold=otsu", picture).await["ground"], Value::Null);
}

#[tokio::test(flavor = "multi_thread")]
async fn parts_that_may_be_two_come_with_both_readings() {
    let app = App::start().await;
    // Two discs so close together that their neck is nearly as broad as they are.
    let picture = drawn(240, 160, |x, y| {
        let disc = |at: f64| (x - at).hypot(y - 80.0) < 30.0;
        if disc(95.0) || disc(143.0) { 200 } else { 40 }
    });
    let seen = regions(&app, "", picture).await;
    assert_eq!((&seen["regions_found"], &seen["warnings"]), (&json!(1), &json!(["touching"])), "{seen:#}");
    let region = &seen["regions"][0];
    assert_eq!(region["touching"], true);
    let mut middles: Vec<f64> =
        (0..2).map(|at| region["pieces"][at]["centroid_px"][0].as_f64().unwrap()).collect();
    middles.sort_by(f64::total_cmp);
    assert!((middles[0] - 94.0).abs() < 3.0 && (middles[1] - 144.0).abs() < 3.0, "{region:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn nothing_and_too_much_are_answers_with_a_warning() {
    let app = App::start().await;
    for level in [0, 128, 255] {
        let empty = regions(&app, "", flat_png(level)).await;
        assert_eq!((&empty["regions"], &empty["regions_found"]), (&json!([]), &json!(0)), "{level}");
        assert_eq!(empty["warnings"], json!(["no_region"]));
    }
    let labels = ask(&app, "", "image/png", flat_png(0)).await;
    assert_eq!(labels.header("x-warnings"), "no_region");
    let read = decode(&labels.body, &DecodeLimits::default()).unwrap();
    assert!(read.luminance.pixels().iter().all(|level| *level == 0.0));

    let one = regions(&app, "?max_objects=1", things()).await;
    assert_eq!((one["regions"].as_array().unwrap().len(), &one["regions_found"]), (1, &json!(2)));
    assert_eq!(one["warnings"], json!(["more_regions"]));
    // Ten thousand specks.
    let specks = drawn(500, 500, |x, y| if x % 5.0 == 2.0 && y % 5.0 == 2.0 { 255 } else { 0 });
    let none = regions(&app, "?threshold=100", specks.clone()).await;
    assert_eq!(none["warnings"], json!(["no_region"]), "specks are not objects");
    let most = regions(&app, "?threshold=100&min_area_px=1&max_objects=1000", specks.clone()).await;
    assert_eq!((most["regions"].as_array().unwrap().len(), &most["regions_found"]), (1000, &json!(10_000)));
    let drawn =
        ask(&app, "?threshold=100&min_area_px=1&max_objects=1000", "image/png;preview=regions", specks).await;
    assert_eq!((drawn.status, drawn.header("x-warnings")), (200, "more_regions"));
}

#[tokio::test(flavor = "multi_thread")]
async fn every_wrong_option_and_part_is_named_at_once() {
    let app = App::start().await;
    let query =
        "?threshold=best&window_px=2&offset=-1&polarity=up&min_area_px=0&max_objects=1001&colour=1&colour=2";
    let problem = ask(&app, query, "*/*", things()).await.expect_problem(422, "invalid_field");
    let wrong = [
        "#colour",
        "#colour",
        "#max_objects",
        "#min_area_px",
        "#offset",
        "#polarity",
        "#threshold",
        "#window_px",
    ];
    assert_eq!(pointers(&problem), wrong);

    let options = json!({"threshold": 300, "polarity": 1, "windows": 3}).to_string();
    let parts = form(&[("options", options.as_bytes()), ("photo", b"x")]);
    let problem = app.post_bytes(PATH, &form_type(), parts).await.expect_problem(422, "invalid_field");
    let wrong = ["/image", "/options/polarity", "/options/threshold", "/options/windows", "/photo"];
    assert_eq!(pointers(&problem), wrong);
    let parts = form(&[("options", b"{}".as_slice()), ("image", &things())]);
    let problem = app.post_bytes(&format!("{PATH}?offset=3"), &form_type(), parts).await;
    assert_eq!(pointers(&problem.expect_problem(422, "invalid_field")), ["/options"]);
    for (options, status, code) in [("[]", 422, "invalid_field"), ("{", 400, "malformed_request")] {
        let parts = form(&[("options", options.as_bytes()), ("image", &things())]);
        app.post_bytes(PATH, &form_type(), parts).await.expect_problem(status, code);
    }
    let problem = app.post_bytes(PATH, &form_type(), form(&[("image", b"no picture")])).await;
    assert_eq!(pointers(&problem.expect_problem(415, "unsupported_image_format")), ["/image"]);
    app.post_png(PATH, things().slice(..60)).await.expect_problem(400, "corrupt_image");
    app.post(PATH, json!({})).await.expect_problem(415, "unsupported_media_type");
    app.post_png(PATH, Bytes::new()).await.expect_problem(400, "empty_image");
}
