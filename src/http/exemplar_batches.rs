//! `POST /v1/databases/{database}/exemplars:batch`: many training images at once, as a form with a manifest or as a
//! tar archive. Streamed: at most one picture is held at a time, and one bad picture never loses the rest.

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::{Path as FilePath, PathBuf};

use axum::Json;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use bytes::Bytes;
use futures_util::{StreamExt, TryStreamExt};
use serde::{Deserialize, Serialize};
use tokio::io::{AsyncRead, AsyncReadExt};
use tokio_tar::{Archive, Entry};
use tokio_util::io::StreamReader;
use utoipa::ToSchema;
use uuid::Uuid;

use super::cameras::CameraReference;
use super::exemplars::{self, Description, label_or_negative, pose, surveyable};
use super::extract::{MAX_JSON_BYTES, Path, essence, from_json};
use super::paths::DatabasePath;
use super::pose_table::{self, FILE_NAME, PoseTable};
use super::problem::{Code, Problem, ProblemBody};
use super::surveys::{SurveyIn, camera_for};
use super::uploads::{Form, Picture, RobotHeader, too_many_parts};
use super::{Service, body};
use crate::database::survey::MapPoseDocument;
use crate::database::{DatabaseRow, FrameHeader, Name};

/// One line of a batch's manifest.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ManifestLine {
    /// Name of the file part.
    pub file: String,
    /// The place or object; left out where `negative` is true.
    #[schema(value_type = Option<String>, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub label: Option<String>,
    /// Turntable pose, in degrees.
    #[schema(minimum = 0, exclusive_maximum = 360)]
    pub pose_deg: Option<f64>,
    /// Whether the picture shows nothing known.
    #[serde(default)]
    #[schema(default = false)]
    pub negative: bool,
    /// Where the camera was; with `size_mm` where the flat thing is. Of landmarks.
    pub pose: Option<MapPoseDocument>,
    /// The camera that took it.
    pub camera: Option<CameraReference>,
    /// Width of the picture on the plane that it shows.
    pub size_mm: Option<f64>,
}

/// A form with a manifest and one file part for each of its files.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form for the OpenAPI document")]
pub struct BatchForm {
    /// JSON: which file shows what. Best sent first: what comes before it must be held.
    manifest: Vec<ManifestLine>,
}

/// What became of a batch.
#[derive(Debug, Default, Serialize, ToSchema)]
pub struct BatchBody {
    pub created: u64,
    pub duplicates: u64,
    pub rejected: u64,
    /// One for each file, in the order they came.
    pub items: Vec<BatchItem>,
}

/// What became of one file.
#[derive(Debug, Serialize, ToSchema)]
pub struct BatchItem {
    pub file: String,
    pub status: ItemStatus,
    /// The exemplar that it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<Uuid>,
    /// Why it was rejected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<ProblemBody>,
}

/// Whether a file became an exemplar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ItemStatus {
    Created,
    Duplicate,
    Rejected,
}

impl BatchBody {
    /// Note what became of a file. A problem of ours (a store is away, too much load) ends the batch: the files
    /// before it are kept, and sending the batch again does no harm.
    fn note(&mut self, file: String, outcome: Result<(Uuid, bool), Problem>) -> Result<(), Problem> {
        let (status, id, problem) = match outcome {
            Ok((id, true)) => (ItemStatus::Created, Some(id), None),
            Ok((id, false)) => (ItemStatus::Duplicate, Some(id), None),
            Err(problem) if problem.status().is_server_error() => return Err(problem),
            Err(problem) => (ItemStatus::Rejected, None, Some(problem.into())),
        };
        match status {
            ItemStatus::Created => self.created += 1,
            ItemStatus::Duplicate => self.duplicates += 1,
            ItemStatus::Rejected => self.rejected += 1,
        }
        self.items.push(BatchItem { file, status, id, problem });
        Ok(())
    }
}

/// Add many training images: a form with a part `manifest` and then one part named as each file, or a tar archive of
/// `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the turntable pose); pictures that show nothing known
/// stand in a folder `_negative`. A file `poses.csv` in the archive says where they were taken: a header line, then a line a
/// picture, of the columns `file` (its path beside the table), `map`, `x_m`, `y_m`, `z_m`, `yaw_deg`, `pitch_deg`, `roll_deg`,
/// `sigma_m`, `size_mm` and `camera` (the name of a kept one); which may be left out but `file`.
#[utoipa::path(
    post, operation_id = "add_exemplar_batch",
    path = "/v1/databases/{database}/exemplars:batch", tag = "databases", security(("key" = ["contribute"])), params(DatabasePath),
    request_body(content((BatchForm = "multipart/form-data"), (Vec<u8> = "application/x-tar"))),
    responses((status = 200, body = BatchBody))
)]
pub async fn post(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    RobotHeader(header): RobotHeader,
    request: Request,
) -> Result<Json<BatchBody>, Problem> {
    let row = service.databases.get(&path.database).await?;
    let batch = Batch { service: &service, database: &path.database, row, header };
    match essence(request.headers()).as_deref() {
        Some("multipart/form-data") => batch.form(request).await.map(Json),
        Some("application/x-tar" | "application/tar") => batch.tar(request).await.map(Json),
        other => Err(Problem::new(
            Code::UnsupportedMediaType,
            format!(
                "a batch is multipart/form-data or application/x-tar, not {}: send -H 'Content-Type: application/x-tar' \
                 with a tar of <label>/<picture>",
                other.unwrap_or("undeclared")
            ),
        )),
    }
}

struct Batch<'a> {
    service: &'a Service,
    database: &'a Name,
    row: DatabaseRow,
    header: FrameHeader,
}

/// The bytes of a file, or why it can't be kept.
type FileBytes = Result<Bytes, Problem>;

impl Batch<'_> {
    async fn keep(
        &self,
        label: Option<&str>,
        negative: bool,
        pose_deg: Option<f64>,
        survey: SurveyIn,
        bytes: Bytes,
    ) -> Result<(Uuid, bool), Problem> {
        let wrong = |label, error| Problem::field("/label", format!("{label:?} {error}"));
        let label = label.map(|label| Name::parse(label).map_err(|error| wrong(label, error))).transpose()?;
        let pose_deg = pose(pose_deg, "/pose_deg")?;
        let label = label_or_negative(&self.row, label, negative, pose_deg, "/")?;
        let survey = surveyable(&self.row, survey.resolved(self.service, "/").await?, negative, "/")?;
        let picture = Picture::of(bytes, &self.service.decode)?;
        let description = Description { label, pose_deg, survey, header: self.header.clone() };
        let kept = exemplars::keep(self.service, self.database, description, &picture, "/");
        let (row, created) = kept.await?;
        Ok((row.id, created))
    }

    /// Keeps what a table that came after its picture says of it.
    async fn survey(&self, id: Uuid, survey: SurveyIn) -> Result<(), Problem> {
        let row = self.service.databases.exemplar(self.database, id).await?;
        let survey = surveyable(&self.row, survey.resolved(self.service, "/").await?, row.negative, "/")?;
        if let Some(camera) = &survey.camera {
            camera_for(camera, (row.width_px, row.height_px), "/camera")?;
        }
        self.service.databases.change_survey(self.database, id, |before| survey.clone().over(before)).await?;
        Ok(())
    }

    async fn form(&self, request: Request) -> Result<BatchBody, Problem> {
        let limits = &self.service.limits;
        let mut form = Form::of(request, self.service, limits.max_batch_bytes, limits.max_body_bytes).await?;
        let (manifest, early) = self.manifest(&mut form).await?;
        if manifest.len() > limits.max_batch_parts {
            return Err(too_many_parts(limits.max_batch_parts));
        }
        let mut lines: HashMap<&str, Vec<&ManifestLine>> = HashMap::new();
        for line in &manifest {
            lines.entry(&line.file).or_default().push(line);
        }
        let mut answer = BatchBody::default();
        let mut received = HashSet::new();
        for (name, read) in early {
            self.form_file(&name, &read, &lines, &mut answer).await?;
            received.insert(name);
        }
        while let Some((name, part)) = form.next().await? {
            let read = part.read(limits.max_body_bytes).await?;
            self.form_file(&name, &read, &lines, &mut answer).await?;
            received.insert(name);
        }
        for line in manifest.iter().filter(|line| !received.contains(&line.file)) {
            let problem = Problem::field("/manifest", format!("the form has no part named {:?}", line.file));
            answer.note(line.file.clone(), Err(problem))?;
        }
        Ok(answer)
    }

    /// The manifest of a form, and the files that come before it: at most as much as one body.
    async fn manifest(
        &self,
        form: &mut Form,
    ) -> Result<(Vec<ManifestLine>, Vec<(String, FileBytes)>), Problem> {
        let max_bytes = self.service.limits.max_body_bytes;
        let (mut early, mut early_bytes) = (Vec::new(), 0);
        while let Some((name, part)) = form.next().await? {
            if name == "manifest" {
                return Ok((from_json(&part.read(MAX_JSON_BYTES).await??)?, early));
            }
            let read = part.read(max_bytes).await?;
            early_bytes += read.as_ref().map_or(0, |bytes| bytes.len() as u64);
            if early_bytes > max_bytes {
                let text = "too much comes before the part called manifest: send that first";
                return Err(Problem::new(Code::BodyTooLarge, text));
            }
            early.push((name, read));
        }
        Err(Problem::field("/manifest", "the form has no part called manifest"))
    }

    /// Keeps one file part under every line of the manifest that names it.
    async fn form_file(
        &self,
        name: &str,
        read: &FileBytes,
        lines: &HashMap<&str, Vec<&ManifestLine>>,
        answer: &mut BatchBody,
    ) -> Result<(), Problem> {
        let Some(lines) = lines.get(name) else {
            let problem = Problem::field("/manifest", format!("no line names the part {name:?}"));
            return answer.note(name.into(), Err(problem));
        };
        for line in lines {
            let outcome = match read.clone() {
                Ok(bytes) => {
                    let ManifestLine { pose, camera, size_mm, .. } = (*line).clone();
                    let survey = SurveyIn { pose, camera, size_mm };
                    self.keep(line.label.as_deref(), line.negative, line.pose_deg, survey, bytes).await
                }
                Err(problem) => Err(problem),
            };
            answer.note(name.into(), outcome)?;
        }
        Ok(())
    }

    async fn tar(&self, request: Request) -> Result<BatchBody, Problem> {
        let limits = &self.service.limits;
        let (parts, body) = request.into_parts();
        let body = body::limited(&parts.headers, body, limits.max_batch_bytes)?;
        let _share = self.service.bodies.admit(&HeaderMap::new(), limits.max_body_bytes)?;
        let mut archive = Archive::new(StreamReader::new(body.into_data_stream().map_err(io::Error::other)));
        // Raw entries: long names come as entries of their own, which are read here under a limit.
        let mut entries = archive.entries_raw().map_err(|error| self.broken_archive(&error))?;
        let mut long_name = None;
        let (mut answer, mut table) = (BatchBody::default(), PoseTable::new(limits.max_batch_parts));
        while let Some(entry) = body::in_time(limits.body_timeout, entries.next()).await? {
            let mut entry = entry.map_err(|error| self.broken_archive(&error))?;
            let kind = entry.header().entry_type();
            if kind.is_gnu_longname() || kind.is_pax_local_extensions() {
                long_name = self.long_name(&mut entry).await?.or(long_name);
                continue;
            }
            let name = long_name.take();
            if kind.is_file() {
                self.tar_file(&mut entry, name, &mut table, &mut answer).await?;
            }
        }
        self.survey_rest(table, &mut answer).await?;
        Ok(answer)
    }

    /// What the table says of pictures that came before it, or of none.
    async fn survey_rest(&self, table: PoseTable, answer: &mut BatchBody) -> Result<(), Problem> {
        let kept = answer.items.iter().filter_map(|item| Some((PathBuf::from(&item.file), item.id?)));
        let kept: HashMap<PathBuf, Uuid> = kept.map(|(file, id)| (pose_table::plain(&file), id)).collect();
        let rejected: HashSet<PathBuf> = (answer.items.iter().filter(|item| item.id.is_none()))
            .map(|item| pose_table::plain(FilePath::new(&item.file)))
            .collect();
        for (file, survey) in table.rest() {
            let outcome = match kept.get(&file) {
                Some(id) => self.survey(*id, survey).await,
                // what is wrong with the picture is said already
                None if rejected.contains(&file) => Ok(()),
                None => Err(Problem::field("/file", format!("{FILE_NAME} names a picture that isn't there"))),
            };
            if let Err(problem) = outcome {
                answer.note(file.to_string_lossy().into_owned(), Err(problem))?;
            }
        }
        Ok(())
    }

    async fn long_name<R: AsyncRead + Unpin>(&self, entry: &mut Entry<R>) -> Result<Option<String>, Problem> {
        let bytes = self.entry_bytes(entry, MAX_TAR_NAME_BYTES).await?;
        let too_long = || Problem::new(Code::MalformedRequest, "the archive has a file name of over 64 KiB");
        let bytes = bytes.ok_or_else(too_long)?;
        let is_gnu = entry.header().entry_type().is_gnu_longname();
        Ok(if is_gnu { gnu_name(&bytes) } else { pax_name(&bytes) })
    }

    /// Keeps the file of an entry; `name` is the long name that came before it.
    async fn tar_file<R: AsyncRead + Unpin>(
        &self,
        entry: &mut Entry<R>,
        name: Option<String>,
        table: &mut PoseTable,
        answer: &mut BatchBody,
    ) -> Result<(), Problem> {
        let limits = &self.service.limits;
        if answer.items.len() >= limits.max_batch_parts {
            return Err(too_many_parts(limits.max_batch_parts));
        }
        let path = match name {
            Some(name) => PathBuf::from(name),
            None => entry.path().map_err(|error| self.broken_archive(&error))?.into_owned(),
        };
        let file = path.to_string_lossy().into_owned();
        if path.file_name().is_some_and(|name| name == FILE_NAME) {
            let read = match self.entry_bytes(entry, MAX_TABLE_BYTES).await? {
                Some(bytes) => table.read(&path, &bytes),
                None => Err(body::too_large(MAX_TABLE_BYTES)),
            };
            return read.or_else(|problem| answer.note(file, Err(problem)));
        }
        let Some((label, pose_deg)) = label_and_pose(&path) else {
            let problem = Problem::field("/file", format!("{file:?} is not <label>/<picture>"));
            return answer.note(file, Err(problem));
        };
        let is_negative = |folder: &FilePath| folder.iter().any(|name| name == NEGATIVE_FOLDER);
        let negative = path.parent().is_some_and(is_negative);
        let (label, pose_deg) = (Some(label).filter(|_| !negative), pose_deg.filter(|_| !negative));
        let outcome = match self.entry_bytes(entry, limits.max_body_bytes).await? {
            Some(bytes) => self.keep(label.as_deref(), negative, pose_deg, table.take(&path), bytes).await,
            None => Err(body::too_large(limits.max_body_bytes)),
        };
        answer.note(file, outcome)
    }

    /// The bytes of an entry; none when it is larger than that.
    async fn entry_bytes<R: AsyncRead + Unpin>(
        &self,
        entry: &mut Entry<R>,
        max_bytes: u64,
    ) -> Result<Option<Bytes>, Problem> {
        let read = body::in_time(self.service.limits.body_timeout, read_entry(entry, max_bytes)).await?;
        read.map_err(|error| self.broken_archive(&error))
    }

    fn broken_archive(&self, error: &io::Error) -> Problem {
        if body::is_over_limit(error) {
            return body::too_large(self.service.limits.max_batch_bytes);
        }
        let text = format!(
            "the archive can't be read: {error}; it must be an uncompressed tar. Files before the fault are kept"
        );
        Problem::new(Code::MalformedRequest, text)
    }
}

/// The folder of pictures that show nothing known; no label begins so.
const NEGATIVE_FOLDER: &str = "_negative";

/// Largest table of poses: some thirty thousand lines.
const MAX_TABLE_BYTES: u64 = 4 << 20;
/// Longest file name in an archive.
const MAX_TAR_NAME_BYTES: u64 = 64 << 10;

/// The name in a GNU long name entry: up to its closing zero.
fn gnu_name(bytes: &[u8]) -> Option<String> {
    let name = bytes.split(|&byte| byte == 0).next()?;
    String::from_utf8(name.to_vec()).ok()
}

/// The name in a pax header: lines of `<length> <key>=<value>`.
fn pax_name(bytes: &[u8]) -> Option<String> {
    // The last one counts.
    let mut lines = bytes.rsplit(|&byte| byte == b'\n').filter_map(|line| std::str::from_utf8(line).ok());
    lines.find_map(|line| line.split_once(' ')?.1.strip_prefix("path=")).map(str::to_owned)
}

async fn read_entry<R: AsyncRead + Unpin>(entry: &mut Entry<R>, max_bytes: u64) -> io::Result<Option<Bytes>> {
    if entry.effective_size() > max_bytes {
        return Ok(None);
    }
    let mut bytes = Vec::new();
    entry.take(max_bytes + 1).read_to_end(&mut bytes).await?;
    Ok((bytes.len() as u64 <= max_bytes).then(|| bytes.into()))
}

/// `<label>/<anything>.<ext>`, with the pose of a leaf name `…__<degrees>.<ext>`. Folders above the label don't count.
fn label_and_pose(path: &FilePath) -> Option<(String, Option<f64>)> {
    let label = path.parent()?.file_name()?.to_str()?.to_owned();
    let stem = path.file_stem()?.to_str()?;
    let pose = stem.rsplit_once("__").and_then(|(_, degrees)| degrees.parse().ok());
    Some((label, pose.filter(|pose: &f64| pose.is_finite())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_read_from_both_dialects() {
        assert_eq!(gnu_name(b"cup/long.png\0rest").as_deref(), Some("cup/long.png"));
        assert_eq!(pax_name(b"20 mtime=1.5\n21 path=cup/\xc3\xa4.png\n").as_deref(), Some("cup/\u{e4}.png"));
        assert_eq!(pax_name(b"20 mtime=1.5\n"), None);
    }

    #[test]
    fn a_path_in_an_archive_gives_label_and_pose() {
        let read = |path: &str| label_and_pose(FilePath::new(path));
        assert_eq!(read("cup/a__12.5.png"), Some(("cup".into(), Some(12.5))));
        assert_eq!(read("./train/cup/obj1__0.png"), Some(("cup".into(), Some(0.0))));
        assert_eq!(read("cup/front.jpg"), Some(("cup".into(), None)));
        assert_eq!(read("cup/front__left.jpg"), Some(("cup".into(), None)));
        assert_eq!(read("front.jpg"), None);
        assert_eq!(read("cup/a__inf.png"), Some(("cup".into(), None)));
    }
}
