//! Databases, with their exemplars, versions and aliases.

use serde_json::json;
use uuid::Uuid;

use super::Catalogue;
use crate::store::error::CatalogueError;
use crate::store::query::Connection;
use crate::store::session::{statement, transaction};
use crate::store::tables::aliases::{self, AliasExpectation, AliasRow, AliasTarget};
use crate::store::tables::audit::{self, Actor, NewEntry, parse_document};
use crate::store::tables::databases::{self, DatabaseCounts, DatabaseRow};
use crate::store::tables::exemplars::{self, ExemplarFilter, ExemplarRow};
use crate::store::tables::jobs::{self, Subject};
use crate::store::tables::versions::{self, NewVersion, VersionRow};

impl Catalogue {
    /// Creates a database, or gives the existing one of that name unchanged, whatever its kind, with `false`.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn create_database(
        &self,
        name: &str,
        kind: &str,
        options: &str,
        actor: &Actor,
    ) -> Result<(DatabaseRow, bool), CatalogueError> {
        transaction!(self, c => {
            let created = databases::create(c, name, kind, options).await?;
            if created.1 {
                let detail = json!({"kind": kind, "options": parse_document(options)});
                audit::append(c, actor, NewEntry::new("database.create").in_database(name).with(detail)).await?;
            }
            Ok(created)
        })
    }

    /// Replaces a database's options.
    ///
    /// # Errors
    /// `NotFound`; `Unavailable`, `Corrupt`.
    pub async fn set_database_options(
        &self,
        name: &str,
        options: &str,
        actor: &Actor,
    ) -> Result<DatabaseRow, CatalogueError> {
        transaction!(self, c => {
            let row = databases::set_options(c, name, options).await?;
            let detail = json!({"options": parse_document(options)});
            audit::append(c, actor, NewEntry::new("database.options").in_database(name).with(detail)).await?;
            Ok(row)
        })
    }

    /// The database of that name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn database(&self, name: &str) -> Result<Option<DatabaseRow>, CatalogueError> {
        statement!(self, c => databases::find(c, name).await)
    }

    /// Databases by name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn databases(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<DatabaseRow>, CatalogueError> {
        statement!(self, c => databases::list(c, after, limit).await)
    }

    /// Deletes a database with its exemplars, versions and aliases, and cancels its unfinished jobs.
    ///
    /// False when there was none.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn delete_database(&self, name: &str, actor: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = databases::delete(c, name).await?;
            jobs::cancel_all(c, Subject::Database(name)).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("database.delete").in_database(name)).await?;
            }
            c.notifies = true;
            Ok(deleted)
        })
    }

    /// Counts what a database holds.
    ///
    /// # Errors
    /// `NotFound`; `Unavailable`, `Corrupt`.
    pub async fn database_counts(&self, name: &str) -> Result<DatabaseCounts, CatalogueError> {
        statement!(self, c => databases::counts(c, name).await)
    }

    /// Adds an exemplar, or gives the existing one of that database and id unchanged, with `false`.
    ///
    /// Its blob must be stored before.
    ///
    /// # Errors
    /// `NotFound` for the database; `Unavailable`, `Corrupt`.
    pub async fn insert_exemplar(&self, row: &ExemplarRow) -> Result<(ExemplarRow, bool), CatalogueError> {
        transaction!(self, c => exemplars::insert(c, row).await)
    }

    /// Replaces the survey of an exemplar if it is still `before`, and gives it; none when it isn't, or there is none of that id.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn change_exemplar_survey(
        &self,
        database: &str,
        id: Uuid,
        before: Option<&str>,
        after: Option<&str>,
    ) -> Result<Option<ExemplarRow>, CatalogueError> {
        transaction!(self, c => exemplars::change_survey(c, database, id, before, after).await)
    }

    /// The exemplar of that id.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn exemplar(&self, database: &str, id: Uuid) -> Result<Option<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::find(c, database, id).await)
    }

    /// Exemplars by id; an empty filter means all.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::list(c, database, filter, after, limit).await)
    }

    /// Deletes one exemplar; false when there was none.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn delete_exemplar(
        &self,
        database: &str,
        id: Uuid,
        actor: &Actor,
    ) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = exemplars::delete(c, database, id).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("exemplar.delete").in_database(database).about(id)).await?;
            }
            Ok(deleted)
        })
    }

    /// Deletes the exemplars that match, and counts them.
    ///
    /// # Errors
    /// `EmptyFilter`; `Unavailable`, `Corrupt`.
    pub async fn delete_exemplars(
        &self,
        database: &str,
        filter: &ExemplarFilter,
        actor: &Actor,
    ) -> Result<u64, CatalogueError> {
        transaction!(self, c => {
            databases::lock(c, database).await?;
            let deleted = exemplars::delete_matching(c, database, filter).await?;
            if deleted > 0 {
                audit::append(c, actor, NewEntry::new("exemplar.delete").in_database(database).with(filter.audit_detail(deleted))).await?;
            }
            Ok(deleted)
        })
    }

    /// Every exemplar of a database as of one moment, by label, then id.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn training_set(&self, database: &str) -> Result<Vec<ExemplarRow>, CatalogueError> {
        statement!(self, c => exemplars::training_set(c, database).await)
    }

    /// Versions by number.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn versions(
        &self,
        database: &str,
        after: Option<i64>,
        limit: u32,
    ) -> Result<Vec<VersionRow>, CatalogueError> {
        statement!(self, c => versions::list(c, database, after, limit).await)
    }

    /// The version of that number.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn version(&self, database: &str, version: i64) -> Result<Option<VersionRow>, CatalogueError> {
        statement!(self, c => versions::find(c, database, version).await)
    }

    /// Those of these databases' versions that are there, with their digests.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn digests(
        &self,
        versions: &[(String, i64)],
    ) -> Result<Vec<(String, i64, String)>, CatalogueError> {
        statement!(self, c => versions::digests(c, versions).await)
    }

    /// The version made from these inputs.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn version_by_digest(
        &self,
        database: &str,
        digest: &str,
    ) -> Result<Option<VersionRow>, CatalogueError> {
        statement!(self, c => versions::find_by_digest(c, database, digest).await)
    }

    /// Adds a version under the next number, or gives the existing one of that digest unchanged, with `false`.
    ///
    /// Its blob must be stored before.
    ///
    /// # Errors
    /// `NotFound` for the database; `Unavailable`, `Corrupt`.
    pub async fn insert_version(
        &self,
        new: &NewVersion,
        actor: &Actor,
    ) -> Result<(VersionRow, bool), CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, &new.database).await? {
                return Err(CatalogueError::no_database(&new.database));
            }
            let inserted = versions::insert(c, new).await?;
            if inserted.1 {
                let entry = NewEntry::new("version.import").in_database(new.database.as_str()).about(inserted.0.version);
                audit::append(c, actor, entry.with(json!({"digest": new.digest}))).await?;
            }
            Ok(inserted)
        })
    }

    /// Deletes a version; false when there was none.
    ///
    /// # Errors
    /// `Conflict` while an alias points to it; `Unavailable`, `Corrupt`.
    pub async fn delete_version(
        &self,
        database: &str,
        version: i64,
        actor: &Actor,
    ) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted =
                databases::lock(c, database).await? && versions::delete(c, database, version).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("version.delete").in_database(database).about(version)).await?;
            }
            Ok(deleted)
        })
    }

    /// The aliases of a database, by name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn aliases(&self, database: &str) -> Result<Vec<AliasRow>, CatalogueError> {
        statement!(self, c => aliases::list(c, database).await)
    }

    /// The aliases of every database, by database and name, with what they point to.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn all_aliases(&self) -> Result<Vec<AliasTarget>, CatalogueError> {
        statement!(self, c => aliases::list_all(c).await)
    }

    /// Points an alias to a version; `true` when it is new.
    ///
    /// # Errors
    /// `NotFound` for the version, `PreconditionFailed` when the alias isn't as `expected`; `Unavailable`, `Corrupt`.
    pub async fn set_alias(
        &self,
        database: &str,
        alias: &str,
        version: i64,
        expected: AliasExpectation,
        actor: &Actor,
    ) -> Result<(AliasRow, bool), CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, database).await? {
                return Err(CatalogueError::no_version(database, version));
            }
            set_alias(c, database, alias, version, expected, actor).await
        })
    }

    /// Deletes an alias; false when there was none and `expected` allows it.
    ///
    /// # Errors
    /// `PreconditionFailed` when the alias isn't as `expected`; `Unavailable`, `Corrupt`.
    pub async fn delete_alias(
        &self,
        database: &str,
        alias: &str,
        expected: AliasExpectation,
        actor: &Actor,
    ) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            if !databases::lock(c, database).await? {
                return expected.check(None).map(|()| false);
            }
            let deleted = aliases::delete(c, database, alias, expected).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("alias.delete").in_database(database).about(alias)).await?;
            }
            c.notifies = true;
            Ok(deleted)
        })
    }
}

/// Points an alias to a version, with the entry in the audit record and a notification.
pub(super) async fn set_alias(
    connection: &mut Connection<'_>,
    database: &str,
    alias: &str,
    version: i64,
    expected: AliasExpectation,
    actor: &Actor,
) -> Result<(AliasRow, bool), CatalogueError> {
    let set = aliases::set(connection, database, alias, version, expected).await?;
    let entry = NewEntry::new("alias.set").in_database(database).about(alias);
    audit::append(connection, actor, entry.with(json!({"version": version}))).await?;
    connection.notifies = true;
    Ok(set)
}
