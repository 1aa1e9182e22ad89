//! When to answer "unknown", B(16), and how sure an answer is: learnt from views that were left out.
//!
//! Each view is left out of its object and shown to it: so near are known objects. It is shown to all the other
//! objects: so near are unknown ones. Two things are not as they will be. A view that was left out meets a gap twice
//! as wide as a query does: the same with every fourth view alone says by how much the distance shrinks when the gap
//! halves, and half of that (its square root) is granted, to err on the side of the known. And objects differ in how
//! far their own views are apart: a distance is judged by the root of its object's scale, half way between one
//! threshold for all and one for each.

/// What held-out views taught.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// How much nearer a query is than a view that was left out, 0..=1.
    pub shrink: f64,
    /// The part of a residual that turns the pose: a residual has many directions, and only one is along the curve.
    pub angle_part: f64,
    /// Nothing that is accepted lies farther from an eigenpoint, in the universal eigenspace.
    pub radius: f64,
    /// The largest distance / √scale that is accepted.
    pub threshold: f64,
    /// How sure an answer is by ln(distance / √scale); `None` if only one object is known.
    pub confidence: Option<Logistic>,
}

/// p(x) = 1 / (1 + exp(−(offset + slope·x))).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logistic {
    pub offset: f64,
    pub slope: f64,
}

/// Added to the diagonal of the Hessian: a fit to few cases stays finite.
const RIDGE: f64 = 1e-6;
const ITERATIONS: usize = 60;

impl Logistic {
    /// The fit of largest likelihood that does not rise with `x` (Platt 1999, with his targets: a few cases never give
    /// certainty).
    pub fn fit(right: &[f64], wrong: &[f64]) -> Logistic {
        let fit = Logistic::steepest(right, wrong);
        let (n, m) = (right.len() as f64, wrong.len() as f64);
        if fit.slope <= 0.0 { fit } else { Logistic { offset: ((n + 1.0) / (m + 1.0)).ln(), slope: 0.0 } }
    }

    fn steepest(right: &[f64], wrong: &[f64]) -> Logistic {
        let (n, m) = (right.len() as f64, wrong.len() as f64);
        let (high, low) = ((n + 1.0) / (n + 2.0), 1.0 / (m + 2.0));
        let cases = || right.iter().map(|&x| (x, high)).chain(wrong.iter().map(|&x| (x, low)));
        let mut fit = Logistic { offset: ((n + 1.0) / (m + 1.0)).ln(), slope: 0.0 };
        let loss = |fit: Logistic| {
            let part = |(x, target): (f64, f64)| {
                let z = fit.offset + fit.slope * x;
                // −target·ln p − (1 − target)·ln(1 − p), without overflow
                (1.0 - target) * z + (-z).max(0.0) + (-z.abs()).exp().ln_1p()
            };
            cases().map(part).sum::<f64>()
        };
        let mut now = loss(fit);
        for _ in 0..ITERATIONS {
            let (mut g0, mut g1, mut h00, mut h01, mut h11) = (0.0, 0.0, RIDGE, 0.0, RIDGE);
            for (x, target) in cases() {
                let p = fit.at(x);
                let (off, weight) = (p - target, p * (1.0 - p));
                g0 += off;
                g1 += off * x;
                h00 += weight;
                h01 += weight * x;
                h11 += weight * x * x;
            }
            let determinant = h00 * h11 - h01 * h01;
            let step = [(h11 * g0 - h01 * g1) / determinant, (h00 * g1 - h01 * g0) / determinant];
            let shorter = (0..20).map(|halvings| 0.5_f64.powi(halvings)).find_map(|part| {
                let next =
                    Logistic { offset: fit.offset - part * step[0], slope: fit.slope - part * step[1] };
                let value = loss(next);
                (value < now).then_some((next, value))
            });
            let Some((next, value)) = shorter else { break };
            let gained = now - value;
            (fit, now) = (next, value);
            if gained < 1e-10 {
                break;
            }
        }
        fit
    }

    /// How probable it is that an answer with evidence `x` is right, if as many known things are shown as unknown
    /// ones.
    pub fn at(&self, x: f64) -> f64 {
        1.0 / (1.0 + (-(self.offset + self.slope * x)).exp())
    }
}

/// The value below which a part of the values lies, between neighbours by proportion; `None` without values.
pub(super) fn quantile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = part * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + (high - low) * at.fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_tells_what_the_cases_tell() {
        // from −1 to 1 the share of right ones falls from all to none
        let cases: Vec<f64> = (0..2000).map(|i| f64::from(i) / 1000.0 - 1.0).collect();
        let is_right =
            |(i, x): &(usize, f64)| (i * 7919 % 1000) as f64 / 1000.0 > 1.0 / (1.0 + (-4.0 * x).exp());
        let (right, wrong): (Vec<_>, Vec<_>) = cases.into_iter().enumerate().partition(is_right);
        let values = |cases: Vec<(usize, f64)>| cases.into_iter().map(|(_, x)| x).collect::<Vec<f64>>();
        let fit = Logistic::fit(&values(right), &values(wrong));
        assert!((fit.slope + 4.0).abs() < 0.4 && fit.offset.abs() < 0.2, "{fit:?}");
    }

    #[test]
    fn cases_that_never_mix_give_no_certainty() {
        let fit = Logistic::fit(&[-3.0, -2.0, -2.5], &[1.0, 2.0]);
        assert!(fit.at(-2.5) > 0.7 && fit.at(-2.5) < 1.0 && fit.at(1.5) < 0.3, "{fit:?}");
        assert!(fit.slope.is_finite());
        let alone = Logistic::fit(&[], &[0.5, 0.7]);
        assert!(alone.at(0.6) < 0.5);
        let rising = Logistic::fit(&[1.0, 2.0], &[-3.0, -2.0]);
        assert_eq!((rising.slope, rising.at(9.0)), (0.0, 0.5), "a farther thing is never surer");
    }

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.5), Some(2.5));
        assert_eq!(quantile(&[4.0], 0.97), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
