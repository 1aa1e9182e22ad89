//! Options of a database of kind `landmarks`.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{fields, judge, readable, words};
use crate::http::problem::{Code, FieldError, Problem};
use crate::recognition::landmarks::{self, LandmarkOptions};

words!(
    /// How votes are counted: `paper` is the published method; `placement` is not in this release.
    MethodWord, landmarks::Method, { Paper }, later { Placement }
);
words!(
    /// Whether the camera may turn about its axis; `upright` is not in this release.
    ViewpointWord, landmarks::Viewpoint, { Free }, later { Upright }
);
words!(
    /// How interest points are found; only `symmetry` is in this release.
    OperatorWord, landmarks::Operator, { Symmetry }, later { Dog, Harris, Mixed }
);
words!(
    /// How a sub-window fades towards its rim: over the radius alone, or over both axes as the paper's text has it.
    TaperWord, landmarks::Taper, { Radial, Literal }
);
words!(
    /// What is made equal between sub-windows before the transform.
    NormaliseWord, landmarks::Normalise, { Contrast, Energy, None }
);
words!(
    /// Which planes signatures are taken from.
    ColourWord, landmarks::Colour, { Auto, Gray, Opponent }
);
words!(
    /// How a label's weight is made of its exemplars' weights.
    PerLabelWord, landmarks::PerLabel, { Best, Sum }
);

/// Options of a database of kind `landmarks`.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LandmarkOptionsBody {
    #[schema(required = false)]
    pub method: Option<MethodWord>,
    #[schema(required = false)]
    pub viewpoint: Option<ViewpointWord>,
    #[schema(required = false)]
    pub operator: Option<OperatorWord>,
    /// Radius of the symmetry operator.
    #[schema(minimum = 2, maximum = 16)]
    pub symmetry_radius_px: Option<usize>,
    /// Interest points an exemplar.
    #[schema(minimum = 1, maximum = 1024)]
    pub interest_points: Option<usize>,
    /// Interest points a query frame.
    #[schema(minimum = 1, maximum = 4096)]
    pub query_points: Option<usize>,
    /// Radius of a sub-window.
    #[schema(minimum = 2, maximum = 64)]
    pub subwindow_radius_px: Option<f64>,
    /// Rows of a polar sub-window.
    #[schema(minimum = 2, maximum = 64)]
    pub rings: Option<usize>,
    /// Columns of a polar sub-window.
    #[schema(minimum = 4, maximum = 128)]
    pub sectors: Option<usize>,
    #[schema(required = false)]
    pub taper: Option<TaperWord>,
    #[schema(required = false)]
    pub normalise: Option<NormaliseWord>,
    #[schema(required = false)]
    pub colour: Option<ColourWord>,
    /// Dimension of the eigenspace.
    #[schema(minimum = 1, maximum = 256)]
    pub dimension: Option<usize>,
    /// Nearest eigenpoints that get a vote of each query point.
    pub neighbours: Option<usize>,
    /// ε of the vote 1/(D+ε).
    pub epsilon: Option<f64>,
    #[schema(required = false)]
    pub per_label: Option<PerLabelWord>,
    /// Not in this release.
    pub position_prior_px: Option<f64>,
}

impl From<&LandmarkOptions> for LandmarkOptionsBody {
    fn from(options: &LandmarkOptions) -> Self {
        Self {
            method: Some(options.method.into()),
            viewpoint: Some(options.viewpoint.into()),
            operator: Some(options.operator.into()),
            symmetry_radius_px: Some(options.symmetry_radius_px),
            interest_points: Some(options.interest_points),
            query_points: Some(options.query_points),
            subwindow_radius_px: Some(options.subwindow_radius_px),
            rings: Some(options.rings),
            sectors: Some(options.sectors),
            taper: Some(options.taper.into()),
            normalise: Some(options.normalise.into()),
            colour: Some(options.colour.into()),
            dimension: Some(options.dimension),
            neighbours: Some(options.neighbours),
            epsilon: Some(options.epsilon),
            per_label: Some(options.per_label.into()),
            position_prior_px: None,
        }
    }
}

/// See [`super::over`].
pub(super) fn over(base: LandmarkOptions, body: &Map<String, Value>) -> Result<LandmarkOptions, Problem> {
    let (body, mut faults) = readable::<LandmarkOptionsBody>("/options", body);
    let mut later = Vec::new();
    let mut options = base;
    macro_rules! take_word {
        ($($field:ident),+) => {$(
            match body.$field.map(|word| word.inside()) {
                Some(Ok(value)) => options.$field = value,
                Some(Err(())) => later.push(stringify!($field)),
                None => {}
            }
        )+};
    }
    macro_rules! take {
        ($($field:ident),+) => {$( if let Some(value) = body.$field { options.$field = value; } )+};
    }
    take_word!(method, viewpoint, operator, taper, normalise, colour, per_label);
    take!(symmetry_radius_px, interest_points, query_points, subwindow_radius_px, rings, sectors, dimension);
    take!(neighbours, epsilon);
    if body.position_prior_px.is_some() {
        later.push("position_prior_px");
    }
    faults.extend(fields("/options", options.faults()));
    let later: Vec<FieldError> = later
        .into_iter()
        .map(|name| FieldError {
            pointer: format!("/options/{name}"),
            detail: "has a value that this release can't do yet".into(),
        })
        .collect();
    if !later.is_empty() && faults.is_empty() {
        let text =
            "this release has method paper, viewpoint free and operator symmetry, and no position prior";
        return Err(Problem::new(Code::NotYet, text).with_errors(later));
    }
    faults.extend(later);
    judge(faults)?;
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::problem::Code;

    fn over_default(body: Value) -> Result<LandmarkOptions, Problem> {
        over(LandmarkOptions::default(), body.as_object().unwrap())
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let body = serde_json::json!({"ringz": 3, "sectors": "many", "epsilon": -1.0, "taper": "flat", "dimension": 8});
        let problem = over_default(body).unwrap_err();
        let mut at: Vec<&str> = problem.errors.iter().map(|error| error.pointer.as_str()).collect();
        at.sort_unstable();
        assert_eq!(at, ["/options/epsilon", "/options/ringz", "/options/sectors", "/options/taper"]);
        assert_eq!(problem.code, Code::InvalidField);
    }

    #[test]
    fn what_is_absent_keeps_its_value() {
        let base = LandmarkOptions { interest_points: 16, ..Default::default() };
        let options = over(base, serde_json::json!({"dimension": 8}).as_object().unwrap()).unwrap();
        assert_eq!((options.interest_points, options.dimension), (16, 8));
    }

    #[test]
    fn words_still_to_come_are_told_apart_from_mistakes() {
        let problem = over_default(serde_json::json!({"method": "placement"})).unwrap_err();
        assert_eq!(problem.code, Code::NotYet);
        assert_eq!(problem.errors[0].pointer, "/options/method");
    }
}
