//! The bounded CPU pool: permit → run off the async runtime → answer; refuses when full.
//!
//! Three lanes, each with threads and memory of its own, so that none starves another. A lane holds at most
//! `threads` running and `waiting` waiting pieces of work; one more is refused at once, so a pile-up can't form.
//! Callers take turns: each has a queue of its own, and a full lane makes room for one who waits with less by refusing
//! the last piece of who waits with the most. Pictures also take what they need from the lane's budget of bytes before
//! they are decoded.

use std::collections::VecDeque;
use std::panic::AssertUnwindSafe;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{Semaphore, oneshot};
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

/// On whose behalf work is done: callers are treated alike, however much each of them asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Party {
    /// Who isn't told apart: everybody without a key, and the service itself.
    #[default]
    Anyone,
    /// Who calls with the key of this id.
    Key(u64),
}

tokio::task_local! {
    static PARTY: Party;
}

impl Party {
    /// On whose behalf this task runs: see [`on_behalf_of`].
    pub fn current() -> Self {
        PARTY.try_with(|party| *party).unwrap_or_default()
    }
}

/// Have everything that `future` computes done on behalf of that caller; tasks that it spawns are not its own.
pub fn on_behalf_of<F: Future>(party: Party, future: F) -> impl Future<Output = F::Output> {
    PARTY.scope(party, future)
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
    turns: Mutex<Turns>,
    threads: usize,
    /// Those in [`Turns`], and those that have a thread and wait for memory.
    waiting: AtomicUsize,
    most_waiting: usize,
    /// Mean time of a piece of work, lately.
    mean_us: AtomicU64,
    /// Counts units of [`MEMORY_UNIT_BYTES`].
    memory: Arc<Semaphore>,
    memory_units: u32,
}

/// Whose turn it is on a lane.
struct Turns {
    free_threads: usize,
    /// Those who wait, in the order of their turns. While anybody waits no thread is free.
    queues: VecDeque<Queue>,
    next_id: u64,
}

/// What waits on behalf of one caller; never empty.
struct Queue {
    party: Party,
    waiting: VecDeque<(u64, Call)>,
}

/// Tells who waits that it has a thread, or that it was refused after all.
type Call = oneshot::Sender<Result<Thread, ComputeError>>;

/// A thread of the lane for one piece of work, given to the next in turn when dropped.
struct Thread(Arc<LanePool>);

impl Drop for Thread {
    fn drop(&mut self) {
        let call = self.0.turns().next();
        if let Some(call) = call {
            // If it went away meanwhile, the thread comes back and drops here again.
            let _ = call.send(Ok(Self(Arc::clone(&self.0))));
        }
    }
}

impl Turns {
    /// Who has the thread that became free; none waits: it stays free.
    fn next(&mut self) -> Option<Call> {
        let Some(mut queue) = self.queues.pop_front() else {
            self.free_threads += 1;
            return None;
        };
        let (_, call) = queue.waiting.pop_front().expect("no queue is empty");
        if !queue.waiting.is_empty() {
            self.queues.push_back(queue);
        }
        Some(call)
    }

    /// Wait at the end of the caller's queue.
    fn join(&mut self, party: Party, call: Call) -> u64 {
        self.next_id += 1;
        let id = self.next_id;
        match self.queues.iter_mut().find(|queue| queue.party == party) {
            Some(queue) => queue.waiting.push_back((id, call)),
            None => self.queues.push_back(Queue { party, waiting: VecDeque::from([(id, call)]) }),
        }
        id
    }

    fn leave(&mut self, id: u64) {
        for queue in &mut self.queues {
            queue.waiting.retain(|(waiting, _)| *waiting != id);
        }
        self.queues.retain(|queue| !queue.waiting.is_empty());
    }

    /// Whether room can be made for one more of `party`: another caller waits with so much more that it is no worse
    /// off.
    fn displaces(&self, party: Party) -> bool {
        let own = self.queues.iter().find(|queue| queue.party == party);
        let own = own.map_or(0, |queue| queue.waiting.len());
        self.queues.iter().any(|queue| queue.waiting.len() > own + 1)
    }

    /// Make that room: the last of the caller with the most.
    fn displace(&mut self, party: Party) -> Option<Call> {
        if !self.displaces(party) {
            return None;
        }
        let (_, call) = self.queues.iter_mut().max_by_key(|queue| queue.waiting.len())?.waiting.pop_back()?;
        Some(call)
    }
}

/// Finer than any picture that matters, and coarse enough for the semaphore's counter.
const MEMORY_UNIT_BYTES: u64 = 64 << 10;
/// How much the mean time of a piece of work follows the latest one: one part in so many.
const MEAN_OVER: u64 = 16;
/// What a piece of work takes before one was seen: a frame of a busy robot camera.
const EXPECTED_US: u64 = 20_000;
/// How much nicer training is to others than recognition: at 10 the kernel gives it a tenth of a core that both want.
const TRAINING_NICENESS: i32 = 10;
/// Background work queues by itself, one job or body at a time, so its lanes need no tight bound.
const MOST_WAITING_IN_BACKGROUND: usize = 4096;

/// The pool; cheap to clone.
#[derive(Clone)]
pub struct Compute {
    recognition: Arc<LanePool>,
    training: Arc<LanePool>,
    upkeep: Arc<LanePool>,
}

/// A place in the queue of a lane; counted and kept for as long as it lives.
struct Place {
    lane: Arc<LanePool>,
    /// None: a thread was free.
    id: Option<u64>,
    called: oneshot::Receiver<Result<Thread, ComputeError>>,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.lane.waiting.fetch_sub(1, Ordering::Relaxed);
        if let Some(id) = self.id {
            self.lane.turns().leave(id);
        }
    }
}

impl Compute {
    /// Start the lanes: `threads` for recognition, the others as [`Lane`] says. Pictures may take `memory_bytes` in
    /// all: half of it in recognitions, a quarter in each other lane.
    ///
    /// # Errors
    /// The operating system starts no threads.
    pub fn new(threads: usize, waiting_per_thread: usize, memory_bytes: u64) -> Result<Self, ComputeError> {
        let lane = |name: &'static str, threads: usize, most_waiting: usize, memory_bytes: u64, niceness| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(move |n| format!("{name}-{n}"))
                .start_handler(move |_| lower_priority(niceness))
                .build()
                .map_err(|source| ComputeError::NoThreads { source })?;
            let memory_units = (memory_bytes / MEMORY_UNIT_BYTES).clamp(1, 1 << 24) as u32;
            Ok(Arc::new(LanePool {
                pool,
                turns: Mutex::new(Turns { free_threads: threads, queues: VecDeque::new(), next_id: 0 }),
                threads,
                waiting: AtomicUsize::new(0),
                most_waiting,
                mean_us: AtomicU64::new(EXPECTED_US),
                memory: Arc::new(Semaphore::new(memory_units as usize)),
                memory_units,
            }))
        };
        let (waiting, background) = (threads * waiting_per_thread, MOST_WAITING_IN_BACKGROUND);
        Ok(Self {
            recognition: lane("recognise", threads.max(1), waiting, memory_bytes / 2, 0)?,
            training: lane("train", (threads / 2).max(1), background, memory_bytes / 4, TRAINING_NICENESS)?,
            upkeep: lane("upkeep", 1, background, memory_bytes / 4, 0)?,
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
        lane.threads - lane.turns().free_threads
    }

    /// Whether the caller would be let in now; by the time it asks that may have changed.
    ///
    /// # Errors
    /// [`ComputeError::Full`] as of [`Compute::run`].
    pub fn room(&self, lane: Lane) -> Result<(), ComputeError> {
        let lane = self.lane(lane);
        let turns = lane.turns();
        match lane.full(&turns) {
            Some(full) if !turns.displaces(Party::current()) => Err(full),
            _ => Ok(()),
        }
    }

    /// Run `work` on a thread of the lane and return its value with the time it waited for the thread.
    ///
    /// `picture_bytes` is what the picture takes while it is worked on (0: no picture); it is taken from the
    /// lane's budget first. A picture larger than the whole budget gets all of it: it then runs alone.
    /// When whoever awaits it goes away while the work waits, the work is dropped unrun.
    ///
    /// # Errors
    /// [`ComputeError::Full`] when too much waits already, at once or when another caller needs the place; [`ComputeError::Panicked`] when `work` panicked.
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
        let place = lane.queue(Party::current())?;
        // A task of its own: a caller that isn't polled for a while must not sit on a permit it was given.
        let task = tokio::spawn(lane.wait_and_run(place, picture_bytes, work));
        match AbortOnDropHandle::new(task).await {
            Ok(done) => done,
            Err(error) => Err(ComputeError::Panicked { message: error.to_string() }),
        }
    }
}

impl LanePool {
    fn turns(&self) -> MutexGuard<'_, Turns> {
        self.turns.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A free thread, or a place to wait for one.
    fn queue(self: &Arc<Self>, party: Party) -> Result<Place, ComputeError> {
        let (call, called) = oneshot::channel();
        let mut turns = self.turns();
        let id = if turns.free_threads > 0 {
            turns.free_threads -= 1;
            // Can't fail: the receiver is here.
            let _ = call.send(Ok(Thread(Arc::clone(self))));
            None
        } else {
            if let Some(full) = self.full(&turns) {
                match turns.displace(party) {
                    // If it went away meanwhile, there is room all the same.
                    Some(call) => drop(call.send(Err(full))),
                    None => return Err(full),
                }
            }
            Some(turns.join(party, call))
        };
        self.waiting.fetch_add(1, Ordering::Relaxed);
        Ok(Place { lane: Arc::clone(self), id, called })
    }

    /// What is said to who finds no room; none while there is some.
    fn full(&self, turns: &Turns) -> Option<ComputeError> {
        let waiting = turns.queues.iter().map(|queue| queue.waiting.len()).sum::<usize>();
        let is_full = turns.free_threads == 0 && waiting >= self.most_waiting;
        is_full.then(|| ComputeError::Full { waiting, retry_after: self.work_off(waiting) })
    }

    /// How long so many pieces of work take, by what they took lately.
    fn work_off(&self, waiting: usize) -> Duration {
        Duration::from_micros(self.mean_us.load(Ordering::Relaxed) * waiting as u64 / self.threads as u64)
    }

    fn took(&self, time: Duration) {
        let mean = self.mean_us.load(Ordering::Relaxed);
        let follows = mean - mean / MEAN_OVER + time.as_micros() as u64 / MEAN_OVER;
        // Of two that end at once one may be forgotten: it's a mean.
        self.mean_us.store(follows, Ordering::Relaxed);
    }

    async fn wait_and_run<T, F>(
        self: Arc<Self>,
        mut place: Place,
        picture_bytes: u64,
        work: F,
    ) -> Result<(T, Duration), ComputeError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let arrived = Instant::now();
        let thread = (&mut place.called).await.expect("who leaves a queue is called or has gone away")?;
        place.id = None;
        let units = picture_bytes.div_ceil(MEMORY_UNIT_BYTES).min(u64::from(self.memory_units)) as u32;
        let memory = Arc::clone(&self.memory).acquire_many_owned(units).await.expect("never closed");
        drop(place);
        let queued = arrived.elapsed();
        let (answer, receive) = tokio::sync::oneshot::channel();
        self.pool.spawn(move || {
            let result = if answer.is_closed() {
                None
            } else {
                let begun = Instant::now();
                let result = std::panic::catch_unwind(AssertUnwindSafe(work));
                thread.0.took(begun.elapsed());
                Some(result)
            };
            drop((thread, memory));
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

/// Make the calling thread nicer to others; it matters only when there is more to do than cores. On Linux a thread has
/// a niceness of its own; elsewhere the whole process would get it.
fn lower_priority(niceness: i32) {
    #[cfg(target_os = "linux")]
    if niceness > 0 {
        // Being nicer is always allowed; if a sandbox forbids it, training is as it was.
        let _ = rustix::process::setpriority_process(None, niceness);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = niceness;
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

    use futures_util::future::BoxFuture;

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

    /// A lane of one thread that is held, and what releases it.
    async fn held_lane(waiting: usize) -> (Compute, mpsc::Sender<()>) {
        let compute = Compute::new(1, waiting, 1 << 20).unwrap();
        let (release, held) = mpsc::channel::<()>();
        tokio::spawn({
            let compute = compute.clone();
            async move { compute.run(Lane::Recognition, 0, move || held.recv().is_ok()).await.is_ok() }
        });
        while compute.running(Lane::Recognition) == 0 {
            tokio::task::yield_now().await;
        }
        (compute, release)
    }

    const FLOOD: Party = Party::Key(1);
    const STEADY: Party = Party::Key(2);

    #[tokio::test]
    async fn callers_take_turns_however_much_one_of_them_asks_for() {
        let (compute, release) = held_lane(100).await;
        let order = Arc::new(Mutex::new(Vec::new()));
        let ask = |party: Party| {
            let (compute, order) = (compute.clone(), Arc::clone(&order));
            tokio::spawn(on_behalf_of(party, async move {
                compute.run(Lane::Recognition, 0, move || order.lock().unwrap().push(party)).await.is_ok()
            }))
        };
        let mut asked: Vec<_> = (0..10).map(|_| ask(FLOOD)).collect();
        while compute.waiting(Lane::Recognition) < 10 {
            tokio::task::yield_now().await;
        }
        asked.extend((0..3).map(|_| ask(STEADY)));
        while compute.waiting(Lane::Recognition) < 13 {
            tokio::task::yield_now().await;
        }
        release.send(()).unwrap();
        for asked in asked {
            assert!(asked.await.unwrap());
        }
        let order = order.lock().unwrap();
        assert_eq!(order[..6], [FLOOD, STEADY, FLOOD, STEADY, FLOOD, STEADY]);
        assert_eq!(order.len(), 13);
    }

    #[tokio::test]
    async fn a_full_lane_makes_room_for_who_waits_with_less() {
        let (compute, release) = held_lane(4).await;
        let ask = |party| -> BoxFuture<'static, bool> {
            let compute = compute.clone();
            let asked = async move { compute.run(Lane::Recognition, 0, || ()).await.is_ok() };
            Box::pin(on_behalf_of(party, asked))
        };
        let mut flood: Vec<_> = (0..6).map(|_| ask(FLOOD)).collect();
        let mut steady: Vec<_> = (0..3).map(|_| ask(STEADY)).collect();
        let polled = |asked: &mut [BoxFuture<'static, bool>]| -> Vec<Poll<bool>> {
            let mut context = std::task::Context::from_waker(std::task::Waker::noop());
            asked.iter_mut().map(|asked| asked.as_mut().poll(&mut context)).collect()
        };
        let (waits, refused) = (Poll::Pending, Poll::Ready(false));
        assert_eq!(polled(&mut flood), [waits, waits, waits, waits, refused, refused]);
        // Two displace one each; a third would have more than the flood.
        assert_eq!(polled(&mut steady), [waits, waits, refused]);
        while compute.waiting(Lane::Recognition) > 4 {
            tokio::task::yield_now().await;
        }
        flood.truncate(4);
        steady.truncate(2);
        release.send(()).unwrap();
        let mut answers = Vec::new();
        for asked in flood.into_iter().chain(steady) {
            answers.push(asked.await);
        }
        assert_eq!(answers, [true, true, false, false, true, true]);
        assert_eq!((compute.waiting(Lane::Recognition), compute.running(Lane::Recognition)), (0, 0));
    }

    #[tokio::test]
    async fn the_time_to_come_back_is_what_the_queue_takes() {
        let compute = Compute::new(1, 1, 1 << 20).unwrap();
        for _ in 0..3 * MEAN_OVER {
            let work = || std::thread::sleep(Duration::from_millis(2));
            compute.run(Lane::Recognition, 0, work).await.unwrap();
        }
        let lane = compute.lane(Lane::Recognition);
        let one = lane.work_off(1);
        assert!(one >= Duration::from_millis(2) && one < Duration::from_micros(EXPECTED_US), "{one:?}");
        assert!(lane.work_off(100) >= 99 * one);
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn training_is_nicer_than_recognition() {
        let compute = Compute::new(2, 1, 1 << 20).unwrap();
        let niceness = || rustix::process::getpriority_process(None).unwrap();
        let own = niceness();
        assert_eq!(compute.run(Lane::Recognition, 0, niceness).await.unwrap().0, own);
        let lowered = compute.run(Lane::Training, 0, niceness).await.unwrap().0;
        assert_eq!(lowered, TRAINING_NICENESS.max(own));
    }
}
