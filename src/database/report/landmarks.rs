//! What the training of a landmark database tells of itself.

use serde::{Deserialize, Serialize};

use super::ReportTimings;
use crate::recognition::landmarks::{Colour, TrainingReport};

/// What a training told of itself. Fields that later releases add are optional here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LandmarkReport {
    /// Variance along each direction, descending, all of them.
    pub spectrum: Vec<f64>,
    /// Part of the variance that the kept dimensions hold.
    pub energy_kept: f64,
    /// Dimensions kept.
    pub dimension: u64,
    /// Components of a signature.
    pub signature_length: u64,
    /// The planes that signatures were taken from: `gray` or `opponent`.
    pub colour: String,
    /// Exemplars in which nothing drew attention.
    pub exemplars_without_points: Vec<String>,
    /// Not in an artifact: the same inputs give the same file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings_ms: Option<ReportTimings>,
}

impl From<&TrainingReport> for LandmarkReport {
    fn from(report: &TrainingReport) -> Self {
        Self {
            spectrum: report.spectrum.clone(),
            energy_kept: report.energy_kept,
            dimension: report.dimension as u64,
            signature_length: report.signature_length as u64,
            colour: match report.colour {
                Colour::Auto => "auto",
                Colour::Gray => "gray",
                Colour::Opponent => "opponent",
            }
            .into(),
            exemplars_without_points: report.exemplars_without_points.clone(),
            timings_ms: None,
        }
    }
}
