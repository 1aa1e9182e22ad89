//! The catalogue in one SQLite file: where transactions begin and end.
//!
//! The statements stand in one file per table and take a connection; this file decides what is one
//! transaction. Write-ahead log, `synchronous=FULL`: a call that returned survives power loss. One connection
//! writes (`BEGIN IMMEDIATE`, so a transaction never finds out halfway that it may not write), four read and
//! can do nothing else.

mod aliases;
mod audit;
mod calibrations;
mod connections;
mod databases;
mod exemplars;
mod jobs;
mod keys;
mod row;
mod versions;
mod workcells;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use jiff::Timestamp;
use serde_json::json;
use sqlx::migrate::Migrator;
use sqlx::pool::PoolConnection;
use sqlx::{Sqlite, SqliteConnection, Transaction};
use tokio::sync::watch;
use uuid::Uuid;

use self::connections::Connections;
use super::audit::{Actor, AuditFilter, AuditRow, Entry, document as kept};
use super::catalogue::{
    AliasExpectation, AliasRow, AliasTarget, CalibrationRow, Catalogue, CatalogueError, DatabaseCounts,
    DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow, JobFilter, JobRow, JobState, KeyRow, NewKey,
    NewVersion, ProcessRow, Progress, Renewal, Turn, VersionRow, WorkcellRow,
};
use super::folder::{CollectionLock, FolderLock};
use super::job_end::{Outcome, Subject};
use super::open::OpenCatalogueError;

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/sqlite");

/// The catalogue in a SQLite file.
#[derive(Debug)]
pub struct SqliteCatalogue {
    connections: Connections,
    hints: watch::Sender<u64>,
    data_dir: PathBuf,
    /// None where another process may be serving the file.
    _lock: Option<Arc<FolderLock>>,
}

impl SqliteCatalogue {
    /// Opens the catalogue, creates it if it isn't there, and brings its tables up to date.
    ///
    /// The lock of the folder that holds the file is kept as long as the catalogue lives.
    pub(in crate::store) async fn open(
        path: &Path,
        lock: Arc<FolderLock>,
    ) -> Result<Self, OpenCatalogueError> {
        let connections = Connections::open(path, true).await.map_err(OpenCatalogueError::of_sqlite)?;
        connections.migrate(&MIGRATIONS).await.map_err(OpenCatalogueError::of_sqlite_migration)?;
        let mut writer = connections.writer().await.map_err(OpenCatalogueError::of_sqlite)?;
        // Damage that nobody reads is found now, and not when a robot needs the row.
        let faults = faults(&mut writer, "PRAGMA quick_check(3)").await;
        if let Some(fault) = faults.map_err(OpenCatalogueError::of_sqlite)?.first() {
            return Err(OpenCatalogueError::Damaged { source: fault.clone().into() });
        }
        drop(writer);
        Ok(Self::over(path, connections, Some(lock)))
    }

    /// Opens the catalogue of a folder that another process may be serving: its tables must be of this release.
    pub(in crate::store) async fn open_beside(path: &Path) -> Result<Self, OpenCatalogueError> {
        let connections = Connections::open(path, false).await.map_err(OpenCatalogueError::of_sqlite)?;
        let mut writer = connections.writer().await.map_err(OpenCatalogueError::of_sqlite)?;
        let applied: Vec<i64> = sqlx::query_scalar("SELECT version FROM _sqlx_migrations ORDER BY version")
            .fetch_all(&mut *writer)
            .await
            .map_err(OpenCatalogueError::of_sqlite)?;
        drop(writer);
        let mut known = MIGRATIONS.iter().map(|migration| migration.version);
        if let Some(migration) = applied.iter().find(|applied| !known.clone().any(|known| known == **applied))
        {
            return Err(OpenCatalogueError::Newer { migration: *migration });
        }
        if let Some(migration) = known.find(|known| !applied.contains(known)) {
            return Err(OpenCatalogueError::Older { migration });
        }
        Ok(Self::over(path, connections, None))
    }

    fn over(path: &Path, connections: Connections, lock: Option<Arc<FolderLock>>) -> Self {
        let data_dir = path.parent().unwrap_or(Path::new(".")).to_owned();
        Self { connections, hints: watch::Sender::new(0), data_dir, _lock: lock }
    }

    /// Copies everything into a new file, as of one moment, while others read and write; synced by the caller.
    pub(in crate::store) async fn copy_to(&self, path: &Path) -> Result<(), CatalogueError> {
        let path = path.to_string_lossy();
        sqlx::query("VACUUM INTO ?1").bind(&*path).execute(&mut *self.connections.writer().await?).await?;
        Ok(())
    }

    /// Every blob that a row names, once.
    pub(in crate::store) async fn blobs_named(&self) -> Result<Vec<String>, CatalogueError> {
        Ok(sqlx::query_scalar(
            "SELECT blob FROM exemplars UNION SELECT blob FROM versions
             UNION SELECT b.blob FROM job_blobs b JOIN jobs j ON j.id = b.job WHERE j.state IN ('queued', 'running')",
        )
        .fetch_all(&mut *self.read().await?)
        .await?)
    }

    /// What SQLite finds wrong with the file, at most a few of it; nothing, when all is well.
    pub(in crate::store) async fn faults(&self) -> Result<Vec<String>, CatalogueError> {
        Ok(faults(&mut *self.connections.writer().await?, "PRAGMA integrity_check(9)").await?)
    }

    /// Ends the connections; the last one takes the write-ahead log with it.
    pub(in crate::store) async fn close(self) {
        self.connections.close().await;
    }

    async fn read(&self) -> Result<PoolConnection<Sqlite>, CatalogueError> {
        Ok(self.connections.read().await?)
    }

    async fn write(&self) -> Result<Transaction<'static, Sqlite>, CatalogueError> {
        Ok(self.connections.write().await?)
    }

    fn hint(&self) {
        self.hints.send_modify(|hints| *hints += 1);
    }
}

fn to_json(value: &impl serde::Serialize) -> Result<String, CatalogueError> {
    serde_json::to_string(value).map_err(|source| CatalogueError::Unavailable { source: source.into() })
}

async fn faults(connection: &mut SqliteConnection, check: &'static str) -> Result<Vec<String>, sqlx::Error> {
    let mut found: Vec<String> = sqlx::query_scalar(check).fetch_all(connection).await?;
    found.retain(|line| line != "ok");
    Ok(found)
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
        by: &Actor,
    ) -> Result<(DatabaseRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let created = databases::create(&mut transaction, name, kind, options).await?;
        if created.1 {
            let detail = json!({"kind": kind, "options": kept(options)});
            audit::append(&mut transaction, by, Entry::of("database.create").in_database(name).with(detail))
                .await?;
        }
        transaction.commit().await?;
        Ok(created)
    }

    async fn set_database_options(
        &self,
        name: &str,
        options: &str,
        by: &Actor,
    ) -> Result<DatabaseRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let row = databases::set_options(&mut transaction, name, options).await?;
        let detail = json!({"options": kept(options)});
        audit::append(&mut transaction, by, Entry::of("database.options").in_database(name).with(detail))
            .await?;
        transaction.commit().await?;
        Ok(row)
    }

    async fn database(&self, name: &str) -> Result<Option<DatabaseRow>, CatalogueError> {
        databases::find(&mut *self.read().await?, name).await
    }

    async fn databases(&self, after: Option<&str>, limit: u32) -> Result<Vec<DatabaseRow>, CatalogueError> {
        databases::list(&mut *self.read().await?, after, limit).await
    }

    async fn delete_database(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::cancel_all(&mut transaction, Subject::Database(name)).await?;
        let deleted = databases::delete(&mut transaction, name).await?;
        if deleted {
            audit::append(&mut transaction, by, Entry::of("database.delete").in_database(name)).await?;
        }
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

    async fn delete_exemplar(&self, database: &str, id: Uuid, by: &Actor) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = exemplars::delete(&mut transaction, database, id).await?;
        if deleted {
            audit::append(&mut transaction, by, Entry::of("exemplar.delete").in_database(database).about(id))
                .await?;
        }
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn delete_exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        by: &Actor,
    ) -> Result<u64, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = exemplars::delete_matching(&mut transaction, database, filter).await?;
        if deleted > 0 {
            audit::append(
                &mut transaction,
                by,
                Entry::of("exemplar.delete").in_database(database).with(filter.detail(deleted)),
            )
            .await?;
        }
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

    async fn digests(
        &self,
        versions: &[(String, i64)],
    ) -> Result<Vec<(String, i64, String)>, CatalogueError> {
        versions::digests(&mut *self.read().await?, &to_json(&versions)?).await
    }

    async fn version_by_digest(
        &self,
        database: &str,
        digest: &str,
    ) -> Result<Option<VersionRow>, CatalogueError> {
        versions::find_by_digest(&mut *self.read().await?, database, digest).await
    }

    async fn insert_version(
        &self,
        new: &NewVersion,
        by: &Actor,
    ) -> Result<(VersionRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let inserted = versions::insert(&mut transaction, new).await?;
        if inserted.1 {
            let entry = Entry::of("version.import").in_database(&new.database).about(inserted.0.version);
            audit::append(&mut transaction, by, entry.with(json!({"digest": new.digest}))).await?;
        }
        transaction.commit().await?;
        Ok(inserted)
    }

    async fn delete_version(&self, database: &str, version: i64, by: &Actor) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = versions::delete(&mut transaction, database, version).await?;
        if deleted {
            audit::append(
                &mut transaction,
                by,
                Entry::of("version.delete").in_database(database).about(version),
            )
            .await?;
        }
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
        by: &Actor,
    ) -> Result<(AliasRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let set = aliases::set(&mut transaction, database, alias, version, expected).await?;
        let entry = Entry::of("alias.set").in_database(database).about(alias);
        audit::append(&mut transaction, by, entry.with(json!({"version": version}))).await?;
        transaction.commit().await?;
        self.hint();
        Ok(set)
    }

    async fn delete_alias(
        &self,
        database: &str,
        alias: &str,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = aliases::delete(&mut transaction, database, alias, expected).await?;
        if deleted {
            audit::append(&mut transaction, by, Entry::of("alias.delete").in_database(database).about(alias))
                .await?;
        }
        transaction.commit().await?;
        self.hint();
        Ok(deleted)
    }

    async fn put_calibration(
        &self,
        name: &str,
        document: &str,
        expected: Option<i64>,
        by: &Actor,
    ) -> Result<CalibrationRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let row = calibrations::put(&mut transaction, name, document, expected).await?;
        let detail = json!({"document": kept(document)});
        audit::append(&mut transaction, by, Entry::of("calibration.put").about(name).with(detail)).await?;
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

    async fn delete_calibration(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        jobs::cancel_all(&mut transaction, Subject::Calibration(name)).await?;
        let deleted = calibrations::delete(&mut transaction, name).await?;
        if deleted {
            audit::append(&mut transaction, by, Entry::of("calibration.delete").about(name)).await?;
        }
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
        by: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::enqueue_for_calibration(&mut transaction, kind, calibration, params, blobs).await?;
        let detail = json!({"job": job.id, "kind": kind});
        audit::append(&mut transaction, by, Entry::of("job.queue").about(calibration).with(detail)).await?;
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
        audit::append(&mut transaction, &Actor::job(id), Entry::of("calibration.put").about(&name)).await?;
        transaction.commit().await?;
        Ok(row)
    }

    async fn put_workcell(
        &self,
        name: &str,
        document: &str,
        by: &Actor,
    ) -> Result<(WorkcellRow, bool), CatalogueError> {
        let mut transaction = self.write().await?;
        let put = workcells::put(&mut transaction, name, document).await?;
        let detail = json!({"document": kept(document)});
        audit::append(&mut transaction, by, Entry::of("workcell.put").about(name).with(detail)).await?;
        transaction.commit().await?;
        Ok(put)
    }

    async fn workcell(&self, name: &str) -> Result<Option<WorkcellRow>, CatalogueError> {
        workcells::find(&mut *self.read().await?, name).await
    }

    async fn workcells(&self, after: Option<&str>, limit: u32) -> Result<Vec<WorkcellRow>, CatalogueError> {
        workcells::list(&mut *self.read().await?, after, limit).await
    }

    async fn delete_workcell(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        let mut transaction = self.write().await?;
        let deleted = workcells::delete(&mut transaction, name).await?;
        if deleted {
            audit::append(&mut transaction, by, Entry::of("workcell.delete").about(name)).await?;
        }
        transaction.commit().await?;
        Ok(deleted)
    }

    async fn enqueue_job(
        &self,
        kind: &str,
        database: &str,
        params: &str,
        by: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::enqueue(&mut transaction, kind, database, params).await?;
        let detail = json!({"kind": kind, "params": kept(params)});
        audit::append(
            &mut transaction,
            by,
            Entry::of("job.queue").in_database(database).about(job.id).with(detail),
        )
        .await?;
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
        let (version, is_new) = versions::insert(&mut transaction, new).await?;
        if is_new {
            let entry = Entry::of("version.publish").in_database(&new.database).about(version.version);
            audit::append(&mut transaction, &Actor::job(id), entry.with(json!({"digest": new.digest})))
                .await?;
        }
        if let Some(alias) = promote_alias {
            aliases::set(&mut transaction, &new.database, alias, version.version, AliasExpectation::Any)
                .await?;
            let entry = Entry::of("alias.set").in_database(&new.database).about(alias);
            audit::append(&mut transaction, &Actor::job(id), entry.with(json!({"version": version.version})))
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
                let entry = Entry::of("alias.set").in_database(database).about(alias);
                audit::append(&mut transaction, &Actor::job(id), entry.with(json!({"version": version})))
                    .await?;
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

    async fn request_cancel(&self, id: Uuid, by: &Actor) -> Result<Option<JobRow>, CatalogueError> {
        let mut transaction = self.write().await?;
        let job = jobs::request_cancel(&mut transaction, id).await?;
        if let Some(job) = &job {
            let entry = Entry { database: job.database.as_deref(), ..Entry::of("job.cancel") };
            audit::append(&mut transaction, by, entry.about(id)).await?;
        }
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

    async fn insert_key(&self, new: &NewKey, by: &Actor) -> Result<KeyRow, CatalogueError> {
        let mut transaction = self.write().await?;
        let row = keys::insert(&mut transaction, new).await?;
        audit::append(&mut transaction, by, Entry::of("key.create").about(&new.id).with(new.detail()))
            .await?;
        transaction.commit().await?;
        self.hint();
        Ok(row)
    }

    async fn keys(&self) -> Result<Vec<KeyRow>, CatalogueError> {
        keys::list(&mut *self.read().await?).await
    }

    async fn revoke_key(&self, id: &str, by: &Actor) -> Result<Option<bool>, CatalogueError> {
        let mut transaction = self.write().await?;
        if keys::find(&mut transaction, id).await?.is_none() {
            return Ok(None);
        }
        let revoked = keys::revoke(&mut transaction, id).await?;
        if revoked {
            audit::append(&mut transaction, by, Entry::of("key.revoke").about(id)).await?;
        }
        transaction.commit().await?;
        self.hint();
        Ok(Some(revoked))
    }

    async fn note_key_uses(&self, uses: &[(String, Timestamp)]) -> Result<(), CatalogueError> {
        let mut transaction = self.write().await?;
        for (id, at) in uses {
            keys::note_use(&mut transaction, id, at.as_microsecond()).await?;
        }
        Ok(transaction.commit().await?)
    }

    async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<i64>,
        limit: u32,
    ) -> Result<Vec<AuditRow>, CatalogueError> {
        audit::list(&mut *self.read().await?, filter, before, limit).await
    }

    async fn blobs_referenced(&self, blobs: &[String]) -> Result<Vec<String>, CatalogueError> {
        Ok(sqlx::query_scalar(
            "SELECT value FROM json_each(?1)
             WHERE EXISTS (SELECT 1 FROM exemplars WHERE blob = value)
                OR EXISTS (SELECT 1 FROM versions WHERE blob = value)
                OR EXISTS (SELECT 1 FROM job_blobs b JOIN jobs j ON j.id = b.job
                           WHERE b.blob = value AND j.state IN ('queued', 'running'))",
        )
        .bind(to_json(&blobs)?)
        .fetch_all(&mut *self.read().await?)
        .await?)
    }

    async fn turn_to_collect(&self) -> Result<Option<Turn>, CatalogueError> {
        let turn = CollectionLock::alone(&self.data_dir);
        Ok(turn
            .map_err(|source| CatalogueError::Unavailable { source: source.into() })?
            .map(|lock| Box::new(lock) as Turn))
    }

    fn hints(&self) -> watch::Receiver<u64> {
        self.hints.subscribe()
    }
}

#[cfg(test)]
mod tests {
    use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};

    use super::*;
    use crate::store::suite::by;

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
        .fetch_one(&mut *catalogue.connections.writer().await.unwrap())
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
        let refused =
            sqlx::query("DELETE FROM jobs").execute(&mut *catalogue.read().await.unwrap()).await.unwrap_err();
        assert!(refused.to_string().contains("readonly"), "{refused}");
    }

    #[tokio::test]
    async fn the_audit_record_is_neither_rewritten_nor_shortened() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        for statement in ["UPDATE audit SET actor = 'somebody else'", "DELETE FROM audit"] {
            let refused = sqlx::query(statement)
                .execute(&mut *catalogue.connections.writer().await.unwrap())
                .await
                .unwrap_err();
            assert!(refused.to_string().contains("append-only"), "{refused}");
        }
        let record = catalogue.audit(&AuditFilter::default(), None, 9).await.unwrap();
        assert_eq!(record.iter().map(|row| row.actor.name.as_str()).collect::<Vec<_>>(), ["tester"]);
    }

    #[tokio::test]
    async fn a_full_disk_makes_writes_unavailable_until_there_is_room() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        let large = "x".repeat(1 << 20);
        sqlx::query("PRAGMA max_page_count = 64")
            .execute(&mut *catalogue.connections.writer().await.unwrap())
            .await
            .unwrap();
        let refused = catalogue.create_database("lab", "landmarks", &large, by()).await.unwrap_err();
        assert!(matches!(refused, CatalogueError::Unavailable { .. }), "{refused:?}");
        assert_eq!(catalogue.databases(None, 9).await.unwrap(), []);

        sqlx::query("PRAGMA max_page_count = 100000")
            .execute(&mut *catalogue.connections.writer().await.unwrap())
            .await
            .unwrap();
        assert!(catalogue.create_database("lab", "landmarks", &large, by()).await.unwrap().1);
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
            catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
            catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
            sqlx::query(damage).execute(&mut *catalogue.connections.writer().await.unwrap()).await.unwrap();
            let refused = catalogue.jobs(&JobFilter::default(), None, 9).await.unwrap_err();
            assert!(
                matches!(&refused, CatalogueError::Corrupt { what, .. } if what.starts_with(column)),
                "{refused:?}"
            );
        }
    }
}
