//! The verb `demo`: learn pictures, ask about disturbed views of them, tell how it went; all through the HTTP
//! contract of a running service, as a robot would.
//!
//! Without a folder of its own pictures the demo draws rooms and objects itself (`drawing`, `rooms`, `objects`,
//! `lessons`), and things on a turntable (`turntable`, `turning`), measures scenes of known depth (`distances`), and
//! last inspects a table with things on it (`table`, `inspecting`). Databases called `demo-…` and the workcell `demo`
//! are the demo's: each run makes them anew.

mod client;
mod distances;
mod drawing;
mod inspecting;
mod lessons;
mod objects;
mod own_pictures;
mod rooms;
mod table;
mod turning;
mod turntable;

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};
use thiserror::Error;

use crate::evaluate::{EvaluateError, Rate};
use client::Server;
use lessons::{Exemplar, Lesson, Question, object_lesson, room_lesson};
use own_pictures::own_lesson;

pub use distances::MeasuredScene;
pub use inspecting::{InspectingSummary, PlaceErrors};
pub use turning::TurningSummary;

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
    #[error("{base_url} is no address of a service")]
    Address { base_url: String },
    #[error("no answer to {call}")]
    NoAnswer { call: String, source: reqwest::Error },
    #[error("the service refused {call}: {detail} (status {status})")]
    Refused { call: String, status: u16, detail: String },
    #[error("the training failed: {detail}")]
    Training { detail: String },
    #[error("the training did not end within {waited_s} s; the job is {job}")]
    Endless { job: String, waited_s: u64 },
    #[error("the folder of pictures can't be used")]
    Pictures { source: EvaluateError },
    #[error("no picture in {} could be learned", .path.display())]
    NothingLearned { path: PathBuf },
    #[error("the service sent no depth map of {scene}")]
    NoMap { scene: &'static str },
    #[error("can't write {}", .path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("can't print")]
    Print(#[from] io::Error),
}

/// How the demo went.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoSummary {
    /// All questions; a thing that was never learned is answered right by being refused.
    pub right: Rate,
    /// By database and kind of view.
    pub by_view: Vec<(String, Rate)>,
    /// The things on the turntable; `None` with pictures of the user's own.
    pub turning: Option<TurningSummary>,
    /// The scenes whose depth was measured; none with pictures of the user's own.
    pub measured: Vec<MeasuredScene>,
    /// The parts on the table; `None` with pictures of the user's own.
    pub inspecting: Option<InspectingSummary>,
    /// Where the pictures are.
    pub pictures_dir: PathBuf,
}

/// Learn, ask, print; the pictures and an annotated answer of each database go to `pictures_dir`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, or a picture can't be written. Wrong answers are no
/// error: they are told.
pub async fn run(
    base_url: &str,
    args: &DemoArgs,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<DemoSummary, DemoError> {
    let server = Server::at(base_url)?;
    let lessons = match &args.images {
        Some(folder) => {
            let (lesson, left_out) = own_lesson(folder)?;
            for reason in left_out {
                writeln!(out, "left out: {reason}")?;
            }
            vec![lesson]
        }
        None => vec![room_lesson(), object_lesson()],
    };

    let mut by_view = Vec::new();
    let mut shown = None;
    for lesson in &lessons {
        let folder = pictures_dir.join(lesson.database);
        let files = keep(&folder, lesson)?;
        let version =
            teach(&server, lesson.database, &json!({"kind": "landmarks"}), &lesson.exemplars, out).await?;
        let rates = examine(&server, lesson, version, out).await?;
        by_view.extend(rates.into_iter().map(|(view, rate)| (format!("{}: {view}", lesson.database), rate)));
        if let (Some(question), Some(file)) = (lesson.questions.last(), files.last()) {
            let annotated = server.annotated(lesson.database, &question.png).await?;
            write_file(&folder.join("annotated.png"), &annotated)?;
            shown = Some((lesson.database, file.clone()));
        }
    }
    let turning = match args.images {
        Some(_) => None,
        None => Some(turn(&server, &pictures_dir.join(turning::DATABASE), out).await?),
    };
    let measured = match args.images {
        Some(_) => Vec::new(),
        None => distances::measure(&server, &pictures_dir.join(distances::FOLDER), out).await?,
    };
    let inspecting = match args.images {
        Some(_) => None,
        None => Some(inspect(&server, &pictures_dir.join(inspecting::DATABASE), out).await?),
    };
    let turned = turning.iter().map(|s| (turning::DATABASE, "turned", s.named_right, s.strange_refused));
    let laid = inspecting.iter().map(|s| (inspecting::DATABASE, "laid", s.named_right, s.strange_refused));
    for (database, view, named_right, strange_refused) in turned.chain(laid) {
        let rates = [(view, named_right), ("never learned", strange_refused)];
        by_view.extend(rates.map(|(view, rate)| (format!("{database}: {view}"), rate)));
    }

    let right = by_view
        .iter()
        .fold(Rate::of(0, 0), |sum, (_, rate)| Rate::of(sum.hits + rate.hits, sum.trials + rate.trials));
    writeln!(out, "\nright in all: {right}")?;
    for (view, rate) in &by_view {
        writeln!(out, "  {view:<44}{rate}")?;
    }
    writeln!(out, "\npictures: {} (annotated.png: an answer and its evidence)", pictures_dir.display())?;
    if let (false, Some((database, file))) = (args.exit, shown) {
        clicks(base_url, database, pictures_dir, args.images.is_none(), out)?;
        directions(base_url, database, &file, out)?;
        if let Some(scene) = measured.last() {
            distances::directions(base_url, &pictures_dir.join(distances::FOLDER), scene, out)?;
        }
        if inspecting.is_some() {
            inspecting::directions(base_url, &pictures_dir.join(inspecting::DATABASE), out)?;
        }
    }
    let pictures_dir = pictures_dir.to_path_buf();
    Ok(DemoSummary { right, by_view, turning, measured, inspecting, pictures_dir })
}

/// Things on the turntable: learn, ask, print, and keep all pictures so that `evaluate` can take them too.
async fn turn(server: &Server, folder: &Path, out: &mut dyn Write) -> Result<TurningSummary, DemoError> {
    let (views, questions) = (turning::views(), turning::questions());
    let named = |label: &str, turn_deg: f64| format!("{label}/turned__{turn_deg}.png");
    let learned = views.iter().map(|view| (named(&view.label, view.pose_deg.unwrap_or_default()), &view.png));
    let asked = questions.iter().map(|question| (named(question.shown, question.turn_deg), &question.png));
    keep_in(&folder.join("learned"), learned)?;
    keep_in(&folder.join("asked"), asked)?;
    let version = teach(server, turning::DATABASE, &json!({"kind": "objects"}), &views, out).await?;
    // For comparison: what the console shows of two versions.
    let small = json!({"options": {"dimension": 6}, "promote": "never"});
    server.train(turning::DATABASE, &small).await?;
    let summary = turning::examine(server, version, &questions, out).await?;
    if let Some(question) = turning::example(&questions).map(|n| &questions[n]) {
        let annotated = server.annotated(turning::DATABASE, &question.png).await?;
        write_file(&folder.join("annotated.png"), &annotated)?;
    }
    Ok(summary)
}

/// Things on a table: learn, inspect, print.
async fn inspect(
    server: &Server,
    folder: &Path,
    out: &mut dyn Write,
) -> Result<InspectingSummary, DemoError> {
    inspecting::forget(server).await?;
    let document = json!({"kind": "objects", "options": {"segment": true}});
    let version = teach(server, inspecting::DATABASE, &document, &inspecting::views(), out).await?;
    inspecting::inspect(server, version, folder, out).await
}

/// Keep the pictures of a lesson: `learned/<n>-<label>.png` and `asked/<n>-<label>.png`. Returns the latter.
fn keep(folder: &Path, lesson: &Lesson) -> Result<Vec<PathBuf>, DemoError> {
    let named = |n: usize, label: &str| format!("{n:03}-{label}.png");
    let learned = lesson.exemplars.iter().enumerate().map(|(n, e)| (named(n, &e.label), &e.png));
    let shown = |question: &Question| question.shown.clone().unwrap_or("strange".into());
    let asked = lesson.questions.iter().enumerate().map(|(n, q)| (named(n, &shown(q)), &q.png));
    keep_in(&folder.join("learned"), learned)?;
    keep_in(&folder.join("asked"), asked)
}

/// Write pictures by their names below a folder, in the place of those of a run before. Returns their files.
fn keep_in<'a>(
    folder: &Path,
    pictures: impl Iterator<Item = (String, &'a Vec<u8>)>,
) -> Result<Vec<PathBuf>, DemoError> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        removed => removed,
    }
    .map_err(|source| DemoError::Write { path: folder.to_path_buf(), source })?;
    let mut files = Vec::new();
    for (name, png) in pictures {
        let file = folder.join(name);
        write_file(&file, png)?;
        files.push(file);
    }
    Ok(files)
}

/// Write a file, and the folders that it lies in.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), DemoError> {
    path.parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(path, bytes))
        .map_err(|source| DemoError::Write { path: path.to_path_buf(), source })
}

/// Create the database, send its pictures, train; returns the version.
async fn teach(
    server: &Server,
    database: &str,
    document: &Value,
    exemplars: &[Exemplar],
    out: &mut dyn Write,
) -> Result<u64, DemoError> {
    server.forget(&["databases", database]).await?;
    server.create(&["databases", database], document).await?;
    for exemplar in exemplars {
        server.learn(database, exemplar).await?;
    }
    let started = std::time::Instant::now();
    let version = server.train(database, &json!({})).await?;
    let took_s = started.elapsed().as_secs_f64();
    let count = exemplars.len();
    writeln!(out, "\n{database}: {count} pictures learned as version {version} in {took_s:.2} s")?;
    Ok(version)
}

/// More rows than this are more than anyone reads: then the wrong answers only.
const MOST_ROWS: usize = 60;

/// Ask every question, print the answers, count the right ones by view.
async fn examine(
    server: &Server,
    lesson: &Lesson,
    version: u64,
    out: &mut dyn Write,
) -> Result<BTreeMap<String, Rate>, DemoError> {
    let all = lesson.questions.len() <= MOST_ROWS;
    if !all {
        writeln!(out, "of {} answers only wrong ones are listed:", lesson.questions.len())?;
    }
    writeln!(out, "  {:<28}{:<20}{:<20}{:>10}{:>8}", "view", "shown", "answered", "confidence", "ms")?;
    let mut rates: BTreeMap<String, Rate> = BTreeMap::new();
    for Question { view, shown, png } in &lesson.questions {
        let answer = server.ask(lesson.database, version, png).await?;
        let right = answer.label == *shown;
        let rate = rates.entry(view.clone()).or_insert(Rate::of(0, 0));
        *rate = Rate::of(rate.hits + usize::from(right), rate.trials + 1);
        if all || !right {
            let nothing = || "nothing".to_owned();
            let (shown, label) =
                (shown.clone().unwrap_or_else(nothing), answer.label.unwrap_or_else(nothing));
            let sure = answer.confidence.map_or("-".into(), |confidence| format!("{confidence:.2}"));
            let ms = answer.recognise_ms;
            let verdict = if right { "right" } else { "WRONG" };
            writeln!(out, "  {view:<28}{shown:<20}{label:<20}{sure:>10}{ms:>8.1}  {verdict}")?;
        }
    }
    Ok(rates)
}

/// What to click first: pages of the console that this demo filled, and the pictures to give them.
fn clicks(
    base_url: &str,
    database: &str,
    pictures_dir: &Path,
    drawn: bool,
    out: &mut dyn Write,
) -> Result<(), DemoError> {
    let base_url = base_url.trim_end_matches('/');
    writeln!(out, "\nopen {base_url}/ in a browser, and click:")?;
    let mut click = |page: &str, what: &str| writeln!(out, "  {:<58}{what}", format!("{base_url}/#/{page}"));
    if !drawn {
        click(&format!("try/{database}"), "drop a picture: what it is, and why")?;
        return Ok(click("", "everything that is here")?);
    }
    click("try/demo-objects", "drop a picture of demo-objects/asked: what it is, and why")?;
    click("try/demo-turntable", "drop one of demo-turntable/asked: how it is turned")?;
    click("versions/demo-turntable/1/2", "what trainings tell of themselves: two versions")?;
    click("depth", "drop near.png and far.png of a scene: how far it is")?;
    click("workcells/demo", "drop demo-workcell/table.png: where to reach")?;
    click("", "everything that is here")?;
    Ok(writeln!(out, "the pictures are in {}", pictures_dir.display())?)
}

/// Where to look next.
fn directions(base_url: &str, database: &str, file: &Path, out: &mut dyn Write) -> Result<(), DemoError> {
    let (base_url, file) = (base_url.trim_end_matches('/'), file.display());
    let call = format!("curl --data-binary '@{file}' -H 'Content-Type: image/png'");
    let url = format!("{base_url}/v1/databases/{database}/recognitions");
    writeln!(
        out,
        "\nor with curl; {base_url}/docs has every call, {base_url}/metrics counts and times.\nask:\n  {call} \\\n    '{url}?explain=true'\n\
         see the points and votes:\n  {call} \\\n    -H 'Accept: image/png' -o annotated.png '{url}'"
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
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
                serve(&settings, |address| listening.send(address).unwrap(), stopped).await
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
        let turning = summary.turning.unwrap();
        assert_eq!((turning.named_right.trials, turning.strange_refused.trials), (48, 12));
        assert!(turning.named_right.hits >= 46, "{printed}");
        assert!(turning.reliable.hits >= 24, "of 36: {printed}");
        let errors = turning.reliable_errors.unwrap();
        assert!(errors.median_deg <= 2.0 && errors.worst_deg <= 10.0, "{printed}");
        assert!(turning.without_pose.trials >= 11, "{printed}");
        assert_eq!(turning.without_pose.hits, turning.without_pose.trials, "{printed}");
        assert!(turning.strange_refused.hits >= 11, "{printed}");
        assert!(printed.contains("the truck turned by"), "{printed}");
        for scene in &summary.measured {
            let step = scene.scene.contains("ball");
            let errors = &scene.errors;
            assert!(
                errors.rms_percent < if step { 3.5 } else { 1.2 } && errors.median_abs_percent < 0.8,
                "{printed}"
            );
            assert!(scene.coverage > if step { 0.7 } else { 0.8 }, "{printed}");
        }
        assert_eq!(summary.measured.len(), 3);
        let inspecting = summary.inspecting.unwrap();
        assert_eq!((inspecting.found, inspecting.named_right), (Rate::of(5, 5), Rate::of(4, 4)), "{printed}");
        assert_eq!(inspecting.strange_refused, Rate::of(1, 1), "{printed}");
        let (turns, places) = (inspecting.turn_errors.unwrap(), inspecting.place_errors.unwrap());
        assert!(turns.trials == 3 && turns.worst_deg <= 2.0, "{printed}");
        assert!(places.trials == 5 && places.worst_mm <= 0.5, "{printed}");
        let [before, once, twice] = inspecting.centring_px[..] else { panic!("{printed}") };
        assert!(before > 25.0 && once < 3.0 && twice < 1.0 && inspecting.centred, "{printed}");
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
    fn own_pictures_are_learned_and_asked_about_and_a_second_run_starts_anew() {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("own");
        for exemplar in object_lesson().exemplars.into_iter().take(3) {
            let label = own.join(&exemplar.label);
            fs::create_dir_all(&label).unwrap();
            fs::write(label.join("a.png"), exemplar.png).unwrap();
        }
        let args = DemoArgs { images: Some(own.clone()), exit: true };
        let (summary, printed) = shown(&args, folder.path());
        assert_eq!(summary.right.trials, 12);
        assert!(summary.right.hits >= 10, "{printed}");
        assert!(summary.turning.is_none() && summary.measured.is_empty());
        assert!(!printed.contains("curl"), "nothing is left to be called: {printed}");
        fs::remove_dir_all(own.join("mug")).unwrap();
        assert_eq!(shown(&args, folder.path()).0.right.trials, 8);
    }
}
