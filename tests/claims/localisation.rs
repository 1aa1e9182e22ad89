//! Where frames were taken: frames of rendered rooms between exemplars a metre apart, and real pairs of pictures of a room
//! with their true relative pose (docs/data.md). All pairs were looked at while parameters were chosen, and rooms of the seeds
//! 1 and 2.

use std::path::Path;

use landmarkd_core::geometry::{Camera, DMat3, DQuat, DVec3, MapPose};
use landmarkd_core::imaging::{DecodeLimits, Frame, Random, decode_reduced};
use landmarkd_core::localisation::scene::{Exposure, Room, Scene};
use landmarkd_core::localisation::{PlaceView, locate, relative_pose};
use landmarkd_core::recognition::landmarks::{ExemplarName, LandmarkOptions, Landmarks, describe};
use landmarkd_core::statistics::quantile;
use serde::Deserialize;

use crate::data::folder;

const CAMERA: Camera = Camera {
    fx: 420.0,
    fy: 421.0,
    cx: 318.0,
    cy: 242.0,
    distortion: [-0.12, 0.03, 2e-4, -3e-4, 0.0],
    width_px: 640,
    height_px: 480,
};
const SEED: u64 = 11;
const FRAMES: u64 = 200;
/// Exemplars look so many ways.
const HEADINGS: u32 = 4;

fn trained(pictures: impl Iterator<Item = Frame>) -> Landmarks {
    let options = LandmarkOptions::default();
    let described = pictures.enumerate().map(|(number, picture)| {
        let name = ExemplarName { id: number.to_string(), label: number.to_string() };
        describe(name, &picture, &options)
    });
    Landmarks::train(described.collect(), &options).unwrap().0
}

#[test]
#[ignore = "takes minutes"]
fn frames_between_exemplars_a_metre_apart_are_located_to_centimetres() {
    let room = |left: f64, seed| Room { least_m: [left, 0.0], greatest_m: [left + 5.0, 4.0], seed };
    let scene = Scene::rooms(&[room(0.0, SEED), room(5.0, SEED + 50)]);
    let mut random = Random::new(SEED, 5);
    let grid = [0.0, 5.0].into_iter().flat_map(|left| (1..=4).map(move |x| left + f64::from(x)));
    let poses: Vec<MapPose> = grid
        .flat_map(|x_m| (1..=3).flat_map(move |y| (0..HEADINGS).map(move |heading| (x_m, y, heading))))
        .map(|(x_m, y, heading)| MapPose {
            x_m,
            y_m: f64::from(y),
            z_m: 0.6,
            yaw_deg: 360.0 / f64::from(HEADINGS) * f64::from(heading),
            ..MapPose::default()
        })
        .collect();
    let exposure = |seed| Exposure { noise: 2.0, seed, ..Exposure::default() };
    let model =
        trained((0..).zip(&poses).map(|(seed, pose)| scene.photograph(&CAMERA, pose, &exposure(seed))));
    let (mut off_m, mut off_deg, mut normalised) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..FRAMES {
        let left = if random.uniform() < 0.5 { 0.0 } else { 5.0 };
        let truth = MapPose {
            x_m: left + random.between(0.9, 4.1),
            y_m: random.between(0.9, 3.1),
            z_m: 0.6,
            yaw_deg: random.between(-180.0, 180.0),
            pitch_deg: random.between(-2.0, 2.0),
            roll_deg: random.between(-1.0, 1.0),
        };
        let gain = random.between(0.8, 1.15);
        let exposure = Exposure { gain: [gain, gain, 0.97 * gain], noise: 3.0, seed: number };
        let asked = model.ask(&scene.photograph(&CAMERA, &truth, &exposure), |_| ()).unwrap();
        let agreeing = model.recognise_asked(&asked, |_| ()).unwrap().agreeing;
        let exemplars: Vec<usize> = agreeing.iter().map(|agreeing| agreeing.exemplar).collect();
        let pairs = model.correspondences(&asked, &exemplars);
        let view = |(agreeing, correspondences)| {
            let landmarkd_core::recognition::landmarks::AgreeingExemplar { exemplar, a_contrario } = agreeing;
            let taught: usize = model.exemplars()[exemplar].id.parse().unwrap();
            PlaceView {
                pose: poses[taught],
                sigma_m: 0.0,
                camera: Some(CAMERA),
                evidence: -a_contrario.log10_false_alarms,
                correspondences,
            }
        };
        let pairs = pairs.iter().map(|pairs| &pairs[..]);
        let views: Vec<PlaceView> = agreeing.into_iter().zip(pairs).map(view).collect();
        let Some(found) = locate(&views, Some(&CAMERA)) else { continue };
        let turned_deg = (found.yaw_deg - truth.yaw_deg + 180.0).rem_euclid(360.0) - 180.0;
        let error = DVec3::new(found.x_m - truth.x_m, found.y_m - truth.y_m, turned_deg.to_radians());
        let inverse = DMat3::from_cols_array_2d(&found.covariance).inverse();
        off_m.push(error.x.hypot(error.y));
        off_deg.push(turned_deg.abs());
        normalised.push(error.dot(inverse * error));
    }
    let at = |values: &[f64], part| quantile(values, part).unwrap();
    println!("{} of {FRAMES} located", off_m.len());
    for (what, values) in [("m", &off_m), ("degrees", &off_deg), ("normalised square", &normalised)] {
        println!("{what}: median {:.4}, 95 % {:.4}", at(values, 0.5), at(values, 0.95));
    }
    assert!(off_m.len() as u64 >= FRAMES * 95 / 100);
    assert!(at(&off_m, 0.5) <= 0.02 && at(&off_m, 0.95) <= 0.15);
    assert!(at(&off_deg, 0.5) <= 0.2 && at(&off_deg, 0.95) <= 2.0);
    // the median of χ² of three degrees of freedom is 2.37; the covariance holds what models leave, too, and renderings have
    // none of that
    assert!((0.3..4.0).contains(&at(&normalised, 0.5)));
}

/// Pictures of one room, and what is true of their cameras.
#[derive(Deserialize)]
struct Pair {
    taught: String,
    asked: String,
    camera_taught: Intrinsics,
    camera_asked: Intrinsics,
    #[serde(rename = "T_asked_taught")]
    asked_taught: [[f64; 4]; 4],
}

#[derive(Deserialize)]
struct Intrinsics {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

#[derive(Deserialize)]
struct Pairs {
    pairs: Vec<Pair>,
}

impl Intrinsics {
    fn camera(&self) -> Camera {
        let Intrinsics { fx, fy, cx, cy } = *self;
        Camera { fx, fy, cx, cy, distortion: [0.0; 5], width_px: 640, height_px: 480 }
    }
}

#[test]
#[ignore = "needs LANDMARKD_DATA"]
fn pictures_of_a_room_far_apart_tell_how_the_camera_moved_or_nothing() {
    let folder = folder().join("real");
    let text = std::fs::read_to_string(folder.join("rooms.json")).unwrap();
    let Pairs { pairs } = serde_json::from_str(&text).unwrap();
    let read = |file: &str| {
        let bytes = std::fs::read(folder.join(Path::new(file))).unwrap();
        decode_reduced(&bytes, &DecodeLimits::default(), 640).unwrap()
    };
    let model = trained(pairs.iter().map(|pair| read(&pair.taught)));
    let mut errors_deg = Vec::new();
    for (number, pair) in pairs.iter().enumerate() {
        let exemplar = model.exemplars().iter().position(|e| e.id == number.to_string()).unwrap();
        let asked = model.ask(&read(&pair.asked), |_| ()).unwrap();
        let points = &model.correspondences(&asked, &[exemplar])[0];
        let found = relative_pose(points, &pair.camera_taught.camera(), &pair.camera_asked.camera());
        let Some((found, direction)) = found.and_then(|found| Some((found.clone(), found.direction?))) else {
            println!("{number}: not determined");
            continue;
        };
        let row = |row: usize| DVec3::from_slice(&pair.asked_taught[row]);
        let rotation = DMat3::from_cols(row(0), row(1), row(2)).transpose();
        let translation =
            DVec3::new(pair.asked_taught[0][3], pair.asked_taught[1][3], pair.asked_taught[2][3]);
        let errors = [
            found.rotation.angle_between(DQuat::from_mat3(&rotation)).to_degrees(),
            direction.angle_between(translation).to_degrees(),
        ];
        let sigmas = [found.rotation_sigma_rad, found.direction_sigma_rad].map(f64::to_degrees);
        println!("{number}: rotation and direction off by {errors:.1?}°, expected {sigmas:.1?}°");
        errors_deg.push(errors[0].max(errors[1]));
    }
    let within = |deg: f64| errors_deg.iter().filter(|error| **error <= deg).count();
    println!("{} of {} determined, {} to within 5°", errors_deg.len(), pairs.len(), within(5.0));
    assert!(within(5.0) >= 2 && within(10.0) == errors_deg.len());
}
