//! Depth from defocus: scenes of known depth are photographed twice, focused near and far, and the service's depth maps
//! are compared with the truth.

use std::io::Write;
use std::path::Path;

use serde_json::json;

use super::DemoError;
use super::client::DepthSummary;
use super::files::write_file;
use crate::client::Server;
use crate::evaluate::depth::{DepthErrors, DepthPair, Plane};
use landmarkd_core::depth::scene::{Camera, Relief, Rendered, Scene, Texture};
use landmarkd_core::depth::{Aperture, Optics, OpticsSpec, Pair, Sensor};

/// The folder of the pictures.
const FOLDER: &str = "demo-depth";
/// The lens: 35 mm, f/8, with a telecentric stop, focused at half a metre.
const FOCAL_LENGTH_MM: f64 = 35.0;
const F_NUMBER: f64 = 8.0;
const NEAR_FOCUS_MM: f64 = 500.0;
/// The two sensors: how far one stands behind the other, and their pixels.
const PLANE_SEPARATION_MM: f64 = 0.4;
const PIXEL_PITCH_UM: f64 = 10.0;

/// The scenes: folder, name, shape, and surface.
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
    /// Its name.
    pub scene: &'static str,
    /// Part of the pixels that have a depth, as the service says.
    pub coverage: f64,
    /// Of the pixels that have one.
    pub errors: DepthErrors,
}

fn camera() -> Camera {
    let spec = OpticsSpec {
        focal_length_mm: FOCAL_LENGTH_MM,
        pair: Pair::Focal {
            aperture: Aperture::FNumber(F_NUMBER),
            near_sensor: Sensor::FocusMm(NEAR_FOCUS_MM),
            plane_separation_mm: PLANE_SEPARATION_MM,
        },
        pixel_pitch_um: PIXEL_PITCH_UM,
        telecentric: true,
        principal_point_px: None,
    };
    Camera::new(Optics::new(&spec).expect("the demo's optics is valid"))
}

/// The same optics as the contract has it.
fn optics() -> String {
    json!({
        "focal_length_mm": FOCAL_LENGTH_MM, "f_number": F_NUMBER, "near_focus_mm": NEAR_FOCUS_MM,
        "plane_separation_mm": PLANE_SEPARATION_MM, "pixel_pitch_um": PIXEL_PITCH_UM, "telecentric": true,
    })
    .to_string()
}

/// Photographs, measures, prints a row a scene; pictures, optics and maps go below `pictures_dir`.
///
/// # Errors
/// [`DemoError`] when the service doesn't answer or refuses, sends no map, or a file can't be written.
pub async fn show(
    server: &Server,
    pictures_dir: &Path,
    out: &mut dyn Write,
) -> Result<Vec<MeasuredScene>, DemoError> {
    let camera = camera();
    let [near_mm, far_mm] = [camera.optics.near_focus_mm(), camera.optics.far_focus_mm()];
    writeln!(
        out,
        "\n{FOLDER}: two pictures of each scene, focused at {near_mm:.0} and {far_mm:.0} mm, and noise on both"
    )?;
    let [measured, rms, of_range, median] = ["measured", "RMS error", "of the range", "median"];
    writeln!(out, "  {:<28}{measured:>10}{rms:>14}{of_range:>17}{median:>14}{:>8}", "scene", "ms")?;
    let mut scenes = Vec::new();
    for (seed, (name, scene, relief, texture)) in (1..).zip(SCENES) {
        let rendered = camera.photograph(&Scene::new(relief, texture, seed));
        let (npy, summary) = measure(server, &rendered, &pictures_dir.join(FOLDER).join(name)).await?;
        let errors = errors(&rendered, &npy, camera.optics.range_mm()).ok_or(DemoError::NoMap { scene })?;
        let DepthErrors { rms_mm, rms_percent, median_abs_mm, .. } = errors;
        let (percent, ms) = (100.0 * summary.coverage, summary.timings_ms.total);
        writeln!(
            out,
            "  {scene:<28}{percent:>8.1} %{rms_mm:>11.2} mm{rms_percent:>15.2} %{median_abs_mm:>11.2} mm{ms:>8.1}"
        )?;
        scenes.push(MeasuredScene { folder: name, scene, coverage: summary.coverage, errors });
    }
    Ok(scenes)
}

/// Measures a scene and keeps its files. Returns the map as an array, and its summary.
async fn measure(
    server: &Server,
    rendered: &Rendered,
    folder: &Path,
) -> Result<(Vec<u8>, DepthSummary), DemoError> {
    let (pair, optics) = (rendered.pngs(), optics());
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
    files.iter().try_for_each(|(name, bytes)| write_file(&folder.join(name), bytes))?;
    Ok((npy, summary))
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

/// Prints the call with curl that measures a scene.
pub fn print_calls(
    base_url: &str,
    pictures_dir: &Path,
    scene: &MeasuredScene,
    out: &mut dyn Write,
) -> Result<(), DemoError> {
    let folder = pictures_dir.join(FOLDER).join(scene.folder);
    let parts = [("near", '@', "near.png"), ("far", '@', "far.png"), ("optics", '<', "optics.json")]
        .map(|(name, mark, file)| format!("-F '{name}={mark}{}'", folder.join(file).display()));
    Ok(writeln!(
        out,
        "measure distances, and see them in false colours:\n  curl {} \\\n    -H 'Accept: image/png; preview=turbo' \
         -o distances.png '{base_url}/v1/depth-maps'",
        parts.join(" \\\n    ")
    )?)
}
