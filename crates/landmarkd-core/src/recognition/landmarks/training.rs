//! Training (A§4.1): the signatures of all exemplars, their eigenspace, and the eigenpoints in it.

use thiserror::Error;

use super::description::{DescribedExemplar, Describer};
use super::model::{Exemplar, Landmarks, Owned};
use super::options::{Colour, LandmarkOptions};
use super::parts::spectrum_lengths;
use super::prior::{coordinates, with_places};
use crate::eigen::{EigenError, EigenpointIndex, Eigenspace};
use crate::recognition::OptionFault;

/// What a training tells of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingReport {
    /// Variance along every direction, descending.
    pub spectrum: Vec<f64>,
    /// The part of all variance that the kept directions hold, 0..=1.
    pub energy_kept: f64,
    /// Directions kept: fewer than asked for if there are no more.
    pub dimension: usize,
    /// Components of a signature.
    pub signature_length: usize,
    /// What signatures know of colour.
    pub colour: Colour,
    /// Exemplars, with or without points.
    pub exemplars: usize,
    /// Different labels.
    pub labels: usize,
    /// Interest points of all exemplars.
    pub interest_points: usize,
    /// Ids of exemplars in which nothing drew attention: they can never be voted for.
    pub exemplars_without_points: Vec<String>,
}

/// Why no model came of a training.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    #[error("there are no exemplars")]
    NoExemplars,
    #[error("no exemplar has interest points: the pictures are flat, dark or out of focus")]
    NoInterestPoints,
    #[error("the exemplar id {id:?} occurs more than once")]
    DuplicateId { id: String },
    #[error("the exemplar {id:?} was described under other options")]
    OtherOptions { id: String },
    #[error("the options can't be used")]
    Options { faults: Vec<OptionFault> },
    #[error("no eigenspace can be fitted to the signatures")]
    Eigenspace { source: EigenError },
}

impl Landmarks {
    /// Train on described exemplars. Their order doesn't matter: they are sorted by label, then id.
    pub fn train(
        mut exemplars: Vec<DescribedExemplar>,
        options: &LandmarkOptions,
    ) -> Result<(Landmarks, TrainingReport), TrainingError> {
        let faults = options.faults();
        if !faults.is_empty() {
            return Err(TrainingError::Options { faults });
        }
        if exemplars.is_empty() {
            return Err(TrainingError::NoExemplars);
        }
        exemplars.sort_by(|a, b| (&a.name.label, &a.name.id).cmp(&(&b.name.label, &b.name.id)));
        let mut ids: Vec<&str> = exemplars.iter().map(|e| e.name.id.as_str()).collect();
        ids.sort_unstable();
        if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(TrainingError::DuplicateId { id: pair[0].to_owned() });
        }
        let described_length = |e: &DescribedExemplar| {
            options.gray_length() + if e.colour { options.colour_length() } else { 0 }
        };
        let fits = |e: &DescribedExemplar| {
            let colour = options.with_colour_if_auto(e.colour).colour == Colour::Opponent;
            colour == e.colour && e.signatures.len() == e.windows.len() * described_length(e)
        };
        if let Some(other) = exemplars.iter().find(|e| !fits(e)) {
            return Err(TrainingError::OtherOptions { id: other.name.id.clone() });
        }
        let options = options.with_colour_if_auto(exemplars.iter().all(|e| e.colour));
        // a signature's luminance part comes first: where colour isn't used, its own part is left out
        let length = options.signature_length();
        let rows = exemplars.iter().flat_map(|e| e.signatures.chunks_exact(described_length(e)));
        let signatures: Vec<f32> = rows.flat_map(|row| &row[..length]).copied().collect();
        if signatures.is_empty() {
            return Err(TrainingError::NoInterestPoints);
        }
        let (eigenspace, spectrum) = Eigenspace::fit(&signatures, length, options.dimension) // A§4.1
            .map_err(|source| TrainingError::Eigenspace { source })?;
        let (dimension, prior) = (eigenspace.dimension(), options.position_prior_px);
        let windows = exemplars.iter().flat_map(|exemplar| exemplar.windows.iter().copied());
        let rows = with_places(eigenspace.project(&signatures), dimension, windows, prior);
        let index = EigenpointIndex::new(rows, coordinates(dimension, prior));

        let owned = exemplars.iter().enumerate().flat_map(|(owner, exemplar)| {
            exemplar.windows.iter().map(move |&window| Owned { window, exemplar: owner as u32 })
        });
        let owned: Vec<Owned> = owned.collect();
        let exemplars_without_points =
            exemplars.iter().filter(|e| e.windows.is_empty()).map(|e| e.name.id.clone()).collect();
        let spectra: Vec<i8> = exemplars.iter().flat_map(|e| e.spectra.iter().copied()).collect();
        let exemplars: Vec<Exemplar> = exemplars
            .into_iter()
            .map(|e| Exemplar {
                id: e.name.id,
                label: e.name.label,
                width_px: e.width_px as u32,
                height_px: e.height_px as u32,
                windows: e.windows.len(),
                contour: e.contour,
            })
            .collect();
        let describer = Describer::new(&options);
        let model = Landmarks {
            options,
            exemplars,
            eigenspace,
            index,
            owned,
            spectrum_lengths: spectrum_lengths(&spectra, &describer),
            describer,
            spectra,
            confidence: None,
        };
        let report = TrainingReport {
            energy_kept: model.eigenspace.eigenvalues.iter().sum::<f64>() / model.eigenspace.total_variance,
            spectrum,
            dimension: model.eigenspace.dimension(),
            signature_length: length,
            colour: model.options.colour,
            exemplars: model.exemplars.len(),
            labels: model.labels().len(),
            interest_points: model.owned.len() / model.options.subwindow_radii_px.len(),
            exemplars_without_points,
        };
        Ok((model, report))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Window;
    use super::super::describe;
    use super::super::pictures::{described, name, paper, toy};
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
        assert_eq!(a.to_parts(), b.to_parts());
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
        assert_eq!(fail(twice, &options), TrainingError::DuplicateId { id: "toy0".to_owned() });
        let other = LandmarkOptions { rings: 6, ..options.clone() };
        assert_eq!(
            fail(described(0..2, &other), &options),
            TrainingError::OtherOptions { id: "toy0".to_owned() }
        );
        let opponent = LandmarkOptions { colour: Colour::Opponent, ..options.clone() };
        let described_gray = described(0..2, &options);
        assert_eq!(fail(described_gray, &opponent), TrainingError::OtherOptions { id: "toy0".to_owned() });
        let bad = LandmarkOptions { neighbours: 2, ..options };
        assert!(matches!(fail(vec![], &bad), TrainingError::Options { faults } if faults.len() == 1));
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
            name: name(id, id),
            width_px: 9,
            height_px: 9,
            windows: vec![Window { point, radius: 0 }; signatures.len() / length],
            colour: false,
            signatures,
            spectra: vec![],
            contour: vec![],
        };
        let window = |k: usize| (0..length).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f32>>();
        let same = exemplar("same", window(0).repeat(10_000));
        let (model, report) =
            Landmarks::train(vec![same.clone(), exemplar("other", window(1))], &options).unwrap();
        assert_eq!(report.dimension, 1);
        assert_eq!(model.to_parts().owner.len(), 10_001);
        let alone = Landmarks::train(vec![same], &options).err().unwrap();
        assert!(matches!(alone, TrainingError::Eigenspace { source: EigenError::NoVariance { .. } }));
    }
}
