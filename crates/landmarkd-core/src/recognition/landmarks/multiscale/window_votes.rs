//! What the windows of a frame say, each by itself: the votes of local naive Bayes (McCann and Lowe 2012), and matches.

use super::description::ScaleSpaceDescriber;
use super::matching::Match;
use super::overlap::Overlap;
use crate::eigen::Neighbour;
use crate::recognition::landmarks::description::WindowBatch;
use crate::recognition::landmarks::model::Landmarks;
use crate::recognition::landmarks::options::Viewpoint;
use crate::vision::gradient_signature::SPECTRUM_LENGTH;

/// Of the neighbours of a window the nearest, that say where their exemplar lies.
const MATCHED: usize = 10;
/// Exemplars with the greatest W whose matches are looked at.
const PROMISING: usize = 40;

/// The votes of a frame's windows.
pub(super) struct WindowVotes {
    /// W of every exemplar: how much nearer its windows are than the background, squared distances summed.
    pub weights: Vec<f64>,
    /// How far the exemplars of the greatest W overlap, if they are places.
    pub overlap: Overlap,
    /// The matches with the exemplars of the greatest W, sorted by exemplar.
    pub matches: Vec<Match>,
}

impl WindowVotes {
    /// Counts votes and gathers matches. `neighbours` has rows of equal length, one a window, nearest first; the last of
    /// each stands for the background.
    pub fn of(
        model: &Landmarks,
        describer: &ScaleSpaceDescriber,
        batch: &WindowBatch,
        neighbours: &[Neighbour],
    ) -> WindowVotes {
        let per_window = neighbours.len().checked_div(batch.windows.len()).unwrap_or(0).max(1);
        let rows = || {
            neighbours.chunks_exact(per_window).enumerate().filter_map(|(query, row)| {
                row.split_last().map(|(background, near)| (query, background.distance.powi(2), near))
            })
        };
        let exemplar_of = |neighbour: &Neighbour| model.windows[neighbour.index].exemplar as usize;
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
        for (query, beyond, near) in rows() {
            for (rank, neighbour) in near.iter().enumerate().take(MATCHED) {
                let nearer = beyond - neighbour.distance.powi(2);
                if nearer > 0.0 && promising[exemplar_of(neighbour)] {
                    let found = matched(model, describer, batch, [query, rank], neighbour, [nearer, beyond]);
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

/// The match of a window with its neighbour of a rank, which is nearer than the background by so much of squared distance.
fn matched(
    model: &Landmarks,
    describer: &ScaleSpaceDescriber,
    batch: &WindowBatch,
    [query, rank]: [usize; 2],
    neighbour: &Neighbour,
    [nearer, beyond]: [f32; 2],
) -> Match {
    let trained = &model.windows[neighbour.index];
    let (window, taught) = (&batch.windows[query], &trained.window);
    let asked = &batch.spectra[query * SPECTRUM_LENGTH..][..SPECTRUM_LENGTH];
    let kept = &model.spectra[neighbour.index * SPECTRUM_LENGTH..][..SPECTRUM_LENGTH];
    let [width_px, height_px] = model.working_size_px(trained.exemplar as usize);
    Match {
        query: query as u32,
        exemplar: trained.exemplar,
        rank: rank as u32,
        from: [taught.point.x_px - (width_px - 1.0) / 2.0, taught.point.y_px - (height_px - 1.0) / 2.0],
        to: [window.point.x_px, window.point.y_px],
        turn_rad: describer.signature().relative_turn(asked, kept),
        scale: describer.scale(window.radius) / describer.scale(taught.radius),
        radius_px: describer.radius_px(window.radius),
        weight: nearer / beyond,
        vote: nearer,
    }
}
