//! Training (A§4.1): the signatures of all exemplars, their eigenspace, and the eigenpoints in it.

use thiserror::Error;

use super::description::{DescribedExemplar, Describer};
use super::model::{Exemplar, Landmarks, Owned};
use super::options::{Colour, LandmarkOptions, OptionFault};
use crate::eigen::{EigenError, EigenpointIndex, Eigenspace};

/// What a training tells of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingReport {
    /// Variance along every direction, descending.
    pub spectrum: Vec<f64>,
    /// The part of all variance that the kept directions hold, 0..=1.
    pub energy_kept: f64,
    /// Directions kept: fewer than asked for if there are no more.
    pub dimension: usize,
    /// Components of a signature.
    pub signature_length: usize,
    /// What signatures know of colour.
    pub colour: Colour,
    /// Exemplars, with or without points.
    pub exemplars: usize,
    /// Different labels.
    pub labels: usize,
    /// Interest points of all exemplars.
    pub interest_points: usize,
    /// Ids of exemplars in which nothing drew attention: they can never be voted for.
    pub exemplars_without_points: Vec<String>,
}

/// Why no model came of a training.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    #[error("there are no exemplars")]
    NoExemplars,
    #[error("no exemplar has interest points: the pictures are flat, dark or out of focus")]
    NoInterestPoints,
    #[error("the exemplar id {id:?} occurs more than once")]
    DuplicateId { id: String },
    #[error("the exemplar {id:?} was described under other options")]
    OtherOptions { id: String },
    #[error("the options can't be used")]
    Options { faults: Vec<OptionFault> },
    #[error("no eigenspace can be fitted to the signatures")]
    Eigenspace { source: EigenError },
}

impl Landmarks {
    /// Train on described exemplars. Their order doesn't matter: they are sorted by label, then id.
    pub fn train(
        mut exemplars: Vec<DescribedExemplar>,
        options: &LandmarkOptions,
    ) -> Result<(Landmarks, TrainingReport), TrainingError> {
        let faults = options.faults();
        if !faults.is_empty() {
            return Err(TrainingError::Options { faults });
        }
        if exemplars.is_empty() {
            return Err(TrainingError::NoExemplars);
        }
        exemplars.sort_by(|a, b| (&a.name.label, &a.name.id).cmp(&(&b.name.label, &b.name.id)));
        let mut ids: Vec<&str> = exemplars.iter().map(|e| e.name.id.as_str()).collect();
        ids.sort_unstable();
        if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(TrainingError::DuplicateId { id: pair[0].to_owned() });
        }
        let length = options.signature_length();
        if let Some(other) = exemplars.iter().find(|e| e.signatures.len() != e.points.len() * length) {
            return Err(TrainingError::OtherOptions { id: other.name.id.clone() });
        }

        let signatures: Vec<f32> = exemplars.iter().flat_map(|e| &e.signatures).copied().collect();
        if signatures.is_empty() {
            return Err(TrainingError::NoInterestPoints);
        }
        let (eigenspace, spectrum) = Eigenspace::fit(&signatures, length, options.dimension) // A§4.1
            .map_err(|source| TrainingError::Eigenspace { source })?;
        let index = EigenpointIndex::new(eigenspace.project(&signatures), eigenspace.dimension());

        let owned = exemplars.iter().enumerate().flat_map(|(owner, exemplar)| {
            exemplar.points.iter().map(move |&point| Owned { point, exemplar: owner as u32 })
        });
        let owned: Vec<Owned> = owned.collect();
        let exemplars_without_points =
            exemplars.iter().filter(|e| e.points.is_empty()).map(|e| e.name.id.clone()).collect();
        let exemplars: Vec<Exemplar> = exemplars
            .into_iter()
            .map(|e| Exemplar {
                id: e.name.id,
                label: e.name.label,
                width_px: e.width_px as u32,
                height_px: e.height_px as u32,
                points: e.points.len(),
            })
            .collect();
        let model = Landmarks {
            options: LandmarkOptions { colour: options.colour_used(), ..options.clone() },
            describer: Describer::new(options),
            exemplars,
            eigenspace,
            index,
            owned,
        };
        let report = TrainingReport {
            energy_kept: model.eigenspace.eigenvalues.iter().sum::<f64>() / model.eigenspace.total_variance,
            spectrum,
            dimension: model.eigenspace.dimension(),
            signature_length: length,
            colour: model.options.colour,
            exemplars: model.exemplars.len(),
            labels: model.labels().len(),
            interest_points: model.owned.len(),
            exemplars_without_points,
        };
        Ok((model, report))
    }
}
