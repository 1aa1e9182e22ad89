//! A trained landmark database: an immutable value that recognises frames.

use super::description::Describer;
use super::options::{Colour, LandmarkOptions};
use super::vote::{Recognition, vote};
use super::warning::{FEW_POINTS, Warning};
use crate::eigen::{EigenpointIndex, Eigenspace};
use crate::imaging::Frame;
use crate::vision::InterestPoint;

/// One training image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exemplar {
    /// Its own name, unique in the database.
    pub id: String,
    /// What it shows.
    pub label: String,
    /// Width of its picture.
    pub width_px: u32,
    /// Height of its picture.
    pub height_px: u32,
    /// How many interest points it has.
    pub points: usize,
}

/// The steps of a recognition, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A§4.2: interest points.
    Attention,
    /// A§4.3–4.4: sub-windows and signatures.
    Signature,
    /// A§4.1, A§4.5: projection, and the nearest eigenpoints.
    Search,
    /// A§4.5: votes.
    Vote,
}

/// The interest point that an eigenpoint comes from.
#[derive(Clone, Copy)]
pub(super) struct Owned {
    pub point: InterestPoint,
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
}

impl Landmarks {
    /// Recognise a frame. `finished` is told the end of each stage: the caller holds the clock.
    ///
    /// Always names the nearest there is: whether that is near enough is for the caller to judge by the
    /// weights and warnings.
    pub fn recognise(&self, frame: &Frame, mut finished: impl FnMut(Stage)) -> Recognition {
        let attention = self.describer.attend(frame); // A§4.2
        let points_found = attention.points.len();
        finished(Stage::Attention);

        let (points, signatures) = self.describer.sign(frame, &attention, self.options.query_points); // A§4.3, A§4.4
        finished(Stage::Signature);

        let neighbours = self.index.nearest(&self.eigenspace.project(&signatures)); // A§4.1, A§4.5
        finished(Stage::Search);

        let matches = points.into_iter().zip(&neighbours).map(|(point, neighbour)| {
            (point, self.owned[neighbour.index].exemplar as usize, f64::from(neighbour.distance))
        });
        let (votes, points) = vote(matches, &self.exemplars, &self.options); // A§4.5
        finished(Stage::Vote);
        let warnings = self.doubts(frame, points.len());
        Recognition { points_found, points_used: points.len(), votes, points, warnings }
    }

    fn doubts(&self, frame: &Frame, points_used: usize) -> Vec<Warning> {
        let mut warnings = Vec::new();
        match points_used {
            0 => warnings.push(Warning::NoInterestPoints),
            used if used < self.options.query_points.min(FEW_POINTS) => {
                warnings.push(Warning::FewInterestPoints { found: used });
            }
            _ => {}
        }
        if self.options.colour == Colour::Opponent && !frame.is_colour() {
            warnings.push(Warning::GrayFrame);
        }
        warnings
    }

    /// The training images, sorted by label, then id.
    pub fn exemplars(&self) -> &[Exemplar] {
        &self.exemplars
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

    /// Coordinates of an eigenpoint: as many as asked for, or as there are.
    pub fn dimension(&self) -> usize {
        self.eigenspace.dimension()
    }

    /// Memory held, to within what an allocator adds.
    pub fn bytes(&self) -> usize {
        let names: usize =
            self.exemplars.iter().map(|e| size_of::<Exemplar>() + e.id.len() + e.label.len()).sum();
        let space = size_of_val(&self.eigenspace.mean[..])
            + size_of_val(&self.eigenspace.basis[..])
            + size_of_val(&self.eigenspace.eigenvalues[..]);
        size_of::<Landmarks>() + names + space + self.index.bytes() + size_of_val(&self.owned[..])
    }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{described, name, toy};
    use super::super::{PerLabel, Taper, describe};
    use super::*;
    use crate::imaging::Image;

    fn trained(options: &LandmarkOptions) -> Landmarks {
        Landmarks::train(described(0..10, options), options).unwrap().0
    }

    fn first(model: &Landmarks, frame: &Frame) -> String {
        model.recognise(frame, |_| ()).votes[0].label.clone()
    }

    #[test]
    fn its_own_picture_is_at_distance_zero() {
        let model = trained(&LandmarkOptions::default());
        for seed in 0..10 {
            let recognition = model.recognise(&Frame::gray(toy(seed, 96)), |_| ());
            assert_eq!(recognition.votes[0].label, format!("toy{seed}"));
            assert!(recognition.points.iter().all(|point| point.distance == 0.0));
            assert_eq!(recognition.votes[0].points, recognition.points_used);
            assert!(recognition.warnings.is_empty());
        }
    }

    #[test]
    fn turned_toys_are_recognised() {
        let model = trained(&LandmarkOptions::default());
        let right = (0..10u64).filter(|&seed| {
            let turned = Frame::gray(toy(seed, 96)).turned(17.0 + 36.0 * seed as f64);
            first(&model, &turned) == format!("toy{seed}")
        });
        let right = right.count();
        assert!(right == 10, "{right} of 10");
    }

    #[test]
    fn the_literal_taper_recognises_fewer_turned_toys() {
        let right = |taper| {
            let model = trained(&LandmarkOptions { taper, ..LandmarkOptions::default() });
            let mut share = 0.0;
            for seed in 0..10u64 {
                let turned = Frame::gray(toy(seed, 96)).turned(17.0 + 36.0 * seed as f64);
                let recognition = model.recognise(&turned, |_| ());
                let own = recognition.votes.iter().find(|vote| vote.label == format!("toy{seed}"));
                share += own.map_or(0.0, |vote| vote.share) / 10.0;
            }
            share
        };
        let (radial, literal) = (right(Taper::Radial), right(Taper::Literal));
        println!("share of W for the true label, turned toys: radial {radial:.3}, literal {literal:.3}");
        assert!(radial > literal + 0.1, "radial {radial}, literal {literal}");
    }

    #[test]
    fn most_half_occluded_toys_are_recognised() {
        let model = trained(&LandmarkOptions::default());
        let right = (0..10).filter(|&seed| {
            let whole = toy(seed, 96);
            let half = Image::from_fn(96, 96, |x, y| if x + y < 96 { whole.at(x, y) } else { 40.0 });
            first(&model, &Frame::gray(half).turned(45.0)) == format!("toy{seed}")
        });
        let right = right.count();
        // ten labels: chance is 1; the rest of the points votes for the occluder's edge
        assert!(right >= 7, "{right} of 10");
    }

    #[test]
    fn stages_end_in_their_order() {
        let mut stages = Vec::new();
        trained(&LandmarkOptions::default()).recognise(&Frame::gray(toy(1, 96)), |stage| stages.push(stage));
        assert_eq!(stages, [Stage::Attention, Stage::Signature, Stage::Search, Stage::Vote]);
    }

    #[test]
    fn the_same_frame_gives_the_same_answer() {
        let model = trained(&LandmarkOptions::default());
        let frame = Frame::gray(toy(4, 96)).turned(33.0);
        assert_eq!(model.recognise(&frame, |_| ()), model.recognise(&frame, |_| ()));
    }

    #[test]
    fn a_flat_frame_is_answered_with_a_warning() {
        let model = trained(&LandmarkOptions::default());
        for (width, height) in [(64, 64), (1, 1), (0, 0)] {
            let recognition =
                model.recognise(&Frame::gray(Image::from_fn(width, height, |_, _| 7.0)), |_| ());
            assert!(recognition.votes.is_empty() && recognition.points.is_empty());
            assert_eq!(recognition.warnings, [Warning::NoInterestPoints]);
        }
        let dot = Image::from_fn(40, 40, |x, y| if (x, y) == (20, 20) { 255.0 } else { 0.0 });
        let recognition = model.recognise(&Frame::gray(dot), |_| ());
        let found = recognition.points_used;
        assert!((1..8).contains(&found), "{found}");
        assert_eq!(recognition.warnings, [Warning::FewInterestPoints { found }]);
    }

    #[test]
    fn a_gray_frame_for_a_colour_database_is_doubted() {
        let options = LandmarkOptions { colour: Colour::Opponent, ..LandmarkOptions::default() };
        let frame = |seed| Frame::colour([toy(seed, 96), toy(seed, 96), toy(seed + 1, 96)]);
        let exemplars = (0..3).map(|seed| describe(name(&seed.to_string(), "x"), &frame(seed), &options));
        let (model, _) = Landmarks::train(exemplars.collect(), &options).unwrap();
        assert_eq!(model.recognise(&frame(1), |_| ()).warnings, []);
        let gray = Frame::gray(frame(1).luminance);
        assert_eq!(model.recognise(&gray, |_| ()).warnings, [Warning::GrayFrame]);
    }

    #[test]
    fn query_points_limit_the_voters() {
        let options = LandmarkOptions { query_points: 12, ..LandmarkOptions::default() };
        let recognition = trained(&options).recognise(&Frame::gray(toy(2, 96)), |_| ());
        assert_eq!(recognition.points_used, 12);
        assert!(recognition.points_found > 12);
        assert!(recognition.points.is_sorted_by(|a, b| a.salience >= b.salience));
    }

    #[test]
    fn two_views_of_a_label_count_once_or_both() {
        for (per_label, both) in [(PerLabel::Best, false), (PerLabel::Sum, true)] {
            let options = LandmarkOptions { per_label, ..LandmarkOptions::default() };
            let mut exemplars = described(0..3, &options);
            exemplars[1].name.label = "toy0".to_owned();
            let (model, _) = Landmarks::train(exemplars, &options).unwrap();
            assert_eq!(model.labels(), ["toy0", "toy2"]);
            let (left, right) = (toy(0, 96), toy(1, 96));
            let side_by_side =
                Image::from_fn(192, 96, |x, y| if x < 96 { left.at(x, y) } else { right.at(x - 96, y) });
            let recognition = model.recognise(&Frame::gray(side_by_side), |_| ());
            let voted =
                |exemplar: usize| recognition.points.iter().any(|p| p.exemplar == exemplar && p.weight > 0.0);
            assert_eq!(voted(0) && voted(1), both);
        }
    }
}
