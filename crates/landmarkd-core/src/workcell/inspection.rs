//! An inspection: the regions of an overview, each cropped, recognised and located; with a focal pair their distances.

use std::sync::Arc;

use thiserror::Error;

use super::{PartDistance, Workcell};
use crate::depth::{
    self, Calibration, DepthMap, DepthOptions, EstimateError, Estimator, EstimatorError, FocalPair,
};
use crate::imaging::Frame;
use crate::recognition::objects::{self, Objects, Recognition};
use crate::vision::segmentation::{Region, Segmentation, segmented, segmented_from_near};

/// The steps of an inspection, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Threshold, components, regions.
    Segment,
    /// The normalised crop of a region, as a vector; once for each region.
    Crop,
    /// Which object, and its pose; twice for each region.
    Recognise,
    /// The depth estimator made ready.
    Design,
    /// The depth map, and the distances of the parts.
    Depth,
}

/// A part on the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its region of the overview.
    pub region: Region,
    /// Where its centroid is, X and Y; `None` beyond the horizon of a homography.
    pub robot_mm: Option<[f64; 2]>,
    /// Direction of its principal axis, in [−90, 90), from X towards Y; `None` if it has none.
    pub robot_deg: Option<f64>,
    /// Which object it is, and its pose.
    pub recognition: Recognition,
    /// Whether a focal pair shows it.
    pub is_in_pair: bool,
    /// Its distance; `None` if no pair shows it, or none of its pixels has a depth.
    pub distance: Option<PartDistance>,
}

/// The parts on a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Of the overview.
    pub segmentation: Segmentation,
    /// One for each region, in their order.
    pub parts: Vec<Part>,
    /// Doubts about the inspection as a whole.
    pub warnings: Vec<Warning>,
}

/// A doubt about an inspection, or about a segmentation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Warning {
    /// Nothing stands out from the background.
    NoRegion,
    /// There are more regions than the most objects.
    MoreRegions,
    /// A region may be several parts that touch.
    Touching,
    /// A region is so large that it may be the table, and the background what is around that.
    LargeRegion,
    /// Hardly any of the picture is ground, so that its level is a guess.
    LittleGround,
    /// The ground's texture is so strong that parts of little contrast are not seen.
    TexturedGround,
    /// A line on the ground was left out.
    LineLeftOut,
    /// Shadows were left out.
    ShadowsLeftOut,
    /// A part's dark side may be its shadow.
    PerhapsShadow,
    /// What is nearly as large as the least area was left out.
    SmallLeftOut,
    /// The database was trained without `segment`: its exemplars are not normalised crops, as the parts are.
    NotSegmented,
    /// Nothing stands out in the near-focused picture.
    NoRegionInPair,
    /// About the depth map.
    Depth(depth::Warning),
}

/// A region of this part of the picture is large.
const LARGE_PART: f64 = 0.4;
/// Less of the picture than this is little ground.
const LITTLE_PART: f32 = 0.2;
/// An offset of more than this part of the picture's range is that of a strong texture.
const TEXTURED_PART: f32 = 0.2;

impl Warning {
    /// The doubts about a segmentation.
    pub fn about(segmentation: &Segmentation) -> Vec<Warning> {
        let Segmentation { regions, found, left_out, noise, .. } = segmentation;
        let large_px = LARGE_PART * (segmentation.width() * segmentation.height()) as f64;
        let nearly_px = left_out.least_area_px.div_ceil(2);
        let doubts = [
            (Warning::NoRegion, regions.is_empty()),
            (Warning::MoreRegions, *found > regions.len()),
            (Warning::Touching, regions.iter().any(|region| !region.pieces.is_empty())),
            (Warning::LargeRegion, regions.first().is_some_and(|region| region.area_px as f64 > large_px)),
            (Warning::LittleGround, noise.is_some_and(|noise| noise.ground_part < LITTLE_PART)),
            (
                Warning::TexturedGround,
                noise
                    .is_some_and(|noise| noise.averaged_px > 1 && noise.offset > TEXTURED_PART * noise.range),
            ),
            (Warning::LineLeftOut, left_out.lines > 0),
            (Warning::ShadowsLeftOut, left_out.shadows.left_out > 0),
            (Warning::PerhapsShadow, left_out.shadows.doubtful > 0),
            (Warning::SmallLeftOut, left_out.small_areas_px.first().is_some_and(|&area| area >= nearly_px)),
        ];
        doubts.into_iter().filter(|(_, is_doubtful)| *is_doubtful).map(|(warning, _)| warning).collect()
    }

    /// A short name for programs.
    pub fn code(self) -> String {
        let code = match self {
            Warning::NoRegion => "no_region",
            Warning::MoreRegions => "more_regions",
            Warning::Touching => "touching",
            Warning::LargeRegion => "large_region",
            Warning::LittleGround => "little_ground",
            Warning::TexturedGround => "textured_ground",
            Warning::LineLeftOut => "line_left_out",
            Warning::ShadowsLeftOut => "shadows_left_out",
            Warning::PerhapsShadow => "perhaps_shadow",
            Warning::SmallLeftOut => "small_left_out",
            Warning::NotSegmented => "not_segmented",
            Warning::NoRegionInPair => "no_region_in_pair",
            Warning::Depth(warning) => return format!("depth_{}", warning.word()),
        };
        code.to_owned()
    }
}

/// A focal pair beside the overview, and the scene that it shows.
#[derive(Clone, Copy, Debug)]
pub struct PairView<'a> {
    /// The two pictures.
    pub pair: &'a FocalPair,
    /// What they show.
    pub scene: PairScene,
    /// Of the cameras that took them.
    pub calibration: &'a Calibration,
}

/// The scene of a focal pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairScene {
    /// One part, from near.
    Local {
        /// Id of its region in the overview; `None`: the one nearest the overview's middle.
        region: Option<usize>,
    },
    /// The whole table, pixel by pixel as the overview shows it.
    Overview,
}

/// Why a focal pair doesn't go with an overview.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum InspectionError {
    /// A pair that shows the whole table has another size than the overview. Sizes are (width, height).
    #[error("the pair has {pair_px:?} px and the overview {overview_px:?}")]
    OtherSize {
        /// Size of the overview.
        overview_px: (usize, usize),
        /// Size of the pair.
        pair_px: (usize, usize),
    },
    /// The overview has no region of that id.
    #[error("there is no region {id} among {regions}")]
    UnknownRegion {
        /// The id that was given.
        id: usize,
        /// Number of the overview's regions, which have the ids from 1 on.
        regions: usize,
    },
    /// The calibration gives no estimator.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// The pair can't be measured with the calibration.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
}

/// Find, recognise and locate the parts on a table. Calls `finished` after each stage.
pub fn inspect(
    overview: &Frame,
    workcell: &Workcell,
    model: &Objects,
    mut finished: impl FnMut(Stage),
) -> Inspection {
    let segmentation = segmented(overview, &workcell.segmentation); // B§3
    finished(Stage::Segment);
    let part = |region: &Region| {
        let recognition = model.recognise_region(overview, &segmentation, region, |stage| {
            finished(match stage {
                objects::Stage::Appearance => Stage::Crop,
                objects::Stage::Universal | objects::Stage::Object => Stage::Recognise, // B§5
            });
        });
        let at_px = region.centroid_px;
        Part {
            robot_mm: workcell.mapping.robot_mm(at_px),
            robot_deg: region.orientation_deg.and_then(|deg| workcell.mapping.axis_deg(at_px, deg)),
            region: region.clone(),
            recognition,
            is_in_pair: false,
            distance: None,
        }
    };
    let parts = segmentation.regions.iter().map(part).collect();
    let not_segmented = (!model.options().segment).then_some(Warning::NotSegmented);
    let warnings = Warning::about(&segmentation).into_iter().chain(not_segmented).collect();
    Inspection { segmentation, parts, warnings }
}

/// The same, with the distances of the parts that a focal pair shows. `estimator` makes or finds the estimator of a
/// calibration and options.
///
/// # Errors
/// [`InspectionError`] if the pair doesn't go with the overview or the calibration.
pub fn inspect_with_depth(
    overview: &Frame,
    view: &PairView,
    workcell: &Workcell,
    model: &Objects,
    estimator: impl FnOnce(&Calibration, &DepthOptions) -> Result<Arc<Estimator>, EstimatorError>,
    mut finished: impl FnMut(Stage),
) -> Result<Inspection, InspectionError> {
    let overview_px = (overview.width(), overview.height());
    let pair_px = (view.pair.width(), view.pair.height());
    if view.scene == PairScene::Overview && overview_px != pair_px {
        return Err(InspectionError::OtherSize { overview_px, pair_px });
    }
    let mut inspection = inspect(overview, workcell, model, &mut finished);
    let shown = inspection.shown_region(view.scene)?;
    if inspection.parts.is_empty() {
        return Ok(inspection);
    }
    let estimator = estimator(view.calibration, &depth_options(view.calibration))?;
    finished(Stage::Design);
    let map = estimator.estimate(view.pair, &mut |_| ())?;
    match shown {
        None => inspection.measure_all(&map),
        Some(id) => inspection.measure_one(id, view.pair, workcell, &map),
    }
    inspection.warnings.extend(map.summary.warnings.iter().copied().map(Warning::Depth));
    finished(Stage::Depth);
    Ok(inspection)
}

/// With the method of the filters of a calibration sweep, if it has any: what they were made with measures best.
fn depth_options(calibration: &Calibration) -> DepthOptions {
    let default = DepthOptions::default();
    let method = calibration.filters.as_ref().map_or(default.method, |filters| filters.method);
    DepthOptions { method, ..default }
}

impl Inspection {
    /// Id of the one region that a pair shows; `None` if it shows all.
    fn shown_region(&self, scene: PairScene) -> Result<Option<usize>, InspectionError> {
        match scene {
            PairScene::Overview => Ok(None),
            PairScene::Local { region: None } => Ok(self.segmentation.central().map(|region| region.id)),
            PairScene::Local { region: Some(id) } => match self.segmentation.region(id) {
                Some(_) => Ok(Some(id)),
                None => Err(InspectionError::UnknownRegion { id, regions: self.parts.len() }),
            },
        }
    }

    /// Set the distance of every part by a depth map of the overview's size.
    fn measure_all(&mut self, map: &DepthMap) {
        for part in &mut self.parts {
            part.is_in_pair = true;
            part.distance = PartDistance::of(&part.region, &self.segmentation, map);
        }
    }

    /// Set the distance of the part with that region: it is in the middle of the near-focused picture.
    fn measure_one(&mut self, id: usize, pair: &FocalPair, workcell: &Workcell, map: &DepthMap) {
        let segmentation = segmented_from_near(pair.near(), &workcell.segmentation);
        match segmentation.central() {
            Some(region) => {
                let part = &mut self.parts[id - 1];
                part.is_in_pair = true;
                part.distance = PartDistance::of(region, &segmentation, map);
            }
            None => self.warnings.push(Warning::NoRegionInPair),
        }
    }
}
