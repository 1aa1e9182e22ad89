//! Options on the wire. Each is optional; what is absent keeps its value. Unknown, misshapen and conflicting ones are
//! one problem that names them all. One file a kind, one for depth maps, one for segmentations.

mod depth;
mod landmarks;
mod objects;
mod segmentation;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::openapi::schema::AnyOfBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

pub use depth::{DepthMethodWord, DepthOptionsBody, WindowBody};
pub use landmarks::LandmarkOptionsBody;
pub use objects::ObjectOptionsBody;
pub use segmentation::SegmentationOptionsBody;

use super::extract::from_value;
use super::problem::{FieldError, Problem};
use crate::database::Options;
use landmarkd_core::recognition::OptionFault;

/// Options of a database, by its kind.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum OptionsBody {
    Landmarks(LandmarkOptionsBody),
    Objects(ObjectOptionsBody),
}

/// Any of both: with no member at all it is both, so that `oneOf`, which is derived, would refuse it.
impl PartialSchema for OptionsBody {
    fn schema() -> RefOr<Schema> {
        let kinds = [LandmarkOptionsBody::name(), ObjectOptionsBody::name()];
        let any = kinds
            .iter()
            .fold(AnyOfBuilder::new(), |any, kind| any.item(Ref::from_schema_name(kind.as_ref())));
        any.description(Some("Options of a database, by its kind.")).into()
    }
}

impl ToSchema for OptionsBody {
    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        schemas.push((LandmarkOptionsBody::name().into(), LandmarkOptionsBody::schema()));
        schemas.push((ObjectOptionsBody::name().into(), ObjectOptionsBody::schema()));
        LandmarkOptionsBody::schemas(schemas);
        ObjectOptionsBody::schemas(schemas);
    }
}

impl From<&Options> for OptionsBody {
    fn from(options: &Options) -> Self {
        match options {
            Options::Landmarks(options) => Self::Landmarks(options.into()),
            Options::Objects(options) => Self::Objects(options.into()),
        }
    }
}

/// The options `base` with those of the body put over them.
///
/// # Errors
/// One problem that names every unknown, misshapen or conflicting option.
pub fn over(base: Options, body: &Map<String, Value>) -> Result<Options, Problem> {
    match base {
        Options::Landmarks(base) => landmarks::over(base, body).map(Options::Landmarks),
        Options::Objects(base) => objects::over(base, body).map(Options::Objects),
    }
}

/// Left to the service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutoWord {
    Auto,
}

/// A value that is given as null is not an absent one.
fn given<'de, D, T>(deserializer: D) -> Result<Option<Option<T>>, D::Error>
where
    D: serde::Deserializer<'de>,
    T: Deserialize<'de>,
{
    Option::deserialize(deserializer).map(Some)
}

/// What of the members of the object `at` can be read, and a fault for each of the others.
pub fn readable<B: DeserializeOwned + Default>(at: &str, body: &Map<String, Value>) -> (B, Vec<FieldError>) {
    let mut faults = Vec::new();
    let mut readable = Map::new();
    for (name, value) in body {
        // One at a time, so that every fault is found and not only the first.
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        match from_value::<B>(alone) {
            Ok(_) => drop(readable.insert(name.clone(), value.clone())),
            Err(fault) => {
                faults.push(FieldError { pointer: format!("{at}{}", fault.pointer), ..fault });
            }
        }
    }
    (serde_json::from_value(Value::Object(readable)).unwrap_or_default(), faults)
}

/// What is wrong with the options in the object `at`, as fields.
fn fields(at: &str, unusable: Vec<OptionFault>) -> impl Iterator<Item = FieldError> {
    unusable
        .into_iter()
        .map(move |fault| FieldError { pointer: format!("{at}/{}", fault.option), detail: fault.message })
}

/// What is at fault as one problem; nothing if there is none.
fn judge(faults: Vec<FieldError>) -> Result<(), Problem> {
    if faults.is_empty() { Ok(()) } else { Err(Problem::fields(faults)) }
}

/// Options that are words: a type of the wire, and both ways to the one inside.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident, $room:ident::$domain:ident, { $($variant:ident),+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($variant),+ }

        impl From<$name> for $room::$domain {
            fn from(word: $name) -> Self {
                match word { $($name::$variant => Self::$variant),+ }
            }
        }

        impl From<$room::$domain> for $name {
            fn from(value: $room::$domain) -> Self {
                match value { $($room::$domain::$variant => Self::$variant),+ }
            }
        }
    };
}
pub(super) use words;
