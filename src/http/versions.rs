//! `/v1/databases/{database}/versions[/{version}[/artifact]]`: what trainings made. A version never changes.

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::extract::{Path, Query};
use super::middleware::LONG_CALL;
use super::pages::{Page, PageQuery, Paging};
use super::paths::DatabasePath;
use super::preconditions::Tags;
use super::problem::{Code, Problem};
use super::{Service, body, put_status};
use crate::access::Caller;
use crate::database::{Kind, Name, Options, OptionsDocument, Report, VersionRow};

/// The version that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct VersionPath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
    /// Number of the version.
    #[param(minimum = 1)]
    pub version: i64,
}

/// A trained version.
#[derive(Debug, Serialize, ToSchema)]
pub struct VersionBody {
    pub version: i64,
    /// Digest of the inputs: the same exemplars, options and algorithm give the same digest.
    pub digest: String,
    pub created_at: Timestamp,
    /// Algorithm revision that trained it.
    pub revision: i64,
    /// Size of the artifact file.
    pub artifact_bytes: u64,
    /// What it was trained with. The colour of landmarks as it came out; the dimension and size of objects stand in the
    /// report.
    pub options: OptionsDocument,
    pub counts: CountsBody,
    pub report: Report,
}

/// What a version was trained from.
#[derive(Debug, Serialize, Deserialize, ToSchema)]
pub struct CountsBody {
    pub exemplars: u64,
    pub labels: u64,
    /// 0 for objects.
    pub interest_points: u64,
}

impl TryFrom<VersionRow> for VersionBody {
    type Error = Problem;

    fn try_from(row: VersionRow) -> Result<Self, Problem> {
        let unreadable = |what: &str, error: &dyn std::error::Error| {
            tracing::error!(
                row.database,
                row.version,
                error = crate::telemetry::chain(error),
                "unreadable {what}"
            );
            Problem::new(
                Code::Internal,
                format!("the {what} kept with version {} can't be read", row.version),
            )
        };
        let kind = Kind::parse(&row.kind).ok_or_else(|| {
            let text = format!("version {} is of kind {}: this release can't read it", row.version, row.kind);
            Problem::new(Code::NotYet, text)
        })?;
        let options =
            Options::from_document(kind, &row.options).map_err(|error| unreadable("options", &error))?;
        Ok(Self {
            version: row.version,
            created_at: row.created_at,
            revision: row.algorithm_revision,
            artifact_bytes: row.bytes,
            options: (&options).into(),
            counts: serde_json::from_str(&row.counts).map_err(|error| unreadable("counts", &error))?,
            report: Report::from_document(kind, &row.report)
                .map_err(|error| unreadable("report", &error))?
                .complete(),
            digest: row.digest,
        })
    }
}

/// Versions by number.
#[utoipa::path(
    get, operation_id = "list_versions",
    path = "/v1/databases/{database}/versions", tag = "databases", security(("key" = ["recognise"])), params(DatabasePath, PageQuery),
    responses((status = 200, body = Page<VersionBody>))
)]
pub async fn list(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<VersionBody>>, Problem> {
    let Paging { limit, after } = Paging::read(page.limit, page.cursor.as_deref())?;
    service.databases.get(&path.database).await?;
    let rows = service.databases.versions(&path.database, after, limit).await?;
    let page = Page::of(rows, limit, |row| row.version.to_string(), VersionBody::try_from);
    let items = page.items.into_iter().collect::<Result<_, _>>()?;
    Ok(Json(Page { items, next_cursor: page.next_cursor }))
}

/// One version with its report.
#[utoipa::path(
    get, operation_id = "get_version",
    path = "/v1/databases/{database}/versions/{version}", tag = "databases", security(("key" = ["recognise"])), params(VersionPath),
    responses((status = 200, body = VersionBody))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<VersionPath>,
) -> Result<Json<VersionBody>, Problem> {
    service.databases.get(&path.database).await?;
    Ok(Json(service.databases.version(&path.database, path.version).await?.try_into()?))
}

/// Delete a version that no alias points to.
#[utoipa::path(
    delete, operation_id = "delete_version",
    path = "/v1/databases/{database}/versions/{version}", tag = "databases", security(("key" = ["admin"])), params(VersionPath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<VersionPath>,
) -> Result<StatusCode, Problem> {
    service.databases.get(&path.database).await?;
    service.databases.delete_version(&path.database, path.version, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// The version as one file (safetensors): a backup, or another site's database.
#[utoipa::path(
    get, operation_id = "get_version_artifact",
    path = "/v1/databases/{database}/versions/{version}/artifact", tag = "databases", security(("key" = ["recognise"])), params(VersionPath),
    responses(
        (status = 200, description = "The artifact file", body = Vec<u8>, content_type = "application/octet-stream",
         headers(("ETag" = String))),
        (status = 304, description = "You have it"),
    )
)]
pub async fn artifact(
    State(service): State<Service>,
    Path(path): Path<VersionPath>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    service.databases.get(&path.database).await?;
    let row = service.databases.version(&path.database, path.version).await?;
    let etag = match if_none_match(&headers, &row.blob)? {
        IfNoneMatch::NotModified(response) => return Ok(response),
        IfNoneMatch::Modified(etag) => etag,
    };
    let bytes = service.databases.artifact(&row).await?;
    let name = format!("attachment; filename=\"{}-{}.safetensors\"", row.database, row.version);
    let name = HeaderValue::from_str(&name).unwrap_or(HeaderValue::from_static("attachment"));
    let kind = HeaderValue::from_static("application/octet-stream");
    let cache = HeaderValue::from_static("private, no-cache");
    let headers = [
        (header::ETAG, etag),
        (header::CONTENT_TYPE, kind),
        (header::CONTENT_DISPOSITION, name),
        (header::CACHE_CONTROL, cache),
    ];
    Ok((headers, bytes).into_response())
}

/// The outcome of a conditional request.
pub enum IfNoneMatch {
    /// The caller has it: the answer 304.
    NotModified(Response),
    /// The caller hasn't: the ETag of what it gets.
    Modified(HeaderValue),
}

/// Compares the header `If-None-Match` with the ETag of that name.
pub fn if_none_match(headers: &HeaderMap, name: &str) -> Result<IfNoneMatch, Problem> {
    let etag = format!("\"{name}\"");
    // A header that can't be read says nothing of what the caller has: it gets the version.
    let tags = Tags::of(headers, header::IF_NONE_MATCH).ok().flatten();
    let matches = tags.is_some_and(|tags| tags.matches_weakly(&etag));
    let etag =
        HeaderValue::from_str(&etag).map_err(|_| Problem::new(Code::Internal, "the version has no ETag"))?;
    Ok(match matches {
        true => IfNoneMatch::NotModified((StatusCode::NOT_MODIFIED, [(header::ETAG, etag)]).into_response()),
        false => IfNoneMatch::Modified(etag),
    })
}

/// Take in an artifact file: checked whole, then a new version. The same digest again is the same version.
#[utoipa::path(
    post, operation_id = "import_version",
    path = "/v1/databases/{database}/versions", tag = "databases", security(("key" = ["train"])), params(DatabasePath),
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses(
        (status = 201, body = VersionBody, description = "Taken in"),
        (status = 200, body = VersionBody, description = "It was there"),
    )
)]
pub async fn import(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<DatabasePath>,
    request: Request,
) -> Result<(StatusCode, Json<VersionBody>), Problem> {
    let (parts, body) = request.into_parts();
    service.databases.get(&path.database).await?;
    let most = service.limits.max_artifact_bytes;
    let _share = service.bodies.admit(&parts.headers, most)?;
    // As long as the middleware gives the whole call: an artifact is as large as a batch.
    let bytes = body::read_whole(body, most, service.limits.body_timeout * LONG_CALL).await?;
    let (row, created) =
        service.databases.import(&path.database, bytes, &service.compute, &caller.actor()).await?;
    Ok((put_status(created), Json(row.try_into()?)))
}
