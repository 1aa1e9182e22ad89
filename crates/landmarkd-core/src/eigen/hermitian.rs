//! The leading eigenvectors of a Hermitian matrix.

use faer::{Mat, Side, c64};

/// The eigenvectors of the `count` largest eigenvalues, largest first, of unit length: real and imaginary part of each
/// component. `None` if an entry is not finite.
///
/// `entries`: size × size real and imaginary parts, row-major; only the lower triangle is read.
///
/// # Panics
/// If `entries` are not size × size, or `count` is above `size`.
pub fn leading_eigenvectors(entries: &[[f64; 2]], size: usize, count: usize) -> Option<Vec<Vec<[f64; 2]>>> {
    assert!(entries.len() == size * size && count <= size, "a square matrix");
    if !entries.iter().flatten().all(|v| v.is_finite()) {
        return None;
    }
    let matrix = Mat::from_fn(size, size, |row, column| {
        let [re, im] = entries[row * size + column];
        c64::new(re, im)
    });
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let vector = |k: usize| (0..size).map(|row| eigen.U()[(row, k)]).map(|v| [v.re, v.im]).collect();
    Some((size - count..size).rev().map(vector).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vectors_of_a_known_matrix_are_found() {
        // 3 · a aᴴ + b bᴴ of orthonormal a and b
        let half = 0.5_f64.sqrt();
        let (a, b) = ([[half, 0.0], [0.0, half]], [[half, 0.0], [0.0, -half]]);
        let product = |v: &[[f64; 2]; 2], i: usize, j: usize| {
            [v[i][0] * v[j][0] + v[i][1] * v[j][1], v[i][1] * v[j][0] - v[i][0] * v[j][1]]
        };
        let entry = |at: usize| {
            let (of_a, of_b) = (product(&a, at / 2, at % 2), product(&b, at / 2, at % 2));
            [3.0 * of_a[0] + of_b[0], 3.0 * of_a[1] + of_b[1]]
        };
        let found = leading_eigenvectors(&[0, 1, 2, 3].map(entry), 2, 1).unwrap();
        // |aᴴ v| = 1: the same but for a phase
        let along = found[0].iter().zip(&a).fold([0.0; 2], |sum, (v, a)| {
            [sum[0] + a[0] * v[0] + a[1] * v[1], sum[1] + a[0] * v[1] - a[1] * v[0]]
        });
        assert!((along[0].hypot(along[1]) - 1.0).abs() < 1e-12, "{found:?}");
        assert!(leading_eigenvectors(&[[f64::NAN, 0.0]], 1, 1).is_none());
    }
}
