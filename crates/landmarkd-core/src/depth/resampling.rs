//! A picture seen through an affine map, without loss up to nearly half a cycle a pixel: the depth lies in the fine
//! detail that cheaper interpolation takes away.

use std::f64::consts::PI;

use crate::imaging::Image;

/// `[a, b, c, d, e, f]`: (x, y) ↦ (a·x + b·y + c, d·x + e·y + f).
pub(super) type Affine = [f64; 6];

/// Nothing moves.
pub(super) const IDENTITY: Affine = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Taps of the interpolation along an axis.
const TAPS: usize = 8;
/// Positions between two pixels that weights are kept for.
const PHASES: usize = 1024;
/// Shape of the Kaiser window over the sinc.
const KAISER: f64 = 5.0;

/// First `inner`, then `outer`.
pub(super) fn composed(outer: &Affine, inner: &Affine) -> Affine {
    let [a, b, c, d, e, f] = *inner;
    let [p, q, r, s, t, u] = *outer;
    [p * a + q * d, p * b + q * e, p * c + q * f + r, s * a + t * d, s * b + t * e, s * c + t * f + u]
}

/// Where the map takes a point.
pub(super) fn applied(affine: &Affine, [x, y]: [f64; 2]) -> [f64; 2] {
    let [a, b, c, d, e, f] = *affine;
    [a * x + b * y + c, d * x + e * y + f]
}

/// The image whose pixel p is the given one's at `affine`(p); border pixels are continued. For maps near the identity:
/// it works along x, then along y.
pub(super) fn resampled(image: &Image, affine: &Affine) -> Image {
    if *affine == IDENTITY {
        return image.clone();
    }
    let (width, height) = (image.width(), image.height());
    let [a, b, c, d, e, f] = *affine;
    let weights = Weights::new();
    // Row y' of the first pass holds what the second takes for the points that the map sends to y'.
    let across = Image::new(width, height, {
        let mut pixels = Vec::with_capacity(width * height);
        for row in 0..height {
            let source = image.row(row);
            pixels.extend((0..width).map(|x| {
                let y = (row as f64 - d * x as f64 - f) / e;
                weights.at(a * x as f64 + b * y + c, width, |column| source[column])
            }));
        }
        pixels
    });
    let mut out = Image::new(width, height, vec![0.0; width * height]);
    for y in 0..height {
        for x in 0..width {
            let from = d * x as f64 + e * y as f64 + f;
            let value = weights.at(from, height, |row| across.pixels()[row * width + x]);
            out.pixels_mut()[y * width + x] = value;
        }
    }
    out
}

/// The interpolation's weights for each phase.
struct Weights(Vec<[f32; TAPS]>);

impl Weights {
    fn new() -> Weights {
        let tap = |distance: f64| {
            let sinc = if distance == 0.0 { 1.0 } else { (PI * distance).sin() / (PI * distance) };
            let inside = 1.0 - (distance / (TAPS as f64 / 2.0)).powi(2);
            if inside > 0.0 { sinc * bessel_i0(KAISER * inside.sqrt()) } else { 0.0 }
        };
        let phases = (0..=PHASES).map(|phase| {
            let offset = phase as f64 / PHASES as f64;
            let taps: [f64; TAPS] = std::array::from_fn(|k| tap(k as f64 - (TAPS / 2 - 1) as f64 - offset));
            let sum: f64 = taps.iter().sum();
            taps.map(|v| (v / sum) as f32)
        });
        Weights(phases.collect())
    }

    fn at(&self, position: f64, length: usize, value: impl Fn(usize) -> f32) -> f32 {
        let position = position.clamp(-1.0, length as f64);
        let floor = position.floor();
        let weights = &self.0[((position - floor) * PHASES as f64).round() as usize];
        let first = floor as isize - (TAPS as isize / 2 - 1);
        let last = length as isize - 1;
        let inside = first >= 0 && first + TAPS as isize - 1 <= last;
        let column =
            |k: usize| if inside { first as usize + k } else { (first + k as isize).clamp(0, last) as usize };
        weights.iter().enumerate().map(|(k, weight)| weight * value(column(k))).sum()
    }
}

/// The modified Bessel function of order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(x: f64, y: f64) -> f64 {
        128.0 + 50.0 * (1.9 * x + 0.3).sin() + 40.0 * (0.5 * x - 1.7 * y).cos()
    }

    #[test]
    fn fine_waves_are_found_where_the_map_says() {
        let image = Image::from_fn(64, 48, |x, y| wave(x as f64, y as f64) as f32);
        for affine in [
            [1.0, 0.0, 0.4, 0.0, 1.0, -0.7],
            [0.99, 0.0, 0.3, 0.0, 0.99, 0.2],
            [1.002, 0.01, -0.4, -0.012, 0.998, 0.5],
        ] {
            let seen = resampled(&image, &affine);
            for y in 8..40 {
                for x in 8..56 {
                    let [u, v] = applied(&affine, [x as f64, y as f64]);
                    let (found, expected) = (f64::from(seen.at(x, y)), wave(u, v));
                    assert!((found - expected).abs() < 0.6, "({x}, {y}): {found}, not {expected}");
                }
            }
        }
    }

    #[test]
    fn maps_follow_one_another() {
        let (first, second) = ([0.9, 0.1, 2.0, -0.1, 1.1, -1.0], [1.0, 0.2, 0.5, 0.0, 0.8, 3.0]);
        let point = [3.0, -2.0];
        let at_once = applied(&composed(&second, &first), point);
        let one_by_one = applied(&second, applied(&first, point));
        assert!(at_once.iter().zip(one_by_one).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
