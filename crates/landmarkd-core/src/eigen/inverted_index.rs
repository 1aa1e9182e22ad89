//! The several nearest of many eigenpoints, nearly always: an inverted index (Sivic and Zisserman 2003; Jégou, Douze and
//! Schmid 2011, without their codes).
//!
//! k-means on a seeded sample gives centroids. Each eigenpoint is in the list of its nearest centroid, and a query looks
//! through the lists of the centroids nearest to it. A list is read once for all queries that probe it.
//!
//! Of ‖q − t‖² = ‖q‖² + (‖t‖² − 2 q·t), B(14), the part in brackets is computed for all eigenpoints of a list with
//! coordinates of 16 bits: twice as fast as with f32, and whole numbers add up to the same on every machine. Given a bound
//! on its rounding, it excludes the eigenpoints that can't be among the nearest; the few that can are measured in f64. So
//! the answer is that of
//! [`EigenpointIndex::nearest_several`](super::EigenpointIndex::nearest_several), bit for bit, among the lists probed.

use std::cmp::Ordering;
use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::neighbours::{Neighbour, distance_square, dot};
use crate::random::Random;

/// Sums that are one vector of AVX2.
const LANES: usize = 8;
/// Eigenpoints that are side by side: two vectors of sums.
const BLOCK: usize = 2 * LANES;
/// Queries that pass over a block together: their sums and the block's eigenpoints fill AVX2's registers.
const TILE: usize = 4;
/// The length of the longest vector in whole numbers: that of a product of two stays below 2³¹, rounded ones too.
const LONGEST: f32 = 32_000.0;
/// Below this many eigenpoints there is one list, and the search exact: what centroids and their lists cost beside
/// the eigenpoints is more than they save.
const ONE_LIST_BELOW: usize = 4096;
/// Eigenpoints for each list to learn its centroid from, and rounds of k-means.
const SAMPLE_PER_LIST: usize = 32;
const ROUNDS: usize = 6;
/// Lists that a query probes.
///
/// Of the nearest, the 6 and the 31 nearest of 4000 windows of photographed paintings, among 43 thousand eigenpoints of
/// 48 coordinates in 207 lists, there are found: 0.948, 0.931, 0.896 by 8 probes; 0.975, 0.970, 0.950 by 12; 0.988,
/// 0.985, 0.975 by 16; 0.997, 0.996, 0.993 by 24. With 12 one decision in twenty of a corridor is lost.
const PROBES: usize = 24;
/// Of them, those that are probed before all others.
const FIRST_PROBES: usize = 3;
/// Eigenpoints whose lists are sought together: they stay in the first cache.
const TOGETHER: usize = 64;
/// Candidates of a query are reduced to the nearest when they are so many.
const LEAST_CAPACITY: usize = 48;
/// The index of a place of a block that holds no eigenpoint.
const EMPTY: u32 = u32::MAX;

/// A set of eigenpoints in lists.
pub struct InvertedIndex {
    points: Vec<f32>,
    dimension: usize,
    /// The greatest ‖t‖.
    farthest: f32,
    centroids: Blocks,
    lists: Blocks,
    /// The blocks of each list: from one number to the next. One more than there are lists.
    starts: Vec<usize>,
    /// Eigenpoints of each list.
    sizes: Vec<usize>,
}

impl InvertedIndex {
    /// An index over n × `dimension` row-major eigenpoints, all finite; of some √n lists, or of one if there are few
    /// eigenpoints.
    ///
    /// # Panics
    /// If there is no eigenpoint, not a whole number of them, or more than a u32 counts.
    pub fn new(points: Vec<f32>, dimension: usize) -> InvertedIndex {
        let count = points.len() / dimension.max(1);
        let lists = if count < ONE_LIST_BELOW { 1 } else { (count as f64).sqrt().round() as usize };
        InvertedIndex::with_lists(points, dimension, lists)
    }

    /// An index of at most `lists` lists; of as many as there are eigenpoints if those are fewer.
    ///
    /// # Panics
    /// As [`InvertedIndex::new`], or if `lists` is 0.
    pub fn with_lists(points: Vec<f32>, dimension: usize, lists: usize) -> InvertedIndex {
        assert!(dimension > 0 && !points.is_empty(), "an index holds an eigenpoint");
        assert!(points.len().is_multiple_of(dimension), "whole eigenpoints");
        let count = points.len() / dimension;
        assert!(count < EMPTY as usize, "eigenpoints are numbered by u32");
        assert!(lists > 0, "an eigenpoint is in a list");
        let lists = lists.min(count);
        let centroids = centroids(&points, dimension, lists);
        let of_point = nearest_blocks(&centroids, &points, dimension);
        let mut sizes = vec![0; lists];
        of_point.iter().for_each(|&list| sizes[list as usize] += 1);
        let mut starts = vec![0];
        sizes.iter().for_each(|size: &usize| starts.push(starts[starts.len() - 1] + size.div_ceil(BLOCK)));
        let farthest = farthest(&points, dimension);
        let mut blocks = Blocks::empty(starts[lists], dimension, farthest);
        let mut next: Vec<usize> = starts[..lists].iter().map(|block| block * BLOCK).collect();
        for (index, (point, &list)) in points.chunks_exact(dimension).zip(&of_point).enumerate() {
            let place = &mut next[list as usize];
            blocks.put(*place, index as u32, point);
            *place += 1;
        }
        InvertedIndex { points, dimension, farthest, centroids, lists: blocks, starts, sizes }
    }

    /// The eigenpoints, n × dimension, row-major, in the order that they were given in.
    pub fn points(&self) -> &[f32] {
        &self.points
    }

    /// How many eigenpoints there are.
    pub fn count(&self) -> usize {
        self.points.len() / self.dimension
    }

    /// How many lists there are.
    pub fn lists(&self) -> usize {
        self.sizes.len()
    }

    /// Memory held, in bytes: half as much again as the eigenpoints, and a little more.
    pub fn bytes(&self) -> usize {
        let whole = size_of_val(&self.starts[..]) + size_of_val(&self.sizes[..]);
        size_of_val(&self.points[..]) + self.centroids.bytes() + self.lists.bytes() + whole
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
        self.nearest_several_probing(queries, count, PROBES)
    }

    /// As [`InvertedIndex::nearest_several`], probing `probes` lists, more where those hold fewer than `count`; exact
    /// if these are all.
    ///
    /// # Panics
    /// As [`InvertedIndex::nearest_several`], or if `probes` is 0.
    pub fn nearest_several_probing(&self, queries: &[f32], count: usize, probes: usize) -> Vec<Neighbour> {
        assert!(queries.len().is_multiple_of(self.dimension), "whole queries");
        assert!(count > 0 && probes > 0, "a query asks for something, somewhere");
        let (asked, count) = (queries.len() / self.dimension, count.min(self.count()));
        let slack = |query: &[f32]| {
            let length = dot(query, query).sqrt() as f32;
            // Each coordinate of either vector is off by half a unit at most, the whole vector by half of √n units; a
            // unit is the vector's length, or the farthest's, over LONGEST. One percent more for products of both errors.
            let whole = 2.02 * (self.dimension as f32).sqrt() * length * self.farthest / LONGEST;
            // the square, the conversion, the product and the sum in f32
            whole + 8.0 * f32::EPSILON * (length + self.farthest).powi(2) + f32::MIN_POSITIVE
        };
        let nearest = |query: &[f32]| Nearest::new(count, 2.0 * slack(query));
        let mut nearest: Vec<Nearest> = queries.chunks_exact(self.dimension).map(nearest).collect();
        let mut scratch = Tiles::default();
        let whole = WholeQueries::new(queries, self.dimension);
        for round in self.rounds(&whole, count, probes) {
            for list in 0..self.lists() {
                let blocks = self.starts[list]..self.starts[list + 1];
                self.lists.scan(blocks, &whole, round.asking(list), &mut nearest, &mut scratch);
            }
        }
        let mut found = vec![Neighbour { index: 0, distance: 0.0 }; asked * count];
        let mut squares = Vec::new();
        for (number, found) in found.chunks_exact_mut(count).enumerate() {
            let candidates = nearest[number].reduced();
            let query = &queries[number * self.dimension..][..self.dimension];
            Arch::new().dispatch(Measure { points: &self.points, query, candidates, squares: &mut squares });
            squares.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (found, &(square, index)) in found.iter_mut().zip(&squares) {
                *found = Neighbour { index: index as usize, distance: square.sqrt() as f32 };
            }
        }
        found
    }

    /// Which queries probe which lists: first each its nearest ones, so that it knows how near its nearest are at most;
    /// then the others.
    fn rounds(&self, queries: &WholeQueries, count: usize, probes: usize) -> [Round; 2] {
        let (asked, lists) = (queries.units.len(), self.lists());
        let all: Vec<u32> = (0..asked as u32).collect();
        let whole = 0..self.centroids.squares.len();
        let mut nearest: Vec<Nearest> = (0..asked).map(|_| Nearest::new(probes.min(lists), 0.0)).collect();
        let mut scratch = Tiles::default();
        self.centroids.scan(whole.clone(), queries, &all, &mut nearest, &mut scratch);
        let mut visits = [(); 2].map(|()| Vec::with_capacity(asked * probes.min(lists)));
        for (number, nearest) in nearest.iter_mut().enumerate() {
            let mut held = 0;
            let mut probed = 0;
            let mut probe = |list: usize| {
                visits[usize::from(probed >= FIRST_PROBES)].push((list, number as u32));
                held += self.sizes[list];
                probed += 1;
                probed >= probes && held >= count
            };
            let is_enough = nearest.in_order(probes).fold(false, |_, list| probe(list));
            if !is_enough && probes < lists {
                let mut every = [Nearest::new(lists, 0.0)];
                self.centroids.scan(whole.clone(), &queries.only(number), &[0], &mut every, &mut scratch);
                every[0].in_order(lists).skip(probes).find(|&list| probe(list));
            }
        }
        visits.map(|visits| Round::new(&visits, lists))
    }
}

/// The queries that probe each list.
struct Round {
    /// Of each list, where its queries start; one more than there are lists.
    starts: Vec<usize>,
    queries: Vec<u32>,
}

impl Round {
    /// From pairs of list and query; those of a list keep their order.
    fn new(visits: &[(usize, u32)], lists: usize) -> Round {
        let mut starts = vec![0; lists + 1];
        visits.iter().for_each(|visit| starts[visit.0 + 1] += 1);
        (0..lists).for_each(|list| starts[list + 1] += starts[list]);
        let mut next = starts.clone();
        let mut queries = vec![0; visits.len()];
        for &(list, query) in visits {
            queries[next[list]] = query;
            next[list] += 1;
        }
        Round { starts, queries }
    }

    fn asking(&self, list: usize) -> &[u32] {
        &self.queries[self.starts[list]..self.starts[list + 1]]
    }
}

/// The squared distances of candidates, in f64.
struct Measure<'a> {
    points: &'a [f32],
    query: &'a [f32],
    candidates: &'a [u64],
    /// (‖q − t‖², index).
    squares: &'a mut Vec<(f64, u32)>,
}

impl WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.squares.clear();
        let dimension = self.query.len();
        for at in 0..self.candidates.len() {
            let index = index_of(self.candidates[at]);
            let point = &self.points[index as usize * dimension..][..dimension];
            self.squares.push((distance_square(self.query, point), index));
        }
    }
}

/// The greatest length of n × dimension row-major points.
fn farthest(points: &[f32], dimension: usize) -> f32 {
    points.chunks_exact(dimension).map(|point| dot(point, point) as f32).fold(0.0, f32::max).sqrt()
}

/// The unit of a vector's whole numbers, given the greatest length.
fn unit(longest: f32) -> f32 {
    if longest > 0.0 { longest / LONGEST } else { 1.0 }
}

/// Coordinates in whole numbers, by pairs; 0 after the last.
fn whole(coordinates: &[f32], unit: f32) -> impl Iterator<Item = [i16; 2]> {
    // adding so much leaves f32 no place for a fraction
    const NO_FRACTION: f32 = (3 << 22) as f32;
    let whole = move |value: f32| ((value / unit + NO_FRACTION) - NO_FRACTION) as i16;
    let (pairs, last) = coordinates.as_chunks::<2>();
    let last = last.first().map(|&value| [whole(value), 0]);
    pairs.iter().map(move |&[a, b]| [whole(a), whole(b)]).chain(last)
}

/// Queries in whole numbers, each with a unit of its own.
struct WholeQueries {
    pairs: usize,
    rows: Vec<[i16; 2]>,
    units: Vec<f32>,
}

impl WholeQueries {
    fn new(queries: &[f32], dimension: usize) -> WholeQueries {
        let pairs = dimension.div_ceil(2);
        let mut rows = Vec::with_capacity(queries.len() / dimension * pairs);
        let mut units = Vec::with_capacity(queries.len() / dimension);
        for query in queries.chunks_exact(dimension) {
            let unit = unit(dot(query, query).sqrt() as f32);
            rows.extend(whole(query, unit));
            units.push(unit);
        }
        WholeQueries { pairs, rows, units }
    }

    /// One of them by itself.
    fn only(&self, number: usize) -> WholeQueries {
        let rows = self.row(number as u32).to_vec();
        WholeQueries { pairs: self.pairs, rows, units: vec![self.units[number]] }
    }

    fn row(&self, number: u32) -> &[[i16; 2]] {
        &self.rows[number as usize * self.pairs..][..self.pairs]
    }
}

/// Points side by side, two coordinates at a time.
struct Blocks {
    dimension: usize,
    /// What 1 is worth in rows.
    unit: f32,
    /// For each pair of coordinates of each block a row of [`BLOCK`] pairs.
    rows: Vec<[[i16; 2]; BLOCK]>,
    /// ‖t‖², infinite where no point is.
    squares: Vec<[f32; BLOCK]>,
    /// Which point it is.
    indices: Vec<[u32; BLOCK]>,
}

impl Blocks {
    /// For points of at most that length.
    fn empty(blocks: usize, dimension: usize, farthest: f32) -> Blocks {
        Blocks {
            dimension,
            unit: unit(farthest),
            rows: vec![[[0; 2]; BLOCK]; blocks * dimension.div_ceil(2)],
            squares: vec![[f32::INFINITY; BLOCK]; blocks],
            indices: vec![[EMPTY; BLOCK]; blocks],
        }
    }

    fn of(points: &[f32], dimension: usize) -> Blocks {
        let count = points.len() / dimension;
        let mut blocks = Blocks::empty(count.div_ceil(BLOCK), dimension, farthest(points, dimension));
        for (index, point) in points.chunks_exact(dimension).enumerate() {
            blocks.put(index, index as u32, point);
        }
        blocks
    }

    fn put(&mut self, place: usize, index: u32, point: &[f32]) {
        let (block, lane) = (place / BLOCK, place % BLOCK);
        let pairs = self.pairs();
        for (row, pair) in self.rows[block * pairs..][..pairs].iter_mut().zip(whole(point, self.unit)) {
            row[lane] = pair;
        }
        self.squares[block][lane] = dot(point, point) as f32;
        self.indices[block][lane] = index;
    }

    /// Pairs of coordinates of a point.
    fn pairs(&self) -> usize {
        self.dimension.div_ceil(2)
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.rows[..]) + size_of_val(&self.squares[..]) + size_of_val(&self.indices[..])
    }

    /// Shows a range of blocks to the numbered queries.
    fn scan(
        &self,
        blocks: Range<usize>,
        queries: &WholeQueries,
        asking: &[u32],
        nearest: &mut [Nearest],
        scratch: &mut Tiles,
    ) {
        if !asking.is_empty() && !blocks.is_empty() {
            scratch.fill(queries, self, asking);
            dispatch(Scan { of: self, blocks, tiles: scratch, asking, nearest });
        }
    }
}

/// Queries by fours, two coordinates at a time.
#[derive(Default)]
struct Tiles {
    /// For each pair of coordinates of each tile.
    rows: Vec<[[i16; 2]; TILE]>,
    /// −2 times what a product of 1 and 1 is worth.
    factors: Vec<[f32; TILE]>,
}

impl Tiles {
    /// Replaces what it holds by the numbered queries of some blocks.
    fn fill(&mut self, queries: &WholeQueries, of: &Blocks, asking: &[u32]) {
        let pairs = of.pairs();
        let tiles = asking.len().div_ceil(TILE);
        self.rows.clear();
        self.rows.resize(tiles * pairs, [[0; 2]; TILE]);
        self.factors.clear();
        self.factors.resize(tiles, [0.0; TILE]);
        for (place, &number) in asking.iter().enumerate() {
            let (tile, lane) = (place / TILE, place % TILE);
            self.factors[tile][lane] = -2.0 * queries.units[number as usize] * of.unit;
            for (row, pair) in self.rows[tile * pairs..][..pairs].iter_mut().zip(queries.row(number)) {
                row[lane] = *pair;
            }
        }
    }
}

/// What products of whole numbers are added up with: processors have an instruction for it.
trait Products: Copy {
    type Sums: Copy;
    fn zero(self) -> Self::Sums;
    /// Adds the product of each pair of the row with `pair`.
    fn add(self, sums: Self::Sums, row: &[[i16; 2]; LANES], pair: [i16; 2]) -> Self::Sums;
    fn sums(self, sums: Self::Sums) -> [i32; LANES];
}

#[derive(Clone, Copy)]
struct Plain;

impl Products for Plain {
    type Sums = [i32; LANES];

    #[inline(always)]
    fn zero(self) -> Self::Sums {
        [0; LANES]
    }

    #[inline(always)]
    fn add(self, mut sums: Self::Sums, row: &[[i16; 2]; LANES], pair: [i16; 2]) -> Self::Sums {
        for lane in 0..LANES {
            let product = |at: usize| i32::from(row[lane][at]) * i32::from(pair[at]);
            sums[lane] += product(0) + product(1);
        }
        sums
    }

    #[inline(always)]
    fn sums(self, sums: Self::Sums) -> [i32; LANES] {
        sums
    }
}

#[cfg(target_arch = "x86_64")]
impl Products for pulp::x86::V3 {
    type Sums = pulp::i32x8;

    #[inline(always)]
    fn zero(self) -> Self::Sums {
        self.splat_i32x8(0)
    }

    #[inline(always)]
    fn add(self, sums: Self::Sums, row: &[[i16; 2]; LANES], pair: [i16; 2]) -> Self::Sums {
        let pair = self.splat_i32x8(pulp::cast(pair));
        self.wrapping_add_i32x8(
            sums,
            self.multiply_wrapping_add_adjacent_i16x16(pulp::cast(*row), pulp::cast(pair)),
        )
    }

    #[inline(always)]
    fn sums(self, sums: Self::Sums) -> [i32; LANES] {
        pulp::cast(sums)
    }
}

/// A loop over blocks.
trait Pass {
    fn run<S: Simd, P: Products>(self, simd: S, products: P);
}

/// A pass with the instructions of this processor.
fn dispatch(pass: impl Pass) {
    struct With<T, P>(T, P);
    impl<T: Pass, P: Products> WithSimd for With<T, P> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.run(simd, self.1);
        }
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(v3) = pulp::x86::V3::try_new() {
        return Simd::vectorize(v3, With(pass, v3));
    }
    Arch::new().dispatch(With(pass, Plain));
}

/// ‖t‖² − 2 q·t of a block's points and a tile's queries. // B(14)
#[inline(always)]
fn parts<P: Products>(
    products: P,
    rows: &[[[i16; 2]; BLOCK]],
    squares: &[f32; BLOCK],
    tile: &[[[i16; 2]; TILE]],
    factors: &[f32; TILE],
    parts: &mut [[f32; BLOCK]; TILE],
) {
    let mut sums = [[products.zero(); 2]; TILE];
    for (row, queries) in rows.iter().zip(tile) {
        let (first, second) = row.split_at(LANES);
        let (Some(first), Some(second)) = (first.first_chunk(), second.first_chunk()) else { continue };
        for lane in 0..TILE {
            sums[lane][0] = products.add(sums[lane][0], first, queries[lane]);
            sums[lane][1] = products.add(sums[lane][1], second, queries[lane]);
        }
    }
    for lane in 0..TILE {
        for half in 0..2 {
            let sums = products.sums(sums[lane][half]);
            let places = half * LANES..(half + 1) * LANES;
            let out = parts[lane][places.clone()].iter_mut().zip(&squares[places]).zip(sums);
            for ((part, square), sum) in out {
                *part = square + factors[lane] * sum as f32;
            }
        }
    }
}

/// Whether one of the parts is not above the limit.
#[inline(always)]
fn passes<S: Simd>(simd: S, parts: &[f32; BLOCK], limit: f32) -> bool {
    let (parts, limit) = (S::as_simd_f32s(parts).0, simd.splat_f32s(limit));
    let mut passes = false;
    for part in parts {
        let within = simd.not_m32s(simd.less_than_f32s(limit, *part));
        passes |= simd.first_true_m32s(within) < S::F32_LANES;
    }
    passes
}

/// Looks through blocks for points nearer than a query's nearest so far.
struct Scan<'a> {
    of: &'a Blocks,
    blocks: Range<usize>,
    tiles: &'a Tiles,
    asking: &'a [u32],
    nearest: &'a mut [Nearest],
}

impl Pass for Scan<'_> {
    #[inline(always)]
    fn run<S: Simd, P: Products>(self, simd: S, products: P) {
        let pairs = self.of.pairs();
        let mut out = [[0.0; BLOCK]; TILE];
        for block in self.blocks {
            let rows = &self.of.rows[block * pairs..][..pairs];
            let (squares, indices) = (&self.of.squares[block], &self.of.indices[block]);
            for tile in 0..self.asking.len().div_ceil(TILE) {
                let queries = &self.tiles.rows[tile * pairs..][..pairs];
                parts(products, rows, squares, queries, &self.tiles.factors[tile], &mut out);
                for (parts, &number) in out.iter().zip(&self.asking[tile * TILE..]) {
                    let nearest = &mut self.nearest[number as usize];
                    if passes(simd, parts, nearest.limit) {
                        nearest.add(parts, indices);
                    }
                }
            }
        }
    }
}

/// The candidates for the nearest of a query.
struct Nearest {
    count: usize,
    /// By how much a part may exceed the last of the nearest and still be one.
    slack: f32,
    /// What the part of a candidate can't exceed.
    limit: f32,
    capacity: usize,
    /// In no order; of meaning up to `held`, and with room for a block after the capacity.
    candidates: Vec<u64>,
    held: usize,
}

/// A number that is in the order of parts, then of indices.
#[inline(always)]
fn candidate(part: f32, index: u32) -> u64 {
    let bits = part.to_bits();
    let ordered = bits ^ (((bits as i32 >> 31) as u32) | 0x8000_0000);
    (u64::from(ordered) << 32) | u64::from(index)
}

fn index_of(candidate: u64) -> u32 {
    candidate as u32
}

fn part_of(candidate: u64) -> f32 {
    let ordered = (candidate >> 32) as u32;
    f32::from_bits(if ordered >> 31 == 1 { ordered ^ 0x8000_0000 } else { !ordered })
}

impl Nearest {
    fn new(count: usize, slack: f32) -> Nearest {
        let capacity = (2 * count + BLOCK).max(LEAST_CAPACITY);
        let candidates = vec![0; capacity + BLOCK];
        Nearest { count, slack, limit: f32::INFINITY, capacity, candidates, held: 0 }
    }

    /// Adds those of a block that are within the limit.
    fn add(&mut self, parts: &[f32; BLOCK], indices: &[u32; BLOCK]) {
        let room = self.candidates[self.held..].first_chunk_mut::<BLOCK>().expect("room for a block");
        let mut added = 0;
        for lane in 0..BLOCK {
            room[added % BLOCK] = candidate(parts[lane], indices[lane]);
            let is_within = !matches!(parts[lane].partial_cmp(&self.limit), Some(Ordering::Greater));
            added += usize::from(is_within && indices[lane] != EMPTY);
        }
        self.held += added;
        if self.held >= self.capacity {
            self.reduce();
            // of many equal ones none can go
            self.capacity = self.capacity.max(2 * self.held);
            self.candidates.resize(self.capacity + BLOCK, 0);
        }
    }

    /// Keeps those that can be among the nearest.
    fn reduce(&mut self) {
        if self.held > self.count {
            let held = &mut self.candidates[..self.held];
            let last = *held.select_nth_unstable(self.count - 1).1;
            self.limit = part_of(last) + self.slack;
            let limit = candidate(self.limit, EMPTY);
            let mut kept = self.count;
            for at in self.count..held.len() {
                if held[at] <= limit {
                    held[kept] = held[at];
                    kept += 1;
                }
            }
            self.held = kept;
        }
    }

    /// The candidates that can be among the nearest, in no order.
    fn reduced(&mut self) -> &mut [u64] {
        self.reduce();
        &mut self.candidates[..self.held]
    }

    /// The indices of at most `count`, of the smallest part first, of equal ones the lower index.
    fn in_order(&mut self, count: usize) -> impl Iterator<Item = usize> {
        let reduced = self.reduced();
        reduced.sort_unstable();
        reduced.iter().take(count).map(|&candidate| index_of(candidate) as usize)
    }
}

/// For each of n × dimension row-major points the nearest one of `blocks`, of equal ones the first.
fn nearest_blocks(blocks: &Blocks, points: &[f32], dimension: usize) -> Vec<u32> {
    let numbers: Vec<u32> = (0..(points.len() / dimension) as u32).collect();
    let mut found = vec![0; numbers.len()];
    let mut tiles = Tiles::default();
    let points = WholeQueries::new(points, dimension);
    for (numbers, found) in numbers.chunks(TOGETHER).zip(found.chunks_mut(TOGETHER)) {
        tiles.fill(&points, blocks, numbers);
        dispatch(NearestOne { of: blocks, tiles: &tiles, found });
    }
    found
}

struct NearestOne<'a> {
    of: &'a Blocks,
    tiles: &'a Tiles,
    found: &'a mut [u32],
}

impl Pass for NearestOne<'_> {
    #[inline(always)]
    fn run<S: Simd, P: Products>(self, simd: S, products: P) {
        let pairs = self.of.pairs();
        let mut out = [[0.0; BLOCK]; TILE];
        let mut least = [f32::INFINITY; TOGETHER];
        for block in 0..self.of.squares.len() {
            let rows = &self.of.rows[block * pairs..][..pairs];
            let (squares, indices) = (&self.of.squares[block], &self.of.indices[block]);
            for tile in 0..self.found.len().div_ceil(TILE) {
                let queries = &self.tiles.rows[tile * pairs..][..pairs];
                parts(products, rows, squares, queries, &self.tiles.factors[tile], &mut out);
                let points = least.iter_mut().zip(self.found.iter_mut()).skip(tile * TILE);
                for (parts, (least, found)) in out.iter().zip(points) {
                    if passes(simd, parts, *least) {
                        for (part, index) in parts.iter().zip(indices) {
                            if part < least {
                                (*least, *found) = (*part, *index);
                            }
                        }
                    }
                }
            }
        }
    }
}

/// k-means on a seeded sample.
fn centroids(points: &[f32], dimension: usize, lists: usize) -> Blocks {
    let count = points.len() / dimension;
    let wanted = (SAMPLE_PER_LIST * lists).min(count);
    let mut random = Random::new(0, 0x11f);
    // one of every stretch of the eigenpoints, in an order of chance
    let mut sample: Vec<usize> = (0..wanted)
        .map(|i| {
            let (from, to) = (i * count / wanted, (i + 1) * count / wanted);
            from + (random.uniform() * (to - from) as f64) as usize
        })
        .collect();
    for i in (1..sample.len()).rev() {
        sample.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
    let sample: Vec<f32> =
        sample.iter().flat_map(|&index| &points[index * dimension..][..dimension]).copied().collect();
    let mut means = sample[..lists * dimension].to_vec();
    if lists == 1 {
        return Blocks::of(&means, dimension);
    }
    for _ in 0..ROUNDS {
        let of_point = nearest_blocks(&Blocks::of(&means, dimension), &sample, dimension);
        let mut sums = vec![0.0_f64; means.len()];
        let mut sizes = vec![0_u32; lists];
        for (point, &list) in sample.chunks_exact(dimension).zip(&of_point) {
            let sum = &mut sums[list as usize * dimension..][..dimension];
            sum.iter_mut().zip(point).for_each(|(sum, value)| *sum += f64::from(*value));
            sizes[list as usize] += 1;
        }
        let rows = means.chunks_exact_mut(dimension).zip(sums.chunks_exact(dimension));
        for ((mean, sum), &size) in rows.zip(&sizes) {
            if size > 0 {
                mean.iter_mut().zip(sum).for_each(|(mean, sum)| *mean = (sum / f64::from(size)) as f32);
            }
        }
    }
    Blocks::of(&means, dimension)
}

#[cfg(test)]
mod tests {
    use super::super::EigenpointIndex;
    use super::*;

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

    #[test]
    fn with_all_lists_probed_the_answer_is_exact() {
        for (count, lists) in [(1, 1), (5, 5), (333, 7), (4000, 60), (4001, 1)] {
            let (points, queries) = (clustered(count, 3), clustered(37, 4));
            let exact = EigenpointIndex::new(points.clone(), DIMENSION);
            let index = InvertedIndex::with_lists(points, DIMENSION, lists);
            for asked in [1, 6, 31, 200] {
                let found = index.nearest_several_probing(&queries, asked, lists);
                assert_eq!(
                    found,
                    exact.nearest_several(&queries, asked),
                    "{asked} of {count}, {lists} lists"
                );
            }
        }
    }

    #[test]
    fn few_lists_hold_nearly_all_of_the_nearest() {
        let (points, queries) = (clustered(20_000, 5), clustered(200, 6));
        let exact = EigenpointIndex::new(points.clone(), DIMENSION).nearest_several(&queries, 31);
        let index = InvertedIndex::new(points, DIMENSION);
        assert_eq!(index.lists(), 141);
        let found = index.nearest_several(&queries, 31);
        let rows = found.chunks_exact(31).zip(exact.chunks_exact(31));
        let (mut first, mut all) = (0, 0);
        for (found, exact) in rows {
            first += usize::from(found[0] == exact[0]);
            all += exact.iter().filter(|neighbour| found.contains(neighbour)).count();
            assert!(found.is_sorted_by(|a, b| (a.distance, a.index) < (b.distance, b.index)));
        }
        assert!(first >= 194, "{first} of 200");
        assert!(all >= 5580, "{all} of 6200");
    }

    #[test]
    fn many_identical_eigenpoints_are_found_by_index() {
        let mut points = [0.25_f32].repeat(10_000 * DIMENSION);
        points.extend([0.5_f32].repeat(DIMENSION));
        let queries = [[0.3_f32].repeat(DIMENSION), [0.6_f32].repeat(DIMENSION)].concat();
        let exact = EigenpointIndex::new(points.clone(), DIMENSION).nearest_several(&queries, 40);
        let index = InvertedIndex::new(points, DIMENSION);
        assert!(index.lists() > 1);
        assert_eq!(index.nearest_several(&queries, 40), exact);
        assert_eq!((exact[0].index, exact[39].index, exact[40].index), (0, 39, 10_000));
    }

    #[test]
    fn a_query_is_filled_from_further_lists() {
        let points = clustered(5000, 7);
        let index = InvertedIndex::with_lists(points.clone(), DIMENSION, 500);
        let found = index.nearest_several_probing(&points[..3 * DIMENSION], 300, 1);
        assert_eq!(found.len(), 900);
        for (number, row) in found.chunks_exact(300).enumerate() {
            assert_eq!(row[0], Neighbour { index: number, distance: 0.0 });
            let distinct: std::collections::HashSet<usize> = row.iter().map(|n| n.index).collect();
            assert_eq!(distinct.len(), 300);
        }
    }

    #[test]
    fn fewer_eigenpoints_than_asked_are_all_found() {
        let index = InvertedIndex::new(vec![0.0, 0.0, 30.0, 40.0], 2);
        let found = index.nearest_several(&[3.0, 4.0], 9);
        assert_eq!(found, [Neighbour { index: 0, distance: 5.0 }, Neighbour { index: 1, distance: 45.0 }]);
        assert!(index.nearest_several(&[], 9).is_empty());
    }

    #[test]
    fn an_index_repeats_and_vector_instructions_change_no_bit() {
        let (points, queries) = (clustered(6000, 8), clustered(8, 9));
        let build = || InvertedIndex::new(points.clone(), DIMENSION);
        let (a, b) = (build(), build());
        assert_eq!((&a.lists.rows, &a.starts), (&b.lists.rows, &b.starts));
        let numbers: Vec<u32> = (0..8).collect();
        let mut tiles = Tiles::default();
        tiles.fill(&WholeQueries::new(&queries, DIMENSION), &a.lists, &numbers);
        let scan = |plain: bool| {
            let mut nearest: Vec<Nearest> = (0..8).map(|_| Nearest::new(40, 1e-5)).collect();
            let blocks = 0..a.lists.squares.len();
            let pass = Scan { of: &a.lists, blocks, tiles: &tiles, asking: &numbers, nearest: &mut nearest };
            if plain {
                pass.run(pulp::Scalar, Plain)
            } else {
                dispatch(pass)
            }
            nearest.iter_mut().map(|n| n.in_order(40).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        assert_eq!(scan(true), scan(false));
    }
}
