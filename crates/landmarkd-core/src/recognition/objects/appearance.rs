//! The appearance of a picture: one vector of unit energy (B(7)), from pictures of one size.
//!
//! The text takes the pixels as they are. Here the picture is smoothed first, and then sampled no more densely than
//! the smoothing leaves detail: an edge that moves by more than its own width between two views can't be
//! interpolated, so raw pixels make a manifold of corners. Measured on 20 objects, trained with 36 views each and asked
//! about the 36 between: see `docs/papers.md`.

use std::collections::BTreeMap;

use thiserror::Error;

use super::normalised_crop::{ObjectSegmentation, normalised_crop, saturated_part};
use super::options::{MAX_SIDE_PX, ObjectOptions, Resize};
use super::recognition::Warning;
use crate::imaging::{Frame, Image, fitted};
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

/// Turns pictures into appearances: one size, smoothed, sampled, of unit energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Normaliser {
    /// Size of the database's pictures.
    pub(super) width_px: usize,
    pub(super) height_px: usize,
    resize: Resize,
    segment: bool,
    sigma_px: f64,
    /// Side of the square of pixels that makes one sample.
    step_px: usize,
}

/// A picture as a vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Of length one, row-major; all zero for a black picture.
    pub vector: Vec<f32>,
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
        let sigma_px = options.smoothing * width_px.max(height_px) as f64;
        let step_px = ((sigma_px / SIGMA_SAMPLES) as usize).clamp(1, width_px.min(height_px).max(1));
        Normaliser {
            width_px,
            height_px,
            resize: options.resize,
            segment: options.segment,
            sigma_px,
            step_px,
        }
    }

    /// Width and height of an appearance as a picture: samples, not pixels.
    pub fn samples(&self) -> (usize, usize) {
        (self.width_px / self.step_px, self.height_px / self.step_px)
    }

    /// Components of an appearance.
    pub fn length(&self) -> usize {
        let (columns, rows) = self.samples();
        columns * rows
    }

    /// Gray levels of samples as a picture.
    pub(super) fn picture(&self, samples: impl Iterator<Item = f32>) -> Image {
        let (width, height) = self.samples();
        Image::new(width, height, samples.collect())
    }

    /// The appearance of a picture: its luminance, or with `segment` the crop of its largest region.
    ///
    /// # Errors
    /// [`SizeMismatch`], unless `segment` is set.
    pub fn appearance(&self, frame: &Frame) -> Result<Appearance, SizeMismatch> {
        let luminance = &frame.luminance;
        if self.segment {
            return Ok(self.object_appearance(luminance));
        }
        let resized = (luminance.width(), luminance.height()) != (self.width_px, self.height_px);
        if resized && self.resize == Resize::Never {
            return Err(SizeMismatch {
                width_px: luminance.width(),
                height_px: luminance.height(),
                expected_width_px: self.width_px,
                expected_height_px: self.height_px,
            });
        }
        let appearance = match resized {
            true => self.normalised(&fitted(luminance, self.width_px, self.height_px)),
            false => self.normalised(luminance),
        };
        Ok(Appearance {
            resized,
            over_exposed: part_above(luminance, SATURATED) > MAX_SATURATED_PART,
            under_exposed: part_above(luminance, BRIGHT) < MIN_BRIGHT_PART,
            ..appearance
        })
    }

    /// The appearance of the [`normalised_crop`] of a region, whatever `segment` says.
    pub fn region_appearance(
        &self,
        luminance: &Image,
        segmentation: &Segmentation,
        region: &Region,
    ) -> Appearance {
        let crop = normalised_crop(luminance, segmentation, region, (self.width_px, self.height_px));
        Appearance {
            touches_border: region.touches_border,
            // The negative of black pixels is bright, and few saturated pixels are averaged away in a small crop.
            over_exposed: saturated_part(luminance, segmentation, region, SATURATED) > MAX_SATURATED_PART,
            under_exposed: part_above(&crop, BRIGHT) < MIN_BRIGHT_PART,
            ..self.normalised(&crop)
        }
    }

    /// The appearance of the largest region of a picture; blank if nothing stands out.
    fn object_appearance(&self, luminance: &Image) -> Appearance {
        let object = ObjectSegmentation::of(luminance);
        let appearance = match object.segmentation.regions.first() {
            Some(region) => self.region_appearance(luminance, &object.segmentation, region),
            None => self.normalised(&Image::from_fn(self.width_px, self.height_px, |_, _| 0.0)),
        };
        Appearance { several_regions: object.several_regions, ..appearance }
    }

    /// The appearance of a picture of the database's size, without doubts.
    fn normalised(&self, picture: &Image) -> Appearance {
        let mut vector = self.sampled(&smoothed(picture, self.sigma_px as f32));
        let energy = vector.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
        // B(7)
        let scale = if energy > MIN_ENERGY * vector.len() as f64 { 1.0 / energy.sqrt() } else { 0.0 };
        vector.iter_mut().for_each(|v| *v = (f64::from(*v) * scale) as f32);
        Appearance { vector, ..Appearance::default() }
    }

    /// The mean of each square of pixels; what is left of a square at the right and lower border is not sampled.
    fn sampled(&self, image: &Image) -> Vec<f32> {
        if self.step_px == 1 {
            return image.pixels().to_vec();
        }
        let (columns, rows) = self.samples();
        let mut samples = vec![0.0; columns * rows];
        for (y, out) in samples.chunks_exact_mut(columns).enumerate() {
            for row in 0..self.step_px {
                let squares = image.row(y * self.step_px + row).chunks_exact(self.step_px);
                out.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square.iter().sum::<f32>());
            }
        }
        let pixels = self.step_px.pow(2) as f32;
        samples.iter_mut().for_each(|sum| *sum /= pixels);
        samples
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
        let normaliser = Normaliser::new(&ObjectOptions::default(), (64, 48));
        let bright = normaliser.appearance(&blob(64, 48, 240.0)).unwrap();
        let dark = normaliser.appearance(&blob(64, 48, 60.0)).unwrap();
        assert!(apart(&bright, &dark) < 1e-5);
        assert!((bright.vector.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
        let black = normaliser.appearance(&blob(64, 48, 0.0)).unwrap();
        assert!(black.vector.iter().all(|&v| v == 0.0) && black.under_exposed);
    }

    #[test]
    fn smoothing_takes_samples_away_and_none_takes_none() {
        let smooth = Normaliser::new(&ObjectOptions::default(), (128, 128));
        assert_eq!(smooth.samples(), (64, 64));
        let raw = Normaliser::new(&ObjectOptions { smoothing: 0.0, ..ObjectOptions::default() }, (128, 96));
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
        assert!(apart(&here, &there) < 0.03, "{}", apart(&here, &there));
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
