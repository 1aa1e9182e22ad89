//! What a call on a database can fail with.

use crate::compute::ComputeError;
use crate::database::artifact::ArtifactError;
use crate::database::calibrations::UnreadableCalibration;
use crate::database::workcells::UnreadableWorkcell;
use crate::store::{BlobError, CatalogueError, InvalidBlobName};

/// Why a call on a database failed. HTTP gives each its code and status.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    /// No database has that name.
    #[error("there is no database {database}")]
    UnknownDatabase {
        /// The name that was asked for.
        database: String,
    },
    /// The database has no such exemplar.
    #[error("database {database} has no exemplar {exemplar}")]
    UnknownExemplar {
        /// The database's name.
        database: String,
        /// The id that was asked for.
        exemplar: String,
    },
    /// The exemplar is known and its picture is damaged or gone.
    #[error("the picture of exemplar {exemplar} of database {database} is lost")]
    LostExemplar {
        /// The database's name.
        database: String,
        /// The exemplar's id.
        exemplar: String,
        /// What is wrong with the blob.
        #[source]
        source: BlobError,
    },
    /// The database has no version of that number.
    #[error("database {database} has no version {version}")]
    UnknownVersion {
        /// The database's name.
        database: String,
        /// The number that was asked for.
        version: i64,
    },
    /// The database has no alias of that name.
    #[error("database {database} has no alias {alias}")]
    UnknownAlias {
        /// The database's name.
        database: String,
        /// The name that was asked for.
        alias: String,
    },
    /// No calibration has that name.
    #[error("there is no calibration {calibration}")]
    UnknownCalibration {
        /// The name that was asked for.
        calibration: String,
    },
    /// The calibration isn't at the revision that was read.
    #[error("calibration {calibration} was changed meanwhile")]
    CalibrationChanged {
        /// The calibration's name.
        calibration: String,
    },
    /// The calibration's document isn't one of this release.
    #[error("calibration {calibration} can't be read back")]
    UnreadableCalibration {
        /// The calibration's name.
        calibration: String,
        /// What is wrong with the document.
        #[source]
        source: UnreadableCalibration,
    },
    /// No workcell has that name.
    #[error("there is no workcell {workcell}")]
    UnknownWorkcell {
        /// The name that was asked for.
        workcell: String,
    },
    /// The workcell's document isn't one of this release.
    #[error("workcell {workcell} can't be read back")]
    UnreadableWorkcell {
        /// The workcell's name.
        workcell: String,
        /// What is wrong with the document.
        #[source]
        source: UnreadableWorkcell,
    },
    /// No camera has that name.
    #[error("there is no camera {camera}")]
    UnknownCamera {
        /// The name that was asked for.
        camera: String,
    },
    /// The camera's document isn't one of this release.
    #[error("camera {camera} can't be read back")]
    UnreadableCamera {
        /// The camera's name.
        camera: String,
        /// What is wrong with the document.
        #[source]
        source: serde_json::Error,
    },
    /// The survey of an exemplar isn't one of this release.
    #[error("the survey of exemplar {exemplar} can't be read back")]
    UnreadableSurvey {
        /// The exemplar's id.
        exemplar: String,
        /// What is wrong with the document.
        #[source]
        source: serde_json::Error,
    },
    /// The call needs a database of another kind.
    #[error("database {database} is of kind {kind}, not of kind {wanted}")]
    WrongKind {
        /// The database's name.
        database: String,
        /// Its kind.
        kind: String,
        /// The kind that the call needs.
        wanted: &'static str,
    },
    /// What is to be put into the database is of another kind.
    #[error("database {database} is of kind {kind}")]
    KindConflict {
        /// The database's name.
        database: String,
        /// Its kind.
        kind: String,
    },
    /// The database has no version that could answer.
    #[error("database {database} has no version yet")]
    NotTrained {
        /// The database's name.
        database: String,
    },
    /// The database has versions and no alias `current`.
    #[error("database {database} has versions, but its alias current names none")]
    NoCurrent {
        /// The database's name.
        database: String,
    },
    /// An alias points to the version that is to be deleted.
    #[error("an alias points to version {version} of database {database}")]
    VersionInUse {
        /// The database's name.
        database: String,
        /// The version's number.
        version: i64,
    },
    /// The alias was moved meanwhile.
    #[error("the alias is not at the revision that was expected")]
    PreconditionFailed,
    /// The filter would delete everything.
    #[error("the filter names neither a label nor a robot")]
    EmptyFilter,
    /// The version's artifact is damaged, gone, or of another release.
    #[error("version {version} of database {database} can't be loaded: {reason}")]
    Unloadable {
        /// The database's name.
        database: String,
        /// The version's number.
        version: i64,
        /// What is wrong with the artifact, and what to do.
        reason: String,
    },
    /// The artifact to import isn't one that this release can use.
    #[error("the artifact can't be used")]
    InvalidArtifact {
        /// What is wrong with the file.
        #[source]
        source: ArtifactError,
    },
    /// The catalogue is away, or refused the call.
    #[error("the catalogue failed")]
    Catalogue {
        /// The catalogue's error.
        #[source]
        source: CatalogueError,
    },
    /// The blob store is away, or refused the call.
    #[error("the blob store failed")]
    Blobs {
        /// The blob store's error.
        #[from]
        source: BlobError,
    },
    /// The queue of computations is full, or the service ends.
    #[error("no computing thread took the work")]
    Compute {
        /// The error of the computing pool.
        #[from]
        source: ComputeError,
    },
}

impl From<InvalidBlobName> for DatabaseError {
    fn from(source: InvalidBlobName) -> Self {
        BlobError::from(source).into()
    }
}

impl From<CatalogueError> for DatabaseError {
    fn from(source: CatalogueError) -> Self {
        match source {
            CatalogueError::PreconditionFailed => Self::PreconditionFailed,
            CatalogueError::EmptyFilter => Self::EmptyFilter,
            source => Self::Catalogue { source },
        }
    }
}
