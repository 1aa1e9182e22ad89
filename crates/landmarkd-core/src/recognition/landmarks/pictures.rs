//! Drawn pictures for the tests: each seed gives another arrangement of discs and bars.

use super::{DescribedExemplar, ExemplarName, LandmarkOptions, Method, Signature, Viewpoint, describe};
use crate::imaging::{Frame, Image, Random, bilinear_replicated};

/// A square toy of `side_px`, dark at its border, with some thirty bright shapes within a disc.
pub fn toy(seed: u64, side_px: usize) -> Image {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x1234_5678_9abc_def1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let side = side_px as f32;
    let shapes: Vec<[f32; 6]> = (0..30)
        .map(|_| {
            let (turn, reach) = (std::f32::consts::TAU * next(), 0.36 * side * next().sqrt());
            let (x, y) = (side / 2.0 + reach * turn.cos(), side / 2.0 + reach * turn.sin());
            let tilt = std::f32::consts::PI * next();
            [x, y, tilt, 1.5 + 2.5 * next(), 1.5 + 5.0 * next(), 60.0 + 195.0 * next()]
        })
        .collect();
    Image::from_fn(side_px, side_px, |x, y| {
        let inside = |&&[cx, cy, tilt, a, b, _]: &&[f32; 6]| {
            let (dx, dy) = (x as f32 - cx, y as f32 - cy);
            let (u, v) = (dx * tilt.cos() + dy * tilt.sin(), dy * tilt.cos() - dx * tilt.sin());
            (u / a).powi(2) + (v / b).powi(2) < 1.0
        };
        shapes.iter().rev().find(inside).map_or(12.0, |shape| shape[5])
    })
}

/// A wall full of bars and discs of some 6 to 60 px, one over the other.
pub fn wall(seed: u64, width: usize, height: usize) -> Image {
    let random = &mut Random::new(seed, 0);
    let mut image = Image::from_fn(width, height, |_, _| 90.0);
    for _ in 0..width * height / 400 {
        let (x, y) = (random.uniform() * width as f64, random.uniform() * height as f64);
        let (sin, cos) = (random.uniform() * std::f64::consts::PI).sin_cos();
        let (a, b) = (3.0 * 10.0_f64.powf(random.uniform()), 3.0 * 6.0_f64.powf(random.uniform()));
        let (gray, round) = (20.0 + 220.0 * random.uniform(), random.uniform() < 0.4);
        let reach = a.hypot(b);
        let (left, top) = ((x - reach).max(0.0) as usize, (y - reach).max(0.0) as usize);
        for py in top..((y + reach) as usize).min(height) {
            for px in left..((x + reach) as usize).min(width) {
                let (dx, dy) = (px as f64 - x, py as f64 - y);
                let (u, v) = ((dx * cos + dy * sin) / a, (dy * cos - dx * sin) / b);
                if if round { u * u + v * v < 1.0 } else { u.abs().max(v.abs()) < 1.0 } {
                    image.pixels_mut()[py * width + px] = gray as f32;
                }
            }
        }
    }
    image
}

/// A picture laid on a frame: `to_picture` says which of its points is seen at a pixel of the frame.
pub fn laid(frame: &mut Image, picture: &Image, to_picture: impl Fn(f64, f64) -> [f64; 2]) {
    let (width, height) = (frame.width(), frame.height());
    let (right, bottom) = (picture.width() as f64 - 1.0, picture.height() as f64 - 1.0);
    for py in 0..height {
        for px in 0..width {
            let [x, y] = to_picture(px as f64, py as f64);
            if (0.0..=right).contains(&x) && (0.0..=bottom).contains(&y) {
                frame.pixels_mut()[py * width + px] = bilinear_replicated(picture, x, y) as f32;
            }
        }
    }
}

/// The image turned by a quarter, x towards y, without resampling.
pub fn quarter_turned(image: &Image) -> Image {
    let (width, height) = (image.width(), image.height());
    Image::from_fn(height, width, |x, y| image.at(y, height - 1 - x))
}

/// The paper's own options.
pub fn paper() -> LandmarkOptions {
    LandmarkOptions::of(Method::Paper, Viewpoint::Free)
}

/// The options of intensity signatures with placement.
pub fn intensity(viewpoint: Viewpoint) -> LandmarkOptions {
    LandmarkOptions::with_signature(Method::Placement, viewpoint, Signature::Intensity)
}

pub fn name(id: &str, label: &str) -> ExemplarName {
    ExemplarName { id: id.to_owned(), label: label.to_owned() }
}

/// Toys of the given seeds, described, each its own label.
pub fn described(seeds: std::ops::Range<u64>, options: &LandmarkOptions) -> Vec<DescribedExemplar> {
    seeds
        .map(|seed| {
            let label = format!("toy{seed}");
            describe(name(&label, &label), &Frame::gray(toy(seed, 96)), options)
        })
        .collect()
}
