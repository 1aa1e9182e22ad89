//! `kill -9` at random moments of uploading, training, publishing and starting, round after round over one folder.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::client::{Client, Died, verify};
use crate::pictures::{Numbers, scene_png};
use crate::process::{Process, landmarkd};
use crate::scenario::{Fact, Known, Robot};

/// What the rounds came to.
#[derive(Debug, Default)]
struct Tally {
    exemplars: usize,
    jobs: u64,
    killed_while_starting: u64,
    slowest_start: Duration,
}

/// Options under which a training takes long enough to be cut off in its midst.
fn slow_options() -> Value {
    json!({"kind": "landmarks", "options": {"method": "paper", "interest_points": 24}})
}

async fn rounds(count: u64, seed: u64) -> Tally {
    println!("seed {seed}");
    let started = Instant::now();
    let mut numbers = Numbers::seeded(seed);
    let mut tally = Tally::default();
    let mut folder = tempfile::tempdir().unwrap();
    let mut known = Known::default();
    let mut last_check = Duration::ZERO;
    for round in 0..count {
        // A folder grows, and its trainings with it; now and then a new one.
        if round % 20 == 0 && round > 0 {
            verify(folder.path()).unwrap();
            (folder, known) = (tempfile::tempdir().unwrap(), Known::default());
        }
        let die_after = Duration::from_millis(10 + numbers.below(700));
        let context = format!("seed {seed}, round {round}, killed after {die_after:?}");
        let process = Process::start(folder.path());
        let client = Client::new(&process);
        client.ready(&context).await;
        let mut robot = Robot::new(client.clone(), known, None);
        let first = 1 + 1000 * round;
        let working = async {
            assert!(client.put("/v1/databases/lab", slow_options()).await?.is_well());
            for number in first.. {
                robot.upload("lab", number).await?;
                if number % 4 == 0 {
                    robot.train("lab").await?;
                    robot.recognise("lab").await?;
                }
            }
            Ok::<_, Died>(())
        };
        let killing = async {
            tokio::time::sleep(die_after).await;
            process.kill();
        };
        let (died, ()) = tokio::join!(working, killing);
        assert_eq!(died, Err(Died), "{context}");
        known = robot.known;

        // In some rounds the next one dies too, while it starts or takes up what was left.
        if numbers.below(3) == 0 {
            tally.killed_while_starting += 1;
            let mut starting = landmarkd()
                .args(["serve", "--bind", "127.0.0.1:0", "--threads", "2", "--data-dir"])
                .arg(folder.path())
                .stderr(std::process::Stdio::null())
                .spawn()
                .unwrap();
            tokio::time::sleep(Duration::from_millis(numbers.below(150))).await;
            starting.kill().unwrap();
            starting.wait().unwrap();
        }

        let restarted = Instant::now();
        let process = Process::start(folder.path());
        let client = Client::new(&process);
        client.ready(&context).await;
        tally.slowest_start = tally.slowest_start.max(restarted.elapsed());
        let mut robot = Robot::new(client, known, None);
        robot.check(folder.path(), &context).await;
        tally.jobs += known_jobs(&robot.known.facts);
        tally.exemplars += robot.known.facts.values().filter(|fact| matches!(fact, Fact::Bytes(_))).count();
        known = robot.known;
        // Each job once: those that ended are known to have.
        known.facts.retain(|path, _| !path.starts_with("/v1/jobs/"));
        drop(process);
        if started.elapsed() - last_check > Duration::from_secs(30) {
            last_check = started.elapsed();
            println!("{round} rounds in {last_check:?}");
        }
    }
    println!("{count} rounds: {tally:#?} in {:?}", started.elapsed());
    tally
}

fn known_jobs(facts: &BTreeMap<String, Fact>) -> u64 {
    facts.keys().filter(|path| path.starts_with("/v1/jobs/")).count() as u64
}

fn seed() -> u64 {
    std::time::UNIX_EPOCH.elapsed().unwrap().as_secs()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_kill_at_any_moment_loses_nothing_that_was_acknowledged() {
    let tally = rounds(6, seed()).await;
    assert!(tally.exemplars > 0, "the rounds were too short to show anything");
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "minutes: 240 rounds, in release"]
async fn two_hundred_and_forty_kills_lose_nothing_that_was_acknowledged() {
    let tally = rounds(240, seed()).await;
    assert!(tally.exemplars > 1000 && tally.jobs > 100 && tally.killed_while_starting > 20);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_kill_during_a_training_lets_the_job_go_on_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let process = Process::start(folder.path());
    let client = Client::new(&process);
    let long = json!({"kind": "landmarks", "options": {
        "method": "paper", "interest_points": 128, "subwindow_radius_px": 9.0, "rings": 16, "sectors": 64,
    }});
    client.put("/v1/databases/lab", long).await.unwrap().expect(201);
    for number in 1..=24 {
        let path = format!("/v1/databases/lab/exemplars?label=place-{number}");
        client.post_picture(&path, scene_png(number)).await.unwrap().expect(201);
    }
    let job = client.post("/v1/databases/lab/trainings", json!({})).await.unwrap().expect(202);
    let id = job["id"].as_str().unwrap();
    let path = format!("/v1/jobs/{id}");
    loop {
        let job = client.get(&path).await.unwrap().expect(200);
        if job["state"] == "running" && job["progress"]["stage"] == "describing" {
            break;
        }
        assert!(matches!(job["state"].as_str(), Some("queued" | "running")), "over before the kill: {job:#}");
    }
    process.kill();
    let process = Process::start(folder.path());
    let job = Client::new(&process).ended(id).await.unwrap();
    assert_eq!(
        (&job["state"], &job["version"], &job["attempts"]),
        (&json!("succeeded"), &json!(1), &json!(2)),
        "{job:#}"
    );
}
