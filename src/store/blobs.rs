//! Bytes named by their content: exemplar images and version artifacts.
//!
//! A name is the BLAKE3 hash of the bytes, 64 lower-case hexadecimal digits; `abcdef…` is stored as
//! `ab/abcdef…`. So a blob is never changed, writing one twice is one blob, and reading one proves it.
//! A path is only ever made from such a name, never from anything a client sent.

use std::collections::HashSet;
use std::fmt;
use std::io;
use std::path::{Path as FilePath, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt;
use jiff::Timestamp;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{GetResult, ObjectMeta, ObjectStore, ObjectStoreExt};
use tokio::sync::RwLock;
use uuid::Uuid;

use super::bucket;
use super::cache::Cache;
use super::catalogue::{Catalogue, CatalogueError};
use super::folder::FolderLock;

/// An object beside the blobs whose presence shows that the store is there and is ours.
const MARKER: &str = "landmarkd-blobs";
const MARKER_WORDS: &[u8] = b"blobs of landmarkd, named by content\n";
/// Where a bucket's orphans wait before they are deleted.
const ASIDE: &str = "set-aside";
/// Blobs that the catalogue is asked about at once: some 70 kB of names.
const ASKED_AT_ONCE: usize = 1000;

/// The name of a blob: the BLAKE3 hash of its content.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlobName([u8; 32]);

impl BlobName {
    /// Names a content.
    pub fn of(content: &[u8]) -> Self {
        Self(*blake3::hash(content).as_bytes())
    }

    /// The hash itself.
    pub const fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }

    fn path(&self) -> Path {
        let digits = self.to_string();
        Path::from_iter([&digits[..2], digits.as_str()])
    }

    fn path_aside(&self) -> Path {
        Path::from_iter([ASIDE, self.to_string().as_str()])
    }

    /// The name of a stored object; none for anything that isn't a blob.
    fn at(path: &Path) -> Option<Self> {
        let name: Self = path.filename()?.parse().ok()?;
        (name.path() == *path || name.path_aside() == *path).then_some(name)
    }
}

impl fmt::Display for BlobName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

impl fmt::Debug for BlobName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "BlobName({self})")
    }
}

impl FromStr for BlobName {
    type Err = BlobError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let invalid = || BlobError::InvalidName { text: text.to_owned() };
        let mut name = [0; 32];
        let (pairs, []) = text.as_bytes().as_chunks::<2>() else { return Err(invalid()) };
        if pairs.len() != name.len() {
            return Err(invalid());
        }
        for (byte, &[high, low]) in name.iter_mut().zip(pairs) {
            *byte = digit(high).zip(digit(low)).map(|(high, low)| high << 4 | low).ok_or_else(invalid)?;
        }
        Ok(Self(name))
    }
}

fn digit(character: u8) -> Option<u8> {
    match character {
        b'0'..=b'9' => Some(character - b'0'),
        b'a'..=b'f' => Some(character - b'a' + 10),
        _ => None,
    }
}

/// What a call on the blobs can fail with.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// The store can't be reached or can't write now (away, no rights, disk full); it may heal by itself.
    #[error("the blob store is unavailable")]
    Unavailable {
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The text is no blob name.
    #[error("{text:?} is no blob name: 64 lower-case hexadecimal digits are")]
    InvalidName { text: String },
    /// There is no such blob.
    #[error("blob {name} does not exist")]
    NotFound { name: BlobName },
    /// The blob is larger than the caller would take; nothing was read.
    #[error("blob {name} has {bytes} bytes, more than the {max_bytes} allowed")]
    TooLarge { name: BlobName, bytes: u64, max_bytes: u64 },
    /// The bytes that stand under the name aren't the ones that were put there.
    #[error("blob {name} is corrupt: its content hashes to {found}")]
    Corrupt { name: BlobName, found: BlobName },
    /// The blob was corrupt when it was read before, and was set aside.
    #[error("blob {name} was corrupt; what is left of it stands in the data folder's quarantine")]
    Quarantined { name: BlobName },
    /// Collecting orphans needs the catalogue, and it failed.
    #[error("the catalogue cannot say which blobs are in use")]
    Catalogue {
        #[source]
        source: CatalogueError,
    },
}

impl BlobError {
    /// True when the content is lost: the same put again mends it, nothing else does. For a caller that allowed as
    /// many bytes as were put, a larger blob is damaged too.
    pub fn is_damage(&self) -> bool {
        matches!(
            self,
            Self::NotFound { .. } | Self::Corrupt { .. } | Self::Quarantined { .. } | Self::TooLarge { .. }
        )
    }
}

impl From<object_store::Error> for BlobError {
    fn from(error: object_store::Error) -> Self {
        Self::Unavailable { source: error.into() }
    }
}

impl From<io::Error> for BlobError {
    fn from(error: io::Error) -> Self {
        Self::Unavailable { source: error.into() }
    }
}

/// The blobs of a store; copies share it.
#[derive(Debug, Clone)]
pub struct Blobs {
    store: Arc<dyn ObjectStore>,
    place: Arc<Place>,
}

/// What came of a look for orphans.
#[derive(Debug, Default)]
pub struct Collected {
    pub removed: u64,
    /// Objects that couldn't be looked at or removed; the next look finds them again.
    pub failed: u64,
    /// Why the first of them couldn't.
    pub error: Option<BlobError>,
}

impl Collected {
    fn note(&mut self, removed: Result<bool, BlobError>) {
        match removed {
            Ok(is_removed) => self.removed += u64::from(is_removed),
            Err(error) => {
                self.failed += 1;
                self.error.get_or_insert(error);
            }
        }
    }
}

/// Where the blobs are, and what that asks for.
#[derive(Debug)]
enum Place {
    Folder {
        /// Where blobs are set aside that aren't what their names say.
        quarantine: PathBuf,
        /// Shared by those who put, held alone by whoever takes a blob away: the collector while it looks at an
        /// orphan's age and deletes it, a reader while it sets a corrupt blob aside.
        collection: RwLock<()>,
        /// None where another process may be serving the folder: then nothing is taken away.
        lock: Option<Arc<FolderLock>>,
    },
    Bucket {
        cache: Cache,
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
        lock: Arc<FolderLock>,
    ) -> Result<Self, BlobError> {
        if new {
            std::fs::create_dir_all(folder)?;
        }
        let blobs = Self::over(folder, Some(lock))?;
        if new {
            blobs.mark(Bytes::from_static(MARKER_WORDS)).await?;
        }
        blobs.ping().await?;
        remove_unfinished(folder)?;
        Ok(blobs)
    }

    /// Opens the blobs in a folder that another process may be serving.
    pub(super) async fn beside(folder: &FilePath) -> Result<Self, BlobError> {
        let blobs = Self::over(folder, None)?;
        blobs.ping().await?;
        Ok(blobs)
    }

    fn over(folder: &FilePath, lock: Option<Arc<FolderLock>>) -> Result<Self, BlobError> {
        let store = LocalFileSystem::new_with_prefix(folder)?.with_fsync(true);
        let quarantine = folder.with_file_name("quarantine");
        let place = Place::Folder { quarantine, collection: RwLock::default(), lock };
        Ok(Self { store: Arc::new(store), place: Arc::new(place) })
    }

    /// Opens the blobs in a bucket, which other processes of the same catalogue may use and open too; `None` if it
    /// is marked with another catalogue, whose blobs would be orphans here.
    pub(super) async fn in_bucket(
        store: Arc<dyn ObjectStore>,
        cache: Cache,
        catalogue: Uuid,
    ) -> object_store::Result<Option<Self>> {
        let blobs = Self { store, place: Arc::new(Place::Bucket { cache }) };
        let words = [MARKER_WORDS, format!("catalogue {catalogue}\n").as_bytes()].concat();
        let found = match blobs.store.get(&Path::from(MARKER)).await {
            Err(object_store::Error::NotFound { .. }) => {
                blobs.mark(words.clone().into()).await?;
                // Whoever marked it at the same moment has it.
                blobs.store.get(&Path::from(MARKER)).await?
            }
            found => found?,
        };
        Ok((found.bytes().await? == words).then_some(blobs))
    }

    /// Says whose the store is; saying it twice is no harm.
    async fn mark(&self, words: Bytes) -> object_store::Result<()> {
        self.store.put(&Path::from(MARKER), words.into()).await?;
        Ok(())
    }

    /// Succeeds when the store is there.
    pub async fn ping(&self) -> Result<(), BlobError> {
        self.store.head(&Path::from(MARKER)).await?;
        Ok(())
    }

    /// Stores a content durably and names it; one that is already there is a success.
    ///
    /// It is always written: that renews the age of a blob, so that the collector leaves it alone until its row is
    /// written, and mends it if it was damaged.
    pub async fn put(&self, content: Bytes) -> Result<BlobName, BlobError> {
        let name = name_of(content.clone()).await?;
        match &*self.place {
            Place::Folder { collection, .. } => {
                let _not_collecting = collection.read().await;
                // A folder whose disk went away would take writes, and lose them when the disk comes back.
                self.ping().await?;
                self.store.put(&name.path(), content.into()).await?;
            }
            Place::Bucket { .. } => bucket::upload(&*self.store, &name.path(), content).await?,
        }
        Ok(name)
    }

    /// Reads a blob and proves its content. Errors: `NotFound`, `TooLarge`, `Corrupt`.
    ///
    /// What was read from a bucket before may come from this machine's cache, without a request.
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

    async fn fetch(&self, name: &BlobName, max_bytes: u64) -> Result<Bytes, BlobError> {
        let found = self.open(name).await?;
        let bytes = found.meta.size;
        if bytes > max_bytes {
            return Err(BlobError::TooLarge { name: *name, bytes, max_bytes });
        }
        let content = found.bytes().await?;
        let found = name_of(content.clone()).await?;
        if found == *name {
            return Ok(content);
        }
        // A task of its own: who stops waiting for it must not let others put while the file is being moved.
        let (blobs, corrupt) = (self.clone(), *name);
        drop(tokio::spawn(async move { blobs.set_apart(&corrupt).await }).await);
        Err(BlobError::Corrupt { name: *name, found })
    }

    /// Takes a corrupt blob out of the way, for an operator to look at. In a bucket it stays: there nobody can be kept
    /// from putting it again at the same moment.
    async fn set_apart(&self, name: &BlobName) {
        let Place::Folder { quarantine, collection, lock: Some(_) } = &*self.place else { return };
        let _nobody_puts = collection.write().await;
        // Once more, alone: it may have been put again since.
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
        // Where it can't be moved it stays, and is refused each time it is read.
        drop(moved.await);
    }

    fn is_set_apart(&self, name: &BlobName) -> bool {
        match &*self.place {
            Place::Folder { quarantine, .. } => quarantine.join(name.to_string()).exists(),
            Place::Bucket { .. } => false,
        }
    }

    async fn open(&self, name: &BlobName) -> Result<GetResult, BlobError> {
        for path in [name.path(), name.path_aside()] {
            match self.store.get(&path).await {
                Err(object_store::Error::NotFound { .. }) => {}
                other => return Ok(other?),
            }
        }
        // Nothing is there when the whole store is away.
        self.ping().await?;
        if self.is_set_apart(name) {
            return Err(BlobError::Quarantined { name: *name });
        }
        Err(BlobError::NotFound { name: *name })
    }

    /// Deletes the blobs that no row names and that were put longer ago than `older_than`.
    ///
    /// `older_than` must exceed the time that a request or a job may take between putting a blob and writing its
    /// row. Whatever else stands in the store is left alone. What fails doesn't keep the others from being collected.
    /// Does nothing while another process collects. Errors: `Catalogue`; what was deleted until then was rightly
    /// deleted.
    ///
    /// In a bucket another process may put an orphan again between a look at its age and its deletion; S3 has no
    /// deletion that asks for the age. An orphan is therefore set aside first, where it is still read, and deleted
    /// from there if no row names it after `older_than` once more. One that a row names by then stays there.
    pub async fn collect_orphans(
        &self,
        older_than: Duration,
        catalogue: &dyn Catalogue,
    ) -> Result<Collected, BlobError> {
        let away = |source| BlobError::Catalogue { source };
        let mut collected = Collected::default();
        let Some(_turn) = catalogue.turn_to_collect().await.map_err(away)? else { return Ok(collected) };
        // By the beginnings of names: a listing ends where it fails, and the others go on.
        for beginning in self.store.list_with_delimiter(None).await?.common_prefixes {
            let mut batches = self.store.list(Some(&beginning)).chunks(ASKED_AT_ONCE);
            while let Some(batch) = batches.next().await {
                self.collect_among(batch, older_than, catalogue, &mut collected).await?;
            }
        }
        Ok(collected)
    }

    async fn collect_among(
        &self,
        batch: Vec<object_store::Result<ObjectMeta>>,
        older_than: Duration,
        catalogue: &dyn Catalogue,
        collected: &mut Collected,
    ) -> Result<(), BlobError> {
        let mut old = Vec::new();
        for object in batch {
            match object {
                Ok(object) if is_older(&object, older_than) => {
                    old.extend(BlobName::at(&object.location).map(|name| (name, object.location)));
                }
                Ok(_) => {}
                Err(error) => collected.note(Err(error.into())),
            }
        }
        if old.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = old.iter().map(|(name, _)| name.to_string()).collect();
        let named = catalogue.blobs_referenced(&names).await;
        let named: HashSet<String> =
            named.map_err(|source| BlobError::Catalogue { source })?.into_iter().collect();
        for (name, path) in old {
            if !named.contains(&name.to_string()) {
                // A task of its own, as in `fetch`.
                let blobs = self.clone();
                let removing = async move { blobs.remove_orphan(&name, &path, older_than).await };
                let removed = tokio::spawn(removing).await;
                let died =
                    |error: tokio::task::JoinError| Err(BlobError::Unavailable { source: error.into() });
                collected.note(removed.unwrap_or_else(died));
            }
        }
        Ok(())
    }

    async fn remove_orphan(
        &self,
        name: &BlobName,
        path: &Path,
        older_than: Duration,
    ) -> Result<bool, BlobError> {
        match &*self.place {
            Place::Folder { collection, .. } => {
                // Looks at the age once more with everybody who puts kept out: one put again meanwhile stays.
                let _collecting = collection.write().await;
                self.delete_if_older(path, older_than).await
            }
            Place::Bucket { .. } if *path == name.path() => {
                self.set_aside(name, older_than).await?;
                Ok(false)
            }
            Place::Bucket { .. } => self.delete_if_older(path, older_than).await,
        }
    }

    /// Copies an orphan to where nobody puts, and only then deletes it; the copy is young.
    async fn set_aside(&self, name: &BlobName, older_than: Duration) -> Result<(), BlobError> {
        match self.store.copy(&name.path(), &name.path_aside()).await {
            // Another process was first.
            Err(object_store::Error::NotFound { .. }) => return Ok(()),
            copied => copied?,
        }
        self.delete_if_older(&name.path(), older_than).await?;
        Ok(())
    }

    async fn delete_if_older(&self, path: &Path, older_than: Duration) -> Result<bool, BlobError> {
        let object = match self.store.head(path).await {
            Err(object_store::Error::NotFound { .. }) => return Ok(false),
            object => object?,
        };
        if !is_older(&object, older_than) {
            return Ok(false);
        }
        match self.store.delete(path).await {
            Ok(()) => Ok(true),
            Err(object_store::Error::NotFound { .. }) => Ok(false),
            Err(error) => Err(error.into()),
        }
    }
}

fn is_older(object: &ObjectMeta, age: Duration) -> bool {
    let put_at_us = object.last_modified.timestamp_micros();
    let age_us = Timestamp::now().as_microsecond().saturating_sub(put_at_us);
    u128::try_from(age_us).is_ok_and(|age_us| age_us > age.as_micros())
}

/// Hashes off the async threads: an artifact may have hundreds of megabytes.
async fn name_of(content: Bytes) -> Result<BlobName, BlobError> {
    tokio::task::spawn_blocking(move || BlobName::of(&content))
        .await
        .map_err(|error| BlobError::Unavailable { source: error.into() })
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
mod tests {
    use super::*;
    use crate::store::folder::CollectionLock;
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

    struct Fixture {
        directory: tempfile::TempDir,
        folder: Folder,
    }

    impl Fixture {
        async fn new() -> Self {
            let directory = tempfile::tempdir().unwrap();
            let folder = open_folder(directory.path()).await.unwrap();
            Self { directory, folder }
        }

        fn blobs(&self) -> &Blobs {
            &self.folder.blobs
        }

        fn file(&self, name: BlobName) -> PathBuf {
            file_in(self.directory.path(), name)
        }

        async fn holds(&self, name: BlobName) -> bool {
            self.blobs().get(&name, 100).await.is_ok()
        }

        /// Makes a blob look as if it had been put an hour ago.
        fn age(&self, name: BlobName) {
            let file = std::fs::File::options().append(true).open(self.file(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(3600)).unwrap();
        }

        async fn collect(&self, older_than: Duration) -> u64 {
            let collected = self.try_collect(older_than).await;
            assert!(collected.error.is_none(), "{collected:?}");
            collected.removed
        }

        async fn try_collect(&self, older_than: Duration) -> Collected {
            let (blobs, catalogue) = (self.blobs().clone(), self.folder.catalogue.clone());
            // A task of its own, as the service runs it.
            tokio::spawn(async move { blobs.collect_orphans(older_than, &*catalogue).await.unwrap() })
                .await
                .unwrap()
        }

        async fn refer_to(&self, blob: BlobName) {
            self.folder.catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
            let row = ExemplarRow {
                database: "lab".to_owned(),
                id: uuid::Uuid::from_u128(1),
                label: "kitchen".to_owned(),
                pose_deg: None,
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

    const HALF_AN_HOUR: Duration = Duration::from_secs(1800);

    #[test]
    fn only_sixty_four_lower_case_hexadecimal_digits_are_a_name() {
        let name = BlobName::of(b"picture");
        assert_eq!(name.to_string().parse::<BlobName>().unwrap(), name);
        assert_eq!(name.to_string(), blake3::hash(b"picture").to_hex().as_str());
        let digits = name.to_string();
        let wrong = [
            String::new(),
            digits[..63].to_owned(),
            digits[..62].to_owned(),
            format!("{digits}0"),
            format!("{digits}00"),
            digits.to_uppercase(),
            format!("{}g", &digits[..63]),
            format!("{}é", &digits[..62]),
            format!("../{}", &digits[3..]),
            format!("{}/{}", &digits[..2], &digits[3..]),
            format!(" {}", &digits[1..]),
        ];
        for text in wrong {
            let refused = text.parse::<BlobName>().unwrap_err();
            assert!(
                matches!(&refused, BlobError::InvalidName { text: named } if *named == text),
                "{refused:?}"
            );
        }
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

        assert_eq!(fixture.collect(Duration::from_secs(7200)).await, 0);
        assert_eq!(fixture.collect(HALF_AN_HOUR).await, 1);
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
        let collected = fixture.try_collect(HALF_AN_HOUR).await;
        assert_eq!((collected.removed, collected.failed), (7, 1), "{collected:?}");
        std::fs::remove_file(&stuck).unwrap();
        std::fs::write(&stuck, content).unwrap();
        fixture.age(orphans[0]);
        assert_eq!(fixture.collect(HALF_AN_HOUR).await, 1);
    }

    #[tokio::test]
    async fn nothing_is_collected_while_the_blobs_are_copied() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("orphan".into()).await.unwrap();
        fixture.age(name);
        let copying = CollectionLock::shared(fixture.directory.path()).unwrap();
        assert_eq!(fixture.collect(HALF_AN_HOUR).await, 0);
        drop(copying);
        assert_eq!(fixture.collect(HALF_AN_HOUR).await, 1);
    }

    #[tokio::test]
    async fn a_corrupt_blob_is_set_apart_and_not_read_again() {
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
        let beside = crate::store::open_beside(fixture.directory.path()).await.unwrap();
        assert!(matches!(beside.blobs.get(&name, 7).await, Err(BlobError::Corrupt { .. })));
        assert!(fixture.file(name).exists());
    }

    #[tokio::test]
    async fn an_old_orphan_that_is_put_again_is_young_again() {
        let fixture = Fixture::new().await;
        let name = fixture.blobs().put("picture".into()).await.unwrap();
        fixture.age(name);
        fixture.blobs().put("picture".into()).await.unwrap();
        // One file: of a write that was put over another nothing is left beside it.
        assert_eq!(std::fs::read_dir(fixture.file(name).parent().unwrap()).unwrap().count(), 1);
        assert_eq!(fixture.collect(HALF_AN_HOUR).await, 0);
        // As the collector would find it that had looked at the age before the blob was put again.
        assert!(!fixture.blobs().delete_if_older(&name.path(), HALF_AN_HOUR).await.unwrap());
        fixture.age(name);
        assert!(fixture.blobs().delete_if_older(&name.path(), HALF_AN_HOUR).await.unwrap());
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
