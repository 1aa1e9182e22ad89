//! Training a landmark database: interest points and signatures of each exemplar, then the eigenspace of them all.

use std::sync::Arc;

use super::{Trained, Worker};
use crate::database::{Counts, ExemplarRow, LandmarkReport, Model, Report, ReportTimings};
use crate::jobs::runner::Stop;
use crate::recognition::landmarks::{ExemplarName, LandmarkOptions, Landmarks, describe};

/// Train the exemplars, with the time that it took.
pub(super) async fn train(
    worker: Worker<'_>,
    exemplars: Vec<ExemplarRow>,
    options: LandmarkOptions,
) -> Result<(Trained, ReportTimings), Stop> {
    let options = Arc::new(options);
    let with = Arc::clone(&options);
    let described = worker.described(exemplars, move |row, frame| {
        let name = ExemplarName { id: row.id.to_string(), label: row.label.clone() };
        Ok(describe(name, frame, &with))
    });
    let (described, describe_ms) = described.await?;
    let fit = move || {
        let (model, report) = Landmarks::train(described, &options).map_err(|error| Stop::Failed {
            code: "too_few_points",
            detail: crate::telemetry::chain(&error),
        })?;
        let counts = Counts {
            exemplars: report.exemplars as u64,
            labels: report.labels as u64,
            interest_points: report.interest_points as u64,
        };
        let report = Report::Landmarks(LandmarkReport::from(&report));
        Ok(Trained { model: Model::Landmarks(model), report, counts })
    };
    let (trained, eigenspace_ms) = worker.fitted(fit).await?;
    Ok((trained, ReportTimings { describe: describe_ms, eigenspace: eigenspace_ms }))
}
