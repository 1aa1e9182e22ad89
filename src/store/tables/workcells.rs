//! The table `workcells`.

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{Connection, FromRow, Row};

/// What is known of a workcell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorkcellRow {
    /// Unique among the workcells.
    pub name: String,
    /// The workcell, as JSON.
    pub document: String,
    /// When it was created.
    pub created_at: Timestamp,
    /// When its document was replaced last.
    pub updated_at: Timestamp,
}

impl FromRow for WorkcellRow {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            name: row.get("name")?,
            document: row.get("document")?,
            created_at: row.time("created_at")?,
            updated_at: row.time("updated_at")?,
        })
    }
}

/// Replaces the workcell's document, or creates the workcell, with `true`.
pub async fn put(
    connection: &mut Connection<'_>,
    name: &str,
    document: &str,
) -> Result<(WorkcellRow, bool), CatalogueError> {
    loop {
        let replaced = connection
            .query("UPDATE workcells SET document = $2, updated_at = now_us() WHERE name = $1 RETURNING *")
            .bind(name)
            .bind(document)
            .fetch_optional()
            .await?;
        if let Some(replaced) = replaced {
            return Ok((replaced, false));
        }
        // No row when another transaction created the workcell meanwhile: the next turn replaces that one.
        let created = connection
            .query(
                "INSERT INTO workcells (name, document, created_at, updated_at)
                 VALUES ($1, $2, now_us(), now_us()) ON CONFLICT (name) DO NOTHING RETURNING *",
            )
            .bind(name)
            .bind(document)
            .fetch_optional()
            .await?;
        if let Some(created) = created {
            return Ok((created, true));
        }
    }
}

/// The workcell of that name.
pub async fn find(
    connection: &mut Connection<'_>,
    name: &str,
) -> Result<Option<WorkcellRow>, CatalogueError> {
    connection.query("SELECT * FROM workcells WHERE name = $1").bind(name).fetch_optional().await
}

/// Workcells by name.
pub async fn list(
    connection: &mut Connection<'_>,
    after: Option<&str>,
    limit: u32,
) -> Result<Vec<WorkcellRow>, CatalogueError> {
    connection
        .query("SELECT * FROM workcells WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2")
        .bind(after)
        .bind(i64::from(limit))
        .fetch_all()
        .await
}

/// Deletes a workcell; false when there was none.
pub async fn delete(connection: &mut Connection<'_>, name: &str) -> Result<bool, CatalogueError> {
    Ok(connection.query("DELETE FROM workcells WHERE name = $1").bind(name).execute().await? > 0)
}
