//! Workcells: what a table's cameras see and where the robot reaches, under names. Who puts one last wins.

mod document;

use jiff::Timestamp;

pub use document::{
    CorrespondenceDocument, LocalCameraDocument, MappingKindWord, UnreadableWorkcell, WorkcellDocument,
};

use super::{DatabaseError, Databases, Kind, Name};
use crate::store::{Actor, NamedDocument};
use landmarkd_core::workcell::{Correspondence, Workcell};

/// A workcell, as it is described.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkcellSetup {
    /// The database that names the parts, of kind objects.
    pub database: Name,
    /// The rig that measures distances.
    pub calibration: Option<Name>,
    /// What the mapping is fitted to.
    pub correspondences: Vec<Correspondence>,
    /// The cameras and the robot.
    pub workcell: Workcell,
}

/// A workcell under its name.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptWorkcell {
    /// Its name.
    pub name: String,
    /// Its description.
    pub setup: WorkcellSetup,
    /// When it was described first.
    pub created_at: Timestamp,
    /// When it was described last.
    pub updated_at: Timestamp,
}

impl TryFrom<NamedDocument> for KeptWorkcell {
    type Error = DatabaseError;

    fn try_from(row: NamedDocument) -> Result<Self, DatabaseError> {
        let NamedDocument { name, document, created_at, updated_at } = row;
        match document::read(&document) {
            Ok(setup) => Ok(Self { name, setup, created_at, updated_at }),
            Err(source) => Err(DatabaseError::UnreadableWorkcell { workcell: name, source }),
        }
    }
}

impl Databases {
    /// Create a workcell, or replace the one of that name; `true` when it is new.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownDatabase`] or [`DatabaseError::WrongKind`] for its database,
    /// [`DatabaseError::UnknownCalibration`] for its rig.
    pub async fn put_workcell(
        &self,
        name: &Name,
        setup: &WorkcellSetup,
        by: &Actor,
    ) -> Result<(KeptWorkcell, bool), DatabaseError> {
        let database = self.get(&setup.database).await?;
        if database.kind != Kind::Objects.as_str() {
            let wanted = Kind::Objects.as_str();
            return Err(DatabaseError::WrongKind { database: database.name, kind: database.kind, wanted });
        }
        if let Some(calibration) = &setup.calibration {
            self.rig(calibration).await?;
        }
        let document = WorkcellDocument::from(setup).to_text();
        let (row, created) = self.catalogue.put_workcell(name.as_str(), &document, by).await?;
        // As it is read from now on.
        Ok((row.try_into()?, created))
    }

    /// The workcell of that name.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownWorkcell`], or [`DatabaseError::UnreadableWorkcell`].
    pub async fn workcell(&self, name: &Name) -> Result<KeptWorkcell, DatabaseError> {
        let row = self.catalogue.workcell(name.as_str()).await?;
        row.ok_or_else(|| DatabaseError::UnknownWorkcell { workcell: name.to_string() })?.try_into()
    }

    /// Workcells by name, after `after`.
    ///
    /// # Errors
    /// [`DatabaseError::UnreadableWorkcell`].
    pub async fn workcells(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<KeptWorkcell>, DatabaseError> {
        self.catalogue.workcells(after, limit).await?.into_iter().map(KeptWorkcell::try_from).collect()
    }

    /// Delete a workcell.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownWorkcell`].
    pub async fn delete_workcell(&self, name: &Name, by: &Actor) -> Result<(), DatabaseError> {
        if self.catalogue.delete_workcell(name.as_str(), by).await? {
            return Ok(());
        }
        Err(DatabaseError::UnknownWorkcell { workcell: name.to_string() })
    }
}
