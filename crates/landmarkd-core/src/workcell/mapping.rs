//! The map from the overview camera's pixels to the robot's millimetres: a similarity, an affine map or a homography,
//! fitted to correspondences by least squares in the robot's plane (Hartley and Zisserman, chapter 4).

use thiserror::Error;

use super::diagnosis::best_kind;
use crate::eigen::Symmetric;

/// A pixel and the place on the table that it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// x and y.
    pub image_px: [f64; 2],
    /// X and Y.
    pub robot_mm: [f64; 2],
}

/// The group of a mapping: what it preserves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MappingKind {
    /// Shapes: turned, scaled and moved. Two correspondences are the least.
    Similarity,
    /// Parallels. Three are the least.
    Affine,
    /// Straight lines: a camera that looks aslant. Four are the least.
    Homography,
}

/// Why no mapping can be fitted.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MappingError {
    /// The mapping has more parameters than the correspondences determine.
    #[error("{given} correspondences are too few: {needed} are the least")]
    TooFew {
        /// Number of correspondences.
        given: usize,
        /// The least number for the kind of mapping.
        needed: usize,
    },
    /// Two correspondences have a point in common.
    #[error("correspondences {first} and {second} have the same {what}")]
    Equal {
        /// Index of the one.
        first: usize,
        /// Index of the other.
        second: usize,
        /// `image_px` or `robot_mm`.
        what: &'static str,
    },
    /// All points are on one line.
    #[error("the correspondences' {what} lie on one straight line, or too nearly so")]
    Collinear {
        /// `image_px` or `robot_mm`.
        what: &'static str,
    },
    /// A coordinate is not finite, or too large.
    #[error("correspondence {at} has a number that is not finite, or beyond ±1e9")]
    NotFinite {
        /// Index of the correspondence.
        at: usize,
    },
    /// The homography puts points behind the camera.
    #[error("the correspondences fit no camera: some of them would be behind it")]
    Folded,
    /// The similarity shrinks the image to a point.
    #[error("no similarity fits the correspondences: flip_y is the wrong way round, or two are exchanged")]
    Unlike,
}

/// From pixels to the robot's plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// Which parameters were fitted.
    pub kind: MappingKind,
    /// Row by row: (X·w, Y·w, w) = matrix · (x, y, 1), in mm and pixels.
    pub matrix: [[f64; 3]; 3],
    /// Root mean square distance of the correspondences from where the mapping puts them.
    pub residual_mm: f64,
    /// Whether the correspondences have the other handedness than `flip_y` says: it is wrong, or two were exchanged.
    pub mirrored: bool,
}

/// Points whose breadth is below this part of their length are collinear.
const MIN_BREADTH: f64 = 0.01;
/// Points nearer to each other than this part of their RMS radius are one.
const ONE_POINT: f64 = 1e-6;
/// The second least eigenvalue of a homography's equations by the largest: below it, two homographies fit as well.
const MIN_EIGENVALUE_RATIO: f64 = 1e-8;
/// Iterations of the reweighted fit of a homography.
const REWEIGHTINGS: usize = 10;
/// A similarity of normalised points with a smaller scale fits nothing.
const MIN_SCALE: f64 = 0.01;
/// Points nearer to each other than this are one, in pixels and in mm.
const ONE_PLACE: f64 = 1e-9;
/// A residual below this part of the RMS radius is rounding.
const ROUNDING: f64 = 1e-6;
/// A mirrored similarity that leaves less than this part of the residual fits far better.
const FAR_BETTER: f64 = 0.5;
/// Coordinates beyond this are refused.
const LARGEST: f64 = 1e9;

impl MappingKind {
    /// All, those with fewer parameters first.
    pub const ALL: [MappingKind; 3] = [MappingKind::Similarity, MappingKind::Affine, MappingKind::Homography];

    /// The least number of correspondences.
    pub(super) fn least(self) -> usize {
        match self {
            MappingKind::Similarity => 2,
            MappingKind::Affine => 3,
            MappingKind::Homography => 4,
        }
    }
}

impl Mapping {
    /// The mapping that fits best; without a kind, that of [`best_kind`]. `flip_y` says whether the robot's Y grows where the image's y falls: a similarity takes it as given, the others
    /// find out.
    ///
    /// # Errors
    /// [`MappingError`] for too few correspondences and for degenerate ones.
    pub fn fit(
        correspondences: &[Correspondence],
        kind: Option<MappingKind>,
        flip_y: bool,
    ) -> Result<Mapping, MappingError> {
        let kind = kind.unwrap_or_else(|| best_kind(correspondences, flip_y));
        check(correspondences, kind)?;
        let image = Normalised::of("image_px", correspondences.iter().map(|pair| pair.image_px))?;
        let robot = Normalised::of("robot_mm", correspondences.iter().map(|pair| pair.robot_mm))?;
        let matrix = fit_normalised(kind, &image, &robot, flip_y)?;
        let of = |matrix| Mapping {
            kind,
            matrix: robot.denormalised(&image, matrix),
            residual_mm: 0.0,
            mirrored: false,
        };
        let mut mapping = of(matrix);
        mapping.residual_mm = mapping.rms_error_mm(correspondences).ok_or(MappingError::Folded)?;
        mapping.mirrored = match kind {
            // Two points, or collinear ones, fit with either handedness.
            MappingKind::Similarity if mapping.residual_mm <= ROUNDING * robot.rms_radius => false,
            MappingKind::Similarity => {
                let other = of(similarity(&image, &robot, !flip_y)).rms_error_mm(correspondences);
                other.is_some_and(|other_mm| other_mm < FAR_BETTER * mapping.residual_mm)
            }
            _ => mapping.is_reflection(image.centroid) != flip_y,
        };
        Ok(mapping)
    }

    /// Root mean square distance of the correspondences from where the mapping puts them; `None` if one is beyond the
    /// horizon.
    fn rms_error_mm(&self, correspondences: &[Correspondence]) -> Option<f64> {
        let squares = correspondences.iter().map(|pair| {
            let [x, y] = self.robot_mm(pair.image_px)?;
            Some((x - pair.robot_mm[0]).powi(2) + (y - pair.robot_mm[1]).powi(2))
        });
        Some((squares.sum::<Option<f64>>()? / correspondences.len() as f64).sqrt())
    }

    /// Where the robot finds what the pixel shows, X and Y in mm; `None` beyond the horizon of a homography.
    pub fn robot_mm(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let [along_x, along_y, depth] = self.matrix.map(|[a, b, c]| a * x + b * y + c);
        (depth > 0.0).then(|| [along_x / depth, along_y / depth])
    }

    /// Direction on the table of what points in the image from `at_px` along `angle_deg` (x towards y), in [−90, 90),
    /// from X towards Y; `None` beyond the horizon.
    pub fn axis_deg(&self, at_px: [f64; 2], angle_deg: f64) -> Option<f64> {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let [ahead, behind] =
            [0.5, -0.5].map(|step| self.robot_mm([at_px[0] + step * cos, at_px[1] + step * sin]));
        let (ahead, behind) = (ahead?, behind?);
        let turned_deg = (ahead[1] - behind[1]).atan2(ahead[0] - behind[0]).to_degrees();
        let axis_deg = (turned_deg + 90.0).rem_euclid(180.0) - 90.0;
        // The remainder of what is hardly below 0 is rounded up to the whole.
        Some(if axis_deg < 90.0 { axis_deg } else { -90.0 })
    }

    /// Whether the mapping reverses orientation at a point.
    fn is_reflection(&self, at_px: [f64; 2]) -> bool {
        let Some([x, y]) = self.robot_mm(at_px) else { return false };
        let beside = [[1.0, 0.0], [0.0, 1.0]].map(|[dx, dy]| self.robot_mm([at_px[0] + dx, at_px[1] + dy]));
        let [Some([right_x, right_y]), Some([down_x, down_y])] = beside else { return false };
        (right_x - x) * (down_y - y) - (right_y - y) * (down_x - x) < 0.0
    }
}

/// Check the number of correspondences and their coordinates.
fn check(correspondences: &[Correspondence], kind: MappingKind) -> Result<(), MappingError> {
    let given = correspondences.len();
    if given < kind.least() {
        return Err(MappingError::TooFew { given, needed: kind.least() });
    }
    let is_finite = |v: &f64| v.is_finite() && v.abs() <= LARGEST;
    let all_finite = |pair: &Correspondence| pair.image_px.iter().chain(&pair.robot_mm).all(is_finite);
    match correspondences.iter().position(|pair| !all_finite(pair)) {
        Some(at) => Err(MappingError::NotFinite { at }),
        None => Ok(()),
    }
}

/// Points about their centroid, of unit RMS radius: equations in them are well conditioned (Hartley).
struct Normalised {
    what: &'static str,
    points: Vec<[f64; 2]>,
    centroid: [f64; 2],
    /// Root mean square distance from the centroid.
    rms_radius: f64,
}

impl Normalised {
    fn of(what: &'static str, points: impl Iterator<Item = [f64; 2]>) -> Result<Normalised, MappingError> {
        let points: Vec<[f64; 2]> = points.collect();
        let count = points.len() as f64;
        let centroid = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let squares = points.iter().map(|[x, y]| (x - centroid[0]).powi(2) + (y - centroid[1]).powi(2));
        let rms_radius = (squares.sum::<f64>() / count).sqrt();
        for (second, b) in points.iter().enumerate() {
            let is_near =
                |a: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) <= (ONE_POINT * rms_radius).max(ONE_PLACE);
            if let Some(first) = points[..second].iter().position(is_near) {
                return Err(MappingError::Equal { first, second, what });
            }
        }
        let normalised = |[x, y]: &[f64; 2]| [(x - centroid[0]) / rms_radius, (y - centroid[1]) / rms_radius];
        Ok(Normalised { what, points: points.iter().map(normalised).collect(), centroid, rms_radius })
    }

    fn spans_a_plane(&self) -> Result<(), MappingError> {
        let moment = |a: usize, b: usize| self.points.iter().map(|point| point[a] * point[b]).sum::<f64>();
        let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
        let (mean, apart) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
        if mean - apart < MIN_BREADTH.powi(2) * (mean + apart) {
            return Err(MappingError::Collinear { what: self.what });
        }
        Ok(())
    }

    /// A map from `image` to these points, both normalised, as one from pixels to mm (T'⁻¹ H T).
    fn denormalised(&self, image: &Normalised, matrix: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let from = |[a, b, c]: [f64; 3]| {
            let (a, b) = (a / image.rms_radius, b / image.rms_radius);
            [a, b, c - a * image.centroid[0] - b * image.centroid[1]]
        };
        let [x, y, depth] = matrix.map(from);
        let axis =
            |row: [f64; 3], centroid: f64| [0, 1, 2].map(|k| self.rms_radius * row[k] + centroid * depth[k]);
        let rows = [axis(x, self.centroid[0]), axis(y, self.centroid[1]), depth];
        // The centroid of the image points is in front of the camera, at depth 1.
        let scale = depth[0] * image.centroid[0] + depth[1] * image.centroid[1] + depth[2];
        rows.map(|row| row.map(|v| v / scale))
    }
}

/// The mapping of that kind between two sets of normalised points.
fn fit_normalised(
    kind: MappingKind,
    image: &Normalised,
    robot: &Normalised,
    flip_y: bool,
) -> Result<[[f64; 3]; 3], MappingError> {
    if kind == MappingKind::Similarity {
        let matrix = similarity(image, robot, flip_y);
        let scale = matrix[0][0].hypot(matrix[1][0]);
        return if scale < MIN_SCALE { Err(MappingError::Unlike) } else { Ok(matrix) };
    }
    image.spans_a_plane()?;
    robot.spans_a_plane()?;
    if kind == MappingKind::Affine { Ok(affine(image, robot)) } else { homography(image, robot) }
}

/// The similarity between two sets of normalised points, of the handedness that is given.
fn similarity(image: &Normalised, robot: &Normalised, flip_y: bool) -> [[f64; 3]; 3] {
    let sign = if flip_y { -1.0 } else { 1.0 };
    let (mut along, mut across, mut all) = (0.0, 0.0, 0.0);
    for ([x, y], [robot_x, robot_y]) in image.points.iter().zip(&robot.points) {
        let y = sign * y;
        along += x * robot_x + y * robot_y;
        across += x * robot_y - y * robot_x;
        all += x * x + y * y;
    }
    let (cos, sin) = (along / all, across / all);
    [[cos, -sign * sin, 0.0], [sin, sign * cos, 0.0], [0.0, 0.0, 1.0]]
}

/// The affine map between two sets of normalised points that span a plane.
fn affine(image: &Normalised, robot: &Normalised) -> [[f64; 3]; 3] {
    let pairs = || image.points.iter().zip(&robot.points);
    let moment = |a: usize, b: usize| image.points.iter().map(|point| point[a] * point[b]).sum::<f64>();
    let (xx, xy, yy) = (moment(0, 0), moment(0, 1), moment(1, 1));
    let determinant = xx * yy - xy * xy;
    let row = |axis: usize| {
        let along = |k: usize| pairs().map(|(from, to)| from[k] * to[axis]).sum::<f64>();
        let (x, y) = (along(0), along(1));
        [(yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant, 0.0]
    };
    [row(0), row(1), [0.0, 0.0, 1.0]]
}

/// The homography between two sets of normalised points: the direct linear transformation, reweighted by the depths of
/// the last solution, so that the sum of squared distances on the table is nearly least.
fn homography(image: &Normalised, robot: &Normalised) -> Result<[[f64; 3]; 3], MappingError> {
    let mut depths = vec![1.0; image.points.len()];
    let mut matrix = [[0.0; 3]; 3];
    for _ in 0..REWEIGHTINGS {
        matrix = direct_linear_transformation(image, robot, &depths)?;
        for (depth, [x, y]) in depths.iter_mut().zip(&image.points) {
            *depth = matrix[2][0] * x + matrix[2][1] * y + matrix[2][2];
            if *depth <= 0.0 {
                return Err(MappingError::Folded);
            }
        }
    }
    let [[a, b, c], [d, e, f], [g, h, i]] = matrix;
    let determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    // Three collinear points and one beside them: the fit is singular.
    if determinant.abs() < MIN_BREADTH.powi(2) * i.abs().powi(3) {
        return Err(MappingError::Collinear { what: image.what });
    }
    Ok(matrix)
}

/// The direct linear transformation, each equation divided by the depth of its point; the centroid of the image points
/// is in front of the camera.
fn direct_linear_transformation(
    image: &Normalised,
    robot: &Normalised,
    depths: &[f64],
) -> Result<[[f64; 3]; 3], MappingError> {
    let mut normal = [0.0; 81];
    for (([x, y], [robot_x, robot_y]), depth) in image.points.iter().zip(&robot.points).zip(depths) {
        let pixel = [*x, *y, 1.0];
        for (axis, robot) in [(0, robot_x), (1, robot_y)] {
            let mut equation = [0.0; 9];
            for k in 0..3 {
                equation[3 * axis + k] = pixel[k] / depth;
                equation[6 + k] = -robot * pixel[k] / depth;
            }
            for (row, left) in equation.iter().enumerate() {
                for (column, right) in equation.iter().enumerate() {
                    normal[9 * row + column] += left * right;
                }
            }
        }
    }
    let collinear = MappingError::Collinear { what: image.what };
    let Some(solved) = Symmetric::of(&normal, 9) else { return Err(collinear) };
    if solved.values[7] < MIN_EIGENVALUE_RATIO * solved.values[0] {
        return Err(collinear);
    }
    let least = &solved.vectors[8];
    let sign = least[8].signum();
    Ok([0, 1, 2].map(|row| [0, 1, 2].map(|column| sign * least[3 * row + column])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(points: &[[f64; 2]], map: impl Fn(f64, f64) -> [f64; 2]) -> Vec<Correspondence> {
        points.iter().map(|&[x, y]| Correspondence { image_px: [x, y], robot_mm: map(x, y) }).collect()
    }

    const CORNERS: [[f64; 2]; 4] = [[20.0, 30.0], [600.0, 25.0], [610.0, 450.0], [15.0, 440.0]];

    fn assert_maps(mapping: &Mapping, map: impl Fn(f64, f64) -> [f64; 2]) {
        for [x, y] in [[0.0, 0.0], [320.0, 240.0], [639.0, 479.0], [100.0, 400.0]] {
            let (found, expected) = (mapping.robot_mm([x, y]).unwrap(), map(x, y));
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 1e-6, "({x}, {y}): {found:?}, not {expected:?}");
        }
    }

    #[test]
    fn two_points_and_the_handedness_settle_a_similarity() {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        let flipped = |x: f64, y: f64| [100.0 + 0.5 * (cos * x + sin * y), -40.0 + 0.5 * (sin * x - cos * y)];
        let mapping = Mapping::fit(&pairs(&CORNERS[..2], flipped), None, true).unwrap();
        assert_eq!((mapping.kind, mapping.mirrored), (MappingKind::Similarity, false));
        assert!(mapping.residual_mm < 1e-9);
        assert_maps(&mapping, flipped);
        let upright = |x: f64, y: f64| [3.0 + 0.2 * (cos * x - sin * y), 5.0 + 0.2 * (sin * x + cos * y)];
        assert_maps(&Mapping::fit(&pairs(&CORNERS[..2], upright), None, false).unwrap(), upright);
    }

    #[test]
    fn three_points_give_an_affine_map_and_four_a_homography_on_request() {
        let sheared = |x: f64, y: f64| [5.0 + 0.4 * x + 0.05 * y, 300.0 - 0.02 * x - 0.5 * y];
        let mapping = Mapping::fit(&pairs(&CORNERS[..3], sheared), None, true).unwrap();
        assert_eq!(mapping.kind, MappingKind::Affine);
        assert_maps(&mapping, sheared);
        let aslant = |x: f64, y: f64| {
            let depth = 1.0 + 0.0002 * x + 0.0007 * y;
            [(10.0 + 0.6 * x) / depth, (400.0 - 0.5 * y) / depth]
        };
        let mapping = Mapping::fit(&pairs(&CORNERS, aslant), Some(MappingKind::Homography), true).unwrap();
        assert!(!mapping.mirrored);
        assert_maps(&mapping, aslant);
        // The horizon of this camera: 1 + 0.0002 x + 0.0007 y = 0.
        assert_eq!(mapping.robot_mm([-4000.0, -1000.0]), None);
    }

    #[test]
    fn the_residual_is_what_is_left() {
        let shifted = |x: f64, y: f64| [0.5 * x, -0.5 * y];
        let mut given = pairs(&CORNERS, shifted);
        given.push(Correspondence { image_px: [300.0, 200.0], robot_mm: [151.0, -100.0] });
        for kind in [MappingKind::Similarity, MappingKind::Affine, MappingKind::Homography] {
            let mapping = Mapping::fit(&given, Some(kind), true).unwrap();
            let off = given.iter().map(|pair| {
                let [x, y] = mapping.robot_mm(pair.image_px).unwrap();
                (x - pair.robot_mm[0]).powi(2) + (y - pair.robot_mm[1]).powi(2)
            });
            let expected = (off.sum::<f64>() / 5.0).sqrt();
            assert!((mapping.residual_mm - expected).abs() < 1e-9, "{kind:?}");
            assert!((0.05..0.45).contains(&mapping.residual_mm), "{kind:?}: {}", mapping.residual_mm);
        }
    }

    #[test]
    fn a_homography_of_noisy_points_is_least_on_the_table() {
        let aslant = |x: f64, y: f64| {
            let depth = 1.0 + 0.001 * y;
            [0.6 * x / depth, -0.9 * y / depth]
        };
        let grid: Vec<[f64; 2]> = (0..30).map(|k| [110.0 * (k % 6) as f64, 100.0 * (k / 6) as f64]).collect();
        let mut given = pairs(&grid, aslant);
        for (k, pair) in given.iter_mut().enumerate() {
            pair.robot_mm[0] += ((k * 37) % 11) as f64 / 10.0 - 0.5;
            pair.robot_mm[1] += ((k * 53) % 13) as f64 / 12.0 - 0.5;
        }
        let best = Mapping::fit(&given, Some(MappingKind::Homography), true).unwrap();
        let residual = |mapping: &Mapping| -> f64 {
            let off = given.iter().map(|pair| {
                let [x, y] = mapping.robot_mm(pair.image_px).unwrap();
                (x - pair.robot_mm[0]).powi(2) + (y - pair.robot_mm[1]).powi(2)
            });
            (off.sum::<f64>() / 30.0).sqrt()
        };
        for at in 0..8 {
            for part in [0.9999, 1.0001] {
                let mut other = best.clone();
                other.matrix[at / 3][at % 3] *= part;
                assert!(
                    residual(&other) > best.residual_mm - 1e-3,
                    "{at}: {} {}",
                    residual(&other),
                    best.residual_mm
                );
            }
        }
    }

    #[test]
    fn a_wrong_handedness_is_told() {
        let flipped = |x: f64, y: f64| [0.5 * x, 200.0 - 0.5 * y];
        for kind in [MappingKind::Affine, MappingKind::Homography] {
            let given = pairs(&CORNERS, flipped);
            assert!(Mapping::fit(&given, Some(kind), false).unwrap().mirrored, "{kind:?}");
            assert!(!Mapping::fit(&given, Some(kind), true).unwrap().mirrored, "{kind:?}");
        }
    }

    #[test]
    fn a_similarity_the_wrong_way_round_is_told_or_refused_and_a_line_is_neither() {
        let flipped = |x: f64, y: f64| [0.5 * x, 200.0 - 0.5 * y];
        let long = pairs(&[[0.0, 0.0], [600.0, 0.0], [600.0, 100.0], [0.0, 100.0]], flipped);
        let fit =
            |given: &[Correspondence], flip_y| Mapping::fit(given, Some(MappingKind::Similarity), flip_y);
        assert!(fit(&long, false).unwrap().mirrored && !fit(&long, true).unwrap().mirrored);
        let square = pairs(&[[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]], flipped);
        assert_eq!(fit(&square, false), Err(MappingError::Unlike));
        for k in 0..50 {
            let (x, y) = (3.0 + f64::from(k), 17.0 + 7.0 * f64::from(k));
            let line = pairs(&[[x, y], [2.0 * x, 2.0 * y], [3.7 * x, 3.7 * y]], flipped);
            assert!(!fit(&line, true).unwrap().mirrored && !fit(&line, false).unwrap().mirrored, "{k}");
        }
    }

    #[test]
    fn degenerate_correspondences_are_refused() {
        let half = |x: f64, y: f64| [0.5 * x, -0.5 * y];
        let fit = |points: &[[f64; 2]], kind| Mapping::fit(&pairs(points, half), kind, true).unwrap_err();
        let twice = [[1.0, 2.0], [5.0, 9.0], [1.0, 2.0]];
        assert_eq!(fit(&twice, None), MappingError::Equal { first: 0, second: 2, what: "image_px" });
        let line = [[0.0, 0.0], [100.0, 50.0], [200.0, 100.3], [300.0, 150.0]];
        for kind in [MappingKind::Affine, MappingKind::Homography] {
            assert_eq!(fit(&line, Some(kind)), MappingError::Collinear { what: "image_px" });
        }
        let three_on_a_line = [[0.0, 0.0], [100.0, 50.0], [200.0, 100.0], [30.0, 300.0]];
        let error = fit(&three_on_a_line, Some(MappingKind::Homography));
        assert_eq!(error, MappingError::Collinear { what: "image_px" });
        assert_eq!(fit(&CORNERS[..1], None), MappingError::TooFew { given: 1, needed: 2 });
        let few = fit(&CORNERS[..3], Some(MappingKind::Homography));
        assert_eq!(few, MappingError::TooFew { given: 3, needed: 4 });
        let mut endless = pairs(&CORNERS, half);
        endless[2].robot_mm[1] = f64::INFINITY;
        assert_eq!(Mapping::fit(&endless, None, true), Err(MappingError::NotFinite { at: 2 }));
        let mut all_but_one = pairs(&CORNERS[..2], |_, _| [0.0, 0.0]);
        all_but_one[1].robot_mm = [1e-200, 0.0];
        let error = Mapping::fit(&all_but_one, None, true).unwrap_err();
        assert_eq!(error, MappingError::Equal { first: 0, second: 1, what: "robot_mm" });
        let place = |x: f64, y: f64| [x, -y];
        let mut one_place = pairs(&CORNERS[..2], place);
        one_place[1].robot_mm = one_place[0].robot_mm;
        let error = Mapping::fit(&one_place, None, true).unwrap_err();
        assert_eq!(error, MappingError::Equal { first: 0, second: 1, what: "robot_mm" });
    }

    #[test]
    fn exchanged_corners_fit_no_camera() {
        let mut given = pairs(&CORNERS, |x, y| [0.5 * x, -0.5 * y]);
        let first = given[0].robot_mm;
        given[0].robot_mm = given[1].robot_mm;
        given[1].robot_mm = first;
        let error = Mapping::fit(&given, Some(MappingKind::Homography), true).unwrap_err();
        assert_eq!(error, MappingError::Folded);
    }

    #[test]
    fn axes_turn_with_the_table() {
        let flipped = |x: f64, y: f64| [0.5 * x, -0.5 * y];
        let mapping = Mapping::fit(&pairs(&CORNERS, flipped), None, true).unwrap();
        for (image_deg, robot_deg) in [(0.0, 0.0), (30.0, -30.0), (-60.0, 60.0)] {
            let found = mapping.axis_deg([200.0, 100.0], image_deg).unwrap();
            assert!((found - robot_deg).abs() < 1e-6, "{image_deg}: {found}");
        }
    }
}
