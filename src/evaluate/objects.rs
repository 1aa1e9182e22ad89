//! Databases of whole appearance: which object, known or not, and how it is turned.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use serde_json::Value;

use super::EvaluateError;
use super::figures::{Confusion, PoseErrors, Rate, Times, closing_rows, row, timed};
use super::files::{Files, LabelledFile, Skipped, UNKNOWN, read_frame};
use super::options::document_of;
use super::queries::{Answers, Progress, ask};
use crate::database::options::Options;
use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::recognition::objects::{
    self, Normaliser, ObjectOptions, Objects, Pose, Recognition, TrainingError, TrainingReport, View,
    ViewName, common_size, common_step_deg, is_trial,
};

/// How well a trained database knew the objects of the queries.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectEvaluation {
    /// The options, as they are kept with a database.
    pub options: Value,
    /// Training views.
    pub exemplars: usize,
    /// Different labels among them.
    pub labels: usize,
    /// Size of the database's pictures.
    pub width_px: usize,
    /// Height of these.
    pub height_px: usize,
    /// Coordinates of an eigenpoint in the universal eigenspace.
    pub dimension: usize,
    /// Queries of known objects whose likeliest object is the right one, be it accepted or not.
    pub recognised: Rate,
    /// Queries of known objects that were accepted and named right.
    pub named_right: Rate,
    /// Queries of known objects that were accepted as anything.
    pub accepted: Rate,
    /// Queries without a known object that were refused; `None` without such queries.
    pub refused: Option<Rate>,
    /// Queries that were named wrong or refused, and unknown ones that were accepted; most frequent first.
    pub confusion: Vec<Confusion>,
    /// Poses of the queries that were named right and have a true pose; `None` without any.
    pub poses: Option<Poses>,
    /// The same by object.
    pub poses_by_object: Vec<ObjectPoses>,
    /// Labels of queries that nothing was trained for: their frames show no known object.
    pub untrained_labels: Vec<String>,
    /// Pictures that could not be used.
    pub skipped: Vec<Skipped>,
    /// From the bytes of a query to its pixels.
    pub decode: Times,
    /// From its pixels to the answer.
    pub recognise: Times,
    /// Training with the appearances of its pictures, without decoding.
    pub training_ms: f64,
}

/// Poses of queries whose object was named right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Poses {
    /// Queries that were given a pose, of those with a true one.
    pub answered: Rate,
    /// Errors of all of them; `None` if none was answered.
    pub errors: Option<PoseErrors>,
    /// Poses that call themselves reliable, of those answered.
    pub reliable: Rate,
    /// Errors of these; `None` without any.
    pub reliable_errors: Option<PoseErrors>,
}

/// Poses of one object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectPoses {
    /// The object.
    pub label: String,
    #[serde(flatten)]
    /// Its poses.
    pub poses: Poses,
}

/// Trains and recognises.
pub(super) fn evaluate(
    options: &ObjectOptions,
    files: &Files,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<ObjectEvaluation, EvaluateError> {
    let mut progress = Progress::new(files.training.len() + files.queries.len(), progress);
    let mut skipped = Vec::new();
    let Trained { model, report, training_ms } =
        train(options, &files.training, &mut skipped, &mut progress)?;
    let Answers { judged, untrained_labels, decode, recognise } = ask(
        &files.queries,
        &model.labels(),
        |frame| model.recognise(frame, |_| ()),
        Judged::of,
        &mut skipped,
        &mut progress,
    );

    let (known, unknown): (Vec<&Judged>, Vec<&Judged>) = judged.iter().partition(|j| j.known);
    let rate = |good: fn(&Judged) -> bool| Rate::among(known.iter().map(|j| good(j)));
    let refused = Rate::among(unknown.iter().map(|j| j.named.is_none()));
    let wrong = judged.iter().filter(|j| j.is_wrong());
    Ok(ObjectEvaluation {
        options: document_of(&Options::Objects(options.clone())),
        exemplars: report.exemplars,
        labels: report.labels,
        width_px: report.width_px,
        height_px: report.height_px,
        dimension: report.dimension,
        recognised: rate(|j| j.likeliest.as_ref() == Some(&j.shown)),
        named_right: rate(Judged::is_named_right),
        accepted: rate(|j| j.named.is_some()),
        refused: (!unknown.is_empty()).then_some(refused),
        confusion: Confusion::counted(wrong.map(|j| (j.shown.clone(), j.named.clone()))),
        poses: Poses::of(&known),
        poses_by_object: poses_by_object(&known),
        untrained_labels,
        skipped,
        decode,
        recognise,
        training_ms,
    })
}

/// The poses of each object that has any, in the order of labels.
fn poses_by_object(known: &[&Judged]) -> Vec<ObjectPoses> {
    let mut by_object: BTreeMap<&str, Vec<&Judged>> = BTreeMap::new();
    for judged in known {
        by_object.entry(&judged.shown).or_default().push(judged);
    }
    let poses = by_object.into_iter().filter_map(|(label, judged)| {
        Some(ObjectPoses { label: label.to_owned(), poses: Poses::of(&judged)? })
    });
    poses.collect()
}

/// A model, its report, and what the training took.
struct Trained {
    model: Objects,
    report: TrainingReport,
    training_ms: f64,
}

/// A training picture that can be used, and its label.
type Usable<'a> = (&'a str, &'a LabelledFile);

/// Trains on the files that have a label; skips what can't be used.
fn train(
    options: &ObjectOptions,
    files: &[LabelledFile],
    skipped: &mut Vec<Skipped>,
    progress: &mut Progress,
) -> Result<Trained, EvaluateError> {
    let failed = |source| EvaluateError::ObjectTraining { source };
    let usable = usable(files, skipped, progress);
    // Decoded once for the commonest size, and again for the appearance: large pictures are held one at a time.
    let sizes = usable.iter().filter_map(|(_, file)| {
        let (frame, _) = read_frame(&file.path, &mut Vec::new())?;
        Some((frame.width() as u32, frame.height() as u32))
    });
    let size_px = common_size(sizes).ok_or_else(|| failed(TrainingError::TooFew { views: 0 }))?;
    let posed = usable.iter().map(|(label, file)| (*label, file.pose_deg));
    let normaliser = Normaliser::new(options, size_px).with_step_deg(common_step_deg(posed));
    let mut training_ms = 0.0;
    let mut views = Vec::new();
    let count = usable.len();
    for (place, (label, file)) in usable.into_iter().enumerate() {
        if let Some((frame, _)) = read_frame(&file.path, skipped) {
            let id = file.path.display().to_string();
            let name = ViewName { id, label: label.to_owned(), pose_deg: file.pose_deg };
            let shown = || View::new(&normaliser, name, &frame, is_trial(place, count));
            match timed(&mut training_ms, shown) {
                Err(mismatch) => skipped.push(Skipped::new(&file.path, mismatch)),
                Ok(view) => views.push(view),
            }
        }
        progress.step();
    }
    let trained = timed(&mut training_ms, || objects::train(views, &normaliser, options));
    let (model, report) = trained.map_err(failed)?;
    Ok(Trained { model, report, training_ms })
}

/// The files that have a label and no impossible pose.
fn usable<'a>(
    files: &'a [LabelledFile],
    skipped: &mut Vec<Skipped>,
    progress: &mut Progress,
) -> Vec<Usable<'a>> {
    let mut usable = Vec::new();
    for file in files {
        let reason = match (&file.label, file.pose_deg) {
            (None, _) => "a training picture needs a label".to_owned(),
            (_, Some(pose_deg)) if !(0.0..360.0).contains(&pose_deg) => {
                format!("the pose {pose_deg}° is not in [0, 360)")
            }
            (Some(label), _) => {
                usable.push((label.as_str(), file));
                continue;
            }
        };
        skipped.push(Skipped::new(&file.path, reason));
        progress.step();
    }
    usable
}

/// One query's answer against its truth.
struct Judged {
    /// What was shown: its label, or "unknown".
    shown: String,
    /// Whether that was trained.
    known: bool,
    /// The first candidate.
    likeliest: Option<String>,
    /// What the answer says; `None`: nothing that is known.
    named: Option<String>,
    true_pose_deg: Option<f64>,
    pose: Option<Pose>,
}

impl Judged {
    fn of(file: &LabelledFile, known: bool, recognition: Recognition) -> Judged {
        let (named, pose) =
            recognition.decision.map_or((None, None), |decision| (Some(decision.label), decision.pose));
        Judged {
            shown: file.label.clone().unwrap_or_else(|| UNKNOWN.to_owned()),
            known,
            likeliest: recognition.candidates.into_iter().next().map(|candidate| candidate.label),
            named,
            true_pose_deg: file.pose_deg,
            pose,
        }
    }

    fn is_named_right(&self) -> bool {
        self.known && self.named.as_ref() == Some(&self.shown)
    }

    fn is_wrong(&self) -> bool {
        if self.known { !self.is_named_right() } else { self.named.is_some() }
    }
}

impl Poses {
    fn of(judged: &[&Judged]) -> Option<Poses> {
        let asked: Vec<(f64, Option<Pose>)> = judged
            .iter()
            .filter(|j| j.is_named_right())
            .filter_map(|j| Some((j.true_pose_deg?, j.pose)))
            .collect();
        let answered: Vec<(f64, bool)> = asked
            .iter()
            .filter_map(|(true_deg, pose)| {
                pose.map(|pose| (angular_distance_deg(*true_deg, pose.turn_deg), pose.reliable))
            })
            .collect();
        let errors = |wanted: fn(bool) -> bool| {
            PoseErrors::of(answered.iter().filter(|(_, reliable)| wanted(*reliable)).map(|a| a.0).collect())
        };
        (!asked.is_empty()).then(|| Poses {
            answered: Rate::of(answered.len(), asked.len()),
            errors: errors(|_| true),
            reliable: Rate::among(answered.iter().map(|(_, reliable)| *reliable)),
            reliable_errors: errors(|reliable| reliable),
        })
    }
}

impl fmt::Display for ObjectEvaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let training_s = self.training_ms / 1e3;
        row(
            f,
            "trained",
            &format_args!(
                "{} pictures of {} labels, {}×{} px, {} dimensions, {training_s:.2} s",
                self.exemplars, self.labels, self.width_px, self.height_px, self.dimension
            ),
        )?;
        row(f, "recognised", &format_args!("{} of known objects: the likeliest is right", self.recognised))?;
        row(f, "named right", &format_args!("{} of known objects: accepted and right", self.named_right))?;
        row(f, "accepted", &format_args!("{} of known objects", self.accepted))?;
        if let Some(refused) = &self.refused {
            row(f, "refused", &format_args!("{refused} without a known object"))?;
        }
        if let Some(poses) = &self.poses {
            row(f, "poses", &format_args!("{} of those named right", poses.answered))?;
            if let Some(errors) = &poses.errors {
                row(f, "pose error", errors)?;
            }
            row(f, "reliable", &format_args!("{} of these poses", poses.reliable))?;
            if let Some(errors) = &poses.reliable_errors {
                row(f, "pose error", &format_args!("{errors}, of the reliable"))?;
            }
        }
        for (n, ObjectPoses { label, poses }) in self.poses_by_object.iter().enumerate() {
            let name = if n == 0 { "by object" } else { "" };
            let reliable = poses.reliable;
            match &poses.errors {
                Some(errors) => row(f, name, &format_args!("{label}: {errors}; reliable {reliable}"))?,
                None => row(f, name, &format_args!("{label}: no pose"))?,
            }
        }
        let Times { p50_ms, p95_ms } = self.decode;
        row(f, "decode", &format_args!("{p50_ms:.2} ms a picture (p95 {p95_ms:.2}), one thread"))?;
        let [p50_us, p95_us] = [self.recognise.p50_ms, self.recognise.p95_ms].map(|ms| 1e3 * ms);
        row(f, "recognise", &format_args!("{p50_us:.0} µs a picture (p95 {p95_us:.0}), one thread"))?;
        closing_rows(f, &self.confusion, &self.untrained_labels, &self.skipped)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::super::files::training_and_queries;
    use super::*;
    use landmarkd_core::imaging::encode::png_gray8;

    const SIDE_PX: usize = 32;

    /// A bright wedge on black that points where it is turned, of one of some widths.
    fn write_wedge(path: &Path, half_width_deg: f64, turn_deg: f64) {
        let middle = SIDE_PX as f64 / 2.0;
        let gray = |x: usize, y: usize| {
            let (dx, dy) = (x as f64 + 0.5 - middle, y as f64 + 0.5 - middle);
            let (radius, bearing_deg) = (dx.hypot(dy), dy.atan2(dx).to_degrees());
            let aside = angular_distance_deg(bearing_deg, turn_deg) / half_width_deg;
            if radius < 14.0 { (255.0 * (1.5 - aside).clamp(0.0, 1.0)) as u8 } else { 0 }
        };
        let pixels: Vec<u8> = (0..SIDE_PX * SIDE_PX).map(|i| gray(i % SIDE_PX, i / SIDE_PX)).collect();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, png_gray8(SIDE_PX, SIDE_PX, &pixels)).unwrap();
    }

    /// Chequers, which no wedge is like.
    fn write_chequers(path: &Path) {
        let gray = |x: usize, y: usize| if (x / 4 + y / 4).is_multiple_of(2) { 200 } else { 20 };
        let pixels: Vec<u8> = (0..SIDE_PX * SIDE_PX).map(|i| gray(i % SIDE_PX, i / SIDE_PX)).collect();
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, png_gray8(SIDE_PX, SIDE_PX, &pixels)).unwrap();
    }

    /// Two wedges seen every 15 degrees, and asked in between.
    fn write_wedges(folder: &Path) {
        for (label, half_width_deg) in [("narrow", 35.0), ("wide", 80.0)] {
            for turn_deg in (0..360).step_by(15) {
                let name = format!("train/{label}/view__{turn_deg}.png");
                write_wedge(&folder.join(name), half_width_deg, f64::from(turn_deg));
            }
            for turn_deg in [7.5, 100.0, 233.0, 352.5] {
                let name = format!("queries/{label}/view__{turn_deg}.png");
                write_wedge(&folder.join(name), half_width_deg, turn_deg);
            }
        }
    }

    fn evaluated(folder: &Path, queries: &str) -> ObjectEvaluation {
        let files = training_and_queries(&folder.join("train"), &folder.join(queries)).unwrap();
        evaluate(&ObjectOptions::default(), &files, &mut |_, _| ()).unwrap()
    }

    #[test]
    fn wedges_are_named_with_their_turn_and_chequers_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        write_wedges(folder.path());
        write_chequers(&folder.path().join("queries/unknown/a.png"));
        write_chequers(&folder.path().join("queries/carpet/b__30.png"));
        let files =
            training_and_queries(&folder.path().join("train"), &folder.path().join("queries")).unwrap();
        let mut reported = Vec::new();
        let evaluation =
            evaluate(&ObjectOptions::default(), &files, &mut |done, total| reported.push((done, total)))
                .unwrap();
        println!("{evaluation}");
        assert_eq!((evaluation.exemplars, evaluation.labels), (48, 2));
        assert_eq!((evaluation.width_px, evaluation.height_px), (SIDE_PX, SIDE_PX));
        assert_eq!(evaluation.recognised, Rate::of(8, 8));
        assert_eq!(evaluation.named_right, Rate::of(8, 8));
        assert_eq!(evaluation.refused, Some(Rate::of(2, 2)));
        assert_eq!(evaluation.untrained_labels, ["carpet"]);
        assert!(evaluation.confusion.is_empty() && evaluation.skipped.is_empty());
        assert_eq!(reported, (1..=58).map(|done| (done, 58)).collect::<Vec<_>>());
        let poses = evaluation.poses.unwrap();
        let errors = poses.errors.unwrap();
        assert_eq!((poses.answered, errors.within_5_deg), (Rate::of(8, 8), Rate::of(8, 8)));
        let labels: Vec<&str> = evaluation.poses_by_object.iter().map(|o| o.label.as_str()).collect();
        assert_eq!(labels, ["narrow", "wide"]);
        assert!(evaluation.poses_by_object.iter().all(|o| o.poses.answered == Rate::of(4, 4)));
    }

    #[test]
    fn the_json_has_what_the_table_says() {
        let folder = tempfile::tempdir().unwrap();
        write_wedges(folder.path());
        let evaluation = evaluated(folder.path(), "queries");
        let table = evaluation.to_string();
        assert!(table.contains("named right   1.000 (8 of 8)"), "{table}");
        assert!(table.contains("µs a picture"), "{table}");
        let json = serde_json::to_value(&evaluation).unwrap();
        assert_eq!((&json["named_right"]["trials"], &json["refused"]), (&8.into(), &Value::Null));
        assert_eq!(json["poses"]["errors"]["trials"], 8);
        assert_eq!(json["poses_by_object"][1]["label"], "wide");
        assert_eq!(json["poses_by_object"][1]["reliable"]["trials"], 4);
    }

    #[test]
    fn a_manifest_gives_labels_and_true_poses() {
        let folder = tempfile::tempdir().unwrap();
        write_wedges(folder.path());
        fs::copy(folder.path().join("queries/wide/view__100.png"), folder.path().join("a.png")).unwrap();
        let manifest = r#"{"train": [], "queries": [{"file": "a.png", "label": "wide", "pose_deg": 280},
            {"file": "a.png", "label": "narrow", "pose_deg": 100}, {"file": "a.png", "label": "wide"}]}"#;
        fs::write(folder.path().join("manifest.json"), manifest).unwrap();
        let elsewhere = folder.path().join("views");
        fs::rename(folder.path().join("train"), &elsewhere).unwrap();
        let files = training_and_queries(&elsewhere, &folder.path().join("manifest.json")).unwrap();
        let evaluation = evaluate(&ObjectOptions::default(), &files, &mut |_, _| ()).unwrap();
        assert_eq!(evaluation.named_right, Rate::of(2, 3));
        let pair = Confusion { shown: "narrow".into(), named: Some("wide".into()), times: 1 };
        assert_eq!(evaluation.confusion, [pair]);
        let errors = evaluation.poses.unwrap().errors.unwrap();
        assert_eq!(errors.trials, 1, "only the one that was named right and has a true pose");
        assert!(errors.worst_deg > 170.0, "the truth is wrong by half a turn: {errors}");
    }

    #[test]
    fn pictures_that_cannot_be_used_are_named_and_skipped() {
        let folder = tempfile::tempdir().unwrap();
        write_wedges(folder.path());
        let train = folder.path().join("train/wide");
        fs::copy(train.join("view__0.png"), train.join("again__360.png")).unwrap();
        fs::write(train.join("broken__5.png"), b"no picture").unwrap();
        fs::write(folder.path().join("queries/wide/broken.png"), b"no picture").unwrap();
        let evaluation = evaluated(folder.path(), "queries");
        assert_eq!(evaluation.exemplars, 48);
        let skipped: Vec<&str> =
            evaluation.skipped.iter().map(|s| s.file.rsplit('/').next().unwrap()).collect();
        assert_eq!(skipped, ["again__360.png", "broken__5.png", "broken.png"]);
        assert!(evaluation.skipped[0].reason.contains("360° is not in [0, 360)"));
    }

    #[test]
    fn nothing_to_train_on_is_an_error() {
        let file = LabelledFile { label: Some("cup".into()), path: "absent.png".into(), pose_deg: None };
        let files = Files { training: vec![file], queries: Vec::new() };
        let error = evaluate(&ObjectOptions::default(), &files, &mut |_, _| ()).unwrap_err();
        assert!(matches!(
            error,
            EvaluateError::ObjectTraining { source: TrainingError::TooFew { views: 0 } }
        ));
    }
}
