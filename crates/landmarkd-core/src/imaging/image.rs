//! The image type: one plane of `f32`, row-major, gray levels 0..=255 (differences may be negative).

use crate::statistics::median;

/// One plane of pixels, row-major: the pixel (x, y) stands at `y * width + x`.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<f32>,
}

impl Image {
    /// An image of `width` × `height` pixels over the given values.
    ///
    /// # Panics
    /// If `pixels` does not hold exactly `width * height` values: that is a fault of the program, never
    /// of its input.
    pub fn new(width: usize, height: usize, pixels: Vec<f32>) -> Image {
        assert_eq!(pixels.len(), width * height, "an image of {width}×{height} holds width × height pixels");
        Image { width, height, pixels }
    }

    /// An image whose pixel (x, y) is `f(x, y)`, computed in row-major order.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> f32) -> Image {
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            pixels.extend((0..width).map(|x| f(x, y)));
        }
        Image { width, height, pixels }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row-major.
    pub fn pixels(&self) -> &[f32] {
        &self.pixels
    }

    /// All pixels as bytes, row-major, rounded and held within 0..=255.
    pub fn to_gray8(&self) -> Vec<u8> {
        self.pixels.iter().map(|v| v.round().clamp(0.0, 255.0) as u8).collect()
    }

    /// The mean of all pixels; 0 for an image without any.
    pub fn mean(&self) -> f64 {
        self.pixels.iter().map(|&v| f64::from(v)).sum::<f64>() / self.pixels.len().max(1) as f64
    }

    /// All pixels, row-major, to be written.
    pub fn pixels_mut(&mut self) -> &mut [f32] {
        &mut self.pixels
    }

    /// The part of `width` × `height` pixels whose top left pixel is (`left`, `top`).
    pub fn cropped(&self, left: usize, top: usize, width: usize, height: usize) -> Image {
        Image::from_fn(width, height, |x, y| self.at(left + x, top + y))
    }

    /// The middle part, of at most `side_px` a side.
    pub fn middle(&self, side_px: usize) -> Image {
        let (width, height) = (self.width.min(side_px), self.height.min(side_px));
        self.cropped((self.width - width) / 2, (self.height - height) / 2, width, height)
    }

    /// Indices of the pixels at the border, each once, ascending.
    pub fn border(&self) -> impl Iterator<Item = usize> + use<> {
        let (width, height) = (self.width, self.height);
        (0..width * height).filter(move |at| {
            let (x, y) = (at % width, at / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        })
    }

    /// The upper median of the pixels at the border; 0 for an image without any.
    pub fn border_median(&self) -> f32 {
        let mut values: Vec<f32> = self.border().map(|at| self.pixels[at]).collect();
        median(&mut values, f32::total_cmp).unwrap_or(0.0)
    }

    /// The pixels of row `y`.
    pub fn row(&self, y: usize) -> &[f32] {
        &self.pixels[y * self.width..(y + 1) * self.width]
    }

    /// The pixel in column `x` of row `y`.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        assert!(x < self.width, "column {x} of an image {} wide", self.width);
        self.pixels[y * self.width + x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_row_major() {
        let image = Image::from_fn(3, 2, |x, y| (10 * y + x) as f32);
        assert_eq!(image.pixels(), [0.0, 1.0, 2.0, 10.0, 11.0, 12.0]);
        assert_eq!(image.row(1), [10.0, 11.0, 12.0]);
        assert_eq!(image.at(2, 1), 12.0);
    }

    #[test]
    fn bytes_are_rounded_and_held_in_their_range() {
        let image = Image::new(5, 1, vec![-3.0, 0.4, 127.5, 300.0, f32::NAN]);
        assert_eq!(image.to_gray8(), [0, 0, 128, 255, 0]);
    }

    #[test]
    fn the_mean_is_that_of_all_pixels() {
        assert_eq!(Image::new(2, 2, vec![1.0, 2.0, 3.0, 5.0]).mean(), 2.75);
        assert_eq!(Image::new(0, 0, vec![]).mean(), 0.0);
    }

    #[test]
    fn the_border_is_what_has_no_neighbour_on_a_side() {
        let image = Image::new(4, 3, vec![9.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 5.0, 6.0, 7.0, 8.0, 10.0]);
        assert_eq!(image.border().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 7, 8, 9, 10, 11]);
        assert_eq!(image.border_median(), 6.0);
        assert_eq!(Image::new(0, 0, vec![]).border_median(), 0.0);
    }

    #[test]
    #[should_panic(expected = "holds width × height pixels")]
    fn a_wrong_number_of_pixels_is_refused() {
        Image::new(2, 2, vec![0.0; 3]);
    }
}
