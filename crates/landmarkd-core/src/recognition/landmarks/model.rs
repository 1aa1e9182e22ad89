//! A trained landmark database: an immutable value that recognises frames.

use std::sync::Arc;

use super::confidence::{CalibrationSample, Confidence, Reliability};
use super::description::{Describer, ExemplarName, Window};
use super::edge_template::EdgePoint;
use super::held_out::CalibrationPlan;
use super::multiscale::encoded_exemplars::EncodedExemplars;
use super::multiscale::encoded_windows::EncodedWindows;
use super::options::LandmarkOptions;
use super::recognise::recognise;
use super::recognition::{Recognition, Stage};
use crate::eigen::{EigenpointIndex, Eigenspace};
use crate::imaging::Frame;

/// One training image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exemplar {
    /// Its own name, unique in the database.
    pub id: String,
    /// The class or place that it shows; empty for a negative exemplar, which shows nothing known. Gradient signatures only.
    pub label: String,
    /// Width of its picture.
    pub width_px: u32,
    /// Height of its picture.
    pub height_px: u32,
    /// Number of its windows and eigenpoints.
    pub windows: usize,
    /// Points of its edge template; none if the method verifies no placements.
    pub edges: Vec<EdgePoint>,
}

impl Exemplar {
    /// What exemplars are sorted by.
    pub(super) fn sort_key(&self) -> (&str, &str) {
        (&self.label, &self.id)
    }

    /// Whether it shows nothing known: what looks like it is background.
    pub fn is_negative(&self) -> bool {
        self.label.is_empty()
    }

    /// Width and height of its picture at the working size.
    pub(super) fn working_size_px(&self, options: &LandmarkOptions) -> [f32; 2] {
        let reduction = options.reduction_of(self.width_px, self.height_px);
        [self.width_px, self.height_px].map(|side| (side as f32 / reduction).round())
    }

    /// Id and label.
    pub fn name(&self) -> ExemplarName {
        ExemplarName { id: self.id.clone(), label: self.label.clone() }
    }
}

/// A window of an exemplar, from which an eigenpoint was computed.
#[derive(Clone, Copy)]
pub(super) struct TrainedWindow {
    pub window: Window,
    /// Index of its exemplar.
    pub exemplar: u32,
}

/// The windows of all exemplars, by the kind of their signatures.
pub(super) enum Windows {
    /// With signatures of intensities.
    Plain(PlainWindows),
    /// With signatures of gradients.
    Encoded(Box<EncodedWindows>),
    /// The same, where their exemplars are known and they are not here.
    Elsewhere(Box<EncodedExemplars>),
}

/// Windows with all that was computed of them.
pub(super) struct PlainWindows {
    pub index: EigenpointIndex,
    /// In the order of the eigenpoints; exemplars ascend.
    pub windows: Vec<TrainedWindow>,
    /// A row an eigenpoint if the method verifies placements, else empty.
    pub spectra: Vec<i8>,
    /// Norm of each row of `spectra`.
    pub spectrum_lengths: Vec<f32>,
}

impl PlainWindows {
    fn bytes(&self) -> usize {
        self.index.bytes()
            + size_of_val(&self.windows[..])
            + size_of_val(&self.spectra[..])
            + size_of_val(&self.spectrum_lengths[..])
    }
}

impl Windows {
    /// The exemplars of gradient signatures.
    pub fn encoded(&self) -> Option<&EncodedExemplars> {
        match self {
            Windows::Plain(_) => None,
            Windows::Encoded(windows) => Some(&windows.exemplars),
            Windows::Elsewhere(exemplars) => Some(exemplars),
        }
    }

    /// How many are here.
    pub fn count(&self) -> usize {
        match self {
            Windows::Plain(plain) => plain.windows.len(),
            Windows::Encoded(windows) => windows.index().count(),
            Windows::Elsewhere(_) => 0,
        }
    }

    /// The index of a window's exemplar.
    ///
    /// # Panics
    /// If the window is not here.
    pub fn exemplar(&self, window: usize) -> usize {
        match self {
            Windows::Plain(plain) => plain.windows[window].exemplar as usize,
            Windows::Encoded(windows) => windows.exemplar(window),
            Windows::Elsewhere(_) => panic!("window {window} is elsewhere"),
        }
    }

    /// Memory that they take, in bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Windows::Plain(plain) => plain.bytes(),
            Windows::Encoded(windows) => windows.bytes(),
            Windows::Elsewhere(exemplars) => exemplars.bytes(),
        }
    }
}

/// A trained landmark database.
pub struct Landmarks {
    /// The colour is resolved, never `Auto`.
    pub(super) options: LandmarkOptions,
    pub(super) describer: Arc<Describer>,
    /// Sorted by label, then id.
    pub(super) exemplars: Vec<Exemplar>,
    pub(super) eigenspace: Eigenspace,
    pub(super) windows: Windows,
    /// Exemplars of the database that these are chosen from: so many may agree with a frame by accident.
    pub(super) chosen_from: usize,
    /// `None` before calibration.
    pub(super) confidence: Option<Confidence>,
}

impl Landmarks {
    /// The database of parts that are sound.
    pub(super) fn assemble(
        options: LandmarkOptions,
        exemplars: Vec<Exemplar>,
        eigenspace: Eigenspace,
        windows: Windows,
        confidence: Option<Confidence>,
    ) -> Landmarks {
        let describer = Arc::new(Describer::new(&options));
        let chosen_from = exemplars.len();
        Landmarks { options, describer, exemplars, eigenspace, windows, chosen_from, confidence }
    }

    /// The training images, sorted by label, then id.
    pub fn exemplars(&self) -> &[Exemplar] {
        &self.exemplars
    }

    /// Ids and labels of the exemplars, in their order.
    pub fn names(&self) -> Vec<ExemplarName> {
        self.exemplars.iter().map(Exemplar::name).collect()
    }

    /// The different labels, ascending.
    pub fn labels(&self) -> Vec<&str> {
        let labelled = self.exemplars.iter().filter(|exemplar| !exemplar.is_negative());
        let mut labels: Vec<&str> = labelled.map(|e| e.label.as_str()).collect();
        labels.dedup();
        labels
    }

    /// The indices of the exemplars that have a label, ascending.
    pub(super) fn labelled(&self) -> Vec<usize> {
        (0..self.exemplars.len()).filter(|&index| !self.exemplars[index].is_negative()).collect()
    }

    /// The options it was trained with, the colour resolved.
    pub fn options(&self) -> &LandmarkOptions {
        &self.options
    }

    /// The curve from evidence to probability; `None` before calibration.
    pub fn confidence(&self) -> Option<&Confidence> {
        self.confidence.as_ref()
    }

    /// Coordinates of an eigenpoint: as many as the options ask for, or as the signatures span.
    pub fn dimension(&self) -> usize {
        self.eigenspace.dimension()
    }

    /// Width and height of an exemplar's picture at the working size.
    pub fn working_size_px(&self, exemplar: usize) -> [f32; 2] {
        self.exemplars[exemplar].working_size_px(&self.options)
    }

    /// Recognises a frame. Calls `finished` after each stage, some of them several times: the caller holds the clock.
    ///
    /// The decision is `None` if its probability of being right is below the database's threshold. A database that
    /// isn't calibrated has no threshold and always decides for the best vote.
    ///
    /// # Panics
    /// If its windows are elsewhere ([`Landmarks::has_windows`]).
    pub fn recognise(&self, frame: &Frame, finished: impl FnMut(Stage)) -> Recognition {
        recognise(self, None, frame, finished)
    }

    /// Fits the confidence to samples of a [`CalibrationPlan`]: round by round, in each round in the order of its
    /// exemplars. Changes nothing and returns `None` if there are too few samples, or only right or only wrong ones.
    pub fn calibrate(&mut self, samples: &[CalibrationSample]) -> Option<Reliability> {
        let exemplars = CalibrationPlan::of(self).exemplars.len();
        let (confidence, reliability) = Confidence::fit(samples, exemplars)?;
        self.confidence = Some(confidence);
        Some(reliability)
    }

    /// Memory that it takes, without the allocator's overhead.
    pub fn bytes(&self) -> usize {
        let exemplar =
            |e: &Exemplar| size_of::<Exemplar>() + e.id.len() + e.label.len() + size_of_val(&e.edges[..]);
        size_of::<Landmarks>()
            + self.exemplars.iter().map(exemplar).sum::<usize>()
            + size_of_val(&self.eigenspace.mean[..])
            + size_of_val(&self.eigenspace.basis[..])
            + size_of_val(&self.eigenspace.eigenvalues[..])
            + self.windows.bytes()
    }
}
