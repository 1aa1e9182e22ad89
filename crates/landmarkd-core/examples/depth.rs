//! How far is it? Measures a near- and a far-focused picture of a telecentric rig, without a server, and writes the
//! distances as an array.
//!
//! ```sh
//! cargo run --release --example depth -- near.png far.png depth.npy
//! ```

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, anyhow, bail};
use landmarkd_core::depth::{
    Aperture, Calibration, DepthOptions, Estimator, FocalPair, Optics, OpticsSpec, Pair, Sensor,
};
use landmarkd_core::imaging::npy::npy_f32;
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [near, far, out] = &arguments[..] else { bail!("usage: depth NEAR FAR OUT.npy") };
    // The rig: put your own camera's figures here.
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
    })
    .map_err(|faults| anyhow!("the optics can't be: {faults:?}"))?;
    println!("between {:.0} and {:.0} mm", optics.near_focus_mm(), optics.far_focus_mm());

    let estimator = Estimator::new(&Calibration::of(optics), &DepthOptions::default())?;
    let pair = FocalPair::new(read(near)?, read(far)?, 8)?;
    let map = estimator.estimate(&pair, &mut |_stage| ())?;
    match map.summary.depth {
        Some(depth) => println!(
            "{:.1} to {:.1} mm, half of it beyond {:.1} mm; {:.0} % of the pixels",
            depth.min,
            depth.max,
            depth.median,
            100.0 * map.summary.coverage
        ),
        None => println!("nothing could be measured {:?}", map.summary.warnings),
    }
    let npy = npy_f32(&[map.height(), map.width()], map.depth_mm().iter().copied());
    fs::write(out, npy).with_context(|| format!("can't write {}", out.display()))
}

fn read(path: &Path) -> anyhow::Result<Frame> {
    let bytes = fs::read(path).with_context(|| format!("can't read {}", path.display()))?;
    decode(&bytes, &DecodeLimits::default()).with_context(|| format!("{} is no picture", path.display()))
}
