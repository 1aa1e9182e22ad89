//! Options of a database as words of the command line.

use serde_json::{Map, Value};

use super::EvaluateError;
use crate::database::options::{DocumentError, Kind, Options};
use landmarkd_core::recognition::landmarks::LandmarkOptions;

/// The options as the document they are kept as.
pub(super) fn document_of(options: &Options) -> Value {
    serde_json::from_str(&options.to_document()).unwrap_or_default()
}

/// The default options of a kind with the given `NAME=VALUE` laid over them; a value is JSON, or else a word. Defaults
/// of landmarks are those of the method and viewpoint that are given.
pub(super) fn options_with(kind: Kind, given: &[String]) -> Result<Options, EvaluateError> {
    let given: Vec<(&str, Value)> = given.iter().map(|pair| read_pair(pair)).collect::<Result<_, _>>()?;
    let read = |document: &Map<String, Value>| {
        Options::from_document(kind, &Value::from(document.clone()).to_string())
    };
    let mut defaults = Options::default_of(kind);
    if let Options::Landmarks(options) = &mut defaults {
        let mut pair = Map::from_iter([("method".into(), Value::from("placement"))]);
        for (option, value) in given.iter().filter(|(option, _)| ["method", "viewpoint"].contains(option)) {
            pair.insert((*option).into(), value.clone());
            match read(&pair) {
                Ok(Options::Landmarks(read)) => *options = LandmarkOptions::of(read.method, read.viewpoint),
                Err(source @ DocumentError::Malformed { .. }) => {
                    let (option, value) = ((*option).into(), value.clone());
                    return Err(EvaluateError::OptionType { option, value, source });
                }
                Err(source) => return Err(EvaluateError::Options { source }),
                Ok(Options::Objects(_)) => {}
            }
        }
    }
    let mut document: Map<String, Value> = document_of(&defaults).as_object().cloned().unwrap_or_default();
    // Documents name these only where they are on.
    match kind {
        Kind::Objects => document.insert("segment".into(), Value::from(false)),
        Kind::Landmarks => document.insert("position_prior_px".into(), Value::Null),
    };
    for (option, value) in given {
        if !document.contains_key(option) {
            let known = document.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(EvaluateError::UnknownOption { option: option.into(), known });
        }
        document.insert(option.into(), value.clone());
        // Types are asked for one option at a time, so that the one at fault is named; whether all of them go
        // together is asked at the end.
        if let Err(source @ DocumentError::Malformed { .. }) = read(&document) {
            return Err(EvaluateError::OptionType { option: option.into(), value, source });
        }
    }
    read(&document).map_err(|source| EvaluateError::Options { source })
}

fn read_pair(pair: &str) -> Result<(&str, Value), EvaluateError> {
    let (option, text) =
        pair.split_once('=').ok_or_else(|| EvaluateError::NotAnOption { given: pair.into() })?;
    Ok((option, serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::recognition::landmarks::{Method, Viewpoint};
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
            ..LandmarkOptions::of(Method::Placement, Viewpoint::Upright)
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
