//! The background of a picture: the mean of the square around each pixel, of background pixels only.
//!
//! It changes slowly, so it has one mean for each block of pixels, a sixteenth of the square's side, and is interpolated
//! between the blocks' middles: an eighth of the work, and less than a gray level's difference.

/// Blocks along the side of a square.
const BLOCKS: usize = 16;
/// Below this part of a square, background isn't enough to know its mean.
const LEAST_PART: f64 = 0.02;

/// Means of squares around blocks of pixels.
pub(super) struct Background {
    width: usize,
    height: usize,
    /// Pixels along the side of a block.
    side: usize,
    /// Blocks on each side of the middle one.
    radius: usize,
    columns: usize,
    rows: usize,
    /// Row-major.
    means: Vec<f32>,
}

impl Background {
    /// Room for the means of a picture in squares of `window` pixels.
    pub fn new(width: usize, height: usize, window: usize) -> Background {
        let side = (window / BLOCKS).max(1);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        let radius = (window / side / 2).max(1);
        Background { width, height, side, radius, columns, rows, means: vec![0.0; columns * rows] }
    }

    /// Updates the means, of the pixels that are at most `offset` above `ground`; where hardly one is, the mean stays as
    /// it was.
    pub fn update(&mut self, levels: &[f32], ground: &[f32], offset: f32) {
        if self.means.is_empty() {
            return;
        }
        let (sums, counts) = self.integrals(levels, ground, offset);
        let (side, radius, stride) = (self.side, self.radius, self.columns + 1);
        for row in 0..self.rows {
            let (top, bottom) = (row.saturating_sub(radius), (row + radius + 1).min(self.rows));
            for column in 0..self.columns {
                let (left, right) = (column.saturating_sub(radius), (column + radius + 1).min(self.columns));
                let within = |integral: &[f64]| {
                    let at = |row: usize, column: usize| integral[row * stride + column];
                    at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left)
                };
                let count = within(&counts);
                let height = (bottom * side).min(self.height) - top * side;
                let width = (right * side).min(self.width) - left * side;
                if count > LEAST_PART * (width * height) as f64 {
                    self.means[row * self.columns + column] = (within(&sums) / count) as f32;
                }
            }
        }
    }

    /// Integral images, by blocks, of the gray levels and of the number of background pixels, with a row and a column of
    /// zeros before the first.
    fn integrals(&self, levels: &[f32], ground: &[f32], offset: f32) -> (Vec<f64>, Vec<f64>) {
        let stride = self.columns + 1;
        let mut sums = vec![0.0_f64; stride * (self.rows + 1)];
        let mut counts = sums.clone();
        let strip = self.side * self.width;
        let (mut level_sums, mut pixels) = (vec![0.0_f32; self.width], vec![0.0_f32; self.width]);
        for (row, (levels, ground)) in levels.chunks(strip).zip(ground.chunks(strip)).enumerate() {
            level_sums.fill(0.0);
            pixels.fill(0.0);
            for (levels, ground) in levels.chunks_exact(self.width).zip(ground.chunks_exact(self.width)) {
                let columns = level_sums.iter_mut().zip(&mut pixels).zip(levels).zip(ground);
                for (((sum, pixels), &level), &ground) in columns {
                    let kept = if level - ground <= offset { 1.0 } else { 0.0 };
                    *sum += kept * level;
                    *pixels += kept;
                }
            }
            let (mut sum, mut count) = (0.0, 0.0);
            let blocks = level_sums.chunks(self.side).zip(pixels.chunks(self.side));
            for (column, (levels, pixels)) in blocks.enumerate() {
                sum += f64::from(levels.iter().sum::<f32>());
                count += f64::from(pixels.iter().sum::<f32>());
                let at = (row + 1) * stride + column + 1;
                sums[at] = sums[at - stride] + sum;
                counts[at] = counts[at - stride] + count;
            }
        }
        (sums, counts)
    }

    /// Writes the background of every pixel: bilinear between the middles of the blocks.
    pub fn interpolate(&self, out: &mut [f32]) {
        if self.means.is_empty() {
            return;
        }
        let columns: Vec<Between> = (0..self.width).map(|x| self.between(x, self.columns)).collect();
        // A row of blocks, interpolated to the picture's width.
        let stretched = |row: usize, out: &mut [f32]| {
            let means = &self.means[row * self.columns..][..self.columns];
            for (out, place) in out.iter_mut().zip(&columns) {
                *out = means[place.before] + place.part * (means[place.after] - means[place.before]);
            }
        };
        let (mut upper, mut lower) = (vec![0.0; self.width], vec![0.0; self.width]);
        let mut drawn = None;
        for (y, out) in out.chunks_exact_mut(self.width).enumerate() {
            let Between { before, after, part } = self.between(y, self.rows);
            if drawn != Some(before) {
                stretched(before, &mut upper);
                stretched(after, &mut lower);
                drawn = Some(before);
            }
            for ((out, upper), lower) in out.iter_mut().zip(&upper).zip(&lower) {
                *out = upper + part * (lower - upper);
            }
        }
    }

    /// The place of a pixel between the middles of so many blocks; beyond the outermost middle, that middle.
    fn between(&self, at: usize, blocks: usize) -> Between {
        let place = ((at as f32 + 0.5) / self.side as f32 - 0.5).clamp(0.0, (blocks - 1) as f32);
        let before = place as usize;
        Between { before, after: (before + 1).min(blocks - 1), part: place - before as f32 }
    }
}

/// A place between two blocks, and how far it is from the first to the second.
struct Between {
    before: usize,
    after: usize,
    part: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: usize, height: usize) -> Vec<f32> {
        (0..width * height).map(|at| ((at * 37) % 101) as f32 + 0.1 * (at % width) as f32).collect()
    }

    fn means(levels: &[f32], width: usize, window: usize) -> Background {
        let mut background = Background::new(width, levels.len() / width, window);
        background.update(levels, &vec![f32::INFINITY; levels.len()], 0.0);
        background
    }

    #[test]
    fn with_blocks_of_a_pixel_means_are_those_of_looking_at_each() {
        let (width, height) = (17, 11);
        let levels = picture(width, height);
        for window in [3, 7, 31] {
            let mut background = means(&levels, width, window);
            let whole = background.means.clone();
            background.update(&levels, &whole, 5.0);
            let radius = window / 2;
            for at in 0..levels.len() {
                let near = |other: &usize| {
                    (other % width).abs_diff(at % width) <= radius
                        && (other / width).abs_diff(at / width) <= radius
                };
                let mean = |kept: &dyn Fn(usize) -> bool| {
                    let inside = (0..levels.len()).filter(near).filter(|&k| kept(k));
                    let inside: Vec<f32> = inside.map(|k| levels[k]).collect();
                    inside.iter().sum::<f32>() / inside.len() as f32
                };
                assert!((whole[at] - mean(&|_| true)).abs() < 1e-3, "window {window}, {at}");
                let kept = mean(&|k| levels[k] - whole[k] <= 5.0);
                assert!((background.means[at] - kept).abs() < 1e-3, "window {window}, {at}");
            }
        }
    }

    #[test]
    fn blocks_change_hardly_anything() {
        let (width, height) = (203, 149);
        let levels = picture(width, height);
        let background = means(&levels, width, 64);
        assert_eq!(background.side, 4);
        let mut drawn = vec![0.0; levels.len()];
        background.interpolate(&mut drawn);
        for (x, y) in [(0, 0), (100, 70), (202, 148), (31, 90), (150, 3)] {
            let inside = |at: &usize| (at % width).abs_diff(x) <= 32 && (at / width).abs_diff(y) <= 32;
            let around: Vec<f32> = (0..levels.len()).filter(inside).map(|at| levels[at]).collect();
            let mean = around.iter().sum::<f32>() / around.len() as f32;
            let found = drawn[y * width + x];
            assert!((found - mean).abs() < 1.0, "({x}, {y}): {found}, not {mean}");
        }
    }

    #[test]
    fn where_nothing_is_near_the_mean_stays() {
        let levels = vec![50.0; 40 * 30];
        let mut background = means(&levels, 40, 16);
        background.update(&levels, &levels, -1.0);
        assert!(background.means.iter().all(|&mean| mean == 50.0));
    }
}
