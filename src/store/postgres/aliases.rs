//! Statements on the table `aliases`: the only compare-and-swap of the service.

use sqlx::Row;
use sqlx::postgres::{PgConnection, PgRow};

use super::versions;
use crate::store::row::time;
use crate::store::{AliasExpectation, AliasRow, AliasTarget, CatalogueError};

fn read(row: &PgRow) -> Result<AliasRow, CatalogueError> {
    Ok(AliasRow {
        database: row.try_get("database")?,
        alias: row.try_get("alias")?,
        version: row.try_get("version")?,
        revision: row.try_get("revision")?,
        updated_at: time(row, "updated_at")?,
    })
}

fn read_target(row: &PgRow) -> Result<AliasTarget, CatalogueError> {
    Ok(AliasTarget {
        database: row.try_get("database")?,
        kind: row.try_get("kind")?,
        alias: row.try_get("alias")?,
        version: row.try_get("version")?,
        digest: row.try_get("digest")?,
        blob: row.try_get("blob")?,
        revision: row.try_get("revision")?,
    })
}

pub async fn list(connection: &mut PgConnection, database: &str) -> Result<Vec<AliasRow>, CatalogueError> {
    let rows = sqlx::query("SELECT * FROM aliases WHERE database = $1 ORDER BY alias")
        .bind(database)
        .fetch_all(connection)
        .await?;
    rows.iter().map(read).collect()
}

pub async fn list_all(connection: &mut PgConnection) -> Result<Vec<AliasTarget>, CatalogueError> {
    let rows = sqlx::query(
        "SELECT a.database, v.kind, a.alias, a.version, v.digest, v.blob, a.revision
         FROM aliases a JOIN versions v ON v.database = a.database AND v.version = a.version
         ORDER BY a.database, a.alias",
    )
    .fetch_all(connection)
    .await?;
    rows.iter().map(read_target).collect()
}

/// Gives the alias's present revision, if it is as expected.
async fn compare(
    connection: &mut PgConnection,
    database: &str,
    alias: &str,
    expected: AliasExpectation,
) -> Result<Option<i64>, CatalogueError> {
    let revision: Option<i64> =
        sqlx::query_scalar("SELECT revision FROM aliases WHERE database = $1 AND alias = $2")
            .bind(database)
            .bind(alias)
            .fetch_optional(connection)
            .await?;
    let met = match expected {
        AliasExpectation::Any => true,
        AliasExpectation::Absent => revision.is_none(),
        AliasExpectation::Revision(wanted) => revision == Some(wanted),
    };
    if met { Ok(revision) } else { Err(CatalogueError::PreconditionFailed) }
}

pub async fn set(
    connection: &mut PgConnection,
    database: &str,
    alias: &str,
    version: i64,
    expected: AliasExpectation,
) -> Result<(AliasRow, bool), CatalogueError> {
    let existing = compare(connection, database, alias, expected).await?;
    if versions::find(connection, database, version).await?.is_none() {
        return Err(CatalogueError::no_version(database, version));
    }
    // From a counter, not from the row: an alias deleted and made again must not repeat a revision.
    let revision: i64 = sqlx::query_scalar(
        "UPDATE databases SET last_revision = last_revision + 1 WHERE name = $1 RETURNING last_revision",
    )
    .bind(database)
    .fetch_one(&mut *connection)
    .await?;
    let row = sqlx::query(
        "INSERT INTO aliases (database, alias, version, revision, updated_at) VALUES ($1, $2, $3, $4, now_us())
         ON CONFLICT (database, alias) DO UPDATE
         SET version = excluded.version, revision = excluded.revision, updated_at = excluded.updated_at
         RETURNING *",
    )
    .bind(database)
    .bind(alias)
    .bind(version)
    .bind(revision)
    .fetch_one(connection)
    .await?;
    Ok((read(&row)?, existing.is_none()))
}

pub async fn delete(
    connection: &mut PgConnection,
    database: &str,
    alias: &str,
    expected: AliasExpectation,
) -> Result<bool, CatalogueError> {
    compare(connection, database, alias, expected).await?;
    let done = sqlx::query("DELETE FROM aliases WHERE database = $1 AND alias = $2")
        .bind(database)
        .bind(alias)
        .execute(connection)
        .await?;
    Ok(done.rows_affected() > 0)
}
