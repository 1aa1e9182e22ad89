//! The nearest points of a query, so far.

use super::blocks::{BLOCK, EMPTY};

/// Candidates are reduced to the nearest when they are so many.
const LEAST_CAPACITY: usize = 48;

/// The candidates for the nearest `count` points of a query.
pub(super) struct Candidates {
    count: usize,
    /// What the part of a candidate can't exceed.
    limit: f32,
    capacity: usize,
    /// In no order; of meaning up to `held`, and with room for a block after the capacity.
    candidates: Vec<u64>,
    held: usize,
}

/// A number that is in the order of parts, then of places.
#[inline(always)]
fn candidate(part: f32, place: u32) -> u64 {
    let bits = part.to_bits();
    let ordered = bits ^ (((bits as i32 >> 31) as u32) | 0x8000_0000);
    (u64::from(ordered) << 32) | u64::from(place)
}

fn place_of(candidate: u64) -> u32 {
    candidate as u32
}

fn part_of(candidate: u64) -> f32 {
    let ordered = (candidate >> 32) as u32;
    f32::from_bits(if ordered >> 31 == 1 { ordered ^ 0x8000_0000 } else { !ordered })
}

impl Candidates {
    pub fn new(count: usize) -> Candidates {
        let capacity = (2 * count + BLOCK).max(LEAST_CAPACITY);
        Candidates { count, limit: f32::INFINITY, capacity, candidates: vec![0; capacity + BLOCK], held: 0 }
    }

    /// What the part of a candidate can't exceed.
    #[inline(always)]
    pub fn limit(&self) -> f32 {
        self.limit
    }

    /// How many there are, `count` at most.
    pub fn len(&self) -> usize {
        self.held.min(self.count)
    }

    /// Adds those of a block that are within the limit; `first` is the place of its first.
    pub fn add(&mut self, parts: &[f32; BLOCK], indices: &[u32; BLOCK], first: u32) {
        let room = self.candidates[self.held..].first_chunk_mut::<BLOCK>().expect("room for a block");
        let mut added = 0;
        for lane in 0..BLOCK {
            room[added % BLOCK] = candidate(parts[lane], first + lane as u32);
            added += usize::from(parts[lane] <= self.limit && indices[lane] != EMPTY);
        }
        self.held += added;
        if self.held >= self.capacity {
            self.reduce();
        }
    }

    /// Keeps the nearest.
    fn reduce(&mut self) {
        if self.held > self.count {
            let held = &mut self.candidates[..self.held];
            let last = *held.select_nth_unstable(self.count - 1).1;
            (self.limit, self.held) = (part_of(last), self.count);
        }
    }

    /// ‖q − t‖² without ‖q‖², and the place of at most `count` points; the nearest first, of equal ones the lower place.
    pub fn nearest(&mut self) -> impl Iterator<Item = (f32, u32)> {
        self.reduce();
        let nearest = &mut self.candidates[..self.held];
        nearest.sort_unstable();
        nearest.iter().map(|&candidate| (part_of(candidate), place_of(candidate)))
    }
}
