//! The options of a database: which kind it is and how it is trained, and the document they are kept as.
//!
//! The document is JSON with one member an option; absent members mean the default. It stands in the catalogue,
//! in every version and in artifact files, so its names never change meaning.

use serde::{Deserialize, Serialize};

use crate::recognition::landmarks::{
    Colour, LandmarkOptions, Method, Normalise, Operator, OptionFault, PerLabel, Taper, Viewpoint,
};

/// What a database recognises by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Local appearance: interest points, sub-windows, votes.
    Landmarks,
}

impl Kind {
    /// The word that stands in the catalogue, in artifacts and in the HTTP contract.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Landmarks => "landmarks",
        }
    }

    /// The kind of that word.
    pub fn parse(word: &str) -> Option<Self> {
        (word == "landmarks").then_some(Self::Landmarks)
    }
}

macro_rules! words {
    ($type:ident, $document:ident, { $($variant:ident),+ }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum $document { $($variant),+ }
        impl From<$type> for $document {
            fn from(value: $type) -> Self { match value { $($type::$variant => Self::$variant),+ } }
        }
        impl From<$document> for $type {
            fn from(value: $document) -> Self { match value { $($document::$variant => Self::$variant),+ } }
        }
    };
}

words!(Method, MethodWord, { Paper });
words!(Viewpoint, ViewpointWord, { Free });
words!(Operator, OperatorWord, { Symmetry });
words!(Taper, TaperWord, { Radial, Literal });
words!(Normalise, NormaliseWord, { Contrast, Energy, None });
words!(Colour, ColourWord, { Auto, Gray, Opponent });
words!(PerLabel, PerLabelWord, { Best, Sum });

/// Landmark options as they are kept. The order of the members is the order in the document and in digests.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct LandmarkDocument {
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

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    #[error("the options are no document that this release reads")]
    Malformed {
        #[source]
        source: serde_json::Error,
    },
    #[error("the options can't be used: {}", .faults.iter().map(|f| format!("{} {}", f.option, f.message)).collect::<Vec<_>>().join("; "))]
    Impossible { faults: Vec<OptionFault> },
}

/// Landmark options as one line of JSON: the same options always give the same text.
pub fn to_document(options: &LandmarkOptions) -> String {
    serde_json::to_string(&LandmarkDocument::from(options)).expect("numbers and words always serialise")
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

/// Read a kept document back.
///
/// # Errors
/// [`DocumentError`] for text that is no such document, or options that can't be used together.
pub fn from_document(text: &str) -> Result<LandmarkOptions, DocumentError> {
    let document: LandmarkDocument =
        serde_json::from_str(text).map_err(|source| DocumentError::Malformed { source })?;
    let options = LandmarkOptions {
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
    };
    let faults = options.faults();
    if faults.is_empty() { Ok(options) } else { Err(DocumentError::Impossible { faults }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_comes_back_as_the_same_options() {
        let options = LandmarkOptions {
            taper: Taper::Literal,
            colour: Colour::Opponent,
            epsilon: 0.01,
            interest_points: 16,
            ..Default::default()
        };
        assert_eq!(from_document(&to_document(&options)).unwrap(), options);
    }

    #[test]
    fn impossible_options_are_refused_with_their_names() {
        let text = to_document(&LandmarkOptions::default()).replace(r#""rings":"#, r#""rings":9"#);
        let error = from_document(&text).unwrap_err();
        assert!(error.to_string().contains("rings"), "{error}");
        assert!(matches!(from_document("{"), Err(DocumentError::Malformed { .. })));
    }

    #[test]
    fn an_older_document_without_an_option_is_still_read() {
        let text = to_document(&LandmarkOptions { rings: 12, ..Default::default() });
        let older = text.replace(r#","per_label":"best""#, "");
        assert_ne!(older, text);
        assert_eq!(from_document(&older).unwrap().rings, 12);
    }
}
