//! The essential matrix of two calibrated views, E = [t]ₓ R with q′ᵀ E q = 0 for the rays q of the first and q′ of the second
//! view (Longuet-Higgins 1981): from five pairs of rays (Nistér 2004), and back to rotation and direction (Horn 1990).

use crate::eigen::real_roots;
use crate::geometry::{DMat3, DVec2, DVec3};

/// Pairs that determine it.
pub const LEAST_PAIRS: usize = 5;

/// Linear polynomials in x, y, z: their coefficients, and 1.
type Linear = [f64; 4];
/// Polynomials of the second and third degree, in the order of [`SECOND`] and [`THIRD`].
type Quadratic = [f64; 10];
type Cubic = [f64; 20];

/// Exponents of x, y, z.
const FIRST: [[usize; 3]; 4] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]];
const SECOND: [[usize; 3]; 10] = [
    [2, 0, 0],
    [1, 1, 0],
    [0, 2, 0],
    [1, 0, 1],
    [0, 1, 1],
    [0, 0, 2],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [0, 0, 0],
];
/// The first ten are eliminated (Nistér 2004, §3.2.2).
const THIRD: [[usize; 3]; 20] = [
    [3, 0, 0],
    [0, 3, 0],
    [2, 1, 0],
    [1, 2, 0],
    [2, 0, 1],
    [2, 0, 0],
    [0, 2, 1],
    [0, 2, 0],
    [1, 1, 1],
    [1, 1, 0],
    [1, 0, 2],
    [1, 0, 1],
    [1, 0, 0],
    [0, 1, 2],
    [0, 1, 1],
    [0, 1, 0],
    [0, 0, 3],
    [0, 0, 2],
    [0, 0, 1],
    [0, 0, 0],
];

/// Where the product of a monomial of one list and a linear one stands in another list.
const fn products<const A: usize, const B: usize>(
    of: [[usize; 3]; A],
    among: [[usize; 3]; B],
) -> [[usize; 4]; A] {
    let mut out = [[0; 4]; A];
    let mut a = 0;
    while a < A {
        let mut b = 0;
        while b < 4 {
            let mut at = 0;
            while at < B {
                let (p, q, r) = (of[a], FIRST[b], among[at]);
                if p[0] + q[0] == r[0] && p[1] + q[1] == r[1] && p[2] + q[2] == r[2] {
                    out[a][b] = at;
                }
                at += 1;
            }
            b += 1;
        }
        a += 1;
    }
    out
}

const TO_SECOND: [[usize; 4]; 4] = products(FIRST, SECOND);
const TO_THIRD: [[usize; 4]; 10] = products(SECOND, THIRD);

fn add_product(a: &Linear, b: &Linear, sign: f64, sum: &mut Quadratic) {
    for (a, to) in a.iter().zip(&TO_SECOND) {
        b.iter().zip(to).for_each(|(b, at)| sum[*at] += sign * a * b);
    }
}

fn add_cubic(a: &Quadratic, b: &Linear, sum: &mut Cubic) {
    for (a, to) in a.iter().zip(&TO_THIRD) {
        b.iter().zip(to).for_each(|(b, at)| sum[*at] += a * b);
    }
}

/// The essential matrices that five pairs of rays (x/z, y/z) of the first and second view allow, up to scale: ten at most.
pub fn essential_matrices(pairs: &[(DVec2, DVec2); LEAST_PAIRS]) -> Vec<DMat3> {
    let Some(basis) = null_space(pairs) else { return Vec::new() };
    // E = x X + y Y + z Z + W
    let e: [[Linear; 3]; 3] =
        std::array::from_fn(|row| std::array::from_fn(|column| basis.map(|vector| vector[3 * row + column])));
    let Some(reduced) = eliminated(constraints(&e)) else { return Vec::new() };
    // Rows ⟨k⟩ = ⟨e⟩ − z⟨f⟩, ⟨l⟩ = ⟨g⟩ − z⟨h⟩, ⟨m⟩ = ⟨i⟩ − z⟨j⟩: polynomials in z that multiply x, y and 1 (Nistér 2004, (11)–(13)).
    let b: [[[f64; 5]; 3]; 3] = std::array::from_fn(|row| {
        let (plain, times_z) = (&reduced[4 + 2 * row], &reduced[5 + 2 * row]);
        let cubic = |from: usize| {
            let [p, t] = [plain, times_z].map(|row| [row[from + 2], row[from + 1], row[from]]);
            [p[0], p[1] - t[0], p[2] - t[1], -t[2], 0.0]
        };
        let [p, t] = [plain, times_z].map(|row| [row[19], row[18], row[17], row[16]]);
        [cubic(10), cubic(13), [p[0], p[1] - t[0], p[2] - t[1], p[3] - t[2], -t[3]]]
    });
    let at =
        |z: f64| b.map(|row| DVec3::from_array(row.map(|p| p.iter().rev().fold(0.0, |sum, c| sum * z + c))));
    let matrix = |z: f64| {
        let [k, l, m] = at(z);
        let null = [k.cross(l), l.cross(m), m.cross(k)];
        let null = null.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let (x, y) = (null.x / null.z, null.y / null.z);
        let entry = |row: usize, column: usize| {
            let [a, b, c, d] = e[row][column];
            a * x + b * y + c * z + d
        };
        let found = DMat3::from_cols(
            DVec3::new(entry(0, 0), entry(1, 0), entry(2, 0)),
            DVec3::new(entry(0, 1), entry(1, 1), entry(2, 1)),
            DVec3::new(entry(0, 2), entry(1, 2), entry(2, 2)),
        );
        found.is_finite().then_some(found)
    };
    real_roots(&determinant(&b)).into_iter().filter_map(matrix).collect()
}

/// Four vectors that span the matrices, row-major, with q′ᵀ E q = 0 for all pairs: Gaussian elimination with full pivoting.
fn null_space(pairs: &[(DVec2, DVec2); LEAST_PAIRS]) -> Option<[[f64; 9]; 4]> {
    let mut m = pairs.map(|(q, p)| [p.x * q.x, p.x * q.y, p.x, p.y * q.x, p.y * q.y, p.y, q.x, q.y, 1.0]);
    let mut order: [usize; 9] = std::array::from_fn(|column| column);
    for step in 0..LEAST_PAIRS {
        let places = (step..LEAST_PAIRS).flat_map(|row| (step..9).map(move |column| (row, column)));
        let (row, column) = places.max_by(|a, b| m[a.0][a.1].abs().total_cmp(&m[b.0][b.1].abs()))?;
        if m[row][column].abs() < 1e-10 {
            return None;
        }
        m.swap(step, row);
        m.iter_mut().for_each(|row| row.swap(step, column));
        order.swap(step, column);
        let pivot = m[step].map(|v| v / m[step][step]);
        for (number, row) in m.iter_mut().enumerate() {
            let factor = row[step];
            if number == step {
                *row = pivot;
            } else {
                row.iter_mut().zip(pivot).for_each(|(v, p)| *v -= factor * p);
            }
        }
    }
    let mut basis = [[0.0; 9]; 4];
    for free in 0..4 {
        let mut vector = [0.0; 9];
        for (row, own) in m.iter().zip(order) {
            vector[own] = -row[LEAST_PAIRS + free];
        }
        vector[order[LEAST_PAIRS + free]] = 1.0;
        // orthonormal, so that no member of the family is far away
        for before in &basis[..free] {
            let along: f64 = vector.iter().zip(before).map(|(a, b)| a * b).sum();
            vector.iter_mut().zip(before).for_each(|(v, b)| *v -= along * b);
        }
        let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        basis[free] = vector.map(|v| v / length);
    }
    Some(basis)
}

/// det E = 0 and E Eᵀ E − ½ tr(E Eᵀ) E = 0, as cubics (Nistér 2004, (2) and (3)).
fn constraints(e: &[[Linear; 3]; 3]) -> [Cubic; 10] {
    let mut squares = [[[0.0; 10]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            (0..3).for_each(|k| add_product(&e[i][k], &e[j][k], 1.0, &mut squares[i][j]));
        }
    }
    let half_trace: Quadratic =
        std::array::from_fn(|at| 0.5 * (0..3).map(|i| squares[i][i][at]).sum::<f64>());
    (0..3).for_each(|i| squares[i][i].iter_mut().zip(half_trace).for_each(|(v, h)| *v -= h));
    let mut out = [[0.0; 20]; 10];
    for i in 0..3 {
        for j in 0..3 {
            (0..3).for_each(|k| add_cubic(&squares[i][k], &e[k][j], &mut out[3 * i + j]));
        }
    }
    for i in 0..3 {
        let mut minor = [0.0; 10];
        add_product(&e[1][(i + 1) % 3], &e[2][(i + 2) % 3], 1.0, &mut minor);
        add_product(&e[1][(i + 2) % 3], &e[2][(i + 1) % 3], -1.0, &mut minor);
        add_cubic(&minor, &e[0][i], &mut out[9]);
    }
    out
}

/// Gauss–Jordan elimination of the first ten monomials.
fn eliminated(mut m: [Cubic; 10]) -> Option<[Cubic; 10]> {
    for step in 0..10 {
        let pivot = (step..10).max_by(|&a, &b| m[a][step].abs().total_cmp(&m[b][step].abs()))?;
        if m[pivot][step].abs() < 1e-14 {
            return None;
        }
        m.swap(step, pivot);
        let row = m[step].map(|v| v / m[step][step]);
        for (number, other) in m.iter_mut().enumerate() {
            let factor = other[step];
            if number == step {
                *other = row;
            } else {
                other.iter_mut().zip(row).for_each(|(v, p)| *v -= factor * p);
            }
        }
    }
    Some(m)
}

/// The determinant of a matrix of polynomials in z, from the constant on: of the tenth degree (Nistér 2004, (17)).
fn determinant(b: &[[[f64; 5]; 3]; 3]) -> [f64; 11] {
    let mut sum = [0.0; 11];
    for (columns, sign) in [
        ([0, 1, 2], 1.0),
        ([1, 2, 0], 1.0),
        ([2, 0, 1], 1.0),
        ([2, 1, 0], -1.0),
        ([1, 0, 2], -1.0),
        ([0, 2, 1], -1.0),
    ] {
        let [p, q, r]: [&[f64; 5]; 3] = std::array::from_fn(|row| &b[row][columns[row]]);
        for (i, p) in p.iter().enumerate().filter(|(_, p)| **p != 0.0) {
            for (j, q) in q.iter().enumerate().filter(|(_, q)| **q != 0.0) {
                r.iter()
                    .enumerate()
                    .filter(|(_, r)| **r != 0.0)
                    .for_each(|(k, r)| sum[i + j + k] += sign * p * q * r);
            }
        }
    }
    sum
}

/// The cross product with a vector, as a matrix.
pub fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// The four motions that have an essential matrix: rotation and direction of the translation, of unit length. None for a
/// matrix of rank below two.
pub fn motions(e: &DMat3) -> Option<[(DMat3, DVec3); 4]> {
    let (a, b, c) = (e.x_axis, e.y_axis, e.z_axis);
    let cofactors = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    let columns = [cofactors.x_axis, cofactors.y_axis, cofactors.z_axis];
    // b bᵀ R: every column is along b
    let along = columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let square = 0.5 * (a.length_squared() + b.length_squared() + c.length_squared());
    let baseline = along.try_normalize()? * square.sqrt();
    // (b·b) R = Cof(E) ∓ [b]ₓ E (Horn 1990, (28))
    let turned = cross_matrix(baseline) * *e;
    let [first, second] = [cofactors - turned, cofactors + turned].map(|sum| sum * square.recip());
    let direction = baseline / square.sqrt();
    let rotations = [first, second];
    rotations
        .iter()
        .all(|r| r.is_finite())
        .then(|| [(first, direction), (first, -direction), (second, direction), (second, -direction)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn five_pairs_determine_a_motion_among_few() {
        for seed in 0..40 {
            let mut random = Random::new(seed, 31);
            let mut number = |most: f64| random.between(-most, most);
            let rotation = DMat3::from_rotation_y(number(1.0)) * DMat3::from_rotation_x(number(0.4));
            let translation = DVec3::new(number(1.0), number(1.0), number(1.0)).normalize();
            let pairs: [(DVec2, DVec2); 5] = std::array::from_fn(|_| {
                let point = DVec3::new(number(2.0), number(2.0), 5.0 + number(2.0));
                let seen = rotation * point + translation;
                (point.truncate() / point.z, seen.truncate() / seen.z)
            });
            let found = essential_matrices(&pairs);
            assert!(!found.is_empty() && found.len() <= 10);
            let off = found.iter().filter_map(motions).flatten().map(|(r, t)| {
                let difference = r - rotation;
                let axes = [difference.x_axis, difference.y_axis, difference.z_axis];
                axes.iter().map(|a| a.length()).fold((t - translation).length(), f64::max)
            });
            let nearest = off.fold(f64::MAX, f64::min);
            assert!(nearest < 1e-5, "{seed}: {nearest}");
        }
    }

    #[test]
    fn pairs_that_coincide_determine_none() {
        assert!(essential_matrices(&[(DVec2::new(0.1, 0.2), DVec2::new(0.3, 0.1)); 5]).is_empty());
        assert!(motions(&DMat3::ZERO).is_none());
    }
}
