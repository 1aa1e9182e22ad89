//! The examples do what they say, on pictures drawn here.

#![expect(clippy::unwrap_used, reason = "a test fails where its helpers panic")]

#[path = "api/depth_pictures.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod depth_pictures;
#[path = "api/pictures.rs"]
#[expect(dead_code, reason = "shared with the tests of the API, which use all of it")]
mod pictures;

use std::fs;
use std::path::Path;
use std::process::Command;

use landmarkd_core::depth::scene::Relief;
use pictures::{Thing, png, scene_png, thing};

/// What an example prints.
fn printed(name: &str, folder: &Path, arguments: &[&str]) -> String {
    let built = std::env::current_exe().unwrap();
    // Built beside the tests: target/<profile>/{deps,examples}.
    let example = built.ancestors().nth(2).unwrap().join("examples").join(name);
    assert!(example.exists(), "cargo build --examples makes {}", example.display());
    let run = Command::new(example).current_dir(folder).args(arguments).output().unwrap();
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{name}: {told}");
    String::from_utf8(run.stdout).unwrap()
}

fn write(path: impl AsRef<Path>, bytes: &[u8]) {
    fs::create_dir_all(path.as_ref().parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_place_is_recognised_and_a_strange_one_is_unknown() {
    let folder = tempfile::tempdir().unwrap();
    for place in 1..=6 {
        write(folder.path().join(format!("photos/place-{place}/a.png")), &scene_png(place));
    }
    write(folder.path().join("known.png"), &scene_png(4));
    write(folder.path().join("strange.png"), &scene_png(99));
    let known = printed("recognise_place", folder.path(), &["photos", "known.png"]);
    assert!(
        known.contains("6 photographs of 6 places") && known.contains("\nplace-4 (confidence"),
        "{known}"
    );
    let strange = printed("recognise_place", folder.path(), &["photos", "strange.png"]);
    assert!(strange.contains("\nunknown"), "{strange}");
}

#[test]
fn a_thing_is_named_and_its_turn_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (name, shape) in [("bar", Thing::Bar), ("wedge", Thing::Wedge), ("pair", Thing::Pair)] {
        for turn_deg in (0..360).step_by(10) {
            let view = folder.path().join(format!("views/{name}/{name}__{turn_deg}.png"));
            write(view, &png(&thing(shape, f64::from(turn_deg), 64)));
        }
    }
    write(folder.path().join("part.png"), &png(&thing(Thing::Wedge, 145.0, 64)));
    let told = printed("pose", folder.path(), &["views", "part.png"]);
    let turn = told.split("wedge turned by ").nth(1).and_then(|rest| rest.split('°').next());
    let turn_deg: f64 = turn.unwrap_or_else(|| panic!("{told}")).parse().unwrap();
    assert!((turn_deg - 145.0).abs() < 3.0, "{told}");
}

#[test]
fn a_slanted_plane_is_measured_and_kept_as_an_array() {
    let folder = tempfile::tempdir().unwrap();
    let [near, far] = depth_pictures::pair(Relief::Slant, 3);
    write(folder.path().join("near.png"), &near);
    write(folder.path().join("far.png"), &far);
    let told = printed("depth", folder.path(), &["near.png", "far.png", "depth.npy"]);
    assert!(told.starts_with("between 529 and 74"), "{told}");
    let kept = fs::read(folder.path().join("depth.npy")).unwrap();
    let (width, height) = depth_pictures::SIZE_PX;
    assert!(kept.starts_with(b"\x93NUMPY") && kept.len() > 4 * width * height);
    let coverage = told.split("; ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert!(coverage.parse::<u32>().unwrap() > 60, "{told}");
}
