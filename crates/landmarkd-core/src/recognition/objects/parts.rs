//! A trained object database as plain vectors, and back: the contents of an artifact file.
//!
//! The vectors may come from anywhere: every length, index, order and number is checked.

use std::ops::RangeInclusive;

use thiserror::Error;

use super::acceptance::Acceptance;
use super::appearance::Normaliser;
use super::model::{Objects, ViewName, class_covariances};
use super::object::{KnownObject, ViewSet};
use super::options::{MAX_DIMENSION, MAX_SIDE_PX, ObjectOptions, Stages};
use super::training::AUTO_DIMENSION;
use crate::eigen::{EigenError, Eigenspace, RadiusIndex};
use crate::recognition::OptionFault;

/// No number of a trained database is larger: pictures have energy one. Squares and sums of such numbers stay finite.
const LARGEST: f64 = 1e6;
/// Windows of histograms.
const WINDOWS_PX: RangeInclusive<f64> = 2.0..=64.0;

/// A trained object database as plain vectors.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectParts {
    /// The options it was trained with.
    pub options: ObjectOptions,
    /// Width of the database's pictures.
    pub width_px: usize,
    /// Height of the database's pictures.
    pub height_px: usize,
    /// Window that histograms are of; `None` of intensities, and of gradients the narrowest.
    pub window_px: Option<f64>,
    /// Sorted by label, then pose (none last), then id.
    pub views: Vec<ViewName>,
    /// Of all views.
    pub universal: Eigenspace,
    /// views × dimension, row-major.
    pub eigenpoints: Vec<f32>,
    /// One for each label, ascending.
    pub objects: Vec<ObjectPart>,
    /// `None` if no object has two views.
    pub acceptance: Option<Acceptance>,
}

/// One object as plain vectors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectPart {
    /// Its own eigenspace, its dimension perhaps 0; `None` with [`Stages::UniversalOnly`].
    pub space: Option<Eigenspace>,
    /// views × dimension, row-major, in its own space; empty without one.
    pub eigenpoints: Vec<f32>,
    /// Root mean square distance of held-out views; `None` if nothing was held out.
    pub scale: Option<f64>,
    /// Distance to be expected of a query.
    pub typical_distance: f64,
    /// Held-out error at each different pose, ascending; or empty.
    pub held_out_deg: Vec<f64>,
}

/// Why parts make no object database.
#[derive(Debug, Error, PartialEq)]
pub enum PartsError {
    /// See [`ObjectOptions::faults`].
    #[error("the options can't be used")]
    Options {
        /// All faults.
        faults: Vec<OptionFault>,
    },
    /// A vector is too long or too short.
    #[error("{part} has {found} values where {expected} belong")]
    Length {
        /// Which vector.
        part: &'static str,
        /// Its length by the others.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// A number is out of range.
    #[error("{part} holds a number that is not finite, too large, or negative where it can't be")]
    Number {
        /// Where.
        part: &'static str,
    },
    /// Sorted values are not sorted, or occur twice.
    #[error("{part} are not in their order, or not different")]
    Order {
        /// Which values.
        part: &'static str,
    },
    /// A basis is not orthonormal, or a covariance can't be inverted.
    #[error("an eigenspace is none")]
    Eigenspace {
        /// Why.
        source: EigenError,
    },
}

impl From<&Objects> for ObjectParts {
    fn from(model: &Objects) -> ObjectParts {
        ObjectParts {
            options: model.options.clone(),
            width_px: model.normaliser.width_px,
            height_px: model.normaliser.height_px,
            window_px: model.normaliser.window_px(),
            views: model.views.clone(),
            universal: model.universal.clone(),
            eigenpoints: model.radius_index.points().to_vec(),
            objects: model.objects.iter().map(|object| object.part.clone()).collect(),
            acceptance: model.acceptance,
        }
    }
}

impl TryFrom<ObjectParts> for Objects {
    type Error = PartsError;

    /// Rebuild a database from plain vectors that may hold anything.
    fn try_from(parts: ObjectParts) -> Result<Objects, PartsError> {
        let normaliser = parts.check()?;
        let dimension = parts.universal.dimension();
        let mut objects = Vec::with_capacity(parts.objects.len());
        let mut object_of_view = Vec::with_capacity(parts.views.len());
        let groups = parts.views.chunk_by(|a, b| a.label == b.label);
        for (part, views) in parts.objects.into_iter().zip(groups) {
            let universal = &parts.eigenpoints[object_of_view.len() * dimension..][..views.len() * dimension];
            object_of_view.extend(vec![objects.len(); views.len()]);
            objects.push(part.into_object(views, universal, dimension)?);
        }
        let options = parts.options;
        let covariances =
            class_covariances(options.distance, &parts.eigenpoints, &object_of_view, objects.len())
                .map_err(|source| PartsError::Eigenspace { source })?;
        Ok(Objects {
            radius_index: RadiusIndex::new(parts.eigenpoints, dimension, options.search),
            options,
            normaliser,
            views: parts.views,
            universal: parts.universal,
            object_of_view,
            objects,
            covariances,
            acceptance: parts.acceptance,
        })
    }
}

impl ObjectPart {
    /// The object of these views, whose eigenpoints in the universal eigenspace are `universal`.
    fn into_object(
        self,
        views: &[ViewName],
        universal: &[f32],
        dimension: usize,
    ) -> Result<KnownObject, PartsError> {
        let poses_deg: Vec<Option<f64>> = views.iter().map(|view| view.pose_deg).collect();
        let set = match &self.space {
            Some(space) => ViewSet::new(&self.eigenpoints, &poses_deg, space.dimension()),
            None => ViewSet::new(universal, &poses_deg, dimension),
        };
        if !self.held_out_deg.is_empty() {
            check_length("held-out errors", set.poses_deg.len(), self.held_out_deg.len())?;
        }
        Ok(KnownObject { label: views[0].label.clone(), part: self, views: set })
    }
}

impl ObjectParts {
    /// Check all that the parts of a database have to agree on.
    fn check(&self) -> Result<Normaliser, PartsError> {
        let faults = self.options.faults();
        if !faults.is_empty() {
            return Err(PartsError::Options { faults });
        }
        let normaliser = self.check_size()?;
        self.check_views()?;
        check_space(&self.universal, normaliser.length(), 1..=MAX_DIMENSION)?;
        check_length("eigenpoints", self.views.len() * self.universal.dimension(), self.eigenpoints.len())?;
        check_numbers("eigenpoints", &self.eigenpoints)?;
        let groups: Vec<&[ViewName]> = self.views.chunk_by(|a, b| a.label == b.label).collect();
        check_length("objects", groups.len(), self.objects.len())?;
        for (part, views) in self.objects.iter().zip(groups) {
            part.check(self.options.stages, views.len(), normaliser.length())?;
        }
        self.acceptance.as_ref().map_or(Ok(()), check_acceptance)?;
        Ok(normaliser)
    }

    fn check_size(&self) -> Result<Normaliser, PartsError> {
        let error = PartsError::Number { part: "the size of pictures" };
        if ![self.width_px, self.height_px].iter().all(|side| (1..=MAX_SIDE_PX).contains(side)) {
            return Err(error);
        }
        let normaliser = Normaliser::new(&self.options, (self.width_px as u32, self.height_px as u32));
        if (normaliser.width_px, normaliser.height_px) != (self.width_px, self.height_px) {
            return Err(error);
        }
        match self.window_px.is_none_or(|window_px| WINDOWS_PX.contains(&window_px)) {
            true => Ok(normaliser.with_window_px(self.window_px)),
            false => Err(PartsError::Number { part: "the window of histograms" }),
        }
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

impl ObjectPart {
    /// Check an object of so many views whose appearances have `length` components.
    fn check(&self, stages: Stages, views: usize, length: usize) -> Result<(), PartsError> {
        let needs_space = stages == Stages::UniversalThenObject;
        check_length("an object", usize::from(needs_space), usize::from(self.space.is_some()))?;
        let mut dimension = 0;
        if let Some(space) = &self.space {
            check_space(space, length, 0..=AUTO_DIMENSION)?;
            dimension = space.dimension();
        }
        check_length("an object's eigenpoints", views * dimension, self.eigenpoints.len())?;
        check_numbers("an object's eigenpoints", &self.eigenpoints)?;
        let mut numbers = self.held_out_deg.iter().copied().chain(self.scale).chain([self.typical_distance]);
        if !numbers.all(|v| (0.0..=LARGEST).contains(&v)) || self.scale == Some(0.0) {
            return Err(PartsError::Number { part: "an object" });
        }
        Ok(())
    }
}

fn check_acceptance(acceptance: &Acceptance) -> Result<(), PartsError> {
    let Acceptance { distance_ratio, tangential_part, radius, threshold, confidence } = acceptance;
    let parts = (0.0..=1.0).contains(distance_ratio);
    let bounds = [*tangential_part, *radius, *threshold].iter().all(|v| (0.0..=LARGEST).contains(v));
    let fit =
        confidence.is_none_or(|fit| fit.offset.is_finite() && fit.slope.is_finite() && fit.slope <= 0.0);
    if parts && bounds && fit { Ok(()) } else { Err(PartsError::Number { part: "the calibration" }) }
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
    use super::super::test_pictures::{normaliser, thing, turntable};
    use super::*;
    use crate::recognition::objects::{AppearanceOf, Distance, train};

    fn trained(options: &ObjectOptions) -> Objects {
        train(turntable(3, 30, options), &normaliser(options), options).unwrap().0
    }

    #[test]
    fn a_database_comes_back_from_its_parts() {
        for options in [
            ObjectOptions::default(),
            ObjectOptions::of(AppearanceOf::Intensity),
            ObjectOptions {
                stages: Stages::UniversalOnly,
                distance: Distance::Mahalanobis,
                ..ObjectOptions::default()
            },
        ] {
            let before = trained(&options);
            let after = Objects::try_from(ObjectParts::from(&before)).unwrap();
            assert_eq!(ObjectParts::from(&after), ObjectParts::from(&before));
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
            ("threshold NaN", |p| p.acceptance.as_mut().unwrap().threshold = f64::NAN),
            ("slope infinite", |p| {
                p.acceptance.as_mut().unwrap().confidence.as_mut().unwrap().slope = f64::INFINITY
            }),
        ];
        for (what, damage) in damages {
            let mut parts = ObjectParts::from(&trained(&ObjectOptions::of(AppearanceOf::Intensity)));
            damage(&mut parts);
            assert!(Objects::try_from(parts).is_err(), "{what} went through");
        }
    }
}
