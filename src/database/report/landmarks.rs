//! What the training of a landmark database tells of itself.

use serde::{Deserialize, Serialize};

use super::ReportTimings;
use landmarkd_core::recognition::landmarks::{Colour, Reliability, ReliabilityBin, TrainingReport};

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
    /// What rehearsals told of answers; none where they allowed no calibration, or none were done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reliability: Option<ReliabilityReport>,
    /// `not_calibrated`: no rehearsal was answered rightly.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Not in an artifact: the same inputs give the same file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings_ms: Option<ReportTimings>,
}

/// See [`Reliability`]; the threshold is that of the version.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReliabilityReport {
    pub known: u64,
    pub unknown: u64,
    pub known_named: f64,
    pub known_misnamed: f64,
    pub unknown_refused: f64,
    pub curve: Vec<ReliabilityBinReport>,
    pub threshold: f64,
}

/// See [`ReliabilityBin`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReliabilityBinReport {
    pub confidence: f64,
    pub answers: u64,
    pub right: f64,
}

impl ReliabilityReport {
    /// What rehearsals told of answers at this threshold.
    pub fn of(reliability: &Reliability, threshold: f64) -> Self {
        let bin = |bin: &ReliabilityBin| ReliabilityBinReport {
            confidence: bin.confidence,
            answers: bin.answers as u64,
            right: bin.right,
        };
        Self {
            known: reliability.known as u64,
            unknown: reliability.unknown as u64,
            known_named: reliability.known_named,
            known_misnamed: reliability.known_misnamed,
            unknown_refused: reliability.unknown_refused,
            curve: reliability.curve.iter().map(bin).collect(),
            threshold,
        }
    }
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
            reliability: None,
            warnings: Vec::new(),
            timings_ms: None,
        }
    }
}
