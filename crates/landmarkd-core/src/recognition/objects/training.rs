//! Training (B(8)–(13)): the universal eigenspace, each object's own, and the curves through their eigenpoints.

use std::ops::Range;

use thiserror::Error;

use super::appearance::{Appearance, Canvas};
use super::held_out::{HeldOutView, Lesson, Neighbourhood, TRIALS, hold_out};
use super::model::{Objects, ViewName, way};
use super::object::{KnownObject, ViewSet};
use super::options::{Dimension, Distance, ObjectOptions, Stages};
use super::report::{DimensionRate, Told, TrainingReport};
use crate::eigen::{ClassCovariance, EigenError, Eigenspace, Vicinity};
use crate::recognition::OptionFault;

/// Views beyond which an eigenspace is found by iteration: then the whole spectrum would take minutes.
const EXACT_UP_TO: usize = 1500;
/// Coordinates of the universal eigenspace from which `auto` chooses, and most of an object's own.
pub(super) const AUTO_DIMENSION: usize = 64;
/// B§6 finds recognition poor below.
const LEAST_DIMENSION: usize = 8;
/// Nearly all of the training set's variance is beyond the views' own: a view that nothing else explains.
const MOST_LEVERAGE: f64 = 0.9;

/// An exemplar as training takes it.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Its own name, unique in the database.
    pub id: String,
    /// The object shown.
    pub label: String,
    /// How it is turned, in [0, 360).
    pub pose_deg: Option<f64>,
    /// From the canvas that [`Objects::train`] is given.
    pub appearance: Appearance,
}

/// Why no model came of a training.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    #[error("there are {views} exemplars; two that differ are the least")]
    TooFew { views: usize },
    #[error("all pictures are equal")]
    AllEqual,
    #[error("the exemplar id {id:?} occurs more than once")]
    DuplicateId { id: String },
    #[error("the exemplar {id:?} comes from another canvas, or its pose is not in [0, 360)")]
    OtherCanvas { id: String },
    #[error("the options can't be used")]
    Options { faults: Vec<OptionFault> },
    #[error("no eigenspace can be fitted")]
    Eigenspace { source: EigenError },
}

impl Objects {
    /// Train on views. Their order doesn't matter: they are sorted by label, pose, id. Black ones are left out.
    pub fn train(
        mut views: Vec<View>,
        canvas: &Canvas,
        options: &ObjectOptions,
    ) -> Result<(Objects, TrainingReport), TrainingError> {
        check(&views, canvas, options)?;
        views.sort_by(|a, b| {
            let pose = |view: &View| view.pose_deg.unwrap_or(f64::INFINITY);
            a.label.cmp(&b.label).then(pose(a).total_cmp(&pose(b))).then(a.id.cmp(&b.id))
        });
        let blank = views.extract_if(.., |view| view.appearance.is_blank()).map(|view| view.id).collect();
        let length = canvas.length();
        let mut rows = Vec::with_capacity(views.len() * length);
        for view in &mut views {
            rows.append(&mut std::mem::take(&mut view.appearance.vector));
        }
        let members = members(&views);
        let owner: Vec<usize> =
            members.iter().enumerate().flat_map(|(object, views)| vec![object; views.len()]).collect();
        let poses_deg: Vec<Option<f64>> = views.iter().map(|view| view.pose_deg).collect();

        let most = match options.dimension {
            Dimension::Auto => AUTO_DIMENSION,
            Dimension::Fixed(dimension) => dimension,
        };
        let (universal, spectrum) = fit(&rows, length, most)?; // B(8)–(12)
        let points: Vec<f32> = rows.chunks_exact(length).flat_map(|row| universal.locate(row).0).collect(); // B(13)
        let whole = Neighbourhood {
            points: &points,
            dimension: universal.dimension(),
            owner: &owner,
            poses_deg: &poses_deg,
        };
        let rate_by_dimension = rate_by_dimension(&whole);
        let dimension = match options.dimension {
            // B§6: where no object's own eigenspace follows, poses need all there is
            Dimension::Auto if options.stages == Stages::UniversalThenObject => {
                least_good(&rate_by_dimension)
            }
            _ => None,
        };
        let dimension = dimension.unwrap_or(universal.dimension());
        let points: Vec<f32> = points
            .chunks_exact(universal.dimension())
            .flat_map(|point| &point[..dimension])
            .copied()
            .collect();
        let universal = universal.truncated(dimension);

        let mut objects = Vec::with_capacity(members.len());
        let mut held_out = Vec::with_capacity(members.len());
        for members in &members {
            let rows = &rows[members.start * length..members.end * length];
            let poses_deg = &poses_deg[members.clone()];
            let (space, placed) = match options.stages {
                Stages::UniversalThenObject => {
                    let space = own_space(rows, length)?;
                    let placed = Placed::all(&space, rows);
                    (Some(space), placed)
                }
                Stages::UniversalOnly => (None, Placed::as_if_left_out(&universal, rows, views.len())),
            };
            held_out.push(hold_out(&placed.points, &placed.outside, poses_deg, placed.dimension));
            objects.push(KnownObject {
                label: views[members.start].label.clone(),
                space,
                views: ViewSet::new(&placed.points, poses_deg, placed.dimension),
                scale: None,
                usual: 0.0,
                held_out_deg: Vec::new(),
                points: placed.points,
            });
        }
        let lesson = Lesson::learn(&mut objects, &held_out);
        let covariances = match options.distance {
            Distance::Euclidean => None,
            Distance::Mahalanobis => Some(
                ClassCovariance::fit(&points, dimension, &owner, objects.len()) // B(15)
                    .map_err(|source| TrainingError::Eigenspace { source })?,
            ),
        };
        let mut model = Objects {
            options: options.clone(),
            canvas: canvas.clone(),
            names: views.iter().map(ViewName::from).collect(),
            universal,
            vicinity: Vicinity::new(points.clone(), dimension, way(options.search)),
            owner: owner.clone(),
            objects,
            covariances,
            calibration: None,
        };
        let held_out: Vec<HeldOutView> = held_out.into_iter().flatten().collect();
        let neighbourhood =
            Neighbourhood { points: &points, dimension, owner: &owner, poses_deg: &poses_deg };
        let trials =
            lesson.map(|lesson| lesson.trials(&model, &rows, &held_out, &neighbourhood)).unwrap_or_default();
        model.calibration = lesson
            .and_then(|lesson| lesson.calibrated(&model.objects, &trials, &neighbourhood, options.accept));
        let told = Told {
            model: &model,
            views: &views,
            rows: &rows,
            held_out: &held_out,
            trials: &trials,
            spectrum,
            rate_by_dimension,
            blank,
        };
        let report = told.report();
        Ok((model, report))
    }
}

impl From<&View> for ViewName {
    fn from(view: &View) -> Self {
        ViewName { id: view.id.clone(), label: view.label.clone(), pose_deg: view.pose_deg }
    }
}

fn check(views: &[View], canvas: &Canvas, options: &ObjectOptions) -> Result<(), TrainingError> {
    let faults = options.faults();
    if !faults.is_empty() {
        return Err(TrainingError::Options { faults });
    }
    let seen = views.iter().filter(|view| !view.appearance.is_blank()).count();
    if seen < 2 {
        return Err(TrainingError::TooFew { views: seen });
    }
    let mut ids: Vec<&str> = views.iter().map(|view| view.id.as_str()).collect();
    ids.sort_unstable();
    if let Some(pair) = ids.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(TrainingError::DuplicateId { id: pair[0].to_owned() });
    }
    let fits = |view: &&View| {
        view.appearance.vector.len() == canvas.length()
            && view.pose_deg.is_none_or(|pose| (0.0..360.0).contains(&pose))
    };
    match views.iter().find(|view| !fits(view)) {
        Some(view) => Err(TrainingError::OtherCanvas { id: view.id.clone() }),
        None => Ok(()),
    }
}

/// Which of the sorted views are of each object.
fn members(views: &[View]) -> Vec<Range<usize>> {
    let mut end = 0;
    let groups = views.chunk_by(|a, b| a.label == b.label).map(|group| {
        end += group.len();
        end - group.len()..end
    });
    groups.collect()
}

/// The leading directions of appearances, and their spectrum.
fn fit(rows: &[f32], length: usize, dimension: usize) -> Result<(Eigenspace, Vec<f64>), TrainingError> {
    let fitted = match (rows.len() / length).min(length) <= EXACT_UP_TO {
        true => Eigenspace::fit(rows, length, dimension),
        false => Eigenspace::fit_leading(rows, length, dimension),
    };
    fitted.map_err(|source| match source {
        EigenError::NoVariance { .. } => TrainingError::AllEqual,
        source => TrainingError::Eigenspace { source },
    })
}

/// The eigenspace of one object's appearances: a mean and no direction if they are one or all alike.
fn own_space(rows: &[f32], length: usize) -> Result<Eigenspace, TrainingError> {
    match fit(rows, length, AUTO_DIMENSION) {
        Ok((space, _)) => Ok(space),
        Err(TrainingError::AllEqual) => Ok(Eigenspace {
            mean: rows[..length].to_vec(),
            basis: Vec::new(),
            eigenvalues: Vec::new(),
            total_variance: 0.0,
        }),
        Err(error) => Err(error),
    }
}

/// Views as eigenpoints, and how far each lies from the space.
struct Placed {
    points: Vec<f32>,
    outside: Vec<f64>,
    dimension: usize,
}

impl Placed {
    fn all(space: &Eigenspace, rows: &[f32]) -> Placed {
        let (points, outside): (Vec<_>, Vec<_>) =
            rows.chunks_exact(space.length()).map(|row| space.locate(row)).unzip();
        Placed { points: points.concat(), outside, dimension: space.dimension() }
    }

    /// As far from the space as if the eigenspace of `count` views had been made without the view: its leverage on
    /// the principal components is taken away.
    fn as_if_left_out(space: &Eigenspace, rows: &[f32], count: usize) -> Placed {
        let mut placed = Placed::all(space, rows);
        let degrees = count.saturating_sub(1).max(1) as f64;
        for (outside, point) in placed.outside.iter_mut().zip(placed.points.chunks_exact(space.dimension())) {
            let parts =
                point.iter().zip(&space.eigenvalues).map(|(&z, v)| f64::from(z).powi(2) / (v * degrees));
            let leverage = 1.0 / count as f64 + parts.sum::<f64>();
            *outside /= 1.0 - leverage.min(MOST_LEVERAGE);
        }
        placed
    }
}

/// B Fig. 9: how many held-out views have their nearest eigenpoint among their own object's, for the leading one
/// coordinate, two, three …
fn rate_by_dimension(whole: &Neighbourhood) -> Vec<DimensionRate> {
    let (count, dimension) = (whole.owner.len(), whole.dimension);
    let across: Vec<Vec<f32>> =
        (0..dimension).map(|k| whole.points.iter().skip(k).step_by(dimension).copied().collect()).collect();
    let mut right = vec![0; dimension];
    let mut trials = 0;
    for view in (0..count).step_by(count.div_ceil(TRIALS)) {
        let mut squares: Vec<f32> =
            (0..count).map(|other| if whole.goes_with(other, view) { f32::INFINITY } else { 0.0 }).collect();
        let own = whole.owner[view];
        if !squares.iter().zip(whole.owner).any(|(square, &owner)| owner == own && square.is_finite()) {
            continue;
        }
        trials += 1;
        for (values, right) in across.iter().zip(&mut right) {
            let query = values[view];
            squares.iter_mut().zip(values).for_each(|(square, v)| *square += (v - query) * (v - query));
            let least = squares
                .iter()
                .fold(f32::INFINITY, |least, &square| if square < least { square } else { least });
            let nearest = squares.iter().position(|&square| square == least);
            *right += usize::from(nearest.is_some_and(|nearest| whole.owner[nearest] == own));
        }
    }
    if trials == 0 {
        return Vec::new();
    }
    right.iter().enumerate().map(|(k, &right)| DimensionRate { dimension: k + 1, right, trials }).collect()
}

/// The least dimension whose rate is within a standard error of the best, and no less than [`LEAST_DIMENSION`]: few
/// things are told apart by less, and new ones need more.
fn least_good(rates: &[DimensionRate]) -> Option<usize> {
    let share = |rate: &DimensionRate| rate.right as f64 / rate.trials as f64;
    let best = rates.iter().map(share).fold(0.0, f64::max);
    let error = (best * (1.0 - best) / rates.first()?.trials as f64).sqrt();
    let least = rates.iter().find(|rate| share(rate) >= best - error)?;
    Some(least.dimension.max(LEAST_DIMENSION).min(rates.len()))
}

#[cfg(test)]
mod tests {
    use super::super::pictures::{canvas, thing, turntable, view};
    use super::*;
    use crate::imaging::{Frame, Image};

    fn trained(views: Vec<View>) -> (Objects, TrainingReport) {
        let options = ObjectOptions::default();
        Objects::train(views, &canvas(&options), &options).unwrap()
    }

    fn refused(views: Vec<View>) -> TrainingError {
        let options = ObjectOptions::default();
        Objects::train(views, &canvas(&options), &options).err().unwrap()
    }

    #[test]
    fn the_order_of_views_changes_nothing() {
        let views = turntable(3, 30, &ObjectOptions::default());
        let mut shuffled = views.clone();
        shuffled.reverse();
        shuffled.swap(3, 17);
        let ((a, told_a), (b, told_b)) = (trained(views), trained(shuffled));
        assert_eq!(a.to_parts(), b.to_parts());
        assert_eq!(told_a, told_b);
    }

    #[test]
    fn the_report_tells_what_held_out_views_taught() {
        let (model, report) = trained(turntable(5, 15, &ObjectOptions::default()));
        assert_eq!((report.exemplars, report.labels, report.width_px), (120, 5, 48));
        let rates = &report.rate_by_dimension;
        assert!(rates[0].trials == 120 && rates[0].right < 120 && rates[report.dimension - 1].right >= 119);
        assert_eq!(report.dimension, model.dimension());
        let held_out = report.held_out.unwrap();
        // 0.97 of 120, and whatever lies on the threshold
        assert!((115..=118).contains(&held_out.known_accepted), "{held_out:?}");
        assert!(held_out.unknown == 120 && held_out.unknown_refused > 115, "{held_out:?}");
        for object in &report.objects {
            let pose = object.pose.unwrap();
            assert!(pose.trials == 24 && pose.within_5_deg >= 22, "{object:?}");
            assert!(object.gaps.is_empty() && object.threshold.unwrap() > 0.0);
        }
        assert!((0.5..1.0).contains(&report.energy_kept) && report.spectrum.len() == 120);
        let told: usize = report.confusion.iter().map(|confusion| confusion.times).sum();
        assert_eq!(told, held_out.known - held_out.known_right);
    }

    #[test]
    fn exemplars_that_are_cut_out_badly_are_told() {
        let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
        let canvas = Canvas::new(&options, (96, 96));
        let discs = |places: &[(f64, f64)]| {
            Frame::gray(Image::from_fn(96, 96, |x, y| {
                let near = |(to_x, to_y): &(f64, f64)| (x as f64 - to_x).hypot(y as f64 - to_y) < 15.0;
                if places.iter().any(near) { 120.0 + x as f32 } else { 10.0 }
            }))
        };
        let views = [
            ("whole", discs(&[(48.0, 48.0)])),
            ("cut", discs(&[(90.0, 40.0)])),
            ("two", discs(&[(24.0, 40.0), (70.0, 60.0)])),
            ("none", discs(&[])),
        ];
        let views = views.map(|(id, frame)| View { id: id.into(), ..view(&canvas, "disc", None, &frame) });
        let (_, report) = Objects::train(views.to_vec(), &canvas, &options).unwrap();
        assert_eq!(report.touches_border, ["cut"]);
        assert_eq!(report.several_regions, ["two"]);
        assert_eq!(report.blank, ["none"]);
    }

    #[test]
    fn what_is_wrong_with_exemplars_is_told() {
        let options = ObjectOptions::default();
        let canvas = canvas(&options);
        let mut views = turntable(2, 10, &options);
        views.retain(|view| view.label != "thing1" || !(120.0..160.0).contains(&view.pose_deg.unwrap()));
        let glare = Frame::gray(Image::from_fn(48, 48, |x, _| if x < 20 { 255.0 } else { 10.0 }));
        let dim = Frame::gray(Image::from_fn(48, 48, |x, y| 0.1 * thing(5, 0.0).luminance.at(x, y)));
        let black = Frame::gray(Image::from_fn(48, 48, |_, _| 0.0));
        let half = Frame::gray(crate::imaging::fitted(&thing(6, 3.0).luminance, 24, 24));
        for (id, pose, frame) in
            [("glare", 1.0, &glare), ("dim", 2.0, &dim), ("black", 3.0, &black), ("half", 4.0, &half)]
        {
            views.push(View { id: id.into(), ..view(&canvas, "odd", Some(pose), frame) });
        }
        views.push(View { id: "again".into(), ..view(&canvas, "odd", Some(2.0), &dim) });
        let (_, report) = trained(views);
        assert_eq!(
            (report.over_exposed, report.resized),
            (vec!["glare".to_owned()], vec!["half".to_owned()])
        );
        assert_eq!(report.under_exposed, ["again", "dim"]);
        assert_eq!(report.blank, ["black"]);
        assert_eq!(report.near_duplicates, [("again".to_owned(), "dim".to_owned())]);
        assert_eq!(report.repeated_poses, report.near_duplicates);
        let gaps = &report.objects.iter().find(|object| object.label == "thing1").unwrap().gaps;
        assert_eq!((gaps.len(), gaps[0].from_deg, gaps[0].to_deg), (1, 110.0, 160.0));
    }

    #[test]
    fn what_can_not_be_trained_says_why() {
        let options = ObjectOptions::default();
        let views = turntable(2, 90, &options);
        assert_eq!(refused(vec![]), TrainingError::TooFew { views: 0 });
        assert_eq!(refused(views[..1].to_vec()), TrainingError::TooFew { views: 1 });
        let same: Vec<View> = (0..4).map(|n| View { id: n.to_string(), ..views[0].clone() }).collect();
        assert_eq!(refused(same), TrainingError::AllEqual);
        let twice = vec![views[0].clone(), views[0].clone()];
        assert_eq!(refused(twice), TrainingError::DuplicateId { id: views[0].id.clone() });
        let mut other = views.clone();
        other[2].pose_deg = Some(360.0);
        assert_eq!(refused(other), TrainingError::OtherCanvas { id: views[2].id.clone() });
        let bad = ObjectOptions { accept: 2.0, ..options.clone() };
        let error = Objects::train(views, &canvas(&options), &bad).err().unwrap();
        assert!(matches!(error, TrainingError::Options { faults } if faults.len() == 1));
    }

    #[test]
    fn ten_thousand_identical_pictures_and_one_other_are_trained_or_refused_with_a_reason() {
        let options = ObjectOptions { dimension: Dimension::Fixed(4), ..ObjectOptions::default() };
        let canvas = Canvas::new(&options, (8, 8));
        let flat = |level: f32| Frame::gray(Image::from_fn(8, 8, |_, _| level));
        let alike = |level: f32| -> Vec<View> {
            let appearance = canvas.appearance(&flat(level)).unwrap();
            let label = |n: usize| format!("flat{}", n % 3);
            let view = |n: usize| View {
                id: n.to_string(),
                label: label(n),
                pose_deg: None,
                appearance: appearance.clone(),
            };
            (0..10_000).map(view).collect()
        };
        let train = |views| Objects::train(views, &canvas, &options).map(|(model, _)| model);
        assert_eq!(train(alike(120.0)).err(), Some(TrainingError::AllEqual));
        assert_eq!(train(alike(255.0)).err(), Some(TrainingError::AllEqual));
        // All black: nothing of it is an appearance.
        assert_eq!(train(alike(0.0)).err(), Some(TrainingError::TooFew { views: 0 }));
        let mut views = alike(120.0);
        let slope = Frame::gray(Image::from_fn(8, 8, |x, _| 30.0 * x as f32));
        views.push(view(&canvas, "slope", None, &slope));
        let model = train(views).unwrap();
        let nearest = |frame: &Frame| model.recognise(frame, |_| ()).unwrap().candidates[0].label.clone();
        assert_eq!(nearest(&slope), "slope");
        assert!(nearest(&flat(120.0)).starts_with("flat"));
    }

    #[test]
    fn a_label_with_one_view_stands_beside_others() {
        let options = ObjectOptions::default();
        let mut views = turntable(3, 15, &options);
        views.push(view(&canvas(&options), "lonely", Some(0.0), &thing(9, 0.0)));
        let (model, report) = trained(views);
        assert_eq!(report.objects[0].pose, None);
        let decision = model.recognise(&thing(9, 0.5), |_| ()).unwrap().decision.unwrap();
        assert_eq!((decision.label.as_str(), decision.pose), ("lonely", None));
    }
}
