//! The k-d tree of `kiddo`, over eigenpoints whose dimension is known at run time only.

use std::cmp::Ordering;
use std::ops::Range;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// A tree over the distinct eigenpoints of a set: a tree can't split identical ones.
pub(super) struct PointTree {
    tree: OfSize,
    /// Rows of the eigenpoints; identical ones stand together, ascending.
    rows: Vec<u32>,
    /// Where in `rows` the rows of each point of the tree stand.
    groups: Vec<Range<u32>>,
}

impl PointTree {
    /// A tree over n × `dimension` row-major eigenpoints, all finite. `None` above 64 coordinates, where a tree
    /// visits everything, more slowly than a loop.
    pub fn new(points: &[f32], dimension: usize) -> Option<PointTree> {
        let count = u32::try_from(points.len() / dimension).expect("eigenpoints are counted in 32 bits");
        let point = |row: u32| &points[row as usize * dimension..][..dimension];
        let unequal = |a: u32, b: u32| {
            let pairs = point(a).iter().zip(point(b));
            pairs.map(|(a, b)| a.partial_cmp(b).unwrap_or(Ordering::Equal)).find(|o| o.is_ne())
        };
        let mut rows: Vec<u32> = (0..count).collect();
        rows.sort_unstable_by(|&a, &b| unequal(a, b).unwrap_or(a.cmp(&b)));
        let mut groups: Vec<Range<u32>> = Vec::new();
        for at in 0..count {
            match groups.last_mut() {
                Some(group) if unequal(rows[at as usize - 1], rows[at as usize]).is_none() => {
                    group.end = at + 1;
                }
                _ => groups.push(at..at + 1),
            }
        }
        // by their lowest rows: the same eigenpoints in the same order make the same tree
        groups.sort_unstable_by_key(|group| rows[group.start as usize]);
        let distinct = groups.iter().map(|group| point(rows[group.start as usize]));
        Some(PointTree { tree: OfSize::new(distinct, dimension)?, rows, groups })
    }

    /// How many distinct eigenpoints there are.
    pub fn distinct(&self) -> usize {
        self.groups.len()
    }

    /// The row of the nearest, the lowest of identical ones.
    pub fn nearest(&self, query: &[f32]) -> usize {
        self.rows[self.groups[self.tree.nearest(query)].start as usize] as usize
    }

    /// The rows within √`square`, in no order.
    pub fn within(&self, query: &[f32], square: f32) -> impl Iterator<Item = usize> {
        let groups = self.tree.within(query, square).into_iter().map(|group| &self.groups[group as usize]);
        groups.flat_map(|group| &self.rows[group.start as usize..group.end as usize]).map(|&row| row as usize)
    }
}

/// `kiddo`'s tree has its dimension in its type: some sizes, padded with zeros up to the next.
macro_rules! trees {
    ($($size:ident = $dimension:literal),*) => {
        enum OfSize { $($size(Box<ImmutableKdTree<f32, $dimension>>)),* }

        impl OfSize {
            fn new<'a>(points: impl Iterator<Item = &'a [f32]>, dimension: usize) -> Option<OfSize> {
                $(if dimension <= $dimension {
                    let padded: Vec<[f32; $dimension]> = points.map(padded).collect();
                    return Some(OfSize::$size(Box::new(ImmutableKdTree::new_from_slice(&padded).ok()?)));
                })*
                None
            }

            fn nearest(&self, query: &[f32]) -> usize {
                match self {
                    $(OfSize::$size(tree) => {
                        let query: [f32; $dimension] = padded(query);
                        tree.query(&query).nearest_one::<SquaredEuclidean<f32>>().execute().item as usize
                    })*
                }
            }

            fn within(&self, query: &[f32], square: f32) -> Vec<u32> {
                match self {
                    $(OfSize::$size(tree) => {
                        let query: [f32; $dimension] = padded(query);
                        let found = tree.query(&query).within::<SquaredEuclidean<f32>>(square).unsorted().execute();
                        found.iter().map(|found| found.item as u32).collect()
                    })*
                }
            }
        }
    };
}
trees!(Of8 = 8, Of12 = 12, Of16 = 16, Of24 = 24, Of32 = 32, Of48 = 48, Of64 = 64);

/// The coordinates with zeros after them: no distance changes.
fn padded<const D: usize>(point: &[f32]) -> [f32; D] {
    let mut wide = [0.0; D];
    wide[..point.len()].copy_from_slice(point);
    wide
}
