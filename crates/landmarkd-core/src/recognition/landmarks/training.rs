//! Training (A§4.1): the signatures of all exemplars, their eigenspace, and the eigenpoints in it.

use std::sync::Arc;

use thiserror::Error;

use super::confidence::Confidence;
use super::description::DescribedExemplar;
use super::model::{Exemplar, Landmarks, Windows};
use super::multiscale::description::ScaleSpaceDescriber;
use super::multiscale::encoded_exemplars::EncodedExemplars;
use super::multiscale::encoded_windows::EncodedWindows;
use super::multiscale::window_space::{EncodedExemplar, WindowSample, WindowSpace, sample_plan};
use super::options::{Colour, LandmarkOptions, Signature};
use super::parts::{PlainParts, coordinates};
use crate::eigen::{EigenError, Eigenspace};
use crate::recognition::OptionFault;

/// Figures of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingReport {
    /// Variance along every direction, descending; of a database that has grown, along those that are kept.
    pub spectrum: Vec<f64>,
    /// The part of all variance that the kept directions hold, 0..=1.
    pub energy_kept: f64,
    /// Directions kept: fewer than the options ask for if there are no more.
    pub dimension: usize,
    /// Components of a signature.
    pub signature_length: usize,
    /// The colour planes of signatures, never `Auto`.
    pub colour: Colour,
    /// Exemplars, with or without points.
    pub exemplars: usize,
    /// Different labels.
    pub labels: usize,
    /// Interest points of all exemplars.
    pub interest_points: usize,
    /// Ids of exemplars without interest points: no point can vote for them.
    pub exemplars_without_points: Vec<String>,
}

/// Why a training gave no model.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    /// The list of exemplars is empty.
    #[error("there are no exemplars")]
    NoExemplars,
    /// Not one window was described.
    #[error("no exemplar has interest points: the pictures are flat, dark or out of focus")]
    NoInterestPoints,
    /// Every exemplar is negative.
    #[error("every exemplar is negative: there is nothing to recognise")]
    NoLabels,
    /// Negative exemplars with signatures that have no use for them.
    #[error("negative exemplars go with gradient signatures")]
    NegativeExemplars,
    /// Two exemplars have this id.
    #[error("the exemplar id {0:?} occurs more than once")]
    DuplicateId(String),
    /// Signatures of the exemplar with this id have another length than the options give.
    #[error("the exemplar {0:?} was described under other options")]
    OtherOptions(String),
    /// The options are out of range or contradict each other: all that is wrong with them.
    #[error("the options can't be used")]
    Options(Vec<OptionFault>),
    /// The exemplar with this id has no colour, and the signatures of the others' sample have.
    #[error("the exemplar {0:?} has no colour: train with signatures of luminance alone")]
    WithoutColour(String),
    /// The signatures don't vary.
    #[error("no eigenspace can be fitted to the signatures")]
    Eigenspace(#[source] EigenError),
}

impl Landmarks {
    /// Trains on described exemplars, in any order: they are sorted by label, then id.
    ///
    /// # Errors
    /// Faults of the options; exemplars that are none, have the same id, were described under other options, or have
    /// no interest points; signatures that don't vary.
    pub fn train(
        mut exemplars: Vec<DescribedExemplar>,
        options: &LandmarkOptions,
    ) -> Result<(Landmarks, TrainingReport), TrainingError> {
        exemplars.sort_by(|a, b| a.exemplar.sort_key().cmp(&b.exemplar.sort_key()));
        check(&exemplars, options)?;
        let resolved = options.with_colour(exemplars.iter().all(|e| e.colour));
        match resolved.signature {
            Signature::Intensity => train_plain(exemplars, resolved),
            Signature::Gradient => {
                let (chosen, most) = sample_plan(exemplars.len());
                let samples: Vec<WindowSample> =
                    chosen.iter().map(|&index| WindowSample::of(&exemplars[index], most)).collect();
                let space = WindowSpace::fit(samples, exemplars.len(), &resolved)?;
                let encoded = exemplars.into_iter().map(|e| space.encode(e)).collect::<Result<_, _>>()?;
                Landmarks::of_encoded(space, encoded)
            }
        }
    }

    /// The database of exemplars that were encoded in a space, in any order.
    ///
    /// # Errors
    /// As [`Landmarks::train`].
    pub fn of_encoded(
        space: WindowSpace,
        mut encoded: Vec<EncodedExemplar>,
    ) -> Result<(Landmarks, TrainingReport), TrainingError> {
        encoded.sort_by(|a, b| a.exemplar.sort_key().cmp(&b.exemplar.sort_key()));
        let WindowSpace { options, eigenspace, spectrum, encoding } = space;
        check_exemplars(encoded.iter().map(|e| &e.exemplar), options.signature)?;
        let of_exemplars = EncodedExemplars {
            describer: Arc::new(ScaleSpaceDescriber::new(&options)),
            encoding,
            descriptors: encoded.iter().map(|e| e.descriptor).collect(),
        };
        let mut rows = Vec::with_capacity(encoded.iter().map(|e| e.rows.len()).sum());
        let mut exemplars = Vec::with_capacity(encoded.len());
        for EncodedExemplar { exemplar, rows: own, .. } in encoded {
            rows.extend(own);
            exemplars.push(exemplar);
        }
        let windows = EncodedWindows::of_rows(of_exemplars, &rows, &exemplars)
            .ok_or(TrainingError::NoInterestPoints)?;
        drop(rows);
        let (windows, confidence) = (Windows::Encoded(windows.into()), Some(Confidence::A_CONTRARIO));
        let model = Landmarks::assemble(options, exemplars, eigenspace, windows, confidence);
        let report = report(&model, spectrum);
        Ok((model, report))
    }

    /// This database with other exemplars beside those it keeps, in the same eigenspace: `added` were encoded in its
    /// [`WindowSpace::of`].
    ///
    /// # Errors
    /// As [`Landmarks::train`]; [`TrainingError::OtherOptions`] if this database has signatures of intensities, or its
    /// windows are elsewhere.
    pub fn grown(
        &self,
        added: Vec<EncodedExemplar>,
        keeps: impl Fn(&Exemplar) -> bool,
    ) -> Result<(Landmarks, TrainingReport), TrainingError> {
        let (Windows::Encoded(windows), Some(space)) = (&self.windows, WindowSpace::of(self)) else {
            return Err(TrainingError::OtherOptions(self.exemplars[0].id.clone()));
        };
        let (rows, length) = (windows.rows(), space.encoding.row_length());
        let kept = self.exemplars.iter().enumerate().filter(|(_, exemplar)| keeps(exemplar));
        let kept = kept.map(|(index, exemplar)| {
            let own = windows.of_exemplar(index);
            EncodedExemplar {
                exemplar: exemplar.clone(),
                rows: rows[own.start * length..own.end * length].to_vec(),
                descriptor: windows.exemplars.descriptors[index],
                energy: [0.0; 2],
            }
        });
        let encoded = kept.chain(added).collect();
        drop(rows);
        Landmarks::of_encoded(space, encoded)
    }
}

/// The database of exemplars with signatures of intensities, sorted.
fn train_plain(
    exemplars: Vec<DescribedExemplar>,
    options: LandmarkOptions,
) -> Result<(Landmarks, TrainingReport), TrainingError> {
    let length = options.signature_length();
    let row = |e: &DescribedExemplar| e.signatures.len().checked_div(e.windows.len()).unwrap_or(1).max(1);
    let rows = exemplars.iter().flat_map(|e| e.signatures.chunks_exact(row(e)));
    // the luminance part comes first: a shorter length leaves the colour part out
    let signatures: Vec<f32> = rows.flat_map(|row| &row[..length]).copied().collect();
    if signatures.is_empty() {
        return Err(TrainingError::NoInterestPoints);
    }
    let (eigenspace, spectrum) = Eigenspace::fit(&signatures, length, options.dimension) // A§4.1
        .map_err(TrainingError::Eigenspace)?;
    let windows = || exemplars.iter().flat_map(|e| &e.windows);
    let owner = |(owner, e): (usize, &DescribedExemplar)| std::iter::repeat_n(owner as u32, e.windows.len());
    let plain = PlainParts {
        eigenpoints: eigenspace.project(&signatures),
        points: windows().flat_map(|window| coordinates(&window.point)).collect(),
        radius: windows().map(|window| window.radius).collect(),
        spectra: exemplars.iter().flat_map(|e| e.spectra.iter().copied()).collect(),
        owner: exemplars.iter().enumerate().flat_map(owner).collect(),
    };
    let windows = Windows::Plain(plain.assemble(&options, eigenspace.dimension()));
    let exemplars = exemplars.into_iter().map(|e| e.exemplar).collect();
    let model = Landmarks::assemble(options, exemplars, eigenspace, windows, None);
    let report = report(&model, spectrum);
    Ok((model, report))
}

fn report(model: &Landmarks, spectrum: Vec<f64>) -> TrainingReport {
    let without = model.exemplars.iter().filter(|e| e.windows == 0);
    TrainingReport {
        energy_kept: model.eigenspace.eigenvalues.iter().sum::<f64>() / model.eigenspace.total_variance,
        spectrum,
        dimension: model.dimension(),
        signature_length: model.eigenspace.length(),
        colour: model.options.colour,
        exemplars: model.exemplars.len(),
        labels: model.labels().len(),
        interest_points: model.windows.count() / model.options.subwindow_radii_px.len(),
        exemplars_without_points: without.map(|e| e.id.clone()).collect(),
    }
}

/// Checks options and sorted exemplars.
fn check(exemplars: &[DescribedExemplar], options: &LandmarkOptions) -> Result<(), TrainingError> {
    let faults = options.faults();
    if !faults.is_empty() {
        return Err(TrainingError::Options(faults));
    }
    check_exemplars(exemplars.iter().map(|e| &e.exemplar), options.signature)?;
    let fits = |e: &DescribedExemplar| {
        let colour = options.with_colour(e.colour).colour == Colour::Opponent;
        colour == e.colour && e.signatures.len() == e.windows.len() * described_length(e, options)
    };
    match exemplars.iter().find(|e| !fits(e)) {
        Some(other) => Err(TrainingError::OtherOptions(other.exemplar.id.clone())),
        None => Ok(()),
    }
}

fn check_exemplars<'a>(
    exemplars: impl Iterator<Item = &'a Exemplar> + Clone,
    signature: Signature,
) -> Result<(), TrainingError> {
    if exemplars.clone().next().is_none() {
        return Err(TrainingError::NoExemplars);
    }
    if exemplars.clone().all(Exemplar::is_negative) {
        return Err(TrainingError::NoLabels);
    }
    if signature != Signature::Gradient && exemplars.clone().any(Exemplar::is_negative) {
        return Err(TrainingError::NegativeExemplars);
    }
    let mut ids: Vec<&str> = exemplars.map(|e| e.id.as_str()).collect();
    ids.sort_unstable();
    match ids.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(TrainingError::DuplicateId(pair[0].to_owned())),
        None => Ok(()),
    }
}

/// Length of an exemplar's signatures.
fn described_length(exemplar: &DescribedExemplar, options: &LandmarkOptions) -> usize {
    options.gray_length() + if exemplar.colour { options.colour_length() } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{described, name, paper, toy};
    use super::super::{Exemplar, LandmarkParts, Window, describe};
    use super::*;
    use crate::imaging::{Frame, Image};
    use crate::vision::InterestPoint;

    #[test]
    fn the_order_of_exemplars_changes_nothing() {
        let options = paper();
        let exemplars = described(0..6, &options);
        let mut shuffled = exemplars.clone();
        shuffled.reverse();
        shuffled.swap(1, 4);
        let (a, report_a) = Landmarks::train(exemplars, &options).unwrap();
        let (b, report_b) = Landmarks::train(shuffled, &options).unwrap();
        assert_eq!(LandmarkParts::from(&a), LandmarkParts::from(&b));
        assert_eq!(report_a, report_b);
    }

    #[test]
    fn the_report_counts_what_was_seen() {
        let options = paper();
        let mut exemplars = described(0..4, &options);
        let flat = Frame::gray(Image::from_fn(50, 40, |_, _| 90.0));
        exemplars.push(describe(name("wall", "toy0"), &flat, &options));
        let points: usize = exemplars.iter().map(|e| e.windows.len()).sum(); // one radius
        let (model, report) = Landmarks::train(exemplars, &options).unwrap();
        assert_eq!((report.exemplars, report.labels, report.interest_points), (5, 4, points));
        assert_eq!(report.exemplars_without_points, ["wall"]);
        assert_eq!(report.spectrum.len(), report.signature_length.min(points));
        assert!(report.energy_kept > 0.9 && report.energy_kept <= 1.0);
        assert_eq!(report.colour, Colour::Gray);
        assert_eq!((report.dimension, model.dimension()), (32, 32));
        assert!(model.bytes() > points * 32 * 4);
    }

    #[test]
    fn what_can_not_be_trained_says_why() {
        let options = paper();
        let fail = |exemplars, options: &LandmarkOptions| Landmarks::train(exemplars, options).err().unwrap();
        assert_eq!(fail(vec![], &options), TrainingError::NoExemplars);
        let flat = describe(name("a", "a"), &Frame::gray(Image::from_fn(50, 40, |_, _| 90.0)), &options);
        assert_eq!(fail(vec![flat], &options), TrainingError::NoInterestPoints);
        let twice = [described(0..1, &options), described(0..1, &options)].concat();
        assert_eq!(fail(twice, &options), TrainingError::DuplicateId("toy0".to_owned()));
        let other = LandmarkOptions { rings: 6, ..options.clone() };
        assert_eq!(fail(described(0..2, &other), &options), TrainingError::OtherOptions("toy0".to_owned()));
        let opponent = LandmarkOptions { colour: Colour::Opponent, ..options.clone() };
        let described_gray = described(0..2, &options);
        assert_eq!(fail(described_gray, &opponent), TrainingError::OtherOptions("toy0".to_owned()));
        let bad = LandmarkOptions { neighbours: 2, ..options };
        assert!(matches!(fail(vec![], &bad), TrainingError::Options(faults) if faults.len() == 1));
    }

    #[test]
    fn colour_is_used_if_every_exemplar_has_it() {
        let options = paper();
        let colourful = |seed| {
            let frame = Frame::colour([toy(seed, 64), toy(seed + 50, 64), toy(seed + 90, 64)]);
            describe(name(&format!("c{seed}"), "c"), &frame, &options)
        };
        let (model, report) = Landmarks::train(vec![colourful(1), colourful(2)], &options).unwrap();
        assert_eq!((report.colour, model.options().colour), (Colour::Opponent, Colour::Opponent));
        let mut mixed = described(0..2, &options);
        mixed.push(colourful(1));
        let (_, report) = Landmarks::train(mixed, &options).unwrap();
        assert_eq!(report.colour, Colour::Gray);
    }

    #[test]
    fn ten_thousand_identical_windows_and_one_other_can_be_trained() {
        let options = paper();
        let length = options.signature_length();
        let point = InterestPoint { x_px: 1.0, y_px: 1.0, salience: 1.0 };
        let exemplar = |id: &str, signatures: Vec<f32>| DescribedExemplar {
            exemplar: Exemplar {
                id: id.to_owned(),
                label: id.to_owned(),
                width_px: 9,
                height_px: 9,
                windows: signatures.len() / length,
                edges: vec![],
            },
            windows: vec![Window { point, radius: 0 }; signatures.len() / length],
            colour: false,
            signatures,
            spectra: vec![],
        };
        let window = |k: usize| (0..length).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f32>>();
        let same = exemplar("same", window(0).repeat(10_000));
        let (model, report) =
            Landmarks::train(vec![same.clone(), exemplar("other", window(1))], &options).unwrap();
        assert_eq!(report.dimension, 1);
        assert_eq!(model.windows.count(), 10_001);
        let alone = Landmarks::train(vec![same], &options).err().unwrap();
        assert!(matches!(alone, TrainingError::Eigenspace(EigenError::NoVariance { .. })));
    }
}
