//! Bilinear interpolation: the value of an image between its pixels, by three rules for its border.
//!
//! Each function is continuous inside and differs outside only; they also round differently, and pictures that are made
//! with one must stay the same to the last bit.

use pulp::{Arch, Simd, WithSimd};

use super::Image;

/// The value at (x, y); outside, the border is continued (OpenCV's `BORDER_REPLICATE`).
///
/// # Panics
/// If the image has no pixels.
pub fn bilinear_replicated(image: &Image, x_px: f64, y_px: f64) -> f64 {
    let (last_x, last_y) = (image.width() - 1, image.height() - 1);
    let (x, y) = (x_px.clamp(0.0, last_x as f64), y_px.clamp(0.0, last_y as f64));
    let (left, top) = (x as usize, y as usize);
    let (right, bottom) = ((left + 1).min(last_x), (top + 1).min(last_y));
    let (across, down) = (x - left as f64, y - top as f64);
    let at = |x, y| f64::from(image.at(x, y));
    let upper = at(left, top) + across * (at(right, top) - at(left, top));
    let lower = at(left, bottom) + across * (at(right, bottom) - at(left, bottom));
    upper + down * (lower - upper)
}

/// The value at (x, y) of an image that is surrounded by zeros (OpenCV's `BORDER_CONSTANT`).
pub fn bilinear_zero_padded(image: &Image, x_px: f64, y_px: f64) -> f64 {
    let (width, height) = (image.width() as f64, image.height() as f64);
    let pixel = |x: f64, y: f64| {
        let inside = x >= 0.0 && y >= 0.0 && x < width && y < height;
        if inside { f64::from(image.at(x as usize, y as usize)) } else { 0.0 }
    };
    let (left, top) = (x_px.floor(), y_px.floor());
    let (across, down) = (x_px - left, y_px - top);
    let upper = pixel(left, top) * (1.0 - across) + pixel(left + 1.0, top) * across;
    let lower = pixel(left, top + 1.0) * (1.0 - across) + pixel(left + 1.0, top + 1.0) * across;
    upper * (1.0 - down) + lower * down
}

/// The value at (x, y); 0 wherever one of the four neighbours is outside.
pub fn bilinear_inside(image: &Image, x_px: f64, y_px: f64) -> f32 {
    let (left, top) = (x_px.floor(), y_px.floor());
    if left < 0.0 || top < 0.0 || left + 1.0 >= image.width() as f64 || top + 1.0 >= image.height() as f64 {
        return 0.0;
    }
    let (across, down) = ((x_px - left) as f32, (y_px - top) as f32);
    let (left, top) = (left as usize, top as usize);
    let upper = image.at(left, top) * (1.0 - across) + image.at(left + 1, top) * across;
    let lower = image.at(left, top + 1) * (1.0 - across) + image.at(left + 1, top + 1) * across;
    upper * (1.0 - down) + lower * down
}

/// The image at `width` × `height` samples that divide it evenly, bilinear; the border is continued.
pub fn resampled(image: &Image, width: usize, height: usize) -> Image {
    let taps = |from: usize, to: usize| -> Vec<(usize, usize, f32)> {
        let ratio = from as f64 / to as f64;
        let tap = |u: usize| {
            let at = ((u as f64 + 0.5) * ratio - 0.5).clamp(0.0, from as f64 - 1.0);
            let low = at.floor() as usize;
            (low, (low + 1).min(from - 1), (at - low as f64) as f32)
        };
        (0..to).map(tap).collect()
    };
    let (columns, rows) = (taps(image.width(), width), taps(image.height(), height));
    let mut pixels = Vec::with_capacity(width * height);
    let mut between = vec![0.0; image.width()];
    for (above, below, down) in rows {
        Arch::new().dispatch(Between {
            above: image.row(above),
            below: image.row(below),
            down,
            out: &mut between,
        });
        pixels.extend(
            columns
                .iter()
                .map(|&(left, right, along)| between[left] + along * (between[right] - between[left])),
        );
    }
    Image::new(width, height, pixels)
}

/// A row between two others.
struct Between<'a> {
    above: &'a [f32],
    below: &'a [f32],
    down: f32,
    out: &'a mut [f32],
}

impl WithSimd for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for ((out, above), below) in self.out.iter_mut().zip(self.above).zip(self.below) {
            *out = above + self.down * (below - above);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Image {
        Image::new(3, 2, vec![1.0, 2.0, 4.0, 3.0, 6.0, 8.0])
    }

    #[test]
    fn between_pixels_all_agree() {
        for (x, y, expected) in [(0.5, 0.0, 1.5), (1.25, 0.5, 4.5), (0.0, 0.25, 1.5), (1.0, 0.75, 5.0)] {
            assert_eq!(bilinear_replicated(&picture(), x, y), expected);
            assert_eq!(bilinear_zero_padded(&picture(), x, y), expected);
            assert_eq!(f64::from(bilinear_inside(&picture(), x, y)), expected);
        }
    }

    #[test]
    fn at_the_border_they_differ() {
        for (x, y, replicated, padded, inside) in [
            (2.0, 1.0, 8.0, 8.0, 0.0),
            (2.5, 0.0, 4.0, 2.0, 0.0),
            (-0.5, 0.5, 2.0, 1.0, 0.0),
            (9.0, 9.0, 8.0, 0.0, 0.0),
        ] {
            assert_eq!(bilinear_replicated(&picture(), x, y), replicated, "({x}, {y})");
            assert_eq!(bilinear_zero_padded(&picture(), x, y), padded, "({x}, {y})");
            assert_eq!(bilinear_inside(&picture(), x, y), inside, "({x}, {y})");
        }
    }
}
