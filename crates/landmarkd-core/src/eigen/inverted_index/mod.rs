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

pub use blocks::BLOCK;
use blocks::{Blocks, BlocksBuilder};
use candidates::Candidates;
pub use codebook::{Codebook, Codes, fine_length};
use queries::{Tiles, WholeQueries};

use pulp::{Arch, Simd, WithSimd};

use super::neighbours::{Neighbour, dot};
use crate::column::Column;

/// Below this many eigenpoints all lists are probed.
const EXACT_BELOW: usize = 4096;
/// Eigenpoints of a list, where all lists are probed.
const SHORT_LIST: usize = 64;
/// Lists that a query probes.
const PROBES: usize = 64;
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

/// A set of eigenpoints in lists, segment by segment.
#[derive(Clone)]
pub struct InvertedIndex {
    codebook: Arc<Codebook>,
    segments: Vec<Segment>,
}

/// Eigenpoints that were added together, in lists.
#[derive(Clone)]
pub struct Segment {
    /// How many there are.
    count: usize,
    /// The blocks of each list: from one number to the next. One more than there are lists.
    starts: Column<u32>,
    blocks: Blocks<i8>,
    /// Place by place what the codes leave.
    fine: Column<u8>,
}

/// A segment as it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentColumns {
    /// Lists + 1: where the blocks of each list start.
    pub starts: Column<u32>,
    /// Blocks × pairs of coordinates × [`BLOCK`] × 2.
    pub codes: Column<i8>,
    /// Blocks × [`BLOCK`] × [`fine_length`]: what the codes leave.
    pub fine: Column<u8>,
    /// Blocks × [`BLOCK`]: ‖t‖² of each eigenpoint by its code, infinite where none is.
    pub squares: Column<f32>,
    /// Blocks × [`BLOCK`]: which of the segment's eigenpoints it is, u32::MAX where none is.
    pub indices: Column<u32>,
}

impl Segment {
    /// The eigenpoints of codes, list by list.
    ///
    /// # Panics
    /// If they are not of that codebook, or more than a u32 counts.
    pub fn new(codebook: &Codebook, codes: &Codes) -> Segment {
        let (count, lists, dimension) = (codes.lists.len(), codebook.lists(), codebook.dimension());
        assert!(count < u32::MAX as usize && codes.codes.len() == count * dimension, "codes of the codebook");
        let mut sizes = vec![0_usize; lists];
        codes.lists.iter().for_each(|&list| sizes[list as usize] += 1);
        let mut starts = vec![0_u32];
        sizes.iter().for_each(|size| starts.push(starts[starts.len() - 1] + size.div_ceil(BLOCK) as u32));
        let mut blocks = BlocksBuilder::new(starts[lists] as usize, dimension);
        let mut next: Vec<usize> = starts[..lists].iter().map(|&block| block as usize * BLOCK).collect();
        let length = fine_length(dimension);
        let mut fine = vec![0; starts[lists] as usize * BLOCK * length];
        for (index, (code, &list)) in codes.codes.chunks_exact(dimension).zip(&codes.lists).enumerate() {
            let list = list as usize;
            let square: f32 = codebook.decoded(list, code).map(|v| v * v).sum();
            blocks.put(next[list], index as u32, code, square);
            fine[next[list] * length..][..length].copy_from_slice(&codes.fine[index * length..][..length]);
            next[list] += 1;
        }
        Segment { count, starts: starts.into(), blocks: blocks.build(), fine: fine.into() }
    }

    /// A segment as it was kept; `None` if its columns are not those of one of that codebook.
    pub fn of_columns(codebook: &Codebook, columns: SegmentColumns) -> Option<Segment> {
        let SegmentColumns { starts, codes, fine, squares, indices } = columns;
        let blocks = Blocks::of_columns(codebook.dimension(), codes, squares, indices)?;
        let is_whole = starts.len() == codebook.lists() + 1
            && starts.first() == Some(&0)
            && starts.is_sorted()
            && starts.last().is_some_and(|&end| end as usize == blocks.count())
            && fine.len() == blocks.count() * BLOCK * fine_length(codebook.dimension());
        if !is_whole {
            return None;
        }
        let (_, squares, indices) = blocks.columns();
        let held: Vec<u32> = indices.iter().copied().filter(|&index| index != blocks::EMPTY).collect();
        let mut seen = vec![false; held.len()];
        for &index in &held {
            // each once
            if std::mem::replace(seen.get_mut(index as usize)?, true) {
                return None;
            }
        }
        let is_sound =
            |(square, &index): (&f32, &u32)| (index == blocks::EMPTY) == (*square == f32::INFINITY);
        let sound = squares.iter().zip(indices.iter()).all(is_sound) && squares.iter().all(|s| *s >= 0.0);
        sound.then(|| Segment { count: held.len(), starts, blocks, fine })
    }

    /// What it is kept as.
    pub fn columns(&self) -> SegmentColumns {
        let (codes, squares, indices) = self.blocks.columns();
        SegmentColumns {
            starts: self.starts.clone(),
            codes: codes.clone(),
            fine: self.fine.clone(),
            squares: squares.clone(),
            indices: indices.clone(),
        }
    }

    /// How many eigenpoints there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Memory that it takes, in bytes.
    pub fn bytes(&self) -> usize {
        self.starts.bytes() + self.blocks.bytes() + self.fine.bytes()
    }

    /// The lists and codes of its eigenpoints, in their order.
    pub fn codes(&self, dimension: usize) -> Codes {
        let pairs = fine_length(dimension);
        let mut codes = Codes {
            lists: vec![0; self.count],
            codes: vec![0; self.count * dimension],
            fine: vec![0; self.count * pairs],
        };
        let (numbers, _, indices) = self.blocks.columns();
        let rows = numbers.as_chunks::<2>().0.as_chunks::<BLOCK>().0;
        for (list, blocks) in self.starts.windows(2).enumerate() {
            for place in blocks[0] as usize * BLOCK..blocks[1] as usize * BLOCK {
                let index = indices[place] as usize;
                if indices[place] == blocks::EMPTY {
                    continue;
                }
                codes.lists[index] = list as u32;
                let code = codes.codes[index * dimension..][..dimension].chunks_mut(2);
                for (code, row) in code.zip(&rows[place / BLOCK * pairs..]) {
                    code.copy_from_slice(&row[place % BLOCK][..code.len()]);
                }
                codes.fine[index * pairs..][..pairs].copy_from_slice(&self.fine[place * pairs..][..pairs]);
            }
        }
        codes
    }

    /// Places for eigenpoints, taken or not.
    fn places(&self) -> usize {
        self.blocks.count() * BLOCK
    }

    /// Writes the eigenpoint of a place as it is kept, and returns its index.
    #[inline(always)]
    fn decode(&self, codebook: &Codebook, place: usize, point: &mut [f32]) -> u32 {
        let (codes, _, indices) = self.blocks.columns();
        let list = self.starts.partition_point(|&start| start as usize <= place / BLOCK) - 1;
        let pairs = fine_length(codebook.dimension());
        let block = codes.as_chunks::<2>().0.as_chunks::<BLOCK>().0;
        let code = block[place / BLOCK * pairs..][..pairs].iter().map(|row| &row[place % BLOCK]);
        codebook.decode_finely(list, code, &self.fine[place * pairs..][..pairs], point);
        indices[place]
    }
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
        let mut codes = Codes::default();
        codebook.encode(points, &mut codes);
        let segment = Segment::new(&codebook, &codes);
        InvertedIndex { codebook: Arc::new(codebook), segments: vec![segment] }
    }

    /// The index of segments of one codebook; their eigenpoints are numbered on from one to the next.
    ///
    /// # Panics
    /// If there are more than a u32 counts.
    pub fn of_segments(codebook: Arc<Codebook>, segments: Vec<Segment>) -> InvertedIndex {
        let index = InvertedIndex { codebook, segments };
        assert!(index.count() < u32::MAX as usize, "eigenpoints are numbered by u32");
        index
    }

    /// The centroids and steps.
    pub fn codebook(&self) -> &Arc<Codebook> {
        &self.codebook
    }

    /// The segments, in their order.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// How many eigenpoints there are.
    pub fn count(&self) -> usize {
        self.segments.iter().map(Segment::count).sum()
    }

    /// How many lists there are.
    pub fn lists(&self) -> usize {
        self.codebook.lists()
    }

    /// Memory that it takes, in bytes: of each eigenpoint a byte and a half a coordinate, 8 more, and a little.
    pub fn bytes(&self) -> usize {
        self.codebook.bytes() + self.segments.iter().map(Segment::bytes).sum::<usize>()
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
        let probes = if self.count() < EXACT_BELOW { self.lists() } else { PROBES };
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
        blocks.scan(0..blocks.count(), 0, &tiles, &mut nearest);
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
            let mut first = 0;
            for segment in &self.segments {
                let blocks = segment.starts[list] as usize..segment.starts[list + 1] as usize;
                segment.blocks.scan(blocks, first, tiles, candidates);
                first += segment.places();
            }
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
            let (mut place, mut before) = (place as usize, 0);
            for segment in &self.index.segments {
                if place < segment.places() {
                    let index = segment.decode(&self.index.codebook, place, self.point);
                    let square = square_distance(self.query, self.point);
                    self.measured.push((square, before + index as usize));
                    break;
                }
                place -= segment.places();
                before += segment.count;
            }
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
        let segment = &index.segments()[0];
        let mut points = vec![vec![]; segment.count()];
        for place in 0..segment.places() {
            let mut point = vec![0.0; DIMENSION];
            let index = segment.decode(index.codebook(), place, &mut point);
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
    fn an_index_repeats_and_its_columns_make_it_anew() {
        let (points, queries) = (clustered(6000, 8), clustered(8, 9));
        let build = || InvertedIndex::new(&points, DIMENSION);
        let (a, b) = (build(), build());
        assert_eq!(a.segments()[0].columns(), b.segments()[0].columns());
        let again = rebuilt(&a, |_| ()).unwrap();
        assert_eq!(again.nearest_several(&queries, 31), a.nearest_several(&queries, 31));
        assert_eq!(kept(&again), kept(&a));
        let codes = a.segments()[0].codes(DIMENSION);
        assert_eq!(Segment::new(a.codebook(), &codes).columns(), a.segments()[0].columns());
        let damages: [fn(&mut SegmentColumns); 8] = [
            |c| c.fine = c.fine[1..].to_vec().into(),
            |c| c.starts = c.starts[1..].to_vec().into(),
            |c| c.starts = c.starts.iter().rev().copied().collect::<Vec<_>>().into(),
            |c| c.codes = c.codes[2..].to_vec().into(),
            |c| c.squares = c.squares[BLOCK..].to_vec().into(),
            |c| c.squares = vec![f32::NAN; c.squares.len()].into(),
            |c| c.squares = vec![1.0; c.squares.len()].into(),
            |c| c.indices = c.indices.iter().map(|index| index / 2).collect::<Vec<_>>().into(),
        ];
        for (number, damage) in damages.into_iter().enumerate() {
            assert!(rebuilt(&a, damage).is_none(), "damage {number} went through");
        }
    }

    fn rebuilt(index: &InvertedIndex, change: impl Fn(&mut SegmentColumns)) -> Option<InvertedIndex> {
        let codebook = index.codebook();
        let kept = Codebook::of_parts(codebook.centroids().to_vec(), codebook.steps().to_vec())?;
        let mut columns = index.segments()[0].columns();
        change(&mut columns);
        let segment = Segment::of_columns(&kept, columns)?;
        Some(InvertedIndex::of_segments(Arc::new(kept), vec![segment]))
    }

    #[test]
    fn segments_answer_as_one() {
        let (points, queries) = (clustered(9000, 5), clustered(50, 6));
        let whole = InvertedIndex::new(&points, DIMENSION);
        let codebook = whole.codebook();
        let segments = points.chunks(4000 * DIMENSION).map(|points| {
            let mut codes = Codes::default();
            codebook.encode(points, &mut codes);
            Segment::new(codebook, &codes)
        });
        let parted = InvertedIndex::of_segments(Arc::clone(codebook), segments.collect());
        assert_eq!((parted.segments().len(), parted.count()), (3, 9000));
        assert_eq!(parted.nearest_several(&queries, 31), whole.nearest_several(&queries, 31));
    }
}
