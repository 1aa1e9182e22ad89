//! Options of a segmentation.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Number, Value};
use utoipa::{IntoParams, ToSchema};

use super::{fields, readable, words};
use crate::http::problem::FieldError;
use landmarkd_core::vision::segmentation::{self, SegmentationOptions, Threshold};

words!(
    /// What objects look like.
    PolarityWord, segmentation::Polarity, { LightOnDark, DarkOnLight }
);

/// `adaptive`: the mean of the background around each pixel, and an offset. `otsu`: one level for the picture, which
/// tells two classes of pixels best apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ThresholdWord {
    Adaptive,
    Otsu,
}

/// A grey level, 0 to 255, or by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a number of 0 to 255, \"adaptive\" or \"otsu\"")]
pub enum ThresholdBody {
    Level(f64),
    Word(ThresholdWord),
}

/// Options of a segmentation. What is absent has its default.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SegmentationOptionsBody {
    /// What a pixel is held against: `adaptive` (the default), `otsu`, or a grey level.
    #[schema(required = false)]
    #[param(required = false)]
    pub threshold: Option<ThresholdBody>,
    /// Adaptive only: side of the square that the background is looked for in; null or absent: chosen from the picture.
    #[schema(minimum = 3, maximum = 4095)]
    #[param(minimum = 3, maximum = 4095)]
    pub window_px: Option<usize>,
    /// Adaptive only: how far a pixel must stand out from the background, in grey levels; null or absent: chosen from
    /// the picture.
    #[schema(minimum = 0, maximum = 255)]
    #[param(minimum = 0, maximum = 255)]
    pub offset: Option<f64>,
    /// Whether objects are lighter than the background (the default) or darker.
    #[schema(required = false)]
    #[param(required = false)]
    pub polarity: Option<PolarityWord>,
    /// Smaller regions are specks; null or absent: chosen from the picture.
    #[schema(minimum = 1)]
    #[param(minimum = 1)]
    pub min_area_px: Option<usize>,
    /// Most regions that are told of, the largest.
    #[schema(minimum = 1, maximum = 1000, default = 100)]
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub max_objects: Option<usize>,
}

impl SegmentationOptionsBody {
    /// The options that the members of the object `at` make, and everything that is wrong with them.
    pub fn read(at: &str, body: &Map<String, Value>) -> (SegmentationOptions, Vec<FieldError>) {
        let (body, mut faults) = readable::<Self>(at, body);
        let mut options = SegmentationOptions {
            window_px: body.window_px,
            offset: body.offset,
            min_area_px: body.min_area_px,
            ..SegmentationOptions::default()
        };
        match body.threshold {
            Some(ThresholdBody::Level(level)) => options.threshold = Threshold::Fixed(level),
            Some(ThresholdBody::Word(ThresholdWord::Otsu)) => options.threshold = Threshold::Otsu,
            Some(ThresholdBody::Word(ThresholdWord::Adaptive)) | None => {}
        }
        if let Some(polarity) = body.polarity {
            options.polarity = polarity.into();
        }
        if let Some(most) = body.max_objects {
            options.max_objects = most;
        }
        faults.extend(fields(at, options.faults()));
        (options, faults)
    }

    /// The same of a query.
    pub fn read_query(query: &str) -> (SegmentationOptions, Vec<FieldError>) {
        let (mut body, mut twice) = (Map::new(), Vec::new());
        for (name, text) in form_urlencoded::parse(query.as_bytes()) {
            let number = serde_json::from_str::<Number>(&text).map(Value::Number);
            let value = number.unwrap_or_else(|_| text.as_ref().into());
            if body.insert(name.to_string(), value).is_some() {
                twice.push(FieldError {
                    pointer: format!("#{name}"),
                    detail: "comes twice: give it once".into(),
                });
            }
        }
        let (options, faults) = Self::read("", &body);
        let named = |fault: FieldError| FieldError { pointer: fault.pointer.replacen('/', "#", 1), ..fault };
        twice.extend(faults.into_iter().map(named));
        (options, twice)
    }
}

impl From<&SegmentationOptions> for SegmentationOptionsBody {
    fn from(options: &SegmentationOptions) -> Self {
        Self {
            threshold: Some(match options.threshold {
                Threshold::Adaptive => ThresholdBody::Word(ThresholdWord::Adaptive),
                Threshold::Otsu => ThresholdBody::Word(ThresholdWord::Otsu),
                Threshold::Fixed(level) => ThresholdBody::Level(level),
            }),
            window_px: options.window_px,
            offset: options.offset,
            polarity: Some(options.polarity.into()),
            min_area_px: options.min_area_px,
            max_objects: Some(options.max_objects),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::vision::segmentation::Polarity;
    use serde_json::json;

    fn read(body: Value) -> (SegmentationOptions, Vec<FieldError>) {
        SegmentationOptionsBody::read("/segmentation", body.as_object().unwrap())
    }

    fn pointers(faults: Vec<FieldError>) -> Vec<String> {
        let mut at: Vec<String> = faults.into_iter().map(|fault| fault.pointer).collect();
        at.sort_unstable();
        at
    }

    const ALL: [&str; 6] = ["max_objects", "min_area_px", "offset", "polarity", "threshold", "window_px"];

    #[test]
    fn every_fault_is_named_at_once() {
        let (_, faults) = read(json!({
            "threshold": "best", "window_px": 2, "offset": -1, "polarity": "light", "min_area_px": 0,
            "max_objects": 1001, "colour": 1,
        }));
        let mut wrong = [&ALL[..], &["colour"]].concat();
        wrong.sort_unstable();
        let wrong: Vec<String> = wrong.into_iter().map(|option| format!("/segmentation/{option}")).collect();
        assert_eq!(pointers(faults), wrong);
        let query = "threshold=256&window_px=no&offset=1e9&polarity=&min_area_px=1.5&max_objects=-1";
        let (_, faults) = SegmentationOptionsBody::read_query(query);
        assert_eq!(pointers(faults), ALL.map(|option| format!("#{option}")));
        let (_, faults) = SegmentationOptionsBody::read_query("offset=3&offset=4&treshold=1");
        assert_eq!(pointers(faults), ["#offset", "#treshold"]);
    }

    #[test]
    fn body_and_query_say_the_same_and_what_is_absent_or_null_is_the_default() {
        let null = json!({"threshold": null, "window_px": null, "offset": null, "min_area_px": null});
        for body in [json!({}), null, json!({"threshold": "adaptive", "polarity": "light_on_dark"})] {
            assert_eq!(read(body), (SegmentationOptions::default(), vec![]));
        }
        assert_eq!(SegmentationOptionsBody::read_query(""), (SegmentationOptions::default(), vec![]));
        let expected = SegmentationOptions {
            threshold: Threshold::Fixed(90.5),
            window_px: Some(61),
            offset: Some(7.0),
            polarity: Polarity::DarkOnLight,
            min_area_px: Some(30),
            max_objects: 9,
        };
        let told = serde_json::to_value(SegmentationOptionsBody::from(&expected)).unwrap();
        assert_eq!(read(told), (expected.clone(), vec![]));
        let query =
            "threshold=90.5&window_px=61&offset=7&polarity=dark_on_light&min_area_px=30&max_objects=9";
        assert_eq!(SegmentationOptionsBody::read_query(query), (expected, vec![]));
        let (otsu, faults) = SegmentationOptionsBody::read_query("threshold=otsu");
        assert_eq!((otsu.threshold, faults), (Threshold::Otsu, vec![]));
    }
}
