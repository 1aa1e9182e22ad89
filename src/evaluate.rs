//! The verb `evaluate`: train on a folder, recognise queries with known truth, say how often it was right.
//!
//! Works on the core directly, without server or store, on one thread. Rates always come with their number of
//! trials. A query whose label was not trained (a folder `unknown`, a label `null`) shows no known object: it
//! can't be named right, and asks how much weight background alone collects.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

use crate::database::options::{DocumentError, from_document, to_document};
use crate::imaging::{DecodeLimits, Frame, decode};
use crate::recognition::landmarks::{
    ExemplarName, LandmarkOptions, Landmarks, Recognition, TrainingError, describe,
};

/// The query folder of frames without a known object.
const UNKNOWN: &str = "unknown";
/// Endings of the files that are taken as pictures; their bytes decide what they are.
const ENDINGS: [&str; 5] = ["png", "jpg", "jpeg", "pgm", "ppm"];
/// A right answer among the first so many is still of use to a robot that looks twice.
const TOP: usize = 5;

/// Arguments of `landmarkd evaluate`.
#[derive(Args, Clone, Debug)]
pub struct EvaluateArgs {
    /// Training pictures: TRAIN_DIR/<label>/*.{png,jpg,jpeg,pgm,ppm}
    #[arg(value_name = "TRAIN_DIR")]
    pub train_dir: PathBuf,
    /// Queries: <label>/* likewise (a folder `unknown`: no known object), or a manifest of files and labels
    #[arg(value_name = "QUERY_DIR|MANIFEST.json")]
    pub queries: PathBuf,
    /// An option of the database, as in PUT /v1/databases: --option interest_points=128 (may be repeated)
    #[arg(long = "option", value_name = "NAME=VALUE")]
    pub options: Vec<String>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    pub json: bool,
}

impl EvaluateArgs {
    /// The request that the arguments make.
    ///
    /// # Errors
    /// [`EvaluateError`] naming the option that is unknown, of the wrong type, or impossible.
    pub fn request(&self) -> Result<EvaluationRequest, EvaluateError> {
        Ok(EvaluationRequest {
            train_dir: self.train_dir.clone(),
            queries: self.queries.clone(),
            options: options_with(&self.options)?,
        })
    }
}

/// What is to be evaluated.
#[derive(Clone, Debug)]
pub struct EvaluationRequest {
    /// `<label>/*` to train on.
    pub train_dir: PathBuf,
    /// `<label>/*` to recognise, or a manifest file.
    pub queries: PathBuf,
    /// How to train.
    pub options: LandmarkOptions,
}

/// Why nothing could be evaluated.
#[derive(Debug, Error)]
pub enum EvaluateError {
    #[error("--option {given:?} is not NAME=VALUE")]
    NotAnOption { given: String },
    #[error("there is no option {option:?}; the options are {known}")]
    UnknownOption { option: String, known: String },
    #[error("the option {option} can't be {value}")]
    OptionType { option: String, value: Value, source: DocumentError },
    #[error("the options can't be used together")]
    Options { source: DocumentError },
    #[error("can't read {}", .path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} is no manifest: an object with lists `train` and `queries` of {{file, label}}", .path.display())]
    Manifest { path: PathBuf, source: serde_json::Error },
    #[error("{} holds no pictures in folders named by their labels", .path.display())]
    NoPictures { path: PathBuf },
    #[error("no model can be trained")]
    Training { source: TrainingError },
}

/// A rate, and how much it rests on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Trials that went well.
    pub hits: usize,
    /// All trials.
    pub trials: usize,
    /// hits / trials; 0 without trials.
    pub rate: f64,
}

impl Rate {
    /// The rate of `hits` in `trials`.
    pub fn of(hits: usize, trials: usize) -> Rate {
        Rate { hits, trials, rate: hits as f64 / trials.max(1) as f64 }
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} ({} of {})", self.rate, self.hits, self.trials)
    }
}

/// Frames of one label that were taken for another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Confusion {
    /// What was shown.
    pub shown: String,
    /// What was answered; `None`: nothing.
    pub named: Option<String>,
    /// How often.
    pub times: usize,
}

/// A picture that was left out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// Its file.
    pub file: String,
    /// Why.
    pub reason: String,
}

/// Times of one step over all queries.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Half of them took no longer.
    pub p50_ms: f64,
    /// 95 of 100 took no longer.
    pub p95_ms: f64,
}

/// Frames without a known object, and what they do to the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejection {
    /// How many there were.
    pub frames: usize,
    /// Queries named right with more weight than every one of these frames has for anything.
    pub kept: Rate,
    /// Probability that a query outweighs such a frame; a query named wrong counts as weight 0.
    pub auroc: f64,
}

/// How well a trained database knew the queries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// The options, as they are kept with a database.
    pub options: Value,
    /// Training images.
    pub exemplars: usize,
    /// Different labels among them.
    pub labels: usize,
    /// Coordinates of an eigenpoint.
    pub dimension: usize,
    /// Interest points of all training images.
    pub interest_points: usize,
    /// Named right.
    pub top_1: Rate,
    /// The right name among the first five.
    pub top_5: Rate,
    /// `None` without frames that show no known object.
    pub rejection: Option<Rejection>,
    /// What was taken for what, most frequent first.
    pub confusion: Vec<Confusion>,
    /// Labels of queries that nothing was trained for: their frames show no known object.
    pub untrained_labels: Vec<String>,
    /// Pictures that could not be read.
    pub skipped: Vec<Skipped>,
    /// From the bytes of a query to its pixels.
    pub decode: Times,
    /// From its pixels to the votes.
    pub recognise: Times,
    /// Describing and training, without decoding.
    pub training_ms: f64,
}

/// A picture file and what it shows.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LabelledFile {
    /// What it shows; `None`: nothing that is known.
    pub label: Option<String>,
    /// Where it is.
    pub path: PathBuf,
}

/// Train and recognise; `progress` is told (pictures done, all pictures).
///
/// # Errors
/// [`EvaluateError`]; a single broken picture is none, it is named and skipped.
pub fn evaluate(
    request: &EvaluationRequest,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Evaluation, EvaluateError> {
    let (training, queries) = files_of(request)?;
    let total = training.len() + queries.len();
    let mut done = 0;
    let mut skipped = Vec::new();

    let mut training_ms = 0.0;
    let mut exemplars = Vec::new();
    for file in &training {
        let id = file.path.display().to_string();
        if let (Some(label), Some((frame, _))) = (&file.label, read_frame(&file.path, &mut skipped)) {
            let started = Instant::now();
            exemplars.push(describe(ExemplarName { id, label: label.clone() }, &frame, &request.options));
            training_ms += ms_since(started);
        }
        done += 1;
        progress(done, total);
    }
    let started = Instant::now();
    let (model, report) =
        Landmarks::train(exemplars, &request.options).map_err(|source| EvaluateError::Training { source })?;
    training_ms += ms_since(started);

    let labels = model.labels();
    let mut untrained = BTreeSet::new();
    let mut judged = Vec::new();
    let (mut decode_ms, mut recognise_ms) = (Vec::new(), Vec::new());
    for file in &queries {
        if let Some((frame, took_ms)) = read_frame(&file.path, &mut skipped) {
            let known = file.label.as_deref().filter(|label| labels.binary_search(label).is_ok());
            if known.is_none() {
                untrained.extend(file.label.clone());
            }
            let started = Instant::now();
            let recognition = model.recognise(&frame, |_| ());
            recognise_ms.push(ms_since(started));
            decode_ms.push(took_ms);
            judged.push(Judged::of(known, &recognition));
        }
        done += 1;
        progress(done, total);
    }
    untrained.remove(UNKNOWN);

    let (known, strange): (Vec<Judged>, Vec<Judged>) = judged.into_iter().partition(|j| j.shown.is_some());
    let within = |most: usize| Rate::of(known.iter().filter(|j| j.rank < most).count(), known.len());
    Ok(Evaluation {
        options: document_of(&request.options),
        exemplars: report.exemplars,
        labels: report.labels,
        dimension: report.dimension,
        interest_points: report.interest_points,
        top_1: within(1),
        top_5: within(TOP),
        rejection: rejection(&known, &strange),
        confusion: confusion(&known),
        untrained_labels: untrained.into_iter().collect(),
        skipped,
        decode: times(decode_ms),
        recognise: times(recognise_ms),
        training_ms,
    })
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
            files.push(LabelledFile { label: label.clone(), path });
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(EvaluateError::NoPictures { path: folder.to_path_buf() });
    }
    Ok(files)
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
}

/// The files to train on and to recognise. A manifest's own list of training pictures holds when TRAIN_DIR is
/// the `train` folder beside it; any other TRAIN_DIR holds by itself.
fn files_of(request: &EvaluationRequest) -> Result<(Vec<LabelledFile>, Vec<LabelledFile>), EvaluateError> {
    let path = &request.queries;
    if path.is_dir() {
        return Ok((labelled_files(&request.train_dir)?, labelled_files(path)?));
    }
    let text = fs::read(path).map_err(|source| EvaluateError::Read { path: path.clone(), source })?;
    let manifest: Manifest = serde_json::from_slice(&text)
        .map_err(|source| EvaluateError::Manifest { path: path.clone(), source })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let listed = |entries: Vec<ManifestEntry>| -> Vec<LabelledFile> {
        entries
            .into_iter()
            .map(|entry| LabelledFile { label: entry.label, path: folder.join(entry.file) })
            .collect()
    };
    let training = match is_same_folder(&request.train_dir, &folder.join("train")) {
        true => listed(manifest.train),
        false => labelled_files(&request.train_dir)?,
    };
    Ok((training, listed(manifest.queries)))
}

fn is_same_folder(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// A frame and the time its decoding took; a picture that can't be read is noted instead.
fn read_frame(path: &Path, skipped: &mut Vec<Skipped>) -> Option<(Frame, f64)> {
    let mut skip = |reason: String| skipped.push(Skipped { file: path.display().to_string(), reason });
    let bytes = fs::read(path).map_err(|error| skip(error.to_string())).ok()?;
    let started = Instant::now();
    let frame = decode(&bytes, &DecodeLimits::default()).map_err(|error| skip(error.to_string())).ok()?;
    Some((frame, ms_since(started)))
}

/// One query's answer against its truth.
struct Judged {
    shown: Option<String>,
    named: Option<String>,
    /// Place of the right label among the votes, from 0; [`usize::MAX`]: not among them.
    rank: usize,
    /// W of the best label.
    weight: f64,
}

impl Judged {
    fn of(shown: Option<&str>, recognition: &Recognition) -> Judged {
        let votes = &recognition.votes;
        let rank = votes.iter().position(|vote| Some(vote.label.as_str()) == shown);
        Judged {
            shown: shown.map(str::to_owned),
            named: votes.first().map(|vote| vote.label.clone()),
            rank: rank.unwrap_or(usize::MAX),
            weight: votes.first().map_or(0.0, |vote| vote.weight),
        }
    }

    /// W when it was named right, else 0.
    fn right_weight(&self) -> f64 {
        if self.rank == 0 { self.weight } else { 0.0 }
    }
}

fn rejection(known: &[Judged], strange: &[Judged]) -> Option<Rejection> {
    if strange.is_empty() || known.is_empty() {
        return None;
    }
    let heaviest = strange.iter().map(|j| j.weight).fold(0.0, f64::max);
    let kept = known.iter().filter(|j| j.right_weight() > heaviest).count();
    let mut won = 0.0;
    for a in known.iter().map(Judged::right_weight) {
        for b in strange.iter().map(|j| j.weight) {
            won += if a > b {
                1.0
            } else if a == b {
                0.5
            } else {
                0.0
            };
        }
    }
    let auroc = won / (known.len() * strange.len()) as f64;
    Some(Rejection { frames: strange.len(), kept: Rate::of(kept, known.len()), auroc })
}

fn confusion(known: &[Judged]) -> Vec<Confusion> {
    let mut times: BTreeMap<(String, Option<String>), usize> = BTreeMap::new();
    for judged in known.iter().filter(|j| j.rank != 0) {
        let pair = (judged.shown.clone().unwrap_or_default(), judged.named.clone());
        *times.entry(pair).or_default() += 1;
    }
    let mut pairs: Vec<Confusion> =
        times.into_iter().map(|((shown, named), times)| Confusion { shown, named, times }).collect();
    pairs.sort_by_key(|pair| std::cmp::Reverse(pair.times)); // stable: equal ones stay in the order of labels
    pairs
}

fn ms_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1e3
}

/// Percentiles by nearest rank; 0 of nothing.
fn times(mut all_ms: Vec<f64>) -> Times {
    all_ms.sort_by(f64::total_cmp);
    let percentile = |part: f64| {
        let rank = (part * all_ms.len() as f64).ceil() as usize;
        all_ms.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
    };
    Times { p50_ms: percentile(0.50), p95_ms: percentile(0.95) }
}

fn document_of(options: &LandmarkOptions) -> Value {
    serde_json::from_str(&to_document(options)).unwrap_or_default()
}

/// The default options with the given `NAME=VALUE` laid over them; a value is JSON, or else a word.
fn options_with(given: &[String]) -> Result<LandmarkOptions, EvaluateError> {
    let defaults = document_of(&LandmarkOptions::default());
    let mut document: Map<String, Value> = defaults.as_object().cloned().unwrap_or_default();
    for pair in given {
        let (option, text) =
            pair.split_once('=').ok_or_else(|| EvaluateError::NotAnOption { given: pair.clone() })?;
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::from(text));
        if !document.contains_key(option) {
            let known = document.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(EvaluateError::UnknownOption { option: option.into(), known });
        }
        document.insert(option.into(), value.clone());
        // Types are asked for one option at a time, so that the one at fault is named; whether all of them go
        // together is asked at the end.
        if let Err(source @ DocumentError::Malformed { .. }) = from_document(&text_of(&document)) {
            return Err(EvaluateError::OptionType { option: option.into(), value, source });
        }
    }
    from_document(&text_of(&document)).map_err(|source| EvaluateError::Options { source })
}

fn text_of(document: &Map<String, Value>) -> String {
    Value::from(document.clone()).to_string()
}

/// How many confused pairs and skipped pictures the table names; the JSON has them all.
const LISTED: usize = 12;
const PAIRS_A_LINE: usize = 3;

impl fmt::Display for Confusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Confusion { shown, named, times } = self;
        write!(f, "{shown} as {}", named.as_deref().unwrap_or("nothing"))?;
        if *times > 1 { write!(f, " ({times})") } else { Ok(()) }
    }
}

impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rows = |f: &mut fmt::Formatter<'_>, name: &str, value: &dyn fmt::Display| {
            writeln!(f, "{name:<14}{value}")
        };
        rows(
            f,
            "trained",
            &format_args!(
                "{} pictures of {} labels, {} interest points, {} dimensions, {:.0} ms",
                self.exemplars, self.labels, self.interest_points, self.dimension, self.training_ms
            ),
        )?;
        rows(f, "top-1", &self.top_1)?;
        rows(f, "top-5", &self.top_5)?;
        if let Some(rejection) = &self.rejection {
            let frames = rejection.frames;
            rows(
                f,
                "kept",
                &format_args!("{} above all of {frames} without a known object", rejection.kept),
            )?;
            rows(f, "AUROC", &format_args!("{:.3} against these {frames}", rejection.auroc))?;
        }
        for (name, times) in [("decode", self.decode), ("recognise", self.recognise)] {
            let Times { p50_ms, p95_ms } = times;
            rows(f, name, &format_args!("{p50_ms:.2} ms a picture (p95 {p95_ms:.2}), one thread"))?;
        }
        let listed: Vec<String> = self.confusion.iter().take(LISTED).map(Confusion::to_string).collect();
        for (n, pairs) in listed.chunks(PAIRS_A_LINE).enumerate() {
            rows(f, if n == 0 { "confused" } else { "" }, &pairs.join(", "))?;
        }
        if self.confusion.len() > LISTED {
            rows(f, "", &format_args!("and {} pairs more", self.confusion.len() - LISTED))?;
        }
        if !self.untrained_labels.is_empty() {
            rows(f, "not trained", &format_args!("{} (no known object)", self.untrained_labels.join(", ")))?;
        }
        if !self.skipped.is_empty() {
            rows(f, "skipped", &format_args!("{} pictures", self.skipped.len()))?;
        }
        for picture in self.skipped.iter().take(LISTED) {
            rows(f, "", &format_args!("{}: {}", picture.file, picture.reason))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::encode::png_gray8;

    /// A picture of 12 px cells whose greys depend on the seed alone.
    fn write_picture(path: &Path, seed: usize) {
        let size = 96;
        let grey = |x: usize, y: usize| {
            ((x / 12 + 8 * (y / 12) + 64 * seed + 1).wrapping_mul(2_654_435_761) >> 24) as u8
        };
        let pixels: Vec<u8> = (0..size * size).map(|i| grey(i % size, i / size)).collect();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, png_gray8(size, size, &pixels)).unwrap();
    }

    fn evaluated(train_dir: &Path, queries: &Path) -> Evaluation {
        let options = LandmarkOptions::default();
        let request = EvaluationRequest { train_dir: train_dir.into(), queries: queries.into(), options };
        evaluate(&request, &mut |_, _| ()).unwrap()
    }

    #[test]
    fn a_picture_is_recognised_as_itself_and_above_strange_ones() {
        let folder = tempfile::tempdir().unwrap();
        let (train, queries) = (folder.path().join("train"), folder.path().join("queries"));
        for (n, label) in ["hall", "lab", "yard"].into_iter().enumerate() {
            write_picture(&train.join(label).join("a.png"), n);
            write_picture(&queries.join(label).join("b.PNG"), n);
        }
        write_picture(&queries.join("unknown/c.png"), 7);
        write_picture(&queries.join("attic/d.png"), 8);
        let request = EvaluationRequest { train_dir: train, queries, options: LandmarkOptions::default() };
        let mut told = Vec::new();
        let evaluation = evaluate(&request, &mut |done, total| told.push((done, total))).unwrap();
        assert_eq!(evaluation.top_1, Rate::of(3, 3));
        assert_eq!(evaluation.top_5, Rate::of(3, 3));
        let rejection = evaluation.rejection.as_ref().unwrap();
        assert_eq!((rejection.frames, rejection.kept, rejection.auroc), (2, Rate::of(3, 3), 1.0));
        assert_eq!(evaluation.untrained_labels, ["attic"]);
        assert!(evaluation.confusion.is_empty() && evaluation.skipped.is_empty());
        assert_eq!(told, (1..=8).map(|done| (done, 8)).collect::<Vec<_>>());
        assert!(evaluation.to_string().contains("top-1         1.000 (3 of 3)"), "{evaluation}");
    }

    #[test]
    fn a_wrong_label_shows_up_as_a_confused_pair() {
        let folder = tempfile::tempdir().unwrap();
        let (train, queries) = (folder.path().join("train"), folder.path().join("queries"));
        for (n, label) in ["hall", "lab"].into_iter().enumerate() {
            write_picture(&train.join(label).join("a.png"), n);
            write_picture(&queries.join(label).join("b.png"), 0);
        }
        let evaluation = evaluated(&train, &queries);
        assert_eq!(evaluation.top_1, Rate::of(1, 2));
        let pair = Confusion { shown: "lab".into(), named: Some("hall".into()), times: 1 };
        assert!(evaluation.to_string().contains("confused      lab as hall\n"), "{evaluation}");
        assert_eq!(evaluation.confusion, [pair]);
        assert_eq!(evaluation.rejection, None);
    }

    #[test]
    fn a_broken_picture_is_named_and_skipped() {
        let folder = tempfile::tempdir().unwrap();
        write_picture(&folder.path().join("hall/a.png"), 1);
        write_picture(&folder.path().join("lab/a.png"), 2);
        fs::write(folder.path().join("lab/b.jpg"), b"not a picture").unwrap();
        fs::write(folder.path().join("lab/notes.txt"), b"passed over").unwrap();
        let evaluation = evaluated(folder.path(), folder.path());
        assert_eq!(evaluation.top_1, Rate::of(2, 2));
        assert_eq!(evaluation.skipped.len(), 2, "once in training, once as a query");
        assert!(evaluation.skipped.iter().all(|s| s.file.ends_with("b.jpg")), "{:?}", evaluation.skipped);
    }

    #[test]
    fn a_manifest_names_training_pictures_and_queries() {
        let folder = tempfile::tempdir().unwrap();
        let at = |file: &str| folder.path().join(file);
        write_picture(&at("train/hall/a.png"), 1);
        write_picture(&at("train/lab/a.png"), 2);
        write_picture(&at("train/lab/not-listed.png"), 3);
        write_picture(&at("queries/q0.png"), 1);
        write_picture(&at("queries/q1.png"), 9);
        let manifest = r#"{"settings": {}, "train": [{"file": "train/hall/a.png", "label": "hall"},
            {"file": "train/lab/a.png", "label": "lab", "pose_deg": 0}],
            "queries": [{"file": "queries/q0.png", "label": "hall"}, {"file": "queries/q1.png", "label": null}]}"#;
        fs::write(at("manifest.json"), manifest).unwrap();
        let evaluation = evaluated(&at("train"), &at("manifest.json"));
        assert_eq!((evaluation.exemplars, evaluation.top_1), (2, Rate::of(1, 1)));
        assert_eq!(evaluation.rejection.unwrap().frames, 1);
        fs::rename(at("train"), at("elsewhere")).unwrap();
        assert_eq!(evaluated(&at("elsewhere"), &at("manifest.json")).exemplars, 3);
    }

    #[test]
    fn options_are_laid_over_the_defaults_and_faults_name_the_option() {
        let with =
            |pairs: &[&str]| options_with(&pairs.iter().map(|pair| (*pair).to_owned()).collect::<Vec<_>>());
        let options =
            with(&["interest_points=16", "colour=gray", "taper=\"literal\"", "epsilon=0.01"]).unwrap();
        assert_eq!((options.interest_points, options.epsilon), (16, 0.01));
        assert_eq!(options.query_points, LandmarkOptions::default().query_points);
        let message = |pairs: &[&str]| with(pairs).unwrap_err().to_string();
        assert!(message(&["rings"]).contains("NAME=VALUE"));
        assert!(message(&["points=3"]).contains("interest_points"), "the message lists what there is");
        assert!(message(&["epsilon=0.1", "rings=many"]).contains("rings"));
        assert!(
            matches!(with(&["rings=0"]), Err(EvaluateError::Options { source }) if source.to_string().contains("rings"))
        );
    }

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
    fn percentiles_are_by_nearest_rank() {
        let Times { p50_ms, p95_ms } = times((1..=100).rev().map(f64::from).collect());
        assert_eq!((p50_ms, p95_ms), (50.0, 95.0));
        assert_eq!(times(Vec::new()), Times { p50_ms: 0.0, p95_ms: 0.0 });
        assert_eq!(times(vec![3.0]), Times { p50_ms: 3.0, p95_ms: 3.0 });
    }
}
