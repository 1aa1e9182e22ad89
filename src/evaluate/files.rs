//! The pictures of an evaluation: folders named by labels, manifests, poses in file names.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::EvaluateError;
use super::figures::ms_since;
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};

/// The query folder of frames without a known object.
pub(super) const UNKNOWN: &str = "unknown";
/// Endings of the files that are taken as pictures; their bytes decide what they are.
const ENDINGS: [&str; 5] = ["png", "jpg", "jpeg", "pgm", "ppm"];

/// A picture file and what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelledFile {
    /// What it shows; `None`: nothing that is known.
    pub label: Option<String>,
    /// Where it is.
    pub path: PathBuf,
    /// How it is turned: of a name `…__<degrees>.<ext>`, or as the manifest has it.
    pub pose_deg: Option<f64>,
}

/// A picture that was left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// Its file.
    pub file: String,
    /// Why.
    pub reason: String,
}

impl Skipped {
    pub(super) fn new(path: &Path, reason: impl ToString) -> Skipped {
        Skipped { file: path.display().to_string(), reason: reason.to_string() }
    }
}

/// What is trained on and what is asked.
pub(super) struct Files {
    pub training: Vec<LabelledFile>,
    pub queries: Vec<LabelledFile>,
}

/// The pictures of `<label>/*`, sorted; files that don't end like a picture are passed over.
///
/// # Errors
/// [`EvaluateError::Read`] for a folder that can't be listed, [`EvaluateError::NoPictures`] for an empty one.
pub fn labelled_files(folder: &Path) -> Result<Vec<LabelledFile>, EvaluateError> {
    let mut files = Vec::new();
    for label_folder in entries(folder)?.into_iter().filter(|path| path.is_dir()) {
        let label = label_folder.file_name().map(|name| name.to_string_lossy().into_owned());
        for path in entries(&label_folder)?.into_iter().filter(|path| is_picture(path)) {
            let pose_deg = pose_of_name(&path);
            files.push(LabelledFile { label: label.clone(), path, pose_deg });
        }
    }
    files.sort_by(|a, b| (&a.label, &a.path).cmp(&(&b.label, &b.path)));
    if files.is_empty() {
        return Err(EvaluateError::NoPictures { path: folder.to_path_buf() });
    }
    Ok(files)
}

/// The pose of a name `…__<degrees>.<ext>`, the same that archives of exemplars have.
fn pose_of_name(path: &Path) -> Option<f64> {
    let (_, degrees) = path.file_stem()?.to_str()?.rsplit_once("__")?;
    degrees.parse().ok().filter(|pose_deg: &f64| pose_deg.is_finite())
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, EvaluateError> {
    let failed = |source| EvaluateError::Read { path: folder.to_path_buf(), source };
    let listed: Result<Vec<_>, _> =
        fs::read_dir(folder).map_err(failed)?.map(|entry| entry.map(|e| e.path())).collect();
    listed.map_err(failed)
}

fn is_picture(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    path.is_file() && ending.is_some_and(|e| ENDINGS.contains(&e.as_str()))
}

#[derive(Deserialize)]
struct Manifest {
    train: Vec<ManifestEntry>,
    queries: Vec<ManifestEntry>,
}

/// Other members of an entry, such as the placement, are not judged here.
#[derive(Deserialize)]
struct ManifestEntry {
    file: PathBuf,
    label: Option<String>,
    pose_deg: Option<f64>,
}

/// The files to train on and to recognise. A manifest's own list of training pictures holds when `train_dir` is
/// the `train` folder beside it; any other folder holds by itself.
///
/// # Errors
/// [`EvaluateError`] for folders without pictures, and for what can't be read or is no manifest.
pub(super) fn training_and_queries(train_dir: &Path, queries: &Path) -> Result<Files, EvaluateError> {
    if queries.is_dir() {
        return Ok(Files { training: labelled_files(train_dir)?, queries: labelled_files(queries)? });
    }
    let text =
        fs::read(queries).map_err(|source| EvaluateError::Read { path: queries.to_path_buf(), source })?;
    let manifest: Manifest = serde_json::from_slice(&text)
        .map_err(|source| EvaluateError::Manifest { path: queries.to_path_buf(), source })?;
    let folder = queries.parent().unwrap_or(Path::new(""));
    let listed = |entries: Vec<ManifestEntry>| -> Vec<LabelledFile> {
        let file = |entry: ManifestEntry| {
            let path = folder.join(entry.file);
            let pose_deg = entry.pose_deg.or_else(|| pose_of_name(&path));
            LabelledFile { label: entry.label, path, pose_deg }
        };
        entries.into_iter().map(file).collect()
    };
    let training = match is_same_folder(train_dir, &folder.join("train")) {
        true => listed(manifest.train),
        false => labelled_files(train_dir)?,
    };
    Ok(Files { training, queries: listed(manifest.queries) })
}

fn is_same_folder(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// A frame and the time its decoding took; a picture that can't be read is noted instead.
pub(super) fn read_frame(path: &Path, skipped: &mut Vec<Skipped>) -> Option<(Frame, f64)> {
    let bytes = fs::read(path).map_err(|error| skipped.push(Skipped::new(path, error))).ok()?;
    let started = Instant::now();
    let frame = decode(&bytes, &DecodeLimits::default())
        .map_err(|error| skipped.push(Skipped::new(path, error)))
        .ok()?;
    Some((frame, ms_since(started)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_without_pictures_are_an_error_that_names_them() {
        let folder = tempfile::tempdir().unwrap();
        assert!(
            matches!(labelled_files(folder.path()), Err(EvaluateError::NoPictures { path }) if path == folder.path())
        );
        let absent = folder.path().join("absent");
        assert!(matches!(labelled_files(&absent), Err(EvaluateError::Read { path, .. }) if path == absent));
    }

    #[test]
    fn the_end_of_a_name_gives_the_pose() {
        for (name, pose_deg) in [
            ("cup/a__12.5.png", Some(12.5)),
            ("cup/obj__1__0.png", Some(0.0)),
            ("cup/a__-5.jpg", Some(-5.0)),
            ("cup/front.jpg", None),
            ("cup/front__left.jpg", None),
            ("cup__3/front.jpg", None),
            ("cup/a__inf.png", None),
        ] {
            assert_eq!(pose_of_name(Path::new(name)), pose_deg, "{name}");
        }
    }

    #[test]
    fn a_manifest_has_poses_of_its_own_before_those_of_names() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = folder.path().join("manifest.json");
        let text = r#"{"train": [{"file": "a__10.png", "label": "cup", "pose_deg": 20}],
            "queries": [{"file": "b__10.png", "label": "cup"}, {"file": "c.png", "label": null}]}"#;
        fs::write(&manifest, text).unwrap();
        fs::create_dir(folder.path().join("train")).unwrap();
        let files = training_and_queries(&folder.path().join("train"), &manifest).unwrap();
        let poses = |files: &[LabelledFile]| files.iter().map(|file| file.pose_deg).collect::<Vec<_>>();
        assert_eq!(
            (poses(&files.training), poses(&files.queries)),
            (vec![Some(20.0)], vec![Some(10.0), None])
        );
    }
}
