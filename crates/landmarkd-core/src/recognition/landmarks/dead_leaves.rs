//! Dead-leaves backgrounds (Lee, Mumford, Huang 2001, Occlusion models for natural images): leaves of random size, shape and
//! gray level that occlude one another, as things do in natural images. Some leaves show a piece of the exemplar's own
//! picture.

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::imaging::{Frame, Image, Random, bilinear_replicated};

/// Radius of the smallest leaves, and of the largest in shorter sides of the background.
const LEAST_RADIUS_PX: f64 = 3.0;
const MOST_RADIUS: f64 = 0.35;
/// Area of all leaves together, in areas of the background.
const COVERAGE: f64 = 3.0;
/// Gray level where no leaf lies.
const BARE_LEVEL: f32 = 90.0;

/// A background. Later leaves occlude earlier ones.
pub(super) struct DeadLeaves {
    width: usize,
    height: usize,
    leaves: Vec<Leaf>,
}

/// An ellipse or a rectangle.
struct Leaf {
    x_px: f64,
    y_px: f64,
    /// Half the length.
    radius_px: f64,
    /// Width over length.
    aspect: f64,
    /// Direction of the length.
    sin: f64,
    cos: f64,
    rectangular: bool,
    /// Gray level of each channel in the middle.
    level: [f64; 3],
    /// Change of the gray level along the leaf, levels per pixel.
    slope: f64,
    /// Middle of the leaf's texture on the exemplar's picture, and contrast of the texture; 0: none.
    texture_px: [f64; 2],
    contrast: f64,
}

impl DeadLeaves {
    /// Draws leaves until they cover the background several times. Textures are pieces of `picture`.
    pub fn draw(width: usize, height: usize, picture: &Frame, random: &mut Random) -> DeadLeaves {
        let most_radius_px = MOST_RADIUS * width.min(height) as f64;
        let mut covered = 0.0;
        let mut leaves = Vec::new();
        while covered < COVERAGE * (width * height) as f64 {
            let leaf = Leaf::draw(width, height, most_radius_px, picture, random);
            covered += leaf.radius_px * leaf.radius_px * leaf.aspect * PI;
            leaves.push(leaf);
        }
        DeadLeaves { width, height, leaves }
    }

    /// One channel of the background, with the textures of that channel of the picture.
    pub fn render(&self, channel: usize, picture: &Image) -> Image {
        let mut plane = Image::from_fn(self.width, self.height, |_, _| BARE_LEVEL);
        let mean = picture.mean();
        for leaf in &self.leaves {
            let reach = leaf.radius_px * if leaf.rectangular { SQRT_2 } else { 1.0 };
            let range = |centre: f64, length: usize| {
                (centre - reach).max(0.0) as usize..((centre + reach + 1.0).max(0.0) as usize).min(length)
            };
            for py in range(leaf.y_px, self.height) {
                for px in range(leaf.x_px, self.width) {
                    if let Some(level) = leaf.level_at(px as f64, py as f64, channel, picture, mean) {
                        plane.pixels_mut()[py * self.width + px] = level;
                    }
                }
            }
        }
        plane
    }
}

impl Leaf {
    fn draw(width: usize, height: usize, most_radius_px: f64, picture: &Frame, random: &mut Random) -> Leaf {
        // the density of radii is the inverse cube: small leaves cover as much as large ones
        let u = random.uniform();
        let (least, most) = (LEAST_RADIUS_PX, most_radius_px);
        let radius_px = 1.0 / ((1.0 - u) / (least * least) + u / (most * most)).sqrt();
        let (sin, cos) = random.between(0.0, TAU).sin_cos();
        let gray = random.between(10.0, 245.0);
        let tint = if random.uniform() < 0.5 { 0.0 } else { 60.0 };
        // the order of the fields is the order of the draws
        Leaf {
            x_px: random.between(0.0, width as f64),
            y_px: random.between(0.0, height as f64),
            radius_px,
            aspect: random.between(0.3, 1.0),
            sin,
            cos,
            rectangular: random.uniform() < 0.4,
            level: [(); 3].map(|()| (gray + random.between(-tint, tint)).clamp(0.0, 255.0)),
            slope: random.between(-1.0, 1.0) * 40.0 / radius_px.max(8.0),
            texture_px: [picture.width(), picture.height()].map(|side| random.between(0.0, side as f64)),
            contrast: if random.uniform() < 0.5 { random.between(0.2, 1.0) } else { 0.0 },
        }
    }

    /// The gray level at a pixel; `None` outside the leaf. `mean` is that of the picture.
    fn level_at(&self, px: f64, py: f64, channel: usize, picture: &Image, mean: f64) -> Option<f32> {
        let (dx, dy) = (px - self.x_px, py - self.y_px);
        let (u, v) = (self.cos * dx + self.sin * dy, (self.cos * dy - self.sin * dx) / self.aspect);
        let inside = match self.rectangular {
            true => u.abs().max(v.abs()) < self.radius_px,
            false => u * u + v * v < self.radius_px * self.radius_px,
        };
        if !inside {
            return None;
        }
        let mut level = self.level[channel] + self.slope * u;
        if self.contrast > 0.0 {
            let [x_px, y_px] = self.texture_px;
            level += self.contrast * (bilinear_replicated(picture, x_px + u, y_px + v * self.aspect) - mean);
        }
        Some(level.clamp(0.0, 255.0) as f32)
    }
}
