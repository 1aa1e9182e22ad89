//! Rehearsals: an exemplar's picture seen otherwise (turned, moved, on other ground, hidden in part), so that the
//! right answer is known. With the exemplar's label left out of the database, the right answer is none.
//!
//! The ground is drawn as dead leaves (Lee, Mumford, Huang 2001): leaves of all sizes that lie over each other, as
//! things do in pictures of the world, some of them with pieces of the exemplar's own picture on them.

use std::f64::consts::{PI, TAU};

use super::confidence::{Confidence, Evidence, REHEARSALS_TOGETHER, Rehearsed, Reliability};
use super::description::ExemplarName;
use super::model::{Exemplar, Landmarks};
use super::options::{LandmarkOptions, Viewpoint};
use super::recognition::Recognition;
use crate::imaging::{Frame, Image, Random};

/// So many exemplars are rehearsed, spread over all; fewer than [`FEW_EXEMPLARS`] several times each.
const REHEARSED_EXEMPLARS: usize = 40;
const FEW_EXEMPLARS: usize = 10;
/// The rehearsals of one picture.
const CONDITIONS: [Condition; REHEARSALS_TOGETHER / 2] = [
    Condition { cluttered: false, hidden: 0.0 },
    Condition { cluttered: true, hidden: 0.0 },
    Condition { cluttered: true, hidden: 0.3 },
    Condition { cluttered: true, hidden: 0.55 },
];
/// A rehearsal's frame is not larger than this a side, unless the picture is.
const MOST_SIDE_PX: f64 = 448.0;
/// Of the picture's side.
const FRAME_SIDE: f64 = 2.0;
/// Standard deviation of the noise, grey levels.
const NOISE: f64 = 2.0;
/// Pixels within this of the rim's median belong to the ground, if most of the rim does; grey levels.
const GROUND_LEVELS: f32 = 12.0;
const GROUND_RIM: f64 = 0.8;

/// What is done to a picture beside turning and moving it.
#[derive(Clone, Copy)]
struct Condition {
    cluttered: bool,
    /// Part of the picture that is hidden.
    hidden: f64,
}

/// A frame in which a picture is seen otherwise.
pub struct Rehearsal {
    /// What is seen.
    frame: Frame,
    /// The ground without the picture.
    ground: Frame,
    /// Whether the exemplar itself is left out if there are others of its label: then it is like a new view.
    new_view: bool,
}

/// What a database says to a rehearsal, and what it says with the label left out.
struct Said {
    known: (Recognition, Evidence),
    unknown: (Recognition, Evidence),
}

/// The rehearsals of an exemplar's picture, always the same for the same name and round; rounds tell apart several
/// rehearsals of one picture.
pub fn rehearsals(
    name: &ExemplarName,
    picture: &Frame,
    round: u64,
    options: &LandmarkOptions,
) -> Vec<Rehearsal> {
    let seed = name.id.bytes().fold(round, |seed, byte| seed.wrapping_mul(31).wrapping_add(u64::from(byte)));
    let upright = options.viewpoint == Viewpoint::Upright;
    let scales = options.subwindow_radii_px.len() > 1;
    let rehearsal = |(number, condition): (usize, &Condition)| {
        let random = &mut Random::new(seed, number as u64);
        let [frame, ground] = rehearsed(picture, *condition, upright, scales, random);
        Rehearsal { frame, ground, new_view: number % 2 == 1 }
    };
    CONDITIONS.iter().enumerate().map(rehearsal).collect()
}

impl Landmarks {
    /// What the database says to rehearsals of an exemplar, and to the same with the exemplar's label left out: two
    /// rows each.
    ///
    /// Exemplars don't depend on each other: they may be rehearsed in parallel.
    pub fn rehearse(&self, name: &ExemplarName, rehearsals: &[Rehearsal]) -> Vec<Rehearsed> {
        let said = self.said_to(name, rehearsals).into_iter();
        said.flat_map(|said| {
            let label = said.known.0.votes.first().map(|vote| vote.label.as_str());
            let right = label == Some(name.label.as_str());
            [
                Rehearsed { evidence: said.known.1, right, known: true },
                Rehearsed { evidence: said.unknown.1, right: false, known: false },
            ]
        })
        .collect()
    }

    /// Whether the database decides rightly on rehearsals of an exemplar, and on the same with the exemplar's label
    /// left out, where nothing should be decided: two answers each, in the same order for every database.
    pub fn judge(&self, name: &ExemplarName, rehearsals: &[Rehearsal]) -> Vec<bool> {
        let said = self.said_to(name, rehearsals).into_iter();
        said.flat_map(|said| {
            let label = said.known.0.decision.as_ref().map(|decision| decision.label.as_str());
            [label == Some(name.label.as_str()), said.unknown.0.decision.is_none()]
        })
        .collect()
    }

    fn said_to(&self, name: &ExemplarName, rehearsals: &[Rehearsal]) -> Vec<Said> {
        let has = |wanted: &dyn Fn(&Exemplar) -> bool| self.exemplars.iter().any(wanted);
        let without_label = self.leaving_out(|e| e.label == name.label);
        let without_itself =
            has(&|e| e.label == name.label && e.id != name.id).then(|| self.leaving_out(|e| e.id == name.id));
        let other_labels = has(&|e| e.label != name.label);
        let said_to = |rehearsal: &Rehearsal| {
            let left_out = without_itself.as_ref().filter(|_| rehearsal.new_view);
            Said {
                known: self.recognise_without(&rehearsal.frame, left_out, |_| ()),
                unknown: match other_labels {
                    true => self.recognise_without(&rehearsal.frame, Some(&without_label), |_| ()),
                    // nothing else is known: the ground alone
                    false => self.recognise_without(&rehearsal.ground, None, |_| ()),
                },
            }
        };
        rehearsals.iter().map(said_to).collect()
    }

    /// Which exemplars to rehearse, by index, and how often each.
    pub fn rehearsed_exemplars(&self) -> (Vec<usize>, u64) {
        let count = self.exemplars.len();
        let chosen = count.min(REHEARSED_EXEMPLARS);
        let rounds = FEW_EXEMPLARS.div_ceil(chosen.max(1)) as u64;
        ((0..chosen).map(|i| i * count / chosen).collect(), rounds)
    }

    /// Take the chance to be right from rehearsals, round by round, in each in the order of the exemplars; nothing is
    /// told if they don't allow it.
    pub fn calibrate(&mut self, rehearsed: &[Rehearsed]) -> Option<Reliability> {
        let (chosen, _) = self.rehearsed_exemplars();
        let (confidence, reliability) = Confidence::fit(rehearsed, chosen.len())?;
        self.confidence = Some(confidence);
        Some(reliability)
    }
}

/// The picture seen otherwise, and its ground alone.
fn rehearsed(
    picture: &Frame,
    condition: Condition,
    upright: bool,
    scales: bool,
    random: &mut Random,
) -> [Frame; 2] {
    let (width, height) = (picture.width() as f64, picture.height() as f64);
    let side = |length: f64| match upright {
        true => length,
        false => (FRAME_SIDE * length).min(MOST_SIDE_PX).max(length).round(),
    };
    let (frame_width, frame_height) = (side(width) as usize, side(height) as usize);
    let turn = if upright { random.between(-0.05, 0.05) } else { random.between(-PI, PI) };
    let scale = match (upright, scales) {
        (true, _) => random.between(0.92, 1.12),
        (false, true) => random.between(0.8_f64.ln(), 1.25_f64.ln()).exp(),
        (false, false) => random.between(0.95, 1.05),
    };
    let shift = if upright { 0.05 } else { 0.12 };
    let mut off = |length: usize| length as f64 * (0.5 + random.between(-shift, shift)) - 0.5;
    let (x, y) = (off(frame_width), off(frame_height));
    let gain = random.between(0.75, 1.0);
    let (sin, cos) = (turn.sin() / scale, turn.cos() / scale);
    let to_picture = |px: usize, py: usize| {
        let (dx, dy) = (px as f64 - x, py as f64 - y);
        ((width - 1.0) / 2.0 + cos * dx + sin * dy, (height - 1.0) / 2.0 - sin * dx + cos * dy)
    };
    let body = if upright { None } else { body(&picture.luminance) };
    let seen = |px: usize, py: usize| {
        let (u, v) = to_picture(px, py);
        let inside = u > -0.5 && v > -0.5 && u < width - 0.5 && v < height - 0.5;
        match &body {
            _ if upright => 1.0,
            Some(body) if inside => bilinear(body, u, v),
            None if inside => 1.0,
            _ => 0.0,
        }
    };
    let (hide_sin, hide_cos) = random.between(0.0, TAU).sin_cos();
    let along = |px: usize, py: usize| px as f64 * hide_cos + py as f64 * hide_sin;
    let line = {
        let every =
            (0..frame_height).step_by(4).flat_map(|py| (0..frame_width).step_by(4).map(move |px| (px, py)));
        let mut visible: Vec<f64> =
            every.filter(|&(px, py)| seen(px, py) > 0.5).map(|(px, py)| along(px, py)).collect();
        visible.sort_by(f64::total_cmp);
        let last = visible.len().saturating_sub(1) as f64;
        visible.get((last * (1.0 - condition.hidden)).round() as usize).copied().unwrap_or(f64::INFINITY)
    };
    let ground = Leaves::fallen(frame_width, frame_height, picture, random);
    let cover = Leaves::fallen(frame_width, frame_height, picture, random);
    let plane = |channel: usize, random: &mut Random| {
        let plane = picture.rgb.as_ref().map_or(&picture.luminance, |rgb| &rgb[channel]);
        let flat = f64::from(if body.is_some() { rim_median(plane) } else { 0.0 });
        let (ground, cover) = (ground.plane(channel, plane), cover.plane(channel, plane));
        let seen = Image::from_fn(frame_width, frame_height, |px, py| {
            let value = if condition.hidden > 0.0 && along(px, py) > line {
                f64::from(cover.at(px, py))
            } else {
                let (u, v) = to_picture(px, py);
                let alpha = seen(px, py);
                let behind = if condition.cluttered { f64::from(ground.at(px, py)) } else { flat };
                alpha * gain * bilinear(plane, u, v) + (1.0 - alpha) * behind
            };
            (value + NOISE * random.normals()[0]).round().clamp(0.0, 255.0) as f32
        });
        [seen, ground]
    };
    if !picture.is_colour() {
        return plane(0, random).map(Frame::gray);
    }
    let [[red, red_ground], [green, green_ground], [blue, blue_ground]] =
        [0, 1, 2].map(|channel| plane(channel, random));
    [Frame::colour([red, green, blue]), Frame::colour([red_ground, green_ground, blue_ground])]
}

/// Leaves in the order in which they fell.
struct Leaves {
    width: usize,
    height: usize,
    leaves: Vec<Leaf>,
}

struct Leaf {
    x: f64,
    y: f64,
    radius: f64,
    /// Width over length, and direction.
    narrow: f64,
    sin: f64,
    cos: f64,
    square: bool,
    /// Grey level of each channel, and how it changes along the leaf, levels per pixel.
    level: [f64; 3],
    slope: f64,
    /// Where on the picture the piece on it was taken, and how strong it is; 0: plain.
    from: (f64, f64),
    strength: f64,
}

impl Leaves {
    fn fallen(width: usize, height: usize, picture: &Frame, random: &mut Random) -> Leaves {
        let side = width.min(height) as f64;
        let (least, most) = (3.0, 0.35 * side);
        // sizes by the inverse cube: as much is covered by small leaves as by large ones
        let radius = |u: f64| 1.0 / ((1.0 - u) / (least * least) + u / (most * most)).sqrt();
        let mut covered = 0.0;
        let mut leaves = Vec::new();
        while covered < 3.0 * (width * height) as f64 {
            let radius = radius(random.uniform());
            let (sin, cos) = random.between(0.0, TAU).sin_cos();
            let gray = random.between(10.0, 245.0);
            let tint = if random.uniform() < 0.5 { 0.0 } else { 60.0 };
            let leaf = Leaf {
                x: random.between(0.0, width as f64),
                y: random.between(0.0, height as f64),
                radius,
                narrow: random.between(0.3, 1.0),
                sin,
                cos,
                square: random.uniform() < 0.4,
                level: [(); 3].map(|()| (gray + random.between(-tint, tint)).clamp(0.0, 255.0)),
                slope: random.between(-1.0, 1.0) * 40.0 / radius.max(8.0),
                from: (
                    random.between(0.0, picture.width() as f64),
                    random.between(0.0, picture.height() as f64),
                ),
                strength: if random.uniform() < 0.5 { random.between(0.2, 1.0) } else { 0.0 },
            };
            covered += leaf.radius * leaf.radius * leaf.narrow * PI;
            leaves.push(leaf);
        }
        Leaves { width, height, leaves }
    }

    fn plane(&self, channel: usize, picture: &Image) -> Image {
        let mut plane = Image::from_fn(self.width, self.height, |_, _| 90.0);
        let mean = picture.mean();
        for leaf in &self.leaves {
            let reach = leaf.radius * if leaf.square { std::f64::consts::SQRT_2 } else { 1.0 };
            let range = |centre: f64, length: usize| {
                (centre - reach).max(0.0) as usize..((centre + reach + 1.0).max(0.0) as usize).min(length)
            };
            for py in range(leaf.y, self.height) {
                for px in range(leaf.x, self.width) {
                    let (dx, dy) = (px as f64 - leaf.x, py as f64 - leaf.y);
                    let (u, v) =
                        (leaf.cos * dx + leaf.sin * dy, (leaf.cos * dy - leaf.sin * dx) / leaf.narrow);
                    let inside = match leaf.square {
                        true => u.abs().max(v.abs()) < leaf.radius,
                        false => u * u + v * v < leaf.radius * leaf.radius,
                    };
                    if !inside {
                        continue;
                    }
                    let mut value = leaf.level[channel] + leaf.slope * u;
                    if leaf.strength > 0.0 {
                        let piece = bilinear(picture, leaf.from.0 + u, leaf.from.1 + v * leaf.narrow);
                        value += leaf.strength * (piece - mean);
                    }
                    plane.pixels_mut()[py * self.width + px] = value.clamp(0.0, 255.0) as f32;
                }
            }
        }
        plane
    }
}

/// 1 where a picture shows something, 0 on the even ground around it; `None` if its rim isn't even.
fn body(picture: &Image) -> Option<Image> {
    let (width, height) = (picture.width(), picture.height());
    let level = rim_median(picture);
    let even = |i: usize| (picture.pixels()[i] - level).abs() <= GROUND_LEVELS;
    let rim: Vec<usize> = rim(width, height).collect();
    if (rim.iter().filter(|&&i| even(i)).count() as f64) < GROUND_RIM * rim.len() as f64 {
        return None;
    }
    let mut body = Image::from_fn(width, height, |_, _| 1.0);
    let mut waiting: Vec<usize> = rim.into_iter().filter(|&i| even(i)).collect();
    while let Some(i) = waiting.pop() {
        if body.pixels()[i] == 0.0 || !even(i) {
            continue;
        }
        body.pixels_mut()[i] = 0.0;
        let (x, y) = (i % width, i / width);
        waiting.extend((x > 0).then(|| i - 1));
        waiting.extend((x + 1 < width).then(|| i + 1));
        waiting.extend((y > 0).then(|| i - width));
        waiting.extend((y + 1 < height).then(|| i + width));
    }
    body.pixels().contains(&1.0).then_some(body)
}

fn rim(width: usize, height: usize) -> impl Iterator<Item = usize> {
    (0..width * height).filter(move |i| {
        let (x, y) = (i % width, i / width);
        x == 0 || y == 0 || x + 1 == width || y + 1 == height
    })
}

fn rim_median(picture: &Image) -> f32 {
    let mut values: Vec<f32> = rim(picture.width(), picture.height()).map(|i| picture.pixels()[i]).collect();
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// The value between pixels; outside, the border is continued.
fn bilinear(image: &Image, x: f64, y: f64) -> f64 {
    let (last_x, last_y) = (image.width() - 1, image.height() - 1);
    let (x, y) = (x.clamp(0.0, last_x as f64), y.clamp(0.0, last_y as f64));
    let (left, top) = (x as usize, y as usize);
    let (right, below) = ((left + 1).min(last_x), (top + 1).min(last_y));
    let (across, down) = (x - left as f64, y - top as f64);
    let at = |x, y| f64::from(image.at(x, y));
    let upper = at(left, top) + across * (at(right, top) - at(left, top));
    let lower = at(left, below) + across * (at(right, below) - at(left, below));
    upper + down * (lower - upper)
}
