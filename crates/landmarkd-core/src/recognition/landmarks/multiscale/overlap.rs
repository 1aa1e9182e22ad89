//! How far exemplars overlap in a frame: whether the same windows vote for both.
//!
//! Pictures of neighbouring places show one scene. The votes for them differ little, and partly by accident: a place's
//! votes are better told by those of the places about it too (kernel regression, Nadaraya 1964, Watson 1964).

/// Votes are smoothed by this power of the overlap.
const SHARPNESS: i32 = 2;

/// The overlap of the promising exemplars: the cosine between their votes, window by window.
pub(super) struct Overlap {
    /// Exemplars, ascending.
    exemplars: Vec<usize>,
    /// A row an exemplar.
    cosines: Vec<f64>,
}

impl Overlap {
    /// No exemplar overlaps another.
    pub fn none() -> Overlap {
        Overlap { exemplars: Vec::new(), cosines: Vec::new() }
    }

    /// Of votes (window, exemplar, vote), each window once an exemplar; `exemplars` ascend.
    pub fn of(exemplars: &[usize], votes: impl Iterator<Item = (usize, usize, f32)>) -> Overlap {
        let mut rows: Vec<Vec<(usize, f32)>> = vec![Vec::new(); exemplars.len()];
        for (window, exemplar, vote) in votes {
            if let Ok(row) = exemplars.binary_search(&exemplar) {
                rows[row].push((window, vote));
            }
        }
        rows.iter_mut().for_each(|row| row.sort_by_key(|(window, _)| *window));
        let lengths: Vec<f64> = rows.iter().map(|row| product(row, row).sqrt()).collect();
        let cosine = |(a, b): (usize, usize)| match lengths[a] * lengths[b] {
            both if both > 0.0 => product(&rows[a], &rows[b]) / both,
            _ => f64::from(u8::from(a == b)),
        };
        let all = 0..exemplars.len();
        let cosines = all.clone().flat_map(|a| all.clone().map(move |b| (a, b))).map(cosine).collect();
        Overlap { exemplars: exemplars.to_vec(), cosines }
    }

    /// 1 where the same windows vote alike for both exemplars, 0 where others do.
    pub fn between(&self, a: usize, b: usize) -> f64 {
        match (self.exemplars.binary_search(&a), self.exemplars.binary_search(&b)) {
            (Ok(a), Ok(b)) => self.cosines[a * self.exemplars.len() + b],
            _ => f64::from(u8::from(a == b)),
        }
    }

    /// The votes of exemplars, each the mean of those about it.
    pub fn smoothed(&self, votes: &[f64]) -> Vec<f64> {
        let mut smoothed = votes.to_vec();
        for (&exemplar, row) in self.exemplars.iter().zip(self.cosines.chunks(self.exemplars.len().max(1))) {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (&other, cosine) in self.exemplars.iter().zip(row) {
                let weight = cosine.powi(SHARPNESS);
                sum += weight * votes[other];
                weights += weight;
            }
            if weights > 0.0 {
                smoothed[exemplar] = sum / weights;
            }
        }
        smoothed
    }
}

/// The scalar product of sparse rows, sorted by window.
fn product(a: &[(usize, f32)], b: &[(usize, f32)]) -> f64 {
    let (mut sum, mut others) = (0.0, b.iter().peekable());
    for &(window, vote) in a {
        while others.next_if(|(other, _)| *other < window).is_some() {}
        if let Some((_, other)) = others.next_if(|(other, _)| *other == window) {
            sum += f64::from(vote * other);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exemplars_overlap_as_far_as_the_same_windows_vote_for_them() {
        let votes = [(0, 3, 1.0), (1, 3, 1.0), (1, 5, 1.0), (2, 5, 1.0), (7, 9, 2.0), (0, 4, 1.0)];
        let overlap = Overlap::of(&[3, 5, 8, 9], votes.into_iter());
        assert_eq!((overlap.between(8, 8), overlap.between(8, 3)), (1.0, 0.0), "nobody votes for it");
        assert!((overlap.between(3, 5) - 0.5).abs() < 1e-6);
        assert!((overlap.between(9, 9) - 1.0).abs() < 1e-6);
        assert_eq!((overlap.between(3, 9), overlap.between(4, 4), overlap.between(3, 4)), (0.0, 1.0, 0.0));
        let smoothed = overlap.smoothed(&[0.0, 0.0, 0.0, 10.0, 1.0, 20.0, 0.0, 0.0, 0.0, 7.0]);
        let weight = 0.25;
        assert!((smoothed[3] - (10.0 + weight * 20.0) / (1.0 + weight)).abs() < 1e-6);
        assert_eq!((smoothed[4], smoothed[9]), (1.0, 7.0));
    }

    #[test]
    fn without_overlap_votes_stay() {
        assert_eq!(Overlap::none().smoothed(&[3.0, 4.0]), [3.0, 4.0]);
        assert_eq!((Overlap::none().between(1, 1), Overlap::none().between(1, 2)), (1.0, 0.0));
    }
}
