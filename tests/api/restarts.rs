//! Restarts: what was acknowledged is there again, and what was unfinished goes on. Crashes stand in `tests/crash`.

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
use crate::pictures::scene_png;
use crate::process::{Process, landmarkd};
use crate::waits::{until, until_blocking};

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

    let app = App::open(folder, |_| ()).await;
    // Every wait of a test is bounded by less than the dead worker's lease.
    let job = app.finished(&job).await;
    assert_eq!((&job["state"], &job["version"]), (&json!("succeeded"), &json!(1)), "{job:#}");
    assert_eq!(job["attempts"], 2);
    assert_ne!(job["worker"], "a dead worker");
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

/// Less than the 20 s after which a shutdown ends whatever still runs, and far more than one that waits for nothing takes.
const SHUTDOWN_PATIENCE: Duration = Duration::from_secs(15);

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
    let url = format!("{}/v1/jobs/{id}", process.url);
    until("the job runs", async || get(&client, &url).await["state"] != "queued").await;
    let begun = Instant::now();
    let ending = tokio::task::spawn_blocking(|| process.terminate());
    let events = tokio::time::timeout(SHUTDOWN_PATIENCE, events.bytes()).await;
    events.expect("the shutdown ends the events").unwrap();
    let (status, log) = ending.await.unwrap();
    assert!(begun.elapsed() < SHUTDOWN_PATIENCE, "the reader held the shutdown up: {log:#?}");
    assert!(status.success(), "{status}: {log:#?}");
    assert!(log.iter().any(|line| line.contains("shutting down")), "{log:#?}");

    let process = Process::start(folder.path());
    let url = format!("{}/v1/jobs/{id}", process.url);
    until("the job succeeds", async || get(&client, &url).await["state"] == "succeeded").await;
    assert_eq!(get(&client, &url).await["attempts"], 1, "a job handed back was no attempt");
}

/// A request that takes as long as its sender wants: its body is on the way.
fn slow_request(process: &Process) -> std::net::TcpStream {
    use std::io::Write;
    let mut stream = std::net::TcpStream::connect(process.address()).unwrap();
    let head = "POST /v1/databases/lab/exemplars?label=a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\nx";
    stream.write_all(head.as_bytes()).unwrap();
    // Until it has been begun.
    std::thread::sleep(Duration::from_millis(300));
    stream
}

#[test]
fn a_request_that_runs_at_a_termination_is_answered() {
    use std::io::{Read, Write};
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let mut stream = slow_request(&process);
    let address = process.address().to_owned();
    let begun = Instant::now();
    let ending = std::thread::spawn(|| process.terminate());
    until_blocking("the port is closed", || std::net::TcpStream::connect(&address).is_err());
    stream.write_all(&[b'x'; 99]).unwrap();
    let mut answer = String::new();
    stream.set_read_timeout(Some(SHUTDOWN_PATIENCE)).unwrap();
    stream.read_to_string(&mut answer).unwrap();
    // What it asks for isn't there; what counts is that it is told so.
    assert!(answer.starts_with("HTTP/1.1 4"), "{answer}");
    let (status, log) = ending.join().unwrap();
    assert!(begun.elapsed() < SHUTDOWN_PATIENCE, "nothing runs after the answer: {log:#?}");
    assert!(status.success(), "{status}: {log:#?}");
}

#[test]
fn a_second_signal_ends_at_once_what_the_first_lets_run() {
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let stream = slow_request(&process);
    process.signal("TERM");
    until_blocking("the port is closed", || std::net::TcpStream::connect(process.address()).is_err());
    // One that waits for the request ends well; the second signal doesn't wait.
    let (status, log) = process.terminate();
    assert!(!status.success(), "{log:#?}");
    drop(stream);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_health_check_succeeds_while_the_service_is_ready_and_fails_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let client = client();
    let ready = format!("{}/readyz", process.url);
    until("ready", async || client.get(&ready).send().await.unwrap().status() == 200).await;
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
