//! Words: enumerations of the core as documents and the HTTP contract write them, in snake case.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Left to the service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AutoWord {
    /// The service chooses.
    Auto,
}

/// Declares the twin of an enumeration of the core that serialises and has a schema, with the conversions both ways.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident, $domain:ident, { $($variant:ident),+ }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $(
                #[doc = concat!("See [`", stringify!($domain), "::", stringify!($variant), "`].")]
                $variant
            ),+
        }

        impl From<$name> for $domain {
            fn from(word: $name) -> Self {
                match word { $($name::$variant => Self::$variant),+ }
            }
        }

        impl From<$domain> for $name {
            fn from(value: $domain) -> Self {
                match value { $($domain::$variant => Self::$variant),+ }
            }
        }
    };
}
pub(crate) use words;
