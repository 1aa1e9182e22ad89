//! The optics and the options of a depth map as a user writes them.

use serde::Deserialize;

use super::DepthEvaluationError;
use landmarkd_core::depth::{Aperture, DepthOptions, Median, Method, NearSensor, Optics, OpticsSpec, Window};

/// An optics in a file, with the names of the HTTP contract.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OpticsFile {
    focal_length_mm: f64,
    aperture_mm: Option<f64>,
    f_number: Option<f64>,
    near_plane_mm: Option<f64>,
    near_focus_mm: Option<f64>,
    plane_separation_mm: f64,
    pixel_pitch_um: f64,
    telecentric: bool,
    principal_point_px: Option<[f64; 2]>,
}

/// The optics that a JSON object describes.
///
/// # Errors
/// One that can't be read, or can't be.
pub(super) fn optics_of(json: &[u8]) -> Result<Optics, DepthEvaluationError> {
    let file: OpticsFile =
        serde_json::from_slice(json).map_err(|source| DepthEvaluationError::OpticsFile { source })?;
    let one_of = |names| DepthEvaluationError::OneOf { names };
    let spec = OpticsSpec {
        focal_length_mm: file.focal_length_mm,
        aperture: match (file.aperture_mm, file.f_number) {
            (Some(mm), None) => Aperture::DiameterMm(mm),
            (None, Some(number)) => Aperture::FNumber(number),
            _ => return Err(one_of("aperture_mm and f_number")),
        },
        near_sensor: match (file.near_plane_mm, file.near_focus_mm) {
            (Some(mm), None) => NearSensor::PlaneMm(mm),
            (None, Some(mm)) => NearSensor::FocusMm(mm),
            _ => return Err(one_of("near_plane_mm and near_focus_mm")),
        },
        plane_separation_mm: file.plane_separation_mm,
        pixel_pitch_um: file.pixel_pitch_um,
        telecentric: file.telecentric,
        principal_point_px: file.principal_point_px,
    };
    Optics::new(&spec).map_err(|faults| DepthEvaluationError::Optics { faults })
}

/// The default options with the given `NAME=VALUE` laid over them.
///
/// # Errors
/// An option that there isn't, or a value that it can't have.
pub(super) fn options_with(given: &[String]) -> Result<DepthOptions, DepthEvaluationError> {
    let mut options = DepthOptions::default();
    let switch = |value: &str| match value {
        "auto" => Some(true),
        "none" => Some(false),
        _ => None,
    };
    for pair in given {
        let wrong = |expected| DepthEvaluationError::Option { given: pair.clone(), expected };
        let (name, value) = pair.split_once('=').ok_or_else(|| wrong("NAME=VALUE"))?;
        match name {
            "method" => {
                options.method = match value {
                    "gram" => Method::Gram,
                    "stm" => Method::Stm,
                    "laplacian" => Method::Laplacian,
                    _ => return Err(wrong("gram, stm or laplacian")),
                }
            }
            "window" if value == "auto" => options.window = Window::Auto,
            "window" => options.window = Window::Px(value.parse().map_err(|_| wrong("auto or pixels"))?),
            "align" => options.align = switch(value).ok_or_else(|| wrong("auto or none"))?,
            "photometric" => options.match_brightness = switch(value).ok_or_else(|| wrong("auto or none"))?,
            "median" => {
                options.median = match value {
                    "0" => Median::None,
                    "3" => Median::Three,
                    "5" => Median::Five,
                    _ => return Err(wrong("0, 3 or 5")),
                }
            }
            _ => return Err(wrong("one of method, window, align, photometric, median")),
        }
    }
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_optics_is_read_by_the_names_of_the_contract() {
        let usual = r#"{"focal_length_mm": 35, "f_number": 8, "near_focus_mm": 500, "plane_separation_mm": 0.4,
            "pixel_pitch_um": 10, "telecentric": true}"#;
        assert!((optics_of(usual.as_bytes()).unwrap().near_focus_mm() - 500.0).abs() < 1e-6);
        let refused =
            |from: &str, to: &str| optics_of(usual.replace(from, to).as_bytes()).unwrap_err().to_string();
        assert!(refused("\"near_focus_mm\": 500,", "").contains("near_plane_mm and near_focus_mm"));
        assert!(refused("\"f_number\": 8", "\"f_number\": 8, \"aperture_mm\": 4").contains("aperture_mm"));
        assert!(refused("\"near_focus_mm\": 500", "\"near_focus_mm\": 30").contains("near_focus_mm"));
        assert!(refused("telecentric", "telecentrical").contains("optics"));
    }

    #[test]
    fn options_are_laid_over_the_defaults_and_a_wrong_one_is_named() {
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
            assert!(with(&[wrong]).unwrap_err().to_string().contains(wrong), "{wrong}");
        }
    }
}
