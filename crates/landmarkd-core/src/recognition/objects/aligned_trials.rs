//! Leave-one-out trials of aligned views: each is left out of its object, disturbed, and shown to the database.

use super::held_out::{LabelledPoints, Trial};
use super::hypothesis::Reach;
use super::model::Objects;
use super::object::ViewSet;
use super::ranked_object::{RankedObject, explained_part, unexplained_ratio};
use crate::angle::angular_distance_deg;
use crate::vision::GradientField;

/// Show disturbed views to the database: those that there are. A trial's distances are the ratios of what is not
/// explained. `gap_ratio` is the part of an interpolation error that is left when the gap halves.
pub(super) fn aligned_trials(
    model: &Objects,
    disturbed: &[Option<GradientField>],
    points: &LabelledPoints,
    gap_ratio: f64,
) -> Vec<Trial> {
    let shown = disturbed.iter().enumerate().filter_map(|(view, field)| Some((view, field.as_ref()?)));
    shown.map(|(view, field)| trial(model, view, field, points, gap_ratio)).collect()
}

fn trial(
    model: &Objects,
    view: usize,
    field: &GradientField,
    points: &LabelledPoints,
    gap_ratio: f64,
) -> Trial {
    let object = points.object_of_view[view];
    let others = views_without(model, view, points);
    let hypotheses = model.hypotheses(field, Reach::Near, |other| points.is_left_out_with(other, view));
    let first = hypotheses.first().map(|first| first.object == object);
    let (own_hypothesis, strange): (Vec<_>, Vec<_>) =
        hypotheses.into_iter().partition(|hypothesis| hypothesis.object == object);
    let all_views = |of: usize| &model.objects[of].views;
    let ranked = |hypotheses: &[_]| model.ranked_by_alignment(field, Reach::Near, hypotheses, all_views);
    let views_left = |of: usize| others.as_ref().unwrap_or(&model.objects[of].views);
    let own = model.ranked_by_alignment(field, Reach::Near, &own_hypothesis, views_left).into_iter().next();
    let learnt = ranked(&own_hypothesis).into_iter().next();
    // As if the object were unknown: its own fit would end the others' early.
    let other = ranked(&strange).first().map(RankedObject::near);
    // Where the view itself was learnt nothing is interpolated, and the disturbance alone takes away.
    let expected = own.as_ref().zip(learnt.as_ref()).map(|(own, learnt)| {
        let [held_out, learnt] = [own.relative, learnt.relative].map(explained_part);
        unexplained_ratio(held_out.max(learnt - gap_ratio * (learnt - held_out)))
    });
    Trial {
        object,
        own_distance: others.as_ref().map(|_| expected.unwrap_or(unexplained_ratio(0.0))),
        is_likely: own.is_some(),
        other,
        own_is_first: if model.covariance_decides() { first } else { None },
        pose_ratio: own.as_ref().zip(learnt.as_ref()).and_then(|(own, learnt)| {
            let pose_deg = points.poses_deg[view]?;
            let gap_deg = others.as_ref()?.gap_deg(pose_deg)?;
            pose_ratio(own, learnt, pose_deg, gap_deg, gap_ratio)
        }),
    }
}

/// The error of the pose over the deviation that the fit gives, both as a query has them: an error falls with the square of
/// what a distance does when the gap halves. `None` where the pose was found outside its gap: that is another side of the
/// object, of which the deviation says nothing.
fn pose_ratio(
    held_out: &RankedObject,
    learnt: &RankedObject,
    pose_deg: f64,
    gap_deg: f64,
    gap_ratio: f64,
) -> Option<f64> {
    let error_and_sigma_deg = |ranked: &RankedObject| {
        let fit = ranked.fit.as_ref()?;
        let error_deg = angular_distance_deg(fit.turn_deg?, pose_deg);
        fit.turn_sigma_deg.is_finite().then_some([error_deg, fit.turn_sigma_deg])
    };
    let (held_out, learnt) = (error_and_sigma_deg(held_out)?, error_and_sigma_deg(learnt)?);
    if held_out[0].max(learnt[0]) > gap_deg / 2.0 {
        return None;
    }
    let expected = |k: usize, ratio: f64| learnt[k] + ratio * (held_out[k] - learnt[k]).max(0.0);
    let sigma_deg = expected(1, gap_ratio);
    (sigma_deg > 0.0).then(|| expected(0, gap_ratio * gap_ratio) / sigma_deg)
}

/// The other views of a view's object; `None` if there are none.
fn views_without(model: &Objects, view: usize, points: &LabelledPoints) -> Option<ViewSet> {
    let object = points.object_of_view[view];
    let part = &model.objects[object].part;
    let members: Vec<usize> =
        (0..points.object_of_view.len()).filter(|&other| points.object_of_view[other] == object).collect();
    let dimension = part.space.as_ref().map_or(points.dimension, |space| space.dimension());
    let (mut kept, mut poses_deg) = (Vec::new(), Vec::new());
    for (index, &other) in members.iter().enumerate() {
        if !points.is_left_out_with(other, view) {
            kept.extend_from_slice(match &part.space {
                Some(_) => &part.eigenpoints[index * dimension..][..dimension],
                None => points.point(other),
            });
            poses_deg.push(points.poses_deg[other]);
        }
    }
    (!poses_deg.is_empty()).then(|| ViewSet::new(&kept, &poses_deg, dimension))
}
