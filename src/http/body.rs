//! Request bodies under their limits of size and time.

use axum::body::Body;
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use http_body_util::{BodyExt, LengthLimitError, Limited};

use super::problem::{Code, Problem};
use crate::config::Limits;

/// The body, whole, if it is at most `max_bytes` long and comes within the body time-out.
///
/// # Errors
/// 413, 408, or 400 for a body that breaks off.
pub async fn read_whole(
    headers: &HeaderMap,
    body: Body,
    max_bytes: u64,
    limits: &Limits,
) -> Result<Bytes, Problem> {
    refuse_declared(headers, max_bytes)?;
    let whole = Limited::new(body, max_bytes as usize).collect();
    match tokio::time::timeout(limits.body_timeout, whole).await {
        Ok(Ok(whole)) => Ok(whole.to_bytes()),
        Ok(Err(error)) if error.is::<LengthLimitError>() => Err(too_large(max_bytes)),
        Ok(Err(error)) => Err(Problem::new(Code::MalformedRequest, format!("the body broke off: {error}"))),
        Err(_) => Err(too_slow(limits)),
    }
}

/// The body as a stream of at most `max_bytes`.
///
/// # Errors
/// 413 when the declared length is more.
pub fn limited(headers: &HeaderMap, body: Body, max_bytes: u64) -> Result<Body, Problem> {
    refuse_declared(headers, max_bytes)?;
    Ok(Body::new(Limited::new(body, max_bytes as usize)))
}

fn refuse_declared(headers: &HeaderMap, max_bytes: u64) -> Result<(), Problem> {
    let declared = headers.get(header::CONTENT_LENGTH).and_then(|v| v.to_str().ok()?.parse::<u64>().ok());
    if declared.is_some_and(|declared| declared > max_bytes) {
        return Err(too_large(max_bytes));
    }
    Ok(())
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

/// The problem of a body that doesn't come.
pub fn too_slow(limits: &Limits) -> Problem {
    Problem::new(
        Code::BodyTimeout,
        format!("the body did not come within {} s: send it again", limits.body_timeout.as_secs()),
    )
}
