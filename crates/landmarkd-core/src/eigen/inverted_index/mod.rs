//! The several nearest of many eigenpoints, nearly always: an inverted index with codes of residuals (Sivic and Zisserman
//! 2003; Jégou, Douze and Schmid 2011).
//!
//! k-means on a seeded sample gives centroids. Each eigenpoint is in the list of its nearest centroid, as what it differs from
//! it by, a byte a coordinate; a query looks through the lists of the centroids nearest to it. A list is read once for all
//! queries that probe it.
//!
//! Of ‖q − t‖² = ‖q‖² + (‖t‖² − 2 q·t), B(14), with t = c + r, q·c is computed once a list, q·r with whole numbers: half of
//! what 16 bits take from memory, and whole numbers add up to the same on every machine. The few that are nearest by their
//! codes are measured with 4 bits more a coordinate.

mod blocks;
mod candidates;
mod codebook;
mod queries;

use std::sync::Arc;

use blocks::{BLOCK, Blocks};
use candidates::Candidates;
pub use codebook::{Code, Codebook};
use queries::{Tiles, WholeQueries};

use pulp::{Arch, Simd, WithSimd};

use super::neighbours::{Neighbour, dot};

/// Below this many eigenpoints all lists are probed.
const EXACT_BELOW: usize = 4096;
/// Eigenpoints of a list, where all lists are probed.
const SHORT_LIST: usize = 64;
/// Lists that a query probes at least.
const PROBES: usize = 64;
/// Eigenpoints in the lists that a query probes, about, at least.
const LEAST_PROBED: usize = 256;
/// Of them, those that are probed before all others.
const FIRST_PROBES: usize = 3;
/// Candidates that are measured finely beside a quarter more than are asked for.
const MORE: usize = 4;

/// Lists for so many eigenpoints: short ones where all are probed; else some 4 √n, of which [`PROBES`] are.
pub fn lists_for(count: usize) -> usize {
    if count < EXACT_BELOW {
        count.div_ceil(SHORT_LIST).max(1)
    } else {
        (4.0 * (count as f64).sqrt()).round() as usize
    }
}

/// A set of eigenpoints in lists.
#[derive(Clone)]
pub struct InvertedIndex {
    codebook: Arc<Codebook>,
    /// How many eigenpoints there are.
    count: usize,
    /// The blocks of each list: from one number to the next. One more than there are lists.
    starts: Vec<u32>,
    blocks: Blocks<i8>,
    /// Place by place what the codes leave.
    fine: Vec<u8>,
}

impl InvertedIndex {
    /// An index over n × `dimension` row-major eigenpoints, all finite, in as many lists as [`lists_for`] says.
    ///
    /// # Panics
    /// If there is no eigenpoint, not a whole number of them, or more than a u32 counts.
    pub fn new(points: &[f32], dimension: usize) -> InvertedIndex {
        InvertedIndex::with_lists(points, dimension, lists_for(points.len() / dimension.max(1)))
    }

    /// An index of at most `lists` lists; of as many as there are eigenpoints if those are fewer.
    ///
    /// # Panics
    /// As [`InvertedIndex::new`], or if `lists` is 0.
    pub fn with_lists(points: &[f32], dimension: usize, lists: usize) -> InvertedIndex {
        let codebook = Codebook::fit(points, dimension, lists);
        let codes = codebook.encode(points);
        InvertedIndex::of_codes(Arc::new(codebook), &codes, Code::length(dimension))
    }

    /// The index of the eigenpoints whose codes start rows of `row_length` bytes.
    ///
    /// # Panics
    /// If the codes are not of that codebook, or more than a u32 counts.
    pub fn of_codes(codebook: Arc<Codebook>, rows: &[u8], row_length: usize) -> InvertedIndex {
        let (lists, dimension) = (codebook.lists(), codebook.dimension());
        let code = |index: usize| Code::of_row(&rows[index * row_length..][..row_length], dimension);
        let count = rows.len() / row_length;
        assert!(count < u32::MAX as usize, "eigenpoints are numbered by u32");
        let mut ends = vec![0_usize; lists];
        (0..count).for_each(|index| ends[code(index).list as usize] += 1);
        let (mut starts, mut before) = (vec![0_u32], 0);
        for end in &mut ends {
            starts.push(starts[starts.len() - 1] + end.div_ceil(BLOCK) as u32);
            before += *end;
            *end = before;
        }
        // list by list, so that a block is filled while it is in the cache
        let mut order = vec![0_u32; count];
        for index in (0..count).rev() {
            let end = &mut ends[code(index).list as usize];
            *end -= 1;
            order[*end] = index as u32;
        }
        let mut blocks = Blocks::new(starts[lists] as usize, dimension);
        let length = dimension.div_ceil(2);
        let mut fine = vec![0; starts[lists] as usize * BLOCK * length];
        for (list, &first) in ends.iter().enumerate() {
            let own = &order[first..ends.get(list + 1).copied().unwrap_or(count)];
            for (place, &index) in (starts[list] as usize * BLOCK..).zip(own) {
                let code = code(index as usize);
                let square = codebook.decoded(list, code.coordinates).map(|v| v * v).sum();
                blocks.put(place, index, code.coordinates, square);
                fine[place * length..][..length].copy_from_slice(code.fine);
            }
        }
        InvertedIndex { codebook, count, starts, blocks, fine }
    }

    /// The codes of the eigenpoints, in their order: of each [`Code::length`] bytes.
    pub fn codes(&self) -> Vec<u8> {
        let dimension = self.codebook.dimension();
        let (length, pairs) = (Code::length(dimension), dimension.div_ceil(2));
        let mut codes = vec![0; self.count * length];
        let (mut coordinates, mut row) = (vec![0; 2 * pairs], Vec::with_capacity(length));
        for (list, blocks) in self.starts.windows(2).enumerate() {
            for place in blocks[0] as usize * BLOCK..blocks[1] as usize * BLOCK {
                let index = self.blocks.index(place);
                if index != blocks::EMPTY {
                    let pairs_of =
                        coordinates.as_chunks_mut::<2>().0.iter_mut().zip(self.blocks.point(place));
                    pairs_of.for_each(|(coordinates, pair)| *coordinates = *pair);
                    let fine = &self.fine[place * pairs..][..pairs];
                    row.clear();
                    Code { list: list as u32, coordinates: &coordinates[..dimension], fine }
                        .append_to(&mut row);
                    codes[index as usize * length..][..length].copy_from_slice(&row);
                }
            }
        }
        codes
    }

    /// Writes the eigenpoint of a place as it is kept, and returns its index.
    #[inline(always)]
    fn decode(&self, place: usize, point: &mut [f32]) -> u32 {
        let list = self.starts.partition_point(|&start| start as usize <= place / BLOCK) - 1;
        let pairs = self.codebook.dimension().div_ceil(2);
        let fine = &self.fine[place * pairs..][..pairs];
        self.codebook.decode_finely(list, self.blocks.point(place), fine, point);
        self.blocks.index(place)
    }

    /// The centroids and steps.
    pub fn codebook(&self) -> &Arc<Codebook> {
        &self.codebook
    }

    /// How many eigenpoints there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// How many lists there are.
    pub fn lists(&self) -> usize {
        self.codebook.lists()
    }

    /// Memory that it takes, in bytes: of each eigenpoint a byte and a half a coordinate, 8 more, and a little.
    pub fn bytes(&self) -> usize {
        self.codebook.bytes() + size_of_val(&self.starts[..]) + self.blocks.bytes() + self.fine.len()
    }

    /// The `count` nearest eigenpoints of each of n × dimension row-major queries, all finite, among the lists nearest
    /// to each.
    ///
    /// A row of `count` for each query, or of all eigenpoints if there are fewer; ascending distances, of equal
    /// ones the lower index first.
    ///
    /// # Panics
    /// If `queries` is not a whole number of them, or `count` is 0.
    pub fn nearest_several(&self, queries: &[f32], count: usize) -> Vec<Neighbour> {
        // more of them where few eigenpoints are in the lists of many
        let probes = match self.count() {
            count if count < EXACT_BELOW => self.lists(),
            count => PROBES.max(self.lists() * LEAST_PROBED / count),
        };
        self.nearest_several_probing(queries, count, probes)
    }

    /// As [`InvertedIndex::nearest_several`], probing `probes` lists, all where those hold fewer than `count`.
    ///
    /// # Panics
    /// As [`InvertedIndex::nearest_several`], or if `probes` is 0.
    pub fn nearest_several_probing(&self, queries: &[f32], count: usize, probes: usize) -> Vec<Neighbour> {
        let dimension = self.codebook.dimension();
        assert!(queries.len().is_multiple_of(dimension), "whole queries");
        assert!(count > 0 && probes > 0, "a query asks for something, somewhere");
        let (asked, count) = (queries.len() / dimension, count.min(self.count()));
        let few = count + count / 4 + MORE;
        let mut candidates: Vec<Candidates> = (0..asked).map(|_| Candidates::new(few)).collect();
        let probed = self.probed(queries, probes.min(self.lists()));
        let steps = self.codebook.steps();
        let whole = WholeQueries::new(queries, dimension, |at| steps[at]);
        let mut tiles = Tiles::default();
        for probed in probed {
            self.scan_lists(&whole, &probed, &mut candidates, &mut tiles);
        }
        for number in 0..asked {
            if candidates[number].len() < count {
                // those lists hold too few
                candidates[number] = Candidates::new(few);
                let query = &queries[number * dimension..][..dimension];
                let every: Vec<Probe> =
                    (0..self.lists() as u32).map(|list| self.probe(list, number, query)).collect();
                self.scan_lists(&whole, &every, &mut candidates, &mut tiles);
            }
        }
        let mut found = Vec::with_capacity(asked * count);
        let (mut measured, mut point) = (Vec::with_capacity(few), vec![0.0; dimension]);
        for (query, candidates) in queries.chunks_exact(dimension).zip(&mut candidates) {
            let (point, measured) = (&mut point[..], &mut measured);
            Arch::new().dispatch(Measure { index: self, query, candidates, point, measured });
            measured.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let nearest = measured.iter().take(count);
            found.extend(nearest.map(|&(square, index)| Neighbour { index, distance: square.sqrt() }));
        }
        found
    }

    /// Which queries probe which lists, by list: first each its nearest ones, so that it knows how near its nearest are at
    /// most; then the others.
    fn probed(&self, queries: &[f32], probes: usize) -> [Vec<Probe>; 2] {
        let dimension = self.codebook.dimension();
        let (blocks, unit) = self.codebook.blocks();
        let whole = WholeQueries::new(queries, dimension, |_| 1.0);
        let mut nearest: Vec<Candidates> = (0..whole.count()).map(|_| Candidates::new(probes)).collect();
        let mut tiles = Tiles::default();
        tiles.fill(&whole, unit, (0..whole.count() as u32).map(|number| (number, 0.0)));
        blocks.scan(0..blocks.count(), &tiles, &mut nearest);
        let mut probed = [(); 2].map(|()| Vec::with_capacity(whole.count() * probes));
        let queries = queries.chunks_exact(dimension);
        for (number, (query, nearest)) in queries.zip(&mut nearest).enumerate() {
            for (rank, (_, list)) in nearest.nearest().enumerate() {
                probed[usize::from(rank >= FIRST_PROBES)].push(self.probe(list, number, query));
            }
        }
        probed.iter_mut().for_each(|probed| probed.sort_unstable_by_key(|probe| (probe.list, probe.query)));
        probed
    }

    fn probe(&self, list: u32, number: usize, query: &[f32]) -> Probe {
        let offset = -2.0 * dot(query, self.codebook.centroid(list as usize)) as f32;
        Probe { list, query: number as u32, offset }
    }

    /// Shows the lists to the queries that probe them; sorted by list.
    fn scan_lists(
        &self,
        whole: &WholeQueries,
        probed: &[Probe],
        candidates: &mut [Candidates],
        tiles: &mut Tiles,
    ) {
        for probed in probed.chunk_by(|a, b| a.list == b.list) {
            let list = probed[0].list as usize;
            tiles.fill(whole, 1.0, probed.iter().map(|probe| (probe.query, probe.offset)));
            let blocks = self.starts[list] as usize..self.starts[list + 1] as usize;
            self.blocks.scan(blocks, tiles, candidates);
        }
    }
}

/// The squared distances of a query's candidates, finely.
struct Measure<'a> {
    index: &'a InvertedIndex,
    query: &'a [f32],
    candidates: &'a mut Candidates,
    /// Room for an eigenpoint.
    point: &'a mut [f32],
    /// (‖q − t‖², index).
    measured: &'a mut Vec<(f32, usize)>,
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.measured.clear();
        for (_, place) in self.candidates.nearest() {
            let index = self.index.decode(place as usize, self.point);
            self.measured.push((square_distance(self.query, self.point), index as usize));
        }
    }
}

/// ‖q − t‖², summed as one vector of AVX2 does. // B(14)
#[inline(always)]
fn square_distance(query: &[f32], point: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 8];
    let (queries, last_queries) = query.as_chunks::<8>();
    let (points, last_points) = point.as_chunks::<8>();
    for (q, t) in queries.iter().zip(points) {
        for lane in 0..8 {
            sums[lane] += (q[lane] - t[lane]) * (q[lane] - t[lane]);
        }
    }
    let rest: f32 = last_queries.iter().zip(last_points).map(|(q, t)| (q - t) * (q - t)).sum();
    sums.iter().sum::<f32>() + rest
}

/// A query that probes a list.
struct Probe {
    list: u32,
    query: u32,
    /// −2 q·c.
    offset: f32,
}

#[cfg(test)]
mod tests {
    use super::super::EigenpointIndex;
    use super::*;
    use crate::random::Random;

    const DIMENSION: usize = 24;

    /// Clusters of some eigenpoints each.
    fn clustered(count: usize, seed: u64) -> Vec<f32> {
        let mut middles = Random::new(1, 1);
        let middles: Vec<f32> = (0..50 * DIMENSION).map(|_| middles.normals()[0] as f32).collect();
        let mut random = Random::new(seed, 2);
        let point = |_| {
            let cluster = (random.uniform() * 50.0) as usize;
            let middle = &middles[cluster * DIMENSION..][..DIMENSION];
            middle.iter().map(|v| v + 0.3 * random.normals()[0] as f32).collect::<Vec<f32>>()
        };
        (0..count).flat_map(point).collect()
    }

    /// The eigenpoints as they are kept.
    fn kept(index: &InvertedIndex) -> Vec<f32> {
        let mut points = vec![vec![]; index.count()];
        for place in 0..index.blocks.count() * BLOCK {
            let mut point = vec![0.0; DIMENSION];
            let index = index.decode(place, &mut point);
            if index != blocks::EMPTY {
                points[index as usize] = point;
            }
        }
        points.concat()
    }

    #[test]
    fn with_all_lists_probed_the_nearest_of_what_is_kept_are_found() {
        for (count, lists) in [(1, 1), (5, 5), (333, 7), (4000, 60), (4001, 1)] {
            let (points, queries) = (clustered(count, 3), clustered(37, 4));
            let index = InvertedIndex::with_lists(&points, DIMENSION, lists);
            let exact = EigenpointIndex::new(kept(&index), DIMENSION);
            for asked in [1, 6, 31, 200] {
                let found = index.nearest_several_probing(&queries, asked, lists);
                let wanted = exact.nearest_several(&queries, asked);
                assert_eq!(found.len(), wanted.len());
                let mut others = 0;
                for (found, wanted) in found.iter().zip(&wanted) {
                    assert!((found.distance - wanted.distance).abs() < 1e-3, "{found:?} {wanted:?}");
                    others += usize::from(found.index != wanted.index);
                }
                assert!(
                    others * 100 <= found.len(),
                    "{others} other ones, {asked} of {count}, {lists} lists"
                );
            }
        }
    }

    #[test]
    fn what_is_kept_is_near_what_was_given() {
        let points = clustered(5000, 3);
        let index = InvertedIndex::new(&points, DIMENSION);
        let steps = index.codebook().steps();
        let rows = kept(&index).into_iter().zip(&points).enumerate();
        let off =
            rows.filter(|(at, (kept, given))| (kept - *given).abs() > 0.04 * steps[at % DIMENSION]).count();
        // beyond the largest of the sample
        assert!(off < 100, "{off} of {} coordinates", points.len());
    }

    #[test]
    fn few_lists_hold_nearly_all_of_the_nearest() {
        let (points, queries) = (clustered(20_000, 5), clustered(200, 6));
        let exact = EigenpointIndex::new(points.clone(), DIMENSION).nearest_several(&queries, 31);
        let index = InvertedIndex::new(&points, DIMENSION);
        assert_eq!(index.lists(), 566);
        let found = index.nearest_several(&queries, 31);
        let rows = found.chunks_exact(31).zip(exact.chunks_exact(31));
        let (mut first, mut all) = (0, 0);
        for (found, exact) in rows {
            first += usize::from(found[0].index == exact[0].index);
            all +=
                exact.iter().filter(|wanted| found.iter().any(|found| found.index == wanted.index)).count();
            assert!(found.is_sorted_by(|a, b| (a.distance, a.index) < (b.distance, b.index)));
        }
        assert!(first >= 190, "{first} of 200");
        assert!(all >= 5500, "{all} of 6200");
    }

    #[test]
    fn many_identical_eigenpoints_are_found_by_index() {
        let mut points = [0.25_f32].repeat(10_000 * DIMENSION);
        points.extend([0.5_f32].repeat(DIMENSION));
        let queries = [[0.3_f32].repeat(DIMENSION), [0.6_f32].repeat(DIMENSION)].concat();
        let index = InvertedIndex::new(&points, DIMENSION);
        let found: Vec<usize> = index.nearest_several(&queries, 40).iter().map(|found| found.index).collect();
        assert_eq!(found[..40], (0..40).collect::<Vec<_>>());
        assert_eq!((found[40], found[41]), (10_000, 0));
    }

    #[test]
    fn a_query_is_filled_from_further_lists() {
        let points = clustered(5000, 7);
        let index = InvertedIndex::with_lists(&points, DIMENSION, 500);
        let found = index.nearest_several_probing(&points[..3 * DIMENSION], 300, 1);
        assert_eq!(found.len(), 900);
        for (number, row) in found.chunks_exact(300).enumerate() {
            assert_eq!(row[0].index, number);
            assert!(row[0].distance < 0.05, "{}", row[0].distance);
            let distinct: std::collections::HashSet<usize> = row.iter().map(|n| n.index).collect();
            assert_eq!(distinct.len(), 300);
        }
    }

    #[test]
    fn fewer_eigenpoints_than_asked_are_all_found() {
        let index = InvertedIndex::new(&[0.0, 0.0, 30.0, 40.0], 2);
        let found = index.nearest_several(&[3.0, 4.0], 9);
        assert_eq!(found.len(), 2);
        for (found, (index, distance)) in found.iter().zip([(0, 5.0), (1, 45.0)]) {
            assert_eq!(found.index, index);
            assert!((found.distance - distance).abs() < 0.02, "{found:?}");
        }
        assert!(index.nearest_several(&[], 9).is_empty());
    }

    #[test]
    fn an_index_repeats_and_its_codes_make_it_anew() {
        let (points, queries) = (clustered(6000, 8), clustered(8, 9));
        let build = || InvertedIndex::new(&points, DIMENSION);
        let (a, b) = (build(), build());
        assert_eq!(a.codes(), b.codes());
        let codebook = a.codebook();
        let again = Codebook::of_parts(codebook.centroids().to_vec(), codebook.steps().to_vec()).unwrap();
        let again = InvertedIndex::of_codes(Arc::new(again), &a.codes(), Code::length(DIMENSION));
        assert_eq!(again.nearest_several(&queries, 31), a.nearest_several(&queries, 31));
        assert_eq!(kept(&again), kept(&a));
        assert_eq!(again.codes(), a.codes());
    }
}
