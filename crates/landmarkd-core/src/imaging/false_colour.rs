//! Distances in false colours, for people: near is red, far is blue (the map is Turbo, turned round), unknown is dark
//! gray. A colour bar below gives the scale in mm.

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::FONT_6X10;
use embedded_graphics::prelude::*;
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

use super::canvas::{Canvas, rgb};
use super::encode;
use crate::statistics::quantile_nearest;

/// What is not known.
const UNKNOWN: [u8; 3] = [48; 3];
/// Behind the bar and its numbers.
const GROUND: [u8; 3] = [16; 3];
const LETTERS: [u8; 3] = [224; 3];
/// The colours cover the distances between these quantiles, so that outliers don't stretch the scale.
const SPAN: [f64; 2] = [0.02, 0.98];
/// A narrower picture gets a margin on its right: the bar's numbers need room.
const LEAST_WIDTH_PX: usize = 200;
/// Height of the bar with its numbers.
const FOOT_PX: usize = 32;
/// From the foot's upper edge: the bar, its ticks, its numbers.
const BAR_PX: [usize; 2] = [4, 14];
const TICKS_TO_PX: usize = 18;
const NUMBERS_AT_PX: i32 = 20;
/// Between the ends of the bar and of the picture.
const MARGIN_PX: usize = 4;
/// Ticks on the bar, the ends among them: each quarter.
const TICKS: usize = 5;

/// A PNG of distances in mm, row-major, NaN where unknown, with a scale below.
///
/// # Panics
/// If there are not `width * height` distances, or a side is 0.
pub fn png_turbo(width: usize, height: usize, distances_mm: &[f32]) -> Vec<u8> {
    assert_eq!(distances_mm.len(), width * height, "one distance a pixel");
    let span = span(distances_mm);
    let mut canvas =
        Canvas { width: width.max(LEAST_WIDTH_PX), height: height + FOOT_PX, pixels: Vec::new() };
    for row in distances_mm.chunks_exact(width) {
        canvas.pixels.extend(row.iter().flat_map(|&mm| colour(mm, span)));
        canvas.pixels.extend(GROUND.repeat(canvas.width - width));
    }
    canvas.pixels.extend(GROUND.repeat(canvas.width * FOOT_PX));
    foot(&mut canvas, height, span);
    encode::png_rgb8(canvas.width, canvas.height, &canvas.pixels)
}

/// The least and the largest distance that have a colour of their own; none if none is known.
fn span(distances_mm: &[f32]) -> Option<[f32; 2]> {
    let mut known: Vec<f32> = distances_mm.iter().copied().filter(|mm| mm.is_finite()).collect();
    let [least, largest] = SPAN.map(|part| quantile_nearest(&mut known, part, f32::total_cmp));
    Some([least?, largest?])
}

/// The colour of a distance.
fn colour(mm: f32, span: Option<[f32; 2]>) -> [u8; 3] {
    let Some([least, largest]) = span.filter(|_| mm.is_finite()) else { return UNKNOWN };
    let part = if largest > least { (mm - least) / (largest - least) } else { 0.5 };
    turbo(part)
}

/// The colour of a part of the span: 0 is near, 1 far.
fn turbo(part: f32) -> [u8; 3] {
    let colorous::Color { r, g, b } = colorous::TURBO.eval_continuous(1.0 - f64::from(part).clamp(0.0, 1.0));
    [r, g, b]
}

/// The bar with ticks and numbers, below `top`.
fn foot(canvas: &mut Canvas, top: usize, span: Option<[f32; 2]>) {
    let (left, length) = (MARGIN_PX, canvas.width - 2 * MARGIN_PX - 1);
    let letters = MonoTextStyle::new(&FONT_6X10, rgb(LETTERS));
    let write = |canvas: &mut Canvas, x: usize, alignment: Alignment, words: &str| {
        let style = TextStyleBuilder::new().alignment(alignment).baseline(Baseline::Top).build();
        Text::with_text_style(words, Point::new(x as i32, top as i32 + NUMBERS_AT_PX), letters, style)
            .draw(canvas)
            .unwrap_or_else(|never| match never {});
    };
    let Some([least, largest]) = span else {
        return write(canvas, left, Alignment::Left, "no depth");
    };
    for at in 0..=length {
        let colour = rgb(turbo(at as f32 / length as f32));
        for y in BAR_PX[0]..BAR_PX[1] {
            canvas.put(Point::new((left + at) as i32, (top + y) as i32), colour);
        }
    }
    for tick in 0..TICKS {
        let x = left + length * tick / (TICKS - 1);
        for y in BAR_PX[1]..TICKS_TO_PX {
            canvas.put(Point::new(x as i32, (top + y) as i32), rgb(LETTERS));
        }
    }
    let digits = if largest - least < 20.0 { 1 } else { 0 };
    write(canvas, left, Alignment::Left, &format!("{least:.digits$} mm"));
    write(canvas, left + length / 2, Alignment::Center, &format!("{:.digits$}", (least + largest) / 2.0));
    write(canvas, left + length + 1, Alignment::Right, &format!("{largest:.digits$} mm"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::{DecodeLimits, decode};

    fn pixels(width: usize, height: usize, mm: impl Fn(usize, usize) -> f32) -> (usize, Vec<[u8; 3]>) {
        let distances: Vec<f32> = (0..width * height).map(|at| mm(at % width, at / width)).collect();
        let frame = decode(&png_turbo(width, height, &distances), &DecodeLimits::default()).unwrap();
        (frame.width(), frame.to_rgb8().as_chunks().0.to_vec())
    }

    #[test]
    fn near_is_red_far_is_blue_and_unknown_is_gray() {
        let (width, drawn) = pixels(240, 60, |x, _| if x == 120 { f32::NAN } else { 500.0 + x as f32 });
        assert_eq!((width, drawn.len()), (240, 240 * 92));
        let [near, far] = [drawn[8], drawn[231]];
        assert!(near[0] > 2 * near[2] && far[2] > 2 * far[1], "{near:?} {far:?}");
        assert_eq!(drawn[120], UNKNOWN);
    }

    #[test]
    fn the_bar_has_the_colours_of_the_picture_and_numbers_below() {
        let (width, drawn) = pixels(240, 60, |x, _| 1000.0 + x as f32);
        let bar = &drawn[width * 68..width * 69];
        assert_eq!((bar[MARGIN_PX], bar[width - 1 - MARGIN_PX]), (turbo(0.0), turbo(1.0)));
        let letters = drawn[width * 80..].iter().filter(|colour| **colour == LETTERS).count();
        assert!(letters > 100, "{letters} px of numbers");
    }

    #[test]
    fn nothing_known_one_distance_and_one_pixel_are_drawn_too() {
        let (width, drawn) = pixels(1, 1, |_, _| f32::NAN);
        assert_eq!((width, drawn[0]), (LEAST_WIDTH_PX, UNKNOWN));
        assert!(drawn[width * 20..].contains(&LETTERS), "it says that there is none");
        let (_, drawn) = pixels(9, 9, |_, _| 700.0);
        assert_eq!(drawn[0], turbo(0.5));
    }
}
