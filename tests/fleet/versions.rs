//! What one process learns, all recognise.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::fleet::{Fleet, middle_and_most};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn what_is_posted_to_one_and_trained_by_another_is_recognised_by_all() {
    let fleet = Fleet::new();
    // Both find an empty catalogue: whoever comes second waits for the tables of the first.
    let (one, other) = std::thread::scope(|scope| {
        let one = scope.spawn(|| fleet.process(&["--role", "serve"]));
        let other = scope.spawn(|| fleet.process(&["--role", "all"]));
        (one.join().unwrap(), other.join().unwrap())
    });
    one.client.teach("hall", 0..6).await;
    let mut delays = Vec::new();
    for extra in 6..26 {
        one.client.teach_scene("hall", extra).await;
        let job = one.client.train("hall").await;
        let version = other.client.ended(&job).await["version"].as_i64().unwrap();
        delays.push(one.client.serves("hall", version).await);
        other.client.serves("hall", version).await;
        for member in [&one, &other] {
            let (status, answer) = member.client.recognise("hall", extra).await;
            assert_eq!((status, &answer["version"]), (200, &json!(version)), "{answer}");
            assert_eq!(answer["votes"][0]["label"], format!("place{extra}"), "{answer}");
        }
    }
    let (middle, most) = middle_and_most(delays);
    println!(
        "served by the other process after a training's end: median {middle:.3} s, most {most:.3} s of 20"
    );
    assert!(middle <= 0.5 && most <= 3.0, "{middle} {most}");

    let (_, info) = one.client.get("/v1/info").await;
    let processes = info["processes"].as_array().unwrap();
    assert_eq!(processes.len(), 2, "{info}");
    assert_eq!(processes[0]["worker"], info["worker"]);
    assert_eq!(processes[0]["role"], "serve");
    assert_eq!(processes[1]["role"], "all");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_change_that_nobody_was_told_of_is_served_within_three_seconds() {
    let fleet = Fleet::new();
    let member = fleet.process(&[]);
    member.client.teach("hall", 0..4).await;
    member.client.trained("hall").await;
    member.client.teach_scene("hall", 4).await;
    member.client.trained("hall").await;
    let mut delays = Vec::new();
    for change in 0..6 {
        let version = 1 + change % 2;
        // no notification goes with this
        fleet.change_catalogue(&format!("UPDATE aliases SET version = {version}, revision = revision + 1"));
        delays.push(member.client.serves("hall", version).await);
        tokio::time::sleep(Duration::from_millis(300 * change as u64)).await;
    }
    let (middle, most) = middle_and_most(delays);
    println!("served after a change without a notification: median {middle:.2} s, most {most:.2} s of 6");
    assert!(most <= 3.0, "{most}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn five_hundred_publishes_disturb_no_recognition() {
    let fleet = Fleet::new();
    let (one, other) = (fleet.process(&[]), fleet.process(&["--role", "serve"]));
    one.client.teach("hall", 0..4).await;
    let first = one.client.trained("hall").await;
    one.client.teach_scene("hall", 4).await;
    let second = one.client.trained("hall").await;
    other.client.serves("hall", second).await;
    let digest = |version: i64| {
        let client = one.client.clone();
        async move { client.get(&format!("/v1/databases/hall/versions/{version}")).await.1["digest"].clone() }
    };
    let digests = Arc::new([(first, digest(first).await), (second, digest(second).await)]);
    let resident = |member: &crate::fleet::Member| {
        let status = std::fs::read_to_string(format!("/proc/{}/status", member.process.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS")).unwrap();
        line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };

    let (done, answers) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
    let clients: Vec<_> = (0..8)
        .map(|number| {
            let client = if number % 2 == 0 { one.client.clone() } else { other.client.clone() };
            let (done, answers, digests) = (done.clone(), answers.clone(), digests.clone());
            tokio::spawn(async move {
                while !done.load(Ordering::Relaxed) {
                    let (status, answer) = client.recognise("hall", number % 4).await;
                    assert_eq!(status, 200, "{answer}");
                    let whole =
                        digests.iter().any(|(v, d)| answer["version"] == *v && answer["digest"] == *d);
                    assert!(whole, "{answer}");
                    answers.fetch_add(1, Ordering::Relaxed);
                }
            })
        })
        .collect();
    let mut before = [0; 2];
    let begun = Instant::now();
    for publish in 0..500 {
        if publish == 50 {
            before = [resident(&one), resident(&other)];
        }
        let version = if publish % 2 == 0 { first } else { second };
        let path = "/v1/databases/hall/aliases/current";
        let (status, body) = one.client.put(path, &json!({"version": version})).await;
        assert_eq!(status, 200, "{body}");
    }
    let took = begun.elapsed();
    done.store(true, Ordering::Relaxed);
    for client in clients {
        client.await.unwrap();
    }
    other.client.serves("hall", second).await;
    let after = [resident(&one), resident(&other)];
    println!(
        "500 publishes in {:.1} s, {} recognitions by 8 clients, none failed; memory {before:?} kB after 50, {after:?} kB after 500",
        took.as_secs_f64(),
        answers.load(Ordering::Relaxed),
    );
    for (before, after) in before.into_iter().zip(after) {
        assert!(after < before + 32 * 1024, "{before} kB grew to {after} kB");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_process_holds_what_it_is_to_serve_and_answers_for_the_rest_when_asked() {
    let fleet = Fleet::new();
    let (all, floor) = (fleet.process(&[]), fleet.process(&["--role", "serve", "--serve", "floor-*"]));
    for database in ["floor-1", "cellar"] {
        all.client.teach(database, 0..3).await;
        all.client.trained(database).await;
    }
    floor.client.serves("floor-1", 1).await;
    let (_, ready) = floor.client.get("/readyz").await;
    assert_eq!(ready["databases"].as_array().unwrap().len(), 1, "{ready}");
    let (status, answer) = floor.client.recognise("cellar", 1).await;
    assert_eq!((status, &answer["votes"][0]["label"]), (200, &json!("place1")), "{answer}");
    // deleted and made anew elsewhere, it isn't answered for by what was loaded before
    assert_eq!(all.client.delete("/v1/databases/cellar").await, 204);
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert_eq!(floor.client.recognise("cellar", 1).await.0, 404);
    all.client.teach("cellar", 10..13).await;
    all.client.trained("cellar").await;
    let (_, answer) = floor.client.recognise("cellar", 11).await;
    assert_eq!(answer["votes"][0]["label"], "place11", "{answer}");
}
