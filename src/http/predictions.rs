//! `POST /v1/optics:predict`: what a pair of pictures by an optics would measure, before the rig is bought.

use axum::Json;
use axum::extract::State;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::Service;
use super::extract::Json as JsonIn;
use super::optics::{OpticsBody, rounded_mm};
use super::options::read_members;
use super::problem::{FieldError, Problem};
use crate::compute::Lane;
use crate::database::calibrations::optics_advice;
use landmarkd_core::depth::{Optics, Pair, Prediction, Scenery, predicted};

/// An optics, and what is to be measured with it.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PredictionRequest {
    #[schema(value_type = OpticsBody)]
    pub optics: Option<Map<String, Value>>,
    /// The nearest and the farthest distance that are to be measured; by default the optics' own working range.
    #[schema(required = false)]
    pub range_mm: Option<[f64; 2]>,
    /// Standard deviation of the surfaces' texture in gray levels of 255: 40 is gravel, 10 is faint.
    #[schema(required = false, default = 40.0, minimum = 0, maximum = 127.5)]
    pub contrast: Option<f64>,
    /// Standard deviation of a pixel's noise in gray levels of 255.
    #[schema(required = false, default = 1.0, minimum = 0.01, maximum = 100)]
    pub noise_sigma: Option<f64>,
}

/// What an optics would measure.
#[derive(Debug, Serialize, ToSchema)]
pub struct PredictionBody {
    /// The distance that the near-focused picture is focused at; of an aperture pair, the near end of the working range.
    pub near_focus_mm: f64,
    /// The distance that the far-focused picture is focused at; of an aperture pair, the far end of the working range.
    pub far_focus_mm: f64,
    /// The largest blur between the two.
    pub largest_blur_px: f64,
    /// The nearest and the farthest distance that would be measured at all; null if none would.
    pub working_range_mm: Option<[f64; 2]>,
    /// At distances evenly over the range that was asked for.
    pub distances: Vec<ExpectedBody>,
    /// What to change, a sentence each, for people.
    pub advice: Vec<String>,
}

/// What is expected at one distance.
#[derive(Debug, Serialize, ToSchema)]
pub struct ExpectedBody {
    pub distance_mm: f64,
    /// Diameter of the blur circle in the near-focused picture; of an aperture pair, in the wide-open one.
    pub near_blur_px: f64,
    /// Diameter of the blur circle in the far-focused picture; of an aperture pair, in the stopped-down one.
    pub far_blur_px: f64,
    /// Expected standard deviation of a distance over a window that is full of texture; null where there would be none: out
    /// of range, or an error above 2 % of the working range.
    pub sigma_mm: Option<f64>,
}

/// Distances of an answer.
const DISTANCES: usize = 41;
/// The blur that measures best, in pixels.
const BEST_BLUR_PX: f64 = 5.0;
/// The farthest focus that is advised.
const MOST_FOCUS_MM: f64 = 1e6;

/// Predict what an optics measures: the expected error by distance, the working range, and what to change for the range
/// that is wanted.
#[utoipa::path(
    post, operation_id = "predict_optics", path = "/v1/optics:predict", tag = "depth", security(("key" = ["recognise"])),
    request_body = PredictionRequest,
    responses((status = 200, body = PredictionBody))
)]
pub async fn post(
    State(service): State<Service>,
    JsonIn(body): JsonIn<Map<String, Value>>,
) -> Result<Json<PredictionBody>, Problem> {
    let Asked { optics, range_mm, scenery } = Asked::read(&body).map_err(Problem::fields)?;
    let [from, to] = range_mm.unwrap_or([optics.near_focus_mm(), optics.far_focus_mm()]);
    let distance = |at: usize| from + (to - from) * at as f64 / (DISTANCES - 1) as f64;
    let distances: Vec<f64> = (0..DISTANCES).map(distance).collect();
    let work = move || predicted(&optics, &scenery, &distances);
    let (prediction, _) = service.compute.run(Lane::Recognition, 0, work).await?;
    let advice = advice(&optics, range_mm, &scenery, &prediction);
    let narrow_first = optics.picture_names()[0] == "narrow";
    let expected = prediction.expected.iter().map(|expected| {
        let [first, second] = expected.blur_px;
        let [near_blur_px, far_blur_px] = if narrow_first { [second, first] } else { [first, second] };
        let distance_mm = rounded_mm(expected.depth_mm);
        ExpectedBody { distance_mm, near_blur_px, far_blur_px, sigma_mm: expected.sigma_mm }
    });
    Ok(Json(PredictionBody {
        near_focus_mm: rounded_mm(optics.near_focus_mm()),
        far_focus_mm: rounded_mm(optics.far_focus_mm()),
        largest_blur_px: optics.largest_blur_px(),
        working_range_mm: prediction.working_range_mm.map(|range| range.map(rounded_mm)),
        distances: expected.collect(),
        advice,
    }))
}

/// A request that can be answered.
struct Asked {
    optics: Optics,
    range_mm: Option<[f64; 2]>,
    scenery: Scenery,
}

impl Asked {
    /// Errors: every member that is missing, unknown, misshapen or impossible.
    fn read(body: &Map<String, Value>) -> Result<Asked, Vec<FieldError>> {
        let (request, mut faults) = read_members::<PredictionRequest>("", body);
        let optics = match &request.optics {
            Some(optics) => OpticsBody::read("/optics", optics).map_err(|wrong| faults.extend(wrong)).ok(),
            None if body.contains_key("optics") => None,
            None => {
                let detail = "is missing: an optics as a calibration has it".into();
                faults.push(FieldError { pointer: "/optics".into(), detail });
                None
            }
        };
        let scenery = Scenery {
            contrast: request.contrast.unwrap_or(40.0),
            noise_sigma: request.noise_sigma.unwrap_or(1.0),
        };
        let wrong = scenery.faults().into_iter();
        faults.extend(
            wrong.map(|fault| FieldError { pointer: format!("/{}", fault.field), detail: fault.message }),
        );
        if let (Some(optics), Some([from, to])) = (&optics, request.range_mm) {
            let focal_length_mm = optics.spec().focal_length_mm;
            if !(from > focal_length_mm && from < to && to.is_finite()) {
                let detail = format!(
                    "must be two distances beyond the focal length of {focal_length_mm} mm, the nearer first, not \
                     {from} and {to}"
                );
                faults.push(FieldError { pointer: "/range_mm".into(), detail });
            }
        }
        match (optics, faults.is_empty()) {
            (Some(optics), true) => Ok(Asked { optics, range_mm: request.range_mm, scenery }),
            _ => Err(faults),
        }
    }
}

/// How the whole range would be measured.
fn mended(optics: &Optics, [from, to]: [f64; 2]) -> String {
    // B(1): where both ends are sharp, and the aperture that blurs best between them.
    let spec = optics.spec();
    let f = spec.focal_length_mm;
    let [near_plane, far_plane] = [from, to].map(|u| f * u / (u - f));
    let separation_mm = near_plane - far_plane;
    // The image of an aperture pair's range ends this many separations off the sensor: next to the focus too little blur is
    // left, a fifth of the way lies between both.
    let reach = match spec.pair {
        Pair::Focal { .. } => 1.0,
        Pair::Aperture { .. } => 1.25,
    };
    let aperture_mm = BEST_BLUR_PX * spec.pixel_pitch_um / 1000.0 * f / (reach * separation_mm);
    let wide = format!(
        "an aperture of {aperture_mm:.2} mm (f/{:.1}) for a blur of {BEST_BLUR_PX} px",
        f / aperture_mm
    );
    match spec.pair {
        Pair::Focal { .. } => format!(
            "focus the near picture at {from:.0} mm and the far one at {to:.0} mm (sensors {separation_mm:.3} mm apart), \
             with {wide}."
        ),
        Pair::Aperture { .. } => {
            let focus_mm = |plane: f64| if plane > f { f * plane / (plane - f) } else { f64::INFINITY }; // B(1)
            let behind_mm = focus_mm(near_plane - reach * separation_mm);
            // No lens is focused behind a range that ends near infinity.
            let beyond = optics.picture_names()[0] == "wide" || behind_mm > MOST_FOCUS_MM;
            let [focus_mm, end_mm] =
                if beyond { [focus_mm(far_plane + reach * separation_mm), to] } else { [behind_mm, from] };
            format!(
                "focus at {focus_mm:.0} mm and end the range at {end_mm:.0} mm, the wider of the two with {wide}."
            )
        }
    }
}

/// What to change, a sentence each.
fn advice(
    optics: &Optics,
    range_mm: Option<[f64; 2]>,
    scenery: &Scenery,
    prediction: &Prediction,
) -> Vec<String> {
    let mut advice = Vec::new();
    if let Some([from, to]) = range_mm
        && prediction.expected.iter().any(|expected| expected.sigma_mm.is_none())
    {
        advice.push(format!(
            "Not all from {from:.0} to {to:.0} mm would be measured: {}",
            mended(optics, [from, to])
        ));
    }
    let worst = prediction.expected.iter().filter_map(|expected| expected.sigma_mm).fold(0.0, f64::max);
    if worst > 0.01 * optics.range_mm() || prediction.working_range_mm.is_none() {
        advice.push(format!(
            "Contrast {} against noise {} is little: more light, a longer exposure or a projected pattern help more than \
             another lens.",
            scenery.contrast, scenery.noise_sigma
        ));
    }
    advice.extend(optics_advice(optics));
    advice
}
