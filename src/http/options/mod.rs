//! Options in requests. Each is optional; what is absent keeps its value. Unknown, misshapen and conflicting ones are
//! one problem that names them all. The documents of databases and segmentations are those of `database::options`.

mod depth;
mod segmentation;

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

pub use depth::{DepthOptionsBody, WindowBody};
pub use segmentation::{read_segmentation, read_segmentation_query};

use super::extract::from_value;
use super::problem::{FieldError, Problem};
use crate::database::options::{LandmarkOptionsDocument, ObjectOptionsDocument, Options};
use landmarkd_core::recognition::OptionFault;

/// The options `base` changed by the members of `body`.
///
/// # Errors
/// One problem that names every unknown, misshapen or conflicting option.
pub fn patched(base: Options, body: &Map<String, Value>) -> Result<Options, Problem> {
    const AT: &str = "/options";
    let (options, mut faults) = match base {
        Options::Landmarks(base) => {
            let (document, faults) = read_members::<LandmarkOptionsDocument>(AT, body);
            (Options::Landmarks(document.patch(base)), faults)
        }
        Options::Objects(base) => {
            let (document, faults) = read_members::<ObjectOptionsDocument>(AT, body);
            (Options::Objects(document.patch(base)), faults)
        }
    };
    faults.extend(field_errors(AT, options.faults()));
    if faults.is_empty() { Ok(options) } else { Err(Problem::fields(faults)) }
}

/// Reads the members of the object at the JSON pointer `at` one by one, so that every fault is found and not only the
/// first: the members that can be read, and a fault for each of the others.
pub fn read_members<B: DeserializeOwned + Default>(
    at: &str,
    body: &Map<String, Value>,
) -> (B, Vec<FieldError>) {
    let mut faults = Vec::new();
    let mut sound = Map::new();
    for (name, value) in body {
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        match from_value::<B>(alone) {
            Ok(_) => drop(sound.insert(name.clone(), value.clone())),
            Err(fault) => {
                faults.push(FieldError { pointer: format!("{at}{}", fault.pointer), ..fault });
            }
        }
    }
    (serde_json::from_value(Value::Object(sound)).unwrap_or_default(), faults)
}

/// What is wrong with the options in the object at the JSON pointer `at`, as fields of the request.
fn field_errors(at: &str, faults: Vec<OptionFault>) -> impl Iterator<Item = FieldError> {
    faults
        .into_iter()
        .map(move |fault| FieldError { pointer: format!("{at}/{}", fault.option), detail: fault.message })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::problem::Code;
    use landmarkd_core::recognition::landmarks::{LandmarkOptions, Method, Signature, Viewpoint};
    use landmarkd_core::recognition::objects::{Dimension, ObjectOptions};
    use serde_json::json;

    fn landmarks(base: LandmarkOptions, body: Value) -> Result<LandmarkOptions, Problem> {
        match patched(Options::Landmarks(base), body.as_object().unwrap())? {
            Options::Landmarks(options) => Ok(options),
            Options::Objects(_) => panic!("the kind stays"),
        }
    }

    fn objects(base: ObjectOptions, body: Value) -> Result<ObjectOptions, Problem> {
        match patched(Options::Objects(base), body.as_object().unwrap())? {
            Options::Objects(options) => Ok(options),
            Options::Landmarks(_) => panic!("the kind stays"),
        }
    }

    #[test]
    fn every_fault_of_landmark_options_is_named_at_once() {
        let body = json!({"ringz": 3, "sectors": "many", "epsilon": -1.0, "taper": "flat", "dimension": 8});
        let problem = landmarks(LandmarkOptions::default(), body).unwrap_err();
        let mut at: Vec<&str> = problem.errors.iter().map(|error| error.pointer.as_str()).collect();
        at.sort_unstable();
        assert_eq!(at, ["/options/epsilon", "/options/ringz", "/options/sectors", "/options/taper"]);
        assert_eq!(problem.code, Code::InvalidField);
    }

    #[test]
    fn what_is_absent_keeps_its_value() {
        let base = LandmarkOptions { interest_points: 16, ..Default::default() };
        let options = landmarks(base, json!({"dimension": 8})).unwrap();
        assert_eq!((options.interest_points, options.dimension), (16, 8));
    }

    #[test]
    fn another_method_or_viewpoint_starts_from_its_own_defaults() {
        let paper = landmarks(LandmarkOptions::default(), json!({"method": "paper", "rings": 6})).unwrap();
        let expected = LandmarkOptions { rings: 6, ..LandmarkOptions::of(Method::Paper, Viewpoint::Free) };
        assert_eq!(paper, expected);
        let same = landmarks(paper.clone(), json!({"method": "paper"})).unwrap();
        assert_eq!(same, paper, "what is named anew and is no other keeps the rest");
        let back = json!({"method": "placement", "viewpoint": "upright", "position_prior_px": 30});
        let upright = landmarks(paper, back).unwrap();
        let intensity = Signature::Intensity;
        let defaults = LandmarkOptions::with_signature(Method::Placement, Viewpoint::Upright, intensity);
        assert_eq!(upright, LandmarkOptions { position_prior_px: Some(30.0), ..defaults.clone() });
        let anywhere = json!({"position_prior_px": null});
        assert_eq!(landmarks(upright, anywhere).unwrap(), defaults);
    }

    #[test]
    fn a_preset_is_where_options_start_from_and_other_members_are_put_over_it() {
        let kept =
            LandmarkOptions { interest_points: 16, ..LandmarkOptions::of(Method::Paper, Viewpoint::Free) };
        let of = |viewpoint| LandmarkOptions::of(Method::Placement, viewpoint);
        for (preset, viewpoint) in
            [("rooms", Viewpoint::Upright), ("things", Viewpoint::Free), ("flat", Viewpoint::Free)]
        {
            assert_eq!(landmarks(kept.clone(), json!({"preset": preset})).unwrap(), of(viewpoint));
        }
        let body = json!({"preset": "rooms", "turn_prior_deg": 10, "dimension": 8});
        let rooms = LandmarkOptions { turn_prior_deg: Some(10.0), dimension: 8, ..of(Viewpoint::Upright) };
        assert_eq!(landmarks(kept.clone(), body).unwrap(), rooms);
        let free = json!({"preset": "rooms", "viewpoint": "free"});
        assert_eq!(landmarks(kept.clone(), free).unwrap(), of(Viewpoint::Free));
        let shown = serde_json::to_value(LandmarkOptionsDocument::from(rooms)).unwrap();
        assert_eq!(shown.get("preset"), None);

        let problem = landmarks(kept, json!({"preset": "street"})).unwrap_err();
        assert_eq!(problem.errors[0].pointer, "/options/preset");
        for preset in ["rooms", "things", "flat"] {
            assert!(problem.detail.contains(preset), "{}", problem.detail);
        }
        let of_objects = objects(ObjectOptions::default(), json!({"preset": "rooms"})).unwrap_err();
        assert_eq!(of_objects.errors[0].pointer, "/options/preset");
    }

    #[test]
    fn a_radius_or_several_are_taken_and_shown() {
        for (given, radii_px) in [(json!(7), vec![7.0]), (json!([6, 9.5]), vec![6.0, 9.5])] {
            let options =
                landmarks(LandmarkOptions::default(), json!({"subwindow_radius_px": given})).unwrap();
            assert_eq!(options.subwindow_radii_px, radii_px);
            let shown = serde_json::to_value(LandmarkOptionsDocument::from(options)).unwrap();
            assert_eq!(shown["subwindow_radius_px"].is_array(), given.is_array(), "{shown}");
        }
        for wrong in [json!([]), json!([9, 6]), json!([1]), json!("wide"), json!([5, 6, 7, 8, 9])] {
            let problem =
                landmarks(LandmarkOptions::default(), json!({"subwindow_radius_px": wrong})).unwrap_err();
            assert_eq!(problem.errors[0].pointer, "/options/subwindow_radius_px", "{wrong}");
        }
    }

    #[test]
    fn every_fault_of_object_options_is_named_at_once() {
        let body = json!({
            "widht_px": 3, "height_px": 2, "resize": "crop", "dimension": "most", "accept": 2, "segment": "yes",
        });
        let problem = objects(ObjectOptions::default(), body).unwrap_err();
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
        let options = objects(base.clone(), json!({"dimension": 8})).unwrap();
        assert_eq!((options.width_px, options.dimension), (Some(64), Dimension::Fixed(8)));
        let options = objects(base, json!({"width_px": null, "height_px": null})).unwrap();
        assert_eq!((options.width_px, options.height_px), (None, None));
    }

    #[test]
    fn segmenting_is_taken_and_shown() {
        assert_eq!(
            objects(ObjectOptions::default(), json!({"segment": false})).unwrap(),
            ObjectOptions::default()
        );
        let options = objects(ObjectOptions::default(), json!({"segment": true})).unwrap();
        assert_eq!(options, ObjectOptions { segment: true, ..Default::default() });
        let shown = serde_json::to_value(ObjectOptionsDocument::from(options)).unwrap();
        assert_eq!(shown["segment"], true);
    }

    #[test]
    fn the_largest_dimension_is_taken_and_one_more_is_not() {
        assert!(objects(ObjectOptions::default(), json!({"dimension": 256})).is_ok());
        for dimension in [json!(0), json!(257), json!(-1), json!(1.5), json!("Auto")] {
            assert!(
                objects(ObjectOptions::default(), json!({"dimension": dimension})).is_err(),
                "{dimension}"
            );
        }
    }
}
