//! The report of the training of a landmark database.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{TrainingTimings, VerdictReport};
use landmarkd_core::recognition::landmarks::{Colour, Reliability, ReliabilityBin, TrainingReport};

/// What the training of a landmark database told of itself.
// Members that later releases add are optional.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = LandmarkReportBody)]
pub struct LandmarkReport {
    /// Variance along each direction of the signatures' space, descending, all of them; of a version that has grown, those
    /// that are kept.
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
    #[schema(value_type = Option<ReliabilityReport>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reliability: Option<Option<ReliabilityReport>>,
    /// What the training has to say: `not_calibrated` if no exemplar was recognised when it was seen otherwise, so that
    /// answers have no confidence; `not_checked` if the version was published before it was asked about its own pictures, and
    /// that isn't done: it is being done, or its job ended before.
    #[schema(value_type = Vec<String>, required = true)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warnings: Option<Vec<String>>,
    /// Where it was trained here: how long that took.
    #[schema(value_type = Option<TrainingTimings>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timings_ms: Option<Option<TrainingTimings>>,
    /// How well the version knows its own pictures; null for versions of earlier releases, with signatures of intensity, and
    /// where the training didn't ask.
    #[schema(value_type = Option<VerdictReport>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<Option<VerdictReport>>,
    /// Where it was trained here: where the descriptions of its exemplars came from.
    #[schema(value_type = Option<DescriptionsReport>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub descriptions: Option<Option<DescriptionsReport>>,
    /// What it has grown from; null where the eigenspace was fitted to its exemplars.
    #[schema(value_type = Option<GrownReport>)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grown: Option<Option<GrownReport>>,
}

/// What a version has grown from, with the eigenspace that this one had.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = GrownBody)]
pub struct GrownReport {
    /// The number of the version before, where it was trained.
    pub from_version: i64,
    /// Exemplars that the eigenspace was fitted to.
    pub fitted_exemplars: u64,
    /// Exemplars that have come since, or have another label.
    pub added: u64,
    /// Exemplars that have gone since: what the eigenspace and the centroids of the lists owe to them is still there.
    pub removed: u64,
    /// Part of the energy of the new exemplars' signatures that the eigenspace doesn't hold, 0..=1.
    pub residual: f64,
    /// Part of the variance that it didn't hold when it was fitted.
    pub residual_fitted: f64,
}

/// Where the descriptions of a training's exemplars came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = DescriptionsBody)]
pub struct DescriptionsReport {
    /// Pictures that were described.
    pub computed: u64,
    /// Pictures whose description an earlier training had left on this machine.
    pub kept: u64,
}

/// What the version answered when its exemplars were shown turned, moved, on other ground and partly hidden: as they
/// are, and again with all of their label left out, when nothing should be recognised.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ReliabilityBody)]
pub struct ReliabilityReport {
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
    pub curve: Vec<ReliabilityBinReport>,
    /// Below this confidence the decision is null.
    pub threshold: f64,
}

/// Answers of about the same confidence.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ReliabilityBinBody)]
pub struct ReliabilityBinReport {
    /// Their mean confidence.
    pub confidence: f64,
    // How many there are.
    pub answers: u64,
    /// Part of them that was right.
    pub right: f64,
}

impl LandmarkReport {
    /// Makes every member present, as answers have them.
    pub(super) fn complete(&mut self) {
        self.reliability.get_or_insert_default();
        self.verdict.get_or_insert_default();
        self.descriptions.get_or_insert_default();
        self.grown.get_or_insert_default();
        self.warnings.get_or_insert_default();
    }
}

impl ReliabilityReport {
    /// The reliability of answers, with the confidence below which the version decides nothing.
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

/// Without what is known after calibration only.
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
            warnings: None,
            timings_ms: None,
            verdict: None,
            descriptions: None,
            grown: None,
        }
    }
}
