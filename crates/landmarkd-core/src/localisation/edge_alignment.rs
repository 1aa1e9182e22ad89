//! The pose of a flat landmark on the pixels of a frame: its edge template is projected, and where the frame has the same edges a
//! little aside, the pose follows them (Harris and Stennett 1990, RAPID; Drummond and Cipolla 2002).

use std::f64::consts::TAU;

use super::planar_pose::{
    PlanarPoses, Projection, Refined, Row, Sighting, chosen, on_plane, refined, starts,
};
use crate::geometry::{Camera, DQuat, DVec2, DVec3, RigidTransform};
use crate::imaging::{Frame, Image, bilinear_inside};
use crate::recognition::landmarks::{EdgePoint, Exemplar, Landmarks, VerifiedPlacement};
use crate::vision::smoothed;

/// Points of the placement along either side of the picture.
const GRID: usize = 5;
/// How far aside an edge is looked for, round by round, px.
const REACH_PX: [f64; 12] = [8.0, 8.0, 6.0, 6.0, 4.0, 4.0, 3.0, 3.0, 2.0, 2.0, 2.0, 2.0];
/// An edge is looked for as far aside as so many standard deviations of the round before.
const WIDTHS: f64 = 3.0;
/// The errors of edges depend on one another: their variance together is so many times that of independent ones. Found on
/// drawn plates.
const DEPENDENCE: f64 = 1.5;
/// Directions, and angle, in which a landmark is tilted where a start leads nowhere.
const TILTS: usize = 8;
const TILT_RAD: f64 = 0.7;
/// Edges that lie about by accident leave residuals of 3 px and more, those of a drawn landmark 0.7 px and less, those of
/// photographs, through lenses of which little is known, up to 1.6 px.
const MOST_ERROR_PX: f64 = 1.6;
/// Step of the search.
const STEP_PX: f64 = 0.5;
/// Weakest edge of the frame that counts, gray levels per px.
const LEAST_SLOPE: f32 = 1.5;

/// An edge of the landmark's picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaneEdge {
    /// To the right and upwards of the landmark's middle, metres.
    plane_m: [f64; 2],
    /// Towards the brighter side, to the right and upwards; of any length.
    brighter: [f64; 2],
}

/// The pose of a flat landmark that a recognition has placed on a frame. `width_mm`: of the landmark's picture on its plane;
/// the camera is that of the frame as it was posted. `None` where the frame doesn't show the landmark's edges near the
/// placement, or where the camera is for pictures of another shape.
pub fn located(
    model: &Landmarks,
    placed: &VerifiedPlacement,
    width_mm: f64,
    frame: &Frame,
    camera: &Camera,
) -> Option<PlanarPoses> {
    let Exemplar { width_px, height_px, edges, .. } = &model.exemplars()[placed.exemplar];
    let working = model.options().working_frame(frame);
    let camera = camera.resized(working.width() as u32, working.height() as u32)?;
    let posted = f64::from(working.reduction);
    let sighting = |index: usize| {
        let part = |at: usize, side: u32| (at as f64 + 0.5) / GRID as f64 * f64::from(side) - 0.5;
        let at = [part(index % GRID, *width_px), part(index / GRID, *height_px)];
        let frame_px = placed.apply(at.map(|at| at as f32), *width_px, *height_px);
        Sighting {
            plane_m: on_plane(at, *width_px, *height_px, width_mm),
            frame_px: frame_px.map(|at| (f64::from(at) + 0.5) / posted - 0.5),
        }
    };
    let sightings: Vec<Sighting> = (0..GRID * GRID).map(sighting).collect();
    // an exemplar at the working size still shows all of its picture
    let [working_width, working_height] = model.working_size_px(placed.exemplar).map(f64::from);
    let width_m = width_mm / 1000.0;
    let height_m = width_m * f64::from(*height_px) / f64::from(*width_px);
    let edge = |edge: &EdgePoint| PlaneEdge {
        plane_m: [
            f64::from(edge.x_px) * width_m / working_width,
            -f64::from(edge.y_px) * height_m / working_height,
        ],
        brighter: [f64::from(edge.gradient_x), -f64::from(edge.gradient_y)],
    };
    let edges: Vec<PlaneEdge> = edges.iter().map(edge).collect();
    aligned(&sightings, &edges, &smoothed(&working.luminance, 1.0), &camera)
}

/// The pose on the edges of a frame that is smoothed with σ = 1 px, from a rough one: points of the plane and about where the
/// frame shows them.
fn aligned(
    sightings: &[Sighting],
    edges: &[PlaneEdge],
    smoothed: &Image,
    camera: &Camera,
) -> Option<PlanarPoses> {
    let rows = |pose: &RigidTransform, round: usize, sigma_px: f64| -> Vec<Row> {
        // what doesn't fit exactly, as the lens or the picture isn't quite what it is said to be, is looked for farther aside
        let reach_px = REACH_PX[round].max(WIDTHS * sigma_px).min(REACH_PX[0]);
        edges.iter().filter_map(|edge| found(edge, pose, smoothed, camera, reach_px)).collect()
    };
    let from = |start: RigidTransform| refined(start, REACH_PX.len(), rows);
    let is_good = |end: &Refined| end.sigma_px < MOST_ERROR_PX;
    let starts = starts(sightings, camera)?;
    let mut ends: Vec<Refined> = starts.into_iter().filter_map(from).collect();
    if !ends.iter().any(is_good) {
        // a homography of few points doesn't tell how a landmark is tilted
        ends.extend(tilted(&starts[0]).into_iter().filter_map(from));
    }
    ends.retain(is_good);
    let best = ends.iter().min_by(|a, b| a.sigma_px.total_cmp(&b.sigma_px))?;
    let other = mirrored(&best.pose, sightings, camera).and_then(from);
    ends.extend(other);
    chosen(ends, DEPENDENCE)
}

/// The other pose of a plane that looks nearly the same.
fn mirrored(pose: &RigidTransform, sightings: &[Sighting], camera: &Camera) -> Option<RigidTransform> {
    let seen = |&Sighting { plane_m, .. }: &Sighting| {
        Some(Sighting { plane_m, frame_px: Projection::of(plane_m, pose, camera)?.pixel })
    };
    let seen: Vec<Sighting> = sightings.iter().filter_map(seen).collect();
    let both = starts(&seen, camera)?;
    both.into_iter().max_by(|a, b| pose.angle_to_rad(a).total_cmp(&pose.angle_to_rad(b)))
}

/// The landmark tilted in all directions, as much nearer as to look as large.
fn tilted(pose: &RigidTransform) -> Vec<RigidTransform> {
    let tilt = |direction: usize| {
        let (up, right) = (TAU * direction as f64 / TILTS as f64).sin_cos();
        let turn = DQuat::from_axis_angle(DVec3::new(0.0, right, up), TILT_RAD);
        RigidTransform {
            rotation: pose.rotation * turn,
            translation_m: pose.translation_m * TILT_RAD.cos().sqrt(),
        }
    };
    (0..TILTS).map(tilt).collect()
}

/// How far aside of its projection the frame has an edge.
fn found(
    edge: &PlaneEdge,
    pose: &RigidTransform,
    smoothed: &Image,
    camera: &Camera,
    reach_px: f64,
) -> Option<Row> {
    let Projection { pixel: [x, y], by_pose, by_plane: j } = Projection::of(edge.plane_m, pose, camera)?;
    let margin_px = reach_px + 2.0 * STEP_PX + 1.0;
    let is_inside = |at: f64, side: usize| at >= margin_px && at < side as f64 - margin_px;
    if !(is_inside(x, smoothed.width()) && is_inside(y, smoothed.height())) {
        return None;
    }
    // a gradient is a covector: it goes by the inverse transpose, and the plane's upwards is the frame's downwards
    let [right, up] = edge.brighter;
    let normal = DVec2::new(j[1][0] * up - j[1][1] * right, j[0][1] * right - j[0][0] * up).normalize();
    let slope_at = |step: isize| {
        let level = |off_px: f64| bilinear_inside(smoothed, x + off_px * normal.x, y + off_px * normal.y);
        let off_px = step as f64 * STEP_PX;
        level(off_px + STEP_PX) - level(off_px - STEP_PX)
    };
    let steps = (reach_px / STEP_PX) as isize;
    let slopes: Vec<f32> = (-steps - 1..=steps + 1).map(slope_at).collect();
    let peak = |(at, three): (usize, &[f32])| {
        let [before, here, after] = [three[0], three[1], three[2]];
        let is_peak = here >= LEAST_SLOPE && here >= before && here > after;
        is_peak.then(|| {
            let between = 0.5 * (before - after) / (before - 2.0 * here + after);
            let off_px = (at as f64 - steps as f64 + f64::from(between)) * STEP_PX;
            (off_px, f64::from(here) * (-2.0 * (off_px / reach_px).powi(2)).exp())
        })
    };
    let peaks = slopes.windows(3).enumerate().filter_map(peak);
    let (off_px, _) = peaks.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let slope = std::array::from_fn(|i| normal.x * by_pose[0][i] + normal.y * by_pose[1][i]);
    Some(Row { off_px, slope })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::MapPose;
    use crate::imaging::Random;
    use crate::localisation::scene::{Exposure, Room, Scene, poster};
    use crate::recognition::landmarks::{ExemplarName, Homography, LandmarkOptions, describe};

    const CAMERA: Camera = Camera {
        fx: 525.0,
        fy: 526.0,
        cx: 321.5,
        cy: 237.5,
        distortion: [-0.22, 0.06, 4e-4, -5e-4, 0.0],
        width_px: 640,
        height_px: 480,
    };
    const WIDTH_MM: f64 = 600.0;
    const SIZE_PX: [u32; 2] = [400, 300];

    /// A plate's pose before a camera that stands in a room, and the frame.
    fn photographed(
        picture: &Frame,
        distance_m: f64,
        turn_deg: f64,
        pitch_deg: f64,
    ) -> (RigidTransform, Frame) {
        let mut scene = Scene::rooms(&[Room { least_m: [0.0, 0.0], greatest_m: [7.0, 5.0], seed: 3 }]);
        let camera = MapPose { x_m: 1.5, y_m: 2.4, z_m: 1.2, roll_deg: 3.0, ..MapPose::default() };
        let plate = MapPose {
            x_m: 1.5 + distance_m,
            y_m: 2.5,
            z_m: 1.25,
            yaw_deg: 180.0 + turn_deg,
            pitch_deg,
            roll_deg: 8.0,
        };
        scene.hang(picture, WIDTH_MM / 1000.0, &plate);
        let exposure = Exposure { noise: 2.0, ..Exposure::default() };
        let truth = camera.optical().inverse().then(&plate.transform());
        (truth, scene.photograph(&CAMERA, &camera, &exposure))
    }

    /// A placement whose points are so many pixels off.
    fn placed(truth: &RigidTransform, off_px: f64) -> VerifiedPlacement {
        let random = &mut Random::new(5, 902);
        let pairs = [[0.0, 0.0], [399.0, 0.0], [399.0, 299.0], [0.0, 299.0]].map(|at| {
            let [right, up] = on_plane(at, SIZE_PX[0], SIZE_PX[1], WIDTH_MM);
            let [x, y] = CAMERA.project(truth.apply(DVec3::new(0.0, right, up))).unwrap();
            (at, [x + random.between(-off_px, off_px), y + random.between(-off_px, off_px)])
        });
        let homography = Homography::fitted(&pairs).unwrap();
        let [x, y] = homography.apply([199.5, 149.5]);
        let placement = crate::recognition::landmarks::Placement {
            x_px: x as f32,
            y_px: y as f32,
            rotation_rad: 0.0,
            scale: 1.0,
        };
        VerifiedPlacement {
            exemplar: 0,
            placement,
            homography: Some(homography),
            inliers: 10,
            agreement: 0.5,
        }
    }

    fn taught(picture: &Frame) -> Landmarks {
        let options = LandmarkOptions::default();
        let described =
            [picture.clone(), poster(92, 400, 300)].into_iter().enumerate().map(|(number, picture)| {
                let name = ExemplarName { id: number.to_string(), label: number.to_string() };
                describe(name, &picture, &options)
            });
        Landmarks::train(described.collect(), &options).unwrap().0
    }

    #[test]
    fn a_rough_placement_becomes_exact_on_the_edges_and_no_landmark_has_no_pose() {
        let picture = poster(91, 400, 300);
        let model = taught(&picture);
        for (distance_m, turn_deg, pitch_deg) in [(1.0, 0.0, 0.0), (1.5, 40.0, 10.0), (2.2, -20.0, -30.0)] {
            let (truth, frame) = photographed(&picture, distance_m, turn_deg, pitch_deg);
            let placed = placed(&truth, 4.0);
            let found = located(&model, &placed, WIDTH_MM, &frame, &CAMERA).unwrap();
            let pose = found.pose.camera_landmark;
            let off_m = (pose.translation_m - truth.translation_m).length();
            let off_deg = pose.angle_to_rad(&truth).to_degrees();
            assert!(
                off_m < 0.005 * distance_m && off_deg < 1.0,
                "{distance_m}: {off_m} m, {off_deg} degrees"
            );
            assert!(found.pose.error_px < 0.7 && !found.ambiguous, "{found:?}");
            // twice as large, it is twice as far away
            let twice = located(&model, &placed, 2.0 * WIDTH_MM, &frame, &CAMERA).unwrap();
            let ratio = twice.pose.camera_landmark.translation_m.length() / pose.translation_m.length();
            assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
            let (_, without) = photographed(&poster(93, 400, 300), distance_m, turn_deg, pitch_deg);
            assert_eq!(located(&model, &placed, WIDTH_MM, &without, &CAMERA), None);
        }
    }

    #[test]
    fn a_placement_that_says_nothing_of_the_tilt_is_enough() {
        let picture = poster(91, 400, 300);
        let model = taught(&picture);
        let (truth, frame) = photographed(&picture, 2.0, 45.0, 0.0);
        let middle = CAMERA.project(truth.translation_m).unwrap();
        // as large as it looks, and turned as it is, but seen from the front
        let scale = 525.0 * 0.6 / 2.0 / 400.0 * 45.0_f64.to_radians().cos().sqrt();
        let turn = truth.rotation * DVec3::Y;
        let from_middle = Homography::similarity(middle, turn.y.atan2(turn.x), scale);
        let rough = VerifiedPlacement {
            homography: Some(from_middle.from_corner([199.5, 149.5])),
            ..placed(&truth, 0.0)
        };
        let found = located(&model, &rough, WIDTH_MM, &frame, &CAMERA).unwrap();
        let off_deg = found.pose.camera_landmark.angle_to_rad(&truth).to_degrees();
        assert!(off_deg < 1.0, "{off_deg}");
    }
}
