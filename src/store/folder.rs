//! The embedded store: one folder, held by one process.
//!
//! ```text
//! <data-dir>/lock              locked as long as the process lives
//! <data-dir>/collection        locked while orphans are collected, or blobs copied
//! <data-dir>/catalogue.sqlite  rows (and its -wal and -shm beside it)
//! <data-dir>/blobs/            bytes
//! <data-dir>/quarantine/       blobs that were not what their names say
//! ```

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::blob_error::BlobError;
use super::blobs::Blobs;
use super::catalogue::Catalogue;
use super::file_lock::FileLock;
use super::open::OpenCatalogueError;
use super::session::Backend;
use super::sqlite::SqliteFile;

/// Why the data folder can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenFolderError {
    /// The folder can't be created, or not durably.
    #[error("cannot create the data folder {}", path.display())]
    Create {
        /// The data folder.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// Another process works in the folder.
    #[error(
        "the data folder {} is in use by another process: stop that one, or choose another folder",
        path.display()
    )]
    InUse {
        /// The data folder.
        path: PathBuf,
    },
    /// There are blobs, and no rows that name them.
    #[error(
        "the data folder {} has blobs, but its catalogue.sqlite is gone or empty: restore it from a backup, or choose \
         another folder",
        path.display()
    )]
    CatalogueLost {
        /// The data folder.
        path: PathBuf,
    },
    /// Nothing was ever served there.
    #[error("{} is no data folder: it has no catalogue.sqlite", path.display())]
    Empty {
        /// The data folder.
        path: PathBuf,
    },
    /// The lock file can't be made or locked.
    #[error("cannot lock {}", path.display())]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The catalogue can't be opened.
    #[error("cannot open the catalogue {}", path.display())]
    Catalogue {
        /// The file of the catalogue.
        path: PathBuf,
        /// Why.
        #[source]
        source: OpenCatalogueError,
    },
    /// The folder of the blobs can't be opened.
    #[error("cannot open the blobs in {}: is its disk mounted?", path.display())]
    Blobs {
        /// The folder of the blobs.
        path: PathBuf,
        /// Why.
        #[source]
        source: BlobError,
    },
}

/// What a data folder holds.
pub struct Folder {
    /// The rows.
    pub catalogue: Arc<Catalogue>,
    /// The bytes.
    pub blobs: Blobs,
}

/// The lock that shows that no other process works in the folder. Errors: `InUse`, `Lock`.
pub(super) fn lock(data_dir: &Path) -> Result<FileLock, OpenFolderError> {
    let path = data_dir.join("lock");
    match FileLock::try_exclusive(&path) {
        Ok(Some(lock)) => Ok(lock),
        Ok(None) => Err(OpenFolderError::InUse { path: data_dir.to_owned() }),
        Err(source) => Err(OpenFolderError::Lock { path, source }),
    }
}

/// Opens a data folder, creating it where needed, and holds it until the catalogue and the blobs are dropped.
///
/// # Errors
/// They say which file, why, and what to do. `InUse` when another process, or another call, holds the folder.
pub async fn open_folder(data_dir: &Path) -> Result<Folder, OpenFolderError> {
    create(data_dir).map_err(|source| OpenFolderError::Create { path: data_dir.to_owned(), source })?;
    let lock = Arc::new(lock(data_dir)?);

    // The blobs are created before the catalogue. So a catalogue without blobs means that they were lost or are not
    // mounted, and blobs without a catalogue mean that it was lost: they would all be orphans. A crash at the first start
    // leaves an empty file.
    let new = !data_dir.join("catalogue.sqlite").exists();
    let path = data_dir.join("blobs");
    let rows_bytes = std::fs::metadata(data_dir.join("catalogue.sqlite")).map_or(0, |file| file.len());
    if rows_bytes == 0 && holds_folders(&path) {
        return Err(OpenFolderError::CatalogueLost { path: data_dir.to_owned() });
    }
    let blobs = match Blobs::in_folder(&path, new, lock.clone()).await {
        Ok(blobs) => blobs,
        Err(source) => return Err(OpenFolderError::Blobs { path, source }),
    };

    let path = data_dir.join("catalogue.sqlite");
    let catalogue = match SqliteFile::open(&path, lock).await {
        Ok(file) => Arc::new(Catalogue::new(Backend::Sqlite(file))),
        Err(source) => return Err(OpenFolderError::Catalogue { path, source }),
    };
    // The names of the files just created must survive power loss as their contents do.
    sync_directory(data_dir)
        .map_err(|source| OpenFolderError::Create { path: data_dir.to_owned(), source })?;
    Ok(Folder { catalogue, blobs })
}

/// Opens a data folder beside a process that may be serving it: without its lock, and with its tables as they are.
///
/// Blobs that another process may be writing are left alone, and nothing is created.
///
/// # Errors
/// They say which file, why, and what to do. A catalogue of a newer or older release is refused.
pub async fn open_unlocked_folder(data_dir: &Path) -> Result<Folder, OpenFolderError> {
    let path = data_dir.join("catalogue.sqlite");
    if !path.exists() {
        return Err(OpenFolderError::Empty { path: data_dir.to_owned() });
    }
    let catalogue = match SqliteFile::open_unlocked(&path).await {
        Ok(file) => Arc::new(Catalogue::new(Backend::Sqlite(file))),
        Err(source) => return Err(OpenFolderError::Catalogue { path, source }),
    };
    let path = data_dir.join("blobs");
    let blobs = match Blobs::in_unlocked_folder(&path).await {
        Ok(blobs) => blobs,
        Err(source) => return Err(OpenFolderError::Blobs { path, source }),
    };
    Ok(Folder { catalogue, blobs })
}

/// Whether a blob was ever put there: each has a folder for the beginning of its name.
fn holds_folders(blobs: &Path) -> bool {
    std::fs::read_dir(blobs).is_ok_and(|entries| entries.flatten().any(|entry| entry.path().is_dir()))
}

fn create(data_dir: &Path) -> io::Result<()> {
    if data_dir.is_dir() {
        return Ok(());
    }
    std::fs::create_dir_all(data_dir)?;
    match data_dir.canonicalize()?.parent() {
        Some(parent) => sync_directory(parent),
        None => Ok(()),
    }
}

#[cfg(unix)]
pub(super) fn sync_directory(directory: &Path) -> io::Result<()> {
    File::open(directory)?.sync_all()
}

/// Elsewhere than on Unix a folder can't be opened for syncing.
#[cfg(not(unix))]
pub(super) fn sync_directory(_directory: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use super::*;
    use crate::store::suite::{self, by, catalogue_suite};
    use crate::store::{AliasExpectation, BlobName, NewVersion};

    async fn empty() -> (Arc<Catalogue>, (tempfile::TempDir, Blobs)) {
        let directory = tempfile::tempdir().unwrap();
        let folder = open_folder(directory.path()).await.unwrap();
        (folder.catalogue, (directory, folder.blobs))
    }

    mod sqlite_keeps_every_promise {
        use super::{catalogue_suite, empty};

        catalogue_suite!(empty);
    }

    #[tokio::test]
    async fn the_leases_of_dead_owners_end_now() {
        let (catalogue, _kept) = empty().await;
        suite::the_leases_of_dead_owners_end_now(catalogue).await;
    }

    fn artifact(blob: BlobName) -> NewVersion {
        NewVersion {
            database: "lab".to_owned(),
            digest: "d1".to_owned(),
            blob: blob.to_string(),
            bytes: 8,
            kind: "landmarks".to_owned(),
            algorithm_revision: 1,
            options: "{}".to_owned(),
            counts: "{}".to_owned(),
            report: "{}".to_owned(),
        }
    }

    #[tokio::test]
    async fn a_folder_opened_again_holds_everything() {
        let directory = tempfile::tempdir().unwrap();
        let data_dir = directory.path().join("not/yet/there");

        let folder = open_folder(&data_dir).await.unwrap();
        let blob = folder.blobs.put("artifact".into()).await.unwrap();
        folder.catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        let (version, _) = folder.catalogue.insert_version(&artifact(blob), by()).await.unwrap();
        let any = AliasExpectation::Any;
        let (alias, _) = folder.catalogue.set_alias("lab", "current", 1, any, by()).await.unwrap();
        let job = folder.catalogue.enqueue_job("training", "lab", "{}", by()).await.unwrap();
        drop(folder);

        let folder = open_folder(&data_dir).await.unwrap();
        assert_eq!(folder.catalogue.version("lab", 1).await.unwrap(), Some(version));
        assert_eq!(folder.catalogue.aliases("lab").await.unwrap(), [alias]);
        assert_eq!(folder.catalogue.job(job.id).await.unwrap(), Some(job));
        assert_eq!(folder.blobs.get(&blob, 8).await.unwrap(), "artifact");
    }

    #[tokio::test]
    async fn a_folder_is_open_once_until_the_last_part_of_it_is_dropped() {
        let directory = tempfile::tempdir().unwrap();
        let Folder { catalogue, blobs } = open_folder(directory.path()).await.unwrap();
        let refused = open_folder(directory.path()).await.err().unwrap();
        assert!(matches!(refused, OpenFolderError::InUse { .. }), "{refused:?}");
        assert!(refused.to_string().contains("in use by another process"), "{refused}");
        drop(catalogue);
        assert!(open_folder(directory.path()).await.is_err());
        drop(blobs);
        open_folder(directory.path()).await.unwrap();
    }

    /// Opens a folder that was just let go: a task of the store may hold its lock for a moment more.
    async fn once_free(data_dir: &Path) -> Result<Folder, OpenFolderError> {
        for _ in 0..500 {
            match open_folder(data_dir).await {
                Err(OpenFolderError::InUse { .. }) => {
                    tokio::time::sleep(std::time::Duration::from_millis(10)).await;
                }
                opened => return opened,
            }
        }
        panic!("{} stays in use", data_dir.display());
    }

    #[tokio::test]
    async fn blobs_that_are_not_mounted_are_refused_and_take_no_writes() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open_folder(directory.path()).await.unwrap();
        let (blobs, away) = (directory.path().join("blobs"), directory.path().join("away"));
        std::fs::rename(&blobs, &away).unwrap();
        let refused = folder.blobs.put("picture".into()).await;
        assert!(matches!(refused, Err(BlobError::Unavailable { .. })), "{refused:?}");
        let name = super::super::BlobName::of(b"picture");
        let missing = folder.blobs.get(&name, 100).await;
        assert!(matches!(missing, Err(BlobError::Unavailable { .. })), "{missing:?}");
        drop(folder);
        let refused = once_free(directory.path()).await.err().unwrap();
        assert!(matches!(refused, OpenFolderError::Blobs { .. }), "{refused:?}");
        std::fs::remove_dir_all(&blobs).ok();
        std::fs::rename(&away, &blobs).unwrap();
        let folder = once_free(directory.path()).await.unwrap();
        assert_eq!(folder.blobs.put("picture".into()).await.unwrap(), name);
    }

    #[tokio::test]
    async fn a_damaged_catalogue_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        // Blobs that are there, so that only the catalogue is wrong.
        std::fs::create_dir(directory.path().join("blobs")).unwrap();
        std::fs::write(directory.path().join("blobs/landmarkd-blobs"), "").unwrap();
        std::fs::write(directory.path().join("catalogue.sqlite"), "no database at all ".repeat(1000))
            .unwrap();
        let refused = open_folder(directory.path()).await.err().unwrap();
        assert!(matches!(refused, OpenFolderError::Catalogue { .. }), "{refused:?}");
        assert!(refused.to_string().contains("catalogue.sqlite"), "{refused}");
        assert!(refused.source().unwrap().source().is_some(), "{refused:?}");
    }

    #[tokio::test]
    async fn blobs_without_a_catalogue_are_not_taken_for_orphans() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open_folder(directory.path()).await.unwrap();
        folder.blobs.put("picture".into()).await.unwrap();
        drop(folder);
        let catalogue = directory.path().join("catalogue.sqlite");
        // The last connection to end writes the log into the file, and takes it away.
        while directory.path().join("catalogue.sqlite-wal").exists() {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        let lost = async || {
            let refused = once_free(directory.path()).await.err().unwrap();
            assert!(matches!(refused, OpenFolderError::CatalogueLost { .. }), "{refused:?}");
            assert!(refused.to_string().contains("restore it from a backup"), "{refused}");
        };
        std::fs::write(&catalogue, "").unwrap();
        lost().await;
        std::fs::remove_file(&catalogue).unwrap();
        lost().await;
    }

    #[tokio::test]
    async fn a_catalogue_damaged_in_its_midst_is_refused_with_what_to_do() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open_folder(directory.path()).await.unwrap();
        for number in 0..200 {
            folder
                .catalogue
                .create_database(&format!("lab-{number}"), "landmarks", "{}", by())
                .await
                .unwrap();
        }
        drop(folder);
        let path = directory.path().join("catalogue.sqlite");
        drop(once_free(directory.path()).await.unwrap());
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(&path);
        let pool = sqlx::SqlitePool::connect_with(options).await.unwrap();
        sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&pool).await.unwrap();
        pool.close().await;
        let mut bytes = std::fs::read(&path).unwrap();
        for page in bytes.chunks_mut(4096).skip(1) {
            page[..64].fill(0x55);
        }
        std::fs::write(&path, bytes).unwrap();
        let refused = once_free(directory.path()).await.err().unwrap();
        let OpenFolderError::Catalogue { source, .. } = refused else { panic!("{refused:?}") };
        assert!(matches!(source, OpenCatalogueError::Damaged { .. }), "{source:?}");
        assert!(source.to_string().contains("restore"), "{source}");
    }

    #[tokio::test]
    async fn a_catalogue_of_a_newer_release_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        drop(open_folder(directory.path()).await.unwrap());
        let options =
            sqlx::sqlite::SqliteConnectOptions::new().filename(directory.path().join("catalogue.sqlite"));
        let pool = sqlx::SqlitePool::connect_with(options).await.unwrap();
        sqlx::query(
            "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
             VALUES (9000, 'of the future', TRUE, x'00', 0)",
        )
        .execute(&pool)
        .await
        .unwrap();
        pool.close().await;

        let refused = open_folder(directory.path()).await.err().unwrap();
        let OpenFolderError::Catalogue { source, .. } = refused else { panic!("{refused:?}") };
        assert!(matches!(source, OpenCatalogueError::Newer { migration: 9000 }), "{source:?}");
    }

    #[tokio::test]
    async fn a_folder_is_opened_beside_the_process_that_serves_it() {
        let directory = tempfile::tempdir().unwrap();
        let refused = open_unlocked_folder(directory.path()).await.err().unwrap();
        assert!(matches!(refused, OpenFolderError::Empty { .. }), "{refused:?}");
        let served = open_folder(directory.path()).await.unwrap();
        let blob = served.blobs.put("picture".into()).await.unwrap();
        let beside = open_unlocked_folder(directory.path()).await.unwrap();
        beside.catalogue.create_database("lab", "landmarks", "{}", by()).await.unwrap();
        assert!(served.catalogue.database("lab").await.unwrap().is_some());
        assert_eq!(beside.blobs.get(&blob, 7).await.unwrap(), "picture");
        drop(served);
        // It holds no lock.
        once_free(directory.path()).await.unwrap();
    }

    #[tokio::test]
    async fn beside_another_process_only_tables_of_this_release_are_taken_and_none_is_changed() {
        let directory = tempfile::tempdir().unwrap();
        drop(open_folder(directory.path()).await.unwrap());
        let path = directory.path().join("catalogue.sqlite");
        let pool = sqlx::SqlitePool::connect_with(sqlx::sqlite::SqliteConnectOptions::new().filename(path))
            .await
            .unwrap();
        for (statement, is_refused) in [
            ("UPDATE _sqlx_migrations SET version = 9000 WHERE version = 2", true),
            ("UPDATE _sqlx_migrations SET version = 2 WHERE version = 9000", false),
            ("DELETE FROM _sqlx_migrations WHERE version = 2", true),
        ] {
            sqlx::query(statement).execute(&pool).await.unwrap();
            assert_eq!(open_unlocked_folder(directory.path()).await.is_err(), is_refused, "{statement}");
        }
        let left: i64 = sqlx::query_scalar("SELECT count(*) FROM _sqlx_migrations WHERE version = 2")
            .fetch_one(&pool)
            .await
            .unwrap();
        assert_eq!(left, 0);
    }

    #[cfg(unix)]
    #[tokio::test]
    async fn a_data_folder_that_is_a_file_is_refused_with_its_name() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        std::fs::write(&path, "").unwrap();
        let refused = open_folder(&path).await.err().unwrap();
        assert!(matches!(refused, OpenFolderError::Create { .. }), "{refused:?}");
        assert!(refused.to_string().contains("file"), "{refused}");
    }
}
