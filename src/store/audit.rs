//! The record of who changed what: an entry is written in the transaction of the change, and never again.

use jiff::Timestamp;
use serde_json::{Value, json};
use uuid::Uuid;

use super::catalogue::{ExemplarFilter, NewKey};

/// Who makes a change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Actor {
    /// Id of the key that the call came with.
    pub key: Option<String>,
    /// The key's name; without a key, who else it was.
    pub name: String,
    pub request_id: Option<String>,
}

impl Actor {
    /// One that no key speaks for.
    pub fn named(name: impl Into<String>) -> Self {
        Self { key: None, name: name.into(), request_id: None }
    }

    /// A job; who queued it stands in the entry `job.queue` about it.
    pub(super) fn job(id: Uuid) -> Self {
        Self::named(format!("job {id}"))
    }
}

/// An entry of the record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AuditRow {
    /// Grows with every entry.
    pub id: i64,
    pub at: Timestamp,
    pub actor: Actor,
    pub action: String,
    pub database: Option<String>,
    /// What of it: an alias, a version's number, an exemplar's id, a key's id.
    pub subject: Option<String>,
    /// JSON.
    pub detail: String,
}

/// Which entries are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AuditFilter {
    pub database: Option<String>,
    /// Id of a key: what was done with it.
    pub key: Option<String>,
    pub action: Option<String>,
}

/// An entry to be written.
pub(super) struct Entry<'a> {
    pub action: &'static str,
    pub database: Option<&'a str>,
    pub subject: Option<String>,
    pub detail: Value,
}

impl<'a> Entry<'a> {
    pub fn of(action: &'static str) -> Self {
        Self { action, database: None, subject: None, detail: Value::Object(Default::default()) }
    }

    pub fn in_database(self, database: &'a str) -> Self {
        Self { database: Some(database), ..self }
    }

    pub fn about(self, subject: impl ToString) -> Self {
        Self { subject: Some(subject.to_string()), ..self }
    }

    pub fn with(self, detail: Value) -> Self {
        Self { detail, ..self }
    }
}

/// A kept document as a part of an entry's detail.
pub(super) fn document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))
}

impl ExemplarFilter {
    /// What was deleted by it.
    pub(super) fn detail(&self, deleted: u64) -> Value {
        let time = |time: Option<Timestamp>| time.map(|time| time.to_string());
        json!({
            "label": self.label, "robot_id": self.robot_id,
            "since": time(self.since), "before": time(self.before), "deleted": deleted,
        })
    }
}

impl NewKey {
    /// What it may do.
    pub(super) fn detail(&self) -> Value {
        json!({
            "name": self.name, "scope": self.scope,
            "databases": self.databases.as_deref().map(document), "requests_per_s": self.requests_per_s,
        })
    }
}
