//! Queries in whole numbers, and by fours, as blocks of points are shown to them.

use super::blocks::TILE;

/// The greatest coordinate in whole numbers. Products with one of 16 bits are below 2³⁰, those of pairs below 2³¹; sums of
/// many stay there because points of 16 bits are no longer than this either, and points of 8 bits are few units long.
const LARGEST: f32 = 32_000.0;

/// The unit of a vector's whole numbers, given its length: it is [`LARGEST`] units long.
pub(super) fn unit(length: f32) -> f32 {
    if length > 0.0 { length / LARGEST } else { 1.0 }
}

/// A number in whole units, the nearest.
#[inline(always)]
pub(super) fn whole(value: f32, unit: f32) -> i16 {
    // adding so much leaves f32 no place for a fraction
    const NO_FRACTION: f32 = (3 << 22) as f32;
    ((value / unit + NO_FRACTION) - NO_FRACTION) as i16
}

/// The length of a vector.
pub(super) fn length(vector: impl Iterator<Item = f32>) -> f32 {
    vector.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt() as f32
}

/// Queries in whole numbers, each with a unit of its own.
pub(super) struct WholeQueries {
    pairs: usize,
    rows: Vec<[i16; 2]>,
    units: Vec<f32>,
}

impl WholeQueries {
    /// Of n × `dimension` row-major queries, their coordinates multiplied by what `scale` says.
    pub fn new(queries: &[f32], dimension: usize, scale: impl Fn(usize) -> f32) -> WholeQueries {
        let pairs = dimension.div_ceil(2);
        let mut rows = Vec::with_capacity(queries.len() / dimension * pairs);
        let mut units = Vec::with_capacity(queries.len() / dimension);
        for query in queries.chunks_exact(dimension) {
            let scaled = |at: usize| query.get(at).map_or(0.0, |value| value * scale(at));
            let unit = unit(length((0..dimension).map(scaled)));
            rows.extend((0..pairs).map(|pair| [2 * pair, 2 * pair + 1].map(|at| whole(scaled(at), unit))));
            units.push(unit);
        }
        WholeQueries { pairs, rows, units }
    }

    pub fn count(&self) -> usize {
        self.units.len()
    }

    fn row(&self, number: u32) -> &[[i16; 2]] {
        &self.rows[number as usize * self.pairs..][..self.pairs]
    }
}

/// What four queries add to the product with a point.
#[derive(Clone, Copy, Default)]
pub(super) struct Tile {
    /// −2 times what a product of 1 and 1 is worth.
    pub factors: [f32; TILE],
    pub offsets: [f32; TILE],
}

/// Queries by fours, two coordinates at a time.
#[derive(Default)]
pub(super) struct Tiles {
    /// For each pair of coordinates of each tile.
    pub rows: Vec<[[i16; 2]; TILE]>,
    pub tiles: Vec<Tile>,
    /// Which queries they are.
    pub numbers: Vec<u32>,
}

impl Tiles {
    /// Replaces what it holds by the numbered queries, each with what is added to its distances, for points whose
    /// coordinates have that unit.
    pub fn fill(&mut self, queries: &WholeQueries, unit: f32, asking: impl Iterator<Item = (u32, f32)>) {
        let pairs = queries.pairs;
        self.rows.clear();
        self.tiles.clear();
        self.numbers.clear();
        for (place, (number, offset)) in asking.enumerate() {
            let lane = place % TILE;
            if lane == 0 {
                self.tiles.push(Tile::default());
                self.rows.resize(self.tiles.len() * pairs, [[0; 2]; TILE]);
            }
            let tile = self.tiles.len() - 1;
            self.tiles[tile].factors[lane] = -2.0 * queries.units[number as usize] * unit;
            self.tiles[tile].offsets[lane] = offset;
            for (row, pair) in self.rows[tile * pairs..].iter_mut().zip(queries.row(number)) {
                row[lane] = *pair;
            }
            self.numbers.push(number);
        }
    }
}
