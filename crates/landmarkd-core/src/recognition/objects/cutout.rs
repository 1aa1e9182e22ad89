//! The recipe by which a region becomes a picture like those that a database is trained with (B§3): background to zero,
//! centred, scaled to the database's size.
//!
//! The text centres the region and normalises its size, and leaves open by what. Here it is by the moments of the
//! region's light, not by its outermost pixels: those come and go with the threshold where an object is as dark as the
//! table, and move the whole picture with them. Measured: see `docs/papers.md`. What is dark on a light ground is taken
//! as its negative, so that the background is zero in either case.

use crate::imaging::Image;
use crate::vision::segmentation::{Polarity, Region, Segmentation, SegmentationOptions, segmented_from_near};
use crate::vision::smoothed;

/// Half the square's side by the root mean square distance of the light from its centroid. A disc reaches to √2, a
/// bar to √3.
const ROOM: f64 = 1.87;
/// The brightest grey level.
const WHITE: f32 = 255.0;
/// Beyond this distance from the ground's level, in grey levels, a pixel tells whether the object is light or dark.
const APART: f32 = 10.0;
/// Another region of this part of the largest one's area is another object.
const ANOTHER: f64 = 0.5;

/// The one object that a picture shows.
pub(super) struct Sole {
    pub segmentation: Segmentation,
    /// Whether another region is nearly as large.
    pub crowded: bool,
}

impl Sole {
    /// What stands out of a picture of one object, by options that follow from the picture: its border is mostly
    /// ground, and most of what differs from that is the object.
    pub fn of(luminance: &Image) -> Sole {
        let (width, height) = (luminance.width(), luminance.height());
        let border = (0..width * height).filter(|at| {
            let (x, y) = (at % width, at / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        });
        let mut border: Vec<f32> = border.map(|at| luminance.pixels()[at]).collect();
        border.sort_by(f32::total_cmp);
        let ground = border.get(border.len() / 2).copied().unwrap_or(0.0);
        // By how much, not by how many: a ground that is a little brighter in the middle is no object.
        let beyond = |side: f32| {
            let off = luminance.pixels().iter().map(|v| side * (v - ground)).filter(|&off| off > APART);
            off.map(f64::from).sum::<f64>()
        };
        let polarity =
            if beyond(1.0) >= beyond(-1.0) { Polarity::LightOnDark } else { Polarity::DarkOnLight };
        let options = SegmentationOptions { polarity, ..SegmentationOptions::default() };
        let segmentation = segmented_from_near(luminance, &options);
        let area = |at: usize| segmentation.regions.get(at).map_or(0.0, |region| region.area_px as f64);
        let crowded = area(1) > ANOTHER * area(0);
        Sole { segmentation, crowded }
    }
}

/// A region on black, the centroid of its light in the middle of `width_px` × `height_px` pixels.
///
/// The work is in proportion to the region's area, not to that of its box: a thin ring may be as wide as the picture.
pub(super) fn cutout(
    luminance: &Image,
    segmentation: &Segmentation,
    region: &Region,
    (width_px, height_px): (usize, usize),
) -> Image {
    let Some(([centre_x, centre_y], radius)) = moments(luminance, segmentation, region) else {
        return Image::from_fn(width_px, height_px, |_, _| 0.0);
    };
    // B§3, normalisation: pixels of the picture to one of the cutout.
    let step = 2.0 * ROOM * radius / width_px.min(height_px) as f64;
    // What a coarser grid can't show is averaged away first: in whole squares of pixels, and the rest by a Gaussian,
    // which spreads beyond the box.
    let square = (step as usize).max(1);
    let step = step / square as f64;
    let sigma_px = if step > 1.0 { 0.5 * (step * step - 1.0).sqrt() } else { 0.0 };
    let margin = (3.0 * sigma_px).ceil() as usize + 2;
    let bounds = region.bbox_px;
    let [columns, rows] = [bounds.width, bounds.height].map(|side| side.div_ceil(square) + 2 * margin);
    let mut averaged = Image::from_fn(columns, rows, |_, _| 0.0);
    let share = 1.0 / (square * square) as f32;
    for (row, column, light) in lights(luminance, segmentation, region) {
        let (x, y) = ((column - bounds.x) / square + margin, (row - bounds.y) / square + margin);
        averaged.pixels_mut()[y * columns + x] += share * light;
    }
    let averaged = smoothed(&averaged, sigma_px as f32);
    // A place of the picture on the grid of squares.
    let on_grid =
        |place: f64, first: usize| (place - first as f64 + 0.5) / square as f64 - 0.5 + margin as f64;
    let (centre_x, centre_y) = (on_grid(centre_x, bounds.x), on_grid(centre_y, bounds.y));
    let middle = [width_px, height_px].map(|side| (side as f64 - 1.0) / 2.0);
    Image::from_fn(width_px, height_px, |x, y| {
        let from_x = centre_x + (x as f64 - middle[0]) * step;
        let from_y = centre_y + (y as f64 - middle[1]) * step;
        bilinear(&averaged, from_x, from_y)
    })
}

/// Row, column and light of each pixel of a region.
fn lights(
    luminance: &Image,
    segmentation: &Segmentation,
    region: &Region,
) -> impl Iterator<Item = (usize, usize, f32)> {
    let is_negative = segmentation.polarity() == Polarity::DarkOnLight;
    segmentation.runs(region).flat_map(move |(row, columns)| {
        let levels = &luminance.row(row)[columns.clone()];
        columns.zip(levels).map(move |(x, &v)| (row, x, if is_negative { WHITE - v } else { v }))
    })
}

/// The centroid of a region's light, and the root mean square distance from it, in pixels; `None` for a black one.
fn moments(luminance: &Image, segmentation: &Segmentation, region: &Region) -> Option<([f64; 2], f64)> {
    let (mut all, mut x_sum, mut y_sum, mut squares) = (0.0, 0.0, 0.0, 0.0);
    let [middle_x, middle_y] = region.centroid_px;
    for (row, column, light) in lights(luminance, segmentation, region) {
        let (x, y, light) = (column as f64 - middle_x, row as f64 - middle_y, f64::from(light));
        all += light;
        x_sum += light * x;
        y_sum += light * y;
        squares += light * (x * x + y * y);
    }
    let (x, y) = (x_sum / all, y_sum / all);
    // A pixel is a square of second moment 1/12 along each axis, not a point.
    let radius = (squares / all - x * x - y * y + 1.0 / 6.0).sqrt();
    (all > 0.0).then_some(([middle_x + x, middle_y + y], radius))
}

/// Part of a region's pixels that are as bright as can be, from a grey level on.
pub(super) fn glare(luminance: &Image, segmentation: &Segmentation, region: &Region, from: f32) -> f64 {
    let levels = segmentation.runs(region).flat_map(|(row, columns)| &luminance.row(row)[columns]);
    levels.filter(|&&v| v >= from).count() as f64 / region.area_px as f64
}

/// Between pixels; black outside.
fn bilinear(image: &Image, x: f64, y: f64) -> f32 {
    let (left, top) = (x.floor(), y.floor());
    if left < 0.0 || top < 0.0 || left + 1.0 >= image.width() as f64 || top + 1.0 >= image.height() as f64 {
        return 0.0;
    }
    let (right_part, lower_part) = ((x - left) as f32, (y - top) as f32);
    let (left, top) = (left as usize, top as usize);
    let upper = image.at(left, top) * (1.0 - right_part) + image.at(left + 1, top) * right_part;
    let lower = image.at(left, top + 1) * (1.0 - right_part) + image.at(left + 1, top + 1) * right_part;
    upper * (1.0 - lower_part) + lower * lower_part
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
        let sole = Sole::of(image);
        cutout(image, &sole.segmentation, &sole.segmentation.regions[0], (side_px, side_px))
    }

    #[test]
    fn place_size_and_ground_do_not_matter() {
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
            let expected = 20.0 / (ROOM * (20_f64.powi(2) + 12_f64.powi(2)).sqrt() / 2.0);
            assert!((part - expected).abs() < 0.05, "{side_px}: {part}, not {expected}");
            assert_eq!(image.at(0, 0), 0.0);
        }
    }

    #[test]
    fn a_dark_object_on_a_light_ground_is_cut_out_too() {
        let light = egg(160, 120, [70.0, 60.0], 1.5, 20.0);
        let dark = Image::new(160, 120, light.pixels().iter().map(|v| 250.0 - v).collect());
        let negative = Image::new(160, 120, dark.pixels().iter().map(|v| 255.0 - v).collect());
        let (dark, negative) = (cut(&dark, 64), cut(&negative, 64));
        assert_eq!(dark.at(2, 2), 0.0);
        assert!((100.0..200.0).contains(&dark.at(32, 32)));
        assert!(dark.pixels().iter().zip(negative.pixels()).all(|(a, b)| (a - b).abs() < 1e-3));
    }

    #[test]
    fn a_ground_that_is_brighter_in_the_middle_is_no_object() {
        let image = Image::from_fn(160, 120, |x, y| {
            let off = (x as f64 - 80.0).hypot(y as f64 - 60.0);
            if off < 28.0 { 60.0 } else { (205.0 - 0.35 * off) as f32 }
        });
        let sole = Sole::of(&image);
        assert_eq!(sole.segmentation.polarity(), Polarity::DarkOnLight);
        assert_eq!(sole.segmentation.regions.len(), 1);
        let area = sole.segmentation.regions[0].area_px as f64;
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
    fn two_objects_are_a_crowd_and_a_speck_is_not() {
        let beside = |radius: f64| {
            let mut image = egg(160, 120, [50.0, 60.0], 1.5, 20.0);
            for y in 0..120 {
                for x in 0..160 {
                    if (x as f64 - 125.0).hypot(y as f64 - 60.0) < radius {
                        image.pixels_mut()[y * 160 + x] = 180.0;
                    }
                }
            }
            Sole::of(&image).crowded
        };
        assert!(beside(25.0) && !beside(6.0));
    }
}
