//! Path parameters that several resources share.

use serde::Deserialize;
use utoipa::IntoParams;

use crate::database::Name;

/// The database that a call is about.
#[derive(Debug, Clone, Deserialize, IntoParams)]
#[into_params(parameter_in = Path)]
pub struct DatabasePath {
    /// Name of the database.
    #[param(value_type = String, pattern = "^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    pub database: Name,
}
