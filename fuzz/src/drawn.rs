//! Inputs drawn by code: the same number gives the same bytes.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use landmarkd_core::imaging::encode::{png_gray8, png_rgb8};
use landmarkd_core::imaging::random::Random;
use landmarkd_core::imaging::{Frame, Image};
use serde_json::{Value, json};

/// Side of a scene, in pixels.
pub const SIDE_PX: usize = 24;

/// A scene: boxes of many levels, with a little noise, so that no two lines are equal.
pub fn scene(number: u64) -> Frame {
    let mut random = Random::new(number, 1);
    let mut image = Image::from_fn(SIDE_PX, SIDE_PX, |_, _| 60.0);
    for _ in 0..8 {
        let [x, y, width, height] = [20.0, 20.0, 9.0, 9.0].map(|most| random.between(0.0, most) as usize);
        let level = random.between(0.0, 255.0).floor() as f32;
        for row in y..(y + height + 2).min(SIDE_PX) {
            for column in x..(x + width + 2).min(SIDE_PX) {
                image.pixels_mut()[row * SIDE_PX + column] = level;
            }
        }
    }
    Frame::gray(image)
}

/// A scene as a gray PNG file.
pub fn scene_png(number: u64) -> Vec<u8> {
    let levels: Vec<u8> = scene(number).luminance.pixels().iter().map(|level| *level as u8).collect();
    png_gray8(SIDE_PX, SIDE_PX, &levels)
}

/// A scene as a colour PNG file.
pub fn scene_colour_png(number: u64) -> Vec<u8> {
    png_rgb8(SIDE_PX, SIDE_PX, &scene(number).to_rgb8())
}

/// A scene as a JPEG file.
pub fn scene_jpeg(number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let side = SIDE_PX as u32;
    let encoded = JpegEncoder::new_with_quality(&mut bytes, 80).encode(
        &scene(number).to_rgb8(),
        side,
        side,
        ExtendedColorType::Rgb8,
    );
    encoded.expect("memory takes every byte of a picture");
    bytes
}

/// A rig's optics.
pub fn optics() -> Value {
    json!({
        "focal_length_mm": 25, "f_number": 2.8, "near_focus_mm": 529, "plane_separation_mm": 0.37,
        "pixel_pitch_um": 29, "telecentric": true,
    })
}

/// A workcell over the database `parts`.
pub fn workcell() -> Value {
    let corners = [[1.0, 1.0], [22.0, 1.5], [2.0, 21.0], [23.0, 22.0]];
    let pairs =
        corners.map(|[x, y]| json!({"image_px": [x, y], "robot_mm": [x / 2.0 + 100.0, 300.0 - y / 2.0]}));
    json!({"database": "parts", "calibration": "rig", "correspondences": pairs,
           "local": {"mm_per_px": 0.1, "rotation_deg": 12}})
}

/// The line between the parts of a form.
pub const BOUNDARY: &str = "xx";
/// The media type of a form.
pub const FORM: &str = "multipart/form-data; boundary=xx";

/// A form of parts (name, bytes).
pub fn form(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, bytes) in parts {
        let head = format!(
            "--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"{name}\"; filename=\"{name}.png\"\r\n\r\n"
        );
        body.extend_from_slice(head.as_bytes());
        body.extend_from_slice(bytes);
        body.extend_from_slice(b"\r\n");
    }
    body.extend_from_slice(format!("--{BOUNDARY}--\r\n").as_bytes());
    body
}

/// Length of a header or a block in a tar archive.
const BLOCK_BYTES: usize = 512;

/// A tar archive of files (path, bytes), with checksums.
pub fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = Vec::new();
    for (path, bytes) in files {
        let mut header = [0_u8; BLOCK_BYTES];
        header[..path.len()].copy_from_slice(path.as_bytes());
        header[100..107].copy_from_slice(b"0000644");
        header[124..135].copy_from_slice(format!("{:011o}", bytes.len()).as_bytes());
        header[136..147].copy_from_slice(b"00000000000");
        header[156] = b'0';
        header[257..265].copy_from_slice(b"ustar\x0000");
        archive.extend_from_slice(&header);
        archive.extend_from_slice(bytes);
        archive.resize(archive.len().next_multiple_of(BLOCK_BYTES), 0);
    }
    archive.resize(archive.len() + 2 * BLOCK_BYTES, 0);
    with_checksums(&archive)
}

/// The archive with corrected checksums, of every header that the sizes before it lead to: otherwise no changed header
/// would ever be read.
pub fn with_checksums(archive: &[u8]) -> Vec<u8> {
    let mut corrected = archive.to_vec();
    let mut at = 0;
    while at + BLOCK_BYTES <= corrected.len() {
        let header = &mut corrected[at..at + BLOCK_BYTES];
        if header.iter().all(|byte| *byte == 0) {
            at += BLOCK_BYTES;
            continue;
        }
        header[148..156].fill(b' ');
        let sum: u32 = header.iter().map(|byte| u32::from(*byte)).sum();
        header[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
        let octal = std::str::from_utf8(&header[124..135]).unwrap_or_default();
        let size = usize::from_str_radix(octal.trim_matches(['\0', ' ']), 8).unwrap_or_default();
        let blocks = size.min(corrected.len()).div_ceil(BLOCK_BYTES);
        at += BLOCK_BYTES * (1 + blocks);
    }
    corrected
}
