//! A monotone curve through measured points: violators pooled, cubic between, straight beyond.

/// A curve that never falls.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MonotoneCurve {
    x: Vec<f64>,
    y: Vec<f64>,
    slopes: Vec<f64>,
}

/// The values made never to fall: neighbours that do are replaced by their mean (pool adjacent violators).
pub(super) fn pooled(values: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for &value in values {
        let mut pool = (value, 1);
        while let Some(&(before, count)) = pools.last()
            && before > pool.0
        {
            pools.pop();
            let all = count + pool.1;
            pool = ((before * count as f64 + pool.0 * pool.1 as f64) / all as f64, all);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(value, count)| std::iter::repeat_n(value, count)).collect()
}

impl MonotoneCurve {
    /// The curve through points of rising `x` and never falling `y`, at least one of them (Fritsch and Carlson).
    pub(super) fn through(x: &[f64], y: &[f64]) -> MonotoneCurve {
        let chords: Vec<f64> =
            x.windows(2).zip(y.windows(2)).map(|(x, y)| (y[1] - y[0]) / (x[1] - x[0])).collect();
        let Some(last) = chords.len().checked_sub(1) else {
            return MonotoneCurve { x: x.to_vec(), y: y.to_vec(), slopes: vec![0.0; x.len()] };
        };
        let mut slopes = vec![chords[0]];
        for k in 0..last {
            let (before, after) = (chords[k], chords[k + 1]);
            let (left, right) = (x[k + 1] - x[k], x[k + 2] - x[k + 1]);
            let weights = (2.0 * right + left, right + 2.0 * left);
            let flat = before <= 0.0 || after <= 0.0;
            let harmonic = (weights.0 + weights.1) / (weights.0 / before + weights.1 / after);
            slopes.push(if flat { 0.0 } else { harmonic });
        }
        slopes.push(chords[last]);
        MonotoneCurve { x: x.to_vec(), y: y.to_vec(), slopes }
    }

    /// The same through points of never falling `x` too: those of equal `x` become one.
    pub(super) fn inverse_through(x: &[f64], y: &[f64]) -> MonotoneCurve {
        let (mut places, mut values): (Vec<f64>, Vec<f64>) = Default::default();
        let mut at = 0;
        while at < x.len() {
            let same = x[at..].iter().take_while(|&&v| v <= x[at]).count().max(1);
            places.push(x[at]);
            values.push(y[at..at + same].iter().sum::<f64>() / same as f64);
            at += same;
        }
        MonotoneCurve::through(&places, &values)
    }

    /// The curve's value and slope at a point.
    pub(super) fn at(&self, x: f64) -> (f64, f64) {
        let last = self.x.len() - 1;
        if x <= self.x[0] {
            return (self.y[0] + (x - self.x[0]) * self.slopes[0], self.slopes[0]);
        }
        if x >= self.x[last] {
            return (self.y[last] + (x - self.x[last]) * self.slopes[last], self.slopes[last]);
        }
        let k = self.x.partition_point(|&point| point <= x) - 1;
        let width = self.x[k + 1] - self.x[k];
        let t = (x - self.x[k]) / width;
        let (t2, t3) = (t * t, t * t * t);
        let value = self.y[k] * (2.0 * t3 - 3.0 * t2 + 1.0)
            + self.y[k + 1] * (3.0 * t2 - 2.0 * t3)
            + width * (self.slopes[k] * (t3 - 2.0 * t2 + t) + self.slopes[k + 1] * (t3 - t2));
        let slope = (self.y[k + 1] - self.y[k]) / width * (6.0 * t - 6.0 * t2)
            + self.slopes[k] * (3.0 * t2 - 4.0 * t + 1.0)
            + self.slopes[k + 1] * (3.0 * t2 - 2.0 * t);
        (value, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_falls_is_pooled() {
        assert_eq!(pooled(&[1.0, 3.0, 2.0, 4.0]), [1.0, 2.5, 2.5, 4.0]);
        assert_eq!(pooled(&[3.0, 2.0, 1.0]), [2.0, 2.0, 2.0]);
        assert_eq!(pooled(&[1.0, 1.0, 2.0]), [1.0, 1.0, 2.0]);
    }

    #[test]
    fn the_curve_meets_its_points_and_never_falls_between_them() {
        let (x, y) = ([0.0, 1.0, 1.5, 4.0, 5.0], [-1.0, -0.9, 0.5, 0.5, 2.0]);
        let curve = MonotoneCurve::through(&x, &y);
        for (x, y) in x.iter().zip(y) {
            assert!((curve.at(*x).0 - y).abs() < 1e-12);
        }
        let mut before = f64::NEG_INFINITY;
        for k in -100..700 {
            let x = f64::from(k) / 100.0;
            let (value, slope) = curve.at(x);
            assert!(value >= before - 1e-12 && slope >= -1e-12, "at {x}");
            let difference = (curve.at(x + 1e-6).0 - curve.at(x - 1e-6).0) / 2e-6;
            assert!((difference - slope).abs() < 1e-3, "at {x}: {difference} is not {slope}");
            before = value;
        }
    }

    #[test]
    fn a_straight_line_stays_one() {
        let curve = MonotoneCurve::through(&[0.0, 0.3, 1.0, 2.0], &[1.0, 1.6, 3.0, 5.0]);
        for x in [-1.0, 0.1, 0.9, 1.7, 3.0] {
            assert!((curve.at(x).0 - (1.0 + 2.0 * x)).abs() < 1e-12);
        }
    }
}
