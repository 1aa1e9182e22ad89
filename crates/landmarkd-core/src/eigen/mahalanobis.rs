//! Mahalanobis distances, B(15): how far a point is from a class, in units of how the class varies.
//!
//! A class of few points has a covariance that can't be inverted, or that trusts chance. It is drawn towards the
//! covariance within all classes, the more the fewer points it has.

use faer::{Mat, Side};

use super::EigenError;

/// Variance along any direction is at least this part of the mean variance within classes.
const LEAST_PART: f64 = 1e-3;

/// The mean and regularised covariance of one class.
#[derive(Clone, Debug)]
pub struct ClassCovariance {
    mean: Vec<f64>,
    /// dimension × dimension, row-major: W with Σ⁻¹ = WᵀW.
    whitening: Vec<f64>,
}

impl ClassCovariance {
    /// One for each class. `points` is n × `dimension`, row-major; `class` is the class of each point, 0..`classes`;
    /// each class has a point.
    ///
    /// # Errors
    /// [`EigenError::NotConverged`].
    pub fn fit(
        points: &[f32],
        dimension: usize,
        class: &[usize],
        classes: usize,
    ) -> Result<Vec<ClassCovariance>, EigenError> {
        let mut counts = vec![0.0; classes];
        let mut means = vec![vec![0.0; dimension]; classes];
        for (point, &class) in points.chunks_exact(dimension).zip(class) {
            counts[class] += 1.0;
            means[class].iter_mut().zip(point).for_each(|(m, &p)| *m += f64::from(p));
        }
        for (mean, count) in means.iter_mut().zip(&counts) {
            mean.iter_mut().for_each(|m| *m /= count);
        }
        let scatters = scatters(points, dimension, class, &means);
        let total: f64 = counts.iter().sum();
        let pooled = scatters.iter().fold(Mat::<f64>::zeros(dimension, dimension), |sum, own| sum + own);
        let pooled = pooled * faer::Scale(1.0 / total);
        let floor = LEAST_PART * (0..dimension).map(|i| pooled[(i, i)]).sum::<f64>() / dimension as f64;
        let floor = floor.max(1e-12);
        let fitted = means.into_iter().zip(scatters.iter().zip(&counts)).map(|(mean, (scatter, &count))| {
            let trust = count / (count + dimension as f64);
            let mut covariance = scatter * faer::Scale(trust / count) + &pooled * faer::Scale(1.0 - trust);
            (0..dimension).for_each(|i| covariance[(i, i)] += floor);
            Ok(ClassCovariance { mean, whitening: whitening(&covariance, floor)? })
        });
        fitted.collect()
    }

    /// B(15): √((h − m)ᵀ Σ⁻¹ (h − m)).
    pub fn distance(&self, point: &[f32]) -> f64 {
        let off: Vec<f64> = point.iter().zip(&self.mean).map(|(&p, m)| f64::from(p) - m).collect();
        let rows = self.whitening.chunks_exact(off.len());
        rows.map(|row| row.iter().zip(&off).map(|(w, o)| w * o).sum::<f64>().powi(2)).sum::<f64>().sqrt()
    }
}

/// Σ (p − m)(p − m)ᵀ over the points of each class.
fn scatters(points: &[f32], dimension: usize, class: &[usize], means: &[Vec<f64>]) -> Vec<Mat<f64>> {
    let mut scatters = vec![Mat::<f64>::zeros(dimension, dimension); means.len()];
    for (point, &class) in points.chunks_exact(dimension).zip(class) {
        let off: Vec<f64> = point.iter().zip(&means[class]).map(|(&p, m)| f64::from(p) - m).collect();
        for (i, a) in off.iter().enumerate() {
            for (j, b) in off.iter().enumerate() {
                scatters[class][(i, j)] += a * b;
            }
        }
    }
    scatters
}

/// W with Σ⁻¹ = WᵀW, row-major; variances are at least `floor`.
fn whitening(covariance: &Mat<f64>, floor: f64) -> Result<Vec<f64>, EigenError> {
    let size = covariance.nrows();
    let eigen = covariance.self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NotConverged { size })?;
    let row = |i: usize| {
        let scale = 1.0 / eigen.S().column_vector()[i].max(floor).sqrt();
        let direction = eigen.U().col(i);
        (0..size).map(move |k| scale * direction[k])
    };
    Ok((0..size).flat_map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wide_counts_less() {
        // class 0 is wide along x, class 1 along y
        let points: Vec<f32> = (-20..=20).flat_map(|t| [t as f32, 0.1 * (t % 3) as f32]).collect();
        let turned: Vec<f32> = points.chunks_exact(2).flat_map(|p| [p[1], p[0] + 50.0]).collect();
        let class = [vec![0; 41], vec![1; 41]].concat();
        let classes = ClassCovariance::fit(&[points, turned].concat(), 2, &class, 2).unwrap();
        assert!(classes[0].distance(&[15.0, 0.0]) < classes[0].distance(&[0.0, 15.0]) / 2.0);
        assert!(classes[1].distance(&[15.0, 50.0]) > 2.0 * classes[1].distance(&[0.0, 65.0]));
        assert!(classes[0].distance(&[0.0, 0.0]) < 1e-6);
    }

    #[test]
    fn one_point_or_identical_ones_have_a_distance_too() {
        let points = [1.0, 1.0, 1.0, 1.0, 5.0, 5.0];
        let classes = ClassCovariance::fit(&points, 2, &[0, 0, 1], 2).unwrap();
        assert!(classes[1].distance(&[5.0, 5.0]) < 1e-9);
        assert!(classes[0].distance(&[5.0, 5.0]) > classes[0].distance(&[1.1, 1.0]));
    }
}
