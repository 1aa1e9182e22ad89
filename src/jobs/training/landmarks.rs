//! Training a landmark database: interest points and signatures of each exemplar, then the eigenspace of them all;
//! then synthetic views of the exemplars calibrate the confidence.

use std::sync::Arc;

use super::{Trained, rounds_of};
use crate::database::{
    Counts, ExemplarRow, LandmarkReport, Model, ReliabilityReport, Report, TrainingTimings,
};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use crate::problem::Code;
use crate::telemetry::chain;
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, CalibrationSample, ExemplarName, LandmarkOptions, Landmarks, Reliability,
    calibration_samples, describe, synthetic_views,
};

/// The warning of a version without confidence: its samples allow no calibration.
const NOT_CALIBRATED: &str = "not_calibrated";

/// Trains the exemplars; returns the times of the stages too.
pub(super) async fn train(
    worker: &Worker<'_>,
    exemplars: Vec<ExemplarRow>,
    options: LandmarkOptions,
) -> Result<(Trained, TrainingTimings), Stop> {
    let options = Arc::new(options);
    let with = Arc::clone(&options);
    let described = worker
        .each("describing", exemplars.clone(), move |_, row, frame| Ok(describe(name(row), frame, &with)));
    let (described, describe_ms) = described.await?;
    let fit = move || {
        Landmarks::train(described, &options).map_err(|error| Stop::failed(Code::TooFewPoints, chain(&error)))
    };
    let ((model, report), eigenspace_ms) = worker.alone("eigenspace", fit).await?;
    let counts = Counts {
        exemplars: report.exemplars as u64,
        labels: report.labels as u64,
        interest_points: report.interest_points as u64,
    };
    let mut report = LandmarkReport::from(&report);
    let (model, reliability, rehearsal_ms) = calibrate(worker, &exemplars, model).await?;
    match (reliability, model.confidence()) {
        (Some(reliability), Some(confidence)) => {
            report.reliability = Some(Some(ReliabilityReport::of(&reliability, confidence.threshold)));
        }
        _ => report.warnings = Some(vec![NOT_CALIBRATED.into()]),
    }
    let timings = TrainingTimings {
        describe: describe_ms,
        eigenspace: eigenspace_ms,
        rehearsal: Some(Some(rehearsal_ms)),
    };
    let (model, report) = (Model::Landmarks(Box::new(model)), Report::Landmarks(Box::new(report)));
    Ok((Trained { model, report, counts }, timings))
}

/// The model with its confidence calibrated on synthetic views of the exemplars, how reliable it is, and the milliseconds
/// that this took.
async fn calibrate(
    worker: &Worker<'_>,
    exemplars: &[ExemplarRow],
    model: Landmarks,
) -> Result<(Landmarks, Option<Reliability>, f64), Stop> {
    let asked = Arc::new(model);
    let plan = CalibrationPlan::of(&asked);
    let ids: Vec<&str> = plan.exemplars.iter().map(|&index| asked.exemplars()[index].id.as_str()).collect();
    let (rows, count) = rounds_of(&ids, plan.rounds, exemplars);
    let with = Arc::clone(&asked);
    let samples = move |place: usize, row: &ExemplarRow, frame: &_| {
        let name = name(row);
        let round = (place / count) as u64;
        Ok(calibration_samples(&with, &name, &synthetic_views(&name, frame, round, with.options())))
    };
    let (samples, rehearsal_ms) = worker.each("rehearsing", rows, samples).await?;
    let samples: Vec<CalibrationSample> = samples.into_iter().flatten().collect();
    let mut model = Arc::into_inner(asked)
        .ok_or_else(|| Stop::failed(Code::Internal, "the model is still in use after its calibration"))?;
    let calibrate = move || {
        let reliability = model.calibrate(&samples);
        Ok((model, reliability))
    };
    let ((model, reliability), calibrate_ms) = worker.alone("calibrating", calibrate).await?;
    Ok((model, reliability, rehearsal_ms + calibrate_ms))
}

/// An exemplar's name, as recognition has it.
pub(super) fn name(row: &ExemplarRow) -> ExemplarName {
    ExemplarName { id: row.id.to_string(), label: row.label.clone() }
}
