//! The tensors of an object database: of the universal eigenspace `mean` [appearance], `basis` [dimension,
//! appearance], `eigenvalues` [dimension] and `eigenpoints` [views, dimension]; of the objects' own, one after
//! another, `own_means` [objects, appearance], `own_bases` [all dimensions, appearance], `own_eigenvalues` and
//! `own_eigenpoints` (views × dimension of each); and `held_out_deg`. Views, and how many of these numbers are each
//! object's, stand in the header.

use safetensors::tensor::Dtype;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{ArtifactError, File, Tensor};
use crate::database::{Counts, Name, ObjectsReport};
use landmarkd_core::recognition::objects::{
    Acceptance, Eigenspace, Logistic, ObjectOptions, ObjectPart, ObjectParts, Objects, ViewName,
};

/// The members of the header that only an object database has.
#[derive(Serialize, Deserialize)]
pub(super) struct ObjectHeader {
    width_px: usize,
    height_px: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    window_px: Option<f64>,
    total_variance: f64,
    views: Vec<ViewDocument>,
    objects: Vec<ObjectDocument>,
    calibration: Option<CalibrationDocument>,
    pub(super) report: ObjectsReport,
}

#[derive(Serialize, Deserialize)]
struct ViewDocument {
    id: String,
    label: String,
    pose_deg: Option<f64>,
}

#[derive(Serialize, Deserialize)]
struct ObjectDocument {
    /// Of its own eigenspace, if it has one.
    own_dimension: Option<usize>,
    total_variance: f64,
    views: usize,
    held_out: usize,
    scale: Option<f64>,
    usual: f64,
}

#[derive(Serialize, Deserialize)]
struct CalibrationDocument {
    shrink: f64,
    angle_part: f64,
    radius: f64,
    threshold: f64,
    /// Offset and slope.
    confidence: Option<(f64, f64)>,
}

/// Header and tensors of a model.
pub(super) fn header_and_tensors(
    parts: &ObjectParts,
    report: &ObjectsReport,
) -> (ObjectHeader, Vec<Tensor<'static>>) {
    (header_of(parts, report), tensors_of(parts))
}

fn header_of(parts: &ObjectParts, report: &ObjectsReport) -> ObjectHeader {
    let by_object = parts.objects.iter().zip(parts.views.chunk_by(|a, b| a.label == b.label));
    ObjectHeader {
        width_px: parts.width_px,
        height_px: parts.height_px,
        window_px: parts.window_px,
        total_variance: parts.universal.total_variance,
        objects: by_object
            .map(|(part, views)| ObjectDocument {
                own_dimension: part.space.as_ref().map(Eigenspace::dimension),
                total_variance: part.space.as_ref().map_or(0.0, |space| space.total_variance),
                views: views.len(),
                held_out: part.held_out_deg.len(),
                scale: part.scale,
                usual: part.typical_distance,
            })
            .collect(),
        views: (parts.views.iter())
            .map(|view| ViewDocument {
                id: view.id.clone(),
                label: view.label.clone(),
                pose_deg: view.pose_deg,
            })
            .collect(),
        calibration: parts.acceptance.map(|acceptance| CalibrationDocument {
            shrink: acceptance.distance_ratio,
            angle_part: acceptance.tangential_part,
            radius: acceptance.radius,
            threshold: acceptance.threshold,
            confidence: acceptance.confidence.map(|fit| (fit.offset, fit.slope)),
        }),
        report: report.clone(),
    }
}

fn tensors_of(parts: &ObjectParts) -> Vec<Tensor<'static>> {
    let (appearance, dimension) = (parts.universal.mean.len(), parts.universal.dimension());
    let own = || parts.objects.iter().filter_map(|part| part.space.as_ref());
    let own_means: Vec<f32> = own().flat_map(|space| &space.mean).copied().collect();
    let own_bases: Vec<f32> = own().flat_map(|space| &space.basis).copied().collect();
    let own_eigenvalues: Vec<f64> = own().flat_map(|space| &space.eigenvalues).copied().collect();
    let own_eigenpoints: Vec<f32> =
        parts.objects.iter().flat_map(|part| &part.eigenpoints).copied().collect();
    let held_out: Vec<f64> = parts.objects.iter().flat_map(|part| &part.held_out_deg).copied().collect();
    vec![
        Tensor::of_f32("basis", vec![dimension, appearance], &parts.universal.basis),
        Tensor::of_f32("eigenpoints", vec![parts.views.len(), dimension], &parts.eigenpoints),
        Tensor::of_f64("eigenvalues", &parts.universal.eigenvalues),
        Tensor::of_f64("held_out_deg", &held_out),
        Tensor::of_f32("mean", vec![appearance], &parts.universal.mean),
        Tensor::of_f32("own_bases", vec![own_eigenvalues.len(), appearance], &own_bases),
        Tensor::of_f32("own_eigenpoints", vec![own_eigenpoints.len()], &own_eigenpoints),
        Tensor::of_f64("own_eigenvalues", &own_eigenvalues),
        Tensor::of_f32("own_means", vec![own().count(), appearance], &own_means),
    ]
}

/// The model of a header and tensors that may hold anything, with what it counts.
///
/// # Errors
/// [`ArtifactError`]: a tensor is missing, or the parts don't fit together.
pub(super) fn assemble(
    options: ObjectOptions,
    header: ObjectHeader,
    tensors: &File,
) -> Result<(Objects, Counts), ArtifactError> {
    let universal = Eigenspace {
        mean: floats(tensors, "mean")?,
        basis: floats(tensors, "basis")?,
        eigenvalues: doubles(tensors, "eigenvalues")?,
        total_variance: header.total_variance,
    };
    let parts = ObjectParts {
        options,
        width_px: header.width_px,
        height_px: header.height_px,
        window_px: header.window_px,
        views: (header.views.into_iter())
            .map(|view| ViewName { id: view.id, label: view.label, pose_deg: view.pose_deg })
            .collect(),
        eigenpoints: floats(tensors, "eigenpoints")?,
        objects: object_parts(header.objects, universal.mean.len(), tensors)?,
        universal,
        acceptance: header.calibration.map(|document| Acceptance {
            distance_ratio: document.shrink,
            tangential_part: document.angle_part,
            radius: document.radius,
            threshold: document.threshold,
            confidence: document.confidence.map(|(offset, slope)| Logistic { offset, slope }),
        }),
    };
    let is_valid = |view: &ViewName| Name::parse(&view.label).is_ok() && Uuid::try_parse(&view.id).is_ok();
    if !parts.views.iter().all(is_valid) {
        return Err(ArtifactError::Contents);
    }
    let model = Objects::try_from(parts).map_err(|source| ArtifactError::Parts { source: source.into() })?;
    let (exemplars, labels) = (model.views().len() as u64, model.labels().len() as u64);
    Ok((model, Counts { exemplars, labels, interest_points: 0 }))
}

/// The objects' own parts, each the next rows of the tensors that hold those of all; nothing may be left over.
fn object_parts(
    documents: Vec<ObjectDocument>,
    appearance: usize,
    tensors: &File,
) -> Result<Vec<ObjectPart>, ArtifactError> {
    let mut means = Rest::of(floats(tensors, "own_means")?);
    let mut bases = Rest::of(floats(tensors, "own_bases")?);
    let mut eigenvalues = Rest::of(doubles(tensors, "own_eigenvalues")?);
    let mut eigenpoints = Rest::of(floats(tensors, "own_eigenpoints")?);
    let mut held_out = Rest::of(doubles(tensors, "held_out_deg")?);
    let mut objects = Vec::with_capacity(documents.len());
    for object in documents {
        let space = match object.own_dimension {
            None => None,
            Some(dimension) => Some(Eigenspace {
                mean: means.take(appearance, 1)?,
                basis: bases.take(dimension, appearance)?,
                eigenvalues: eigenvalues.take(dimension, 1)?,
                total_variance: object.total_variance,
            }),
        };
        objects.push(ObjectPart {
            space,
            eigenpoints: eigenpoints.take(object.views, object.own_dimension.unwrap_or(0))?,
            scale: object.scale,
            typical_distance: object.usual,
            held_out_deg: held_out.take(object.held_out, 1)?,
        });
    }
    let is_used_up = means.is_empty()
        && bases.is_empty()
        && eigenvalues.is_empty()
        && eigenpoints.is_empty()
        && held_out.is_empty();
    if is_used_up { Ok(objects) } else { Err(ArtifactError::Contents) }
}

fn floats(tensors: &File, name: &'static str) -> Result<Vec<f32>, ArtifactError> {
    tensors.values(name, Dtype::F32, f32::from_le_bytes)
}

fn doubles(tensors: &File, name: &'static str) -> Result<Vec<f64>, ArtifactError> {
    tensors.values(name, Dtype::F64, f64::from_le_bytes)
}

/// What is left of a tensor that holds the numbers of all objects.
struct Rest<T>(std::vec::IntoIter<T>);

impl<T> Rest<T> {
    fn of(values: Vec<T>) -> Self {
        Self(values.into_iter())
    }

    fn is_empty(&self) -> bool {
        self.0.len() == 0
    }

    /// The next rows × columns numbers.
    fn take(&mut self, rows: usize, columns: usize) -> Result<Vec<T>, ArtifactError> {
        let count = rows.checked_mul(columns).filter(|&count| count <= self.0.len());
        Ok(self.0.by_ref().take(count.ok_or(ArtifactError::Contents)?).collect())
    }
}
