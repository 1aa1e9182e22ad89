//! Callers, and what they may do.

use std::sync::Arc;

use super::loaded_key::LoadedKey;
use super::scope::Scope;
use crate::store::Actor;

/// Who calls, and what they may do.
#[derive(Debug, Clone)]
pub struct Caller {
    /// The key that the call came with; none where no key is required.
    pub(super) key: Option<Arc<LoadedKey>>,
    /// Id of the call, for the audit record.
    pub(super) request_id: Option<String>,
}

impl Caller {
    /// Whether the scope of its key includes this one.
    pub fn may(&self, scope: Scope) -> bool {
        self.key.as_ref().is_none_or(|key| key.scope >= scope)
    }

    /// Whether its key reaches that database.
    pub fn reaches(&self, database: &str) -> bool {
        let patterns = self.key.as_ref().and_then(|key| key.databases.as_ref());
        patterns.is_none_or(|patterns| patterns.iter().any(|pattern| pattern.matches(database)))
    }

    /// Whether its key reaches some databases only.
    pub fn is_confined(&self) -> bool {
        self.key.as_ref().is_some_and(|key| key.databases.is_some())
    }

    /// Id of its key; none where no key is required.
    pub fn key_id(&self) -> Option<&str> {
        self.key.as_ref().map(|key| key.id.as_str())
    }

    /// Its key as a number, which tells callers apart.
    pub fn key_number(&self) -> Option<u64> {
        self.key.as_ref().map(|key| key.number)
    }

    /// The same caller, with the id of its call.
    pub fn with_request_id(self, request_id: Option<String>) -> Self {
        Self { request_id, ..self }
    }

    /// The caller as the audit record names it.
    pub fn actor(&self) -> Actor {
        let request_id = self.request_id.clone();
        match &self.key {
            Some(key) => Actor { key: Some(key.id.clone()), name: key.name.clone(), request_id },
            None => Actor { request_id, ..Actor::named("anyone") },
        }
    }
}
