//! Aliases: moved by compare-and-swap.

use std::collections::HashSet;

use futures_util::future::join_all;

use super::{Shared, artifact, by, lab, numbers};
use crate::store::{AliasExpectation, CatalogueError};

pub async fn an_aliased_version_cannot_be_deleted(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    catalogue.insert_version(&artifact("lab", "d2"), by()).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Any, by()).await.unwrap();
    let refused = catalogue.delete_version("lab", 1, by()).await.unwrap_err();
    assert!(matches!(refused, CatalogueError::Conflict { .. }), "{refused:?}");
    assert!(refused.to_string().contains("current"), "{refused}");
    catalogue.set_alias("lab", "current", 2, AliasExpectation::Any, by()).await.unwrap();
    assert!(catalogue.delete_version("lab", 1, by()).await.unwrap());
    assert_eq!(numbers(&catalogue).await, [2]);
}

pub async fn an_alias_moves_only_from_the_expected_revision(catalogue: Shared) {
    use AliasExpectation::{Absent, Any, Revision};
    lab(&catalogue).await;
    for digest in ["d1", "d2"] {
        catalogue.insert_version(&artifact("lab", digest), by()).await.unwrap();
    }
    let set = async |version, expected| catalogue.set_alias("lab", "current", version, expected, by()).await;
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

    let delete = async |expected| catalogue.delete_alias("lab", "current", expected, by()).await;
    assert!(matches!(delete(Revision(first.revision)).await, Err(CatalogueError::PreconditionFailed)));
    assert!(delete(Revision(second.revision)).await.unwrap());
    assert!(!delete(Any).await.unwrap());
    assert!(matches!(delete(Revision(second.revision)).await, Err(CatalogueError::PreconditionFailed)));

    // Created again, it repeats no revision, so a compare against the old one can't succeed by chance.
    let (recreated, created) = set(1, Absent).await.unwrap();
    assert!(created);
    assert!(recreated.revision > second.revision);
}

pub async fn under_contention_every_alias_revision_has_one_winner(catalogue: Shared) {
    lab(&catalogue).await;
    catalogue.insert_version(&artifact("lab", "d1"), by()).await.unwrap();
    catalogue.set_alias("lab", "current", 1, AliasExpectation::Absent, by()).await.unwrap();
    let tasks = (0..8).map(|_| {
        let catalogue = catalogue.clone();
        tokio::spawn(async move {
            let mut won = Vec::new();
            while won.len() < 5 {
                let seen = catalogue.aliases("lab").await.unwrap()[0].revision;
                match catalogue.set_alias("lab", "current", 1, AliasExpectation::Revision(seen), by()).await {
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
