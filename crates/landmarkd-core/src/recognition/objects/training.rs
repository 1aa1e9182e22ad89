//! Training (B(8)–(13)): the universal eigenspace, each object's own, and the curves through their eigenpoints.

use std::ops::Range;

use thiserror::Error;

use super::aligned_trials::aligned_trials;
use super::appearance::{Appearance, Normaliser, SizeMismatch};
use super::held_out::{HeldOutStatistics, HeldOutView, LabelledPoints, MAX_TRIALS, Trial, leave_each_out};
use super::model::{Objects, ViewName, class_covariances};
use super::object::{KnownObject, ViewSet};
use super::options::{AppearanceOf, Dimension, ObjectOptions, Stages};
use super::parts::ObjectPart;
use super::report::{DimensionRate, ReportInput, TrainingReport};
use crate::eigen::{EigenError, Eigenspace, RadiusIndex};
use crate::imaging::Frame;
use crate::recognition::{Colour, OptionFault};
use crate::vision::GradientField;

/// Views beyond which an eigenspace is found by iteration: then the whole spectrum would take minutes.
const EXACT_UP_TO: usize = 1500;
/// Coordinates of the universal eigenspace from which `auto` chooses, and most of an object's own.
pub(super) const AUTO_DIMENSION: usize = 64;
/// B§6 finds recognition poor below.
const MIN_DIMENSION: usize = 8;
/// Views that are shifted or partly hidden are told apart by more than whole ones.
const MIN_DIMENSION_OF_GRADIENTS: usize = 24;
/// Disturbed views that are shown to a database: more take longer and tell no more.
const MAX_DISTURBED: usize = 400;
/// A leverage is taken to be no larger: the view is then alone on nearly all of its principal components.
const MAX_LEVERAGE: f64 = 0.9;

/// An exemplar as training takes it.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Its own name, unique in the database.
    pub id: String,
    /// The object shown.
    pub label: String,
    /// Turn about the vertical, in [0, 360).
    pub pose_deg: Option<f64>,
    /// Made by the normaliser that [`train`] is given.
    pub appearance: Appearance,
    /// The same, disturbed: acceptance and confidence are estimated by such views.
    pub(super) disturbed: Option<GradientField>,
}

impl View {
    /// The view that a picture shows. Only a view that `is_trial` is shown to the trained database, disturbed;
    /// [`is_trial`] says which should be.
    ///
    /// # Errors
    /// [`SizeMismatch`] as [`Normaliser::appearance`].
    pub fn new(
        normaliser: &Normaliser,
        ViewName { id, label, pose_deg }: ViewName,
        frame: &Frame,
        is_trial: bool,
    ) -> Result<View, SizeMismatch> {
        let appearance = normaliser.appearance(frame)?;
        let disturbed = if is_trial { normaliser.disturbed(frame, &id)? } else { None };
        Ok(View { id, label, pose_deg, appearance, disturbed })
    }
}

/// Whether view `index` of `count` should be a trial: all of few, and of many as many as tell the rates.
pub fn is_trial(index: usize, count: usize) -> bool {
    index.is_multiple_of(count.div_ceil(MAX_DISTURBED).max(1))
}

/// Why a training gives no model.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    /// Fewer than two views are not blank.
    #[error("there are {views} exemplars; two that differ are the least")]
    TooFew {
        /// Views that are not blank.
        views: usize,
    },
    /// The appearances have no variance.
    #[error("all pictures are equal")]
    AllEqual,
    /// Two views have one id.
    #[error("the exemplar id {id:?} occurs more than once")]
    DuplicateId {
        /// The id.
        id: String,
    },
    /// An appearance has another length than the normaliser gives, or a pose is out of range.
    #[error("the exemplar {id:?} comes from another normaliser, or its pose is not in [0, 360)")]
    OtherNormaliser {
        /// The view's id.
        id: String,
    },
    /// See [`ObjectOptions::faults`].
    #[error("the options can't be used")]
    Options {
        /// All faults.
        faults: Vec<OptionFault>,
    },
    /// The linear algebra failed.
    #[error("no eigenspace can be fitted")]
    Eigenspace {
        /// Why.
        source: EigenError,
    },
}

/// Train a database on views. Their order doesn't matter: they are sorted by label, pose, id. Blank ones are left out.
///
/// # Errors
/// [`TrainingError`] for options, ids or poses that can't be used, and for views that don't differ.
pub fn train(
    views: Vec<View>,
    normaliser: &Normaliser,
    options: &ObjectOptions,
) -> Result<(Objects, TrainingReport), TrainingError> {
    check(&views, normaliser, options)?;
    let normaliser = &resolved(normaliser, &views);
    let options = &ObjectOptions { colour: normaliser.colour(), ..options.clone() };
    let (set, blank) = TrainingSet::of(views, normaliser.length());
    let UniversalFit { space, points, spectrum, rate_by_dimension } = UniversalFit::of(&set, options)?;
    let (mut objects, held_out) = fit_objects(&set, &space, options.stages)?;
    let statistics = HeldOutStatistics::of(&held_out);
    if let Some(statistics) = &statistics {
        statistics.describe(&mut objects, &held_out);
    }
    let covariances = class_covariances(options.distance, &points, &set.object_of_view, objects.len()) // B(15)
        .map_err(|source| TrainingError::Eigenspace { source })?;
    let mut model = Objects {
        options: options.clone(),
        normaliser: normaliser.clone(),
        views: set.views.iter().map(ViewName::from).collect(),
        radius_index: RadiusIndex::new(points, space.dimension(), options.search),
        universal: space,
        object_of_view: set.object_of_view.clone(),
        objects,
        covariances,
        acceptance: None,
    };
    let held_out: Vec<HeldOutView> = held_out.concat();
    let trials =
        statistics.map_or_else(Vec::new, |statistics| calibrate(&mut model, &statistics, &set, &held_out)); // B(16)
    let input = ReportInput {
        model: &model,
        views: &set.views,
        rows: &set.rows,
        held_out: &held_out,
        trials: &trials,
        spectrum,
        rate_by_dimension,
        blank,
    };
    let report = input.report();
    Ok((model, report))
}

/// The normaliser with `auto` resolved: colours if every view has them.
fn resolved(normaliser: &Normaliser, views: &[View]) -> Normaliser {
    let colour = match normaliser.colour() {
        Colour::Auto if views.iter().all(|view| view.appearance.is_colour) => Colour::Opponent,
        Colour::Auto => Colour::Gray,
        colour => colour,
    };
    normaliser.clone().with_colour(colour)
}

/// Show held-out views to the model, and set its acceptance by their trials.
fn calibrate(
    model: &mut Objects,
    statistics: &HeldOutStatistics,
    set: &TrainingSet,
    held_out: &[HeldOutView],
) -> Vec<Trial> {
    let points = set.labelled(model.radius_index.points(), model.dimension());
    let trials = match model.options.appearance {
        AppearanceOf::Intensity => statistics.trials(model, &set.rows, held_out, &points),
        AppearanceOf::Gradient => aligned_trials(model, &set.disturbed, &points, statistics.distance_ratio),
    };
    model.acceptance = statistics.acceptance(model, &trials, &points);
    trials
}

impl From<&View> for ViewName {
    fn from(view: &View) -> Self {
        ViewName { id: view.id.clone(), label: view.label.clone(), pose_deg: view.pose_deg }
    }
}

fn check(views: &[View], normaliser: &Normaliser, options: &ObjectOptions) -> Result<(), TrainingError> {
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
        view.appearance.vector.len() == normaliser.length()
            && view.pose_deg.is_none_or(|pose| (0.0..360.0).contains(&pose))
    };
    match views.iter().find(|view| !fits(view)) {
        Some(view) => Err(TrainingError::OtherNormaliser { id: view.id.clone() }),
        None => Ok(()),
    }
}

/// The views sorted by object, and their appearances as one matrix.
struct TrainingSet {
    /// By label, then pose, then id; their vectors are moved into `rows`.
    views: Vec<View>,
    /// views × length, row-major.
    rows: Vec<f32>,
    /// By view: the same, disturbed.
    disturbed: Vec<Option<GradientField>>,
    /// Components of an appearance.
    length: usize,
    /// Which views are of each object.
    members: Vec<Range<usize>>,
    /// Index of the object of each view.
    object_of_view: Vec<usize>,
    poses_deg: Vec<Option<f64>>,
}

impl TrainingSet {
    /// The set, and the ids of blank views, which are left out.
    fn of(mut views: Vec<View>, length: usize) -> (TrainingSet, Vec<String>) {
        views.sort_by(|a, b| {
            let pose = |view: &View| view.pose_deg.unwrap_or(f64::INFINITY);
            a.label.cmp(&b.label).then(pose(a).total_cmp(&pose(b))).then(a.id.cmp(&b.id))
        });
        let blank = views.extract_if(.., |view| view.appearance.is_blank()).map(|view| view.id).collect();
        let mut rows = Vec::with_capacity(views.len() * length);
        let mut disturbed = Vec::with_capacity(views.len());
        for view in &mut views {
            let mut vector = std::mem::take(&mut view.appearance.vector);
            // Without colours an appearance is its first part.
            vector.truncate(length);
            rows.append(&mut vector);
            disturbed.push(view.disturbed.take());
        }
        let (mut members, mut object_of_view) = (Vec::new(), Vec::with_capacity(views.len()));
        for group in views.chunk_by(|a, b| a.label == b.label) {
            let first = object_of_view.len();
            object_of_view.extend(vec![members.len(); group.len()]);
            members.push(first..first + group.len());
        }
        let poses_deg = views.iter().map(|view| view.pose_deg).collect();
        (TrainingSet { views, rows, disturbed, length, members, object_of_view, poses_deg }, blank)
    }

    /// n × `dimension` eigenpoints with the object and pose of each.
    fn labelled<'a>(&'a self, points: &'a [f32], dimension: usize) -> LabelledPoints<'a> {
        LabelledPoints { points, dimension, object_of_view: &self.object_of_view, poses_deg: &self.poses_deg }
    }
}

/// The universal eigenspace and the views in it.
struct UniversalFit {
    space: Eigenspace,
    /// views × dimension, row-major.
    points: Vec<f32>,
    spectrum: Vec<f64>,
    rate_by_dimension: Vec<DimensionRate>,
}

impl UniversalFit {
    /// Fit all views, and keep as many directions as the options say.
    fn of(set: &TrainingSet, options: &ObjectOptions) -> Result<UniversalFit, TrainingError> {
        let most = match options.dimension {
            Dimension::Auto => AUTO_DIMENSION,
            Dimension::Fixed(dimension) => dimension,
        };
        let (space, spectrum) = fit(&set.rows, set.length, most)?; // B(8)–(12)
        let points: Vec<f32> =
            set.rows.chunks_exact(set.length).flat_map(|row| space.locate(row).0).collect(); // B(13)
        let rate_by_dimension = rate_by_dimension(&set.labelled(&points, space.dimension()));
        let chosen = match options.dimension {
            // B§6: where no object's own eigenspace follows, poses need all there is
            Dimension::Auto if options.stages == Stages::UniversalThenObject => {
                let least = match options.appearance {
                    AppearanceOf::Intensity => MIN_DIMENSION,
                    AppearanceOf::Gradient => MIN_DIMENSION_OF_GRADIENTS,
                };
                least_good(&rate_by_dimension, least)
            }
            _ => None,
        };
        let dimension = chosen.unwrap_or(space.dimension());
        let points =
            points.chunks_exact(space.dimension()).flat_map(|point| &point[..dimension]).copied().collect();
        Ok(UniversalFit { space: space.truncated(dimension), points, spectrum, rate_by_dimension })
    }
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

/// Each object with its views in its own eigenspace or the universal one, and what leaving each of them out shows.
fn fit_objects(
    set: &TrainingSet,
    universal: &Eigenspace,
    stages: Stages,
) -> Result<(Vec<KnownObject>, Vec<Vec<HeldOutView>>), TrainingError> {
    let mut objects = Vec::with_capacity(set.members.len());
    let mut held_out = Vec::with_capacity(set.members.len());
    for members in &set.members {
        let rows = &set.rows[members.start * set.length..members.end * set.length];
        let poses_deg = &set.poses_deg[members.clone()];
        let space = match stages {
            Stages::UniversalThenObject => Some(own_space(rows, set.length)?),
            Stages::UniversalOnly => None,
        };
        let projected = match &space {
            Some(space) => ProjectedViews::of(space, rows),
            None => ProjectedViews::without_own_leverage(universal, rows, set.views.len()),
        };
        held_out.push(leave_each_out(&projected, poses_deg));
        let views = ViewSet::new(&projected.points, poses_deg, projected.dimension);
        let eigenpoints = if space.is_some() { projected.points } else { Vec::new() };
        let part = ObjectPart { space, eigenpoints, ..ObjectPart::default() };
        objects.push(KnownObject { label: set.views[members.start].label.clone(), part, views });
    }
    Ok((objects, held_out))
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

/// Views as eigenpoints, and the distance of each from the space.
pub(super) struct ProjectedViews {
    /// views × dimension, row-major.
    pub points: Vec<f32>,
    pub distances_from_space: Vec<f64>,
    pub dimension: usize,
}

impl ProjectedViews {
    fn of(space: &Eigenspace, rows: &[f32]) -> ProjectedViews {
        let (points, distances_from_space): (Vec<_>, Vec<_>) =
            rows.chunks_exact(space.length()).map(|row| space.locate(row)).unzip();
        ProjectedViews { points: points.concat(), distances_from_space, dimension: space.dimension() }
    }

    /// With distances as if the eigenspace of `count` views had been fitted without each view: its leverage on the
    /// principal components is removed.
    fn without_own_leverage(space: &Eigenspace, rows: &[f32], count: usize) -> ProjectedViews {
        let mut projected = ProjectedViews::of(space, rows);
        let degrees = count.saturating_sub(1).max(1) as f64;
        let points = projected.points.chunks_exact(space.dimension());
        for (distance, point) in projected.distances_from_space.iter_mut().zip(points) {
            let parts =
                point.iter().zip(&space.eigenvalues).map(|(&z, v)| f64::from(z).powi(2) / (v * degrees));
            let leverage = 1.0 / count as f64 + parts.sum::<f64>();
            *distance /= 1.0 - leverage.min(MAX_LEVERAGE);
        }
        projected
    }
}

/// B Fig. 9: how many held-out views have their nearest eigenpoint among their own object's, for the leading one
/// coordinate, two, three …
fn rate_by_dimension(views: &LabelledPoints) -> Vec<DimensionRate> {
    let (count, dimension) = (views.object_of_view.len(), views.dimension);
    let columns: Vec<Vec<f32>> =
        (0..dimension).map(|k| views.points.iter().skip(k).step_by(dimension).copied().collect()).collect();
    let mut right = vec![0; dimension];
    let mut trials = 0;
    for view in (0..count).step_by(count.div_ceil(MAX_TRIALS)) {
        let mut squares: Vec<f32> = (0..count)
            .map(|other| if views.is_left_out_with(other, view) { f32::INFINITY } else { 0.0 })
            .collect();
        let own = views.object_of_view[view];
        let mut left = squares.iter().zip(views.object_of_view);
        if !left.any(|(square, &object)| object == own && square.is_finite()) {
            continue;
        }
        trials += 1;
        for (values, right) in columns.iter().zip(&mut right) {
            let query = values[view];
            squares.iter_mut().zip(values).for_each(|(square, v)| *square += (v - query) * (v - query));
            let least = squares
                .iter()
                .fold(f32::INFINITY, |least, &square| if square < least { square } else { least });
            let nearest = squares.iter().position(|&square| square == least);
            *right += usize::from(nearest.is_some_and(|nearest| views.object_of_view[nearest] == own));
        }
    }
    if trials == 0 {
        return Vec::new();
    }
    right.iter().enumerate().map(|(k, &right)| DimensionRate { dimension: k + 1, right, trials }).collect()
}

/// The least dimension whose rate is within a standard error of the best, and no less than `least_dimension`: few
/// objects are told apart by less, and new ones need more.
fn least_good(rates: &[DimensionRate], least_dimension: usize) -> Option<usize> {
    let share = |rate: &DimensionRate| rate.right as f64 / rate.trials as f64;
    let best = rates.iter().map(share).fold(0.0, f64::max);
    let error = (best * (1.0 - best) / rates.first()?.trials as f64).sqrt();
    let least = rates.iter().find(|rate| share(rate) >= best - error)?;
    Some(least.dimension.max(least_dimension).min(rates.len()))
}

#[cfg(test)]
mod tests {
    use super::super::ObjectParts;
    use super::super::test_pictures::{normaliser, thing, turntable, view};
    use super::*;
    use crate::imaging::{Frame, Image};

    fn trained(views: Vec<View>) -> (Objects, TrainingReport) {
        let options = ObjectOptions::default();
        train(views, &normaliser(&options), &options).unwrap()
    }

    fn refused(views: Vec<View>) -> TrainingError {
        let options = ObjectOptions::default();
        train(views, &normaliser(&options), &options).err().unwrap()
    }

    #[test]
    fn the_order_of_views_changes_nothing() {
        let views = turntable(3, 30, &ObjectOptions::default());
        let mut shuffled = views.clone();
        shuffled.reverse();
        shuffled.swap(3, 17);
        let ((a, report_a), (b, report_b)) = (trained(views), trained(shuffled));
        assert_eq!(ObjectParts::from(&a), ObjectParts::from(&b));
        assert_eq!(report_a, report_b);
    }

    #[test]
    fn the_report_tells_what_held_out_views_taught() {
        let (model, report) = trained(turntable(5, 15, &ObjectOptions::default()));
        assert_eq!((report.exemplars, report.labels, report.width_px), (120, 5, 48));
        let rates = &report.rate_by_dimension;
        assert!(rates[0].trials == 120 && rates[0].right < 120 && rates[report.dimension - 1].right >= 119);
        assert_eq!(report.dimension, model.dimension());
        let held_out = report.held_out.unwrap();
        // 0.98 of 120 at most, as nothing is accepted that is as likely to be wrong
        assert!((112..=119).contains(&held_out.known_accepted), "{held_out:?}");
        assert!(held_out.unknown == 120 && held_out.unknown_refused > 115, "{held_out:?}");
        for object in &report.objects {
            let pose = object.pose.unwrap();
            assert!(pose.trials == 24 && pose.within_5_deg >= 22, "{object:?}");
            assert!(object.gaps.is_empty() && object.threshold.is_none());
        }
        assert!((0.05..0.9).contains(&report.least_explained.unwrap()));
        assert!((0.5..1.0).contains(&report.energy_kept) && report.spectrum.len() == 120);
        let confused: usize = report.confusion.iter().map(|confusion| confusion.times).sum();
        assert_eq!(confused, held_out.known - held_out.known_right);
    }

    #[test]
    fn exemplars_that_are_cropped_badly_are_reported() {
        let options = ObjectOptions { segment: true, ..ObjectOptions::default() };
        let normaliser = Normaliser::new(&options, (96, 96));
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
        let views =
            views.map(|(id, frame)| View { id: id.into(), ..view(&normaliser, "disc", None, &frame) });
        let (_, report) = train(views.to_vec(), &normaliser, &options).unwrap();
        assert_eq!(report.touches_border, ["cut"]);
        assert_eq!(report.several_regions, ["two"]);
        assert_eq!(report.blank, ["none"]);
    }

    #[test]
    fn what_is_wrong_with_exemplars_is_told() {
        let options = ObjectOptions::default();
        let normaliser = normaliser(&options);
        let mut views = turntable(2, 10, &options);
        views.retain(|view| view.label != "thing1" || !(120.0..160.0).contains(&view.pose_deg.unwrap()));
        let glare = Frame::gray(Image::from_fn(48, 48, |x, _| if x < 20 { 255.0 } else { 10.0 }));
        let dim = Frame::gray(Image::from_fn(48, 48, |x, y| 0.1 * thing(5, 0.0).luminance.at(x, y)));
        let black = Frame::gray(Image::from_fn(48, 48, |_, _| 0.0));
        let half = Frame::gray(crate::imaging::fitted(&thing(6, 3.0).luminance, 24, 24));
        for (id, pose, frame) in
            [("glare", 1.0, &glare), ("dim", 2.0, &dim), ("black", 3.0, &black), ("half", 4.0, &half)]
        {
            views.push(View { id: id.into(), ..view(&normaliser, "odd", Some(pose), frame) });
        }
        views.push(View { id: "again".into(), ..view(&normaliser, "odd", Some(2.0), &dim) });
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
        assert_eq!(refused(other), TrainingError::OtherNormaliser { id: views[2].id.clone() });
        let bad = ObjectOptions { accept: 2.0, ..options.clone() };
        let error = train(views, &normaliser(&options), &bad).err().unwrap();
        assert!(matches!(error, TrainingError::Options { faults } if faults.len() == 1));
    }

    #[test]
    fn ten_thousand_identical_pictures_and_one_other_are_trained_or_refused_with_a_reason() {
        let options =
            ObjectOptions { dimension: Dimension::Fixed(4), ..ObjectOptions::of(AppearanceOf::Intensity) };
        let normaliser = Normaliser::new(&options, (8, 8));
        let flat = |level: f32| Frame::gray(Image::from_fn(8, 8, |_, _| level));
        let alike = |level: f32| -> Vec<View> {
            let appearance = normaliser.appearance(&flat(level)).unwrap();
            let label = |n: usize| format!("flat{}", n % 3);
            let view = |n: usize| View {
                id: n.to_string(),
                label: label(n),
                pose_deg: None,
                appearance: appearance.clone(),
                disturbed: None,
            };
            (0..10_000).map(view).collect()
        };
        let train = |views| train(views, &normaliser, &options).map(|(model, _)| model);
        assert_eq!(train(alike(120.0)).err(), Some(TrainingError::AllEqual));
        assert_eq!(train(alike(255.0)).err(), Some(TrainingError::AllEqual));
        // All black: nothing of it is an appearance.
        assert_eq!(train(alike(0.0)).err(), Some(TrainingError::TooFew { views: 0 }));
        let mut views = alike(120.0);
        let slope = Frame::gray(Image::from_fn(8, 8, |x, _| 30.0 * x as f32));
        views.push(view(&normaliser, "slope", None, &slope));
        let model = train(views).unwrap();
        let nearest = |frame: &Frame| model.recognise(frame, |_| ()).unwrap().candidates[0].label.clone();
        assert_eq!(nearest(&slope), "slope");
        assert!(nearest(&flat(120.0)).starts_with("flat"));
    }

    #[test]
    fn a_label_with_one_view_stands_beside_others() {
        let options = ObjectOptions::default();
        let mut views = turntable(3, 15, &options);
        views.push(view(&normaliser(&options), "lonely", Some(0.0), &thing(9, 0.0)));
        let (model, report) = trained(views);
        assert_eq!(report.objects[0].pose, None);
        let decision = model.recognise(&thing(9, 0.5), |_| ()).unwrap().decision.unwrap();
        assert_eq!((decision.label.as_str(), decision.pose), ("lonely", None));
    }
}
