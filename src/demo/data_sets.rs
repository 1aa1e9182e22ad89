//! Data sets of databases of landmarks: drawn rooms and objects, one training picture each, and queries that show them
//! turned, moved, covered and in clutter. One room and one object have no training picture: their queries should be
//! answered by "unknown". Every view is drawn from its scene; all choices come from seeds.

use super::drawing::{Paint, Picture, Scene, View, hash};
use super::objects::{clutter, objects, table};
use super::rooms::rooms;
use landmarkd_core::imaging::encode::png_rgb8;

const ROOM_WIDTH_PX: usize = 320;
const ROOM_HEIGHT_PX: usize = 240;
const OBJECT_PX: usize = 192;
/// Wider than an object's training picture, so that no turn cuts the object off.
const SEARCH_PX: usize = 240;

/// The room and the object of this number are shown but not trained on.
const NEVER_LEARNED: usize = 3;
/// The view of the queries that show these.
const UNKNOWN_VIEW: &str = "never learned";

/// A training picture.
pub struct Exemplar {
    pub label: String,
    /// How the thing is turned, if it stands on a turntable.
    pub pose_deg: Option<f64>,
    pub png: Vec<u8>,
}

/// A picture to recognise.
pub struct Query {
    /// What was done to the scene.
    pub view: String,
    /// The true label; `None`: nothing that was trained on.
    pub label: Option<String>,
    pub png: Vec<u8>,
}

/// The contents of a database and what it is asked.
pub struct DataSet {
    pub database: &'static str,
    pub exemplars: Vec<Exemplar>,
    pub queries: Vec<Query>,
}

impl DataSet {
    /// An empty set.
    pub fn new(database: &'static str) -> DataSet {
        DataSet { database, exemplars: Vec::new(), queries: Vec::new() }
    }

    pub fn add_exemplar(&mut self, label: &str, png: Vec<u8>) {
        self.exemplars.push(Exemplar { label: label.into(), pose_deg: None, png });
    }

    /// Adds a query that shows what has the label.
    pub fn add_query(&mut self, view: &str, label: &str, png: Vec<u8>) {
        self.queries.push(Query { view: view.into(), label: Some(label.into()), png });
    }

    /// Adds the scene of a number: its queries, and its exemplar unless it is [`NEVER_LEARNED`].
    fn add_scene(&mut self, number: usize, label: &str, exemplar: Vec<u8>, queries: Vec<(&str, Vec<u8>)>) {
        let is_known = number != NEVER_LEARNED;
        if is_known {
            self.add_exemplar(label, exemplar);
        }
        for (view, png) in queries {
            let view = if is_known { view } else { UNKNOWN_VIEW }.into();
            self.queries.push(Query { view, label: is_known.then(|| label.into()), png });
        }
    }
}

fn drawn(width_px: usize, height_px: usize, layers: Vec<(&Scene, View)>, seed: u32) -> Vec<u8> {
    png_rgb8(width_px, height_px, &Picture { width_px, height_px, layers, seed }.draw())
}

/// The rooms: queries are tilted and from another spot, or have half of the view covered.
pub fn room_data_set() -> DataSet {
    let straight = View::of(ROOM_WIDTH_PX as f32 / 2.0, ROOM_HEIGHT_PX as f32 / 2.0);
    let cloth = Scene::half_plane([12.0; 3]);
    let mut set = DataSet::new("demo-rooms");
    for (n, (label, scene)) in rooms().into_iter().enumerate() {
        let choice = |salt: u32| 2.0 * hash(500 + salt, n as i32, 0) - 1.0;
        let elsewhere = |k: u32| View {
            x: straight.x + 12.0 * choice(4 * k),
            y: straight.y + 8.0 * choice(4 * k + 1),
            turn_deg: 15.0 * choice(4 * k + 2),
            scale: 1.0 + 0.05 * choice(4 * k + 3),
        };
        // the line goes through the centre: half of the view is behind it
        let cover = View { turn_deg: 180.0 * choice(8), ..View::of(0.0, 0.0) };
        let seed = 8 * n as u32;
        let drawn = |layers, seed| drawn(ROOM_WIDTH_PX, ROOM_HEIGHT_PX, layers, seed);
        let tilted = drawn(vec![(&scene, elsewhere(0))], seed + 2);
        let covered = drawn(vec![(&scene, elsewhere(1)), (&cloth, cover)], seed + 4);
        let queries = vec![("tilted, from elsewhere", tilted), ("tilted, half covered", covered)];
        set.add_scene(n, label, drawn(vec![(&scene, straight)], seed), queries);
    }
    set
}

/// The objects: queries are turned, and have a third covered or are in clutter.
pub fn object_data_set() -> DataSet {
    let (table, ground) = (table(), View::of(0.0, 0.0));
    let weave = [[150.0, 140.0, 120.0], [190.0, 180.0, 160.0]];
    let cloth = Scene::half_plane(Paint::Clouds { colours: weave, size: 30.0, seed: 600 });
    let mut set = DataSet::new("demo-objects");
    for (n, (label, scene)) in objects().into_iter().enumerate() {
        let choice = |salt: u32| 2.0 * hash(700 + salt, n as i32, 0) - 1.0;
        // the scene's point (x, y) comes to the centre: moving that moves the object
        let turned = |k: u32| View {
            x: 14.0 * choice(3 * k),
            y: 14.0 * choice(3 * k + 1),
            turn_deg: 180.0 * choice(3 * k + 2),
            scale: 1.0,
        };
        let centred = View { x: 0.0, y: 0.0, ..turned(1) };
        // the line passes at a third of a typical radius of 60 px, which leaves about a third behind it
        let cover = View { turn_deg: 180.0 * choice(9), ..View::of(-18.0, 0.0) };
        let things = clutter(800 + 40 * n as u32);
        let seed = 100 + 8 * n as u32;
        let queries = [
            ("turned", vec![(&table, ground), (&scene, turned(0))]),
            ("turned, a third covered", vec![(&table, ground), (&scene, centred), (&cloth, cover)]),
            ("turned, in clutter", vec![(&things, ground), (&scene, turned(2))]),
        ];
        let queries = (1..)
            .zip(queries)
            .map(|(k, (view, layers))| (view, drawn(SEARCH_PX, SEARCH_PX, layers, seed + 2 * k)));
        let exemplar = drawn(OBJECT_PX, OBJECT_PX, vec![(&table, ground), (&scene, ground)], seed);
        set.add_scene(n, label, exemplar, queries.collect());
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::landmarks::{ExemplarName, LandmarkOptions, Landmarks, describe};

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    /// How many queries about what was trained on the core answers right with its default options.
    fn right(set: &DataSet) -> usize {
        let options = LandmarkOptions::default();
        let described = set.exemplars.iter().map(|exemplar| {
            let name = ExemplarName { id: exemplar.label.clone(), label: exemplar.label.clone() };
            describe(name, &frame(&exemplar.png), &options)
        });
        let (model, _) = Landmarks::train(described.collect(), &options).unwrap();
        let mut right = 0;
        for Query { view, label, png } in &set.queries {
            let Some(label) = label else { continue };
            let votes = model.recognise(&frame(png), |_| ()).votes;
            println!("{view}: {label} taken for {} with {:.2} of W", votes[0].label, votes[0].share);
            right += usize::from(&votes[0].label == label);
        }
        right
    }

    #[test]
    fn drawn_rooms_are_recognised_tilted_and_half_covered() {
        assert_eq!(right(&room_data_set()), 14);
    }

    #[test]
    fn drawn_objects_are_recognised_turned_covered_and_in_clutter() {
        assert!(right(&object_data_set()) >= 20, "of 21");
    }
}
