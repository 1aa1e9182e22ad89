//! The table `audit`: who changed what. An entry is written in the transaction of the change, and never again.

use jiff::Timestamp;
use serde_json::Value;
use uuid::Uuid;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// Who makes a change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Actor {
    /// Id of the key that the call came with.
    pub key: Option<String>,
    /// The key's name; without a key, another name of who makes the change.
    pub name: String,
    /// Id of the request that makes the change.
    pub request_id: Option<String>,
}

impl Actor {
    /// An actor without a key.
    pub fn named(name: impl Into<String>) -> Self {
        Self { key: None, name: name.into(), request_id: None }
    }

    /// A job; the entry `job.queue` about it says who queued it.
    pub(in crate::store) fn job(id: Uuid) -> Self {
        Self::named(format!("job {id}"))
    }
}

/// An entry of the audit record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AuditRow {
    /// Grows with every entry.
    pub id: i64,
    /// When the change was made.
    pub at: Timestamp,
    /// Who made it.
    pub actor: Actor,
    /// What was done, for instance `alias.set`.
    pub action: String,
    /// The database that was changed, if it was one.
    pub database: Option<String>,
    /// What of it: an alias, a version's number, an exemplar's id, a key's id.
    pub subject: Option<String>,
    /// What else there is to say of the change, as JSON.
    pub detail: String,
}

impl FromRow for AuditRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            id: row.get("id")?,
            at: row.time("at")?,
            actor: Actor {
                key: row.get("key")?,
                name: row.get("actor")?,
                request_id: row.get("request_id")?,
            },
            action: row.get("action")?,
            database: row.get("database")?,
            subject: row.get("subject")?,
            detail: row.get("detail")?,
        })
    }
}

/// Which entries are meant: those that match every field that is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AuditFilter {
    /// Changes of this database.
    pub database: Option<String>,
    /// Changes made with the key of this id.
    pub key: Option<String>,
    /// Changes of this kind, for instance `alias.set`.
    pub action: Option<String>,
}

/// An entry before it is written.
pub struct NewEntry<'a> {
    action: &'static str,
    database: Option<&'a str>,
    subject: Option<String>,
    detail: Value,
}

impl<'a> NewEntry<'a> {
    /// An entry that says no more than what was done.
    pub fn new(action: &'static str) -> Self {
        Self { action, database: None, subject: None, detail: Value::Object(Default::default()) }
    }

    /// Names the database that was changed, if it was one.
    pub fn in_database(self, database: impl Into<Option<&'a str>>) -> Self {
        Self { database: database.into(), ..self }
    }

    /// Names what was changed.
    pub fn about(self, subject: impl ToString) -> Self {
        Self { subject: Some(subject.to_string()), ..self }
    }

    /// Adds the detail, a JSON object.
    pub fn with(self, detail: Value) -> Self {
        Self { detail, ..self }
    }
}

/// A document's text as a part of an entry's detail.
pub fn parse_document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| Value::from(text))
}

/// Writes an entry.
pub async fn append(
    connection: &mut Connection<'_>,
    actor: &Actor,
    entry: NewEntry<'_>,
) -> Result<(), CatalogueError> {
    connection
        .query(
            "INSERT INTO audit (key, actor, request_id, action, database, subject, detail, at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, now_us())",
        )
        .bind(&actor.key)
        .bind(&actor.name)
        .bind(&actor.request_id)
        .bind(entry.action)
        .bind(entry.database)
        .bind(entry.subject)
        .bind(entry.detail.to_string())
        .execute()
        .await?;
    Ok(())
}

/// Entries, the newest first; `before` is the oldest one seen.
pub async fn list(
    connection: &mut Connection<'_>,
    filter: &AuditFilter,
    before: Option<i64>,
    limit: u32,
) -> Result<Vec<AuditRow>, CatalogueError> {
    connection
        .query(
            "SELECT * FROM audit
             WHERE ($1 IS NULL OR database = $1) AND ($2 IS NULL OR key = $2) AND ($3 IS NULL OR action = $3)
               AND ($4 IS NULL OR id < $4)
             ORDER BY id DESC LIMIT $5",
        )
        .bind(&filter.database)
        .bind(&filter.key)
        .bind(&filter.action)
        .bind(before)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}
