//! Options of a database of kind `objects`.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{AutoWord, fields, given, judge, readable, words};
use crate::http::problem::Problem;
use landmarkd_core::recognition::objects::{self, Dimension, ObjectOptions};

words!(
    /// What becomes of a picture of another size: it is scaled to fit, centred on black, and the answer or report says
    /// so; or it is refused.
    ResizeWord, objects::Resize, { Fit, Never }
);
words!(
    /// Whether the universal eigenspace only proposes objects and each one's own settles which and how turned, or
    /// answers alone: for small sets.
    StagesWord, objects::Stages, { UniversalThenObject, UniversalOnly }
);
words!(
    /// How the eigenpoints near a query are found; the answers are the same.
    SearchWord, objects::Search, { KdTree, Slabs, Exhaustive }
);
words!(
    /// By what the universal eigenspace orders objects.
    DistanceWord, objects::Distance, { Euclidean, Mahalanobis }
);

/// A number of coordinates, or `auto`: the least that recognises held-out views as well as any.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a whole number or \"auto\"")]
pub enum DimensionBody {
    Number(usize),
    Word(AutoWord),
}

/// Options of a database of kind `objects`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectOptionsBody {
    /// Width of the database's pictures; null, as the height then: the commonest size among the exemplars.
    #[schema(value_type = Option<usize>, minimum = 8, maximum = 1024)]
    #[serde(default, deserialize_with = "given")]
    pub width_px: Option<Option<usize>>,
    /// Height of the database's pictures.
    #[schema(value_type = Option<usize>, minimum = 8, maximum = 1024)]
    #[serde(default, deserialize_with = "given")]
    pub height_px: Option<Option<usize>>,
    #[schema(required = false)]
    pub resize: Option<ResizeWord>,
    /// Standard deviation of the Gaussian that pictures are smoothed with, as a part of their longer side.
    #[schema(minimum = 0, maximum = 0.1)]
    pub smoothing: Option<f64>,
    /// Whether the object is cut out of its picture first, in training and in recognition: the largest region that
    /// stands out from the background, in the square about its centroid, on black. Pictures are then square, of 128 px
    /// unless a size is given.
    pub segment: Option<bool>,
    /// Coordinates of an eigenpoint in the universal eigenspace, 1 to 256, or `auto`.
    #[schema(required = false)]
    pub dimension: Option<DimensionBody>,
    #[schema(required = false)]
    pub stages: Option<StagesWord>,
    #[schema(required = false)]
    pub search: Option<SearchWord>,
    #[schema(required = false)]
    pub distance: Option<DistanceWord>,
    /// Part of the known objects that is to be accepted.
    #[schema(minimum = 0.5, maximum = 0.9999)]
    pub accept: Option<f64>,
}

impl From<&ObjectOptions> for ObjectOptionsBody {
    fn from(options: &ObjectOptions) -> Self {
        Self {
            width_px: Some(options.width_px),
            height_px: Some(options.height_px),
            resize: Some(options.resize.into()),
            smoothing: Some(options.smoothing),
            segment: Some(options.segment),
            dimension: Some(match options.dimension {
                Dimension::Fixed(number) => DimensionBody::Number(number),
                Dimension::Auto => DimensionBody::Word(AutoWord::Auto),
            }),
            stages: Some(options.stages.into()),
            search: Some(options.search.into()),
            distance: Some(options.distance.into()),
            accept: Some(options.accept),
        }
    }
}

/// See [`super::over`].
pub(super) fn over(base: ObjectOptions, body: &Map<String, Value>) -> Result<ObjectOptions, Problem> {
    let (body, mut faults) = readable::<ObjectOptionsBody>("/options", body);
    let mut options = base;
    macro_rules! take_word {
        ($($field:ident),+) => {$( if let Some(word) = body.$field { options.$field = word.into(); } )+};
    }
    macro_rules! take {
        ($($field:ident),+) => {$( if let Some(value) = body.$field { options.$field = value; } )+};
    }
    take_word!(resize, stages, search, distance);
    take!(width_px, height_px, smoothing, segment, accept);
    match body.dimension {
        Some(DimensionBody::Number(number)) => options.dimension = Dimension::Fixed(number),
        Some(DimensionBody::Word(AutoWord::Auto)) => options.dimension = Dimension::Auto,
        None => {}
    }
    faults.extend(fields("/options", options.faults()));
    judge(faults)?;
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::problem::Code;
    use serde_json::json;

    fn over_default(body: Value) -> Result<ObjectOptions, Problem> {
        over(ObjectOptions::default(), body.as_object().unwrap())
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let body = json!({
            "widht_px": 3, "height_px": 2, "resize": "crop", "dimension": "most", "accept": 2, "segment": "yes",
        });
        let problem = over_default(body).unwrap_err();
        let mut at: Vec<&str> = problem.errors.iter().map(|error| error.pointer.as_str()).collect();
        at.sort_unstable();
        at.dedup();
        let wrong = ["accept", "dimension", "height_px", "resize", "segment", "widht_px", "width_px"];
        assert_eq!(at, wrong.map(|option| format!("/options/{option}")));
        assert_eq!(problem.code, Code::InvalidField);
        assert!(problem.detail.contains("expected a whole number or \"auto\""), "{}", problem.detail);
    }

    #[test]
    fn what_is_absent_keeps_its_value_and_null_takes_the_size_back() {
        let base = ObjectOptions { width_px: Some(64), height_px: Some(48), ..Default::default() };
        let options = over(base.clone(), json!({"dimension": 8}).as_object().unwrap()).unwrap();
        assert_eq!((options.width_px, options.dimension), (Some(64), Dimension::Fixed(8)));
        let options = over(base, json!({"width_px": null, "height_px": null}).as_object().unwrap()).unwrap();
        assert_eq!((options.width_px, options.height_px), (None, None));
    }

    #[test]
    fn segmenting_is_taken_and_shown() {
        assert_eq!(over_default(json!({"segment": false})).unwrap(), ObjectOptions::default());
        let options = over_default(json!({"segment": true})).unwrap();
        assert_eq!(options, ObjectOptions { segment: true, ..Default::default() });
        assert_eq!(ObjectOptionsBody::from(&options).segment, Some(true));
    }

    #[test]
    fn the_largest_dimension_is_taken_and_one_more_is_not() {
        assert!(over_default(json!({"dimension": 256})).is_ok());
        for dimension in [json!(0), json!(257), json!(-1), json!(1.5), json!("Auto")] {
            assert!(over_default(json!({"dimension": dimension})).is_err(), "{dimension}");
        }
    }
}
