//! A focus stack: three and more pictures of one scene by one camera, focused one after the other from near to far.
//!
//! Neighbours are focal pairs, each with its own working range; together they have the range from the first focus to the
//! last. Every pair is measured in the first picture's geometry, each picture brought into register and brightness with the
//! one before. Where an image lies, v, is one axis for all pairs. On it each pair's energy is a parabola about its own
//! minimum, of the curvature 1/σ²; the sum's minimum is the mean weighed by 1/σ², and its curvature their sum. A pair that
//! says "beyond my end" has no parabola within the others' ranges and leaves the point to them; two that each claim it for
//! themselves contradict each other.

use super::dense_map::{DenseMap, MOST_BETA, MOST_MISFIT};
use super::estimate::{Estimate, Sample, Samples};
use super::estimator::Registered;
use super::registration::scaling;
use super::resampling::{applied, composed};
use super::{
    Aperture, Calibration, DepthMap, DepthOptions, Estimator, EstimatorError, Fault, FocalPair, Optics,
    OpticsSpec, Pair, PairError, Sensor, Stage, Warning,
};
use crate::imaging::{Frame, Image};
use crate::statistics::median;

/// The optics of a stack as described by a user, not validated.
#[derive(Clone, Debug, PartialEq)]
pub struct StackSpec {
    /// Focal length of the lens, in mm.
    pub focal_length_mm: f64,
    /// How wide the lens is.
    pub aperture: Aperture,
    /// Where the sensor of each picture stands, the near-focused first.
    pub sensors: Vec<Sensor>,
    /// The side of a pixel, in µm.
    pub pixel_pitch_um: f64,
    /// Whether a stop in the front focal plane keeps all pictures at one scale.
    pub telecentric: bool,
    /// Where the optical axis meets the picture; the middle if `None`.
    pub principal_point_px: Option<[f64; 2]>,
}

/// The valid optics of a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct StackOptics {
    whole: Optics,
    /// Of neighbours, in pixels of the first picture.
    pairs: Vec<Optics>,
}

/// Three and more pictures of one size, the near-focused first.
#[derive(Clone, Debug, PartialEq)]
pub struct FocusStack {
    first: FocalPair,
    /// The others, each with where it reaches full scale.
    later: Vec<(Image, Vec<bool>)>,
}

/// Estimates the stacks of one optics.
#[derive(Clone, Debug)]
pub struct StackEstimator {
    optics: StackOptics,
    options: DepthOptions,
    estimators: Vec<Estimator>,
}

/// Fewest and most pictures.
pub const STACK_PICTURES: std::ops::RangeInclusive<usize> = 3..=16;
/// A pair's say counts up to this β next to another pair's range: noise carries points across the border.
const MOST_INNER_BETA: f32 = 1.2;
/// The same at the stack's own ends.
const MOST_OUTER_BETA: f32 = 1.1;
/// Two pairs agree within this many standard deviations, and within what textures differ by in β of the whole.
const AGREEMENT: f32 = 3.0;
const AGREEMENT_BETA: f32 = 0.02;
/// A blur, in pixels, that a pair of pictures may have: the whole stack may have more.
const USUAL_BLUR_PX: f64 = 100.0;
/// Of two that don't agree, one whose deviation is this many times the other's doesn't count.
const NO_RIVAL: f32 = 3.0;

impl StackOptics {
    /// The optics of a description.
    ///
    /// # Errors
    /// Every faulty field, by its name in the HTTP contract.
    pub fn new(spec: &StackSpec) -> Result<StackOptics, Vec<Fault>> {
        let field = match spec.sensors.first() {
            Some(Sensor::PlaneMm(_)) => "planes_mm",
            _ => "focuses_mm",
        };
        let fault = |message: String| vec![Fault { field, message }];
        if spec.focal_length_mm <= 0.0 {
            // No sensor has a place by it.
            let message = format!("must be a positive number, not {}", spec.focal_length_mm);
            return Err(vec![Fault { field: "focal_length_mm", message }]);
        }
        if !STACK_PICTURES.contains(&spec.sensors.len()) {
            let (least, most) = (STACK_PICTURES.start(), STACK_PICTURES.end());
            return Err(fault(format!("must be {least} to {most}, not {}", spec.sensors.len())));
        }
        let planes_mm: Option<Vec<f64>> =
            spec.sensors.iter().map(|sensor| sensor.plane_mm(spec.focal_length_mm)).collect();
        let planes_mm = planes_mm.filter(|planes| planes.iter().all(|mm| mm.is_finite()));
        let Some(planes_mm) = planes_mm.filter(|planes| planes.is_sorted_by(|a, b| a > b)) else {
            let near_first =
                "must run from near to far: distances beyond the focal length rise, sensor planes fall";
            return Err(fault(near_first.into()));
        };
        let between = |near: f64, far: f64, aperture: Aperture, pixel_pitch_um: f64| {
            let pair =
                Pair::Focal { aperture, near_sensor: Sensor::PlaneMm(near), plane_separation_mm: near - far };
            let optics = Optics::new(&OpticsSpec {
                focal_length_mm: spec.focal_length_mm,
                pair,
                pixel_pitch_um,
                telecentric: spec.telecentric,
                principal_point_px: spec.principal_point_px,
            });
            // What a pair has under names of its own lies in the stack's list.
            let own = |field| matches!(field, "near_plane_mm" | "plane_separation_mm");
            optics.map_err(|faults| {
                faults
                    .into_iter()
                    .map(|fault| if own(fault.field) { Fault { field, ..fault } } else { fault })
                    .collect::<Vec<_>>()
            })
        };
        let first = planes_mm[0];
        let pairs = planes_mm.windows(2).map(|planes| {
            // An ordinary lens images the first picture largest: in its pixels the others' are larger.
            let enlarged = if spec.telecentric { 1.0 } else { planes[0] / first };
            between(planes[0], planes[1], spec.aperture, spec.pixel_pitch_um * enlarged)
        });
        let pairs: Vec<Optics> = pairs.collect::<Result<_, _>>()?;
        // No two pictures are blurred by as much as the first and the last would be: that isn't limited.
        let blur_px: f64 = pairs.iter().map(Optics::largest_blur_px).sum();
        let narrowed = (blur_px / USUAL_BLUR_PX).max(1.0);
        let aperture = Aperture::DiameterMm(spec.aperture.diameter_mm(spec.focal_length_mm) / narrowed);
        let whole = between(first, planes_mm[planes_mm.len() - 1], aperture, spec.pixel_pitch_um)?;
        Ok(StackOptics { whole: Optics { apertures_mm: pairs[0].apertures_mm, ..whole }, pairs })
    }

    /// The first and the last picture as a focal pair: their working range is the stack's.
    pub fn whole(&self) -> &Optics {
        &self.whole
    }

    /// Neighbouring pictures as focal pairs, near first.
    pub fn pairs(&self) -> &[Optics] {
        &self.pairs
    }
}

impl FocusStack {
    /// A stack of pictures of `bits` bits a sample.
    ///
    /// # Errors
    /// The place of the first picture that makes no pair with the one before it, and why.
    ///
    /// # Panics
    /// If there are fewer than two.
    pub fn new(frames: Vec<Frame>, bits: u8) -> Result<FocusStack, (usize, PairError)> {
        let mut frames = frames.into_iter();
        let [near, far] = [(); 2].map(|()| frames.next().expect("a stack has two pictures and more"));
        let first = FocalPair::new(near, far, bits).map_err(|error| (1, error))?;
        let mut later: Vec<(Image, Vec<bool>)> = Vec::new();
        for (at, frame) in frames.enumerate() {
            let before = later.last().map_or(&first.far, |(picture, _)| picture);
            let pair = FocalPair::new(Frame::gray(before.clone()), frame, bits);
            let FocalPair { far, saturated: [_, marks], .. } = pair.map_err(|error| (at + 2, error))?;
            later.push((far, marks));
        }
        Ok(FocusStack { first, later })
    }

    /// How many pictures it has.
    pub fn pictures(&self) -> usize {
        self.later.len() + 2
    }

    /// The first two pictures.
    pub fn first_pair(&self) -> &FocalPair {
        &self.first
    }
}

/// What one pair measured.
struct PairMeasurement {
    estimate: Estimate,
    shift_px: [f64; 2],
    gain: f64,
}

impl StackEstimator {
    /// Designs the kernels of every pair.
    ///
    /// # Errors
    /// As of [`Estimator::new`].
    pub fn new(optics: &StackOptics, options: &DepthOptions) -> Result<StackEstimator, EstimatorError> {
        let estimators = optics.pairs.iter().map(|&pair| Estimator::new(&Calibration::of(pair), options));
        let estimators = estimators.collect::<Result<_, _>>()?;
        Ok(StackEstimator { optics: optics.clone(), options: *options, estimators })
    }

    /// The depth map of a stack. Calls `finished` after each stage, in order.
    ///
    /// # Panics
    /// If the stack has another number of pictures than the optics.
    pub fn estimate(&self, stack: &FocusStack, finished: &mut dyn FnMut(Stage)) -> DepthMap {
        assert_eq!(stack.pictures(), self.estimators.len() + 1, "a picture for each sensor");
        let FocusStack { first, later } = stack;
        let (width, height) = (first.width(), first.height());
        let mut near = first.near.clone();
        let mut to_near = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let mut saturated = first.saturated[0].clone();
        let mut measurements = Vec::new();
        let mut warnings: Vec<Warning> = Vec::new();
        let second = std::iter::once((&first.far, &first.saturated[1]));
        let fars = second.chain(later.iter().map(|(far, marks)| (far, marks)));
        for ((estimator, (far, marks)), optics) in self.estimators.iter().zip(fars).zip(&self.optics.pairs) {
            let to_far = composed(&scaling(optics, width, height), &to_near);
            let mut registered = estimator.brought(near, far, to_far);
            let gain = estimator.match_brightness(&mut registered);
            near = registered.far.clone();
            to_near = registered.to_far;
            estimator.halve(&mut registered);
            for (at, mark) in saturated.iter_mut().enumerate() {
                let [u, v] = applied(&to_near, [(at % width) as f64, (at / width) as f64]);
                let (x, y) =
                    (u.round().clamp(0.0, (width - 1) as f64), v.round().clamp(0.0, (height - 1) as f64));
                *mark |= marks[y as usize * width + x as usize];
            }
            let new = registered.warnings.iter().filter(|warning| !warnings.contains(warning));
            let new: Vec<Warning> = new.copied().collect();
            warnings.extend(new);
            let estimate = estimator.measured(&registered, first.bits);
            measurements.push(PairMeasurement { estimate, shift_px: registered.shift_px, gain });
        }
        finished(Stage::Estimate);
        let (samples, halvings) = self.joined(&measurements);
        let mut noises: Vec<f64> = measurements.iter().filter_map(|pair| pair.estimate.noise_sigma).collect();
        let noise_sigma = median(&mut noises, f64::total_cmp);
        // What is told of all pictures is told of the one that was farthest off.
        let farthest = |of: &dyn Fn(&PairMeasurement) -> f64| {
            measurements.iter().max_by(|a, b| of(a).total_cmp(&of(b))).expect("a stack has pairs")
        };
        let shift_px = farthest(&|pair| pair.shift_px[0].hypot(pair.shift_px[1])).shift_px;
        let gain = farthest(&|pair| (pair.gain - 1.0).abs()).gain;
        let last = later.last().map_or(&first.far, |(far, _)| far);
        let registered = Registered { near: near.clone(), far: near, to_far: to_near, shift_px, warnings };
        let marked = FocalPair {
            near: first.near.clone(),
            far: last.clone(),
            saturated: [saturated, vec![false; width * height]],
            bits: first.bits,
        };
        let map = DenseMap {
            pair: &marked,
            optics: &self.optics.whole,
            registered: &registered,
            border_px: self.estimators.iter().map(Estimator::border_px).max().unwrap_or(0),
            samples: &samples,
            halvings,
            median: self.options.median,
            gain,
            noise_sigma,
        };
        let map = map.depth_map();
        finished(Stage::Map);
        map
    }

    /// The pairs' measurements on the axis of the whole, on the finest of their grids; and how often that was halved.
    fn joined(&self, measurements: &[PairMeasurement]) -> (Samples, u32) {
        let step_px = |k: usize| measurements[k].estimate.samples.step << self.estimators[k].halvings();
        let finest = (0..measurements.len()).min_by_key(|&k| step_px(k)).expect("a stack has pairs");
        let &Samples { width, height, step, .. } = &measurements[finest].estimate.samples;
        let point = |at: usize| {
            let place_px = [at % width, at / width].map(|v| v * step_px(finest));
            let say = |k: usize| {
                let samples = &measurements[k].estimate.samples;
                let nearest = |px: usize, count: usize| ((px + step_px(k) / 2) / step_px(k)).min(count - 1);
                let (x, y) = (nearest(place_px[0], samples.width), nearest(place_px[1], samples.height));
                samples.points[y * samples.width + x]
            };
            self.joint((0..measurements.len()).map(say).collect::<Vec<Sample>>().as_slice())
        };
        let points = (0..width * height).map(point).collect();
        (Samples { width, height, step, points }, self.estimators[finest].halvings())
    }

    /// What the pairs say of one point together.
    fn joint(&self, said: &[Sample]) -> Sample {
        let last = said.len() - 1;
        let whole = &self.optics.whole;
        let on_whole = |(k, sample): (usize, &Sample)| {
            let pair = &self.optics.pairs[k];
            let image_mm = pair.far_image_mm + 0.5 * pair.image_span_mm * (1.0 + f64::from(sample.beta));
            let beta = 2.0 * (image_mm - whole.far_image_mm) / whole.image_span_mm - 1.0;
            let sigma = sample.sigma * (pair.image_span_mm / whole.image_span_mm) as f32;
            Sample { beta: beta as f32, sigma, ..*sample }
        };
        let measured = |sample: &Sample| sample.sigma.is_finite() && !sample.ambiguous && !sample.scattered;
        let within = |(k, sample): &(usize, &Sample)| {
            let limit = |is_end: bool| if is_end { MOST_OUTER_BETA } else { MOST_INNER_BETA };
            measured(sample)
                && sample.misfit <= MOST_MISFIT
                && sample.beta <= limit(*k == 0)
                && sample.beta >= -limit(*k == last)
        };
        let candidates: Vec<Sample> = said.iter().enumerate().filter(within).map(on_whole).collect();
        let Some(best) = candidates.iter().min_by(|a, b| a.sigma.total_cmp(&b.sigma)) else {
            return self.without_candidates(said);
        };
        let agrees = |other: &&Sample| {
            (other.beta - best.beta).abs() <= AGREEMENT * other.sigma.hypot(best.sigma) + AGREEMENT_BETA
        };
        let (mut weights, mut sum, mut misfit) = (0.0, 0.0, 0.0_f32);
        for sample in candidates.iter().filter(agrees) {
            let weight = sample.sigma.max(f32::MIN_POSITIVE).powi(-2);
            weights += weight;
            sum += weight * sample.beta;
            misfit = misfit.max(sample.misfit);
        }
        let contradicted =
            candidates.iter().any(|other| !agrees(&other) && other.sigma < NO_RIVAL * best.sigma);
        Sample {
            beta: sum / weights,
            sigma: 1.0 / weights.sqrt(),
            misfit,
            ambiguous: false,
            scattered: contradicted,
        }
    }

    /// A point that no pair has in its range: out of the stack's range if a pair at its end says so, else for the reason
    /// that a pair has.
    fn without_candidates(&self, said: &[Sample]) -> Sample {
        let outside = |sample: &Sample, beyond: f32| {
            sample.sigma.is_finite() && sample.misfit <= MOST_MISFIT && sample.beta * beyond > MOST_OUTER_BETA
        };
        let last = said.len() - 1;
        for (k, beyond) in [(0, 1.0), (last, -1.0)] {
            let sample = &said[k];
            if outside(sample, beyond) {
                // Just beyond the range: its error is that of the range's end.
                let share = self.optics.pairs[k].image_span_mm / self.optics.whole.image_span_mm;
                return Sample {
                    beta: 1.01 * MOST_BETA * beyond,
                    sigma: sample.sigma * share as f32,
                    scattered: false,
                    ambiguous: false,
                    ..*sample
                };
            }
        }
        Sample {
            ambiguous: said.iter().any(|sample| sample.ambiguous),
            scattered: said.iter().any(|sample| sample.scattered || sample.misfit > MOST_MISFIT),
            ..Sample::UNKNOWN
        }
    }
}
