//! The optics of a focal pair on the wire.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::options::read_members;
use super::problem::FieldError;
use landmarkd_core::depth::{Aperture, NearSensor, Optics, OpticsSpec};

/// One lens before two sensors. Exactly one of `aperture_mm` and `f_number`, and exactly one of `near_plane_mm` and
/// `near_focus_mm`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct OpticsBody {
    #[schema(value_type = f64, minimum = 0.1, maximum = 10000)]
    pub focal_length_mm: Option<f64>,
    /// Diameter of the aperture.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.01, maximum = 10000)]
    pub aperture_mm: Option<f64>,
    /// Focal length over diameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.01, maximum = 10000)]
    pub f_number: Option<f64>,
    /// Distance from the lens to the sensor of the near-focused picture, the farther of the two sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_plane_mm: Option<f64>,
    /// The distance in the scene that the near-focused picture is focused at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_focus_mm: Option<f64>,
    /// How much nearer to the lens the sensor of the far-focused picture stands.
    #[schema(value_type = f64, minimum = 0.0001, maximum = 1000)]
    pub plane_separation_mm: Option<f64>,
    /// Side of a pixel, in µm.
    #[schema(value_type = f64, minimum = 0.1, maximum = 1000)]
    pub pixel_pitch_um: Option<f64>,
    /// Whether a stop in the front focal plane keeps both pictures at one scale.
    #[schema(value_type = bool)]
    pub telecentric: Option<bool>,
    /// Where the optical axis meets the picture; its middle by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub principal_point_px: Option<[f64; 2]>,
}

/// A distance rounded to a nanometre: what the lens law works out is not more exact, and 500 mm shall read 500.
pub fn rounded_mm(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6
}

impl OpticsBody {
    /// Reads the optics from the members of the object at the JSON pointer `at`.
    ///
    /// # Errors
    /// Every member that is missing, unknown, misshapen or impossible.
    pub fn read(at: &str, body: &Map<String, Value>) -> Result<Optics, Vec<FieldError>> {
        let sent = |field: &str| body.get(field).is_some_and(|value| !value.is_null());
        let (body, mut faults) = read_members::<Self>(at, body);
        let misshapen: Vec<String> = faults.iter().map(|fault| fault.pointer.clone()).collect();
        let mut fault = |field: &str, detail: &str| {
            let pointer = format!("{at}/{field}");
            // A member that was sent and can't be read has a fault already: it isn't missing.
            if !misshapen.contains(&pointer) {
                faults.push(FieldError { pointer, detail: detail.into() });
            }
        };
        let mut required = |field: &str, value: Option<f64>| {
            if value.is_none() {
                fault(field, "is missing");
            }
            value.unwrap_or_default()
        };
        let focal_length_mm = required("focal_length_mm", body.focal_length_mm);
        let plane_separation_mm = required("plane_separation_mm", body.plane_separation_mm);
        let pixel_pitch_um = required("pixel_pitch_um", body.pixel_pitch_um);
        if body.telecentric.is_none() {
            fault("telecentric", "is missing: say true for a stop in the front focal plane, else false");
        }
        let mut one_of = |[a, b]: [&str; 2], values: [Option<f64>; 2]| match values {
            [Some(_), Some(_)] => {
                fault(a, &format!("and {b} exclude each other: give one"));
                fault(b, &format!("and {a} exclude each other: give one"));
            }
            // Either may be the one that was sent and can't be read.
            [None, None] if [a, b].iter().all(|field| !misshapen.contains(&format!("{at}/{field}"))) => {
                fault(a, &format!("is missing: give {a} or {b}"));
            }
            _ => {}
        };
        one_of(["aperture_mm", "f_number"], [body.aperture_mm, body.f_number]);
        one_of(["near_plane_mm", "near_focus_mm"], [body.near_plane_mm, body.near_focus_mm]);
        let aperture = match (body.aperture_mm, body.f_number) {
            (None, Some(number)) => Aperture::FNumber(number),
            (diameter_mm, _) => Aperture::DiameterMm(diameter_mm.unwrap_or_default()),
        };
        let near_sensor = match (body.near_plane_mm, body.near_focus_mm) {
            (None, Some(mm)) => NearSensor::FocusMm(mm),
            (mm, _) => NearSensor::PlaneMm(mm.unwrap_or_default()),
        };
        let spec = OpticsSpec {
            focal_length_mm,
            aperture,
            near_sensor,
            plane_separation_mm,
            pixel_pitch_um,
            telecentric: body.telecentric.unwrap_or_default(),
            principal_point_px: body.principal_point_px,
        };
        let described = Optics::new(&spec);
        if faults.is_empty()
            && let Ok(optics) = described
        {
            return Ok(optics);
        }
        for impossible in described.err().unwrap_or_default() {
            let pointer = format!("{at}/{}", impossible.field);
            // What is absent, or can't be read, has a value in the description that nobody sent.
            if sent(impossible.field) && !faults.iter().any(|fault| fault.pointer == pointer) {
                faults.push(FieldError { pointer, detail: impossible.message });
            }
        }
        Err(faults)
    }
}

impl From<&Optics> for OpticsBody {
    fn from(optics: &Optics) -> Self {
        let spec = optics.spec();
        let (aperture_mm, f_number) = match spec.aperture {
            Aperture::DiameterMm(mm) => (Some(mm), None),
            Aperture::FNumber(number) => (None, Some(number)),
        };
        let (near_plane_mm, near_focus_mm) = match spec.near_sensor {
            NearSensor::PlaneMm(mm) => (Some(mm), None),
            NearSensor::FocusMm(mm) => (None, Some(mm)),
        };
        Self {
            focal_length_mm: Some(spec.focal_length_mm),
            aperture_mm,
            f_number,
            near_plane_mm,
            near_focus_mm,
            plane_separation_mm: Some(spec.plane_separation_mm),
            pixel_pitch_um: Some(spec.pixel_pitch_um),
            telecentric: Some(spec.telecentric),
            principal_point_px: spec.principal_point_px,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn read(body: Value) -> Result<Optics, Vec<FieldError>> {
        OpticsBody::read("/optics", body.as_object().unwrap())
    }

    #[track_caller]
    fn pointers(body: Value) -> Vec<String> {
        let mut at: Vec<String> = read(body).unwrap_err().into_iter().map(|fault| fault.pointer).collect();
        at.sort_unstable();
        at.iter().map(|at| at.strip_prefix("/optics/").unwrap().to_owned()).collect()
    }

    fn usual() -> Value {
        json!({
            "focal_length_mm": 25, "f_number": 2.8, "near_focus_mm": 529, "plane_separation_mm": 0.37,
            "pixel_pitch_um": 29, "telecentric": true,
        })
    }

    fn with(members: Value) -> Value {
        let mut body = usual();
        body.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        body
    }

    #[test]
    fn both_ways_of_saying_it_are_the_same_optics() {
        let optics = read(usual()).unwrap();
        assert!((optics.near_focus_mm() - 529.0).abs() < 1e-6);
        let written = serde_json::to_value(OpticsBody::from(&optics)).unwrap();
        let again = read(written).unwrap();
        assert!((again.near_focus_mm() - 529.0).abs() < 1e-6 && again.spec() == optics.spec());
    }

    #[test]
    fn one_of_two_is_neither_both_nor_none() {
        assert_eq!(pointers(with(json!({"aperture_mm": 9}))), ["aperture_mm", "f_number"]);
        assert_eq!(pointers(with(json!({"near_plane_mm": 26}))), ["near_focus_mm", "near_plane_mm"]);
        assert_eq!(
            pointers(with(json!({"f_number": null, "near_focus_mm": null}))),
            ["aperture_mm", "near_plane_mm"]
        );
        assert_eq!(pointers(with(json!({"f_number": "2.8"}))), ["f_number"], "what was sent isn't missing");
    }

    #[test]
    fn what_is_missing_unknown_and_impossible_is_named_at_once() {
        let nothing = [
            "aperture_mm",
            "focal_length_mm",
            "near_plane_mm",
            "pixel_pitch_um",
            "plane_separation_mm",
            "telecentric",
        ];
        assert_eq!(pointers(json!({})), nothing);
        let body =
            with(json!({"focal_length_mm": -25, "pixel_pitch_um": 0, "colour": "red", "telecentric": null}));
        assert_eq!(pointers(body), ["colour", "focal_length_mm", "pixel_pitch_um", "telecentric"]);
        assert_eq!(
            pointers(with(json!({"near_focus_mm": 20}))),
            ["near_focus_mm"],
            "within the focal length"
        );
    }
}
