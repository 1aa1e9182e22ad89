//! How deep each pixel of a component lies in it: the chamfer distance to the nearest pixel outside (weights 3 and 4, Borgefors
//! 1986), within 8 % of the Euclidean one. Beyond the picture's border is outside.

use super::components::Run;

/// Thirds of a pixel along a side, and across a corner.
const SIDE: u16 = 3;
const CORNER: u16 = 4;
/// A pixel in [`DistanceMap::thirds`].
pub(super) const ONE_PX: u16 = SIDE;

/// The distances in a component's box, with a margin of a pixel.
pub(super) struct DistanceMap {
    /// Column and row of the picture at the map's first pixel, which may be −1.
    left: isize,
    top: isize,
    pub width: usize,
    /// In thirds of a pixel, row-major; 0 outside.
    pub thirds: Vec<u16>,
}

impl DistanceMap {
    /// Of a component that has runs.
    pub fn of(runs: &[Run]) -> DistanceMap {
        let over = |value: &dyn Fn(&Run) -> usize| {
            runs.iter().map(value).fold((usize::MAX, 0), |(a, b), v| (a.min(v), b.max(v)))
        };
        let (top, bottom) = over(&|run| run.row());
        let left = over(&|run| run.columns().start).0;
        let right = over(&|run| run.columns().end).1;
        let (width, height) = (right - left + 2, bottom - top + 3);
        let mut map = DistanceMap {
            left: left as isize - 1,
            top: top as isize - 1,
            width,
            thirds: vec![0; width * height],
        };
        for run in runs {
            let first = map.at(run.row(), run.columns().start);
            map.thirds[first..first + run.columns().len()].fill(u16::MAX);
        }
        spread(&mut map.thirds, width);
        map
    }

    /// Where a pixel of the picture is in the map.
    fn at(&self, row: usize, column: usize) -> usize {
        (row as isize - self.top) as usize * self.width + (column as isize - self.left) as usize
    }

    /// The distance of every pixel of the map to the nearest one deeper than `thirds`; [`u16::MAX`] without one.
    pub fn to_deeper_than(&self, thirds: u16) -> Vec<u16> {
        let mut distances: Vec<u16> =
            self.thirds.iter().map(|&v| if v > thirds { 0 } else { u16::MAX }).collect();
        spread(&mut distances, self.width);
        distances
    }

    /// The runs of the pixels for which `number` gives one, by their numbers.
    pub fn runs(&self, numbers: &[u32], count: usize) -> Vec<Vec<Run>> {
        let mut out = vec![Vec::new(); count];
        for (y, row) in numbers.chunks_exact(self.width).enumerate() {
            let mut x = 0;
            for same in row.chunk_by(|a, b| a == b) {
                if let Some(runs) = out.get_mut(same[0] as usize) {
                    let start = (self.left + x as isize) as usize;
                    runs.push(Run::new((self.top + y as isize) as usize, start..start + same.len()));
                }
                x += same.len();
            }
        }
        out
    }
}

/// Distances to the nearest zero, in place: one pass down and one up. The outermost pixels are not written.
fn spread(distances: &mut [u16], width: usize) {
    let height = distances.len() / width;
    let mut relax = |at: usize, others: [(usize, u16); 4]| {
        if distances[at] != 0 {
            let near = others.map(|(other, weight)| distances[other].saturating_add(weight));
            distances[at] = near.into_iter().fold(distances[at], u16::min);
        }
    };
    for y in 1..height - 1 {
        for at in y * width + 1..(y + 1) * width - 1 {
            relax(
                at,
                [(at - 1, SIDE), (at - width - 1, CORNER), (at - width, SIDE), (at - width + 1, CORNER)],
            );
        }
    }
    for y in (1..height - 1).rev() {
        for at in (y * width + 1..(y + 1) * width - 1).rev() {
            relax(
                at,
                [(at + 1, SIDE), (at + width + 1, CORNER), (at + width, SIDE), (at + width - 1, CORNER)],
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::segmentation::components::{Touching, components};

    #[test]
    fn depth_is_within_a_twelfth_of_the_distance_to_the_nearest_pixel_outside() {
        let (width, height) = (70_usize, 60_usize);
        let is_inside = |x: usize, y: usize| {
            let (dx, dy) = (x as f64 - 34.0, y as f64 - 29.0);
            (dx * dx / 900.0 + dy * dy / 500.0 < 1.0) && !(dx.abs() < 4.0 && dy > 0.0)
        };
        let mask: Vec<u8> =
            (0..width * height).map(|at| u8::from(is_inside(at % width, at / width))).collect();
        let (runs, count) = components(&mask, width, Touching::Corners);
        assert_eq!(count, 1);
        let map = DistanceMap::of(&runs);
        for (x, y) in [(34, 20), (10, 30), (50, 35), (34, 28), (20, 29)] {
            let outside = (0..width * height).filter(|&at| mask[at] == 0);
            let nearest = outside
                .map(|at| ((at % width) as f64 - x as f64).hypot((at / width) as f64 - y as f64))
                .fold(f64::INFINITY, f64::min);
            let found = f64::from(map.thirds[map.at(y, x)]) / f64::from(ONE_PX);
            assert!((found / nearest - 1.0).abs() < 0.085, "({x}, {y}): {found}, not {nearest}");
        }
    }

    #[test]
    fn runs_come_back_by_their_numbers_also_at_the_border() {
        let runs = [Run::new(0, 0..4), Run::new(1, 2..5)];
        let map = DistanceMap::of(&runs);
        let numbers: Vec<u32> = map.thirds.iter().map(|&v| if v > 0 { 1 } else { u32::MAX }).collect();
        assert_eq!(map.runs(&numbers, 2), [vec![], runs.to_vec()]);
    }
}
