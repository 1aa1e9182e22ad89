//! Segmentation (B§3): threshold, connected components, and the properties of each region.
//!
//! Pixels as everywhere: x right, y down, the origin at the centre of the top-left one. Angles turn x towards y.

mod background;
mod components;
mod foreground;
mod holes;
mod options;
mod region;

use components::{Run, Touching, components};
use foreground::{Foreground, otsu_level};
use holes::fill_dark_holes;
use options::MAX_WINDOW_PX;
pub use options::{MAX_OBJECTS, Polarity, SegmentationOptions, Threshold};
use region::Sums;
pub use region::{BoundingBox, Region};

use std::ops::Range;

use crate::imaging::Image;

/// A region's least area is this part of the picture, if it is chosen, and at least so many pixels.
const SMALLEST_PART: usize = 500;
const SMALLEST_PX: usize = 16;
/// The brightest gray level.
const WHITE: f32 = 255.0;

/// A picture divided into regions and background.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    width: usize,
    height: usize,
    polarity: Polarity,
    labels: Vec<u16>,
    /// Region by region.
    runs: Vec<Run>,
    /// Where the runs of each region end.
    ends: Vec<usize>,
    /// The largest first; the region at `k` has the id k + 1.
    pub regions: Vec<Region>,
    /// Regions of at least the least area, also those beyond the most objects.
    pub found: usize,
}

impl Segmentation {
    /// Width of the picture in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height of the picture in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether the regions are light or dark.
    pub fn polarity(&self) -> Polarity {
        self.polarity
    }

    /// Id of the region of each pixel, row-major; 0 is background.
    pub fn labels(&self) -> &[u16] {
        &self.labels
    }

    /// The region of that id.
    pub fn region(&self, id: usize) -> Option<&Region> {
        self.regions.get(id.checked_sub(1)?)
    }

    /// Row and columns of the pixels of a region, run by run.
    pub fn runs(&self, region: &Region) -> impl Iterator<Item = (usize, Range<usize>)> + Clone {
        let start = region.id.checked_sub(2).map_or(0, |before| self.ends[before]);
        self.runs[start..self.ends[region.id - 1]].iter().map(|run| (run.row(), run.columns()))
    }

    /// The picture's middle, x and y.
    pub fn middle_px(&self) -> [f64; 2] {
        [self.width, self.height].map(|side| (side as f64 - 1.0) / 2.0)
    }

    /// The region whose centroid is nearest to the picture's middle; none without regions.
    pub fn central(&self) -> Option<&Region> {
        let [x, y] = self.middle_px();
        let off = |region: &Region| (region.centroid_px[0] - x).hypot(region.centroid_px[1] - y);
        self.regions.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }
}

/// The regions of a picture's luminance, with options that have no faults.
pub fn segmented(luminance: &Image, options: &SegmentationOptions) -> Segmentation {
    let (width, height) = (luminance.width(), luminance.height());
    let smallest_px =
        options.min_area_px.unwrap_or_else(|| (width * height / SMALLEST_PART).max(SMALLEST_PX));
    let mask = mask(luminance, options, smallest_px); // B§3, threshold
    let (mut runs, count) = components(&mask, width, Touching::Corners); // B§3, labelling
    let (ids, found) = ids_by_area(&runs, count, smallest_px, options.max_objects);
    let id = |run: &Run| usize::from(ids[run.component()]);
    runs.retain(|run| id(run) != 0);
    runs.sort_by_key(id);
    let mut labels = vec![0; width * height];
    let (mut ends, mut regions) = (Vec::new(), Vec::new());
    for runs in runs.chunk_by(|a, b| a.component() == b.component()) {
        let mut sums = Sums::NONE;
        for run in runs {
            sums.add(run);
            labels[run.row() * width..][run.columns()].fill(ids[run.component()]);
        }
        ends.push(ends.last().copied().unwrap_or(0) + runs.len());
        regions.push(sums.region(ends.len(), width, height)); // B§3, centroid
    }
    Segmentation { width, height, polarity: options.polarity, labels, runs, ends, regions, found }
}

/// The id of each component, from 1 for the largest on; 0 for those too small and those beyond `most`. And how many are
/// large enough.
fn ids_by_area(runs: &[Run], count: usize, smallest_px: usize, most: usize) -> (Vec<u16>, usize) {
    let mut areas = vec![0_u32; count];
    runs.iter().for_each(|run| areas[run.component()] += run.columns().len() as u32);
    let mut largest: Vec<usize> = (0..count).filter(|&c| areas[c] as usize >= smallest_px).collect();
    largest.sort_by_key(|&component| std::cmp::Reverse(areas[component])); // stable
    let mut ids = vec![0_u16; count];
    for (component, id) in largest.iter().take(most).zip(1..) {
        ids[*component] = id;
    }
    (ids, largest.len())
}

/// The regions of a picture that an object may fill most of: unless a window is given, the background is estimated in
/// squares of the picture's shorter side.
pub fn segmented_from_near(luminance: &Image, options: &SegmentationOptions) -> Segmentation {
    let shorter_px = luminance.width().min(luminance.height()).clamp(3, MAX_WINDOW_PX);
    segmented(
        luminance,
        &SegmentationOptions { window_px: options.window_px.or(Some(shorter_px)), ..options.clone() },
    )
}

/// 1 in the foreground, else 0.
fn mask(luminance: &Image, options: &SegmentationOptions, smallest_px: usize) -> Vec<u8> {
    let width = luminance.width();
    let negative: Vec<f32>;
    let levels = match options.polarity {
        Polarity::LightOnDark => luminance.pixels(),
        Polarity::DarkOnLight => {
            negative = luminance.pixels().iter().map(|v| WHITE - v).collect();
            &negative
        }
    };
    let beyond = |level: f32| levels.iter().map(|&v| u8::from(v > level)).collect();
    match (options.threshold, options.polarity) {
        (Threshold::Adaptive, _) => {
            let foreground = Foreground::of(levels, width, options);
            let stands_out = foreground.above.iter().map(|&v| u8::from(v > foreground.offset));
            let mut mask: Vec<u8> = stands_out.collect();
            // Against one level for the whole picture a shaded table would be dark, too.
            fill_dark_holes(&mut mask, width, &foreground, smallest_px);
            mask
        }
        (Threshold::Otsu, _) => beyond(otsu_level(levels)),
        (Threshold::Fixed(level), Polarity::LightOnDark) => beyond(level as f32),
        (Threshold::Fixed(level), Polarity::DarkOnLight) => beyond(WHITE - level as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dark, shaded table of 200 × 150 pixels with things on it.
    fn table(things: &[&dyn Fn(f64, f64) -> bool]) -> Image {
        Image::from_fn(200, 150, |x, y| {
            let (at_x, at_y) = (x as f64, y as f64);
            let shade = 1.0 - 0.4 * at_x / 200.0;
            let noise = ((x * 37 + y * 101) % 7) as f64 - 3.0;
            let light = if things.iter().any(|thing| thing(at_x, at_y)) { 140.0 } else { 25.0 };
            (light * shade + noise) as f32
        })
    }

    fn disc(x: f64, y: f64, radius: f64) -> impl Fn(f64, f64) -> bool {
        move |at_x, at_y| (at_x - x).hypot(at_y - y) <= radius
    }

    /// A bar whose long axis is turned from x towards y.
    fn bar(x: f64, y: f64, length: f64, breadth: f64, turn_deg: f64) -> impl Fn(f64, f64) -> bool {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        move |at_x, at_y| {
            let (dx, dy) = (at_x - x, at_y - y);
            (cos * dx + sin * dy).abs() <= length / 2.0 && (cos * dy - sin * dx).abs() <= breadth / 2.0
        }
    }

    #[test]
    fn parts_are_found_the_largest_first_with_their_centroids() {
        let (large, small, rod) =
            (disc(60.0, 50.0, 25.0), disc(150.3, 30.6, 12.0), bar(140.0, 105.0, 60.0, 12.0, 30.0));
        let seen = segmented(&table(&[&large, &small, &rod]), &SegmentationOptions::default());
        assert_eq!((seen.regions.len(), seen.found), (3, 3));
        let truths = [(60.0, 50.0, 1963.5), (140.0, 105.0, 720.0), (150.3, 30.6, 452.4)];
        for (region, (x, y, area)) in seen.regions.iter().zip(truths) {
            let off = (region.centroid_px[0] - x).hypot(region.centroid_px[1] - y);
            assert!(off < 0.3, "{region:?}");
            assert!((region.area_px as f64 / area - 1.0).abs() < 0.03, "{region:?}");
            assert!(!region.touches_border);
            let [x, y] = [x as usize, y as usize];
            assert_eq!(usize::from(seen.labels()[y * 200 + x]), region.id);
            let own = seen.runs(region).flat_map(|(row, columns)| columns.map(move |x| row * 200 + x));
            assert!(own.clone().all(|at| usize::from(seen.labels()[at]) == region.id));
            assert_eq!(own.count(), region.area_px);
        }
        assert_eq!(seen.labels()[0], 0);
        let rod = &seen.regions[1];
        assert!(
            (rod.orientation_deg.unwrap() - 30.0).abs() < 1.0 && (rod.elongation - 5.0).abs() < 0.3,
            "{rod:?}"
        );
        assert_eq!(seen.regions[0].orientation_deg, None);
        assert_eq!(seen.central().unwrap().id, 1);
        assert_eq!(seen.region(3), Some(&seen.regions[2]));
        assert_eq!((seen.region(0), seen.region(4)), (None, None));
    }

    #[test]
    fn the_axis_turns_from_x_towards_y() {
        for turn_deg in [-80.0, -45.0, -10.0, 0.0, 25.0, 60.0, 88.0] {
            let rod = bar(100.0, 75.0, 90.0, 20.0, turn_deg);
            let seen = segmented(&table(&[&rod]), &SegmentationOptions::default());
            let found = seen.regions[0].orientation_deg.unwrap();
            assert!((found - turn_deg).abs() < 0.7, "{found}, not {turn_deg}");
        }
        let upright =
            segmented(&table(&[&bar(100.0, 75.0, 90.0, 20.0, 90.0)]), &SegmentationOptions::default());
        let found = upright.regions[0].orientation_deg.unwrap();
        assert!((-90.0..90.0).contains(&found) && found.abs() > 89.0, "{found}");
    }

    #[test]
    fn dark_parts_on_a_light_table_are_the_same_the_other_way_round() {
        let (a, b) = (disc(60.0, 50.0, 25.0), disc(150.0, 100.0, 12.0));
        let light = table(&[&a, &b]);
        let dark = Image::new(200, 150, light.pixels().iter().map(|v| 255.0 - v).collect());
        for threshold in [Threshold::Adaptive, Threshold::Otsu, Threshold::Fixed(60.0)] {
            let options = SegmentationOptions { threshold, ..SegmentationOptions::default() };
            let inverse = match threshold {
                Threshold::Fixed(level) => Threshold::Fixed(255.0 - level),
                other => other,
            };
            let other_way = SegmentationOptions {
                threshold: inverse,
                polarity: Polarity::DarkOnLight,
                ..options.clone()
            };
            let (seen, other) = (segmented(&light, &options), segmented(&dark, &other_way));
            assert_eq!(seen.regions.len(), 2, "{threshold:?}");
            assert_eq!(seen.polarity(), Polarity::LightOnDark);
            assert_eq!(other.polarity(), Polarity::DarkOnLight);
            assert_eq!((seen.regions, seen.labels), (other.regions, other.labels), "{threshold:?}");
        }
    }

    #[test]
    fn a_fixed_level_is_background_itself() {
        let picture = Image::new(5, 1, vec![0.0, 98.0, 99.0, 100.0, 200.0]);
        let fixed = |polarity| SegmentationOptions {
            threshold: Threshold::Fixed(99.0),
            polarity,
            min_area_px: Some(1),
            ..SegmentationOptions::default()
        };
        assert_eq!(segmented(&picture, &fixed(Polarity::LightOnDark)).labels(), [0, 0, 0, 1, 1]);
        assert_eq!(segmented(&picture, &fixed(Polarity::DarkOnLight)).labels(), [1, 1, 0, 0, 0]);
    }

    #[test]
    fn a_part_at_the_border_says_so() {
        let seen = segmented(
            &table(&[&disc(195.0, 60.0, 20.0), &disc(60.0, 60.0, 15.0)]),
            &SegmentationOptions::default(),
        );
        let touching: Vec<bool> = seen.regions.iter().map(|region| region.touches_border).collect();
        assert_eq!(touching, [true, false]);
        let bounds = seen.regions[0].bbox_px;
        assert_eq!((bounds.x + bounds.width, bounds.y, bounds.height), (200, 40, 41));
    }

    #[test]
    fn specks_are_left_out_and_no_more_is_told_than_asked_for() {
        let specks = |x: f64, y: f64| x % 10.0 < 3.0 && y % 10.0 < 3.0;
        let picture = table(&[&specks]);
        let seen = segmented(&picture, &SegmentationOptions::default());
        assert_eq!((seen.regions.len(), seen.found), (0, 0));
        assert!(seen.central().is_none() && seen.labels().iter().all(|&id| id == 0));
        let fine =
            SegmentationOptions { min_area_px: Some(1), max_objects: 7, ..SegmentationOptions::default() };
        let seen = segmented(&picture, &fine);
        assert_eq!((seen.regions.len(), seen.found), (7, 300));
        assert_eq!(seen.labels().iter().max(), Some(&7));
    }

    #[test]
    fn flat_and_empty_pictures_have_no_region() {
        for threshold in [Threshold::Adaptive, Threshold::Otsu, Threshold::Fixed(255.0)] {
            let options =
                SegmentationOptions { threshold, min_area_px: Some(1), ..SegmentationOptions::default() };
            for (width, height) in [(0, 0), (1, 1), (1, 40), (64, 48)] {
                for level in [0.0, 128.0, 255.0] {
                    let flat = Image::from_fn(width, height, |_, _| level);
                    assert_eq!(
                        segmented(&flat, &options).found,
                        0,
                        "{threshold:?} {width}×{height} of {level}"
                    );
                }
            }
        }
    }
}
