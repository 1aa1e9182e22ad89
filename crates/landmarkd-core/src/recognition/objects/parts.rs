//! A trained object database as plain vectors, and back: what an artifact file holds.
//!
//! The vectors may come from anywhere: every length, index, order and number is checked.

use std::ops::RangeInclusive;

use thiserror::Error;

use super::appearance::Canvas;
use super::calibration::Calibration;
use super::model::{Objects, ViewName, way};
use super::object::{KnownObject, ViewSet};
use super::options::{Distance, MAX_DIMENSION, MAX_SIDE_PX, ObjectOptions, Stages};
use super::training::AUTO_DIMENSION;
use crate::eigen::{ClassCovariance, EigenError, Eigenspace, Vicinity};
use crate::recognition::OptionFault;

/// No number of a trained database is larger: pictures have energy one. Squares and sums of such numbers stay finite.
const LARGEST: f64 = 1e6;

/// All that a trained object database is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectParts {
    pub options: ObjectOptions,
    /// Size of the database's pictures.
    pub width_px: usize,
    pub height_px: usize,
    /// Sorted by label, then pose (none last), then id.
    pub views: Vec<ViewName>,
    /// Of all views.
    pub universal: Eigenspace,
    /// views × dimension, row-major.
    pub eigenpoints: Vec<f32>,
    /// One for each label, ascending.
    pub objects: Vec<ObjectPart>,
    pub calibration: Option<Calibration>,
}

/// What one object is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectPart {
    /// Its own eigenspace, its dimension perhaps 0; `None` with [`Stages::UniversalOnly`].
    pub space: Option<Eigenspace>,
    /// views × dimension, row-major, in its own space; empty without one.
    pub eigenpoints: Vec<f32>,
    /// Root mean square distance of held-out views; `None` if nothing was held out.
    pub scale: Option<f64>,
    /// Expected distance of a query.
    pub usual: f64,
    /// Held-out error at each different pose, ascending; or empty.
    pub held_out_deg: Vec<f64>,
}

/// What is wrong with the parts of an object database.
#[derive(Debug, Error, PartialEq)]
pub enum PartsError {
    #[error("the options can't be used")]
    Options { faults: Vec<OptionFault> },
    #[error("{part} has {found} values where {expected} belong")]
    Length { part: &'static str, expected: usize, found: usize },
    #[error("{part} holds a number that is not finite, too large, or negative where it can't be")]
    Number { part: &'static str },
    #[error("{part} are not in their order, or not different")]
    Order { part: &'static str },
    #[error("an eigenspace is none")]
    Eigenspace { source: EigenError },
}

impl Objects {
    /// Copy the database into plain vectors.
    pub fn to_parts(&self) -> ObjectParts {
        let part = |known: &KnownObject| ObjectPart {
            space: known.space.clone(),
            eigenpoints: if known.space.is_some() { known.points.clone() } else { Vec::new() },
            scale: known.scale,
            usual: known.usual,
            held_out_deg: known.held_out_deg.clone(),
        };
        ObjectParts {
            options: self.options.clone(),
            width_px: self.canvas.width_px,
            height_px: self.canvas.height_px,
            views: self.names.clone(),
            universal: self.universal.clone(),
            eigenpoints: self.vicinity.points().to_vec(),
            objects: self.objects.iter().map(part).collect(),
            calibration: self.calibration,
        }
    }

    /// Rebuild a database from plain vectors that may hold anything.
    pub fn from_parts(parts: ObjectParts) -> Result<Objects, PartsError> {
        let canvas = parts.check()?;
        let dimension = parts.universal.dimension();
        let mut objects = Vec::with_capacity(parts.objects.len());
        let mut owner = Vec::with_capacity(parts.views.len());
        let mut first = 0;
        for (object, (part, views)) in
            parts.objects.into_iter().zip(parts.views.chunk_by(|a, b| a.label == b.label)).enumerate()
        {
            let poses_deg: Vec<Option<f64>> = views.iter().map(|view| view.pose_deg).collect();
            let (points, dimension) = match &part.space {
                Some(space) => (part.eigenpoints, space.dimension()),
                None => {
                    (parts.eigenpoints[first * dimension..][..views.len() * dimension].to_vec(), dimension)
                }
            };
            let set = ViewSet::new(&points, &poses_deg, dimension);
            let expected = set.poses_deg.len();
            if ![0, expected].contains(&part.held_out_deg.len()) {
                let found = part.held_out_deg.len();
                return Err(PartsError::Length { part: "held-out errors", expected, found });
            }
            objects.push(KnownObject {
                label: views[0].label.clone(),
                space: part.space,
                views: set,
                scale: part.scale,
                usual: part.usual,
                held_out_deg: part.held_out_deg,
                points,
            });
            owner.extend(vec![object; views.len()]);
            first += views.len();
        }
        let covariances = match parts.options.distance {
            Distance::Euclidean => None,
            Distance::Mahalanobis => Some(
                ClassCovariance::fit(&parts.eigenpoints, dimension, &owner, objects.len())
                    .map_err(|source| PartsError::Eigenspace { source })?,
            ),
        };
        Ok(Objects {
            vicinity: Vicinity::new(parts.eigenpoints, dimension, way(parts.options.search)),
            options: parts.options,
            canvas,
            names: parts.views,
            universal: parts.universal,
            owner,
            objects,
            covariances,
            calibration: parts.calibration,
        })
    }
}

impl ObjectParts {
    fn check(&self) -> Result<Canvas, PartsError> {
        let faults = self.options.faults();
        if !faults.is_empty() {
            return Err(PartsError::Options { faults });
        }
        if ![self.width_px, self.height_px].iter().all(|side| (1..=MAX_SIDE_PX).contains(side)) {
            return Err(PartsError::Number { part: "the size of pictures" });
        }
        let canvas = Canvas::new(&self.options, (self.width_px as u32, self.height_px as u32));
        if (canvas.width_px, canvas.height_px) != (self.width_px, self.height_px) {
            return Err(PartsError::Number { part: "the size of pictures" });
        }
        self.check_views()?;
        check_space(&self.universal, canvas.length(), 1..=MAX_DIMENSION)?;
        let dimension = self.universal.dimension();
        check_length("eigenpoints", self.views.len() * dimension, self.eigenpoints.len())?;
        check_numbers("eigenpoints", &self.eigenpoints)?;
        let groups: Vec<&[ViewName]> = self.views.chunk_by(|a, b| a.label == b.label).collect();
        check_length("objects", groups.len(), self.objects.len())?;
        for (part, views) in self.objects.iter().zip(groups) {
            let own = self.options.stages == Stages::UniversalThenObject;
            if own != part.space.is_some() {
                return Err(PartsError::Length {
                    part: "an object",
                    expected: usize::from(own),
                    found: usize::from(!own),
                });
            }
            let own_dimension = part.space.as_ref().map_or(0, Eigenspace::dimension);
            if let Some(space) = &part.space {
                check_space(space, canvas.length(), 0..=AUTO_DIMENSION)?;
            }
            check_length("an object's eigenpoints", views.len() * own_dimension, part.eigenpoints.len())?;
            check_numbers("an object's eigenpoints", &part.eigenpoints)?;
            let mut numbers = part.held_out_deg.iter().copied().chain(part.scale).chain([part.usual]);
            if !numbers.all(|v| (0.0..=LARGEST).contains(&v)) || part.scale == Some(0.0) {
                return Err(PartsError::Number { part: "an object" });
            }
        }
        if let Some(calibration) = &self.calibration {
            let Calibration { shrink, angle_part, radius, threshold, confidence } = calibration;
            let parts = [*shrink, *angle_part].iter().all(|v| (0.0..=1.0).contains(v));
            let bounds = [*radius, *threshold].iter().all(|v| (0.0..=LARGEST).contains(v));
            let sure = confidence
                .is_none_or(|fit| fit.offset.is_finite() && fit.slope.is_finite() && fit.slope <= 0.0);
            if !(parts && bounds && sure) {
                return Err(PartsError::Number { part: "the calibration" });
            }
        }
        Ok(canvas)
    }

    fn check_views(&self) -> Result<(), PartsError> {
        let key = |view: &ViewName| view.pose_deg.unwrap_or(f64::INFINITY);
        let in_order = |a: &ViewName, b: &ViewName| {
            a.label.cmp(&b.label).then(key(a).total_cmp(&key(b))).then(a.id.cmp(&b.id)).is_lt()
        };
        let mut ids: Vec<&str> = self.views.iter().map(|view| view.id.as_str()).collect();
        ids.sort_unstable();
        if !self.views.is_sorted_by(in_order) || ids.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(PartsError::Order { part: "views" });
        }
        if self.views.is_empty() {
            return Err(PartsError::Length { part: "views", expected: 2, found: 0 });
        }
        match self.views.iter().all(|view| view.pose_deg.is_none_or(|pose| (0.0..360.0).contains(&pose))) {
            true => Ok(()),
            false => Err(PartsError::Number { part: "poses" }),
        }
    }
}

fn check_length(part: &'static str, expected: usize, found: usize) -> Result<(), PartsError> {
    if expected == found { Ok(()) } else { Err(PartsError::Length { part, expected, found }) }
}

fn check_numbers(part: &'static str, values: &[f32]) -> Result<(), PartsError> {
    // a NaN is in no range
    let sound = values.iter().all(|&v| (-LARGEST..=LARGEST).contains(&f64::from(v)));
    if sound { Ok(()) } else { Err(PartsError::Number { part }) }
}

fn check_space(
    space: &Eigenspace,
    length: usize,
    dimensions: RangeInclusive<usize>,
) -> Result<(), PartsError> {
    if !dimensions.contains(&space.dimension()) || space.dimension() > length {
        let expected = *dimensions.start();
        return Err(PartsError::Length { part: "eigenvalues", expected, found: space.dimension() });
    }
    check_length("a mean", length, space.mean.len())?;
    check_length("a basis", space.dimension() * length, space.basis.len())?;
    check_numbers("a mean", &space.mean)?;
    check_numbers("a basis", &space.basis)?;
    let variances = space.eigenvalues.iter().chain([&space.total_variance]);
    if !variances.clone().all(|v| (0.0..=LARGEST).contains(v))
        || !space.eigenvalues.is_sorted_by(|a, b| a >= b)
    {
        return Err(PartsError::Number { part: "eigenvalues" });
    }
    space.check_basis().map_err(|source| PartsError::Eigenspace { source })
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{canvas, thing, turntable};
    use super::*;

    fn trained(options: &ObjectOptions) -> Objects {
        Objects::train(turntable(3, 30, options), &canvas(options), options).unwrap().0
    }

    #[test]
    fn a_database_comes_back_from_its_parts() {
        for options in [
            ObjectOptions::default(),
            ObjectOptions {
                stages: Stages::UniversalOnly,
                distance: Distance::Mahalanobis,
                ..ObjectOptions::default()
            },
        ] {
            let before = trained(&options);
            let after = Objects::from_parts(before.to_parts()).unwrap();
            assert_eq!(after.to_parts(), before.to_parts());
            for turn in [3.0, 77.0, 200.0] {
                let frame = thing(1, turn);
                assert_eq!(after.recognise(&frame, |_| ()), before.recognise(&frame, |_| ()));
            }
        }
    }

    #[test]
    fn damaged_parts_are_refused() {
        type Damage = (&'static str, fn(&mut ObjectParts));
        let damages: [Damage; 24] = [
            ("options", |p| p.options.accept = 0.0),
            ("other stages", |p| p.options.stages = Stages::UniversalOnly),
            ("other smoothing", |p| p.options.smoothing = 0.1),
            ("other size", |p| p.width_px = 47),
            ("no size", |p| p.height_px = 0),
            ("no views", |p| p.views.clear()),
            ("view lost", |p| p.views.truncate(35)),
            ("views swapped", |p| p.views.swap(0, 1)),
            ("view twice", |p| p.views[1] = p.views[0].clone()),
            ("pose", |p| p.views[0].pose_deg = Some(-1.0)),
            ("pose NaN", |p| p.views[35].pose_deg = Some(f64::NAN)),
            ("mean cut", |p| p.universal.mean.truncate(3)),
            ("basis scaled", |p| p.universal.basis.iter_mut().for_each(|v| *v *= 1.01)),
            ("eigenvalue negative", |p| *p.universal.eigenvalues.last_mut().unwrap() = -1.0),
            ("eigenpoints cut", |p| p.eigenpoints.truncate(5)),
            ("eigenpoint NaN", |p| p.eigenpoints[0] = f32::NAN),
            ("object lost", |p| p.objects.truncate(2)),
            ("own space lost", |p| p.objects[0].space = None),
            ("own basis infinite", |p| p.objects[1].space.as_mut().unwrap().basis[0] = f32::INFINITY),
            ("own eigenpoints cut", |p| p.objects[1].eigenpoints.truncate(1)),
            ("errors cut", |p| p.objects[1].held_out_deg.truncate(1)),
            ("scale zero", |p| p.objects[1].scale = Some(0.0)),
            ("threshold NaN", |p| p.calibration.as_mut().unwrap().threshold = f64::NAN),
            ("slope infinite", |p| {
                p.calibration.as_mut().unwrap().confidence.as_mut().unwrap().slope = f64::INFINITY
            }),
        ];
        for (what, damage) in damages {
            let mut parts = trained(&ObjectOptions::default()).to_parts();
            damage(&mut parts);
            assert!(Objects::from_parts(parts).is_err(), "{what} went through");
        }
    }
}
