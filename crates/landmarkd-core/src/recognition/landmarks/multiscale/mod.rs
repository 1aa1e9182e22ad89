//! Recognition on a scale space by gradient signatures: what is seen larger, smaller, obliquely or in another light is
//! known again, and the number of false alarms decides (A§6 asks for several scales, and for structure).
//!
//! Working size → scale space → interest points → signatures → nearest eigenpoints → consensus of their matches on place, turn
//! and scale → a similarity or a plane → the number of false alarms.

mod a_contrario;
pub(super) mod asked_frame;
mod consensus;
mod correspondences;
mod decision;
pub(super) mod description;
pub(super) mod encoded_exemplars;
pub(super) mod encoded_windows;
mod hypothesis;
mod instance;
mod matching;
mod mirror;
mod overlap;
pub(super) mod phase_space;
mod placed_template;
#[cfg(test)]
mod planted;
mod ranking;
pub(super) mod vlad;
pub(super) mod window_space;
mod window_votes;

use asked_frame::AskedFrame;
use decision::{decided, likeliest_first};
use description::ScaleSpaceDescriber;
use encoded_windows::EncodedWindows;
use hypothesis::{Hypothesis, HypothesisOptions, hypotheses};
use instance::instances;
use mirror::{AT_A_LOOK, BEYOND_SYMMETRY, CLEARER, EVERY, WORTH_A_LOOK, mirrored};
use ranking::{AskedWindows, Ranking};
use window_votes::WindowVotes;

use super::description::{DescribedExemplar, ExemplarName};
use super::edge_template::edge_points;
use super::model::{Exemplar, Landmarks};
use super::options::{Colour, LandmarkOptions};
use super::recognition::{Recognition, Stage};
use super::search::nearest_but;
use super::vote::label_numbers;
use crate::imaging::Frame;
use crate::vision::gradient_signature::SPECTRUM_LENGTH;
use crate::vision::kept_spectrum;

/// Things that are looked for in one frame at most.
const MOST_INSTANCES: usize = 16;

/// Describes one exemplar. The colour of the options must be resolved.
pub(super) fn describe(name: ExemplarName, frame: &Frame, options: &LandmarkOptions) -> DescribedExemplar {
    let working = options.working_frame(frame);
    let describer = ScaleSpaceDescriber::new(options);
    let attention = describer.attend(&working);
    let batch = describer.describe(&working, &attention, options.interest_points);
    let mut spectra = Vec::with_capacity(batch.spectra.len());
    batch.spectra.chunks_exact(SPECTRUM_LENGTH).for_each(|row| kept_spectrum(row, &mut spectra));
    DescribedExemplar {
        exemplar: Exemplar {
            id: name.id,
            label: name.label,
            width_px: posted_side(frame.width(), frame.reduction),
            height_px: posted_side(frame.height(), frame.reduction),
            windows: batch.windows.len(),
            edges: edge_points(attention.smoothed()),
        },
        windows: batch.windows,
        colour: options.colour == Colour::Opponent,
        signatures: batch.signatures,
        spectra,
    }
}

/// A side of the posted picture.
fn posted_side(side_px: usize, reduction: f32) -> u32 {
    (side_px as f32 * reduction).round() as u32
}

/// Recognises a frame by all exemplars of a database, or without the one of an index. Calls `finished` after each stage.
pub(super) fn recognise_among(
    model: &Landmarks,
    windows: &EncodedWindows,
    held_out: Option<usize>,
    asked: &AskedFrame<'_>,
    mut finished: impl FnMut(Stage),
) -> Recognition {
    let AskedFrame { working, attention, batch } = asked;
    let neighbours = nearest_but(model, batch, held_out); // A§4.1, A§4.5
    finished(Stage::Search);
    let votes = WindowVotes::of(model, windows, batch, &neighbours);
    finished(Stage::Vote);
    let exemplars: Vec<hypothesis::Exemplar> =
        (0..model.exemplars.len()).map(|index| size(model, index)).collect();
    let options = HypothesisOptions {
        least_evidence: model.options.least_evidence(),
        viewpoint: model.options.viewpoint,
        chosen_from: model.chosen_from,
        ..Default::default()
    };
    let size_px = [working.width(), working.height()];
    let weights = votes.overlap.smoothed(&votes.weights);
    let seen = hypothesis::Frame { size_px, matches: &votes.matches };
    let mut found = hypotheses(&exemplars, &seen, &weights, &options);
    likeliest_first(&mut found, options.viewpoint);
    let witness = decided(&found, &label_numbers(&model.exemplars), &votes.overlap, &options).cloned();
    let is_negative = |found: &Hypothesis| model.exemplars[found.exemplar].is_negative();
    let flipped = |every| {
        let batch = mirrored(batch, size_px[0], every);
        let neighbours = nearest_but(model, &batch, held_out);
        let votes = WindowVotes::of(model, windows, &batch, &neighbours);
        let seen = hypothesis::Frame { size_px, matches: &votes.matches };
        hypotheses(&exemplars, &seen, &votes.weights, &options).into_iter().next()
    };
    // what the flipped frame shows for sure, and far clearer
    let clearer = |evidence: f64| {
        let at_a_look = |found: Hypothesis| found.evidence > AT_A_LOOK;
        let is_worth_it = evidence < WORTH_A_LOOK || flipped(EVERY).is_some_and(at_a_look);
        let is_clearer = |found: &Hypothesis| {
            found.is_evident(options.least_evidence) && found.evidence > CLEARER * evidence
        };
        let found = is_worth_it.then(|| flipped(1)).flatten();
        found.filter(|found| is_clearer(found) && !is_negative(found))
    };
    let evidence = witness.as_ref().map(|witness| witness.evidence);
    let mirrored = evidence.filter(|evidence| *evidence < BEYOND_SYMMETRY).and_then(clearer);
    let decided = witness.filter(|_| mirrored.is_none() && !found.first().is_some_and(is_negative));
    let mut instances = match decided {
        Some(_) => all_there(&exemplars, &seen, &weights, &found, &options),
        None => Vec::new(),
    };
    // they only take their windows away from the others
    instances.retain(|instance| !is_negative(instance));
    let ranking = Ranking {
        model,
        working,
        smoothed: attention.smoothed(),
        decided,
        mirrored,
        hypotheses: found,
        instances,
    };
    let windows = AskedWindows {
        batch,
        neighbours: &neighbours,
        matches: &votes.matches,
        points_found: attention.points(),
    };
    let recognition = ranking.recognition(&windows, votes.weights.clone());
    finished(Stage::Verification);
    recognition
}

/// Every thing in the frame, of the exemplars that chance doesn't explain.
fn all_there(
    exemplars: &[hypothesis::Exemplar],
    seen: &hypothesis::Frame<'_>,
    votes: &[f64],
    found: &[Hypothesis],
    options: &HypothesisOptions,
) -> Vec<Hypothesis> {
    let evident = found.iter().filter(|found| found.is_evident(options.least_evidence));
    let mut of_evident = vec![0.0; votes.len()];
    let mut promising = 0;
    for found in evident {
        of_evident[found.exemplar] = votes[found.exemplar];
        promising += 1;
    }
    instances(exemplars, seen, &of_evident, &HypothesisOptions { promising, ..*options }, MOST_INSTANCES)
}

/// What hypotheses need of an exemplar.
fn size(model: &Landmarks, exemplar: usize) -> hypothesis::Exemplar {
    let [width_px, height_px] = model.working_size_px(exemplar).map(|side| side as usize);
    hypothesis::Exemplar { width_px, height_px }
}

#[cfg(test)]
mod tests {
    use super::super::Reason;
    use super::super::homography::Homography;
    use super::super::pictures::{laid, name, wall};
    use super::super::{
        CalibrationPlan, LandmarkOptions, LandmarkParts, Landmarks, Method, Placement, PlainParts,
        TrainingError, Viewpoint, WindowParts, WindowSpace, describe, exemplars_to_leave_out, left_out,
        names_rightly, residual_of, synthetic_views,
    };
    use super::*;
    use crate::imaging::Image;

    /// Walls of 240 × 200 px, each its own label.
    const WALLS: u64 = 6;

    fn picture(seed: u64) -> Image {
        wall(seed, 240, 200)
    }

    fn model_of(pictures: impl Iterator<Item = (String, Image)>, options: &LandmarkOptions) -> Landmarks {
        let described = pictures.enumerate().map(|(number, (label, image))| {
            describe(name(&format!("{label}-{number}"), &label), &Frame::gray(image), options)
        });
        Landmarks::train(described.collect(), options).unwrap().0
    }

    fn trained() -> Landmarks {
        model_of((0..WALLS).map(|seed| (seed.to_string(), picture(seed))), &LandmarkOptions::default())
    }

    /// A frame of 400 × 360 px with a picture at a similarity, on a wall.
    fn shown(image: &Image, placement: Placement) -> Image {
        let mut frame = wall(97, 400, 360);
        put(&mut frame, image, placement);
        frame
    }

    fn put(frame: &mut Image, image: &Image, placement: Placement) {
        let middle = [image.width(), image.height()].map(|side| (side as f64 - 1.0) / 2.0);
        let (sin, cos) = f64::from(placement.rotation_rad).sin_cos();
        laid(frame, image, |x, y| {
            let (dx, dy) = (x - f64::from(placement.x_px), y - f64::from(placement.y_px));
            let scale = f64::from(placement.scale);
            [middle[0] + (cos * dx + sin * dy) / scale, middle[1] + (cos * dy - sin * dx) / scale]
        });
    }

    fn at(x_px: f32, y_px: f32, rotation_rad: f32, scale: f32) -> Placement {
        Placement { x_px, y_px, rotation_rad, scale }
    }

    fn decided(recognition: &Recognition) -> Option<&str> {
        recognition.decision.as_ref().map(|decision| &decision.label[..])
    }

    #[test]
    fn what_is_turned_larger_or_smaller_is_decided_and_placed_without_calibration() {
        let model = trained();
        for (seed, placement) in [
            (0, at(200.0, 180.0, 0.0, 1.0)),
            (1, at(210.0, 170.0, 2.1, 1.3)),
            (2, at(190.0, 190.0, -0.7, 0.7)),
            (3, at(200.0, 180.0, std::f32::consts::PI, 0.5)),
        ] {
            let frame = Frame::gray(shown(&picture(seed), placement));
            let recognition = model.recognise(&frame, |_| ());
            assert_eq!(decided(&recognition), Some(&seed.to_string()[..]), "{placement:?}");
            let found = recognition.votes[0].placement.unwrap();
            let wanted = placement.outline_px(240, 200);
            let off = found
                .outline_px(240, 200)
                .into_iter()
                .zip(wanted)
                .map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
            let worst_px = off.fold(0.0, f32::max);
            assert!(worst_px < 8.0, "{placement:?}: {worst_px} px off");
            assert_eq!(recognition.instances.len(), 1, "{placement:?}");
            let sum: f64 = recognition
                .points
                .iter()
                .map(|p| p.weight * f64::from(u8::from(p.exemplar == found.exemplar)))
                .sum();
            assert!((sum - recognition.votes[0].weight).abs() < 1e-9 * sum);
        }
    }

    #[test]
    fn what_is_seen_obliquely_is_laid_by_a_homography() {
        let model = trained();
        let truth = Homography([[1.2, 0.15, 60.0], [0.05, 1.1, 70.0], [0.0012, 0.0003, 1.0]]);
        let corners = [[0.0, 0.0], [239.0, 0.0], [239.0, 199.0], [0.0, 199.0]];
        let back = Homography::fitted(&corners.map(|corner| (truth.apply(corner), corner))).unwrap();
        let mut frame = wall(98, 400, 360);
        laid(&mut frame, &picture(4), |x, y| back.apply([x, y]));
        let recognition = model.recognise(&Frame::gray(frame), |_| ());
        assert_eq!(decided(&recognition), Some("4"));
        let found = recognition.votes[0].placement.unwrap().homography.unwrap();
        for corner in corners {
            let (a, b) = (found.apply(corner), truth.apply(corner));
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 8.0, "{corner:?}: {a:?} for {b:?}");
        }
    }

    #[test]
    fn what_is_strange_mirrored_or_flat_is_unknown_and_says_why() {
        let model = trained();
        let mirrored = |image: &Image| {
            Image::from_fn(image.width(), image.height(), |x, y| image.at(image.width() - 1 - x, y))
        };
        let strange =
            (40..52).map(|seed| wall(seed, 400, 360)).chain([mirrored(&picture(0)), mirrored(&picture(3))]);
        for (number, frame) in strange.enumerate() {
            let recognition = model.recognise(&Frame::gray(frame), |_| ());
            assert_eq!(decided(&recognition), None, "{number}");
            assert!(recognition.instances.is_empty() && !recognition.reasons.is_empty());
        }
        let flat = model.recognise(&Frame::gray(Image::from_fn(320, 240, |_, _| 3.0)), |_| ());
        let codes: Vec<&str> = flat.reasons.iter().map(|reason| reason.code()).collect();
        assert_eq!(codes, ["too_dark", "little_to_see", "unlike_anything"]);
        assert!(flat.votes.is_empty() && flat.a_contrario.is_none());
    }

    #[test]
    fn a_mirrored_picture_of_what_is_symmetric_in_part_is_said_to_be_mirrored() {
        let partly_symmetric = |seed: u64| {
            let wall = picture(seed);
            Image::from_fn(240, 200, |x, y| wall.at(if y > 135 && x >= 120 { 239 - x } else { x }, y))
        };
        let pictures = (0..WALLS).map(|seed| (seed.to_string(), partly_symmetric(seed)));
        let model = model_of(pictures, &LandmarkOptions::default());
        let mut said = 0;
        for seed in 0..WALLS {
            let picture = partly_symmetric(seed);
            let flipped = Image::from_fn(240, 200, |x, y| picture.at(239 - x, y));
            let asked = |image: &Image| {
                model.recognise(&Frame::gray(shown(image, at(200.0, 180.0, 0.2, 1.0))), |_| ())
            };
            assert_eq!(decided(&asked(&picture)), Some(&seed.to_string()[..]));
            let flipped = asked(&flipped);
            assert_eq!(decided(&flipped), None, "{seed}: {:?}", flipped.a_contrario);
            assert!(flipped.instances.is_empty());
            // where the symmetric part alone is evident, that it is mirrored is the reason
            let evident = flipped.a_contrario.is_some_and(|found| found.log10_false_alarms <= -2.0);
            if evident {
                assert_eq!(flipped.reasons, [Reason::Mirrored { label: seed.to_string() }], "{seed}");
                said += 1;
            }
        }
        assert!(said >= 2, "{said}");
    }

    #[test]
    fn two_of_one_label_and_one_of_another_are_all_found_and_none_twice() {
        let model = trained();
        let mut frame = wall(99, 640, 480);
        let lie = [
            (0, at(140.0, 120.0, 0.3, 0.9)),
            (0, at(480.0, 130.0, -0.2, 1.0)),
            (5, at(330.0, 370.0, 0.1, 0.9)),
        ];
        for (seed, placement) in lie {
            put(&mut frame, &picture(seed), placement);
        }
        let recognition = model.recognise(&Frame::gray(frame), |_| ());
        assert_eq!(recognition.instances.len(), 3);
        for (seed, placement) in lie {
            let there = recognition.instances.iter().filter(|instance| {
                let found = &instance.verified.placement;
                instance.label == seed.to_string()
                    && (found.x_px - placement.x_px).hypot(found.y_px - placement.y_px) < 8.0
            });
            assert_eq!(there.count(), 1, "{seed} at {placement:?}");
        }
    }

    #[test]
    fn one_picture_under_two_labels_is_named_as_both() {
        let pictures = [("a", 1), ("b", 1), ("c", 2)].map(|(label, seed)| (label.to_owned(), picture(seed)));
        let model = model_of(pictures.into_iter(), &LandmarkOptions::default());
        let recognition =
            model.recognise(&Frame::gray(shown(&picture(1), at(200.0, 180.0, 0.5, 1.0))), |_| ());
        let mut named: Vec<&str> = recognition.also.iter().map(|also| &also.label[..]).collect();
        named.extend(decided(&recognition));
        named.sort_unstable();
        assert_eq!(named, ["a", "b"]);
        let frame = Frame::gray(picture(1));
        let alone = left_out(&model, "a-0", &frame).unwrap();
        assert_eq!((alone.has_others, alone.named), (false, false));
        assert_eq!((alone.alike, alone.same_picture), (vec!["b".to_owned()], Some("b-1".to_owned())));
    }

    #[test]
    fn windows_of_one_wall_that_overlap_do_not_silence_each_other() {
        let strip = wall(7, 80 * 15 + 320, 240);
        let window = |left: usize| Image::from_fn(320, 240, |x, y| strip.at(left + x, y));
        let labels = (0..16).map(|number| (format!("{number:02}"), window(80 * number)));
        let model = model_of(labels, &LandmarkOptions::default());
        for number in 0..15 {
            let recognition = model.recognise(&Frame::gray(window(80 * number + 20)), |_| ());
            assert_eq!(decided(&recognition), Some(&format!("{number:02}")[..]));
            assert!(recognition.also.iter().any(|also| also.label == format!("{:02}", number + 1)));
        }
    }

    #[test]
    fn what_a_negative_exemplar_shows_is_unknown_and_never_a_label() {
        let strip = wall(7, 640, 240);
        let window = |left: usize| Image::from_fn(320, 240, |x, y| strip.at(left + x, y));
        let desk = ("desk".to_owned(), window(0));
        let other = ("other".to_owned(), wall(31, 320, 240));
        let background = (String::new(), window(80));
        let options = LandmarkOptions::default();
        let without = model_of([desk.clone(), other.clone()].into_iter(), &options);
        let model = model_of([desk, other, background].into_iter(), &options);
        assert_eq!(model.labels(), ["desk", "other"]);

        let beside = Frame::gray(window(90));
        assert_eq!(decided(&without.recognise(&beside, |_| ())), Some("desk"));
        let recognition = model.recognise(&beside, |_| ());
        assert_eq!(decided(&recognition), None);
        let codes: Vec<&str> = recognition.reasons.iter().map(|reason| reason.code()).collect();
        assert_eq!(codes, ["known_background"]);
        assert!(recognition.reasons[0].remedy().contains("-2"), "{}", recognition.reasons[0].remedy());
        assert!(recognition.instances.is_empty());

        let shown = model.recognise(&Frame::gray(window(0)), |_| ());
        assert_eq!(decided(&shown), Some("desk"));
        assert!(!shown.instances.is_empty());
        for recognition in [&recognition, &shown] {
            let votes = recognition.votes.iter().map(|vote| &vote.label);
            let labels = votes
                .chain(recognition.also.iter().map(|also| &also.label))
                .chain(recognition.instances.iter().map(|instance| &instance.label));
            assert!(labels.into_iter().all(|label| !label.is_empty()), "{recognition:?}");
        }
        let asked: Vec<&str> = exemplars_to_leave_out(&model)
            .into_iter()
            .map(|index| model.exemplars()[index].label.as_str())
            .collect();
        assert_eq!(asked, ["desk", "other"], "nothing is asked of a negative exemplar");
        assert_eq!(CalibrationPlan::of(&model).exemplars.len(), 2);

        let parts = LandmarkParts::from(&model);
        let rebuilt = Landmarks::try_from(parts.clone()).unwrap();
        assert_eq!(rebuilt.recognise(&beside, |_| ()), recognition);
        let intensity = LandmarkOptions::of(Method::Paper, Viewpoint::Free);
        assert!(Landmarks::try_from(LandmarkParts { options: intensity, ..parts }).is_err());
    }

    #[test]
    fn negative_exemplars_alone_are_refused() {
        let described = describe(name("b", ""), &Frame::gray(picture(1)), &LandmarkOptions::default());
        let error = Landmarks::train(vec![described], &LandmarkOptions::default()).err();
        assert_eq!(error, Some(TrainingError::NoLabels));
        let paper = LandmarkOptions::of(Method::Paper, Viewpoint::Free);
        let described = ["", "a"].map(|label| describe(name(label, label), &Frame::gray(picture(1)), &paper));
        let error = Landmarks::train(described.into(), &paper).err();
        assert_eq!(error, Some(TrainingError::NegativeExemplars));
    }

    #[test]
    fn answers_are_in_pixels_of_the_posted_picture() {
        let options = LandmarkOptions { working_size_px: Some(320), ..LandmarkOptions::default() };
        let twice = |image: &Image| {
            Image::from_fn(2 * image.width(), 2 * image.height(), |x, y| image.at(x / 2, y / 2))
        };
        let model = model_of((0..3).map(|seed| (seed.to_string(), twice(&wall(seed, 320, 240)))), &options);
        assert_eq!((model.exemplars()[0].width_px, model.exemplars()[0].height_px), (640, 480));
        let recognition = model.recognise(&Frame::gray(twice(&wall(1, 320, 240))), |_| ());
        let outline = recognition.votes[0].placement.unwrap().outline_px(640, 480);
        for (found, corner) in
            outline.iter().zip([[-0.5, -0.5], [639.5, -0.5], [639.5, 479.5], [-0.5, 479.5]])
        {
            assert!((found[0] - corner[0]).hypot(found[1] - corner[1]) < 4.0, "{outline:?}");
        }
        assert!(recognition.points.iter().any(|point| point.x_px > 400.0));
    }

    #[test]
    fn an_upright_camera_is_not_asked_about_what_is_turned() {
        let options = LandmarkOptions::of(Method::Placement, Viewpoint::Upright);
        let model = model_of((0..3).map(|seed| (seed.to_string(), picture(seed))), &options);
        let tilted = Frame::gray(shown(&picture(1), at(200.0, 180.0, 0.2, 1.0)));
        assert_eq!(decided(&model.recognise(&tilted, |_| ())), Some("1"));
        let turned = Frame::gray(shown(&picture(1), at(200.0, 180.0, 1.6, 1.0)));
        assert_eq!(decided(&model.recognise(&turned, |_| ())), None);
    }

    #[test]
    fn a_picture_under_a_second_label_makes_a_model_worse_and_one_beside_it_does_not() {
        let options = LandmarkOptions::default();
        let pictures = || (0..3).map(|seed| (seed.to_string(), picture(seed)));
        let right = |model: &Landmarks| {
            let named = (0..3).flat_map(|seed| {
                let name = name(&format!("{seed}-{seed}"), &seed.to_string());
                let views = synthetic_views(&name, &Frame::gray(picture(seed)), 0, &options);
                names_rightly(model, &name, &views)
            });
            named.filter(|right| *right).count()
        };
        let before = right(&model_of(pictures(), &options));
        assert!(before >= 9, "{before} of 12");
        let twice = model_of(pictures().chain([("other".to_owned(), picture(1))]), &options);
        assert!(right(&twice) + 3 <= before, "{} and {before}", right(&twice));
        let grown = model_of(pictures().chain([("new".to_owned(), picture(9))]), &options);
        assert!(right(&grown) + 1 >= before, "{} and {before}", right(&grown));
    }

    #[test]
    fn windows_as_an_earlier_release_kept_them_are_put_into_lists() {
        let options = LandmarkOptions { colour: Colour::Gray, ..LandmarkOptions::default() };
        let described: Vec<_> = (0..WALLS)
            .map(|seed| {
                describe(
                    name(&format!("{seed}-{seed}"), &seed.to_string()),
                    &Frame::gray(picture(seed)),
                    &options,
                )
            })
            .collect();
        let parts = LandmarkParts::from(&Landmarks::train(described.clone(), &options).unwrap().0);
        let LandmarkParts { mean, basis, eigenvalues, total_variance, .. } = parts.clone();
        let eigenspace = crate::eigen::Eigenspace { mean, basis, eigenvalues, total_variance };
        let windows = || described.iter().flat_map(|e| &e.windows);
        let owners = described.iter().enumerate();
        let plain = PlainParts {
            eigenpoints: described.iter().flat_map(|e| eigenspace.project(&e.signatures)).collect(),
            points: windows().flat_map(|w| [w.point.x_px, w.point.y_px, w.point.salience]).collect(),
            radius: windows().map(|w| w.radius).collect(),
            spectra: described.iter().flat_map(|e| e.spectra.iter().copied()).collect(),
            owner: owners.flat_map(|(owner, e)| vec![owner as u32; e.windows.len()]).collect(),
        };
        let earlier = LandmarkParts { windows: WindowParts::Plain(plain), ..parts };
        let model = Landmarks::try_from(earlier).unwrap();
        for seed in 0..WALLS {
            let frame = Frame::gray(shown(&picture(seed), at(200.0, 180.0, 0.4, 1.1)));
            assert_eq!(decided(&model.recognise(&frame, |_| ())), Some(&seed.to_string()[..]));
        }
        assert!(model.bytes() < 200 * windows().count() + (1 << 18), "{} bytes", model.bytes());
    }

    #[test]
    fn what_is_added_is_known_and_what_is_taken_out_is_gone() {
        let options = LandmarkOptions { colour: Colour::Gray, ..LandmarkOptions::default() };
        let mut model = trained();
        let encoded = |model: &Landmarks, seed: u64| {
            let frame = Frame::gray(picture(seed));
            let space = WindowSpace::of(model).unwrap();
            space.encode(describe(name(&format!("new-{seed}"), &seed.to_string()), &frame, &options)).unwrap()
        };
        for seed in 10..22 {
            let added = vec![encoded(&model, seed)];
            assert!(residual_of(&added) < 2.0 * WindowSpace::of(&model).unwrap().residual());
            model = model.grown(added, |_| true).unwrap().0;
        }
        assert_eq!(model.exemplars().len(), 18);
        let asked = |model: &Landmarks, seed: u64| {
            let frame = Frame::gray(shown(&picture(seed), at(200.0, 180.0, 0.4, 1.1)));
            decided(&model.recognise(&frame, |_| ())).map(str::to_owned)
        };
        for seed in [0, 3, 10, 15, 21] {
            assert_eq!(asked(&model, seed), Some(seed.to_string()));
        }
        let parts = LandmarkParts::from(&model);
        assert_eq!(LandmarkParts::from(&Landmarks::try_from(parts.clone()).unwrap()), parts);
        let gone = ["3", "15"];
        let (less, report) = model.grown(vec![], |exemplar| !gone.contains(&&exemplar.label[..])).unwrap();
        assert_eq!((report.exemplars, less.exemplars().len()), (16, 16));
        for seed in [0, 10, 21] {
            assert_eq!(asked(&less, seed), Some(seed.to_string()));
        }
        for seed in [3, 15] {
            assert_eq!(asked(&less, seed), None);
        }
        // what was added and taken out at once left nothing behind
        let (back, _) = less.grown(vec![encoded(&less, 30)], |_| true).unwrap();
        let (back, _) = back.grown(vec![], |exemplar| exemplar.label != "30").unwrap();
        assert_eq!(LandmarkParts::from(&back), LandmarkParts::from(&less));
        assert!(matches!(back.grown(vec![], |_| false), Err(TrainingError::NoExemplars)));
    }

    #[test]
    fn a_model_comes_back_from_its_parts() {
        let model = trained();
        let parts = LandmarkParts::from(&model);
        let back = Landmarks::try_from(parts.clone()).unwrap();
        assert_eq!(LandmarkParts::from(&back), parts);
        let frame = Frame::gray(shown(&picture(2), at(200.0, 180.0, 1.0, 1.0)));
        assert_eq!(back.recognise(&frame, |_| ()), model.recognise(&frame, |_| ()));
    }
}
