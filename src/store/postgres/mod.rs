//! The catalogue in PostgreSQL, shared by many processes: where transactions begin and end.
//!
//! The statements stand in one file per table and take a connection; this file decides what is one
//! transaction. A call that only reads is one statement, hence one snapshot. One that writes runs under READ
//! COMMITTED and locks what it decides by, always in this order, so that no two wait for each other:
//!
//! 1. the row of the database, or the counter of the calibrations and then the calibration's row;
//! 2. the rows of jobs, by id (a claim waits for none: it passes by what is locked);
//! 3. everything below them: versions, aliases, exemplars, events, blobs.
//!
//! Who holds a database's row is alone with its versions and aliases. Exemplars and jobs are added under a
//! weaker lock, which only keeps the database from being deleted. Every time is by the database's clock.

mod aliases;
mod audit;
mod calibrations;
mod databases;
mod exemplars;
mod hints;
mod jobs;
mod keys;
mod processes;
mod versions;
mod workcells;

use std::io;
use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use jiff::Timestamp;
use serde_json::json;
use sqlx::migrate::Migrator;
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection, Postgres, Transaction};
use tokio::sync::watch;
use tokio::time::timeout;
use uuid::Uuid;

use super::audit::{Actor, AuditFilter, AuditRow, Entry, document as kept};
use super::catalogue::{
    AliasExpectation, AliasRow, AliasTarget, CalibrationRow, Catalogue, CatalogueError, DatabaseCounts,
    DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow, JobFilter, JobRow, JobState, KeyRow, NewKey,
    NewVersion, ProcessRow, Progress, Renewal, Turn, VersionRow, WorkcellRow,
};
use super::job_end::{Outcome, Subject};
use super::open::OpenCatalogueError;
use super::row::is_postgres;

static MIGRATIONS: Migrator = sqlx::migrate!("migrations/postgres");

/// Connections of one process, beside the one that listens: calls take milliseconds and recognition makes none.
const CONNECTIONS: u32 = 8;

/// How long a call waits for a connection before it is `Unavailable`.
const TURN_TIMEOUT: Duration = Duration::from_secs(2);

/// How long a call may take in all. PostgreSQL ends what takes long before that, so this is for a server that
/// has gone without a word.
const CALL_TIMEOUT: Duration = Duration::from_secs(35);

/// How long an idle connection is believed to be alive.
const UNASKED: Duration = Duration::from_secs(1);

/// What every connection is told. The locks above are thought out for READ COMMITTED.
const SETTINGS: [(&str, &str); 2] =
    [("default_transaction_isolation", "read committed"), ("client_min_messages", "warning")];

/// What the connections of calls are told: a process that stalls in a transaction must not hold up the others.
const LIMITS: [(&str, &str); 3] =
    [("lock_timeout", "2s"), ("statement_timeout", "30s"), ("idle_in_transaction_session_timeout", "10s")];

/// The advisory lock of the process that collects orphans.
const COLLECTION: i64 = 0x6c61_6e64_6d61_726b;

/// How often a call is tried that PostgreSQL gave up.
const ATTEMPTS: u32 = 5;

/// PostgreSQL's codes for what was given up for the sake of another transaction, and for a statement that was
/// prepared before a newer release added a column.
const GIVEN_UP: [&str; 3] = ["40001", "40P01", "0A000"];

/// Opens the catalogue in a PostgreSQL database, and brings its tables up to date; several processes may do so
/// at once, one after the other then.
///
/// The address is `postgres://user:password@host:port/database`, with libpq's `host` (a socket's folder),
/// `sslmode` and `sslrootcert` as parameters. Connections are made as they are needed and lost ones made again.
///
/// # Errors
/// `Unavailable` may heal: try again. No other does by itself.
///
/// Beside the catalogue comes its own id, which its bucket is marked with.
pub async fn open_postgres(address: &str) -> Result<(Arc<dyn Catalogue>, Uuid), OpenCatalogueError> {
    let (catalogue, id) = PostgresCatalogue::open(address).await?;
    Ok((Arc::new(catalogue), id))
}

/// The catalogue in a PostgreSQL database.
#[derive(Debug)]
struct PostgresCatalogue {
    pool: PgPool,
    options: PgConnectOptions,
    hints: watch::Receiver<u64>,
}

impl PostgresCatalogue {
    async fn open(address: &str) -> Result<(Self, Uuid), OpenCatalogueError> {
        let options = options(address).map_err(OpenCatalogueError::of_postgres)?;
        let mut connection = timeout(TURN_TIMEOUT, options.connect())
            .await
            .unwrap_or_else(|_| Err(io::Error::from(io::ErrorKind::TimedOut).into()))
            .map_err(OpenCatalogueError::of_postgres)?;
        // Alone, by a lock that goes with the connection: another process that opens waits.
        MIGRATIONS
            .run_direct(None, &mut connection, false)
            .await
            .map_err(OpenCatalogueError::of_migration)?;
        let id = sqlx::query_scalar("SELECT id FROM identity")
            .fetch_one(&mut connection)
            .await
            .map_err(OpenCatalogueError::of_postgres)?;
        connection.close().await.map_err(OpenCatalogueError::of_postgres)?;

        let options = options.options(LIMITS);
        let pool = PgPoolOptions::new()
            .max_connections(CONNECTIONS)
            .acquire_timeout(TURN_TIMEOUT)
            // Only what had time to die is asked: a round trip less for a call under load, and one that is dropped
            // there doesn't cost a connection.
            .test_before_acquire(false)
            .before_acquire(|connection, state| {
                Box::pin(async move { Ok(state.idle_for < UNASKED || answers(connection).await) })
            })
            // A call that was dropped leaves its answer behind. Where none comes, the connection is given up.
            .after_release(|connection, _| Box::pin(async { Ok(answers(connection).await) }))
            .connect_lazy_with(options.clone());
        Ok((Self { pool, hints: hints::listen(options.clone()), options }, id))
    }
}

async fn answers(connection: &mut PgConnection) -> bool {
    timeout(TURN_TIMEOUT, connection.ping()).await.is_ok_and(|answer| answer.is_ok())
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

/// Runs one statement, which by itself is a transaction; anew when PostgreSQL gave it up.
macro_rules! statement {
    ($catalogue:expr, $connection:ident => $statement:expr) => {
        bounded(async {
            let mut connection = $catalogue.pool.acquire().await?;
            let mut attempts = 1;
            loop {
                let $connection = &mut *connection;
                match async { $statement }.await {
                    Err(error) if is_worth_another(&error, &mut attempts) => {
                        connection.clear_cached_statements().await?;
                    }
                    ended => break ended,
                }
            }
        })
        .await
    };
}

/// Runs statements in one transaction; anew when PostgreSQL gave it up.
macro_rules! transaction {
    ($catalogue:expr, $connection:ident => $statements:expr) => {
        bounded(async {
            let mut connection = $catalogue.pool.acquire().await?;
            let mut attempts = 1;
            loop {
                let mut transaction = connection.begin().await?;
                let $connection = &mut *transaction;
                let done = async { $statements }.await;
                match end(transaction, done).await {
                    Err(error) if is_worth_another(&error, &mut attempts) => {
                        connection.clear_cached_statements().await?;
                    }
                    ended => break ended,
                }
            }
        })
        .await
    };
}

/// Ends a call that doesn't end by itself.
async fn bounded<T>(call: impl Future<Output = Result<T, CatalogueError>>) -> Result<T, CatalogueError> {
    match timeout(CALL_TIMEOUT, call).await {
        Ok(done) => done,
        Err(elapsed) => Err(CatalogueError::Unavailable { source: elapsed.into() }),
    }
}

/// Commits a transaction whose statements succeeded, and rolls back any other.
async fn end<T>(
    transaction: Transaction<'_, Postgres>,
    done: Result<T, CatalogueError>,
) -> Result<T, CatalogueError> {
    match done {
        Ok(value) => {
            transaction.commit().await?;
            Ok(value)
        }
        Err(error) => {
            // A connection that can't even do this is lost, and the transaction with it.
            transaction.rollback().await.ok();
            Err(error)
        }
    }
}

/// Whether an attempt failed for a reason that another one may not meet; counts them.
fn is_worth_another(error: &CatalogueError, attempts: &mut u32) -> bool {
    let CatalogueError::Unavailable { source } = error else { return false };
    let Some(sqlx::Error::Database(reported)) = source.downcast_ref() else { return false };
    *attempts += 1;
    *attempts <= ATTEMPTS && is_postgres(reported.as_ref(), &GIVEN_UP)
}

/// Locks what a job is about: that comes before the job's own row.
async fn lock_subject(connection: &mut PgConnection, id: Uuid) -> Result<(), CatalogueError> {
    let Some(job) = jobs::find(connection, id).await? else { return Ok(()) };
    if let Some(database) = &job.database {
        databases::lock(connection, database).await?;
    }
    if let Some(calibration) = &job.calibration {
        calibrations::lock(connection, calibration).await?;
    }
    Ok(())
}

#[async_trait]
impl Catalogue for PostgresCatalogue {
    async fn ping(&self) -> Result<(), CatalogueError> {
        statement!(self, c => databases::list(c, None, 1).await.map(drop))
    }

    async fn create_database(
        &self,
        name: &str,
        kind: &str,
        options: &str,
        by: &Actor,
    ) -> Result<(DatabaseRow, bool), CatalogueError> {
        transaction!(self, c => {
            let created = databases::create(c, name, kind, options).await?;
            if created.1 {
                let detail = json!({"kind": kind, "options": kept(options)});
                audit::append(c, by, Entry::of("database.create").in_database(name).with(detail)).await?;
            }
            Ok(created)
        })
    }

    async fn set_database_options(
        &self,
        name: &str,
        options: &str,
        by: &Actor,
    ) -> Result<DatabaseRow, CatalogueError> {
        transaction!(self, c => {
            let row = databases::set_options(c, name, options).await?;
            let detail = json!({"options": kept(options)});
            audit::append(c, by, Entry::of("database.options").in_database(name).with(detail)).await?;
            Ok(row)
        })
    }

    async fn database(&self, name: &str) -> Result<Option<DatabaseRow>, CatalogueError> {
        statement!(self, c => databases::find(c, name).await)
    }

    async fn databases(&self, after: Option<&str>, limit: u32) -> Result<Vec<DatabaseRow>, CatalogueError> {
        statement!(self, c => databases::list(c, after, limit).await)
    }

    async fn delete_database(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = databases::delete(c, name).await?;
            jobs::cancel_all(c, Subject::Database(name)).await?;
            if deleted {
                audit::append(c, by, Entry::of("database.delete").in_database(name)).await?;
            }
            hints::send(c).await?;
            Ok(deleted)
        })
    }

    async fn database_counts(&self, name: &str) -> Result<DatabaseCounts, CatalogueError> {
        statement!(self, c => databases::counts(c, name).await)
    }

    async fn insert_exemplar(&self, row: &ExemplarRow) -> Result<(ExemplarRow, bool), CatalogueError> {
        transaction!(self, c => exemplars::insert(c, row).await)
    }

    async fn exemplar(&self, database: &str, id: Uuid) -> Result<Option<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::find(c, database, id).await)
    }

    async fn exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::list(c, database, filter, after, limit).await)
    }

    async fn delete_exemplar(&self, database: &str, id: Uuid, by: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = exemplars::delete(c, database, id).await?;
            if deleted {
                audit::append(c, by, Entry::of("exemplar.delete").in_database(database).about(id)).await?;
            }
            Ok(deleted)
        })
    }

    async fn delete_exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        by: &Actor,
    ) -> Result<u64, CatalogueError> {
        transaction!(self, c => {
            databases::lock(c, database).await?;
            let deleted = exemplars::delete_matching(c, database, filter).await?;
            if deleted > 0 {
                audit::append(c, by, Entry::of("exemplar.delete").in_database(database).with(filter.detail(deleted))).await?;
            }
            Ok(deleted)
        })
    }

    async fn training_set(&self, database: &str) -> Result<Vec<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::training_set(c, database).await)
    }

    async fn versions(
        &self,
        database: &str,
        after: Option<i64>,
        limit: u32,
    ) -> Result<Vec<VersionRow>, CatalogueError> {
        statement!(self, c => versions::list(c, database, after, limit).await)
    }

    async fn version(&self, database: &str, version: i64) -> Result<Option<VersionRow>, CatalogueError> {
        statement!(self, c => versions::find(c, database, version).await)
    }

    async fn digests(
        &self,
        versions: &[(String, i64)],
    ) -> Result<Vec<(String, i64, String)>, CatalogueError> {
        statement!(self, c => versions::digests(c, versions).await)
    }

    async fn version_by_digest(
        &self,
        database: &str,
        digest: &str,
    ) -> Result<Option<VersionRow>, CatalogueError> {
        statement!(self, c => versions::find_by_digest(c, database, digest).await)
    }

    async fn insert_version(
        &self,
        new: &NewVersion,
        by: &Actor,
    ) -> Result<(VersionRow, bool), CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, &new.database).await? {
                return Err(CatalogueError::no_database(&new.database));
            }
            let inserted = versions::insert(c, new).await?;
            if inserted.1 {
                let entry = Entry::of("version.import").in_database(&new.database).about(inserted.0.version);
                audit::append(c, by, entry.with(json!({"digest": new.digest}))).await?;
            }
            Ok(inserted)
        })
    }

    async fn delete_version(&self, database: &str, version: i64, by: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted =
                databases::lock(c, database).await? && versions::delete(c, database, version).await?;
            if deleted {
                audit::append(c, by, Entry::of("version.delete").in_database(database).about(version)).await?;
            }
            Ok(deleted)
        })
    }

    async fn aliases(&self, database: &str) -> Result<Vec<AliasRow>, CatalogueError> {
        statement!(self, c => aliases::list(c, database).await)
    }

    async fn all_aliases(&self) -> Result<Vec<AliasTarget>, CatalogueError> {
        statement!(self, c => aliases::list_all(c).await)
    }

    async fn set_alias(
        &self,
        database: &str,
        alias: &str,
        version: i64,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<(AliasRow, bool), CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, database).await? {
                return Err(CatalogueError::no_version(database, version));
            }
            let set = aliases::set(c, database, alias, version, expected).await?;
            let entry = Entry::of("alias.set").in_database(database).about(alias);
            audit::append(c, by, entry.with(json!({"version": version}))).await?;
            hints::send(c).await?;
            Ok(set)
        })
    }

    async fn delete_alias(
        &self,
        database: &str,
        alias: &str,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, database).await? {
                return match expected {
                    AliasExpectation::Any | AliasExpectation::Absent => Ok(false),
                    AliasExpectation::Revision(_) => Err(CatalogueError::PreconditionFailed),
                };
            }
            let deleted = aliases::delete(c, database, alias, expected).await?;
            if deleted {
                audit::append(c, by, Entry::of("alias.delete").in_database(database).about(alias)).await?;
            }
            hints::send(c).await?;
            Ok(deleted)
        })
    }

    async fn put_calibration(
        &self,
        name: &str,
        document: &str,
        expected: Option<i64>,
        by: &Actor,
    ) -> Result<CalibrationRow, CatalogueError> {
        transaction!(self, c => {
            let row = calibrations::put(c, name, document, expected).await?;
            let detail = json!({"document": kept(document)});
            audit::append(c, by, Entry::of("calibration.put").about(name).with(detail)).await?;
            Ok(row)
        })
    }

    async fn calibration(&self, name: &str) -> Result<Option<CalibrationRow>, CatalogueError> {
        statement!(self, c => calibrations::find(c, name).await)
    }

    async fn calibrations(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<CalibrationRow>, CatalogueError> {
        statement!(self, c => calibrations::list(c, after, limit).await)
    }

    async fn delete_calibration(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = calibrations::delete(c, name).await?;
            jobs::cancel_all(c, Subject::Calibration(name)).await?;
            if deleted {
                audit::append(c, by, Entry::of("calibration.delete").about(name)).await?;
            }
            hints::send(c).await?;
            Ok(deleted)
        })
    }

    async fn enqueue_calibration_job(
        &self,
        kind: &str,
        calibration: &str,
        params: &str,
        blobs: &[String],
        by: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::enqueue_for_calibration(c, kind, calibration, params, blobs).await?;
            let detail = json!({"job": job.id, "kind": kind});
            audit::append(c, by, Entry::of("job.queue").about(calibration).with(detail)).await?;
            hints::send(c).await?;
            Ok(job)
        })
    }

    async fn publish_calibration(
        &self,
        id: Uuid,
        token: i64,
        document: &str,
        expected: i64,
    ) -> Result<CalibrationRow, CatalogueError> {
        transaction!(self, c => {
            lock_subject(c, id).await?;
            jobs::held_and_wanted(c, id, token).await?;
            let job = jobs::finish(c, id, token, JobState::Succeeded, Outcome::default()).await?;
            let name = job.calibration.unwrap_or_default();
            let row = calibrations::put(c, &name, document, Some(expected)).await?;
            audit::append(c, &Actor::job(id), Entry::of("calibration.put").about(&name)).await?;
            Ok(row)
        })
    }

    async fn put_workcell(
        &self,
        name: &str,
        document: &str,
        by: &Actor,
    ) -> Result<(WorkcellRow, bool), CatalogueError> {
        transaction!(self, c => {
            let put = workcells::put(c, name, document).await?;
            let detail = json!({"document": kept(document)});
            audit::append(c, by, Entry::of("workcell.put").about(name).with(detail)).await?;
            Ok(put)
        })
    }

    async fn workcell(&self, name: &str) -> Result<Option<WorkcellRow>, CatalogueError> {
        statement!(self, c => workcells::find(c, name).await)
    }

    async fn workcells(&self, after: Option<&str>, limit: u32) -> Result<Vec<WorkcellRow>, CatalogueError> {
        statement!(self, c => workcells::list(c, after, limit).await)
    }

    async fn delete_workcell(&self, name: &str, by: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = workcells::delete(c, name).await?;
            if deleted {
                audit::append(c, by, Entry::of("workcell.delete").about(name)).await?;
            }
            Ok(deleted)
        })
    }

    async fn enqueue_job(
        &self,
        kind: &str,
        database: &str,
        params: &str,
        by: &Actor,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::enqueue(c, kind, database, params).await?;
            let detail = json!({"kind": kind, "params": kept(params)});
            audit::append(c, by, Entry::of("job.queue").in_database(database).about(job.id).with(detail)).await?;
            hints::send(c).await?;
            Ok(job)
        })
    }

    async fn job(&self, id: Uuid) -> Result<Option<JobRow>, CatalogueError> {
        statement!(self, c => jobs::find(c, id).await)
    }

    async fn jobs(
        &self,
        filter: &JobFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<JobRow>, CatalogueError> {
        statement!(self, c => jobs::list(c, filter, after, limit).await)
    }

    async fn claim_job(
        &self,
        owner: &str,
        kinds: &[&str],
        lease: Duration,
        max_attempts: u32,
    ) -> Result<Option<JobRow>, CatalogueError> {
        transaction!(self, c => jobs::claim(c, owner, kinds, lease, max_attempts).await)
    }

    async fn renew_job(
        &self,
        id: Uuid,
        token: i64,
        lease: Duration,
        progress: Option<&Progress>,
    ) -> Result<Renewal, CatalogueError> {
        transaction!(self, c => jobs::renew(c, id, token, lease, progress).await)
    }

    async fn publish(
        &self,
        id: Uuid,
        token: i64,
        new: &NewVersion,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<VersionRow, CatalogueError> {
        transaction!(self, c => {
            let is_there = databases::lock(c, &new.database).await?;
            jobs::held_and_wanted(c, id, token).await?;
            if !is_there {
                return Err(CatalogueError::no_database(&new.database));
            }
            let (version, is_new) = versions::insert(c, new).await?;
            if is_new {
                let entry = Entry::of("version.publish").in_database(&new.database).about(version.version);
                audit::append(c, &Actor::job(id), entry.with(json!({"digest": new.digest}))).await?;
            }
            if let Some(alias) = promote_alias {
                aliases::set(c, &new.database, alias, version.version, AliasExpectation::Any).await?;
                let entry = Entry::of("alias.set").in_database(&new.database).about(alias);
                audit::append(c, &Actor::job(id), entry.with(json!({"version": version.version}))).await?;
                hints::send(c).await?;
            }
            let outcome = Outcome { version: Some(version.version), comparison, ..Outcome::default() };
            jobs::finish(c, id, token, JobState::Succeeded, outcome).await?;
            Ok(version)
        })
    }

    async fn succeed_job(
        &self,
        id: Uuid,
        token: i64,
        version: Option<i64>,
        promote_alias: Option<&str>,
        comparison: Option<&str>,
    ) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            lock_subject(c, id).await?;
            jobs::held_and_wanted(c, id, token).await?;
            let outcome = Outcome { version, comparison, ..Outcome::default() };
            let job = jobs::finish(c, id, token, JobState::Succeeded, outcome).await?;
            if let Some(version) = version {
                let database = job.database.as_deref().unwrap_or_default();
                if versions::find(c, database, version).await?.is_none() {
                    return Err(CatalogueError::no_version(database, version));
                }
                if let Some(alias) = promote_alias {
                    aliases::set(c, database, alias, version, AliasExpectation::Any).await?;
                    let entry = Entry::of("alias.set").in_database(database).about(alias);
                    audit::append(c, &Actor::job(id), entry.with(json!({"version": version}))).await?;
                    hints::send(c).await?;
                }
            }
            Ok(job)
        })
    }

    async fn fail_job(&self, id: Uuid, token: i64, problem: &str) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => {
            let outcome = Outcome { problem: Some(problem), ..Outcome::default() };
            jobs::finish(c, id, token, JobState::Failed, outcome).await
        })
    }

    async fn cancelled_job(&self, id: Uuid, token: i64) -> Result<JobRow, CatalogueError> {
        transaction!(self, c => jobs::finish(c, id, token, JobState::Cancelled, Outcome::default()).await)
    }

    async fn request_cancel(&self, id: Uuid, by: &Actor) -> Result<Option<JobRow>, CatalogueError> {
        transaction!(self, c => {
            let job = jobs::request_cancel(c, id).await?;
            if let Some(job) = &job {
                let entry = Entry { database: job.database.as_deref(), ..Entry::of("job.cancel") };
                audit::append(c, by, entry.about(id)).await?;
            }
            hints::send(c).await?;
            Ok(job)
        })
    }

    async fn hand_back_jobs(&self, owner: &str) -> Result<u64, CatalogueError> {
        transaction!(self, c => {
            let handed_back = jobs::hand_back(c, owner).await?;
            hints::send(c).await?;
            Ok(handed_back)
        })
    }

    /// None: other owners may live. A dead one's leases run out.
    async fn release_dead_leases(&self, _except_owner: &str) -> Result<u64, CatalogueError> {
        Ok(0)
    }

    async fn job_events(&self, id: Uuid, after: i64) -> Result<Vec<JobEventRow>, CatalogueError> {
        statement!(self, c => jobs::events(c, id, after).await)
    }

    async fn jobs_by_state(&self) -> Result<Vec<(JobState, u64)>, CatalogueError> {
        statement!(self, c => jobs::count_by_state(c).await)
    }

    async fn note_process(&self, row: &ProcessRow) -> Result<(), CatalogueError> {
        transaction!(self, c => processes::note(c, row).await)
    }

    async fn processes(&self, fresh: Duration) -> Result<Vec<ProcessRow>, CatalogueError> {
        statement!(self, c => processes::list(c, fresh).await)
    }

    async fn insert_key(&self, new: &NewKey, by: &Actor) -> Result<KeyRow, CatalogueError> {
        transaction!(self, c => {
            let row = keys::insert(c, new).await?;
            audit::append(c, by, Entry::of("key.create").about(&new.id).with(new.detail())).await?;
            hints::send(c).await?;
            Ok(row)
        })
    }

    async fn keys(&self) -> Result<Vec<KeyRow>, CatalogueError> {
        statement!(self, c => keys::list(c).await)
    }

    async fn revoke_key(&self, id: &str, by: &Actor) -> Result<Option<bool>, CatalogueError> {
        transaction!(self, c => {
            if keys::find(c, id).await?.is_none() {
                return Ok(None);
            }
            let revoked = keys::revoke(c, id).await?;
            if revoked {
                audit::append(c, by, Entry::of("key.revoke").about(id)).await?;
                hints::send(c).await?;
            }
            Ok(Some(revoked))
        })
    }

    async fn note_key_uses(&self, uses: &[(String, Timestamp)]) -> Result<(), CatalogueError> {
        transaction!(self, c => {
            for (id, at) in uses {
                keys::note_use(c, id, at.as_microsecond()).await?;
            }
            Ok(())
        })
    }

    async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<i64>,
        limit: u32,
    ) -> Result<Vec<AuditRow>, CatalogueError> {
        statement!(self, c => audit::list(c, filter, before, limit).await)
    }

    async fn blobs_referenced(&self, blobs: &[String]) -> Result<Vec<String>, CatalogueError> {
        statement!(self, c => {
            Ok(sqlx::query_scalar(
                "SELECT name FROM unnest($1) AS name
                 WHERE EXISTS (SELECT 1 FROM exemplars WHERE blob = name)
                    OR EXISTS (SELECT 1 FROM versions WHERE blob = name)
                    OR EXISTS (SELECT 1 FROM job_blobs b JOIN jobs j ON j.id = b.job
                               WHERE b.blob = name AND j.state IN ('queued', 'running'))",
            )
            .bind(blobs)
            .fetch_all(c)
            .await?)
        })
    }

    async fn turn_to_collect(&self) -> Result<Option<Turn>, CatalogueError> {
        bounded(async {
            // The lock goes with its connection, so it needs one of its own.
            let mut connection = self.options.connect().await?;
            let is_ours: bool = sqlx::query_scalar("SELECT pg_try_advisory_lock($1)")
                .bind(COLLECTION)
                .fetch_one(&mut connection)
                .await?;
            Ok(is_ours.then(|| Box::new(connection) as Turn))
        })
        .await
    }

    fn hints(&self) -> watch::Receiver<u64> {
        let mut hints = self.hints.clone();
        hints.mark_unchanged();
        hints
    }
}

#[cfg(test)]
mod tests;
