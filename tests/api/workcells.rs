//! Workcells: a table is described, inspected and centred on; parts are found, named and located, and every wrong turn
//! is told.

use axum::http::{Method, header};
use bytes::Bytes;
use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::depth::scene::{Relief, Rendered};
use landmarkd_core::imaging::encode::{png_gray8, png_gray16};
use landmarkd_core::imaging::{DecodeLimits, Frame, Image, decode};
use serde_json::{Value, json};

use crate::app::{Answer, App, form, form_type, pointers, request, tar, with_bytes};
use crate::depth_pictures::{SIZE_PX, optics, pair, photograph};
use crate::pictures::{THING_PX, Thing, flat_png, png, scene_png, thing};

const BENCH: &str = "/v1/workcells/bench";
const PARTS: &str = "/v1/databases/parts";
const RIG: &str = "/v1/calibrations/rig";
const TABLE_PX: (usize, usize) = (320, 240);

/// X = x / 2 + 100, Y = 300 − y / 2.
fn robot_mm([x, y]: [f64; 2]) -> [f64; 2] {
    [x / 2.0 + 100.0, 300.0 - y / 2.0]
}

fn correspondences(places: &[[f64; 2]]) -> Value {
    places.iter().map(|&at| json!({"image_px": at, "robot_mm": robot_mm(at)})).collect()
}

const CORNERS: [[f64; 2]; 4] = [[10.0, 10.0], [310.0, 12.0], [8.0, 230.0], [305.0, 225.0]];

fn bench() -> Value {
    json!({"database": "parts", "correspondences": correspondences(&CORNERS)})
}

fn bench_with(members: Value) -> Value {
    let mut body = bench();
    body.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    body
}

/// A thing whose outline has two arms of different length.
fn hook(turn_deg: f64) -> Frame {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let half = THING_PX as f64 / 2.0;
    Frame::gray(Image::from_fn(THING_PX, THING_PX, |x, y| {
        let (dx, dy) = ((x as f64 + 0.5) / half - 1.0, (y as f64 + 0.5) / half - 1.0);
        let (u, v) = (cos * dx + sin * dy, cos * dy - sin * dx);
        let long = (0.7 - u.abs()).min(0.15 - (v - 0.4).abs());
        let short = (0.15 - (u - 0.55).abs()).min(0.45 - (v - 0.1).abs());
        (190.0 * (0.5 + long.max(short) * half).clamp(0.0, 1.0)) as f32
    }))
}

fn part(label: &str, turn_deg: f64) -> Frame {
    match label {
        "bar" => thing(Thing::Bar, turn_deg, THING_PX),
        "wedge" => thing(Thing::Wedge, turn_deg, THING_PX),
        _ => hook(turn_deg),
    }
}

/// A dark table with things on it; a thing lies with the middle of its picture at its place.
fn table(things: &[(Frame, [usize; 2])]) -> Bytes {
    let (width, height) = TABLE_PX;
    let ground = |x: usize, y: usize| 14.0 + ((x * 37 + y * 101) % 5) as f32;
    let mut image = Image::from_fn(width, height, ground);
    for (frame, [middle_x, middle_y]) in things {
        for (y, x) in (0..frame.height()).flat_map(|y| (0..frame.width()).map(move |x| (y, x))) {
            let at = (middle_x + x).checked_sub(frame.width() / 2).filter(|at| *at < width);
            let row = (middle_y + y).checked_sub(frame.height() / 2).filter(|row| *row < height);
            if let (Some(at), Some(row)) = (at, row) {
                let pixel = &mut image.pixels_mut()[row * width + at];
                *pixel = pixel.max(frame.luminance.at(x, y));
            }
        }
    }
    png(&Frame::gray(image))
}

/// A database of three parts, trained with `segment` or without.
async fn train(app: &App, segment: bool) {
    let options = json!({"segment": segment, "dimension": 12});
    app.put(PARTS, json!({"kind": "objects", "options": options})).await;
    let views = ["bar", "wedge", "hook"].into_iter().flat_map(|label| {
        (0..24).map(move |n| {
            let turn_deg = 15.0 * f64::from(n);
            (format!("{label}/view__{turn_deg}.png"), png(&part(label, turn_deg)))
        })
    });
    let archive = tar(&views.collect::<Vec<_>>()).await;
    app.post_bytes(&format!("{PARTS}/exemplars:batch"), "application/x-tar", archive).await.expect(200);
    app.train("parts", json!({"options": options})).await;
}

/// A workcell with a trained database.
async fn trained() -> App {
    let app = App::start().await;
    train(&app, true).await;
    app.put(BENCH, bench()).await.expect(201);
    app
}

/// A workcell whose database has no version.
async fn untrained() -> App {
    let app = App::start().await;
    app.put(PARTS, json!({"kind": "objects"})).await.expect(201);
    app.put(BENCH, bench()).await.expect(201);
    app
}

type Parts = Vec<(&'static str, Bytes)>;

async fn inspect(app: &App, query: &str, parts: &[(&str, Bytes)]) -> Answer {
    app.post_bytes(&format!("{BENCH}/inspections{query}"), &form_type(), form(parts)).await
}

async fn inspected(app: &App, query: &str, overview: Bytes) -> Value {
    inspect(app, query, &[("overview", overview)]).await.expect(200)
}

/// The part whose centroid lies within some pixels of a place.
#[track_caller]
fn at(answer: &Value, place: [usize; 2]) -> &Value {
    let objects = answer["objects"].as_array().unwrap();
    let found = objects.iter().find(|object| {
        let centroid = &object["region"]["centroid_px"];
        [0, 1].iter().all(|&i| (centroid[i].as_f64().unwrap() - place[i] as f64).abs() < 8.0)
    });
    found.unwrap_or_else(|| panic!("nothing at {place:?}: {answer:#}"))
}

fn has(warnings: &Value, word: &str) -> bool {
    warnings.as_array().unwrap().contains(&json!(word))
}

#[tokio::test(flavor = "multi_thread")]
async fn a_workcell_is_described_replaced_listed_and_deleted() {
    let app = App::start().await;
    app.put(PARTS, json!({"kind": "objects"})).await.expect(201);
    let made = app.put(BENCH, bench()).await.expect(201);
    assert_eq!(
        (&made["name"], &made["database"], &made["calibration"]),
        (&json!("bench"), &json!("parts"), &Value::Null)
    );
    assert_eq!(
        (&made["flip_y"], &made["tolerance_px"], &made["local"]),
        (&json!(true), &json!(1.0), &Value::Null)
    );
    assert_eq!((&made["correspondences"], &made["warnings"]), (&bench()["correspondences"], &json!([])));
    let segmentation = json!({
        "threshold": "adaptive", "window_px": null, "offset": null, "polarity": "either",
        "min_area_px": null, "max_objects": 100,
    });
    assert_eq!(made["segmentation"], segmentation);
    // An exact similarity foretells its points as well as an affine map does, and is simpler.
    assert_eq!(made["mapping"]["kind"], "similarity");
    assert!(made["mapping"]["residual_mm"].as_f64().unwrap() < 1e-6, "{made:#}");
    let expected = [[0.5, 0.0, 100.0], [0.0, -0.5, 300.0], [0.0, 0.0, 1.0]];
    for (row, expected) in made["mapping"]["matrix"].as_array().unwrap().iter().zip(expected) {
        for (value, expected) in row.as_array().unwrap().iter().zip(expected) {
            assert!((value.as_f64().unwrap() - expected).abs() < 1e-6, "{made:#}");
        }
    }
    assert_eq!(app.get(BENCH).await.expect(200), made);

    app.put(RIG, optics()).await.expect(201);
    let other = bench_with(json!({
        "calibration": "rig", "mapping": "homography", "local": {"mm_per_px": 0.25, "rotation_deg": 90},
        "tolerance_px": 2.5, "segmentation": {"threshold": 80, "polarity": "dark_on_light", "max_objects": 5},
    }));
    let replaced = app.put(BENCH, other).await.expect(200);
    assert_eq!(
        (&replaced["calibration"], &replaced["mapping"]["kind"]),
        (&json!("rig"), &json!("homography"))
    );
    assert_eq!(replaced["local"], json!({"mm_per_px": 0.25, "rotation_deg": 90.0}));
    assert_eq!(
        (&replaced["segmentation"]["threshold"], &replaced["tolerance_px"]),
        (&json!(80.0), &json!(2.5))
    );
    assert_eq!(replaced["created_at"], made["created_at"]);
    let told = app.get(BENCH).await.expect(200);
    assert_eq!(told, replaced);
    // What is told can be sent back.
    let back = json!({
        "database": told["database"], "calibration": told["calibration"], "correspondences": told["correspondences"],
        "mapping": told["mapping"]["kind"], "flip_y": told["flip_y"], "local": told["local"],
        "tolerance_px": told["tolerance_px"], "segmentation": told["segmentation"],
    });
    let mut again = app.put(BENCH, back).await.expect(200);
    again["updated_at"] = told["updated_at"].clone();
    assert_eq!(again, told);
    let least = app.put(BENCH, bench()).await.expect(200);
    assert_eq!(
        (&least["calibration"], &least["local"]),
        (&Value::Null, &Value::Null),
        "a PUT replaces the whole"
    );

    app.put("/v1/workcells/attic", bench()).await.expect(201);
    let page = app.get("/v1/workcells?limit=1").await.expect(200);
    assert_eq!((&page["items"][0]["name"], &page["next_cursor"]), (&json!("attic"), &json!("attic")));
    let page = app.get("/v1/workcells?limit=1&cursor=attic").await.expect(200);
    assert_eq!(page["items"], json!([least]));

    app.delete(BENCH).await.expect(204);
    for answer in [
        app.delete(BENCH).await,
        app.get(BENCH).await,
        inspect(&app, "", &[("overview", flat_png(0))]).await,
        app.post_png(&format!("{BENCH}/centrings"), flat_png(0)).await,
    ] {
        answer.expect_problem(404, "unknown_workcell");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn two_places_make_a_similarity_and_a_wrong_hand_is_told() {
    let app = App::start().await;
    app.put(PARTS, json!({"kind": "objects"})).await.expect(201);
    let two = app.put(BENCH, bench_with(json!({"correspondences": correspondences(&CORNERS[..2])}))).await;
    let two = two.expect(201);
    assert_eq!((&two["mapping"]["kind"], &two["warnings"]), (&json!("similarity"), &json!([])));
    let wrong = json!({"mapping": "similarity", "flip_y": false});
    let mirrored = app.put(BENCH, bench_with(wrong)).await.expect(200);
    assert_eq!(mirrored["warnings"], json!(["mirrored"]), "{mirrored:#}");
    assert!(mirrored["mapping"]["residual_mm"].as_f64().unwrap() > 10.0);
}

#[tokio::test(flavor = "multi_thread")]
async fn every_point_has_its_residual_and_two_that_are_exchanged_are_named() {
    let app = App::start().await;
    app.put(PARTS, json!({"kind": "objects"})).await.expect(201);
    let places = [[20.0, 30.0], [600.0, 25.0], [610.0, 450.0], [15.0, 440.0], [310.0, 200.0], [150.0, 330.0]];
    let right = correspondences(&places);
    let told = app.put(BENCH, bench_with(json!({"correspondences": right}))).await.expect(201);
    assert_eq!((&told["warnings"], &told["mapping"]["suspects"]), (&json!([]), &json!([])), "{told:#}");
    let left_out = &told["mapping"]["leave_one_out_mm"];
    for kind in ["similarity", "affine", "homography"] {
        assert!(left_out[kind].as_f64().unwrap() < 1e-6, "{told:#}");
    }
    let mut wrong = right.clone();
    wrong[1]["robot_mm"] = right[4]["robot_mm"].clone();
    wrong[4]["robot_mm"] = right[1]["robot_mm"].clone();
    let body = bench_with(json!({"correspondences": wrong, "mapping": "affine"}));
    let told = app.put(BENCH, body).await.expect(200);
    assert_eq!(told["warnings"], json!(["exchanged"]), "{told:#}");
    assert_eq!(told["mapping"]["suspects"], json!([1, 4]));
    let off_mm = told["mapping"]["residuals_mm"].as_array().unwrap();
    assert_eq!(off_mm.len(), places.len());
    let most = off_mm.iter().map(|mm| mm.as_f64().unwrap()).fold(0.0, f64::max);
    assert!(most > 50.0, "{told:#}");
    let mut mistyped = right.clone();
    mistyped[2]["robot_mm"][0] = json!(900.0);
    let body = bench_with(json!({"correspondences": mistyped, "mapping": "affine"}));
    let told = app.put(BENCH, body).await.expect(200);
    assert_eq!(
        (&told["warnings"], &told["mapping"]["suspects"]),
        (&json!(["outlying"]), &json!([2])),
        "{told:#}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn what_makes_no_workcell_is_named_all_at_once() {
    let app = App::start().await;
    app.put(BENCH, bench()).await.expect_problem(404, "unknown_database");
    app.put(PARTS, json!({"kind": "objects"})).await.expect(201);
    app.put("/v1/databases/places", json!({"kind": "landmarks"})).await.expect(201);
    let places = app.put(BENCH, bench_with(json!({"database": "places"}))).await;
    let problem = places.expect_problem(409, "kind_conflict");
    assert!(problem["detail"].as_str().unwrap().contains("objects"), "{problem:#}");
    let rig = app.put(BENCH, bench_with(json!({"calibration": "rig"}))).await;
    rig.expect_problem(404, "unknown_calibration");

    let equal_px = [CORNERS[0], CORNERS[1], CORNERS[2], CORNERS[1]];
    let mut equal_mm = correspondences(&CORNERS);
    equal_mm[2]["robot_mm"] = equal_mm[0]["robot_mm"].clone();
    let line: Vec<[f64; 2]> = (0..5).map(|n| [20.0 * f64::from(n), 10.0 + 30.0 * f64::from(n)]).collect();
    let mut huge = correspondences(&CORNERS);
    huge[1]["image_px"] = json!([1e300, 0]);
    let mut short = correspondences(&CORNERS);
    short[2]["robot_mm"] = json!([1]);
    let mut lacking = correspondences(&CORNERS);
    lacking[3].as_object_mut().unwrap().remove("image_px");
    let many: Vec<[f64; 2]> = (0..1001).map(|n| [f64::from(n % 40), f64::from(n / 40)]).collect();
    let all_wrong = json!({
        "database": "no name", "correspondences": 5, "mapping": "spline", "flip_y": "yes", "tolerance_px": -1,
        "local": {"mm_per_px": 0}, "segmentation": {"window_px": 1, "polarity": "up"}, "lens": 1,
    });
    let table: [(Value, &[&str]); 16] = [
        (json!({"correspondences": correspondences(&equal_px)}), &["/correspondences/3/image_px"]),
        (json!({"correspondences": equal_mm}), &["/correspondences/2/robot_mm"]),
        (json!({"correspondences": correspondences(&line)}), &["/correspondences"]),
        (json!({"correspondences": correspondences(&line), "mapping": "homography"}), &["/correspondences"]),
        (
            json!({"correspondences": correspondences(&CORNERS[..3]), "mapping": "homography"}),
            &["/correspondences"],
        ),
        (
            json!({"correspondences": correspondences(&CORNERS[..2]), "mapping": "affine"}),
            &["/correspondences"],
        ),
        (json!({"correspondences": []}), &["/correspondences"]),
        (json!({"correspondences": huge}), &["/correspondences/1"]),
        (json!({"correspondences": short}), &["/correspondences/2/robot_mm"]),
        (json!({"correspondences": lacking}), &["/correspondences/3"]),
        (json!({"correspondences": correspondences(&many)}), &["/correspondences"]),
        (json!({"local": {}}), &["/local"]),
        (
            json!({"local": {"mm_per_px": -1, "rotation_deg": 361}}),
            &["/local/mm_per_px", "/local/rotation_deg"],
        ),
        (
            json!({"segmentation": {"offset": 256, "colour": 1}}),
            &["/segmentation/colour", "/segmentation/offset"],
        ),
        (json!({"database": null, "correspondences": null}), &["/correspondences", "/database"]),
        (
            all_wrong,
            &[
                "/correspondences",
                "/database",
                "/flip_y",
                "/lens",
                "/local/mm_per_px",
                "/mapping",
                "/segmentation/polarity",
                "/segmentation/window_px",
                "/tolerance_px",
            ],
        ),
    ];
    for (members, expected) in table {
        let problem = app.put(BENCH, bench_with(members.clone())).await;
        let problem = problem.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), expected, "{members}: {problem:#}");
    }
    let mut folded = correspondences(&CORNERS);
    let exchanged = folded[0]["robot_mm"].clone();
    folded[0]["robot_mm"] = folded[1]["robot_mm"].take();
    folded[1]["robot_mm"] = exchanged;
    let folded = bench_with(json!({"mapping": "homography", "correspondences": folded}));
    let problem = app.put(BENCH, folded).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/correspondences"]);
    app.put("/v1/workcells/-bench", bench()).await.expect_problem(422, "invalid_field");
    app.get(BENCH).await.expect_problem(404, "unknown_workcell");
}

#[tokio::test(flavor = "multi_thread")]
async fn parts_are_found_named_turned_and_located_and_unknown_ones_answered_as_such() {
    let app = trained().await;
    let ring = thing(Thing::Ring, 0.0, THING_PX);
    let overview = table(&[
        (part("bar", 100.0), [70, 60]),
        (part("wedge", 218.0), [230, 70]),
        (part("hook", 40.0), [90, 180]),
        (ring, [240, 180]),
    ]);
    let asked = request(Method::POST, &format!("{BENCH}/inspections")).header("x-frame-id", "overview-7");
    let answer = app.send(with_bytes(asked, &form_type(), form(&[("overview", &overview)]))).await;
    assert_eq!(answer.header("vary"), "Accept");
    let seen = answer.expect(200);
    assert_eq!(
        (&seen["workcell"], &seen["database"], &seen["version"]),
        (&json!("bench"), &json!("parts"), &json!(1))
    );
    assert_eq!((&seen["calibration"], &seen["header"]["frame_id"]), (&Value::Null, &json!("overview-7")));
    assert_eq!((&seen["width_px"], &seen["height_px"]), (&json!(TABLE_PX.0), &json!(TABLE_PX.1)));
    assert_eq!((&seen["regions_found"], &seen["warnings"]), (&json!(4), &json!([])), "{seen:#}");
    for (label, turn_deg, place) in
        [("bar", 100.0, [70, 60]), ("wedge", 218.0, [230, 70]), ("hook", 40.0, [90, 180])]
    {
        let found = at(&seen, place);
        assert_eq!(found["decision"]["label"], label, "{found:#}");
        let pose = &found["pose"];
        assert!(
            angular_distance_deg(pose["turn_deg"].as_f64().unwrap(), turn_deg) < 6.0,
            "{label}: {found:#}"
        );
        let centroid = [0, 1].map(|i| found["region"]["centroid_px"][i].as_f64().unwrap());
        let expected = robot_mm(centroid);
        for i in [0, 1] {
            assert!((found["robot_mm"][i].as_f64().unwrap() - expected[i]).abs() < 1e-6, "{found:#}");
        }
        assert_eq!((&found["distance_mm"], &found["distance_coverage"]), (&Value::Null, &Value::Null));
        assert!(!has(&found["warnings"], "touches_border") && !has(&found["warnings"], "no_depth"));
    }
    let bar = at(&seen, [70, 60]);
    let reach = robot_mm([69.5, 59.5]);
    for i in [0, 1] {
        assert!((bar["robot_mm"][i].as_f64().unwrap() - reach[i]).abs() < 0.5, "{bar:#}");
    }
    // Turned by 100° from x towards y; Y grows where y falls.
    assert!(angular_distance_deg(2.0 * bar["robot_deg"].as_f64().unwrap(), -200.0) < 4.0, "{bar:#}");
    let unknown = at(&seen, [240, 180]);
    assert_eq!((&unknown["decision"], &unknown["pose"]), (&Value::Null, &Value::Null), "{unknown:#}");
    assert!(has(&unknown["warnings"], "beyond_threshold"), "{unknown:#}");
    assert!(!unknown["candidates"].as_array().unwrap().is_empty(), "{unknown:#}");
    let times = &seen["timings_ms"];
    let sum: f64 = ["segment", "cut", "recognise", "design", "depth"]
        .map(|stage| times[stage].as_f64().unwrap())
        .iter()
        .sum();
    assert!((times["total"].as_f64().unwrap() - sum).abs() < 1e-9 && times["design"] == 0.0, "{times:#}");

    let metrics = app.get("/metrics").await;
    let metrics = std::str::from_utf8(&metrics.body).unwrap();
    for (stage, count) in
        [("queue", 1), ("decode", 1), ("segment", 1), ("cut", 1), ("recognise", 1), ("depth", 0)]
    {
        let line = format!("landmarkd_workcell_stage_seconds_count{{stage=\"{stage}\"}} {count}\n");
        assert!(metrics.contains(&line), "{line} {metrics}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_part_that_the_picture_cuts_says_so_and_an_empty_table_is_an_answer() {
    let app = trained().await;
    let cut =
        inspected(&app, "", table(&[(part("bar", 0.0), [8, 120]), (part("bar", 0.0), [160, 120])])).await;
    let warned: Vec<bool> = cut["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|object| has(&object["warnings"], "touches_border"))
        .collect();
    assert_eq!(warned, [false, true], "{cut:#}");
    let empty = inspected(&app, "", table(&[])).await;
    assert_eq!((&empty["objects"], &empty["warnings"]), (&json!([]), &json!(["no_region"])), "{empty:#}");
    let few = bench_with(json!({"segmentation": {"max_objects": 1}}));
    app.put(BENCH, few).await.expect(200);
    let more =
        inspected(&app, "", table(&[(part("bar", 0.0), [80, 120]), (part("bar", 0.0), [240, 120])])).await;
    assert_eq!((more["objects"].as_array().unwrap().len(), &more["regions_found"]), (1, &json!(2)));
    assert_eq!(more["warnings"], json!(["more_regions"]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_part_beyond_the_horizon_of_a_homography_has_no_place_and_says_so() {
    let app = trained().await;
    // A camera that looks so far aslant that its horizon stands at x = 200.
    let pair = |[x, y]: [f64; 2]| {
        let depth = 1.0 - x / 200.0;
        json!({"image_px": [x, y], "robot_mm": [x / depth, -y / depth]})
    };
    let corners = [[10.0, 10.0], [150.0, 12.0], [8.0, 230.0], [140.0, 225.0]].map(pair);
    app.put(BENCH, bench_with(json!({"mapping": "homography", "correspondences": corners})))
        .await
        .expect(200);
    let seen =
        inspected(&app, "", table(&[(part("bar", 0.0), [80, 120]), (part("bar", 0.0), [260, 120])])).await;
    for object in seen["objects"].as_array().unwrap() {
        let is_beyond = object["region"]["centroid_px"][0].as_f64().unwrap() > 200.0;
        assert_eq!(object["robot_mm"].is_null(), is_beyond, "{object:#}");
        assert_eq!(has(&object["warnings"], "beyond_horizon"), is_beyond, "{object:#}");
    }
    assert_eq!(seen["objects"].as_array().unwrap().len(), 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_alias_or_a_number_says_which_version_answers() {
    let app = trained().await;
    train(&app, false).await;
    let overview = table(&[(part("bar", 30.0), [160, 120])]);
    for (query, version, is_segmented) in [
        ("", 2, false),
        ("?version=1", 1, true),
        ("?alias=current", 2, false),
        ("?alias=current&version=1", 0, false),
    ] {
        let answer = inspect(&app, query, &[("overview", overview.clone())]).await;
        if version == 0 {
            assert_eq!(pointers(&answer.expect_problem(422, "invalid_field")), ["#version"]);
            continue;
        }
        let seen = answer.expect(200);
        assert_eq!(seen["version"], version, "{query}");
        assert_eq!(has(&seen["warnings"], "not_segmented"), !is_segmented, "{query}: {seen:#}");
    }
    inspect(&app, "?alias=none", &[("overview", overview.clone())])
        .await
        .expect_problem(404, "unknown_alias");
    inspect(&app, "?version=7", &[("overview", overview.clone())])
        .await
        .expect_problem(404, "unknown_version");

    let asked =
        request(Method::POST, &format!("{BENCH}/inspections?version=1")).header(header::ACCEPT, "image/png");
    let drawn = app.send(with_bytes(asked, &form_type(), form(&[("overview", overview)]))).await;
    assert_eq!(
        (drawn.status, drawn.header("content-type"), drawn.header("x-version")),
        (200, "image/png", "1")
    );
    assert_eq!((drawn.header("x-digest").len(), drawn.header("vary")), (64, "Accept"));
    let drawn = decode(&drawn.body, &DecodeLimits::default()).unwrap();
    assert!(drawn.is_colour() && drawn.width().is_multiple_of(TABLE_PX.0));
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_inspected_is_told() {
    let app = untrained().await;
    let overview = || ("overview", table(&[]));
    inspect(&app, "", &[overview()]).await.expect_problem(409, "not_trained");
    train(&app, true).await;
    let [near, far] = pair(Relief::Plane { share: 0.5 }, 1);
    let (near, far) = (("near", near), ("far", far));
    let table: [(&str, Parts, &[&str]); 9] = [
        ("", vec![near.clone(), far.clone()], &["/near", "/overview"]),
        ("", vec![overview(), near.clone(), far.clone()], &["/near"]),
        ("", vec![overview(), near.clone()], &["/far", "/near"]),
        ("", vec![overview(), ("left", far.1.clone())], &["/left"]),
        ("?pair_view=local", vec![overview()], &["#pair_view"]),
        ("?region=1", vec![overview()], &["#region"]),
        ("?region=one", vec![overview()], &["#region"]),
        ("?pair_view=both", vec![overview()], &["#pair_view"]),
        ("?top=3", vec![overview()], &["#top"]),
    ];
    for (query, parts, expected) in table {
        let problem = inspect(&app, query, &parts).await.expect_problem(422, "invalid_field");
        assert_eq!(pointers(&problem), expected, "{query}: {problem:#}");
    }
    app.put(RIG, optics()).await.expect(201);
    app.put(BENCH, bench_with(json!({"calibration": "rig"}))).await.expect(200);
    let both = [overview(), near.clone(), far.clone()];
    let problem =
        inspect(&app, "?pair_view=overview&region=1", &both).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["#region"]);
    let problem =
        inspect(&app, "?pair_view=overview", &both).await.expect_problem(422, "image_size_mismatch");
    assert_eq!(pointers(&problem), ["/near"]);
    let problem = inspect(&app, "?region=2", &both).await.expect_problem(422, "no_region");
    assert_eq!(pointers(&problem), ["#region"]);
    let problem = inspect(&app, "", &[overview(), near.clone()]).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/far"]);
    let same = [overview(), near.clone(), ("far", near.1.clone())];
    inspect(&app, "", &same).await.expect_problem(422, "identical_images");
    let problem = inspect(&app, "", &[("overview", Bytes::from_static(b"no picture"))]).await;
    assert_eq!(pointers(&problem.expect_problem(415, "unsupported_image_format")), ["/overview"]);
    app.post_png(&format!("{BENCH}/inspections"), scene_png(1))
        .await
        .expect_problem(415, "unsupported_media_type");

    app.delete(RIG).await.expect(204);
    inspect(&app, "", &both).await.expect_problem(404, "unknown_calibration");
    inspect(&app, "", &both[..1]).await.expect(200);
    app.delete(PARTS).await.expect(204);
    inspect(&app, "", &both[..1]).await.expect_problem(404, "unknown_database");
    app.put(PARTS, json!({"kind": "landmarks"})).await.expect(201);
    inspect(&app, "", &both[..1]).await.expect_problem(409, "not_trained");
}

/// A pair of which all but discs lies in the dark, without a step that would be texture; the far-focused picture is
/// dimmed by a gain.
fn on_discs(seen: &Rendered, discs: &[([f64; 2], f64)], gain: f64) -> [Bytes; 2] {
    let full = f64::from(u16::MAX >> (16 - seen.bits));
    [(&seen.near, 1.0), (&seen.far, gain)].map(|(samples, gain)| {
        let levels = samples.iter().enumerate().map(|(at, sample)| {
            let (x, y) = ((at % seen.width) as f64, (at / seen.width) as f64);
            let inside = discs.iter().map(|([middle_x, middle_y], radius)| {
                ((radius - (x - middle_x).hypot(y - middle_y)) / 6.0).clamp(0.0, 1.0)
            });
            let inside = inside.fold(0.0, f64::max);
            let texture = f64::from(*sample) / full;
            let share = 0.03 + 0.02 * texture + inside * (0.25 + 0.6 * texture);
            (gain * share * f64::from(u16::MAX)).round() as u16
        });
        png_gray16(seen.width, seen.height, &levels.collect::<Vec<u16>>()).into()
    })
}

fn truth_mm(seen: &Rendered, [x, y]: [usize; 2]) -> f64 {
    seen.depth_mm[y * seen.width + x]
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pair_tells_how_far_one_part_is_or_all_of_them() {
    let app = trained().await;
    app.put(RIG, optics()).await.expect(201);
    let setup = json!({"calibration": "rig", "segmentation": {"threshold": 30, "min_area_px": 200}});
    app.put(BENCH, bench_with(setup)).await.expect(200);

    // The local camera's view of one part.
    let seen = photograph(Relief::Plane { share: 0.4 }, 3);
    let middle = [SIZE_PX.0 / 2, SIZE_PX.1 / 2];
    let [near, far] = on_discs(&seen, &[(middle.map(|v| v as f64), 40.0)], 1.0);
    let overview = table(&[(part("bar", 0.0), [150, 110]), (part("wedge", 0.0), [260, 190])]);
    let parts = [("overview", overview.clone()), ("near", near), ("far", far)];
    let answer = inspect(&app, "", &parts).await.expect(200);
    assert_eq!(answer["calibration"], "rig");
    let (bar, wedge) = (at(&answer, [150, 110]), at(&answer, [260, 190]));
    let distance_mm = bar["distance_mm"].as_f64().unwrap_or_else(|| panic!("{answer:#}"));
    assert!((distance_mm - truth_mm(&seen, middle)).abs() < 5.0, "{answer:#}");
    assert!(bar["distance_sigma_mm"].as_f64().unwrap() > 0.0, "{bar:#}");
    assert!((0.2..=1.0).contains(&bar["distance_coverage"].as_f64().unwrap()), "{bar:#}");
    assert_eq!(wedge["distance_mm"], Value::Null, "the part nearest the overview's middle is meant");
    assert!(!has(&wedge["warnings"], "no_depth"), "it was not looked for: {wedge:#}");
    let times = &answer["timings_ms"];
    assert!(times["depth"].as_f64().unwrap() > 0.0 && times["design"].as_f64().unwrap() > 0.0, "{times:#}");

    let id = wedge["region"]["id"].as_u64().unwrap();
    let other = inspect(&app, &format!("?region={id}&pair_view=local"), &parts).await.expect(200);
    assert_eq!(at(&other, [260, 190])["distance_mm"], distance_mm);
    assert_eq!(at(&other, [150, 110])["distance_mm"], Value::Null);
    let problem = inspect(&app, "?region=3", &parts).await.expect_problem(422, "no_region");
    assert_eq!(pointers(&problem), ["#region"]);
    assert!(problem["detail"].as_str().unwrap().contains("1 to 2"), "{problem:#}");

    // Nothing in the pair, of which one picture is darker.
    let [near, far] = on_discs(&seen, &[], 0.8);
    let parts = [("overview", overview), ("near", near), ("far", far)];
    let answer = inspect(&app, "", &parts).await.expect(200);
    assert!(has(&answer["warnings"], "no_region_in_pair"), "{answer:#}");
    assert!(has(&answer["warnings"], "depth_gain_off"), "{answer:#}");
    assert!(answer["objects"].as_array().unwrap().iter().all(|object| object["distance_mm"] == Value::Null));

    // The overview's own geometry: every part has a distance.
    let seen = photograph(Relief::Slant, 5);
    let places = [[36, 48], [94, 48]];
    let [near, far] = on_discs(&seen, &places.map(|place| (place.map(|v| v as f64), 28.0)), 1.0);
    let parts = [("overview", near.clone()), ("near", near), ("far", far)];
    let answer = inspect(&app, "?pair_view=overview", &parts).await.expect(200);
    for place in places {
        let told = at(&answer, place)["distance_mm"].as_f64().unwrap_or_else(|| panic!("{answer:#}"));
        assert!((told - truth_mm(&seen, place)).abs() < 12.0, "{place:?}: {answer:#}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_part_without_texture_has_no_depth_and_says_so() {
    let app = trained().await;
    app.put(RIG, optics()).await.expect(201);
    app.put(BENCH, bench_with(json!({"calibration": "rig", "segmentation": {"threshold": 60}})))
        .await
        .expect(200);
    let smooth = |level: f64| {
        let levels: Vec<u8> = (0..SIZE_PX.0 * SIZE_PX.1)
            .map(|at| {
                let off = ((at % SIZE_PX.0) as f64 - 64.0).hypot((at / SIZE_PX.0) as f64 - 48.0);
                (10.0 + level * (1.0 - off / 60.0).max(0.0)) as u8
            })
            .collect();
        Bytes::from(png_gray8(SIZE_PX.0, SIZE_PX.1, &levels))
    };
    let parts = [
        ("overview", table(&[(part("bar", 0.0), [160, 120])])),
        ("near", smooth(180.0)),
        ("far", smooth(178.0)),
    ];
    let answer = inspect(&app, "", &parts).await.expect(200);
    let bar = at(&answer, [160, 120]);
    assert_eq!((&bar["distance_mm"], &bar["distance_sigma_mm"]), (&Value::Null, &Value::Null), "{answer:#}");
    assert!(has(&bar["warnings"], "no_depth"), "{answer:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_local_camera_is_told_by_how_much_it_is_off() {
    let app = untrained().await;
    let path = format!("{BENCH}/centrings");
    let view = |x: usize, y: usize| table(&[(part("bar", 20.0), [x, y]), (part("bar", 0.0), [40, 40])]);
    let off = app.post_png(&path, view(180, 110)).await.expect(200);
    assert_eq!(off["workcell"], "bench");
    let number = |value: &Value| value.as_f64().unwrap();
    let [x, y] = [0, 1].map(|i| number(&off["move_px"][i]));
    assert!((x - 20.0).abs() < 0.6 && (y + 10.0).abs() < 0.6, "{off:#}");
    assert!((number(&off["distance_px"]) - x.hypot(y)).abs() < 1e-9);
    assert_eq!(
        (&off["centred"], &off["move_mm"]),
        (&json!(false), &Value::Null),
        "the local camera isn't known"
    );
    assert!((number(&off["region"]["centroid_px"][0]) - 179.5).abs() < 0.6, "{off:#}");

    let local = json!({"mm_per_px": 0.25, "rotation_deg": 0});
    app.put(BENCH, bench_with(json!({"local": local, "tolerance_px": 2}))).await.expect(200);
    let parts = form(&[("image", view(180, 110))]);
    let off = app.post_bytes(&path, &form_type(), parts).await.expect(200);
    let [across, along] = [0, 1].map(|i| number(&off["move_mm"][i]));
    assert!((across - 5.0).abs() < 0.2 && (along - 2.5).abs() < 0.2, "Y grows where y falls: {off:#}");
    let there = app.post_png(&path, view(160, 120)).await.expect(200);
    assert_eq!(there["centred"], true, "{there:#}");
    app.post_png(&path, table(&[])).await.expect_problem(422, "no_region");
}
