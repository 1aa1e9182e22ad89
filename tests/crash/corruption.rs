//! Damaged files: every byte of an artifact, an exemplar's picture, the catalogue. What is wrong is refused and named, the
//! rest serves, and the same content again mends it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bytes::Bytes;
use landmarkd::database::artifact;
use landmarkd::telemetry::chain;
use reqwest::Method;
use serde_json::{Value, json};

use crate::client::{Client, verify};
use crate::pictures::scene_png;
use crate::process::{Process, landmarkd};

/// A process with a database of few landmarks, trained, and its artifact.
async fn trained(folder: &Path) -> (Process, Client, Bytes) {
    let process = Process::start(folder);
    let client = Client::new(&process);
    client.ready("").await;
    for (database, scene) in [("lab", 1), ("hall", 5)] {
        let options =
            json!({"method": "paper", "interest_points": 1, "rings": 4, "sectors": 8, "dimension": 4});
        let body = json!({"kind": "landmarks", "options": options});
        client.put(&format!("/v1/databases/{database}"), body).await.unwrap().expect(201);
        for number in scene..scene + 2 {
            let path = format!("/v1/databases/{database}/exemplars?label=place-{number}");
            client.post_picture(&path, scene_png(number)).await.unwrap().expect(201);
        }
        train(&client, database).await;
    }
    let artifact = client.get("/v1/databases/lab/versions/1/artifact").await.unwrap();
    assert_eq!(artifact.status, 200);
    (process, client, artifact.body)
}

async fn train(client: &Client, database: &str) -> Value {
    let job =
        client.post(&format!("/v1/databases/{database}/trainings"), json!({})).await.unwrap().expect(202);
    client.ended(job["id"].as_str().unwrap()).await.unwrap()
}

/// Where the blob with this content stands.
fn file_of(folder: &Path, content: &[u8]) -> PathBuf {
    let mut folders = vec![folder.join("blobs")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if std::fs::read(&path).unwrap() == content {
                return path;
            }
        }
    }
    panic!("no blob has this content");
}

fn flipped(bytes: &[u8], at: usize) -> Vec<u8> {
    let mut flipped = bytes.to_vec();
    flipped[at] ^= 0xff;
    flipped
}

#[tokio::test(flavor = "multi_thread")]
async fn an_artifact_with_any_byte_changed_or_cut_off_is_refused_with_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let (_process, client, whole) = trained(folder.path()).await;
    let started = Instant::now();
    artifact::read(whole.clone()).unwrap();
    for at in 0..whole.len() {
        for damaged in [flipped(&whole, at), whole[..at].to_vec()] {
            let Err(refused) = artifact::read(damaged.into()) else { panic!("byte {at} may be anything") };
            assert!(!chain(&refused).is_empty());
        }
        let mut bit = whole.to_vec();
        bit[at] ^= 1 << (at % 8);
        assert!(artifact::read(bit.into()).is_err(), "a bit of byte {at} may be anything");
    }
    println!(
        "{} bytes: flipped, a bit flipped, cut off: all refused in {:?}",
        whole.len(),
        started.elapsed()
    );
    for at in (0..whole.len()).step_by(whole.len() / 40) {
        is_refused(&client, flipped(&whole, at)).await;
    }
}

async fn is_refused(client: &Client, damaged: Vec<u8>) {
    let answer = client
        .send(Method::POST, "/v1/databases/lab/versions", |request| {
            request.header("content-type", "application/octet-stream").body(damaged)
        })
        .await
        .unwrap();
    let problem = answer.json();
    assert!(matches!(answer.status, 422), "{} {problem:#}", answer.status);
    assert!(["invalid_artifact", "not_yet"].contains(&problem["code"].as_str().unwrap()), "{problem:#}");
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a minute or more: every byte over HTTP, and every byte on the disk, in release"]
async fn every_byte_changed_is_refused_by_the_service_too() {
    let folder = tempfile::tempdir().unwrap();
    let (process, client, whole) = trained(folder.path()).await;
    let started = Instant::now();
    for at in 0..whole.len() {
        is_refused(&client, flipped(&whole, at)).await;
    }
    println!("{} bytes flipped, imported and refused in {:?}", whole.len(), started.elapsed());
    let versions = client.get("/v1/databases/lab/versions").await.unwrap().expect(200);
    assert_eq!(versions["items"].as_array().unwrap().len(), 1);

    let started = Instant::now();
    let file = file_of(folder.path(), &whole);
    let quarantine = folder.path().join("quarantine");
    for at in 0..whole.len() {
        std::fs::write(&file, flipped(&whole, at)).unwrap();
        client.get("/v1/databases/lab/versions/1/artifact").await.unwrap().expect(409);
        assert!(!file.exists() && quarantine.join(file.file_name().unwrap()).exists());
    }
    println!("{} bytes flipped on the disk and set apart in {:?}", whole.len(), started.elapsed());
    drop(process);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_with_a_damaged_blob_degrades_its_database_alone_and_training_again_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    let (process, client, whole) = trained(folder.path()).await;
    let before =
        client.post_picture("/v1/databases/lab/recognitions", scene_png(1)).await.unwrap().expect(200);
    let file = file_of(folder.path(), &whole);
    drop(process);
    for damaged in [flipped(&whole, whole.len() / 2), whole[..whole.len() / 3].to_vec(), Vec::new()] {
        std::fs::write(&file, damaged).unwrap();
        let said = verify(folder.path()).unwrap_err();
        assert!(said.contains("version 1 of database lab"), "{said}");
        let process = Process::start(folder.path());
        let client = Client::new(&process);
        client.ready("").await;
        let ready = client.get("/readyz").await.unwrap().expect(200);
        assert_eq!(ready["status"], "degraded", "{ready:#}");
        let lab = ready["databases"].as_array().unwrap().iter().find(|d| d["database"] == "lab").unwrap();
        let reason = lab["reason"].as_str().unwrap();
        assert!(reason.contains("corrupt") && reason.contains("train again"), "{reason}");
        let refused = client.post_picture("/v1/databases/lab/recognitions", scene_png(1)).await.unwrap();
        assert_eq!(refused.expect(409)["code"], "version_unloadable");
        client.post_picture("/v1/databases/hall/recognitions", scene_png(5)).await.unwrap().expect(200);
        let apart = folder.path().join("quarantine").join(file.file_name().unwrap());
        assert!(apart.exists() && !file.exists(), "it was not set apart");

        let job = train(&client, "lab").await;
        assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(1)), "{job:#}");
        let answer =
            client.post_picture("/v1/databases/lab/recognitions", scene_png(1)).await.unwrap().expect(200);
        assert_eq!((&answer["digest"], &answer["votes"]), (&before["digest"], &before["votes"]));
        assert_eq!(std::fs::read(&file).unwrap(), whole, "the same training gives the same bytes");
        // It looks again at what didn't load after ten seconds, and at what is in memory after two.
        let mended = Instant::now();
        while client.get("/readyz").await.unwrap().expect(200)["status"] != "ready" {
            assert!(mended.elapsed() < Duration::from_secs(20), "it stays degraded");
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }
    verify(folder.path()).unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn an_exemplar_with_a_damaged_blob_is_named_and_sending_it_again_mends_it() {
    let folder = tempfile::tempdir().unwrap();
    let (_process, client, _) = trained(folder.path()).await;
    let picture = scene_png(7);
    let path = "/v1/databases/lab/exemplars?label=place-7";
    let id = client.post_picture(path, picture.clone()).await.unwrap().expect(201)["id"].clone();
    let id = id.as_str().unwrap();
    let image = format!("/v1/databases/lab/exemplars/{id}/image");
    let file = file_of(folder.path(), &picture);
    let longer = [&picture[..], &picture[..]].concat();
    for damage in [Some(flipped(&picture, 60)), Some(picture[..20].to_vec()), Some(longer), None] {
        match damage {
            Some(bytes) => std::fs::write(&file, bytes).unwrap(),
            None => std::fs::remove_file(&file).unwrap(),
        }
        for _ in 0..2 {
            let problem = client.get(&image).await.unwrap().expect(422);
            assert_eq!(problem["code"], "unreadable_exemplar");
            assert!(problem["detail"].as_str().unwrap().contains(id), "{problem:#}");
        }
        let job = train(&client, "lab").await;
        assert_eq!(
            (&job["state"], &job["problem"]["code"]),
            (&json!("failed"), &json!("unreadable_exemplar"))
        );
        assert!(job["problem"]["detail"].as_str().unwrap().contains(id), "{job:#}");
        assert!(verify(folder.path()).unwrap_err().contains(id));
        for (database, scene) in [("lab", 1), ("hall", 5)] {
            let path = format!("/v1/databases/{database}/recognitions");
            client.post_picture(&path, scene_png(scene)).await.unwrap().expect(200);
        }
        client.post_picture(path, picture.clone()).await.unwrap().expect(200);
        assert_eq!(client.get(&image).await.unwrap().body, picture);
        verify(folder.path()).unwrap();
    }
    assert_eq!(train(&client, "lab").await["state"], "succeeded");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_or_lost_catalogue_is_refused_with_what_to_do() {
    let (served, copies) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    drop(trained(served.path()).await);
    // A copy has all rows in the file and none in the log.
    let folder = copies.path().join("copy");
    let copied =
        landmarkd().arg("backup").arg("--data-dir").arg(served.path()).arg("--to").arg(&folder).status();
    assert!(copied.unwrap().success());
    let path = folder.join("catalogue.sqlite");
    let whole = std::fs::read(&path).unwrap();
    let mut wrong_pages = whole.clone();
    for page in wrong_pages.chunks_mut(4096).skip(1) {
        page[..100].fill(0xa5);
    }
    let damages: [(&str, Option<Vec<u8>>); 5] = [
        ("its head", Some(flipped(&whole, 3))),
        ("its pages", Some(wrong_pages)),
        ("its end", Some(whole[..whole.len() / 2].to_vec())),
        ("all of it", Some(Vec::new())),
        ("itself", None),
    ];
    for (what, damage) in damages {
        match damage {
            Some(bytes) => std::fs::write(&path, bytes).unwrap(),
            None => std::fs::remove_file(&path).unwrap(),
        }
        let Err(log) = Process::try_start_with(&folder, |_| ()) else { panic!("started without {what}") };
        let said = log.join("\n");
        assert!(said.contains("restore") && said.contains("backup"), "{what}: {said}");
        assert!(said.contains("catalogue.sqlite"), "{what}: {said}");
        for rest in ["catalogue.sqlite-wal", "catalogue.sqlite-shm"] {
            std::fs::remove_file(folder.join(rest)).ok();
        }
        std::fs::write(&path, &whole).unwrap();
    }
    let process = Process::start(&folder);
    let client = Client::new(&process);
    client.ready("").await;
    client.post_picture("/v1/databases/lab/recognitions", scene_png(1)).await.unwrap().expect(200);
}
