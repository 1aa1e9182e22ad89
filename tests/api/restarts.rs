//! Restarts: what was acknowledged is there again, what was unfinished goes on, and a crash leaves nothing half.

use std::sync::Arc;
use std::time::{Duration, Instant};

use landmarkd::config::{GivenSettings, Settings};
use landmarkd::serve;
use landmarkd::store::open_folder;
use landmarkd::telemetry::chain;
use reqwest::Client;
use serde_json::{Value, json};
use tokio::sync::watch;

use crate::app::{App, once_free};
use crate::pictures::{Numbers, scene_png};
use crate::process::{Process, landmarkd};

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_opened_again_serves_what_it_served() {
    let app = App::start().await;
    app.trained("lab", 3).await;
    app.train("lab", json!({"options": {"interest_points": 8}, "promote": "never"})).await;
    app.put("/v1/databases/lab/aliases/next", json!({"version": 2})).await.expect(201);
    let look = async |app: &App| {
        let paths = ["", "/exemplars", "/versions", "/aliases"];
        let mut seen = Vec::new();
        for path in paths {
            seen.push(app.get(&format!("/v1/databases/lab{path}")).await.expect(200));
        }
        for query in ["", "?alias=next", "?version=2"] {
            let answer = app.recognise("lab", query, scene_png(2)).await;
            seen.push(json!([answer["version"], answer["digest"], answer["votes"]]));
        }
        seen
    };
    let before = look(&app).await;
    let folder = app.stop();
    let app = App::open(folder, |_| ()).await;
    assert_eq!(look(&app).await, before);
    let ready = app.get("/readyz").await.expect(200);
    assert_eq!(ready["status"], "ready");
    assert_eq!(ready["databases"], json!([{"database": "lab", "version": 1, "state": "ready"}]));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_a_dead_process_left_running_is_taken_up_and_finishes_once() {
    let mut app = App::start_idle().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    app.add("lab", "can", 2).await;
    let job = app.post("/v1/databases/lab/trainings", json!({})).await.expect(202);
    app.leave_jobs();
    let folder = app.stop();
    // A worker claims the job for an hour and dies.
    let dead = once_free(async || open_folder(folder.path()).await).await;
    let claimed =
        dead.catalogue.claim_job("a dead worker", &["training"], Duration::from_secs(3600), 5).await;
    assert_eq!(claimed.unwrap().unwrap().id.to_string(), job["id"]);
    drop(dead);

    let started = Instant::now();
    let app = App::open(folder, |_| ()).await;
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(1)), "{job:#}");
    assert_eq!(job["attempts"], 2);
    assert_ne!(job["worker"], "a dead worker");
    assert!(started.elapsed() < Duration::from_secs(10), "the dead worker's lease was waited for");
    assert_eq!(app.get("/v1/databases/lab").await.expect(200)["versions"], 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_kills_its_worker_time_after_time_is_given_up() {
    let mut app = App::start_idle().await;
    app.create("lab").await;
    app.add("lab", "cup", 1).await;
    let job = app.post("/v1/databases/lab/trainings", json!({})).await.expect(202);
    app.leave_jobs();
    let folder = app.stop();
    for attempt in 1..=5 {
        let dead = once_free(async || open_folder(folder.path()).await).await;
        let worker = format!("victim {attempt}");
        dead.catalogue.release_dead_leases(&worker).await.unwrap();
        let claimed = dead.catalogue.claim_job(&worker, &["training"], Duration::from_secs(3600), 5).await;
        assert_eq!(claimed.unwrap().unwrap().attempts, attempt);
    }
    let app = App::open(folder, |_| ()).await;
    let job = app.finished(&job).await;
    assert_eq!(
        (&job["state"], &job["problem"]["code"]),
        (&json!("failed"), &json!("attempts_exhausted")),
        "{job:#}"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_version_that_is_lost_degrades_its_database_and_no_other() {
    let app = App::start().await;
    app.trained("lab", 2).await;
    app.trained("hall", 3).await;
    let lost =
        app.get("/v1/databases/lab/versions/1/artifact").await.header("etag").trim_matches('"').to_owned();
    let folder = app.stop();
    let mut removed = 0;
    let mut folders = vec![folder.path().join("blobs")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.to_string_lossy().replace(['/', '\\'], "").ends_with(&lost) {
                std::fs::remove_file(path).unwrap();
                removed += 1;
            }
        }
    }
    assert_eq!(removed, 1, "the artifact's blob is named by its hash");

    let app = App::open(folder, |_| ()).await;
    let ready = app.get("/readyz").await.expect(200);
    assert_eq!(ready["status"], "degraded", "{ready:#}");
    let states: Vec<_> =
        ready["databases"].as_array().unwrap().iter().map(|d| (&d["database"], &d["state"])).collect();
    let (hall, lab) = ((json!("hall"), json!("ready")), (json!("lab"), json!("degraded")));
    assert_eq!(states, [(&hall.0, &hall.1), (&lab.0, &lab.1)]);
    assert!(ready["databases"][1]["reason"].as_str().is_some_and(|reason| !reason.is_empty()));
    app.recognise("hall", "", scene_png(1)).await;
    let answer = app.post_png("/v1/databases/lab/recognitions", scene_png(1)).await;
    answer.expect_problem(409, "version_unloadable");
    // Training the same exemplars in another way heals it.
    app.train("lab", json!({"options": {"interest_points": 12}})).await;
    assert_eq!(app.recognise("lab", "", scene_png(1)).await["version"], 2);
    assert_eq!(app.get("/readyz").await.expect(200)["status"], "ready");
}

fn settings(folder: &std::path::Path) -> Settings {
    let given =
        GivenSettings { data_dir: Some(folder.to_owned()), threads: Some(1), ..GivenSettings::default() };
    Settings::settle(given, None).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_in_use_is_refused_with_what_to_do() {
    let folder = Arc::new(tempfile::tempdir().unwrap());
    let first = App::open(Arc::clone(&folder), |_| ()).await;
    let Err(refused) = serve::wire(&settings(folder.path()), watch::channel(false).1).await else {
        panic!("two in one folder")
    };
    let text = chain(&refused);
    assert!(text.contains("in use by another process") && text.contains("choose another folder"), "{text}");

    let second =
        landmarkd().args(["serve", "--bind", "127.0.0.1:0", "--data-dir"]).arg(folder.path()).output();
    let second = second.unwrap();
    let said = String::from_utf8_lossy(&second.stderr);
    assert!(!second.status.success());
    assert!(said.contains("in use by another process"), "{said}");
    drop(first);
    once_free(async || serve::wire(&settings(folder.path()), watch::channel(false).1).await).await;
}

/// The service's own client: no proxy, and no connection is used twice, so that a kill shows at once.
fn client() -> Client {
    rustls::crypto::ring::default_provider().install_default().ok();
    Client::builder().no_proxy().pool_max_idle_per_host(0).timeout(Duration::from_secs(30)).build().unwrap()
}

async fn get(client: &Client, url: &str) -> Value {
    let answer = client.get(url).send().await.unwrap();
    assert_eq!(answer.status(), 200, "{url}");
    answer.json().await.unwrap()
}

/// Options under which training many small pictures takes long enough to be cut off in its midst.
fn slow_options() -> Value {
    json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 128, "subwindow_radius_px": 9.0, "rings": 16, "sectors": 64}})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_kill_at_any_moment_loses_nothing_that_was_acknowledged() {
    let folder = tempfile::tempdir().unwrap();
    let client = client();
    let mut acknowledged: Vec<String> = Vec::new();
    let mut jobs: Vec<String> = Vec::new();
    for round in 0..5_u64 {
        let mut numbers = Numbers::seeded(round);
        let process = Process::start(folder.path());
        let started = Instant::now();
        let lab = format!("{}/v1/databases/lab", process.url);
        client.put(&lab).json(&slow_options()).send().await.unwrap().error_for_status().unwrap();
        let die_after = Duration::from_millis(20 + numbers.below(600));
        let context = format!("round and seed {round}, killed after {die_after:?}");

        // Uploading, training and uploading on, until the power goes.
        let robot = async {
            let mut number = 1000 * (round + 1);
            loop {
                number += 1;
                let url = format!("{lab}/exemplars?label=place-{}", number % 7);
                let sent = client.post(url).header("content-type", "image/png").body(scene_png(number));
                let Ok(answer) = sent.send().await else { return };
                assert_eq!(answer.status(), 201);
                let Ok(exemplar) = answer.json::<Value>().await else { return };
                acknowledged.push(exemplar["id"].as_str().unwrap().to_owned());
                if number % 6 == 0 {
                    let sent = client.post(format!("{lab}/trainings")).json(&json!({})).send().await;
                    let Ok(answer) = sent else { return };
                    assert_eq!(answer.status(), 202);
                    let Ok(job) = answer.json::<Value>().await else { return };
                    jobs.push(job["id"].as_str().unwrap().to_owned());
                }
            }
        };
        let power_cut = async {
            tokio::time::sleep(die_after).await;
            process.kill();
        };
        tokio::join!(robot, power_cut);

        let restarted = Instant::now();
        let process = Process::start(folder.path());
        while client.get(format!("{}/readyz", process.url)).send().await.unwrap().status() != 200 {
            assert!(restarted.elapsed() < Duration::from_secs(5), "not ready: {context}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        let ready = get(&client, &format!("{}/readyz", process.url)).await;
        assert_eq!(ready["status"], "ready", "{ready:#} {context}");
        let lab = format!("{}/v1/databases/lab", process.url);
        let kept = get(&client, &format!("{lab}/exemplars?limit=1000")).await;
        let kept: Vec<_> = kept["items"].as_array().unwrap().iter().map(|item| item["id"].clone()).collect();
        for id in &acknowledged {
            assert!(kept.iter().any(|kept| kept == id), "exemplar {id} is lost: {context}");
        }
        for id in kept.iter().rev().take(3) {
            let image =
                client.get(format!("{lab}/exemplars/{}/image", id.as_str().unwrap())).send().await.unwrap();
            assert_eq!(image.status(), 200, "{context}");
        }
        // Every job that was promised ends well, and `current` is whole at every moment.
        for id in &jobs {
            let url = format!("{}/v1/jobs/{id}", process.url);
            let patience = Instant::now();
            let job = loop {
                let job = get(&client, &url).await;
                if !matches!(job["state"].as_str(), Some("queued" | "running")) {
                    break job;
                }
                assert!(patience.elapsed() < Duration::from_secs(60), "{job:#} {context}");
                tokio::time::sleep(Duration::from_millis(20)).await;
            };
            assert_eq!(job["state"], "succeeded", "{job:#} {context}");
        }
        if !jobs.is_empty() {
            let sent = client.post(format!("{lab}/recognitions")).body(scene_png(1001)).send().await.unwrap();
            let answer: Value = sent.json().await.unwrap();
            let named = get(&client, &format!("{lab}/aliases/current")).await;
            assert_eq!(answer["version"], named["version"], "{answer:#} {context}");
            let versions = get(&client, &format!("{lab}/versions")).await;
            let versions = versions["items"].as_array().unwrap().clone();
            let digest =
                versions.iter().find(|v| v["version"] == named["version"]).unwrap()["digest"].clone();
            assert_eq!(answer["digest"], digest, "{context}");
            let mut digests: Vec<_> = versions.iter().map(|v| v["digest"].as_str().unwrap()).collect();
            digests.sort_unstable();
            digests.dedup();
            assert_eq!(digests.len(), versions.len(), "published twice: {context}");
        }
        drop(process);
        println!("{context}: {} exemplars, {} jobs, {:?}", acknowledged.len(), jobs.len(), started.elapsed());
    }
    assert!(acknowledged.len() >= 20 && !jobs.is_empty(), "the rounds were too short to show anything");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_kill_during_a_training_lets_the_job_go_on_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let client = client();
    let process = Process::start(folder.path());
    let lab = format!("{}/v1/databases/lab", process.url);
    client.put(&lab).json(&slow_options()).send().await.unwrap().error_for_status().unwrap();
    for number in 1..=24 {
        let sent = client.post(format!("{lab}/exemplars?label=place-{number}")).body(scene_png(number));
        sent.send().await.unwrap().error_for_status().unwrap();
    }
    let sent = client.post(format!("{lab}/trainings")).json(&json!({})).send().await.unwrap();
    let job: Value = sent.json().await.unwrap();
    let path = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
    loop {
        let job = get(&client, &format!("{}{path}", process.url)).await;
        if job["state"] == "running" && job["progress"]["stage"] == "describing" {
            break;
        }
        assert!(matches!(job["state"].as_str(), Some("queued" | "running")), "over before the kill: {job:#}");
    }
    process.kill();
    let process = Process::start(folder.path());
    let patience = Instant::now();
    let job = loop {
        let job = get(&client, &format!("{}{path}", process.url)).await;
        if job["state"] == "succeeded" {
            break job;
        }
        assert!(matches!(job["state"].as_str(), Some("queued" | "running")), "{job:#}");
        assert!(patience.elapsed() < Duration::from_secs(30), "{job:#}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    };
    assert_eq!((&job["version"], &job["attempts"]), (&json!(1), &json!(2)), "{job:#}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_termination_finishes_what_runs_and_ends_well() {
    let folder = tempfile::tempdir().unwrap();
    let client = client();
    let process = Process::start(folder.path());
    let lab = format!("{}/v1/databases/lab", process.url);
    client.put(&lab).json(&slow_options()).send().await.unwrap().error_for_status().unwrap();
    for number in 1..=24 {
        let sent = client.post(format!("{lab}/exemplars?label=place-{number}")).body(scene_png(number));
        sent.send().await.unwrap().error_for_status().unwrap();
    }
    let sent = client.post(format!("{lab}/trainings")).json(&json!({})).send().await.unwrap();
    let job: Value = sent.json().await.unwrap();
    let id = job["id"].as_str().unwrap().to_owned();
    // A reader of the job's events must not hold the shutdown up.
    let events = client.get(format!("{}/v1/jobs/{id}/events", process.url)).send().await.unwrap();
    while get(&client, &format!("{}/v1/jobs/{id}", process.url)).await["state"] == "queued" {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let (status, took, log) = tokio::task::spawn_blocking(|| process.terminate()).await.unwrap();
    assert!(status.success(), "{status}: {log:#?}");
    assert!(took < Duration::from_secs(5), "the shutdown took {took:?}: {log:#?}");
    assert!(log.iter().any(|line| line.contains("shutting down")), "{log:#?}");
    drop(events);

    let process = Process::start(folder.path());
    let url = format!("{}/v1/jobs/{id}", process.url);
    let patience = Instant::now();
    while get(&client, &url).await["state"] != "succeeded" {
        assert!(patience.elapsed() < Duration::from_secs(30));
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert_eq!(get(&client, &url).await["attempts"], 1, "a job handed back was no attempt");
}

#[tokio::test(flavor = "multi_thread")]
async fn the_health_check_succeeds_while_the_service_is_ready_and_fails_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let client = client();
    while client.get(format!("{}/readyz", process.url)).send().await.unwrap().status() != 200 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let address = process.address().to_owned();
    let check = async |address: String| {
        let command = || landmarkd().args(["healthcheck", "--bind", &address]).output().unwrap();
        tokio::task::block_in_place(command)
    };
    assert_eq!(check(address.clone()).await.status.code(), Some(0));
    process.kill();
    let without = check(address.clone()).await;
    assert_eq!(without.status.code(), Some(1));
    let said = String::from_utf8_lossy(&without.stderr);
    assert!(said.contains("no answer from") && said.contains(&address), "{said}");
}

#[test]
fn an_address_that_others_reach_is_refused_unless_it_is_meant() {
    let folder = tempfile::tempdir().unwrap();
    let refused =
        landmarkd().args(["serve", "--bind", "0.0.0.0:0", "--data-dir"]).arg(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("--insecure") && said.contains("127.0.0.1"), "{said}");
    assert!(!folder.path().join("lock").exists(), "refused before anything is touched");
}

#[test]
fn wrong_settings_are_refused_with_their_name_and_range() {
    for (arguments, named) in [
        (&["--threads", "0"][..], "threads is 0"),
        (&["--max-body-mb", "9999"], "max_body_mb is 9999"),
        (&["--config", "/nowhere/landmarkd.toml"], "/nowhere/landmarkd.toml"),
        (&["--log-format", "xml"], "--log-format"),
        (&["--colour", "red"], "--colour"),
    ] {
        let refused = landmarkd().arg("serve").args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success(), "{arguments:?}");
        assert!(said.contains(named), "{arguments:?}: {said}");
    }
}
