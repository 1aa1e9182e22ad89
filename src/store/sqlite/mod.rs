//! The catalogue's SQLite file.
//!
//! Write-ahead log, `synchronous=FULL`: a call that returned survives power loss. One connection writes, four read and
//! can do nothing else.

mod connections;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use sqlx::migrate::Migrator;
use sqlx::pool::PoolConnection;
use sqlx::{Sqlite, SqliteConnection};
use tokio::sync::watch;

use self::connections::Connections;
pub use self::connections::begin;
use super::error::{CatalogueError, is_read_only};
use super::file_lock::{FileLock, collection_lock_path};
use super::open::OpenCatalogueError;

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/sqlite");

/// A SQLite file and the connections to it.
#[derive(Debug)]
pub struct SqliteFile {
    connections: Connections,
    changes: watch::Sender<u64>,
    data_dir: PathBuf,
    /// None where another process may be serving the file.
    _lock: Option<Arc<FileLock>>,
}

impl SqliteFile {
    /// Opens the file, creates it if it isn't there, and brings its tables up to date.
    ///
    /// The lock of the folder that holds the file is kept as long as the value lives.
    pub async fn open(path: &Path, lock: Arc<FileLock>) -> Result<Self, OpenCatalogueError> {
        let connections = Connections::open(path, true).await.map_err(OpenCatalogueError::from_sqlite)?;
        connections.migrate(&MIGRATIONS).await.map_err(OpenCatalogueError::from_sqlite_migration)?;
        let mut writer = connections.writer().await.map_err(OpenCatalogueError::from_sqlite)?;
        // Finds damage now that otherwise shows when a robot needs the row.
        let faults = faults(&mut writer, "PRAGMA quick_check(3)").await;
        if let Some(fault) = faults.map_err(OpenCatalogueError::from_sqlite)?.first() {
            return Err(OpenCatalogueError::Damaged { source: fault.clone().into() });
        }
        drop(writer);
        Ok(Self::new(path, connections, Some(lock)))
    }

    /// Opens the file of a folder that another process may be serving: its tables must be of this release.
    pub async fn open_unlocked(path: &Path) -> Result<Self, OpenCatalogueError> {
        let connections = Connections::open(path, false).await.map_err(OpenCatalogueError::from_sqlite)?;
        let mut writer = connections.writer().await.map_err(OpenCatalogueError::from_sqlite)?;
        let applied: Vec<i64> = sqlx::query_scalar("SELECT version FROM _sqlx_migrations ORDER BY version")
            .fetch_all(&mut *writer)
            .await
            .map_err(OpenCatalogueError::from_sqlite)?;
        drop(writer);
        let mut known = MIGRATIONS.iter().map(|migration| migration.version);
        if let Some(migration) = applied.iter().find(|applied| !known.clone().any(|known| known == **applied))
        {
            return Err(OpenCatalogueError::Newer { migration: *migration });
        }
        if let Some(migration) = known.find(|known| !applied.contains(known)) {
            return Err(OpenCatalogueError::Older { migration });
        }
        Ok(Self::new(path, connections, None))
    }

    fn new(path: &Path, connections: Connections, lock: Option<Arc<FileLock>>) -> Self {
        let data_dir = path.parent().unwrap_or(Path::new(".")).to_owned();
        Self { connections, changes: watch::Sender::new(0), data_dir, _lock: lock }
    }

    /// The file whose exclusive lock is for collecting orphans.
    pub fn collection_lock_path(&self) -> PathBuf {
        collection_lock_path(&self.data_dir)
    }

    /// A connection that can only read.
    pub async fn reader(&self) -> Result<PoolConnection<Sqlite>, CatalogueError> {
        Ok(self.connections.reader().await?)
    }

    /// The one connection that writes. A new one fails while others of the process hold the log's index, opened when the
    /// disk took no writes: then all are opened again.
    pub async fn writer(&self) -> Result<PoolConnection<Sqlite>, CatalogueError> {
        match self.connections.writer().await {
            Ok(connection) => Ok(connection),
            Err(error) => {
                self.recover(error.into(), 1).await?;
                Ok(self.connections.writer().await?)
            }
        }
    }

    /// Reconnects after the first attempt of a call that failed because the disk took no writes when the file was
    /// opened. Errors: `error` itself where that doesn't help.
    pub async fn recover(&self, error: CatalogueError, attempts: u32) -> Result<(), CatalogueError> {
        if attempts == 1 && is_read_only(&error) && self.connections.takes_files() {
            self.connections.reopen().await;
            Ok(())
        } else {
            Err(error)
        }
    }

    /// Notifies this process of a change.
    pub fn notify(&self) {
        self.changes.send_modify(|changes| *changes += 1);
    }

    /// A number that grows with each notification.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changes.subscribe()
    }

    /// Copies everything into a new file, as of one moment, while others read and write; the caller syncs it.
    pub async fn copy_to(&self, path: &Path) -> Result<(), CatalogueError> {
        let path = path.to_string_lossy();
        sqlx::query("VACUUM INTO ?1").bind(&*path).execute(&mut *self.writer().await?).await?;
        Ok(())
    }

    /// Every blob that a row names, once.
    pub async fn blobs_named(&self) -> Result<Vec<String>, CatalogueError> {
        Ok(sqlx::query_scalar(
            "SELECT blob FROM exemplars UNION SELECT blob FROM versions
             UNION SELECT b.blob FROM job_blobs b JOIN jobs j ON j.id = b.job WHERE j.state IN ('queued', 'running')",
        )
        .fetch_all(&mut *self.reader().await?)
        .await?)
    }

    /// What SQLite finds wrong with the file, at most nine lines; none when all is well.
    pub async fn faults(&self) -> Result<Vec<String>, CatalogueError> {
        Ok(faults(&mut *self.writer().await?, "PRAGMA integrity_check(9)").await?)
    }

    /// Closes the connections; the last one removes the write-ahead log.
    pub async fn close(self) {
        self.connections.close().await;
    }
}

async fn faults(connection: &mut SqliteConnection, check: &'static str) -> Result<Vec<String>, sqlx::Error> {
    let mut found: Vec<String> = sqlx::query_scalar(check).fetch_all(connection).await?;
    found.retain(|line| line != "ok");
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};
    use uuid::Uuid;

    use super::*;
    use crate::store::session::Backend;
    use crate::store::suite::by;
    use crate::store::{AuditFilter, Catalogue, JobFilter};

    async fn open(directory: &Path) -> Catalogue {
        let lock = Arc::new(FileLock::try_exclusive(&directory.join("lock")).unwrap().unwrap());
        let file = SqliteFile::open(&directory.join("catalogue.sqlite"), lock).await.unwrap();
        Catalogue::new(Backend::Sqlite(file))
    }

    fn file(catalogue: &Catalogue) -> &SqliteFile {
        match &catalogue.backend {
            Backend::Sqlite(file) => file,
            Backend::Postgres(server) => panic!("{server:?} is no file"),
        }
    }

    #[tokio::test]
    async fn what_was_committed_is_on_the_disk() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        let pragmas: (String, i64, i64) = sqlx::query_as(
            "SELECT journal_mode, synchronous, foreign_keys
             FROM pragma_journal_mode, pragma_synchronous, pragma_foreign_keys",
        )
        .fetch_one(&mut *file(&catalogue).writer().await.unwrap())
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
        let refused = sqlx::query("DELETE FROM jobs")
            .execute(&mut *file(&catalogue).reader().await.unwrap())
            .await
            .unwrap_err();
        assert!(refused.to_string().contains("readonly"), "{refused}");
    }

    #[tokio::test]
    async fn the_audit_record_is_neither_rewritten_nor_shortened() {
        let directory = tempfile::tempdir().unwrap();
        let catalogue = open(directory.path()).await;
        catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        for statement in ["UPDATE audit SET actor = 'somebody else'", "DELETE FROM audit"] {
            let refused = sqlx::query(statement)
                .execute(&mut *file(&catalogue).writer().await.unwrap())
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
            .execute(&mut *file(&catalogue).writer().await.unwrap())
            .await
            .unwrap();
        let refused = catalogue.create_database("lab", "landmarks", &large, by()).await.unwrap_err();
        assert!(matches!(refused, CatalogueError::Unavailable { .. }), "{refused:?}");
        assert_eq!(catalogue.databases(None, 9).await.unwrap(), []);

        sqlx::query("PRAGMA max_page_count = 100000")
            .execute(&mut *file(&catalogue).writer().await.unwrap())
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
            sqlx::query(damage).execute(&mut *file(&catalogue).writer().await.unwrap()).await.unwrap();
            let refused = catalogue.jobs(&JobFilter::default(), None, 9).await.unwrap_err();
            assert!(
                matches!(&refused, CatalogueError::Corrupt { what, .. } if what.starts_with(column)),
                "{refused:?}"
            );
        }
    }
}
