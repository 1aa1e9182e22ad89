//! The connections to the catalogue's file: one that writes, a few that read and can do nothing else.

use std::path::{Path, PathBuf};
use std::time::Duration;

use sqlx::migrate::{MigrateError, Migrator};
use sqlx::pool::PoolConnection;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};
use sqlx::{Connection, Sqlite, Transaction};
use tokio::sync::RwLock;

use super::super::row::is_read_only;

/// Readers beside the one writer: recognition reads no rows, so these serve lists and readiness only.
const READERS: u32 = 4;

/// How long a call waits for its turn before it is `Unavailable`.
const TURN_TIMEOUT: Duration = Duration::from_secs(10);

/// What the write-ahead log is cut to when it begins anew. It begins anew every thousand pages (4 MiB) or so, later
/// only while somebody copies the catalogue.
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
    /// Connections are opened when they are needed first.
    fn to(path: &Path, create: bool) -> Self {
        let readers = options(path).pragma("query_only", "ON");
        Self {
            writer: pool(1).connect_lazy_with(options(path).create_if_missing(create)),
            readers: pool(READERS).connect_lazy_with(readers),
        }
    }

    /// Ends the connections, each when it is given back.
    async fn close(&self) {
        self.readers.close().await;
        self.writer.close().await;
    }
}

impl Connections {
    /// Connections to the file; `create` makes it if it isn't there.
    pub async fn open(path: &Path, create: bool) -> Result<Self, sqlx::Error> {
        let pools = Pools::to(path, create);
        pools.writer.acquire().await?;
        Ok(Self { path: path.to_owned(), pools: RwLock::new(pools) })
    }

    /// Brings the tables up to date.
    pub async fn migrate(&self, migrations: &Migrator) -> Result<(), MigrateError> {
        let writer = self.pools.read().await.writer.clone();
        migrations.run(&writer).await
    }

    /// The one connection that writes, outside a transaction.
    pub async fn writer(&self) -> Result<PoolConnection<Sqlite>, sqlx::Error> {
        self.pools.read().await.writer.acquire().await
    }

    /// A connection that reads.
    pub async fn read(&self) -> Result<PoolConnection<Sqlite>, sqlx::Error> {
        self.pools.read().await.readers.acquire().await
    }

    /// Begins a transaction that writes; dropped without a commit, it is rolled back.
    pub async fn write(&self) -> Result<Transaction<'static, Sqlite>, sqlx::Error> {
        match self.begin().await {
            Err(error) if is_read_only(&error) && self.takes_files() => {
                self.open_anew().await;
                self.begin().await
            }
            begun => begun,
        }
    }

    async fn begin(&self) -> Result<Transaction<'static, Sqlite>, sqlx::Error> {
        let mut transaction = self.pools.read().await.writer.begin_with("BEGIN IMMEDIATE").await?;
        // On a file that could be opened for reading only that began a transaction that only reads: this would write.
        sqlx::query("DELETE FROM jobs WHERE FALSE").execute(&mut *transaction).await?;
        Ok(transaction)
    }

    /// What SQLite opened while the disk took no writes stays open for reading only: the file itself, by connection,
    /// and the log's index, by process, as long as any connection is left. So all of them go, once the disk is well.
    async fn open_anew(&self) {
        let mut pools = self.pools.write().await;
        pools.close().await;
        *pools = Pools::to(&self.path, false);
    }

    /// Whether files can be made beside the catalogue again. While they can't, what is open can at least be read.
    fn takes_files(&self) -> bool {
        let probe = self.path.with_extension("probe");
        std::fs::write(&probe, "probe").and_then(|()| std::fs::remove_file(&probe)).is_ok()
    }

    /// Ends all connections; the last one takes the write-ahead log with it.
    pub async fn close(&self) {
        self.pools.read().await.close().await;
    }
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
        .acquire_timeout(TURN_TIMEOUT)
        .idle_timeout(None)
        .max_lifetime(None)
        // When the disk fails, SQLite may end a transaction by itself; the driver then finds nothing to roll back, takes
        // it for open still, and would never begin another one.
        .after_release(|connection, _| {
            Box::pin(async move {
                // Behind whatever is being rolled back.
                connection.ping().await?;
                Ok(!connection.is_in_transaction())
            })
        })
}
