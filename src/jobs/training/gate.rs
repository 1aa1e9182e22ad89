//! The gate before `current`: the candidate and the version in use are shown the same rehearsals of the candidate's
//! exemplars, and the candidate is promoted unless it is worse beyond chance.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Worker, landmarks, rounds_of};
use crate::database::{DatabaseError, ExemplarRow, JobRow, LoadedVersion, Model, Name};
use crate::jobs::runner::Stop;
use landmarkd_core::imaging::Frame;
use landmarkd_core::recognition::Comparison;
use landmarkd_core::recognition::landmarks::rehearsals;
use landmarkd_core::recognition::objects::{ViewName, rehearsal};

/// A comparison of landmarks takes so many times the rounds of a calibration: small differences want many trials.
const ROUNDS_FACTOR: u64 = 2;

/// How a trained version did beside the one in use, as it is kept with the job.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VersionComparison {
    /// The version in use; none if there was none that loads: then there was nothing to be compared with.
    pub against_version: Option<i64>,
    pub trials: u64,
    pub candidate_right: u64,
    pub current_right: u64,
    pub candidate_only: u64,
    pub current_only: u64,
    pub p_value: f64,
    /// Whether `current` moved to the version.
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
            let (chosen, rounds) = model.rehearsed_exemplars();
            let ids = chosen.into_iter().map(|index| model.exemplars()[index].id.as_str());
            (ids.collect(), rounds, ROUNDS_FACTOR * rounds)
        }
        Model::Objects(model) => {
            let (chosen, rounds) = model.rehearsed_views();
            let ids = chosen.into_iter().map(|index| model.views()[index].id.as_str());
            (ids.collect(), rounds, rounds)
        }
    };
    let (rows, count) = rounds_of(&ids, shown, exemplars);
    // not the rounds that a calibration was made of
    let judge = move |place: usize, row: &ExemplarRow, frame: &Frame| {
        Ok(judged(&candidate.model, &current.model, row, frame, rounds + (place / count) as u64))
    };
    let (judged, _) = worker.each("comparing", rows, judge).await?;
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
        Ok(current) => Ok(Some(current).filter(|current| current.model.kind() == candidate.model.kind())),
        Err(DatabaseError::NotTrained { .. } | DatabaseError::NoCurrent { .. }) => Ok(None),
        Err(error @ DatabaseError::Unloadable { .. }) => {
            let error = crate::telemetry::chain(&error);
            tracing::warn!(database, error, "nothing to compare with: the version in use doesn't load");
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// What candidate and current say rightly to a rehearsal of an exemplar.
fn judged(
    candidate: &Model,
    current: &Model,
    row: &ExemplarRow,
    frame: &Frame,
    round: u64,
) -> (Vec<bool>, Vec<bool>) {
    match (candidate, current) {
        (Model::Landmarks(candidate), Model::Landmarks(current)) => {
            let name = landmarks::name(row);
            let seen = rehearsals(&name, frame, round, candidate.options());
            (candidate.judge(&name, &seen), current.judge(&name, &seen))
        }
        (Model::Objects(candidate), Model::Objects(current)) => {
            let name = ViewName { id: row.id.to_string(), label: row.label.clone(), pose_deg: row.pose_deg };
            let seen = rehearsal(&name, frame, round);
            (vec![candidate.judge(&name, &seen)], vec![current.judge(&name, &seen)])
        }
        _ => (Vec::new(), Vec::new()),
    }
}
