//! Interest points: the strongest local maxima of an attention map (A§4.2).
//!
//! A pixel is a maximum if nothing in the (2·3 + 1)² pixels about it is higher; of equal ones within that
//! reach only the first in reading order (row by row) stays, so that a plateau gives one point.

use pulp::{Arch, Simd, WithSimd};

use crate::imaging::Image;

/// How far a maximum reaches, to each side.
const SEPARATION_PX: usize = 3;
/// Maxima at or below this are noise of a flat picture.
const LEAST_SALIENCE: f32 = 1e-3;
/// Pixels and rows that a maximum is compared with, itself among them.
const REACH_PX: usize = 2 * SEPARATION_PX + 1;
/// Pixels of a row that are tested together for peaks, as peaks are few.
const TILE_PX: usize = 32;

/// A local maximum of an attention map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterestPoint {
    /// Column, a whole number.
    pub x_px: f32,
    /// Row, a whole number.
    pub y_px: f32,
    /// The attention map's value there, > 0.001.
    pub salience: f32,
}

/// All local maxima above 0.001, strongest first, equal ones in reading order.
pub fn interest_points(map: &Image) -> Vec<InterestPoint> {
    let (width, height) = (map.width(), map.height());
    if width == 0 || height == 0 {
        return Vec::new();
    }
    // the rows within reach, each pixel the highest along x
    let mut across = vec![0.0; REACH_PX * width];
    let mut padded = vec![f32::NEG_INFINITY; width + 2 * SEPARATION_PX];
    let mut highest = vec![0.0; width];
    let mut next = 0;
    let mut points = Vec::new();
    for y in 0..height {
        while next < height.min(y + SEPARATION_PX + 1) {
            padded[SEPARATION_PX..][..width].copy_from_slice(map.row(next));
            let rows = std::array::from_fn(|shift| &padded[shift..]);
            Arch::new().dispatch(Highest { out: &mut across[next % REACH_PX * width..][..width], rows });
            next += 1;
        }
        // at the border, one of the rows that exist again
        let row = |shift: usize| (y + shift).saturating_sub(SEPARATION_PX).min(height - 1);
        let rows = std::array::from_fn(|shift| &across[row(shift) % REACH_PX * width..]);
        Arch::new().dispatch(Highest { out: &mut highest, rows });
        let peaks = peaks(map.row(y), &highest).filter(|&x| !follows_an_equal(map, x, y));
        points.extend(peaks.map(|x| InterestPoint {
            x_px: x as f32,
            y_px: y as f32,
            salience: map.at(x, y),
        }));
    }
    points.sort_by(|a, b| b.salience.total_cmp(&a.salience)); // stable: equal ones stay in reading order
    points
}

/// Columns of a row that are as high as the highest within reach, and salient.
fn peaks(row: &[f32], highest: &[f32]) -> impl Iterator<Item = usize> {
    let is_peak = |(salience, highest): (&f32, &f32)| salience >= highest && *salience > LEAST_SALIENCE;
    let tiles = row.chunks(TILE_PX).zip(highest.chunks(TILE_PX)).enumerate();
    // counting without a branch rules out most tiles
    let count = move |row: &[f32], highest: &[f32]| -> u32 {
        row.iter().zip(highest).map(|pair| u32::from(is_peak(pair))).sum()
    };
    tiles.filter(move |(_, (row, highest))| count(row, highest) > 0).flat_map(
        move |(tile, (row, highest))| {
            let columns = (tile * TILE_PX..).zip(row.iter().zip(highest));
            columns.filter(move |(_, pair)| is_peak(*pair)).map(|(x, _)| x)
        },
    )
}

/// The points in another order (bucketing): the first of every cell of a grid of `cell_px`, then the second of every
/// cell, and so on; points of the same rank keep their order.
pub fn bucketed(points: &[InterestPoint], cell_px: usize) -> Vec<InterestPoint> {
    let cell = |point: &InterestPoint| (point.x_px as usize / cell_px, point.y_px as usize / cell_px);
    let (columns, rows) =
        points.iter().map(cell).fold((0, 0), |(x, y), (sx, sy)| (x.max(sx + 1), y.max(sy + 1)));
    let mut counts = vec![0_usize; columns * rows];
    let mut ranked: Vec<(usize, InterestPoint)> = points
        .iter()
        .map(|point| {
            let (x, y) = cell(point);
            let count = &mut counts[y * columns + x];
            *count += 1;
            (*count, *point)
        })
        .collect();
    ranked.sort_by_key(|(rank, _)| *rank); // stable
    ranked.into_iter().map(|(_, point)| point).collect()
}

/// Whether an equally high pixel within reach comes before (x, y) in reading order.
fn follows_an_equal(map: &Image, x: usize, y: usize) -> bool {
    let here = map.at(x, y);
    let (left, right) = (x.saturating_sub(SEPARATION_PX), (x + SEPARATION_PX).min(map.width() - 1));
    (y.saturating_sub(SEPARATION_PX)..=y).any(|row| {
        let end = if row == y { x } else { right + 1 };
        map.row(row)[left..end].contains(&here)
    })
}

/// `out` = the highest of the rows, column by column.
struct Highest<'a> {
    out: &'a mut [f32],
    rows: [&'a [f32]; REACH_PX],
}

impl WithSimd for Highest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let length = self.out.len();
        let [a, b, c, d, e, f, g] = self.rows.map(|row| &row[..length]);
        for p in 0..length {
            let higher = |a: f32, b: f32| if a > b { a } else { b };
            let (ab, cd, ef) = (higher(a[p], b[p]), higher(c[p], d[p]), higher(e[p], f[p]));
            self.out[p] = higher(higher(ab, cd), higher(ef, g[p]));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn map(rows: &[&str]) -> Image {
        let digit = |x: usize, y: usize| f32::from(rows[y].as_bytes()[x] - b'0');
        Image::from_fn(rows[0].len(), rows.len(), digit)
    }

    fn places(map: &Image) -> Vec<(usize, usize)> {
        interest_points(map).iter().map(|p| (p.x_px as usize, p.y_px as usize)).collect()
    }

    #[test]
    fn maxima_come_strongest_first() {
        let map = map(&[
            "000000000000", //
            "010000000030", //
            "000000000000", //
            "000002000000", //
        ]);
        assert_eq!(places(&map), [(10, 1), (5, 3), (1, 1)]);
    }

    #[test]
    fn a_lower_peak_within_three_pixels_is_no_point() {
        assert_eq!(places(&map(&["050040000"])), [(1, 0)]);
        assert_eq!(places(&map(&["050004000"])), [(1, 0), (5, 0)]);
    }

    #[test]
    fn a_plateau_gives_its_first_pixel_in_reading_order() {
        let map = map(&[
            "000000000", //
            "000550000", //
            "000550000", //
            "000000000", //
        ]);
        assert_eq!(places(&map), [(3, 1)]);
    }

    #[test]
    fn a_flat_map_has_no_points() {
        assert!(interest_points(&Image::from_fn(20, 20, |_, _| 0.0)).is_empty());
        assert!(interest_points(&Image::from_fn(20, 20, |_, _| 1e-3)).is_empty());
    }

    proptest! {
        #[test]
        fn points_are_exactly_the_maxima(
            (width, height, levels) in (1usize..30, 1usize..12).prop_flat_map(|(width, height)| {
                (Just(width), Just(height), prop::collection::vec(0u8..6, width * height))
            }),
        ) {
            let map = Image::new(width, height, levels.into_iter().map(f32::from).collect());
            let mut expected = Vec::new();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let here = map.at(x, y);
                let beats = |(u, v): (usize, usize)| {
                    let far = u.abs_diff(x) > 3 || v.abs_diff(y) > 3;
                    far || here > map.at(u, v) || (here == map.at(u, v) && (y, x) <= (v, u))
                };
                if here > 0.0 && (0..height).all(|v| (0..width).all(|u| beats((u, v)))) {
                    expected.push((x, y));
                }
            }
            expected.sort_by(|a, b| map.at(b.0, b.1).total_cmp(&map.at(a.0, a.1)));
            prop_assert_eq!(places(&map), expected);
        }
    }

    #[test]
    fn all_of_a_picture_is_looked_at_before_a_part_of_it_twice() {
        let point = |x_px: f32, salience: f32| InterestPoint { x_px, y_px: 5.0, salience };
        let points = [point(1.0, 9.0), point(7.0, 8.0), point(20.0, 3.0), point(9.0, 2.0), point(30.0, 1.0)];
        let order: Vec<f32> = bucketed(&points, 10).iter().map(|p| p.x_px).collect();
        assert_eq!(order, [1.0, 20.0, 30.0, 7.0, 9.0]);
        assert_eq!(bucketed(&[], 10), []);
    }
}
