//! A trained database as plain vectors, and back: what an artifact file holds.
//!
//! The vectors may come from anywhere: every length, index, order and number is checked.

use thiserror::Error;

use super::confidence::Confidence;
use super::description::{Describer, Window};
use super::edge_template::EdgePoint;
use super::model::{Exemplar, Landmarks, TrainedWindow};
use super::multiscale::description::{MOST_LEVELS, ScaleSpaceDescriber};
use super::options::{Colour, LandmarkOptions, Signature};
use super::position_prior::{row_length, with_positions, without_positions};
use super::search::WindowIndex;
use crate::eigen::{EigenError, Eigenspace};
use crate::recognition::OptionFault;
use crate::vision::InterestPoint;

/// Bound of every number of a trained database: signatures have lengths about 1, and pictures fewer pixels a side.
/// Squares and sums of such numbers stay finite.
const LARGEST: f32 = 1e6;
/// Edge points of an exemplar at most.
const MOST_EDGES: usize = 4096;

/// A trained landmark database as plain vectors. n is the number of eigenpoints.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkParts {
    /// The colour is resolved, never `Auto`.
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
    /// n: index into the options' radii of the window of each eigenpoint; with gradient signatures its level.
    pub radius: Vec<u8>,
    /// n × rings × 24, with gradient signatures n × rings × 108, if the options ask for spectra, else empty.
    pub spectra: Vec<i8>,
    /// `None` before calibration.
    pub confidence: Option<Confidence>,
    /// n: index of the exemplar of each eigenpoint, ascending.
    pub owner: Vec<u32>,
}

/// What is wrong with the parts of a landmark database.
#[derive(Debug, Error, PartialEq)]
pub enum PartsError {
    /// The options are out of range or contradict each other: all that is wrong with them.
    #[error("the options can't be used")]
    Options(Vec<OptionFault>),
    /// The colour is `Auto`.
    #[error("the colour of a trained database is gray or opponent, not auto")]
    ColourUnresolved,
    /// A vector has the wrong length.
    #[error("{part} has {found} values where {expected} belong")]
    Length {
        /// Name of the vector.
        part: &'static str,
        /// Length that the options and the other vectors give.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// The vector of this name is empty.
    #[error("{0} has no values")]
    Empty(&'static str),
    /// A number of the vector of this name is out of range, infinite or NaN.
    #[error("{0} holds a number that is not finite, or too large")]
    Number(&'static str),
    /// The vector of this name isn't sorted, or has equal values where they must differ.
    #[error("{0} are not in their order, or not different")]
    Order(&'static str),
    /// The basis isn't orthonormal.
    #[error("the eigenspace is none")]
    Eigenspace(#[source] EigenError),
    /// Negative exemplars alone, or with other signatures than gradients.
    #[error("negative exemplars stand beside others, and go with gradient signatures")]
    NegativeExemplars,
    /// The exemplar of this index has another number of eigenpoints than it says.
    #[error("the interest points of exemplar {0} are not as many as it says")]
    Count(usize),
}

impl From<&Landmarks> for LandmarkParts {
    fn from(model: &Landmarks) -> LandmarkParts {
        let eigenspace = model.eigenspace.clone();
        let prior = model.options.position_prior_px;
        LandmarkParts {
            options: model.options.clone(),
            exemplars: model.exemplars.clone(),
            mean: eigenspace.mean,
            basis: eigenspace.basis,
            eigenvalues: eigenspace.eigenvalues,
            total_variance: eigenspace.total_variance,
            eigenpoints: without_positions(model.index.points(), model.dimension(), prior),
            points: model.windows.iter().flat_map(|trained| coordinates(&trained.window.point)).collect(),
            radius: model.windows.iter().map(|trained| trained.window.radius).collect(),
            spectra: model.spectra.clone(),
            confidence: model.confidence,
            owner: model.windows.iter().map(|trained| trained.exemplar).collect(),
        }
    }
}

impl TryFrom<LandmarkParts> for Landmarks {
    type Error = PartsError;

    /// Rebuilds a database from plain vectors that may hold anything.
    fn try_from(parts: LandmarkParts) -> Result<Landmarks, PartsError> {
        parts.check_options()?;
        parts.check_lengths()?;
        parts.check_numbers()?;
        parts.check_exemplars()?;
        parts.check_owners()?;
        let model = parts.assemble();
        model.eigenspace.check_basis().map_err(PartsError::Eigenspace)?;
        Ok(model)
    }
}

/// x, y and salience.
pub(super) fn coordinates(point: &InterestPoint) -> [f32; 3] {
    [point.x_px, point.y_px, point.salience]
}

impl LandmarkParts {
    /// The database of parts that are sound.
    pub(super) fn assemble(self) -> Landmarks {
        let LandmarkParts { options, exemplars, mean, basis, eigenvalues, total_variance, .. } = self;
        let eigenspace = Eigenspace { mean, basis, eigenvalues, total_variance };
        let rows = self.points.as_chunks().0.iter().zip(self.radius).zip(self.owner);
        let windows = rows.map(|((&[x_px, y_px, salience], radius), exemplar)| TrainedWindow {
            window: Window { point: InterestPoint { x_px, y_px, salience }, radius },
            exemplar,
        });
        let windows: Vec<TrainedWindow> = windows.collect();
        let (dimension, prior) = (eigenspace.dimension(), options.position_prior_px);
        let positions = windows.iter().map(|trained| trained.window);
        let eigenpoints = with_positions(self.eigenpoints, dimension, positions, prior);
        let describer = Describer::new(&options);
        let signature = options.signature;
        let scale_space =
            (options.signature == Signature::Gradient).then(|| ScaleSpaceDescriber::new(&options));
        Landmarks {
            spectrum_lengths: spectrum_lengths(&self.spectra, &describer),
            describer,
            scale_space,
            options,
            exemplars,
            eigenspace,
            index: WindowIndex::new(eigenpoints, row_length(dimension, prior), signature),
            windows,
            spectra: self.spectra,
            confidence: self.confidence,
        }
    }

    fn check_options(&self) -> Result<(), PartsError> {
        let faults = self.options.faults();
        if !faults.is_empty() {
            return Err(PartsError::Options(faults));
        }
        if self.options.colour == Colour::Auto {
            return Err(PartsError::ColourUnresolved);
        }
        Ok(())
    }

    fn check_lengths(&self) -> Result<(), PartsError> {
        let (exemplars, dimension, points) = (self.exemplars.len(), self.eigenvalues.len(), self.owner.len());
        for (part, found) in [("exemplars", exemplars), ("eigenvalues", dimension), ("owner", points)] {
            if found == 0 {
                return Err(PartsError::Empty(part));
            }
        }
        let signature = self.options.signature_length();
        let spectrum = self.options.spectrum_length();
        let lengths = [
            ("eigenvalues", dimension.min(self.options.dimension), dimension),
            ("mean", signature, self.mean.len()),
            ("basis", dimension * signature, self.basis.len()),
            ("eigenpoints", points.saturating_mul(dimension), self.eigenpoints.len()),
            ("points", points.saturating_mul(3), self.points.len()),
            ("radius", points, self.radius.len()),
            ("spectra", points.saturating_mul(spectrum), self.spectra.len()),
        ];
        match lengths.into_iter().find(|(_, expected, found)| expected != found) {
            Some((part, expected, found)) => Err(PartsError::Length { part, expected, found }),
            None => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), PartsError> {
        let radii = match self.options.signature {
            Signature::Gradient => MOST_LEVELS,
            Signature::Intensity => self.options.subwindow_radii_px.len(),
        };
        let small = |values: &[f32]| values.iter().all(|v| v.abs() <= LARGEST);
        let variance = |v: &f64| (0.0..=f64::from(LARGEST)).contains(v);
        let edge = |p: &EdgePoint| small(&[p.x_px, p.y_px, p.gradient_x, p.gradient_y]);
        let confidence = |c: &Confidence| {
            c.weights.iter().all(variance)
                && c.bias.abs() <= f64::from(LARGEST)
                && (0.0..=1.0).contains(&c.threshold)
        };
        let sound = [
            ("radius", self.radius.iter().all(|&radius| usize::from(radius) < radii)),
            ("contours", self.exemplars.iter().flat_map(|e| &e.edges).all(edge)),
            ("confidence", self.confidence.iter().all(confidence)),
            ("mean", small(&self.mean)),
            ("basis", small(&self.basis)),
            ("eigenpoints", small(&self.eigenpoints)),
            ("points", small(&self.points)),
            ("eigenvalues", self.eigenvalues.iter().all(variance)),
            ("total_variance", variance(&self.total_variance)),
        ];
        first_false(&sound).map_or(Ok(()), |part| Err(PartsError::Number(part)))
    }

    fn check_exemplars(&self) -> Result<(), PartsError> {
        let mut ids: Vec<&str> = self.exemplars.iter().map(|e| e.id.as_str()).collect();
        ids.sort_unstable();
        let sorted = [
            ("eigenvalues", self.eigenvalues.is_sorted_by(|a, b| a >= b)),
            ("exemplars", self.exemplars.is_sorted_by(|a, b| a.sort_key() < b.sort_key())),
            ("exemplars", ids.is_sorted_by(|a, b| a < b)),
        ];
        if let Some(part) = first_false(&sorted) {
            return Err(PartsError::Order(part));
        }
        let small =
            |e: &Exemplar| e.width_px.max(e.height_px) as f32 <= LARGEST && e.edges.len() <= MOST_EDGES;
        if !self.exemplars.iter().all(small) {
            return Err(PartsError::Number("exemplars"));
        }
        let negatives = self.exemplars.iter().filter(|e| e.is_negative()).count();
        if negatives == self.exemplars.len() || negatives > 0 && self.options.signature != Signature::Gradient
        {
            return Err(PartsError::NegativeExemplars);
        }
        Ok(())
    }

    /// Checks that owners ascend, and are of each exemplar as many as it has windows.
    fn check_owners(&self) -> Result<(), PartsError> {
        if !self.owner.is_sorted() {
            return Err(PartsError::Order("owner"));
        }
        let mut rest = &self.owner[..];
        for (exemplar, e) in self.exemplars.iter().enumerate() {
            let own = rest.partition_point(|&owner| owner as usize <= exemplar);
            if own != e.windows {
                return Err(PartsError::Count(exemplar));
            }
            rest = &rest[own..];
        }
        if rest.is_empty() { Ok(()) } else { Err(PartsError::Count(self.exemplars.len())) }
    }
}

fn first_false(checks: &[(&'static str, bool)]) -> Option<&'static str> {
    checks.iter().find(|(_, sound)| !sound).map(|(part, _)| *part)
}

/// The norm of every kept spectrum.
fn spectrum_lengths(spectra: &[i8], describer: &Describer) -> Vec<f32> {
    let Some(plan) = describer.phase_plan() else { return Vec::new() };
    let length = |row: &[i8]| row.iter().map(|&v| f32::from(v).powi(2)).sum::<f32>().sqrt();
    spectra.chunks_exact(plan.length()).map(length).collect()
}

#[cfg(test)]
mod tests {
    use super::super::options::Viewpoint;
    use super::super::pictures::{described, intensity, paper, toy};
    use super::*;
    use crate::imaging::Frame;

    fn parts() -> LandmarkParts {
        let options = LandmarkOptions { dimension: 8, ..paper() };
        LandmarkParts::from(&Landmarks::train(described(0..4, &options), &options).unwrap().0)
    }

    #[test]
    fn a_rebuilt_database_answers_the_same() {
        let parts = parts();
        let rebuilt = Landmarks::try_from(parts.clone()).unwrap();
        assert_eq!(LandmarkParts::from(&rebuilt), parts);
        let options = LandmarkOptions { dimension: 8, ..paper() };
        let (trained, _) = Landmarks::train(described(0..4, &options), &options).unwrap();
        let frame = Frame::gray(toy(2, 96)).turned(70.0);
        assert_eq!(rebuilt.recognise(&frame, |_| ()), trained.recognise(&frame, |_| ()));
    }

    #[test]
    fn a_rebuilt_placement_database_answers_the_same_and_its_damage_is_refused() {
        let options = intensity(Viewpoint::Free);
        let (mut trained, _) = Landmarks::train(described(0..4, &options), &options).unwrap();
        trained.confidence = Some(Confidence { weights: [2.0, 5.0, 0.0, 1.0], bias: -8.0, threshold: 0.6 });
        let parts = LandmarkParts::from(&trained);
        let rebuilt = Landmarks::try_from(parts.clone()).unwrap();
        assert_eq!(LandmarkParts::from(&rebuilt), parts);
        assert_eq!(rebuilt.bytes(), trained.bytes());
        let frame = Frame::gray(toy(2, 96)).turned(70.0);
        assert_eq!(rebuilt.recognise(&frame, |_| ()), trained.recognise(&frame, |_| ()));
        let damages: [fn(&mut LandmarkParts); 8] = [
            |p| p.spectra.truncate(p.spectra.len() - 1),
            |p| p.spectra.clear(),
            |p| p.radius[0] = 2,
            |p| p.radius.truncate(p.radius.len() - 1),
            |p| p.exemplars[1].edges[0].x_px = f32::NAN,
            |p| p.confidence.as_mut().unwrap().weights[1] = -1.0,
            |p| p.confidence.as_mut().unwrap().bias = f64::NAN,
            |p| p.confidence.as_mut().unwrap().threshold = 1.5,
        ];
        for (number, damage) in damages.into_iter().enumerate() {
            let mut parts = parts.clone();
            damage(&mut parts);
            assert!(Landmarks::try_from(parts).is_err(), "damage {number} went through");
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
            assert!(Landmarks::try_from(parts).is_err(), "{what} went through");
        }
    }
}
