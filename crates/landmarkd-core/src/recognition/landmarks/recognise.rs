//! Recognition of a frame by a trained database: the way from pixels to the answer.

use super::consensus::hypotheses;
use super::edge_template::GradientDirections;
use super::model::{Landmarks, Windows};
use super::multiscale::asked_frame::AskedFrame;
use super::multiscale::recognise_among;
use super::options::Colour;
use super::query::{Query, StoppingState};
use super::recognition::{Decision, Instance, Recognition, Stage};
use super::search::EigenpointSubset;
use super::verification::Ranking;
use super::vote_result::VoteResult;
use super::warning::{FEW_POINTS, Warning};
use crate::imaging::Frame;

/// A rival with more than this part of the best one's W is close.
const CLOSE: f64 = 0.8;

/// Recognises a frame by all eigenpoints of a database, or by a subset. Calls `finished` after each stage.
pub(super) fn recognise(
    model: &Landmarks,
    subset: Option<&EigenpointSubset>,
    frame: &Frame,
    mut finished: impl FnMut(Stage),
) -> Recognition {
    match &model.windows {
        Windows::Plain(_) => {}
        Windows::Encoded(windows) => {
            let asked = AskedFrame::of(model, &windows.exemplars, frame, &mut finished);
            return recognise_among(model, windows, None, &asked, finished);
        }
        Windows::Elsewhere(_) => {
            panic!("the windows are elsewhere: ask, choose, and recognise among those chosen")
        }
    }
    let attention = model.describer.attend(frame); // A§4.2
    let mut query = Query::new(model, subset, frame, &attention);
    let verifies = model.options.verifies_placements();
    let directions = verifies.then(|| GradientDirections::of(&attention.smoothed));
    finished(Stage::Attention);
    let result = match directions {
        Some(directions) => verify_placements(&mut query, &directions, &mut finished),
        None => count_votes(&mut query, &mut finished),
    };
    let decision = decision(model, &result);
    let warnings = warnings(&query, frame, &result, decision.is_some());
    Recognition {
        decision,
        points_found: attention.points.len(),
        points_used: query.points(),
        votes: result.votes,
        instances: result.instances,
        points: result.points,
        exemplar_weights: result.exemplar_weights,
        evidence: result.evidence,
        a_contrario: None,
        also: Vec::new(),
        agreeing: Vec::new(),
        reasons: Vec::new(),
        warnings,
    }
}

/// Placements that the matches agree on, verified on the frame.
fn verify_placements(
    query: &mut Query<'_>,
    directions: &GradientDirections,
    finished: &mut impl FnMut(Stage),
) -> VoteResult {
    let model = query.model;
    let ranking = loop {
        query.add_batch(finished);
        let hypotheses = hypotheses(&query.matches);
        finished(Stage::Vote);
        let ranking = Ranking::verify(hypotheses, &model.exemplars, directions);
        finished(Stage::Verification);
        let best = ranking.best_of_labels().into_iter();
        let labels = best.map(|scored| (ranking.label(scored), scored.weight));
        let instances = ranking.instances(model.confidence()).len();
        if query.is_settled(StoppingState::new(labels, instances)) {
            break ranking.refined(directions);
        }
    };
    let result = VoteResult::of_placements(query, &ranking);
    finished(Stage::Verification);
    result
}

/// Votes of the windows alone.
fn count_votes(query: &mut Query<'_>, finished: &mut impl FnMut(Stage)) -> VoteResult {
    loop {
        query.add_batch(finished);
        let result = VoteResult::of_windows(query);
        finished(Stage::Vote);
        let labels = result.votes.iter().map(|vote| (&vote.label[..], vote.weight));
        if query.is_settled(StoppingState::new(labels, 0)) {
            return result;
        }
    }
}

/// The most confident instance, or where the method verifies no placements the best vote.
fn decision(model: &Landmarks, result: &VoteResult) -> Option<Decision> {
    let label = result.votes.first()?.label.clone();
    let Some(confidence) = &model.confidence else {
        return Some(Decision { label, confidence: None });
    };
    if model.options.verifies_placements() {
        let Instance { label, confidence, .. } = result.instances.first()?;
        return Some(Decision { label: label.clone(), confidence: Some(*confidence) });
    }
    let probability = confidence.of(&result.evidence);
    (probability >= confidence.threshold).then_some(Decision { label, confidence: Some(probability) })
}

fn warnings(query: &Query<'_>, frame: &Frame, result: &VoteResult, decided: bool) -> Vec<Warning> {
    let options = &query.model.options;
    let mut warnings = Vec::new();
    match query.points() {
        0 => warnings.push(Warning::NoInterestPoints),
        used if used < options.query_points.min(FEW_POINTS) => {
            warnings.push(Warning::TooFewPoints { found: used });
        }
        used => {
            let windows = result.votes.first().map_or(0, |vote| vote.points);
            let voted = windows / options.subwindow_radii_px.len();
            if !decided && 2 * voted < used {
                warnings.push(Warning::VotesOnBackground { voted, used });
            }
        }
    }
    if result.rival.is_some_and(|rival| rival > CLOSE) {
        warnings.push(Warning::CloseSecond);
    }
    if options.colour == Colour::Opponent && !frame.is_colour() {
        warnings.push(Warning::GrayFrame);
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::super::Exemplar;
    use super::super::confidence::Evidence;
    use super::super::pictures::{described, intensity, name, paper, toy};
    use super::super::{
        CalibrationPlan, CalibrationSample, LandmarkOptions, LandmarkParts, PerLabel, Taper,
        VerifiedPlacement, Viewpoint, calibration_samples, describe, synthetic_views,
    };
    use super::*;
    use crate::angle::angular_distance_rad;
    use crate::imaging::Image;

    fn trained(options: &LandmarkOptions) -> Landmarks {
        Landmarks::train(described(0..10, options), options).unwrap().0
    }

    fn first(model: &Landmarks, frame: &Frame) -> String {
        model.recognise(frame, |_| ()).votes[0].label.clone()
    }

    #[test]
    fn its_own_picture_is_at_distance_zero() {
        let model = trained(&paper());
        for seed in 0..10 {
            let recognition = model.recognise(&Frame::gray(toy(seed, 96)), |_| ());
            assert_eq!(recognition.votes[0].label, format!("toy{seed}"));
            assert!(recognition.points.iter().all(|point| point.distance == 0.0));
            assert_eq!(recognition.votes[0].points, recognition.points_used);
            assert!(recognition.warnings.is_empty());
        }
    }

    #[test]
    fn turned_toys_are_recognised() {
        let model = trained(&paper());
        let right = (0..10u64).filter(|&seed| {
            let turned = Frame::gray(toy(seed, 96)).turned(17.0 + 36.0 * seed as f64);
            first(&model, &turned) == format!("toy{seed}")
        });
        let right = right.count();
        assert!(right == 10, "{right} of 10");
    }

    #[test]
    fn the_literal_taper_recognises_fewer_turned_toys() {
        let right = |taper| {
            let model = trained(&LandmarkOptions { taper, ..paper() });
            let mut share = 0.0;
            for seed in 0..10u64 {
                let turned = Frame::gray(toy(seed, 96)).turned(17.0 + 36.0 * seed as f64);
                let recognition = model.recognise(&turned, |_| ());
                let own = recognition.votes.iter().find(|vote| vote.label == format!("toy{seed}"));
                share += own.map_or(0.0, |vote| vote.share) / 10.0;
            }
            share
        };
        let (radial, literal) = (right(Taper::Radial), right(Taper::Literal));
        println!("share of W for the true label, turned toys: radial {radial:.3}, literal {literal:.3}");
        assert!(radial > literal + 0.1, "radial {radial}, literal {literal}");
    }

    #[test]
    fn most_half_occluded_toys_are_recognised() {
        let model = trained(&paper());
        let right = (0..10).filter(|&seed| {
            let whole = toy(seed, 96);
            let half = Image::from_fn(96, 96, |x, y| if x + y < 96 { whole.at(x, y) } else { 40.0 });
            first(&model, &Frame::gray(half).turned(45.0)) == format!("toy{seed}")
        });
        let right = right.count();
        // ten labels: chance is 1; the rest of the points votes for the occluder's edge
        assert!(right >= 7, "{right} of 10");
    }

    #[test]
    fn stages_end_in_their_order() {
        let mut stages = Vec::new();
        trained(&paper()).recognise(&Frame::gray(toy(1, 96)), |stage| stages.push(stage));
        assert_eq!(stages, [Stage::Attention, Stage::Signature, Stage::Search, Stage::Vote]);
    }

    #[test]
    fn the_same_frame_gives_the_same_answer() {
        let model = trained(&paper());
        let frame = Frame::gray(toy(4, 96)).turned(33.0);
        assert_eq!(model.recognise(&frame, |_| ()), model.recognise(&frame, |_| ()));
    }

    #[test]
    fn a_flat_frame_is_answered_with_a_warning() {
        let model = trained(&paper());
        for (width, height) in [(64, 64), (1, 1), (0, 0)] {
            let recognition =
                model.recognise(&Frame::gray(Image::from_fn(width, height, |_, _| 7.0)), |_| ());
            assert!(recognition.votes.is_empty() && recognition.points.is_empty());
            assert_eq!(recognition.warnings, [Warning::NoInterestPoints]);
        }
        let dot = Image::from_fn(40, 40, |x, y| if (x, y) == (20, 20) { 255.0 } else { 0.0 });
        let recognition = model.recognise(&Frame::gray(dot), |_| ());
        let found = recognition.points_used;
        assert!((1..8).contains(&found), "{found}");
        assert_eq!(recognition.warnings, [Warning::TooFewPoints { found }]);
    }

    #[test]
    fn a_gray_frame_for_a_colour_database_is_doubted() {
        let options = LandmarkOptions { colour: Colour::Opponent, ..paper() };
        let frame = |seed| Frame::colour([toy(seed, 96), toy(seed, 96), toy(seed + 1, 96)]);
        let exemplars = (0..3).map(|seed| describe(name(&seed.to_string(), "x"), &frame(seed), &options));
        let (model, _) = Landmarks::train(exemplars.collect(), &options).unwrap();
        assert_eq!(model.recognise(&frame(1), |_| ()).warnings, []);
        let gray = Frame::gray(frame(1).luminance);
        assert_eq!(model.recognise(&gray, |_| ()).warnings, [Warning::GrayFrame]);
    }

    #[test]
    fn query_points_limit_the_voters() {
        let options = LandmarkOptions { query_points: 12, ..paper() };
        let recognition = trained(&options).recognise(&Frame::gray(toy(2, 96)), |_| ());
        assert_eq!(recognition.points_used, 12);
        assert!(recognition.points_found > 12);
        assert!(recognition.points.is_sorted_by(|a, b| a.salience >= b.salience));
    }

    #[test]
    fn two_views_of_a_label_count_once_or_both() {
        for (per_label, both) in [(PerLabel::Best, false), (PerLabel::Sum, true)] {
            let options = LandmarkOptions { per_label, ..paper() };
            let mut exemplars = described(0..3, &options);
            exemplars[1].exemplar.label = "toy0".to_owned();
            let (model, _) = Landmarks::train(exemplars, &options).unwrap();
            assert_eq!(model.labels(), ["toy0", "toy2"]);
            let (left, right) = (toy(0, 96), toy(1, 96));
            let side_by_side =
                Image::from_fn(192, 96, |x, y| if x < 96 { left.at(x, y) } else { right.at(x - 96, y) });
            let recognition = model.recognise(&Frame::gray(side_by_side), |_| ());
            let voted =
                |exemplar: usize| recognition.points.iter().any(|p| p.exemplar == exemplar && p.weight > 0.0);
            assert_eq!(voted(0) && voted(1), both);
        }
    }

    /// Toys on a chequered table, each turned and moved.
    fn table(toys: &[(u64, f32, f32, f32)], scale: f32) -> Frame {
        let mut frame = Image::from_fn(360, 240, |x, y| {
            let wave = (x as f32 / 9.0).sin() * (y as f32 / 7.0).cos() + ((x * y) as f32 / 300.0).sin();
            90.0 + 40.0 * wave
        });
        for &(seed, x_px, y_px, degrees) in toys {
            let picture = toy(seed, 96);
            let (sin, cos) = degrees.to_radians().sin_cos();
            for y in 0..240 {
                for x in 0..360 {
                    let (dx, dy) = ((x as f32 - x_px) / scale, (y as f32 - y_px) / scale);
                    let (u, v) = (47.5 + cos * dx + sin * dy, 47.5 - sin * dx + cos * dy);
                    if (u - 47.5).hypot(v - 47.5) > 40.0 {
                        continue;
                    }
                    let (left, top) = (u as usize, v as usize);
                    let (a, b) = (u - left as f32, v - top as f32);
                    let row = |y: usize| (1.0 - a) * picture.at(left, y) + a * picture.at(left + 1, y);
                    frame.pixels_mut()[y * 360 + x] = (1.0 - b) * row(top) + b * row(top + 1);
                }
            }
        }
        Frame::gray(frame)
    }

    /// Samples of toys that are named by their seeds.
    fn samples(model: &Landmarks) -> Vec<CalibrationSample> {
        let plan = CalibrationPlan::of(model);
        let of = |round: u64, index: usize| {
            let name = model.exemplars()[index].name();
            let picture = Frame::gray(toy(name.label["toy".len()..].parse().unwrap(), 96));
            calibration_samples(model, &name, &synthetic_views(&name, &picture, round, model.options()))
        };
        (0..plan.rounds).flat_map(|round| plan.exemplars.iter().flat_map(move |&i| of(round, i))).collect()
    }

    /// Ten toys with calibrated confidence.
    fn calibrated(options: &LandmarkOptions) -> Landmarks {
        let mut model = trained(options);
        let reliability = model.calibrate(&samples(&model)).expect("enough samples");
        assert!(reliability.unknown_refused > 0.9 && reliability.known_misnamed < 0.05, "{reliability:?}");
        model
    }

    fn labels(recognition: &Recognition) -> Vec<&str> {
        recognition.votes.iter().map(|vote| vote.label.as_str()).collect()
    }

    #[test]
    fn many_views_of_one_thing_do_not_crowd_out_another() {
        let options = intensity(Viewpoint::Free);
        let mut exemplars: Vec<_> = (0..24)
            .map(|view| {
                let picture = Frame::gray(toy(1, 96)).turned(f64::from(view) * 2.0);
                describe(name(&format!("view{view}"), "thing"), &picture, &options)
            })
            .collect();
        exemplars.extend(described(2..4, &options));
        let (model, _) = Landmarks::train(exemplars, &options).unwrap();
        let recognition =
            model.recognise(&table(&[(1, 100.0, 120.0, 0.0), (2, 250.0, 120.0, 90.0)], 1.0), |_| ());
        let mut first = labels(&recognition)[..2].to_vec();
        first.sort_unstable();
        assert_eq!(first, ["thing", "toy2"]);
    }

    #[test]
    fn a_database_of_one_label_knows_what_it_does_not_know() {
        let options = intensity(Viewpoint::Free);
        let (mut model, _) = Landmarks::train(described(3..4, &options), &options).unwrap();
        let samples = samples(&model);
        assert!(samples.iter().any(|sample| !sample.known && sample.evidence != Evidence::None));
        model.calibrate(&samples).expect("enough samples");
        assert_eq!(model.recognise(&table(&[], 1.0), |_| ()).decision, None);
        let known = model.recognise(&table(&[(3, 150.0, 110.0, 30.0)], 1.0), |_| ());
        assert_eq!(known.decision.expect("the thing").label, "toy3");
    }

    #[test]
    fn the_votes_say_where_the_exemplar_lies() {
        let model = trained(&intensity(Viewpoint::Free));
        for (seed, x_px, y_px, degrees, scale) in [
            (3, 120.0, 110.0, 0.0, 1.0),
            (5, 200.0, 120.0, 133.0, 1.0),
            (8, 150.0, 100.0, -70.0, 1.25),
            (1, 170.0, 130.0, 20.0, 0.8),
        ] {
            let recognition = model.recognise(&table(&[(seed, x_px, y_px, degrees)], scale), |_| ());
            let best = &recognition.votes[0];
            assert_eq!(best.label, format!("toy{seed}"));
            let VerifiedPlacement { placement, exemplar, inliers, agreement, .. } = best.placement.unwrap();
            assert_eq!(model.exemplars()[exemplar].label, best.label);
            assert!((placement.x_px - x_px).hypot(placement.y_px - y_px) < 1.5, "{placement:?}");
            let turned = angular_distance_rad(placement.rotation_rad, degrees.to_radians()).to_degrees();
            assert!(turned < 2.0, "{turned}");
            assert!((placement.scale / scale - 1.0).abs() < 0.06, "{placement:?}");
            assert!(inliers >= 5 && agreement > 0.4, "{inliers} {agreement}");
        }
    }

    #[test]
    fn what_is_not_known_is_not_named() {
        let model = calibrated(&intensity(Viewpoint::Free));
        let strange = [100, 101, 102, 103, 104].map(|seed| table(&[(seed, 150.0, 110.0, 30.0)], 1.0));
        let named = strange.iter().filter(|frame| model.recognise(frame, |_| ()).decision.is_some()).count();
        assert_eq!(named, 0);
        let bare = model.recognise(&table(&[], 1.0), |_| ());
        assert_eq!((bare.decision, bare.instances), (None, vec![]));
        assert!(matches!(bare.warnings[..], [Warning::VotesOnBackground { .. }]), "{:?}", bare.warnings);
        for seed in 0..10 {
            let known = model.recognise(&table(&[(seed, 150.0, 110.0, 30.0)], 1.0), |_| ());
            let decision = known.decision.expect("a known toy");
            assert_eq!(decision.label, format!("toy{seed}"));
            assert!(decision.confidence.unwrap() > 0.8, "{decision:?}");
        }
    }

    #[test]
    fn every_known_thing_in_a_frame_is_found() {
        let model = calibrated(&intensity(Viewpoint::Free));
        let frame = table(&[(2, 60.0, 70.0, 15.0), (7, 180.0, 150.0, 200.0), (2, 300.0, 90.0, 100.0)], 1.0);
        let recognition = model.recognise(&frame, |_| ());
        let mut found: Vec<(&str, f32)> = recognition
            .instances
            .iter()
            .map(|instance| (instance.label.as_str(), instance.verified.placement.x_px.round()))
            .collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        let near =
            |(label, x): &(&str, f32), wanted: (&str, f32)| *label == wanted.0 && (x - wanted.1).abs() < 3.0;
        assert_eq!(found.len(), 3, "{found:?}");
        for (found, wanted) in found.iter().zip([("toy2", 60.0), ("toy7", 180.0), ("toy2", 300.0)]) {
            assert!(near(found, wanted), "{found:?}");
        }
    }

    #[test]
    fn the_weights_of_a_labels_points_are_its_w() {
        let model = trained(&intensity(Viewpoint::Free));
        let recognition = model.recognise(&table(&[(4, 150.0, 110.0, 30.0)], 1.0), |_| ());
        for vote in &recognition.votes {
            let exemplar = vote.placement.unwrap().exemplar;
            let given =
                recognition.points.iter().filter(|point| point.exemplar == exemplar && point.weight > 0.0);
            let sum: f64 = given.map(|point| point.weight).sum();
            assert!((sum - vote.weight).abs() < 1e-9 * sum, "{} {sum} {}", vote.label, vote.weight);
        }
        let shares: f64 = recognition.votes.iter().map(|vote| vote.share).sum();
        assert!((shares - 1.0).abs() < 1e-9);
        assert!(recognition.points.len() >= recognition.points_used);
        assert!(recognition.points.is_sorted_by(|a, b| a.salience >= b.salience));
    }

    #[test]
    fn no_more_points_are_asked_than_it_takes() {
        let model = trained(&intensity(Viewpoint::Free));
        let clear = model.recognise(&Frame::gray(toy(4, 96)), |_| ());
        assert!(clear.points_used <= 256, "{}", clear.points_used);
        let few = LandmarkOptions { query_points: 40, ..intensity(Viewpoint::Free) };
        assert_eq!(trained(&few).recognise(&table(&[(4, 150.0, 110.0, 30.0)], 1.0), |_| ()).points_used, 40);
    }

    #[test]
    fn an_upright_place_is_known_by_what_stands_where() {
        for position_prior_px in [None, Some(30.0)] {
            let upright = LandmarkOptions { position_prior_px, ..intensity(Viewpoint::Upright) };
            let room = |seed: u64| table(&[(seed, 80.0, 120.0, 0.0), (seed + 20, 240.0, 110.0, 0.0)], 1.2);
            let described = (0..5)
                .map(|seed| describe(name(&seed.to_string(), &seed.to_string()), &room(seed), &upright));
            let (model, _) = Landmarks::train(described.collect(), &upright).unwrap();
            for seed in 0..5 {
                let later = table(&[(seed, 86.0, 117.0, 2.0), (seed + 20, 247.0, 108.0, 2.0)], 1.26);
                let recognition = model.recognise(&later, |_| ());
                assert_eq!(recognition.votes[0].label, seed.to_string());
                let (weight, own) =
                    (recognition.votes[0].weight, recognition.exemplar_weights[seed as usize]);
                assert!((weight - own).abs() < 1e-9 * own, "{weight} {own}");
            }
            let parts = LandmarkParts::from(&model);
            assert_eq!(LandmarkParts::from(&Landmarks::try_from(parts.clone()).unwrap()), parts);
        }
    }

    #[test]
    fn without_its_label_an_exemplar_is_not_named() {
        let model = trained(&intensity(Viewpoint::Free));
        let frame = table(&[(3, 110.0, 110.0, 30.0), (6, 250.0, 110.0, 80.0)], 1.0);
        assert_eq!(labels(&model.recognise(&frame, |_| ()))[..2].len(), 2);
        let without = |left_out: fn(&Exemplar) -> bool| {
            let subset = EigenpointSubset::without(&model, left_out);
            recognise(&model, Some(&subset), &frame, |_| ())
        };
        let others = without(|exemplar| exemplar.label == "toy3");
        assert_eq!(labels(&others)[0], "toy6");
        assert!(labels(&others).iter().all(|label| *label != "toy3"));
        let nothing = without(|_| true);
        assert!(nothing.votes.is_empty() && nothing.decision.is_none());
    }
}
