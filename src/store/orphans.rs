//! Orphans: blobs that no row names, left behind by requests and jobs that didn't come to their end.

use std::collections::HashSet;
use std::time::Duration;

use futures_util::StreamExt;
use jiff::Timestamp;
use object_store::path::Path;
use object_store::{ObjectMeta, ObjectStore, ObjectStoreExt};

use super::blob_error::BlobError;
use super::blob_name::BlobName;
use super::blobs::{Blobs, Place};
use super::catalogue::Catalogue;
use super::error::CatalogueError;

/// Blobs that the catalogue is asked about at once: some 70 kB of names.
const BATCH: usize = 1000;

/// What a collection of orphans did.
#[derive(Debug, Default)]
pub struct OrphanCollection {
    /// Blobs that were deleted.
    pub removed: u64,
    /// Objects that couldn't be inspected or deleted; the next collection finds them again.
    pub failed: u64,
    /// Why the first of them couldn't.
    pub error: Option<BlobError>,
}

impl OrphanCollection {
    fn record(&mut self, removed: Result<bool, BlobError>) {
        match removed {
            Ok(is_removed) => self.removed += u64::from(is_removed),
            Err(error) => {
                self.failed += 1;
                self.error.get_or_insert(error);
            }
        }
    }
}

/// Deletes the blobs that no row names and that were put longer ago than `older_than`.
///
/// `older_than` must exceed the time that a request or a job may take between putting a blob and writing its row.
/// Whatever else stands in the store is left alone. What fails doesn't keep the others from being collected. Does
/// nothing while another process collects.
///
/// In a bucket another process may put an orphan again between the check of its age and its deletion; S3 has no deletion
/// with a condition on the age. An orphan is therefore set aside first, where it is still read, and deleted from there if
/// no row names it after `older_than` once more. One that a row names by then stays there.
///
/// # Errors
/// `Catalogue` when the catalogue can't say what is in use: what was deleted until then was rightly deleted.
/// `Unavailable` when the store can't be listed.
pub async fn collect_orphans(
    blobs: &Blobs,
    older_than: Duration,
    catalogue: &Catalogue,
) -> Result<OrphanCollection, BlobError> {
    let mut collection = OrphanCollection::default();
    let Some(_guard) = catalogue.try_lock_collection().await? else { return Ok(collection) };
    // By the beginnings of names: a listing ends where it fails, and the others go on.
    for beginning in blobs.store.list_with_delimiter(None).await?.common_prefixes {
        let mut batches = blobs.store.list(Some(&beginning)).chunks(BATCH);
        while let Some(batch) = batches.next().await {
            let old = old_blobs(batch, older_than, &mut collection);
            for (name, path) in unreferenced(old, catalogue).await? {
                // A task of its own: a caller that goes away must not end the removal while it excludes writers.
                let removal = remove(blobs.clone(), name, path, older_than);
                let removed = tokio::spawn(removal).await;
                collection.record(
                    removed.unwrap_or_else(|error| Err(BlobError::Unavailable { source: error.into() })),
                );
            }
        }
    }
    Ok(collection)
}

/// The blobs among listed objects that are old enough, with their paths; records the objects that can't be inspected.
fn old_blobs(
    listed: Vec<object_store::Result<ObjectMeta>>,
    older_than: Duration,
    collection: &mut OrphanCollection,
) -> Vec<(BlobName, Path)> {
    let mut old = Vec::new();
    for object in listed {
        match object {
            Ok(object) if is_older(&object, older_than) => {
                old.extend(BlobName::from_path(&object.location).map(|name| (name, object.location)));
            }
            Ok(_) => {}
            Err(error) => collection.record(Err(error.into())),
        }
    }
    old
}

/// Those of these blobs that no row names.
async fn unreferenced(
    mut blobs: Vec<(BlobName, Path)>,
    catalogue: &Catalogue,
) -> Result<Vec<(BlobName, Path)>, CatalogueError> {
    if !blobs.is_empty() {
        let names: Vec<String> = blobs.iter().map(|(name, _)| name.to_string()).collect();
        let referenced: HashSet<String> = catalogue.blobs_referenced(&names).await?.into_iter().collect();
        blobs.retain(|(name, _)| !referenced.contains(&name.to_string()));
    }
    Ok(blobs)
}

/// Deletes an orphan, or sets it aside; true when it is deleted.
async fn remove(blobs: Blobs, name: BlobName, path: Path, older_than: Duration) -> Result<bool, BlobError> {
    match &*blobs.place {
        Place::Folder { writes, .. } => {
            // Checks the age once more while nobody can put: a blob that was put again meanwhile stays.
            let _no_writes = writes.write().await;
            delete_if_older(&*blobs.store, &path, older_than).await
        }
        Place::Bucket { .. } if path == name.path() => {
            set_aside(&*blobs.store, &name, older_than).await?;
            Ok(false)
        }
        Place::Bucket { .. } => delete_if_older(&*blobs.store, &path, older_than).await,
    }
}

/// Copies an orphan to where nobody puts, and only then deletes it; the copy is young.
async fn set_aside(store: &dyn ObjectStore, name: &BlobName, older_than: Duration) -> Result<(), BlobError> {
    match store.copy(&name.path(), &name.path_aside()).await {
        // Another process was first.
        Err(object_store::Error::NotFound { .. }) => return Ok(()),
        copied => copied?,
    }
    delete_if_older(store, &name.path(), older_than).await?;
    Ok(())
}

async fn delete_if_older(
    store: &dyn ObjectStore,
    path: &Path,
    older_than: Duration,
) -> Result<bool, BlobError> {
    let object = match store.head(path).await {
        Err(object_store::Error::NotFound { .. }) => return Ok(false),
        object => object?,
    };
    if !is_older(&object, older_than) {
        return Ok(false);
    }
    match store.delete(path).await {
        Ok(()) => Ok(true),
        Err(object_store::Error::NotFound { .. }) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn is_older(object: &ObjectMeta, age: Duration) -> bool {
    let put_at_us = object.last_modified.timestamp_micros();
    let age_us = Timestamp::now().as_microsecond().saturating_sub(put_at_us);
    u128::try_from(age_us).is_ok_and(|age_us| age_us > age.as_micros())
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;

    use super::*;
    use crate::store::blobs::tests::Fixture;
    use crate::store::file_lock::{FileLock, collection_lock_path};

    const HALF_AN_HOUR: Duration = Duration::from_secs(1800);

    async fn collect(fixture: &Fixture, older_than: Duration) -> u64 {
        let collection = try_collect(fixture, older_than).await;
        assert!(collection.error.is_none(), "{collection:?}");
        collection.removed
    }

    async fn try_collect(fixture: &Fixture, older_than: Duration) -> OrphanCollection {
        let (blobs, catalogue) = (fixture.blobs().clone(), fixture.folder.catalogue.clone());
        // A task of its own, as the service runs it.
        tokio::spawn(async move { collect_orphans(&blobs, older_than, &catalogue).await.unwrap() })
            .await
            .unwrap()
    }

    #[tokio::test]
    async fn only_old_blobs_that_no_row_names_are_collected() {
        let fixture = Fixture::new().await;
        let [used, orphan, young] = ["used", "orphan", "young"].map(Bytes::from);
        let used = fixture.blobs().put(used).await.unwrap();
        let orphan = fixture.blobs().put(orphan).await.unwrap();
        let young = fixture.blobs().put(young).await.unwrap();
        fixture.refer_to(used).await;
        fixture.age(used);
        fixture.age(orphan);
        let foreign = fixture.directory.path().join("blobs/README");
        std::fs::write(&foreign, "not ours").unwrap();

        assert_eq!(collect(&fixture, Duration::from_secs(7200)).await, 0);
        assert_eq!(collect(&fixture, HALF_AN_HOUR).await, 1);
        assert!(fixture.holds(used).await);
        assert!(!fixture.holds(orphan).await);
        assert!(fixture.holds(young).await);
        assert!(foreign.exists());
        fixture.blobs().ping().await.unwrap();
    }

    #[cfg(unix)]
    #[tokio::test]
    async fn an_orphan_that_cannot_be_removed_does_not_keep_the_others() {
        let fixture = Fixture::new().await;
        let mut orphans = Vec::new();
        for number in 0..8 {
            let name = fixture.blobs().put(format!("orphan {number}").into()).await.unwrap();
            fixture.age(name);
            orphans.push(name);
        }
        // A name that can't even be looked at, whoever asks.
        let stuck = fixture.file(orphans[0]);
        let content = std::fs::read(&stuck).unwrap();
        std::fs::remove_file(&stuck).unwrap();
        std::os::unix::fs::symlink("/proc/self/mem/nowhere", &stuck).unwrap();
        let collected = try_collect(&fixture, HALF_AN_HOUR).await;
        assert_eq!((collected.removed, collected.failed), (7, 1), "{collected:?}");
        std::fs::remove_file(&stuck).unwrap();
        std::fs::write(&stuck, content).unwrap();
        fixture.age(orphans[0]);
        assert_eq!(collect(&fixture, HALF_AN_HOUR).await, 1);
    }

    #[tokio::test]
    async fn nothing_is_collected_while_the_blobs_are_copied() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("orphan".into()).await.unwrap();
        fixture.age(name);
        let copying = FileLock::shared(&collection_lock_path(fixture.directory.path())).unwrap();
        assert_eq!(collect(&fixture, HALF_AN_HOUR).await, 0);
        drop(copying);
        assert_eq!(collect(&fixture, HALF_AN_HOUR).await, 1);
    }

    #[tokio::test]
    async fn an_old_orphan_that_is_put_again_is_young_again() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("picture".into()).await.unwrap();
        fixture.age(name);
        fixture.blobs().put("picture".into()).await.unwrap();
        // One file: of a write that was put over another nothing is left beside it.
        assert_eq!(std::fs::read_dir(fixture.file(name).parent().unwrap()).unwrap().count(), 1);
        assert_eq!(collect(&fixture, HALF_AN_HOUR).await, 0);
        // As the collector would find it that had looked at the age before the blob was put again.
        assert!(!delete_if_older(&*fixture.blobs().store, &name.path(), HALF_AN_HOUR).await.unwrap());
        fixture.age(name);
        assert!(delete_if_older(&*fixture.blobs().store, &name.path(), HALF_AN_HOUR).await.unwrap());
    }
}
