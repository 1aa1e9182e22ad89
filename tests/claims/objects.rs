//! Paper A on objects: trained on one picture each of the 20 objects of COIL-20, asked with 60 frames a claim
//! (three of each object), seed 7. Floors are the rates of the numpy reference on 240 such frames, less what
//! chance explains on 60.

use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::recognition::landmarks::{LandmarkOptions, Method, Taper, Viewpoint};

use crate::composites::{Condition, compose};
use crate::data;
use crate::trials::{Outcome, asked, trained};

const SEED: u64 = 7;
const OBJECTS: usize = 20;
const FRAMES_PER_OBJECT: u64 = 3;

pub const ON_BLACK: Condition = Condition { on_photograph: false, hidden: 0.0, scale: (1.0, 1.0) };
pub const ON_PHOTOGRAPH: Condition = Condition { on_photograph: true, ..ON_BLACK };

/// The reference's settings of the paper's method: windows of radius 10, which describe more of an object than the paper's 5.
pub fn options() -> LandmarkOptions {
    LandmarkOptions {
        subwindow_radii_px: vec![10.0],
        rings: 10,
        ..LandmarkOptions::of(Method::Paper, Viewpoint::Free)
    }
}

pub struct Objects {
    pub training: Vec<Frame>,
    /// At the training pose, and 5 degrees further on the turntable.
    pub pictures: [Vec<Image>; 2],
    pub photographs: Vec<Image>,
}

impl Objects {
    pub fn read() -> Objects {
        let folder = data::folder();
        let at = |pose_deg| (1..=OBJECTS).map(|n| data::coil_20(&folder, n, pose_deg)).collect::<Vec<_>>();
        let pictures = [at(0), at(5)];
        let training = pictures[0].iter().cloned().map(Frame::gray).collect();
        Objects { training, pictures, photographs: data::photographs(&folder) }
    }

    fn frames(&self, pictures: &[Image], condition: Condition) -> Vec<(usize, Frame)> {
        let trials = (0..pictures.len()).flat_map(|n| (0..FRAMES_PER_OBJECT).map(move |k| (n, k)));
        trials
            .map(|(n, k)| (n, compose(&pictures[n], &self.photographs, condition, SEED, &[n as u64, k]).0))
            .collect()
    }

    fn asked(&self, condition: Condition) -> Outcome {
        asked(&trained(&self.training, &options()), &self.frames(&self.pictures[0], condition))
    }
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn objects_turned_by_any_angle_are_recognised() {
    let objects = Objects::read();
    let outcome = objects.asked(ON_BLACK);
    outcome.say("turned, on black");
    assert!(outcome.right >= 58, "{} of 60", outcome.right);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn objects_on_a_photograph_are_recognised_more_often_than_not() {
    let objects = Objects::read();
    let outcome = objects.asked(ON_PHOTOGRAPH);
    outcome.say("turned, on a photograph");
    outcome.assert_reaches(0.70);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn objects_with_a_third_hidden_are_recognised() {
    let objects = Objects::read();
    let outcome = objects.asked(Condition { hidden: 0.3, ..ON_BLACK });
    outcome.say("turned, 30 % hidden");
    outcome.assert_reaches(0.79);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn objects_on_a_photograph_with_a_third_hidden_are_still_found_more_often_than_not() {
    let objects = Objects::read();
    let outcome = objects.asked(Condition { hidden: 0.3, ..ON_PHOTOGRAPH });
    outcome.say("turned, on a photograph, 30 % hidden");
    outcome.assert_reaches(0.59);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn a_pose_five_degrees_away_is_close_enough() {
    let objects = Objects::read();
    let frames = objects.frames(&objects.pictures[1], ON_PHOTOGRAPH);
    let outcome = asked(&trained(&objects.training, &options()), &frames);
    outcome.say("5 degrees further on the turntable, turned, on a photograph");
    outcome.assert_reaches(0.63);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn tapering_along_the_angle_too_spoils_turned_objects() {
    let objects = Objects::read();
    let frames = objects.frames(&objects.pictures[0], ON_BLACK);
    let with = |taper| asked(&trained(&objects.training, &LandmarkOptions { taper, ..options() }), &frames);
    let (radial, literal) = (with(Taper::Radial), with(Taper::Literal));
    radial.say("turned, on black, taper over the radius");
    literal.say("turned, on black, taper as the text has it");
    // the reference: 1.00 against 0.55
    assert!(literal.rate() + 0.2 < radial.rate(), "the periodic axis needs no taper");
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn more_interest_points_recognise_more() {
    let objects = Objects::read();
    let frames = objects.frames(&objects.pictures[0], ON_PHOTOGRAPH);
    let rates = [5, 16, 64, 128].map(|points| {
        let options = LandmarkOptions { interest_points: points, query_points: points, ..options() };
        let outcome = asked(&trained(&objects.training, &options), &frames);
        outcome.say(&format!("turned, on a photograph, {points} points"));
        outcome.rate()
    });
    // the reference on 240 frames: 0.53, 0.58, 0.70, 0.76; neighbours may change places by chance on 60
    assert!(rates[0] < rates[2] && rates[1] < rates[3], "{rates:?}");
    assert!(rates[0] + 0.1 < rates[3], "{rates:?}");
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn brightness_and_contrast_of_the_whole_frame_hardly_matter() {
    let objects = Objects::read();
    let frames = objects.frames(&objects.pictures[0], ON_PHOTOGRAPH);
    let model = trained(&objects.training, &options());
    let plain = asked(&model, &frames);
    plain.say("turned, on a photograph");
    for (gain, offset) in [(0.5, 0.0), (0.7, 60.0), (1.0, -20.0)] {
        let changed: Vec<(usize, Frame)> =
            frames.iter().map(|(n, frame)| (*n, relit(frame, gain, offset))).collect();
        let outcome = asked(&model, &changed);
        outcome.say(&format!("the same, grey levels × {gain} {offset:+}"));
        let difference = plain.right.abs_diff(outcome.right);
        assert!(difference <= 4, "{difference} of 60 frames more or less");
    }
}

/// Whole grey levels, held within 0..=255, as another exposure of a camera gives them.
fn relit(frame: &Frame, gain: f32, offset: f32) -> Frame {
    let grey = &frame.luminance;
    let relit = grey.pixels().iter().map(|v| (v * gain + offset).round().clamp(0.0, 255.0)).collect();
    Frame::gray(Image::new(grey.width(), grey.height(), relit))
}
