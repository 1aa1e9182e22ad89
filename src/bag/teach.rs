//! The verb `teach`: the pictures of bags become exemplars of a database, with their poses and the camera's intrinsics, and
//! the database is trained.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use landmarkd_core::geometry::MapPose;
use reqwest::Method;
use reqwest::multipart::{Form, Part};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::contents::{BagArgs, Contents};
use super::labels::{LabelArgs, Labels};
use super::selection::{Chosen, LeftOut, Selection, SelectionArgs};
use super::{BagError, bar_of, read_ahead, read_once};
use crate::client::Server;
use crate::database::Name;
use crate::database::survey::{CameraDocument, MapPoseDocument, Survey};
use crate::evaluate::read_pair;

/// Pictures and bytes of one call: a call is answered within seconds, and what it brought is kept.
const BATCH_PICTURES: usize = 32;
const BATCH_BYTES: usize = 16 << 20;

/// Arguments of `landmarkd teach`, but for those of the service.
#[derive(Args, Clone, Debug)]
pub struct TeachArgs {
    /// Bags: MCAP files of ROS 2, or folders of such
    #[arg(value_name = "BAG", required = true)]
    pub bags: Vec<PathBuf>,
    /// The database; one that isn't there is made, of kind landmarks, for a camera that stays upright
    #[arg(long, value_name = "NAME")]
    pub database: String,
    /// An option of a database that is made, as in PUT /v1/databases: --option interest_points=128 (may be repeated)
    #[arg(long = "option", value_name = "NAME=VALUE")]
    pub options: Vec<String>,
    /// Where their pictures and poses are.
    #[command(flatten)]
    pub bag: BagArgs,
    /// How the pictures are labelled.
    #[command(flatten)]
    pub labels: LabelArgs,
    /// What is left out.
    #[command(flatten)]
    pub selection: SelectionArgs,
}

/// What became of the pictures.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TeachSummary {
    /// Pictures that were new.
    pub created: usize,
    /// Pictures that were there.
    pub duplicates: usize,
    /// Pictures that the service refused.
    pub rejected: usize,
    /// The version that was trained.
    pub version: u64,
}

/// The answer to a batch.
#[derive(Deserialize)]
struct BatchAnswer {
    created: usize,
    duplicates: usize,
    items: Vec<BatchItem>,
}

#[derive(Deserialize)]
struct BatchItem {
    file: String,
    problem: Option<Value>,
}

/// A version's report, as far as it is told.
#[derive(Deserialize)]
struct Version {
    report: Report,
}

#[derive(Deserialize)]
struct Report {
    verdict: Option<Verdict>,
}

#[derive(Deserialize)]
struct Verdict {
    summary: String,
    remedy: Option<String>,
}

/// Sends what is worth teaching, trains, and prints how it went.
///
/// # Errors
/// [`BagError`]. What was sent before is kept, and isn't sent twice.
pub async fn teach(server: &Server, args: &TeachArgs, out: &mut dyn Write) -> Result<TeachSummary, BagError> {
    let database = name_of(&args.database)?;
    let mut bags = Vec::new();
    for bag in &args.bags {
        let contents = read_once(bag, &args.bag, out)?;
        let labels = Labels::of(&args.labels, &database, contents.has_poses())?;
        bags.push((bag, Arc::new(contents), labels));
    }
    make_database(server, &database, &args.options).await?;
    let mut summary = TeachSummary::default();
    for (bag, contents, labels) in bags {
        teach_bag(server, args, (bag, &contents, labels), &mut summary, out).await?;
    }
    let TeachSummary { created, duplicates, rejected, .. } = summary;
    writeln!(
        out,
        "{database}: {created} pictures sent, {duplicates} were there, {rejected} refused; training"
    )?;
    summary.version = server.train(database.as_str(), &json!({})).await?;
    let number = summary.version.to_string();
    let version: Option<Version> =
        server.find(&["databases", database.as_str(), "versions", &number]).await?;
    match version.and_then(|version| version.report.verdict) {
        Some(Verdict { summary, remedy }) => {
            writeln!(out, "{database}: version {number}: {summary}")?;
            if let Some(remedy) = remedy {
                writeln!(out, "  {remedy}")?;
            }
        }
        None => writeln!(out, "{database}: version {number}")?,
    }
    Ok(summary)
}

/// The name of a database.
pub fn name_of(database: &str) -> Result<Name, BagError> {
    let wrong = |error| BagError::Name {
        what: "the database",
        name: database.to_owned(),
        reason: format!("{error}"),
    };
    Name::parse(database).map_err(wrong)
}

/// Makes the database if it isn't there.
async fn make_database(server: &Server, database: &Name, options: &[String]) -> Result<(), BagError> {
    let path = ["databases", database.as_str()];
    if let Some(there) = server.find::<Value>(&path).await? {
        return landmarks_only(database, &there);
    }
    let mut given = Map::from_iter([("viewpoint".to_owned(), json!("upright"))]);
    for pair in options {
        let (option, value) = read_pair(pair).ok_or_else(|| BagError::Name {
            what: "--option",
            name: pair.clone(),
            reason: "is not NAME=VALUE".to_owned(),
        })?;
        given.insert(option.to_owned(), value);
    }
    Ok(server.create(&path, &json!({"kind": "landmarks", "options": given})).await?)
}

/// Refuses databases of another kind.
pub fn landmarks_only(database: &Name, document: &Value) -> Result<(), BagError> {
    match document["kind"].as_str() {
        Some("landmarks") => Ok(()),
        kind => Err(BagError::Name {
            what: "the database",
            name: database.to_string(),
            reason: format!("is of kind {}: bags are for landmarks", kind.unwrap_or("unknown")),
        }),
    }
}

/// Sends what is worth teaching of one bag, and prints what was left out.
async fn teach_bag(
    server: &Server,
    args: &TeachArgs,
    (bag, contents, labels): (&Path, &Arc<Contents>, Labels),
    summary: &mut TeachSummary,
    out: &mut dyn Write,
) -> Result<(), BagError> {
    let selection = Selection::new(&args.selection, labels);
    let (mut pictures, reading) =
        read_ahead(contents, selection, |selection, picture, read_bytes| match picture {
            Some(picture) => Vec::from_iter(selection.next(picture, read_bytes)),
            None => selection.rest(),
        });
    let bar = bar_of(contents.bytes());
    let mut batch = Batch::default();
    let mut sent = 0;
    while let Some(picture) = pictures.recv().await {
        bar.set_position(picture.read_bytes);
        batch.add(picture, contents);
        if batch.is_full() {
            sent += std::mem::take(&mut batch).send(server, &args.database, summary, out).await?;
            bar.set_message(format!("{sent} sent"));
        }
    }
    if !batch.lines.is_empty() {
        sent += batch.send(server, &args.database, summary, out).await?;
    }
    bar.finish_and_clear();
    let left_out = reading.await.expect("reading doesn't panic")?.left_out;
    let LeftOut { without_pose, near_duplicates, blurred, unreadable, first_reason } = left_out;
    writeln!(
        out,
        "{}: {sent} pictures taught; left out: {near_duplicates} near-duplicates, {blurred} blurred, {without_pose} without a pose, \
         {unreadable} that can't be read",
        bag.display()
    )?;
    if let Some(reason) = &first_reason {
        writeln!(out, "  can't be read: {reason}")?;
    }
    if without_pose > 0
        && let Some(trouble) = contents.pose_trouble()
    {
        writeln!(out, "  without a pose: {trouble}")?;
    }
    if sent == 0 {
        let reason = first_reason.or_else(|| contents.pose_trouble());
        return Err(BagError::NoPictures {
            topic: contents.image_topic.clone(),
            reason: reason.unwrap_or_else(|| format!("{without_pose} have no pose, {blurred} are blurred")),
        });
    }
    Ok(())
}

/// Refused pictures that are told of one by one.
const MOST_TOLD: usize = 5;

/// A line of the manifest of a batch.
#[derive(Serialize)]
struct ManifestLine {
    file: String,
    label: String,
    #[serde(flatten)]
    survey: Survey,
}

/// The pictures of one call.
#[derive(Default)]
struct Batch {
    lines: Vec<ManifestLine>,
    files: Vec<(String, Vec<u8>)>,
    bytes: usize,
}

impl Batch {
    fn add(&mut self, picture: Chosen, contents: &Contents) {
        let Chosen { stamp_ns, label, file, pose, .. } = picture;
        let name =
            format!("{}.{:09}", stamp_ns.div_euclid(1_000_000_000), stamp_ns.rem_euclid(1_000_000_000));
        let pose = pose.map(|pose| document_of(&pose, &contents.map));
        let camera = contents.camera.as_ref().filter(|_| pose.is_some()).map(CameraDocument::from);
        let survey = Survey { pose, camera, size_mm: None };
        self.bytes += file.len();
        self.lines.push(ManifestLine { file: name.clone(), label, survey });
        self.files.push((name, file));
    }

    fn is_full(&self) -> bool {
        self.lines.len() >= BATCH_PICTURES || self.bytes >= BATCH_BYTES
    }

    /// Sends it, adds to the summary what became of it, and prints why pictures were refused. Returns how many it had.
    async fn send(
        self,
        server: &Server,
        database: &str,
        summary: &mut TeachSummary,
        out: &mut dyn Write,
    ) -> Result<usize, BagError> {
        let mut form = Form::new().text("manifest", json!(self.lines).to_string());
        for (name, file) in self.files {
            form = form.part(name.clone(), Part::bytes(file).file_name(name));
        }
        let path = ["databases", database, "exemplars:batch"];
        let answer: BatchAnswer = server.json(server.call(Method::POST, &path, &[]).multipart(form)).await?;
        summary.created += answer.created;
        summary.duplicates += answer.duplicates;
        for item in &answer.items {
            let Some(problem) = &item.problem else { continue };
            summary.rejected += 1;
            if summary.rejected <= MOST_TOLD {
                let detail = problem["detail"].as_str().unwrap_or("without a reason");
                writeln!(out, "  refused: {}: {detail}", item.file)?;
            }
        }
        Ok(answer.items.len())
    }
}

/// A pose as the wire has it.
fn document_of(pose: &MapPose, map: &Name) -> MapPoseDocument {
    let MapPose { x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg } = *pose;
    let (map, sigma_m) = (map.clone(), MapPoseDocument::DEFAULT_SIGMA_M);
    MapPoseDocument { map, x_m, y_m, z_m, yaw_deg, pitch_deg, roll_deg, sigma_m }
}
