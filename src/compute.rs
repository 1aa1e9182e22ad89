//! The bounded CPU pool: permit → run off the async runtime → answer; refuses when full.
//!
//! Three lanes, each with threads and memory of its own, so that none starves another. A lane holds at most
//! `threads` running and `most_waiting` waiting pieces of work; one more is refused at once, so a pile-up can't form.
//! Permits are given by fair queueing: each principal has a flow of its own, and the flows are served round robin. A
//! full lane makes room for a principal that waits with less by refusing the last piece of the one that waits with the
//! most. Pictures also take what they need from the lane's budget of bytes before they are decoded.

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
    Maintenance,
}

/// On whose behalf work is done: principals are treated alike, however much each of them asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Principal {
    /// Everybody without a key, and the service itself.
    #[default]
    Anyone,
    /// Whoever calls with the key of this id.
    Key(u64),
}

tokio::task_local! {
    static PRINCIPAL: Principal;
}

impl Principal {
    /// The principal of this task: see [`on_behalf_of`].
    pub fn current() -> Self {
        PRINCIPAL.try_with(|principal| *principal).unwrap_or_default()
    }
}

/// Runs `future` with that principal; tasks that it spawns don't have it.
pub fn on_behalf_of<F: Future>(principal: Principal, future: F) -> impl Future<Output = F::Output> {
    PRINCIPAL.scope(principal, future)
}

/// Why work was not done.
#[derive(Debug, thiserror::Error)]
pub enum ComputeError {
    /// Too much waits already.
    #[error("all computing threads are busy and {waiting} requests wait already")]
    Full {
        /// Pieces of work that wait.
        waiting: usize,
        /// How long they are expected to take.
        retry_after: Duration,
    },
    /// The work panicked.
    #[error("the computation failed unexpectedly: {message}")]
    Panicked {
        /// For the log, not for the client.
        message: String,
    },
    /// The computing threads can't be started.
    #[error("can't start the computing threads")]
    NoThreads {
        /// What the operating system says.
        #[source]
        source: rayon::ThreadPoolBuildError,
    },
}

struct LanePool {
    pool: rayon::ThreadPool,
    queue: Mutex<FairQueue>,
    threads: usize,
    /// Pieces of work in the queue, and those that have a permit and wait for memory.
    waiting: AtomicUsize,
    most_waiting: usize,
    /// Moving average of the time of a piece of work.
    mean_us: AtomicU64,
    /// Counts units of [`MEMORY_UNIT_BYTES`].
    memory: Arc<Semaphore>,
    memory_units: u32,
}

/// The queue for a lane's permits: one flow a principal, served round robin.
struct FairQueue {
    /// Zero while any flow waits.
    free_threads: usize,
    /// In the order in which they are served next.
    flows: VecDeque<Flow>,
    next_id: u64,
}

/// What waits on behalf of one principal, first come, first served; never empty.
struct Flow {
    principal: Principal,
    waiting: VecDeque<Waiting>,
}

/// A piece of work that waits for a permit.
struct Waiting {
    id: u64,
    answer: Answer,
}

/// Gives a piece of work its permit, or refuses it after all.
type Answer = oneshot::Sender<Result<Permit, ComputeError>>;

/// A thread of the lane for one piece of work; dropped, it goes to the next in the queue.
struct Permit(Arc<LanePool>);

impl Drop for Permit {
    fn drop(&mut self) {
        let next = self.0.queue().next();
        if let Some(answer) = next {
            // If nobody waits for it any more, the permit comes back and is dropped here again.
            let _ = answer.send(Ok(Self(Arc::clone(&self.0))));
        }
    }
}

impl FairQueue {
    /// The piece of work that gets the thread that became free; the thread stays free when none waits.
    fn next(&mut self) -> Option<Answer> {
        let Some(mut flow) = self.flows.pop_front() else {
            self.free_threads += 1;
            return None;
        };
        let next = flow.waiting.pop_front().expect("no flow is empty");
        if !flow.waiting.is_empty() {
            self.flows.push_back(flow);
        }
        Some(next.answer)
    }

    /// Puts a piece of work at the end of its principal's flow; returns its id.
    fn push(&mut self, principal: Principal, answer: Answer) -> u64 {
        self.next_id += 1;
        let waiting = Waiting { id: self.next_id, answer };
        match self.flows.iter_mut().find(|flow| flow.principal == principal) {
            Some(flow) => flow.waiting.push_back(waiting),
            None => self.flows.push_back(Flow { principal, waiting: VecDeque::from([waiting]) }),
        }
        self.next_id
    }

    fn remove(&mut self, id: u64) {
        for flow in &mut self.flows {
            flow.waiting.retain(|waiting| waiting.id != id);
        }
        self.flows.retain(|flow| !flow.waiting.is_empty());
    }

    fn waiting(&self) -> usize {
        self.flows.iter().map(|flow| flow.waiting.len()).sum()
    }

    /// Whether room can be made for one more of `principal`: another waits with so much more that it is no worse off.
    fn can_displace(&self, principal: Principal) -> bool {
        let own = self.flows.iter().find(|flow| flow.principal == principal);
        let own = own.map_or(0, |flow| flow.waiting.len());
        self.flows.iter().any(|flow| flow.waiting.len() > own + 1)
    }

    /// Takes out the last piece of work of the longest flow, if that makes room for one of `principal`.
    fn displace(&mut self, principal: Principal) -> Option<Answer> {
        if !self.can_displace(principal) {
            return None;
        }
        let longest = self.flows.iter_mut().max_by_key(|flow| flow.waiting.len())?;
        Some(longest.waiting.pop_back()?.answer)
    }
}

/// Finer than any picture that matters, and coarse enough for the semaphore's counter.
const MEMORY_UNIT_BYTES: u64 = 64 << 10;
/// Inverse weight of the latest piece of work in the moving average of their times.
const MEAN_OVER: u64 = 16;
/// Assumed time of a piece of work before one was measured: a frame of a busy robot camera.
const EXPECTED_US: u64 = 20_000;
/// Niceness of training: at 10 the kernel gives it a tenth of a core that recognition wants too.
const TRAINING_NICENESS: i32 = 10;
/// Background work queues by itself, one job or body at a time, so its lanes need no tight bound.
const MOST_WAITING_IN_BACKGROUND: usize = 4096;

/// The pool; cheap to clone.
#[derive(Clone)]
pub struct Compute {
    recognition: Arc<LanePool>,
    training: Arc<LanePool>,
    maintenance: Arc<LanePool>,
}

/// A place in the queue of a lane; counted until it is dropped.
struct Ticket {
    lane: Arc<LanePool>,
    /// None: it has its permit.
    id: Option<u64>,
    permit: oneshot::Receiver<Result<Permit, ComputeError>>,
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.lane.waiting.fetch_sub(1, Ordering::Relaxed);
        if let Some(id) = self.id {
            self.lane.queue().remove(id);
        }
    }
}

impl Compute {
    /// Starts the lanes: `threads` for recognition, the others as [`Lane`] says. Pictures may take `memory_bytes` in
    /// all: half of it in recognitions, a quarter in each other lane.
    ///
    /// # Errors
    /// The operating system starts no threads.
    pub fn new(threads: usize, waiting_per_thread: usize, memory_bytes: u64) -> Result<Self, ComputeError> {
        let (waiting, background) = (threads * waiting_per_thread, MOST_WAITING_IN_BACKGROUND);
        let (half, quarter) = (memory_bytes / 2, memory_bytes / 4);
        Ok(Self {
            recognition: LanePool::start("recognise", threads.max(1), waiting, half, 0)?,
            training: LanePool::start("train", (threads / 2).max(1), background, quarter, TRAINING_NICENESS)?,
            maintenance: LanePool::start("maintenance", 1, background, quarter, 0)?,
        })
    }

    fn lane(&self, lane: Lane) -> &Arc<LanePool> {
        match lane {
            Lane::Recognition => &self.recognition,
            Lane::Training => &self.training,
            Lane::Maintenance => &self.maintenance,
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
        lane.threads - lane.queue().free_threads
    }

    /// Whether the lane would take work of the current principal now; by the time it asks that may have changed.
    ///
    /// # Errors
    /// [`ComputeError::Full`] as of [`Compute::run`].
    pub fn room(&self, lane: Lane) -> Result<(), ComputeError> {
        let lane = self.lane(lane);
        let queue = lane.queue();
        match lane.refusal(&queue) {
            Some(full) if !queue.can_displace(Principal::current()) => Err(full),
            _ => Ok(()),
        }
    }

    /// Runs `work` on a thread of the lane and returns its value with the time that it waited for the thread.
    ///
    /// `picture_bytes` is what the picture takes while it is worked on (0: no picture); it is taken from the
    /// lane's budget first. A picture larger than the whole budget gets all of it: it then runs alone.
    /// When the returned future is dropped while the work waits, the work is dropped unrun.
    ///
    /// # Errors
    /// [`ComputeError::Full`] when too much waits already, at once or when another principal needs the place;
    /// [`ComputeError::Panicked`] when `work` panicked.
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
        let ticket = lane.enqueue(Principal::current())?;
        // A task of its own: a future that isn't polled for a while must not sit on its permit.
        let task = tokio::spawn(lane.wait_and_run(ticket, picture_bytes, work));
        match AbortOnDropHandle::new(task).await {
            Ok(done) => done,
            Err(error) => Err(ComputeError::Panicked { message: error.to_string() }),
        }
    }
}

impl LanePool {
    fn start(
        name: &'static str,
        threads: usize,
        most_waiting: usize,
        memory_bytes: u64,
        niceness: i32,
    ) -> Result<Arc<Self>, ComputeError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(move |n| format!("{name}-{n}"))
            .start_handler(move |_| lower_priority(niceness))
            .build()
            .map_err(|source| ComputeError::NoThreads { source })?;
        let memory_units = (memory_bytes / MEMORY_UNIT_BYTES).clamp(1, 1 << 24) as u32;
        Ok(Arc::new(Self {
            pool,
            queue: Mutex::new(FairQueue { free_threads: threads, flows: VecDeque::new(), next_id: 0 }),
            threads,
            waiting: AtomicUsize::new(0),
            most_waiting,
            mean_us: AtomicU64::new(EXPECTED_US),
            memory: Arc::new(Semaphore::new(memory_units as usize)),
            memory_units,
        }))
    }

    fn queue(&self) -> MutexGuard<'_, FairQueue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A ticket with a permit while a thread is free, else with a place in the queue.
    fn enqueue(self: &Arc<Self>, principal: Principal) -> Result<Ticket, ComputeError> {
        let (answer, permit) = oneshot::channel();
        let mut queue = self.queue();
        let id = if queue.free_threads > 0 {
            queue.free_threads -= 1;
            // Can't fail: the receiver is here.
            let _ = answer.send(Ok(Permit(Arc::clone(self))));
            None
        } else {
            if let Some(full) = self.refusal(&queue) {
                match queue.displace(principal) {
                    // If nobody waits for it any more, there is room all the same.
                    Some(displaced) => drop(displaced.send(Err(full))),
                    None => return Err(full),
                }
            }
            Some(queue.push(principal, answer))
        };
        self.waiting.fetch_add(1, Ordering::Relaxed);
        Ok(Ticket { lane: Arc::clone(self), id, permit })
    }

    /// The error of a full lane; none while there is room.
    fn refusal(&self, queue: &FairQueue) -> Option<ComputeError> {
        let waiting = queue.waiting();
        let is_full = queue.free_threads == 0 && waiting >= self.most_waiting;
        is_full.then(|| ComputeError::Full { waiting, retry_after: self.time_for(waiting) })
    }

    /// How long so many pieces of work are expected to take.
    fn time_for(&self, waiting: usize) -> Duration {
        Duration::from_micros(self.mean_us.load(Ordering::Relaxed) * waiting as u64 / self.threads as u64)
    }

    fn update_mean(&self, took: Duration) {
        let mean = self.mean_us.load(Ordering::Relaxed);
        let follows = mean - mean / MEAN_OVER + took.as_micros() as u64 / MEAN_OVER;
        // Of two that end at once one may be lost: it's a mean.
        self.mean_us.store(follows, Ordering::Relaxed);
    }

    async fn wait_and_run<T, F>(
        self: Arc<Self>,
        mut ticket: Ticket,
        picture_bytes: u64,
        work: F,
    ) -> Result<(T, Duration), ComputeError>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        let arrived = Instant::now();
        let permit = (&mut ticket.permit).await.expect("a ticket is answered or dropped")?;
        ticket.id = None;
        let units = picture_bytes.div_ceil(MEMORY_UNIT_BYTES).min(u64::from(self.memory_units)) as u32;
        let memory = Arc::clone(&self.memory).acquire_many_owned(units).await.expect("never closed");
        drop(ticket);
        let queued = arrived.elapsed();
        let (sender, receiver) = oneshot::channel();
        self.pool.spawn(move || {
            let result = (!sender.is_closed()).then(|| {
                let begun = Instant::now();
                let result = std::panic::catch_unwind(AssertUnwindSafe(work));
                permit.0.update_mean(begun.elapsed());
                result
            });
            drop((permit, memory));
            if let Some(result) = result {
                // The receiver may be gone meanwhile: then nobody needs the value.
                let _ = sender.send(result);
            }
        });
        match receiver.await {
            Ok(Ok(value)) => Ok((value, queued)),
            Ok(Err(panic)) => Err(ComputeError::Panicked { message: panic_message(&*panic) }),
            Err(_) => Err(ComputeError::Panicked { message: "the computing thread went away".into() }),
        }
    }
}

/// Raises the niceness of the calling thread, which matters only when there is more to do than cores. On Linux a thread
/// has a niceness of its own; elsewhere the whole process would get it.
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

    const FLOOD: Principal = Principal::Key(1);
    const STEADY: Principal = Principal::Key(2);

    #[tokio::test]
    async fn principals_are_served_round_robin_however_much_one_of_them_asks_for() {
        let (compute, release) = held_lane(100).await;
        let order = Arc::new(Mutex::new(Vec::new()));
        let ask = |principal: Principal| {
            let (compute, order) = (compute.clone(), Arc::clone(&order));
            tokio::spawn(on_behalf_of(principal, async move {
                compute.run(Lane::Recognition, 0, move || order.lock().unwrap().push(principal)).await.is_ok()
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
    async fn a_full_lane_makes_room_for_the_principal_that_waits_with_less() {
        let (compute, release) = held_lane(4).await;
        let ask = |principal| -> BoxFuture<'static, bool> {
            let compute = compute.clone();
            let asked = async move { compute.run(Lane::Recognition, 0, || ()).await.is_ok() };
            Box::pin(on_behalf_of(principal, asked))
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
        let one = lane.time_for(1);
        assert!(one >= Duration::from_millis(2) && one < Duration::from_micros(EXPECTED_US), "{one:?}");
        assert!(lane.time_for(100) >= 99 * one);
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
