//! A trained landmark database: an immutable value that recognises frames.

use super::confidence::Confidence;
use super::contour::ContourPoint;
use super::description::{Describer, ExemplarName, Window};
use super::options::LandmarkOptions;
use crate::eigen::{EigenpointIndex, Eigenspace};

/// One training image.
#[derive(Clone, Debug, PartialEq)]
pub struct Exemplar {
    /// Its own name, unique in the database.
    pub id: String,
    /// What it shows.
    pub label: String,
    /// Width of its picture.
    pub width_px: u32,
    /// Height of its picture.
    pub height_px: u32,
    /// How many windows it has.
    pub windows: usize,
    /// What of it is laid on frames, if anything.
    pub contour: Vec<ContourPoint>,
}

/// The window that an eigenpoint comes from.
#[derive(Clone, Copy)]
pub(super) struct Owned {
    pub window: Window,
    /// Index of its exemplar.
    pub exemplar: u32,
}

/// A trained landmark database.
pub struct Landmarks {
    /// With the colour that is used, never `Auto`.
    pub(super) options: LandmarkOptions,
    pub(super) describer: Describer,
    /// Sorted by label, then id.
    pub(super) exemplars: Vec<Exemplar>,
    pub(super) eigenspace: Eigenspace,
    pub(super) index: EigenpointIndex,
    /// In the order of the eigenpoints; exemplars ascend.
    pub(super) owned: Vec<Owned>,
    /// A row an eigenpoint, and the length of each, if matches say where exemplars lie.
    pub(super) spectra: Vec<i8>,
    pub(super) spectrum_lengths: Vec<f32>,
    /// How sure answers are, once that was rehearsed.
    pub(super) confidence: Option<Confidence>,
}

impl Landmarks {
    /// The training images, sorted by label, then id.
    pub fn exemplars(&self) -> &[Exemplar] {
        &self.exemplars
    }

    /// What the exemplars are called, in their order.
    pub fn names(&self) -> Vec<ExemplarName> {
        let name = |e: &Exemplar| ExemplarName { id: e.id.clone(), label: e.label.clone() };
        self.exemplars.iter().map(name).collect()
    }

    /// The different labels, ascending.
    pub fn labels(&self) -> Vec<&str> {
        let mut labels: Vec<&str> = self.exemplars.iter().map(|e| e.label.as_str()).collect();
        labels.dedup();
        labels
    }

    /// The options it was trained with, the colour resolved.
    pub fn options(&self) -> &LandmarkOptions {
        &self.options
    }

    /// How sure answers are; `None` if that was never rehearsed.
    pub fn confidence(&self) -> Option<&Confidence> {
        self.confidence.as_ref()
    }

    /// Coordinates of an eigenpoint: as many as asked for, or as there are.
    pub fn dimension(&self) -> usize {
        self.eigenspace.dimension()
    }

    /// Memory held, to within what an allocator adds.
    pub fn bytes(&self) -> usize {
        let exemplar =
            |e: &Exemplar| size_of::<Exemplar>() + e.id.len() + e.label.len() + size_of_val(&e.contour[..]);
        let exemplars: usize = self.exemplars.iter().map(exemplar).sum();
        let spectra = size_of_val(&self.spectra[..]) + size_of_val(&self.spectrum_lengths[..]);
        let space = size_of_val(&self.eigenspace.mean[..])
            + size_of_val(&self.eigenspace.basis[..])
            + size_of_val(&self.eigenspace.eigenvalues[..]);
        size_of::<Landmarks>()
            + exemplars
            + space
            + self.index.bytes()
            + size_of_val(&self.owned[..])
            + spectra
    }
}
