//! Paper B, section 3: the parts on a table told from the table. Sixteen made scenes of photographed objects on a dark
//! table, the light falling off by up to 45 %, a texture on every second; a photograph of coins in uneven light; and
//! dark parts on a light ground. No seed: every scene is used.

use landmarkd_core::imaging::Image;
use landmarkd_core::statistics::median;
use landmarkd_core::vision::segmentation::{Polarity, SegmentationOptions, Threshold, segmented};

use crate::data;

/// An object that has no region so near is missed.
const NEAR_PX: f64 = 10.0;

/// What came of taking scenes apart.
struct Outcome {
    scenes: usize,
    /// Scenes with as many regions as objects, one near each.
    right: usize,
    /// Scenes that were not, with what was found in them.
    wrong: Vec<String>,
    /// From an object's true centroid to that of the nearest region, if it has one; in rising order.
    errors_px: Vec<f64>,
    missed: usize,
}

impl Outcome {
    fn of(scenes: &[data::Table], options: &SegmentationOptions) -> Outcome {
        let mut outcome =
            Outcome { scenes: scenes.len(), right: 0, wrong: Vec::new(), errors_px: Vec::new(), missed: 0 };
        for scene in scenes {
            let found = segmented(&scene.picture, options);
            let nearest = scene.centroids_px.iter().map(|[x, y]| {
                let regions = found.regions.iter();
                let apart_px = regions.map(|r| (r.centroid_px[0] - x).hypot(r.centroid_px[1] - y));
                apart_px.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, apart)| *apart < NEAR_PX)
            });
            let nearest: Vec<Option<(usize, f64)>> = nearest.collect();
            let mut taken: Vec<usize> = nearest.iter().flatten().map(|(region, _)| *region).collect();
            taken.sort_unstable();
            taken.dedup();
            let objects = scene.centroids_px.len();
            outcome.missed += nearest.iter().filter(|nearest| nearest.is_none()).count();
            outcome.errors_px.extend(nearest.iter().flatten().map(|(_, apart_px)| apart_px));
            if found.found == objects && taken.len() == objects {
                outcome.right += 1;
            } else {
                let (name, regions) = (&scene.name, found.found);
                outcome
                    .wrong
                    .push(format!("{name}: {regions} regions, {} of {objects} objects", taken.len()));
            }
        }
        outcome.errors_px.sort_by(f64::total_cmp);
        outcome
    }

    fn median_px(&self) -> f64 {
        median(&mut self.errors_px.clone(), f64::total_cmp).expect("there are errors")
    }

    fn worst_px(&self) -> f64 {
        self.errors_px[self.errors_px.len() - 1]
    }

    fn say(&self, name: &str) {
        let Outcome { right, scenes, missed, .. } = self;
        let (median_px, worst_px) = (self.median_px(), self.worst_px());
        println!(
            "{name}: counts right {right} of {scenes}, centroids off by {median_px:.2} px in the median, \
             {worst_px:.2} px at worst, {missed} missed"
        );
        self.wrong.iter().for_each(|wrong| println!("    {wrong}"));
    }
}

fn with(threshold: Threshold) -> SegmentationOptions {
    SegmentationOptions { threshold, ..SegmentationOptions::default() }
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn every_object_of_the_made_scenes_is_found_and_nothing_else() {
    let folder = data::folder();
    let outcome = Outcome::of(&data::made_tables(&folder), &SegmentationOptions::default());
    outcome.say("made scenes");
    assert_eq!((outcome.right, outcome.scenes), (16, 16));
    assert!(outcome.median_px() <= 1.0, "{}", outcome.median_px());
    assert!(outcome.worst_px() <= 2.5, "{}", outcome.worst_px());
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn every_coin_is_found_in_uneven_light() {
    let folder = data::folder();
    let coins = data::coins(&folder);
    assert_eq!(coins.centroids_px.len(), 24);
    let outcome = Outcome::of(&[coins], &SegmentationOptions::default());
    outcome.say("coins");
    assert_eq!(outcome.right, 1, "{:?}", outcome.wrong);
    // the reference was read by eye, to 3 px
    assert!(outcome.worst_px() <= 3.0, "{}", outcome.worst_px());
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn dark_propellers_on_a_light_ground_are_found() {
    let folder = data::folder();
    let picture: Image = data::propellers(&folder);
    let options = SegmentationOptions { polarity: Polarity::DarkOnLight, ..SegmentationOptions::default() };
    let found = segmented(&picture, &options);
    for region in &found.regions {
        println!("propellers: {region:?}");
    }
    assert_eq!(found.regions.iter().filter(|region| !region.touches_border).count(), 6);
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn no_other_threshold_counts_right_more_often_than_the_default_and_otsu_far_less() {
    let folder = data::folder();
    let scenes = data::made_tables(&folder);
    let of = |name: &str, options: SegmentationOptions| {
        let outcome = Outcome::of(&scenes, &options);
        outcome.say(name);
        outcome
    };
    let default = of("adaptive", SegmentationOptions::default());
    let narrow =
        SegmentationOptions { window_px: Some(51), offset: Some(12.0), ..SegmentationOptions::default() };
    let narrow = of("adaptive, 51 px and 12 levels", narrow);
    let otsu = of("otsu", with(Threshold::Otsu));
    let fixed = of("fixed at 40", with(Threshold::Fixed(40.0)));
    for other in [&narrow, &otsu, &fixed] {
        assert!(default.right >= other.right);
    }
    assert!(default.worst_px() < otsu.worst_px().min(fixed.worst_px()));
    assert!(otsu.right < 12, "dark objects are lost where one level is between them and light ones");
}
