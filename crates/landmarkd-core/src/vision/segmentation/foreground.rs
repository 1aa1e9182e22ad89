//! The foreground: what differs from the ground by more than its noise, in luminance or in colour; or what is on one side
//! of a level.
//!
//! Colour is compared in the opponent planes r − g and b − (r + g)/2. Levels of files are coded by about the root of the
//! light, as the lightness and the opponent axes of CIE L*a*b* are; and a difference is measured by the ground's own
//! deviation along each plane, so that their scales don't matter.

use super::ground::Ground;
use super::holes::fill_dark_holes;
use super::options::{Polarity, SegmentationOptions};
use super::shadows::{GroundedPlane, Shadows, take_out_shadows};
use super::{Picture, Scene};
use crate::imaging::Image;

/// The chosen offset in standard deviations of the background.
const OFFSET_SIGMAS: f32 = 3.5;
/// The least offset that is chosen, by the range of the picture: of luminance, and of the opponent planes, which reach
/// farther.
const LEAST_PARTS: [f32; 3] = [0.04, 0.06, 0.06];
/// No offset is less, in gray levels: rounding.
const LEAST_OFFSET: f32 = 0.02;
/// Where the offset by noise is above this part of the range, the picture is averaged first, in squares of up to
/// 2 · [`MOST_REACH`] + 1 pixels.
const NOISY_PART: f32 = 0.12;
const MOST_REACH: usize = 3;
/// A pixel at an edge belongs to the part if it differs by this part of what those further in do, and these among
/// themselves by less than that factor.
const EDGE_PART: f32 = 0.5;
const PLATEAU_PART: f32 = 1.25;
/// The window is the picture's shorter side by this, if it is chosen.
const WINDOWS_A_SIDE: usize = 3;
/// A region has at least so many pixels, if the least area is chosen.
const SMALLEST_PX: f64 = 12.0;
/// How many regions of noise alone a picture may have, and how many more shapes of n + 1 connected pixels there are than
/// of n, as a factor.
const FALSE_REGIONS: f64 = 0.01;
const SHAPES_GROWTH: f64 = 6.6;

/// A picture against its ground.
pub(super) struct Foreground {
    /// 1 where a pixel differs, else 0; row-major.
    pub mask: Vec<u8>,
    /// The same without what is mostly ground at the edges.
    pub core: Vec<u8>,
    /// By how many offsets each pixel differs.
    pub excess: Vec<f32>,
    /// By how much its luminance is above the ground's, in gray levels.
    pub above: Vec<f32>,
    /// The shadows that were taken out of the mask.
    pub shadows: Shadows,
    /// What is known of the ground.
    pub noise: Noise,
}

/// The noise of a ground, in gray levels of the luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the ground's pixels about its level.
    pub deviation: f32,
    /// By how much a pixel has to differ, in the middle of the picture's ground.
    pub offset: f32,
    /// Part of the picture's blocks that are ground.
    pub ground_part: f32,
    /// From the darkest block of the picture to the lightest.
    pub range: f32,
    /// Regions below so many pixels may be noise.
    pub least_area_px: usize,
    /// Side of the squares that were averaged, 1 for none.
    pub averaged_px: usize,
}

impl Foreground {
    /// By the ground about each pixel.
    pub fn of(picture: Picture, options: &SegmentationOptions, scene: Scene) -> Foreground {
        let (width, height) = (picture.luminance.width(), picture.luminance.height());
        let window = options.window_px.unwrap_or(width.min(height) / WINDOWS_A_SIDE);
        let colours = match (options.polarity, picture.rgb) {
            (Polarity::Either, Some(rgb)) => opponent_planes(rgb),
            _ => vec![],
        };
        let planes: Vec<&[f32]> =
            [picture.luminance.pixels()].into_iter().chain(colours.iter().map(Vec::as_slice)).collect();
        let ground = Ground::of(&planes, width, window, options.polarity, scene); // B§3
        let differences = Differences::of(&planes, &ground, width, options.offset.is_none());
        let (excess, offsets) = differences.excess(&ground, width, options);
        let mut mask = differences.mask(&excess, width);
        let noise = differences.noise(&ground, offsets[0], width * height);
        let mut shadows = Shadows::default();
        match options.polarity {
            Polarity::Either => {
                let planes = planes.iter().zip(differences.exact()).zip(&offsets);
                let planes: Vec<GroundedPlane> = planes
                    .map(|((levels, above), &offset)| GroundedPlane { levels, above, offset })
                    .collect();
                shadows = take_out_shadows(&mut mask, &planes, width, noise.least_area_px);
            }
            Polarity::LightOnDark => {
                fill_dark_holes(&mut mask, width, &differences.above[0], offsets[0], noise.least_area_px);
            }
            Polarity::DarkOnLight => {
                let below: Vec<f32> = differences.above[0].iter().map(|v| -v).collect();
                fill_dark_holes(&mut mask, width, &below, offsets[0], noise.least_area_px);
            }
        }
        let core = trimmed(&mask, &excess, width);
        Foreground { mask, core, excess, above: differences.into_luminance(), shadows, noise }
    }
}

/// By how much the pixels of each plane are above the ground.
struct Differences {
    /// Plane by plane, averaged in squares if the ground is too noisy.
    above: Vec<Vec<f32>>,
    /// Those of the luminance as they are, if others are averaged.
    luminance: Option<Vec<f32>>,
    /// By how much the averages vary less, plane by plane.
    factors: Vec<f32>,
    /// Squares of 2 · reach + 1 pixels were averaged.
    reach: usize,
}

impl Differences {
    fn of(planes: &[&[f32]], ground: &Ground, width: usize, may_average: bool) -> Differences {
        let exact = |k: usize| ground.differences(planes[k], &ground.surfaces[k].levels);
        let mut differences = Differences {
            above: (0..planes.len()).map(exact).collect(),
            luminance: None,
            factors: vec![1.0; planes.len()],
            reach: 0,
        };
        let noisy = (NOISY_PART * ground.range).max(LEAST_OFFSET) / OFFSET_SIGMAS;
        while may_average
            && differences.reach < MOST_REACH
            && differences.factors[0] * ground.surfaces[0].deviation > noisy
        {
            differences.reach += 1;
            for (k, surface) in ground.surfaces.iter().enumerate() {
                let exact = exact(k);
                differences.above[k] = averaged(&exact, width, differences.reach);
                let deviation = ground.deviation(&differences.above[k], width);
                differences.factors[k] = deviation / surface.deviation.max(f32::MIN_POSITIVE);
                if k == 0 {
                    differences.luminance = Some(exact);
                }
            }
        }
        differences
    }

    /// By how many offsets each pixel differs, and the offset of each plane in the middle of the ground's noise.
    fn excess(&self, ground: &Ground, width: usize, options: &SegmentationOptions) -> (Vec<f32>, Vec<f32>) {
        let mut excess = vec![0.0_f32; self.above[0].len()];
        let mut offsets = Vec::new();
        for (k, surface) in ground.surfaces.iter().enumerate() {
            let least = (LEAST_PARTS[k] * ground.range).max(LEAST_OFFSET);
            let offset = |deviation: f32| match options.offset {
                Some(offset) => (offset as f32).max(LEAST_OFFSET),
                None => (OFFSET_SIGMAS * self.factors[k] * deviation).max(least),
            };
            offsets.push(offset(surface.deviation));
            let by_block: Vec<f32> = surface.deviations.iter().map(|&deviation| offset(deviation)).collect();
            ground.blocks.interpolate(&by_block, |y, offsets| {
                let row = y * width..(y + 1) * width;
                let pixels = excess[row.clone()].iter_mut().zip(&self.above[k][row]).zip(offsets);
                match options.polarity {
                    Polarity::Either => pixels.for_each(|((e, v), offset)| *e = e.max(v.abs() / offset)),
                    Polarity::LightOnDark => pixels.for_each(|((e, v), offset)| *e = v / offset),
                    Polarity::DarkOnLight => pixels.for_each(|((e, v), offset)| *e = -v / offset),
                }
            });
        }
        (excess, offsets)
    }

    /// 1 where a pixel differs by more than the offset, else 0.
    fn mask(&self, excess: &[f32], width: usize) -> Vec<u8> {
        let mut mask: Vec<u8> = excess.iter().map(|&e| u8::from(e > 1.0)).collect();
        if self.reach > 0 {
            let most = highest(excess, width, self.reach + 1);
            let pixels = mask.iter_mut().zip(excess).zip(most);
            pixels.for_each(|((is_part, e), most)| *is_part &= u8::from(*e >= EDGE_PART * most));
        }
        mask
    }

    /// What is known of the ground, by the offset of the luminance.
    fn noise(&self, ground: &Ground, offset: f32, pixels: usize) -> Noise {
        let (surface, averaged_px) = (&ground.surfaces[0], 2 * self.reach + 1);
        let deviation = surface.deviation.max(f32::MIN_POSITIVE);
        // The mean of a block varies less by the block's side, if neighbouring pixels don't vary together.
        let side = ground.blocks.side as f32;
        let grain_px = side * surface.block_deviation / deviation;
        let grain_px = grain_px.clamp(averaged_px as f32, side.max(averaged_px as f32));
        let blocks = ground.is_ground.len().max(1) as f32;
        Noise {
            deviation: surface.deviation,
            offset,
            ground_part: ground.is_ground.iter().filter(|is_ground| **is_ground).count() as f32 / blocks,
            range: ground.range,
            least_area_px: least_area_px(pixels, offset / (self.factors[0] * deviation), grain_px),
            averaged_px,
        }
    }

    /// Plane by plane, the luminance as it is.
    fn exact(&self) -> impl Iterator<Item = &Vec<f32>> {
        self.luminance.iter().chain(&self.above[usize::from(self.luminance.is_some())..])
    }

    fn into_luminance(mut self) -> Vec<f32> {
        self.luminance.unwrap_or_else(|| self.above.swap_remove(0))
    }
}

/// The least area that noise hardly reaches: of N pixels, each beyond the offset by chance p, about N (6.6 p)ⁿ connected sets
/// of n are expected; grains count as pixels.
fn least_area_px(pixels: usize, sigmas: f32, grain_px: f32) -> usize {
    let grain = f64::from(grain_px).powi(2);
    let chance = (-0.5 * f64::from(sigmas).powi(2)).exp();
    let shrinks = -(SHAPES_GROWTH * chance).min(0.5).ln();
    let grains = ((pixels as f64 / grain / FALSE_REGIONS).max(1.0).ln() / shrinks).max(1.0);
    (grains.ceil() * grain).max(SMALLEST_PX).ceil() as usize
}

/// r − g and b − (r + g)/2.
fn opponent_planes([red, green, blue]: &[Image; 3]) -> Vec<Vec<f32>> {
    let red_green = red.pixels().iter().zip(green.pixels()).map(|(r, g)| r - g).collect();
    let blue_yellow = (red.pixels().iter().zip(green.pixels()).zip(blue.pixels()))
        .map(|((r, g), b)| b - (r + g) / 2.0)
        .collect();
    vec![red_green, blue_yellow]
}

/// The foreground without the pixels at its edge that are mostly ground: they differ by less than [`EDGE_PART`] of what the
/// next pixel inwards does, and that one by as much as the two behind it. A part that is dark towards its edge keeps it.
fn trimmed(mask: &[u8], excess: &[f32], width: usize) -> Vec<u8> {
    let mut out = mask.to_vec();
    let height = mask.len() / width.max(1);
    for (y, row) in mask.chunks_exact(width.max(1)).enumerate() {
        for x in 0..width {
            if row[x] == 0 {
                continue;
            }
            let at = y * width + x;
            // Outwards by one pixel, inwards by three.
            let is_edge = |outside: bool, by: isize| {
                let inwards = |steps: isize| excess[at.wrapping_add_signed(by * steps)];
                outside
                    && excess[at] < EDGE_PART * inwards(1)
                    && inwards(2).max(inwards(3)) < PLATEAU_PART * inwards(1)
                    && inwards(2).min(inwards(3)) * PLATEAU_PART > inwards(1)
            };
            let (right, down) = (1, width as isize);
            out[at] = u8::from(
                !(is_edge(x > 0 && x + 3 < width && row[x - 1] == 0, right)
                    || is_edge(x > 2 && x + 1 < width && row[x + 1] == 0, -right)
                    || is_edge(y > 0 && y + 3 < height && mask[at - width] == 0, down)
                    || is_edge(y > 2 && y + 1 < height && mask[at + width] == 0, -down)),
            );
        }
    }
    out
}

/// The mean over the square about each pixel, or what of it is within the picture.
fn averaged(values: &[f32], width: usize, reach: usize) -> Vec<f32> {
    let rows = over_rows(values, width, reach, |sum, v| sum + v);
    let columns = over_columns(&rows, width, reach, |sum, v| sum + v);
    let height = values.len() / width.max(1);
    let within = |at: usize, side: usize| ((at + reach + 1).min(side) - at.saturating_sub(reach)) as f32;
    let mut out = columns;
    for (y, row) in out.chunks_exact_mut(width.max(1)).enumerate() {
        let tall = within(y, height);
        row.iter_mut().enumerate().for_each(|(x, v)| *v /= tall * within(x, width));
    }
    out
}

/// The highest value in the square about each pixel.
fn highest(values: &[f32], width: usize, reach: usize) -> Vec<f32> {
    over_columns(&over_rows(values, width, reach, f32::max), width, reach, f32::max)
}

fn over_rows(values: &[f32], width: usize, reach: usize, join: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let mut out = values.to_vec();
    for (out, row) in out.chunks_exact_mut(width.max(1)).zip(values.chunks_exact(width.max(1))) {
        for by in 1..=reach.min(width.saturating_sub(1)) {
            out[by..].iter_mut().zip(row).for_each(|(out, &v)| *out = join(*out, v));
            out.iter_mut().zip(&row[by..]).for_each(|(out, &v)| *out = join(*out, v));
        }
    }
    out
}

fn over_columns(values: &[f32], width: usize, reach: usize, join: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let mut out = values.to_vec();
    for by in (1..=reach).map(|rows| (rows * width).min(values.len())) {
        out[by..].iter_mut().zip(values).for_each(|(out, &v)| *out = join(*out, v));
        out.iter_mut().zip(&values[by..]).for_each(|(out, &v)| *out = join(*out, v));
    }
    out
}

/// Otsu's level: the one between two classes of gray levels whose means are farthest apart, by their variance.
/// "At most" is background. Pictures of one level have none that is above it.
pub(super) fn otsu_level(levels: &[f32]) -> f32 {
    let mut counts = [0_usize; 256];
    for level in levels {
        counts[(level + 0.5).clamp(0.0, 255.0) as usize] += 1;
    }
    let all = levels.len() as f64;
    let sum: f64 = counts.iter().enumerate().map(|(level, &count)| level as f64 * count as f64).sum();
    let (mut below, mut below_sum) = (0.0, 0.0);
    let (mut best, mut best_level) = (0.0, 255);
    for (level, &count) in counts.iter().enumerate() {
        below += count as f64;
        below_sum += level as f64 * count as f64;
        let above = all - below;
        if below > 0.0 && above > 0.0 {
            let apart = below_sum / below - (sum - below_sum) / above;
            let between = below * above * apart.powi(2);
            if between > best {
                (best, best_level) = (between, level);
            }
        }
    }
    // Levels were rounded to be counted.
    best_level as f32 + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Frame;
    use crate::vision::segmentation::segmented;

    fn foreground(picture: &Image) -> Foreground {
        Foreground::of(picture.into(), &SegmentationOptions::default(), Scene::Table)
    }

    /// A table of one level with noise, and a square part that differs from it.
    fn table(level: f32, noise: f32, part: f32) -> Image {
        Image::from_fn(160, 120, |x, y| {
            let is_part = (60..90).contains(&x) && (40..70).contains(&y);
            let mixed = ((y * 160 + x) as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40;
            let noise = noise * ((mixed % 11) as f32 / 5.0 - 1.0);
            if is_part { level + part + noise } else { level + noise }
        })
    }

    #[test]
    fn what_differs_on_either_side_is_foreground() {
        for part in [90.0, -60.0] {
            let seen = foreground(&table(80.0, 2.0, part));
            for (at, &v) in seen.mask.iter().enumerate() {
                let is_part = (60..90).contains(&(at % 160)) && (40..70).contains(&(at / 160));
                assert_eq!(v == 1, is_part, "{part}: {at}");
            }
        }
    }

    #[test]
    fn the_offset_follows_the_noise_of_the_ground_and_the_range_of_the_picture() {
        let offset = |picture: &Image| foreground(picture).noise.offset;
        assert!(offset(&table(80.0, 4.0, 90.0)) > 1.5 * offset(&table(80.0, 2.0, 90.0)));
        let (whole, tenth) = (table(80.0, 1.0, 90.0), table(8.0, 0.1, 9.0));
        let ratio = offset(&whole) / offset(&tenth);
        assert!((ratio - 10.0).abs() < 0.2, "{ratio}");
        let stated = SegmentationOptions { offset: Some(33.0), ..SegmentationOptions::default() };
        assert_eq!(Foreground::of((&whole).into(), &stated, Scene::Table).noise.offset, 33.0);
    }

    #[test]
    fn a_noisy_ground_is_averaged_and_edges_stay_where_they_are() {
        let seen = foreground(&table(100.0, 60.0, 100.0));
        assert!(seen.noise.averaged_px > 1);
        let area = seen.mask.iter().map(|&v| usize::from(v)).sum::<usize>();
        assert!((area as f64 / 900.0 - 1.0).abs() < 0.06, "{area}");
    }

    #[test]
    fn the_least_area_follows_the_grain_and_the_offset() {
        assert_eq!(least_area_px(300_000, 8.0, 1.0), 12);
        assert!(least_area_px(300_000, 3.5, 3.0) > 2 * least_area_px(300_000, 3.5, 2.0) - 4);
        assert!(least_area_px(300_000, 2.5, 4.0) > least_area_px(300_000, 4.0, 4.0));
    }

    #[test]
    fn parts_of_the_grounds_brightness_differ_in_colour() {
        let plane = |part: f32| table(110.0, 3.0, part);
        // 0.299 · 60 − 0.587 · 22 − 0.114 · 44 = 0
        let frame = Frame::colour([plane(60.0), plane(-22.0), plane(-44.0)]);
        assert_eq!(segmented(&frame.luminance, &SegmentationOptions::default()).found, 0);
        let seen = Foreground::of((&frame).into(), &SegmentationOptions::default(), Scene::Table);
        assert_eq!(seen.mask.iter().filter(|&&v| v == 1).count(), 900);
    }

    #[test]
    fn pixels_that_are_mostly_ground_are_trimmed_and_dark_edges_are_not() {
        let row = |levels: [f32; 12]| {
            let excess: Vec<f32> = levels.into_iter().cycle().take(12 * 9).collect();
            let mask: Vec<u8> = excess.iter().map(|&e| u8::from(e > 1.0)).collect();
            trimmed(&mask, &excess, 12)[12 * 4..][..12].to_vec()
        };
        let hard = row([0.0, 0.0, 3.0, 10.0, 10.0, 10.0, 10.0, 10.0, 7.0, 0.0, 0.0, 0.0]);
        assert_eq!(hard, [0, 0, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0]);
        let rounded = row([0.0, 0.0, 3.0, 7.0, 10.0, 13.0, 16.0, 13.0, 9.0, 2.0, 0.0, 0.0]);
        assert_eq!(rounded, [0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0]);
    }

    #[test]
    fn otsus_level_lies_between_two_classes() {
        let levels: Vec<f32> =
            (0..1000).map(|at| if at % 4 == 0 { 180.0 } else { 30.0 } + (at % 9) as f32).collect();
        let level = otsu_level(&levels);
        assert!((38.0..180.0).contains(&level), "{level}");
        assert_eq!(levels.iter().filter(|&&v| v > level).count(), 250);
        assert_eq!(otsu_level(&[7.0; 50]), 255.5, "one level has nothing above it");
    }
}
