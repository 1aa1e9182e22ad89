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
    /// Whether the signatures end with their colour part.
    pub colour: bool,
    /// One row a point.
    pub signatures: Vec<f32>,
}

/// Describe one exemplar. Exemplars don't depend on each other: they may be described in parallel.
///
/// With [`Colour::Auto`] a colour frame gets the colour part as well; training leaves it out if other
/// exemplars have none. The options must be without [`LandmarkOptions::faults`].
pub fn describe(name: ExemplarName, frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
    let options = options.with_colour_if_auto(frame.is_colour());
    let describer = Describer::new(&options);
    let attention = describer.attend(frame);
    let (points, signatures) = describer.sign(frame, &attention, options.interest_points);
    DescribedExemplar {
        name,
        width_px: frame.width(),
        height_px: frame.height(),
        points,
        colour: options.colour == Colour::Opponent,
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
    /// The colour of the options must be settled.
    pub fn new(options: &LandmarkOptions) -> Describer {
        let (rings, sectors) = (options.rings, options.sectors);
        let opponent = (options.colour == Colour::Opponent).then(|| OpponentPlan::new(rings, sectors));
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

    /// A§4.3, A§4.4: what is seen at the strongest `count` points, and its signatures, one row a point.
    ///
    /// Points whose sub-window is flat are passed over: all flat windows look the same, so they would give
    /// the largest weight there is to whichever exemplar has one.
    pub fn sign(&self, frame: &Frame, attention: &Attention, count: usize) -> (Vec<InterestPoint>, Vec<f32>) {
        let resmoothed = (self.subwindow_sigma_px != ATTENTION_SIGMA_PX)
            .then(|| smoothed(&frame.luminance, self.subwindow_sigma_px));
        let luminance = resmoothed.as_ref().unwrap_or(&attention.smoothed);
        let opponents = self.opponent.as_ref().map(|plan| {
            (plan, frame.opponent_planes().map(|plane| smoothed(&plane, self.subwindow_sigma_px)))
        });

        let gray = self.signature.length();
        let length = gray + self.opponent.as_ref().map_or(0, |plan| 2 * plan.length());
        let expected = count.min(attention.points.len());
        let (mut points, mut signatures) =
            (Vec::with_capacity(expected), Vec::with_capacity(expected * length));
        let mut row = vec![0.0; length];
        let mut samples = vec![0.0; self.grid.rings() * self.grid.sectors()];
        let mut scratch = self.signature.scratch();
        for &point in &attention.points {
            if points.len() == count {
                break;
            }
            self.grid.sample(luminance, point.x_px, point.y_px, &mut samples); // A§4.3
            let (gray, colour) = row.split_at_mut(gray);
            if !self.signature.sign(&samples, &mut scratch, gray) {
                continue;
            }
            if let Some((plan, planes)) = &opponents {
                for (plane, part) in planes.iter().zip(colour.chunks_exact_mut(plan.length())) {
                    self.grid.sample(plane, point.x_px, point.y_px, &mut samples);
                    plan.sign(&samples, OPPONENT_WEIGHT, part);
                }
            }
            points.push(point);
            signatures.extend_from_slice(&row);
        }
        (points, signatures)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::pictures::{name, quarter_turned, toy};
    use super::*;

    fn described(frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
        describe(name("a", "a"), frame, options)
    }

    fn distance(a: &[f32], b: &[f32]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    }

    #[test]
    fn a_quarter_turn_leaves_every_signature() {
        for subwindow_radius_px in [5.0, 10.0, 20.0] {
            let options = LandmarkOptions { subwindow_radius_px, ..LandmarkOptions::default() };
            let length = options.signature_length();
            let picture = toy(3, 96);
            let before = described(&Frame::gray(picture.clone()), &options);
            let after = described(&Frame::gray(quarter_turned(&picture)), &options);
            assert_eq!(before.points.len(), after.points.len());
            assert!(before.points.len() > 20);
            for (point, signature) in before.points.iter().zip(before.signatures.chunks_exact(length)) {
                let place = (95.0 - point.y_px, point.x_px);
                let there = after.points.iter().position(|p| (p.x_px, p.y_px) == place);
                let turned = &after.signatures[there.expect("the point turned as well") * length..][..length];
                assert!(distance(signature, turned) < 1e-3, "{point:?}");
            }
        }
    }

    #[test]
    fn the_literal_taper_does_not_survive_a_quarter_turn() {
        let change = |taper| {
            let options = LandmarkOptions { taper, ..LandmarkOptions::default() };
            let length = options.signature_length();
            let picture = toy(3, 96);
            let before = described(&Frame::gray(picture.clone()), &options);
            let after = described(&Frame::gray(quarter_turned(&picture)), &options);
            let changes = before.points.iter().zip(before.signatures.chunks_exact(length)).map(|(p, row)| {
                let there = after.points.iter().position(|q| (q.x_px, q.y_px) == (95.0 - p.y_px, p.x_px));
                distance(row, &after.signatures[there.unwrap() * length..][..length])
            });
            changes.sum::<f32>() / before.points.len() as f32
        };
        let (radial, literal) = (change(super::super::Taper::Radial), change(super::super::Taper::Literal));
        println!(
            "mean change of a signature under a quarter turn: radial {radial:.1e}, literal {literal:.3}"
        );
        assert!(radial < 1e-3 && literal > 0.1, "radial {radial}, literal {literal}");
    }

    #[test]
    fn a_flat_subwindow_is_passed_over() {
        // the middle of a large disc is as symmetric as can be, and within 5 px there is nothing
        let disc = Image::from_fn(90, 64, |x, y| {
            let (dx, dy) = (x as f32 - 30.0, y as f32 - 30.0);
            let spot = x.abs_diff(75) <= 2 && y.abs_diff(30) <= 1;
            if dx * dx + dy * dy < 144.0 || spot { 200.0 } else { 20.0 }
        });
        let options = LandmarkOptions { symmetry_radius_px: 16, ..LandmarkOptions::default() };
        let frame = Frame::gray(disc);
        let found = Describer::new(&options).attend(&frame).points;
        let middle = *found.iter().find(|p| (p.x_px, p.y_px) == (30.0, 30.0)).expect("a point in the middle");
        let kept = described(&frame, &options).points;
        assert!(!kept.is_empty() && !kept.contains(&middle), "{kept:?}");
    }

    #[test]
    fn colour_adds_to_the_gray_signature_and_leaves_it() {
        let (red, green, blue) = (toy(1, 64), toy(2, 64), toy(3, 64));
        let frame = Frame::colour([red, green, blue]);
        let gray = LandmarkOptions { colour: Colour::Gray, ..LandmarkOptions::default() };
        let auto = LandmarkOptions::default();
        let (plain, rich) = (described(&frame, &gray), described(&frame, &auto));
        assert!(rich.colour && !plain.colour);
        assert_eq!(plain.points, rich.points);
        let length = gray.signature_length();
        let rows = rich.signatures.chunks_exact(length + auto.colour_length());
        for (row, plain) in rows.zip(plain.signatures.chunks_exact(length)) {
            assert_eq!(&row[..length], plain);
            assert!(row[length..].iter().any(|&v| v != 0.0));
        }
        assert!(!described(&Frame::gray(frame.luminance.clone()), &auto).colour);
    }

    #[test]
    fn flat_tiny_and_long_pictures_are_taken_at_every_radius() {
        let shapes = [(0, 0), (1, 1), (2, 1), (1, 2), (3, 3), (7, 5), (1, 700), (700, 1), (400, 2), (33, 33)];
        for (width, height) in shapes {
            let pictures = [
                Image::from_fn(width, height, |_, _| 255.0),
                Image::from_fn(width, height, |x, y| ((x * 89 + y * 57 + x * y) % 256) as f32),
            ];
            for picture in pictures {
                let frame = Frame::colour([(); 3].map(|()| picture.clone()));
                for symmetry_radius_px in [2, 3, 6, 11, 16] {
                    for subwindow_radius_px in [2.0, 5.0, 64.0] {
                        let options = LandmarkOptions {
                            symmetry_radius_px,
                            subwindow_radius_px,
                            colour: Colour::Opponent,
                            ..LandmarkOptions::default()
                        };
                        let found = described(&frame, &options);
                        assert!(found.signatures.iter().all(|v| v.is_finite()));
                        assert_eq!(found.signatures.len(), found.points.len() * options.signature_length());
                    }
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn brightness_and_contrast_leave_signatures(seed in 0u64..1000, gain in 0.2f32..1.0, offset in 0.0f32..50.0) {
            let options = LandmarkOptions::default();
            let describer = Describer::new(&options);
            let picture = toy(seed, 64);
            let lit = Frame::gray(Image::from_fn(64, 64, |x, y| gain * picture.at(x, y) + offset));
            let frame = Frame::gray(picture);
            // the same places in both: which points come first may change with contrast
            let points = describer.sign(&frame, &describer.attend(&frame), 64).0;
            let looked_at = |frame: &Frame| {
                let attention = Attention { points: points.clone(), ..describer.attend(frame) };
                let (kept, signatures) = describer.sign(frame, &attention, usize::MAX);
                assert_eq!(kept, points);
                signatures
            };
            let (before, after) = (looked_at(&frame), looked_at(&lit));
            let length = options.signature_length();
            for (a, b) in before.chunks_exact(length).zip(after.chunks_exact(length)) {
                prop_assert!(distance(a, b) < 2e-3, "{}", distance(a, b));
            }
        }
    }
}
