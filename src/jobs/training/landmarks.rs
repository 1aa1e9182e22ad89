//! Training a landmark database: interest points and signatures of each exemplar, then the eigenspace of them all;
//! then the model is asked about its exemplars seen otherwise, which tells how sure its answers are.

use std::sync::Arc;

use super::{Trained, Worker, rounds_of};
use crate::database::{Counts, ExemplarRow, LandmarkReport, Model, ReliabilityReport, Report, ReportTimings};
use crate::jobs::runner::Stop;
use landmarkd_core::recognition::landmarks::{
    ExemplarName, LandmarkOptions, Landmarks, Rehearsed, describe, rehearsals,
};

/// What a version says when no rehearsal allowed to say how sure it is.
const NOT_CALIBRATED: &str = "not_calibrated";

/// Train the exemplars, with the time that it took.
pub(super) async fn train(
    worker: &Worker<'_>,
    exemplars: Vec<ExemplarRow>,
    options: LandmarkOptions,
) -> Result<(Trained, ReportTimings), Stop> {
    let options = Arc::new(options);
    let with = Arc::clone(&options);
    let described = worker
        .each("describing", exemplars.clone(), move |_, row, frame| Ok(describe(name(row), frame, &with)));
    let (described, describe_ms) = described.await?;
    let fit = move || {
        Landmarks::train(described, &options)
            .map_err(|error| Stop::Failed { code: "too_few_points", detail: crate::telemetry::chain(&error) })
    };
    let ((model, report), eigenspace_ms) = worker.alone("eigenspace", fit).await?;
    let counts = Counts {
        exemplars: report.exemplars as u64,
        labels: report.labels as u64,
        interest_points: report.interest_points as u64,
    };
    let mut report = LandmarkReport::from(&report);

    let asked = Arc::new(model);
    let (chosen, rounds) = asked.rehearsed_exemplars();
    let ids: Vec<&str> = chosen.into_iter().map(|index| asked.exemplars()[index].id.as_str()).collect();
    let (rows, count) = rounds_of(&ids, rounds, &exemplars);
    let with = Arc::clone(&asked);
    let rehearse = move |place: usize, row: &ExemplarRow, frame: &_| {
        let name = name(row);
        let round = (place / count) as u64;
        Ok(with.rehearse(&name, &rehearsals(&name, frame, round, with.options())))
    };
    let (said, rehearsal_ms) = worker.each("rehearsing", rows, rehearse).await?;
    let said: Vec<Rehearsed> = said.into_iter().flatten().collect();
    let mut model = Arc::into_inner(asked).ok_or_else(|| Stop::Failed {
        code: "internal",
        detail: "the model is still asked after its rehearsals".into(),
    })?;
    let calibrate = move || {
        let reliability = model.calibrate(&said);
        Ok((model, reliability))
    };
    let ((model, reliability), calibrate_ms) = worker.alone("calibrating", calibrate).await?;
    match (reliability, model.confidence()) {
        (Some(reliability), Some(confidence)) => {
            report.reliability = Some(ReliabilityReport::of(&reliability, confidence.threshold));
        }
        _ => report.warnings.push(NOT_CALIBRATED.into()),
    }
    let timings = ReportTimings {
        describe: describe_ms,
        eigenspace: eigenspace_ms,
        rehearsal: Some(rehearsal_ms + calibrate_ms),
    };
    let (model, report) = (Model::Landmarks(Box::new(model)), Report::Landmarks(Box::new(report)));
    Ok((Trained { model, report, counts }, timings))
}

/// An exemplar's name, as recognition has it.
pub(super) fn name(row: &ExemplarRow) -> ExemplarName {
    ExemplarName { id: row.id.to_string(), label: row.label.clone() }
}
