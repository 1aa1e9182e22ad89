//! What a call on a database can fail with.

use crate::compute::ComputeError;
use crate::database::artifact::ArtifactError;
use crate::database::calibrations::UnreadableCalibration;
use crate::database::workcells::UnreadableWorkcell;
use crate::store::{BlobError, CatalogueError};

/// Why a call on a database failed. The HTTP rim gives each its code and status.
#[derive(Debug, thiserror::Error)]
pub enum DatabaseError {
    #[error("there is no database {database}")]
    UnknownDatabase { database: String },
    #[error("database {database} has no exemplar {exemplar}")]
    UnknownExemplar { database: String, exemplar: String },
    #[error("the picture of exemplar {exemplar} of database {database} is lost")]
    LostExemplar {
        database: String,
        exemplar: String,
        #[source]
        source: BlobError,
    },
    #[error("database {database} has no version {version}")]
    UnknownVersion { database: String, version: i64 },
    #[error("database {database} has no alias {alias}")]
    UnknownAlias { database: String, alias: String },
    #[error("there is no calibration {calibration}")]
    UnknownCalibration { calibration: String },
    #[error("calibration {calibration} was changed meanwhile")]
    CalibrationChanged { calibration: String },
    #[error("calibration {calibration} can't be read back")]
    UnreadableCalibration {
        calibration: String,
        #[source]
        source: UnreadableCalibration,
    },
    #[error("there is no workcell {workcell}")]
    UnknownWorkcell { workcell: String },
    #[error("workcell {workcell} can't be read back")]
    UnreadableWorkcell {
        workcell: String,
        #[source]
        source: UnreadableWorkcell,
    },
    #[error("database {database} is of kind {kind}, not of kind {wanted}")]
    WrongKind { database: String, kind: String, wanted: &'static str },
    #[error("database {database} is of kind {kind}")]
    KindConflict { database: String, kind: String },
    #[error("database {database} has no version yet")]
    NotTrained { database: String },
    #[error("database {database} has versions, but its alias current names none")]
    NoCurrent { database: String },
    #[error("an alias points to version {version} of database {database}")]
    VersionInUse { database: String, version: i64 },
    #[error("the alias is not at the revision that was expected")]
    PreconditionFailed,
    #[error("the filter names neither a label nor a robot")]
    EmptyFilter,
    #[error("version {version} of database {database} can't be loaded: {reason}")]
    Unloadable { database: String, version: i64, reason: String },
    #[error("the artifact can't be used")]
    InvalidArtifact {
        #[source]
        source: ArtifactError,
    },
    #[error("the catalogue failed")]
    Catalogue {
        #[source]
        source: CatalogueError,
    },
    #[error("the blob store failed")]
    Blobs {
        #[from]
        source: BlobError,
    },
    #[error("no computing thread took the work")]
    Compute {
        #[from]
        source: ComputeError,
    },
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
