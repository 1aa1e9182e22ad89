//! The nearest of a set of eigenpoints (A§4.5), exactly: by a k-d tree, or by looking at all of them.
//!
//! Distances are Euclidean, not squared. Both ways return the distance as computed in f64 from the
//! eigenpoint found, so that they agree to the bit where they find the same; of identical eigenpoints the
//! lowest index is found.

use pulp::{Arch, Simd, WithSimd};

use super::tree::PointTree;

/// A tree is asked for up to this many coordinates, and from this many different eigenpoints on.
///
/// Measured by `benches/search.rs` for 64 queries, half of them new, in ms, tree / looking at all:
///
/// | coordinates | 1280 | 10 000 | 100 000 eigenpoints |
/// | --- | --- | --- | --- |
/// | 8 | 0.21 / 0.10 | 0.43 / 0.71 | 1.2 / 8.3 |
/// | 16 | 0.58 / 0.18 | 3.3 / 1.2 | 15.8 / 10.0 |
/// | 32 | 0.99 / 0.21 | 6.2 / 2.0 | 92 / 22 |
/// | 64 | 3.3 / 0.35 | 18 / 3.8 | 258 / 38 |
const TREE_TO_DIMENSION: usize = 8;
const TREE_FROM_POINTS: usize = 10_000;
/// Eigenpoints compared at a time: 64 partial sums are 8 vector registers' worth, half of AVX2's.
const LANES: usize = 64;
/// Coordinates taken at a time; tiles are padded with zeros to a multiple.
const STEP: usize = 4;

/// An eigenpoint found, and how far it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbour {
    /// Row of the eigenpoint.
    pub index: usize,
    /// Euclidean distance.
    pub distance: f32,
}

/// A set of eigenpoints that can be asked for the nearest.
pub struct EigenpointIndex {
    points: Vec<f32>,
    dimension: usize,
    /// The eigenpoints in tiles of [`LANES`], coordinate by coordinate within a tile.
    tiles: Vec<f32>,
    tree: Option<PointTree>,
}

impl EigenpointIndex {
    /// An index over n × `dimension` row-major eigenpoints, all finite. Chooses the faster way by itself.
    ///
    /// # Panics
    /// If there is no eigenpoint, or not a whole number of them.
    pub fn new(points: Vec<f32>, dimension: usize) -> Self {
        let count = points.len() / dimension.max(1);
        let mut index = EigenpointIndex::exhaustive(points, dimension);
        if dimension <= TREE_TO_DIMENSION && count >= TREE_FROM_POINTS {
            index.tree = PointTree::new(&index.points, dimension);
            if index.tree.as_ref().is_some_and(|tree| tree.different() < TREE_FROM_POINTS) {
                index.tree = None;
            }
        }
        index
    }

    /// An index that asks a k-d tree if there is one for this dimension (64 at most), whatever is faster.
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
        let tiles = tiles(&points, dimension);
        EigenpointIndex { points, dimension, tiles, tree: None }
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

    /// Memory held.
    pub fn bytes(&self) -> usize {
        let copies = if self.has_tree() { 2 } else { 1 };
        size_of_val(&self.points[..]) * copies + size_of_val(&self.tiles[..])
    }

    /// The nearest eigenpoint of each of n × dimension row-major queries, all finite.
    ///
    /// # Panics
    /// If `queries` is not a whole number of them.
    pub fn nearest(&self, queries: &[f32]) -> Vec<Neighbour> {
        let Some(tree) = &self.tree else { return self.nearest_exhaustive(queries) };
        assert!(queries.len().is_multiple_of(self.dimension), "whole queries");
        queries.chunks_exact(self.dimension).map(|query| self.neighbour(query, tree.nearest(query))).collect()
    }

    /// The same by looking at every eigenpoint: the judge of the tree.
    ///
    /// # Panics
    /// If `queries` is not a whole number of them.
    pub fn nearest_exhaustive(&self, queries: &[f32]) -> Vec<Neighbour> {
        assert!(queries.len().is_multiple_of(self.dimension), "whole queries");
        let padded = self.dimension.next_multiple_of(STEP);
        let count = queries.len() / self.dimension;
        let mut spread = vec![0.0; count * padded];
        for (wide, query) in spread.chunks_exact_mut(padded).zip(queries.chunks_exact(self.dimension)) {
            wide[..self.dimension].copy_from_slice(query);
        }
        // a tile stays in the first cache while all queries pass over it
        let mut best = vec![(f32::INFINITY, 0); count];
        for (number, tile) in self.tiles.chunks_exact(padded * LANES).enumerate() {
            let first = number * LANES;
            Arch::new().dispatch(NearestInTile { tile, first, queries: &spread, best: &mut best });
        }
        let queries = queries.chunks_exact(self.dimension).zip(best);
        queries.map(|(query, (_, index))| self.neighbour(query, index)).collect()
    }

    fn point(&self, index: usize) -> &[f32] {
        &self.points[index * self.dimension..][..self.dimension]
    }

    fn neighbour(&self, query: &[f32], index: usize) -> Neighbour {
        Neighbour { index, distance: distance(query, self.point(index)) as f32 } // A§4.5: D
    }
}

/// Euclidean distance, in f64.
pub(super) fn distance(a: &[f32], b: &[f32]) -> f64 {
    let difference = |(a, b): (&f32, &f32)| f64::from(*a) - f64::from(*b);
    a.iter().zip(b).map(difference).map(|d| d * d).sum::<f64>().sqrt()
}

/// Tiles of [`LANES`] eigenpoints, padded with zeros in the coordinates and with infinities at the end.
fn tiles(points: &[f32], dimension: usize) -> Vec<f32> {
    let padded = dimension.next_multiple_of(STEP);
    let count = points.len() / dimension;
    let mut tiles = vec![0.0; count.div_ceil(LANES) * padded * LANES];
    for (tile, members) in tiles.chunks_exact_mut(padded * LANES).zip(points.chunks(LANES * dimension)) {
        let members = members.chunks_exact(dimension);
        tile[members.len()..LANES].fill(f32::INFINITY);
        for (lane, point) in members.enumerate() {
            for (k, &coordinate) in point.iter().enumerate() {
                tile[k * LANES + lane] = coordinate;
            }
        }
    }
    tiles
}

/// Lower each query's best (squared distance, index) if the tile holds something nearer.
struct NearestInTile<'a> {
    tile: &'a [f32],
    /// Index of the tile's first eigenpoint.
    first: usize,
    queries: &'a [f32],
    best: &'a mut [(f32, usize)],
}

impl WithSimd for NearestInTile<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let padded = self.tile.len() / LANES;
        for (query, best) in self.queries.chunks_exact(padded).zip(self.best) {
            let squares = squares(self.tile, query);
            let mut least = [f32::INFINITY; LANES / 4];
            for part in squares.chunks_exact(LANES / 4) {
                for (least, &square) in least.iter_mut().zip(part) {
                    *least = if square < *least { square } else { *least };
                }
            }
            if least.iter().any(|&square| square < best.0) {
                for (lane, &square) in squares.iter().enumerate() {
                    if square < best.0 {
                        *best = (square, self.first + lane);
                    }
                }
            }
        }
    }
}

/// Squared distances of a query from the eigenpoints of a tile.
#[inline(always)]
fn squares(tile: &[f32], query: &[f32]) -> [f32; LANES] {
    let mut squares = [0.0_f32; LANES];
    for (rows, q) in tile.chunks_exact(STEP * LANES).zip(query.chunks_exact(STEP)) {
        let (a, rest) = rows.split_at(LANES);
        let (b, rest) = rest.split_at(LANES);
        let (c, d) = rest.split_at(LANES);
        for lane in 0..LANES {
            let (a, b, c, d) = (a[lane] - q[0], b[lane] - q[1], c[lane] - q[2], d[lane] - q[3]);
            squares[lane] += (a * a + b * b) + (c * c + d * d);
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn both(points: &[f32], dimension: usize, queries: &[f32]) -> (Vec<Neighbour>, Vec<Neighbour>) {
        let index = EigenpointIndex::with_tree(points.to_vec(), dimension);
        assert!(index.has_tree());
        (index.nearest(queries), index.nearest_exhaustive(queries))
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

    proptest! {
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
