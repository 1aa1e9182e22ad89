//! What happens in this process, as it happens: decisions, versions that are swapped in, jobs. The newest are kept, so that who
//! was away for a moment goes on where it was.

use std::collections::VecDeque;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use jiff::Timestamp;
use tokio::sync::watch;

/// Most events that are kept.
const MOST_KEPT: usize = 4096;
/// Most bytes of them.
const MOST_KEPT_BYTES: usize = 8 << 20;

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// A frame was answered.
    Decision,
    /// A database answers with another version.
    Version,
    /// A job changed its state or its progress.
    Job,
}

impl EventKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Decision, Self::Version, Self::Job];

    /// Its word.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Decision => "decision",
            Self::Version => "version",
            Self::Job => "job",
        }
    }
}

/// Something that happened.
#[derive(Debug, Clone)]
pub struct Event {
    /// What kind of thing.
    pub kind: EventKind,
    /// The database that it is about.
    pub database: Option<String>,
    /// The robot that it is about.
    pub robot_id: Option<String>,
    /// What happened, as JSON.
    pub data: String,
}

/// Where a stream is: after the event of this number of this process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cursor {
    /// When the process began, in milliseconds since 1970-01-01 UTC.
    began_ms: i64,
    number: u64,
}

impl std::fmt::Display for Cursor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}-{}", self.began_ms, self.number)
    }
}

/// The text is no cursor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoCursor;

impl FromStr for Cursor {
    type Err = NoCursor;

    fn from_str(text: &str) -> Result<Self, NoCursor> {
        let (began, number) = text.trim().split_once('-').ok_or(NoCursor)?;
        let (began_ms, number) =
            (began.parse().map_err(|_| NoCursor)?, number.parse().map_err(|_| NoCursor)?);
        Ok(Self { began_ms, number })
    }
}

/// The newest events; the last one's number is `first + kept.len() - 1`.
struct Kept {
    first: u64,
    bytes: usize,
    kept: VecDeque<Arc<Event>>,
}

/// The events of this process; cheap to clone.
#[derive(Clone)]
pub struct Events(Arc<Inner>);

struct Inner {
    began_ms: i64,
    kept: Mutex<Kept>,
    /// The last event's number.
    last: watch::Sender<u64>,
    followers: AtomicUsize,
}

/// Counts as a follower until it is dropped.
pub struct Follower(Events);

impl Drop for Follower {
    fn drop(&mut self) {
        self.0.0.followers.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Default for Events {
    fn default() -> Self {
        let kept = Mutex::new(Kept { first: 1, bytes: 0, kept: VecDeque::new() });
        let began_ms = Timestamp::now().as_millisecond();
        Self(Arc::new(Inner { began_ms, kept, last: watch::Sender::new(0), followers: AtomicUsize::new(0) }))
    }
}

impl Events {
    fn kept(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.0.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells all that follow, and keeps it for those that come back.
    pub fn publish(&self, event: Event) {
        let last = {
            let mut kept = self.kept();
            kept.bytes += event.data.len();
            kept.kept.push_back(Arc::new(event));
            while kept.kept.len() > MOST_KEPT || kept.bytes > MOST_KEPT_BYTES {
                let Some(oldest) = kept.kept.pop_front() else { break };
                kept.bytes -= oldest.data.len();
                kept.first += 1;
            }
            kept.first + kept.kept.len() as u64 - 1
        };
        // two that publish at once may come here in either order
        self.0.last.send_if_modified(|told| {
            let is_newer = last > *told;
            *told = last.max(*told);
            is_newer
        });
    }

    /// Forgets what is kept: not all that happens was told from here on.
    pub fn forget(&self) {
        let mut kept = self.kept();
        // One number more: it stands for what was not told.
        kept.first += kept.kept.len() as u64 + 1;
        kept.kept.clear();
        kept.bytes = 0;
        self.0.last.send_replace(kept.first - 1);
    }

    /// One more follower, unless there are `most`.
    pub fn follow(&self, most: usize) -> Option<Follower> {
        let followers = &self.0.followers;
        let counted = followers
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |count| (count < most).then_some(count + 1));
        counted.is_ok().then(|| Follower(self.clone()))
    }

    /// Whether anybody follows.
    pub fn are_followed(&self) -> bool {
        self.0.followers.load(Ordering::Relaxed) > 0
    }

    /// After all that happened so far.
    pub fn now(&self) -> Cursor {
        Cursor { began_ms: self.0.began_ms, number: *self.0.last.borrow() }
    }

    /// What is kept of what came after the cursor, each with its own; and whether some of it is gone. What another process
    /// numbered, or nobody did, is taken as if nothing was seen.
    pub fn after(&self, cursor: Cursor) -> (Vec<(Cursor, Arc<Event>)>, bool) {
        let kept = self.kept();
        let next = kept.first + kept.kept.len() as u64;
        let is_ours = cursor.began_ms == self.0.began_ms && cursor.number < next;
        let from = if is_ours { cursor.number + 1 } else { 1 };
        let began_ms = self.0.began_ms;
        let numbered = (kept.first..).zip(&kept.kept).filter(|(number, _)| *number >= from);
        let events =
            numbered.map(|(number, event)| (Cursor { began_ms, number }, Arc::clone(event))).collect();
        (events, !is_ours || from < kept.first)
    }

    /// Resolves when there is something after the cursor.
    pub async fn changed(&self, cursor: Cursor) {
        let mut last = self.0.last.subscribe();
        // the sender lives as long as this
        let _ = last.wait_for(|last| *last > cursor.number).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(bytes: usize) -> Event {
        Event { kind: EventKind::Decision, database: None, robot_id: None, data: "x".repeat(bytes) }
    }

    #[test]
    fn who_was_away_gets_what_is_kept_and_is_told_what_is_not() {
        let events = Events::default();
        let start = events.now();
        events.publish(event(1));
        let (after, lost) = events.after(start);
        assert_eq!((after.len(), lost), (1, false));
        let seen = after[0].0;
        assert_eq!(seen.to_string().parse(), Ok(seen));
        for _ in 0..MOST_KEPT {
            events.publish(event(1));
        }
        assert_eq!((events.after(seen).0.len(), events.after(seen).1), (MOST_KEPT, false));
        assert!(events.after(start).1, "the first one is gone");
        let of_another = Cursor { began_ms: 0, ..seen };
        assert!(events.after(of_another).1);
        let beyond = Cursor { number: u64::MAX, ..seen };
        assert!(events.after(beyond).1);
        events.publish(event(MOST_KEPT_BYTES));
        assert_eq!(events.after(start).0.len(), 1, "bytes are bounded too");
    }

    #[test]
    fn who_comes_back_after_a_stretch_that_was_not_told_is_told_so() {
        let events = Events::default();
        events.publish(event(1));
        let seen = events.now();
        events.forget();
        assert_eq!((events.after(seen).0.len(), events.after(seen).1), (0, true));
        let now = events.now();
        events.publish(event(1));
        assert_eq!((events.after(now).0.len(), events.after(now).1), (1, false));
    }

    #[test]
    fn only_so_many_follow() {
        let events = Events::default();
        let first = events.follow(1);
        assert!(first.is_some() && events.follow(1).is_none());
        drop(first);
        assert!(!events.are_followed() && events.follow(1).is_some());
    }

    #[tokio::test]
    async fn a_wait_ends_with_the_next_event() {
        let events = Events::default();
        let now = events.now();
        let waiting = events.clone();
        let wait = tokio::spawn(async move { waiting.changed(now).await });
        events.publish(event(1));
        wait.await.unwrap();
    }
}
