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
        let mut attention = self.describer.attend(frame); // A§4.2
        let points_found = attention.points.len();
        attention.points.truncate(self.options.query_points);
        finished(Stage::Attention);

        let signatures = self.describer.sign(frame, &attention); // A§4.3, A§4.4
        finished(Stage::Signature);

        let neighbours = self.index.nearest(&self.eigenspace.project(&signatures)); // A§4.1, A§4.5
        finished(Stage::Search);

        let matches = attention.points.iter().zip(&neighbours).map(|(&point, neighbour)| {
            (point, self.owned[neighbour.index].exemplar as usize, f64::from(neighbour.distance))
        });
        let (votes, points) = vote(matches, &self.exemplars, &self.options); // A§4.5
        finished(Stage::Vote);
        Recognition {
            points_found,
            points_used: points.len(),
            votes,
            points,
            warnings: self.doubts(frame, points_found),
        }
    }

    fn doubts(&self, frame: &Frame, points_found: usize) -> Vec<Warning> {
        let mut warnings = Vec::new();
        match points_found {
            0 => warnings.push(Warning::NoInterestPoints),
            found if found < FEW_POINTS => warnings.push(Warning::FewInterestPoints { found }),
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
