//! Which points of an exemplar and of a frame show the same: what the relative pose of their cameras is computed from.
//!
//! A placement's witnesses agree on one plane. In a room with depth the others tell where the camera stands: matches are
//! judged here by those in their neighbourhood alone, which lie where the match's own turn and scale predict them.

use super::asked_frame::AskedFrame;
use super::consensus::turn_between;
use super::phase_space::PHASE_LENGTH;
use super::window_space::unit_px;
use crate::geometry::PointPair;
use crate::recognition::landmarks::model::{Landmarks, Windows};
use crate::recognition::landmarks::search::nearest_but;

/// Neighbours are looked for within this distance in the frame at its working size, and beyond that distance, where they see
/// the same.
const REACH_PX: f32 = 100.0;
const SAME_PX: f32 = 4.0;
/// Widths of the kernel: of the place as a part of the distance, and at least so much; of the turn; of the scale's logarithm.
const PLACE_WIDTH: f32 = 0.2;
const LEAST_PLACE_WIDTH_PX: f32 = 4.0;
const TURN_WIDTH_RAD: f32 = 0.35;
const SCALE_WIDTH: f32 = 0.35;
/// The kernel is 0 where turn or scale differ by more than so many widths.
const WIDTHS: f32 = 2.5;
/// Of an exemplar's windows that are near to one of the frame the nearest so many are candidates.
const MOST_RANKS: usize = 4;
/// Pairs of an exemplar at most.
const MOST_PAIRS: usize = 300;

/// A window of the frame and one of the exemplar that is near to it.
struct Candidate {
    query: usize,
    trained: usize,
    from: [f32; 2],
    to: [f32; 2],
    scale: [f32; 2],
    turn_rad: f32,
    weight: f32,
}

impl Landmarks {
    /// The points that exemplars and a frame have in common, of each exemplar the likeliest first; in pixels of the pictures
    /// as posted. None with signatures of intensities, or where the windows are elsewhere.
    pub fn correspondences(&self, asked: &AskedFrame<'_>, exemplars: &[usize]) -> Vec<Vec<PointPair>> {
        let Windows::Encoded(windows) = &self.windows else { return vec![Vec::new(); exemplars.len()] };
        let AskedFrame { working, batch, .. } = asked;
        let neighbours = nearest_but(self, batch, None);
        let per_window = neighbours.len().checked_div(batch.windows.len()).unwrap_or(0).max(1);
        let (encoding, describer) = (&windows.exemplars.encoding, &windows.exemplars.describer);
        let phases = encoding.phases.project(&batch.spectra);
        let mut candidates: Vec<Vec<Candidate>> = exemplars.iter().map(|_| Vec::new()).collect();
        let units: Vec<f32> = exemplars.iter().map(|&e| unit_px(self.working_size_px(e))).collect();
        for (query, row) in neighbours.chunks_exact(per_window).enumerate() {
            let Some((background, near)) = row.split_last() else { continue };
            let mut counts = vec![0; exemplars.len()];
            for neighbour in near {
                let exemplar = windows.exemplar(neighbour.index);
                let Some(number) = exemplars.iter().position(|e| *e == exemplar) else { continue };
                counts[number] += 1;
                if counts[number] > MOST_RANKS {
                    continue;
                }
                let weight = 1.0 - (neighbour.distance / background.distance).powi(2);
                if !(weight > 0.0) {
                    continue;
                }
                let (window, trained) = (&batch.windows[query], windows.window(neighbour.index));
                candidates[number].push(Candidate {
                    query,
                    trained: neighbour.index,
                    from: trained.position.map(|at| f32::from(at) * units[number]),
                    to: [window.point.x_px, window.point.y_px],
                    scale: [trained.level, window.radius].map(|level| describer.scale(level)),
                    turn_rad: encoding
                        .phases
                        .relative_turn(&phases[query * PHASE_LENGTH..][..PHASE_LENGTH], trained.phases),
                    weight,
                });
            }
        }
        let posted = |at: [f32; 2], reduction: f32| at.map(|at| f64::from((at + 0.5) * reduction - 0.5));
        let pairs = |(candidates, &exemplar): (Vec<Candidate>, &usize)| {
            let taught = &self.exemplars[exemplar];
            let reductions =
                [self.options.reduction_of(taught.width_px, taught.height_px), working.reduction];
            let pair = |(candidate, support): (Candidate, f32)| PointPair {
                from_px: posted(candidate.from, reductions[0]),
                to_px: posted(candidate.to, reductions[1]),
                scale_px: [0, 1].map(|side| f64::from(candidate.scale[side] * reductions[side])),
                turn_rad: f64::from(candidate.turn_rad),
                weight: f64::from(support),
            };
            likeliest(candidates).into_iter().map(pair).collect()
        };
        candidates.into_iter().zip(exemplars).map(pairs).collect()
    }
}

/// The candidates that others support, most first, each window of frame and exemplar once.
fn likeliest(candidates: Vec<Candidate>) -> Vec<(Candidate, f32)> {
    let supports: Vec<f32> = candidates.iter().map(|candidate| support(candidate, &candidates)).collect();
    let mut ranked: Vec<(Candidate, f32)> = candidates.into_iter().zip(supports).collect();
    ranked.retain(|(_, support)| *support > 0.0);
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1)); // stable
    let mut kept: Vec<(Candidate, f32)> = Vec::new();
    for (candidate, support) in ranked {
        let is_new = |(other, _): &(Candidate, f32)| {
            other.query != candidate.query && other.trained != candidate.trained
        };
        if kept.len() < MOST_PAIRS && kept.iter().all(is_new) {
            kept.push((candidate, support));
        }
    }
    kept
}

/// How much the candidates in its neighbourhood speak for a candidate, each window of the frame once. The candidates are sorted
/// by window.
fn support(about: &Candidate, candidates: &[Candidate]) -> f32 {
    let log_scale = |c: &Candidate| (c.scale[1] / c.scale[0]).ln();
    let scale = about.scale[1] / about.scale[0];
    let (sin, cos) = about.turn_rad.sin_cos();
    let mut sum = 0.0;
    // of the window that is looked at
    let (mut query, mut most) = (usize::MAX, 0.0_f32);
    for other in candidates {
        let there = [other.to[0] - about.to[0], other.to[1] - about.to[1]];
        let square = there[0] * there[0] + there[1] * there[1];
        if !(square < REACH_PX * REACH_PX && square > SAME_PX * SAME_PX) {
            continue;
        }
        let turned = turn_between(other.turn_rad, about.turn_rad) / TURN_WIDTH_RAD;
        let scaled = (log_scale(other) - scale.ln()) / SCALE_WIDTH;
        if turned > WIDTHS || scaled.abs() > WIDTHS {
            continue;
        }
        let [x, y] = [other.from[0] - about.from[0], other.from[1] - about.from[1]];
        let (u, v) = (scale * (cos * x - sin * y), scale * (sin * x + cos * y));
        let off = (u - there[0]).hypot(v - there[1]) / (PLACE_WIDTH * square.sqrt() + LEAST_PLACE_WIDTH_PX);
        let kernel = (-0.5 * (off * off + turned * turned + scaled * scaled)).exp() * other.weight;
        if other.query != query {
            sum += most;
            (query, most) = (other.query, 0.0);
        }
        most = most.max(kernel);
    }
    about.weight * (sum + most)
}
