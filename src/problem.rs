//! The table of problem codes: word, HTTP status, title and advice of each. Answers and failed jobs use the same one.

use landmarkd_core::depth::{PairError, SweepError};
use landmarkd_core::imaging::DecodeError;
use serde::{Deserialize, Serialize};

macro_rules! codes {
    ($($code:ident $word:literal $status:literal $title:literal $advice:literal,)+) => {
        /// The kind of a problem, for programs; in JSON it is its word.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Code { $(#[doc = $title] #[serde(rename = $word)] $code),+ }

        impl Code {
            /// Every code.
            pub const ALL: &[Code] = &[$(Code::$code),+];

            /// Its word, as in the member `code` of a problem document.
            pub const fn word(self) -> &'static str { match self { $(Code::$code => $word),+ } }

            /// Its HTTP status.
            pub const fn status(self) -> u16 { match self { $(Code::$code => $status),+ } }

            /// One line on the kind of problem, the same for every case of it.
            pub const fn title(self) -> &'static str { match self { $(Code::$code => $title),+ } }

            /// What to do about it, with code between backquotes.
            pub const fn advice(self) -> &'static str { match self { $(Code::$code => $advice),+ } }
        }
    };
}

codes! {
    MalformedRequest "malformed_request" 400 "The request can't be read"
        "Send what the call takes: the JSON, form, archive or header can't be read.",
    MissingFilter "missing_filter" 400 "The call must say which ones it means"
        "Say which exemplars to delete, with `?label=`, `?negative=`, `?robot_id=`, `?since=` or `?before=`: absent never means all.",
    EmptyImage "empty_image" 400 "The request holds no picture"
        "Send a picture; with curl, `--data-binary @file`, or `-F image=@file`.",
    CorruptImage "corrupt_image" 400 "The picture is damaged"
        "Send the picture again: it is cut off or damaged.",
    KeyRequired "key_required" 401 "The call needs a key in force"
        "Send a key that is in force, as `Authorization: Bearer <key>`.",
    NotAllowed "not_allowed" 403 "The key may not do that"
        "Ask for a key of the scope that `detail` names, or one for this database.",
    UnknownRoute "unknown_route" 404 "There is nothing at this address"
        "Check the address against `/docs`.",
    UnknownDatabase "unknown_database" 404 "There is no such database"
        "Create it with `PUT /v1/databases/{database}`, or check the name.",
    UnknownExemplar "unknown_exemplar" 404 "There is no such exemplar"
        "List them with `GET …/exemplars`.",
    UnknownVersion "unknown_version" 404 "There is no such version"
        "List them with `GET …/versions`.",
    UnknownAlias "unknown_alias" 404 "There is no such alias"
        "List them with `GET …/aliases`.",
    UnknownEigenimage "unknown_eigenimage" 404 "There is no such eigenimage"
        "Ask for `mean`, or for a number below the one that `detail` names; only kind `objects` has them.",
    UnknownCalibration "unknown_calibration" 404 "There is no such calibration"
        "List them with `GET /v1/calibrations`, or send `optics`.",
    UnknownWorkcell "unknown_workcell" 404 "There is no such workcell"
        "Describe it with `PUT /v1/workcells/{name}`, or list them with `GET /v1/workcells`.",
    UnknownCamera "unknown_camera" 404 "There is no such camera"
        "Keep it with `PUT /v1/cameras/{name}`, list them with `GET /v1/cameras`, or send its intrinsics.",
    UnknownJob "unknown_job" 404 "There is no such job"
        "List them with `GET /v1/jobs`.",
    UnknownTrack "unknown_track" 404 "There is no such track"
        "Begin another with `POST /v1/databases/{database}/tracks`: it is gone ten minutes after its last frame, and with the process.",
    UnknownKey "unknown_key" 404 "There is no such key"
        "List them with `GET /v1/keys`.",
    MethodNotAllowed "method_not_allowed" 405 "This address doesn't take this method"
        "Use a method that `Allow` names.",
    NotAcceptable "not_acceptable" 406 "None of the accepted types can be given"
        "Accept one of the types that `detail` names.",
    BodyTimeout "body_timeout" 408 "The body came too slowly"
        "Send it again over a better connection, or send less at once.",
    KindConflict "kind_conflict" 409 "The database is of another kind"
        "Take another name, or delete the database of the other kind first; for a workcell, name a database of kind `objects`; for a track, one of kind `landmarks`.",
    NotTrained "not_trained" 409 "The database has no version yet"
        "Post exemplars, train, and wait for the job.",
    NoCurrent "no_current" 409 "The alias current names no version"
        "Point the alias `current` to one of the versions, or ask with `?version=`.",
    VersionInUse "version_in_use" 409 "An alias points to the version"
        "Point the alias to another version first.",
    VersionUnloadable "version_unloadable" 409 "The version can't be loaded"
        "Its artifact is damaged or gone: use another version, train the same again, or restore a backup.",
    CalibrationChanged "calibration_changed" 409 "The calibration was changed meanwhile"
        "Read the calibration again and decide anew; a sweep of the one before must be sent again.",
    CalibrationDeleted "calibration_deleted" 409 "The calibration was deleted meanwhile"
        "Nothing: its calibration was deleted, and the job with it.",
    JobEnded "job_ended" 409 "The job has ended"
        "Nothing: it had ended before it was cancelled.",
    PreconditionFailed "precondition_failed" 412 "It has changed since you looked"
        "Read the alias again and decide anew.",
    BodyTooLarge "body_too_large" 413 "The body is too large"
        "Send less at once, or raise the limit.",
    UnsupportedMediaType "unsupported_media_type" 415 "This type of content isn't taken here"
        "Declare what the call takes: `detail` names it.",
    UnsupportedImageFormat "unsupported_image_format" 415 "The picture's format isn't read"
        "Send JPEG, PNG or a portable map.",
    InvalidField "invalid_field" 422 "A field is missing, unknown or impossible"
        "Mend the fields in `errors`; all that are at fault are named.",
    ImageTooLarge "image_too_large" 422 "The picture has too many pixels"
        "Send a smaller picture, or raise the limit.",
    ImageTooSmall "image_too_small" 422 "The picture has too few pixels"
        "Send larger pictures: `detail` says how large.",
    IdenticalImages "identical_images" 422 "Both pictures are the same"
        "Send the near-focused picture as `near` and the far-focused one as `far`: one of them came twice.",
    NeedsCalibration "needs_calibration" 422 "The method needs a calibration with a sweep"
        "Calibrate with a sweep by this method, or take another method.",
    RegistrationRefused "registration_refused" 422 "The pictures can't be registered"
        "Show a flat target full of fine irregular texture, within the working range, and keep the rig still between both pictures.",
    TooFewPlanes "too_few_planes" 422 "The sweep has too few planes"
        "Send planes at 5 known depths at least, better 9 to 21.",
    SweepRefused "sweep_refused" 422 "The planes make no sweep"
        "Mend the planes' depths as `detail` says: each once, and reaching past both focus distances.",
    TooLittleTexture "too_little_texture" 422 "A plane of the sweep has too little texture"
        "Show a plane with more texture, or a projected pattern, at the depth that `detail` names.",
    NotMonotone "not_monotone" 422 "What the sweep measures is not in the order of its depths"
        "Look after the plane that `detail` names: its depth is wrong, or its pictures are of another one.",
    ScaleUnclear "scale_unclear" 422 "The pictures don't say how wide the aperture is"
        "State the aperture, or photograph a scene full of fine irregular texture at several distances.",
    UnreadablePicture "unreadable_picture" 422 "A picture of the sweep can't be read"
        "Sweep again: a picture of it is gone or can't be decoded.",
    NoExemplars "no_exemplars" 422 "There is nothing to train from"
        "Post exemplars, then train.",
    TooFewPoints "too_few_points" 422 "The exemplars have too few interest points"
        "The exemplars are flat, dark or out of focus: post others.",
    TooFewExemplars "too_few_exemplars" 422 "There are too few exemplars"
        "Post at least two pictures that differ, better ten views or more of each object, then train.",
    TrainingTooLarge "training_too_large" 422 "The exemplars are more than a training can hold"
        "The exemplars hold more samples than a training takes into memory: give a smaller `width_px` and `height_px`, or more `smoothing`.",
    AllEqual "all_equal" 422 "All exemplars are the same picture"
        "The exemplars are all one picture: post others, then train.",
    ImageSizeMismatch "image_size_mismatch" 422 "The picture is not of the size it must have"
        "Send pictures of the size that `detail` names: of a pair both of one size, for a calibration those of its own, with `pair_view=overview` those of the overview; or train with `resize: \"fit\"`.",
    UnreadableExemplar "unreadable_exemplar" 422 "An exemplar can't be read"
        "Post the same picture again, or delete the exemplar that `detail` names; then train again.",
    InvalidArtifact "invalid_artifact" 422 "The artifact file can't be used"
        "Fetch the file again: it is no artifact, or was damaged or changed.",
    NoRegion "no_region" 422 "The picture has no such region"
        "Bring a part into view, or change the segmentation; for `?region=`, take one of the ids that `detail` names.",
    NotYet "not_yet" 422 "This release can't do that yet"
        "Do without: this release can't do it.",
    RateLimited "rate_limited" 429 "The key was used too often"
        "Come back after `Retry-After`, and ask less often: the key is held to a rate.",
    TooManyTracks "too_many_tracks" 429 "There is no room for another track"
        "Delete the tracks that are done with, or come back after `Retry-After`.",
    Overloaded "overloaded" 503 "There is more to do than can be done"
        "Come back after `Retry-After`; if it lasts, add cores or ask less.",
    DeadlineExceeded "deadline_exceeded" 503 "The answer took too long"
        "Try again; if it lasts, send less at once or raise the limit.",
    CatalogueUnavailable "catalogue_unavailable" 503 "The catalogue is away"
        "Do as `detail` says: make room, look after the disk's rights or the connection. Recognition goes on from memory.",
    BlobsUnavailable "blobs_unavailable" 503 "The blob store is away"
        "No new version loads and no picture is taken meanwhile, recognition goes on: look after the folder's disk or the bucket, as `detail` says.",
    AttemptsExhausted "attempts_exhausted" 500 "The job's workers died, time after time"
        "The job's worker died five times, perhaps for lack of memory: look into the log, then train with fewer or smaller exemplars.",
    DatabaseDeleted "database_deleted" 409 "The database was deleted meanwhile"
        "Nothing: its database was deleted, and the job with it.",
    Internal "internal" 500 "Something is wrong in the service"
        "Look into the log under the request's id, and tell the developers.",
}

impl Code {
    /// The code of that word, if there is one.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.word() == word)
    }

    /// Whether an answer with it has the header `Retry-After`.
    pub const fn has_retry_after(self) -> bool {
        matches!(self.status(), 429 | 503)
    }

    /// The advice in parts, each with whether it is code.
    pub fn advice_spans(self) -> impl Iterator<Item = (bool, &'static str)> {
        self.advice().split('`').enumerate().map(|(n, text)| (n % 2 == 1, text))
    }
}

impl From<&DecodeError> for Code {
    fn from(error: &DecodeError) -> Self {
        match error {
            DecodeError::Empty => Self::EmptyImage,
            DecodeError::UnknownFormat => Self::UnsupportedImageFormat,
            DecodeError::TooLarge { .. } | DecodeError::TooMuchMemory { .. } => Self::ImageTooLarge,
            DecodeError::Corrupt { .. } => Self::CorruptImage,
        }
    }
}

impl From<&PairError> for Code {
    fn from(error: &PairError) -> Self {
        match error {
            PairError::SizeMismatch { .. } => Self::ImageSizeMismatch,
            PairError::Identical => Self::IdenticalImages,
            PairError::TooSmall { .. } => Self::ImageTooSmall,
        }
    }
}

impl From<&SweepError> for Code {
    fn from(error: &SweepError) -> Self {
        match error {
            SweepError::TooFewPlanes { .. } => Self::TooFewPlanes,
            SweepError::TooLittleTexture { .. } => Self::TooLittleTexture,
            SweepError::NotMonotone { .. } => Self::NotMonotone,
            SweepError::Estimate(_) => Self::ImageSizeMismatch,
            _ => Self::SweepRefused,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_word_of_its_own_and_is_found_by_it() {
        for code in Code::ALL {
            assert_eq!(Code::from_word(code.word()), Some(*code));
            assert_eq!(serde_json::to_value(code).unwrap(), code.word());
            assert!((400..600).contains(&code.status()));
        }
    }
}
