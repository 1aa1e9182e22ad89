//! Problem documents (RFC 9457). `type` is the address of a page of this service on the code: title and advice.

use std::time::Duration;

use axum::Json;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use utoipa::ToSchema;

use crate::access::AccessError;
use crate::compute::ComputeError;
use crate::database::DatabaseError;
use crate::database::artifact::ArtifactError;
use crate::jobs::{Failure, JobError};
pub use crate::problem::Code;
use crate::store::{BlobError, CatalogueError, operator_advice};
use crate::telemetry::chain;
use landmarkd_core::depth::{
    BlurScaleError, EstimateError, EstimatorError, PairError, RegistrationError, SweepError,
};
use landmarkd_core::imaging::DecodeError;
use landmarkd_core::recognition::objects::SizeMismatch;

/// A field that is at fault.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FieldError {
    /// JSON pointer (RFC 6901) into the body, or the name of the query or path parameter after `#`.
    #[schema(example = "/options/rings")]
    pub pointer: String,
    /// What is wrong with it.
    pub detail: String,
}

/// What went wrong with a call, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The kind of problem.
    pub code: Code,
    /// What happened here, and what to do.
    pub detail: String,
    /// The fields at fault.
    pub errors: Vec<FieldError>,
    retry_after_s: Option<u64>,
}

/// A problem document, `application/problem+json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemBody {
    /// The kind of problem: the address, on this service, of a page that says what to do.
    #[serde(rename = "type")]
    #[schema(format = "uri-reference", example = "/problems/not_trained")]
    pub kind: String,
    /// One line on the kind of problem.
    pub title: &'static str,
    /// The HTTP status.
    #[schema(example = 409)]
    pub status: u16,
    /// What happened here, and what to do.
    pub detail: String,
    /// The kind of problem, for programs.
    #[schema(example = "not_trained")]
    pub code: &'static str,
    /// The request's id, as in `X-Request-Id`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// The fields at fault.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<FieldError>,
}

/// The document of a problem inside another answer, which has the request's id itself.
impl From<Problem> for ProblemBody {
    fn from(problem: Problem) -> Self {
        let code = problem.code;
        Self {
            kind: format!("/problems/{}", code.word()),
            title: code.title(),
            status: code.status(),
            detail: problem.detail,
            code: code.word(),
            request_id: None,
            errors: problem.errors,
        }
    }
}

impl Problem {
    /// A problem of this kind.
    pub fn new(code: Code, detail: impl Into<String>) -> Self {
        let retry_after_s = code.has_retry_after().then_some(1);
        Self { code, detail: detail.into(), errors: Vec::new(), retry_after_s }
    }

    /// The same, to come back after that time: in whole seconds, rounded up, at least one.
    pub fn until(self, after: Duration) -> Self {
        Self { retry_after_s: Some(after.as_millis().div_ceil(1000).max(1) as u64), ..self }
    }

    /// Fields at fault, all of them.
    pub fn fields(errors: Vec<FieldError>) -> Self {
        let named: Vec<String> =
            errors.iter().map(|error| format!("{} {}", error.pointer, error.detail)).collect();
        Self::new(Code::InvalidField, named.join("; ")).with_errors(errors)
    }

    /// The same, pointing to these fields.
    pub fn with_errors(self, errors: Vec<FieldError>) -> Self {
        Self { errors, ..self }
    }

    /// One field at fault.
    pub fn field(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self::fields(vec![FieldError { pointer: pointer.into(), detail: detail.into() }])
    }

    /// The same, of this part of a form; what points into the part points into the form.
    pub fn in_part(self, name: &str) -> Self {
        let mut errors = self.errors;
        for error in &mut errors {
            error.pointer.insert_str(0, &format!("/{name}"));
        }
        if errors.is_empty() {
            errors.push(FieldError { pointer: format!("/{name}"), detail: self.detail.clone() });
        }
        Self { detail: format!("the part {name}: {}", self.detail), errors, ..self }
    }

    /// A failure of the service: logged with its causes, answered without them.
    fn internal(error: &dyn std::error::Error) -> Self {
        tracing::error!(error = chain(error), "internal error");
        Self::new(
            Code::Internal,
            "something went wrong in the service; the log has it under this request's id",
        )
    }

    /// Its HTTP status.
    pub fn status(&self) -> StatusCode {
        StatusCode::from_u16(self.code.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR)
    }

    /// The document as a response. The request middleware calls this: it has the request's id.
    pub fn render(self, request_id: Option<String>) -> Response {
        let (status, retry_after) = (self.status(), self.retry_after_s);
        let mut response = (status, Json(ProblemBody { request_id, ..self.into() })).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if let Some(seconds) = retry_after {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

/// Leaves the problem in the response's extensions; the request middleware renders it with the request's id.
impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = self.status().into_response();
        response.extensions_mut().insert(self);
        response
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        Self::new(failure.code, failure.detail)
    }
}

impl From<DecodeError> for Problem {
    fn from(error: DecodeError) -> Self {
        Self::new((&error).into(), chain(&error))
    }
}

impl From<SizeMismatch> for Problem {
    fn from(error: SizeMismatch) -> Self {
        let text = format!("{error}: send it in that size, or train the database with resize fit");
        Self::new(Code::ImageSizeMismatch, text)
    }
}

impl From<PairError> for Problem {
    fn from(error: PairError) -> Self {
        let advice = match error {
            PairError::SizeMismatch { .. } => "send two pictures of one size",
            PairError::Identical => "send the near-focused one as near and the far-focused one as far",
            PairError::TooSmall { .. } => "send larger ones",
        };
        Self::new((&error).into(), format!("{error}: {advice}"))
    }
}

impl From<EstimatorError> for Problem {
    fn from(error: EstimatorError) -> Self {
        match error {
            EstimatorError::Options { faults } => Self::fields(
                faults
                    .into_iter()
                    .map(|fault| FieldError {
                        pointer: format!("/options/{}", fault.field),
                        detail: fault.message,
                    })
                    .collect(),
            ),
            EstimatorError::NeedsTable | EstimatorError::OtherFilters => Self::new(
                Code::NeedsCalibration,
                format!("{error}: POST /v1/calibrations/{{name}}/sweep, or take another method"),
            ),
        }
    }
}

impl From<BlurScaleError> for Problem {
    fn from(error: BlurScaleError) -> Self {
        let advice = "state aperture_mm or f_number, or photograph a scene full of fine irregular texture";
        Self::new(Code::ScaleUnclear, format!("{error}: {advice}"))
    }
}

impl From<EstimateError> for Problem {
    fn from(error: EstimateError) -> Self {
        let EstimateError::OtherSize { .. } = error;
        Self::new(
            Code::ImageSizeMismatch,
            format!("{error}: send pictures of that size, or calibrate for these"),
        )
    }
}

impl From<RegistrationError> for Problem {
    fn from(error: RegistrationError) -> Self {
        let text =
            format!("{error}: show a flat target full of fine irregular texture, within the working range");
        Self::new(Code::RegistrationRefused, text)
    }
}

impl From<SweepError> for Problem {
    fn from(error: SweepError) -> Self {
        Self::new((&error).into(), chain(&error))
    }
}

impl From<ComputeError> for Problem {
    fn from(error: ComputeError) -> Self {
        match error {
            ComputeError::Full { retry_after, .. } => {
                Self::new(Code::Overloaded, format!("{error}: try again a little later")).until(retry_after)
            }
            error => Self::internal(&error),
        }
    }
}

impl From<AccessError> for Problem {
    fn from(error: AccessError) -> Self {
        match error {
            AccessError::Grant { field, fault } => Self::field(format!("/{field}"), fault),
            AccessError::UnknownKey { .. } => Self::new(Code::UnknownKey, error.to_string()),
            AccessError::NoRandomNumbers { .. } => Self::internal(&error),
            AccessError::Catalogue(source) => source.into(),
        }
    }
}

impl From<CatalogueError> for Problem {
    fn from(error: CatalogueError) -> Self {
        match error {
            CatalogueError::Unavailable { .. } => {
                tracing::warn!(error = chain(&error), "the catalogue is away");
                let text = operator_advice(&error);
                Self::new(
                    Code::CatalogueUnavailable,
                    format!("the catalogue can't be used: {text}; recognition goes on, try this again soon"),
                )
            }
            CatalogueError::NotFound { what } => {
                Self::new(Code::UnknownDatabase, format!("{what}: it was deleted meanwhile"))
            }
            error => Self::internal(&error),
        }
    }
}

impl From<DatabaseError> for Problem {
    fn from(error: DatabaseError) -> Self {
        let (code, advice) = match error {
            DatabaseError::UnknownDatabase { .. } => {
                (Code::UnknownDatabase, "; create it with PUT /v1/databases/{database}")
            }
            DatabaseError::UnknownExemplar { .. } => (Code::UnknownExemplar, ""),
            DatabaseError::UnknownVersion { .. } => (Code::UnknownVersion, ""),
            DatabaseError::UnknownAlias { .. } => (Code::UnknownAlias, ""),
            DatabaseError::UnknownCalibration { .. } => {
                (Code::UnknownCalibration, "; create it with PUT /v1/calibrations/{name}")
            }
            DatabaseError::CalibrationChanged { .. } => {
                (Code::CalibrationChanged, ": read it again and decide anew")
            }
            DatabaseError::UnknownWorkcell { .. } => {
                (Code::UnknownWorkcell, "; create it with PUT /v1/workcells/{name}")
            }
            DatabaseError::UnknownCamera { .. } => {
                (Code::UnknownCamera, "; keep it with PUT /v1/cameras/{name}")
            }
            DatabaseError::WrongKind { .. } => {
                (Code::KindConflict, ": PUT /v1/workcells/{name} with a database of that kind")
            }
            DatabaseError::KindConflict { .. } => {
                (Code::KindConflict, ": delete it first, or take another name")
            }
            DatabaseError::NotTrained { .. } => (
                Code::NotTrained,
                ": post exemplars, then POST /v1/databases/{database}/trainings and wait for the job",
            ),
            DatabaseError::NoCurrent { .. } => (
                Code::NoCurrent,
                ": PUT /v1/databases/{database}/aliases/current with one of them, or ask with ?version=",
            ),
            DatabaseError::VersionInUse { .. } => (Code::VersionInUse, ": point the alias elsewhere first"),
            DatabaseError::PreconditionFailed => {
                (Code::PreconditionFailed, ": read it again and decide anew")
            }
            DatabaseError::EmptyFilter => (
                Code::MissingFilter,
                ": give ?label=, ?robot_id=, ?since= or ?before=, absent never means all",
            ),
            DatabaseError::Unloadable { .. } => (Code::VersionUnloadable, ""),
            error @ DatabaseError::LostExemplar { .. } => {
                tracing::error!(error = chain(&error), "a picture is lost");
                let advice = ": post the same picture again, or delete the exemplar";
                return Self::new(Code::UnreadableExemplar, format!("{}{advice}", chain(&error)));
            }
            error @ (DatabaseError::UnreadableCalibration { .. }
            | DatabaseError::UnreadableWorkcell { .. }
            | DatabaseError::UnreadableCamera { .. }
            | DatabaseError::UnreadableSurvey { .. }) => return Self::internal(&error),
            DatabaseError::InvalidArtifact { source } => {
                let is_newer = matches!(source, ArtifactError::KindUnknown { .. });
                let code = if is_newer { Code::NotYet } else { Code::InvalidArtifact };
                return Self::new(code, chain(&source));
            }
            DatabaseError::Catalogue { source } => return source.into(),
            DatabaseError::Blobs { source } => return source.into(),
            DatabaseError::Compute { source } => return source.into(),
        };
        Self::new(code, format!("{error}{advice}"))
    }
}

impl From<BlobError> for Problem {
    fn from(error: BlobError) -> Self {
        if !matches!(error, BlobError::Unavailable { .. }) {
            return Self::internal(&error);
        }
        tracing::warn!(error = chain(&error), "the blob store is away");
        let text = operator_advice(&error);
        let text = format!(
            "the blob store can't be used: {text}; recognition goes on with what is in memory, try this again soon"
        );
        Self::new(Code::BlobsUnavailable, text)
    }
}

impl From<JobError> for Problem {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Unknown { .. } => Self::new(Code::UnknownJob, error.to_string()),
            JobError::Ended { .. } => Self::new(Code::JobEnded, error.to_string()),
            JobError::NoExemplars { .. } => {
                Self::new(Code::NoExemplars, format!("{error}: post some, then train"))
            }
            JobError::Negative { .. } => Self::field(
                "/options/signature",
                format!(
                    "{error}: train with signature gradient, or delete them with DELETE …/exemplars?negative=true"
                ),
            ),
            JobError::Unfit { source, .. } => Self::new(source.code(), source.to_string()),
            JobError::Database(source) => source.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_answer_that_puts_off_says_when_to_come_back() {
        for code in Code::ALL {
            let response = Problem::new(*code, "x").render(None);
            let says = response.headers().contains_key(header::RETRY_AFTER);
            let puts_off = [503, 429].contains(&response.status().as_u16());
            assert_eq!(says, puts_off, "{}", code.word());
        }
    }
}
