//! Swaps: recognition goes on through every publish, and each answer comes from one whole version.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use axum::http::Method;
use serde_json::json;

use crate::app::{App, request, with_bytes};
use crate::pictures::scene_png;

const ROBOTS: u64 = 8;
const TRAININGS: u64 = 20;

#[tokio::test(flavor = "multi_thread")]
async fn eight_robots_recognise_without_pause_while_twenty_versions_are_published() {
    let app = Arc::new(App::start().await);
    app.trained("lab", 2).await;
    let (stop, answered) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
    let robots: Vec<_> = (0..ROBOTS)
        .map(|robot| {
            let (app, stop, answered) = (Arc::clone(&app), Arc::clone(&stop), Arc::clone(&answered));
            tokio::spawn(async move {
                let (mut seen, mut last) = (HashSet::new(), 0);
                while !stop.load(Ordering::Relaxed) {
                    let asked = request(Method::POST, "/v1/databases/lab/recognitions");
                    let asked = with_bytes(asked, "image/png", scene_png(1 + robot % 2));
                    let answer = app.send(asked).await.expect(200);
                    assert_eq!(answer["votes"][0]["label"], format!("place-{}", 1 + robot % 2));
                    let version = answer["version"].as_i64().unwrap();
                    assert!(version >= last, "version {version} answered after {last}");
                    last = version;
                    seen.insert((version, answer["digest"].as_str().unwrap().to_owned()));
                    answered.fetch_add(1, Ordering::Relaxed);
                }
                seen
            })
        })
        .collect();
    for number in 3..3 + TRAININGS {
        app.add("lab", &format!("place-{number}"), number).await;
        if number % 4 == 0 {
            app.delete(&format!("/v1/databases/lab/exemplars?label=place-{}", number - 1)).await.expect(204);
        }
        app.train("lab", json!({})).await;
    }
    stop.store(true, Ordering::Relaxed);
    let mut seen = HashSet::new();
    for robot in robots {
        seen.extend(robot.await.unwrap());
    }
    let versions = app.get("/v1/databases/lab/versions").await.expect(200);
    let real: HashSet<_> = versions["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|version| (version["version"].as_i64().unwrap(), version["digest"].as_str().unwrap().to_owned()))
        .collect();
    assert_eq!(real.len() as u64, TRAININGS + 1);
    assert!(seen.is_subset(&real), "answers of versions that never were: {:?}", seen.difference(&real));
    assert!(seen.len() >= 5, "only {} versions were seen in {answered:?} answers", seen.len());
    // Versions that nothing names any more are gone from memory.
    assert_eq!(app.service.databases.registry().held().0, 1);
}
