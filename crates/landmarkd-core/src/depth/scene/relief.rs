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
    /// Six planes from 10 % at the left to 90 % at the right, each hiding a part of the next.
    Staircase,
    /// A ball, 15 % to 50 %, before a plane at 85 %.
    Sphere,
}

/// Planes of the staircase.
const STEPS: usize = 6;
/// Radius of the ball over the picture's shorter side.
const BALL: f64 = 0.35;

impl Relief {
    /// How many surfaces it has; the first is the farthest and is everywhere.
    pub(super) fn surfaces(self) -> usize {
        match self {
            Relief::Plane { .. } | Relief::Slant | Relief::Cone => 1,
            Relief::Staircase => STEPS,
            Relief::Sphere => 2,
        }
    }

    /// The depth of a surface at a place of a picture of this size; `None` where it isn't.
    pub(super) fn share(self, surface: usize, [x, y]: [f64; 2], [width, height]: [usize; 2]) -> Option<f64> {
        let (width, height) = (width as f64, height as f64);
        let radius = (x - (width - 1.0) / 2.0).hypot(y - (height - 1.0) / 2.0);
        match self {
            Relief::Plane { share } => Some(share),
            Relief::Slant => Some(0.05 + 0.9 * (x + 0.5) / width),
            Relief::Cone => Some(0.1 + 0.8 * radius / (width.hypot(height) / 2.0)),
            Relief::Staircase => {
                let reaches = surface == 0 || x + 0.5 < width * (STEPS - surface) as f64 / STEPS as f64;
                reaches.then_some(0.9 - 0.8 * surface as f64 / (STEPS - 1) as f64)
            }
            Relief::Sphere if surface == 0 => Some(0.85),
            Relief::Sphere => {
                let out = radius / (BALL * width.min(height));
                (out < 1.0).then(|| 0.5 - 0.35 * (1.0 - out * out).sqrt())
            }
        }
    }

    /// Whether a nearer surface covers all within a distance of a place; every surface's outline is convex.
    pub(super) fn hides(self, surface: usize, [x, y]: [f64; 2], reach: f64, size: [usize; 2]) -> bool {
        (surface + 1..self.surfaces()).any(|nearer| {
            [[-1, -1], [1, -1], [-1, 1], [1, 1]].iter().all(|corner| {
                let [across, down] = corner.map(|v| f64::from(v) * reach);
                self.share(nearer, [x + across, y + down], size).is_some()
            })
        })
    }

    /// The surface that is seen at a place, and its depth.
    pub(super) fn seen(self, place: [f64; 2], size: [usize; 2]) -> (usize, f64) {
        let mut surfaces = (0..self.surfaces()).rev();
        surfaces
            .find_map(|surface| self.share(surface, place, size).map(|share| (surface, share)))
            .expect("the farthest surface is everywhere")
    }
}
