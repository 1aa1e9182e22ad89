//! The options of a landmark database, with the defaults of each method and viewpoint, and the section of the paper that
//! each option comes from.

use std::borrow::Cow;
use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;

use crate::imaging::Frame;
pub use crate::recognition::Colour;
use crate::recognition::OptionFault;
use crate::vision::theta_spectrum::FREQUENCIES;
pub use crate::vision::{Normalise, Taper};
use crate::vision::{OpponentPlan, gradient_signature};

/// Longer side to which larger pictures are brought by default.
const WORKING_SIZE_PX: usize = 640;
/// Pictures with a shorter longer side are enlarged up to it, by so much at most: of 60 frames of 256 px with half hidden objects
/// of 128 px the best vote is right in 1.00 so, and in 0.95 as they are.
const SMALL_PX: f64 = 512.0;
const MOST_ENLARGED: f64 = 2.0;
/// How far a camera on wheels turns about its axis at most, by default.
const UPRIGHT_TURN_DEG: f64 = 30.0;

/// How matches become an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Hypotheses of where an exemplar lies and how it is turned, each verified on the picture's gradients.
    Placement,
    /// A§4.5: each point votes for the exemplar of its nearest eigenpoint.
    Paper,
}

/// What is known of the camera's rotation about its axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewpoint {
    /// Nothing: signatures don't change when the image is turned.
    Free,
    /// The camera is upright, as on wheels: signatures keep the direction, and labels are judged by how much
    /// nearer than the background they are.
    Upright,
}

/// What a database is for: where its options start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Places, seen by a camera on wheels.
    Rooms,
    /// Things, turned as they may be.
    Things,
    /// Flat things: pictures, posters, boxes, labels.
    Flat,
}

impl Preset {
    /// The options. A placement is laid by a similarity or by a plane, whichever agrees better: what is flat needs no
    /// other options than any thing.
    pub fn options(self) -> LandmarkOptions {
        let viewpoint = match self {
            Preset::Rooms => Viewpoint::Upright,
            Preset::Things | Preset::Flat => Viewpoint::Free,
        };
        LandmarkOptions::of(Method::Placement, viewpoint)
    }
}

/// What signatures are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signature {
    /// The directions of the gradient relative to the radius, in windows of a scale space: what is seen larger, smaller,
    /// obliquely or in another light is known again. The number of false alarms decides.
    Gradient,
    /// The intensities of windows of one to four radii in the picture as it is (A§4.4).
    Intensity,
}

/// The interest operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// A§4.2: generalised symmetry.
    Symmetry,
    /// Harris's corners. Measured on the 20 objects of COIL-20 with 50 % hidden on photographs (120 frames): 0.98
    /// right by 304 points, symmetry 0.99 by 440; 111 frames of a corridor: 0.60, symmetry 0.69. The difference of
    /// Gaussians (0.96 by 410; 0.67), and all three in turn (0.95 by 500; 0.67), helped nowhere and are not here.
    Harris,
}

/// How W of a label's exemplars combine to W of the label.
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
    /// How matches become an answer.
    pub method: Method,
    /// What is known of the camera's rotation about its axis.
    pub viewpoint: Viewpoint,
    /// The interest operator: that of A§4.2 by default.
    pub operator: Operator,
    /// Radius of the operator's disc, 2..=16 px. A§4.2 leaves it open; 6.
    pub symmetry_radius_px: usize,
    /// Interest points of an exemplar, 1..=1024. The paper's experiments use 64.
    pub interest_points: usize,
    /// Interest points of a frame to recognise at most, 1..=4096. The paper's experiments use 64.
    pub query_points: usize,
    /// Radii of the sub-windows, one to four different ones in ascending order, 2..=64 px each; every point
    /// has one of each. The paper's experiments use windows of 10 × 10 pixels: 5.
    pub subwindow_radii_px: Vec<f64>,
    /// Rows of the polar sub-window, 2..=64. A§4.3 leaves the step open; from 5 × 24 to 10 × 48 nothing
    /// changes beyond sampling error at radius 5 or 10, so 8 × 32: a sample a pixel or denser up to radius 8.
    pub rings: usize,
    /// Columns of the polar sub-window, 4..=128. A§4.3 leaves the step open.
    pub sectors: usize,
    /// A§4.4 tapers with a Gaussian before the transform: over the radius only, so that turns change nothing.
    pub taper: Taper,
    /// Normalisation of sub-windows: of mean and contrast by default.
    pub normalise: Normalise,
    /// The colour planes of signatures.
    pub colour: Colour,
    /// Coordinates of an eigenpoint, 1..=256. A§4.1 keeps the leading directions.
    pub dimension: usize,
    /// Nearest eigenpoints searched for each query window, 1..=64; A§4.5 has the nearest one alone.
    pub neighbours: usize,
    /// ε of the vote 1/(D + ε), 1e-9..=10 (A§4.5).
    pub epsilon: f64,
    /// Width of the prior on the distance of a window from its trained position, 1..=1000 px; `None`: no prior.
    pub position_prior_px: Option<f64>,
    /// How W of a label's exemplars combine to W of the label: A§4.5 counts per training image.
    pub per_label: PerLabel,
    /// What signatures are made of.
    pub signature: Signature,
    /// Longer side to which larger pictures are brought, 160..=4096 px; `None`: pictures are taken as they are.
    pub working_size_px: Option<usize>,
    /// Levels of the scale space for each halving of the picture, 1..=4. Gradient signatures only.
    pub levels_per_octave: usize,
    /// Matches turned by more are left out, 1..=180°; `None`: any turn. Gradient signatures only.
    pub turn_prior_deg: Option<f64>,
    /// Frames of something unknown that may be answered, as a part of all, 1e-9..=1. Gradient signatures only.
    pub false_alarms: f64,
}

impl Default for LandmarkOptions {
    fn default() -> Self {
        LandmarkOptions::of(Method::Placement, Viewpoint::Free)
    }
}

impl LandmarkOptions {
    /// The defaults of a method and a viewpoint: gradient signatures with placement. Those of [`Method::Paper`] are the
    /// paper's own.
    pub fn of(method: Method, viewpoint: Viewpoint) -> LandmarkOptions {
        let signature = match method {
            Method::Paper => Signature::Intensity,
            Method::Placement => Signature::Gradient,
        };
        LandmarkOptions::with_signature(method, viewpoint, signature)
    }

    /// The defaults of a method, a viewpoint and a signature.
    pub fn with_signature(method: Method, viewpoint: Viewpoint, signature: Signature) -> LandmarkOptions {
        let paper = LandmarkOptions {
            method,
            viewpoint,
            operator: Operator::Symmetry,
            symmetry_radius_px: 6,
            interest_points: 64,
            query_points: 64,
            subwindow_radii_px: vec![5.0],
            rings: 8,
            sectors: 32,
            taper: Taper::Radial,
            normalise: Normalise::Contrast,
            colour: Colour::Auto,
            dimension: 32,
            neighbours: 1,
            epsilon: 1e-3,
            position_prior_px: None,
            per_label: PerLabel::Best,
            signature,
            working_size_px: None,
            levels_per_octave: 2,
            turn_prior_deg: None,
            false_alarms: 0.01,
        };
        match (signature, method, viewpoint) {
            (Signature::Gradient, _, _) => LandmarkOptions {
                interest_points: 600,
                query_points: 1000,
                subwindow_radii_px: vec![14.0],
                rings: gradient_signature::RINGS,
                sectors: gradient_signature::SECTORS,
                dimension: 48,
                neighbours: 30,
                working_size_px: Some(WORKING_SIZE_PX),
                operator: match viewpoint {
                    Viewpoint::Free => Operator::Symmetry,
                    Viewpoint::Upright => Operator::Harris,
                },
                turn_prior_deg: (viewpoint == Viewpoint::Upright).then_some(UPRIGHT_TURN_DEG),
                ..paper
            },
            (Signature::Intensity, Method::Paper, _) => paper,
            (Signature::Intensity, Method::Placement, Viewpoint::Free) => LandmarkOptions {
                interest_points: 96,
                query_points: 1000,
                subwindow_radii_px: vec![10.0, 14.0],
                dimension: 20,
                neighbours: 6,
                ..paper
            },
            (Signature::Intensity, Method::Placement, Viewpoint::Upright) => LandmarkOptions {
                interest_points: 150,
                query_points: 250,
                subwindow_radii_px: vec![12.0, 16.0, 21.0],
                dimension: 48,
                neighbours: 30,
                ..paper
            },
        }
    }

    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        let mut faults = self.range_faults();
        faults.extend(self.conflicts());
        let shape_is_sound = !faults.iter().any(|f| ["rings", "sectors", "dimension"].contains(&f.option));
        if shape_is_sound && self.dimension > self.signature_length() {
            let length = self.signature_length();
            let message = format!("{} is more than the {length} components of a signature", self.dimension);
            faults.push(OptionFault { option: "dimension", message });
        }
        faults
    }

    /// The numbers that are out of their range.
    fn range_faults(&self) -> Vec<OptionFault> {
        // the paper's method has a rule of its own for neighbours
        let neighbours = Some(self.neighbours).filter(|_| self.method != Method::Paper);
        let whole = [
            out_of_range("symmetry_radius_px", self.symmetry_radius_px, 2..=16),
            out_of_range("interest_points", self.interest_points, 1..=1024),
            out_of_range("query_points", self.query_points, 1..=4096),
            out_of_range("rings", self.rings, 2..=64),
            out_of_range("sectors", self.sectors, 4..=128),
            out_of_range("dimension", self.dimension, 1..=256),
            neighbours.and_then(|neighbours| out_of_range("neighbours", neighbours, 1..=64)),
            self.working_size_px.and_then(|side_px| out_of_range("working_size_px", side_px, 160..=4096)),
            out_of_range("levels_per_octave", self.levels_per_octave, 1..=4),
        ];
        let radii_px = self.subwindow_radii_px.iter();
        let radii = radii_px.map(|&radius_px| out_of_range("subwindow_radius_px", radius_px, 2.0..=64.0));
        let real = [
            out_of_range("epsilon", self.epsilon, 1e-9..=10.0),
            self.position_prior_px
                .and_then(|prior_px| out_of_range("position_prior_px", prior_px, 1.0..=1000.0)),
            self.turn_prior_deg.and_then(|turn_deg| out_of_range("turn_prior_deg", turn_deg, 1.0..=180.0)),
            out_of_range("false_alarms", self.false_alarms, 1e-9..=1.0),
        ];
        whole.into_iter().chain(radii).chain(real).flatten().collect()
    }

    /// The options that contradict each other.
    fn conflicts(&self) -> Vec<OptionFault> {
        let paper = self.method == Method::Paper;
        let gradient = self.signature == Signature::Gradient;
        let shape = (gradient_signature::RINGS, gradient_signature::SECTORS);
        let of_gradient = "belongs to gradient signatures";
        let radii = &self.subwindow_radii_px;
        let descending = radii.windows(2).any(|pair| pair[0] >= pair[1]);
        let neighbours =
            format!("{} given; the paper's method asks for the nearest eigenpoint only: 1", self.neighbours);
        let rules = [
            (
                !(1..=4).contains(&radii.len()) || descending,
                "subwindow_radius_px",
                "give one to four different radii, the smallest first",
            ),
            (
                paper && self.viewpoint == Viewpoint::Upright,
                "viewpoint",
                "upright goes with the method placement: the paper's signatures turn",
            ),
            (paper && self.neighbours != 1, "neighbours", neighbours.as_str()),
            (
                paper && radii.len() > 1,
                "subwindow_radius_px",
                "the paper's method has sub-windows of one radius",
            ),
            (
                !paper && self.taper == Taper::Literal,
                "taper",
                "literal goes with the method paper: placement needs signatures that turns leave",
            ),
            (
                !paper && self.per_label == PerLabel::Sum,
                "per_label",
                "sum goes with the method paper: an exemplar lies in one place",
            ),
            (
                self.position_prior_px.is_some() && self.viewpoint == Viewpoint::Free,
                "position_prior_px",
                "a window keeps its position only where the viewpoint is upright",
            ),
            (paper && gradient, "signature", "gradient goes with the method placement"),
            (
                gradient && radii.len() > 1,
                "subwindow_radius_px",
                "gradient signatures have windows of one radius, which grow with the levels of the scale space",
            ),
            (
                gradient && (self.rings, self.sectors) != shape,
                "rings",
                "gradient signatures have 6 rings of 32 sectors",
            ),
            (
                gradient && self.normalise != Normalise::Contrast,
                "normalise",
                "gradient signatures are of unit length: contrast",
            ),
            (
                gradient && self.position_prior_px.is_some(),
                "position_prior_px",
                "goes with intensity signatures",
            ),
            (!gradient && self.turn_prior_deg.is_some(), "turn_prior_deg", of_gradient),
        ];
        let broken = rules.into_iter().filter(|(broken, ..)| *broken);
        broken.map(|(_, option, message)| OptionFault { option, message: message.into() }).collect()
    }

    /// Components of a signature: 324 of gradients; of intensities rings × (sectors/2 + 1) with the paper's method,
    /// rings × 12 with placement, rings × sectors upright; and with opponent planes 2 × rings × 4 more, or × 3 for fewer than six sectors.
    /// [`Colour::Auto`] counts as gray: so many there are at least.
    pub fn signature_length(&self) -> usize {
        self.gray_length() + if self.colour == Colour::Opponent { self.colour_length() } else { 0 }
    }

    /// The luminance part of a signature, which comes first.
    pub(super) fn gray_length(&self) -> usize {
        if self.signature == Signature::Gradient {
            return gradient_signature::SIGNATURE_LENGTH;
        }
        match (self.method, self.viewpoint) {
            (Method::Paper, _) => self.rings * (self.sectors / 2 + 1),
            (Method::Placement, Viewpoint::Free) => self.rings * FREQUENCIES,
            (Method::Placement, Viewpoint::Upright) => self.rings * self.sectors,
        }
    }

    /// The part of both opponent planes.
    pub(super) fn colour_length(&self) -> usize {
        2 * OpponentPlan::new(self.rings, self.sectors).length()
    }

    /// These options with [`Colour::Auto`] resolved: opponent if there is `colour`, else gray.
    pub(super) fn with_colour(&self, colour: bool) -> LandmarkOptions {
        let colour = match (self.colour, colour) {
            (Colour::Auto, true) => Colour::Opponent,
            (Colour::Auto, false) => Colour::Gray,
            (given, _) => given,
        };
        LandmarkOptions { colour, ..self.clone() }
    }

    /// Whether recognition verifies where exemplars lie. Otherwise windows only vote.
    pub fn verifies_placements(&self) -> bool {
        self.signature == Signature::Gradient
            || (self.method, self.viewpoint) == (Method::Placement, Viewpoint::Free)
    }

    /// Numbers of the spectrum that is kept of each window: 0 if none is.
    pub(super) fn spectrum_length(&self) -> usize {
        match self.signature {
            Signature::Gradient => gradient_signature::SPECTRUM_LENGTH,
            Signature::Intensity if self.verifies_placements() => self.rings * 2 * FREQUENCIES,
            Signature::Intensity => 0,
        }
    }

    /// The frame brought to the working size; with gradient signatures small ones are enlarged.
    pub fn working_frame<'f>(&self, frame: &'f Frame) -> Cow<'f, Frame> {
        let enlarged = self.enlargement(frame.width().max(frame.height()) as f64);
        match self.working_size_px {
            _ if enlarged > 1.0 => Cow::Owned(frame.enlarged(enlarged)),
            Some(side_px) => frame.at_most(side_px),
            None => Cow::Borrowed(frame),
        }
    }

    /// How much a picture with this longer side is enlarged.
    fn enlargement(&self, longer_px: f64) -> f64 {
        let wanted_px = self.working_size_px.map_or(SMALL_PX, |side_px| SMALL_PX.min(side_px as f64));
        match self.signature {
            Signature::Gradient => (wanted_px / longer_px.max(1.0)).clamp(1.0, MOST_ENLARGED),
            Signature::Intensity => 1.0,
        }
    }

    /// Pixels of a picture of this size for each pixel of it at the working size.
    pub(super) fn reduction_of(&self, width_px: u32, height_px: u32) -> f32 {
        let longer_px = width_px.max(height_px);
        match self.working_size_px {
            Some(side_px) if longer_px as usize > side_px => longer_px as f32 / side_px as f32,
            _ => self.enlargement(f64::from(longer_px)).recip() as f32,
        }
    }

    /// −log₁₀ of the number of false alarms from which on a placement decides.
    pub fn least_evidence(&self) -> f64 {
        -self.false_alarms.log10()
    }
}

fn out_of_range<T: PartialOrd + Display + Debug>(
    option: &'static str,
    value: T,
    range: RangeInclusive<T>,
) -> Option<OptionFault> {
    (!range.contains(&value)).then(|| OptionFault { option, message: format!("{value} is not in {range:?}") })
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{intensity, paper};
    use super::*;

    #[test]
    fn the_defaults_of_every_method_have_no_fault_and_the_papers_are_its_own() {
        let options = paper();
        assert_eq!((options.interest_points, options.query_points, options.neighbours), (64, 64, 1));
        assert_eq!(options.subwindow_radii_px, [5.0]);
        let upright = LandmarkOptions::of(Method::Placement, Viewpoint::Upright);
        for options in [options, upright, LandmarkOptions::default()] {
            assert_eq!(options.faults(), []);
        }
    }

    #[test]
    fn options_that_do_not_go_together_are_faults() {
        let gradient = LandmarkOptions::default();
        let [free, upright] = [Viewpoint::Free, Viewpoint::Upright].map(intensity);
        let wrong = [
            (
                LandmarkOptions {
                    signature: Signature::Gradient,
                    method: Method::Paper,
                    neighbours: 1,
                    ..gradient.clone()
                },
                "signature",
            ),
            (
                LandmarkOptions { subwindow_radii_px: vec![8.0, 12.0], ..gradient.clone() },
                "subwindow_radius_px",
            ),
            (LandmarkOptions { rings: 8, ..gradient.clone() }, "rings"),
            (LandmarkOptions { false_alarms: 0.0, ..gradient.clone() }, "false_alarms"),
            (LandmarkOptions { working_size_px: Some(100), ..gradient }, "working_size_px"),
            (LandmarkOptions { turn_prior_deg: Some(30.0), ..free.clone() }, "turn_prior_deg"),
            (LandmarkOptions { viewpoint: Viewpoint::Upright, ..paper() }, "viewpoint"),
            (LandmarkOptions { subwindow_radii_px: vec![5.0, 8.0], ..paper() }, "subwindow_radius_px"),
            (LandmarkOptions { subwindow_radii_px: vec![], ..free.clone() }, "subwindow_radius_px"),
            (LandmarkOptions { subwindow_radii_px: vec![8.0, 8.0], ..free.clone() }, "subwindow_radius_px"),
            (LandmarkOptions { taper: Taper::Literal, ..free.clone() }, "taper"),
            (LandmarkOptions { position_prior_px: Some(40.0), ..free.clone() }, "position_prior_px"),
            (LandmarkOptions { position_prior_px: Some(0.0), ..upright }, "position_prior_px"),
            (LandmarkOptions { neighbours: 0, ..free.clone() }, "neighbours"),
            (LandmarkOptions { per_label: PerLabel::Sum, ..free }, "per_label"),
        ];
        for (options, option) in wrong {
            let faults: Vec<&str> = options.faults().iter().map(|fault| fault.option).collect();
            assert_eq!(faults, [option]);
        }
    }

    #[test]
    fn every_fault_is_reported_at_once() {
        let options = LandmarkOptions {
            symmetry_radius_px: 1,
            interest_points: 0,
            query_points: 5000,
            subwindow_radii_px: vec![f64::NAN],
            rings: 1,
            sectors: 1000,
            dimension: 0,
            neighbours: 3,
            epsilon: f64::INFINITY,
            ..paper()
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
        let options =
            |sectors, colour, dimension| LandmarkOptions { rings: 2, sectors, colour, dimension, ..paper() };
        assert_eq!(options(4, Colour::Gray, 6).faults(), []);
        let faults = options(4, Colour::Auto, 7).faults();
        assert_eq!(faults[0].to_string(), "dimension: 7 is more than the 6 components of a signature");
        assert_eq!(options(4, Colour::Opponent, 6 + 12).faults(), []);
        assert_eq!(options(8, Colour::Opponent, 10 + 16).faults(), []);
        assert_eq!(options(8, Colour::Opponent, 10 + 17).faults().len(), 1);
    }
}
