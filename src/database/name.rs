//! Names of databases, labels and aliases. A name is data, never a path.

use std::fmt;

use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A name that matches `^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Name(String);

/// The text is no name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "is not a name: a name has 1 to 64 characters, letters, digits, '_', '.' or '-', \
     and starts with a letter or digit"
)]
pub struct NotAName;

/// Longest name, in characters.
pub const MAX_NAME_CHARACTERS: usize = 64;

impl Name {
    /// The text as a name.
    ///
    /// # Errors
    /// [`NotAName`] when it doesn't match the pattern.
    pub fn parse(text: &str) -> Result<Self, NotAName> {
        let inner = |c: u8| c.is_ascii_alphanumeric() || matches!(c, b'_' | b'.' | b'-');
        let right = text.len() <= MAX_NAME_CHARACTERS
            && text.as_bytes().first().is_some_and(u8::is_ascii_alphanumeric)
            && text.bytes().all(inner);
        if right { Ok(Self(text.to_owned())) } else { Err(NotAName) }
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Serialize for Name {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_str(NameVisitor)
    }
}

/// Checks the text while it is read, so that the error belongs to the field that it stands in.
struct NameVisitor;

impl Visitor<'_> for NameVisitor {
    type Value = Name;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Name, E> {
        Name::parse(text).map_err(|error| E::custom(format!("{text:?} {error}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_held_to_the_pattern() {
        for good in ["a", "Kitchen-2", "obj1", "0.1_x", &"a".repeat(64)] {
            assert!(Name::parse(good).is_ok(), "{good}");
        }
        for bad in ["", "-a", ".hidden", "..", "a/b", "a b", "küche", "a\0", &"a".repeat(65)] {
            assert_eq!(Name::parse(bad), Err(NotAName), "{bad}");
        }
    }
}
