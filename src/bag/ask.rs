//! The verb `ask`: a service answers about the pictures of a bag; the answers are held against the bag's poses and labels,
//! and written as a bag.

use std::fmt;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use landmarkd_core::geometry::{DMat3, DVec3, MapPose};
use landmarkd_core::statistics::nearest_rank;
use reqwest::Method;
use reqwest::multipart::{Form, Part};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answers::AnswerBag;
use super::contents::{BagArgs, BagPicture, Contents};
use super::labels::{LabelArgs, Labels};
use super::teach::{landmarks_only, name_of};
use super::{BagError, bar_of, read_ahead, read_once};
use crate::client::{ClientError, Server};
use crate::database::survey::CameraDocument;
use crate::evaluate::Rate;

/// Arguments of `landmarkd ask`, but for those of the service.
#[derive(Args, Clone, Debug)]
pub struct AskArgs {
    /// A bag: an MCAP file of ROS 2, or a folder of such
    #[arg(value_name = "BAG")]
    pub recording: PathBuf,
    /// The database that is asked
    #[arg(long, value_name = "NAME")]
    pub database: String,
    /// Ask about every Nth picture
    #[arg(long, value_name = "N", default_value = "1")]
    pub every: std::num::NonZeroUsize,
    /// Write the answers as a bag: frames, outlines, votes and poses for Foxglove, Rerun or rosbags
    #[arg(long, value_name = "FILE.mcap")]
    pub out: Option<PathBuf>,
    /// Also write the frames with the evidence drawn on them, for viewers without outlines; asks twice
    #[arg(long, requires = "out")]
    pub draw: bool,
    /// Where its pictures and poses are.
    #[command(flatten)]
    pub bag: BagArgs,
    /// How its pictures were labelled.
    #[command(flatten)]
    pub labels: LabelArgs,
}

/// An answer, as far as it is used here.
#[derive(Clone, Debug, Deserialize)]
pub struct Answer {
    pub decision: Option<Decision>,
    #[serde(default)]
    pub votes: Vec<Vote>,
    #[serde(default)]
    pub pose: Option<AnsweredPose>,
}

/// The label that was decided for.
#[derive(Clone, Debug, Deserialize)]
pub struct Decision {
    pub label: String,
    pub confidence: Option<f64>,
}

/// What speaks for a label.
#[derive(Clone, Debug, Deserialize)]
pub struct Vote {
    pub label: String,
    pub share: f64,
    pub placement: Option<Placement>,
}

/// Where a training picture lies in the frame.
#[derive(Clone, Debug, Deserialize)]
pub struct Placement {
    pub outline_px: [[f64; 2]; 4],
    pub exemplar: Option<String>,
}

/// Where the camera's body is.
#[derive(Clone, Debug, Deserialize)]
pub struct AnsweredPose {
    pub map: String,
    pub x_m: f64,
    pub y_m: f64,
    pub yaw_deg: f64,
    /// Row-major over x, y, yaw; m and rad.
    pub covariance: [f64; 9],
}

impl AnsweredPose {
    /// The same as a pose on the map's plane.
    pub fn on_the_plane(&self) -> MapPose {
        MapPose { x_m: self.x_m, y_m: self.y_m, yaw_deg: self.yaw_deg, ..MapPose::default() }
    }
}

/// How well the answers agree with the bag.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AskSummary {
    /// Pictures that were asked about.
    pub asked: usize,
    /// Those for which something was decided.
    pub answered: usize,
    /// Of the answered ones whose label the bag says: named so.
    pub right: Option<Rate>,
    /// The same, or named as a cell that touches it.
    pub near: Option<Rate>,
    /// `None`: no answer has a pose, or the bag none.
    pub position: Option<PositionErrors>,
    /// Pictures that the service, or this program, could not read.
    pub unreadable: usize,
    /// Why the first of them was not.
    pub first_reason: Option<String>,
}

/// How far answered poses are from the bag's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PositionErrors {
    /// Pictures whose pose the bag says, and those of them that were answered with one.
    pub answered: Rate,
    /// By nearest rank.
    pub median_m: f64,
    /// 95 of 100 are no larger.
    pub p95_m: f64,
    /// By nearest rank.
    pub yaw_median_deg: f64,
    /// 95 of 100 are no larger.
    pub yaw_p95_deg: f64,
    /// Mean squared error over the covariance: 3 if it is honest, more if it is too small.
    pub nees: Option<f64>,
}

/// One picture against its truth.
#[derive(Default)]
struct Judged {
    answered: bool,
    right: Option<bool>,
    near: Option<bool>,
    has_true_pose: bool,
    /// Metres, degrees, and squared over the covariance if that is one.
    error: Option<(f64, f64, Option<f64>)>,
}

/// Asks, prints how it went, and writes the answers if a file is named.
///
/// # Errors
/// [`BagError`]; pictures that can't be read are counted.
pub async fn ask(server: &Server, args: &AskArgs, out: &mut dyn Write) -> Result<AskSummary, BagError> {
    let database = name_of(&args.database)?;
    let path = ["databases", database.as_str()];
    let there: Value = server.json(server.call(Method::GET, &path, &[])).await?;
    landmarks_only(&database, &there)?;
    let contents = Arc::new(read_once(&args.recording, &args.bag, out)?);
    let labels = Labels::of(&args.labels, &database, contents.has_poses()).ok();
    let mut answers =
        args.out.as_deref().map(|path| AnswerBag::create(path, contents.map.to_string())).transpose()?;

    let every = args.every.get();
    let (mut pictures, reading) = read_ahead(&contents, 0_usize, move |count, picture, read_bytes| {
        let picture = picture.filter(|_| *count % every == 0);
        *count += 1;
        Vec::from_iter(picture.map(|picture| (picture, read_bytes)))
    });
    let bar = bar_of(contents.bytes());
    let mut judged = Vec::new();
    let mut summary = AskSummary::default();
    while let Some((picture, read_bytes)) = pictures.recv().await {
        bar.set_position(read_bytes);
        match asked_about(server, args, &contents, &picture).await {
            Ok((file, answer, drawn)) => {
                judged.push(Judged::of(&picture, &answer, labels.as_ref(), &contents));
                if let Some(answers) = &mut answers {
                    answers.add(&picture, file, &answer, drawn.as_deref())?;
                }
            }
            Err(NotAsked::Unreadable(reason)) => {
                summary.unreadable += 1;
                summary.first_reason.get_or_insert(reason);
            }
            Err(NotAsked::Failed(error)) => return Err(error.into()),
        }
    }
    bar.finish_and_clear();
    reading.await.expect("reading doesn't panic")?;
    if judged.is_empty() {
        return Err(BagError::NoPictures {
            topic: contents.image_topic.clone(),
            reason: summary.first_reason.unwrap_or_else(|| "there is none".to_owned()),
        });
    }
    if let (Some(answers), Some(path)) = (answers, &args.out) {
        answers.finish()?;
        writeln!(out, "answers: {}", path.display())?;
    }
    Ok(AskSummary { unreadable: summary.unreadable, first_reason: summary.first_reason, ..summed(&judged) })
}

/// Why a picture has no answer.
enum NotAsked {
    Unreadable(String),
    Failed(ClientError),
}

/// The picture's bytes, the answer, and the picture with the evidence drawn on it where that is wanted.
async fn asked_about<'a>(
    server: &Server,
    args: &AskArgs,
    contents: &Contents,
    picture: &'a BagPicture,
) -> Result<(&'a [u8], Answer, Option<Vec<u8>>), NotAsked> {
    let file = picture.file.as_deref().map_err(|reason| NotAsked::Unreadable(reason.clone()))?;
    let refused = |error| match error {
        // what the service says of this very picture
        ClientError::Refused { status: 400 | 413 | 415 | 422, detail, .. } => NotAsked::Unreadable(detail),
        error => NotAsked::Failed(error),
    };
    let call = || {
        let mut form = Form::new();
        if let Some(camera) = &contents.camera {
            form = form.text("camera", json!(CameraDocument::from(camera)).to_string());
        }
        let form = form.part("image", Part::bytes(file.to_vec()).file_name("frame"));
        let path = ["databases", args.database.as_str(), "recognitions"];
        server.call(Method::POST, &path, &[]).multipart(form)
    };
    let answer = server.json(call()).await.map_err(refused)?;
    let drawn = match args.draw {
        true => Some(server.bytes(call().header("Accept", "image/png")).await.map_err(refused)?),
        false => None,
    };
    Ok((file, answer, drawn))
}

impl Judged {
    fn of(picture: &BagPicture, answer: &Answer, labels: Option<&Labels>, contents: &Contents) -> Judged {
        let shown = labels.and_then(|labels| Some((labels, labels.label(picture.pose.as_ref())?)));
        let decided = answer.decision.as_ref().map(|decision| decision.label.as_str());
        let agrees = |agree: &dyn Fn(&Labels, &str, &str) -> bool| match (&shown, decided) {
            (Some((labels, shown)), Some(decided)) => Some(agree(labels, shown, decided)),
            _ => None,
        };
        let answered_pose = answer.pose.as_ref().filter(|answered| answered.map == contents.map.as_str());
        Judged {
            answered: decided.is_some(),
            right: agrees(&|_, shown, decided| shown == decided),
            near: agrees(&|labels, shown, decided| labels.are_near(shown, decided)),
            has_true_pose: picture.pose.is_some(),
            error: answered_pose
                .zip(picture.pose.as_ref())
                .map(|(answered, true_pose)| error_of(answered, true_pose)),
        }
    }
}

/// Metres, degrees, and the squared error over the covariance.
fn error_of(answered: &AnsweredPose, true_pose: &MapPose) -> (f64, f64, Option<f64>) {
    let (dx_m, dy_m) = (answered.x_m - true_pose.x_m, answered.y_m - true_pose.y_m);
    let turn_deg = (answered.yaw_deg - true_pose.yaw_deg + 180.0).rem_euclid(360.0) - 180.0;
    let covariance = DMat3::from_cols_array(&answered.covariance);
    let error = DVec3::new(dx_m, dy_m, turn_deg.to_radians());
    let squared = (covariance.determinant() > 0.0).then(|| error.dot(covariance.inverse() * error));
    (dx_m.hypot(dy_m), turn_deg.abs(), squared)
}

fn summed(judged: &[Judged]) -> AskSummary {
    let rate = |agrees: fn(&Judged) -> Option<bool>| {
        let known: Vec<bool> = judged.iter().filter_map(agrees).collect();
        (!known.is_empty()).then(|| Rate::among(known))
    };
    AskSummary {
        asked: judged.len(),
        answered: judged.iter().filter(|one| one.answered).count(),
        right: rate(|one| one.right),
        near: rate(|one| one.near),
        position: position_errors(judged),
        ..AskSummary::default()
    }
}

fn position_errors(judged: &[Judged]) -> Option<PositionErrors> {
    let sorted = |values: Vec<f64>| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values
    };
    let errors: Vec<_> = judged.iter().filter_map(|one| one.error).collect();
    let (metres, degrees) = (
        sorted(errors.iter().map(|error| error.0).collect()),
        sorted(errors.iter().map(|error| error.1).collect()),
    );
    let squared: Option<Vec<f64>> = errors.iter().map(|error| error.2).collect();
    Some(PositionErrors {
        answered: Rate::of(errors.len(), judged.iter().filter(|one| one.has_true_pose).count()),
        median_m: nearest_rank(&metres, 0.5)?,
        p95_m: nearest_rank(&metres, 0.95)?,
        yaw_median_deg: nearest_rank(&degrees, 0.5)?,
        yaw_p95_deg: nearest_rank(&degrees, 0.95)?,
        nees: squared.map(|squared| squared.iter().sum::<f64>() / squared.len() as f64),
    })
}

impl fmt::Display for AskSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut row = |name: &str, value: &dyn fmt::Display| writeln!(f, "{name:<14}{value}");
        row("asked", &self.asked)?;
        row("answered", &Rate::of(self.answered, self.asked))?;
        match (&self.right, &self.near) {
            (Some(right), Some(near)) => {
                row("label right", right)?;
                row("or beside it", near)?;
            }
            _ => row("label right", &"nobody knows: the bag has no poses, and --label isn't given")?,
        }
        match &self.position {
            Some(PositionErrors { answered, median_m, p95_m, yaw_median_deg, yaw_p95_deg, nees }) => {
                row("with a pose", answered)?;
                row("position", &format_args!("median {median_m:.2} m, p95 {p95_m:.2} m"))?;
                row("yaw", &format_args!("median {yaw_median_deg:.1}°, p95 {yaw_p95_deg:.1}°"))?;
                if let Some(nees) = nees {
                    row("NEES", &format_args!("{nees:.2} in the mean; an honest covariance has 3"))?;
                }
            }
            None => row("with a pose", &"none, or the bag has none to compare with")?,
        }
        match &self.first_reason {
            Some(reason) => row("unreadable", &format_args!("{}: {reason}", self.unreadable)),
            None => Ok(()),
        }
    }
}
