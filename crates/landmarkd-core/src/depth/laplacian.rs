//! The method `laplacian`, as the text has it (B§4): the Laplacian of each picture, and their difference is depth.
//!
//! What it measures grows with the texture's contrast, so it is a depth only by a table made with the same texture.

use super::Window;
use super::estimate::{Estimate, Sample, Samples};
use super::stm::laplacian;
use super::windows::{Means, Planes};
use crate::imaging::Image;

/// The window of `auto`.
const WINDOW_PX: f64 = 4.0;
/// Energy of the Laplacian below this, in gray levels, shows nothing.
const LEAST_ENERGY: f32 = 0.5;

/// ⟨|∇²n|⟩ − ⟨|∇²f|⟩ in gray levels: rises with β.
pub(super) fn estimate(near: &Image, far: &Image, window: Window) -> Estimate {
    let (width, height) = (near.width(), near.height());
    let window_px = match window {
        Window::Auto => WINDOW_PX,
        Window::Px(px) => px,
    };
    let energy = |image| laplacian(image).into_iter().map(f32::abs).collect::<Vec<f32>>();
    let (near, far) = (energy(near), energy(far));
    let rows = Planes { width, planes: [&near, &far] };
    let means = Means::over(&rows, width, height, window_px);
    let sample = |(near, far): (&f32, &f32)| {
        let sigma = if near + far > LEAST_ENERGY { f32::NAN } else { f32::INFINITY };
        Sample { beta: near - far, sigma, ..Sample::UNKNOWN }
    };
    let points = means.planes[0].iter().zip(&means.planes[1]).map(sample).collect();
    let samples = Samples { width: means.width, height: means.height, step: means.step, points };
    Estimate { samples, noise_sigma: None }
}
