//! The one layer that asks who calls, around every route: what a call needs stands with its handler, as `security` in
//! the OpenAPI document, and is read from there. What stands nowhere needs everything.

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

use super::problem::{Code, Problem};
use super::rim::RequestId;
use super::{Service, console};
use crate::access::{Actor, Caller, Denied, Scope};
use crate::compute;

/// Name of the security scheme in the document.
const SCHEME: &str = "key";
/// What the router has beside the calls of the document: the document itself, and the pages that show it. They and the
/// console are the same for everybody and hold nothing that was told to the service: no key is needed.
const PAGES: [&str; 4] = ["/openapi.json", "/docs", "/docs/", "/docs/{*rest}"];

/// What each call needs, by route and method; none where no key is needed.
pub struct Needs {
    calls: HashMap<(String, Method), Option<Scope>>,
}

impl Needs {
    /// As the document says.
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

    /// What a call needs; `route` is none for an address that no route has: there is nothing, and any key may hear so.
    fn need(&self, route: Option<&str>, method: &Method) -> Option<Scope> {
        let Some(route) = route else { return Some(Scope::Recognise) };
        // Who may GET may HEAD.
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

/// Say in the document how a key is sent.
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

/// Lets a call in, or says why not; the handlers find the [`Caller`] in the request.
pub async fn ask(
    State((service, needs)): State<(Service, Arc<Needs>)>,
    request: Request,
    next: Next,
) -> Response {
    let (mut parts, body) = request.into_parts();
    match admit(&service, &needs, &mut parts).await {
        Ok(None) => next.run(Request::from_parts(parts, body)).await,
        Ok(Some(caller)) => {
            let party = caller.key_number().map_or(compute::Party::Anyone, compute::Party::Key);
            parts.extensions.insert(caller.clone());
            let answering = compute::on_behalf_of(party, next.run(Request::from_parts(parts, body)));
            tokio::select! {
                answer = answering => answer,
                // What a batch added until then stays.
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

async fn admit(service: &Service, needs: &Needs, parts: &mut Parts) -> Result<Option<Caller>, Problem> {
    let route = parts.extensions.get::<MatchedPath>().map(|route| route.as_str().to_owned());
    let Some(need) = needs.need(route.as_deref(), &parts.method) else { return Ok(None) };
    if !service.keyring.asks() {
        keep_strange_pages_out(parts, service.insecure)?;
    }
    let caller = service.keyring.admit(bearer(&parts.headers)).map_err(denied)?;
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

/// A service that asks for no key is reached by every page that a browser on this machine shows. A page of another
/// origin says so in `Origin`; one that had its own name lead here (DNS rebinding) gives that name as the host.
fn keep_strange_pages_out(parts: &Parts, by_any_name: bool) -> Result<(), Problem> {
    let text = |name| parts.headers.get(name).and_then(|value| value.to_str().ok());
    let authority = parts.uri.authority().map(Authority::as_str).or_else(|| text(HOST));
    let origin = parts.headers.contains_key(ORIGIN).then(|| {
        let origin = text(ORIGIN).and_then(|origin| origin.parse::<Uri>().ok());
        origin.and_then(|origin| origin.into_parts().authority)
    });
    let is_foreign = origin.is_some_and(|origin| origin.as_ref().map(Authority::as_str) != authority);
    let host = authority.and_then(|authority| authority.parse::<Authority>().ok());
    let host = host.as_ref().map(|host| host.host().trim_matches(['[', ']']));
    // Programs that send no host are no browsers.
    let is_here = host.is_none_or(|host| host == "localhost" || host.parse::<IpAddr>().is_ok());
    if is_foreign || !(is_here || by_any_name) {
        return Err(Problem::new(
            Code::NotAllowed,
            "without keys only this machine is let in, by localhost or an address, and no page of another site: make a \
             key with landmarkd keys create",
        ));
    }
    Ok(())
}

/// Refuse what the caller's key doesn't reach.
pub fn reach(caller: &Caller, database: &str) -> Result<(), Problem> {
    if caller.reaches(database) {
        return Ok(());
    }
    Err(Problem::new(Code::NotAllowed, format!("the key isn't for database {database}")))
}

/// The key of a call; anything else that stands there is no key.
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

/// The caller, and the call's id, for the record.
pub struct Who {
    pub caller: Caller,
    request_id: Option<String>,
}

impl Who {
    /// The caller as the record names it.
    pub fn actor(&self) -> Actor {
        self.caller.actor(self.request_id.clone())
    }
}

impl FromRequestParts<Service> for Who {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _service: &Service) -> Result<Self, Problem> {
        let nobody = || Problem::new(Code::Internal, "the call came past the layer that asks for keys");
        let caller = parts.extensions.get::<Caller>().cloned().ok_or_else(nobody)?;
        let request_id = parts.extensions.get::<RequestId>().map(|id| id.0.clone());
        Ok(Self { caller, request_id })
    }
}
