//! Statements that are written once and run on SQLite and PostgreSQL alike.
//!
//! The text is PostgreSQL's. [`Connection::query`] translates what SQLite lacks:
//!
//! - `now_us()`, the server's clock, becomes one more parameter with the time of this process;
//! - a locking clause at the end (`FOR UPDATE` and its kin) is cut off: a transaction that writes holds the whole file;
//! - ids are text there, in the hyphenated form, and lists are JSON.
//!
//! Where more differs, [`Connection::query_per_dialect`] takes two texts.

use std::borrow::Cow;

use jiff::Timestamp;
use serde::Serialize;
use sqlx::error::BoxDynError;
use sqlx::postgres::{PgArguments, PgConnection, PgRow, Postgres};
use sqlx::sqlite::{Sqlite, SqliteArguments, SqliteConnection, SqliteRow};
use sqlx::{Arguments, AssertSqlSafe, ColumnIndex, Decode, Encode, Row as _, Type};
use uuid::Uuid;

use super::error::CatalogueError;

/// A connection to either database, for one statement or for one transaction.
pub struct Connection<'c> {
    driver: Driver<'c>,
    /// Whether to notify other processes of a change when the transaction is committed.
    pub notifies: bool,
}

enum Driver<'c> {
    Sqlite(&'c mut SqliteConnection),
    Postgres(&'c mut PgConnection),
}

impl<'c> From<&'c mut SqliteConnection> for Connection<'c> {
    fn from(connection: &'c mut SqliteConnection) -> Self {
        Self { driver: Driver::Sqlite(connection), notifies: false }
    }
}

impl<'c> From<&'c mut PgConnection> for Connection<'c> {
    fn from(connection: &'c mut PgConnection) -> Self {
        Self { driver: Driver::Postgres(connection), notifies: false }
    }
}

impl Connection<'_> {
    /// Begins a statement that both databases understand.
    pub fn query(&mut self, text: &'static str) -> Query<'_> {
        self.query_per_dialect(text, text)
    }

    /// Begins a statement that each database needs in its own words.
    pub fn query_per_dialect(&mut self, sqlite: &'static str, postgres: &'static str) -> Query<'_> {
        let statement = match &mut self.driver {
            Driver::Sqlite(connection) => {
                Statement::Sqlite { connection, text: sqlite, arguments: SqliteArguments::default() }
            }
            Driver::Postgres(connection) => {
                Statement::Postgres { connection, text: postgres, arguments: PgArguments::default() }
            }
        };
        Query { statement, fault: None }
    }
}

/// A statement and its arguments.
pub struct Query<'c> {
    statement: Statement<'c>,
    /// The first argument that couldn't be encoded.
    fault: Option<BoxDynError>,
}

enum Statement<'c> {
    Sqlite { connection: &'c mut SqliteConnection, text: &'static str, arguments: SqliteArguments },
    Postgres { connection: &'c mut PgConnection, text: &'static str, arguments: PgArguments },
}

impl Query<'_> {
    /// Adds the next argument: `$1`, `$2` …
    pub fn bind<'t, T>(mut self, value: T) -> Self
    where
        T: Encode<'t, Sqlite> + Type<Sqlite> + Encode<'t, Postgres> + Type<Postgres>,
    {
        let added = match &mut self.statement {
            Statement::Sqlite { arguments, .. } => arguments.add(value),
            Statement::Postgres { arguments, .. } => arguments.add(value),
        };
        self.fault = self.fault.or(added.err());
        self
    }

    /// Adds an id, or NULL.
    pub fn bind_id(mut self, id: impl Into<Option<Uuid>>) -> Self {
        let id = id.into();
        let added = match &mut self.statement {
            Statement::Sqlite { arguments, .. } => arguments.add(id.map(|id| id.to_string())),
            Statement::Postgres { arguments, .. } => arguments.add(id),
        };
        self.fault = self.fault.or(added.err());
        self
    }

    /// Adds a list: a JSON array for `json_each` in SQLite, an array for `unnest` or `ANY` in PostgreSQL.
    pub fn bind_list<'t, T>(mut self, values: &'t [T]) -> Self
    where
        T: Serialize,
        &'t [T]: Encode<'t, Postgres> + Type<Postgres>,
    {
        let added = match &mut self.statement {
            Statement::Sqlite { arguments, .. } => {
                serde_json::to_string(values).map_err(BoxDynError::from).and_then(|json| arguments.add(json))
            }
            Statement::Postgres { arguments, .. } => arguments.add(values),
        };
        self.fault = self.fault.or(added.err());
        self
    }

    /// Runs the statement and gives the number of rows that it changed.
    pub async fn execute(mut self) -> Result<u64, CatalogueError> {
        self.check()?;
        match self.statement {
            Statement::Sqlite { connection, text, arguments } => {
                let done = sqlite_query(text, arguments)?.execute(connection).await?;
                Ok(done.rows_affected())
            }
            Statement::Postgres { connection, text, arguments } => {
                Ok(sqlx::query_with(text, arguments).execute(connection).await?.rows_affected())
            }
        }
    }

    /// Runs the statement and reads its first row, if it gives any.
    pub async fn fetch_optional<T: FromRow>(mut self) -> Result<Option<T>, CatalogueError> {
        self.check()?;
        let row = match self.statement {
            Statement::Sqlite { connection, text, arguments } => {
                sqlite_query(text, arguments)?.fetch_optional(connection).await?.map(Row::Sqlite)
            }
            Statement::Postgres { connection, text, arguments } => {
                sqlx::query_with(text, arguments).fetch_optional(connection).await?.map(Row::Postgres)
            }
        };
        row.as_ref().map(T::from_row).transpose()
    }

    /// Runs the statement and reads the one row that it must give.
    pub async fn fetch_one<T: FromRow>(self) -> Result<T, CatalogueError> {
        self.fetch_optional().await?.ok_or_else(|| sqlx::Error::RowNotFound.into())
    }

    /// Runs the statement and reads all its rows.
    pub async fn fetch_all<T: FromRow>(mut self) -> Result<Vec<T>, CatalogueError> {
        self.check()?;
        match self.statement {
            Statement::Sqlite { connection, text, arguments } => {
                let rows = sqlite_query(text, arguments)?.fetch_all(connection).await?;
                rows.into_iter().map(|row| T::from_row(&Row::Sqlite(row))).collect()
            }
            Statement::Postgres { connection, text, arguments } => {
                let rows = sqlx::query_with(text, arguments).fetch_all(connection).await?;
                rows.into_iter().map(|row| T::from_row(&Row::Postgres(row))).collect()
            }
        }
    }

    /// Refuses a statement with an argument that couldn't be encoded.
    fn check(&mut self) -> Result<(), sqlx::Error> {
        self.fault.take().map_or(Ok(()), |fault| Err(sqlx::Error::Encode(fault)))
    }
}

/// The statement as SQLite is to run it.
fn sqlite_query(
    text: &'static str,
    mut arguments: SqliteArguments,
) -> Result<sqlx::query::Query<'static, Sqlite, SqliteArguments>, sqlx::Error> {
    let text = text.split_once(" FOR ").map_or(text, |(unlocked, _)| unlocked);
    let text = if text.contains("now_us()") {
        arguments.add(Timestamp::now().as_microsecond()).map_err(sqlx::Error::Encode)?;
        Cow::Owned(text.replace("now_us()", &format!("${}", arguments.len())))
    } else {
        Cow::Borrowed(text)
    };
    // The text is a constant of this program, and only a parameter's number was put into it.
    Ok(sqlx::query_with(AssertSqlSafe(text.into_owned()), arguments))
}

/// A row of either database.
pub enum Row {
    Sqlite(SqliteRow),
    Postgres(PgRow),
}

/// What is read from one row.
pub trait FromRow: Sized {
    /// Reads the columns. Errors: `Corrupt` when one holds what this program never writes.
    fn from_row(row: &Row) -> Result<Self, CatalogueError>;
}

/// The first column.
impl FromRow for i64 {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        row.get(0)
    }
}

/// The first column.
impl FromRow for String {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        row.get(0)
    }
}

impl Row {
    /// Reads a column, by name or by number.
    pub fn get<T>(
        &self,
        column: impl ColumnIndex<SqliteRow> + ColumnIndex<PgRow>,
    ) -> Result<T, CatalogueError>
    where
        T: for<'r> Decode<'r, Sqlite> + Type<Sqlite> + for<'r> Decode<'r, Postgres> + Type<Postgres>,
    {
        Ok(match self {
            Self::Sqlite(row) => row.try_get(column)?,
            Self::Postgres(row) => row.try_get(column)?,
        })
    }

    /// Reads a column with an id.
    pub fn id(&self, column: &str) -> Result<Uuid, CatalogueError> {
        match self {
            Self::Sqlite(row) => {
                let text: &str = row.try_get(column)?;
                Uuid::try_parse(text).map_err(|source| CatalogueError::Corrupt {
                    what: format!("{column} is {text:?}"),
                    source: Some(source.into()),
                })
            }
            Self::Postgres(row) => Ok(row.try_get(column)?),
        }
    }

    /// Reads an integer column that can't be negative, or can't be above its type's limit.
    pub fn unsigned<T: TryFrom<i64>>(&self, column: &str) -> Result<T, CatalogueError> {
        let value: i64 = self.get(column)?;
        T::try_from(value).map_err(|_| CatalogueError::corrupt(format!("{column} is {value}")))
    }

    /// Reads a column with a time in microseconds since 1970-01-01 UTC.
    pub fn time(&self, column: &str) -> Result<Timestamp, CatalogueError> {
        to_timestamp(self.get(column)?, column)
    }

    /// Reads a column with a time, or NULL.
    pub fn optional_time(&self, column: &str) -> Result<Option<Timestamp>, CatalogueError> {
        let value: Option<i64> = self.get(column)?;
        value.map(|value_us| to_timestamp(value_us, column)).transpose()
    }
}

fn to_timestamp(value_us: i64, column: &str) -> Result<Timestamp, CatalogueError> {
    Timestamp::from_microsecond(value_us).map_err(|source| CatalogueError::Corrupt {
        what: format!("{column} is {value_us}"),
        source: Some(source.into()),
    })
}

/// An unsigned size as a column holds it; nothing that fits a disk saturates.
pub fn to_column(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
