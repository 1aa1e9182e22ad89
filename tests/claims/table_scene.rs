//! Tables with known truth: turntable objects cut out of their pictures, scaled, set down apart from each other on a
//! dark shaded table, each at a height of its own; as an overview camera sees it, and as a focal pair.
//!
//!   picture = shade · (table, then object after object: picture · (1 − mask) + mask · object) + noise

use std::f64::consts::{PI, TAU};

use landmarkd_core::depth::Optics;
use landmarkd_core::imaging::{Frame, Image};
use rustfft::num_complex::Complex64;
use rustfft::{FftDirection, FftPlanner};

use crate::composites::{cubic, linear, mask};
use crate::random::Random;

/// Size of a picture.
pub const SIZE_PX: (usize, usize) = (640, 480);
/// The table's grey level.
const TABLE: f64 = 20.0;
/// How much darker the darkest place is than the brightest.
const SHADING: f64 = 0.25;
/// Standard deviation of the sensor noise, grey levels.
const NOISE: f64 = 2.0;
/// Scale of an object's picture of 128 px.
const SCALES: [f64; 2] = [0.7, 1.0];
/// Between the boxes of two objects, and from the picture's border.
const GAP_PX: f64 = 14.0;

/// An object on the table.
pub struct Placed {
    /// Which one, and how it is turned.
    pub object: usize,
    pub pose: usize,
    /// The mean of its pixels.
    pub centroid_px: [f64; 2],
    /// How far away it is: 0 at the near focus distance, 1 at the far one.
    pub share: f64,
    layer: Layer,
}

/// What covers a part of the picture.
struct Layer {
    /// Its first column and row.
    left: isize,
    top: isize,
    /// 0..=1, and the light times that.
    mask: Image,
    light: Image,
}

/// A table.
pub struct TableScene {
    pub placed: Vec<Placed>,
    /// Direction of the shading.
    towards: [f64; 2],
    seed: u64,
    number: u64,
}

impl TableScene {
    /// Table `number` of a seed, with three to six different objects; `picture` gives each by number and pose.
    pub fn new(
        seed: u64,
        number: u64,
        objects: usize,
        poses: &[usize],
        picture: impl Fn(usize, usize) -> Image,
    ) -> TableScene {
        let random = &mut Random::of(seed, &[number]);
        let (sin, cos) = random.uniform(0.0, TAU).sin_cos();
        let count = 3 + random.below(4);
        let mut placed: Vec<Placed> = Vec::new();
        let mut boxes: Vec<[f64; 4]> = Vec::new();
        while placed.len() < count {
            let (object, pose) = (random.below(objects), poses[random.below(poses.len())]);
            let scale = random.uniform(SCALES[0], SCALES[1]);
            let share = random.uniform(0.1, 0.9);
            let half = scale * 64.0;
            let x = random.uniform(half + GAP_PX, SIZE_PX.0 as f64 - half - GAP_PX);
            let y = random.uniform(half + GAP_PX, SIZE_PX.1 as f64 - half - GAP_PX);
            let apart = |other: &[f64; 4]| {
                let reach = half + other[2] + GAP_PX;
                (x - other[0]).abs() > reach || (y - other[1]).abs() > reach
            };
            if placed.iter().any(|placed| placed.object == object) || !boxes.iter().all(apart) {
                continue;
            }
            boxes.push([x, y, half, half]);
            let layer = Layer::of(&picture(object, pose), [x, y], scale);
            placed.push(Placed { object, pose, centroid_px: layer.centroid(), share, layer });
        }
        TableScene { placed, towards: [cos, sin], seed, number }
    }

    /// One object alone, its picture's middle at a place.
    pub fn of_one(seed: u64, number: u64, picture: &Image, at_px: [f64; 2], scale: f64) -> TableScene {
        let layer = Layer::of(picture, at_px, scale);
        let placed = Placed { object: 0, pose: 0, centroid_px: layer.centroid(), share: 0.5, layer };
        TableScene { placed: vec![placed], towards: [0.6, 0.8], seed, number }
    }

    /// What a camera sees that is sharp everywhere.
    pub fn overview(&self) -> Frame {
        self.photographed(0, |_| 0.0)
    }

    /// The near- and the far-focused picture of telecentric optics.
    pub fn pair(&self, optics: &Optics) -> [Frame; 2] {
        [0, 1].map(|sensor| {
            self.photographed(1 + sensor as u64, |share| {
                let depth_mm = optics.near_focus_mm() + share * optics.range_mm();
                optics.blur_diameters_px(optics.beta(depth_mm))[sensor].abs()
            })
        })
    }

    fn photographed(&self, exposure: u64, blur_px: impl Fn(f64) -> f64) -> Frame {
        let (width, height) = SIZE_PX;
        let mut light = vec![TABLE; width * height];
        for placed in &self.placed {
            placed.layer.blurred(blur_px(placed.share)).cover(&mut light);
        }
        let random = &mut Random::of(self.seed + 1, &[self.number, exposure]);
        let [to_x, to_y] = self.towards;
        let reach = (to_x.abs() * width as f64 + to_y.abs() * height as f64) / 2.0;
        Frame::gray(Image::from_fn(width, height, |x, y| {
            let along = (x as f64 - width as f64 / 2.0) * to_x + (y as f64 - height as f64 / 2.0) * to_y;
            let shade = 1.0 - SHADING * (0.5 + 0.5 * along / reach);
            let level = light[y * width + x] * shade + NOISE * random.normal();
            level.round().clamp(0.0, 255.0) as f32
        }))
    }
}

impl Layer {
    fn of(picture: &Image, [x, y]: [f64; 2], scale: f64) -> Layer {
        let mask = mask(picture);
        let half = scale * 64.0 + 1.0;
        let (left, top) = ((x - half).floor() as isize, (y - half).floor() as isize);
        let side = (2.0 * half).ceil() as usize + 2;
        let from = |column: usize, row: usize| {
            let (dx, dy) = ((left + column as isize) as f64 - x, (top + row as isize) as f64 - y);
            (63.5 + dx / scale, 63.5 + dy / scale)
        };
        let covered = Image::from_fn(side, side, |column, row| {
            let (x, y) = from(column, row);
            linear(&mask, x, y) as f32
        });
        let light = Image::from_fn(side, side, |column, row| {
            let (x, y) = from(column, row);
            covered.at(column, row) * (cubic(picture, x, y) as f32).clamp(0.0, 255.0)
        });
        Layer { left, top, mask: covered, light }
    }

    fn centroid(&self) -> [f64; 2] {
        let (mut x, mut y, mut all) = (0.0, 0.0, 0.0);
        for row in 0..self.mask.height() {
            for column in 0..self.mask.width() {
                let part = f64::from(self.mask.at(column, row));
                x += part * (self.left + column as isize) as f64;
                y += part * (self.top + row as isize) as f64;
                all += part;
            }
        }
        [x / all, y / all]
    }

    /// The layer through discs of blur: what it lights and hides.
    fn blurred(&self, diameter_px: f64) -> Layer {
        let margin = (diameter_px / 2.0).ceil() as usize + 2;
        Layer {
            left: self.left - margin as isize,
            top: self.top - margin as isize,
            mask: blurred(&self.mask, diameter_px, margin),
            light: blurred(&self.light, diameter_px, margin),
        }
    }

    /// Cover what is behind by as much as it hides.
    fn cover(&self, light: &mut [f64]) {
        for row in 0..self.mask.height() {
            for column in 0..self.mask.width() {
                let (x, y) = (self.left + column as isize, self.top + row as isize);
                if (0..SIZE_PX.0 as isize).contains(&x) && (0..SIZE_PX.1 as isize).contains(&y) {
                    let behind = &mut light[y as usize * SIZE_PX.0 + x as usize];
                    *behind *= 1.0 - f64::from(self.mask.at(column, row));
                    *behind += f64::from(self.light.at(column, row));
                }
            }
        }
    }
}

/// An image, black outside, with a margin on all sides, each point of it spread over a disc: by the disc's transfer
/// function 2·J₁(πdf) / (πdf), so that discs of less than a pixel are as true as large ones.
fn blurred(image: &Image, diameter_px: f64, margin: usize) -> Image {
    let (width, height) = (image.width() + 2 * margin, image.height() + 2 * margin);
    let mut spectrum = vec![Complex64::default(); width * height];
    for y in 0..image.height() {
        for (x, &v) in image.row(y).iter().enumerate() {
            spectrum[(y + margin) * width + x + margin].re = f64::from(v);
        }
    }
    let mut planner = FftPlanner::new();
    for direction in [FftDirection::Forward, FftDirection::Inverse] {
        let rows = planner.plan_fft(width, direction);
        spectrum.chunks_exact_mut(width).for_each(|row| rows.process(row));
        let columns = planner.plan_fft(height, direction);
        for x in 0..width {
            let mut column: Vec<Complex64> = spectrum[x..].iter().step_by(width).copied().collect();
            columns.process(&mut column);
            column.iter().enumerate().for_each(|(y, &v)| spectrum[y * width + x] = v);
        }
        if direction == FftDirection::Forward {
            let cycles = |k: usize, side: usize| k.min(side - k) as f64 / side as f64;
            for (at, v) in spectrum.iter_mut().enumerate() {
                let frequency = cycles(at % width, width).hypot(cycles(at / width, height));
                let along = PI * diameter_px * frequency;
                let transfer = if along < 1e-6 { 1.0 } else { 2.0 * libm::j1(along) / along };
                *v *= transfer / (width * height) as f64;
            }
        }
    }
    Image::new(width, height, spectrum.iter().map(|v| v.re as f32).collect())
}

#[test]
fn a_disc_gives_all_its_light_over_its_diameter() {
    let point = Image::from_fn(21, 21, |x, y| f32::from(x == 10 && y == 10));
    for diameter_px in [0.7, 2.0, 5.3] {
        let disc = blurred(&point, diameter_px, 12);
        let all: f64 = disc.pixels().iter().map(|&v| f64::from(v)).sum();
        let far = |at: usize, side: usize| (at as f64 - (side as f64 - 1.0) / 2.0).powi(2);
        let spread: f64 = (0..disc.height())
            .flat_map(|y| (0..disc.width()).map(move |x| (x, y)))
            .map(|(x, y)| f64::from(disc.at(x, y)) * far(x, disc.width()))
            .sum();
        assert!((all - 1.0).abs() < 1e-4, "{all}");
        // The second moment of a disc along an axis, but for what stands at the frequencies a pixel can't show.
        assert!((spread - diameter_px.powi(2) / 16.0).abs() < 0.1, "{diameter_px}: {spread}");
    }
}
