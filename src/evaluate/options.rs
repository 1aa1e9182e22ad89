//! Options of a database as words of the command line.

use serde_json::{Map, Value};

use super::EvaluateError;
use crate::database::options::{DocumentError, Kind, Options};

/// The options as the document they are kept as.
pub(super) fn document_of(options: &Options) -> Value {
    serde_json::from_str(&options.to_document()).unwrap_or_default()
}

/// The default options of a kind with the given `NAME=VALUE` laid over them; a value is JSON, or else a word.
pub(super) fn options_with(kind: Kind, given: &[String]) -> Result<Options, EvaluateError> {
    let defaults = document_of(&Options::default_of(kind));
    let mut document: Map<String, Value> = defaults.as_object().cloned().unwrap_or_default();
    if kind == Kind::Objects {
        // Documents name it only where it is on.
        document.insert("segment".into(), Value::from(false));
    }
    let read = |document: &Map<String, Value>| {
        Options::from_document(kind, &Value::from(document.clone()).to_string())
    };
    for pair in given {
        let (option, text) =
            pair.split_once('=').ok_or_else(|| EvaluateError::NotAnOption { given: pair.clone() })?;
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::from(text));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recognition::landmarks::LandmarkOptions;
    use crate::recognition::objects::{Dimension, ObjectOptions};

    fn with(kind: Kind, pairs: &[&str]) -> Result<Options, EvaluateError> {
        options_with(kind, &pairs.iter().map(|pair| (*pair).to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn options_are_laid_over_the_defaults_and_faults_name_the_option() {
        let with = |pairs: &[&str]| with(Kind::Landmarks, pairs);
        let pairs = ["interest_points=16", "colour=gray", "taper=\"literal\"", "epsilon=0.01"];
        let Ok(Options::Landmarks(options)) = with(&pairs) else { panic!("these options are good") };
        assert_eq!((options.interest_points, options.epsilon), (16, 0.01));
        assert_eq!(options.query_points, LandmarkOptions::default().query_points);
        let message = |pairs: &[&str]| with(pairs).unwrap_err().to_string();
        assert!(message(&["rings"]).contains("NAME=VALUE"));
        assert!(message(&["points=3"]).contains("interest_points"), "the message lists what there is");
        assert!(message(&["epsilon=0.1", "rings=many"]).contains("rings"));
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
