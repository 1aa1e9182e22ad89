//! Cameras: intrinsics under names, which pictures then name. Who puts one last wins.

use jiff::Timestamp;

use super::survey::CameraDocument;
use super::{DatabaseError, Databases, Name};
use crate::store::{Actor, NamedDocument};

/// Intrinsics under their name.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptCamera {
    /// Their name.
    pub name: String,
    /// The intrinsics.
    pub camera: CameraDocument,
    /// When they were kept first.
    pub created_at: Timestamp,
    /// When they were replaced last.
    pub updated_at: Timestamp,
}

impl TryFrom<NamedDocument> for KeptCamera {
    type Error = DatabaseError;

    fn try_from(row: NamedDocument) -> Result<Self, DatabaseError> {
        let NamedDocument { name, document, created_at, updated_at } = row;
        match serde_json::from_str(&document) {
            Ok(camera) => Ok(Self { name, camera, created_at, updated_at }),
            Err(source) => Err(DatabaseError::UnreadableCamera { camera: name, source }),
        }
    }
}

impl Databases {
    /// Keeps a camera, or replaces the one of that name; `true` when it is new. Exemplars that came before keep what it was.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn put_camera(
        &self,
        name: &Name,
        camera: &CameraDocument,
        by: &Actor,
    ) -> Result<(KeptCamera, bool), DatabaseError> {
        let document = serde_json::to_string(camera).expect("numbers always serialise");
        let (row, created) = self.catalogue.put_camera(name.as_str(), &document, by).await?;
        Ok((row.try_into()?, created))
    }

    /// The camera of that name.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownCamera`], or [`DatabaseError::UnreadableCamera`].
    pub async fn camera(&self, name: &Name) -> Result<KeptCamera, DatabaseError> {
        let row = self.catalogue.camera(name.as_str()).await?;
        row.ok_or_else(|| DatabaseError::UnknownCamera { camera: name.to_string() })?.try_into()
    }

    /// Cameras by name, after `after`.
    ///
    /// # Errors
    /// [`DatabaseError::UnreadableCamera`].
    pub async fn cameras(&self, after: Option<&str>, limit: u32) -> Result<Vec<KeptCamera>, DatabaseError> {
        self.catalogue.cameras(after, limit).await?.into_iter().map(KeptCamera::try_from).collect()
    }

    /// Deletes a camera.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownCamera`].
    pub async fn delete_camera(&self, name: &Name, by: &Actor) -> Result<(), DatabaseError> {
        if self.catalogue.delete_camera(name.as_str(), by).await? {
            return Ok(());
        }
        Err(DatabaseError::UnknownCamera { camera: name.to_string() })
    }
}
