//! The optics of two pictures on the wire.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::options::read_members;
use super::problem::FieldError;
use landmarkd_core::depth::{Aperture, Fault, Optics, OpticsSpec, Pair, Sensor, StackOptics, StackSpec};

/// What is known of an aperture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ApertureWord {
    /// Nothing: it is measured from the pictures.
    Unknown,
}

/// One lens, and what the two pictures differ by. A *focal pair* (`near`, `far`) has two focus settings: exactly one of
/// `aperture_mm` and `f_number`, exactly one of `near_plane_mm` and `near_focus_mm`, and `plane_separation_mm`. An *aperture
/// pair* (`wide`, `narrow`) has one: exactly one of `apertures_mm` and `f_numbers`, exactly one of `plane_mm` and
/// `focus_mm`, and `range_end_mm`. A *focus stack* (`stack`, for depth maps alone) has three settings and more: exactly
/// one of `aperture_mm` and `f_number`, and exactly one of `planes_mm` and `focuses_mm`.
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
    /// In place of both, where the aperture or the pixel pitch isn't known, and for depth maps alone: the blur is measured
    /// from the pictures. With a pitch that is a guess, distances are right, but not x and y of points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture: Option<ApertureWord>,
    /// Distance from the lens to the sensor of the near-focused picture, the farther of the two sensors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_plane_mm: Option<f64>,
    /// The distance in the scene that the near-focused picture is focused at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub near_focus_mm: Option<f64>,
    /// Of a focal pair: how much nearer to the lens the sensor of the far-focused picture stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0.0001, maximum = 1000)]
    pub plane_separation_mm: Option<f64>,
    /// Of an aperture pair: the diameters of both apertures, in either order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub apertures_mm: Option<[f64; 2]>,
    /// Of an aperture pair: focal length over diameter of both, in either order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_numbers: Option<[f64; 2]>,
    /// Of an aperture pair: distance from the lens to the sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plane_mm: Option<f64>,
    /// Of an aperture pair: the distance in the scene that both pictures are focused at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_mm: Option<f64>,
    /// Of an aperture pair: how far its working range reaches, beyond the focus or before it. Blur is alike on both sides of
    /// the focus: what stands on the other side is measured as if it stood on this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range_end_mm: Option<f64>,
    /// Of a focus stack: distances from the lens to the sensor of each picture, the near-focused first, so falling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planes_mm: Option<Vec<f64>>,
    /// Of a focus stack: the distances in the scene that the pictures are focused at, from near to far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focuses_mm: Option<Vec<f64>>,
    /// Side of a pixel, in µm.
    #[schema(value_type = f64, minimum = 0.1, maximum = 1000)]
    pub pixel_pitch_um: Option<f64>,
    /// Whether a stop in the front focal plane keeps pictures of all focus settings at one scale.
    #[schema(value_type = bool)]
    pub telecentric: Option<bool>,
    /// Where the optical axis meets the picture; its middle by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub principal_point_px: Option<[f64; 2]>,
}

/// What a depth map may be measured with.
#[derive(Debug, Clone, PartialEq)]
pub enum Lens {
    /// Two pictures.
    Pair(Optics),
    /// Two pictures by an aperture that isn't known; the optics has one that blurs well.
    OpenPair(Optics),
    /// Three pictures and more.
    Stack(StackOptics),
}

/// The largest blur that an unknown aperture is taken to make, in pixels.
const USUAL_BLUR_PX: f64 = 5.0;
/// Members of a focal pair alone.
const FOCAL_PAIR: [&str; 6] =
    ["aperture", "near_plane_mm", "near_focus_mm", "plane_separation_mm", "aperture_mm", "f_number"];
/// Members of a focus stack alone.
const FOCUS_STACK: [&str; 2] = ["planes_mm", "focuses_mm"];
/// Why a stack is not taken.
const STACK_ELSEWHERE: &str =
    "is of a focus stack: depth maps alone measure by one, from the form's own optics";
/// Members of an aperture pair alone.
const APERTURE_PAIR: [&str; 5] = ["apertures_mm", "f_numbers", "plane_mm", "focus_mm", "range_end_mm"];

/// A distance rounded to a nanometre: what the lens law works out is not more exact, and 500 mm shall read 500.
pub fn rounded_mm(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e6
}

impl OpticsBody {
    /// Reads the optics from the members of the object at the JSON pointer `at`.
    ///
    /// # Errors
    /// Every member that is missing, unknown, misshapen or impossible; an aperture that isn't known.
    pub fn read(at: &str, body: &Map<String, Value>) -> Result<Optics, Vec<FieldError>> {
        let (field, detail) = match Self::read_lens(at, body)? {
            Lens::Pair(optics) => return Ok(optics),
            Lens::OpenPair(_) => (
                "aperture",
                "is needed here: a depth map of a textured scene measures it, and answers aperture_mm",
            ),
            Lens::Stack(_) if sent(body, "planes_mm") => ("planes_mm", STACK_ELSEWHERE),
            Lens::Stack(_) => ("focuses_mm", STACK_ELSEWHERE),
        };
        Err(vec![FieldError { pointer: format!("{at}/{field}"), detail: detail.into() }])
    }

    /// The same of everything that a depth map may be measured with.
    ///
    /// # Errors
    /// Every member that is missing, unknown, misshapen or impossible.
    pub fn read_lens(at: &str, body: &Map<String, Value>) -> Result<Lens, Vec<FieldError>> {
        let members = body;
        let sent = |field: &str| sent(members, field);
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
        let is_aperture_pair = APERTURE_PAIR.iter().any(|field| sent(field));
        let is_stack = FOCUS_STACK.iter().any(|field| sent(field));
        let range_mm = match (is_aperture_pair, is_stack) {
            (true, _) => required("range_end_mm", body.range_end_mm),
            (false, true) => 0.0,
            (false, false) => required("plane_separation_mm", body.plane_separation_mm),
        };
        let pixel_pitch_um = required("pixel_pitch_um", body.pixel_pitch_um);
        if body.telecentric.is_none() {
            fault("telecentric", "is missing: say true for a stop in the front focal plane, else false");
        }
        let alien: &[&str] = match (is_aperture_pair, is_stack) {
            (true, true) => &[FOCAL_PAIR.as_slice(), &FOCUS_STACK].concat(),
            (true, false) => &FOCAL_PAIR,
            (false, true) => &FOCAL_PAIR[..4],
            (false, false) => &[],
        };
        for field in alien.iter().filter(|field| sent(field)) {
            fault(field, "doesn't go with the others: they are of pictures that differ otherwise");
        }
        let aperture_known = body.aperture.is_none();
        for field in ["aperture_mm", "f_number"].into_iter().filter(|field| !aperture_known && sent(field)) {
            fault(field, "and an unknown aperture exclude each other: leave one out");
        }
        // Unknown, it is as wide as blurs well; `valid` leaves out what is wrong with it if one of these lengths is.
        let usual_mm = USUAL_BLUR_PX * pixel_pitch_um / 1000.0 * focal_length_mm / range_mm;
        let mut one_of = |[a, b]: [&str; 2], given: [bool; 2]| match given {
            [true, true] => {
                fault(a, &format!("and {b} exclude each other: give one"));
                fault(b, &format!("and {a} exclude each other: give one"));
            }
            // Either may be the one that was sent and can't be read.
            [false, false] if [a, b].iter().all(|field| !misshapen.contains(&format!("{at}/{field}"))) => {
                fault(a, &format!("is missing: give {a} or {b}"));
            }
            _ => {}
        };
        let of_either = |number: Option<f64>, diameter_mm: Option<f64>| match (diameter_mm, number) {
            (None, Some(number)) => Aperture::FNumber(number),
            (diameter_mm, _) => Aperture::DiameterMm(diameter_mm.unwrap_or_default()),
        };
        let placed = |focus_mm: Option<f64>, plane_mm: Option<f64>| match (plane_mm, focus_mm) {
            (None, Some(mm)) => Sensor::FocusMm(mm),
            (mm, _) => Sensor::PlaneMm(mm.unwrap_or_default()),
        };
        if is_stack && !is_aperture_pair {
            one_of(["aperture_mm", "f_number"], [body.aperture_mm.is_some(), body.f_number.is_some()]);
            one_of(["planes_mm", "focuses_mm"], [body.planes_mm.is_some(), body.focuses_mm.is_some()]);
            let planes = body.planes_mm.iter().flatten().map(|&mm| Sensor::PlaneMm(mm));
            let focuses = body.focuses_mm.iter().flatten().map(|&mm| Sensor::FocusMm(mm));
            let described = StackOptics::new(&StackSpec {
                focal_length_mm,
                aperture: of_either(body.f_number, body.aperture_mm),
                sensors: planes.chain(focuses).collect(),
                pixel_pitch_um,
                telecentric: body.telecentric.unwrap_or_default(),
                principal_point_px: body.principal_point_px,
            });
            // A list without settings doesn't say of what kind they are.
            let field = if sent("planes_mm") { "planes_mm" } else { "focuses_mm" };
            let of_sent = |fault: Fault| match fault.field {
                "planes_mm" | "focuses_mm" => Fault { field, ..fault },
                _ => fault,
            };
            let described = described.map_err(|wrong| wrong.into_iter().map(of_sent).collect());
            return valid(described.map(Lens::Stack), faults, at, members);
        }
        let pair = if is_aperture_pair {
            one_of(["apertures_mm", "f_numbers"], [body.apertures_mm.is_some(), body.f_numbers.is_some()]);
            one_of(["plane_mm", "focus_mm"], [body.plane_mm.is_some(), body.focus_mm.is_some()]);
            let apertures = [0, 1].map(|k| {
                of_either(body.f_numbers.map(|numbers| numbers[k]), body.apertures_mm.map(|mm| mm[k]))
            });
            Pair::Aperture { apertures, sensor: placed(body.focus_mm, body.plane_mm), range_end_mm: range_mm }
        } else {
            if aperture_known {
                one_of(["aperture_mm", "f_number"], [body.aperture_mm.is_some(), body.f_number.is_some()]);
            }
            one_of(
                ["near_plane_mm", "near_focus_mm"],
                [body.near_plane_mm.is_some(), body.near_focus_mm.is_some()],
            );
            Pair::Focal {
                aperture: match aperture_known {
                    true => of_either(body.f_number, body.aperture_mm),
                    false => Aperture::DiameterMm(usual_mm),
                },
                near_sensor: placed(body.near_focus_mm, body.near_plane_mm),
                plane_separation_mm: range_mm,
            }
        };
        let spec = OpticsSpec {
            focal_length_mm,
            pair,
            pixel_pitch_um,
            telecentric: body.telecentric.unwrap_or_default(),
            principal_point_px: body.principal_point_px,
        };
        let lens = if aperture_known { Lens::Pair } else { Lens::OpenPair };
        let described = Optics::new(&spec).map_err(|wrong| match (body.plane_mm, wrong.as_slice()) {
            // What is said of the sensor and the range together is the sensor's fault alone.
            (Some(mm), [sensor, range]) if mm <= focal_length_mm && sensor.message == range.message => {
                let message = format!(
                    "must exceed the focal length of {focal_length_mm} mm, not be {mm}: a sensor there is focused on \
                     nothing"
                );
                vec![Fault { field: "plane_mm", message }]
            }
            _ => wrong,
        });
        valid(described.map(lens), faults, at, members)
    }
}

/// Whether a member was sent.
fn sent(members: &Map<String, Value>, field: &str) -> bool {
    members.get(field).is_some_and(|value| !value.is_null())
}

/// What is described, if nothing is wrong with its members.
fn valid(
    described: Result<Lens, Vec<Fault>>,
    mut faults: Vec<FieldError>,
    at: &str,
    members: &Map<String, Value>,
) -> Result<Lens, Vec<FieldError>> {
    let impossible = match described {
        Ok(lens) if faults.is_empty() => return Ok(lens),
        described => described.err().unwrap_or_default(),
    };
    let is_alone = faults.is_empty() && impossible.len() == 1;
    let mut unsent = Vec::new();
    for fault in impossible {
        let open = fault.field == "aperture_mm" && sent(members, "aperture");
        let field = if open { "aperture" } else { fault.field };
        let pointer = format!("{at}/{field}");
        // An aperture that isn't known is worked out from other lengths: what is wrong may be one of those.
        if open && !is_alone || faults.iter().any(|fault| fault.pointer == pointer) {
            continue;
        }
        // What is absent, or can't be read, has a value in the description that nobody sent.
        let list = if sent(members, field) { &mut faults } else { &mut unsent };
        list.push(FieldError { pointer, detail: fault.message });
    }
    Err(if faults.is_empty() { unsent } else { faults })
}

impl From<&Optics> for OpticsBody {
    fn from(optics: &Optics) -> Self {
        let spec = optics.spec();
        let lens = Self {
            focal_length_mm: Some(spec.focal_length_mm),
            pixel_pitch_um: Some(spec.pixel_pitch_um),
            telecentric: Some(spec.telecentric),
            principal_point_px: spec.principal_point_px,
            ..Self::default()
        };
        let f = spec.focal_length_mm;
        match spec.pair {
            Pair::Focal { aperture, near_sensor, plane_separation_mm } => Self {
                aperture_mm: Some(aperture.diameter_mm(f)),
                near_plane_mm: near_sensor.plane_mm(f),
                plane_separation_mm: Some(plane_separation_mm),
                ..lens
            },
            Pair::Aperture { apertures, sensor, range_end_mm } => Self {
                apertures_mm: Some(apertures.map(|aperture| aperture.diameter_mm(f))),
                plane_mm: sensor.plane_mm(f),
                range_end_mm: Some(range_end_mm),
                ..lens
            },
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

    #[test]
    fn a_stack_may_span_more_blur_than_a_pair() {
        let planes_mm: Vec<f64> = (0..16).map(|at| 50.0 - 0.656 * f64::from(at)).collect();
        let body = json!({
            "focal_length_mm": 35, "f_number": 8, "planes_mm": planes_mm, "pixel_pitch_um": 10, "telecentric": true,
        });
        let Ok(Lens::Stack(optics)) = OpticsBody::read_lens("", body.as_object().unwrap()) else {
            panic!("16 pictures of 8.2 px a pair are refused");
        };
        assert!((optics.whole().largest_blur_px() - 123.0).abs() < 0.1 && optics.pairs().len() == 15);
    }

    #[test]
    fn what_follows_from_a_missing_length_is_no_fault_of_its_own() {
        let open = |members: Value| {
            let mut body = with(json!({"f_number": null, "aperture": "unknown"}));
            body.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
            body
        };
        assert_eq!(pointers(open(json!({"pixel_pitch_um": null}))), ["pixel_pitch_um"]);
        assert_eq!(pointers(open(json!({"plane_separation_mm": null}))), ["plane_separation_mm"]);
        let stack = |members: Value| {
            let mut body = with(json!({"near_focus_mm": null, "plane_separation_mm": null}));
            body.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
            body
        };
        let focuses_mm = json!([500, 600, 700]);
        assert_eq!(
            pointers(stack(json!({"focuses_mm": focuses_mm, "focal_length_mm": null}))),
            ["focal_length_mm"]
        );
        assert_eq!(
            pointers(stack(json!({"focuses_mm": focuses_mm, "focal_length_mm": -25}))),
            ["focal_length_mm"]
        );
        assert_eq!(pointers(stack(json!({"planes_mm": []}))), ["planes_mm"]);
        assert_eq!(pointers(stack(json!({"focuses_mm": []}))), ["focuses_mm"]);
        let sensor = json!({
            "f_number": null, "near_focus_mm": null, "plane_separation_mm": null, "f_numbers": [2.8, 8], "plane_mm": 20,
            "range_end_mm": 540,
        });
        assert_eq!(pointers(with(sensor)), ["plane_mm"], "within the focal length");
    }
}
