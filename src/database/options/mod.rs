//! The options of a database: which kind it is and how it is trained, and the document they are kept as.
//!
//! The document is JSON with one member an option; absent members mean the default. It stands in the catalogue,
//! in every version and in artifact files, so its names never change meaning. One file a kind.

mod landmarks;
mod objects;

use landmarkd_core::recognition::OptionFault;
use landmarkd_core::recognition::landmarks::LandmarkOptions;
use landmarkd_core::recognition::objects::ObjectOptions;

use landmarks::LandmarkDocument;
use objects::ObjectDocument;

/// What a database recognises by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Local appearance: interest points, sub-windows, votes.
    Landmarks,
    /// Whole appearance: eigenimages, and the pose.
    Objects,
}

impl Kind {
    /// The word that stands in the catalogue, in artifacts and in the HTTP contract.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Landmarks => "landmarks",
            Self::Objects => "objects",
        }
    }

    /// The kind of that word.
    pub fn parse(word: &str) -> Option<Self> {
        [Self::Landmarks, Self::Objects].into_iter().find(|kind| kind.as_str() == word)
    }
}

/// All options of a database.
#[derive(Debug, Clone, PartialEq)]
pub enum Options {
    Landmarks(LandmarkOptions),
    Objects(ObjectOptions),
}

impl Options {
    /// The defaults of a kind.
    pub fn default_of(kind: Kind) -> Self {
        match kind {
            Kind::Landmarks => Self::Landmarks(LandmarkOptions::default()),
            Kind::Objects => Self::Objects(ObjectOptions::default()),
        }
    }

    /// The kind of database they are for.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Landmarks(_) => Kind::Landmarks,
            Self::Objects(_) => Kind::Objects,
        }
    }

    /// The options as one line of JSON: the same options always give the same text.
    pub fn to_document(&self) -> String {
        let text = match self {
            Self::Landmarks(options) => serde_json::to_string(&LandmarkDocument::from(options)),
            Self::Objects(options) => serde_json::to_string(&ObjectDocument::from(options)),
        };
        text.expect("numbers and words always serialise")
    }

    /// Read a kept document of this kind back.
    ///
    /// # Errors
    /// [`DocumentError`] for text that is no such document, or options that can't be used together.
    pub fn from_document(kind: Kind, text: &str) -> Result<Self, DocumentError> {
        let malformed = |source| DocumentError::Malformed { source };
        let options = match kind {
            Kind::Landmarks => {
                Self::Landmarks(serde_json::from_str::<LandmarkDocument>(text).map_err(malformed)?.into())
            }
            Kind::Objects => {
                Self::Objects(serde_json::from_str::<ObjectDocument>(text).map_err(malformed)?.into())
            }
        };
        let faults = options.faults();
        if faults.is_empty() { Ok(options) } else { Err(DocumentError::Impossible { faults }) }
    }

    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        match self {
            Self::Landmarks(options) => options.faults(),
            Self::Objects(options) => options.faults(),
        }
    }
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

/// Options that are words: a twin of the type that serialises, and both ways between them.
macro_rules! words {
    ($type:ident, $document:ident, { $($variant:ident),+ }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
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
pub(super) use words;

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::recognition::landmarks::{Colour, Method, Taper, Viewpoint};
    use landmarkd_core::recognition::objects::{Dimension, Distance, Resize, Search, Stages};

    fn read(options: &Options) -> Options {
        Options::from_document(options.kind(), &options.to_document()).unwrap()
    }

    #[test]
    fn a_document_comes_back_as_the_same_options() {
        let paper = LandmarkOptions {
            taper: Taper::Literal,
            colour: Colour::Opponent,
            epsilon: 0.01,
            interest_points: 16,
            ..LandmarkOptions::of(Method::Paper, Viewpoint::Free)
        };
        let upright = LandmarkOptions {
            position_prior_px: Some(40.0),
            ..LandmarkOptions::of(Method::Placement, Viewpoint::Upright)
        };
        let objects = ObjectOptions {
            width_px: Some(64),
            height_px: Some(48),
            resize: Resize::Never,
            segment: true,
            smoothing: 0.01,
            dimension: Dimension::Fixed(12),
            stages: Stages::UniversalOnly,
            search: Search::Slabs,
            distance: Distance::Mahalanobis,
            accept: 0.9,
        };
        let defaults = [Kind::Landmarks, Kind::Objects].map(Options::default_of);
        let given = [Options::Landmarks(paper), Options::Landmarks(upright), Options::Objects(objects)];
        for options in given.into_iter().chain(defaults) {
            assert_eq!(read(&options), options);
        }
    }

    #[test]
    fn the_documents_of_the_defaults_never_change() {
        // Digests of versions are made from this text.
        assert_eq!(
            Options::default_of(Kind::Landmarks).to_document(),
            r#"{"method":"placement","viewpoint":"free","operator":"symmetry","symmetry_radius_px":6,"interest_points":96,"query_points":1000,"subwindow_radius_px":[10.0,14.0],"rings":8,"sectors":32,"taper":"radial","normalise":"contrast","colour":"auto","dimension":20,"neighbours":6,"epsilon":0.001,"per_label":"best"}"#
        );
        assert_eq!(
            Options::Landmarks(LandmarkOptions::of(Method::Paper, Viewpoint::Free)).to_document(),
            r#"{"method":"paper","viewpoint":"free","operator":"symmetry","symmetry_radius_px":6,"interest_points":64,"query_points":64,"subwindow_radius_px":5.0,"rings":8,"sectors":32,"taper":"radial","normalise":"contrast","colour":"auto","dimension":32,"neighbours":1,"epsilon":0.001,"per_label":"best"}"#
        );
        assert_eq!(
            Options::default_of(Kind::Objects).to_document(),
            r#"{"width_px":null,"height_px":null,"resize":"fit","smoothing":0.0234375,"dimension":"auto","stages":"universal_then_object","search":"kd_tree","distance":"euclidean","accept":0.97}"#
        );
    }

    #[test]
    fn impossible_options_are_refused_with_their_names() {
        for (kind, option, from, to) in [
            (Kind::Landmarks, "rings", r#""rings":"#, r#""rings":9"#),
            (Kind::Objects, "accept", r#""accept":0."#, r#""accept":5."#),
        ] {
            let text = Options::default_of(kind).to_document().replace(from, to);
            let error = Options::from_document(kind, &text).unwrap_err();
            assert!(matches!(error, DocumentError::Impossible { .. }), "{error}");
            assert!(error.to_string().contains(option), "{error}");
            assert!(matches!(Options::from_document(kind, "{"), Err(DocumentError::Malformed { .. })));
        }
    }

    #[test]
    fn options_of_the_other_kind_are_no_document() {
        for (kind, other) in [(Kind::Landmarks, Kind::Objects), (Kind::Objects, Kind::Landmarks)] {
            let text = Options::default_of(other).to_document();
            assert!(matches!(Options::from_document(kind, &text), Err(DocumentError::Malformed { .. })));
        }
    }

    #[test]
    fn an_older_document_without_an_option_is_still_read() {
        let paper = LandmarkOptions::of(Method::Paper, Viewpoint::Free);
        let options = Options::Landmarks(LandmarkOptions { rings: 12, ..paper });
        let text = options.to_document();
        let older = text.replace(r#","per_label":"best""#, "").replace(r#""method":"paper","#, "");
        assert!(older.len() < text.len() - 30, "{older}");
        assert_eq!(Options::from_document(Kind::Landmarks, &older).unwrap(), options);
    }
}
