//! The options of a database: which kind it is and how it is trained, and the document that is sent and kept.
//!
//! The document is JSON with one member an option. In a request absent members keep their value; in a kept document they
//! mean the default of the release that added them. It stands in the catalogue, in every version and in artifact files,
//! so its names never change meaning. One file a kind, one for segmentations.

/// Declares the document of options: a member for each option, of a type that converts to and from the option's, absent
/// or present. Members that only requests have come last: they are no options, and absent from kept documents and answers.
macro_rules! options_document {
    (
        $(#[$doc:meta])*
        $name:ident as $schema:ident, $options:ident, { $($(#[$attribute:meta])* $option:ident: $type:ty),+ $(,)? }
        $(, in requests: { $($(#[$asked_attribute:meta])* $asked:ident: $asked_type:ty),+ $(,)? })?
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Default, Serialize, Deserialize, ToSchema)]
        #[schema(as = $schema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($(#[$attribute])* $option: Option<$type>,)+
            $($($(#[$asked_attribute])* #[serde(skip_serializing_if = "Option::is_none")] $asked: Option<$asked_type>,)+)?
        }

        /// Every option is present.
        impl From<$options> for $name {
            fn from(options: $options) -> Self {
                Self { $($option: Some(options.$option.into()),)+ $($($asked: None,)+)? }
            }
        }

        impl $name {
            /// The options `base` with the members that are present put over them.
            pub fn over(self, base: $options) -> $options {
                $options { $($option: self.$option.map_or(base.$option, Into::into)),+ }
            }
        }
    };
}

mod landmarks;
mod objects;
mod segmentation;

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use utoipa::openapi::schema::AnyOfBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use landmarkd_core::recognition::OptionFault;
use landmarkd_core::recognition::landmarks::{LandmarkOptions, Signature};
use landmarkd_core::recognition::objects::ObjectOptions;

pub use landmarks::LandmarkOptionsDocument;
use objects::KeptObjectOptions;
pub use objects::ObjectOptionsDocument;
pub use segmentation::SegmentationOptionsDocument;

/// What a database recognises by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = KindWord)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Local appearance (interest points, sub-windows, votes): places and objects on any background.
    Landmarks,
    /// Whole appearance (eigenimages): which object, and its pose.
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
    /// Of a database of kind `landmarks`.
    Landmarks(LandmarkOptions),
    /// Of a database of kind `objects`.
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

    /// The options as they are kept, one line of JSON: the same options always give the same text.
    pub fn to_document(&self) -> String {
        let text = match self {
            Self::Landmarks(options) => serde_json::to_string(&LandmarkOptionsDocument::kept(options)),
            Self::Objects(options) => serde_json::to_string(&KeptObjectOptions::from(options)),
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
                let document: LandmarkOptionsDocument = serde_json::from_str(text).map_err(malformed)?;
                Self::Landmarks(document.read_kept())
            }
            Kind::Objects => {
                let document: ObjectOptionsDocument = serde_json::from_str(text).map_err(malformed)?;
                Self::Objects(document.read_kept())
            }
        };
        let members: Map<String, Value> = serde_json::from_str(text).map_err(malformed)?;
        refuse_null(&members).map_err(malformed)?;
        options.usable()
    }

    /// Whether signatures are of gradients: then negative exemplars are of use, and no calibration is needed to decide.
    pub fn have_gradients(&self) -> bool {
        match self {
            Self::Landmarks(options) => options.signature == Signature::Gradient,
            Self::Objects(_) => false,
        }
    }

    /// Everything that is wrong with the options, all at once; empty if they can be used.
    pub fn faults(&self) -> Vec<OptionFault> {
        match self {
            Self::Landmarks(options) => options.faults(),
            Self::Objects(options) => options.faults(),
        }
    }

    /// The options, if they can be used.
    ///
    /// # Errors
    /// [`DocumentError::Impossible`] with everything that is wrong with them.
    pub fn usable(self) -> Result<Self, DocumentError> {
        let faults = self.faults();
        if faults.is_empty() { Ok(self) } else { Err(DocumentError::Impossible { faults }) }
    }
}

/// Options that may be null.
const NULLABLE: [&str; 3] = ["width_px", "height_px", "position_prior_px"];

/// Refuses null for other options than [`NULLABLE`]. In a request null means absent; a kept document has no such member.
///
/// # Errors
/// The option that is null.
pub fn refuse_null(members: &Map<String, Value>) -> Result<(), serde_json::Error> {
    match members.iter().find(|(name, value)| value.is_null() && !NULLABLE.contains(&name.as_str())) {
        Some((name, _)) => Err(serde::de::Error::custom(format!("{name} is null"))),
        None => Ok(()),
    }
}

/// A member that may be null: `None` where it is absent, `Some(None)` where it is null.
fn present_or_null<'de, D, T>(deserializer: D) -> Result<Option<Option<T>>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    Option::deserialize(deserializer).map(Some)
}

/// Options of a database as answers have them, every member present.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum OptionsDocument {
    /// Of a database of kind `landmarks`.
    Landmarks(LandmarkOptionsDocument),
    /// Of a database of kind `objects`.
    Objects(ObjectOptionsDocument),
}

impl From<&Options> for OptionsDocument {
    fn from(options: &Options) -> Self {
        match options {
            Options::Landmarks(options) => Self::Landmarks(options.clone().into()),
            Options::Objects(options) => Self::Objects(options.clone().into()),
        }
    }
}

/// `anyOf`: a document without members is of both kinds, so that `oneOf`, which is derived, would refuse it.
impl PartialSchema for OptionsDocument {
    fn schema() -> RefOr<Schema> {
        let kinds = [LandmarkOptionsDocument::name(), ObjectOptionsDocument::name()];
        let any = kinds
            .iter()
            .fold(AnyOfBuilder::new(), |any, kind| any.item(Ref::from_schema_name(kind.as_ref())));
        any.description(Some("Options of a database, by its kind.")).into()
    }
}

impl ToSchema for OptionsDocument {
    fn name() -> std::borrow::Cow<'static, str> {
        "OptionsBody".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schemas.push((LandmarkOptionsDocument::name().into(), LandmarkOptionsDocument::schema()));
        schemas.push((ObjectOptionsDocument::name().into(), ObjectOptionsDocument::schema()));
        LandmarkOptionsDocument::schemas(schemas);
        ObjectOptionsDocument::schemas(schemas);
    }
}

/// The kept document can't be read back.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// The text is no document of this release's options.
    #[error("the options are no document that this release reads")]
    Malformed {
        /// What is wrong with the text.
        #[source]
        source: serde_json::Error,
    },
    /// The options exclude each other, or are out of range.
    #[error("the options can't be used: {}", .faults.iter().map(|f| format!("{} {}", f.option, f.message)).collect::<Vec<_>>().join("; "))]
    Impossible {
        /// Everything that is wrong, all at once.
        faults: Vec<OptionFault>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use landmarkd_core::recognition::landmarks::{Colour, Method, Taper, Viewpoint};
    use landmarkd_core::recognition::objects::{AppearanceOf, Dimension, Distance, Resize, Search, Stages};

    fn intensity(viewpoint: Viewpoint) -> LandmarkOptions {
        LandmarkOptions::with_signature(Method::Placement, viewpoint, Signature::Intensity)
    }

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
        let upright = LandmarkOptions { position_prior_px: Some(40.0), ..intensity(Viewpoint::Upright) };
        let objects = ObjectOptions {
            appearance: AppearanceOf::Intensity,
            colour: Colour::Gray,
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
            Options::Landmarks(intensity(Viewpoint::Free)).to_document(),
            r#"{"method":"placement","viewpoint":"free","operator":"symmetry","symmetry_radius_px":6,"interest_points":96,"query_points":1000,"subwindow_radius_px":[10.0,14.0],"rings":8,"sectors":32,"taper":"radial","normalise":"contrast","colour":"auto","dimension":20,"neighbours":6,"epsilon":0.001,"per_label":"best"}"#
        );
        assert_eq!(
            Options::default_of(Kind::Landmarks).to_document(),
            r#"{"method":"placement","viewpoint":"free","operator":"symmetry","symmetry_radius_px":6,"interest_points":600,"query_points":1000,"subwindow_radius_px":14.0,"rings":6,"sectors":32,"taper":"radial","normalise":"contrast","colour":"auto","dimension":48,"neighbours":30,"epsilon":0.001,"per_label":"best","signature":"gradient","working_size_px":640,"levels_per_octave":2,"false_alarms":0.01}"#
        );
        assert_eq!(
            Options::Landmarks(LandmarkOptions::of(Method::Paper, Viewpoint::Free)).to_document(),
            r#"{"method":"paper","viewpoint":"free","operator":"symmetry","symmetry_radius_px":6,"interest_points":64,"query_points":64,"subwindow_radius_px":5.0,"rings":8,"sectors":32,"taper":"radial","normalise":"contrast","colour":"auto","dimension":32,"neighbours":1,"epsilon":0.001,"per_label":"best"}"#
        );
        assert_eq!(
            Options::default_of(Kind::Objects).to_document(),
            r#"{"width_px":null,"height_px":null,"resize":"fit","appearance":"gradient","colour":"auto","smoothing":0.01171875,"dimension":"auto","stages":"universal_then_object","search":"kd_tree","distance":"euclidean","accept":0.98}"#
        );
        assert_eq!(
            Options::Objects(ObjectOptions::of(AppearanceOf::Intensity)).to_document(),
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
    fn a_kept_document_has_null_only_where_null_is_a_value() {
        for (kind, option, readable) in [
            (Kind::Landmarks, "rings", false),
            (Kind::Landmarks, "position_prior_px", true),
            (Kind::Objects, "segment", false),
            (Kind::Objects, "width_px", true),
        ] {
            let read = Options::from_document(kind, &format!("{{\"{option}\":null}}"));
            assert_eq!(read.is_ok(), readable, "{option}");
        }
    }

    #[test]
    fn an_answer_has_every_member_and_a_kept_document_leaves_out_what_is_off() {
        let only_in_answers = [(Kind::Landmarks, "position_prior_px"), (Kind::Objects, "segment")];
        for (kind, option) in only_in_answers {
            let options = Options::default_of(kind);
            let answer = serde_json::to_string(&OptionsDocument::from(&options)).unwrap();
            assert!(answer.contains(option) && !options.to_document().contains(option), "{answer}");
        }
        let cut = Options::Objects(ObjectOptions { segment: true, ..Default::default() });
        assert!(cut.to_document().contains(r#""resize":"fit","segment":true,"appearance""#));
        let answer = serde_json::to_string(&OptionsDocument::from(&cut)).unwrap();
        assert!(answer.contains(r#""smoothing":0.01171875,"segment":true,"dimension""#), "{answer}");
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
