//! Placements: where in a frame a known thing lies and how it is turned, several in one frame, and frames without any.

use bytes::Bytes;
use landmarkd_core::imaging::{Frame, Image};
use serde_json::{Value, json};

use crate::app::App;
use crate::pictures::{SIDE_PX, png, scene};

/// Side of a thing's picture: two by two scenes.
const THING_PX: usize = 2 * SIDE_PX;
/// Side of a frame: four by four scenes.
const FRAME_PX: usize = 4 * SIDE_PX;
const THINGS: [(&str, u64); 3] = [("crate", 10), ("shelf", 20), ("door", 30)];

/// So many scenes a side, counted on from a number, as one gray picture.
fn mosaic(first: u64, scenes: usize) -> Image {
    let count = (scenes * scenes) as u64;
    let parts: Vec<Image> = (first..first + count).map(|number| scene(number).luminance).collect();
    Image::from_fn(scenes * SIDE_PX, scenes * SIDE_PX, |x, y| {
        parts[(y / SIDE_PX) * scenes + x / SIDE_PX].at(x % SIDE_PX, y % SIDE_PX)
    })
}

/// A thing, given by its first scene, and where its top left corner lies in a frame; turned by quarters, clockwise.
struct Laid {
    first: u64,
    x_px: usize,
    y_px: usize,
    quarters: usize,
}

/// Things on a ground of scenes that nothing was made of.
fn frame(ground: u64, things: &[Laid]) -> Bytes {
    let mut picture = mosaic(ground, 4);
    for laid in things {
        let thing = mosaic(laid.first, 2);
        for at in 0..THING_PX * THING_PX {
            let (mut x, mut y) = (at % THING_PX, at / THING_PX);
            let value = thing.at(x, y);
            for _ in 0..laid.quarters {
                (x, y) = (THING_PX - 1 - y, x);
            }
            picture.pixels_mut()[(laid.y_px + y) * FRAME_PX + laid.x_px + x] = value;
        }
    }
    png(&Frame::gray(picture))
}

/// The things, trained; the ids of their exemplars.
async fn things(app: &App, options: Value) -> [String; 3] {
    app.put("/v1/databases/yard", json!({"kind": "landmarks", "options": options})).await.expect(201);
    let mut ids = Vec::new();
    for (label, first) in THINGS {
        let path = format!("/v1/databases/yard/exemplars?label={label}");
        let picture = png(&Frame::gray(mosaic(first, 2)));
        let exemplar = app.post_png(&path, picture).await.expect(201);
        ids.push(exemplar["id"].as_str().unwrap().to_owned());
    }
    app.train("yard", json!({})).await;
    ids.try_into().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_in_a_frame_is_named_and_placed_and_nothing_known_says_why() {
    let app = App::start().await;
    let [crate_id, shelf_id, _] = things(&app, json!({})).await;
    let version = app.get("/v1/databases/yard/versions/1").await.expect(200);
    let verdict = &version["report"]["verdict"];
    assert_eq!(verdict["single_picture_labels"], json!(["crate", "door", "shelf"]), "{version:#}");
    assert!(verdict["summary"].as_str().unwrap().starts_with("every label has one picture"), "{verdict}");
    assert!(verdict["remedy"].as_str().unwrap().contains("take a second picture"), "{verdict}");

    let turned = frame(500, &[Laid { first: 20, x_px: 70, y_px: 50, quarters: 1 }]);
    let answer = app.recognise("yard", "", turned).await;
    assert_eq!(answer["decision"]["label"], "shelf", "{answer:#}");
    assert!(number(&answer["evidence"]["log10_false_alarms"]) <= -2.0, "{answer:#}");
    assert!(number(&answer["evidence"]["agreeing"]) <= number(&answer["evidence"]["asked"]), "{answer:#}");
    assert_eq!(
        (&answer["also"], &answer["guess"], &answer["reasons"]),
        (&json!([]), &Value::Null, &json!([]))
    );
    let placement = &answer["votes"][0]["placement"];
    assert!((number(&placement["rotation_deg"]) - 90.0).abs() < 3.0, "{placement}");
    assert_eq!(placement["exemplar"], shelf_id);
    // Top left of the exemplar is seen at the top right, and so on round.
    let (near, far) = (69.5, 69.5 + THING_PX as f64);
    let (top, bottom) = (near - 20.0, far - 20.0);
    let corners = [[far, top], [far, bottom], [near, bottom], [near, top]];
    for (corner, expected) in placement["outline_px"].as_array().unwrap().iter().zip(corners) {
        let off = (number(&corner[0]) - expected[0]).hypot(number(&corner[1]) - expected[1]);
        assert!(off < 5.0, "{corner} is not {expected:?}");
    }
    let homography = &placement["homography"];
    assert_eq!((homography.as_array().unwrap().len(), number(&homography[2][2])), (3, 1.0), "{placement}");

    let things = [
        Laid { first: 10, x_px: 4, y_px: 6, quarters: 0 },
        Laid { first: 20, x_px: 110, y_px: 108, quarters: 2 },
    ];
    let answer = app.recognise("yard", "", frame(600, &things)).await;
    let ids = answer["instances"].as_array().unwrap().iter();
    let mut seen: Vec<&Value> = ids.map(|instance| &instance["placement"]["exemplar"]).collect();
    seen.sort_unstable_by_key(|id| id.as_str());
    let mut expected = [json!(crate_id), json!(shelf_id)];
    expected.sort_unstable_by_key(|id| id.as_str().map(str::to_owned));
    assert_eq!(seen, expected.iter().collect::<Vec<_>>(), "{answer:#}");

    let strange = app.recognise("yard", "", frame(700, &[])).await;
    assert_eq!((&strange["decision"], &strange["instances"]), (&Value::Null, &json!([])), "{strange:#}");
    for member in ["code", "detail", "remedy"] {
        assert!(strange["reasons"][0][member].is_string(), "{strange:#}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn with_intensity_what_is_in_a_frame_is_named_and_placed_and_nothing_known_is_null() {
    let app = App::start().await;
    let [crate_id, shelf_id, _] = things(&app, json!({"signature": "intensity"})).await;

    let version = app.get("/v1/databases/yard/versions/1").await.expect(200);
    let reliability = &version["report"]["reliability"];
    assert!(number(&reliability["unknown_refused"]) >= 0.95, "{version:#}");
    assert!(number(&reliability["known_named"]) >= 0.4, "{version:#}");
    let threshold = number(&reliability["threshold"]);
    assert!((0.8..=1.0).contains(&threshold), "{threshold}");
    assert!(number(&version["report"]["timings_ms"]["rehearsal"]) > 0.0);

    // A quarter turn clockwise, its centre at (70 + 55.5, 50 + 55.5).
    let turned = frame(500, &[Laid { first: 20, x_px: 70, y_px: 50, quarters: 1 }]);
    let answer = app.recognise("yard", "", turned).await;
    assert_eq!(answer["decision"]["label"], "shelf", "{answer:#}");
    let confidence = number(&answer["decision"]["confidence"]);
    assert!((threshold..=1.0).contains(&confidence), "{answer:#}");
    let placement = &answer["votes"][0]["placement"];
    let [x_px, y_px] = ["x_px", "y_px"].map(|member| number(&placement[member]));
    assert!((x_px - 125.5).abs() < 2.0 && (y_px - 105.5).abs() < 2.0, "{placement}");
    assert!((number(&placement["rotation_deg"]) - 90.0).abs() < 3.0, "{placement}");
    assert!((number(&placement["scale"]) - 1.0).abs() < 0.05, "{placement}");
    assert!(
        placement["inliers"].as_u64().unwrap() >= 8 && number(&placement["agreement"]) > 0.5,
        "{placement}"
    );
    assert_eq!(placement["exemplar"], shelf_id);
    // Top left of the exemplar is seen at the top right, and so on round.
    let (near, far) = (69.5, 69.5 + THING_PX as f64);
    let (top, bottom) = (near - 20.0, far - 20.0);
    let corners = [[far, top], [far, bottom], [near, bottom], [near, top]];
    for (corner, expected) in placement["outline_px"].as_array().unwrap().iter().zip(corners) {
        let off = (number(&corner[0]) - expected[0]).hypot(number(&corner[1]) - expected[1]);
        assert!(off < 5.0, "{corner} is not {expected:?}");
    }
    let instances = answer["instances"].as_array().unwrap();
    assert_eq!((instances.len(), &instances[0]["placement"]), (1, placement), "{answer:#}");
    assert!(number(&answer["timings_ms"]["verification"]) > 0.0);

    let both = frame(
        600,
        &[
            Laid { first: 10, x_px: 4, y_px: 6, quarters: 0 },
            Laid { first: 20, x_px: 110, y_px: 108, quarters: 2 },
        ],
    );
    let answer = app.recognise("yard", "", both).await;
    let mut seen: Vec<(&str, &str)> = answer["instances"]
        .as_array()
        .unwrap()
        .iter()
        .map(|instance| {
            let exemplar = instance["placement"]["exemplar"].as_str().unwrap();
            (instance["label"].as_str().unwrap(), exemplar)
        })
        .collect();
    seen.sort_unstable();
    assert_eq!(seen, [("crate", crate_id.as_str()), ("shelf", shelf_id.as_str())], "{answer:#}");

    let strange = app.recognise("yard", "", frame(700, &[])).await;
    assert_eq!((&strange["decision"], &strange["instances"]), (&Value::Null, &json!([])), "{strange:#}");
    assert!(strange["warnings"].as_array().unwrap().contains(&json!("votes_on_background")), "{strange:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_papers_method_names_and_places_nothing() {
    let app = App::start().await;
    things(&app, json!({"method": "paper", "query_points": 32, "interest_points": 32})).await;
    let answer = app.recognise("yard", "", png(&Frame::gray(mosaic(20, 2)))).await;
    assert_eq!(answer["votes"][0]["label"], "shelf", "{answer:#}");
    assert_eq!(answer["votes"][0]["placement"], Value::Null);
    assert_eq!(answer["instances"], json!([]));
}
