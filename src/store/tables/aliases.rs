//! The table `aliases`: moving names for versions, changed by compare-and-swap.

use jiff::Timestamp;

use super::versions;
use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// A moving name for a version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AliasRow {
    /// The database's name.
    pub database: String,
    /// Unique in its database.
    pub alias: String,
    /// The version that it points to.
    pub version: i64,
    /// Grows with every move; no two states of the database's aliases share one, not even after a deletion.
    pub revision: i64,
    /// When it was moved last.
    pub updated_at: Timestamp,
}

impl FromRow for AliasRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            database: row.get("database")?,
            alias: row.get("alias")?,
            version: row.get("version")?,
            revision: row.get("revision")?,
            updated_at: row.time("updated_at")?,
        })
    }
}

/// An alias and what the registry needs to load the version it points to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AliasTarget {
    /// The database's name.
    pub database: String,
    /// What the version recognises: `landmarks` or `objects`.
    pub kind: String,
    /// The alias's name.
    pub alias: String,
    /// The version that it points to.
    pub version: i64,
    /// Digest of the version's inputs.
    pub digest: String,
    /// Name of the artifact's blob, as `BlobName` writes it.
    pub blob: String,
    /// Size of the artifact.
    pub bytes: u64,
    /// The alias's revision.
    pub revision: i64,
}

impl FromRow for AliasTarget {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            database: row.get("database")?,
            kind: row.get("kind")?,
            alias: row.get("alias")?,
            version: row.get("version")?,
            digest: row.get("digest")?,
            blob: row.get("blob")?,
            bytes: row.unsigned("bytes")?,
            revision: row.get("revision")?,
        })
    }
}

/// What the caller takes the alias to be before a change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AliasExpectation {
    /// Whatever it is.
    Any,
    /// Not there yet.
    Absent,
    /// There, at this revision.
    Revision(i64),
}

impl AliasExpectation {
    /// Refuses an alias at another revision than the expected one; none means that there is no alias. Errors:
    /// `PreconditionFailed`.
    pub(in crate::store) fn check(self, revision: Option<i64>) -> Result<(), CatalogueError> {
        let is_met = match self {
            Self::Any => true,
            Self::Absent => revision.is_none(),
            Self::Revision(expected) => revision == Some(expected),
        };
        if is_met { Ok(()) } else { Err(CatalogueError::PreconditionFailed) }
    }
}

/// The aliases of a database, by name.
pub async fn list(connection: &mut Connection<'_>, database: &str) -> Result<Vec<AliasRow>, CatalogueError> {
    connection
        .query("SELECT * FROM aliases WHERE database = $1 ORDER BY alias")
        .bind(database)
        .fetch_all()
        .await
}

/// The aliases of every database, by database and name.
pub async fn list_all(connection: &mut Connection<'_>) -> Result<Vec<AliasTarget>, CatalogueError> {
    connection
        .query(
            "SELECT a.database, v.kind, a.alias, a.version, v.digest, v.blob, v.bytes, a.revision
             FROM aliases a JOIN versions v ON v.database = a.database AND v.version = a.version
             ORDER BY a.database, a.alias",
        )
        .fetch_all()
        .await
}

/// The alias's present revision; none when there is no alias.
async fn find_revision(
    connection: &mut Connection<'_>,
    database: &str,
    alias: &str,
) -> Result<Option<i64>, CatalogueError> {
    connection
        .query("SELECT revision FROM aliases WHERE database = $1 AND alias = $2")
        .bind(database)
        .bind(alias)
        .fetch_optional()
        .await
}

/// Points an alias to a version; `true` when it is new. Errors: `NotFound` for the version, `PreconditionFailed`.
pub async fn set(
    connection: &mut Connection<'_>,
    database: &str,
    alias: &str,
    version: i64,
    expected: AliasExpectation,
) -> Result<(AliasRow, bool), CatalogueError> {
    let before = find_revision(connection, database, alias).await?;
    expected.check(before)?;
    if versions::find(connection, database, version).await?.is_none() {
        return Err(CatalogueError::no_version(database, version));
    }
    // From a counter, not from the row: an alias deleted and made again must not repeat a revision.
    let revision: i64 = connection
        .query(
            "UPDATE databases SET last_revision = last_revision + 1 WHERE name = $1 RETURNING last_revision",
        )
        .bind(database)
        .fetch_one()
        .await?;
    let set = connection
        .query(
            "INSERT INTO aliases (database, alias, version, revision, updated_at)
             VALUES ($1, $2, $3, $4, now_us())
             ON CONFLICT (database, alias) DO UPDATE
             SET version = excluded.version, revision = excluded.revision, updated_at = excluded.updated_at
             RETURNING *",
        )
        .bind(database)
        .bind(alias)
        .bind(version)
        .bind(revision)
        .fetch_one()
        .await?;
    Ok((set, before.is_none()))
}

/// Deletes an alias; false when there was none and `expected` allows it. Errors: `PreconditionFailed`.
pub async fn delete(
    connection: &mut Connection<'_>,
    database: &str,
    alias: &str,
    expected: AliasExpectation,
) -> Result<bool, CatalogueError> {
    expected.check(find_revision(connection, database, alias).await?)?;
    let deleted = connection
        .query("DELETE FROM aliases WHERE database = $1 AND alias = $2")
        .bind(database)
        .bind(alias)
        .execute()
        .await?;
    Ok(deleted > 0)
}
