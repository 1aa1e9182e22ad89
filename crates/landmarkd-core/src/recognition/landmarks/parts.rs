//! A trained database as plain vectors, and back: what an artifact file holds.
//!
//! The vectors may come from anywhere: every length, index, order and number is checked.

use thiserror::Error;

use super::confidence::Confidence;
use super::contour::ContourPoint;
use super::description::{Describer, Window};
use super::model::{Exemplar, Landmarks, Owned};
use super::options::{Colour, LandmarkOptions};
use super::prior::{coordinates, with_places, without_places};
use crate::eigen::{EigenError, EigenpointIndex, Eigenspace};
use crate::recognition::OptionFault;
use crate::vision::InterestPoint;
use crate::vision::theta_spectrum::FREQUENCIES;

/// No number of a trained database is larger: signatures have lengths about 1, and pictures fewer pixels
/// a side. Squares and sums of such numbers stay finite.
const LARGEST: f32 = 1e6;
/// No exemplar has more contour points.
const LONGEST_CONTOUR: usize = 4096;

/// All that a trained landmark database is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkParts {
    /// With the colour that is used, never `Auto`.
    pub options: LandmarkOptions,
    /// Sorted by label, then id.
    pub exemplars: Vec<Exemplar>,
    /// Mean signature.
    pub mean: Vec<f32>,
    /// dimension × signature length, row-major, rows orthonormal.
    pub basis: Vec<f32>,
    /// Variance along each row of the basis, descending.
    pub eigenvalues: Vec<f64>,
    /// Variance in all directions.
    pub total_variance: f64,
    /// n × dimension, row-major, exemplar by exemplar.
    pub eigenpoints: Vec<f32>,
    /// n × 3: x, y, salience of the interest point of each eigenpoint.
    pub points: Vec<f32>,
    /// n: which of the options' radii the window of each eigenpoint has.
    pub radius: Vec<u8>,
    /// n × rings × 24 if the options ask for spectra, else none.
    pub spectra: Vec<i8>,
    /// How sure answers are, if that was rehearsed.
    pub confidence: Option<Confidence>,
    /// n: index of the exemplar of each eigenpoint, ascending.
    pub owner: Vec<u32>,
}

/// What is wrong with the parts of a landmark database.
#[derive(Debug, Error, PartialEq)]
pub enum PartsError {
    #[error("the options can't be used")]
    Options { faults: Vec<OptionFault> },
    #[error("the colour of a trained database is gray or opponent, not auto")]
    ColourUnresolved,
    #[error("{part} has {found} values where {expected} belong")]
    Length { part: &'static str, expected: usize, found: usize },
    #[error("{part} has no values")]
    Empty { part: &'static str },
    #[error("{part} holds a number that is not finite, or too large")]
    Number { part: &'static str },
    #[error("{part} are not in their order, or not different")]
    Order { part: &'static str },
    #[error("the eigenspace is none")]
    Eigenspace { source: EigenError },
    #[error("the interest points of exemplar {exemplar} are not as many as it says")]
    Count { exemplar: usize },
}

impl Landmarks {
    /// Copy the database into plain vectors.
    pub fn to_parts(&self) -> LandmarkParts {
        LandmarkParts {
            options: self.options.clone(),
            exemplars: self.exemplars.clone(),
            mean: self.eigenspace.mean.clone(),
            basis: self.eigenspace.basis.clone(),
            eigenvalues: self.eigenspace.eigenvalues.clone(),
            total_variance: self.eigenspace.total_variance,
            eigenpoints: without_places(
                self.index.points(),
                self.dimension(),
                self.options.position_prior_px,
            ),
            points: self.owned.iter().flat_map(|o| point(&o.window.point)).collect(),
            radius: self.owned.iter().map(|o| o.window.radius).collect(),
            spectra: self.spectra.clone(),
            confidence: self.confidence,
            owner: self.owned.iter().map(|o| o.exemplar).collect(),
        }
    }

    /// Rebuild a database from plain vectors that may hold anything.
    pub fn from_parts(parts: LandmarkParts) -> Result<Landmarks, PartsError> {
        parts.check()?;
        let LandmarkParts { options, exemplars, mean, basis, eigenvalues, total_variance, .. } = parts;
        let eigenspace = Eigenspace { mean, basis, eigenvalues, total_variance };
        eigenspace.check_basis().map_err(|source| PartsError::Eigenspace { source })?;
        let dimension = eigenspace.dimension();
        let rows = parts.points.chunks_exact(3).zip(parts.radius).zip(&parts.owner);
        let owned = rows.map(|((p, radius), &exemplar)| {
            let point = InterestPoint { x_px: p[0], y_px: p[1], salience: p[2] };
            Owned { window: Window { point, radius }, exemplar }
        });
        let owned: Vec<Owned> = owned.collect();
        let (prior, windows) = (options.position_prior_px, owned.iter().map(|owned| owned.window));
        let rows = with_places(parts.eigenpoints, dimension, windows, prior);
        let describer = Describer::new(&options);
        Ok(Landmarks {
            spectrum_lengths: spectrum_lengths(&parts.spectra, &describer),
            describer,
            options,
            exemplars,
            eigenspace,
            index: EigenpointIndex::new(rows, coordinates(dimension, prior)),
            owned,
            spectra: parts.spectra,
            confidence: parts.confidence,
        })
    }
}

fn point(point: &InterestPoint) -> [f32; 3] {
    [point.x_px, point.y_px, point.salience]
}

/// The length of every kept spectrum.
pub(super) fn spectrum_lengths(spectra: &[i8], describer: &Describer) -> Vec<f32> {
    let Some(plan) = describer.turns() else { return Vec::new() };
    let length = |row: &[i8]| row.iter().map(|&v| f32::from(v).powi(2)).sum::<f32>().sqrt();
    spectra.chunks_exact(plan.length()).map(length).collect()
}

impl LandmarkParts {
    fn check(&self) -> Result<(), PartsError> {
        let faults = self.options.faults();
        if !faults.is_empty() {
            return Err(PartsError::Options { faults });
        }
        if self.options.colour == Colour::Auto {
            return Err(PartsError::ColourUnresolved);
        }

        let (dimension, points) = (self.eigenvalues.len(), self.owner.len());
        let signature_length = self.options.signature_length();
        for (part, found) in
            [("exemplars", self.exemplars.len()), ("eigenvalues", dimension), ("owner", points)]
        {
            if found == 0 {
                return Err(PartsError::Empty { part });
            }
        }
        let length = |part, expected: usize, found: usize| match expected == found {
            true => Ok(()),
            false => Err(PartsError::Length { part, expected, found }),
        };
        length("eigenvalues", dimension.min(self.options.dimension), dimension)?;
        length("mean", signature_length, self.mean.len())?;
        length("basis", dimension * signature_length, self.basis.len())?;
        length("eigenpoints", points.saturating_mul(dimension), self.eigenpoints.len())?;
        length("points", points.saturating_mul(3), self.points.len())?;
        length("radius", points, self.radius.len())?;
        let spectrum = if self.options.places() { self.options.rings * 2 * FREQUENCIES } else { 0 };
        length("spectra", points.saturating_mul(spectrum), self.spectra.len())?;
        if !self.radius.iter().all(|&radius| usize::from(radius) < self.options.subwindow_radii_px.len()) {
            return Err(PartsError::Number { part: "radius" });
        }
        let contours = self.exemplars.iter().flat_map(|e| &e.contour);
        let within = |p: &ContourPoint| {
            [p.x_px, p.y_px, p.gradient_x, p.gradient_y].iter().all(|v| v.abs() <= LARGEST)
        };
        if !contours.into_iter().all(within) {
            return Err(PartsError::Number { part: "contours" });
        }
        if let Some(confidence) = &self.confidence {
            let sound = |v: &f64| v.abs() <= f64::from(LARGEST);
            let weights = confidence.weights.iter().all(|v| *v >= 0.0 && sound(v));
            if !weights || !sound(&confidence.bias) || !(0.0..=1.0).contains(&confidence.threshold) {
                return Err(PartsError::Number { part: "confidence" });
            }
        }

        let vectors: [(&'static str, &[f32]); 4] = [
            ("mean", &self.mean),
            ("basis", &self.basis),
            ("eigenpoints", &self.eigenpoints),
            ("points", &self.points),
        ];
        for (part, values) in vectors {
            if !values.iter().all(|v| v.abs() <= LARGEST) {
                return Err(PartsError::Number { part });
            }
        }
        let variance = |v: &f64| (0.0..=f64::from(LARGEST)).contains(v);
        if !self.eigenvalues.iter().all(variance) {
            return Err(PartsError::Number { part: "eigenvalues" });
        }
        if !variance(&self.total_variance) {
            return Err(PartsError::Number { part: "total_variance" });
        }

        if !self.eigenvalues.is_sorted_by(|a, b| a >= b) {
            return Err(PartsError::Order { part: "eigenvalues" });
        }
        if !self.exemplars.is_sorted_by(|a, b| (&a.label, &a.id) < (&b.label, &b.id)) {
            return Err(PartsError::Order { part: "exemplars" });
        }
        let mut ids: Vec<&str> = self.exemplars.iter().map(|e| e.id.as_str()).collect();
        ids.sort_unstable();
        if ids.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(PartsError::Order { part: "exemplars" });
        }
        let pictured = |e: &Exemplar| {
            [e.width_px, e.height_px].iter().all(|side| *side as f32 <= LARGEST)
                && e.contour.len() <= LONGEST_CONTOUR
        };
        if !self.exemplars.iter().all(pictured) {
            return Err(PartsError::Number { part: "exemplars" });
        }
        if !self.owner.is_sorted() {
            return Err(PartsError::Order { part: "owner" });
        }
        let mut left = &self.owner[..];
        for (exemplar, e) in self.exemplars.iter().enumerate() {
            let own = left.partition_point(|&owner| owner as usize <= exemplar);
            if own != e.windows {
                return Err(PartsError::Count { exemplar });
            }
            left = &left[own..];
        }
        if !left.is_empty() {
            return Err(PartsError::Count { exemplar: self.exemplars.len() });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{described, paper, toy};
    use super::*;
    use crate::imaging::Frame;

    fn parts() -> LandmarkParts {
        let options = LandmarkOptions { dimension: 8, ..paper() };
        Landmarks::train(described(0..4, &options), &options).unwrap().0.to_parts()
    }

    #[test]
    fn a_rebuilt_database_answers_the_same() {
        let parts = parts();
        let rebuilt = Landmarks::from_parts(parts.clone()).unwrap();
        assert_eq!(rebuilt.to_parts(), parts);
        let options = LandmarkOptions { dimension: 8, ..paper() };
        let (trained, _) = Landmarks::train(described(0..4, &options), &options).unwrap();
        let frame = Frame::gray(toy(2, 96)).turned(70.0);
        assert_eq!(rebuilt.recognise(&frame, |_| ()), trained.recognise(&frame, |_| ()));
    }

    #[test]
    fn a_rebuilt_placement_database_answers_the_same_and_its_damage_is_refused() {
        let options = LandmarkOptions::default();
        let (mut trained, _) = Landmarks::train(described(0..4, &options), &options).unwrap();
        trained.confidence = Some(Confidence { weights: [2.0, 5.0, 0.0, 1.0], bias: -8.0, threshold: 0.6 });
        let parts = trained.to_parts();
        let rebuilt = Landmarks::from_parts(parts.clone()).unwrap();
        assert_eq!(rebuilt.to_parts(), parts);
        assert_eq!(rebuilt.bytes(), trained.bytes());
        let frame = Frame::gray(toy(2, 96)).turned(70.0);
        assert_eq!(rebuilt.recognise(&frame, |_| ()), trained.recognise(&frame, |_| ()));
        let damages: [fn(&mut LandmarkParts); 8] = [
            |p| p.spectra.truncate(p.spectra.len() - 1),
            |p| p.spectra.clear(),
            |p| p.radius[0] = 2,
            |p| p.radius.truncate(p.radius.len() - 1),
            |p| p.exemplars[1].contour[0].x_px = f32::NAN,
            |p| p.confidence.as_mut().unwrap().weights[1] = -1.0,
            |p| p.confidence.as_mut().unwrap().bias = f64::NAN,
            |p| p.confidence.as_mut().unwrap().threshold = 1.5,
        ];
        for (number, damage) in damages.into_iter().enumerate() {
            let mut parts = parts.clone();
            damage(&mut parts);
            assert!(Landmarks::from_parts(parts).is_err(), "damage {number} went through");
        }
    }

    #[test]
    fn damaged_parts_are_refused() {
        type Damage = (&'static str, fn(&mut LandmarkParts));
        let damages: [Damage; 26] = [
            ("options", |p| p.options.epsilon = 0.0),
            ("auto colour", |p| p.options.colour = Colour::Auto),
            ("other colour", |p| p.options.colour = Colour::Opponent),
            ("other rings", |p| p.options.rings += 1),
            ("smaller dimension", |p| p.options.dimension = 7),
            ("no exemplars", |p| p.exemplars.clear()),
            ("exemplar lost", |p| p.exemplars.truncate(p.exemplars.len() - 1)),
            ("exemplars swapped", |p| p.exemplars.swap(0, 1)),
            ("exemplar twice", |p| p.exemplars[1] = p.exemplars[0].clone()),
            ("count", |p| p.exemplars[2].windows += 1),
            ("count beyond all", |p| p.exemplars[3].windows = usize::MAX),
            ("mean cut", |p| p.mean.truncate(p.mean.len() - 1)),
            ("mean NaN", |p| p.mean[0] = f32::NAN),
            ("basis cut", |p| p.basis.truncate(p.basis.len() - 1)),
            ("basis scaled", |p| p.basis.iter_mut().for_each(|v| *v *= 1.01)),
            ("basis infinite", |p| p.basis[5] = f32::INFINITY),
            ("no eigenvalues", |p| p.eigenvalues.clear()),
            ("eigenvalues swapped", |p| p.eigenvalues.swap(0, 1)),
            ("eigenvalue negative", |p| p.eigenvalues[7] = -1.0),
            ("variance NaN", |p| p.total_variance = f64::NAN),
            ("eigenpoints cut", |p| p.eigenpoints.truncate(p.eigenpoints.len() - 1)),
            ("eigenpoint huge", |p| p.eigenpoints[0] = 3e38),
            ("points cut", |p| p.points.truncate(p.points.len() - 1)),
            ("owner out of range", |p| *p.owner.last_mut().unwrap() = 4),
            ("owners swapped", |p| p.owner.reverse()),
            ("no owners", |p| p.owner.clear()),
        ];
        for (what, damage) in damages {
            let mut parts = parts();
            damage(&mut parts);
            assert!(Landmarks::from_parts(parts).is_err(), "{what} went through");
        }
    }
}
