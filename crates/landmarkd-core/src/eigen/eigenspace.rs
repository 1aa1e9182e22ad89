//! The eigenspace of a set of vectors (A§4.1): their mean and the directions in which they differ most.
//!
//! The text takes the SVD of the mean-subtracted vectors as A = Pᵀ and keeps columns of V; with vectors as
//! the columns of A it is the columns of **U** that span the space of vectors. Those are computed here, as
//! eigenvectors of the covariance or, when there are fewer vectors than components, through the Gram
//! matrix: the same subspace from the smaller problem. One thread, f64, fixed signs: the same rows give the
//! same bits.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Side};
use pulp::{Arch, Simd, WithSimd};
use thiserror::Error;

/// Directions with less than this part of the largest eigenvalue are null: nothing but rounding.
const LEAST_RELATIVE_EIGENVALUE: f64 = 1e-10;
/// Variance below this part of the vectors' mean square is the rounding of identical f32 vectors.
const LEAST_RELATIVE_VARIANCE: f64 = 1e-12;
/// Basis vectors may depart from orthonormality by this much in f32.
const ORTHONORMALITY: f64 = 1e-4;
/// Rows that are taken into f64 at a time: bounds the memory beside the covariance.
const CHUNK_ROWS: usize = 1024;
/// Directions that are iterated beside the requested ones: the more, the faster those converge.
const OVERSAMPLING: usize = 32;
/// The iteration ends when no requested eigenvalue changes by more than this part of the largest.
const SETTLED: f64 = 1e-6;
const MOST_ITERATIONS: usize = 200;

/// A mean and an orthonormal basis; vectors become points of a few coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenspace {
    /// Mean of the training vectors, `length` components.
    pub mean: Vec<f32>,
    /// `dimension` × `length`, row-major; the rows are orthonormal. In each row the component of largest
    /// magnitude, the first of equals, is positive.
    pub basis: Vec<f32>,
    /// Variance along each row of the basis, descending.
    pub eigenvalues: Vec<f64>,
    /// Variance in all directions, kept or not.
    pub total_variance: f64,
}

/// Why no eigenspace could be made.
#[derive(Debug, Error, PartialEq)]
pub enum EigenError {
    /// Not n × length values.
    #[error("{values} values are not a whole number of vectors of {length} components, or none at all")]
    Shape {
        /// Values that were given.
        values: usize,
        /// Components of a vector.
        length: usize,
    },
    /// An infinite component, or one that is no number.
    #[error("a component is not a finite number")]
    NotFinite,
    /// Identical vectors.
    #[error("the {vectors} vectors do not differ from each other")]
    NoVariance {
        /// Vectors that were given.
        vectors: usize,
    },
    /// Eigenvalues that didn't settle.
    #[error("the eigenvalue iteration did not converge on a {size}×{size} matrix")]
    NotConverged {
        /// Rows of the matrix.
        size: usize,
    },
    /// A basis that is not orthonormal to f32 precision.
    #[error("the basis departs from orthonormality by {deviation:e}")]
    NotOrthonormal {
        /// The largest entry of |B Bᵀ − I|.
        deviation: f64,
    },
}

/// A symmetric matrix' eigenvalues and eigenvectors as faer has them, the largest last.
type Eigen = faer::linalg::solvers::SelfAdjointEigen<f64>;

/// Mean and moments of a set of vectors.
struct Moments {
    count: usize,
    mean: Vec<f64>,
    /// Mean square length of the vectors.
    mean_square: f64,
}

impl Moments {
    fn of(rows: &[f32], length: usize) -> Result<Moments, EigenError> {
        let count = vector_count(rows, length)?;
        let mean_square = rows.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / count as f64;
        Ok(Moments { count, mean: mean(rows, length), mean_square })
    }

    /// Degrees of freedom of a variance.
    fn degrees(&self) -> f64 {
        self.count.saturating_sub(1).max(1) as f64
    }

    /// How many of descending variances are more than rounding.
    ///
    /// # Errors
    /// [`EigenError::NoVariance`] if none is.
    fn significant(&self, variances: &[f64]) -> Result<usize, EigenError> {
        let largest = variances.first().copied().unwrap_or_default();
        let floor = (LEAST_RELATIVE_EIGENVALUE * largest).max(LEAST_RELATIVE_VARIANCE * self.mean_square);
        match variances.iter().take_while(|&&variance| variance > floor).count() {
            0 => Err(EigenError::NoVariance { vectors: self.count }),
            kept => Ok(kept),
        }
    }
}

impl Eigenspace {
    /// Fits the leading `dimension` directions to n × `length` row-major vectors.
    ///
    /// Returns the eigenspace and the whole spectrum: variances (over n − 1), descending, min(n, length)
    /// of them. Null directions are dropped, so the dimension may be smaller than requested.
    ///
    /// # Errors
    /// [`EigenError`]: a wrong shape, components that are not finite, identical vectors.
    pub fn fit(rows: &[f32], length: usize, dimension: usize) -> Result<(Eigenspace, Vec<f64>), EigenError> {
        let moments = Moments::of(rows, length)?;
        let through_gram = moments.count < length;
        let products = if through_gram { gram(rows, &moments.mean) } else { covariance(rows, &moments.mean) };
        let eigen = decomposed(&products)?;
        let size = products.nrows();
        let variance = |i: usize| (eigen.S().column_vector()[i] / moments.degrees()).max(0.0);
        let spectrum: Vec<f64> = (0..size).rev().map(variance).collect();
        let kept = moments.significant(&spectrum[..dimension.min(size)])?;
        let mut directions = leading(&eigen, size, kept);
        if through_gram {
            directions = combined(rows, &moments.mean, &directions);
        }
        let total_variance = spectrum.iter().sum();
        let eigenspace =
            Eigenspace::of(&moments.mean, &directions, spectrum[..kept].to_vec(), total_variance)?;
        Ok((eigenspace, spectrum))
    }

    /// The same leading directions from a set so large that the whole spectrum would take too long: subspace
    /// iteration (Halko, Martinsson and Tropp 2011) from a start drawn with a fixed seed, chunk by chunk.
    ///
    /// Returns the eigenspace and the spectrum of its directions alone.
    ///
    /// # Errors
    /// As [`Eigenspace::fit`], or an iteration that doesn't converge.
    pub fn fit_leading(
        rows: &[f32],
        length: usize,
        dimension: usize,
    ) -> Result<(Eigenspace, Vec<f64>), EigenError> {
        let moments = Moments::of(rows, length)?;
        let squares = rows.chunks(CHUNK_ROWS * length).flat_map(|chunk| centred(chunk, &moments.mean));
        let total_variance = squares.map(|v| v * v).sum::<f64>() / moments.degrees();
        if total_variance <= LEAST_RELATIVE_VARIANCE * moments.mean_square {
            return Err(EigenError::NoVariance { vectors: moments.count });
        }
        let (directions, mut variances) = subspace_iteration(rows, length, dimension, &moments)?;
        let kept = moments.significant(&variances)?;
        variances.truncate(kept);
        let eigenspace = Eigenspace::of(&moments.mean, &directions, variances.clone(), total_variance)?;
        Ok((eigenspace, variances))
    }

    /// The eigenspace of as many of the `directions` (columns) as there are eigenvalues, with fixed signs.
    fn of(
        mean: &[f64],
        directions: &Mat<f64>,
        eigenvalues: Vec<f64>,
        total_variance: f64,
    ) -> Result<Eigenspace, EigenError> {
        let columns = directions.col_iter().take(eigenvalues.len());
        let basis = columns.flat_map(|column| oriented(column.iter().copied().collect())).collect();
        let mean = mean.iter().map(|&v| v as f32).collect();
        let eigenspace = Eigenspace { mean, basis, eigenvalues, total_variance };
        eigenspace.check_basis()?;
        Ok(eigenspace)
    }

    /// The leading `dimension` directions alone.
    pub fn truncated(mut self, dimension: usize) -> Eigenspace {
        self.basis.truncate(dimension * self.length());
        self.eigenvalues.truncate(dimension);
        self
    }

    /// The eigenpoint of one vector, and its distance from the space: the length of what the basis can't express.
    ///
    /// # Panics
    /// If the vector has another length.
    pub fn locate(&self, vector: &[f32]) -> (Vec<f32>, f64) {
        assert_eq!(vector.len(), self.length(), "a vector of the space's length");
        let centred: Vec<f32> = vector.iter().zip(&self.mean).map(|(v, m)| v - m).collect();
        let mut point = vec![0.0; self.dimension()];
        Arch::new().dispatch(Locate { centred: &centred, basis: &self.basis, point: &mut point });
        let squares = |values: &[f32]| values.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>();
        let outside = squares(&centred) - squares(&point);
        (point, outside.max(0.0).sqrt())
    }

    /// The vector of an eigenpoint: the mean, and each direction as much as its coordinate says.
    ///
    /// # Panics
    /// If the point has another dimension.
    pub fn rebuild(&self, point: &[f32]) -> Vec<f32> {
        assert_eq!(point.len(), self.dimension(), "a point of the space's dimension");
        let mut vector = self.mean.clone();
        Arch::new().dispatch(Rebuild { basis: &self.basis, point, vector: &mut vector });
        vector
    }

    /// Checks that the rows of the basis are orthonormal to f32 precision; a basis that was not fitted here needs it.
    ///
    /// # Errors
    /// [`EigenError::NotOrthonormal`].
    pub fn check_basis(&self) -> Result<(), EigenError> {
        let deviation = departure_from_orthonormality(&self.basis, self.length());
        // a NaN must not pass
        match deviation <= ORTHONORMALITY {
            true => Ok(()),
            false => Err(EigenError::NotOrthonormal { deviation }),
        }
    }

    /// Coordinates of an eigenpoint.
    pub fn dimension(&self) -> usize {
        self.eigenvalues.len()
    }

    /// Components of a vector.
    pub fn length(&self) -> usize {
        self.mean.len()
    }

    /// The eigenpoints of n × `length` row-major vectors: n × `dimension`, row-major.
    ///
    /// A vector gives the same bits whichever others are projected with it.
    ///
    /// # Panics
    /// If `vectors` is not a whole number of vectors.
    pub fn project(&self, vectors: &[f32]) -> Vec<f32> {
        let (length, dimension) = (self.length(), self.dimension());
        assert!(vectors.len().is_multiple_of(length), "whole vectors");
        let mut across = vec![[0.0; WIDE]; dimension.div_ceil(WIDE) * length];
        for (i, row) in self.basis.chunks_exact(length).enumerate() {
            for (column, &v) in across[i / WIDE * length..].iter_mut().zip(row) {
                column[i % WIDE] = v;
            }
        }
        let mut points = vec![0.0; vectors.len() / length * dimension];
        let (mean, points_out) = (&self.mean[..], &mut points[..]);
        Arch::new().dispatch(Project { vectors, mean, across: &across, dimension, points: points_out });
        points
    }
}

/// vector += basisᵀ · point, four directions at a time: the vector is read and written once for them.
struct Rebuild<'a> {
    basis: &'a [f32],
    point: &'a [f32],
    vector: &'a mut [f32],
}

impl WithSimd for Rebuild<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let length = self.vector.len();
        let (groups, rest) = self.point.as_chunks::<TOGETHER>();
        for (coordinates, rows) in groups.iter().zip(self.basis.chunks_exact(TOGETHER * length)) {
            let rows: [&[f32]; TOGETHER] = std::array::from_fn(|k| &rows[k * length..][..length]);
            for (i, v) in self.vector.iter_mut().enumerate() {
                *v += coordinates[0] * rows[0][i]
                    + coordinates[1] * rows[1][i]
                    + coordinates[2] * rows[2][i]
                    + coordinates[3] * rows[3][i];
            }
        }
        let last = self.basis.chunks_exact(length).skip(TOGETHER * groups.len());
        for (row, coordinate) in last.zip(rest) {
            self.vector.iter_mut().zip(row).for_each(|(v, direction)| *v += coordinate * direction);
        }
    }
}

/// Coordinates that are summed up side by side, and vectors.
const WIDE: usize = 16;
const TOGETHER: usize = 4;

/// points = basis · (vectors − mean), with the basis by [`WIDE`] rows, column by column. A§4.1
struct Project<'a> {
    vectors: &'a [f32],
    mean: &'a [f32],
    across: &'a [[f32; WIDE]],
    dimension: usize,
    points: &'a mut [f32],
}

impl WithSimd for Project<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (length, dimension) = (self.mean.len(), self.dimension);
        let mut centred = vec![[0.0_f32; TOGETHER]; length];
        let groups = self.vectors.chunks(TOGETHER * length);
        for (vectors, points) in groups.zip(self.points.chunks_mut(TOGETHER * dimension)) {
            for (lane, vector) in vectors.chunks_exact(length).enumerate() {
                for k in 0..length {
                    centred[k][lane] = vector[k] - self.mean[k];
                }
            }
            for (number, columns) in self.across.chunks_exact(length).enumerate() {
                let mut sums = [[0.0_f32; WIDE]; TOGETHER];
                let vectors = WIDE / S::F32_LANES;
                let mut first = 0;
                while first < vectors {
                    let second = (first + 1).min(vectors - 1);
                    let zero = simd.splat_f32s(0.0);
                    let (mut a, mut b) = ([zero; TOGETHER], [zero; TOGETHER]);
                    for k in 0..length {
                        let (column, centred) = (S::as_simd_f32s(&columns[k]).0, &centred[k]);
                        for lane in 0..TOGETHER {
                            let v = simd.splat_f32s(centred[lane]);
                            a[lane] = simd.add_f32s(a[lane], simd.mul_f32s(v, column[first]));
                            b[lane] = simd.add_f32s(b[lane], simd.mul_f32s(v, column[second]));
                        }
                    }
                    for lane in 0..TOGETHER {
                        let out = S::as_mut_simd_f32s(&mut sums[lane]).0;
                        (out[first], out[second]) = (a[lane], b[lane]);
                    }
                    first += 2;
                }
                for (point, sums) in points.chunks_exact_mut(dimension).zip(&sums) {
                    let coordinates = &mut point[number * WIDE..];
                    coordinates.iter_mut().zip(sums).for_each(|(coordinate, sum)| *coordinate = *sum);
                }
            }
        }
    }
}

/// point = basis · centred, row by row, so that the basis is read as it lies.
struct Locate<'a> {
    centred: &'a [f32],
    basis: &'a [f32],
    point: &'a mut [f32],
}

impl WithSimd for Locate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let (chunks, rest) = self.centred.as_chunks::<32>();
        for (coordinate, row) in self.point.iter_mut().zip(self.basis.chunks_exact(self.centred.len())) {
            let (row_chunks, row_rest) = row.as_chunks::<32>();
            let mut sums = [0.0_f32; 32];
            for (a, b) in chunks.iter().zip(row_chunks) {
                for lane in 0..32 {
                    sums[lane] += a[lane] * b[lane];
                }
            }
            let rest: f32 = rest.iter().zip(row_rest).map(|(a, b)| a * b).sum();
            *coordinate = sums.iter().sum::<f32>() + rest;
        }
    }
}

/// The direction at length one, its component of largest magnitude positive.
fn oriented(direction: Vec<f64>) -> impl Iterator<Item = f32> {
    let norm = direction.iter().map(|v| v * v).sum::<f64>().sqrt();
    let largest = direction.iter().fold(0.0, |l: f64, &v| if v.abs() > l.abs() { v } else { l });
    let scale = if largest < 0.0 { -1.0 / norm } else { 1.0 / norm };
    direction.into_iter().map(move |v| (v * scale) as f32)
}

fn decomposed(products: &Mat<f64>) -> Result<Eigen, EigenError> {
    products.self_adjoint_eigen(Side::Lower).map_err(|_| EigenError::NotConverged { size: products.nrows() })
}

/// The eigenvectors of the `kept` largest of `size` eigenvalues as columns, the largest first.
fn leading(eigen: &Eigen, size: usize, kept: usize) -> Mat<f64> {
    let mut directions = Mat::zeros(size, kept);
    for (i, mut column) in directions.col_iter_mut().enumerate() {
        column.copy_from(eigen.U().col(size - 1 - i));
    }
    directions
}

/// The leading directions (columns) and their variances, by subspace iteration with Rayleigh and Ritz' projection.
fn subspace_iteration(
    rows: &[f32],
    length: usize,
    dimension: usize,
    moments: &Moments,
) -> Result<(Mat<f64>, Vec<f64>), EigenError> {
    let width = (dimension + OVERSAMPLING).min(length).min(moments.count);
    let mut directions = orthonormal(random_matrix(length, width));
    let mut variances = vec![0.0; dimension.min(width)];
    for _ in 0..MOST_ITERATIONS {
        let (moved, products) = subspace_products(rows, &moments.mean, &directions);
        let size = products.nrows();
        let ritz = decomposed(&products)?;
        let now: Vec<f64> = (0..variances.len())
            .map(|i| ritz.S().column_vector()[size - 1 - i] / moments.degrees())
            .collect();
        let change = now.iter().zip(&variances).map(|(n, b)| (n - b).abs()).fold(0.0, f64::max);
        variances = now;
        if change <= SETTLED * variances[0] {
            return Ok((&directions * leading(&ritz, size, variances.len()), variances));
        }
        directions = orthonormal(moved);
    }
    Err(EigenError::NotConverged { size: width })
}

/// XᵀX·Z and (XZ)ᵀ(XZ) of the mean-subtracted rows X, for `length` × k directions Z, chunk by chunk.
fn subspace_products(rows: &[f32], mean: &[f64], directions: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
    let length = mean.len();
    let width = directions.ncols();
    let (mut moved, mut products) = (Mat::zeros(length, width), Mat::zeros(width, width));
    for chunk in rows.chunks(CHUNK_ROWS * length) {
        let centred = centred(chunk, mean);
        let x = MatRef::from_row_major_slice(&centred, centred.len() / length, length);
        let across = x * directions;
        matmul(moved.as_mut(), Accum::Add, x.transpose(), &across, 1.0, Par::Seq);
        matmul(products.as_mut(), Accum::Add, across.transpose(), &across, 1.0, Par::Seq);
    }
    (moved, products)
}

/// An orthonormal basis of the columns' span.
fn orthonormal(columns: Mat<f64>) -> Mat<f64> {
    columns.qr().compute_thin_Q()
}

/// `rows` × `columns` numbers in -1..1, always the same (SplitMix64).
fn random_matrix(rows: usize, columns: usize) -> Mat<f64> {
    let mut state = 0x005e_ed1e_57ab_1e00_u64;
    Mat::from_fn(rows, columns, |_, _| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

/// How many vectors there are: whole ones, of finite components.
fn vector_count(rows: &[f32], length: usize) -> Result<usize, EigenError> {
    if rows.is_empty() || length == 0 || !rows.len().is_multiple_of(length) {
        return Err(EigenError::Shape { values: rows.len(), length });
    }
    match rows.iter().all(|v| v.is_finite()) {
        true => Ok(rows.len() / length),
        false => Err(EigenError::NotFinite),
    }
}

fn mean(rows: &[f32], length: usize) -> Vec<f64> {
    let mut mean = vec![0.0; length];
    for row in rows.chunks_exact(length) {
        mean.iter_mut().zip(row).for_each(|(m, &v)| *m += f64::from(v));
    }
    let count = (rows.len() / length) as f64;
    mean.iter_mut().for_each(|m| *m /= count);
    mean
}

fn centred(rows: &[f32], mean: &[f64]) -> Vec<f64> {
    rows.chunks_exact(mean.len())
        .flat_map(|row| row.iter().zip(mean).map(|(&v, m)| f64::from(v) - m))
        .collect()
}

/// Σ x xᵀ over the mean-subtracted rows, `length` × `length`, chunk by chunk.
fn covariance(rows: &[f32], mean: &[f64]) -> Mat<f64> {
    let length = mean.len();
    let mut sum = Mat::zeros(length, length);
    for chunk in rows.chunks(CHUNK_ROWS * length) {
        let centred = centred(chunk, mean);
        let x = MatRef::from_row_major_slice(&centred, centred.len() / length, length);
        matmul(sum.as_mut(), Accum::Add, x.transpose(), x, 1.0, Par::Seq);
    }
    sum
}

/// X Xᵀ of the mean-subtracted rows, n × n.
fn gram(rows: &[f32], mean: &[f64]) -> Mat<f64> {
    let centred = centred(rows, mean);
    let count = rows.len() / mean.len();
    let x = MatRef::from_row_major_slice(&centred, count, mean.len());
    let mut products = Mat::zeros(count, count);
    matmul(products.as_mut(), Accum::Replace, x, x.transpose(), 1.0, Par::Seq);
    products
}

/// XᵀW of the mean-subtracted rows X: from eigenvectors of the Gram matrix to those of the covariance, chunk by chunk.
fn combined(rows: &[f32], mean: &[f64], weights: &Mat<f64>) -> Mat<f64> {
    let length = mean.len();
    let mut sum = Mat::zeros(length, weights.ncols());
    for (number, chunk) in rows.chunks(CHUNK_ROWS * length).enumerate() {
        let centred = centred(chunk, mean);
        let x = MatRef::from_row_major_slice(&centred, centred.len() / length, length);
        let weights = weights.subrows(number * CHUNK_ROWS, x.nrows());
        matmul(sum.as_mut(), Accum::Add, x.transpose(), weights, 1.0, Par::Seq);
    }
    sum
}

/// The largest entry of |B Bᵀ − I|.
fn departure_from_orthonormality(basis: &[f32], length: usize) -> f64 {
    let b: Vec<f64> = basis.iter().map(|&v| f64::from(v)).collect();
    let b = MatRef::from_row_major_slice(&b, basis.len() / length, length);
    let mut products = Mat::zeros(b.nrows(), b.nrows());
    matmul(products.as_mut(), Accum::Replace, b, b.transpose(), 1.0, Par::Seq);
    let mut largest = 0.0;
    for i in 0..b.nrows() {
        for j in 0..b.nrows() {
            let departure = (products[(i, j)] - if i == j { 1.0 } else { 0.0 }).abs();
            // a NaN must not pass
            if departure.is_nan() || departure > largest {
                largest = departure;
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// `count` vectors about a mean of 3, spread by 1/(k + 1) along component k, from a fixed generator.
    fn cloud(count: usize, length: usize) -> Vec<f32> {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
        };
        (0..count * length).map(|i| 3.0 + next() / ((i % length) as f32 + 1.0)).collect()
    }

    fn squared(a: &[f32], b: &[f32]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum()
    }

    #[test]
    fn a_line_has_one_direction() {
        let rows: Vec<f32> = (0..9).flat_map(|t| [1.0 + 3.0 * t as f32, 2.0, 5.0 - 4.0 * t as f32]).collect();
        let (space, spectrum) = Eigenspace::fit(&rows, 3, 3).unwrap();
        assert_eq!(space.dimension(), 1);
        // the variance of 0..9 is 7.5, its step 5 long; the component of largest magnitude is positive
        assert!((space.eigenvalues[0] - 7.5 * 25.0).abs() < 1e-9);
        for (b, expected) in space.basis.iter().zip([-0.6, 0.0, 0.8]) {
            assert!((b - expected).abs() < 1e-6, "{:?}", space.basis);
        }
        assert_eq!(spectrum.len(), 3);
        assert!(spectrum[1].abs() < 1e-9 && (space.total_variance - 187.5).abs() < 1e-9);
    }

    #[test]
    fn gram_and_covariance_span_the_same_space() {
        let rows = cloud(30, 29);
        let (wide, _) = Eigenspace::fit(&rows, 29, 6).unwrap(); // 30 > 29: covariance
        let padded: Vec<f32> = rows.chunks_exact(29).flat_map(|row| [row, &[0.0; 11][..]].concat()).collect();
        let (tall, _) = Eigenspace::fit(&padded, 40, 6).unwrap(); // 30 < 40: Gram
        for i in 0..6 {
            assert!((wide.eigenvalues[i] - tall.eigenvalues[i]).abs() < 1e-9 * wide.eigenvalues[0]);
            let (a, b) = (&wide.basis[29 * i..][..29], &tall.basis[40 * i..][..29]);
            assert!(squared(a, b).sqrt() < 1e-5, "direction {i}");
        }
    }

    #[test]
    fn many_rows_are_taken_in_chunks() {
        let rows = cloud(2 * CHUNK_ROWS + 17, 5);
        let (space, spectrum) = Eigenspace::fit(&rows, 5, 5).unwrap();
        let points = space.project(&rows);
        let count = (points.len() / 5) as f64;
        for (i, expected) in spectrum.iter().enumerate() {
            let squares = points.iter().skip(i).step_by(5).map(|&v| f64::from(v).powi(2));
            let variance = squares.sum::<f64>() / (count - 1.0);
            assert!((variance / expected - 1.0).abs() < 1e-4, "direction {i}: {variance}, {expected}");
        }
    }

    #[test]
    fn the_leading_directions_are_those_of_the_whole_spectrum() {
        let rows = cloud(400, 90);
        let (exact, spectrum) = Eigenspace::fit(&rows, 90, 6).unwrap();
        let (leading, settled) = Eigenspace::fit_leading(&rows, 90, 6).unwrap();
        assert_eq!(leading.dimension(), 6);
        assert!((exact.total_variance / leading.total_variance - 1.0).abs() < 1e-9);
        for i in 0..6 {
            assert!((spectrum[i] / settled[i] - 1.0).abs() < 1e-5, "{} {}", spectrum[i], settled[i]);
            let apart = squared(&exact.basis[90 * i..][..90], &leading.basis[90 * i..][..90]).sqrt();
            assert!(apart < 1e-2, "direction {i}: {apart}");
        }
        assert_eq!(Eigenspace::fit_leading(&rows, 90, 6).unwrap().0, leading, "the seed is fixed");
        let line: Vec<f32> = (0..9).flat_map(|t| [t as f32, 0.0, -2.0 * t as f32]).collect();
        assert_eq!(Eigenspace::fit_leading(&line, 3, 3).unwrap().0.dimension(), 1);
        let same = [0.1, 0.7].repeat(30);
        assert_eq!(Eigenspace::fit_leading(&same, 2, 2).unwrap_err(), EigenError::NoVariance { vectors: 30 });
    }

    #[test]
    fn one_vector_is_located_as_many_are_projected() {
        let rows = cloud(30, 77);
        let (space, _) = Eigenspace::fit(&rows, 77, 5).unwrap();
        let points = space.project(&rows);
        for (row, expected) in rows.chunks_exact(77).zip(points.chunks_exact(5)) {
            let (point, outside) = space.locate(row);
            assert!(squared(&point, expected).sqrt() < 1e-5);
            let whole = squared(row, &space.mean);
            assert!((whole - squared(&point, &[0.0; 5]) - outside * outside).abs() < 1e-5);
        }
        assert_eq!(space.clone().truncated(2).locate(&rows[..77]).0, space.locate(&rows[..77]).0[..2]);
    }

    #[test]
    fn what_can_not_be_fitted_says_why() {
        assert_eq!(Eigenspace::fit(&[], 3, 1).unwrap_err(), EigenError::Shape { values: 0, length: 3 });
        assert_eq!(Eigenspace::fit(&[1.0; 4], 3, 1).unwrap_err(), EigenError::Shape { values: 4, length: 3 });
        assert_eq!(Eigenspace::fit(&[1.0, f32::NAN], 1, 1).unwrap_err(), EigenError::NotFinite);
        let same: Vec<f32> = [0.1, 0.7, 0.3].repeat(10_000);
        assert_eq!(Eigenspace::fit(&same, 3, 2).unwrap_err(), EigenError::NoVariance { vectors: 10_000 });
        assert_eq!(Eigenspace::fit(&same[..3], 3, 2).unwrap_err(), EigenError::NoVariance { vectors: 1 });
    }

    #[test]
    fn a_foreign_basis_is_checked() {
        let (mut space, _) = Eigenspace::fit(&cloud(20, 6), 6, 3).unwrap();
        assert_eq!(space.check_basis(), Ok(()));
        space.basis[2] += 0.01;
        assert!(matches!(space.check_basis(), Err(EigenError::NotOrthonormal { .. })));
        space.basis[2] = f32::NAN;
        assert!(space.check_basis().is_err());
    }

    proptest! {
        #[test]
        fn a_whole_basis_keeps_distances(
            (length, count, values) in (1usize..12, 2usize..30).prop_flat_map(|(length, count)| {
                (Just(length), Just(count), prop::collection::vec(-10.0f32..10.0, length * count))
            }),
        ) {
            let (space, spectrum) = Eigenspace::fit(&values, length, length).unwrap();
            prop_assert!(spectrum.is_sorted_by(|a, b| a >= b));
            prop_assert_eq!(spectrum.len(), length.min(count));
            prop_assert_eq!(space.check_basis(), Ok(()));
            let points = space.project(&values);
            let d = space.dimension();
            for i in 0..count {
                let before = squared(&values[..length], &values[i * length..][..length]);
                let after = squared(&points[..d], &points[i * d..][..d]);
                prop_assert!((before - after).abs() < 1e-3 * before.max(1.0), "{before} became {after}");
            }
            // one vector by itself gives the same bits
            prop_assert_eq!(&space.project(&values[length..2 * length])[..], &points[d..2 * d]);
        }
    }
}
