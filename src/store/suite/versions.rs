//! Versions: numbered, never twice, one a digest.

use futures_util::future::join_all;

use super::{Shared, artifact, by, lab, numbers};
use crate::store::{CatalogueError, NewVersion};

pub async fn a_version_is_read_back_whole_and_its_digest_is_unique(catalogue: Shared) {
    let new = artifact("lab", "d1");
    let unknown = catalogue.insert_version(&new, by()).await.unwrap_err();
    assert!(matches!(unknown, CatalogueError::NotFound { .. }), "{unknown:?}");

    lab(&catalogue).await;
    let (row, created) = catalogue.insert_version(&new, by()).await.unwrap();
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
    assert_eq!(catalogue.insert_version(&other_bytes, by()).await.unwrap(), (row, false));

    catalogue.create_database("other", "landmarks", "{}", by()).await.unwrap();
    let (elsewhere, created) = catalogue.insert_version(&artifact("other", "d1"), by()).await.unwrap();
    assert_eq!((elsewhere.version, created), (1, true));
}

pub async fn a_version_number_is_never_given_twice(catalogue: Shared) {
    lab(&catalogue).await;
    for digest in ["d1", "d2", "d3"] {
        catalogue.insert_version(&artifact("lab", digest), by()).await.unwrap();
    }
    assert!(catalogue.delete_version("lab", 3, by()).await.unwrap());
    assert!(!catalogue.delete_version("lab", 3, by()).await.unwrap());
    // The same inputs again are a new version now, under a new number.
    let (row, created) = catalogue.insert_version(&artifact("lab", "d3"), by()).await.unwrap();
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
            catalogue.insert_version(&artifact("lab", &format!("d{}", task % 2)), by()).await.unwrap()
        })
    });
    let inserted: Vec<_> = join_all(tasks).await.into_iter().map(Result::unwrap).collect();
    assert_eq!(inserted.iter().filter(|(_, created)| *created).count(), 2);
    assert_eq!(numbers(&catalogue).await, [1, 2]);
}
