//! What a landmark, a process and a robot cost: the figures that docs/operating.md, *Sizing*, reckons with, on drawn scenes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::fleet::Fleet;

const SCENES: u64 = 20;
const ROBOTS: u64 = 8;
const LOOK: Duration = Duration::from_secs(10);

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn landmarks_take_under_a_kilobyte_and_recognition_asks_postgresql_nothing() {
    let fleet = Fleet::new();
    let members = [fleet.process(&[]), fleet.process(&["--role", "serve"])];
    let [one, other] = [0, 1].map(|at: usize| &members[at].client);
    let (status, body) = one.put("/v1/databases/hall", &json!({"kind": "landmarks"})).await;
    assert_eq!(status, 201, "{body}");
    for number in 0..SCENES {
        one.teach_scene("hall", number).await;
    }
    let version = one.trained("hall").await;
    other.serves("hall", version).await;
    let (_, version) = one.get(&format!("/v1/databases/hall/versions/{version}")).await;
    let landmarks = version["counts"]["interest_points"].as_f64().unwrap();
    let metrics = other.text("/metrics").await;
    let held = metrics.lines().find_map(|line| line.strip_prefix("landmarkd_versions_loaded_bytes "));
    let in_memory = held.unwrap().parse::<f64>().unwrap() / landmarks;
    let in_file = version["artifact_bytes"].as_f64().unwrap() / landmarks;
    println!(
        "{landmarks} landmarks of {SCENES} scenes: {in_file:.0} bytes each in the artifact, {in_memory:.0} in memory"
    );
    assert!(in_file < 1024.0 && in_memory < 1024.0);

    // Until the statistics of the training have been written down.
    tokio::time::sleep(Duration::from_secs(3)).await;
    let idle = transactions_a_second(&fleet, async { tokio::time::sleep(LOOK).await }).await;
    let answers = Arc::new(AtomicU64::new(0));
    let robots = async {
        let until = Instant::now() + LOOK;
        let robots: Vec<_> = (0..ROBOTS)
            .map(|robot| {
                let (client, answers) = (members[robot as usize % 2].client.clone(), answers.clone());
                tokio::spawn(async move {
                    while Instant::now() < until {
                        assert_eq!(client.recognise("hall", robot).await.0, 200);
                        answers.fetch_add(1, Ordering::Relaxed);
                    }
                })
            })
            .collect();
        for robot in robots {
            robot.await.unwrap();
        }
    };
    let busy = transactions_a_second(&fleet, robots).await;
    let answers = answers.load(Ordering::Relaxed) as f64 / LOOK.as_secs_f64();
    println!(
        "two processes: {idle:.1} transactions a second idle; {ROBOTS} robots, {answers:.0} recognitions a second, \
         {busy:.1} transactions"
    );
    assert!(idle < 10.0 && busy < idle + 2.0, "{idle} {busy}");
}

async fn transactions_a_second(fleet: &Fleet, meanwhile: impl Future<Output = ()>) -> f64 {
    let (before, begun) = (fleet.transactions(), Instant::now());
    meanwhile.await;
    // A backend writes its statistics down when it falls idle, at most once a second.
    tokio::time::sleep(Duration::from_secs(1)).await;
    (fleet.transactions() - before) / begun.elapsed().as_secs_f64()
}
