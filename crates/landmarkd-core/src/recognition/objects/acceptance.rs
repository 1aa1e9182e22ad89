//! When to answer "unknown", B(16), and the confidence of an answer: estimated from held-out views.
//!
//! Each view is left out of its object and shown to it: the distance of a known object. It is shown to all the other
//! objects: the distance of an unknown one. Two corrections follow. A view that is left out lies in a gap twice as wide
//! as a query does: the same with every fourth view alone says by how much the distance falls when the gap halves, and
//! half of that (its square root) is applied, to err on the side of the known. And objects differ in the distance
//! between their own views: a distance is divided by the root of its object's scale, half way between one threshold for
//! all and one for each.

/// How a database decides whether a picture shows a known object, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceptance {
    /// The distance of a query, of gradients the error of its pose, as a part of that of a held-out view, 0..=1.
    pub distance_ratio: f64,
    /// The part of a residual that is along the manifold and so shifts the pose, 0..=1.
    pub tangential_part: f64,
    /// Nothing that is accepted lies farther from an eigenpoint, in the universal eigenspace.
    pub radius: f64,
    /// The largest distance / √scale that is accepted.
    pub threshold: f64,
    /// Confidence by ln(distance / √scale); `None` if only one object is known.
    pub confidence: Option<Logistic>,
}

/// p(x) = 1 / (1 + exp(−(offset + slope·x))).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logistic {
    /// Log odds at x = 0.
    pub offset: f64,
    /// Change of the log odds with x.
    pub slope: f64,
}

/// Added to the diagonal of the Hessian: a fit to few cases stays finite.
const RIDGE: f64 = 1e-6;
const ITERATIONS: usize = 60;
/// A step that reduces the loss by less is the last.
const MIN_GAIN: f64 = 1e-10;

/// A value of the evidence with the probability that the fit should give it.
struct Case {
    x: f64,
    target: f64,
}

impl Logistic {
    /// The maximum-likelihood fit that does not rise with `x` (Platt 1999, with his targets: a few cases never give
    /// certainty).
    pub fn fit(right: &[f64], wrong: &[f64]) -> Logistic {
        let (n, m) = (right.len() as f64, wrong.len() as f64);
        let constant = Logistic { offset: ((n + 1.0) / (m + 1.0)).ln(), slope: 0.0 };
        let (high, low) = ((n + 1.0) / (n + 2.0), 1.0 / (m + 2.0));
        let right = right.iter().map(|&x| Case { x, target: high });
        let cases: Vec<Case> = right.chain(wrong.iter().map(|&x| Case { x, target: low })).collect();
        let fit = constant.minimised(&cases);
        if fit.slope <= 0.0 { fit } else { constant }
    }

    /// Newton's method on the cross entropy, each step halved until the loss falls.
    fn minimised(mut self, cases: &[Case]) -> Logistic {
        let mut loss = self.loss(cases);
        for _ in 0..ITERATIONS {
            let step = self.newton_step(cases);
            let shorter = (0..20).map(|halvings| 0.5_f64.powi(halvings)).find_map(|part| {
                let next = Logistic {
                    offset: self.offset - part * step.offset,
                    slope: self.slope - part * step.slope,
                };
                let value = next.loss(cases);
                (value < loss).then_some((next, value))
            });
            let Some((next, value)) = shorter else { break };
            let gain = loss - value;
            (self, loss) = (next, value);
            if gain < MIN_GAIN {
                break;
            }
        }
        self
    }

    fn loss(&self, cases: &[Case]) -> f64 {
        let part = |case: &Case| {
            let z = self.offset + self.slope * case.x;
            // −target·ln p − (1 − target)·ln(1 − p), without overflow
            (1.0 - case.target) * z + (-z).max(0.0) + (-z.abs()).exp().ln_1p()
        };
        cases.iter().map(part).sum()
    }

    /// H⁻¹ ∇ of the loss.
    fn newton_step(&self, cases: &[Case]) -> Logistic {
        let (mut g0, mut g1, mut h00, mut h01, mut h11) = (0.0, 0.0, RIDGE, 0.0, RIDGE);
        for &Case { x, target } in cases {
            let p = self.at(x);
            let (error, weight) = (p - target, p * (1.0 - p));
            g0 += error;
            g1 += error * x;
            h00 += weight;
            h01 += weight * x;
            h11 += weight * x * x;
        }
        let determinant = h00 * h11 - h01 * h01;
        Logistic { offset: (h11 * g0 - h01 * g1) / determinant, slope: (h00 * g1 - h01 * g0) / determinant }
    }

    /// The evidence at which right is so many times as likely as wrong; `None` if it doesn't tell them apart.
    pub fn evidence_at(&self, odds: f64) -> Option<f64> {
        (self.slope < 0.0).then(|| (odds.ln() - self.offset) / self.slope)
    }

    /// The probability that an answer with evidence `x` is right, if known and unknown objects are equally frequent.
    pub fn at(&self, x: f64) -> f64 {
        1.0 / (1.0 + (-(self.offset + self.slope * x)).exp())
    }
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
}
