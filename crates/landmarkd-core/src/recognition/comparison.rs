//! Two databases judged on the same frames: is the candidate worse than the one in use, beyond chance?
//!
//! Frames of one exemplar resemble each other, so chance explains somewhat more than the sign test grants: the test
//! errs on the side of the database in use.

/// A candidate that is worse by chance alone looks as bad as this one time in twenty.
const SIGNIFICANCE: f64 = 0.05;

/// How a candidate and the database in use did on the same frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Frames that both were shown.
    pub trials: usize,
    /// What the candidate said rightly.
    pub candidate_right: usize,
    /// What the database in use said rightly.
    pub current_right: usize,
    /// Right by the candidate alone.
    pub candidate_only: usize,
    /// Right by the database in use alone.
    pub current_only: usize,
    /// The chance that of the frames on which they differ so many or more go to the database in use, if both are
    /// equally good (sign test).
    pub p_value: f64,
}

impl Comparison {
    /// Compare what was said rightly, frame by frame.
    ///
    /// # Panics
    /// If they weren't shown the same number of frames.
    pub fn of(candidate: &[bool], current: &[bool]) -> Comparison {
        assert_eq!(candidate.len(), current.len(), "the same frames");
        let count = |wanted: fn(bool, bool) -> bool| {
            candidate.iter().zip(current).filter(|(a, b)| wanted(**a, **b)).count()
        };
        let (candidate_only, current_only) = (count(|a, b| a && !b), count(|a, b| b && !a));
        Comparison {
            trials: candidate.len(),
            candidate_right: count(|a, _| a),
            current_right: count(|_, b| b),
            candidate_only,
            current_only,
            p_value: at_least(current_only, candidate_only + current_only),
        }
    }

    /// Whether the candidate is worse beyond chance.
    pub fn candidate_is_worse(&self) -> bool {
        self.p_value < SIGNIFICANCE
    }
}

/// The chance of `heads` or more heads in `tosses` of a fair coin.
fn at_least(heads: usize, tosses: usize) -> f64 {
    // each chance from the one before, in logarithms as 2^-tosses may be too small for a number
    let mut logarithm = -(tosses as f64) * std::f64::consts::LN_2;
    let mut sum = 0.0;
    for k in 0..=tosses {
        if k >= heads {
            sum += logarithm.exp();
        }
        logarithm += ((tosses - k) as f64 / (k + 1) as f64).ln();
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coin_shows_heads_as_often_as_it_should() {
        assert_eq!(at_least(0, 0), 1.0);
        assert!((at_least(5, 5) - 1.0 / 32.0).abs() < 1e-12);
        assert!((at_least(2, 3) - 0.5).abs() < 1e-12);
        assert!((at_least(5000, 10_000) - 0.504).abs() < 1e-3);
    }

    #[test]
    fn worse_by_chance_is_not_worse() {
        let mut current = vec![true; 100];
        let mut candidate = vec![true; 100];
        candidate[..4].fill(false);
        let by_chance = Comparison::of(&candidate, &current);
        assert_eq!(
            (by_chance.candidate_right, by_chance.current_right, by_chance.current_only),
            (96, 100, 4)
        );
        assert!(!by_chance.candidate_is_worse(), "{by_chance:?}");
        candidate[..5].fill(false);
        assert!(Comparison::of(&candidate, &current).candidate_is_worse());
        // five lost and as many won
        current[50..55].fill(false);
        assert!(!Comparison::of(&candidate, &current).candidate_is_worse());
        assert!(!Comparison::of(&[], &[]).candidate_is_worse());
    }
}
