//! Landmark options as they are kept.

use serde::{Deserialize, Serialize};

use super::words;
use crate::recognition::landmarks::{
    Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Taper, Viewpoint,
};

words!(Method, MethodWord, { Paper });
words!(Viewpoint, ViewpointWord, { Free });
words!(Operator, OperatorWord, { Symmetry });
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
    subwindow_radius_px: f64,
    rings: usize,
    sectors: usize,
    taper: TaperWord,
    normalise: NormaliseWord,
    colour: ColourWord,
    dimension: usize,
    neighbours: usize,
    epsilon: f64,
    per_label: PerLabelWord,
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
            subwindow_radius_px: options.subwindow_radius_px,
            rings: options.rings,
            sectors: options.sectors,
            taper: options.taper.into(),
            normalise: options.normalise.into(),
            colour: options.colour.into(),
            dimension: options.dimension,
            neighbours: options.neighbours,
            epsilon: options.epsilon,
            per_label: options.per_label.into(),
        }
    }
}

/// What is absent in a kept document: the default of the release that added the option.
impl Default for LandmarkDocument {
    fn default() -> Self {
        Self::from(&LandmarkOptions::default())
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
            subwindow_radius_px: document.subwindow_radius_px,
            rings: document.rings,
            sectors: document.sectors,
            taper: document.taper.into(),
            normalise: document.normalise.into(),
            colour: document.colour.into(),
            dimension: document.dimension,
            neighbours: document.neighbours,
            epsilon: document.epsilon,
            per_label: document.per_label.into(),
        }
    }
}
