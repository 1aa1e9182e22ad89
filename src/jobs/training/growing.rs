//! A training that goes on from the version that is in use: what is new is projected on its eigenspace, what is gone is taken
//! out, the rest stays as it is.

use std::collections::HashMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Inputs;
use super::describing::described;
use super::landmarks::{Fitted, model_of, stop};
use crate::database::{
    ALGORITHM_REVISION, DatabaseError, ExemplarRow, GrownReport, Kind, LoadedVersion, Name, Options, Report,
    TrainingTimings, grown_digest,
};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use landmarkd_core::recognition::landmarks::{Colour, Exemplar, LandmarkOptions, WindowSpace, residual_of};

/// Versions of fewer exemplars are trained anew unless it is asked otherwise: that takes seconds.
const FROM_EXEMPLARS: usize = 1000;
/// An eigenspace serves up to so many times the exemplars that it was fitted to.
const MOST_GROWTH: f64 = 1.5;
/// It no longer fits exemplars of which it leaves out so many times what it did when it was fitted.
const MOST_RESIDUAL: f64 = 1.5;

/// Which eigenspace exemplars are projected on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = EigenspaceWord)]
pub enum EigenspaceChoice {
    /// That of the version in use, from 1000 exemplars on, as long as it fits: it has grown by half at most since it was
    /// fitted, and leaves out of the new exemplars hardly more than of those. Only what is new is described.
    #[default]
    Auto,
    /// One that is fitted to these exemplars: the same exemplars and options give the same version, whatever was before.
    Fit,
    /// That of the version in use, if there is one of the same options.
    Keep,
}

/// What a training goes on from.
struct Base {
    version: Arc<LoadedVersion>,
    /// Exemplars that its eigenspace was fitted to.
    fitted: u64,
    added: Vec<ExemplarRow>,
}

/// What came of it.
pub(super) enum Growth {
    /// It can't go on from the version in use.
    None,
    /// The version of this number has just these exemplars.
    Same(i64),
    /// The model, what the report says of where it came from, and the digest of its inputs.
    Grown(Box<Fitted>, GrownReport, String),
}

/// Goes on from the version in use, if the choice and the exemplars let it.
pub(super) async fn grown(
    worker: &Worker<'_>,
    inputs: &Inputs,
    options: &LandmarkOptions,
) -> Result<Growth, Stop> {
    let Some(base) = base(worker, inputs, options).await? else { return Ok(Growth::None) };
    let (Some(model), Base { version, fitted, added }) = (model_of(&base.version), &base) else {
        return Ok(Growth::None);
    };
    let removed = model.exemplars().len() + added.len() - inputs.exemplars.len();
    if added.is_empty() && removed == 0 {
        return Ok(Growth::Same(version.version));
    }
    let Some(space) = WindowSpace::of(model).map(Arc::new) else { return Ok(Growth::None) };
    let (with, residual_fitted) = (Arc::clone(&space), space.residual());
    let encode = move |described| with.encode(described);
    let options = Arc::new(options.clone());
    let (encoded, descriptions, describe) =
        described(worker, "describing", added.clone(), &options, encode).await?;
    // one without colour, where the others have it: an eigenspace of luminance alone serves all
    let Ok(encoded) = encoded.into_iter().collect::<Result<Vec<_>, _>>() else { return Ok(Growth::None) };
    let residual = residual_of(&encoded);
    if inputs.params.eigenspace == EigenspaceChoice::Auto && residual > MOST_RESIDUAL * residual_fitted {
        return Ok(Growth::None);
    }
    let kept = names(&inputs.exemplars);
    let (with, count) = (Arc::clone(version), added.len());
    let grow = move || {
        let keeps = |exemplar: &Exemplar| kept.get(&exemplar.id) == Some(&exemplar.label);
        Ok(model_of(&with).map(|model| model.grown(encoded, keeps)))
    };
    let (grown, eigenspace) = worker.alone("eigenspace", grow).await?;
    let Some(grown) = grown else { return Ok(Growth::None) };
    let (model, report) = grown.map_err(stop)?;
    let report_of_growth = GrownReport {
        from_version: version.version,
        fitted_exemplars: *fitted,
        added: count as u64,
        removed: removed as u64,
        segments: model.segments() as u64,
        residual,
        residual_fitted,
    };
    let digest = grown_digest(&inputs.digest, &version.digest);
    let timings = TrainingTimings { describe, eigenspace, rehearsal: None };
    Ok(Growth::Grown(Box::new((model, report, timings, descriptions)), report_of_growth, digest))
}

/// The version in use, if the training can go on from it.
async fn base(worker: &Worker<'_>, inputs: &Inputs, options: &LandmarkOptions) -> Result<Option<Base>, Stop> {
    let choice = inputs.params.eigenspace;
    let Ok(name) = Name::parse(&inputs.database) else { return Ok(None) };
    if choice == EigenspaceChoice::Fit {
        return Ok(None);
    }
    let version = match worker.databases.alias_model(&name, None).await {
        Ok(version) => version,
        // there is none, or it is damaged: training anew mends that
        Err(
            DatabaseError::NotTrained { .. }
            | DatabaseError::NoCurrent { .. }
            | DatabaseError::Unloadable { .. }
            | DatabaseError::UnknownVersion { .. },
        ) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let Some(model) = model_of(&version) else { return Ok(None) };
    let row = worker.databases.version(&name, version.version).await?;
    let asked = LandmarkOptions { colour: model.options().colour, ..options.clone() };
    let is_alike = row.algorithm_revision == ALGORITHM_REVISION
        && (options.colour == asked.colour || options.colour == Colour::Auto)
        && Options::Landmarks(asked) == Options::Landmarks(model.options().clone());
    if !is_alike {
        return Ok(None);
    }
    let before: HashMap<&str, &str> =
        model.exemplars().iter().map(|e| (e.id.as_str(), e.label.as_str())).collect();
    let is_new = |row: &&ExemplarRow| before.get(&row.id.to_string()[..]) != Some(&&*row.label);
    let added: Vec<ExemplarRow> = inputs.exemplars.iter().filter(is_new).cloned().collect();
    let fitted = fitted_exemplars(&row.report, &row.kind).unwrap_or(model.exemplars().len() as u64);
    let has_grown_little =
        inputs.exemplars.len() as f64 <= MOST_GROWTH * fitted as f64 && added.len() < inputs.exemplars.len();
    let goes_on = match choice {
        EigenspaceChoice::Auto => model.exemplars().len() >= FROM_EXEMPLARS && has_grown_little,
        EigenspaceChoice::Keep => added.len() < inputs.exemplars.len(),
        EigenspaceChoice::Fit => false,
    };
    Ok(goes_on.then_some(Base { version, fitted, added }))
}

/// How many exemplars the eigenspace of a version was fitted to, if it has grown since.
fn fitted_exemplars(report: &str, kind: &str) -> Option<u64> {
    match Report::from_document(Kind::parse(kind)?, report) {
        Ok(Report::Landmarks(report)) => report.grown.flatten().map(|grown| grown.fitted_exemplars),
        _ => None,
    }
}

/// Ids and labels.
fn names(rows: &[ExemplarRow]) -> HashMap<String, String> {
    rows.iter().map(|row| (row.id.to_string(), row.label.clone())).collect()
}
