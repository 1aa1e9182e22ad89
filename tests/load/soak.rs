//! Days of work in minutes: memory and open files are afterwards what they were.

use std::time::Instant;

use reqwest::Method;
use serde_json::json;

use crate::client::Client;
use crate::figures::{memory_bytes, number, open_files};
use crate::service::{Service, recognition, tiny, tiny_pictures};

/// Recognitions after which everything that is kept for good should be there.
const WARM: u64 = 1000;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "takes minutes; run by .ci/run"]
async fn memory_and_open_files_stay_what_they_were() {
    let recognitions: u64 = number("LANDMARKD_LOAD_RECOGNITIONS", 50_000);
    let publishes: u64 = number("LANDMARKD_LOAD_PUBLISHES", 200);
    let service = Service::start(&[]);
    let id = service.process.id();
    let pictures = tiny_pictures(12);
    service.taught("lab", tiny(), &pictures[..8]).await;
    service.train("lab", json!({})).await;
    for (number, picture) in pictures[8..].iter().enumerate() {
        service.add("lab", &format!("late-{number}"), picture).await;
    }
    service.train("lab", json!({})).await;
    let requests: Vec<_> = pictures.iter().map(|picture| recognition("lab", picture)).collect();
    let mut clients = Vec::new();
    for _ in 0..4 {
        clients.push(Client::connect(service.process.address()).await);
    }
    let mut asked = 0;
    let mut work = async |until: u64, publish_every: u64| {
        while asked < until {
            let asking = clients.iter_mut().zip(requests.iter().cycle().skip(asked as usize % 7));
            let answers =
                futures_util::future::join_all(asking.map(|(client, request)| client.ask(request))).await;
            assert!(answers.iter().all(|answer| answer.status == 200));
            let before = asked;
            asked += answers.len() as u64;
            if before / publish_every != asked / publish_every {
                let version = json!({"version": asked / publish_every % 2 + 1});
                service.send(Method::PUT, "/v1/databases/lab/aliases/current", Some(&version)).await;
            }
        }
    };
    work(WARM, WARM / 10).await;
    let (memory, files) = (memory_bytes(id, "VmRSS"), open_files(id));
    let begun = Instant::now();
    work(recognitions, (recognitions / publishes).max(1)).await;
    let (memory_after, files_after) = (memory_bytes(id, "VmRSS"), open_files(id));
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    println!(
        "after {WARM} recognitions: {:.1} MiB, {files} open files; after {recognitions} and {publishes} publishes \
         ({:.0} s): {:.1} MiB, {files_after} open files",
        mib(memory),
        begun.elapsed().as_secs_f64(),
        mib(memory_after)
    );
    assert!(memory_after < memory + memory / 4 + (16 << 20));
    assert!(files_after <= files + 8);
}
