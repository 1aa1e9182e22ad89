//! The document of landmark options.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::present_or_null;
use crate::database::words::words;
use landmarkd_core::recognition::landmarks::{
    Colour, LandmarkOptions, Method, Normalise, Operator, PerLabel, Preset, Signature, Taper, Viewpoint,
};

words!(
    /// How matches become an answer: by agreeing on where an exemplar lies and how it is turned (`placement`), or by
    /// each point's vote for the exemplar of its nearest eigenpoint, the published method (`paper`).
    MethodWord, Method, { Placement, Paper }
);
words!(
    /// Whether the camera may turn about its axis, or stays upright as on wheels.
    ViewpointWord, Viewpoint, { Free, Upright }
);
words!(
    /// What draws attention: generalised symmetry, as in the paper, or corners (Harris), the default of upright places with
    /// gradient signatures.
    OperatorWord, Operator, { Symmetry, Harris }
);
words!(
    /// How a sub-window fades towards its rim: over the radius alone, or over both axes as the paper's text has it.
    TaperWord, Taper, { Radial, Literal }
);
words!(
    /// What is made equal between sub-windows before the transform.
    NormaliseWord, Normalise, { Contrast, Energy, None }
);
words!(
    /// Which planes signatures are taken from.
    ColourWord, Colour, { Auto, Gray, Opponent }
);
words!(
    /// How a label's weight is made of its exemplars' weights.
    PerLabelWord, PerLabel, { Best, Sum }
);

words!(
    /// What signatures are made of: the directions of the gradient in windows of a scale space (`gradient`), or the
    /// intensities of windows of one to four radii (`intensity`), as the paper has it.
    SignatureWord, Signature, { Gradient, Intensity }
);

words!(
    /// What the database is for: places seen by a camera on wheels (`rooms`), things turned as they may be (`things`), or
    /// flat ones such as pictures and boxes (`flat`, which needs no other options than `things`).
    PresetWord, Preset, { Rooms, Things, Flat }
);

/// A radius, or one to four different ones, the smallest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RadiiBody)]
#[serde(untagged, expecting = "expected a number, or a list of numbers")]
pub enum RadiiDocument {
    // One radius, in pixels.
    One(f64),
    // Several radii, in pixels.
    Several(Vec<f64>),
}

impl From<Vec<f64>> for RadiiDocument {
    fn from(radii_px: Vec<f64>) -> Self {
        match radii_px[..] {
            [one] => Self::One(one),
            _ => Self::Several(radii_px),
        }
    }
}

impl From<RadiiDocument> for Vec<f64> {
    fn from(document: RadiiDocument) -> Self {
        match document {
            RadiiDocument::One(one) => vec![one],
            RadiiDocument::Several(several) => several,
        }
    }
}

// The order of the members is their order in kept documents, of which digests are made.
options_document!(
    /// Options of a database of kind `landmarks`. Defaults are those of `method`, `viewpoint` and `signature`: a body that
    /// names another of these than the database has starts from their defaults, and its other members are put over them.
    /// A body that names `rings`, `sectors`, `normalise`, `position_prior_px` or several radii and no `signature` means
    /// signatures of intensity.
    LandmarkOptionsDocument as LandmarkOptionsBody, LandmarkOptions, {
        #[schema(required = false)]
        method: MethodWord,
        #[schema(required = false)]
        viewpoint: ViewpointWord,
        #[schema(required = false)]
        operator: OperatorWord,
        /// Radius of the symmetry operator.
        #[schema(minimum = 2, maximum = 16)]
        symmetry_radius_px: usize,
        /// Interest points an exemplar.
        #[schema(minimum = 1, maximum = 1024)]
        interest_points: usize,
        /// Interest points a query frame.
        #[schema(minimum = 1, maximum = 4096)]
        query_points: usize,
        /// Radius of a sub-window, 2 to 64; with `placement` one to four radii, the smallest first: every point has a
        /// sub-window of each, so that what is nearer or farther away is known again.
        #[schema(required = false)]
        #[serde(rename = "subwindow_radius_px")]
        subwindow_radii_px: RadiiDocument,
        /// Rows of a polar sub-window.
        #[schema(minimum = 2, maximum = 64)]
        rings: usize,
        /// Columns of a polar sub-window.
        #[schema(minimum = 4, maximum = 128)]
        sectors: usize,
        #[schema(required = false)]
        taper: TaperWord,
        #[schema(required = false)]
        normalise: NormaliseWord,
        #[schema(required = false)]
        colour: ColourWord,
        /// Dimension of the eigenspace.
        #[schema(minimum = 1, maximum = 256)]
        dimension: usize,
        /// Nearest eigenpoints that each sub-window of a frame is matched with; the paper's method has one.
        #[schema(minimum = 1, maximum = 64)]
        neighbours: usize,
        /// ε of the vote 1/(D+ε).
        epsilon: f64,
        #[schema(required = false)]
        per_label: PerLabelWord,
        /// Upright: a window is believed to be seen within some such distance of where it was; null: anywhere.
        #[schema(value_type = Option<f64>, minimum = 1, maximum = 1000)]
        #[serde(default, deserialize_with = "present_or_null", skip_serializing_if = "Option::is_none")]
        position_prior_px: Option<f64>,
        #[schema(required = false)]
        #[serde(skip_serializing_if = "Option::is_none")]
        signature: SignatureWord,
        /// Larger pictures are brought to so many pixels on their longer side, in training and asking alike; answers are in
        /// pixels of the picture as it was posted. Null: pictures are taken as they are.
        #[schema(value_type = Option<u32>, minimum = 160, maximum = 4096)]
        #[serde(default, deserialize_with = "present_or_null", skip_serializing_if = "Option::is_none")]
        working_size_px: Option<usize>,
        /// Gradient: levels of the scale space for each halving of the picture.
        #[schema(minimum = 1, maximum = 4)]
        #[serde(skip_serializing_if = "Option::is_none")]
        levels_per_octave: usize,
        /// Gradient: what is turned by more is left out; null: any turn.
        #[schema(value_type = Option<f64>, minimum = 1, maximum = 180)]
        #[serde(default, deserialize_with = "present_or_null", skip_serializing_if = "Option::is_none")]
        turn_prior_deg: Option<f64>,
        /// Gradient: the part of frames of something unknown that may be answered.
        #[schema(minimum = 1e-9, maximum = 1)]
        #[serde(skip_serializing_if = "Option::is_none")]
        false_alarms: f64,
    },
    in requests: {
        /// Starts from the options that go with it, whatever the database's are; other members are put over them. Answers have
        /// the options that it stands for.
        #[schema(required = false)]
        preset: PresetWord,
    }
);

impl LandmarkOptionsDocument {
    /// The document as it is kept: without what is null, and with signatures of intensity without the options of
    /// gradients, as digests from before they were options have it.
    pub(super) fn kept(options: &LandmarkOptions) -> Self {
        let whole = Self {
            position_prior_px: options.position_prior_px.map(Some),
            working_size_px: options.working_size_px.map(Some),
            turn_prior_deg: options.turn_prior_deg.map(Some),
            ..options.clone().into()
        };
        match options.signature {
            Signature::Gradient => whole,
            Signature::Intensity => {
                Self { signature: None, levels_per_octave: None, false_alarms: None, ..whole }
            }
        }
    }

    /// The options of a kept document. What is absent is the paper's: only documents from when there was no other
    /// method lack any member but those that are null, and those of gradients.
    pub(super) fn read_kept(self) -> LandmarkOptions {
        self.over(LandmarkOptions::of(Method::Paper, Viewpoint::Free))
    }

    /// Whether it names an option that gradient signatures don't have.
    fn names_intensity(&self) -> bool {
        self.rings.is_some()
            || self.sectors.is_some()
            || self.normalise.is_some()
            || self.position_prior_px.flatten().is_some()
            || matches!(self.subwindow_radii_px, Some(RadiiDocument::Several(_)))
    }

    /// The options `base`, or those of the preset, changed by this document: one that names another method, viewpoint or signature starts from
    /// the defaults of these. Options that only signatures of intensity have imply these.
    pub fn patch(self, base: LandmarkOptions) -> LandmarkOptions {
        let base = self.preset.map_or(base, |preset| Preset::from(preset).options());
        let method = self.method.map_or(base.method, Method::from);
        let viewpoint = self.viewpoint.map_or(base.viewpoint, Viewpoint::from);
        let of_method = if method == base.method {
            base.signature
        } else {
            LandmarkOptions::of(method, viewpoint).signature
        };
        let of_options = if self.names_intensity() { Signature::Intensity } else { of_method };
        let signature = self.signature.map_or(of_options, Signature::from);
        let same = (method, viewpoint, signature) == (base.method, base.viewpoint, base.signature);
        self.over(if same { base } else { LandmarkOptions::with_signature(method, viewpoint, signature) })
    }
}
