//! The processes that share a catalogue, and what each of them serves.

use std::time::Duration;

use jiff::Timestamp;

use super::registry::ServedState;
use super::{DatabaseError, Databases};
use crate::store::ProcessRow;

/// A process whose row is older is taken for gone: five refreshes.
const GONE_AFTER: Duration = Duration::from_secs(10);

/// A process, and what it serves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    /// The name under which it does jobs.
    pub worker: String,
    /// `serve`, `train` or `all`.
    pub role: String,
    /// The databases that it serves.
    pub databases: Vec<ServedState>,
    /// When it started.
    pub started_at: Timestamp,
}

impl Databases {
    /// Writes down for the other processes what this one serves.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn record_process(&self, process: &Process) -> Result<(), DatabaseError> {
        let row = ProcessRow {
            worker: process.worker.clone(),
            role: process.role.clone(),
            serving: serde_json::json!(process.databases).to_string(),
            started_at: process.started_at,
            seen_at: process.started_at,
        };
        Ok(self.catalogue.record_process(&row).await?)
    }

    /// The processes of the fleet by the time of their start; none where one process works alone. One whose row
    /// can't be read, of another release perhaps, is listed as serving nothing.
    ///
    /// # Errors
    /// The catalogue is unavailable.
    pub async fn processes(&self) -> Result<Vec<Process>, DatabaseError> {
        let rows = self.catalogue.processes(GONE_AFTER).await?;
        let process = |row: ProcessRow| Process {
            databases: serde_json::from_str(&row.serving).unwrap_or_default(),
            worker: row.worker,
            role: row.role,
            started_at: row.started_at,
        };
        Ok(rows.into_iter().map(process).collect())
    }
}
