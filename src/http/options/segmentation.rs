//! Options of a segmentation, from a JSON object or a query.

use serde_json::{Map, Number, Value};

use super::{field_errors, read_members};
use crate::database::options::SegmentationOptionsDocument;
use crate::http::problem::FieldError;
use landmarkd_core::vision::segmentation::SegmentationOptions;

/// Reads the options from the members of the object at the JSON pointer `at`, and finds everything that is wrong with
/// them. What is absent has its default.
pub fn read_segmentation(at: &str, body: &Map<String, Value>) -> (SegmentationOptions, Vec<FieldError>) {
    let (document, mut faults) = read_members::<SegmentationOptionsDocument>(at, body);
    let options = SegmentationOptions::from(document);
    faults.extend(field_errors(at, options.faults()));
    (options, faults)
}

/// The same for the parameters of a query.
pub fn read_segmentation_query(query: &str) -> (SegmentationOptions, Vec<FieldError>) {
    let (mut members, mut faults) = (Map::new(), Vec::new());
    for (name, text) in form_urlencoded::parse(query.as_bytes()) {
        let number = serde_json::from_str::<Number>(&text).map(Value::Number);
        let value = number.unwrap_or_else(|_| text.as_ref().into());
        if members.insert(name.to_string(), value).is_some() {
            let detail = "comes twice: give it once".into();
            faults.push(FieldError { pointer: format!("#{name}"), detail });
        }
    }
    let (options, wrong) = read_segmentation("", &members);
    let of_query = |fault: FieldError| FieldError { pointer: fault.pointer.replacen('/', "#", 1), ..fault };
    faults.extend(wrong.into_iter().map(of_query));
    (options, faults)
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::vision::segmentation::{Polarity, Threshold};
    use serde_json::json;

    fn read(body: Value) -> (SegmentationOptions, Vec<FieldError>) {
        read_segmentation("/segmentation", body.as_object().unwrap())
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
        let (_, faults) = read_segmentation_query(query);
        assert_eq!(pointers(faults), ALL.map(|option| format!("#{option}")));
        let (_, faults) = read_segmentation_query("offset=3&offset=4&treshold=1");
        assert_eq!(pointers(faults), ["#offset", "#treshold"]);
    }

    #[test]
    fn body_and_query_say_the_same_and_what_is_absent_or_null_is_the_default() {
        let null = json!({"threshold": null, "window_px": null, "offset": null, "min_area_px": null});
        for body in [json!({}), null, json!({"threshold": "adaptive", "polarity": "either"})] {
            assert_eq!(read(body), (SegmentationOptions::default(), vec![]));
        }
        assert_eq!(read_segmentation_query(""), (SegmentationOptions::default(), vec![]));
        let expected = SegmentationOptions {
            threshold: Threshold::Fixed(90.5),
            window_px: Some(61),
            offset: Some(7.0),
            polarity: Polarity::DarkOnLight,
            min_area_px: Some(30),
            max_objects: 9,
        };
        let written = serde_json::to_value(SegmentationOptionsDocument::from(&expected)).unwrap();
        assert_eq!(read(written), (expected.clone(), vec![]));
        let query =
            "threshold=90.5&window_px=61&offset=7&polarity=dark_on_light&min_area_px=30&max_objects=9";
        assert_eq!(read_segmentation_query(query), (expected, vec![]));
        let (otsu, faults) = read_segmentation_query("threshold=otsu");
        assert_eq!((otsu.threshold, faults), (Threshold::Otsu, vec![]));
    }
}
