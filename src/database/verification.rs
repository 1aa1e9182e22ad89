//! Verification of everything that is kept: whether every exemplar's picture and every version is there and whole.

use super::{DatabaseError, ExemplarFilter, artifact};
use crate::store::{BlobError, Blobs, Catalogue};
use crate::telemetry::chain;

/// Rows read at once.
const PAGE: u32 = 1000;

/// What was read, and what is wrong with it.
#[derive(Debug, Default)]
pub struct Verification {
    /// Exemplars whose pictures were read.
    pub exemplars: u64,
    /// Versions whose artifacts were read.
    pub versions: u64,
    /// One line each: the exemplar or version, and what is wrong with it.
    pub faults: Vec<String>,
}

/// Read every exemplar's picture and every version's artifact, and compare each with its name and digest.
///
/// # Errors
/// The error of a store that is unavailable; what is damaged is a fault in the answer.
pub async fn verify(catalogue: &Catalogue, blobs: &Blobs) -> Result<Verification, DatabaseError> {
    let mut verification = Verification::default();
    let mut after: Option<String> = None;
    loop {
        let databases = catalogue.databases(after.as_deref(), PAGE).await?;
        let Some(last) = databases.last() else { return Ok(verification) };
        after = Some(last.name.clone());
        for database in &databases {
            verification.exemplars(&database.name, catalogue, blobs).await?;
            verification.versions(&database.name, catalogue, blobs).await?;
        }
    }
}

impl Verification {
    async fn exemplars(
        &mut self,
        database: &str,
        catalogue: &Catalogue,
        blobs: &Blobs,
    ) -> Result<(), DatabaseError> {
        let mut after = None;
        loop {
            let rows = catalogue.exemplars(database, &ExemplarFilter::default(), after, PAGE).await?;
            let Some(last) = rows.last() else { return Ok(()) };
            after = Some(last.id);
            for row in rows {
                self.exemplars += 1;
                let read = blobs.get(&row.blob.parse()?, row.bytes).await;
                self.note(read.map(drop), || format!("exemplar {} of database {database}", row.id))?;
            }
        }
    }

    async fn versions(
        &mut self,
        database: &str,
        catalogue: &Catalogue,
        blobs: &Blobs,
    ) -> Result<(), DatabaseError> {
        let mut after = None;
        loop {
            let rows = catalogue.versions(database, after, PAGE).await?;
            let Some(last) = rows.last() else { return Ok(()) };
            after = Some(last.version);
            for row in rows {
                self.versions += 1;
                let what = || format!("version {} of database {database}", row.version);
                match blobs.get(&row.blob.parse()?, row.bytes).await {
                    Err(error) => self.note(Err(error), what)?,
                    Ok(bytes) => match artifact::read(bytes) {
                        Err(error) => self.faults.push(format!("{}: {}", what(), chain(&error))),
                        Ok(artifact) if artifact.digest != row.digest => {
                            self.faults.push(format!("{}: its artifact is that of another version", what()));
                        }
                        Ok(_) => {}
                    },
                }
            }
        }
    }

    /// Adds a fault if the blob is damaged or gone.
    fn note(&mut self, read: Result<(), BlobError>, what: impl Fn() -> String) -> Result<(), DatabaseError> {
        match read {
            Err(error) if error.is_damage() => self.faults.push(format!("{}: {}", what(), chain(&error))),
            other => other?,
        }
        Ok(())
    }
}
