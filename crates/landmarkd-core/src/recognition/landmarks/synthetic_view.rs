//! Synthetic views of an exemplar: its picture turned, moved, scaled, on another background and partly occluded, so that
//! the right answer is known. They calibrate the confidence and compare versions.

use std::f64::consts::{PI, TAU};

use super::confidence::SAMPLES_TOGETHER;
use super::dead_leaves::DeadLeaves;
use super::description::ExemplarName;
use super::options::{LandmarkOptions, Viewpoint};
use crate::imaging::{Frame, Image, Random, bilinear_replicated, seed_of_name};
use crate::statistics::quantile_nearest;

/// The conditions of one exemplar in one round. Each gives two samples.
const CONDITIONS: [Condition; SAMPLES_TOGETHER / 2] = [
    Condition { cluttered: false, occlusion: 0.0 },
    Condition { cluttered: true, occlusion: 0.0 },
    Condition { cluttered: true, occlusion: 0.3 },
    Condition { cluttered: true, occlusion: 0.55 },
];
/// A side of the frame in sides of the picture.
const FRAME_SIDE: f64 = 2.0;
/// A side of the frame at most, unless the picture is larger.
const MOST_SIDE_PX: f64 = 448.0;
/// Standard deviation of the noise, gray levels.
const NOISE: f64 = 2.0;
/// Pixels within this of the border's median belong to the background, if most of the border does; gray levels.
const BACKGROUND_LEVELS: f32 = 12.0;
const BACKGROUND_BORDER: f64 = 0.8;

/// Background and occlusion of a synthetic view.
#[derive(Clone, Copy)]
struct Condition {
    /// Whether the background is dead leaves, not even.
    cluttered: bool,
    /// The part of the picture that is occluded.
    occlusion: f64,
}

/// A frame that shows an exemplar's picture under known conditions.
pub struct SyntheticView {
    /// Shows the picture.
    pub(super) frame: Frame,
    /// The background without the picture.
    pub(super) background: Frame,
    /// Whether the exemplar itself is left out if its label has others: then the frame is like a new view.
    pub(super) new_view: bool,
}

/// The synthetic views of an exemplar's picture, always the same for the same name and round; rounds give different
/// views of one picture.
pub fn synthetic_views(
    name: &ExemplarName,
    picture: &Frame,
    round: u64,
    options: &LandmarkOptions,
) -> Vec<SyntheticView> {
    let seed = seed_of_name(&name.id, round);
    let view = |(number, condition): (usize, &Condition)| {
        let random = &mut Random::new(seed, number as u64);
        let [frame, background] = render(picture, *condition, options, random);
        SyntheticView { frame, background, new_view: number % 2 == 1 }
    };
    CONDITIONS.iter().enumerate().map(view).collect()
}

/// The picture under a condition, and the background alone.
fn render(
    picture: &Frame,
    condition: Condition,
    options: &LandmarkOptions,
    random: &mut Random,
) -> [Frame; 2] {
    let view = ViewTransform::draw(picture, options, random);
    let gain = random.between(0.75, 1.0);
    let whole = options.viewpoint == Viewpoint::Upright;
    let mask = if whole { None } else { foreground_mask(&picture.luminance) };
    let alpha = view.alpha(picture, mask.as_ref(), whole);
    let occluded = view.occluded(&alpha, condition.occlusion, random);
    let background = DeadLeaves::draw(view.width, view.height, picture, random);
    let cover = DeadLeaves::draw(view.width, view.height, picture, random);
    let channel = |channel: usize, random: &mut Random| {
        let plane = picture.rgb.as_ref().map_or(&picture.luminance, |rgb| &rgb[channel]);
        let even = f64::from(if mask.is_some() { plane.border_median() } else { 0.0 });
        let (background, cover) = (background.render(channel, plane), cover.render(channel, plane));
        let shown = Image::from_fn(view.width, view.height, |px, py| {
            let pixel = py * view.width + px;
            let value = if occluded[pixel] {
                f64::from(cover.at(px, py))
            } else {
                let [u, v] = view.to_picture(px, py);
                let behind = if condition.cluttered { f64::from(background.at(px, py)) } else { even };
                alpha[pixel] * gain * bilinear_replicated(plane, u, v) + (1.0 - alpha[pixel]) * behind
            };
            (value + NOISE * random.normals()[0]).round().clamp(0.0, 255.0) as f32
        });
        [shown, background]
    };
    if !picture.is_colour() {
        return channel(0, random).map(Frame::gray);
    }
    let [[red, red_behind], [green, green_behind], [blue, blue_behind]] =
        [0, 1, 2].map(|number| channel(number, random));
    [Frame::colour([red, green, blue]), Frame::colour([red_behind, green_behind, blue_behind])]
}

/// Size of the frame, and the inverse similarity from the frame to the picture.
struct ViewTransform {
    width: usize,
    height: usize,
    /// The picture's centre, in the frame and in the picture, pixels.
    frame_centre: [f64; 2],
    picture_centre: [f64; 2],
    /// Sine and cosine of the rotation over the scale.
    sin: f64,
    cos: f64,
}

impl ViewTransform {
    /// Draws rotation, scale and position: little change for upright cameras, scales only if the database has several
    /// radii.
    fn draw(picture: &Frame, options: &LandmarkOptions, random: &mut Random) -> ViewTransform {
        let upright = options.viewpoint == Viewpoint::Upright;
        let several_radii = options.subwindow_radii_px.len() > 1;
        let side = |length: usize| match upright {
            true => length,
            false => (FRAME_SIDE * length as f64).min(MOST_SIDE_PX).max(length as f64).round() as usize,
        };
        let (width, height) = (side(picture.width()), side(picture.height()));
        let turn_rad = if upright { random.between(-0.05, 0.05) } else { random.between(-PI, PI) };
        let scale = match (upright, several_radii) {
            (true, _) => random.between(0.92, 1.12),
            (false, true) => random.between(0.8_f64.ln(), 1.25_f64.ln()).exp(),
            (false, false) => random.between(0.95, 1.05),
        };
        let shift = if upright { 0.05 } else { 0.12 };
        let mut centre = |length: usize| length as f64 * (0.5 + random.between(-shift, shift)) - 0.5;
        ViewTransform {
            width,
            height,
            frame_centre: [centre(width), centre(height)],
            picture_centre: [picture.width(), picture.height()].map(|side| (side as f64 - 1.0) / 2.0),
            sin: turn_rad.sin() / scale,
            cos: turn_rad.cos() / scale,
        }
    }

    /// The position on the picture that a pixel of the frame shows.
    fn to_picture(&self, px: usize, py: usize) -> [f64; 2] {
        let (dx, dy) = (px as f64 - self.frame_centre[0], py as f64 - self.frame_centre[1]);
        let [x, y] = self.picture_centre;
        [x + self.cos * dx + self.sin * dy, y - self.sin * dx + self.cos * dy]
    }

    /// Opacity of the picture at each pixel of the frame, 0..=1, row-major: that of the mask, or 1 on the picture. With
    /// `whole` the picture is continued beyond its border.
    fn alpha(&self, picture: &Frame, mask: Option<&Image>, whole: bool) -> Vec<f64> {
        let (width, height) = (picture.width() as f64, picture.height() as f64);
        let pixels = (0..self.height).flat_map(|py| (0..self.width).map(move |px| (px, py)));
        let alpha = pixels.map(|(px, py)| {
            let [u, v] = self.to_picture(px, py);
            let inside = u > -0.5 && v > -0.5 && u < width - 0.5 && v < height - 0.5;
            match mask {
                Some(mask) if inside => bilinear_replicated(mask, u, v),
                None if inside || whole => 1.0,
                _ => 0.0,
            }
        });
        alpha.collect()
    }

    /// The pixels of the frame beyond a line of random direction, which cuts the given part off the picture, row-major.
    fn occluded(&self, alpha: &[f64], part: f64, random: &mut Random) -> Vec<bool> {
        let (sin, cos) = random.between(0.0, TAU).sin_cos();
        let along = |pixel: usize| (pixel % self.width) as f64 * cos + (pixel / self.width) as f64 * sin;
        let every_fourth = (0..self.height)
            .step_by(4)
            .flat_map(|py| (0..self.width).step_by(4).map(move |px| py * self.width + px));
        let mut visible: Vec<f64> = every_fourth.filter(|&pixel| alpha[pixel] > 0.5).map(along).collect();
        let line = quantile_nearest(&mut visible, 1.0 - part, f64::total_cmp).unwrap_or(f64::INFINITY);
        (0..alpha.len()).map(|pixel| part > 0.0 && along(pixel) > line).collect()
    }
}

/// 1 on the thing that a picture shows, 0 on the even background around it, by flood fill from the border; `None` if
/// the border isn't even, or nothing else remains.
fn foreground_mask(picture: &Image) -> Option<Image> {
    let (width, height) = (picture.width(), picture.height());
    let level = picture.border_median();
    let even = |i: usize| (picture.pixels()[i] - level).abs() <= BACKGROUND_LEVELS;
    let border: Vec<usize> = picture.border().collect();
    if (border.iter().filter(|&&i| even(i)).count() as f64) < BACKGROUND_BORDER * border.len() as f64 {
        return None;
    }
    let mut mask = Image::from_fn(width, height, |_, _| 1.0);
    let mut waiting: Vec<usize> = border.into_iter().filter(|&i| even(i)).collect();
    while let Some(i) = waiting.pop() {
        if mask.pixels()[i] == 0.0 || !even(i) {
            continue;
        }
        mask.pixels_mut()[i] = 0.0;
        let (x, y) = (i % width, i / width);
        waiting.extend((x > 0).then(|| i - 1));
        waiting.extend((x + 1 < width).then(|| i + 1));
        waiting.extend((y > 0).then(|| i - width));
        waiting.extend((y + 1 < height).then(|| i + width));
    }
    mask.pixels().contains(&1.0).then_some(mask)
}
