//! Training a landmark database: interest points and signatures of each exemplar, then the eigenspace of them all;
//! then each picture is asked with itself left out or, with intensities, synthetic views calibrate the confidence.

use std::sync::Arc;

use super::describing::described;
use super::{SelfCheck, Trained, rounds_of};
use crate::database::{
    Counts, DescriptionsReport, ExemplarRow, GrownReport, LandmarkReport, LoadedVersion, Model,
    ReliabilityReport, Report, TrainingTimings, VerdictReport,
};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use crate::problem::Code;
use crate::telemetry::chain;
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, CalibrationSample, Colour, DescribedExemplar, ExemplarName, LandmarkOptions, Landmarks,
    LeftOut, Reliability, Signature, TrainingError, TrainingReport, WindowSample, WindowSpace,
    calibration_samples, exemplars_to_leave_out, left_out, sample_plan, synthetic_views,
};

/// The warning of a version without confidence: its samples allow no calibration.
const NOT_CALIBRATED: &str = "not_calibrated";

/// Trains the exemplars; returns the times of the stages too, and where the descriptions came from.
pub(super) async fn train(
    worker: &Worker<'_>,
    exemplars: Vec<ExemplarRow>,
    options: LandmarkOptions,
    calibration: SelfCheck,
    grown: Option<(Fitted, GrownReport)>,
) -> Result<(Trained, TrainingTimings, DescriptionsReport), Stop> {
    let (grown, growth) = grown.unzip();
    let (model, report, timings, descriptions) = match (grown, options.signature) {
        (Some(grown), _) => grown,
        (None, Signature::Intensity) => plain(worker, &exemplars, options).await?,
        (None, Signature::Gradient) => taught(worker, &exemplars, options).await?,
    };
    let counts = Counts {
        exemplars: report.exemplars as u64,
        labels: report.labels as u64,
        interest_points: report.interest_points as u64,
    };
    let mut report = LandmarkReport { grown: growth.map(Some), ..LandmarkReport::from(&report) };
    let mut rehearsal = None;
    let model = match (calibration, model.options().signature) {
        (SelfCheck::None | SelfCheck::Background, _) => model,
        (SelfCheck::Wait, Signature::Gradient) => {
            let asked = Arc::new(model);
            let checked =
                verdict(worker, "calibrating", &exemplars, &asked, |model: &Landmarks| Some(model)).await?;
            (report.verdict, rehearsal) = checked.map(|(verdict, took_ms)| (Some(verdict), took_ms)).unzip();
            Arc::into_inner(asked)
                .ok_or_else(|| Stop::failed(Code::Internal, "the model is still in use after it was asked"))?
        }
        (SelfCheck::Wait, Signature::Intensity) => {
            let (model, reliability, took_ms) = calibrate(worker, &exemplars, model).await?;
            if let (Some(reliability), Some(confidence)) = (reliability, model.confidence()) {
                report.reliability = Some(Some(ReliabilityReport::of(&reliability, confidence.threshold)));
            }
            rehearsal = Some(took_ms);
            model
        }
    };
    if model.confidence().is_none() {
        report.warnings = Some(vec![NOT_CALIBRATED.into()]);
    }
    let timings = TrainingTimings { rehearsal: Some(rehearsal), ..timings };
    let (model, report) = (Model::Landmarks(Box::new(model)), Report::Landmarks(Box::new(report)));
    Ok((Trained { model, report, counts }, timings, descriptions))
}

/// A model with its report, the times of the stages and where the descriptions came from.
pub(super) type Fitted = (Landmarks, TrainingReport, TrainingTimings, DescriptionsReport);

/// All exemplars described, then the eigenspace of all their signatures.
async fn plain(
    worker: &Worker<'_>,
    exemplars: &[ExemplarRow],
    options: LandmarkOptions,
) -> Result<Fitted, Stop> {
    let options = Arc::new(options);
    let (described, descriptions, describe) =
        described(worker, "describing", exemplars.to_vec(), &options, |described| described).await?;
    let fit = move || Landmarks::train(described, &options).map_err(stop);
    let ((model, report), eigenspace) = worker.alone("eigenspace", fit).await?;
    Ok((model, report, TrainingTimings { describe, eigenspace, rehearsal: None }, descriptions))
}

/// The eigenspace of a sample of the exemplars, then of all of them one by one what is kept: what is held of a description is a
/// tenth of it.
async fn taught(
    worker: &Worker<'_>,
    exemplars: &[ExemplarRow],
    options: LandmarkOptions,
) -> Result<Fitted, Stop> {
    let (mut fitted, options) = (options.clone(), Arc::new(options));
    let mut exemplars = exemplars.to_vec();
    exemplars.sort_by_cached_key(|row| (row.label.clone(), row.id.to_string()));
    let (chosen, most) = sample_plan(exemplars.len());
    let sampled: Vec<ExemplarRow> = chosen.into_iter().map(|index| exemplars[index].clone()).collect();
    let mut timings = TrainingTimings { describe: 0.0, eigenspace: 0.0, rehearsal: None };
    let mut computed = 0;
    loop {
        let sample = move |described: DescribedExemplar| WindowSample::of(&described, most);
        let (samples, of_sample, sample_ms) =
            described(worker, "sampling", sampled.clone(), &options, sample).await?;
        let (count, with) = (exemplars.len(), fitted.clone());
        let fit = move || WindowSpace::fit(samples, count, &with).map(Arc::new).map_err(stop);
        let (space, fit_ms) = worker.alone("eigenspace", fit).await?;
        let with = Arc::clone(&space);
        let encode = move |described| with.encode(described);
        let (encoded, of_all, describe_ms) =
            described(worker, "describing", exemplars.clone(), &options, encode).await?;
        timings.describe += sample_ms + describe_ms;
        computed += of_sample.computed + of_all.computed;
        timings.eigenspace += fit_ms;
        let encoded = match encoded.into_iter().collect::<Result<Vec<_>, _>>() {
            // one that was not sampled: luminance alone for all
            Err(TrainingError::WithoutColour(_)) if fitted.colour == Colour::Auto => {
                fitted.colour = Colour::Gray;
                continue;
            }
            encoded => encoded.map_err(stop)?,
        };
        let space = Arc::into_inner(space).ok_or_else(|| {
            Stop::failed(Code::Internal, "the eigenspace is still in use after its exemplars")
        })?;
        let teach = move || Landmarks::of_encoded(space, encoded).map_err(stop);
        let ((model, report), teach_ms) = worker.alone("eigenspace", teach).await?;
        timings.eigenspace += teach_ms;
        // where none are kept, some were computed twice
        let computed = computed.min(count as u64);
        let descriptions = DescriptionsReport { computed, kept: count as u64 - computed };
        return Ok((model, report, timings, descriptions));
    }
}

pub(super) fn stop(error: TrainingError) -> Stop {
    let code = match error {
        TrainingError::NoLabels => Code::NoExemplars,
        TrainingError::NegativeExemplars => Code::InvalidField,
        _ => Code::TooFewPoints,
    };
    Stop::failed(code, chain(&error))
}

/// The model of a version, if it is one of landmarks.
pub(super) fn model_of(version: &LoadedVersion) -> Option<&Landmarks> {
    match &version.model {
        Model::Landmarks(model) => Some(model),
        Model::Objects(_) => None,
    }
}

/// What a model says of each picture of its exemplars with that left out, and the milliseconds that this took; `None` if
/// `held` has no model of landmarks.
pub(super) async fn verdict<M: Send + Sync + 'static>(
    worker: &Worker<'_>,
    stage: &str,
    exemplars: &[ExemplarRow],
    held: &Arc<M>,
    model_of: fn(&M) -> Option<&Landmarks>,
) -> Result<Option<(VerdictReport, f64)>, Stop> {
    let Some(model) = model_of(held) else { return Ok(None) };
    let chosen = exemplars_to_leave_out(model);
    let ids: Vec<&str> = chosen.iter().map(|&index| model.exemplars()[index].id.as_str()).collect();
    let (rows, _) = rounds_of(&ids, 1, exemplars);
    let (with, longer_side_px) = (Arc::clone(held), model.options().working_size_px);
    let ask = move |_: usize, row: &ExemplarRow, frame: &_| {
        Ok(model_of(&with).and_then(|model| left_out(model, &row.id.to_string(), frame)))
    };
    let (left_out, took_ms) = worker.each(stage, rows, longer_side_px, ask).await?;
    let left_out: Vec<LeftOut> = left_out.into_iter().flatten().collect();
    Ok(Some((VerdictReport::of(&left_out), took_ms)))
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
    let (samples, rehearsal_ms) = worker.each("rehearsing", rows, None, samples).await?;
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
