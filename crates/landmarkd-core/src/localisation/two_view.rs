//! The relative pose of two calibrated views by the points that look alike in both: rotation, and direction of the translation
//! (Hartley and Zisserman 2004, 9 and 11; Nistér 2004).
//!
//! PROSAC (Chum and Matas 2005) over five pairs of rays gives hypotheses; the likeliest few, each refined, are compared. What a
//! second one explains nearly as well is not determined. Errors of positions are in proportion to the windows' scale, and
//! measured by what is left of them in the end.

use std::ops::Range;

use super::essential::{LEAST_PAIRS, cross_matrix, essential_matrices, motions};
use super::least_squares::{Refined, Residual, refined};
use crate::geometry::{Camera, DMat3, DQuat, DVec2, DVec3, PointPair};
use crate::random::Random;
use crate::statistics::quantile;

/// Rounds of the search at most, and at least.
const MOST_ROUNDS: usize = 4000;
const LEAST_ROUNDS: usize = 100;
/// Among so many of the likeliest pairs the first rounds choose.
const PROSAC_FIRST: usize = 12;
/// Chance that the search ends before five right pairs were chosen.
const MISSED: f64 = 0.005;
/// A pair agrees to within so many expected deviations, which are one pixel of its window's level.
pub(super) const WITHIN: f64 = 2.5;
/// … and if the surroundings turn as the epipolar lines do, to within so much.
const TURNED_RAD: f64 = 0.7;
/// A pair of weight w is right with the chance MOST w/(w + HALF); a wrong one agrees with the chance of an accident.
const MOST_RIGHT: f64 = 0.6;
const HALF_RIGHT: f64 = 2.0;
const ACCIDENT: f64 = 0.015;
/// The two rays of a point meet before the cameras, unless they are parallel to within so many expected deviations.
const FAR: f64 = 4.0;
/// Hypotheses that are refined.
const REFINED: usize = 12;
/// Hypotheses that differ by less are one: rotation, direction.
const SAME_RAD: [f64; 2] = [0.06, 0.12];
/// Windows whose centres are nearer than their radius, of 14 px at their level, see one spot.
const SPOT_PX: f64 = 14.0;
/// There is no baseline to be seen if a rotation alone explains this part of what agrees.
const TURN_ALONE: f64 = 0.8;

/// A pose is not determined where the best hypothesis is likelier than an accident by less than e to this power …
const LEAST_GAIN: f64 = 25.0;
/// … or where the rotation or the direction may be off by more than this.
const MOST_SIGMA_RAD: [f64; 2] = [0.16, 0.26];
/// Where a baseline is seen and its direction isn't determined, the rotation is if it is off by no more than this.
const ALONE_SIGMA_RAD: f64 = 0.1;
/// Pairs depend on each other: differences of log-likelihoods count by this part.
const INDEPENDENT: f64 = 0.4;

/// The relative pose of two views.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoView {
    /// `R_to_from`: takes directions of the first view's optical frame to the second one's.
    pub rotation: DQuat,
    /// Where the first camera lies in the second one's optical frame: direction, of unit length. None where no baseline is
    /// seen, or its direction isn't determined.
    pub direction: Option<DVec3>,
    /// Expected error of the rotation, about all axes together, with what other hypotheses say.
    pub rotation_sigma_rad: f64,
    /// Expected error of the direction, likewise.
    pub direction_sigma_rad: f64,
    /// Median distance of what agrees from the second camera, in baselines.
    pub depth_in_baselines: f64,
    /// Indices of the pairs that agree.
    pub agreeing: Vec<usize>,
    /// How large the errors of positions are, in pixels of the windows' levels.
    pub deviation: f64,
    /// Natural logarithm of how much likelier the pairs are by this pose than by accident.
    pub gain: f64,
}

/// A pair as rays of both cameras.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayPair {
    pub from: DVec2,
    pub to: DVec2,
    /// Expected deviations of both, in units of rays.
    pub sigma: [f64; 2],
    /// The turn of the surroundings, as its cosine and sine.
    turn: DVec2,
    /// Its part of what is seen at its spot.
    pub weight: f64,
    /// What its agreement adds to the logarithm of a motion's likelihood.
    pub gain: f64,
}

/// A rotation and a direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub rotation: DMat3,
    pub direction: DVec3,
}

impl RayPair {
    /// The pairs that both cameras have rays for, with their indices. What several windows see of one spot counts once.
    pub fn of(pairs: &[PointPair], from: &Camera, to: &Camera) -> Vec<(usize, RayPair)> {
        let near = |a: [f64; 2], b: [f64; 2], within: f64| (a[0] - b[0]).hypot(a[1] - b[1]) < within;
        let spot = |pair: &PointPair| {
            let of_one = |other: &&PointPair| {
                let [p, q] = [0, 1].map(|side| SPOT_PX * pair.scale_px[side].max(other.scale_px[side]));
                near(pair.from_px, other.from_px, p) && near(pair.to_px, other.to_px, q)
            };
            pairs.iter().filter(of_one).count() as f64
        };
        let ray_pair = |pair: &PointPair| {
            let (sin, cos) = pair.turn_rad.sin_cos();
            let weight = spot(pair).recip();
            let right = MOST_RIGHT * pair.weight / (pair.weight + HALF_RIGHT);
            Some(RayPair {
                from: from.ray(pair.from_px)?,
                to: to.ray(pair.to_px)?,
                sigma: [pair.scale_px[0] / from.fx, pair.scale_px[1] / to.fx],
                turn: DVec2::new(cos, sin),
                weight,
                gain: weight * (right / ACCIDENT).ln_1p(),
            })
        };
        pairs.iter().enumerate().filter_map(|(index, pair)| Some((index, ray_pair(pair)?))).collect()
    }

    /// Sampson's error in expected deviations (Hartley and Zisserman 2004, (11.9)), if the surroundings turn as the epipolar
    /// lines do and the point is before both cameras. `essential` = [t]ₓ R.
    pub fn error(&self, essential: &DMat3, rotation: &DMat3, translation: DVec3) -> Option<f64> {
        let (q, p) = (self.from.extend(1.0), self.to.extend(1.0));
        let line_to = *essential * q;
        let line_from = essential.transpose() * p;
        let (normal_to, normal_from) = (line_to.truncate(), line_from.truncate());
        // Of an affine map A of the surroundings, Aᵀ n′ = −n (Barath and Hajder 2018): here of a rotation.
        let turned = self.turn.rotate(normal_from);
        let cosine = -turned.dot(normal_to);
        if cosine < TURNED_RAD.cos() * turned.length() * normal_to.length() {
            return None;
        }
        let variance = self.sigma[0].powi(2) * normal_from.length_squared()
            + self.sigma[1].powi(2) * normal_to.length_squared();
        let error = p.dot(line_to) / variance.sqrt();
        // d′ q′ = d R q + t
        let seen = *rotation * q;
        let across = p.cross(seen);
        let in_front = p.cross(translation).dot(across) < 0.0 && seen.cross(translation).dot(across) < 0.0;
        let is_far = across.length() < FAR * (self.sigma[0] + self.sigma[1]);
        (error.is_finite() && (in_front || is_far)).then_some(error)
    }

    /// The distance from the second camera along its axis, in baselines.
    fn depth(&self, motion: &Motion) -> f64 {
        let (seen, p) = (motion.rotation * self.from.extend(1.0), self.to.extend(1.0));
        let across = p.cross(seen);
        (seen.cross(motion.direction).dot(across) / across.length_squared()).abs()
    }
}

impl Motion {
    fn essential(&self) -> DMat3 {
        cross_matrix(self.direction) * self.rotation
    }

    /// Turned about three axes, and the direction moved along the two that are across it.
    fn moved(&self, by: &[f64; 5]) -> Motion {
        let turn = DQuat::from_scaled_axis(DVec3::new(by[0], by[1], by[2]));
        let (a, b) = self.direction.any_orthonormal_pair();
        Motion {
            rotation: DMat3::from_quat(turn) * self.rotation,
            direction: (self.direction + a * by[3] + b * by[4]).normalize(),
        }
    }

    /// How much likelier the pairs are by this motion than by accident: what agrees, the better the more (Torr and Zisserman
    /// 2000).
    pub fn gain(&self, pairs: &[RayPair]) -> f64 {
        let essential = self.essential();
        let gain = |pair: &RayPair| match pair.error(&essential, &self.rotation, self.direction) {
            Some(error) if error.abs() < WITHIN => pair.gain * (1.0 - (error / WITHIN).powi(2)),
            _ => 0.0,
        };
        pairs.iter().map(gain).sum()
    }

    fn agrees(&self, pair: &RayPair) -> bool {
        pair.error(&self.essential(), &self.rotation, self.direction)
            .is_some_and(|error| error.abs() < WITHIN)
    }

    fn turn_to_rad(&self, other: &Motion) -> f64 {
        DQuat::from_mat3(&self.rotation).angle_between(DQuat::from_mat3(&other.rotation))
    }

    fn turn_of_direction_rad(&self, other: &Motion) -> f64 {
        self.direction.angle_between(other.direction)
    }

    fn is_like(&self, other: &Motion) -> bool {
        self.turn_to_rad(other) < SAME_RAD[0] && self.turn_of_direction_rad(other) < SAME_RAD[1]
    }

    fn refined(&self, pairs: &[RayPair]) -> Option<Refined<Motion, 5>> {
        refined(self, WITHIN, Motion::moved, |motion| {
            let essential = motion.essential();
            let residual = |pair: &RayPair| match pair.error(&essential, &motion.rotation, motion.direction) {
                Some(value) => Residual { value, weight: pair.weight },
                None => Residual::default(),
            };
            pairs.iter().map(residual).collect()
        })
    }
}

/// The pose of `from`'s camera relative to `to`'s by pairs of points, likeliest first; none where they don't determine it.
pub fn relative_pose(pairs: &[PointPair], from: &Camera, to: &Camera) -> Option<TwoView> {
    let (indices, rays): (Vec<usize>, Vec<RayPair>) = RayPair::of(pairs, from, to).into_iter().unzip();
    let modes = modes(&rays, REFINED);
    let (gain, best) = modes.first().filter(|(gain, _)| *gain > LEAST_GAIN)?;
    let motion = best.parameters;
    let agreeing: Vec<usize> = (0..rays.len()).filter(|&i| motion.agrees(&rays[i])).collect();
    // the spread of the hypotheses, each as likely as it is
    let likelihoods: Vec<f64> = modes.iter().map(|(other, _)| (INDEPENDENT * (other - gain)).exp()).collect();
    let all: f64 = likelihoods.iter().sum();
    let spread = |between: fn(&Motion, &Motion) -> f64| {
        let square = |(likelihood, (_, other)): (&f64, &(f64, Refined<Motion, 5>))| {
            likelihood / all * between(&motion, &other.parameters).powi(2)
        };
        likelihoods.iter().zip(&modes).map(square).sum::<f64>()
    };
    let variance = |range: Range<usize>| range.map(|i| best.covariance[i][i]).sum::<f64>();
    let rotation_sigma_rad = (variance(0..3) + spread(Motion::turn_to_rad)).sqrt();
    let direction_sigma_rad = (variance(3..5) + spread(Motion::turn_of_direction_rad)).sqrt();
    let is_turn_alone = is_turn_alone(&motion, &rays);
    let direction_is_known = direction_sigma_rad < MOST_SIGMA_RAD[1];
    let most_rad = if direction_is_known || is_turn_alone { MOST_SIGMA_RAD[0] } else { ALONE_SIGMA_RAD };
    if rotation_sigma_rad > most_rad {
        return None;
    }
    let depths: Vec<f64> = agreeing.iter().map(|&i| rays[i].depth(&motion)).collect();
    Some(TwoView {
        rotation: DQuat::from_mat3(&motion.rotation),
        direction: (direction_is_known && !is_turn_alone).then_some(motion.direction),
        rotation_sigma_rad,
        direction_sigma_rad,
        depth_in_baselines: quantile(&depths, 0.5)?,
        agreeing: agreeing.into_iter().map(|i| indices[i]).collect(),
        deviation: best.deviation,
        gain: *gain,
    })
}

/// The likeliest motions, at most so many, refined, likeliest first, with the logarithm of how much likelier they are than an accident.
pub(super) fn modes(pairs: &[RayPair], most: usize) -> Vec<(f64, Refined<Motion, 5>)> {
    let mut modes: Vec<(f64, Refined<Motion, 5>)> = Vec::new();
    for motion in hypotheses(pairs).into_iter().take(most) {
        let Some(refined) = motion.refined(pairs) else { continue };
        let gain = refined.parameters.gain(pairs);
        match modes.iter_mut().find(|(_, other)| other.parameters.is_like(&refined.parameters)) {
            Some(other) if other.0 < gain => *other = (gain, refined),
            Some(_) => {}
            None => modes.push((gain, refined)),
        }
    }
    modes.sort_by(|a, b| b.0.total_cmp(&a.0));
    modes
}

/// The likeliest motions by five pairs.
fn hypotheses(pairs: &[RayPair]) -> Vec<Motion> {
    if pairs.len() < LEAST_PAIRS {
        return Vec::new();
    }
    let mut random = Random::new(pairs.len() as u64, 11);
    let mut kept: Vec<(f64, Motion)> = Vec::new();
    let all: f64 = pairs.iter().map(|pair| pair.gain).sum();
    let (mut left, mut round) = (MOST_ROUNDS, 0);
    while round < left {
        round += 1;
        let among = (PROSAC_FIRST + pairs.len() * 2 * round / MOST_ROUNDS).min(pairs.len());
        let five = chosen(&mut random, among).map(|i| pairs[i]);
        let essential = essential_matrices(&five.map(|pair| (pair.from, pair.to)));
        for (rotation, direction) in essential.iter().filter_map(motions).flatten() {
            let motion = Motion { rotation, direction };
            if !five.iter().all(|pair| motion.agrees(pair)) {
                continue;
            }
            let gain = motion.gain(pairs);
            match kept.iter().position(|(_, other)| other.is_like(&motion)) {
                Some(at) if kept[at].0 >= gain => continue,
                Some(at) => kept[at] = (gain, motion),
                None => kept.push((gain, motion)),
            }
            kept.sort_by(|a, b| b.0.total_cmp(&a.0));
            kept.truncate(REFINED);
            let share = kept[0].0 / all;
            let needed = MISSED.ln() / (1.0 - share.powi(LEAST_PAIRS as i32)).max(1e-12).ln();
            left = left.min((needed.ceil() as usize).max(LEAST_ROUNDS));
        }
    }
    kept.into_iter().map(|(_, motion)| motion).collect()
}

/// Five different indices below `among`.
fn chosen(random: &mut Random, among: usize) -> [usize; LEAST_PAIRS] {
    let mut chosen = [usize::MAX; LEAST_PAIRS];
    for i in 0..LEAST_PAIRS {
        while chosen[i] == usize::MAX {
            let candidate = ((random.uniform() * among as f64) as usize).min(among - 1);
            if !chosen[..i].contains(&candidate) {
                chosen[i] = candidate;
            }
        }
    }
    chosen
}

/// Whether a rotation explains what agrees with a motion.
fn is_turn_alone(motion: &Motion, pairs: &[RayPair]) -> bool {
    let agreeing: Vec<RayPair> = pairs.iter().copied().filter(|pair| motion.agrees(pair)).collect();
    let transfer = |rotation: &DMat3, pair: &RayPair| {
        let seen = *rotation * pair.from.extend(1.0);
        let sigma = pair.sigma[0].hypot(pair.sigma[1]);
        (seen.truncate() / seen.z - pair.to) / sigma
    };
    let turned = |rotation: &DMat3, by: &[f64; 3]| {
        DMat3::from_quat(DQuat::from_scaled_axis(DVec3::from_array(*by))) * *rotation
    };
    let turn = refined(&motion.rotation, WITHIN, turned, |rotation| {
        let both = agreeing.iter().flat_map(|pair| {
            let off = transfer(rotation, pair);
            [off.x, off.y].map(|value| Residual { value, weight: pair.weight })
        });
        both.collect()
    });
    let Some(turn) = turn else { return false };
    let sum = |pairs: &mut dyn Iterator<Item = &RayPair>| pairs.map(|pair| pair.weight).sum::<f64>();
    let explained = |pair: &&RayPair| transfer(&turn.parameters, pair).length() < WITHIN;
    sum(&mut agreeing.iter().filter(explained)) > TURN_ALONE * sum(&mut agreeing.iter())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::{MapPose, RigidTransform};

    /// A camera of 640 × 480 px.
    pub const CAMERA: Camera = Camera {
        fx: 420.0,
        fy: 421.0,
        cx: 318.0,
        cy: 242.0,
        distortion: [-0.12, 0.03, 2e-4, -3e-4, 0.0],
        width_px: 640,
        height_px: 480,
    };

    /// Points on the walls, the floor and the furniture of a room of 6 × 5 m.
    pub fn room(count: usize, random: &mut Random) -> Vec<DVec3> {
        let mut point = |number: usize| {
            let (x, y, z) = (random.between(-3.0, 3.0), random.between(-2.5, 2.5), random.between(0.0, 2.4));
            match number % 6 {
                0 => DVec3::new(3.0, y, z),
                1 => DVec3::new(-3.0, y, z),
                2 => DVec3::new(x, 2.5, z),
                3 => DVec3::new(x, -2.5, z),
                4 => DVec3::new(x, y, 0.0),
                _ => DVec3::new(x, 2.0 * y.signum() + 0.1 * y, 0.4 * z),
            }
        };
        (0..count).map(&mut point).collect()
    }

    /// Where a camera at a pose sees a point: a pixel, and the direction of what is above it.
    fn seen(pose: &RigidTransform, point: DVec3) -> Option<([f64; 2], f64)> {
        let optical_map = pose.inverse();
        let at = CAMERA.project(optical_map.apply(point))?;
        let above = CAMERA.project(optical_map.apply(point + DVec3::new(0.0, 0.0, 0.01)))?;
        let inside = at[0] > 0.0 && at[1] > 0.0 && at[0] < 639.0 && at[1] < 479.0;
        inside.then(|| (at, (above[1] - at[1]).atan2(above[0] - at[0])))
    }

    /// The pairs of points that an exemplar and a frame see, of the first `most` points, each to within `noise_px`; of five
    /// pairs as many as `wrong` have nothing to do with each other. Positions in the frame are those of `frame_noise`.
    pub fn pairs(
        points: &[DVec3],
        [taught, asked]: [&MapPose; 2],
        (noise_px, wrong): (f64, usize),
        frame_noise: &[[f64; 2]],
        random: &mut Random,
    ) -> Vec<PointPair> {
        let poses = [taught, asked].map(MapPose::optical);
        let mut pairs = Vec::new();
        for (number, (point, off)) in points.iter().zip(frame_noise).enumerate() {
            let (Some(from), Some(to)) = (seen(&poses[0], *point), seen(&poses[1], *point)) else { continue };
            let own = random.normals();
            let is_wrong = number % 5 < wrong;
            let mut pair = PointPair {
                from_px: [from.0[0] + noise_px * own[0], from.0[1] + noise_px * own[1]],
                to_px: [to.0[0] + noise_px * off[0], to.0[1] + noise_px * off[1]],
                scale_px: [1.0, 1.0],
                turn_rad: to.1 - from.1 + 0.1 * random.normals()[0],
                weight: random.between(0.3, 4.0),
            };
            if is_wrong {
                pair.from_px = [random.between(0.0, 639.0), random.between(0.0, 479.0)];
                pair.turn_rad = random.between(-3.1, 3.1);
                pair.weight *= 0.3;
            }
            pairs.push(pair);
        }
        pairs.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        pairs
    }

    pub fn normals(count: usize, random: &mut Random) -> Vec<[f64; 2]> {
        (0..count).map(|_| random.normals()).collect()
    }

    fn two_views(seed: u64, asked: &MapPose, points: &[DVec3], wrong: usize) -> Option<TwoView> {
        let mut random = Random::new(seed, 4);
        let noise = normals(points.len(), &mut random);
        let taught = MapPose { z_m: 0.6, ..MapPose::default() };
        relative_pose(&pairs(points, [&taught, asked], (0.7, wrong), &noise, &mut random), &CAMERA, &CAMERA)
    }

    fn truth(asked: &MapPose) -> RigidTransform {
        let taught = MapPose { z_m: 0.6, ..MapPose::default() };
        asked.optical().inverse().then(&taught.optical())
    }

    #[test]
    fn rotation_and_direction_are_found_among_two_fifths_of_wrong_pairs() {
        for seed in 0..6 {
            let mut random = Random::new(seed, 5);
            let points = room(500, &mut random);
            let asked =
                MapPose { x_m: -0.5, y_m: 0.8, z_m: 0.7, yaw_deg: -18.0, pitch_deg: 3.0, roll_deg: 2.0 };
            let found = two_views(seed, &asked, &points, 2).unwrap();
            let truth = truth(&asked);
            let turned = found.rotation.angle_between(truth.rotation);
            let aside = found.direction.unwrap().angle_between(truth.translation_m);
            assert!(turned < 0.02 && turned < 4.0 * found.rotation_sigma_rad, "{seed}: {turned} {found:?}");
            assert!(aside < 0.05 && aside < 4.0 * found.direction_sigma_rad, "{seed}: {aside} {found:?}");
            assert!((0.5..1.1).contains(&found.deviation), "{}", found.deviation);
        }
    }

    #[test]
    fn a_turn_on_the_spot_has_no_direction() {
        for seed in 0..4 {
            let points = room(500, &mut Random::new(seed, 5));
            let asked = MapPose { z_m: 0.6, yaw_deg: 15.0, ..MapPose::default() };
            let found = two_views(seed, &asked, &points, 1).unwrap();
            assert_eq!(found.direction, None);
            assert!(found.rotation.angle_between(truth(&asked).rotation) < 0.02);
        }
    }

    #[test]
    fn pairs_of_nothing_in_common_determine_nothing() {
        for seed in 0..4 {
            let points = room(500, &mut Random::new(seed, 5));
            let asked = MapPose { x_m: 0.5, y_m: 0.5, z_m: 0.6, yaw_deg: 10.0, ..MapPose::default() };
            assert_eq!(two_views(seed, &asked, &points, 5), None, "{seed}");
            assert_eq!(two_views(seed, &asked, &points[..12], 0), None, "few");
        }
    }
}
