//! Past paper A, on places: a camera that stays upright. The corridor, walked twice (111 frames each, enlarged to
//! 320 × 240): trained on the first walk, asked with the second, frame by frame and along the walk; 20 places of the
//! tower, one picture each, asked with the frames 1, 2 and 3 seconds away.

use landmarkd_core::imaging::{Frame, Image};
use landmarkd_core::recognition::landmarks::{
    Belief, LandmarkOptions, Landmarks, Method, Motion, Signature, Viewpoint,
};

use crate::composites::cubic;
use crate::data::{self, Corridor};
use crate::places::shrunk;
use crate::trials::{asked, trained};

const PLACES: usize = 20;

fn upright() -> LandmarkOptions {
    LandmarkOptions::with_signature(Method::Placement, Viewpoint::Upright, Signature::Intensity)
}

/// For a corridor that is walked along one line: windows of very different size, seen about where they were.
fn along_a_line() -> LandmarkOptions {
    LandmarkOptions { subwindow_radii_px: vec![10.0, 20.0, 40.0], position_prior_px: Some(40.0), ..upright() }
}

fn doubled(frame: &Frame) -> Frame {
    let small = &frame.luminance;
    let from = |at: usize| (at as f64 - 0.5) / 2.0;
    Frame::gray(Image::from_fn(2 * small.width(), 2 * small.height(), |x, y| {
        let inside = |at: f64, length: usize| at.clamp(0.0, length as f64 - 1.0);
        cubic(small, inside(from(x), small.width()), inside(from(y), small.height())) as f32
    }))
}

/// W of every place of the first walk, by the frames of the second.
fn walked(model: &Landmarks, corridor: &Corridor) -> Vec<Vec<f64>> {
    let place_of: Vec<usize> = model.exemplars().iter().map(|e| e.label.parse().expect("a place")).collect();
    let weights = corridor.second.iter().map(|frame| {
        let mut weights = vec![0.0; place_of.len()];
        let said = model.recognise(&doubled(frame), |_| ()).exemplar_weights;
        place_of.iter().zip(said).for_each(|(&place, weight)| weights[place] = weight);
        weights
    });
    weights.collect()
}

fn best(weights: &[f64]) -> usize {
    (0..weights.len()).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).expect("places")
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn a_corridor_is_recognised_frame_by_frame_and_along_the_walk() {
    let folder = data::folder();
    let corridor = data::corridor(&folder);
    let training: Vec<Frame> = corridor.first.iter().map(doubled).collect();
    let right = |places: &[usize]| {
        places.iter().zip(&corridor.same).filter(|(place, same)| same.contains(place)).count()
    };
    for (name, options, least_single, least_along) in [
        ("gradients", LandmarkOptions::of(Method::Placement, Viewpoint::Upright), 0.85, 0.95),
        ("upright", upright(), 0.63, 0.90),
        ("upright, windows near where they were", along_a_line(), 0.75, 0.98),
    ] {
        let weights = walked(&trained(&training, &options), &corridor);
        let single: Vec<usize> = weights.iter().map(|weights| best(weights)).collect();
        let mut belief = Belief::new(Motion::Path((0..training.len()).collect()), training.len());
        let along: Vec<usize> = weights
            .iter()
            .map(|weights| {
                belief.add(weights);
                best(&belief.probabilities())
            })
            .collect();
        let [single, along] =
            [single, along].map(|places| right(&places) as f64 / corridor.same.len() as f64);
        println!("corridor, {name}: single frames {single:.3}, along the walk {along:.3} of 111");
        assert!(single >= least_single && along >= least_along, "{name}: {single:.3}, {along:.3}");
    }
}

#[test]
#[ignore = "reads real pictures from the folder LANDMARKD_DATA"]
fn rooms_of_the_tower_are_recognised_from_seconds_away() {
    let folder = data::folder();
    let clips = data::tower_clips(&folder, PLACES);
    let gray = |frame: &Frame| shrunk(&Frame::gray(frame.luminance.clone()));
    let training: Vec<Frame> =
        clips.iter().map(|clip| gray(&clip.frame(clip.middle_s()).expect("the middle"))).collect();
    let model = trained(&training, &upright());
    // OpenCV's SIFT with the ratio test on the same frames: 0.80, 0.45, 0.30
    for (gap_s, sift) in [(1, 0.80), (2, 0.45), (3, 0.30)] {
        let frames: Vec<(usize, Frame)> = clips
            .iter()
            .enumerate()
            .flat_map(|(place, clip)| [-gap_s, gap_s].map(|offset_s| (place, clip, offset_s)))
            .filter_map(|(place, clip, offset_s)| {
                Some((place, gray(&clip.frame(clip.middle_s().checked_add_signed(offset_s)?)?)))
            })
            .collect();
        let outcome = asked(&model, &frames);
        outcome.say(&format!("rooms {gap_s} s away, upright"));
        assert!(outcome.rate() >= sift, "{:.3} is below SIFT's {sift}", outcome.rate());
    }
}
