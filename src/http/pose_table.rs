//! `poses.csv` of an archive: which picture was taken where. A header line names the columns: `file` (relative to the table),
//! `map`, `x_m`, `y_m`, `z_m`, `yaw_deg`, `pitch_deg`, `roll_deg`, `sigma_m`, `size_mm`, `camera`; empty cells say nothing.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::cameras::CameraReference;
use super::problem::{Code, Problem};
use super::surveys::SurveyIn;
use super::uploads::too_many_parts;
use crate::database::Name;
use crate::database::survey::MapPoseDocument;

/// The name of the file.
pub const FILE_NAME: &str = "poses.csv";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    file: PathBuf,
    map: Option<Name>,
    x_m: Option<f64>,
    y_m: Option<f64>,
    z_m: Option<f64>,
    yaw_deg: Option<f64>,
    pitch_deg: Option<f64>,
    roll_deg: Option<f64>,
    sigma_m: Option<f64>,
    size_mm: Option<f64>,
    camera: Option<String>,
}

/// What an archive's table says of its pictures, by their paths in it.
pub struct PoseTable {
    rows: HashMap<PathBuf, SurveyIn>,
    /// Most rows of all tables of an archive.
    most_rows: usize,
}

impl PoseTable {
    /// One without rows, for so many.
    pub fn new(most_rows: usize) -> Self {
        Self { rows: HashMap::new(), most_rows }
    }

    /// Reads a table that lies at `path` of an archive, beside the rows of those before: all of it, or nothing.
    ///
    /// # Errors
    /// 422 with the line at fault, 413 for too many rows.
    pub fn read(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Problem> {
        let mut rows = HashMap::new();
        let folder = plain(path.parent().unwrap_or(Path::new("")));
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
        let wrong = |line: u64, text: String| {
            Problem::new(Code::InvalidField, format!("{FILE_NAME}, line {line}: {text}"))
        };
        for row in reader.deserialize::<Row>() {
            let row = row.map_err(|error| {
                let line = error.position().map_or(1, csv::Position::line);
                let text = match error.kind() {
                    csv::ErrorKind::Deserialize { err, .. } => err.to_string(),
                    _ => error.to_string(),
                };
                wrong(line, text)
            })?;
            if self.rows.len() + rows.len() >= self.most_rows {
                return Err(too_many_parts(self.most_rows));
            }
            let pose = match (row.map, row.x_m, row.y_m, row.yaw_deg) {
                (Some(map), Some(x_m), Some(y_m), Some(yaw_deg)) => Some(MapPoseDocument {
                    map,
                    x_m,
                    y_m,
                    yaw_deg,
                    z_m: row.z_m.unwrap_or(0.0),
                    pitch_deg: row.pitch_deg.unwrap_or(0.0),
                    roll_deg: row.roll_deg.unwrap_or(0.0),
                    sigma_m: row.sigma_m.unwrap_or(MapPoseDocument::DEFAULT_SIGMA_M),
                }),
                (None, None, None, None)
                    if row.z_m.or(row.pitch_deg).or(row.roll_deg).or(row.sigma_m).is_none() =>
                {
                    None
                }
                _ => {
                    let text = format!("{:?} has only some of map, x_m, y_m and yaw_deg", row.file);
                    return Err(Problem::new(Code::InvalidField, format!("{FILE_NAME}: {text}")));
                }
            };
            let camera = row.camera.map(CameraReference::Name);
            let survey = SurveyIn { pose, camera, size_mm: row.size_mm };
            let file = folder.join(plain(&row.file));
            if rows.contains_key(&file) {
                let text = format!("{FILE_NAME} names {:?} twice", row.file);
                return Err(Problem::new(Code::InvalidField, text));
            }
            rows.insert(file, survey);
        }
        self.rows.extend(rows);
        Ok(())
    }

    /// What it says of the picture at that path.
    pub fn take(&mut self, path: &Path) -> SurveyIn {
        self.rows.remove(&plain(path)).unwrap_or_default()
    }

    /// The rows that were not taken yet.
    pub fn rest(self) -> impl Iterator<Item = (PathBuf, SurveyIn)> {
        let mut rest: Vec<_> = self.rows.into_iter().collect();
        rest.sort_by(|(a, _), (b, _)| a.cmp(b));
        rest.into_iter()
    }
}

/// A path without `.` in it.
pub fn plain(path: &Path) -> PathBuf {
    path.components().filter(|part| !matches!(part, Component::CurDir)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_their_files_beside_the_table() {
        let mut table = PoseTable::new(10);
        let text = "file,map,x_m,y_m,yaw_deg,size_mm\nhall/a.jpg, lab ,1,2,90,\n./hall/b.jpg,,,,,210\n";
        table.read(Path::new("./set/poses.csv"), text.as_bytes()).unwrap();
        let pose = table.take(Path::new("set/hall/a.jpg")).pose.unwrap();
        assert_eq!((pose.map.as_str(), pose.yaw_deg, pose.z_m), ("lab", 90.0, 0.0));
        let rest: Vec<_> = table.rest().collect();
        assert_eq!((rest[0].0.to_str(), rest[0].1.size_mm), (Some("set/hall/b.jpg"), Some(210.0)));
    }

    #[test]
    fn a_line_that_cannot_be_is_named() {
        for (text, says) in [
            ("file,map,x_m,y_m,yaw_deg\na.jpg,lab,1,2,90\nb.jpg,lab,x,2,90\n", "line 3"),
            ("file,map,x_m,y_m,yaw_deg\na.jpg,lab,1,,90\n", "only some"),
            ("file,lat\na.jpg,1\n", "unknown field `lat`"),
            ("file,z_m\na.jpg,1\n", "only some"),
            ("file,size_mm\na.jpg,1\n./a.jpg,2\n", "twice"),
            ("file,size_mm\na.jpg,1\nb.jpg,2\nc.jpg,2\n", "at most 2"),
        ] {
            let problem = PoseTable::new(2).read(Path::new(FILE_NAME), text.as_bytes()).unwrap_err();
            assert!(problem.detail.contains(says), "{}", problem.detail);
        }
    }
}
