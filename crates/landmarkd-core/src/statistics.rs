//! Order statistics: the median, and quantiles by the three conventions that are in use here, named as NumPy names them.

use std::cmp::Ordering;

/// The upper median: of an even number of values the larger of the two in the middle; `None` without values.
///
/// Reorders the values.
pub fn median<T: Copy>(values: &mut [T], order: impl FnMut(&T, &T) -> Ordering) -> Option<T> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, order).1)
}

/// The quantile of a `part` (0..=1) of the values, linear between the two nearest (NumPy's default); `None` without
/// values.
pub fn quantile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let at = part * last as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + (high - low) * at.fract())
}

/// The value nearest to the quantile of a `part` (0..=1) of the values (NumPy's `nearest`, halves upwards); `None`
/// without values.
///
/// Reorders the values.
pub fn quantile_nearest<T: Copy>(
    values: &mut [T],
    part: f64,
    order: impl FnMut(&T, &T) -> Ordering,
) -> Option<T> {
    let last = values.len().checked_sub(1)?;
    Some(*values.select_nth_unstable_by((part * last as f64).round() as usize, order).1)
}

/// The least of ascending values that at least a `part` (0..=1) of them doesn't exceed (nearest rank, NumPy's
/// `inverted_cdf`); `None` without values.
pub fn nearest_rank(ascending: &[f64], part: f64) -> Option<f64> {
    let rank = (part * ascending.len() as f64).ceil() as usize;
    ascending.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_of_values_is_the_upper_one() {
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0], f64::total_cmp), Some(3.0));
        assert_eq!(median(&mut [3, 1, 2], Ord::cmp), Some(2));
        assert_eq!(median(&mut [], f32::total_cmp), None);
    }

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.5), Some(2.5));
        assert_eq!(quantile(&[4.0], 0.97), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn the_nearest_quantile_is_a_value() {
        let nearest = |part| quantile_nearest(&mut [40.0, 10.0, 30.0, 20.0], part, f64::total_cmp);
        assert_eq!([0.0, 0.3, 0.5, 1.0].map(nearest), [10.0, 20.0, 30.0, 40.0].map(Some));
        assert_eq!(quantile_nearest(&mut [], 0.5, f64::total_cmp), None);
    }

    #[test]
    fn ranks_count_from_the_least() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(
            [0.0, 0.5, 0.951, 1.0].map(|part| nearest_rank(&hundred, part)),
            [1.0, 50.0, 96.0, 100.0].map(Some)
        );
        assert_eq!(nearest_rank(&[], 0.5), None);
    }
}
