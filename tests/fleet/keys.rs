//! Keys of a fleet: made with one process, taken by all; revoked with one, refused by all at once.

use std::time::{Duration, Instant};

use serde_json::json;

use crate::fleet::{Client, Fleet, middle_and_most};
use crate::postgres::Stop;

const ROUNDS: usize = 20;

/// How long until an answer to this client has that status.
async fn until(client: &Client, status: u16) -> Duration {
    let begun = Instant::now();
    while client.get("/v1/info").await.0 != status {
        assert!(begun.elapsed() < Duration::from_secs(20), "no {status} for {:?}", begun.elapsed());
    }
    begun.elapsed()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn a_key_revoked_with_one_process_is_refused_by_every_other_at_once() {
    let fleet = Fleet::new();
    let (one, other) = (fleet.process(&["--role", "serve"]), fleet.process(&["--role", "serve"]));
    let key = fleet.key("operator", "admin");
    let admin = one.client.with_key(&key);
    // Both ask for keys as soon as they have heard of the first.
    until(&one.client, 401).await;
    until(&other.client, 401).await;

    let (mut taken, mut refused) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        let new = json!({"name": format!("robot {round}"), "scope": "recognise"});
        let (status, made) = admin.post("/v1/keys", &new).await;
        assert_eq!(status, 201, "{made}");
        let robot = other.client.with_key(made["key"].as_str().unwrap());
        taken.push(until(&robot, 200).await);
        assert_eq!(admin.delete(&format!("/v1/keys/{}", made["id"].as_str().unwrap())).await, 204);
        refused.push(until(&robot, 401).await);
    }
    let (middle, most) = middle_and_most(taken);
    println!("a key is taken by the other process after: median {middle:.4} s, most {most:.4} s of {ROUNDS}");
    let (middle, most) = middle_and_most(refused);
    println!("and refused after its revocation: median {middle:.4} s, most {most:.4} s of {ROUNDS}");
    assert!(most <= 3.0, "{most}");

    // What was known stays in force while PostgreSQL is away; nobody is let in who wasn't.
    fleet.cluster.stop(Stop::Immediate);
    let operator = other.client.with_key(&key);
    for _ in 0..20 {
        assert_eq!((operator.get("/v1/info").await.0, other.client.get("/v1/info").await.0), (200, 401));
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    assert_eq!(operator.post("/v1/keys", &json!({"name": "late", "scope": "admin"})).await.0, 503);
    fleet.cluster.start();
    until(&operator, 200).await;
    let (_, record) = operator.get("/v1/audit?limit=1000").await;
    let revoked = record["items"].as_array().unwrap().iter().filter(|item| item["action"] == "key.revoke");
    assert_eq!(revoked.count(), ROUNDS);
}
