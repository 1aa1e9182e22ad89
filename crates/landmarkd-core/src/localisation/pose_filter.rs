//! Where a robot is on its way: a particle filter over x, y and heading (Thrun, Burgard and Fox 2005, Probabilistic
//! Robotics, chapter 8: Monte Carlo localisation, augmented so that a robot that was carried away is found again).
//!
//! Odometry moves the particles, fixes weigh them. A fix is either about right, with the errors that its covariance says, or
//! wrong altogether; where fixes turn out wrong more often than they used to, some particles are drawn from the fix
//! itself (sensor resetting, Lenser and Veloso 2000). Everything follows from the seed.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::eigen::Symmetric;
use crate::geometry::{DMat3, DVec3};
use crate::random::Random;

/// Particles.
const PARTICLES: usize = 1000;
/// Part of the fixes that is wrong altogether.
const WRONG: f64 = 0.1;
/// Density of wrong fixes: anywhere in so many square metres, with any heading.
const WRONG_DENSITY: f64 = 1.0 / (200.0 * TAU);
/// Below so many effective particles they say little of a fix.
const DEPLETED: f64 = 50.0;
/// Weights of the newest fix in the short and the long average of how well fixes are expected.
const FAST: f64 = 0.4;
const SLOW: f64 = 0.05;
/// Part of the particles that is drawn from one fix at most: two fixes that agree are needed to outweigh a place.
const MOST_INJECTED: f64 = 0.3;
/// Standard deviation of odometry: part of the way, and of the turn; turn a metre of way; and when it stands still.
const WAY_PART: f64 = 0.05;
const TURN_PART: f64 = 0.05;
const TURN_RAD_PER_M: f64 = 0.02;
const STILL_M: f64 = 0.003;
const STILL_RAD: f64 = 0.002;
/// Standard deviations of the unknown motion between frames without odometry.
const STRIDE_M: f64 = 0.3;
const STRIDE_RAD: f64 = 0.25;
/// After this way, or this turn, the errors of a fix are other ones: until then it says in part the same again.
const FRESH_M: f64 = 0.3;
const FRESH_RAD: f64 = 0.35;
/// A fix from where the last one was taken counts so much.
const LEAST_FRESH: f64 = 0.05;
/// Fixes are never taken to be better than this.
const LEAST_SIGMA_M: f64 = 0.01;
const LEAST_SIGMA_RAD: f64 = 0.003;
/// It is lost beyond these standard deviations, where less than this part of the fixes was expected of late, or where less
/// than this part of the particles is about one place.
const LOST_M: f64 = 1.5;
const LOST_RAD: f64 = 0.8;
const LOST_EXPECTED: f64 = 0.4;
const LOST_SHARE: f64 = 0.5;
/// Squared Mahalanobis distance within which particles are about one place.
const ONE_PLACE: f64 = 16.0;

/// A motion since the frame before, in the robot's body frame there: x forward, y left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odometry {
    /// Forward.
    pub dx_m: f64,
    /// To the left.
    pub dy_m: f64,
    /// Counter-clockwise.
    pub dyaw_deg: f64,
}

/// A pose on the plane of a map, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePose {
    /// Along the map's x axis.
    pub x_m: f64,
    /// Along the map's y axis.
    pub y_m: f64,
    /// Heading, in (−180, 180].
    pub yaw_deg: f64,
    /// Of x (m), y (m) and heading (rad).
    pub covariance: [[f64; 3]; 3],
}

/// What a filter believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean of the particles about the likeliest place.
    pub pose: PlanePose,
    /// Whether it is better not relied on: the particles are spread wide or over several places, or fixes are not where they
    /// were expected.
    pub lost: bool,
}

/// Particles that follow a robot in one map.
#[derive(Clone, Debug)]
pub struct PoseFilter {
    particles: Vec<Particle>,
    random: Random,
    /// Short and long average of the probability that a fix is about right.
    fast: f64,
    slow: f64,
    /// How much of the next fix is new, of 1.
    fresh: f64,
    fixes: u32,
}

#[derive(Clone, Copy, Debug)]
struct Particle {
    /// x, y, heading in rad.
    state: DVec3,
    weight: f64,
    /// The fix that it was drawn from: those of one fix are about one place.
    drawn_from: u32,
}

impl PoseFilter {
    /// Memory that its particles take.
    pub const BYTES: usize = PARTICLES * size_of::<Particle>();

    /// A robot that may be anywhere, until the first fix.
    pub fn new(seed: u64) -> PoseFilter {
        PoseFilter {
            particles: Vec::new(),
            random: Random::new(seed, 14),
            fast: 1.0,
            slow: 1.0,
            fresh: 1.0,
            fixes: 0,
        }
    }

    /// The robot moved; without odometry, by some stride in any direction.
    pub fn predict(&mut self, odometry: Option<&Odometry>) {
        let motion = odometry.copied().unwrap_or_default();
        let (way_m, turn_rad) = (motion.dx_m.hypot(motion.dy_m), motion.dyaw_deg.to_radians());
        let (sigma_m, sigma_rad) = match odometry {
            Some(_) => (
                STILL_M.hypot(WAY_PART * way_m),
                STILL_RAD.hypot(TURN_PART * turn_rad).hypot(TURN_RAD_PER_M * way_m),
            ),
            None => (STRIDE_M, STRIDE_RAD),
        };
        let fresh = if odometry.is_some() { way_m / FRESH_M + turn_rad.abs() / FRESH_RAD } else { 1.0 };
        self.fresh = (self.fresh + fresh).min(1.0);
        for particle in &mut self.particles {
            let ([x, y], [turn, _]) = (self.random.normals(), self.random.normals());
            let (dx_m, dy_m) = (motion.dx_m + sigma_m * x, motion.dy_m + sigma_m * y);
            // the way is told in the frame before the turn
            let turn_rad = turn_rad + sigma_rad * turn;
            let (sin, cos) = particle.state.z.sin_cos();
            particle.state += DVec3::new(cos * dx_m - sin * dy_m, sin * dx_m + cos * dy_m, turn_rad);
        }
    }

    /// A frame said where the robot is.
    pub fn update(&mut self, fix: &PlanePose) {
        let mean = DVec3::new(fix.x_m, fix.y_m, fix.yaw_deg.to_radians());
        let Some(spread) = Spread::of(fix.covariance) else { return };
        self.fixes += 1;
        let flatter = spread.scaled(1.0 / self.fresh.max(LEAST_FRESH));
        self.fresh = 0.0;
        let Some(place) = self.likeliest() else { return self.inject(PARTICLES, mean, &spread) };
        let wrong = WRONG * WRONG_DENSITY;
        let mut right = self.weigh(|particle| (1.0 - WRONG) * flatter.density(apart(mean, particle.state)));
        // where the particles are too few to tell, those of the likeliest place are taken for a normal distribution
        let is_depleted = self.effective() < DEPLETED;
        let fused = is_depleted.then(|| place.fused(mean, &flatter)).flatten();
        let fused = fused.filter(|fused| (1.0 - WRONG) * fused.density > wrong);
        if let Some(fused) = &fused {
            right = right.max((1.0 - WRONG) * fused.density);
        }
        let expected = right / (right + wrong);
        self.fast += FAST * (expected - self.fast);
        self.slow += SLOW * (expected - self.slow);
        if let Some(Fused { mean, spread, .. }) = fused {
            self.particles.clear();
            return self.inject(PARTICLES, mean, &spread);
        }
        let injected = ((1.0 - self.fast / self.slow).clamp(0.0, MOST_INJECTED) * PARTICLES as f64) as usize;
        if injected > 0 || self.effective() < 0.5 * PARTICLES as f64 {
            self.resample(PARTICLES - injected);
            self.inject(injected, mean, &spread);
        }
        self.join();
    }

    /// Multiplies the weights by the density of a fix, and the wrong ones'; returns the density of right ones before.
    fn weigh(&mut self, density: impl Fn(&Particle) -> f64) -> f64 {
        let mut right = 0.0;
        for particle in &mut self.particles {
            let density = density(particle);
            right += particle.weight * density;
            particle.weight *= density + WRONG * WRONG_DENSITY;
        }
        let total: f64 = self.particles.iter().map(|particle| particle.weight).sum();
        self.particles.iter_mut().for_each(|particle| particle.weight /= total);
        right
    }

    /// How many particles of equal weight would say as much.
    fn effective(&self) -> f64 {
        1.0 / self.particles.iter().map(|particle| particle.weight.powi(2)).sum::<f64>()
    }

    /// What the particles say; `None` before the first fix.
    pub fn estimate(&self) -> Option<Estimate> {
        let place = self.likeliest()?;
        let spread = Spread::of(place.covariance)?;
        let share: f64 = self.about(&place, &spread).map(|index| self.particles[index].weight).sum();
        let [[xx, xy, _], [_, yy, _], [_, _, turn]] = place.covariance;
        let widest = 0.5 * (xx + yy) + (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let lost = widest.sqrt() > LOST_M
            || turn.sqrt() > LOST_RAD
            || self.fast < LOST_EXPECTED
            || share < LOST_SHARE;
        let DVec3 { x: x_m, y: y_m, z: yaw_rad } = place.mean;
        let pose = PlanePose { x_m, y_m, yaw_deg: yaw_rad.to_degrees(), covariance: place.covariance };
        Some(Estimate { pose, lost })
    }

    /// The place of those particles drawn from one fix that weigh most.
    fn likeliest(&self) -> Option<Place> {
        let mut weights = BTreeMap::new();
        for particle in &self.particles {
            *weights.entry(particle.drawn_from).or_insert(0.0) += particle.weight;
        }
        let (&fix, &total) = weights.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
        let of_fix = || self.particles.iter().filter(|particle| particle.drawn_from == fix);
        let first = of_fix().next()?.state;
        let mean_of = |value: &dyn Fn(DVec3) -> DVec3| -> DVec3 {
            of_fix().map(|particle| particle.weight / total * value(apart(particle.state, first))).sum()
        };
        let mean = mean_of(&|off| off);
        let covariance = [0, 1, 2].map(|axis| mean_of(&|off| (off - mean) * (off - mean)[axis]).to_array());
        let DVec3 { x, y, z } = first + mean;
        Some(Place { fix, mean: DVec3::new(x, y, turned(z)), covariance })
    }

    /// Indices of the particles that are about a place.
    fn about(&self, place: &Place, spread: &Spread) -> impl Iterator<Item = usize> {
        let near = |particle: &Particle| spread.squared(apart(particle.state, place.mean)) < ONE_PLACE;
        (0..self.particles.len()).filter(move |&index| near(&self.particles[index]))
    }

    /// What came to lie about the likeliest place belongs to it, whatever fix it was drawn from.
    fn join(&mut self) {
        let Some(place) = self.likeliest() else { return };
        let Some(spread) = Spread::of(place.covariance) else { return };
        let there: Vec<usize> = self.about(&place, &spread).collect();
        there.into_iter().for_each(|index| self.particles[index].drawn_from = place.fix);
    }

    /// So many particles, as often as their weights say (systematic resampling).
    fn resample(&mut self, count: usize) {
        let step = 1.0 / count as f64;
        let (mut goal, mut sum, mut at) = (step * self.random.uniform(), self.particles[0].weight, 0);
        let weight = 1.0 / PARTICLES as f64;
        let kept = (0..count).map(|_| {
            while sum < goal && at + 1 < self.particles.len() {
                at += 1;
                sum += self.particles[at].weight;
            }
            goal += step;
            Particle { weight, ..self.particles[at] }
        });
        self.particles = kept.collect();
    }

    /// So many particles more, drawn from a fix.
    fn inject(&mut self, count: usize, mean: DVec3, spread: &Spread) {
        for _ in 0..count {
            let ([a, b], [c, _]) = (self.random.normals(), self.random.normals());
            let state = mean + spread.root * DVec3::new(a, b, c);
            let weight = 1.0 / PARTICLES as f64;
            self.particles.push(Particle { state, weight, drawn_from: self.fixes });
        }
    }
}

/// Particles that are about one place.
struct Place {
    fix: u32,
    /// x, y, heading in rad.
    mean: DVec3,
    covariance: [[f64; 3]; 3],
}

/// The product of a place, taken for a normal distribution, and a fix.
struct Fused {
    mean: DVec3,
    spread: Spread,
    /// Density of the fix by the place alone.
    density: f64,
}

impl Place {
    fn fused(&self, fix: DVec3, spread: &Spread) -> Option<Fused> {
        let own = Spread::of(self.covariance)?;
        let off = apart(fix, self.mean);
        let both = (own.inverse + spread.inverse).inverse();
        let sum = Spread::of((own.inverse.inverse() + spread.inverse.inverse()).to_cols_array_2d())?;
        Some(Fused {
            mean: self.mean + both * (spread.inverse * off),
            spread: Spread::of(both.to_cols_array_2d())?,
            density: sum.density(off),
        })
    }
}

/// A covariance of x, y and heading in rad, taken apart.
struct Spread {
    /// Its inverse.
    inverse: DMat3,
    /// Takes independent normal numbers to its own.
    root: DMat3,
    /// Density at its middle.
    peak: f64,
}

impl Spread {
    /// None of what is not finite.
    fn of(covariance: [[f64; 3]; 3]) -> Option<Spread> {
        let mut entries = covariance;
        let least = [LEAST_SIGMA_M, LEAST_SIGMA_M, LEAST_SIGMA_RAD];
        least.iter().enumerate().for_each(|(axis, sigma)| entries[axis][axis] += sigma * sigma);
        let eigen = Symmetric::of(entries.as_flattened(), 3)?;
        let floor = LEAST_SIGMA_RAD * LEAST_SIGMA_RAD;
        let values = [0, 1, 2].map(|k| eigen.values[k].max(floor));
        let vectors = [0, 1, 2].map(|k| DVec3::from_slice(&eigen.vectors[k]));
        let axes = DMat3::from_cols(vectors[0], vectors[1], vectors[2]);
        let scaled = |by: [f64; 3]| axes * DMat3::from_diagonal(DVec3::from_array(by));
        let determinant: f64 = values.iter().product();
        Some(Spread {
            inverse: scaled(values.map(f64::recip)) * axes.transpose(),
            root: scaled(values.map(f64::sqrt)),
            peak: (TAU.powi(3) * determinant).sqrt().recip(),
        })
    }

    /// The variances so many times as large.
    fn scaled(&self, factor: f64) -> Spread {
        Spread {
            inverse: self.inverse * factor.recip(),
            root: self.root * factor.sqrt(),
            peak: self.peak / factor.powf(1.5),
        }
    }

    /// The squared Mahalanobis distance.
    fn squared(&self, off: DVec3) -> f64 {
        off.dot(self.inverse * off)
    }

    fn density(&self, off: DVec3) -> f64 {
        self.peak * (-0.5 * self.squared(off)).exp()
    }
}

/// What one state differs from another by, the smaller way round.
fn apart(a: DVec3, b: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = a - b;
    DVec3::new(x, y, turned(z))
}

/// The same heading in (−π, π].
fn turned(yaw_rad: f64) -> f64 {
    PI - (PI - yaw_rad).rem_euclid(TAU)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::MapPose;

    #[test]
    fn a_drive_told_step_by_step_ends_where_its_motions_lead() {
        let mut filter = PoseFilter::new(3);
        let start = MapPose { x_m: 2.0, y_m: 3.0, yaw_deg: 20.0, ..MapPose::default() };
        filter.update(&PlanePose {
            x_m: 2.0,
            y_m: 3.0,
            yaw_deg: 20.0,
            covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-5]],
        });
        let step = MapPose { x_m: 0.3, y_m: 0.1, yaw_deg: 40.0, ..MapPose::default() };
        let mut truth = start.transform();
        for _ in 0..5 {
            truth = truth.then(&step.transform());
            filter.predict(Some(&Odometry { dx_m: 0.3, dy_m: 0.1, dyaw_deg: 40.0 }));
        }
        let (truth, told) = (MapPose::of(&truth), filter.estimate().unwrap().pose);
        let off_m = (told.x_m - truth.x_m).hypot(told.y_m - truth.y_m);
        let turned = turned((told.yaw_deg - truth.yaw_deg).to_radians()).to_degrees();
        assert!(off_m < 0.05 && turned.abs() < 3.0, "{off_m} m and {turned} degrees off");
    }

    /// A robot that walks in a hall, in strides of 0.3 m, and the odometry that it posts.
    struct Walk {
        state: DVec3,
        random: Random,
    }

    impl Walk {
        fn new(seed: u64) -> Walk {
            Walk { state: DVec3::new(2.0, 3.0, 0.4), random: Random::new(seed, 900) }
        }

        /// One stride: on, and about a circle or back.
        fn stride(&mut self, frame: usize) -> Odometry {
            let turn_deg = if (frame / 20).is_multiple_of(2) { 9.0 } else { -6.0 };
            let odometry = Odometry { dx_m: 0.3, dy_m: 0.0, dyaw_deg: turn_deg };
            let ([a, b], [c, _]) = (self.random.normals(), self.random.normals());
            let sigma_m = STILL_M.hypot(WAY_PART * 0.3);
            let turn_rad = turn_deg.to_radians();
            let sigma_rad = STILL_RAD.hypot(TURN_PART * turn_rad).hypot(TURN_RAD_PER_M * 0.3);
            let turn = turn_rad + sigma_rad * c;
            let (sin, cos) = self.state.z.sin_cos();
            let (dx, dy) = (0.3 + sigma_m * a, sigma_m * b);
            self.state += DVec3::new(cos * dx - sin * dy, sin * dx + cos * dy, turn);
            odometry
        }

        /// What a frame says, with errors of 0.15 m and 3°.
        fn fix(&mut self) -> PlanePose {
            self.fix_within(1.0)
        }

        /// What a frame says, with errors so many times as large.
        fn fix_within(&mut self, scale: f64) -> PlanePose {
            let ([a, b], [c, _]) = (self.random.normals(), self.random.normals());
            let fix = fix_at(self.state + scale * DVec3::new(0.15 * a, 0.15 * b, 0.052 * c));
            PlanePose { covariance: fix.covariance.map(|row| row.map(|v| scale * scale * v)), ..fix }
        }
    }

    fn fix_at(state: DVec3) -> PlanePose {
        PlanePose {
            x_m: state.x,
            y_m: state.y,
            yaw_deg: state.z.to_degrees(),
            covariance: [[0.0225, 0.0, 0.0], [0.0, 0.0225, 0.0], [0.0, 0.0, 0.0027]],
        }
    }

    fn off(estimate: &Estimate, state: DVec3) -> DVec3 {
        let pose = &estimate.pose;
        apart(DVec3::new(pose.x_m, pose.y_m, pose.yaw_deg.to_radians()), state)
    }

    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        // 60 walks of 80 frames: at each frame the mean of NEES over the walks is χ² of 180 degrees of freedom over 60
        const WALKS: usize = 60;
        const FRAMES: usize = 80;
        let band = 2.38_f64..3.67;
        let mut sums = [0.0; FRAMES];
        for walk in 0..WALKS as u64 {
            let (mut robot, mut filter) = (Walk::new(walk), PoseFilter::new(walk));
            for (frame, sum) in sums.iter_mut().enumerate() {
                filter.predict(Some(&robot.stride(frame)));
                // good fixes among vague ones, as places are near and far
                filter.update(&robot.fix_within([1.0, 4.0, 0.4, 8.0][(walk as usize + frame) % 4]));
                let estimate = filter.estimate().unwrap();
                assert!(frame < 8 || !estimate.lost, "walk {walk}, frame {frame}");
                let inverse = Symmetric::of(estimate.pose.covariance.as_flattened(), 3).unwrap();
                let off = off(&estimate, robot.state);
                *sum += off.dot(DVec3::from_slice(&inverse.solve(&off.to_array()))) / WALKS as f64;
            }
        }
        let inside = sums.iter().filter(|mean| band.contains(*mean)).count();
        println!("mean {:.2}, inside {inside} of {FRAMES}", sums.iter().sum::<f64>() / FRAMES as f64);
        assert!(inside as f64 >= 0.9 * FRAMES as f64, "{inside} of {FRAMES}: {sums:?}");
    }

    #[test]
    fn a_robot_that_was_carried_away_is_found_again() {
        let mut worst = 0;
        for walk in 0..40 {
            let (mut robot, mut filter) = (Walk::new(walk), PoseFilter::new(walk));
            for frame in 0..30 {
                filter.predict(Some(&robot.stride(frame)));
                filter.update(&robot.fix());
            }
            robot.state += DVec3::new(6.0, -4.0, 2.0);
            let found = (0..20).find(|frame| {
                filter.predict(Some(&robot.stride(*frame)));
                filter.update(&robot.fix());
                let estimate = filter.estimate().unwrap();
                let near = off(&estimate, robot.state).truncate().length() < 0.5;
                assert!(near || *frame == 0 || estimate.lost, "walk {walk}: sure of the wrong place");
                near && !estimate.lost
            });
            worst = worst.max(found.unwrap() + 1);
        }
        println!("found again after {worst} frames at most");
        assert!(worst <= 3, "{worst}");
    }

    #[test]
    fn one_wrong_fix_of_ten_leads_nobody_astray() {
        let (mut astray, mut lost, mut frames) = (0, 0, 0);
        for walk in 0..40 {
            let (mut robot, mut filter) = (Walk::new(walk), PoseFilter::new(walk));
            let mut random = Random::new(walk, 901);
            for frame in 0..100 {
                filter.predict(Some(&robot.stride(frame)));
                let wrong = frame > 0 && random.uniform() < 0.1;
                let anywhere = DVec3::new(
                    random.between(-8.0, 12.0),
                    random.between(-8.0, 12.0),
                    random.between(-PI, PI),
                );
                filter.update(&if wrong { fix_at(anywhere) } else { robot.fix() });
                let estimate = filter.estimate().unwrap();
                let is_near = off(&estimate, robot.state).truncate().length() < 0.5;
                frames += 1;
                astray += usize::from(!is_near && !estimate.lost);
                lost += usize::from(estimate.lost);
            }
        }
        println!("{astray} astray, {lost} lost of {frames}");
        assert!(astray == 0 && lost < frames / 20, "{astray} astray, {lost} lost of {frames}");
    }

    #[test]
    fn a_robot_that_stands_still_does_not_grow_sure_of_one_wrong_measure() {
        let mut filter = PoseFilter::new(3);
        let fix = fix_at(DVec3::new(1.0, 2.0, 0.0));
        for _ in 0..40 {
            filter.predict(Some(&Odometry::default()));
            filter.update(&fix);
        }
        let sigma_m = filter.estimate().unwrap().pose.covariance[0][0].sqrt();
        // forty independent fixes would make it 0.024 m
        assert!(sigma_m > 0.07, "{sigma_m}");
    }

    #[test]
    fn without_fixes_it_is_lost_in_time_and_without_a_first_one_it_knows_nothing() {
        let mut filter = PoseFilter::new(5);
        filter.predict(None);
        assert_eq!(filter.estimate(), None);
        filter.update(&fix_at(DVec3::new(1.0, 2.0, 3.1)));
        assert!(!filter.estimate().unwrap().lost);
        let lost = (0..60).position(|_| {
            filter.predict(None);
            filter.estimate().unwrap().lost
        });
        assert!((5..50).contains(&lost.unwrap()), "{lost:?}");
        let nothing = PlanePose { covariance: [[f64::NAN; 3]; 3], ..fix_at(DVec3::ZERO) };
        let before = filter.estimate();
        filter.update(&nothing);
        assert_eq!(filter.estimate(), before);
    }
}
