//! What the training of a landmark database told of itself.

use serde::Serialize;
use utoipa::ToSchema;

use super::TrainingTimings;
use crate::database::{LandmarkReport, ReliabilityBinReport, ReliabilityReport};

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
    /// How far answers can be believed; null, with a word in `warnings`, if the exemplars don't tell, and for versions of
    /// earlier releases.
    pub reliability: Option<ReliabilityBody>,
    /// What the training has to say: `not_calibrated` if no exemplar was recognised when it was seen otherwise, so that
    /// answers have no confidence.
    pub warnings: Vec<String>,
    /// Where it was trained here: how long that took.
    pub timings_ms: Option<TrainingTimings>,
}

/// What the version answered when its exemplars were shown turned, moved, on other ground and partly hidden: as they
/// are, and again with all of their label left out, when nothing should be recognised.
#[derive(Debug, Serialize, ToSchema)]
pub struct ReliabilityBody {
    /// Frames that showed something known.
    pub known: u64,
    /// Frames that showed nothing known.
    pub unknown: u64,
    /// Part of the known ones that were decided rightly.
    pub known_named: f64,
    /// Part of the known ones that were decided wrongly.
    pub known_misnamed: f64,
    /// Part of the unknown ones whose decision was null.
    pub unknown_refused: f64,
    /// Of the answers of about one confidence, how many were right. Each answer's confidence is of a curve fitted
    /// without it.
    pub curve: Vec<ReliabilityBinBody>,
    /// Below this confidence the decision is null.
    pub threshold: f64,
}

/// Answers of about the same confidence.
#[derive(Debug, Serialize, ToSchema)]
pub struct ReliabilityBinBody {
    /// Their mean confidence.
    pub confidence: f64,
    pub answers: u64,
    /// Part of them that was right.
    pub right: f64,
}

impl From<ReliabilityReport> for ReliabilityBody {
    fn from(report: ReliabilityReport) -> Self {
        let bin = |bin: ReliabilityBinReport| ReliabilityBinBody {
            confidence: bin.confidence,
            answers: bin.answers,
            right: bin.right,
        };
        Self {
            known: report.known,
            unknown: report.unknown,
            known_named: report.known_named,
            known_misnamed: report.known_misnamed,
            unknown_refused: report.unknown_refused,
            curve: report.curve.into_iter().map(bin).collect(),
            threshold: report.threshold,
        }
    }
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
            reliability: report.reliability.map(ReliabilityBody::from),
            warnings: report.warnings,
            timings_ms: report.timings_ms.map(TrainingTimings::from),
        }
    }
}
