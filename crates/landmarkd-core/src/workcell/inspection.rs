//! An inspection: overview → regions → cut out, recognised, located.

use super::Workcell;
use crate::imaging::Frame;
use crate::recognition::objects::{self, Objects, Recognition};
use crate::vision::segmentation::{Region, Segmentation, segmented};

/// The steps of an inspection, in their order; the last two come anew with every region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Threshold, components, regions.
    Segment,
    /// A region cut out, centred and scaled, as a vector.
    Cut,
    /// Which object, and how turned.
    Recognise,
}

/// A part on the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    pub region: Region,
    /// Where its centroid is, X and Y; `None` beyond the horizon of a homography.
    pub robot_mm: Option<[f64; 2]>,
    /// Direction of its principal axis, in [−90, 90), from X towards Y; `None` if it has none.
    pub robot_deg: Option<f64>,
    pub recognition: Recognition,
}

/// What stands on the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    pub segmentation: Segmentation,
    /// One for each region, in their order.
    pub parts: Vec<Part>,
}

/// Look at the table. `finished` is told the end of each stage: the caller holds the clock.
pub fn inspect(
    overview: &Frame,
    workcell: &Workcell,
    model: &Objects,
    mut finished: impl FnMut(Stage),
) -> Inspection {
    let segmentation = segmented(&overview.luminance, &workcell.segmentation); // B§3
    finished(Stage::Segment);
    let part = |region: &Region| {
        let recognition = model.recognise_region(&overview.luminance, &segmentation, region, |stage| {
            finished(match stage {
                objects::Stage::Appearance => Stage::Cut,
                objects::Stage::Universal | objects::Stage::Object => Stage::Recognise, // B§5
            });
        });
        let at_px = region.centroid_px;
        Part {
            robot_mm: workcell.mapping.robot_mm(at_px),
            robot_deg: region.orientation_deg.and_then(|deg| workcell.mapping.axis_deg(at_px, deg)),
            region: region.clone(),
            recognition,
        }
    };
    let parts = segmentation.regions.iter().map(part).collect();
    Inspection { segmentation, parts }
}
