//! Separable Gaussian smoothing, with mirror borders (`d c b | a b c d | c b a`).

use pulp::{Arch, Simd, WithSimd};

use crate::imaging::Image;

/// The kernel reaches this many standard deviations.
const REACH: f32 = 4.0;

/// The image convolved with a Gaussian of `sigma_px`, cut off at four of them; unchanged for sigma 0.
pub fn smoothed(image: &Image, sigma_px: f32) -> Image {
    let kernel = kernel(sigma_px);
    if kernel.len() == 1 || image.pixels().is_empty() {
        return image.clone();
    }
    let (width, height, reach) = (image.width(), image.height(), kernel.len() - 1);

    let mut padded = vec![0.0; width + 2 * reach];
    let beside = (0..reach).chain(reach + width..width + 2 * reach);
    let beside: Vec<(usize, usize)> =
        beside.map(|x| (x, mirrored(x as isize - reach as isize, width))).collect();
    // the rows that a kernel reaches, smoothed along x: mirrored rows are among them
    let kept = 2 * reach + 1;
    let mut across = vec![0.0; kept * width];
    let mut next = 0;
    let mut both = vec![0.0; width * height];
    for (y, out) in both.chunks_exact_mut(width).enumerate() {
        while next < height.min(y + reach + 1) {
            let row = image.row(next);
            padded[reach..reach + width].copy_from_slice(row);
            for &(x, column) in &beside {
                padded[x] = row[column];
            }
            let taps = (0..=reach).map(|k| (&padded[reach - k..], &padded[reach + k..]));
            let out = &mut across[next % kept * width..][..width];
            Arch::new().dispatch(WeightedPairs { out, kernel: &kernel, taps });
            next += 1;
        }
        let row = |y: isize| &across[mirrored(y, height) % kept * width..];
        let taps = (0..=reach as isize).map(|k| (row(y as isize - k), row(y as isize + k)));
        Arch::new().dispatch(WeightedPairs { out, kernel: &kernel, taps });
    }
    Image::new(width, height, both)
}

/// `out` = k₀·centre + Σ kᵢ·(before + after), in the order of the kernel.
pub(crate) struct WeightedPairs<'a, T> {
    pub(crate) out: &'a mut [f32],
    pub(crate) kernel: &'a [f32],
    pub(crate) taps: T,
}

impl<'a, T: Iterator<Item = (&'a [f32], &'a [f32])>> WithSimd for WeightedPairs<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) {
        // short kernels keep their sums in registers
        match self.kernel.len() {
            2 => self.at_once::<2>(),
            3 => self.at_once::<3>(),
            4 => self.at_once::<4>(),
            5 => self.at_once::<5>(),
            _ => self.pair_by_pair(),
        }
    }
}

impl<'a, T: Iterator<Item = (&'a [f32], &'a [f32])>> WeightedPairs<'_, T> {
    #[inline(always)]
    fn at_once<const N: usize>(&mut self) {
        let length = self.out.len();
        let mut pairs: [(&[f32], &[f32]); N] = [(&[], &[]); N];
        let mut weights = [0.0; N];
        for (k, (before, after)) in self.taps.by_ref().take(N).enumerate() {
            (pairs[k], weights[k]) = ((&before[..length], &after[..length]), self.kernel[k]);
        }
        let pairs = pairs.map(|(before, after)| (&before[..length], &after[..length]));
        for (p, out) in self.out.iter_mut().enumerate() {
            let mut sum = weights[0] * pairs[0].0[p];
            for k in 1..N {
                sum += weights[k] * (pairs[k].0[p] + pairs[k].1[p]);
            }
            *out = sum;
        }
    }

    #[inline(always)]
    fn pair_by_pair(&mut self) {
        for (k, (before, after)) in self.taps.by_ref().enumerate() {
            let weight = self.kernel[k];
            let centre = k == 0;
            let (before, after) = (&before[..self.out.len()], &after[..self.out.len()]);
            for (p, out) in self.out.iter_mut().enumerate() {
                *out = if centre { weight * before[p] } else { *out + weight * (before[p] + after[p]) };
            }
        }
    }
}

/// Half of the kernel, centre first; the whole sums to 1.
fn kernel(sigma_px: f32) -> Vec<f32> {
    let reach = (REACH * sigma_px + 0.5).floor().max(0.0) as usize;
    if reach == 0 {
        return vec![1.0];
    }
    let sigma = f64::from(sigma_px);
    let bell: Vec<f64> = (0..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let sum = 2.0 * bell.iter().sum::<f64>() - bell[0];
    bell.iter().map(|v| (v / sum) as f32).collect()
}

/// The index inside 0..`length` that a position outside mirrors; the border pixel is not repeated.
pub(crate) fn mirrored(position: isize, length: usize) -> usize {
    if length == 1 {
        return 0;
    }
    let period = 2 * (length - 1);
    let folded = position.rem_euclid(period as isize) as usize;
    folded.min(period - folded)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Two-dimensional, straight from the definition, in f64.
    fn direct(image: &Image, sigma_px: f32) -> Image {
        let half = kernel(sigma_px);
        let reach = half.len() as isize - 1;
        Image::from_fn(image.width(), image.height(), |x, y| {
            let mut sum = 0.0;
            for dy in -reach..=reach {
                for dx in -reach..=reach {
                    let column = mirrored(x as isize + dx, image.width());
                    let row = mirrored(y as isize + dy, image.height());
                    sum += f64::from(half[dx.unsigned_abs()])
                        * f64::from(half[dy.unsigned_abs()])
                        * f64::from(image.at(column, row));
                }
            }
            sum as f32
        })
    }

    #[test]
    fn borders_mirror_without_repeating_the_edge() {
        let folded: Vec<usize> = (-4..8).map(|i| mirrored(i, 4)).collect();
        assert_eq!(folded, [2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0, 1]);
        assert_eq!(mirrored(-7, 1), 0);
    }

    #[test]
    fn a_flat_picture_stays_flat() {
        let flat = smoothed(&Image::from_fn(9, 5, |_, _| 100.0), 1.0);
        assert!(flat.pixels().iter().all(|v| (v - 100.0).abs() < 1e-4));
    }

    proptest! {
        #[test]
        fn separable_equals_direct(
            (width, height, levels) in (1usize..40, 1usize..12).prop_flat_map(|(width, height)| {
                (Just(width), Just(height), prop::collection::vec(0u8..=255, width * height))
            }),
            sigma_px in 0.2f32..3.0,
        ) {
            let image = Image::new(width, height, levels.into_iter().map(f32::from).collect());
            let (fast, slow) = (smoothed(&image, sigma_px), direct(&image, sigma_px));
            for (a, b) in fast.pixels().iter().zip(slow.pixels()) {
                prop_assert!((a - b).abs() < 2e-3, "{a} is not {b}");
            }
        }
    }
}
