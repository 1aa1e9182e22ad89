//! A decoded picture: its luminance, and its red, green and blue planes if the file is in colour.
//!
//! All planes have one size and hold gray levels 0..=255. Luminance is 0.299 r + 0.587 g + 0.114 b.

use std::borrow::Cow;

use pulp::{Arch, Simd, WithSimd};

use super::reduction::{Reduction, reduced_size};
use super::{Image, bilinear_zero_padded, resampled};

/// What a camera saw: luminance always, the three colours if the file had them.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Luminance, the plane that interest points and gray signatures are taken from.
    pub luminance: Image,
    /// Red, green, blue; `None` for a gray file.
    pub rgb: Option<[Image; 3]>,
    /// Pixels of the posted picture for each pixel of this frame, along either side: 1 unless it was decoded at, or
    /// brought to, a smaller size.
    pub reduction: f32,
}

impl Frame {
    /// A frame without colour.
    pub fn gray(luminance: Image) -> Frame {
        Frame { luminance, rgb: None, reduction: 1.0 }
    }

    /// A colour frame from three planes of one size.
    ///
    /// # Panics
    /// If the planes differ in size.
    pub fn colour(rgb: [Image; 3]) -> Frame {
        let [red, green, blue] = &rgb;
        let (width, height) = (red.width(), red.height());
        assert!(
            rgb.iter().all(|plane| (plane.width(), plane.height()) == (width, height)),
            "planes of one size"
        );
        let luminance = red
            .pixels()
            .iter()
            .zip(green.pixels())
            .zip(blue.pixels())
            .map(|((r, g), b)| 0.299 * r + 0.587 * g + 0.114 * b)
            .collect();
        Frame { luminance: Image::new(width, height, luminance), rgb: Some(rgb), reduction: 1.0 }
    }

    /// A colour frame from interleaved bytes r, g, b, row-major.
    ///
    /// # Panics
    /// If `bytes` does not hold `3 * width * height` bytes.
    pub fn from_rgb8(width: usize, height: usize, bytes: &[u8]) -> Frame {
        assert_eq!(bytes.len(), 3 * width * height, "three bytes a pixel");
        Frame::colour([0, 1, 2].map(|channel| {
            Image::new(width, height, bytes.iter().skip(channel).step_by(3).map(|&v| f32::from(v)).collect())
        }))
    }

    /// The frame enlarged by `factor` ≥ 1, bilinear.
    pub fn enlarged(&self, factor: f64) -> Frame {
        let [width, height] =
            [self.width(), self.height()].map(|side| (side as f64 * factor).round() as usize);
        let enlarged = |image: &Image| resampled(image, width, height);
        Frame {
            luminance: enlarged(&self.luminance),
            rgb: self.rgb.as_ref().map(|planes| planes.each_ref().map(enlarged)),
            reduction: self.reduction / factor as f32,
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.luminance.width()
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.luminance.height()
    }

    /// Whether the file had colour.
    pub fn is_colour(&self) -> bool {
        self.rgb.is_some()
    }

    /// The two opponent planes r − g and b − (r + g)/2, −255..=255; zero everywhere for a gray frame.
    pub fn opponent_planes(&self) -> [Image; 2] {
        let (width, height) = (self.width(), self.height());
        let Some([red, green, blue]) = &self.rgb else {
            return [(); 2].map(|()| Image::from_fn(width, height, |_, _| 0.0));
        };
        let red_green = red.pixels().iter().zip(green.pixels()).map(|(r, g)| r - g).collect();
        let blue_yellow = (red.pixels().iter().zip(green.pixels()).zip(blue.pixels()))
            .map(|((r, g), b)| b - (r + g) / 2.0)
            .collect();
        [Image::new(width, height, red_green), Image::new(width, height, blue_yellow)]
    }

    /// The opponent planes at half of the frame's size, rounded up: each pixel is the mean of four. Zero everywhere for a
    /// gray frame.
    pub fn half_opponent_planes(&self) -> [Image; 2] {
        let (width, height) = (self.width().div_ceil(2), self.height().div_ceil(2));
        let mut planes = [(); 2].map(|()| vec![0.0; width * height]);
        if let Some(rgb) = &self.rgb {
            let [red_green, blue_yellow] = &mut planes;
            let out =
                red_green.chunks_exact_mut(width.max(1)).zip(blue_yellow.chunks_exact_mut(width.max(1)));
            for (v, (red_green, blue_yellow)) in out.enumerate() {
                let below = (2 * v + 1).min(self.height() - 1);
                let rows = rgb.each_ref().map(|plane| [plane.row(2 * v), plane.row(below)]);
                Arch::new().dispatch(HalfOpponents { rows, red_green, blue_yellow });
            }
        }
        planes.map(|pixels| Image::new(width, height, pixels))
    }

    /// The frame as interleaved bytes r, g, b, rounded and held within 0..=255; gray gives r = g = b.
    pub fn to_rgb8(&self) -> Vec<u8> {
        let byte = |v: f32| v.round().clamp(0.0, 255.0) as u8;
        match &self.rgb {
            None => self.luminance.pixels().iter().flat_map(|&v| [byte(v); 3]).collect(),
            Some([red, green, blue]) => (red.pixels().iter().zip(green.pixels()).zip(blue.pixels()))
                .flat_map(|((&r, &g), &b)| [byte(r), byte(g), byte(b)])
                .collect(),
        }
    }

    /// The frame turned about its centre, of the same size, bilinear, black outside.
    ///
    /// A positive rotation turns x towards y: clockwise as seen on a screen.
    pub fn turned(&self, rotation_deg: f64) -> Frame {
        Frame {
            luminance: turned(&self.luminance, rotation_deg),
            rgb: self.rgb.as_ref().map(|planes| planes.each_ref().map(|plane| turned(plane, rotation_deg))),
            reduction: self.reduction,
        }
    }

    /// The frame brought down so that its longer side is `longer_side_px` (1 at least), the other one rounded; the same
    /// frame if it is not longer.
    ///
    /// Each pixel is the mean of the area that it covers: pixel u stands at (u + 0.5) k − 0.5 of this frame, with k the
    /// old length of the side over the new one. [`Frame::reduction`] grows by the k of the longer side; that of the
    /// other side differs by what its length is rounded by, half a pixel at the far end at most.
    pub fn at_most(&self, longer_side_px: usize) -> Cow<'_, Frame> {
        let (width, height) = (self.width(), self.height());
        let Some(to) = reduced_size(width, height, longer_side_px) else { return Cow::Borrowed(self) };
        let reduction = Reduction::new(width as f64, height as f64, to);
        let frame = match &self.rgb {
            Some(rgb) => Frame::colour(rgb.each_ref().map(|plane| reduction.image(plane))),
            None => Frame::gray(reduction.image(&self.luminance)),
        };
        let factor = width.max(height) as f32 / to.0.max(to.1) as f32;
        Cow::Owned(Frame { reduction: self.reduction * factor, ..frame })
    }
}

/// Two rows of red, green and blue to one of each opponent plane.
struct HalfOpponents<'a> {
    rows: [[&'a [f32]; 2]; 3],
    red_green: &'a mut [f32],
    blue_yellow: &'a mut [f32],
}

impl WithSimd for HalfOpponents<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let [red, green, blue] = self.rows;
        let ((r, last_r), (r_below, last_r_below)) = (red[0].as_chunks::<2>(), red[1].as_chunks::<2>());
        let ((g, last_g), (g_below, last_g_below)) = (green[0].as_chunks::<2>(), green[1].as_chunks::<2>());
        let ((b, last_b), (b_below, last_b_below)) = (blue[0].as_chunks::<2>(), blue[1].as_chunks::<2>());
        let whole = r.len();
        let (r, g, b) = (&r[..whole], &g[..whole], &b[..whole]);
        let (r_below, g_below, b_below) = (&r_below[..whole], &g_below[..whole], &b_below[..whole]);
        let (red_green, last_red_green) = self.red_green.split_at_mut(whole);
        let (blue_yellow, last_blue_yellow) = self.blue_yellow.split_at_mut(whole);
        for u in 0..whole {
            let r = 0.25 * ((r[u][0] + r[u][1]) + (r_below[u][0] + r_below[u][1]));
            let g = 0.25 * ((g[u][0] + g[u][1]) + (g_below[u][0] + g_below[u][1]));
            let b = 0.25 * ((b[u][0] + b[u][1]) + (b_below[u][0] + b_below[u][1]));
            red_green[u] = r - g;
            blue_yellow[u] = b - (r + g) / 2.0;
        }
        // the last column of an odd number by itself
        if let ([r], [g], [b], [r_below], [g_below], [b_below]) =
            (last_r, last_g, last_b, last_r_below, last_g_below, last_b_below)
        {
            let (r, g, b) = (0.5 * (r + r_below), 0.5 * (g + g_below), 0.5 * (b + b_below));
            last_red_green[0] = r - g;
            last_blue_yellow[0] = b - (r + g) / 2.0;
        }
    }
}

/// Each pixel p takes the value that stood at R(−a)(p − c) + c.
fn turned(image: &Image, rotation_deg: f64) -> Image {
    let (width, height) = (image.width(), image.height());
    let (sin, cos) = rotation_deg.to_radians().sin_cos();
    let (centre_x, centre_y) = ((width as f64 - 1.0) / 2.0, (height as f64 - 1.0) / 2.0);
    Image::from_fn(width, height, |x, y| {
        let (dx, dy) = (x as f64 - centre_x, y as f64 - centre_y);
        let (from_x, from_y) = (centre_x + cos * dx + sin * dy, centre_y - sin * dx + cos * dy);
        bilinear_zero_padded(image, from_x, from_y) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_brings_x_to_y() {
        let picture = Image::new(3, 3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        let turned = Frame::gray(picture).turned(90.0);
        // clockwise on the screen: the left column, read upwards, becomes the top row
        let expected = [7.0, 4.0, 1.0, 8.0, 5.0, 2.0, 9.0, 6.0, 3.0];
        for (value, expected) in turned.luminance.pixels().iter().zip(expected) {
            assert!((value - expected).abs() < 1e-5, "{turned:?}");
        }
    }

    #[test]
    fn outside_is_black() {
        let turned = Frame::gray(Image::from_fn(9, 9, |_, _| 200.0)).turned(45.0);
        assert_eq!(turned.luminance.at(0, 0), 0.0);
        assert!((turned.luminance.at(4, 4) - 200.0).abs() < 1e-3);
    }

    #[test]
    fn colour_bytes_come_back_as_they_went_in() {
        let bytes = [255, 0, 10, 20, 30, 40];
        let frame = Frame::from_rgb8(2, 1, &bytes);
        assert_eq!(frame.to_rgb8(), bytes);
        assert!((frame.luminance.at(0, 0) - (0.299 * 255.0 + 0.114 * 10.0)).abs() < 1e-3);
        let [red_green, blue_yellow] = frame.opponent_planes();
        assert_eq!(red_green.pixels(), [255.0, -10.0]);
        assert_eq!(blue_yellow.pixels(), [-117.5, 15.0]);
    }

    #[test]
    fn half_opponent_planes_are_means_of_the_whole_ones() {
        for (width, height) in [(1, 1), (5, 4), (6, 3), (31, 17)] {
            let bytes: Vec<u8> = (0..width * height * 3).map(|i| (i * 31 % 256) as u8).collect();
            let frame = Frame::from_rgb8(width, height, &bytes);
            for (half, whole) in frame.half_opponent_planes().iter().zip(frame.opponent_planes()) {
                assert_eq!((half.width(), half.height()), (width.div_ceil(2), height.div_ceil(2)));
                for (u, v) in (0..half.width()).flat_map(|u| (0..half.height()).map(move |v| (u, v))) {
                    let at = |dx: usize, dy: usize| {
                        whole.at((2 * u + dx).min(width - 1), (2 * v + dy).min(height - 1))
                    };
                    let mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0;
                    assert!((half.at(u, v) - mean).abs() < 1e-3, "{width}×{height}: ({u}, {v})");
                }
            }
        }
        let gray = Frame::gray(Image::from_fn(4, 4, |_, _| 9.0));
        assert!(gray.half_opponent_planes().iter().all(|plane| plane.pixels() == [0.0; 4]));
    }

    #[test]
    fn a_smaller_frame_tells_by_how_much() {
        let bytes: Vec<u8> = (0..60 * 40 * 3).map(|i| (i * 31 % 256) as u8).collect();
        let frame = Frame::from_rgb8(60, 40, &bytes);
        assert!(matches!(frame.at_most(60), Cow::Borrowed(_)));
        let half = frame.at_most(30).into_owned();
        assert_eq!((half.width(), half.height(), half.reduction), (30, 20, 2.0));
        assert_eq!(half.at_most(10).reduction, 6.0);
        assert_eq!(half.turned(30.0).reduction, 2.0);
        // luminance is linear in the colours
        let gray = Frame::gray(frame.luminance.clone()).at_most(30).into_owned();
        assert!(!gray.is_colour());
        for (a, b) in gray.luminance.pixels().iter().zip(half.luminance.pixels()) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
        assert_eq!(Frame::gray(Image::from_fn(100, 300, |_, _| 1.0)).at_most(120).reduction, 2.5);
    }

    #[test]
    fn a_gray_frame_has_no_colour() {
        let frame = Frame::gray(Image::from_fn(2, 2, |x, _| x as f32));
        assert!(!frame.is_colour());
        assert!(frame.opponent_planes().iter().all(|plane| plane.pixels() == [0.0; 4]));
    }
}
