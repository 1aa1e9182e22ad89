//! Local naive Bayes (McCann, Lowe 2012) for places seen upright: of the k eigenpoints nearest to a window, the
//! farthest stands for the background. Each label among them gains the difference of squared distances to the
//! background and to its nearest eigenpoint, once a window.

use super::model::Exemplar;
use super::recognition::PointVote;
use super::vote::Tally;
use crate::eigen::Neighbour;
use crate::vision::InterestPoint;

/// Counts windows with their nearest eigenpoints, nearest first. A label has one vote a window, an exemplar's W counts
/// each window once.
pub(super) fn tally<'a>(
    windows: impl Iterator<Item = (InterestPoint, &'a [Neighbour])>,
    exemplar_of: impl Fn(usize) -> usize,
    exemplars: &[Exemplar],
) -> Tally {
    let mut points = Vec::new();
    let mut exemplar_weights = vec![0.0; exemplars.len()];
    let mut counted: Vec<usize> = Vec::new();
    for (point, neighbours) in windows {
        let Some((background, near)) = neighbours.split_last() else { continue };
        let square = |neighbour: &Neighbour| f64::from(neighbour.distance).powi(2);
        counted.clear();
        for neighbour in near {
            let exemplar = exemplar_of(neighbour.index);
            if counted.contains(&exemplar) {
                continue;
            }
            let gain = square(background) - square(neighbour);
            exemplar_weights[exemplar] += gain;
            if !counted.iter().any(|&other| exemplars[other].label == exemplars[exemplar].label) {
                points.push(PointVote::new(point, exemplar, neighbour.distance, gain));
            }
            counted.push(exemplar);
        }
    }
    Tally { points, exemplar_weights }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_gets_what_it_is_nearer_than_the_background_once_a_window() {
        let exemplar = |id: &str, label: &str| Exemplar {
            id: id.into(),
            label: label.into(),
            width_px: 9,
            height_px: 9,
            windows: 2,
            edges: Vec::new(),
        };
        let exemplars = [exemplar("1", "a"), exemplar("2", "a"), exemplar("3", "b")];
        let near = |index, distance| Neighbour { index, distance };
        // eigenpoints 0 and 1 belong to the first exemplar, 2 and 3 to the second, 4 and 5 to the third
        let row = [near(2, 1.0), near(0, 2.0), near(1, 2.5), near(4, 3.0), near(5, 4.0)];
        let point = InterestPoint { x_px: 1.0, y_px: 2.0, salience: 3.0 };
        let tally = tally([(point, &row[..])].into_iter(), |index| index / 2, &exemplars);
        assert_eq!(tally.exemplar_weights, [16.0 - 4.0, 16.0 - 1.0, 16.0 - 9.0]);
        let votes: Vec<(usize, f64)> = tally.points.iter().map(|p| (p.exemplar, p.weight)).collect();
        assert_eq!(votes, [(1, 15.0), (2, 7.0)]);
        assert!(super::tally([(point, &row[..0])].into_iter(), |index| index, &exemplars).points.is_empty());
    }
}
