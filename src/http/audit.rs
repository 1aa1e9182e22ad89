//! `/v1/audit`: who changed what.

use axum::Json;
use axum::extract::State;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::{IntoParams, ToSchema};

use super::Service;
use super::extract::Query;
use super::keys::unconfined;
use super::pages::{Page, Paging};
use super::problem::Problem;
use crate::access::{AuditFilter, AuditRow, Caller};

/// Which entries are meant.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct AuditQuery {
    /// About this database.
    pub database: Option<String>,
    /// Done with the key of this id.
    pub key: Option<String>,
    /// Of this action, such as `alias.set`.
    pub action: Option<String>,
    /// Most items to give.
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub limit: Option<u32>,
    /// `next_cursor` of the page before.
    pub cursor: Option<String>,
}

/// An entry of the record.
#[derive(Debug, Serialize, ToSchema)]
pub struct AuditBody {
    /// Grows with every entry; one of a change that was undone may be missing.
    pub id: i64,
    pub at: Timestamp,
    /// Id of the key that the call came with.
    pub key: Option<String>,
    /// The key's name; without a key `anyone`, `command line`, or `job` and its id.
    #[schema(example = "robot 7")]
    pub actor: String,
    /// `X-Request-Id` of the call.
    pub request_id: Option<String>,
    #[schema(example = "alias.set")]
    pub action: String,
    pub database: Option<String>,
    /// What of it: an alias, a version's number, an exemplar's id, a key's id.
    #[schema(example = "current")]
    pub subject: Option<String>,
    /// More about it, as the action has it.
    #[schema(value_type = Object, example = json!({"version": 3}))]
    pub detail: Value,
}

impl From<AuditRow> for AuditBody {
    fn from(row: AuditRow) -> Self {
        Self {
            id: row.id,
            at: row.at,
            key: row.actor.key,
            actor: row.actor.name,
            request_id: row.actor.request_id,
            action: row.action,
            database: row.database,
            subject: row.subject,
            detail: serde_json::from_str(&row.detail).unwrap_or_default(),
        }
    }
}

/// Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells, jobs and everything
/// that was deleted. An entry is written with its change, and can't be changed or deleted.
#[utoipa::path(
    get, operation_id = "list_audit",
    path = "/v1/audit", tag = "access", security(("key" = ["admin"])), params(AuditQuery),
    responses((status = 200, body = Page<AuditBody>))
)]
pub async fn list(
    State(service): State<Service>,
    caller: Caller,
    Query(query): Query<AuditQuery>,
) -> Result<Json<Page<AuditBody>>, Problem> {
    unconfined(&caller)?;
    let Paging { limit, after: before } = Paging::read(query.limit, query.cursor.as_deref())?;
    let AuditQuery { database, key, action, .. } = query;
    let rows = service.keyring.audit(&AuditFilter { database, key, action }, before, limit).await?;
    Ok(Json(Page::of(rows, limit, |row| row.id.to_string(), AuditBody::from)))
}
