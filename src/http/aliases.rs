//! `/v1/databases/{database}/aliases[/{alias}]`: moving names for versions. `current` answers when a call names none.

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::extract::{Json as JsonIn, Path};
use super::pages::Page;
use super::paths::DatabasePath;
use super::preconditions::Tags;
use super::problem::{Code, Problem};
use super::{Service, put_status};
use crate::access::Caller;
use crate::database::{AliasExpectation, AliasRow, DatabaseError, Name};

/// The alias that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct AliasPath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Name of the alias.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub alias: Name,
}

/// Where an alias shall point.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewAlias {
    /// Number of a version that loads.
    #[schema(minimum = 1)]
    pub version: i64,
}

/// An alias.
#[derive(Debug, Serialize, ToSchema)]
pub struct AliasBody {
    pub alias: String,
    pub version: i64,
    pub updated_at: Timestamp,
}

impl From<AliasRow> for AliasBody {
    fn from(row: AliasRow) -> Self {
        Self { alias: row.alias, version: row.version, updated_at: row.updated_at }
    }
}

fn etag(revision: i64) -> String {
    format!("\"{revision}\"")
}

fn with_etag(status: StatusCode, row: AliasRow) -> Response {
    let etag = etag(row.revision);
    (status, [(header::ETAG, etag)], Json(AliasBody::from(row))).into_response()
}

/// The state of the alias that `If-Match` and `If-None-Match` expect.
async fn expected(
    service: &Service,
    path: &AliasPath,
    headers: &HeaderMap,
) -> Result<AliasExpectation, Problem> {
    match Tags::of(headers, header::IF_NONE_MATCH)? {
        Some(Tags::Any) => return Ok(AliasExpectation::Absent),
        Some(Tags::Listed(_)) => {
            let text = "If-None-Match must be *: the alias must not be there yet. If-Match takes its ETag";
            return Err(Problem::new(Code::MalformedRequest, text));
        }
        None => {}
    }
    let Some(tags) = Tags::of(headers, header::IF_MATCH)? else { return Ok(AliasExpectation::Any) };
    match service.databases.alias(&path.database, &path.alias).await {
        // The alias may change before it is written: the write expects the revision that was read here.
        Ok(row) if tags.matches(&etag(row.revision)) => Ok(AliasExpectation::Revision(row.revision)),
        Ok(_) | Err(DatabaseError::UnknownAlias { .. }) => Err(DatabaseError::PreconditionFailed.into()),
        Err(error) => Err(error.into()),
    }
}

/// Point an alias to a version. The answer comes when this process serves it.
#[utoipa::path(
    put, operation_id = "put_alias",
    path = "/v1/databases/{database}/aliases/{alias}", tag = "databases", security(("key" = ["train"])), params(AliasPath),
    request_body = NewAlias,
    responses(
        (status = 200, body = AliasBody, description = "Moved", headers(("ETag" = String))),
        (status = 201, body = AliasBody, description = "Created", headers(("ETag" = String))),
    )
)]
pub async fn put(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<AliasPath>,
    headers: HeaderMap,
    JsonIn(new): JsonIn<NewAlias>,
) -> Result<Response, Problem> {
    service.databases.get(&path.database).await?;
    let expected = expected(&service, &path, &headers).await?;
    let actor = caller.actor();
    let set = service.databases.set_alias(&path.database, &path.alias, new.version, expected, &actor);
    let (row, created) = set.await?;
    Ok(with_etag(put_status(created), row))
}

/// One alias.
#[utoipa::path(
    get, operation_id = "get_alias",
    path = "/v1/databases/{database}/aliases/{alias}", tag = "databases", security(("key" = ["recognise"])), params(AliasPath),
    responses((status = 200, body = AliasBody, headers(("ETag" = String))))
)]
pub async fn get(State(service): State<Service>, Path(path): Path<AliasPath>) -> Result<Response, Problem> {
    service.databases.get(&path.database).await?;
    let row = service.databases.alias(&path.database, &path.alias).await?;
    Ok(with_etag(StatusCode::OK, row))
}

/// The aliases of a database, by name.
#[utoipa::path(
    get, operation_id = "list_aliases",
    path = "/v1/databases/{database}/aliases", tag = "databases", security(("key" = ["recognise"])), params(DatabasePath),
    responses((status = 200, body = Page<AliasBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
) -> Result<Json<Page<AliasBody>>, Problem> {
    service.databases.get(&path.database).await?;
    let rows = service.databases.aliases(&path.database).await?;
    Ok(Json(Page::whole(rows)))
}

/// Delete an alias; its version stays.
#[utoipa::path(
    delete, operation_id = "delete_alias",
    path = "/v1/databases/{database}/aliases/{alias}", tag = "databases", security(("key" = ["train"])), params(AliasPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<AliasPath>,
    headers: HeaderMap,
) -> Result<StatusCode, Problem> {
    service.databases.get(&path.database).await?;
    let expected = expected(&service, &path, &headers).await?;
    service.databases.delete_alias(&path.database, &path.alias, expected, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
