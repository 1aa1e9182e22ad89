//! The tensors of a landmark database: `mean` [signature], `basis` [dimension, signature], `eigenvalues` [dimension]; where
//! matches say where an exemplar lies also `contours` [contour points, 4] (x, y from the picture's centre in pixels, gradient
//! along x and y), exemplar by exemplar. Exemplars stand in the header.
//!
//! Signatures of gradients have windows in lists (`recognition/landmarks/multiscale`): `centroids` [lists, dimension],
//! `steps` [dimension], `phase_basis` [56, 2, 36], and of each segment, from 0 on, `segment.0.starts` [lists + 1] (in blocks),
//! `segment.0.codes` [blocks, pairs of coordinates, 16, 2], `segment.0.squares` and `segment.0.indices` [blocks, 16],
//! `segment.0.fine` [blocks, 16, pairs], `segment.0.positions` [points, 2], `segment.0.levels` [points], `segment.0.phases`
//! [points, 64], `segment.0.exemplars` (indices into the header's) and `segment.0.windows` (from which point on each
//! exemplar's are, and their number). The eigenpoint of a place of a list is the list's centroid plus `steps` times (code +
//! (fine + ½)/16); a byte of `fine` has the even coordinate in its low half, the odd one in its high half, both signed.
//!
//! Signatures of intensities have `eigenpoints` [points, dimension], `points` [points, 3] (x, y in pixels, salience), `radius`
//! [points] (which of the options' radii), `owner` [points] (index into the exemplars), `spectra` [points, rings, 24]. So had
//! those of gradients in format 1, with `spectra` [points, rings, 108]. Files of releases without `radius`, `spectra`, `contours`
//! and `confidence` have one radius and none of the others.

use safetensors::tensor::Dtype;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{ArtifactError, File, Tensor, le_bytes};
use crate::database::{Counts, LandmarkReport, Name};
use landmarkd_core::eigen::inverted_index::{BLOCK, SegmentColumns};
use landmarkd_core::recognition::landmarks::{
    Confidence, EdgePoint, EncodedParts, Exemplar, LandmarkOptions, LandmarkParts, Landmarks, PlainParts,
    SegmentParts, WindowParts,
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

/// Header and tensors of a model's parts.
pub(super) fn header_and_tensors<'a>(
    parts: &'a LandmarkParts,
    report: &LandmarkReport,
) -> (LandmarkHeader, Vec<Tensor<'a>>) {
    let header = LandmarkHeader {
        total_variance: parts.total_variance,
        exemplars: parts.exemplars.iter().map(ExemplarDocument::from).collect(),
        confidence: parts.confidence.as_ref().map(ConfidenceDocument::from),
        report: report.clone(),
    };
    let (dimension, signature) = (parts.eigenvalues.len(), parts.mean.len());
    let mut tensors = vec![
        Tensor::of_f32("basis", vec![dimension, signature], &parts.basis),
        Tensor::of_f64("eigenvalues", &parts.eigenvalues),
        Tensor::of_f32("mean", vec![signature], &parts.mean),
    ];
    match &parts.windows {
        WindowParts::Plain(plain) => tensors.extend(plain_tensors(plain, dimension, parts.options.rings)),
        WindowParts::Encoded(taught) => tensors.extend(taught_tensors(taught, dimension)),
    }
    let edges: Vec<f32> = parts.exemplars.iter().flat_map(|e| &e.edges).flat_map(edge_row).collect();
    if !edges.is_empty() {
        tensors.push(Tensor::of_f32("contours", vec![edges.len() / 4, 4], &edges));
    }
    (header, tensors)
}

fn plain_tensors(plain: &PlainParts, dimension: usize, rings: usize) -> Vec<Tensor<'_>> {
    let points = plain.owner.len();
    let owner = le_bytes(&plain.owner, u32::to_le_bytes);
    let mut tensors = vec![
        Tensor::of_f32("eigenpoints", vec![points, dimension], &plain.eigenpoints),
        Tensor::new("owner", Dtype::U32, vec![points], owner),
        Tensor::of_f32("points", vec![points, 3], &plain.points),
        Tensor::new("radius", Dtype::U8, vec![points], plain.radius[..].into()),
    ];
    if !plain.spectra.is_empty() {
        let shape = vec![points, rings, plain.spectra.len() / (points * rings)];
        tensors.push(Tensor::new("spectra", Dtype::I8, shape, le_bytes(&plain.spectra, i8::to_le_bytes)));
    }
    tensors
}

fn taught_tensors(taught: &EncodedParts, dimension: usize) -> Vec<Tensor<'_>> {
    let EncodedParts { centroids, steps, phase_basis, segments } = taught;
    let lists = centroids.len() / dimension;
    let mut tensors = vec![
        Tensor::of_f32("centroids", vec![lists, dimension], centroids),
        Tensor::of_f32("phase_basis", vec![phase_basis.len() / 72, 2, 36], phase_basis),
        Tensor::of_f32("steps", vec![dimension], steps),
    ];
    for (number, segment) in segments.iter().enumerate() {
        let SegmentParts { lists: SegmentColumns { starts, codes, fine, squares, indices }, .. } = segment;
        let (points, blocks) = (segment.levels.len(), indices.len() / BLOCK);
        let mut add = |name: &str, dtype, shape, bytes| {
            tensors.push(Tensor::new(tensor_name(number, name), dtype, shape, bytes));
        };
        add("starts", Dtype::U32, vec![lists + 1], starts.le_bytes());
        add("codes", Dtype::I8, vec![blocks, dimension.div_ceil(2), BLOCK, 2], codes.le_bytes());
        add("fine", Dtype::U8, vec![blocks, BLOCK, dimension.div_ceil(2)], fine.le_bytes());
        add("squares", Dtype::F32, vec![blocks, BLOCK], squares.le_bytes());
        add("indices", Dtype::U32, vec![blocks, BLOCK], indices.le_bytes());
        add("positions", Dtype::U16, vec![points, 2], segment.positions.le_bytes());
        add("levels", Dtype::U8, vec![points], segment.levels.le_bytes());
        add(
            "phases",
            Dtype::U8,
            vec![points, segment.phases.len() / points.max(1)],
            segment.phases.le_bytes(),
        );
        add("windows", Dtype::U32, vec![segment.starts.len()], segment.starts.le_bytes());
        let exemplars = le_bytes(&segment.exemplars, u32::to_le_bytes);
        add("exemplars", Dtype::U32, vec![segment.exemplars.len()], exemplars);
    }
    tensors
}

/// The name of a segment's tensor.
fn tensor_name(segment: usize, name: &str) -> String {
    format!("segment.{segment}.{name}")
}

fn plain_parts(file: &File) -> Result<PlainParts, ArtifactError> {
    let owner = file.values("owner", Dtype::U32, u32::from_le_bytes)?;
    Ok(PlainParts {
        eigenpoints: file.values("eigenpoints", Dtype::F32, f32::from_le_bytes)?,
        points: file.values("points", Dtype::F32, f32::from_le_bytes)?,
        radius: file
            .optional("radius", Dtype::U8, u8::from_le_bytes)?
            .unwrap_or_else(|| vec![0; owner.len()]),
        spectra: file.optional("spectra", Dtype::I8, i8::from_le_bytes)?.unwrap_or_default(),
        owner,
    })
}

fn taught_parts(file: &File) -> Result<EncodedParts, ArtifactError> {
    let floats = |name| file.values(name, Dtype::F32, f32::from_le_bytes);
    let segments = (0..).take_while(|&number| file.has(&tensor_name(number, "starts")));
    Ok(EncodedParts {
        centroids: floats("centroids")?,
        steps: floats("steps")?,
        phase_basis: floats("phase_basis")?,
        segments: segments.map(|number| segment(file, number)).collect::<Result<_, _>>()?,
    })
}

fn segment(file: &File, number: usize) -> Result<SegmentParts, ArtifactError> {
    let name = |name| tensor_name(number, name);
    Ok(SegmentParts {
        lists: SegmentColumns {
            starts: file.column(&name("starts"), Dtype::U32)?,
            codes: file.column(&name("codes"), Dtype::I8)?,
            fine: file.column(&name("fine"), Dtype::U8)?,
            squares: file.column(&name("squares"), Dtype::F32)?,
            indices: file.column(&name("indices"), Dtype::U32)?,
        },
        positions: file.column(&name("positions"), Dtype::U16)?,
        levels: file.column(&name("levels"), Dtype::U8)?,
        phases: file.column(&name("phases"), Dtype::U8)?,
        starts: file.column(&name("windows"), Dtype::U32)?,
        exemplars: file.values(&name("exemplars"), Dtype::U32, u32::from_le_bytes)?,
    })
}

/// The model of header and tensors that may hold anything, with what it counts.
pub(super) fn assemble(
    options: LandmarkOptions,
    header: LandmarkHeader,
    file: &File,
) -> Result<(Landmarks, Counts), ArtifactError> {
    let edges = file.optional("contours", Dtype::F32, f32::from_le_bytes)?.unwrap_or_default();
    let parts = LandmarkParts {
        options,
        exemplars: exemplars(header.exemplars, &edges)?,
        mean: file.values("mean", Dtype::F32, f32::from_le_bytes)?,
        basis: file.values("basis", Dtype::F32, f32::from_le_bytes)?,
        eigenvalues: file.values("eigenvalues", Dtype::F64, f64::from_le_bytes)?,
        total_variance: header.total_variance,
        confidence: header.confidence.map(Confidence::from),
        windows: match file.has("eigenpoints") {
            true => WindowParts::Plain(plain_parts(file)?),
            false => WindowParts::Encoded(taught_parts(file)?),
        },
    };
    let named = |exemplar: &Exemplar| {
        (exemplar.is_negative() || Name::parse(&exemplar.label).is_ok())
            && Uuid::try_parse(&exemplar.id).is_ok()
    };
    if !parts.exemplars.iter().all(named) {
        return Err(ArtifactError::Contents);
    }
    let radii = parts.options.subwindow_radii_px.len().max(1) as u64;
    let exemplars = parts.exemplars.len() as u64;
    let windows: u64 = parts.exemplars.iter().fold(0, |sum, e| sum.saturating_add(e.windows as u64));
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
