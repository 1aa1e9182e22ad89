//! Lines on the ground: thin, straight, and leading out of the picture on both sides. They are marks, not parts; where
//! parts lie on one, it is taken from between them.

use super::components::{Run, Touching, area_px, components};
use super::distance_map::{DistanceMap, ONE_PX};
use super::region::Sums;

/// A component is a line if it is so many times as long as broad, by its second moments, reaches from border to border
/// over this part of the picture's shorter side, and is nowhere deeper than this part of its mean breadth.
const LINE_ELONGATION: f64 = 10.0;
const LEAST_REACH: f64 = 0.5;
const MOST_DEPTH: f64 = 0.65;
/// A line beneath parts is at most as broad as the shorter side by this.
const BREADTHS_A_SIDE: usize = 40;
/// A piece of it is at least so many breadths long, and so many times as long as broad by its second moments.
const LEAST_BREADTHS: f64 = 3.0;
const PIECE_ELONGATION: f64 = 4.0;

/// What of a component is no line, in its components; `None` if nothing of it is a line. The picture has `width` × `height`
/// pixels.
pub(super) fn without_lines(runs: &[Run], width: usize, height: usize) -> Option<Vec<Vec<Run>>> {
    let is_at_border = |run: &Run| {
        run.row() == 0 || run.row() + 1 == height || run.columns().start == 0 || run.columns().end == width
    };
    if !runs.iter().any(is_at_border) {
        return None;
    }
    let shorter = width.min(height);
    let map = DistanceMap::of(runs);
    let whole = Piece::of(runs, &is_at_border);
    let deepest_px = f64::from(map.thirds.iter().copied().max().unwrap_or(0)) / f64::from(ONE_PX);
    let is_even = deepest_px <= MOST_DEPTH * area_px(runs) as f64 / whole.length + 1.0;
    if is_even && whole.elongation >= LINE_ELONGATION && whole.border_reach >= LEAST_REACH * shorter as f64 {
        return Some(vec![]);
    }
    let breadth = (shorter / BREADTHS_A_SIDE).max(4);
    let depth = (breadth / 2) as u16 * ONE_PX;
    let to_core = map.to_deeper_than(depth);
    // All of it is farther than a line's half breadth from what is deeper.
    let thin: Vec<u8> = (map.thirds.iter().zip(&to_core))
        .map(|(&thirds, &to_core)| u8::from(thirds > 0 && to_core > depth + ONE_PX))
        .collect();
    let (thin_runs, count) = components(&thin, map.width, Touching::Corners);
    let numbers = |pieces: &[Run]| {
        let mut numbers = vec![u32::MAX; thin.len()];
        pieces.iter().for_each(|run| {
            numbers[run.row() * map.width..][run.columns()].fill(run.component() as u32);
        });
        numbers
    };
    let thin_numbers = numbers(&thin_runs);
    let pieces: Vec<Piece> =
        map.runs(&thin_numbers, count).iter().map(|runs| Piece::of(runs, &is_at_border)).collect();
    let is_line = |piece: &Piece| {
        piece.length >= LEAST_BREADTHS * breadth as f64 && piece.elongation >= PIECE_ELONGATION
    };
    let leading_out = pieces.iter().filter(|piece| is_line(piece) && piece.is_at_border).count();
    if leading_out < 2 {
        return None;
    }
    let mut rest: Vec<u8> = map.thirds.iter().map(|&thirds| u8::from(thirds > 0)).collect();
    for (at, number) in thin_numbers.iter().enumerate() {
        if pieces.get(*number as usize).is_some_and(is_line) {
            rest[at] = 0;
        }
    }
    let (runs, count) = components(&rest, map.width, Touching::Corners);
    Some(map.runs(&numbers(&runs), count))
}

/// A component, or a thin piece of one.
struct Piece {
    /// Diagonal of its box.
    length: f64,
    is_at_border: bool,
    elongation: f64,
    /// From the first to the last of its runs at the border.
    border_reach: f64,
}

impl Piece {
    fn of(runs: &[Run], is_at_border: &impl Fn(&Run) -> bool) -> Piece {
        let ends =
            |run: &Run| [run.columns().start, run.columns().end - 1].map(|x| [x as f64, run.row() as f64]);
        let points: Vec<[f64; 2]> = runs.iter().flat_map(ends).collect();
        let extent = |points: &[[f64; 2]]| {
            let side = |axis: usize| {
                let along = points.iter().map(|point| point[axis]);
                along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
            };
            if points.is_empty() { 0.0 } else { side(0).hypot(side(1)) }
        };
        let border: Vec<[f64; 2]> = runs.iter().filter(|run| is_at_border(run)).flat_map(ends).collect();
        Piece {
            length: extent(&points),
            is_at_border: !border.is_empty(),
            elongation: Sums::of(runs).elongation(),
            border_reach: extent(&border),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (320, 240);

    fn left(is_inside: impl Fn(f64, f64) -> bool) -> Option<Vec<usize>> {
        let (width, height) = SIZE;
        let inside = |at: usize| is_inside((at % width) as f64, (at / width) as f64);
        let mask: Vec<u8> = (0..width * height).map(|at| u8::from(inside(at))).collect();
        let (runs, count) = components(&mask, width, Touching::Corners);
        assert_eq!(count, 1);
        let rest = without_lines(&runs, width, height)?;
        Some(rest.iter().map(|runs| runs.iter().map(|run| run.columns().len()).sum()).collect())
    }

    fn line(x: f64, y: f64) -> bool {
        (y - 120.0 - 0.1 * x).abs() < 2.0
    }

    #[test]
    fn a_line_across_the_picture_is_no_part() {
        assert_eq!(left(line), Some(vec![]));
    }

    #[test]
    fn parts_on_a_line_are_left() {
        let disc = |x: f64, y: f64, at: f64| (x - at).hypot(y - 125.0 - 0.1 * at) < 25.0;
        let mut areas = left(|x, y| line(x, y) || disc(x, y, 90.0) || disc(x, y, 230.0)).unwrap();
        areas.retain(|area| *area > 100);
        assert_eq!(areas.len(), 2);
        assert!(areas.iter().all(|area| (*area as f64 / 1963.0 - 1.0).abs() < 0.06), "{areas:?}");
    }

    #[test]
    fn rods_and_parts_at_the_border_are_no_lines() {
        assert_eq!(left(|x, y| line(x, y) && (20.0..300.0).contains(&x)), None, "it ends within");
        assert_eq!(left(|x, y| line(x, y) && x < 200.0), None, "it leads out on one side");
        assert_eq!(left(|x, y| x < 60.0 && (y - 120.0).abs() < 30.0), None);
        let spoon =
            |x: f64, y: f64| (x < 150.0 && (y - 100.0).abs() < 2.5) || (x - 160.0).hypot(y - 100.0) < 30.0;
        assert_eq!(left(spoon), None);
    }
}
