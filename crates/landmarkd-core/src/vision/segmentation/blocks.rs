//! Blocks of pixels: a grid that is coarse enough to fit surfaces on and fine enough to interpolate between.

/// So many blocks fit the picture's shorter side, if they needn't be smaller than a pixel or larger than [`LARGEST_PX`].
const BLOCKS: usize = 60;
/// Largest side of a block.
const LARGEST_PX: usize = 16;

/// The grid of blocks of a picture. Values by blocks are row-major.
pub(super) struct Blocks {
    width: usize,
    height: usize,
    /// Pixels along the side of a block.
    pub side: usize,
    pub columns: usize,
    pub rows: usize,
}

/// Sums over the pixels of each block that count.
#[derive(Clone)]
pub(super) struct BlockSums {
    pub pixels: Vec<f32>,
    pub values: Vec<f32>,
    pub squares: Vec<f32>,
}

impl Blocks {
    pub fn new(width: usize, height: usize) -> Blocks {
        let side = (width.min(height) / BLOCKS).clamp(1, LARGEST_PX);
        Blocks { width, height, side, columns: width.div_ceil(side), rows: height.div_ceil(side) }
    }

    pub fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether a block is at the picture's border.
    pub fn is_at_border(&self, block: usize) -> bool {
        let (column, row) = (block % self.columns, block / self.columns);
        column == 0 || row == 0 || column + 1 == self.columns || row + 1 == self.rows
    }

    /// Middle of a block, −1..=1 across and down the picture.
    pub fn position(&self, block: usize) -> [f64; 2] {
        let along = |at: usize, count: usize| (2 * at + 1) as f64 / count as f64 - 1.0;
        [along(block % self.columns, self.columns), along(block / self.columns, self.rows)]
    }

    /// Sums over every `step`th row of a block of the values that are at most `most` from 0.
    pub fn sums(&self, values: &[f32], most: f32, step: usize) -> BlockSums {
        let empty = |count: usize| BlockSums {
            pixels: vec![0.0; count],
            values: vec![0.0; count],
            squares: vec![0.0; count],
        };
        let (mut sums, mut columns) = (empty(self.count()), empty(self.width));
        for (row, strip) in values.chunks(self.side * self.width.max(1)).enumerate() {
            let BlockSums { pixels, values, squares } = &mut columns;
            pixels.fill(0.0);
            values.fill(0.0);
            squares.fill(0.0);
            for line in strip.chunks_exact(self.width).step_by(step) {
                for (((pixels, sum), squares), &v) in
                    pixels.iter_mut().zip(values.iter_mut()).zip(squares.iter_mut()).zip(line)
                {
                    let kept = if v.abs() <= most { 1.0 } else { 0.0 };
                    *pixels += kept;
                    *sum += kept * v;
                    *squares += kept * v * v;
                }
            }
            let row = row * self.columns..(row + 1) * self.columns;
            for (out, columns) in
                [(&mut sums.pixels, &*pixels), (&mut sums.values, &*values), (&mut sums.squares, &*squares)]
            {
                let blocks = out[row.clone()].iter_mut().zip(columns.chunks(self.side));
                blocks.for_each(|(out, columns)| *out = columns.iter().sum());
            }
        }
        sums
    }

    /// The mean of each block.
    pub fn means(&self, values: &[f32]) -> Vec<f32> {
        let sums = self.sums(values, f32::INFINITY, 1);
        sums.values.iter().zip(sums.pixels).map(|(sum, pixels)| sum / pixels).collect()
    }

    /// The sum over a window of `window` pixels about each block, or as near to that as whole blocks come; by integral
    /// images.
    pub fn window_sums(&self, values: &[f32], window: usize) -> Vec<f32> {
        let radius = (window / self.side / 2).max(1);
        let stride = self.columns + 1;
        let mut integral = vec![0.0_f64; stride * (self.rows + 1)];
        for row in 0..self.rows {
            let mut sum = 0.0;
            for column in 0..self.columns {
                sum += f64::from(values[row * self.columns + column]);
                let at = (row + 1) * stride + column + 1;
                integral[at] = integral[at - stride] + sum;
            }
        }
        let mut out = Vec::with_capacity(self.count());
        for row in 0..self.rows {
            let (top, bottom) = (row.saturating_sub(radius), (row + radius + 1).min(self.rows));
            for column in 0..self.columns {
                let (left, right) = (column.saturating_sub(radius), (column + radius + 1).min(self.columns));
                let at = |row: usize, column: usize| integral[row * stride + column];
                out.push((at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left)) as f32);
            }
        }
        out
    }

    /// Calls `use_row` with each row of the picture and the values of its pixels: bilinear between the middles of the
    /// blocks, and beyond the outermost middle, that middle's.
    pub fn interpolate(&self, values: &[f32], mut use_row: impl FnMut(usize, &[f32])) {
        if values.is_empty() {
            return;
        }
        let columns: Vec<Between> = (0..self.width).map(|x| self.between(x, self.columns)).collect();
        let stretched = |row: usize, out: &mut [f32]| {
            let values = &values[row * self.columns..][..self.columns];
            for (out, place) in out.iter_mut().zip(&columns) {
                *out = values[place.before] + place.part * (values[place.after] - values[place.before]);
            }
        };
        let (mut upper, mut lower, mut out) =
            (vec![0.0; self.width], vec![0.0; self.width], vec![0.0; self.width]);
        let mut drawn = None;
        for y in 0..self.height {
            let Between { before, after, part } = self.between(y, self.rows);
            if drawn != Some(before) {
                stretched(before, &mut upper);
                stretched(after, &mut lower);
                drawn = Some(before);
            }
            for ((out, upper), lower) in out.iter_mut().zip(&upper).zip(&lower) {
                *out = upper + part * (lower - upper);
            }
            use_row(y, &out);
        }
    }

    /// The place of a pixel between the middles of so many blocks.
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

    #[test]
    fn sums_are_those_of_the_pixels_that_count() {
        let (width, height) = (203, 149);
        let (blocks, values) = (Blocks::new(width, height), picture(width, height));
        assert_eq!((blocks.side, blocks.columns, blocks.rows), (2, 102, 75));
        let sums = blocks.sums(&values, 60.0, 2);
        for (column, row) in [(0, 0), (50, 31), (101, 74), (101, 3)] {
            let rows = (row * 2..(row * 2 + 2).min(height)).step_by(2);
            let inside = rows.flat_map(|y| values[y * width..][..width].chunks(2).nth(column).unwrap());
            let kept: Vec<f32> = inside.copied().filter(|v| v.abs() <= 60.0).collect();
            let block = row * blocks.columns + column;
            assert_eq!(sums.pixels[block], kept.len() as f32);
            assert!((sums.values[block] - kept.iter().sum::<f32>()).abs() < 1e-3);
            assert!((sums.squares[block] - kept.iter().map(|v| v * v).sum::<f32>()).abs() < 1e-1);
        }
    }

    #[test]
    fn window_sums_are_those_of_looking_at_each_block() {
        let blocks = Blocks::new(60, 40);
        let values = picture(blocks.columns, blocks.rows);
        for window in [1, 7, 31] {
            let radius = (window / 2).max(1);
            let sums = blocks.window_sums(&values, window);
            for at in (0..blocks.count()).step_by(7) {
                let near = |other: &usize| {
                    (other % blocks.columns).abs_diff(at % blocks.columns) <= radius
                        && (other / blocks.columns).abs_diff(at / blocks.columns) <= radius
                };
                let expected: f32 = (0..blocks.count()).filter(near).map(|other| values[other]).sum();
                assert!((sums[at] - expected).abs() < 1e-4 * expected, "window {window}, {at}");
            }
        }
    }

    #[test]
    fn a_slope_is_interpolated_as_it_is() {
        let blocks = Blocks::new(640, 480);
        let values: Vec<f32> = (0..blocks.count())
            .map(|block| {
                let [column, row] = [block % blocks.columns, block / blocks.columns].map(|at| at as f32);
                2.0 * (8.0 * column + 3.5) - (8.0 * row + 3.5)
            })
            .collect();
        blocks.interpolate(&values, |y, row| {
            if (4..476).contains(&y) {
                let off = (4..636).map(|x| (row[x] - 2.0 * x as f32 + y as f32).abs());
                assert!(off.fold(0.0, f32::max) < 1e-2, "row {y}");
            }
        });
    }
}
