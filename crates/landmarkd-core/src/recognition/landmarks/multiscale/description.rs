//! From a frame to the windows of its scale space and their gradient signatures, the same for exemplars and queries.
//!
//! Positions are pixels of the frame at its working size; a window's `radius` is its level of the scale space.

use crate::imaging::{Frame, Image};
use crate::recognition::landmarks::description::{Window, WindowBatch};
use crate::recognition::landmarks::options::{Colour, LandmarkOptions, Operator};
use crate::vision::gradient_signature::{GradientSignature, SIGNATURE_LENGTH};
use crate::vision::scale_space::{Level, scale_space};
use crate::vision::{
    InterestPoint, OpponentPlan, PaddedGradient, PolarGrid, bucketed, harris, interest_points, smoothed,
    symmetry_map,
};

/// Octaves of the scale space at most, with the picture itself.
const OCTAVES: usize = 3;
/// Levels of a scale space at most, whatever the options.
pub(in super::super) const MOST_LEVELS: usize = OCTAVES * 4;
/// Smoothing of each level before the interest operator and the gradient.
const SIGMA_PX: f32 = 1.0;
/// Side of the buckets that the points of a level are taken from in turn.
const BUCKET_SIDE_PX: usize = 32;
/// Points nearer to a level's border have no whole neighbourhood.
const BORDER_PX: f32 = 6.0;
/// Points of a level at least.
const LEAST_POINTS: usize = 12;
/// Weight of the opponent planes against the gradient.
const OPPONENT_WEIGHT: f32 = 0.5;

/// The plans of all that a description computes under the same options.
pub(in super::super) struct ScaleSpaceDescriber {
    operator: Operator,
    symmetry_radius_px: usize,
    levels_per_octave: usize,
    /// At the finest level.
    radius_px: f32,
    signature: GradientSignature,
    opponent: Option<OpponentDescriber>,
}

/// A level of the scale space with its points, most salient of each bucket first.
struct AttendedLevel {
    level: Level,
    smoothed: Image,
    points: Vec<InterestPoint>,
}

/// The interest points of a frame's scale space.
pub(in super::super) struct ScaleSpaceAttention {
    levels: Vec<AttendedLevel>,
}

impl ScaleSpaceAttention {
    /// Points found.
    pub fn points(&self) -> usize {
        self.levels.iter().map(|level| level.points.len()).sum()
    }

    /// The picture smoothed with σ = 1 px.
    pub fn smoothed(&self) -> &Image {
        &self.levels[0].smoothed
    }
}

impl ScaleSpaceDescriber {
    /// The colour of the options must be resolved.
    pub fn new(options: &LandmarkOptions) -> ScaleSpaceDescriber {
        let radius_px = options.subwindow_radii_px[0];
        let opponent = (options.colour == Colour::Opponent).then(|| OpponentDescriber::new(options));
        ScaleSpaceDescriber {
            operator: options.operator,
            symmetry_radius_px: options.symmetry_radius_px,
            levels_per_octave: options.levels_per_octave,
            radius_px: radius_px as f32,
            signature: GradientSignature::new(radius_px),
            opponent,
        }
    }

    /// Pixels of the picture for each pixel of a level.
    pub fn scale(&self, level: u8) -> f32 {
        (f32::from(level) / self.levels_per_octave as f32).exp2()
    }

    /// Radius of the sub-windows of a level, pixels of the picture.
    pub fn radius_px(&self, level: u8) -> f32 {
        self.radius_px * self.scale(level)
    }

    /// A§4.2: finds the interest points of every level.
    pub fn attend(&self, frame: &Frame) -> ScaleSpaceAttention {
        let levels = scale_space(&frame.luminance, self.levels_per_octave, OCTAVES * self.levels_per_octave);
        let attended = levels.into_iter().map(|level| {
            let smoothed = smoothed(&level.image, SIGMA_PX);
            let map = match self.operator {
                Operator::Symmetry => symmetry_map(&smoothed, self.symmetry_radius_px),
                Operator::Harris => harris(&smoothed, self.symmetry_radius_px),
            };
            let (right, bottom) =
                (map.width() as f32 - 1.0 - BORDER_PX, map.height() as f32 - 1.0 - BORDER_PX);
            let inside = |point: &InterestPoint| {
                point.x_px > BORDER_PX && point.y_px > BORDER_PX && point.x_px < right && point.y_px < bottom
            };
            let points: Vec<InterestPoint> = interest_points(&map).into_iter().filter(inside).collect();
            AttendedLevel { level, smoothed, points: bucketed(&points, BUCKET_SIDE_PX) }
        });
        ScaleSpaceAttention { levels: attended.collect() }
    }

    /// A§4.3, A§4.4: describes about `points` windows, shared over the levels in proportion to their sides.
    pub fn describe(&self, frame: &Frame, attention: &ScaleSpaceAttention, points: usize) -> WindowBatch {
        let whole: f32 = attention.levels.iter().map(|attended| attended.level.scale.recip()).sum();
        let levels = attention.levels.len();
        let mut colour = self.opponent.as_ref().map(|describer| describer.part(frame, levels));
        let mut batch = WindowBatch::default();
        for (number, attended) in attention.levels.iter().enumerate() {
            let share = (points as f32 / attended.level.scale / whole) as usize;
            self.describe_level(number, attended, share.max(LEAST_POINTS), &mut colour, &mut batch);
        }
        batch
    }

    fn describe_level(
        &self,
        number: usize,
        attended: &AttendedLevel,
        points: usize,
        colour: &mut Option<OpponentPart<'_>>,
        batch: &mut WindowBatch,
    ) {
        let AttendedLevel { level, smoothed, points: found } = attended;
        let found = &found[..points.min(found.len())];
        let at: Vec<[usize; 2]> =
            found.iter().map(|point| [point.x_px as usize, point.y_px as usize]).collect();
        let gradient = PaddedGradient::new(smoothed, self.signature.reach_px());
        let described = self.signature.describe(&gradient, &at);
        let in_picture = |at: f32| (at + 0.5) * level.scale - 0.5;
        let rows = described.described.iter().zip(described.signatures.chunks_exact(SIGNATURE_LENGTH));
        for (&index, signature) in rows {
            let point = found[index];
            batch.signatures.extend_from_slice(signature);
            let at = InterestPoint { x_px: in_picture(point.x_px), y_px: in_picture(point.y_px), ..point };
            if let Some(colour) = colour {
                colour.write(number, &at, &mut batch.signatures);
            }
            batch.windows.push(Window { point: at, radius: number as u8 });
        }
        batch.spectra.extend(described.spectra);
    }
}

/// What describes the opponent planes. Colours of cameras have half the resolution of luminance: so have the planes here,
/// and finer windows take their samples from the finest of them. No fewer sectors than luminance has: with 16 or 24 of them one
/// frame of 15 rooms more stays undecided.
struct OpponentDescriber {
    levels_per_octave: usize,
    /// By how many levels the window is finer than the planes, from none on.
    grids: Vec<PolarGrid>,
    plan: OpponentPlan,
}

impl OpponentDescriber {
    fn new(options: &LandmarkOptions) -> OpponentDescriber {
        let grid = |finer: usize| {
            let radius_px =
                options.subwindow_radii_px[0] / (finer as f64 / options.levels_per_octave as f64).exp2();
            PolarGrid::new(radius_px, options.rings, options.sectors)
        };
        OpponentDescriber {
            levels_per_octave: options.levels_per_octave,
            grids: (0..=options.levels_per_octave).map(grid).collect(),
            plan: OpponentPlan::new(options.rings, options.sectors),
        }
    }

    /// The planes of a frame whose luminance has so many levels.
    fn part(&self, frame: &Frame, levels: usize) -> OpponentPart<'_> {
        let levels = levels.saturating_sub(self.levels_per_octave).max(1);
        let planes = frame.half_opponent_planes().map(|plane| {
            let levels = scale_space(&plane, self.levels_per_octave, levels).into_iter();
            // a mean of four pixels is smooth enough for the finer windows that look at it
            let smooth = |level: Level| match level.scale {
                1.0 => level,
                _ => Level { image: smoothed(&level.image, SIGMA_PX), ..level },
            };
            levels.map(smooth).collect()
        });
        OpponentPart {
            of: self,
            planes,
            samples: vec![0.0; self.plan.samples()],
            part: vec![0.0; self.plan.length()],
        }
    }
}

/// The opponent planes of a frame, level by level from half of its resolution on.
struct OpponentPart<'a> {
    of: &'a OpponentDescriber,
    planes: [Vec<Level>; 2],
    samples: Vec<f32>,
    part: Vec<f32>,
}

impl OpponentPart<'_> {
    /// Appends the part of a level's sub-window about a point of the frame.
    fn write(&mut self, level: usize, point: &InterestPoint, signatures: &mut Vec<f32>) {
        for planes in &self.planes {
            let coarser = level.saturating_sub(self.of.levels_per_octave).min(planes.len() - 1);
            let finer = (coarser + self.of.levels_per_octave).saturating_sub(level);
            let Level { image, scale } = &planes[coarser];
            let in_plane = |at: f32| (at + 0.5) / (2.0 * scale) - 0.5;
            self.of.grids[finer].sample(image, in_plane(point.x_px), in_plane(point.y_px), &mut self.samples);
            self.of.plan.sign(&self.samples, OPPONENT_WEIGHT, &mut self.part);
            signatures.extend_from_slice(&self.part);
        }
    }
}
