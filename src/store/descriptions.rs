//! Descriptions of pictures kept on this machine, so that a training computes only those of new pictures.
//!
//! A file begins with the hash of its name and of the rest, which proves it on every reading. What is lost is computed
//! again; what describes a picture that no row names any more is removed.

use std::collections::HashSet;
use std::fmt;
use std::path::Path;
use std::str::FromStr;

use bytes::Bytes;

use super::blob_name::BlobName;
use super::cache::{Cache, Key};
use super::catalogue::Catalogue;
use super::error::CatalogueError;

/// Pictures that the catalogue is asked about at once: some 70 kB of names.
const BATCH: usize = 1000;
/// Length of the hash that a file begins with.
const PROOF_BYTES: usize = 32;

/// What a description is known by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DescriptionKey {
    /// The picture's blob.
    pub picture: BlobName,
    /// The hash of all that describing it depends on beside the picture.
    pub options: BlobName,
}

impl fmt::Display for DescriptionKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}-{}", self.picture, self.options)
    }
}

impl FromStr for DescriptionKey {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let (picture, options) = text.split_once('-').ok_or(())?;
        Ok(Self { picture: picture.parse().map_err(drop)?, options: options.parse().map_err(drop)? })
    }
}

impl DescriptionKey {
    fn proof(&self, description: &[u8]) -> BlobName {
        BlobName::of(&[self.to_string().as_bytes(), description].concat())
    }
}

impl Key for DescriptionKey {
    fn is_proved_by(&self, content: &[u8]) -> bool {
        content
            .split_first_chunk::<PROOF_BYTES>()
            .is_some_and(|(proof, description)| self.proof(description).as_bytes() == proof)
    }
}

/// The descriptions kept; copies share them.
#[derive(Debug, Clone)]
pub struct Descriptions {
    cache: Cache<DescriptionKey>,
}

impl Descriptions {
    /// Opens the folder, creating it where needed, and brings it within the limit; with a limit of 0 nothing is kept.
    pub async fn open(folder: &Path, limit_bytes: u64) -> Self {
        Self { cache: Cache::open(folder, limit_bytes).await }
    }

    /// A description that was kept.
    pub async fn get(&self, key: DescriptionKey) -> Option<Bytes> {
        Some(self.cache.get(key).await?.slice(PROOF_BYTES..))
    }

    /// Keeps a description.
    pub async fn keep(&self, key: DescriptionKey, description: &[u8]) {
        let content = [key.proof(description).as_bytes(), description].concat();
        self.cache.keep(key, content.into()).await;
    }

    /// Removes the descriptions of pictures that no row names, and counts them.
    ///
    /// # Errors
    /// The catalogue can't say which pictures are named: what was removed until then was rightly removed.
    pub async fn remove_unreferenced(&self, catalogue: &Catalogue) -> Result<u64, CatalogueError> {
        let mut removed = 0;
        for keys in self.cache.keys().chunks(BATCH) {
            let pictures: Vec<String> = keys.iter().map(|key| key.picture.to_string()).collect();
            let named: HashSet<String> = catalogue.blobs_referenced(&pictures).await?.into_iter().collect();
            let gone = |key: &&DescriptionKey| !named.contains(&key.picture.to_string());
            let gone: Vec<DescriptionKey> = keys.iter().filter(gone).copied().collect();
            removed += gone.len() as u64;
            self.cache.remove(gone).await;
        }
        Ok(removed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(picture: &str, options: &str) -> DescriptionKey {
        DescriptionKey {
            picture: BlobName::of(picture.as_bytes()),
            options: BlobName::of(options.as_bytes()),
        }
    }

    #[tokio::test]
    async fn a_description_comes_back_for_its_picture_and_options_alone() {
        let folder = tempfile::tempdir().unwrap();
        let descriptions = Descriptions::open(folder.path(), 10_000).await;
        descriptions.keep(key("hall", "gray"), b"windows").await;
        for descriptions in [descriptions, Descriptions::open(folder.path(), 10_000).await] {
            assert_eq!(descriptions.get(key("hall", "gray")).await.as_deref(), Some(&b"windows"[..]));
            assert_eq!(descriptions.get(key("hall", "colour")).await, None);
            assert_eq!(descriptions.get(key("stairs", "gray")).await, None);
        }
    }

    #[tokio::test]
    async fn a_damaged_or_exchanged_description_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let descriptions = Descriptions::open(folder.path(), 10_000).await;
        let (hall, stairs) = (key("hall", "gray"), key("stairs", "gray"));
        let file = |key: DescriptionKey| folder.path().join(key.to_string());
        descriptions.keep(stairs, b"steps").await;
        let of_stairs = std::fs::read(file(stairs)).unwrap();
        for damage in [&b""[..], b"short", &[0; 40], &of_stairs] {
            descriptions.keep(hall, b"windows").await;
            std::fs::write(file(hall), damage).unwrap();
            assert_eq!(descriptions.get(hall).await, None);
            assert!(!file(hall).exists());
        }
        assert_eq!(descriptions.get(stairs).await.as_deref(), Some(&b"steps"[..]));
    }

    #[tokio::test]
    async fn without_a_limit_nothing_is_kept_and_what_was_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        Descriptions::open(folder.path(), 10_000).await.keep(key("hall", "gray"), b"windows").await;
        let descriptions = Descriptions::open(folder.path(), 0).await;
        descriptions.keep(key("stairs", "gray"), b"steps").await;
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
