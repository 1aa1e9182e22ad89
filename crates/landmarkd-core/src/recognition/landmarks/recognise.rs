//! Recognition of a frame by a trained database.
//!
//! Points are asked in batches, each as large as all before it together, until one more changes neither what is
//! seen nor by how much (A§6 leaves open how many it takes). The paper's method asks all of them at once.

use super::confidence::Evidence;
use super::consensus::{Match, hypotheses};
use super::contour::Directions;
use super::description::Seen;
use super::model::{Exemplar, Landmarks};
use super::opinion::{Opinion, placed};
use super::options::{Colour, Method, Viewpoint};
use super::prior::{coordinates, with_places};
use super::recognition::{Decision, Instance, Recognition};
use super::standing::{Standing, exact, in_one_place, laid};
use super::warning::{FEW_POINTS, Warning};
use crate::eigen::{EigenpointIndex, Neighbour};
use crate::imaging::Frame;

/// The steps of a recognition, in their order; all but the first may come several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A§4.2: interest points.
    Attention,
    /// A§4.3–4.4: sub-windows and signatures.
    Signature,
    /// A§4.1, A§4.5: projection, and the nearest eigenpoints.
    Search,
    /// A§4.5: votes.
    Vote,
    /// Exemplars laid on the frame.
    Verification,
}

/// Points of the first batch: so many, and so many for each square of [`BATCH_SIDE_PX`].
const LEAST_BATCH: usize = 128;
const BATCH_SIDE_PX: usize = 32;
const BATCH_POINTS: usize = 2;
/// The margin that no longer moves: it changed by no more than this.
const STILL: f64 = 0.25;
/// A rival with more than this part of the best one's W is close.
const CLOSE: f64 = 0.8;

/// What is left of a database when some exemplars are left out.
pub(super) struct LeftOut {
    /// `None` if nothing is left.
    kept: Option<EigenpointIndex>,
    /// Of each eigenpoint that is kept its row in the whole database.
    rows: Vec<u32>,
}

/// What all windows so far say.
enum Said<'a> {
    /// Where exemplars lie, about, and what they were laid on.
    Laid(Vec<Standing>, &'a Directions),
    /// What windows count for.
    Counted(Opinion),
}

/// What must stay as it is for more points not to matter.
struct Glance {
    best: Option<String>,
    instances: usize,
    /// How far the best label is ahead of the next: its part of W less the next one's.
    margin: f64,
}

impl Glance {
    fn still(&self, before: &Glance) -> bool {
        self.best == before.best
            && self.instances == before.instances
            && (self.margin - before.margin).abs() <= STILL
    }
}

impl Landmarks {
    /// Recognise a frame. `finished` is told the end of each stage: the caller holds the clock.
    ///
    /// The decision is none where the chance that it is right is below the database's threshold. Without
    /// rehearsals there is no such chance: then the best there is is named.
    pub fn recognise(&self, frame: &Frame, finished: impl FnMut(Stage)) -> Recognition {
        self.recognise_without(frame, None, finished).0
    }

    /// The same without some exemplars; and the evidence for the best vote.
    pub(super) fn recognise_without(
        &self,
        frame: &Frame,
        left_out: Option<&LeftOut>,
        mut finished: impl FnMut(Stage),
    ) -> (Recognition, Evidence) {
        let attention = self.describer.attend(frame); // A§4.2
        let points_found = attention.points.len();
        let mut look = self.describer.look(frame, &attention);
        let directions = self.options.places().then(|| Directions::of(&attention.smoothed));
        finished(Stage::Attention);

        let radii = self.options.subwindow_radii_px.len();
        let squares = (frame.width() / BATCH_SIDE_PX) * (frame.height() / BATCH_SIDE_PX);
        let mut batch = match self.options.method {
            Method::Paper => self.options.query_points,
            Method::Placement => LEAST_BATCH.max(BATCH_POINTS * squares).min(self.options.query_points),
        };
        let (mut windows, mut neighbours, mut matches) = (Vec::new(), Vec::new(), Vec::new());
        let mut before: Option<Glance> = None;
        let said = loop {
            let seen = self.describer.sign(&mut look, batch); // A§4.3, A§4.4
            finished(Stage::Signature);
            let found = self.nearest(&seen, left_out); // A§4.1, A§4.5
            finished(Stage::Search);
            let exhausted = seen.windows.len() < batch * radii;
            self.add_matches(&seen, windows.len(), &found, &mut matches);
            windows.extend(seen.windows);
            neighbours.extend(found);
            let said = match &directions {
                Some(directions) => {
                    matches.sort_by_key(|found: &Match| found.exemplar); // stable
                    let hypotheses = hypotheses(&matches);
                    finished(Stage::Vote);
                    let standings = laid(hypotheses, &self.exemplars, directions);
                    finished(Stage::Verification);
                    Said::Laid(standings, directions)
                }
                None => {
                    let opinion = self.counted(&windows, &neighbours);
                    finished(Stage::Vote);
                    Said::Counted(opinion)
                }
            };
            let asked = windows.len() / radii;
            batch = asked.min(self.options.query_points.saturating_sub(asked));
            let glance = self.glance(&said);
            if exhausted || batch == 0 || before.is_some_and(|before| glance.still(&before)) {
                break said;
            }
            before = Some(glance);
        };
        let opinion = match said {
            Said::Laid(standings, directions) => {
                let standings = exact(standings, &self.exemplars, directions);
                let opinion = self.placed(&windows, &neighbours, &matches, standings);
                finished(Stage::Verification);
                opinion
            }
            Said::Counted(opinion) => opinion,
        };
        let points_used = windows.len() / radii;
        let instances = self.instances(&opinion.standings);
        let decision = self.decision(&opinion, &instances);
        let warnings = self.doubts(frame, points_used, &opinion, decision.is_some());
        let recognition = Recognition {
            decision,
            points_found,
            points_used,
            instances,
            votes: opinion.votes,
            points: opinion.points,
            exemplar_weights: opinion.exemplar_weights,
            warnings,
        };
        (recognition, opinion.evidence)
    }

    fn glance(&self, said: &Said<'_>) -> Glance {
        let (instances, weights): (_, Vec<(&str, f64)>) = match said {
            Said::Laid(standings, _) => {
                let best = self.best_of_labels(standings);
                let weights = best.iter().map(|standing| (self.label(standing), standing.weight));
                (self.instances(standings).len(), weights.collect())
            }
            Said::Counted(opinion) => {
                (0, opinion.votes.iter().map(|vote| (&vote.label[..], vote.weight)).collect())
            }
        };
        let all: f64 = weights.iter().map(|(_, weight)| weight).sum();
        let margin = match &weights[..] {
            [] => 0.0,
            [(_, only)] => only / all,
            [(_, first), (_, second), ..] => (first - second) / all,
        };
        Glance { best: weights.first().map(|(label, _)| (*label).to_owned()), instances, margin }
    }

    /// The nearest eigenpoints of every window, rows of equal length.
    fn nearest(&self, seen: &Seen, left_out: Option<&LeftOut>) -> Vec<Neighbour> {
        let projected = with_places(
            self.eigenspace.project(&seen.signatures),
            self.dimension(),
            seen.windows.iter().copied(),
            self.options.position_prior_px,
        );
        match left_out {
            Some(LeftOut { kept: None, .. }) => Vec::new(),
            Some(LeftOut { kept: Some(index), rows }) => {
                let found = index.nearest_several(&projected, self.wanted().min(index.count()));
                found.into_iter().map(|n| Neighbour { index: rows[n.index] as usize, ..n }).collect()
            }
            None if self.wanted() == 1 => self.index.nearest(&projected),
            None => self.index.nearest_several(&projected, self.wanted()),
        }
    }

    /// The database without some of its exemplars.
    pub(super) fn leaving_out(&self, left_out: impl Fn(&Exemplar) -> bool) -> LeftOut {
        let marks: Vec<bool> = self.exemplars.iter().map(left_out).collect();
        let kept = self.owned.iter().enumerate().filter(|(_, owned)| !marks[owned.exemplar as usize]);
        let rows: Vec<u32> = kept.map(|(row, _)| row as u32).collect();
        let width = coordinates(self.dimension(), self.options.position_prior_px);
        let all = self.index.points();
        let points: Vec<f32> =
            rows.iter().flat_map(|&row| &all[row as usize * width..][..width]).copied().collect();
        LeftOut { kept: (!points.is_empty()).then(|| EigenpointIndex::new(points, width)), rows }
    }

    /// Eigenpoints asked for by each window: with local naive Bayes one more stands for the background.
    fn wanted(&self) -> usize {
        let beyond = usize::from(self.options.viewpoint == Viewpoint::Upright);
        (self.options.neighbours + beyond).min(self.index.count())
    }

    /// The standings that are sure enough, each the best in its place.
    fn instances(&self, standings: &[Standing]) -> Vec<Instance> {
        let Some(confidence) = &self.confidence else { return Vec::new() };
        let mut taken: Vec<&Standing> = Vec::new();
        let mut instances = Vec::new();
        for standing in standings {
            if taken.iter().any(|other| in_one_place(other, standing, &self.exemplars)) {
                continue;
            }
            taken.push(standing);
            let sure = confidence.of(&self.evidence(standing, standings));
            if sure >= confidence.threshold {
                let label = self.label(standing).to_owned();
                instances.push(Instance { label, confidence: sure, placed: placed(standing) });
            }
        }
        instances.sort_by(|a, b| b.confidence.total_cmp(&a.confidence)); // stable
        instances
    }

    /// What the frame shows: the surest of the placed exemplars, or where nothing is placed the best vote.
    fn decision(&self, opinion: &Opinion, instances: &[Instance]) -> Option<Decision> {
        let best = opinion.votes.first()?;
        let Some(confidence) = &self.confidence else {
            return Some(Decision { label: best.label.clone(), confidence: None });
        };
        if self.options.places() {
            let Instance { label, confidence, .. } = instances.first()?;
            return Some(Decision { label: label.clone(), confidence: Some(*confidence) });
        }
        let sure = confidence.of(&opinion.evidence);
        (sure >= confidence.threshold).then(|| Decision { label: best.label.clone(), confidence: Some(sure) })
    }

    fn doubts(&self, frame: &Frame, points_used: usize, opinion: &Opinion, decided: bool) -> Vec<Warning> {
        let mut warnings = Vec::new();
        match points_used {
            0 => warnings.push(Warning::NoInterestPoints),
            used if used < self.options.query_points.min(FEW_POINTS) => {
                warnings.push(Warning::TooFewPoints { found: used });
            }
            used => {
                let radii = self.options.subwindow_radii_px.len();
                let voted = opinion.votes.first().map_or(0, |vote| vote.points / radii);
                if !decided && 2 * voted < used {
                    warnings.push(Warning::VotesOnBackground { voted, used });
                }
            }
        }
        if opinion.rival.is_some_and(|rival| rival > CLOSE) {
            warnings.push(Warning::CloseSecond);
        }
        if self.options.colour == Colour::Opponent && !frame.is_colour() {
            warnings.push(Warning::GrayFrame);
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::super::confidence::EVIDENCE;
    use super::super::pictures::{described, name, paper, toy};
    use super::super::{LandmarkOptions, PerLabel, Placed, Taper, describe, rehearsals};
    use super::*;
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
            exemplars[1].name.label = "toy0".to_owned();
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

    /// Ten toys that know how sure they are.
    fn calibrated(options: &LandmarkOptions) -> Landmarks {
        let mut model = trained(options);
        let (chosen, rounds) = model.rehearsed_exemplars();
        let mut rehearsed = Vec::new();
        for round in 0..rounds {
            for &index in &chosen {
                let Exemplar { id, label, .. } = &model.exemplars()[index];
                let picture = Frame::gray(toy(label["toy".len()..].parse().unwrap(), 96));
                let name = name(id, label);
                rehearsed.extend(model.rehearse(&name, &rehearsals(&name, &picture, round, options)));
            }
        }
        let reliability = model.calibrate(&rehearsed).expect("enough rehearsals");
        assert!(reliability.unknown_refused > 0.9 && reliability.known_misnamed < 0.05, "{reliability:?}");
        model
    }

    fn labels(recognition: &Recognition) -> Vec<&str> {
        recognition.votes.iter().map(|vote| vote.label.as_str()).collect()
    }

    #[test]
    fn many_views_of_one_thing_do_not_crowd_out_another() {
        let options = LandmarkOptions::default();
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
        let options = LandmarkOptions::default();
        let (mut model, _) = Landmarks::train(described(3..4, &options), &options).unwrap();
        let (_, rounds) = model.rehearsed_exemplars();
        let name = name("toy3", "toy3");
        let picture = Frame::gray(toy(3, 96));
        let rehearsed = (0..rounds)
            .flat_map(|round| model.rehearse(&name, &rehearsals(&name, &picture, round, &options)));
        let rehearsed: Vec<_> = rehearsed.collect();
        assert!(rehearsed.iter().any(|r| !r.known && r.evidence != [0.0; EVIDENCE]));
        model.calibrate(&rehearsed).expect("enough rehearsals");
        assert_eq!(model.recognise(&table(&[], 1.0), |_| ()).decision, None);
        let known = model.recognise(&table(&[(3, 150.0, 110.0, 30.0)], 1.0), |_| ());
        assert_eq!(known.decision.expect("the thing").label, "toy3");
    }

    #[test]
    fn the_votes_say_where_the_exemplar_lies() {
        let model = trained(&LandmarkOptions::default());
        for (seed, x_px, y_px, degrees, scale) in [
            (3, 120.0, 110.0, 0.0, 1.0),
            (5, 200.0, 120.0, 133.0, 1.0),
            (8, 150.0, 100.0, -70.0, 1.25),
            (1, 170.0, 130.0, 20.0, 0.8),
        ] {
            let recognition = model.recognise(&table(&[(seed, x_px, y_px, degrees)], scale), |_| ());
            let best = &recognition.votes[0];
            assert_eq!(best.label, format!("toy{seed}"));
            let Placed { placement, exemplar, inliers, agreement } = best.placement.unwrap();
            assert_eq!(model.exemplars()[exemplar].label, best.label);
            assert!((placement.x_px - x_px).hypot(placement.y_px - y_px) < 1.5, "{placement:?}");
            let turned = (placement.rotation_rad.to_degrees() - degrees + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turned.abs() < 2.0, "{turned}");
            assert!((placement.scale / scale - 1.0).abs() < 0.06, "{placement:?}");
            assert!(inliers >= 5 && agreement > 0.4, "{inliers} {agreement}");
        }
    }

    #[test]
    fn what_is_not_known_is_not_named() {
        let model = calibrated(&LandmarkOptions::default());
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
        let model = calibrated(&LandmarkOptions::default());
        let frame = table(&[(2, 60.0, 70.0, 15.0), (7, 180.0, 150.0, 200.0), (2, 300.0, 90.0, 100.0)], 1.0);
        let recognition = model.recognise(&frame, |_| ());
        let mut found: Vec<(&str, f32)> = recognition
            .instances
            .iter()
            .map(|instance| (instance.label.as_str(), instance.placed.placement.x_px.round()))
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
        let model = trained(&LandmarkOptions::default());
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
        let model = trained(&LandmarkOptions::default());
        let clear = model.recognise(&Frame::gray(toy(4, 96)), |_| ());
        assert!(clear.points_used <= 256, "{}", clear.points_used);
        let few = LandmarkOptions { query_points: 40, ..LandmarkOptions::default() };
        assert_eq!(trained(&few).recognise(&table(&[(4, 150.0, 110.0, 30.0)], 1.0), |_| ()).points_used, 40);
    }

    #[test]
    fn an_upright_place_is_known_by_what_stands_where() {
        for position_prior_px in [None, Some(30.0)] {
            let upright = LandmarkOptions {
                position_prior_px,
                ..LandmarkOptions::of(Method::Placement, Viewpoint::Upright)
            };
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
            let parts = model.to_parts();
            assert_eq!(Landmarks::from_parts(parts.clone()).unwrap().to_parts(), parts);
        }
    }

    #[test]
    fn without_its_label_an_exemplar_is_not_named() {
        let model = trained(&LandmarkOptions::default());
        let frame = table(&[(3, 110.0, 110.0, 30.0), (6, 250.0, 110.0, 80.0)], 1.0);
        assert_eq!(labels(&model.recognise(&frame, |_| ()))[..2].len(), 2);
        let (without, _) =
            model.recognise_without(&frame, Some(&model.leaving_out(|e| e.label == "toy3")), |_| ());
        assert_eq!(labels(&without)[0], "toy6");
        assert!(labels(&without).iter().all(|label| *label != "toy3"));
        let nothing = model.recognise_without(&frame, Some(&model.leaving_out(|_| true)), |_| ()).0;
        assert!(nothing.votes.is_empty() && nothing.decision.is_none());
    }
}
