//! A fleet of robots that all post at once.

use std::collections::HashSet;
use std::time::Instant;

use serde_json::json;

use crate::fleet::Fleet;
use crate::pictures::{png, scene};

/// Each posts so many; `LANDMARKD_FLEET_EXEMPLARS` asks for more in all.
const ROBOTS: u64 = 50;
const EXEMPLARS: u64 = 1000;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL and moto_server; run by .ci/run"]
async fn what_fifty_robots_post_at_once_is_all_there_and_none_of_it_twice() {
    let all = std::env::var("LANDMARKD_FLEET_EXEMPLARS").map_or(EXEMPLARS, |n| n.parse().unwrap());
    let fleet = Fleet::new();
    let members = [fleet.process(&["--role", "serve"]), fleet.process(&["--role", "serve"])];
    members[0].client.put("/v1/databases/city", &json!({"kind": "landmarks"})).await;
    let begun = Instant::now();
    let robots = (0..ROBOTS).map(|robot| {
        let client = members[robot as usize % 2].client.clone();
        tokio::spawn(async move {
            let mut ids = Vec::new();
            for number in 0..all / ROBOTS {
                let label = format!("place{}", number % 10);
                let path = format!("/v1/databases/city/exemplars?label={label}");
                let picture = png(&scene(robot * 1_000_000 + number));
                // the same once more, as a robot does that heard no answer
                for _ in 0..1 + usize::from(number % 10 == 0) {
                    let (status, body) = client.post_picture(&path, picture.clone()).await;
                    assert!(status == 200 || status == 201, "{status} {body}");
                    ids.push(body["id"].as_str().unwrap().to_owned());
                }
            }
            ids
        })
    });
    let robots: Vec<_> = robots.collect();
    let mut connections = 0;
    let mut acknowledged = HashSet::new();
    for robot in robots {
        acknowledged.extend(robot.await.unwrap());
        connections = connections.max(fleet.cluster.connections());
    }
    let took = begun.elapsed().as_secs_f64();
    let (_, counts) = members[1].client.get("/v1/databases/city").await;
    assert_eq!(acknowledged.len() as u64, all);
    assert_eq!(counts["exemplars"], all, "{counts}");
    println!(
        "{all} exemplars of {ROBOTS} robots through two processes in {took:.1} s, {:.0} a second; \
         connections to PostgreSQL: {connections} at most",
        all as f64 / took
    );
    assert!(connections <= 20, "{connections}");
}
