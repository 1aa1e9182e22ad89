//! Tables of documents under names, in which who writes last wins: workcells, cameras.

use jiff::Timestamp;

use crate::store::CatalogueError;
use crate::store::query::{FromRow, Row};

/// A document under its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedDocument {
    /// Unique in its table.
    pub name: String,
    /// JSON.
    pub document: String,
    /// When it was created.
    pub created_at: Timestamp,
    /// When it was replaced last.
    pub updated_at: Timestamp,
}

impl FromRow for NamedDocument {
    fn from_row(row: &Row) -> Result<Self, CatalogueError> {
        Ok(Self {
            name: row.get("name")?,
            document: row.get("document")?,
            created_at: row.time("created_at")?,
            updated_at: row.time("updated_at")?,
        })
    }
}

/// The statements on such a table.
macro_rules! named_documents {
    ($table:literal) => {
        use crate::store::CatalogueError;
        use crate::store::query::Connection;
        use crate::store::tables::named_documents::NamedDocument;

        /// Replaces the document of that name, or creates it, with `true`.
        pub async fn put(
            connection: &mut Connection<'_>,
            name: &str,
            document: &str,
        ) -> Result<(NamedDocument, bool), CatalogueError> {
            loop {
                let update = concat!(
                    "UPDATE ",
                    $table,
                    " SET document = $2, updated_at = now_us() WHERE name = $1 RETURNING *"
                );
                let replaced = connection.query(update).bind(name).bind(document).fetch_optional().await?;
                if let Some(replaced) = replaced {
                    return Ok((replaced, false));
                }
                // No row when another transaction created it meanwhile: the next turn replaces that one.
                let insert = concat!(
                    "INSERT INTO ",
                    $table,
                    " (name, document, created_at, updated_at) VALUES ($1, $2, now_us(), now_us())",
                    " ON CONFLICT (name) DO NOTHING RETURNING *"
                );
                let created = connection.query(insert).bind(name).bind(document).fetch_optional().await?;
                if let Some(created) = created {
                    return Ok((created, true));
                }
            }
        }

        /// The document of that name.
        pub async fn find(
            connection: &mut Connection<'_>,
            name: &str,
        ) -> Result<Option<NamedDocument>, CatalogueError> {
            let select = concat!("SELECT * FROM ", $table, " WHERE name = $1");
            connection.query(select).bind(name).fetch_optional().await
        }

        /// Documents by name.
        pub async fn list(
            connection: &mut Connection<'_>,
            after: Option<&str>,
            limit: u32,
        ) -> Result<Vec<NamedDocument>, CatalogueError> {
            let select =
                concat!("SELECT * FROM ", $table, " WHERE ($1 IS NULL OR name > $1) ORDER BY name LIMIT $2");
            connection.query(select).bind(after).bind(i64::from(limit)).fetch_all().await
        }

        /// Deletes a document; false when there was none.
        pub async fn delete(connection: &mut Connection<'_>, name: &str) -> Result<bool, CatalogueError> {
            let delete = concat!("DELETE FROM ", $table, " WHERE name = $1");
            Ok(connection.query(delete).bind(name).execute().await? > 0)
        }
    };
}

pub(super) use named_documents;
