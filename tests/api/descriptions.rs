//! Descriptions of exemplars kept for later trainings: a training describes new pictures only, its version is the one
//! that it would be without, and what describes a deleted picture goes.

use std::path::Path;

use serde_json::{Value, json};

use crate::app::App;

/// The versions' own report of where descriptions came from: computed, kept.
async fn descriptions(app: &App, database: &str) -> (u64, u64) {
    let current = app.get(&format!("/v1/databases/{database}")).await.expect(200)["current_version"].clone();
    let version = app.get(&format!("/v1/databases/{database}/versions/{current}")).await.expect(200);
    let count = |name: &str| version["report"]["descriptions"][name].as_u64().unwrap();
    (count("computed"), count("kept"))
}

/// The hash of the artifact that answers.
async fn etag(app: &App, database: &str) -> String {
    let current = app.get(&format!("/v1/databases/{database}")).await.expect(200)["current_version"].clone();
    let path = format!("/v1/databases/{database}/versions/{current}/artifact");
    app.get(&path).await.header("etag").to_owned()
}

async fn create(app: &App, database: &str, options: Value) {
    app.put(&format!("/v1/databases/{database}"), json!({"kind": "landmarks", "options": options}))
        .await
        .expect(201);
}

async fn teach(app: &App, database: &str, scenes: std::ops::Range<u64>) {
    for number in scenes {
        app.add(database, &format!("place-{number}"), number).await;
    }
}

async fn train(app: &App, database: &str) {
    app.train(database, json!({"calibration": "none"})).await;
}

fn files(folder: &Path) -> usize {
    std::fs::read_dir(folder.join("descriptions")).unwrap().count()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_training_describes_new_pictures_only_and_gives_the_same_version() {
    let app = App::start().await;
    create(&app, "lab", json!({})).await;
    teach(&app, "lab", 1..5).await;
    train(&app, "lab").await;
    assert_eq!(descriptions(&app, "lab").await, (4, 0));
    teach(&app, "lab", 5..7).await;
    train(&app, "lab").await;
    assert_eq!(descriptions(&app, "lab").await, (2, 4));

    // Another database shows some of the same pictures, under other labels and another decision.
    create(&app, "office", json!({"false_alarms": 0.1})).await;
    app.add("office", "desk", 3).await;
    app.add("office", "door", 7).await;
    train(&app, "office").await;
    assert_eq!(descriptions(&app, "office").await, (1, 1));

    // Other options of describing are other descriptions.
    app.train("lab", json!({"calibration": "none", "options": {"interest_points": 300}})).await;
    assert_eq!(descriptions(&app, "lab").await, (6, 0));

    let without = App::start_with(|settings| settings.description_limit_bytes = 0).await;
    create(&without, "lab", json!({})).await;
    teach(&without, "lab", 1..7).await;
    train(&without, "lab").await;
    assert_eq!(descriptions(&without, "lab").await, (6, 0));
    assert_eq!(files(without.folder()), 0);
    app.put("/v1/databases/lab/aliases/current", json!({"version": 2})).await.expect(200);
    assert_eq!(etag(&app, "lab").await, etag(&without, "lab").await);
}

#[tokio::test(flavor = "multi_thread")]
async fn descriptions_outlive_the_process_and_a_damaged_one_is_computed_again() {
    let app = App::start().await;
    create(&app, "lab", json!({})).await;
    teach(&app, "lab", 1..4).await;
    train(&app, "lab").await;
    let before = etag(&app, "lab").await;
    let folder = app.stop();
    let file = std::fs::read_dir(folder.path().join("descriptions")).unwrap().next().unwrap().unwrap();
    let mut bytes = std::fs::read(file.path()).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(file.path(), bytes).unwrap();

    let app = App::open(folder, |_| ()).await;
    app.put("/v1/databases/lab-2", json!({"kind": "landmarks"})).await.expect(201);
    teach(&app, "lab-2", 1..4).await;
    train(&app, "lab-2").await;
    assert_eq!(descriptions(&app, "lab-2").await, (1, 2));
    assert_eq!(etag(&app, "lab-2").await, before);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deleted_picture_takes_its_description_with_it() {
    let app = App::start().await;
    create(&app, "lab", json!({})).await;
    create(&app, "office", json!({})).await;
    teach(&app, "lab", 1..4).await;
    train(&app, "lab").await;
    teach(&app, "office", 3..4).await;
    assert_eq!(files(app.folder()), 3);
    assert_eq!(app.service.databases.collect_descriptions().await.unwrap(), 0);
    for label in ["place-2", "place-3"] {
        app.delete(&format!("/v1/databases/lab/exemplars?label={label}")).await.expect(204);
    }
    assert_eq!(
        app.service.databases.collect_descriptions().await.unwrap(),
        1,
        "the office still has place-3"
    );
    assert_eq!(files(app.folder()), 2);
}
