//! Where was this frame taken? Learns a folder of photographs, `<label>/*`, and asks about one more, without a server.
//!
//! ```sh
//! cargo run --release --example recognise_place -- photos frame.jpg
//! ```

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, bail};
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
use landmarkd_core::recognition::landmarks::{
    ExemplarName, LandmarkOptions, Landmarks, describe, rehearsals,
};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [photos, frame] = &arguments[..] else { bail!("usage: recognise_place PHOTOS FRAME") };
    let options = LandmarkOptions::default();

    // Training: every exemplar is described by its windows, the eigenspace is theirs together.
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

    // How sure is sure enough is learnt from the exemplars, turned, covered and on other ground.
    let (chosen, rounds) = model.rehearsed_exemplars();
    let mut said = Vec::new();
    for round in 0..rounds {
        for exemplar in chosen.iter().map(|&index| &model.exemplars()[index]) {
            let name = ExemplarName { id: exemplar.id.clone(), label: exemplar.label.clone() };
            let shown = rehearsals(&name, &read(Path::new(&exemplar.id))?, round, model.options());
            said.extend(model.rehearse(&name, &shown));
        }
    }
    model.calibrate(&said);

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

/// What a folder holds, by name.
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
