//! The behaviour of the catalogue, whichever database keeps it; and the behaviour of the blobs, in `blobs`.
//!
//! A database runs it with `catalogue_suite!(open)`, where `open` gives an empty catalogue and a value that must stay alive
//! with it, and an attribute for every test may follow. One file for each table; tests about several of them are here.

mod aliases;
pub(super) mod blobs;
mod calibrations;
mod databases;
mod exemplars;
mod jobs;
mod keys;
mod versions;
mod workcells;

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use jiff::Timestamp;
use uuid::Uuid;

use super::{Actor, AliasExpectation, Catalogue, ExemplarFilter, ExemplarRow, NewVersion};

pub use self::aliases::*;
pub use self::calibrations::*;
pub use self::databases::*;
pub use self::exemplars::*;
pub use self::jobs::*;
pub use self::keys::*;
pub use self::versions::*;
pub use self::workcells::*;

const LEASE: Duration = Duration::from_secs(60);
/// Runs out the moment it is taken.
const NO_LEASE: Duration = Duration::ZERO;
const TRAINING: &[&str] = &["training"];

/// Makes a test of each function of the suite.
macro_rules! catalogue_suite {
    ($open:path $(, #[$attribute:meta])?) => {
        $crate::store::suite::catalogue_suite! { @each $open, [$(#[$attribute])?]:
            a_database_is_created_once_and_stays_as_it_is
            databases_come_in_pages_by_name
            deleting_a_database_takes_all_it_holds_and_ends_its_jobs
            an_exemplar_is_inserted_once_and_read_back_whole
            exemplars_are_filtered_and_paged_and_trained_in_one_order
            negative_exemplars_have_no_label_and_are_chosen_by_it
            exemplars_are_deleted_one_by_one_or_by_a_filter_that_names_something
            a_version_is_read_back_whole_and_its_digest_is_unique
            a_version_number_is_never_given_twice
            concurrent_versions_of_one_digest_are_one_version
            an_aliased_version_cannot_be_deleted
            an_alias_moves_only_from_the_expected_revision
            under_contention_every_alias_revision_has_one_winner
            eight_workers_claim_two_hundred_jobs_once_each
            the_oldest_waiting_job_of_a_kind_is_claimed_first
            a_worker_that_lost_its_lease_can_finish_nothing
            a_job_that_never_finishes_fails_with_the_reason
            a_queued_job_is_cancelled_at_once_and_a_running_one_is_flagged
            a_cancelled_job_of_a_dead_worker_is_not_taken_up_again
            a_version_published_early_stays_whatever_becomes_of_its_job
            publishing_moves_version_alias_and_job_together
            a_publish_that_fails_changes_nothing
            concurrent_publishes_of_one_digest_give_one_version
            a_job_succeeds_with_a_version_that_was_there
            a_job_handed_back_loses_no_attempt
            every_change_of_state_or_progress_is_an_event
            jobs_come_newest_first_and_are_counted_by_state
            a_blob_is_referenced_while_a_row_names_it
            one_at_a_time_may_collect_orphans
            the_digests_of_many_versions_come_in_one_answer
            a_calibration_is_replaced_only_from_the_expected_revision
            calibrations_come_in_pages_by_name
            a_job_about_a_calibration_keeps_its_blobs_until_it_ends
            a_calibration_and_its_job_end_together_or_not_at_all
            deleting_a_calibration_ends_its_jobs
            a_workcell_is_replaced_by_who_writes_last
            workcells_come_in_pages_by_name
            a_key_is_kept_and_ends_once
            a_change_and_its_entry_are_one_transaction
            a_call_dropped_midway_leaves_the_catalogue_whole
            a_change_that_others_wait_for_is_notified
        }
    };
    (@each $open:path, $attributes:tt: $($promise:ident)+) => {
        $($crate::store::suite::catalogue_suite! { @one $open, $attributes: $promise })+
    };
    (@one $open:path, [$(#[$attribute:meta])?]: $promise:ident) => {
        #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
        $(#[$attribute])?
        async fn $promise() {
            let (catalogue, _kept) = $open().await;
            $crate::store::suite::$promise(catalogue).await;
        }
    };
}
pub(super) use catalogue_suite;

type Shared = Arc<Catalogue>;

fn exemplar(database: &str, number: u128, label: &str) -> ExemplarRow {
    ExemplarRow {
        database: database.to_owned(),
        id: Uuid::from_u128(number),
        label: label.to_owned(),
        negative: label.is_empty(),
        pose_deg: None,
        survey: None,
        width_px: 640,
        height_px: 480,
        bytes: 12_345,
        sha256: format!("{number:064x}"),
        blob: format!("{number:064x}"),
        media_type: "image/png".to_owned(),
        robot_id: None,
        frame_id: None,
        stamp: None,
        created_at: Timestamp::UNIX_EPOCH,
    }
}

fn artifact(database: &str, digest: &str) -> NewVersion {
    NewVersion {
        database: database.to_owned(),
        digest: digest.to_owned(),
        blob: format!("blob of {digest}"),
        bytes: 1 << 40,
        kind: "landmarks".to_owned(),
        algorithm_revision: 1,
        options: r#"{"dimension":32}"#.to_owned(),
        counts: r#"{"exemplars":2}"#.to_owned(),
        report: "{}".to_owned(),
    }
}

/// Who makes the changes of the tests.
pub fn by() -> &'static Actor {
    static TESTER: LazyLock<Actor> = LazyLock::new(|| Actor::named("tester"));
    &TESTER
}

fn label(label: &str) -> ExemplarFilter {
    ExemplarFilter { label: Some(label.to_owned()), ..ExemplarFilter::default() }
}

fn robot(robot_id: &str) -> ExemplarFilter {
    ExemplarFilter { robot_id: Some(robot_id.to_owned()), ..ExemplarFilter::default() }
}

async fn lab(catalogue: &Shared) {
    catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
}

async fn numbers(catalogue: &Shared) -> Vec<i64> {
    catalogue.versions("lab", None, 1000).await.unwrap().iter().map(|row| row.version).collect()
}

pub async fn a_blob_is_referenced_while_a_row_names_it(catalogue: Shared) {
    lab(&catalogue).await;
    let row = exemplar("lab", 1, "a");
    let referenced = async |blob: &str| is_referenced(&catalogue, blob).await;
    assert!(!referenced(&row.blob).await);
    catalogue.insert_exemplar(&row).await.unwrap();
    assert!(referenced(&row.blob).await);
    catalogue.delete_exemplar("lab", row.id, by()).await.unwrap();
    assert!(!referenced(&row.blob).await);

    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    assert!(referenced("blob of d1").await);
    let asked = ["blob of d1", &row.blob, "another"].map(str::to_owned);
    assert_eq!(catalogue.blobs_referenced(&asked).await.unwrap(), ["blob of d1"]);
    assert!(catalogue.blobs_referenced(&[]).await.unwrap().is_empty());
    catalogue.delete_version("lab", 1, by()).await.unwrap();
    assert!(!referenced("blob of d1").await);
}

async fn is_referenced(catalogue: &Shared, blob: &str) -> bool {
    !catalogue.blobs_referenced(&[blob.to_owned()]).await.unwrap().is_empty()
}

pub async fn one_at_a_time_may_collect_orphans(catalogue: Shared) {
    let guard = catalogue.try_lock_collection().await.unwrap();
    assert!(guard.is_some());
    assert!(catalogue.try_lock_collection().await.unwrap().is_none());
    drop(guard);
    for _ in 0..500 {
        if catalogue.try_lock_collection().await.unwrap().is_some() {
            return;
        }
        // PostgreSQL notices a closed connection a moment later.
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("the lock is never free again");
}

pub async fn the_digests_of_many_versions_come_in_one_answer(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("hall", "landmarks", "{}", by()).await.unwrap();
    for (database, digest) in [("lab", "d1"), ("lab", "d2"), ("hall", "h1")] {
        catalogue.insert_version(&artifact(database, digest), by()).await.unwrap();
    }
    catalogue.delete_version("lab", 1, by()).await.unwrap();
    let asked = [("lab", 1), ("lab", 2), ("hall", 1), ("hall", 2), ("none", 1)];
    let asked = asked.map(|(database, version)| (database.to_owned(), version));
    let mut kept = catalogue.digests(&asked).await.unwrap();
    kept.sort();
    let expected = [("hall", 1, "h1"), ("lab", 2, "d2")];
    assert_eq!(
        kept,
        expected.map(|(database, version, digest)| (database.to_owned(), version, digest.to_owned()))
    );
}

pub async fn a_call_dropped_midway_leaves_the_catalogue_whole(catalogue: Shared) {
    lab(&catalogue).await;
    let mut dropped = 0;
    for round in 0..300 {
        let new = artifact("lab", &format!("d{round}"));
        let mut call = std::pin::pin!(catalogue.insert_version(&new, by()));
        // looked at once more each round, so that it is dropped ever later; the first look only begins it
        let mut inserted = futures_util::poll!(call.as_mut());
        for _ in 0..round {
            if inserted.is_pending() {
                tokio::task::yield_now().await;
                inserted = futures_util::poll!(call.as_mut());
            }
        }
        match inserted {
            std::task::Poll::Ready(inserted) => drop(inserted.unwrap()),
            std::task::Poll::Pending => dropped += 1,
        }
    }
    assert!(dropped > 0, "a call that was looked at once can't have ended");
    // What was rolled back took no number, and the writer isn't stuck in somebody's transaction.
    let (last, created) = catalogue.insert_version(&artifact("lab", "last"), by()).await.unwrap();
    assert!(created);
    assert_eq!(numbers(&catalogue).await, (1..=last.version).collect::<Vec<_>>());
}

pub async fn a_change_that_others_wait_for_is_notified(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    let mut changes = catalogue.change_notifications();
    let mut notified = async || {
        tokio::time::timeout(Duration::from_secs(5), changes.changed())
            .await
            .expect("a notification")
            .unwrap();
        changes.mark_unchanged();
    };
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any, by()).await.unwrap();
    notified().await;
    let queued = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    notified().await;
    catalogue.request_cancel(queued.id, by()).await.unwrap();
    notified().await;
    catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    notified().await;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    catalogue.publish(job.id, job.token, &artifact("lab", "d2"), Some("current"), None).await.unwrap();
    notified().await;
    catalogue.delete_database("lab", by()).await.unwrap();
    notified().await;
}
