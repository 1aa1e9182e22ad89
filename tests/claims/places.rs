//! Paper A on places: one picture each of 20 places of the tower (the middle frame of its 20 longest clips),
//! 256 × 256; asked with the frames 1 and 2 seconds before and after it, tilted and half covered, seed 7.

use landmarkd_core::imaging::{Frame, Image};

use crate::data;
use crate::objects::options;
use crate::random::Random;
use crate::trials::{asked, trained};

const SEED: u64 = 7;
const PLACES: usize = 20;
const SIZE_PX: usize = 256;
const TILT_DEG: f64 = 15.0;

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn rooms_are_recognised_from_a_second_away_tilted_and_half_covered() {
    let folder = data::folder();
    let clips = data::tower_clips(&folder, PLACES);
    let training: Vec<Frame> =
        clips.iter().map(|clip| shrunk(&clip.frame(clip.middle_s()).expect("the middle"))).collect();
    let model = trained(&training, &options());
    let mut frames = Vec::new();
    for (place, clip) in clips.iter().enumerate() {
        for (k, offset_s) in [-2, -1, 1, 2].into_iter().enumerate() {
            if let Some(frame) = clip.middle_s().checked_add_signed(offset_s).and_then(|s| clip.frame(s)) {
                frames.push((offset_s.abs(), place, k as u64, shrunk(&frame)));
            }
        }
    }
    // Expected: untouched, the rates of the numpy reference; else the means over four seeds. By chance: 0.05.
    for (gap_s, tilt_deg, covered, expected) in [
        (1, 0.0, false, 0.65),
        (2, 0.0, false, 0.275),
        (1, TILT_DEG, false, 0.56),
        (2, TILT_DEG, false, 0.28),
        (1, TILT_DEG, true, 0.42),
        (2, TILT_DEG, true, 0.23),
    ] {
        let asked_for = frames.iter().filter(|(gap, ..)| *gap == gap_s);
        let views: Vec<(usize, Frame)> = asked_for
            .map(|(_, place, k, frame)| (*place, disturbed(frame, tilt_deg, covered, &[*place as u64, *k])))
            .collect();
        let outcome = asked(&model, &views);
        let cover = if covered { ", half covered" } else { "" };
        outcome.say(&format!("rooms {gap_s} s away, tilted by up to {tilt_deg} degrees{cover}"));
        outcome.assert_reaches(expected);
    }
}

/// Tilted about its centre by up to `tilt_deg`; `covered`: black on one side of a diagonal.
fn disturbed(frame: &Frame, tilt_deg: f64, covered: bool, key: &[u64]) -> Frame {
    let mut random = Random::of(SEED, key);
    let tilted = frame.turned(random.uniform(-tilt_deg, tilt_deg));
    let corner = random.below(4);
    let grey = &tilted.luminance;
    let last = SIZE_PX - 1;
    let hidden = |x: usize, y: usize| match corner {
        0 => x + y < last,
        1 => x > y,
        2 => x + y > last,
        _ => x < y,
    };
    Frame::gray(Image::from_fn(
        SIZE_PX,
        SIZE_PX,
        |x, y| {
            if covered && hidden(x, y) { 0.0 } else { grey.at(x, y) }
        },
    ))
}

/// The whole picture in [`SIZE_PX`] × [`SIZE_PX`], gray; each pixel the mean of the area that it covers.
pub fn shrunk(frame: &Frame) -> Frame {
    let grey = &frame.luminance;
    let across = shares(grey.width());
    let rows = Image::from_fn(SIZE_PX, grey.height(), |x, y| {
        across[x].iter().map(|&(from, share)| share * grey.at(from, y)).sum()
    });
    let down = shares(grey.height());
    Frame::gray(Image::from_fn(SIZE_PX, SIZE_PX, |x, y| {
        down[y].iter().map(|&(from, share)| share * rows.at(x, from)).sum()
    }))
}

/// For each of [`SIZE_PX`] pixels, the old pixels that it covers and their parts of it.
fn shares(length: usize) -> Vec<Vec<(usize, f32)>> {
    let step = length as f64 / SIZE_PX as f64;
    let covers = |n: usize| {
        let (start, end) = (n as f64 * step, (n + 1) as f64 * step);
        let part = move |from: usize| ((from + 1) as f64).min(end) - (from as f64).max(start);
        (start as usize..(end.ceil() as usize).min(length))
            .map(move |from| (from, (part(from) / step) as f32))
    };
    (0..SIZE_PX).map(|n| covers(n).collect()).collect()
}
