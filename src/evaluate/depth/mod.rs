//! The verb `evaluate-depth`: measure a focal pair, say what the map is like, and how far it is from the truth if that
//! is known. Works on the core directly, without server or store, on one thread.

mod array;
mod errors;
mod rig;

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use thiserror::Error;

use super::figures::{ms_since, timed};
use crate::http::problem::FieldError;
use landmarkd_core::depth::{
    Calibration, DepthMap, DepthOptions, EstimateError, Estimator, EstimatorError, Flag, FocalPair, Optics,
    PairError, Stage,
};
use landmarkd_core::imaging::encode::png_distances;
use landmarkd_core::imaging::false_colour::png_turbo;
use landmarkd_core::imaging::npy::npy_f32;
use landmarkd_core::imaging::ply::ply_points;
use landmarkd_core::imaging::{DecodeError, DecodeLimits, Frame, decode, read_header};

pub use array::Plane;
pub use errors::{DepthErrors, DepthPair};

/// Arguments of `landmarkd evaluate-depth`.
#[derive(Args, Clone, Debug)]
pub struct EvaluateDepthArgs {
    /// The near-focused picture; of two apertures, that of the wider one
    #[arg(value_name = "NEAR")]
    pub near: PathBuf,
    /// The far-focused picture; of two apertures, that of the narrower one
    #[arg(value_name = "FAR")]
    pub far: PathBuf,
    /// The optics as JSON, as `optics` in POST /v1/depth-maps
    #[arg(long, value_name = "FILE")]
    pub optics: PathBuf,
    /// The true depths: an array (.npy, NaN = unknown) or a gray picture (0 = unknown)
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// What a unit of the truth is in mm [default: 1 for an array, 0.1 for a picture]
    #[arg(long, value_name = "MM", requires = "truth")]
    pub truth_scale_mm: Option<f64>,
    /// Where the truth counts: a picture, where it isn't black
    #[arg(long, value_name = "FILE", requires = "truth")]
    pub truth_mask: Option<PathBuf>,
    /// Fit the truth's scale and offset first: for a truth that isn't metric
    #[arg(long, requires = "truth")]
    pub fit_truth: bool,
    /// An option, as in POST /v1/depth-maps: --option method=stm (may be repeated)
    #[arg(long = "option", value_name = "NAME=VALUE")]
    pub options: Vec<String>,
    /// Measure this often; the shortest times are printed
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,
    /// Write depth.png, preview.png, depth.npy and cloud.ply to this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    pub json: bool,
}

/// Why no depth could be evaluated.
#[derive(Debug, Error)]
pub enum DepthEvaluationError {
    /// A file can't be read.
    #[error("can't read {}", .path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file can't be written.
    #[error("can't write {}", .path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file is no picture, or too large.
    #[error("{} can't be taken as a picture", .path.display())]
    Picture {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: DecodeError,
    },
    /// The optics are no JSON object.
    #[error("the optics can't be read")]
    OpticsFile {
        /// The cause.
        source: serde_json::Error,
    },
    /// The optics miss members or are impossible.
    #[error("the optics can't be: {}", listed(.faults))]
    Optics {
        /// Each member at fault.
        faults: Vec<FieldError>,
    },
    /// An option without `=`.
    #[error("--option {given:?} is not NAME=VALUE")]
    NotAnOption {
        /// The text given.
        given: String,
    },
    /// Options that are unknown or impossible.
    #[error("the options can't be: {}", listed(.faults))]
    Options {
        /// Each member at fault.
        faults: Vec<FieldError>,
    },
    /// The pictures don't make a pair.
    #[error("the pictures are no focal pair")]
    Pair {
        /// The cause.
        source: PairError,
    },
    /// The options need what there isn't, such as a sweep.
    #[error("the options can't be used")]
    Estimator {
        /// The cause.
        source: EstimatorError,
    },
    /// The pair can't be measured.
    #[error("the pair can't be measured")]
    Estimate {
        /// The cause.
        source: EstimateError,
    },
    /// The truth is no array that can be read.
    #[error("{} is no array of two axes of 32- or 64-bit floating-point numbers in row order", .path.display())]
    Array {
        /// The file or folder.
        path: PathBuf,
    },
    /// The truth or its mask has another size than the pictures.
    #[error("{} is {width_px}×{height_px}, not of the pictures' size", .path.display())]
    OtherSize {
        /// The file or folder.
        path: PathBuf,
        /// Its width.
        width_px: usize,
        /// Its height.
        height_px: usize,
    },
}

fn listed(faults: &[FieldError]) -> String {
    let faults = faults.iter().map(|FieldError { pointer, detail }| format!("{pointer} {detail}"));
    faults.collect::<Vec<_>>().join("; ")
}

/// The shortest times of several runs, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DepthTimes {
    /// Making filters ready, once for a rig.
    pub design: f64,
    /// Both pictures.
    pub decode: f64,
    /// Finding the shift between the pictures.
    pub register: f64,
    /// Matching their brightness.
    pub r#match: f64,
    /// Estimating the depths.
    pub estimate: f64,
    /// Judging which depths hold.
    pub judge: f64,
    /// All that follows decoding.
    pub total: f64,
}

/// The scale and offset that bring the truth to the measured depths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TruthFit {
    /// Measured mm a unit of the truth.
    pub scale_mm: f64,
    /// Measured mm at 0 of the truth.
    pub offset_mm: f64,
}

/// What a depth map is like, and how far it is from the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DepthEvaluation {
    /// Width of the pictures.
    pub width_px: usize,
    /// Height of the pictures.
    pub height_px: usize,
    /// The distance that the near picture is focused at.
    pub near_focus_mm: f64,
    /// The distance that the far picture is focused at.
    pub far_focus_mm: f64,
    /// The largest blur within the working range.
    pub largest_blur_px: f64,
    /// Part of the pixels that have a depth.
    pub coverage: f64,
    /// Least, middle and largest depth; none if no pixel has one.
    pub depth_mm: Option<[f64; 3]>,
    /// Noise of a picture in gray levels of 255; none if the method doesn't estimate it.
    pub noise_sigma: Option<f64>,
    /// How far the far picture was moved back, x and y.
    pub shift_px: [f64; 2],
    /// What its brightness was multiplied by.
    pub gain: f64,
    /// Pixels without a depth, by the reason.
    pub flags: BTreeMap<&'static str, u64>,
    /// Words of the HTTP contract.
    pub warnings: Vec<&'static str>,
    /// The shortest of all runs.
    pub times_ms: DepthTimes,
    /// With `--fit-truth`: what was fitted before errors were taken.
    pub truth_fit: Option<TruthFit>,
    /// None without a truth, or if none of its pixels is measured.
    pub errors: Option<DepthErrors>,
}

/// Measures a pair as the arguments say.
///
/// # Errors
/// [`DepthEvaluationError`].
pub fn evaluate_depth(args: &EvaluateDepthArgs) -> Result<DepthEvaluation, DepthEvaluationError> {
    let optics = rig::optics_of(&read(&args.optics)?)?;
    let options = rig::options_with(&args.options)?;
    let files = [(args.near.as_path(), read(&args.near)?), (args.far.as_path(), read(&args.far)?)];
    let mut run = Run::of(&files, optics, &options)?;
    for _ in 1..args.repeat {
        let again = Run::of(&files, optics, &options)?;
        run = Run { times: run.times.shorter(&again.times), ..again };
    }
    let Run { times, map, pair } = run;

    let truth = args.truth.as_ref().map(|path| truth_of(path, args, &map)).transpose()?;
    let (truth_fit, errors) = match truth {
        Some(truth) => compared(&map, &truth, args.fit_truth, optics.range_mm()),
        None => (None, None),
    };
    if let Some(folder) = &args.out {
        write_files(folder, &map, &pair)?;
    }
    let summary = &map.summary;
    Ok(DepthEvaluation {
        width_px: map.width(),
        height_px: map.height(),
        near_focus_mm: summary.near_focus_mm,
        far_focus_mm: summary.far_focus_mm,
        largest_blur_px: optics.largest_blur_px(),
        coverage: summary.coverage,
        depth_mm: summary.depth.map(|depth| [depth.min, depth.median, depth.max]),
        noise_sigma: summary.noise_sigma,
        shift_px: summary.shift_px,
        gain: summary.gain,
        flags: Flag::ALL.iter().map(|flag| flag.word()).zip(summary.flag_counts).collect(),
        warnings: summary.warnings.iter().map(|warning| warning.word()).collect(),
        times_ms: times,
        truth_fit,
        errors,
    })
}

/// A pair decoded and measured once.
struct Run {
    times: DepthTimes,
    map: DepthMap,
    pair: FocalPair,
}

impl Run {
    /// Of the near and the far file: paths and bytes.
    fn of(
        [near, far]: &[(&Path, Vec<u8>); 2],
        optics: Optics,
        options: &DepthOptions,
    ) -> Result<Run, DepthEvaluationError> {
        let mut times = DepthTimes::default();
        let estimator = timed(&mut times.design, || Estimator::new(&Calibration::of(optics), options))
            .map_err(|source| DepthEvaluationError::Estimator { source })?;
        let [first, second] = match optics.picture_names() {
            ["narrow", _] => [far, near],
            _ => [near, far],
        };
        let pair = timed(&mut times.decode, || pair_of(first, second))?;
        let (started, mut before) = (Instant::now(), 0.0);
        let mut finished = |stage| {
            let (now, time) = (ms_since(started), times.of_stage(stage));
            *time = now - std::mem::replace(&mut before, now);
        };
        let map = estimator
            .estimate(&pair, &mut finished)
            .map_err(|source| DepthEvaluationError::Estimate { source })?;
        times.total = ms_since(started);
        Ok(Run { times, map, pair })
    }
}

impl DepthTimes {
    fn of_stage(&mut self, stage: Stage) -> &mut f64 {
        match stage {
            Stage::Register => &mut self.register,
            Stage::Match => &mut self.r#match,
            Stage::Estimate => &mut self.estimate,
            Stage::Map => &mut self.judge,
        }
    }

    /// Of each stage the shorter time.
    fn shorter(&self, other: &DepthTimes) -> DepthTimes {
        DepthTimes {
            design: self.design.min(other.design),
            decode: self.decode.min(other.decode),
            register: self.register.min(other.register),
            r#match: self.r#match.min(other.r#match),
            estimate: self.estimate.min(other.estimate),
            judge: self.judge.min(other.judge),
            total: self.total.min(other.total),
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>, DepthEvaluationError> {
    fs::read(path).map_err(|source| DepthEvaluationError::Read { path: path.to_path_buf(), source })
}

/// A picture, and its bits a sample.
fn picture(path: &Path, bytes: &[u8]) -> Result<(Frame, u8), DepthEvaluationError> {
    let limits = DecodeLimits::default();
    let header = read_header(bytes, &limits);
    header
        .and_then(|header| Ok((decode(bytes, &limits)?, header.bits)))
        .map_err(|source| DepthEvaluationError::Picture { path: path.to_path_buf(), source })
}

fn pair_of(near: &(&Path, Vec<u8>), far: &(&Path, Vec<u8>)) -> Result<FocalPair, DepthEvaluationError> {
    let (near_frame, near_bits) = picture(near.0, &near.1)?;
    let (far_frame, far_bits) = picture(far.0, &far.1)?;
    FocalPair::new(near_frame, far_frame, near_bits.min(far_bits))
        .map_err(|source| DepthEvaluationError::Pair { source })
}

/// The true depth of every pixel in mm, or in the truth's own unit times its scale; NaN where it isn't known.
fn truth_of(path: &Path, args: &EvaluateDepthArgs, map: &DepthMap) -> Result<Vec<f64>, DepthEvaluationError> {
    let fits = |path: &Path, width_px: usize, height_px: usize| {
        let other = || DepthEvaluationError::OtherSize { path: path.to_path_buf(), width_px, height_px };
        ((width_px, height_px) == (map.width(), map.height())).then_some(()).ok_or_else(other)
    };
    let bytes = read(path)?;
    let mut truth = if path.extension().is_some_and(|extension| extension == "npy") {
        let plane =
            Plane::of_npy(&bytes).ok_or_else(|| DepthEvaluationError::Array { path: path.to_path_buf() })?;
        fits(path, plane.width, plane.height)?;
        let scale_mm = args.truth_scale_mm.unwrap_or(1.0);
        plane.values.into_iter().map(|value| value * scale_mm).collect()
    } else {
        let (frame, bits) = picture(path, &bytes)?;
        fits(path, frame.width(), frame.height())?;
        // Grey levels are 0..=255 whatever the bits.
        let unit = if bits == 16 { 257.0 } else { 1.0 } * args.truth_scale_mm.unwrap_or(0.1);
        let depth = |&level: &f32| if level > 0.0 { f64::from(level) * unit } else { f64::NAN };
        frame.luminance.pixels().iter().map(depth).collect::<Vec<f64>>()
    };
    if let Some(path) = &args.truth_mask {
        let (mask, _) = picture(path, &read(path)?)?;
        fits(path, mask.width(), mask.height())?;
        for (depth, &level) in truth.iter_mut().zip(mask.luminance.pixels()) {
            if level == 0.0 {
                *depth = f64::NAN;
            }
        }
    }
    Ok(truth)
}

/// The errors of a map, after the truth's scale and offset were fitted if `fit`.
fn compared(
    map: &DepthMap,
    truth: &[f64],
    fit: bool,
    range_mm: f64,
) -> (Option<TruthFit>, Option<DepthErrors>) {
    let measured = map.depth_mm().iter().zip(map.sigma_mm()).zip(truth);
    let mut pixels: Vec<DepthPair> = measured
        .filter(|(_, truth)| truth.is_finite())
        .map(|((&measured, &sigma), &true_mm)| DepthPair {
            measured_mm: f64::from(measured),
            true_mm,
            sigma_mm: f64::from(sigma),
        })
        .collect();
    let mut truth_fit = None;
    if fit {
        let known = pixels.iter().filter(|pixel| !pixel.measured_mm.is_nan());
        let (x, y): (Vec<f64>, Vec<f64>) = known.map(|pixel| (pixel.true_mm, pixel.measured_mm)).unzip();
        truth_fit = errors::line(&x, &y).map(|[scale_mm, offset_mm]| TruthFit { scale_mm, offset_mm });
        if let Some(TruthFit { scale_mm, offset_mm }) = truth_fit {
            pixels.iter_mut().for_each(|pixel| pixel.true_mm = scale_mm * pixel.true_mm + offset_mm);
        }
    }
    (truth_fit, DepthErrors::of(&pixels, range_mm))
}

fn write_files(folder: &Path, map: &DepthMap, pair: &FocalPair) -> Result<(), DepthEvaluationError> {
    let (width, height) = (map.width(), map.height());
    let levels = pair.near().pixels();
    let files = [
        ("depth.png", png_distances(width, height, map.depth_mm()).0),
        ("preview.png", png_turbo(width, height, map.depth_mm())),
        ("depth.npy", npy_f32(&[height, width], map.depth_mm().iter().copied())),
        ("cloud.ply", ply_points(map.points_mm().map(|(at, point_mm)| (point_mm, levels[at])))),
    ];
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        move |source| DepthEvaluationError::Write { path, source }
    };
    fs::create_dir_all(folder).map_err(failed(folder))?;
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::write(&path, bytes).map_err(failed(&path))?;
    }
    Ok(())
}

/// A line of the table: its name in 23 columns, and what there is to print.
fn row(f: &mut fmt::Formatter<'_>, name: &str, value: fmt::Arguments<'_>) -> fmt::Result {
    writeln!(f, "{name:<23}{value}")
}

impl fmt::Display for DepthEvaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (near_mm, far_mm) = (self.near_focus_mm, self.far_focus_mm);
        let range_mm = far_mm - near_mm;
        let focus = format_args!("{near_mm:.1} and {far_mm:.1} mm, a range of {range_mm:.1} mm");
        row(f, "pictures", format_args!("{}×{} px", self.width_px, self.height_px))?;
        row(f, "focused at", focus)?;
        row(f, "largest blur", format_args!("{:.2} px", self.largest_blur_px))?;
        row(f, "coverage", format_args!("{:.1} %", 100.0 * self.coverage))?;
        if let Some([least, middle, largest]) = self.depth_mm {
            row(f, "depth", format_args!("{least:.1} to {largest:.1} mm, median {middle:.1} mm"))?;
        }
        if let Some(noise) = self.noise_sigma {
            row(f, "noise", format_args!("{noise:.2} grey levels"))?;
        }
        let ([x, y], gain) = (self.shift_px, self.gain);
        row(f, "far picture", format_args!("moved back by ({x:.3}, {y:.3}) px, multiplied by {gain:.4}"))?;
        let words = |words: Vec<String>| if words.is_empty() { "none".to_owned() } else { words.join(", ") };
        let flags = self.flags.iter().filter(|(_, count)| **count > 0);
        let flags = words(flags.map(|(flag, count)| format!("{flag} {count}")).collect());
        row(f, "flagged pixels", format_args!("{flags}"))?;
        let warnings = words(self.warnings.iter().map(|warning| (*warning).to_owned()).collect());
        row(f, "warnings", format_args!("{warnings}"))?;
        let DepthTimes { design, decode, register, r#match, estimate, judge, total } = self.times_ms;
        let once = format_args!("{total:.1} after {decode:.1} of decoding and {design:.1} of design, once");
        row(f, "ms", once)?;
        let stages = format_args!(
            "register {register:.1}, match {match:.1}, estimate {estimate:.1}, judge {judge:.1}"
        );
        row(f, "  of these", stages)?;
        if let Some(TruthFit { scale_mm, offset_mm }) = self.truth_fit {
            row(f, "truth fitted", format_args!("{scale_mm:.4} mm a unit, {offset_mm:.2} mm at 0"))?;
        }
        self.errors.as_ref().map_or(Ok(()), |errors| errors.fmt(f))
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;
    use landmarkd_core::depth::scene::{Camera, Relief, Rendered, Scene, Texture};
    use landmarkd_core::imaging::encode::{png_gray8, png_gray16};

    const OPTICS: &str = r#"{"focal_length_mm": 35, "f_number": 8, "near_focus_mm": 500, "plane_separation_mm": 0.4,
        "pixel_pitch_um": 10, "telecentric": true}"#;

    /// A folder with a pair and its optics.
    fn folder_of(relief: Relief) -> (tempfile::TempDir, Rendered) {
        let folder = tempfile::tempdir().unwrap();
        let optics = rig::optics_of(OPTICS.as_bytes()).unwrap();
        let camera = Camera { width: 112, height: 80, ..Camera::new(optics) };
        let rendered = camera.photograph(&Scene::new(relief, Texture::Gravel, 3));
        let [near, far] = rendered.pngs();
        for (name, bytes) in [("near.png", &near[..]), ("far.png", &far), ("optics.json", OPTICS.as_bytes())]
        {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        (folder, rendered)
    }

    fn evaluated(folder: &Path, words: &[&str]) -> Result<DepthEvaluation, DepthEvaluationError> {
        let at = |name: &str| folder.join(name).display().to_string();
        let given = [
            "evaluate-depth".to_owned(),
            at("near.png"),
            at("far.png"),
            "--optics".into(),
            at("optics.json"),
        ];
        // A word that names a file is one of the folder's.
        let words = words.iter().map(|word| if word.contains('.') { at(word) } else { (*word).to_owned() });
        let command = EvaluateDepthArgs::augment_args(Command::new("evaluate-depth"));
        let matches = command.try_get_matches_from(given.into_iter().chain(words)).unwrap();
        evaluate_depth(&EvaluateDepthArgs::from_arg_matches(&matches).unwrap())
    }

    #[test]
    fn a_map_is_held_against_an_array_of_true_depths_and_its_files_are_written() {
        let (folder, rendered) = folder_of(Relief::Slant);
        let truth = rendered.depth_mm.iter().map(|&depth| depth as f32);
        fs::write(folder.path().join("truth.npy"), npy_f32(&[80, 112], truth)).unwrap();
        let words = ["--truth", "truth.npy", "--out", "maps.d", "--repeat", "2"];
        let evaluation = evaluated(folder.path(), &words).unwrap();
        let errors = evaluation.errors.unwrap();
        assert!(errors.rms_percent < 2.0 && errors.spearman.unwrap() > 0.99, "{evaluation}");
        assert!(errors.measured.rate > 0.7 && evaluation.coverage == errors.measured.rate, "{evaluation}");
        assert!(
            evaluation.times_ms.estimate > 0.0 && evaluation.times_ms.total >= evaluation.times_ms.estimate
        );
        assert!(evaluation.to_string().contains("RMS error"), "{evaluation}");
        for (name, magic) in [("depth.png", "PNG"), ("preview.png", "PNG"), ("cloud.ply", "ply")] {
            let bytes = fs::read(folder.path().join("maps.d").join(name)).unwrap();
            assert!(bytes[..4].windows(3).any(|part| part == magic.as_bytes()), "{name}");
        }
        let kept = Plane::of_npy(&fs::read(folder.path().join("maps.d/depth.npy")).unwrap()).unwrap();
        let known = kept.values.iter().filter(|depth| depth.is_finite()).count();
        assert_eq!(known, errors.measured.hits);
    }

    #[test]
    fn a_truth_in_a_unit_of_its_own_is_fitted_where_the_mask_is_white() {
        let (folder, rendered) = folder_of(Relief::Slant);
        // Nearer is larger, and the lower half is nonsense.
        let half = 40 * 112;
        let own: Vec<u16> = rendered.depth_mm.iter().map(|depth| (60_000.0 - 50.0 * depth) as u16).collect();
        let own = own
            .into_iter()
            .enumerate()
            .map(|(at, unit)| if at < half { unit } else { 7 })
            .collect::<Vec<_>>();
        let mask: Vec<u8> = (0..80 * 112).map(|at| if at < half { 255 } else { 0 }).collect();
        fs::write(folder.path().join("truth.png"), png_gray16(112, 80, &own)).unwrap();
        fs::write(folder.path().join("mask.png"), png_gray8(112, 80, &mask)).unwrap();
        let words =
            ["--truth", "truth.png", "--truth-scale-mm", "1", "--truth-mask", "mask.png", "--fit-truth"];
        let evaluation = evaluated(folder.path(), &words).unwrap();
        let (fit, errors) = (evaluation.truth_fit.unwrap(), evaluation.errors.unwrap());
        assert!((fit.scale_mm + 1.0 / 50.0).abs() < 0.001 && errors.rms_percent < 2.0, "{evaluation}");
        assert_eq!(errors.measured.trials, half);
    }

    #[test]
    fn what_cannot_be_measured_says_why() {
        let (folder, _) = folder_of(Relief::Slant);
        let refused = |words: &[&str]| evaluated(folder.path(), words).unwrap_err().to_string();
        assert!(refused(&["--option", "method=laplacian"]).contains("options"));
        assert!(refused(&["--truth", "none.npy"]).contains("none.npy"));
        fs::write(folder.path().join("small.npy"), npy_f32(&[2, 2], [500.0; 4])).unwrap();
        assert!(refused(&["--truth", "small.npy"]).contains("2×2"));
        fs::copy(folder.path().join("near.png"), folder.path().join("far.png")).unwrap();
        assert!(refused(&[]).contains("no focal pair"));
    }
}
