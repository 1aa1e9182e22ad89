//! What the windows of a database are measured in: the eigenspace of their signatures (A§4.1), the codebook of their
//! eigenpoints, the directions of their phases. It is fitted to a sample; then exemplars are taken one by one, and what is kept
//! of each is small.

use std::sync::Arc;

use super::encoded_exemplars::Encoding;
use super::phase_space::PhaseSpace;
use super::vlad::{Descriptor, Vlad};
use crate::eigen::{Codebook, Eigenspace, lists_for};
use crate::recognition::landmarks::description::{DescribedExemplar, Window};
use crate::recognition::landmarks::model::{Exemplar, Landmarks};
use crate::recognition::landmarks::options::{Colour, LandmarkOptions};
use crate::recognition::landmarks::training::TrainingError;
use crate::vision::gradient_signature::SPECTRUM_LENGTH;

/// Exemplars that are sampled at most.
const MOST_EXEMPLARS: usize = 1024;
/// Windows that are sampled at most, 2 kB of each, of up to so many exemplars; of more exemplars as many times more as the
/// root of their number is larger, as lists are.
const MOST_WINDOWS: f64 = 65_536.0;
const FEW_EXEMPLARS: f64 = 1000.0;
/// Signatures that the eigenspace is fitted to at most, and spectra that the directions of phases are.
pub(in super::super) const MOST_FITTED: usize = 30_000;

/// The exemplars to sample, of so many: their indices, ascending, and the windows to take from each at most.
pub fn sample_plan(exemplars: usize) -> (Vec<usize>, usize) {
    let chosen = exemplars.min(MOST_EXEMPLARS);
    let windows = MOST_WINDOWS * (exemplars as f64 / FEW_EXEMPLARS).sqrt().max(1.0);
    ((0..chosen).map(|i| i * exemplars / chosen).collect(), windows as usize / chosen.max(1))
}

/// Evenly chosen windows of an exemplar.
#[derive(Clone, Debug)]
pub struct WindowSample {
    /// All windows of the exemplar.
    windows: usize,
    colour: bool,
    signatures: Vec<f32>,
    spectra: Vec<i8>,
}

impl WindowSample {
    /// Windows that were taken.
    fn rows(&self) -> usize {
        self.spectra.len() / SPECTRUM_LENGTH
    }

    /// At most so many windows of a described exemplar.
    pub fn of(described: &DescribedExemplar, most: usize) -> WindowSample {
        let windows = described.windows.len();
        let chosen = windows.min(most);
        let length = described.signatures.len().checked_div(windows).unwrap_or(0);
        let rows = || (0..chosen).map(|i| i * windows / chosen);
        let signature = |row: usize| &described.signatures[row * length..][..length];
        let spectrum = |row: usize| &described.spectra[row * SPECTRUM_LENGTH..][..SPECTRUM_LENGTH];
        WindowSample {
            windows,
            colour: described.colour,
            signatures: rows().flat_map(signature).copied().collect(),
            spectra: rows().flat_map(spectrum).copied().collect(),
        }
    }
}

/// The space of the windows of a database with gradient signatures.
pub struct WindowSpace {
    /// The colour is resolved.
    pub(in super::super) options: LandmarkOptions,
    pub(in super::super) eigenspace: Eigenspace,
    /// Variances along its directions, descending; along all when it was fitted just now.
    pub(in super::super) spectrum: Vec<f64>,
    pub(in super::super) encoding: Encoding,
}

/// What is kept of an exemplar.
#[derive(Clone, Debug)]
pub struct EncodedExemplar {
    /// Name, size and edge points.
    pub exemplar: Exemplar,
    /// The rows of its windows.
    pub(in super::super) rows: Vec<u8>,
    pub(in super::super) descriptor: Descriptor,
    /// Squared length of its signatures, less the mean: of all, and of what the eigenspace doesn't hold.
    pub(in super::super) energy: [f64; 2],
}

impl WindowSpace {
    /// The space of samples of exemplars, for a database of `exemplars`.
    ///
    /// # Errors
    /// No window in the samples; signatures that don't vary, or are of other options.
    pub fn fit(
        samples: Vec<WindowSample>,
        exemplars: usize,
        options: &LandmarkOptions,
    ) -> Result<WindowSpace, TrainingError> {
        let resolved = options.with_colour(samples.iter().all(|sample| sample.colour));
        let length = resolved.signature_length();
        let (sampled, windows) = (samples.len(), samples.iter().map(|sample| sample.windows).sum::<usize>());
        let rows_of_all: usize = samples.iter().map(WindowSample::rows).sum();
        let stride = rows_of_all.div_ceil(MOST_FITTED).max(1);
        let spectra = samples.iter().flat_map(|sample| sample.spectra.chunks_exact(SPECTRUM_LENGTH));
        let spectra: Vec<i8> = spectra.step_by(stride).flatten().copied().collect();
        let mut signatures = Vec::with_capacity(rows_of_all * length);
        for sample in samples {
            signatures.extend(rows(&sample, length));
        }
        if signatures.is_empty() {
            return Err(TrainingError::NoInterestPoints);
        }
        let phases = PhaseSpace::fit(&spectra).ok_or(TrainingError::NoInterestPoints)?;
        let fitted: Vec<f32> = signatures.chunks_exact(length).step_by(stride).flatten().copied().collect();
        let (eigenspace, spectrum) = Eigenspace::fit(&fitted, length, options.dimension) // A§4.1
            .map_err(TrainingError::Eigenspace)?;
        drop(fitted);
        let points = eigenspace.project(&signatures);
        drop(signatures);
        let expected = windows * exemplars / sampled;
        let codebook = Codebook::fit(&points, eigenspace.dimension(), lists_for(expected));
        let vlad = Vlad::fit(&points, &eigenspace.eigenvalues);
        let encoding =
            Encoding { codebook: Arc::new(codebook), phases: Arc::new(phases), vlad: Arc::new(vlad) };
        Ok(WindowSpace { options: resolved, eigenspace, spectrum, encoding })
    }

    /// The space of a database; `None` if it has signatures of intensities.
    pub fn of(model: &Landmarks) -> Option<WindowSpace> {
        Some(WindowSpace {
            options: model.options.clone(),
            spectrum: model.eigenspace.eigenvalues.clone(),
            eigenspace: model.eigenspace.clone(),
            encoding: model.windows.encoded()?.encoding.clone(),
        })
    }

    /// The part of the variance that its directions don't hold, when it was fitted.
    pub fn residual(&self) -> f64 {
        1.0 - self.eigenspace.eigenvalues.iter().sum::<f64>() / self.eigenspace.total_variance
    }

    /// What is kept of an exemplar.
    ///
    /// # Errors
    /// It has no colour, and the space has.
    pub fn encode(&self, described: DescribedExemplar) -> Result<EncodedExemplar, TrainingError> {
        if self.options.colour == Colour::Opponent && !described.colour {
            return Err(TrainingError::WithoutColour(described.exemplar.id));
        }
        let sample = WindowSample {
            windows: described.windows.len(),
            colour: described.colour,
            signatures: described.signatures,
            spectra: described.spectra,
        };
        let signatures: Vec<f32> = rows(&sample, self.options.signature_length()).copied().collect();
        let points = self.eigenspace.project(&signatures);
        let square =
            |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>();
        let mean = self.eigenspace.mean.iter().cycle();
        let all = square(&mut signatures.iter().zip(mean).map(|(value, mean)| value - mean));
        let held = square(&mut points.iter().copied());
        let unit_px = unit_px(described.exemplar.working_size_px(&self.options));
        let place = |window: &Window| {
            let Window { point, radius } = window;
            ([point.x_px, point.y_px].map(|at| (at / unit_px).round() as u16), *radius)
        };
        Ok(EncodedExemplar {
            rows: self.encoding.rows(&points, described.windows.iter().map(place), &sample.spectra),
            descriptor: self.encoding.vlad.descriptor(&points),
            exemplar: described.exemplar,
            energy: [all, (all - held).max(0.0)],
        })
    }
}

/// The part of the energy of exemplars' signatures that the directions of their space don't hold: beside
/// [`WindowSpace::residual`] it tells whether the space fits them. 0 of none.
pub fn residual_of(encoded: &[EncodedExemplar]) -> f64 {
    let sum = |at: usize| encoded.iter().map(|exemplar| exemplar.energy[at]).sum::<f64>();
    if sum(0) > 0.0 { sum(1) / sum(0) } else { 0.0 }
}

/// What 1 is worth in the positions of an exemplar's windows, given the exemplar's size: 0.01 px where the longer side has 640.
pub(in super::super) fn unit_px([width_px, height_px]: [f32; 2]) -> f32 {
    width_px.max(height_px).max(1.0) / f32::from(u16::MAX)
}

/// The first `length` components of all signatures of a sample. The luminance part comes first: a shorter `length` leaves
/// the colour part out.
fn rows(sample: &WindowSample, length: usize) -> impl Iterator<Item = &f32> {
    let own = sample.signatures.len().checked_div(sample.rows()).unwrap_or(1).max(1);
    sample.signatures.chunks_exact(own).flat_map(move |row| &row[..length])
}
