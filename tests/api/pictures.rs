//! Little pictures for the tests, drawn by code: the same number gives the same picture.

use bytes::Bytes;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use landmarkd_core::imaging::encode::{png_gray8, png_rgb8};
use landmarkd_core::imaging::{Frame, Image};

/// Side of a scene, in pixels.
pub const SIDE_PX: usize = 56;

/// A generator of well-mixed numbers (splitmix64): small, seeded, the same everywhere.
pub struct Numbers(u64);

impl Numbers {
    pub fn seeded(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5bf0_3635)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

/// A scene of its own for every number: discs and bars of many grey levels and some colour.
pub fn scene(number: u64) -> Frame {
    let mut numbers = Numbers::seeded(number);
    let mut planes = [100.0_f32, 90.0, 80.0].map(|level| Image::from_fn(SIDE_PX, SIDE_PX, |_, _| level));
    for _ in 0..14 {
        let (centre_x, centre_y) =
            (numbers.below(SIDE_PX as u64) as f32, numbers.below(SIDE_PX as u64) as f32);
        let (half_width, half_height) = (2.0 + numbers.below(6) as f32, 2.0 + numbers.below(6) as f32);
        let is_disc = numbers.below(2) == 0;
        let level = numbers.below(256) as f32;
        for (plane, shift) in planes.iter_mut().zip([0, 1, 2].map(|_| numbers.below(60) as f32 - 30.0)) {
            for at in 0..SIDE_PX * SIDE_PX {
                let (dx, dy) = ((at % SIDE_PX) as f32 - centre_x, (at / SIDE_PX) as f32 - centre_y);
                let inside = if is_disc {
                    dx * dx + dy * dy < half_width * half_width
                } else {
                    dx.abs() < half_width && dy.abs() < half_height
                };
                if inside {
                    plane.pixels_mut()[at] = (level + shift).clamp(0.0, 255.0);
                }
            }
        }
    }
    Frame::colour(planes)
}

/// The frame as a PNG file, in colour or gray as it is.
pub fn png(frame: &Frame) -> Bytes {
    let (width, height) = (frame.width(), frame.height());
    if frame.is_colour() {
        return png_rgb8(width, height, &frame.to_rgb8()).into();
    }
    let levels: Vec<u8> = frame.luminance.pixels().iter().map(|level| level.round() as u8).collect();
    png_gray8(width, height, &levels).into()
}

/// The frame as a JPEG file.
pub fn jpeg(frame: &Frame) -> Bytes {
    let (mut bytes, width, height) = (Vec::new(), frame.width() as u16, frame.height() as u16);
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
    let (width, height) = (u32::from(width), u32::from(height));
    let encoded = { encoder }.encode(&frame.to_rgb8(), width, height, ExtendedColorType::Rgb8);
    encoded.expect("memory takes every byte of a well-formed picture");
    bytes.into()
}

/// Side of a picture of a thing, in pixels.
pub const THING_PX: usize = 48;

/// A thing to be turned before the camera, bright on black.
#[derive(Clone, Copy)]
pub enum Thing {
    /// Shaded from one end to the other.
    Bar,
    Wedge,
    /// A small bright disc and a large dim one.
    Pair,
    /// Looks the same however it is turned.
    Ring,
}

/// A thing turned by so many degrees, with a little noise of its own for every angle; a square picture of a side.
pub fn thing(thing: Thing, turn_deg: f64, side_px: usize) -> Frame {
    let mut numbers = Numbers::seeded((turn_deg * 64.0) as u64 + thing as u64);
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let half = side_px as f64 / 2.0;
    Frame::gray(Image::from_fn(side_px, side_px, |x, y| {
        let (dx, dy) = ((x as f64 + 0.5) / half - 1.0, (y as f64 + 0.5) / half - 1.0);
        let (u, v) = (cos * dx + sin * dy, cos * dy - sin * dx);
        // How far inside the rim, and the brightness there.
        let (inside, level) = match thing {
            Thing::Bar => ((0.8 - u.abs()).min(0.2 - v.abs()), 150.0 + 100.0 * u),
            Thing::Wedge => ((0.35 * (0.7 - u) - v.abs()).min(u + 0.7), 200.0),
            Thing::Pair if u > 0.15 => (0.25 - (u - 0.5).hypot(v), 230.0),
            Thing::Pair => (0.35 - (u + 0.4).hypot(v), 120.0),
            Thing::Ring => (0.12 - (u.hypot(v) - 0.6).abs(), 220.0),
        };
        let noise = numbers.below(5) as f64;
        (level * (0.5 + inside * half).clamp(0.0, 1.0) + noise) as f32
    }))
}

/// The PNG file of a scene.
pub fn scene_png(number: u64) -> Bytes {
    png(&scene(number))
}

/// A picture without any structure.
pub fn flat_png(level: u8) -> Bytes {
    png_rgb8(SIDE_PX, SIDE_PX, &vec![level; 3 * SIDE_PX * SIDE_PX]).into()
}
