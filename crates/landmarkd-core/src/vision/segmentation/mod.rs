//! Segmentation (B§3): threshold, connected components, and the properties of each region.
//!
//! Pixels as everywhere: x right, y down, the origin at the centre of the top-left one. Angles turn x towards y.

mod blocks;
mod components;
mod distance_map;
mod foreground;
mod ground;
mod holes;
mod lines;
mod options;
mod region;
mod shadows;
mod touching;

use components::{Run, Touching, area_px, by_component, components, kept};
pub use foreground::Noise;
use foreground::{Foreground, otsu_level};
use holes::over_square;
use lines::without_lines;
use options::MAX_WINDOW_PX;
pub use options::{MAX_OBJECTS, Polarity, SegmentationOptions, Threshold};
use region::Sums;
pub use region::{BoundingBox, Piece, Region};
pub use shadows::Shadows;
use touching::{Reading, reading};

use std::cmp::Reverse;
use std::ops::Range;

use crate::imaging::{Frame, Image};

/// With one level for the picture the noise isn't known: a region's least area is this part of the picture, if it is
/// chosen, and at least so many pixels.
const SMALLEST_PART: usize = 500;
const SMALLEST_PX: usize = 16;
/// A region differs from the ground by so many offsets in the mean: what hardly reaches the offset anywhere is texture.
const LEAST_EXCESS: f32 = 1.3;
/// A fragment has less than this part of the area of what it lies beside, with twice so many pixels between them at most.
const FRAGMENT_PART: f64 = 0.05;
const FRAGMENT_REACH_PX: usize = 3;
/// The brightest gray level.
const WHITE: f32 = 255.0;

/// A picture divided into regions and background.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmentation {
    width: usize,
    height: usize,
    labels: Vec<u16>,
    /// Region by region.
    runs: Vec<Run>,
    /// Where the runs of each region end.
    ends: Vec<usize>,
    /// The largest first; the region at `k` has the id k + 1.
    pub regions: Vec<Region>,
    /// Regions of at least the least area, also those beyond the most objects.
    pub found: usize,
    /// What was left out of the regions.
    pub left_out: LeftOut,
    /// Of the ground; `None` if one level divides the picture.
    pub noise: Option<Noise>,
}

/// What differs from the ground and is no region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// The least area of a region, given or chosen.
    pub least_area_px: usize,
    /// Components below the least area.
    pub small: usize,
    /// The areas of the largest of them, descending, at most [`LeftOut::MOST_AREAS`].
    pub small_areas_px: Vec<usize>,
    /// Lines that lead out of the picture on both sides.
    pub lines: usize,
    /// Shadows.
    pub shadows: Shadows,
}

impl LeftOut {
    /// The most areas that are listed.
    pub const MOST_AREAS: usize = 20;
}

/// The planes of a picture: luminance, and colour if it has any.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Gray levels.
    pub luminance: &'a Image,
    /// Red, green and blue.
    pub rgb: Option<&'a [Image; 3]>,
}

impl<'a> From<&'a Image> for Picture<'a> {
    fn from(luminance: &'a Image) -> Self {
        Picture { luminance, rgb: None }
    }
}

impl<'a> From<&'a Frame> for Picture<'a> {
    fn from(frame: &'a Frame) -> Self {
        Picture { luminance: &frame.luminance, rgb: frame.rgb.as_ref() }
    }
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

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scene {
    /// Parts on a ground that most of the picture shows: some may touch, and lines may be drawn on it.
    Table,
    /// An object that may fill most of it.
    OneObject,
}

/// The regions of a picture, with options that have no faults.
pub fn segmented<'a>(picture: impl Into<Picture<'a>>, options: &SegmentationOptions) -> Segmentation {
    regions(picture.into(), options, Scene::Table)
}

fn regions(picture: Picture, options: &SegmentationOptions, scene: Scene) -> Segmentation {
    let (width, height) = (picture.luminance.width(), picture.luminance.height());
    let Told { components, above, shadows, noise } = told(picture, options, scene); // B§3, threshold and labelling
    let of_noise = noise.map(|noise| noise.least_area_px);
    let least_area_px =
        options.min_area_px.or(of_noise).unwrap_or((width * height / SMALLEST_PART).max(SMALLEST_PX));
    let mut left_out = LeftOut { least_area_px, shadows, ..LeftOut::default() };
    let is_table = scene == Scene::Table && options.threshold == Threshold::Adaptive;
    let mut parts = parts(components, (width, height), is_table, &mut left_out);
    let found = parts.len();
    parts.sort_by_key(|part| Reverse(area_px(&part.runs))); // stable
    parts.truncate(options.max_objects);
    let mut segmentation = Segmentation {
        width,
        height,
        labels: vec![0; width * height],
        runs: Vec::new(),
        ends: Vec::new(),
        regions: Vec::new(),
        found,
        left_out,
        noise,
    };
    parts.into_iter().for_each(|part| segmentation.add(part, &above));
    segmentation
}

/// The runs of a region.
struct Part {
    runs: Vec<Run>,
    /// If it may be several: their runs.
    pieces: Vec<Vec<Run>>,
}

/// The components that are parts: large enough, and of a table without lines, and divided where several touch.
fn parts(
    components: Vec<Vec<Run>>,
    (width, height): (usize, usize),
    is_table: bool,
    left_out: &mut LeftOut,
) -> Vec<Part> {
    let mut parts = Vec::new();
    let (large, small): (Vec<_>, Vec<_>) =
        components.into_iter().partition(|runs| area_px(runs) >= left_out.least_area_px);
    for component in large {
        if !is_table {
            parts.push(Part { runs: component, pieces: vec![] });
            continue;
        }
        let rest = without_lines(&component, width, height);
        left_out.lines += usize::from(rest.is_some());
        for runs in rest.unwrap_or_else(|| vec![component]) {
            if area_px(&runs) < left_out.least_area_px {
                continue;
            }
            match reading(&runs) {
                Reading::One => parts.push(Part { runs, pieces: vec![] }),
                Reading::Unclear(pieces) => parts.push(Part { runs, pieces }),
                Reading::Several(pieces) => {
                    parts.extend(pieces.into_iter().map(|runs| Part { runs, pieces: vec![] }));
                }
            }
        }
    }
    left_out.small = small.len();
    left_out.small_areas_px = small.iter().map(|runs| area_px(runs)).collect();
    left_out.small_areas_px.sort_unstable_by_key(|&area| Reverse(area));
    left_out.small_areas_px.truncate(LeftOut::MOST_AREAS);
    parts
}

impl Segmentation {
    /// Add a region. `above` is by how much each pixel is above its ground.
    fn add(&mut self, part: Part, above: &[f32]) {
        let id = self.regions.len() + 1;
        for run in &part.runs {
            self.labels[run.row() * self.width..][run.columns()].fill(id as u16);
        }
        self.ends.push(self.runs.len() + part.runs.len());
        let above =
            part.runs.iter().map(|run| above[run.row() * self.width..][run.columns()].iter().sum::<f32>());
        self.regions.push(Region {
            is_darker: above.sum::<f32>() < 0.0,
            pieces: part.pieces.iter().map(|runs| Sums::of(runs).piece()).collect(),
            ..Sums::of(&part.runs).region(id, self.width, self.height) // B§3, centroid
        });
        self.runs.extend(part.runs);
    }
}

/// The regions of a picture that one object may fill most of: unless a window is given, the background is estimated in
/// squares of the picture's shorter side; nothing is taken for a line or for several parts.
pub fn segmented_from_near<'a>(
    picture: impl Into<Picture<'a>>,
    options: &SegmentationOptions,
) -> Segmentation {
    let picture = picture.into();
    let shorter_px = picture.luminance.width().min(picture.luminance.height()).clamp(3, MAX_WINDOW_PX);
    let options =
        SegmentationOptions { window_px: options.window_px.or(Some(shorter_px)), ..options.clone() };
    regions(picture, &options, Scene::OneObject)
}

/// What is told from the background.
struct Told {
    components: Vec<Vec<Run>>,
    /// By how much each pixel is above its background.
    above: Vec<f32>,
    shadows: Shadows,
    noise: Option<Noise>,
}

fn told(picture: Picture, options: &SegmentationOptions, scene: Scene) -> Told {
    let width = picture.luminance.width();
    if options.threshold != Threshold::Adaptive {
        let (mask, above) = divided(picture.luminance, options);
        let (runs, count) = components(&mask, width, Touching::Corners);
        let components = by_component(runs.into_iter(), count);
        return Told { components, above, shadows: Shadows::default(), noise: None };
    }
    let Foreground { mask, core, excess, above, shadows, noise } = Foreground::of(picture, options, scene);
    let (runs, count) = components(&mask, width, Touching::Corners);
    let mut sums = vec![(0.0, 0); count];
    for run in &runs {
        let (sum, pixels) = &mut sums[run.component()];
        *sum += excess[run.row() * width..][run.columns()].iter().sum::<f32>();
        *pixels += run.columns().len();
    }
    let is_clear = |run: &Run| {
        let (sum, pixels) = sums[run.component()];
        sum > LEAST_EXCESS * pixels as f32
    };
    let runs = kept(&runs, &core, width);
    let mut components = by_component(runs.into_iter().filter(is_clear), count);
    join_fragments(&mut components, &mask, width, noise.least_area_px);
    Told { components, above, shadows, noise: Some(noise) }
}

/// Join fragments to the part that they lie beside: a dark place between them was taken for ground. Components below
/// `least_px` are specks.
fn join_fragments(components: &mut Vec<Vec<Run>>, mask: &[u8], width: usize, least_px: usize) {
    let most = components.iter().map(|runs| area_px(runs)).max().unwrap_or(0);
    let is_fragment = |area: usize, of: usize| area >= least_px && (area as f64) < FRAGMENT_PART * of as f64;
    if !components.iter().any(|runs| is_fragment(area_px(runs), most)) {
        return;
    }
    let near = over_square(mask, width, FRAGMENT_REACH_PX, |a, b| a | b);
    let (runs, count) = self::components::components(&near, width, Touching::Corners);
    let mut neighbourhoods = vec![u32::MAX; mask.len()];
    for run in &runs {
        neighbourhoods[run.row() * width..][run.columns()].fill(run.component() as u32);
    }
    let neighbourhood =
        |runs: &[Run]| neighbourhoods[runs[0].row() * width + runs[0].columns().start] as usize;
    let mut largest: Vec<Option<usize>> = vec![None; count];
    for (k, runs) in components.iter().enumerate() {
        let largest = &mut largest[neighbourhood(runs)];
        if largest.is_none_or(|other| area_px(&components[other]) < area_px(runs)) {
            *largest = Some(k);
        }
    }
    for k in 0..components.len() {
        let Some(to) = largest[neighbourhood(&components[k])].filter(|to| *to != k) else { continue };
        if is_fragment(area_px(&components[k]), area_px(&components[to])) {
            let fragment = std::mem::take(&mut components[k]);
            components[to].extend(fragment);
            components[to].sort_by_key(|run| (run.row(), run.columns().start));
        }
    }
    components.retain(|runs| !runs.is_empty());
}

/// A picture divided by one level: 1 in the foreground, else 0; and by how much each pixel is above the level.
fn divided(luminance: &Image, options: &SegmentationOptions) -> (Vec<u8>, Vec<f32>) {
    let levels = luminance.pixels();
    let (level, is_dark) = match (options.threshold, options.polarity) {
        (Threshold::Fixed(level), Polarity::DarkOnLight) => (level as f32, true),
        (Threshold::Fixed(level), Polarity::LightOnDark) => (level as f32, false),
        (Threshold::Fixed(level), Polarity::Either) => {
            (level as f32, luminance.border_median() > level as f32)
        }
        (_, Polarity::LightOnDark) => (otsu_level(levels), false),
        (_, Polarity::DarkOnLight) => (otsu_level_of_negative(levels), true),
        (_, Polarity::Either) => match otsu_level(levels) {
            // What most of the border shows is ground.
            level if luminance.border_median() > level => (otsu_level_of_negative(levels), true),
            level => (level, false),
        },
    };
    let is_part = |v: f32| if is_dark { v < level } else { v > level };
    let mask = levels.iter().map(|&v| u8::from(is_part(v))).collect();
    (mask, levels.iter().map(|v| v - level).collect())
}

/// Of dark objects: "at least" is background.
fn otsu_level_of_negative(levels: &[f32]) -> f32 {
    let negative: Vec<f32> = levels.iter().map(|v| WHITE - v).collect();
    WHITE - otsu_level(&negative)
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
            let polarity = Polarity::LightOnDark;
            let options = SegmentationOptions { threshold, polarity, ..SegmentationOptions::default() };
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
            let lighter: Vec<Region> = (other.regions.iter().cloned())
                .map(|region| Region { is_darker: !region.is_darker, ..region })
                .collect();
            assert!(seen.regions.iter().all(|region| !region.is_darker), "{threshold:?}");
            assert_eq!((seen.regions, seen.labels), (lighter, other.labels), "{threshold:?}");
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
