//! The edge template of an exemplar: some hundred points where its picture has the strongest gradients, one a cell.
//! Placed on a frame it tells whether the exemplar is really there: the frame has the same gradient directions.

use super::placement::Placement;
use crate::imaging::Image;
use crate::vision::{Gradient, gradient, gradient_at};

/// Cells of a picture, about: a picture that is full of edges has as many edge points.
const CELLS: usize = 512;
/// Side of a cell at least.
const LEAST_CELL_PX: usize = 4;
/// Gradients below this are noise and shading, gray levels per pixel.
const LEAST_GRADIENT: f32 = 3.0;
/// Gradients much below this count little, whatever their direction; gray levels per pixel.
const SOFT_GRADIENT: f32 = 1.0;

/// A point of an exemplar's picture and the gradient there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// Column, from the picture's centre.
    pub x_px: f32,
    /// Row, from the picture's centre.
    pub y_px: f32,
    /// ∂/∂x, gray levels per pixel.
    pub gradient_x: f32,
    /// ∂/∂y, gray levels per pixel.
    pub gradient_y: f32,
}

/// The strongest gradient of each cell of the picture, which should be smoothed with σ = 1 px.
pub(super) fn edge_points(smoothed: &Image) -> Vec<EdgePoint> {
    let (width, height) = (smoothed.width(), smoothed.height());
    let side = ((width * height / CELLS) as f64).sqrt().ceil().max(LEAST_CELL_PX as f64) as usize;
    let gradient = gradient(smoothed);
    let (middle_x, middle_y) = ((width as f32 - 1.0) / 2.0, (height as f32 - 1.0) / 2.0);
    let mut points = Vec::new();
    for top in (0..height).step_by(side) {
        for left in (0..width).step_by(side) {
            if let Some((px, py)) = strongest(&gradient, left, top, side) {
                points.push(EdgePoint {
                    x_px: px as f32 - middle_x,
                    y_px: py as f32 - middle_y,
                    gradient_x: gradient.x.at(px, py),
                    gradient_y: gradient.y.at(px, py),
                });
            }
        }
    }
    points
}

/// The pixel of a cell with the strongest gradient; `None` if none exceeds [`LEAST_GRADIENT`].
fn strongest(gradient: &Gradient, left: usize, top: usize, side: usize) -> Option<(usize, usize)> {
    let Gradient { x, y } = gradient;
    let (mut most, mut strongest) = (LEAST_GRADIENT * LEAST_GRADIENT, None);
    for py in top..(top + side).min(x.height()) {
        for px in left..(left + side).min(x.width()) {
            let square = x.at(px, py) * x.at(px, py) + y.at(px, py) * y.at(px, py);
            if square > most {
                (most, strongest) = (square, Some((px, py)));
            }
        }
    }
    strongest
}

/// The direction of the gradient at a position of a picture smoothed with σ = 1 px, short where the gradient is weak; `None`
/// outside. For a few positions: what asks for many takes [`GradientDirections`].
pub(super) fn direction_at(smoothed: &Image, x_px: f32, y_px: f32) -> Option<[f32; 2]> {
    // half a pixel more: the cast to an integer truncates
    let (u, v) = (x_px + 0.5, y_px + 0.5);
    let inside = u >= 0.0 && v >= 0.0 && u < smoothed.width() as f32 && v < smoothed.height() as f32;
    inside.then(|| {
        let [gx, gy] = gradient_at(smoothed, u as usize, v as usize);
        let length = (gx * gx + gy * gy).sqrt() + SOFT_GRADIENT;
        [gx / length, gy / length]
    })
}

/// The directions of a frame's gradients, weak ones short: g/(‖g‖ + [`SOFT_GRADIENT`]).
pub(super) struct GradientDirections {
    width: i32,
    height: i32,
    /// Row-major.
    vectors: Vec<[f32; 2]>,
}

impl GradientDirections {
    /// Of a frame smoothed with σ = 1 px.
    pub fn of(smoothed: &Image) -> GradientDirections {
        let Gradient { x, y } = gradient(smoothed);
        let vectors = x.pixels().iter().zip(y.pixels()).map(|(&gx, &gy)| {
            let length = (gx * gx + gy * gy).sqrt() + SOFT_GRADIENT;
            [gx / length, gy / length]
        });
        GradientDirections {
            width: smoothed.width() as i32,
            height: smoothed.height() as i32,
            vectors: vectors.collect(),
        }
    }
}

/// The edge points of an exemplar, prepared for many placements.
pub(super) struct EdgeTemplate {
    /// Gradients are scaled to the weight of the point, weak ones to less.
    points: Vec<EdgePoint>,
    /// Sum of the weights.
    total_weight: f32,
}

impl EdgeTemplate {
    /// The template of an exemplar's edge points.
    pub fn of(points: &[EdgePoint]) -> EdgeTemplate {
        let mut total_weight = 0.0;
        let scaled = points.iter().map(|point| {
            let length = (point.gradient_x.powi(2) + point.gradient_y.powi(2)).sqrt() + SOFT_GRADIENT;
            let weight = length.sqrt();
            total_weight += weight;
            let [gradient_x, gradient_y] =
                [point.gradient_x, point.gradient_y].map(|gradient| weight / length * gradient);
            EdgePoint { gradient_x, gradient_y, ..*point }
        });
        EdgeTemplate { points: scaled.collect(), total_weight }
    }

    /// How well the template agrees with the frame's gradients at a placement: the weighted mean of the cosine of the
    /// angle between them, weak ones counting little, in −1..=1. Points outside the frame count 0; so does a template
    /// without points.
    pub fn agreement(&self, at: &Placement, frame: &GradientDirections) -> f32 {
        let (sin, cos) = at.rotation_rad.sin_cos();
        let (step_x, step_y) = (at.scale * cos, at.scale * sin);
        // half a pixel more: the cast to an integer truncates
        let (left, top) = (at.x_px + 0.5, at.y_px + 0.5);
        let mut sum = 0.0;
        for &EdgePoint { x_px: x, y_px: y, gradient_x, gradient_y } in &self.points {
            let (u, v) = (left + step_x * x - step_y * y, top + step_y * x + step_x * y);
            let (px, py) = (u as i32, v as i32);
            let inside = u >= 0.0 && v >= 0.0 && px < frame.width && py < frame.height;
            if !inside {
                continue;
            }
            let [gx, gy] = frame.vectors[(py * frame.width + px) as usize];
            sum += gx * (cos * gradient_x - sin * gradient_y) + gy * (sin * gradient_x + cos * gradient_y);
        }
        if self.total_weight > 0.0 { sum / self.total_weight } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::toy;
    use super::*;
    use crate::imaging::Frame;
    use crate::vision::smoothed;

    fn at(x_px: f32, y_px: f32, degrees: f32) -> Placement {
        Placement { x_px, y_px, rotation_rad: degrees.to_radians(), scale: 1.0 }
    }

    #[test]
    fn an_edge_template_agrees_where_its_picture_lies_and_nowhere_else() {
        let picture = toy(4, 96);
        let template = EdgeTemplate::of(&edge_points(&smoothed(&picture, 1.0)));
        assert!(template.points.len() > 100, "{}", template.points.len());
        let frame = Frame::gray(picture).turned(40.0);
        let directions = GradientDirections::of(&smoothed(&frame.luminance, 1.0));
        let middle = (frame.width() as f32 - 1.0) / 2.0;
        let there = template.agreement(&at(middle, middle, 40.0), &directions);
        assert!(there > 0.7, "{there}");
        for elsewhere in [at(middle + 9.0, middle, 40.0), at(middle, middle, 70.0), at(middle, middle, 220.0)]
        {
            let agreement = template.agreement(&elsewhere, &directions);
            assert!(agreement < 0.4 * there, "{elsewhere:?}: {agreement}");
        }
        assert_eq!(template.agreement(&at(-500.0, 0.0, 0.0), &directions), 0.0);
    }

    #[test]
    fn edge_templates_have_a_bounded_number_of_points() {
        let noisy = Image::from_fn(400, 300, |x, y| ((x * 7919 + y * 104_729) % 251) as f32);
        let points = edge_points(&noisy);
        assert!((CELLS / 2..=2 * CELLS).contains(&points.len()), "{}", points.len());
        assert_eq!(edge_points(&Image::from_fn(400, 300, |_, _| 90.0)), []);
        assert_eq!(edge_points(&Image::from_fn(1, 1, |_, _| 90.0)), []);
        let nothing = EdgeTemplate::of(&[]);
        assert_eq!(nothing.agreement(&at(3.0, 3.0, 0.0), &GradientDirections::of(&noisy)), 0.0);
    }
}
