//! What correspondences say about themselves: by how much each is off, which kind of mapping foretells one from the others
//! best, and which of them is wrong.

use super::{Correspondence, Mapping, MappingKind};

/// A kind with fewer parameters is taken unless one with more foretells better by this factor.
const FAR_BETTER: f64 = 0.8;
/// Errors below this part of the robot points' extent are rounding.
const ROUNDING: f64 = 1e-9;
/// Correspondences are looked through for a wrong one if the residual is above this part of the robot points' extent.
const SUSPICIOUS: f64 = 0.002;
/// What is found wrong leaves less than this part of the residual when it is put right, and what else might be, more
/// than twice that.
const MENDED: f64 = 0.25;
/// Of many correspondences, those that are farthest off are tried.
const MOST_TRIED: usize = 8;
const MOST_LEFT_OUT: usize = 20;

/// What is wrong with some correspondences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suspect {
    /// The robot's points of these two, by their indices, are exchanged.
    Exchanged([usize; 2]),
    /// This one is far from where all others put it.
    Outlying(usize),
}

/// From each correspondence to where a mapping puts it, in mm; `None` beyond the horizon.
pub fn residuals_mm(mapping: &Mapping, correspondences: &[Correspondence]) -> Vec<Option<f64>> {
    correspondences.iter().map(|pair| residual_mm(mapping, pair)).collect()
}

fn residual_mm(mapping: &Mapping, pair: &Correspondence) -> Option<f64> {
    let [x, y] = mapping.robot_mm(pair.image_px)?;
    Some((x - pair.robot_mm[0]).hypot(y - pair.robot_mm[1]))
}

/// Root mean square distance from each correspondence to where a mapping fitted to the others puts it, in mm; `None` if
/// one of them can't be foretold: too few are left, or they are degenerate. Of many, [`MOST_LEFT_OUT`] are left out.
pub fn leave_one_out_mm(correspondences: &[Correspondence], kind: MappingKind, flip_y: bool) -> Option<f64> {
    let every = correspondences.len().div_ceil(MOST_LEFT_OUT).max(1);
    let left_out = (0..correspondences.len()).step_by(every);
    let count = left_out.len();
    let squares = left_out.map(|left_out| {
        let mapping = Mapping::fit(&without(correspondences, left_out), Some(kind), flip_y).ok()?;
        Some(residual_mm(&mapping, &correspondences[left_out])?.powi(2))
    });
    Some((squares.sum::<Option<f64>>()? / count.max(1) as f64).sqrt())
}

/// The kind of mapping whose leave-one-out error is least, one with fewer parameters if it is hardly more. Without any: an
/// affine map from three correspondences on, else a similarity.
pub fn best_kind(correspondences: &[Correspondence], flip_y: bool) -> MappingKind {
    if correspondences.len() < MappingKind::Affine.least() {
        return MappingKind::Similarity;
    }
    // Of points on a line no mapping of the plane can be told, and none is chosen that hides it.
    if Mapping::fit(correspondences, Some(MappingKind::Affine), flip_y).is_err() {
        return MappingKind::Affine;
    }
    let rounding = ROUNDING * extent_mm(correspondences);
    let mut best = None;
    for kind in MappingKind::ALL {
        let Some(error_mm) = leave_one_out_mm(correspondences, kind, flip_y) else { continue };
        // With three correspondences an affine map can't be judged, and a similarity alone isn't chosen.
        if correspondences.len() > MappingKind::Affine.least()
            && best.is_none_or(|(_, least_mm)| error_mm < FAR_BETTER * least_mm - rounding)
        {
            best = Some((kind, error_mm));
        }
    }
    best.map_or(MappingKind::Affine, |(kind, _)| kind)
}

/// What is wrong with correspondences that a mapping doesn't fit, if one exchange or one point explains it.
pub fn suspect(mapping: &Mapping, correspondences: &[Correspondence], flip_y: bool) -> Option<Suspect> {
    if mapping.residual_mm <= SUSPICIOUS * extent_mm(correspondences) {
        return None;
    }
    let mut tried: Vec<usize> = (0..correspondences.len()).collect();
    let residuals = residuals_mm(mapping, correspondences);
    let residual = |at: usize| residuals[at].unwrap_or(f64::INFINITY);
    tried.sort_by(|&a, &b| residual(b).total_cmp(&residual(a)));
    tried.truncate(MOST_TRIED);
    let left_mm = |correspondences: &[Correspondence]| {
        let mended = Mapping::fit(correspondences, Some(mapping.kind), flip_y).ok()?;
        let is_judged = correspondences.len() > mapping.kind.least();
        (is_judged && !mended.mirrored).then_some(mended.residual_mm)
    };
    let mut found: Vec<(f64, Suspect)> = Vec::new();
    for (k, &first) in tried.iter().enumerate() {
        let others = without(correspondences, first);
        found.extend(left_mm(&others).map(|left_mm| (left_mm, Suspect::Outlying(first))));
        for &second in &tried[..k] {
            let mut exchanged = correspondences.to_vec();
            (exchanged[first].robot_mm, exchanged[second].robot_mm) =
                (correspondences[second].robot_mm, correspondences[first].robot_mm);
            let pair = Suspect::Exchanged([first.min(second), first.max(second)]);
            found.extend(left_mm(&exchanged).map(|left_mm| (left_mm, pair)));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (left_mm, suspect) = *found.first()?;
    let is_the_only_one = found.get(1).is_none_or(|(next_mm, _)| *next_mm > 2.0 * left_mm);
    (left_mm < MENDED * mapping.residual_mm && is_the_only_one).then_some(suspect)
}

fn without(correspondences: &[Correspondence], left_out: usize) -> Vec<Correspondence> {
    let kept = correspondences.iter().enumerate().filter(|(at, _)| *at != left_out);
    kept.map(|(_, pair)| *pair).collect()
}

/// Diagonal of the box around the robot's points.
fn extent_mm(correspondences: &[Correspondence]) -> f64 {
    let side = |axis: usize| {
        let along = correspondences.iter().map(|pair| pair.robot_mm[axis]);
        along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
    };
    side(0).hypot(side(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [[f64; 2]; 8] = [
        [20.0, 30.0],
        [600.0, 25.0],
        [610.0, 450.0],
        [15.0, 440.0],
        [300.0, 230.0],
        [180.0, 120.0],
        [470.0, 140.0],
        [330.0, 400.0],
    ];

    /// Correspondences of a map, each robot point off by up to half of `noise_mm` along each axis.
    fn seen(count: usize, noise_mm: f64, map: impl Fn(f64, f64) -> [f64; 2]) -> Vec<Correspondence> {
        let pairs = PLACES[..count].iter().enumerate().map(|(k, &[x, y])| {
            let [robot_x, robot_y] = map(x, y);
            let off = [((k * 37) % 11) as f64 / 10.0 - 0.5, ((k * 53 + 3) % 13) as f64 / 12.0 - 0.5];
            let robot_mm = [robot_x + noise_mm * off[0], robot_y + noise_mm * off[1]];
            Correspondence { image_px: [x, y], robot_mm }
        });
        pairs.collect()
    }

    fn similar(x: f64, y: f64) -> [f64; 2] {
        [100.0 + 0.48 * x + 0.14 * y, 300.0 + 0.14 * x - 0.48 * y]
    }

    fn sheared(x: f64, y: f64) -> [f64; 2] {
        [5.0 + 0.4 * x + 0.05 * y, 300.0 - 0.02 * x - 0.5 * y]
    }

    fn aslant(x: f64, y: f64) -> [f64; 2] {
        let depth = 1.0 + 0.0002 * x + 0.0007 * y;
        [(10.0 + 0.6 * x) / depth, (400.0 - 0.5 * y) / depth]
    }

    #[test]
    fn the_kind_that_foretells_best_is_chosen() {
        for noise_mm in [0.0, 0.4] {
            assert_eq!(best_kind(&seen(8, noise_mm, similar), true), MappingKind::Similarity, "{noise_mm}");
            assert_eq!(best_kind(&seen(8, noise_mm, sheared), true), MappingKind::Affine, "{noise_mm}");
            assert_eq!(best_kind(&seen(8, noise_mm, aslant), true), MappingKind::Homography, "{noise_mm}");
        }
        let kind = |count| best_kind(&seen(count, 0.2, sheared), true);
        assert_eq!([2, 3, 4].map(kind), [MappingKind::Similarity, MappingKind::Affine, MappingKind::Affine]);
    }

    #[test]
    fn leaving_one_out_shows_what_the_residual_hides() {
        let noisy = seen(8, 1.0, similar);
        let homography = Mapping::fit(&noisy, Some(MappingKind::Homography), true).unwrap();
        let similarity = Mapping::fit(&noisy, Some(MappingKind::Similarity), true).unwrap();
        assert!(homography.residual_mm < similarity.residual_mm);
        let left_out = |kind| leave_one_out_mm(&noisy, kind, true).unwrap();
        assert!(left_out(MappingKind::Homography) > left_out(MappingKind::Similarity));
        assert_eq!(leave_one_out_mm(&noisy[..4], MappingKind::Homography, true), None);
        let off_mm = residuals_mm(&similarity, &noisy);
        let squares: f64 = off_mm.iter().map(|off| off.unwrap().powi(2)).sum();
        assert!(((squares / 8.0).sqrt() - similarity.residual_mm).abs() < 1e-9);
    }

    #[test]
    fn two_exchanged_points_are_named() {
        type Map = fn(f64, f64) -> [f64; 2];
        let maps: [(MappingKind, Map, usize); 4] = [
            (MappingKind::Similarity, similar, 4),
            (MappingKind::Affine, sheared, 5),
            (MappingKind::Affine, sheared, 8),
            (MappingKind::Homography, aslant, 8),
        ];
        for (kind, map, count) in maps {
            let right = seen(count, 0.3, map);
            let fitted = Mapping::fit(&right, Some(kind), true).unwrap();
            assert_eq!(suspect(&fitted, &right, true), None, "{kind:?}");
            for (first, second) in [(0, 1), (1, 3), (2, 3)] {
                let mut wrong = right.clone();
                (wrong[first].robot_mm, wrong[second].robot_mm) =
                    (right[second].robot_mm, right[first].robot_mm);
                let Ok(fitted) = Mapping::fit(&wrong, Some(kind), true) else { continue };
                let named = suspect(&fitted, &wrong, true);
                assert_eq!(
                    named,
                    Some(Suspect::Exchanged([first, second])),
                    "{kind:?} of {count}: {fitted:?}"
                );
            }
        }
    }

    #[test]
    fn a_mistyped_point_is_named_and_a_common_error_is_not() {
        let mut mistyped = seen(8, 0.3, sheared);
        mistyped[6].robot_mm[1] += 90.0;
        let fitted = Mapping::fit(&mistyped, Some(MappingKind::Affine), true).unwrap();
        assert_eq!(suspect(&fitted, &mistyped, true), Some(Suspect::Outlying(6)));
        let coarse = seen(8, 40.0, sheared);
        let fitted = Mapping::fit(&coarse, Some(MappingKind::Affine), true).unwrap();
        assert!(fitted.residual_mm > SUSPICIOUS * extent_mm(&coarse));
        assert_eq!(suspect(&fitted, &coarse, true), None);
    }
}
