//! The contour of an exemplar: some hundred places where its picture has the strongest gradients, spread over it.
//! Laid on a frame they tell whether the exemplar is really there: its gradients should be found again.

use super::placement::Placement;
use crate::imaging::Image;
use crate::vision::{Gradient, gradient};

/// About as many contour points has a picture that is full of edges.
const CELLS: usize = 512;
/// Cells are not smaller than this.
const LEAST_CELL_PX: usize = 4;
/// Gradients below this are noise and shading, grey levels per pixel.
const LEAST_GRADIENT: f32 = 3.0;
/// Gradients much below this count little, whichever way they point; grey levels per pixel.
const SOFT_GRADIENT: f32 = 1.0;

/// A place on an exemplar and the gradient there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourPoint {
    /// Column, from the picture's centre.
    pub x_px: f32,
    /// Row, from the picture's centre.
    pub y_px: f32,
    /// ∂/∂x, grey levels per pixel.
    pub gradient_x: f32,
    /// ∂/∂y, grey levels per pixel.
    pub gradient_y: f32,
}

/// The strongest gradient of each cell of the picture, which should be smoothed with σ = 1 px.
pub(super) fn contour(smoothed: &Image) -> Vec<ContourPoint> {
    let (width, height) = (smoothed.width(), smoothed.height());
    let cell = ((width * height / CELLS) as f64).sqrt().ceil().max(LEAST_CELL_PX as f64) as usize;
    let Gradient { x, y } = gradient(smoothed);
    let (middle_x, middle_y) = ((width as f32 - 1.0) / 2.0, (height as f32 - 1.0) / 2.0);
    let mut points = Vec::new();
    for top in (0..height).step_by(cell) {
        for left in (0..width).step_by(cell) {
            let mut best = (LEAST_GRADIENT * LEAST_GRADIENT, None);
            for py in top..(top + cell).min(height) {
                for px in left..(left + cell).min(width) {
                    let (gx, gy) = (x.at(px, py), y.at(px, py));
                    let square = gx * gx + gy * gy;
                    if square > best.0 {
                        best = (square, Some((px, py)));
                    }
                }
            }
            if let (_, Some((px, py))) = best {
                points.push(ContourPoint {
                    x_px: px as f32 - middle_x,
                    y_px: py as f32 - middle_y,
                    gradient_x: x.at(px, py),
                    gradient_y: y.at(px, py),
                });
            }
        }
    }
    points
}

/// The directions of a frame's gradients, weak ones short: g/(‖g‖ + [`SOFT_GRADIENT`]).
pub(super) struct Directions {
    width: i32,
    height: i32,
    /// Row-major.
    vectors: Vec<[f32; 2]>,
}

impl Directions {
    /// Of a frame smoothed with σ = 1 px.
    pub fn of(smoothed: &Image) -> Directions {
        let Gradient { x, y } = gradient(smoothed);
        let vectors = x.pixels().iter().zip(y.pixels()).map(|(&gx, &gy)| {
            let length = (gx * gx + gy * gy).sqrt() + SOFT_GRADIENT;
            [gx / length, gy / length]
        });
        Directions {
            width: smoothed.width() as i32,
            height: smoothed.height() as i32,
            vectors: vectors.collect(),
        }
    }
}

/// A contour made ready to be laid on frames many times.
pub(super) struct Template {
    /// x, y, and the direction times its weight.
    points: Vec<[f32; 4]>,
    weights: f32,
}

impl Template {
    pub fn of(contour: &[ContourPoint]) -> Template {
        let mut weights = 0.0;
        let points = contour.iter().map(|point| {
            let length = (point.gradient_x.powi(2) + point.gradient_y.powi(2)).sqrt() + SOFT_GRADIENT;
            let weight = length.sqrt();
            weights += weight;
            let part = weight / length;
            [point.x_px, point.y_px, part * point.gradient_x, part * point.gradient_y]
        });
        Template { points: points.collect(), weights }
    }

    /// How well the contour laid on a frame agrees with the frame's gradients: the mean of the cosine between them,
    /// weak ones counting little, in −1..=1; 0 for a contour without points. Outside the frame there is no
    /// gradient.
    pub fn agreement(&self, at: &Placement, frame: &Directions) -> f32 {
        let (sin, cos) = at.rotation_rad.sin_cos();
        let (step_x, step_y) = (at.scale * cos, at.scale * sin);
        // half a pixel more, as a cast cuts off
        let (left, top) = (at.x_px + 0.5, at.y_px + 0.5);
        let mut sum = 0.0;
        for &[x, y, along_x, along_y] in &self.points {
            let (u, v) = (left + step_x * x - step_y * y, top + step_y * x + step_x * y);
            let (px, py) = (u as i32, v as i32);
            let inside = u >= 0.0 && v >= 0.0 && px < frame.width && py < frame.height;
            if !inside {
                continue;
            }
            let [gx, gy] = frame.vectors[(py * frame.width + px) as usize];
            sum += gx * (cos * along_x - sin * along_y) + gy * (sin * along_x + cos * along_y);
        }
        if self.weights > 0.0 { sum / self.weights } else { 0.0 }
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
    fn a_contour_agrees_where_its_picture_lies_and_nowhere_else() {
        let picture = toy(4, 96);
        let template = Template::of(&contour(&smoothed(&picture, 1.0)));
        assert!(template.points.len() > 100, "{}", template.points.len());
        let frame = Frame::gray(picture).turned(40.0);
        let directions = Directions::of(&smoothed(&frame.luminance, 1.0));
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
    fn contours_have_a_bounded_number_of_points() {
        let noisy = Image::from_fn(400, 300, |x, y| ((x * 7919 + y * 104_729) % 251) as f32);
        let points = contour(&noisy);
        assert!((CELLS / 2..=2 * CELLS).contains(&points.len()), "{}", points.len());
        assert_eq!(contour(&Image::from_fn(400, 300, |_, _| 90.0)), []);
        assert_eq!(contour(&Image::from_fn(1, 1, |_, _| 90.0)), []);
        let nothing = Template::of(&[]);
        assert_eq!(nothing.agreement(&at(3.0, 3.0, 0.0), &Directions::of(&noisy)), 0.0);
    }
}
