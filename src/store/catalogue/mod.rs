//! The catalogue: the rows of the service, in SQLite or PostgreSQL.
//!
//! This room decides which statements make a transaction, in one file for each kind of rows. Transactions in PostgreSQL
//! run under READ COMMITTED, and lock the rows that they decide by, always in this order, so that no two wait for each
//! other:
//!
//! 1. the row of the database, or the counter of the calibrations and then the calibration's row;
//! 2. the rows of jobs, by id (a claim waits for none: it skips what is locked);
//! 3. everything below them: versions, aliases, exemplars, events, blobs.
//!
//! Whoever has locked a database's row is alone with its versions and aliases. Exemplars and jobs are added under a
//! weaker lock, which only keeps the database from being deleted. In SQLite a transaction that writes holds the file.
//!
//! Two guards keep writers apart. An alias carries a revision, and moves by compare-and-swap. A job carries a token that
//! counts its claims, and a worker's writes name the token they were given, so that a worker which lost its lease can
//! finish nothing.

mod calibrations;
mod databases;
mod jobs;
mod keys;

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use uuid::Uuid;

use super::error::CatalogueError;
use super::file_lock::FileLock;
use super::open::OpenCatalogueError;
use super::postgres::PostgresServer;
use super::session::{Backend, statement, transaction};
use super::tables::databases as databases_table;
use super::tables::processes::{self, ProcessRow};

/// The right to collect orphans, which only one process has at a time; it ends when the value is dropped.
pub type CollectionGuard = Box<dyn Send>;

/// Opens the catalogue in a PostgreSQL database, and brings its tables up to date; several processes may do so at once,
/// one after the other then. Gives the catalogue's own id too, which marks its bucket.
///
/// The address is `postgres://user:password@host:port/database`, with libpq's `host` (a socket's folder), `sslmode` and
/// `sslrootcert` as parameters. Connections are made as they are needed, and lost ones made again.
///
/// # Errors
/// `Unavailable` may heal by itself, no other does.
pub async fn open_postgres(address: &str) -> Result<(Arc<Catalogue>, Uuid), OpenCatalogueError> {
    let (server, id) = PostgresServer::open(address).await?;
    Ok((Arc::new(Catalogue::new(Backend::Postgres(Box::new(server)))), id))
}

/// The one truth about databases, exemplars, versions, aliases, calibrations, workcells and jobs.
///
/// Every call is one transaction: it happened wholly, durably, or not at all. Dropping the future of a call leaves it
/// done or undone, never half. Any call may fail with `Unavailable` or `Corrupt`; the other errors are named at the calls
/// that give them. A call that changes something for somebody takes the actor, and writes the entry in the audit record
/// in the same transaction; a call that finds nothing to change writes none.
///
/// The catalogue reads the clock itself, a shared one its server's; times have microsecond resolution, UTC.
#[derive(Debug)]
pub struct Catalogue {
    pub(in crate::store) backend: Backend,
}

impl Catalogue {
    /// The catalogue that this database keeps.
    pub(in crate::store) fn new(backend: Backend) -> Self {
        Self { backend }
    }

    /// Succeeds when the catalogue can be read.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn ping(&self) -> Result<(), CatalogueError> {
        statement!(self, c => databases_table::list(c, None, 1).await.map(drop))
    }

    /// Records what this process reports, for the others that share the catalogue.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn record_process(&self, row: &ProcessRow) -> Result<(), CatalogueError> {
        if !self.is_shared() {
            return Ok(());
        }
        transaction!(self, c => processes::record(c, row).await)
    }

    /// The processes that reported within the time `fresh`, by the time of their start; none when no other process
    /// shares the catalogue.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn processes(&self, fresh: Duration) -> Result<Vec<ProcessRow>, CatalogueError> {
        if !self.is_shared() {
            return Ok(Vec::new());
        }
        statement!(self, c => processes::list(c, fresh).await)
    }

    /// Those of these blobs that an exemplar, a version or a job that hasn't ended names.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn blobs_referenced(&self, blobs: &[String]) -> Result<Vec<String>, CatalogueError> {
        statement!(self, c => {
            c.query_per_dialect(
                "SELECT value FROM json_each($1)
                 WHERE EXISTS (SELECT 1 FROM exemplars WHERE blob = value)
                    OR EXISTS (SELECT 1 FROM versions WHERE blob = value)
                    OR EXISTS (SELECT 1 FROM job_blobs b JOIN jobs j ON j.id = b.job
                               WHERE b.blob = value AND j.state IN ('queued', 'running'))",
                "SELECT name FROM unnest($1) AS name
                 WHERE EXISTS (SELECT 1 FROM exemplars WHERE blob = name)
                    OR EXISTS (SELECT 1 FROM versions WHERE blob = name)
                    OR EXISTS (SELECT 1 FROM job_blobs b JOIN jobs j ON j.id = b.job
                               WHERE b.blob = name AND j.state IN ('queued', 'running'))",
            )
            .bind_list(blobs)
            .fetch_all()
            .await
        })
    }

    /// Takes the right to collect orphans; none while another process has it, or copies the blobs.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn try_lock_collection(&self) -> Result<Option<CollectionGuard>, CatalogueError> {
        match &self.backend {
            Backend::Sqlite(file) => {
                let lock = FileLock::try_exclusive(&file.collection_lock_path())
                    .map_err(|source| CatalogueError::Unavailable { source: source.into() })?;
                Ok(lock.map(|lock| Box::new(lock) as CollectionGuard))
            }
            Backend::Postgres(server) => {
                let locked = self.backend.bounded(async { Ok(server.try_lock_collection().await?) }).await?;
                Ok(locked.map(|connection| Box::new(connection) as CollectionGuard))
            }
        }
    }

    /// A number that grows soon after any process moved or deleted an alias, made or revoked a key, queued a job, asked
    /// one to end, or deleted what jobs are about. What happened before this call counts as seen.
    ///
    /// Not to be relied on alone: the number may grow without a change, and doesn't grow while the catalogue can't be
    /// reached, so who waits for it has to look now and then all the same.
    pub fn change_notifications(&self) -> watch::Receiver<u64> {
        match &self.backend {
            Backend::Sqlite(file) => file.changes(),
            Backend::Postgres(server) => server.changes(),
        }
    }

    /// Whether several processes share the catalogue.
    fn is_shared(&self) -> bool {
        matches!(self.backend, Backend::Postgres(_))
    }
}
