//! The keys in force, held in memory: looked up for every call, and read anew when the catalogue hints at a change.

use std::collections::HashMap;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use arc_swap::ArcSwap;
use governor::clock::{Clock, DefaultClock};
use governor::{DefaultDirectRateLimiter, Quota, RateLimiter};
use jiff::Timestamp;
use tokio::sync::watch;

use super::key::{Key, KeyHash, hash_of_hex, hex};
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
    pub scope: Scope,
    /// Names of databases, with `*` and `?`; none: every database.
    pub databases: Option<Vec<String>>,
    /// None: as often as there is time for.
    pub requests_per_s: Option<u32>,
}

/// A new key: the one time that it is shown.
#[derive(Debug, Clone)]
pub struct KeyGrant {
    pub key: Key,
    pub row: KeyRow,
}

/// Why keys can't be managed.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// The field of the grant, and what is wrong with it.
    #[error("{field} {fault}")]
    Grant { field: &'static str, fault: String },
    #[error("there is no key {id}")]
    UnknownKey { id: String },
    #[error("the operating system gives no random numbers")]
    NoRandomNumbers {
        #[source]
        source: getrandom::Error,
    },
    #[error(transparent)]
    Catalogue(#[from] CatalogueError),
}

/// Why a call isn't let in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Denied {
    /// It came without a key.
    Missing,
    /// Its key isn't in force: never made, misspelt, or revoked.
    Unknown,
    /// Its key was used too often; it may be used again after that time.
    TooOften(Duration),
}

/// Who calls, and what they may do.
#[derive(Debug, Clone)]
pub struct Caller {
    key: Option<Arc<HeldKey>>,
}

impl Caller {
    /// Whether the scope of its key includes this one.
    pub fn may(&self, scope: Scope) -> bool {
        self.key.as_ref().is_none_or(|key| key.scope >= scope)
    }

    /// Whether its key reaches that database.
    pub fn reaches(&self, database: &str) -> bool {
        let confined = self.key.as_ref().and_then(|key| key.databases.as_ref());
        confined.is_none_or(|patterns| patterns.iter().any(|pattern| pattern.matches(database)))
    }

    /// Whether its key reaches some databases only.
    pub fn is_confined(&self) -> bool {
        self.key.as_ref().is_some_and(|key| key.databases.is_some())
    }

    /// Id of its key.
    pub fn key_id(&self) -> Option<&str> {
        self.key.as_ref().map(|key| key.id.as_str())
    }

    /// Its key as a number: callers are told apart by it.
    pub fn key_number(&self) -> Option<u64> {
        self.key.as_ref().map(|key| key.number)
    }

    /// The caller as the record names it.
    pub fn actor(&self, request_id: Option<String>) -> Actor {
        match &self.key {
            Some(key) => Actor { key: Some(key.id.clone()), name: key.name.clone(), request_id },
            None => Actor { request_id, ..Actor::named("anyone") },
        }
    }
}

#[derive(Debug)]
struct HeldKey {
    id: String,
    /// The same, read.
    number: u64,
    name: String,
    hash: KeyHash,
    scope: Scope,
    databases: Option<Vec<glob::Pattern>>,
    limiter: Option<DefaultDirectRateLimiter>,
    last_used_us: AtomicI64,
    noted_us: AtomicI64,
}

impl HeldKey {
    /// The key of a row. One that can't be read, of a newer release perhaps, opens nothing.
    fn of(row: &KeyRow) -> Option<Self> {
        let databases = match &row.databases {
            None => None,
            Some(kept) => {
                let names: Vec<String> = serde_json::from_str(kept).ok()?;
                Some(names.iter().map(|name| glob::Pattern::new(name)).collect::<Result<_, _>>().ok()?)
            }
        };
        let limiter = match row.requests_per_s {
            None => None,
            Some(rate) => {
                let rate = NonZeroU32::new(u32::try_from(rate).ok()?)?;
                Some(RateLimiter::direct(Quota::per_second(rate)))
            }
        };
        let used = row.last_used_at.map_or(0, Timestamp::as_microsecond);
        Some(Self {
            number: u64::from_str_radix(&row.id, 16).ok()?,
            id: row.id.clone(),
            name: row.name.clone(),
            hash: hash_of_hex(&row.hash)?,
            scope: row.scope.parse().ok()?,
            databases,
            limiter,
            last_used_us: AtomicI64::new(used),
            noted_us: AtomicI64::new(used),
        })
    }
}

#[derive(Default)]
struct Held {
    /// Those in force, by id.
    keys: HashMap<String, Arc<HeldKey>>,
    /// Whether there ever was a key.
    ever_had_one: bool,
}

/// The keys of a service; cheap to clone.
#[derive(Clone)]
pub struct Keyring {
    catalogue: Arc<dyn Catalogue>,
    held: Arc<ArcSwap<Held>>,
    /// Whether a service that never had a key lets everybody in.
    open_without_keys: bool,
    /// Grows when the keys were read anew.
    read: watch::Sender<u64>,
    /// One reads at a time, so that what was read first is never stored last.
    reading: Arc<tokio::sync::Mutex<()>>,
}

impl Keyring {
    /// The keys kept in `catalogue`, read once.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn open(
        catalogue: Arc<dyn Catalogue>,
        open_without_keys: bool,
    ) -> Result<Self, CatalogueError> {
        let keyring = Self {
            catalogue,
            held: Arc::default(),
            open_without_keys,
            read: watch::Sender::new(0),
            reading: Arc::default(),
        };
        keyring.refresh().await?;
        Ok(keyring)
    }

    /// Whether some key is in force.
    pub fn has_keys(&self) -> bool {
        !self.held.load().keys.is_empty()
    }

    /// Whether a call must come with a key.
    pub fn asks(&self) -> bool {
        !self.open_without_keys || self.held.load().ever_had_one
    }

    /// Let a call in that came with this key.
    ///
    /// # Errors
    /// Why it isn't let in.
    pub fn admit(&self, text: Option<&str>) -> Result<Caller, Denied> {
        if !self.asks() {
            return Ok(Caller { key: None });
        }
        let key = Key::parse(text.ok_or(Denied::Missing)?).ok_or(Denied::Unknown)?;
        let held = self.held.load().keys.get(key.id()).cloned().ok_or(Denied::Unknown)?;
        if !key.has_hash(&held.hash) {
            return Err(Denied::Unknown);
        }
        held.last_used_us.fetch_max(Timestamp::now().as_microsecond(), Ordering::Relaxed);
        if let Some(Err(until)) = held.limiter.as_ref().map(DefaultDirectRateLimiter::check) {
            return Err(Denied::TooOften(until.wait_time_from(DefaultClock::default().now())));
        }
        Ok(Caller { key: Some(held) })
    }

    /// Resolves when the caller's key isn't in force any more.
    pub async fn revoked(&self, caller: &Caller) {
        let Some(id) = caller.key_id() else { return std::future::pending().await };
        let mut read = self.read.subscribe();
        while self.held.load().keys.contains_key(id) {
            if read.changed().await.is_err() {
                return std::future::pending().await;
            }
        }
    }

    /// Read the keys anew.
    ///
    /// # Errors
    /// The catalogue is away: then the keys held stay in force.
    pub async fn refresh(&self) -> Result<(), CatalogueError> {
        let _one_at_a_time = self.reading.lock().await;
        let rows = self.catalogue.keys().await?;
        let before = self.held.load_full();
        let in_force = rows.iter().filter(|row| row.revoked_at.is_none());
        let keys = in_force.filter_map(|row| {
            // All else of a key stays as it was made; its limiter goes on counting.
            let held = before.keys.get(&row.id).cloned();
            held.or_else(|| HeldKey::of(row).map(Arc::new)).map(|key| (row.id.clone(), key))
        });
        let held = Held { keys: keys.collect(), ever_had_one: !rows.is_empty() };
        self.held.store(Arc::new(held));
        self.read.send_modify(|count| *count += 1);
        Ok(())
    }

    /// Note when keys were last used.
    ///
    /// # Errors
    /// The catalogue is away: then they are noted the next time.
    pub async fn note_uses(&self) -> Result<(), CatalogueError> {
        let held = self.held.load_full();
        let mut due: Vec<_> = held
            .keys
            .values()
            .map(|key| (key, key.last_used_us.load(Ordering::Relaxed)))
            .filter(|(key, used_us)| *used_us > key.noted_us.load(Ordering::Relaxed))
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
        self.catalogue.note_key_uses(&uses).await?;
        due.iter().for_each(|(key, used_us)| key.noted_us.store(*used_us, Ordering::Relaxed));
        Ok(())
    }

    /// Make a key. On return this process takes it.
    ///
    /// # Errors
    /// [`AccessError::Grant`], or the catalogue is away.
    pub async fn create(&self, grant: &Grant, by: &Actor) -> Result<KeyGrant, AccessError> {
        check(grant)?;
        let key = Key::make().map_err(|source| AccessError::NoRandomNumbers { source })?;
        let new = NewKey {
            id: key.id().to_owned(),
            name: grant.name.clone(),
            hash: hex(&key.hash()),
            scope: grant.scope.as_str().to_owned(),
            databases: grant.databases.as_ref().map(|names| serde_json::json!(names).to_string()),
            requests_per_s: grant.requests_per_s.map(i64::from),
        };
        let row = self.catalogue.insert_key(&new, by).await?;
        self.refresh().await?;
        Ok(KeyGrant { key, row })
    }

    /// Every key that ever was, the oldest first, with its last use in this process as of now.
    ///
    /// # Errors
    /// The catalogue is away.
    pub async fn list(&self) -> Result<Vec<KeyRow>, AccessError> {
        let mut rows = self.catalogue.keys().await?;
        let held = self.held.load();
        for row in &mut rows {
            let used = held.keys.get(&row.id).map_or(0, |key| key.last_used_us.load(Ordering::Relaxed));
            let used = Timestamp::from_microsecond(used).ok().filter(|used| *used > Timestamp::UNIX_EPOCH);
            row.last_used_at = row.last_used_at.max(used);
        }
        Ok(rows)
    }

    /// End a key, for good; one that had ended stays as it is. On return this process refuses it.
    ///
    /// # Errors
    /// [`AccessError::UnknownKey`], or the catalogue is away.
    pub async fn revoke(&self, id: &str, by: &Actor) -> Result<(), AccessError> {
        if self.catalogue.revoke_key(id, by).await?.is_none() {
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
