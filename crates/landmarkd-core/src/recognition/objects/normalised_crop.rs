//! The normalised crop of a region (B§3): background to zero, centred, scaled to the size of the database's pictures.
//!
//! The text centres the region and normalises its size, and leaves open by what. Here it is by the moments of the
//! region's intensity, not by its outermost pixels: those come and go with the threshold where an object is as dark as
//! the table, and move the whole picture with them. Measured: see `docs/papers.md`. A dark region on a light background
//! is negated, so that the background is zero in either case.

use crate::imaging::{Frame, Image, bilinear_inside};
use crate::vision::segmentation::{Polarity, Region, Segmentation, SegmentationOptions, segmented_from_near};
use crate::vision::smoothed;

/// Half the crop's side by the root mean square distance of the intensity from its centroid. A disc reaches to √2, a
/// bar to √3.
const MARGIN_FACTOR: f64 = 1.87;
/// The brightest gray level.
const WHITE: f32 = 255.0;
/// Pixels that differ from the background by more gray levels say whether the object is light or dark.
const MIN_CONTRAST: f32 = 10.0;
/// Another region of this part of the largest one's area is another object.
const OTHER_OBJECT_PART: f64 = 0.5;

/// The segmentation of a picture that shows one object.
pub(super) struct ObjectSegmentation {
    pub segmentation: Segmentation,
    /// Whether another region is nearly as large.
    pub several_regions: bool,
}

impl ObjectSegmentation {
    /// Segment a picture with options that follow from it: its border is mostly background, and most of what differs
    /// from that is the object.
    pub fn of(luminance: &Image) -> ObjectSegmentation {
        let background = luminance.border_median();
        // The sum of differences, not their number: a background that is a little brighter in the middle is no object.
        let contrast = |sign: f32| {
            let differences = luminance.pixels().iter().map(|v| sign * (v - background));
            differences.filter(|&difference| difference > MIN_CONTRAST).map(f64::from).sum::<f64>()
        };
        let polarity =
            if contrast(1.0) >= contrast(-1.0) { Polarity::LightOnDark } else { Polarity::DarkOnLight };
        let options = SegmentationOptions { polarity, ..SegmentationOptions::default() };
        let segmentation = segmented_from_near(luminance, &options);
        let area = |at: usize| segmentation.regions.get(at).map_or(0.0, |region| region.area_px as f64);
        let several_regions = area(1) > OTHER_OBJECT_PART * area(0);
        ObjectSegmentation { segmentation, several_regions }
    }
}

/// A region on black, the centroid of its intensity in the middle of `width_px` × `height_px` pixels.
///
/// The work is in proportion to the region's area, not to that of its box: a thin ring may be as wide as the picture.
pub(super) fn normalised_crop(
    frame: &Frame,
    segmentation: &Segmentation,
    region: &Region,
    (width_px, height_px): (usize, usize),
) -> Frame {
    let Some(moments) = Moments::of(&frame.luminance, segmentation, region) else {
        return Frame::gray(Image::from_fn(width_px, height_px, |_, _| 0.0));
    };
    // B§3, normalisation: pixels of the picture to one of the crop.
    let scale = 2.0 * MARGIN_FACTOR * moments.radius_px / width_px.min(height_px) as f64;
    let middle = [width_px, height_px].map(|side| (side as f64 - 1.0) / 2.0);
    let crop = |plane: &Image| {
        let reduced = Reduced::of(plane, segmentation, region, scale);
        let [centre_x, centre_y] = reduced.position_of(moments.centroid_px);
        Image::from_fn(width_px, height_px, |x, y| {
            let from_x = centre_x + (x as f64 - middle[0]) * reduced.step;
            let from_y = centre_y + (y as f64 - middle[1]) * reduced.step;
            bilinear_inside(&reduced.image, from_x, from_y)
        })
    };
    match &frame.rgb {
        Some(rgb) => Frame::colour(rgb.each_ref().map(crop)),
        None => Frame::gray(crop(&frame.luminance)),
    }
}

/// A region on black, reduced so far that sampling it at every `step` pixels doesn't alias.
struct Reduced {
    image: Image,
    /// Pixels of the reduced image to one of the crop, below 2.
    step: f64,
    /// Side of the squares of pixels of the picture that are averaged.
    square_px: usize,
    /// Black pixels of the reduced image on each side.
    margin: usize,
    /// Left and top of the region's box in the picture.
    origin_px: [usize; 2],
}

impl Reduced {
    /// For a crop whose pixels are `scale` pixels of the picture: averaged in whole squares of pixels, and the rest by a
    /// Gaussian, which spreads beyond the box.
    fn of(luminance: &Image, segmentation: &Segmentation, region: &Region, scale: f64) -> Reduced {
        let square_px = (scale as usize).max(1);
        let step = scale / square_px as f64;
        let sigma = if step > 1.0 { 0.5 * (step * step - 1.0).sqrt() } else { 0.0 };
        let margin = (3.0 * sigma).ceil() as usize + 2;
        let bounds = region.bbox_px;
        let [columns, rows] = [bounds.width, bounds.height].map(|side| side.div_ceil(square_px) + 2 * margin);
        let mut image = Image::from_fn(columns, rows, |_, _| 0.0);
        let share = 1.0 / (square_px * square_px) as f32;
        for Pixel { x, y, intensity } in pixels(luminance, segmentation, region) {
            let (x, y) = ((x - bounds.x) / square_px + margin, (y - bounds.y) / square_px + margin);
            image.pixels_mut()[y * columns + x] += share * intensity;
        }
        let image = smoothed(&image, sigma as f32);
        Reduced { image, step, square_px, margin, origin_px: [bounds.x, bounds.y] }
    }

    /// Where a point of the picture is in the reduced image.
    fn position_of(&self, [x_px, y_px]: [f64; 2]) -> [f64; 2] {
        let position = |at: f64, origin: usize| {
            (at - origin as f64 + 0.5) / self.square_px as f64 - 0.5 + self.margin as f64
        };
        [position(x_px, self.origin_px[0]), position(y_px, self.origin_px[1])]
    }
}

struct Pixel {
    x: usize,
    y: usize,
    /// The gray level, negated for a dark region.
    intensity: f32,
}

/// The pixels of a region.
fn pixels(luminance: &Image, segmentation: &Segmentation, region: &Region) -> impl Iterator<Item = Pixel> {
    let is_negative = region.is_darker;
    segmentation.runs(region).flat_map(move |(y, columns)| {
        let levels = &luminance.row(y)[columns.clone()];
        columns.zip(levels).map(move |(x, &v)| Pixel {
            x,
            y,
            intensity: if is_negative { WHITE - v } else { v },
        })
    })
}

/// Moments of a region's intensity.
struct Moments {
    centroid_px: [f64; 2],
    /// Root mean square distance from the centroid.
    radius_px: f64,
}

impl Moments {
    /// `None` for a black region.
    fn of(luminance: &Image, segmentation: &Segmentation, region: &Region) -> Option<Moments> {
        let (mut sum, mut x_sum, mut y_sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
        let [middle_x, middle_y] = region.centroid_px;
        for pixel in pixels(luminance, segmentation, region) {
            let (x, y) = (pixel.x as f64 - middle_x, pixel.y as f64 - middle_y);
            let intensity = f64::from(pixel.intensity);
            sum += intensity;
            x_sum += intensity * x;
            y_sum += intensity * y;
            squares += intensity * (x * x + y * y);
        }
        let (x, y) = (x_sum / sum, y_sum / sum);
        // A pixel is a square of second moment 1/12 along each axis, not a point.
        let radius_px = (squares / sum - x * x - y * y + 1.0 / 6.0).sqrt();
        (sum > 0.0).then_some(Moments { centroid_px: [middle_x + x, middle_y + y], radius_px })
    }
}

/// Part of a region's pixels whose gray level is at least `level`.
pub(super) fn saturated_part(
    luminance: &Image,
    segmentation: &Segmentation,
    region: &Region,
    level: f32,
) -> f64 {
    let levels = segmentation.runs(region).flat_map(|(row, columns)| &luminance.row(row)[columns]);
    levels.filter(|&&v| v >= level).count() as f64 / region.area_px as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An egg with a dark end, set down at a place and a size.
    fn egg(width: usize, height: usize, centre: [f64; 2], scale: f64, ground: f32) -> Image {
        Image::from_fn(width, height, |x, y| {
            let (dx, dy) = ((x as f64 - centre[0]) / scale, (y as f64 - centre[1]) / scale);
            let inside = (dx / 20.0).powi(2) + (dy / 12.0).powi(2) < 1.0;
            if inside { (140.0 + 3.0 * dx + dy) as f32 } else { ground }
        })
    }

    fn cut(image: &Image, side_px: usize) -> Image {
        let ObjectSegmentation { segmentation, .. } = ObjectSegmentation::of(image);
        let frame = Frame::gray(image.clone());
        normalised_crop(&frame, &segmentation, &segmentation.regions[0], (side_px, side_px)).luminance
    }

    #[test]
    fn place_size_and_background_do_not_matter() {
        let first = cut(&egg(160, 120, [80.0, 60.0], 1.5, 0.0), 64);
        for (centre, scale, ground) in
            [([40.3, 50.6], 1.5, 20.0), ([110.0, 30.5], 1.0, 12.0), ([80.2, 60.4], 2.4, 40.0)]
        {
            let other = cut(&egg(160, 120, centre, scale, ground), 64);
            let apart: f32 = first.pixels().iter().zip(other.pixels()).map(|(a, b)| (a - b).abs()).sum();
            let all: f32 = first.pixels().iter().sum();
            assert!(apart < 0.05 * all, "{centre:?} {scale}: {}", apart / all);
        }
    }

    #[test]
    fn the_object_fills_the_square_by_its_moments() {
        for side_px in [32, 64, 200] {
            let image = cut(&egg(160, 120, [80.0, 60.0], 1.5, 20.0), side_px);
            let lit: Vec<usize> = (0..side_px).filter(|&x| image.at(x, side_px / 2) > 50.0).collect();
            let part = (lit[lit.len() - 1] - lit[0] + 1) as f64 / side_px as f64;
            // Of an ellipse: half axes a and b, and (a² + b²)/4 for the square of the distance.
            let expected = 20.0 / (MARGIN_FACTOR * (20_f64.powi(2) + 12_f64.powi(2)).sqrt() / 2.0);
            assert!((part - expected).abs() < 0.05, "{side_px}: {part}, not {expected}");
            assert_eq!(image.at(0, 0), 0.0);
        }
    }

    #[test]
    fn a_dark_object_on_a_light_background_is_cropped_too() {
        let light = egg(160, 120, [70.0, 60.0], 1.5, 20.0);
        let dark = Image::new(160, 120, light.pixels().iter().map(|v| 250.0 - v).collect());
        let negative = Image::new(160, 120, dark.pixels().iter().map(|v| 255.0 - v).collect());
        let (dark, negative) = (cut(&dark, 64), cut(&negative, 64));
        assert_eq!(dark.at(2, 2), 0.0);
        assert!((100.0..200.0).contains(&dark.at(32, 32)));
        assert!(dark.pixels().iter().zip(negative.pixels()).all(|(a, b)| (a - b).abs() < 1e-3));
    }

    #[test]
    fn a_background_that_is_brighter_in_the_middle_is_no_object() {
        let image = Image::from_fn(160, 120, |x, y| {
            let off = (x as f64 - 80.0).hypot(y as f64 - 60.0);
            if off < 28.0 { 60.0 } else { (205.0 - 0.35 * off) as f32 }
        });
        let object = ObjectSegmentation::of(&image);
        assert_eq!(object.segmentation.regions.len(), 1);
        assert!(object.segmentation.regions[0].is_darker);
        let area = object.segmentation.regions[0].area_px as f64;
        assert!((area / 2463.0 - 1.0).abs() < 0.03, "{area}");
    }

    #[test]
    fn a_large_region_is_averaged_not_sampled() {
        let striped = Image::from_fn(900, 900, |x, y| {
            let inside = (x as f64 - 450.0).hypot(y as f64 - 450.0) < 400.0;
            match inside {
                true if (x + y) % 2 == 0 => 180.0,
                true => 100.0,
                false => 20.0,
            }
        });
        let image = cut(&striped, 32);
        for (x, y) in [(16, 16), (12, 18), (20, 14)] {
            assert!((image.at(x, y) - 140.0).abs() < 2.0, "{}", image.at(x, y));
        }
    }

    #[test]
    fn two_objects_are_several_regions_and_a_speck_is_not() {
        let beside = |radius: f64| {
            let mut image = egg(160, 120, [50.0, 60.0], 1.5, 20.0);
            for y in 0..120 {
                for x in 0..160 {
                    if (x as f64 - 125.0).hypot(y as f64 - 60.0) < radius {
                        image.pixels_mut()[y * 160 + x] = 180.0;
                    }
                }
            }
            ObjectSegmentation::of(&image).several_regions
        };
        assert!(beside(25.0) && !beside(6.0));
    }
}
