//! The connections to the catalogue's file: one that writes, a few that read and can do nothing else.

use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::migrate::{MigrateError, Migrator};
use sqlx::pool::PoolConnection;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};
use sqlx::{Connection, Sqlite, SqliteConnection, Transaction};
use tokio::sync::RwLock;

/// Readers beside the one writer: recognition reads no rows, so these serve lists and readiness only.
const READERS: u32 = 4;

/// How long a call waits for a connection before it is `Unavailable`.
const ACQUIRE_TIMEOUT: Duration = Duration::from_secs(10);

/// What the write-ahead log is truncated to at a checkpoint. There is one every thousand pages (4 MiB) or so, and none
/// while the catalogue is being copied.
const MAX_IDLE_LOG_BYTES: &str = "67108864";

/// How long SQLite waits for another program that holds the file, a backup for instance.
const BUSY_TIMEOUT: Duration = Duration::from_secs(5);

/// All connections of this process to the file.
#[derive(Debug)]
pub struct Connections {
    path: PathBuf,
    pools: RwLock<Pools>,
}

#[derive(Debug)]
struct Pools {
    writer: SqlitePool,
    readers: SqlitePool,
}

impl Pools {
    /// Pools that open their connections when they are first needed.
    fn new(path: &Path, create: bool) -> Self {
        let readers = options(path).pragma("query_only", "ON");
        Self {
            writer: pool(1).connect_lazy_with(options(path).create_if_missing(create)),
            readers: pool(READERS).connect_lazy_with(readers),
        }
    }

    /// Closes the connections, each when it is returned.
    async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }
}

impl Connections {
    /// Connections to the file; `create` makes it if it isn't there.
    pub async fn open(path: &Path, create: bool) -> Result<Self, sqlx::Error> {
        let pools = Pools::new(path, create);
        pools.writer.acquire().await?;
        Ok(Self { path: path.to_owned(), pools: RwLock::new(pools) })
    }

    /// Brings the tables up to date.
    pub async fn migrate(&self, migrations: &Migrator) -> Result<(), MigrateError> {
        let writer = self.pools.read().await.writer.clone();
        migrations.run(&writer).await
    }

    /// The one connection that writes.
    pub async fn writer(&self) -> Result<PoolConnection<Sqlite>, sqlx::Error> {
        self.pools.read().await.writer.acquire().await
    }

    /// A connection that reads.
    pub async fn reader(&self) -> Result<PoolConnection<Sqlite>, sqlx::Error> {
        self.pools.read().await.readers.acquire().await
    }

    /// Closes all connections and opens the file again.
    ///
    /// What SQLite opened while the disk took no writes stays open for reading only: the file itself as long as its
    /// connection, and the log's index as long as any connection of the process.
    pub async fn reopen(&self) {
        let mut pools = self.pools.write().await;
        pools.close().await;
        *pools = Pools::new(&self.path, false);
    }

    /// Whether a file can be created beside the catalogue. While none can, what is open can at least be read.
    pub fn takes_files(&self) -> bool {
        let probe = self.path.with_extension("probe");
        std::fs::write(&probe, "probe").and_then(|()| std::fs::remove_file(&probe)).is_ok()
    }

    /// Closes all connections; the last one removes the write-ahead log.
    pub async fn close(&self) {
        self.pools.read().await.close().await;
    }
}

/// Begins a transaction that writes at once, so that it can't find out halfway that it may not.
pub async fn begin(connection: &mut SqliteConnection) -> Result<Transaction<'_, Sqlite>, sqlx::Error> {
    let mut transaction = connection.begin_with("BEGIN IMMEDIATE").await?;
    // On a file that could be opened for reading only, that began a transaction that only reads: this fails there.
    sqlx::query("DELETE FROM jobs WHERE FALSE").execute(&mut *transaction).await?;
    Ok(transaction)
}

fn options(path: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(path)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY_TIMEOUT)
        .pragma("journal_size_limit", MAX_IDLE_LOG_BYTES)
}

/// Connections live as long as the pool: opening one again costs more than keeping it.
fn pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(ACQUIRE_TIMEOUT)
        .idle_timeout(None)
        .max_lifetime(None)
        // When the disk fails, SQLite may end a transaction by itself. The driver then finds nothing to roll back, takes
        // the transaction to be open still, and would never begin another one.
        .after_release(|connection, _| {
            Box::pin(async move {
                // Runs after a rollback that is still under way.
                connection.ping().await?;
                Ok(!connection.is_in_transaction())
            })
        })
}
