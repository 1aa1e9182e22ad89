//! `GET /`: the console, a page for people, and the files it is made of; and a page for each kind of problem, at the
//! address that its `type` names. All of it comes from the binary, needs no key, and asks no other host for anything:
//! what the console shows it fetches with the key that the person gave it.

use askama::Template;
use axum::Router;
use axum::extract::Request;
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG, HeaderName, REFERRER_POLICY,
};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use rust_embed::RustEmbed;

use super::Service;
use super::extract::Path;
use super::middleware::unknown_route;
use super::problem::{Code, Problem};
use super::versions::{IfNoneMatch, if_none_match};

/// The routes of this file. They are not in the OpenAPI document: they are pages, not calls.
pub const PAGES: [&str; 3] = ["/", "/console/{*file}", "/problems/{code}"];

/// Own scripts, styles and pictures, and calls of the service itself: a page can load nothing from another host and send
/// nothing to one. Pictures that were dropped or fetched with the key are `blob:`.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                      media-src blob:; connect-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'";

#[derive(RustEmbed)]
#[folder = "console/"]
struct Files;

/// The routes.
pub fn routes() -> Router<Service> {
    Router::new().route(PAGES[0], get(index)).route(PAGES[1], get(file)).route(PAGES[2], get(problem))
}

async fn index(headers: HeaderMap) -> Result<Response, Problem> {
    serve("index.html", &headers).unwrap_or_else(|| unreachable!("the console has its first page"))
}

async fn file(Path(name): Path<String>, headers: HeaderMap, request: Request) -> Result<Response, Problem> {
    match serve(&name, &headers) {
        Some(response) => response,
        None => Err(unknown_route(request).await),
    }
}

fn serve(name: &str, headers: &HeaderMap) -> Option<Result<Response, Problem>> {
    let file = Files::get(name)?;
    let tag: String = file.metadata.sha256_hash()[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    let etag = match if_none_match(headers, &tag) {
        Ok(IfNoneMatch::Modified(etag)) => etag,
        Ok(IfNoneMatch::NotModified(response)) => return Some(Ok(response)),
        Err(problem) => return Some(Err(problem)),
    };
    let kind = match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    };
    // Revalidated each time, so that nobody works with the pages of the release before.
    let headers = [(ETAG, etag), (CACHE_CONTROL, HeaderValue::from_static("no-cache"))];
    Some(Ok((page(kind), headers, file.data).into_response()))
}

fn page(kind: &'static str) -> [(HeaderName, HeaderValue); 3] {
    [
        (CONTENT_TYPE, HeaderValue::from_static(kind)),
        (CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
        (REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
    ]
}

/// The page of a kind of problem: title and advice.
#[derive(Template)]
#[template(path = "problem.html")]
struct ProblemPage {
    code: Code,
}

async fn problem(Path(word): Path<String>) -> Result<Response, Problem> {
    let code = Code::from_word(&word).ok_or_else(|| {
        let text = format!("no problem is called {word:?}: docs/operating.md lists those that there are");
        Problem::new(Code::UnknownRoute, text)
    })?;
    let text = ProblemPage { code }.render();
    let text =
        text.map_err(|error| Problem::new(Code::Internal, format!("the page can't be written: {error}")))?;
    Ok((page("text/html; charset=utf-8"), text).into_response())
}
