//! Versions: what a training made of a database's exemplars. A version never changes.

use bytes::Bytes;

use super::artifact::{self, Artifact};
use super::{ALGORITHM_REVISION, DatabaseError, Databases, ExemplarRow, Kind, Name, VersionRow};
use crate::compute::{Compute, Lane};
use crate::store::{Actor, BlobName, CatalogueError, NewVersion};
use crate::telemetry::chain;

/// The digest of a training's inputs, hex: the same exemplars, options and algorithm give the same digest, in
/// whatever order the exemplars came.
pub fn inputs_digest(kind: Kind, options_document: &str, exemplars: &[ExemplarRow]) -> String {
    let mut lines: Vec<String> = exemplars
        .iter()
        .map(|row| {
            let pose = row.pose_deg.map_or_else(|| "-".into(), |pose| pose.to_string());
            // no label is "-": names begin with a letter or a digit
            let label = if row.negative { "-" } else { &row.label };
            let survey = row.survey.as_ref().map_or_else(String::new, |survey| format!(" {survey}"));
            format!("{} {label} {pose}{survey}", row.sha256)
        })
        .collect();
    lines.sort_unstable();
    lines.dedup();
    let kind = kind.as_str();
    let text = format!(
        "landmarkd inputs\n{kind}\nrevision {ALGORITHM_REVISION}\n{options_document}\n{}\n",
        lines.join("\n")
    );
    BlobName::of(text.as_bytes()).to_string()
}

/// The digest of inputs that were added to the version of a digest, hex.
pub fn grown_digest(inputs: &str, from: &str) -> String {
    BlobName::of(format!("landmarkd grown\n{inputs}\n{from}\n").as_bytes()).to_string()
}

impl Databases {
    /// Versions by number, after `after`.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn versions(
        &self,
        database: &Name,
        after: Option<i64>,
        limit: u32,
    ) -> Result<Vec<VersionRow>, DatabaseError> {
        Ok(self.catalogue.versions(database.as_str(), after, limit).await?)
    }

    /// One version.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownVersion`].
    pub async fn version(&self, database: &Name, version: i64) -> Result<VersionRow, DatabaseError> {
        let row = self.catalogue.version(database.as_str(), version).await?;
        row.ok_or_else(|| DatabaseError::UnknownVersion { database: database.to_string(), version })
    }

    /// Deletes a version that no alias points to.
    ///
    /// # Errors
    /// [`DatabaseError::UnknownVersion`] or [`DatabaseError::VersionInUse`].
    pub async fn delete_version(
        &self,
        database: &Name,
        version: i64,
        by: &Actor,
    ) -> Result<(), DatabaseError> {
        match self.catalogue.delete_version(database.as_str(), version, by).await {
            Ok(true) => {
                self.registry().forget(database.as_str(), Some(version));
                Ok(())
            }
            Ok(false) => Err(DatabaseError::UnknownVersion { database: database.to_string(), version }),
            Err(CatalogueError::Conflict { .. }) => {
                Err(DatabaseError::VersionInUse { database: database.to_string(), version })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The artifact file of a version.
    ///
    /// # Errors
    /// [`DatabaseError::Unloadable`] when it is damaged or gone.
    pub async fn artifact(&self, row: &VersionRow) -> Result<Bytes, DatabaseError> {
        let read = self.blobs.get(&row.blob.parse()?, row.bytes).await;
        read.map_err(|source| match source.is_damage() {
            true => DatabaseError::Unloadable {
                database: row.database.clone(),
                version: row.version,
                reason: chain(&source),
            },
            false => source.into(),
        })
    }

    /// Imports an artifact file, checked whole, as a new version; `true` when it is new. No alias moves.
    ///
    /// # Errors
    /// [`DatabaseError::InvalidArtifact`], [`DatabaseError::KindConflict`], [`DatabaseError::UnknownDatabase`].
    pub async fn import(
        &self,
        database: &Name,
        bytes: Bytes,
        compute: &Compute,
        by: &Actor,
    ) -> Result<(VersionRow, bool), DatabaseError> {
        let row = self.get(database).await?;
        let held = bytes.clone();
        let (read, _) = compute.run(Lane::Maintenance, 0, move || artifact::read(held)).await?;
        let artifact = read.map_err(|source| DatabaseError::InvalidArtifact { source })?;
        if row.kind != artifact.kind().as_str() {
            return Err(DatabaseError::KindConflict { database: database.to_string(), kind: row.kind });
        }
        let new = self.keep_artifact(database.as_str(), &artifact, bytes).await?;
        Ok(self.catalogue.insert_version(&new, by).await?)
    }

    /// Stores an artifact's bytes; returns the version row that will name them.
    pub(crate) async fn keep_artifact(
        &self,
        database: &str,
        artifact: &Artifact,
        bytes: Bytes,
    ) -> Result<NewVersion, DatabaseError> {
        let size = bytes.len() as u64;
        let blob = self.blobs.put(bytes).await?;
        Ok(NewVersion {
            database: database.into(),
            digest: artifact.digest.clone(),
            blob: blob.to_string(),
            bytes: size,
            kind: artifact.kind().as_str().into(),
            algorithm_revision: artifact.algorithm_revision,
            options: artifact.options_document(),
            counts: serde_json::to_string(&artifact.counts).expect("counts are numbers"),
            report: artifact.report.to_document(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jiff::Timestamp;
    use uuid::Uuid;

    fn row(label: &str, sha256: &str, pose_deg: Option<f64>) -> ExemplarRow {
        ExemplarRow {
            database: "d".into(),
            id: Uuid::nil(),
            label: label.into(),
            negative: label.is_empty(),
            pose_deg,
            survey: None,
            width_px: 1,
            height_px: 1,
            bytes: 1,
            sha256: sha256.into(),
            blob: String::new(),
            media_type: "image/png".into(),
            robot_id: None,
            frame_id: None,
            stamp: None,
            created_at: Timestamp::UNIX_EPOCH,
        }
    }

    #[test]
    fn order_of_exemplars_does_not_change_the_digest_and_everything_else_does() {
        let (a, b) = (row("cup", "00", None), row("cup", "11", Some(5.0)));
        let digest = inputs_digest(Kind::Landmarks, "{}", &[a.clone(), b.clone()]);
        assert_eq!(digest, inputs_digest(Kind::Landmarks, "{}", &[b.clone(), a.clone()]));
        for other in [
            inputs_digest(Kind::Landmarks, "{1}", &[a.clone(), b.clone()]),
            inputs_digest(Kind::Landmarks, "{}", std::slice::from_ref(&a)),
            inputs_digest(Kind::Landmarks, "{}", &[a.clone(), row("cup", "11", Some(6.0))]),
            inputs_digest(Kind::Landmarks, "{}", &[row("", "00", None), b.clone()]),
            inputs_digest(
                Kind::Landmarks,
                "{}",
                &[ExemplarRow { survey: Some("{}".into()), ..a.clone() }, b.clone()],
            ),
            inputs_digest(Kind::Landmarks, "{}", &[row("can", "00", None), b]),
        ] {
            assert_ne!(digest, other);
        }
    }
}
