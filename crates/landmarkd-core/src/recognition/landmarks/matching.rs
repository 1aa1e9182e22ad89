//! Windows of a frame beside the trained ones that look like them: where each pair would have the exemplar lie.

use super::consensus::Match;
use super::description::Seen;
use super::model::Landmarks;
use super::placement::Placement;
use crate::eigen::Neighbour;
use crate::vision::{KeptSpectrum, spectrum_length};

/// Correlations at or below this say nothing of turns.
const LEAST_CORRELATION: f32 = 0.5;

impl Landmarks {
    /// Add a match for each window and trained window near it, if they are turned alike ring by ring; none if the
    /// options ask for no placement. `first` is the index of the first window among all of the frame.
    pub(super) fn add_matches(
        &self,
        seen: &Seen,
        first: usize,
        neighbours: &[Neighbour],
        matches: &mut Vec<Match>,
    ) {
        let Some(plan) = self.describer.turns() else { return };
        if seen.windows.is_empty() {
            return;
        }
        let (row, count) = (plan.length(), neighbours.len() / seen.windows.len());
        let radii = &self.options.subwindow_radii_px;
        let queries = seen.windows.iter().zip(seen.spectra.chunks_exact(row));
        for (query, ((window, spectrum), near)) in
            queries.zip(neighbours.chunks_exact(count.max(1))).enumerate()
        {
            let length = spectrum_length(spectrum);
            for neighbour in near {
                let kept = KeptSpectrum {
                    numbers: &self.spectra[neighbour.index * row..][..row],
                    length: self.spectrum_lengths[neighbour.index],
                };
                let turn = plan.relative_turn(spectrum, length, kept);
                if turn.correlation <= LEAST_CORRELATION {
                    continue;
                }
                let owned = &self.owned[neighbour.index];
                let exemplar = &self.exemplars[owned.exemplar as usize];
                let scale = (radii[window.radius as usize] / radii[owned.window.radius as usize]) as f32;
                let from = [
                    owned.window.point.x_px - (exemplar.width_px as f32 - 1.0) / 2.0,
                    owned.window.point.y_px - (exemplar.height_px as f32 - 1.0) / 2.0,
                ];
                let to = [window.point.x_px, window.point.y_px];
                let about = Placement { x_px: 0.0, y_px: 0.0, rotation_rad: turn.turn_rad, scale };
                let [x_px, y_px] = about.apply(from);
                matches.push(Match {
                    query: (first + query) as u32,
                    distance: neighbour.distance,
                    exemplar: owned.exemplar,
                    placement: Placement { x_px: to[0] - x_px, y_px: to[1] - y_px, ..about },
                    from,
                    to,
                    weight: (turn.correlation - LEAST_CORRELATION).powi(2),
                });
            }
        }
    }
}
