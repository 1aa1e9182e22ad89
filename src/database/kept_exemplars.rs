//! Exemplars that a version doesn't hold in memory: their windows are read from its artifact when a frame needs them, and
//! kept in a cache that is bounded in bytes.

use std::sync::Arc;

use bytes::Bytes;
use quick_cache::Weighter;
use quick_cache::sync::Cache;

use super::artifact::outline::ExemplarPlace;
use crate::store::{BlobError, BlobName, Blobs};
use landmarkd_core::recognition::landmarks::KeptExemplar;

/// Exemplars of any version, by the hash of their bytes: the next version finds those that it shares with the last.
#[derive(Debug)]
pub struct ExemplarCache {
    exemplars: Cache<BlobName, Bytes, Length>,
}

#[derive(Debug, Clone)]
struct Length;

impl Weighter<BlobName, Bytes> for Length {
    fn weight(&self, _: &BlobName, exemplar: &Bytes) -> u64 {
        // an exemplar without windows takes place too
        (exemplar.len() + size_of::<(BlobName, Bytes)>()) as u64
    }
}

/// Bytes of an exemplar, about: how many there is place for.
const EXEMPLAR_BYTES: u64 = 64 << 10;

impl ExemplarCache {
    /// An empty cache that takes so many bytes.
    pub fn new(limit_bytes: u64) -> Self {
        let exemplars = (limit_bytes / EXEMPLAR_BYTES).max(16) as usize;
        Self { exemplars: Cache::with_weighter(exemplars, limit_bytes, Length) }
    }

    /// Bytes that it holds.
    pub fn bytes(&self) -> u64 {
        self.exemplars.weight()
    }

    /// Exemplars that were found in it since the start, and those that were read.
    pub fn hits_and_misses(&self) -> (u64, u64) {
        (self.exemplars.hits(), self.exemplars.misses())
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

    /// The exemplars of these indices, from the cache or the store.
    ///
    /// # Errors
    /// The store is unavailable, or the artifact is damaged or gone.
    pub(super) async fn read(&self, indices: &[usize]) -> Result<ReadExemplars, BlobError> {
        let cached = |&index: &usize| {
            let place = &self.places[index];
            (index, place, self.cache.exemplars.get(&place.name))
        };
        let found: Vec<(usize, &ExemplarPlace, Option<Bytes>)> = indices.iter().map(cached).collect();
        let missing = found.iter().filter(|(_, _, bytes)| bytes.is_none());
        let missing: Vec<_> = missing.map(|(_, place, _)| (place.name, place.range.clone())).collect();
        let mut read = self.blobs.parts(&self.artifact, &missing).await?.into_iter();
        let exemplar = |(index, place, cached): (usize, &ExemplarPlace, Option<Bytes>)| {
            let bytes = cached.or_else(|| {
                // several may lie in one buffer, which none of them is to keep alive
                let bytes = Bytes::copy_from_slice(&read.next()?);
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

    /// The exemplars as a model takes them.
    pub fn kept(&self) -> Vec<KeptExemplar<'_>> {
        let exemplars = self.exemplars.iter();
        exemplars
            .map(|(index, place, bytes)| {
                let (rows, edges) = place.parts(bytes);
                KeptExemplar { index: *index, rows, edges }
            })
            .collect()
    }
}
