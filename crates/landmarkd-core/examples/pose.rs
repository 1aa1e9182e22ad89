//! Which object is this, and how is it turned? Learns views named `<label>/…__<degrees>.png` and asks about one more,
//! without a server.
//!
//! ```sh
//! cargo run --release --example pose -- views part.png
//! ```

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, bail};
use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
use landmarkd_core::recognition::objects::{
    Normaliser, ObjectOptions, View, ViewName, common_step_deg, train,
};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<PathBuf> = env::args_os().skip(1).map(PathBuf::from).collect();
    let [views, picture] = &arguments[..] else { bail!("usage: pose VIEWS PICTURE") };
    let options = ObjectOptions::default();
    let picture = read(picture)?;

    // All pictures become vectors on one normaliser; here it has the size of the picture that is asked about.
    let mut names = Vec::new();
    for label in files(views)? {
        for view in files(&label)? {
            let folder = label.file_name().context("a label has a name")?.to_string_lossy().into_owned();
            let name =
                ViewName { id: view.display().to_string(), label: folder, pose_deg: pose_in_name(&view) };
            names.push((view, name));
        }
    }
    let step_deg = common_step_deg(names.iter().map(|(_, name)| (name.label.as_str(), name.pose_deg)));
    let size_px = (picture.width() as u32, picture.height() as u32);
    let normaliser = Normaliser::new(&options, size_px).with_step_deg(step_deg);
    let mut learnt = Vec::new();
    for (view, name) in names {
        // All views are shown again, disturbed, for the confidence.
        learnt.push(View::new(&normaliser, name, &read(&view)?, true)?);
    }
    let (model, report) = train(learnt, &normaliser, &options)?;
    println!("{} views, {} dimensions", report.exemplars, model.dimension());

    let recognition = model.recognise(&picture, |_stage| ())?;
    match &recognition.decision {
        None => {
            let why =
                recognition.reasons.iter().map(|reason| format!("{}: {}", reason.detail(), reason.remedy()));
            println!("unknown; {}", why.collect::<Vec<_>>().join("; "));
        }
        Some(decision) => match decision.pose {
            Some(pose) if pose.reliable => {
                println!("{} turned by {:.1}° ± {:.1}°", decision.label, pose.turn_deg, pose.sigma_deg);
            }
            Some(pose) => {
                println!("{} perhaps turned by {:.1}°: don't act on it", decision.label, pose.turn_deg)
            }
            None => println!("{} without a pose", decision.label),
        },
    }
    Ok(())
}

/// `mug__30.png` is turned by 30°.
fn pose_in_name(path: &Path) -> Option<f64> {
    path.file_stem()?.to_str()?.rsplit_once("__")?.1.parse().ok()
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
