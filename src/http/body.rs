//! Request bodies under their limits of size, time and memory.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::body::Body;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::{BodyExt, LengthLimitError, Limited};

use super::problem::{Code, Problem};
use crate::compute::Principal;

/// Memory for bodies that are being read or worked on, all requests together. The calls with one key have at most half of
/// it, so that none locks the others out.
#[derive(Clone)]
pub struct BodyBudget {
    held: Arc<Mutex<HashMap<Principal, u64>>>,
    most_bytes: u64,
}

/// A share of the budget, given back when dropped.
#[derive(Debug)]
pub struct BodyShare {
    held: Arc<Mutex<HashMap<Principal, u64>>>,
    principal: Principal,
    bytes: u64,
}

/// What a body takes at least: its buffers, and that there is one.
const LEAST_BYTES: u64 = 64 << 10;

impl BodyBudget {
    /// A budget of `bytes`.
    pub fn new(bytes: u64) -> Self {
        Self { held: Arc::default(), most_bytes: bytes.max(LEAST_BYTES) }
    }

    /// Takes room for a body: for the length it declares, or for the most it may have.
    ///
    /// # Errors
    /// 413 when it declares more than `max_bytes`, 503 when the bodies of others fill the budget, or those of the same
    /// caller its part of it.
    pub fn admit(&self, headers: &HeaderMap, max_bytes: u64) -> Result<BodyShare, Problem> {
        refuse_declared(headers, max_bytes)?;
        let bytes = declared(headers).unwrap_or(max_bytes).clamp(LEAST_BYTES, self.most_bytes);
        let principal = Principal::current();
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        let (all, own) = (held.values().sum::<u64>(), held.get(&principal).copied().unwrap_or(0));
        // A body larger than half goes through alone.
        let is_too_much = principal != Principal::Anyone && own > 0 && own + bytes > self.most_bytes / 2;
        if all + bytes > self.most_bytes || is_too_much {
            return Err(Problem::new(
                Code::Overloaded,
                "the bodies of other requests fill the memory set aside for them: try again a little later",
            ));
        }
        held.insert(principal, own + bytes);
        Ok(BodyShare { held: Arc::clone(&self.held), principal, bytes })
    }
}

impl Drop for BodyShare {
    fn drop(&mut self) {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = held.get_mut(&self.principal) {
            *own -= self.bytes;
            if *own == 0 {
                held.remove(&self.principal);
            }
        }
    }
}

/// The whole body, if it is at most `max_bytes` long and comes within `timeout`.
///
/// # Errors
/// 413, 408, or 400 for a body that breaks off.
pub async fn read_whole(body: Body, max_bytes: u64, timeout: Duration) -> Result<Bytes, Problem> {
    let whole = Limited::new(body, max_bytes as usize).collect();
    match in_time(timeout, whole).await? {
        Ok(whole) => Ok(whole.to_bytes()),
        Err(error) if error.is::<LengthLimitError>() => Err(too_large(max_bytes)),
        Err(error) => Err(Problem::new(Code::MalformedRequest, format!("the body broke off: {error}"))),
    }
}

/// The output of `read`, if it comes within `timeout`.
///
/// # Errors
/// 408 when it doesn't.
pub async fn in_time<T>(timeout: Duration, read: impl Future<Output = T>) -> Result<T, Problem> {
    tokio::time::timeout(timeout, read).await.map_err(|_| {
        let text = format!("the body did not come within {} s: send it again", timeout.as_secs());
        Problem::new(Code::BodyTimeout, text)
    })
}

/// The body as a stream of at most `max_bytes`.
///
/// # Errors
/// 413 when the declared length is more.
pub fn limited(headers: &HeaderMap, body: Body, max_bytes: u64) -> Result<Body, Problem> {
    refuse_declared(headers, max_bytes)?;
    Ok(Body::new(Limited::new(body, max_bytes as usize)))
}

fn declared(headers: &HeaderMap) -> Option<u64> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

fn refuse_declared(headers: &HeaderMap, max_bytes: u64) -> Result<(), Problem> {
    if declared(headers).is_some_and(|declared| declared > max_bytes) {
        return Err(too_large(max_bytes));
    }
    Ok(())
}

/// Whether the cause of an error is a body over its limit.
pub fn is_over_limit(error: &(dyn std::error::Error + 'static)) -> bool {
    std::iter::successors(Some(error), |error| error.source()).any(|error| error.is::<LengthLimitError>())
}

/// The problem of a body over its limit.
pub fn too_large(max_bytes: u64) -> Problem {
    Problem::new(
        Code::BodyTooLarge,
        format!(
            "the body is larger than {} MiB, the limit for this call (see GET /v1/info): send less at once",
            max_bytes >> 20
        ),
    )
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::compute::on_behalf_of;

    #[test]
    fn a_full_budget_refuses_and_gives_back_what_is_dropped() {
        let budget = BodyBudget::new(1 << 20);
        let headers = HeaderMap::from_iter([(header::CONTENT_LENGTH, "600000".parse().unwrap())]);
        let share = budget.admit(&headers, 16 << 20).unwrap();
        assert_eq!(budget.admit(&headers, 16 << 20).unwrap_err().code, Code::Overloaded);
        drop(share);
        assert!(budget.admit(&headers, 16 << 20).is_ok());
        assert_eq!(budget.admit(&headers, 1 << 10).unwrap_err().code, Code::BodyTooLarge);
        // A body of unknown length takes what it might need, at most all there is.
        let all = budget.admit(&HeaderMap::new(), 16 << 20).unwrap();
        assert!(budget.admit(&headers, 16 << 20).is_err());
        drop(all);
    }

    #[tokio::test]
    async fn one_caller_has_half_of_the_budget_and_another_the_rest() {
        let budget = BodyBudget::new(1 << 20);
        let headers = HeaderMap::from_iter([(header::CONTENT_LENGTH, "200000".parse().unwrap())]);
        let admit = |key: u64| {
            let asked = async { budget.admit(&headers, 16 << 20) };
            on_behalf_of(Principal::Key(key), asked)
        };
        let held = [admit(1).await.unwrap(), admit(1).await.unwrap()];
        assert_eq!(admit(1).await.err().unwrap().code, Code::Overloaded);
        let other = [admit(2).await.unwrap(), admit(2).await.unwrap()];
        drop(held);
        assert!(admit(1).await.is_ok());
        drop(other);
        assert!(budget.held.lock().unwrap().is_empty());
    }
}
