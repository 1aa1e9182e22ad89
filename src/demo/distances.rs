//! The fourth act: scenes of known depth are photographed twice, focused near and far, and the service is asked how far
//! away everything is. The map that it sends is held against the truth.

use std::io::Write;
use std::path::Path;

use serde_json::json;

use super::DemoError;
use super::client::Server;
use super::write_file;
use crate::evaluate::depth::{DepthErrors, DepthPair, Plane};
use landmarkd_core::depth::scene::{Camera, Relief, Rendered, Scene, Texture};
use landmarkd_core::depth::{Aperture, NearSensor, Optics, OpticsSpec};

/// The folder of the fourth act's pictures.
pub const FOLDER: &str = "demo-depth";
/// The lens: 35 mm, f/8, with a telecentric stop, focused at half a metre.
const FOCAL_LENGTH_MM: f64 = 35.0;
const F_NUMBER: f64 = 8.0;
const NEAR_FOCUS_MM: f64 = 500.0;
/// The two sensors: how far one stands behind the other, and their pixels.
const PLANE_SEPARATION_MM: f64 = 0.4;
const PIXEL_PITCH_UM: f64 = 10.0;

/// The scenes: their folders, what they are called, and how they are made.
const SCENES: [(&str, &str, Relief, Texture); 3] = [
    ("floor", "a slanted floor of gravel", Relief::Slant, Texture::Gravel),
    ("hollow", "a cone of grass", Relief::Cone, Texture::Grass),
    ("ball", "a ball before a wall", Relief::Sphere, Texture::Gravel),
];

/// How a scene was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredScene {
    /// The folder of its pictures.
    folder: &'static str,
    pub scene: &'static str,
    /// Part of the pixels that have a depth, as the service says.
    pub coverage: f64,
    /// Of the pixels that have one.
    pub errors: DepthErrors,
}

fn camera() -> Camera {
    let spec = OpticsSpec {
        focal_length_mm: FOCAL_LENGTH_MM,
        aperture: Aperture::FNumber(F_NUMBER),
        near_sensor: NearSensor::FocusMm(NEAR_FOCUS_MM),
        plane_separation_mm: PLANE_SEPARATION_MM,
        pixel_pitch_um: PIXEL_PITCH_UM,
        telecentric: true,
        principal_point_px: None,
    };
    Camera::new(Optics::new(&spec).expect("the demo's lens can be"))
}

/// The same lens in the words of the contract.
fn optics() -> String {
    json!({
        "focal_length_mm": FOCAL_LENGTH_MM, "f_number": F_NUMBER, "near_focus_mm": NEAR_FOCUS_MM,
        "plane_separation_mm": PLANE_SEPARATION_MM, "pixel_pitch_um": PIXEL_PITCH_UM, "telecentric": true,
    })
    .to_string()
}

/// Photograph, ask, print a row a scene; pictures, optics and maps go to `folder`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, sends no map, or a file can't be written.
pub async fn measure(
    server: &Server,
    folder: &Path,
    out: &mut dyn Write,
) -> Result<Vec<MeasuredScene>, DemoError> {
    let (camera, optics) = (camera(), optics());
    let (near_mm, far_mm) = (camera.optics.near_focus_mm(), camera.optics.far_focus_mm());
    let range_mm = camera.optics.range_mm();
    writeln!(
        out,
        "\n{FOLDER}: two pictures of each scene, focused at {near_mm:.0} and {far_mm:.0} mm, and noise on both"
    )?;
    writeln!(
        out,
        "  {:<28}{:>10}{:>14}{:>17}{:>14}{:>8}",
        "scene", "measured", "RMS error", "of the range", "median", "ms"
    )?;
    let mut measured = Vec::new();
    for (seed, (name, scene, relief, texture)) in (1..).zip(SCENES) {
        let rendered = camera.photograph(&Scene::new(relief, texture, seed));
        let pair = rendered.pngs();
        let summary = server.depth_summary(&pair, &optics).await?;
        let npy = server.depth_map(&pair, &optics, "application/x-npy").await?;
        let preview = server.depth_map(&pair, &optics, "image/png; preview=turbo").await?;
        let [near, far] = &pair;
        let files = [
            ("near.png", &near[..]),
            ("far.png", far),
            ("optics.json", optics.as_bytes()),
            ("depth.npy", &npy),
            ("preview.png", &preview),
        ];
        for (file, bytes) in files {
            write_file(&folder.join(name).join(file), bytes)?;
        }
        let errors = errors(&rendered, &npy, range_mm).ok_or(DemoError::NoMap { scene })?;
        let DepthErrors { rms_mm, rms_percent, median_abs_mm, .. } = errors;
        let (percent, ms) = (100.0 * summary.coverage, summary.measure_ms);
        writeln!(
            out,
            "  {scene:<28}{percent:>8.1} %{rms_mm:>11.2} mm{rms_percent:>15.2} %{median_abs_mm:>11.2} mm{ms:>8.1}"
        )?;
        measured.push(MeasuredScene { folder: name, scene, coverage: summary.coverage, errors });
    }
    Ok(measured)
}

/// The errors of a map against the rendered truth; `None` if it is no map of the scene, or empty.
fn errors(rendered: &Rendered, npy: &[u8], range_mm: f64) -> Option<DepthErrors> {
    let map =
        Plane::of_npy(npy).filter(|map| (map.width, map.height) == (rendered.width, rendered.height))?;
    let pixels: Vec<DepthPair> = (map.values.into_iter().zip(&rendered.depth_mm))
        .map(|(measured_mm, &true_mm)| DepthPair { measured_mm, true_mm, sigma_mm: f64::NAN })
        .collect();
    DepthErrors::of(&pixels, range_mm)
}

/// How to see the distances of a scene.
pub fn directions(
    base_url: &str,
    folder: &Path,
    scene: &MeasuredScene,
    out: &mut dyn Write,
) -> Result<(), DemoError> {
    let (base_url, folder) = (base_url.trim_end_matches('/'), folder.join(scene.folder));
    let part =
        |name: &str, mark: char, file: &str| format!("-F '{name}={mark}{}'", folder.join(file).display());
    let parts =
        [part("near", '@', "near.png"), part("far", '@', "far.png"), part("optics", '<', "optics.json")];
    writeln!(
        out,
        "measure distances, and see them in false colours:\n  curl {} \\\n    -H 'Accept: image/png; preview=turbo' \
         -o distances.png '{base_url}/v1/depth-maps'",
        parts.join(" \\\n    ")
    )?;
    Ok(())
}
