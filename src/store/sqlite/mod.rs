//! The catalogue in one SQLite file: where transactions begin and end.
//!
//! The statements stand in one file per table and take a connection; this file decides what is one
//! transaction. Write-ahead log, `synchronous=FULL`: a call that returned survives power loss. One connection
//! writes (`BEGIN IMMEDIATE`, so a transaction never finds out halfway that it may not write), four read and
//! can do nothing else.

mod aliases;
mod calibrations;
mod databases;
mod exemplars;
mod jobs;
mod row;
mod versions;
mod workcells;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use sqlx::migrate::Migrator;
use sqlx::pool::PoolConnection;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};
use sqlx::{Sqlite, Transaction};
use tokio::sync::watch;
use uuid::Uuid;

use super::catalogue::{
    AliasExpectation, AliasRow, AliasTarget, CalibrationRow, Catalogue, CatalogueError, DatabaseCounts,
    DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow, JobFilter, JobRow, JobState, NewVersion,
    ProcessRow, Progress, Renewal, VersionRow, WorkcellRow,
};
use super::folder::FolderLock;
use super::job_end::{Outcome, Subject};
use super::open::OpenCatalogueError;

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/sqlite");

/// Readers beside the one writer: recognition reads no rows, so these serve lists and readiness only.
const READERS: u32 = 4;

/// How long a call waits for its turn before it is `Unavailable`.
const TURN_TIMEOUT: Duration = Duration::from_secs(10);

/// How long SQLite waits for another program that holds the file, a backup for instance.
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);

/// The catalogue in a SQLite file.
#[derive(Debug)]
pub struct SqliteCatalogue {
    writer: SqlitePool,
    readers: SqlitePool,
    hints: watch::Sender<u64>,
    _lock: Arc<FolderLock>,
}

impl SqliteCatalogue {
    /// Opens the catalogue, creates it if it isn't there, and brings its tables up to date.
    ///
    /// The lock of the folder that holds the file is kept as long as the catalogue lives.
    pub(in crate::store) async fn open(
        path: &Path,
        lock: Arc<FolderLock>,
    ) -> Result<Self, OpenCatalogueError> {
        let options = SqliteConnectOptions::new()
            .filename(path)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .foreign_keys(true)
            .busy_timeout(BUSY_TIMEOUT);
        let writer = pool(1)
            .connect_with(options.clone().create_if_missing(true))
            .await
            .map_err(OpenCatalogueError::Open)?;
        MIGRATIONS.run(&writer).await?;
        let readers = pool(READERS)
            .connect_with(options.pragma("query_only", "ON"))
            .await
            .map_err(OpenCatalogueError::Open)?;
        Ok(Self { writer, readers, hints: watch::Sender::new(0), _lock: lock })
    }

    async fn read(&self) -> Result<PoolConnection<Sqlite>, CatalogueError> {
        Ok(self.readers.acquire().await?)
    }

    /// Begins a transaction that writes; dropped without a commit, it is rolled back.
    async fn write(&self) -> Result<Transaction<'static, Sqlite>, CatalogueError> {
        Ok(self.writer.begin_with("BEGIN IMMEDIATE").await?)
    }

    fn hint(&self) {
        self.hints.send_modify(|hints| *hints += 1);
    }
}

/// Connections live as long as the pool: opening one again costs more than keeping it.
fn pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(TURN_TIMEOUT)
        .idle_timeout(None)
        .max_lifetime(None)
}

#[async_trait]
impl Catalogue for SqliteCatalogue {
    async fn ping(&self) -> Result<(), CatalogueError> {
        databases::list(&mut *self.read().await?, None, 1).await.map(drop)
    }

    async fn create_database(
        &self,
        name: &str,
        kind: &str,
        options: &str,
    ) -> Result<(DatabaseRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let created = databases::create(&mut transaction, name, kind, options).await?;
        transaction.commit().await?;
        Ok(created)
    }

    async fn set_database_options(&self, name: &str, options: &str) -> Result<DatabaseRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let row = databases::set_options(&mut transaction, name, options).await?;
        transaction.commit().await?;
        Ok(row)
    }

    async fn database(&self, name: &str) -> Result<Option<DatabaseRow>, CatalogueError> {
        databases::find(&mut *self.read().await?, name).await
    }

    async fn databases(&self, after: Option<&str>, limit: u32) -> Result<Vec<DatabaseRow>, CatalogueError> {
        databases::list(&mut *self.read().await?, after, limit).await
    }

    async fn delete_database(&self, name: &str) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::cancel_all(&mut transaction, Subject::Database(name)).await?;
        let deleted = databases::delete(&mut transaction, name).await?;
        transaction.commit().await?;
        self.hint();
        Ok(deleted)
    }

    async fn database_counts(&self, name: &str) -> Result<DatabaseCounts, CatalogueError> {
        databases::counts(&mut *self.read().await?, name).await
    }

    async fn insert_exemplar(&self, row: &ExemplarRow) -> Result<(ExemplarRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let inserted = exemplars::insert(&mut transaction, row).await?;
        transaction.commit().await?;
        Ok(inserted)
    }

    async fn exemplar(&self, database: &str, id: Uuid) -> Result<Option<ExemplarRow>, CatalogueError> {
        exemplars::find(&mut *self.read().await?, database, id).await
    }

    async fn exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<ExemplarRow>, CatalogueError> {
        exemplars::list(&mut *self.read().await?, database, filter, after, limit).await
    }

    async fn delete_exemplar(&self, database: &str, id: Uuid) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = exemplars::delete(&mut transaction, database, id).await?;
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn delete_exemplars(&self, database: &str, filter: &ExemplarFilter) -> Result<u64, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = exemplars::delete_matching(&mut transaction, database, filter).await?;
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn training_set(&self, database: &str) -> Result<Vec<ExemplarRow>, CatalogueError> {
        exemplars::training_set(&mut *self.read().await?, database).await
    }

    async fn versions(
        &self,
        database: &str,
        after: Option<i64>,
        limit: u32,
    ) -> Result<Vec<VersionRow>, CatalogueError> {
        versions::list(&mut *self.read().await?, database, after, limit).await
    }

    async fn version(&self, database: &str, version: i64) -> Result<Option<VersionRow>, CatalogueError> {
        versions::find(&mut *self.read().await?, database, version).await
    }

    async fn version_by_digest(
        &self,
        database: &str,
        digest: &str,
    ) -> Result<Option<VersionRow>, CatalogueError> {
        versions::find_by_digest(&mut *self.read().await?, database, digest).await
    }

    async fn insert_version(&self, new: &NewVersion) -> Result<(VersionRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let inserted = versions::insert(&mut transaction, new).await?;
        transaction.commit().await?;
        Ok(inserted)
    }

    async fn delete_version(&self, database: &str, version: i64) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = versions::delete(&mut transaction, database, version).await?;
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn aliases(&self, database: &str) -> Result<Vec<AliasRow>, CatalogueError> {
        aliases::list(&mut *self.read().await?, database).await
    }

    async fn all_aliases(&self) -> Result<Vec<AliasTarget>, CatalogueError> {
        aliases::list_all(&mut *self.read().await?).await
    }

    async fn set_alias(
        &self,
        database: &str,
        alias: &str,
        version: i64,
        expected: AliasExpectation,
    ) -> Result<(AliasRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let set = aliases::set(&mut transaction, database, alias, version, expected).await?;
        transaction.commit().await?;
        self.hint();
        Ok(set)
    }

    async fn delete_alias(
        &self,
        database: &str,
        alias: &str,
        expected: AliasExpectation,
    ) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = aliases::delete(&mut transaction, database, alias, expected).await?;
        transaction.commit().await?;
        self.hint();
        Ok(deleted)
    }

    async fn put_calibration(
        &self,
        name: &str,
        document: &str,
        expected: Option<i64>,
    ) -> Result<CalibrationRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let row = calibrations::put(&mut transaction, name, document, expected).await?;
        transaction.commit().await?;
        Ok(row)
    }

    async fn calibration(&self, name: &str) -> Result<Option<CalibrationRow>, CatalogueError> {
        calibrations::find(&mut *self.read().await?, name).await
    }

    async fn calibrations(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<CalibrationRow>, CatalogueError> {
        calibrations::list(&mut *self.read().await?, after, limit).await
    }

    async fn delete_calibration(&self, name: &str) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::cancel_all(&mut transaction, Subject::Calibration(name)).await?;
        let deleted = calibrations::delete(&mut transaction, name).await?;
        transaction.commit().await?;
        self.hint();
        Ok(deleted)
    }

    async fn enqueue_calibration_job(
        &self,
        kind: &str,
        calibration: &str,
        params: &str,
        blobs: &[String],
    ) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::enqueue_for_calibration(&mut transaction, kind, calibration, params, blobs).await?;
        transaction.commit().await?;
        self.hint();
        Ok(job)
    }

    async fn publish_calibration(
        &self,
        id: Uuid,
        token: i64,
        document: &str,
        expected: i64,
    ) -> Result<CalibrationRow, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::held_and_wanted(&mut transaction, id, token).await?;
        let job = jobs::finish(&mut transaction, id, token, JobState::Succeeded, Outcome::default()).await?;
        let name = job.calibration.unwrap_or_default();
        let row = calibrations::put(&mut transaction, &name, document, Some(expected)).await?;
        transaction.commit().await?;
        Ok(row)
    }

    async fn put_workcell(&self, name: &str, document: &str) -> Result<(WorkcellRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let put = workcells::put(&mut transaction, name, document).await?;
        transaction.commit().await?;
        Ok(put)
    }

    async fn workcell(&self, name: &str) -> Result<Option<WorkcellRow>, CatalogueError> {
        workcells::find(&mut *self.read().await?, name).await
    }

    async fn workcells(&self, after: Option<&str>, limit: u32) -> Result<Vec<WorkcellRow>, CatalogueError> {
        workcells::list(&mut *self.read().await?, after, limit).await
    }

    async fn delete_workcell(&self, name: &str) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = workcells::delete(&mut transaction, name).await?;
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn enqueue_job(&self, kind: &str, database: &str, params: &str) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::enqueue(&mut transaction, kind, database, params).await?;
        transaction.commit().await?;
        self.hint();
        Ok(job)
    }

    async fn job(&self, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
        jobs::find(&mut *self.read().await?, id).await
    }

    async fn jobs(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, CatalogueError> {
        jobs::list(&mut *self.read().await?, filter, after, limit).await
    }

    async fn claim_job(
        &self,
        owner: &str,
        kinds: &[&str],
        lease: Duration,
        max_attempts: u32,
    ) -> Result<Option<JobRow>, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::claim(&mut transaction, owner, kinds, lease, max_attempts).await?;
        transaction.commit().await?;
        Ok(job)
    }

    async fn renew_job(
        &self,
        id: Uuid,
        token: i64,
        lease: Duration,
        progress: Option<&Progress>,
    ) -> Result<Renewal, CatalogueError> {
        let mut transaction = self.write().await?;
        let renewal = jobs::renew(&mut transaction, id, token, lease, progress).await?;
        transaction.commit().await?;
        Ok(renewal)
    }

    async fn publish(
        &self,
        id: Uuid,
        token: i64,
        new: &NewVersion,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<VersionRow, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::held_and_wanted(&mut transaction, id, token).await?;
        let (version, _) = versions::insert(&mut transaction, new).await?;
        if let Some(alias) = promote_alias {
            aliases::set(&mut transaction, &new.database, alias, version.version, AliasExpectation::Any)
                .await?;
        }
        let outcome = Outcome { version: Some(version.version), comparison, ..Outcome::default() };
        jobs::finish(&mut transaction, id, token, JobState::Succeeded, outcome).await?;
        transaction.commit().await?;
        if promote_alias.is_some() {
            self.hint();
        }
        Ok(version)
    }

    async fn succeed_job(
        &self,
        id: Uuid,
        token: i64,
        version: Option<i64>,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::held_and_wanted(&mut transaction, id, token).await?;
        let outcome = Outcome { version, comparison, ..Outcome::default() };
        let job = jobs::finish(&mut transaction, id, token, JobState::Succeeded, outcome).await?;
        if let Some(version) = version {
            let database = job.database.as_deref().unwrap_or_default();
            if versions::find(&mut transaction, database, version).await?.is_none() {
                return Err(CatalogueError::no_version(database, version));
            }
            if let Some(alias) = promote_alias {
                aliases::set(&mut transaction, database, alias, version, AliasExpectation::Any).await?;
            }
        }
        transaction.commit().await?;
        if promote_alias.is_some() {
            self.hint();
        }
        Ok(job)
    }

    async fn fail_job(&self, id: Uuid, token: i64, problem: &str) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let outcome = Outcome { problem: Some(problem), ..Outcome::default() };
        let job = jobs::finish(&mut transaction, id, token, JobState::Failed, outcome).await?;
        transaction.commit().await?;
        Ok(job)
    }

    async fn cancelled_job(&self, id: Uuid, token: i64) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::finish(&mut transaction, id, token, JobState::Cancelled, Outcome::default()).await?;
        transaction.commit().await?;
        Ok(job)
    }

    async fn request_cancel(&self, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::request_cancel(&mut transaction, id).await?;
        transaction.commit().await?;
        self.hint();
        Ok(job)
    }

    async fn hand_back_jobs(&self, owner: &str) -> Result<u64, CatalogueError> {
        let mut transaction = self.write().await?;
        let handed_back = jobs::hand_back(&mut transaction, owner).await?;
        transaction.commit().await?;
        self.hint();
        Ok(handed_back)
    }

    async fn release_dead_leases(&self, except_owner: &str) -> Result<u64, CatalogueError> {
        let mut transaction = self.write().await?;
        let released = jobs::release_dead_leases(&mut transaction, except_owner).await?;
        transaction.commit().await?;
        Ok(released)
    }

    async fn job_events(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, CatalogueError> {
        jobs::events(&mut *self.read().await?, id, after).await
    }

    async fn jobs_by_state(&self) -> Result<Vec<(JobState, u64)>, CatalogueError> {
        jobs::count_by_state(&mut *self.read().await?).await
    }

    async fn note_process(&self, _row: &ProcessRow) -> Result<(), CatalogueError> {
        Ok(())
    }

    async fn processes(&self, _fresh: Duration) -> Result<Vec<ProcessRow>, CatalogueError> {
        Ok(Vec::new())
    }

    async fn is_blob_referenced(&self, blob: &str) -> Result<bool, CatalogueError> {
        Ok(sqlx::query_scalar(
            "SELECT EXISTS (SELECT 1 FROM exemplars WHERE blob = ?1)
                 OR EXISTS (SELECT 1 FROM versions WHERE blob = ?1)
                 OR EXISTS (SELECT 1 FROM job_blobs b JOIN jobs j ON j.id = b.job
                            WHERE b.blob = ?1 AND j.state IN ('queued', 'running'))",
        )
        .bind(blob)
        .fetch_one(&mut *self.read().await?)
        .await?)
    }

    fn hints(&self) -> watch::Receiver<u64> {
        self.hints.subscribe()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn open(directory: &Path) -> SqliteCatalogue {
        let lock = Arc::new(FolderLock::take(directory).unwrap());
        SqliteCatalogue::open(&directory.join("catalogue.sqlite"), lock).await.unwrap()
    }

    #[tokio::test]
    async fn what_was_committed_is_on_the_disk() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        let pragmas: (String, i64, i64) = sqlx::query_as(
            "SELECT journal_mode, synchronous, foreign_keys
             FROM pragma_journal_mode, pragma_synchronous, pragma_foreign_keys",
        )
        .fetch_one(&catalogue.writer)
        .await
        .unwrap();
        assert_eq!(pragmas, ("wal".to_owned(), 2, 1)); // 2 is FULL.
    }

    #[tokio::test]
    async fn jobs_of_the_first_release_are_kept_with_their_events() {
        let directory = tempfile::tempdir().unwrap();
        let options = SqliteConnectOptions::new()
            .filename(directory.path().join("catalogue.sqlite"))
            .create_if_missing(true)
            .foreign_keys(true);
        let old = SqlitePool::connect_with(options).await.unwrap();
        let first = Migrator { migrations: MIGRATIONS.migrations[..1].to_vec().into(), ..Migrator::DEFAULT };
        first.run(&old).await.unwrap();
        for statement in [
            "INSERT INTO jobs (id, kind, database, params, state, created_at)
             VALUES ('00000000-0000-4000-8000-000000000001', 'training', 'lab', '{}', 'queued', 7)",
            "INSERT INTO job_events (job, sequence, at, state, token, cancel_requested, attempts)
             VALUES ('00000000-0000-4000-8000-000000000001', 1, 7, 'queued', 0, 0, 0)",
        ] {
            sqlx::query(statement).execute(&old).await.unwrap();
        }
        old.close().await;

        let catalogue = open(directory.path()).await;
        let job = catalogue.job(Uuid::from_u128(0x4000_8000_0000_0000_0001)).await.unwrap().unwrap();
        assert_eq!((job.database.as_deref(), job.calibration.as_deref()), (Some("lab"), None));
        assert_eq!(catalogue.job_events(job.id, 0).await.unwrap().len(), 1);
        let claimed = catalogue.claim_job("w", &["training"], Duration::from_secs(1), 3).await.unwrap();
        assert_eq!(claimed.unwrap().id, job.id);
    }

    #[tokio::test]
    async fn readers_cannot_write() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        let refused = sqlx::query("DELETE FROM jobs").execute(&catalogue.readers).await.unwrap_err();
        assert!(refused.to_string().contains("readonly"), "{refused}");
    }

    #[tokio::test]
    async fn a_full_disk_makes_writes_unavailable_until_there_is_room() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        let large = "x".repeat(1 << 20);
        sqlx::query("PRAGMA max_page_count = 64").execute(&catalogue.writer).await.unwrap();
        let refused = catalogue.create_database("lab", "landmarks", &large).await.unwrap_err();
        assert!(matches!(refused, CatalogueError::Unavailable { .. }), "{refused:?}");
        assert_eq!(catalogue.databases(None, 9).await.unwrap(), []);

        sqlx::query("PRAGMA max_page_count = 100000").execute(&catalogue.writer).await.unwrap();
        assert!(catalogue.create_database("lab", "landmarks", &large).await.unwrap().1);
    }

    #[tokio::test]
    async fn a_row_that_cannot_be_ours_is_corrupt() {
        for (damage, column) in [
            ("UPDATE jobs SET attempts = -1", "attempts"),
            ("UPDATE jobs SET created_at = 9223372036854775807", "created_at"),
            (
                "INSERT INTO jobs (id, kind, database, params, state, created_at) VALUES ('x', '', '', '', 'queued', 0)",
                "id",
            ),
        ] {
            let directory = tempfile::tempdir().unwrap();
            let catalogue = open(directory.path()).await;
            catalogue.create_database("lab", "landmarks", "{}").await.unwrap();
            catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
            sqlx::query(damage).execute(&catalogue.writer).await.unwrap();
            let refused = catalogue.jobs(&JobFilter::default(), None, 9).await.unwrap_err();
            assert!(
                matches!(&refused, CatalogueError::Corrupt { what, .. } if what.starts_with(column)),
                "{refused:?}"
            );
        }
    }
}
