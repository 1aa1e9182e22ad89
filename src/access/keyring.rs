//! The keys in force, held in memory: looked up for every call, and loaded again on a change notification.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use arc_swap::ArcSwap;
use jiff::Timestamp;
use tokio::sync::watch;

use super::caller::Caller;
use super::key::{Key, hex};
use super::loaded_key::LoadedKey;
use super::scope::Scope;
use crate::store::{Actor, AuditFilter, AuditRow, Catalogue, CatalogueError, KeyRow, NewKey};

/// Most calls a second that a key may be held to.
const MOST_REQUESTS_PER_S: u32 = 10_000;
/// Longest name of a key, in bytes.
const MAX_NAME_BYTES: usize = 128;
/// Most patterns that confine a key.
const MOST_PATTERNS: usize = 64;

/// What a new key may do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grant {
    /// For people: whose key it is.
    pub name: String,
    /// What the key may do.
    pub scope: Scope,
    /// Names of databases, with `*` and `?`; none: every database.
    pub databases: Option<Vec<String>>,
    /// Most requests in a second; none: no limit.
    pub requests_per_s: Option<u32>,
}

/// A new key with its row; the key can't be had again.
#[derive(Debug, Clone)]
pub struct IssuedKey {
    /// The whole key.
    pub key: Key,
    /// What the catalogue keeps of it.
    pub row: KeyRow,
}

/// Why keys can't be managed.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// A field of the grant is wrong.
    #[error("{field} {fault}")]
    Grant {
        /// The field's name.
        field: &'static str,
        /// What is wrong with it, for people.
        fault: String,
    },
    /// There is no key of that id.
    #[error("there is no key {id}")]
    UnknownKey {
        /// The id that was given.
        id: String,
    },
    /// No key can be made without random numbers.
    #[error("the operating system gives no random numbers")]
    NoRandomNumbers {
        /// The error of the operating system.
        #[source]
        source: getrandom::Error,
    },
    /// The catalogue failed.
    #[error(transparent)]
    Catalogue(#[from] CatalogueError),
}

/// Why a call isn't admitted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Denied {
    /// It came without a key.
    Missing,
    /// Its key isn't in force: never made, misspelt, or revoked.
    Unknown,
    /// Its key was used too often; it may be used again after that time.
    TooOften(Duration),
}

#[derive(Default)]
struct LoadedKeys {
    /// The keys in force, by id.
    in_force: HashMap<String, Arc<LoadedKey>>,
    /// Whether there ever was a key.
    is_in_use: bool,
}

/// The keys of a service; cheap to clone.
#[derive(Clone)]
pub struct Keyring {
    catalogue: Arc<Catalogue>,
    keys: Arc<ArcSwap<LoadedKeys>>,
    /// Whether a service that never had a key lets everybody in.
    open_without_keys: bool,
    /// Counts the refreshes.
    refreshes: watch::Sender<u64>,
    /// Locked during a refresh, so that the rows that were read first are never stored last.
    refreshing: Arc<tokio::sync::Mutex<()>>,
}

impl Keyring {
    /// The keys kept in `catalogue`, read once.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn open(catalogue: Arc<Catalogue>, open_without_keys: bool) -> Result<Self, CatalogueError> {
        let keyring = Self {
            catalogue,
            keys: Arc::default(),
            open_without_keys,
            refreshes: watch::Sender::new(0),
            refreshing: Arc::default(),
        };
        keyring.refresh().await?;
        Ok(keyring)
    }

    /// Whether some key is in force.
    pub fn has_keys(&self) -> bool {
        !self.keys.load().in_force.is_empty()
    }

    /// Whether a call must come with a key.
    pub fn requires_key(&self) -> bool {
        !self.open_without_keys || self.keys.load().is_in_use
    }

    /// Admits a call that came with this key, and counts it.
    ///
    /// # Errors
    /// Why the call isn't admitted.
    pub fn admit(&self, text: Option<&str>) -> Result<Caller, Denied> {
        if !self.requires_key() {
            return Ok(Caller { key: None, request_id: None });
        }
        let key = Key::parse(text.ok_or(Denied::Missing)?).ok_or(Denied::Unknown)?;
        let loaded = self.keys.load().in_force.get(key.id()).cloned().ok_or(Denied::Unknown)?;
        if !key.has_hash(&loaded.hash) {
            return Err(Denied::Unknown);
        }
        loaded.last_used_us.fetch_max(Timestamp::now().as_microsecond(), Ordering::Relaxed);
        loaded.check_rate().map_err(Denied::TooOften)?;
        Ok(Caller { key: Some(loaded), request_id: None })
    }

    /// Resolves when the caller's key isn't in force any more.
    pub async fn revoked(&self, caller: &Caller) {
        let Some(id) = caller.key_id() else { return std::future::pending().await };
        let mut refreshes = self.refreshes.subscribe();
        while self.keys.load().in_force.contains_key(id) {
            if refreshes.changed().await.is_err() {
                return std::future::pending().await;
            }
        }
    }

    /// Loads the keys again.
    ///
    /// # Errors
    /// The catalogue is away: then the keys that are loaded stay in force.
    pub async fn refresh(&self) -> Result<(), CatalogueError> {
        let _one_at_a_time = self.refreshing.lock().await;
        let rows = self.catalogue.keys().await?;
        let before = self.keys.load_full();
        let unrevoked = rows.iter().filter(|row| row.revoked_at.is_none());
        let in_force = unrevoked.filter_map(|row| {
            // A key never changes but for its revocation, and its limiter has to go on counting.
            let loaded = before.in_force.get(&row.id).cloned();
            loaded.or_else(|| LoadedKey::from_row(row).map(Arc::new)).map(|key| (row.id.clone(), key))
        });
        let loaded = LoadedKeys { in_force: in_force.collect(), is_in_use: !rows.is_empty() };
        self.keys.store(Arc::new(loaded));
        self.refreshes.send_modify(|count| *count += 1);
        Ok(())
    }

    /// Records in the catalogue when keys were last used.
    ///
    /// # Errors
    /// The catalogue is away: then the next call records them.
    pub async fn record_uses(&self) -> Result<(), CatalogueError> {
        let keys = self.keys.load_full();
        let mut due: Vec<_> = keys
            .in_force
            .values()
            .map(|key| (key, key.last_used_us.load(Ordering::Relaxed)))
            .filter(|(key, used_us)| *used_us > key.recorded_us.load(Ordering::Relaxed))
            .collect();
        // In one order in every process, so that no two wait for each other's rows.
        due.sort_by(|(a, _), (b, _)| a.id.cmp(&b.id));
        let uses: Vec<_> = due
            .iter()
            .filter_map(|(key, used_us)| Some((key.id.clone(), Timestamp::from_microsecond(*used_us).ok()?)))
            .collect();
        if uses.is_empty() {
            return Ok(());
        }
        self.catalogue.record_key_uses(&uses).await?;
        due.iter().for_each(|(key, used_us)| key.recorded_us.store(*used_us, Ordering::Relaxed));
        Ok(())
    }

    /// Makes a key. On return this process accepts it.
    ///
    /// # Errors
    /// [`AccessError::Grant`], or the catalogue is away.
    pub async fn create(&self, grant: &Grant, actor: &Actor) -> Result<IssuedKey, AccessError> {
        check(grant)?;
        let key = Key::generate().map_err(|source| AccessError::NoRandomNumbers { source })?;
        let new = NewKey {
            id: key.id().to_owned(),
            name: grant.name.clone(),
            hash: hex(&key.hash()),
            scope: grant.scope.as_str().to_owned(),
            databases: grant.databases.as_ref().map(|names| serde_json::json!(names).to_string()),
            requests_per_s: grant.requests_per_s.map(i64::from),
        };
        let row = self.catalogue.insert_key(&new, actor).await?;
        self.refresh().await?;
        Ok(IssuedKey { key, row })
    }

    /// Every key that ever was, the oldest first, with its last use in this process as of now.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn list(&self) -> Result<Vec<KeyRow>, AccessError> {
        let mut rows = self.catalogue.keys().await?;
        let keys = self.keys.load();
        for row in &mut rows {
            let used = keys.in_force.get(&row.id).map_or(0, |key| key.last_used_us.load(Ordering::Relaxed));
            let used = Timestamp::from_microsecond(used).ok().filter(|used| *used > Timestamp::UNIX_EPOCH);
            row.last_used_at = row.last_used_at.max(used);
        }
        Ok(rows)
    }

    /// Revokes a key, for good; a revoked one stays as it is. On return this process refuses it.
    ///
    /// # Errors
    /// [`AccessError::UnknownKey`], or the catalogue is away.
    pub async fn revoke(&self, id: &str, actor: &Actor) -> Result<(), AccessError> {
        if self.catalogue.revoke_key(id, actor).await?.is_none() {
            return Err(AccessError::UnknownKey { id: id.to_owned() });
        }
        Ok(self.refresh().await?)
    }

    /// Entries of the audit record, the newest first, before `before`.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn audit(
        &self,
        filter: &AuditFilter,
        before: Option<i64>,
        limit: u32,
    ) -> Result<Vec<AuditRow>, AccessError> {
        Ok(self.catalogue.audit(filter, before, limit).await?)
    }
}

fn check(grant: &Grant) -> Result<(), AccessError> {
    let wrong = |field, fault: String| Err(AccessError::Grant { field, fault });
    let name = &grant.name;
    if name.trim().is_empty() || name.len() > MAX_NAME_BYTES || name.chars().any(char::is_control) {
        return wrong("name", format!("must be 1 to {MAX_NAME_BYTES} bytes without control characters"));
    }
    for name in grant.databases.iter().flatten() {
        if let Err(error) = glob::Pattern::new(name) {
            return wrong("databases", format!("holds {name:?}, which is no pattern: {error}"));
        }
    }
    if grant.databases.as_ref().is_some_and(|names| names.is_empty() || names.len() > MOST_PATTERNS) {
        return wrong("databases", format!("must name 1 to {MOST_PATTERNS}, or be left out for all"));
    }
    if grant.requests_per_s.is_some_and(|rate| !(1..=MOST_REQUESTS_PER_S).contains(&rate)) {
        return wrong("requests_per_s", format!("must be between 1 and {MOST_REQUESTS_PER_S}"));
    }
    Ok(())
}
