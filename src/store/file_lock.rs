//! Locks between the processes that use one data folder.

use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// A lock on a file; it ends when the value is dropped, or with the process.
#[derive(Debug)]
pub struct FileLock {
    _file: File,
}

impl FileLock {
    /// Locks the file for this process alone, and creates it where needed; none while another lock is held.
    pub fn try_exclusive(path: &Path) -> io::Result<Option<Self>> {
        let file = File::create(path)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { _file: file })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(source)) => Err(source),
        }
    }

    /// Locks the file against exclusive locks, and waits until there is none.
    pub fn shared(path: &Path) -> io::Result<Self> {
        let file = File::create(path)?;
        file.lock_shared()?;
        Ok(Self { _file: file })
    }
}

/// The file whose exclusive lock is for collecting orphans, and whose shared lock is for copying blobs.
pub fn collection_lock_path(data_dir: &Path) -> PathBuf {
    data_dir.join("collection")
}
