//! Exemplars: training images with their label, pose and the header of the robot that sent them.
//!
//! An exemplar's id is made from what it is (label, pose, bytes), so the same picture sent twice is one exemplar,
//! and the same pictures at another site have the same ids. One without a label is negative: it shows nothing known.

use std::fmt::Write;

use bytes::Bytes;
use jiff::Timestamp;
use serde::Serialize;
use sha2::{Digest, Sha256};
use utoipa::ToSchema;
use uuid::Uuid;

use super::{DatabaseError, Databases, ExemplarFilter, ExemplarRow, Name, Survey};
use crate::store::{Actor, BlobName, CatalogueError};

/// What the robot says about its frame, as an answer echoes it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = HeaderEcho)]
pub struct FrameHeader {
    /// `X-Robot-Id` as sent.
    pub robot_id: Option<String>,
    /// `X-Frame-Id` as sent.
    pub frame_id: Option<String>,
    /// `X-Stamp` as sent: RFC 3339 or `sec.nanosec`.
    pub stamp: Option<String>,
}

/// A training image to add. Its bytes have been decoded once: they are an image of that size.
#[derive(Debug, Clone)]
pub struct NewExemplar {
    label: Option<Name>,
    pose_deg: Option<f64>,
    survey: Survey,
    bytes: Bytes,
    media_type: &'static str,
    size_px: (u32, u32),
    header: FrameHeader,
    sha256: String,
}

impl NewExemplar {
    /// A training image with its SHA-256 sum, which takes a while for large images; negative without a label. `pose_deg` is the turntable pose in
    /// degrees, in [0, 360); `size_px` is width and height.
    pub fn of(
        label: Option<Name>,
        pose_deg: Option<f64>,
        survey: Survey,
        bytes: Bytes,
        media_type: &'static str,
        size_px: (u32, u32),
        header: FrameHeader,
    ) -> Self {
        let sha256 = sha256_hex(&bytes);
        Self { label, pose_deg, survey, bytes, media_type, size_px, header, sha256 }
    }
}

/// The id of an exemplar: a UUID of version 8 made from its content.
fn exemplar_id(label: Option<&Name>, pose_deg: Option<f64>, sha256: &str) -> Uuid {
    let label = label.map_or("", Name::as_str);
    let pose = pose_deg.map_or_else(String::new, |pose| pose.to_string());
    let hash = BlobName::of(format!("exemplar\n{label}\n{pose}\n{sha256}").as_bytes());
    Uuid::new_v8(hash.as_bytes().as_chunks().0[0])
}

fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut text, byte| {
        write!(text, "{byte:02x}").expect("writing to a string does not fail");
        text
    })
}

impl Databases {
    /// Keeps a training image: its bytes first, then its row; `true` when it is new. The same bytes with the same
    /// label and turntable pose again give the exemplar that is there, with what the new survey says over its own.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownDatabase`], or the error of a store that is unavailable.
    pub async fn add_exemplar(
        &self,
        database: &Name,
        new: NewExemplar,
    ) -> Result<(ExemplarRow, bool), DatabaseError> {
        let id = exemplar_id(new.label.as_ref(), new.pose_deg, &new.sha256);
        let bytes = new.bytes.len() as u64;
        let blob = self.blobs.put(new.bytes).await?;
        let row = ExemplarRow {
            database: database.to_string(),
            id,
            negative: new.label.is_none(),
            label: new.label.map_or_else(String::new, |label| label.to_string()),
            pose_deg: new.pose_deg,
            survey: new.survey.to_document(),
            width_px: new.size_px.0,
            height_px: new.size_px.1,
            bytes,
            sha256: new.sha256,
            blob: blob.to_string(),
            media_type: new.media_type.into(),
            robot_id: new.header.robot_id,
            frame_id: new.header.frame_id,
            stamp: new.header.stamp,
            created_at: Timestamp::UNIX_EPOCH,
        };
        let inserted = self.catalogue.insert_exemplar(&row).await;
        let (kept, created) = inserted.map_err(|error| match error {
            CatalogueError::NotFound { .. } => {
                DatabaseError::UnknownDatabase { database: database.to_string() }
            }
            error => error.into(),
        })?;
        match created {
            true => Ok((kept, true)),
            false => {
                Ok((self.change_survey(database, id, |before| new.survey.clone().over(before)).await?, false))
            }
        }
    }

    /// One exemplar.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownExemplar`].
    pub async fn exemplar(&self, database: &Name, id: Uuid) -> Result<ExemplarRow, DatabaseError> {
        let row = self.catalogue.exemplar(database.as_str(), id).await?;
        row.ok_or_else(|| DatabaseError::UnknownExemplar {
            database: database.to_string(),
            exemplar: id.to_string(),
        })
    }

    /// The bytes of an exemplar, as they were sent.
    ///
    /// # Errors
    /// [`DatabaseError::LostExemplar`] when they are damaged or gone.
    pub async fn exemplar_bytes(&self, row: &ExemplarRow) -> Result<Bytes, DatabaseError> {
        let read = self.blobs.get(&row.blob.parse()?, row.bytes).await;
        read.map_err(|source| match source.is_damage() {
            true => DatabaseError::LostExemplar {
                database: row.database.clone(),
                exemplar: row.id.to_string(),
                source,
            },
            false => source.into(),
        })
    }

    /// Exemplars by id, after `after`.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn exemplars(
        &self,
        database: &Name,
        filter: &ExemplarFilter,
        after: Option<Uuid>,
        limit: u32,
    ) -> Result<Vec<ExemplarRow>, DatabaseError> {
        Ok(self.catalogue.exemplars(database.as_str(), filter, after, limit).await?)
    }

    /// The ids of all exemplars, in the order in which they came.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn exemplars_by_arrival(&self, database: &Name) -> Result<Vec<Uuid>, DatabaseError> {
        let mut rows = self.catalogue.training_set(database.as_str()).await?;
        rows.sort_by_key(|row| (row.created_at, row.id));
        Ok(rows.into_iter().map(|row| row.id).collect())
    }

    /// Deletes one exemplar.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownExemplar`].
    pub async fn delete_exemplar(&self, database: &Name, id: Uuid, by: &Actor) -> Result<(), DatabaseError> {
        if self.catalogue.delete_exemplar(database.as_str(), id, by).await? {
            return Ok(());
        }
        Err(DatabaseError::UnknownExemplar { database: database.to_string(), exemplar: id.to_string() })
    }

    /// Deletes the exemplars that match the filter, and counts them.
    ///
    /// # Errors
    /// [`DatabaseError::EmptyFilter`] for a filter that names nothing: absent never means all.
    pub async fn delete_exemplars(
        &self,
        database: &Name,
        filter: &ExemplarFilter,
        by: &Actor,
    ) -> Result<u64, DatabaseError> {
        Ok(self.catalogue.delete_exemplars(database.as_str(), filter, by).await?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_made_from_label_pose_and_bytes_alone() {
        let (cup, cups) = (Name::parse("cup").unwrap(), Name::parse("cups").unwrap());
        let label = Some(&cup);
        let id = exemplar_id(label, Some(10.0), "aa");
        assert_eq!(id, exemplar_id(label, Some(10.0), "aa"));
        assert_eq!(id.get_version_num(), 8);
        for other in [
            exemplar_id(Some(&cups), Some(10.0), "aa"),
            exemplar_id(None, Some(10.0), "aa"),
            exemplar_id(label, Some(10.5), "aa"),
            exemplar_id(label, None, "aa"),
            exemplar_id(label, Some(10.0), "ab"),
        ] {
            assert_ne!(id, other);
        }
    }

    #[test]
    fn the_sum_is_what_sha256sum_prints() {
        assert_eq!(sha256_hex(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    }
}
