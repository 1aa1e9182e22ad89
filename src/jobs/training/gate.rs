//! The gate before `current`: the candidate and the version in use recognise the same synthetic views of the candidate's
//! exemplars, and the candidate is promoted unless it is worse beyond chance.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{landmarks, rounds_of};
use crate::database::{DatabaseError, ExemplarRow, JobRow, LoadedVersion, Model, Name};
use crate::jobs::stop::Stop;
use crate::jobs::worker::Worker;
use crate::telemetry::chain;
use landmarkd_core::imaging::Frame;
use landmarkd_core::recognition::Comparison;
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, Signature, correct_decisions, names_rightly, synthetic_views,
};
use landmarkd_core::recognition::objects::{ViewName, ViewSample, recognises_view, synthetic_view};

/// A comparison of landmarks by intensity takes so many times the rounds of a calibration: small differences want many trials.
const ROUNDS_FACTOR: u64 = 2;

/// A trained version and the one that `current` pointed to, shown the same: exemplars of the new one, seen otherwise.
/// Of landmarks with gradient signatures what both know is shown; others are also shown with their label left out of
/// either version, when the right answer is null.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonBody)]
pub struct VersionComparison {
    /// The version in use; null if `current` pointed to none that loads: then nothing was shown, and it is promoted.
    pub against_version: Option<i64>,
    /// How often both were asked.
    pub trials: u64,
    /// Right answers of the trained version.
    pub candidate_right: u64,
    /// Right answers of the version in use.
    pub current_right: u64,
    /// Asked when the trained version alone was right.
    pub candidate_only: u64,
    /// Asked when the version in use alone was right.
    pub current_only: u64,
    /// The chance that, of those on which they differ, as many or more go to the version in use if both are equally
    /// good (sign test). Below 0.05 the trained version counts as worse.
    pub p_value: f64,
    /// Whether `current` moved to the trained version.
    pub promoted: bool,
}

impl VersionComparison {
    /// What is kept with a job, if anything is.
    pub fn of_job(job: &JobRow) -> Option<Self> {
        serde_json::from_str(job.comparison.as_deref()?).ok()
    }

    pub(super) fn to_document(self) -> String {
        serde_json::to_string(&self).expect("numbers always serialise")
    }

    fn of(against_version: Option<i64>, comparison: &Comparison) -> Self {
        Self {
            against_version,
            trials: comparison.trials as u64,
            candidate_right: comparison.candidate_right as u64,
            current_right: comparison.current_right as u64,
            candidate_only: comparison.candidate_only as u64,
            current_only: comparison.current_only as u64,
            p_value: comparison.p_value,
            promoted: !comparison.candidate_is_worse(),
        }
    }
}

/// Compare a candidate with the version that `current` points to.
pub(super) async fn compare(
    worker: &Worker<'_>,
    database: &str,
    candidate: Arc<LoadedVersion>,
    exemplars: &[ExemplarRow],
) -> Result<VersionComparison, Stop> {
    let Some(current) = in_use(worker, database, &candidate).await? else {
        return Ok(VersionComparison::of(None, &Comparison::of(&[], &[])));
    };
    let against_version = current.version;
    let (ids, rounds, shown): (Vec<&str>, u64, u64) = match &candidate.model {
        Model::Landmarks(model) => {
            let CalibrationPlan { exemplars, rounds } = CalibrationPlan::of(model);
            let ids = exemplars.into_iter().map(|index| model.exemplars()[index].id.as_str());
            let factor = if model.options().signature == Signature::Gradient { 1 } else { ROUNDS_FACTOR };
            (ids.collect(), rounds, factor * rounds)
        }
        Model::Objects(model) => {
            let ViewSample { views, rounds } = ViewSample::of(model);
            let ids = views.into_iter().map(|index| model.views()[index].id.as_str());
            (ids.collect(), rounds, rounds)
        }
    };
    let (rows, count) = rounds_of(&ids, shown, exemplars);
    let longer_side_px = match &candidate.model {
        Model::Landmarks(model) => model.options().working_size_px,
        Model::Objects(_) => None,
    };
    // not the rounds that a calibration was made of
    let judge = move |place: usize, row: &ExemplarRow, frame: &Frame| {
        Ok(judged(&candidate.model, &current.model, row, frame, rounds + (place / count) as u64))
    };
    let (judged, _) = worker.each("comparing", rows, longer_side_px, judge).await?;
    let (by_candidate, by_current): (Vec<Vec<bool>>, Vec<Vec<bool>>) = judged.into_iter().unzip();
    let comparison = Comparison::of(&by_candidate.concat(), &by_current.concat());
    let compared = VersionComparison::of(Some(against_version), &comparison);
    tracing::info!(database, against_version, ?comparison, promoted = compared.promoted, "compared");
    Ok(compared)
}

/// The version in use, if it can be compared with the candidate.
async fn in_use(
    worker: &Worker<'_>,
    database: &str,
    candidate: &LoadedVersion,
) -> Result<Option<Arc<LoadedVersion>>, Stop> {
    let Ok(name) = Name::parse(database) else { return Ok(None) };
    match worker.databases.alias_model(&name, None).await {
        Ok(current) if current.model.kind() != candidate.model.kind() => Ok(None),
        Ok(current) => whole(worker, current).await,
        Err(DatabaseError::NotTrained { .. } | DatabaseError::NoCurrent { .. }) => Ok(None),
        Err(error @ DatabaseError::Unloadable { .. }) => {
            let error = chain(&error);
            tracing::warn!(database, error, "nothing to compare with: the version in use doesn't load");
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// The version with all of its windows, to be asked here.
async fn whole(worker: &Worker<'_>, current: Arc<LoadedVersion>) -> Result<Option<Arc<LoadedVersion>>, Stop> {
    if current.kept.is_none() {
        return Ok(Some(current));
    }
    let row = worker.databases.catalogue.version(&current.database, current.version).await?;
    match row {
        Some(row) => Ok(Some(worker.databases.whole_version(&row).await?)),
        // deleted meanwhile
        None => Ok(None),
    }
}

/// Which synthetic views of an exemplar the candidate and the version in use answer correctly.
fn judged(
    candidate: &Model,
    current: &Model,
    row: &ExemplarRow,
    frame: &Frame,
    round: u64,
) -> (Vec<bool>, Vec<bool>) {
    match (candidate, current) {
        (Model::Landmarks(candidate), Model::Landmarks(current))
            if candidate.options().signature == Signature::Gradient =>
        {
            let name = landmarks::name(row);
            // what both know is compared; a label that is new to one is judged on its own
            if !current.labels().contains(&name.label.as_str()) {
                return (Vec::new(), Vec::new());
            }
            let working = candidate.options().working_frame(frame);
            let views = synthetic_views(&name, &working, round, candidate.options());
            (names_rightly(candidate, &name, &views), names_rightly(current, &name, &views))
        }
        (Model::Landmarks(candidate), Model::Landmarks(current)) => {
            let name = landmarks::name(row);
            let views = synthetic_views(&name, frame, round, candidate.options());
            (correct_decisions(candidate, &name, &views), correct_decisions(current, &name, &views))
        }
        (Model::Objects(candidate), Model::Objects(current)) => {
            let name = ViewName { id: row.id.to_string(), label: row.label.clone(), pose_deg: row.pose_deg };
            let view = synthetic_view(&name, frame, round);
            (vec![recognises_view(candidate, &name, &view)], vec![recognises_view(current, &name, &view)])
        }
        _ => (Vec::new(), Vec::new()),
    }
}
