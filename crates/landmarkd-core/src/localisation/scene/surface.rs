//! A textured rectangle in the map, seen from one side.

use super::texture::Texture;
use crate::geometry::{DMat3, DVec3};

/// A rectangle with a texture. Who sees it has its corner at the top left.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    corner: DVec3,
    right: DVec3,
    down: DVec3,
    pub texture: Texture,
    /// Parts that one sees through: spans of the width and of the height, 0..=1.
    pub holes: Vec<[[f64; 2]; 2]>,
    /// How much of the light from above it returns, of 1.
    shade: f64,
}

/// A surface as a camera at one place sees it: rays are met by three products.
pub(super) struct Seen<'a> {
    pub surface: &'a Surface,
    /// Takes a ray d to (s/λ, t/λ, 1/λ), with the point origin + λd at (s, t) of the width and height.
    to_place: DMat3,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    /// Of the width and of the height, 0..=1.
    pub place: [f64; 2],
    /// 1/λ: the greater, the nearer.
    pub nearness: f64,
}

impl Surface {
    pub fn new(corner: DVec3, right: DVec3, down: DVec3, texture: Texture) -> Surface {
        // light falls from above and a little from one side, so that corners of rooms and boxes are seen
        let normal = down.cross(right).normalize();
        let shade = 0.82 + 0.12 * normal.z + 0.05 * normal.x - 0.08 * normal.y;
        Surface { corner, right, down, texture, holes: Vec::new(), shade }
    }

    /// As seen from a point; `None` from behind.
    pub fn from(&self, origin: DVec3) -> Option<Seen<'_>> {
        let before = DMat3::from_cols(self.right, self.down, self.corner - origin);
        // a surface that is seen edge on has no inside
        (before.determinant() > 1e-9).then(|| Seen { surface: self, to_place: before.inverse() })
    }
}

impl Seen<'_> {
    /// Where a ray meets the surface, if that is nearer.
    pub fn met(&self, ray: DVec3, nearer_than: f64) -> Option<Met> {
        let met = self.to_place * ray;
        let nearness = met.z;
        let inside = met.x >= 0.0 && met.y >= 0.0 && met.x <= nearness && met.y <= nearness;
        if !(nearness > nearer_than && inside) {
            return None;
        }
        let place = [met.x / nearness, met.y / nearness];
        let within = |[[a, b], [c, d]]: &[[f64; 2]; 2]| {
            *a < place[0] && place[0] < *b && *c < place[1] && place[1] < *d
        };
        (!self.surface.holes.iter().any(within)).then_some(Met { place, nearness })
    }

    /// The colour there, if a ray of unit depth stands for a square of this side at unit depth.
    pub fn colour(&self, met: &Met, ray_side: f64) -> [f64; 3] {
        // ∂(s, t)/∂(ray) has determinant det(M⁻¹)·λ³, with d along the axis of the camera
        let spread = self.to_place.determinant() / met.nearness.powi(3);
        let texture = &self.surface.texture;
        let [width, height] = texture.size().map(|side| side as f64);
        let texels = (spread * width * height).sqrt() * ray_side;
        texture.colour(met.place, texels).map(|level| self.surface.shade * level)
    }
}
