//! Calibrations: what is known of the rigs that depth is measured with, under names.
//!
//! A rig changes by compare-and-swap on its revision: what was measured with one optics is never kept with another.

mod advice;
mod document;

use bytes::Bytes;
use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

pub use advice::optics_advice;
pub use document::{
    CALIBRATION_DOCUMENT_VERSION, DepthMethodWord, FiltersDocument, ImageDocument, NoiseDocument,
    PhotometricDocument, RegistrationDocument, ResidualDocument, TableDocument, UnreadableCalibration,
};

use super::{DatabaseError, Databases, Name};
use crate::store::{Actor, CalibrationRow, CatalogueError, JobFilter, JobState};
use landmarkd_core::depth::{Calibration, Optics};

/// A rig of a lens before two sensors: a calibration under a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// The calibration's name.
    pub name: String,
    /// What is known of the rig.
    pub calibration: Calibration,
    /// Grows with every change.
    pub revision: i64,
    /// When it was created.
    pub created_at: Timestamp,
    /// When it was last changed.
    pub updated_at: Timestamp,
}

/// A picture of a sweep, kept until its job has ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PictureBlob {
    /// Name of the blob.
    pub blob: String,
    /// Its size in bytes.
    pub bytes: u64,
}

/// Attempts to put a rig while others change it.
const PUT_ATTEMPTS: u32 = 8;

impl TryFrom<CalibrationRow> for Rig {
    type Error = DatabaseError;

    fn try_from(row: CalibrationRow) -> Result<Self, DatabaseError> {
        let calibration = document::read(&row.document).map_err(|source| {
            DatabaseError::UnreadableCalibration { calibration: row.name.clone(), source }
        })?;
        let CalibrationRow { name, revision, created_at, updated_at, .. } = row;
        Ok(Self { name, calibration, revision, created_at, updated_at })
    }
}

impl Databases {
    /// Creates a rig of this optics, or finds the one of that name; `true` when it is new. The same optics keeps what
    /// was measured with it; another drops it.
    ///
    /// # Errors
    /// [`DatabaseError::CalibrationChanged`] when others keep changing it.
    pub async fn put_rig(
        &self,
        name: &Name,
        optics: &Optics,
        by: &Actor,
    ) -> Result<(Rig, bool), DatabaseError> {
        for _ in 0..PUT_ATTEMPTS {
            let before = self.catalogue.calibration(name.as_str()).await?;
            let revision = before.as_ref().map(|row| row.revision);
            // One that can't be read is replaced.
            if let Some(rig) = before.and_then(|row| Rig::try_from(row).ok())
                && rig.calibration.stated.unwrap_or(rig.calibration.optics) == *optics
            {
                return Ok((rig, false));
            }
            let document = document::text(&Calibration::of(*optics));
            match self.catalogue.put_calibration(name.as_str(), &document, revision, by).await {
                Ok(row) => return Ok((row.try_into()?, revision.is_none())),
                Err(CatalogueError::PreconditionFailed) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Err(DatabaseError::CalibrationChanged { calibration: name.to_string() })
    }

    /// The rig of that name.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownCalibration`], or [`DatabaseError::UnreadableCalibration`].
    pub async fn rig(&self, name: &Name) -> Result<Rig, DatabaseError> {
        let row = self.catalogue.calibration(name.as_str()).await?;
        row.ok_or_else(|| DatabaseError::UnknownCalibration { calibration: name.to_string() })?.try_into()
    }

    /// The newest sweep of a rig, if it failed after the rig was changed last: what was known before it still answers.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn failed_sweep(&self, rig: &Rig) -> Result<Option<Uuid>, DatabaseError> {
        let filter = JobFilter { calibration: Some(rig.name.clone()), ..JobFilter::default() };
        let newest = self.catalogue.jobs(&filter, None, 1).await?.pop();
        let failed = newest.filter(|job| job.state == JobState::Failed && job.created_at >= rig.updated_at);
        Ok(failed.map(|job| job.id))
    }

    /// Rigs by name, after `after`.
    ///
    /// # Errors
    /// [`DatabaseError::UnreadableCalibration`].
    pub async fn rigs(&self, after: Option<&str>, limit: u32) -> Result<Vec<Rig>, DatabaseError> {
        self.catalogue.calibrations(after, limit).await?.into_iter().map(Rig::try_from).collect()
    }

    /// Deletes a rig; its unfinished jobs are cancelled.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownCalibration`].
    pub async fn delete_rig(&self, name: &Name, by: &Actor) -> Result<(), DatabaseError> {
        if self.catalogue.delete_calibration(name.as_str(), by).await? {
            return Ok(());
        }
        Err(DatabaseError::UnknownCalibration { calibration: name.to_string() })
    }

    /// Keeps what was measured with a rig since it was read.
    ///
    /// # Errors
    /// [`DatabaseError::CalibrationChanged`] when it isn't as it was then, or is gone.
    pub async fn update_rig(
        &self,
        rig: &Rig,
        calibration: &Calibration,
        by: &Actor,
    ) -> Result<Rig, DatabaseError> {
        let document = document::text(calibration);
        match self.catalogue.put_calibration(&rig.name, &document, Some(rig.revision), by).await {
            Ok(row) => row.try_into(),
            Err(CatalogueError::PreconditionFailed) => {
                Err(DatabaseError::CalibrationChanged { calibration: rig.name.clone() })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Ends a job with what it measured with a rig since it was read.
    ///
    /// # Errors
    /// As [`Self::update_rig`], and those of a job whose lease was lost or that was asked to end.
    pub(crate) async fn publish_rig(
        &self,
        (job, token): (uuid::Uuid, i64),
        rig: &Rig,
        calibration: &Calibration,
    ) -> Result<(), DatabaseError> {
        let document = document::text(calibration);
        match self.catalogue.publish_calibration(job, token, &document, rig.revision).await {
            Ok(_) => Ok(()),
            Err(CatalogueError::PreconditionFailed) => {
                Err(DatabaseError::CalibrationChanged { calibration: rig.name.clone() })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Keeps a picture for a job that is queued next: one that no job names is removed after a day.
    ///
    /// # Errors
    /// The blob store is unavailable.
    pub async fn keep_picture(&self, bytes: Bytes) -> Result<PictureBlob, DatabaseError> {
        let size = bytes.len() as u64;
        Ok(PictureBlob { blob: self.blobs.put(bytes).await?.to_string(), bytes: size })
    }

    /// The bytes of a picture kept for a job.
    pub(crate) async fn picture(&self, kept: &PictureBlob) -> Result<Bytes, DatabaseError> {
        Ok(self.blobs.get(&kept.blob.parse()?, kept.bytes).await?)
    }
}
