//! Jobs end exactly once, whatever happens to the processes that do them.

use std::time::Duration;

use serde_json::Value;

use crate::fleet::{Client, Fleet};
use crate::pictures::Numbers;

/// Every state a job went through, from its events in the catalogue as the service tells them.
async fn states(client: &Client, job: &str) -> Vec<String> {
    let (_, body) = client.get(job).await;
    assert!(body["finished_at"].is_string(), "{body}");
    let events = client.text(&format!("{job}/events")).await;
    let bodies = events.lines().filter_map(|line| line.strip_prefix("data:"));
    bodies
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["state"].as_str().unwrap().to_owned())
        .collect()
}

fn ends(states: &[String]) -> usize {
    states.iter().filter(|state| ["succeeded", "failed", "cancelled"].contains(&state.as_str())).count()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_trainer_killed_at_twenty_moments_leaves_no_job_undone_and_none_done_twice() {
    let fleet = Fleet::new();
    let server = fleet.process(&["--role", "serve"]);
    let mut jobs = Vec::new();
    for number in 0..20 {
        let database = format!("room{number}");
        server.client.teach(&database, number * 10..number * 10 + 4).await;
    }
    let seed = 7;
    let mut numbers = Numbers::seeded(seed);
    for number in 0..20 {
        let database = format!("room{number}");
        jobs.push((database.clone(), server.client.train(&database).await));
        let trainer = fleet.process(&["--role", "train"]);
        tokio::time::sleep(Duration::from_millis(numbers.below(1200))).await;
        trainer.process.kill();
    }
    let _trainer = fleet.process(&["--role", "train"]);
    let (mut retaken, mut failed) = (0, 0);
    for (database, job) in &jobs {
        let ended = server.client.ended(job).await;
        let states = states(&server.client, job).await;
        assert_eq!(ends(&states), 1, "{database}: {states:?}");
        retaken += usize::from(ended["attempts"].as_i64().unwrap() > 1);
        let (_, versions) = server.client.get(&format!("/v1/databases/{database}/versions")).await;
        let versions = versions["items"].as_array().unwrap().len();
        if ended["state"] == "succeeded" {
            assert_eq!((versions, ended["version"].as_i64()), (1, Some(1)), "{database}: {ended}");
            server.client.serves(database, 1).await;
        } else {
            assert_eq!(ended["problem"]["code"], "attempts_exhausted", "{ended}");
            assert_eq!(versions, 0, "{ended}");
            failed += 1;
        }
    }
    assert!(retaken > 0, "no kill hit a running job");
    println!(
        "killed 20 times (seed {seed}): 20 jobs ended once each, {retaken} taken up again, {failed} given up"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_worker_that_slept_past_its_lease_finishes_nothing() {
    let fleet = Fleet::new();
    let server = fleet.process(&["--role", "serve"]);
    // Enough that the job still runs when the signal comes.
    server.client.teach("hall", 0..60).await;
    let sleeper = fleet.process(&["--role", "train"]);
    let job = server.client.train("hall").await;
    let asleep = loop {
        let (_, body) = server.client.get(&job).await;
        if body["state"] == "running" {
            sleeper.process.signal("STOP");
            // It may have ended between the look and the signal.
            break server.client.get(&job).await.1;
        }
        assert_eq!(body["state"], "queued", "the job ended before it could be stopped: {body}");
    };
    assert_eq!(asleep["state"], "running", "the job ended before it could be stopped");
    let other = fleet.process(&["--role", "train"]);
    let ended = server.client.ended(&job).await;
    assert_eq!((&ended["state"], &ended["attempts"]), (&"succeeded".into(), &2.into()), "{ended}");
    assert_ne!(ended["worker"], asleep["worker"]);
    sleeper.process.signal("CONT");
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert_eq!(server.client.get(&job).await.1, ended);
    let states = states(&server.client, &job).await;
    assert_eq!(ends(&states), 1, "{states:?}");
    let (_, versions) = server.client.get("/v1/databases/hall/versions").await;
    assert_eq!(versions["items"].as_array().unwrap().len(), 1, "{versions}");
    drop(other);
}
