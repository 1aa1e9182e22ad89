//! `/v1/databases[/{database}]`.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::aliases::AliasBody;
use super::extract::{Json as JsonIn, Path, Query};
use super::options;
use super::pages::{self, Page, PageQuery};
use super::paths::DatabasePath;
use super::problem::{Code, Problem};
use super::{Service, put_status};
use crate::access::Caller;
use crate::database::{CURRENT, DatabaseRow, Kind, Options, OptionsDocument};

/// A database to create.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewDatabase {
    pub kind: Kind,
    /// What is absent has its default. For a database that is there: replaces its options from the next training on.
    #[schema(value_type = Option<OptionsDocument>)]
    pub options: Option<Map<String, Value>>,
}

/// A database.
#[derive(Debug, Serialize, ToSchema)]
pub struct DatabaseBody {
    pub name: String,
    pub kind: Kind,
    /// Options of the next training.
    pub options: OptionsDocument,
    pub created_at: Timestamp,
}

/// A database with what it holds.
#[derive(Debug, Serialize, ToSchema)]
pub struct DatabaseDetail {
    #[serde(flatten)]
    pub database: DatabaseBody,
    /// Training images.
    pub exemplars: u64,
    /// Distinct labels among them.
    pub labels: u64,
    /// Trained versions.
    pub versions: u64,
    /// The version that `current` points to.
    pub current_version: Option<i64>,
    pub aliases: Vec<AliasBody>,
}

impl TryFrom<DatabaseRow> for DatabaseBody {
    type Error = Problem;

    fn try_from(row: DatabaseRow) -> Result<Self, Problem> {
        let options = read_options(&row)?;
        Ok(Self {
            kind: options.kind(),
            name: row.name,
            options: (&options).into(),
            created_at: row.created_at,
        })
    }
}

fn read_kind(row: &DatabaseRow) -> Result<Kind, Problem> {
    Kind::parse(&row.kind).ok_or_else(|| {
        Problem::new(
            Code::NotYet,
            format!("database {} is of kind {}: this release can't read it", row.name, row.kind),
        )
    })
}

/// The options kept with a database.
pub fn read_options(row: &DatabaseRow) -> Result<Options, Problem> {
    Options::from_document(read_kind(row)?, &row.options).map_err(|error| {
        tracing::error!(database = row.name, error = crate::telemetry::chain(&error), "unreadable options");
        Problem::new(Code::Internal, format!("the options kept with database {} can't be read", row.name))
    })
}

/// Create a database, or change the options of the one of that name.
#[utoipa::path(
    put, operation_id = "put_database",
    path = "/v1/databases/{database}", tag = "databases", security(("key" = ["train"])), params(DatabasePath), request_body = NewDatabase,
    responses(
        (status = 201, body = DatabaseBody, description = "Created"),
        (status = 200, body = DatabaseBody, description = "It was there"),
    )
)]
pub async fn put(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<DatabasePath>,
    JsonIn(new): JsonIn<NewDatabase>,
) -> Result<(StatusCode, Json<DatabaseBody>), Problem> {
    let options =
        new.options.map(|body| options::patched(Options::default_of(new.kind), &body)).transpose()?;
    let (row, created) =
        service.databases.create(&path.database, new.kind, options.as_ref(), &caller.actor()).await?;
    let status = put_status(created);
    Ok((status, Json(row.try_into()?)))
}

/// Databases by name.
#[utoipa::path(
    get, operation_id = "list_databases",
    path = "/v1/databases", tag = "databases", security(("key" = ["recognise"])), params(PageQuery),
    responses((status = 200, body = Page<DatabaseBody>))
)]
pub async fn list(
    State(service): State<Service>,
    caller: Caller,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<DatabaseBody>>, Problem> {
    let limit = pages::limit(page.limit)?;
    let rows = service.databases.list(page.cursor.as_deref(), limit).await?;
    let page = Page::of(rows, limit, |row| row.name.clone(), DatabaseBody::try_from);
    let reached =
        |body: &Result<DatabaseBody, _>| body.as_ref().map_or(true, |body| caller.reaches(&body.name));
    let items = page.items.into_iter().filter(reached).collect::<Result<_, _>>()?;
    Ok(Json(Page { items, next_cursor: page.next_cursor }))
}

/// One database with counts, aliases and current version.
#[utoipa::path(
    get, operation_id = "get_database",
    path = "/v1/databases/{database}", tag = "databases", security(("key" = ["recognise"])), params(DatabasePath),
    responses((status = 200, body = DatabaseDetail))
)]
pub async fn get(
    State(service): State<Service>,
    Path(path): Path<DatabasePath>,
) -> Result<Json<DatabaseDetail>, Problem> {
    let row = service.databases.get(&path.database).await?;
    let counts = service.databases.counts(&path.database).await?;
    let aliases = service.databases.aliases(&path.database).await?;
    Ok(Json(DatabaseDetail {
        database: row.try_into()?,
        exemplars: counts.exemplars,
        labels: counts.labels,
        versions: counts.versions,
        current_version: aliases.iter().find(|row| row.alias == CURRENT).map(|row| row.version),
        aliases: aliases.into_iter().map(AliasBody::from).collect(),
    }))
}

/// Delete a database with all it holds.
#[utoipa::path(
    delete, operation_id = "delete_database",
    path = "/v1/databases/{database}", tag = "databases", security(("key" = ["admin"])), params(DatabasePath),
    responses((status = 204, description = "Gone"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<DatabasePath>,
) -> Result<StatusCode, Problem> {
    service.databases.delete(&path.database, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}
