//! A copy of a data folder, taken while the service runs on it or not.
//!
//! Copies the rows first, as of one moment, then every blob that they name, proved by its name on the way. The copy is
//! written beside its place, synced, and renamed last: half a copy is never taken for a whole one.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::blob_error::BlobError;
use super::blob_name::BlobName;
use super::blobs::Blobs;
use super::error::CatalogueError;
use super::file_lock::{FileLock, collection_lock_path};
use super::folder::{self, OpenFolderError, open_unlocked_folder, sync_directory};
use super::open::OpenCatalogueError;
use super::sqlite::SqliteFile;

/// Why a data folder wasn't copied. What was copied until then stands beside the place, and is overwritten by the
/// next attempt.
#[derive(Debug, thiserror::Error)]
pub enum BackupError {
    /// There is something at the place of the copy already.
    #[error("{} is there already: give the folder of a new backup", path.display())]
    Exists {
        /// The place of the copy.
        path: PathBuf,
    },
    /// The folder can't be read.
    #[error(transparent)]
    Folder {
        /// Why.
        #[from]
        source: OpenFolderError,
    },
    /// The rows can't be copied, or the copy can't be read.
    #[error("the catalogue can't be copied")]
    Catalogue {
        /// The error of the catalogue, or of its opening.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A blob can't be read or written now.
    #[error("the blobs can't be copied")]
    Blobs {
        /// Why.
        #[from]
        source: BlobError,
    },
    /// The copy's folder can't be written.
    #[error("{} can't be written", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

impl From<CatalogueError> for BackupError {
    fn from(source: CatalogueError) -> Self {
        Self::Catalogue { source: source.into() }
    }
}

impl From<OpenCatalogueError> for BackupError {
    fn from(source: OpenCatalogueError) -> Self {
        Self::Catalogue { source: source.into() }
    }
}

/// What a copy holds.
#[derive(Debug)]
pub struct Backup {
    /// The number of blobs.
    pub blobs: u64,
    /// Size of the blobs.
    pub bytes: u64,
    /// Blobs that are damaged or gone where they were copied from, and so aren't in the copy.
    pub damaged: Vec<BlobError>,
}

/// Copies a data folder to `to`, which isn't there yet; to restore, serve on the copy.
///
/// Everything acknowledged before the call is in it. A blob that is damaged doesn't keep the rest from being copied.
///
/// # Errors
/// They say which file or folder, and why.
pub async fn back_up(data_dir: &Path, to: &Path) -> Result<Backup, BackupError> {
    if to.exists() {
        return Err(BackupError::Exists { path: to.to_owned() });
    }
    let writing = |path: &Path| {
        let path = path.to_owned();
        move |source| BackupError::Write { path, source }
    };
    let source = open_unlocked_folder(data_dir).await?;
    let collection = collection_lock_path(data_dir);
    let locked = tokio::task::spawn_blocking(move || FileLock::shared(&collection)).await;
    let _no_collection = locked.map_err(io::Error::other).flatten().map_err(writing(data_dir))?;

    let mut unfinished = to.as_os_str().to_owned();
    unfinished.push(".unfinished");
    let unfinished = PathBuf::from(unfinished);
    std::fs::create_dir_all(&unfinished).map_err(writing(&unfinished))?;
    let lock = Arc::new(folder::lock(&unfinished)?);
    empty(&unfinished).map_err(writing(&unfinished))?;

    let path = unfinished.join("catalogue.sqlite");
    let rows = SqliteFile::open_unlocked(&data_dir.join("catalogue.sqlite")).await?;
    rows.copy_to(&path).await?;
    rows.close().await;
    let copy = SqliteFile::open_unlocked(&path).await?;
    let named = copy.blobs_named().await?;
    copy.close().await;

    let blobs = Blobs::in_folder(&unfinished.join("blobs"), true, lock).await?;
    let mut backup = Backup { blobs: 0, bytes: 0, damaged: Vec::new() };
    for name in named {
        let name: BlobName = name.parse().map_err(BlobError::from)?;
        match source.blobs.get(&name, u64::MAX).await {
            Ok(content) => {
                backup.blobs += 1;
                backup.bytes += content.len() as u64;
                blobs.put(content).await?;
            }
            Err(damaged) if damaged.is_damage() => backup.damaged.push(damaged),
            Err(away) => return Err(away.into()),
        }
    }
    // SQLite does not sync a copy.
    File::open(&path).and_then(|file| file.sync_all()).map_err(writing(&path))?;
    sync_directory(&unfinished).map_err(writing(&unfinished))?;
    std::fs::rename(&unfinished, to).map_err(writing(to))?;
    let parent = to.canonicalize().map_err(writing(to))?;
    parent.parent().map_or(Ok(()), sync_directory).map_err(writing(to))?;
    Ok(backup)
}

/// What SQLite finds wrong with a data folder's catalogue; none when all is well.
///
/// # Errors
/// The catalogue can't be opened or read.
pub async fn catalogue_faults(data_dir: &Path) -> Result<Vec<String>, BackupError> {
    let rows = SqliteFile::open_unlocked(&data_dir.join("catalogue.sqlite")).await?;
    let faults = rows.faults().await?;
    rows.close().await;
    Ok(faults)
}

/// Removes what an attempt that was cut off left.
fn empty(unfinished: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(unfinished)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            std::fs::remove_dir_all(entry.path())?;
        } else if entry.file_name() != "lock" {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}
