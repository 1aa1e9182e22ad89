//! Calibrations: replaced by compare-and-swap, and their jobs.

use super::{LEASE, Shared, TRAINING, by, is_referenced, lab};
use crate::store::{CatalogueError, JobFilter, JobState};

const SWEEP: &[&str] = &["sweep"];

pub async fn a_calibration_is_replaced_only_from_the_expected_revision(catalogue: Shared) {
    let put =
        async |document: &str, expected| catalogue.put_calibration("rig", document, expected, by()).await;
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

    assert!(catalogue.delete_calibration("rig", by()).await.unwrap());
    assert!(!catalogue.delete_calibration("rig", by()).await.unwrap());
    // Created again, it repeats no revision.
    assert!(put("{}", None).await.unwrap().revision > second.revision);
}

pub async fn calibrations_come_in_pages_by_name(catalogue: Shared) {
    for name in ["c", "a", "b"] {
        catalogue.put_calibration(name, "{}", None, by()).await.unwrap();
    }
    let names = async |after, limit| -> Vec<String> {
        catalogue.calibrations(after, limit).await.unwrap().into_iter().map(|row| row.name).collect()
    };
    assert_eq!(names(None, 2).await, ["a", "b"]);
    assert_eq!(names(Some("b"), 2).await, ["c"]);
}

pub async fn a_job_about_a_calibration_keeps_its_blobs_until_it_ends(catalogue: Shared) {
    let blobs = ["one".to_owned(), "two".to_owned(), "one".to_owned()];
    let unknown = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &blobs, by()).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    catalogue.put_calibration("rig", "{}", None, by()).await.unwrap();
    let job = catalogue.enqueue_calibration_job("sweep", "rig", r#"{"n":1}"#, &blobs, by()).await.unwrap();
    assert_eq!((job.database.as_deref(), job.calibration.as_deref()), (None, Some("rig")));
    assert_eq!(catalogue.job_events(job.id, 0).await.unwrap()[0].body, job);
    let of_rig = JobFilter { calibration: Some("rig".to_owned()), ..JobFilter::default() };
    assert_eq!(catalogue.jobs(&of_rig, None, 9).await.unwrap(), std::slice::from_ref(&job));
    let of_lab = JobFilter { database: Some("rig".to_owned()), ..JobFilter::default() };
    assert_eq!(catalogue.jobs(&of_lab, None, 9).await.unwrap(), []);

    let referenced = async |blob: &str| is_referenced(&catalogue, blob).await;
    assert!(referenced("one").await && referenced("two").await && !referenced("three").await);
    assert_eq!(catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap(), None);
    let claimed = catalogue.claim_job("w", SWEEP, LEASE, 3).await.unwrap().unwrap();
    assert!(referenced("one").await);
    catalogue.fail_job(job.id, claimed.token, "{}").await.unwrap();
    assert!(!referenced("one").await && !referenced("two").await);
}

pub async fn a_calibration_and_its_job_end_together_or_not_at_all(catalogue: Shared) {
    let rig = catalogue.put_calibration("rig", "{}", None, by()).await.unwrap();
    let claimed = async || {
        catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[], by()).await.unwrap();
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
    catalogue.request_cancel(unwanted.id, by()).await.unwrap();
    let refused = catalogue.publish_calibration(unwanted.id, unwanted.token, "{}", swept.revision).await;
    assert!(matches!(refused, Err(CatalogueError::CancelRequested)), "{refused:?}");
}

pub async fn deleting_a_calibration_ends_its_jobs(catalogue: Shared) {
    lab(&catalogue).await;
    let rig = catalogue.put_calibration("rig", "{}", None, by()).await.unwrap();
    let running = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[], by()).await.unwrap();
    let token = catalogue.claim_job("w", SWEEP, LEASE, 3).await.unwrap().unwrap().token;
    let queued = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[], by()).await.unwrap();
    // A database of no name, or of the calibration's, is another thing.
    catalogue.create_database("rig", "landmarks", "{}", by()).await.unwrap();
    let other = catalogue.enqueue_job("training", "rig", "{}", by()).await.unwrap();
    assert!(catalogue.delete_calibration("rig", by()).await.unwrap());
    for id in [running.id, queued.id] {
        let job = catalogue.job(id).await.unwrap().unwrap();
        assert_eq!(job.state, JobState::Cancelled);
        assert!(job.problem.unwrap().contains("calibration_deleted"));
    }
    assert_eq!(catalogue.job(other.id).await.unwrap().unwrap().state, JobState::Queued);
    catalogue.put_calibration("rig", "{}", None, by()).await.unwrap();
    let lost = catalogue.publish_calibration(running.id, token, "{}", rig.revision).await.unwrap_err();
    assert!(matches!(lost, CatalogueError::LeaseLost), "{lost:?}");

    let sweep = catalogue.enqueue_calibration_job("sweep", "rig", "{}", &[], by()).await.unwrap();
    assert!(catalogue.delete_database("rig", by()).await.unwrap());
    assert_eq!(catalogue.job(sweep.id).await.unwrap().unwrap().state, JobState::Queued);
}
