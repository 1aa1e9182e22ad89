//! Why an object database decides nothing, and what would help.

use super::alignment::Fit;
use super::appearance::Appearance;
use super::hypothesis::Reach;
use super::model::Objects;
use super::ranked_object::RankedObject;
use super::recognition::Alignment;
use crate::angle::angular_distance_deg;
use crate::vision::GradientField;

/// Less than this part of what would be accepted is no likeness.
const LIKE: f64 = 0.5;
/// Shift, as a part of the longer side, and change of scale beyond which a place is the reason.
const OFF_CENTRE_PART: f64 = 0.06;
const OFF_SCALE: f64 = 1.15;
/// Lines that may part what is seen from what is hidden have so many directions.
const DIRECTIONS: usize = 16;
/// Each side has at least this part of the object.
const LEAST_SIDE: f32 = 0.2;
/// Of the side that is seen at least this part is explained, and so many times what is of the other.
const SEEN: f32 = 0.4;
const CONTRAST: f32 = 3.0;
/// Between views so far apart the object may look otherwise.
const SPARSE_DEG: f64 = 18.0;

/// Why a picture is answered with nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The picture is flat, or mostly black or saturated.
    Light {
        /// Much of it is saturated.
        over_exposed: bool,
    },
    /// An object is seen, but away from where its exemplars stand.
    OffCentre {
        /// The object.
        label: String,
        /// Where it stands.
        alignment: Alignment,
    },
    /// An object is seen, but smaller or larger than in its exemplars.
    Scale {
        /// The object.
        label: String,
        /// Where it stands.
        alignment: Alignment,
    },
    /// An object agrees on one side, and not on the other.
    Hidden {
        /// The object.
        label: String,
        /// The part of it that is not explained, 0..=1.
        part: f64,
    },
    /// An object agrees in part, and no exemplar of it is near the pose.
    BetweenViews {
        /// The object.
        label: String,
        /// The pose.
        turn_deg: f64,
        /// To the nearest pose of an exemplar.
        gap_deg: f64,
    },
    /// Nothing known looks like it.
    UnlikeAnything,
}

impl Reason {
    /// A short name for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Reason::Light { .. } => "light",
            Reason::OffCentre { .. } => "off_centre",
            Reason::Scale { .. } => "scale",
            Reason::Hidden { .. } => "hidden",
            Reason::BetweenViews { .. } => "between_views",
            Reason::UnlikeAnything => "unlike_anything",
        }
    }

    /// What was seen, in a sentence.
    pub fn detail(&self) -> String {
        match self {
            Reason::Light { over_exposed: true } => "much of the picture is saturated".to_owned(),
            Reason::Light { over_exposed: false } => "the picture is flat, or nearly black".to_owned(),
            Reason::OffCentre { label, alignment } => {
                let Alignment { shift_x_px, shift_y_px, .. } = alignment;
                let across = if *shift_x_px < 0.0 { "left" } else { "right" };
                let down = if *shift_y_px < 0.0 { "above" } else { "below" };
                let (x, y) = (shift_x_px.abs(), shift_y_px.abs());
                format!(
                    "it looks like {label:?}, {x:.0} px to the {across} of where it stood in its exemplars, {y:.0} px {down}"
                )
            }
            Reason::Scale { label, alignment } => {
                format!("it looks like {label:?}, {:.2} times as large as in its exemplars", alignment.scale)
            }
            Reason::Hidden { label, part } => {
                format!(
                    "it looks like {label:?} on one side; {:.0} % of it is hidden or differs",
                    100.0 * part
                )
            }
            Reason::BetweenViews { label, turn_deg, gap_deg } => format!(
                "it looks somewhat like {label:?} turned by {turn_deg:.0}°, {gap_deg:.0}° from its nearest exemplar"
            ),
            Reason::UnlikeAnything => "nothing known looks like it".to_owned(),
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> String {
        match self {
            Reason::Light { over_exposed: true } => "shorten the exposure".to_owned(),
            Reason::Light { over_exposed: false } => "give more light, or a longer exposure".to_owned(),
            Reason::OffCentre { .. } => {
                "centre it as in the exemplars, or set segment: true, which cuts it out wherever it lies".to_owned()
            }
            Reason::Scale { .. } => {
                "hold the camera as far away as for the exemplars, or set segment: true, which brings it to one size"
                    .to_owned()
            }
            Reason::Hidden { .. } => "take away what hides it, or what stands beside it".to_owned(),
            Reason::BetweenViews { label, turn_deg, .. } => {
                format!("if this is {label:?}, teach a view of it at about {turn_deg:.0}°")
            }
            Reason::UnlikeAnything => "if this should be known, teach this picture".to_owned(),
        }
    }
}

/// By cell: how much of a fit is seen.
#[derive(Clone, Debug)]
pub(super) struct Visibility {
    /// Along both sides.
    pub cells: [usize; 2],
    /// How much the picture agrees with the object, 0..=1.
    pub weights: Vec<f32>,
    /// Energy of the object's appearance.
    pub energies: Vec<f32>,
}

impl Visibility {
    /// Whether a line parts the object into a side that is seen and one that isn't.
    fn is_hidden_on_one_side(&self) -> bool {
        let [columns, _] = self.cells;
        let all: f32 = self.energies.iter().sum();
        let seen: f32 = self.weights.iter().zip(&self.energies).map(|(w, e)| w * e).sum();
        (0..DIRECTIONS).any(|direction| {
            let (sin, cos) = (std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64).sin_cos();
            let along = |cell: usize| cos * (cell % columns) as f64 + sin * (cell / columns) as f64;
            let mut order: Vec<usize> = (0..self.energies.len()).collect();
            order.sort_by(|&a, &b| along(a).total_cmp(&along(b)));
            let (mut before, mut seen_before) = (0.0, 0.0);
            order.into_iter().any(|cell| {
                before += self.energies[cell];
                seen_before += self.weights[cell] * self.energies[cell];
                let (behind, seen_behind) = (all - before, seen - seen_before);
                before.min(behind) >= LEAST_SIDE * all
                    && seen_before >= SEEN * before
                    && seen_before / before >= CONTRAST * seen_behind / behind
            })
        })
    }
}

impl Objects {
    /// The reasons, the likeliest first.
    pub(super) fn reasons(
        &self,
        appearance: &Appearance,
        field: Option<&GradientField>,
        ranked: &[RankedObject],
    ) -> Vec<Reason> {
        let mut reasons = Vec::new();
        if appearance.over_exposed || appearance.under_exposed {
            reasons.push(Reason::Light { over_exposed: appearance.over_exposed });
        }
        let of_object = field.and_then(|field| self.reason_of_object(field, ranked.first()?));
        reasons.push(of_object.unwrap_or(Reason::UnlikeAnything));
        reasons
    }

    /// What keeps the picture from showing an object; `None` if it is like none.
    fn reason_of_object(&self, field: &GradientField, nearest: &RankedObject) -> Option<Reason> {
        let least = self.least_explained()?;
        let hypotheses = self.hypotheses(field, Reach::Far, |_| false);
        let views_of = |object: usize| &self.objects[object].views;
        let far = self.ranked_by_alignment(field, Reach::Far, &hypotheses, views_of);
        let label = |object: usize| self.objects[object].label.clone();
        if let Some((object, fit)) = far.first().and_then(|far| Some((far.object, far.fit.as_ref()?)))
            && fit.explained >= least
            && let Some(reason) = self.reason_of_place(label(object), fit)
        {
            return Some(reason);
        }
        let fit = nearest.fit.as_ref().filter(|fit| fit.explained >= LIKE * least)?;
        if fit.visibility.is_hidden_on_one_side() {
            return Some(Reason::Hidden { label: label(nearest.object), part: 1.0 - fit.explained });
        }
        let turn_deg = fit.turn_deg?;
        let poses_deg = &self.objects[nearest.object].views.poses_deg;
        let gap_deg =
            poses_deg.iter().map(|&pose| angular_distance_deg(pose, turn_deg)).fold(360.0, f64::min);
        let is_sparse = poses_deg.len() as f64 * SPARSE_DEG < 360.0 || gap_deg > SPARSE_DEG / 2.0;
        is_sparse.then(|| Reason::BetweenViews { label: label(nearest.object), turn_deg, gap_deg })
    }

    fn reason_of_place(&self, label: String, fit: &Fit) -> Option<Reason> {
        let alignment = self.normaliser.alignment(&fit.place);
        let longer_px = self.normaliser.width_px.max(self.normaliser.height_px) as f64;
        let shift = alignment.shift_x_px.hypot(alignment.shift_y_px) / longer_px;
        let scale = alignment.scale.max(1.0 / alignment.scale);
        if scale > OFF_SCALE {
            return Some(Reason::Scale { label, alignment });
        }
        (shift > OFF_CENTRE_PART).then_some(Reason::OffCentre { label, alignment })
    }
}
