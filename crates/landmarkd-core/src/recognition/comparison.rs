//! Paired comparison of two databases on the same frames, by the sign test: is the candidate worse than the database in
//! use, beyond chance?
//!
//! Frames of one exemplar resemble each other, so chance explains somewhat more than the sign test grants: the test
//! errs on the side of the database in use.

/// Significance level: an equally good candidate is called worse in at most one comparison of twenty.
const SIGNIFICANCE: f64 = 0.05;

/// How many frames a candidate and the database in use answered correctly, of the same frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Frames that both were asked about.
    pub trials: usize,
    /// Frames that the candidate answered correctly.
    pub candidate_right: usize,
    /// Frames that the database in use answered correctly.
    pub current_right: usize,
    /// Frames that the candidate alone answered correctly.
    pub candidate_only: usize,
    /// Frames that the database in use alone answered correctly.
    pub current_only: usize,
    /// Probability that, of the frames on which they differ, as many as [`Comparison::current_only`] or more go to the
    /// database in use if both are equally good (one-sided sign test).
    pub p_value: f64,
}

impl Comparison {
    /// Compares the correctness of the answers, frame by frame.
    ///
    /// # Panics
    /// If `candidate` and `current` differ in length.
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
            p_value: binomial_tail(current_only, candidate_only + current_only),
        }
    }

    /// Whether the candidate is significantly worse.
    pub fn candidate_is_worse(&self) -> bool {
        self.p_value < SIGNIFICANCE
    }
}

/// Probability of `heads` or more heads in `tosses` of a fair coin.
fn binomial_tail(heads: usize, tosses: usize) -> f64 {
    // each term from the one before, in logarithms as 2^-tosses may underflow
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
        assert_eq!(binomial_tail(0, 0), 1.0);
        assert!((binomial_tail(5, 5) - 1.0 / 32.0).abs() < 1e-12);
        assert!((binomial_tail(2, 3) - 0.5).abs() < 1e-12);
        assert!((binomial_tail(5000, 10_000) - 0.504).abs() < 1e-3);
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
