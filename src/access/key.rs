//! A key's text: `lmk_<16 hexadecimal digits>_<64 hexadecimal digits>`. The first part names the key and may be
//! known; the second is 256 random bits.

use std::fmt;

use sha2::{Digest, Sha256};
use subtle::ConstantTimeEq;

const PREFIX: &str = "lmk";
const ID_DIGITS: usize = 16;
const SECRET_DIGITS: usize = 64;

/// SHA-256 of a key's text. The text has 256 random bits, so a slow hash would protect nothing more.
pub(super) type KeyHash = [u8; 32];

/// A key as its holder has it. Its text is a secret, so `Debug` shows the id only.
#[derive(Clone, PartialEq, Eq)]
pub struct Key {
    text: String,
}

impl Key {
    /// A new random key.
    ///
    /// # Errors
    /// The operating system gives no random numbers.
    pub(super) fn generate() -> Result<Self, getrandom::Error> {
        let (mut id, mut secret) = ([0; ID_DIGITS / 2], [0; SECRET_DIGITS / 2]);
        getrandom::fill(&mut id)?;
        getrandom::fill(&mut secret)?;
        Ok(Self { text: format!("{PREFIX}_{}_{}", hex(&id), hex(&secret)) })
    }

    /// The key of that text, if it has a key's shape.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let digits = |part: &str, count| {
            part.len() == count && part.bytes().all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'))
        };
        let mut parts = text.split('_');
        let is_key = parts.next() == Some(PREFIX)
            && parts.next().is_some_and(|id| digits(id, ID_DIGITS))
            && parts.next().is_some_and(|secret| digits(secret, SECRET_DIGITS))
            && parts.next().is_none();
        is_key.then(|| Self { text: text.to_owned() })
    }

    /// The part that names it.
    pub fn id(&self) -> &str {
        &self.text[PREFIX.len() + 1..][..ID_DIGITS]
    }

    /// The whole of it: to be shown once.
    pub fn reveal(&self) -> &str {
        &self.text
    }

    /// What the catalogue keeps of the key.
    pub(super) fn hash(&self) -> KeyHash {
        Sha256::digest(&self.text).into()
    }

    /// Whether this is the key of that hash, in a time that doesn't depend on where they differ.
    pub(super) fn has_hash(&self, hash: &KeyHash) -> bool {
        self.hash().ct_eq(hash).into()
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Key({}…)", self.id())
    }
}

/// Bytes as lower-case hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The hash that a row keeps, if it is one.
pub(super) fn hash_of_hex(text: &str) -> Option<KeyHash> {
    let mut hash = KeyHash::default();
    if text.len() != 2 * hash.len() || !text.is_ascii() {
        return None;
    }
    for (byte, digits) in hash.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    }
    Some(hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_read_back_and_shows_its_id_alone() {
        let key = Key::generate().unwrap();
        assert_eq!(key.reveal().len(), 3 + 1 + 16 + 1 + 64);
        assert_eq!(Key::parse(key.reveal()).as_ref(), Some(&key));
        let shown = format!("{key:?}");
        assert!(shown.contains(key.id()) && !shown.contains(&key.reveal()[21..]), "{shown}");
        assert_eq!(hash_of_hex(&hex(&key.hash())), Some(key.hash()));
        assert!(key.has_hash(&key.hash()));
        assert!(!Key::generate().unwrap().has_hash(&key.hash()));
    }

    #[test]
    fn only_a_whole_key_has_the_shape_of_one() {
        let key = Key::generate().unwrap();
        let text = key.reveal();
        for wrong in [
            String::new(),
            text[..text.len() - 1].to_owned(),
            format!("{text}0"),
            format!("{text}_"),
            text.to_uppercase(),
            text.replace("lmk", "lml"),
            text.replace('_', "-"),
            format!("{}é", &text[..text.len() - 2]),
        ] {
            assert_eq!(Key::parse(&wrong), None, "{wrong}");
        }
    }
}
