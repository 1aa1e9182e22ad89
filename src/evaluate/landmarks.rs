//! Databases of landmarks: which label has the most weight, what was decided at the version's threshold, and how much
//! weight background alone collects.

use std::convert::Infallible;
use std::fmt;
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use super::EvaluateError;
use super::figures::{Confusion, Rate, Times, closing_rows, row, timed};
use super::files::{Files, LabelledFile, Skipped, read_frame};
use super::options::document_of;
use super::queries::{Answers, Progress, ask};
use crate::database::options::Options;
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, ExemplarName, LandmarkOptions, Landmarks, Recognition, Signature, TrainingReport,
    calibration_samples, describe, synthetic_views,
};

/// A right answer among the first so many still helps a robot that checks several.
const TOP: usize = 5;

/// Frames without a known object, and what they do to the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rejection {
    /// How many there were.
    pub frames: usize,
    /// Queries named right with more weight than every one of these frames has for anything.
    pub kept: Rate,
    /// Probability that a query outweighs such a frame; a query named wrong counts as weight 0.
    pub auroc: f64,
    /// Those of these frames for which nothing was decided.
    pub refused: Rate,
}

/// What was decided about the queries that show something known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Decided {
    /// Named right.
    pub named: Rate,
    /// Named wrong.
    pub misnamed: Rate,
    /// Not sure enough: no decision.
    pub null: Rate,
}

/// How well a trained database knew the queries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LandmarkEvaluation {
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
    /// Decisions about queries that show something known.
    pub decided: Decided,
    /// Least confidence of a decision; `None` if the exemplars didn't allow to learn it: then the best is decided.
    pub threshold: Option<f64>,
    /// With gradient signatures: the part of frames of something unknown that may be decided.
    pub false_alarms: Option<f64>,
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
    /// Calibrating on synthetic views of the training images, with decoding.
    #[serde(rename = "rehearsal_ms")]
    pub calibration_ms: f64,
}

/// Trains and recognises.
pub(super) fn evaluate(
    options: &LandmarkOptions,
    files: &Files,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<LandmarkEvaluation, EvaluateError> {
    let mut progress = Progress::new(files.training.len() + files.queries.len(), progress);
    let mut skipped = Vec::new();
    let Trained { model, report, training_ms, calibration_ms } =
        train(options, &files.training, &mut skipped, &mut progress)?;
    let Answers { judged, untrained_labels, decode, recognise } = ask(
        &files.queries,
        &model.labels(),
        |frame| Ok::<_, Infallible>(model.recognise(frame, |_| ())),
        |file, is_known, recognition| Judged::of(file.label.as_deref().filter(|_| is_known), &recognition),
        &mut skipped,
        &mut progress,
    );

    let by_confidence = options.signature == Signature::Intensity;
    let (known, unknown): (Vec<Judged>, Vec<Judged>) = judged.into_iter().partition(|j| j.shown.is_some());
    let decided = |wanted: &dyn Fn(&Judged) -> bool| Rate::among(known.iter().map(wanted));
    let within = |most: usize| Rate::among(known.iter().map(|j| j.rank < most));
    let wrong = known.iter().filter(|j| j.rank != 0);
    Ok(LandmarkEvaluation {
        options: document_of(&Options::Landmarks(options.clone())),
        exemplars: report.exemplars,
        labels: report.labels,
        dimension: report.dimension,
        interest_points: report.interest_points,
        top_1: within(1),
        top_5: within(TOP),
        decided: Decided {
            named: decided(&|j| j.decided.is_some() && j.decided == j.shown),
            misnamed: decided(&|j| j.decided.is_some() && j.decided != j.shown),
            null: decided(&|j| j.decided.is_none()),
        },
        threshold: model.confidence().filter(|_| by_confidence).map(|confidence| confidence.threshold),
        false_alarms: (!by_confidence).then_some(options.false_alarms),
        rejection: rejection(&known, &unknown),
        confusion: Confusion::counted(wrong.map(|j| (j.shown.clone().unwrap_or_default(), j.named.clone()))),
        untrained_labels,
        skipped,
        decode,
        recognise,
        training_ms,
        calibration_ms,
    })
}

/// A calibrated model, its report, and what it took.
struct Trained {
    model: Landmarks,
    report: TrainingReport,
    training_ms: f64,
    calibration_ms: f64,
}

/// Trains on the files that have a label, and calibrates.
fn train(
    options: &LandmarkOptions,
    files: &[LabelledFile],
    skipped: &mut Vec<Skipped>,
    progress: &mut Progress,
) -> Result<Trained, EvaluateError> {
    let (mut training_ms, mut calibration_ms) = (0.0, 0.0);
    let mut exemplars = Vec::new();
    for file in files {
        if let (Some(label), Some((frame, _))) = (&file.label, read_frame(&file.path, skipped)) {
            let name = ExemplarName { id: file.path.display().to_string(), label: label.clone() };
            exemplars.push(timed(&mut training_ms, || describe(name, &frame, options)));
        }
        progress.step();
    }
    let trained = timed(&mut training_ms, || Landmarks::train(exemplars, options));
    let (mut model, report) = trained.map_err(|source| EvaluateError::LandmarkTraining { source })?;
    if options.signature == Signature::Intensity {
        timed(&mut calibration_ms, || calibrate(&mut model));
    }
    Ok(Trained { model, report, training_ms, calibration_ms })
}

/// Calibrates on synthetic views of the exemplars, as a training of the service does; skips pictures that can't be read
/// again.
fn calibrate(model: &mut Landmarks) {
    let plan = CalibrationPlan::of(model);
    let mut samples = Vec::new();
    for round in 0..plan.rounds {
        for name in plan.exemplars.iter().map(|&index| model.exemplars()[index].name()) {
            if let Some((frame, _)) = read_frame(Path::new(&name.id), &mut Vec::new()) {
                let views = synthetic_views(&name, &frame, round, model.options());
                samples.extend(calibration_samples(model, &name, &views));
            }
        }
    }
    model.calibrate(&samples);
}

/// One query's answer against its truth.
struct Judged {
    shown: Option<String>,
    named: Option<String>,
    /// What was decided.
    decided: Option<String>,
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
            decided: recognition.decision.as_ref().map(|decision| decision.label.clone()),
            rank: rank.unwrap_or(usize::MAX),
            weight: votes.first().map_or(0.0, |vote| vote.weight),
        }
    }

    /// W when it was named right, else 0.
    fn right_weight(&self) -> f64 {
        if self.rank == 0 { self.weight } else { 0.0 }
    }
}

fn rejection(known: &[Judged], unknown: &[Judged]) -> Option<Rejection> {
    if unknown.is_empty() || known.is_empty() {
        return None;
    }
    let heaviest = unknown.iter().map(|j| j.weight).fold(0.0, f64::max);
    let kept = known.iter().filter(|j| j.right_weight() > heaviest).count();
    let mut won = 0.0;
    for a in known.iter().map(Judged::right_weight) {
        for b in unknown.iter().map(|j| j.weight) {
            won += 0.5 * (f64::from(a > b) + f64::from(a >= b));
        }
    }
    let auroc = won / (known.len() * unknown.len()) as f64;
    let refused = Rate::among(unknown.iter().map(|j| j.decided.is_none()));
    Some(Rejection { frames: unknown.len(), kept: Rate::of(kept, known.len()), auroc, refused })
}

impl fmt::Display for LandmarkEvaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        row(
            f,
            "trained",
            &format_args!(
                "{} pictures of {} labels, {} interest points, {} dimensions, {:.0} ms, and {:.0} ms of rehearsals",
                self.exemplars,
                self.labels,
                self.interest_points,
                self.dimension,
                self.training_ms,
                self.calibration_ms
            ),
        )?;
        row(f, "top-1", &self.top_1)?;
        row(f, "top-5", &self.top_5)?;
        let Decided { named, misnamed, null } = &self.decided;
        match (self.threshold, self.false_alarms) {
            (Some(threshold), _) => row(f, "threshold", &format_args!("{threshold:.3}"))?,
            (None, Some(alarms)) => row(f, "false alarms", &format_args!("{alarms} a frame at most"))?,
            (None, None) => row(f, "threshold", &"none: the best is decided")?,
        }
        row(f, "named", named)?;
        row(f, "misnamed", misnamed)?;
        row(f, "null", null)?;
        if let Some(rejection) = &self.rejection {
            row(f, "refused", &format_args!("{} without a known object", rejection.refused))?;
            let frames = rejection.frames;
            row(f, "kept", &format_args!("{} above all of {frames} without a known object", rejection.kept))?;
            row(f, "AUROC", &format_args!("{:.3} against these {frames}", rejection.auroc))?;
        }
        for (name, times) in [("decode", self.decode), ("recognise", self.recognise)] {
            let Times { p50_ms, p95_ms } = times;
            row(f, name, &format_args!("{p50_ms:.2} ms a picture (p95 {p95_ms:.2}), one thread"))?;
        }
        closing_rows(f, &self.confusion, &self.untrained_labels, &self.skipped)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::files::training_and_queries;
    use super::*;
    use landmarkd_core::imaging::encode::png_gray8;

    /// A picture of 12 px cells whose gray levels depend on the seed alone.
    fn write_picture(path: &Path, seed: usize) {
        let size = 96;
        // mixed well: a plain multiplication would make one picture a shift of another
        let gray = |x: usize, y: usize| {
            let mut mixed = (x / 12 + 8 * (y / 12) + 64 * seed + 1) as u64;
            for factor in [0xbf58_476d_1ce4_e5b9_u64, 0x94d0_49bb_1331_11eb] {
                mixed = (mixed ^ (mixed >> 29)).wrapping_mul(factor);
            }
            (mixed >> 56) as u8
        };
        let pixels: Vec<u8> = (0..size * size).map(|i| gray(i % size, i / size)).collect();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, png_gray8(size, size, &pixels)).unwrap();
    }

    fn evaluated(train_dir: &Path, queries: &Path) -> LandmarkEvaluation {
        evaluated_with(train_dir, queries, &mut |_, _| ())
    }

    fn evaluated_with(
        train_dir: &Path,
        queries: &Path,
        progress: &mut dyn FnMut(usize, usize),
    ) -> LandmarkEvaluation {
        let files = training_and_queries(train_dir, queries).unwrap();
        evaluate(&LandmarkOptions::default(), &files, progress).unwrap()
    }

    #[test]
    fn a_picture_is_recognised_as_itself_and_above_unknown_ones() {
        let folder = tempfile::tempdir().unwrap();
        let (train, queries) = (folder.path().join("train"), folder.path().join("queries"));
        for (n, label) in ["hall", "lab", "yard"].into_iter().enumerate() {
            write_picture(&train.join(label).join("a.png"), n);
            write_picture(&queries.join(label).join("b.PNG"), n);
        }
        write_picture(&queries.join("unknown/c.png"), 7);
        write_picture(&queries.join("attic/d.png"), 8);
        let mut reported = Vec::new();
        let evaluation = evaluated_with(&train, &queries, &mut |done, total| reported.push((done, total)));
        assert_eq!(evaluation.top_1, Rate::of(3, 3));
        assert_eq!(evaluation.top_5, Rate::of(3, 3));
        let rejection = evaluation.rejection.as_ref().unwrap();
        assert_eq!((rejection.frames, rejection.kept, rejection.auroc), (2, Rate::of(3, 3), 1.0));
        assert_eq!((evaluation.decided.named, rejection.refused), (Rate::of(3, 3), Rate::of(2, 2)));
        assert_eq!((evaluation.threshold, evaluation.false_alarms), (None, Some(0.01)), "{evaluation}");
        assert_eq!(evaluation.untrained_labels, ["attic"]);
        assert!(evaluation.confusion.is_empty() && evaluation.skipped.is_empty());
        assert_eq!(reported, (1..=8).map(|done| (done, 8)).collect::<Vec<_>>());
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
}
