//! What the surfaces of a scene look like: planes of light, drawn by seeded code.
//!
//! Lengths in pixels of the near-focused picture; a plane holds [`FINE`] samples a pixel and axis.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex32;

use super::point_spread::FINE;
use crate::imaging::{Image, Random};

/// What is painted on the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    /// Clouds on every scale: amplitude 1/f up to the sensor's highest frequency.
    Noise,
    /// Pebbles of 5 to 14 px, lit from the upper left, of grainy stone.
    Gravel,
    /// Thin blades that lie across each other.
    Grass,
    /// Dark dots without order.
    Dots {
        /// Their mean distance.
        period_px: f64,
    },
    /// Upright smooth bars, each a little wider or narrower than the others.
    Stripes {
        /// Their mean period.
        period_px: f64,
    },
    /// Upright hard bars, strictly periodic.
    Bars {
        /// Their period.
        period_px: f64,
    },
    /// Nothing.
    Plain,
}

/// Mean gray level of a texture.
const MEAN: f64 = 120.0;
/// Darkest and lightest gray level of a texture.
const SPAN: [f64; 2] = [4.0, 250.0];

impl Texture {
    /// A plane of `width` × `height` samples: mean 120, the given standard deviation, held within 4..250.
    pub(super) fn drawn(self, width: usize, height: usize, deviation: f64, seed: u64) -> Image {
        let random = &mut Random::new(seed, 1);
        let mut plane = match self {
            Texture::Noise => clouds(width, height, random),
            Texture::Gravel => pebbles(width, height, random),
            Texture::Grass => blades(width, height, random),
            Texture::Dots { period_px } => dots(width, height, period_px * FINE as f64, random),
            Texture::Stripes { period_px } => stripes(width, height, period_px * FINE as f64, random),
            Texture::Bars { period_px } => {
                let period = period_px * FINE as f64;
                Image::from_fn(width, height, |x, _| f32::from((x as f64).rem_euclid(period) < period / 2.0))
            }
            Texture::Plain => Image::from_fn(width, height, |_, _| 0.0),
        };
        let mean = plane.mean();
        let squares = plane.pixels().iter().map(|&v| (f64::from(v) - mean).powi(2));
        let variance = squares.sum::<f64>() / (width * height) as f64;
        let gain = if variance > 0.0 { deviation / variance.sqrt() } else { 0.0 };
        for value in plane.pixels_mut() {
            *value = (MEAN + gain * (f64::from(*value) - mean)).clamp(SPAN[0], SPAN[1]) as f32;
        }
        plane
    }
}

fn clouds(width: usize, height: usize, random: &mut Random) -> Image {
    let cycles_per_px = |at: usize, length: usize| {
        let signed = if 2 * at < length { at as f64 } else { at as f64 - length as f64 };
        signed / length as f64 * FINE as f64
    };
    let mut plane = vec![Complex32::ZERO; width * height];
    for (at, value) in plane.iter_mut().enumerate().skip(1) {
        let frequency = cycles_per_px(at % width, width).hypot(cycles_per_px(at / width, height));
        let amplitude = (-(frequency / 0.45).powi(6)).exp() / frequency;
        let [re, im] = random.normals().map(|normal| (amplitude * normal) as f32);
        *value = Complex32::new(re, im);
    }
    let mut planner = FftPlanner::new();
    planner.plan_fft_inverse(width).process(&mut plane);
    let mut turned: Vec<_> = (0..width * height).map(|at| plane[at % height * width + at / height]).collect();
    planner.plan_fft_inverse(height).process(&mut turned);
    Image::from_fn(width, height, |x, y| turned[x * height + y].re)
}

/// Places scattered about the nodes of a grid.
struct Scattered {
    spacing: f64,
    columns: usize,
    /// Row by row: x, y, and a number of its own in 0..1.
    places: Vec<[f64; 3]>,
}

impl Scattered {
    fn new(width: usize, height: usize, spacing: f64, jitter: f64, random: &mut Random) -> Scattered {
        let (columns, rows) = ((width as f64 / spacing) as usize + 3, (height as f64 / spacing) as usize + 3);
        let places = (0..columns * rows)
            .map(|at| {
                let [x, y] = [at % columns, at / columns]
                    .map(|node| (node as f64 - 0.5 + random.between(-jitter, jitter)) * spacing);
                [x, y, random.uniform()]
            })
            .collect();
        Scattered { spacing, columns, places }
    }

    /// The places about the node nearest to a sample.
    fn around(&self, x: f64, y: f64) -> impl Iterator<Item = &[f64; 3]> {
        let [column, row] = [x, y].map(|v| (v / self.spacing + 1.0) as usize);
        let rows = row.saturating_sub(1)..(row + 2).min(self.places.len() / self.columns);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        rows.flat_map(move |row| {
            &self.places[row * self.columns + columns.start..row * self.columns + columns.end]
        })
    }
}

fn pebbles(width: usize, height: usize, random: &mut Random) -> Image {
    let stones = Scattered::new(width, height, 8.0 * FINE as f64, 0.48, random);
    let grain = Image::from_fn(width, height, |_, _| random.normals()[0] as f32);
    Image::from_fn(width, height, |column, row| {
        let (x, y) = (column as f64, row as f64);
        // The nearest stone and how far the next one's border is; large stones reach farther.
        let (mut nearest, mut next, mut stone) = (f64::INFINITY, f64::INFINITY, [0.0; 3]);
        for &[stone_x, stone_y, own] in stones.around(x, y) {
            let size = 0.75 + 0.5 * (own * 7.0).fract();
            let distance = ((stone_x - x).powi(2) + (stone_y - y).powi(2)).sqrt() / size;
            if distance < nearest {
                (next, nearest, stone) = (nearest, distance, [stone_x, stone_y, own]);
            } else {
                next = next.min(distance);
            }
        }
        let radius = 5.0 * FINE as f64;
        let lit = ((stone[0] - x) + 1.4 * (stone[1] - y)) / radius;
        let crack = ((next - nearest) / (1.6 * FINE as f64)).min(1.0);
        let (left, up) = (column.saturating_sub(1), row.saturating_sub(1));
        let grains = grain.at(column, row) + grain.at(left, row) + grain.at(column, up) + grain.at(left, up);
        (crack * (0.55 + 0.5 * stone[2] + 0.22 * lit + 0.06 * f64::from(grains))) as f32
    })
}

fn blades(width: usize, height: usize, random: &mut Random) -> Image {
    let mut plane = Image::from_fn(width, height, |_, _| 0.2);
    let fine = FINE as f64;
    let pixels = (width * height) as f64 / (fine * fine);
    for _ in 0..(pixels / 12.0) as usize {
        let (mut x, mut y) = (random.between(0.0, width as f64), random.between(0.0, height as f64));
        let mut angle = random.between(-1.2, 1.2) - std::f64::consts::FRAC_PI_2;
        let (curvature, length_px) = (random.between(-0.03, 0.03), random.between(8.0, 30.0));
        let (half_width, tone) = (random.between(0.4, 1.1) * fine, random.between(0.1, 1.0));
        let steps = (length_px * fine) as usize;
        for step in 0..steps {
            let (sin, cos) = angle.sin_cos();
            let part = step as f64 / steps as f64;
            let half = half_width * (1.0 - 0.7 * part);
            // One side of a blade lies in its own shadow.
            let mut across = -half;
            while across <= half {
                let (column, row) = (x - sin * across, y + cos * across);
                if column >= 0.0 && row >= 0.0 && column < width as f64 && row < height as f64 {
                    let shade = if across < 0.0 { 0.75 } else { 1.0 };
                    plane.pixels_mut()[row as usize * width + column as usize] =
                        (tone * shade * (0.5 + 0.5 * part)) as f32;
                }
                across += 0.7;
            }
            (x, y, angle) = (x + cos, y + sin, angle + curvature / fine);
        }
    }
    plane
}

fn dots(width: usize, height: usize, period: f64, random: &mut Random) -> Image {
    let places = Scattered::new(width, height, period, 0.3, random);
    Image::from_fn(width, height, |x, y| {
        let (x, y) = (x as f64, y as f64);
        let distance =
            |place: &[f64; 3]| (place[0] - x).hypot(place[1] - y) - (0.2 + 0.15 * place[2]) * period;
        let nearest = places.around(x, y).map(distance).fold(f64::INFINITY, f64::min);
        (nearest / 1.5).clamp(0.0, 1.0) as f32
    })
}

fn stripes(width: usize, height: usize, period: f64, random: &mut Random) -> Image {
    let mut row = Vec::with_capacity(width);
    let (mut turn, mut speed) = (random.uniform(), 1.0);
    for _ in 0..width {
        row.push((std::f64::consts::TAU * turn).sin() as f32);
        let before = turn;
        turn += speed / period;
        if turn.floor() > before.floor() {
            speed = random.between(0.75, 1.25);
        }
    }
    Image::from_fn(width, height, |x, _| row[x])
}
