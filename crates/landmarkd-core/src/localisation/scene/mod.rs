//! Rooms to walk through and plates to look at, rendered: frames of a camera whose true pose is known.
//!
//! Everything is a textured rectangle: walls, floor, ceiling, the sides of furniture, plates. Each pixel is the mean of
//! several rays, and each ray takes the nearest rectangle's texture at the size of its footprint. Frames are in the map of
//! [`crate::geometry`], metres, z up. Everything follows from seeds.

mod paint;
mod photograph;
mod surface;
mod texture;

pub use photograph::Exposure;

use crate::geometry::{DVec3, MapPose};
use crate::imaging::{Frame, Image, Random};
use paint::Paint;
use surface::Surface;
use texture::Texture;

/// Height of every room.
const HEIGHT_M: f64 = 2.6;
/// Size of a doorway.
const DOORWAY_M: [f64; 2] = [1.0, 2.1];
/// Farthest that furniture reaches from its wall.
pub const FURNITURE_DEPTH_M: f64 = 0.8;
/// Texels a metre of what is looked at from all over a room.
const TEXELS_PER_M: f64 = 250.0;

/// A rectangular room: what lies between two corners, seen from above. Its seed says what it looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Its least x and y.
    pub least_m: [f64; 2],
    /// Its greatest x and y.
    pub greatest_m: [f64; 2],
    /// Of its colours, pictures and furniture.
    pub seed: u64,
}

/// What a camera can photograph.
#[derive(Clone, Debug)]
pub struct Scene {
    surfaces: Vec<Surface>,
}

impl Scene {
    /// Furnished rooms. Rooms that share a part of a wall of at least 1.4 m have a doorway in its middle.
    pub fn rooms(rooms: &[Room]) -> Scene {
        let mut scene = Scene { surfaces: Vec::new() };
        for room in rooms {
            scene.add_room(room, rooms);
        }
        scene
    }

    /// Hangs a flat picture of that width in the map. The pose is that of a flat landmark: x is its normal towards who looks
    /// at it, z its upward side, the origin its middle.
    pub fn hang(&mut self, picture: &Frame, width_m: f64, pose: &MapPose) {
        let height_m = width_m * picture.height() as f64 / picture.width() as f64;
        let stands = pose.transform();
        let right = stands.rotation * DVec3::Y * width_m;
        let down = stands.rotation * -DVec3::Z * height_m;
        let corner = stands.translation_m - 0.5 * (right + down);
        self.surfaces.push(Surface::new(corner, right, down, Texture::of(picture)));
    }

    fn add_room(&mut self, room: &Room, all: &[Room]) {
        let random = &mut Random::new(room.seed, 11);
        let ([x0, y0], [x1, y1]) = (room.least_m, room.greatest_m);
        // seen from inside, from its top left corner: right, then down
        let walls = [([x1, y1], [x1, y0]), ([x1, y0], [x0, y0]), ([x0, y0], [x0, y1]), ([x0, y1], [x1, y1])];
        for (left, right) in walls {
            let doorways = doorways(left, right, room, all);
            self.add_wall(left, right, &doorways, random);
            self.add_furniture(left, right, &doorways, random);
        }
        let (across, along) = (DVec3::X * (x1 - x0), DVec3::Y * (y1 - y0));
        let size_m = [across.length(), along.length()];
        let floor = Paint::floor(size_m, random);
        self.surfaces.push(Surface::new(DVec3::new(x0, y1, 0.0), across, -along, floor));
        let ceiling = Paint::ceiling(size_m, random);
        self.surfaces.push(Surface::new(DVec3::new(x0, y0, HEIGHT_M), across, along, ceiling));
    }

    fn add_wall(&mut self, left: [f64; 2], right: [f64; 2], doorways: &[f64], random: &mut Random) {
        let along = DVec3::new(right[0] - left[0], right[1] - left[1], 0.0);
        let length_m = along.length();
        let texture = Paint::wall([length_m, HEIGHT_M], random);
        let corner = DVec3::new(left[0], left[1], HEIGHT_M);
        let mut wall = Surface::new(corner, along, -DVec3::Z * HEIGHT_M, texture);
        wall.holes = (doorways.iter())
            .map(|middle| {
                let half = 0.5 * DOORWAY_M[0];
                let sides = [middle - half, middle + half].map(|at| at / length_m);
                [sides, [1.0 - DOORWAY_M[1] / HEIGHT_M, 1.0]]
            })
            .collect();
        self.surfaces.push(wall);
    }

    /// Boxes along a wall, none before a doorway nor in the corners.
    fn add_furniture(&mut self, left: [f64; 2], right: [f64; 2], doorways: &[f64], random: &mut Random) {
        let span = DVec3::new(right[0] - left[0], right[1] - left[1], 0.0);
        let (length_m, along) = (span.length(), span.normalize());
        let inwards = DVec3::Z.cross(along) * -1.0;
        let mut at_m = FURNITURE_DEPTH_M + random.between(0.0, 1.0);
        loop {
            let [width_m, depth_m, height_m] =
                [[0.4, 1.3], [0.3, FURNITURE_DEPTH_M], [0.35, 1.7]].map(|[a, b]| random.between(a, b));
            if at_m + width_m > length_m - FURNITURE_DEPTH_M {
                return;
            }
            let near = |middle: &f64| (middle - at_m - 0.5 * width_m).abs() < 0.5 * width_m + DOORWAY_M[0];
            if !doorways.iter().any(near) {
                let corner = DVec3::new(left[0], left[1], 0.0) + along * at_m;
                self.add_box(corner, along * width_m, inwards * depth_m, height_m, random);
            }
            at_m += width_m + random.between(0.3, 2.0);
        }
    }

    /// A box on the floor: `corner` is the left one at the wall.
    fn add_box(&mut self, corner: DVec3, along: DVec3, inwards: DVec3, height_m: f64, random: &mut Random) {
        let (up, colour) = (DVec3::Z * height_m, Paint::any_colour(random));
        let mut side = |corner: DVec3, right: DVec3, down: DVec3| {
            let texture = Paint::furniture([right.length(), down.length()], colour, random);
            self.surfaces.push(Surface::new(corner, right, down, texture));
        };
        side(corner + inwards + up, along, -up);
        side(corner + up, inwards, -up);
        side(corner + along + inwards + up, -inwards, -up);
        side(corner + up, along, inwards);
    }
}

/// A picture worth hanging: leaves of all sizes and colours, one over the other, as bytes.
pub fn poster(seed: u64, width_px: usize, height_px: usize) -> Frame {
    let texture = Paint::poster([width_px, height_px], &mut Random::new(seed, 12));
    Frame::colour(
        [0, 1, 2].map(|channel| {
            Image::from_fn(width_px, height_px, |x, y| f32::from(texture.texel(x, y)[channel]))
        }),
    )
}

/// The middles of the doorways of a wall, in metres from its left end as seen from inside.
fn doorways(left: [f64; 2], right: [f64; 2], room: &Room, all: &[Room]) -> Vec<f64> {
    // the axis across which the wall stands, and the one along which it runs
    let (across, along) = if left[0] == right[0] { (0, 1) } else { (1, 0) };
    let at_m = left[across];
    let neighbours = all.iter().filter(|other| {
        *other != room && (other.least_m[across] == at_m || other.greatest_m[across] == at_m)
    });
    neighbours
        .filter_map(|other| {
            let from = other.least_m[along].max(room.least_m[along]);
            let to = other.greatest_m[along].min(room.greatest_m[along]);
            (to - from >= DOORWAY_M[0] + 0.4).then(|| (0.5 * (from + to) - left[along]).abs())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Camera;

    const CAMERA: Camera = Camera {
        fx: 270.0,
        fy: 271.0,
        cx: 160.5,
        cy: 118.0,
        distortion: [-0.2, 0.05, 4e-4, -5e-4, 0.0],
        width_px: 320,
        height_px: 240,
    };
    const ROOM: Room = Room { least_m: [0.0, 0.0], greatest_m: [6.0, 4.0], seed: 1 };

    fn standing(x_m: f64, y_m: f64, yaw_deg: f64) -> MapPose {
        MapPose { x_m, y_m, z_m: 1.1, yaw_deg, ..MapPose::default() }
    }

    #[test]
    fn a_plate_is_seen_where_its_pose_puts_it() {
        let mut scene = Scene::rooms(&[ROOM]);
        let plate = Frame::gray(Image::from_fn(80, 60, |_, _| 255.0));
        let pose = MapPose { x_m: 3.5, y_m: 2.2, z_m: 1.3, yaw_deg: 200.0, pitch_deg: 10.0, roll_deg: 5.0 };
        scene.hang(&plate, 0.8, &pose);
        let camera_pose = standing(1.5, 2.0, 3.0);
        let frame = scene.photograph(&CAMERA, &camera_pose, &Exposure::default());
        let optical_map = camera_pose.optical().inverse();
        let at = |right_m: f64, up_m: f64| {
            let seen = optical_map.apply(pose.transform().apply(DVec3::new(0.0, right_m, up_m)));
            CAMERA.project(seen).unwrap().map(|v| v.round() as usize)
        };
        let [x, y] = at(0.0, 0.0);
        let white = frame.luminance.at(x, y);
        assert!(white > 150.0, "{white}");
        for (right_m, up_m) in [(0.37, 0.27), (-0.37, 0.27), (-0.37, -0.27), (0.37, -0.27)] {
            let [x, y] = at(right_m, up_m);
            assert_eq!(frame.luminance.at(x, y), white, "({right_m}, {up_m}) at ({x}, {y})");
        }
        for (right_m, up_m) in [(0.43, 0.0), (-0.43, 0.0), (0.0, 0.33), (0.0, -0.33)] {
            let [x, y] = at(right_m, up_m);
            assert_ne!(frame.luminance.at(x, y), white, "({right_m}, {up_m}) at ({x}, {y})");
        }
    }

    #[test]
    fn a_frame_follows_from_its_seeds_and_rooms_differ() {
        let scene = Scene::rooms(&[ROOM]);
        let exposure = Exposure { noise: 2.0, seed: 4, ..Exposure::default() };
        let photographed = |scene: &Scene| scene.photograph(&CAMERA, &standing(2.0, 2.0, 40.0), &exposure);
        assert_eq!(photographed(&scene), photographed(&Scene::rooms(&[ROOM])));
        let other = photographed(&Scene::rooms(&[Room { seed: 2, ..ROOM }]));
        let frame = photographed(&scene);
        let apart = frame.luminance.pixels().iter().zip(other.luminance.pixels()).map(|(a, b)| (a - b).abs());
        assert!(apart.sum::<f32>() / (320.0 * 240.0) > 20.0);
    }

    #[test]
    fn rooms_are_closed_and_a_doorway_shows_the_next_one() {
        let next = Room { least_m: [6.0, 0.0], greatest_m: [10.0, 4.0], seed: 2 };
        let through = standing(3.0, 2.0, 0.0);
        let [alone, joined] = [vec![ROOM], vec![ROOM, next]]
            .map(|rooms| Scene::rooms(&rooms).photograph(&CAMERA, &through, &Exposure::default()));
        let other = Scene::rooms(&[ROOM, Room { seed: 3, ..next }]);
        let other = other.photograph(&CAMERA, &through, &Exposure::default());
        let differ = |a: &Frame, b: &Frame, x: usize, y: usize| {
            (0..3).any(|c| a.rgb.as_ref().unwrap()[c].at(x, y) != b.rgb.as_ref().unwrap()[c].at(x, y))
        };
        let doorway = (140..180).flat_map(|x| (90..130).map(move |y| (x, y)));
        assert!(doorway.filter(|&(x, y)| differ(&joined, &other, x, y)).count() > 800);
        assert!(!(0..40).any(|x| differ(&joined, &other, x, 20)), "the wall itself is the same");
        let black = alone.rgb.as_ref().unwrap()[0].pixels().iter().filter(|v| **v == 0.0).count();
        assert!(black < 50, "{black} pixels of nothing");
    }
}
