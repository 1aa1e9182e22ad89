//! Robust least squares by Levenberg and Marquardt's method, with the weights of Geman and McClure (Hartley and Zisserman 2004,
//! A6), and the covariance of what was found.

use crate::eigen::Symmetric;

/// Rounds at most.
const MOST_ROUNDS: usize = 30;
/// Step of the numerical derivative.
const STEP: f64 = 1e-6;
/// A step that changes the cost by less than this part ends the search.
const CLOSE: f64 = 1e-9;
/// Directions with less than this part of the largest information are not determined.
const LEAST_INFORMATION: f64 = 1e-12;

/// A residual in units of its expected deviation, and how much it counts: 0 where it says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// In expected deviations.
    pub value: f64,
    /// Its part of an independent observation.
    pub weight: f64,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Refined<P, const N: usize> {
    /// With the least cost.
    pub parameters: P,
    /// Of the local coordinates, row-major, by the measured size of the residuals.
    pub covariance: [[f64; N]; N],
    /// How large residuals are, in expected deviations.
    pub deviation: f64,
}

/// The parameters near `start` with the least robust cost Σ w r²/(1 + r²/width²), where `moved` takes parameters along N
/// local coordinates. None if the residuals don't determine them.
pub fn refined<P: Clone, const N: usize>(
    start: &P,
    width: f64,
    moved: impl Fn(&P, &[f64; N]) -> P,
    residuals: impl Fn(&P) -> Vec<Residual>,
) -> Option<Refined<P, N>> {
    let cost = |all: &[Residual]| -> f64 {
        all.iter().map(|r| r.weight * r.value.powi(2) / (1.0 + (r.value / width).powi(2))).sum()
    };
    let mut at = start.clone();
    let mut here = residuals(&at);
    let mut damping = 1e-3;
    for _ in 0..MOST_ROUNDS {
        let (information, gradient) = normal_equations(&at, &here, width, &moved, &residuals);
        let mut damped = information;
        (0..N).for_each(|i| damped[i][i] *= 1.0 + damping);
        let step = Symmetric::of(damped.as_flattened(), N)?.solve(&gradient);
        let step: [f64; N] = std::array::from_fn(|i| -step[i]);
        let next = moved(&at, &step);
        // what a residual counts may change from place to place: both places are judged by what counts now
        let mut there = residuals(&next);
        let (before, after) = (cost(&here), {
            there
                .iter_mut()
                .zip(&here)
                .for_each(|(there, here)| there.weight = there.weight.min(here.weight));
            cost(&there)
        });
        if after < before {
            at = next;
            here = residuals(&at);
            damping = (damping * 0.2).max(1e-9);
            if before - after < CLOSE * before {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    let (information, _) = normal_equations(&at, &here, width, &moved, &residuals);
    let eigen = Symmetric::of(information.as_flattened(), N)?;
    let [most, .., least] = &eigen.values[..] else { return None };
    if !(*least > LEAST_INFORMATION * most && *most > 0.0) {
        return None;
    }
    // redescending weights shrink the residuals that they are measured by: the deviation by the weighted sum over what is left
    let (mut square, mut count) = (0.0, 0.0);
    for r in &here {
        let robust = robust(r.value, width) * r.weight;
        square += robust * r.value.powi(2);
        count += robust;
    }
    let variance = square / (count - N as f64).max(1.0);
    let mut covariance = [[0.0; N]; N];
    for (value, vector) in eigen.values.iter().zip(&eigen.vectors) {
        for (row, a) in covariance.iter_mut().zip(vector) {
            row.iter_mut().zip(vector).for_each(|(sum, b)| *sum += variance * a * b / value);
        }
    }
    Some(Refined { parameters: at, covariance, deviation: variance.sqrt() })
}

/// The weight of Geman and McClure's loss.
fn robust(value: f64, width: f64) -> f64 {
    (1.0 + (value / width).powi(2)).powi(-2)
}

/// JᵀWJ and JᵀWr.
fn normal_equations<P, const N: usize>(
    at: &P,
    here: &[Residual],
    width: f64,
    moved: &impl Fn(&P, &[f64; N]) -> P,
    residuals: &impl Fn(&P) -> Vec<Residual>,
) -> ([[f64; N]; N], [f64; N]) {
    let aside: [Vec<Residual>; N] = std::array::from_fn(|along| {
        let mut step = [0.0; N];
        step[along] = STEP;
        residuals(&moved(at, &step))
    });
    let (mut information, mut gradient) = ([[0.0; N]; N], [0.0; N]);
    for (number, r) in here.iter().enumerate() {
        let weight = r.weight * robust(r.value, width);
        let slope: [f64; N] = std::array::from_fn(|along| (aside[along][number].value - r.value) / STEP);
        // where it says nothing a step aside, it has no slope
        if weight == 0.0 || aside.iter().any(|aside| aside[number].weight == 0.0) {
            continue;
        }
        for i in 0..N {
            gradient[i] += weight * slope[i] * r.value;
            (0..N).for_each(|j| information[i][j] += weight * slope[i] * slope[j]);
        }
    }
    (information, gradient)
}
