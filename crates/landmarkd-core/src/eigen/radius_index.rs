//! The eigenpoints within a radius (B(16)), by one of three methods; all give the same answers.
//!
//! Measured by `benches/search.rs` for 64 queries with about five eigenpoints within the radius, in ms, k-d tree /
//! slabs / product:
//!
//! | coordinates | 720 | 7200 | 72 000 eigenpoints |
//! | --- | --- | --- | --- |
//! | 8 | 0.23 / 0.69 / 1.0 | 0.76 / 3.9 / 9.5 | 1.7 / 28 / 81 |
//! | 15 | 0.38 / 1.2 / 1.6 | 2.6 / 8.9 / 11 | 20 / 121 / 87 |
//! | 36 | 0.71 / 2.8 / 1.2 | 5.9 / 25 / 12 | 124 / 467 / 112 |
//!
//! Each method selects a superset of the eigenpoints within the radius; then the distance of each is computed in f64 by
//! the same formula, so that no answer depends on the method. Distances are Euclidean, not squared.

use std::cmp::Ordering;

use super::neighbours::{Neighbour, distance};
use super::tree::PointTree;

/// The search of a [`RadiusIndex`]; the answers are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// A k-d tree over the leading coordinates, 16 at most: the fastest up to some ten thousand eigenpoints.
    KdTree,
    /// B Fig. 8 (Nene and Nayar 1997): each coordinate sorted; what lies between the two hyperplanes of the
    /// coordinate that has the fewest there is cut down by the others.
    Slabs,
    /// The product of the query with all eigenpoints: ‖h‖² − 2 h·hᵢ + ‖hᵢ‖², B(14).
    Exhaustive,
}

/// More coordinates than this only slow a tree down: what is far in 16 is far in all.
const TREE_COORDINATES: usize = 16;
/// Bounds in f32 are widened by this part, so that rounding never loses an eigenpoint.
const SLACK: f32 = 1e-5;

/// A set of eigenpoints, indexed for those within a radius.
pub struct RadiusIndex {
    points: Vec<f32>,
    dimension: usize,
    finder: Finder,
}

enum Finder {
    Tree {
        tree: PointTree,
        coordinates: usize,
    },
    Slabs(Vec<Axis>),
    /// ‖hᵢ‖²
    Exhaustive(Vec<f32>),
}

impl RadiusIndex {
    /// Over n × `dimension` row-major eigenpoints, all finite.
    ///
    /// # Panics
    /// If there is no eigenpoint, or not a whole number of them.
    pub fn new(points: Vec<f32>, dimension: usize, search: Search) -> Self {
        assert!(dimension > 0 && !points.is_empty(), "there is an eigenpoint");
        assert!(points.len().is_multiple_of(dimension), "whole eigenpoints");
        let rows = || points.chunks_exact(dimension);
        let finder = match search {
            Search::KdTree => {
                let coordinates = dimension.min(TREE_COORDINATES);
                let leading: Vec<f32> = rows().flat_map(|point| &point[..coordinates]).copied().collect();
                let tree = PointTree::new(&leading, coordinates).expect("there are trees of 16 coordinates");
                Finder::Tree { tree, coordinates }
            }
            Search::Slabs => {
                Finder::Slabs((0..dimension).map(|axis| sorted(&points, dimension, axis)).collect())
            }
            Search::Exhaustive => Finder::Exhaustive(rows().map(|point| dot(point, point)).collect()),
        };
        Self { points, dimension, finder }
    }

    /// The eigenpoints, n × dimension, row-major.
    pub fn points(&self) -> &[f32] {
        &self.points
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        let count = self.points.len() / self.dimension;
        let finder = match &self.finder {
            Finder::Tree { coordinates, .. } => count * (4 * coordinates + 16),
            Finder::Slabs(axes) => 8 * count * axes.len(),
            Finder::Exhaustive(_) => 4 * count,
        };
        4 * self.points.len() + finder
    }

    /// The eigenpoints at most `radius` from the query, the nearest first, of equally near ones the lowest row first.
    ///
    /// # Panics
    /// If the query has another number of coordinates, or the radius is NaN or negative.
    pub fn within(&self, query: &[f32], radius: f64) -> Vec<Neighbour> {
        assert_eq!(query.len(), self.dimension, "a query has the coordinates of an eigenpoint");
        assert!(radius >= 0.0, "a radius is a distance");
        let mut found = Vec::new();
        let mut measure = |index: usize| {
            let distance = distance(query, &self.points[index * self.dimension..][..self.dimension]);
            if distance <= radius {
                found.push((distance, index));
            }
        };
        // never below what the radius is in f64
        let reach = radius as f32 * (1.0 + SLACK) + f32::MIN_POSITIVE;
        match &self.finder {
            Finder::Tree { tree, coordinates } => {
                tree.within(&query[..*coordinates], reach * reach * (1.0 + SLACK)).for_each(&mut measure);
            }
            Finder::Slabs(axes) => self.between_slabs(axes, query, reach).for_each(&mut measure),
            Finder::Exhaustive(squares) => self.by_products(squares, query, reach).for_each(&mut measure),
        }
        let by_distance = |a: &(f64, usize), b: &(f64, usize)| {
            a.0.partial_cmp(&b.0).unwrap_or(Ordering::Equal).then(a.1.cmp(&b.1))
        };
        found.sort_unstable_by(by_distance);
        found.into_iter().map(|(distance, index)| Neighbour { index, distance: distance as f32 }).collect()
    }

    /// The rows that lie between the hyperplanes of every coordinate, from those of the one that has the fewest.
    fn between_slabs(&self, axes: &[Axis], query: &[f32], reach: f32) -> impl Iterator<Item = usize> {
        let slabs = axes.iter().zip(query).map(|(Axis { values, rows }, q)| {
            let reach = reach + SLACK * q.abs();
            let from = values.partition_point(|value| *value < q - reach);
            let to = values.partition_point(|value| *value <= q + reach);
            &rows[from..to.max(from)]
        });
        let narrowest = slabs.min_by_key(|rows| rows.len()).expect("there is a coordinate");
        narrowest.iter().map(|&row| row as usize).filter(move |row| {
            let point = &self.points[row * self.dimension..][..self.dimension];
            point.iter().zip(query).all(|(p, q)| (p - q).abs() <= reach + SLACK * q.abs())
        })
    }

    /// The rows that are near by B(14); `squares` are ‖hᵢ‖².
    fn by_products(&self, squares: &[f32], query: &[f32], reach: f32) -> impl Iterator<Item = usize> {
        let own = dot(query, query);
        let rows = self.points.chunks_exact(self.dimension).zip(squares).enumerate();
        rows.filter_map(move |(row, (point, &square))| {
            let apart = own - 2.0 * dot(query, point) + square; // B(14)
            (apart <= reach * reach + SLACK * (own + square) || !apart.is_finite()).then_some(row)
        })
    }
}

/// One coordinate of all eigenpoints: its values ascending, and their rows.
struct Axis {
    values: Vec<f32>,
    rows: Vec<u32>,
}

fn sorted(points: &[f32], dimension: usize, axis: usize) -> Axis {
    let value = |row: u32| points[row as usize * dimension + axis];
    let count = u32::try_from(points.len() / dimension).expect("eigenpoints are counted in 32 bits");
    let mut rows: Vec<u32> = (0..count).collect();
    rows.sort_unstable_by(|&a, &b| {
        value(a).partial_cmp(&value(b)).unwrap_or(Ordering::Equal).then(a.cmp(&b))
    });
    Axis { values: rows.iter().map(|&row| value(row)).collect(), rows }
}

/// a·b, eight partial sums at a time.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0_f32; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SEARCHES: [Search; 3] = [Search::KdTree, Search::Slabs, Search::Exhaustive];

    #[test]
    fn the_radius_is_inclusive() {
        for search in SEARCHES {
            let index = RadiusIndex::new(vec![0.0, 0.0, 3.0, 4.0, 3.0, 4.0, 9.0, 9.0], 2, search);
            let found = index.within(&[0.0, 0.0], 5.0);
            assert_eq!(found.iter().map(|n| n.index).collect::<Vec<_>>(), [0, 1, 2], "{search:?}");
            assert_eq!(found[1].distance, 5.0);
            assert!(index.within(&[-1.0, -1.0], 0.5).is_empty());
            assert_eq!(index.within(&[0.0, 0.0], f64::INFINITY).len(), 4);
            assert_eq!(index.within(&[9.0, 9.0], 0.0).len(), 1);
        }
    }

    #[test]
    fn ten_thousand_queries_have_the_same_answers_by_each_search() {
        let mut state = 5_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
        };
        for (dimension, radius) in [(8, 0.45), (15, 0.9), (36, 1.8)] {
            let points: Vec<f32> = (0..720 * dimension).map(|_| next()).collect();
            let queries: Vec<f32> = (0..10_000 * dimension).map(|_| next()).collect();
            let [tree, slabs, all] =
                SEARCHES.map(|search| RadiusIndex::new(points.clone(), dimension, search));
            let mut found = 0;
            for query in queries.chunks_exact(dimension) {
                let expected = all.within(query, radius);
                assert_eq!(tree.within(query, radius), expected);
                assert_eq!(slabs.within(query, radius), expected);
                found += expected.len();
            }
            assert!((1_000..1_000_000).contains(&found), "{dimension} coordinates: {found} found");
        }
    }

    proptest! {
        #[test]
        fn all_searches_find_the_same(
            (dimension, points, queries, radius) in (1usize..40, 1usize..150, 1usize..8, 0.0f64..3.0).prop_flat_map(
                |(dimension, points, queries, radius)| (
                    Just(dimension),
                    prop::collection::vec(-1.0f32..1.0, dimension * points),
                    prop::collection::vec(-1.2f32..1.2, dimension * queries),
                    Just(radius),
                ),
            ),
        ) {
            // every point twice: a tree must give both
            let twice = [&points[..], &points[..]].concat();
            let [tree, slabs, all] = SEARCHES.map(|search| RadiusIndex::new(twice.clone(), dimension, search));
            for query in queries.chunks_exact(dimension).chain(points.chunks_exact(dimension)) {
                let expected = all.within(query, radius);
                prop_assert_eq!(&tree.within(query, radius), &expected);
                prop_assert_eq!(&slabs.within(query, radius), &expected);
                let counted = twice.chunks_exact(dimension).filter(|p| distance(query, p) <= radius).count();
                prop_assert_eq!(expected.len(), counted);
            }
        }
    }
}
