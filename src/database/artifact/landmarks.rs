//! The tensors of a landmark database: `mean` [signature], `basis` [dimension, signature], `eigenvalues` [dimension]; where
//! matches say where an exemplar lies also `contours` [contour points, 4] (x, y from the picture's centre in pixels, gradient
//! along x and y), exemplar by exemplar. Exemplars stand in the header.
//!
//! Signatures of gradients have windows in lists (`recognition/landmarks/multiscale`): `centroids` [lists, dimension],
//! `steps` [dimension], `phase_basis` [56, 2, 36], `vlad_centroids` [64 at most, dimension], `descriptors` [exemplars, 256],
//! `names` [exemplars, 32] and `exemplars` [bytes], from which parts can be read: exemplar by exemplar first a row a window,
//! then four f32 a contour point as `contours` has them, without which the file is then; its name is the BLAKE3 hash of those
//! bytes. A row is the list (u32), `dimension` codes (i8), half as many bytes of what those leave, x and y (u16; the longer side
//! of the exemplar at its working size is 65535), the level (u8), 64 bytes of phases, all little-endian. The eigenpoint of a
//! window is its list's centroid plus `steps` times (code + (left + ½)/16); a byte of what is left has the even coordinate in
//! its low half, the odd one in its high half, both signed.
//!
//! Signatures of intensities have `eigenpoints` [points, dimension], `points` [points, 3] (x, y in pixels, salience), `radius`
//! [points] (which of the options' radii), `owner` [points] (index into the exemplars), `spectra` [points, rings, 24]. So had
//! those of gradients in format 1, with `spectra` [points, rings, 108]. Files of releases without `radius`, `spectra`, `contours`
//! and `confidence` have one radius and none of the others.

use safetensors::tensor::Dtype;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::outline::{EXEMPLARS, ExemplarPlace};
use super::{ArtifactError, File, NO_DIGITS, Tensor, le_bytes};
use crate::database::survey::Surveys;
use crate::database::{Counts, LandmarkReport, Name};
use crate::store::BlobName;
use landmarkd_core::recognition::landmarks::{
    Confidence, EdgePoint, EncodedParts, Exemplar, LandmarkOptions, LandmarkParts, Landmarks, PlainParts,
    WindowParts,
};

/// The members of the header that only a landmark database has.
#[derive(Serialize, Deserialize)]
pub(super) struct LandmarkHeader {
    total_variance: f64,
    exemplars: Vec<ExemplarDocument>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    confidence: Option<ConfidenceDocument>,
    /// With signatures of gradients the hash of the file without the tensor `exemplars`, its digits and those of the
    /// checksum as they are before they are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) outline: Option<String>,
    /// Of the exemplars that have any.
    #[serde(default, skip_serializing_if = "Surveys::is_empty")]
    pub(super) surveys: Surveys,
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
    surveys: &Surveys,
) -> (LandmarkHeader, Vec<Tensor<'a>>) {
    let header = LandmarkHeader {
        total_variance: parts.total_variance,
        exemplars: parts.exemplars.iter().map(ExemplarDocument::from).collect(),
        confidence: parts.confidence.as_ref().map(ConfidenceDocument::from),
        outline: matches!(parts.windows, WindowParts::Encoded(_)).then(|| NO_DIGITS.into()),
        surveys: surveys.clone(),
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
        WindowParts::Encoded(encoded) => {
            tensors.extend(encoded_tensors(encoded, &parts.exemplars, dimension));
            return (header, tensors);
        }
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

/// # Panics
/// If the windows are elsewhere.
fn encoded_tensors<'a>(
    encoded: &'a EncodedParts,
    exemplars: &[Exemplar],
    dimension: usize,
) -> Vec<Tensor<'a>> {
    let EncodedParts { centroids, steps, phase_basis, vlad_centroids, descriptors, rows } = encoded;
    let mut rows = rows.as_deref().expect("the windows of an artifact are beside it");
    let row_length = rows.len() / exemplars.iter().map(|e| e.windows).sum::<usize>().max(1);
    let (mut names, mut bytes) = (Vec::new(), Vec::with_capacity(rows.len()));
    for exemplar in exemplars {
        let start = bytes.len();
        let (own, others) = rows.split_at(exemplar.windows * row_length);
        bytes.extend(own);
        bytes.extend(exemplar.edges.iter().flat_map(edge_row).flat_map(f32::to_le_bytes));
        names.extend(BlobName::of(&bytes[start..]).as_bytes());
        rows = others;
    }
    let bytes_of = |name: &'static str, shape: Vec<usize>, bytes: Vec<u8>| {
        Tensor::new(name, Dtype::U8, shape, bytes.into())
    };
    vec![
        Tensor::of_f32("centroids", vec![centroids.len() / dimension, dimension], centroids),
        Tensor::of_f32("phase_basis", vec![phase_basis.len() / 72, 2, 36], phase_basis),
        Tensor::of_f32("steps", vec![dimension], steps),
        Tensor::of_f32("vlad_centroids", vec![vlad_centroids.len() / dimension, dimension], vlad_centroids),
        bytes_of(
            "descriptors",
            vec![exemplars.len(), descriptors.len() / exemplars.len().max(1)],
            descriptors.clone(),
        ),
        bytes_of("names", vec![exemplars.len(), 32], names),
        bytes_of(EXEMPLARS, vec![bytes.len()], bytes),
    ]
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

/// Windows in lists, with the edge points of the exemplars.
fn encoded_parts(
    file: &File,
    documents: &[ExemplarDocument],
    dimension: usize,
) -> Result<(EncodedParts, Vec<Vec<EdgePoint>>), ArtifactError> {
    let floats = |name| file.values(name, Dtype::F32, f32::from_le_bytes);
    let bytes = |name| Ok::<_, ArtifactError>(file.data(name, Dtype::U8)?.to_vec());
    let (mut rows, mut edges) = (None, vec![Vec::new(); documents.len()]);
    if file.has(EXEMPLARS) {
        let (all, places) = (file.data(EXEMPLARS, Dtype::U8)?, places(file, documents, dimension)?);
        let end = places.last().map_or(0, |place| place.range.end);
        if end != all.len() as u64 {
            return Err(ArtifactError::Contents);
        }
        let mut own_rows = Vec::with_capacity(all.len());
        for (place, edges) in places.iter().zip(&mut edges) {
            let piece = &all[place.range.start as usize..place.range.end as usize];
            let (own, points) = place.parts(piece).ok_or(ArtifactError::Contents)?;
            if BlobName::of(piece) != place.name {
                return Err(ArtifactError::Checksum);
            }
            own_rows.extend_from_slice(own);
            *edges = points;
        }
        rows = Some(own_rows);
    }
    let parts = EncodedParts {
        centroids: floats("centroids")?,
        steps: floats("steps")?,
        phase_basis: floats("phase_basis")?,
        vlad_centroids: floats("vlad_centroids")?,
        descriptors: bytes("descriptors")?,
        rows,
    };
    Ok((parts, edges))
}

/// Where the windows and edge points of each exemplar lie in the tensor `exemplars`.
fn places(
    file: &File,
    documents: &[ExemplarDocument],
    dimension: usize,
) -> Result<Vec<ExemplarPlace>, ArtifactError> {
    let (names, rest) = file.data("names", Dtype::U8)?.as_chunks::<32>();
    if names.len() != documents.len() || !rest.is_empty() {
        return Err(ArtifactError::Contents);
    }
    let mut start = 0_u64;
    let place = |(document, name): (&ExemplarDocument, &[u8; 32])| {
        let length = |count: usize, of: usize| (count as u64).checked_mul(of as u64);
        let rows = length(document.points, EncodedParts::row_length(dimension))?;
        let end = start.checked_add(rows)?.checked_add(length(document.contour_points, EDGE_LENGTH)?)?;
        let range = std::mem::replace(&mut start, end)..end;
        Some(ExemplarPlace { name: BlobName::of_hash(*name), range, rows_length: rows as usize })
    };
    documents.iter().zip(names).map(place).collect::<Option<_>>().ok_or(ArtifactError::Contents)
}

/// The model of header and tensors that may hold anything, with what it counts, and where its exemplars lie if they are elsewhere.
pub(super) fn assemble(
    options: LandmarkOptions,
    header: LandmarkHeader,
    file: File,
) -> Result<(Landmarks, Counts, Vec<ExemplarPlace>), ArtifactError> {
    let eigenvalues = file.values("eigenvalues", Dtype::F64, f64::from_le_bytes)?;
    let documents = &header.exemplars;
    let (windows, edges) = if file.has("eigenpoints") {
        let contours = file.optional("contours", Dtype::F32, f32::from_le_bytes)?.unwrap_or_default();
        (WindowParts::Plain(plain_parts(&file)?), edges_of(documents, &contours)?)
    } else {
        let (encoded, edges) = encoded_parts(&file, documents, eigenvalues.len())?;
        (WindowParts::Encoded(encoded), edges)
    };
    let places = match file.has(EXEMPLARS) || file.has("eigenpoints") {
        true => Vec::new(),
        false => places(&file, documents, eigenvalues.len())?,
    };
    let parts = LandmarkParts {
        options,
        exemplars: exemplars(header.exemplars, edges)?,
        mean: file.values("mean", Dtype::F32, f32::from_le_bytes)?,
        basis: file.values("basis", Dtype::F32, f32::from_le_bytes)?,
        eigenvalues,
        total_variance: header.total_variance,
        confidence: header.confidence.map(Confidence::from),
        windows,
    };
    // hundreds of megabytes, which the parts have by now
    drop(file);
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
    Ok((landmarks, counts, places))
}

/// The edge templates of the exemplars, whose rows are those of the tensor `contours`, no more and no fewer.
fn edges_of(documents: &[ExemplarDocument], contours: &[f32]) -> Result<Vec<Vec<EdgePoint>>, ArtifactError> {
    let (mut left, rest) = contours.as_chunks::<4>();
    let mut edges = Vec::with_capacity(documents.len());
    for document in documents {
        let (own, others) = left.split_at_checked(document.contour_points).ok_or(ArtifactError::Contents)?;
        left = others;
        edges.push(own.iter().map(|&row| edge_point(row)).collect());
    }
    if left.is_empty() && rest.is_empty() { Ok(edges) } else { Err(ArtifactError::Contents) }
}

/// The exemplars with their edge templates.
fn exemplars(
    documents: Vec<ExemplarDocument>,
    edges: Vec<Vec<EdgePoint>>,
) -> Result<Vec<Exemplar>, ArtifactError> {
    let exemplar = |(document, edges): (ExemplarDocument, Vec<EdgePoint>)| match document.label.as_deref() {
        Some("") => Err(ArtifactError::Contents),
        _ => Ok(Exemplar {
            id: document.id,
            label: document.label.unwrap_or_default(),
            width_px: document.width_px,
            height_px: document.height_px,
            windows: document.points,
            edges,
        }),
    };
    documents.into_iter().zip(edges).map(exemplar).collect()
}

/// Bytes of an edge point.
const EDGE_LENGTH: usize = 16;

/// The edge points of a row of bytes.
pub(super) fn edge_points(bytes: &[u8]) -> Vec<EdgePoint> {
    let rows = bytes.as_chunks::<4>().0.as_chunks::<4>().0;
    rows.iter().map(|row| edge_point(row.map(f32::from_le_bytes))).collect()
}

fn edge_point([x_px, y_px, gradient_x, gradient_y]: [f32; 4]) -> EdgePoint {
    EdgePoint { x_px, y_px, gradient_x, gradient_y }
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
