//! The report of a training on the wire. One file a kind.

mod landmarks;
mod objects;

use serde::Serialize;
use utoipa::ToSchema;

pub use landmarks::LandmarkReportBody;
pub use objects::ObjectsReportBody;

use crate::database::{Report, ReportTimings};

/// What a training told of itself, by the kind of its database.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
pub enum ReportBody {
    Landmarks(Box<LandmarkReportBody>),
    Objects(Box<ObjectsReportBody>),
}

impl From<Report> for ReportBody {
    fn from(report: Report) -> Self {
        match report {
            Report::Landmarks(report) => Self::Landmarks(Box::new((*report).into())),
            Report::Objects(report) => Self::Objects(Box::new((*report).into())),
        }
    }
}

/// How long the parts of a training took.
#[derive(Debug, Serialize, ToSchema)]
pub struct TrainingTimings {
    /// Reading and describing the exemplars.
    pub describe: f64,
    /// Eigenspace, index and artifact.
    pub eigenspace: f64,
    /// Asking the new version about its exemplars seen otherwise; null where that isn't done.
    pub rehearsal: Option<f64>,
}

impl From<ReportTimings> for TrainingTimings {
    fn from(timings: ReportTimings) -> Self {
        Self { describe: timings.describe, eigenspace: timings.eigenspace, rehearsal: timings.rehearsal }
    }
}
