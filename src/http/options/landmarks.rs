//! Options of a database of kind `landmarks`.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::{fields, given, judge, readable, words};
use crate::http::problem::Problem;
use landmarkd_core::recognition::landmarks::{self, LandmarkOptions, Method, Viewpoint};

words!(
    /// How matches become an answer: by agreeing on where an exemplar lies and how it is turned (`placement`), or by
    /// each point's vote for the exemplar of its nearest eigenpoint, the published method (`paper`).
    MethodWord, landmarks::Method, { Placement, Paper }
);
words!(
    /// Whether the camera may turn about its axis, or stays upright as on wheels.
    ViewpointWord, landmarks::Viewpoint, { Free, Upright }
);
words!(
    /// What draws attention: generalised symmetry, as in the paper, or corners (Harris): fewer points, on objects as
    /// good, on places not.
    OperatorWord, landmarks::Operator, { Symmetry, Harris }
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

/// A radius, or one to four different ones, the smallest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected a number, or a list of numbers")]
pub enum RadiiBody {
    One(f64),
    Several(Vec<f64>),
}

/// Options of a database of kind `landmarks`. Defaults are those of `method` and `viewpoint`: a body that names another
/// of these than the database has starts from that pair's defaults, and its other members are put over them.
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
    /// Radius of a sub-window, 2 to 64; with `placement` one to four radii, the smallest first: every point has a
    /// sub-window of each, so that what is nearer or farther away is known again.
    #[schema(required = false)]
    pub subwindow_radius_px: Option<RadiiBody>,
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
    /// Nearest eigenpoints that each sub-window of a frame is matched with; the paper's method has one.
    #[schema(minimum = 1, maximum = 64)]
    pub neighbours: Option<usize>,
    /// ε of the vote 1/(D+ε).
    pub epsilon: Option<f64>,
    #[schema(required = false)]
    pub per_label: Option<PerLabelWord>,
    /// Upright: a window is believed to be seen within some such distance of where it was; null: anywhere.
    #[schema(value_type = Option<f64>, minimum = 1, maximum = 1000)]
    #[serde(default, deserialize_with = "given")]
    pub position_prior_px: Option<Option<f64>>,
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
            subwindow_radius_px: Some(match &options.subwindow_radii_px[..] {
                [one] => RadiiBody::One(*one),
                several => RadiiBody::Several(several.to_vec()),
            }),
            rings: Some(options.rings),
            sectors: Some(options.sectors),
            taper: Some(options.taper.into()),
            normalise: Some(options.normalise.into()),
            colour: Some(options.colour.into()),
            dimension: Some(options.dimension),
            neighbours: Some(options.neighbours),
            epsilon: Some(options.epsilon),
            per_label: Some(options.per_label.into()),
            position_prior_px: Some(options.position_prior_px),
        }
    }
}

/// See [`super::over`].
pub(super) fn over(base: LandmarkOptions, body: &Map<String, Value>) -> Result<LandmarkOptions, Problem> {
    let (body, mut faults) = readable::<LandmarkOptionsBody>("/options", body);
    let method = body.method.map_or(base.method, Method::from);
    let viewpoint = body.viewpoint.map_or(base.viewpoint, Viewpoint::from);
    let mut options = match (method, viewpoint) == (base.method, base.viewpoint) {
        true => base,
        false => LandmarkOptions::of(method, viewpoint),
    };
    macro_rules! take_word {
        ($($field:ident),+) => {$( if let Some(word) = body.$field { options.$field = word.into(); } )+};
    }
    macro_rules! take {
        ($($field:ident),+) => {$( if let Some(value) = body.$field { options.$field = value; } )+};
    }
    take_word!(operator, taper, normalise, colour, per_label);
    take!(symmetry_radius_px, interest_points, query_points, rings, sectors, dimension);
    take!(neighbours, epsilon, position_prior_px);
    match body.subwindow_radius_px {
        Some(RadiiBody::One(one)) => options.subwindow_radii_px = vec![one],
        Some(RadiiBody::Several(several)) => options.subwindow_radii_px = several,
        None => {}
    }
    faults.extend(fields("/options", options.faults()));
    judge(faults)?;
    Ok(options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::http::problem::Code;
    use serde_json::json;

    fn over_default(body: Value) -> Result<LandmarkOptions, Problem> {
        over(LandmarkOptions::default(), body.as_object().unwrap())
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let body = json!({"ringz": 3, "sectors": "many", "epsilon": -1.0, "taper": "flat", "dimension": 8});
        let problem = over_default(body).unwrap_err();
        let mut at: Vec<&str> = problem.errors.iter().map(|error| error.pointer.as_str()).collect();
        at.sort_unstable();
        assert_eq!(at, ["/options/epsilon", "/options/ringz", "/options/sectors", "/options/taper"]);
        assert_eq!(problem.code, Code::InvalidField);
    }

    #[test]
    fn what_is_absent_keeps_its_value() {
        let base = LandmarkOptions { interest_points: 16, ..Default::default() };
        let options = over(base, json!({"dimension": 8}).as_object().unwrap()).unwrap();
        assert_eq!((options.interest_points, options.dimension), (16, 8));
    }

    #[test]
    fn another_method_or_viewpoint_starts_from_its_own_defaults() {
        let paper = over_default(json!({"method": "paper", "rings": 6})).unwrap();
        let expected = LandmarkOptions { rings: 6, ..LandmarkOptions::of(Method::Paper, Viewpoint::Free) };
        assert_eq!(paper, expected);
        let same = over(paper.clone(), json!({"method": "paper"}).as_object().unwrap()).unwrap();
        assert_eq!(same, paper, "what is named anew and is no other keeps the rest");
        let back = json!({"method": "placement", "viewpoint": "upright", "position_prior_px": 30});
        let upright = over(paper, back.as_object().unwrap()).unwrap();
        let defaults = LandmarkOptions::of(Method::Placement, Viewpoint::Upright);
        assert_eq!(upright, LandmarkOptions { position_prior_px: Some(30.0), ..defaults.clone() });
        let anywhere = json!({"position_prior_px": null});
        assert_eq!(over(upright, anywhere.as_object().unwrap()).unwrap(), defaults);
    }

    #[test]
    fn a_radius_or_several_are_taken_and_shown() {
        for (given, radii_px) in [(json!(7), vec![7.0]), (json!([6, 9.5]), vec![6.0, 9.5])] {
            let options = over_default(json!({"subwindow_radius_px": given})).unwrap();
            assert_eq!(options.subwindow_radii_px, radii_px);
            let shown = serde_json::to_value(LandmarkOptionsBody::from(&options)).unwrap();
            assert_eq!(shown["subwindow_radius_px"].is_array(), given.is_array(), "{shown}");
        }
        for wrong in [json!([]), json!([9, 6]), json!([1]), json!("wide"), json!([5, 6, 7, 8, 9])] {
            let problem = over_default(json!({"subwindow_radius_px": wrong})).unwrap_err();
            assert_eq!(problem.errors[0].pointer, "/options/subwindow_radius_px", "{wrong}");
        }
    }
}
