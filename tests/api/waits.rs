//! Waits for a condition: it is checked again and again, up to a bound that only a broken service reaches.

use std::time::{Duration, Instant};

/// Longer than any wait of a test takes on a busy machine.
pub const BOUND: Duration = Duration::from_secs(60);
const INTERVAL: Duration = Duration::from_millis(2);

/// Returns when the condition holds; panics with `what` after [`BOUND`].
pub async fn until(what: &str, mut holds: impl AsyncFnMut() -> bool) {
    let started = Instant::now();
    while !holds().await {
        assert!(started.elapsed() < BOUND, "still not after {BOUND:?}: {what}");
        tokio::time::sleep(INTERVAL).await;
    }
}

/// As [`until`], for tests without a runtime.
#[track_caller]
pub fn until_blocking(what: &str, mut holds: impl FnMut() -> bool) {
    let started = Instant::now();
    while !holds() {
        assert!(started.elapsed() < BOUND, "still not after {BOUND:?}: {what}");
        std::thread::sleep(INTERVAL);
    }
}
