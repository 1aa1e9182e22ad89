//! The pose of a flat landmark before a camera, in six degrees of freedom: two solutions from a homography (Collins and
//! Bartoli 2014, Infinitesimal plane-based pose estimation, IJCV 109), each refined on what the frame shows.
//!
//! The landmark's frame: x is its normal towards who looks at it, y to the right as they see it, z up; its origin is the middle
//! of the picture. Points of its plane are metres to the right and upwards. Poses are `T_camera_landmark`, from there to the
//! optical frame of the camera.

use super::pose_filter::PlanePose;
use crate::eigen::Symmetric;
use crate::geometry::{Camera, DMat3, DQuat, DVec2, DVec3, MapPose, RigidTransform};
use crate::recognition::landmarks::Homography;
use crate::statistics::median;

/// Unknowns of a pose: translation and rotation.
pub(super) const FREEDOM: usize = 6;
/// An eigenvalue of the normal equations below this part of the largest determines nothing.
const UNDETERMINED: f64 = 1e-13;
/// Rounds of refinement on points.
const ROUNDS: usize = 20;
/// Residuals beyond so many standard deviations count nothing (Tukey's biweight, 95 % efficient).
const TUKEY: f64 = 4.685;
/// Standard deviations per median of absolute normal deviates.
const MAD_TO_SIGMA: f64 = 1.4826;
/// Residuals are never taken to scatter less than this, in px: pixels have a size.
const LEAST_SIGMA_PX: f64 = 0.05;
/// Solutions nearer than this are one.
const SAME_RAD: f64 = 0.05;
/// Twice the log of the odds from which on the better of two solutions is believed. Odds of 20 to 1 would be 6; which edges are
/// found for either is chance too, and makes as much of a difference.
const SURE: f64 = 20.0;

/// Step of a numerical derivative, m or rad.
const STEP: f64 = 1e-6;

/// Where a frame shows a point of the landmark's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// To the right and upwards of the landmark's middle, metres.
    pub plane_m: [f64; 2],
    /// In the frame.
    pub frame_px: [f64; 2],
}

/// A pose of a flat landmark, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPose {
    /// `T_camera_landmark`.
    pub camera_landmark: RigidTransform,
    /// Of the translation (m) and of a rotation vector (rad) that is applied after the pose's own rotation; both in the optical
    /// frame.
    pub covariance: [[f64; FREEDOM]; FREEDOM],
    /// Standard deviation of the residuals, by those that agree, px.
    pub error_px: f64,
}

/// What a frame says of a flat landmark's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarPoses {
    /// The pose that explains the frame best.
    pub pose: PlanarPose,
    /// The other minimum of the reprojection error; none if there is but one.
    pub alternative: Option<PlanarPose>,
    /// Whether the alternative explains the frame nearly as well: what is small, far away or seen from the front hardly
    /// tells which of its sides is nearer.
    pub ambiguous: bool,
}

impl PlanarPose {
    /// The camera's body in a map, if that is the landmark's pose there.
    pub fn camera_in_map(&self, landmark: &MapPose) -> MapPose {
        in_map(&self.camera_landmark, landmark)
    }

    /// The same on the map's plane with its covariance, if the landmark's position is known to within `sigma_m` along each
    /// axis.
    pub fn camera_on_plane(&self, landmark: &MapPose, sigma_m: f64) -> PlanePose {
        let MapPose { x_m, y_m, yaw_deg, .. } = self.camera_in_map(landmark);
        let slopes: [[f64; 3]; FREEDOM] = std::array::from_fn(|axis| {
            let mut step = [0.0; FREEDOM];
            step[axis] = STEP;
            let moved = in_map(&moved(&self.camera_landmark, &step), landmark);
            let turn_deg = (moved.yaw_deg - yaw_deg + 180.0).rem_euclid(360.0) - 180.0;
            [moved.x_m - x_m, moved.y_m - y_m, turn_deg.to_radians()].map(|off| off / STEP)
        });
        let mut covariance = [[sigma_m * sigma_m, 0.0, 0.0], [0.0, sigma_m * sigma_m, 0.0], [0.0; 3]];
        for (row, a) in self.covariance.iter().zip(&slopes) {
            for (between, b) in row.iter().zip(&slopes) {
                for (i, line) in covariance.iter_mut().enumerate() {
                    line.iter_mut().zip(b).for_each(|(sum, b)| *sum += a[i] * between * b);
                }
            }
        }
        PlanePose { x_m, y_m, yaw_deg, covariance }
    }
}

fn in_map(camera_landmark: &RigidTransform, landmark: &MapPose) -> MapPose {
    MapPose::of_optical(&landmark.transform().then(&camera_landmark.inverse()))
}

/// The pose moved by a translation and then a rotation vector, both in the optical frame.
fn moved(pose: &RigidTransform, step: &[f64]) -> RigidTransform {
    let turn = DQuat::from_scaled_axis(DVec3::from_slice(&step[3..]));
    RigidTransform {
        rotation: (turn * pose.rotation).normalize(),
        translation_m: pose.translation_m + DVec3::from_slice(&step[..3]),
    }
}

/// The point of a flat landmark's plane that a pixel of its picture shows, in metres to the right and upwards of its middle.
/// `width_mm`: of the whole picture.
pub fn on_plane([x, y]: [f64; 2], width_px: u32, height_px: u32, width_mm: f64) -> [f64; 2] {
    let metres = width_mm / 1000.0 / f64::from(width_px);
    [(x - (f64::from(width_px) - 1.0) / 2.0) * metres, ((f64::from(height_px) - 1.0) / 2.0 - y) * metres]
}

/// The pose from points of the plane and where the frame shows them; `None` if they determine none. Points that disagree
/// with the others count nothing. The covariance takes the errors of the points for independent.
pub fn solve(sightings: &[Sighting], camera: &Camera) -> Option<PlanarPoses> {
    let rows = |pose: &RigidTransform| -> Vec<Row> {
        let seen = sightings.iter().filter_map(|sighting| {
            let Projection { pixel, by_pose, .. } = Projection::of(sighting.plane_m, pose, camera)?;
            Some(
                [0, 1]
                    .map(|axis| Row { off_px: sighting.frame_px[axis] - pixel[axis], slope: by_pose[axis] }),
            )
        });
        seen.flatten().collect()
    };
    let both = starts(sightings, camera)?.map(|start| refined(start, ROUNDS, |pose, _, _| rows(pose)));
    chosen(both.into_iter().flatten().collect(), 1.0)
}

/// The better of refined poses, and whether the other is nearly as good. `dependence`: by how much the variance of what the
/// residuals say together exceeds that of independent ones.
pub(super) fn chosen(mut refined: Vec<Refined>, dependence: f64) -> Option<PlanarPoses> {
    let sigma_px = refined.iter().map(|refined| refined.sigma_px).reduce(f64::min)?;
    let asked = refined.iter().map(|refined| refined.offs_px.len()).max()?;
    // −2 log of the likelihood; what one of them doesn't find costs as much as what it finds
    let cost = |refined: &Refined| {
        let found = refined.offs_px.iter().map(|off_px| Biweight::of(off_px / sigma_px).cost);
        found.sum::<f64>() / refined.offs_px.len() as f64 * asked as f64 / dependence
    };
    refined.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let best = refined.first()?;
    let other = refined.iter().find(|other| best.pose.angle_to_rad(&other.pose) > SAME_RAD);
    Some(PlanarPoses {
        pose: best.planar_pose(dependence),
        alternative: other.map(|other| other.planar_pose(dependence)),
        ambiguous: other.is_some_and(|other| cost(other) - cost(best) < SURE),
    })
}

/// Tukey's biweight for a residual in standard deviations.
struct Biweight {
    weight: f64,
    /// By how much weight times residual grows with the residual.
    growth: f64,
    /// What it adds to −2 log of the likelihood.
    cost: f64,
}

impl Biweight {
    fn of(off: f64) -> Biweight {
        let part = (off / TUKEY).powi(2).min(1.0);
        let rest = 1.0 - part;
        Biweight {
            weight: rest * rest,
            growth: rest * (1.0 - 5.0 * part),
            cost: TUKEY * TUKEY / 3.0 * (1.0 - rest.powi(3)),
        }
    }
}

/// Both poses that a homography from the plane to the frame leaves open.
pub(super) fn starts(sightings: &[Sighting], camera: &Camera) -> Option<[RigidTransform; 2]> {
    let pairs: Vec<([f64; 2], [f64; 2])> = sightings
        .iter()
        .filter_map(|sighting| Some((sighting.plane_m, camera.ray(sighting.frame_px)?.to_array())))
        .collect();
    let count = pairs.len().max(1) as f64;
    let middle = pairs.iter().fold([0.0; 2], |sum, (at, _)| [sum[0] + at[0] / count, sum[1] + at[1] / count]);
    let about = pairs.iter().map(|([x, y], ray)| ([x - middle[0], y - middle[1]], *ray));
    let map = Homography::fitted(&about.collect::<Vec<_>>())?;
    ippe(&map, middle)
}

/// Collins and Bartoli 2014, algorithm 1: both poses of a plane by the derivative of its homography at its point `middle`,
/// which the homography has at the origin.
fn ippe(map: &Homography, middle: [f64; 2]) -> Option<[RigidTransform; 2]> {
    let v = DVec2::from_array(map.apply([0.0, 0.0]));
    let j = map.derivative([0.0, 0.0]);
    // turns the optical axis to the ray
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Z, v.extend(1.0).normalize()));
    let b = [0, 1].map(|row| [0, 1].map(|column| turn.col(column)[row] - v[row] * turn.col(column)[2]));
    let det = b[0][0] * b[1][1] - b[0][1] * b[1][0];
    let a = [0, 1].map(|column| {
        [
            (b[1][1] * j[0][column] - b[0][1] * j[1][column]) / det,
            (b[0][0] * j[1][column] - b[1][0] * j[0][column]) / det,
        ]
    });
    let [x, y] = a.map(DVec2::from_array);
    let (xx, yy, xy) = (x.length_squared(), y.length_squared(), x.dot(y));
    let gamma = (0.5 * (xx + yy + ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt())).sqrt();
    if !(gamma.is_finite() && gamma > 0.0) {
        return None;
    }
    let (x, y) = (x / gamma, y / gamma);
    let depth = |column: DVec2| (1.0 - column.length_squared()).max(0.0).sqrt();
    let (dx, dy) = (depth(x), depth(y) * if x.dot(y) > 0.0 { -1.0 } else { 1.0 });
    let pose = |sign: f64| {
        // the plane's right, its up, and the normal
        let (right, up) = (turn * x.extend(sign * dx), turn * y.extend(sign * dy));
        let (right, up) = (right.normalize(), (up - up.project_onto(right)).normalize());
        let rotation = DMat3::from_cols(right.cross(up), right, up);
        let middle_m = v.extend(1.0) / gamma;
        let origin_m = middle_m - right * middle[0] - up * middle[1];
        RigidTransform::new(rotation, origin_m)
    };
    Some([pose(1.0), pose(-1.0)])
}

/// Where a point of the plane appears, and how that changes.
pub(super) struct Projection {
    pub pixel: [f64; 2],
    /// Derivatives of column and row by the pose: translation, then rotation.
    pub by_pose: [[f64; FREEDOM]; 2],
    /// Derivatives of column and row by the place on the plane.
    pub by_plane: [[f64; 2]; 2],
}

impl Projection {
    /// `None` for what is behind the camera.
    pub fn of(plane_m: [f64; 2], pose: &RigidTransform, camera: &Camera) -> Option<Projection> {
        let arm = pose.rotation * DVec3::new(0.0, plane_m[0], plane_m[1]);
        let point = arm + pose.translation_m;
        let pixel = camera.project(point)?;
        let ray = DVec2::new(point.x, point.y) / point.z;
        let bent = camera.derivative(ray);
        let focal = [camera.fx, camera.fy];
        let by_point = [0, 1].map(|axis| {
            let [a, b] = bent[axis].map(|slope| focal[axis] * slope / point.z);
            DVec3::new(a, b, -a * ray.x - b * ray.y)
        });
        let (right, up) = (pose.rotation * DVec3::Y, pose.rotation * DVec3::Z);
        Some(Projection {
            pixel,
            // the point turns by ω × arm
            by_pose: by_point.map(|g| {
                let turned = arm.cross(g);
                [g.x, g.y, g.z, turned.x, turned.y, turned.z]
            }),
            by_plane: by_point.map(|g| [g.dot(right), g.dot(up)]),
        })
    }
}

/// A residual in the frame, and how it falls when the pose changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub off_px: f64,
    pub slope: [f64; FREEDOM],
}

/// A pose at a minimum of the residuals.
#[derive(Clone, Debug)]
pub(super) struct Refined {
    pub pose: RigidTransform,
    offs_px: Vec<f64>,
    /// Standard deviation of the residuals, by those that agree.
    pub sigma_px: f64,
    /// (JᵀWJ)⁻¹.
    inverse: [[f64; FREEDOM]; FREEDOM],
}

impl Refined {
    fn planar_pose(&self, dependence: f64) -> PlanarPose {
        let variance = self.sigma_px * self.sigma_px * dependence;
        PlanarPose {
            camera_landmark: self.pose,
            covariance: self.inverse.map(|row| row.map(|v| variance * v)),
            error_px: self.sigma_px,
        }
    }
}

/// Gauss and Newton with Tukey's weights; `None` if the residuals don't determine a pose. `rows` is given the round, and how
/// far the residuals of the round before scattered.
pub(super) fn refined(
    start: RigidTransform,
    rounds: usize,
    rows: impl Fn(&RigidTransform, usize, f64) -> Vec<Row>,
) -> Option<Refined> {
    let mut pose = start;
    let mut end = None;
    for round in 0..rounds {
        let sigma_px = end.as_ref().map_or(0.0, |end: &Refined| end.sigma_px);
        let rows = rows(&pose, round, sigma_px);
        let mut sizes: Vec<f64> = rows.iter().map(|row| row.off_px.abs()).collect();
        let scale_px = (MAD_TO_SIGMA * median(&mut sizes, f64::total_cmp)?).max(LEAST_SIGMA_PX);
        let (mut normal, mut right) = ([0.0; FREEDOM * FREEDOM], [0.0; FREEDOM]);
        let (mut weights, mut squares, mut growth) = (0.0, 0.0, 0.0);
        for Row { off_px, slope } in &rows {
            let robust = Biweight::of(off_px / scale_px);
            let pull = robust.weight * off_px;
            weights += robust.weight;
            squares += pull * pull;
            growth += robust.growth;
            for (i, a) in slope.iter().enumerate() {
                right[i] += pull * a;
                let row = normal[i * FREEDOM..].iter_mut();
                row.zip(slope).for_each(|(sum, b)| *sum += robust.weight * a * b);
            }
        }
        if weights <= FREEDOM as f64 || growth <= 0.0 {
            return None;
        }
        let eigen = Symmetric::of(&normal, FREEDOM)?;
        let step = eigen.solve(&right);
        // Huber 1981, Robust Statistics, 7.6: Σψ²/(n − p) over the square of the mean of ψ′, for what the weights leave
        let rows_per_degree = rows.len() as f64 / (rows.len() - FREEDOM) as f64;
        let sigma_px = (squares * weights * rows_per_degree).sqrt() / growth;
        let sigma_px = sigma_px.max(LEAST_SIGMA_PX);
        let mut inverse = [[0.0; FREEDOM]; FREEDOM];
        // a direction that nothing determines: no pose
        let largest = eigen.values.iter().fold(0.0_f64, |most, value| most.max(*value));
        if !eigen.values.iter().all(|value| *value > UNDETERMINED * largest) {
            return None;
        }
        for (value, vector) in eigen.values.iter().zip(&eigen.vectors) {
            for (row, a) in inverse.iter_mut().zip(vector) {
                row.iter_mut().zip(vector).for_each(|(sum, b)| *sum += a * b / value);
            }
        }
        let offs_px = rows.iter().map(|row| row.off_px).collect();
        end = Some(Refined { pose, offs_px, sigma_px, inverse });
        pose = moved(&pose, &step);
        if !(pose.translation_m.is_finite() && pose.translation_m.z > 0.0) {
            return None;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::Random;

    const CAMERA: Camera = Camera {
        fx: 525.0,
        fy: 526.0,
        cx: 321.5,
        cy: 237.5,
        distortion: [-0.22, 0.06, 4e-4, -5e-4, 0.0],
        width_px: 640,
        height_px: 480,
    };

    /// A landmark that faces the camera from straight ahead, turned about its upward axis, then its right one, then the view.
    fn before(distance_m: f64, angles_deg: [f64; 3]) -> RigidTransform {
        let [yaw, pitch, roll] = angles_deg.map(f64::to_radians);
        let facing = DMat3::from_cols(-DVec3::Z, DVec3::X, -DVec3::Y);
        let turned = DQuat::from_rotation_z(roll) * DQuat::from_mat3(&facing);
        let rotation = turned * DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch);
        RigidTransform { rotation, translation_m: DVec3::new(0.08, -0.05, 1.0) * distance_m }
    }

    /// Points of a landmark as a frame shows it, with normal errors.
    fn seen(pose: &RigidTransform, width_m: f64, camera: &Camera, sigma_px: f64, seed: u64) -> Vec<Sighting> {
        let random = &mut Random::new(seed, 903);
        (0..48)
            .map(|index| {
                let part = |at: usize, count: usize| (at as f64 + 0.5) / count as f64 - 0.5;
                let plane_m = [width_m * part(index % 8, 8), 0.75 * width_m * part(index / 8, 6)];
                let [x, y] = camera.project(pose.apply(DVec3::new(0.0, plane_m[0], plane_m[1]))).unwrap();
                let [a, b] = random.normals();
                Sighting { plane_m, frame_px: [x + sigma_px * a, y + sigma_px * b] }
            })
            .collect()
    }

    #[test]
    fn exact_points_give_the_exact_pose() {
        for angles_deg in [[0.0, 0.0, 0.0], [50.0, 0.0, 20.0], [-30.0, 35.0, -100.0], [5.0, -60.0, 179.0]] {
            let truth = before(1.3, angles_deg);
            let mut sightings = seen(&truth, 0.6, &CAMERA, 0.0, 1);
            for wrong in [false, true] {
                if wrong {
                    // a fifth of the points is wrong
                    sightings.iter_mut().step_by(5).for_each(|sighting| sighting.frame_px[0] += 30.0);
                }
                let pose = solve(&sightings, &CAMERA).unwrap().pose.camera_landmark;
                let off_m = (pose.translation_m - truth.translation_m).length();
                assert!(
                    off_m < 1e-6 && pose.angle_to_rad(&truth) < 1e-6,
                    "{angles_deg:?}, {wrong}: {pose:?}"
                );
            }
        }
    }

    #[test]
    fn errors_are_as_large_as_the_covariance_says() {
        const TRIALS: u64 = 200;
        let mut sum = 0.0;
        for trial in 0..TRIALS {
            let random = &mut Random::new(trial, 904);
            let angles_deg = [random.between(-55.0, 55.0), random.between(-20.0, 20.0), 0.0];
            let truth = before(random.between(0.7, 2.0), angles_deg);
            let found = solve(&seen(&truth, 0.6, &CAMERA, 0.5, trial), &CAMERA).unwrap();
            let other = found.alternative.map(|other| other.camera_landmark.angle_to_rad(&truth));
            let pose = found.pose.camera_landmark;
            assert!(found.ambiguous || other.is_none_or(|other| pose.angle_to_rad(&truth) < other));
            let turn = truth.rotation * pose.rotation.conjugate();
            let turn = if turn.w < 0.0 { -turn } else { turn }.to_scaled_axis();
            let off_m = truth.translation_m - pose.translation_m;
            let off = [off_m.x, off_m.y, off_m.z, turn.x, turn.y, turn.z];
            let scaled = Symmetric::of(found.pose.covariance.as_flattened(), FREEDOM).unwrap().solve(&off);
            sum += scaled.iter().zip(off).map(|(a, b)| a * b).sum::<f64>() / TRIALS as f64;
        }
        println!("mean NEES of 6: {sum:.2}");
        // χ² of 1200 degrees of freedom over 200, and what the measured scale of 90 residuals adds
        assert!((5.5..7.0).contains(&sum), "{sum}");
    }

    #[test]
    fn what_is_small_and_far_away_is_ambiguous_and_what_is_near_is_not() {
        let tele = Camera { fx: 6000.0, fy: 6000.0, distortion: [0.0; 5], ..CAMERA };
        let (mut ambiguous, mut right) = (0, 0);
        for seed in 0..20 {
            let truth = before(34.0, [30.0, 0.0, 0.0]);
            let found = solve(&seen(&truth, 0.4, &tele, 0.5, seed), &tele).unwrap();
            let off_deg = |pose: &PlanarPose| pose.camera_landmark.angle_to_rad(&truth).to_degrees();
            let other = found.alternative.unwrap();
            assert!(off_deg(&found.pose).min(off_deg(&other)) < 6.0, "{found:?}");
            ambiguous += usize::from(found.ambiguous);
            right += usize::from(found.ambiguous || off_deg(&found.pose) < 6.0);
            let near = before(1.0, [30.0, 0.0, 0.0]);
            assert!(!solve(&seen(&near, 0.4, &CAMERA, 0.5, seed), &CAMERA).unwrap().ambiguous);
        }
        assert!(ambiguous >= 15 && right >= 19, "{ambiguous} ambiguous, {right} right or ambiguous");
    }

    #[test]
    fn points_on_a_line_or_too_few_give_no_pose() {
        let all = seen(&before(1.0, [20.0, 0.0, 0.0]), 0.6, &CAMERA, 0.0, 1);
        assert_eq!(solve(&all[..3], &CAMERA), None);
        assert_eq!(solve(&all[..8], &CAMERA), None, "one row");
        assert_eq!(solve(&[], &CAMERA), None);
    }

    #[test]
    fn the_camera_stands_where_the_landmark_says() {
        let camera = MapPose { x_m: 3.0, y_m: -1.0, z_m: 0.8, yaw_deg: 75.0, pitch_deg: 5.0, roll_deg: -3.0 };
        let landmark = MapPose { x_m: 3.6, y_m: 1.5, z_m: 1.4, yaw_deg: -80.0, ..MapPose::default() };
        let truth = camera.optical().inverse().then(&landmark.transform());
        let pose = solve(&seen(&truth, 0.6, &CAMERA, 0.0, 2), &CAMERA).unwrap().pose;
        let found = pose.camera_in_map(&landmark);
        assert!((found.x_m - 3.0).abs() < 1e-5 && (found.y_m + 1.0).abs() < 1e-5, "{found:?}");
        assert!((found.yaw_deg - 75.0).abs() < 1e-4 && (found.roll_deg + 3.0).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn where_the_camera_stands_is_as_sure_as_its_covariance_says() {
        const TRIALS: u64 = 200;
        let camera =
            MapPose { x_m: 3.0, y_m: -1.0, z_m: 0.8, yaw_deg: 175.0, pitch_deg: 5.0, roll_deg: -3.0 };
        let landmark = MapPose { x_m: 1.2, y_m: -0.6, z_m: 1.1, yaw_deg: 20.0, ..MapPose::default() };
        let truth = camera.optical().inverse().then(&landmark.transform());
        let mut sum = 0.0;
        for trial in 0..TRIALS {
            let pose = solve(&seen(&truth, 0.6, &CAMERA, 0.5, trial), &CAMERA).unwrap().pose;
            let [a, b] = Random::new(trial, 905).normals().map(|normal| 0.02 * normal);
            let surveyed = MapPose { x_m: landmark.x_m + a, y_m: landmark.y_m + b, ..landmark };
            let found = pose.camera_on_plane(&surveyed, 0.02);
            let turn_deg = (found.yaw_deg - 175.0 + 180.0).rem_euclid(360.0) - 180.0;
            let off = [found.x_m - 3.0, found.y_m + 1.0, turn_deg.to_radians()];
            let scaled = Symmetric::of(found.covariance.as_flattened(), 3).unwrap().solve(&off);
            sum += scaled.iter().zip(off).map(|(a, b)| a * b).sum::<f64>() / TRIALS as f64;
        }
        println!("mean NEES of 3: {sum:.2}");
        assert!((2.5..3.6).contains(&sum), "{sum}");
    }

    #[test]
    fn the_middle_of_the_picture_is_the_origin_and_its_edge_half_the_width_away() {
        assert_eq!(on_plane([199.5, 149.5], 400, 300, 600.0), [0.0, 0.0]);
        let [right, up] = on_plane([399.5, -0.5], 400, 300, 600.0);
        assert!((right - 0.3).abs() < 1e-12 && (up - 0.225).abs() < 1e-12);
    }
}
