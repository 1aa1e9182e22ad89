//! The real roots of a polynomial.

/// Rounds of the search in one bracket.
const MOST_ROUNDS: usize = 80;
/// A root is known to within this part of it.
const CLOSE: f64 = 1e-13;

/// The real roots of Σ cₖ xᵏ, coefficients from the constant on, ascending; a root that the polynomial touches without crossing
/// zero is not found.
///
/// Between neighbouring roots of the derivative the polynomial is monotone: it has one root there, or none.
pub fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let Some(degree) = coefficients.iter().rposition(|c| *c != 0.0).filter(|degree| *degree > 0) else {
        return Vec::new();
    };
    let coefficients = &coefficients[..=degree];
    if degree == 1 {
        return vec![-coefficients[0] / coefficients[1]];
    }
    let derivative: Vec<f64> = (1..=degree).map(|k| k as f64 * coefficients[k]).collect();
    // all roots are within Cauchy's bound
    let largest = coefficients[..degree].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    let bound = 1.0 + largest / coefficients[degree].abs();
    if !bound.is_finite() {
        return Vec::new();
    }
    let mut ends = vec![-bound];
    ends.extend(real_roots(&derivative).into_iter().filter(|at| at.abs() < bound));
    ends.push(bound);
    ends.windows(2).filter_map(|pair| root_between(coefficients, &derivative, pair[0], pair[1])).collect()
}

fn value(coefficients: &[f64], at: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * at + c)
}

/// The root in a bracket with values of different sign at its ends: Newton's method, and halving where that leads out of it.
fn root_between(coefficients: &[f64], derivative: &[f64], mut low: f64, mut high: f64) -> Option<f64> {
    let at_low = value(coefficients, low);
    if (at_low < 0.0) == (value(coefficients, high) < 0.0) {
        return None;
    }
    let mut at = 0.5 * (low + high);
    for _ in 0..MOST_ROUNDS {
        let here = value(coefficients, at);
        if (here < 0.0) == (at_low < 0.0) {
            low = at;
        } else {
            high = at;
        }
        let newton = at - here / value(derivative, at);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - at).abs() <= CLOSE * next.abs() {
            return Some(next);
        }
        at = next;
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_roots_of_a_product_are_those_of_its_factors() {
        let wanted = [-12.5, -1.0, -0.03, 0.4, 0.41, 3.0, 250.0];
        // times (x² + 1), which has none
        let mut product = vec![1.0, 0.0, 1.0];
        for root in wanted {
            let mut next = vec![0.0; product.len() + 1];
            for (k, c) in product.iter().enumerate() {
                next[k] -= root * c;
                next[k + 1] += c;
            }
            product = next;
        }
        let found = real_roots(&product);
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-7 * wanted.abs().max(1.0), "{found} {wanted}");
        }
    }

    #[test]
    fn constants_and_what_stays_above_zero_have_none() {
        assert!(
            real_roots(&[]).is_empty() && real_roots(&[3.0]).is_empty() && real_roots(&[0.0, 0.0]).is_empty()
        );
        assert!(real_roots(&[1.0, 0.0, 1.0]).is_empty());
        assert_eq!(real_roots(&[1.0, 2.0, 0.0]), [-0.5]);
    }
}
