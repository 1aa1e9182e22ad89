//! Solid things on a turntable: convex parts, painted and shaded, seen from a little above, on black; or from right above.
//!
//! A thing has axes of its own: x to the right, y away from the camera, z up; it stands on z = 0 and turns about
//! z, counter-clockwise as seen from above. Camera and lamp stand still. One unit is a pixel; the projection is
//! orthographic. Every picture is drawn from the solids themselves: for each point of it, the nearest part met.

use super::drawing::{Colour, Paint, sampled};

/// Width and height of a picture.
pub const SIDE_PX: usize = 96;
/// How far above the horizon the turntable's camera stands.
const ELEVATION_DEG: f32 = 25.0;
/// Height on the axis that comes to the picture's centre.
const CENTRE_HEIGHT: f32 = 27.0;
/// Direction to the lamp: from the left, before and above.
const LAMP: Vector = [-0.43, -0.56, 0.71];
/// What a face that is turned from the lamp still gets.
const AMBIENT: f32 = 0.35;
/// Largest noise of the camera, gray levels.
pub const NOISE: f32 = 2.0;

const WHITE: Colour = [236.0, 234.0, 226.0];
const BLACK: Colour = [36.0, 35.0, 38.0];
const STEEL: Colour = [150.0, 156.0, 164.0];
const WOOD: Colour = [170.0, 112.0, 60.0];
const RED: Colour = [200.0, 62.0, 50.0];
const BLUE: Colour = [52.0, 96.0, 176.0];
const CREAM: Colour = [232.0, 214.0, 170.0];
const YELLOW: Colour = [234.0, 192.0, 60.0];

type Vector = [f32; 3];

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|v| v / length)
}

/// A vector turned about z.
fn turned(a: Vector, (sin, cos): (f32, f32)) -> Vector {
    [cos * a[0] - sin * a[1], sin * a[0] + cos * a[1], a[2]]
}

/// A convex solid.
#[derive(Clone, Debug)]
enum Shape {
    /// What lies on the inner side, normal · point ≤ offset, of all these planes.
    Faces(Vec<(Vector, f32)>),
    /// A cone without its tip about the vertical axis, with a lid.
    Cone { bottom: f32, top: f32, bottom_radius: f32, top_radius: f32 },
}

/// Where a ray enters a solid.
struct Intersection {
    distance: f32,
    normal: Vector,
    /// Place on the surface: along the face, or around the axis; and upwards.
    surface: (f32, f32),
}

impl Shape {
    /// Where the ray from a point outside enters the solid; `None` beside it.
    fn intersection(&self, from: Vector, towards: Vector) -> Option<Intersection> {
        let at = |distance: f32| [0, 1, 2].map(|axis| from[axis] + distance * towards[axis]);
        match self {
            Shape::Faces(faces) => {
                let (mut entry, mut exit) = ((f32::NEG_INFINITY, [0.0; 3]), f32::INFINITY);
                for &(normal, offset) in faces {
                    let (speed, gap) = (dot(normal, towards), offset - dot(normal, from));
                    if speed < 0.0 && gap / speed > entry.0 {
                        entry = (gap / speed, normal);
                    } else if speed > 0.0 {
                        exit = exit.min(gap / speed);
                    } else if speed == 0.0 && gap < 0.0 {
                        return None;
                    }
                }
                let (distance, normal) = entry;
                let ([x, y, z], along) = (at(distance), normal[0].hypot(normal[1]));
                let surface = match along > 1e-3 {
                    true => ((x * -normal[1] + y * normal[0]) / along, z),
                    false => (x, y),
                };
                (distance < exit).then_some(Intersection { distance, normal, surface })
            }
            &Shape::Cone { bottom, top, bottom_radius, top_radius } => {
                let slope = (top_radius - bottom_radius) / (top - bottom);
                let radius_at = |z: f32| bottom_radius + slope * (z - bottom);
                let lid = (top - from[2]) / towards[2];
                let [x, y, _] = at(lid);
                if x.hypot(y) <= top_radius {
                    // the camera looks down: the lid hides whatever of the side is on the same line
                    return Some(Intersection { distance: lid, normal: [0.0, 0.0, 1.0], surface: (x, y) });
                }
                // x² + y² = radius(z)² along the line
                let (from_radius, radius_speed) = (radius_at(from[2]), slope * towards[2]);
                let a = towards[0].powi(2) + towards[1].powi(2) - radius_speed.powi(2);
                let half_b = from[0] * towards[0] + from[1] * towards[1] - from_radius * radius_speed;
                let c = from[0].powi(2) + from[1].powi(2) - from_radius.powi(2);
                let root = (half_b * half_b - a * c).sqrt();
                // no number if the line passes the solid by, and then in no range
                let sides = [(-half_b - root) / a, (-half_b + root) / a];
                let met = sides.into_iter().filter(|&side| (bottom..=top).contains(&at(side)[2]));
                met.min_by(f32::total_cmp).map(|distance| {
                    let [x, y, z] = at(distance);
                    let radius = radius_at(z).max(1e-3);
                    let normal = unit([x / radius, y / radius, -slope]);
                    let around = y.atan2(x) * bottom_radius.max(top_radius);
                    Intersection { distance, normal, surface: (around, z) }
                })
            }
        }
    }
}

/// A thing that stands on the turntable.
#[derive(Clone, Debug, Default)]
pub struct Thing {
    parts: Vec<(Shape, Paint)>,
}

impl Thing {
    /// Add a box by its least and greatest corner.
    #[must_use]
    fn with_box(self, least: Vector, greatest: Vector, paint: impl Into<Paint>) -> Thing {
        let faces = (0..3).flat_map(|axis| {
            let direction = |sign: f32| {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                normal
            };
            [(direction(1.0), greatest[axis]), (direction(-1.0), -least[axis])]
        });
        self.with_faces(faces.collect(), paint)
    }

    /// Add a solid by its planes: normals of length one that point outwards, and their distances from the origin.
    #[must_use]
    fn with_faces(mut self, faces: Vec<(Vector, f32)>, paint: impl Into<Paint>) -> Thing {
        self.parts.push((Shape::Faces(faces), paint.into()));
        self
    }

    /// Add a cone about the axis by heights and radii of its ends, bottom and top.
    #[must_use]
    fn with_cone(mut self, heights: (f32, f32), radii: (f32, f32), paint: impl Into<Paint>) -> Thing {
        let ((bottom, top), (bottom_radius, top_radius)) = (heights, radii);
        self.parts.push((Shape::Cone { bottom, top, bottom_radius, top_radius }, paint.into()));
        self
    }

    /// The colour that the turntable's camera sees at (`right`, `up`) from its picture's centre, the thing being turned.
    fn at(&self, right: f32, up: f32, turn: (f32, f32)) -> Option<Colour> {
        self.traced(right, up, turn, ELEVATION_DEG.to_radians().sin_cos())
    }

    /// The colour seen from right above at (`right`, `back`) from the thing's axis.
    pub fn seen_from_above(&self, right: f32, back: f32, turn: (f32, f32)) -> Option<Colour> {
        self.traced(right, back, turn, (1.0, 0.0))
    }

    /// The colour seen by a camera at that elevation; `None` beside the thing. Angles are sine and cosine.
    fn traced(&self, right: f32, up: f32, turn: (f32, f32), (sin, cos): (f32, f32)) -> Option<Colour> {
        // The thing stays and all else turns the other way.
        let back = |a: Vector| turned(a, (-turn.0, turn.1));
        const FAR: f32 = 1000.0;
        let towards = back([0.0, cos, -sin]);
        let eye = [right, up * sin - FAR * cos, CENTRE_HEIGHT + up * cos + FAR * sin];
        let (from, lamp) = (back(eye), back(LAMP));
        let met =
            self.parts.iter().filter_map(|(shape, paint)| Some((shape.intersection(from, towards)?, paint)));
        let nearest = met.min_by(|(a, _), (b, _)| a.distance.total_cmp(&b.distance));
        nearest.map(|(hit, paint)| {
            let light = AMBIENT + (1.0 - AMBIENT) * dot(hit.normal, lamp).max(0.0);
            let (u, v) = hit.surface;
            paint.at(u, v).map(|colour| colour * light)
        })
    }

    /// A picture of the thing turned by an angle, [`SIDE_PX`] a side: bytes as of [`sampled`].
    pub fn draw(&self, turn_deg: f32, seed: u32) -> Vec<u8> {
        let turn = turn_deg.rem_euclid(360.0).to_radians().sin_cos();
        sampled((SIDE_PX, SIDE_PX), NOISE, seed, |dx, dy| self.at(dx, -dy, turn).unwrap_or_default())
    }
}

/// The name of the thing that looks the same from all sides.
pub const WITHOUT_POSE: &str = "vase";

/// The things that versions are trained on.
pub fn known_things() -> Vec<(&'static str, Thing)> {
    vec![("house", house()), ("mug", mug()), ("truck", truck()), (WITHOUT_POSE, vase())]
}

/// Things that are shown although no version was trained on them.
pub fn unknown_things() -> Vec<(&'static str, Thing)> {
    vec![("chair", chair()), ("lamp", lamp())]
}

fn mug() -> Thing {
    let glaze = Paint::Mosaic { colours: [BLUE, WHITE], size: 18.0, seed: 1000 };
    Thing::default()
        .with_cone((0.0, 52.0), (22.0, 24.0), glaze)
        .with_cone((50.0, 52.2), (20.0, 20.0), BLACK)
        .with_box([20.0, -4.0, 38.0], [42.0, 4.0, 45.0], BLUE)
        .with_box([20.0, -4.0, 10.0], [42.0, 4.0, 17.0], BLUE)
        .with_box([35.0, -4.0, 10.0], [42.0, 4.0, 45.0], BLUE)
}

fn truck() -> Thing {
    let load = Paint::Chequers { colours: [YELLOW, [176.0, 128.0, 40.0]], size: 13.0 };
    let truck = Thing::default()
        .with_box([-38.0, -11.0, 6.0], [40.0, 11.0, 11.0], BLACK)
        .with_box([-40.0, -13.0, 8.0], [-19.0, 13.0, 38.0], RED)
        .with_box([-40.4, -11.0, 24.0], [-38.0, 11.0, 35.0], BLACK)
        .with_box([-36.0, -13.4, 24.0], [-25.0, 13.4, 35.0], BLACK)
        .with_box([-15.0, -15.0, 11.0], [40.0, 15.0, 46.0], load);
    [-28.0, 6.0, 28.0].into_iter().fold(truck, |truck, x| {
        let wheel = |y: f32| {
            let rim = (0..8).map(|n| {
                let (sin, cos) = (45.0 * n as f32).to_radians().sin_cos();
                ([cos, 0.0, sin], cos * x + sin * 7.0 + 7.0)
            });
            rim.chain([([0.0, 1.0, 0.0], y + 2.0), ([0.0, -1.0, 0.0], 2.0 - y)]).collect()
        };
        truck.with_faces(wheel(12.0), STEEL).with_faces(wheel(-12.0), STEEL)
    })
}

fn house() -> Thing {
    let (ridge, eaves_height, eaves) = (54.0, 27.0, 22.0);
    let slope = |side: f32| {
        let normal = unit([0.0, side * (ridge - eaves_height), eaves]);
        (normal, normal[2] * ridge)
    };
    let roof = vec![
        slope(1.0),
        slope(-1.0),
        ([1.0, 0.0, 0.0], 30.0),
        ([-1.0, 0.0, 0.0], 30.0),
        ([0.0, 0.0, -1.0], -eaves_height),
    ];
    Thing::default()
        .with_box([-26.0, -18.0, 0.0], [26.0, 18.0, 30.0], CREAM)
        .with_faces(roof, Paint::Stripes { colours: [RED, [150.0, 50.0, 44.0]], period: 9.0 })
        .with_box([10.0, -12.0, 32.0], [18.0, -4.0, 60.0], WOOD)
        .with_box([-18.0, -18.5, 0.0], [-7.0, -17.0, 19.0], BLUE)
        .with_box([4.0, -18.5, 9.0], [18.0, -17.0, 21.0], BLACK)
        .with_box([25.0, -10.0, 8.0], [26.5, 2.0, 22.0], BLACK)
        .with_box([-16.0, 17.0, 10.0], [16.0, 18.5, 20.0], STEEL)
}

fn vase() -> Thing {
    Thing::default()
        .with_cone((0.0, 5.0), (15.0, 13.0), WHITE)
        .with_cone((5.0, 28.0), (11.0, 27.0), BLUE)
        .with_cone((28.0, 32.0), (27.0, 27.0), YELLOW)
        .with_cone((32.0, 46.0), (27.0, 11.0), BLUE)
        .with_cone((46.0, 58.0), (10.0, 17.0), WHITE)
        .with_cone((56.0, 58.2), (14.0, 14.0), BLACK)
}

fn chair() -> Thing {
    let legs = [(-16.0, -16.0), (12.0, -16.0), (-16.0, 12.0), (12.0, 12.0)];
    legs.into_iter()
        .fold(Thing::default(), |chair, (x, y)| chair.with_box([x, y, 0.0], [x + 4.0, y + 4.0, 24.0], WOOD))
        .with_box([-18.0, -18.0, 24.0], [18.0, 18.0, 28.0], WOOD)
        .with_box(
            [-18.0, 14.0, 28.0],
            [18.0, 18.0, 62.0],
            Paint::Stripes { colours: [WOOD, BLACK], period: 9.0 },
        )
}

fn lamp() -> Thing {
    Thing::default()
        .with_cone((0.0, 5.0), (20.0, 18.0), STEEL)
        .with_cone((5.0, 34.0), (3.0, 3.0), BLACK)
        .with_cone((30.0, 56.0), (30.0, 14.0), CREAM)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn thing(name: &str) -> Thing {
        let mut all = known_things().into_iter().chain(unknown_things());
        all.find(|(label, _)| *label == name).unwrap().1
    }

    /// The largest difference of two pictures' bytes, and the mean one.
    fn difference(a: &[u8], b: &[u8]) -> (u8, f64) {
        let apart: Vec<u8> = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).collect();
        let mean = apart.iter().map(|v| f64::from(*v)).sum::<f64>() / apart.len() as f64;
        (apart.into_iter().max().unwrap(), mean)
    }

    #[test]
    fn a_whole_turn_gives_the_same_picture_and_another_seed_other_noise() {
        let mug = thing("mug");
        assert_eq!(mug.draw(15.0, 1), mug.draw(375.0, 1));
        assert_eq!(mug.draw(0.0, 1), mug.draw(-360.0, 1));
        let (largest, _) = difference(&mug.draw(15.0, 1), &mug.draw(15.0, 3));
        assert!((1..=2 * NOISE as u8 + 1).contains(&largest), "{largest}");
    }

    #[test]
    fn the_vase_looks_the_same_from_all_sides_and_the_mug_does_not() {
        let apart = |name: &str, turn_deg: f32| {
            difference(&thing(name).draw(0.0, 1), &thing(name).draw(turn_deg, 1)).1
        };
        for turn_deg in [10.0, 90.0, 180.0, 301.5] {
            let (vase, mug) = (apart(WITHOUT_POSE, turn_deg), apart("mug", turn_deg));
            assert!(vase < 0.05, "the vase turned by {turn_deg}°: {vase} gray levels apart");
            assert!(mug > 2.0, "the mug turned by {turn_deg}°: {mug} gray levels apart");
        }
    }

    #[test]
    fn a_positive_turn_brings_the_handle_from_the_right_to_the_back_to_the_left() {
        /// How far right of the centre the lit pixels have their middle.
        fn middle_px(bytes: &[u8]) -> f64 {
            let lit = bytes.chunks(3).enumerate().filter(|(_, pixel)| pixel[2] > 8);
            let columns: Vec<usize> = lit.map(|(n, _)| n % SIDE_PX).collect();
            columns.iter().sum::<usize>() as f64 / columns.len() as f64 - (SIDE_PX as f64 - 1.0) / 2.0
        }
        let middle = |turn_deg: f32| middle_px(&thing("mug").draw(turn_deg, 1));
        let [right, back, left] = [0.0, 90.0, 180.0].map(middle);
        assert!(right > 2.0 && left < -2.0 && back.abs() < 0.5, "{right} {back} {left}");
    }

    #[test]
    fn no_thing_is_cut_off_at_any_turn() {
        for (name, thing) in known_things().into_iter().chain(unknown_things()) {
            for turn_deg in [0.0, 30.0, 45.0, 60.0, 90.0, 180.0, 225.0, 270.0] {
                let bytes = thing.draw(turn_deg, 1);
                let lit = |x: usize, y: usize| bytes[3 * (y * SIDE_PX + x)..][..3].iter().any(|v| *v > 8);
                let last = SIDE_PX - 1;
                let rim = (0..SIDE_PX).find(|&n| lit(n, 0) || lit(n, last) || lit(0, n) || lit(last, n));
                assert_eq!(rim, None, "{name} turned by {turn_deg}°");
                let shown = (0..SIDE_PX * SIDE_PX).filter(|n| lit(n % SIDE_PX, n / SIDE_PX)).count();
                assert!(shown > 1000, "{name} turned by {turn_deg}°: {shown} px");
            }
        }
    }

    #[test]
    fn a_face_towards_the_lamp_is_brighter() {
        let cube = Thing::default().with_box([-20.0, -20.0, 0.0], [20.0, 20.0, 40.0], [100.0; 3]);
        let turn = (0.0, 1.0);
        let red = |up| cube.at(0.0, up, turn).unwrap()[0];
        let (front, top) = (red(-15.0), red(12.0));
        let light = |normal: Vector| 100.0 * (AMBIENT + (1.0 - AMBIENT) * dot(normal, LAMP).max(0.0));
        assert!((front - light([0.0, -1.0, 0.0])).abs() < 0.1, "{front}");
        assert!((top - light([0.0, 0.0, 1.0])).abs() < 0.1, "{top}");
        assert_eq!(cube.at(40.0, 0.0, turn), None);
    }

    #[test]
    fn from_above_a_house_is_as_broad_and_long_as_its_roof_and_the_chimney_stands_out() {
        let house = thing("house");
        let turn = 90.0_f32.to_radians().sin_cos();
        // half a roof of 60 × 44, turned by 90°: its length lies along the view's height
        let seen = |right, back| house.seen_from_above(right, back, turn);
        assert!(seen(0.0, 29.0).is_some() && seen(0.0, 31.0).is_none());
        assert!(seen(21.0, 0.0).is_some() && seen(23.0, 0.0).is_none());
        // the chimney at (14, −8) comes to (8, 14): wood, lit from above
        let lit = AMBIENT + (1.0 - AMBIENT) * LAMP[2];
        let [red, ..] = seen(8.0, 14.0).unwrap();
        assert!((red - WOOD[0] * lit).abs() < 0.5, "{red}");
    }
}
