//! The edge template of an exemplar where a homography lays it: does the frame have the same gradient directions there?
//!
//! It is told beside the evidence and doesn't decide. Measured as a witness with a number of false alarms of its own (against
//! the agreement beside the place) it named two more of 120 half hidden objects, and one strange frame of 36 beside paintings,
//! one building of 40 and two frames of a corridor wrongly.

use crate::imaging::Image;
use crate::recognition::landmarks::edge_template::{EdgePoint, direction_at};
use crate::recognition::landmarks::homography::Homography;

/// Gradients much below this count little, whatever their direction; gray levels per pixel.
const SOFT_GRADIENT: f64 = 1.0;

/// An edge point where a map places it.
#[derive(Clone, Copy, Debug)]
struct PlacedPoint {
    x: f32,
    y: f32,
    /// Direction of the gradient times the weight of the point.
    gradient: [f32; 2],
    weight: f32,
}

/// An edge template that a map has placed on a frame.
pub(super) struct PlacedTemplate {
    points: Vec<PlacedPoint>,
}

impl PlacedTemplate {
    /// Edge points where a map takes them.
    pub fn new(edges: &[EdgePoint], map: &Homography) -> PlacedTemplate {
        let place = |point: &EdgePoint| {
            let at = [f64::from(point.x_px), f64::from(point.y_px)];
            let (j, [x, y]) = (map.derivative(at), map.apply(at));
            let (gx, gy) = (f64::from(point.gradient_x), f64::from(point.gradient_y));
            // a gradient is a covector: it goes by the inverse transpose, whose scale does not matter here
            let (u, v) = (j[1][1] * gx - j[1][0] * gy, j[0][0] * gy - j[0][1] * gx);
            let weight = (gx.hypot(gy) + SOFT_GRADIENT).sqrt();
            let unit = weight / u.hypot(v).max(1e-12);
            PlacedPoint {
                x: x as f32,
                y: y as f32,
                gradient: [(unit * u) as f32, (unit * v) as f32],
                weight: weight as f32,
            }
        };
        PlacedTemplate { points: edges.iter().map(place).collect() }
    }

    /// The weighted mean of the cosine of the angle between the template's and the frame's gradients, weak ones counting little;
    /// of points inside the frame, which is smoothed with σ = 1 px; 0 without any.
    pub fn agreement(&self, smoothed: &Image) -> f32 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for point in &self.points {
            if let Some([gx, gy]) = direction_at(smoothed, point.x, point.y) {
                sum += gx * point.gradient[0] + gy * point.gradient[1];
                weight += point.weight;
            }
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }
}
