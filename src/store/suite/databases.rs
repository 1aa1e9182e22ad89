//! Databases: created once, listed, deleted with all they hold.

use super::{LEASE, Shared, TRAINING, artifact, by, exemplar, lab};
use crate::store::{AliasExpectation, CatalogueError, DatabaseCounts, JobState};

pub async fn a_database_is_created_once_and_stays_as_it_is(catalogue: Shared) {
    catalogue.ping().await.unwrap();
    let (first, created) = catalogue.create_database("lab", "landmarks", r#"{"a":1}"#, by()).await.unwrap();
    assert!(created);
    assert_eq!((first.kind.as_str(), first.options.as_str()), ("landmarks", r#"{"a":1}"#));

    let (again, created) = catalogue.create_database("lab", "objects", "{}", by()).await.unwrap();
    assert!(!created);
    assert_eq!(again, first);

    let changed = catalogue.set_database_options("lab", "{}", by()).await.unwrap();
    assert_eq!(changed.options, "{}");
    assert_eq!(catalogue.database("lab").await.unwrap(), Some(changed));
    assert_eq!(catalogue.database("other").await.unwrap(), None);
    let unknown = catalogue.set_database_options("other", "{}", by()).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
    let unknown = catalogue.database_counts("other").await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");
}

pub async fn databases_come_in_pages_by_name(catalogue: Shared) {
    for name in ["c", "a", "b"] {
        catalogue.create_database(name, "objects", "{}", by()).await.unwrap();
    }
    let page = catalogue.databases(None, 2).await.unwrap();
    assert_eq!(page.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    let page = catalogue.databases(Some("b"), 2).await.unwrap();
    assert_eq!(page.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["c"]);
}

pub async fn deleting_a_database_takes_all_it_holds_and_ends_its_jobs(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.create_database("kept", "landmarks", "{}", by()).await.unwrap();
    for database in ["lab", "kept"] {
        catalogue.insert_exemplar(&exemplar(database, 1, "kitchen")).await.unwrap();
        catalogue.insert_version(&artifact(database, "d1"), by()).await.unwrap();
        catalogue.set_alias(database, "current", 1, AliasExpectation::Any, by()).await.unwrap();
    }
    let running = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    let running =
        catalogue.claim_job("w", TRAINING, LEASE, 3).await.unwrap().filter(|job| job.id == running.id);
    let running = running.unwrap();
    let queued = catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
    let other = catalogue.enqueue_job("training", "kept", "{}", by()).await.unwrap();

    assert!(catalogue.delete_database("lab", by()).await.unwrap());
    assert!(!catalogue.delete_database("lab", by()).await.unwrap());

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
    let lost =
        catalogue.publish(running.id, running.token, &artifact("lab", "d2"), None, None).await.unwrap_err();
    assert!(matches!(lost, CatalogueError::LeaseLost), "{lost:?}");
    let counts = catalogue.database_counts("kept").await.unwrap();
    assert_eq!(counts, DatabaseCounts { exemplars: 1, labels: 1, versions: 1 });
    assert_eq!(catalogue.all_aliases().await.unwrap().len(), 1);
}
