//! Query frames with known truth: a turntable object cut out of its picture, turned, set down somewhere, on a
//! photograph or on black, a part of it hidden behind a half-plane of another photograph, with sensor noise.
//!
//!   frame = (1 − mask) · ground + mask · object;  on one side of a random line another photograph;  + noise

use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::statistics::quantile_nearest;

use crate::random::Random;

/// Side of a frame.
const SIZE_PX: usize = 256;
/// Largest offset of the object from the frame's centre, along each axis.
const SHIFT_PX: f64 = 30.0;
/// Standard deviation of the sensor noise, grey levels.
const NOISE: f64 = 2.0;
/// COIL-20's ground is black: what is brighter belongs to the object.
const GROUND: f32 = 12.0;
/// Gaps up to this width within an object are closed.
const GAP_PX: usize = 7;

/// What is done to an object besides turning and moving it.
#[derive(Clone, Copy)]
pub struct Condition {
    /// On a photograph instead of black.
    pub on_photograph: bool,
    /// Part of the object's pixels that are hidden.
    pub hidden: f64,
    /// Least and greatest scale of the object.
    pub scale: (f64, f64),
}

/// How a picture lies in a frame: where its centre is, and how it is turned and scaled.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub x_px: f64,
    pub y_px: f64,
    pub rotation_deg: f64,
    pub scale: f64,
}

/// One frame with the object of `picture`, and how it lies. The turn and place depend on `key` alone, not on the
/// condition.
pub fn compose(
    picture: &Image,
    photographs: &[Image],
    condition: Condition,
    seed: u64,
    key: &[u64],
) -> (Frame, Truth) {
    let [mut place, mut ground, mut hide, mut grain] =
        [0, 1, 2, 3].map(|stream| Random::of(seed + stream, key));
    let rotation_deg = place.uniform(-180.0, 180.0);
    let middle = (SIZE_PX as f64 - 1.0) / 2.0;
    let mut off = || middle + place.uniform(-SHIFT_PX, SHIFT_PX);
    let (x_px, y_px) = (off(), off());
    let scale = place.uniform(condition.scale.0, condition.scale.1);
    let truth = Truth { x_px, y_px, rotation_deg, scale };
    let mut frame = match condition.on_photograph {
        true => crop(photographs, &mut ground),
        false => Image::from_fn(SIZE_PX, SIZE_PX, |_, _| 0.0),
    };
    let alpha = paste(&mut frame, picture, truth);
    if condition.hidden > 0.0 {
        let (sin, cos) = hide.uniform(0.0, std::f64::consts::TAU).sin_cos();
        let along = |px: usize, py: usize| px as f64 * cos + py as f64 * sin;
        let mut visible: Vec<f64> =
            pixels().filter(|&(px, py)| alpha.at(px, py) > 0.5).map(|(px, py)| along(px, py)).collect();
        let line = quantile_nearest(&mut visible, 1.0 - condition.hidden, f64::total_cmp)
            .expect("a part of the object is visible");
        let cover = crop(photographs, &mut hide);
        for (px, py) in pixels().filter(|&(px, py)| along(px, py) > line) {
            frame.pixels_mut()[py * SIZE_PX + px] = cover.at(px, py);
        }
    }
    (noisy(frame, &mut grain), truth)
}

/// One photograph with several objects on it, each in a part of the frame of its own.
pub fn compose_several(
    pictures: &[&Image],
    photographs: &[Image],
    seed: u64,
    key: &[u64],
) -> (Frame, Vec<Truth>) {
    let [mut place, mut ground, mut grain] = [0, 1, 3].map(|stream| Random::of(seed + stream, key));
    // the corners in turn: objects of 128 px hardly overlap there
    let first = place.below(4);
    let mut frame = crop(photographs, &mut ground);
    let mut truths = Vec::new();
    for (n, picture) in pictures.iter().enumerate() {
        let corner = (first + n) % 4;
        let mut off = |far: bool| if far { 189.0 } else { 66.0 } + place.uniform(-6.0, 6.0);
        let (x_px, y_px) = (off(corner == 1 || corner == 2), off(corner >= 2));
        let truth = Truth { x_px, y_px, rotation_deg: place.uniform(-180.0, 180.0), scale: 1.0 };
        paste(&mut frame, picture, truth);
        truths.push(truth);
    }
    (noisy(frame, &mut grain), truths)
}

/// One photograph without any object.
pub fn photograph(photographs: &[Image], seed: u64, key: &[u64]) -> Frame {
    let [mut ground, mut grain] = [1, 3].map(|stream| Random::of(seed + stream, key));
    noisy(crop(photographs, &mut ground), &mut grain)
}

/// Lay the object of a picture on a frame; how much of each pixel it covers.
fn paste(frame: &mut Image, picture: &Image, truth: Truth) -> Image {
    let (sin, cos) = truth.rotation_deg.to_radians().sin_cos();
    let (from_x, from_y) = ((picture.width() as f64 - 1.0) / 2.0, (picture.height() as f64 - 1.0) / 2.0);
    let mask = mask(picture);
    // frame pixel → picture pixel: turned back about the object's place
    let turned = |image: &Image, sample: fn(&Image, f64, f64) -> f64| {
        Image::from_fn(SIZE_PX, SIZE_PX, |px, py| {
            let (dx, dy) = ((px as f64 - truth.x_px) / truth.scale, (py as f64 - truth.y_px) / truth.scale);
            sample(image, from_x + cos * dx + sin * dy, from_y - sin * dx + cos * dy) as f32
        })
    };
    let (object, alpha) = (turned(picture, cubic), turned(&mask, linear));
    for (value, (alpha, object)) in
        frame.pixels_mut().iter_mut().zip(alpha.pixels().iter().zip(object.pixels()))
    {
        *value = *value * (1.0 - alpha) + object * alpha;
    }
    alpha
}

fn noisy(mut frame: Image, grain: &mut Random) -> Frame {
    for value in frame.pixels_mut() {
        *value = (f64::from(*value) + NOISE * grain.normal()).round().clamp(0.0, 255.0) as f32;
    }
    Frame::gray(frame)
}

fn pixels() -> impl Iterator<Item = (usize, usize)> {
    (0..SIZE_PX * SIZE_PX).map(|i| (i % SIZE_PX, i / SIZE_PX))
}

/// A piece of one of the photographs, each enlarged to a frame's size if it is smaller.
fn crop(photographs: &[Image], random: &mut Random) -> Image {
    let photograph = &photographs[random.below(photographs.len())];
    let scale = (photograph.width().min(photograph.height()) as f64 / SIZE_PX as f64).min(1.0);
    let (width, height) = (photograph.width() as f64 / scale, photograph.height() as f64 / scale);
    let (left, top) =
        (random.below(width as usize - SIZE_PX + 1), random.below(height as usize - SIZE_PX + 1));
    Image::from_fn(SIZE_PX, SIZE_PX, |px, py| match scale == 1.0 {
        true => photograph.at(left + px, top + py),
        false => cubic(photograph, (left + px) as f64 * scale, (top + py) as f64 * scale) as f32,
    })
}

/// 1 where the object is, 0 elsewhere: brighter than the ground, gaps closed, holes filled, the largest piece.
pub fn mask(picture: &Image) -> Image {
    // a rim of ground, so that closing never bridges to the picture's edge
    let (width, height) = (picture.width() + 2 * GAP_PX, picture.height() + 2 * GAP_PX);
    let bright = Image::from_fn(width, height, |x, y| {
        let inside = (GAP_PX..width - GAP_PX).contains(&x) && (GAP_PX..height - GAP_PX).contains(&y);
        f32::from(inside && picture.at(x.max(GAP_PX) - GAP_PX, y.max(GAP_PX) - GAP_PX) > GROUND)
    });
    let grown = around(&bright, f32::max);
    let closed = around(&grown, f32::min);
    let pieces = pieces(&closed, |value| value == 0.0);
    let outside = pieces.iter().find(|piece| piece.contains(&0)).expect("the rim is ground");
    let mut filled = Image::from_fn(width, height, |_, _| 1.0);
    outside.iter().for_each(|&i| filled.pixels_mut()[i] = 0.0);
    let object =
        self::pieces(&filled, |value| value == 1.0).into_iter().max_by_key(Vec::len).unwrap_or_default();
    let mut mask = Image::from_fn(picture.width(), picture.height(), |_, _| 0.0);
    for i in object {
        let (x, y) = (i % width, i / width);
        if (GAP_PX..width - GAP_PX).contains(&x) && (GAP_PX..height - GAP_PX).contains(&y) {
            mask.pixels_mut()[(y - GAP_PX) * picture.width() + x - GAP_PX] = 1.0;
        }
    }
    mask
}

/// Each pixel takes the extreme of the square of [`GAP_PX`] about it.
fn around(image: &Image, extreme: fn(f32, f32) -> f32) -> Image {
    let reach = GAP_PX / 2;
    let window = |at: usize, length: usize| at.saturating_sub(reach)..(at + reach + 1).min(length);
    let rows = Image::from_fn(image.width(), image.height(), |x, y| {
        window(x, image.width()).map(|x| image.at(x, y)).reduce(extreme).expect("a window")
    });
    Image::from_fn(image.width(), image.height(), |x, y| {
        window(y, image.height()).map(|y| rows.at(x, y)).reduce(extreme).expect("a window")
    })
}

/// The connected pieces (four neighbours) of the pixels that belong.
fn pieces(image: &Image, belongs: fn(f32) -> bool) -> Vec<Vec<usize>> {
    let (width, height) = (image.width(), image.height());
    let mut seen = vec![false; width * height];
    let mut pieces = Vec::new();
    for start in 0..width * height {
        let mut piece = Vec::new();
        let mut waiting = vec![start];
        while let Some(i) = waiting.pop() {
            if seen[i] || !belongs(image.pixels()[i]) {
                continue;
            }
            seen[i] = true;
            piece.push(i);
            let (x, y) = (i % width, i / width);
            waiting.extend((x > 0).then(|| i - 1));
            waiting.extend((x + 1 < width).then(|| i + 1));
            waiting.extend((y > 0).then(|| i - width));
            waiting.extend((y + 1 < height).then(|| i + width));
        }
        if !piece.is_empty() {
            pieces.push(piece);
        }
    }
    pieces
}

fn pixel(image: &Image, x: f64, y: f64) -> f64 {
    let inside = x >= 0.0 && y >= 0.0 && x < image.width() as f64 && y < image.height() as f64;
    if inside { f64::from(image.at(x as usize, y as usize)) } else { 0.0 }
}

pub fn linear(image: &Image, x: f64, y: f64) -> f64 {
    resampled(image, x, y, 0, |distance| 1.0 - distance)
}

/// The cubic of Catmull and Rom.
pub fn cubic(image: &Image, x: f64, y: f64) -> f64 {
    resampled(image, x, y, 1, |d| match d <= 1.0 {
        true => 1.5 * d * d * d - 2.5 * d * d + 1.0,
        false => -0.5 * d * d * d + 2.5 * d * d - 4.0 * d + 2.0,
    })
}

/// The sum over the pixels `reach` beyond the four around (x, y), weighted by `kernel` of the distances.
fn resampled(image: &Image, x: f64, y: f64, reach: i32, kernel: fn(f64) -> f64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let mut sum = 0.0;
    for row in (-reach..=1 + reach).map(|i| top + f64::from(i)) {
        for column in (-reach..=1 + reach).map(|i| left + f64::from(i)) {
            sum += kernel((x - column).abs()) * kernel((y - row).abs()) * pixel(image, column, row);
        }
    }
    sum
}

#[test]
fn the_mask_closes_gaps_fills_holes_and_keeps_the_largest_piece() {
    // a ring of 20 px with a hole of 8 px and a slit of 3 px, and a speck far away
    let picture = Image::from_fn(48, 32, |x, y| {
        let ring = (4..24).contains(&x) && (4..24).contains(&y);
        let hole = (10..18).contains(&x) && (10..18).contains(&y);
        let slit = (12..15).contains(&x) && y < 12;
        let speck = (40..43).contains(&x) && (26..29).contains(&y);
        if (ring && !hole && !slit) || speck { 200.0 } else { 5.0 }
    });
    let mask = mask(&picture);
    assert_eq!(mask.pixels().iter().sum::<f32>(), 20.0 * 20.0);
    assert_eq!((mask.at(14, 14), mask.at(13, 4), mask.at(41, 27)), (1.0, 1.0, 0.0));
}

#[test]
fn resampling_at_whole_pixels_changes_nothing() {
    let image = Image::from_fn(6, 5, |x, y| (7 * x * x + 11 * y) as f32);
    for (x, y) in [(0, 0), (3, 2), (5, 4)] {
        let expected = f64::from(image.at(x, y));
        assert!((linear(&image, x as f64, y as f64) - expected).abs() < 1e-9);
        assert!((cubic(&image, x as f64, y as f64) - expected).abs() < 1e-9);
    }
    // of a straight slope, half a pixel is half way
    let slope = Image::from_fn(6, 6, |x, _| x as f32);
    assert!((cubic(&slope, 2.5, 3.0) - 2.5).abs() < 1e-9);
}
