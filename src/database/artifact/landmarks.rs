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
    Confidence, EdgePoint, Exemplar, LandmarkOptions, LandmarkParts, Landmarks,
};

/// The members of the header that only a landmark database has.
#[derive(Serialize, Deserialize)]
pub(super) struct LandmarkHeader {
    total_variance: f64,
    exemplars: Vec<ExemplarDocument>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    confidence: Option<ConfidenceDocument>,
    pub(super) report: LandmarkReport,
}

/// An exemplar; its points and edge points are rows of the tensors.
#[derive(Serialize, Deserialize)]
struct ExemplarDocument {
    id: String,
    /// Null: a negative exemplar.
    label: Option<String>,
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
pub(super) fn header_and_tensors(
    landmarks: &Landmarks,
    report: &LandmarkReport,
) -> (LandmarkHeader, Vec<Tensor>) {
    let parts = LandmarkParts::from(landmarks);
    let header = LandmarkHeader {
        total_variance: parts.total_variance,
        exemplars: parts.exemplars.iter().map(ExemplarDocument::from).collect(),
        confidence: parts.confidence.as_ref().map(ConfidenceDocument::from),
        report: report.clone(),
    };
    let (dimension, points) = (parts.eigenvalues.len(), parts.owner.len());
    let signature = parts.mean.len();
    let mut tensors = vec![
        Tensor::of_f32("basis", vec![dimension, signature], &parts.basis),
        Tensor::of_f32("eigenpoints", vec![points, dimension], &parts.eigenpoints),
        Tensor::of_f64("eigenvalues", &parts.eigenvalues),
        Tensor::of_f32("mean", vec![signature], &parts.mean),
        Tensor {
            name: "owner",
            dtype: Dtype::U32,
            shape: vec![points],
            bytes: le_bytes(&parts.owner, u32::to_le_bytes),
        },
        Tensor::of_f32("points", vec![points, 3], &parts.points),
        Tensor { name: "radius", dtype: Dtype::U8, shape: vec![points], bytes: parts.radius },
    ];
    if !parts.spectra.is_empty() {
        let rings = parts.options.rings;
        let shape = vec![points, rings, parts.spectra.len() / (points * rings)];
        let bytes = le_bytes(&parts.spectra, i8::to_le_bytes);
        tensors.push(Tensor { name: "spectra", dtype: Dtype::I8, shape, bytes });
    }
    let edges: Vec<f32> = parts.exemplars.iter().flat_map(|e| &e.edges).flat_map(edge_row).collect();
    if !edges.is_empty() {
        tensors.push(Tensor::of_f32("contours", vec![edges.len() / 4, 4], &edges));
    }
    (header, tensors)
}

/// The model of header and tensors that may hold anything, with what it counts.
pub(super) fn assemble(
    options: LandmarkOptions,
    header: LandmarkHeader,
    tensors: &SafeTensors,
) -> Result<(Landmarks, Counts), ArtifactError> {
    let owner = tensor(tensors, "owner", Dtype::U32, u32::from_le_bytes)?;
    let edges = optional(tensors, "contours", Dtype::F32, f32::from_le_bytes)?.unwrap_or_default();
    let parts = LandmarkParts {
        options,
        exemplars: exemplars(header.exemplars, &edges)?,
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
    let named = |exemplar: &Exemplar| {
        (exemplar.is_negative() || Name::parse(&exemplar.label).is_ok())
            && Uuid::try_parse(&exemplar.id).is_ok()
    };
    if !parts.exemplars.iter().all(named) {
        return Err(ArtifactError::Contents);
    }
    let radii = parts.options.subwindow_radii_px.len().max(1) as u64;
    let (exemplars, windows) = (parts.exemplars.len() as u64, parts.owner.len() as u64);
    let landmarks =
        Landmarks::try_from(parts).map_err(|source| ArtifactError::Parts { source: source.into() })?;
    let labels = landmarks.labels().len() as u64;
    let counts = Counts { exemplars, labels, interest_points: windows / radii };
    Ok((landmarks, counts))
}

/// The exemplars with their edge templates, whose rows are those of the tensor `contours`, no more and no fewer.
fn exemplars(documents: Vec<ExemplarDocument>, edges: &[f32]) -> Result<Vec<Exemplar>, ArtifactError> {
    let (mut left, rest) = edges.as_chunks::<4>();
    let mut exemplars = Vec::with_capacity(documents.len());
    for document in documents {
        let (own, others) = left.split_at_checked(document.contour_points).ok_or(ArtifactError::Contents)?;
        left = others;
        let point = |&[x_px, y_px, gradient_x, gradient_y]: &[f32; 4]| EdgePoint {
            x_px,
            y_px,
            gradient_x,
            gradient_y,
        };
        if document.label.as_deref() == Some("") {
            return Err(ArtifactError::Contents);
        }
        exemplars.push(Exemplar {
            id: document.id,
            label: document.label.unwrap_or_default(),
            width_px: document.width_px,
            height_px: document.height_px,
            windows: document.points,
            edges: own.iter().map(point).collect(),
        });
    }
    if left.is_empty() && rest.is_empty() { Ok(exemplars) } else { Err(ArtifactError::Contents) }
}

/// A row of the tensor `contours`.
fn edge_row(point: &EdgePoint) -> [f32; 4] {
    [point.x_px, point.y_px, point.gradient_x, point.gradient_y]
}

impl From<&Exemplar> for ExemplarDocument {
    fn from(exemplar: &Exemplar) -> Self {
        Self {
            id: exemplar.id.clone(),
            label: (!exemplar.is_negative()).then(|| exemplar.label.clone()),
            width_px: exemplar.width_px,
            height_px: exemplar.height_px,
            points: exemplar.windows,
            contour_points: exemplar.edges.len(),
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
