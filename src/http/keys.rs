//! `/v1/keys[/{id}]`: who may call.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::Service;
use super::extract::{Json as JsonIn, Path, Query};
use super::pages::{self, Page, PageQuery};
use super::problem::{Code, Problem};
use crate::access::{Caller, Grant, IssuedKey, KeyRow, Scope};

/// A key to make.
#[derive(Debug, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewKeyBody {
    /// For people: whose key it is.
    #[schema(example = "robot 7", min_length = 1, max_length = 128)]
    pub name: String,
    pub scope: Scope,
    /// Names of the databases that it reaches, with `*` and `?`; null: every one.
    #[schema(example = json!(["floor-*"]), min_items = 1, max_items = 64)]
    pub databases: Option<Vec<String>>,
    /// Most calls a second, to each process; null: as many as there is time for.
    #[schema(minimum = 1, maximum = 10000)]
    pub requests_per_s: Option<u32>,
}

/// A key, without its secret.
#[derive(Debug, Serialize, ToSchema)]
pub struct KeyBody {
    #[schema(example = "2f6b1c09d4e7a853")]
    pub id: String,
    pub name: String,
    #[schema(value_type = Scope)]
    pub scope: String,
    pub databases: Option<Vec<String>>,
    pub requests_per_s: Option<i64>,
    pub created_at: Timestamp,
    /// Of other processes within a minute or so.
    pub last_used_at: Option<Timestamp>,
    /// It isn't taken any more from then on.
    pub revoked_at: Option<Timestamp>,
}

impl From<KeyRow> for KeyBody {
    fn from(row: KeyRow) -> Self {
        Self {
            databases: row.databases.and_then(|kept| serde_json::from_str(&kept).ok()),
            id: row.id,
            name: row.name,
            scope: row.scope,
            requests_per_s: row.requests_per_s,
            created_at: row.created_at,
            last_used_at: row.last_used_at,
            revoked_at: row.revoked_at,
        }
    }
}

/// A new key, shown this once.
#[derive(Debug, Serialize, ToSchema)]
pub struct KeyMade {
    /// The key itself: keep it, it isn't shown again.
    #[schema(example = "lmk_2f6b1c09d4e7a853_…")]
    pub key: String,
    #[serde(flatten)]
    pub about: KeyBody,
}

/// The key that a call is about.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct KeyPath {
    /// Id of the key.
    pub id: String,
}

/// Make a key. It is shown in this answer, and never again. The first one is made with `landmarkd keys create`; from then
/// on every call needs one.
#[utoipa::path(
    post, operation_id = "create_key",
    path = "/v1/keys", tag = "access", security(("key" = ["admin"])), request_body = NewKeyBody,
    responses((status = 201, body = KeyMade))
)]
pub async fn post(
    State(service): State<Service>,
    caller: Caller,
    JsonIn(new): JsonIn<NewKeyBody>,
) -> Result<(StatusCode, Json<KeyMade>), Problem> {
    unconfined(&caller)?;
    if !service.keyring.requires_key() {
        // Whoever made the first would have the service for themselves.
        let text =
            "the first key is made on the machine itself: landmarkd keys create --name NAME --scope admin";
        return Err(Problem::new(Code::NotAllowed, text));
    }
    let NewKeyBody { name, scope, databases, requests_per_s } = new;
    let grant = Grant { name, scope, databases, requests_per_s };
    let IssuedKey { key, row } = service.keyring.create(&grant, &caller.actor()).await?;
    Ok((StatusCode::CREATED, Json(KeyMade { key: key.reveal().to_owned(), about: row.into() })))
}

/// Keys, revoked ones too, the oldest first.
#[utoipa::path(
    get, operation_id = "list_keys",
    path = "/v1/keys", tag = "access", security(("key" = ["admin"])), params(PageQuery),
    responses((status = 200, body = Page<KeyBody>))
)]
pub async fn list(
    State(service): State<Service>,
    caller: Caller,
    Query(page): Query<PageQuery>,
) -> Result<Json<Page<KeyBody>>, Problem> {
    unconfined(&caller)?;
    let limit = pages::limit(page.limit)?;
    let rows = service.keyring.list().await?;
    let start = match page.cursor {
        None => 0,
        Some(id) => {
            let at = rows.iter().position(|row| row.id == id);
            at.ok_or_else(|| Problem::field("#cursor", "is not a next_cursor of this list"))? + 1
        }
    };
    let rows: Vec<KeyRow> = rows.into_iter().skip(start).take(limit as usize).collect();
    Ok(Json(Page::of(rows, limit, |row| row.id.clone(), KeyBody::from)))
}

/// One key.
#[utoipa::path(
    get, operation_id = "get_key",
    path = "/v1/keys/{id}", tag = "access", security(("key" = ["admin"])), params(KeyPath),
    responses((status = 200, body = KeyBody))
)]
pub async fn get(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<KeyPath>,
) -> Result<Json<KeyBody>, Problem> {
    unconfined(&caller)?;
    let rows = service.keyring.list().await?;
    let row = rows.into_iter().find(|row| row.id == path.id);
    let unknown = || Problem::new(Code::UnknownKey, format!("there is no key {}", path.id));
    Ok(Json(row.ok_or_else(unknown)?.into()))
}

/// Revoke a key, for good. Every process of a fleet refuses it at once; one that is cut off from the catalogue, when
/// it can reach it again.
#[utoipa::path(
    delete, operation_id = "revoke_key",
    path = "/v1/keys/{id}", tag = "access", security(("key" = ["admin"])), params(KeyPath),
    responses((status = 204, description = "It isn't taken any more"))
)]
pub async fn delete(
    State(service): State<Service>,
    caller: Caller,
    Path(path): Path<KeyPath>,
) -> Result<StatusCode, Problem> {
    unconfined(&caller)?;
    service.keyring.revoke(&path.id, &caller.actor()).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Whether the caller's key reaches every database: a key for some must not make one for all, nor read what was done to
/// the others.
///
/// # Errors
/// 403 when it doesn't.
pub fn unconfined(caller: &Caller) -> Result<(), Problem> {
    if caller.is_confined() {
        let text = "this call needs a key of scope admin that reaches every database";
        return Err(Problem::new(Code::NotAllowed, text));
    }
    Ok(())
}
