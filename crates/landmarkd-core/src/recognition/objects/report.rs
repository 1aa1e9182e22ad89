//! The report of a training: the eigenspace, rates of held-out views, and what is wrong with the exemplars.

use std::collections::BTreeMap;

use super::held_out::{HeldOutView, Trial};
use super::manifold::{ONE_POSE_DEG, wide_gaps};
use super::model::{NearObject, Objects};
use super::object::{KnownObject, euclidean_distance};
use super::training::View;
use crate::angle::angular_distance_deg;
use crate::eigen::{RadiusIndex, Search};
use crate::statistics::quantile;

/// Pictures of unit energy at a smaller distance are the same but for noise.
const MAX_DUPLICATE_DISTANCE: f64 = 0.003;
/// Most pairs that are listed.
const MAX_PAIRS: usize = 100;
/// A smaller pose error is small.
const SMALL_ERROR_DEG: f64 = 5.0;

/// The report of a training. Rates are of views that were left out: see [`HeldOut`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingReport {
    /// Variance along the directions of the universal eigenspace, descending; for more than 1500 views the leading ones.
    pub spectrum: Vec<f64>,
    /// The part of all variance that the kept directions hold, 0..=1.
    pub energy_kept: f64,
    /// Directions kept.
    pub dimension: usize,
    /// Width of the database's pictures.
    pub width_px: usize,
    /// Height of the database's pictures.
    pub height_px: usize,
    /// Components of an appearance.
    pub vector_length: usize,
    /// Views.
    pub exemplars: usize,
    /// Different labels.
    pub labels: usize,
    /// B Fig. 9: held-out views whose nearest eigenpoint is of their own object, by dimension 1, 2, 3, …
    pub rate_by_dimension: Vec<DimensionRate>,
    /// Held-out views that were taken for another object, or for none.
    pub confusion: Vec<Confusion>,
    /// Answers to held-out views and unknown objects; `None` if no object has two views.
    pub held_out: Option<HeldOut>,
    /// The least part of an object that a picture has to explain; `None` of intensities, and if not calibrated.
    pub least_explained: Option<f64>,
    /// By object, ascending.
    pub objects: Vec<ObjectReport>,
    /// Pairs of ids of views that are all but the same picture.
    pub near_duplicates: Vec<(String, String)>,
    /// Ids of views of one object with one pose: the manifold takes their mean.
    pub repeated_poses: Vec<(String, String)>,
    /// Ids of views with many saturated pixels.
    pub over_exposed: Vec<String>,
    /// Ids of views with hardly a bright pixel.
    pub under_exposed: Vec<String>,
    /// Ids of views that are black, or in which nothing stands out. They are not trained.
    pub blank: Vec<String>,
    /// Ids of views that were not of the database's size.
    pub resized: Vec<String>,
    /// Ids of views whose object was cropped and reaches the border.
    pub touches_border: Vec<String>,
    /// Ids of views whose object was cropped beside another one nearly as large.
    pub several_regions: Vec<String>,
}

/// Held-out views recognised at a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DimensionRate {
    /// Leading coordinates that are compared.
    pub dimension: usize,
    /// Views whose nearest eigenpoint is of their own object.
    pub right: usize,
    /// Views that were held out.
    pub trials: usize,
}

/// Held-out views of one object that were given one wrong answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Confusion {
    /// Label of the object.
    pub shown: String,
    /// Label of the answer; `None`: refused.
    pub named: Option<String>,
    /// Number of such views.
    pub times: usize,
}

/// Each view in turn is left out of its object and shown, of gradients disturbed; and is shown to the other objects alone. The threshold was
/// chosen on the same views, so `known_accepted` is about `accept` of them; other views may fare worse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    /// Views of objects with at least two.
    pub known: usize,
    /// … accepted as something.
    pub known_accepted: usize,
    /// … accepted, and named right.
    pub known_right: usize,
    /// Views shown to the other objects alone; 0 if there is only one object.
    pub unknown: usize,
    /// … refused.
    pub unknown_refused: usize,
}

/// The report on one object.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectReport {
    /// Its label.
    pub label: String,
    /// Number of its views.
    pub views: usize,
    /// Of these, with a pose.
    pub views_with_pose: usize,
    /// The largest total distance that is accepted as this object; `None` where the explained part decides.
    pub threshold: Option<f64>,
    /// Pose errors of held-out views; `None` if there are too few.
    pub pose: Option<PoseErrors>,
    /// Poses that no view is near: the pose is not reliable there.
    pub gaps: Vec<Gap>,
}

/// Errors of the pose of held-out views, with twice the gap that a query meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseErrors {
    /// Views that were held out.
    pub trials: usize,
    /// Mean of the errors.
    pub mean_deg: f64,
    /// Median of the errors.
    pub median_deg: f64,
    /// 95th percentile of the errors.
    pub p95_deg: f64,
    /// Number of errors of 5° at most.
    pub within_5_deg: usize,
}

/// Poses from one view to the next that are far apart; `to_deg` may be less than `from_deg`, across 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The pose before the gap.
    pub from_deg: f64,
    /// The pose behind it.
    pub to_deg: f64,
}

/// What a report is made of.
pub(super) struct ReportInput<'a> {
    pub model: &'a Objects,
    /// In the model's order, their vectors moved to `rows`.
    pub views: &'a [View],
    /// views × vector length.
    pub rows: &'a [f32],
    pub held_out: &'a [HeldOutView],
    pub trials: &'a [Trial],
    pub spectrum: Vec<f64>,
    pub rate_by_dimension: Vec<DimensionRate>,
    /// Ids of blank views.
    pub blank: Vec<String>,
}

impl ReportInput<'_> {
    pub fn report(self) -> TrainingReport {
        let model = self.model;
        let universal = &model.universal;
        let ids = |is: fn(&View) -> bool| -> Vec<String> {
            self.views.iter().filter(|view| is(view)).map(|view| view.id.clone()).collect()
        };
        TrainingReport {
            energy_kept: universal.eigenvalues.iter().sum::<f64>() / universal.total_variance,
            dimension: universal.dimension(),
            width_px: model.normaliser.width_px,
            height_px: model.normaliser.height_px,
            vector_length: universal.length(),
            exemplars: self.views.len() + self.blank.len(),
            labels: model.objects.len(),
            confusion: self.confusion(),
            held_out: self.held_out(),
            least_explained: model.least_explained(),
            objects: self.objects(),
            near_duplicates: self.near_duplicates(),
            repeated_poses: self.repeated_poses(),
            over_exposed: ids(|view| view.appearance.over_exposed),
            under_exposed: ids(|view| view.appearance.under_exposed),
            resized: ids(|view| view.appearance.resized),
            touches_border: ids(|view| view.appearance.touches_border),
            several_regions: ids(|view| view.appearance.several_regions),
            blank: self.blank,
            spectrum: self.spectrum,
            rate_by_dimension: self.rate_by_dimension,
        }
    }

    /// The answer to a trial of a known object; `None`: refused.
    fn answer(&self, trial: &Trial) -> Option<usize> {
        let NearObject { object, distance } = trial.nearest()?;
        self.model.is_accepted(NearObject { object, distance }).then_some(object)
    }

    fn held_out(&self) -> Option<HeldOut> {
        let known = || self.trials.iter().filter(|trial| trial.own_distance.is_some());
        let refused = |found: &NearObject| !self.model.is_accepted(*found);
        let others = || self.trials.iter().filter_map(|trial| trial.other);
        (known().count() > 0).then(|| HeldOut {
            known: known().count(),
            known_accepted: known().filter(|trial| self.answer(trial).is_some()).count(),
            known_right: known().filter(|trial| self.answer(trial) == Some(trial.object)).count(),
            unknown: others().count(),
            unknown_refused: others().filter(refused).count(),
        })
    }

    fn confusion(&self) -> Vec<Confusion> {
        let label = |object: usize| self.model.objects[object].label.clone();
        let mut times: BTreeMap<(String, Option<String>), usize> = BTreeMap::new();
        for trial in self.trials.iter().filter(|trial| trial.own_distance.is_some()) {
            let answer = self.answer(trial);
            if answer != Some(trial.object) {
                *times.entry((label(trial.object), answer.map(label))).or_default() += 1;
            }
        }
        times.into_iter().map(|((shown, named), times)| Confusion { shown, named, times }).collect()
    }

    fn objects(&self) -> Vec<ObjectReport> {
        let of = |object: usize| {
            (0..self.views.len()).filter(move |&view| self.model.object_of_view[view] == object)
        };
        let report = |(object, known): (usize, &KnownObject)| {
            let errors: Vec<f64> =
                of(object).filter_map(|view| self.held_out[view].pose_error_deg()).collect();
            ObjectReport {
                label: known.label.clone(),
                views: of(object).count(),
                views_with_pose: of(object).filter(|&view| self.views[view].pose_deg.is_some()).count(),
                threshold: self.model.threshold(object),
                pose: pose_errors(&errors),
                gaps: wide_gaps(&known.views.poses_deg),
            }
        };
        self.model.objects.iter().enumerate().map(report).collect()
    }

    /// Views that lie within [`MAX_DUPLICATE_DISTANCE`] of each other, each pair once.
    fn near_duplicates(&self) -> Vec<(String, String)> {
        let universal = &self.model.universal;
        let (length, dimension) = (universal.length(), universal.dimension());
        let points = self.model.radius_index.points();
        let radius_index = RadiusIndex::new(points.to_vec(), dimension, Search::Slabs);
        let row = |view: usize| &self.rows[view * length..][..length];
        let mut pairs = Vec::new();
        for (view, point) in points.chunks_exact(dimension).enumerate() {
            for near in radius_index
                .within(point, MAX_DUPLICATE_DISTANCE)
                .into_iter()
                .filter(|near| near.index > view)
            {
                if euclidean_distance(row(view), row(near.index)) <= MAX_DUPLICATE_DISTANCE {
                    pairs.push((self.views[view].id.clone(), self.views[near.index].id.clone()));
                }
            }
            if pairs.len() >= MAX_PAIRS {
                pairs.truncate(MAX_PAIRS);
                break;
            }
        }
        pairs
    }

    fn repeated_poses(&self) -> Vec<(String, String)> {
        let same = |pair: &&[View]| {
            let poses = pair[0].pose_deg.zip(pair[1].pose_deg);
            pair[0].label == pair[1].label
                && poses.is_some_and(|(a, b)| angular_distance_deg(a, b) <= ONE_POSE_DEG)
        };
        let pairs = self.views.windows(2).filter(same).take(MAX_PAIRS);
        pairs.map(|pair| (pair[0].id.clone(), pair[1].id.clone())).collect()
    }
}

fn pose_errors(errors: &[f64]) -> Option<PoseErrors> {
    Some(PoseErrors {
        trials: errors.len(),
        mean_deg: errors.iter().sum::<f64>() / errors.len() as f64,
        median_deg: quantile(errors, 0.5)?,
        p95_deg: quantile(errors, 0.95)?,
        within_5_deg: errors.iter().filter(|&&error| error <= SMALL_ERROR_DEG).count(),
    })
}
