//! A trained object database: an immutable value that recognises pictures.

use super::appearance::{Appearance, Canvas, SizeMismatch};
use super::calibration::Calibration;
use super::object::{Closeness, KnownObject};
use super::options::{ObjectOptions, Search, Stages};
use super::recognition::{Candidate, Decision, Recognition, Warning};
use crate::eigen::{ClassCovariance, Eigenspace, Vicinity, Way};
use crate::imaging::{Frame, Image};
use crate::vision::segmentation::{Region, Segmentation};

/// Objects that are looked at closely. On 20 objects and 12 dimensions the right one is always among the first three.
pub(super) const CANDIDATES: usize = 5;
/// An answer is doubted when the next object is not farther than so many times.
const CLOSE_SECOND: f64 = 1.1;

/// The steps of a recognition, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// B(7): the picture as a vector.
    Appearance,
    /// Projection into the universal eigenspace, and the eigenpoints near.
    Universal,
    /// The likeliest objects' own eigenspaces: which, and how turned.
    Object,
}

/// A training view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewName {
    /// Its own name, unique in the database.
    pub id: String,
    /// The object shown.
    pub label: String,
    /// How it is turned, in [0, 360).
    pub pose_deg: Option<f64>,
}

/// A trained object database.
pub struct Objects {
    pub(super) options: ObjectOptions,
    pub(super) canvas: Canvas,
    /// Sorted by label, then pose, then id.
    pub(super) names: Vec<ViewName>,
    pub(super) universal: Eigenspace,
    pub(super) vicinity: Vicinity,
    /// Index of the object of each view.
    pub(super) owner: Vec<usize>,
    /// By label, ascending.
    pub(super) objects: Vec<KnownObject>,
    /// As `objects`, if they are ordered by B(15).
    pub(super) covariances: Option<Vec<ClassCovariance>>,
    pub(super) calibration: Option<Calibration>,
}

/// The way that an option names.
pub(super) fn way(search: Search) -> Way {
    match search {
        Search::KdTree => Way::KdTree,
        Search::Slabs => Way::Slabs,
        Search::Exhaustive => Way::Exhaustive,
    }
}

impl Objects {
    /// Recognise a picture. `finished` is told the end of each stage: the caller holds the clock.
    ///
    /// # Errors
    /// [`SizeMismatch`] if the picture is of another size and `resize` is `never`.
    pub fn recognise(
        &self,
        frame: &Frame,
        mut finished: impl FnMut(Stage),
    ) -> Result<Recognition, SizeMismatch> {
        let appearance = self.canvas.appearance(frame)?; // B(7)
        finished(Stage::Appearance);
        let blank = if self.options.segment { Warning::NoRegion } else { Warning::Blank };
        Ok(self.recognise_appearance(&appearance, blank, finished))
    }

    /// Recognise a region of a picture, cut out by the recipe that `segment` names for exemplars. `finished` as in
    /// [`Objects::recognise`].
    pub fn recognise_region(
        &self,
        luminance: &Image,
        segmentation: &Segmentation,
        region: &Region,
        mut finished: impl FnMut(Stage),
    ) -> Recognition {
        let appearance = self.canvas.region_appearance(luminance, segmentation, region); // B(7)
        finished(Stage::Appearance);
        self.recognise_appearance(&appearance, Warning::Blank, finished)
    }

    /// `blank` says why an appearance is blank, if it is.
    fn recognise_appearance(
        &self,
        appearance: &Appearance,
        blank: Warning,
        mut finished: impl FnMut(Stage),
    ) -> Recognition {
        let doubts = [
            (appearance.resized, Warning::Resized),
            (appearance.touches_border, Warning::TouchesBorder),
            (appearance.crowded, Warning::SeveralRegions),
            (appearance.over_exposed, Warning::OverExposed),
            (appearance.is_blank(), blank),
        ];
        let mut warnings: Vec<Warning> =
            doubts.into_iter().filter(|(is_so, _)| *is_so).map(|(_, warning)| warning).collect();
        if appearance.is_blank() {
            return Recognition { decision: None, candidates: Vec::new(), warnings };
        }

        let (point, outside) = self.universal.locate(&appearance.vector); // B(13)
        let (likeliest, is_near) = self.likeliest(&point);
        finished(Stage::Universal);

        let mut close: Vec<(usize, Option<f64>, Closeness)> = likeliest
            .into_iter()
            .map(|(object, mahalanobis)| {
                let closeness = self.objects[object].closeness(&appearance.vector, (&point, outside));
                (object, mahalanobis, closeness)
            })
            .collect();
        if !self.order_stands() {
            close.sort_by(|a, b| a.2.total().total_cmp(&b.2.total()));
        }
        let decision = close.first().and_then(|(object, _, closeness)| {
            let accepted =
                is_near && self.threshold(*object).is_none_or(|threshold| closeness.total() <= threshold); // B(16)
            accepted.then(|| self.decide(*object, closeness))
        });
        if decision.is_none() {
            warnings.push(Warning::BeyondThreshold);
        }
        if let [first, second, ..] = &close[..]
            && second.2.total() <= CLOSE_SECOND * first.2.total()
        {
            warnings.push(Warning::CloseSecond);
        }
        if self.calibration.is_none() {
            warnings.push(Warning::NotCalibrated);
        }
        let candidates = close.into_iter().map(|(object, mahalanobis, closeness)| Candidate {
            label: self.objects[object].label.clone(),
            distance_in_space: closeness.in_space,
            distance_from_space: closeness.from_space,
            threshold: self.threshold(object),
            mahalanobis,
        });
        let recognition = Recognition { decision, candidates: candidates.collect(), warnings };
        finished(Stage::Object);
        recognition
    }

    /// The objects to look at closely, the likeliest first, and whether any has a view within the radius.
    fn likeliest(&self, point: &[f32]) -> (Vec<(usize, Option<f64>)>, bool) {
        let radius = self.calibration.as_ref().map_or(f64::INFINITY, |calibration| calibration.radius);
        let near = self.vicinity.within(point, radius); // B(16)
        let is_near = !near.is_empty();
        // the evidence is given even where nothing is near
        let near = if is_near { near } else { self.vicinity.within(point, f64::INFINITY) };
        let mut seen = vec![false; self.objects.len()];
        let owners = near.iter().map(|neighbour| self.owner[neighbour.index]);
        let mut found: Vec<(usize, f64)> = owners
            .filter(|&object| !std::mem::replace(&mut seen[object], true)) // B(14)
            .map(|object| (object, 0.0))
            .collect();
        self.order_by_covariance(&mut found, point);
        found.truncate(CANDIDATES);
        let is_measured = self.covariances.is_some();
        let found = found.into_iter().map(|(object, at)| (object, is_measured.then_some(at)));
        (found.collect(), is_near)
    }

    /// B(15): with `distance: "mahalanobis"` objects are ordered by it, and each gets its distance.
    pub(super) fn order_by_covariance(&self, found: &mut [(usize, f64)], point: &[f32]) {
        if let Some(covariances) = &self.covariances {
            found.iter_mut().for_each(|(object, at)| *at = covariances[*object].distance(point));
            found.sort_by(|a, b| a.1.total_cmp(&b.1));
        }
    }

    /// B§6: whether that order decides, with the universal eigenspace alone.
    pub(super) fn order_stands(&self) -> bool {
        self.options.stages == Stages::UniversalOnly && self.covariances.is_some()
    }

    /// B(16): the largest total distance that is accepted as an object.
    pub(super) fn threshold(&self, object: usize) -> Option<f64> {
        Some(self.calibration.as_ref()?.threshold * self.root_scale(object))
    }

    /// What distances from an object are measured by.
    fn root_scale(&self, object: usize) -> f64 {
        self.objects[object].scale.map_or(1.0, f64::sqrt)
    }

    fn decide(&self, object: usize, closeness: &Closeness) -> Decision {
        let known = &self.objects[object];
        let evidence = (closeness.total().max(f64::MIN_POSITIVE) / self.root_scale(object)).ln();
        let calibration = self.calibration.as_ref();
        let confidence = calibration.and_then(|c| c.confidence).map(|logistic| logistic.at(evidence));
        let pose = calibration.and_then(|c| known.pose(closeness, c.angle_part, c.shrink));
        Decision { label: known.label.clone(), confidence, pose }
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
        &self.names
    }

    /// The different labels, ascending.
    pub fn labels(&self) -> Vec<&str> {
        self.objects.iter().map(|object| object.label.as_str()).collect()
    }

    /// The mean appearance as a picture of samples, its values spread over 0..=255.
    pub fn mean_picture(&self) -> Image {
        let mean = &self.universal.mean;
        let brightest = mean.iter().fold(f32::MIN_POSITIVE, |most, &v| most.max(v));
        self.picture(mean.iter().map(|v| 255.0 * v.max(0.0) / brightest))
    }

    /// Eigenimage `i` of the universal eigenspace, counted from 0, as a picture of samples; zero is mid-gray.
    /// `None` beyond the dimension.
    pub fn eigenimage(&self, i: usize) -> Option<Image> {
        let row = self.universal.basis.chunks_exact(self.universal.length()).nth(i)?;
        let most = row.iter().fold(f32::MIN_POSITIVE, |most, v| most.max(v.abs()));
        Some(self.picture(row.iter().map(|v| 127.5 * (1.0 + v / most))))
    }

    pub(super) fn picture(&self, pixels: impl Iterator<Item = f32>) -> Image {
        let (width, height) = self.canvas.samples();
        Image::new(width, height, pixels.collect())
    }

    /// Memory held, to within what an allocator adds.
    pub fn bytes(&self) -> usize {
        let names: usize =
            self.names.iter().map(|n| size_of::<ViewName>() + n.id.len() + n.label.len()).sum();
        let universal = 4 * (self.universal.mean.len() + self.universal.basis.len());
        let objects: usize = self.objects.iter().map(KnownObject::bytes).sum();
        let covariances = self.covariances.as_ref().map_or(0, |c| c.len() * 8 * self.dimension().pow(2));
        size_of::<Objects>() + names + universal + self.vicinity.bytes() + objects + covariances
    }
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{canvas, noisy, thing, turntable, vase, view};
    use super::super::{Distance, Resize, View};
    use super::*;

    fn trained(views: Vec<View>, options: &ObjectOptions) -> Objects {
        Objects::train(views, &canvas(options), options).unwrap().0
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
                worst = worst.max(super::super::manifold::apart_deg(pose.turn_deg, turn));
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
        let model = trained(turntable(8, 20, &ObjectOptions::default()), &ObjectOptions::default());
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
            views.push(view(&canvas(&options), "vase", Some(pose as f64), &frame));
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
            views.push(view(&canvas(&options), "twofold", Some(pose as f64), &frame));
        }
        let model = trained(views, &options);
        let pose = asked(&model, &thing(7, 2.0 * 44.0)).decision.unwrap().pose.unwrap();
        let (a, b) = (pose.turn_deg, pose.alternative_deg.expect("another pose"));
        let apart = |x: f64, y: f64| super::super::manifold::apart_deg(x, y);
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
    fn eigenimages_are_pictures_of_samples() {
        let model = trained(turntable(3, 30, &ObjectOptions::default()), &ObjectOptions::default());
        let mean = model.mean_picture();
        assert_eq!((mean.width(), mean.height()), (48, 48));
        assert!(mean.pixels().iter().all(|v| (-1e-3..=255.001).contains(v)));
        assert!(model.eigenimage(model.dimension()).is_none());
        let first = model.eigenimage(0).unwrap();
        assert!(first.pixels().iter().any(|v| !(1.0..=254.0).contains(v)));
    }
}
