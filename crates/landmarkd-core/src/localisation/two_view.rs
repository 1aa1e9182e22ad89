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
/// Windows whose centres are nearer than this part of their radius, of 14 px at their level, see one spot.
const SPOT_PX: f64 = 7.0;
/// There is no baseline to be seen if a rotation alone explains this part of what agrees.
const TURN_ALONE: f64 = 0.8;

/// A pose is not determined where the best hypothesis is likelier than an accident by less than e to this power …
const LEAST_GAIN: f64 = 25.0;
/// … or where the rotation or the direction may be off by more than this.
const MOST_SIGMA_RAD: [f64; 2] = [0.16, 0.26];
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
    let modes = modes(&rays);
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
    let has_direction = direction_sigma_rad < MOST_SIGMA_RAD[1] && !is_turn_alone(&motion, &rays);
    let depths: Vec<f64> = agreeing.iter().map(|&i| rays[i].depth(&motion)).collect();
    if rotation_sigma_rad > MOST_SIGMA_RAD[0] {
        return None;
    }
    Some(TwoView {
        rotation: DQuat::from_mat3(&motion.rotation),
        direction: has_direction.then_some(motion.direction),
        rotation_sigma_rad,
        direction_sigma_rad,
        depth_in_baselines: quantile(&depths, 0.5)?,
        agreeing: agreeing.into_iter().map(|i| indices[i]).collect(),
        deviation: best.deviation,
        gain: *gain,
    })
}

/// The likeliest motions, refined, likeliest first, with the logarithm of how much likelier they are than an accident.
pub(super) fn modes(pairs: &[RayPair]) -> Vec<(f64, Refined<Motion, 5>)> {
    let mut modes: Vec<(f64, Refined<Motion, 5>)> = Vec::new();
    for motion in hypotheses(pairs) {
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
