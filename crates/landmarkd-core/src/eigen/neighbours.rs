//! The nearest of a set of eigenpoints (A§4.5), exactly: by a k-d tree, or exhaustively.
//!
//! Distances are Euclidean, not squared. Both ways return the distance as computed in f64 from the
//! eigenpoint found, so that they agree to the bit where they find the same; of identical eigenpoints the
//! one of lowest index is found.
//!
//! The exhaustive search is a product of matrices: of ‖q − t‖² = ‖q‖² + (‖t‖² − 2 q·t), B(14), the part in brackets in f32.
//! Given a bound on its rounding, it excludes the eigenpoints that can't be among the nearest; the few that can are
//! measured in f64. So what is found does not depend on the order in which a machine adds the products up.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};

use super::tree::PointTree;

/// A tree serves up to this many coordinates, from this many distinct eigenpoints on.
///
/// Measured as `benches/search.rs` does, for 64 queries, half of them new, the least of 15 rounds or more in ms,
/// tree / exhaustive:
///
/// | coordinates | 1280 | 10 000 | 100 000 eigenpoints |
/// | --- | --- | --- | --- |
/// | 8 | 0.14 / 0.07 | 0.31 / 0.39 | 0.70 / 4.4 |
/// | 16 | 0.39 / 0.09 | 2.1 / 0.49 | 18 / 7.0 |
/// | 32 | 0.95 / 0.12 | 7.8 / 0.88 | 93 / 11 |
/// | 64 | 2.4 / 0.18 | 14 / 1.2 | 236 / 19 |
const TREE_TO_DIMENSION: usize = 8;
const TREE_FROM_POINTS: usize = 10_000;
/// Queries and eigenpoints of one product: at most 1 MB of f32, within a second cache.
const BLOCK_QUERIES: usize = 64;
const BLOCK_POINTS: usize = 4096;
/// The eigenpoints of a block fall into so many classes in turn; only a class whose least is near enough is searched.
const CLASSES: usize = 64;

/// An eigenpoint found, and its distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Row of the eigenpoint.
    pub index: usize,
    /// Euclidean distance.
    pub distance: f32,
}

/// A set of eigenpoints, indexed for nearest-neighbour queries.
pub struct EigenpointIndex {
    points: Vec<f32>,
    dimension: usize,
    /// ‖t‖² of each eigenpoint.
    squares: Vec<f32>,
    tree: Option<PointTree>,
}

impl EigenpointIndex {
    /// An index over n × `dimension` row-major eigenpoints, all finite; with a k-d tree where that is faster.
    ///
    /// # Panics
    /// If there is no eigenpoint, or not a whole number of them.
    pub fn new(points: Vec<f32>, dimension: usize) -> Self {
        let count = points.len() / dimension.max(1);
        let mut index = EigenpointIndex::exhaustive(points, dimension);
        if dimension <= TREE_TO_DIMENSION && count >= TREE_FROM_POINTS {
            index.tree = PointTree::new(&index.points, dimension);
            if index.tree.as_ref().is_some_and(|tree| tree.distinct() < TREE_FROM_POINTS) {
                index.tree = None;
            }
        }
        index
    }

    /// An index with a k-d tree, whatever is faster; without one above 64 dimensions.
    ///
    /// # Panics
    /// As [`EigenpointIndex::new`].
    pub fn with_tree(points: Vec<f32>, dimension: usize) -> Self {
        let mut index = EigenpointIndex::exhaustive(points, dimension);
        index.tree = PointTree::new(&index.points, dimension);
        index
    }

    fn exhaustive(points: Vec<f32>, dimension: usize) -> Self {
        assert!(dimension > 0 && !points.is_empty(), "an index holds an eigenpoint");
        assert!(points.len().is_multiple_of(dimension), "whole eigenpoints");
        let squares = points.chunks_exact(dimension).map(|point| dot(point, point) as f32).collect();
        EigenpointIndex { points, dimension, squares, tree: None }
    }

    /// The eigenpoints, n × dimension, row-major.
    pub fn points(&self) -> &[f32] {
        &self.points
    }

    /// How many eigenpoints there are.
    pub fn count(&self) -> usize {
        self.points.len() / self.dimension
    }

    /// Whether [`EigenpointIndex::nearest`] asks a tree.
    pub fn has_tree(&self) -> bool {
        self.tree.is_some()
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        let copies = if self.has_tree() { 2 } else { 1 };
        size_of_val(&self.points[..]) * copies + size_of_val(&self.squares[..])
    }

    /// The nearest eigenpoint of each of n × dimension row-major queries, all finite.
    ///
    /// # Panics
    /// If `queries` is not a whole number of them.
    pub fn nearest(&self, queries: &[f32]) -> Vec<Neighbour> {
        let Some(tree) = &self.tree else { return self.nearest_several(queries, 1) };
        assert!(queries.len().is_multiple_of(self.dimension), "whole queries");
        let found = queries.chunks_exact(self.dimension).map(|query| {
            let index = tree.nearest(query);
            Neighbour { index, distance: distance(query, self.point(index)) as f32 } // A§4.5: D
        });
        found.collect()
    }

    /// The `count` nearest eigenpoints of each of n × dimension row-major queries, all finite, by looking at every
    /// eigenpoint: the oracle of the tree.
    ///
    /// A row of `count` for each query, or of all eigenpoints if there are fewer; ascending distances, of equal
    /// ones the lower index first.
    ///
    /// # Panics
    /// If `queries` is not a whole number of them, or `count` is 0.
    pub fn nearest_several(&self, queries: &[f32], count: usize) -> Vec<Neighbour> {
        assert!(queries.len().is_multiple_of(self.dimension), "whole queries");
        assert!(count > 0, "a query asks for something");
        let (dimension, count) = (self.dimension, count.min(self.count()));
        let as_matrix = |rows| MatRef::from_row_major_slice(rows, rows.len() / dimension, dimension);
        let farthest = self.squares.iter().copied().fold(0.0, f32::max).sqrt();
        let mut found = vec![(f64::INFINITY, usize::MAX); queries.len() / dimension * count];
        let mut parts = vec![0.0; BLOCK_QUERIES * BLOCK_POINTS.min(self.count())];
        let blocks = self.points.chunks(BLOCK_POINTS * dimension).zip(self.squares.chunks(BLOCK_POINTS));
        for (number, (points, squares)) in blocks.enumerate() {
            let first = number * BLOCK_POINTS;
            let points = as_matrix(points).transpose();
            let blocks = queries.chunks(BLOCK_QUERIES * dimension);
            for (queries, found) in blocks.zip(found.chunks_mut(BLOCK_QUERIES * count)) {
                let asked = queries.len() / dimension;
                let parts = &mut parts[..asked * squares.len()];
                let product = MatMut::from_row_major_slice_mut(&mut *parts, asked, squares.len());
                matmul(product, Accum::Replace, as_matrix(queries), points, -2.0, Par::Seq); // B(14)
                let rows = parts.chunks_exact_mut(squares.len()).zip(found.chunks_exact_mut(count));
                for (query, (parts, found)) in queries.chunks_exact(dimension).zip(rows) {
                    Arch::new().dispatch(BlockScan {
                        index: self,
                        first,
                        farthest,
                        squares,
                        query,
                        parts,
                        found,
                    });
                }
            }
        }
        let neighbour = |(square, index): (f64, usize)| Neighbour { index, distance: square.sqrt() as f32 };
        found.into_iter().map(neighbour).collect()
    }

    fn point(&self, index: usize) -> &[f32] {
        &self.points[index * self.dimension..][..self.dimension]
    }
}

/// Looks through a block of eigenpoints for nearer ones than those found before.
struct BlockScan<'a> {
    index: &'a EigenpointIndex,
    /// Index of the block's first eigenpoint.
    first: usize,
    /// The greatest ‖t‖ of all eigenpoints.
    farthest: f32,
    /// ‖t‖² of the block.
    squares: &'a [f32],
    query: &'a [f32],
    /// −2 q·t of the block.
    parts: &'a mut [f32],
    /// (squared distance, index), ascending.
    found: &'a mut [(f64, usize)],
}

impl WithSimd for BlockScan<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let least = self.class_minima(simd);
        let limit = self.limit(&least);
        for (class, &least) in least.iter().enumerate() {
            if least > limit {
                continue;
            }
            for at in (class..self.parts.len()).step_by(CLASSES) {
                if self.parts[at] > limit {
                    continue;
                }
                self.insert(self.first + at);
            }
        }
    }
}

impl BlockScan<'_> {
    /// Completes the parts to ‖t‖² − 2 q·t; returns the least of each class.
    #[inline(always)]
    fn class_minima<S: Simd>(&mut self, simd: S) -> [f32; CLASSES] {
        let mut least = [f32::INFINITY; CLASSES];
        let (tiles, rest) = self.parts.as_chunks_mut::<CLASSES>();
        let (squares, squares_of_rest) = self.squares.as_chunks::<CLASSES>();
        let classes = S::as_mut_simd_f32s(&mut least).0;
        for tile in 0..tiles.len() {
            let (parts, squares) =
                (S::as_mut_simd_f32s(&mut tiles[tile]).0, S::as_simd_f32s(&squares[tile]).0);
            for lanes in 0..CLASSES / S::F32_LANES {
                parts[lanes] = simd.add_f32s(parts[lanes], squares[lanes]);
                classes[lanes] = simd.min_f32s(classes[lanes], parts[lanes]);
            }
        }
        for (class, part) in rest.iter_mut().enumerate() {
            *part += squares_of_rest[class];
            least[class] = least[class].min(*part);
        }
        least
    }

    /// What the part of a nearer eigenpoint can't exceed.
    #[inline(always)]
    fn limit(&self, least: &[f32; CLASSES]) -> f32 {
        // Each of n products and sums in f32 is off by at most 2⁻²⁴ of it, and all of them together are at most
        // (‖q‖ + ‖t‖)²: twice that, for what else is rounded. Infinite if f32 can't hold it: then every eigenpoint is
        // measured.
        let own = dot(self.query, self.query);
        let reach = (own.sqrt() as f32 + self.farthest).powi(2);
        let slack = (self.query.len() + 4) as f32 * f32::EPSILON * reach + f32::MIN_POSITIVE;
        let last = self.found.len() - 1;
        if self.found[last].0.is_finite() {
            (self.found[last].0 - own) as f32 + slack
        } else if last < CLASSES {
            *least.clone().select_nth_unstable_by(last, f32::total_cmp).1 + 2.0 * slack
        } else {
            f32::INFINITY
        }
    }

    /// Inserts an eigenpoint among those found, if it is nearer than the last of them.
    #[inline(always)]
    fn insert(&mut self, index: usize) {
        let last = self.found.len() - 1;
        let candidate = (distance_square(self.query, self.index.point(index)), index);
        if candidate < self.found[last] {
            let mut place = last;
            while place > 0 && candidate < self.found[place - 1] {
                self.found[place] = self.found[place - 1];
                place -= 1;
            }
            self.found[place] = candidate;
        }
    }
}

/// Euclidean distance, in f64.
pub(super) fn distance(a: &[f32], b: &[f32]) -> f64 {
    distance_square(a, b).sqrt()
}

#[inline(always)]
pub(super) fn distance_square(a: &[f32], b: &[f32]) -> f64 {
    sum_in_lanes(a, b, |a, b| (a - b) * (a - b))
}

#[inline(always)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f64 {
    sum_in_lanes(a, b, |a, b| a * b)
}

/// The sum over pairs in f64, eight partial sums at a time.
#[inline(always)]
fn sum_in_lanes(a: &[f32], b: &[f32], term: impl Fn(f64, f64) -> f64) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0_f64; 8];
    for chunk in 0..a.len().min(b.len()) {
        for lane in 0..8 {
            sums[lane] += term(f64::from(a[chunk][lane]), f64::from(b[chunk][lane]));
        }
    }
    for at in 0..a_rest.len().min(b_rest.len()) {
        sums[at] += term(f64::from(a_rest[at]), f64::from(b_rest[at]));
    }
    sums.iter().sum()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn both(points: &[f32], dimension: usize, queries: &[f32]) -> (Vec<Neighbour>, Vec<Neighbour>) {
        let index = EigenpointIndex::with_tree(points.to_vec(), dimension);
        assert!(index.has_tree());
        (index.nearest(queries), index.nearest_several(queries, 1))
    }

    #[test]
    fn ten_thousand_identical_eigenpoints_are_no_trouble() {
        for dimension in [1, 7, 8, 32, 64] {
            let mut points = [0.25].repeat(10_000 * dimension);
            points.extend([0.5].repeat(dimension));
            let queries = [[0.3].repeat(dimension), [0.6].repeat(dimension)].concat();
            let (tree, exhaustive) = both(&points, dimension, &queries);
            assert_eq!(tree, exhaustive);
            assert_eq!((tree[0].index, tree[1].index), (0, 10_000));
        }
    }

    #[test]
    fn equal_coordinates_on_an_axis_do_not_unbalance_the_tree() {
        // nine coordinates, the last five all zero, so that a tree of twelve splits on nothing eight times
        let count = 5000usize;
        let value = |i: usize, k: usize| match k {
            0..4 => ((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ (k as u64 * 77)) >> 40) as f32,
            _ => 0.0,
        };
        let points: Vec<f32> = (0..count).flat_map(|i| (0..9).map(move |k| value(i, k))).collect();
        let queries: Vec<f32> = points.iter().map(|v| v + 3.0).collect();
        let (tree, exhaustive) = both(&points, 9, &queries);
        assert_eq!(tree, exhaustive);
    }

    #[test]
    fn minus_zero_is_zero() {
        let (tree, exhaustive) = both(&[0.0, -0.0, 1.0], 1, &[-0.0, 0.9]);
        assert_eq!(tree, exhaustive);
        assert_eq!((tree[0].index, tree[1].index), (0, 2));
    }

    #[test]
    fn distances_are_not_squared() {
        let index = EigenpointIndex::new(vec![0.0, 0.0, 30.0, 40.0], 2);
        assert_eq!(index.nearest(&[3.0, 4.0]), [Neighbour { index: 0, distance: 5.0 }]);
        assert!(index.nearest(&[]).is_empty());
    }

    #[test]
    fn the_way_is_chosen_as_measured() {
        let ramp = |count: usize, dimension: usize| (0..count * dimension).map(|i| i as f32).collect();
        assert!(EigenpointIndex::new(ramp(10_000, 8), 8).has_tree());
        assert!(!EigenpointIndex::new(ramp(9_999, 8), 8).has_tree());
        assert!(!EigenpointIndex::new(ramp(10_000, 9), 9).has_tree());
        assert!(!EigenpointIndex::new(vec![1.0; 80_000], 8).has_tree());
    }

    #[test]
    fn above_sixty_four_coordinates_there_is_no_tree() {
        let points: Vec<f32> = (0..3 * 65).map(|i| i as f32).collect();
        let index = EigenpointIndex::with_tree(points.clone(), 65);
        assert!(!index.has_tree());
        assert_eq!(index.nearest(&points[65..130]), [Neighbour { index: 1, distance: 0.0 }]);
    }

    #[test]
    fn numbers_beyond_f32_give_an_infinite_distance_and_no_panic() {
        let index = EigenpointIndex::new(vec![f32::MAX, f32::MAX, f32::MIN, f32::MIN], 2);
        assert_eq!(index.nearest(&[f32::MIN, f32::MAX])[0].index, 0);
    }

    /// All eigenpoints, sorted.
    fn all_sorted(points: &[f32], dimension: usize, query: &[f32]) -> Vec<Neighbour> {
        let points = points.chunks_exact(dimension).enumerate();
        let mut all: Vec<(f64, usize)> =
            points.map(|(index, p)| (distance_square(query, p), index)).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all.into_iter().map(|(square, index)| Neighbour { index, distance: square.sqrt() as f32 }).collect()
    }

    #[test]
    fn several_come_from_all_blocks_in_order() {
        // two blocks and a part of a class, queries of two blocks; a far offset makes the products coarse
        let (count, dimension) = (2 * BLOCK_POINTS + 77, 3);
        let value = |i: usize, offset: f32| ((i * 7919) % 10_007) as f32 / 10_007.0 + offset;
        for offset in [0.0, 300.0] {
            let points: Vec<f32> = (0..count * dimension).map(|i| value(i, offset)).collect();
            let queries: Vec<f32> =
                (0..(BLOCK_QUERIES + 3) * dimension).map(|i| value(31 * i + 5, offset)).collect();
            let index = EigenpointIndex::new(points.clone(), dimension);
            let found = [1, 10, CLASSES + 1].map(|asked| (asked, index.nearest_several(&queries, asked)));
            for (at, query) in queries.chunks_exact(dimension).enumerate().step_by(11) {
                let expected = all_sorted(&points, dimension, query);
                for (asked, found) in &found {
                    assert_eq!(
                        found[at * asked..][..*asked],
                        expected[..*asked],
                        "query {at}, offset {offset}"
                    );
                }
            }
        }
    }

    #[test]
    fn several_are_all_where_there_are_fewer() {
        let index = EigenpointIndex::new(vec![3.0, 1.0, 2.0, 1.0], 1);
        let found: Vec<usize> = index.nearest_several(&[0.0, 3.0], 9).iter().map(|n| n.index).collect();
        assert_eq!(found, [1, 3, 2, 0, 0, 2, 1, 3]);
        assert!(index.nearest_several(&[], 9).is_empty());
    }

    #[test]
    fn several_are_found_where_f32_holds_no_square() {
        let points = [1e30, 2e30, -1e30, f32::MAX, f32::MIN, 0.0];
        let found = EigenpointIndex::new(points.to_vec(), 1).nearest_several(&[2.1e30], 6);
        assert_eq!(found.iter().map(|n| n.index).collect::<Vec<_>>(), [1, 0, 5, 2, 3, 4]);
    }

    proptest! {
        #[test]
        fn several_are_the_first_of_all_sorted(
            (dimension, points, queries, count) in (1usize..40, 1usize..150, 1usize..80, 1usize..40).prop_flat_map(
                |(dimension, points, queries, count)| (
                    Just(dimension),
                    // coarse ones among them, for equal distances
                    prop::collection::vec(prop_oneof![-1.0f32..1.0, Just(0.0), Just(0.5)], dimension * points),
                    prop::collection::vec(-1.2f32..1.2, dimension * queries),
                    Just(count),
                ),
            ),
        ) {
            let index = EigenpointIndex::new(points.clone(), dimension);
            let asked = [&queries[..], &points].concat();
            let found = index.nearest_several(&asked, count);
            let rows = found.chunks_exact(count.min(index.count()));
            prop_assert_eq!(rows.len(), asked.len() / dimension);
            for (query, row) in asked.chunks_exact(dimension).zip(rows) {
                prop_assert_eq!(row, &all_sorted(&points, dimension, query)[..row.len()]);
            }
        }

        #[test]
        fn the_tree_finds_what_looking_at_all_finds(
            (dimension, points, queries) in (1usize..=64, 1usize..200, 1usize..20).prop_flat_map(
                |(dimension, points, queries)| (
                    Just(dimension),
                    prop::collection::vec(-1.0f32..1.0, dimension * points),
                    prop::collection::vec(-1.5f32..1.5, dimension * queries),
                ),
            ),
        ) {
            let (tree, exhaustive) = both(&points, dimension, &queries);
            for (a, b) in tree.iter().zip(&exhaustive) {
                // two that are equally far to within f32 may change places
                prop_assert!((a.distance - b.distance).abs() <= 1e-6 * b.distance, "{a:?} is not {b:?}");
            }
            let own = EigenpointIndex::new(points.clone(), dimension).nearest(&points);
            prop_assert!(own.iter().enumerate().all(|(i, n)| n.distance == 0.0 && n.index <= i));
        }

        #[test]
        fn coarse_coordinates_with_many_equals_agree(
            (dimension, points, queries) in (1usize..6, 1usize..400).prop_flat_map(|(dimension, points)| (
                Just(dimension),
                prop::collection::vec(prop::sample::select(vec![0.0f32, 1.0, 2.0]), dimension * points),
                prop::collection::vec(-0.5f32..2.5, dimension * 10),
            )),
        ) {
            let (tree, exhaustive) = both(&points, dimension, &queries);
            for (a, b) in tree.iter().zip(&exhaustive) {
                prop_assert!((a.distance - b.distance).abs() <= 1e-6 * b.distance, "{a:?} is not {b:?}");
            }
        }
    }
}
