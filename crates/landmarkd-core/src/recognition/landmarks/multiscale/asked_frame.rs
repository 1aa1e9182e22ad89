//! A frame that is asked in two steps: of a database whose windows are elsewhere exemplars are chosen, then the frame is
//! recognised among them.

use std::borrow::Cow;
use std::sync::Arc;

use super::description::ScaleSpaceAttention;
use super::encoded_exemplars::EncodedExemplars;
use super::encoded_windows::EncodedWindows;
use super::recognise_among;
use crate::imaging::Frame;
use crate::recognition::landmarks::description::WindowBatch;
use crate::recognition::landmarks::edge_template::EdgePoint;
use crate::recognition::landmarks::model::{Exemplar, Landmarks, Windows};
use crate::recognition::landmarks::parts::PartsError;
use crate::recognition::landmarks::recognition::{Recognition, Stage};

/// A frame with its windows.
pub struct AskedFrame<'a> {
    /// At the working size.
    pub(super) working: Cow<'a, Frame>,
    pub(super) attention: ScaleSpaceAttention,
    pub(super) batch: WindowBatch,
}

/// What is kept of an exemplar beside its name.
#[derive(Clone, Debug)]
pub struct KeptExemplar<'a> {
    /// Its index in the database.
    pub index: usize,
    /// A row a window.
    pub rows: &'a [u8],
    /// Points of its edge template.
    pub edges: Vec<EdgePoint>,
}

impl<'a> AskedFrame<'a> {
    /// Describes a frame as the exemplars were. Calls `finished` after each stage.
    pub(in super::super) fn of(
        model: &Landmarks,
        exemplars: &EncodedExemplars,
        frame: &'a Frame,
        mut finished: impl FnMut(Stage),
    ) -> AskedFrame<'a> {
        let working = model.options.working_frame(frame);
        let attention = exemplars.describer.attend(&working); // A§4.2
        finished(Stage::Attention);
        let batch = exemplars.describer.describe(&working, &attention, model.options.query_points); // A§4.3, A§4.4
        finished(Stage::Signature);
        AskedFrame { working, attention, batch }
    }
}

impl Landmarks {
    /// Whether its windows are here, so that it recognises.
    pub fn has_windows(&self) -> bool {
        !matches!(self.windows, Windows::Elsewhere(_))
    }

    /// A frame with its windows; `None` with signatures of intensities. Calls `finished` after each stage.
    pub fn ask(&self, frame: &Frame, finished: impl FnMut(Stage)) -> Option<AskedFrame<'static>> {
        let asked = AskedFrame::of(self, self.windows.encoded()?, frame, finished);
        let AskedFrame { working, attention, batch } = asked;
        Some(AskedFrame { working: Cow::Owned(working.into_owned()), attention, batch })
    }

    /// The `count` exemplars that are likest the frame by one descriptor each, ascending: nearly always what the frame shows is
    /// among them, if it is known.
    pub fn likest(&self, asked: &AskedFrame<'_>, count: usize) -> Vec<usize> {
        let Some(EncodedExemplars { encoding, descriptors, .. }) = self.windows.encoded() else {
            return Vec::new();
        };
        let points = self.eigenspace.project(&asked.batch.signatures); // A§4.1
        let has_windows = |exemplar: usize| self.exemplars[exemplar].windows > 0;
        encoding.vlad.likest(&points, descriptors, has_windows, count)
    }

    /// The database of some of its exemplars with their windows, for recognition among them: what chance explains is judged by
    /// all. The indices ascend.
    ///
    /// # Errors
    /// The windows are not those of the exemplars.
    pub fn of_kept(&self, kept: Vec<KeptExemplar<'_>>) -> Result<Landmarks, PartsError> {
        let all = self.windows.encoded().ok_or(PartsError::Signature)?;
        let rows: Vec<u8> = kept.iter().map(|kept| kept.rows).collect::<Vec<_>>().concat();
        let descriptors = kept.iter().map(|kept| all.descriptors[kept.index]).collect();
        let exemplar =
            |kept: KeptExemplar<'_>| Exemplar { edges: kept.edges, ..self.exemplars[kept.index].clone() };
        let exemplars: Vec<Exemplar> = kept.into_iter().map(exemplar).collect();
        let encoded = EncodedExemplars {
            describer: Arc::clone(&all.describer),
            encoding: all.encoding.clone(),
            descriptors,
        };
        let windows = EncodedWindows::of_rows(encoded, &rows, &exemplars).ok_or(PartsError::Lists)?;
        Ok(Landmarks {
            options: self.options.clone(),
            describer: Arc::clone(&self.describer),
            exemplars,
            eigenspace: self.eigenspace.clone(),
            windows: Windows::Encoded(windows.into()),
            chosen_from: self.exemplars.len(),
            confidence: self.confidence,
        })
    }

    /// Recognises a frame that was asked of this database, or of one that its exemplars were chosen from. Calls `finished`
    /// after each stage.
    ///
    /// # Errors
    /// Its windows are elsewhere.
    pub fn recognise_asked(
        &self,
        asked: &AskedFrame<'_>,
        finished: impl FnMut(Stage),
    ) -> Result<Recognition, PartsError> {
        match &self.windows {
            Windows::Encoded(windows) => Ok(recognise_among(self, windows, None, asked, finished)),
            _ => Err(PartsError::Lists),
        }
    }
}
