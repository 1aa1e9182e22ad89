//! Which pictures of a bag are worth teaching: not those that show what the one before showed, nor blurred ones.

use std::collections::VecDeque;

use clap::Args;
use landmarkd_core::geometry::MapPose;
use landmarkd_core::imaging::{DecodeLimits, Image, decode_reduced};

use super::contents::{BagPicture, positive};
use super::labels::Labels;

/// Sharpness is measured on pictures of this length at most: finer detail is noise and compression.
const SHARPNESS_SIDE_PX: usize = 640;
/// Pictures before and after one that its sharpness is compared with.
const NEIGHBOURS: usize = 7;
/// A picture is blurred below this part of its neighbours' median sharpness. Chosen on four walks through a building at one
/// frame a second; on 17 others (498 frames) it leaves out 87 in 100 frames that are smeared over 9 px, and 5 in 100 as they are.
const BLURRED_BELOW: f64 = 0.3;
/// Pictures without poses are compared at this length.
const THUMBNAIL_SIDE_PX: usize = 32;
/// Mean difference of two thumbnails in gray levels, below which they show the same.
const SAME_BELOW: f64 = 8.0;

/// What is left out.
#[derive(Args, Clone, Debug)]
pub struct SelectionArgs {
    /// Least way between pictures that are taught, in metres, unless the camera turned
    #[arg(long, value_name = "M", default_value_t = 0.5, value_parser = positive)]
    pub min_distance_m: f64,
    /// Least turn between pictures that are taught, in degrees, unless the camera moved
    #[arg(long, value_name = "DEG", default_value_t = 15.0, value_parser = positive)]
    pub min_turn_deg: f64,
}

/// How many pictures were left out, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Without a pose that says their label.
    pub without_pose: usize,
    /// Too near to the picture that was kept before.
    pub near_duplicates: usize,
    /// Blurred.
    pub blurred: usize,
    /// Not read.
    pub unreadable: usize,
    /// Why the first of these was not.
    pub first_reason: Option<String>,
}

/// A picture that is worth teaching.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The picture with its bytes.
    pub stamp_ns: i64,
    /// What it shows.
    pub label: String,
    /// A JPEG or PNG.
    pub file: Vec<u8>,
    /// Of the camera's body.
    pub pose: Option<MapPose>,
    /// Length of the bag that was read so far.
    pub read_bytes: u64,
}

/// Takes pictures one by one and gives back those that are worth teaching, some pictures later.
pub struct Selection {
    args: SelectionArgs,
    labels: Labels,
    /// Sharpness of the pictures around the next one that is decided about, and which of them that is.
    sharpness: VecDeque<f64>,
    decided: usize,
    waiting: VecDeque<(Chosen, Image)>,
    /// The pose and thumbnail of the picture that was kept last.
    last: Option<(Option<MapPose>, Image)>,
    /// What was left out so far.
    pub left_out: LeftOut,
}

impl Selection {
    /// Before the first picture.
    pub fn new(args: &SelectionArgs, labels: Labels) -> Selection {
        Selection {
            args: args.clone(),
            labels,
            sharpness: VecDeque::new(),
            decided: 0,
            waiting: VecDeque::new(),
            last: None,
            left_out: LeftOut::default(),
        }
    }

    /// Takes the next picture; gives one that is kept, if that is certain by now.
    pub fn next(&mut self, picture: BagPicture, read_bytes: u64) -> Option<Chosen> {
        let Some(label) = self.labels.label(picture.pose.as_ref()) else {
            self.left_out.without_pose += 1;
            return None;
        };
        let read = picture.file.and_then(|file| {
            let frame = decode_reduced(&file, &DecodeLimits::default(), SHARPNESS_SIDE_PX);
            Ok((file, frame.map_err(|error| error.to_string())?))
        });
        let (file, frame) = match read {
            Ok(read) => read,
            Err(reason) => {
                self.left_out.unreadable += 1;
                self.left_out.first_reason.get_or_insert(reason);
                return None;
            }
        };
        let thumbnail = frame.at_most(THUMBNAIL_SIDE_PX).luminance.clone();
        self.sharpness.push_back(sharpness(&frame.luminance));
        let chosen = Chosen { stamp_ns: picture.stamp_ns, label, file, pose: picture.pose, read_bytes };
        self.waiting.push_back((chosen, thumbnail));
        if self.waiting.len() > NEIGHBOURS { self.decide() } else { None }
    }

    /// The pictures that were not decided about when the bag ended.
    pub fn rest(&mut self) -> Vec<Chosen> {
        let mut chosen = Vec::new();
        while !self.waiting.is_empty() {
            chosen.extend(self.decide());
        }
        chosen
    }

    /// Decides about the picture that waits longest.
    fn decide(&mut self) -> Option<Chosen> {
        let (chosen, thumbnail) = self.waiting.pop_front()?;
        let own = self.sharpness[self.decided];
        let mut around: Vec<f64> = self.sharpness.iter().copied().collect();
        around.sort_by(f64::total_cmp);
        let median = around[around.len() / 2];
        match self.decided < NEIGHBOURS {
            true => self.decided += 1,
            false => drop(self.sharpness.pop_front()),
        }
        let kept = self.last.as_ref().map(|(pose, image)| (pose.as_ref(), image));
        if kept.is_some_and(|kept| self.shows_the_same(kept, (chosen.pose.as_ref(), &thumbnail))) {
            self.left_out.near_duplicates += 1;
            return None;
        }
        if own < BLURRED_BELOW * median {
            self.left_out.blurred += 1;
            return None;
        }
        self.last = Some((chosen.pose, thumbnail));
        Some(chosen)
    }

    fn shows_the_same(
        &self,
        (pose_a, thumbnail_a): (Option<&MapPose>, &Image),
        (pose_b, thumbnail_b): (Option<&MapPose>, &Image),
    ) -> bool {
        let (Some(a), Some(b)) = (pose_a, pose_b) else {
            return difference(thumbnail_a, thumbnail_b) < SAME_BELOW;
        };
        let (a, b) = (a.transform(), b.transform());
        (a.translation_m - b.translation_m).length() < self.args.min_distance_m
            && a.angle_to_rad(&b).to_degrees() < self.args.min_turn_deg
    }
}

/// Variance of the Laplacian over that of the gray levels: what it is of the scene's contrast doesn't count. 0 for pictures
/// without an inner pixel.
fn sharpness(image: &Image) -> f64 {
    let (width, height) = (image.width(), image.height());
    let mut laplacian = Moments::default();
    for y in 1..height.saturating_sub(1) {
        let (above, row, below) = (image.row(y - 1), image.row(y), image.row(y + 1));
        for x in 1..width.saturating_sub(1) {
            laplacian.add(4.0 * row[x] - row[x - 1] - row[x + 1] - above[x] - below[x]);
        }
    }
    let mut levels = Moments::default();
    image.pixels().iter().for_each(|level| levels.add(*level));
    laplacian.variance() / (levels.variance() + 1.0)
}

#[derive(Default)]
struct Moments {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f32) {
        let value = f64::from(value);
        self.count += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    fn variance(&self) -> f64 {
        let count = self.count.max(1.0);
        (self.squares / count - (self.sum / count).powi(2)).max(0.0)
    }
}

/// Mean absolute difference; pictures of different size differ.
fn difference(a: &Image, b: &Image) -> f64 {
    if (a.width(), a.height()) != (b.width(), b.height()) {
        return f64::INFINITY;
    }
    let sum: f32 = a.pixels().iter().zip(b.pixels()).map(|(a, b)| (a - b).abs()).sum();
    f64::from(sum) / a.pixels().len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::messages::Header;
    use landmarkd_core::imaging::encode::png_gray8;

    const SIDE: usize = 64;

    /// Pixels of a seed, each the mean of a square of so many.
    fn file(seed: u32, smear: usize) -> Vec<u8> {
        let gray = |x: usize, y: usize| {
            let mixed = (x as u32 / 2 + 97 * (y as u32 / 2) + 7919 * seed).wrapping_mul(2_654_435_761);
            u32::from((mixed ^ (mixed >> 15)) as u8)
        };
        let around = |x: usize, y: usize| (0..smear * smear).map(move |n| gray(x + n % smear, y + n / smear));
        let smeared = |x: usize, y: usize| around(x, y).sum::<u32>() / (smear * smear) as u32;
        let pixels: Vec<u8> = (0..SIDE * SIDE).map(|i| smeared(i % SIDE, i / SIDE) as u8).collect();
        png_gray8(SIDE, SIDE, &pixels)
    }

    fn picture(n: usize, file: Vec<u8>, pose: Option<MapPose>) -> BagPicture {
        BagPicture { header: Header::default(), stamp_ns: n as i64, file: Ok(file), pose }
    }

    /// The stamps of what is kept, and what was left out.
    fn kept(labels: Labels, pictures: impl IntoIterator<Item = BagPicture>) -> (Vec<i64>, LeftOut) {
        let args = SelectionArgs { min_distance_m: 0.5, min_turn_deg: 15.0 };
        let mut selection = Selection::new(&args, labels);
        let mut chosen: Vec<Chosen> =
            pictures.into_iter().filter_map(|picture| selection.next(picture, 0)).collect();
        chosen.extend(selection.rest());
        (chosen.iter().map(|chosen| chosen.stamp_ns).collect(), selection.left_out)
    }

    fn cells() -> Labels {
        Labels::Cells { prefix: "hall".into(), cell_m: 2.0 }
    }

    fn at(x_m: f64, yaw_deg: f64) -> Option<MapPose> {
        Some(MapPose { x_m, yaw_deg, ..MapPose::default() })
    }

    #[test]
    fn a_picture_is_kept_when_the_camera_has_moved_or_turned() {
        let poses = [(0.0, 0.0), (0.3, 0.0), (0.4, 20.0), (0.45, 20.0), (1.0, 20.0), (1.1, 20.0)];
        let pictures =
            poses.iter().enumerate().map(|(n, &(x, yaw))| picture(n, file(n as u32, 1), at(x, yaw)));
        let (stamps, left_out) = kept(cells(), pictures);
        assert_eq!((stamps, left_out.near_duplicates), (vec![0, 2, 4], 3));
    }

    #[test]
    fn a_blurred_picture_is_left_out_and_the_next_sharp_one_is_taken_instead() {
        let pictures = (0..20).map(|n| {
            let smear = if n == 10 || n == 11 { 9 } else { 1 };
            picture(n, file(n as u32, smear), at(n as f64 * 0.25, 0.0))
        });
        let (stamps, left_out) = kept(cells(), pictures);
        assert_eq!(stamps, [0, 2, 4, 6, 8, 12, 14, 16, 18]);
        // 9 and 13 and the like are too near; 11 is blurred as 10 is
        assert_eq!((left_out.blurred, left_out.near_duplicates), (2, 9));
    }

    #[test]
    fn without_poses_pictures_that_look_the_same_are_left_out() {
        let shown = [1, 1, 1, 2, 2, 3, 1];
        let pictures = shown.iter().enumerate().map(|(n, &seed)| picture(n, file(seed, 1), None));
        let (stamps, left_out) = kept(Labels::One("dock".into()), pictures);
        assert_eq!((stamps, left_out.near_duplicates), (vec![0, 3, 5, 6], 3));
    }

    #[test]
    fn pictures_without_a_label_and_unreadable_ones_are_counted() {
        let mut broken = picture(1, b"no picture".to_vec(), at(9.0, 0.0));
        let unknown =
            BagPicture { file: Err("the encoding".to_owned()), ..picture(2, Vec::new(), at(9.0, 0.0)) };
        broken.stamp_ns = 7;
        let (stamps, left_out) = kept(
            cells(),
            [picture(0, file(0, 1), at(0.0, 0.0)), picture(1, file(1, 1), None), broken, unknown],
        );
        assert_eq!((stamps, left_out.without_pose, left_out.unreadable), (vec![0], 1, 2));
        assert!(left_out.first_reason.is_some());
    }
}
