//! From β on a grid to millimetres and flags at every pixel, and to what the map says as a whole.

use super::depth_map::{DepthMap, DepthSpan, Flag, Summary, Warning};
use super::estimate::Samples;
use super::resampling::{Affine, applied};
use super::{FocalPair, Median, Optics};

/// Expected error above this part of the range is no depth.
const MOST_SIGMA: f32 = 0.02;
/// β beyond this is outside the range.
const MOST_BETA: f32 = 1.05;
/// A misfit above this is not explained by one depth.
const MOST_MISFIT: f32 = 2.5;
/// How far around a pixel at full scale nothing is measured.
const SATURATION_REACH_PX: usize = 8;
/// Neighbours of the grid whose β differs by more than this, and by more than their error, lie on another surface.
const SAME_SURFACE: f32 = 0.08;
/// Fewer known pixels are worth a warning.
const WARN_COVERAGE: f64 = 0.05;
/// More inconsistent ones, of those with texture, are worth a warning.
const WARN_INCONSISTENT: f64 = 0.2;

/// Everything that the verdict on a pair needs.
pub(super) struct Judge<'a> {
    pub(super) pair: &'a FocalPair,
    pub(super) optics: &'a Optics,
    pub(super) to_far: &'a Affine,
    pub(super) border_px: usize,
    pub(super) samples: &'a Samples,
    pub(super) halvings: u32,
    pub(super) median: Median,
    pub(super) shift_px: [f64; 2],
    pub(super) gain: f64,
    pub(super) noise_sigma: Option<f64>,
    pub(super) warnings: Vec<Warning>,
}

impl Judge<'_> {
    /// The map.
    pub(super) fn depth_map(self) -> DepthMap {
        let (width, height) = (self.pair.width(), self.pair.height());
        let (sample_flags, sample_shares) = self.sample_flags();
        let mut flags = vec![0_u8; width * height];
        let mut beta = vec![f32::NAN; width * height];
        let mut sigma_mm = vec![f32::NAN; width * height];
        let range_mm = self.optics.range_mm() as f32;
        let grid = self.samples.step << self.halvings;
        let last = (self.samples.width - 1, self.samples.height - 1);
        let nearest = |px: usize, last: usize| ((px + grid / 2) / grid).min(last);
        for y in 0..height {
            let j = nearest(y, last.1);
            let (above, v) = ((y / grid).min(last.1), (y % grid) as f32 / grid as f32);
            let below = (above + 1).min(last.1);
            for x in 0..width {
                let own = j * self.samples.width + nearest(x, last.0);
                let at = y * width + x;
                flags[at] = sample_flags[own];
                let share = sample_shares[own];
                sigma_mm[at] = if share.is_finite() { share * range_mm } else { f32::NAN };
                if flags[at] != 0 {
                    continue;
                }
                let (left, u) = ((x / grid).min(last.0), (x % grid) as f32 / grid as f32);
                let right = (left + 1).min(last.0);
                let centre = self.samples.beta[own];
                let (mut sum, mut weights) = (0.0, 0.0);
                for (row, v) in [(above, 1.0 - v), (below, v)] {
                    for (column, u) in [(left, 1.0 - u), (right, u)] {
                        let other = row * self.samples.width + column;
                        let off = (self.samples.beta[other] - centre).abs();
                        if sample_flags[other] == 0 && off < SAME_SURFACE {
                            sum += u * v * self.samples.beta[other];
                            weights += u * v;
                        }
                    }
                }
                beta[at] = if weights > 0.0 { sum / weights } else { centre };
            }
        }
        self.flag_pixels(&mut flags);
        for (beta, flags) in beta.iter_mut().zip(&flags) {
            if *flags != 0 {
                *beta = f32::NAN;
            }
        }
        if self.median != Median::None {
            beta = medians(&beta, width, height, self.median.side_px());
        }
        let depth_mm: Vec<f32> = beta
            .iter()
            .map(|&beta| if beta.is_nan() { f32::NAN } else { self.optics.depth_mm(f64::from(beta)) as f32 })
            .collect();
        let summary = self.summary(&depth_mm, &flags);
        DepthMap { width, height, depth_mm, sigma_mm, flags, optics: *self.optics, summary }
    }

    /// Flags of the grid's points, and their expected error as a part of the range.
    fn sample_flags(&self) -> (Vec<u8>, Vec<f32>) {
        let samples = self.samples;
        let range_mm = self.optics.range_mm();
        let points = (0..samples.beta.len()).map(|at| {
            let beta = samples.beta[at];
            let (before, after) = (f64::from(beta) - 0.01, f64::from(beta) + 0.01);
            // Depths by β, in parts of the range.
            let slope = (self.optics.depth_mm(before) - self.optics.depth_mm(after)) / 0.02 / range_mm;
            let share = samples.sigma[at] * slope.abs() as f32;
            let mut flags = 0;
            let mut flag = |raised: bool, flag: Flag| flags |= if raised { flag.bit() } else { 0 };
            let nothing = samples.sigma[at] == f32::INFINITY;
            flag((nothing || share > MOST_SIGMA) && !samples.ambiguous[at], Flag::LowTexture);
            flag(nothing && samples.ambiguous[at], Flag::Ambiguous);
            let outside = beta.abs() > MOST_BETA || !self.optics.depth_mm(before).is_finite();
            flag(!nothing && outside, Flag::OutOfRange);
            flag(!nothing && samples.misfit[at] > MOST_MISFIT, Flag::Inconsistent);
            (flags, share)
        });
        points.unzip()
    }

    /// The flags that pixels have by themselves: full scale, and the border of either picture.
    fn flag_pixels(&self, flags: &mut [u8]) {
        let (width, height) = (self.pair.width(), self.pair.height());
        let [near, far] =
            self.pair.saturated.each_ref().map(|marks| {
                marks.contains(&true).then(|| dilated(marks, width, height, SATURATION_REACH_PX))
            });
        if near.is_some() || far.is_some() {
            let last = [width - 1, height - 1].map(|last| last as f64);
            for (at, flags) in flags.iter_mut().enumerate() {
                let [u, v] = applied(self.to_far, [(at % width) as f64, (at / width) as f64]);
                let there =
                    v.round().clamp(0.0, last[1]) as usize * width + u.round().clamp(0.0, last[0]) as usize;
                let reached =
                    near.as_ref().is_some_and(|near| near[at]) || far.as_ref().is_some_and(|far| far[there]);
                *flags |= if reached { Flag::Saturated.bit() } else { 0 };
            }
        }
        let border = self.border_px as f64;
        let inside = |[x, y]: [f64; 2]| {
            x >= border
                && y >= border
                && x <= (width - 1) as f64 - border
                && y <= (height - 1) as f64 - border
        };
        // Nothing moves farther than a corner does: pixels deeper inside need no look.
        let corners =
            [[0, 0], [width, 0], [0, height], [width, height]].map(|corner| corner.map(|v| v as f64));
        let moves = corners.map(|[x, y]| {
            let [u, v] = applied(self.to_far, [x, y]);
            (u - x).abs().max((v - y).abs())
        });
        let farthest = moves.into_iter().fold(0.0, f64::max);
        let margin = (border + farthest).ceil().clamp(0.0, 1e6) as usize;
        for y in 0..height {
            let deep = y >= margin && y + margin < height;
            for x in 0..width {
                if deep && x >= margin && x + margin < width {
                    continue;
                }
                let near = [x as f64, y as f64];
                if !inside(near) || !inside(applied(self.to_far, near)) {
                    flags[y * width + x] |= Flag::Border.bit();
                }
            }
        }
    }

    fn summary(&self, depth_mm: &[f32], flags: &[u8]) -> Summary {
        let mut known: Vec<f32> = depth_mm.iter().copied().filter(|depth| depth.is_finite()).collect();
        let coverage = known.len() as f64 / depth_mm.len() as f64;
        let depth = (!known.is_empty()).then(|| {
            let middle = known.len() / 2;
            let (below, &mut median, above) = known.select_nth_unstable_by(middle, f32::total_cmp);
            let min = below.iter().copied().fold(median, f32::min);
            let max = above.iter().copied().fold(median, f32::max);
            DepthSpan { min: min.into(), median: median.into(), max: max.into() }
        });
        let count = |raised: &dyn Fn(u8) -> bool| flags.iter().filter(|&&flags| raised(flags)).count() as u64;
        let flag_counts = Flag::ALL.map(|flag| count(&|flags| flags & flag.bit() != 0));
        let without =
            Flag::LowTexture.bit() | Flag::Ambiguous.bit() | Flag::Border.bit() | Flag::Saturated.bit();
        let textured = count(&|flags| flags & without == 0);
        let inconsistent = count(&|flags| flags & without == 0 && flags & Flag::Inconsistent.bit() != 0);
        let mut warnings = self.warnings.clone();
        if inconsistent as f64 > WARN_INCONSISTENT * textured as f64 {
            warnings.push(Warning::ManyInconsistent);
        }
        if coverage < WARN_COVERAGE {
            warnings.push(Warning::LowCoverage);
        }
        Summary {
            near_focus_mm: self.optics.near_focus_mm(),
            far_focus_mm: self.optics.far_focus_mm(),
            coverage,
            depth,
            noise_sigma: self.noise_sigma,
            shift_px: self.shift_px,
            gain: self.gain,
            flag_counts,
            warnings,
        }
    }
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
    fn a_median_looks_at_what_is_known_only() {
        let nan = f32::NAN;
        let values = [1.0, 2.0, 9.0, nan, 5.0, nan, 3.0, nan, 4.0];
        let out = medians(&values, 3, 3, 3);
        // 1 2 9 5 3 4 about the middle: between 3 and 4
        assert_eq!(out[4], 3.5);
        assert!(out[3].is_nan() && out[5].is_nan());
        assert_eq!(out[0], 2.0);
    }
}
