//! A frame with its recognition drawn on it, for people.

use super::model::Landmarks;
use super::recognition::{LabelVote, PointVote, Recognition, VerifiedPlacement};
use crate::imaging::{Frame, Overlay};

/// Points that voted for the best label, and accepted placements.
const FOR_BEST: [u8; 3] = [64, 224, 96];
/// Points that voted for another label.
const FOR_OTHERS: [u8; 3] = [240, 150, 40];
/// The best placement where nothing is decided.
const UNSURE: [u8; 3] = [150, 150, 160];
const TEXT: [u8; 3] = [255, 255, 255];
/// Lines of the list of votes.
const LINES: usize = 3;
/// Half the length of the cross in the middle of an outline.
const CROSS_PX: f32 = 4.0;

/// Draws a circle of the sub-window's radius around each point that voted, the outline and the middle of every instance,
/// and the best votes as text.
///
/// Green points voted for the best label, orange ones for another. The upper edge of an outline is drawn twice. Where
/// nothing is decided the best placement is drawn in gray.
pub fn annotate(frame: &Frame, recognition: &Recognition, model: &Landmarks) -> Overlay {
    let mut overlay = Overlay::on(frame);
    draw_points(&mut overlay, recognition, model);
    draw_placements(&mut overlay, recognition, model);
    for (line, text) in lines(recognition).enumerate() {
        let top_px = overlay.line_height_px() * (line as f32 + 0.25);
        overlay.text(4.0, top_px, &text, TEXT);
    }
    overlay
}

fn draw_points(overlay: &mut Overlay, recognition: &Recognition, model: &Landmarks) {
    let best = recognition.votes.first();
    let radius_px = model.options().subwindow_radii_px[0] as f32;
    // beside outlines only the points that count are drawn
    let outlined = best.is_some_and(|vote| vote.placement.is_some());
    let counts = |point: &&PointVote| !outlined || point.weight > 0.0;
    for point in recognition.points.iter().filter(counts) {
        let label = &model.exemplars()[point.exemplar].label;
        let is_best = best.is_some_and(|vote| vote.label == *label);
        overlay.circle(point.x_px, point.y_px, radius_px, if is_best { FOR_BEST } else { FOR_OTHERS });
    }
}

/// Outlines the instances, or the best placement where there are none.
fn draw_placements(overlay: &mut Overlay, recognition: &Recognition, model: &Landmarks) {
    let best = recognition.votes.first().and_then(|vote| vote.placement.as_ref());
    match &recognition.decision {
        None => best.into_iter().for_each(|best| outline(overlay, best, model, UNSURE)),
        // the model isn't calibrated
        Some(_) if recognition.instances.is_empty() => {
            best.into_iter().for_each(|best| outline(overlay, best, model, FOR_BEST));
        }
        Some(_) => {}
    }
    for instance in &recognition.instances {
        outline(overlay, &instance.verified, model, FOR_BEST);
        let text = format!("{} {:.2}", instance.label, instance.confidence);
        let centre = &instance.verified.placement;
        overlay.text(centre.x_px + CROSS_PX, centre.y_px + CROSS_PX, &text, FOR_BEST);
    }
}

/// The decision and the best votes.
fn lines(recognition: &Recognition) -> impl Iterator<Item = String> {
    let decision = match &recognition.decision {
        None => "nothing for sure".to_owned(),
        Some(decision) => match decision.confidence {
            Some(confidence) => format!("{}, confidence {confidence:.2}", decision.label),
            None => decision.label.clone(),
        },
    };
    let vote =
        |vote: &LabelVote| format!("{}  {:.0}%  {} points", vote.label, 100.0 * vote.share, vote.points);
    std::iter::once(decision).chain(recognition.votes.iter().take(LINES).map(vote))
}

/// The border of an exemplar's picture at its placement, and a cross in its middle.
fn outline(overlay: &mut Overlay, verified: &VerifiedPlacement, model: &Landmarks, colour: [u8; 3]) {
    let exemplar = &model.exemplars()[verified.exemplar];
    let (width_px, height_px) = (exemplar.width_px, exemplar.height_px);
    let placement = &verified.placement;
    let corners = verified.outline_px(width_px, height_px);
    let mut line = |from: [f32; 2], to: [f32; 2]| overlay.line(from[0], from[1], to[0], to[1], colour);
    for (k, &from) in corners.iter().enumerate() {
        line(from, corners[(k + 1) % corners.len()]);
    }
    let second = 2.0 / placement.scale - 0.5;
    let along = |x: f32| verified.apply([x, second], width_px, height_px);
    line(along(-0.5), along(width_px as f32 - 0.5));
    let [x, y] = [placement.x_px, placement.y_px];
    line([x - CROSS_PX, y], [x + CROSS_PX, y]);
    line([x, y - CROSS_PX], [x, y + CROSS_PX]);
}

#[cfg(test)]
mod tests {
    use super::super::pictures::intensity;
    use super::super::{
        Decision, Evidence, ExemplarName, Instance, LandmarkOptions, Method, Placement, Viewpoint, describe,
    };
    use super::*;
    use crate::imaging::Image;

    fn disc() -> Frame {
        Frame::gray(Image::from_fn(80, 80, |x, y| {
            let (dx, dy) = (x as f32 - 40.0, y as f32 - 44.0);
            if dx * dx + dy * dy < 64.0 { 210.0 } else { 30.0 }
        }))
    }

    fn model(options: &LandmarkOptions) -> Landmarks {
        let name = ExemplarName { id: "1".into(), label: "disc".into() };
        Landmarks::train(vec![describe(name, &disc(), options)], options).unwrap().0
    }

    fn drawn(recognition: &Recognition, model: &Landmarks) -> Frame {
        let png = annotate(&disc(), recognition, model).into_png();
        crate::imaging::decode(&png, &crate::imaging::DecodeLimits::default()).unwrap()
    }

    fn count(picture: &Frame, colour: [u8; 3]) -> usize {
        picture.to_rgb8().chunks_exact(3).filter(|pixel| *pixel == colour).count()
    }

    #[test]
    fn points_for_the_best_label_are_green() {
        let model = model(&LandmarkOptions::of(Method::Paper, Viewpoint::Free));
        let picture = drawn(&model.recognise(&disc(), |_| ()), &model);
        assert!(count(&picture, FOR_BEST) > 0);
        assert_eq!(count(&picture, FOR_OTHERS) + count(&picture, UNSURE), 0);
    }

    #[test]
    fn the_outline_is_green_where_it_is_sure_and_gray_where_it_is_not() {
        let model = model(&intensity(Viewpoint::Free));
        let placement = Placement { x_px: 39.5, y_px: 39.5, rotation_rad: 0.3, scale: 0.6 };
        let verified =
            VerifiedPlacement { exemplar: 0, placement, homography: None, inliers: 9, agreement: 0.8 };
        let vote = LabelVote {
            label: "disc".into(),
            weight: 1.0,
            share: 1.0,
            points: 9,
            placement: Some(verified),
            a_contrario: None,
        };
        let unsure = Recognition {
            a_contrario: None,
            also: vec![],
            agreeing: Vec::new(),
            reasons: vec![],
            decision: None,
            points_found: 9,
            points_used: 9,
            votes: vec![vote],
            instances: vec![],
            points: vec![],
            exemplar_weights: vec![1.0],
            evidence: Evidence::None,
            warnings: vec![],
        };
        // enlarged four times: four edges of 0.6 × 80 px, the upper one twice, and a cross
        let expected = 4 * (5 * 48 + 16);
        let about = |pixels: usize| (expected * 8 / 10..expected * 11 / 10).contains(&pixels);
        let picture = drawn(&unsure, &model);
        assert!(about(count(&picture, UNSURE)) && count(&picture, FOR_BEST) == 0);
        let confidence = 0.9;
        let sure = Recognition {
            decision: Some(Decision { label: "disc".into(), confidence: Some(confidence) }),
            instances: vec![Instance { label: "disc".into(), confidence, verified }],
            ..unsure
        };
        let picture = drawn(&sure, &model);
        assert!(count(&picture, FOR_BEST) > expected * 8 / 10 && count(&picture, UNSURE) == 0);
    }
}
