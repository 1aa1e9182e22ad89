//! The windows of a database with gradient signatures, as they are searched and compared: 150 bytes of each.

use std::ops::Range;
use std::sync::Arc;

use super::description::MOST_LEVELS;
use super::encoded_exemplars::{EncodedExemplars, REST_LENGTH};
use crate::eigen::{Code, InvertedIndex};
use crate::recognition::landmarks::model::Exemplar;

/// What a match needs of a window.
pub(super) struct EncodedWindow<'a> {
    /// Index of its exemplar.
    pub exemplar: u32,
    /// In units of the exemplar's size.
    pub position: [u16; 2],
    pub level: u8,
    pub phases: &'a [u8],
}

/// All windows of a database, exemplar by exemplar.
pub(in super::super) struct EncodedWindows {
    pub exemplars: EncodedExemplars,
    index: InvertedIndex,
    /// n × [`REST_LENGTH`].
    rest: Vec<u8>,
    /// Where the windows of each exemplar start, and after the last n.
    starts: Vec<u32>,
}

impl EncodedWindows {
    /// The windows of rows that may hold anything; `None` if they are not those of the exemplars.
    pub fn of_rows(encoded: EncodedExemplars, rows: &[u8], exemplars: &[Exemplar]) -> Option<EncodedWindows> {
        let codebook = Arc::clone(&encoded.encoding.codebook);
        let (length, code_length) = (encoded.encoding.row_length(), encoded.encoding.code_length());
        let mut starts = vec![0_u32];
        for exemplar in exemplars {
            let windows = u32::try_from(exemplar.windows).ok()?;
            starts.push(starts.last()?.checked_add(windows)?);
        }
        let windows = *starts.last()? as usize;
        let is_sound = |row: &[u8]| {
            (Code::of_row(row, codebook.dimension()).list as usize) < codebook.lists()
                && usize::from(row[code_length + 4]) < MOST_LEVELS
        };
        let fits = windows > 0
            && windows < u32::MAX as usize
            && windows.checked_mul(length) == Some(rows.len())
            && rows.chunks_exact(length).all(is_sound);
        fits.then(|| {
            let mut rest = Vec::with_capacity(windows * REST_LENGTH);
            rows.chunks_exact(length).for_each(|row| rest.extend_from_slice(&row[code_length..]));
            let index = InvertedIndex::of_codes(codebook, rows, length);
            EncodedWindows { exemplars: encoded, index, rest, starts }
        })
    }

    /// What they are kept as: n rows.
    pub fn rows(&self) -> Vec<u8> {
        let codes = self.index.codes();
        let code_length = self.exemplars.encoding.code_length();
        let both = codes.chunks_exact(code_length).zip(self.rest.chunks_exact(REST_LENGTH));
        let mut rows = Vec::with_capacity(codes.len() + self.rest.len());
        both.for_each(|(code, rest)| {
            rows.extend_from_slice(code);
            rows.extend_from_slice(rest);
        });
        rows
    }

    /// The windows of an exemplar.
    pub fn of_exemplar(&self, exemplar: usize) -> Range<usize> {
        self.starts[exemplar] as usize..self.starts[exemplar + 1] as usize
    }

    pub fn index(&self) -> &InvertedIndex {
        &self.index
    }

    /// The index of a window's exemplar.
    pub fn exemplar(&self, window: usize) -> usize {
        self.starts.partition_point(|&start| start as usize <= window) - 1
    }

    pub(super) fn window(&self, window: usize) -> EncodedWindow<'_> {
        let rest = &self.rest[window * REST_LENGTH..][..REST_LENGTH];
        EncodedWindow {
            exemplar: self.exemplar(window) as u32,
            position: [[rest[0], rest[1]], [rest[2], rest[3]]].map(u16::from_le_bytes),
            level: rest[4],
            phases: &rest[5..],
        }
    }

    /// Memory that they take, in bytes, with the exemplars.
    pub fn bytes(&self) -> usize {
        // the codebook is that of the exemplars
        self.index.bytes() + self.rest.len() + size_of_val(&self.starts[..]) + self.exemplars.bytes()
            - self.exemplars.encoding.codebook.bytes()
    }
}
