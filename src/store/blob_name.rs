//! Names of blobs.

use std::fmt;
use std::str::FromStr;

use object_store::path::Path;

/// The folder of a bucket where orphans wait before they are deleted.
const SET_ASIDE: &str = "set-aside";

/// The name of a blob: the BLAKE3 hash of its content.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlobName([u8; 32]);

impl BlobName {
    /// The name of a content.
    pub fn of(content: &[u8]) -> Self {
        Self(*blake3::hash(content).as_bytes())
    }

    /// The name of a content that lies in parts.
    pub fn of_parts<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut hasher = blake3::Hasher::new();
        for part in parts {
            hasher.update(part);
        }
        Self(*hasher.finalize().as_bytes())
    }

    /// The name that is this hash.
    pub const fn of_hash(hash: [u8; 32]) -> Self {
        Self(hash)
    }

    /// The hash itself.
    pub const fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// Where the blob is stored: `abcdef…` as `ab/abcdef…`.
    pub(super) fn path(&self) -> Path {
        let digits = self.to_string();
        Path::from_iter([&digits[..2], digits.as_str()])
    }

    /// Where an orphan of a bucket waits before it is deleted.
    pub(super) fn path_aside(&self) -> Path {
        Path::from_iter([SET_ASIDE, self.to_string().as_str()])
    }

    /// The name of a stored object; none for anything that isn't a blob.
    pub(super) fn from_path(path: &Path) -> Option<Self> {
        let name: Self = path.filename()?.parse().ok()?;
        (name.path() == *path || name.path_aside() == *path).then_some(name)
    }
}

impl fmt::Display for BlobName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

impl fmt::Debug for BlobName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "BlobName({self})")
    }
}

impl FromStr for BlobName {
    type Err = InvalidBlobName;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let invalid = || InvalidBlobName { text: text.to_owned() };
        let mut name = [0; 32];
        let (pairs, []) = text.as_bytes().as_chunks::<2>() else { return Err(invalid()) };
        if pairs.len() != name.len() {
            return Err(invalid());
        }
        for (byte, &[high, low]) in name.iter_mut().zip(pairs) {
            *byte = digit(high).zip(digit(low)).map(|(high, low)| high << 4 | low).ok_or_else(invalid)?;
        }
        Ok(Self(name))
    }
}

fn digit(character: u8) -> Option<u8> {
    match character {
        b'0'..=b'9' => Some(character - b'0'),
        b'a'..=b'f' => Some(character - b'a' + 10),
        _ => None,
    }
}

/// The text is no blob name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is no blob name: 64 lower-case hexadecimal digits are")]
pub struct InvalidBlobName {
    /// The text that was read.
    pub text: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_sixty_four_lower_case_hexadecimal_digits_are_a_name() {
        let name = BlobName::of(b"picture");
        assert_eq!(name.to_string().parse::<BlobName>().unwrap(), name);
        assert_eq!(name.to_string(), blake3::hash(b"picture").to_hex().as_str());
        let digits = name.to_string();
        let wrong = [
            String::new(),
            digits[..63].to_owned(),
            digits[..62].to_owned(),
            format!("{digits}0"),
            format!("{digits}00"),
            digits.to_uppercase(),
            format!("{}g", &digits[..63]),
            format!("{}é", &digits[..62]),
            format!("../{}", &digits[3..]),
            format!("{}/{}", &digits[..2], &digits[3..]),
            format!(" {}", &digits[1..]),
        ];
        for text in wrong {
            let refused = text.parse::<BlobName>().unwrap_err();
            assert_eq!(refused, InvalidBlobName { text });
        }
    }
}
