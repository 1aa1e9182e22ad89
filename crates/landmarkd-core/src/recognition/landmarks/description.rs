//! From a frame to interest points and their signatures (A§4.2–4.4), the same for exemplars and queries.
//!
//! A *window* is a sub-window of one radius about one interest point; with several radii a point has several.
//! Windows stand point by point, the smallest radius first.

use super::contour::{ContourPoint, contour};
use super::options::{Colour, LandmarkOptions, Method, Operator, Viewpoint};
use crate::imaging::{Frame, Image};
use crate::vision::theta_spectrum::kept_spectrum;
use crate::vision::{
    InterestPoint, OpponentPlan, PolarGrid, SignaturePlan, ThetaPlan, harris, interest_points, smoothed,
    spread, symmetry_map,
};

/// Smoothing before the symmetry operator: an edge should have one direction, not its pixels' noise.
const ATTENTION_SIGMA_PX: f32 = 1.0;
/// A sub-window is smoothed by this part of its radius, and by 1 px at least: its samples lie farther
/// apart the larger it is.
const SUBWINDOW_SIGMA: f64 = 1.0 / 12.0;
/// Side of the squares that take turns in being looked at: background with strong contrast doesn't crowd out
/// the rest of the frame.
const SPREAD_PX: usize = 32;
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

/// A sub-window about an interest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// What it lies about.
    pub point: InterestPoint,
    /// Which of the options' radii it has.
    pub radius: u8,
}

/// The windows of one exemplar, and their signatures.
#[derive(Clone, Debug, PartialEq)]
pub struct DescribedExemplar {
    /// What it is called.
    pub name: ExemplarName,
    /// Width of its picture.
    pub width_px: usize,
    /// Height of its picture.
    pub height_px: usize,
    /// Point by point.
    pub windows: Vec<Window>,
    /// Whether the signatures end with their colour part.
    pub colour: bool,
    /// One row a window.
    pub signatures: Vec<f32>,
    /// One row a window, if matches are to say where the exemplar lies; else none.
    pub spectra: Vec<i8>,
    /// Where its strongest gradients are, if it is to be laid on frames; else none.
    pub contour: Vec<ContourPoint>,
}

/// Describe one exemplar. Exemplars don't depend on each other: they may be described in parallel.
///
/// With [`Colour::Auto`] a colour frame gets the colour part as well; training leaves it out if other
/// exemplars have none. The options must be without [`LandmarkOptions::faults`].
pub fn describe(name: ExemplarName, frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
    let options = options.with_colour_if_auto(frame.is_colour());
    let describer = Describer::new(&options);
    let attention = describer.attend(frame);
    let seen = describer.sign(&mut describer.look(frame, &attention), options.interest_points);
    let mut spectra = Vec::with_capacity(seen.spectra.len());
    if let Some(plan) = describer.turns() {
        seen.spectra.chunks_exact(plan.length()).for_each(|row| kept_spectrum(row, &mut spectra));
    }
    DescribedExemplar {
        name,
        width_px: frame.width(),
        height_px: frame.height(),
        windows: seen.windows,
        colour: options.colour == Colour::Opponent,
        signatures: seen.signatures,
        spectra,
        contour: if options.places() { contour(&attention.smoothed) } else { Vec::new() },
    }
}

/// What drew attention in a frame.
pub(super) struct Attention {
    /// All interest points, in the order in which they are looked at.
    pub points: Vec<InterestPoint>,
    /// The smoothed luminance they were found in.
    pub smoothed: Image,
}

/// A frame made ready for sub-windows of every radius, and how far its points have been looked at.
pub(super) struct Look<'a> {
    attention: &'a Attention,
    /// For each radius: the luminance, and the opponent planes; `None` for what [`Attention`] holds.
    luminance: Vec<Option<Image>>,
    opponents: Vec<[Image; 2]>,
    next: usize,
}

/// Windows of a frame.
#[derive(Default)]
pub(super) struct Seen {
    pub windows: Vec<Window>,
    /// One row a window.
    pub signatures: Vec<f32>,
    /// One row a window, if the options ask for them.
    pub spectra: Vec<f32>,
}

/// All that is computed once for descriptions under the same options.
pub(super) struct Describer {
    operator: Operator,
    symmetry_radius_px: usize,
    /// Whether all of the frame is looked at before any part of it a second time.
    spread: bool,
    scales: Vec<Scale>,
    gray: GrayPlan,
    opponent: Option<OpponentPlan>,
}

/// How sub-windows of one radius are sampled.
struct Scale {
    sigma_px: f32,
    grid: PolarGrid,
}

/// What is made of the luminance of a sub-window.
enum GrayPlan {
    /// A§4.4: amplitudes of its two-dimensional transform.
    Amplitude(SignaturePlan),
    /// Amplitudes ring by ring; the phases are kept beside.
    Rings(ThetaPlan),
    /// Itself, tapered.
    Upright(ThetaPlan),
}

impl Describer {
    /// The colour of the options must be settled.
    pub fn new(options: &LandmarkOptions) -> Describer {
        let (rings, sectors) = (options.rings, options.sectors);
        let opponent = (options.colour == Colour::Opponent).then(|| OpponentPlan::new(rings, sectors));
        let scale = |&radius_px: &f64| Scale {
            sigma_px: (radius_px * SUBWINDOW_SIGMA).max(1.0) as f32,
            grid: PolarGrid::new(radius_px, rings, sectors),
        };
        let theta = || ThetaPlan::new(rings, sectors, options.normalise);
        Describer {
            operator: options.operator,
            symmetry_radius_px: options.symmetry_radius_px,
            spread: options.method == Method::Placement,
            scales: options.subwindow_radii_px.iter().map(scale).collect(),
            gray: match (options.method, options.viewpoint) {
                (Method::Paper, _) => {
                    GrayPlan::Amplitude(SignaturePlan::new(rings, sectors, options.taper, options.normalise))
                }
                (Method::Placement, Viewpoint::Free) => GrayPlan::Rings(theta()),
                (Method::Placement, Viewpoint::Upright) => GrayPlan::Upright(theta()),
            },
            opponent,
        }
    }

    /// A§4.2: where to look.
    pub fn attend(&self, frame: &Frame) -> Attention {
        let smoothed = smoothed(&frame.luminance, ATTENTION_SIGMA_PX);
        let radius_px = self.symmetry_radius_px;
        let map = match self.operator {
            Operator::Symmetry => symmetry_map(&smoothed, radius_px),
            Operator::Harris => harris(&smoothed, radius_px),
        };
        let points = interest_points(&map);
        Attention { points: if self.spread { spread(&points, SPREAD_PX) } else { points }, smoothed }
    }

    /// The frame made ready, no point looked at yet.
    pub fn look<'a>(&self, frame: &Frame, attention: &'a Attention) -> Look<'a> {
        let planes = self.opponent.as_ref().map(|_| frame.opponent_planes());
        let luminance = |scale: &Scale| {
            (scale.sigma_px != ATTENTION_SIGMA_PX).then(|| smoothed(&frame.luminance, scale.sigma_px))
        };
        let opponents = planes.iter().flat_map(|planes| {
            self.scales.iter().map(|scale| [0, 1].map(|plane| smoothed(&planes[plane], scale.sigma_px)))
        });
        Look {
            attention,
            luminance: self.scales.iter().map(luminance).collect(),
            opponents: opponents.collect(),
            next: 0,
        }
    }

    /// What compares the phases of two windows, if they are kept.
    pub fn turns(&self) -> Option<&ThetaPlan> {
        match &self.gray {
            GrayPlan::Rings(plan) => Some(plan),
            GrayPlan::Amplitude(_) | GrayPlan::Upright(_) => None,
        }
    }

    /// A§4.3, A§4.4: what is seen at the next `count` points, and its signatures, one row a window.
    ///
    /// Points whose sub-window is flat are passed over: all flat windows look the same, so they would give
    /// the largest weight there is to whichever exemplar has one.
    pub fn sign(&self, look: &mut Look<'_>, count: usize) -> Seen {
        let (gray, spectrum_length) = match &self.gray {
            GrayPlan::Amplitude(plan) => (plan.length(), 0),
            GrayPlan::Rings(plan) => (plan.amplitudes(), plan.length()),
            GrayPlan::Upright(plan) => (plan.samples(), 0),
        };
        let length = gray + self.opponent.as_ref().map_or(0, |plan| 2 * plan.length());
        let scales = self.scales.len();
        let expected = count.min(look.attention.points.len() - look.next) * scales;
        let mut seen = Seen {
            windows: Vec::with_capacity(expected),
            signatures: Vec::with_capacity(expected * length),
            spectra: Vec::with_capacity(expected * spectrum_length),
        };
        let mut rows = vec![0.0; scales * length];
        let mut spectra = vec![0.0; scales * spectrum_length];
        let mut samples = vec![0.0; self.scales[0].grid.rings() * self.scales[0].grid.sectors()];
        let mut scratch = match &self.gray {
            GrayPlan::Amplitude(plan) => Some(plan.scratch()),
            GrayPlan::Rings(_) | GrayPlan::Upright(_) => None,
        };
        while seen.windows.len() < count * scales && look.next < look.attention.points.len() {
            let point = look.attention.points[look.next];
            look.next += 1;
            let mut visible = true;
            for (radius, scale) in self.scales.iter().enumerate() {
                let luminance = look.luminance[radius].as_ref().unwrap_or(&look.attention.smoothed);
                scale.grid.sample(luminance, point.x_px, point.y_px, &mut samples); // A§4.3
                let (gray, colour) = rows[radius * length..][..length].split_at_mut(gray);
                visible &= match (&self.gray, &mut scratch) {
                    (GrayPlan::Amplitude(plan), Some(scratch)) => plan.sign(&samples, scratch, gray), // A§4.4
                    (GrayPlan::Amplitude(_), None) => false,
                    (GrayPlan::Rings(plan), _) => plan.transform(
                        &samples,
                        &mut spectra[radius * spectrum_length..][..spectrum_length],
                        gray,
                    ),
                    (GrayPlan::Upright(plan), _) => plan.upright(&samples, gray),
                };
                if !visible {
                    break;
                }
                if let Some(plan) = &self.opponent {
                    let planes = &look.opponents[radius];
                    for (plane, part) in planes.iter().zip(colour.chunks_exact_mut(plan.length())) {
                        scale.grid.sample(plane, point.x_px, point.y_px, &mut samples);
                        plan.sign(&samples, OPPONENT_WEIGHT, part);
                    }
                }
            }
            if visible {
                seen.windows.extend((0..scales).map(|radius| Window { point, radius: radius as u8 }));
                seen.signatures.extend_from_slice(&rows);
                seen.spectra.extend_from_slice(&spectra);
            }
        }
        seen
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::pictures::{name, paper, quarter_turned, toy};
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
            let options = LandmarkOptions { subwindow_radii_px: vec![subwindow_radius_px], ..paper() };
            let length = options.signature_length();
            let picture = toy(3, 96);
            let before = described(&Frame::gray(picture.clone()), &options);
            let after = described(&Frame::gray(quarter_turned(&picture)), &options);
            assert_eq!(before.windows.len(), after.windows.len());
            assert!(before.windows.len() > 20);
            for (Window { point, .. }, signature) in
                before.windows.iter().zip(before.signatures.chunks_exact(length))
            {
                let place = (95.0 - point.y_px, point.x_px);
                let there = after.windows.iter().position(|w| (w.point.x_px, w.point.y_px) == place);
                let turned = &after.signatures[there.expect("the point turned as well") * length..][..length];
                assert!(distance(signature, turned) < 1e-3, "{point:?}");
            }
        }
    }

    #[test]
    fn the_literal_taper_does_not_survive_a_quarter_turn() {
        let change = |taper| {
            let options = LandmarkOptions { taper, ..paper() };
            let length = options.signature_length();
            let picture = toy(3, 96);
            let before = described(&Frame::gray(picture.clone()), &options);
            let after = described(&Frame::gray(quarter_turned(&picture)), &options);
            let changes = before.windows.iter().zip(before.signatures.chunks_exact(length)).map(
                |(Window { point: p, .. }, row)| {
                    let there = after
                        .windows
                        .iter()
                        .position(|q| (q.point.x_px, q.point.y_px) == (95.0 - p.y_px, p.x_px));
                    distance(row, &after.signatures[there.unwrap() * length..][..length])
                },
            );
            changes.sum::<f32>() / before.windows.len() as f32
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
        let options = LandmarkOptions { symmetry_radius_px: 16, ..paper() };
        let frame = Frame::gray(disc);
        let found = Describer::new(&options).attend(&frame).points;
        let middle = *found.iter().find(|p| (p.x_px, p.y_px) == (30.0, 30.0)).expect("a point in the middle");
        let kept: Vec<InterestPoint> =
            described(&frame, &options).windows.iter().map(|window| window.point).collect();
        assert!(!kept.is_empty() && !kept.contains(&middle), "{kept:?}");
    }

    #[test]
    fn colour_adds_to_the_gray_signature_and_leaves_it() {
        let (red, green, blue) = (toy(1, 64), toy(2, 64), toy(3, 64));
        let frame = Frame::colour([red, green, blue]);
        let gray = LandmarkOptions { colour: Colour::Gray, ..paper() };
        let auto = paper();
        let (plain, rich) = (described(&frame, &gray), described(&frame, &auto));
        assert!(rich.colour && !plain.colour);
        assert_eq!(plain.windows, rich.windows);
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
                            subwindow_radii_px: vec![subwindow_radius_px],
                            colour: Colour::Opponent,
                            ..paper()
                        };
                        let found = described(&frame, &options);
                        assert!(found.signatures.iter().all(|v| v.is_finite()));
                        assert_eq!(found.signatures.len(), found.windows.len() * options.signature_length());
                    }
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn brightness_and_contrast_leave_signatures(seed in 0u64..1000, gain in 0.2f32..1.0, offset in 0.0f32..50.0) {
            let options = paper();
            let describer = Describer::new(&options);
            let picture = toy(seed, 64);
            let lit = Frame::gray(Image::from_fn(64, 64, |x, y| gain * picture.at(x, y) + offset));
            let frame = Frame::gray(picture);
            // the same places in both: which points come first may change with contrast
            let attention = describer.attend(&frame);
            let windows = describer.sign(&mut describer.look(&frame, &attention), 64).windows;
            let looked_at = |frame: &Frame| {
                let points = windows.iter().map(|window| window.point).collect();
                let attention = Attention { points, ..describer.attend(frame) };
                let seen = describer.sign(&mut describer.look(frame, &attention), windows.len());
                assert_eq!(seen.windows, windows);
                seen.signatures
            };
            let (before, after) = (looked_at(&frame), looked_at(&lit));
            let length = options.signature_length();
            for (a, b) in before.chunks_exact(length).zip(after.chunks_exact(length)) {
                prop_assert!(distance(a, b) < 2e-3, "{}", distance(a, b));
            }
        }
    }

    #[test]
    fn a_point_has_a_window_of_every_radius_and_batches_go_on_where_they_stopped() {
        let options = LandmarkOptions::default();
        let frame = Frame::gray(toy(3, 96));
        let described = described(&frame, &options);
        for pair in described.windows.chunks_exact(2) {
            assert_eq!((pair[0].point, pair[0].radius, pair[1].radius), (pair[1].point, 0, 1));
        }
        let rows = described.windows.len();
        assert_eq!(described.signatures.len(), rows * options.signature_length());
        assert_eq!(described.spectra.len(), rows * 8 * 24);
        let describer = Describer::new(&options.with_colour_if_auto(false));
        let attention = describer.attend(&frame);
        let mut look = describer.look(&frame, &attention);
        let batches = [10, 7, usize::MAX / 4].map(|count| describer.sign(&mut look, count));
        let windows: Vec<Window> = batches.iter().flat_map(|seen| seen.windows.clone()).collect();
        assert_eq!(windows[..rows], described.windows);
        assert_eq!((batches[0].windows.len(), batches[1].windows.len()), (20, 14));
    }

    #[test]
    fn placement_signatures_survive_a_quarter_turn_and_upright_ones_do_not() {
        let changed = |viewpoint| {
            let options = LandmarkOptions {
                subwindow_radii_px: vec![10.0],
                ..LandmarkOptions::of(Method::Placement, viewpoint)
            };
            let picture = toy(3, 96);
            let (before, after) = (
                described(&Frame::gray(picture.clone()), &options),
                described(&Frame::gray(quarter_turned(&picture)), &options),
            );
            let length = options.signature_length();
            let row = |of: &DescribedExemplar, at: usize| of.signatures[at * length..][..length].to_vec();
            let mut changes: Vec<f32> = Vec::new();
            for (at, window) in before.windows.iter().enumerate() {
                let place = (95.0 - window.point.y_px, window.point.x_px);
                if let Some(there) = after.windows.iter().position(|w| (w.point.x_px, w.point.y_px) == place)
                {
                    changes.push(distance(&row(&before, at), &row(&after, there)));
                }
            }
            assert!(changes.len() > 20);
            changes.sort_by(f32::total_cmp);
            changes[changes.len() / 2]
        };
        let (free, upright) = (changed(Viewpoint::Free), changed(Viewpoint::Upright));
        assert!(free < 1e-3 && upright > 0.3, "free {free}, upright {upright}");
    }
}
