//! Dark holes of a part: what the foreground encloses, and is darker than the background, belongs to the part.
//!
//! A handle's opening shows the background and stays open; a car's wheel is darker and is filled.

use std::ops::Range;

use super::components::{Run, Touching, components};

/// Reach of the closing square: gaps of twice as many pixels don't open a hole to the outside.
const REACH_PX: usize = 3;
/// A hole is dark if it is below the background by this part of the offset.
const DARK_PART: f64 = 0.5;

/// Fills the dark holes of a mask of 0 and 1, each within one part: what is dark between two parts, of at least
/// `smallest_px` both, is their shadow.
pub(super) fn fill_dark_holes(mask: &mut [u8], width: usize, above: &[f32], offset: f32, smallest_px: usize) {
    let (mut holes, count) = components(&enclosed(mask, width), width, Touching::Sides);
    let mut sums = vec![(0.0, 0_usize); count];
    for run in &holes {
        let above = &above[run.row() * width..][run.columns()];
        let (sum, pixels) = &mut sums[run.component()];
        *sum += above.iter().map(|&v| f64::from(v)).sum::<f64>();
        *pixels += above.len();
    }
    let dark = -DARK_PART * f64::from(offset);
    holes.retain(|run| {
        let (sum, pixels) = sums[run.component()];
        sum < dark * pixels as f64
    });
    if holes.is_empty() {
        return;
    }
    let adjoining = adjoining_parts(mask, width, &holes, count, smallest_px);
    for run in holes.iter().filter(|run| matches!(adjoining[run.component()], Adjoining::One(_))) {
        mask[run.row() * width..][run.columns()].fill(1);
    }
}

/// The background that the closed mask separates from the picture's border, as a mask.
fn enclosed(mask: &[u8], width: usize) -> Vec<u8> {
    let mut open = closed(mask, width);
    open.iter_mut().for_each(|v| *v = 1 - *v);
    let height = mask.len() / width.max(1);
    let (runs, count) = components(&open, width, Touching::Sides);
    let mut outside = vec![false; count];
    for run in &runs {
        let Range { start, end } = run.columns();
        let at_border = run.row() == 0 || run.row() + 1 == height || start == 0 || end == width;
        outside[run.component()] |= at_border;
    }
    let mut holes: Vec<u8> = mask.iter().map(|v| 1 - v).collect();
    for run in runs.iter().filter(|run| outside[run.component()]) {
        holes[run.row() * width..][run.columns()].fill(0);
    }
    holes
}

/// The parts that adjoin a hole.
#[derive(Clone, Copy)]
enum Adjoining {
    None,
    One(u32),
    Several,
}

/// For each of `count` holes, the parts of the mask that its runs touch; a component below `smallest_px` is no part.
fn adjoining_parts(
    mask: &[u8],
    width: usize,
    holes: &[Run],
    count: usize,
    smallest_px: usize,
) -> Vec<Adjoining> {
    let (parts, part_count) = components(mask, width, Touching::Corners);
    let mut areas = vec![0; part_count];
    parts.iter().for_each(|run| areas[run.component()] += run.columns().len());
    let mut part = vec![u32::MAX; mask.len()];
    for run in parts.iter().filter(|run| areas[run.component()] >= smallest_px) {
        part[run.row() * width..][run.columns()].fill(run.component() as u32);
    }
    let height = mask.len() / width;
    let mut adjoining = vec![Adjoining::None; count];
    for run in holes {
        let Range { start, end } = run.columns();
        let adjoining = &mut adjoining[run.component()];
        for row in run.row().saturating_sub(1)..(run.row() + 2).min(height) {
            let around = &part[row * width..][start.saturating_sub(1)..(end + 1).min(width)];
            for &part in around.iter().filter(|&&part| part != u32::MAX) {
                *adjoining = match *adjoining {
                    Adjoining::None => Adjoining::One(part),
                    Adjoining::One(first) if first == part => Adjoining::One(first),
                    _ => Adjoining::Several,
                };
            }
        }
    }
    adjoining
}

/// The morphological closing of a mask of 0 and 1 by a square: gaps too narrow for it are filled, but not those to the
/// picture's border.
fn closed(mask: &[u8], width: usize) -> Vec<u8> {
    let height = mask.len() / width.max(1);
    let dilated = over_square(mask, width, REACH_PX, |a, b| a | b);
    let mut closed = over_square(&dilated, width, REACH_PX, |a, b| a & b);
    for (y, (row, mask)) in
        closed.chunks_exact_mut(width.max(1)).zip(mask.chunks_exact(width.max(1))).enumerate()
    {
        if y < REACH_PX || y + REACH_PX >= height {
            row.copy_from_slice(mask);
        }
        let margin = REACH_PX.min(width);
        row[..margin].copy_from_slice(&mask[..margin]);
        row[width - margin..].copy_from_slice(&mask[width - margin..]);
    }
    closed
}

/// Each pixel joined with all in the square around it, within the picture: dilation by `|`, erosion by `&`.
pub(super) fn over_square(
    mask: &[u8],
    width: usize,
    reach_px: usize,
    join: impl Fn(u8, u8) -> u8 + Copy,
) -> Vec<u8> {
    let mut rows = mask.to_vec();
    for (out, row) in rows.chunks_exact_mut(width.max(1)).zip(mask.chunks_exact(width.max(1))) {
        for reach in 1..=reach_px.min(width.saturating_sub(1)) {
            out[reach..].iter_mut().zip(row).for_each(|(out, &v)| *out = join(*out, v));
            out.iter_mut().zip(&row[reach..]).for_each(|(out, &v)| *out = join(*out, v));
        }
    }
    let mut out = rows.clone();
    for reach in 1..=reach_px {
        let by = (reach * width).min(rows.len());
        out[by..].iter_mut().zip(&rows).for_each(|(out, &v)| *out = join(*out, v));
        out.iter_mut().zip(&rows[by..]).for_each(|(out, &v)| *out = join(*out, v));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `#` stands out, `.` is background, `o` is darker than it.
    fn filled(rows: &[&str]) -> Vec<String> {
        let width = rows[0].len();
        let above = |letter: u8| match letter {
            b'#' => 50.0,
            b'o' => -15.0,
            _ => 0.0,
        };
        let above: Vec<f32> = rows.concat().bytes().map(above).collect();
        let mut mask: Vec<u8> = above.iter().map(|&v| u8::from(v > 12.0)).collect();
        fill_dark_holes(&mut mask, width, &above, 12.0, 12);
        let letters: Vec<u8> = mask.iter().map(|&v| if v == 1 { b'#' } else { b'.' }).collect();
        letters.chunks(width).map(|row| String::from_utf8(row.to_vec()).unwrap()).collect()
    }

    #[test]
    fn a_dark_hole_is_filled_and_an_opening_is_not() {
        let rows = [
            ".........................",
            ".###########.###########.",
            ".###########.###########.",
            ".##ooooooo##.##.......##.",
            ".##ooooooo##.##.......##.",
            ".##ooooooo##.##.......##.",
            ".###########.###########.",
            ".........................",
        ];
        let mut expected = rows.map(str::to_owned);
        expected.iter_mut().for_each(|row| *row = row.replace('o', "#"));
        assert_eq!(filled(&rows), expected);
    }

    #[test]
    fn a_dark_side_behind_a_narrow_gap_is_filled_and_darkness_outside_is_not() {
        let rows = [
            "oooooooooooooooooooooo",
            "oooooooooooooooooooooo",
            "oooo############oooooo",
            "oooo##oooooooo##oooooo",
            "oooo##ooooooooo.oooooo",
            "oooo##oooooooo##oooooo",
            "oooo############oooooo",
            "oooooooooooooooooooooo",
            "oooooooooooooooooooooo",
            "oooooooooooooooooooooo",
        ];
        let seen = filled(&rows);
        assert_eq!(seen[4], "....############......", "{seen:#?}");
        assert_eq!(seen[1], "......................");
        assert_eq!(seen[8], "......................");
    }

    #[test]
    fn a_shadow_between_two_parts_does_not_make_them_one() {
        let rows = [
            "......................",
            "......................",
            "......................",
            "......................",
            "....######ooo######...",
            "....######ooo######...",
            "....######ooo######...",
            "....######ooo######...",
            "......................",
            "......................",
            "......................",
            "......................",
        ];
        let expected = rows.map(|row| row.replace('o', "."));
        assert_eq!(filled(&rows), expected);
    }

    #[test]
    fn closing_fills_gaps_that_are_narrower_than_its_square() {
        let gap = |width: usize| [vec![1; 9], vec![0; width], vec![1; 9]].concat();
        let row = |mask: Vec<u8>, row: usize| mask[row * (mask.len() / 9)..][..mask.len() / 9].to_vec();
        assert_eq!(row(closed(&gap(6).repeat(9), 24), 4), [1; 24]);
        assert_eq!(row(closed(&gap(6).repeat(9), 24), 2), gap(6));
        assert_eq!(row(closed(&gap(7).repeat(9), 25), 4), gap(7));
    }
}
