//! From a focal pair to a depth map: everything that the rig and the options fix is prepared once.

use thiserror::Error;

use super::brightness::matched;
use super::depth_map::{DepthMap, Warning};
use super::estimate::{Estimate, Samples};
use super::judging::Judge;
use super::kernels::KernelBank;
use super::monotone::MonotoneCurve;
use super::registration::{HALVING_SIGMA_PX, halved, looks_swapped, scaling, shift};
use super::resampling::{Affine, composed, resampled};
use super::stm::StmCurve;
use super::{
    Calibration, DepthOptions, Fault, Filters, FocalPair, Method, Photometric, Window, gram, laplacian, stm,
};
use crate::imaging::Image;

/// Why no estimator can be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EstimatorError {
    #[error("the options can't be used")]
    Options { faults: Vec<Fault> },
    #[error(
        "the method laplacian measures contrast, not depth: it needs a calibration with a plane sweep by this method"
    )]
    NeedsTable,
    #[error("the calibration's table was measured with other filters than this release has: sweep it again")]
    OtherFilters,
}

/// Why a pair can't be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EstimateError {
    #[error(
        "the calibration is for pictures of {calibrated_width_px}×{calibrated_height_px} px, not {width_px}×{height_px}"
    )]
    OtherSize { calibrated_width_px: usize, calibrated_height_px: usize, width_px: usize, height_px: usize },
}

/// A part of the work, told when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Scale, affine and shift.
    Register,
    /// Brightness, and halving.
    Match,
    /// Filters, windows, the estimate in each window.
    Estimate,
    /// Table, lens law, flags, median, summary.
    Judge,
}

/// A rig and options made ready; reads any number of pairs.
#[derive(Clone, Debug)]
pub struct Estimator {
    calibration: Calibration,
    options: DepthOptions,
    /// How often the pictures are halved, so that blur fits the filters.
    halvings: u32,
    reading: Reading,
    /// From what the method says to β, if a sweep has told.
    table: Option<MonotoneCurve>,
}

/// A method, made ready.
#[derive(Clone, Debug)]
enum Reading {
    Gram(KernelBank),
    Stm(StmCurve),
    Laplacian,
}

/// The largest blur that the filters reach around, in pixels.
const MOST_BLUR_PX: f64 = 7.5;
/// A shift of less than this is left, in pixels: it is within what can be told of it.
const LEAST_SHIFT_PX: f64 = 0.05;
/// A shift of more than this is worth a warning, in pixels.
const WARN_SHIFT_PX: f64 = 0.25;
/// A gain farther from 1 than this is worth a warning.
const WARN_GAIN: f64 = 0.03;
/// Rounding to whole levels and what the sensor's own electronics adds at the least, in levels.
const QUANTUM_LEVELS: f64 = 0.5;

impl Estimator {
    /// Make ready: design the kernels.
    ///
    /// # Errors
    /// [`EstimatorError`].
    pub fn new(calibration: &Calibration, options: &DepthOptions) -> Result<Estimator, EstimatorError> {
        let faults = options.faults();
        if !faults.is_empty() {
            return Err(EstimatorError::Options { faults });
        }
        let estimator = Estimator::without_table(calibration, options);
        let swept = calibration.filters.as_ref().filter(|filters| filters.method == options.method);
        let table = match (swept, &calibration.table) {
            (Some(filters), Some(_)) if filters.hash != estimator.filters().hash => {
                return Err(EstimatorError::OtherFilters);
            }
            (Some(_), Some(table)) => Some(table.curve()),
            _ if options.method == Method::Laplacian => return Err(EstimatorError::NeedsTable),
            _ => None,
        };
        Ok(Estimator { table, ..estimator })
    }

    /// The same without looking for a table: what a sweep measures with.
    pub(super) fn without_table(calibration: &Calibration, options: &DepthOptions) -> Estimator {
        let optics = &calibration.optics;
        let mut halvings = 0;
        while options.method != Method::Laplacian
            && optics.largest_blur_px() / f64::from(1 << halvings) > MOST_BLUR_PX
        {
            halvings += 1;
        }
        let scale = f64::from(1 << halvings);
        let shrunk = optics.shrunk(scale);
        let reading = match options.method {
            Method::Gram => Reading::Gram(KernelBank::new(&shrunk, halvings)),
            Method::Stm => Reading::Stm(StmCurve::new(&shrunk)),
            Method::Laplacian => Reading::Laplacian,
        };
        Estimator { calibration: calibration.clone(), options: *options, halvings, reading, table: None }
    }

    /// The filters, as a calibration names them.
    pub(super) fn filters(&self) -> Filters {
        let (side, rank, band, numbers) = match &self.reading {
            Reading::Gram(bank) => (bank.side, super::kernels::RANK, super::kernels::BAND, bank.numbers()),
            Reading::Stm(curve) => (0, 0, 0.5, curve.numbers()),
            Reading::Laplacian => (0, 0, 0.5, Vec::new()),
        };
        Filters {
            method: self.options.method,
            side,
            rank,
            band,
            halvings: self.halvings,
            hash: hash(&numbers),
        }
    }

    /// How often the pictures are halved.
    pub(super) fn halvings(&self) -> u32 {
        self.halvings
    }

    /// The depth map of a pair. `finished` is called at the end of each stage, in order.
    ///
    /// # Errors
    /// [`EstimateError`].
    pub fn estimate(
        &self,
        pair: &FocalPair,
        finished: &mut dyn FnMut(Stage),
    ) -> Result<DepthMap, EstimateError> {
        self.right_size(pair)?;
        let mut registered = self.registered(pair);
        finished(Stage::Register);
        let gain = self.match_brightness(&mut registered);
        if (gain - 1.0).abs() > WARN_GAIN {
            registered.warnings.push(Warning::GainOff);
        }
        finished(Stage::Match);
        let Estimate { mut samples, noise_sigma } = self.measured(&registered, pair.bits);
        finished(Stage::Estimate);
        self.apply_table(&mut samples);
        let judge = Judge {
            pair,
            optics: &self.calibration.optics,
            to_far: &registered.to_far,
            border_px: self.border_px(),
            samples: &samples,
            halvings: self.halvings,
            median: self.options.median,
            shift_px: registered.shift_px,
            gain,
            noise_sigma: noise_sigma.map(|sigma| sigma / noise_gain(self.halvings)),
            warnings: registered.warnings,
        };
        let map = judge.depth_map();
        finished(Stage::Judge);
        Ok(map)
    }

    /// What the method says of a pair, before any table; the noise is that of the pictures as sent.
    pub(super) fn raw(&self, pair: &FocalPair) -> Estimate {
        let mut registered = self.registered(pair);
        self.match_brightness(&mut registered);
        let estimate = self.measured(&registered, pair.bits);
        Estimate {
            noise_sigma: estimate.noise_sigma.map(|sigma| sigma / noise_gain(self.halvings)),
            ..estimate
        }
    }

    fn right_size(&self, pair: &FocalPair) -> Result<(), EstimateError> {
        let (width_px, height_px) = (pair.width(), pair.height());
        match self.calibration.image {
            Some(image) if (image.width_px, image.height_px) != (width_px, height_px) => {
                Err(EstimateError::OtherSize {
                    calibrated_width_px: image.width_px,
                    calibrated_height_px: image.height_px,
                    width_px,
                    height_px,
                })
            }
            _ => Ok(()),
        }
    }

    /// Both pictures without offsets, in register.
    fn registered(&self, pair: &FocalPair) -> Registered {
        let (width, height) = (pair.width(), pair.height());
        let mut warnings = Vec::new();
        let (near, far) = level(pair, self.calibration.photometric);
        let largest_blur_px = self.calibration.optics.largest_blur_px();
        let mut to_far = match &self.calibration.registration {
            Some(registration) => registration.affine_far_to_near,
            None => scaling(&self.calibration.optics, width, height),
        };
        if looks_swapped(pair, &to_far, largest_blur_px) {
            warnings.push(Warning::NearFarSwapped);
        }
        let mut brought = resampled(&far, &to_far);
        let mut shift_px = [0.0; 2];
        if self.options.align {
            match shift(&near, &brought, largest_blur_px) {
                None => warnings.push(Warning::ShiftUnknown),
                Some([dx, dy]) if dx.hypot(dy) > LEAST_SHIFT_PX => {
                    to_far = composed(&to_far, &[1.0, 0.0, dx, 0.0, 1.0, dy]);
                    brought = resampled(&far, &to_far);
                    shift_px = [dx, dy];
                    if dx.hypot(dy) > WARN_SHIFT_PX {
                        warnings.push(Warning::Shifted);
                    }
                }
                Some(_) => {}
            }
        }
        Registered { near, far: brought, to_far, shift_px, warnings }
    }

    /// Match the far picture's brightness, if that is wanted; tells by how much.
    fn match_brightness(&self, registered: &mut Registered) -> f64 {
        let mut gain = 1.0;
        if self.options.match_brightness {
            (registered.far, gain) = matched(&registered.near, &registered.far);
        }
        for _ in 0..self.halvings {
            registered.near = halved(&registered.near);
            registered.far = halved(&registered.far);
        }
        gain
    }

    fn measured(&self, registered: &Registered, bits: u8) -> Estimate {
        let Registered { near, far, .. } = registered;
        let scale = f64::from(1 << self.halvings);
        let quantum = QUANTUM_LEVELS * 255.0 / (2_f64.powi(i32::from(bits)) - 1.0) / scale;
        match &self.reading {
            Reading::Gram(bank) => {
                let least_noise = quantum.max(self.calibrated_noise(near) * noise_gain(self.halvings));
                gram::estimate(near, far, bank, self.options.window, self.halvings, least_noise)
            }
            Reading::Stm(curve) => {
                let window_px = match self.options.window {
                    Window::Auto => None,
                    Window::Px(px) => Some((px / scale).max(1.0)),
                };
                stm::estimate(near, far, curve, window_px, quantum)
            }
            Reading::Laplacian => laplacian::estimate(near, far, self.options.window),
        }
    }

    /// Noise of a picture this bright, if the rig's is known; else 0.
    fn calibrated_noise(&self, near: &Image) -> f64 {
        let Some(noise) = self.calibration.noise else { return 0.0 };
        let mean = near.pixels().iter().map(|&v| f64::from(v)).sum::<f64>() / near.pixels().len() as f64;
        (noise.read_sigma.powi(2) + noise.shot_gain * mean.max(0.0)).sqrt()
    }

    fn apply_table(&self, samples: &mut Samples) {
        let Some(table) = &self.table else { return };
        for (raw, sigma) in samples.beta.iter_mut().zip(&mut samples.sigma) {
            let (beta, slope) = table.at(f64::from(*raw));
            *raw = beta as f32;
            if sigma.is_finite() {
                *sigma *= slope.abs() as f32;
            }
        }
    }

    /// How near to the border nothing is measured.
    pub(super) fn border_px(&self) -> usize {
        let reach = match &self.reading {
            Reading::Gram(bank) => bank.reach(),
            Reading::Stm(_) => 4,
            Reading::Laplacian => 2,
        };
        (reach + 2) << self.halvings
    }
}

/// Two pictures in register, and how they came to it.
struct Registered {
    near: Image,
    far: Image,
    to_far: Affine,
    shift_px: [f64; 2],
    warnings: Vec<Warning>,
}

/// Both pictures without their dark levels, the far one with its gain.
fn level(pair: &FocalPair, photometric: Option<Photometric>) -> (Image, Image) {
    let (mut near, mut far) = (pair.near.clone(), pair.far.clone());
    if let Some(Photometric { dark_near, dark_far, gain_far }) = photometric {
        near.pixels_mut().iter_mut().for_each(|v| *v -= dark_near as f32);
        far.pixels_mut().iter_mut().for_each(|v| *v = (*v - dark_far as f32) * gain_far as f32);
    }
    (near, far)
}

/// Standard deviation of white unit noise after so many halvings: the root of the combined kernel's energy.
fn noise_gain(halvings: u32) -> f64 {
    let bell: Vec<f64> =
        (-6_i32..=6).map(|k| (-0.5 * (f64::from(k) / f64::from(HALVING_SIGMA_PX)).powi(2)).exp()).collect();
    let sum: f64 = bell.iter().sum();
    let mut kernel = vec![1.0];
    for halving in 0..halvings {
        let spacing = 1_usize << halving;
        let mut wider = vec![0.0; kernel.len() + (bell.len() - 1) * spacing];
        for (i, k) in kernel.iter().enumerate() {
            for (j, b) in bell.iter().enumerate() {
                wider[i + j * spacing] += k * b / sum;
            }
        }
        kernel = wider;
    }
    // Two axes: the square root of the energy's square.
    kernel.iter().map(|v| v * v).sum()
}

/// FNV-1a over the numbers' bits.
fn hash(numbers: &[f32]) -> String {
    let bytes = numbers.iter().flat_map(|v| v.to_bits().to_le_bytes());
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
