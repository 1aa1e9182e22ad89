//! The bounded CPU pool: permit → run off the async runtime → answer; refuses when full.
//!
//! Two lanes, each with threads of its own, so that training never starves recognition: `Recognition` has one
//! thread a core (or `--threads`), `Training` half of that. A lane holds at most `threads` running and
//! `waiting` waiting pieces of work; one more is refused at once, so a pile-up can't form.
//! Pictures also take their decoded size from one common budget of bytes before they are decoded.

use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::Semaphore;

/// Which share of the pool a piece of work runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Work that a client waits for.
    Recognition,
    /// Work of background jobs.
    Training,
}

/// Why work was not done.
#[derive(Debug, thiserror::Error)]
pub enum ComputeError {
    /// Too much waits already; `retry_after` is when the present queue should be gone.
    #[error("all computing threads are busy and {waiting} requests wait already")]
    Full { waiting: usize, retry_after: Duration },
    /// The work panicked; the message is for the log, not for the client.
    #[error("the computation failed unexpectedly: {message}")]
    Panicked { message: String },
    /// The computing threads can't be started.
    #[error("can't start the computing threads")]
    NoThreads {
        #[source]
        source: rayon::ThreadPoolBuildError,
    },
}

struct LanePool {
    pool: rayon::ThreadPool,
    permits: Arc<Semaphore>,
    threads: usize,
    waiting: Arc<AtomicUsize>,
    most_waiting: usize,
}

/// The pool; cheap to clone.
#[derive(Clone)]
pub struct Compute {
    recognition: Arc<LanePool>,
    training: Arc<LanePool>,
    decode_bytes: Arc<Semaphore>,
    decode_unit_bytes: u64,
    decode_units: u32,
}

/// Counts itself in the queue of a lane for as long as it lives.
struct Waiting(Arc<AtomicUsize>);

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Compute {
    /// Start `threads` recognition threads and half as many training threads (at least one each).
    ///
    /// # Errors
    /// The operating system starts no threads.
    pub fn new(
        threads: usize,
        waiting_per_thread: usize,
        decode_bytes_total: u64,
    ) -> Result<Self, ComputeError> {
        let lane = |name: &'static str, threads: usize, most_waiting: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(move |n| format!("{name}-{n}"))
                .build()
                .map_err(|source| ComputeError::NoThreads { source })?;
            Ok(Arc::new(LanePool {
                pool,
                permits: Arc::new(Semaphore::new(threads)),
                threads,
                waiting: Arc::default(),
                most_waiting,
            }))
        };
        // The semaphore counts units of 64 KiB: finer than any picture that matters, and 1 GiB fits its counter.
        let decode_unit_bytes = 64 << 10;
        let decode_units = (decode_bytes_total / decode_unit_bytes).clamp(1, 1 << 24) as u32;
        Ok(Self {
            recognition: lane("recognise", threads.max(1), threads * waiting_per_thread)?,
            // Background work queues by itself (one job at a time), so its lane needs no tight bound.
            training: lane("train", (threads / 2).max(1), 4096)?,
            decode_bytes: Arc::new(Semaphore::new(decode_units as usize)),
            decode_unit_bytes,
            decode_units,
        })
    }

    fn lane(&self, lane: Lane) -> &LanePool {
        match lane {
            Lane::Recognition => &self.recognition,
            Lane::Training => &self.training,
        }
    }

    /// Threads of a lane.
    pub fn threads(&self, lane: Lane) -> usize {
        self.lane(lane).threads
    }

    /// Pieces of work that wait for a thread of the lane now.
    pub fn waiting(&self, lane: Lane) -> usize {
        self.lane(lane).waiting.load(Ordering::Relaxed)
    }

    /// Pieces of work that run on the lane now.
    pub fn running(&self, lane: Lane) -> usize {
        let lane = self.lane(lane);
        lane.threads - lane.permits.available_permits().min(lane.threads)
    }

    /// Run `work` on a thread of the lane and return its value with the time it waited for the thread.
    ///
    /// `picture_bytes` is what the picture takes while it is worked on (0: no picture); it is taken from the
    /// common budget first. A picture larger than the whole budget gets all of it: it then runs alone.
    /// When the caller goes away while the work waits, the work is dropped unrun.
    ///
    /// # Errors
    /// [`ComputeError::Full`] when too much waits already; [`ComputeError::Panicked`] when `work` panicked.
    pub async fn run<T, F>(
        &self,
        lane: Lane,
        picture_bytes: u64,
        work: F,
    ) -> Result<(T, Duration), ComputeError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let lane = self.lane(lane);
        let arrived = Instant::now();
        let permit = match Arc::clone(&lane.permits).try_acquire_owned() {
            Ok(permit) => permit,
            Err(_) => {
                let ahead = lane.waiting.fetch_add(1, Ordering::Relaxed);
                let _counted = Waiting(Arc::clone(&lane.waiting));
                if ahead >= lane.most_waiting {
                    return Err(ComputeError::Full {
                        waiting: ahead,
                        // 20 ms a frame is what a busy robot camera costs; the client's own jitter does the rest.
                        retry_after: Duration::from_millis(20 * ahead as u64 / lane.threads as u64),
                    });
                }
                let permit = Arc::clone(&lane.permits).acquire_owned().await;
                permit.expect("the semaphore is never closed")
            }
        };
        let units = picture_bytes.div_ceil(self.decode_unit_bytes).min(u64::from(self.decode_units)) as u32;
        let memory = Arc::clone(&self.decode_bytes).acquire_many_owned(units).await;
        let memory = memory.expect("the semaphore is never closed");
        let queued = arrived.elapsed();
        let (answer, receive) = tokio::sync::oneshot::channel();
        lane.pool.spawn(move || {
            let result = if answer.is_closed() {
                None
            } else {
                Some(std::panic::catch_unwind(AssertUnwindSafe(work)))
            };
            drop((permit, memory));
            if let Some(result) = result {
                // The receiver may have hung up meanwhile: then nobody needs the value.
                let _ = answer.send(result);
            }
        });
        match receive.await {
            Ok(Ok(value)) => Ok((value, queued)),
            Ok(Err(panic)) => Err(ComputeError::Panicked { message: panic_message(&*panic) }),
            Err(_) => Err(ComputeError::Panicked { message: "the computing thread went away".into() }),
        }
    }
}

/// The text a panic was raised with.
pub fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    panic
        .downcast_ref::<&str>()
        .map(ToString::to_string)
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[tokio::test]
    async fn a_full_lane_refuses_at_once_and_recovers() {
        let compute = Compute::new(1, 1, 1 << 20).unwrap();
        let (release, held) = mpsc::channel::<()>();
        let running = tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, move || held.recv()).await.is_ok() }
        });
        while compute.running(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        let waiting = tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, || 7).await.map(|(value, _)| value) }
        });
        while compute.waiting(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        let refused = compute.run(Lane::Recognition, 0, || 8).await;
        assert!(matches!(refused, Err(ComputeError::Full { waiting: 1, .. })));
        release.send(()).unwrap();
        assert!(running.await.unwrap());
        assert_eq!(waiting.await.unwrap().unwrap(), 7);
        assert_eq!(compute.run(Lane::Recognition, 0, || 9).await.unwrap().0, 9);
    }

    #[tokio::test]
    async fn a_panic_is_an_error_and_the_thread_lives_on() {
        let compute = Compute::new(1, 1, 1 << 20).unwrap();
        let panicked = compute.run(Lane::Recognition, 0, || panic!("on purpose")).await;
        let Err(ComputeError::Panicked { message }) = panicked.map(|((), _)| ()) else { panic!() };
        assert_eq!(message, "on purpose");
        assert_eq!(compute.run(Lane::Recognition, 0, || 1).await.unwrap().0, 1);
    }

    #[tokio::test]
    async fn a_caller_that_hangs_up_while_waiting_leaves_no_trace() {
        let compute = Compute::new(1, 4, 1 << 20).unwrap();
        let (release, held) = mpsc::channel::<()>();
        let first = tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, move || held.recv()).await.is_ok() }
        });
        while compute.running(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        let gone = tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, || ()).await.is_ok() }
        });
        while compute.waiting(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        gone.abort();
        let _ = gone.await;
        assert_eq!(compute.waiting(Lane::Recognition), 0);
        release.send(()).unwrap();
        assert!(first.await.unwrap());
    }
}
