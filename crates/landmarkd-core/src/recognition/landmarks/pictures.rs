//! Drawn pictures for the tests: each seed gives another arrangement of discs and bars.

use super::{DescribedExemplar, ExemplarName, LandmarkOptions, Method, Viewpoint, describe};
use crate::imaging::{Frame, Image};

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

/// The image turned by a quarter, x towards y, without resampling.
pub fn quarter_turned(image: &Image) -> Image {
    let (width, height) = (image.width(), image.height());
    Image::from_fn(height, width, |x, y| image.at(y, height - 1 - x))
}

/// The paper's own options.
pub fn paper() -> LandmarkOptions {
    LandmarkOptions::of(Method::Paper, Viewpoint::Free)
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
