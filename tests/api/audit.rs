//! The audit record: who changed what, in the order of the changes, with the call's id.

use axum::body::Body;
use axum::http::Method;
use serde_json::{Value, json};

use crate::app::{App, request, with_json};

fn told(page: &Value) -> Vec<(String, String, String)> {
    let items = page["items"].as_array().unwrap().iter().rev();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    items.map(|item| (text(&item["actor"]), text(&item["action"]), text(&item["subject"]))).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn every_change_names_who_made_it_and_by_which_call() {
    let mut app = App::start().await;
    app.create("attic").await;
    let (admin, admin_id) = app.close().await;
    let (robot, robot_id) = app.make_key(json!({"name": "robot 7", "scope": "train"})).await;
    app.use_key(Some(&robot));
    app.trained("lab", 2).await;
    app.train("lab", json!({"options": {"interest_points": 8}, "promote": "never"})).await;
    let moved = with_json(
        request(Method::PUT, "/v1/databases/lab/aliases/current").header("x-request-id", "call-42"),
        &json!({"version": 2}),
    );
    app.send(moved).await.expect(200);
    app.delete("/v1/databases/lab/exemplars?label=place-1").await.expect(204);
    app.use_key(Some(&admin));
    app.delete("/v1/databases/lab/versions/1").await.expect(204);
    app.delete(&format!("/v1/keys/{robot_id}")).await.expect(204);
    app.delete("/v1/databases/lab").await.expect(204);

    let record = app.get("/v1/audit").await.expect(200);
    let told = told(&record);
    let told: Vec<_> =
        told.iter().map(|(who, what, on)| (who.as_str(), what.as_str(), on.as_str())).collect();
    let of_jobs: Vec<_> =
        told.iter().filter(|(_, what, _)| *what == "job.queue").map(|told| told.2).collect();
    let workers: Vec<String> = of_jobs.iter().map(|id| format!("job {id}")).collect();
    assert_eq!(
        told,
        [
            ("anyone", "database.create", ""),
            ("command line", "key.create", admin_id.as_str()),
            ("operator", "key.create", robot_id.as_str()),
            ("robot 7", "database.create", ""),
            ("robot 7", "job.queue", of_jobs[0]),
            (workers[0].as_str(), "version.publish", "1"),
            (workers[0].as_str(), "alias.set", "current"),
            ("robot 7", "job.queue", of_jobs[1]),
            (workers[1].as_str(), "version.publish", "2"),
            ("robot 7", "alias.set", "current"),
            ("robot 7", "exemplar.delete", ""),
            ("operator", "version.delete", "1"),
            ("operator", "key.revoke", robot_id.as_str()),
            ("operator", "database.delete", ""),
        ]
    );
    let items = record["items"].as_array().unwrap();
    let moved = items.iter().find(|item| item["request_id"] == "call-42").unwrap();
    assert_eq!((&moved["key"], &moved["detail"]["version"]), (&json!(robot_id), &json!(2)));
    let deleted = items.iter().find(|item| item["action"] == "exemplar.delete").unwrap();
    assert_eq!(
        deleted["detail"],
        json!({"label": "place-1", "robot_id": null, "since": null, "before": null, "deleted": 1})
    );
    assert!(!record.to_string().contains(&robot[21..]) && !record.to_string().contains(&admin[21..]));

    // Pages, and what is asked for alone.
    let page = app.get("/v1/audit?limit=4").await.expect(200);
    let next = page["next_cursor"].as_str().unwrap();
    let rest = app.get(&format!("/v1/audit?limit=100&cursor={next}")).await.expect(200);
    assert_eq!(
        (page["items"].as_array().unwrap().len(), rest["items"].as_array().unwrap().len()),
        (4, items.len() - 4)
    );
    let of_robot = app.get(&format!("/v1/audit?key={robot_id}&action=alias.set")).await.expect(200);
    assert_eq!(of_robot["items"], json!([moved]));
    assert_eq!(app.get("/v1/audit?database=attic").await.expect(200)["items"].as_array().unwrap().len(), 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn no_call_changes_the_record() {
    let app = App::start().await;
    app.create("lab").await;
    for method in [Method::DELETE, Method::POST, Method::PUT] {
        let asked = request(method, "/v1/audit").body(Body::empty()).unwrap();
        app.send(asked).await.expect_problem(405, "method_not_allowed");
    }
    assert_eq!(app.get("/v1/audit").await.expect(200)["items"].as_array().unwrap().len(), 1);
}
