//! Keys as a process holds them in memory.

use std::num::NonZeroU32;
use std::sync::atomic::AtomicI64;
use std::time::Duration;

use governor::clock::{Clock, DefaultClock};
use governor::{DefaultDirectRateLimiter, Quota, RateLimiter};
use jiff::Timestamp;

use super::key::{KeyHash, hash_of_hex};
use super::scope::Scope;
use crate::store::KeyRow;

/// A key in force, with its rate limiter and its last use.
#[derive(Debug)]
pub struct LoadedKey {
    /// The public part of the key.
    pub id: String,
    /// The id as a number.
    pub number: u64,
    /// What people call it.
    pub name: String,
    /// Of the whole key.
    pub hash: KeyHash,
    /// What it may do.
    pub scope: Scope,
    /// Patterns of names; none: every database.
    pub databases: Option<Vec<glob::Pattern>>,
    /// None where the key is not limited. Each process counts for itself.
    limiter: Option<DefaultDirectRateLimiter>,
    /// The last use that this process knows of, in microseconds since 1970-01-01 UTC; 0: none.
    pub last_used_us: AtomicI64,
    /// The last use that the catalogue knows of, likewise.
    pub recorded_us: AtomicI64,
}

impl LoadedKey {
    /// The key of a row; none for a row that can't be read, of a newer release perhaps.
    pub fn from_row(row: &KeyRow) -> Option<Self> {
        let databases = match &row.databases {
            None => None,
            Some(json) => {
                let names: Vec<String> = serde_json::from_str(json).ok()?;
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
            recorded_us: AtomicI64::new(used),
        })
    }

    /// Counts a request. Errors: how long to wait, when there were too many.
    pub fn check_rate(&self) -> Result<(), Duration> {
        let Some(limiter) = &self.limiter else { return Ok(()) };
        limiter.check().map_err(|until| until.wait_time_from(DefaultClock::default().now()))
    }
}
