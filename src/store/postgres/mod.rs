//! The catalogue's PostgreSQL server: connections, limits, and which calls are worth another attempt.

mod notifications;
#[cfg(test)]
mod tests;

use std::io;
use std::time::Duration;

use sqlx::migrate::Migrator;
use sqlx::pool::PoolConnection;
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, Postgres};
use tokio::sync::watch;
use tokio::time::timeout;
use uuid::Uuid;

pub use self::notifications::notify;
use super::error::{CatalogueError, is_postgres, reported_unavailable};
use super::open::OpenCatalogueError;

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/postgres");

/// Connections of one process, beside the one that listens: calls take milliseconds and recognition makes none.
const CONNECTIONS: u32 = 8;

/// How long a call waits for a connection before it is `Unavailable`.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);

/// How long a call may take in all. PostgreSQL ends what takes long before that, so this is for a server that has gone
/// silently.
const CALL_TIMEOUT: Duration = Duration::from_secs(35);

/// How long an idle connection is taken to be alive without a ping.
const ALIVE_FOR: Duration = Duration::from_secs(1);

/// Parameters of every connection. The catalogue's order of locks is meant for READ COMMITTED.
const SETTINGS: [(&str, &str); 2] =
    [("default_transaction_isolation", "read committed"), ("client_min_messages", "warning")];

/// Parameters of the connections for calls: a process that stalls in a transaction must not block the others.
const LIMITS: [(&str, &str); 3] =
    [("lock_timeout", "2s"), ("statement_timeout", "30s"), ("idle_in_transaction_session_timeout", "10s")];

/// The advisory lock of the process that collects orphans.
const COLLECTION_LOCK: i64 = 0x6c61_6e64_6d61_726b;

/// How often a call is tried that PostgreSQL gave up.
const ATTEMPTS: u32 = 5;

/// PostgreSQL's codes for what was given up for the sake of another transaction, and for a statement that was
/// prepared before a newer release added a column.
const GIVEN_UP: [&str; 3] = ["40001", "40P01", "0A000"];

/// A database on a PostgreSQL server, and the connections to it.
#[derive(Debug)]
pub struct PostgresServer {
    pool: PgPool,
    options: PgConnectOptions,
    changes: watch::Receiver<u64>,
}

impl PostgresServer {
    /// Connects to the server and brings the tables up to date; gives the catalogue's id too.
    pub async fn open(address: &str) -> Result<(Self, Uuid), OpenCatalogueError> {
        let options = options(address).map_err(OpenCatalogueError::from_postgres)?;
        let mut connection = timeout(CONNECT_TIMEOUT, options.connect())
            .await
            .unwrap_or_else(|_| Err(io::Error::from(io::ErrorKind::TimedOut).into()))
            .map_err(OpenCatalogueError::from_postgres)?;
        // Takes a lock that goes with the connection: another process that opens the catalogue waits.
        MIGRATIONS
            .run_direct(None, &mut connection, false)
            .await
            .map_err(OpenCatalogueError::from_postgres_migration)?;
        let id = sqlx::query_scalar("SELECT id FROM identity")
            .fetch_one(&mut connection)
            .await
            .map_err(OpenCatalogueError::from_postgres)?;
        connection.close().await.map_err(OpenCatalogueError::from_postgres)?;

        let options = options.options(LIMITS);
        let pool = PgPoolOptions::new()
            .max_connections(CONNECTIONS)
            .acquire_timeout(CONNECT_TIMEOUT)
            // Pings only a connection that was idle: this saves a call under load a round trip, and a call that is
            // dropped during the ping doesn't cost a connection.
            .test_before_acquire(false)
            .before_acquire(|connection, state| {
                Box::pin(async move { Ok(state.idle_for < ALIVE_FOR || answers(connection).await) })
            })
            // A call that was dropped leaves its answer behind. A connection on which none comes is closed.
            .after_release(|connection, _| Box::pin(async { Ok(answers(connection).await) }))
            .connect_lazy_with(options.clone());
        Ok((Self { pool, changes: notifications::listen(options.clone()), options }, id))
    }

    /// A connection that the caller has for itself.
    pub async fn session(&self) -> Result<PoolConnection<Postgres>, sqlx::Error> {
        self.pool.acquire().await
    }

    /// Takes the lock of the process that collects orphans; none while another process has it. The lock goes with the
    /// connection that is given, one of its own.
    pub async fn try_lock_collection(&self) -> Result<Option<PgConnection>, sqlx::Error> {
        let mut connection = self.options.connect().await?;
        let is_locked: bool = sqlx::query_scalar("SELECT pg_try_advisory_lock($1)")
            .bind(COLLECTION_LOCK)
            .fetch_one(&mut connection)
            .await?;
        Ok(is_locked.then_some(connection))
    }

    /// A number that grows with each notification; those before this call count as seen.
    pub fn changes(&self) -> watch::Receiver<u64> {
        let mut changes = self.changes.clone();
        changes.mark_unchanged();
        changes
    }
}

/// Whether the server answers on this connection.
async fn answers(connection: &mut PgConnection) -> bool {
    timeout(CONNECT_TIMEOUT, connection.ping()).await.is_ok_and(|answer| answer.is_ok())
}

fn options(address: &str) -> Result<PgConnectOptions, sqlx::Error> {
    if !["postgres://", "postgresql://"].iter().any(|scheme| address.starts_with(scheme)) {
        return Err(sqlx::Error::Configuration("it begins with another scheme".into()));
    }
    let options: PgConnectOptions = address.parse()?;
    let options = match options.get_application_name() {
        Some(_) => options,
        None => options.application_name("landmarkd"),
    };
    Ok(options.options(SETTINGS))
}

/// Ends a call that doesn't end by itself.
pub async fn bounded<T>(call: impl Future<Output = Result<T, CatalogueError>>) -> Result<T, CatalogueError> {
    match timeout(CALL_TIMEOUT, call).await {
        Ok(result) => result,
        Err(elapsed) => Err(CatalogueError::Unavailable { source: elapsed.into() }),
    }
}

/// Makes a connection ready for another attempt of a call that PostgreSQL gave up. Errors: `error` itself where another
/// attempt doesn't help, or there were enough of them.
pub async fn recover(
    connection: &mut PgConnection,
    error: CatalogueError,
    attempts: u32,
) -> Result<(), CatalogueError> {
    let is_given_up = reported_unavailable(&error).is_some_and(|reported| is_postgres(reported, &GIVEN_UP));
    if !is_given_up || attempts >= ATTEMPTS {
        return Err(error);
    }
    Ok(connection.clear_cached_statements().await?)
}
