//! Synthetic pictures of turning things, for the tests of this folder.

use super::appearance::Normaliser;
use super::model::ViewName;
use super::options::ObjectOptions;
use super::training::View;
use crate::imaging::{Frame, Image};

/// A side of the pictures.
pub const SIDE_PX: usize = 48;

/// Six spots fixed to a turning thing, nearer ones brighter; another thing for each seed.
pub fn thing(seed: u64, turn_deg: f64) -> Frame {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    let spots: Vec<[f64; 3]> = (0..6)
        .map(|_| {
            let (radius, angle, height) = (7.0 + 9.0 * next(), 360.0 * next(), 36.0 * next() - 18.0);
            let around = (angle + turn_deg).to_radians();
            [radius * around.sin(), height, 0.6 + 0.4 * around.cos()]
        })
        .collect();
    drawn(&spots)
}

/// A thing that looks the same from everywhere: its spots stand on the axis.
pub fn vase() -> Frame {
    drawn(&[[0.0, -14.0, 0.9], [0.0, 0.0, 0.5], [0.0, 12.0, 0.8]])
}

/// Spots at (x, y) of a brightness, about the middle.
fn drawn(spots: &[[f64; 3]]) -> Frame {
    let middle = SIDE_PX as f64 / 2.0;
    Frame::gray(Image::from_fn(SIDE_PX, SIDE_PX, |px, py| {
        let (px, py) = (px as f64 - middle, py as f64 - middle);
        let light = |&[x, y, bright]: &[f64; 3]| {
            250.0 * bright * (-((px - x).powi(2) + (py - y).powi(2)) / 18.0).exp()
        };
        spots.iter().map(light).sum::<f64>().min(255.0) as f32
    }))
}

/// The frame with noise of some gray levels, another for each seed.
pub fn noisy(frame: &Frame, levels: f32, seed: u64) -> Frame {
    let mut state = seed ^ 0x2545_f491_4f6c_dd1d;
    let pixels = frame.luminance.pixels().iter().map(|v| {
        let mut sum = -2.0;
        for _ in 0..4 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 40) as f32 / (1u64 << 24) as f32;
        }
        v + levels * 1.7 * sum
    });
    Frame::gray(Image::new(SIDE_PX, SIDE_PX, pixels.collect()))
}

/// The normaliser of these pictures.
pub fn normaliser(options: &ObjectOptions) -> Normaliser {
    Normaliser::new(options, (SIDE_PX as u32, SIDE_PX as u32))
}

/// A view as training takes it.
pub fn view(normaliser: &Normaliser, label: &str, pose_deg: Option<f64>, frame: &Frame) -> View {
    let pose = pose_deg.map_or_else(|| "-".into(), |pose| pose.to_string());
    let appearance = normaliser.appearance(frame).unwrap();
    let bits = appearance.vector.iter().fold(0_u32, |sum, v| sum.wrapping_mul(31).wrapping_add(v.to_bits()));
    let name = ViewName { id: format!("{label} {pose} {bits:08x}"), label: label.into(), pose_deg };
    View::new(normaliser, name, frame, true).unwrap()
}

/// Things 0, 1, 2 … at every so many degrees.
pub fn turntable(things: u64, step_deg: usize, options: &ObjectOptions) -> Vec<View> {
    let normaliser = normaliser(options);
    let poses = (0..360).step_by(step_deg).map(|pose| pose as f64);
    let views = (0..things).flat_map(|seed| poses.clone().map(move |pose| (seed, pose)));
    views
        .map(|(seed, pose)| {
            let frame = noisy(&thing(seed, pose), 1.0, seed * 1000 + pose as u64);
            view(&normaliser, &format!("thing{seed}"), Some(pose), &frame)
        })
        .collect()
}
