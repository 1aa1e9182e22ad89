//! The model of a version: what a training made, and what it counted.

use serde::{Deserialize, Serialize};

use super::options::{Kind, Options};
use landmarkd_core::recognition::landmarks::Landmarks;
use landmarkd_core::recognition::objects::Objects;

/// Grows with every change that makes training give other results for the same inputs.
pub const ALGORITHM_REVISION: i64 = 2;

/// How much a version was trained from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Training images.
    pub exemplars: u64,
    /// Distinct labels among them.
    pub labels: u64,
    /// Interest points of all of them; 0 for objects.
    pub interest_points: u64,
}

/// What a version recognises with.
pub enum Model {
    /// The model of a database of kind `landmarks`.
    Landmarks(Box<Landmarks>),
    /// The model of a database of kind `objects`.
    Objects(Box<Objects>),
}

impl Model {
    /// The kind of its database.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Landmarks(_) => Kind::Landmarks,
            Self::Objects(_) => Kind::Objects,
        }
    }

    /// The options it was trained with.
    pub fn options(&self) -> Options {
        match self {
            Self::Landmarks(landmarks) => Options::Landmarks(landmarks.options().clone()),
            Self::Objects(objects) => Options::Objects(objects.options().clone()),
        }
    }

    /// Memory that it holds, in bytes.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Landmarks(landmarks) => landmarks.bytes() as u64,
            Self::Objects(objects) => objects.bytes() as u64,
        }
    }
}
