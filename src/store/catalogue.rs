//! The catalogue: one trait, and its rows as plain structs.
//!
//! Rows are disk shapes: JSON stands in them as text, and nothing here checks a name or an option; the rooms
//! above do. The catalogue reads the clock itself, a shared one its server's; times have microsecond resolution, UTC. Lists are pages:
//! `after` is the key of the last row seen, `limit` the most rows to give.
//!
//! Two guards keep writers apart. An alias carries a revision, and moves by compare-and-swap. A job carries a
//! token that counts its claims, and a worker's writes name the token they were given, so that a worker which
//! lost its lease can finish nothing.

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use async_trait::async_trait;
use jiff::Timestamp;
use tokio::sync::watch;
use uuid::Uuid;

use super::audit::{Actor, AuditFilter, AuditRow};

/// What a catalogue call can fail with.
///
/// The source of an error, where there is one, is the driver's own error.
#[derive(Debug, thiserror::Error)]
pub enum CatalogueError {
    /// The catalogue can't be reached or can't write now (away, busy, disk full); it may heal by itself.
    #[error("the catalogue is unavailable")]
    Unavailable {
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The row that the call needs isn't there.
    #[error("{what} does not exist")]
    NotFound { what: String },
    /// The catalogue's state forbids the call.
    #[error("{what}")]
    Conflict { what: String },
    /// The alias or calibration isn't as the caller expected it.
    #[error("it is not at the expected revision")]
    PreconditionFailed,
    /// The job isn't running under this token any more: nothing was written.
    #[error("the lease on the job was lost")]
    LeaseLost,
    /// Somebody asked for the job to end before it did: nothing was written, and `Catalogue::cancelled_job` is due.
    #[error("the job was asked to end")]
    CancelRequested,
    /// A filter that must name something names nothing: absent never means all.
    #[error("the filter names no label, no robot and no time")]
    EmptyFilter,
    /// What was read can't have been written by this program.
    #[error("the catalogue is corrupt: {what}")]
    Corrupt {
        what: String,
        #[source]
        source: Option<Box<dyn std::error::Error + Send + Sync>>,
    },
}

impl CatalogueError {
    /// The error for a database that isn't there.
    pub(super) fn no_database(name: &str) -> Self {
        Self::NotFound { what: format!("database {name:?}") }
    }

    /// The error for a version that isn't there.
    pub(super) fn no_version(database: &str, version: i64) -> Self {
        Self::NotFound { what: format!("version {version} of database {database:?}") }
    }

    /// The error for a calibration that isn't there.
    pub(super) fn no_calibration(name: &str) -> Self {
        Self::NotFound { what: format!("calibration {name:?}") }
    }

    /// The error for the deletion of a version that is in use.
    pub(super) fn aliased(database: &str, version: i64, alias: &str) -> Self {
        Self::Conflict {
            what: format!("alias {alias:?} points to version {version} of database {database:?}"),
        }
    }
}

/// A named database of exemplars and the versions trained from them.
#[derive(Debug, Clone, PartialEq)]
pub struct DatabaseRow {
    pub name: String,
    pub kind: String,
    /// JSON.
    pub options: String,
    pub created_at: Timestamp,
}

/// How much a database holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatabaseCounts {
    pub exemplars: u64,
    /// Distinct labels among the exemplars.
    pub labels: u64,
    pub versions: u64,
}

/// One training image; its bytes are the blob.
#[derive(Debug, Clone, PartialEq)]
pub struct ExemplarRow {
    pub database: String,
    pub id: Uuid,
    pub label: String,
    pub pose_deg: Option<f64>,
    pub width_px: u32,
    pub height_px: u32,
    pub bytes: u64,
    /// SHA-256 of the bytes as sent, hex.
    pub sha256: String,
    /// Name of the blob, as `BlobName` writes it.
    pub blob: String,
    pub media_type: String,
    pub robot_id: Option<String>,
    pub frame_id: Option<String>,
    /// The capture time as the robot sent it.
    pub stamp: Option<String>,
    /// Set by the catalogue on insertion; what the caller puts here is ignored.
    pub created_at: Timestamp,
}

/// Which exemplars are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExemplarFilter {
    pub label: Option<String>,
    pub robot_id: Option<String>,
    /// Received at this moment or later.
    pub since: Option<Timestamp>,
    /// Received before this moment.
    pub before: Option<Timestamp>,
}

impl ExemplarFilter {
    /// Whether every exemplar matches.
    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A trained artefact before it has its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewVersion {
    pub database: String,
    /// Digest of the inputs: the same digest in one database is the same version.
    pub digest: String,
    /// Name of the artifact's blob, as `BlobName` writes it.
    pub blob: String,
    /// Size of the artifact.
    pub bytes: u64,
    pub kind: String,
    pub algorithm_revision: i64,
    /// JSON.
    pub options: String,
    /// JSON.
    pub counts: String,
    /// JSON.
    pub report: String,
}

/// A trained artefact; it never changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VersionRow {
    pub database: String,
    /// Counts 1, 2, 3 … in its database; the number of a deleted version isn't given again.
    pub version: i64,
    pub digest: String,
    pub blob: String,
    pub bytes: u64,
    pub kind: String,
    pub algorithm_revision: i64,
    /// JSON.
    pub options: String,
    /// JSON.
    pub counts: String,
    /// JSON.
    pub report: String,
    pub created_at: Timestamp,
}

/// A moving name for a version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AliasRow {
    pub database: String,
    pub alias: String,
    pub version: i64,
    /// Grows with every move; no two states of the database's aliases share one, not even after a deletion.
    pub revision: i64,
    pub updated_at: Timestamp,
}

/// An alias and what the registry needs to load the version it points to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AliasTarget {
    pub database: String,
    pub kind: String,
    pub alias: String,
    pub version: i64,
    pub digest: String,
    pub blob: String,
    pub revision: i64,
}

/// What the caller takes the alias to be before a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AliasExpectation {
    /// Whatever it is.
    Any,
    /// Not there yet.
    Absent,
    /// There, at this revision.
    Revision(i64),
}

/// What is known of a rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CalibrationRow {
    pub name: String,
    /// JSON.
    pub document: String,
    /// Grows with every change; no two states of any calibration share one, not even after a deletion.
    pub revision: i64,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

/// What is known of a workcell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkcellRow {
    pub name: String,
    /// JSON.
    pub document: String,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

/// The life of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum JobState {
    Queued,
    Running,
    Succeeded,
    Failed,
    Cancelled,
}

impl JobState {
    /// Every state, in the order of a job's life.
    pub const ALL: [Self; 5] = [Self::Queued, Self::Running, Self::Succeeded, Self::Failed, Self::Cancelled];

    /// The word that stands in the catalogue and in the HTTP contract.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }

    /// True when the job will never change again.
    pub const fn is_terminal(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }
}

impl fmt::Display for JobState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

/// The word is no job state.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{word:?} is no job state")]
pub struct UnknownJobState {
    pub word: String,
}

impl FromStr for JobState {
    type Err = UnknownJobState;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|state| state.as_str() == word)
            .ok_or_else(|| UnknownJobState { word: word.to_owned() })
    }
}

/// How far a job is: `done` of `total` steps of a stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    pub stage: String,
    pub done: u64,
    pub total: u64,
}

/// A piece of long work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobRow {
    /// UUID v7: ids sort by the time of their making.
    pub id: Uuid,
    pub kind: String,
    /// The name only: the row outlives the database. None for a job about a calibration.
    pub database: Option<String>,
    /// Likewise, the calibration that the job is about.
    pub calibration: Option<String>,
    /// JSON.
    pub params: String,
    pub state: JobState,
    pub progress: Option<Progress>,
    /// Counts the claims; a worker's writes must name the one it was given.
    pub token: i64,
    /// The worker that holds the job, or held it when it ended; none while it waits.
    pub owner: Option<String>,
    /// When a running job may be claimed by another worker.
    pub lease_until: Option<Timestamp>,
    pub cancel_requested: bool,
    /// Claims that count: one handed back doesn't.
    pub attempts: u32,
    /// The version it made or found.
    pub version: Option<i64>,
    /// JSON with at least `code` and `detail`, where the job failed or was cut off by a deletion.
    pub problem: Option<String>,
    /// JSON: how the version did beside the one in use, where that was asked for.
    pub comparison: Option<String>,
    pub created_at: Timestamp,
    /// The first claim.
    pub started_at: Option<Timestamp>,
    pub finished_at: Option<Timestamp>,
}

/// Which jobs are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct JobFilter {
    pub database: Option<String>,
    pub calibration: Option<String>,
    pub state: Option<JobState>,
}

/// What a worker learns when it renews its lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Renewal {
    /// Somebody asked for the job to end: stop at the next step and call `Catalogue::cancelled_job`.
    pub cancel_requested: bool,
}

/// A job as it was after one change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobEventRow {
    pub job: Uuid,
    /// Counts 1, 2, 3 … for each job.
    pub sequence: i64,
    /// The whole row as it was then.
    pub body: JobRow,
    pub created_at: Timestamp,
}

/// A process of a fleet, as it told of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessRow {
    /// Unique to the process.
    pub worker: String,
    pub role: String,
    /// JSON: what it serves.
    pub serving: String,
    pub started_at: Timestamp,
    /// When it last told; what the caller puts here is ignored.
    pub seen_at: Timestamp,
}

/// An API key before it is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewKey {
    /// The public part of the key.
    pub id: String,
    pub name: String,
    /// SHA-256 of the whole key, hex.
    pub hash: String,
    pub scope: String,
    /// JSON array of name patterns; none: every database.
    pub databases: Option<String>,
    pub requests_per_s: Option<i64>,
}

/// An API key; the key itself is not kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyRow {
    pub id: String,
    pub name: String,
    pub hash: String,
    pub scope: String,
    pub databases: Option<String>,
    pub requests_per_s: Option<i64>,
    pub created_at: Timestamp,
    /// Within a minute or so: it is noted now and then.
    pub last_used_at: Option<Timestamp>,
    /// It isn't taken any more from then on.
    pub revoked_at: Option<Timestamp>,
}

/// Something only one process has at a time; dropped, it is free.
pub type Turn = Box<dyn Send>;

/// The one truth about databases, exemplars, versions, aliases, calibrations, workcells and jobs.
///
/// Every call is one transaction: it happened wholly, durably, or not at all. Dropping the future of a call
/// leaves it done or undone, never half. Any call may fail with `Unavailable` or `Corrupt`; the other errors
/// are named at the calls that give them. A change that somebody asks for says by whom, and its entry in the audit
/// record is written in the same transaction; a call that finds nothing to change writes none.
#[async_trait]
pub trait Catalogue: Send + Sync + 'static {
    /// Succeeds when the catalogue can be read.
    async fn ping(&self) -> Result<(), CatalogueError>;

    /// Creates a database, or gives the existing one of that name unchanged, whatever its kind, with `false`.
    async fn create_database(
        &self,
        name: &str,
        kind: &str,
        options: &str,
        by: &Actor,
    ) -> Result<(DatabaseRow, bool), CatalogueError>;

    /// Replaces a database's options. Errors: `NotFound`.
    async fn set_database_options(
        &self,
        name: &str,
        options: &str,
        by: &Actor,
    ) -> Result<DatabaseRow, CatalogueError>;

    /// The database of that name.
    async fn database(&self, name: &str) -> Result<Option<DatabaseRow>, CatalogueError>;

    /// Databases by name.
    async fn databases(&self, after: Option<&str>, limit: u32) -> Result<Vec<DatabaseRow>, CatalogueError>;

    /// Deletes a database with its exemplars, versions and aliases, and cancels its unfinished jobs.
    ///
    /// False when there was none.
    async fn delete_database(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError>;

    /// Counts what a database holds. Errors: `NotFound`.
    async fn database_counts(&self, name: &str) -> Result<DatabaseCounts, CatalogueError>;

    /// Adds an exemplar, or gives the existing one of that database and id unchanged, with `false`.
    ///
    /// Its blob must be stored before. Errors: `NotFound` for the database.
    async fn insert_exemplar(&self, row: &ExemplarRow) -> Result<(ExemplarRow, bool), CatalogueError>;

    /// The exemplar of that id.
    async fn exemplar(&self, database: &str, id: Uuid) -> Result<Option<ExemplarRow>, CatalogueError>;

    /// Exemplars by id; an empty filter means all.
    async fn exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<ExemplarRow>, CatalogueError>;

    /// Deletes one exemplar; false when there was none.
    async fn delete_exemplar(&self, database: &str, id: Uuid, by: &Actor) -> Result<bool, CatalogueError>;

    /// Deletes the exemplars that match, and counts them. Errors: `EmptyFilter`.
    async fn delete_exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        by: &Actor,
    ) -> Result<u64, CatalogueError>;

    /// Every exemplar of a database as of one moment, by label, then id.
    async fn training_set(&self, database: &str) -> Result<Vec<ExemplarRow>, CatalogueError>;

    /// Versions by number.
    async fn versions(
        &self,
        database: &str,
        after: Option<i64>,
        limit: u32,
    ) -> Result<Vec<VersionRow>, CatalogueError>;

    /// The version of that number.
    async fn version(&self, database: &str, version: i64) -> Result<Option<VersionRow>, CatalogueError>;

    /// Those of these databases' versions that are there, with their digests.
    async fn digests(&self, versions: &[(String, i64)])
    -> Result<Vec<(String, i64, String)>, CatalogueError>;

    /// The version made from these inputs.
    async fn version_by_digest(
        &self,
        database: &str,
        digest: &str,
    ) -> Result<Option<VersionRow>, CatalogueError>;

    /// Adds a version under the next number, or gives the existing one of that digest unchanged, with `false`.
    ///
    /// Its blob must be stored before. Errors: `NotFound` for the database.
    async fn insert_version(
        &self,
        new: &NewVersion,
        by: &Actor,
    ) -> Result<(VersionRow, bool), CatalogueError>;

    /// Deletes a version; false when there was none. Errors: `Conflict` while an alias points to it.
    async fn delete_version(&self, database: &str, version: i64, by: &Actor) -> Result<bool, CatalogueError>;

    /// The aliases of a database, by name.
    async fn aliases(&self, database: &str) -> Result<Vec<AliasRow>, CatalogueError>;

    /// The aliases of every database, by database and name, with what they point to.
    async fn all_aliases(&self) -> Result<Vec<AliasTarget>, CatalogueError>;

    /// Points an alias to a version; `true` when it is new.
    ///
    /// Errors: `NotFound` for the version, `PreconditionFailed` when the alias isn't as `expected`.
    async fn set_alias(
        &self,
        database: &str,
        alias: &str,
        version: i64,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<(AliasRow, bool), CatalogueError>;

    /// Deletes an alias; false when there was none and `expected` allows it.
    ///
    /// Errors: `PreconditionFailed` when the alias isn't as `expected`.
    async fn delete_alias(
        &self,
        database: &str,
        alias: &str,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<bool, CatalogueError>;

    /// Creates the calibration of that name, or replaces its document, if it is at the revision `expected`; none
    /// means that it isn't there. Errors: `PreconditionFailed`.
    async fn put_calibration(
        &self,
        name: &str,
        document: &str,
        expected: Option<i64>,
        by: &Actor,
    ) -> Result<CalibrationRow, CatalogueError>;

    /// The calibration of that name.
    async fn calibration(&self, name: &str) -> Result<Option<CalibrationRow>, CatalogueError>;

    /// Calibrations by name.
    async fn calibrations(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<CalibrationRow>, CatalogueError>;

    /// Deletes a calibration and cancels its unfinished jobs; false when there was none.
    async fn delete_calibration(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError>;

    /// Adds a job about a calibration to the queue, with the blobs that it will read: they count as named until it
    /// has ended, and must be stored before. Errors: `NotFound` for the calibration.
    async fn enqueue_calibration_job(
        &self,
        kind: &str,
        calibration: &str,
        params: &str,
        blobs: &[String],
        by: &Actor,
    ) -> Result<JobRow, CatalogueError>;

    /// Ends a job with what it found out about its calibration: the document, if that is still at the revision
    /// `expected`, and the job's success, in one transaction.
    ///
    /// Errors: `LeaseLost`, `CancelRequested`, `PreconditionFailed`; then nothing has changed.
    async fn publish_calibration(
        &self,
        id: Uuid,
        token: i64,
        document: &str,
        expected: i64,
    ) -> Result<CalibrationRow, CatalogueError>;

    /// Creates the workcell of that name, with `true`, or replaces its document.
    async fn put_workcell(
        &self,
        name: &str,
        document: &str,
        by: &Actor,
    ) -> Result<(WorkcellRow, bool), CatalogueError>;

    /// The workcell of that name.
    async fn workcell(&self, name: &str) -> Result<Option<WorkcellRow>, CatalogueError>;

    /// Workcells by name.
    async fn workcells(&self, after: Option<&str>, limit: u32) -> Result<Vec<WorkcellRow>, CatalogueError>;

    /// Deletes a workcell; false when there was none.
    async fn delete_workcell(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError>;

    /// Adds a job about a database to the queue. Errors: `NotFound` for the database.
    async fn enqueue_job(
        &self,
        kind: &str,
        database: &str,
        params: &str,
        by: &Actor,
    ) -> Result<JobRow, CatalogueError>;

    /// The job of that id.
    async fn job(&self, id: Uuid) -> Result<Option<JobRow>, CatalogueError>;

    /// Jobs, the newest first; `after` is the oldest one seen.
    async fn jobs(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, CatalogueError>;

    /// Gives the oldest job of these kinds that waits, or whose lease ran out, to this worker.
    ///
    /// Its token and its attempts grow by one and its progress starts anew. On the way, a job that was asked to
    /// end becomes `cancelled`, and one that was claimed `max_attempts` times becomes `failed`.
    async fn claim_job(
        &self,
        owner: &str,
        kinds: &[&str],
        lease: Duration,
        max_attempts: u32,
    ) -> Result<Option<JobRow>, CatalogueError>;

    /// Extends the lease to `lease` from now, and notes the progress when it is given. Errors: `LeaseLost`.
    async fn renew_job(
        &self,
        id: Uuid,
        token: i64,
        lease: Duration,
        progress: Option<&Progress>,
    ) -> Result<Renewal, CatalogueError>;

    /// Ends a job with a version: its row, the alias if one is named, and the job's success, in one transaction.
    ///
    /// The version of that digest is taken where there is one already. What came of comparing it (JSON) is kept with
    /// the job. Errors: `LeaseLost`, `CancelRequested`,
    /// `NotFound` for the database; then nothing has changed.
    async fn publish(
        &self,
        id: Uuid,
        token: i64,
        new: &NewVersion,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<VersionRow, CatalogueError>;

    /// Ends a job that needed no new version: the one it found, the alias if one is named, and its success.
    ///
    /// An alias is moved only when there is a version. Errors: `LeaseLost`, `CancelRequested`, `NotFound` for the
    /// version; then nothing has changed.
    async fn succeed_job(
        &self,
        id: Uuid,
        token: i64,
        version: Option<i64>,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<JobRow, CatalogueError>;

    /// Ends a job with a problem (JSON with at least `code` and `detail`). Errors: `LeaseLost`.
    async fn fail_job(&self, id: Uuid, token: i64, problem: &str) -> Result<JobRow, CatalogueError>;

    /// Ends a job that was asked to end. Errors: `LeaseLost`.
    async fn cancelled_job(&self, id: Uuid, token: i64) -> Result<JobRow, CatalogueError>;

    /// Asks a job to end: a queued one is cancelled at once, a running one is flagged, a finished one stays.
    ///
    /// None when there is no such job.
    async fn request_cancel(&self, id: Uuid, by: &Actor) -> Result<Option<JobRow>, CatalogueError>;

    /// Puts a worker's running jobs back into the queue, the attempt not counted; gives their number.
    ///
    /// One that was asked to end is cancelled. For graceful shutdown.
    async fn hand_back_jobs(&self, owner: &str) -> Result<u64, CatalogueError>;

    /// Ends the leases of every other owner now; gives the number that had time left.
    ///
    /// Only for an embedded catalogue, where holding the folder's lock proves that every other owner is dead. A
    /// shared one leaves them to run out, and gives 0.
    async fn release_dead_leases(&self, except_owner: &str) -> Result<u64, CatalogueError>;

    /// What happened to a job after the event `after` (0: from its first state on), in order.
    ///
    /// Every change of state or progress appends one event in the transaction that makes it.
    async fn job_events(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, CatalogueError>;

    /// How many jobs there are in each state that has any.
    async fn jobs_by_state(&self) -> Result<Vec<(JobState, u64)>, CatalogueError>;

    /// Tells the other processes of this one. A catalogue that one process holds keeps nothing.
    async fn note_process(&self, row: &ProcessRow) -> Result<(), CatalogueError>;

    /// The processes that told of themselves not longer ago than `fresh`, by the time of their start.
    async fn processes(&self, fresh: Duration) -> Result<Vec<ProcessRow>, CatalogueError>;

    /// Keeps a new key.
    async fn insert_key(&self, new: &NewKey, by: &Actor) -> Result<KeyRow, CatalogueError>;

    /// Every key that ever was, revoked ones too, the oldest first.
    async fn keys(&self) -> Result<Vec<KeyRow>, CatalogueError>;

    /// Ends a key, for good; false when it had ended, none when there is no such key.
    async fn revoke_key(&self, id: &str, by: &Actor) -> Result<Option<bool>, CatalogueError>;

    /// Notes when keys were last used.
    async fn note_key_uses(&self, uses: &[(String, Timestamp)]) -> Result<(), CatalogueError>;

    /// Entries of the audit record, the newest first; `before` is the oldest one seen.
    async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<i64>,
        limit: u32,
    ) -> Result<Vec<AuditRow>, CatalogueError>;

    /// Those of these blobs that an exemplar, a version or a job that hasn't ended names.
    async fn blobs_referenced(&self, blobs: &[String]) -> Result<Vec<String>, CatalogueError>;

    /// The turn to collect orphans, held until it is dropped; none while another process has it, or copies the
    /// blobs.
    async fn turn_to_collect(&self) -> Result<Option<Turn>, CatalogueError>;

    /// A number that grows soon after any process moved or deleted an alias, made or revoked a key, queued a job, asked
    /// one to end, or deleted what jobs are about.
    ///
    /// No more than a hint: it may grow for nothing, and says nothing while the catalogue can't be reached, so
    /// whoever waits for it looks now and then all the same. What happened before this call counts as seen.
    fn hints(&self) -> watch::Receiver<u64>;
}
