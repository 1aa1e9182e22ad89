//! From a frame to interest points and their signatures (A§4.2–4.4), the same for exemplars and queries.

use super::options::{Colour, LandmarkOptions};
use crate::imaging::{Frame, Image};
use crate::vision::{
    InterestPoint, OpponentPlan, PolarGrid, SignaturePlan, interest_points, smoothed, symmetry_map,
};

/// Smoothing before the symmetry operator: an edge should have one direction, not its pixels' noise.
const ATTENTION_SIGMA_PX: f32 = 1.0;
/// A sub-window is smoothed by this part of its radius, and by 1 px at least: its samples lie farther
/// apart the larger it is.
const SUBWINDOW_SIGMA: f64 = 1.0 / 12.0;
/// What the opponent planes count beside luminance.
const OPPONENT_WEIGHT: f32 = 0.5;

/// What an exemplar is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExemplarName {
    /// Its own name, unique in a database.
    pub id: String,
    /// What it shows.
    pub label: String,
}

/// The interest points of one exemplar, and their signatures.
#[derive(Clone, Debug, PartialEq)]
pub struct DescribedExemplar {
    /// What it is called.
    pub name: ExemplarName,
    /// Width of its picture.
    pub width_px: usize,
    /// Height of its picture.
    pub height_px: usize,
    /// Strongest first.
    pub points: Vec<InterestPoint>,
    /// One row a point.
    pub signatures: Vec<f32>,
}

/// Describe one exemplar. Exemplars don't depend on each other: they may be described in parallel.
///
/// The options must be without [`LandmarkOptions::faults`].
pub fn describe(name: ExemplarName, frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
    let describer = Describer::new(options);
    let mut attention = describer.attend(frame);
    attention.points.truncate(options.interest_points);
    let signatures = describer.sign(frame, &attention);
    DescribedExemplar {
        name,
        width_px: frame.width(),
        height_px: frame.height(),
        points: attention.points,
        signatures,
    }
}

/// What drew attention in a frame.
pub(super) struct Attention {
    /// All interest points, strongest first.
    pub points: Vec<InterestPoint>,
    /// The smoothed luminance they were found in.
    smoothed: Image,
}

/// All that is computed once for descriptions under the same options.
pub(super) struct Describer {
    symmetry_radius_px: usize,
    subwindow_sigma_px: f32,
    grid: PolarGrid,
    signature: SignaturePlan,
    opponent: Option<OpponentPlan>,
}

impl Describer {
    pub fn new(options: &LandmarkOptions) -> Describer {
        let (rings, sectors) = (options.rings, options.sectors);
        let opponent = match options.colour_used() {
            Colour::Opponent => Some(OpponentPlan::new(rings, sectors)),
            Colour::Auto | Colour::Gray => None,
        };
        Describer {
            symmetry_radius_px: options.symmetry_radius_px,
            subwindow_sigma_px: (options.subwindow_radius_px * SUBWINDOW_SIGMA).max(1.0) as f32,
            grid: PolarGrid::new(options.subwindow_radius_px, rings, sectors),
            signature: options.signature_plan(),
            opponent,
        }
    }

    /// A§4.2: where to look.
    pub fn attend(&self, frame: &Frame) -> Attention {
        let smoothed = smoothed(&frame.luminance, ATTENTION_SIGMA_PX);
        let points = interest_points(&symmetry_map(&smoothed, self.symmetry_radius_px));
        Attention { points, smoothed }
    }

    /// A§4.3, A§4.4: what is seen there, one row a point.
    pub fn sign(&self, frame: &Frame, attention: &Attention) -> Vec<f32> {
        let resmoothed = (self.subwindow_sigma_px != ATTENTION_SIGMA_PX)
            .then(|| smoothed(&frame.luminance, self.subwindow_sigma_px));
        let luminance = resmoothed.as_ref().unwrap_or(&attention.smoothed);
        let opponents = self.opponent.as_ref().map(|plan| {
            (plan, frame.opponent_planes().map(|plane| smoothed(&plane, self.subwindow_sigma_px)))
        });

        let gray = self.signature.length();
        let length = gray + self.opponent.as_ref().map_or(0, |plan| 2 * plan.length());
        let mut signatures = vec![0.0; attention.points.len() * length];
        let mut samples = vec![0.0; self.grid.rings() * self.grid.sectors()];
        let mut scratch = self.signature.scratch();
        for (point, row) in attention.points.iter().zip(signatures.chunks_exact_mut(length)) {
            self.grid.sample(luminance, point.x_px, point.y_px, &mut samples); // A§4.3
            let (gray, colour) = row.split_at_mut(gray);
            self.signature.sign(&samples, &mut scratch, gray); // A§4.4
            if let Some((plan, planes)) = &opponents {
                for (plane, part) in planes.iter().zip(colour.chunks_exact_mut(plan.length())) {
                    self.grid.sample(plane, point.x_px, point.y_px, &mut samples);
                    plan.sign(&samples, OPPONENT_WEIGHT, part);
                }
            }
        }
        signatures
    }
}
