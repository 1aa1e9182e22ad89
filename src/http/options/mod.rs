//! Options on the wire. Each is optional; what is absent keeps its value. Unknown, misshapen and conflicting ones are
//! one problem that names them all. One file a kind, and one for depth maps.

mod depth;
mod landmarks;
mod objects;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

pub use depth::{DepthMethodWord, DepthOptionsBody, WindowBody};
pub use landmarks::LandmarkOptionsBody;
pub use objects::ObjectOptionsBody;

use super::problem::{Code, FieldError, Problem};
use crate::database::Options;
use crate::recognition::OptionFault;

/// Options of a database, by its kind.
#[derive(Debug, Clone, Serialize, ToSchema)]
#[serde(untagged)]
pub enum OptionsBody {
    Landmarks(LandmarkOptionsBody),
    Objects(ObjectOptionsBody),
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
/// One problem that names every unknown, misshapen or conflicting option; 422 `not_yet` when all that is wrong is a
/// value whose meaning is still to come.
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

/// What of the members of the object `at` can be read, and a fault for each of the others.
pub fn readable<B: DeserializeOwned + Default>(at: &str, body: &Map<String, Value>) -> (B, Vec<FieldError>) {
    let mut faults = Vec::new();
    let mut readable = Map::new();
    for (name, value) in body {
        // One at a time, so that every fault is found and not only the first.
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        match serde_json::from_value::<B>(alone) {
            Ok(_) => drop(readable.insert(name.clone(), value.clone())),
            Err(error) => {
                faults.push(FieldError { pointer: format!("{at}/{name}"), detail: error.to_string() });
            }
        }
    }
    (serde_json::from_value(Value::Object(readable)).unwrap_or_default(), faults)
}

/// What can't be read, what can't be used, and the names of what has a value that is still to come, as one problem;
/// nothing if there is none. `not_yet` says what there is instead.
fn judge(
    mut faults: Vec<FieldError>,
    unusable: Vec<OptionFault>,
    later: Vec<&'static str>,
    not_yet: &str,
) -> Result<(), Problem> {
    for fault in unusable {
        faults.push(FieldError { pointer: format!("/options/{}", fault.option), detail: fault.message });
    }
    let later: Vec<FieldError> = later
        .into_iter()
        .map(|name| FieldError {
            pointer: format!("/options/{name}"),
            detail: "has a value that this release can't do yet".into(),
        })
        .collect();
    if !later.is_empty() && faults.is_empty() {
        return Err(Problem::new(Code::NotYet, not_yet).with_errors(later));
    }
    faults.extend(later);
    if faults.is_empty() { Ok(()) } else { Err(Problem::fields(faults)) }
}

/// Options that are words: a type of the wire, and both ways to the one inside.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident, $room:ident::$domain:ident, { $($variant:ident),+ } $(, later { $($later:ident),+ })?) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $($variant),+ $(, $($later),+)? }

        impl $name {
            /// The value inside; an error for a word whose meaning is still to come.
            pub fn inside(self) -> Result<$room::$domain, ()> {
                match self {
                    $(Self::$variant => Ok($room::$domain::$variant),)+
                    $($(Self::$later => Err(()),)+)?
                }
            }
        }

        impl From<$room::$domain> for $name {
            fn from(value: $room::$domain) -> Self {
                match value { $($room::$domain::$variant => Self::$variant),+ }
            }
        }
    };
}
use words;
