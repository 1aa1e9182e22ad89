//! Matches for tests: accidents, and those of a thing that is there.

use std::f64::consts::PI;

use super::matching::Match;
use crate::imaging::Random;
use crate::recognition::landmarks::homography::Homography;

/// Matches that have nothing to do with each other, in a frame of 640 by 480 px, one a window; exemplars of 200 by 150 px.
pub(super) fn accidents(exemplars: usize, count: usize, seed: u64) -> Vec<Match> {
    let mut random = Random::new(seed, 91);
    let mut between = |least: f64, most: f64| random.between(least, most) as f32;
    (0..count)
        .map(|i| Match {
            query: i as u32,
            exemplar: (i % exemplars) as u32,
            rank: 0,
            from: [between(-100.0, 100.0), between(-75.0, 75.0)],
            to: [between(0.0, 640.0), between(0.0, 480.0)],
            turn_rad: between(-PI, PI),
            scale: between(-1.0, 1.0).exp(),
            radius_px: 14.0,
            weight: between(0.01, 0.4),
            vote: 0.1,
        })
        .collect()
}

/// Matches of an exemplar of 200 by 150 px that a map places, a little off; their windows are numbered from `first_query`.
pub(super) fn planted(
    exemplar: u32,
    map: &Homography,
    count: usize,
    first_query: u32,
    seed: u64,
) -> Vec<Match> {
    let mut random = Random::new(seed, 92);
    let mut between = |least: f64, most: f64| random.between(least, most);
    (0..count)
        .map(|i| {
            let from = [between(-90.0, 90.0), between(-65.0, 65.0)];
            let (to, local) = (map.apply(from), map.local_similarity(from));
            Match {
                query: first_query + i as u32,
                exemplar,
                rank: 0,
                from: from.map(|v| v as f32),
                to: to.map(|v| (v + between(-1.0, 1.0)) as f32),
                turn_rad: (local.turn_rad + between(-0.1, 0.1)) as f32,
                scale: (local.scale * between(-0.1, 0.1).exp()) as f32,
                radius_px: 14.0,
                weight: between(0.2, 0.6) as f32,
                vote: 0.3,
            }
        })
        .collect()
}

/// The votes of the matches for so many exemplars.
pub(super) fn votes_of(exemplars: usize, matches: &[Match]) -> Vec<f64> {
    let mut votes = vec![0.0; exemplars];
    matches.iter().for_each(|found| votes[found.exemplar as usize] += f64::from(found.vote));
    votes
}
