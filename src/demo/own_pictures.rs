//! A data set of a user's own pictures: trained on as they are, queried turned by three angles and with a third covered.

use std::fs;
use std::path::Path;

use super::DemoError;
use super::data_sets::DataSet;
use super::drawing::hash;
use crate::database::Name;
use crate::evaluate::labelled_files;
use landmarkd_core::imaging::encode::{png_gray8, png_rgb8};
use landmarkd_core::imaging::{DecodeLimits, Frame, Image, decode};

/// Longer pictures are shrunk by a whole factor, exemplars and queries alike: a turned view is sent as PNG, and four of
/// each are made.
const LONGEST_SIDE_PX: usize = 1024;
/// How often each picture is turned.
const TURNS: u32 = 3;

/// The data set of a folder `<label>/*`, and which files were left out, with the reasons.
///
/// # Errors
/// [`DemoError`] for a folder without pictures.
pub fn own_data_set(folder: &Path) -> Result<(DataSet, Vec<String>), DemoError> {
    let files = labelled_files(folder).map_err(|source| DemoError::Pictures { source })?;
    let mut set = DataSet::new("demo-own-pictures");
    let mut left_out = Vec::new();
    for (n, file) in files.into_iter().enumerate() {
        let label = file.label.unwrap_or_default();
        match name_and_frame(&label, &file.path) {
            Err(reason) => left_out.push(format!("{}: {reason}", file.path.display())),
            Ok(frame) => add(&mut set, n as i32, &label, &frame),
        }
    }
    if set.exemplars.is_empty() {
        return Err(DemoError::NothingLearned { path: folder.to_path_buf() });
    }
    Ok((set, left_out))
}

/// The frame of a file whose folder can be a label.
fn name_and_frame(label: &str, path: &Path) -> Result<Frame, String> {
    Name::parse(label).map_err(|error| format!("the folder {label:?} {error}"))?;
    let bytes = fs::read(path).map_err(|error| error.to_string())?;
    let frame = decode(&bytes, &DecodeLimits::default()).map_err(|error| error.to_string())?;
    Ok(shrunk(frame))
}

fn add(set: &mut DataSet, n: i32, label: &str, frame: &Frame) {
    set.add_exemplar(label, png(frame));
    for turn in 0..TURNS {
        set.add_query("turned", label, png(&frame.turned(360.0 * f64::from(hash(900 + turn, n, 0)))));
    }
    set.add_query("a third covered", label, png(&covered(frame, (4.0 * hash(950, n, 0)) as usize)));
}

fn png(frame: &Frame) -> Vec<u8> {
    let (width, height) = (frame.width(), frame.height());
    match frame.is_colour() {
        true => png_rgb8(width, height, &frame.to_rgb8()),
        false => png_gray8(width, height, &frame.luminance.to_gray8()),
    }
}

fn each_plane(frame: &Frame, change: impl Fn(&Image) -> Image) -> Frame {
    match &frame.rgb {
        Some(planes) => Frame::colour(planes.each_ref().map(change)),
        None => Frame::gray(change(&frame.luminance)),
    }
}

/// Black from one of the four sides, a third of the way.
fn covered(frame: &Frame, side: usize) -> Frame {
    let (width, height) = (frame.width(), frame.height());
    let hidden = |x: usize, y: usize| match side {
        0 => 3 * x < width,
        1 => 3 * x >= 2 * width,
        2 => 3 * y < height,
        _ => 3 * y >= 2 * height,
    };
    each_plane(frame, |plane| {
        Image::from_fn(width, height, |x, y| if hidden(x, y) { 0.0 } else { plane.at(x, y) })
    })
}

/// Each pixel the mean of a square of pixels, so many that no side is longer than [`LONGEST_SIDE_PX`].
fn shrunk(frame: Frame) -> Frame {
    let factor = frame.width().max(frame.height()).div_ceil(LONGEST_SIDE_PX);
    if factor <= 1 {
        return frame;
    }
    let (width, height) = ((frame.width() / factor).max(1), (frame.height() / factor).max(1));
    each_plane(&frame, |plane| {
        Image::from_fn(width, height, |x, y| {
            let rows = (y * factor..(y + 1) * factor).filter(|&row| row < plane.height());
            let (mut sum, mut count) = (0.0, 0.0_f32);
            for row in rows {
                let end = ((x + 1) * factor).min(plane.width());
                sum += plane.row(row)[x * factor..end].iter().sum::<f32>();
                count += (end - x * factor) as f32;
            }
            sum / count
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_own_picture_makes_three_turned_queries_and_a_covered_one() {
        let folder = tempfile::tempdir().unwrap();
        let write = |file: &str, bytes: &[u8]| {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        };
        write("hall/a.png", &png_gray8(30, 12, &[200; 360]));
        write("lab/b.png", &png_rgb8(6, 6, &[90; 108]));
        write("lab/broken.png", b"no picture");
        write("no label/c.png", &png_gray8(1, 1, &[0]));
        let (set, left_out) = own_data_set(folder.path()).unwrap();
        let labels: Vec<&str> = set.exemplars.iter().map(|e| e.label.as_str()).collect();
        assert_eq!((labels, set.queries.len(), left_out.len()), (vec!["hall", "lab"], 8, 2));
        let covered = decode(&set.queries[3].png, &DecodeLimits::default()).unwrap();
        let black = covered.luminance.pixels().iter().filter(|v| **v == 0.0).count();
        assert_eq!((black, covered.is_colour()), (120, false));
        fs::remove_dir_all(folder.path().join("hall")).unwrap();
        fs::remove_file(folder.path().join("lab/b.png")).unwrap();
        assert!(matches!(own_data_set(folder.path()), Err(DemoError::NothingLearned { .. })));
    }

    #[test]
    fn long_pictures_are_shrunk_to_means() {
        let wide = Image::from_fn(2500, 2, |x, _| (x % 3) as f32);
        let frame = shrunk(Frame::gray(wide));
        assert_eq!((frame.width(), frame.height()), (833, 1));
        assert!(frame.luminance.pixels().iter().all(|v| (v - 1.0).abs() < 1e-6));
        let small = Frame::gray(Image::from_fn(5, 1024, |x, _| x as f32));
        assert_eq!(shrunk(small.clone()), small);
    }
}
