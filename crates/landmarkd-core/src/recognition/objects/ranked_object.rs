//! The objects that a picture may show, ranked: of intensities by distance, of gradients by the part of the object that the
//! picture explains once it is aligned.

use super::alignment::{Aligner, Fit, Start};
use super::hypothesis::{Hypothesis, Reach};
use super::model::{NearObject, Objects};
use super::object::{ObjectDistance, Query, ViewSet};
use crate::angle::angular_distance_deg;
use crate::vision::gradient_field::GradientField;

/// Two turns nearer than this are one.
const SEPARATION_DEG: f64 = 15.0;
/// The least part of an object that is told from none.
const LEAST_EXPLAINED: f64 = 1e-6;

/// An object of the shortlist, compared in its own eigenspace.
pub(super) struct RankedObject {
    pub object: usize,
    pub mahalanobis: Option<f64>,
    pub distance: ObjectDistance,
    /// What is held against the threshold, 0 or more: of intensities the distance over the root of the object's scale, of
    /// gradients the part that is not explained over the part that is.
    pub relative: f64,
    pub fit: Option<Fit>,
}

/// (1 − e)/e of the part e that a picture explains.
pub(super) fn unexplained_ratio(explained: f64) -> f64 {
    let explained = explained.max(LEAST_EXPLAINED);
    (1.0 - explained).max(0.0) / explained
}

/// The part e of a ratio (1 − e)/e.
pub(super) fn explained_part(ratio: f64) -> f64 {
    1.0 / (1.0 + ratio)
}

impl RankedObject {
    pub fn near(&self) -> NearObject {
        NearObject { object: self.object, distance: self.relative }
    }
}

impl Objects {
    /// The objects of a shortlist by their distances, B(14).
    pub(super) fn ranked_by_distance(&self, query: &Query, shortlist: &[NearObject]) -> Vec<RankedObject> {
        let ranked = |near: &NearObject| {
            let distance = self.objects[near.object].distance(query);
            RankedObject {
                object: near.object,
                mahalanobis: self.covariances.is_some().then_some(near.distance),
                relative: distance.total() / self.objects[near.object].root_scale(),
                distance,
                fit: None,
            }
        };
        let mut ranking: Vec<RankedObject> = shortlist.iter().map(ranked).collect();
        if !self.covariance_decides() {
            ranking.sort_by(|a, b| a.distance.total().total_cmp(&b.distance.total()));
        }
        ranking
    }

    /// Align the object of each hypothesis, and rank them by what is explained. `views_of` gives an object's views.
    pub(super) fn ranked_by_alignment<'a>(
        &'a self,
        field: &GradientField,
        reach: Reach,
        hypotheses: &[Hypothesis],
        views_of: impl Fn(usize) -> &'a ViewSet,
    ) -> Vec<RankedObject> {
        let mut best_cost = f64::INFINITY;
        let ranked = |hypothesis: &Hypothesis| {
            let aligner = self.aligner(field, reach, hypothesis.object, views_of(hypothesis.object));
            let fits = hypothesis.starts.iter().map(|start| {
                let fit = aligner.fit(start, best_cost);
                best_cost = best_cost.min(fit.cost);
                fit
            });
            let fit = fits.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
            let (point, from_space) = aligner.space.locate(&fit.appearance); // B(13)
            Some(RankedObject {
                object: hypothesis.object,
                mahalanobis: hypothesis.mahalanobis,
                distance: aligner.views.distance(&point, from_space), // B(14)
                relative: unexplained_ratio(fit.explained),
                fit: Some(fit),
            })
        };
        let mut ranking: Vec<RankedObject> = hypotheses.iter().filter_map(ranked).collect();
        if !self.covariance_decides() {
            ranking.sort_by(|a, b| a.relative.total_cmp(&b.relative));
        }
        ranking
    }

    /// The same object at the turn of its next nearest view, if that is another turn: the nearest may be the wrong side of
    /// it.
    pub(super) fn other_side(
        &self,
        field: &GradientField,
        fit: &Fit,
        object: usize,
        views: &ViewSet,
    ) -> Option<Fit> {
        let aligner = self.aligner(field, Reach::Near, object, views);
        let (point, _) = aligner.space.locate(&fit.appearance);
        let curve = views.manifold()?.project(&point);
        let turn_deg = fit.turn_deg?;
        let is_other = |other: f64| angular_distance_deg(other, turn_deg) > SEPARATION_DEG;
        let turns = [Some(curve.nearest.turn_deg), curve.second.map(|second| second.turn_deg)];
        let start = turns.into_iter().flatten().find(|&other| is_other(other))?;
        let other = aligner.fit(&Start { place: fit.place, turn_deg: Some(start) }, f64::INFINITY);
        other.turn_deg.is_some_and(is_other).then_some(other)
    }

    fn aligner<'a>(
        &'a self,
        field: &'a GradientField,
        reach: Reach,
        object: usize,
        views: &'a ViewSet,
    ) -> Aligner<'a> {
        Aligner {
            field,
            reach,
            cells: self.normaliser.samples().into(),
            space: self.objects[object].part.space.as_ref().unwrap_or(&self.universal),
            views,
            typical_distance: self.objects[object].part.typical_distance,
        }
    }
}
