//! An exemplar in 256 bytes, by which exemplars are chosen before their windows are looked at: a vector of locally aggregated
//! descriptors (VLAD; Jégou, Douze, Schmid and Pérez 2010), a bit a coordinate.
//!
//! Eigenpoints are scaled so that their directions differ less in variance; each adds the direction in which it lies from its
//! nearest centroid to that centroid's sum, and every sum counts alike, however many eigenpoints it has (Delhumeau, Gosselin,
//! Jégou and Pérez 2013). Of an exemplar only the signs of the sums' leading coordinates are kept; those of a frame keep their
//! sizes, in 4 bits.

use pulp::{Arch, Simd, WithSimd};

use crate::eigen::Codebook;
use crate::eigen::neighbours::dot;

/// Centroids at most.
const CENTROIDS: usize = 64;
/// Coordinates of each sum that are kept.
const COORDINATES: usize = 32;
/// Bytes of an exemplar.
pub(in super::super) const DESCRIPTOR_LENGTH: usize = CENTROIDS * COORDINATES / 8;
/// Bits of a word, and words of an exemplar.
const WORD: usize = 64;
const WORDS: usize = CENTROIDS * COORDINATES / WORD;
/// Bits that a frame's coordinates keep, and the part of the largest of them that still differs from larger ones.
const PLANES: usize = 4;
const LARGEST: f32 = 0.6;

/// An exemplar: the signs of its sums, centroid by centroid.
pub(in super::super) type Descriptor = [u8; DESCRIPTOR_LENGTH];

/// The centroids that eigenpoints are aggregated about.
pub(in super::super) struct Vlad {
    /// What each coordinate of an eigenpoint is multiplied by.
    scales: Vec<f32>,
    /// Centroids × dimension, of scaled eigenpoints.
    centroids: Vec<f32>,
}

impl Vlad {
    /// Centroids of n × dimension row-major eigenpoints, at least one, in an eigenspace with these variances along its
    /// directions.
    pub fn fit(points: &[f32], eigenvalues: &[f64]) -> Vlad {
        let scales = scales(eigenvalues);
        let scaled: Vec<f32> =
            points.chunks_exact(scales.len()).flat_map(|point| product(point, &scales)).collect();
        let centroids = Codebook::fit(&scaled, scales.len(), CENTROIDS).centroids().to_vec();
        Vlad { scales, centroids }
    }

    /// Centroids as they were kept; `None` if they are too many or of another dimension.
    pub fn of_centroids(centroids: Vec<f32>, eigenvalues: &[f64]) -> Option<Vlad> {
        let scales = scales(eigenvalues);
        let is_whole = !centroids.is_empty()
            && centroids.len().is_multiple_of(scales.len())
            && centroids.len() <= CENTROIDS * scales.len();
        is_whole.then_some(Vlad { scales, centroids })
    }

    /// Centroids × dimension.
    pub fn centroids(&self) -> &[f32] {
        &self.centroids
    }

    /// The sums of n × dimension eigenpoints, of unit length or 0: centroid by centroid the leading coordinates.
    fn aggregated(&self, points: &[f32]) -> [f32; CENTROIDS * COORDINATES] {
        let dimension = self.scales.len();
        let centroids = || self.centroids.chunks_exact(dimension);
        let squares: Vec<f64> = centroids().map(|centroid| dot(centroid, centroid)).collect();
        let mut sums = vec![0.0; self.centroids.len()];
        for point in points.chunks_exact(dimension) {
            let point: Vec<f32> = product(point, &self.scales).collect();
            let distances =
                centroids().zip(&squares).map(|(centroid, square)| square - 2.0 * dot(&point, centroid));
            let nearest =
                distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(centroid, _)| centroid);
            let own = nearest * dimension..(nearest + 1) * dimension;
            let off: Vec<f32> = point.iter().zip(&self.centroids[own.clone()]).map(|(v, c)| v - c).collect();
            let length = dot(&off, &off).sqrt() as f32;
            if length > 0.0 {
                sums[own].iter_mut().zip(&off).for_each(|(sum, off)| *sum += off / length);
            }
        }
        let mut aggregated = [0.0; CENTROIDS * COORDINATES];
        for (kept, sum) in aggregated.chunks_exact_mut(COORDINATES).zip(sums.chunks_exact(dimension)) {
            let leading = &sum[..dimension.min(COORDINATES)];
            let length = dot(leading, leading).sqrt() as f32;
            if length > 0.0 {
                kept.iter_mut().zip(leading).for_each(|(kept, sum)| *kept = sum / length);
            }
        }
        aggregated
    }

    /// What is kept of an exemplar with these eigenpoints.
    pub fn descriptor(&self, points: &[f32]) -> Descriptor {
        let mut descriptor = [0; DESCRIPTOR_LENGTH];
        for (at, sum) in self.aggregated(points).into_iter().enumerate() {
            descriptor[at / 8] |= u8::from(sum > 0.0) << (at % 8);
        }
        descriptor
    }

    /// The `count` exemplars that are likest a frame with these eigenpoints, of those that `may` be, ascending; of equal ones
    /// the first.
    pub fn likest(
        &self,
        points: &[f32],
        descriptors: &[Descriptor],
        may: impl Fn(usize) -> bool,
        count: usize,
    ) -> Vec<usize> {
        let sums = self.aggregated(points);
        let largest = sums.iter().fold(0.0_f32, |largest, sum| largest.max(sum.abs()));
        let unit = if largest > 0.0 { LARGEST * largest / 7.5 } else { 1.0 };
        // from 0 on: Σ ± v = 2 Σ v where the sign is +, less Σ v, and the last is the same for all
        let levels = sums.map(|sum| ((sum / unit).round().clamp(-8.0, 7.0) + 8.0) as u8);
        let mut planes = [[0_u64; WORDS]; PLANES];
        for (plane, words) in planes.iter_mut().enumerate() {
            for (at, level) in levels.iter().enumerate() {
                words[at / WORD] |= u64::from(level >> plane & 1) << (at % WORD);
            }
        }
        let mut scores = Arch::new().dispatch(Scores { planes: &planes, descriptors });
        scores.retain(|&(_, exemplar)| may(exemplar));
        let count = count.min(scores.len());
        if count < scores.len() {
            scores.select_nth_unstable_by(count, |a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
            scores.truncate(count);
        }
        let mut likest: Vec<usize> = scores.into_iter().map(|(_, exemplar)| exemplar).collect();
        likest.sort_unstable();
        likest
    }
}

/// The score of each exemplar, and its index.
struct Scores<'a> {
    planes: &'a [[u64; WORDS]; PLANES],
    descriptors: &'a [Descriptor],
}

impl WithSimd for Scores<'_> {
    type Output = Vec<(i32, usize)>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Vec<(i32, usize)> {
        let score = |descriptor: &Descriptor| {
            let words = descriptor.as_chunks::<8>().0;
            let mut score = 0;
            for (at, word) in words.iter().enumerate() {
                let word = u64::from_le_bytes(*word);
                score -= 8 * word.count_ones() as i32;
                for (plane, words) in self.planes.iter().enumerate() {
                    score += ((word & words[at]).count_ones() << plane) as i32;
                }
            }
            score
        };
        self.descriptors
            .iter()
            .enumerate()
            .map(|(exemplar, descriptor)| (score(descriptor), exemplar))
            .collect()
    }
}

/// λ^-¼: variances λ become √λ. Directions without variance count for nothing.
fn scales(eigenvalues: &[f64]) -> Vec<f32> {
    let scale = |&variance: &f64| if variance > 1e-12 { variance.powf(-0.25) as f32 } else { 0.0 };
    eigenvalues.iter().map(scale).collect()
}

fn product(point: &[f32], scales: &[f32]) -> impl Iterator<Item = f32> {
    point.iter().zip(scales).map(|(v, scale)| v * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const DIMENSION: usize = 40;

    fn points(count: usize, seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed, 7);
        (0..count * DIMENSION).map(|_| random.normals()[0] as f32).collect()
    }

    fn eigenvalues() -> Vec<f64> {
        (1..=DIMENSION).map(|at| 1.0 / at as f64).collect()
    }

    /// Points near others.
    fn seen_again(points: &[f32], seed: u64) -> Vec<f32> {
        let mut random = Random::new(seed, 8);
        points.iter().map(|v| v + 0.3 * random.normals()[0] as f32).collect()
    }

    #[test]
    fn what_shares_some_of_its_points_is_likest() {
        let vlad = Vlad::fit(&points(4000, 0), &eigenvalues());
        let exemplars: Vec<Vec<f32>> = (1..=200).map(|seed| points(120, seed)).collect();
        let descriptors: Vec<Descriptor> = exemplars.iter().map(|points| vlad.descriptor(points)).collect();
        for shown in [0, 77, 199] {
            // a third of the frame is the exemplar's
            let frame = [seen_again(&exemplars[shown][..60 * DIMENSION], 5), points(120, 1000)].concat();
            let likest = vlad.likest(&frame, &descriptors, |_| true, 10);
            assert!(
                likest.len() == 10 && likest.is_sorted() && likest.contains(&shown),
                "{shown}: {likest:?}"
            );
        }
    }

    #[test]
    fn scores_are_those_of_the_signs() {
        let vlad = Vlad::fit(&points(500, 3), &eigenvalues());
        let descriptors: Vec<Descriptor> = (10..40).map(|seed| vlad.descriptor(&points(30, seed))).collect();
        let frame = points(50, 4);
        let sums = vlad.aggregated(&frame);
        let score = |descriptor: &Descriptor| {
            let sign = |at: usize| if descriptor[at / 8] >> (at % 8) & 1 == 1 { 1.0 } else { -1.0 };
            (0..sums.len()).map(|at| f64::from(sums[at]) * sign(at)).sum::<f64>()
        };
        let likest = vlad.likest(&frame, &descriptors, |_| true, 5);
        let mut order: Vec<usize> = (0..30).collect();
        order.sort_by(|&a, &b| score(&descriptors[b]).total_cmp(&score(&descriptors[a])));
        // 4 bits may exchange neighbours
        assert!(likest.iter().all(|exemplar| order[..7].contains(exemplar)), "{likest:?} {order:?}");
        assert!(likest.contains(&order[0]));
        assert_eq!(vlad.likest(&frame, &descriptors, |_| true, 99), (0..30).collect::<Vec<_>>());
        assert_eq!(vlad.likest(&[], &descriptors, |exemplar| exemplar != 1, 3), [0, 2, 3]);
    }

    #[test]
    fn centroids_make_it_anew_and_others_are_refused() {
        let vlad = Vlad::fit(&points(10, 3), &eigenvalues());
        let again = Vlad::of_centroids(vlad.centroids().to_vec(), &eigenvalues()).unwrap();
        assert_eq!(again.descriptor(&points(30, 9)), vlad.descriptor(&points(30, 9)));
        assert!(Vlad::of_centroids(vlad.centroids()[1..].to_vec(), &eigenvalues()).is_none());
        assert!(Vlad::of_centroids(Vec::new(), &eigenvalues()).is_none());
        assert!(Vlad::of_centroids(vec![0.0; 65 * DIMENSION], &eigenvalues()).is_none());
    }
}
