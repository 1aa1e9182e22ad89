//! The report of a training, as it is kept with the version and in its artifact. One file a kind.

mod landmarks;
mod objects;

use serde::{Deserialize, Serialize};

pub use landmarks::{LandmarkReport, ReliabilityBinReport, ReliabilityReport};
pub use objects::{
    ConfusionReport, DimensionRateReport, GapReport, HeldOutReport, ObjectsReport, OneObjectReport,
    PoseErrorsReport,
};

use super::Kind;

/// What a training told of itself.
#[derive(Debug, Clone, PartialEq)]
pub enum Report {
    Landmarks(Box<LandmarkReport>),
    Objects(Box<ObjectsReport>),
}

/// How long the parts of a training took, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ReportTimings {
    /// Reading the exemplars, and describing each by itself.
    pub describe: f64,
    /// Eigenspace, index and artifact.
    pub eigenspace: f64,
    /// Rehearsing the exemplars; none where that isn't done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rehearsal: Option<f64>,
}

impl Report {
    /// The report as one line of JSON.
    pub fn to_document(&self) -> String {
        let text = match self {
            Self::Landmarks(report) => serde_json::to_string(report),
            Self::Objects(report) => serde_json::to_string(report),
        };
        text.expect("numbers and text always serialise")
    }

    /// Read a kept report of this kind back.
    ///
    /// # Errors
    /// The text is no such report.
    pub fn from_document(kind: Kind, text: &str) -> Result<Self, serde_json::Error> {
        match kind {
            Kind::Landmarks => serde_json::from_str(text).map(Self::Landmarks),
            Kind::Objects => serde_json::from_str(text).map(Self::Objects),
        }
    }

    /// The same with these timings.
    pub fn timed(mut self, timings: ReportTimings) -> Self {
        match &mut self {
            Self::Landmarks(report) => report.timings_ms = Some(timings),
            Self::Objects(report) => report.timings_ms = Some(timings),
        }
        self
    }
}
