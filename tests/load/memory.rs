//! What a training takes into memory: little beside what it keeps.

use reqwest::Method;
use serde_json::json;

use crate::service::{Service, hall};

/// Pictures of the two databases, and what each takes to train beside what the process took before, at most. Held at once, the
/// signatures of the larger one alone would take three times as much.
const PICTURES: [u64; 2] = [60, 900];
const MOST_BYTES: u64 = 450 << 20;

/// The most memory that a process has had.
fn peak_bytes(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    peak.trim().strip_suffix(" kB").unwrap().parse::<u64>().unwrap() << 10
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "measures memory of a process of its own; run by .ci/run"]
async fn a_training_of_many_pictures_takes_little_more_memory_than_it_keeps() {
    let service = Service::start(&[]);
    for (number, pictures) in PICTURES.into_iter().enumerate() {
        let database = format!("halls-{number}");
        service.taught(&database, json!({}), &[]).await;
        for picture in 0..pictures {
            service.add(&database, &format!("place-{picture}"), &hall(picture)).await;
        }
        let before = peak_bytes(service.process.id());
        service.train(&database, json!({"calibration": "none"})).await;
        let version = service.send(Method::GET, &format!("/v1/databases/{database}/versions/1"), None).await;
        let windows = version["counts"]["interest_points"].as_u64().unwrap();
        let taken = peak_bytes(service.process.id()) - before;
        println!(
            "{pictures} pictures, {windows} windows: {} MiB more at the peak, {} bytes a window; {}",
            taken >> 20,
            taken / windows,
            version["report"]["timings_ms"]
        );
        assert!(taken < MOST_BYTES, "{taken}");
    }
}
