//! From a frame to interest points and their signatures (A§4.2–4.4), the same for exemplars and queries.
//!
//! A *window* is a sub-window of one radius about one interest point; with several radii a point has several.
//! Windows stand point by point, the smallest radius first.

use super::edge_template::edge_points;
use super::model::Exemplar;
use super::multiscale;
use super::options::{Colour, LandmarkOptions, Method, Operator, Signature, Viewpoint};
use crate::imaging::{Frame, Image};
use crate::vision::theta_spectrum::kept_spectrum;
use crate::vision::{
    InterestPoint, OpponentPlan, PolarGrid, SignaturePlan, SignatureScratch, ThetaPlan, bucketed, harris,
    interest_points, smoothed, symmetry_map,
};

/// Smoothing before the interest operator: an edge should have one direction, not its pixels' noise.
const ATTENTION_SIGMA_PX: f32 = 1.0;
/// A sub-window is smoothed by this part of its radius, and by 1 px at least: its samples lie farther
/// apart the larger it is.
const SUBWINDOW_SIGMA: f64 = 1.0 / 12.0;
/// Side of the buckets that interest points are taken from in turn: background with strong contrast doesn't crowd out
/// the rest of the frame.
const BUCKET_SIDE_PX: usize = 32;
/// Weight of the opponent planes against luminance.
const OPPONENT_WEIGHT: f32 = 0.5;

/// Name of an exemplar.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExemplarName {
    /// Its own name, unique in a database.
    pub id: String,
    /// The class or place that it shows; empty for a negative exemplar.
    pub label: String,
}

/// A sub-window about an interest point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Its centre.
    pub point: InterestPoint,
    /// Index of its radius among the options' radii; with gradient signatures its level of the scale space.
    pub radius: u8,
}

/// The windows of one exemplar, and their signatures.
#[derive(Clone, Debug, PartialEq)]
pub struct DescribedExemplar {
    /// Name, size and edge points.
    pub exemplar: Exemplar,
    /// Point by point.
    pub windows: Vec<Window>,
    /// Whether the signatures end with their colour part.
    pub colour: bool,
    /// One row a window.
    pub signatures: Vec<f32>,
    /// One row a window if the method verifies placements, else empty.
    pub spectra: Vec<i8>,
}

/// Describes one exemplar. Exemplars don't depend on each other: they may be described in parallel.
///
/// With [`Colour::Auto`] a colour frame gets the colour part as well; training leaves it out if other
/// exemplars have none. The options must be without [`LandmarkOptions::faults`].
pub fn describe(name: ExemplarName, frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
    let options = options.with_colour(frame.is_colour());
    if options.signature == Signature::Gradient {
        return multiscale::describe(name, frame, &options);
    }
    let describer = Describer::new(&options);
    let attention = describer.attend(frame);
    let mut planes = describer.smooth(frame, &attention);
    let batch = describer.next_batch(&mut planes, options.interest_points);
    let mut spectra = Vec::with_capacity(batch.spectra.len());
    if let Some(plan) = describer.phase_plan() {
        batch.spectra.chunks_exact(plan.length()).for_each(|row| kept_spectrum(row, &mut spectra));
    }
    DescribedExemplar {
        exemplar: Exemplar {
            id: name.id,
            label: name.label,
            width_px: frame.width() as u32,
            height_px: frame.height() as u32,
            windows: batch.windows.len(),
            edges: if options.verifies_placements() { edge_points(&attention.smoothed) } else { Vec::new() },
        },
        windows: batch.windows,
        colour: options.colour == Colour::Opponent,
        signatures: batch.signatures,
        spectra,
    }
}

/// The interest points of a frame.
pub(super) struct Attention {
    /// All interest points, in the order in which they are described.
    pub points: Vec<InterestPoint>,
    /// The smoothed luminance they were found in.
    pub smoothed: Image,
}

/// The planes of a frame, smoothed for the sub-windows of every radius, and the next point to describe.
pub(super) struct SmoothedPlanes<'a> {
    attention: &'a Attention,
    /// Of each radius; `None` where [`Attention::smoothed`] is the same.
    luminance: Vec<Option<Image>>,
    /// Of each radius; empty without colour.
    opponents: Vec<[Image; 2]>,
    next_point: usize,
}

/// Windows of a frame, and what describes them.
#[derive(Clone, Default)]
pub(super) struct WindowBatch {
    pub windows: Vec<Window>,
    /// One row a window.
    pub signatures: Vec<f32>,
    /// One row a window if the method verifies placements, else empty.
    pub spectra: Vec<f32>,
}

/// The plans of all that a description computes under the same options.
pub(super) struct Describer {
    operator: Operator,
    symmetry_radius_px: usize,
    /// Whether interest points are taken from buckets in turn.
    bucketing: bool,
    scales: Vec<Scale>,
    gray: GrayPlan,
    opponent: Option<OpponentPlan>,
}

/// Sampling of the sub-windows of one radius.
struct Scale {
    sigma_px: f32,
    grid: PolarGrid,
}

/// Signature of the luminance of a sub-window.
enum GrayPlan {
    /// A§4.4: amplitudes of its two-dimensional transform.
    Amplitude(SignaturePlan),
    /// Amplitudes of the transform along θ, ring by ring; the phases are kept beside.
    Rings(ThetaPlan),
    /// The sub-window itself, tapered.
    Upright(ThetaPlan),
}

/// Buffers for the windows of one point, used again for the next.
struct PointBuffers {
    samples: Vec<f32>,
    transform: Option<SignatureScratch>,
    /// One row a radius.
    signatures: Vec<f32>,
    /// One row a radius, rows of length 0 without spectra.
    spectra: Vec<f32>,
}

impl Describer {
    /// The colour of the options must be resolved.
    pub fn new(options: &LandmarkOptions) -> Describer {
        let (rings, sectors) = (options.rings, options.sectors);
        let scale = |&radius_px: &f64| Scale {
            sigma_px: (radius_px * SUBWINDOW_SIGMA).max(1.0) as f32,
            grid: PolarGrid::new(radius_px, rings, sectors),
        };
        let theta = || ThetaPlan::new(rings, sectors, options.normalise);
        Describer {
            operator: options.operator,
            symmetry_radius_px: options.symmetry_radius_px,
            bucketing: options.method == Method::Placement,
            scales: options.subwindow_radii_px.iter().map(scale).collect(),
            gray: match (options.method, options.viewpoint) {
                (Method::Paper, _) => {
                    GrayPlan::Amplitude(SignaturePlan::new(rings, sectors, options.taper, options.normalise))
                }
                (Method::Placement, Viewpoint::Free) => GrayPlan::Rings(theta()),
                (Method::Placement, Viewpoint::Upright) => GrayPlan::Upright(theta()),
            },
            opponent: (options.colour == Colour::Opponent).then(|| OpponentPlan::new(rings, sectors)),
        }
    }

    /// A§4.2: finds the interest points.
    pub fn attend(&self, frame: &Frame) -> Attention {
        let smoothed = smoothed(&frame.luminance, ATTENTION_SIGMA_PX);
        let radius_px = self.symmetry_radius_px;
        let map = match self.operator {
            Operator::Symmetry => symmetry_map(&smoothed, radius_px),
            Operator::Harris => harris(&smoothed, radius_px),
        };
        let points = interest_points(&map);
        Attention {
            points: if self.bucketing { bucketed(&points, BUCKET_SIDE_PX) } else { points },
            smoothed,
        }
    }

    /// Smooths the planes for every radius. The first point is the next.
    pub fn smooth<'a>(&self, frame: &Frame, attention: &'a Attention) -> SmoothedPlanes<'a> {
        let planes = self.opponent.as_ref().map(|_| frame.opponent_planes());
        let luminance = |scale: &Scale| {
            (scale.sigma_px != ATTENTION_SIGMA_PX).then(|| smoothed(&frame.luminance, scale.sigma_px))
        };
        let opponents = planes.iter().flat_map(|planes| {
            self.scales.iter().map(|scale| [0, 1].map(|plane| smoothed(&planes[plane], scale.sigma_px)))
        });
        SmoothedPlanes {
            attention,
            luminance: self.scales.iter().map(luminance).collect(),
            opponents: opponents.collect(),
            next_point: 0,
        }
    }

    /// The plan that compares the phases of two windows, if they are kept.
    pub fn phase_plan(&self) -> Option<&ThetaPlan> {
        match &self.gray {
            GrayPlan::Rings(plan) => Some(plan),
            GrayPlan::Amplitude(_) | GrayPlan::Upright(_) => None,
        }
    }

    /// A§4.3, A§4.4: describes the windows of the next `points` points, fewer if the frame has no more.
    ///
    /// Points with a flat sub-window are skipped: all flat windows look the same, so they would give the
    /// largest weight there is to whichever exemplar has one.
    pub fn next_batch(&self, planes: &mut SmoothedPlanes<'_>, points: usize) -> WindowBatch {
        let radii = self.scales.len();
        let expected = points.min(planes.attention.points.len() - planes.next_point) * radii;
        let mut batch = WindowBatch {
            windows: Vec::with_capacity(expected),
            signatures: Vec::with_capacity(expected * self.signature_length()),
            spectra: Vec::with_capacity(expected * self.spectrum_length()),
        };
        let mut buffers = PointBuffers {
            samples: vec![0.0; self.scales[0].grid.rings() * self.scales[0].grid.sectors()],
            transform: None,
            signatures: vec![0.0; radii * self.signature_length()],
            spectra: vec![0.0; radii * self.spectrum_length()],
        };
        while batch.windows.len() < points * radii
            && let Some(&point) = planes.attention.points.get(planes.next_point)
        {
            planes.next_point += 1;
            if (0..radii).all(|radius| self.describe_window(planes, point, radius, &mut buffers)) {
                batch.windows.extend((0..radii).map(|radius| Window { point, radius: radius as u8 }));
                batch.signatures.extend_from_slice(&buffers.signatures);
                batch.spectra.extend_from_slice(&buffers.spectra);
            }
        }
        batch
    }

    /// Writes the signature of one window, and its spectrum. Returns false if the window is flat.
    fn describe_window(
        &self,
        planes: &SmoothedPlanes<'_>,
        point: InterestPoint,
        radius: usize,
        buffers: &mut PointBuffers,
    ) -> bool {
        let PointBuffers { samples, transform, signatures, spectra } = buffers;
        let (signature_length, spectrum_length) = (self.signature_length(), self.spectrum_length());
        let signature = &mut signatures[radius * signature_length..][..signature_length];
        let (gray, colour) = signature.split_at_mut(self.gray_length());
        let spectrum = &mut spectra[radius * spectrum_length..][..spectrum_length];
        let grid = &self.scales[radius].grid;
        let luminance = planes.luminance[radius].as_ref().unwrap_or(&planes.attention.smoothed);
        grid.sample(luminance, point.x_px, point.y_px, samples); // A§4.3
        let visible = match &self.gray {
            GrayPlan::Amplitude(plan) => {
                plan.sign(samples, transform.get_or_insert_with(|| plan.scratch()), gray) // A§4.4
            }
            GrayPlan::Rings(plan) => plan.transform(samples, spectrum, gray),
            GrayPlan::Upright(plan) => plan.upright(samples, gray),
        };
        if let Some(plan) = self.opponent.as_ref().filter(|_| visible) {
            for (plane, part) in planes.opponents[radius].iter().zip(colour.chunks_exact_mut(plan.length())) {
                grid.sample(plane, point.x_px, point.y_px, samples);
                plan.sign(samples, OPPONENT_WEIGHT, part);
            }
        }
        visible
    }

    fn gray_length(&self) -> usize {
        match &self.gray {
            GrayPlan::Amplitude(plan) => plan.length(),
            GrayPlan::Rings(plan) => plan.amplitudes(),
            GrayPlan::Upright(plan) => plan.samples(),
        }
    }

    fn signature_length(&self) -> usize {
        self.gray_length() + self.opponent.as_ref().map_or(0, |plan| 2 * plan.length())
    }

    fn spectrum_length(&self) -> usize {
        self.phase_plan().map_or(0, ThetaPlan::length)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::pictures::{intensity, name, paper, quarter_turned, toy};
    use super::*;
    use crate::statistics::median;

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
    fn a_flat_subwindow_is_skipped() {
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
            let windows = describer.next_batch(&mut describer.smooth(&frame, &attention), 64).windows;
            let described_at = |frame: &Frame| {
                let points = windows.iter().map(|window| window.point).collect();
                let attention = Attention { points, ..describer.attend(frame) };
                describer.next_batch(&mut describer.smooth(frame, &attention), windows.len())
            };
            let (before, after) = (described_at(&frame), described_at(&lit));
            prop_assert_eq!(&before.windows, &windows);
            // The faintest windows may be flat once the contrast is a fifth.
            prop_assert!(4 * after.windows.len() >= 3 * windows.len());
            let length = options.signature_length();
            for (window, b) in after.windows.iter().zip(after.signatures.chunks_exact(length)) {
                let at = windows.iter().position(|other| other == window).unwrap();
                let a = &before.signatures[at * length..][..length];
                prop_assert!(distance(a, b) < 2e-3, "{}", distance(a, b));
            }
        }
    }

    #[test]
    fn a_point_has_a_window_of_every_radius_and_batches_go_on_where_they_stopped() {
        let options = intensity(Viewpoint::Free);
        let frame = Frame::gray(toy(3, 96));
        let described = described(&frame, &options);
        for pair in described.windows.chunks_exact(2) {
            assert_eq!((pair[0].point, pair[0].radius, pair[1].radius), (pair[1].point, 0, 1));
        }
        let rows = described.windows.len();
        assert_eq!(described.signatures.len(), rows * options.signature_length());
        assert_eq!(described.spectra.len(), rows * 8 * 24);
        let describer = Describer::new(&options.with_colour(false));
        let attention = describer.attend(&frame);
        let mut planes = describer.smooth(&frame, &attention);
        let batches = [10, 7, usize::MAX / 4].map(|count| describer.next_batch(&mut planes, count));
        let windows: Vec<Window> = batches.iter().flat_map(|batch| batch.windows.clone()).collect();
        assert_eq!(windows[..rows], described.windows);
        assert_eq!((batches[0].windows.len(), batches[1].windows.len()), (20, 14));
    }

    #[test]
    fn placement_signatures_survive_a_quarter_turn_and_upright_ones_do_not() {
        let changed = |viewpoint| {
            let options = LandmarkOptions { subwindow_radii_px: vec![10.0], ..intensity(viewpoint) };
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
            median(&mut changes, f32::total_cmp).expect("windows were found again")
        };
        let (free, upright) = (changed(Viewpoint::Free), changed(Viewpoint::Upright));
        assert!(free < 1e-3 && upright > 0.3, "free {free}, upright {upright}");
    }
}
