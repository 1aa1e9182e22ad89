//! `calibration: "background"`: a version serves as soon as its eigenspace stands, and is asked about its own pictures
//! afterwards, in the same job.

use serde_json::{Value, json};

use crate::app::App;
use crate::pictures::scene_png;
use crate::waits::until;

async fn taught(app: &App, scenes: u64) {
    app.put("/v1/databases/lab", json!({"kind": "landmarks"})).await.expect(201);
    for number in 1..=scenes {
        app.add("lab", &format!("place-{}", number % 5), number).await;
    }
}

async fn report(app: &App, version: u64) -> Value {
    app.get(&format!("/v1/databases/lab/versions/{version}")).await.expect(200)["report"].clone()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_version_serves_before_its_verdict_comes() {
    let app = App::start().await;
    taught(&app, 10).await;
    let job = app.train("lab", json!({"calibration": "background", "promote": "if_not_worse"})).await;
    assert_eq!((&job["version"], &job["comparison"]["promoted"]), (&json!(1), &json!(true)), "{job:#}");
    let events = app.get(&format!("/v1/jobs/{}/events", job["id"].as_str().unwrap())).await;
    let events = String::from_utf8(events.body.to_vec()).unwrap();
    let states: Vec<Value> = events
        .lines()
        .filter_map(|line| serde_json::from_str(line.strip_prefix("data:")?.trim()).ok())
        .collect();
    let checking = states.iter().find(|event| event["progress"]["stage"] == "checking").unwrap();
    assert_eq!((&checking["state"], &checking["version"]), (&json!("running"), &json!(1)));
    let published = states.iter().position(|event| event["version"] == 1).unwrap();
    assert!(states[..published].iter().all(|event| event["progress"]["stage"] != "checking"));

    let report = report(&app, 1).await;
    assert_eq!(report["verdict"]["asked"], 10, "{report:#}");
    assert!(report["timings_ms"]["rehearsal"].as_f64().unwrap() > 0.0);
    assert!(!report["warnings"].as_array().unwrap().contains(&json!("not_checked")), "{report:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_whose_process_ends_before_the_verdict_stays_and_says_so() {
    let mut app = App::start().await;
    taught(&app, 60).await;
    let queued =
        app.post("/v1/databases/lab/trainings", json!({"calibration": "background"})).await.expect(202);
    let path = format!("/v1/jobs/{}", queued["id"].as_str().unwrap());
    until("published", async || app.get(&path).await.json()["version"] == 1).await;
    let job = app.get(&path).await.expect(200);
    assert_eq!(job["state"], "running", "the test must see it before it has ended");
    assert!(app.recognise("lab", "", scene_png(1)).await["version"] == 1);
    let before = report(&app, 1).await;
    assert_eq!(before["verdict"], Value::Null);
    assert!(before["warnings"].as_array().unwrap().contains(&json!("not_checked")), "{before:#}");
    app.leave_jobs();
    let folder = app.stop();

    // The job is taken up again where it was: no other version.
    let app = App::open(folder, |_| ()).await;
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(1)), "{job:#}");
    let after = report(&app, 1).await;
    assert_eq!(after["verdict"]["asked"], 60, "{after:#}");
    assert!(!after["warnings"].as_array().unwrap().contains(&json!("not_checked")));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_without_a_verdict_is_asked_when_the_same_is_trained_again() {
    let app = App::start().await;
    taught(&app, 5).await;
    app.train("lab", json!({"calibration": "none"})).await;
    assert_eq!(report(&app, 1).await["verdict"], Value::Null);
    let job = app.train("lab", json!({})).await;
    assert_eq!(job["version"], 1, "the same version");
    assert_eq!(report(&app, 1).await["verdict"]["single_picture_labels"].as_array().unwrap().len(), 5);
    let job = app.train("lab", json!({"calibration": "background"})).await;
    assert_eq!(job["version"], 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_cancelled_check_leaves_the_version() {
    let app = App::start().await;
    taught(&app, 60).await;
    let queued =
        app.post("/v1/databases/lab/trainings", json!({"calibration": "background"})).await.expect(202);
    let path = format!("/v1/jobs/{}", queued["id"].as_str().unwrap());
    until("published", async || app.get(&path).await.json()["version"] == 1).await;
    app.delete(&path).await;
    let job = app.finished(&queued).await;
    assert_eq!((&job["state"], &job["version"]), (&json!("cancelled"), &json!(1)), "{job:#}");
    assert_eq!(app.get("/v1/databases/lab").await.expect(200)["current_version"], 1);
    assert!(report(&app, 1).await["warnings"].as_array().unwrap().contains(&json!("not_checked")));
}

#[tokio::test(flavor = "multi_thread")]
async fn what_needs_a_calibration_is_not_published_before_it() {
    let app = App::start().await;
    app.create("paper").await;
    app.put("/v1/databases/things", json!({"kind": "objects"})).await.expect(201);
    for database in ["paper", "things"] {
        let body = json!({"calibration": "background"});
        let answer = app.post(&format!("/v1/databases/{database}/trainings"), body).await;
        let problem = answer.expect_problem(422, "invalid_field");
        assert!(problem["detail"].as_str().unwrap().contains("wait or none"), "{problem:#}");
    }
}
