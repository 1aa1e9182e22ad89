//! What the training of a landmark database told of itself.

use serde::Serialize;
use utoipa::ToSchema;

use super::TrainingTimings;
use crate::database::LandmarkReport;

/// What the training of a landmark database told of itself.
#[derive(Debug, Serialize, ToSchema)]
pub struct LandmarkReportBody {
    /// Variance along each direction of the signatures' space, descending, all of them.
    pub spectrum: Vec<f64>,
    /// Part of the variance that the kept dimensions hold.
    pub energy_kept: f64,
    /// Dimensions kept.
    pub dimension: u64,
    /// Components of a signature.
    pub signature_length: u64,
    /// The planes that signatures were taken from.
    #[schema(example = "opponent")]
    pub colour: String,
    /// Exemplars in which nothing drew attention: they can't be recognised.
    pub exemplars_without_points: Vec<String>,
    /// Where it was trained here: how long that took.
    pub timings_ms: Option<TrainingTimings>,
}

impl From<LandmarkReport> for LandmarkReportBody {
    fn from(report: LandmarkReport) -> Self {
        Self {
            spectrum: report.spectrum,
            energy_kept: report.energy_kept,
            dimension: report.dimension,
            signature_length: report.signature_length,
            colour: report.colour,
            exemplars_without_points: report.exemplars_without_points,
            timings_ms: report.timings_ms.map(TrainingTimings::from),
        }
    }
}
