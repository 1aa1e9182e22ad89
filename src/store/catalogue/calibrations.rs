//! Calibrations, workcells and cameras.

use serde_json::json;

use super::Catalogue;
use crate::store::error::CatalogueError;
use crate::store::session::{statement, transaction};
use crate::store::tables::audit::{self, Actor, NewEntry, parse_document};
use crate::store::tables::calibrations::{self, CalibrationRow};
use crate::store::tables::jobs::{self, Subject};
use crate::store::tables::named_documents::NamedDocument;
use crate::store::tables::{cameras, workcells};

impl Catalogue {
    /// Creates the calibration of that name, or replaces its document, if it is at the revision `expected`; none means
    /// that it isn't there.
    ///
    /// # Errors
    /// `PreconditionFailed`; `Unavailable`, `Corrupt`.
    pub async fn put_calibration(
        &self,
        name: &str,
        document: &str,
        expected: Option<i64>,
        actor: &Actor,
    ) -> Result<CalibrationRow, CatalogueError> {
        transaction!(self, c => {
            let row = calibrations::put(c, name, document, expected).await?;
            let detail = json!({"document": parse_document(document)});
            audit::append(c, actor, NewEntry::new("calibration.put").about(name).with(detail)).await?;
            Ok(row)
        })
    }

    /// The calibration of that name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn calibration(&self, name: &str) -> Result<Option<CalibrationRow>, CatalogueError> {
        statement!(self, c => calibrations::find(c, name).await)
    }

    /// Calibrations by name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn calibrations(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<CalibrationRow>, CatalogueError> {
        statement!(self, c => calibrations::list(c, after, limit).await)
    }

    /// Deletes a calibration and cancels its unfinished jobs; false when there was none.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn delete_calibration(&self, name: &str, actor: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = calibrations::delete(c, name).await?;
            jobs::cancel_all(c, Subject::Calibration(name)).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("calibration.delete").about(name)).await?;
            }
            c.notifies = true;
            Ok(deleted)
        })
    }

    /// Creates the workcell of that name, with `true`, or replaces its document.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn put_workcell(
        &self,
        name: &str,
        document: &str,
        actor: &Actor,
    ) -> Result<(NamedDocument, bool), CatalogueError> {
        transaction!(self, c => {
            let put = workcells::put(c, name, document).await?;
            let detail = json!({"document": parse_document(document)});
            audit::append(c, actor, NewEntry::new("workcell.put").about(name).with(detail)).await?;
            Ok(put)
        })
    }

    /// The workcell of that name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn workcell(&self, name: &str) -> Result<Option<NamedDocument>, CatalogueError> {
        statement!(self, c => workcells::find(c, name).await)
    }

    /// Workcells by name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn workcells(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<NamedDocument>, CatalogueError> {
        statement!(self, c => workcells::list(c, after, limit).await)
    }

    /// Deletes a workcell; false when there was none.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn delete_workcell(&self, name: &str, actor: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = workcells::delete(c, name).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("workcell.delete").about(name)).await?;
            }
            Ok(deleted)
        })
    }

    /// Creates the camera of that name, with `true`, or replaces its document.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn put_camera(
        &self,
        name: &str,
        document: &str,
        actor: &Actor,
    ) -> Result<(NamedDocument, bool), CatalogueError> {
        transaction!(self, c => {
            let put = cameras::put(c, name, document).await?;
            let detail = json!({"document": parse_document(document)});
            audit::append(c, actor, NewEntry::new("camera.put").about(name).with(detail)).await?;
            Ok(put)
        })
    }

    /// The camera of that name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn camera(&self, name: &str) -> Result<Option<NamedDocument>, CatalogueError> {
        statement!(self, c => cameras::find(c, name).await)
    }

    /// Cameras by name.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn cameras(
        &self,
        after: Option<&str>,
        limit: u32,
    ) -> Result<Vec<NamedDocument>, CatalogueError> {
        statement!(self, c => cameras::list(c, after, limit).await)
    }

    /// Deletes a camera; false when there was none.
    ///
    /// # Errors
    /// `Unavailable`, `Corrupt`.
    pub async fn delete_camera(&self, name: &str, actor: &Actor) -> Result<bool, CatalogueError> {
        transaction!(self, c => {
            let deleted = cameras::delete(c, name).await?;
            if deleted {
                audit::append(c, actor, NewEntry::new("camera.delete").about(name)).await?;
            }
            Ok(deleted)
        })
    }
}
