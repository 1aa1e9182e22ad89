//! What is painted on the surfaces of rooms: structure of a few texels up to metres, another for each seed.
//!
//! Posters are dead leaves (Lee, Mumford, Huang 2001, Occlusion models for natural images): shapes whose radii have an
//! inverse cube density, one over the other.

use std::f64::consts::{SQRT_2, TAU};

use super::TEXELS_PER_M;
use super::texture::Texture;
use crate::imaging::Random;

/// Red, green, blue, 0..=255.
type Colour = [f64; 3];

/// Texels being painted.
pub(super) struct Paint {
    width: usize,
    height: usize,
    texels: Vec<Colour>,
}

/// A rectangle of texels: left, top, width, height.
#[derive(Clone, Copy)]
struct Area {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

impl Paint {
    /// A picture of leaves.
    pub fn poster([width, height]: [usize; 2], random: &mut Random) -> Texture {
        let mut paint = Paint { width, height, texels: vec![Paint::any_colour(random); width * height] };
        let whole = Area { left: 0.0, top: 0.0, width: width as f64, height: height as f64 };
        paint.leaves(whole, 3.0, width.min(height) as f64 * 0.3, 1.0, random);
        paint.finished(2.0, random)
    }

    /// A wall with pictures, shelves and signs along it.
    pub fn wall(size_m: [f64; 2], random: &mut Random) -> Texture {
        let mut paint = Paint::primed(size_m, random);
        let tone = paint.texels[0];
        match (3.0 * random.uniform()) as usize {
            0 => {}
            1 => paint.bricks(tone, [0.24, 0.08].map(|m| m * TEXELS_PER_M), random),
            _ => {
                let across_m = random.between(0.1, 0.5);
                paint.bricks(tone, [across_m, 3.0].map(|m| m * TEXELS_PER_M), random);
            }
        }
        let mut at_m = random.between(0.05, 0.4);
        while at_m < size_m[0] - 0.4 {
            let width_m = random.between(0.35, 1.2).min(size_m[0] - at_m - 0.05);
            let height_m = random.between(0.3, 1.3);
            let top_m = random.between(0.2, (size_m[1] - height_m - 0.7).max(0.25));
            let [left, top, width, height] = [at_m, top_m, width_m, height_m].map(|m| m * TEXELS_PER_M);
            let area = Area { left, top, width, height };
            match (4.0 * random.uniform()) as usize {
                0 | 1 => paint.picture(area, random),
                2 => paint.shelf(area, random),
                _ => paint.sign(area, random),
            }
            at_m += width_m + random.between(0.05, 0.5);
        }
        paint.finished(3.0, random)
    }

    /// Tiles or boards with stains.
    pub fn floor(size_m: [f64; 2], random: &mut Random) -> Texture {
        let mut paint = Paint::primed(size_m, random);
        let (tone, [across_m, down_m]) = (
            paint.texels[0],
            match random.uniform() < 0.5 {
                true => [random.between(0.3, 0.6); 2],
                false => [1.4, random.between(0.1, 0.2)],
            },
        );
        paint.bricks(tone, [across_m, down_m].map(|m| m * TEXELS_PER_M), random);
        let [width, height] = [paint.width, paint.height].map(|side| side as f64);
        paint.leaves(Area { left: 0.0, top: 0.0, width, height }, 4.0, 0.3 * TEXELS_PER_M, 0.15, random);
        paint.finished(3.0, random)
    }

    /// Bright, with panels.
    pub fn ceiling(size_m: [f64; 2], random: &mut Random) -> Texture {
        let mut paint = Paint::primed(size_m, random);
        let bright = [200.0, 200.0, 195.0];
        paint.texels.fill(bright);
        paint.bricks(bright, [0.6 * TEXELS_PER_M; 2], random);
        paint.finished(2.0, random)
    }

    /// A side of a piece of furniture: drawers, labels, things.
    pub fn furniture(size_m: [f64; 2], colour: Colour, random: &mut Random) -> Texture {
        let mut paint = Paint::primed(size_m, random);
        paint.texels.fill(colour);
        let [width, height] = [paint.width, paint.height].map(|side| side as f64);
        let cell = [random.between(0.2, 0.7), random.between(0.12, 0.4)].map(|m| m * TEXELS_PER_M);
        paint.bricks(colour, cell, random);
        for _ in 0..(3.0 + 6.0 * random.uniform()) as usize {
            let (w, h) = (random.between(0.05, 0.3) * width, random.between(0.05, 0.25) * height);
            let (left, top) = (random.between(0.0, width - w), random.between(0.0, height - h));
            let area = Area { left, top, width: w, height: h };
            if random.uniform() < 0.5 { paint.sign(area, random) } else { paint.picture(area, random) }
        }
        paint.finished(3.0, random)
    }

    /// Any colour that isn't near black or white.
    pub fn any_colour(random: &mut Random) -> Colour {
        let gray = random.between(40.0, 215.0);
        [(); 3].map(|()| (gray + random.between(-55.0, 55.0)).clamp(10.0, 245.0))
    }

    /// One tone all over.
    fn primed(size_m: [f64; 2], random: &mut Random) -> Paint {
        let [width, height] = size_m.map(|side_m| (side_m * TEXELS_PER_M).ceil().max(4.0) as usize);
        let gray = random.between(90.0, 190.0);
        let tone = [(); 3].map(|()| gray + random.between(-25.0, 25.0));
        Paint { width, height, texels: vec![tone; width * height] }
    }

    /// Grain of this deviation over everything, and rounding to bytes.
    fn finished(self, grain: f64, random: &mut Random) -> Texture {
        let texel = |colour: &Colour| {
            let [more, _] = random.normals();
            colour.map(|level| (level + grain * more).round().clamp(0.0, 255.0) as u8)
        };
        let texels = self.texels.iter().map(texel).collect();
        Texture::new(self.width, self.height, texels)
    }

    /// Fills the texels of a rectangle.
    fn fill(&mut self, area: Area, colour: Colour) {
        let span = |from: f64, length: f64, most: usize| {
            from.round().max(0.0) as usize..((from + length).round().max(0.0) as usize).min(most)
        };
        for y in span(area.top, area.height, self.height) {
            let row = span(area.left, area.width, self.width);
            if row.start < row.end {
                self.texels[y * self.width..][row].fill(colour);
            }
        }
    }

    /// Courses of bricks, boards or tiles, each of its own tone, with joints between them.
    fn bricks(&mut self, tone: Colour, [across, down]: [f64; 2], random: &mut Random) {
        let joint = tone.map(|level| 0.7 * level);
        let mut top = -random.between(0.0, down);
        while top < self.height as f64 {
            let mut left = -random.between(0.0, across);
            while left < self.width as f64 {
                let change = random.between(-14.0, 14.0);
                self.fill(Area { left, top, width: across, height: down }, joint);
                let area = Area { left, top, width: across - 2.0, height: down - 2.0 };
                self.fill(area, tone.map(|level| level + change));
                left += across;
            }
            top += down;
        }
    }

    /// A framed picture.
    fn picture(&mut self, area: Area, random: &mut Random) {
        self.fill(area, Paint::any_colour(random));
        let edge = random.between(2.0, 8.0).min(0.2 * area.width.min(area.height));
        let inside = area.shrunk(edge);
        self.fill(inside, Paint::any_colour(random));
        self.leaves(inside, 2.5, 0.4 * inside.width.min(inside.height), 1.0, random);
    }

    /// Boards with things of all widths and heights on them.
    fn shelf(&mut self, area: Area, random: &mut Random) {
        self.fill(area, [45.0, 40.0, 36.0]);
        let board = Paint::any_colour(random);
        let rows = (area.height / (0.3 * TEXELS_PER_M)).round().max(1.0);
        let pitch = area.height / rows;
        for row in 0..rows as usize {
            let bottom = area.top + (row + 1) as f64 * pitch - 5.0;
            let mut left = area.left + 4.0;
            loop {
                let width = random.between(0.012, 0.07) * TEXELS_PER_M;
                if left + width > area.left + area.width - 4.0 {
                    break;
                }
                let height = random.between(0.45, 0.95) * (pitch - 8.0);
                let colour = Paint::any_colour(random);
                let thing = Area { left, top: bottom - height, width, height };
                self.fill(thing, colour);
                let label = Area { top: thing.top + 0.2 * height, height: 0.2 * height, ..thing };
                self.fill(label.shrunk(1.0), Paint::any_colour(random));
                left += width + if random.uniform() < 0.1 { 12.0 } else { 1.0 };
            }
            self.fill(Area { left: area.left, top: bottom, width: area.width, height: 5.0 }, board);
        }
    }

    /// Lines of words.
    fn sign(&mut self, area: Area, random: &mut Random) {
        let paper = Paint::any_colour(random);
        let dark = paper.iter().sum::<f64>() > 380.0;
        let ink = if dark { [25.0, 28.0, 40.0] } else { [235.0, 232.0, 220.0] };
        self.fill(area, paper);
        let line = random.between(0.02, 0.08) * TEXELS_PER_M;
        let mut top = area.top + line;
        while top + line < area.top + area.height {
            let mut left = area.left + line;
            loop {
                let width = random.between(0.2, 0.7) * line;
                if left + width > area.left + area.width - line {
                    break;
                }
                let height = random.between(0.3, 0.7) * line;
                if random.uniform() < 0.85 {
                    self.fill(Area { left, top: top + random.between(0.0, 0.3) * line, width, height }, ink);
                }
                left += width + 0.15 * line;
            }
            top += 1.3 * line;
        }
    }

    /// Leaves of `least` texels and more, opaque or a part of it, that cover the area about twice.
    fn leaves(&mut self, area: Area, least: f64, most: f64, opacity: f64, random: &mut Random) {
        let most = most.max(least + 1.0);
        let goal = 2.0 * area.width * area.height * if opacity < 1.0 { 0.2 } else { 1.0 };
        let mut covered = 0.0;
        while covered < goal {
            let u = random.uniform();
            // the density of radii is their inverse cube
            let radius = 1.0 / ((1.0 - u) / (least * least) + u / (most * most)).sqrt();
            let aspect = random.between(0.3, 1.0);
            covered += std::f64::consts::PI * radius * radius * aspect;
            let x = area.left + area.width * random.uniform();
            let y = area.top + area.height * random.uniform();
            let (sin, cos) = random.between(0.0, TAU).sin_cos();
            let (is_round, colour) = (random.uniform() < 0.6, Paint::any_colour(random));
            let slope = random.between(-40.0, 40.0) / radius.max(8.0);
            let reach = radius * if is_round { 1.0 } else { SQRT_2 };
            let span = |at: f64, from: f64, length: f64, most: usize| {
                let start = (at - reach).max(from).max(0.0).ceil() as usize;
                start..((at + reach).min(from + length).max(0.0) as usize).min(most)
            };
            for py in span(y, area.top, area.height, self.height) {
                for px in span(x, area.left, area.width, self.width) {
                    let (dx, dy) = (px as f64 - x, py as f64 - y);
                    let (u, v) = (cos * dx + sin * dy, (cos * dy - sin * dx) / aspect);
                    let inside = match is_round {
                        true => u * u + v * v < radius * radius,
                        false => u.abs().max(v.abs()) < radius,
                    };
                    if inside {
                        let texel = &mut self.texels[py * self.width + px];
                        for (level, new) in texel.iter_mut().zip(colour) {
                            *level += opacity * (new + slope * u - *level);
                        }
                    }
                }
            }
        }
    }
}

impl Area {
    fn shrunk(self, edge: f64) -> Area {
        Area {
            left: self.left + edge,
            top: self.top + edge,
            width: self.width - 2.0 * edge,
            height: self.height - 2.0 * edge,
        }
    }
}
