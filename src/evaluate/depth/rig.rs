//! The optics and the options of a depth map as a user writes them: with the names and values of the HTTP contract.

use serde_json::{Map, Value};

use super::DepthEvaluationError;
use crate::evaluate::options::read_pair;
use crate::http::optics::OpticsBody;
use crate::http::options::DepthOptionsBody;
use landmarkd_core::depth::{DepthOptions, Optics};

/// The optics that a JSON object describes.
///
/// # Errors
/// One that can't be read, or can't be.
pub(super) fn optics_of(json: &[u8]) -> Result<Optics, DepthEvaluationError> {
    let members: Map<String, Value> =
        serde_json::from_slice(json).map_err(|source| DepthEvaluationError::OpticsFile { source })?;
    OpticsBody::read("", &members).map_err(|faults| DepthEvaluationError::Optics { faults })
}

/// The default options changed by the given `NAME=VALUE`; a value is JSON, or else a word.
///
/// # Errors
/// An option that there isn't, or a value that it can't have.
pub(super) fn options_with(given: &[String]) -> Result<DepthOptions, DepthEvaluationError> {
    let mut members = Map::new();
    for pair in given {
        let (option, value) =
            read_pair(pair).ok_or_else(|| DepthEvaluationError::NotAnOption { given: pair.clone() })?;
        members.insert(option.to_owned(), value);
    }
    match DepthOptionsBody::read(&members) {
        (options, faults) if faults.is_empty() => Ok(options),
        (_, faults) => Err(DepthEvaluationError::Options { faults }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::depth::{Median, Method, Window};

    #[test]
    fn an_optics_is_read_by_the_names_of_the_contract() {
        let usual = r#"{"focal_length_mm": 35, "f_number": 8, "near_focus_mm": 500, "plane_separation_mm": 0.4,
            "pixel_pitch_um": 10, "telecentric": true}"#;
        assert!((optics_of(usual.as_bytes()).unwrap().near_focus_mm() - 500.0).abs() < 1e-6);
        let refused =
            |from: &str, to: &str| optics_of(usual.replace(from, to).as_bytes()).unwrap_err().to_string();
        assert!(refused("\"near_focus_mm\": 500,", "").contains("near_plane_mm or near_focus_mm"));
        assert!(refused("\"f_number\": 8", "\"f_number\": 8, \"aperture_mm\": 4").contains("aperture_mm"));
        assert!(refused("\"near_focus_mm\": 500", "\"near_focus_mm\": 30").contains("near_focus_mm"));
        assert!(refused("telecentric", "telecentrical").contains("telecentrical"));
    }

    #[test]
    fn options_change_the_defaults_and_a_wrong_one_is_named() {
        let with =
            |pairs: &[&str]| options_with(&pairs.iter().map(|pair| (*pair).into()).collect::<Vec<_>>());
        assert_eq!(with(&[]).unwrap(), DepthOptions::default());
        let options =
            with(&["method=stm", "window=4.5", "align=none", "photometric=none", "median=3"]).unwrap();
        let expected = DepthOptions {
            method: Method::Stm,
            window: Window::Px(4.5),
            align: false,
            match_brightness: false,
            median: Median::Three,
        };
        assert_eq!(options, expected);
        for wrong in ["method=stereo", "window=wide", "align=yes", "median=4", "colour=1", "gram"] {
            let option = wrong.split('=').next().unwrap();
            assert!(with(&[wrong]).unwrap_err().to_string().contains(option), "{wrong}");
        }
    }
}
