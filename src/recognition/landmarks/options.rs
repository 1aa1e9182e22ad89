//! The options of a landmark database. Their defaults are the paper's; each says where the text has it.

use crate::recognition::OptionFault;
use crate::vision::OpponentPlan;
use crate::vision::SignaturePlan;
pub use crate::vision::{Normalise, Taper};

/// How matches become an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// A§4.5: each point votes for the exemplar of its nearest eigenpoint.
    Paper,
}

/// What is known of the camera's attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewpoint {
    /// Nothing: signatures don't change when the image is turned.
    Free,
}

/// What draws attention.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// A§4.2: generalised symmetry.
    Symmetry,
}

/// What signatures know of colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Opponent if every exemplar is in colour, else gray.
    ///
    /// Measured with the paper's vote and these defaults, gray → opponent. Rooms and corridors seen 1, 2
    /// and 3 s away (20 places, 40 frames each): 0.30 → 0.73, 0.23 → 0.38, 0.08 → 0.25 right. Objects on
    /// photographs, 30 % occluded, and both (12 objects, 240 frames each): 0.48 → 0.50, 0.59 → 0.57,
    /// 0.38 → 0.33: no difference beyond sampling error.
    Auto,
    /// Luminance only.
    Gray,
    /// Luminance, and the two opponent planes r − g and b − (r + g)/2.
    Opponent,
}

/// How the W of a label's exemplars become the label's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PerLabel {
    /// That of its best exemplar.
    Best,
    /// Their sum.
    Sum,
}

/// All options of a landmark database.
#[derive(Clone, Debug, PartialEq)]
pub struct LandmarkOptions {
    /// How matches become an answer: A§4.5 itself.
    pub method: Method,
    /// What is known of the camera's attitude: nothing (A§4.4 wants signatures that turns don't change).
    pub viewpoint: Viewpoint,
    /// What draws attention: the symmetry operator of A§4.2.
    pub operator: Operator,
    /// Radius of the disc that the operator looks at, 2..=16 px. A§4.2 leaves it open; 6.
    pub symmetry_radius_px: usize,
    /// Interest points of an exemplar, 1..=1024. The paper's experiments use 64.
    pub interest_points: usize,
    /// Interest points of a frame to recognise, 1..=4096. The paper's experiments use 64.
    pub query_points: usize,
    /// Radius of the sub-windows, 2..=64 px. The paper's experiments use windows of 10 × 10 pixels: 5.
    pub subwindow_radius_px: f64,
    /// Rows of the polar sub-window, 2..=64. A§4.3 leaves the step open; from 5 × 24 to 10 × 48 nothing
    /// changes beyond sampling error at radius 5 or 10, so 8 × 32: a sample a pixel or denser up to radius 8.
    pub rings: usize,
    /// Columns of the polar sub-window, 4..=128. A§4.3 leaves the step open.
    pub sectors: usize,
    /// A§4.4 tapers with a Gaussian before the transform: over the radius only, so that turns change nothing.
    pub taper: Taper,
    /// What is made equal between sub-windows: mean and contrast.
    pub normalise: Normalise,
    /// What signatures know of colour.
    pub colour: Colour,
    /// Coordinates of an eigenpoint, 1..=256. A§4.1 keeps the leading directions.
    pub dimension: usize,
    /// Eigenpoints that a query point asks for: A§4.5 has the nearest one alone.
    pub neighbours: usize,
    /// ε of the vote 1/(D + ε), 1e-9..=10 (A§4.5).
    pub epsilon: f64,
    /// How the W of a label's exemplars become the label's: A§4.5 counts per training image.
    pub per_label: PerLabel,
}

impl Default for LandmarkOptions {
    fn default() -> Self {
        LandmarkOptions {
            method: Method::Paper,
            viewpoint: Viewpoint::Free,
            operator: Operator::Symmetry,
            symmetry_radius_px: 6,
            interest_points: 64,
            query_points: 64,
            subwindow_radius_px: 5.0,
            rings: 8,
            sectors: 32,
            taper: Taper::Radial,
            normalise: Normalise::Contrast,
            colour: Colour::Auto,
            dimension: 32,
            neighbours: 1,
            epsilon: 1e-3,
            per_label: PerLabel::Best,
        }
    }
}

impl LandmarkOptions {
    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        let mut faults = Vec::new();
        let mut whole = |option, value: usize, least: usize, most: usize| {
            if !(least..=most).contains(&value) {
                faults.push(OptionFault { option, message: format!("{value} is not in {least}..={most}") });
            }
        };
        whole("symmetry_radius_px", self.symmetry_radius_px, 2, 16);
        whole("interest_points", self.interest_points, 1, 1024);
        whole("query_points", self.query_points, 1, 4096);
        whole("rings", self.rings, 2, 64);
        whole("sectors", self.sectors, 4, 128);
        whole("dimension", self.dimension, 1, 256);
        let mut real = |option, value: f64, least: f64, most: f64| {
            if !(least..=most).contains(&value) {
                faults
                    .push(OptionFault { option, message: format!("{value} is not in {least:?}..={most:?}") });
            }
        };
        real("subwindow_radius_px", self.subwindow_radius_px, 2.0, 64.0);
        real("epsilon", self.epsilon, 1e-9, 10.0);
        if self.neighbours != 1 {
            let message = format!(
                "{} given; the paper's method asks for the nearest eigenpoint only: 1",
                self.neighbours
            );
            faults.push(OptionFault { option: "neighbours", message });
        }
        let shape_is_sound = !faults.iter().any(|f| ["rings", "sectors", "dimension"].contains(&f.option));
        if shape_is_sound && self.dimension > self.signature_length() {
            let length = self.signature_length();
            let message = format!("{} is more than the {length} components of a signature", self.dimension);
            faults.push(OptionFault { option: "dimension", message });
        }
        faults
    }

    /// Components of a signature: rings × (sectors/2 + 1), and with opponent planes 2 × rings × 4 more, or
    /// × 3 for fewer than six sectors. [`Colour::Auto`] counts as gray: so many there are at least.
    pub fn signature_length(&self) -> usize {
        self.gray_length() + if self.colour == Colour::Opponent { self.colour_length() } else { 0 }
    }

    /// The luminance part of a signature, which comes first.
    pub(super) fn gray_length(&self) -> usize {
        self.rings * (self.sectors / 2 + 1)
    }

    /// The part of both opponent planes.
    pub(super) fn colour_length(&self) -> usize {
        2 * OpponentPlan::new(self.rings, self.sectors).length()
    }

    /// These options with `Auto` settled.
    pub(super) fn with_colour_if_auto(&self, colour: bool) -> LandmarkOptions {
        let colour = match (self.colour, colour) {
            (Colour::Auto, true) => Colour::Opponent,
            (Colour::Auto, false) => Colour::Gray,
            (settled, _) => settled,
        };
        LandmarkOptions { colour, ..self.clone() }
    }

    pub(super) fn signature_plan(&self) -> SignaturePlan {
        SignaturePlan::new(self.rings, self.sectors, self.taper, self.normalise)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_the_papers_and_have_no_fault() {
        let options = LandmarkOptions::default();
        assert_eq!(options.faults(), []);
        assert_eq!((options.interest_points, options.query_points, options.neighbours), (64, 64, 1));
        assert_eq!(options.subwindow_radius_px, 5.0);
    }

    #[test]
    fn every_fault_is_told_at_once() {
        let options = LandmarkOptions {
            symmetry_radius_px: 1,
            interest_points: 0,
            query_points: 5000,
            subwindow_radius_px: f64::NAN,
            rings: 1,
            sectors: 1000,
            dimension: 0,
            neighbours: 3,
            epsilon: f64::INFINITY,
            ..LandmarkOptions::default()
        };
        let faults: Vec<&str> = options.faults().iter().map(|fault| fault.option).collect();
        assert_eq!(
            faults,
            [
                "symmetry_radius_px",
                "interest_points",
                "query_points",
                "rings",
                "sectors",
                "dimension",
                "subwindow_radius_px",
                "epsilon",
                "neighbours",
            ]
        );
    }

    #[test]
    fn a_dimension_above_the_signatures_is_a_fault() {
        let options = |sectors, colour, dimension| LandmarkOptions {
            rings: 2,
            sectors,
            colour,
            dimension,
            ..LandmarkOptions::default()
        };
        assert_eq!(options(4, Colour::Gray, 6).faults(), []);
        let faults = options(4, Colour::Auto, 7).faults();
        assert_eq!(faults[0].to_string(), "dimension: 7 is more than the 6 components of a signature");
        assert_eq!(options(4, Colour::Opponent, 6 + 12).faults(), []);
        assert_eq!(options(8, Colour::Opponent, 10 + 16).faults(), []);
        assert_eq!(options(8, Colour::Opponent, 10 + 17).faults().len(), 1);
    }
}
