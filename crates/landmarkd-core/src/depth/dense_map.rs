//! From β on a grid to a depth map: millimetres and flags at every pixel, and the map's summary.

use super::depth_map::{DepthMap, DepthSpan, Flag, Summary, Warning};
use super::estimate::{Sample, Samples};
use super::estimator::Registered;
use super::resampling::applied;
use super::{FocalPair, Median, Optics};
use crate::statistics::median;

/// Expected error above this part of the range is no depth.
pub(super) const MOST_SIGMA: f32 = 0.02;
/// β beyond this is outside the range.
pub(super) const MOST_BETA: f32 = 1.05;
/// A misfit above this is not explained by one depth.
pub(super) const MOST_MISFIT: f32 = 2.5;
/// How far around a pixel at full scale nothing is measured.
const SATURATION_REACH_PX: usize = 8;
/// Neighbours of the grid whose β differs by more than this, and by more than their error, lie on another surface.
const SAME_SURFACE: f32 = 0.08;
/// Fewer known pixels are worth a warning.
const WARN_COVERAGE: f64 = 0.05;
/// More inconsistent ones, of those with texture, are worth a warning.
const WARN_INCONSISTENT: f64 = 0.2;

/// All that a depth map is made of.
pub(super) struct DenseMap<'a> {
    pub(super) pair: &'a FocalPair,
    pub(super) optics: &'a Optics,
    pub(super) registered: &'a Registered,
    pub(super) border_px: usize,
    pub(super) samples: &'a Samples,
    pub(super) halvings: u32,
    pub(super) median: Median,
    pub(super) gain: f64,
    pub(super) noise_sigma: Option<f64>,
}

/// Flags of a point of the grid, and its expected error as a part of the range.
struct Grade {
    flags: u8,
    sigma_share: f32,
}

/// What is known of each pixel, row-major.
struct Pixels {
    beta: Vec<f32>,
    sigma_mm: Vec<f32>,
    flags: Vec<u8>,
}

/// Where a row or column of pixels lies on the grid: its nearest point, and the two about it with their weights.
struct GridPlace {
    nearest: usize,
    between: [(usize, f32); 2],
}

impl DenseMap<'_> {
    /// The depth map and its summary.
    pub(super) fn depth_map(self) -> DepthMap {
        let (width, height) = (self.pair.width(), self.pair.height());
        let grades: Vec<Grade> = self.samples.points.iter().map(|sample| self.grade(sample)).collect();
        let Pixels { mut beta, sigma_mm, mut flags } = self.upsampled(&grades);
        self.flag_saturation(&mut flags);
        self.flag_border(&mut flags);
        beta.iter_mut().zip(&flags).filter(|(_, flags)| **flags != 0).for_each(|(beta, _)| *beta = f32::NAN);
        if self.median != Median::None {
            beta = medians(&beta, width, height, self.median.side_px());
        }
        let depth_mm = |&beta: &f32| match beta.is_nan() {
            true => f32::NAN,
            false => self.optics.depth_mm(f64::from(beta)) as f32,
        };
        let depth_mm: Vec<f32> = beta.iter().map(depth_mm).collect();
        let summary = self.summary(&depth_mm, &flags);
        let halvings = self.halvings;
        DepthMap { width, height, depth_mm, sigma_mm, flags, optics: *self.optics, halvings, summary }
    }

    fn grade(&self, sample: &Sample) -> Grade {
        let Sample { beta, sigma, misfit, ambiguous, scattered } = *sample;
        let (before, after) = (f64::from(beta) - 0.01, f64::from(beta) + 0.01);
        // Depths by β, in parts of the range.
        let slope =
            (self.optics.depth_mm(before) - self.optics.depth_mm(after)) / 0.02 / self.optics.range_mm();
        let sigma_share = sigma * slope.abs() as f32;
        let unknown = sigma == f32::INFINITY;
        let outside = beta.abs() > MOST_BETA || !self.optics.depth_mm(before).is_finite();
        let raised = [
            (Flag::LowTexture, (unknown || sigma_share > MOST_SIGMA) && !ambiguous && !scattered),
            (Flag::Ambiguous, unknown && ambiguous),
            (Flag::OutOfRange, !unknown && outside),
            (Flag::Inconsistent, scattered || !unknown && misfit > MOST_MISFIT),
        ];
        let flags =
            raised.iter().filter(|(_, raised)| *raised).fold(0, |flags, (flag, _)| flags | flag.bit());
        Grade { flags, sigma_share }
    }

    /// The flags and error of each pixel's nearest point of the grid, and β between the grid's points.
    fn upsampled(&self, grades: &[Grade]) -> Pixels {
        let count = self.pair.width() * self.pair.height();
        let mut pixels = Pixels {
            beta: Vec::with_capacity(count),
            sigma_mm: Vec::with_capacity(count),
            flags: Vec::with_capacity(count),
        };
        let range_mm = self.optics.range_mm() as f32;
        let columns = self.grid_places(self.pair.width(), self.samples.width);
        for row in &self.grid_places(self.pair.height(), self.samples.height) {
            for column in &columns {
                let nearest = row.nearest * self.samples.width + column.nearest;
                let &Grade { flags, sigma_share } = &grades[nearest];
                pixels.flags.push(flags);
                pixels.sigma_mm.push(if sigma_share.is_finite() { sigma_share * range_mm } else { f32::NAN });
                let known = flags == 0;
                pixels.beta.push(if known {
                    self.beta_between(row, column, nearest, grades)
                } else {
                    f32::NAN
                });
            }
        }
        pixels
    }

    /// The places of `count` pixels along an axis on which the grid has `points`.
    fn grid_places(&self, count: usize, points: usize) -> Vec<GridPlace> {
        let (step, last) = (self.samples.step << self.halvings, points - 1);
        let place = |px: usize| {
            let (before, part) = ((px / step).min(last), (px % step) as f32 / step as f32);
            GridPlace {
                nearest: ((px + step / 2) / step).min(last),
                between: [(before, 1.0 - part), ((before + 1).min(last), part)],
            }
        };
        (0..count).map(place).collect()
    }

    /// β of a pixel, bilinear between the points of the grid that lie on the surface of the `nearest` one.
    fn beta_between(&self, row: &GridPlace, column: &GridPlace, nearest: usize, grades: &[Grade]) -> f32 {
        let centre = self.samples.points[nearest].beta;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (row, v) in row.between {
            for (column, u) in column.between {
                let other = row * self.samples.width + column;
                let beta = self.samples.points[other].beta;
                if grades[other].flags == 0 && (beta - centre).abs() < SAME_SURFACE {
                    sum += u * v * beta;
                    weights += u * v;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { centre }
    }

    /// Flags what full scale in either picture reaches.
    fn flag_saturation(&self, flags: &mut [u8]) {
        let (width, height) = (self.pair.width(), self.pair.height());
        let [near, far] =
            self.pair.saturated.each_ref().map(|marks| {
                marks.contains(&true).then(|| dilated(marks, width, height, SATURATION_REACH_PX))
            });
        if near.is_none() && far.is_none() {
            return;
        }
        let last = [width - 1, height - 1].map(|last| last as f64);
        for (at, flags) in flags.iter_mut().enumerate() {
            let [u, v] = applied(&self.registered.to_far, [(at % width) as f64, (at / width) as f64]);
            let there =
                v.round().clamp(0.0, last[1]) as usize * width + u.round().clamp(0.0, last[0]) as usize;
            let reached =
                near.as_ref().is_some_and(|near| near[at]) || far.as_ref().is_some_and(|far| far[there]);
            *flags |= if reached { Flag::Saturated.bit() } else { 0 };
        }
    }

    /// Flags the border of either picture.
    fn flag_border(&self, flags: &mut [u8]) {
        let (width, height) = (self.pair.width(), self.pair.height());
        let border = self.border_px as f64;
        let [right, bottom] = [width, height].map(|side| (side - 1) as f64 - border);
        let inside = |[x, y]: [f64; 2]| x >= border && y >= border && x <= right && y <= bottom;
        let in_far = |point: [f64; 2]| applied(&self.registered.to_far, point);
        // Nothing moves farther than a corner does: pixels deeper inside need no test.
        let corners = [[0, 0], [width, 0], [0, height], [width, height]];
        let moves = corners.map(|corner| corner.map(|v| v as f64)).map(|[x, y]| {
            let [u, v] = in_far([x, y]);
            (u - x).abs().max((v - y).abs())
        });
        let farthest = moves.into_iter().fold(0.0, f64::max);
        let margin = (border + farthest).ceil().clamp(0.0, 1e6) as usize;
        for y in 0..height {
            let deep = y >= margin && y + margin < height;
            for x in (0..width).filter(|&x| !(deep && x >= margin && x + margin < width)) {
                let near = [x as f64, y as f64];
                if !inside(near) || !inside(in_far(near)) {
                    flags[y * width + x] |= Flag::Border.bit();
                }
            }
        }
    }

    fn summary(&self, depth_mm: &[f32], flags: &[u8]) -> Summary {
        let mut known: Vec<f32> = depth_mm.iter().copied().filter(|depth| depth.is_finite()).collect();
        let coverage = known.len() as f64 / depth_mm.len() as f64;
        let depth = median(&mut known, f32::total_cmp).map(|median| {
            let min = known.iter().copied().fold(median, f32::min);
            let max = known.iter().copied().fold(median, f32::max);
            DepthSpan { min: min.into(), median: median.into(), max: max.into() }
        });
        Summary {
            near_focus_mm: self.optics.near_focus_mm(),
            far_focus_mm: self.optics.far_focus_mm(),
            coverage,
            depth,
            noise_sigma: self.noise_sigma,
            shift_px: self.registered.shift_px,
            gain: self.gain,
            flag_counts: Flag::ALL.map(|flag| count(flags, |flags| flags & flag.bit() != 0)),
            warnings: self.warnings(flags, coverage),
        }
    }

    /// The registration's warnings, and those of the whole map.
    fn warnings(&self, flags: &[u8], coverage: f64) -> Vec<Warning> {
        let untextured =
            Flag::LowTexture.bit() | Flag::Ambiguous.bit() | Flag::Border.bit() | Flag::Saturated.bit();
        let textured = count(flags, |flags| flags & untextured == 0);
        let inconsistent =
            count(flags, |flags| flags & untextured == 0 && flags & Flag::Inconsistent.bit() != 0);
        let mut warnings = self.registered.warnings.clone();
        if inconsistent as f64 > WARN_INCONSISTENT * textured as f64 {
            warnings.push(Warning::ManyInconsistent);
        }
        if coverage < WARN_COVERAGE {
            warnings.push(Warning::LowCoverage);
        }
        warnings
    }
}

/// Pixels whose flags pass a test.
fn count(flags: &[u8], passes: impl Fn(u8) -> bool) -> u64 {
    flags.iter().filter(|&&flags| passes(flags)).count() as u64
}

/// Whether a marked pixel lies within a square of this reach.
fn dilated(marks: &[bool], width: usize, height: usize, reach: usize) -> Vec<bool> {
    let along = |marks: &[bool], length: usize, count: usize, at: &dyn Fn(usize, usize) -> usize| {
        let mut out = vec![false; marks.len()];
        for line in 0..count {
            // Up to where the last mark reaches.
            let mut until = 0;
            for k in 0..length {
                if marks[at(line, k)] {
                    until = k + reach + 1;
                    for back in k.saturating_sub(reach)..k {
                        out[at(line, back)] = true;
                    }
                }
                if k < until {
                    out[at(line, k)] = true;
                }
            }
        }
        out
    };
    let rows = along(marks, width, height, &|y, x| y * width + x);
    along(&rows, height, width, &|x, y| y * width + x)
}

/// The median of what is known in a square about each known value.
fn medians(values: &[f32], width: usize, height: usize, side: usize) -> Vec<f32> {
    let reach = side / 2;
    let mut around = Vec::with_capacity(side * side);
    let mut out = values.to_vec();
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            if values[at].is_nan() {
                continue;
            }
            around.clear();
            for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                let from = row * width + x.saturating_sub(reach);
                let to = row * width + (x + reach + 1).min(width);
                around.extend(values[from..to].iter().copied().filter(|v| !v.is_nan()));
            }
            let middle = around.len() / 2;
            let (below, &mut median, _) = around.select_nth_unstable_by(middle, f32::total_cmp);
            let before = below.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            out[at] = if around.len() % 2 == 0 { 0.5 * (before + median) } else { median };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_reach_as_far_as_they_should() {
        let mut marks = vec![false; 7 * 5];
        marks[2 * 7 + 3] = true;
        let picture: String = dilated(&marks, 7, 5, 1)
            .chunks(7)
            .map(|row| row.iter().map(|&mark| if mark { '#' } else { '.' }).chain(['\n']).collect::<String>())
            .collect();
        assert_eq!(picture, ".......\n..###..\n..###..\n..###..\n.......\n");
    }

    #[test]
    fn a_median_is_of_known_values_only() {
        let nan = f32::NAN;
        let values = [1.0, 2.0, 9.0, nan, 5.0, nan, 3.0, nan, 4.0];
        let out = medians(&values, 3, 3, 3);
        // 1 2 9 5 3 4 about the middle: between 3 and 4
        assert_eq!(out[4], 3.5);
        assert!(out[3].is_nan() && out[5].is_nan());
        assert_eq!(out[0], 2.0);
    }
}
