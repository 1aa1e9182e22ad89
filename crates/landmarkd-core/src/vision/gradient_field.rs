//! Orientation histograms of the gradient at any place of a picture, and the appearance that they make: cells of 8 × 8 px, 8
//! soft directions each, divided by the energy about the cell (HOG, Dalal and Triggs 2005), the whole of length one.
//!
//! Histograms stand at knots, 4 px apart, and are interpolated between them, so that the appearance of a shifted, scaled
//! or turned object is read from the picture as it is: no picture is warped. Brightness, contrast and an offset drop
//! out, and light that changes slowly across the picture nearly.
//!
//! An appearance is laid out cell by cell, row-major, [`DIRECTIONS`] numbers each; with colour, two more a cell follow all of
//! those: the opponent planes over the luminance.

use std::array::from_fn;

use pulp::{Arch, Simd, WithSimd};

use super::gradient::gradient;
use super::smoothing::{mirrored, smoothed};
use crate::imaging::{Frame, Image};

/// Soft bins of the gradient's direction.
pub const DIRECTIONS: usize = 8;
/// Opponent planes.
pub const OPPONENTS: usize = 2;
/// Side of a cell.
pub const CELL_PX: usize = 8;
/// Distance between knots.
const KNOT_PX: usize = 4;
/// Standard deviation of the window that a histogram is taken in, where as much as cells can show is to be told apart.
pub const WINDOW_PX: f64 = 0.6 * CELL_PX as f64;
/// Standard deviation of the surround, in cells, whose energy a cell is divided by …
const SURROUND_CELLS: f64 = 1.0;
/// … with this part of the picture's strongest gradient, so that noise on a bare ground stays small.
const NOISE_PART: f32 = 0.02;
/// Gray levels that are added to a luminance before it divides: the colour of what is black is noise.
const BLACK: f32 = 24.0;
/// Weight of the opponent planes beside the histograms.
const COLOUR_WEIGHT: f32 = 0.5;

/// Where an object stands in a picture, relative to where it stood when it was learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Shift to the right of the picture's middle, px.
    pub x_px: f64,
    /// Shift down.
    pub y_px: f64,
    /// Size here over size there.
    pub scale: f64,
    /// Turn in the picture's plane, clockwise as seen, radians.
    pub turn_rad: f64,
}

impl Similarity {
    /// As it was learnt.
    pub const IDENTITY: Similarity = Similarity { x_px: 0.0, y_px: 0.0, scale: 1.0, turn_rad: 0.0 };
}

/// The histograms of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct GradientField {
    width_px: usize,
    height_px: usize,
    /// Knots along a row.
    columns: usize,
    rows: usize,
    histograms: Vec<[f32; DIRECTIONS]>,
    /// Opponent planes over the luminance; empty for a gray picture.
    colours: Vec<[f32; OPPONENTS]>,
    /// Length of the strongest gradient.
    strongest: f32,
}

/// Cells along the two sides of a picture, at least one.
pub fn cells(width_px: usize, height_px: usize) -> [usize; 2] {
    [width_px, height_px].map(|side| (side / CELL_PX).max(1))
}

impl GradientField {
    /// The field of a picture of at least [`CELL_PX`] a side, smoothed by a Gaussian of `sigma_px` before its gradient is taken.
    /// Histograms are of a Gaussian window of `window_px`, [`KNOT_PX`] at least.
    pub fn of(frame: &Frame, sigma_px: f32, window_px: f64) -> GradientField {
        let (width_px, height_px) = (frame.width(), frame.height());
        let [columns, rows] = [width_px, height_px].map(|side| side / KNOT_PX);
        let gradient = gradient(&smoothed(&frame.luminance, sigma_px));
        let mut sums = vec![[0.0_f32; DIRECTIONS]; columns * rows];
        let mut strongest = 0.0_f32;
        for y in 0..rows * KNOT_PX {
            let knots = &mut sums[y / KNOT_PX * columns..][..columns];
            let pixels = gradient.x.row(y).iter().zip(gradient.y.row(y)).take(columns * KNOT_PX);
            for (x, (&dx, &dy)) in pixels.enumerate() {
                strongest = strongest.max(dx * dx + dy * dy);
                add_softly(&mut knots[x / KNOT_PX], dx, dy);
            }
        }
        let area = (KNOT_PX * KNOT_PX) as f32;
        sums.iter_mut().flatten().for_each(|sum| *sum /= area);
        GradientField {
            width_px,
            height_px,
            columns,
            rows,
            histograms: windowed(sums, columns, rows, window_px),
            colours: if frame.is_colour() { colours(frame, columns, rows, window_px) } else { Vec::new() },
            strongest: strongest.sqrt(),
        }
    }

    /// Whether the picture was in colour.
    pub fn is_colour(&self) -> bool {
        !self.colours.is_empty()
    }

    /// Length of the strongest gradient, gray levels per pixel.
    pub fn strongest(&self) -> f32 {
        self.strongest
    }

    /// The appearance of an object that stands at `place`. `opponents` is what a gray picture's opponent planes are taken
    /// for, two numbers a cell; without them the histograms are all. Zero for a flat picture.
    pub fn appearance(&self, place: &Similarity, opponents: &[f32]) -> Vec<f32> {
        let [columns, rows] = cells(self.width_px, self.height_px);
        let positions: Vec<Knots> = self.positions(place).collect();
        let mut appearance = Vec::with_capacity(columns * rows * (DIRECTIONS + OPPONENTS));
        appearance.resize(columns * rows * DIRECTIONS, 0.0);
        let (cells, _) = appearance.as_chunks_mut::<DIRECTIONS>();
        let turned = Turned::by(place.turn_rad);
        let mut energies = vec![0.0; cells.len()];
        let field = &self.histograms;
        Arch::new().dispatch(Read { field, positions: &positions, turned, cells, energies: &mut energies });
        let surround = smoothed(&Image::new(columns, rows, energies), SURROUND_CELLS as f32);
        let least = NOISE_PART * self.strongest + f32::MIN_POSITIVE;
        Arch::new().dispatch(Normalise { cells, surround: surround.pixels(), least });
        if self.is_colour() && !opponents.is_empty() {
            // A cell of a picture whose cells are all alike has this length.
            let unit = COLOUR_WEIGHT / ((columns * rows) as f32).sqrt();
            appearance.extend(positions.iter().flat_map(|at| at.between(&self.colours).map(|v| unit * v)));
        } else {
            appearance.extend_from_slice(opponents);
        }
        appearance
    }

    /// Where the middles of the cells of an object at `place` lie among the knots, row by row.
    fn positions(&self, place: &Similarity) -> impl Iterator<Item = Knots> + Clone + use<> {
        let [columns, rows] = cells(self.width_px, self.height_px);
        let middle = [self.width_px, self.height_px].map(|side| (side as f64 - 1.0) / 2.0);
        let (sin, cos) = place.turn_rad.sin_cos();
        let (along, across) = (place.scale * cos, place.scale * sin);
        let offset =
            |index: usize, count: usize| CELL_PX as f64 * (index as f64 - (count as f64 - 1.0) / 2.0);
        let knot = |px: f64, count: usize| {
            let at = (px - (KNOT_PX as f64 - 1.0) / 2.0) / KNOT_PX as f64;
            at.clamp(0.0, count as f64 - 1.0) as f32
        };
        let (x_px, y_px) = (place.x_px + middle[0], place.y_px + middle[1]);
        let (knot_columns, knot_rows) = (self.columns, self.rows);
        (0..rows).flat_map(move |row| {
            let down = offset(row, rows);
            (0..columns).map(move |column| {
                let right = offset(column, columns);
                let x = knot(x_px + along * right - across * down, knot_columns);
                let y = knot(y_px + across * right + along * down, knot_rows);
                Knots::about(x, y, knot_columns, knot_rows)
            })
        })
    }
}

/// Histograms at their positions, and the energy of each.
struct Read<'a> {
    field: &'a [[f32; DIRECTIONS]],
    positions: &'a [Knots],
    turned: Turned,
    cells: &'a mut [[f32; DIRECTIONS]],
    energies: &'a mut [f32],
}

impl WithSimd for Read<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for ((cell, energy), at) in self.cells.iter_mut().zip(self.energies).zip(self.positions) {
            *cell = self.turned.histogram(at.between(self.field));
            *energy = cell.iter().map(|v| v * v).sum();
        }
    }
}

/// Each cell over the root of the energy about it, then all at length one.
struct Normalise<'a> {
    cells: &'a mut [[f32; DIRECTIONS]],
    surround: &'a [f32],
    least: f32,
}

impl WithSimd for Normalise<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let mut squares = [0.0_f32; DIRECTIONS];
        for (cell, energy) in self.cells.iter_mut().zip(self.surround) {
            let share = 1.0 / (energy.max(0.0).sqrt() + self.least);
            for k in 0..DIRECTIONS {
                cell[k] *= share;
                squares[k] += cell[k] * cell[k];
            }
        }
        let energy: f32 = squares.iter().sum();
        let scale = if energy > 0.0 { 1.0 / energy.sqrt() } else { 0.0 };
        self.cells.as_flattened_mut().iter_mut().for_each(|v| *v *= scale);
    }
}

/// Adds the length of a gradient to the two directions that are next to its own.
#[inline(always)]
fn add_softly(histogram: &mut [f32; DIRECTIONS], dx: f32, dy: f32) {
    let (across, down) = (dx.abs(), dy.abs());
    let (least, most) = (across.min(down), across.max(down));
    if most == 0.0 {
        return;
    }
    // arctan(t) over an eighth of the circle, to within 0.3°
    let t = least / most;
    let octant = t * (1.0 + 0.3476 * (1.0 - t));
    let quadrant = if down > across { 2.0 - octant } else { octant };
    let half = if dx < 0.0 { 4.0 - quadrant } else { quadrant };
    let direction = if dy < 0.0 { DIRECTIONS as f32 - half } else { half };
    let length = (dx * dx + dy * dy).sqrt();
    let low = direction as usize;
    let upper = length * (direction - low as f32);
    histogram[low % DIRECTIONS] += length - upper;
    histogram[(low + 1) % DIRECTIONS] += upper;
}

/// The opponent planes over the luminance, at the knots.
fn colours(frame: &Frame, columns: usize, rows: usize, window_px: f64) -> Vec<[f32; OPPONENTS]> {
    let [red_green, blue_yellow] = frame.opponent_planes();
    let mut sums = vec![[0.0_f32; OPPONENTS + 1]; columns * rows];
    for y in 0..rows * KNOT_PX {
        let knots = &mut sums[y / KNOT_PX * columns..][..columns];
        for x in 0..columns * KNOT_PX {
            let planes = [&red_green, &blue_yellow, &frame.luminance].map(|plane| plane.at(x, y));
            knots[x / KNOT_PX].iter_mut().zip(planes).for_each(|(sum, v)| *sum += v);
        }
    }
    let area = (KNOT_PX * KNOT_PX) as f32;
    let ratio = |[red_green, blue_yellow, luminance]: [f32; 3]| {
        let share = 1.0 / (luminance.max(0.0) + BLACK * area);
        [share * red_green, share * blue_yellow]
    };
    windowed(sums, columns, rows, window_px).into_iter().map(ratio).collect()
}

/// Sums of squares of [`KNOT_PX`] pixels as a Gaussian window of `window_px` sees them; mirrored at the border.
fn windowed<const N: usize>(
    sums: Vec<[f32; N]>,
    columns: usize,
    rows: usize,
    window_px: f64,
) -> Vec<[f32; N]> {
    let box_variance = ((KNOT_PX * KNOT_PX) as f64 - 1.0) / 12.0;
    let sigma = (window_px * window_px - box_variance).sqrt() / KNOT_PX as f64;
    let reach = (3.0 * sigma).ceil() as isize;
    let weights: Vec<f32> =
        (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp() as f32).collect();
    let all: f32 = weights.iter().sum();
    let along = |from: &[[f32; N]], count: usize, at: &dyn Fn(usize, usize) -> usize, line: usize| {
        let weighted = |middle: usize| -> [f32; N] {
            let mut sum = [0.0; N];
            for (k, weight) in (-reach..=reach).zip(&weights) {
                let from = &from[at(line, mirrored(middle as isize + k, count))];
                sum.iter_mut().zip(from).for_each(|(sum, v)| *sum += weight / all * v);
            }
            sum
        };
        (0..count).map(weighted).collect::<Vec<_>>()
    };
    let across: Vec<[f32; N]> =
        (0..rows).flat_map(|row| along(&sums, columns, &|row, column| row * columns + column, row)).collect();
    let mut both = across.clone();
    for column in 0..columns {
        let line = along(&across, rows, &|column, row| row * columns + column, column);
        line.into_iter().enumerate().for_each(|(row, v)| both[row * columns + column] = v);
    }
    both
}

/// A place between four knots.
#[derive(Clone, Copy)]
struct Knots {
    upper_left: usize,
    /// To the knot on the right and to the one below; 0 at the last one.
    right: usize,
    below: usize,
    along: f32,
    down: f32,
}

impl Knots {
    fn about(x: f32, y: f32, columns: usize, rows: usize) -> Knots {
        let (left, top) = (x as usize, y as usize);
        Knots {
            upper_left: top * columns + left,
            right: usize::from(left + 1 < columns),
            below: if top + 1 < rows { columns } else { 0 },
            along: x - left as f32,
            down: y - top as f32,
        }
    }

    #[inline(always)]
    fn between<const N: usize>(&self, values: &[[f32; N]]) -> [f32; N] {
        let upper = &values[self.upper_left..];
        let lower = &values[self.upper_left + self.below..];
        let (a, b, c, d) = (&upper[0], &upper[self.right], &lower[0], &lower[self.right]);
        from_fn(|k| {
            let above = a[k] + self.along * (b[k] - a[k]);
            let under = c[k] + self.along * (d[k] - c[k]);
            above + self.down * (under - above)
        })
    }
}

/// A turn of histograms by a part of the circle.
struct Turned {
    bins: usize,
    part: f32,
}

impl Turned {
    fn by(turn_rad: f64) -> Turned {
        let bins = (turn_rad / std::f64::consts::TAU).rem_euclid(1.0) * DIRECTIONS as f64;
        Turned { bins: bins as usize % DIRECTIONS, part: bins.fract() as f32 }
    }

    /// What stands at a direction of the picture as a direction of the object.
    #[inline(always)]
    fn histogram(&self, histogram: [f32; DIRECTIONS]) -> [f32; DIRECTIONS] {
        if self.bins == 0 && self.part == 0.0 {
            return histogram;
        }
        from_fn(|k| {
            let (low, high) = ((k + self.bins) % DIRECTIONS, (k + self.bins + 1) % DIRECTIONS);
            histogram[low] + self.part * (histogram[high] - histogram[low])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blobs, as they are seen at a place.
    fn blobs(place: &Similarity) -> Frame {
        let blobs = [(-22.0, -10.0, 7.0), (14.0, -24.0, 9.0), (8.0, 20.0, 6.0), (-18.0, 22.0, 8.0)];
        let (sin, cos) = place.turn_rad.sin_cos();
        Frame::gray(Image::from_fn(128, 128, |x, y| {
            let (x, y) = (x as f64 - 63.5 - place.x_px, y as f64 - 63.5 - place.y_px);
            let (x, y) = ((cos * x + sin * y) / place.scale, (cos * y - sin * x) / place.scale);
            let light = |&(bx, by, size): &(f64, f64, f64)| {
                200.0 * (-((x - bx).powi(2) + (y - by).powi(2)) / (2.0 * size * size)).exp()
            };
            (20.0 + blobs.iter().map(light).sum::<f64>()) as f32
        }))
    }

    fn apart(a: &[f32], b: &[f32]) -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt()
    }

    #[test]
    fn an_object_that_moved_is_read_as_it_stood() {
        let still = GradientField::of(&blobs(&Similarity::IDENTITY), 1.5, WINDOW_PX);
        let learnt = still.appearance(&Similarity::IDENTITY, &[]);
        assert_eq!(learnt.len(), 16 * 16 * DIRECTIONS);
        for place in [
            Similarity { x_px: 5.0, y_px: -3.0, ..Similarity::IDENTITY },
            Similarity { scale: 1.1, ..Similarity::IDENTITY },
            Similarity { turn_rad: 0.15, ..Similarity::IDENTITY },
        ] {
            let field = GradientField::of(&blobs(&place), 1.5, WINDOW_PX);
            let (aligned, as_is) =
                (field.appearance(&place, &[]), field.appearance(&Similarity::IDENTITY, &[]));
            let (near, far) = (apart(&aligned, &learnt), apart(&as_is, &learnt));
            assert!(near < 0.13 && far > 2.5 * near, "{place:?}: {near} and {far}");
        }
    }

    #[test]
    fn gain_and_offset_drop_out() {
        let frame = blobs(&Similarity::IDENTITY);
        let relit = Frame::gray(Image::from_fn(128, 128, |x, y| 60.0 + 0.5 * frame.luminance.at(x, y)));
        let read =
            |frame: &Frame| GradientField::of(frame, 1.5, WINDOW_PX).appearance(&Similarity::IDENTITY, &[]);
        assert!(apart(&read(&frame), &read(&relit)) < 1e-4);
        let flat = Frame::gray(Image::from_fn(128, 128, |_, _| 90.0));
        assert!(read(&flat).iter().all(|&v| v == 0.0));
    }

    #[test]
    fn a_gradient_is_shared_by_the_directions_beside_its_own() {
        for sixteenth in 0..16 {
            let angle = std::f32::consts::TAU * sixteenth as f32 / 16.0;
            let mut histogram = [0.0; DIRECTIONS];
            add_softly(&mut histogram, 3.0 * angle.cos(), 3.0 * angle.sin());
            let (low, high) = (sixteenth / 2 % DIRECTIONS, sixteenth.div_ceil(2) % DIRECTIONS);
            let share = if low == high { 3.0 } else { 1.5 };
            assert!(
                (histogram[low] - share).abs() < 0.05 && (histogram[high] - share).abs() < 0.05,
                "{histogram:?}"
            );
            assert!((histogram.iter().sum::<f32>() - 3.0).abs() < 1e-4);
        }
    }

    #[test]
    fn colours_are_ratios_and_gray_pictures_take_what_they_are_given() {
        let gray = blobs(&Similarity::IDENTITY);
        let painted =
            |light: f32| {
                Frame::colour([1.2, 0.9, 0.9].map(|factor: f32| {
                    Image::from_fn(128, 128, |x, y| light * factor * gray.luminance.at(x, y))
                }))
            };
        let opponents = vec![0.25; 16 * 16 * OPPONENTS];
        let colours = |frame: &Frame| {
            GradientField::of(frame, 1.5, WINDOW_PX).appearance(&Similarity::IDENTITY, &opponents)
                [16 * 16 * DIRECTIONS..]
                .to_vec()
        };
        let (bright, dim) = (colours(&painted(1.0)), colours(&painted(0.6)));
        assert!(bright[0] > 0.0 && apart(&bright, &dim) < 0.3 * apart(&bright, &vec![0.0; bright.len()]));
        assert_eq!(colours(&gray), opponents);
    }
}
