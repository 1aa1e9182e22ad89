//! Landmark options as they are kept.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::words;
use landmarkd_core::recognition::landmarks::{
    Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Taper, Viewpoint,
};

words!(Method, MethodWord, { Placement, Paper });
words!(Viewpoint, ViewpointWord, { Free, Upright });
words!(Operator, OperatorWord, { Symmetry, Harris });
words!(Taper, TaperWord, { Radial, Literal });
words!(Normalise, NormaliseWord, { Contrast, Energy, None });
words!(Colour, ColourWord, { Auto, Gray, Opponent });
words!(PerLabel, PerLabelWord, { Best, Sum });

/// The document. The order of the members is the order in the document and in digests.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct LandmarkDocument {
    method: MethodWord,
    viewpoint: ViewpointWord,
    operator: OperatorWord,
    symmetry_radius_px: usize,
    interest_points: usize,
    query_points: usize,
    #[serde(serialize_with = "write_radii", deserialize_with = "read_radii")]
    subwindow_radius_px: Vec<f64>,
    rings: usize,
    sectors: usize,
    taper: TaperWord,
    normalise: NormaliseWord,
    colour: ColourWord,
    dimension: usize,
    neighbours: usize,
    epsilon: f64,
    per_label: PerLabelWord,
    /// Left out where there is none: digests from before it was an option stay what they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    position_prior_px: Option<f64>,
}

/// One radius stands as a number, as it did before there could be several.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "subwindow_radius_px is a number, or a list of numbers")]
enum RadiiDocument {
    One(f64),
    Several(Vec<f64>),
}

fn write_radii<S: Serializer>(radii_px: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    match radii_px {
        [one] => RadiiDocument::One(*one),
        several => RadiiDocument::Several(several.to_vec()),
    }
    .serialize(serializer)
}

fn read_radii<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    Ok(match RadiiDocument::deserialize(deserializer)? {
        RadiiDocument::One(one) => vec![one],
        RadiiDocument::Several(several) => several,
    })
}

impl From<&LandmarkOptions> for LandmarkDocument {
    fn from(options: &LandmarkOptions) -> Self {
        Self {
            method: options.method.into(),
            viewpoint: options.viewpoint.into(),
            operator: options.operator.into(),
            symmetry_radius_px: options.symmetry_radius_px,
            interest_points: options.interest_points,
            query_points: options.query_points,
            subwindow_radius_px: options.subwindow_radii_px.clone(),
            rings: options.rings,
            sectors: options.sectors,
            taper: options.taper.into(),
            normalise: options.normalise.into(),
            colour: options.colour.into(),
            dimension: options.dimension,
            neighbours: options.neighbours,
            epsilon: options.epsilon,
            per_label: options.per_label.into(),
            position_prior_px: options.position_prior_px,
        }
    }
}

/// What is absent in a kept document: the default of the release that added the option. Only documents from when
/// there was no other method than the paper's lack any but the position prior.
impl Default for LandmarkDocument {
    fn default() -> Self {
        Self::from(&LandmarkOptions::of(Method::Paper, Viewpoint::Free))
    }
}

impl From<LandmarkDocument> for LandmarkOptions {
    fn from(document: LandmarkDocument) -> Self {
        Self {
            method: document.method.into(),
            viewpoint: document.viewpoint.into(),
            operator: document.operator.into(),
            symmetry_radius_px: document.symmetry_radius_px,
            interest_points: document.interest_points,
            query_points: document.query_points,
            subwindow_radii_px: document.subwindow_radius_px,
            rings: document.rings,
            sectors: document.sectors,
            taper: document.taper.into(),
            normalise: document.normalise.into(),
            colour: document.colour.into(),
            dimension: document.dimension,
            neighbours: document.neighbours,
            epsilon: document.epsilon,
            per_label: document.per_label.into(),
            position_prior_px: document.position_prior_px,
        }
    }
}
