//! PNG out: 8-bit gray and 8-bit colour.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// A PNG of interleaved bytes r, g, b, row-major.
///
/// # Panics
/// If `pixels` does not hold `3 * width * height` bytes, or a side is 0.
pub fn png_rgb8(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    png(width, height, pixels, ExtendedColorType::Rgb8)
}

/// A PNG of grey levels, one byte each, row-major.
///
/// # Panics
/// If `pixels` does not hold `width * height` bytes, or a side is 0.
pub fn png_gray8(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    png(width, height, pixels, ExtendedColorType::L8)
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
    use crate::imaging::{DecodeLimits, Image, decode};

    #[test]
    fn what_is_written_is_read_back() {
        let gray = decode(&png_gray8(3, 1, &[0, 128, 255]), &DecodeLimits::default()).unwrap();
        assert_eq!(gray.luminance, Image::new(3, 1, vec![0.0, 128.0, 255.0]));
        assert!(!gray.is_colour());
        let pixels = [1, 2, 3, 250, 251, 252];
        let colour = decode(&png_rgb8(1, 2, &pixels), &DecodeLimits::default()).unwrap();
        assert_eq!(colour.to_rgb8(), pixels);
    }
}
