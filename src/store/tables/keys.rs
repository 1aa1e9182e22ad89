//! The table `keys`: API keys, of which only the hash is kept.

use jiff::Timestamp;
use serde_json::{Value, json};

use super::audit::parse_document;
use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// An API key before it is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewKey {
    /// The public part of the key.
    pub id: String,
    /// What people call it.
    pub name: String,
    /// SHA-256 of the whole key, hex.
    pub hash: String,
    /// What it may do: `recognise`, `contribute`, `train` or `admin`.
    pub scope: String,
    /// JSON array of name patterns; none: every database.
    pub databases: Option<String>,
    /// The most requests in a second; none: as many as there are.
    pub requests_per_s: Option<i64>,
}

impl NewKey {
    /// The audit entry's detail: what the key may do.
    pub(in crate::store) fn audit_detail(&self) -> Value {
        json!({
            "name": self.name, "scope": self.scope,
            "databases": self.databases.as_deref().map(parse_document), "requests_per_s": self.requests_per_s,
        })
    }
}

/// An API key; the key itself is not kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyRow {
    /// The public part of the key.
    pub id: String,
    /// What people call it.
    pub name: String,
    /// SHA-256 of the whole key, hex.
    pub hash: String,
    /// What it may do: `recognise`, `contribute`, `train` or `admin`.
    pub scope: String,
    /// JSON array of name patterns; none: every database.
    pub databases: Option<String>,
    /// The most requests in a second; none: as many as there are.
    pub requests_per_s: Option<i64>,
    /// When it was made.
    pub created_at: Timestamp,
    /// To within a minute or so: uses are recorded now and then.
    pub last_used_at: Option<Timestamp>,
    /// When it was revoked; none while it is in force.
    pub revoked_at: Option<Timestamp>,
}

impl FromRow for KeyRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            id: row.get("id")?,
            name: row.get("name")?,
            hash: row.get("hash")?,
            scope: row.get("scope")?,
            databases: row.get("databases")?,
            requests_per_s: row.get("requests_per_s")?,
            created_at: row.time("created_at")?,
            last_used_at: row.optional_time("last_used_at")?,
            revoked_at: row.optional_time("revoked_at")?,
        })
    }
}

/// Adds a key.
pub async fn insert(connection: &mut Connection<'_>, new: &NewKey) -> Result<KeyRow, CatalogueError> {
    connection
        .query(
            "INSERT INTO keys (id, name, hash, scope, databases, requests_per_s, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, now_us()) RETURNING *",
        )
        .bind(&new.id)
        .bind(&new.name)
        .bind(&new.hash)
        .bind(&new.scope)
        .bind(&new.databases)
        .bind(new.requests_per_s)
        .fetch_one()
        .await
}

/// The key of that id, revoked or not.
pub async fn find(connection: &mut Connection<'_>, id: &str) -> Result<Option<KeyRow>, CatalogueError> {
    connection.query("SELECT * FROM keys WHERE id = $1").bind(id).fetch_optional().await
}

/// Every key that ever was, the oldest first.
pub async fn list(connection: &mut Connection<'_>) -> Result<Vec<KeyRow>, CatalogueError> {
    connection.query("SELECT * FROM keys ORDER BY created_at, id").fetch_all().await
}

/// Revokes a key; true when it was in force until now.
pub async fn revoke(connection: &mut Connection<'_>, id: &str) -> Result<bool, CatalogueError> {
    let revoked = connection
        .query("UPDATE keys SET revoked_at = now_us() WHERE id = $1 AND revoked_at IS NULL")
        .bind(id)
        .execute()
        .await?;
    Ok(revoked > 0)
}

/// Records when a key was used; a time before the recorded one changes nothing.
pub async fn record_use(
    connection: &mut Connection<'_>,
    id: &str,
    used_at: Timestamp,
) -> Result<(), CatalogueError> {
    connection
        .query(
            "UPDATE keys SET last_used_at = $2 WHERE id = $1 AND (last_used_at IS NULL OR last_used_at < $2)",
        )
        .bind(id)
        .bind(used_at.as_microsecond())
        .execute()
        .await?;
    Ok(())
}
