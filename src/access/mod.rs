//! Who may call: keys, what each may do, and how often.
//!
//! A key is shown once, when it is made; only its SHA-256 is kept. Every process holds the keys in memory, so that asking
//! for one costs no query and goes on while the catalogue is away; a key that is made or revoked anywhere is known
//! everywhere as soon as the catalogue's change notification arrives.
//!
//! A service that never had a key requires none, and is then reachable on loopback addresses only, unless the operator
//! allows others. From its first key on it always requires one, even when every key was revoked.

mod caller;
mod key;
mod keyring;
mod loaded_key;
mod scope;

pub use caller::Caller;
pub use key::Key;
pub use keyring::{AccessError, Denied, Grant, IssuedKey, Keyring};
pub use scope::{Scope, UnknownScope};

pub use crate::store::{Actor, AuditFilter, AuditRow, KeyRow};
