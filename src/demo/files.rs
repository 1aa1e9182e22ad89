//! The files that the demo leaves for its user.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::DemoError;

/// Writes a file, and makes the folders that it lies in.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), DemoError> {
    path.parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(path, bytes))
        .map_err(|source| DemoError::Write { path: path.to_path_buf(), source })
}

/// Writes pictures by their names below a folder, in the place of those of a run before. Returns their paths.
pub fn replace_folder<'a>(
    folder: &Path,
    pictures: impl IntoIterator<Item = (String, &'a Vec<u8>)>,
) -> Result<Vec<PathBuf>, DemoError> {
    match fs::remove_dir_all(folder) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            return Err(DemoError::Write { path: folder.to_path_buf(), source });
        }
        _ => {}
    }
    let write = |(name, png): (String, &'a Vec<u8>)| {
        let file = folder.join(name);
        write_file(&file, png).map(|()| file)
    };
    pictures.into_iter().map(write).collect()
}
