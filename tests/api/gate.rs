//! The gate before `current`: a training that is to be promoted if it isn't worse is held against the version in use.

use serde_json::{Value, json};

use crate::app::App;
use crate::pictures::{THING_PX, Thing, png, thing};

const IF_NOT_WORSE: &str = "if_not_worse";

async fn current(app: &App, database: &str) -> Value {
    app.get(&format!("/v1/databases/{database}")).await.expect(200)["current_version"].clone()
}

fn count(comparison: &Value, member: &str) -> u64 {
    comparison[member].as_u64().unwrap_or_else(|| panic!("{member} of {comparison:#}"))
}

#[tokio::test(flavor = "multi_thread")]
async fn landmarks_with_a_wrong_label_among_them_are_not_promoted() {
    let app = App::start().await;
    let options = json!({"signature": "intensity", "interest_points": 48, "query_points": 200, "subwindow_radius_px": 9, "dimension": 16});
    app.put("/v1/databases/lab", json!({"kind": "landmarks", "options": options})).await.expect(201);
    for number in 1..=4 {
        app.add("lab", &format!("place-{number}"), number).await;
    }
    let first = app.train("lab", json!({"promote": IF_NOT_WORSE})).await;
    let alone = &first["comparison"];
    assert_eq!((&alone["against_version"], &alone["promoted"]), (&Value::Null, &json!(true)), "{first:#}");
    assert_eq!((count(alone, "trials"), current(&app, "lab").await), (0, json!(1)));

    app.add("lab", "place-2", 1).await;
    let confused = app.train("lab", json!({"promote": IF_NOT_WORSE})).await;
    let worse = &confused["comparison"];
    assert_eq!((&confused["version"], &worse["promoted"]), (&json!(2), &json!(false)), "{confused:#}");
    assert_eq!((&worse["against_version"], count(worse, "trials")), (&json!(1), 160), "{worse:#}");
    assert!(worse["p_value"].as_f64().unwrap() < 0.05, "{worse:#}");
    assert!(count(worse, "current_only") > count(worse, "candidate_only"), "{worse:#}");
    assert_eq!(current(&app, "lab").await, 1);
    app.get("/v1/databases/lab/versions/2").await.expect(200);
    // The comparison stands in the job's last event, too.
    let events = app.get(&format!("/v1/jobs/{}/events", confused["id"].as_str().unwrap())).await;
    let text = String::from_utf8(events.body.to_vec()).unwrap();
    assert!(text.contains(r#""promoted":false"#), "{text}");

    let always = app.train("lab", json!({})).await;
    assert_eq!((&always["version"], &always["comparison"]), (&json!(2), &Value::Null));
    assert_eq!(current(&app, "lab").await, 2);
}

#[tokio::test(flavor = "multi_thread")]
async fn objects_that_are_worse_are_not_promoted_and_equal_ones_are() {
    let app = App::start().await;
    app.put("/v1/databases/shelf", json!({"kind": "objects"})).await.expect(201);
    let things = [("bar", Thing::Bar), ("wedge", Thing::Wedge), ("pair", Thing::Pair)];
    for (label, which) in things {
        for pose_deg in (0..360).step_by(20) {
            let path = format!("/v1/databases/shelf/exemplars?label={label}&pose_deg={pose_deg}");
            app.post_png(&path, png(&thing(which, f64::from(pose_deg), THING_PX))).await.expect(201);
        }
    }
    app.train("shelf", json!({"options": {"dimension": 12}})).await;
    let other = json!({"options": {"dimension": 13}, "promote": IF_NOT_WORSE});
    let equal = app.train("shelf", other).await;
    let comparison = &equal["comparison"];
    assert_eq!((&equal["version"], &comparison["promoted"]), (&json!(2), &json!(true)), "{equal:#}");
    assert_eq!((count(comparison, "trials"), &comparison["against_version"]), (108, &json!(1)));
    assert!(count(comparison, "candidate_right") >= 90, "{comparison:#}");

    // The same inputs again are judged again: the version that is there against itself.
    let same = app.train("shelf", json!({"options": {"dimension": 13}, "promote": IF_NOT_WORSE})).await;
    let comparison = &same["comparison"];
    assert_eq!((&same["version"], &comparison["against_version"]), (&json!(2), &json!(2)), "{same:#}");
    assert_eq!((count(comparison, "trials"), &comparison["p_value"]), (108, &json!(1.0)));

    let blind = json!({"options": {"dimension": 1, "stages": "universal_only"}, "promote": IF_NOT_WORSE});
    let worse = app.train("shelf", blind).await;
    assert_eq!(worse["comparison"]["promoted"], false, "{worse:#}");
    assert_eq!((&worse["version"], current(&app, "shelf").await), (&json!(3), json!(2)));
}
