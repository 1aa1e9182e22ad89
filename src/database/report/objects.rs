//! What the training of an object database tells of itself. The members mean what they mean in
//! [`TrainingReport`]; fields that later releases add are optional here.

use serde::{Deserialize, Serialize};

use super::ReportTimings;
use landmarkd_core::recognition::objects as method;
use landmarkd_core::recognition::objects::TrainingReport;

/// See [`TrainingReport`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectsReport {
    pub spectrum: Vec<f64>,
    pub energy_kept: f64,
    pub dimension: u64,
    pub width_px: u64,
    pub height_px: u64,
    pub vector_length: u64,
    pub rate_by_dimension: Vec<DimensionRateReport>,
    pub confusion: Vec<ConfusionReport>,
    pub held_out: Option<HeldOutReport>,
    pub objects: Vec<OneObjectReport>,
    pub near_duplicates: Vec<(String, String)>,
    pub repeated_poses: Vec<(String, String)>,
    pub over_exposed: Vec<String>,
    pub under_exposed: Vec<String>,
    pub blank: Vec<String>,
    pub resized: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub touches_border: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub several_regions: Vec<String>,
    /// Not in an artifact: the same inputs give the same file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings_ms: Option<ReportTimings>,
}

/// See [`method::DimensionRate`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DimensionRateReport {
    pub dimension: u64,
    pub right: u64,
    pub trials: u64,
}

/// See [`method::Confusion`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConfusionReport {
    pub shown: String,
    pub named: Option<String>,
    pub times: u64,
}

/// See [`method::HeldOut`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOutReport {
    pub known: u64,
    pub known_accepted: u64,
    pub known_right: u64,
    pub unknown: u64,
    pub unknown_refused: u64,
}

/// See [`method::ObjectReport`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OneObjectReport {
    pub label: String,
    pub views: u64,
    pub views_with_pose: u64,
    pub threshold: Option<f64>,
    pub pose: Option<PoseErrorsReport>,
    pub gaps: Vec<GapReport>,
}

/// See [`method::PoseErrors`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseErrorsReport {
    pub trials: u64,
    pub mean_deg: f64,
    pub median_deg: f64,
    pub p95_deg: f64,
    pub within_5_deg: u64,
}

/// See [`method::Gap`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GapReport {
    pub from_deg: f64,
    pub to_deg: f64,
}

impl From<&TrainingReport> for ObjectsReport {
    fn from(report: &TrainingReport) -> Self {
        Self {
            spectrum: report.spectrum.clone(),
            energy_kept: report.energy_kept,
            dimension: report.dimension as u64,
            width_px: report.width_px as u64,
            height_px: report.height_px as u64,
            vector_length: report.vector_length as u64,
            rate_by_dimension: report.rate_by_dimension.iter().map(DimensionRateReport::from).collect(),
            confusion: report.confusion.iter().map(ConfusionReport::from).collect(),
            held_out: report.held_out.as_ref().map(HeldOutReport::from),
            objects: report.objects.iter().map(OneObjectReport::from).collect(),
            near_duplicates: report.near_duplicates.clone(),
            repeated_poses: report.repeated_poses.clone(),
            over_exposed: report.over_exposed.clone(),
            under_exposed: report.under_exposed.clone(),
            blank: report.blank.clone(),
            resized: report.resized.clone(),
            touches_border: report.touches_border.clone(),
            several_regions: report.several_regions.clone(),
            timings_ms: None,
        }
    }
}

impl From<&method::DimensionRate> for DimensionRateReport {
    fn from(rate: &method::DimensionRate) -> Self {
        Self { dimension: rate.dimension as u64, right: rate.right as u64, trials: rate.trials as u64 }
    }
}

impl From<&method::Confusion> for ConfusionReport {
    fn from(confusion: &method::Confusion) -> Self {
        let method::Confusion { shown, named, times } = confusion;
        Self { shown: shown.clone(), named: named.clone(), times: *times as u64 }
    }
}

impl From<&method::HeldOut> for HeldOutReport {
    fn from(held_out: &method::HeldOut) -> Self {
        Self {
            known: held_out.known as u64,
            known_accepted: held_out.known_accepted as u64,
            known_right: held_out.known_right as u64,
            unknown: held_out.unknown as u64,
            unknown_refused: held_out.unknown_refused as u64,
        }
    }
}

impl From<&method::ObjectReport> for OneObjectReport {
    fn from(object: &method::ObjectReport) -> Self {
        let gap = |gap: &method::Gap| GapReport { from_deg: gap.from_deg, to_deg: gap.to_deg };
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

impl From<&method::PoseErrors> for PoseErrorsReport {
    fn from(errors: &method::PoseErrors) -> Self {
        Self {
            trials: errors.trials as u64,
            mean_deg: errors.mean_deg,
            median_deg: errors.median_deg,
            p95_deg: errors.p95_deg,
            within_5_deg: errors.within_5_deg as u64,
        }
    }
}
