//! The bounded CPU pool: permit → run off the async runtime → answer; refuses when full.
//!
//! Three lanes, each with threads and memory of its own, so that none starves another. A lane holds at most
//! `threads` running and `waiting` waiting pieces of work; one more is refused at once, so a pile-up can't form.
//! Pictures also take what they need from the lane's budget of bytes before they are decoded.

use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use tokio::sync::Semaphore;
use tokio_util::task::AbortOnDropHandle;

/// Which share of the pool a piece of work runs on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Recognitions: one thread a core, or `--threads`.
    Recognition,
    /// Background jobs: half as many.
    Training,
    /// Checking uploaded pictures and loading versions: one thread.
    Upkeep,
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
    waiting: AtomicUsize,
    most_waiting: usize,
    /// Counts units of [`MEMORY_UNIT_BYTES`].
    memory: Arc<Semaphore>,
    memory_units: u32,
}

/// Finer than any picture that matters, and coarse enough for the semaphore's counter.
const MEMORY_UNIT_BYTES: u64 = 64 << 10;
/// Background work queues by itself, one job or body at a time, so its lanes need no tight bound.
const MOST_WAITING_IN_BACKGROUND: usize = 4096;

/// The pool; cheap to clone.
#[derive(Clone)]
pub struct Compute {
    recognition: Arc<LanePool>,
    training: Arc<LanePool>,
    upkeep: Arc<LanePool>,
}

/// Counts itself in the queue of a lane for as long as it lives.
struct Waiting(Arc<LanePool>);

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.waiting.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Compute {
    /// Start the lanes: `threads` for recognition, the others as [`Lane`] says. Pictures may take `memory_bytes` in
    /// all: half of it in recognitions, a quarter in each other lane.
    ///
    /// # Errors
    /// The operating system starts no threads.
    pub fn new(threads: usize, waiting_per_thread: usize, memory_bytes: u64) -> Result<Self, ComputeError> {
        let lane = |name: &'static str, threads: usize, most_waiting: usize, memory_bytes: u64| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(move |n| format!("{name}-{n}"))
                .build()
                .map_err(|source| ComputeError::NoThreads { source })?;
            let memory_units = (memory_bytes / MEMORY_UNIT_BYTES).clamp(1, 1 << 24) as u32;
            Ok(Arc::new(LanePool {
                pool,
                permits: Arc::new(Semaphore::new(threads)),
                threads,
                waiting: AtomicUsize::new(0),
                most_waiting,
                memory: Arc::new(Semaphore::new(memory_units as usize)),
                memory_units,
            }))
        };
        let background = MOST_WAITING_IN_BACKGROUND;
        Ok(Self {
            recognition: lane("recognise", threads.max(1), threads * waiting_per_thread, memory_bytes / 2)?,
            training: lane("train", (threads / 2).max(1), background, memory_bytes / 4)?,
            upkeep: lane("upkeep", 1, background, memory_bytes / 4)?,
        })
    }

    fn lane(&self, lane: Lane) -> &Arc<LanePool> {
        match lane {
            Lane::Recognition => &self.recognition,
            Lane::Training => &self.training,
            Lane::Upkeep => &self.upkeep,
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
    /// lane's budget first. A picture larger than the whole budget gets all of it: it then runs alone.
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
        let lane = Arc::clone(self.lane(lane));
        // Who is about to take a free permit counts as waiting until it has it.
        let free = lane.permits.available_permits();
        let ahead = lane.waiting.fetch_add(1, Ordering::Relaxed);
        let counted = Waiting(Arc::clone(&lane));
        if ahead >= lane.most_waiting + free {
            return Err(ComputeError::Full {
                waiting: ahead,
                // 20 ms a frame is what a busy robot camera costs; the client's own jitter does the rest.
                retry_after: Duration::from_millis(20 * ahead as u64 / lane.threads as u64),
            });
        }
        // A task of its own: a caller that isn't polled for a while must not sit on a permit it was given.
        let task = tokio::spawn(lane.wait_and_run(counted, picture_bytes, work));
        match AbortOnDropHandle::new(task).await {
            Ok(done) => done,
            Err(error) => Err(ComputeError::Panicked { message: error.to_string() }),
        }
    }
}

impl LanePool {
    async fn wait_and_run<T, F>(
        self: Arc<Self>,
        counted: Waiting,
        picture_bytes: u64,
        work: F,
    ) -> Result<(T, Duration), ComputeError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let arrived = Instant::now();
        let permit = Arc::clone(&self.permits).acquire_owned().await.expect("never closed");
        let units = picture_bytes.div_ceil(MEMORY_UNIT_BYTES).min(u64::from(self.memory_units)) as u32;
        let memory = Arc::clone(&self.memory).acquire_many_owned(units).await.expect("never closed");
        drop(counted);
        let queued = arrived.elapsed();
        let (answer, receive) = tokio::sync::oneshot::channel();
        self.pool.spawn(move || {
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
    use std::task::Poll;

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
    async fn a_burst_is_refused_even_before_anything_runs() {
        let compute = Compute::new(1, 2, 1 << 20).unwrap();
        let mut burst: Vec<_> = (0..10).map(|_| Box::pin(compute.run(Lane::Recognition, 0, || ()))).collect();
        let mut refused = 0;
        for caller in &mut burst {
            let answer = futures_util::poll!(caller);
            refused += usize::from(matches!(answer, Poll::Ready(Err(ComputeError::Full { .. }))));
        }
        // One has the free thread, two wait.
        assert_eq!(refused, 7);
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
    async fn a_caller_that_is_not_polled_holds_nobody_up() {
        let compute = Compute::new(1, 4, 1 << 20).unwrap();
        let (release, held) = mpsc::channel::<()>();
        let first = tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, move || held.recv()).await.is_ok() }
        });
        while compute.running(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        let mut idle = Box::pin(compute.run(Lane::Recognition, 0, || 1));
        assert!(futures_util::poll!(&mut idle).is_pending());
        release.send(()).unwrap();
        assert!(first.await.unwrap());
        // The idle caller's turn came and passed without it.
        assert_eq!(compute.run(Lane::Recognition, 0, || 2).await.unwrap().0, 2);
        assert_eq!(idle.await.unwrap().0, 1);
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
        while compute.waiting(Lane::Recognition) > 0 {
            tokio::task::yield_now().await;
        }
        release.send(()).unwrap();
        assert!(first.await.unwrap());
    }
}
