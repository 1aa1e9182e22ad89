//! Bytes named by their content: exemplar images and version artifacts.
//!
//! A name is the BLAKE3 hash of the bytes, 64 lower-case hexadecimal digits; `abcdef…` is stored as
//! `ab/abcdef…`. So a blob is never changed, writing one twice is one blob, and reading one proves it.
//! A path is only ever made from such a name, never from anything a client sent.

use std::io;
use std::ops::Range;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{GetOptions, GetResult, ObjectMeta, ObjectStore, ObjectStoreExt};
use tokio::sync::RwLock;
use uuid::Uuid;

use super::blob_error::BlobError;
use super::blob_name::BlobName;
use super::cache::Cache;
use super::file_lock::FileLock;
use super::upload::upload;

/// An object beside the blobs whose presence shows that the store is there and is ours.
const MARKER: &str = "landmarkd-blobs";
const MARKER_WORDS: &[u8] = b"blobs of landmarkd, named by content\n";

/// The blobs of a store; copies share it.
#[derive(Debug, Clone)]
pub struct Blobs {
    pub(super) store: Arc<dyn ObjectStore>,
    pub(super) place: Arc<Place>,
}

/// Where the blobs are, with what that needs.
#[derive(Debug)]
pub(super) enum Place {
    /// A folder of this machine.
    Folder {
        /// The folder for blobs whose content isn't what their names say.
        quarantine: PathBuf,
        /// Shared by those who put a blob; exclusive for whoever removes one: the collector of orphans while it checks
        /// an orphan's age and deletes it, a reader while it moves a corrupt blob into the quarantine.
        writes: RwLock<()>,
        /// None where another process may be serving the folder: then no blob is removed.
        lock: Option<Arc<FileLock>>,
    },
    /// A bucket that several processes share.
    Bucket {
        /// Blobs that were read before, on this machine.
        cache: Cache<BlobName>,
    },
}

impl Blobs {
    /// Opens the blobs in a folder; what is put there is synced to the disk. A `new` store is created; one that
    /// should be there and isn't is `Unavailable`: its disk is not mounted.
    ///
    /// The lock of the data folder is kept as long as the blobs live.
    pub(super) async fn in_folder(
        folder: &FilePath,
        new: bool,
        lock: Arc<FileLock>,
    ) -> Result<Self, BlobError> {
        if new {
            std::fs::create_dir_all(folder)?;
        }
        let blobs = Self::new_in(folder, Some(lock))?;
        if new {
            blobs.mark(Bytes::from_static(MARKER_WORDS)).await?;
        }
        blobs.ping().await?;
        remove_unfinished(folder)?;
        Ok(blobs)
    }

    /// Opens the blobs in a folder that another process may be serving.
    pub(super) async fn in_unlocked_folder(folder: &FilePath) -> Result<Self, BlobError> {
        let blobs = Self::new_in(folder, None)?;
        blobs.ping().await?;
        Ok(blobs)
    }

    fn new_in(folder: &FilePath, lock: Option<Arc<FileLock>>) -> Result<Self, BlobError> {
        let store = LocalFileSystem::new_with_prefix(folder)?.with_fsync(true);
        let quarantine = folder.with_file_name("quarantine");
        let place = Place::Folder { quarantine, writes: RwLock::default(), lock };
        Ok(Self { store: Arc::new(store), place: Arc::new(place) })
    }

    /// Opens the blobs in a bucket, which other processes of the same catalogue may use and open too; `None` if it
    /// is marked with another catalogue, whose blobs would be orphans here.
    pub(super) async fn in_bucket(
        store: Arc<dyn ObjectStore>,
        cache: Cache<BlobName>,
        catalogue: Uuid,
    ) -> object_store::Result<Option<Self>> {
        let blobs = Self { store, place: Arc::new(Place::Bucket { cache }) };
        let words = [MARKER_WORDS, format!("catalogue {catalogue}\n").as_bytes()].concat();
        let found = match blobs.store.get(&Path::from(MARKER)).await {
            Err(object_store::Error::NotFound { .. }) => {
                blobs.mark(words.clone().into()).await?;
                // Another process may have marked it at the same moment, and the last one has it.
                blobs.store.get(&Path::from(MARKER)).await?
            }
            found => found?,
        };
        Ok((found.bytes().await? == words).then_some(blobs))
    }

    /// Writes the marker, which says whose the store is.
    async fn mark(&self, words: Bytes) -> object_store::Result<()> {
        self.store.put(&Path::from(MARKER), words.into()).await?;
        Ok(())
    }

    /// Succeeds when the store is there.
    ///
    /// # Errors
    /// `Unavailable`.
    pub async fn ping(&self) -> Result<(), BlobError> {
        self.store.head(&Path::from(MARKER)).await?;
        Ok(())
    }

    /// Stores a content durably and names it; one that is already there is a success.
    ///
    /// It is always written: that renews the age of a blob, so that the collector leaves it alone until its row is
    /// written, and mends it if it was damaged.
    ///
    /// # Errors
    /// `Unavailable`.
    pub async fn put(&self, content: Bytes) -> Result<BlobName, BlobError> {
        let name = hash(content.clone()).await?;
        match &*self.place {
            Place::Folder { writes, .. } => {
                let _writing = writes.read().await;
                // A folder whose disk is not mounted takes writes, and hides them when the disk is mounted again.
                self.ping().await?;
                self.store.put(&name.path(), content.into()).await?;
            }
            Place::Bucket { .. } => upload(&*self.store, &name.path(), content).await?,
        }
        Ok(name)
    }

    /// Reads a blob and proves its content.
    ///
    /// What was read from a bucket before may come from this machine's cache, without a request.
    ///
    /// # Errors
    /// `NotFound`, `TooLarge`, `Corrupt`, `Quarantined`, `Unavailable`.
    pub async fn get(&self, name: &BlobName, max_bytes: u64) -> Result<Bytes, BlobError> {
        let Place::Bucket { cache } = &*self.place else { return self.fetch(name, max_bytes).await };
        if let Some(content) = cache.get(*name).await {
            let bytes = content.len() as u64;
            if bytes > max_bytes {
                return Err(BlobError::TooLarge { name: *name, bytes, max_bytes });
            }
            return Ok(content);
        }
        let content = self.fetch(name, max_bytes).await?;
        cache.keep(*name, content.clone()).await;
        Ok(content)
    }

    /// Reads a blob from the store and proves its content.
    async fn fetch(&self, name: &BlobName, max_bytes: u64) -> Result<Bytes, BlobError> {
        let found = self.open(name).await?;
        let bytes = found.meta.size;
        if bytes > max_bytes {
            return Err(BlobError::TooLarge { name: *name, bytes, max_bytes });
        }
        let content = found.bytes().await?;
        let found = hash(content.clone()).await?;
        if found == *name {
            return Ok(content);
        }
        // A task of its own: a caller that goes away must not end the move while it excludes writers.
        let (blobs, corrupt) = (self.clone(), *name);
        drop(tokio::spawn(async move { blobs.quarantine(&corrupt).await }).await);
        Err(BlobError::Corrupt { name: *name, found })
    }

    /// The size of a blob.
    ///
    /// # Errors
    /// `NotFound`, `Quarantined`, `Unavailable`.
    pub async fn size(&self, name: &BlobName) -> Result<u64, BlobError> {
        Ok(self.locate(name).await?.size)
    }

    /// Reads ranges of a blob. What is read is not proved.
    ///
    /// # Errors
    /// `NotFound`, `Quarantined`, `Unavailable`.
    pub async fn ranges(&self, name: &BlobName, ranges: &[Range<u64>]) -> Result<Vec<Bytes>, BlobError> {
        match self.store.get_ranges(&name.path(), ranges).await {
            Err(object_store::Error::NotFound { .. }) => {
                let path = self.locate(name).await?.location;
                Ok(self.store.get_ranges(&path, ranges).await?)
            }
            other => Ok(other?),
        }
    }

    /// Reads parts of a blob that have names of their own, and proves them by those.
    ///
    /// Those that were read from a bucket before may come from this machine's cache, without a request.
    ///
    /// # Errors
    /// `NotFound`, `Corrupt`, `Quarantined`, `Unavailable`.
    pub async fn parts(
        &self,
        blob: &BlobName,
        parts: Vec<(BlobName, Range<u64>)>,
    ) -> Result<Vec<Bytes>, BlobError> {
        let mut found = vec![None; parts.len()];
        if let Place::Bucket { cache } = &*self.place {
            for (found, (name, _)) in found.iter_mut().zip(&parts) {
                *found = cache.get(*name).await;
            }
        }
        let missing: Vec<usize> = (0..parts.len()).filter(|&at| found[at].is_none()).collect();
        let ranges: Vec<Range<u64>> = missing.iter().map(|&at| parts[at].1.clone()).collect();
        let read = match ranges.is_empty() {
            true => Vec::new(),
            false => self.ranges(blob, &ranges).await?,
        };
        // several may lie in one buffer, which none of them is to keep alive
        let prove =
            move || read.iter().map(|part| (BlobName::of(part), Bytes::copy_from_slice(part))).collect();
        let proved: Vec<(BlobName, Bytes)> = off_the_async_threads(prove).await?;
        for (at, (hash, content)) in missing.into_iter().zip(proved) {
            if hash != parts[at].0 {
                return Err(BlobError::Corrupt { name: *blob, found: hash });
            }
            if let Place::Bucket { cache } = &*self.place {
                cache.keep(hash, content.clone()).await;
            }
            found[at] = Some(content);
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// Moves a corrupt blob into the quarantine, for an operator to inspect. In a bucket it stays: there another process
    /// can't be kept from putting it again at the same moment.
    async fn quarantine(&self, name: &BlobName) {
        let Place::Folder { quarantine, writes, lock: Some(_) } = &*self.place else { return };
        let _no_writes = writes.write().await;
        // Reads it once more: it may have been put again since.
        let Ok(read) = self.store.get(&name.path()).await else { return };
        let Ok(content) = read.bytes().await else { return };
        let name = *name;
        let (quarantine, from) = (quarantine.clone(), quarantine.with_file_name("blobs"));
        let from = from.join(name.path().as_ref());
        let moved = tokio::task::spawn_blocking(move || {
            if BlobName::of(&content) == name {
                return Ok(());
            }
            std::fs::create_dir_all(&quarantine)?;
            std::fs::rename(from, quarantine.join(name.to_string()))
        });
        // A blob that can't be moved stays, and is refused each time it is read.
        drop(moved.await);
    }

    /// Whether the blob was moved into the quarantine.
    fn is_quarantined(&self, name: &BlobName) -> bool {
        match &*self.place {
            Place::Folder { quarantine, .. } => quarantine.join(name.to_string()).exists(),
            Place::Bucket { .. } => false,
        }
    }

    /// Begins to read a blob, wherever it stands.
    async fn open(&self, name: &BlobName) -> Result<GetResult, BlobError> {
        self.found(name, GetOptions::default()).await
    }

    /// Where a blob stands, and its size.
    async fn locate(&self, name: &BlobName) -> Result<ObjectMeta, BlobError> {
        Ok(self.found(name, GetOptions { head: true, ..GetOptions::default() }).await?.meta)
    }

    async fn found(&self, name: &BlobName, wanted: GetOptions) -> Result<GetResult, BlobError> {
        for path in [name.path(), name.path_aside()] {
            match self.store.get_opts(&path, wanted.clone()).await {
                Err(object_store::Error::NotFound { .. }) => {}
                other => return Ok(other?),
            }
        }
        Err(self.missing(name).await)
    }

    /// Why a blob stands nowhere.
    async fn missing(&self, name: &BlobName) -> BlobError {
        // Nothing is there when the whole store is away.
        match self.ping().await {
            Err(error) => error,
            Ok(()) if self.is_quarantined(name) => BlobError::Quarantined { name: *name },
            Ok(()) => BlobError::NotFound { name: *name },
        }
    }
}

/// Hashes off the async threads: an artifact may have hundreds of megabytes.
async fn hash(content: Bytes) -> Result<BlobName, BlobError> {
    off_the_async_threads(move || BlobName::of(&content)).await
}

async fn off_the_async_threads<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, BlobError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.map_err(|error| BlobError::Unavailable { source: error.into() })
}

/// Removes what a crash left of unfinished writes: files `<name>#<number>`, which the store never lists.
fn remove_unfinished(folder: &FilePath) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            remove_unfinished(&entry.path())?;
        } else if entry.file_name().to_string_lossy().contains('#') {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use std::time::Duration;

    use jiff::Timestamp;

    use super::*;
    use crate::store::suite::blobs::{Opened, blob_suite};
    use crate::store::suite::by;
    use crate::store::{ExemplarRow, Folder, open_folder};

    async fn folder() -> (Opened, Fixture) {
        let fixture = Fixture::new().await;
        let blobs = fixture.blobs().clone();
        let directory = fixture.directory.path().to_owned();
        let damage = Box::new(move |name, content: &[u8]| {
            std::fs::write(file_in(&directory, name), content).unwrap();
        });
        (Opened { twin: blobs.clone(), blobs, damage }, fixture)
    }

    mod a_folder_keeps_every_promise {
        use super::{blob_suite, folder};

        blob_suite!(folder, cfg(test));
    }

    fn file_in(data_dir: &FilePath, name: BlobName) -> PathBuf {
        let digits = name.to_string();
        data_dir.join("blobs").join(&digits[..2]).join(digits)
    }

    pub(in crate::store) struct Fixture {
        pub directory: tempfile::TempDir,
        pub folder: Folder,
    }

    impl Fixture {
        pub async fn new() -> Self {
            let directory = tempfile::tempdir().unwrap();
            let folder = open_folder(directory.path()).await.unwrap();
            Self { directory, folder }
        }

        pub fn blobs(&self) -> &Blobs {
            &self.folder.blobs
        }

        pub fn file(&self, name: BlobName) -> PathBuf {
            file_in(self.directory.path(), name)
        }

        pub async fn holds(&self, name: BlobName) -> bool {
            self.blobs().get(&name, 100).await.is_ok()
        }

        /// Makes a blob look as if it had been put an hour ago.
        pub fn age(&self, name: BlobName) {
            let file = std::fs::File::options().append(true).open(self.file(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
        }

        pub async fn refer_to(&self, blob: BlobName) {
            self.folder.catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
            let row = ExemplarRow {
                database: "lab".to_owned(),
                id: uuid::Uuid::from_u128(1),
                label: "kitchen".to_owned(),
                negative: false,
                pose_deg: None,
                survey: None,
                width_px: 1,
                height_px: 1,
                bytes: 1,
                sha256: String::new(),
                blob: blob.to_string(),
                media_type: "image/png".to_owned(),
                robot_id: None,
                frame_id: None,
                stamp: None,
                created_at: Timestamp::UNIX_EPOCH,
            };
            self.folder.catalogue.insert_exemplar(&row).await.unwrap();
        }
    }

    #[tokio::test]
    async fn a_corrupt_blob_is_quarantined_and_not_read_again() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("picture".into()).await.unwrap();
        std::fs::write(fixture.file(name), "pictvre").unwrap();
        let refused = fixture.blobs().get(&name, 7).await.unwrap_err();
        assert!(matches!(refused, BlobError::Corrupt { .. }), "{refused:?}");
        let apart = fixture.directory.path().join("quarantine").join(name.to_string());
        assert_eq!(std::fs::read(&apart).unwrap(), b"pictvre");
        assert!(!fixture.file(name).exists());
        let refused = fixture.blobs().get(&name, 7).await.unwrap_err();
        assert!(matches!(refused, BlobError::Quarantined { .. }), "{refused:?}");
        fixture.blobs().put("picture".into()).await.unwrap();
        assert_eq!(fixture.blobs().get(&name, 7).await.unwrap(), "picture");

        // Whoever looks on beside the process that serves the folder takes nothing away.
        std::fs::write(fixture.file(name), "pictvre").unwrap();
        let beside = crate::store::open_unlocked_folder(fixture.directory.path()).await.unwrap();
        assert!(matches!(beside.blobs.get(&name, 7).await, Err(BlobError::Corrupt { .. })));
        assert!(fixture.file(name).exists());
    }

    #[tokio::test]
    async fn what_a_crash_left_of_a_write_is_removed_on_opening() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("picture".into()).await.unwrap();
        let left = fixture.file(name).with_file_name(format!("{name}#1"));
        std::fs::write(&left, "pict").unwrap();
        let Fixture { directory, folder } = fixture;
        drop(folder);
        let folder = open_folder(directory.path()).await.unwrap();
        assert!(!left.exists());
        assert_eq!(folder.blobs.get(&name, 7).await.unwrap(), "picture");
    }

    #[tokio::test]
    async fn a_store_that_is_away_says_so() {
        let fixture = Fixture::new().await;
        let folder = fixture.directory.path().join("blobs");
        std::fs::rename(&folder, fixture.directory.path().join("elsewhere")).unwrap();
        let away = fixture.blobs().ping().await.unwrap_err();
        assert!(matches!(away, BlobError::Unavailable { .. }), "{away:?}");
        std::fs::rename(fixture.directory.path().join("elsewhere"), &folder).unwrap();
        fixture.blobs().ping().await.unwrap();
    }
}
