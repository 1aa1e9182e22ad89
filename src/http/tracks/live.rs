//! The tracks that are live in this process: where each robot is believed to be, and when its track is gone.
//!
//! A track is an immutable value; each of its frames puts another in its place. The one lock is held to read and to
//! replace, never while a frame is worked on.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Bound;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use tokio::sync::{OwnedMutexGuard, Semaphore, SemaphorePermit};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::config::Limits;
use crate::database::{FrameHeader, Name};
use crate::http::problem::{Code, Problem};
use crate::http::recognitions::{PlacePoseBody, flat};
use landmarkd_core::localisation::{Estimate, Odometry, PlanePose, PoseFilter};
use landmarkd_core::recognition::landmarks::{Belief, ExemplarName};

/// Frames of one track that may wait for those before them: a second's worth of a slow camera. A robot that sends faster
/// than it is answered must drop frames, not pile them up.
const MOST_WAITING: usize = 8;

/// How robots move among the exemplars.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionWord {
    /// The exemplars follow one another as they were posted; robots pass them forward or back, at whatever speed.
    Path,
    /// Nothing is known of which exemplar is near which.
    Still,
    /// `path` if the version takes the camera to be upright, else `still`.
    #[default]
    Auto,
}

/// The state of a track after its frames so far.
#[derive(Clone)]
pub struct Track {
    pub id: Uuid,
    pub database: Name,
    /// Whose version answers; `current` if it is none.
    pub alias: Option<Name>,
    /// What was asked for.
    pub motion: MotionWord,
    /// A path was wanted, and the order of the exemplars isn't known.
    pub is_out_of_order: bool,
    /// The version that the belief is about, its digest and its exemplars.
    pub version: i64,
    pub digest: String,
    pub exemplars: Arc<[ExemplarName]>,
    pub belief: Belief,
    /// Where the robot is in a map, from the first frame on that tells.
    pub localisation: Option<Localisation>,
    /// Frames that were counted.
    pub frames: u64,
    /// The last frame, if it had an id.
    pub last: Option<FrameMark>,
    pub created_at: Timestamp,
    /// When its last frame was answered.
    pub used_at: Timestamp,
}

/// Where a robot is in a map.
#[derive(Clone)]
pub struct Localisation {
    map: String,
    filter: PoseFilter,
    /// The exemplars that the last fix rests on.
    support: Vec<String>,
    /// A fix in another map came last: two in a row, and the robot is there.
    elsewhere: bool,
}

impl Localisation {
    fn new(map: &str, seed: u64) -> Self {
        Self { map: map.into(), filter: PoseFilter::new(seed), support: Vec::new(), elsewhere: false }
    }

    /// The robot moved, and a frame may have said where it is.
    fn after(mut self, odometry: Option<&Odometry>, fix: Option<&PlacePoseBody>, seed: u64) -> Self {
        self.filter.predict(odometry);
        let Some(fix) = fix else { return self };
        if fix.map != self.map {
            if !self.elsewhere {
                return Self { elsewhere: true, ..self };
            }
            self = Self::new(&fix.map, seed);
        }
        let covariance = std::array::from_fn(|row| std::array::from_fn(|at| fix.covariance[3 * row + at]));
        self.filter.update(&PlanePose { x_m: fix.x_m, y_m: fix.y_m, yaw_deg: fix.yaw_deg, covariance });
        Self { support: fix.support.clone(), elsewhere: false, ..self }
    }

    /// Memory held, about.
    fn bytes(&self) -> usize {
        size_of::<Self>() + PoseFilter::BYTES
    }

    /// Where the robot is by all frames.
    pub fn pose(&self) -> Option<PlacePoseBody> {
        let Estimate { pose, lost } = self.filter.estimate()?;
        Some(PlacePoseBody {
            map: self.map.clone(),
            x_m: pose.x_m,
            y_m: pose.y_m,
            yaw_deg: pose.yaw_deg,
            covariance: flat(&pose.covariance),
            method: "track",
            support: self.support.clone(),
            lost: Some(lost),
        })
    }
}

/// What identifies a frame within its track: the robot's header and a hash of its picture.
#[derive(Clone, PartialEq, Eq)]
pub struct FrameMark {
    header: FrameHeader,
    hash: u64,
}

impl Track {
    /// The same after a frame with those bytes, the motion since the one before, W of every exemplar and where the frame was
    /// taken; and whether the frame was counted: the last one sent again is not. A frame without an id is never taken for a
    /// repeat.
    pub fn after(
        mut self,
        header: FrameHeader,
        bytes: &[u8],
        odometry: Option<&Odometry>,
        weights: &[f64],
        fix: Option<&PlacePoseBody>,
    ) -> (Self, bool) {
        let mark = header.frame_id.is_some().then(|| {
            let mut hasher = DefaultHasher::new();
            bytes.hash(&mut hasher);
            FrameMark { header, hash: hasher.finish() }
        });
        let is_repeat = mark.is_some() && mark == self.last;
        if !is_repeat {
            self.belief.add(weights);
            // The seed is the track's and the frame's: the same frames give the same poses.
            let seed = self.id.as_u64_pair().1 ^ self.frames;
            let before = self.localisation.take();
            let before = before.or_else(|| fix.map(|fix| Localisation::new(&fix.map, seed)));
            self.localisation = before.map(|localisation| localisation.after(odometry, fix, seed));
            self.frames += 1;
            self.last = mark;
        }
        self.used_at = Timestamp::now();
        (self, !is_repeat)
    }

    /// Memory held.
    fn bytes(&self) -> u64 {
        let name = |name: &ExemplarName| size_of::<ExemplarName>() + name.id.len() + name.label.len();
        let exemplars: usize = self.exemplars.iter().map(name).sum();
        let particles = self.localisation.as_ref().map_or(0, |localisation| localisation.bytes());
        (size_of::<Self>() + self.belief.bytes() + exemplars + particles) as u64
    }
}

/// The queue of a track's frames: first come, first served.
#[derive(Clone)]
pub struct FrameQueue {
    permits: Arc<Semaphore>,
    current: Arc<tokio::sync::Mutex<()>>,
}

/// The frame that is worked on, until it is dropped.
pub struct FrameGuard<'a> {
    _permit: SemaphorePermit<'a>,
    _current: OwnedMutexGuard<()>,
}

impl FrameQueue {
    fn new() -> Self {
        Self { permits: Arc::new(Semaphore::new(1 + MOST_WAITING)), current: Arc::default() }
    }

    /// Waits until the frames that came before are answered.
    ///
    /// # Errors
    /// 503 when too many wait already.
    pub async fn lock(&self) -> Result<FrameGuard<'_>, Problem> {
        let permit = self.permits.try_acquire().map_err(|_| {
            let text = format!(
                "{MOST_WAITING} frames of this track wait already: send the next when one is answered"
            );
            Problem::new(Code::Overloaded, text)
        })?;
        Ok(FrameGuard { _permit: permit, _current: Arc::clone(&self.current).lock_owned().await })
    }
}

struct Entry {
    track: Arc<Track>,
    bytes: u64,
    queue: FrameQueue,
    used: Instant,
}

/// The live tracks, by id; cheap to clone.
#[derive(Clone)]
pub struct Tracks {
    live: Arc<Mutex<BTreeMap<Uuid, Entry>>>,
    most: usize,
    most_bytes: u64,
    idle: Duration,
}

impl Tracks {
    /// None yet.
    pub fn new(limits: &Limits) -> Self {
        let (most, most_bytes, idle) = (limits.max_tracks, limits.max_tracks_bytes, limits.track_idle);
        Self { live: Arc::default(), most, most_bytes, idle }
    }

    /// Those that are not gone yet.
    fn live(&self) -> MutexGuard<'_, BTreeMap<Uuid, Entry>> {
        // A panic elsewhere leaves the table whole: nothing here is half done while the lock is held.
        let mut live = self.live.lock().unwrap_or_else(PoisonError::into_inner);
        live.retain(|_, entry| entry.used.elapsed() < self.idle);
        live
    }

    /// Whether there is room for so many bytes of a track, in place of those of that id if it is there.
    fn admit(&self, live: &BTreeMap<Uuid, Entry>, id: Uuid, bytes: u64) -> Result<(), Problem> {
        let others = || live.iter().filter(|(other, _)| **other != id).map(|(_, entry)| entry.bytes);
        let held = others().sum::<u64>();
        if others().count() < self.most && held + bytes <= self.most_bytes {
            return Ok(());
        }
        let oldest = live.values().map(|entry| entry.used.elapsed()).max().unwrap_or_default();
        let text = format!(
            "{} tracks hold {} MiB: delete those that are done with, or wait until one is gone",
            others().count(),
            held >> 20
        );
        Err(Problem::new(Code::TooManyTracks, text).until(self.idle.saturating_sub(oldest)))
    }

    /// Begins a track.
    ///
    /// # Errors
    /// 429 when there is no room.
    pub fn begin(&self, track: Track) -> Result<Arc<Track>, Problem> {
        let bytes = track.bytes();
        let mut live = self.live();
        self.admit(&live, track.id, bytes)?;
        let track = Arc::new(track);
        let entry =
            Entry { track: Arc::clone(&track), bytes, queue: FrameQueue::new(), used: Instant::now() };
        live.insert(track.id, entry);
        Ok(track)
    }

    /// The queue of a track that a frame came for; its idle time starts again.
    ///
    /// # Errors
    /// 404 when there is no such track.
    pub fn queue(&self, database: &Name, id: Uuid) -> Result<FrameQueue, Problem> {
        let mut live = self.live();
        let entry = live.get_mut(&id).filter(|entry| entry.track.database == *database);
        let entry = entry.ok_or_else(|| self.unknown(id))?;
        entry.used = Instant::now();
        Ok(entry.queue.clone())
    }

    /// A track as it stands.
    ///
    /// # Errors
    /// 404 when there is no such track.
    pub fn get(&self, database: &Name, id: Uuid) -> Result<Arc<Track>, Problem> {
        let live = self.live();
        let entry = live.get(&id).filter(|entry| entry.track.database == *database);
        entry.map(|entry| Arc::clone(&entry.track)).ok_or_else(|| self.unknown(id))
    }

    /// Puts a track in the place of the one with its id.
    ///
    /// # Errors
    /// 404 when it was deleted meanwhile, 429 when it has grown and there is no room.
    pub fn put(&self, track: Track) -> Result<Arc<Track>, Problem> {
        let (id, bytes) = (track.id, track.bytes());
        let mut live = self.live();
        if !live.contains_key(&id) {
            return Err(self.unknown(id));
        }
        self.admit(&live, id, bytes)?;
        let track = Arc::new(track);
        live.entry(id).and_modify(|entry| {
            (entry.track, entry.bytes, entry.used) = (Arc::clone(&track), bytes, Instant::now());
        });
        Ok(track)
    }

    /// The tracks of a database after that id: in the order in which they began.
    pub fn list(&self, database: &Name, after: Option<Uuid>, limit: u32) -> Vec<Arc<Track>> {
        let live = self.live();
        let later = live.range((after.map_or(Bound::Unbounded, Bound::Excluded), Bound::Unbounded));
        let of_database = later.map(|(_, entry)| &entry.track).filter(|track| track.database == *database);
        of_database.take(limit as usize).cloned().collect()
    }

    /// Ends a track.
    ///
    /// # Errors
    /// 404 when there is no such track.
    pub fn end(&self, database: &Name, id: Uuid) -> Result<(), Problem> {
        self.get(database, id)?;
        self.live().remove(&id);
        Ok(())
    }

    /// Number and bytes of the live tracks.
    pub fn held(&self) -> (usize, u64) {
        let live = self.live();
        (live.len(), live.values().map(|entry| entry.bytes).sum())
    }

    /// When a track is gone unless another frame comes.
    pub fn expires_at(&self, track: &Track) -> Timestamp {
        track.used_at + self.idle
    }

    fn unknown(&self, id: Uuid) -> Problem {
        let text = format!(
            "there is no track {id}: one without a frame for {} s is gone, and all are when the service restarts; begin \
             another with POST /v1/databases/{{database}}/tracks",
            self.idle.as_secs_f64()
        );
        Problem::new(Code::UnknownTrack, text)
    }
}
