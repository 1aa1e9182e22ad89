//! Pictures sent by clients: the raw body, or a multipart part named `image`. The bytes decide the format, and the
//! size is read from the picture's header before anything is queued. Nothing is decoded here.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use axum::BoxError;
use axum::body::Body;
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::HeaderMap;
use axum::http::request::Parts;
use bytes::{Bytes, BytesMut};
use futures_util::StreamExt;
use serde::Serialize;
use utoipa::ToSchema;

use super::body::BodyShare;
use super::extract::essence;
use super::problem::{Code, Problem};
use super::{Service, body};
use crate::config::Limits;
use crate::database::FrameHeader;
use crate::imaging::{self, DecodeLimits, Format};

/// A picture as sent, with what its header says.
#[derive(Debug)]
pub struct Picture {
    pub bytes: Bytes,
    pub format: Format,
    /// Memory that the picture takes while it is worked on.
    pub working_bytes: u64,
    /// The body's room, held as long as the picture is.
    _share: Option<BodyShare>,
}

impl Picture {
    /// The picture in these bytes, judged by their header.
    ///
    /// # Errors
    /// No picture, a format we don't read, or too many pixels.
    pub fn of(bytes: Bytes, limits: &DecodeLimits) -> Result<Self, Problem> {
        let header = imaging::read_header(&bytes, limits)?;
        Ok(Self { bytes, format: header.format, working_bytes: header.working_bytes(), _share: None })
    }
}

/// One picture: the raw body, or the part `image` of a multipart body.
pub struct OnePicture(pub Picture);

impl FromRequest<Service> for OnePicture {
    type Rejection = Problem;

    async fn from_request(request: Request, service: &Service) -> Result<Self, Problem> {
        let limits = &service.limits;
        let declared = essence(request.headers());
        if declared.as_deref() == Some("multipart/form-data") {
            let mut form = Form::of(request, service, limits.max_body_bytes).await?;
            while let Some((name, field)) = form.next().await? {
                if name == "image" {
                    let bytes = field.read(limits.max_body_bytes).await??;
                    let picture = Picture::of(bytes, &service.decode)?;
                    return Ok(Self(Picture { _share: Some(form.share), ..picture }));
                }
            }
            return Err(Problem::new(
                Code::EmptyImage,
                "the form has no file part called image: send -F image=@frame.jpg",
            ));
        }
        match declared.as_deref() {
            None | Some("application/octet-stream") => {}
            Some(image) if image.starts_with("image/") => {}
            Some(other) => {
                return Err(Problem::new(
                    Code::UnsupportedMediaType,
                    format!(
                        "this call takes a picture, not {other}: send --data-binary @frame.jpg \
                         -H 'Content-Type: image/jpeg', or a form with -F image=@frame.jpg"
                    ),
                ));
            }
        }
        let (parts, body) = request.into_parts();
        let share = service.bodies.admit(&parts.headers, limits.max_body_bytes)?;
        let bytes = body::read_whole(body, limits.max_body_bytes, limits.body_timeout).await?;
        let picture = Picture::of(bytes, &service.decode)?;
        Ok(Self(Picture { _share: Some(share), ..picture }))
    }
}

/// A multipart body read part by part, under the limits of number, size and time.
pub struct Form {
    multipart: Multipart,
    meter: Meter,
    limits: Limits,
    max_bytes: u64,
    parts: usize,
    /// Room for one part: the rest of the form is not held.
    share: BodyShare,
}

/// One part of a form.
pub struct Part<'a> {
    field: Field<'a>,
    meter: Meter,
    patience: Duration,
    max_form_bytes: u64,
}

/// Bytes that came since anything was made of them. The form's reader holds what it hasn't made anything of, so an
/// endless head of a part would fill the memory.
#[derive(Clone, Default)]
struct Meter(Arc<AtomicU64>);

/// Most bytes without anything made of them: a part's head, and what the connection reads at once.
const MAX_PENDING_BYTES: u64 = 2 << 20;

impl Meter {
    fn reset(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// The same body; it breaks off when too much of it comes to nothing.
    fn watch(&self, body: Body) -> Body {
        let meter = self.clone();
        Body::from_stream(body.into_data_stream().map(move |chunk| {
            // Without its wrapper: the body gets one again, and under a second the limit's own error isn't seen.
            let chunk = chunk.map_err(axum::Error::into_inner)?;
            let pending = meter.0.fetch_add(chunk.len() as u64, Ordering::Relaxed) + chunk.len() as u64;
            if pending > MAX_PENDING_BYTES {
                return Err(std::io::Error::other("a part's head has no end").into());
            }
            Ok::<_, BoxError>(chunk)
        }))
    }
}

impl Form {
    /// The form in a request's body, of at most `max_bytes` in all.
    ///
    /// # Errors
    /// A body that is no form, one that declares more than it may hold, or no room for it now.
    pub async fn of(request: Request, service: &Service, max_bytes: u64) -> Result<Self, Problem> {
        let (parts, body) = request.into_parts();
        let body = body::limited(&parts.headers, body, max_bytes)?;
        let share = service.bodies.admit(&HeaderMap::new(), service.limits.max_body_bytes)?;
        let meter = Meter::default();
        let request = Request::from_parts(parts, meter.watch(body));
        let multipart = Multipart::from_request(request, service).await.map_err(|rejection| {
            Problem::new(Code::MalformedRequest, format!("the form can't be read: {}", rejection.body_text()))
        })?;
        Ok(Self { multipart, meter, limits: service.limits.clone(), max_bytes, parts: 0, share })
    }

    /// The next part with its name (empty when it has none). One part more than a batch has pictures is allowed: the
    /// manifest.
    pub async fn next(&mut self) -> Result<Option<(String, Part<'_>)>, Problem> {
        let (patience, max_form_bytes) = (self.limits.body_timeout, self.max_bytes);
        self.meter.reset();
        let next = tokio::time::timeout(patience, self.multipart.next_field()).await;
        let field = next
            .map_err(|_| body::too_slow(patience))?
            .map_err(|error| broken_form(&error, max_form_bytes))?;
        let Some(field) = field else { return Ok(None) };
        self.parts += 1;
        if self.parts > self.limits.max_batch_parts + 1 {
            return Err(too_many_parts(self.limits.max_batch_parts));
        }
        let name = field.name().unwrap_or_default().to_owned();
        Ok(Some((name, Part { field, meter: self.meter.clone(), patience, max_form_bytes })))
    }
}

/// The problem of a batch with too many pictures.
pub fn too_many_parts(most: usize) -> Problem {
    Problem::new(
        Code::BodyTooLarge,
        format!("a batch has at most {most} pictures: send several; those that were kept stay kept"),
    )
}

impl Part<'_> {
    /// The bytes of the part. The inner error is the part's alone: it is larger than `max_bytes`, and the rest of it
    /// was skipped.
    ///
    /// # Errors
    /// A form that breaks off, or doesn't come.
    pub async fn read(mut self, max_bytes: u64) -> Result<Result<Bytes, Problem>, Problem> {
        let all = async {
            let (mut bytes, mut fits) = (BytesMut::new(), true);
            self.meter.reset();
            while let Some(chunk) =
                self.field.chunk().await.map_err(|error| broken_form(&error, self.max_form_bytes))?
            {
                self.meter.reset();
                fits &= (bytes.len() + chunk.len()) as u64 <= max_bytes;
                if fits {
                    bytes.extend_from_slice(&chunk);
                }
            }
            Ok(if fits { Ok(bytes.freeze()) } else { Err(body::too_large(max_bytes)) })
        };
        let read = tokio::time::timeout(self.patience, all).await;
        read.map_err(|_| body::too_slow(self.patience))?
    }
}

fn broken_form(error: &MultipartError, max_bytes: u64) -> Problem {
    if body::ran_over(error) {
        return body::too_large(max_bytes);
    }
    Problem::new(Code::MalformedRequest, format!("the form can't be read: {}", error.body_text()))
}

/// Longest value of a robot's header field.
const MAX_HEADER_VALUE_BYTES: usize = 128;

/// What the robot says about its frame, as an answer echoes it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, ToSchema)]
pub struct HeaderEcho {
    /// `X-Robot-Id` as sent.
    pub robot_id: Option<String>,
    /// `X-Frame-Id` as sent.
    pub frame_id: Option<String>,
    /// `X-Stamp` as sent: RFC 3339 or `sec.nanosec`.
    pub stamp: Option<String>,
}

impl From<FrameHeader> for HeaderEcho {
    fn from(header: FrameHeader) -> Self {
        Self { robot_id: header.robot_id, frame_id: header.frame_id, stamp: header.stamp }
    }
}

/// The robot's header fields of a request.
pub struct RobotHeader(pub FrameHeader);

impl FromRequestParts<Service> for RobotHeader {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _service: &Service) -> Result<Self, Problem> {
        let robot_id = field(&parts.headers, "x-robot-id")?;
        let frame_id = field(&parts.headers, "x-frame-id")?;
        let stamp = field(&parts.headers, "x-stamp")?;
        if let Some(stamp) = &stamp
            && !is_stamp(stamp)
        {
            return Err(Problem::field(
                "#X-Stamp",
                format!("{stamp:?} is no time: send RFC 3339 (2026-01-31T12:00:00.5Z) or sec.nanosec"),
            ));
        }
        Ok(Self(FrameHeader { robot_id, frame_id, stamp }))
    }
}

fn field(headers: &HeaderMap, name: &str) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get(name) else { return Ok(None) };
    let text = std::str::from_utf8(value.as_bytes()).ok().filter(|text| text.len() <= MAX_HEADER_VALUE_BYTES);
    match text {
        Some(text) => Ok(Some(text.to_owned())),
        None => Err(Problem::field(
            format!("#{name}"),
            format!("must be UTF-8 of at most {MAX_HEADER_VALUE_BYTES} bytes"),
        )),
    }
}

/// RFC 3339, or whole seconds with an optional fraction.
fn is_stamp(text: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|c| c.is_ascii_digit());
    let seconds = match text.split_once('.') {
        Some((whole, fraction)) => digits(whole) && digits(fraction) && fraction.len() <= 9,
        None => digits(text),
    };
    seconds || text.parse::<jiff::Timestamp>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_rfc_3339_or_seconds() {
        for good in
            ["1700000000", "1700000000.123456789", "2026-01-31T12:00:00Z", "2026-01-31T12:00:00.25+01:00"]
        {
            assert!(is_stamp(good), "{good}");
        }
        for bad in ["", "yesterday", "1700000000.", ".5", "-3", "1.1234567890", "2026-13-01T00:00:00Z"] {
            assert!(!is_stamp(bad), "{bad}");
        }
    }
}
