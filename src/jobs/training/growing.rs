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
    ALGORITHM_REVISION, CURRENT, Counts, DatabaseError, ExemplarRow, GrownReport, Kind, LandmarkReport,
    LoadedVersion, Name, Report, TrainingTimings, VersionRow, grown_digest,
};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use landmarkd_core::recognition::landmarks::{Colour, Exemplar, LandmarkOptions, WindowSpace, residual_of};

/// Versions of fewer exemplars are trained anew unless it is asked otherwise: that takes seconds.
const FROM_EXEMPLARS: u64 = 1000;
/// Up to so many times the exemplars that it was fitted to are added to an eigenspace; where it is to be kept, so many.
const MOST_ADDED: u64 = 1;
const MOST_ADDED_KEPT: u64 = 16;
/// It no longer fits exemplars of which it leaves out so many times what it did when it was fitted.
const MOST_RESIDUAL: f64 = 1.5;

/// Which eigenspace exemplars are projected on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = EigenspaceWord)]
pub enum EigenspaceChoice {
    /// That of the version in use, from 1000 exemplars on, as long as it fits: no exemplar has gone since it was fitted, at most
    /// as many have come, and it leaves out of the new ones hardly more than of those. Only what is new is described.
    #[default]
    Auto,
    /// One that is fitted to these exemplars: the same exemplars and options give the same version, whatever was before.
    Fit,
    /// That of the version in use, if that was trained here with the same options and has not grown sixteenfold. What is gone
    /// is in no window of the new version; what the eigenspace owes to it stays until another is fitted.
    Keep,
}

/// What a training goes on from.
pub(super) struct Base {
    version: Arc<LoadedVersion>,
    added: Vec<ExemplarRow>,
    /// What the report says, without the new exemplars' residual.
    report: GrownReport,
    /// Of what comes of it.
    pub(super) digest: String,
}

impl Base {
    /// The number of the version that has just these exemplars, if it has.
    pub(super) fn is_same(&self, inputs: &Inputs) -> bool {
        self.added.is_empty()
            && exemplars_of(&self.version) == inputs.exemplars.len()
            && self.version.surveys == inputs.surveys
    }

    pub(super) fn version(&self) -> i64 {
        self.version.version
    }

    /// The model with what is new and without what is gone; `None` if the eigenspace doesn't fit.
    pub(super) async fn grown(
        self,
        worker: &Worker<'_>,
        inputs: &Inputs,
        options: &LandmarkOptions,
    ) -> Result<Option<(Fitted, GrownReport)>, Stop> {
        let Some(space) = model_of(&self.version).and_then(WindowSpace::of).map(Arc::new) else {
            return Ok(None);
        };
        let (with, residual_fitted) = (Arc::clone(&space), space.residual());
        let encode = move |described| with.encode(described);
        let options = Arc::new(options.clone());
        let (encoded, descriptions, describe) =
            described(worker, "describing", self.added, &options, encode).await?;
        // one without colour, where the others have it: an eigenspace of luminance alone serves all
        let Ok(encoded) = encoded.into_iter().collect::<Result<Vec<_>, _>>() else { return Ok(None) };
        let residual = residual_of(&encoded);
        if inputs.params.eigenspace == EigenspaceChoice::Auto && residual > MOST_RESIDUAL * residual_fitted {
            return Ok(None);
        }
        let names: HashMap<String, String> =
            inputs.exemplars.iter().map(|row| (row.id.to_string(), row.label.clone())).collect();
        let with = self.version;
        let grow = move || {
            let keeps = |exemplar: &Exemplar| names.get(&exemplar.id) == Some(&exemplar.label);
            Ok(model_of(&with).map(|model| model.grown(encoded, keeps)))
        };
        let (grown, eigenspace) = worker.alone("eigenspace", grow).await?;
        let Some(grown) = grown else { return Ok(None) };
        let (model, report) = grown.map_err(stop)?;
        let growth = GrownReport { residual, residual_fitted, ..self.report };
        let timings = TrainingTimings { describe, eigenspace, rehearsal: None };
        Ok(Some(((model, report, timings, descriptions), growth)))
    }
}

/// The version in use, if the training can go on from it.
pub(super) async fn base(
    worker: &Worker<'_>,
    inputs: &Inputs,
    options: &LandmarkOptions,
) -> Result<Option<Base>, Stop> {
    let (choice, databases) = (inputs.params.eigenspace, worker.databases);
    let Ok(name) = Name::parse(&inputs.database) else { return Ok(None) };
    if choice == EigenspaceChoice::Fit {
        return Ok(None);
    }
    let aliases = databases.aliases(&name).await?;
    let Some(alias) = aliases.into_iter().find(|alias| alias.alias == CURRENT) else { return Ok(None) };
    let Some(row) = databases.catalogue.version(name.as_str(), alias.version).await? else { return Ok(None) };
    let (report, counts) = (landmark_report(&row), serde_json::from_str::<Counts>(&row.counts));
    let (Some(report), Ok(counts)) = (report, counts) else { return Ok(None) };
    let grown = report.grown.flatten();
    let is_usable = row.algorithm_revision == ALGORITHM_REVISION
        // an import may say of itself what it will
        && report.timings_ms.flatten().is_some()
        && (choice == EigenspaceChoice::Keep || counts.exemplars >= FROM_EXEMPLARS);
    if !is_usable {
        return Ok(None);
    }
    // what a damaged one had is trained anew, and that mends it
    let version = match databases.whole_version(&row).await {
        Err(DatabaseError::Unloadable { .. } | DatabaseError::UnknownVersion { .. }) => return Ok(None),
        version => version?,
    };
    let Some(model) = model_of(&version).filter(|_| version.digest == row.digest) else { return Ok(None) };
    let colour = model.options().colour;
    let resolved = LandmarkOptions { colour, ..options.clone() };
    if &resolved != model.options() || (options.colour != Colour::Auto && options.colour != colour) {
        return Ok(None);
    }
    let before: HashMap<&str, &str> =
        model.exemplars().iter().map(|e| (e.id.as_str(), e.label.as_str())).collect();
    let is_new = |row: &&ExemplarRow| before.get(&row.id.to_string()[..]) != Some(&&*row.label);
    let added: Vec<ExemplarRow> = inputs.exemplars.iter().filter(is_new).cloned().collect();
    let kept = inputs.exemplars.len() - added.len();
    let of_before = |count: fn(&GrownReport) -> u64| grown.as_ref().map_or(0, count);
    let report = GrownReport {
        from_version: row.version,
        fitted_exemplars: grown.map_or(counts.exemplars, |grown| grown.fitted_exemplars),
        added: of_before(|grown| grown.added) + added.len() as u64,
        removed: of_before(|grown| grown.removed) + (model.exemplars().len() - kept) as u64,
        residual: 0.0,
        residual_fitted: 0.0,
    };
    let goes_on = kept > 0
        && match choice {
            EigenspaceChoice::Keep => report.added <= MOST_ADDED_KEPT * report.fitted_exemplars,
            _ => report.removed == 0 && report.added <= MOST_ADDED * report.fitted_exemplars,
        };
    let digest = grown_digest(&inputs.digest, &version.digest);
    Ok(goes_on.then_some(Base { version, added, report, digest }))
}

fn exemplars_of(version: &LoadedVersion) -> usize {
    model_of(version).map_or(0, |model| model.exemplars().len())
}

/// The report of a version of landmarks.
fn landmark_report(row: &VersionRow) -> Option<LandmarkReport> {
    match Report::from_document(Kind::parse(&row.kind)?, &row.report) {
        Ok(Report::Landmarks(report)) => Some(*report),
        _ => None,
    }
}
