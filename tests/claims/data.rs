//! The real pictures: turntable objects, photographs, frames of a walk through a building, tables with parts.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use landmarkd_core::imaging::{DecodeLimits, Frame, Image, decode};
use serde_json::Value;

/// The data folder; panics when the variable isn't set.
pub fn folder() -> PathBuf {
    env::var_os("LANDMARKD_DATA").expect("LANDMARKD_DATA names the folder of the pictures").into()
}

fn read(path: &Path) -> Frame {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    decode(&bytes, &DecodeLimits::default()).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// An object of COIL-20 (1..=20) at a pose that is a multiple of 5 degrees: gray, 128 × 128, on black.
pub fn coil_20(folder: &Path, object: usize, pose_deg: usize) -> Image {
    read(&folder.join(format!("coil-20/images/obj{object}__{}.png", pose_deg / 5))).luminance
}

/// All photographs, gray, in the order of their names.
pub fn photographs(folder: &Path) -> Vec<Image> {
    let listed = fs::read_dir(folder.join("backgrounds")).expect("the photographs are there");
    let mut paths: Vec<PathBuf> = listed.map(|entry| entry.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "png" || e == "jpg"));
    paths.sort();
    paths.iter().map(|path| read(path).luminance).collect()
}

/// The corridor, walked twice: frames of the first walk, frames of the second, and for each of these which of the
/// first show the same place. Gray, 160 × 120.
pub struct Corridor {
    pub first: Vec<Frame>,
    pub second: Vec<Frame>,
    pub same: Vec<Vec<usize>>,
}

/// See [`Corridor`].
pub fn corridor(folder: &Path) -> Corridor {
    let root = folder.join("vpr-corridor");
    let walk = |name: &str| {
        let listed = fs::read_dir(root.join(name)).expect("the walk is there");
        let mut paths: Vec<PathBuf> = listed.map(|entry| entry.expect("an entry").path()).collect();
        paths.retain(|path| path.extension().is_some_and(|e| e == "jpg"));
        paths.sort();
        paths.iter().map(|path| Frame::gray(read(path).luminance)).collect()
    };
    let table = fs::read_to_string(root.join("ground_truth.csv")).expect("the table is there");
    let same = table.lines().skip(1).map(|line| {
        let (_, places) = line.split_once(',').expect("two columns");
        places.split_whitespace().map(|place| place.parse().expect("a number")).collect()
    });
    Corridor { first: walk("ref"), second: walk("query"), same: same.collect() }
}

/// One clip of the tower: its frames, one a second.
pub struct Clip {
    frames: BTreeMap<u32, PathBuf>,
}

impl Clip {
    /// The second in the middle of the clip.
    pub fn middle_s(&self) -> u32 {
        let seconds: Vec<&u32> = self.frames.keys().collect();
        *seconds[seconds.len() / 2]
    }

    /// The frame of a second, if the clip has it.
    pub fn frame(&self, second: u32) -> Option<Frame> {
        self.frames.get(&second).map(|path| read(path))
    }
}

/// The longest clips of the tower, in the order of their names; of equally long ones the first by name.
pub fn tower_clips(folder: &Path, count: usize) -> Vec<Clip> {
    let root = folder.join("vpr-ie-tower");
    let table = fs::read_to_string(root.join("ground_truth.csv")).expect("the table is there");
    let mut clips: BTreeMap<&str, BTreeMap<u32, PathBuf>> = BTreeMap::new();
    for line in table.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [image, _floor, clip, second, ..] = fields[..] else { panic!("not a row: {line}") };
        let second = second.trim().parse().expect("a second");
        clips.entry(clip).or_default().insert(second, root.join(image));
    }
    let mut longest: Vec<_> = clips.into_iter().collect();
    longest.sort_by_key(|(name, frames)| (std::cmp::Reverse(frames.len()), *name));
    longest.truncate(count);
    longest.sort_by_key(|(name, _)| *name);
    longest.into_iter().map(|(_, frames)| Clip { frames }).collect()
}

/// A table with objects.
pub struct Table {
    pub name: String,
    pub picture: Frame,
    /// Of its objects, x and y.
    pub centroids_px: Vec<[f64; 2]>,
}

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn point(value: &Value) -> [f64; 2] {
    [0, 1].map(|axis| value[axis].as_f64().expect("a coordinate"))
}

/// The sixteen scenes made of photographed objects, in the order of their names.
pub fn made_tables(folder: &Path) -> Vec<Table> {
    let root = folder.join("segmentation/composites");
    let truth = json(&root.join("ground_truth.json"));
    let scenes = list(&truth).iter().map(|scene| {
        let name = scene["image"].as_str().expect("a name").to_owned();
        let picture = read(&root.join(&name));
        let objects = list(&scene["objects"]).iter();
        Table { name, picture, centroids_px: objects.map(|object| point(&object["centroid_xy"])).collect() }
    });
    scenes.collect()
}

/// The photograph of coins, with their centres.
pub fn coins(folder: &Path) -> Table {
    let root = folder.join("segmentation/real");
    let truth = json(&root.join("coins_reference.json"));
    let centroids_px = list(&truth["centroids_xy"]).iter().map(point).collect();
    Table { name: "coins".to_owned(), picture: read(&root.join("coins.png")), centroids_px }
}

/// The photograph of six dark propellers on a light ground, gray.
pub fn propellers(folder: &Path) -> Image {
    read(&folder.join("segmentation/real/pca_test1.jpg")).luminance
}
