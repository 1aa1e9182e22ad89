//! Disturbances of a picture with one object: light, noise, place, and what hides a part of it.

use std::f64::consts::TAU;

use crate::imaging::{Frame, Image, Random, bilinear_replicated, seed_of_name};

/// Gray levels by which the object differs from the ground.
const MIN_CONTRAST: f32 = 10.0;
/// Of the random numbers.
const PURPOSE: u64 = 0x0b;
/// Share of the random disturbances that hide something …
const HIDING: f64 = 0.5;
/// … and the largest part of the object that they hide.
const MOST_HIDDEN: f64 = 0.25;

/// What happens to a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Factor of all gray levels.
    pub gain: f64,
    /// Change of the gain from the middle to the border, along [`Disturbance::ramp_rad`].
    pub ramp: f64,
    /// Direction of the ramp.
    pub ramp_rad: f64,
    /// Standard deviation of the noise, gray levels.
    pub noise: f64,
    /// Shift to the right and down, as parts of the longer side.
    pub shift: [f64; 2],
    /// Factor of the object's size.
    pub scale: f64,
    /// Turn in the plane, clockwise as seen, radians.
    pub turn_rad: f64,
    /// The part of the object's pixels that is hidden, 0: none.
    pub hidden: f64,
    /// The side from which it is hidden.
    pub hidden_rad: f64,
    /// Gray level of what hides it.
    pub occluder: f64,
}

impl Disturbance {
    /// None.
    pub const NONE: Disturbance = Disturbance {
        gain: 1.0,
        ramp: 0.0,
        ramp_rad: 0.0,
        noise: 0.0,
        shift: [0.0; 2],
        scale: 1.0,
        turn_rad: 0.0,
        hidden: 0.0,
        hidden_rad: 0.0,
        occluder: 0.0,
    };

    /// A random one of any strength up to what a camera on a bench meets: always the same for a name and a round.
    pub fn random(name: &str, round: u64) -> Disturbance {
        let random = &mut Random::new(seed_of_name(name, round), PURPOSE);
        let strength = random.uniform();
        let hidden =
            if random.uniform() < HIDING { strength * random.between(0.0, MOST_HIDDEN) } else { 0.0 };
        let mut within = |most: f64| random.between(-strength * most, strength * most);
        Disturbance {
            gain: 1.0 + within(0.4),
            ramp: within(0.5),
            noise: within(15.0).abs(),
            shift: [within(0.05), within(0.05)],
            scale: 1.0 + within(0.1),
            turn_rad: within(0.09),
            hidden,
            ramp_rad: random.between(0.0, TAU),
            hidden_rad: random.between(0.0, TAU),
            occluder: random.between(0.0, 255.0),
        }
    }

    /// The disturbed picture; `seed` is of the noise.
    pub fn of(&self, frame: &Frame, seed: u64) -> Frame {
        let (width, height) = (frame.width() as f64, frame.height() as f64);
        let longer = width.max(height);
        let middle = [(width - 1.0) / 2.0, (height - 1.0) / 2.0];
        let cover = self.cover(&frame.luminance);
        let (ramp_sin, ramp_cos) = self.ramp_rad.sin_cos();
        let (sin, cos) = self.turn_rad.sin_cos();
        let random = &mut Random::new(seed, PURPOSE);
        let mut spare = None;
        let mut normal = || {
            spare.take().unwrap_or_else(|| {
                let [now, later] = random.normals();
                spare = Some(later);
                now
            })
        };
        let mut disturbed = |plane: &Image| {
            Image::from_fn(plane.width(), plane.height(), |px, py| {
                let (x, y) = (px as f64 - middle[0], py as f64 - middle[1]);
                // where the pixel was
                let (dx, dy) = (x - self.shift[0] * longer, y - self.shift[1] * longer);
                let (from_x, from_y) =
                    ((cos * dx + sin * dy) / self.scale, (cos * dy - sin * dx) / self.scale);
                let (from_x, from_y) = (from_x + middle[0], from_y + middle[1]);
                let level = match &cover {
                    Some(cover) if cover.hides(from_x, from_y) => self.occluder,
                    _ => bilinear_replicated(plane, from_x, from_y),
                };
                let light = self.gain * (1.0 + self.ramp * 2.0 * (ramp_cos * x + ramp_sin * y) / longer);
                let noise = if self.noise > 0.0 { self.noise * normal() } else { 0.0 };
                (light * level + noise).round().clamp(0.0, 255.0) as f32
            })
        };
        match &frame.rgb {
            Some(rgb) => Frame::colour(rgb.each_ref().map(&mut disturbed)),
            None => Frame::gray(disturbed(&frame.luminance)),
        }
    }

    /// The half plane that hides the part of the object.
    fn cover(&self, luminance: &Image) -> Option<Cover> {
        if self.hidden <= 0.0 {
            return None;
        }
        let ground = luminance.border_median();
        let (sin, cos) = self.hidden_rad.sin_cos();
        let width = luminance.width();
        let mut along: Vec<f64> = (luminance.pixels().iter().enumerate())
            .filter(|(_, v)| (*v - ground).abs() > MIN_CONTRAST)
            .map(|(at, _)| cos * (at % width) as f64 + sin * (at / width) as f64)
            .collect();
        along.sort_by(f64::total_cmp);
        let first = ((1.0 - self.hidden) * along.len() as f64) as usize;
        Some(Cover { sin, cos, from: *along.get(first)? })
    }
}

/// Pixels beyond a line.
struct Cover {
    sin: f64,
    cos: f64,
    from: f64,
}

impl Cover {
    fn hides(&self, x: f64, y: f64) -> bool {
        self.cos * x + self.sin * y > self.from
    }
}
