//! The table `versions`.

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row, to_column};

/// A trained artifact before it has its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewVersion {
    /// The database's name.
    pub database: String,
    /// Digest of the inputs: the same digest in one database is the same version.
    pub digest: String,
    /// Name of the artifact's blob, as `BlobName` writes it.
    pub blob: String,
    /// Size of the artifact.
    pub bytes: u64,
    /// What it recognises: `landmarks` or `objects`.
    pub kind: String,
    /// Revision of the training algorithm that made it.
    pub algorithm_revision: i64,
    /// The options it was trained with, as JSON.
    pub options: String,
    /// How much it was trained from, as JSON.
    pub counts: String,
    /// The report of its training, as JSON.
    pub report: String,
}

/// A trained artifact; it never changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VersionRow {
    /// The database's name.
    pub database: String,
    /// Counts 1, 2, 3 … in its database; the number of a deleted version isn't given again.
    pub version: i64,
    /// Digest of the inputs, unique in its database.
    pub digest: String,
    /// Name of the artifact's blob, as `BlobName` writes it.
    pub blob: String,
    /// Size of the artifact.
    pub bytes: u64,
    /// What it recognises: `landmarks` or `objects`.
    pub kind: String,
    /// Revision of the training algorithm that made it.
    pub algorithm_revision: i64,
    /// The options it was trained with, as JSON.
    pub options: String,
    /// How much it was trained from, as JSON.
    pub counts: String,
    /// The report of its training, as JSON.
    pub report: String,
    /// When it got its number.
    pub created_at: Timestamp,
}

impl NewVersion {
    /// A version that is there, to be published again: its digest finds it.
    pub fn again(row: VersionRow) -> Self {
        let VersionRow {
            database,
            digest,
            blob,
            bytes,
            kind,
            algorithm_revision,
            options,
            counts,
            report,
            ..
        } = row;
        Self { database, digest, blob, bytes, kind, algorithm_revision, options, counts, report }
    }
}

impl FromRow for VersionRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            database: row.get("database")?,
            version: row.get("version")?,
            digest: row.get("digest")?,
            blob: row.get("blob")?,
            bytes: row.unsigned("bytes")?,
            kind: row.get("kind")?,
            algorithm_revision: row.get("algorithm_revision")?,
            options: row.get("options")?,
            counts: row.get("counts")?,
            report: row.get("report")?,
            created_at: row.time("created_at")?,
        })
    }
}

/// A database's name, a version's number and its digest.
impl FromRow for (String, i64, String) {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok((row.get("database")?, row.get("version")?, row.get("digest")?))
    }
}

/// Adds a version under the next number, or gives the existing one of that digest, with `false`. Errors: `NotFound` for
/// the database.
pub async fn insert(
    connection: &mut Connection<'_>,
    new: &NewVersion,
) -> Result<(VersionRow, bool), CatalogueError> {
    if let Some(existing) = find_by_digest(connection, &new.database, &new.digest).await? {
        return Ok((existing, false));
    }
    // The counter stands beside the rows, so that deleting the last version doesn't give its number back.
    let number: i64 = connection
        .query("UPDATE databases SET last_version = last_version + 1 WHERE name = $1 RETURNING last_version")
        .bind(&new.database)
        .fetch_optional()
        .await?
        .ok_or_else(|| CatalogueError::no_database(&new.database))?;
    let inserted = connection
        .query(
            "INSERT INTO versions (database, version, digest, blob, bytes, kind, algorithm_revision, options,
                                   counts, report, created_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, now_us()) RETURNING *",
        )
        .bind(&new.database)
        .bind(number)
        .bind(&new.digest)
        .bind(&new.blob)
        .bind(to_column(new.bytes))
        .bind(&new.kind)
        .bind(new.algorithm_revision)
        .bind(&new.options)
        .bind(&new.counts)
        .bind(&new.report)
        .fetch_one()
        .await?;
    Ok((inserted, true))
}

/// The version of that number.
pub async fn find(
    connection: &mut Connection<'_>,
    database: &str,
    version: i64,
) -> Result<Option<VersionRow>, CatalogueError> {
    connection
        .query("SELECT * FROM versions WHERE database = $1 AND version = $2")
        .bind(database)
        .bind(version)
        .fetch_optional()
        .await
}

/// The version made from these inputs.
pub async fn find_by_digest(
    connection: &mut Connection<'_>,
    database: &str,
    digest: &str,
) -> Result<Option<VersionRow>, CatalogueError> {
    connection
        .query("SELECT * FROM versions WHERE database = $1 AND digest = $2")
        .bind(database)
        .bind(digest)
        .fetch_optional()
        .await
}

/// Replaces the report of a version, if that is there.
pub async fn set_report(
    connection: &mut Connection<'_>,
    database: &str,
    version: i64,
    report: &str,
) -> Result<(), CatalogueError> {
    connection
        .query("UPDATE versions SET report = $3 WHERE database = $1 AND version = $2")
        .bind(database)
        .bind(version)
        .bind(report)
        .execute()
        .await?;
    Ok(())
}

/// Versions by number.
pub async fn list(
    connection: &mut Connection<'_>,
    database: &str,
    after: Option<i64>,
    limit: u32,
) -> Result<Vec<VersionRow>, CatalogueError> {
    connection
        .query(
            "SELECT * FROM versions WHERE database = $1 AND ($2 IS NULL OR version > $2)
             ORDER BY version LIMIT $3",
        )
        .bind(database)
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// Those of these versions that are there, with their digests.
pub async fn digests(
    connection: &mut Connection<'_>,
    versions: &[(String, i64)],
) -> Result<Vec<(String, i64, String)>, CatalogueError> {
    let (databases, numbers): (Vec<&str>, Vec<i64>) =
        versions.iter().map(|(database, version)| (database.as_str(), *version)).unzip();
    connection
        .query_per_dialect(
            "SELECT v.database, v.version, v.digest
             FROM json_each($1) AS w JOIN versions v ON v.database = w.value AND v.version = $2 ->> w.key",
            "SELECT v.database, v.version, v.digest
             FROM unnest($1, $2) AS w (database, version)
             JOIN versions v ON v.database = w.database AND v.version = w.version",
        )
        .bind_list(&databases)
        .bind_list(&numbers)
        .fetch_all()
        .await
}

/// Deletes a version; false when there was none. Errors: `Conflict` while an alias points to it.
pub async fn delete(
    connection: &mut Connection<'_>,
    database: &str,
    version: i64,
) -> Result<bool, CatalogueError> {
    let alias: Option<String> = connection
        .query("SELECT alias FROM aliases WHERE database = $1 AND version = $2 ORDER BY alias")
        .bind(database)
        .bind(version)
        .fetch_optional()
        .await?;
    if let Some(alias) = alias {
        return Err(CatalogueError::aliased(database, version, &alias));
    }
    let deleted = connection
        .query("DELETE FROM versions WHERE database = $1 AND version = $2")
        .bind(database)
        .bind(version)
        .execute()
        .await?;
    Ok(deleted > 0)
}
