//! Why a job stops before its end, and the failure that is kept with it.

use serde::{Deserialize, Deserializer, Serialize};

use crate::compute::ComputeError;
use crate::database::DatabaseError;
use crate::problem::Code;
use crate::store::CatalogueError;
use crate::telemetry::chain;

/// Why a job failed, as it is kept with the job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// The kind of problem.
    #[serde(deserialize_with = "known_code")]
    pub code: Code,
    /// What happened, and what to do.
    pub detail: String,
}

/// A newer release may have kept a code that this one doesn't know.
fn known_code<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Code, D::Error> {
    let word = String::deserialize(deserializer)?;
    Ok(Code::from_word(&word).unwrap_or(Code::Internal))
}

impl Failure {
    /// The failure in the document that is kept with a job.
    pub fn from_document(document: &str) -> Self {
        serde_json::from_str(document).unwrap_or_else(|_| Self {
            code: Code::Internal,
            detail: "the job failed and left no reason".into(),
        })
    }

    pub(super) fn to_document(&self) -> String {
        serde_json::to_string(self).expect("words and text always serialise")
    }
}

/// Why a job stops before its end.
#[derive(Debug)]
pub(super) enum Stop {
    /// Somebody cancelled it.
    Cancelled,
    /// Another worker has it now, or the service is shutting down: leave it alone.
    Lost,
    /// It can't be done.
    Failed(Failure),
    /// A store is away: the job goes back into the queue.
    Unavailable(DatabaseError),
}

impl Stop {
    pub(super) fn failed(code: Code, detail: impl Into<String>) -> Self {
        Self::Failed(Failure { code, detail: detail.into() })
    }
}

impl From<DatabaseError> for Stop {
    fn from(error: DatabaseError) -> Self {
        match error {
            DatabaseError::Catalogue { source: CatalogueError::LeaseLost } => Self::Lost,
            DatabaseError::Catalogue { source: CatalogueError::CancelRequested } => Self::Cancelled,
            DatabaseError::Catalogue { source: CatalogueError::NotFound { what } } => {
                Self::failed(Code::UnknownDatabase, format!("{what}; it was deleted meanwhile"))
            }
            error @ DatabaseError::LostExemplar { .. } => {
                let advice = "post the same picture again, or delete it, and train again";
                Self::failed(Code::UnreadableExemplar, format!("{}; {advice}", chain(&error)))
            }
            DatabaseError::Blobs { source } if source.is_damage() => {
                Self::failed(Code::UnreadablePicture, chain(&source))
            }
            DatabaseError::Unloadable { reason, .. } => {
                Self::failed(Code::Internal, format!("the new version can't be read back: {reason}"))
            }
            DatabaseError::Compute { source: ComputeError::Panicked { message } } => {
                Self::failed(Code::Internal, format!("the computation failed: {message}"))
            }
            error @ DatabaseError::CalibrationChanged { .. } => {
                Self::failed(Code::CalibrationChanged, format!("{error}: sweep it again"))
            }
            error @ DatabaseError::UnknownCalibration { .. } => {
                Self::failed(Code::UnknownCalibration, format!("{error}; it was deleted meanwhile"))
            }
            error @ DatabaseError::UnreadableCalibration { .. } => {
                Self::failed(Code::Internal, chain(&error))
            }
            error => Self::Unavailable(error),
        }
    }
}

impl From<CatalogueError> for Stop {
    fn from(error: CatalogueError) -> Self {
        DatabaseError::from(error).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_comes_back_from_its_document_and_an_unknown_code_is_internal() {
        let failure = Failure { code: Code::AllEqual, detail: "one picture".into() };
        assert_eq!(failure.to_document(), r#"{"code":"all_equal","detail":"one picture"}"#);
        assert_eq!(Failure::from_document(&failure.to_document()), failure);
        let newer = Failure::from_document(r#"{"code":"of_tomorrow","detail":"x"}"#);
        assert_eq!((newer.code, newer.detail.as_str()), (Code::Internal, "x"));
        assert_eq!(Failure::from_document("").code, Code::Internal);
    }
}
