//! Hypotheses: which object may stand where, before any is aligned. The appearance is read at a few places, projected into
//! the universal eigenspace (B(13)), and its nearest eigenpoints (B(14)) say object, pose and place.

use super::alignment::Start;
use super::model::{CANDIDATES, Objects};
use crate::angle::angular_distance_deg;
use crate::vision::gradient_field::{GradientField, Similarity};

/// Shift, change of scale and turn of the places that are looked at: a step of Gauss–Newton reaches from one to the next.
const SHIFT_PX: f64 = 5.0;
const SCALE: f64 = 1.1;
const TURN_RAD: f64 = 0.09;
/// Step of the shift, and scales, where the whole picture is searched.
const FAR_SHIFT_PX: f64 = 12.0;
const FAR_SCALES: [f64; 5] = [0.6, 0.78, 1.0, 1.28, 1.65];
/// Of an object that may be seen from several sides, the likeliest two are aligned if they are so far apart.
const OTHER_SIDE_DEG: f64 = 20.0;
const SIDES: usize = 2;

/// The likeliest starts of one object's alignment.
pub(super) struct Hypothesis {
    pub object: usize,
    /// B(15), if objects are ordered by it.
    pub mahalanobis: Option<f64>,
    /// The likeliest first.
    pub starts: Vec<Start>,
}

/// A view near to the picture as read at a place.
struct Hit {
    view: usize,
    place: usize,
    /// Between the appearances.
    distance: f64,
}

/// Where an object is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// About where it stood when it was learnt.
    Near,
    /// In the whole picture: to say why it wasn't recognised.
    Far,
}

impl Reach {
    /// The places at which the appearance is read; the identity is the first.
    fn places(self) -> Vec<Similarity> {
        let mut places = vec![Similarity::IDENTITY];
        match self {
            Reach::Near => {
                places.extend(shifted([-1.0, 0.0, 1.0], SHIFT_PX, 1.0));
                places.extend([1.0 / SCALE, SCALE].map(|scale| Similarity { scale, ..Similarity::IDENTITY }));
                let turned = |turn_rad| Similarity { turn_rad, ..Similarity::IDENTITY };
                places.extend([-TURN_RAD, TURN_RAD].map(turned));
            }
            Reach::Far => {
                let steps = [-2.0, -1.0, 0.0, 1.0, 2.0];
                places.extend(FAR_SCALES.iter().flat_map(|&scale| shifted(steps, FAR_SHIFT_PX, scale)));
            }
        }
        places
    }
}

/// Places at some steps to each side.
fn shifted<const N: usize>(steps: [f64; N], step_px: f64, scale: f64) -> impl Iterator<Item = Similarity> {
    let along = steps.into_iter().flat_map(move |x| steps.map(|y| (step_px * x, step_px * y)));
    along.map(move |(x_px, y_px)| Similarity { x_px, y_px, scale, turn_rad: 0.0 })
}

impl Objects {
    /// The likeliest objects, [`CANDIDATES`] at most, the likeliest first. Views that are left out are not looked at.
    pub(super) fn hypotheses(
        &self,
        field: &GradientField,
        reach: Reach,
        is_left_out: impl Fn(usize) -> bool,
    ) -> Vec<Hypothesis> {
        let places = reach.places();
        let mut appearances = Vec::with_capacity(places.len() * self.universal.length());
        places.iter().for_each(|place| appearances.extend(self.appearance_at(field, place)));
        let points = self.universal.project(&appearances); // B(13)
        let mut hits = self.hits(&appearances, &points, is_left_out); // B(14)
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.view.cmp(&b.view)));
        let mut found: Vec<Hypothesis> = Vec::new();
        for hit in &hits {
            let object = self.object_of_view[hit.view];
            let start = Start { place: places[hit.place], turn_deg: self.views[hit.view].pose_deg };
            match found.iter().position(|hypothesis| hypothesis.object == object) {
                Some(at) => found[at].add(start),
                None => {
                    let point = &points[hit.place * self.dimension()..][..self.dimension()];
                    let mahalanobis = self.covariances.as_ref().map(|all| all[object].distance(point)); // B(15)
                    found.push(Hypothesis { object, mahalanobis, starts: vec![start] });
                }
            }
        }
        // Without covariances the order stays.
        found.sort_by(|a, b| a.mahalanobis.unwrap_or(0.0).total_cmp(&b.mahalanobis.unwrap_or(0.0)));
        found.truncate(CANDIDATES);
        found
    }

    /// Views among which the nearest of each of the likeliest objects are, of a picture read at several places. With
    /// covariances any view may be.
    fn hits(&self, appearances: &[f32], points: &[f32], is_left_out: impl Fn(usize) -> bool) -> Vec<Hit> {
        let mut hits: Vec<Hit> = Vec::new();
        // By object: the distance of its nearest view so far.
        let mut nearest = vec![f64::INFINITY; self.objects.len()];
        let rows =
            appearances.chunks_exact(self.universal.length()).zip(points.chunks_exact(self.dimension()));
        for (place, (appearance, point)) in rows.enumerate() {
            let centred = appearance.iter().zip(&self.universal.mean).map(|(v, m)| f64::from(v - m).powi(2));
            let inside: f64 = point.iter().map(|&v| f64::from(v).powi(2)).sum();
            let outside = (centred.sum::<f64>() - inside).max(0.0);
            let mut likeliest = nearest.clone();
            likeliest.sort_by(f64::total_cmp);
            let farthest = likeliest[CANDIDATES.min(likeliest.len()) - 1];
            let radius = match self.covariances {
                Some(_) => f64::INFINITY,
                None => (farthest * farthest - outside).max(0.0).sqrt(),
            };
            for near in self.radius_index.within(point, radius) {
                if is_left_out(near.index) {
                    continue;
                }
                let distance = f64::from(near.distance).hypot(outside.sqrt());
                let best = &mut nearest[self.object_of_view[near.index]];
                *best = best.min(distance);
                hits.push(Hit { view: near.index, place, distance });
            }
        }
        hits
    }

    /// The appearance at a place; what a gray picture doesn't say about colours is as the mean.
    fn appearance_at(&self, field: &GradientField, place: &Similarity) -> Vec<f32> {
        field.appearance(place, &self.universal.mean[self.normaliser.colourless_length()..])
    }
}

impl Hypothesis {
    /// Adds the start of another side of the object.
    fn add(&mut self, start: Start) {
        let is_far = |other: &Start| match (start.turn_deg, other.turn_deg) {
            (Some(a), Some(b)) => angular_distance_deg(a, b) > OTHER_SIDE_DEG,
            _ => false,
        };
        if self.starts.len() < SIDES && self.starts.iter().all(is_far) {
            self.starts.push(start);
        }
    }
}
