//! What the windows of a frame say, each by itself: the votes of local naive Bayes (McCann and Lowe 2012), and matches.

use super::encoded_exemplars::EncodedExemplars;
use super::encoded_windows::{EncodedWindow, EncodedWindows};
use super::matching::Match;
use super::overlap::Overlap;
use super::phase_space::PHASE_LENGTH;
use super::window_space::unit_px;
use crate::eigen::Neighbour;
use crate::recognition::landmarks::description::{Window, WindowBatch};
use crate::recognition::landmarks::model::Landmarks;
use crate::recognition::landmarks::options::Viewpoint;

/// Of the neighbours of a window the nearest, that say where their exemplar lies.
const MATCHED: usize = 10;
/// Exemplars with the greatest W whose matches are looked at.
const PROMISING: usize = 40;

/// The votes of a frame's windows.
pub(super) struct WindowVotes {
    /// W of every exemplar: how much nearer its windows are than the background, squared distances summed.
    pub weights: Vec<f64>,
    /// How far the exemplars of the greatest W overlap, if they are positions.
    pub overlap: Overlap,
    /// The matches with the exemplars of the greatest W, sorted by exemplar.
    pub matches: Vec<Match>,
}

impl WindowVotes {
    /// Counts votes and gathers matches. `neighbours` has rows of equal length, one a window, nearest first; the last of
    /// each stands for the background.
    pub fn of(
        model: &Landmarks,
        windows: &EncodedWindows,
        batch: &WindowBatch,
        neighbours: &[Neighbour],
    ) -> WindowVotes {
        let per_window = neighbours.len().checked_div(batch.windows.len()).unwrap_or(0).max(1);
        let rows = || {
            neighbours.chunks_exact(per_window).enumerate().filter_map(|(query, row)| {
                row.split_last().map(|(background, near)| (query, background.distance.powi(2), near))
            })
        };
        let exemplar_of = |neighbour: &Neighbour| windows.exemplar(neighbour.index);
        let exemplars = model.exemplars.len();
        // (window, exemplar, vote), each window once an exemplar
        let mut votes: Vec<(usize, usize, f32)> = Vec::with_capacity(neighbours.len());
        let mut counted = vec![usize::MAX; exemplars];
        for (query, beyond, near) in rows() {
            for neighbour in near {
                let exemplar = exemplar_of(neighbour);
                if counted[exemplar] != query {
                    counted[exemplar] = query;
                    votes.push((query, exemplar, beyond - neighbour.distance.powi(2)));
                }
            }
        }
        let mut weights = vec![0.0; exemplars];
        votes.iter().for_each(|&(_, exemplar, vote)| weights[exemplar] += f64::from(vote));
        let promising = promising(&weights);
        let overlap = match model.options.viewpoint {
            Viewpoint::Free => Overlap::none(),
            Viewpoint::Upright => {
                // what a negative exemplar shows speaks for no place
                let is_place = |&e: &usize| promising[e] && !model.exemplars[e].is_negative();
                Overlap::of(&(0..exemplars).filter(is_place).collect::<Vec<usize>>(), votes.into_iter())
            }
        };
        let most_rad = model.options.turn_prior_deg.map_or(f32::INFINITY, |deg| deg.to_radians() as f32);
        let mut matches = Vec::new();
        let encoding = &windows.exemplars.encoding;
        let phases = encoding.phases.project(&batch.spectra);
        for (query, beyond, near) in rows() {
            for (rank, neighbour) in near.iter().enumerate().take(MATCHED) {
                let nearer = beyond - neighbour.distance.powi(2);
                if nearer > 0.0 && promising[exemplar_of(neighbour)] {
                    let window = windows.window(neighbour.index);
                    let phases = &phases[query * PHASE_LENGTH..][..PHASE_LENGTH];
                    let asked = Asked { query, rank, window: &batch.windows[query], phases };
                    let found = matched(model, &windows.exemplars, &asked, &window, [nearer, beyond]);
                    matches.extend(Some(found).filter(|found| found.turn_rad.abs() <= most_rad));
                }
            }
        }
        matches.sort_by_key(|found| found.exemplar); // stable
        WindowVotes { weights, overlap, matches }
    }
}

/// Of every exemplar whether it is among those of the greatest W.
fn promising(weights: &[f64]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a])); // stable
    let mut promising = vec![false; weights.len()];
    order.into_iter().take(PROMISING).for_each(|exemplar| promising[exemplar] = true);
    promising
}

/// A window of the frame with the rank of one of its neighbours.
struct Asked<'a> {
    query: usize,
    rank: usize,
    window: &'a Window,
    phases: &'a [f32],
}

/// The match of a window with a neighbour, which is nearer than the background by so much of squared distance.
fn matched(
    model: &Landmarks,
    exemplars: &EncodedExemplars,
    asked: &Asked<'_>,
    neighbour: &EncodedWindow<'_>,
    [nearer, beyond]: [f32; 2],
) -> Match {
    let describer = &exemplars.describer;
    let size_px = model.working_size_px(neighbour.exemplar as usize);
    let unit_px = unit_px(size_px);
    let from = |axis: usize| f32::from(neighbour.position[axis]) * unit_px - (size_px[axis] - 1.0) / 2.0;
    Match {
        query: asked.query as u32,
        exemplar: neighbour.exemplar,
        rank: asked.rank as u32,
        from: [from(0), from(1)],
        to: [asked.window.point.x_px, asked.window.point.y_px],
        turn_rad: exemplars.encoding.phases.relative_turn(asked.phases, neighbour.phases),
        scale: describer.scale(asked.window.radius) / describer.scale(neighbour.level),
        radius_px: describer.radius_px(asked.window.radius),
        weight: nearer / beyond,
        vote: nearer,
    }
}
