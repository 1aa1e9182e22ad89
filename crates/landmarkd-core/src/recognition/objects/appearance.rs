//! The appearance of a picture: one vector (B(7)), from pictures of one size.
//!
//! Of gradients: the orientation histograms of a [`GradientField`], in pictures whose longer side is 128 px; the farther views
//! are apart, the wider the windows that histograms are of, as what moves by more than a window can't be interpolated.
//!
//! Of intensities, as the text has it, of unit energy. The text takes the pixels as they are. Here the picture is
//! smoothed first, and then sampled no more densely than the smoothing leaves detail: an edge that moves by more than its
//! own width between two views can't be interpolated, so raw pixels make a manifold of corners. Measured on 20
//! objects, trained with 36 views each and asked about the 36 between: see `docs/papers.md`.

use std::collections::BTreeMap;

use thiserror::Error;

use super::disturbance::Disturbance;
use super::manifold::{DistinctPoses, gaps};
use super::normalised_crop::{ObjectSegmentation, normalised_crop, saturated_part};
use super::options::{AppearanceOf, MAX_SIDE_PX, ObjectOptions, Resize};
use super::recognition::{Alignment, Warning};
use crate::imaging::{Frame, Image, bilinear_replicated, fitted, seed_of_name};
use crate::recognition::Colour;
use crate::statistics::median;
use crate::vision::gradient_field::{self, DIRECTIONS, GradientField, OPPONENTS, Similarity};
use crate::vision::segmentation::{Region, Segmentation};
use crate::vision::smoothed;

/// Standard deviation of the smoothing in samples: detail that is finer is nearly gone.
const SIGMA_SAMPLES: f64 = 1.5;
/// Energy a pixel below which a picture is black: half a gray level in a hundred pixels.
const MIN_ENERGY: f64 = 0.0025;
/// A pixel this bright is saturated, in a picture of 0..=255.
const SATURATED: f32 = 254.0;
/// A picture is over-exposed if a larger part of its pixels is saturated.
const MAX_SATURATED_PART: f64 = 0.05;
/// A picture is under-exposed if fewer than [`MIN_BRIGHT_PART`] of its pixels are this bright.
const BRIGHT: f32 = 48.0;
const MIN_BRIGHT_PART: f64 = 0.01;
/// Side of normalised crops, if none is given and the exemplars aren't smaller.
const CROP_SIDE_PX: u32 = 128;
/// Least side of normalised crops: the least that an option may give.
const MIN_SIDE_PX: u32 = 8;
/// Longer side of a picture whose gradients are taken.
const FIELD_SIDE_PX: usize = 128;
/// Window of the histograms, in cells for each degree from one view to the next, and the widest.
const WINDOW_CELLS_PER_DEG: f64 = 0.055;
const WIDEST_CELLS: f64 = 1.1;
/// Gray levels per pixel: a picture whose strongest gradient is weaker is flat.
const FLAT: f32 = 0.5;
/// Side of the square that shows the histogram of a cell.
const ROSE_PX: usize = 16;

/// The picture is not of the database's size, and `resize` is `never`.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error(
    "the picture has {width_px}×{height_px} pixels; the database has pictures of {expected_width_px}×{expected_height_px}"
)]
pub struct SizeMismatch {
    /// Width of the picture.
    pub width_px: usize,
    /// Height of the picture.
    pub height_px: usize,
    /// Width of the database's pictures.
    pub expected_width_px: usize,
    /// Height of the database's pictures.
    pub expected_height_px: usize,
}

/// Turns pictures into appearances: one size, smoothed, sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct Normaliser {
    /// Size of the database's pictures.
    pub(super) width_px: usize,
    pub(super) height_px: usize,
    resize: Resize,
    segment: bool,
    /// Of the smoothing, px of the picture that is sampled.
    sigma_px: f64,
    sampling: Sampling,
}

/// How a picture is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sampling {
    /// Means of squares of this side.
    Intensity { step_px: usize },
    /// Histograms of a picture of this size.
    Gradient { width_px: usize, height_px: usize, colour: Colour, window_px: f64 },
}

/// A picture as read for recognition.
pub(super) struct Reading {
    pub appearance: Appearance,
    /// What the appearance of gradients was read from.
    pub field: Option<GradientField>,
}

/// A picture as a vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Row-major, of length one but for colours; all zero for a black picture.
    pub vector: Vec<f32>,
    /// The picture was in colour.
    pub is_colour: bool,
    /// The picture was not of the normaliser's size.
    pub resized: bool,
    /// More than a twentieth of the pixels is saturated.
    pub over_exposed: bool,
    /// Hardly a pixel reaches a fifth of the brightest. A dark background is no reason.
    pub under_exposed: bool,
    /// The object was cropped from a picture whose border cuts it.
    pub touches_border: bool,
    /// The object was cropped from a picture with another one nearly as large.
    pub several_regions: bool,
}

impl Appearance {
    /// Whether the picture is black, or nothing stood out of it.
    pub fn is_blank(&self) -> bool {
        self.vector.iter().all(|&v| v == 0.0)
    }

    /// Doubts about the picture, but for a blank one.
    pub(super) fn warnings(&self) -> Vec<Warning> {
        let doubts = [
            self.resized.then_some(Warning::Resized),
            self.touches_border.then_some(Warning::TouchesBorder),
            self.several_regions.then_some(Warning::SeveralRegions),
            self.over_exposed.then_some(Warning::OverExposed),
        ];
        doubts.into_iter().flatten().collect()
    }
}

/// The commonest width and height; of equally common ones the largest.
pub fn common_size(sizes: impl IntoIterator<Item = (u32, u32)>) -> Option<(u32, u32)> {
    let mut counts: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for size in sizes {
        *counts.entry(size).or_default() += 1;
    }
    counts.into_iter().max_by_key(|&(size, count)| (count, size)).map(|(size, _)| size)
}

/// The commonest step in pose from one view of an object to the next, degrees: the median over the objects that have three
/// poses. `None` without any.
pub fn common_step_deg<'a>(views: impl IntoIterator<Item = (&'a str, Option<f64>)>) -> Option<f64> {
    let mut poses: BTreeMap<&str, Vec<Option<f64>>> = BTreeMap::new();
    for (label, pose_deg) in views {
        poses.entry(label).or_default().push(pose_deg);
    }
    let poses = poses.into_values().map(|poses| DistinctPoses::of(&poses).poses_deg);
    let mut steps: Vec<f64> = poses.filter(|poses| poses.len() >= 3).flat_map(|poses| gaps(&poses)).collect();
    median(&mut steps, f64::total_cmp)
}

impl Normaliser {
    /// The normaliser of a database whose commonest picture has `size_px` (width, height): of the size that the options
    /// name, or else of that one, shrunk to 1024 px a side; with `segment` a square of 128 px.
    pub fn new(options: &ObjectOptions, size_px: (u32, u32)) -> Normaliser {
        let size_px = match options.segment {
            true => [size_px.0.min(size_px.1).clamp(MIN_SIDE_PX, CROP_SIDE_PX); 2].into(),
            false => size_px,
        };
        let (width, height) = (f64::from(size_px.0), f64::from(size_px.1));
        let shrink = (MAX_SIDE_PX as f64 / width.max(height)).min(1.0);
        let side = |length: f64| ((length * shrink).round() as usize).max(1);
        let width_px = options.width_px.unwrap_or(side(width));
        let height_px = options.height_px.unwrap_or(side(height));
        let longer_px = width_px.max(height_px);
        let (sigma_px, sampling) = match options.appearance {
            AppearanceOf::Intensity => {
                let sigma_px = options.smoothing * longer_px as f64;
                let step_px = ((sigma_px / SIGMA_SAMPLES) as usize).clamp(1, width_px.min(height_px).max(1));
                (sigma_px, Sampling::Intensity { step_px })
            }
            AppearanceOf::Gradient => {
                let [width_px, height_px] = [width_px, height_px].map(|side| {
                    let side = (side * FIELD_SIDE_PX) as f64 / longer_px as f64;
                    (side.round() as usize).max(gradient_field::CELL_PX)
                });
                let sigma_px = options.smoothing * FIELD_SIDE_PX as f64;
                let (colour, window_px) = (options.colour, gradient_field::WINDOW_PX);
                (sigma_px, Sampling::Gradient { width_px, height_px, colour, window_px })
            }
        };
        Normaliser {
            width_px,
            height_px,
            resize: options.resize,
            segment: options.segment,
            sigma_px,
            sampling,
        }
    }

    /// The normaliser of views that are commonly `step_deg` apart: see [`common_step_deg`].
    #[must_use]
    pub fn with_step_deg(mut self, step_deg: Option<f64>) -> Normaliser {
        if let (Sampling::Gradient { window_px, .. }, Some(step_deg)) = (&mut self.sampling, step_deg) {
            let cells = (WINDOW_CELLS_PER_DEG * step_deg).min(WIDEST_CELLS);
            *window_px = (cells * gradient_field::CELL_PX as f64).max(gradient_field::WINDOW_PX);
        }
        self
    }

    /// Window of the histograms; `None` of intensities.
    pub(super) fn window_px(&self) -> Option<f64> {
        match self.sampling {
            Sampling::Intensity { .. } => None,
            Sampling::Gradient { window_px, .. } => Some(window_px),
        }
    }

    /// The normaliser with a window that was kept; without one it stays.
    pub(super) fn with_window_px(mut self, kept_px: Option<f64>) -> Normaliser {
        if let (Sampling::Gradient { window_px, .. }, Some(kept_px)) = (&mut self.sampling, kept_px) {
            *window_px = kept_px;
        }
        self
    }

    /// Columns and rows of samples, or of cells.
    pub fn samples(&self) -> (usize, usize) {
        match self.sampling {
            Sampling::Intensity { step_px } => (self.width_px / step_px, self.height_px / step_px),
            Sampling::Gradient { width_px, height_px, .. } => {
                gradient_field::cells(width_px, height_px).into()
            }
        }
    }

    /// Components of an appearance without colours.
    pub(super) fn colourless_length(&self) -> usize {
        let (columns, rows) = self.samples();
        match self.sampling {
            Sampling::Intensity { .. } => columns * rows,
            Sampling::Gradient { .. } => columns * rows * DIRECTIONS,
        }
    }

    /// Components of an appearance.
    pub fn length(&self) -> usize {
        let (columns, rows) = self.samples();
        let opponents = if self.colour() == Colour::Gray { 0 } else { columns * rows * OPPONENTS };
        self.colourless_length() + opponents
    }

    /// The colours of appearances; not resolved before training.
    pub(super) fn colour(&self) -> Colour {
        match self.sampling {
            Sampling::Intensity { .. } => Colour::Gray,
            Sampling::Gradient { colour, .. } => colour,
        }
    }

    /// The normaliser with another choice of colours.
    pub(super) fn with_colour(mut self, of: Colour) -> Normaliser {
        if let Sampling::Gradient { colour, .. } = &mut self.sampling {
            *colour = of;
        }
        self
    }

    /// A place in the pixels of the database's pictures.
    pub(super) fn alignment(&self, place: &Similarity) -> Alignment {
        let px = match self.sampling {
            Sampling::Intensity { .. } => 1.0,
            Sampling::Gradient { .. } => self.width_px.max(self.height_px) as f64 / FIELD_SIDE_PX as f64,
        };
        Alignment {
            shift_x_px: px * place.x_px,
            shift_y_px: px * place.y_px,
            scale: place.scale,
            turn_deg: place.turn_rad.to_degrees(),
        }
    }

    /// What a disturbed view of a picture is recognised from; `None` of intensities.
    ///
    /// # Errors
    /// [`SizeMismatch`], unless `segment` is set.
    pub(super) fn disturbed(&self, frame: &Frame, name: &str) -> Result<Option<GradientField>, SizeMismatch> {
        match self.sampling {
            Sampling::Intensity { .. } => Ok(None),
            Sampling::Gradient { .. } => {
                let disturbed = Disturbance::random(name, 0).of(frame, seed_of_name(name, 0));
                Ok(self.read(&disturbed)?.field)
            }
        }
    }

    /// An appearance as a picture: gray levels of samples; of gradients a rose for each cell, whose petals are as bright as
    /// there is gradient in their direction. `base` is where there is none.
    pub(super) fn picture(&self, samples: impl Iterator<Item = f32>, base: f32) -> Image {
        let (columns, rows) = self.samples();
        let samples: Vec<f32> = samples.take(self.colourless_length()).collect();
        match self.sampling {
            Sampling::Intensity { .. } => Image::new(columns, rows, samples),
            Sampling::Gradient { .. } => Image::from_fn(columns * ROSE_PX, rows * ROSE_PX, |x, y| {
                let cell = y / ROSE_PX * columns + x / ROSE_PX;
                let off = |at: usize| (at % ROSE_PX) as f32 - (ROSE_PX as f32 - 1.0) / 2.0;
                let (right, down) = (off(x), off(y));
                if right.hypot(down) > ROSE_PX as f32 / 2.0 {
                    return base;
                }
                let turn = (down.atan2(right) / std::f32::consts::TAU).rem_euclid(1.0) * DIRECTIONS as f32;
                let (low, part) = (turn as usize % DIRECTIONS, turn.fract());
                let histogram = &samples[cell * DIRECTIONS..][..DIRECTIONS];
                histogram[low] + part * (histogram[(low + 1) % DIRECTIONS] - histogram[low])
            }),
        }
    }

    /// The appearance of a picture, or with `segment` of the crop of its largest region.
    ///
    /// # Errors
    /// [`SizeMismatch`], unless `segment` is set.
    pub fn appearance(&self, frame: &Frame) -> Result<Appearance, SizeMismatch> {
        Ok(self.read(frame)?.appearance)
    }

    /// As [`Normaliser::appearance`], with what a query needs.
    pub(super) fn read(&self, frame: &Frame) -> Result<Reading, SizeMismatch> {
        if self.segment {
            return Ok(self.read_object(frame));
        }
        let luminance = &frame.luminance;
        let resized = (luminance.width(), luminance.height()) != (self.width_px, self.height_px);
        if resized && self.resize == Resize::Never {
            return Err(SizeMismatch {
                width_px: luminance.width(),
                height_px: luminance.height(),
                expected_width_px: self.width_px,
                expected_height_px: self.height_px,
            });
        }
        let Reading { appearance, field } = self.normalised(frame);
        let appearance = Appearance {
            resized,
            over_exposed: part_above(luminance, SATURATED) > MAX_SATURATED_PART,
            under_exposed: part_above(luminance, BRIGHT) < MIN_BRIGHT_PART,
            ..appearance
        };
        Ok(Reading { appearance, field })
    }

    /// The [`normalised_crop`] of a region, whatever `segment` says.
    pub(super) fn read_region(&self, frame: &Frame, segmentation: &Segmentation, region: &Region) -> Reading {
        let crop = normalised_crop(frame, segmentation, region, (self.width_px, self.height_px));
        let luminance = &frame.luminance;
        let Reading { appearance, field } = self.normalised(&crop);
        let appearance = Appearance {
            touches_border: region.touches_border,
            // The negative of black pixels is bright, and few saturated pixels are averaged away in a small crop.
            over_exposed: saturated_part(luminance, segmentation, region, SATURATED) > MAX_SATURATED_PART,
            under_exposed: part_above(&crop.luminance, BRIGHT) < MIN_BRIGHT_PART,
            ..appearance
        };
        Reading { appearance, field }
    }

    /// The largest region of a picture; blank if nothing stands out.
    fn read_object(&self, frame: &Frame) -> Reading {
        let object = ObjectSegmentation::of(&frame.luminance);
        let Reading { appearance, field } = match object.segmentation.regions.first() {
            Some(region) => self.read_region(frame, &object.segmentation, region),
            None => {
                let black = Image::from_fn(self.width_px, self.height_px, |_, _| 0.0);
                self.normalised(&Frame::gray(black))
            }
        };
        let appearance = Appearance { several_regions: object.several_regions, ..appearance };
        Reading { appearance, field }
    }

    /// A picture without doubts.
    fn normalised(&self, frame: &Frame) -> Reading {
        let (vector, field) = match self.sampling {
            Sampling::Intensity { step_px } => (self.intensities(&frame.luminance, step_px), None),
            Sampling::Gradient { width_px, height_px, window_px, .. } => {
                let placed = placed(frame, width_px, height_px);
                let field = GradientField::of(&placed, self.sigma_px as f32, window_px);
                let opponents = vec![0.0; self.length() - self.colourless_length()];
                let vector = match field.strongest() > FLAT {
                    true => field.appearance(&Similarity::IDENTITY, &opponents),
                    false => vec![0.0; self.length()],
                };
                (vector, Some(field))
            }
        };
        let appearance = Appearance { vector, is_colour: frame.is_colour(), ..Appearance::default() };
        Reading { appearance, field }
    }

    /// The smoothed gray levels, of unit energy.
    fn intensities(&self, luminance: &Image, step_px: usize) -> Vec<f32> {
        let fitted = fitted(luminance, self.width_px, self.height_px);
        let mut vector = self.sampled(&smoothed(&fitted, self.sigma_px as f32), step_px);
        let energy = vector.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
        // B(7)
        let scale = if energy > MIN_ENERGY * vector.len() as f64 { 1.0 / energy.sqrt() } else { 0.0 };
        vector.iter_mut().for_each(|v| *v = (f64::from(*v) * scale) as f32);
        vector
    }

    /// The mean of each square of pixels; what is left of a square at the right and lower border is not sampled.
    fn sampled(&self, image: &Image, step_px: usize) -> Vec<f32> {
        if step_px == 1 {
            return image.pixels().to_vec();
        }
        let (columns, rows) = self.samples();
        let mut samples = vec![0.0; columns * rows];
        for (y, out) in samples.chunks_exact_mut(columns).enumerate() {
            for row in 0..step_px {
                let squares = image.row(y * step_px + row).chunks_exact(step_px);
                out.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square.iter().sum::<f32>());
            }
        }
        let pixels = step_px.pow(2) as f32;
        samples.iter_mut().for_each(|sum| *sum /= pixels);
        samples
    }
}

/// The picture as large as fits into `width_px` × `height_px`, in the middle; beyond it, what stands at its border: an edge
/// there would be part of the appearance.
fn placed(frame: &Frame, width_px: usize, height_px: usize) -> Frame {
    let scale = (width_px as f64 / frame.width() as f64).min(height_px as f64 / frame.height() as f64);
    let [width, height] =
        [frame.width(), frame.height()].map(|side| ((side as f64 * scale).round() as usize).max(1));
    let scaled = match scale <= 1.0 {
        true => frame.at_most(width.max(height)).into_owned(),
        false => frame.enlarged(scale),
    };
    if (scaled.width(), scaled.height()) == (width_px, height_px) {
        return scaled;
    }
    let left = (width_px as f64 - width as f64) / 2.0;
    let top = (height_px as f64 - height as f64) / 2.0;
    let framed = |plane: &Image| {
        Image::from_fn(width_px, height_px, |x, y| {
            bilinear_replicated(plane, x as f64 - left, y as f64 - top) as f32
        })
    };
    match &scaled.rgb {
        Some(rgb) => Frame::colour(rgb.each_ref().map(framed)),
        None => Frame::gray(framed(&scaled.luminance)),
    }
}

/// Part of the pixels whose gray level is at least `level`.
fn part_above(luminance: &Image, level: f32) -> f64 {
    let pixels = luminance.pixels();
    pixels.iter().filter(|&&v| v >= level).count() as f64 / pixels.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blob(width: usize, height: usize, brightness: f32) -> Frame {
        Frame::gray(Image::from_fn(width, height, |x, y| {
            let (dx, dy) = (x as f32 - 0.4 * width as f32, y as f32 - 0.6 * height as f32);
            brightness * (-(dx * dx + 2.0 * dy * dy) / (0.05 * (width * height) as f32)).exp()
        }))
    }

    fn apart(a: &Appearance, b: &Appearance) -> f32 {
        a.vector.iter().zip(&b.vector).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    }

    #[test]
    fn brightness_does_not_matter() {
        for of in [AppearanceOf::Intensity, AppearanceOf::Gradient] {
            brightness_does_not_matter_to(of);
        }
    }

    fn brightness_does_not_matter_to(of: AppearanceOf) {
        let options = ObjectOptions { colour: Colour::Gray, ..ObjectOptions::of(of) };
        let normaliser = Normaliser::new(&options, (64, 48));
        let bright = normaliser.appearance(&blob(64, 48, 240.0)).unwrap();
        let dark = normaliser.appearance(&blob(64, 48, 60.0)).unwrap();
        assert!(apart(&bright, &dark) < 1e-5);
        assert!((bright.vector.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
        let black = normaliser.appearance(&blob(64, 48, 0.0)).unwrap();
        assert!(black.vector.iter().all(|&v| v == 0.0) && black.under_exposed);
    }

    #[test]
    fn smoothing_takes_samples_away_and_none_takes_none() {
        let options = ObjectOptions::of(AppearanceOf::Intensity);
        let smooth = Normaliser::new(&options, (128, 128));
        assert_eq!(smooth.samples(), (64, 64));
        let raw = Normaliser::new(&ObjectOptions { smoothing: 0.0, ..options }, (128, 96));
        assert_eq!(raw.samples(), (128, 96));
        let frame = blob(128, 96, 200.0);
        let raw = raw.appearance(&frame).unwrap();
        let energy = frame.luminance.pixels().iter().map(|v| v * v).sum::<f32>().sqrt();
        assert!((raw.vector[5000] - frame.luminance.pixels()[5000] / energy).abs() < 1e-6);
    }

    #[test]
    fn another_size_is_fitted_or_refused() {
        let options = ObjectOptions { width_px: Some(64), height_px: Some(48), ..ObjectOptions::default() };
        let fit = Normaliser::new(&options, (9, 9));
        let twice = fit.appearance(&blob(128, 96, 200.0)).unwrap();
        let once = fit.appearance(&blob(64, 48, 200.0)).unwrap();
        assert!(twice.resized && !once.resized);
        // half a pixel between the two drawings
        assert!(apart(&twice, &once) < 0.05, "{}", apart(&twice, &once));
        let never = Normaliser::new(&ObjectOptions { resize: Resize::Never, ..options }, (9, 9));
        let error = never.appearance(&blob(128, 96, 200.0)).unwrap_err();
        assert_eq!((error.width_px, error.expected_height_px), (128, 48));
    }

    #[test]
    fn the_commonest_size_is_found() {
        assert_eq!(common_size([(5, 5), (9, 8), (5, 5)]), Some((5, 5)));
        assert_eq!(common_size([(5, 5), (9, 8)]), Some((9, 8)));
        assert_eq!(common_size([]), None);
    }

    #[test]
    fn large_pictures_are_shrunk() {
        let normaliser = Normaliser::new(&ObjectOptions::default(), (4000, 2000));
        assert_eq!((normaliser.width_px, normaliser.height_px), (1024, 512));
        assert!(normaliser.length() < 10_000, "{}", normaliser.length());
        assert_eq!(Normaliser::new(&ObjectOptions::default(), (65_535, 1)).samples().1, 1);
    }

    #[test]
    fn a_segmented_object_may_lie_anywhere() {
        let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
        let normaliser = Normaliser::new(&options, (320, 240));
        assert_eq!((normaliser.width_px, normaliser.height_px), (128, 128));
        let at = |x: f32, y: f32, ground: f32| {
            Frame::gray(Image::from_fn(320, 240, |column, row| {
                let (dx, dy) = (column as f32 - x, row as f32 - y);
                if (dx / 40.0).powi(2) + (dy / 25.0).powi(2) < 1.0 { 130.0 + dx } else { ground }
            }))
        };
        let here = normaliser.appearance(&at(100.0, 80.0, 0.0)).unwrap();
        let there = normaliser.appearance(&at(200.4, 150.7, 25.0)).unwrap();
        assert!(apart(&here, &there) < 0.1, "{}", apart(&here, &there));
        assert!(!here.resized && !here.touches_border && !here.several_regions);
        assert!(normaliser.appearance(&at(300.0, 80.0, 0.0)).unwrap().touches_border);
        assert!(
            normaliser.appearance(&Frame::gray(Image::from_fn(320, 240, |_, _| 90.0))).unwrap().is_blank()
        );
    }

    #[test]
    fn exposure_is_told() {
        let normaliser = Normaliser::new(&ObjectOptions::default(), (32, 32));
        let glare = Image::from_fn(32, 32, |x, _| if x < 8 { 255.0 } else { 20.0 });
        assert!(normaliser.appearance(&Frame::gray(glare)).unwrap().over_exposed);
        let good = normaliser.appearance(&blob(32, 32, 200.0)).unwrap();
        assert!(!good.over_exposed && !good.under_exposed);
        assert!(normaliser.appearance(&blob(32, 32, 30.0)).unwrap().under_exposed);
    }
}
