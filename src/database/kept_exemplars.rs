//! Exemplars that a version doesn't hold in memory: their windows are read from its artifact when a frame needs them, and
//! kept in a cache that is bounded in bytes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bytes::Bytes;
use quick_cache::Weighter;
use quick_cache::sync::Cache;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use super::artifact::outline::ExemplarPlace;
use crate::store::{BlobError, BlobName, Blobs};
use landmarkd_core::recognition::landmarks::KeptExemplar;

/// Exemplars of any version, by the hash of their bytes: the next version finds those that it shares with the last.
#[derive(Debug)]
pub struct ExemplarCache {
    exemplars: Cache<BlobName, Bytes, Length>,
    found: AtomicU64,
    read: AtomicU64,
    /// Frames that may have chosen exemplars, and wait for them or are recognised among them.
    frames: Arc<Semaphore>,
}

#[derive(Debug, Clone)]
struct Length;

impl Weighter<BlobName, Bytes> for Length {
    fn weight(&self, _: &BlobName, exemplar: &Bytes) -> u64 {
        // an exemplar without windows takes place too
        (exemplar.len() + size_of::<(BlobName, Bytes)>()) as u64
    }
}

/// Frames that choose exemplars at once: each holds its picture until they are read.
const MOST_FRAMES: usize = 32;

/// Bytes of an exemplar, about: how many there is place for.
const EXEMPLAR_BYTES: u64 = 64 << 10;

impl ExemplarCache {
    /// An empty cache that takes so many bytes; of 0 it keeps nothing.
    pub fn new(limit_bytes: u64) -> Self {
        let exemplars = (limit_bytes / EXEMPLAR_BYTES).max(16) as usize;
        let exemplars = Cache::with_weighter(exemplars, limit_bytes, Length);
        let frames = Arc::new(Semaphore::new(MOST_FRAMES));
        Self { exemplars, found: AtomicU64::new(0), read: AtomicU64::new(0), frames }
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> u64 {
        self.exemplars.weight()
    }

    /// Exemplars that frames needed since the start: found in it, and read.
    pub fn found_and_read(&self) -> [u64; 2] {
        [&self.found, &self.read].map(|count| count.load(Ordering::Relaxed))
    }
}

/// The exemplars of a version, in its artifact.
#[derive(Debug)]
pub struct KeptExemplars {
    blobs: Blobs,
    artifact: BlobName,
    /// In the order of the model's exemplars.
    places: Vec<ExemplarPlace>,
    cache: Arc<ExemplarCache>,
}

/// Exemplars that a frame needs.
#[derive(Debug, Default)]
pub struct ReadExemplars {
    /// Index, place and bytes of each, ascending.
    exemplars: Vec<(usize, ExemplarPlace, Bytes)>,
}

impl KeptExemplars {
    /// Those that lie at these places of an artifact.
    pub(super) fn new(
        blobs: Blobs,
        artifact: BlobName,
        places: Vec<ExemplarPlace>,
        cache: Arc<ExemplarCache>,
    ) -> Self {
        Self { blobs, artifact, places, cache }
    }

    /// Memory that the places take.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(&self.places[..]) as u64
    }

    /// A turn for a frame.
    pub(super) async fn turn(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.cache.frames).acquire_owned().await.ok()
    }

    /// The exemplars of these indices, from the cache or the store.
    ///
    /// # Errors
    /// The store is unavailable, or the artifact is damaged or gone.
    pub(super) async fn read(&self, indices: &[usize]) -> Result<ReadExemplars, BlobError> {
        let cached = |&index: &usize| {
            let place = &self.places[index];
            // one without windows and edges is nowhere
            let known = if place.range.is_empty() {
                Some(Bytes::new())
            } else {
                self.cache.exemplars.get(&place.name)
            };
            (index, place, known)
        };
        let found: Vec<(usize, &ExemplarPlace, Option<Bytes>)> = indices.iter().map(cached).collect();
        let missing = found.iter().filter(|(_, _, bytes)| bytes.is_none());
        let missing: Vec<_> = missing.map(|(_, place, _)| (place.name, place.range.clone())).collect();
        let count = missing.len() as u64;
        let mut read = self.blobs.parts(&self.artifact, missing).await?.into_iter();
        self.cache.found.fetch_add(indices.len() as u64 - count, Ordering::Relaxed);
        self.cache.read.fetch_add(count, Ordering::Relaxed);
        let exemplar = |(index, place, cached): (usize, &ExemplarPlace, Option<Bytes>)| {
            let bytes = cached.or_else(|| {
                let bytes = read.next()?;
                self.cache.exemplars.insert(place.name, bytes.clone());
                Some(bytes)
            })?;
            Some((index, place.clone(), bytes))
        };
        Ok(ReadExemplars { exemplars: found.into_iter().filter_map(exemplar).collect() })
    }
}

impl ReadExemplars {
    /// How many bytes they take.
    pub fn bytes(&self) -> u64 {
        self.exemplars.iter().map(|(_, _, bytes)| bytes.len() as u64).sum()
    }

    /// The exemplars as a model takes them; one of another length than it has in its version is left out.
    pub fn kept(&self) -> Vec<KeptExemplar<'_>> {
        let kept = self.exemplars.iter().filter_map(|(index, place, bytes)| {
            let (rows, edges) = place.parts(bytes)?;
            Some(KeptExemplar { index: *index, rows, edges })
        });
        kept.collect()
    }
}
