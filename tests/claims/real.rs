//! Past paper A, on pictures that people took: one or three pictures of a thing or place are taught, others asked, and
//! frames of something else beside them. Sets and truth are those of the files under `real` (docs/data.md).

use std::path::Path;

use landmarkd_core::imaging::{DecodeLimits, Frame, decode_reduced};
use landmarkd_core::recognition::landmarks::{
    ExemplarName, LandmarkOptions, Landmarks, Method, Viewpoint, describe,
};
use serde::Deserialize;

use crate::data::folder;

/// What is taught and asked: files relative to the set's.
#[derive(Deserialize)]
struct Set {
    /// Label and file.
    train: Vec<(String, String)>,
    /// The labels that are right, none for a strange frame; and the file.
    query: Vec<(Vec<String>, String)>,
}

/// What came of a set.
#[derive(Debug, Default)]
struct Tally {
    known: usize,
    strange: usize,
    best: usize,
    decided: usize,
    wrong: usize,
    strange_decided: usize,
}

fn tally(set: &str, options: &LandmarkOptions) -> Tally {
    let folder = folder().join("real");
    let text = std::fs::read_to_string(folder.join(format!("{set}.json"))).expect("the set is there");
    let set_of: Set = serde_json::from_str(&text).expect("it is a set");
    let frame = |file: &str| read(&folder.join(file), options);
    let described = set_of.train.iter().enumerate().map(|(number, (label, file))| {
        describe(ExemplarName { id: number.to_string(), label: label.clone() }, &frame(file), options)
    });
    let (model, _) = Landmarks::train(described.collect(), options).expect("a model");
    let mut tally = Tally::default();
    for (labels, file) in &set_of.query {
        let recognition = model.recognise(&frame(file), |_| ());
        let decision = recognition.decision.map(|decision| decision.label);
        if labels.is_empty() {
            tally.strange += 1;
            tally.strange_decided += usize::from(decision.is_some());
            continue;
        }
        tally.known += 1;
        tally.best += usize::from(recognition.votes.first().is_some_and(|vote| labels.contains(&vote.label)));
        match decision {
            Some(label) if labels.contains(&label) => tally.decided += 1,
            Some(_) => tally.wrong += 1,
            None => {}
        }
    }
    println!("{set}: {tally:?}");
    tally
}

fn read(path: &Path, options: &LandmarkOptions) -> Frame {
    let bytes = std::fs::read(path).expect("the picture is there");
    let side_px = options.working_size_px.expect("gradients have a working size");
    decode_reduced(&bytes, &DecodeLimits::default(), side_px).expect("it is a picture")
}

impl Tally {
    /// At least these parts of the known frames, at most so many wrong and strange ones.
    fn assert(&self, best: f64, decided: f64, wrong: usize, strange_decided: usize) {
        let part = |count: usize| count as f64 / self.known as f64;
        assert!(part(self.best) >= best && part(self.decided) >= decided, "{self:?}");
        assert!(self.wrong <= wrong && self.strange_decided <= strange_decided, "{self:?}");
    }
}

fn upright() -> LandmarkOptions {
    LandmarkOptions::of(Method::Placement, Viewpoint::Upright)
}

#[test]
#[ignore = "needs LANDMARKD_DATA"]
fn paintings_taught_from_the_web_are_known_on_phone_pictures() {
    tally("paintings", &LandmarkOptions::default()).assert(0.98, 0.98, 0, 1);
}

#[test]
#[ignore = "needs LANDMARKD_DATA"]
fn buildings_are_known_from_across_the_street_more_often_than_not() {
    tally("buildings", &LandmarkOptions::default()).assert(0.8, 0.6, 1, 1);
}

#[test]
#[ignore = "needs LANDMARKD_DATA"]
fn a_lab_is_known_from_a_metre_aside() {
    for set in ["lab", "lab24"] {
        tally(set, &LandmarkOptions::default()).assert(0.95, 0.95, 1, 0);
    }
}

#[test]
#[ignore = "needs LANDMARKD_DATA"]
fn rooms_are_known_the_better_the_more_pictures_are_taught() {
    let decided = ["basement1", "basement3", "basement10"].map(|set| {
        let tally = tally(set, &upright());
        assert!(tally.wrong <= 1 && tally.strange_decided <= 2, "{tally:?}");
        tally.decided
    });
    assert!(decided.is_sorted(), "{decided:?}");
}
