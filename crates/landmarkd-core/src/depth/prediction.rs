//! What an optics would measure, before it is built: the expected error at each distance, from the kernels that it would
//! have and a texture of a 1/f spectrum.

use super::dense_map::MOST_SIGMA;
use super::estimator::noise_gain;
use super::gram;
use super::kernels::Evidence;
use super::selection::TEXTURE_SIGMA;
use super::{Calibration, DepthOptions, Estimator, Fault, Optics};

/// What stands before the camera, and how it is lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scenery {
    /// Standard deviation of the surfaces' texture, in gray levels of 255: their contrast.
    pub contrast: f64,
    /// Standard deviation of a pixel's noise, in gray levels of 255.
    pub noise_sigma: f64,
}

/// What is expected at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Distance along the optical axis, in mm.
    pub depth_mm: f64,
    /// Blur diameters of the near- and the far-focused picture, in pixels.
    pub blur_px: [f64; 2],
    /// Expected error, standard deviation in mm; `None` where an answer would be no depth: out of range, or above 2 % of
    /// the range.
    pub sigma_mm: Option<f64>,
}

/// What an optics would measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// At the distances that were asked for, in their order.
    pub expected: Vec<Expected>,
    /// Where there would be depths, in mm: from the nearest to the farthest of the β that are.
    pub working_range_mm: Option<[f64; 2]>,
}

/// The window that errors are predicted for: one that is filled with texture, standard deviation in pixels.
pub(super) const WINDOW_PX: f64 = 7.0;
/// The same in a halved picture.
pub(super) const HALVED_WINDOW_PX: f64 = 5.0;
/// No depth lies farther out.
const MOST_BETA: f64 = super::dense_map::MOST_BETA as f64;
/// Steps from one end of the range to the other in which the working range is looked for.
const STEPS: usize = 84;

impl Scenery {
    /// Every faulty field.
    pub fn faults(&self) -> Vec<Fault> {
        let fields =
            [("contrast", self.contrast, 0.0..=127.5), ("noise_sigma", self.noise_sigma, 0.01..=100.0)];
        let faulty = fields.into_iter().filter(|(_, value, range)| !range.contains(value));
        let fault = |(field, value, range): (_, f64, std::ops::RangeInclusive<f64>)| Fault {
            field,
            message: format!("must be from {} to {} gray levels, not {value}", range.start(), range.end()),
        };
        faulty.map(fault).collect()
    }
}

/// What an optics would measure of planes that face the camera, by the method `gram`.
pub fn predicted(optics: &Optics, scenery: &Scenery, depths_mm: &[f64]) -> Prediction {
    let estimator = Estimator::without_table(&Calibration::of(*optics), &DepthOptions::default());
    let asked = depths_mm.iter().map(|&depth_mm| optics.beta(depth_mm));
    let swept = (0..=STEPS).map(|step| MOST_BETA * (2.0 * step as f64 / STEPS as f64 - 1.0));
    let betas: Vec<f64> = asked.chain(swept).collect();
    let mut expected = expected(&estimator, optics, scenery, &betas);
    let swept = expected.split_off(depths_mm.len());
    for (expected, &depth_mm) in expected.iter_mut().zip(depths_mm) {
        expected.depth_mm = depth_mm;
    }
    let known =
        || swept.iter().filter(|expected| expected.sigma_mm.is_some()).map(|expected| expected.depth_mm);
    let nearest = known().min_by(f64::total_cmp);
    let farthest = known().max_by(f64::total_cmp);
    Prediction {
        expected,
        working_range_mm: nearest.zip(farthest).map(|(nearest, farthest)| [nearest, farthest]),
    }
}

fn expected(estimator: &Estimator, optics: &Optics, scenery: &Scenery, betas: &[f64]) -> Vec<Expected> {
    let halvings = estimator.halvings();
    let scale = f64::from(1_u32 << halvings);
    let blurs = |beta: f64| optics.registered_blur_px(beta);
    let shrunk: Vec<[f64; 2]> = betas.iter().map(|&beta| blurs(beta).map(|px| px / scale)).collect();
    let evidence = estimator.bank().map(|bank| bank.evidence(&shrunk)).unwrap_or_default();
    let noise = (scenery.noise_sigma * noise_gain(halvings)).powi(2);
    let window_px = if halvings == 0 { WINDOW_PX } else { HALVED_WINDOW_PX };
    let at = |(&beta, Evidence { second_derivative, left }): (&f64, Evidence)| {
        let texture = scenery.contrast * scenery.contrast;
        let (residual, second_derivative) = (left * texture + noise, second_derivative * texture);
        let variance =
            gram::variance(residual, second_derivative, noise, window_px) + f64::from(TEXTURE_SIGMA).powi(2);
        let (before, after) = (optics.depth_mm(beta - 0.01), optics.depth_mm(beta + 0.01));
        let sigma_mm = variance.sqrt() * (before - after) / 0.02;
        let known = beta.abs() <= MOST_BETA + 1e-9
            && second_derivative > 0.0
            && sigma_mm <= f64::from(MOST_SIGMA) * optics.range_mm();
        Expected {
            depth_mm: optics.depth_mm(beta),
            blur_px: blurs(beta).map(f64::abs),
            sigma_mm: known.then_some(sigma_mm),
        }
    };
    betas.iter().zip(evidence).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::scene::{Camera, Relief, Scene, Texture, bench_optics};

    /// Spread of the depths of a plane about their mean, in mm.
    fn measured(optics: Optics, share: f64, contrast: f64, noise: f64) -> f64 {
        let camera = Camera { noise, width: 160, height: 160, ..Camera::new(optics) };
        let scene = Scene { contrast, ..Scene::new(Relief::Plane { share }, Texture::Noise, 5) };
        let options = DepthOptions { window: super::super::Window::Px(WINDOW_PX), ..DepthOptions::default() };
        let estimator = Estimator::new(&Calibration::of(optics), &options).unwrap();
        let map = estimator.estimate(&camera.photograph(&scene).pair().unwrap(), &mut |_| {}).unwrap();
        let known: Vec<f64> = map.depth_mm().iter().filter(|v| !v.is_nan()).map(|&v| f64::from(v)).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        (known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt()
    }

    #[test]
    fn what_is_predicted_is_what_is_measured_but_for_a_factor_of_two() {
        let optics = bench_optics(8.0, true);
        for (share, contrast, noise) in [(0.5, 10.0, 1.0), (0.2, 10.0, 1.0), (0.8, 20.0, 3.0)] {
            let depth_mm = optics.near_focus_mm() + share * optics.range_mm();
            let prediction = predicted(&optics, &Scenery { contrast, noise_sigma: noise }, &[depth_mm]);
            let (expected, found) =
                (prediction.expected[0].sigma_mm.unwrap(), measured(optics, share, contrast, noise));
            let ratio = expected / found;
            assert!((0.5..2.0).contains(&ratio), "at {depth_mm:.0} mm: {expected:.3}, not {found:.3} mm");
        }
    }

    #[test]
    fn less_contrast_is_less_sure_and_none_is_no_depth() {
        let optics = bench_optics(8.0, true);
        let at = |contrast: f64, depth_mm: f64| {
            let prediction = predicted(&optics, &Scenery { contrast, noise_sigma: 1.0 }, &[depth_mm]);
            (prediction.expected[0].sigma_mm, prediction.working_range_mm)
        };
        let middle_mm = optics.depth_mm(0.0);
        let (strong, range_mm) = at(40.0, middle_mm);
        let (weak, _) = at(10.0, middle_mm);
        assert!(strong.unwrap() < weak.unwrap());
        let [nearest, farthest] = range_mm.unwrap();
        assert!(nearest < optics.near_focus_mm() && farthest > optics.far_focus_mm());
        assert_eq!(at(0.0, middle_mm), (None, None));
        assert_eq!(at(40.0, optics.depth_mm(-1.2)).0, None);
    }
}
