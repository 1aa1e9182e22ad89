//! The table `databases`.

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// A named database of exemplars and the versions trained from them.
#[derive(Debug, Clone, PartialEq)]
pub struct DatabaseRow {
    /// Unique among the databases.
    pub name: String,
    /// What its versions recognise: `landmarks` or `objects`.
    pub kind: String,
    /// How its versions are trained, as JSON.
    pub options: String,
    /// When it was created.
    pub created_at: Timestamp,
}

impl FromRow for DatabaseRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            name: row.get("name")?,
            kind: row.get("kind")?,
            options: row.get("options")?,
            created_at: row.time("created_at")?,
        })
    }
}

/// How much a database holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DatabaseCounts {
    /// Training images.
    pub exemplars: u64,
    /// Distinct labels among the exemplars.
    pub labels: u64,
    /// Versions that are still kept.
    pub versions: u64,
}

impl FromRow for DatabaseCounts {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            exemplars: row.unsigned("exemplars")?,
            labels: row.unsigned("labels")?,
            versions: row.unsigned("versions")?,
        })
    }
}

/// Creates the database, or gives the existing one of that name unchanged, with `false`.
pub async fn create(
    connection: &mut Connection<'_>,
    name: &str,
    kind: &str,
    options: &str,
) -> Result<(DatabaseRow, bool), CatalogueError> {
    loop {
        if let Some(existing) = find(connection, name).await? {
            return Ok((existing, false));
        }
        // No row when another transaction created the database meanwhile: the next turn finds that one.
        let created = connection
            .query(
                "INSERT INTO databases (name, kind, options, created_at) VALUES ($1, $2, $3, now_us())
                 ON CONFLICT (name) DO NOTHING RETURNING *",
            )
            .bind(name)
            .bind(kind)
            .bind(options)
            .fetch_optional()
            .await?;
        if let Some(created) = created {
            return Ok((created, true));
        }
    }
}

/// Replaces the options. Errors: `NotFound`.
pub async fn set_options(
    connection: &mut Connection<'_>,
    name: &str,
    options: &str,
) -> Result<DatabaseRow, CatalogueError> {
    connection
        .query("UPDATE databases SET options = $2 WHERE name = $1 RETURNING *")
        .bind(name)
        .bind(options)
        .fetch_optional()
        .await?
        .ok_or_else(|| CatalogueError::no_database(name))
}

/// Lets nobody else change the database's versions and aliases, or delete it, until the transaction ends.
///
/// False when there is none; another transaction may create it at any moment then, so the caller has to give up.
pub async fn lock(connection: &mut Connection<'_>, name: &str) -> Result<bool, CatalogueError> {
    let locked: Option<String> = connection
        .query("SELECT name FROM databases WHERE name = $1 FOR NO KEY UPDATE")
        .bind(name)
        .fetch_optional()
        .await?;
    Ok(locked.is_some())
}

/// Lets nobody delete the database until the transaction ends. Errors: `NotFound`.
pub async fn lock_against_deletion(
    connection: &mut Connection<'_>,
    name: &str,
) -> Result<(), CatalogueError> {
    let locked: Option<String> = connection
        .query("SELECT name FROM databases WHERE name = $1 FOR KEY SHARE")
        .bind(name)
        .fetch_optional()
        .await?;
    locked.map(drop).ok_or_else(|| CatalogueError::no_database(name))
}

/// The database of that name.
pub async fn find(
    connection: &mut Connection<'_>,
    name: &str,
) -> Result<Option<DatabaseRow>, CatalogueError> {
    connection.query("SELECT * FROM databases WHERE name = $1").bind(name).fetch_optional().await
}

/// Databases by name.
pub async fn list(
    connection: &mut Connection<'_>,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<DatabaseRow>, CatalogueError> {
    connection
        .query("SELECT * FROM databases WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2")
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// Deletes the row; exemplars, versions and aliases go with it by cascade.
pub async fn delete(connection: &mut Connection<'_>, name: &str) -> Result<bool, CatalogueError> {
    Ok(connection.query("DELETE FROM databases WHERE name = $1").bind(name).execute().await? > 0)
}

/// Counts what the database holds. Errors: `NotFound`.
pub async fn counts(connection: &mut Connection<'_>, name: &str) -> Result<DatabaseCounts, CatalogueError> {
    connection
        .query(
            "SELECT (SELECT count(*) FROM exemplars WHERE database = name) AS exemplars,
                    (SELECT count(DISTINCT label) FROM exemplars WHERE database = name AND NOT negative) AS labels,
                    (SELECT count(*) FROM versions WHERE database = name) AS versions
             FROM databases WHERE name = $1",
        )
        .bind(name)
        .fetch_optional()
        .await?
        .ok_or_else(|| CatalogueError::no_database(name))
}
