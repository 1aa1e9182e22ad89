//! What the training of an object database told of itself.

use serde::Serialize;
use utoipa::ToSchema;

use super::TrainingTimings;
use crate::database::{
    ConfusionReport, DimensionRateReport, GapReport, HeldOutReport, ObjectsReport, OneObjectReport,
    PoseErrorsReport,
};

/// What the training of an object database told of itself. Rates are of views that were left out.
#[derive(Debug, Serialize, ToSchema)]
pub struct ObjectsReportBody {
    /// Variance along the directions of the universal eigenspace, descending; for more than 1500 views the leading
    /// ones.
    pub spectrum: Vec<f64>,
    /// Part of the variance that the kept dimensions hold.
    pub energy_kept: f64,
    /// Dimensions kept.
    pub dimension: u64,
    /// Width of the database's pictures.
    pub width_px: u64,
    /// Height of the database's pictures.
    pub height_px: u64,
    /// Components of an appearance.
    pub vector_length: u64,
    /// Left-out views whose nearest eigenpoint is of their own object, by dimension.
    pub rate_by_dimension: Vec<DimensionRateBody>,
    /// Left-out views that were taken for another object, or for none.
    pub confusion: Vec<ConfusionBody>,
    /// How left-out views and unknown objects fared; null if no object has two views.
    pub held_out: Option<HeldOutBody>,
    /// By object.
    pub objects: Vec<OneObjectBody>,
    /// Pairs of exemplars that are all but the same picture.
    pub near_duplicates: Vec<[String; 2]>,
    /// Pairs of exemplars of one object with one pose: their mean is taken.
    pub repeated_poses: Vec<[String; 2]>,
    /// Exemplars with too many pixels as bright as can be.
    pub over_exposed: Vec<String>,
    /// Exemplars with hardly a bright pixel.
    pub under_exposed: Vec<String>,
    /// Exemplars that are black, or in which nothing stands out to be cut out: they were left out.
    pub blank: Vec<String>,
    /// Exemplars that were not of the database's size, and were scaled.
    pub resized: Vec<String>,
    /// With `segment`: exemplars whose object reaches the picture's border, which may cut it.
    pub touches_border: Vec<String>,
    /// With `segment`: exemplars in which another thing is nearly as large; the largest was learnt.
    pub several_regions: Vec<String>,
    /// Where it was trained here: how long that took.
    pub timings_ms: Option<TrainingTimings>,
}

/// Left-out views recognised at a dimension.
#[derive(Debug, Serialize, ToSchema)]
pub struct DimensionRateBody {
    pub dimension: u64,
    pub right: u64,
    pub trials: u64,
}

/// Left-out views of one object that were given one wrong answer.
#[derive(Debug, Serialize, ToSchema)]
pub struct ConfusionBody {
    /// The object shown.
    pub shown: String,
    /// The object named; null when none was.
    pub named: Option<String>,
    pub times: u64,
}

/// Each view in turn was left out of its object and shown, and was shown to the other objects alone. The threshold was
/// chosen on the same views: others may fare worse.
#[derive(Debug, Serialize, ToSchema)]
pub struct HeldOutBody {
    /// Views of objects with at least two.
    pub known: u64,
    /// Of these, accepted as something.
    pub known_accepted: u64,
    /// Of these, named right.
    pub known_right: u64,
    /// Views shown to the other objects alone.
    pub unknown: u64,
    /// Of these, refused.
    pub unknown_refused: u64,
}

/// What is known of one object.
#[derive(Debug, Serialize, ToSchema)]
pub struct OneObjectBody {
    pub label: String,
    pub views: u64,
    /// Of these, with a pose.
    pub views_with_pose: u64,
    /// The largest total distance that is accepted as this object; null if it could not be told.
    pub threshold: Option<f64>,
    /// Pose errors of left-out views; null if there are too few.
    pub pose: Option<PoseErrorsBody>,
    /// Poses that no view is near: the pose isn't reliable there.
    pub gaps: Vec<GapBody>,
}

/// Errors of the pose of left-out views, which see twice the gap that a picture to recognise sees.
#[derive(Debug, Serialize, ToSchema)]
pub struct PoseErrorsBody {
    pub trials: u64,
    pub mean_deg: f64,
    pub median_deg: f64,
    pub p95_deg: f64,
    /// How many were within 5°.
    pub within_5_deg: u64,
}

/// From one view's pose to the next; across 0 the second is the smaller one.
#[derive(Debug, Serialize, ToSchema)]
pub struct GapBody {
    pub from_deg: f64,
    pub to_deg: f64,
}

impl From<ObjectsReport> for ObjectsReportBody {
    fn from(report: ObjectsReport) -> Self {
        let pairs = |pairs: Vec<(String, String)>| pairs.into_iter().map(|(a, b)| [a, b]).collect();
        Self {
            spectrum: report.spectrum,
            energy_kept: report.energy_kept,
            dimension: report.dimension,
            width_px: report.width_px,
            height_px: report.height_px,
            vector_length: report.vector_length,
            rate_by_dimension: report.rate_by_dimension.into_iter().map(DimensionRateBody::from).collect(),
            confusion: report.confusion.into_iter().map(ConfusionBody::from).collect(),
            held_out: report.held_out.map(HeldOutBody::from),
            objects: report.objects.into_iter().map(OneObjectBody::from).collect(),
            near_duplicates: pairs(report.near_duplicates),
            repeated_poses: pairs(report.repeated_poses),
            over_exposed: report.over_exposed,
            under_exposed: report.under_exposed,
            blank: report.blank,
            resized: report.resized,
            touches_border: report.touches_border,
            several_regions: report.several_regions,
            timings_ms: report.timings_ms.map(TrainingTimings::from),
        }
    }
}

impl From<DimensionRateReport> for DimensionRateBody {
    fn from(DimensionRateReport { dimension, right, trials }: DimensionRateReport) -> Self {
        Self { dimension, right, trials }
    }
}

impl From<ConfusionReport> for ConfusionBody {
    fn from(ConfusionReport { shown, named, times }: ConfusionReport) -> Self {
        Self { shown, named, times }
    }
}

impl From<HeldOutReport> for HeldOutBody {
    fn from(held_out: HeldOutReport) -> Self {
        Self {
            known: held_out.known,
            known_accepted: held_out.known_accepted,
            known_right: held_out.known_right,
            unknown: held_out.unknown,
            unknown_refused: held_out.unknown_refused,
        }
    }
}

impl From<OneObjectReport> for OneObjectBody {
    fn from(object: OneObjectReport) -> Self {
        Self {
            label: object.label,
            views: object.views,
            views_with_pose: object.views_with_pose,
            threshold: object.threshold,
            pose: object.pose.map(PoseErrorsBody::from),
            gaps: object.gaps.into_iter().map(GapBody::from).collect(),
        }
    }
}

impl From<PoseErrorsReport> for PoseErrorsBody {
    fn from(errors: PoseErrorsReport) -> Self {
        Self {
            trials: errors.trials,
            mean_deg: errors.mean_deg,
            median_deg: errors.median_deg,
            p95_deg: errors.p95_deg,
            within_5_deg: errors.within_5_deg,
        }
    }
}

impl From<GapReport> for GapBody {
    fn from(GapReport { from_deg, to_deg }: GapReport) -> Self {
        Self { from_deg, to_deg }
    }
}
