//! The verb `evaluate`: train on a folder, recognise queries with known truth, say how often it was right; and in
//! `depth` the verb `evaluate-depth`.
//!
//! Works on the core directly, without server or store, on one thread. Rates always come with their number of
//! trials. A query whose label was not trained (a folder `unknown`, a label `null`) shows no known object. One
//! file a kind of database: what is asked of a kind differs. Bags instead of folders go through a service (`bag`).

pub mod depth;
mod figures;
mod files;
mod landmarks;
mod objects;
mod options;
mod queries;

use std::fmt;
use std::io;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

use crate::database::options::{DocumentError, Kind, Options};
use landmarkd_core::recognition;

pub use figures::{Confusion, PoseErrors, Rate, Times};
pub use files::{LabelledFile, Skipped, labelled_files};
pub use landmarks::{Decided, LandmarkEvaluation, Rejection};
pub use objects::{ObjectEvaluation, ObjectPoses, Poses};
pub(crate) use options::read_pair;

/// Arguments of `landmarkd evaluate`.
#[derive(Args, Clone, Debug)]
pub struct EvaluateArgs {
    /// What the database recognises by: landmarks, or objects (whole pictures, and the pose)
    #[arg(long, value_name = "KIND", default_value = "landmarks", value_parser = kind_of_word)]
    pub kind: Kind,
    /// Training pictures: TRAIN_DIR/<label>/*.{png,jpg,jpeg,pgm,ppm}; a name NAME__DEGREES.png gives the pose; or a bag
    #[arg(value_name = "TRAIN_DIR|BAG")]
    pub train_dir: PathBuf,
    /// Queries: <label>/* likewise (a folder `unknown`: no known object), a manifest of files and labels, or a bag
    #[arg(value_name = "QUERY_DIR|MANIFEST.json|BAG")]
    pub queries: PathBuf,
    /// An option of the database, as in PUT /v1/databases: --option interest_points=128 (may be repeated)
    #[arg(long = "option", value_name = "NAME=VALUE")]
    pub options: Vec<String>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    pub json: bool,
}

fn kind_of_word(word: &str) -> Result<Kind, &'static str> {
    Kind::parse(word).ok_or("the kinds are landmarks and objects")
}

impl EvaluateArgs {
    /// The request that the arguments make.
    ///
    /// # Errors
    /// [`EvaluateError`] naming the option that is unknown, of the wrong type, or impossible.
    pub fn request(&self) -> Result<EvaluationRequest, EvaluateError> {
        Ok(EvaluationRequest {
            train_dir: self.train_dir.clone(),
            queries: self.queries.clone(),
            options: options::options_with(self.kind, &self.options)?,
        })
    }
}

/// What is to be evaluated.
#[derive(Clone, Debug)]
pub struct EvaluationRequest {
    /// `<label>/*` to train on.
    pub train_dir: PathBuf,
    /// `<label>/*` to recognise, or a manifest file.
    pub queries: PathBuf,
    /// How to train, and which kind of database.
    pub options: Options,
}

/// Why nothing could be evaluated.
#[derive(Debug, Error)]
pub enum EvaluateError {
    /// An option without `=`.
    #[error("--option {given:?} is not NAME=VALUE")]
    NotAnOption {
        /// The text given.
        given: String,
    },
    /// An option that the kind hasn't got.
    #[error("there is no option {option:?}; the options are {known}")]
    UnknownOption {
        /// The name of the option.
        option: String,
        /// The names that there are.
        known: String,
    },
    /// An option whose value has the wrong type.
    #[error("the option {option} can't be {value}")]
    OptionType {
        /// The name of the option.
        option: String,
        /// The value given.
        value: Value,
        /// The cause.
        source: DocumentError,
    },
    /// Options that are out of range or conflict.
    #[error("the options can't be used together")]
    Options {
        /// The cause.
        source: DocumentError,
    },
    /// A file or folder can't be read.
    #[error("can't read {}", .path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The manifest is not the JSON that it must be.
    #[error("{} is no manifest: an object with lists `train` and `queries` of {{file, label}}", .path.display())]
    Manifest {
        /// The file or folder.
        path: PathBuf,
        /// The cause.
        source: serde_json::Error,
    },
    /// A folder without pictures below labels.
    #[error("{} holds no pictures in folders named by their labels", .path.display())]
    NoPictures {
        /// The file or folder.
        path: PathBuf,
    },
    /// No model of landmarks can be trained.
    #[error("no model can be trained")]
    LandmarkTraining {
        /// The cause.
        source: recognition::landmarks::TrainingError,
    },
    /// No model of objects can be trained.
    #[error("no model can be trained")]
    ObjectTraining {
        /// The cause.
        source: recognition::objects::TrainingError,
    },
}

/// How well a trained database knew the queries.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Evaluation {
    /// Of a database of landmarks.
    Landmarks(Box<LandmarkEvaluation>),
    /// Of a database of objects.
    Objects(Box<ObjectEvaluation>),
}

impl fmt::Display for Evaluation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Evaluation::Landmarks(evaluation) => evaluation.fmt(f),
            Evaluation::Objects(evaluation) => evaluation.fmt(f),
        }
    }
}

/// Trains and recognises; calls `progress` with (pictures done, all pictures).
///
/// # Errors
/// [`EvaluateError`]; a single broken picture is none, it is named and skipped.
pub fn evaluate(
    request: &EvaluationRequest,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Evaluation, EvaluateError> {
    let files = files::training_and_queries(&request.train_dir, &request.queries)?;
    match &request.options {
        Options::Landmarks(options) => {
            landmarks::evaluate(options, &files, progress).map(|it| Evaluation::Landmarks(Box::new(it)))
        }
        Options::Objects(options) => {
            objects::evaluate(options, &files, progress).map(|it| Evaluation::Objects(Box::new(it)))
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::{Command, FromArgMatches};

    use super::*;

    fn parsed(words: &[&str]) -> Result<EvaluateArgs, clap::Error> {
        let command = EvaluateArgs::augment_args(Command::new("evaluate"));
        let matches = command.try_get_matches_from([&["evaluate", "train", "queries"], words].concat())?;
        EvaluateArgs::from_arg_matches(&matches)
    }

    #[test]
    fn the_kind_is_landmarks_unless_it_is_named() {
        let kind = |words: &[&str]| parsed(words).unwrap().request().unwrap().options.kind();
        assert_eq!(kind(&[]), Kind::Landmarks);
        assert_eq!(kind(&["--kind", "objects", "--option", "dimension=12"]), Kind::Objects);
        let refused = parsed(&["--kind", "faces"]).unwrap_err().to_string();
        assert!(refused.contains("landmarks and objects"), "{refused}");
    }
}
