//! Pictures sent by clients: the raw body, a multipart part named `image`, or several parts with names of their own. The
//! bytes decide the format, and the size is read from the picture's header before anything is queued. Nothing is decoded
//! here.

use std::collections::BTreeMap;
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
use serde_json::{Map, Value};

use super::body::BodyShare;
use super::extract::{MAX_JSON_BYTES, essence, from_json};
use super::problem::{Code, FieldError, Problem};
use super::{Service, body};
use crate::compute::Lane;
use crate::config::Limits;
use crate::database::FrameHeader;
use landmarkd_core::imaging::{self, DecodeLimits, Format, Header};

/// A picture as sent, with the format and the sizes in its header.
#[derive(Debug)]
pub struct Picture {
    pub bytes: Bytes,
    pub format: Format,
    /// Bits a sample.
    pub bits: u8,
    pub header: Header,
    /// Memory that the picture takes while it is worked on.
    pub working_bytes: u64,
    /// Memory that it takes as one of the two that a depth map is made of.
    pub depth_bytes: u64,
    /// The body's room, held as long as the picture is.
    _share: Option<BodyShare>,
}

/// Most memory that one picture of a pair may take in a measurement of depth: 12 megapixels in gray.
pub const MAX_DEPTH_BYTES: u64 = 2 << 30;

impl Picture {
    /// The same, if a depth can be measured in pictures this large.
    ///
    /// # Errors
    /// 422 when it would take too much memory.
    pub fn for_depth(self) -> Result<Self, Problem> {
        if self.depth_bytes <= MAX_DEPTH_BYTES {
            return Ok(self);
        }
        Err(Problem::new(
            Code::ImageTooLarge,
            format!(
                "measuring depth in this picture takes {} MiB, more than the {} that are allowed: send it smaller, some 12 \
                 megapixels in gray are taken",
                self.depth_bytes >> 20,
                MAX_DEPTH_BYTES >> 20
            ),
        ))
    }

    /// The same, holding the body's room for as long as it is held.
    pub fn with_share(self, share: BodyShare) -> Self {
        Self { _share: Some(share), ..self }
    }

    /// The picture in these bytes, judged by their header.
    ///
    /// # Errors
    /// No picture, a format we don't read, or too many pixels.
    pub fn of(bytes: Bytes, limits: &DecodeLimits) -> Result<Self, Problem> {
        let header = imaging::read_header(&bytes, limits)?;
        Ok(Self {
            bytes,
            format: header.format,
            bits: header.bits,
            header,
            working_bytes: header.working_bytes(),
            depth_bytes: header.depth_bytes(),
            _share: None,
        })
    }
}

/// Parts of a form that say something about its picture, by name.
pub type Texts = BTreeMap<&'static str, Bytes>;

/// The names that such parts may have.
const TEXTS: [&str; 4] = ["pose", "camera", "size_mm", "odometry"];

/// One picture whose header isn't read yet: the raw body, or the part `image` of a multipart body.
pub struct OnePicture {
    bytes: Bytes,
    /// What a form says about it.
    pub texts: Texts,
    share: BodyShare,
}

impl OnePicture {
    /// The picture, if its header is within the limits.
    ///
    /// # Errors
    /// As of [`Picture::of`].
    pub fn checked(self, limits: &DecodeLimits) -> Result<Picture, Problem> {
        Ok(Picture::of(self.bytes, limits)?.with_share(self.share))
    }

    /// The same, if recognition has room for it: a picture that must be refused costs as little as can be.
    ///
    /// # Errors
    /// No room, or as of [`Picture::of`].
    pub fn admitted(self, service: &Service) -> Result<Picture, Problem> {
        service.compute.room(Lane::Recognition)?;
        self.checked(&service.decode)
    }
}

impl FromRequest<Service> for OnePicture {
    type Rejection = Problem;

    async fn from_request(request: Request, service: &Service) -> Result<Self, Problem> {
        let limits = &service.limits;
        let declared = essence(request.headers());
        if declared.as_deref() == Some("multipart/form-data") {
            let mut form = Form::of(request, service, limits.max_body_bytes, limits.max_body_bytes).await?;
            let (mut image, mut texts) = (None, Texts::new());
            while let Some((name, field)) = form.next().await? {
                if name == "image" && image.is_none() {
                    image = Some(field.read(limits.max_body_bytes).await??);
                } else if let Some(name) = TEXTS.into_iter().find(|text| *text == name) {
                    let text = field.read(MAX_JSON_BYTES).await?.map_err(|problem| problem.in_part(name))?;
                    texts.insert(name, text);
                }
            }
            let missing = || {
                Problem::new(
                    Code::EmptyImage,
                    "the form has no file part called image: send -F image=@frame.jpg",
                )
            };
            return Ok(Self { bytes: image.ok_or_else(missing)?, texts, share: form.share });
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
        Ok(Self { bytes, texts: Texts::new(), share })
    }
}

/// A multipart body read part by part, under the limits of number, size and time.
pub struct Form {
    multipart: Multipart,
    pending_bytes: PendingBytes,
    limits: Limits,
    max_bytes: u64,
    parts: usize,
    /// Room for the parts that are held at once.
    share: BodyShare,
}

/// One part of a form.
pub struct Part<'a> {
    field: Field<'a>,
    pending_bytes: PendingBytes,
    timeout: Duration,
    max_form_bytes: u64,
}

/// Counts the bytes that arrived since the form's reader last gave a chunk. The reader holds those, so the endless head of a
/// part would fill the memory.
#[derive(Clone, Default)]
struct PendingBytes(Arc<AtomicU64>);

/// Most pending bytes: a part's head, and what the connection reads at once.
const MAX_PENDING_BYTES: u64 = 2 << 20;

impl PendingBytes {
    fn reset(&self) {
        self.0.store(0, Ordering::Relaxed);
    }

    /// The same body; it ends with an error when too many bytes arrive without a part being read.
    fn watch(&self, body: Body) -> Body {
        let pending_bytes = self.clone();
        Body::from_stream(body.into_data_stream().map(move |chunk| {
            // Without its wrapper: the body adds one again, and under two the limit's own error isn't found.
            let chunk = chunk.map_err(axum::Error::into_inner)?;
            let pending =
                pending_bytes.0.fetch_add(chunk.len() as u64, Ordering::Relaxed) + chunk.len() as u64;
            if pending > MAX_PENDING_BYTES {
                return Err(std::io::Error::other("a part's head has no end").into());
            }
            Ok::<_, BoxError>(chunk)
        }))
    }
}

impl Form {
    /// The form in a request's body, of at most `max_bytes` in all, of which at most `held_bytes` are held at once. One that
    /// is held whole takes room for the length it declares.
    ///
    /// # Errors
    /// A body that is no form, one that declares more than it may hold, or no room for it now.
    pub async fn of(
        request: Request,
        service: &Service,
        max_bytes: u64,
        held_bytes: u64,
    ) -> Result<Self, Problem> {
        let (parts, body) = request.into_parts();
        let body = body::limited(&parts.headers, body, max_bytes)?;
        let undeclared = HeaderMap::new();
        let headers = if held_bytes >= max_bytes { &parts.headers } else { &undeclared };
        let share = service.bodies.admit(headers, held_bytes)?;
        let pending_bytes = PendingBytes::default();
        let request = Request::from_parts(parts, pending_bytes.watch(body));
        let multipart = Multipart::from_request(request, service).await.map_err(|rejection| {
            Problem::new(Code::MalformedRequest, format!("the form can't be read: {}", rejection.body_text()))
        })?;
        Ok(Self { multipart, pending_bytes, limits: service.limits.clone(), max_bytes, parts: 0, share })
    }

    /// The next part with its name (empty when it has none). One part more than a batch has pictures is allowed: the
    /// manifest.
    pub async fn next(&mut self) -> Result<Option<(String, Part<'_>)>, Problem> {
        let (timeout, max_form_bytes) = (self.limits.body_timeout, self.max_bytes);
        self.pending_bytes.reset();
        let next = body::in_time(timeout, self.multipart.next_field()).await?;
        let field = next.map_err(|error| broken_form(&error, max_form_bytes))?;
        let Some(field) = field else { return Ok(None) };
        self.parts += 1;
        if self.parts > self.limits.max_batch_parts + 1 {
            return Err(too_many_parts(self.limits.max_batch_parts));
        }
        let name = field.name().unwrap_or_default().to_owned();
        Ok(Some((name, Part { field, pending_bytes: self.pending_bytes.clone(), timeout, max_form_bytes })))
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
            self.pending_bytes.reset();
            while let Some(chunk) =
                self.field.chunk().await.map_err(|error| broken_form(&error, self.max_form_bytes))?
            {
                self.pending_bytes.reset();
                fits &= (bytes.len() + chunk.len()) as u64 <= max_bytes;
                if fits {
                    bytes.extend_from_slice(&chunk);
                }
            }
            Ok(if fits { Ok(bytes.freeze()) } else { Err(body::too_large(max_bytes)) })
        };
        body::in_time(self.timeout, all).await?
    }
}

/// A form of a few parts with known names that are held together, in whatever order they come.
pub struct KnownParts {
    bytes: BTreeMap<&'static str, Bytes>,
    /// The pictures of the part that may come several times, in their order.
    pub list: Vec<Bytes>,
    /// Parts that are unknown or come twice.
    pub faults: Vec<FieldError>,
    /// The form's room, to be held as long as its parts are.
    pub share: BodyShare,
}

/// A part that may come several times, its name also with `[]` after it.
#[derive(Clone, Copy)]
pub struct PartList {
    pub name: &'static str,
    /// How often at most.
    pub most: usize,
}

/// Most wrong parts that are named.
const MAX_PART_FAULTS: usize = 16;

impl KnownParts {
    /// The parts of a form: `pictures` may each be as large as a body, `texts` as a JSON body.
    ///
    /// # Errors
    /// A body that is no form, is too large, breaks off or doesn't come, or no room for it now.
    pub async fn of(
        request: Request,
        service: &Service,
        pictures: &[&'static str],
        texts: &[&'static str],
        list: Option<PartList>,
    ) -> Result<Self, Problem> {
        if essence(request.headers()).as_deref() != Some("multipart/form-data") {
            // Of the two kinds of pair, which exclude each other, one is an example.
            let shown = |name: &&&str| !(pictures.contains(&"near") && ["wide", "narrow"].contains(name));
            let files = pictures.iter().filter(shown).map(|name| format!(" -F {name}=@{name}.png"));
            let files = files.collect::<String>();
            let text = format!("this call takes a form, multipart/form-data: with curl,{files}");
            return Err(Problem::new(Code::UnsupportedMediaType, text));
        }
        let max_picture_bytes = service.limits.max_body_bytes;
        let most_pictures = pictures.len().max(list.map_or(0, |list| list.most)) as u64;
        let most = most_pictures * max_picture_bytes + texts.len() as u64 * MAX_JSON_BYTES;
        let mut form = Form::of(request, service, most, most).await?;
        let (mut bytes, mut faults, mut listed) = (BTreeMap::new(), Vec::new(), Vec::new());
        while let Some((name, part)) = form.next().await? {
            if let Some(list) = list.filter(|list| name.strip_suffix("[]").unwrap_or(&name) == list.name) {
                if listed.len() == list.most {
                    let detail = format!("comes more than {} times", list.most);
                    return Err(Problem::field(format!("/{}", list.name), detail));
                }
                listed
                    .push(part.read(max_picture_bytes).await?.map_err(|problem| problem.in_part(list.name))?);
                continue;
            }
            let find = |names: &[&'static str]| names.iter().copied().find(|known| *known == name);
            let picture = find(pictures).map(|known| (known, max_picture_bytes));
            let Some((known, max_bytes)) = picture.or(find(texts).map(|known| (known, MAX_JSON_BYTES)))
            else {
                // Read past it, keeping nothing.
                let _ = part.read(0).await?;
                let list = list.map(|list| list.name);
                let names = [pictures, list.as_slice(), texts].concat().join(", ");
                let detail = format!("is no part of this form; its parts are {names}");
                faults.push(FieldError { pointer: format!("/{name}"), detail });
                if faults.len() >= MAX_PART_FAULTS {
                    break;
                }
                continue;
            };
            let read = part.read(max_bytes).await?.map_err(|problem| problem.in_part(known))?;
            if bytes.insert(known, read).is_some() {
                return Err(Problem::field(format!("/{known}"), "comes twice: send it once"));
            }
        }
        Ok(Self { bytes, list: listed, faults, share: form.share })
    }

    /// Whether the part of that name was sent and not taken yet.
    pub fn holds(&self, name: &str) -> bool {
        self.bytes.contains_key(name)
    }

    /// The part of that name, if it was sent.
    pub fn take(&mut self, name: &str) -> Option<Bytes> {
        self.bytes.remove(name)
    }

    /// The part of that name; a fault if it wasn't sent.
    pub fn require(&mut self, name: &str) -> Option<Bytes> {
        let taken = self.take(name);
        if taken.is_none() {
            let detail = format!("is missing: send a file part called {name}");
            self.faults.push(FieldError { pointer: format!("/{name}"), detail });
        }
        taken
    }

    /// The members of the JSON object in that part, if it was sent; a fault if it holds something else.
    ///
    /// # Errors
    /// Text that is no JSON.
    pub fn object(&mut self, name: &str) -> Result<Option<Map<String, Value>>, Problem> {
        let Some(bytes) = self.take(name) else { return Ok(None) };
        match from_json(&bytes).map_err(|problem| problem.in_part(name))? {
            Value::Object(members) => Ok(Some(members)),
            _ => {
                let detail = "must be a JSON object".into();
                self.faults.push(FieldError { pointer: format!("/{name}"), detail });
                Ok(None)
            }
        }
    }
}

fn broken_form(error: &MultipartError, max_bytes: u64) -> Problem {
    if body::is_over_limit(error) {
        return body::too_large(max_bytes);
    }
    Problem::new(Code::MalformedRequest, format!("the form can't be read: {}", error.body_text()))
}

/// Longest value of a robot's header field.
const MAX_HEADER_VALUE_BYTES: usize = 128;

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
    // A catalogue may not be able to keep control characters, and nobody can read them in a log.
    let usable = |text: &&str| text.len() <= MAX_HEADER_VALUE_BYTES && !text.contains(char::is_control);
    let text = std::str::from_utf8(value.as_bytes()).ok().filter(usable);
    match text {
        Some(text) => Ok(Some(text.to_owned())),
        None => Err(Problem::field(
            format!("#{name}"),
            format!("must be UTF-8 of at most {MAX_HEADER_VALUE_BYTES} bytes without control characters"),
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
