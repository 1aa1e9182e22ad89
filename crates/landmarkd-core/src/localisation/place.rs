//! Where a frame was taken, by exemplars whose poses in a map are known.
//!
//! Without cameras the exemplars that agree are averaged. With cameras the frame's pose is that which the points in common
//! speak for: a point seen in one exemplar lies on an epipolar line; one seen in several lies in the map, and is where the
//! frame sees it (resection). Rotation and direction from each exemplar give hypotheses, lengths come from the distances
//! between exemplars; the likeliest hypothesis is refined on all points at once (Hartley and Zisserman 2004, 7.2, 11, 12).
//! Exemplars of somewhere else agree with nothing and so don't matter.

use super::least_squares::{Refined, Residual, refined};
use super::two_view::{Motion, RayPair, WITHIN, modes, relative_pose};
use crate::geometry::{Camera, DMat3, DQuat, DVec2, DVec3, MapPose, PointPair, RigidTransform};

/// An exemplar that agrees with a frame.
#[derive(Clone, Debug)]
pub struct PlaceView<'a> {
    /// Where its camera's body stood.
    pub pose: MapPose,
    /// Expected error of that position along each axis.
    pub sigma_m: f64,
    /// Its camera.
    pub camera: Option<Camera>,
    /// Log₁₀ of how rarely chance agrees as well, above 0.
    pub evidence: f64,
    /// Points of the exemplar's picture, and of the frame.
    pub correspondences: &'a [PointPair],
}

/// How a place was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaceMethod {
    /// The mean of the exemplars that agree, by their evidence: no cameras are known.
    Exemplars,
    /// Rotation from one exemplar and that exemplar's position: how far away it is, one alone doesn't tell.
    Bearing,
    /// From several exemplars at known distances.
    Triangulation,
}

/// Where a frame was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacePose {
    /// Metres along the map's x axis.
    pub x_m: f64,
    /// Metres along the map's y axis.
    pub y_m: f64,
    /// Heading of the camera, counter-clockwise from the map's x axis, in (−180, 180].
    pub yaw_deg: f64,
    /// Of x, y and yaw: m and rad.
    pub covariance: [[f64; 3]; 3],
    /// How it was found.
    pub method: PlaceMethod,
    /// Indices of the views that it rests on, ascending.
    pub support: Vec<usize>,
}

/// Views that are looked at, most evident first.
const MOST_VIEWS: usize = 8;
/// Views that give hypotheses, hypotheses of each, and lengths that are tried: from the least, each so many times the one before.
const PROPOSING: usize = 4;
const MOST_MODES: usize = 3;
const LENGTHS: usize = 24;
const LEAST_LENGTH_M: f64 = 0.05;
const LONGER: f64 = 1.28;
/// Hypotheses that are refined.
const REFINED: usize = 4;
/// Hypotheses that differ by less are one.
const SAME_M: f64 = 0.15;
const SAME_RAD: f64 = 0.05;
/// Pairs depend on each other: differences of log-likelihoods count by this part.
const INDEPENDENT: f64 = 0.4;
/// A pose is not determined where it is likelier than an accident by less than e to this power, …
const LEAST_GAIN: f64 = 25.0;
/// … or where it may be off by more than this.
const MOST_SIGMA_M: f64 = 2.0;
const MOST_SIGMA_RAD: f64 = 0.26;
/// What calibrations leave, and windows that see other surfaces from elsewhere.
const MODEL_SIGMA_M: f64 = 0.003;
const MODEL_SIGMA_RAD: f64 = 5e-4;
/// A view supports a pose with at least so many spots.
const LEAST_SPOTS: f64 = 5.0;
/// How likely an accident puts a point that several exemplars see where the frame sees it: to within some pixels, of all.
const ACCIDENT: f64 = 5e-4;
/// Where nothing tells a scene's depth: about so far, within twice and half of it.
const TYPICAL_DEPTH_M: f64 = 3.0;
/// Without cameras: exemplars are of one place if they stand this near to each other and look the same way; how far frames
/// stand from where the exemplar that they look like does, at least.
const SAME_PLACE_M: f64 = 3.0;
const SAME_VIEW_RAD: f64 = 1.0;
const PLACE_SIGMA_M: f64 = 0.7;
/// Another place that chance explains hardly oftener (log₁₀) may be the one as well.
const RIVAL_EVIDENCE: f64 = 1.0;
const VIEW_SIGMA_RAD: f64 = 0.35;

/// Where a frame was taken; `camera` is the frame's. None where the views don't tell.
pub fn locate(views: &[PlaceView<'_>], camera: Option<&Camera>) -> Option<PlacePose> {
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by(|&a, &b| views[b].evidence.total_cmp(&views[a].evidence)); // stable
    let calibrated = order.iter().copied().filter(|&i| views[i].camera.is_some());
    let seen: Vec<usize> = calibrated.take(MOST_VIEWS).collect();
    let by_points = camera.and_then(|camera| triangulated(views, &seen, camera));
    if by_points.is_some() || has_rival(views, &order) {
        return by_points.map(with_model_error);
    }
    let by_one = camera.and_then(|camera| seen.iter().find_map(|&i| bearing(views, i, camera)));
    by_one.or_else(|| mean(views, &order))
}

/// Whether another place agrees about as well as the likeliest: one of them alone would tell too much.
fn has_rival(views: &[PlaceView<'_>], order: &[usize]) -> bool {
    let Some(best) = order.first().map(|&index| &views[index]) else { return false };
    order.iter().map(|&index| &views[index]).any(|view| {
        let apart_m = (view.pose.x_m - best.pose.x_m).hypot(view.pose.y_m - best.pose.y_m);
        apart_m > SAME_PLACE_M && view.evidence > best.evidence - RIVAL_EVIDENCE
    })
}

/// A view's rays, and where they start from.
struct SeenView {
    /// Among the views that were given.
    index: usize,
    map_optical: RigidTransform,
    /// Without those of points that several views see.
    pairs: Vec<RayPair>,
    /// All.
    rays: Vec<RayPair>,
}

/// A point that several views see.
struct MapPoint {
    at: DVec3,
    covariance: DMat3,
    /// Of the frame.
    ray: DVec2,
    sigma: f64,
    weight: f64,
    gain: f64,
    /// Which of the seen views see it.
    views: Vec<usize>,
}

/// All that speaks for the pose of a frame.
struct Scene {
    views: Vec<SeenView>,
    points: Vec<MapPoint>,
}

impl Scene {
    /// Of the views of some indices, their cameras moved by `shift`.
    fn of(views: &[PlaceView<'_>], seen: &[usize], camera: &Camera, shift: impl Fn(usize) -> DVec3) -> Scene {
        let mut out = Vec::new();
        // (frame px, view, pair)
        let mut observations: Vec<([u64; 3], usize, RayPair)> = Vec::new();
        for &index in seen {
            let view = &views[index];
            let Some(own) = view.camera else { continue };
            let mut map_optical = view.pose.optical();
            map_optical.translation_m += shift(index);
            let pairs = RayPair::of(view.correspondences, &own, camera);
            for (pair, rays) in &pairs {
                let PointPair { to_px: [x, y], scale_px: [_, scale], .. } = view.correspondences[*pair];
                observations.push(([x, y, scale].map(f64::to_bits), out.len(), *rays));
            }
            out.push(SeenView {
                index,
                map_optical,
                pairs: Vec::new(),
                rays: pairs.into_iter().map(|(_, rays)| rays).collect(),
            });
        }
        observations.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut points = Vec::new();
        for of_point in observations.chunk_by(|a, b| a.0 == b.0) {
            let seen: Vec<(usize, RayPair)> = of_point.iter().map(|(_, view, rays)| (*view, *rays)).collect();
            match MapPoint::of(&out, &seen) {
                Some(point) => points.push(point),
                // they share the frame's error, half of theirs: two are worth 4/3, three 3/2
                None => {
                    let part = 2.0 / (seen.len() as f64 + 1.0);
                    for (view, mut rays) in seen {
                        rays.weight *= part;
                        out[view].pairs.push(rays);
                    }
                }
            }
        }
        Scene { views: out, points }
    }

    /// How much likelier all that is seen is by a pose `T_map_optical` than by accident.
    fn gain(&self, pose: &RigidTransform) -> f64 {
        let inverse = pose.inverse();
        let of_view = |view: &SeenView| Relative::of(&inverse, view).gain(&view.pairs);
        let of_point = |point: &MapPoint| {
            point.gain * agreement(point.off(&inverse).map_or(f64::MAX, |off| off.length()))
        };
        self.views.iter().map(of_view).sum::<f64>() + self.points.iter().map(of_point).sum::<f64>()
    }

    fn residuals(&self, pose: &RigidTransform) -> Vec<Residual> {
        let inverse = pose.inverse();
        let mut all = Vec::new();
        for view in &self.views {
            let relative = Relative::of(&inverse, view);
            all.extend(view.pairs.iter().map(|pair| match relative.error(pair) {
                Some(value) => Residual { value, weight: pair.weight },
                None => Residual::default(),
            }));
        }
        for point in &self.points {
            let off = point.off(&inverse);
            let weight = if off.is_some() { point.weight } else { 0.0 };
            let off = off.unwrap_or_default();
            all.extend([off.x, off.y].map(|value| Residual { value, weight }));
        }
        all
    }

    fn refined(&self, pose: &RigidTransform) -> Option<Refined<RigidTransform, 6>> {
        refined(pose, WITHIN, moved, |pose| self.residuals(pose))
    }

    /// How many spots of each view agree with a pose.
    fn spots(&self, pose: &RigidTransform) -> Vec<f64> {
        let inverse = pose.inverse();
        let agreeing = |view: &SeenView| {
            let relative = Relative::of(&inverse, view);
            let agrees = |pair: &&RayPair| relative.error(pair).is_some_and(|error| error.abs() < WITHIN);
            view.pairs.iter().filter(agrees).map(|pair| pair.weight).sum::<f64>()
        };
        let mut spots: Vec<f64> = self.views.iter().map(agreeing).collect();
        for point in &self.points {
            if point.off(&inverse).is_some_and(|off| off.length() < WITHIN) {
                point.views.iter().for_each(|&view| spots[view] += point.weight);
            }
        }
        spots
    }

    /// Poses that a view's rotation and direction allow, with some lengths.
    fn proposals(&self) -> Vec<(f64, RigidTransform)> {
        let mut proposals = Vec::new();
        for view in self.views.iter().take(PROPOSING) {
            for (_, mode) in modes(&view.rays, MOST_MODES) {
                let Motion { rotation, direction } = mode.parameters;
                let lengths = (0..LENGTHS).map(|step| LEAST_LENGTH_M * LONGER.powi(step as i32));
                let proposal = |length: f64| {
                    let pose =
                        view.map_optical.then(&RigidTransform::new(rotation, direction * length).inverse());
                    (self.gain(&pose), pose)
                };
                proposals.extend(lengths.map(proposal).max_by(|a, b| a.0.total_cmp(&b.0)));
            }
        }
        proposals.sort_by(|a: &(f64, RigidTransform), b| b.0.total_cmp(&a.0));
        proposals.truncate(REFINED);
        proposals
    }
}

/// A view's camera as a frame at a pose sees it.
struct Relative {
    rotation: DMat3,
    translation: DVec3,
    essential: DMat3,
}

impl Relative {
    fn of(optical_map: &RigidTransform, view: &SeenView) -> Relative {
        let frame_view = optical_map.then(&view.map_optical);
        let rotation = DMat3::from_quat(frame_view.rotation);
        let translation = frame_view.translation_m;
        Relative { rotation, translation, essential: super::essential::cross_matrix(translation) * rotation }
    }

    fn error(&self, pair: &RayPair) -> Option<f64> {
        pair.error(&self.essential, &self.rotation, self.translation)
    }

    fn gain(&self, pairs: &[RayPair]) -> f64 {
        pairs.iter().map(|pair| pair.gain * self.error(pair).map_or(0.0, agreement)).sum()
    }
}

/// What an error leaves of an agreement.
fn agreement(error: f64) -> f64 {
    (1.0 - (error / WITHIN).powi(2)).max(0.0)
}

impl MapPoint {
    /// The point that views see along rays, one each; none if they don't meet before the cameras, or are all but parallel.
    fn of(views: &[SeenView], seen: &[(usize, RayPair)]) -> Option<MapPoint> {
        if seen.len() < 2 {
            return None;
        }
        let rays: Vec<(DVec3, DVec3, f64)> = seen
            .iter()
            .map(|(view, rays)| {
                let RigidTransform { rotation, translation_m } = views[*view].map_optical;
                (translation_m, rotation * rays.from.extend(1.0).normalize(), rays.sigma[0])
            })
            .collect();
        // Least squares of the distances from the rays, each in its expected deviation at the point's distance.
        let mut distances = vec![TYPICAL_DEPTH_M; rays.len()];
        let mut found = None;
        for _ in 0..4 {
            let (mut information, mut right) = (DMat3::ZERO, DVec3::ZERO);
            for ((origin, ray, sigma), distance) in rays.iter().zip(&distances) {
                let across = DMat3::IDENTITY - DMat3::from_cols(*ray * ray.x, *ray * ray.y, *ray * ray.z);
                let weight = (sigma * distance).powi(-2);
                information += across * weight;
                right += across * *origin * weight;
            }
            let covariance = information.inverse();
            let at = covariance * right;
            if !at.is_finite() {
                return None;
            }
            for ((origin, ray, _), distance) in rays.iter().zip(&mut distances) {
                *distance = (at - *origin).dot(*ray);
            }
            if distances.iter().any(|distance| *distance <= 0.0) {
                return None;
            }
            found = Some((at, covariance));
        }
        let (at, covariance) = found?;
        let meets = rays.iter().zip(&distances).all(|((origin, ray, sigma), distance)| {
            let off = at - *origin;
            (off - *ray * off.dot(*ray)).length() < WITHIN * sigma * distance
        });
        // known to within half of its distance: else its errors aren't normal
        let nearest = distances.iter().copied().fold(f64::MAX, f64::min);
        let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
        let (_, of_frame) = seen.first()?;
        let weight = seen.iter().map(|(_, rays)| rays.weight).fold(0.0, f64::max);
        (meets && trace.sqrt() < 0.5 * nearest).then(|| MapPoint {
            at,
            covariance,
            ray: of_frame.to,
            sigma: of_frame.sigma[1],
            weight,
            gain: weight * (0.5 / ACCIDENT).ln_1p(),
            views: seen.iter().map(|(view, _)| *view).collect(),
        })
    }

    /// How far from where the frame sees it a pose would see it, in expected deviations; none behind the camera.
    fn off(&self, optical_map: &RigidTransform) -> Option<DVec2> {
        let p = optical_map.apply(self.at);
        if p.z <= 1e-3 {
            return None;
        }
        let (u, v) = (p.x / p.z, p.y / p.z);
        let rotation = DMat3::from_quat(optical_map.rotation);
        let covariance = rotation * self.covariance * rotation.transpose();
        let (du, dv) = (DVec3::new(1.0, 0.0, -u) / p.z, DVec3::new(0.0, 1.0, -v) / p.z);
        let square = self.sigma * self.sigma;
        let a = du.dot(covariance * du) + square;
        let b = du.dot(covariance * dv);
        let c = dv.dot(covariance * dv) + square;
        // whitened by Cholesky's factor
        let off = DVec2::new(u, v) - self.ray;
        let l = a.sqrt();
        let m = b / l;
        let n = (c - m * m).sqrt();
        let first = off.x / l;
        Some(DVec2::new(first, (off.y - m * first) / n))
    }
}

/// A pose turned about its own axes and moved along the map's.
fn moved(pose: &RigidTransform, by: &[f64; 6]) -> RigidTransform {
    let turn = DQuat::from_scaled_axis(DVec3::new(by[0], by[1], by[2]));
    RigidTransform {
        rotation: (pose.rotation * turn).normalize(),
        translation_m: pose.translation_m + DVec3::new(by[3], by[4], by[5]),
    }
}

/// x, y and yaw in radians.
fn planar(pose: &RigidTransform) -> [f64; 3] {
    let MapPose { x_m, y_m, yaw_deg, .. } = MapPose::of_optical(pose);
    [x_m, y_m, yaw_deg.to_radians()]
}

/// What one planar pose differs from another by; the turn in (−π, π].
fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let turn = a[2] - b[2];
    [a[0] - b[0], a[1] - b[1], turn.sin().atan2(turn.cos())]
}

fn add_outer(covariance: &mut [[f64; 3]; 3], off: [f64; 3], weight: f64) {
    for (row, a) in covariance.iter_mut().zip(off) {
        row.iter_mut().zip(off).for_each(|(sum, b)| *sum += weight * a * b);
    }
}

/// Adds to what points may be off by what no number of them makes less.
fn with_model_error(mut pose: PlacePose) -> PlacePose {
    for (axis, sigma) in [MODEL_SIGMA_M, MODEL_SIGMA_M, MODEL_SIGMA_RAD].into_iter().enumerate() {
        pose.covariance[axis][axis] += sigma * sigma;
    }
    pose
}

/// By all points of several views, as if only their positions were uncertain.
fn triangulated(views: &[PlaceView<'_>], seen: &[usize], camera: &Camera) -> Option<PlacePose> {
    if seen.len() < 2 {
        return None;
    }
    let scene = Scene::of(views, seen, camera, |_| DVec3::ZERO);
    let mut found: Vec<(f64, Refined<RigidTransform, 6>)> = Vec::new();
    for (_, pose) in scene.proposals() {
        let Some(refined) = scene.refined(&pose) else { continue };
        let gain = scene.gain(&refined.parameters);
        let is_like = |other: &Refined<RigidTransform, 6>| {
            let (a, b) = (&refined.parameters, &other.parameters);
            (a.translation_m - b.translation_m).length() < SAME_M && a.angle_to_rad(b) < SAME_RAD
        };
        match found.iter_mut().find(|(_, other)| is_like(other)) {
            Some(other) if other.0 < gain => *other = (gain, refined),
            Some(_) => {}
            None => found.push((gain, refined)),
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (gain, best) = found.first().filter(|(gain, _)| *gain > LEAST_GAIN)?;
    let pose = best.parameters;
    let supporting: Vec<usize> = scene
        .spots(&pose)
        .iter()
        .zip(&scene.views)
        .filter(|(spots, _)| **spots >= LEAST_SPOTS)
        .map(|(_, view)| view.index)
        .collect();
    if supporting.len() < 2 {
        return None;
    }
    let here = planar(&pose);
    // JCJᵀ
    let slope: [[f64; 3]; 6] = std::array::from_fn(|along| {
        let mut step = [0.0; 6];
        step[along] = 1e-6;
        difference(planar(&moved(&pose, &step)), here).map(|v| v / 1e-6)
    });
    let mut covariance: [[f64; 3]; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let term = |(a, b): (usize, usize)| slope[a][i] * best.covariance[a][b] * slope[b][j];
            (0..6).flat_map(|a| (0..6).map(move |b| (a, b))).map(term).sum()
        })
    });
    // what other hypotheses say, each as likely as it is
    let likelihood = |other: f64| (INDEPENDENT * (other - gain)).exp();
    let all: f64 = found.iter().map(|(other, _)| likelihood(*other)).sum();
    for (other, refined) in &found[1..] {
        add_outer(&mut covariance, difference(planar(&refined.parameters), here), likelihood(*other) / all);
    }
    // what the errors of the exemplars' positions do to it
    for &index in &supporting {
        let sigma_m = views[index].sigma_m;
        for axis in [DVec3::X, DVec3::Y].into_iter().filter(|_| sigma_m > 0.0) {
            let shifted =
                Scene::of(
                    views,
                    seen,
                    camera,
                    |view| if view == index { axis * sigma_m } else { DVec3::ZERO },
                );
            let Some(shifted) = shifted.refined(&pose) else { continue };
            add_outer(&mut covariance, difference(planar(&shifted.parameters), here), 1.0);
        }
    }
    let sigma_m = (covariance[0][0] + covariance[1][1]).sqrt();
    let is_determined = sigma_m < MOST_SIGMA_M && covariance[2][2].sqrt() < MOST_SIGMA_RAD;
    let mut support = supporting;
    support.sort_unstable();
    is_determined.then(|| PlacePose {
        x_m: here[0],
        y_m: here[1],
        yaw_deg: here[2].to_degrees(),
        covariance,
        method: PlaceMethod::Triangulation,
        support,
    })
}

/// By the points of one view: the scale is unknown.
fn bearing(views: &[PlaceView<'_>], index: usize, camera: &Camera) -> Option<PlacePose> {
    let view = &views[index];
    let found = relative_pose(view.correspondences, &view.camera?, camera)?;
    let map_optical = view.pose.optical();
    let turned = RigidTransform {
        rotation: (map_optical.rotation * found.rotation.conjugate()).normalize(),
        translation_m: map_optical.translation_m,
    };
    let here = planar(&turned);
    let sigma_m = view.sigma_m;
    let mut covariance = [[0.0; 3]; 3];
    // a third of the squared error is about the vertical
    covariance[2][2] = found.rotation_sigma_rad.powi(2) / 3.0;
    // the baseline, as a part of a depth that isn't known
    let length_m = TYPICAL_DEPTH_M / found.depth_in_baselines;
    match found.direction {
        Some(direction) => {
            let away = turned.rotation * -direction * (2.0 * length_m);
            add_outer(&mut covariance, [away.x, away.y, 0.0], 1.0);
            let across = found.direction_sigma_rad * length_m;
            (0..2).for_each(|axis| covariance[axis][axis] += sigma_m.powi(2) + across.powi(2));
        }
        None => (0..2).for_each(|axis| covariance[axis][axis] = sigma_m.powi(2) + PLACE_SIGMA_M.powi(2)),
    }
    Some(PlacePose {
        x_m: here[0],
        y_m: here[1],
        yaw_deg: here[2].to_degrees(),
        covariance,
        method: PlaceMethod::Bearing,
        support: vec![index],
    })
}

/// The mean of the exemplars of one place, by their evidence.
fn mean(views: &[PlaceView<'_>], order: &[usize]) -> Option<PlacePose> {
    let planar = |index: usize| {
        let MapPose { x_m, y_m, yaw_deg, .. } = views[index].pose;
        [x_m, y_m, yaw_deg.to_radians()]
    };
    let near = |about: usize| -> Vec<usize> {
        let is_near = |&index: &usize| {
            let [x, y, turn] = difference(planar(index), planar(about));
            x.hypot(y) < SAME_PLACE_M && turn.abs() < SAME_VIEW_RAD
        };
        order.iter().copied().filter(is_near).collect()
    };
    let evidence = |of: &[usize]| of.iter().map(|&index| views[index].evidence).sum::<f64>();
    let places = order.iter().map(|&index| near(index));
    let place = places.max_by(|a, b| evidence(a).total_cmp(&evidence(b)))?;
    let all = evidence(&place);
    let weight = |index: usize| views[index].evidence / all;
    let first = planar(place[0]);
    let sum =
        |axis: usize| place.iter().map(|&i| weight(i) * difference(planar(i), first)[axis]).sum::<f64>();
    let here = [first[0] + sum(0), first[1] + sum(1), first[2] + sum(2)];
    let mut covariance = [[0.0; 3]; 3];
    let mut known_m2 = 0.0;
    for &index in &place {
        add_outer(&mut covariance, difference(planar(index), here), weight(index));
        known_m2 += weight(index) * views[index].sigma_m.powi(2);
    }
    (0..2).for_each(|axis| covariance[axis][axis] += known_m2 + PLACE_SIGMA_M.powi(2));
    covariance[2][2] += VIEW_SIGMA_RAD.powi(2);
    let mut support = place;
    support.sort_unstable();
    Some(PlacePose {
        x_m: here[0],
        y_m: here[1],
        yaw_deg: here[2].sin().atan2(here[2].cos()).to_degrees(),
        covariance,
        method: PlaceMethod::Exemplars,
        support,
    })
}

#[cfg(test)]
mod tests {
    use super::super::two_view::tests::{CAMERA, normals, pairs, room};
    use super::*;
    use crate::random::Random;

    #[test]
    fn of_places_that_look_alike_none_is_told() {
        let view = |x_m: f64, evidence: f64| PlaceView {
            pose: MapPose { x_m, ..MapPose::default() },
            sigma_m: 0.05,
            camera: None,
            evidence,
            correspondences: &[],
        };
        assert_eq!(locate(&[view(0.0, 10.0), view(30.0, 9.9)], None), None);
        let sure = locate(&[view(0.0, 10.0), view(30.0, 4.0), view(1.0, 9.0)], None).unwrap();
        assert!(sure.x_m < 1.0 && sure.method == PlaceMethod::Exemplars, "{sure:?}");
    }

    /// Exemplars of a room, and a frame of it.
    struct Trial {
        truth: MapPose,
        exemplars: Vec<(MapPose, Vec<PointPair>)>,
    }

    /// Exemplars a metre apart whose true poses are off by `sigma_m`; of five pairs as many as `wrong` are wrong.
    fn trial(seed: u64, exemplars: usize, sigma_m: f64, wrong: usize) -> Trial {
        let mut random = Random::new(seed, 6);
        let points = room(220, &mut random);
        let truth = MapPose {
            x_m: random.between(-0.4, 0.4),
            y_m: random.between(-0.4, 0.4),
            z_m: 0.6,
            yaw_deg: random.between(-20.0, 20.0),
            pitch_deg: random.between(-2.0, 2.0),
            roll_deg: 0.0,
        };
        let noise = normals(points.len(), &mut random);
        let stand = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
        let exemplars = stand[..exemplars].iter().map(|[x_m, y_m]| {
            let known = MapPose { x_m: *x_m, y_m: *y_m, z_m: 0.6, ..MapPose::default() };
            let [dx, dy] = random.normals();
            let real = MapPose { x_m: x_m + sigma_m * dx, y_m: y_m + sigma_m * dy, ..known };
            (known, pairs(&points, [&real, &truth], (1.0, wrong), &noise, &mut random))
        });
        Trial { truth, exemplars: exemplars.collect() }
    }

    fn views(trial: &Trial, sigma_m: f64, camera: Option<Camera>) -> Vec<PlaceView<'_>> {
        trial
            .exemplars
            .iter()
            .map(|(pose, correspondences)| PlaceView {
                pose: *pose,
                sigma_m,
                camera,
                evidence: 10.0,
                correspondences,
            })
            .collect()
    }

    /// The error of a pose, and its normalised square.
    fn error(found: &PlacePose, truth: &MapPose) -> ([f64; 3], f64) {
        let off = difference(
            [found.x_m, found.y_m, found.yaw_deg.to_radians()],
            [truth.x_m, truth.y_m, truth.yaw_deg.to_radians()],
        );
        let inverse = DMat3::from_cols_array_2d(&found.covariance).inverse();
        let v = DVec3::from_array(off);
        (off, v.dot(inverse * v))
    }

    /// The mean of the normalised squared errors of some trials, and how many were answered.
    fn mean_error(trials: u64, exemplars: usize, sigma_m: f64, wrong: usize) -> (f64, u64) {
        let (mut sum, mut answered) = (0.0, 0);
        for seed in 0..trials {
            let trial = trial(seed, exemplars, sigma_m, wrong);
            let views = views(&trial, sigma_m, Some(CAMERA));
            let seen: Vec<usize> = (0..exemplars).collect();
            let Some(found) = triangulated(&views, &seen, &CAMERA) else { continue };
            let (off, normalised) = error(&found, &trial.truth);
            assert!(off[0].hypot(off[1]) < 0.15 + 5.0 * sigma_m, "{seed}: {off:?}");
            sum += normalised;
            answered += 1;
        }
        (sum / answered as f64, answered)
    }

    #[test]
    fn the_covariance_is_that_of_the_errors() {
        let (mean, answered) = mean_error(500, 3, 0.0, 0);
        println!("normalised squared error {mean:.2} of {answered}");
        assert!(answered >= 490, "{answered}");
        // the 95 % band of the mean of 500 χ² of three degrees of freedom: 3 ± 1.96·√(6/500)
        assert!((2.79..3.21).contains(&mean), "{mean}");
    }

    #[test]
    fn what_is_not_known_of_the_exemplars_poses_is_in_the_covariance() {
        let (mean, answered) = mean_error(60, 4, 0.05, 1);
        println!("normalised squared error {mean:.2} of {answered}");
        assert!(answered >= 55, "{answered}");
        // 3 ± 1.96·√(6/60)
        assert!((2.38..3.62).contains(&mean), "{mean}");
    }

    #[test]
    fn an_exemplar_of_another_place_that_looks_the_same_does_not_matter() {
        for seed in 0..6 {
            let mut trial = trial(seed, 3, 0.0, 1);
            let elsewhere = MapPose { x_m: 20.0, y_m: 7.0, z_m: 0.6, yaw_deg: 90.0, ..MapPose::default() };
            let same = trial.exemplars[0].1.clone();
            trial.exemplars.insert(0, (elsewhere, same));
            let mut views = views(&trial, 0.0, Some(CAMERA));
            views[0].evidence = 30.0;
            let found = locate(&views, Some(&CAMERA)).unwrap();
            assert_eq!(
                (found.method, &found.support[..]),
                (PlaceMethod::Triangulation, &[1, 2, 3][..]),
                "{seed}"
            );
            let ([x, y, turn], _) = error(&found, &trial.truth);
            assert!(x.hypot(y) < 0.1 && turn.abs() < 0.03, "{seed}: {x} {y} {turn}");
        }
    }

    #[test]
    fn one_exemplar_tells_the_heading_and_a_line() {
        let mut told = 0;
        for seed in 0..6 {
            let trial = trial(seed, 1, 0.0, 1);
            let found = locate(&views(&trial, 0.02, Some(CAMERA)), Some(&CAMERA)).unwrap();
            assert_eq!(found.support, [0]);
            // where the points don't determine the motion the exemplar's own pose is left
            if found.method == PlaceMethod::Exemplars {
                continue;
            }
            told += 1;
            let ([.., turn], normalised) = error(&found, &trial.truth);
            assert!(turn.abs() < 0.03, "{seed}: {turn}");
            assert!(normalised < 16.0, "{seed}: {normalised}");
            assert!(found.covariance[0][0] + found.covariance[1][1] > 0.1, "{seed}: {found:?}");
        }
        assert!(told >= 4, "{told}");
    }

    #[test]
    fn without_cameras_exemplars_of_one_place_are_averaged() {
        let trial = trial(1, 4, 0.0, 1);
        let mut views = views(&trial, 0.1, None);
        let elsewhere = MapPose { x_m: 20.0, ..MapPose::default() };
        views.push(PlaceView { pose: elsewhere, evidence: 15.0, ..views[0].clone() });
        for camera in [None, Some(&CAMERA)] {
            let found = locate(&views, camera).unwrap();
            assert_eq!((found.method, &found.support[..]), (PlaceMethod::Exemplars, &[0, 1, 2, 3][..]));
            assert!(found.x_m.abs() < 1e-9 && found.y_m.abs() < 1e-9 && found.yaw_deg.abs() < 1e-9);
            let (_, normalised) = error(&found, &trial.truth);
            assert!(normalised < 8.0, "{normalised}");
        }
        assert_eq!(locate(&[], None), None);
    }
}
