//! Growing without retraining: a training that goes on from the version in use describes what is new, and forgets what is
//! gone for good.

use serde_json::{Value, json};

use crate::app::{App, pointers};
use crate::pictures::scene_png;

/// The version that answers, and its report.
async fn current(app: &App) -> (i64, Value) {
    let version = app.get("/v1/databases/lab").await.expect(200)["current_version"].as_i64().unwrap();
    let report =
        app.get(&format!("/v1/databases/lab/versions/{version}")).await.expect(200)["report"].clone();
    (version, report)
}

async fn keep(app: &App) -> (i64, Value) {
    app.train("lab", json!({"calibration": "none", "eigenspace": "keep"})).await;
    current(app).await
}

async fn named(app: &App, number: u64) -> Value {
    app.recognise("lab", "", scene_png(number)).await["votes"][0]["label"].clone()
}

async fn artifact(app: &App, version: i64) -> Vec<u8> {
    let answer = app.get(&format!("/v1/databases/lab/versions/{version}/artifact")).await;
    assert_eq!(answer.status, 200);
    answer.body.to_vec()
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_new_is_added_to_the_version_in_use_and_what_is_gone_is_forgotten() {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "landmarks"})).await.expect(201);
    for number in 1..6 {
        app.add("lab", &format!("place-{number}"), number).await;
    }
    let (first, report) = keep(&app).await;
    assert_eq!((first, &report["grown"]), (1, &Value::Null), "there was nothing to keep");

    let added = app.add("lab", "place-6", 6).await;
    app.add("lab", "place-7", 7).await;
    let (second, report) = keep(&app).await;
    let grown = &report["grown"];
    let expected = json!({"from_version": 1, "fitted_exemplars": 5, "added": 2, "removed": 0});
    for (member, value) in expected.as_object().unwrap() {
        assert_eq!(&grown[member], value, "{member}");
    }
    assert!(grown["residual"].as_f64().unwrap() > 0.0, "{grown}");
    assert_eq!(report["descriptions"], json!({"computed": 2, "kept": 0}));
    for number in [1, 4, 6, 7] {
        assert_eq!(named(&app, number).await, format!("place-{number}"));
    }

    let (same, _) = keep(&app).await;
    assert_eq!(same, second, "nothing is new");

    let id = added["id"].as_str().unwrap();
    assert!(artifact(&app, second).await.windows(id.len()).any(|bytes| bytes == id.as_bytes()));
    app.delete(&format!("/v1/databases/lab/exemplars/{id}")).await.expect(204);
    let (third, report) = keep(&app).await;
    assert_eq!((&report["grown"]["added"], &report["grown"]["removed"]), (&json!(2), &json!(1)));
    assert_eq!(report["grown"]["fitted_exemplars"], 5);
    let left = artifact(&app, third).await;
    assert!(!left.windows(id.len()).any(|bytes| bytes == id.as_bytes()));
    // without the windows of one exemplar, not only its name
    assert!(left.len() + 1000 < artifact(&app, second).await.len());
    assert_eq!(named(&app, 7).await, "place-7");

    // fitted anew it is as if what is gone had never been
    app.train("lab", json!({"calibration": "none", "eigenspace": "fit"})).await;
    let (fourth, report) = current(&app).await;
    assert_eq!((fourth, &report["grown"]), (4, &Value::Null));
    app.put("/v1/databases/never", json!({"kind": "landmarks"})).await.expect(201);
    for number in [1, 2, 3, 4, 5, 7] {
        app.add("never", &format!("place-{number}"), number).await;
    }
    app.train("never", json!({"calibration": "none"})).await;
    let never = app.get("/v1/databases/never/versions/1/artifact").await;
    assert_eq!(never.body.to_vec(), artifact(&app, fourth).await);
    // an artifact of several parts is imported as any other
    app.put("/v1/databases/copy", json!({"kind": "landmarks"})).await.expect(201);
    let media_type = "application/vnd.safetensors";
    let imported = app.post_bytes("/v1/databases/copy/versions", media_type, left.clone()).await;
    let version = imported.expect(201)["version"].clone();
    let copy = app.get(&format!("/v1/databases/copy/versions/{version}/artifact")).await;
    assert_eq!(copy.body.to_vec(), left);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_version_is_not_kept_and_an_imported_one_is_no_base() {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "landmarks"})).await.expect(201);
    for number in 1..5 {
        app.add("lab", &format!("place-{number}"), number).await;
    }
    let (first, _) = keep(&app).await;
    let file = artifact(&app, first).await;
    let blobs = walk(&app.folder().join("blobs"));
    let blob = blobs.into_iter().find(|path| std::fs::read(path).unwrap() == file).unwrap();
    std::fs::write(&blob, b"something else").unwrap();
    let (mended, _) = keep(&app).await;
    assert_eq!((mended, artifact(&app, first).await), (first, file.clone()));

    app.put("/v1/databases/copy", json!({"kind": "landmarks"})).await.expect(201);
    app.post_bytes("/v1/databases/copy/versions", "application/vnd.safetensors", file).await.expect(201);
    app.put("/v1/databases/copy/aliases/current", json!({"version": 1})).await.expect(201);
    for number in 1..6 {
        app.add("copy", &format!("place-{number}"), number).await;
    }
    app.train("copy", json!({"calibration": "none", "eigenspace": "keep"})).await;
    let trained = app.get("/v1/databases/copy/versions/2").await.expect(200);
    assert_eq!(trained["report"]["grown"], Value::Null);
}

/// The files of a folder and its folders.
fn walk(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { walk(&path) } else { vec![path] }).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_of_few_exemplars_is_trained_anew_unless_it_is_to_keep_its_eigenspace() {
    let app = App::start().await;
    app.put("/v1/databases/lab", json!({"kind": "landmarks"})).await.expect(201);
    for number in 1..5 {
        app.add("lab", &format!("place-{number}"), number).await;
        app.train("lab", json!({"calibration": "none"})).await;
        assert_eq!(current(&app).await.1["grown"], Value::Null);
    }
    // other options have another eigenspace
    app.add("lab", "place-9", 9).await;
    let other = json!({"calibration": "none", "eigenspace": "keep", "options": {"dimension": 12}});
    app.train("lab", other).await;
    assert_eq!(current(&app).await.1["grown"], Value::Null);
    let paper = json!({"options": {"method": "paper"}, "eigenspace": "keep"});
    let problem = app.post("/v1/databases/lab/trainings", paper).await.expect_problem(422, "invalid_field");
    assert_eq!(pointers(&problem), ["/eigenspace"]);
}
