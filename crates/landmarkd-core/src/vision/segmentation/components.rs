//! Connected components of a mask of 0 and 1: one pass over its runs with union-find.

use std::ops::Range;

use memchr::memchr;

/// Which pixels touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Touching {
    /// Those that share a side.
    Sides,
    /// Those that share a side or a corner.
    Corners,
}

/// Pixels side by side that are all set: no picture has 2³² of them, and a picture of specks has many runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    row: u32,
    start: u32,
    end: u32,
    component: u32,
}

impl Run {
    /// Of no component.
    pub fn new(row: usize, columns: Range<usize>) -> Run {
        Run { row: row as u32, start: columns.start as u32, end: columns.end as u32, component: 0 }
    }

    pub fn row(&self) -> usize {
        self.row as usize
    }

    /// Its columns.
    pub fn columns(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }

    /// The component that it belongs to, from 0.
    pub fn component(&self) -> usize {
        self.component as usize
    }
}

/// The runs of a mask, row by row, each with its component; and how many components there are. They are numbered by
/// their first pixel, row-major.
pub(super) fn components(mask: &[u8], width: usize, touching: Touching) -> (Vec<Run>, usize) {
    // Until the end a run's component is another run of it, or itself.
    let mut runs: Vec<Run> = Vec::new();
    let mut above = 0..0;
    for (row, pixels) in mask.chunks_exact(width.max(1)).enumerate() {
        let first = runs.len();
        let mut candidates = above.clone();
        let mut x = 0;
        while let Some(gap) = memchr(1, &pixels[x..]) {
            let start = x + gap;
            let end = memchr(0, &pixels[start..]).map_or(width, |length| start + length);
            let own = runs.len();
            runs.push(Run { row: row as u32, start: start as u32, end: end as u32, component: own as u32 });
            let reach = usize::from(touching == Touching::Corners);
            while candidates.start < candidates.end {
                let other = runs[candidates.start].columns();
                if other.end + reach <= start {
                    candidates.start += 1;
                    continue;
                }
                if other.start >= end + reach {
                    break;
                }
                unite(&mut runs, candidates.start, own);
                if other.end > end {
                    // It may touch the next run, too.
                    break;
                }
                candidates.start += 1;
            }
            x = end;
        }
        above = first..runs.len();
    }
    // Every run points to an earlier one of its component, the first to itself: from the first on, each finds the
    // number that its forerunner got.
    let mut count = 0;
    for at in 0..runs.len() {
        let before = runs[at].component();
        if before == at {
            runs[at].component = count;
            count += 1;
        } else {
            runs[at].component = runs[before].component;
        }
    }
    (runs, count as usize)
}

/// The runs of the pixels that are kept, each in the component of the run that it is a part of.
pub(super) fn kept(runs: &[Run], kept: &[u8], width: usize) -> Vec<Run> {
    let mut out = Vec::with_capacity(runs.len());
    for run in runs {
        let row = &kept[run.row() * width..][..run.end as usize];
        let mut x = run.start as usize;
        while let Some(gap) = memchr(1, &row[x..]) {
            let start = x + gap;
            let end = memchr(0, &row[start..]).map_or(row.len(), |length| start + length);
            out.push(Run { start: start as u32, end: end as u32, ..*run });
            x = end;
        }
    }
    out
}

/// The number of pixels.
pub(super) fn area_px(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.columns().len()).sum()
}

/// The runs of each component that has any.
pub(super) fn by_component(runs: impl Iterator<Item = Run>, count: usize) -> Vec<Vec<Run>> {
    let mut components = vec![Vec::new(); count];
    runs.for_each(|run| components[run.component()].push(run));
    components.retain(|runs| !runs.is_empty());
    components
}

fn root(runs: &mut [Run], mut at: usize) -> usize {
    while runs[at].component() != at {
        runs[at].component = runs[runs[at].component()].component;
        at = runs[at].component();
    }
    at
}

/// The earlier root becomes the root of both.
fn unite(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (root(runs, a), root(runs, b));
    runs[a.max(b)].component = a.min(b) as u32;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Components of a mask drawn with letters: `.` is not set.
    fn drawn(rows: &[&str], touching: Touching) -> (Vec<String>, usize) {
        let width = rows[0].len();
        let mask: Vec<u8> = rows.concat().bytes().map(|c| u8::from(c != b'.')).collect();
        let (runs, count) = components(&mask, width, touching);
        let mut out = vec![vec![b'.'; width]; rows.len()];
        for run in runs {
            out[run.row()][run.columns()].fill(b'a' + run.component() as u8);
        }
        (out.into_iter().map(|row| String::from_utf8(row).unwrap()).collect(), count)
    }

    #[test]
    fn a_ring_and_what_is_in_it_are_two() {
        let (seen, count) = drawn(&["#####", "#...#", "#.#.#", "#...#", "#####"], Touching::Corners);
        assert_eq!(
            (seen, count),
            (["aaaaa", "a...a", "a.b.a", "a...a", "aaaaa"].map(String::from).to_vec(), 2)
        );
    }

    #[test]
    fn corners_connect_or_not() {
        let rows = ["#.#.", ".#..", "#..#"];
        assert_eq!(drawn(&rows, Touching::Corners).1, 2);
        assert_eq!(drawn(&rows, Touching::Sides).1, 5);
    }

    #[test]
    fn branches_that_meet_late_are_one() {
        let (seen, count) = drawn(&["#.#.#.#", "#.#.#.#", "#.###.#", "#.....#", "#######"], Touching::Sides);
        assert_eq!(count, 2);
        assert_eq!(seen[2], "a.bbb.a");
        assert_eq!(seen[0], "a.b.b.a");
    }

    #[test]
    fn it_agrees_with_filling_from_every_pixel() {
        let (width, height) = (40, 30);
        for (seed, touching) in [(3, Touching::Sides), (5, Touching::Corners), (7, Touching::Corners)] {
            let set = |at: usize| (at * at * seed + at * 31 + at / width * 17) % 5 < 3;
            let mask: Vec<u8> = (0..width * height).map(|at| u8::from(set(at))).collect();
            let (runs, count) = components(&mask, width, touching);
            let mut number = vec![usize::MAX; width * height];
            let mut filled = 0;
            for first in 0..mask.len() {
                if mask[first] == 0 || number[first] != usize::MAX {
                    continue;
                }
                let mut waiting = vec![first];
                while let Some(at) = waiting.pop() {
                    if number[at] != usize::MAX {
                        continue;
                    }
                    number[at] = filled;
                    let touches = |k: &usize| {
                        let (dx, dy) = ((k % width).abs_diff(at % width), (k / width).abs_diff(at / width));
                        dx.max(dy) == 1 && (touching == Touching::Corners || dx + dy == 1)
                    };
                    waiting.extend((0..mask.len()).filter(touches).filter(|&k| mask[k] == 1));
                }
                filled += 1;
            }
            assert_eq!(count, filled, "seed {seed}");
            for run in runs {
                for x in run.columns() {
                    assert_eq!(number[run.row() * width + x], run.component(), "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn nothing_has_no_component() {
        assert_eq!(components(&[], 0, Touching::Sides), (vec![], 0));
        assert_eq!(components(&[0; 6], 3, Touching::Sides), (vec![], 0));
    }
}
