//! A picture with its recognition drawn on it, for people: candidates as text, the pose as a dial.

use super::recognition::{Candidate, Pose, Recognition};
use crate::imaging::{Frame, Overlay};

/// The candidate that was accepted, and a reliable pose.
const ACCEPTED: [u8; 3] = [64, 224, 96];
/// Candidates that were not, and a pose that is not reliable.
const DOUBTFUL: [u8; 3] = [240, 150, 40];
/// The dial's circle and its mark at 0°.
const DIAL: [u8; 3] = [160, 160, 160];
const TEXT: [u8; 3] = [255, 255, 255];
/// Most candidates in the list.
const MAX_LINES: usize = 3;
/// The dial's radius as a part of the picture's shorter side.
const DIAL_RADIUS: f32 = 0.14;

/// Draw the likeliest objects with their distances as text, and the pose as a dial in the lower right corner.
///
/// The dial is the turntable from above: 0° points down, towards the camera, and the turn grows anticlockwise. The
/// hand is green if the pose is reliable and orange if not; a short orange hand is the alternative.
pub fn annotate(frame: &Frame, recognition: &Recognition) -> Overlay {
    let mut overlay = Overlay::on(frame);
    let decision = recognition.decision.as_ref();
    let line_px = overlay.line_height_px();
    if decision.is_none() {
        overlay.text(4.0, 0.25 * line_px, "unknown", DOUBTFUL);
    }
    let first = usize::from(decision.is_none());
    for (line, candidate) in recognition.candidates.iter().take(MAX_LINES).enumerate() {
        let accepted = decision.is_some_and(|decision| decision.label == candidate.label);
        let top_px = line_px * ((first + line) as f32 + 0.25);
        overlay.text(4.0, top_px, &candidate_text(candidate), if accepted { ACCEPTED } else { DOUBTFUL });
    }
    if let Some(pose) = decision.and_then(|decision| decision.pose) {
        draw_dial(&mut overlay, frame, &pose);
    }
    overlay
}

/// Label, and the part of the object that is explained with the least that is accepted; of intensities the total distance
/// (B(16): in the space and from it) with the largest.
fn candidate_text(candidate: &Candidate) -> String {
    let Candidate { label, explained, least_explained, threshold, .. } = candidate;
    let distance = candidate.distance_in_space.hypot(candidate.distance_from_space);
    match (explained, least_explained, threshold) {
        (Some(part), Some(least), _) => {
            format!("{label}  {:.0}% (least {:.0}%)", 100.0 * part, 100.0 * least)
        }
        (Some(part), None, _) => format!("{label}  {:.0}%", 100.0 * part),
        (None, _, Some(threshold)) => format!("{label}  {distance:.3} of {threshold:.3}"),
        (None, _, None) => format!("{label}  {distance:.3}"),
    }
}

fn draw_dial(overlay: &mut Overlay, frame: &Frame, pose: &Pose) {
    let (width_px, height_px) = (frame.width() as f32, frame.height() as f32);
    let radius_px = DIAL_RADIUS * width_px.min(height_px);
    let (x_px, y_px) = (width_px - 1.5 * radius_px, height_px - 1.5 * radius_px);
    let towards = |turn_deg: f64, part: f32| {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        (x_px + part * radius_px * sin as f32, y_px + part * radius_px * cos as f32)
    };
    overlay.circle(x_px, y_px, radius_px, DIAL);
    let ((from_x_px, from_y_px), (to_x_px, to_y_px)) = (towards(0.0, 0.85), towards(0.0, 1.15));
    overlay.line(from_x_px, from_y_px, to_x_px, to_y_px, DIAL);
    if let Some(alternative_deg) = pose.alternative_deg {
        let (to_x_px, to_y_px) = towards(alternative_deg, 0.6);
        overlay.line(x_px, y_px, to_x_px, to_y_px, DOUBTFUL);
    }
    let (to_x_px, to_y_px) = towards(pose.turn_deg, 1.0);
    overlay.line(x_px, y_px, to_x_px, to_y_px, if pose.reliable { ACCEPTED } else { DOUBTFUL });
    let line_px = overlay.line_height_px();
    let text = format!("{:.1}\u{b0} \u{b1}{:.1}\u{b0}", pose.turn_deg, pose.sigma_deg);
    overlay.text(4.0, height_px - 1.25 * line_px, &text, TEXT);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::{DecodeLimits, Image, decode};
    use crate::recognition::objects::Decision;

    fn recognition(pose: Option<Pose>, decided: bool) -> Recognition {
        let candidate = |label: &str, distance_in_space| Candidate {
            label: label.into(),
            distance_in_space,
            distance_from_space: 0.01,
            threshold: Some(0.2),
            mahalanobis: None,
            explained: None,
            least_explained: None,
        };
        let decision =
            decided.then(|| Decision { label: "mug".into(), confidence: Some(0.9), pose, alignment: None });
        let candidates = vec![candidate("mug", 0.05), candidate("jug", 0.4)];
        Recognition { decision, candidates, reasons: Vec::new(), warnings: Vec::new() }
    }

    /// How many pixels of a colour stand right of and below the middle.
    fn drawn(recognition: &Recognition, colour: [u8; 3]) -> (usize, usize) {
        let frame = Frame::gray(Image::from_fn(320, 320, |_, _| 0.0));
        let picture = decode(&annotate(&frame, recognition).into_png(), &DecodeLimits::default()).unwrap();
        let bytes = picture.to_rgb8();
        let is_it = |at: usize| bytes[3 * at..3 * at + 3] == colour;
        let (inside, outside): (Vec<usize>, Vec<usize>) =
            (0..320 * 320).filter(|&at| is_it(at)).partition(|at| at % 320 > 160 && at / 320 > 160);
        (inside.len(), outside.len())
    }

    fn pose(reliable: bool, alternative_deg: Option<f64>) -> Option<Pose> {
        Some(Pose { turn_deg: 70.0, sigma_deg: 1.5, reliable, alternative_deg })
    }

    #[test]
    fn the_hand_is_green_only_if_the_pose_is_reliable() {
        let (reliable, doubtful) =
            (recognition(pose(true, None), true), recognition(pose(false, None), true));
        assert!(drawn(&reliable, ACCEPTED).0 > 30 && drawn(&reliable, DOUBTFUL).0 == 0);
        assert!(drawn(&doubtful, DOUBTFUL).0 > 30 && drawn(&doubtful, ACCEPTED).0 == 0);
    }

    #[test]
    fn an_alternative_is_a_hand_of_its_own() {
        let both = recognition(pose(true, Some(250.0)), true);
        assert!(drawn(&both, ACCEPTED).0 > 30 && drawn(&both, DOUBTFUL).0 > 20);
    }

    #[test]
    fn without_a_decision_there_is_no_dial_and_no_green() {
        let unknown = recognition(None, false);
        assert_eq!(drawn(&unknown, ACCEPTED), (0, 0));
        assert_eq!(drawn(&unknown, DIAL).0, 0);
        assert!(drawn(&unknown, DOUBTFUL).1 > 50, "the text is there");
    }
}
