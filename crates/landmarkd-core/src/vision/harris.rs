//! An attention operator for corners (Harris and Stephens 1988).
//!
//! With the mean products of the gradient's components about a pixel, A = ⟨gx²⟩, B = ⟨gy²⟩, C = ⟨gx·gy⟩,
//!
//! > R = (AB − C²) − 0.04 (A + B)²
//!
//! is positive where the image changes in both directions, and negative along an edge. The map is the fourth root of
//! it: the same points in the same order as those of R, and of a gradient's unit.

use super::gradient::{Gradient, gradient};
use super::smoothing::smoothed;
use crate::imaging::Image;

/// An edge is what changes more than some 23 times as much (in squares) across as along.
const EDGE: f32 = 0.04;

/// How much the image changes in both directions within `radius_px` of each pixel; of the image's size.
///
/// The image should be smoothed (σ = 1 px) before. Values are gray levels per pixel, 0 on edges and where nothing
/// changes.
pub fn harris(image: &Image, radius_px: usize) -> Image {
    let Gradient { x, y } = gradient(image);
    // the window reaches three standard deviations
    let mean_product = |a: &Image, b: &Image| {
        let products = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a * b).collect();
        smoothed(&Image::new(image.width(), image.height(), products), radius_px as f32 / 3.0)
    };
    let (mut map, yy, xy) = (mean_product(&x, &x), mean_product(&y, &y), mean_product(&x, &y));
    for ((xx, &yy), &xy) in map.pixels_mut().iter_mut().zip(yy.pixels()).zip(xy.pixels()) {
        let (determinant, trace) = (*xx * yy - xy * xy, *xx + yy);
        *xx = (determinant - EDGE * trace * trace).max(0.0).sqrt().sqrt();
    }
    map
}

#[cfg(test)]
mod tests {
    use super::super::interest_points;
    use super::*;

    /// Bright above and left of (30, 20).
    fn corner(bright: f32) -> Image {
        smoothed(&Image::from_fn(61, 51, |x, y| if x <= 30 && y <= 20 { bright } else { 50.0 }), 1.0)
    }

    #[test]
    fn a_corner_is_the_one_point() {
        for radius_px in 3..=12 {
            let points = interest_points(&harris(&corner(200.0), radius_px));
            assert_eq!(points.len(), 1, "radius {radius_px}");
            let off = (points[0].x_px - 30.5).hypot(points[0].y_px - 20.5);
            assert!(off < 1.0 + 0.5 * radius_px as f32, "radius {radius_px}: {:?}", points[0]);
        }
    }

    #[test]
    fn twice_the_contrast_is_twice_the_salience() {
        let salience = |bright| interest_points(&harris(&corner(bright), 6))[0].salience;
        assert!((salience(150.0) / salience(100.0) - 2.0).abs() < 1e-3);
    }

    #[test]
    fn an_edge_has_no_points() {
        for degrees in [0.0_f32, 10.0, 30.0, 45.0, 90.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let edge = Image::from_fn(60, 60, |x, y| {
                let across = (x as f32 - 30.0) * cos + (y as f32 - 30.0) * sin;
                255.0 * (across + 0.5).clamp(0.0, 1.0)
            });
            let map = harris(&smoothed(&edge, 1.0), 6);
            // at its border the picture is mirrored, and the edge broken
            let inside = (10..50).all(|y| (10..50).all(|x| map.at(x, y) == 0.0));
            assert!(inside, "{degrees}°");
        }
    }

    #[test]
    fn a_quarter_turn_turns_the_map() {
        let image = Image::from_fn(23, 17, |x, y| ((x * x * 7 + y * 31 + x * y) % 251) as f32);
        let turned = Image::from_fn(17, 23, |x, y| image.at(y, 16 - x));
        let (map, of_turned) = (harris(&image, 6), harris(&turned, 6));
        let highest = map.pixels().iter().fold(0.0f32, |m, &v| m.max(v));
        assert!(highest > 1.0);
        for (x, y) in (0..23).flat_map(|x| (0..17).map(move |y| (x, y))) {
            assert!((map.at(x, y) - of_turned.at(16 - y, x)).abs() < 1e-2 * highest, "({x}, {y})");
        }
    }

    #[test]
    fn flat_and_tiny_pictures_have_no_points_at_any_radius() {
        for (width, height) in [(0, 0), (0, 5), (5, 0), (1, 1), (2, 1), (1, 9), (300, 1), (20, 20)] {
            let flat = Image::from_fn(width, height, |_, _| 255.0);
            for radius_px in 1..=16 {
                let map = harris(&smoothed(&flat, 1.0), radius_px);
                assert_eq!((map.width(), map.height()), (width, height));
                assert!(interest_points(&map).is_empty(), "{width}×{height}, radius {radius_px}");
            }
        }
    }
}
