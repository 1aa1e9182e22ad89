//! Options of a database as words of the command line.

use serde_json::{Map, Value};

use super::EvaluateError;
use crate::database::options::{
    DocumentError, Kind, LandmarkOptionsDocument, ObjectOptionsDocument, Options, OptionsDocument,
    refuse_null,
};

/// The options as the document they are kept as.
pub(super) fn document_of(options: &Options) -> Value {
    serde_json::from_str(&options.to_document()).unwrap_or_default()
}

/// The default options of a kind changed by the given `NAME=VALUE`; a value is JSON, or else a word. Defaults of landmarks
/// are those of the method and viewpoint that are given.
///
/// # Errors
/// An option that is unknown, of the wrong type, or that can't be used with the others.
pub(super) fn options_with(kind: Kind, given: &[String]) -> Result<Options, EvaluateError> {
    let pairs = given
        .iter()
        .map(|pair| read_pair(pair).ok_or_else(|| EvaluateError::NotAnOption { given: pair.clone() }));
    let given: Vec<(&str, Value)> = pairs.collect::<Result<_, _>>()?;
    let defaults = Options::default_of(kind);
    let known: Map<String, Value> = serde_json::to_value(OptionsDocument::from(&defaults))
        .and_then(serde_json::from_value)
        .unwrap_or_default();
    for (option, value) in &given {
        if !known.contains_key(*option) {
            let known = known.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(EvaluateError::UnknownOption { option: (*option).into(), known });
        }
        // Each is read by itself, so that the error names the one at fault.
        let alone = Map::from_iter([((*option).to_owned(), value.clone())]);
        patched(defaults.clone(), alone).map_err(|source| {
            let source = DocumentError::Malformed { source };
            EvaluateError::OptionType { option: (*option).into(), value: value.clone(), source }
        })?;
    }
    let all = given.into_iter().map(|(option, value)| (option.to_owned(), value)).collect();
    patched(defaults, all)
        .map_err(|source| DocumentError::Malformed { source })
        .and_then(Options::usable)
        .map_err(|source| EvaluateError::Options { source })
}

/// The options `base` changed by the members, whether or not they can be used together.
fn patched(base: Options, members: Map<String, Value>) -> Result<Options, serde_json::Error> {
    refuse_null(&members)?;
    let members = Value::Object(members);
    Ok(match base {
        Options::Landmarks(base) => {
            Options::Landmarks(serde_json::from_value::<LandmarkOptionsDocument>(members)?.patch(base))
        }
        Options::Objects(base) => {
            Options::Objects(serde_json::from_value::<ObjectOptionsDocument>(members)?.patch(base))
        }
    })
}

/// The name and the value of `NAME=VALUE`; a value is JSON, or else a word. `None` without `=`.
pub(crate) fn read_pair(pair: &str) -> Option<(&str, Value)> {
    let (option, text) = pair.split_once('=')?;
    Some((option, serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::recognition::landmarks::{LandmarkOptions, Method, Signature, Viewpoint};
    use landmarkd_core::recognition::objects::{Dimension, ObjectOptions};

    fn with(kind: Kind, pairs: &[&str]) -> Result<Options, EvaluateError> {
        options_with(kind, &pairs.iter().map(|pair| (*pair).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_laid_over_the_defaults_and_faults_name_the_option() {
        let with = |pairs: &[&str]| with(Kind::Landmarks, pairs);
        let pairs = ["interest_points=16", "colour=gray", "normalise=\"energy\"", "epsilon=0.01"];
        let Ok(Options::Landmarks(options)) = with(&pairs) else { panic!("these options are good") };
        assert_eq!((options.interest_points, options.epsilon), (16, 0.01));
        assert_eq!(options.query_points, LandmarkOptions::default().query_points);
        let paper = LandmarkOptions::of(Method::Paper, Viewpoint::Free);
        let Ok(Options::Landmarks(options)) = with(&["rings=6", "method=paper"]) else {
            panic!("so are these")
        };
        assert_eq!(options, LandmarkOptions { rings: 6, ..paper });
        let upright = LandmarkOptions {
            position_prior_px: Some(30.0),
            ..LandmarkOptions::with_signature(Method::Placement, Viewpoint::Upright, Signature::Intensity)
        };
        let given = with(&["viewpoint=upright", "position_prior_px=30"]).unwrap();
        assert_eq!(given, Options::Landmarks(upright));
        let message = |pairs: &[&str]| with(pairs).unwrap_err().to_string();
        assert!(message(&["rings"]).contains("NAME=VALUE"));
        assert!(message(&["points=3"]).contains("interest_points"), "the message lists what there is");
        assert!(message(&["epsilon=0.1", "rings=many"]).contains("rings"));
        assert!(message(&["method=magic"]).contains("method"));
        assert!(
            matches!(with(&["rings=0"]), Err(EvaluateError::Options { source }) if source.to_string().contains("rings"))
        );
    }

    #[test]
    fn each_kind_has_options_of_its_own() {
        let pairs = ["dimension=12", "segment=true", "width_px=64", "height_px=48"];
        let options = with(Kind::Objects, &pairs).unwrap();
        let expected = ObjectOptions {
            dimension: Dimension::Fixed(12),
            segment: true,
            width_px: Some(64),
            height_px: Some(48),
            ..ObjectOptions::default()
        };
        assert_eq!(options, Options::Objects(expected));
        assert_eq!(with(Kind::Objects, &[]).unwrap(), Options::Objects(ObjectOptions::default()));
        assert!(matches!(with(Kind::Objects, &["rings=8"]), Err(EvaluateError::UnknownOption { .. })));
        let lone = with(Kind::Objects, &["width_px=64"]);
        assert!(
            matches!(lone, Err(EvaluateError::Options { source }) if source.to_string().contains("height_px"))
        );
    }
}
