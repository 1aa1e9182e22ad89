//! A table with things on it, seen by cameras that look straight down.
//!
//! The table has axes of its own, in millimetres: x right and y down as the overview camera sees it, the origin in the
//! middle. Things stand upright; one unit of theirs is a millimetre, and they turn counter-clockwise in the picture.

use super::drawing::{Paint, View, sampled};
use super::turntable::{NOISE, Thing};

/// How far things reach from where they stand, at most.
const REACH_MM: f32 = 50.0;
/// Width of the table, along which the light falls off.
const WIDTH_MM: f32 = 480.0;
/// A dark cloth.
const CLOTH: Paint = Paint::Clouds { colours: [[7.0, 8.0, 9.0], [15.0, 15.0, 16.0]], size: 40.0, seed: 1200 };

/// A thing on the table.
#[derive(Clone, Debug)]
pub struct PlacedThing {
    pub thing: Thing,
    /// Where its axis is.
    pub x_mm: f32,
    pub y_mm: f32,
    pub turn_deg: f32,
}

impl PlacedThing {
    /// The middle of all that is seen of it from above, x and y.
    pub fn middle_mm(&self) -> [f64; 2] {
        const STEP_MM: f32 = 0.25;
        let steps = (REACH_MM / STEP_MM) as i32;
        let turn = self.turn_deg.to_radians().sin_cos();
        let (mut right, mut back, mut count) = (0.0, 0.0, 0.0);
        for row in -steps..=steps {
            for column in -steps..=steps {
                let (x, y) = (column as f32 * STEP_MM, row as f32 * STEP_MM);
                if self.thing.seen_from_above(x, y, turn).is_some() {
                    right += f64::from(x);
                    back += f64::from(y);
                    count += 1.0;
                }
            }
        }
        [f64::from(self.x_mm) + right / count, f64::from(self.y_mm) - back / count]
    }
}

/// A table under a lamp.
#[derive(Clone, Debug)]
pub struct Table {
    pub things: Vec<PlacedThing>,
    /// By what part the light is less at the right edge than at the left one.
    pub shade: f32,
}

impl Table {
    /// The picture that a camera takes of it: bytes as of [`sampled`].
    pub fn photographed(&self, view: View, size_px: (usize, usize), seed: u32) -> Vec<u8> {
        let turns: Vec<_> = self.things.iter().map(|thing| thing.turn_deg.to_radians().sin_cos()).collect();
        sampled(size_px, NOISE, seed, |dx, dy| {
            let (x, y) = view.scene_point(dx, dy);
            let thing = self.things.iter().zip(&turns).find_map(|(placed, &turn)| {
                let (right, back) = (x - placed.x_mm, placed.y_mm - y);
                let near = right.hypot(back) <= REACH_MM;
                near.then(|| placed.thing.seen_from_above(right, back, turn)).flatten()
            });
            let light = 1.0 - self.shade * (0.5 + x / WIDTH_MM).clamp(0.0, 1.0);
            thing.unwrap_or_else(|| CLOTH.at(x, y)).map(|colour| colour * light)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::turntable::{known_things, unknown_things};

    /// Middle of the pixels that are not cloth, from the picture's, in pixels.
    fn middle_px(bytes: &[u8], (width, height): (usize, usize)) -> [f64; 2] {
        let lit = bytes.chunks(3).enumerate().filter(|(_, pixel)| pixel.iter().any(|v| *v > 21));
        let (mut x, mut y, mut count) = (0.0, 0.0, 0.0);
        for (n, _) in lit {
            x += (n % width) as f64;
            y += (n / width) as f64;
            count += 1.0;
        }
        [x / count - (width as f64 - 1.0) / 2.0, y / count - (height as f64 - 1.0) / 2.0]
    }

    #[test]
    fn every_thing_lies_around_its_middle_and_within_reach() {
        for (name, thing) in known_things().into_iter().chain(unknown_things()) {
            for turn_deg in [0.0, 77.0, 200.0] {
                let placed = PlacedThing { thing: thing.clone(), x_mm: 3.0, y_mm: -4.0, turn_deg };
                let [x, y] = placed.middle_mm();
                let table = Table { things: vec![placed], shade: 0.0 };
                let view = View { scale: 1.25, ..View::of(0.0, 0.0) };
                let bytes = table.photographed(view, (160, 160), 1);
                let [seen_x, seen_y] = middle_px(&bytes, (160, 160));
                let (dx, dy) = (seen_x / 1.25 - x, seen_y / 1.25 - y);
                assert!(dx.hypot(dy) < 0.3, "{name} turned by {turn_deg}°: off by ({dx}, {dy}) mm");
                let edge = |k: usize| [k, 159 * 160 + k, 160 * k, 160 * k + 159];
                let cut = (0..160).flat_map(edge).any(|n| bytes[3 * n..][..3].iter().any(|v| *v > 21));
                assert!(!cut, "{name} turned by {turn_deg}°");
            }
        }
    }

    #[test]
    fn a_positive_turn_brings_the_handle_from_the_right_to_the_top() {
        let mug = || known_things().into_iter().find(|(name, _)| *name == "mug").unwrap().1;
        let middle = |turn_deg| PlacedThing { thing: mug(), x_mm: 10.0, y_mm: 20.0, turn_deg }.middle_mm();
        let ([right, level], [middle_x, top]) = (middle(0.0), middle(90.0));
        assert!(right > 12.0 && (level - 20.0).abs() < 0.1, "{right} {level}");
        assert!(top < 18.0 && (middle_x - 10.0).abs() < 0.1, "{middle_x} {top}");
    }

    #[test]
    fn the_light_falls_off_to_the_right_by_the_shade() {
        let cube = known_things().into_iter().find(|(name, _)| *name == "house").unwrap().1;
        let placed = |x_mm| PlacedThing { thing: cube.clone(), x_mm, y_mm: 0.0, turn_deg: 0.0 };
        let table = Table { things: vec![placed(-180.0), placed(180.0)], shade: 0.2 };
        let bytes = table.photographed(View::of(0.0, 0.0), (480, 100), 1);
        // the same place on both roofs, a mean over 20 × 20 pixels
        let red = |x_px: usize| {
            let patch = (40..60).flat_map(|y| (x_px - 10..x_px + 10).map(move |x| 3 * (480 * y + x)));
            patch.map(|n| f64::from(bytes[n])).sum::<f64>() / 400.0
        };
        let ratio = red(240 + 180) / red(240 - 180);
        // 1 − 0.2 · 420 / 480 over 1 − 0.2 · 60 / 480
        assert!((ratio - 0.825 / 0.975).abs() < 0.01, "{ratio}");
    }
}
