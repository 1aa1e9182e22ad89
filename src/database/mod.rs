//! Databases: names, exemplars, options, versions, aliases; the registry of loaded versions; the artifact format.
//! Calibrations of depth rigs, cameras and workcells stand beside them.
//!
//! Callers use [`Databases`]. It writes in the order of the protocol: the blob, then its row, then the alias. Plain
//! records (`ExemplarRow`, `VersionRow`, …) are the catalogue's rows themselves. Options, reports and the parts of a
//! calibration have one document each, which is kept, written into artifacts and sent over HTTP.
//!
//! Architecture invariant: nothing here knows HTTP, and nothing but `store` knows SQL or files.

pub mod artifact;
pub(crate) mod calibrations;
mod cameras;
pub(crate) mod description;
mod error;
mod exemplar;
mod fleet;
pub mod kept_exemplars;
mod model;
mod name;
pub mod options;
pub mod registry;
mod report;
pub(crate) mod survey;
mod verification;
mod version;
pub(crate) mod words;
pub(crate) mod workcells;

use std::sync::Arc;
use std::time::Duration;

pub use calibrations::{DepthMethodWord, PictureBlob, Rig, UnreadableCalibration};
pub use cameras::KeptCamera;
pub use error::DatabaseError;
pub use exemplar::{FrameHeader, NewExemplar};
pub use fleet::Process;
pub use kept_exemplars::ExemplarCache;
pub use model::{ALGORITHM_REVISION, Counts, Model};
pub use name::{MAX_NAME_CHARACTERS, Name, NotAName};
pub use options::{Kind, Options, OptionsDocument};
pub use registry::{LoadedVersion, Registry, Residency};
pub(crate) use report::{
    DescriptionsReport, GrownReport, LandmarkReport, ObjectsReport, ReliabilityReport, Report,
    TrainingTimings, VerdictReport,
};
pub use survey::Survey;
pub use verification::{Verification, verify};
pub use version::{grown_digest, inputs_digest};
pub use workcells::{KeptWorkcell, UnreadableWorkcell, WorkcellSetup};

pub use crate::store::{
    AliasExpectation, AliasRow, DatabaseCounts, DatabaseRow, ExemplarFilter, ExemplarRow, JobEventRow,
    JobFilter, JobRow, JobState, Progress, VersionRow,
};

use crate::compute::Compute;
use crate::store::{Actor, Blobs, Catalogue, Descriptions, OrphanCollection};

/// The alias that answers when a call names none.
pub const CURRENT: &str = "current";

/// The databases of one catalogue and one blob store, and those of their versions that are in memory.
#[derive(Clone)]
pub struct Databases {
    pub(crate) catalogue: Arc<Catalogue>,
    pub(crate) blobs: Blobs,
    pub(crate) descriptions: Descriptions,
    registry: Arc<Registry>,
}

impl Databases {
    /// Open over a catalogue and a blob store; `memory_limit_bytes` bounds the versions that no alias of the
    /// databases in `holds` names.
    pub fn new(
        catalogue: Arc<Catalogue>,
        blobs: Blobs,
        descriptions: Descriptions,
        compute: Compute,
        memory_limit_bytes: u64,
        holds: Option<glob::Pattern>,
        residency: Residency,
    ) -> Self {
        let (rows, artifacts) = (Arc::clone(&catalogue), blobs.clone());
        let registry =
            Arc::new(Registry::new(rows, artifacts, compute, memory_limit_bytes, holds, residency));
        Self { catalogue, blobs, descriptions, registry }
    }

    /// The versions in memory.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Asks the catalogue for an answer.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn ping_catalogue(&self) -> Result<(), DatabaseError> {
        Ok(self.catalogue.ping().await?)
    }

    /// Asks the blob store for an answer.
    ///
    /// # Errors
    /// The blob store is unavailable.
    pub async fn ping_blobs(&self) -> Result<(), DatabaseError> {
        Ok(self.blobs.ping().await?)
    }

    /// Removes blobs older than `age` that neither an exemplar nor a version names.
    ///
    /// # Errors
    /// A store is unavailable.
    pub async fn collect_orphans(&self, age: Duration) -> Result<OrphanCollection, DatabaseError> {
        Ok(crate::store::collect_orphans(&self.blobs, age, &self.catalogue).await?)
    }

    /// Removes the descriptions kept on this machine of pictures that no exemplar has any more, and counts them.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn collect_descriptions(&self) -> Result<u64, DatabaseError> {
        Ok(self.descriptions.remove_unreferenced(&self.catalogue).await?)
    }

    /// Create a database, or find the one of that name; `true` when it is new. Options given for a database that
    /// is there replace the kept ones, and count from the next training on.
    ///
    /// # Errors
    /// [`DatabaseError::KindConflict`] when the database is of another kind.
    pub async fn create(
        &self,
        name: &Name,
        kind: Kind,
        options: Option<&Options>,
        by: &Actor,
    ) -> Result<(DatabaseRow, bool), DatabaseError> {
        let document = options.unwrap_or(&Options::default_of(kind)).to_document();
        let (row, created) =
            self.catalogue.create_database(name.as_str(), kind.as_str(), &document, by).await?;
        if row.kind != kind.as_str() {
            return Err(DatabaseError::KindConflict { database: name.to_string(), kind: row.kind });
        }
        if options.is_some() && row.options != document {
            let row = self.catalogue.set_database_options(name.as_str(), &document, by).await?;
            return Ok((row, false));
        }
        Ok((row, created))
    }

    /// The database of that name.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownDatabase`].
    pub async fn get(&self, name: &Name) -> Result<DatabaseRow, DatabaseError> {
        let row = self.catalogue.database(name.as_str()).await?;
        row.ok_or_else(|| DatabaseError::UnknownDatabase { database: name.to_string() })
    }

    /// Databases by name, after `after`.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn list(&self, after: Option<&str>, limit: u32) -> Result<Vec<DatabaseRow>, DatabaseError> {
        Ok(self.catalogue.databases(after, limit).await?)
    }

    /// How much the database holds.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn counts(&self, name: &Name) -> Result<DatabaseCounts, DatabaseError> {
        Ok(self.catalogue.database_counts(name.as_str()).await?)
    }

    /// Delete a database with all it holds; its unfinished jobs are cancelled.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownDatabase`].
    pub async fn delete(&self, name: &Name, by: &Actor) -> Result<(), DatabaseError> {
        if !self.catalogue.delete_database(name.as_str(), by).await? {
            return Err(DatabaseError::UnknownDatabase { database: name.to_string() });
        }
        self.registry.forget(name.as_str(), None);
        self.registry.refresh().await
    }

    /// The aliases of a database, by name.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn aliases(&self, name: &Name) -> Result<Vec<AliasRow>, DatabaseError> {
        Ok(self.catalogue.aliases(name.as_str()).await?)
    }

    /// One alias.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownAlias`].
    pub async fn alias(&self, name: &Name, alias: &Name) -> Result<AliasRow, DatabaseError> {
        let rows = self.aliases(name).await?;
        rows.into_iter().find(|row| row.alias == alias.as_str()).ok_or_else(|| DatabaseError::UnknownAlias {
            database: name.to_string(),
            alias: alias.to_string(),
        })
    }

    /// Point an alias to a version that loads; `true` when the alias is new. On return this process serves it.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownVersion`], [`DatabaseError::Unloadable`], or
    /// [`DatabaseError::PreconditionFailed`] when the alias isn't as `expected`.
    pub async fn set_alias(
        &self,
        name: &Name,
        alias: &Name,
        version: i64,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<(AliasRow, bool), DatabaseError> {
        // Held until the registry has swapped, so that the load is not done twice.
        let _loaded = self.version_model(name, version).await?;
        let set = self.catalogue.set_alias(name.as_str(), alias.as_str(), version, expected, by).await?;
        self.registry.refresh().await?;
        Ok(set)
    }

    /// Delete an alias.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownAlias`], or [`DatabaseError::PreconditionFailed`].
    pub async fn delete_alias(
        &self,
        name: &Name,
        alias: &Name,
        expected: AliasExpectation,
        by: &Actor,
    ) -> Result<(), DatabaseError> {
        if !self.catalogue.delete_alias(name.as_str(), alias.as_str(), expected, by).await? {
            return Err(DatabaseError::UnknownAlias { database: name.to_string(), alias: alias.to_string() });
        }
        self.registry.refresh().await
    }
}
