//! Sessions with either database, and the transactions in them.

use sqlx::pool::PoolConnection;
use sqlx::{Connection as _, Postgres, Sqlite};

use super::error::CatalogueError;
use super::postgres::{self, PostgresServer};
use super::query::Connection;
use super::sqlite::{self, SqliteFile};

/// The database that keeps the rows.
#[derive(Debug)]
pub enum Backend {
    Sqlite(SqliteFile),
    Postgres(Box<PostgresServer>),
}

impl Backend {
    /// A session for one statement that reads.
    pub async fn reader(&self) -> Result<Session<'_>, CatalogueError> {
        Ok(match self {
            Self::Sqlite(file) => Session::Sqlite(file, file.reader().await?),
            Self::Postgres(server) => Session::Postgres(server.session().await?),
        })
    }

    /// A session for transactions that write.
    pub async fn writer(&self) -> Result<Session<'_>, CatalogueError> {
        Ok(match self {
            Self::Sqlite(file) => Session::Sqlite(file, file.writer().await?),
            Self::Postgres(server) => Session::Postgres(server.session().await?),
        })
    }

    /// Ends a call that doesn't end by itself because its server has gone silently.
    pub async fn bounded<T>(
        &self,
        call: impl Future<Output = Result<T, CatalogueError>>,
    ) -> Result<T, CatalogueError> {
        match self {
            Self::Sqlite(_) => call.await,
            Self::Postgres(_) => postgres::bounded(call).await,
        }
    }
}

/// A connection that a call has for itself.
pub enum Session<'b> {
    Sqlite(&'b SqliteFile, PoolConnection<Sqlite>),
    Postgres(PoolConnection<Postgres>),
}

impl<'b> Session<'b> {
    /// The connection, for one statement that by itself is a transaction.
    pub fn connection(&mut self) -> Connection<'_> {
        match self {
            Self::Sqlite(_, connection) => Connection::from(&mut **connection),
            Self::Postgres(connection) => Connection::from(&mut **connection),
        }
    }

    /// Begins a transaction that writes; dropped before its end, it is rolled back.
    pub async fn begin(&mut self) -> Result<Transaction<'b, '_>, sqlx::Error> {
        Ok(match self {
            Self::Sqlite(file, connection) => Transaction::Sqlite(file, sqlite::begin(connection).await?),
            Self::Postgres(connection) => Transaction::Postgres(connection.begin().await?),
        })
    }

    /// Makes the session ready for another attempt to write, after the given number of attempts. Errors: `error` itself
    /// where another attempt doesn't help.
    pub async fn recover(self, error: CatalogueError, attempts: u32) -> Result<Self, CatalogueError> {
        match self {
            Self::Sqlite(file, connection) => {
                drop(connection);
                file.recover(error, attempts).await?;
                Ok(Self::Sqlite(file, file.writer().await?))
            }
            Self::Postgres(mut connection) => {
                postgres::recover(&mut connection, error, attempts).await?;
                Ok(Self::Postgres(connection))
            }
        }
    }
}

/// A transaction that writes.
pub enum Transaction<'b, 's> {
    Sqlite(&'b SqliteFile, sqlx::Transaction<'s, Sqlite>),
    Postgres(sqlx::Transaction<'s, Postgres>),
}

impl Transaction<'_, '_> {
    /// The connection, for the transaction's statements.
    pub fn connection(&mut self) -> Connection<'_> {
        match self {
            Self::Sqlite(_, transaction) => Connection::from(&mut **transaction),
            Self::Postgres(transaction) => Connection::from(&mut **transaction),
        }
    }

    /// Commits what succeeded, with a change notification if `notifies`, and rolls back what failed.
    pub async fn end<T>(
        self,
        result: Result<T, CatalogueError>,
        notifies: bool,
    ) -> Result<T, CatalogueError> {
        let is_done = result.is_ok();
        match self {
            Self::Sqlite(file, transaction) if is_done => {
                transaction.commit().await?;
                if notifies {
                    file.notify();
                }
            }
            Self::Postgres(mut transaction) if is_done => {
                if notifies {
                    postgres::notify(&mut transaction).await?;
                }
                transaction.commit().await?;
            }
            // A connection that can't even roll back is lost, and the transaction with it.
            Self::Sqlite(_, transaction) => drop(transaction.rollback().await),
            Self::Postgres(transaction) => drop(transaction.rollback().await),
        }
        result
    }
}

/// Runs one statement, which by itself is a transaction; again when the server gave it up.
macro_rules! statement {
    ($catalogue:expr, $connection:ident => $statement:expr) => {{
        let backend = &$catalogue.backend;
        let call = async {
            let mut session = backend.reader().await?;
            let mut attempts = 0;
            loop {
                let $connection = &mut session.connection();
                match async { $statement }.await {
                    Ok(value) => break Ok(value),
                    Err(error) => {
                        attempts += 1;
                        session = session.recover(error, attempts).await?;
                    }
                }
            }
        };
        backend.bounded(call).await
    }};
}

/// Runs statements in one transaction; again when the database gave it up.
macro_rules! transaction {
    ($catalogue:expr, $connection:ident => $statements:expr) => {{
        let backend = &$catalogue.backend;
        let call = async {
            let mut session = backend.writer().await?;
            let mut attempts = 0;
            loop {
                let attempt = async {
                    let mut transaction = session.begin().await?;
                    let mut connection = transaction.connection();
                    let $connection = &mut connection;
                    let result = async { $statements }.await;
                    let notifies = connection.notifies;
                    transaction.end(result, notifies).await
                };
                let result = attempt.await;
                match result {
                    Ok(value) => break Ok(value),
                    Err(error) => {
                        attempts += 1;
                        session = session.recover(error, attempts).await?;
                    }
                }
            }
        };
        backend.bounded(call).await
    }};
}
pub(super) use {statement, transaction};
