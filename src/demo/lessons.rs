//! What the demo learns and what it then asks: drawn rooms and objects, each learned from one picture, and seen again
//! turned, moved, covered and in clutter; one of each is never learned and asked about all the same. Every view is drawn anew from its scene; all choices come from seeds.

use super::drawing::{Outline, Paint, Picture, Scene, View, hash};
use super::objects::{clutter, objects, table};
use super::rooms::rooms;
use landmarkd_core::imaging::encode::png_rgb8;

const ROOM_WIDTH_PX: usize = 320;
const ROOM_HEIGHT_PX: usize = 240;
const OBJECT_PX: usize = 192;
/// Wider than the picture an object is learned from, so that no turn cuts it off.
const SEARCH_PX: usize = 240;

/// The room and the object of this number are never learned.
const NEVER_LEARNED: usize = 3;
/// What views of these are called.
const STRANGE: &str = "never learned";

/// A picture that is learned.
pub struct Exemplar {
    pub label: String,
    /// How the thing is turned, if it stands on a turntable.
    pub pose_deg: Option<f64>,
    pub png: Vec<u8>,
}

/// A picture that is asked about.
pub struct Question {
    /// What was done to it.
    pub view: String,
    /// What it shows; `None`: nothing that was learned.
    pub shown: Option<String>,
    pub png: Vec<u8>,
}

/// A database to fill, and what to ask it.
pub struct Lesson {
    pub database: &'static str,
    pub exemplars: Vec<Exemplar>,
    pub questions: Vec<Question>,
}

/// The rooms: seen again tilted from another spot, and with half of the view covered.
pub fn room_lesson() -> Lesson {
    let straight = View::of(ROOM_WIDTH_PX as f32 / 2.0, ROOM_HEIGHT_PX as f32 / 2.0);
    let cloth = Scene::default().shape((0.0, 0.0), 0.0, Outline::HalfPlane, Paint::Plain([12.0; 3]));
    let mut lesson = Lesson { database: "demo-rooms", exemplars: Vec::new(), questions: Vec::new() };
    for (n, (label, scene)) in rooms().into_iter().enumerate() {
        let choice = |salt: u32| 2.0 * hash(500 + salt, n as i32, 0) - 1.0;
        let elsewhere = |k: u32| View {
            x: straight.x + 12.0 * choice(4 * k),
            y: straight.y + 8.0 * choice(4 * k + 1),
            turn_deg: 15.0 * choice(4 * k + 2),
            scale: 1.0 + 0.05 * choice(4 * k + 3),
        };
        let drawn = |layers: Vec<(&Scene, View)>, seed: u32| {
            let picture = Picture { width_px: ROOM_WIDTH_PX, height_px: ROOM_HEIGHT_PX, layers, seed };
            png_rgb8(ROOM_WIDTH_PX, ROOM_HEIGHT_PX, &picture.draw())
        };
        let learned = n != NEVER_LEARNED;
        let mut ask = |view: &str, png| {
            let (view, shown) = if learned { (view, Some(label.into())) } else { (STRANGE, None) };
            lesson.questions.push(Question { view: view.into(), shown, png });
        };
        let seed = 8 * n as u32;
        if learned {
            let png = drawn(vec![(&scene, straight)], seed);
            lesson.exemplars.push(Exemplar { label: label.into(), pose_deg: None, png });
        }
        ask("tilted, from elsewhere", drawn(vec![(&scene, elsewhere(0))], seed + 2));
        // the line goes through the centre: half of the view is behind it
        let covered = View { turn_deg: 180.0 * choice(8), ..View::of(0.0, 0.0) };
        ask("tilted, half covered", drawn(vec![(&scene, elsewhere(1)), (&cloth, covered)], seed + 4));
    }
    lesson
}

/// The objects: seen again turned, with a third covered, and in clutter.
pub fn object_lesson() -> Lesson {
    let table = table();
    let cloth = Scene::default().shape(
        (0.0, 0.0),
        0.0,
        Outline::HalfPlane,
        Paint::Clouds { colours: [[150.0, 140.0, 120.0], [190.0, 180.0, 160.0]], size: 30.0, seed: 600 },
    );
    let mut lesson = Lesson { database: "demo-objects", exemplars: Vec::new(), questions: Vec::new() };
    for (n, (label, scene)) in objects().into_iter().enumerate() {
        let choice = |salt: u32| 2.0 * hash(700 + salt, n as i32, 0) - 1.0;
        // the scene's point (x, y) comes to the centre: moving that moves the object
        let turned = |k: u32| View {
            x: 14.0 * choice(3 * k),
            y: 14.0 * choice(3 * k + 1),
            turn_deg: 180.0 * choice(3 * k + 2),
            scale: 1.0,
        };
        let ground = View::of(0.0, 0.0);
        let drawn = |side_px: usize, layers: Vec<(&Scene, View)>, seed: u32| {
            png_rgb8(
                side_px,
                side_px,
                &Picture { width_px: side_px, height_px: side_px, layers, seed }.draw(),
            )
        };
        let learned = n != NEVER_LEARNED;
        let mut ask = |view: &str, png| {
            let (view, shown) = if learned { (view, Some(label.into())) } else { (STRANGE, None) };
            lesson.questions.push(Question { view: view.into(), shown, png });
        };
        let seed = 100 + 8 * n as u32;
        if learned {
            let png = drawn(OBJECT_PX, vec![(&table, ground), (&scene, ground)], seed);
            lesson.exemplars.push(Exemplar { label: label.into(), pose_deg: None, png });
        }
        ask("turned", drawn(SEARCH_PX, vec![(&table, ground), (&scene, turned(0))], seed + 2));
        // the line passes at a third of a typical radius of 60 px, which leaves about a third behind it
        let aside = View { x: -18.0, y: 0.0, turn_deg: 0.0, scale: 1.0 };
        let cover = View { turn_deg: 180.0 * choice(9), ..aside };
        let layers = vec![(&table, ground), (&scene, View { x: 0.0, y: 0.0, ..turned(1) }), (&cloth, cover)];
        ask("turned, a third covered", drawn(SEARCH_PX, layers, seed + 4));
        let things = clutter(800 + 40 * n as u32);
        ask("turned, in clutter", drawn(SEARCH_PX, vec![(&things, ground), (&scene, turned(2))], seed + 6));
    }
    lesson
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::imaging::{DecodeLimits, Frame, decode};
    use landmarkd_core::recognition::landmarks::{ExemplarName, LandmarkOptions, Landmarks, describe};

    fn frame(png: &[u8]) -> Frame {
        decode(png, &DecodeLimits::default()).unwrap()
    }

    /// How many questions about what was learned the core answers right with its default options.
    fn right(lesson: &Lesson) -> usize {
        let options = LandmarkOptions::default();
        let described = lesson.exemplars.iter().map(|exemplar| {
            let name = ExemplarName { id: exemplar.label.clone(), label: exemplar.label.clone() };
            describe(name, &frame(&exemplar.png), &options)
        });
        let (model, _) = Landmarks::train(described.collect(), &options).unwrap();
        let mut right = 0;
        for Question { view, shown, png } in &lesson.questions {
            let Some(shown) = shown else { continue };
            let votes = model.recognise(&frame(png), |_| ()).votes;
            println!("{view}: {shown} taken for {} with {:.2} of W", votes[0].label, votes[0].share);
            right += usize::from(&votes[0].label == shown);
        }
        right
    }

    #[test]
    fn drawn_rooms_are_recognised_tilted_and_half_covered() {
        assert_eq!(right(&room_lesson()), 14);
    }

    #[test]
    fn drawn_objects_are_recognised_turned_covered_and_in_clutter() {
        assert!(right(&object_lesson()) >= 20, "of 21");
    }
}
