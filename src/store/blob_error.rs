//! What a call on the blobs fails with.

use std::io;

use super::blob_name::{BlobName, InvalidBlobName};
use super::error::CatalogueError;

/// What a call on the blobs can fail with.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// The store can't be reached or can't write now (away, no rights, disk full); it may heal by itself.
    #[error("the blob store is unavailable")]
    Unavailable {
        /// The error of the disk, of the connection or of the bucket.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A text that should name a blob doesn't.
    #[error(transparent)]
    InvalidName(#[from] InvalidBlobName),
    /// There is no such blob.
    #[error("blob {name} does not exist")]
    NotFound {
        /// The blob.
        name: BlobName,
    },
    /// The blob is larger than the caller would take; nothing was read.
    #[error("blob {name} has {bytes} bytes, more than the {max_bytes} allowed")]
    TooLarge {
        /// The blob.
        name: BlobName,
        /// Its size.
        bytes: u64,
        /// The most that the caller would take.
        max_bytes: u64,
    },
    /// The bytes that stand under the name aren't the ones that were put there.
    #[error("blob {name} is corrupt: its content hashes to {found}")]
    Corrupt {
        /// The blob.
        name: BlobName,
        /// The name that the bytes ought to have.
        found: BlobName,
    },
    /// The blob was corrupt when it was read before, and was moved into the quarantine.
    #[error("blob {name} was corrupt; what is left of it stands in the data folder's quarantine")]
    Quarantined {
        /// The blob.
        name: BlobName,
    },
    /// Collecting orphans needs the catalogue, and it failed.
    #[error("the catalogue cannot say which blobs are in use")]
    Catalogue {
        /// What the catalogue failed with.
        #[source]
        source: CatalogueError,
    },
}

impl BlobError {
    /// True when the content is lost until the same content is put again. For a caller that allowed as many bytes as
    /// were put, a larger blob is damaged too.
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

impl From<CatalogueError> for BlobError {
    fn from(source: CatalogueError) -> Self {
        Self::Catalogue { source }
    }
}
