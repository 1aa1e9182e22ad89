//! The query windows of a frame. They are described and searched in batches of points, each as large as all before it
//! together, until one more changes neither what is seen nor by how much (A§6 leaves open how many points it takes).
//! The paper's method takes all points at once.

use super::description::{Attention, SmoothedPlanes, Window};
use super::matching::{Match, matches};
use super::model::Landmarks;
use super::options::Method;
use super::recognition::Stage;
use super::search::{EigenpointSubset, nearest};
use crate::eigen::Neighbour;
use crate::imaging::Frame;

/// Points of the first batch: at least so many, and so many for each square of [`BATCH_SIDE_PX`].
const LEAST_BATCH: usize = 128;
const BATCH_SIDE_PX: usize = 32;
const BATCH_POINTS: usize = 2;
/// The margin is stable if it changes by no more than this.
const STABLE_MARGIN: f64 = 0.25;

/// The windows of a frame so far.
pub(super) struct Query<'a> {
    pub model: &'a Landmarks,
    subset: Option<&'a EigenpointSubset>,
    planes: SmoothedPlanes<'a>,
    pub windows: Vec<Window>,
    /// The nearest eigenpoints, nearest first: rows of equal length, one a window.
    neighbours: Vec<Neighbour>,
    /// Sorted by exemplar; empty if the method verifies no placements.
    pub matches: Vec<Match>,
    /// Points of the next batch.
    batch_points: usize,
    /// Whether the frame has no more points.
    exhausted: bool,
    /// Of the batch before.
    previous: Option<StoppingState>,
}

impl<'a> Query<'a> {
    /// The query of a frame before its first batch.
    pub fn new(
        model: &'a Landmarks,
        subset: Option<&'a EigenpointSubset>,
        frame: &Frame,
        attention: &'a Attention,
    ) -> Query<'a> {
        let query_points = model.options.query_points;
        let squares = (frame.width() / BATCH_SIDE_PX) * (frame.height() / BATCH_SIDE_PX);
        let batch_points = match model.options.method {
            Method::Paper => query_points,
            Method::Placement => LEAST_BATCH.max(BATCH_POINTS * squares).min(query_points),
        };
        Query {
            model,
            subset,
            planes: model.describer.smooth(frame, attention),
            windows: Vec::new(),
            neighbours: Vec::new(),
            matches: Vec::new(),
            batch_points,
            exhausted: false,
            previous: None,
        }
    }

    /// Describes and searches one batch more.
    pub fn add_batch(&mut self, finished: &mut impl FnMut(Stage)) {
        let batch = self.model.describer.next_batch(&mut self.planes, self.batch_points); // A§4.3, A§4.4
        finished(Stage::Signature);
        let neighbours = nearest(self.model, &batch, self.subset); // A§4.1, A§4.5
        finished(Stage::Search);
        self.exhausted = batch.windows.len() < self.batch_points * self.radii();
        self.matches.extend(matches(self.model, &batch, self.windows.len(), &neighbours));
        self.matches.sort_by_key(|found| found.exemplar); // stable
        self.windows.extend(batch.windows);
        self.neighbours.extend(neighbours);
        let points = self.points();
        self.batch_points = points.min(self.model.options.query_points.saturating_sub(points));
    }

    /// Whether no batch is left, or the last one left the state as it was before.
    pub fn is_settled(&mut self, state: StoppingState) -> bool {
        let stable = self.previous.as_ref().is_some_and(|previous| state.is_stable_since(previous));
        self.previous = Some(state);
        self.exhausted || self.batch_points == 0 || stable
    }

    /// Points so far.
    pub fn points(&self) -> usize {
        self.windows.len() / self.radii()
    }

    /// Each window with its nearest eigenpoints; none if no eigenpoint was searched.
    pub fn rows(&self) -> impl Iterator<Item = (&Window, &[Neighbour])> {
        let per_window = self.neighbours.len().checked_div(self.windows.len()).unwrap_or(0).max(1);
        self.windows.iter().zip(self.neighbours.chunks_exact(per_window))
    }

    fn radii(&self) -> usize {
        self.model.options.subwindow_radii_px.len()
    }
}

/// What must stay the same for more points to be needless.
pub(super) struct StoppingState {
    /// The best label.
    best: Option<String>,
    instances: usize,
    /// The best label's part of W less that of the second.
    margin: f64,
}

impl StoppingState {
    /// The state of labels with their W, best first, and of the number of instances.
    pub fn new<'l>(labels: impl Iterator<Item = (&'l str, f64)>, instances: usize) -> StoppingState {
        let labels: Vec<(&str, f64)> = labels.collect();
        let all: f64 = labels.iter().map(|(_, weight)| weight).sum();
        let margin = match &labels[..] {
            [] => 0.0,
            [(_, only)] => only / all,
            [(_, first), (_, second), ..] => (first - second) / all,
        };
        StoppingState { best: labels.first().map(|(label, _)| (*label).to_owned()), instances, margin }
    }

    fn is_stable_since(&self, before: &StoppingState) -> bool {
        self.best == before.best
            && self.instances == before.instances
            && (self.margin - before.margin).abs() <= STABLE_MARGIN
    }
}
