//! Parts that touch: a component whose depth has several peaks with narrow necks between them (watershed of the distance map,
//! Vincent & Soille 1991) is divided by the shortest chords across the necks, if the pieces are convex.
//!
//! Two discs that touch are two convex pieces with a narrow neck; a spanner's halves are not convex. Where the neck isn't
//! narrow, or a piece not quite convex, shape alone doesn't say whether there are one or several.

use std::f64::consts::PI;

use super::components::{Run, area_px};
use super::distance_map::{DistanceMap, ONE_PX};
use super::region::Sums;

/// A component of at least this solidity is one part.
const CONVEX: f64 = 0.95;
/// Two peaks with a neck of at least this part of the lower one are one.
const WIDEST_NECK: f64 = 0.8;
/// Pieces of a clear division: the broadest neck, and the least solidity.
const CLEAR_NECK: f64 = 0.64;
const CLEAR_SOLIDITY: f64 = 0.93;
/// And the highest solidity of the whole, and of two the highest elongation: the blades of a propeller are one part.
const CLEAR_WHOLE: f64 = 0.93;
const CLEAR_ELONGATION: f64 = 3.0;
/// Pieces that may be parts have at least this solidity, this part of the largest one's area, and this depth.
const LEAST_SOLIDITY: f64 = 0.88;
const LEAST_PART: f64 = 0.12;
const LEAST_DEPTH: u16 = 4 * ONE_PX;

/// Directions in which the shortest chord across a neck is sought.
const CHORDS: usize = 36;
/// Larger components are taken for one part: a division takes 40 bytes a pixel.
const MOST_PX: usize = 4 << 20;

/// What a component may be.
pub(super) enum Reading {
    /// One part.
    One,
    /// Several, divided.
    Several(Vec<Vec<Run>>),
    /// One, or these.
    Unclear(Vec<Vec<Run>>),
}

/// Whether a component is one part or several.
pub(super) fn reading(runs: &[Run]) -> Reading {
    let whole = solidity(runs);
    if whole >= CONVEX || area_px(runs) > MOST_PX {
        return Reading::One;
    }
    let map = DistanceMap::of(runs);
    let Division { pieces, numbers, widest_neck } = Basins::of(&map).division(&map);
    if pieces < 2 {
        return Reading::One;
    }
    let pieces = map.runs(&numbers, pieces);
    let least = pieces.iter().map(|runs| solidity(runs)).fold(1.0, f64::min);
    let is_clear = least >= CLEAR_SOLIDITY
        && whole <= CLEAR_WHOLE
        && widest_neck <= CLEAR_NECK
        && (pieces.len() > 2 || Sums::of(runs).elongation() <= CLEAR_ELONGATION);
    if is_clear {
        Reading::Several(pieces)
    } else if least >= LEAST_SOLIDITY {
        Reading::Unclear(pieces)
    } else {
        Reading::One
    }
}

/// The pixels of a component by those of its convex hull, 1 for a convex one: the hull's by the theorem of Pick.
pub(super) fn solidity(runs: &[Run]) -> f64 {
    let mut points: Vec<[i64; 2]> = runs
        .iter()
        .flat_map(|run| [run.columns().start, run.columns().end - 1].map(|x| [run.row() as i64, x as i64]))
        .collect();
    points.sort_unstable();
    points.dedup();
    let turn =
        |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let chain = |points: &mut dyn Iterator<Item = [i64; 2]>| {
        let mut hull: Vec<[i64; 2]> = Vec::new();
        for point in points {
            while hull.len() >= 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0 {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    let (mut doubled, mut boundary) = (0, 0);
    for (k, a) in hull.iter().enumerate() {
        let b = hull[(k + 1) % hull.len()];
        doubled += a[0] * b[1] - a[1] * b[0];
        boundary += greatest_common_divisor((a[0] - b[0]).abs(), (a[1] - b[1]).abs());
    }
    area_px(runs) as f64 / (doubled.abs() + boundary + 2).max(2) as f64 * 2.0
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// The catchment basins of a component's depth.
struct Basins {
    /// The basin of each pixel of the map.
    basin: Vec<u32>,
    peaks: Vec<u16>,
    areas: Vec<usize>,
    /// The basin that each belongs to, or itself.
    joined: Vec<usize>,
    necks: Vec<Neck>,
}

/// Where two basins meet that were kept apart.
#[derive(Clone, Copy)]
struct Neck {
    basins: [usize; 2],
    /// The deepest pixel that touches both, and its depth.
    at: usize,
    depth: u16,
}

/// A division into pieces.
struct Division {
    pieces: usize,
    /// The piece of each pixel of the map, [`u32::MAX`] outside.
    numbers: Vec<u32>,
    /// The widest neck by the lower peak beside it.
    widest_neck: f64,
}

const NONE: u32 = u32::MAX;

impl Basins {
    /// Pixel by pixel from the deepest on, each to the basin that it touches; where two meet, they are joined unless the
    /// neck is narrow.
    fn of(map: &DistanceMap) -> Basins {
        let deepest = map.thirds.iter().copied().max().unwrap_or(0);
        let mut by_depth = vec![Vec::new(); usize::from(deepest) + 1];
        for (at, &depth) in map.thirds.iter().enumerate().filter(|(_, depth)| **depth > 0) {
            by_depth[usize::from(depth)].push(at);
        }
        let mut basins = Basins {
            basin: vec![NONE; map.thirds.len()],
            peaks: vec![],
            areas: vec![],
            joined: vec![],
            necks: vec![],
        };
        let width = map.width;
        for pixels in by_depth.iter().rev() {
            for &at in pixels {
                let depth = map.thirds[at];
                let mut own = None;
                for other in around(at, width) {
                    if basins.basin[other] == NONE {
                        continue;
                    }
                    let other = basins.root(basins.basin[other] as usize);
                    own = Some(match own {
                        Some(own) if own != other => basins.meet(own, other, at, depth),
                        _ => other,
                    });
                }
                let own = own.unwrap_or_else(|| {
                    basins.peaks.push(depth);
                    basins.areas.push(0);
                    basins.joined.push(basins.joined.len());
                    basins.joined.len() - 1
                });
                basins.basin[at] = own as u32;
                basins.areas[own] += 1;
            }
        }
        basins
    }

    fn root(&self, mut basin: usize) -> usize {
        while self.joined[basin] != basin {
            basin = self.joined[basin];
        }
        basin
    }

    /// Two basins meet at a depth: the one that a pixel there belongs to.
    fn meet(&mut self, a: usize, b: usize, at: usize, depth: u16) -> usize {
        let (high, low) = if self.peaks[a] >= self.peaks[b] { (a, b) } else { (b, a) };
        let are_apart = self.necks.iter().any(|neck| {
            let pair = self.roots_of(neck);
            pair == [a, b] || pair == [b, a]
        });
        if are_apart {
            return a;
        }
        let peak = self.peaks[low];
        if peak >= depth + ONE_PX && peak >= LEAST_DEPTH && f64::from(depth) <= WIDEST_NECK * f64::from(peak)
        {
            self.necks.push(Neck { basins: [a, b], at, depth });
            return a;
        }
        self.join(low, high);
        high
    }

    fn join(&mut self, basin: usize, to: usize) {
        self.joined[basin] = to;
        self.peaks[to] = self.peaks[to].max(self.peaks[basin]);
        self.areas[to] += self.areas[basin];
    }

    fn roots_of(&self, neck: &Neck) -> [usize; 2] {
        neck.basins.map(|basin| self.root(basin))
    }

    fn roots(&self) -> Vec<usize> {
        (0..self.joined.len()).filter(|&basin| self.joined[basin] == basin).collect()
    }

    /// The basins that are large enough to be parts, the others joined to what they adjoin.
    fn division(mut self, map: &DistanceMap) -> Division {
        loop {
            let roots = self.roots();
            let area = |basin: &usize| self.areas[*basin];
            let Some(largest) = roots.iter().copied().max_by_key(area) else { break };
            let Some(least) = roots.into_iter().min_by_key(area) else { break };
            if self.areas[least] as f64 >= LEAST_PART * self.areas[largest] as f64 {
                break;
            }
            // The widest neck of it leads to what it is a piece of; what has none lies beside the component.
            let beside = self.necks.iter().filter_map(|neck| {
                let [a, b] = self.roots_of(neck);
                let other = if a == least { b } else { a };
                ((a == least) != (b == least)).then_some((neck.depth, other))
            });
            let to = beside.max().map_or(largest, |(_, to)| to);
            self.join(least, to);
        }
        let kept = self.roots();
        let number = |basin: &u32| match *basin {
            NONE => NONE,
            basin => {
                let root = self.root(basin as usize);
                kept.iter().position(|&kept| kept == root).map_or(NONE, |number| number as u32)
            }
        };
        let basins: Vec<u32> = self.basin.iter().map(number).collect();
        let necks = self.necks.iter().filter(|neck| self.roots_of(neck)[0] != self.roots_of(neck)[1]);
        let width = |neck: &Neck| {
            f64::from(neck.depth)
                / f64::from(self.roots_of(neck).map(|root| self.peaks[root]).into_iter().min().unwrap_or(1))
        };
        let chords: Vec<Vec<usize>> = necks.clone().map(|neck| shortest_chord(map, neck.at)).collect();
        Division {
            pieces: kept.len(),
            widest_neck: necks.map(width).fold(0.0, f64::max),
            numbers: divided(map.width, &basins, &chords.concat(), kept.len()),
        }
    }
}

/// The pixels of the shortest straight line through a pixel from one side of the component to the other.
fn shortest_chord(map: &DistanceMap, at: usize) -> Vec<usize> {
    let (x, y) = ((at % map.width) as f64, (at / map.width) as f64);
    let half = |angle_rad: f64| {
        let (sin, cos) = angle_rad.sin_cos();
        // The map has a margin, so that every line leaves the component within it.
        let place = move |step: usize| {
            let length = 0.5 * step as f64;
            (y + length * sin).round() as usize * map.width + (x + length * cos).round() as usize
        };
        (0..).map(place).take_while(|&at| map.thirds[at] > 0)
    };
    let lines = (0..CHORDS).map(|k| PI * k as f64 / CHORDS as f64);
    let length = |angle_rad: &f64| half(*angle_rad).count() + half(angle_rad + PI).count();
    let shortest = lines.min_by_key(length).unwrap_or(0.0);
    half(shortest).chain(half(shortest + PI)).collect()
}

/// The piece of each pixel: what hangs together by the sides of pixels without crossing a chord. A piece is the largest of
/// those of which most is of its basin; if one has none, the chords don't divide, and the basins are the pieces. What is left,
/// the chords too, belongs to what it touches.
fn divided(width: usize, basins: &[u32], chords: &[usize], pieces: usize) -> Vec<u32> {
    if pieces < 2 {
        return basins.to_vec();
    }
    let mut free: Vec<bool> = basins.iter().map(|&basin| basin != NONE).collect();
    chords.iter().for_each(|&at| free[at] = false);
    let mut largest: Vec<Vec<usize>> = vec![vec![]; pieces];
    let mut rest = chords.to_vec();
    for first in 0..free.len() {
        if !std::mem::take(&mut free[first]) {
            continue;
        }
        let (mut members, mut next, mut votes) = (vec![first], 0, vec![0; pieces]);
        while let Some(&at) = members.get(next) {
            next += 1;
            votes[basins[at] as usize] += 1;
            for other in [at - 1, at + 1, at - width, at + width] {
                if std::mem::take(&mut free[other]) {
                    members.push(other);
                }
            }
        }
        let piece = (0..pieces).max_by_key(|&piece| votes[piece]).unwrap_or(0);
        if members.len() > largest[piece].len() {
            std::mem::swap(&mut members, &mut largest[piece]);
        }
        rest.extend(members);
    }
    if largest.iter().any(Vec::is_empty) {
        return basins.to_vec();
    }
    let mut numbers = vec![NONE; basins.len()];
    for (piece, members) in largest.iter().enumerate() {
        members.iter().for_each(|&at| numbers[at] = piece as u32);
    }
    // From the pixels that touch a piece on, ring by ring.
    let mut is_left = vec![false; basins.len()];
    rest.iter().for_each(|&at| is_left[at] = true);
    let mut ring: Vec<usize> =
        rest.into_iter().flat_map(|at| around(at, width)).filter(|&at| numbers[at] != NONE).collect();
    while !ring.is_empty() {
        let mut next = vec![];
        for at in ring {
            for other in around(at, width) {
                if std::mem::take(&mut is_left[other]) {
                    numbers[other] = numbers[at];
                    next.push(other);
                }
            }
        }
        ring = next;
    }
    numbers
}

/// The eight neighbours of a pixel.
fn around(at: usize, width: usize) -> [usize; 8] {
    let (above, below) = (at - width, at + width);
    [at - 1, at + 1, above, below, above - 1, above + 1, below - 1, below + 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::segmentation::components::{Touching, components};

    const WIDTH: usize = 160;

    fn runs(is_inside: impl Fn(f64, f64) -> bool) -> Vec<Run> {
        let inside = |at: usize| is_inside((at % WIDTH) as f64, (at / WIDTH) as f64);
        let mask: Vec<u8> = (0..WIDTH * 120).map(|at| u8::from(inside(at))).collect();
        let (runs, count) = components(&mask, WIDTH, Touching::Corners);
        assert_eq!(count, 1);
        runs
    }

    fn disc(x: f64, y: f64, radius: f64) -> impl Fn(f64, f64) -> bool {
        move |at_x, at_y| (at_x - x).hypot(at_y - y) <= radius
    }

    /// The areas of the pieces.
    fn areas(pieces: &[Vec<Run>]) -> Vec<usize> {
        pieces.iter().map(|runs| area_px(runs)).collect()
    }

    #[test]
    fn discs_that_touch_are_divided_at_the_neck() {
        let (a, b, c) = (disc(40.0, 50.0, 22.0), disc(79.0, 55.0, 18.0), disc(110.0, 75.0, 20.0));
        let seen = reading(&runs(|x, y| a(x, y) || b(x, y) || c(x, y)));
        let Reading::Several(pieces) = seen else { panic!("not divided") };
        let mut areas = areas(&pieces);
        areas.sort_unstable();
        for (area, radius) in areas.iter().zip([18.0_f64, 20.0, 22.0]) {
            let expected = std::f64::consts::PI * radius * radius;
            assert!((*area as f64 / expected - 1.0).abs() < 0.04, "{areas:?}");
        }
    }

    #[test]
    fn convex_hollow_and_branched_parts_are_one() {
        let shapes: [Box<dyn Fn(f64, f64) -> bool>; 5] = [
            Box::new(disc(60.0, 60.0, 30.0)),
            Box::new(|x, y| (20.0..140.0).contains(&x) && (50.0..62.0).contains(&y)),
            Box::new(|x, y| (20.0..46.0).contains(&(x - 70.0).hypot(y - 60.0))),
            Box::new(|x, y| {
                (20.0..130.0).contains(&x) && (20.0..36.0).contains(&y)
                    || (20.0..36.0).contains(&x) && (20.0..100.0).contains(&y)
            }),
            // A spanner.
            Box::new(|x, y| {
                disc(30.0, 60.0, 18.0)(x, y)
                    || disc(130.0, 60.0, 18.0)(x, y)
                    || (30.0..130.0).contains(&x) && (53.0..67.0).contains(&y)
            }),
        ];
        for (k, shape) in shapes.iter().enumerate() {
            assert!(matches!(reading(&runs(shape)), Reading::One), "{k}");
        }
    }

    #[test]
    fn a_broad_neck_leaves_both_readings() {
        let (a, b) = (disc(50.0, 60.0, 30.0), disc(98.0, 60.0, 30.0));
        let seen = reading(&runs(|x, y| a(x, y) || b(x, y)));
        let Reading::Unclear(pieces) = seen else { panic!("it was clear") };
        assert_eq!(pieces.len(), 2);
    }

    #[test]
    fn solidity_is_one_for_digital_convex_sets() {
        for radius in [3.0, 7.5, 30.0] {
            assert!((solidity(&runs(disc(60.0, 60.0, radius))) - 1.0).abs() < 1e-12);
        }
        assert_eq!(solidity(&[Run::new(3, 5..6)]), 1.0);
        assert_eq!(solidity(&[Run::new(3, 5..9)]), 1.0);
        let angle =
            runs(|x, y| (0.0..60.0).contains(&x) && (0.0..60.0).contains(&y) && (x < 30.0 || y < 30.0));
        assert!((solidity(&angle) - 0.857).abs() < 0.01, "{}", solidity(&angle));
    }
}
