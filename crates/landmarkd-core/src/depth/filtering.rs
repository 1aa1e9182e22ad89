//! The pictures through the kernels: q_j = a_j∗n + b_j∗f.

use pulp::{Arch, Simd, WithSimd};

use super::kernels::{KernelBank, RANK};
use crate::imaging::Image;

/// Pixels of one block.
const BLOCK: usize = 32;
/// The farthest that a kernel reaches.
const MOST_REACH: usize = 6;

/// The q_j of a pair, five planes of the pictures' size, row-major; pictures are continued beyond their border by their
/// outermost pixels.
pub(super) fn filtered(near: &Image, far: &Image, bank: &KernelBank) -> [Vec<f32>; RANK] {
    let (width, height, reach) = (near.width(), near.height(), bank.reach());
    // Rows are padded to whole blocks, with the reach on both sides.
    let padded_width = width.next_multiple_of(BLOCK) + 2 * reach;
    let padded = |image: &Image| {
        let mut pixels = Vec::with_capacity(height * padded_width);
        for y in 0..height {
            let row = image.row(y);
            pixels.resize(pixels.len() + reach, row[0]);
            pixels.extend_from_slice(row);
            pixels.resize((y + 1) * padded_width, row[width - 1]);
        }
        pixels
    };
    let pictures = [padded(near), padded(far)];
    let mut planes: [Vec<f32>; RANK] = std::array::from_fn(|_| vec![0.0; width * height]);
    for y in 0..height {
        let row = |picture: usize, dy: isize| {
            let y = y.saturating_add_signed(dy).min(height - 1);
            &pictures[picture][y * padded_width..][..padded_width]
        };
        for from in (0..width).step_by(BLOCK) {
            let mut sums = [[0.0; BLOCK]; RANK];
            for picture in 0..2 {
                let rows = |dy: isize| &row(picture, dy)[from..][..BLOCK + 2 * reach];
                let above = std::array::from_fn(|a| rows(-(a.min(reach) as isize)));
                let below = std::array::from_fn(|a| rows(a.min(reach) as isize));
                Arch::new().dispatch(Filter { picture, bank, above, below, sums: &mut sums });
            }
            let count = BLOCK.min(width - from);
            for (plane, sums) in planes.iter_mut().zip(&sums) {
                plane[y * width + from..][..count].copy_from_slice(&sums[..count]);
            }
        }
    }
    planes
}

/// Adds one picture's part of a block of pixels to the sums of all kernels. Row a above and below has the
/// block's pixels and the kernels' reach on both sides.
struct Filter<'a> {
    picture: usize,
    bank: &'a KernelBank,
    above: [&'a [f32]; MOST_REACH + 1],
    below: [&'a [f32]; MOST_REACH + 1],
    sums: &'a mut [[f32; BLOCK]; RANK],
}

impl WithSimd for Filter<'_> {
    type Output = ();

    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators over the lanes are not inlined into vector code here"
    )]
    fn with_simd<S: Simd>(self, _simd: S) {
        let reach = self.bank.reach();
        // The rows a above and below, added: kernels are symmetric.
        let mut folded = [[0.0_f32; BLOCK + 2 * MOST_REACH]; MOST_REACH + 1];
        let length = BLOCK + 2 * reach;
        for a in 0..=reach {
            let (above, below, out) =
                (&self.above[a][..length], &self.below[a][..length], &mut folded[a][..length]);
            for x in 0..length {
                out[x] = if a == 0 { above[x] } else { above[x] + below[x] };
            }
        }
        for (number, &(a, b)) in self.bank.orbits.iter().enumerate() {
            let mut orbit = [0.0_f32; BLOCK];
            for (row, tap) in [(a, b), (b, a)] {
                let (left, right) =
                    (&folded[row][reach - tap..][..BLOCK], &folded[row][reach + tap..][..BLOCK]);
                for x in 0..BLOCK {
                    orbit[x] += if tap == 0 { left[x] } else { left[x] + right[x] };
                }
                if a == b {
                    break;
                }
            }
            let values = &self.bank.values[number][self.picture];
            for j in 0..RANK {
                let sum = &mut self.sums[j];
                for x in 0..BLOCK {
                    sum[x] += values[j] * orbit[x];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::scene::bench_optics;

    fn bank(f_number: f64) -> KernelBank {
        KernelBank::new(&bench_optics(f_number, true), 0)
    }

    /// Tap by tap.
    fn direct(near: &Image, far: &Image, bank: &KernelBank, j: usize, x: usize, y: usize) -> f32 {
        let reach = bank.reach() as isize;
        let mut sum = 0.0;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let (a, b) =
                    (dx.unsigned_abs().min(dy.unsigned_abs()), dx.unsigned_abs().max(dy.unsigned_abs()));
                let orbit = bank.orbits.iter().position(|&orbit| orbit == (a, b)).unwrap();
                let column = x.saturating_add_signed(dx).min(near.width() - 1);
                let row = y.saturating_add_signed(dy).min(near.height() - 1);
                let [of_near, of_far] = bank.values[orbit];
                sum += of_near[j] * near.at(column, row) + of_far[j] * far.at(column, row);
            }
        }
        sum
    }

    #[test]
    fn folded_equals_tap_by_tap() {
        for f_number in [8.0, 6.0] {
            let bank = bank(f_number);
            for (width, height) in [(45, 21), (32, 7), (3, 2)] {
                let noise = |salt: usize| {
                    Image::from_fn(width, height, |x, y| ((x * 37 + y * 101 + salt) * 7919 % 256) as f32)
                };
                let (near, far) = (noise(1), noise(5));
                let planes = filtered(&near, &far, &bank);
                for (j, plane) in planes.iter().enumerate() {
                    for (at, fast) in plane.iter().enumerate() {
                        let (x, y) = (at % width, at / width);
                        let slow = direct(&near, &far, &bank, j, x, y);
                        assert!((fast - slow).abs() < 2e-3, "q{j} at ({x}, {y}): {fast} is not {slow}");
                    }
                }
            }
        }
    }
}
