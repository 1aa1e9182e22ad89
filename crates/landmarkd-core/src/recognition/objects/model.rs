//! A trained object database: an immutable value that recognises pictures.

use super::acceptance::Acceptance;
use super::alignment::Fit;
use super::appearance::{Normaliser, Reading, SizeMismatch};
use super::hypothesis::Reach;
use super::object::{KnownObject, Query};
use super::options::{AppearanceOf, Distance, ObjectOptions, Stages};
use super::ranked_object::{RankedObject, explained_part};
use super::reason::Reason;
use super::recognition::{Candidate, Decision, Pose, Recognition, Warning};
use crate::eigen::{ClassCovariance, EigenError, Eigenspace, RadiusIndex};
use crate::imaging::{Frame, Image};
use crate::recognition::Colour;
use crate::vision::GradientField;
use crate::vision::segmentation::{Region, Segmentation};

/// Objects that are compared in their own eigenspaces. On 20 objects and 12 dimensions the right one is always among
/// the first three.
pub(super) const CANDIDATES: usize = 5;
/// A warning is given when the next object is not farther than so many times.
const CLOSE_SECOND: f64 = 1.1;
/// … or explains no less than this part of what the first does.
const CLOSE_SECOND_PART: f64 = 0.8;

/// The steps of a recognition, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// B(7): the picture as a vector.
    Appearance,
    /// Projection into the universal eigenspace, and the eigenpoints near.
    Universal,
    /// The likeliest objects' own eigenspaces: which object, and its pose.
    Object,
}

/// A training view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewName {
    /// Its own name, unique in the database.
    pub id: String,
    /// The object shown.
    pub label: String,
    /// Turn about the vertical, in [0, 360).
    pub pose_deg: Option<f64>,
}

/// A trained object database.
pub struct Objects {
    pub(super) options: ObjectOptions,
    pub(super) normaliser: Normaliser,
    /// Sorted by label, then pose, then id.
    pub(super) views: Vec<ViewName>,
    pub(super) universal: Eigenspace,
    pub(super) radius_index: RadiusIndex,
    /// Index of the object of each view.
    pub(super) object_of_view: Vec<usize>,
    /// By label, ascending.
    pub(super) objects: Vec<KnownObject>,
    /// As `objects`, if they are ordered by B(15).
    pub(super) covariances: Option<Vec<ClassCovariance>>,
    pub(super) acceptance: Option<Acceptance>,
}

/// An object and the distance of a query from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearObject {
    pub object: usize,
    pub distance: f64,
}

impl NearObject {
    pub fn by_distance(a: &NearObject, b: &NearObject) -> std::cmp::Ordering {
        a.distance.total_cmp(&b.distance)
    }
}

/// The objects that the universal eigenspace proposes.
struct Shortlist {
    /// The likeliest first, [`CANDIDATES`] at most; with their Mahalanobis distances if they are ordered by these.
    objects: Vec<NearObject>,
    /// Whether any has a view within the radius of acceptance.
    is_near: bool,
}

/// B(15): the covariance of each object's eigenpoints, if the option asks for it. `points` are views × dimension.
pub(super) fn class_covariances(
    distance: Distance,
    points: &[f32],
    object_of_view: &[usize],
    objects: usize,
) -> Result<Option<Vec<ClassCovariance>>, EigenError> {
    let dimension = points.len() / object_of_view.len();
    match distance {
        Distance::Euclidean => Ok(None),
        Distance::Mahalanobis => ClassCovariance::fit(points, dimension, object_of_view, objects).map(Some),
    }
}

impl Objects {
    /// Recognise a picture. Calls `finished` after each stage.
    ///
    /// # Errors
    /// [`SizeMismatch`] if the picture is of another size and `resize` is `never`.
    pub fn recognise(
        &self,
        frame: &Frame,
        mut finished: impl FnMut(Stage),
    ) -> Result<Recognition, SizeMismatch> {
        let reading = self.normaliser.read(frame)?; // B(7)
        finished(Stage::Appearance);
        let blank = if self.options.segment { Warning::NoRegion } else { Warning::Blank };
        Ok(self.recognise_reading(&reading, blank, finished))
    }

    /// Recognise a region of a picture, cropped and normalised as exemplars are with `segment`. Calls `finished` after
    /// each stage.
    pub fn recognise_region(
        &self,
        frame: &Frame,
        segmentation: &Segmentation,
        region: &Region,
        mut finished: impl FnMut(Stage),
    ) -> Recognition {
        let reading = self.normaliser.read_region(frame, segmentation, region); // B(7)
        finished(Stage::Appearance);
        self.recognise_reading(&reading, Warning::Blank, finished)
    }

    /// `blank` is the warning for a blank appearance.
    fn recognise_reading(
        &self,
        Reading { appearance, field }: &Reading,
        blank: Warning,
        mut finished: impl FnMut(Stage),
    ) -> Recognition {
        let mut warnings = appearance.warnings();
        if self.options.colour == Colour::Opponent && !appearance.is_colour {
            warnings.push(Warning::GrayFrame);
        }
        if appearance.is_blank() {
            warnings.push(blank);
            let reasons = vec![Reason::Light { over_exposed: appearance.over_exposed }];
            return Recognition { decision: None, candidates: Vec::new(), reasons, warnings };
        }
        let (ranked, is_near) = match field {
            None => {
                let query = Query::new(&self.universal, &appearance.vector); // B(13)
                let shortlist = self.shortlist(&query.point); // B(14), B(15)
                finished(Stage::Universal);
                (self.ranked_by_distance(&query, &shortlist.objects), shortlist.is_near)
            }
            Some(field) => {
                let hypotheses = self.hypotheses(field, Reach::Near, |_| false); // B(13), B(14)
                finished(Stage::Universal);
                let views_of = |object: usize| &self.objects[object].views;
                (self.ranked_by_alignment(field, Reach::Near, &hypotheses, views_of), true)
            }
        };
        let accepted = ranked.first().filter(|best| is_near && self.accepts(best)); // B(16)
        warnings.extend(self.doubts(&ranked, accepted.is_some()));
        let decision = accepted.map(|best| self.decide(best, field.as_ref()));
        let recognition = Recognition {
            reasons: if decision.is_none() {
                self.reasons(appearance, field.as_ref(), &ranked)
            } else {
                Vec::new()
            },
            decision,
            candidates: ranked.iter().map(|object| self.candidate(object)).collect(),
            warnings,
        };
        finished(Stage::Object);
        recognition
    }

    fn shortlist(&self, point: &[f32]) -> Shortlist {
        let radius = self.acceptance.as_ref().map_or(f64::INFINITY, |acceptance| acceptance.radius);
        let near = self.radius_index.within(point, radius); // B(16)
        let is_near = !near.is_empty();
        // candidates are given even where nothing is near
        let near = if is_near { near } else { self.radius_index.within(point, f64::INFINITY) };
        let mut seen = vec![false; self.objects.len()];
        let mut objects: Vec<NearObject> = near
            .iter()
            .map(|neighbour| self.object_of_view[neighbour.index])
            .filter(|&object| !std::mem::replace(&mut seen[object], true)) // B(14)
            .map(|object| NearObject { object, distance: 0.0 })
            .collect();
        self.order_by_covariance(&mut objects, point);
        objects.truncate(CANDIDATES);
        Shortlist { objects, is_near }
    }

    /// B(15): with `distance: "mahalanobis"`, set the distances of objects to it and sort them by it.
    pub(super) fn order_by_covariance(&self, objects: &mut [NearObject], point: &[f32]) {
        if let Some(covariances) = &self.covariances {
            objects.iter_mut().for_each(|near| near.distance = covariances[near.object].distance(point));
            objects.sort_by(NearObject::by_distance);
        }
    }

    /// B§6: whether that order decides, with the universal eigenspace alone.
    pub(super) fn covariance_decides(&self) -> bool {
        self.options.stages == Stages::UniversalOnly && self.covariances.is_some()
    }

    fn accepts(&self, ranked: &RankedObject) -> bool {
        self.acceptance.as_ref().is_none_or(|acceptance| ranked.relative <= acceptance.threshold)
    }

    /// B(16): the largest total distance that is accepted as an object; `None` where the explained part decides.
    pub(super) fn threshold(&self, object: usize) -> Option<f64> {
        let by_distance =
            self.acceptance.as_ref().filter(|_| self.options.appearance == AppearanceOf::Intensity);
        Some(by_distance?.threshold * self.objects[object].root_scale())
    }

    /// Whether a held-out view at a distance from an object is accepted as it; of gradients the distance is the ratio of what is
    /// not explained.
    pub(super) fn is_accepted(&self, found: NearObject) -> bool {
        let most = match self.options.appearance {
            AppearanceOf::Intensity => self.threshold(found.object),
            AppearanceOf::Gradient => self.acceptance.as_ref().map(|acceptance| acceptance.threshold),
        };
        most.is_some_and(|most| found.distance <= most)
    }

    /// The least part of an object that a picture has to explain; `None` where the distance decides.
    pub fn least_explained(&self) -> Option<f64> {
        let by_part = self.acceptance.as_ref().filter(|_| self.options.appearance == AppearanceOf::Gradient);
        Some(explained_part(by_part?.threshold))
    }

    fn doubts(&self, ranking: &[RankedObject], is_accepted: bool) -> impl Iterator<Item = Warning> {
        let is_close = match ranking {
            [first, second, ..] => match (&first.fit, &second.fit) {
                (Some(first), Some(second)) => second.explained >= CLOSE_SECOND_PART * first.explained,
                _ => second.distance.total() <= CLOSE_SECOND * first.distance.total(),
            },
            _ => false,
        };
        let doubts = [
            (!is_accepted).then_some(Warning::BeyondThreshold),
            is_close.then_some(Warning::CloseSecond),
            self.acceptance.is_none().then_some(Warning::NotCalibrated),
        ];
        doubts.into_iter().flatten()
    }

    fn decide(&self, best: &RankedObject, field: Option<&GradientField>) -> Decision {
        let object = &self.objects[best.object];
        let acceptance = self.acceptance.as_ref();
        let evidence = best.relative.max(f64::MIN_POSITIVE).ln();
        let confidence = acceptance.and_then(|a| a.confidence).map(|logistic| logistic.at(evidence));
        let pose = acceptance.and_then(|a| match (&best.fit, field) {
            (Some(fit), Some(field)) => self.aligned_pose(field, best.object, fit, a),
            _ => object.pose(&best.distance, a.tangential_part, a.distance_ratio),
        });
        let alignment = best.fit.as_ref().map(|fit| self.normaliser.alignment(&fit.place));
        Decision { label: object.label.clone(), confidence, pose, alignment }
    }

    /// The pose of an aligned object; its other side is tried too.
    fn aligned_pose(
        &self,
        field: &GradientField,
        object: usize,
        fit: &Fit,
        acceptance: &Acceptance,
    ) -> Option<Pose> {
        let known = &self.objects[object];
        let other = self.other_side(field, fit, object, &known.views);
        let (nearest, second) = match &other {
            Some(other) if other.cost < fit.cost => (other, Some(fit)),
            _ => (fit, other.as_ref()),
        };
        known.aligned_pose(nearest, second, acceptance)
    }

    fn candidate(&self, ranked: &RankedObject) -> Candidate {
        Candidate {
            label: self.objects[ranked.object].label.clone(),
            distance_in_space: ranked.distance.in_space,
            distance_from_space: ranked.distance.from_space,
            threshold: self.threshold(ranked.object),
            mahalanobis: ranked.mahalanobis,
            explained: ranked.fit.as_ref().map(|fit| fit.explained),
            least_explained: self.least_explained(),
        }
    }

    /// The options it was trained with.
    pub fn options(&self) -> &ObjectOptions {
        &self.options
    }

    /// Coordinates of the universal eigenspace.
    pub fn dimension(&self) -> usize {
        self.universal.dimension()
    }

    /// Training views, sorted by label, then pose, then id.
    pub fn views(&self) -> &[ViewName] {
        &self.views
    }

    /// The different labels, ascending.
    pub fn labels(&self) -> Vec<&str> {
        self.objects.iter().map(|object| object.label.as_str()).collect()
    }

    /// The mean appearance as a picture of samples, its values spread over 0..=255.
    pub fn mean_picture(&self) -> Image {
        let mean = &self.universal.mean;
        let brightest = mean.iter().fold(f32::MIN_POSITIVE, |most, &v| most.max(v));
        self.normaliser.picture(mean.iter().map(|v| 255.0 * v.max(0.0) / brightest), 0.0)
    }

    /// Eigenimage `i` of the universal eigenspace, counted from 0, as a picture of samples; zero is mid-gray.
    /// `None` beyond the dimension.
    pub fn eigenimage(&self, i: usize) -> Option<Image> {
        let row = self.universal.basis.chunks_exact(self.universal.length()).nth(i)?;
        let most = row.iter().fold(f32::MIN_POSITIVE, |most, v| most.max(v.abs()));
        Some(self.normaliser.picture(row.iter().map(|v| 127.5 * (1.0 + v / most)), 127.5))
    }

    /// Memory held, to within what an allocator adds.
    pub fn bytes(&self) -> usize {
        let views: usize =
            self.views.iter().map(|n| size_of::<ViewName>() + n.id.len() + n.label.len()).sum();
        let universal = 4 * (self.universal.mean.len() + self.universal.basis.len());
        let objects: usize = self.objects.iter().map(KnownObject::bytes).sum();
        let covariances = self.covariances.as_ref().map_or(0, |c| c.len() * 8 * self.dimension().pow(2));
        size_of::<Objects>() + views + universal + self.radius_index.bytes() + objects + covariances
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_pictures::{noisy, normaliser, thing, turntable, vase, view};
    use super::super::{Resize, View, train};
    use super::*;
    use crate::angle::angular_distance_deg;
    use crate::eigen::Search;

    fn trained(views: Vec<View>, options: &ObjectOptions) -> Objects {
        train(views, &normaliser(options), options).unwrap().0
    }

    fn asked(model: &Objects, frame: &Frame) -> Recognition {
        model.recognise(frame, |_| ()).unwrap()
    }

    /// Things 0..4 seen at poses between their views: how many were named right, and the worst pose error.
    fn between_views(model: &Objects) -> (usize, f64) {
        let (mut right, mut worst) = (0, 0.0_f64);
        for seed in 0..4 {
            for turn in (7..360).step_by(30).map(f64::from) {
                let frame = noisy(&thing(seed, turn), 1.0, 77 * seed + turn as u64);
                let Some(decision) = asked(model, &frame).decision else { continue };
                right += usize::from(decision.label == format!("thing{seed}"));
                let pose = decision.pose.unwrap();
                assert!(pose.reliable && pose.alternative_deg.is_none(), "{pose:?}");
                worst = worst.max(angular_distance_deg(pose.turn_deg, turn));
            }
        }
        (right, worst)
    }

    #[test]
    fn things_are_named_and_their_poses_found_between_views() {
        for options in [
            ObjectOptions::default(),
            ObjectOptions { stages: Stages::UniversalOnly, ..ObjectOptions::default() },
            ObjectOptions { distance: Distance::Mahalanobis, ..ObjectOptions::default() },
            ObjectOptions {
                stages: Stages::UniversalOnly,
                distance: Distance::Mahalanobis,
                ..ObjectOptions::default()
            },
        ] {
            let (right, worst) = between_views(&trained(turntable(4, 15, &options), &options));
            assert!(right == 48 && worst < 2.0, "{options:?}: {right} of 48, worst {worst}°");
        }
    }

    #[test]
    fn every_search_gives_the_same_answers() {
        let answers = [Search::KdTree, Search::Slabs, Search::Exhaustive].map(|search| {
            let options = ObjectOptions { search, ..ObjectOptions::default() };
            let model = trained(turntable(5, 20, &options), &options);
            (0..9).map(|seed| asked(&model, &thing(seed, 33.0 * seed as f64))).collect::<Vec<_>>()
        });
        assert_eq!(answers[0], answers[1]);
        assert_eq!(answers[1], answers[2]);
    }

    #[test]
    fn a_thing_never_seen_is_unknown_and_told_with_its_evidence() {
        let model = trained(turntable(4, 15, &ObjectOptions::default()), &ObjectOptions::default());
        for seed in 20..30 {
            let recognition = asked(&model, &thing(seed, 50.0));
            assert_eq!(recognition.decision, None, "thing {seed}: {:?}", recognition.candidates);
            assert!(recognition.warnings.contains(&Warning::BeyondThreshold));
            assert!(!recognition.candidates.is_empty());
        }
    }

    #[test]
    fn candidates_come_nearest_first_with_their_thresholds() {
        let options = ObjectOptions::of(AppearanceOf::Intensity);
        let model = trained(turntable(8, 20, &options), &options);
        let recognition = asked(&model, &thing(3, 10.0));
        let total = |c: &Candidate| c.distance_in_space.hypot(c.distance_from_space);
        assert!(recognition.candidates.is_sorted_by(|a, b| total(a) <= total(b)));
        let best = &recognition.candidates[0];
        assert!(best.label == "thing3" && total(best) <= best.threshold.unwrap());
        assert!(recognition.decision.unwrap().confidence.unwrap() > 0.9);
        assert!(recognition.candidates.len() <= CANDIDATES);
    }

    #[test]
    fn a_thing_that_looks_the_same_from_everywhere_has_no_reliable_pose() {
        let options = ObjectOptions::default();
        let mut views = turntable(3, 15, &options);
        for pose in (0..360).step_by(15) {
            let frame = noisy(&vase(), 1.0, 5000 + pose);
            views.push(view(&normaliser(&options), "vase", Some(pose as f64), &frame));
        }
        let model = trained(views, &options);
        for seed in 0..10 {
            let decision = asked(&model, &noisy(&vase(), 1.0, 9000 + seed)).decision.unwrap();
            assert_eq!(decision.label, "vase");
            let pose = decision.pose.unwrap();
            assert!(!pose.reliable, "{pose:?}");
            assert!(pose.sigma_deg > 10.0 || pose.alternative_deg.is_some(), "{pose:?}");
        }
    }

    #[test]
    fn a_thing_with_two_equal_sides_names_the_other_pose() {
        let options = ObjectOptions::default();
        let mut views = turntable(3, 15, &options);
        for pose in (0..360).step_by(10) {
            // the same after half a turn
            let frame = noisy(&thing(7, 2.0 * pose as f64), 0.5, 400 + pose);
            views.push(view(&normaliser(&options), "twofold", Some(pose as f64), &frame));
        }
        let model = trained(views, &options);
        let pose = asked(&model, &thing(7, 2.0 * 44.0)).decision.unwrap().pose.unwrap();
        let (a, b) = (pose.turn_deg, pose.alternative_deg.expect("another pose"));
        let apart = angular_distance_deg;
        assert!(apart(a, b) > 175.0 && apart(a % 180.0, 44.0) < 2.0, "{pose:?}");
        assert!(!pose.reliable);
    }

    #[test]
    fn few_views_and_gaps_give_no_reliable_pose() {
        let options = ObjectOptions::default();
        let nine = trained(turntable(4, 40, &options), &options);
        let decision = asked(&nine, &thing(1, 81.0)).decision.unwrap();
        assert!(!decision.pose.unwrap().reliable, "nine views");
        let lacking = turntable(4, 10, &options).into_iter();
        let lacking = lacking.filter(|view| !(120.0..160.0).contains(&view.pose_deg.unwrap()));
        let model = trained(lacking.collect(), &options);
        let reliable = |turn: f64| {
            asked(&model, &thing(2, turn)).decision.is_some_and(|decision| decision.pose.unwrap().reliable)
        };
        assert!(reliable(44.0) && !reliable(138.0));
    }

    #[test]
    fn views_without_poses_are_recognised_without_one() {
        let options = ObjectOptions::default();
        let without = turntable(3, 15, &options).into_iter().map(|view| View { pose_deg: None, ..view });
        let model = trained(without.collect(), &options);
        let decision = asked(&model, &thing(2, 62.0)).decision.unwrap();
        assert_eq!((decision.label.as_str(), decision.pose), ("thing2", None));
    }

    #[test]
    fn one_view_an_object_is_not_calibrated_and_says_so() {
        let options = ObjectOptions::default();
        let model = trained(turntable(3, 360, &options), &options);
        let recognition = asked(&model, &thing(1, 0.0));
        let decision = recognition.decision.unwrap();
        assert_eq!((decision.label.as_str(), decision.confidence, decision.pose), ("thing1", None, None));
        assert!(recognition.warnings.contains(&Warning::NotCalibrated));
    }

    #[test]
    fn other_sizes_are_fitted_with_a_warning_or_refused() {
        let options = ObjectOptions::default();
        let model = trained(turntable(3, 15, &options), &options);
        let large = crate::imaging::fitted(&thing(1, 20.0).luminance, 96, 96);
        let recognition = asked(&model, &Frame::gray(large.clone()));
        assert_eq!(recognition.warnings, [Warning::Resized]);
        assert_eq!(recognition.decision.unwrap().label, "thing1");
        let never = ObjectOptions { resize: Resize::Never, ..options };
        let error =
            trained(turntable(3, 15, &never), &never).recognise(&Frame::gray(large), |_| ()).unwrap_err();
        assert_eq!((error.width_px, error.expected_width_px), (96, 48));
    }

    #[test]
    fn an_over_exposed_picture_is_doubted() {
        let model = trained(turntable(3, 15, &ObjectOptions::default()), &ObjectOptions::default());
        let bright = thing(1, 20.0).luminance.pixels().iter().map(|v| (9.0 * v).min(255.0)).collect();
        let recognition = asked(&model, &Frame::gray(Image::new(48, 48, bright)));
        assert!(recognition.warnings.contains(&Warning::OverExposed), "{recognition:?}");
    }

    #[test]
    fn a_black_picture_shows_nothing() {
        let model = trained(turntable(3, 30, &ObjectOptions::default()), &ObjectOptions::default());
        let recognition = asked(&model, &Frame::gray(Image::from_fn(48, 48, |_, _| 0.0)));
        assert_eq!((recognition.decision, recognition.warnings), (None, vec![Warning::Blank]));
    }

    #[test]
    fn aligned_candidates_come_by_what_is_explained() {
        let model = trained(turntable(8, 20, &ObjectOptions::default()), &ObjectOptions::default());
        let recognition = asked(&model, &thing(3, 10.0));
        assert!(recognition.candidates.is_sorted_by(|a, b| a.explained >= b.explained));
        let best = &recognition.candidates[0];
        assert!(best.label == "thing3" && best.explained > best.least_explained && best.threshold.is_none());
        assert!(recognition.decision.unwrap().confidence.unwrap() > 0.9 && recognition.reasons.is_empty());
    }

    #[test]
    fn eigenimages_are_pictures_of_samples_or_of_cells() {
        for (of, side) in [(AppearanceOf::Intensity, 48), (AppearanceOf::Gradient, 256)] {
            eigenimages_have(of, side);
        }
    }

    fn eigenimages_have(of: AppearanceOf, side: usize) {
        let options = ObjectOptions::of(of);
        let model = trained(turntable(3, 30, &options), &options);
        let mean = model.mean_picture();
        assert_eq!((mean.width(), mean.height()), (side, side));
        assert!(mean.pixels().iter().all(|v| (-1e-3..=255.001).contains(v)));
        assert!(model.eigenimage(model.dimension()).is_none());
        let first = model.eigenimage(0).unwrap();
        assert!(first.pixels().iter().any(|v| !(1.0..=254.0).contains(v)));
    }
}
