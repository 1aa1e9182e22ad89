//! Regions and parts drawn on the picture, for people.

use super::{Inspection, Part};
use crate::imaging::{Frame, Overlay};
use crate::vision::segmentation::{Region, Segmentation};

/// A known object, and a reliable pose.
const KNOWN: [u8; 3] = [64, 224, 96];
/// An unknown object, and a pose that is not reliable.
const UNKNOWN: [u8; 3] = [240, 150, 40];
/// A region that is not recognised.
const REGION: [u8; 3] = [80, 200, 240];
const TEXT: [u8; 3] = [255, 255, 255];

/// Draw the outline, centroid, principal axis and id of every region.
pub fn annotate_regions(frame: &Frame, segmentation: &Segmentation) -> Overlay {
    let mut overlay = Overlay::on(frame);
    outline(&mut overlay, segmentation, |_| REGION);
    for region in &segmentation.regions {
        mark(&mut overlay, region, REGION);
        write(&mut overlay, region, &[Line { text: region.id.to_string(), colour: TEXT }]);
    }
    overlay
}

/// Draw every part with its label, its pose, its place in the robot's plane and its distance.
pub fn annotate(frame: &Frame, inspection: &Inspection) -> Overlay {
    let mut overlay = Overlay::on(frame);
    outline(&mut overlay, &inspection.segmentation, |id| part_colour(&inspection.parts[id - 1]));
    for part in &inspection.parts {
        mark(&mut overlay, &part.region, part_colour(part));
        write(&mut overlay, &part.region, &lines(part));
    }
    overlay
}

fn part_colour(part: &Part) -> [u8; 3] {
    if part.recognition.decision.is_some() { KNOWN } else { UNKNOWN }
}

/// A line of text beside a region.
struct Line {
    text: String,
    colour: [u8; 3],
}

fn lines(part: &Part) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut line = |text, colour| lines.push(Line { text, colour });
    match &part.recognition.decision {
        None => line(format!("{} unknown", part.region.id), UNKNOWN),
        Some(decision) => {
            line(format!("{} {}", part.region.id, decision.label), KNOWN);
            if let Some(pose) = decision.pose {
                let text = format!("{:.1}\u{b0} \u{b1}{:.1}\u{b0}", pose.turn_deg, pose.sigma_deg);
                line(text, if pose.reliable { KNOWN } else { UNKNOWN });
            }
        }
    }
    if let Some([x, y]) = part.robot_mm {
        line(format!("{x:.1}, {y:.1} mm"), TEXT);
    }
    if let Some(distance) = part.distance {
        let sigma = distance.sigma_mm.map_or(String::new(), |mm| format!(" \u{b1}{mm:.1}"));
        line(format!("{:.1}{sigma} mm far", distance.distance_mm), TEXT);
    }
    lines
}

/// The edges between pixels of a region and others.
fn outline(overlay: &mut Overlay, segmentation: &Segmentation, colour: impl Fn(usize) -> [u8; 3]) {
    let (width, height) = (segmentation.width(), segmentation.height());
    let id = |x: usize, y: usize| usize::from(segmentation.labels()[y * width + x]);
    for y in 0..height {
        for x in 0..width {
            let own = id(x, y);
            let (at_x, at_y) = (x as f32 + 0.5, y as f32 + 0.5);
            if x + 1 < width && id(x + 1, y) != own {
                let colour = colour(own.max(id(x + 1, y)));
                overlay.line(at_x, at_y - 1.0, at_x, at_y, colour);
            }
            if y + 1 < height && id(x, y + 1) != own {
                let colour = colour(own.max(id(x, y + 1)));
                overlay.line(at_x - 1.0, at_y, at_x, at_y, colour);
            }
        }
    }
}

/// The centroid, and the principal axis as long as the region is.
fn mark(overlay: &mut Overlay, region: &Region, colour: [u8; 3]) {
    let [x, y] = region.centroid_px.map(|v| v as f32);
    overlay.circle(x, y, 3.0, colour);
    if let Some(orientation_deg) = region.orientation_deg {
        let (sin, cos) = orientation_deg.to_radians().sin_cos();
        // Of an ellipse: the longer half axis.
        let half = (region.area_px as f64 * region.elongation / std::f64::consts::PI).sqrt();
        let (dx, dy) = ((half * cos) as f32, (half * sin) as f32);
        overlay.line(x - dx, y - dy, x + dx, y + dy, colour);
    }
}

/// Write lines to the right of the region's box.
fn write(overlay: &mut Overlay, region: &Region, lines: &[Line]) {
    let bounds = region.bbox_px;
    let (x, y) = ((bounds.x + bounds.width) as f32 + 2.0, bounds.y as f32);
    let line_px = overlay.line_height_px();
    for (number, line) in lines.iter().enumerate() {
        overlay.text(x, y + number as f32 * line_px, &line.text, line.colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::{DecodeLimits, Image, decode};
    use crate::recognition::objects::{Decision, Pose, Recognition};
    use crate::vision::segmentation::{SegmentationOptions, segmented};
    use crate::workcell::PartDistance;

    fn frame() -> Frame {
        Frame::gray(Image::from_fn(400, 300, |x, y| {
            if (60..140).contains(&x) && (100..140).contains(&y) { 120.0 } else { 10.0 }
        }))
    }

    /// How many pixels of a colour stand in the region's half of the picture.
    fn drawn(overlay: Overlay, colour: [u8; 3]) -> usize {
        let picture = decode(&overlay.into_png(), &DecodeLimits::default()).unwrap();
        picture.to_rgb8().chunks(3).filter(|rgb| *rgb == colour).count()
    }

    #[test]
    fn a_region_is_outlined() {
        let frame = frame();
        let seen = segmented(&frame.luminance, &SegmentationOptions::default());
        let picture = decode(&annotate_regions(&frame, &seen).into_png(), &DecodeLimits::default()).unwrap();
        let rgb = picture.to_rgb8();
        let at = |x: usize, y: usize| &rgb[3 * (y * 400 + x)..][..3];
        let near = |x: usize, y: usize| (x - 1..=x + 1).any(|x| (y - 1..=y + 1).any(|y| at(x, y) == REGION));
        assert!(near(60, 120) && near(139, 120) && near(80, 100) && near(80, 139), "its four sides");
        assert!(near(100, 120) && at(80, 110) != REGION && at(300, 250) != REGION);
        assert!(drawn(annotate_regions(&frame, &seen), TEXT) > 4, "its id");
    }

    #[test]
    fn what_is_known_is_green_and_what_is_not_is_orange() {
        let frame = frame();
        let segmentation = segmented(&frame.luminance, &SegmentationOptions::default());
        let inspection = |decision: Option<Decision>, distance: Option<PartDistance>| Inspection {
            parts: vec![Part {
                region: segmentation.regions[0].clone(),
                robot_mm: Some([120.0, -30.0]),
                robot_deg: None,
                recognition: Recognition {
                    decision,
                    candidates: Vec::new(),
                    reasons: Vec::new(),
                    warnings: Vec::new(),
                },
                is_in_pair: distance.is_some(),
                distance,
            }],
            segmentation: segmentation.clone(),
            warnings: Vec::new(),
        };
        let drawn_with =
            |decision, depth, colour| drawn(annotate(&frame, &inspection(decision, depth)), colour);
        let pose = |reliable| Pose { turn_deg: 70.0, sigma_deg: 1.5, reliable, alternative_deg: None };
        let known = |reliable| Decision {
            label: "mug".into(),
            confidence: None,
            pose: Some(pose(reliable)),
            alignment: None,
        };
        let count = |decision, colour| drawn_with(decision, None, colour);
        assert!(count(Some(known(true)), KNOWN) > 200 && count(Some(known(true)), UNKNOWN) == 0);
        assert!(count(Some(known(false)), KNOWN) > 200 && count(Some(known(false)), UNKNOWN) > 20);
        assert!(count(None, UNKNOWN) > 200 && count(None, KNOWN) == 0);
        let far = PartDistance { distance_mm: 500.0, sigma_mm: Some(1.0), coverage: 0.9 };
        let with = drawn_with(None, Some(far), TEXT);
        assert!(with > count(None, TEXT) + 20, "the distance is written");
    }
}
