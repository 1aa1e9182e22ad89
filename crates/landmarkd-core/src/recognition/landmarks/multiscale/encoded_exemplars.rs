//! What is known of the exemplars of a database with gradient signatures without looking at their windows.

use std::sync::Arc;

use super::description::ScaleSpaceDescriber;
use super::phase_space::{KEPT_LENGTH, PhaseSpace};
use super::vlad::{Descriptor, Vlad};
use crate::eigen::{Code, Codebook};

/// Bytes of what is kept of a window beside its eigenpoint's code: x and y, in units of its exemplar's size, little-endian; its
/// level; its phases.
pub(super) const REST_LENGTH: usize = 2 * size_of::<u16>() + 1 + KEPT_LENGTH;

/// Bytes of a window: the code of its eigenpoint, then the rest.
pub(in super::super) fn window_length(dimension: usize) -> usize {
    Code::length(dimension) + REST_LENGTH
}

/// How windows and exemplars are kept, fitted to a sample of a database.
#[derive(Clone)]
pub(in super::super) struct Encoding {
    pub codebook: Arc<Codebook>,
    pub phases: Arc<PhaseSpace>,
    pub vlad: Arc<Vlad>,
}

impl Encoding {
    /// Bytes of a window.
    pub fn row_length(&self) -> usize {
        window_length(self.codebook.dimension())
    }

    /// Bytes of the code.
    pub(super) fn code_length(&self) -> usize {
        Code::length(self.codebook.dimension())
    }

    /// The rows of windows: of each the eigenpoint, x and y in units of the exemplar's size, and the level; of all the spectra.
    pub fn rows(
        &self,
        eigenpoints: &[f32],
        windows: impl Iterator<Item = ([u16; 2], u8)>,
        spectra: &[i8],
    ) -> Vec<u8> {
        let (codes, phases) = (self.codebook.encode(eigenpoints), self.phases.kept(spectra));
        let both = codes.chunks_exact(self.code_length()).zip(phases.chunks_exact(KEPT_LENGTH));
        let mut rows = Vec::with_capacity(both.len() * self.row_length());
        for ((code, phases), (position, level)) in both.zip(windows) {
            rows.extend(code);
            rows.extend(position.into_iter().flat_map(u16::to_le_bytes));
            rows.push(level);
            rows.extend(phases);
        }
        rows
    }
}

/// The exemplars of a database, whose windows are elsewhere or beside it.
pub(in super::super) struct EncodedExemplars {
    pub describer: Arc<ScaleSpaceDescriber>,
    pub encoding: Encoding,
    /// Of each exemplar.
    pub descriptors: Vec<Descriptor>,
}

impl EncodedExemplars {
    /// Memory that they take, in bytes.
    pub fn bytes(&self) -> usize {
        let Encoding { codebook, phases, vlad } = &self.encoding;
        codebook.bytes()
            + size_of_val(phases.basis())
            + size_of_val(vlad.centroids())
            + size_of_val(&self.descriptors[..])
    }
}
