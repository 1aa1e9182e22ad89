//! The plane sweep (calibration level 2): textured planes that face the camera at known depths become a table.

use thiserror::Error;

use super::calibration::{ImageSize, Noise, Registration, Residual, Table};
use super::estimate::{Estimate, Samples};
use super::monotone::{MonotoneCurve, pooled};
use super::resampling::composed;
use super::{Calibration, DepthOptions, EstimateError, Estimator, FocalPair, Method, Optics, Window};
use crate::eigen::Symmetric;
use crate::statistics::median;

/// Fewer planes are refused.
pub const MIN_PLANES: usize = 5;
/// More planes are refused.
pub const MAX_PLANES: usize = 64;

/// Why a sweep makes no table.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SweepError {
    /// Fewer than [`MIN_PLANES`].
    #[error("{planes} planes are too few: at least {MIN_PLANES}, better 9 to 21")]
    TooFewPlanes {
        /// Planes of the sweep.
        planes: usize,
    },
    /// More than [`MAX_PLANES`].
    #[error("{planes} planes are too many: at most {MAX_PLANES}")]
    TooManyPlanes {
        /// Planes of the sweep.
        planes: usize,
    },
    /// Two planes of one depth.
    #[error("two planes are at {depth_mm} mm")]
    DepthTwice {
        /// Their depth.
        depth_mm: f64,
    },
    /// A depth at which the lens forms no image.
    #[error("{depth_mm} mm is no depth: a number beyond the focal length of {focal_length_mm} mm is needed")]
    NoDepth {
        /// The depth as given.
        depth_mm: f64,
        /// The lens' focal length.
        focal_length_mm: f64,
    },
    /// The planes don't enclose the working range.
    #[error(
        "the planes reach from {nearest_mm} to {farthest_mm} mm; they must reach past both focus distances, {near_focus_mm:.1} and {far_focus_mm:.1} mm"
    )]
    RangeNotCovered {
        /// Depth of the nearest plane.
        nearest_mm: f64,
        /// Depth of the farthest plane.
        farthest_mm: f64,
        /// Near end of the working range.
        near_focus_mm: f64,
        /// Far end of the working range.
        far_focus_mm: f64,
    },
    /// Too few pixels of a plane can be measured.
    #[error("the plane at {depth_mm} mm has too little texture: {percent:.0} % of it can be measured")]
    TooLittleTexture {
        /// Depth of the plane.
        depth_mm: f64,
        /// Measured pixels of the plane's middle, in percent.
        percent: f64,
    },
    /// Neighbouring planes measure in the wrong order.
    #[error(
        "the sweep is not monotone: the plane at {depth_mm} mm measures as if it stood on the other side of its neighbour"
    )]
    NotMonotone {
        /// Depth of the plane.
        depth_mm: f64,
    },
    /// A pair can't be measured.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
}

/// A sweep: a rig, and the planes measured so far.
#[derive(Clone, Debug)]
pub struct Sweep {
    calibration: Calibration,
    options: DepthOptions,
    image: Option<ImageSize>,
    planes: Vec<Plane>,
}

/// The middle of a plane's pictures, and what the method measures of it.
#[derive(Clone, Debug)]
struct Plane {
    depth_mm: f64,
    pair: FocalPair,
    /// Mean gray level of the near-focused picture.
    brightness: f64,
    noise_sigma: Option<f64>,
    estimate: PlaneEstimate,
}

/// What the method measures of a plane: the median of its samples, and their standard deviation about it.
#[derive(Clone, Copy, Debug)]
struct PlaneEstimate {
    median: f64,
    sigma: f64,
}

/// Side of the middle that is kept of a plane, in pixels: enough for its median, and many planes fit into memory.
const MIDDLE_PX: usize = 384;
/// The window that planes are measured over: they have no relief.
const WINDOW_PX: f64 = 7.0;
/// A plane with less of its middle measured has too little texture.
const LEAST_MEASURED: f64 = 0.2;
/// Neighbours in the wrong order by more than this many standard deviations are no accident.
const MOST_VIOLATION: f64 = 2.0;

impl Sweep {
    /// A sweep of a rig for one method, over planes at these depths.
    ///
    /// # Errors
    /// Faults of the depths: too few or too many planes, one depth twice, a range that isn't covered.
    pub fn new(calibration: &Calibration, method: Method, depths_mm: &[f64]) -> Result<Sweep, SweepError> {
        let planes = depths_mm.len();
        if planes < MIN_PLANES {
            return Err(SweepError::TooFewPlanes { planes });
        }
        if planes > MAX_PLANES {
            return Err(SweepError::TooManyPlanes { planes });
        }
        let focal_length_mm = calibration.optics.focal_length_mm;
        let possible = |depth_mm: f64| depth_mm.is_finite() && depth_mm > focal_length_mm;
        if let Some(&depth_mm) = depths_mm.iter().find(|&&depth_mm| !possible(depth_mm)) {
            return Err(SweepError::NoDepth { depth_mm, focal_length_mm });
        }
        let mut sorted = depths_mm.to_vec();
        sorted.sort_by(f64::total_cmp);
        if let Some(twice) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(SweepError::DepthTwice { depth_mm: twice[0] });
        }
        check_range(&calibration.optics, depths_mm)?;
        // The results of an earlier sweep don't count.
        let calibration =
            Calibration { filters: None, table: None, noise: None, residual: None, ..calibration.clone() };
        let options = DepthOptions { method, window: Window::Px(WINDOW_PX), ..DepthOptions::default() };
        Ok(Sweep { image: calibration.image, calibration, options, planes: Vec::new() })
    }

    /// Measures one plane.
    ///
    /// # Errors
    /// A pair of another size, or a plane with too little texture.
    pub fn add(&mut self, depth_mm: f64, pair: &FocalPair) -> Result<(), SweepError> {
        let (width_px, height_px) = (pair.width(), pair.height());
        self.image.get_or_insert(ImageSize { width_px, height_px, bits: pair.bits }).check(pair)?;
        let middle = pair.middle(MIDDLE_PX);
        let dark = self.calibration.photometric.map_or(0.0, |photometric| photometric.dark_near);
        let brightness = -dark + middle.near.mean();
        let estimator = self.estimator(&self.calibration.optics);
        let Estimate { samples, noise_sigma } = estimator.uncalibrated(&middle);
        let estimate = PlaneEstimate::of(&samples, &estimator)
            .map_err(|part| SweepError::TooLittleTexture { depth_mm, percent: 100.0 * part })?;
        self.planes.push(Plane { depth_mm, pair: middle, brightness, noise_sigma, estimate });
        Ok(())
    }

    /// An estimator for the middles of the planes, by an optics.
    fn estimator(&self, optics: &Optics) -> Estimator {
        let Some(image) = self.image else {
            return Estimator::without_table(&self.calibration, &self.options);
        };
        let [left, top] = [image.width_px, image.height_px].map(|side| side.saturating_sub(MIDDLE_PX) / 2);
        let [left, top] = [left as f64, top as f64];
        let axis = optics.principal_point(image.width_px, image.height_px);
        let registration = self.calibration.registration.map(|registration| Registration {
            affine_far_to_near: composed(
                &[1.0, 0.0, -left, 0.0, 1.0, -top],
                &composed(&registration.affine_far_to_near, &[1.0, 0.0, left, 0.0, 1.0, top]),
            ),
            ..registration
        });
        let optics = Optics { principal_point_px: Some([axis[0] - left, axis[1] - top]), ..*optics };
        let middle = Calibration { optics, image: None, registration, ..self.calibration.clone() };
        Estimator::without_table(&middle, &self.options)
    }

    /// The rig with its table; fits its optics (aperture, separation or ratio of apertures, sensor plane) first if
    /// `fit_optics`.
    ///
    /// Calls `step` with the progress (done, total); stops and returns `None` if it returns false.
    ///
    /// # Errors
    /// A sweep that is not monotone; planes that the fitted optics can't measure or that don't cover its range.
    pub fn fit(
        mut self,
        fit_optics: bool,
        step: &mut dyn FnMut(u64, u64) -> bool,
    ) -> Result<Option<Calibration>, SweepError> {
        // From far to near: rising β.
        self.planes.sort_by(|a, b| b.depth_mm.total_cmp(&a.depth_mm));
        if fit_optics && self.options.method != Method::Laplacian {
            let Some(optics) = self.fitted_optics(step) else { return Ok(None) };
            self.adopt(optics)?;
        }
        self.check_order()?;
        let table = self.table();
        if table.raw.last() <= table.raw.first() {
            return Err(SweepError::NotMonotone { depth_mm: self.planes[0].depth_mm });
        }
        let residual = self.leave_one_out(&table);
        let filters = self.estimator(&self.calibration.optics).filters();
        Ok(Some(Calibration {
            image: self.image,
            noise: self.noise(),
            filters: Some(filters),
            table: Some(table),
            residual,
            ..self.calibration
        }))
    }

    /// Replaces the optics by a fitted one, and measures the planes by it.
    fn adopt(&mut self, optics: Optics) -> Result<(), SweepError> {
        let estimator = self.estimator(&optics);
        for plane in &mut self.planes {
            let (depth_mm, samples) = (plane.depth_mm, estimator.uncalibrated(&plane.pair).samples);
            plane.estimate = PlaneEstimate::of(&samples, &estimator)
                .map_err(|part| SweepError::TooLittleTexture { depth_mm, percent: 100.0 * part })?;
        }
        self.calibration.stated.get_or_insert(self.calibration.optics);
        self.calibration.optics = optics;
        let depths_mm: Vec<f64> = self.planes.iter().map(|plane| plane.depth_mm).collect();
        check_range(&optics, &depths_mm)
    }

    /// Whether neighbouring planes measure in their order, but for noise.
    fn check_order(&self) -> Result<(), SweepError> {
        for pair in self.planes.windows(2) {
            let (before, after) = (pair[0].estimate, pair[1].estimate);
            if before.median - after.median > MOST_VIOLATION * before.sigma.hypot(after.sigma) {
                return Err(SweepError::NotMonotone { depth_mm: pair[1].depth_mm });
            }
        }
        Ok(())
    }

    fn table(&self) -> Table {
        let optics = &self.calibration.optics;
        let of = |value: &dyn Fn(&Plane) -> f64| -> Vec<f64> { self.planes.iter().map(value).collect() };
        Table {
            beta: of(&|plane| optics.beta(plane.depth_mm)),
            raw: pooled(&of(&|plane| plane.estimate.median)),
            sigma: of(&|plane| plane.estimate.sigma),
            depth_mm: of(&|plane| plane.depth_mm),
        }
    }

    /// How well the table of all other planes gives the depth of each plane between two others (cross-validation).
    fn leave_one_out(&self, table: &Table) -> Option<Residual> {
        let errors: Vec<f64> = (1..table.beta.len() - 1)
            .map(|left| {
                let others = |values: &[f64]| -> Vec<f64> {
                    values.iter().enumerate().filter(|(k, _)| *k != left).map(|(_, v)| *v).collect()
                };
                let curve = MonotoneCurve::inverse_through(&others(&table.raw), &others(&table.beta));
                let depth_mm =
                    self.calibration.optics.depth_mm(curve.at(self.planes[left].estimate.median).0);
                depth_mm - table.depth_mm[left]
            })
            .collect();
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        let max_mm = errors.iter().fold(0.0_f64, |most, error| most.max(error.abs()));
        mean_square.is_finite().then(|| Residual { rms_mm: mean_square.sqrt(), max_mm })
    }

    /// Noise against brightness, by a straight line through the planes; without a slope if they are equally bright.
    fn noise(&self) -> Option<Noise> {
        let point = |plane: &Plane| Some((plane.brightness, plane.noise_sigma?.powi(2)));
        let points: Vec<(f64, f64)> = self.planes.iter().filter_map(point).collect();
        let count = points.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
        let (level, noise) = (mean(&|point| point.0), mean(&|point| point.1));
        let level_variance = mean(&|point| (point.0 - level).powi(2));
        let slope = mean(&|point| (point.0 - level) * (point.1 - noise)) / level_variance;
        let differ = level_variance.sqrt() > LEAST_BRIGHTNESS_DEVIATION * level;
        let shot_gain = if differ && slope > 0.0 && slope * level < noise { slope } else { 0.0 };
        (!points.is_empty()).then(|| Noise { read_sigma: (noise - shot_gain * level).sqrt(), shot_gain })
    }

    /// The optics whose lens law and blur explain the planes best, near the stated one: Gauss and Newton, with the stated
    /// optics as a prior, as aperture and separation have much the same effect. `None` if `step` returns false.
    fn fitted_optics(&self, step: &mut dyn FnMut(u64, u64) -> bool) -> Option<Optics> {
        let total = (ROUNDS * (1 + UNKNOWNS)) as u64;
        let mut done = 0;
        let stated = self.calibration.optics;
        let mut unknowns = [0.0; UNKNOWNS];
        let mut residuals = |unknowns: &[f64; UNKNOWNS]| -> Option<Vec<f64>> {
            done += 1;
            step(done, total).then(|| self.residuals(&perturbed(&stated, unknowns), unknowns))
        };
        for _ in 0..ROUNDS {
            let here = residuals(&unknowns)?;
            let mut slopes = Vec::with_capacity(UNKNOWNS);
            for k in 0..UNKNOWNS {
                let mut beside = unknowns;
                beside[k] += PROBE;
                let there = residuals(&beside)?;
                slopes.push(
                    there.iter().zip(&here).map(|(there, here)| (there - here) / PROBE).collect::<Vec<f64>>(),
                );
            }
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let normal: Vec<f64> = slopes.iter().flat_map(|a| slopes.iter().map(|b| product(a, b))).collect();
            let right: Vec<f64> = slopes.iter().map(|slope| -product(slope, &here)).collect();
            let Some(normal) = Symmetric::of(&normal, UNKNOWNS) else { break };
            let change = normal.solve(&right);
            for (unknown, change) in unknowns.iter_mut().zip(change) {
                *unknown = (*unknown + change).clamp(-MOST_MOVE, MOST_MOVE);
            }
        }
        Some(perturbed(&stated, &unknowns))
    }

    /// The error of each plane's β, and the unknowns' distance from the stated optics, each over its deviation.
    fn residuals(&self, optics: &Optics, unknowns: &[f64; UNKNOWNS]) -> Vec<f64> {
        let estimator = self.estimator(optics);
        let planes = self.planes.iter().map(|plane| {
            let beta = optics.beta(plane.depth_mm);
            // Which planes count must not change with the unknowns, or losing one would be a gain.
            if self.calibration.optics.beta(plane.depth_mm).abs() > 1.1 {
                return 0.0;
            }
            let estimate = PlaneEstimate::of(&estimator.uncalibrated(&plane.pair).samples, &estimator);
            estimate.map_or(UNMEASURED, |estimate| (estimate.median - beta) / PLANE_SIGMA)
        });
        planes.chain(unknowns.iter().copied()).collect()
    }
}

/// Whether planes reach past both focus distances.
fn check_range(optics: &Optics, depths_mm: &[f64]) -> Result<(), SweepError> {
    let nearest_mm = depths_mm.iter().copied().fold(f64::INFINITY, f64::min);
    let farthest_mm = depths_mm.iter().copied().fold(0.0, f64::max);
    let (near_focus_mm, far_focus_mm) = (optics.near_focus_mm(), optics.far_focus_mm());
    if nearest_mm > near_focus_mm || farthest_mm < far_focus_mm {
        return Err(SweepError::RangeNotCovered { nearest_mm, farthest_mm, near_focus_mm, far_focus_mm });
    }
    Ok(())
}

/// Aperture, separation or ratio of apertures, sensor plane.
const UNKNOWNS: usize = 3;
/// Steps of the fit.
const ROUNDS: usize = 4;
/// Step of the difference quotients, in prior deviations.
const PROBE: f64 = 0.1;
/// How far the fit may go, in prior deviations.
const MOST_MOVE: f64 = 4.0;
/// The residual of a plane that can't be measured any more.
const UNMEASURED: f64 = 50.0;
/// Standard deviation of a plane's β.
const PLANE_SIGMA: f64 = 0.01;
/// Standard deviations of the stated optics: parts of the aperture and of the separation (of an aperture pair: of the ratio
/// of the apertures), and the first sensor's plane in parts of the image's span over the working range.
const PRIORS: [f64; UNKNOWNS] = [0.1, 0.03, 0.25];
/// Planes whose brightness deviates by less, as a part of its mean, don't determine shot noise.
const LEAST_BRIGHTNESS_DEVIATION: f64 = 0.1;

/// The optics with its unknowns changed, in prior deviations; unchanged if the result is no valid optics.
fn perturbed(optics: &Optics, unknowns: &[f64; UNKNOWNS]) -> Optics {
    let [widened, spread, moved]: [f64; UNKNOWNS] = std::array::from_fn(|k| PRIORS[k] * unknowns[k]);
    Optics::new(&optics.perturbed_spec(widened.exp(), spread.exp(), moved)).unwrap_or(*optics)
}

impl PlaneEstimate {
    /// Of the samples away from the border. The error is the measured part of them, if it is too small.
    fn of(samples: &Samples, estimator: &Estimator) -> Result<PlaneEstimate, f64> {
        let border = (estimator.border_px() >> estimator.halvings()).div_ceil(samples.step);
        let inside = |x: usize, count: usize| x >= border && x + border < count;
        let mut values = Vec::new();
        let mut count = 0;
        for y in (0..samples.height).filter(|&y| inside(y, samples.height)) {
            for x in (0..samples.width).filter(|&x| inside(x, samples.width)) {
                let sample = samples.points[y * samples.width + x];
                count += 1;
                if sample.sigma != f32::INFINITY {
                    values.push(f64::from(sample.beta));
                }
            }
        }
        let part = values.len() as f64 / f64::from(count.max(1));
        if part < LEAST_MEASURED {
            return Err(part);
        }
        let Some(median) = median(&mut values, f64::total_cmp) else { return Err(part) };
        let variance = values.iter().map(|value| (value - median).powi(2)).sum::<f64>() / values.len() as f64;
        Ok(PlaneEstimate { median, sigma: variance.sqrt() })
    }
}
