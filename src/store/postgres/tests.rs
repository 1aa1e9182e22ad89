//! PostgreSQL keeps every promise of the catalogue, and those of a shared one.

#[path = "../../../tests/fleet/postgres.rs"]
#[expect(dead_code, reason = "some of it is for the tests of whole processes")]
mod cluster;

use std::collections::HashSet;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use futures_util::future::{join_all, try_join_all};

use self::cluster::{Cluster, Stop};
use super::*;
use crate::store::catalogue::open_postgres;
use crate::store::query::Connection;
use crate::store::session::{Backend, transaction};
use crate::store::suite::{by, catalogue_suite};
use crate::store::tables::databases;
use crate::store::{AliasExpectation, Catalogue, JobFilter, NewVersion};

const LEASE: Duration = Duration::from_secs(60);
const TRAINING: &[&str] = &["training"];

/// One for all tests that don't stop it; it ends with the process.
static CLUSTER: LazyLock<Cluster> = LazyLock::new(Cluster::start_new);

async fn empty() -> (Arc<Catalogue>, ()) {
    let (catalogue, _) = open_postgres(&CLUSTER.create_database()).await.unwrap();
    // Every connection is there before a promise begins: one drops hundreds of calls, which would begin as many.
    for opened in join_all((0..CONNECTIONS).map(|_| catalogue.ping())).await {
        opened.unwrap();
    }
    (catalogue, ())
}

/// Two processes' views of one empty catalogue, with a database.
async fn two(cluster: &Cluster) -> [Arc<Catalogue>; 2] {
    let address = cluster.create_database();
    let both = [open_postgres(&address).await.unwrap().0, open_postgres(&address).await.unwrap().0];
    both[0].create_database("lab", "landmarks", "{}", by()).await.unwrap();
    both
}

fn pool(catalogue: &Catalogue) -> &PgPool {
    match &catalogue.backend {
        Backend::Postgres(server) => &server.pool,
        Backend::Sqlite(file) => panic!("{file:?} is no server"),
    }
}

fn artifact(digest: &str) -> NewVersion {
    NewVersion {
        database: "lab".to_owned(),
        digest: digest.to_owned(),
        blob: format!("blob of {digest}"),
        bytes: 8,
        kind: "landmarks".to_owned(),
        algorithm_revision: 1,
        options: "{}".to_owned(),
        counts: "{}".to_owned(),
        report: "{}".to_owned(),
    }
}

mod postgres_keeps_every_promise {
    use super::{catalogue_suite, empty};

    catalogue_suite!(empty, #[ignore = "needs PostgreSQL's programs; run by .ci/run"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn eight_claimers_of_two_processes_claim_five_hundred_jobs_once_each() {
    let both = two(&CLUSTER).await;
    let mut queued = HashSet::new();
    for _ in 0..500 {
        queued.insert(both[0].enqueue_job("training", "lab", "{}", by()).await.unwrap().id);
    }
    let began = Instant::now();
    let tasks = (0..8).map(|worker| {
        let catalogue = both[worker % 2].clone();
        tokio::spawn(async move {
            let mut claimed = Vec::new();
            while let Some(job) = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap() {
                assert_eq!((job.token, job.attempts), (1, 1));
                claimed.push(job.id);
            }
            claimed
        })
    });
    let claimed: Vec<Uuid> = try_join_all(tasks).await.unwrap().into_iter().flatten().collect();
    println!("{:.0} claims/s", 500.0 / began.elapsed().as_secs_f64());
    assert_eq!(claimed.len(), 500);
    assert_eq!(claimed.into_iter().collect::<HashSet<_>>(), queued);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn concurrent_publishes_number_versions_and_revisions_without_a_gap() {
    let both = two(&CLUSTER).await;
    let tasks = (0..8).map(|worker| {
        let catalogue = both[worker % 2].clone();
        tokio::spawn(async move {
            for round in 0..10 {
                catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
                // Another worker may be at the one job that was there when this claim began; its own is there then.
                let job = loop {
                    if let Some(job) = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap() {
                        break job;
                    }
                };
                let new = artifact(&format!("{worker} {round}"));
                catalogue.publish(job.id, job.token, &new, Some("current"), None).await.unwrap();
                let events = catalogue.job_events(job.id, 0).await.unwrap();
                assert!(events.iter().map(|event| event.sequence).eq(1..=3));
            }
        })
    });
    try_join_all(tasks).await.unwrap();
    let versions = both[0].versions("lab", None, 1000).await.unwrap();
    assert!(versions.iter().map(|row| row.version).eq(1..=80));
    let aliases = both[0].aliases("lab").await.unwrap();
    // Whose publish was the last moved the alias last: both counters stand under one lock.
    assert_eq!((aliases[0].version, aliases[0].revision), (80, 80));
}

/// Everything that locks, at once, again and again: whoever waits gets a turn, and nobody waits in a circle.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn calls_that_lock_the_same_rows_do_not_block_each_other_for_good() {
    let both = two(&CLUSTER).await;
    let began = Instant::now();
    let is_refusal = |error: &CatalogueError| {
        !matches!(error, CatalogueError::Unavailable { .. } | CatalogueError::Corrupt { .. })
    };
    let tasks = (0..6).map(|worker| {
        let catalogue = both[worker % 2].clone();
        tokio::spawn(async move {
            for round in 0..25 {
                let (digest, any) = (format!("{worker} {round}"), AliasExpectation::Any);
                let mut ends = Vec::new();
                match worker % 3 {
                    0 => {
                        ends.push(catalogue.delete_database("lab", by()).await.map(drop));
                        ends.push(catalogue.create_database("lab", "landmarks", "{}", by()).await.map(drop));
                        ends.push(catalogue.hand_back_jobs("w").await.map(drop));
                        ends.push(catalogue.delete_calibration("rig", by()).await.map(drop));
                    }
                    1 => {
                        ends.push(catalogue.insert_version(&artifact(&digest), by()).await.map(drop));
                        ends.push(catalogue.set_alias("lab", "current", 1, any, by()).await.map(drop));
                        ends.push(catalogue.put_calibration("rig", "{}", None, by()).await.map(drop));
                        ends.push(
                            catalogue
                                .enqueue_calibration_job("sweep", "rig", "{}", &[], by())
                                .await
                                .map(drop),
                        );
                        if let Ok(Some(job)) = catalogue.claim_job("w", &["sweep"], LEASE, 3).await {
                            ends.push(
                                catalogue.publish_calibration(job.id, job.token, "{}", 1).await.map(drop),
                            );
                            ends.push(catalogue.request_cancel(job.id, by()).await.map(drop));
                        }
                    }
                    _ => {
                        ends.push(catalogue.enqueue_job("training", "lab", "{}", by()).await.map(drop));
                        match catalogue.claim_job("w", TRAINING, LEASE, 100).await {
                            Ok(Some(job)) => {
                                let new = artifact(&digest);
                                let published =
                                    catalogue.publish(job.id, job.token, &new, Some("current"), None);
                                ends.push(published.await.map(drop));
                            }
                            other => ends.push(other.map(drop)),
                        }
                        ends.push(catalogue.delete_version("lab", 1, by()).await.map(drop));
                    }
                }
                for error in ends.into_iter().filter_map(Result::err) {
                    assert!(is_refusal(&error), "{error:?}");
                }
            }
        })
    });
    try_join_all(tasks).await.unwrap();
    println!("150 rounds in {:?}", began.elapsed());
    // No job was left behind by a deletion of its database.
    both[0].delete_database("lab", by()).await.unwrap();
    both[0].delete_calibration("rig", by()).await.unwrap();
    let states = both[0].jobs_by_state().await.unwrap();
    assert!(states.iter().all(|(state, _)| state.is_terminal()), "{states:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn processes_that_open_an_empty_database_at_once_make_its_tables_once() {
    for _ in 0..5 {
        let address = CLUSTER.create_database();
        let opened = join_all((0..4).map(|_| open_postgres(&address))).await;
        for catalogue in opened {
            catalogue.unwrap().0.ping().await.unwrap();
        }
    }
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn a_lease_runs_out_by_the_servers_clock_and_its_token_is_worth_nothing_then() {
    let [slow, quick] = two(&CLUSTER).await;
    let id = slow.enqueue_job("training", "lab", "{}", by()).await.unwrap().id;
    let lost = slow.claim_job("slow", TRAINING, Duration::from_millis(300), 3).await.unwrap().unwrap();
    assert_eq!(slow.release_dead_leases("quick").await.unwrap(), 0);
    assert_eq!(quick.claim_job("quick", TRAINING, LEASE, 3).await.unwrap(), None);
    tokio::time::sleep(Duration::from_millis(350)).await;
    let taken = quick.claim_job("quick", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!((taken.id, taken.token), (id, lost.token + 1));
    let refused = slow.publish(id, lost.token, &artifact("late"), Some("current"), None).await;
    assert!(matches!(refused, Err(CatalogueError::LeaseLost)), "{refused:?}");
    let refused = slow.renew_job(id, lost.token, LEASE, None).await;
    assert!(matches!(refused, Err(CatalogueError::LeaseLost)), "{refused:?}");
    quick.publish(id, taken.token, &artifact("in time"), Some("current"), None).await.unwrap();
    assert_eq!(slow.aliases("lab").await.unwrap()[0].version, 1);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn calls_fail_soon_while_postgres_is_away_and_work_again_when_it_is_back() {
    let cluster = Cluster::start_new();
    let [catalogue, _] = two(&cluster).await;
    for how in [Stop::Fast, Stop::Immediate] {
        // Several connections, so that each of them has to be found dead.
        join_all((0..8).map(|_| catalogue.ping())).await;
        cluster.stop(how);
        for _ in 0..2 {
            let began = Instant::now();
            let calls = (0..12).map(|_| catalogue.create_database("lab", "landmarks", "{}", by()));
            for refused in join_all(calls).await {
                assert!(matches!(refused, Err(CatalogueError::Unavailable { .. })), "{refused:?}");
            }
            println!("twelve calls refused after {:?}", began.elapsed());
            assert!(began.elapsed() < Duration::from_secs(3));
        }
        cluster.start();
        let began = Instant::now();
        for ended in
            join_all((0..12).map(|_| catalogue.create_database("lab", "landmarks", "{}", by()))).await
        {
            assert!(!ended.unwrap().1);
        }
        println!("twelve calls served {:?} after its return", began.elapsed());
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn a_connection_cut_in_the_middle_of_a_transaction_leaves_nothing() {
    let address = CLUSTER.create_database();
    let (catalogue, _) = open_postgres(&address).await.unwrap();
    catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
    // Somebody holds the row; who waits for it is cut off, and then the call after it succeeds.
    let mut holder = pool(&catalogue).begin().await.unwrap();
    databases::lock(&mut Connection::from(&mut *holder), "lab").await.unwrap();
    let new = artifact("d1");
    let cut = async {
        tokio::time::sleep(Duration::from_millis(300)).await;
        sqlx::query(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity
             WHERE datname = current_database() AND wait_event_type = 'Lock'",
        )
        .execute(pool(&catalogue))
        .await
        .unwrap();
    };
    let (refused, ()) = tokio::join!(catalogue.insert_version(&new, by()), cut);
    assert!(matches!(refused, Err(CatalogueError::Unavailable { .. })), "{refused:?}");
    // Who isn't cut off waits no longer than the limit.
    let began = Instant::now();
    let refused = catalogue.insert_version(&new, by()).await;
    assert!(matches!(refused, Err(CatalogueError::Unavailable { .. })), "{refused:?}");
    assert!(began.elapsed() < Duration::from_secs(4), "{:?}", began.elapsed());
    drop(holder);
    assert_eq!(catalogue.insert_version(&new, by()).await.unwrap().0.version, 1);
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn a_call_that_deadlocks_is_tried_again() {
    let (catalogue, _) = open_postgres(&CLUSTER.create_database()).await.unwrap();
    for name in ["a", "b"] {
        catalogue.create_database(name, "landmarks", "{}", by()).await.unwrap();
    }
    // Against the order on purpose: each has one row and wants the other.
    let cross = async |first: &'static str, second: &'static str| -> Result<u32, CatalogueError> {
        let mut attempts_made = 0;
        transaction!(catalogue, c => {
            attempts_made += 1;
            databases::lock(c, first).await?;
            tokio::time::sleep(Duration::from_millis(200)).await;
            databases::lock(c, second).await?;
            Ok(attempts_made)
        })
    };
    let (one, other) = tokio::join!(cross("a", "b"), cross("b", "a"));
    // One is given up, or both in turn.
    let attempts_made = one.unwrap() + other.unwrap();
    assert!(attempts_made > 2, "they never met: {attempts_made}");
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn a_column_that_a_newer_release_adds_breaks_no_call_of_this_one() {
    let (catalogue, _) = open_postgres(&CLUSTER.create_database()).await.unwrap();
    let calls = async || {
        catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
        catalogue.jobs(&JobFilter::default(), None, 9).await.unwrap().len()
    };
    assert_eq!(calls().await, 1);
    for addition in ["ALTER TABLE jobs ADD COLUMN hue TEXT", "ALTER TABLE databases ADD COLUMN hue TEXT"] {
        sqlx::query(addition).execute(pool(&catalogue)).await.unwrap();
    }
    assert_eq!(calls().await, 2);
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn another_process_is_notified_soon_and_after_a_lost_connection() {
    let cluster = Cluster::start_new();
    let [here, there] = two(&cluster).await;
    here.insert_version(&artifact("d1"), by()).await.unwrap();
    // What comes while the listener connects is over.
    tokio::time::sleep(Duration::from_millis(500)).await;

    let mut changes = there.change_notifications();
    let mut notified = async |what: &str, began: Instant| {
        let limit = Duration::from_millis(500);
        timeout(limit, changes.changed())
            .await
            .unwrap_or_else(|_| panic!("no notification: {what}"))
            .unwrap();
        println!("{what}: done and notified within {:?}", began.elapsed());
        changes.mark_unchanged();
    };
    let began = Instant::now();
    here.set_alias("lab", "current", 1, AliasExpectation::Any, by()).await.unwrap();
    notified("an alias was moved", began).await;
    let began = Instant::now();
    let job = here.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    notified("a job was queued", began).await;
    let claimed = here.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let began = Instant::now();
    here.request_cancel(job.id, by()).await.unwrap();
    notified("a job was asked to end", began).await;
    here.cancelled_job(job.id, claimed.token).await.unwrap();
    let began = Instant::now();
    here.delete_alias("lab", "current", AliasExpectation::Any, by()).await.unwrap();
    notified("an alias was deleted", began).await;
    let began = Instant::now();
    here.delete_database("lab", by()).await.unwrap();
    notified("a database was deleted", began).await;

    for how in [Stop::Fast, Stop::Immediate] {
        let mut changes = there.change_notifications();
        cluster.stop(how);
        tokio::time::sleep(Duration::from_secs(1)).await;
        assert!(!changes.has_changed().unwrap());
        cluster.start();
        let began = Instant::now();
        timeout(Duration::from_secs(4), changes.changed())
            .await
            .expect("a notification after the return")
            .unwrap();
        println!("listening again {:?} after the return", began.elapsed());
        changes.mark_unchanged();
        here.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        here.enqueue_job("training", "lab", "{}", by()).await.unwrap();
        timeout(Duration::from_millis(500), changes.changed()).await.expect("a notification").unwrap();
    }
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn what_hinders_the_opening_is_told_apart() {
    use OpenCatalogueError::{Address, Newer, NoDatabase, Refused, Unavailable};
    let address = CLUSTER.create_database();
    let error = async |address: &str| open_postgres(address).await.err().unwrap();

    for wrong in ["mysql://localhost/x", "postgres://localhost:port/x", "postgres://localhost/x?sslmode=no"] {
        let refused = error(wrong).await;
        assert!(matches!(refused, Address(_)), "{wrong}: {refused:?}");
    }
    let refused = error(&CLUSTER.address("postgres", "gone")).await;
    assert!(matches!(refused, NoDatabase(_)), "{refused:?}");
    let refused = error(&CLUSTER.address("nobody", "postgres")).await;
    assert!(matches!(refused, Refused(_)), "{refused:?}");
    for away in
        ["postgres://postgres@localhost/x?host=/nonexistent", "postgres://127.0.0.1:1/x?sslmode=disable"]
    {
        let began = Instant::now();
        let refused = error(away).await;
        assert!(matches!(refused, Unavailable(_)), "{away}: {refused:?}");
        assert!(began.elapsed() < Duration::from_secs(3));
    }

    let (catalogue, _) = open_postgres(&address).await.unwrap();
    sqlx::query("CREATE ROLE guest LOGIN").execute(pool(&catalogue)).await.unwrap();
    let database = address.split(['/', '?']).nth(3).unwrap();
    let refused = error(&CLUSTER.address("guest", database)).await;
    assert!(matches!(refused, Refused(_)), "{refused:?}");
    sqlx::query(
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
         VALUES (9000, 'of the future', TRUE, '', 0)",
    )
    .execute(pool(&catalogue))
    .await
    .unwrap();
    let refused = error(&address).await;
    assert!(matches!(refused, Newer { migration: 9000 }), "{refused:?}");
    // Who has it open goes on.
    catalogue.ping().await.unwrap();
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn what_cannot_be_kept_or_cannot_be_ours_is_told_apart() {
    let (catalogue, _) = open_postgres(&CLUSTER.create_database()).await.unwrap();
    catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
    let refused = catalogue.enqueue_job("training", "lab", "a\0b", by()).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::Conflict { .. }), "{refused:?}");

    catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    sqlx::query("UPDATE jobs SET attempts = -1").execute(pool(&catalogue)).await.unwrap();
    let refused = catalogue.jobs(&JobFilter::default(), None, 9).await.unwrap_err();
    assert!(
        matches!(&refused, CatalogueError::Corrupt { what, .. } if what == "attempts is -1"),
        "{refused:?}"
    );

    let mut transaction = pool(&catalogue).begin().await.unwrap();
    sqlx::query("SET TRANSACTION READ ONLY").execute(&mut *transaction).await.unwrap();
    let refused = databases::create(&mut Connection::from(&mut *transaction), "other", "landmarks", "{}")
        .await
        .unwrap_err();
    assert!(matches!(refused, CatalogueError::Unavailable { .. }), "{refused:?}");
}

#[tokio::test]
#[ignore = "needs PostgreSQL's programs; run by .ci/run"]
async fn a_process_has_a_bounded_number_of_connections() {
    let (catalogue, _) = open_postgres(&CLUSTER.create_database()).await.unwrap();
    join_all((0..100).map(|number| {
        let (catalogue, name) = (&catalogue, format!("lab{number}"));
        async move { catalogue.create_database(&name, "landmarks", "{}", by()).await.unwrap() }
    }))
    .await;
    let open: i64 = sqlx::query_scalar(
        "SELECT count(*) FROM pg_stat_activity
         WHERE datname = current_database() AND application_name = 'landmarkd'",
    )
    .fetch_one(pool(&catalogue))
    .await
    .unwrap();
    assert!(open <= i64::from(CONNECTIONS) + 1, "{open}");
}
