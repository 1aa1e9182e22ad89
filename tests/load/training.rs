//! A training beside a client that asks steadily.
//!
//! A training takes a core, and on a machine with few cores that shows. What it may cost beyond that is held against
//! the same client while a foreign process of ordinary priority keeps a core busy: the lost core.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use reqwest::Method;
use serde_json::json;

use crate::client::Client;
use crate::figures::{Times, load_lasts};
use crate::service::{Service, recognition, room};

/// Requests a second of the client that asks.
const STEADY: f64 = 10.0;

/// A process that keeps a core busy for as long as this lives.
struct Busy(Child);

impl Busy {
    fn start() -> Self {
        Self(Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap())
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "measures time on a machine of its own; run by .ci/run"]
async fn a_training_costs_recognition_little_more_than_a_lost_core() {
    let service = Service::start(&[]);
    service.taught("hall", json!({}), &(1..=6).map(room).collect::<Vec<_>>()).await;
    service.train("hall", json!({})).await;
    service
        .taught("school", json!({}), &(1..=60).map(|number| room(1000 + number)).collect::<Vec<_>>())
        .await;
    let request = recognition("hall", &room(1));
    let mut client = Client::connect(service.process.address()).await;
    let third = load_lasts() / 3;

    let alone = client.ask_at(&request, STEADY, Instant::now() + third).await;
    let busy = Busy::start();
    let lost_core = client.ask_at(&request, STEADY, Instant::now() + third).await;
    drop(busy);

    let mut beside = Vec::new();
    let until = Instant::now() + third;
    let mut revision = 0;
    while Instant::now() < until {
        // Another number of points is another version, so that it is trained anew.
        revision += 1;
        let options = json!({"options": {"interest_points": 60 + revision}});
        let job = service.begin_training("school", options).await;
        loop {
            let state = service.send(Method::GET, &job, None).await["state"].take();
            match state.as_str() {
                Some("queued") => tokio::time::sleep(Duration::from_millis(5)).await,
                Some("running") if Instant::now() < until => {
                    beside.extend(
                        client.ask_at(&request, STEADY, Instant::now() + Duration::from_millis(500)).await,
                    );
                }
                Some("running" | "succeeded") => break,
                _ => panic!("{state}"),
            }
        }
    }
    let [alone, lost_core, beside] = [&alone, &lost_core, &beside].map(Times::of);
    println!(
        "alone: {alone}\na core lost to another process: {lost_core}\nbeside {revision} trainings: {beside}"
    );
    let moved = beside.percentile(99).as_secs_f64() / lost_core.percentile(99).as_secs_f64();
    println!("p99 beside a training is {:.0} % of that with a core lost", moved * 100.0);
    assert!(moved < 3.0, "{moved}");
}
