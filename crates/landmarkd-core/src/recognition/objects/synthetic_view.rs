//! Synthetic views: the picture of a view with another gain, a shift of up to a pixel, and noise, so that the right
//! answer is known.

use super::disturbance::Disturbance;
use super::model::{Objects, ViewName};
use crate::angle::angular_distance_deg;
use crate::imaging::{Frame, Random, seed_of_name};

/// Most views that synthetic ones are made of, spread over all.
const MAX_VIEWS: usize = 200;
/// With fewer views each is used several times.
const MIN_TRIALS: usize = 64;
/// Standard deviation of the noise, gray levels.
const NOISE: f64 = 4.0;
/// Least and largest gain.
const GAIN: [f64; 2] = [0.8, 1.2];
/// Largest shift along an axis.
const SHIFT_PX: f64 = 1.0;
/// A pose with a larger error is wrong.
const MAX_ERROR_DEG: f64 = 10.0;

/// A synthetic view of a picture: always the same for the same name and round, and another for each round.
pub fn synthetic_view(name: &ViewName, picture: &Frame, round: u64) -> Frame {
    let seed = seed_of_name(&name.id, round);
    let random = &mut Random::new(seed, round);
    let mut shift = || random.between(-SHIFT_PX, SHIFT_PX) / picture.width().max(picture.height()) as f64;
    let shift = [shift(), shift()];
    let gain = random.between(GAIN[0], GAIN[1]);
    Disturbance { gain, shift, noise: NOISE, ..Disturbance::NONE }.of(picture, seed)
}

/// The views of a database that synthetic ones are made of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewSample {
    /// Indices into [`Objects::views`].
    pub views: Vec<usize>,
    /// Synthetic views of each.
    pub rounds: u64,
}

impl ViewSample {
    /// Up to 200 views, spread evenly; with fewer than 64 several rounds.
    pub fn of(model: &Objects) -> ViewSample {
        let count = model.views.len();
        let chosen = count.min(MAX_VIEWS);
        ViewSample {
            views: (0..chosen).map(|i| i * count / chosen).collect(),
            rounds: MIN_TRIALS.div_ceil(chosen.max(1)) as u64,
        }
    }
}

/// Whether the database gives a picture the label of the view, and its pose if it calls that reliable.
pub fn recognises_view(model: &Objects, name: &ViewName, picture: &Frame) -> bool {
    let Ok(recognition) = model.recognise(picture, |_| ()) else { return false };
    recognition.decision.is_some_and(|decision| {
        let reliable = decision.pose.filter(|pose| pose.reliable);
        let pose_is_right = match (reliable, name.pose_deg) {
            (Some(pose), Some(pose_deg)) => angular_distance_deg(pose.turn_deg, pose_deg) <= MAX_ERROR_DEG,
            _ => true,
        };
        decision.label == name.label && pose_is_right
    })
}

#[cfg(test)]
mod tests {
    use super::super::test_pictures::{SIDE_PX, normaliser, thing, turntable};
    use super::super::{ObjectOptions, train};
    use super::*;

    fn name(label: &str, pose_deg: f64) -> ViewName {
        ViewName { id: format!("{label} {pose_deg}"), label: label.into(), pose_deg: Some(pose_deg) }
    }

    #[test]
    fn a_synthetic_view_is_repeated_by_its_round_alone() {
        let (picture, name) = (thing(1, 20.0), name("thing1", 20.0));
        let view = synthetic_view(&name, &picture, 3);
        assert_eq!((view.width(), view.height()), (SIDE_PX, SIDE_PX));
        assert_eq!(view.to_rgb8(), synthetic_view(&name, &picture, 3).to_rgb8());
        assert_ne!(view.to_rgb8(), synthetic_view(&name, &picture, 4).to_rgb8());
        assert_ne!(view.to_rgb8(), picture.to_rgb8());
    }

    #[test]
    fn what_is_known_is_judged_right_and_another_label_or_pose_wrong() {
        let options = ObjectOptions::default();
        let (model, _) = train(turntable(4, 10, &options), &normaliser(&options), &options).unwrap();
        let picture = thing(1, 40.0);
        assert!(recognises_view(&model, &name("thing1", 40.0), &picture));
        assert!(!recognises_view(&model, &name("thing2", 40.0), &picture));
        let decision = model.recognise(&picture, |_| ()).unwrap().decision.unwrap();
        let reliable = decision.pose.is_some_and(|pose| pose.reliable);
        assert_eq!(recognises_view(&model, &name("thing1", 90.0), &picture), !reliable);
    }

    #[test]
    fn few_views_are_shown_several_times() {
        let options = ObjectOptions::default();
        let sample = |things| {
            let views = turntable(things, 10, &options);
            ViewSample::of(&train(views, &normaliser(&options), &options).unwrap().0)
        };
        let few = sample(1);
        assert_eq!((few.views.len(), few.rounds), (36, 2));
        let many = sample(8);
        assert_eq!((many.views.len(), many.views[199], many.rounds), (200, 286, 1));
    }
}
