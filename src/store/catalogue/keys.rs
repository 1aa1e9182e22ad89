//! API keys, and the audit record.

use jiff::Timestamp;

use super::Catalogue;
use crate::store::error::CatalogueError;
use crate::store::session::{statement, transaction};
use crate::store::tables::audit::{self, Actor, AuditFilter, AuditRow, NewEntry};
use crate::store::tables::keys::{self, KeyRow, NewKey};

impl Catalogue {
    /// Keeps a new key.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn insert_key(&self, new: &NewKey, actor: &Actor) -> Result<KeyRow, CatalogueError> {
        transaction!(self, c => {
            let row = keys::insert(c, new).await?;
            audit::append(c, actor, NewEntry::new("key.create").about(&new.id).with(new.audit_detail())).await?;
            c.notifies = true;
            Ok(row)
        })
    }

    /// Every key that ever was, revoked ones too, the oldest first.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn keys(&self) -> Result<Vec<KeyRow>, CatalogueError> {
        statement!(self, c => keys::list(c).await)
    }

    /// Ends a key, for good; false when it had ended, none when there is no such key.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn revoke_key(&self, id: &str, actor: &Actor) -> Result<Option<bool>, CatalogueError> {
        transaction!(self, c => {
            if keys::find(c, id).await?.is_none() {
                return Ok(None);
            }
            let revoked = keys::revoke(c, id).await?;
            if revoked {
                audit::append(c, actor, NewEntry::new("key.revoke").about(id)).await?;
                c.notifies = true;
            }
            Ok(Some(revoked))
        })
    }

    /// Records when keys were last used.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn record_key_uses(&self, uses: &[(String, Timestamp)]) -> Result<(), CatalogueError> {
        transaction!(self, c => {
            for (id, at) in uses {
                keys::record_use(c, id, *at).await?;
            }
            Ok(())
        })
    }

    /// Entries of the audit record, the newest first; `before` is the oldest one seen.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<i64>,
        limit: u32,
    ) -> Result<Vec<AuditRow>, CatalogueError> {
        statement!(self, c => audit::list(c, filter, before, limit).await)
    }
}
