//! Drawn pictures: a scene is a stack of painted shapes, a pure function from a point to a colour.
//!
//! Points are (x, y) in scene units, x right, y down; a picture of scale 1 has one unit a pixel. A view is drawn
//! from the scene itself under an affine map, never resampled from another picture, so that a turned or moved view
//! is as sharp as the first. Colours are [r, g, b], 0..=255. All noise is hashed from seeds.

/// A colour: red, green, blue, 0..=255.
pub type Colour = [f32; 3];

/// A pseudo-random number in [0, 1) for a seed and a cell: the same ones everywhere, always.
pub fn hash(seed: u32, x: i32, y: i32) -> f32 {
    let mut h = seed.wrapping_mul(0x9e37_79b9)
        ^ (x as u32).wrapping_mul(0x85eb_ca6b)
        ^ (y as u32).wrapping_mul(0xc2b2_ae35);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    ((h ^ (h >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// Smooth noise in [0, 1) whose features are one unit large.
fn smooth_noise(seed: u32, x: f32, y: f32) -> f32 {
    let (left, top) = (x.floor(), y.floor());
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (right_part, bottom_part) = (ease(x - left), ease(y - top));
    let corner = |dx: i32, dy: i32| hash(seed, left as i32 + dx, top as i32 + dy);
    let upper = corner(0, 0) * (1.0 - right_part) + corner(1, 0) * right_part;
    let lower = corner(0, 1) * (1.0 - right_part) + corner(1, 1) * right_part;
    upper * (1.0 - bottom_part) + lower * bottom_part
}

/// The outline of a shape about its own centre.
#[derive(Clone, Copy, Debug)]
pub enum Outline {
    /// Everywhere.
    Everything,
    /// A rectangle of these half sides.
    Rectangle { half_width: f32, half_height: f32 },
    /// An ellipse of these half axes.
    Ellipse { half_width: f32, half_height: f32 },
    /// A ring between two radii.
    Ring { outer: f32, inner: f32 },
    /// A trapezium: half widths at the top (0: a triangle) and at the bottom.
    Trapezium { half_top: f32, half_bottom: f32, half_height: f32 },
    /// Everything on the side x > 0.
    HalfPlane,
}

impl Outline {
    fn holds(self, x: f32, y: f32) -> bool {
        match self {
            Outline::Everything => true,
            Outline::HalfPlane => x > 0.0,
            Outline::Rectangle { half_width, half_height } => x.abs() <= half_width && y.abs() <= half_height,
            Outline::Ellipse { half_width, half_height } => {
                (x / half_width).powi(2) + (y / half_height).powi(2) <= 1.0
            }
            Outline::Ring { outer, inner } => (inner * inner..=outer * outer).contains(&(x * x + y * y)),
            Outline::Trapezium { half_top, half_bottom, half_height } => {
                let down = (y + half_height) / (2.0 * half_height);
                (0.0..=1.0).contains(&down) && x.abs() <= half_top + (half_bottom - half_top) * down
            }
        }
    }
}

/// What a shape is painted with, in the shape's own coordinates.
#[derive(Clone, Copy, Debug)]
pub enum Paint {
    /// One colour.
    Plain(Colour),
    /// One colour over another, in soft clouds of this size.
    Clouds { colours: [Colour; 2], size: f32, seed: u32 },
    /// Stripes across x, each of its own width's share of the period.
    Stripes { colours: [Colour; 2], period: f32 },
    /// A chequerboard.
    Chequers { colours: [Colour; 2], size: f32 },
    /// Dots on a ground, one in each cell, of differing size and place.
    Dots { colours: [Colour; 2], size: f32, seed: u32 },
    /// Cells of hashed colours between two: no two places look the same.
    Mosaic { colours: [Colour; 2], size: f32, seed: u32 },
    /// Lines of "writing": dark marks of hashed length in rows.
    Writing { colours: [Colour; 2], size: f32, seed: u32 },
}

impl Paint {
    /// The colour at a point.
    pub fn at(self, x: f32, y: f32) -> Colour {
        let cell = |size: f32| ((x / size).floor() as i32, (y / size).floor() as i32);
        match self {
            Paint::Plain(colour) => colour,
            Paint::Clouds { colours, size, seed } => blend(colours, smooth_noise(seed, x / size, y / size)),
            Paint::Stripes { colours, period } => colours[usize::from((x / period).rem_euclid(1.0) < 0.5)],
            Paint::Chequers { colours, size } => {
                let (column, row) = cell(size);
                colours[(column + row).rem_euclid(2) as usize]
            }
            Paint::Dots { colours, size, seed } => {
                let (column, row) = cell(size);
                let part = |salt: u32| hash(seed + salt, column, row);
                let (dx, dy) = (
                    x / size - column as f32 - 0.35 - 0.3 * part(0),
                    y / size - row as f32 - 0.35 - 0.3 * part(1),
                );
                colours[usize::from(dx.hypot(dy) < 0.14 + 0.2 * part(2))]
            }
            Paint::Mosaic { colours, size, seed } => {
                let (column, row) = cell(size);
                [0, 1, 2].map(|c| {
                    let t = 0.7 * hash(seed, column, row) + 0.3 * hash(seed + 1 + c as u32, column, row);
                    colours[0][c] + (colours[1][c] - colours[0][c]) * t
                })
            }
            Paint::Writing { colours, size, seed } => {
                let (column, row) = ((x / (0.55 * size)).floor() as i32, (y / size).floor() as i32);
                let within = (y / size).rem_euclid(1.0);
                let low = 0.3 + 0.3 * hash(seed + 1, column, row);
                let inked = hash(seed, column, row) < 0.72 && (low - 0.25..low + 0.25).contains(&within);
                colours[usize::from(inked)]
            }
        }
    }
}

fn blend(colours: [Colour; 2], part: f32) -> Colour {
    [0, 1, 2].map(|c| colours[0][c] * (1.0 - part) + colours[1][c] * part)
}

/// A painted outline somewhere in the scene.
#[derive(Clone, Copy, Debug)]
struct Shape {
    x: f32,
    y: f32,
    sin: f32,
    cos: f32,
    outline: Outline,
    paint: Paint,
}

impl From<Colour> for Paint {
    fn from(colour: Colour) -> Paint {
        Paint::Plain(colour)
    }
}

/// A stack of painted shapes; a later one covers what is below.
///
/// Angles turn clockwise about a shape's own centre; sizes about a centre are halves.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    shapes: Vec<Shape>,
}

impl Scene {
    /// A scene that is painted everywhere.
    pub fn on(paint: impl Into<Paint>) -> Scene {
        let mut scene = Scene::default();
        scene.shape((0.0, 0.0), 0.0, Outline::Everything, paint);
        scene
    }

    /// A scene that is painted where x > 0.
    pub fn half_plane(paint: impl Into<Paint>) -> Scene {
        let mut scene = Scene::default();
        scene.shape((0.0, 0.0), 0.0, Outline::HalfPlane, paint);
        scene
    }

    /// Adds a shape on top, its centre at a point.
    pub fn shape(&mut self, (x, y): (f32, f32), turn_deg: f32, outline: Outline, paint: impl Into<Paint>) {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        self.shapes.push(Shape { x, y, sin, cos, outline, paint: paint.into() });
    }

    /// Adds an upright rectangle by its left, top, width and height.
    pub fn rectangle(&mut self, left: f32, top: f32, width: f32, height: f32, paint: impl Into<Paint>) {
        let half = [width / 2.0, height / 2.0];
        self.turned_rectangle((left + half[0], top + half[1]), 0.0, half, paint);
    }

    /// Adds a rectangle by its centre, its angle, half width and half height.
    pub fn turned_rectangle(
        &mut self,
        centre: (f32, f32),
        turn_deg: f32,
        [half_width, half_height]: [f32; 2],
        paint: impl Into<Paint>,
    ) {
        self.shape(centre, turn_deg, Outline::Rectangle { half_width, half_height }, paint);
    }

    /// Adds an ellipse by its centre, its angle and its half axes.
    pub fn ellipse(
        &mut self,
        centre: (f32, f32),
        turn_deg: f32,
        [half_width, half_height]: [f32; 2],
        paint: impl Into<Paint>,
    ) {
        self.shape(centre, turn_deg, Outline::Ellipse { half_width, half_height }, paint);
    }

    /// Adds a disc.
    pub fn disc(&mut self, x: f32, y: f32, radius: f32, paint: impl Into<Paint>) {
        self.ellipse((x, y), 0.0, [radius, radius], paint);
    }

    /// Adds a ring by its centre and its two radii.
    pub fn ring(&mut self, centre: (f32, f32), outer: f32, inner: f32, paint: impl Into<Paint>) {
        self.shape(centre, 0.0, Outline::Ring { outer, inner }, paint);
    }

    /// Adds a triangle that stands on its base, by half its base and half its height.
    pub fn triangle(
        &mut self,
        centre: (f32, f32),
        turn_deg: f32,
        [half_width, half_height]: [f32; 2],
        paint: impl Into<Paint>,
    ) {
        self.trapezium(centre, turn_deg, [0.0, half_width, half_height], paint);
    }

    /// Adds a trapezium by its half widths at the top and at the bottom, and half its height.
    pub fn trapezium(
        &mut self,
        centre: (f32, f32),
        turn_deg: f32,
        [half_top, half_bottom, half_height]: [f32; 3],
        paint: impl Into<Paint>,
    ) {
        self.shape(centre, turn_deg, Outline::Trapezium { half_top, half_bottom, half_height }, paint);
    }

    /// The colour at a point; `None` where nothing is painted.
    pub fn at(&self, x: f32, y: f32) -> Option<Colour> {
        self.shapes.iter().rev().find_map(|shape| {
            let (dx, dy) = (x - shape.x, y - shape.y);
            let (x, y) = (shape.cos * dx + shape.sin * dy, shape.cos * dy - shape.sin * dx);
            shape.outline.holds(x, y).then(|| shape.paint.at(x, y))
        })
    }
}

/// How a scene is looked at: the scene point (`x`, `y`) comes to the picture's centre, turned clockwise on the screen
/// and enlarged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    pub x: f32,
    pub y: f32,
    pub turn_deg: f32,
    pub scale: f32,
}

impl View {
    /// Upright, scale 1.
    pub fn of(x: f32, y: f32) -> View {
        View { x, y, turn_deg: 0.0, scale: 1.0 }
    }

    /// The scene point that the picture shows at (`dx`, `dy`) from its centre.
    pub fn scene_point(self, dx: f32, dy: f32) -> (f32, f32) {
        let (sin, cos) = self.turn_deg.to_radians().sin_cos();
        (self.x + (cos * dx + sin * dy) / self.scale, self.y + (cos * dy - sin * dx) / self.scale)
    }
}

/// Scenes one behind the other, each seen under its own view; what is in front comes last.
pub struct Picture<'a> {
    pub width_px: usize,
    pub height_px: usize,
    pub layers: Vec<(&'a Scene, View)>,
    /// Of the camera's noise.
    pub seed: u32,
}

/// Samples along each side of a pixel.
const SAMPLES: usize = 2;
/// Largest noise of the camera, gray levels.
const NOISE: f32 = 4.0;

/// What a camera makes of a scene: interleaved bytes r, g, b, row-major; each pixel is the mean of 2 × 2 points in it,
/// with noise up to that many gray levels. `at` gives the colour at a point from the picture's centre.
pub fn sampled(
    (width_px, height_px): (usize, usize),
    noise: f32,
    seed: u32,
    at: impl Fn(f32, f32) -> Colour,
) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(3 * width_px * height_px);
    for py in 0..height_px {
        for px in 0..width_px {
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let within = |n: usize| (n as f32 + 0.5) / SAMPLES as f32;
                let dx = px as f32 + within(sample % SAMPLES) - width_px as f32 / 2.0;
                let dy = py as f32 + within(sample / SAMPLES) - height_px as f32 / 2.0;
                let colour = at(dx, dy);
                (0..3).for_each(|c| sum[c] += colour[c] / (SAMPLES * SAMPLES) as f32);
            }
            let part = |salt: u32| hash(seed + salt, px as i32, py as i32);
            let noise = noise * (part(0) - part(1));
            bytes.extend(sum.map(|v| (v + noise).round().clamp(0.0, 255.0) as u8));
        }
    }
    bytes
}

impl Picture<'_> {
    /// Draw it: bytes as of [`sampled`].
    pub fn draw(&self) -> Vec<u8> {
        sampled((self.width_px, self.height_px), NOISE, self.seed, |dx, dy| self.at(dx, dy))
    }

    /// The colour at (`dx`, `dy`) from the picture's centre; black where no layer is painted.
    fn at(&self, dx: f32, dy: f32) -> Colour {
        let seen = self.layers.iter().rev().find_map(|(scene, view)| {
            let (x, y) = view.scene_point(dx, dy);
            scene.at(x, y)
        });
        seen.unwrap_or([0.0; 3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Colour = [255.0; 3];

    #[test]
    fn a_later_shape_covers_what_is_below() {
        let mut scene = Scene::on([0.0; 3]);
        scene.rectangle(0.0, 0.0, 4.0, 4.0, [9.0; 3]);
        scene.disc(2.0, 2.0, 1.0, WHITE);
        assert_eq!(
            [scene.at(2.0, 2.0), scene.at(0.5, 0.5), scene.at(9.0, 9.0)],
            [Some(WHITE), Some([9.0; 3]), Some([0.0; 3])]
        );
        assert_eq!(Scene::default().at(0.0, 0.0), None);
    }

    #[test]
    fn a_positive_turn_brings_x_to_y() {
        let mut spot = Scene::default();
        spot.disc(10.0, 0.0, 2.0, WHITE);
        let view = View { turn_deg: 90.0, ..View::of(0.0, 0.0) };
        let picture = Picture { width_px: 32, height_px: 32, layers: vec![(&spot, view)], seed: 0 };
        assert_eq!((picture.at(0.0, 10.0), picture.at(10.0, 0.0)), (WHITE, [0.0; 3]));
        let mut turned_shape = Scene::default();
        turned_shape.shape((0.0, 0.0), 90.0, Outline::HalfPlane, WHITE);
        assert_eq!((turned_shape.at(0.0, 1.0), turned_shape.at(1.0, -0.1)), (Some(WHITE), None));
    }

    #[test]
    fn an_edge_through_a_pixel_gives_its_mean() {
        let mut half = Scene::on([0.0; 3]);
        half.rectangle(0.5, -9.0, 9.0, 18.0, [200.0; 3]);
        let picture =
            Picture { width_px: 4, height_px: 1, layers: vec![(&half, View::of(0.0, 0.0))], seed: 3 };
        let bytes = picture.draw();
        for (px, expected) in [0_i16, 0, 100, 200].into_iter().enumerate() {
            assert!((i16::from(bytes[3 * px]) - expected).abs() <= NOISE as i16, "{bytes:?}");
        }
    }

    #[test]
    fn drawing_twice_gives_the_same_bytes_and_another_seed_other_noise() {
        let scene = Scene::on(Paint::Mosaic { colours: [[0.0; 3], WHITE], size: 5.0, seed: 4 });
        let drawn = |seed| {
            Picture { width_px: 20, height_px: 10, layers: vec![(&scene, View::of(3.0, 4.0))], seed }.draw()
        };
        assert_eq!(drawn(1), drawn(1));
        assert_ne!(drawn(1), drawn(2));
    }
}
