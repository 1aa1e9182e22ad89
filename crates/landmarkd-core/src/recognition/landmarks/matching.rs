//! Matches: windows of a frame and trained windows that resemble them. Each predicts where the exemplar lies.

use super::description::{Window, WindowBatch};
use super::model::{Exemplar, Landmarks, TrainedWindow, Windows};
use super::placement::Placement;
use crate::eigen::Neighbour;
use crate::vision::{KeptSpectrum, RelativeTurn, spectrum_length};

/// Correlations of spectra at or below this say nothing of the relative turn.
const LEAST_CORRELATION: f32 = 0.5;

/// A window of the frame and a trained window that resembles it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    /// Index of the frame's window.
    pub query: u32,
    /// D.
    pub distance: f32,
    /// Index of the trained window's exemplar.
    pub exemplar: u32,
    /// The placement of the exemplar that this match alone predicts.
    pub placement: Placement,
    /// Offset of the trained window from the exemplar's centre, exemplar pixels.
    pub from: [f32; 2],
    /// Position of the frame's window, frame pixels.
    pub to: [f32; 2],
    /// How much the match counts, > 0.
    pub weight: f32,
}

/// The matches of each window with its nearest eigenpoints (rows of equal length), where the spectra agree on a
/// relative turn; none if the options ask for no placement. `first` is the index of the first window in the frame.
pub(super) fn matches(
    model: &Landmarks,
    batch: &WindowBatch,
    first: usize,
    neighbours: &[Neighbour],
) -> Vec<Match> {
    let (Some(plan), Windows::Plain(plain)) = (model.describer.phase_plan(), &model.windows) else {
        return Vec::new();
    };
    let per_window = neighbours.len().checked_div(batch.windows.len()).unwrap_or(0).max(1);
    let described = batch.windows.iter().zip(batch.spectra.chunks_exact(plan.length()));
    let mut matches = Vec::new();
    for (query, ((window, spectrum), near)) in described.zip(neighbours.chunks_exact(per_window)).enumerate()
    {
        let length = spectrum_length(spectrum);
        for neighbour in near {
            let kept = KeptSpectrum {
                numbers: &plain.spectra[neighbour.index * plan.length()..][..plan.length()],
                length: plain.spectrum_lengths[neighbour.index],
            };
            let turn = plan.relative_turn(spectrum, length, kept);
            if turn.correlation <= LEAST_CORRELATION {
                continue;
            }
            let trained = &plain.windows[neighbour.index];
            matches.push(Match::new(
                model,
                (first + query) as u32,
                window,
                trained,
                neighbour.distance,
                &turn,
            ));
        }
    }
    matches
}

impl Match {
    fn new(
        model: &Landmarks,
        query: u32,
        window: &Window,
        &TrainedWindow { window: trained, exemplar }: &TrainedWindow,
        distance: f32,
        turn: &RelativeTurn,
    ) -> Match {
        let radii_px = &model.options.subwindow_radii_px;
        let scale = (radii_px[window.radius as usize] / radii_px[trained.radius as usize]) as f32;
        let Exemplar { width_px, height_px, .. } = model.exemplars[exemplar as usize];
        let from = [
            trained.point.x_px - (width_px as f32 - 1.0) / 2.0,
            trained.point.y_px - (height_px as f32 - 1.0) / 2.0,
        ];
        let to = [window.point.x_px, window.point.y_px];
        let about_origin = Placement { x_px: 0.0, y_px: 0.0, rotation_rad: turn.turn_rad, scale };
        let [x_px, y_px] = about_origin.apply(from);
        Match {
            query,
            distance,
            exemplar,
            placement: Placement { x_px: to[0] - x_px, y_px: to[1] - y_px, ..about_origin },
            from,
            to,
            weight: (turn.correlation - LEAST_CORRELATION).powi(2),
        }
    }
}
