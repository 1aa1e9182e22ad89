//! Past paper A, on objects: matches that agree on a placement. Trained on one picture each of the 20 objects of
//! COIL-20, with signatures of intensity, calibrated as a training job does, and of gradients, asked with 120 frames a condition (six of each
//! object), seed 31; and with 60 photographs without any object.

use landmarkd_core::angle::angular_distance_deg;
use landmarkd_core::recognition::landmarks::{
    LandmarkOptions, Landmarks, Method, Signature, Viewpoint, Warning,
};

use crate::composites::{Condition, Truth, compose, compose_several, photograph};
use crate::objects::{self, ON_BLACK, ON_PHOTOGRAPH, Objects};
use crate::random::Random;
use crate::trials::{calibrated, trained};

const SEED: u64 = 31;

fn intensity() -> LandmarkOptions {
    LandmarkOptions::with_signature(Method::Placement, Viewpoint::Free, Signature::Intensity)
}

const FRAMES_PER_OBJECT: u64 = 6;
const UNKNOWN: u64 = 60;

/// What came of the frames of one condition.
#[derive(Default)]
struct Tally {
    trials: usize,
    /// Best vote right.
    first: usize,
    /// Decided rightly, and decided wrongly.
    named: usize,
    misnamed: usize,
    /// Of the best votes that were right: placed within 6 px and 5 degrees.
    placed: usize,
}

impl Tally {
    fn say(&self, name: &str) {
        let part = |count: usize| count as f64 / self.trials as f64;
        println!(
            "{name}: first {:.3}, named {:.3}, misnamed {:.3} of {}; within 6 px and 5 degrees {:.3} of {}",
            part(self.first),
            part(self.named),
            part(self.misnamed),
            self.trials,
            self.placed as f64 / self.first as f64,
            self.first,
        );
    }
}

fn near(truth: &Truth, x_px: f32, y_px: f32, rotation_rad: f32) -> bool {
    let off = (f64::from(x_px) - truth.x_px).hypot(f64::from(y_px) - truth.y_px);
    off <= 6.0 && angular_distance_deg(f64::from(rotation_rad).to_degrees(), truth.rotation_deg) <= 5.0
}

fn asked(
    model: &Landmarks,
    objects: &Objects,
    pose: usize,
    condition: Condition,
    frames_per_object: u64,
) -> Tally {
    let mut tally = Tally::default();
    for (n, picture) in objects.pictures[pose].iter().enumerate() {
        for k in 0..frames_per_object {
            let (frame, truth) = compose(picture, &objects.photographs, condition, SEED, &[n as u64, k]);
            let recognition = model.recognise(&frame, |_| ());
            tally.trials += 1;
            if let Some(decision) = &recognition.decision {
                let right = decision.label == n.to_string();
                tally.named += usize::from(right);
                tally.misnamed += usize::from(!right);
            }
            if let Some(best) = recognition.votes.first().filter(|vote| vote.label == n.to_string()) {
                tally.first += 1;
                let placement = best.placement.expect("votes have a placement").placement;
                tally.placed +=
                    usize::from(near(&truth, placement.x_px, placement.y_px, placement.rotation_rad));
            }
        }
    }
    tally
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn clutter_and_occluders_do_not_fool_the_placement_and_what_is_unknown_is_not_named() {
    let objects = Objects::read();
    let (model, reliability) = calibrated(&objects.training, &intensity());
    println!("intensity, calibrated: {reliability:?}");
    assert_names_what_is_known(&model, &objects);
    println!("gradient:");
    assert_names_what_is_known(&trained(&objects.training, &LandmarkOptions::default()), &objects);
}

/// Under all conditions, and leaves photographs without an object undecided.
fn assert_names_what_is_known(model: &Landmarks, objects: &Objects) {
    let conditions = [
        ("turned, on black", 0, ON_BLACK, 0.97),
        ("turned, on a photograph", 0, ON_PHOTOGRAPH, 0.97),
        ("turned, 30 % hidden", 0, Condition { hidden: 0.3, ..ON_BLACK }, 0.97),
        ("turned, on a photograph, 30 % hidden", 0, Condition { hidden: 0.3, ..ON_PHOTOGRAPH }, 0.97),
        ("5 degrees further on the turntable, turned, on a photograph", 1, ON_PHOTOGRAPH, 0.97),
        ("turned, on a photograph, half hidden", 0, Condition { hidden: 0.5, ..ON_PHOTOGRAPH }, 0.90),
        (
            "scaled by 0.7 to 1.4, turned, on a photograph",
            0,
            Condition { scale: (0.7, 1.4), ..ON_PHOTOGRAPH },
            0.90,
        ),
    ];
    let mut firsts = Vec::new();
    for (name, pose, condition, least) in conditions {
        let tally = asked(model, objects, pose, condition, FRAMES_PER_OBJECT);
        tally.say(name);
        let first = tally.first as f64 / tally.trials as f64;
        assert!(first >= least, "{name}: {first:.3}");
        assert!(tally.misnamed * 50 <= tally.trials, "{name}: {} misnamed", tally.misnamed);
        assert!(tally.placed * 10 >= tally.first * 9, "{name}: {} of {} placed", tally.placed, tally.first);
        firsts.push(first);
    }
    let mean = firsts[..5].iter().sum::<f64>() / 5.0;
    println!("mean of the first five: {mean:.4}");
    assert!(mean >= 0.985);

    let unknown = (0..UNKNOWN).map(|k| photograph(&objects.photographs, SEED, &[k]));
    let refused = unknown.filter(|frame| model.recognise(frame, |_| ()).decision.is_none()).count();
    println!("photographs without an object: {refused} of {UNKNOWN} refused");
    assert!(refused as f64 >= 0.95 * UNKNOWN as f64);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn two_and_three_known_objects_in_one_frame_are_all_found() {
    let objects = Objects::read();
    let (calibrated, _) = calibrated(&objects.training, &intensity());
    let gradients = trained(&objects.training, &LandmarkOptions::default());
    for (model, count) in [(&calibrated, 2), (&calibrated, 3), (&gradients, 2), (&gradients, 3)] {
        let mut all = 0;
        for k in 0..30 {
            let mut random = Random::of(SEED, &[4, count as u64, k]);
            let mut shown: Vec<usize> = Vec::new();
            while shown.len() < count {
                let object = random.below(objects.training.len());
                if !shown.contains(&object) {
                    shown.push(object);
                }
            }
            let pictures: Vec<_> = shown.iter().map(|&n| &objects.pictures[0][n]).collect();
            let key = [count as u64, k];
            let (frame, truths) = compose_several(&pictures, &objects.photographs, SEED, &key);
            let instances = model.recognise(&frame, |_| ()).instances;
            let found = shown.iter().zip(&truths).filter(|(n, truth)| {
                instances.iter().any(|instance| {
                    let placement = instance.verified.placement;
                    instance.label == n.to_string()
                        && near(truth, placement.x_px, placement.y_px, placement.rotation_rad)
                })
            });
            all += usize::from(found.count() == count);
        }
        println!("{count} objects in a frame: all found in {all} of 30");
        assert!(all >= 27, "{all} of 30");
    }
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn votes_that_fall_on_the_background_are_unsure_and_say_so() {
    // A's Figure 7: a small part of the object is seen, and most of the strongest points lie elsewhere
    let objects = Objects::read();
    let failing = Condition { hidden: 0.6, scale: (0.7, 0.8), ..ON_PHOTOGRAPH };
    for options in [objects::options(), LandmarkOptions::of(Method::Paper, Viewpoint::Free)] {
        let (model, _) = calibrated(&objects.training, &options);
        let (mut misled, mut decided_wrongly, mut warned) = (0, 0, 0);
        for (n, picture) in objects.pictures[0].iter().enumerate() {
            for k in 0..3 {
                let (frame, _) = compose(picture, &objects.photographs, failing, SEED, &[n as u64, k]);
                let recognition = model.recognise(&frame, |_| ());
                if recognition.votes[0].label == n.to_string() {
                    continue;
                }
                misled += 1;
                decided_wrongly += usize::from(recognition.decision.is_some());
                let says_why = |warning: &Warning| matches!(warning, Warning::VotesOnBackground { .. });
                warned += usize::from(recognition.warnings.iter().any(says_why));
            }
        }
        println!("the paper's vote misled in {misled} of 60: {decided_wrongly} named wrong, {warned} warned");
        assert!(misled >= 30, "the case isn't rebuilt: {misled}");
        assert!(decided_wrongly * 20 <= misled, "{decided_wrongly}");
        assert!(warned * 10 >= misled * 9, "{warned}");
    }
    let (model, _) = calibrated(&objects.training, &intensity());
    let tally = asked(&model, &objects, 0, failing, 3);
    tally.say("the placement on the same frames");
    assert!(tally.misnamed * 50 <= tally.trials, "{} misnamed", tally.misnamed);
    assert!(tally.first * 2 >= tally.trials, "{} right", tally.first);
}
