//! What every catalogue promises, written against the trait alone.
//!
//! An implementation runs it with `catalogue_suite!(open)`, where `open` gives an empty catalogue and whatever
//! must stay alive with it.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::join_all;
use jiff::Timestamp;
use uuid::Uuid;

use super::{
    AliasExpectation, Catalogue, CatalogueError, DatabaseCounts, ExemplarFilter, ExemplarRow, JobFilter,
    JobState, NewVersion, Progress, Renewal,
};

const LEASE: Duration = Duration::from_secs(60);
/// Runs out the moment it is taken.
const NO_LEASE: Duration = Duration::ZERO;
const TRAINING: &[&str] = &["training"];

/// Makes one test of every promise.
macro_rules! catalogue_suite {
    ($open:path) => {
        $crate::store::suite::catalogue_suite! { @each $open:
            a_database_is_created_once_and_stays_as_it_is
            databases_come_in_pages_by_name
            deleting_a_database_takes_all_it_holds_and_ends_its_jobs
            an_exemplar_is_inserted_once_and_read_back_whole
            exemplars_are_filtered_and_paged_and_trained_in_one_order
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
            a_queued_job_is_cancelled_at_once_and_a_running_one_is_told
            a_cancelled_job_of_a_dead_worker_is_not_taken_up_again
            publishing_moves_version_alias_and_job_together
            a_publish_that_fails_changes_nothing
            concurrent_publishes_of_one_digest_give_one_version
            a_job_succeeds_with_a_version_that_was_there
            a_job_handed_back_loses_no_attempt
            the_leases_of_dead_owners_end_now
            every_change_of_state_or_progress_is_an_event
            jobs_come_newest_first_and_are_counted_by_state
            a_blob_is_referenced_while_a_row_names_it
            a_calibration_is_replaced_only_from_the_expected_revision
            calibrations_come_in_pages_by_name
            a_job_about_a_calibration_keeps_its_blobs_until_it_ends
            a_calibration_and_its_job_end_together_or_not_at_all
            deleting_a_calibration_ends_its_jobs
            a_call_dropped_midway_leaves_the_catalogue_whole
        }
    };
    (@each $open:path: $($promise:ident)+) => {
        $(
            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            async fn $promise() {
                let (catalogue, _kept) = $open().await;
                $crate::store::suite::$promise(catalogue).await;
            }
        )+
    };
}
pub(super) use catalogue_suite;

type Shared = Arc<dyn Catalogue>;

fn exemplar(database: &str, number: u128, label: &str) -> ExemplarRow {
    ExemplarRow {
        database: database.to_owned(),
        id: Uuid::from_u128(number),
        label: label.to_owned(),
        pose_deg: None,
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

fn label(label: &str) -> ExemplarFilter {
    ExemplarFilter { label: Some(label.to_owned()), robot_id: None }
}

fn robot(robot_id: &str) -> ExemplarFilter {
    ExemplarFilter { label: None, robot_id: Some(robot_id.to_owned()) }
}

async fn lab(catalogue: &Shared) {
    catalogue.create_database("lab", "landmarks", "{}").await.unwrap();
}

async fn numbers(catalogue: &Shared) -> Vec<i64> {
    catalogue.versions("lab", None, 1000).await.unwrap().iter().map(|row| row.version).collect()
}

pub async fn a_database_is_created_once_and_stays_as_it_is(catalogue: Shared) {
    catalogue.ping().await.unwrap();
    let (first, created) = catalogue.create_database("lab", "landmarks", r#"{"a":1}"#).await.unwrap();
    assert!(created);
    assert_eq!((first.kind.as_str(), first.options.as_str()), ("landmarks", r#"{"a":1}"#));

    let (again, created) = catalogue.create_database("lab", "objects", "{}").await.unwrap();
    assert!(!created);
    assert_eq!(again, first);

    let changed = catalogue.set_database_options("lab", "{}").await.unwrap();
    assert_eq!(changed.options, "{}");
    assert_eq!(catalogue.database("lab").await.unwrap(), Some(changed));
    assert_eq!(catalogue.database("other").await.unwrap(), None);
    let unknown = catalogue.set_database_options("other", "{}").await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    let unknown = catalogue.database_counts("other").await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
}

pub async fn databases_come_in_pages_by_name(catalogue: Shared) {
    for name in ["c", "a", "b"] {
        catalogue.create_database(name, "objects", "{}").await.unwrap();
    }
    let page = catalogue.databases(None, 2).await.unwrap();
    assert_eq!(page.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    let page = catalogue.databases(Some("b"), 2).await.unwrap();
    assert_eq!(page.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["c"]);
}

pub async fn deleting_a_database_takes_all_it_holds_and_ends_its_jobs(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("kept", "landmarks", "{}").await.unwrap();
    for database in ["lab", "kept"] {
        catalogue.insert_exemplar(&exemplar(database, 1, "kitchen")).await.unwrap();
        catalogue.insert_version(&artifact(database, "d1")).await.unwrap();
        catalogue.set_alias(database, "current", 1, AliasExpectation::Any).await.unwrap();
    }
    let running = catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
    let running =
        catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().filter(|job| job.id == running.id);
    let running = running.unwrap();
    let queued = catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
    let other = catalogue.enqueue_job("training", "kept", "{}").await.unwrap();

    assert!(catalogue.delete_database("lab").await.unwrap());
    assert!(!catalogue.delete_database("lab").await.unwrap());

    for id in [running.id, queued.id] {
        let job = catalogue.job(id).await.unwrap().unwrap();
        assert_eq!(job.state, JobState::Cancelled);
        assert!(job.problem.unwrap().contains("database_deleted"));
    }
    assert_eq!(catalogue.job(other.id).await.unwrap().unwrap().state, JobState::Queued);

    // Even when the name is taken again, the worker of the old database can publish nothing into the new one.
    lab(&catalogue).await;
    let counts = catalogue.database_counts("lab").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 0, labels: 0, versions: 0 });
    assert_eq!(catalogue.aliases("lab").await.unwrap(), []);
    let lost = catalogue.publish(running.id, running.token, &artifact("lab", "d2"), None).await.unwrap_err();
    assert!(matches!(lost, CatalogueError::LeaseLost), "{lost:?}");
    let counts = catalogue.database_counts("kept").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 1, labels: 1, versions: 1 });
    assert_eq!(catalogue.all_aliases().await.unwrap().len(), 1);
}

pub async fn an_exemplar_is_inserted_once_and_read_back_whole(catalogue: Shared) {
    let full = ExemplarRow {
        pose_deg: Some(359.75),
        robot_id: Some("r2".to_owned()),
        frame_id: Some("head".to_owned()),
        stamp: Some("12.000000034".to_owned()),
        ..exemplar("lab", 7, "it's a \"kitchen\"; DROP TABLE exemplars")
    };
    let unknown = catalogue.insert_exemplar(&full).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");

    lab(&catalogue).await;
    let before = Timestamp::now().as_microsecond();
    let (stored, created) = catalogue.insert_exemplar(&full).await.unwrap();
    assert!(created);
    assert!(stored.created_at.as_microsecond() >= before);
    assert_eq!(stored, ExemplarRow { created_at: stored.created_at, ..full.clone() });
    assert_eq!(catalogue.exemplar("lab", full.id).await.unwrap(), Some(stored.clone()));

    let other = ExemplarRow { label: "hall".to_owned(), ..full };
    assert_eq!(catalogue.insert_exemplar(&other).await.unwrap(), (stored, false));
    assert_eq!(catalogue.exemplar("lab", Uuid::from_u128(8)).await.unwrap(), None);
}

pub async fn exemplars_are_filtered_and_paged_and_trained_in_one_order(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("other", "landmarks", "{}").await.unwrap();
    for (number, label, robot_id) in [(4, "b", "r1"), (1, "b", "r2"), (3, "a", "r1"), (2, "c", "r1")] {
        let row = ExemplarRow { robot_id: Some(robot_id.to_owned()), ..exemplar("lab", number, label) };
        catalogue.insert_exemplar(&row).await.unwrap();
    }
    catalogue.insert_exemplar(&exemplar("other", 5, "b")).await.unwrap();

    let list = async |filter: &ExemplarFilter, after: Option<u128>, limit| {
        let rows = catalogue.exemplars("lab", filter, after.map(Uuid::from_u128), limit).await.unwrap();
        rows.iter().map(|row| row.id.as_u128()).collect::<Vec<_>>()
    };
    assert_eq!(list(&ExemplarFilter::default(), None, 3).await, [1, 2, 3]);
    assert_eq!(list(&ExemplarFilter::default(), Some(3), 3).await, [4]);
    assert_eq!(list(&label("b"), None, 9).await, [1, 4]);
    assert_eq!(list(&robot("r1"), None, 9).await, [2, 3, 4]);
    let both = ExemplarFilter { label: label("b").label, robot_id: robot("r1").robot_id };
    assert_eq!(list(&both, None, 9).await, [4]);

    let trained = catalogue.training_set("lab").await.unwrap();
    let trained: Vec<_> = trained.iter().map(|row| (row.label.as_str(), row.id.as_u128())).collect();
    assert_eq!(trained, [("a", 3), ("b", 1), ("b", 4), ("c", 2)]);
    let counts = catalogue.database_counts("lab").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 4, labels: 3, versions: 0 });
}

pub async fn exemplars_are_deleted_one_by_one_or_by_a_filter_that_names_something(catalogue: Shared) {
    lab(&catalogue).await;
    for (number, label) in [(1, "a"), (2, "b"), (3, "b"), (4, "c")] {
        catalogue.insert_exemplar(&exemplar("lab", number, label)).await.unwrap();
    }
    assert!(catalogue.delete_exemplar("lab", Uuid::from_u128(1)).await.unwrap());
    assert!(!catalogue.delete_exemplar("lab", Uuid::from_u128(1)).await.unwrap());
    let refused = catalogue.delete_exemplars("lab", &ExemplarFilter::default()).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::EmptyFilter), "{refused:?}");
    assert_eq!(catalogue.delete_exemplars("lab", &robot("r1")).await.unwrap(), 0);
    assert_eq!(catalogue.delete_exemplars("lab", &label("b")).await.unwrap(), 2);
    let left = catalogue.training_set("lab").await.unwrap();
    assert_eq!(left.iter().map(|row| row.id.as_u128()).collect::<Vec<_>>(), [4]);
}

pub async fn a_version_is_read_back_whole_and_its_digest_is_unique(catalogue: Shared) {
    let new = artifact("lab", "d1");
    let unknown = catalogue.insert_version(&new).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");

    lab(&catalogue).await;
    let (row, created) = catalogue.insert_version(&new).await.unwrap();
    assert!(created);
    let read_back = NewVersion {
        database: row.database.clone(),
        digest: row.digest.clone(),
        blob: row.blob.clone(),
        bytes: row.bytes,
        kind: row.kind.clone(),
        algorithm_revision: row.algorithm_revision,
        options: row.options.clone(),
        counts: row.counts.clone(),
        report: row.report.clone(),
    };
    assert_eq!((row.version, &read_back), (1, &new));
    assert_eq!(catalogue.version("lab", 1).await.unwrap().as_ref(), Some(&row));
    assert_eq!(catalogue.version("lab", 2).await.unwrap(), None);
    assert_eq!(catalogue.version_by_digest("lab", "d1").await.unwrap().as_ref(), Some(&row));
    assert_eq!(catalogue.version_by_digest("lab", "d2").await.unwrap(), None);

    let other_bytes = NewVersion { blob: "another".to_owned(), ..new };
    assert_eq!(catalogue.insert_version(&other_bytes).await.unwrap(), (row, false));

    catalogue.create_database("other", "landmarks", "{}").await.unwrap();
    let (elsewhere, created) = catalogue.insert_version(&artifact("other", "d1")).await.unwrap();
    assert_eq!((elsewhere.version, created), (1, true));
}

pub async fn a_version_number_is_never_given_twice(catalogue: Shared) {
    lab(&catalogue).await;
    for digest in ["d1", "d2", "d3"] {
        catalogue.insert_version(&artifact("lab", digest)).await.unwrap();
    }
    assert!(catalogue.delete_version("lab", 3).await.unwrap());
    assert!(!catalogue.delete_version("lab", 3).await.unwrap());
    // The same inputs again are a new version now, under a new number.
    let (row, created) = catalogue.insert_version(&artifact("lab", "d3")).await.unwrap();
    assert_eq!((row.version, created), (4, true));
    assert_eq!(numbers(&catalogue).await, [1, 2, 4]);
    let page = catalogue.versions("lab", Some(1), 1).await.unwrap();
    assert_eq!(page.iter().map(|row| row.version).collect::<Vec<_>>(), [2]);
}

pub async fn concurrent_versions_of_one_digest_are_one_version(catalogue: Shared) {
    lab(&catalogue).await;
    let tasks = (0..16).map(|task| {
        let catalogue = catalogue.clone();
        tokio::spawn(async move {
            catalogue.insert_version(&artifact("lab", &format!("d{}", task % 2))).await.unwrap()
        })
    });
    let inserted: Vec<_> = join_all(tasks).await.into_iter().map(Result::unwrap).collect();
    assert_eq!(inserted.iter().filter(|(_, created)| *created).count(), 2);
    assert_eq!(numbers(&catalogue).await, [1, 2]);
}

pub async fn an_aliased_version_cannot_be_deleted(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1")).await.unwrap();
    catalogue.insert_version(&artifact("lab", "d2")).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any).await.unwrap();
    let refused = catalogue.delete_version("lab", 1).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::Conflict { .. }), "{refused:?}");
    assert!(refused.to_string().contains("current"), "{refused}");
    catalogue.set_alias("lab", "current", 2, AliasExpectation::Any).await.unwrap();
    assert!(catalogue.delete_version("lab", 1).await.unwrap());
    assert_eq!(numbers(&catalogue).await, [2]);
}

pub async fn an_alias_moves_only_from_the_expected_revision(catalogue: Shared) {
    use AliasExpectation::{Absent, Any, Revision};
    lab(&catalogue).await;
    for digest in ["d1", "d2"] {
        catalogue.insert_version(&artifact("lab", digest)).await.unwrap();
    }
    let set = async |version, expected| catalogue.set_alias("lab", "current", version, expected).await;
    let refused =
        |result: Result<_, CatalogueError>| matches!(result, Err(CatalogueError::PreconditionFailed));

    assert!(refused(set(1, Revision(0)).await));
    assert!(matches!(set(9, Any).await, Err(CatalogueError::NotFound { .. })));
    let (first, created) = set(1, Absent).await.unwrap();
    assert!(created);
    assert!(refused(set(2, Absent).await));
    let (second, created) = set(2, Revision(first.revision)).await.unwrap();
    assert!(!created);
    assert!(second.revision > first.revision);
    assert!(refused(set(1, Revision(first.revision)).await));
    assert_eq!(catalogue.aliases("lab").await.unwrap(), std::slice::from_ref(&second));

    let targets = catalogue.all_aliases().await.unwrap();
    assert_eq!(targets.len(), 1);
    let target = &targets[0];
    assert_eq!((target.database.as_str(), target.alias.as_str(), target.version), ("lab", "current", 2));
    assert_eq!((target.digest.as_str(), target.blob.as_str()), ("d2", "blob of d2"));
    assert_eq!((target.kind.as_str(), target.revision), ("landmarks", second.revision));

    let delete = async |expected| catalogue.delete_alias("lab", "current", expected).await;
    assert!(matches!(delete(Revision(first.revision)).await, Err(CatalogueError::PreconditionFailed)));
    assert!(delete(Revision(second.revision)).await.unwrap());
    assert!(!delete(Any).await.unwrap());
    assert!(matches!(delete(Revision(second.revision)).await, Err(CatalogueError::PreconditionFailed)));

    // Made anew, it repeats no revision, so a compare against the old one can't succeed by chance.
    let (anew, created) = set(1, Absent).await.unwrap();
    assert!(created);
    assert!(anew.revision > second.revision);
}

pub async fn under_contention_every_alias_revision_has_one_winner(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1")).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Absent).await.unwrap();
    let tasks = (0..8).map(|_| {
        let catalogue = catalogue.clone();
        tokio::spawn(async move {
            let mut won = Vec::new();
            while won.len() < 5 {
                let seen = catalogue.aliases("lab").await.unwrap()[0].revision;
                match catalogue.set_alias("lab", "current", 1, AliasExpectation::Revision(seen)).await {
                    Ok(_) => won.push(seen),
                    Err(CatalogueError::PreconditionFailed) => {}
                    Err(other) => panic!("{other:?}"),
                }
            }
            won
        })
    });
    let won: Vec<i64> = join_all(tasks).await.into_iter().flat_map(Result::unwrap).collect();
    assert_eq!(won.iter().collect::<HashSet<_>>().len(), 40, "a revision was replaced twice: {won:?}");
    assert_eq!(catalogue.aliases("lab").await.unwrap()[0].revision, 41);
}

pub async fn eight_workers_claim_two_hundred_jobs_once_each(catalogue: Shared) {
    lab(&catalogue).await;
    let mut queued = HashSet::new();
    for _ in 0..200 {
        queued.insert(catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id);
    }
    let tasks = (0..8).map(|worker| {
        let catalogue = catalogue.clone();
        tokio::spawn(async move {
            let owner = format!("worker {worker}");
            let mut claimed = Vec::new();
            while let Some(job) = catalogue.claim_job(&owner, TRAINING, LEASE, 3).await.unwrap() {
                assert_eq!((job.token, job.attempts, job.owner.as_deref()), (1, 1, Some(owner.as_str())));
                claimed.push(job.id);
            }
            claimed
        })
    });
    let claimed: Vec<Uuid> = join_all(tasks).await.into_iter().flat_map(Result::unwrap).collect();
    assert_eq!(claimed.len(), 200);
    assert_eq!(claimed.into_iter().collect::<HashSet<_>>(), queued);
}

pub async fn the_oldest_waiting_job_of_a_kind_is_claimed_first(catalogue: Shared) {
    let unknown = catalogue.enqueue_job("training", "lab", "{}").await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    lab(&catalogue).await;
    let sweep = catalogue.enqueue_job("sweep", "lab", r#"{"n":0}"#).await.unwrap();
    let first = catalogue.enqueue_job("training", "lab", r#"{"n":1}"#).await.unwrap();
    let second = catalogue.enqueue_job("training", "lab", r#"{"n":2}"#).await.unwrap();
    assert_eq!((first.state, first.token, first.attempts), (JobState::Queued, 0, 0));

    let claim = async |kinds: &[&str]| {
        catalogue.claim_job("w", kinds, LEASE, 3).await.unwrap().map(|job| (job.id, job.params))
    };
    assert_eq!(claim(&[]).await, None);
    assert_eq!(claim(TRAINING).await, Some((first.id, r#"{"n":1}"#.to_owned())));
    assert_eq!(claim(TRAINING).await, Some((second.id, r#"{"n":2}"#.to_owned())));
    assert_eq!(claim(TRAINING).await, None);
    assert_eq!(claim(&["training", "sweep"]).await, Some((sweep.id, r#"{"n":0}"#.to_owned())));
}

pub async fn a_worker_that_lost_its_lease_can_finish_nothing(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let slow = catalogue.claim_job("slow", TRAINING, NO_LEASE, 3).await.unwrap().unwrap();
    let quick = catalogue.claim_job("quick", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!((slow.id, quick.id), (id, id));
    assert_eq!((slow.token, quick.token, quick.attempts), (1, 2, 2));
    assert_eq!(quick.started_at, slow.started_at);
    let before = catalogue.job_events(id, 0).await.unwrap();

    let new = artifact("lab", "stale");
    let progress = Progress { stage: "eigen".to_owned(), done: 1, total: 2 };
    let lost = [
        catalogue.renew_job(id, slow.token, LEASE, Some(&progress)).await.map(drop),
        catalogue.publish(id, slow.token, &new, Some("current")).await.map(drop),
        catalogue.succeed_job(id, slow.token, None, None).await.map(drop),
        catalogue.fail_job(id, slow.token, "{}").await.map(drop),
        catalogue.cancelled_job(id, slow.token).await.map(drop),
    ];
    for result in lost {
        assert!(matches!(result, Err(CatalogueError::LeaseLost)), "{result:?}");
    }
    assert_eq!(catalogue.job(id).await.unwrap(), Some(quick.clone()));
    assert_eq!(catalogue.job_events(id, 0).await.unwrap(), before);
    assert_eq!(numbers(&catalogue).await, [0; 0]);
    assert_eq!(catalogue.aliases("lab").await.unwrap(), []);

    // The holder finishes; after that its token is worth nothing either.
    catalogue.publish(id, quick.token, &artifact("lab", "fresh"), None).await.unwrap();
    let late = catalogue.fail_job(id, quick.token, "{}").await.unwrap_err();
    assert!(matches!(late, CatalogueError::LeaseLost), "{late:?}");
    assert_eq!(catalogue.job(id).await.unwrap().unwrap().state, JobState::Succeeded);
}

pub async fn a_job_that_never_finishes_fails_with_the_reason(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let next = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    for attempt in 1..=2 {
        let job = catalogue.claim_job("w", TRAINING, NO_LEASE, 2).await.unwrap().unwrap();
        assert_eq!((job.id, job.attempts), (id, attempt));
    }
    // The exhausted job doesn't stand in the way of the next one.
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 2).await.unwrap().unwrap().id, next);
    let job = catalogue.job(id).await.unwrap().unwrap();
    assert_eq!((job.state, job.attempts, job.lease_until), (JobState::Failed, 2, None));
    assert!(job.finished_at.is_some());
    let problem: serde_json::Value = serde_json::from_str(&job.problem.unwrap()).unwrap();
    assert_eq!(problem["code"], "attempts_exhausted");
    assert!(problem["detail"].as_str().unwrap().contains("2 times"), "{problem}");
}

pub async fn a_queued_job_is_cancelled_at_once_and_a_running_one_is_told(catalogue: Shared) {
    lab(&catalogue).await;
    assert_eq!(catalogue.request_cancel(Uuid::from_u128(1)).await.unwrap(), None);

    let queued = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let cancelled = catalogue.request_cancel(queued).await.unwrap().unwrap();
    assert_eq!(cancelled.state, JobState::Cancelled);
    assert!(cancelled.finished_at.is_some());
    assert_eq!(catalogue.request_cancel(queued).await.unwrap(), Some(cancelled));

    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(job.id, id);
    let renew = async || catalogue.renew_job(id, job.token, LEASE, None).await.unwrap();
    assert_eq!(renew().await, Renewal { cancel_requested: false });
    let told = catalogue.request_cancel(id).await.unwrap().unwrap();
    assert_eq!((told.state, told.cancel_requested), (JobState::Running, true));
    assert_eq!(renew().await, Renewal { cancel_requested: true });
    let cancelled = catalogue.cancelled_job(id, job.token).await.unwrap();
    assert_eq!((cancelled.state, cancelled.problem), (JobState::Cancelled, None));
}

pub async fn a_cancelled_job_of_a_dead_worker_is_not_taken_up_again(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    catalogue.claim_job("dead", TRAINING, NO_LEASE, 3).await.unwrap().unwrap();
    catalogue.request_cancel(id).await.unwrap();
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap(), None);
    assert_eq!(catalogue.job(id).await.unwrap().unwrap().state, JobState::Cancelled);
}

pub async fn publishing_moves_version_alias_and_job_together(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1")).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any).await.unwrap();
    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let version = catalogue.publish(id, job.token, &artifact("lab", "d2"), Some("current")).await.unwrap();
    assert_eq!(version.version, 2);
    let aliases = catalogue.aliases("lab").await.unwrap();
    assert_eq!(aliases.iter().map(|row| row.version).collect::<Vec<_>>(), [2]);
    let done = catalogue.job(id).await.unwrap().unwrap();
    assert_eq!((done.state, done.version, done.lease_until), (JobState::Succeeded, Some(2), None));
    assert!(done.finished_at >= done.started_at);

    // Not promoted: the alias stays.
    catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    catalogue.publish(job.id, job.token, &artifact("lab", "d3"), None).await.unwrap();
    assert_eq!(catalogue.aliases("lab").await.unwrap(), aliases);
}

pub async fn a_publish_that_fails_changes_nothing(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let refused =
        catalogue.publish(id, job.token, &artifact("gone", "d1"), Some("current")).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::NotFound { .. }), "{refused:?}");
    // Here the job's end was already written when the version turned out to be missing.
    let refused = catalogue.succeed_job(id, job.token, Some(9), Some("current")).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::NotFound { .. }), "{refused:?}");
    assert_eq!(catalogue.job(id).await.unwrap(), Some(job.clone()));
    assert_eq!(catalogue.job_events(id, 0).await.unwrap().len(), 2);
    // The lease is still good.
    assert_eq!(catalogue.publish(id, job.token, &artifact("lab", "d1"), None).await.unwrap().version, 1);
}

pub async fn concurrent_publishes_of_one_digest_give_one_version(catalogue: Shared) {
    lab(&catalogue).await;
    let mut jobs = Vec::new();
    for _ in 0..4 {
        catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
        jobs.push(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap());
    }
    let tasks = jobs.iter().map(|job| {
        let (catalogue, id, token) = (catalogue.clone(), job.id, job.token);
        tokio::spawn(
            async move { catalogue.publish(id, token, &artifact("lab", "same"), Some("current")).await },
        )
    });
    for published in join_all(tasks).await {
        assert_eq!(published.unwrap().unwrap().version, 1);
    }
    assert_eq!(numbers(&catalogue).await, [1]);
    for job in jobs {
        let job = catalogue.job(job.id).await.unwrap().unwrap();
        assert_eq!((job.state, job.version), (JobState::Succeeded, Some(1)));
    }
}

pub async fn a_job_succeeds_with_a_version_that_was_there(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1")).await.unwrap();
    catalogue.enqueue_job("training", "lab", "{}").await.unwrap();
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let done = catalogue.succeed_job(job.id, job.token, Some(1), Some("current")).await.unwrap();
    assert_eq!((done.state, done.version), (JobState::Succeeded, Some(1)));
    assert_eq!(catalogue.job(job.id).await.unwrap(), Some(done));
    assert_eq!(catalogue.aliases("lab").await.unwrap()[0].version, 1);
}

pub async fn a_job_handed_back_loses_no_attempt(catalogue: Shared) {
    lab(&catalogue).await;
    let back = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let ended = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let others = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let job = catalogue.claim_job("leaving", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.claim_job("leaving", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.claim_job("staying", TRAINING, LEASE, 1).await.unwrap().unwrap();
    catalogue.request_cancel(ended).await.unwrap();

    assert_eq!(catalogue.hand_back_jobs("leaving").await.unwrap(), 2);
    assert_eq!(catalogue.hand_back_jobs("leaving").await.unwrap(), 0);

    let waiting = catalogue.job(back).await.unwrap().unwrap();
    assert_eq!((waiting.state, waiting.attempts, waiting.owner), (JobState::Queued, 0, None));
    assert_eq!(catalogue.job(ended).await.unwrap().unwrap().state, JobState::Cancelled);
    assert_eq!(catalogue.job(others).await.unwrap().unwrap().state, JobState::Running);
    let late = catalogue.fail_job(back, job.token, "{}").await.unwrap_err();
    assert!(matches!(late, CatalogueError::LeaseLost), "{late:?}");

    // One attempt is allowed, and it is still to be had.
    let again = catalogue.claim_job("next", TRAINING, LEASE, 1).await.unwrap().unwrap();
    assert_eq!((again.id, again.attempts, again.token), (back, 1, 2));
}

pub async fn the_leases_of_dead_owners_end_now(catalogue: Shared) {
    lab(&catalogue).await;
    let dead = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    catalogue.claim_job("dead", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let ours = catalogue.enqueue_job("training", "lab", "{}").await.unwrap().id;
    let held = catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(held.id, ours);
    assert_eq!(catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap(), None);

    assert_eq!(catalogue.release_dead_leases("us").await.unwrap(), 1);
    let taken = catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!((taken.id, taken.attempts, taken.token), (dead, 2, 2));
    assert_eq!(catalogue.claim_job("us", TRAINING, LEASE, 3).await.unwrap(), None);
    assert_eq!(catalogue.job(ours).await.unwrap(), Some(held));
}

pub async fn every_change_of_state_or_progress_is_an_event(catalogue: Shared) {
    lab(&catalogue).await;
    let id = catalogue.enqueue_job("training", "lab", r#"{"top":1}"#).await.unwrap().id;
    let job = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    let step = |done| Progress { stage: "signatures".to_owned(), done, total: 2 };
    for progress in [Some(step(1)), Some(step(1)), None, Some(step(2))] {
        let renewed_from = catalogue.job(id).await.unwrap().unwrap().lease_until;
        catalogue.renew_job(id, job.token, LEASE, progress.as_ref()).await.unwrap();
        assert!(catalogue.job(id).await.unwrap().unwrap().lease_until > renewed_from);
    }
    let published = catalogue.publish(id, job.token, &artifact("lab", "d1"), None).await.unwrap();

    let events = catalogue.job_events(id, 0).await.unwrap();
    let told: Vec<_> = events
        .iter()
        .map(|event| {
            let done = event.body.progress.as_ref().map(|progress| progress.done);
            (event.sequence, event.body.state, done, event.body.version)
        })
        .collect();
    assert_eq!(
        told,
        [
            (1, JobState::Queued, None, None),
            (2, JobState::Running, None, None),
            (3, JobState::Running, Some(1), None),
            (4, JobState::Running, Some(2), None),
            (5, JobState::Succeeded, Some(2), Some(published.version)),
        ]
    );
    assert_eq!(events[1].body, job);
    assert_eq!(Some(&events[4].body), catalogue.job(id).await.unwrap().as_ref());
    assert!(events.iter().all(|event| event.job == id && event.body.params == r#"{"top":1}"#));
    assert_eq!(catalogue.job_events(id, 3).await.unwrap(), events[3..]);
    assert_eq!(catalogue.job_events(Uuid::from_u128(1), 0).await.unwrap(), []);
}

pub async fn jobs_come_newest_first_and_are_counted_by_state(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("other", "landmarks", "{}").await.unwrap();
    let mut ids = Vec::new();
    for database in ["lab", "other", "lab", "lab"] {
        ids.push(catalogue.enqueue_job("training", database, "{}").await.unwrap().id);
    }
    let claimed = catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().unwrap();
    assert_eq!(claimed.id, ids[0]);

    let list = async |database: Option<&str>, state, after, limit| {
        let filter = JobFilter { database: database.map(str::to_owned), calibration: None, state };
        catalogue.jobs(&filter, after, limit).await.unwrap().iter().map(|job| job.id).collect::<Vec<_>>()
    };
    assert_eq!(list(None, None, None, 3).await, [ids[3], ids[2], ids[1]]);
    assert_eq!(list(None, None, Some(ids[1]), 3).await, [ids[0]]);
    assert_eq!(list(Some("lab"), None, None, 9).await, [ids[3], ids[2], ids[0]]);
    assert_eq!(list(Some("lab"), Some(JobState::Queued), None, 9).await, [ids[3], ids[2]]);
    assert!(list(None, Some(JobState::Failed), None, 9).await.is_empty());
    assert_eq!(catalogue.jobs_by_state().await.unwrap(), [(JobState::Queued, 3), (JobState::Running, 1)]);
}

pub async fn a_blob_is_referenced_while_a_row_names_it(catalogue: Shared) {
    lab(&catalogue).await;
    let row = exemplar("lab", 1, "a");
    let referenced = async |blob: &str| catalogue.is_blob_referenced(blob).await.unwrap();
    assert!(!referenced(&row.blob).await);
    catalogue.insert_exemplar(&row).await.unwrap();
    assert!(referenced(&row.blob).await);
    catalogue.delete_exemplar("lab", row.id).await.unwrap();
    assert!(!referenced(&row.blob).await);

    catalogue.insert_version(&artifact("lab", "d1")).await.unwrap();
    assert!(referenced("blob of d1").await);
    catalogue.delete_version("lab", 1).await.unwrap();
    assert!(!referenced("blob of d1").await);
}

const SWEEP: &[&str] = &["sweep"];

pub async fn a_calibration_is_replaced_only_from_the_expected_revision(catalogue: Shared) {
    let put = async |document: &str, expected| catalogue.put_calibration("rig", document, expected).await;
    let refused =
        |result: Result<_, CatalogueError>| matches!(result, Err(CatalogueError::PreconditionFailed));
    assert!(refused(put("{}", Some(1)).await));
    let first = put("{}", None).await.unwrap();
    assert_eq!((first.name.as_str(), first.document.as_str()), ("rig", "{}"));
    assert_eq!(first.created_at, first.updated_at);
    assert!(refused(put("{}", None).await));
    let second = put(r#"{"a":1}"#, Some(first.revision)).await.unwrap();
    assert!(second.revision > first.revision && second.created_at == first.created_at);
    assert!(refused(put("{}", Some(first.revision)).await));
    assert_eq!(catalogue.calibration("rig").await.unwrap(), Some(second.clone()));
    assert_eq!(catalogue.calibration("other").await.unwrap(), None);

    assert!(catalogue.delete_calibration("rig").await.unwrap());
    assert!(!catalogue.delete_calibration("rig").await.unwrap());
    // Made anew, it repeats no revision.
    assert!(put("{}", None).await.unwrap().revision > second.revision);
}

pub async fn calibrations_come_in_pages_by_name(catalogue: Shared) {
    for name in ["c", "a", "b"] {
        catalogue.put_calibration(name, "{}", None).await.unwrap();
    }
    let names = async |after, limit| -> Vec<String> {
        catalogue.calibrations(after, limit).await.unwrap().into_iter().map(|row| row.name).collect()
    };
    assert_eq!(names(None, 2).await, ["a", "b"]);
    assert_eq!(names(Some("b"), 2).await, ["c"]);
}

pub async fn a_job_about_a_calibration_keeps_its_blobs_until_it_ends(catalogue: Shared) {
    let blobs = ["one".to_owned(), "two".to_owned(), "one".to_owned()];
    let unknown = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &blobs).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    catalogue.put_calibration("rig", "{}", None).await.unwrap();
    let job = catalogue.enqueue_calibration_job("sweep", "rig", r#"{"n":1}"#, &blobs).await.unwrap();
    assert_eq!((job.database.as_deref(), job.calibration.as_deref()), (None, Some("rig")));
    assert_eq!(catalogue.job_events(job.id, 0).await.unwrap()[0].body, job);
    let of_rig = JobFilter { calibration: Some("rig".to_owned()), ..JobFilter::default() };
    assert_eq!(catalogue.jobs(&of_rig, None, 9).await.unwrap(), std::slice::from_ref(&job));
    let of_lab = JobFilter { database: Some("rig".to_owned()), ..JobFilter::default() };
    assert_eq!(catalogue.jobs(&of_lab, None, 9).await.unwrap(), []);

    let referenced = async |blob: &str| catalogue.is_blob_referenced(blob).await.unwrap();
    assert!(referenced("one").await && referenced("two").await && !referenced("three").await);
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap(), None);
    let claimed = catalogue.claim_job("w", SWEEP, LEASE, 3).await.unwrap().unwrap();
    assert!(referenced("one").await);
    catalogue.fail_job(job.id, claimed.token, "{}").await.unwrap();
    assert!(!referenced("one").await && !referenced("two").await);
}

pub async fn a_calibration_and_its_job_end_together_or_not_at_all(catalogue: Shared) {
    let rig = catalogue.put_calibration("rig", "{}", None).await.unwrap();
    let claimed = async || {
        catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[]).await.unwrap();
        catalogue.claim_job("w", SWEEP, LEASE, 3).await.unwrap().unwrap()
    };
    let job = claimed().await;
    let publish = async |token, expected| {
        catalogue.publish_calibration(job.id, token, r#"{"table":1}"#, expected).await
    };
    let lost = publish(job.token + 1, rig.revision).await.unwrap_err();
    assert!(matches!(lost, CatalogueError::LeaseLost), "{lost:?}");
    let changed = publish(job.token, rig.revision + 1).await.unwrap_err();
    assert!(matches!(changed, CatalogueError::PreconditionFailed), "{changed:?}");
    assert_eq!(catalogue.calibration("rig").await.unwrap(), Some(rig.clone()));
    assert_eq!(catalogue.job(job.id).await.unwrap().unwrap().state, JobState::Running);

    let swept = publish(job.token, rig.revision).await.unwrap();
    assert!(swept.revision > rig.revision && swept.document.contains("table"));
    let job = catalogue.job(job.id).await.unwrap().unwrap();
    assert_eq!((job.state, job.version), (JobState::Succeeded, None));

    let unwanted = claimed().await;
    catalogue.request_cancel(unwanted.id).await.unwrap();
    let refused = catalogue.publish_calibration(unwanted.id, unwanted.token, "{}", swept.revision).await;
    assert!(matches!(refused, Err(CatalogueError::CancelRequested)), "{refused:?}");
}

pub async fn deleting_a_calibration_ends_its_jobs(catalogue: Shared) {
    lab(&catalogue).await;
    let rig = catalogue.put_calibration("rig", "{}", None).await.unwrap();
    let running = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[]).await.unwrap();
    let token = catalogue.claim_job("w", SWEEP, LEASE, 3).await.unwrap().unwrap().token;
    let queued = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[]).await.unwrap();
    // A database of no name, or of the calibration's, is another thing.
    catalogue.create_database("rig", "landmarks", "{}").await.unwrap();
    let other = catalogue.enqueue_job("training", "rig", "{}").await.unwrap();
    assert!(catalogue.delete_calibration("rig").await.unwrap());
    for id in [running.id, queued.id] {
        let job = catalogue.job(id).await.unwrap().unwrap();
        assert_eq!(job.state, JobState::Cancelled);
        assert!(job.problem.unwrap().contains("calibration_deleted"));
    }
    assert_eq!(catalogue.job(other.id).await.unwrap().unwrap().state, JobState::Queued);
    catalogue.put_calibration("rig", "{}", None).await.unwrap();
    let lost = catalogue.publish_calibration(running.id, token, "{}", rig.revision).await.unwrap_err();
    assert!(matches!(lost, CatalogueError::LeaseLost), "{lost:?}");

    let sweep = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[]).await.unwrap();
    assert!(catalogue.delete_database("rig").await.unwrap());
    assert_eq!(catalogue.job(sweep.id).await.unwrap().unwrap().state, JobState::Queued);
}

pub async fn a_call_dropped_midway_leaves_the_catalogue_whole(catalogue: Shared) {
    lab(&catalogue).await;
    let mut dropped = 0;
    for round in 0..300 {
        let new = artifact("lab", &format!("d{round}"));
        let mut call = std::pin::pin!(catalogue.insert_version(&new));
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
    let (last, created) = catalogue.insert_version(&artifact("lab", "last")).await.unwrap();
    assert!(created);
    assert_eq!(numbers(&catalogue).await, (1..=last.version).collect::<Vec<_>>());
}
