//! Points side by side, two coordinates at a time, in whole numbers: what queries are shown to.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::candidates::Candidates;
use super::queries::{Tile, Tiles};

/// Sums that are one vector of AVX2.
const LANES: usize = 8;
/// Points that are side by side: two vectors of sums.
pub const BLOCK: usize = 2 * LANES;
/// Queries that pass over a block together: their sums and the block's points fill AVX2's registers.
pub(super) const TILE: usize = 4;
/// The index of a place of a block that holds no point.
pub(super) const EMPTY: u32 = u32::MAX;

/// What a coordinate is kept as.
pub(super) trait Coordinate: Copy + Default + Send + Sync + 'static {
    /// A row of pairs as what `products` multiplies.
    fn pairs<P: Products>(products: P, row: &[[Self; 2]; LANES]) -> P::Pairs;
}

impl Coordinate for i8 {
    #[inline(always)]
    fn pairs<P: Products>(products: P, row: &[[i8; 2]; LANES]) -> P::Pairs {
        products.short(row)
    }
}

impl Coordinate for i16 {
    #[inline(always)]
    fn pairs<P: Products>(products: P, row: &[[i16; 2]; LANES]) -> P::Pairs {
        products.long(row)
    }
}

/// Points in blocks of [`BLOCK`].
#[derive(Clone)]
pub(super) struct Blocks<C> {
    /// Pairs of coordinates of a point; the last pair of an odd number ends with 0.
    pairs: usize,
    /// For each pair of each block a row of [`BLOCK`] pairs.
    coordinates: Vec<C>,
    /// ‖t‖² of each place, infinite where no point is.
    squares: Vec<f32>,
    /// Which point each place holds.
    indices: Vec<u32>,
}

impl<C: Coordinate> Blocks<C> {
    /// So many blocks without points.
    pub fn new(blocks: usize, dimension: usize) -> Blocks<C> {
        let pairs = dimension.div_ceil(2);
        Blocks {
            pairs,
            coordinates: vec![C::default(); blocks * pairs * BLOCK * 2],
            squares: vec![f32::INFINITY; blocks * BLOCK],
            indices: vec![EMPTY; blocks * BLOCK],
        }
    }

    pub fn put(&mut self, place: usize, index: u32, coordinates: &[C], square: f32) {
        let (block, lane) = (place / BLOCK, place % BLOCK);
        let rows = self.coordinates[block * self.pairs * BLOCK * 2..].chunks_exact_mut(BLOCK * 2);
        for (row, pair) in rows.zip(coordinates.chunks(2)) {
            row[2 * lane..][..pair.len()].copy_from_slice(pair);
        }
        self.squares[place] = square;
        self.indices[place] = index;
    }

    /// Which point a place holds, or [`EMPTY`].
    #[inline(always)]
    pub fn index(&self, place: usize) -> u32 {
        self.indices[place]
    }

    /// The coordinates of a place's point, by pairs.
    #[inline(always)]
    pub fn point(&self, place: usize) -> impl Iterator<Item = &[C; 2]> {
        let rows = &self.rows().coordinates[place / BLOCK * self.pairs..][..self.pairs];
        rows.iter().map(move |row| &row[place % BLOCK])
    }

    /// How many blocks there are.
    pub fn count(&self) -> usize {
        self.indices.len() / BLOCK
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.coordinates[..]) + size_of_val(&self.squares[..]) + size_of_val(&self.indices[..])
    }

    fn rows(&self) -> Rows<'_, C> {
        Rows {
            pairs: self.pairs,
            coordinates: self.coordinates.as_chunks::<2>().0.as_chunks::<BLOCK>().0,
            squares: self.squares.as_chunks().0,
            indices: self.indices.as_chunks().0,
        }
    }

    /// Shows a range of blocks to queries; candidates are their places.
    pub fn scan(&self, blocks: Range<usize>, tiles: &Tiles, candidates: &mut [Candidates]) {
        if !tiles.numbers.is_empty() && !blocks.is_empty() {
            dispatch(Scan { of: self.rows(), blocks, tiles, candidates });
        }
    }

    /// The nearest point of each query, of equal ones the first of the lowest index.
    pub fn nearest(&self, tiles: &Tiles, found: &mut [u32]) {
        dispatch(NearestOne { of: self.rows(), tiles, found });
    }
}

/// The columns of blocks, block by block.
struct Rows<'a, C> {
    pairs: usize,
    coordinates: &'a [[[C; 2]; BLOCK]],
    squares: &'a [[f32; BLOCK]],
    indices: &'a [[u32; BLOCK]],
}

/// What products of whole numbers are added up with: processors have an instruction for it.
pub(super) trait Products: Copy {
    type Pairs: Copy;
    type Sums: Copy;
    fn zero(self) -> Self::Sums;
    fn short(self, row: &[[i8; 2]; LANES]) -> Self::Pairs;
    fn long(self, row: &[[i16; 2]; LANES]) -> Self::Pairs;
    /// Adds the product of each pair of the row with `pair`.
    fn add(self, sums: Self::Sums, row: Self::Pairs, pair: [i16; 2]) -> Self::Sums;
    fn sums(self, sums: Self::Sums) -> [i32; LANES];
}

#[derive(Clone, Copy)]
struct Plain;

impl Products for Plain {
    type Pairs = [[i16; 2]; LANES];
    type Sums = [i32; LANES];

    #[inline(always)]
    fn zero(self) -> Self::Sums {
        [0; LANES]
    }

    #[inline(always)]
    fn short(self, row: &[[i8; 2]; LANES]) -> Self::Pairs {
        row.map(|pair| pair.map(i16::from))
    }

    #[inline(always)]
    fn long(self, row: &[[i16; 2]; LANES]) -> Self::Pairs {
        *row
    }

    #[inline(always)]
    fn add(self, mut sums: Self::Sums, row: Self::Pairs, pair: [i16; 2]) -> Self::Sums {
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
    type Pairs = pulp::i16x16;
    type Sums = pulp::i32x8;

    #[inline(always)]
    fn zero(self) -> Self::Sums {
        self.splat_i32x8(0)
    }

    #[inline(always)]
    fn short(self, row: &[[i8; 2]; LANES]) -> Self::Pairs {
        self.convert_i8x16_to_i16x16(pulp::cast(*row))
    }

    #[inline(always)]
    fn long(self, row: &[[i16; 2]; LANES]) -> Self::Pairs {
        pulp::cast(*row)
    }

    #[inline(always)]
    fn add(self, sums: Self::Sums, row: Self::Pairs, pair: [i16; 2]) -> Self::Sums {
        let pair = pulp::cast(self.splat_i32x8(pulp::cast(pair)));
        self.wrapping_add_i32x8(sums, self.multiply_wrapping_add_adjacent_i16x16(row, pair))
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
fn parts<P: Products, C: Coordinate>(
    products: P,
    rows: &[[[C; 2]; BLOCK]],
    squares: &[f32; BLOCK],
    queries: &[[[i16; 2]; TILE]],
    tile: &Tile,
    parts: &mut [[f32; BLOCK]; TILE],
) {
    let mut sums = [[products.zero(); 2]; TILE];
    for (row, queries) in rows.iter().zip(queries) {
        let (first, second) = row.split_at(LANES);
        let (Some(first), Some(second)) = (first.first_chunk(), second.first_chunk()) else { continue };
        let (first, second) = (C::pairs(products, first), C::pairs(products, second));
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
                *part = square + (tile.offsets[lane] + tile.factors[lane] * sum as f32);
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
struct Scan<'a, C> {
    of: Rows<'a, C>,
    blocks: Range<usize>,
    tiles: &'a Tiles,
    candidates: &'a mut [Candidates],
}

impl<C: Coordinate> Pass for Scan<'_, C> {
    #[inline(always)]
    fn run<S: Simd, P: Products>(self, simd: S, products: P) {
        let pairs = self.of.pairs;
        let mut out = [[0.0; BLOCK]; TILE];
        for block in self.blocks {
            let rows = &self.of.coordinates[block * pairs..][..pairs];
            let (squares, indices) = (&self.of.squares[block], &self.of.indices[block]);
            for (number, tile) in self.tiles.tiles.iter().enumerate() {
                let queries = &self.tiles.rows[number * pairs..][..pairs];
                parts(products, rows, squares, queries, tile, &mut out);
                for (parts, &query) in out.iter().zip(&self.tiles.numbers[number * TILE..]) {
                    let candidates = &mut self.candidates[query as usize];
                    if passes(simd, parts, candidates.limit()) {
                        candidates.add(parts, indices, (block * BLOCK) as u32);
                    }
                }
            }
        }
    }
}

struct NearestOne<'a, C> {
    of: Rows<'a, C>,
    tiles: &'a Tiles,
    found: &'a mut [u32],
}

impl<C: Coordinate> Pass for NearestOne<'_, C> {
    #[inline(always)]
    fn run<S: Simd, P: Products>(self, simd: S, products: P) {
        let pairs = self.of.pairs;
        let mut out = [[0.0; BLOCK]; TILE];
        let mut least = vec![f32::INFINITY; self.found.len()];
        for (block, squares) in self.of.squares.iter().enumerate() {
            let rows = &self.of.coordinates[block * pairs..][..pairs];
            let indices = &self.of.indices[block];
            for (number, tile) in self.tiles.tiles.iter().enumerate() {
                let queries = &self.tiles.rows[number * pairs..][..pairs];
                parts(products, rows, squares, queries, tile, &mut out);
                let points = least.iter_mut().zip(self.found.iter_mut()).skip(number * TILE);
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

#[cfg(test)]
mod tests {
    use super::super::queries::WholeQueries;
    use super::*;
    use crate::random::Random;

    #[test]
    fn vector_instructions_change_no_bit() {
        const DIMENSION: usize = 23;
        let mut random = Random::new(8, 9);
        let mut numbers =
            |count: usize| -> Vec<f32> { (0..count).map(|_| random.normals()[0] as f32).collect() };
        let queries = numbers(8 * DIMENSION);
        let mut blocks = Blocks::<i8>::new(20, DIMENSION);
        for place in 0..317 {
            let coordinates: Vec<i8> = numbers(DIMENSION).iter().map(|v| (v * 30.0) as i8).collect();
            let square = coordinates.iter().map(|&v| f32::from(v).powi(2)).sum();
            blocks.put(place, 1000 - place as u32, &coordinates, square);
        }
        let mut tiles = Tiles::default();
        let asking: Vec<(u32, f32)> = (0..8).map(|number| (number, number as f32)).collect();
        tiles.fill(&WholeQueries::new(&queries, DIMENSION, |_| 1.0), 1.0, asking.iter().copied());
        let scan = |plain: bool| {
            let mut candidates: Vec<Candidates> = (0..8).map(|_| Candidates::new(40)).collect();
            let pass = Scan { of: blocks.rows(), blocks: 0..20, tiles: &tiles, candidates: &mut candidates };
            if plain {
                pass.run(pulp::Scalar, Plain)
            } else {
                dispatch(pass)
            }
            candidates.iter_mut().map(|found| found.nearest().collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        let found = scan(false);
        assert_eq!(found[0].len(), 40);
        assert_eq!(scan(true), found);
    }
}
