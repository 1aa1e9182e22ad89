//! Extractors of path, query and JSON body. They answer with problems instead of the framework's plain texts.

use axum::extract::path::ErrorKind;
use axum::extract::rejection::PathRejection;
use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;

use super::problem::{Code, FieldError, Problem};
use super::{Service, body};

/// Path parameters.
pub struct Path<T>(pub T);

impl<T: DeserializeOwned + Send> FromRequestParts<Service> for Path<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, service: &Service) -> Result<Self, Problem> {
        let taken = axum::extract::Path::<T>::from_request_parts(parts, service).await;
        let axum::extract::Path(value) = taken.map_err(|rejection| match rejection {
            PathRejection::FailedToDeserializePathParams(error) => match error.kind() {
                ErrorKind::DeserializeError { key, message, .. } => {
                    Problem::field(format!("#{key}"), message.clone())
                }
                ErrorKind::ParseErrorAtKey { key, value, expected_type } => {
                    Problem::field(format!("#{key}"), format!("{value:?} can't be read as {expected_type}"))
                }
                _ => Problem::field("#path", error.body_text()),
            },
            rejection => Problem::field("#path", rejection.body_text()),
        })?;
        Ok(Self(value))
    }
}

/// Query parameters; unknown ones are refused by the types (`deny_unknown_fields`).
pub struct Query<T>(pub T);

impl<T: DeserializeOwned + Send> FromRequestParts<Service> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _service: &Service) -> Result<Self, Problem> {
        let query = parts.uri.query().unwrap_or_default();
        // Not every catalogue can keep control characters, and no name has one.
        let mut given = form_urlencoded::parse(query.as_bytes());
        if let Some((name, _)) = given.find(|(_, value)| value.contains(char::is_control)) {
            return Err(Problem::field(format!("#{name}"), "holds a control character"));
        }
        let pairs = form_urlencoded::parse(query.as_bytes());
        serde_path_to_error::deserialize(serde_urlencoded::Deserializer::new(pairs)).map(Self).map_err(
            |error| {
                let name = error.path().to_string();
                let at = if name == "." { "#query".into() } else { format!("#{name}") };
                Problem::field(at, error.inner().to_string())
            },
        )
    }
}

/// A JSON body.
pub struct Json<T>(pub T);

/// Largest JSON body: the longest that any call needs is a few kilobytes.
pub const MAX_JSON_BYTES: u64 = 1 << 20;
/// Deepest nesting of a JSON body.
const MAX_JSON_DEPTH: usize = 32;

impl<T: DeserializeOwned> FromRequest<Service> for Json<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, service: &Service) -> Result<Self, Problem> {
        let (parts, body) = request.into_parts();
        match essence(&parts.headers).as_deref() {
            None | Some("application/json") => {}
            Some(other) => {
                return Err(Problem::new(
                    Code::UnsupportedMediaType,
                    format!("this call takes JSON, not {other}: send -H 'Content-Type: application/json'"),
                ));
            }
        }
        let _share = service.bodies.admit(&parts.headers, MAX_JSON_BYTES)?;
        let bytes = body::read_whole(body, MAX_JSON_BYTES, service.limits.body_timeout).await?;
        let value = parse(if bytes.is_empty() { b"{}" } else { &bytes })?;
        if !value.is_object() {
            return Err(Problem::field("", "the body must be a JSON object"));
        }
        read_value(value).map(Self)
    }
}

/// Reads JSON.
///
/// # Errors
/// 400 for text that doesn't parse, 422 with the field at fault for a value of the wrong shape.
pub fn from_json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    // Parsed as a value first, so that a syntax error behind a wrong field is still a syntax error.
    read_value(parse(bytes)?)
}

fn parse(bytes: &[u8]) -> Result<serde_json::Value, Problem> {
    if nesting(bytes) > MAX_JSON_DEPTH {
        return Err(Problem::new(
            Code::MalformedRequest,
            format!("the JSON is nested deeper than {MAX_JSON_DEPTH}"),
        ));
    }
    serde_json::from_slice(bytes)
        .map_err(|error| Problem::new(Code::MalformedRequest, format!("this is not valid JSON: {error}")))
}

fn read_value<T: DeserializeOwned>(value: serde_json::Value) -> Result<T, Problem> {
    from_value(value).map_err(|fault| Problem::fields(vec![fault]))
}

/// Reads a value.
///
/// # Errors
/// The field at fault, with its JSON pointer.
pub fn from_value<T: DeserializeOwned>(value: serde_json::Value) -> Result<T, FieldError> {
    serde_path_to_error::deserialize(value)
        .map_err(|error| FieldError { pointer: pointer(error.path()), detail: error.inner().to_string() })
}

/// The JSON pointer of a path.
fn pointer(path: &serde_path_to_error::Path) -> String {
    use serde_path_to_error::Segment;
    path.iter().fold(String::new(), |text, segment| match segment {
        Segment::Seq { index } => format!("{text}/{index}"),
        Segment::Map { key } => format!("{text}/{}", key.replace('~', "~0").replace('/', "~1")),
        Segment::Enum { .. } | Segment::Unknown => text,
    })
}

/// The depth of nested brackets outside strings. For text that is no JSON it is some number, and parsing fails later.
fn nesting(bytes: &[u8]) -> usize {
    let (mut depth, mut deepest, mut in_string, mut escaped) = (0_usize, 0, false, false);
    for &byte in bytes {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            b'[' | b'{' if !in_string => {
                depth += 1;
                deepest = deepest.max(depth);
            }
            b']' | b'}' if !in_string => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    deepest
}

/// The media type of a body without its parameters, in lower case; none when it isn't declared.
pub fn essence(headers: &HeaderMap) -> Option<String> {
    let declared = headers.get(header::CONTENT_TYPE)?.to_str().ok()?;
    let essence = declared.split(';').next()?.trim().to_ascii_lowercase();
    (!essence.is_empty()).then_some(essence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Outer {
        #[serde(rename = "inner")]
        _inner: Vec<Inner>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        #[serde(rename = "n")]
        _n: u8,
    }

    #[test]
    fn a_wrong_field_is_pointed_to_and_broken_json_is_malformed() {
        let problem = from_json::<Outer>(br#"{"inner":[{"n":1},{"n":300}]}"#).unwrap_err();
        assert_eq!((problem.code, problem.errors[0].pointer.as_str()), (Code::InvalidField, "/inner/1/n"));
        let problem = from_json::<Outer>(br#"{"inner":[{"n":"#).unwrap_err();
        assert_eq!(problem.code, Code::MalformedRequest);
        let problem = from_json::<Outer>(br#"{"inner":[{"n":300}"#).unwrap_err();
        assert_eq!(problem.code, Code::MalformedRequest);
    }

    #[test]
    fn deep_nesting_is_refused_and_brackets_in_strings_do_not_count() {
        assert_eq!(nesting(br#"{"a":"[[[[\"[[","b":[{}]}"#), 3);
        let deep = "[".repeat(5000);
        assert_eq!(from_json::<serde_json::Value>(deep.as_bytes()).unwrap_err().code, Code::MalformedRequest);
    }
}
