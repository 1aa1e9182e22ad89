//! Where was this frame taken? Trains on a folder of photographs, `<label>/*`, and recognises one more, without a server.
//!
//! ```sh
//! cargo run --release --example recognise_place -- photos frame.jpg
//! ```

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, bail};
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
use landmarkd_core::recognition::landmarks::{
    CalibrationPlan, ExemplarName, LandmarkOptions, Landmarks, calibration_samples, describe, synthetic_views,
};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [photos, frame] = &arguments[..] else { bail!("usage: recognise_place PHOTOS FRAME") };
    let options = LandmarkOptions::default();

    // Training: describes every exemplar by its windows and fits one eigenspace to all of them.
    let mut exemplars = Vec::new();
    for label in files(photos)? {
        for photo in files(&label)? {
            let label = label.file_name().context("a label has a name")?.to_string_lossy().into_owned();
            let name = ExemplarName { id: photo.display().to_string(), label };
            exemplars.push(describe(name, &read(&photo)?, &options));
        }
    }
    let (mut model, report) = Landmarks::train(exemplars, &options)?;
    println!("{} photographs of {} places, {} dimensions", report.exemplars, report.labels, report.dimension);

    // Calibration: synthetic views of the exemplars, turned, occluded and on other backgrounds, tell how confident an
    // answer has to be.
    let plan = CalibrationPlan::of(&model);
    let mut samples = Vec::new();
    for round in 0..plan.rounds {
        for name in plan.exemplars.iter().map(|&index| model.exemplars()[index].name()) {
            let views = synthetic_views(&name, &read(Path::new(&name.id))?, round, model.options());
            samples.extend(calibration_samples(&model, &name, &views));
        }
    }
    model.calibrate(&samples);

    let recognition = model.recognise(&read(frame)?, |_stage| ());
    match &recognition.decision {
        Some(decision) => {
            println!("{} (confidence {:.3})", decision.label, decision.confidence.unwrap_or_default())
        }
        None => println!("unknown {:?}", recognition.warnings),
    }
    for vote in recognition.votes.iter().take(3) {
        println!("  {:<20} {:.0} % of the votes, {} points", vote.label, 100.0 * vote.share, vote.points);
    }
    Ok(())
}

/// The entries of a folder, by name.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| format!("can't list {}", folder.display()))?;
    let mut files = entries.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<Vec<_>>>()?;
    files.sort();
    Ok(files)
}

fn read(path: &Path) -> anyhow::Result<Frame> {
    let bytes = fs::read(path).with_context(|| format!("can't read {}", path.display()))?;
    decode(&bytes, &DecodeLimits::default()).with_context(|| format!("{} is no picture", path.display()))
}
