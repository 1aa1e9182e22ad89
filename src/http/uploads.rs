//! Pictures sent by clients: the raw body, or a multipart part named `image`. The bytes decide the format, and the
//! size is read from the picture's header before anything is queued. Nothing is decoded here.

use axum::body::Body;
use axum::extract::multipart::{Field, Multipart, MultipartError};
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use bytes::{Bytes, BytesMut};
use serde::Serialize;
use utoipa::ToSchema;

use super::extract::essence;
use super::problem::{Code, Problem};
use super::{Service, body};
use crate::config::Limits;
use crate::database::FrameHeader;
use crate::imaging::{self, DecodeLimits, Format};

/// A picture as sent, with what its header says.
#[derive(Debug, Clone)]
pub struct Picture {
    pub bytes: Bytes,
    pub format: Format,
    pub width_px: u32,
    pub height_px: u32,
    /// Memory that the picture takes while it is worked on.
    pub working_bytes: u64,
}

impl Picture {
    /// The picture in these bytes, judged by their header.
    ///
    /// # Errors
    /// No picture, a format we don't read, or too many pixels.
    pub fn of(bytes: Bytes, limits: &DecodeLimits) -> Result<Self, Problem> {
        let header = imaging::read_header(&bytes, limits)?;
        Ok(Self {
            bytes,
            format: header.format,
            width_px: header.width_px,
            height_px: header.height_px,
            working_bytes: header.frame_bytes(),
        })
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
            let mut parts = Form::of(request, service, limits.max_body_bytes).await?;
            while let Some((name, field)) = parts.next().await? {
                if name == "image" {
                    let bytes = service.read_part(field, limits.max_body_bytes).await??;
                    return Ok(Self(Picture::of(bytes, &service.decode)?));
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
        let bytes = body::read_whole(&parts.headers, body, limits.max_body_bytes, limits).await?;
        Ok(Self(Picture::of(bytes, &service.decode)?))
    }
}

/// A multipart body read part by part, under the limits of number, size and time.
pub struct Form {
    multipart: Multipart,
    limits: Limits,
    max_bytes: u64,
    parts: usize,
}

impl Form {
    /// The form in a request's body, of at most `max_bytes` in all.
    ///
    /// # Errors
    /// A body that is no form, or one that declares more than it may hold.
    pub async fn of(request: Request, service: &Service, max_bytes: u64) -> Result<Self, Problem> {
        let (parts, body) = request.into_parts();
        let body: Body = body::limited(&parts.headers, body, max_bytes)?;
        let request = Request::from_parts(parts, body);
        let multipart = Multipart::from_request(request, service).await.map_err(|rejection| {
            Problem::new(Code::MalformedRequest, format!("the form can't be read: {}", rejection.body_text()))
        })?;
        Ok(Self { multipart, limits: service.limits.clone(), max_bytes, parts: 0 })
    }

    /// The next part with its name (empty when it has none).
    pub async fn next(&mut self) -> Result<Option<(String, Field<'_>)>, Problem> {
        self.parts += 1;
        if self.parts > self.limits.max_batch_parts + 1 {
            return Err(Problem::new(
                Code::BodyTooLarge,
                format!("a batch has at most {} parts: send several", self.limits.max_batch_parts),
            ));
        }
        let max_bytes = self.max_bytes;
        let next = tokio::time::timeout(self.limits.body_timeout, self.multipart.next_field()).await;
        let field = next
            .map_err(|_| body::too_slow(&self.limits))?
            .map_err(|error| broken_form(&error, max_bytes))?;
        Ok(field.map(|field| (field.name().unwrap_or_default().to_owned(), field)))
    }
}

impl Service {
    /// The bytes of one part of a form.
    ///
    /// # Errors
    /// A part larger than `max_bytes` (the rest of it is skipped), or one that doesn't come.
    pub async fn read_part(
        &self,
        mut field: Field<'_>,
        max_bytes: u64,
    ) -> Result<Result<Bytes, Problem>, Problem> {
        let all = async {
            let (mut bytes, mut fits) = (BytesMut::new(), true);
            while let Some(chunk) =
                field.chunk().await.map_err(|error| broken_form(&error, self.limits.max_batch_bytes))?
            {
                fits &= (bytes.len() + chunk.len()) as u64 <= max_bytes;
                if fits {
                    bytes.extend_from_slice(&chunk);
                }
            }
            Ok(if fits { Ok(bytes.freeze()) } else { Err(body::too_large(max_bytes)) })
        };
        let read = tokio::time::timeout(self.limits.body_timeout, all).await;
        read.map_err(|_| body::too_slow(&self.limits))?
    }
}

fn broken_form(error: &MultipartError, max_bytes: u64) -> Problem {
    if error.status() == StatusCode::PAYLOAD_TOO_LARGE {
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
