//! Rehearsals: a view's picture seen otherwise (in other light, a pixel aside, with noise), so that the right answer is
//! known.

use super::manifold::apart_deg;
use super::model::{Objects, ViewName};
use crate::imaging::{Frame, Image, Random};

/// So many views are rehearsed, spread over all; fewer than [`FEW_VIEWS`] several times each.
const REHEARSED_VIEWS: usize = 200;
const FEW_VIEWS: usize = 64;
/// Standard deviation of the noise, grey levels.
const NOISE: f64 = 4.0;
/// Least and most part of the light.
const GAIN: [f64; 2] = [0.8, 1.2];
/// Farthest that the picture is moved along an axis.
const SHIFT_PX: f64 = 1.0;
/// A pose that is farther from the true one is wrong.
const POSE_DEG: f64 = 10.0;

/// A view's picture seen otherwise, always the same for the same name and round; rounds tell apart several rehearsals
/// of one picture.
pub fn rehearsal(name: &ViewName, picture: &Frame, round: u64) -> Frame {
    let seed = name.id.bytes().fold(round, |seed, byte| seed.wrapping_mul(31).wrapping_add(u64::from(byte)));
    let random = &mut Random::new(seed, round);
    let gain = random.between(GAIN[0], GAIN[1]);
    let mut shift = || random.between(-SHIFT_PX, SHIFT_PX);
    let (right, down) = (shift(), shift());
    let luminance = &picture.luminance;
    let last = (luminance.width() - 1, luminance.height() - 1);
    Frame::gray(Image::from_fn(luminance.width(), luminance.height(), |px, py| {
        let (x, y) =
            ((px as f64 - right).clamp(0.0, last.0 as f64), (py as f64 - down).clamp(0.0, last.1 as f64));
        let (left, top) = (x as usize, y as usize);
        let (across, along) = (x - left as f64, y - top as f64);
        let at =
            |dx: usize, dy: usize| f64::from(luminance.at((left + dx).min(last.0), (top + dy).min(last.1)));
        let upper = at(0, 0) + across * (at(1, 0) - at(0, 0));
        let lower = at(0, 1) + across * (at(1, 1) - at(0, 1));
        let value = gain * (upper + along * (lower - upper)) + NOISE * random.normals()[0];
        value.round().clamp(0.0, 255.0) as f32
    }))
}

impl Objects {
    /// Which views to rehearse, by index, and how often each.
    pub fn rehearsed_views(&self) -> (Vec<usize>, u64) {
        let count = self.names.len();
        let chosen = count.min(REHEARSED_VIEWS);
        ((0..chosen).map(|i| i * count / chosen).collect(), FEW_VIEWS.div_ceil(chosen.max(1)) as u64)
    }

    /// Whether the database names a rehearsed view rightly, and turned as it is where it calls the pose reliable.
    pub fn judge(&self, name: &ViewName, rehearsal: &Frame) -> bool {
        let Ok(recognition) = self.recognise(rehearsal, |_| ()) else { return false };
        recognition.decision.is_some_and(|decision| {
            let reliable = decision.pose.filter(|pose| pose.reliable);
            let turned_so = match (reliable, name.pose_deg) {
                (Some(pose), Some(pose_deg)) => apart_deg(pose.turn_deg, pose_deg) <= POSE_DEG,
                _ => true,
            };
            decision.label == name.label && turned_so
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::ObjectOptions;
    use super::super::pictures::{SIDE_PX, canvas, thing, turntable};
    use super::*;

    fn name(label: &str, pose_deg: f64) -> ViewName {
        ViewName { id: format!("{label} {pose_deg}"), label: label.into(), pose_deg: Some(pose_deg) }
    }

    #[test]
    fn a_rehearsal_is_repeated_by_its_round_alone() {
        let (picture, name) = (thing(1, 20.0), name("thing1", 20.0));
        let seen = rehearsal(&name, &picture, 3);
        assert_eq!((seen.width(), seen.height()), (SIDE_PX, SIDE_PX));
        assert_eq!(seen.to_rgb8(), rehearsal(&name, &picture, 3).to_rgb8());
        assert_ne!(seen.to_rgb8(), rehearsal(&name, &picture, 4).to_rgb8());
        assert_ne!(seen.to_rgb8(), picture.to_rgb8());
    }

    #[test]
    fn what_is_known_is_judged_right_and_another_label_or_pose_wrong() {
        let options = ObjectOptions::default();
        let (model, _) = Objects::train(turntable(4, 10, &options), &canvas(&options), &options).unwrap();
        let picture = thing(1, 40.0);
        assert!(model.judge(&name("thing1", 40.0), &picture));
        assert!(!model.judge(&name("thing2", 40.0), &picture));
        let decision = model.recognise(&picture, |_| ()).unwrap().decision.unwrap();
        let reliable = decision.pose.is_some_and(|pose| pose.reliable);
        assert_eq!(model.judge(&name("thing1", 90.0), &picture), !reliable);
    }

    #[test]
    fn few_views_are_rehearsed_several_times() {
        let options = ObjectOptions::default();
        let model =
            |things| Objects::train(turntable(things, 10, &options), &canvas(&options), &options).unwrap().0;
        let (chosen, rounds) = model(1).rehearsed_views();
        assert_eq!((chosen.len(), rounds), (36, 2));
        let (chosen, rounds) = model(8).rehearsed_views();
        assert_eq!((chosen.len(), chosen[199], rounds), (200, 286, 1));
    }
}
