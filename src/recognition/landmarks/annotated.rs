//! A frame with its recognition drawn on it: what a person looks at to see why.

use super::model::Landmarks;
use super::vote::Recognition;
use crate::imaging::{Frame, Overlay};

/// Points that voted for the best label.
const FOR_BEST: [u8; 3] = [64, 224, 96];
/// Points that voted for another.
const FOR_OTHERS: [u8; 3] = [240, 150, 40];
const TEXT: [u8; 3] = [255, 255, 255];
/// Lines of the list of votes.
const LINES: usize = 3;

/// Draw a circle of the sub-window's radius around each point that voted, and the best votes as text.
///
/// Green points voted for the best label, orange ones for another.
pub fn annotate(frame: &Frame, recognition: &Recognition, model: &Landmarks) -> Overlay {
    let mut overlay = Overlay::on(frame);
    let best = recognition.votes.first().map(|vote| vote.label.as_str());
    let radius_px = model.options().subwindow_radius_px as f32;
    for point in &recognition.points {
        let label = model.exemplars()[point.exemplar].label.as_str();
        let colour = if Some(label) == best { FOR_BEST } else { FOR_OTHERS };
        overlay.circle(point.x_px, point.y_px, radius_px, colour);
    }
    for (line, vote) in recognition.votes.iter().take(LINES).enumerate() {
        let words = format!("{}  {:.0}%  {} points", vote.label, 100.0 * vote.share, vote.points);
        let top_px = overlay.line_height_px() * (line as f32 + 0.25);
        overlay.text(4.0, top_px, &words, TEXT);
    }
    overlay
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Image;
    use crate::recognition::landmarks::{ExemplarName, LandmarkOptions, describe};

    #[test]
    fn points_for_the_best_label_are_green() {
        let image = Image::from_fn(80, 80, |x, y| {
            let (dx, dy) = (x as f32 - 40.0, y as f32 - 44.0);
            if dx * dx + dy * dy < 64.0 { 210.0 } else { 30.0 }
        });
        let frame = Frame::gray(image);
        let options = LandmarkOptions::default();
        let name = ExemplarName { id: "1".into(), label: "disc".into() };
        let (model, _) = Landmarks::train(vec![describe(name, &frame, &options)], &options).unwrap();
        let recognition = model.recognise(&frame, |_| ());
        let png = annotate(&frame, &recognition, &model).into_png();
        let limits = crate::imaging::DecodeLimits::default();
        let drawn = crate::imaging::decode(&png, &limits).unwrap().to_rgb8();
        assert!(drawn.chunks_exact(3).any(|pixel| pixel == FOR_BEST));
        assert!(!drawn.chunks_exact(3).any(|pixel| pixel == FOR_OTHERS));
    }
}
