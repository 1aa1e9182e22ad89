//! The report of the training of an object database. The members mean what they mean in [`TrainingReport`].

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::TrainingTimings;
use landmarkd_core::recognition::objects as core;
use landmarkd_core::recognition::objects::TrainingReport;

/// What the training of an object database told of itself. Rates are of views that were left out.
// Members that later releases add are optional.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ObjectsReportBody)]
pub struct ObjectsReport {
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
    pub rate_by_dimension: Vec<DimensionRateReport>,
    /// Left-out views that were taken for another object, or for none.
    pub confusion: Vec<ConfusionReport>,
    /// How left-out views and unknown objects fared; null if no object has two views.
    pub held_out: Option<HeldOutReport>,
    /// The least part of an object that a frame has to explain; null with `appearance: "intensity"`, and if it could not be
    /// told.
    #[schema(required = false)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_explained: Option<f64>,
    /// By object.
    pub objects: Vec<ObjectReport>,
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
    #[schema(value_type = Vec<String>, required = true)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touches_border: Option<Vec<String>>,
    /// With `segment`: exemplars in which another thing is nearly as large; the largest was learnt.
    #[schema(value_type = Vec<String>, required = true)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub several_regions: Option<Vec<String>>,
    /// Where it was trained here: how long that took.
    #[schema(value_type = Option<TrainingTimings>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings_ms: Option<Option<TrainingTimings>>,
}

/// Left-out views recognised at a dimension.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = DimensionRateBody)]
pub struct DimensionRateReport {
    pub dimension: u64,
    pub right: u64,
    pub trials: u64,
}

/// Left-out views of one object that were given one wrong answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ConfusionBody)]
pub struct ConfusionReport {
    /// The object shown.
    pub shown: String,
    /// The object named; null when none was.
    pub named: Option<String>,
    pub times: u64,
}

/// Each view in turn was left out of its object and shown, and was shown to the other objects alone. The threshold was
/// chosen on the same views: others may fare worse.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = HeldOutBody)]
pub struct HeldOutReport {
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = OneObjectBody)]
pub struct ObjectReport {
    pub label: String,
    pub views: u64,
    /// Of these, with a pose.
    pub views_with_pose: u64,
    /// The largest total distance that is accepted as this object; null if it could not be told, and where the explained
    /// part decides.
    pub threshold: Option<f64>,
    /// Pose errors of left-out views; null if there are too few.
    pub pose: Option<PoseErrorsReport>,
    /// Poses that no view is near: the pose isn't reliable there.
    pub gaps: Vec<GapReport>,
}

/// Errors of the pose of left-out views, which see twice the gap that a picture to recognise sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PoseErrorsBody)]
pub struct PoseErrorsReport {
    pub trials: u64,
    pub mean_deg: f64,
    pub median_deg: f64,
    pub p95_deg: f64,
    /// How many were within 5°.
    pub within_5_deg: u64,
}

/// From one view's pose to the next; across 0 the second is the smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GapBody)]
pub struct GapReport {
    pub from_deg: f64,
    pub to_deg: f64,
}

impl ObjectsReport {
    /// Makes every member present, as answers have them.
    pub(super) fn complete(&mut self) {
        self.touches_border.get_or_insert_default();
        self.several_regions.get_or_insert_default();
    }
}

impl From<&TrainingReport> for ObjectsReport {
    fn from(report: &TrainingReport) -> Self {
        let pairs = |pairs: &[(String, String)]| pairs.iter().cloned().map(<[String; 2]>::from).collect();
        let unless_empty = |ids: &[String]| (!ids.is_empty()).then(|| ids.to_vec());
        Self {
            spectrum: report.spectrum.clone(),
            energy_kept: report.energy_kept,
            dimension: report.dimension as u64,
            width_px: report.width_px as u64,
            height_px: report.height_px as u64,
            vector_length: report.vector_length as u64,
            rate_by_dimension: report.rate_by_dimension.iter().map(DimensionRateReport::from).collect(),
            confusion: report.confusion.iter().map(ConfusionReport::from).collect(),
            least_explained: report.least_explained,
            held_out: report.held_out.as_ref().map(HeldOutReport::from),
            objects: report.objects.iter().map(ObjectReport::from).collect(),
            near_duplicates: pairs(&report.near_duplicates),
            repeated_poses: pairs(&report.repeated_poses),
            over_exposed: report.over_exposed.clone(),
            under_exposed: report.under_exposed.clone(),
            blank: report.blank.clone(),
            resized: report.resized.clone(),
            touches_border: unless_empty(&report.touches_border),
            several_regions: unless_empty(&report.several_regions),
            timings_ms: None,
        }
    }
}

impl From<&core::DimensionRate> for DimensionRateReport {
    fn from(rate: &core::DimensionRate) -> Self {
        Self { dimension: rate.dimension as u64, right: rate.right as u64, trials: rate.trials as u64 }
    }
}

impl From<&core::Confusion> for ConfusionReport {
    fn from(confusion: &core::Confusion) -> Self {
        Self { shown: confusion.shown.clone(), named: confusion.named.clone(), times: confusion.times as u64 }
    }
}

impl From<&core::HeldOut> for HeldOutReport {
    fn from(held_out: &core::HeldOut) -> Self {
        Self {
            known: held_out.known as u64,
            known_accepted: held_out.known_accepted as u64,
            known_right: held_out.known_right as u64,
            unknown: held_out.unknown as u64,
            unknown_refused: held_out.unknown_refused as u64,
        }
    }
}

impl From<&core::ObjectReport> for ObjectReport {
    fn from(object: &core::ObjectReport) -> Self {
        let gap = |gap: &core::Gap| GapReport { from_deg: gap.from_deg, to_deg: gap.to_deg };
        Self {
            label: object.label.clone(),
            views: object.views as u64,
            views_with_pose: object.views_with_pose as u64,
            threshold: object.threshold,
            pose: object.pose.as_ref().map(PoseErrorsReport::from),
            gaps: object.gaps.iter().map(gap).collect(),
        }
    }
}

impl From<&core::PoseErrors> for PoseErrorsReport {
    fn from(errors: &core::PoseErrors) -> Self {
        Self {
            trials: errors.trials as u64,
            mean_deg: errors.mean_deg,
            median_deg: errors.median_deg,
            p95_deg: errors.p95_deg,
            within_5_deg: errors.within_5_deg as u64,
        }
    }
}
