//! Centroids, and the steps in which what a point differs from its centroid is kept: a byte a coordinate.

use super::blocks::Blocks;
use super::queries::{Tiles, WholeQueries, length, unit, whole};
use crate::random::Random;

/// Points of a sample for each centroid at most, and rounds of k-means.
const SAMPLE_PER_LIST: usize = 32;
const ROUNDS: usize = 6;
/// Points whose centroids are sought together: they stay in the first cache.
const TOGETHER: usize = 64;
/// This part of a coordinate's residuals is within the range of codes; the others are kept as the largest code, which is the
/// greatest of them over so much at least.
const CODED: f64 = 0.9995;
const MOST_CUT: f32 = 2.0;
/// Parts of a step that are told apart where few points are left.
const FINE: f32 = 16.0;
/// The largest code.
const LARGEST_CODE: f32 = 127.0;

/// How points are told apart, learnt from a sample.
#[derive(Clone)]
pub struct Codebook {
    dimension: usize,
    /// Lists × dimension.
    centroids: Vec<f32>,
    /// Of each coordinate what 1 is worth.
    steps: Vec<f32>,
    blocks: Blocks<i16>,
    /// What 1 is worth in `blocks`.
    unit: f32,
}

/// A point as it is kept: its list, little-endian; a byte a coordinate; what those leave in sixteenths of a step, the even
/// coordinates in the low halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code<'a> {
    /// Whose centroid is nearest.
    pub list: u32,
    /// In steps from the centroid.
    pub coordinates: &'a [i8],
    /// Two coordinates a byte.
    pub fine: &'a [u8],
}

/// Bytes of the list of a code.
const LIST_LENGTH: usize = size_of::<u32>();

impl Code<'_> {
    /// Bytes of a code.
    pub fn length(dimension: usize) -> usize {
        LIST_LENGTH + dimension + dimension.div_ceil(2)
    }

    /// The code in the first bytes of a row.
    ///
    /// # Panics
    /// If the row is shorter than [`Code::length`].
    pub fn of_row(row: &[u8], dimension: usize) -> Code<'_> {
        let (list, rest) = row.split_first_chunk::<LIST_LENGTH>().expect("a row starts with a code");
        let (coordinates, rest) = rest.split_at(dimension);
        Code {
            list: u32::from_le_bytes(*list),
            coordinates: bytemuck::cast_slice(coordinates),
            fine: &rest[..dimension.div_ceil(2)],
        }
    }

    /// Adds its bytes to a row.
    pub fn append_to(self, row: &mut Vec<u8>) {
        row.extend(self.list.to_le_bytes());
        row.extend(bytemuck::cast_slice::<i8, u8>(self.coordinates));
        row.extend(self.fine);
    }
}

impl Codebook {
    /// A codebook of at most `lists` lists, of as many as there are points if those are fewer, from n × `dimension` row-major
    /// points: k-means on a seeded choice of them.
    ///
    /// # Panics
    /// If there is no point, not a whole number of them, or `lists` is 0.
    pub fn fit(points: &[f32], dimension: usize, lists: usize) -> Codebook {
        assert!(dimension > 0 && !points.is_empty(), "there are points");
        assert!(points.len().is_multiple_of(dimension), "whole points");
        assert!(lists > 0, "a point is in a list");
        let lists = lists.min(points.len() / dimension);
        let sample = chosen(points, dimension, SAMPLE_PER_LIST * lists);
        let (centroids, blocks, unit) = centroids(&sample, dimension, lists);
        let of_point = nearest(&blocks, unit, &sample, dimension);
        let step = |coordinate: usize| {
            let off = |(point, &list): (&[f32], &u32)| {
                (point[coordinate] - centroids[list as usize * dimension + coordinate]).abs()
            };
            let mut off: Vec<f32> = sample.chunks_exact(dimension).zip(&of_point).map(off).collect();
            let last = ((off.len() - 1) as f64 * CODED).ceil() as usize;
            let (_, &mut usual, rest) = off.select_nth_unstable_by(last, f32::total_cmp);
            let largest = rest.iter().fold(usual, |largest, off| largest.max(off / MOST_CUT));
            if largest > 0.0 { largest / LARGEST_CODE } else { 1.0 }
        };
        Codebook { dimension, steps: (0..dimension).map(step).collect(), centroids, blocks, unit }
    }

    /// A codebook as it was kept; `None` if there is no list, or not a step for each coordinate.
    pub fn of_parts(centroids: Vec<f32>, steps: Vec<f32>) -> Option<Codebook> {
        let dimension = steps.len();
        let is_whole = dimension > 0 && !centroids.is_empty() && centroids.len().is_multiple_of(dimension);
        is_whole.then(|| {
            let (blocks, unit) = blocks_of(&centroids, dimension);
            Codebook { dimension, centroids, steps, blocks, unit }
        })
    }

    /// Lists × dimension, row-major.
    pub fn centroids(&self) -> &[f32] {
        &self.centroids
    }

    /// What a code of 1 is worth, coordinate by coordinate.
    pub fn steps(&self) -> &[f32] {
        &self.steps
    }

    /// How many lists there are.
    pub fn lists(&self) -> usize {
        self.centroids.len() / self.dimension
    }

    /// Coordinates of a point.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.centroids[..]) + size_of_val(&self.steps[..]) + self.blocks.bytes()
    }

    /// The codes of n × dimension row-major points, all finite: n × [`Code::length`] bytes.
    ///
    /// # Panics
    /// If it is not a whole number of them.
    pub fn encode(&self, points: &[f32]) -> Vec<u8> {
        assert!(points.len().is_multiple_of(self.dimension), "whole points");
        let lists = nearest(&self.blocks, self.unit, points, self.dimension);
        let mut codes = Vec::with_capacity(lists.len() * Code::length(self.dimension));
        let (mut coordinates, mut fine) = (vec![0; self.dimension], vec![0; self.dimension.div_ceil(2)]);
        for (point, list) in points.chunks_exact(self.dimension).zip(lists) {
            let centroid = self.centroid(list as usize);
            fine.fill(0);
            for (at, coordinate) in coordinates.iter_mut().enumerate() {
                let steps = (point[at] - centroid[at]) / self.steps[at];
                let code = steps.round().clamp(-LARGEST_CODE, LARGEST_CODE);
                let sixteenths = ((steps - code) * FINE).floor().clamp(-FINE / 2.0, FINE / 2.0 - 1.0);
                *coordinate = code as i8;
                fine[at / 2] |= (sixteenths as i8 as u8 & 0xf) << (at % 2 * 4);
            }
            Code { list, coordinates: &coordinates, fine: &fine }.append_to(&mut codes);
        }
        codes
    }

    /// The point that a code stands for.
    pub(super) fn decoded<'a>(&'a self, list: usize, code: &'a [i8]) -> impl Iterator<Item = f32> + 'a {
        let parts = self.centroid(list).iter().zip(&self.steps).zip(code);
        parts.map(|((middle, step), &code)| middle + step * f32::from(code))
    }

    /// The point that a code, by pairs, and what it leaves stand for.
    #[inline(always)]
    pub(super) fn decode_finely<'a>(
        &self,
        list: usize,
        code: impl Iterator<Item = &'a [i8; 2]>,
        fine: &[u8],
        point: &mut [f32],
    ) {
        let (centroid, steps) = (self.centroid(list), &self.steps);
        // the middle of a sixteenth
        let finely = |code: i8, fine: i8| f32::from(code) + (f32::from(fine) + 0.5) / FINE;
        let (pairs, last) = point.as_chunks_mut::<2>();
        let (middles, last_middle) = centroid.as_chunks::<2>();
        let (units, last_unit) = steps.as_chunks::<2>();
        let mut parts = code.zip(fine).map(|(&[even, odd], &both)| {
            [finely(even, (both << 4) as i8 >> 4), finely(odd, both as i8 >> 4)]
        });
        for ((point, middle), unit) in pairs.iter_mut().zip(middles).zip(units) {
            let [even, odd] = parts.next().unwrap_or_default();
            *point = [middle[0] + unit[0] * even, middle[1] + unit[1] * odd];
        }
        if let ([point], [middle], [unit]) = (last, last_middle, last_unit) {
            *point = middle + unit * parts.next().unwrap_or_default()[0];
        }
    }

    /// The centroid of a list.
    pub(super) fn centroid(&self, list: usize) -> &[f32] {
        &self.centroids[list * self.dimension..][..self.dimension]
    }

    /// The centroids side by side, and the unit of their coordinates.
    pub(super) fn blocks(&self) -> (&Blocks<i16>, f32) {
        (&self.blocks, self.unit)
    }
}

/// One point of every stretch, in an order of chance; `most` at most.
fn chosen(points: &[f32], dimension: usize, most: usize) -> Vec<f32> {
    let count = points.len() / dimension;
    let wanted = most.min(count);
    let mut random = Random::new(0, 0x11f);
    let mut chosen: Vec<usize> = (0..wanted)
        .map(|i| {
            let (from, to) = (i * count / wanted, (i + 1) * count / wanted);
            from + (random.uniform() * (to - from) as f64) as usize
        })
        .collect();
    for i in (1..chosen.len()).rev() {
        chosen.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
    chosen.iter().flat_map(|&index| &points[index * dimension..][..dimension]).copied().collect()
}

/// k-means: the centroids, as rows and side by side.
fn centroids(sample: &[f32], dimension: usize, lists: usize) -> (Vec<f32>, Blocks<i16>, f32) {
    let mut means = sample[..lists * dimension].to_vec();
    let rounds = if lists == 1 { 1 } else { ROUNDS };
    for _ in 0..rounds {
        let (blocks, unit) = blocks_of(&means, dimension);
        let of_point = nearest(&blocks, unit, sample, dimension);
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
    let (blocks, unit) = blocks_of(&means, dimension);
    (means, blocks, unit)
}

/// Row-major points in blocks, with the unit of their coordinates.
fn blocks_of(points: &[f32], dimension: usize) -> (Blocks<i16>, f32) {
    let rows = || points.chunks_exact(dimension);
    let unit = unit(rows().map(|point| length(point.iter().copied())).fold(0.0, f32::max));
    let mut blocks = Blocks::new(rows().len().div_ceil(super::blocks::BLOCK), dimension);
    for (index, point) in rows().enumerate() {
        let coordinates: Vec<i16> = point.iter().map(|&value| whole(value, unit)).collect();
        blocks.put(index, index as u32, &coordinates, length(point.iter().copied()).powi(2));
    }
    (blocks, unit)
}

/// For each of n × dimension row-major points the nearest centroid, of equal ones the first.
fn nearest(centroids: &Blocks<i16>, unit: f32, points: &[f32], dimension: usize) -> Vec<u32> {
    let mut found = vec![0; points.len() / dimension];
    let mut tiles = Tiles::default();
    let points = points.chunks(TOGETHER * dimension);
    for (points, found) in points.zip(found.chunks_mut(TOGETHER)) {
        let queries = WholeQueries::new(points, dimension, |_| 1.0);
        tiles.fill(&queries, unit, (0..found.len() as u32).map(|number| (number, 0.0)));
        centroids.nearest(&tiles, found);
    }
    found
}
