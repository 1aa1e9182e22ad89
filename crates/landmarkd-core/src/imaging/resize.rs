//! Fitting a plane into another size.

use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Luma};

use super::Image;

const BRIGHTEST: f32 = 255.0;

/// The image, of gray levels 0..=255, scaled to fit into `width_px` × `height_px`, as large as it can be, centred on
/// black. Area-weighted where it shrinks, linear where it grows.
pub fn fitted(image: &Image, width_px: usize, height_px: usize) -> Image {
    if (image.width(), image.height()) == (width_px, height_px) {
        return image.clone();
    }
    let mut canvas = Image::from_fn(width_px, height_px, |_, _| 0.0);
    if image.pixels().is_empty() || canvas.pixels().is_empty() {
        return canvas;
    }
    let scale = (width_px as f64 / image.width() as f64).min(height_px as f64 / image.height() as f64);
    let side = |length: usize, most: usize| ((length as f64 * scale).round() as usize).clamp(1, most);
    let (width, height) = (side(image.width(), width_px), side(image.height(), height_px));
    // the library's gray levels of this type are 0..=1, and others are cut off
    let levels: Vec<f32> = image.pixels().iter().map(|v| v / BRIGHTEST).collect();
    let plane: ImageBuffer<Luma<f32>, _> =
        ImageBuffer::from_raw(image.width() as u32, image.height() as u32, levels)
            .expect("an image holds width × height pixels");
    let scaled = resize(&plane, width as u32, height as u32, FilterType::Triangle);
    let (left, top) = ((width_px - width) / 2, (height_px - height) / 2);
    for (y, row) in scaled.as_raw().chunks_exact(width).enumerate() {
        let pixels = &mut canvas.pixels_mut()[(top + y) * width_px + left..][..width];
        pixels.iter_mut().zip(row).for_each(|(pixel, v)| *pixel = v * BRIGHTEST);
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_picture_stands_between_black_bars() {
        let wide = Image::from_fn(40, 20, |_, _| 80.0);
        let fitted = fitted(&wide, 20, 20);
        assert_eq!((fitted.width(), fitted.height()), (20, 20));
        assert!(fitted.row(4).iter().all(|&v| v == 0.0) && fitted.row(15).iter().all(|&v| v == 0.0));
        assert!(fitted.row(5).iter().chain(fitted.row(14)).all(|&v| (v - 80.0).abs() < 1e-3));
    }

    #[test]
    fn shrinking_keeps_the_mean_and_growing_the_order() {
        let fine = Image::from_fn(64, 64, |x, y| if (x + y) % 2 == 0 { 200.0 } else { 0.0 });
        let small = fitted(&fine, 16, 16);
        assert!(small.pixels().iter().all(|&v| (v - 100.0).abs() < 5.0));
        let ramp = Image::from_fn(10, 10, |x, _| x as f32);
        assert_eq!(fitted(&ramp, 10, 10), ramp);
        assert!(fitted(&ramp, 40, 40).row(20).is_sorted());
    }
}
