//! What happens here, as it happens; and the health and metadata that others route by.

use axum::body::Body;
use axum::http::Method;
use serde_json::{Value, json};

use crate::app::{App, request, with_bytes};
use crate::pictures::scene_png;

/// The events of a stream that is read until it was told of `count`.
async fn read(app: &App, query: &str, last: Option<&str>, count: usize) -> Vec<(String, String, Value)> {
    let mut asked = request(Method::GET, &format!("/v1/events{query}"));
    if let Some(last) = last {
        asked = asked.header("last-event-id", last);
    }
    let text =
        app.read_stream(asked.body(Body::empty()).unwrap(), |text| text.matches("data:").count() >= count);
    let text = text.await;
    let field = |event: &str, name: &str| {
        let line = event.lines().find_map(|line| line.strip_prefix(name));
        line.unwrap_or_default().trim().to_owned()
    };
    let events = text.split("\n\n").filter(|event| event.contains("data:"));
    let parsed = events.map(|event| {
        let data = serde_json::from_str(&field(event, "data:")).unwrap();
        (field(event, "id:"), field(event, "event:"), data)
    });
    parsed.collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn decisions_versions_and_jobs_are_told_and_a_stream_resumes() {
    let app = App::start().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    app.add("lab", "can", 2).await;
    let ask = async |robot: &str| {
        let asked = request(Method::POST, "/v1/databases/lab/recognitions").header("x-robot-id", robot);
        app.send(with_bytes(asked, "image/png", scene_png(1))).await.expect(200)
    };
    let followed = read(&app, "?database=lab&kind=version,job", None, 3);
    let (told, _) = tokio::join!(followed, app.train("lab", json!({})));
    assert!(told.iter().any(|(_, kind, data)| kind == "job" && data["kind"] == "training"), "{told:?}");

    let (told, answer) = tokio::join!(read(&app, "?kind=decision", None, 1), async {
        // the stream has to be open first
        crate::waits::until("somebody follows", async || app.is_followed()).await;
        ask("r1").await
    });
    let (id, kind, data) = &told[0];
    assert_eq!((kind.as_str(), &data["database"], &data["version"]), ("decision", &json!("lab"), &json!(1)));
    assert_eq!(data["decision"], answer["decision"]);
    assert_eq!(data["header"]["robot_id"], "r1");

    ask("r2").await;
    ask("r1").await;
    let resumed = read(&app, "?kind=decision&robot_id=r1", Some(id), 1).await;
    assert_eq!((resumed.len(), &resumed[0].2["header"]["robot_id"]), (1, &json!("r1")));
    let of_another = read(&app, "?kind=decision", Some("7-7"), 2).await;
    assert_eq!(of_another[0].1, "lost");
    let refused = app.get("/v1/events?kind=gossip").await.expect_problem(422, "invalid_field");
    assert_eq!(refused["errors"][0]["pointer"], "#kind");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_follows_what_it_reaches() {
    let mut app = App::start().await;
    let (admin, _) = app.close().await;
    app.trained("lab", 1).await;
    app.trained("attic", 1).await;
    let (robot, _) = app.make_key(json!({"name": "r", "scope": "recognise", "databases": ["lab"]})).await;
    let ask = async |database: &str| {
        let path = format!("/v1/databases/{database}/recognitions");
        app.post_png(&path, scene_png(1)).await.expect(200);
    };
    let start = read(&app, "?kind=decision", None, 1);
    let (first, ()) = tokio::join!(start, async {
        crate::waits::until("somebody follows", async || app.is_followed()).await;
        ask("attic").await;
    });
    ask("attic").await;
    ask("lab").await;
    // From the same place on the confined key sees what is about its own database alone.
    app.use_key(Some(&robot));
    let told = read(&app, "?kind=decision", Some(&first[0].0), 1).await;
    assert_eq!(told.iter().map(|(_, _, data)| &data["database"]).collect::<Vec<_>>(), ["lab"]);
    app.get("/v1/events?database=attic").await.expect_problem(403, "not_allowed");
    app.use_key(Some(&admin));
}

#[tokio::test(flavor = "multi_thread")]
async fn the_inference_protocol_tells_health_and_models() {
    let app = App::start().await;
    assert_eq!(app.get("/v2/health/live").await.expect(200)["live"], true);
    assert_eq!(app.get("/v2/health/ready").await.expect(200)["ready"], true);
    assert_eq!(app.get("/v2").await.expect(200)["name"], "landmarkd");
    app.get("/v2/models/lab").await.expect_problem(404, "unknown_database");
    app.create("lab").await;
    let asked = request(Method::GET, "/v2/models/lab/ready").body(Body::empty()).unwrap();
    let waiting = app.send_as_it_is(asked).await;
    assert_eq!((waiting.status, &waiting.json()["ready"]), (503, &json!(false)));
    app.add("lab", "cup", 1).await;
    app.train("lab", json!({})).await;
    assert_eq!(app.get("/v2/models/lab/ready").await.expect(200)["ready"], true);
    let model = app.get("/v2/models/lab").await.expect(200);
    assert_eq!((&model["platform"], &model["versions"]), (&json!("landmarkd_landmarks"), &json!(["1"])));
    let version = app.get("/v2/models/lab/versions/1").await.expect(200);
    assert_eq!(version["versions"], json!(["1"]));
    app.get("/v2/models/lab/versions/2").await.expect_problem(404, "unknown_version");
}
