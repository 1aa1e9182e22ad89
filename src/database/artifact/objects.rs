//! The tensors of an object database: of the universal eigenspace `mean` [appearance], `basis` [dimension,
//! appearance], `eigenvalues` [dimension] and `eigenpoints` [views, dimension]; of the objects' own, one after
//! another, `own_means` [objects, appearance], `own_bases` [all dimensions, appearance], `own_eigenvalues` and
//! `own_eigenpoints` (views × dimension of each); and `held_out_deg`. Views, and how many of these numbers are each
//! object's, stand in the header.

use safetensors::tensor::{Dtype, SafeTensors};
use serde::{Deserialize, Serialize};
use uuid::Uuid;

use super::{ArtifactError, Tensor, le_bytes, tensor};
use crate::database::{Counts, Name, ObjectsReport};
use landmarkd_core::recognition::objects::{
    Calibration, Eigenspace, Logistic, ObjectOptions, ObjectPart, ObjectParts, Objects, ViewName,
};

/// What stands in the header of an object database beside that of all kinds.
#[derive(Serialize, Deserialize)]
pub(super) struct ObjectHeader {
    width_px: usize,
    height_px: usize,
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
pub(super) fn take_apart(objects: &Objects, report: &ObjectsReport) -> (ObjectHeader, Vec<Tensor>) {
    let parts = objects.to_parts();
    let appearance = parts.universal.mean.len();
    let counted = parts.objects.iter().zip(parts.views.chunk_by(|a, b| a.label == b.label));
    let header = ObjectHeader {
        width_px: parts.width_px,
        height_px: parts.height_px,
        total_variance: parts.universal.total_variance,
        objects: counted
            .map(|(part, views)| ObjectDocument {
                own_dimension: part.space.as_ref().map(Eigenspace::dimension),
                total_variance: part.space.as_ref().map_or(0.0, |space| space.total_variance),
                views: views.len(),
                held_out: part.held_out_deg.len(),
                scale: part.scale,
                usual: part.usual,
            })
            .collect(),
        views: (parts.views.iter())
            .map(|view| ViewDocument {
                id: view.id.clone(),
                label: view.label.clone(),
                pose_deg: view.pose_deg,
            })
            .collect(),
        calibration: parts.calibration.map(|c| CalibrationDocument {
            shrink: c.shrink,
            angle_part: c.angle_part,
            radius: c.radius,
            threshold: c.threshold,
            confidence: c.confidence.map(|fit| (fit.offset, fit.slope)),
        }),
        report: report.clone(),
    };
    let own = || parts.objects.iter().filter_map(|part| part.space.as_ref());
    let own_means: Vec<f32> = own().flat_map(|space| &space.mean).copied().collect();
    let own_bases: Vec<f32> = own().flat_map(|space| &space.basis).copied().collect();
    let own_eigenvalues: Vec<f64> = own().flat_map(|space| &space.eigenvalues).copied().collect();
    let own_eigenpoints: Vec<f32> =
        parts.objects.iter().flat_map(|part| &part.eigenpoints).copied().collect();
    let held_out: Vec<f64> = parts.objects.iter().flat_map(|part| &part.held_out_deg).copied().collect();
    let dimension = parts.universal.dimension();
    let float = |name, shape, values: &[f32]| (name, Dtype::F32, shape, le_bytes(values, f32::to_le_bytes));
    let double =
        |name, values: &[f64]| (name, Dtype::F64, vec![values.len()], le_bytes(values, f64::to_le_bytes));
    let tensors = vec![
        float("basis", vec![dimension, appearance], &parts.universal.basis),
        float("eigenpoints", vec![parts.views.len(), dimension], &parts.eigenpoints),
        double("eigenvalues", &parts.universal.eigenvalues),
        double("held_out_deg", &held_out),
        float("mean", vec![appearance], &parts.universal.mean),
        float("own_bases", vec![own_eigenvalues.len(), appearance], &own_bases),
        float("own_eigenpoints", vec![own_eigenpoints.len()], &own_eigenpoints),
        double("own_eigenvalues", &own_eigenvalues),
        float("own_means", vec![own().count(), appearance], &own_means),
    ];
    (header, tensors)
}

/// The model of header and tensors that may hold anything, with what it counts.
pub(super) fn put_together(
    options: ObjectOptions,
    header: ObjectHeader,
    tensors: &SafeTensors,
) -> Result<(Objects, Counts), ArtifactError> {
    let float = |name| tensor(tensors, name, Dtype::F32, f32::from_le_bytes);
    let double = |name| tensor(tensors, name, Dtype::F64, f64::from_le_bytes);
    let universal = Eigenspace {
        mean: float("mean")?,
        basis: float("basis")?,
        eigenvalues: double("eigenvalues")?,
        total_variance: header.total_variance,
    };
    let appearance = universal.mean.len();
    let mut own_means = Rest::of(float("own_means")?);
    let mut own_bases = Rest::of(float("own_bases")?);
    let mut own_eigenvalues = Rest::of(double("own_eigenvalues")?);
    let mut own_eigenpoints = Rest::of(float("own_eigenpoints")?);
    let mut held_out = Rest::of(double("held_out_deg")?);
    let mut objects = Vec::with_capacity(header.objects.len());
    for object in header.objects {
        let space = match object.own_dimension {
            None => None,
            Some(dimension) => Some(Eigenspace {
                mean: own_means.take(appearance, 1)?,
                basis: own_bases.take(dimension, appearance)?,
                eigenvalues: own_eigenvalues.take(dimension, 1)?,
                total_variance: object.total_variance,
            }),
        };
        objects.push(ObjectPart {
            space,
            eigenpoints: own_eigenpoints.take(object.views, object.own_dimension.unwrap_or(0))?,
            scale: object.scale,
            usual: object.usual,
            held_out_deg: held_out.take(object.held_out, 1)?,
        });
    }
    let over = [
        own_means.0.len(),
        own_bases.0.len(),
        own_eigenvalues.0.len(),
        own_eigenpoints.0.len(),
        held_out.0.len(),
    ];
    if over.iter().any(|&left| left > 0) {
        return Err(ArtifactError::Contents);
    }
    let parts = ObjectParts {
        options,
        width_px: header.width_px,
        height_px: header.height_px,
        views: (header.views.into_iter())
            .map(|view| ViewName { id: view.id, label: view.label, pose_deg: view.pose_deg })
            .collect(),
        eigenpoints: float("eigenpoints")?,
        universal,
        objects,
        calibration: header.calibration.map(|c| Calibration {
            shrink: c.shrink,
            angle_part: c.angle_part,
            radius: c.radius,
            threshold: c.threshold,
            confidence: c.confidence.map(|(offset, slope)| Logistic { offset, slope }),
        }),
    };
    let named = |view: &ViewName| Name::parse(&view.label).is_ok() && Uuid::try_parse(&view.id).is_ok();
    if !parts.views.iter().all(named) {
        return Err(ArtifactError::Contents);
    }
    let model =
        Objects::from_parts(parts).map_err(|source| ArtifactError::Parts { source: source.into() })?;
    let (exemplars, labels) = (model.views().len() as u64, model.labels().len() as u64);
    Ok((model, Counts { exemplars, labels, interest_points: 0 }))
}

/// What is left of a tensor that holds the numbers of all objects.
struct Rest<T>(std::vec::IntoIter<T>);

impl<T> Rest<T> {
    fn of(values: Vec<T>) -> Self {
        Self(values.into_iter())
    }

    /// The next rows × columns numbers.
    fn take(&mut self, rows: usize, columns: usize) -> Result<Vec<T>, ArtifactError> {
        let count = rows.checked_mul(columns).filter(|&count| count <= self.0.len());
        Ok(self.0.by_ref().take(count.ok_or(ArtifactError::Contents)?).collect())
    }
}
