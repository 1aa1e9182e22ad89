//! The middleware that authorises calls, around every route. The scope that a call needs stands with its handler, as
//! `security` in the OpenAPI document, and is read from there. A call that stands nowhere needs scope `admin`.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::Arc;

use axum::RequestPartsExt;
use axum::extract::{FromRequestParts, MatchedPath, RawPathParams, Request, State};
use axum::http::header::{AUTHORIZATION, HOST, ORIGIN, WWW_AUTHENTICATE};
use axum::http::request::Parts;
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use utoipa::openapi::security::{Http, HttpAuthScheme, SecurityScheme};
use utoipa::openapi::{Components, OpenApi, PathItem};

use super::middleware::RequestId;
use super::problem::{Code, Problem};
use super::{Service, console};
use crate::access::{Caller, Denied, Scope};
use crate::compute;

/// Name of the security scheme in the document.
const SCHEME: &str = "key";
/// Routes beside the calls of the document: the document itself, and the pages that show it. They and the console are the
/// same for everybody and hold no data of the service: no key is needed.
const PAGES: [&str; 4] = ["/openapi.json", "/docs", "/docs/", "/docs/{*rest}"];

/// The scope that each call needs, by route and method; none where no key is needed.
pub struct Requirements {
    calls: HashMap<(String, Method), Option<Scope>>,
}

impl Requirements {
    /// Those in the document.
    pub fn of(document: &OpenApi) -> Self {
        let mut calls = HashMap::new();
        for (route, item) in &document.paths.paths {
            for (method, operation) in operations(item) {
                let value = serde_json::to_value(&operation.security).unwrap_or_default();
                let need = match value.pointer("/0") {
                    Some(none) if none.as_object().is_some_and(serde_json::Map::is_empty) => None,
                    one => {
                        let word = one.and_then(|one| one[SCHEME][0].as_str());
                        Some(word.and_then(|word| word.parse().ok()).unwrap_or(Scope::Admin))
                    }
                };
                calls.insert((route.clone(), method), need);
            }
        }
        for page in PAGES.iter().chain(&console::PAGES) {
            calls.insert(((*page).to_owned(), Method::GET), None);
        }
        Self { calls }
    }

    /// The scope that a call needs. `route` is none for an address that no route has: any key may learn that.
    fn scope(&self, route: Option<&str>, method: &Method) -> Option<Scope> {
        let Some(route) = route else { return Some(Scope::Recognise) };
        // HEAD needs what GET needs.
        let method = if *method == Method::HEAD { Method::GET } else { method.clone() };
        self.calls.get(&(route.to_owned(), method)).copied().unwrap_or(Some(Scope::Admin))
    }
}

fn operations(item: &PathItem) -> Vec<(Method, &utoipa::openapi::path::Operation)> {
    let all = [
        (Method::GET, &item.get),
        (Method::PUT, &item.put),
        (Method::POST, &item.post),
        (Method::DELETE, &item.delete),
        (Method::PATCH, &item.patch),
    ];
    all.into_iter().filter_map(|(method, operation)| Some((method, operation.as_ref()?))).collect()
}

/// Describes in the document how a key is sent.
pub fn describe(document: &mut OpenApi) {
    let mut http = Http::new(HttpAuthScheme::Bearer);
    http.description = Some(
        "A key, `Authorization: Bearer lmk_…`, of at least the scope that the call names: `recognise` < `contribute` < \
         `train` < `admin`. A service that never had a key, on a loopback address, asks for none."
            .into(),
    );
    let components = document.components.get_or_insert_with(Components::new);
    components.add_security_scheme(SCHEME, SecurityScheme::Http(http));
}

/// Admits a call, or answers why not. The handlers find the [`Caller`] in the request.
pub async fn authorise(
    State((service, requirements)): State<(Service, Arc<Requirements>)>,
    request: Request,
    next: Next,
) -> Response {
    let (mut parts, body) = request.into_parts();
    match admit(&service, &requirements, &mut parts).await {
        Ok(None) => next.run(Request::from_parts(parts, body)).await,
        Ok(Some(caller)) => {
            let principal = caller.key_number().map_or(compute::Principal::Anyone, compute::Principal::Key);
            parts.extensions.insert(caller.clone());
            let revokes_itself = caller.key_id().is_some_and(|id| {
                parts.method == Method::DELETE && parts.uri.path() == format!("/v1/keys/{id}")
            });
            let responding = compute::on_behalf_of(principal, next.run(Request::from_parts(parts, body)));
            if revokes_itself {
                return responding.await;
            }
            tokio::select! {
                response = responding => response,
                // A key was revoked while its call ran: what a batch added until then stays.
                () = service.keyring.revoked(&caller) => refuse(denied(Denied::Unknown)),
            }
        }
        Err(problem) => refuse(problem),
    }
}

fn refuse(problem: Problem) -> Response {
    let mut response = problem.into_response();
    if response.status() == StatusCode::UNAUTHORIZED {
        let challenge = HeaderValue::from_static("Bearer realm=\"landmarkd\"");
        response.headers_mut().insert(WWW_AUTHENTICATE, challenge);
    }
    response
}

async fn admit(
    service: &Service,
    requirements: &Requirements,
    parts: &mut Parts,
) -> Result<Option<Caller>, Problem> {
    let route = parts.extensions.get::<MatchedPath>().map(|route| route.as_str().to_owned());
    let Some(need) = requirements.scope(route.as_deref(), &parts.method) else { return Ok(None) };
    if !service.keyring.requires_key() {
        refuse_foreign_pages(parts, service.insecure)?;
    }
    let request_id = parts.extensions.get::<RequestId>().map(|id| id.0.clone());
    let caller = service.keyring.admit(bearer(&parts.headers)).map_err(denied)?.with_request_id(request_id);
    if !caller.may(need) {
        return Err(Problem::new(
            Code::NotAllowed,
            format!("this call needs a key of scope {need}: ask whoever made yours for one"),
        ));
    }
    if let Ok(path) = parts.extract::<RawPathParams>().await
        && let Some((_, database)) = path.iter().find(|(name, _)| *name == "database")
    {
        reach(&caller, database)?;
    }
    Ok(Some(caller))
}

/// Refuses pages of other sites. A service that asks for no key is reached by every page that a browser on this machine
/// shows: a page of another origin has it in `Origin`, one that uses DNS rebinding has its own name as the host.
fn refuse_foreign_pages(parts: &Parts, any_host: bool) -> Result<(), Problem> {
    let text = |name| parts.headers.get(name).and_then(|value| value.to_str().ok());
    let authority = parts.uri.authority().map(Authority::as_str).or_else(|| text(HOST));
    let origin = parts.headers.contains_key(ORIGIN).then(|| {
        let origin = text(ORIGIN).and_then(|origin| origin.parse::<Uri>().ok());
        origin.and_then(|origin| origin.into_parts().authority)
    });
    let is_foreign = origin.is_some_and(|origin| origin.as_ref().map(Authority::as_str) != authority);
    let host = authority.and_then(|authority| authority.parse::<Authority>().ok());
    let host = host.as_ref().map(|host| host.host().trim_matches(['[', ']']));
    // A browser always sends a host.
    let is_here = host.is_none_or(|host| host == "localhost" || host.parse::<IpAddr>().is_ok());
    if is_foreign || !(is_here || any_host) {
        return Err(Problem::new(
            Code::NotAllowed,
            "without keys only this machine is let in, by localhost or an address, and no page of another site: make a \
             key with landmarkd keys create",
        ));
    }
    Ok(())
}

/// Whether the caller's key reaches the database.
///
/// # Errors
/// 403 when it doesn't.
pub fn reach(caller: &Caller, database: &str) -> Result<(), Problem> {
    if caller.reaches(database) {
        return Ok(());
    }
    Err(Problem::new(Code::NotAllowed, format!("the key isn't for database {database}")))
}

/// The bearer token of a call, if it has one.
fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, key) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| key.trim())
}

fn denied(denied: Denied) -> Problem {
    match denied {
        Denied::Missing => Problem::new(
            Code::KeyRequired,
            "this service asks for a key: send -H 'Authorization: Bearer <key>'; its operator makes one with \
             landmarkd keys create",
        ),
        Denied::Unknown => Problem::new(
            Code::KeyRequired,
            "the key is not in force: it is misspelt, or was revoked; ask whoever gave it to you",
        ),
        Denied::TooOften(wait) => Problem::new(
            Code::RateLimited,
            format!("the key was used more often than it may be: come back in {:.3} s", wait.as_secs_f64()),
        )
        .until(wait),
    }
}

impl FromRequestParts<Service> for Caller {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _service: &Service) -> Result<Self, Problem> {
        let nobody = || Problem::new(Code::Internal, "the call came past the layer that asks for keys");
        parts.extensions.get::<Self>().cloned().ok_or_else(nobody)
    }
}
