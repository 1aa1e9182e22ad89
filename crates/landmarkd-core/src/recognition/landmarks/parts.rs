//! A trained database as plain vectors, and back: what an artifact file holds.
//!
//! The vectors may come from anywhere: every length, index, order and number is checked.

use std::sync::Arc;

use thiserror::Error;

use super::confidence::Confidence;
use super::description::{Describer, Window};
use super::edge_template::EdgePoint;
use super::model::{Exemplar, Landmarks, PlainWindows, TrainedWindow, Windows};
use super::multiscale::description::{MOST_LEVELS, ScaleSpaceDescriber};
use super::multiscale::encoded_exemplars::{EncodedExemplars, Encoding, window_length};
use super::multiscale::encoded_windows::EncodedWindows;
use super::multiscale::phase_space::{BASIS_LENGTH, PhaseSpace};
use super::multiscale::vlad::{DESCRIPTOR_LENGTH, Vlad};
use super::multiscale::window_space::{MOST_FITTED, unit_px};
use super::options::{Colour, LandmarkOptions, Signature};
use super::position_prior::{row_length, with_positions, without_positions};
use crate::eigen::{Codebook, EigenError, EigenpointIndex, Eigenspace, lists_for};
use crate::recognition::OptionFault;
use crate::vision::InterestPoint;
use crate::vision::gradient_signature::SPECTRUM_LENGTH;

/// Bound of every number of a trained database: signatures have lengths about 1, and pictures fewer pixels a side.
/// Squares and sums of such numbers stay finite.
const LARGEST: f32 = 1e6;
/// Edge points of an exemplar at most.
const MOST_EDGES: usize = 4096;

/// A trained landmark database as plain vectors.
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
    /// `None` before calibration.
    pub confidence: Option<Confidence>,
    /// The windows of all exemplars.
    pub windows: WindowParts,
}

/// The windows of a database.
#[derive(Clone, Debug, PartialEq)]
pub enum WindowParts {
    /// With all that was computed of each: signatures of intensities, and gradients as releases before 0.2 kept them.
    Plain(PlainParts),
    /// Signatures of gradients.
    Encoded(EncodedParts),
}

/// Windows with all that was computed of them. n is their number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlainParts {
    /// n × dimension, row-major, exemplar by exemplar.
    pub eigenpoints: Vec<f32>,
    /// n × 3: x, y, salience of the interest point of each eigenpoint.
    pub points: Vec<f32>,
    /// n: index into the options' radii of the window of each eigenpoint; with gradient signatures its level.
    pub radius: Vec<u8>,
    /// n × rings × 24, with gradient signatures n × rings × 108, if the options ask for spectra, else empty.
    pub spectra: Vec<i8>,
    /// n: index of the exemplar of each eigenpoint, ascending.
    pub owner: Vec<u32>,
}

/// Windows in lists.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedParts {
    /// Lists × dimension, row-major.
    pub centroids: Vec<f32>,
    /// What a code of 1 is worth in each coordinate.
    pub steps: Vec<f32>,
    /// 56 directions × 2 × 36: real and imaginary parts of the channels, frequency by frequency.
    pub phase_basis: Vec<f32>,
    /// 64 centroids at most × dimension, row-major, of eigenpoints times λ^-¼ of each direction.
    pub vlad_centroids: Vec<f32>,
    /// Of each exemplar 256 bytes.
    pub descriptors: Vec<u8>,
    /// A row a window, exemplar by exemplar; `None`: they are elsewhere.
    pub rows: Option<Vec<u8>>,
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
    /// The lists are not those of the exemplars' windows, each once.
    #[error("the windows in lists are not those of the exemplars")]
    Lists,
    /// Signatures of intensities in lists.
    #[error("signatures of intensities are not kept in lists")]
    Signature,
}

impl From<&Landmarks> for LandmarkParts {
    fn from(model: &Landmarks) -> LandmarkParts {
        let eigenspace = model.eigenspace.clone();
        LandmarkParts {
            options: model.options.clone(),
            exemplars: model.exemplars.clone(),
            mean: eigenspace.mean,
            basis: eigenspace.basis,
            eigenvalues: eigenspace.eigenvalues,
            total_variance: eigenspace.total_variance,
            confidence: model.confidence,
            windows: match &model.windows {
                Windows::Plain(plain) => WindowParts::Plain(plain_parts(model, plain)),
                Windows::Encoded(windows) => encoded_parts(&windows.exemplars, Some(windows.rows())),
                Windows::Elsewhere(exemplars) => encoded_parts(exemplars, None),
            },
        }
    }
}

fn encoded_parts(exemplars: &EncodedExemplars, rows: Option<Vec<u8>>) -> WindowParts {
    let EncodedExemplars { encoding: Encoding { codebook, phases, vlad }, descriptors, .. } = exemplars;
    WindowParts::Encoded(EncodedParts {
        centroids: codebook.centroids().to_vec(),
        steps: codebook.steps().to_vec(),
        phase_basis: phases.basis().to_vec(),
        vlad_centroids: vlad.centroids().to_vec(),
        descriptors: descriptors.as_flattened().to_vec(),
        rows,
    })
}

fn plain_parts(model: &Landmarks, plain: &PlainWindows) -> PlainParts {
    let (points, prior) = (plain.index.points(), model.options.position_prior_px);
    PlainParts {
        eigenpoints: without_positions(points, model.dimension(), prior),
        points: plain.windows.iter().flat_map(|trained| coordinates(&trained.window.point)).collect(),
        radius: plain.windows.iter().map(|trained| trained.window.radius).collect(),
        spectra: plain.spectra.clone(),
        owner: plain.windows.iter().map(|trained| trained.exemplar).collect(),
    }
}

impl TryFrom<LandmarkParts> for Landmarks {
    type Error = PartsError;

    /// Rebuilds a database from plain vectors that may hold anything.
    fn try_from(parts: LandmarkParts) -> Result<Landmarks, PartsError> {
        parts.check_options()?;
        parts.check_eigenspace()?;
        parts.check_exemplars()?;
        let LandmarkParts { options, exemplars, mean, basis, eigenvalues, total_variance, .. } = parts;
        let eigenspace = Eigenspace { mean, basis, eigenvalues, total_variance };
        eigenspace.check_basis().map_err(PartsError::Eigenspace)?;
        let dimension = eigenspace.dimension();
        let windows = match (parts.windows, options.signature) {
            (WindowParts::Plain(plain), signature) => {
                plain.check(&options, &exemplars, dimension)?;
                match signature {
                    Signature::Intensity => Windows::Plain(plain.assemble(&options, dimension)),
                    Signature::Gradient => {
                        let encoded = plain.encoded(&options, &exemplars, &eigenspace.eigenvalues)?;
                        encoded.assemble(&options, &exemplars, &eigenspace.eigenvalues)?
                    }
                }
            }
            (WindowParts::Encoded(encoded), Signature::Gradient) => {
                encoded.assemble(&options, &exemplars, &eigenspace.eigenvalues)?
            }
            (WindowParts::Encoded(_), Signature::Intensity) => return Err(PartsError::Signature),
        };
        Ok(Landmarks::assemble(options, exemplars, eigenspace, windows, parts.confidence))
    }
}

/// x, y and salience.
pub(super) fn coordinates(point: &InterestPoint) -> [f32; 3] {
    [point.x_px, point.y_px, point.salience]
}

impl LandmarkParts {
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

    fn check_eigenspace(&self) -> Result<(), PartsError> {
        let dimension = self.eigenvalues.len();
        if dimension == 0 {
            return Err(PartsError::Empty("eigenvalues"));
        }
        let signature = self.options.signature_length();
        check_lengths([
            ("eigenvalues", dimension.min(self.options.dimension), dimension),
            ("mean", signature, self.mean.len()),
            ("basis", dimension * signature, self.basis.len()),
        ])?;
        let variance = |v: &f64| (0.0..=f64::from(LARGEST)).contains(v);
        let confidence = |c: &Confidence| {
            c.weights.iter().all(variance)
                && c.bias.abs() <= f64::from(LARGEST)
                && (0.0..=1.0).contains(&c.threshold)
        };
        check_numbers([
            ("confidence", self.confidence.iter().all(confidence)),
            ("mean", small(&self.mean)),
            ("basis", small(&self.basis)),
            ("eigenvalues", self.eigenvalues.iter().all(variance)),
            ("total_variance", variance(&self.total_variance) && self.total_variance > 0.0),
        ])
    }

    fn check_exemplars(&self) -> Result<(), PartsError> {
        if self.exemplars.is_empty() {
            return Err(PartsError::Empty("exemplars"));
        }
        let edge = |p: &EdgePoint| small(&[p.x_px, p.y_px, p.gradient_x, p.gradient_y]);
        check_numbers([("contours", self.exemplars.iter().flat_map(|e| &e.edges).all(edge))])?;
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
        let fits =
            |e: &Exemplar| e.width_px.max(e.height_px) as f32 <= LARGEST && e.edges.len() <= MOST_EDGES;
        if !self.exemplars.iter().all(fits) {
            return Err(PartsError::Number("exemplars"));
        }
        let negatives = self.exemplars.iter().filter(|e| e.is_negative()).count();
        if negatives == self.exemplars.len() || negatives > 0 && self.options.signature != Signature::Gradient
        {
            return Err(PartsError::NegativeExemplars);
        }
        Ok(())
    }
}

impl PlainParts {
    fn check(
        &self,
        options: &LandmarkOptions,
        exemplars: &[Exemplar],
        dimension: usize,
    ) -> Result<(), PartsError> {
        let points = self.owner.len();
        if points == 0 {
            return Err(PartsError::Empty("owner"));
        }
        check_lengths([
            ("eigenpoints", points.saturating_mul(dimension), self.eigenpoints.len()),
            ("points", points.saturating_mul(3), self.points.len()),
            ("radius", points, self.radius.len()),
            ("spectra", points.saturating_mul(options.spectrum_length()), self.spectra.len()),
        ])?;
        let radii = match options.signature {
            Signature::Gradient => MOST_LEVELS,
            Signature::Intensity => options.subwindow_radii_px.len(),
        };
        check_numbers([
            ("radius", self.radius.iter().all(|&radius| usize::from(radius) < radii)),
            ("eigenpoints", small(&self.eigenpoints)),
            ("points", small(&self.points)),
        ])?;
        self.check_owners(exemplars)
    }

    /// Checks that owners ascend, and are of each exemplar as many as it has windows.
    fn check_owners(&self, exemplars: &[Exemplar]) -> Result<(), PartsError> {
        if !self.owner.is_sorted() {
            return Err(PartsError::Order("owner"));
        }
        let mut rest = &self.owner[..];
        for (exemplar, e) in exemplars.iter().enumerate() {
            let own = rest.partition_point(|&owner| owner as usize <= exemplar);
            if own != e.windows {
                return Err(PartsError::Count(exemplar));
            }
            rest = &rest[own..];
        }
        if rest.is_empty() { Ok(()) } else { Err(PartsError::Count(exemplars.len())) }
    }

    /// The windows of parts that are sound.
    pub(super) fn assemble(self, options: &LandmarkOptions, dimension: usize) -> PlainWindows {
        let rows = self.points.as_chunks().0.iter().zip(self.radius).zip(self.owner);
        let windows = rows.map(|((&[x_px, y_px, salience], radius), exemplar)| TrainedWindow {
            window: Window { point: InterestPoint { x_px, y_px, salience }, radius },
            exemplar,
        });
        let windows: Vec<TrainedWindow> = windows.collect();
        let prior = options.position_prior_px;
        let positions = windows.iter().map(|trained| trained.window);
        let eigenpoints = with_positions(self.eigenpoints, dimension, positions, prior);
        PlainWindows {
            index: EigenpointIndex::new(eigenpoints, row_length(dimension, prior)),
            windows,
            spectrum_lengths: spectrum_lengths(&self.spectra, options),
            spectra: self.spectra,
        }
    }

    /// The windows of parts that are sound and have gradients, in lists.
    fn encoded(
        &self,
        options: &LandmarkOptions,
        exemplars: &[Exemplar],
        eigenvalues: &[f64],
    ) -> Result<EncodedParts, PartsError> {
        let dimension = eigenvalues.len();
        let codebook = Codebook::fit(&self.eigenpoints, dimension, lists_for(self.owner.len()));
        let stride = self.owner.len().div_ceil(MOST_FITTED);
        let spectra = self.spectra.chunks_exact(SPECTRUM_LENGTH).step_by(stride).flatten();
        let phases = PhaseSpace::fit(&spectra.copied().collect::<Vec<i8>>()).ok_or(PartsError::Lists)?;
        let vlad = Vlad::fit(&self.eigenpoints, eigenvalues);
        let place = |((&[x_px, y_px, _], &owner), &level): ((&[f32; 3], &u32), &u8)| {
            let unit_px = unit_px(exemplars[owner as usize].working_size_px(options));
            ([x_px, y_px].map(|at| (at / unit_px).round() as u16), level)
        };
        let windows = self.points.as_chunks().0.iter().zip(&self.owner).zip(&self.radius).map(place);
        let mut left = &self.eigenpoints[..];
        let descriptor = |exemplar: &Exemplar| {
            let (own, others) = left.split_at(exemplar.windows * dimension);
            left = others;
            vlad.descriptor(own)
        };
        let descriptors = exemplars.iter().flat_map(descriptor).collect();
        let (codebook, phases, vlad) = (Arc::new(codebook), Arc::new(phases), Arc::new(vlad));
        let encoding = Encoding { codebook, phases, vlad };
        Ok(EncodedParts {
            centroids: encoding.codebook.centroids().to_vec(),
            steps: encoding.codebook.steps().to_vec(),
            phase_basis: encoding.phases.basis().to_vec(),
            vlad_centroids: encoding.vlad.centroids().to_vec(),
            descriptors,
            rows: Some(encoding.rows(&self.eigenpoints, windows, &self.spectra)),
        })
    }
}

impl EncodedParts {
    /// Bytes of a window's row, with eigenpoints of so many coordinates.
    pub fn row_length(dimension: usize) -> usize {
        window_length(dimension)
    }

    fn assemble(
        self,
        options: &LandmarkOptions,
        exemplars: &[Exemplar],
        eigenvalues: &[f64],
    ) -> Result<Windows, PartsError> {
        check_lengths([
            ("steps", eigenvalues.len(), self.steps.len()),
            ("phase_basis", BASIS_LENGTH, self.phase_basis.len()),
            ("descriptors", exemplars.len() * DESCRIPTOR_LENGTH, self.descriptors.len()),
        ])?;
        check_numbers([
            ("steps", small(&self.steps) && self.steps.iter().all(|step| *step > 0.0)),
            ("phase_basis", small(&self.phase_basis)),
            ("centroids", small(&self.centroids)),
            ("vlad_centroids", small(&self.vlad_centroids)),
        ])?;
        let codebook = Codebook::of_parts(self.centroids, self.steps).ok_or(PartsError::Lists)?;
        let phases = PhaseSpace::of_basis(self.phase_basis).ok_or(PartsError::Lists)?;
        let vlad = Vlad::of_centroids(self.vlad_centroids, eigenvalues).ok_or(PartsError::Lists)?;
        let (codebook, phases, vlad) = (Arc::new(codebook), Arc::new(phases), Arc::new(vlad));
        let encoded = EncodedExemplars {
            describer: Arc::new(ScaleSpaceDescriber::new(options)),
            encoding: Encoding { codebook, phases, vlad },
            descriptors: self.descriptors.as_chunks().0.to_vec(),
        };
        Ok(match self.rows {
            None => Windows::Elsewhere(encoded.into()),
            Some(rows) => {
                let windows = EncodedWindows::of_rows(encoded, &rows, exemplars).ok_or(PartsError::Lists)?;
                Windows::Encoded(windows.into())
            }
        })
    }
}

fn check_lengths<const N: usize>(lengths: [(&'static str, usize, usize); N]) -> Result<(), PartsError> {
    match lengths.into_iter().find(|(_, expected, found)| expected != found) {
        Some((part, expected, found)) => Err(PartsError::Length { part, expected, found }),
        None => Ok(()),
    }
}

fn check_numbers<const N: usize>(sound: [(&'static str, bool); N]) -> Result<(), PartsError> {
    first_false(&sound).map_or(Ok(()), |part| Err(PartsError::Number(part)))
}

fn small(values: &[f32]) -> bool {
    values.iter().all(|v| v.abs() <= LARGEST)
}

fn first_false(checks: &[(&'static str, bool)]) -> Option<&'static str> {
    checks.iter().find(|(_, sound)| !sound).map(|(part, _)| *part)
}

/// The norm of every kept spectrum.
fn spectrum_lengths(spectra: &[i8], options: &LandmarkOptions) -> Vec<f32> {
    let describer = Describer::new(options);
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

    fn cut<T>(values: &mut Vec<T>) {
        values.truncate(values.len() - 1);
    }

    fn plain(parts: &mut LandmarkParts) -> &mut PlainParts {
        match &mut parts.windows {
            WindowParts::Plain(plain) => plain,
            WindowParts::Encoded(_) => panic!("signatures of intensities"),
        }
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
            |p| cut(&mut plain(p).spectra),
            |p| plain(p).spectra.clear(),
            |p| plain(p).radius[0] = 2,
            |p| cut(&mut plain(p).radius),
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
            ("mean cut", |p| cut(&mut p.mean)),
            ("mean NaN", |p| p.mean[0] = f32::NAN),
            ("basis cut", |p| cut(&mut p.basis)),
            ("basis scaled", |p| p.basis.iter_mut().for_each(|v| *v *= 1.01)),
            ("basis infinite", |p| p.basis[5] = f32::INFINITY),
            ("no eigenvalues", |p| p.eigenvalues.clear()),
            ("eigenvalues swapped", |p| p.eigenvalues.swap(0, 1)),
            ("eigenvalue negative", |p| p.eigenvalues[7] = -1.0),
            ("variance NaN", |p| p.total_variance = f64::NAN),
            ("eigenpoints cut", |p| cut(&mut plain(p).eigenpoints)),
            ("eigenpoint huge", |p| plain(p).eigenpoints[0] = 3e38),
            ("points cut", |p| cut(&mut plain(p).points)),
            ("owner out of range", |p| *plain(p).owner.last_mut().unwrap() = 4),
            ("owners swapped", |p| plain(p).owner.reverse()),
            ("no owners", |p| plain(p).owner.clear()),
        ];
        for (what, damage) in damages {
            let mut parts = parts();
            damage(&mut parts);
            assert!(Landmarks::try_from(parts).is_err(), "{what} went through");
        }
    }
}
