//! The verb `demo`: trains on pictures, recognises disturbed views of them and prints how it went; all through the HTTP
//! contract of a running service, as a robot would.
//!
//! Without a folder of the user's pictures the demo draws rooms and objects itself (`drawing`, `rooms`, `objects`,
//! `data_sets`), and things on a turntable (`turntable`, `poses`), measures scenes of known depth (`depth`), and last
//! inspects a table with things on it (`table`, `inspection`). Databases called `demo-…` and the workcell `demo` are the
//! demo's: each run makes them anew.

mod client;
mod data_sets;
mod depth;
mod drawing;
mod files;
mod inspection;
mod objects;
mod own_pictures;
mod poses;
mod rooms;
mod table;
mod turntable;

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};
use thiserror::Error;

use crate::client::{ClientError, Server};
use crate::evaluate::{EvaluateError, Rate};
use data_sets::{DataSet, Exemplar, Query, object_data_set, room_data_set};
use files::{replace_folder, write_file};
use own_pictures::own_data_set;

pub use depth::MeasuredScene;
pub use inspection::{InspectionSummary, PlaceErrors};
pub use poses::PoseSummary;

/// Arguments of `landmarkd demo`.
#[derive(Args, Clone, Debug)]
pub struct DemoArgs {
    /// Learn your own pictures DIR/<label>/* instead, and tell how well they are known when turned and covered
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,
    /// End after the table instead of serving on
    #[arg(long)]
    pub exit: bool,
}

/// Why the demo stopped.
#[derive(Debug, Error)]
pub enum DemoError {
    /// A call went wrong.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The user's folder can't be listed.
    #[error("the folder of pictures can't be used")]
    Pictures {
        /// The cause.
        source: EvaluateError,
    },
    /// No picture of the user's folder can be used.
    #[error("no picture in {} could be learned", .path.display())]
    NothingLearned {
        /// The file or folder.
        path: PathBuf,
    },
    /// The service's depth map isn't one of the scene.
    #[error("the service sent no depth map of {scene}")]
    NoMap {
        /// The name of the scene.
        scene: &'static str,
    },
    /// A file can't be written.
    #[error("can't write {}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The output can't be written.
    #[error("can't print")]
    Print(#[from] io::Error),
}

/// How the demo went.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoSummary {
    /// All queries; a thing that no version was trained on is answered right by "unknown".
    pub right: Rate,
    /// By database and kind of view.
    pub by_view: Vec<(String, Rate)>,
    /// `None` with pictures of the user's own.
    pub drawn: Option<DrawnSummary>,
    /// The folder of the pictures.
    pub pictures_dir: PathBuf,
}

/// How the parts went that only drawn pictures have.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnSummary {
    /// The things on the turntable.
    pub poses: PoseSummary,
    /// The scenes whose depth was measured.
    pub depth: Vec<MeasuredScene>,
    /// The parts on the table.
    pub inspection: InspectionSummary,
}

/// Trains, recognises, prints; the pictures and an annotated answer of each database go to `pictures_dir`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, or a picture can't be written. Wrong answers are no
/// error: they are printed.
pub async fn run(
    base_url: &str,
    args: &DemoArgs,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<DemoSummary, DemoError> {
    let server = Server::at(base_url, None, None)?;
    let sets = match &args.images {
        Some(folder) => vec![own_pictures(folder, out)?],
        None => vec![room_data_set(), object_data_set()],
    };
    let mut by_view = Vec::new();
    let mut example = None;
    for set in &sets {
        let rates;
        (rates, example) = landmarks(&server, set, pictures_dir, out).await?;
        by_view.extend(rates);
    }
    let drawn = match args.images {
        Some(_) => None,
        None => Some(drawn(&server, pictures_dir, out).await?),
    };
    by_view.extend(drawn.iter().flat_map(DrawnSummary::by_view));
    let sum = |count: fn(&Rate) -> usize| by_view.iter().map(|(_, rate)| count(rate)).sum();
    let right = Rate::of(sum(|rate| rate.hits), sum(|rate| rate.trials));
    let summary = DemoSummary { right, by_view, drawn, pictures_dir: pictures_dir.to_path_buf() };

    summary.print(out)?;
    if let (false, Some(set), Some(file)) = (args.exit, sets.last(), example) {
        let base_url = base_url.trim_end_matches('/');
        print_pages(base_url, set.database, &summary, out)?;
        print_calls(base_url, set.database, &file, out)?;
        if let Some(scene) = summary.drawn.as_ref().and_then(|drawn| drawn.depth.last()) {
            depth::print_calls(base_url, pictures_dir, scene, out)?;
            inspection::print_calls(base_url, pictures_dir, out)?;
        }
    }
    Ok(summary)
}

/// The data set of the user's folder; prints which files are left out.
fn own_pictures(folder: &Path, out: &mut dyn Write) -> Result<DataSet, DemoError> {
    let (set, left_out) = own_data_set(folder)?;
    for reason in left_out {
        writeln!(out, "left out: {reason}")?;
    }
    Ok(set)
}

/// Trains on a data set and asks its queries. Returns the rates by view, and the file of the last query.
async fn landmarks(
    server: &Server,
    set: &DataSet,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<(Vec<(String, Rate)>, Option<PathBuf>), DemoError> {
    let folder = pictures_dir.join(set.database);
    let named = |n: usize, label: Option<&String>| format!("{n:03}-{}.png", label.map_or("strange", |l| l));
    let learned = set.exemplars.iter().enumerate().map(|(n, e)| (named(n, Some(&e.label)), &e.png));
    let asked = set.queries.iter().enumerate().map(|(n, q)| (named(n, q.label.as_ref()), &q.png));
    replace_folder(&folder.join("learned"), learned)?;
    let example = replace_folder(&folder.join("asked"), asked)?.pop();
    let version = train(server, set.database, &json!({"kind": "landmarks"}), &set.exemplars, out).await?;
    let rates = recognise(server, set, version, out).await?;
    if let Some(query) = set.queries.last() {
        write_file(&folder.join("annotated.png"), &server.annotated(set.database, &query.png).await?)?;
    }
    let rates = rates.into_iter().map(|(view, rate)| (format!("{}: {view}", set.database), rate));
    Ok((rates.collect(), example))
}

/// Poses on the turntable, depths, and the inspection of a table.
async fn drawn(server: &Server, pictures_dir: &Path, out: &mut dyn Write) -> Result<DrawnSummary, DemoError> {
    Ok(DrawnSummary {
        poses: poses::show(server, pictures_dir, out).await?,
        depth: depth::show(server, pictures_dir, out).await?,
        inspection: inspection::show(server, pictures_dir, out).await?,
    })
}

/// Creates the database anew, sends its pictures and trains; returns the version.
async fn train(
    server: &Server,
    database: &str,
    document: &Value,
    exemplars: &[Exemplar],
    out: &mut dyn Write,
) -> Result<u64, DemoError> {
    server.delete(&["databases", database]).await?;
    server.create(&["databases", database], document).await?;
    for exemplar in exemplars {
        server.add_exemplar(database, exemplar).await?;
    }
    let started = Instant::now();
    let version = server.train(database, &json!({})).await?;
    let took_s = started.elapsed().as_secs_f64();
    let count = exemplars.len();
    writeln!(out, "\n{database}: {count} pictures learned as version {version} in {took_s:.2} s")?;
    Ok(version)
}

/// More rows than this are more than anyone reads: then the wrong answers only.
const MOST_ROWS: usize = 60;

/// Asks every query, prints the answers, counts the right ones by view.
async fn recognise(
    server: &Server,
    set: &DataSet,
    version: u64,
    out: &mut dyn Write,
) -> Result<BTreeMap<String, Rate>, DemoError> {
    let all = set.queries.len() <= MOST_ROWS;
    if !all {
        writeln!(out, "of {} answers only wrong ones are listed:", set.queries.len())?;
    }
    writeln!(out, "  {:<28}{:<20}{:<20}{:>10}{:>8}", "view", "shown", "answered", "confidence", "ms")?;
    let mut answers: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for Query { view, label, png } in &set.queries {
        let answer = server.recognise(set.database, version, png).await?;
        let right = answer.label() == label.as_deref();
        answers.entry(view.clone()).or_default().push(right);
        if all || !right {
            let [shown, named] = [label.as_deref(), answer.label()].map(|label| label.unwrap_or("nothing"));
            let confidence = answer.decision.as_ref().and_then(|decision| decision.confidence);
            let sure = confidence.map_or("-".into(), |confidence| format!("{confidence:.2}"));
            let (ms, verdict) = (answer.timings_ms.recognise, verdict(right));
            writeln!(out, "  {view:<28}{shown:<20}{named:<20}{sure:>10}{ms:>8.1}  {verdict}")?;
        }
    }
    Ok(answers.into_iter().map(|(view, right)| (view, Rate::among(right))).collect())
}

fn verdict(right: bool) -> &'static str {
    if right { "right" } else { "WRONG" }
}

impl DrawnSummary {
    /// The rates of poses and inspection, by database and kind of view.
    fn by_view(&self) -> [(String, Rate); 4] {
        let DrawnSummary { poses, inspection, .. } = self;
        let (turntable, workcell) = (poses::DATABASE, inspection::DATABASE);
        [
            (format!("{turntable}: turned"), poses.named_right),
            (format!("{turntable}: never learned"), poses.unknown_refused),
            (format!("{workcell}: laid"), inspection.named_right),
            (format!("{workcell}: never learned"), inspection.unknown_refused),
        ]
    }
}

impl DemoSummary {
    fn print(&self, out: &mut dyn Write) -> Result<(), DemoError> {
        writeln!(out, "\nright in all: {}", self.right)?;
        for (view, rate) in &self.by_view {
            writeln!(out, "  {view:<44}{rate}")?;
        }
        let folder = self.pictures_dir.display();
        Ok(writeln!(out, "\npictures: {folder} (annotated.png: an answer and its evidence)")?)
    }
}

/// Prints which pages of the console to open, and the pictures to give them.
fn print_pages(
    base_url: &str,
    database: &str,
    summary: &DemoSummary,
    out: &mut dyn Write,
) -> Result<(), DemoError> {
    writeln!(out, "\nopen {base_url}/ in a browser, and click:")?;
    let mut page = |page: &str, what: &str| writeln!(out, "  {:<58}{what}", format!("{base_url}/#/{page}"));
    if summary.drawn.is_none() {
        page(&format!("try/{database}"), "drop a picture: what it is, and why")?;
        return Ok(page("", "everything that is here")?);
    }
    page("try/demo-objects", "drop a picture of demo-objects/asked: what it is, and why")?;
    page("try/demo-turntable", "drop one of demo-turntable/asked: how it is turned")?;
    page("versions/demo-turntable/1/2", "what trainings tell of themselves: two versions")?;
    page("depth", "drop near.png and far.png of a scene: how far it is")?;
    page("workcells/demo", "drop demo-workcell/table.png: where to reach")?;
    page("", "everything that is here")?;
    Ok(writeln!(out, "the pictures are in {}", summary.pictures_dir.display())?)
}

/// Prints calls with curl that ask a database about a file.
fn print_calls(base_url: &str, database: &str, file: &Path, out: &mut dyn Write) -> Result<(), DemoError> {
    let call = format!("curl --data-binary '@{}' -H 'Content-Type: image/png'", file.display());
    let url = format!("{base_url}/v1/databases/{database}/recognitions");
    Ok(writeln!(
        out,
        "\nor with curl; {base_url}/docs has every call, {base_url}/metrics counts and times.\nask:\n  {call} \\\n    '{url}?explain=true'\n\
         see the points and votes:\n  {call} \\\n    -H 'Accept: image/png' -o annotated.png '{url}'"
    )?)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use tokio::sync::oneshot;

    use super::*;
    use crate::config::{GivenSettings, Settings};
    use crate::serve::serve;

    /// Run the demo against a service of its own; returns what it printed.
    fn shown(args: &DemoArgs, folder: &Path) -> (DemoSummary, String) {
        let given = GivenSettings {
            bind: Some(([127, 0, 0, 1], 0).into()),
            data_dir: Some(folder.join("data")),
            ..GivenSettings::default()
        };
        let settings = Settings::settle(given, None).unwrap();
        tokio::runtime::Runtime::new().unwrap().block_on(async {
            let (listening, address) = oneshot::channel();
            let (stop, stopped) = oneshot::channel::<()>();
            let server = tokio::spawn(async move {
                let stopped = async { drop(stopped.await) };
                serve(&settings, |address, _| listening.send(address).unwrap(), stopped).await
            });
            let base_url = format!("http://{}", address.await.unwrap());
            let mut printed = Vec::new();
            let summary = run(&base_url, args, &folder.join("pictures"), &mut printed).await.unwrap();
            stop.send(()).unwrap();
            server.await.unwrap().unwrap();
            (summary, String::from_utf8(printed).unwrap())
        })
    }

    #[test]
    fn the_drawn_demo_is_nearly_always_right_and_keeps_its_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let (summary, printed) = shown(&DemoArgs { images: None, exit: false }, folder.path());
        assert_eq!(summary.right.trials, 105);
        assert!(summary.right.hits >= 99, "{printed}");
        let DrawnSummary { poses, depth, inspection } = summary.drawn.unwrap();
        assert_eq!((poses.named_right.trials, poses.unknown_refused.trials), (48, 12));
        assert!(poses.named_right.hits >= 46, "{printed}");
        assert!(poses.reliable.hits >= 24, "of 36: {printed}");
        let errors = poses.reliable_errors.unwrap();
        assert!(errors.median_deg <= 2.0 && errors.worst_deg <= 10.0, "{printed}");
        assert!(poses.without_pose.trials >= 11, "{printed}");
        assert_eq!(poses.without_pose.hits, poses.without_pose.trials, "{printed}");
        assert!(poses.unknown_refused.hits >= 11, "{printed}");
        assert!(printed.contains("the truck turned by"), "{printed}");
        for scene in &depth {
            let step = scene.scene.contains("ball");
            let errors = &scene.errors;
            assert!(
                errors.rms_percent < if step { 1.5 } else { 1.2 } && errors.median_abs_percent < 0.8,
                "{printed}"
            );
            assert!(scene.coverage > if step { 0.6 } else { 0.8 }, "{printed}");
        }
        assert_eq!(depth.len(), 3);
        assert_eq!((inspection.found, inspection.named_right), (Rate::of(5, 5), Rate::of(4, 4)), "{printed}");
        assert_eq!(inspection.unknown_refused, Rate::of(1, 1), "{printed}");
        let (turns, places) = (inspection.turn_errors.unwrap(), inspection.place_errors.unwrap());
        assert!(turns.trials == 3 && turns.worst_deg <= 2.0, "{printed}");
        assert!(places.trials == 5 && places.worst_mm <= 0.5, "{printed}");
        let [before, once, twice] = inspection.centring_px[..] else { panic!("{printed}") };
        assert!(before > 25.0 && once < 3.0 && twice < 1.0 && inspection.centred, "{printed}");
        assert!(printed.contains("preview=turbo") && printed.contains("/v1/workcells/demo/"), "{printed}");
        assert!(printed.contains("/docs") && printed.contains("curl --data-binary"), "{printed}");
        assert!(
            printed.contains("/#/try/demo-objects") && printed.contains("/#/workcells/demo"),
            "{printed}"
        );
        for database in ["demo-rooms", "demo-objects", "demo-turntable", "demo-workcell"] {
            let annotated = fs::read(summary.pictures_dir.join(database).join("annotated.png")).unwrap();
            assert!(annotated.starts_with(b"\x89PNG"), "{database}");
        }
    }

    #[test]
    fn own_pictures_are_trained_on_and_asked_about_and_a_second_run_starts_anew() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("own");
        for exemplar in object_data_set().exemplars.into_iter().take(3) {
            let label = own.join(&exemplar.label);
            fs::create_dir_all(&label).unwrap();
            fs::write(label.join("a.png"), exemplar.png).unwrap();
        }
        let args = DemoArgs { images: Some(own.clone()), exit: true };
        let (summary, printed) = shown(&args, folder.path());
        assert_eq!(summary.right.trials, 12);
        assert!(summary.right.hits >= 10, "{printed}");
        assert!(summary.drawn.is_none());
        assert!(!printed.contains("curl"), "nothing is left to be called: {printed}");
        fs::remove_dir_all(own.join("mug")).unwrap();
        assert_eq!(shown(&args, folder.path()).0.right.trials, 8);
    }
}
