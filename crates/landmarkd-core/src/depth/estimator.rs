//! From a focal pair to a depth map: everything that the rig and the options fix is prepared once.

use thiserror::Error;

use super::brightness::matched;
use super::dense_map::DenseMap;
use super::depth_map::{DepthMap, Warning};
use super::estimate::{Estimate, Samples};
use super::kernels::KernelBank;
use super::monotone::MonotoneCurve;
use super::registration::{HALVING_SIGMA_PX, exchanged, fitted_registration, halved, scaling, shift};
use super::resampling::{Affine, applied, composed, resampled};
use super::stm::StmCurve;
use super::{
    Calibration, DepthOptions, Fault, Filters, FocalPair, Method, Optics, Photometric, Window, gram,
    laplacian, stm,
};
use crate::imaging::Image;
use crate::vision::smoothed;

/// Why no estimator can be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EstimatorError {
    /// Faulty options.
    #[error("the options can't be used")]
    Options {
        /// Every faulty option.
        faults: Vec<Fault>,
    },
    /// The method measures no depth by itself.
    #[error(
        "the method laplacian measures contrast, not depth: it needs a calibration with a plane sweep by this method"
    )]
    NeedsTable,
    /// The table belongs to other kernels.
    #[error("the calibration's table was measured with other filters than this release has: sweep it again")]
    OtherFilters,
}

/// Why a pair can't be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EstimateError {
    /// The pair has not the size that the calibration is for.
    #[error(
        "the calibration is for pictures of {calibrated_width_px}×{calibrated_height_px} px, not {width_px}×{height_px}"
    )]
    OtherSize {
        /// Width that the calibration is for.
        calibrated_width_px: usize,
        /// Height that the calibration is for.
        calibrated_height_px: usize,
        /// Width of the pair.
        width_px: usize,
        /// Height of the pair.
        height_px: usize,
    },
}

/// A stage of the estimation, in the order of execution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Scale, affine and shift.
    Register,
    /// Brightness, and halving.
    Match,
    /// Filters, windows, the estimate in each window.
    Estimate,
    /// Table, lens law, flags, median, summary.
    Map,
}

/// All that a rig and options fix, prepared once; estimates any number of pairs.
#[derive(Clone, Debug)]
pub struct Estimator {
    calibration: Calibration,
    options: DepthOptions,
    /// How often the pictures are halved, so that blur fits the filters.
    halvings: u32,
    method: PreparedMethod,
    /// From what the method measures to β, if a sweep has calibrated it.
    table: Option<MonotoneCurve>,
}

/// A method with its filters or curve.
#[derive(Clone, Debug)]
enum PreparedMethod {
    Gram(KernelBank),
    Stm(StmCurve),
    Laplacian,
}

/// The largest blur that the filters reach around, in pixels.
const MOST_BLUR_PX: f64 = 7.5;
/// A shift of less than this is left, in pixels: it is within its own error.
const LEAST_SHIFT_PX: f64 = 0.05;
/// A shift of more than this is worth a warning, in pixels.
const WARN_SHIFT_PX: f64 = 0.25;
/// A gain farther from 1 than this is worth a warning.
const WARN_GAIN: f64 = 0.03;
/// A contrast farther from 1 than this is worth a warning.
const WARN_CONTRAST: f64 = 0.03;
/// Parts by which scale and turn are asked for begin half of their side after each other.
const OVERLAPS: usize = 2;
/// Parts that lie farther off the common map than this have moved, in pixels.
const MOVED_PX: f64 = 0.3;
/// A map by parts that differs less from the shift in every corner is left, in pixels: it is within its own error.
const LEAST_FIT_PX: f64 = 0.3;
/// What a map may leave, in pixels: more is no shift, scale and turn.
const MOST_LEFT_PX: f64 = 0.15;
/// Smoothing before the detail of two apertures is compared, in pixels: against noise.
const DETAIL_PX: f32 = 1.5;
/// Times as much detail in the wider aperture's picture.
const EXCHANGED_DETAIL: f64 = 1.5;
/// Rounding to whole levels and what the sensor's own electronics adds at the least, in levels.
const QUANTUM_LEVELS: f64 = 0.5;

impl Estimator {
    /// Designs the kernels.
    ///
    /// # Errors
    /// [`EstimatorError`]: faulty options, or a calibration that lacks or doesn't match the method's table.
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

    /// The same without a table: what a sweep measures with.
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
        let method = match options.method {
            Method::Gram => PreparedMethod::Gram(KernelBank::new(&shrunk, halvings)),
            Method::Stm => PreparedMethod::Stm(StmCurve::new(&shrunk)),
            Method::Laplacian => PreparedMethod::Laplacian,
        };
        Estimator { calibration: calibration.clone(), options: *options, halvings, method, table: None }
    }

    /// The filters, as a calibration names them.
    pub(super) fn filters(&self) -> Filters {
        let (side, rank, band, numbers) = match &self.method {
            PreparedMethod::Gram(bank) => {
                (bank.side, super::kernels::RANK, super::kernels::BAND, bank.numbers())
            }
            PreparedMethod::Stm(curve) => (0, 0, 0.5, curve.numbers()),
            PreparedMethod::Laplacian => (0, 0, 0.5, Vec::new()),
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

    /// The kernels, if the method has them.
    pub(super) fn bank(&self) -> Option<&KernelBank> {
        match &self.method {
            PreparedMethod::Gram(bank) => Some(bank),
            PreparedMethod::Stm(_) | PreparedMethod::Laplacian => None,
        }
    }

    /// How often the pictures are halved.
    pub(super) fn halvings(&self) -> u32 {
        self.halvings
    }

    /// The depth map of a pair. Calls `finished` after each stage, in order.
    ///
    /// # Errors
    /// [`EstimateError::OtherSize`] if the calibration is for pictures of another size.
    pub fn estimate(
        &self,
        pair: &FocalPair,
        finished: &mut dyn FnMut(Stage),
    ) -> Result<DepthMap, EstimateError> {
        if let Some(image) = self.calibration.image {
            image.check(pair)?;
        }
        let mut registered = self.registered(pair);
        finished(Stage::Register);
        let gain = self.match_brightness(&mut registered);
        self.halve(&mut registered);
        finished(Stage::Match);
        let Estimate { mut samples, noise_sigma } = self.measured(&registered, pair.bits);
        finished(Stage::Estimate);
        self.apply_table(&mut samples);
        let map = DenseMap {
            pair,
            optics: &self.calibration.optics,
            registered: &registered,
            border_px: self.border_px(),
            samples: &samples,
            halvings: self.halvings,
            median: self.options.median,
            gain,
            noise_sigma,
        };
        let map = map.depth_map();
        finished(Stage::Map);
        Ok(map)
    }

    /// What the method measures of a pair, before any table.
    pub(super) fn uncalibrated(&self, pair: &FocalPair) -> Estimate {
        let mut registered = self.registered(pair);
        self.match_brightness(&mut registered);
        self.halve(&mut registered);
        self.measured(&registered, pair.bits)
    }

    /// Both pictures in register and of one brightness.
    pub(super) fn matched(&self, pair: &FocalPair) -> Registered {
        let mut registered = self.registered(pair);
        self.match_brightness(&mut registered);
        registered
    }

    /// Both pictures without offsets, in register.
    fn registered(&self, pair: &FocalPair) -> Registered {
        let (near, far) = without_offsets(pair, self.calibration.photometric);
        let largest_blur_px = self.calibration.optics.largest_blur_px();
        let to_far = match &self.calibration.registration {
            Some(registration) => registration.affine_far_to_near,
            None => scaling(&self.calibration.optics, pair.width(), pair.height()),
        };
        let mut registered = self.brought(near, &far, to_far);
        if exchanged(pair, &to_far, largest_blur_px) || apertures_exchanged(&self.calibration.optics, pair) {
            registered.warnings.insert(0, Warning::NearFarSwapped);
        }
        registered
    }

    /// The far picture brought into register by a map that is nearly right; and by what the pictures show, if the options
    /// ask for it.
    pub(super) fn brought(&self, near: Image, far: &Image, to_far: Affine) -> Registered {
        let brought = resampled(far, &to_far);
        let mut registered =
            Registered { near, far: brought, to_far, shift_px: [0.0; 2], warnings: Vec::new() };
        if self.options.align {
            registered.align(far, self.calibration.optics.largest_blur_px());
        }
        registered
    }

    /// Matches the far picture's brightness, if the options ask for it; returns the gain.
    pub(super) fn match_brightness(&self, registered: &mut Registered) -> f64 {
        let mut gain = 1.0;
        if self.options.match_brightness {
            let largest_blur_px = self.calibration.optics.largest_blur_px();
            let matched = matched(&registered.near, &registered.far, largest_blur_px);
            (registered.far, gain) = (matched.far, matched.gain);
            if (gain - 1.0).abs() > WARN_GAIN {
                registered.warnings.push(Warning::GainOff);
            }
            if (matched.contrast - 1.0).abs() > WARN_CONTRAST {
                registered.warnings.push(Warning::ContrastOff);
            }
        }
        gain
    }

    /// Halves both pictures as often as their blur needs it.
    pub(super) fn halve(&self, registered: &mut Registered) {
        for _ in 0..self.halvings {
            registered.near = halved(&registered.near);
            registered.far = halved(&registered.far);
        }
    }

    /// The method on a registered pair; the noise is that of the pictures as sent.
    pub(super) fn measured(&self, registered: &Registered, bits: u8) -> Estimate {
        let Registered { near, far, .. } = registered;
        let scale = f64::from(1 << self.halvings);
        let quantum = QUANTUM_LEVELS * 255.0 / (2_f64.powi(i32::from(bits)) - 1.0) / scale;
        match &self.method {
            PreparedMethod::Gram(bank) => {
                let noise_gain = noise_gain(self.halvings);
                let least_noise = quantum.max(self.calibrated_noise(near) * noise_gain);
                let estimate =
                    gram::estimate(near, far, bank, self.options.window, self.halvings, least_noise);
                let noise_sigma = estimate.noise_sigma.map(|sigma| sigma / noise_gain);
                Estimate { noise_sigma, ..estimate }
            }
            PreparedMethod::Stm(curve) => {
                let window_px = match self.options.window {
                    Window::Auto => None,
                    Window::Px(px) => Some((px / scale).max(1.0)),
                };
                stm::estimate(near, far, curve, window_px, quantum)
            }
            PreparedMethod::Laplacian => laplacian::estimate(near, far, self.options.window),
        }
    }

    /// Noise of a picture this bright, if the rig's is known; else 0.
    fn calibrated_noise(&self, near: &Image) -> f64 {
        let Some(noise) = self.calibration.noise else { return 0.0 };
        (noise.read_sigma.powi(2) + noise.shot_gain * near.mean().max(0.0)).sqrt()
    }

    fn apply_table(&self, samples: &mut Samples) {
        let Some(table) = &self.table else { return };
        for sample in &mut samples.points {
            let (beta, slope) = table.at(f64::from(sample.beta));
            sample.beta = beta as f32;
            if sample.sigma.is_finite() {
                sample.sigma *= slope.abs() as f32;
            }
        }
    }

    /// Width of the border in which nothing is measured, in pixels.
    pub(super) fn border_px(&self) -> usize {
        let reach = match &self.method {
            PreparedMethod::Gram(bank) => bank.reach(),
            PreparedMethod::Stm(_) => 4,
            PreparedMethod::Laplacian => 2,
        };
        (reach + 2) << self.halvings
    }
}

/// Two pictures in register, and how they were brought there.
pub(super) struct Registered {
    pub(super) near: Image,
    pub(super) far: Image,
    pub(super) to_far: Affine,
    pub(super) shift_px: [f64; 2],
    pub(super) warnings: Vec<Warning>,
}

impl Registered {
    /// Brings the far picture, given as sent, into register: a shift of the whole, then what its parts say of scale and
    /// turn.
    fn align(&mut self, far: &Image, largest_blur_px: f64) {
        let start = self.to_far;
        let whole = shift(&self.near, &self.far, largest_blur_px);
        let [dx, dy] = whole.filter(|[dx, dy]| dx.hypot(*dy) > LEAST_SHIFT_PX).unwrap_or_default();
        self.to_far = composed(&start, &[1.0, 0.0, dx, 0.0, 1.0, dy]);
        let parts = fitted_registration(&self.near, far, &self.to_far, largest_blur_px, OVERLAPS);
        let size = [self.near.width(), self.near.height()];
        match parts.fit {
            None if whole.is_none() => self.warnings.push(Warning::ShiftUnknown),
            Some(fit) if fit.rms_px > MOST_LEFT_PX => self.warnings.push(Warning::Misregistered),
            Some(fit)
                if displacement(&self.to_far, &fit.affine_far_to_near, size).farthest_px > LEAST_FIT_PX =>
            {
                self.to_far = fit.affine_far_to_near;
            }
            _ => {}
        }
        let Displacement { shift_px, scale_px, turn_px, .. } = displacement(&start, &self.to_far, size);
        let raised = [
            (Warning::Shifted, shift_px[0].hypot(shift_px[1]) > WARN_SHIFT_PX),
            (Warning::Scaled, scale_px > WARN_SHIFT_PX),
            (Warning::Rotated, turn_px > WARN_SHIFT_PX),
            (Warning::Moved, parts.fit.is_some() && parts.worst_px > MOVED_PX),
        ];
        self.warnings.extend(raised.iter().filter(|(_, raised)| *raised).map(|(warning, _)| *warning));
        if self.to_far != start {
            self.far = resampled(far, &self.to_far);
            self.shift_px = shift_px;
        }
    }
}

/// How two maps differ over a picture, in pixels.
struct Displacement {
    /// At its middle, x and y.
    shift_px: [f64; 2],
    /// By scale, in its corners.
    scale_px: f64,
    /// By a turn, in its corners.
    turn_px: f64,
    /// In the corner where they differ most.
    farthest_px: f64,
}

fn displacement(before: &Affine, after: &Affine, size: [usize; 2]) -> Displacement {
    let [right, bottom] = size.map(|side| (side - 1) as f64);
    let middle = [right / 2.0, bottom / 2.0];
    let difference = |point: [f64; 2]| {
        let (from, to) = (applied(before, point), applied(after, point));
        [to[0] - from[0], to[1] - from[1]]
    };
    let shift_px = difference(middle);
    let half_diagonal_px = middle[0].hypot(middle[1]);
    let [a, b, _, d, e, _] = *before;
    let [p, q, _, s, t, _] = *after;
    let corners = [[0.0, 0.0], [right, 0.0], [0.0, bottom], [right, bottom]].map(difference);
    Displacement {
        shift_px,
        scale_px: (((p * t - q * s) / (a * e - b * d)).abs().sqrt() - 1.0).abs() * half_diagonal_px,
        turn_px: ((s - q).atan2(p + t) - (d - b).atan2(a + e)).abs() * half_diagonal_px,
        farthest_px: corners.iter().fold(0.0, |most, [dx, dy]| dx.hypot(*dy).max(most)),
    }
}

/// Whether the picture of the wider aperture shows more detail than the other: then they are exchanged.
fn apertures_exchanged(optics: &Optics, pair: &FocalPair) -> bool {
    let [first_mm, second_mm] = optics.apertures_mm();
    if first_mm == second_mm {
        return false;
    }
    let detail = |image: &Image| {
        let laplacian = stm::laplacian(&smoothed(image, DETAIL_PX));
        laplacian.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / image.mean().max(1.0).powi(2)
    };
    let [first, second] = [&pair.near, &pair.far].map(detail);
    let (wide, narrow) = if first_mm > second_mm { (first, second) } else { (second, first) };
    wide > EXCHANGED_DETAIL * narrow
}

/// Both pictures without their dark levels, the far one with its gain.
fn without_offsets(pair: &FocalPair, photometric: Option<Photometric>) -> (Image, Image) {
    let (mut near, mut far) = (pair.near.clone(), pair.far.clone());
    if let Some(Photometric { dark_near, dark_far, gain_far }) = photometric {
        near.pixels_mut().iter_mut().for_each(|v| *v -= dark_near as f32);
        far.pixels_mut().iter_mut().for_each(|v| *v = (*v - dark_far as f32) * gain_far as f32);
    }
    (near, far)
}

/// Standard deviation of white unit noise after so many halvings: the root of the combined kernel's energy.
pub(super) fn noise_gain(halvings: u32) -> f64 {
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
