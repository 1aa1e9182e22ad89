//! Problem documents (RFC 9457): one table of codes, their status, title and what to do. `type` is the address of a page
//! of this service that says the same.

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
use crate::jobs::{JobError, sweep_problem};
use crate::store::{BlobError, CatalogueError, outage};
use crate::telemetry::chain;
use landmarkd_core::depth::{EstimateError, EstimatorError, PairError, RegistrationError, SweepError};
use landmarkd_core::imaging::DecodeError;
use landmarkd_core::recognition::objects::SizeMismatch;

macro_rules! codes {
    ($($code:ident $word:literal $status:ident $title:literal $advice:literal,)+) => {
        /// What went wrong, as programs tell it apart.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Code { $(#[doc = $title] $code),+ }

        impl Code {
            /// Every code.
            pub const ALL: &[Code] = &[$(Code::$code),+];

            /// The word in `code`.
            pub const fn word(self) -> &'static str { match self { $(Code::$code => $word),+ } }

            /// The HTTP status it comes with.
            pub const fn status(self) -> StatusCode { match self { $(Code::$code => StatusCode::$status),+ } }

            /// One line on the kind of problem, the same for every case of it.
            pub const fn title(self) -> &'static str { match self { $(Code::$code => $title),+ } }

            /// What to do about it, with code between backquotes.
            pub const fn advice(self) -> &'static str { match self { $(Code::$code => $advice),+ } }
        }
    };
}

codes! {
    MalformedRequest "malformed_request" BAD_REQUEST "The request can't be read"
        "Send what the call takes: the JSON, form, archive or header can't be read.",
    MissingFilter "missing_filter" BAD_REQUEST "The call must say which ones it means"
        "Say which exemplars to delete, with `?label=`, `?robot_id=`, `?since=` or `?before=`: absent never means all.",
    EmptyImage "empty_image" BAD_REQUEST "The request holds no picture"
        "Send a picture; with curl, `--data-binary @file`, or `-F image=@file`.",
    CorruptImage "corrupt_image" BAD_REQUEST "The picture is damaged"
        "Send the picture again: it is cut off or damaged.",
    KeyRequired "key_required" UNAUTHORIZED "The call needs a key in force"
        "Send a key that is in force, as `Authorization: Bearer <key>`.",
    NotAllowed "not_allowed" FORBIDDEN "The key may not do that"
        "Ask for a key of the scope that `detail` names, or one for this database.",
    UnknownRoute "unknown_route" NOT_FOUND "There is nothing at this address"
        "Check the address against `/docs`.",
    UnknownDatabase "unknown_database" NOT_FOUND "There is no such database"
        "Create it with `PUT /v1/databases/{database}`, or check the name.",
    UnknownExemplar "unknown_exemplar" NOT_FOUND "There is no such exemplar"
        "List them with `GET …/exemplars`.",
    UnknownVersion "unknown_version" NOT_FOUND "There is no such version"
        "List them with `GET …/versions`.",
    UnknownAlias "unknown_alias" NOT_FOUND "There is no such alias"
        "List them with `GET …/aliases`.",
    UnknownEigenimage "unknown_eigenimage" NOT_FOUND "There is no such eigenimage"
        "Ask for `mean`, or for a number below the one that `detail` names; only kind `objects` has them.",
    UnknownCalibration "unknown_calibration" NOT_FOUND "There is no such calibration"
        "List them with `GET /v1/calibrations`, or send `optics`.",
    UnknownWorkcell "unknown_workcell" NOT_FOUND "There is no such workcell"
        "Describe it with `PUT /v1/workcells/{name}`, or list them with `GET /v1/workcells`.",
    UnknownJob "unknown_job" NOT_FOUND "There is no such job"
        "List them with `GET /v1/jobs`.",
    UnknownTrack "unknown_track" NOT_FOUND "There is no such track"
        "Begin another with `POST /v1/databases/{database}/tracks`: it is gone ten minutes after its last frame, and with the process.",
    UnknownKey "unknown_key" NOT_FOUND "There is no such key"
        "List them with `GET /v1/keys`.",
    MethodNotAllowed "method_not_allowed" METHOD_NOT_ALLOWED "This address doesn't take this method"
        "Use a method that `Allow` names.",
    NotAcceptable "not_acceptable" NOT_ACCEPTABLE "None of the accepted types can be given"
        "Accept one of the types that `detail` names.",
    BodyTimeout "body_timeout" REQUEST_TIMEOUT "The body came too slowly"
        "Send it again over a better connection, or send less at once.",
    KindConflict "kind_conflict" CONFLICT "The database is of another kind"
        "Take another name, or delete the database of the other kind first; for a workcell, name a database of kind `objects`; for a track, one of kind `landmarks`.",
    NotTrained "not_trained" CONFLICT "The database has no version yet"
        "Post exemplars, train, and wait for the job.",
    NoCurrent "no_current" CONFLICT "The alias current names no version"
        "Point the alias `current` to one of the versions, or ask with `?version=`.",
    VersionInUse "version_in_use" CONFLICT "An alias points to the version"
        "Point the alias to another version first.",
    VersionUnloadable "version_unloadable" CONFLICT "The version can't be loaded"
        "Its artifact is damaged or gone: use another version, train the same again, or restore a backup.",
    CalibrationChanged "calibration_changed" CONFLICT "The calibration was changed meanwhile"
        "Read the calibration again and decide anew; a sweep of the one before must be sent again.",
    CalibrationDeleted "calibration_deleted" CONFLICT "The calibration was deleted meanwhile"
        "Nothing: its calibration was deleted, and the job with it.",
    JobEnded "job_ended" CONFLICT "The job has ended"
        "Nothing: it had ended before it was cancelled.",
    PreconditionFailed "precondition_failed" PRECONDITION_FAILED "It has changed since you looked"
        "Read the alias again and decide anew.",
    BodyTooLarge "body_too_large" PAYLOAD_TOO_LARGE "The body is too large"
        "Send less at once, or raise the limit.",
    UnsupportedMediaType "unsupported_media_type" UNSUPPORTED_MEDIA_TYPE "This type of content isn't taken here"
        "Declare what the call takes: `detail` names it.",
    UnsupportedImageFormat "unsupported_image_format" UNSUPPORTED_MEDIA_TYPE "The picture's format isn't read"
        "Send JPEG, PNG or a portable map.",
    InvalidField "invalid_field" UNPROCESSABLE_ENTITY "A field is missing, unknown or impossible"
        "Mend the fields in `errors`; all that are at fault are named.",
    ImageTooLarge "image_too_large" UNPROCESSABLE_ENTITY "The picture has too many pixels"
        "Send a smaller picture, or raise the limit.",
    ImageTooSmall "image_too_small" UNPROCESSABLE_ENTITY "The picture has too few pixels"
        "Send larger pictures: `detail` says how large.",
    IdenticalImages "identical_images" UNPROCESSABLE_ENTITY "Both pictures are the same"
        "Send the near-focused picture as `near` and the far-focused one as `far`: one of them came twice.",
    NeedsCalibration "needs_calibration" UNPROCESSABLE_ENTITY "The method needs a calibration with a sweep"
        "Calibrate with a sweep by this method, or take another method.",
    RegistrationRefused "registration_refused" UNPROCESSABLE_ENTITY "The pictures can't be registered"
        "Show a flat target full of fine irregular texture, within the working range, and keep the rig still between both pictures.",
    TooFewPlanes "too_few_planes" UNPROCESSABLE_ENTITY "The sweep has too few planes"
        "Send planes at 5 known depths at least, better 9 to 21.",
    SweepRefused "sweep_refused" UNPROCESSABLE_ENTITY "The planes make no sweep"
        "Mend the planes' depths as `detail` says: each once, and reaching past both focus distances.",
    TooLittleTexture "too_little_texture" UNPROCESSABLE_ENTITY "A plane of the sweep has too little texture"
        "Show a plane with more texture, or a projected pattern, at the depth that `detail` names.",
    NotMonotone "not_monotone" UNPROCESSABLE_ENTITY "What the sweep measures is not in the order of its depths"
        "Look after the plane that `detail` names: its depth is wrong, or its pictures are of another one.",
    UnreadablePicture "unreadable_picture" UNPROCESSABLE_ENTITY "A picture of the sweep can't be read"
        "Sweep again: a picture of it is gone or can't be decoded.",
    NoExemplars "no_exemplars" UNPROCESSABLE_ENTITY "There is nothing to train from"
        "Post exemplars, then train.",
    TooFewPoints "too_few_points" UNPROCESSABLE_ENTITY "The exemplars have too few interest points"
        "The exemplars are flat, dark or out of focus: post others.",
    TooFewExemplars "too_few_exemplars" UNPROCESSABLE_ENTITY "There are too few exemplars"
        "Post at least two pictures that differ, better ten views or more of each object, then train.",
    TrainingTooLarge "training_too_large" UNPROCESSABLE_ENTITY "The exemplars are more than a training can hold"
        "The exemplars hold more samples than a training takes into memory: give a smaller `width_px` and `height_px`, or more `smoothing`.",
    AllEqual "all_equal" UNPROCESSABLE_ENTITY "All exemplars are the same picture"
        "The exemplars are all one picture: post others, then train.",
    ImageSizeMismatch "image_size_mismatch" UNPROCESSABLE_ENTITY "The picture is not of the size it must have"
        "Send pictures of the size that `detail` names: of a pair both of one size, for a calibration those of its own, with `pair_view=overview` those of the overview; or train with `resize: \"fit\"`.",
    UnreadableExemplar "unreadable_exemplar" UNPROCESSABLE_ENTITY "An exemplar can't be read"
        "Post the same picture again, or delete the exemplar that `detail` names; then train again.",
    InvalidArtifact "invalid_artifact" UNPROCESSABLE_ENTITY "The artifact file can't be used"
        "Fetch the file again: it is no artifact, or was damaged or changed.",
    NoRegion "no_region" UNPROCESSABLE_ENTITY "The picture has no such region"
        "Bring a part into view, or change the segmentation; for `?region=`, take one of the ids that `detail` names.",
    NotYet "not_yet" UNPROCESSABLE_ENTITY "This release can't do that yet"
        "Do without: this release can't do it.",
    RateLimited "rate_limited" TOO_MANY_REQUESTS "The key was used too often"
        "Come back after `Retry-After`, and ask less often: the key is held to a rate.",
    TooManyTracks "too_many_tracks" TOO_MANY_REQUESTS "There is no room for another track"
        "Delete the tracks that are done with, or come back after `Retry-After`.",
    Overloaded "overloaded" SERVICE_UNAVAILABLE "There is more to do than can be done"
        "Come back after `Retry-After`; if it lasts, add cores or ask less.",
    DeadlineExceeded "deadline_exceeded" SERVICE_UNAVAILABLE "The answer took too long"
        "Try again; if it lasts, send less at once or raise the limit.",
    CatalogueUnavailable "catalogue_unavailable" SERVICE_UNAVAILABLE "The catalogue is away"
        "Do as `detail` says: make room, look after the disk's rights or the connection. Recognition goes on from memory.",
    BlobsUnavailable "blobs_unavailable" SERVICE_UNAVAILABLE "The blob store is away"
        "No new version loads and no picture is taken meanwhile, recognition goes on: look after the folder's disk or the bucket, as `detail` says.",
    AttemptsExhausted "attempts_exhausted" INTERNAL_SERVER_ERROR "The job's workers died, time after time"
        "The job's worker died five times, perhaps for lack of memory: look into the log, then train with fewer or smaller exemplars.",
    DatabaseDeleted "database_deleted" CONFLICT "The database was deleted meanwhile"
        "Nothing: its database was deleted, and the job with it.",
    Internal "internal" INTERNAL_SERVER_ERROR "Something is wrong in the service"
        "Look into the log under the request's id, and tell the developers.",
}

impl Code {
    /// The code of that word: problems of jobs are kept by it.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.word() == word)
    }

    /// Whether it says when to come back.
    pub fn says_when(self) -> bool {
        [StatusCode::SERVICE_UNAVAILABLE, StatusCode::TOO_MANY_REQUESTS].contains(&self.status())
    }

    /// The advice in parts, each with whether it is code.
    pub fn advice_spans(self) -> impl Iterator<Item = (bool, &'static str)> {
        self.advice().split('`').enumerate().map(|(n, text)| (n % 2 == 1, text))
    }
}

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

/// The document of a problem that is told inside another answer, which has the request's id itself.
impl From<Problem> for ProblemBody {
    fn from(problem: Problem) -> Self {
        let code = problem.code;
        Self {
            kind: format!("/problems/{}", code.word()),
            title: code.title(),
            status: code.status().as_u16(),
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
        let retry_after_s = code.says_when().then_some(1);
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

    /// The problem kept with a failed job.
    pub fn of_job(document: &str) -> Self {
        let kept: serde_json::Value = serde_json::from_str(document).unwrap_or_default();
        let code = kept["code"].as_str().and_then(Code::of_word).unwrap_or(Code::Internal);
        Self::new(code, kept["detail"].as_str().unwrap_or("the job failed and left no reason"))
    }

    /// A failure that is ours: logged with its causes, told without them.
    fn internal(error: &dyn std::error::Error) -> Self {
        tracing::error!(error = chain(error), "internal error");
        Self::new(
            Code::Internal,
            "something went wrong in the service; the log has it under this request's id",
        )
    }

    /// The document as a response. The rim calls this: it knows the request's id.
    pub fn render(self, request_id: Option<String>) -> Response {
        let (status, retry_after) = (self.code.status(), self.retry_after_s);
        let mut response = (status, Json(ProblemBody { request_id, ..self.into() })).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        if let Some(seconds) = retry_after {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(seconds));
        }
        response
    }
}

/// Leaves the document in the response's extensions; the rim renders it with the request's id.
impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = self.code.status().into_response();
        response.extensions_mut().insert(self);
        response
    }
}

impl From<DecodeError> for Problem {
    fn from(error: DecodeError) -> Self {
        let code = match &error {
            DecodeError::Empty => Code::EmptyImage,
            DecodeError::UnknownFormat => Code::UnsupportedImageFormat,
            DecodeError::TooLarge { .. } | DecodeError::TooMuchMemory { .. } => Code::ImageTooLarge,
            DecodeError::Corrupt { .. } => Code::CorruptImage,
        };
        Self::new(code, chain(&error))
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
        let (code, advice) = match error {
            PairError::SizeMismatch { .. } => (Code::ImageSizeMismatch, "send two pictures of one size"),
            PairError::Identical => {
                (Code::IdenticalImages, "send the near-focused one as near and the far-focused one as far")
            }
            PairError::TooSmall { .. } => (Code::ImageTooSmall, "send larger ones"),
        };
        Self::new(code, format!("{error}: {advice}"))
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
        let code = Code::of_word(sweep_problem(&error)).unwrap_or(Code::Internal);
        Self::new(code, chain(&error))
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
                let text = outage(&error);
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
        let text = error.to_string();
        let problem = |code, advice: &str| Self::new(code, format!("{text}{advice}"));
        match error {
            DatabaseError::UnknownDatabase { .. } => {
                problem(Code::UnknownDatabase, "; create it with PUT /v1/databases/{database}")
            }
            DatabaseError::UnknownExemplar { .. } => problem(Code::UnknownExemplar, ""),
            error @ DatabaseError::LostExemplar { .. } => {
                tracing::error!(error = chain(&error), "a picture is lost");
                let advice = ": post the same picture again, or delete the exemplar";
                Self::new(Code::UnreadableExemplar, format!("{}{advice}", chain(&error)))
            }
            DatabaseError::UnknownVersion { .. } => problem(Code::UnknownVersion, ""),
            DatabaseError::UnknownAlias { .. } => problem(Code::UnknownAlias, ""),
            DatabaseError::UnknownCalibration { .. } => {
                problem(Code::UnknownCalibration, "; create it with PUT /v1/calibrations/{name}")
            }
            DatabaseError::CalibrationChanged { .. } => {
                problem(Code::CalibrationChanged, ": read it again and decide anew")
            }
            error @ DatabaseError::UnreadableCalibration { .. } => Self::internal(&error),
            DatabaseError::UnknownWorkcell { .. } => {
                problem(Code::UnknownWorkcell, "; create it with PUT /v1/workcells/{name}")
            }
            error @ DatabaseError::UnreadableWorkcell { .. } => Self::internal(&error),
            DatabaseError::WrongKind { .. } => {
                problem(Code::KindConflict, ": PUT /v1/workcells/{name} with a database of that kind")
            }
            DatabaseError::KindConflict { .. } => {
                problem(Code::KindConflict, ": delete it first, or take another name")
            }
            DatabaseError::NotTrained { .. } => problem(
                Code::NotTrained,
                ": post exemplars, then POST /v1/databases/{database}/trainings and wait for the job",
            ),
            DatabaseError::NoCurrent { .. } => problem(
                Code::NoCurrent,
                ": PUT /v1/databases/{database}/aliases/current with one of them, or ask with ?version=",
            ),
            DatabaseError::VersionInUse { .. } => {
                problem(Code::VersionInUse, ": point the alias elsewhere first")
            }
            DatabaseError::PreconditionFailed => {
                problem(Code::PreconditionFailed, ": read it again and decide anew")
            }
            DatabaseError::EmptyFilter => problem(
                Code::MissingFilter,
                ": give ?label=, ?robot_id=, ?since= or ?before=, absent never means all",
            ),
            DatabaseError::Unloadable { .. } => problem(Code::VersionUnloadable, ""),
            DatabaseError::InvalidArtifact { source } => {
                let code = match source {
                    ArtifactError::KindUnknown { .. } => Code::NotYet,
                    _ => Code::InvalidArtifact,
                };
                Self::new(code, chain(&source))
            }
            DatabaseError::Catalogue { source } => source.into(),
            DatabaseError::Blobs { source: source @ BlobError::Unavailable { .. } } => {
                tracing::warn!(error = chain(&source), "the blob store is away");
                let text = outage(&source);
                Self::new(
                    Code::BlobsUnavailable,
                    format!("the blob store can't be used: {text}; recognition goes on, try this again soon"),
                )
            }
            DatabaseError::Blobs { source } => Self::internal(&source),
            DatabaseError::Compute { source } => source.into(),
        }
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
            JobError::Unfit { source, .. } => {
                Self::new(Code::of_word(source.code()).unwrap_or(Code::Internal), source.to_string())
            }
            JobError::Database(source) => source.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_word_of_its_own_and_is_found_by_it() {
        for code in Code::ALL {
            assert_eq!(Code::of_word(code.word()), Some(*code));
            assert!(code.status().is_client_error() || code.status().is_server_error());
        }
    }

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
