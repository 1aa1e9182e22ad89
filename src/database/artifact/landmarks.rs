//! The tensors of a landmark database: `mean` [signature], `basis` [dimension, signature], `eigenvalues`
//! [dimension], `eigenpoints` [points, dimension], `points` [points, 3] (x, y in pixels, salience), `radius` [points]
//! (which of the options' radii) and `owner` [points] (index into the exemplars, which stand in the header). Where
//! matches say where an exemplar lies also `spectra` [points, rings, 24], and `contours` [contour points, 4] (x, y from
//! the picture's centre in pixels, gradient along x and y), exemplar by exemplar.
//!
//! Files of releases without `radius`, `spectra`, `contours` and `confidence` have one radius and none of the others.

use safetensors::tensor::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{ArtifactError, Tensor, le_bytes, optional, tensor};
use crate::database::{Counts, LandmarkReport, Name};
use landmarkd_core::recognition::landmarks::{
    Confidence, ContourPoint, Exemplar, LandmarkOptions, LandmarkParts, Landmarks,
};

/// What stands in the header of a landmark database beside that of all kinds.
#[derive(Serialize, Deserialize)]
pub(super) struct LandmarkHeader {
    total_variance: f64,
    exemplars: Vec<ExemplarDocument>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    confidence: Option<ConfidenceDocument>,
    pub(super) report: LandmarkReport,
}

#[derive(Serialize, Deserialize)]
struct ExemplarDocument {
    id: String,
    label: String,
    width_px: u32,
    height_px: u32,
    points: usize,
    #[serde(default)]
    contour_points: usize,
}

#[derive(Serialize, Deserialize)]
struct ConfidenceDocument {
    weights: [f64; 4],
    bias: f64,
    threshold: f64,
}

/// Header and tensors of a model.
pub(super) fn take_apart(landmarks: &Landmarks, report: &LandmarkReport) -> (LandmarkHeader, Vec<Tensor>) {
    let parts = landmarks.to_parts();
    let header = LandmarkHeader {
        total_variance: parts.total_variance,
        exemplars: parts.exemplars.iter().map(ExemplarDocument::from).collect(),
        confidence: parts.confidence.as_ref().map(ConfidenceDocument::from),
        report: report.clone(),
    };
    let (dimension, points) = (parts.eigenvalues.len(), parts.owner.len());
    let signature = parts.mean.len();
    let mut tensors = vec![
        ("basis", Dtype::F32, vec![dimension, signature], le_bytes(&parts.basis, f32::to_le_bytes)),
        ("eigenpoints", Dtype::F32, vec![points, dimension], le_bytes(&parts.eigenpoints, f32::to_le_bytes)),
        ("eigenvalues", Dtype::F64, vec![dimension], le_bytes(&parts.eigenvalues, f64::to_le_bytes)),
        ("mean", Dtype::F32, vec![signature], le_bytes(&parts.mean, f32::to_le_bytes)),
        ("owner", Dtype::U32, vec![points], le_bytes(&parts.owner, u32::to_le_bytes)),
        ("points", Dtype::F32, vec![points, 3], le_bytes(&parts.points, f32::to_le_bytes)),
        ("radius", Dtype::U8, vec![points], parts.radius),
    ];
    if !parts.spectra.is_empty() {
        let rings = parts.options.rings;
        let shape = vec![points, rings, parts.spectra.len() / (points * rings)];
        tensors.push(("spectra", Dtype::I8, shape, le_bytes(&parts.spectra, i8::to_le_bytes)));
    }
    let contours: Vec<f32> = parts.exemplars.iter().flat_map(|e| &e.contour).flat_map(numbers).collect();
    if !contours.is_empty() {
        let shape = vec![contours.len() / 4, 4];
        tensors.push(("contours", Dtype::F32, shape, le_bytes(&contours, f32::to_le_bytes)));
    }
    (header, tensors)
}

/// The model of header and tensors that may hold anything, with what it counts.
pub(super) fn put_together(
    options: LandmarkOptions,
    header: LandmarkHeader,
    tensors: &SafeTensors,
) -> Result<(Landmarks, Counts), ArtifactError> {
    let owner = tensor(tensors, "owner", Dtype::U32, u32::from_le_bytes)?;
    let contours = optional(tensors, "contours", Dtype::F32, f32::from_le_bytes)?.unwrap_or_default();
    let parts = LandmarkParts {
        options,
        exemplars: exemplars(header.exemplars, &contours)?,
        mean: tensor(tensors, "mean", Dtype::F32, f32::from_le_bytes)?,
        basis: tensor(tensors, "basis", Dtype::F32, f32::from_le_bytes)?,
        eigenvalues: tensor(tensors, "eigenvalues", Dtype::F64, f64::from_le_bytes)?,
        total_variance: header.total_variance,
        eigenpoints: tensor(tensors, "eigenpoints", Dtype::F32, f32::from_le_bytes)?,
        points: tensor(tensors, "points", Dtype::F32, f32::from_le_bytes)?,
        radius: optional(tensors, "radius", Dtype::U8, u8::from_le_bytes)?
            .unwrap_or_else(|| vec![0; owner.len()]),
        spectra: optional(tensors, "spectra", Dtype::I8, i8::from_le_bytes)?.unwrap_or_default(),
        confidence: header.confidence.map(Confidence::from),
        owner,
    };
    let named =
        |exemplar: &Exemplar| Name::parse(&exemplar.label).is_ok() && Uuid::try_parse(&exemplar.id).is_ok();
    if !parts.exemplars.iter().all(named) {
        return Err(ArtifactError::Contents);
    }
    let radii = parts.options.subwindow_radii_px.len().max(1) as u64;
    let (exemplars, windows) = (parts.exemplars.len() as u64, parts.owner.len() as u64);
    let landmarks =
        Landmarks::from_parts(parts).map_err(|source| ArtifactError::Parts { source: source.into() })?;
    let labels = landmarks.labels().len() as u64;
    let counts = Counts { exemplars, labels, interest_points: windows / radii };
    Ok((landmarks, counts))
}

/// The exemplars with their contours; as many contour points must be there as they say.
fn exemplars(documents: Vec<ExemplarDocument>, contours: &[f32]) -> Result<Vec<Exemplar>, ArtifactError> {
    let (mut left, rest) = contours.as_chunks::<4>();
    let mut exemplars = Vec::with_capacity(documents.len());
    for document in documents {
        let (own, others) = left.split_at_checked(document.contour_points).ok_or(ArtifactError::Contents)?;
        left = others;
        let point = |&[x_px, y_px, gradient_x, gradient_y]: &[f32; 4]| ContourPoint {
            x_px,
            y_px,
            gradient_x,
            gradient_y,
        };
        exemplars.push(Exemplar {
            id: document.id,
            label: document.label,
            width_px: document.width_px,
            height_px: document.height_px,
            windows: document.points,
            contour: own.iter().map(point).collect(),
        });
    }
    if left.is_empty() && rest.is_empty() { Ok(exemplars) } else { Err(ArtifactError::Contents) }
}

fn numbers(point: &ContourPoint) -> [f32; 4] {
    [point.x_px, point.y_px, point.gradient_x, point.gradient_y]
}

impl From<&Exemplar> for ExemplarDocument {
    fn from(exemplar: &Exemplar) -> Self {
        Self {
            id: exemplar.id.clone(),
            label: exemplar.label.clone(),
            width_px: exemplar.width_px,
            height_px: exemplar.height_px,
            points: exemplar.windows,
            contour_points: exemplar.contour.len(),
        }
    }
}

impl From<&Confidence> for ConfidenceDocument {
    fn from(confidence: &Confidence) -> Self {
        let Confidence { weights, bias, threshold } = *confidence;
        Self { weights, bias, threshold }
    }
}

impl From<ConfidenceDocument> for Confidence {
    fn from(document: ConfidenceDocument) -> Self {
        let ConfidenceDocument { weights, bias, threshold } = document;
        Self { weights, bias, threshold }
    }
}
