//! Who may call: keys, what each may do, and how often.
//!
//! A key is shown once, when it is made; kept is its SHA-256. Every process holds the keys in memory, so that asking
//! for one costs no query and goes on while the catalogue is away; a key that is made or revoked anywhere is known
//! everywhere as soon as the catalogue hints at it.
//!
//! A service that never had a key asks nobody, and is then only reachable on loopback addresses, or at the operator's
//! word. From its first key on it always asks, even when every key was revoked.

mod key;
mod keyring;
mod scope;

pub use key::Key;
pub use keyring::{AccessError, Caller, Denied, Grant, KeyGrant, Keyring};
pub use scope::{Scope, UnknownScope};

pub use crate::store::{Actor, AuditFilter, AuditRow, KeyRow};
