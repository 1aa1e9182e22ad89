//! PNG out: 8-bit gray, 8-bit colour, 16-bit gray.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// A PNG of interleaved bytes r, g, b, row-major.
///
/// # Panics
/// If `pixels` does not hold `3 * width * height` bytes, or a side is 0.
pub fn png_rgb8(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    png(width, height, pixels, ExtendedColorType::Rgb8)
}

/// A PNG of gray levels, one byte each, row-major.
///
/// # Panics
/// If `pixels` does not hold `width * height` bytes, or a side is 0.
pub fn png_gray8(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    png(width, height, pixels, ExtendedColorType::L8)
}

/// A PNG of 16-bit gray levels, row-major.
///
/// # Panics
/// If `pixels` does not hold `width * height` values, or a side is 0.
pub fn png_gray16(width: usize, height: usize, pixels: &[u16]) -> Vec<u8> {
    // The encoder takes samples in the machine's byte order.
    let bytes: Vec<u8> = pixels.iter().flat_map(|level| level.to_ne_bytes()).collect();
    png(width, height, &bytes, ExtendedColorType::L16)
}

/// The finest step of [`png_distances`], in mm.
const FINEST_STEP_MM: f64 = 0.1;

/// A 16-bit PNG of distances in mm, row-major, and its step in mm: distance = gray level × step, 0 = unknown (NaN).
///
/// The step is 0.1 mm if the largest distance fits, else the least of 1, 10, … mm with which it does.
///
/// # Panics
/// As [`png_gray16`].
pub fn png_distances(width: usize, height: usize, distances_mm: &[f32]) -> (Vec<u8>, f64) {
    let known = distances_mm.iter().copied().filter(|v| v.is_finite());
    let largest_mm = f64::from(known.fold(0.0, f32::max));
    let steps_mm = std::iter::successors(Some(FINEST_STEP_MM), |step| Some((step * 10.0).round()));
    let fits = |step_mm: &f64| (largest_mm / step_mm).round() <= f64::from(u16::MAX);
    let step_mm = steps_mm.take(40).find(fits).expect("no f32 exceeds 65535 × 10³⁸");
    // A distance is never written as unknown.
    let level = |mm: &f32| match mm.is_finite() {
        true => (f64::from(*mm) / step_mm).round().max(1.0) as u16,
        false => 0,
    };
    let levels: Vec<u16> = distances_mm.iter().map(level).collect();
    (png_gray16(width, height, &levels), step_mm)
}

fn png(width: usize, height: usize, pixels: &[u8], colour: ExtendedColorType) -> Vec<u8> {
    let side = |v: usize| u32::try_from(v).expect("a side fits 32 bits");
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(pixels, side(width), side(height), colour)
        .expect("memory takes every byte of a well-formed picture");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::{DecodeLimits, Image, decode, read_header};

    #[test]
    fn what_is_written_is_read_back() {
        let gray = decode(&png_gray8(3, 1, &[0, 128, 255]), &DecodeLimits::default()).unwrap();
        assert_eq!(gray.luminance, Image::new(3, 1, vec![0.0, 128.0, 255.0]));
        assert!(!gray.is_colour());
        let pixels = [1, 2, 3, 250, 251, 252];
        let colour = decode(&png_rgb8(1, 2, &pixels), &DecodeLimits::default()).unwrap();
        assert_eq!(colour.to_rgb8(), pixels);
    }

    #[test]
    fn sixteen_bits_are_read_back_with_their_fraction() {
        let png = png_gray16(2, 2, &[0, 1, 257, 65535]);
        let frame = decode(&png, &DecodeLimits::default()).unwrap();
        assert_eq!(frame.luminance, Image::new(2, 2, vec![0.0, 1.0 / 257.0, 1.0, 255.0]));
        assert_eq!(read_header(&png, &DecodeLimits::default()).unwrap().bits, 16);
    }

    #[test]
    fn distances_take_the_finest_step_that_holds_the_largest() {
        for (largest_mm, step_mm) in [(6553.5, 0.1), (6553.6, 1.0), (65535.0, 1.0), (65536.0, 10.0)] {
            let (png, step) = png_distances(3, 1, &[largest_mm, f32::NAN, 1e-9]);
            assert_eq!(step, step_mm, "{largest_mm}");
            let read = decode(&png, &DecodeLimits::default()).unwrap();
            let levels: Vec<f64> =
                read.luminance.pixels().iter().map(|v| (f64::from(*v) * 257.0).round()).collect();
            assert_eq!(levels[1..], [0.0, 1.0]);
            assert!((levels[0] * step - f64::from(largest_mm)).abs() <= 0.5 * step, "{levels:?}");
        }
        assert_eq!(png_distances(1, 1, &[f32::NAN]).1, 0.1);
        assert!(png_distances(1, 1, &[f32::MAX]).1 >= 1e33);
    }
}
