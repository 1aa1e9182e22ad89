//! Evidence drawn on the frame: circles, lines and words for a person to look at.
//!
//! Coordinates are those of the frame (x right, y down, pixel centres at whole numbers), also where a
//! small frame is enlarged so that words are legible.

use embedded_graphics::mono_font::iso_8859_1::{FONT_6X10, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyleBuilder};
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, Line, PrimitiveStyle};
use embedded_graphics::text::{Baseline, Text};

use super::canvas::{Canvas, rgb};
use super::{Frame, encode};

/// Below this width a frame is enlarged: some 50 letters of the small font side by side.
const LEGIBLE_WIDTH_PX: usize = 320;
/// No frame is enlarged by more than this.
const MAX_ENLARGEMENT: usize = 8;
/// From this width on the large font and thick strokes are used.
const LARGE_WIDTH_PX: usize = 1000;
/// Drawing coordinates are held within ±this: four times the largest side that is decoded by default,
/// and far from where 32-bit arithmetic on them overflows.
const MAX_COORDINATE_PX: f32 = 32_768.0;

/// A picture of the frame, being drawn on.
pub struct Overlay {
    canvas: Canvas,
    enlargement: usize,
    font: &'static MonoFont<'static>,
    stroke_px: u32,
}

impl Overlay {
    /// Starts from the frame itself; one narrower than 320 px is enlarged by a whole factor, 8 at most.
    pub fn on(frame: &Frame) -> Overlay {
        let enlargement = LEGIBLE_WIDTH_PX.div_ceil(frame.width().max(1)).clamp(1, MAX_ENLARGEMENT);
        let (width, height) = (frame.width() * enlargement, frame.height() * enlargement);
        let ground = frame.to_rgb8();
        let mut pixels = Vec::with_capacity(3 * width * height);
        for row in ground.chunks_exact(3 * frame.width().max(1)) {
            let start = pixels.len();
            pixels
                .extend(row.chunks_exact(3).flat_map(|rgb| std::iter::repeat_n(rgb, enlargement)).flatten());
            let end = pixels.len();
            for _ in 1..enlargement {
                pixels.extend_from_within(start..end);
            }
        }
        let large = width >= LARGE_WIDTH_PX;
        Overlay {
            canvas: Canvas { width, height, pixels },
            enlargement,
            font: if large { &FONT_10X20 } else { &FONT_6X10 },
            stroke_px: if large { 2 } else { 1 },
        }
    }

    /// A circle about (x, y). Nothing is drawn where a number is not finite.
    pub fn circle(&mut self, x_px: f32, y_px: f32, radius_px: f32, colour: [u8; 3]) {
        let (Some(centre), true) = (self.place(x_px, y_px), radius_px.is_finite()) else { return };
        let reach = (self.canvas.width + self.canvas.height) as f32;
        let diameter = (2.0 * radius_px * self.enlargement as f32).clamp(1.0, reach) as u32;
        Circle::with_center(centre, diameter)
            .into_styled(PrimitiveStyle::with_stroke(rgb(colour), self.stroke_px))
            .draw(&mut self.canvas)
            .unwrap_or_else(|never| match never {});
    }

    /// A straight line between two points. Nothing is drawn where a number is not finite.
    pub fn line(&mut self, from_x_px: f32, from_y_px: f32, to_x_px: f32, to_y_px: f32, colour: [u8; 3]) {
        let (Some(from), Some(to)) = (self.place(from_x_px, from_y_px), self.place(to_x_px, to_y_px)) else {
            return;
        };
        // point by point: the library's strokes square lengths in 32 bits, too few for the longest lines
        let brush = 0..self.stroke_px as i32;
        for point in Line::new(from, to).points() {
            for offset in brush.clone().flat_map(|dy| brush.clone().map(move |dx| Point::new(dx, dy))) {
                self.canvas.put(point + offset, rgb(colour));
            }
        }
    }

    /// Distance between lines of text that don't touch, in pixels of the frame.
    pub fn line_height_px(&self) -> f32 {
        (self.font.character_size.height + 4) as f32 / self.enlargement as f32
    }

    /// Words with their top-left corner at (x, y), on a dark backing so that they are readable on any
    /// ground, moved inwards where they would leave the frame. Letters outside Latin-1 become `?`.
    pub fn text(&mut self, x_px: f32, y_px: f32, words: &str, colour: [u8; 3]) {
        let Some(place) = self.place(x_px, y_px) else { return };
        let letter = self.font.character_size;
        let lines = words.lines().count().max(1) as i32;
        let longest = words.lines().map(|line| line.chars().count()).max().unwrap_or(0) as i32;
        let held = |at: i32, size: i32, room: usize| at.min(room as i32 - size).max(0);
        let corner = Point::new(
            held(place.x, longest.saturating_mul(letter.width as i32), self.canvas.width),
            held(place.y, lines.saturating_mul(letter.height as i32), self.canvas.height),
        );
        let style = MonoTextStyleBuilder::new()
            .font(self.font)
            .text_color(rgb(colour))
            .background_color(Rgb888::new(16, 16, 16))
            .build();
        Text::with_baseline(words, corner, style, Baseline::Top)
            .draw(&mut self.canvas)
            .unwrap_or_else(|never| match never {});
    }

    /// The picture as a colour PNG.
    pub fn into_png(self) -> Vec<u8> {
        encode::png_rgb8(self.canvas.width, self.canvas.height, &self.canvas.pixels)
    }

    /// The middle of the enlarged pixel.
    fn place(&self, x_px: f32, y_px: f32) -> Option<Point> {
        let scaled = |v: f32| {
            let at = (v + 0.5) * self.enlargement as f32 - 0.5;
            at.round().clamp(-MAX_COORDINATE_PX, MAX_COORDINATE_PX) as i32
        };
        (x_px.is_finite() && y_px.is_finite()).then(|| Point::new(scaled(x_px), scaled(y_px)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::{DecodeLimits, Image, decode};

    fn drawn(frame: &Frame, draw: impl FnOnce(&mut Overlay)) -> Frame {
        let mut overlay = Overlay::on(frame);
        draw(&mut overlay);
        decode(&overlay.into_png(), &DecodeLimits::default()).unwrap()
    }

    fn black(width: usize, height: usize) -> Frame {
        Frame::gray(Image::from_fn(width, height, |_, _| 0.0))
    }

    #[test]
    fn a_small_frame_is_enlarged_by_a_whole_factor() {
        let frame = Frame::gray(Image::from_fn(100, 40, |x, y| ((x * 7 + y * 3) % 256) as f32));
        let picture = drawn(&frame, |_| ());
        assert_eq!((picture.width(), picture.height()), (400, 160));
        for (x, y) in [(0, 0), (3, 3), (4, 0), (399, 159), (201, 77)] {
            assert_eq!(picture.luminance.at(x, y).round(), frame.luminance.at(x / 4, y / 4), "({x}, {y})");
        }
    }

    #[test]
    fn a_circle_stands_about_its_frame_coordinates() {
        let picture = drawn(&black(160, 160), |overlay| overlay.circle(80.0, 40.0, 10.0, [0, 255, 0]));
        let lit = |x: f32, y: f32| {
            let (x, y) = ((2.0 * x) as usize, (2.0 * y) as usize);
            (x - 2..=x + 2).any(|x| (y - 2..=y + 2).any(|y| picture.luminance.at(x, y) > 100.0))
        };
        assert!(lit(90.0, 40.0) && lit(70.0, 40.0) && lit(80.0, 50.0) && lit(80.0, 30.0));
        assert!(!lit(80.0, 40.0));
    }

    #[test]
    fn words_are_readable_on_white_and_stay_inside() {
        let white = Frame::gray(Image::from_fn(320, 40, |_, _| 255.0));
        let picture = drawn(&white, |overlay| overlay.text(315.0, 38.0, "kitchen", [255, 255, 0]));
        let dark = picture.luminance.pixels().iter().filter(|&&v| v < 32.0).count();
        assert!(dark > 7 * 6 * 10 / 2, "{dark} px of backing");
        let bright_yellow = picture.to_rgb8().chunks_exact(3).filter(|rgb| *rgb == [255, 255, 0]).count();
        assert!(bright_yellow > 60, "{bright_yellow} px of letters");
    }

    #[test]
    fn no_coordinate_breaks_it() {
        for frame in [black(1, 1), black(1, 900), black(2000, 3)] {
            drawn(&frame, |overlay| {
                for v in [f32::NAN, f32::INFINITY, f32::MIN, f32::MAX, -1.0, 0.0, 1e9] {
                    overlay.circle(v, 0.0, 5.0, [255; 3]);
                    overlay.circle(0.0, 0.0, v, [255; 3]);
                    overlay.line(v, v, -v, 3.0, [255; 3]);
                    overlay.text(v, v, "a\nlong word — über", [255; 3]);
                }
            });
        }
    }
}
