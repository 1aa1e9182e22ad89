//! The document of segmentation options.

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use crate::database::words::words;
use landmarkd_core::vision::segmentation::{Polarity, SegmentationOptions, Threshold};

words!(
    /// What objects look like: lighter or darker than the background or of another colour; lighter; darker.
    PolarityWord, Polarity, { Either, LightOnDark, DarkOnLight }
);

/// `adaptive`: the mean of the background around each pixel, and an offset. `otsu`: one level for the picture, which
/// tells two classes of pixels best apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ThresholdWord {
    /// [`Threshold::Adaptive`].
    Adaptive,
    /// [`Threshold::Otsu`].
    Otsu,
}

/// A grey level, 0 to 255, or by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ThresholdBody)]
#[serde(untagged, expecting = "expected a number of 0 to 255, \"adaptive\" or \"otsu\"")]
pub enum ThresholdDocument {
    // A gray level, 0 to 255.
    Level(f64),
    // How the level is chosen.
    Word(ThresholdWord),
}

impl From<Threshold> for ThresholdDocument {
    fn from(threshold: Threshold) -> Self {
        match threshold {
            Threshold::Adaptive => Self::Word(ThresholdWord::Adaptive),
            Threshold::Otsu => Self::Word(ThresholdWord::Otsu),
            Threshold::Fixed(level) => Self::Level(level),
        }
    }
}

impl From<ThresholdDocument> for Threshold {
    fn from(document: ThresholdDocument) -> Self {
        match document {
            ThresholdDocument::Word(ThresholdWord::Adaptive) => Self::Adaptive,
            ThresholdDocument::Word(ThresholdWord::Otsu) => Self::Otsu,
            ThresholdDocument::Level(level) => Self::Fixed(level),
        }
    }
}

/// Options of a segmentation. What is absent has its default.
#[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema, IntoParams)]
#[schema(as = SegmentationOptionsBody)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct SegmentationOptionsDocument {
    /// What a pixel is held against: `adaptive` (the default), `otsu`, or a grey level.
    #[schema(required = false)]
    #[param(required = false)]
    pub threshold: Option<ThresholdDocument>,
    /// Adaptive only: side of the square that the background is looked for in; null or absent: chosen from the picture.
    #[schema(minimum = 3, maximum = 4095)]
    #[param(minimum = 3, maximum = 4095)]
    pub window_px: Option<usize>,
    /// Adaptive only: how far a pixel must stand out from the background, in grey levels; null or absent: chosen by the
    /// background's own noise and the picture's range.
    #[schema(minimum = 0, maximum = 255)]
    #[param(minimum = 0, maximum = 255)]
    pub offset: Option<f64>,
    /// Whether objects are lighter than the background, darker, or either, also of another colour alone (the default).
    #[schema(required = false)]
    #[param(required = false)]
    pub polarity: Option<PolarityWord>,
    /// Smaller regions are specks; null or absent: chosen by the background's noise, with a
    /// threshold for the whole picture a 500th of it.
    #[schema(minimum = 1)]
    #[param(minimum = 1)]
    pub min_area_px: Option<usize>,
    /// Most regions that are told of, the largest.
    #[schema(minimum = 1, maximum = 1000, default = 100)]
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub max_objects: Option<usize>,
}

/// Every member is present.
impl From<&SegmentationOptions> for SegmentationOptionsDocument {
    fn from(options: &SegmentationOptions) -> Self {
        Self {
            threshold: Some(options.threshold.into()),
            window_px: options.window_px,
            offset: options.offset,
            polarity: Some(options.polarity.into()),
            min_area_px: options.min_area_px,
            max_objects: Some(options.max_objects),
        }
    }
}

/// What is absent or null has its default.
impl From<SegmentationOptionsDocument> for SegmentationOptions {
    fn from(document: SegmentationOptionsDocument) -> Self {
        let default = Self::default();
        Self {
            threshold: document.threshold.map_or(default.threshold, Threshold::from),
            window_px: document.window_px.or(default.window_px),
            offset: document.offset.or(default.offset),
            polarity: document.polarity.map_or(default.polarity, Polarity::from),
            min_area_px: document.min_area_px.or(default.min_area_px),
            max_objects: document.max_objects.unwrap_or(default.max_objects),
        }
    }
}
