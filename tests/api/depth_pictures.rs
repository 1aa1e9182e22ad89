//! A rig for the tests, and what its camera sees.

use bytes::Bytes;
use landmarkd_core::depth::scene::{Camera, Relief, Rendered, Scene, Texture};
use landmarkd_core::depth::{Aperture, Optics, OpticsSpec, Pair, Sensor};
use serde_json::{Value, json};

/// Width and height of a picture.
pub const SIZE_PX: (usize, usize) = (128, 96);

/// The rig: focused at 529 and some 743 mm, largest blur 4.6 px.
pub fn optics() -> Value {
    json!({
        "focal_length_mm": 25, "f_number": 2.8, "near_focus_mm": 529, "plane_separation_mm": 0.37,
        "pixel_pitch_um": 29, "telecentric": true,
    })
}

/// What the rig's camera sees of a scene.
pub fn photograph(relief: Relief, seed: u64) -> Rendered {
    photograph_of(SIZE_PX, relief, seed)
}

/// The same in pictures of another width and height.
pub fn photograph_of((width, height): (usize, usize), relief: Relief, seed: u64) -> Rendered {
    let optics = Optics::new(&OpticsSpec {
        focal_length_mm: 25.0,
        pair: Pair::Focal {
            aperture: Aperture::FNumber(2.8),
            near_sensor: Sensor::FocusMm(529.0),
            plane_separation_mm: 0.37,
        },
        pixel_pitch_um: 29.0,
        telecentric: true,
        principal_point_px: None,
    });
    let camera = Camera { width, height, ..Camera::new(optics.unwrap()) };
    camera.photograph(&Scene::new(relief, Texture::Gravel, seed))
}

/// The near- and the far-focused picture of a scene as files.
pub fn pair(relief: Relief, seed: u64) -> [Bytes; 2] {
    photograph(relief, seed).pngs().map(Bytes::from)
}

/// The parts of a form with a pair, and others.
pub fn parts<'a>([near, far]: &[Bytes; 2], others: &[(&'a str, Value)]) -> Vec<(&'a str, Bytes)> {
    let mut parts = vec![("near", near.clone()), ("far", far.clone())];
    parts.extend(others.iter().map(|(name, value)| (*name, text(value))));
    parts
}

/// A value as a part: a name as it is, other things as JSON.
fn text(value: &Value) -> Bytes {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned).into()
}
