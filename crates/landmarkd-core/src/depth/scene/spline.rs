//! The light of a scene between its samples: a cubic B-spline through them.
//!
//! The plane goes on cyclically when it is read outside. Nothing here is shared with the registration of focal pairs,
//! which is tested with what this renders.

use crate::imaging::Image;

/// The pole of the filter that turns samples into coefficients: √3 − 2.
const POLE: f32 = -0.267_949_2;
/// Its powers beyond this one vanish.
const HORIZON: usize = 14;

/// The coefficients of the spline that runs through the samples.
pub(super) fn coefficients(mut samples: Image) -> Image {
    for _ in 0..2 {
        let width = samples.width();
        samples.pixels_mut().chunks_exact_mut(width).for_each(filter);
        samples = Image::from_fn(samples.height(), width, |x, y| samples.at(y, x));
    }
    samples
}

/// The coefficients of the means over squares of two samples, from those of the light itself.
pub(super) fn of_squares(coefficients: &Image) -> Image {
    // The integral of the cubic B-spline from −1 to 1, and about its neighbours.
    const MEANS: [f32; 5] = [1.0 / 48.0, 12.0 / 48.0, 22.0 / 48.0, 12.0 / 48.0, 1.0 / 48.0];
    let mut means = coefficients.clone();
    for _ in 0..2 {
        let (width, height) = (means.width(), means.height());
        means = Image::from_fn(height, width, |y, x| {
            let taps = MEANS.iter().enumerate();
            taps.map(|(k, weight)| weight * means.at((x + width + k - 2) % width, y)).sum()
        });
    }
    self::coefficients(means)
}

/// Along one row, cyclically: forwards, then backwards.
fn filter(row: &mut [f32]) {
    let last = row.len() - 1;
    let horizon = HORIZON.min(last);
    row[0] += row[last - horizon + 1..].iter().fold(0.0, |sum, value| POLE * (sum + value));
    for x in 1..row.len() {
        row[x] += POLE * row[x - 1];
    }
    row[last] =
        -POLE * row[..horizon].iter().rev().fold(0.0, |sum, value| POLE * (sum + value)) - POLE * row[last];
    for x in (0..last).rev() {
        row[x] = POLE * (row[x + 1] - row[x]);
    }
    row.iter_mut().for_each(|value| *value *= 6.0);
}

/// The spline's value at a place, in samples.
pub(super) fn value_at(coefficients: &Image, x: f64, y: f64) -> f32 {
    let (width, height) = (coefficients.width() as i64, coefficients.height() as i64);
    let (left, top) = (x.floor(), y.floor());
    let (across, down) = (weights((x - left) as f32), weights((y - top) as f32));
    // A division costs more than all the rest: most places have none of their samples outside.
    let within = |at: i64, length: i64| {
        if (0..length).contains(&at) { at as usize } else { at.rem_euclid(length) as usize }
    };
    let columns = [-1, 0, 1, 2].map(|step| within(left as i64 + step, width));
    let mut sum = 0.0;
    for (step, weight) in (-1..).zip(down) {
        let row = coefficients.row(within(top as i64 + step, height));
        let along: f32 = columns.iter().zip(across).map(|(&column, weight)| weight * row[column]).sum();
        sum += weight * along;
    }
    sum
}

/// Weights of the coefficients at −1, 0, 1 and 2 for a place between 0 and 1.
fn weights(part: f32) -> [f32; 4] {
    let rest = 1.0 - part;
    let outer = |t: f32| t * t * t / 6.0;
    let inner = |t: f32| 2.0 / 3.0 - t * t + t * t * t / 2.0;
    [outer(rest), inner(part), inner(rest), outer(part)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spline_runs_through_its_samples_and_between_them() {
        let turn = |at: f64, length: f64| std::f64::consts::TAU * 4.0 * at / length;
        let wave = |x: f64, y: f64| (40.0 * turn(x, 40.0).sin() + 30.0 * turn(y, 30.0).cos()) as f32;
        let spline = coefficients(Image::from_fn(40, 30, |x, y| wave(x as f64, y as f64)));
        for (x, y) in [(0.0, 0.0), (39.0, 29.0), (20.0, 10.0)] {
            assert!((value_at(&spline, x, y) - wave(x, y)).abs() < 0.01, "at {x}, {y}");
        }
        for (x, y) in [(15.5, 12.5), (39.25, 17.0), (-3.0, 29.7)] {
            let (value, expected) = (value_at(&spline, x, y), wave(x, y));
            assert!((value - expected).abs() < 0.3, "at {x}, {y}: {value}, not {expected}");
        }
    }
}
