//! The tensors of a landmark database: `mean` [signature], `basis` [dimension, signature], `eigenvalues`
//! [dimension], `eigenpoints` [points, dimension], `points` [points, 3] (x, y in pixels, salience) and `owner`
//! [points] (index into the exemplars, which stand in the header).

use safetensors::tensor::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{ArtifactError, Tensor, le_bytes, tensor};
use crate::database::{Counts, LandmarkReport, Name};
use crate::recognition::landmarks::{Exemplar, LandmarkOptions, LandmarkParts, Landmarks};

/// What stands in the header of a landmark database beside that of all kinds.
#[derive(Serialize, Deserialize)]
pub(super) struct LandmarkHeader {
    total_variance: f64,
    exemplars: Vec<ExemplarDocument>,
    pub(super) report: LandmarkReport,
}

#[derive(Serialize, Deserialize)]
struct ExemplarDocument {
    id: String,
    label: String,
    width_px: u32,
    height_px: u32,
    points: usize,
}

/// Header and tensors of a model.
pub(super) fn take_apart(landmarks: &Landmarks, report: &LandmarkReport) -> (LandmarkHeader, Vec<Tensor>) {
    let parts = landmarks.to_parts();
    let header = LandmarkHeader {
        total_variance: parts.total_variance,
        exemplars: parts.exemplars.iter().map(ExemplarDocument::from).collect(),
        report: report.clone(),
    };
    let (dimension, points) = (parts.eigenvalues.len(), parts.owner.len());
    let signature = parts.mean.len();
    let tensors = vec![
        ("basis", Dtype::F32, vec![dimension, signature], le_bytes(&parts.basis, f32::to_le_bytes)),
        ("eigenpoints", Dtype::F32, vec![points, dimension], le_bytes(&parts.eigenpoints, f32::to_le_bytes)),
        ("eigenvalues", Dtype::F64, vec![dimension], le_bytes(&parts.eigenvalues, f64::to_le_bytes)),
        ("mean", Dtype::F32, vec![signature], le_bytes(&parts.mean, f32::to_le_bytes)),
        ("owner", Dtype::U32, vec![points], le_bytes(&parts.owner, u32::to_le_bytes)),
        ("points", Dtype::F32, vec![points, 3], le_bytes(&parts.points, f32::to_le_bytes)),
    ];
    (header, tensors)
}

/// The model of header and tensors that may hold anything, with what it counts.
pub(super) fn put_together(
    options: LandmarkOptions,
    header: LandmarkHeader,
    tensors: &SafeTensors,
) -> Result<(Landmarks, Counts), ArtifactError> {
    let parts = LandmarkParts {
        options,
        exemplars: header.exemplars.into_iter().map(Exemplar::from).collect(),
        mean: tensor(tensors, "mean", Dtype::F32, f32::from_le_bytes)?,
        basis: tensor(tensors, "basis", Dtype::F32, f32::from_le_bytes)?,
        eigenvalues: tensor(tensors, "eigenvalues", Dtype::F64, f64::from_le_bytes)?,
        total_variance: header.total_variance,
        eigenpoints: tensor(tensors, "eigenpoints", Dtype::F32, f32::from_le_bytes)?,
        points: tensor(tensors, "points", Dtype::F32, f32::from_le_bytes)?,
        owner: tensor(tensors, "owner", Dtype::U32, u32::from_le_bytes)?,
    };
    let named =
        |exemplar: &Exemplar| Name::parse(&exemplar.label).is_ok() && Uuid::try_parse(&exemplar.id).is_ok();
    if !parts.exemplars.iter().all(named) {
        return Err(ArtifactError::Contents);
    }
    let (exemplars, points) = (parts.exemplars.len() as u64, parts.owner.len() as u64);
    let landmarks =
        Landmarks::from_parts(parts).map_err(|source| ArtifactError::Parts { source: source.into() })?;
    let counts = Counts { exemplars, labels: landmarks.labels().len() as u64, interest_points: points };
    Ok((landmarks, counts))
}

impl From<&Exemplar> for ExemplarDocument {
    fn from(exemplar: &Exemplar) -> Self {
        Self {
            id: exemplar.id.clone(),
            label: exemplar.label.clone(),
            width_px: exemplar.width_px,
            height_px: exemplar.height_px,
            points: exemplar.points,
        }
    }
}

impl From<ExemplarDocument> for Exemplar {
    fn from(document: ExemplarDocument) -> Self {
        Self {
            id: document.id,
            label: document.label,
            width_px: document.width_px,
            height_px: document.height_px,
            points: document.points,
        }
    }
}
