//! The document of object options.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::landmarks::ColourWord;
use super::present_or_null;
use crate::database::words::{AutoWord, words};
use landmarkd_core::recognition::objects::{
    AppearanceOf, Dimension, Distance, ObjectOptions, Resize, Search, Stages,
};

words!(
    /// What is compared: orientation histograms of the gradient, after the picture is aligned with the object; or gray levels, as
    /// they are.
    AppearanceWord, AppearanceOf, { Gradient, Intensity }
);
words!(
    /// What becomes of a picture of another size: it is scaled to fit, centred on black, and the answer or report says
    /// so; or it is refused.
    ResizeWord, Resize, { Fit, Never }
);
words!(
    /// Whether the universal eigenspace only proposes objects and each one's own settles which and how turned, or
    /// answers alone: for small sets.
    StagesWord, Stages, { UniversalThenObject, UniversalOnly }
);
words!(
    /// How the eigenpoints near a query are found; the answers are the same.
    SearchWord, Search, { KdTree, Slabs, Exhaustive }
);
words!(
    /// By what the universal eigenspace orders objects.
    DistanceWord, Distance, { Euclidean, Mahalanobis }
);

/// A number of coordinates, or `auto`: the least that recognises held-out views as well as any.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = DimensionBody)]
#[serde(untagged, expecting = "expected a whole number or \"auto\"")]
pub enum DimensionDocument {
    // So many coordinates.
    Number(usize),
    // Chosen in training.
    Word(AutoWord),
}

impl From<Dimension> for DimensionDocument {
    fn from(dimension: Dimension) -> Self {
        match dimension {
            Dimension::Fixed(number) => Self::Number(number),
            Dimension::Auto => Self::Word(AutoWord::Auto),
        }
    }
}

impl From<DimensionDocument> for Dimension {
    fn from(document: DimensionDocument) -> Self {
        match document {
            DimensionDocument::Number(number) => Self::Fixed(number),
            DimensionDocument::Word(AutoWord::Auto) => Self::Auto,
        }
    }
}

options_document!(
    /// Options of a database of kind `objects`.
    ObjectOptionsDocument as ObjectOptionsBody, ObjectOptions, {
        /// One that is changed brings the defaults of `smoothing`, `colour` and `accept` with it.
        #[schema(required = false)]
        #[serde(skip_serializing_if = "Option::is_none")]
        appearance: AppearanceWord,
        /// Of an appearance of gradients; gray of one of intensities.
        #[schema(required = false)]
        #[serde(skip_serializing_if = "Option::is_none")]
        colour: ColourWord,
        /// Width of the database's pictures; null, as the height then: the commonest size among the exemplars.
        #[schema(value_type = Option<usize>, minimum = 8, maximum = 1024)]
        #[serde(default, deserialize_with = "present_or_null", skip_serializing_if = "Option::is_none")]
        width_px: Option<usize>,
        /// Height of the database's pictures.
        #[schema(value_type = Option<usize>, minimum = 8, maximum = 1024)]
        #[serde(default, deserialize_with = "present_or_null", skip_serializing_if = "Option::is_none")]
        height_px: Option<usize>,
        #[schema(required = false)]
        #[serde(skip_serializing_if = "Option::is_none")]
        resize: ResizeWord,
        /// Standard deviation of the Gaussian that pictures are smoothed with, as a part of their longer side.
        #[schema(minimum = 0, maximum = 0.1)]
        smoothing: f64,
        /// Whether the object is cut out of its picture first, in training and in recognition: the largest region that
        /// stands out from the background, in the square about its centroid, on black. Pictures are then square, of 128 px
        /// unless a size is given.
        #[serde(skip_serializing_if = "Option::is_none")]
        segment: bool,
        /// Coordinates of an eigenpoint in the universal eigenspace, 1 to 256, or `auto`.
        #[schema(required = false)]
        dimension: DimensionDocument,
        #[schema(required = false)]
        stages: StagesWord,
        #[schema(required = false)]
        search: SearchWord,
        #[schema(required = false)]
        distance: DistanceWord,
        /// Part of the known objects that is to be accepted.
        #[schema(minimum = 0.5, maximum = 0.9999)]
        accept: f64,
    }
);

impl ObjectOptionsDocument {
    /// The options of a kept document: without an `appearance` it is from before there was another than of intensities.
    pub(super) fn read_kept(self) -> ObjectOptions {
        let appearance = self.appearance.map_or(AppearanceOf::Intensity, AppearanceOf::from);
        self.over(ObjectOptions::of(appearance))
    }

    /// The options `base` changed by this document: one that names another appearance brings its defaults.
    pub fn patch(self, base: ObjectOptions) -> ObjectOptions {
        let appearance = self.appearance.map_or(base.appearance, AppearanceOf::from);
        let ObjectOptions { smoothing, colour, accept, .. } = ObjectOptions::of(appearance);
        let base = match appearance == base.appearance {
            true => base,
            false => ObjectOptions { smoothing, colour, accept, ..base },
        };
        self.over(base)
    }
}

/// The document as it is kept, of which digests are made: `segment` comes before `smoothing`, and only where it is true, and
/// `appearance` and `colour` only of gradients, as digests from before they were options have it.
#[derive(Serialize)]
pub(super) struct KeptObjectOptions {
    width_px: Option<usize>,
    height_px: Option<usize>,
    resize: ResizeWord,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    segment: bool,
    #[serde(flatten)]
    rest: ObjectOptionsDocument,
}

impl From<&ObjectOptions> for KeptObjectOptions {
    fn from(options: &ObjectOptions) -> Self {
        let whole = ObjectOptionsDocument::from(options.clone());
        let rest = match options.appearance {
            AppearanceOf::Gradient => whole,
            AppearanceOf::Intensity => ObjectOptionsDocument { appearance: None, colour: None, ..whole },
        };
        Self {
            width_px: options.width_px,
            height_px: options.height_px,
            resize: options.resize.into(),
            segment: options.segment,
            rest: ObjectOptionsDocument {
                width_px: None,
                height_px: None,
                resize: None,
                segment: None,
                ..rest
            },
        }
    }
}
