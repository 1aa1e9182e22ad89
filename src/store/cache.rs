//! What can be fetched or computed again, kept in a folder of this machine, bounded in bytes, the least recently used
//! out first: blobs of a bucket, descriptions of pictures.
//!
//! A file is named by its key and proved on every reading; one that is damaged is removed, and its content fetched or
//! computed again. A file's time of change is when it was last used, so that the order outlives the process. Without
//! room or rights on the disk nothing is kept. One process at a time uses a folder.

use std::collections::{BTreeMap, HashMap};
use std::fmt::{Debug, Display};
use std::fs::{self, File};
use std::hash::Hash;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use bytes::Bytes;

use super::blob_name::BlobName;

/// What a cached content is known by. Its text is the name of the file: it comes back from it, and has no `#`.
pub(super) trait Key: Copy + Ord + Hash + Debug + Display + FromStr + Send + Sync + 'static {
    /// Whether a file's content is what was kept under this key.
    fn is_proved_by(&self, content: &[u8]) -> bool;
}

impl Key for BlobName {
    fn is_proved_by(&self, content: &[u8]) -> bool {
        Self::of(content) == *self
    }
}

/// The cache; copies share it.
#[derive(Debug)]
pub(super) struct Cache<K> {
    inner: Arc<Inner<K>>,
}

impl<K> Clone for Cache<K> {
    fn clone(&self) -> Self {
        Self { inner: Arc::clone(&self.inner) }
    }
}

#[derive(Debug)]
struct Inner<K> {
    folder: PathBuf,
    limit_bytes: u64,
    index: Mutex<Index<K>>,
    /// Makes the names of unfinished files differ.
    writes: AtomicU64,
    warned: AtomicBool,
}

/// The finished files in the folder, by key and by use; its lock is held while one is added or removed.
#[derive(Debug)]
struct Index<K> {
    entries: HashMap<K, Entry>,
    by_use: BTreeMap<u64, K>,
    uses: u64,
    /// The bytes of the entries and of what is being written.
    bytes: u64,
}

#[derive(Debug)]
struct Entry {
    bytes: u64,
    used: u64,
}

impl<K> Default for Index<K> {
    fn default() -> Self {
        Self { entries: HashMap::new(), by_use: BTreeMap::new(), uses: 0, bytes: 0 }
    }
}

impl<K: Key> Index<K> {
    fn insert(&mut self, name: K, bytes: u64) {
        self.uses += 1;
        let entry = Entry { bytes, used: self.uses };
        self.by_use.insert(entry.used, name);
        if let Some(twin) = self.entries.insert(name, entry) {
            self.by_use.remove(&twin.used);
            self.bytes -= twin.bytes;
        }
    }

    fn touch(&mut self, name: &K) {
        if let Some(entry) = self.entries.get_mut(name) {
            self.by_use.remove(&entry.used);
            self.uses += 1;
            entry.used = self.uses;
            self.by_use.insert(entry.used, *name);
        }
    }

    fn remove(&mut self, name: &K) {
        if let Some(entry) = self.entries.remove(name) {
            self.by_use.remove(&entry.used);
            self.bytes -= entry.bytes;
        }
    }
}

impl<K: Key> Cache<K> {
    /// Opens the folder, creating it where needed, and brings it within the limit.
    pub(super) async fn open(folder: &Path, limit_bytes: u64) -> Self {
        let inner = Arc::new(Inner {
            folder: folder.to_owned(),
            limit_bytes,
            index: Mutex::default(),
            writes: AtomicU64::new(0),
            warned: AtomicBool::new(false),
        });
        let cache = Self { inner };
        cache.run(Inner::open).await;
        cache
    }

    /// A cached content, proved.
    pub(super) async fn get(&self, name: K) -> Option<Bytes> {
        self.run(move |inner| inner.get(&name)).await.flatten()
    }

    /// Caches a content that proves its key.
    pub(super) async fn keep(&self, name: K, content: Bytes) {
        self.run(move |inner| inner.keep(name, &content)).await;
    }

    /// The keys of all that is kept, in their order.
    pub(super) fn keys(&self) -> Vec<K> {
        let mut keys: Vec<K> = self.inner.index().entries.keys().copied().collect();
        keys.sort_unstable();
        keys
    }

    /// Removes what is kept under these keys.
    pub(super) async fn remove(&self, names: Vec<K>) {
        self.run(move |inner| names.iter().for_each(|name| inner.remove(name))).await;
    }

    /// Runs work on files outside the async threads; none when the runtime is shutting down.
    async fn run<T: Send + 'static>(&self, work: impl FnOnce(&Inner<K>) -> T + Send + 'static) -> Option<T> {
        let inner = Arc::clone(&self.inner);
        tokio::task::spawn_blocking(move || work(&inner)).await.ok()
    }
}

impl<K: Key> Inner<K> {
    fn open(&self) {
        if let Err(error) = self.scan() {
            self.warn(&error);
        }
        self.make_room(0);
    }

    /// Indexes the files of an earlier process, and removes those that it didn't finish.
    fn scan(&self) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            // one that can't be looked at must not hide the others from their limit
            let Ok(entry) = entry else { continue };
            let file_name = entry.file_name();
            let file_name = file_name.to_string_lossy();
            let Ok(metadata) = entry.metadata() else { continue };
            if let Ok(name) = file_name.parse::<K>() {
                let used = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                found.push((used, name, metadata.len()));
            } else if file_name.contains('#') {
                fs::remove_file(entry.path()).ok();
            }
        }
        found.sort_unstable();
        let mut index = self.index();
        for (_, name, bytes) in found {
            index.bytes += bytes;
            index.insert(name, bytes);
        }
        Ok(())
    }

    fn get(&self, name: &K) -> Option<Bytes> {
        let path = self.path(name);
        let content = match fs::read(&path) {
            Ok(content) => Bytes::from(content),
            Err(error) => {
                if error.kind() != io::ErrorKind::NotFound {
                    self.warn(&error);
                }
                let mut index = self.index();
                // Another call may have put it there in the meantime.
                if !path.exists() {
                    index.remove(name);
                }
                return None;
            }
        };
        if !name.is_proved_by(&content) {
            self.remove(name);
            return None;
        }
        self.index().touch(name);
        // A failure only affects the order of use after the next start.
        File::options().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now())).ok();
        Some(content)
    }

    fn keep(&self, name: K, content: &[u8]) {
        let bytes = content.len() as u64;
        let is_kept = self.index().entries.contains_key(&name);
        if is_kept || !self.make_room(bytes) {
            return;
        }
        let number = self.writes.fetch_add(1, Ordering::Relaxed);
        let unfinished = self.folder.join(format!("{name}#{number}"));
        let written = fs::write(&unfinished, content);
        let mut index = self.index();
        match written.and_then(|()| fs::rename(&unfinished, self.path(&name))) {
            Ok(()) => index.insert(name, bytes),
            Err(error) => {
                fs::remove_file(&unfinished).ok();
                index.bytes -= bytes;
                self.warn(&error);
            }
        }
    }

    /// Reserves `bytes`, and removes the least recently used files that leave no room for them; false when `bytes` exceed
    /// the limit.
    fn make_room(&self, bytes: u64) -> bool {
        if bytes > self.limit_bytes {
            return false;
        }
        let mut index = self.index();
        index.bytes += bytes;
        while index.bytes > self.limit_bytes {
            // None when other calls are writing all of it, and exceed the limit for a moment.
            let Some((_, name)) = index.by_use.pop_first() else { break };
            index.remove(&name);
            self.remove_file(&name);
        }
        true
    }

    fn remove(&self, name: &K) {
        let mut index = self.index();
        index.remove(name);
        self.remove_file(name);
    }

    fn remove_file(&self, name: &K) {
        if let Err(error) = fs::remove_file(self.path(name))
            && error.kind() != io::ErrorKind::NotFound
        {
            self.warn(&error);
        }
    }

    fn path(&self, name: &K) -> PathBuf {
        self.folder.join(name.to_string())
    }

    fn index(&self) -> std::sync::MutexGuard<'_, Index<K>> {
        self.index.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn warn(&self, error: &io::Error) {
        if !self.warned.swap(true, Ordering::Relaxed) {
            let folder = self.folder.display();
            tracing::warn!(%folder, %error, "a cache can't be used: what it would keep is fetched or computed each time");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A blob of a thousand bytes.
    fn thousand(number: u8) -> (BlobName, Bytes) {
        let content = Bytes::from(vec![number; 1000]);
        (BlobName::of(&content), content)
    }

    fn bytes_in(folder: &Path) -> u64 {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().metadata().unwrap().len()).sum()
    }

    #[tokio::test]
    async fn the_least_recently_used_goes_first_and_the_bound_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path(), 3500).await;
        for number in 0..3 {
            let (name, content) = thousand(number);
            assert_eq!(cache.get(name).await, None);
            cache.keep(name, content.clone()).await;
            cache.keep(name, content.clone()).await;
            assert_eq!(cache.get(name).await, Some(content));
        }
        // Used last, the oldest stays.
        assert!(cache.get(thousand(0).0).await.is_some());
        let (name, content) = thousand(3);
        cache.keep(name, content).await;
        assert_eq!(bytes_in(folder.path()), 3000);
        assert_eq!(cache.get(thousand(1).0).await, None);
        for number in [2, 3, 0] {
            assert!(cache.get(thousand(number).0).await.is_some(), "{number}");
        }
        let large = Bytes::from(vec![9; 4000]);
        cache.keep(BlobName::of(&large), large).await;
        assert_eq!(bytes_in(folder.path()), 3000);

        // The order outlives the process; a smaller limit is kept from the start.
        fs::write(folder.path().join(format!("{name}#7")), "unfinished").unwrap();
        let cache = Cache::open(folder.path(), 1500).await;
        assert_eq!(bytes_in(folder.path()), 1000);
        assert!(cache.get(thousand(0).0).await.is_some());
    }

    #[tokio::test]
    async fn many_that_keep_at_once_keep_the_bound() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path(), 10_000).await;
        let kept = (0..100).map(|number| {
            let (cache, (name, content)) = (cache.clone(), thousand(number % 25));
            tokio::spawn(async move {
                cache.keep(name, content.clone()).await;
                if let Some(found) = cache.get(name).await {
                    assert_eq!(found, content);
                }
            })
        });
        for kept in futures_util::future::join_all(kept).await {
            kept.unwrap();
        }
        let (name, content) = thousand(200);
        cache.keep(name, content).await;
        assert!(bytes_in(folder.path()) <= 10_000, "{}", bytes_in(folder.path()));
        assert_eq!(cache.inner.index().bytes, bytes_in(folder.path()));
    }

    #[tokio::test]
    async fn a_damaged_file_is_removed_and_a_lost_one_is_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path(), 10_000).await;
        let (name, content) = thousand(1);
        for damage in ["damaged", ""] {
            cache.keep(name, content.clone()).await;
            fs::write(folder.path().join(name.to_string()), damage).unwrap();
            assert_eq!(cache.get(name).await, None);
            assert!(!folder.path().join(name.to_string()).exists());
        }
        cache.keep(name, content.clone()).await;
        fs::remove_file(folder.path().join(name.to_string())).unwrap();
        assert_eq!(cache.get(name).await, None);
        cache.keep(name, content.clone()).await;
        assert_eq!(cache.get(name).await, Some(content));
        assert_eq!(cache.inner.index().bytes, 1000);
    }

    #[tokio::test]
    async fn a_folder_that_cannot_be_used_only_keeps_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("file");
        fs::write(&file, "").unwrap();
        let cache = Cache::open(&file, 10_000).await;
        let (name, content) = thousand(1);
        cache.keep(name, content).await;
        assert_eq!(cache.get(name).await, None);
        assert_eq!(cache.inner.index().bytes, 0);
    }
}
