//! Eigenvalues and eigenvectors of a small symmetric matrix, and linear equations with it.

use faer::{Mat, Side};

/// Eigenvalues below this part of the largest count as null: rounding.
const LEAST_RELATIVE_EIGENVALUE: f64 = 1e-13;

/// Eigenvalues, the largest first, with their eigenvectors of unit length.
#[derive(Clone, Debug, PartialEq)]
pub struct Symmetric {
    /// Descending.
    pub values: Vec<f64>,
    /// The eigenvector of each eigenvalue.
    pub vectors: Vec<Vec<f64>>,
}

impl Symmetric {
    /// The matrix of `size` × `size` entries, row-major; only its lower triangle is read. `None` if an entry is not
    /// finite.
    ///
    /// # Panics
    /// If `entries` does not hold `size` × `size` values.
    pub fn of(entries: &[f64], size: usize) -> Option<Symmetric> {
        assert_eq!(entries.len(), size * size, "a square matrix");
        if !entries.iter().all(|v| v.is_finite()) {
            return None;
        }
        let matrix = Mat::from_fn(size, size, |row, column| entries[row * size + column]);
        let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
        let order = (0..size).rev();
        Some(Symmetric {
            values: order.clone().map(|k| eigen.S().column_vector()[k]).collect(),
            vectors: order.map(|k| (0..size).map(|row| eigen.U()[(row, k)]).collect()).collect(),
        })
    }

    /// The shortest x for which the matrix times x comes nearest to `right`.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut solution = vec![0.0; right.len()];
        let least = LEAST_RELATIVE_EIGENVALUE * self.values.first().map_or(0.0, |v| v.abs());
        for (value, vector) in self.values.iter().zip(&self.vectors).filter(|(value, _)| value.abs() > least)
        {
            let along: f64 = vector.iter().zip(right).map(|(v, r)| v * r).sum();
            for (x, v) in solution.iter_mut().zip(vector) {
                *x += along / value * v;
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, -1.0, 0.5, -1.0, 2.0];
        let solution = Symmetric::of(&matrix, 3).unwrap().solve(&[1.0, 2.0, 3.0]);
        for (row, right) in matrix.chunks(3).zip([1.0, 2.0, 3.0]) {
            let left: f64 = row.iter().zip(&solution).map(|(a, x)| a * x).sum();
            assert!((left - right).abs() < 1e-12, "{left} is not {right}");
        }
    }

    #[test]
    fn a_null_direction_is_left_out() {
        let eigen = Symmetric::of(&[1.0, 1.0, 1.0, 1.0], 2).unwrap();
        assert!((eigen.values[0] - 2.0).abs() < 1e-12);
        let solution = eigen.solve(&[2.0, 2.0]);
        assert!(solution.iter().all(|x| (x - 1.0).abs() < 1e-12), "{solution:?}");
    }

    #[test]
    fn what_is_not_finite_has_no_eigenvalues() {
        assert_eq!(Symmetric::of(&[f64::NAN], 1), None);
    }
}
