//! Object options as they are kept.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::words;
use landmarkd_core::recognition::objects::{Dimension, Distance, ObjectOptions, Resize, Search, Stages};

words!(Resize, ResizeWord, { Fit, Never });
words!(Stages, StagesWord, { UniversalThenObject, UniversalOnly });
words!(Search, SearchWord, { KdTree, Slabs, Exhaustive });
words!(Distance, DistanceWord, { Euclidean, Mahalanobis });

/// The document. The order of the members is the order in the document and in digests.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ObjectDocument {
    width_px: Option<usize>,
    height_px: Option<usize>,
    resize: ResizeWord,
    /// Left out where it is false: digests from before it was an option stay what they are.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    segment: bool,
    smoothing: f64,
    #[serde(serialize_with = "write_dimension", deserialize_with = "read_dimension")]
    dimension: Dimension,
    stages: StagesWord,
    search: SearchWord,
    distance: DistanceWord,
    accept: f64,
}

/// A number, or the word `auto`.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum DimensionDocument {
    Number(usize),
    Word(String),
}

fn write_dimension<S: Serializer>(dimension: &Dimension, serializer: S) -> Result<S::Ok, S::Error> {
    match dimension {
        Dimension::Fixed(number) => DimensionDocument::Number(*number),
        Dimension::Auto => DimensionDocument::Word("auto".into()),
    }
    .serialize(serializer)
}

fn read_dimension<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Dimension, D::Error> {
    let expected = "dimension is a whole number, or auto";
    match DimensionDocument::deserialize(deserializer).map_err(|_| D::Error::custom(expected))? {
        DimensionDocument::Number(number) => Ok(Dimension::Fixed(number)),
        DimensionDocument::Word(word) if word == "auto" => Ok(Dimension::Auto),
        DimensionDocument::Word(_) => Err(D::Error::custom(expected)),
    }
}

impl From<&ObjectOptions> for ObjectDocument {
    fn from(options: &ObjectOptions) -> Self {
        Self {
            width_px: options.width_px,
            height_px: options.height_px,
            resize: options.resize.into(),
            segment: options.segment,
            smoothing: options.smoothing,
            dimension: options.dimension,
            stages: options.stages.into(),
            search: options.search.into(),
            distance: options.distance.into(),
            accept: options.accept,
        }
    }
}

/// What is absent in a kept document: the default of the release that added the option.
impl Default for ObjectDocument {
    fn default() -> Self {
        Self::from(&ObjectOptions::default())
    }
}

impl From<ObjectDocument> for ObjectOptions {
    fn from(document: ObjectDocument) -> Self {
        Self {
            width_px: document.width_px,
            height_px: document.height_px,
            resize: document.resize.into(),
            segment: document.segment,
            smoothing: document.smoothing,
            dimension: document.dimension,
            stages: document.stages.into(),
            search: document.search.into(),
            distance: document.distance.into(),
            accept: document.accept,
        }
    }
}
