//! The plane sweep (calibration level 2): textured planes that face the camera at known depths become a table.

use thiserror::Error;

use super::calibration::{ImageSize, Noise, Registration, Residual, Table};
use super::estimate::Samples;
use super::monotone::{MonotoneCurve, pooled};
use super::resampling::composed;
use super::{Calibration, DepthOptions, EstimateError, Estimator, FocalPair, Method, Optics, Window};
use crate::eigen::Symmetric;

/// Fewer planes are refused.
pub const MIN_PLANES: usize = 5;
/// More planes are refused.
pub const MAX_PLANES: usize = 64;

/// Why a sweep makes no table.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SweepError {
    #[error("{planes} planes are too few: at least {MIN_PLANES}, better 9 to 21")]
    TooFewPlanes { planes: usize },
    #[error("{planes} planes are too many: at most {MAX_PLANES}")]
    TooManyPlanes { planes: usize },
    #[error("two planes are at {depth_mm} mm")]
    DepthTwice { depth_mm: f64 },
    #[error("{depth_mm} mm is no depth: a number beyond the focal length of {focal_length_mm} mm is needed")]
    NoDepth { depth_mm: f64, focal_length_mm: f64 },
    #[error(
        "the planes reach from {nearest_mm} to {farthest_mm} mm; they must reach past both focus distances, {near_focus_mm:.1} and {far_focus_mm:.1} mm"
    )]
    RangeNotCovered { nearest_mm: f64, farthest_mm: f64, near_focus_mm: f64, far_focus_mm: f64 },
    #[error("the plane at {depth_mm} mm has too little texture: {percent:.0} % of it can be measured")]
    TooLittleTexture { depth_mm: f64, percent: f64 },
    #[error(
        "the sweep is not monotone: the plane at {depth_mm} mm measures as if it stood on the other side of its neighbour"
    )]
    NotMonotone { depth_mm: f64 },
    #[error(transparent)]
    Estimate(#[from] EstimateError),
}

/// A sweep that is being measured.
#[derive(Clone, Debug)]
pub struct Sweep {
    calibration: Calibration,
    options: DepthOptions,
    image: Option<ImageSize>,
    planes: Vec<Plane>,
}

/// The middle of a plane's pictures, and what the method says of it.
#[derive(Clone, Debug)]
struct Plane {
    depth_mm: f64,
    pair: FocalPair,
    /// Mean grey level of the near-focused picture.
    brightness: f64,
    noise_sigma: Option<f64>,
    raw: Raw,
}

/// What the method says of a plane: the middle of its pixels, and their standard deviation.
#[derive(Clone, Copy, Debug)]
struct Raw {
    median: f64,
    sigma: f64,
}

/// Side of what is kept of a plane, in pixels: enough for its median, and many planes fit into memory.
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
    /// What the depths alone tell: too few or too many planes, one depth twice, a range that isn't covered.
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
        covers(&calibration.optics, depths_mm)?;
        // What an earlier sweep found is measured anew.
        let calibration =
            Calibration { filters: None, table: None, noise: None, residual: None, ..calibration.clone() };
        let options = DepthOptions { method, window: Window::Px(WINDOW_PX), ..DepthOptions::default() };
        Ok(Sweep { image: calibration.image, calibration, options, planes: Vec::new() })
    }

    /// Measure one plane.
    ///
    /// # Errors
    /// A pair of another size, or a plane with too little texture.
    pub fn add(&mut self, depth_mm: f64, pair: &FocalPair) -> Result<(), SweepError> {
        let (width_px, height_px) = (pair.width(), pair.height());
        let image = *self.image.get_or_insert(ImageSize { width_px, height_px, bits: pair.bits });
        if (image.width_px, image.height_px) != (width_px, height_px) {
            return Err(SweepError::Estimate(EstimateError::OtherSize {
                calibrated_width_px: image.width_px,
                calibrated_height_px: image.height_px,
                width_px,
                height_px,
            }));
        }
        let middle = pair.middle(MIDDLE_PX);
        let dark = self.calibration.photometric.map_or(0.0, |photometric| photometric.dark_near);
        let brightness = -dark
            + middle.near.pixels().iter().map(|&v| f64::from(v)).sum::<f64>()
                / middle.near.pixels().len() as f64;
        let estimator = self.estimator(&self.calibration.optics);
        let estimate = estimator.raw(&middle);
        let raw = Raw::of(&estimate.samples, &estimator)
            .map_err(|part| SweepError::TooLittleTexture { depth_mm, percent: 100.0 * part })?;
        self.planes.push(Plane {
            depth_mm,
            pair: middle,
            brightness,
            noise_sigma: estimate.noise_sigma,
            raw,
        });
        Ok(())
    }

    /// What measures the middles of the planes by an optics.
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

    /// The rig with its table; its optics (aperture, separation, near plane) are fitted first if `fit_optics`.
    /// `step` is told how far it is (done, total) and says whether to go on; `None` if it said no.
    ///
    /// # Errors
    /// A sweep that is not monotone.
    pub fn fit(
        mut self,
        fit_optics: bool,
        step: &mut dyn FnMut(u64, u64) -> bool,
    ) -> Result<Option<Calibration>, SweepError> {
        self.planes.sort_by(|a, b| b.depth_mm.total_cmp(&a.depth_mm));
        if fit_optics && self.options.method != Method::Laplacian {
            let Some(optics) = self.fitted_optics(step) else { return Ok(None) };
            let estimator = self.estimator(&optics);
            for plane in &mut self.planes {
                let (depth_mm, samples) = (plane.depth_mm, estimator.raw(&plane.pair).samples);
                plane.raw = Raw::of(&samples, &estimator)
                    .map_err(|part| SweepError::TooLittleTexture { depth_mm, percent: 100.0 * part })?;
            }
            self.calibration.stated.get_or_insert(self.calibration.optics);
            self.calibration.optics = optics;
            let depths_mm: Vec<f64> = self.planes.iter().map(|plane| plane.depth_mm).collect();
            covers(&optics, &depths_mm)?;
        }
        // From far to near: rising β.
        for pair in self.planes.windows(2) {
            let (before, after) = (pair[0].raw, pair[1].raw);
            if before.median - after.median > MOST_VIOLATION * before.sigma.hypot(after.sigma) {
                return Err(SweepError::NotMonotone { depth_mm: pair[1].depth_mm });
            }
        }
        let table = self.table();
        if table.raw.last() <= table.raw.first() {
            return Err(SweepError::NotMonotone { depth_mm: self.planes[0].depth_mm });
        }
        let residual = self.left_out(&table);
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

    fn table(&self) -> Table {
        let optics = &self.calibration.optics;
        let raw: Vec<f64> = self.planes.iter().map(|plane| plane.raw.median).collect();
        Table {
            beta: self.planes.iter().map(|plane| optics.beta(plane.depth_mm)).collect(),
            raw: pooled(&raw),
            sigma: self.planes.iter().map(|plane| plane.raw.sigma).collect(),
            depth_mm: self.planes.iter().map(|plane| plane.depth_mm).collect(),
        }
    }

    /// How well the table of all other planes tells the depth of each plane that stands between two others.
    fn left_out(&self, table: &Table) -> Option<Residual> {
        let errors: Vec<f64> = (1..table.beta.len() - 1)
            .map(|left| {
                let others = |values: &[f64]| -> Vec<f64> {
                    values.iter().enumerate().filter(|(k, _)| *k != left).map(|(_, v)| *v).collect()
                };
                let curve = MonotoneCurve::inverse_through(&others(&table.raw), &others(&table.beta));
                let depth_mm = self.calibration.optics.depth_mm(curve.at(self.planes[left].raw.median).0);
                depth_mm - table.depth_mm[left]
            })
            .collect();
        let mean_square = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
        let max_mm = errors.iter().fold(0.0_f64, |most, error| most.max(error.abs()));
        mean_square.is_finite().then(|| Residual { rms_mm: mean_square.sqrt(), max_mm })
    }

    /// Noise against brightness, by a straight line through the planes; without a slope if they are equally bright.
    fn noise(&self) -> Option<Noise> {
        let points: Vec<(f64, f64)> = self
            .planes
            .iter()
            .filter_map(|plane| Some((plane.brightness, plane.noise_sigma?.powi(2))))
            .collect();
        let count = points.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / count;
        let (level, variance) = (mean(&|point| point.0), mean(&|point| point.1));
        let spread = mean(&|point| (point.0 - level).powi(2));
        let slope = mean(&|point| (point.0 - level) * (point.1 - variance)) / spread;
        let sloped =
            spread.sqrt() > LEAST_BRIGHTNESS_SPREAD * level && slope > 0.0 && slope * level < variance;
        let shot_gain = if sloped { slope } else { 0.0 };
        (!points.is_empty()).then(|| Noise { read_sigma: (variance - shot_gain * level).sqrt(), shot_gain })
    }

    /// The optics whose lens law and blur explain the planes best, near the stated one (Gauss and Newton, with what is
    /// stated as a prior: aperture and separation change the answer much alike). `None` if `step` says no.
    fn fitted_optics(&self, step: &mut dyn FnMut(u64, u64) -> bool) -> Option<Optics> {
        let total = (ROUNDS * (1 + UNKNOWNS)) as u64;
        let mut done = 0;
        let stated = self.calibration.optics;
        let mut unknowns = [0.0; UNKNOWNS];
        let mut misses = |unknowns: &[f64; UNKNOWNS]| -> Option<Vec<f64>> {
            done += 1;
            step(done, total).then(|| self.misses(&moved(&stated, unknowns), unknowns))
        };
        for _ in 0..ROUNDS {
            let here = misses(&unknowns)?;
            let mut slopes = Vec::with_capacity(UNKNOWNS);
            for k in 0..UNKNOWNS {
                let mut beside = unknowns;
                beside[k] += PROBE;
                let there = misses(&beside)?;
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
        Some(moved(&stated, &unknowns))
    }

    /// By how much each plane's β is missed, and how far the unknowns are from what is stated, each over its deviation.
    fn misses(&self, optics: &Optics, unknowns: &[f64; UNKNOWNS]) -> Vec<f64> {
        let estimator = self.estimator(optics);
        let planes = self.planes.iter().map(|plane| {
            let beta = optics.beta(plane.depth_mm);
            // Which planes count must not change with the unknowns, or losing one would be a gain.
            if self.calibration.optics.beta(plane.depth_mm).abs() > 1.1 {
                return 0.0;
            }
            let raw = Raw::of(&estimator.raw(&plane.pair).samples, &estimator);
            raw.map_or(UNMEASURED, |raw| (raw.median - beta) / PLANE_SIGMA)
        });
        planes.chain(unknowns.iter().copied()).collect()
    }
}

/// Whether planes reach past both focus distances.
fn covers(optics: &Optics, depths_mm: &[f64]) -> Result<(), SweepError> {
    let nearest_mm = depths_mm.iter().copied().fold(f64::INFINITY, f64::min);
    let farthest_mm = depths_mm.iter().copied().fold(0.0, f64::max);
    let (near_focus_mm, far_focus_mm) = (optics.near_focus_mm(), optics.far_focus_mm());
    if nearest_mm > near_focus_mm || farthest_mm < far_focus_mm {
        return Err(SweepError::RangeNotCovered { nearest_mm, farthest_mm, near_focus_mm, far_focus_mm });
    }
    Ok(())
}

/// Aperture, separation, near plane.
const UNKNOWNS: usize = 3;
/// Steps of the fit.
const ROUNDS: usize = 4;
/// How far the slopes are taken over, in prior deviations.
const PROBE: f64 = 0.1;
/// How far the fit may go, in prior deviations.
const MOST_MOVE: f64 = 4.0;
/// The miss of a plane that can't be measured any more.
const UNMEASURED: f64 = 50.0;
/// Standard deviation of a plane's β.
const PLANE_SIGMA: f64 = 0.01;
/// What is stated may be off by this, one standard deviation: parts of the aperture and of the separation, and the near
/// plane in parts of the separation.
const PRIORS: [f64; UNKNOWNS] = [0.1, 0.03, 0.25];
/// Planes that differ less in brightness tell nothing of shot noise.
const LEAST_BRIGHTNESS_SPREAD: f64 = 0.1;

/// The optics with its unknowns moved, in prior deviations; as it is if that makes none that can be.
fn moved(optics: &Optics, unknowns: &[f64; UNKNOWNS]) -> Optics {
    let [aperture, separation, near_plane]: [f64; UNKNOWNS] =
        std::array::from_fn(|k| PRIORS[k] * unknowns[k]);
    let moved = Optics {
        aperture_mm: optics.aperture_mm * aperture.exp(),
        plane_separation_mm: optics.plane_separation_mm * separation.exp(),
        near_plane_mm: optics.near_plane_mm + optics.plane_separation_mm * near_plane,
        ..*optics
    };
    Optics::new(&moved.spec()).unwrap_or(*optics)
}

impl Raw {
    /// Of the samples away from the border; the part that could be measured if that is too little.
    fn of(samples: &Samples, estimator: &Estimator) -> Result<Raw, f64> {
        let border = (estimator.border_px() >> estimator.halvings()).div_ceil(samples.step);
        let inside = |x: usize, count: usize| x >= border && x + border < count;
        let mut values = Vec::new();
        let mut count = 0;
        for y in (0..samples.height).filter(|&y| inside(y, samples.height)) {
            for x in (0..samples.width).filter(|&x| inside(x, samples.width)) {
                let at = y * samples.width + x;
                count += 1;
                if samples.sigma[at] != f32::INFINITY {
                    values.push(f64::from(samples.beta[at]));
                }
            }
        }
        let part = values.len() as f64 / f64::from(count.max(1));
        if part < LEAST_MEASURED {
            return Err(part);
        }
        let middle = values.len() / 2;
        let (_, &mut median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let variance = values.iter().map(|value| (value - median).powi(2)).sum::<f64>() / values.len() as f64;
        Ok(Raw { median, sigma: variance.sqrt() })
    }
}
