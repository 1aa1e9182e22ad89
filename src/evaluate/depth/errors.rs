//! How far measured depths are from true ones.

use std::fmt;

use serde::Serialize;

use crate::evaluate::Rate;
use landmarkd_core::statistics::median;

/// A true depth off by more than this share of the range counts as off.
const OFF_SHARE: f64 = 0.05;

/// Errors over the pixels whose depth is both measured and known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DepthErrors {
    /// Measured pixels, of those with a known depth.
    pub measured: Rate,
    /// Root mean square.
    pub rms_mm: f64,
    /// Of the working range, as all percentages here.
    pub rms_percent: f64,
    /// Mean of measured − true.
    pub bias_mm: f64,
    /// The same of the range.
    pub bias_percent: f64,
    /// Median of the errors' sizes.
    pub median_abs_mm: f64,
    /// The same of the range.
    pub median_abs_percent: f64,
    /// Pixels off by more than 5 % of the range.
    pub off: Rate,
    /// Correlation of the depths; none if either doesn't vary.
    pub pearson: Option<f64>,
    /// Correlation of their ranks.
    pub spearman: Option<f64>,
    /// Root mean square of error / expected standard deviation: 1 if the expectation is right; none if the method has
    /// no expectation.
    pub rms_over_sigma: Option<f64>,
}

/// One pixel, in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPair {
    /// NaN if there is none.
    pub measured_mm: f64,
    /// The true depth.
    pub true_mm: f64,
    /// Expected standard deviation of the measured depth; NaN if there is none.
    pub sigma_mm: f64,
}

impl DepthErrors {
    /// The errors over pixels with known depth; `None` if none of them is measured.
    pub fn of(pixels: &[DepthPair], range_mm: f64) -> Option<DepthErrors> {
        let known: Vec<DepthPair> =
            pixels.iter().copied().filter(|pixel| !pixel.measured_mm.is_nan()).collect();
        if known.is_empty() {
            return None;
        }
        let errors: Vec<f64> = known.iter().map(|pixel| pixel.measured_mm - pixel.true_mm).collect();
        let percent = |mm: f64| 100.0 * mm / range_mm;
        let rms_mm = root_mean_square(errors.iter().copied()).unwrap_or_default();
        let bias_mm = mean(&errors);
        let mut absolute: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        let median_abs_mm = median(&mut absolute, f64::total_cmp)?;
        let [measured, truth] = [|pixel: &DepthPair| pixel.measured_mm, |pixel: &DepthPair| pixel.true_mm]
            .map(|of| known.iter().map(of).collect::<Vec<f64>>());
        let over_sigma = known.iter().zip(&errors).map(|(pixel, error)| error / pixel.sigma_mm);
        Some(DepthErrors {
            measured: Rate::of(known.len(), pixels.len()),
            rms_mm,
            rms_percent: percent(rms_mm),
            bias_mm,
            bias_percent: percent(bias_mm),
            median_abs_mm,
            median_abs_percent: percent(median_abs_mm),
            off: Rate::among(absolute.iter().map(|error| *error > OFF_SHARE * range_mm)),
            pearson: correlation(&measured, &truth),
            spearman: correlation(&ranks(&measured), &ranks(&truth)),
            rms_over_sigma: root_mean_square(over_sigma.filter(|ratio| ratio.is_finite())),
        })
    }
}

impl fmt::Display for DepthErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let both = |mm: f64, percent: f64| format!("{mm:.3} mm ({percent:.2} % of the range)");
        let number =
            |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| format!("{value:.4}"));
        writeln!(f, "known and measured     {}", self.measured)?;
        writeln!(f, "RMS error              {}", both(self.rms_mm, self.rms_percent))?;
        writeln!(f, "bias                   {}", both(self.bias_mm, self.bias_percent))?;
        writeln!(f, "median absolute error  {}", both(self.median_abs_mm, self.median_abs_percent))?;
        writeln!(f, "off by over 5 %        {}", self.off)?;
        writeln!(f, "correlation            {}, of ranks {}", number(self.pearson), number(self.spearman))?;
        writeln!(f, "RMS of error / sigma   {}", number(self.rms_over_sigma))
    }
}

/// The line through (x, y) by least squares: slope and offset; `None` if x doesn't vary.
pub(super) fn line(x: &[f64], y: &[f64]) -> Option<[f64; 2]> {
    let (mean_x, mean_y) = (mean(x), mean(y));
    let sxy: f64 = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let sxx: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    (sxx > 0.0).then(|| [sxy / sxx, mean_y - sxy / sxx * mean_x])
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value * value, count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

fn correlation(x: &[f64], y: &[f64]) -> Option<f64> {
    // The slopes of both lines: their product is the square of the correlation.
    let ([slope, _], [back, _]) = (line(x, y)?, line(y, x)?);
    Some((slope * back).max(0.0).sqrt().copysign(slope))
}

/// The rank of every value; equal ones share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let rank = first as f64 + (equal.len() - 1) as f64 / 2.0;
        equal.iter().for_each(|&at| ranks[at] = rank);
        first += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(pairs: &[[f64; 3]]) -> Vec<DepthPair> {
        let pixel =
            |&[measured_mm, true_mm, sigma_mm]: &[f64; 3]| DepthPair { measured_mm, true_mm, sigma_mm };
        pairs.iter().map(pixel).collect()
    }

    #[test]
    fn errors_are_those_of_the_measured_pixels() {
        let pairs =
            [[501.0, 500.0, 1.0], [508.0, 510.0, 1.0], [f64::NAN, 515.0, f64::NAN], [528.0, 520.0, 4.0]];
        let errors = DepthErrors::of(&pixels(&pairs), 100.0).unwrap();
        assert_eq!((errors.measured, errors.off), (Rate::of(3, 4), Rate::of(1, 3)));
        assert!((errors.rms_mm - 23.0_f64.sqrt()).abs() < 1e-9);
        assert!((errors.bias_percent - 7.0 / 3.0).abs() < 1e-9);
        assert_eq!(errors.median_abs_mm, 2.0);
        assert_eq!(errors.spearman, Some(1.0));
        assert!((errors.rms_over_sigma.unwrap() - 3.0_f64.sqrt()).abs() < 1e-9);
        assert_eq!(DepthErrors::of(&pixels(&[[f64::NAN, 500.0, 1.0]]), 100.0), None);
    }

    #[test]
    fn a_wall_correlates_with_nothing_and_ties_share_their_rank() {
        let wall = DepthErrors::of(&pixels(&[[500.0, 500.0, f64::NAN]; 3]), 100.0).unwrap();
        assert_eq!((wall.pearson, wall.spearman, wall.rms_over_sigma), (None, None, None));
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 7.0]), [1.5, 0.0, 1.5, 3.0]);
        let falling = correlation(&[1.0, 2.0, 3.0], &[9.0, 7.0, 6.0]).unwrap();
        assert!((-1.0..-0.98).contains(&falling));
    }
}
