//! How far away the parts of a scene are: surfaces, one before the other.
//!
//! A depth is given as a share of the working range: 0 at the near focus distance, 1 at the far one. Places are pixels of
//! the near-focused picture.

/// The shape of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// A plane that faces the camera; the share may lie outside 0..1.
    Plane {
        /// Its depth as a share of the working range.
        share: f64,
    },
    /// A plane from 5 % at the picture's left edge to 95 % at its right one.
    Slant,
    /// From 10 % in the middle to 90 % in the corners.
    Cone,
    /// Waves of 64 px from 30 % to 70 %, across the picture and down it.
    Waves,
    /// Six planes from 10 % at the left to 90 % at the right, each hiding a part of the next.
    Staircase,
    /// A plane in the left half, before one that is everywhere.
    Step {
        /// Depth of the left half as a share of the working range.
        near: f64,
        /// Depth behind it.
        far: f64,
    },
    /// Upright strips at 25 %, 3, 6, 12 and 24 px wide, before a plane at 75 %.
    Strips,
    /// A ball, 15 % to 50 %, before a plane at 85 %.
    Sphere,
}

/// Planes of the staircase.
const STEPS: usize = 6;
/// Widths of the strips.
const STRIPS_PX: [f64; 4] = [3.0, 6.0, 12.0, 24.0];
/// Radius of the ball over the picture's shorter side.
const BALL: f64 = 0.35;
/// Length of the waves.
const WAVE_PX: f64 = 64.0;

impl Relief {
    /// How many surfaces it has; the first is the farthest and is everywhere.
    pub(super) fn surfaces(self) -> usize {
        match self {
            Relief::Plane { .. } | Relief::Slant | Relief::Cone | Relief::Waves => 1,
            Relief::Staircase => STEPS,
            Relief::Step { .. } | Relief::Sphere => 2,
            Relief::Strips => 1 + STRIPS_PX.len(),
        }
    }

    /// Whether a surface is at a place of a picture of this size.
    pub(super) fn reaches(self, surface: usize, [x, y]: [f64; 2], [width, height]: [usize; 2]) -> bool {
        let (width, height) = (width as f64, height as f64);
        match self {
            _ if surface == 0 => true,
            Relief::Staircase => x + 0.5 < width * (STEPS - surface) as f64 / STEPS as f64,
            Relief::Step { .. } => x + 0.5 < width / 2.0,
            Relief::Strips => {
                let middle = width * surface as f64 / (STRIPS_PX.len() + 1) as f64;
                (x + 0.5 - middle).abs() < STRIPS_PX[surface - 1] / 2.0
            }
            _ => off_middle([x, y], [width, height]) < BALL * width.min(height),
        }
    }

    /// The depth of a surface at a place, or at its outline's height beyond it.
    pub(super) fn share(self, surface: usize, [x, y]: [f64; 2], [width, height]: [usize; 2]) -> f64 {
        let (width, height) = (width as f64, height as f64);
        let radius = off_middle([x, y], [width, height]);
        match self {
            Relief::Plane { share } => share,
            Relief::Slant => 0.05 + 0.9 * (x + 0.5) / width,
            Relief::Cone => 0.1 + 0.8 * radius / (width.hypot(height) / 2.0),
            Relief::Waves => {
                let wave = |v: f64| (std::f64::consts::TAU * v / WAVE_PX).sin();
                0.5 + 0.1 * (wave(x) + wave(y))
            }
            Relief::Staircase => 0.9 - 0.8 * surface as f64 / (STEPS - 1) as f64,
            Relief::Step { near, far } => [far, near][surface],
            Relief::Strips => {
                if surface == 0 {
                    0.75
                } else {
                    0.25
                }
            }
            Relief::Sphere if surface == 0 => 0.85,
            Relief::Sphere => {
                let out = radius / (BALL * width.min(height));
                0.5 - 0.35 * (1.0 - out * out).max(0.0).sqrt()
            }
        }
    }

    /// The surface that is seen at a place.
    pub(super) fn seen(self, place: [f64; 2], size: [usize; 2]) -> usize {
        (0..self.surfaces()).rev().find(|&surface| self.reaches(surface, place, size)).unwrap_or(0)
    }
}

/// How far a place lies off the middle of a picture, in pixels.
fn off_middle([x, y]: [f64; 2], [width, height]: [f64; 2]) -> f64 {
    (x - (width - 1.0) / 2.0).hypot(y - (height - 1.0) / 2.0)
}
